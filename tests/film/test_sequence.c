// The sequence of paths, and whose path a slot holds.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "film/sequence.h"
#include "shared/rng.h"

// Takes batches of random sizes, counting how often each sample of each pixel comes, until `stop`
// paths are taken or the sequence ends. Counts are [spp_max][pixels] of the span.
static void take(struct sequence *sequence, uint8_t *counts, uint32_t spp_max, uint64_t stop,
                 uint32_t largest, uint32_t *seed)
{
    while (!sequence_ended(sequence) && sequence_paths(sequence) < stop) {
        const uint64_t left = stop - sequence_paths(sequence);
        const uint32_t size = 1 + rng_mix((*seed)++) % largest;
        const struct batch batch = sequence_batch(sequence, left < size ? (uint32_t)left : size);
        assert_in_range(batch.count, 1, size);
        for (uint32_t slot = 0; slot < batch.count; slot++) {
            const struct path_place place = batch_place(batch, slot);
            const struct span *span = &sequence->span;
            const uint32_t pixel = place.pixel - span->first_pixel;
            const uint32_t sample = place.sample - (uint32_t)span->first_sample;
            assert_in_range(pixel, 0, span->pixel_count - 1);
            assert_in_range(sample, 0, spp_max - 1);
            counts[(size_t)sample * span->pixel_count + pixel]++;
        }
        const uint64_t before = sequence_paths(sequence);
        sequence_advance(sequence, &batch);
        assert_int_equal(sequence_paths(sequence), before + batch.count);
    }
}

static void each_sample_comes_once_however_batches_are_cut(void **state)
{
    (void)state;
    const uint32_t pixel_counts[] = {1, 7, 64, 1000};
    const uint32_t spps[] = {1, 2, 3, 10, 13, 64, 100};
    uint32_t seed = 1;
    for (size_t p = 0; p < sizeof(pixel_counts) / sizeof(pixel_counts[0]); p++)
        for (size_t s = 0; s < sizeof(spps) / sizeof(spps[0]); s++)
            for (uint32_t largest = 1; largest < 100000; largest *= 17) {
                const uint32_t pixels = pixel_counts[p];
                const uint32_t spp = spps[s];
                uint8_t *counts = calloc((size_t)pixels * spp, 1);
                struct sequence sequence;
                const uint32_t first = seed % 5; // a span from the middle, at times
                const struct span span = {7 * first, pixels, first, first + spp, NULL};
                sequence_begin(&sequence, &span, seed % 2 == 0);
                take(&sequence, counts, spp, UINT64_MAX, largest, &seed);
                assert_int_equal(sequence_paths(&sequence), (uint64_t)pixels * spp);
                for (size_t i = 0; i < (size_t)pixels * spp; i++)
                    assert_int_equal(counts[i], 1);
                free(counts);
            }
}

static void samples_of_a_pixel_are_counted_and_even_at_any_time(void **state)
{
    (void)state;
    enum { PIXELS = 100, SPP_MAX = 80 };
    static uint8_t counts[SPP_MAX * PIXELS];
    uint32_t seed = 2;
    for (uint64_t stop = 0; stop < 40 * PIXELS; stop += 37) {
        struct sequence sequence;
        memset(counts, 0, sizeof(counts));
        const struct span span = {0, PIXELS, 0, UINT64_MAX, NULL};
        sequence_begin(&sequence, &span, true);
        take(&sequence, counts, SPP_MAX, stop, 300, &seed);
        uint64_t least = UINT64_MAX;
        uint64_t most = 0;
        for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
            uint64_t samples = 0;
            for (uint32_t sample = 0; sample < SPP_MAX; sample++)
                samples += counts[sample * PIXELS + pixel];
            assert_int_equal(samples, sequence_samples(&sequence, pixel));
            least = samples < least ? samples : least;
            most = samples > most ? samples : most;
        }
        assert_true(most <= 2 * least || most == 1);
    }
}

static void a_pass_of_a_huge_image_fits_32_bits(void **state)
{
    (void)state;
    const uint32_t pixels = 1u << 28;
    struct sequence sequence;
    const struct span span = {0, pixels, 0, 64, NULL};
    sequence_begin(&sequence, &span, true);
    for (int i = 0; i < 1000000 && !sequence_ended(&sequence); i++) {
        const struct batch batch = sequence_batch(&sequence, 1u << 21);
        assert_true((uint64_t)batch.first + batch.count <= UINT32_MAX);
        const struct path_place place = batch_place(batch, batch.count - 1);
        assert_true(place.pixel < pixels && place.sample < 64);
        sequence_advance(&sequence, &batch);
    }
    assert_int_equal(sequence_paths(&sequence), 64ull * pixels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_sample_comes_once_however_batches_are_cut),
        cmocka_unit_test(samples_of_a_pixel_are_counted_and_even_at_any_time),
        cmocka_unit_test(a_pass_of_a_huge_image_fits_32_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
