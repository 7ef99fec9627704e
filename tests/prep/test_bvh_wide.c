// The wide BVH: that it is the tree it was made of, as kernels read it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "prep/bvh_wide.h"
#include "prep/woop.h"
#include "tree_fixture.h"

#define LEAF_SIZE 8

static const struct scene_material materials[2] = {{.name = "solid"},
                                                   {.name = "masked", .masked = true}};

// All that belongs to one wide tree.
struct fixture {
    struct tree tree;
    struct wide_bvh wide;
    uint32_t *seen;         // [triangle_count] times that a leaf names each
    uint32_t nodes, blocks; // met on the way
};

static void build(struct fixture *out, struct geometry geometry, bool split)
{
    mask_every_third(&geometry);
    *out = (struct fixture){.tree = tree_make(geometry, split, LEAF_SIZE)};
    const struct tree *tree = &out->tree;
    assert_int_equal(wide_bvh_pack(&out->wide, &tree->bvh, tree->refs, &tree->geometry, materials),
                     STATUS_OK);
    out->seen = calloc(geometry.triangle_count + 1, sizeof(*out->seen));
}

static void release(struct fixture *f)
{
    free(f->seen);
    wide_bvh_free(&f->wide);
    tree_free(&f->tree);
}

static float value(const struct wide_node *node, uint32_t row, uint32_t child)
{
    return ((const float *)node->rows)[row * WIDE_CHILDREN + child];
}

static int32_t word_of(const struct wide_node *node, uint32_t child)
{
    int32_t word;
    const float bits = value(node, 6, child);
    memcpy(&word, &bits, sizeof(word));
    return word;
}

// A leaf's lanes hold distinct triangles with their own rows; those without one are 0.
static void check_leaf(struct fixture *f, int32_t word)
{
    const uint32_t first = (uint32_t)~word >> WIDE_LEAF_BITS;
    const uint32_t count = (uint32_t)~word & ((1u << WIDE_LEAF_BITS) - 1u);
    assert_int_equal(first, f->blocks); // blocks stand in the order of the leaves
    f->blocks += count;
    for (uint32_t i = first * WIDE_BLOCK; i < (first + count) * WIDE_BLOCK; i++) {
        const float *block = (const float *)f->wide.blocks[i / WIDE_BLOCK].rows;
        const uint32_t ref = f->wide.refs[i];
        struct woop woop = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
        if (ref != WIDE_NO_REF) {
            const uint32_t triangle = ref & BVH_REF_TRIANGLE;
            const float4 *p[3];
            for (uint32_t k = 0; k < 3; k++)
                p[k] = &f->tree.geometry.vertices[3 * triangle + k].pos_normal;
            woop_build(&woop, &p[0]->x, &p[1]->x, &p[2]->x);
            assert_int_equal((ref & BVH_REF_ALPHA) != 0, triangle % 3 == 0);
            f->seen[triangle]++;
            for (uint32_t j = first * WIDE_BLOCK; j < i; j++)
                assert_int_not_equal(f->wide.refs[j], ref);
        }
        for (uint32_t k = 0; k < 12; k++)
            assert_true(block[k * WIDE_BLOCK + i % WIDE_BLOCK] == ((const float *)&woop)[k]);
    }
}

// Checks a node and what is below it. Returns the most that a traversal keeps on its stack.
static uint32_t check_node(struct fixture *f, uint32_t index)
{
    const struct wide_node *node = &f->wide.nodes[index];
    uint32_t children = 0;
    uint32_t most = 0;
    assert_int_equal(index, f->nodes); // depth first
    f->nodes++;
    for (uint32_t i = 0; i < WIDE_CHILDREN; i++) {
        const int32_t word = word_of(node, i);
        if (word == WIDE_EMPTY) {
            assert_true(value(node, 0, i) > value(node, 1, i));
            continue;
        }
        assert_int_equal(children, i); // those without a child come last
        children++;
        for (uint32_t k = 0; k < 6; k += 2)
            assert_true(value(node, k, i) <= value(node, k + 1, i));
        if (word < 0) {
            check_leaf(f, word);
            continue;
        }
        const struct wide_node *child = &f->wide.nodes[word];
        for (uint32_t j = 0; j < WIDE_CHILDREN && word_of(child, j) != WIDE_EMPTY; j++)
            for (uint32_t k = 0; k < 6; k += 2) {
                assert_true(value(child, k, j) >= value(node, k, i));
                assert_true(value(child, k + 1, j) <= value(node, k + 1, i));
            }
        const uint32_t below = check_node(f, (uint32_t)word);
        most = below > most ? below : most;
    }
    return most + (children > 0 ? children - 1 : 0);
}

static void check_tree(struct geometry geometry, bool split)
{
    struct fixture f;
    build(&f, geometry, split);
    assert_true(check_node(&f, 0) <= WIDE_STACK_SIZE);
    assert_int_equal(f.nodes, f.wide.node_count);
    assert_int_equal(f.blocks, f.wide.block_count);
    assert_all_seen(&f.tree, f.seen, split);
    release(&f);
}

static void every_triangle_is_in_a_leaf_with_its_rows(void **state)
{
    (void)state;
    static const uint32_t counts[] = {0, 1, 2, 3, 4, 5, 8, 17, 100, 5000};
    for (int split = 0; split < 2; split++) {
        for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
            check_tree(make_soup(i, counts[i], 10.0, 1.0), split);
        check_tree(make_soup(3, 2000, 1.0, 10.0), split);
    }
}

static void equal_triangles_are_no_harm(void **state)
{
    (void)state;
    for (int split = 0; split < 2; split++)
        check_tree(make_equal_triangles(), split);
}

static void deep_trees_fit_the_stack(void **state)
{
    (void)state;
    for (int split = 0; split < 2; split++)
        check_tree(make_shrinking_triangles(), split);
}

static void trees_deeper_than_the_stack_are_a_limit(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    const struct bvh bvh = {.node_count = 1, .depth = BVH_STACK_SIZE + 1};
    struct wide_bvh wide;
    assert_int_equal(wide_bvh_pack(&wide, &bvh, NULL, &geometry, materials), STATUS_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_triangle_is_in_a_leaf_with_its_rows),
        cmocka_unit_test(equal_triangles_are_no_harm),
        cmocka_unit_test(deep_trees_fit_the_stack),
        cmocka_unit_test(trees_deeper_than_the_stack_are_a_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
