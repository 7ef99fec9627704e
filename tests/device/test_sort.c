// The sort stage against a stable sort on the host.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "shared/geometry.h"
#include "shared/ray.h"
#include "stage_support.h"

#define CAPACITY      300000u
#define MAX_MATERIALS 1000u
#define TRIANGLES     (3 * MAX_MATERIALS)
#define GUARD         64u // places behind the queue's that have to stay as they were
#define SENTINEL      0xdeadbeefu

struct fixture {
    struct gpu *gpu;
    struct sort sort;
    struct wavefront wavefront;
    struct hit *hits;         // [CAPACITY]
    struct path *paths;       // [CAPACITY]
    uint32_t *queue, *result; // [CAPACITY]
    uint64_t seed;
};

static void make_fixture(struct fixture *out, struct gpu *gpu)
{
    static const struct program_options options;
    uint32_t built = 0;
    *out = (struct fixture){.gpu = gpu, .seed = 1};
    assert_ok(sort_build(&out->sort, gpu, &options, &built));
    out->wavefront = make_wavefront(gpu, CAPACITY, MAX_MATERIALS);
    out->hits = malloc(CAPACITY * sizeof(*out->hits));
    out->paths = calloc(CAPACITY, sizeof(*out->paths));
    out->queue = malloc(CAPACITY * sizeof(*out->queue));
    out->result = malloc(CAPACITY * sizeof(*out->result));
}

static void release(struct fixture *f)
{
    free(f->result);
    free(f->queue);
    free(f->paths);
    free(f->hits);
    wavefront_free(f->gpu, &f->wavefront);
    sort_free(&f->sort);
}

// One sort to be checked.
struct round {
    uint32_t count, material_count, bounce;
    double misses; // part of the rays
    double skew;   // exponent: 1 spreads the hits evenly, more prefers the first materials
};

// The material that a triangle of the test has.
static uint32_t material_of(uint32_t triangle, uint32_t material_count)
{
    return (triangle * 7919u) % material_count;
}

// Sorts on the host: counts each key, then places in order. ranges has material_count + 2 places.
static void sort_naively(uint32_t *order, uint32_t *ranges, const struct fixture *f,
                         const struct round *round)
{
    uint32_t place = 0;
    for (uint32_t key = 0; key <= round->material_count; key++) {
        ranges[key] = place;
        for (uint32_t i = 0; i < round->count; i++) {
            const uint32_t triangle = f->hits[f->queue[i]].triangle;
            const uint32_t mine = triangle == HIT_NONE
                                      ? round->material_count
                                      : material_of(triangle, round->material_count);
            if (mine == key)
                order[place++] = f->queue[i];
        }
    }
    ranges[round->material_count + 1] = SENTINEL;
}

// Random hits of slots in use; slots out of use must not be looked at, and would show.
static void fill_hits(struct fixture *f, const struct round *round)
{
    for (uint32_t i = 0; i < CAPACITY; i++)
        f->hits[i] = (struct hit){.triangle = 0x7fffffffu};
    for (uint32_t i = 0; i < round->count; i++) {
        const double u = pow(random_unit(&f->seed), round->skew);
        f->hits[f->queue[i]].triangle =
            random_unit(&f->seed) < round->misses ? HIT_NONE : (uint32_t)(u * TRIANGLES);
    }
}

static void upload_round(struct fixture *f, struct device_scene *scene, const struct round *round)
{
    const struct wavefront *w = &f->wavefront;
    struct triangle triangles[TRIANGLES];
    for (uint32_t i = 0; i < TRIANGLES; i++)
        triangles[i] = (struct triangle){.material = material_of(i, round->material_count)};
    scene->triangles = device_buffer(f->gpu, triangles, sizeof(triangles));
    scene->material_count = round->material_count;
    make_queue(f->queue, round->count, CAPACITY, &f->seed);
    fill_hits(f, round);
    for (uint32_t i = 0; i < CAPACITY; i++) {
        f->result[i] = SENTINEL;
        f->paths[i].throughput_bits.w = bits_float(SENTINEL);
    }
    assert_ok(buffer_write(f->gpu, &w->queue[round->bounce & 1], f->queue,
                           round->count * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->hits, f->hits, CAPACITY * sizeof(*f->hits)));
    assert_ok(buffer_write(f->gpu, &w->paths, f->paths, CAPACITY * sizeof(*f->paths)));
    assert_ok(buffer_write(f->gpu, &w->slots[0], f->result, CAPACITY * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->ranges, f->result, (MAX_MATERIALS + 2) * sizeof(uint32_t)));
    write_counters(f->gpu, w, round->bounce, round->count);
}

