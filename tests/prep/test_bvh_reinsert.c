// Reinsertion: the tree stays a tree of the same leaves, becomes cheaper, and is the same for any
// number of threads.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <omp.h>
#include <stdbool.h>

#include "prep/bvh_reinsert.h"
#include "prep/bvh_trial.h"
#include "shared/bvh.h"
#include "tree_fixture.h"

static void reinsert(struct tree *f)
{
    assert_int_equal(bvh_reinsert(&f->bvh, f->refs, &f->geometry), STATUS_OK);
}

static void copy(struct bvh *out, const struct bvh *bvh)
{
    assert_int_equal(bvh_take(out, bvh->nodes, bvh->order), STATUS_OK);
}

// Checks that boxes are no larger than what is in them. Returns the depth, and marks the leaves'
// references.
static uint32_t check_subtree(const struct bvh *bvh, uint32_t index, bool *seen)
{
    const struct bvh_build_node *node = &bvh->nodes[index];
    if (node->count > 0) {
        for (uint32_t i = node->left; i < node->left + node->count; i++) {
            assert_false(seen[bvh->order[i]]);
            seen[bvh->order[i]] = true;
        }
        return 1;
    }
    const struct bvh_build_node *left = &bvh->nodes[node->left];
    assert_true(node->left > index && node->left + 1 < bvh->node_count);
    for (int k = 0; k < 3; k++) {
        assert_true(node->lo[k] == fminf(left[0].lo[k], left[1].lo[k]));
        assert_true(node->hi[k] == fmaxf(left[0].hi[k], left[1].hi[k]));
    }
    const uint32_t a = check_subtree(bvh, node->left, seen);
    const uint32_t b = check_subtree(bvh, node->left + 1, seen);
    return 1 + (a > b ? a : b);
}

// The leaf of a tree that holds a reference.
static const struct bvh_build_node *find_leaf(const struct bvh *bvh, uint32_t ref)
{
    for (uint32_t i = 0; i < bvh->node_count; i++)
        for (uint32_t k = 0; k < bvh->nodes[i].count; k++)
            if (bvh->order[bvh->nodes[i].left + k] == ref)
                return &bvh->nodes[i];
    return NULL;
}

// Reinserts and checks all that must hold. Takes the geometry over.
static void check_reinsert(struct geometry geometry, uint32_t leaf_size)
{
    struct tree f = tree_make(geometry, false, leaf_size);
    const struct bvh *bvh = &f.bvh;
    struct bvh old;
    double old_work, work;
    copy(&old, bvh);
    reinsert(&f);
    assert_int_equal(bvh->node_count, old.node_count);
    assert_int_equal(bvh->ref_count, old.ref_count);
    bool *seen = calloc(bvh->ref_count + 1, sizeof(*seen));
    assert_int_equal(check_subtree(bvh, 0, seen), bvh->depth);
    assert_true(bvh->depth < BVH_STACK_SIZE);
    for (uint32_t i = 0; i < bvh->ref_count; i++)
        assert_true(seen[i]);
    for (uint32_t i = 0; i < bvh->ref_count && i < 500; i++) {
        const struct bvh_build_node *a = find_leaf(&old, i);
        const struct bvh_build_node *b = find_leaf(bvh, i);
        assert_int_equal(a->count, b->count);
        assert_memory_equal(a->lo, b->lo, sizeof(a->lo));
        assert_memory_equal(a->hi, b->hi, sizeof(a->hi));
    }
    assert_true(bvh_sah_cost(bvh) <= bvh_sah_cost(&old) * (1.0 + 1e-6));
    assert_int_equal(bvh_trial(&old_work, &old, f.refs, &f.geometry), STATUS_OK);
    assert_int_equal(bvh_trial(&work, bvh, f.refs, &f.geometry), STATUS_OK);
    assert_true(work <= old_work);
    free(seen);
    bvh_free(&old);
    tree_free(&f);
}

// ---- laws

static void the_tree_keeps_its_leaves(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 4, 5, 9, 100, 5000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++) {
        check_reinsert(make_soup(i, counts[i], 10.0, 1.0), 2);
        check_reinsert(make_soup(i, counts[i], 1.0, 20.0), 8);
    }
}

static void boxes_as_large_as_float_and_as_small_are_no_harm(void **state)
{
    (void)state;
    check_reinsert(make_soup(1, 300, 1e18, 1e18), 2);
    check_reinsert(make_soup(1, 300, 1e-18, 1e-18), 2);
}

