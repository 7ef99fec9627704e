// The light tree: its probabilities sum to one, agree with a random descent, and its splits are the
// best of all.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/light_tree.h"
#include "prep_support.h"

#define LIGHTS       200
#define SPLIT_LIGHTS 32 // most lights of which all splits are tried
#define POINTS       300
#define DRAWS        200000
#define SUM_EPSILON  1e-9 // sums of products in double
#define COST_EPSILON 1e-9 // relative
#define DRAW_SIGMAS  6.0  // how far a frequency may be from its probability
#define NONE         UINT32_MAX

struct fixture {
    struct light *lights;
    float *power;
    struct light_tree tree;
    uint32_t count;
};

// Lights within +-10 m; every `unranged`th reaches everywhere (0: none), the others up to 5 m.
static void build(struct fixture *out, uint64_t seed, uint32_t count, uint32_t unranged)
{
    out->count = count;
    out->lights = calloc(count, sizeof(*out->lights));
    out->power = calloc(count, sizeof(*out->power));
    for (uint32_t i = 0; i < count; i++) {
        const bool far = unranged > 0 && i % unranged == 0;
        out->lights[i].org_range =
            (float4){(float)random_between(&seed, -10, 10), (float)random_between(&seed, -10, 10),
                     (float)random_between(&seed, -10, 10),
                     far ? LIGHT_NO_RANGE : (float)random_between(&seed, 0.5, 5)};
        out->power[i] = (float)random_between(&seed, 0.01, 10);
    }
    assert_int_equal(light_tree_build(&out->tree, out->lights, NULL, out->power, count), STATUS_OK);
}

static void release(struct fixture *fixture)
{
    light_tree_free(&fixture->tree);
    free(fixture->power);
    free(fixture->lights);
}

static void random_point(float *out, uint64_t *seed)
{
    for (int k = 0; k < 3; k++)
        out[k] = (float)random_between(seed, -14, 14);
}

static bool holds(const struct light_node *node, const float *p)
{
    return p[0] >= node->lo_left.x && p[0] <= node->hi_child.x && p[1] >= node->lo_left.y &&
           p[1] <= node->hi_child.y && p[2] >= node->lo_left.z && p[2] <= node->hi_child.z;
}

static uint child_word(const struct light_node *node)
{
    uint word;
    memcpy(&word, &node->hi_child.w, sizeof(word));
    return word;
}

// ---- the oracles: the rules of descent, read from the node down

// Adds up the probabilities with which a descent from a node that holds p ends nowhere.
static double failure(const struct light_tree *tree, uint32_t node, const float *p)
{
    const uint child = child_word(&tree->nodes[node]);
    if (child & LIGHT_NODE_LEAF)
        return 0.0;
    const bool left = holds(&tree->nodes[node + 1], p);
    const bool right = holds(&tree->nodes[child], p);
    if (!left && !right)
        return 1.0;
    if (!left || !right)
        return failure(tree, left ? node + 1 : child, p);
    const double share = tree->nodes[node].lo_left.w;
    return share * failure(tree, node + 1, p) + (1.0 - share) * failure(tree, child, p);
}

// Draws one light, or NONE.
static uint32_t draw(const struct light_tree *tree, const float *p, uint64_t *seed)
{
    uint32_t node = 0;
    if (!holds(&tree->nodes[0], p))
        return NONE;
    for (;;) {
        const uint child = child_word(&tree->nodes[node]);
        if (child & LIGHT_NODE_LEAF)
            return child & ~LIGHT_NODE_LEAF;
        const bool left = holds(&tree->nodes[node + 1], p);
        const bool right = holds(&tree->nodes[child], p);
        if (!left && !right)
            return NONE;
        if (left && right)
            node = random_unit(seed) < tree->nodes[node].lo_left.w ? node + 1 : child;
        else
            node = left ? node + 1 : child;
    }
}

// ---- laws

static void check_pmf(uint64_t seed, uint32_t count, uint32_t unranged)
{
    struct fixture fixture;
    build(&fixture, seed, count, unranged);
    for (int i = 0; i < POINTS; i++) {
        float p[3];
        random_point(p, &seed);
        double sum = holds(&fixture.tree.nodes[0], p) ? failure(&fixture.tree, 0, p) : 1.0;
        for (uint32_t light = 0; light < count; light++)
            sum += light_tree_pmf(&fixture.tree, p, light);
        assert_true(fabs(sum - 1.0) <= SUM_EPSILON);
    }
    release(&fixture);
}

static void light_tree_pmf_sums_to_one(void **state)
{
    (void)state;
    check_pmf(1, LIGHTS, 0);
    check_pmf(2, LIGHTS, 1);
    check_pmf(3, LIGHTS, 4);
    check_pmf(4, 1, 0);
    check_pmf(5, 1, 1);
    check_pmf(6, 2, 2);
}

