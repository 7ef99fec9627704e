// The 4-wide BVH: that it is the tree it was made of, as kernels read it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "prep/bvh_quad.h"
#include "prep/sbvh.h"
#include "prep/woop.h"
#include "prep_support.h"

#define LEAF_SIZE 8

static const struct scene_material materials[2] = {{.name = "solid"},
                                                   {.name = "masked", .masked = true}};

// All that belongs to one tree.
struct fixture {
    struct geometry geometry;
    struct tri_ref *refs;
    uint32_t ref_count;
    struct bvh bvh;
    struct quad_bvh quad;
    uint32_t *seen;            // [triangle_count] times that a leaf names each
    uint32_t nodes, leaf_refs; // met on the way
};

static void build(struct fixture *out, struct geometry geometry, bool split)
{
    *out = (struct fixture){.geometry = geometry};
    for (uint32_t i = 0; i < geometry.triangle_count; i++)
        geometry.triangles[i].material = i % 3 == 0;
    assert_int_equal(presplit(&out->refs, &out->ref_count, &geometry, 0.0f), STATUS_OK);
    if (split)
        assert_int_equal(sbvh_build(&out->bvh, out->refs, out->ref_count, &geometry, LEAF_SIZE),
                         STATUS_OK);
    else
        assert_int_equal(bvh_build(&out->bvh, out->refs, out->ref_count, LEAF_SIZE), STATUS_OK);
    assert_int_equal(quad_bvh_pack(&out->quad, &out->bvh, out->refs, &geometry, materials),
                     STATUS_OK);
    out->seen = calloc(geometry.triangle_count + 1, sizeof(*out->seen));
}

static void release(struct fixture *f)
{
    free(f->seen);
    quad_bvh_free(&f->quad);
    bvh_free(&f->bvh);
    free(f->refs);
    geometry_free(&f->geometry);
}

// The box of a child as kernels decode it.
static void load_box(double *lo, double *hi, const struct quad_node *node, uint32_t child)
{
    const unsigned char *bytes = (const unsigned char *)node->planes;
    const float origin[3] = {node->grid.x, node->grid.y, node->grid.z};
    float scale[3] = {node->grid.w, 0.0f, 0.0f};
    memcpy(&scale[1], &node->planes[1].z, sizeof(scale[1]));
    memcpy(&scale[2], &node->planes[1].w, sizeof(scale[2]));
    for (int k = 0; k < 3; k++) {
        const double cell = ldexp((double)scale[k], -BYTE_PLANE_SHIFT);
        lo[k] = origin[k] + cell * bytes[8 * k + (int)child];
        hi[k] = origin[k] + cell * bytes[8 * k + 4 + (int)child];
    }
}

static int32_t word_of(const struct quad_node *node, uint32_t child)
{
    int32_t words[QUAD_CHILDREN];
    memcpy(words, &node->words, sizeof(words));
    return words[child];
}

// A box holds what lies in another one, with a little room for rounding.
static void assert_holds(const double *lo, const double *hi, const float *inner_lo,
                         const float *inner_hi)
{
    for (int k = 0; k < 3; k++) {
        assert_true(lo[k] < inner_lo[k]);
        assert_true(hi[k] > inner_hi[k]);
    }
}

// Finds the node of the build tree whose references a leaf has, if it is one: a leaf of the tree.
static const struct bvh_build_node *find_leaf(const struct fixture *f, uint32_t triangle)
{
    for (uint32_t i = 0; i < f->bvh.node_count; i++)
        for (uint32_t k = 0; k < f->bvh.nodes[i].count; k++)
            if (f->refs[f->bvh.order[f->bvh.nodes[i].left + k]].triangle == triangle)
                return &f->bvh.nodes[i];
    return NULL;
}

// A leaf's references name distinct triangles, with their rows. Where no triangle is split, its box
// holds their leaves of the build tree.
static void check_leaf(struct fixture *f, const double *lo, const double *hi, int32_t word,
                       bool split)
{
    const uint32_t first = (uint32_t)~word >> BVH_LEAF_BITS;
    const uint32_t count = (uint32_t)~word & BVH_LEAF_MAX;
    assert_int_equal(first, f->leaf_refs); // references stand in the order of the leaves
    f->leaf_refs += count;
    for (uint32_t i = first; i < first + count; i++) {
        const uint32_t triangle = f->quad.refs[i] & BVH_REF_TRIANGLE;
        const float4 *p[3];
        struct woop woop;
        for (uint32_t k = 0; k < 3; k++)
            p[k] = &f->geometry.vertices[3 * triangle + k].pos_normal;
        woop_build(&woop, &p[0]->x, &p[1]->x, &p[2]->x);
        assert_memory_equal(&f->quad.woop[i], &woop, sizeof(woop));
        assert_int_equal((f->quad.refs[i] & BVH_REF_ALPHA) != 0, triangle % 3 == 0);
        f->seen[triangle]++;
        for (uint32_t j = first; j < i; j++)
            assert_int_not_equal(f->quad.refs[j], f->quad.refs[i]);
        if (!split && f->geometry.triangle_count <= 500) {
            const struct bvh_build_node *leaf = find_leaf(f, triangle);
            assert_holds(lo, hi, leaf->lo, leaf->hi);
        }
    }
}

