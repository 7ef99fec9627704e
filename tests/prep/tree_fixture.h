/**
 * @file
 * What tests of trees share: a tree with all that it was made of, and triangles that make trees
 * awkward.
 */
#ifndef TESTS_PREP_TREE_FIXTURE_H
#define TESTS_PREP_TREE_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "prep/sbvh.h"
#include "prep_support.h"

/** A geometry with its references and the tree over them. */
struct tree {
    struct geometry geometry;
    struct tri_ref *refs;
    uint32_t ref_count;
    struct bvh bvh;
};

/** Builds a tree, with spatial splits or without, and takes the geometry over; for tree_free(). */
static inline struct tree tree_make(struct geometry geometry, bool split, uint32_t leaf_size)
{
    struct tree t = {.geometry = geometry};
    assert_int_equal(presplit(&t.refs, &t.ref_count, &t.geometry, 0.0f), STATUS_OK);
    if (split)
        assert_int_equal(sbvh_build(&t.bvh, t.refs, t.ref_count, &t.geometry, leaf_size),
                         STATUS_OK);
    else
        assert_int_equal(bvh_build(&t.bvh, t.refs, t.ref_count, leaf_size), STATUS_OK);
    return t;
}

static inline void tree_free(struct tree *tree)
{
    bvh_free(&tree->bvh);
    free(tree->refs);
    geometry_free(&tree->geometry);
}

/** Two trees are the same, bit by bit. */
static inline void assert_same_tree(const struct bvh *a, const struct bvh *b)
{
    assert_int_equal(a->node_count, b->node_count);
    assert_int_equal(a->ref_count, b->ref_count);
    assert_memory_equal(a->nodes, b->nodes, a->node_count * sizeof(*a->nodes));
    assert_memory_equal(a->order, b->order, a->ref_count * sizeof(*a->order));
}

/** Material 1 on every third triangle, from the first on, and 0 on the others. */
static inline void mask_every_third(struct geometry *geometry)
{
    for (uint32_t i = 0; i < geometry->triangle_count; i++)
        geometry->triangles[i].material = i % 3 == 0;
}

/** Every triangle is in a leaf, in one alone if none is split: `seen` are the times that leaves
 * name each. */
static inline void assert_all_seen(const struct tree *tree, const uint32_t *seen, bool split)
{
    for (uint32_t i = 0; i < tree->ref_count; i++) {
        const uint32_t times = seen[tree->refs[i].triangle];
        assert_true(split ? times >= 1 : times == 1);
    }
}

/** 300 times the same triangle. */
static inline struct geometry make_equal_triangles(void)
{
    float corners[9 * 300];
    for (uint32_t i = 0; i < 9 * 300; i++)
        corners[i] = (float)(i % 9 * (i % 9));
    return make_geometry(corners, 300);
}

/** Triangles of which each plane parts only the largest few from all others. */
static inline struct geometry make_shrinking_triangles(void)
{
    const uint32_t count = 4000;
    float *corners = malloc(9 * count * sizeof(*corners));
    for (uint32_t i = 0; i < 9 * count; i++)
        corners[i] = (float)exp2(60.0 - 120.0 * (i / 9) / count) * (1.0f + 0.1f * (float)(i % 7));
    const struct geometry geometry = make_geometry(corners, count);
    free(corners);
    return geometry;
}

#endif