static void equal_boxes_are_no_harm(void **state)
{
    (void)state;
    float corners[9 * 1000];
    for (uint32_t i = 0; i < 9 * 1000; i++)
        corners[i] = (float)(i % 9 * i % 9);
    check_reinsert(make_geometry(corners, 1000), 2);
}

static void the_empty_tree_stays_empty(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    struct bvh bvh = {0};
    assert_int_equal(bvh_reinsert(&bvh, NULL, &geometry), STATUS_OK);
    assert_int_equal(bvh.node_count, 0);
}

// A leaf of each of two heaps is put where the other one should be: the worst nodes there are.
static void what_was_mislaid_is_put_back(void **state)
{
    (void)state;
    float corners[9 * 200];
    uint64_t seed = 3;
    for (uint32_t i = 0; i < 9 * 200; i++)
        corners[i] = (float)random_unit(&seed) + (i < 9 * 100 ? 0.0f : 1000.0f);
    struct tree f = tree_make(make_geometry(corners, 200), false, 2);
    const struct bvh bvh = f.bvh;
    const double good = bvh_sah_cost(&bvh);

    // Exchange the heaps' last leaves, and bound what is above anew.
    uint32_t last[2] = {0, 0};
    for (uint32_t i = 0; i < bvh.node_count; i++)
        if (bvh.nodes[i].count > 0)
            last[bvh.nodes[i].lo[0] > 500.0f] = i;
    const struct bvh_build_node kept = bvh.nodes[last[0]];
    bvh.nodes[last[0]] = bvh.nodes[last[1]];
    bvh.nodes[last[1]] = kept;
    for (uint32_t i = bvh.node_count; i > 0; i--) {
        struct bvh_build_node *node = &bvh.nodes[i - 1];
        const struct bvh_build_node *left = &bvh.nodes[node->left];
        for (int k = 0; k < 3 && node->count == 0; k++) {
            node->lo[k] = fminf(left[0].lo[k], left[1].lo[k]);
            node->hi[k] = fmaxf(left[0].hi[k], left[1].hi[k]);
        }
    }
    assert_true(bvh_sah_cost(&bvh) > good + 4.0);
    reinsert(&f);
    assert_true(bvh_sah_cost(&f.bvh) <= good * (1.0 + 1e-6));
    tree_free(&f);
}

// Triangles of all sizes: a top-down builder puts large ones beside small ones.
static void triangles_of_all_sizes_become_cheaper(void **state)
{
    (void)state;
    static float corners[9 * 20000];
    uint64_t seed = 5;
    for (uint32_t i = 0; i < 20000; i++) {
        const double size = pow(10.0, random_between(&seed, -3.0, 0.0));
        for (int k = 0; k < 3; k++) {
            const double org = random_unit(&seed);
            for (int corner = 0; corner < 3; corner++)
                corners[9 * i + (uint32_t)(3 * corner + k)] =
                    (float)(org + size * random_unit(&seed));
        }
    }
    struct tree f = tree_make(make_geometry(corners, 20000), false, 2);
    const double cost = bvh_sah_cost(&f.bvh);
    reinsert(&f);
    assert_true(bvh_sah_cost(&f.bvh) < 0.95 * cost);
    tree_free(&f);
}

static void the_tree_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    const int threads = omp_get_max_threads();
    struct tree one = tree_make(make_soup(6, 30000, 10.0, 1.0), false, 2);
    struct tree many = tree_make(make_soup(6, 30000, 10.0, 1.0), false, 2);
    omp_set_num_threads(1);
    reinsert(&one);
    omp_set_num_threads(5);
    reinsert(&many);
    omp_set_num_threads(threads);
    assert_same_tree(&one.bvh, &many.bvh);
    tree_free(&many);
    tree_free(&one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tree_keeps_its_leaves),
        cmocka_unit_test(boxes_as_large_as_float_and_as_small_are_no_harm),
        cmocka_unit_test(equal_boxes_are_no_harm),
        cmocka_unit_test(the_empty_tree_stays_empty),
        cmocka_unit_test(what_was_mislaid_is_put_back),
        cmocka_unit_test(triangles_of_all_sizes_become_cheaper),
        cmocka_unit_test(the_tree_is_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