static void every_light_in_reach_can_be_drawn(void **state)
{
    (void)state;
    struct fixture fixture;
    uint64_t seed = 7;
    int in_reach = 0;
    build(&fixture, 8, LIGHTS, 5);
    for (int i = 0; i < POINTS; i++) {
        float p[3];
        random_point(p, &seed);
        for (uint32_t light = 0; light < LIGHTS; light++) {
            const float4 row = fixture.lights[light].org_range;
            const double distance =
                sqrt(pow(p[0] - row.x, 2) + pow(p[1] - row.y, 2) + pow(p[2] - row.z, 2));
            if (row.w != LIGHT_NO_RANGE && distance > row.w)
                continue;
            assert_true(light_tree_pmf(&fixture.tree, p, light) > 0.0);
            in_reach++;
        }
    }
    assert_true(in_reach > POINTS);
    release(&fixture);
}

static void random_descents_agree_with_the_pmf(void **state)
{
    (void)state;
    struct fixture fixture;
    uint64_t seed = 9;
    const float p[3] = {1.0f, -2.0f, 3.0f};
    build(&fixture, 10, LIGHTS, 10);
    uint32_t *hits = calloc(LIGHTS, sizeof(*hits));
    for (int i = 0; i < DRAWS; i++) {
        const uint32_t light = draw(&fixture.tree, p, &seed);
        if (light != NONE)
            hits[light]++;
    }
    for (uint32_t i = 0; i < LIGHTS; i++) {
        const double pmf = light_tree_pmf(&fixture.tree, p, i);
        const double sigma = sqrt(DRAWS * pmf * (1.0 - pmf));
        assert_true(fabs(hits[i] - DRAWS * pmf) <= DRAW_SIGMAS * sigma + 1e-9);
    }
    free(hits);
    release(&fixture);
}

static void check_structure(const struct light_tree *tree)
{
    bool *seen = calloc(tree->light_count, sizeof(*seen));
    assert_int_equal(tree->node_count, 2 * tree->light_count - 1);
    assert_int_equal(tree->parents[0], 0);
    for (uint32_t i = 0; i < tree->node_count; i++) {
        const struct light_node *node = &tree->nodes[i];
        const uint child = child_word(node);
        if (child & LIGHT_NODE_LEAF) {
            const uint32_t light = child & ~LIGHT_NODE_LEAF;
            assert_true(light < tree->light_count && !seen[light]);
            assert_int_equal(tree->leaves[light], i);
            seen[light] = true;
            continue;
        }
        assert_true(child > i + 1 && child < tree->node_count);
        assert_int_equal(tree->parents[i + 1], i);
        assert_int_equal(tree->parents[child], i);
        assert_true(node->lo_left.w > 0.0f && node->lo_left.w < 1.0f);
        for (uint32_t j = 0; j < 2; j++) {
            const struct light_node *below = &tree->nodes[j == 0 ? i + 1 : child];
            const float lo[3] = {below->lo_left.x, below->lo_left.y, below->lo_left.z};
            const float hi[3] = {below->hi_child.x, below->hi_child.y, below->hi_child.z};
            assert_true(holds(node, lo) && holds(node, hi));
        }
    }
    for (uint32_t i = 0; i < tree->light_count; i++)
        assert_true(seen[i]);
    free(seen);
}

static void nodes_stand_depth_first_and_parents_hold_children(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 10, LIGHTS};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++) {
        for (uint32_t unranged = 0; unranged < 4; unranged++) {
            struct fixture fixture;
            build(&fixture, i, counts[i], unranged);
            check_structure(&fixture.tree);
            release(&fixture);
        }
    }
}

// ---- the split: all subsets that a plane parts by centre, tried one by one

static double volume_of(const struct fixture *fixture, const bool *taken, bool side)
{
    double lo[3] = {INFINITY, INFINITY, INFINITY};
    double hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < fixture->count; i++) {
        const float4 row = fixture->lights[i].org_range;
        const double center[3] = {row.x, row.y, row.z};
        for (int k = 0; k < 3 && taken[i] == side; k++) {
            lo[k] = fmin(lo[k], center[k] - row.w);
            hi[k] = fmax(hi[k], center[k] + row.w);
        }
    }
    return (hi[0] - lo[0]) * (hi[1] - lo[1]) * (hi[2] - lo[2]);
}

static double center_on(const struct fixture *fixture, uint32_t light, int axis)
{
    const float4 row = fixture->lights[light].org_range;
    return axis == 0 ? row.x : axis == 1 ? row.y : row.z;
}

static double node_volume(const struct light_node *node)
{
    return ((double)node->hi_child.x - node->lo_left.x) *
           ((double)node->hi_child.y - node->lo_left.y) *
           ((double)node->hi_child.z - node->lo_left.z);
}

