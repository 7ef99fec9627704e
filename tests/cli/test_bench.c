// Laws of what bench tells: tables, the thesis's numbers, curves, conclusions, the cave.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/bench_cave.h"
#include "cli/bench_rays.h"
#include "cli/bench_results.h"
#include "core/file.h"
#include "cli/commands.h"

// ---- Tables

static const struct bench_column columns[] = {
    {"name", "what it is called", NULL},
    {"value", "what it is", "%.1f"},
};

static struct bench_table two_rows(void)
{
    struct bench_table table = {
        .key = "things", .title = "Things", .columns = columns, .column_count = 2};
    bench_text(&table, "first");
    bench_number(&table, 1.25);
    bench_text(&table, "second");
    bench_number(&table, NAN);
    return table;
}

static void table_tells_every_cell_in_every_form(void **state)
{
    (void)state;
    struct bench_table table = two_rows();
    struct json json = {.compact = true};
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    bench_table_markdown(file, &table);
    bench_table_print(file, &table);
    assert_int_equal(fclose(file), 0);
    assert_non_null(strstr(text, "| what it is called | what it is |"));
    assert_non_null(strstr(text, "| first | 1.2 |"));
    assert_non_null(strstr(text, "| second | - |"));
    assert_non_null(strstr(text, "second      -"));

    json_object(&json, NULL);
    bench_table_json(&json, &table);
    json_object_end(&json);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, "{\"things\":[{\"name\":\"first\",\"value\":1.25},"
                                   "{\"name\":\"second\",\"value\":null}]}");
    json_free(&json);
    bench_table_free(&table);
    free(text);
}

// ---- The thesis

static void thesis_shares_add_up(void **state)
{
    (void)state;
    static const char *const names[] = {"cornell", "cathedral", "atrium", "deck"};
    for (int i = 0; i < 4; i++) {
        const struct thesis_scene *scene = thesis_find(names[i]);
        assert_non_null(scene);
        for (int k = 0; k < 4; k++) {
            const double sum = scene->traversal[k >> 1][k & 1] + scene->lighting[k >> 1][k & 1] +
                               scene->others[k >> 1][k & 1];
            if (sum > 0.0) // Sponza's are not told
                assert_true(fabs(sum - 100.0) < 0.15);
        }
    }
    assert_null(thesis_find("teapot"));
}

// ---- Curves

// variance = 1 / time at 1, 2, 4 .. s, and twice as many rays as microseconds.
static struct bench_curve falling(double times)
{
    struct bench_curve curve = {0};
    for (int i = 0; i < 6; i++)
        curve.points[curve.count++] = (struct bench_point){
            .time_s = exp2(i), .rays = 2e6 * exp2(i), .spp = exp2(i), .variance = times / exp2(i)};
    return curve;
}

static void curve_is_read_between_its_points(void **state)
{
    (void)state;
    const struct bench_curve curve = falling(1.0);
    assert_true(fabs(bench_curve_reach(&curve, 1.0 / 5.5, false) - 5.5) < 1e-9);
    assert_true(fabs(bench_curve_reach(&curve, 1.0 / 16.0, true) - 32e6) < 1e-3);
    assert_true(bench_curve_reach(&curve, 2.0, false) == 1.0);
    assert_true(isinf(bench_curve_reach(&curve, 1e-3, false)));
}

// ---- Conclusions

// Measurements on two scenes: as the thesis has them, or all the other way round.
static void make_results(struct bench_results *out, bool as_thesis)
{
    *out = (struct bench_results){.scene_count = 2};
    for (unsigned i = 0; i < 2; i++) {
        struct bench_scene *scene = &out->scenes[i];
        scene->thesis = thesis_find("cornell");
        scene->queue = 1000000;
        scene->used.rays = as_thesis ? 50000000 : 500000000;
        scene->small_queue = scene->queue;
        for (int s = 0; s < 2; s++) {
            struct lk_scene_info *info = &scene->info[s];
            info->triangles = 1000u << i;
            info->lights.drawn = 1;
            scene->used.geometry = as_thesis ? 100 * info->triangles : 100;
            scene->used.bvh = as_thesis ? 10 * info->triangles : 1000;
            info->memory.rays = (as_thesis ? 1000 : 1000 + i) * (as_thesis && s ? 4 : 1);
        }
        for (int k = 0; k < 8; k++) {
            struct bench_speed *speed = &scene->speed[k >> 2][k >> 1 & 1][k & 1];
            const double more = 1.0 + (k >> 2) + (k & 1) + 2.0 * !(k >> 1 & 1);
            speed->rays_per_s = as_thesis ? more : 1.0 / more;
            speed->traversal = 0.5;
            speed->lighting = as_thesis ? 0.4 - 0.1 * (k >> 1 & 1) : 0.8 + 0.1 * (k >> 1 & 1);
            if (k & 1)
                speed->lighting *= as_thesis ? 2.0 : 8.0;
        }
        scene->used.materials = as_thesis ? 0 : 1000000000;
        scene->small_rays_per_s = (as_thesis ? 1.0 : 0.5) * scene->speed[1][1][0].rays_per_s;
        scene->view_count = 1;
        scene->views[0] = (struct bench_view){
            .title = "view",
            .has_curves = true,
            .thesis_faster = 1,
            .thesis_better = -1,
            .curves = {falling(as_thesis ? 2.0 : 1.0), falling(as_thesis ? 1.0 : 2.0)}};
        for (unsigned p = 0; p < 6; p++) // rays: four times as many for four shadow rays, or one
            scene->views[0].curves[1].points[p].rays *= as_thesis ? 4.0 : 0.125;
    }
}

