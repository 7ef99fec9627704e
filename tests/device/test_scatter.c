// The scatter stage against a loop: it sends the right paths on, all of them, each once.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "shared/oct.h"
#include "shared/path.h"
#include "shared/ray.h"
#include "stage_support.h"

#define CAPACITY 300000u
#define SENTINEL 0xdeadbeefu

struct fixture {
    struct gpu *gpu;
    struct scatter scatter;
    bool by_items; // an item takes one path, on CPUs as well
    struct wavefront wavefront;
    struct path *paths;     // [CAPACITY]
    uint32_t *queue;        // [CAPACITY]
    uint32_t *result;       // [CAPACITY]
    uint8_t *goes, *is_new; // [CAPACITY] whether a path goes on, and is yet to be found
    uint64_t seed;
};

// Hits of white surfaces that look up.
static void upload_hits(const struct fixture *f)
{
    struct ray *rays = calloc(CAPACITY, sizeof(*rays));
    struct shade *shades = calloc(CAPACITY, sizeof(*shades));
    for (uint32_t i = 0; i < CAPACITY; i++) {
        rays[i].org.w = bits_float(oct_pack(0.0f, 1.0f, 0.0f));
        rays[i].dir.y = -1.0f;
        shades[i].diffuse_f0 = (uint2){.x = 0xffffffffu, .y = 0xffffu};
    }
    assert_ok(buffer_write(f->gpu, &f->wavefront.rays, rays, CAPACITY * sizeof(*rays)));
    assert_ok(buffer_write(f->gpu, &f->wavefront.hits, shades, CAPACITY * sizeof(*shades)));
    free(shades);
    free(rays);
}

static void make_fixture(struct fixture *out, struct gpu *gpu, bool by_items)
{
    static const struct program_options options;
    uint32_t built = 0;
    *out = (struct fixture){.gpu = gpu, .by_items = by_items, .seed = 1};
    if (by_items) {
        struct program program = device_program(gpu, "scatter_portable", &options);
        assert_ok(kernel_create(&out->scatter.kernel, gpu, &program, "scatter"));
        program_free(&program);
    } else {
        assert_ok(scatter_build(&out->scatter, gpu, &options, &built));
    }
    out->wavefront = make_wavefront(gpu, CAPACITY, 1);
    out->paths = calloc(CAPACITY, sizeof(*out->paths));
    out->queue = calloc(CAPACITY, sizeof(*out->queue));
    out->result = calloc(CAPACITY, sizeof(*out->result));
    out->goes = calloc(CAPACITY, sizeof(*out->goes));
    out->is_new = calloc(CAPACITY, sizeof(*out->is_new));
}

static void release(struct fixture *f)
{
    free(f->is_new);
    free(f->goes);
    free(f->result);
    free(f->queue);
    free(f->paths);
    wavefront_free(f->gpu, &f->wavefront);
    scatter_free(&f->scatter);
}

// Makes paths of which a share goes on; the others have met nothing, or are at their last hit, or
// have no weight left.
static void make_paths(struct fixture *f, double kept)
{
    for (uint32_t i = 0; i < CAPACITY; i++) {
        const uint32_t why = (uint32_t)(random_unit(&f->seed) * 3.0); // it ends
        f->goes[i] = random_unit(&f->seed) < kept;
        const bool ends = !f->goes[i];
        const uint32_t flags =
            (ends && why == 0 ? 0u : PATH_SHADED) | (ends && why == 1 ? PATH_NO_BOUNCE : 0u);
        const float weight = ends && why == 2 ? 0.0f : 1.0f;
        f->paths[i].throughput_bits = (float4){weight, weight, weight, bits_float(flags)};
        f->paths[i].radiance_normal.w = bits_float(oct_pack(0.0f, 1.0f, 0.0f));
        f->result[i] = SENTINEL;
    }
}

static void upload_round(struct fixture *f, uint32_t count, uint32_t bounce)
{
    const struct wavefront *w = &f->wavefront;
    upload_hits(f);
    assert_ok(buffer_write(f->gpu, &w->queue[bounce & 1], f->queue, count * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->queue[~bounce & 1], f->result, CAPACITY * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->paths, f->paths, CAPACITY * sizeof(*f->paths)));
    write_counters(f->gpu, w, bounce, count);
}

