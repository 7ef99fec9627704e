// The SAH builder: what makes a tree a BVH, the root's split against all 24 candidates, and
// sameness for any number of threads.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdbool.h>

#include "prep/bvh.h"
#include "prep_support.h"
#include "shared/bvh.h"

#define LEAF_SIZE    8
#define COST_EPSILON 1e-6 // relative: centroids and planes are computed in float

// Random boxes within +-range, with sides up to `size`.
static struct tri_ref *make_refs(uint64_t seed, uint32_t count, double range, double size)
{
    struct tri_ref *refs = calloc(count + 1, sizeof(*refs));
    for (uint32_t i = 0; i < count; i++) {
        refs[i].triangle = i;
        for (int k = 0; k < 3; k++) {
            refs[i].lo[k] = (float)random_between(&seed, -range, range);
            refs[i].hi[k] = refs[i].lo[k] + (float)random_between(&seed, 0.0, size);
        }
    }
    return refs;
}

static void unite(float *lo, float *hi, const float *other_lo, const float *other_hi)
{
    for (int k = 0; k < 3; k++) {
        lo[k] = fminf(lo[k], other_lo[k]);
        hi[k] = fmaxf(hi[k], other_hi[k]);
    }
}

// Checks a subtree and returns its depth. Counts its nodes and moves *next over its references.
static uint32_t check_subtree(const struct bvh *bvh, const struct tri_ref *refs, uint32_t leaf_size,
                              uint32_t index, uint32_t *next, uint32_t *node_count)
{
    const struct bvh_build_node *node = &bvh->nodes[index];
    float lo[3] = {FLT_MAX, FLT_MAX, FLT_MAX};
    float hi[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    uint32_t depth = 1;
    ++*node_count;
    if (node->count > 0) {
        assert_true(node->count < leaf_size);
        assert_int_equal(node->left, *next); // leaves stand in the order of their references
        *next += node->count;
        for (uint32_t i = 0; i < node->count; i++) {
            const struct tri_ref *ref = &refs[bvh->order[node->left + i]];
            unite(lo, hi, ref->lo, ref->hi);
        }
    } else {
        const uint32_t first = *next;
        assert_true(node->left > index && node->left + 1 < bvh->node_count);
        for (uint32_t side = 0; side < 2; side++) {
            const struct bvh_build_node *child = &bvh->nodes[node->left + side];
            const uint32_t below =
                check_subtree(bvh, refs, leaf_size, node->left + side, next, node_count);
            depth = below + 1 > depth ? below + 1 : depth;
            unite(lo, hi, child->lo, child->hi);
        }
        assert_true(*next - first >= leaf_size); // fewer would be a leaf
    }
    assert_memory_equal(node->lo, lo, sizeof(lo));
    assert_memory_equal(node->hi, hi, sizeof(hi));
    return depth;
}

// Builds a tree, checks all that makes it one, and returns its depth.
static uint32_t check_tree(const struct tri_ref *refs, uint32_t count, uint32_t leaf_size)
{
    struct bvh bvh;
    assert_int_equal(bvh_build(&bvh, refs, count, leaf_size), STATUS_OK);
    assert_int_equal(bvh.ref_count, count);

    uint32_t next = 0;
    uint32_t node_count = 0;
    const uint32_t depth = check_subtree(&bvh, refs, leaf_size, 0, &next, &node_count);
    assert_int_equal(next, count);
    assert_int_equal(node_count, bvh.node_count);
    assert_int_equal(depth, bvh.depth);
    assert_true(depth < BVH_STACK_SIZE);

    bool *seen = calloc(count, sizeof(*seen));
    for (uint32_t i = 0; i < count; i++) {
        assert_true(bvh.order[i] < count && !seen[bvh.order[i]]);
        seen[bvh.order[i]] = true;
    }
    free(seen);
    bvh_free(&bvh);
    return depth;
}

static void bvh_bounds_every_reference_once(void **state)
{
    (void)state;
    static const uint32_t leaf_sizes[] = {2, 3, 8, BVH_LEAF_MAX + 1};
    static const uint32_t counts[] = {1, 2, 3, 7, 8, 9, 100, 20000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++) {
        struct tri_ref *refs = make_refs(i, counts[i], 10.0, 1.0);
        for (size_t j = 0; j < sizeof(leaf_sizes) / sizeof(leaf_sizes[0]); j++)
            check_tree(refs, counts[i], leaf_sizes[j]);
        free(refs);
    }
}

static void no_references_give_the_empty_tree(void **state)
{
    (void)state;
    struct bvh bvh;
    assert_int_equal(bvh_build(&bvh, NULL, 0, LEAF_SIZE), STATUS_OK);
    assert_int_equal(bvh.node_count, 0);
    assert_true(bvh_sah_cost(&bvh) == 0.0);
    bvh_free(&bvh);
}

static void bvh_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    const uint32_t count = 30000;
    const int threads = omp_get_max_threads();
    struct tri_ref *refs = make_refs(1, count, 10.0, 0.5);
    struct bvh one, many;
    omp_set_num_threads(1);
    assert_int_equal(bvh_build(&one, refs, count, LEAF_SIZE), STATUS_OK);
    omp_set_num_threads(5);
    assert_int_equal(bvh_build(&many, refs, count, LEAF_SIZE), STATUS_OK);
    omp_set_num_threads(threads);
    assert_int_equal(one.node_count, many.node_count);
    assert_memory_equal(one.nodes, many.nodes, one.node_count * sizeof(*one.nodes));
    assert_memory_equal(one.order, many.order, count * sizeof(*one.order));
    bvh_free(&many);
    bvh_free(&one);
    free(refs);
}

