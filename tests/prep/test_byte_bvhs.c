// The BVHs whose boxes are bytes, 4-wide and compressed 8-wide: that each is the tree it was made
// of, as kernels read it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "prep/bvh_compressed.h"
#include "prep/bvh_quad.h"
#include "prep/woop.h"
#include "tree_fixture.h"

#define LEAF_SIZE 8

static const struct scene_material materials[2] = {{.name = "solid"},
                                                   {.name = "masked", .masked = true}};

enum layout { QUAD, COMPRESSED, LAYOUTS };

// All that belongs to one tree.
struct fixture {
    enum layout layout;
    struct tree tree;
    struct quad_bvh quad;             // or
    struct compressed_bvh compressed; // the other is empty
    const struct woop *woop;          // of that layout
    const uint32_t *words;            // [leaf_ref_count] the same
    uint32_t node_count, leaf_ref_count;
    uint32_t *seen;            // [triangle_count] times that a leaf names each
    uint32_t nodes, leaf_refs; // met on the way
};

// A child as kernels decode it.
struct child {
    double lo[3], hi[3];
    bool is_there, is_leaf;
    uint32_t first, count; // leaf: its references
    uint32_t node;         // inner
};

static enum status pack(struct fixture *f)
{
    const struct tree *tree = &f->tree;
    if (f->layout == QUAD)
        return quad_bvh_pack(&f->quad, &tree->bvh, tree->refs, &tree->geometry, materials);
    return compressed_bvh_pack(&f->compressed, &tree->bvh, tree->refs, &tree->geometry, materials);
}

static void build(struct fixture *out, enum layout layout, struct geometry geometry, bool split)
{
    mask_every_third(&geometry);
    *out = (struct fixture){.layout = layout, .tree = tree_make(geometry, split, LEAF_SIZE)};
    assert_int_equal(pack(out), STATUS_OK);
    out->woop = layout == QUAD ? out->quad.woop : out->compressed.woop;
    out->words = layout == QUAD ? out->quad.refs : out->compressed.refs;
    out->node_count = layout == QUAD ? out->quad.node_count : out->compressed.node_count;
    out->leaf_ref_count = layout == QUAD ? out->quad.ref_count : out->compressed.ref_count;
    out->seen = calloc(geometry.triangle_count + 1, sizeof(*out->seen));
}

static void release(struct fixture *f)
{
    free(f->seen);
    compressed_bvh_free(&f->compressed);
    quad_bvh_free(&f->quad);
    tree_free(&f->tree);
}

static void load_quad(struct child *out, const struct quad_node *node, uint32_t child)
{
    const unsigned char *bytes = (const unsigned char *)node->planes;
    const float origin[3] = {node->grid.x, node->grid.y, node->grid.z};
    float scale[3] = {node->grid.w, 0.0f, 0.0f};
    int32_t words[QUAD_CHILDREN];
    memcpy(&scale[1], &node->planes[1].z, sizeof(scale[1]));
    memcpy(&scale[2], &node->planes[1].w, sizeof(scale[2]));
    memcpy(words, &node->words, sizeof(words));
    for (int k = 0; k < 3; k++) {
        const double cell = ldexp((double)scale[k], -BYTE_PLANE_SHIFT);
        out->lo[k] = (double)origin[k] + scale[k] + cell * bytes[8 * k + 2 * (int)child];
        out->hi[k] = (double)origin[k] + scale[k] + cell * bytes[8 * k + 2 * (int)child + 1];
    }
    out->is_there = words[child] != QUAD_EMPTY;
    out->is_leaf = words[child] < 0;
    out->first = (uint32_t)~words[child] >> BVH_LEAF_BITS;
    out->count = (uint32_t)~words[child] & BVH_LEAF_MAX;
    out->node = (uint32_t)words[child];
}

