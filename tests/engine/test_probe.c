// The start-up probe: what it chooses changes no pixel, is remembered, and what does not work is
// struck out. Candidates are of the tests' own, so that CPUs, too, have something to choose.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "choice.h"
#include "core/choices.h"
#include "core/file.h"
#include "core/log.h"
#include "gltf_writer.h"
#include "probe.h"
#include "render_support.h"

#define PATH_SIZE 1024
#define BOTH      (FORM_TRACES | FORM_SHADOWS)

static const struct form sound[] = {
    {LK_TRACE_SIMPLE, LK_BVH_BINARY, BOTH, NULL},
    {LK_TRACE_PERSISTENT, LK_BVH_BINARY, BOTH, NULL},
    {LK_TRACE_SIMPLE, LK_BVH_QUAD, BOTH, NULL},
    {LK_TRACE_PERSISTENT, LK_BVH_QUAD, BOTH, NULL},
};

static struct lk_scene *scene; // of the group
static char folder[PATH_SIZE]; // the cache

// A room with a lamp and something in it, and a mirror for bounces.
static int make_scene(void **state)
{
    (void)state;
    struct gltf_writer writer = {0};
    const char *base = getenv("TMPDIR");
    gltf_room(&writer, gltf_lambert(&writer, 0.7), (const float[]){-2, -1, -2},
              (const float[]){2, 2, 3});
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 3.0, false), 1.9f, 0.6f, false);
    const int mirror = gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"metallicFactor\":1,"
                                              "\"roughnessFactor\":0.1}}");
    for (int i = 0; i < 40; i++) {
        const float x = -1.5f + 0.07f * (float)i;
        const float y = 0.01f * (float)(i * i % 17);
        gltf_triangle(&writer, mirror, (const float[]){x, y, 0, x + 0.2f, y, 0.3f, x, 0.4f, 0.1f});
    }
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2}");
    gltf_light(&writer, (const float[]){1, 2, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"directional\",\"intensity\":1}");
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, 0.2f, 0},
                1.1);
    scene = gltf_load(&writer);
    snprintf(folder, sizeof(folder), "%s/lightkiln-test-XXXXXX", base != NULL ? base : "/tmp");
    return mkdtemp(folder) != NULL && setenv("LIGHTKILN_CACHE_DIR", folder, 1) == 0 ? 0 : -1;
}

// Finds the notes in the cache; the path of one of them, if there is any.
static unsigned find_notes(char *path)
{
    unsigned count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir)) {
        const char *dot = strrchr(entry->d_name, '.');
        if (dot == NULL || strcmp(dot, ".txt") != 0)
            continue;
        snprintf(path, PATH_SIZE, "%.600s/%.200s", folder, entry->d_name);
        count++;
    }
    closedir(dir);
    return count;
}

// Removes what is in the cache.
static void empty_cache(void)
{
    DIR *dir = opendir(folder);
    char path[PATH_SIZE];
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir)) {
        snprintf(path, sizeof(path), "%.600s/%.200s", folder, entry->d_name);
        if (entry->d_name[0] != '.')
            unlink(path);
    }
    closedir(dir);
}

static int free_scene(void **state)
{
    (void)state;
    lk_scene_free(scene);
    empty_cache();
    return rmdir(folder);
}

// Every test starts without notes, with sound candidates and time enough for a slow machine.
static int begin(void **state)
{
    (void)state;
    empty_cache();
    choice_forget();
    choice_candidates = sound;
    choice_candidate_count = sizeof(sound) / sizeof(sound[0]);
    probe_limits = (struct probe_limits){.all = INFINITY, .launch = 120.0, .grace = 1.0};
    return 0;
}

static struct lk_settings settings_of(enum lk_trace trace, enum lk_bvh bvh)
{
    struct lk_settings settings = test_settings(96, 64, 2);
    settings.depth = 4;
    settings.trace = trace;
    settings.bvh = bvh;
    return settings;
}

static struct lk_settings open_settings(void)
{
    return settings_of(LK_TRACE_AUTO, LK_BVH_AUTO);
}

static const struct lk_device_share *share_of(const struct lk_image *image)
{
    return &lk_image_info(image)->devices[0];
}

