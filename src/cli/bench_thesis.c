#include "cli/bench_thesis.h"

#include <stddef.h>
#include <string.h>

const unsigned thesis_depths[2] = {1, 5};
const unsigned thesis_shadow_rays[2] = {1, 4};

static const struct thesis_scene scenes[] = {
    {.name = "cornell",
     .thesis = "Cornell Box",
     .cameras = {"front", NULL},
     .views = {"Cornell Box", NULL},
     .triangles = 34e3,
     .area = 1,
     .bvh_mb = 0.5,
     .geometry_mb = 5.9,
     .material_mb = 4.4,
     .footprint_mb = 212.4,
     .mrays = {{{18.0, 34.0}, {11.5, 22.0}}, {{27.5, 47.0}, {17.0, 29.0}}},
     .traversal = {{39.8, 25.2}, {48.2, 31.9}},
     .lighting = {{24.6, 52.2}, {26.1, 51.1}},
     .others = {{35.7, 22.6}, {25.7, 17.0}},
     .faster_in_time = {-1, 0},
     .better_by_rays = {-1, 0}},
    {.name = "cathedral",
     .thesis = "Cathedral",
     .cameras = {"nave", "aisle"},
     .views = {"Cathedral 1", "Cathedral 2"},
     .triangles = 205e3,
     .point = 5,
     .bvh_mb = 2.9,
     .geometry_mb = 35.0,
     .material_mb = 162.3,
     .footprint_mb = 401.9,
     .mrays = {{{11.0, 15.0}, {6.5, 10.5}}, {{16.0, 19.2}, {8.5, 12.5}}},
     .traversal = {{27.9, 12.7}, {47.0, 27.0}},
     .lighting = {{49.0, 76.8}, {34.2, 62.1}},
     .others = {{23.1, 10.5}, {18.8, 10.9}},
     .faster_in_time = {1, 1},
     .better_by_rays = {1, -1}},
    {.name = "atrium",
     .thesis = "Sponza",
     .cameras = {"court", NULL},
     .views = {"Sponza", NULL},
     .triangles = 376e3,
     .directional = 1,
     .bvh_mb = 5.1,
     .geometry_mb = 54.8,
     .material_mb = 10.7,
     .footprint_mb = 272.4,
     .mrays = {{{12.0, 12.0}, {7.5, 7.2}}, {{18.0, 18.0}, {9.0, 9.0}}}},
    {.name = "deck",
     .thesis = "DMDeck",
     .cameras = {"hall", NULL},
     .views = {"DMDeck", NULL},
     .triangles = 1804e3,
     .point = 49,
     .directional = 1,
     .bvh_mb = 25.3,
     .geometry_mb = 262.2,
     .material_mb = 38.7,
     .footprint_mb = 528.0,
     .mrays = {{{10.0, 14.0}, {5.5, 9.0}}, {{14.5, 18.3}, {7.0, 11.0}}},
     .traversal = {{26.3, 14.0}, {44.7, 29.4}},
     .lighting = {{36.9, 66.6}, {26.1, 51.2}},
     .others = {{36.8, 19.4}, {29.2, 19.4}},
     .faster_in_time = {1, 0},
     .better_by_rays = {-1, 0}},
};

const struct thesis_scene *thesis_find(const char *name)
{
    for (size_t i = 0; i < sizeof(scenes) / sizeof(scenes[0]); i++)
        if (strcmp(scenes[i].name, name) == 0)
            return &scenes[i];
    return NULL;
}
