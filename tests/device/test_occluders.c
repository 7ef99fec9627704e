// Rays for any hit that remember what has stopped the last ones, against those that do not.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "trace_fixture.h"

#define SOUP  300u
#define BUNCH 12u // rays that run alike: one triangle stops most of them
_Static_assert(RAYS % BUNCH == 0, "rays come in whole bunches");

// Ways to ask for any hit: each item traces one ray, or many one after the other.
enum { ALONE, KEEPING, WAYS };

// The same tree and source, in both ways.
struct pair {
    enum tree tree;
    const char *source;
    struct variant ways[WAYS];
};

static struct fixture fixture;
static struct pair pairs[] = {
    {.tree = TREE_WIDE, .source = NULL},
    {.tree = TREE_WIDE_SPLIT, .source = NULL},
    {.tree = TREE_WIDE_SPLIT, .source = "trace_portable"},
};

#define PAIRS (sizeof(pairs) / sizeof(pairs[0]))

static int occluders_setup(void **state)
{
    if (device_setup(state) != 0)
        return -1;
    if (*state == NULL)
        return 0;
    fixture.gpu = *state;
    fixture.wavefront = make_wavefront(fixture.gpu, RAYS, 1);
    for (size_t i = 0; i < PAIRS; i++)
        for (int way = 0; way < WAYS; way++) {
            struct variant *variant = &pairs[i].ways[way];
            *variant = (struct variant){.tree = pairs[i].tree,
                                        .options = {.bvh_wide = true,
                                                    .alpha = true,
                                                    .any_hit = true,
                                                    .persistent = way == KEEPING},
                                        .source = pairs[i].source};
            build_variant(variant, fixture.gpu);
        }
    return 0;
}

static int occluders_teardown(void **state)
{
    if (*state != NULL) {
        for (size_t i = 0; i < PAIRS; i++)
            for (int way = 0; way < WAYS; way++)
                trace_free(&pairs[i].ways[way].trace);
        wavefront_free(fixture.gpu, &fixture.wavefront);
    }
    return device_teardown(state);
}

// Triangles with two sides along axes, 1 m, in stacks of WIDE_BLOCK far from each other: their
// leaves' boxes end where they do, and nothing else stops a ray that passes.
static struct geometry make_tiles(uint64_t seed, uint32_t count)
{
    struct geometry geometry = make_soup(seed, count, 50.0, 1.0);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t stack = i / WIDE_BLOCK;
        const float *a = corner_of(&geometry, stack * WIDE_BLOCK, 0);
        for (uint32_t corner = 0; corner < 3; corner++)
            for (uint32_t k = 0; k < 3; k++)
                corner_of(&geometry, i, (int)corner)[k] =
                    a[k] + (corner > 0 && k == (stack + corner) % 3 ? 1.0f : 0.0f);
    }
    return geometry;
}

// A ray beside another one, from the same place.
static struct ray deflect(const struct ray *ray, uint64_t *seed)
{
    const double off = pow(10.0, -1.0 - 7.0 * random_unit(seed));
    const double org[3] = {0.0, 0.0, 0.0};
    const double to[3] = {ray->dir.x + off * random_between(seed, -1.0, 1.0),
                          ray->dir.y + off * random_between(seed, -1.0, 1.0),
                          ray->dir.z + off * random_between(seed, -1.0, 1.0)};
    struct ray out = aim(org, to, 0);
    out.org = ray->org;
    out.dir.w = ray->dir.w;
    return out;
}

// Makes a bunch of rays of one kind.
static void make_bunch(struct ray *out, const struct geometry *geometry, enum ray_kind kind,
                       double reach, uint64_t *seed)
{
    out[0] = make_ray(geometry, kind, reach, seed);
    for (uint32_t i = 1; i < BUNCH; i++)
        out[i] = deflect(&out[0], seed);
}