// Checks a node and what is below it. Returns the most that a traversal keeps on its stack.
static uint32_t check_node(struct fixture *f, uint32_t index, bool split)
{
    const struct quad_node *node = &f->quad.nodes[index];
    uint32_t children = 0;
    uint32_t most = 0;
    assert_int_equal(index, f->nodes); // depth first
    f->nodes++;
    for (uint32_t i = 0; i < QUAD_CHILDREN; i++) {
        const int32_t word = word_of(node, i);
        double lo[3], hi[3];
        load_box(lo, hi, node, i);
        if (word == QUAD_EMPTY) {
            for (int k = 0; k < 3; k++)
                assert_true(lo[k] > hi[k]);
            continue;
        }
        assert_int_equal(children, i); // those without a child come last
        children++;
        if (word < 0) {
            check_leaf(f, lo, hi, word, split);
            continue;
        }
        const uint32_t below = check_node(f, (uint32_t)word, split);
        most = below > most ? below : most;
    }
    return most + (children > 0 ? children - 1 : 0);
}

static void check_tree(struct geometry geometry, bool split)
{
    struct fixture f;
    build(&f, geometry, split);
    assert_true(check_node(&f, 0, split) < QUAD_STACK_SIZE);
    assert_int_equal(f.nodes, f.quad.node_count);
    assert_int_equal(f.leaf_refs, f.quad.ref_count);
    for (uint32_t i = 0; i < f.ref_count; i++)
        assert_true(f.seen[f.refs[i].triangle] >= 1);
    if (!split)
        for (uint32_t i = 0; i < f.ref_count; i++)
            assert_int_equal(f.seen[f.refs[i].triangle], 1);
    release(&f);
}

// ---- laws

static void every_triangle_is_in_a_leaf_with_its_rows(void **state)
{
    (void)state;
    static const uint32_t counts[] = {0, 1, 2, 3, 4, 5, 8, 17, 100, 5000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        for (int split = 0; split < 2; split++) {
            check_tree(make_soup(i, counts[i], 10.0, 1.0), split);
            check_tree(make_soup(i, counts[i], 1.0, 20.0), split);
        }
}

// Grids reach over what they must, wherever it is and whatever its size.
static void boxes_far_away_large_and_small_are_held(void **state)
{
    (void)state;
    struct geometry far = make_soup(1, 300, 1.0, 1.0);
    for (uint32_t i = 0; i < far.vertex_count; i++)
        far.vertices[i].pos_normal.x += 1e5f;
    check_tree(far, false);
    check_tree(make_soup(2, 300, 1e12, 1e12), false);
    check_tree(make_soup(3, 300, 1e-12, 1e-12), false);
    check_tree(make_soup(4, 300, 1e12, 1e-3), false);
}

static void equal_triangles_are_no_harm(void **state)
{
    (void)state;
    float corners[9 * 300];
    for (uint32_t i = 0; i < 9 * 300; i++)
        corners[i] = (float)(i % 9 * (i % 9));
    for (int split = 0; split < 2; split++)
        check_tree(make_geometry(corners, 300), split);
}

// Each plane parts only the largest few from all others.
static void deep_trees_fit_the_stack(void **state)
{
    (void)state;
    const uint32_t count = 4000;
    float *corners = malloc(9 * count * sizeof(*corners));
    for (uint32_t i = 0; i < 9 * count; i++)
        corners[i] = (float)exp2(60.0 - 120.0 * (i / 9) / count) * (1.0f + 0.1f * (float)(i % 7));
    for (int split = 0; split < 2; split++)
        check_tree(make_geometry(corners, count), split);
    free(corners);
}

static void trees_deeper_than_the_stack_are_a_limit(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    const struct bvh bvh = {.node_count = 1, .depth = BVH_STACK_SIZE + 1};
    struct quad_bvh quad;
    assert_int_equal(quad_bvh_pack(&quad, &bvh, NULL, &geometry, materials), STATUS_LIMIT);
}

// All triangles of a node in one plane: a grid without extent.
static void flat_scenes_are_held(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        struct geometry flat = make_soup(5, 300, 10.0, 1.0);
        for (uint32_t i = 0; i < flat.vertex_count; i++)
            (&flat.vertices[i].pos_normal.x)[axis] = axis == 0 ? 0.0f : 7.3f;
        check_tree(flat, false);
    }
}

static void scenes_beyond_a_grid_are_refused(void **state)
{
    (void)state;
    struct geometry geometry = make_soup(6, 20, 1e37, 1e30);
    struct tri_ref *refs;
    uint32_t ref_count;
    struct bvh bvh;
    struct quad_bvh quad;
    assert_int_equal(presplit(&refs, &ref_count, &geometry, 0.0f), STATUS_OK);
    assert_int_equal(bvh_build(&bvh, refs, ref_count, LEAF_SIZE), STATUS_OK);
    assert_int_equal(quad_bvh_pack(&quad, &bvh, refs, &geometry, materials), STATUS_LIMIT);
    bvh_free(&bvh);
    free(refs);
    geometry_free(&geometry);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_triangle_is_in_a_leaf_with_its_rows),
        cmocka_unit_test(boxes_far_away_large_and_small_are_held),
        cmocka_unit_test(equal_triangles_are_no_harm),
        cmocka_unit_test(deep_trees_fit_the_stack),
        cmocka_unit_test(trees_deeper_than_the_stack_are_a_limit),
        cmocka_unit_test(flat_scenes_are_held),
        cmocka_unit_test(scenes_beyond_a_grid_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
