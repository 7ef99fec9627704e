// lib/traverse.h asked for any hit, one ray an item.

#include "lib/traverse.h"
#include "test.h"

TEST_KERNEL any_hit(BVH_NODES nodes, __global const struct woop *restrict woop,
                    __global const uint *restrict refs, __global const struct vertex *vertices,
                    __global const struct triangle *triangles,
                    __global const struct material *materials,
                    __global const struct ray *restrict rays, __global struct hit *restrict hits,
                    const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    struct surface surface;
    surface.vertices = vertices;
    surface.colors = 0;
    surface.triangles = triangles;
    surface.materials = materials;
    surface.texels = 0;
    hits[i] = traverse(nodes, woop, refs, &surface, rays[i].org_tmin.xyz, rays[i].dir_tmax.xyz,
                       rays[i].org_tmin.w, rays[i].dir_tmax.w, true);
}
