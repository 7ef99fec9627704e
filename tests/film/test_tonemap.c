// The display transform against closed forms and the laws of any tone curve.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "film/tonemap.h"

static const enum tonemap tonemaps[] = {TONEMAP_NONE, TONEMAP_REINHARD, TONEMAP_ACES};

static float apply_grey(float value, float exposure_ev, enum tonemap tonemap)
{
    const float rgb[3] = {value, value, value};
    float display[3];
    tonemap_apply(display, rgb, 1, exposure_ev, tonemap);
    return display[1];
}

static void assert_near(float a, float b, float tolerance)
{
    if (!(fabsf(a - b) <= tolerance))
        fail_msg("%g is not %g", (double)a, (double)b);
}

static void srgb_matches_the_standard(void **state)
{
    (void)state;
    assert_near(tonemap_srgb_encode(0.0f), 0.0f, 0.0f);
    assert_near(tonemap_srgb_encode(1.0f), 1.0f, 1e-6f);
    assert_near(tonemap_srgb_encode(0.0031308f), 0.04045f, 1e-5f);
    assert_near(tonemap_srgb_encode(0.2140411f), 0.5f, 1e-6f);
}

static void none_only_encodes(void **state)
{
    (void)state;
    for (int i = 0; i <= 100; i++) {
        const float x = (float)i / 100.0f;
        assert_near(apply_grey(x, 0.0f, TONEMAP_NONE), tonemap_srgb_encode(x), 0.0f);
    }
}

static void exposure_counts_in_stops(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        assert_near(apply_grey(0.1f, 1.0f, tonemaps[t]), apply_grey(0.2f, 0.0f, tonemaps[t]),
                    1e-6f);
        assert_near(apply_grey(0.4f, -2.0f, tonemaps[t]), apply_grey(0.1f, 0.0f, tonemaps[t]),
                    1e-6f);
    }
}

static void reinhard_is_x_over_1_plus_x(void **state)
{
    (void)state;
    assert_near(apply_grey(1.0f, 0.0f, TONEMAP_REINHARD), tonemap_srgb_encode(0.5f), 1e-6f);
    assert_near(apply_grey(3.0f, 0.0f, TONEMAP_REINHARD), tonemap_srgb_encode(0.75f), 1e-6f);
}

static void aces_keeps_grey_grey(void **state)
{
    (void)state;
    for (float x = 0.01f; x < 100.0f; x *= 1.5f) {
        const float rgb[3] = {x, x, x};
        float display[3];
        tonemap_apply(display, rgb, 1, 0.0f, TONEMAP_ACES);
        assert_near(display[0], display[1], 1e-3f);
        assert_near(display[2], display[1], 1e-3f);
    }
}

static void curves_rise_and_stay_within_0_and_1(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        float last = 0.0f;
        for (float x = 1e-6f; x < 1e30f; x *= 1.1f) {
            const float y = apply_grey(x, 0.0f, tonemaps[t]);
            assert_true(y >= last - 2e-6f && y <= 1.0f); // but for rounding
            last = y;
        }
        assert_near(last, 1.0f, 1e-3f);
    }
}

static void values_without_meaning_become_black_or_white(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        assert_near(apply_grey(0.0f, 0.0f, tonemaps[t]), 0.0f, 0.0f);
        assert_near(apply_grey(-1.0f, 0.0f, tonemaps[t]), 0.0f, 0.0f);
        assert_near(apply_grey(NAN, 0.0f, tonemaps[t]), 0.0f, 0.0f);
        assert_near(apply_grey(INFINITY, 0.0f, tonemaps[t]), 1.0f, 1e-3f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(srgb_matches_the_standard),
        cmocka_unit_test(none_only_encodes),
        cmocka_unit_test(exposure_counts_in_stops),
        cmocka_unit_test(reinhard_is_x_over_1_plus_x),
        cmocka_unit_test(aces_keeps_grey_grey),
        cmocka_unit_test(curves_rise_and_stay_within_0_and_1),
        cmocka_unit_test(values_without_meaning_become_black_or_white),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
