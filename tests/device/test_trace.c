// Every variant of the trace kernel against all triangles in double precision.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "trace_fixture.h"

#define SOUP 300u
#define MAX_OPEN                                                                                   \
    0.4            // part of the rays that may be undecided; the kinds that run along edges are 2/7
#define SIGMAS 6.0 // how far a frequency may be from its probability

static struct fixture fixture;

static int trace_setup(void **state)
{
    if (device_setup(state) != 0)
        return -1;
    if (*state != NULL)
        fixture = make_fixture(*state);
    return 0;
}

static int trace_teardown(void **state)
{
    if (*state != NULL)
        release_fixture(&fixture);
    return device_teardown(state);
}

// Rays, the order in which they are queued, and what they should hit.
struct job {
    struct ray rays[RAYS];
    uint32_t queue[RAYS];
    struct expectation expected[RAYS];
    bool *absent; // [triangle_count] cut out by alpha
};

static uint32_t octant(const struct ray *ray)
{
    return (ray->dir.x < 0.0f) + 2u * (ray->dir.y < 0.0f) + 4u * (ray->dir.z < 0.0f);
}

// Puts rays into one octant next to each other: packets trace those together.
static void gather_octants(uint32_t *queue, const struct ray *rays)
{
    uint32_t sorted[RAYS];
    uint32_t count = 0;
    for (uint32_t k = 0; k < 8; k++)
        for (uint32_t i = 0; i < RAYS; i++)
            if (octant(&rays[queue[i]]) == k)
                sorted[count++] = queue[i];
    memcpy(queue, sorted, sizeof(sorted));
}

static void make_job(struct job *out, const struct trace_scene *scene, double reach, bool masks)
{
    const struct geometry *geometry = &scene->geometry;
    uint64_t seed = 11;
    uint32_t open = 0;
    make_rays(out->rays, RAYS, geometry, reach, 12);
    make_queue(out->queue, RAYS, RAYS, &seed);
    gather_octants(out->queue, out->rays);
    out->absent = calloc(geometry->triangle_count + 1, sizeof(*out->absent));
    for (uint32_t i = 0; i < geometry->triangle_count; i++)
        out->absent[i] = masks && geometry->triangles[i].material == CUT_OUT;
    for (uint32_t i = 0; i < RAYS; i++) {
        out->expected[i] = oracle_expect(geometry, out->absent, &out->rays[i]);
        open += out->expected[i].open;
    }
    if (open > MAX_OPEN * RAYS)
        fail_msg("%u of %u rays are undecided", open, RAYS);
}

static void check_hit(const struct trace_scene *scene, const struct job *job, uint32_t i,
                      const struct hit *hit, const char *what)
{
    if (oracle_accepts(&scene->geometry, job->absent, &job->expected[i], &job->rays[i], hit))
        return;
    const struct ray *ray = &job->rays[i];
    fail_msg("%s, ray %u (kind %u) from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g): hit %d at "
             "%.9g, expected one before %.9g",
             what, i, i % RAY_KINDS, ray->org.x, ray->org.y, ray->org.z, ray->dir.x, ray->dir.y,
             ray->dir.z, (int)hit->triangle, hit->t, job->expected[i].limit);
}

// Any hit: one that may be, and none only where there need not be one.
static void check_any_hit(const struct trace_scene *scene, const struct job *job, enum tree tree)
{
    struct hit hits[RAYS];
    run_any_hit(hits, &fixture, scene, tree, job->rays);
    for (uint32_t i = 0; i < RAYS; i++) {
        struct expectation anywhere = job->expected[i];
        if (!isinf(anywhere.limit))
            anywhere.limit = DBL_MAX;
        const struct expectation *e = &anywhere;
        if (!oracle_accepts(&scene->geometry, job->absent, e, &job->rays[i], &hits[i]))
            check_hit(scene, job, i, &hits[i], "any hit");
    }
}

// Traces all kinds of rays by all variants. Takes the geometry over.
static void check_scene(struct geometry geometry, double reach, float split)
{
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct job *jobs = calloc(2, sizeof(*jobs)); // without and with alpha masks
    make_scene(scene, &fixture, geometry, split);
    for (int masks = 0; masks < 2; masks++)
        make_job(&jobs[masks], scene, reach, masks);
    for (uint32_t v = 0; v < fixture.variant_count; v++) {
        const struct variant *variant = &fixture.variants[v];
        const struct job *job = &jobs[variant->options.alpha];
        char what[32];
        struct hit hits[RAYS];
        snprintf(what, sizeof(what), "variant %u", v);
        run_variant(hits, &fixture, variant, scene, job->rays, job->queue, RAYS);
        for (uint32_t i = 0; i < RAYS; i++)
            check_hit(scene, job, i, &hits[i], what);
    }
    for (int tree = 0; tree < TREES; tree++)
        if (tree != TREE_TEXTURE)
            check_any_hit(scene, &jobs[1], tree);
    free(jobs[1].absent);
    free(jobs[0].absent);
    free(jobs);
    release_scene(scene, &fixture);
    free(scene);
}

// ---- laws

