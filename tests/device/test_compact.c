// The compact stage against a loop: it keeps the right paths, all of them, in their order.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "shared/path.h"
#include "stage_support.h"

#define CAPACITY 300000u
#define SENTINEL 0xdeadbeefu

struct fixture {
    struct gpu *gpu;
    struct compact compact;
    struct wavefront wavefront;
    struct path *paths;       // [CAPACITY]
    uint32_t *queue, *result; // [CAPACITY]
    uint64_t seed;
};

static void make_fixture(struct fixture *out, struct gpu *gpu)
{
    static const struct program_options options;
    uint32_t built = 0;
    *out = (struct fixture){.gpu = gpu, .seed = 1};
    assert_ok(compact_build(&out->compact, gpu, &options, &built));
    out->wavefront = make_wavefront(gpu, CAPACITY, 1);
    out->paths = calloc(CAPACITY, sizeof(*out->paths));
    out->queue = calloc(CAPACITY, sizeof(*out->queue));
    out->result = calloc(CAPACITY, sizeof(*out->result));
}

static void release(struct fixture *f)
{
    free(f->result);
    free(f->queue);
    free(f->paths);
    wavefront_free(f->gpu, &f->wavefront);
    compact_free(&f->compact);
}

static int goes_on(const struct fixture *f, uint32_t slot)
{
    return (float_bits(f->paths[slot].throughput_bits.w) & PATH_ALIVE) != 0;
}

static void upload_round(struct fixture *f, uint32_t count, uint32_t bounce, double kept)
{
    const struct wavefront *w = &f->wavefront;
    make_queue(f->queue, count, CAPACITY, &f->seed);
    for (uint32_t i = 0; i < CAPACITY; i++) {
        const bool keep = random_unit(&f->seed) < kept;
        const uint32_t other = (uint32_t)(random_unit(&f->seed) * 4.0) << 1; // other flags
        f->paths[i].throughput_bits.w = bits_float((keep ? PATH_ALIVE : 0u) | other);
        f->result[i] = SENTINEL;
    }
    assert_ok(buffer_write(f->gpu, &w->queue[bounce & 1], f->queue, count * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->queue[~bounce & 1], f->result, CAPACITY * sizeof(uint32_t)));
    assert_ok(buffer_write(f->gpu, &w->paths, f->paths, CAPACITY * sizeof(*f->paths)));
    write_counters(f->gpu, w, bounce, count);
}

static void check_round(struct fixture *f, uint32_t count, uint32_t bounce, double kept)
{
    upload_round(f, count, bounce, kept);
    const struct device_scene scene = {0};
    const struct stage_context context = {
        .gpu = f->gpu, .scene = &scene, .wavefront = &f->wavefront, .bounce = bounce};
    assert_ok(compact_enqueue(&f->compact, &context));

    struct counters counters[3];
    assert_int_equal(f->wavefront.bounce_count, 3);
    assert_ok(buffer_read(f->gpu, &f->wavefront.counters, counters, sizeof(counters)));
    assert_ok(buffer_read(f->gpu, &f->wavefront.queue[~bounce & 1], f->result,
                          CAPACITY * sizeof(uint32_t)));
    uint32_t place = 0;
    for (uint32_t i = 0; i < count; i++)
        if (goes_on(f, f->queue[i]))
            assert_int_equal(f->result[place++], f->queue[i]);
    assert_int_equal(counters[bounce].active, count);
    assert_int_equal(counters[bounce + 1].active, place);
    for (uint32_t i = place; i < CAPACITY; i++)
        assert_int_equal(f->result[i], SENTINEL);
}

static void compact_agrees_at_every_count(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    static const uint32_t counts[] = {0,    1,    2,    15,   16,   17,    255,   256,  257,
                                      1023, 1024, 1025, 2048, 2049, 16384, 16385, 40000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        check_round(&f, counts[i], i & 1, 0.6);
    release(&f);
}

static void compact_agrees_on_any_share(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    check_round(&f, 10000, 0, 0.0);
    check_round(&f, 10000, 1, 1.0);
    check_round(&f, 10000, 0, 0.001);
    check_round(&f, 10000, 1, 0.999);
    release(&f);
}

static void compact_agrees_on_long_queues(void **state)
{
    struct fixture f;
    make_fixture(&f, device_of(state));
    check_round(&f, CAPACITY, 0, 0.5);
    check_round(&f, CAPACITY - 1, 1, 0.9);
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compact_agrees_at_every_count),
        cmocka_unit_test(compact_agrees_on_any_share),
        cmocka_unit_test(compact_agrees_on_long_queues),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