// Makes a bunch towards one triangle: the first two go into it, the others along one of its edges,
// as near as float tells apart, where it is met or its box is, or both or none.
static void make_edge_bunch(struct ray *out, const struct geometry *geometry, double reach,
                            uint64_t *seed)
{
    double inside[3], a[3], b[3], org[3], to[3];
    pick_target(inside, a, b, geometry, seed);
    for (int k = 0; k < 3; k++)
        org[k] = inside[k] + random_between(seed, -reach, reach);
    for (uint32_t i = 0; i < BUNCH; i++) {
        const double along = random_unit(seed);
        const double off = reach * 0x1p-20 * random_unit(seed);
        for (int k = 0; k < 3; k++)
            to[k] = a[k] + along * (b[k] - a[k]) + off * random_between(seed, -1.0, 1.0);
        out[i] = aim(org, i < 2 ? inside : to, 0);
    }
}

static void make_bunches(struct ray *out, const struct geometry *geometry, double reach)
{
    uint64_t seed = 5;
    for (uint32_t i = 0; i < RAYS / BUNCH; i++)
        if (i % 2 == 0)
            make_bunch(&out[i * BUNCH], geometry, (enum ray_kind)(i / 2 % RAY_KINDS), reach, &seed);
        else
            make_edge_bunch(&out[i * BUNCH], geometry, reach, &seed);
}

// Traces the same rays in both ways, neighbours one after the other and in any order, and compares
// every answer. Takes the geometry over.
static void check_scene(struct geometry geometry, double reach)
{
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct ray rays[RAYS];
    struct hit alone[RAYS], keeping[RAYS];
    uint32_t queue[RAYS];
    uint64_t seed = 1;
    for (uint32_t i = 0; i < geometry.triangle_count; i++)
        geometry.triangles[i].material = i % MATERIALS;
    make_scene(scene, &fixture, geometry, 0.0f);
    make_bunches(rays, &scene->geometry, reach);
    for (size_t i = 0; i < PAIRS; i++) {
        for (uint32_t k = 0; k < RAYS; k++)
            queue[k] = k;
        run_variant(alone, &fixture, &pairs[i].ways[ALONE], scene, rays, queue, RAYS);
        for (int order = 0; order < 3; order++) {
            run_variant(keeping, &fixture, &pairs[i].ways[KEEPING], scene, rays, queue, RAYS);
            for (uint32_t k = 0; k < RAYS; k++)
                if (keeping[k].triangle != alone[k].triangle)
                    fail_msg("pair %zu, order %d: ray %u: %x, not %x", i, order, k,
                             keeping[k].triangle, alone[k].triangle);
            make_queue(queue, RAYS, RAYS, &seed);
        }
    }
    release_scene(scene, &fixture);
    free(scene);
}

// ---- laws

static void earlier_rays_change_no_answer(void **state)
{
    device_of(state);
    check_scene(make_soup(1, SOUP, 1.0, 0.3), 3.0);
    check_scene(make_soup(2, SOUP, 1.0, 2.0), 1.0);
    check_scene(make_soup(3, 20, 1.0, 1.0), 3.0);
}

static void earlier_rays_change_no_answer_along_edges(void **state)
{
    device_of(state);
    check_scene(make_slivers(1, SOUP), 3.0);
    check_scene(make_sizes(1, SOUP), 3.0);
    check_scene(make_walls(), 3.0);
    check_scene(make_tiles(1, SOUP), 1e3);
}

static void earlier_rays_change_no_answer_far_from_the_origin(void **state)
{
    device_of(state);
    struct geometry geometry = make_soup(4, SOUP, 30.0, 10.0);
    move_geometry(&geometry, 1e4f);
    check_scene(geometry, 60.0);
    geometry = make_slivers(2, SOUP);
    move_geometry(&geometry, 1e3f);
    check_scene(geometry, 3.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(earlier_rays_change_no_answer),
        cmocka_unit_test(earlier_rays_change_no_answer_along_edges),
        cmocka_unit_test(earlier_rays_change_no_answer_far_from_the_origin),
    };
    return cmocka_run_group_tests(tests, occluders_setup, occluders_teardown);
}