static void conclusions_follow_the_measurements(void **state)
{
    (void)state;
    struct bench_results *results = calloc(1, sizeof(*results));
    assert_non_null(results);
    for (int as_thesis = 0; as_thesis < 2; as_thesis++) {
        struct bench_table table;
        make_results(results, as_thesis);
        bench_conclusions(&table, results);
        assert_int_equal(table.cell_count % table.column_count, 0);
        unsigned told = 0;
        for (size_t i = 0; i < table.cell_count; i += table.column_count) {
            const char *holds = table.cells[i + 1].text;
            if (strcmp(holds, "not measured") == 0)
                continue; // Sponza's
            told++;
            if (strcmp(holds, as_thesis ? "holds" : "does not hold") != 0)
                fail_msg("%s: %s, %s", table.cells[i].text, holds, table.cells[i + 2].text);
        }
        assert_true(told >= 14);
        bench_table_free(&table);
    }
    free(results);
}

// ---- The command

static enum status run(const char *line)
{
    static char text[256];
    char *args[16];
    int count = 0;
    struct options options;
    snprintf(text, sizeof(text), "%s", line);
    for (char *word = strtok(text, " "); word != NULL; word = strtok(NULL, " "))
        args[count++] = word;
    const enum status status = options_parse(&options, COMMAND_BENCH, args, count);
    return status == STATUS_OK ? command_bench(&options) : status;
}

static void options_without_use_are_refused(void **state)
{
    (void)state;
    static const char *const lines[] = {"report --depth 3",
                                        "--width 100",
                                        "memory --reference a",
                                        "scale --runs 3",
                                        "lights a.glb --quick",
                                        "trace a.glb --out b",
                                        "path a.glb --views 2",
                                        "scale a.glb",
                                        "lights",
                                        "lights a.glb b.glb",
                                        "teapot"};
    for (size_t i = 0; i < sizeof(lines) / sizeof(lines[0]); i++)
        assert_int_equal(run(lines[i]), STATUS_USAGE);
    assert_int_equal(run("report nosuch.glb --out /tmp --quiet"), STATUS_IO);
    assert_non_null(strstr(status_message(), "make_scenes"));
}

// ---- The cave

static void cave_has_the_triangles_and_lights_asked_for(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{100, 1}, {10000, 64}, {20000, 1000}};
    char folder[] = "/tmp/lightkiln_bench_XXXXXX";
    char path[128];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/cave.glb", folder);
    for (int i = 0; i < 3; i++) {
        struct lk_scene *scene = NULL;
        struct lk_scene_info info;
        struct lk_settings settings;
        lk_settings_init(&settings);
        assert_int_equal(bench_cave_write(path, sizes[i][0], sizes[i][1]), STATUS_OK);
        assert_int_equal(lk_scene_load(&scene, path), LK_OK);
        assert_int_equal(lk_scene_info(&info, scene, &settings), LK_OK);
        const double walls = (double)info.triangles - sizes[i][1];
        assert_true(fabs(walls - sizes[i][0]) < 0.1 * sizes[i][0]);
        assert_int_equal(info.lights.drawn, sizes[i][1]);
        lk_scene_free(scene);
    }
    unlink(path);
    rmdir(folder);
}

// ---- Views

#define VIEWS     4u
#define VIEW_SIDE 32u

// All rays of a view start at one place and look within 90 degrees of it; nearly all meet the
// level.
static void check_view(const struct lk_ray *rays, const struct lk_hit *hits)
{
    double ahead[3] = {0.0, 0.0, 0.0};
    uint32_t missed = 0;
    for (uint32_t i = 0; i < VIEW_SIDE * VIEW_SIDE; i++) {
        assert_memory_equal(rays[i].org, rays[0].org, sizeof(rays[0].org));
        for (int k = 0; k < 3; k++)
            ahead[k] += rays[i].dir[k];
        missed += hits[i].triangle == LK_HIT_NONE;
    }
    const double length = sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1] + ahead[2] * ahead[2]);
    assert_true(fabs(ahead[1]) < 1e-3 * length); // a level heading
    assert_true(missed < VIEW_SIDE * VIEW_SIDE / 4);
    for (uint32_t i = 0; i < VIEW_SIDE * VIEW_SIDE; i++) {
        double part = 0.0;
        for (int k = 0; k < 3; k++)
            part += rays[i].dir[k] * ahead[k] / length;
        assert_true(part > 1.0 / sqrt(3.0)); // the corners of a square of 90 degrees
    }
}