static void load_compressed(struct child *out, const struct compressed_node *node, uint32_t slot)
{
    const unsigned char *bytes = (const unsigned char *)node->planes;
    const unsigned char *exponents = (const unsigned char *)&node->head.w;
    const unsigned char *meta = (const unsigned char *)&node->links.z;
    const float origin[3] = {node->head.x, node->head.y, node->head.z};
    const uint32_t bits = meta[slot];
    for (int k = 0; k < 3; k++) {
        const double cell = ldexp(1.0, exponents[k] - 127 - BYTE_PLANE_SHIFT);
        const double first = origin[k] + ldexp(1.0, exponents[k] - 127);
        out->lo[k] = first + cell * bytes[16 * k + (int)slot];
        out->hi[k] = first + cell * bytes[16 * k + 8 + (int)slot];
    }
    out->is_there = bits != 0;
    out->is_leaf = (bits & 0x18u) != 0x18u;
    out->first = node->links.y + (bits & 31u);
    out->count = (uint32_t)__builtin_popcount(bits >> 5);
    assert_int_equal((bits >> 5) & ((bits >> 5) + 1u), 0); // 0, 1, 11 or 111
    assert_int_equal(out->is_there && !out->is_leaf, exponents[3] >> slot & 1);
    out->node = node->links.x + (uint32_t)__builtin_popcount(exponents[3] & ((1u << slot) - 1u));
    if (out->is_there && !out->is_leaf)
        assert_int_equal(bits, COMPRESSED_INNER | slot);
}

static void load_child(struct child *out, const struct fixture *f, uint32_t node, uint32_t child)
{
    if (f->layout == QUAD)
        load_quad(out, &f->quad.nodes[node], child);
    else
        load_compressed(out, &f->compressed.nodes[node], child);
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
    for (uint32_t i = 0; i < f->tree.bvh.node_count; i++)
        for (uint32_t k = 0; k < f->tree.bvh.nodes[i].count; k++)
            if (f->tree.refs[f->tree.bvh.order[f->tree.bvh.nodes[i].left + k]].triangle == triangle)
                return &f->tree.bvh.nodes[i];
    return NULL;
}

// The box of a leaf holds a whole triangle of it.
static void check_triangle(const struct fixture *f, const struct child *leaf, uint32_t triangle)
{
    float lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
        for (uint32_t corner = 0; corner < 3; corner++) {
            const float at = (&f->tree.geometry.vertices[3 * triangle + corner].pos_normal.x)[k];
            lo[k] = fminf(lo[k], at);
            hi[k] = fmaxf(hi[k], at);
        }
    }
    assert_holds(leaf->lo, leaf->hi, lo, hi);
}

// A leaf's references name distinct triangles, with their rows. Where no triangle is split, its box
// holds them; and their leaves of the build tree, unless those are halved.
static void check_leaf(struct fixture *f, const struct child *child, bool split)
{
    const uint32_t first = child->first;
    const uint32_t count = child->count;
    if (f->layout == QUAD)
        assert_int_equal(first, f->leaf_refs); // references stand in the order of the leaves
    else
        assert_in_range(count, 1, COMPRESSED_LEAF_REFS);
    f->leaf_refs += count;
    for (uint32_t i = first; i < first + count; i++) {
        const uint32_t triangle = f->words[i] & BVH_REF_TRIANGLE;
        const float4 *p[3];
        struct woop woop;
        for (uint32_t k = 0; k < 3; k++)
            p[k] = &f->tree.geometry.vertices[3 * triangle + k].pos_normal;
        woop_build(&woop, &p[0]->x, &p[1]->x, &p[2]->x);
        assert_memory_equal(&f->woop[i], &woop, sizeof(woop));
        assert_int_equal((f->words[i] & BVH_REF_ALPHA) != 0, triangle % 3 == 0);
        f->seen[triangle]++;
        for (uint32_t j = first; j < i; j++)
            assert_int_not_equal(f->words[j], f->words[i]);
        if (!split)
            check_triangle(f, child, triangle);
        if (f->layout == QUAD && !split && f->tree.geometry.triangle_count <= 500) {
            const struct bvh_build_node *leaf = find_leaf(f, triangle);
            assert_holds(child->lo, child->hi, leaf->lo, leaf->hi);
        }
    }
}

// How far a child's middle lies along the diagonal of a slot, from anywhere.
static double fit_of(const struct child *child, uint32_t slot)
{
    double fit = 0.0;
    for (uint32_t k = 0; k < 3; k++)
        fit += (slot >> k & 1u ? 0.5 : -0.5) * (child->lo[k] + child->hi[k]);
    return fit;
}