// What is in the next queue is what goes on, each once, and nothing is written behind it.
static void check_queue(struct fixture *f, uint32_t count, uint32_t bounce)
{
    struct counters counters[4];
    assert_int_equal(f->wavefront.bounce_count, 4);
    assert_ok(buffer_read(f->gpu, &f->wavefront.counters, counters, sizeof(counters)));
    assert_ok(buffer_read(f->gpu, &f->wavefront.queue[~bounce & 1], f->result,
                          CAPACITY * sizeof(uint32_t)));
    uint32_t expected = 0;
    for (uint32_t i = 0; i < count; i++) {
        f->is_new[f->queue[i]] = f->goes[f->queue[i]];
        expected += f->goes[f->queue[i]];
    }
    assert_int_equal(counters[bounce].active, count);
    assert_int_equal(counters[bounce + 1].active, expected);
    for (uint32_t i = 0; i < expected; i++) {
        assert_true(f->result[i] < CAPACITY && f->is_new[f->result[i]]);
        f->is_new[f->result[i]] = 0;
    }
    for (uint32_t i = expected; i < CAPACITY; i++)
        assert_int_equal(f->result[i], SENTINEL);
}

// Paths say themselves whether they go on; those that are not in the queue stay as they were.
static void check_paths(struct fixture *f, uint32_t count)
{
    struct path *after = calloc(CAPACITY, sizeof(*after));
    assert_ok(buffer_read(f->gpu, &f->wavefront.paths, after, CAPACITY * sizeof(*after)));
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t slot = f->queue[i];
        const uint32_t flags = float_bits(after[slot].throughput_bits.w);
        assert_int_equal(flags & PATH_ALIVE, f->goes[slot] ? PATH_ALIVE : 0u);
        after[slot].throughput_bits = f->paths[slot].throughput_bits;
    }
    assert_memory_equal(after, f->paths, CAPACITY * sizeof(*after));
    free(after);
}

static void check_round(struct fixture *f, uint32_t count, uint32_t bounce, double kept)
{
    make_queue(f->queue, count, CAPACITY, &f->seed);
    make_paths(f, kept);
    upload_round(f, count, bounce);
    const struct device_scene scene = {0};
    // On CPUs the stage launches an item for each run of paths.
    const uint32_t items = f->by_items && f->gpu->info.is_cpu ? count * PATH_RUN : count;
    const struct stage_context context = {.gpu = f->gpu,
                                          .scene = &scene,
                                          .wavefront = &f->wavefront,
                                          .batch = {.count = items, .pixel_count = 1},
                                          .bounce = bounce};
    assert_ok(scatter_enqueue(&f->scatter, &context));
    check_queue(f, count, bounce);
    check_paths(f, count);
}

static void check_counts(struct gpu *gpu, bool by_items)
{
    struct fixture f;
    make_fixture(&f, gpu, by_items);
    static const uint32_t counts[] = {0,    1,    2,    15,   16,   17,    255,   256,  257,
                                      1023, 1024, 1025, 2048, 2049, 16384, 16385, 40000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        check_round(&f, counts[i], i & 1, 0.6);
    release(&f);
}

static void check_shares(struct gpu *gpu, bool by_items)
{
    struct fixture f;
    make_fixture(&f, gpu, by_items);
    check_round(&f, 10000, 0, 0.0);
    check_round(&f, 10000, 1, 1.0);
    check_round(&f, 10000, 0, 0.001);
    check_round(&f, 10000, 1, 0.999);
    check_round(&f, CAPACITY, 0, 0.5);
    check_round(&f, CAPACITY - 1, 1, 0.9);
    release(&f);
}

static void scatter_agrees_at_every_count(void **state)
{
    check_counts(device_of(state), false);
}

static void scatter_agrees_on_any_share(void **state)
{
    check_shares(device_of(state), false);
}

static void single_items_agree_at_every_count(void **state)
{
    check_counts(device_of(state), true);
}

static void single_items_agree_on_any_share(void **state)
{
    check_shares(device_of(state), true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scatter_agrees_at_every_count),
        cmocka_unit_test(scatter_agrees_on_any_share),
        cmocka_unit_test(single_items_agree_at_every_count),
        cmocka_unit_test(single_items_agree_on_any_share),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