static void trace_agrees_on_random_triangles(void **state)
{
    device_of(state);
    check_scene(make_soup(1, SOUP, 1.0, 0.3), 3.0, 0.0f);
    check_scene(make_soup(2, SOUP, 1.0, 2.0), 1.0, 0.0f);
}

static void trace_agrees_on_few_triangles(void **state)
{
    device_of(state);
    static const uint32_t counts[] = {0, 1, 2, 7, 8, 9};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        check_scene(make_soup(3 + i, counts[i], 1.0, 0.8), 3.0, 0.0f);
}

static void trace_agrees_on_slivers_and_degenerate_triangles(void **state)
{
    device_of(state);
    check_scene(make_slivers(1, SOUP), 3.0, 0.0f);
}

static void trace_agrees_on_huge_and_tiny_triangles(void **state)
{
    device_of(state);
    check_scene(make_sizes(1, SOUP), 3.0, 0.0f);
    check_scene(make_sizes(2, SOUP), 100.0, 0.0f);
}

static void trace_agrees_on_walls_along_the_axes(void **state)
{
    device_of(state);
    check_scene(make_walls(), 3.0, 0.0f);
}

static void trace_agrees_far_from_the_origin(void **state)
{
    device_of(state);
    struct geometry geometry = make_soup(4, SOUP, 30.0, 10.0);
    move_geometry(&geometry, 1e4f);
    check_scene(geometry, 60.0, 0.0f);
}

static void trace_agrees_on_split_triangles(void **state)
{
    device_of(state);
    check_scene(make_soup(5, 100, 1.0, 2.0), 3.0, 1.0f);
    check_scene(make_walls(), 3.0, 0.5f);
}

static void cut_out_triangles_let_rays_by(void **state)
{
    device_of(state);
    struct geometry geometry = make_soup(6, SOUP, 1.0, 0.5);
    for (uint32_t i = 0; i < SOUP; i++)
        geometry.triangles[i].material = i % 3 == 0 ? CUT_OUT : SOLID;
    check_scene(geometry, 3.0, 0.0f);
}

// A scene in which every triangle is there twice, so that two are met at one distance.
static void make_twins(struct trace_scene *scene, struct job *job)
{
    struct geometry geometry = make_soup(9, SOUP, 1.0, 1.0);
    for (uint32_t i = 0; i + 1 < SOUP; i += 2) {
        geometry.triangles[i + 1] = geometry.triangles[i];
        geometry.triangles[i].material = geometry.triangles[i + 1].material = SOLID;
    }
    make_scene(scene, &fixture, geometry, 0.0f);
    make_job(job, scene, 3.0, false);
}

// Neither the layout nor the way to walk it changes a bit of a hit; the wide BVH of CPUs rounds
// otherwise.
static void layouts_of_gpus_have_the_same_hits(void **state)
{
    device_of(state);
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct job *job = calloc(1, sizeof(*job));
    struct hit hits[2][RAYS];
    make_twins(scene, job);
    run_variant(hits[0], &fixture, &fixture.variants[0], scene, job->rays, job->queue, RAYS);
    for (uint32_t v = 1; v < fixture.variant_count; v++) {
        if (is_wide(fixture.variants[v].tree))
            continue;
        run_variant(hits[1], &fixture, &fixture.variants[v], scene, job->rays, job->queue, RAYS);
        for (uint32_t i = 0; i < RAYS; i++)
            if (!job->expected[i].open) // else a slab may cut off the end of a triangle
                assert_memory_equal(&hits[0][i], &hits[1][i], sizeof(hits[0][i]));
    }
    free(job->absent);
    free(job);
    release_scene(scene, &fixture);
    free(scene);
}

// The bits of a hit do not depend on the rays beside it, not even where two triangles are met at
// one distance.
static void neighbours_in_a_packet_do_not_matter(void **state)
{
    device_of(state);
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct job *job = calloc(1, sizeof(*job));
    struct hit hits[2][RAYS];
    make_twins(scene, job);
    for (uint32_t v = 0; v < fixture.variant_count; v++) {
        if (!fixture.variants[v].packets)
            continue;
        uint64_t seed = 1;
        uint32_t queue[RAYS];
        run_variant(hits[0], &fixture, &fixture.variants[v], scene, job->rays, job->queue, RAYS);
        for (int k = 0; k < 4; k++) {
            make_queue(queue, RAYS, RAYS, &seed);
            run_variant(hits[1], &fixture, &fixture.variants[v], scene, job->rays, queue, RAYS);
            assert_memory_equal(hits[0], hits[1], sizeof(hits[0]));
        }
    }
    free(job->absent);
    free(job);
    release_scene(scene, &fixture);
    free(scene);
}