// No two slots of a compressed node can be exchanged and fit better, but for what boxes lose on
// their grid.
static void check_slots(const struct child *children)
{
    double cells = 0.0;
    for (uint32_t i = 0; i < COMPRESSED_CHILDREN; i++)
        for (int k = 0; k < 3 && children[i].is_there; k++)
            for (uint32_t j = 0; j < COMPRESSED_CHILDREN; j++)
                if (children[j].is_there)
                    cells = fmax(cells, (children[i].hi[k] - children[j].lo[k]) / 64.0);
    for (uint32_t i = 0; i < COMPRESSED_CHILDREN; i++)
        for (uint32_t j = 0; j < i; j++) {
            const bool both = children[i].is_there && children[j].is_there;
            if (!both)
                continue;
            const double now = fit_of(&children[i], i) + fit_of(&children[j], j);
            const double then = fit_of(&children[i], j) + fit_of(&children[j], i);
            assert_true(now >= then - 12.0 * cells);
        }
}

// Checks a node and what is below it. Returns the most that a traversal keeps on its stack.
static uint32_t check_node(struct fixture *f, uint32_t index, bool split)
{
    const uint32_t width = f->layout == QUAD ? QUAD_CHILDREN : COMPRESSED_CHILDREN;
    struct child children[COMPRESSED_CHILDREN];
    uint32_t count = 0;
    uint32_t most = 0;
    if (f->layout == QUAD)
        assert_int_equal(index, f->nodes); // depth first
    f->nodes++;
    for (uint32_t i = 0; i < width; i++) {
        struct child *child = &children[i];
        load_child(child, f, index, i);
        if (!child->is_there) {
            for (int k = 0; k < 3; k++)
                assert_true(child->lo[k] > child->hi[k]);
            continue;
        }
        if (f->layout == QUAD)
            assert_int_equal(count, i); // those without a child come last
        count++;
        if (child->is_leaf) {
            check_leaf(f, child, split);
            continue;
        }
        assert_in_range(child->node, 1, f->node_count - 1);
        const uint32_t below = check_node(f, child->node, split);
        most = below > most ? below : most;
    }
    if (f->layout == COMPRESSED) {
        check_slots(children);
        return most + 2; // the others, and references
    }
    return most + (count > 0 ? count - 1 : 0);
}

static void check_layout(enum layout layout, struct geometry geometry, bool split)
{
    struct fixture f;
    build(&f, layout, geometry, split);
    const uint32_t stack = check_node(&f, 0, split);
    assert_true(stack < (layout == QUAD ? QUAD_STACK_SIZE : COMPRESSED_STACK_SIZE));
    assert_int_equal(f.nodes, f.node_count);
    assert_int_equal(f.leaf_refs, f.leaf_ref_count);
    assert_all_seen(&f.tree, f.seen, split);
    release(&f);
}

static void *copy_of(const void *bytes, size_t size)
{
    void *copy = malloc(size + 1);
    memcpy(copy, bytes, size);
    return copy;
}

// Checks all layouts. Takes the geometry over.
static void check_tree(struct geometry geometry, bool split)
{
    for (enum layout layout = 0; layout < LAYOUTS; layout++) {
        struct geometry copy = geometry;
        copy.vertices = copy_of(geometry.vertices, geometry.vertex_count * sizeof(*copy.vertices));
        copy.triangles =
            copy_of(geometry.triangles, geometry.triangle_count * sizeof(*copy.triangles));
        check_layout(layout, copy, split);
    }
    geometry_free(&geometry);
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
    struct quad_bvh quad;
    struct compressed_bvh compressed;
    assert_int_equal(quad_bvh_pack(&quad, &bvh, NULL, &geometry, materials), STATUS_LIMIT);
    assert_int_equal(compressed_bvh_pack(&compressed, &bvh, NULL, &geometry, materials),
                     STATUS_LIMIT);
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
    struct tree tree = tree_make(make_soup(6, 20, 1e37, 1e30), false, LEAF_SIZE);
    struct quad_bvh quad;
    struct compressed_bvh compressed;
    assert_int_equal(quad_bvh_pack(&quad, &tree.bvh, tree.refs, &tree.geometry, materials),
                     STATUS_LIMIT);
    assert_int_equal(
        compressed_bvh_pack(&compressed, &tree.bvh, tree.refs, &tree.geometry, materials),
        STATUS_LIMIT);
    tree_free(&tree);
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
