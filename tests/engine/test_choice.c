// Choosing a form of tracing: it changes no pixel, and what was measured is remembered.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/choices.h"
#include "core/file.h"
#include "probe_fixture.h"

static void assert_same_tracing(const struct lk_image *a, const struct lk_image *b)
{
    for (int i = 0; i < LK_RAYS_COUNT; i++) {
        assert_int_equal(share_of(a)->tracing[i].trace, share_of(b)->tracing[i].trace);
        assert_int_equal(share_of(a)->tracing[i].bvh, share_of(b)->tracing[i].bvh);
    }
}

// Writes the note of the last probe anew.
static void write_note(const char *text)
{
    char path[PATH_SIZE];
    assert_int_equal(find_notes(path), 1);
    assert_int_equal(file_write(path, text, strlen(text)), STATUS_OK);
    choice_forget();
}

// Writes it with a form for each kind of rays.
static void write_forms(const struct form *const forms[LK_RAYS_COUNT])
{
    char note[512] = "lightkiln tracing 1\n";
    for (unsigned i = 0; i < LK_RAYS_COUNT; i++) {
        char line[128], name[96];
        snprintf(line, sizeof(line), "%s %s\n", choices_rays[i],
                 form_name(name, sizeof(name), forms[i]));
        strcat(note, line);
    }
    write_note(note);
}

// ---- laws

static void what_is_measured_is_found_again(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    char path[PATH_SIZE];
    struct lk_image *first = render_for(&settings, LK_REASON_PROBE);
    assert_int_equal(find_notes(path), 1);
    struct lk_image *same_process = render_for(&settings, LK_REASON_CACHE);
    choice_forget();
    struct lk_image *next_process = render_for(&settings, LK_REASON_CACHE);
    assert_same_tracing(first, same_process);
    assert_same_tracing(first, next_process);
    assert_same_picture(first, same_process);
    assert_same_picture(first, next_process);
    assert_true(share_of(next_process)->memory <= share_of(first)->memory);
    lk_image_free(next_process);
    lk_image_free(same_process);
    lk_image_free(first);
}

// Forms of two layouts, mixed as no probe would.
static void every_mixture_gives_the_same_picture(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    const struct lk_settings plain = settings_of(LK_TRACE_SIMPLE, LK_BVH_BINARY);
    struct lk_image *expected = render_for(&plain, LK_REASON_FORCED);
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    for (unsigned shift = 0; shift < 4; shift++) {
        const struct form *forms[LK_RAYS_COUNT];
        for (unsigned i = 0; i < LK_RAYS_COUNT; i++)
            forms[i] = &sound[(i + shift) % 4];
        write_forms(forms);
        struct lk_image *mixed = render_for(&settings, LK_REASON_CACHE);
        for (unsigned i = 0; i < LK_RAYS_COUNT; i++)
            assert_int_equal(share_of(mixed)->tracing[i].trace, forms[i]->trace);
        assert_same_picture(expected, mixed);
        lk_image_free(mixed);
    }
    lk_image_free(expected);
}

// Renders with shadow rays by groups of so many items, as GPUs take them, and all else plainly.
static struct lk_image *render_by_groups(enum lk_bvh bvh, const char *more)
{
    const struct lk_settings settings = open_settings();
    const struct form groups[] = {sound[0], {LK_TRACE_PERSISTENT, bvh, BOTH, more}};
    choice_candidates = groups;
    choice_candidate_count = 2;
    folder_empty();
    choice_forget();
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    const struct form *forms[LK_RAYS_COUNT];
    for (unsigned i = 0; i < LK_RAYS_COUNT; i++)
        forms[i] = &groups[i == LK_RAYS_SHADOW];
    write_forms(forms);
    struct lk_image *image = render_for(&settings, LK_REASON_CACHE);
    assert_int_equal(share_of(image)->tracing[LK_RAYS_SHADOW].trace, LK_TRACE_PERSISTENT);
    return image;
}

// Groups send paths on together.
static void groups_of_any_size_give_the_same_picture(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_image *single = render_by_groups(LK_BVH_BINARY, "-D SHADE_LANES=0 -D WARP_WIDTH=1");
    struct lk_image *wide = render_by_groups(LK_BVH_BINARY, "-D SHADE_LANES=0 -D WARP_WIDTH=32");
    assert_same_picture(single, wide);
    lk_image_free(wide);
    lk_image_free(single);
}

static void odd_notes_are_measured_anew(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    static const char *const notes[] = {
        "",
        "lightkiln tracing 1\n",
        "lightkiln tracing 1\ncamera binary simple\nfirst_bounce binary simple\nlater_bounces "
        "binary simple\nshadow binary warps\n",
        "lightkiln tracing 1\ncamera binary simple\nfirst_bounce binary simple\nlater_bounces "
        "binary simple\nshadow binary simple\nmore\n",
    };
    char path[PATH_SIZE];
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    for (size_t i = 0; i < sizeof(notes) / sizeof(notes[0]); i++) {
        char *text = NULL;
        size_t size = 0;
        write_note(notes[i]);
        lk_image_free(render_for(&settings, LK_REASON_PROBE));
        assert_int_equal(find_notes(path), 1);
        assert_int_equal(file_read(&text, &size, path), STATUS_OK);
        assert_string_not_equal(text, notes[i]);
        free(text);
        choice_forget();
        lk_image_free(render_for(&settings, LK_REASON_CACHE));
    }
}