// Splitting changes what is visited, not what is hit.
static void splitting_changes_no_hit(void **state)
{
    device_of(state);
    struct trace_scene *scenes = calloc(2, sizeof(*scenes));
    struct job *job = calloc(1, sizeof(*job));
    struct hit hits[2][RAYS];
    make_scene(&scenes[0], &fixture, make_soup(7, 200, 1.0, 2.0), 0.0f);
    make_scene(&scenes[1], &fixture, make_soup(7, 200, 1.0, 2.0), 0.7f);
    assert_true(scenes[1].ref_count > 2 * scenes[0].ref_count);
    make_job(job, &scenes[0], 3.0, false);
    for (int i = 0; i < 2; i++)
        run_variant(hits[i], &fixture, &fixture.variants[0], &scenes[i], job->rays, job->queue,
                    RAYS);
    for (uint32_t i = 0; i < RAYS; i++)
        if (!job->expected[i].open)
            assert_memory_equal(&hits[0][i], &hits[1][i], sizeof(hits[0][i]));
    free(job->absent);
    free(job);
    for (int i = 0; i < 2; i++)
        release_scene(&scenes[i], &fixture);
    free(scenes);
}

// Which rays meet it is the same for every variant, and for any hit.
static void a_blended_triangle_meets_its_share_of_rays(void **state)
{
    device_of(state);
    static const float corners[9] = {-1e3f, -1e3f, 0.0f, 1e3f, -1e3f, 0.0f, 0.0f, 1e3f, 0.0f};
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct job *job = calloc(1, sizeof(*job));
    struct hit any[RAYS];
    struct hit hits[RAYS];
    struct geometry geometry = make_geometry(corners, 1);
    geometry.triangles[0].material = BLENDED;
    make_scene(scene, &fixture, geometry, 0.0f);
    make_job(job, scene, 3.0, false);
    for (uint32_t i = 0; i < RAYS; i++) {
        job->rays[i].org = (float4){0.37f * (float)(i % 64), 0.0f, 1.0f + (float)i, 0.0f};
        job->rays[i].dir = (float4){0.0f, 0.0f, -1.0f, FLT_MAX};
    }
    run_any_hit(any, &fixture, scene, TREE_BINARY, job->rays);
    uint32_t met = 0;
    for (uint32_t i = 0; i < RAYS; i++)
        met += any[i].triangle == 0;
    assert_close((double)met / RAYS, BLENDED_ALPHA,
                 SIGMAS * sqrt(BLENDED_ALPHA * (1.0 - BLENDED_ALPHA) / RAYS));
    for (uint32_t v = 0; v < fixture.variant_count; v++) {
        const struct variant *variant = &fixture.variants[v];
        run_variant(hits, &fixture, variant, scene, job->rays, job->queue, RAYS);
        for (uint32_t i = 0; i < RAYS; i++)
            assert_int_equal(hits[i].triangle, variant->options.alpha ? any[i].triangle : 0);
    }
    free(job->absent);
    free(job);
    release_scene(scene, &fixture);
    free(scene);
}

static void check_queues(uint32_t triangle_count)
{
    static const uint32_t counts[] = {0, 1, 2, 15, 16, 17, 31, 32, 33, 63, 64, 65, 1000, RAYS};
    struct trace_scene *scene = calloc(1, sizeof(*scene));
    struct job *job = calloc(1, sizeof(*job));
    struct hit all[RAYS];
    struct hit hits[RAYS];
    make_scene(scene, &fixture, make_soup(8, triangle_count, 1.0, 0.5), 0.0f);
    make_job(job, scene, 3.0, false);
    for (uint32_t v = 0; v < fixture.variant_count; v++) {
        const struct variant *variant = &fixture.variants[v];
        run_variant(all, &fixture, variant, scene, job->rays, job->queue, RAYS);
        for (size_t k = 0; k < sizeof(counts) / sizeof(counts[0]); k++) {
            run_variant(hits, &fixture, variant, scene, job->rays, job->queue, counts[k]);
            for (uint32_t i = 0; i < RAYS; i++) {
                const uint32_t slot = job->queue[i];
                if (i < counts[k])
                    assert_memory_equal(&hits[slot], &all[slot], sizeof(all[slot]));
                else
                    assert_int_equal(hits[slot].triangle, UNTOUCHED);
            }
        }
    }
    free(job->absent);
    free(job);
    release_scene(scene, &fixture);
    free(scene);
}

static void every_queued_ray_is_traced_and_no_other(void **state)
{
    device_of(state);
    check_queues(SOUP);
    check_queues(20); // few enough to be met side by side
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trace_agrees_on_random_triangles),
        cmocka_unit_test(trace_agrees_on_few_triangles),
        cmocka_unit_test(trace_agrees_on_slivers_and_degenerate_triangles),
        cmocka_unit_test(trace_agrees_on_huge_and_tiny_triangles),
        cmocka_unit_test(trace_agrees_on_walls_along_the_axes),
        cmocka_unit_test(trace_agrees_far_from_the_origin),
        cmocka_unit_test(trace_agrees_on_split_triangles),
        cmocka_unit_test(cut_out_triangles_let_rays_by),
        cmocka_unit_test(layouts_of_gpus_have_the_same_hits),
        cmocka_unit_test(neighbours_in_a_packet_do_not_matter),
        cmocka_unit_test(splitting_changes_no_hit),
        cmocka_unit_test(a_blended_triangle_meets_its_share_of_rays),
        cmocka_unit_test(every_queued_ray_is_traced_and_no_other),
    };
    return cmocka_run_group_tests(tests, trace_setup, trace_teardown);
}
