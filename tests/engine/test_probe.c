// The start-up probe: what does not work is struck out, and leaves no trace in the picture.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "core/log.h"
#include "probe_fixture.h"

// Renders with a candidate that does not work, and asserts that it is struck out, with a warning
// and without a trace in the picture.
static void check_spoilt(const char *more)
{
    const struct lk_settings settings = open_settings();
    const struct lk_settings plain = settings_of(LK_TRACE_SIMPLE, LK_BVH_BINARY);
    const struct form spoilt[] = {sound[0], {LK_TRACE_PERSISTENT, LK_BVH_QUAD, BOTH, more}};
    choice_candidates = spoilt;
    choice_candidate_count = 2;
    const unsigned before = log_warning_count();
    struct lk_image *image = render(scene, &settings);
    assert_true(log_warning_count() > before);
    for (int i = 0; i < LK_RAYS_COUNT; i++) {
        const struct lk_tracing *tracing = &share_of(image)->tracing[i];
        assert_false(tracing->trace == LK_TRACE_PERSISTENT && tracing->bvh == LK_BVH_QUAD);
    }
    if (share_of(image)->tracing[0].bvh == LK_BVH_BINARY) {
        struct lk_image *expected = render(scene, &plain);
        assert_int_equal(lk_image_info(expected)->rays_camera, lk_image_info(image)->rays_camera);
        lk_image_free(expected);
    }
    lk_image_free(image);
}

// ---- laws

static void what_does_not_compile_is_struck_out(void **state)
{
    (void)state;
    skip_without_device();
    check_spoilt("-D WG_TRACE=none");
}

static void what_finds_other_hits_is_struck_out(void **state)
{
    (void)state;
    skip_without_device();
    check_spoilt("-D ANY_HIT=1"); // another -D before it says 0
}

// Of two forms for shadow rays that do not agree, neither the plain one, none can be told right.
static void shadows_that_do_not_agree_are_traced_plainly(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = open_settings();
    settings.light_sampler = LK_LIGHTS_ALL;
    const struct form forms[] = {
        {LK_TRACE_SIMPLE, LK_BVH_BINARY, FORM_TRACES, NULL},
        {LK_TRACE_PERSISTENT, LK_BVH_BINARY, FORM_SHADOWS, NULL},
        {LK_TRACE_PERSISTENT, LK_BVH_QUAD, FORM_SHADOWS, "-D LIGHT_SAMPLER=2"},
    };
    choice_candidates = forms;
    choice_candidate_count = 3;
    const unsigned before = log_warning_count();
    struct lk_image *image = render(scene, &settings);
    assert_true(log_warning_count() >= before + 2);
    const struct lk_tracing *tracing = &share_of(image)->tracing[LK_RAYS_SHADOW];
    assert_true(tracing->trace != LK_TRACE_PERSISTENT || tracing->bvh == LK_BVH_WIDE);
    lk_image_free(image);
}

static void what_takes_too_long_is_struck_out(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    char path[PATH_SIZE];
    probe_limits = (struct probe_limits){.all = 1.0, .launch = 0.0, .grace = 120.0};
    const unsigned before = log_warning_count();
    struct lk_image *image = render(scene, &settings);
    assert_true(log_warning_count() > before);
    for (int i = 0; i < LK_RAYS_COUNT; i++)
        assert_int_equal(share_of(image)->tracing[i].reason, LK_REASON_RULE);
    assert_int_equal(find_notes(path), 0); // another time it may not be
    lk_image_free(image);
}

static void a_device_that_hangs_is_started_again(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    probe_limits = (struct probe_limits){.all = 1.0, .launch = 0.0, .grace = 0.0};
    const unsigned before = log_warning_count();
    struct lk_image *image = render(scene, &settings);
    assert_true(log_warning_count() > before);
    for (int i = 0; i < LK_RAYS_COUNT; i++) {
        assert_int_equal(share_of(image)->tracing[i].trace, LK_TRACE_SIMPLE);
        assert_int_equal(share_of(image)->tracing[i].reason, LK_REASON_RULE);
    }
    const struct lk_settings plain = settings_of(LK_TRACE_SIMPLE, share_of(image)->bvh);
    struct lk_image *expected = render(scene, &plain);
    assert_same_picture(expected, image);
    lk_image_free(expected);
    lk_image_free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(what_does_not_compile_is_struck_out, begin),
        cmocka_unit_test_setup(what_finds_other_hits_is_struck_out, begin),
        cmocka_unit_test_setup(shadows_that_do_not_agree_are_traced_plainly, begin),
        cmocka_unit_test_setup(what_takes_too_long_is_struck_out, begin),
        cmocka_unit_test_setup(a_device_that_hangs_is_started_again, begin),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
