// The measures against values worked out by hand.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "output/compare.h"

#define TOLERANCE 1e-6 // of float inputs like 0.1

static void assert_close(double a, double b)
{
    if (!(fabs(a - b) <= TOLERANCE * fmax(1.0, fabs(b))))
        fail_msg("%.17g is not %.17g", a, b);
}

static void equal_images_have_no_difference(void **state)
{
    (void)state;
    const float image[6] = {0.0f, 0.5f, 1.0f, 2.0f, 3.0f, 4.0f};
    struct lk_comparison result;
    compare_images(&result, NULL, image, image, 2, 1);
    assert_true(result.variance == 0.0 && result.rmse == 0.0 && result.relative_mse == 0.0);
    assert_true(result.maximum == 0.0 && result.not_finite == 0);
    assert_true(isinf(result.psnr_db));
    assert_close(result.mean[0], 1.0);
    assert_close(result.reference_mean[2], 2.5);
}

static void measures_match_their_definitions(void **state)
{
    (void)state;
    const float reference[6] = {1.0f, 1.0f, 1.0f, 2.0f, 2.0f, 2.0f};
    const float image[6] = {1.0f, 1.5f, 1.0f, 2.0f, 2.0f, 1.0f};
    struct lk_comparison result;
    float difference[6];
    compare_images(&result, difference, image, reference, 2, 1);

    // Differences of 0.5 and 1 among two pixels, six values.
    assert_close(result.variance, 1.25 / 2.0);
    assert_close(result.rmse, sqrt(1.25 / 6.0));
    assert_close(result.relative_mse, (0.25 / 1.01 + 1.0 / 4.01) / 6.0);
    assert_close(result.psnr_db, 20.0 * log10(2.0 / sqrt(1.25 / 6.0)));
    assert_close(result.maximum, 1.0);
    assert_int_equal(result.maximum_x, 1);
    assert_int_equal(result.maximum_y, 0);
    assert_true(difference[0] == 0.0f && difference[1] == 0.5f && difference[5] == 1.0f);
}

static void values_that_are_not_finite_are_counted_and_left_out(void **state)
{
    (void)state;
    const float reference[6] = {1.0f, 1.0f, 1.0f, 1.0f, INFINITY, 1.0f};
    const float image[6] = {NAN, 2.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    struct lk_comparison result;
    float difference[6];
    compare_images(&result, difference, image, reference, 1, 2);
    assert_int_equal(result.not_finite, 2);
    assert_close(result.rmse, sqrt(1.0 / 4.0));
    assert_close(result.mean[0], 1.0);
    assert_close(result.mean[1], 2.0);
    assert_true(difference[0] == 0.0f && difference[4] == 0.0f);
}

static void largest_difference_is_found_by_row_and_column(void **state)
{
    (void)state;
    float reference[5 * 4 * 3] = {0};
    float image[5 * 4 * 3] = {0};
    image[(2 * 5 + 3) * 3 + 1] = -7.0f;
    struct lk_comparison result;
    compare_images(&result, NULL, image, reference, 5, 4);
    assert_close(result.maximum, 7.0);
    assert_int_equal(result.maximum_x, 3);
    assert_int_equal(result.maximum_y, 2);
}

static void noise_is_that_of_the_worst_tile_but_one_in_a_hundred(void **state)
{
    (void)state;
    enum { TILES = 200, TILE = 256 };
    static float reference[TILES * TILE * 3];
    static float image[TILES * TILE * 3];
    double noise = 0.0;
    for (int i = 0; i < TILES * TILE * 3; i++) {
        const int tile = i / (3 * TILE);
        reference[i] = 2.0f;
        image[i] = 2.0f + (tile < 2 ? 1.0f : tile < 10 ? 0.5f : 0.125f);
    }
    assert_int_equal(compare_noise(&noise, image, reference, TILES * TILE, 1), STATUS_OK);
    assert_close(noise, 0.25);
    image[6 * TILE] = NAN; // one of 768 values of a tile that does not count
    assert_int_equal(compare_noise(&noise, image, reference, TILES * TILE, 1), STATUS_OK);
    assert_close(noise, 0.25);
}

static void dark_tiles_are_measured_by_the_mean(void **state)
{
    (void)state;
    float reference[512 * 3];
    float image[512 * 3];
    double noise = 0.0;
    for (int i = 0; i < 512 * 3; i++) {
        reference[i] = i < 256 * 3 ? 1.0f : 0.0f;
        image[i] = i < 256 * 3 ? 1.0f : 0.01f;
    }
    assert_int_equal(compare_noise(&noise, image, reference, 512, 1), STATUS_OK);
    assert_true(fabs(noise - 0.01 / (0.1 * 0.5)) < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_images_have_no_difference),
        cmocka_unit_test(measures_match_their_definitions),
        cmocka_unit_test(values_that_are_not_finite_are_counted_and_left_out),
        cmocka_unit_test(noise_is_that_of_the_worst_tile_but_one_in_a_hundred),
        cmocka_unit_test(dark_tiles_are_measured_by_the_mean),
        cmocka_unit_test(largest_difference_is_found_by_row_and_column),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