static void views_stand_apart_inside_the_level(void **state)
{
    (void)state;
    char folder[] = "/tmp/lightkiln_bench_XXXXXX";
    char path[128];
    struct lk_scene *scene = NULL;
    struct lk_tracer *tracer = NULL;
    struct lk_settings settings;
    struct ray_set sets[RAY_CLASSES], again[RAY_CLASSES];
    static struct lk_hit hits[VIEWS * VIEW_SIDE * VIEW_SIDE];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/cave.glb", folder);
    lk_settings_init(&settings);
    settings.width = VIEWS * VIEW_SIDE;
    settings.height = VIEW_SIDE;
    assert_int_equal(bench_cave_write(path, 1000, 1), STATUS_OK);
    assert_int_equal(lk_scene_load(&scene, path), LK_OK);
    assert_int_equal(lk_tracer_create(&tracer, scene, &settings), LK_OK);
    assert_int_equal(ray_sets_make(sets, scene, tracer, VIEWS), STATUS_OK);
    assert_int_equal(ray_sets_make(again, scene, tracer, VIEWS), STATUS_OK);

    const struct ray_set *primary = &sets[RAYS_PRIMARY];
    assert_int_equal(primary->count, VIEWS * VIEW_SIDE * VIEW_SIDE);
    assert_int_equal(ray_set_trace(hits, tracer, primary), STATUS_OK);
    for (uint32_t i = 0; i < VIEWS; i++) {
        const uint32_t first = i * VIEW_SIDE * VIEW_SIDE;
        check_view(primary->rays + first, hits + first);
        for (uint32_t j = 0; j < i; j++)
            assert_memory_not_equal(primary->rays[first].org,
                                    primary->rays[j * VIEW_SIDE * VIEW_SIDE].org,
                                    sizeof(primary->rays[0].org));
    }
    for (int k = 0; k < RAY_CLASSES; k++) {
        assert_int_equal(sets[k].count, again[k].count);
        assert_memory_equal(sets[k].rays, again[k].rays, sets[k].count * sizeof(*sets[k].rays));
    }
    ray_sets_free(again);
    ray_sets_free(sets);
    assert_int_equal(ray_sets_make(sets, scene, tracer, 17), STATUS_USAGE); // too small
    lk_tracer_free(tracer);
    lk_scene_free(scene);
    unlink(path);
    rmdir(folder);
}

// The number that follows the n-th `"key": ` of a JSON text.
static double number_of(const char *json, const char *key, int n)
{
    char text[64];
    snprintf(text, sizeof(text), "\"%s\": ", key);
    for (const char *at = strstr(json, text); at != NULL; at = strstr(at + 1, text))
        if (n-- == 0)
            return strtod(at + strlen(text), NULL);
    fail_msg("no %s in %s", key, json);
    return NAN;
}

// A path has a ray to each hit, as many to the one light, and one more that may only collect what
// shines; what is told of it adds up.
static void path_tells_what_adds_up(void **state)
{
    (void)state;
    char folder[] = "/tmp/lightkiln_bench_XXXXXX";
    char path[128];
    char out[128];
    char line[256];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/cave.glb", folder);
    snprintf(out, sizeof(out), "%s/out.json", folder);
    assert_int_equal(bench_cave_write(path, 1000, 1), STATUS_OK);
    snprintf(line, sizeof(line),
             "path %s --width 32 --height 32 --runs 3 --time 0.05 --json --quiet", path);

    fflush(stdout);
    const int terminal = dup(STDOUT_FILENO);
    const int file = open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, STDOUT_FILENO);
    const enum status status = run(line);
    fflush(stdout);
    dup2(terminal, STDOUT_FILENO);
    close(terminal);
    close(file);
    assert_int_equal(status, STATUS_OK);

    char *json = NULL;
    size_t size = 0;
    assert_int_equal(file_read(&json, &size, out), STATUS_OK);
    for (int row = 0; row < 4; row++) {
        const double depth = number_of(json, "depth", row);
        const double rays = number_of(json, "rays_per_path", row);
        const double median = number_of(json, "mpaths_per_s", row);
        const double traced = number_of(json, "traced_percent", row);
        assert_true(depth == (row < 2 ? 1.0 : 5.0));
        assert_true(rays > 1.0 && rays <= 2.0 * depth + 1.0);
        assert_true(number_of(json, "trace_only_percent", row) > 0.0);
        assert_true(number_of(json, "mpaths_per_s_least", row) <= median);
        assert_true(number_of(json, "mpaths_per_s_most", row) >= median);
        assert_true(median > 0.0 && traced > 0.0 && traced < 100.0);
        assert_true(fabs(number_of(json, "mrays_per_s", row) - median * rays) < 1e-6 * median);
    }
    free(json);
    unlink(out);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_tells_every_cell_in_every_form),
        cmocka_unit_test(thesis_shares_add_up),
        cmocka_unit_test(curve_is_read_between_its_points),
        cmocka_unit_test(conclusions_follow_the_measurements),
        cmocka_unit_test(options_without_use_are_refused),
        cmocka_unit_test(cave_has_the_triangles_and_lights_asked_for),
        cmocka_unit_test(views_stand_apart_inside_the_level),
        cmocka_unit_test(path_tells_what_adds_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