static void without_a_cache_no_note_is_read_or_written(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = open_settings();
    char path[PATH_SIZE];
    settings.no_cache = true;
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    assert_int_equal(find_notes(path), 0);
    settings.no_cache = false;
    choice_forget();
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    settings.no_cache = true;
    choice_forget();
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
}

static void what_is_forced_is_not_measured(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings forced = settings_of(LK_TRACE_PERSISTENT, LK_BVH_QUAD);
    char path[PATH_SIZE];
    struct lk_image *image = render_for(&forced, LK_REASON_FORCED);
    for (int i = 0; i < LK_RAYS_COUNT; i++) {
        assert_int_equal(share_of(image)->tracing[i].trace, LK_TRACE_PERSISTENT);
        assert_int_equal(share_of(image)->tracing[i].bvh, LK_BVH_QUAD);
    }
    assert_int_equal(find_notes(path), 0);
    lk_image_free(image);
}

// A CPU's rule has no rival, and costs nothing.
static void cpus_have_nothing_to_choose(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = open_settings();
    choice_candidate_count = 0;
    struct lk_image *image = render(scene, &settings);
    if (strcmp(share_of(image)->info.type, "cpu") == 0)
        for (int i = 0; i < LK_RAYS_COUNT; i++) {
            assert_int_equal(share_of(image)->tracing[i].reason, LK_REASON_RULE);
            assert_int_equal(share_of(image)->tracing[i].bvh, LK_BVH_WIDE);
        }
    lk_image_free(image);
}

// Where shadow rays are not measured, they go over the layout that serves later bounces.
static void unmeasured_shadows_follow_later_bounces(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    const struct lk_settings plain = settings_of(LK_TRACE_SIMPLE, LK_BVH_BINARY);
    struct lk_image *expected = render(scene, &plain);
    // Each in turn has no rival but the rule's, or both have.
    const struct form forms[] = {
        {LK_TRACE_SIMPLE, LK_BVH_BINARY, FORM_TRACES, NULL},
        {LK_TRACE_PERSISTENT, LK_BVH_BINARY, FORM_FOLLOWS, NULL},
        {LK_TRACE_SIMPLE, LK_BVH_QUAD, FORM_TRACES, NULL},
        {LK_TRACE_PERSISTENT, LK_BVH_QUAD, FORM_FOLLOWS, NULL},
    };
    for (uint32_t first = 0; first <= 2; first += 2) {
        choice_candidates = forms + first;
        choice_candidate_count = 4 - first;
        choice_forget();
        struct lk_image *image = render(scene, &settings);
        const struct lk_tracing *tracing = share_of(image)->tracing;
        assert_int_equal(tracing[LK_RAYS_SHADOW].bvh, tracing[LK_RAYS_LATER_BOUNCES].bvh);
        if (tracing[LK_RAYS_SHADOW].bvh != LK_BVH_WIDE)
            assert_int_not_equal(tracing[LK_RAYS_SHADOW].trace, LK_TRACE_SIMPLE);
        if (tracing[LK_RAYS_CAMERA].bvh != LK_BVH_WIDE &&
            tracing[LK_RAYS_SHADOW].bvh != LK_BVH_WIDE &&
            tracing[LK_RAYS_FIRST_BOUNCE].bvh != LK_BVH_WIDE)
            assert_same_picture(expected, image);
        lk_image_free(image);
    }
    lk_image_free(expected);
}

static void little_memory_leaves_one_layout(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = open_settings();
    struct lk_image *plenty = render_for(&settings, LK_REASON_PROBE);
    const struct lk_settings single = settings_of(LK_TRACE_AUTO, LK_BVH_WIDE);
    struct lk_image *one = render(scene, &single);
    settings.memory_limit = share_of(one)->memory;
    struct lk_image *little = render(scene, &settings);
    assert_true(share_of(little)->memory <= settings.memory_limit);
    assert_int_equal(share_of(little)->queue, share_of(plenty)->queue);
    lk_image_free(little);
    lk_image_free(one);
    lk_image_free(plenty);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(what_is_measured_is_found_again, begin),
        cmocka_unit_test_setup(every_mixture_gives_the_same_picture, begin),
        cmocka_unit_test_setup(groups_of_any_size_give_the_same_picture, begin),
        cmocka_unit_test_setup(odd_notes_are_measured_anew, begin),
        cmocka_unit_test_setup(without_a_cache_no_note_is_read_or_written, begin),
        cmocka_unit_test_setup(what_is_forced_is_not_measured, begin),
        cmocka_unit_test_setup(cpus_have_nothing_to_choose, begin),
        cmocka_unit_test_setup(unmeasured_shadows_follow_later_bounces, begin),
        cmocka_unit_test_setup(little_memory_leaves_one_layout, begin),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