// The paths in use that have missed have ended; no other has been touched.
static void check_ends(struct fixture *f, const struct round *round)
{
    assert_ok(buffer_read(f->gpu, &f->wavefront.paths, f->paths, CAPACITY * sizeof(*f->paths)));
    uint32_t misses = 0;
    for (uint32_t i = 0; i < round->count; i++) {
        const uint32_t slot = f->queue[i];
        const bool missed = f->hits[slot].triangle == HIT_NONE;
        misses += missed;
        assert_int_equal(float_bits(f->paths[slot].throughput_bits.w), missed ? 0 : SENTINEL);
    }
    uint32_t ended = 0;
    for (uint32_t i = 0; i < CAPACITY; i++)
        ended += float_bits(f->paths[i].throughput_bits.w) != SENTINEL;
    assert_int_equal(ended, misses);
}

static void check_round(struct fixture *f, const struct round *round)
{
    struct device_scene scene = {0};
    upload_round(f, &scene, round);
    const struct stage_context context = {
        .gpu = f->gpu, .scene = &scene, .wavefront = &f->wavefront, .bounce = round->bounce};
    assert_ok(sort_enqueue(&f->sort, &context));

    check_ends(f, round);
    uint32_t expected_ranges[MAX_MATERIALS + 2];
    uint32_t ranges[MAX_MATERIALS + 2];
    uint32_t *expected = malloc((round->count + 1) * sizeof(*expected));
    sort_naively(expected, expected_ranges, f, round);
    assert_ok(buffer_read(f->gpu, &f->wavefront.slots[0], f->result, CAPACITY * sizeof(uint32_t)));
    assert_ok(buffer_read(f->gpu, &f->wavefront.ranges, ranges, sizeof(ranges)));
    assert_memory_equal(f->result, expected, round->count * sizeof(uint32_t));
    for (uint32_t i = round->count; i < round->count + GUARD && i < CAPACITY; i++)
        assert_int_equal(f->result[i], SENTINEL);
    assert_memory_equal(ranges, expected_ranges, (round->material_count + 2) * sizeof(uint32_t));
    free(expected);
    buffer_free(f->gpu, &scene.triangles);
}

static void sort_agrees_at_every_count(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    static const uint32_t counts[] = {0,    1,    2,    15,   16,   17,   255,   256,   257,
                                      1023, 1024, 1025, 2048, 2049, 5000, 16384, 16385, 40000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        check_round(&f, &(struct round){counts[i], 10, i & 1, 0.2, 1.0});
    release(&f);
}

static void sort_agrees_at_every_material_count(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    static const uint32_t materials[] = {1, 2, 14, 15, 16, 17, 254, 255, 256, 257, 1000};
    for (size_t i = 0; i < sizeof(materials) / sizeof(materials[0]); i++)
        check_round(&f, &(struct round){3000, materials[i], i & 1, 0.1, 1.0});
    release(&f);
}

static void sort_agrees_when_all_is_one(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    check_round(&f, &(struct round){5000, 1, 0, 0.0, 1.0});
    check_round(&f, &(struct round){5000, 20, 0, 1.0, 1.0});
    check_round(&f, &(struct round){5000, 300, 1, 0.5, 1000.0}); // nearly all of one material
    release(&f);
}

static void sort_agrees_on_long_queues(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    check_round(&f, &(struct round){CAPACITY, 17, 0, 0.3, 2.0});
    check_round(&f, &(struct round){CAPACITY - 1, 300, 1, 0.01, 1.0});
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sort_agrees_at_every_count),
        cmocka_unit_test(sort_agrees_at_every_material_count),
        cmocka_unit_test(sort_agrees_when_all_is_one),
        cmocka_unit_test(sort_agrees_on_long_queues),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
