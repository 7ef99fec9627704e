// The builder with spatial splits: what makes its tree a BVH of all triangles, and sameness for any
// number of threads.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdbool.h>

#include "shared/bvh.h"
#include "tree_fixture.h"

#define LEAF_SIZE 8
#define POINTS    40      // of each triangle, that must be in a leaf
#define MARGIN    0x1p-22 // part of the largest coordinate that packing grows boxes by

static bool is_inside(const struct bvh_build_node *node, const struct bvh_build_node *parent)
{
    for (int k = 0; k < 3; k++)
        if (node->lo[k] < parent->lo[k] || node->hi[k] > parent->hi[k])
            return false;
    return true;
}

// Checks a subtree and returns its depth. Counts its nodes and moves *next over its references.
static uint32_t check_subtree(const struct tree *f, uint32_t leaf_size, uint32_t index,
                              uint32_t *next, uint32_t *node_count)
{
    const struct bvh_build_node *node = &f->bvh.nodes[index];
    uint32_t depth = 1;
    ++*node_count;
    for (int k = 0; k < 3; k++)
        assert_true(node->lo[k] <= node->hi[k]);
    if (node->count > 0) {
        assert_true(node->count < leaf_size);
        assert_int_equal(node->left, *next); // leaves stand in the order of their references
        *next += node->count;
        return depth;
    }
    assert_true(node->left > index && node->left + 1 < f->bvh.node_count);
    for (uint32_t side = 0; side < 2; side++) {
        const uint32_t below = check_subtree(f, leaf_size, node->left + side, next, node_count);
        assert_true(is_inside(&f->bvh.nodes[node->left + side], node));
        depth = below + 1 > depth ? below + 1 : depth;
    }
    return depth;
}

// Whether a leaf that refers to a triangle holds a point of it.
static bool holds(const struct tree *f, uint32_t index, uint32_t triangle, const double *p)
{
    const struct bvh_build_node *node = &f->bvh.nodes[index];
    double largest = 0.0;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fmax(fabs(node->lo[k]), fabs(node->hi[k])));
    for (int k = 0; k < 3; k++)
        if (p[k] < node->lo[k] - MARGIN * largest || p[k] > node->hi[k] + MARGIN * largest)
            return false;
    if (node->count == 0)
        return holds(f, node->left, triangle, p) || holds(f, node->left + 1, triangle, p);
    for (uint32_t i = node->left; i < node->left + node->count; i++)
        if (f->refs[f->bvh.order[i]].triangle == triangle)
            return true;
    return false;
}