// Renders, and asserts that all rays are traced as they are for one reason.
static struct lk_image *render_for(const struct lk_settings *settings, enum lk_reason reason)
{
    struct lk_image *image = render(scene, settings);
    const struct lk_device_share *share = share_of(image);
    for (int i = 0; i < LK_RAYS_COUNT; i++)
        assert_int_equal(share->tracing[i].reason, reason);
    assert_true((share->probe_s > 0.0) == (reason == LK_REASON_PROBE));
    return image;
}

// Few paths may go another way.
static void assert_like_picture(const struct lk_image *a, const struct lk_image *b)
{
    struct lk_comparison comparison;
    assert_int_equal(lk_compare(&comparison, NULL, a, b), LK_OK);
    for (int i = 0; i < 3; i++)
        assert_true(comparison.mean[i] > 0.01 && comparison.rmse < 0.05 * comparison.mean[i]);
}

// Where compilers round alike, bits are equal.
static void assert_same_picture(const struct lk_image *a, const struct lk_image *b)
{
    struct lk_comparison comparison;
    assert_int_equal(lk_compare(&comparison, NULL, a, b), LK_OK);
    if (strcmp(share_of(a)->info.type, "cpu") == 0)
        assert_true(comparison.maximum == 0.0);
    assert_like_picture(a, b);
}

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
        char note[512] = "lightkiln tracing 1\n";
        for (unsigned i = 0; i < LK_RAYS_COUNT; i++) {
            const struct form *form = &sound[(i + shift) % 4];
            char line[128], name[96];
            snprintf(line, sizeof(line), "%s %s\n", choices_rays[i],
                     form_name(name, sizeof(name), form));
            strcat(note, line);
        }
        write_note(note);
        struct lk_image *mixed = render_for(&settings, LK_REASON_CACHE);
        for (unsigned i = 0; i < LK_RAYS_COUNT; i++)
            assert_int_equal(share_of(mixed)->tracing[i].trace, sound[(i + shift) % 4].trace);
        assert_same_picture(expected, mixed);
        lk_image_free(mixed);
    }
    lk_image_free(expected);
}

// Shadow rays by groups of items as on GPUs, which send paths on together, too; all else plain.
// CPUs round otherwise where they take hits one by one.
static void groups_of_items_give_the_same_picture(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = open_settings();
    const struct lk_settings plain = settings_of(LK_TRACE_SIMPLE, LK_BVH_BINARY);
    const struct form groups[] = {
        sound[0], {LK_TRACE_PERSISTENT, LK_BVH_BINARY, BOTH, "-D SHADE_LANES=0 -D WARP_WIDTH=32"}};
    choice_candidates = groups;
    choice_candidate_count = 2;
    lk_image_free(render_for(&settings, LK_REASON_PROBE));
    char note[512] = "lightkiln tracing 1\n";
    for (unsigned i = 0; i < LK_RAYS_COUNT; i++) {
        char line[128], name[96];
        snprintf(line, sizeof(line), "%s %s\n", choices_rays[i],
                 form_name(name, sizeof(name), &groups[i == LK_RAYS_COUNT - 1]));
        strcat(note, line);
    }
    write_note(note);
    struct lk_image *expected = render_for(&plain, LK_REASON_FORCED);
    struct lk_image *image = render_for(&settings, LK_REASON_CACHE);
    assert_int_equal(share_of(image)->tracing[LK_RAYS_COUNT - 1].trace, LK_TRACE_PERSISTENT);
    assert_like_picture(expected, image);
    lk_image_free(image);
    lk_image_free(expected);
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
        cmocka_unit_test_setup(groups_of_items_give_the_same_picture, begin),
        cmocka_unit_test_setup(odd_notes_are_measured_anew, begin),
        cmocka_unit_test_setup(without_a_cache_no_note_is_read_or_written, begin),
        cmocka_unit_test_setup(what_is_forced_is_not_measured, begin),
        cmocka_unit_test_setup(cpus_have_nothing_to_choose, begin),
        cmocka_unit_test_setup(what_does_not_compile_is_struck_out, begin),
        cmocka_unit_test_setup(what_finds_other_hits_is_struck_out, begin),
        cmocka_unit_test_setup(shadows_that_do_not_agree_are_traced_plainly, begin),
        cmocka_unit_test_setup(unmeasured_shadows_follow_later_bounces, begin),
        cmocka_unit_test_setup(what_takes_too_long_is_struck_out, begin),
        cmocka_unit_test_setup(little_memory_leaves_one_layout, begin),
        cmocka_unit_test_setup(a_device_that_hangs_is_started_again, begin),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