static void root_takes_the_least_volume_of_all_splits(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++) {
        struct fixture fixture;
        build(&fixture, seed, 2 + (uint32_t)(seed % (SPLIT_LIGHTS - 1)), 0);
        double best = INFINITY;
        for (int axis = 0; axis < 3; axis++) {
            for (uint32_t pivot = 0; pivot < fixture.count; pivot++) {
                // All up to the pivot's centre against the rest.
                bool taken[SPLIT_LIGHTS];
                uint32_t left = 0;
                for (uint32_t i = 0; i < fixture.count; i++) {
                    taken[i] = center_on(&fixture, i, axis) <= center_on(&fixture, pivot, axis);
                    left += taken[i];
                }
                if (left < fixture.count)
                    best = fmin(best, volume_of(&fixture, taken, true) +
                                          volume_of(&fixture, taken, false));
            }
        }
        const struct light_node *nodes = fixture.tree.nodes;
        const double cost = node_volume(&nodes[1]) + node_volume(&nodes[child_word(&nodes[0])]);
        // Boxes are rounded outwards to float.
        assert_true(fabs(cost - best) <= 1e-5 * best + COST_EPSILON);
        release(&fixture);
    }
}

static uint32_t depth_of(const struct light_tree *tree)
{
    uint32_t depth = 0;
    for (uint32_t light = 0; light < tree->light_count; light++) {
        uint32_t steps = 0;
        for (uint32_t node = tree->leaves[light]; node != 0; node = tree->parents[node])
            steps++;
        depth = steps > depth ? steps : depth;
    }
    return depth;
}

static void equal_lights_make_an_even_tree(void **state)
{
    (void)state;
    const uint32_t count = 1024;
    struct light *lights = calloc(count, sizeof(*lights));
    float *power = calloc(count, sizeof(*power));
    for (float range = 0.0f; range < 2.0f; range += 1.0f) {
        for (uint32_t i = 0; i < count; i++) {
            lights[i].org_range.w = range;
            power[i] = 1.0f;
        }
        struct light_tree tree;
        assert_int_equal(light_tree_build(&tree, lights, NULL, power, count), STATUS_OK);
        check_structure(&tree);
        assert_int_equal(depth_of(&tree), 10);
        light_tree_free(&tree);
    }
    free(power);
    free(lights);
}

static void a_line_of_overlapping_lights_stays_bounded(void **state)
{
    (void)state;
    // Cutting one light off the end is the least volume at every node.
    const uint32_t count = 20000;
    struct light *lights = calloc(count, sizeof(*lights));
    float *power = calloc(count, sizeof(*power));
    for (uint32_t i = 0; i < count; i++) {
        lights[i].org_range = (float4){(float)i * (float)i * 1e-3f, 0, 0, 100.0f};
        power[i] = 1.0f;
    }
    struct light_tree tree;
    assert_int_equal(light_tree_build(&tree, lights, NULL, power, count), STATUS_OK);
    check_structure(&tree);
    assert_true(depth_of(&tree) <= 17 + (uint32_t)ceil(log(count) / log(4.0 / 3.0)));
    light_tree_free(&tree);
    free(power);
    free(lights);
}

static void lights_without_range_are_drawn_by_power(void **state)
{
    (void)state;
    struct fixture fixture;
    const float p[3] = {1e6f, -1e6f, 1e6f};
    double total = 0.0;
    build(&fixture, 11, LIGHTS, 1);
    for (uint32_t i = 0; i < LIGHTS; i++)
        total += fixture.power[i];
    for (uint32_t i = 0; i < LIGHTS; i++) {
        const double expected = fixture.power[i] / total;
        assert_true(fabs(light_tree_pmf(&fixture.tree, p, i) - expected) <= 1e-5 * expected);
    }
    release(&fixture);
}

static void weak_lights_are_never_lost(void **state)
{
    (void)state;
    const struct light lights[2] = {{.org_range = {0, 0, 0, 0}}, {.org_range = {1, 0, 0, 0}}};
    const float power[2] = {FLT_MAX, FLT_MIN};
    const float p[3] = {0};
    struct light_tree tree;
    assert_int_equal(light_tree_build(&tree, lights, NULL, power, 2), STATUS_OK);
    assert_true(light_tree_pmf(&tree, p, 0) > 0.0 && light_tree_pmf(&tree, p, 1) > 0.0);
    light_tree_free(&tree);
}

static void no_lights_give_the_empty_tree(void **state)
{
    (void)state;
    struct light_tree tree;
    assert_int_equal(light_tree_build(&tree, NULL, NULL, NULL, 0), STATUS_OK);
    assert_int_equal(tree.node_count, 0);
    light_tree_free(&tree);
    light_tree_free(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_tree_pmf_sums_to_one),
        cmocka_unit_test(every_light_in_reach_can_be_drawn),
        cmocka_unit_test(random_descents_agree_with_the_pmf),
        cmocka_unit_test(nodes_stand_depth_first_and_parents_hold_children),
        cmocka_unit_test(root_takes_the_least_volume_of_all_splits),
        cmocka_unit_test(equal_lights_make_an_even_tree),
        cmocka_unit_test(a_line_of_overlapping_lights_stays_bounded),
        cmocka_unit_test(lights_without_range_are_drawn_by_power),
        cmocka_unit_test(weak_lights_are_never_lost),
        cmocka_unit_test(no_lights_give_the_empty_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