// Every point of every triangle that has references is where a ray finds it.
static void check_cover(const struct tree *f)
{
    uint64_t seed = 5;
    for (uint32_t i = 0; i < f->ref_count; i++) {
        const struct triangle *tri = &f->geometry.triangles[f->refs[i].triangle];
        const float4 a = f->geometry.vertices[tri->v0].pos_normal;
        const float4 b = f->geometry.vertices[tri->v1].pos_normal;
        const float4 c = f->geometry.vertices[tri->v2].pos_normal;
        for (int point = 0; point < POINTS; point++) {
            double u = random_unit(&seed);
            double v = random_unit(&seed);
            if (u + v > 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            const double w = 1.0 - u - v;
            const double p[3] = {w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y,
                                 w * a.z + u * b.z + v * c.z};
            assert_true(holds(f, 0, f->refs[i].triangle, p));
        }
    }
}

static void check_tree(struct geometry geometry, uint32_t leaf_size)
{
    struct tree f = tree_make(geometry, true, leaf_size);
    uint32_t next = 0;
    uint32_t node_count = 0;
    const uint32_t depth = check_subtree(&f, leaf_size, 0, &next, &node_count);
    assert_int_equal(next, f.bvh.ref_count);
    assert_int_equal(node_count, f.bvh.node_count);
    assert_int_equal(depth, f.bvh.depth);
    assert_true(depth < BVH_STACK_SIZE);
    assert_true(f.bvh.ref_count >= f.ref_count && f.bvh.ref_count <= 2 * f.ref_count);
    for (uint32_t i = 0; i < f.bvh.ref_count; i++)
        assert_true(f.bvh.order[i] < f.ref_count);
    check_cover(&f);
    tree_free(&f);
}

// Long thin triangles every which way: what spatial splits are for.
static struct geometry make_straws(uint64_t seed, uint32_t count)
{
    float *corners = malloc(9 * (size_t)count * sizeof(*corners));
    for (uint32_t i = 0; i < 9 * count; i++)
        corners[i] = (float)random_between(&seed, -10.0, 10.0);
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            corners[9 * i + 6 + (uint32_t)k] = corners[9 * i + (uint32_t)k] + 0.05f * (float)k;
    struct geometry geometry = make_geometry(corners, count);
    free(corners);
    return geometry;
}

static void every_point_of_every_triangle_is_in_a_leaf(void **state)
{
    (void)state;
    static const uint32_t leaf_sizes[] = {2, 3, 8, BVH_LEAF_MAX + 1};
    static const uint32_t counts[] = {1, 2, 3, 7, 8, 9, 100, 5000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        for (size_t j = 0; j < sizeof(leaf_sizes) / sizeof(leaf_sizes[0]); j++)
            check_tree(make_soup(i, counts[i], 10.0, 1.0), leaf_sizes[j]);
    check_tree(make_soup(1, 500, 1.0, 20.0), LEAF_SIZE);
    check_tree(make_straws(1, 1000), LEAF_SIZE);
    check_tree(make_straws(2, 1000), 2);
}

static void equal_triangles_are_parted(void **state)
{
    (void)state;
    float corners[9 * 1000];
    for (uint32_t i = 0; i < 9 * 1000; i++)
        corners[i] = (float)(i % 9 * i % 9);
    check_tree(make_geometry(corners, 1000), 2);
}

static void triangles_as_large_as_float_are_no_harm(void **state)
{
    (void)state;
    check_tree(make_soup(1, 300, 1e18, 1e18), LEAF_SIZE);
    check_tree(make_soup(1, 300, 1e-18, 1e-18), LEAF_SIZE);
}

static void splits_make_long_triangles_cheaper(void **state)
{
    (void)state;
    struct tree f = tree_make(make_straws(3, 3000), true, LEAF_SIZE);
    struct bvh whole;
    assert_int_equal(bvh_build(&whole, f.refs, f.ref_count, LEAF_SIZE), STATUS_OK);
    assert_true(f.bvh.ref_count > f.ref_count);
    assert_true(bvh_sah_cost(&f.bvh) < 0.9 * bvh_sah_cost(&whole));
    bvh_free(&whole);
    tree_free(&f);
}

static void no_references_give_the_empty_tree(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    struct bvh bvh;
    assert_int_equal(sbvh_build(&bvh, NULL, 0, &geometry, LEAF_SIZE), STATUS_OK);
    assert_int_equal(bvh.node_count, 0);
    bvh_free(&bvh);
}

static void the_tree_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    struct tree one = tree_make(make_straws(4, 20000), true, LEAF_SIZE);
    omp_set_num_threads(5);
    struct tree many = tree_make(make_straws(4, 20000), true, LEAF_SIZE);
    omp_set_num_threads(threads);
    assert_same_tree(&one.bvh, &many.bvh);
    tree_free(&many);
    tree_free(&one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_point_of_every_triangle_is_in_a_leaf),
        cmocka_unit_test(equal_triangles_are_parted),
        cmocka_unit_test(triangles_as_large_as_float_are_no_harm),
        cmocka_unit_test(splits_make_long_triangles_cheaper),
        cmocka_unit_test(no_references_give_the_empty_tree),
        cmocka_unit_test(the_tree_is_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