static double half_area(const float *lo, const float *hi)
{
    const double x = (double)hi[0] - lo[0];
    const double y = (double)hi[1] - lo[1];
    const double z = (double)hi[2] - lo[2];
    return x * y + y * z + z * x;
}

// The cost of cutting all references by their centroids at one plane; infinite if it parts nothing.
static double plane_cost(const struct tri_ref *refs, uint32_t count, int axis, double at)
{
    float lo[2][3], hi[2][3];
    uint32_t counts[2] = {0, 0};
    for (int i = 0; i < 6; i++) {
        lo[i / 3][i % 3] = FLT_MAX;
        hi[i / 3][i % 3] = -FLT_MAX;
    }
    for (uint32_t i = 0; i < count; i++) {
        const int side = 0.5 * ((double)refs[i].lo[axis] + refs[i].hi[axis]) >= at;
        unite(lo[side], hi[side], refs[i].lo, refs[i].hi);
        counts[side]++;
    }
    if (counts[0] == 0 || counts[1] == 0)
        return INFINITY;
    return counts[0] * half_area(lo[0], hi[0]) + counts[1] * half_area(lo[1], hi[1]);
}

static uint32_t count_below(const struct bvh *bvh, uint32_t index)
{
    const struct bvh_build_node *node = &bvh->nodes[index];
    return node->count > 0 ? node->count
                           : count_below(bvh, node->left) + count_below(bvh, node->left + 1);
}

static void root_takes_the_cheapest_of_24_planes(void **state)
{
    (void)state;
    const uint32_t count = 60;
    for (uint64_t seed = 0; seed < 200; seed++) {
        struct tri_ref *refs = make_refs(seed, count, 10.0, 2.0);
        double best = INFINITY;
        for (int axis = 0; axis < 3; axis++) {
            double lo = INFINITY;
            double hi = -INFINITY;
            for (uint32_t i = 0; i < count; i++) {
                const double center = 0.5 * ((double)refs[i].lo[axis] + refs[i].hi[axis]);
                lo = fmin(lo, center);
                hi = fmax(hi, center);
            }
            for (int plane = 1; plane <= 8; plane++)
                best = fmin(best, plane_cost(refs, count, axis, lo + (hi - lo) * plane / 9.0));
        }

        struct bvh bvh;
        assert_int_equal(bvh_build(&bvh, refs, count, LEAF_SIZE), STATUS_OK);
        double cost = 0.0;
        for (uint32_t child = bvh.nodes[0].left; child < bvh.nodes[0].left + 2; child++)
            cost += count_below(&bvh, child) * half_area(bvh.nodes[child].lo, bvh.nodes[child].hi);
        assert_true(fabs(cost - best) <= COST_EPSILON * best);
        bvh_free(&bvh);
        free(refs);
    }
}

static void equal_boxes_are_halved(void **state)
{
    (void)state;
    const uint32_t count = 10000;
    struct tri_ref *refs = make_refs(1, count, 0.0, 0.0);
    assert_int_equal(check_tree(refs, count, 2), 15); // 2^14 is the first power above
    free(refs);
}

static void boxes_that_halve_their_way_to_zero_stay_shallow(void **state)
{
    (void)state;
    // Each plane parts only the largest few from all others.
    const uint32_t count = 40000;
    struct tri_ref *refs = make_refs(1, count, 1.0, 0.0);
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            refs[i].lo[k] = refs[i].hi[k] = (float)exp2(120.0 - 240.0 * i / count);
    assert_true(check_tree(refs, count, 2) > 20);
    free(refs);
}

static void boxes_as_large_as_float_are_no_harm(void **state)
{
    (void)state;
    const uint32_t count = 1000;
    struct tri_ref *refs = make_refs(1, count, 3.4e38, 0.0);
    check_tree(refs, count, LEAF_SIZE);
    free(refs);
}

static void cost_of_two_leaves_is_their_share_of_the_root(void **state)
{
    (void)state;
    // Two unit cubes in a row of three: the root's surface is 14, that of each leaf 6.
    const struct tri_ref refs[2] = {{{0, 0, 0}, {1, 1, 1}, 0}, {{2, 0, 0}, {3, 1, 1}, 1}};
    struct bvh bvh;
    assert_int_equal(bvh_build(&bvh, refs, 2, 2), STATUS_OK);
    assert_true(fabs(bvh_sah_cost(&bvh) - (1.0 + 2.0 * 6.0 / 14.0)) < 1e-12);
    bvh_free(&bvh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bvh_bounds_every_reference_once),
        cmocka_unit_test(no_references_give_the_empty_tree),
        cmocka_unit_test(bvh_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(root_takes_the_cheapest_of_24_planes),
        cmocka_unit_test(equal_boxes_are_halved),
        cmocka_unit_test(boxes_that_halve_their_way_to_zero_stay_shallow),
        cmocka_unit_test(boxes_as_large_as_float_are_no_harm),
        cmocka_unit_test(cost_of_two_leaves_is_their_share_of_the_root),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
