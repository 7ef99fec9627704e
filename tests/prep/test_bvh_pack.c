// The packed BVH, walked here as kernels walk it, against brute force in double precision.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "prep/bvh_pack.h"
#include "prep/bvh_quad.h"
#include "prep_support.h"

#define TRIANGLES 3000
#define RAYS      2000
#define LEAF_SIZE 8
#define EPSILON   1e-5 // relative error of t that Woop's rows in float leave, with some room
#define EDGE      1e-4 // weights nearer to an edge than this may be hit or missed

// All that belongs to one packed tree.
struct fixture {
    struct geometry geometry;
    struct tri_ref *refs;
    uint32_t ref_count;
    struct bvh bvh;
    struct packed_bvh packed;
};

static const struct scene_material materials[2] = {{.name = "solid"},
                                                   {.name = "masked", .masked = true}};

static void build(struct fixture *out, struct geometry geometry, float threshold)
{
    out->geometry = geometry;
    for (uint32_t i = 0; i < geometry.triangle_count; i++)
        geometry.triangles[i].material = i % 3 == 0;
    assert_int_equal(presplit(&out->refs, &out->ref_count, &geometry, threshold), STATUS_OK);
    assert_int_equal(bvh_build(&out->bvh, out->refs, out->ref_count, LEAF_SIZE), STATUS_OK);
    assert_int_equal(bvh_pack(&out->packed, &out->bvh, out->refs, &geometry, materials), STATUS_OK);
}

static void release(struct fixture *fixture)
{
    packed_bvh_free(&fixture->packed);
    bvh_free(&fixture->bvh);
    free(fixture->refs);
    geometry_free(&fixture->geometry);
}

static int32_t child_word(const struct bvh_node *node, int side)
{
    int32_t word;
    memcpy(&word, side == 0 ? &node->row3.x : &node->row3.y, sizeof(word));
    return word;
}

static void child_box(float *lo, float *hi, const struct bvh_node *node, int side)
{
    const float4 xy = side == 0 ? node->row0 : node->row1;
    lo[0] = xy.x;
    hi[0] = xy.y;
    lo[1] = xy.z;
    hi[1] = xy.w;
    lo[2] = side == 0 ? node->row2.x : node->row2.z;
    hi[2] = side == 0 ? node->row2.y : node->row2.w;
}

// The slab test in float.
static bool meets(const float *lo, const float *hi, const float *org, const float *dir, float tmax)
{
    float enter = 0.0f;
    float leave = tmax;
    for (int k = 0; k < 3; k++) {
        const float a = (lo[k] - org[k]) / dir[k];
        const float b = (hi[k] - org[k]) / dir[k];
        enter = fmaxf(enter, fminf(a, b));
        leave = fminf(leave, fmaxf(a, b));
    }
    return enter <= leave;
}

static float apply(float4 row, const float *p, float w)
{
    return row.x * p[0] + row.y * p[1] + row.z * p[2] + row.w * w;
}

// Walks the tree for the nearest hit. Returns its triangle or -1.
static int64_t trace(float *t, const struct packed_bvh *packed, const float *org, const float *dir)
{
    int32_t stack[BVH_STACK_SIZE];
    uint32_t top = 0;
    int64_t nearest = -1;
    *t = FLT_MAX;
    stack[top++] = 0;
    while (top > 0) {
        const int32_t word = stack[--top];
        if (word >= 0) {
            const struct bvh_node *node = &packed->nodes[word];
            for (int side = 0; side < 2; side++) {
                float lo[3], hi[3];
                child_box(lo, hi, node, side);
                if (meets(lo, hi, org, dir, *t)) {
                    assert_true(top < BVH_STACK_SIZE);
                    stack[top++] = child_word(node, side);
                }
            }
            continue;
        }
        const uint32_t first = (uint32_t)~word >> BVH_LEAF_BITS;
        const uint32_t count = (uint32_t)~word & BVH_LEAF_MAX;
        for (uint32_t i = first; i < first + count; i++) {
            const struct woop *woop = &packed->woop[i];
            const float hit = -apply(woop->row_w, org, 1.0f) / apply(woop->row_w, dir, 0.0f);
            const float p[3] = {org[0] + hit * dir[0], org[1] + hit * dir[1],
                                org[2] + hit * dir[2]};
            const float u = apply(woop->row_u, p, 1.0f);
            const float v = apply(woop->row_v, p, 1.0f);
            if (hit > 0.0f && hit < *t && u >= 0.0f && v >= 0.0f && u + v <= 1.0f) {
                *t = hit;
                nearest = packed->refs[i] & BVH_REF_TRIANGLE;
            }
        }
    }
    return nearest;
}

// Finds the nearest hit of all triangles. `slack` widens them (or narrows them, if negative).
static double brute_force(const struct geometry *geometry, const float *org, const float *dir,
                          double slack)
{
    const double wide_org[3] = {org[0], org[1], org[2]};
    const double wide_dir[3] = {dir[0], dir[1], dir[2]};
    double nearest = INFINITY;
    for (uint32_t i = 0; i < geometry->triangle_count; i++) {
        double corners[3][3], hit[3];
        for (uint32_t j = 0; j < 3; j++) {
            const float4 row = geometry->vertices[3 * i + j].pos_normal;
            corners[j][0] = row.x;
            corners[j][1] = row.y;
            corners[j][2] = row.z;
        }
        if (moeller_trumbore(hit, wide_org, wide_dir, corners) && hit[0] > 0.0 &&
            hit[0] < nearest && hit[1] >= -slack && hit[2] >= -slack &&
            hit[1] + hit[2] <= 1 + slack)
            nearest = hit[0];
    }
    return nearest;
}

static void check_rays(const struct fixture *fixture, uint64_t seed)
{
    int hits = 0;
    for (int i = 0; i < RAYS; i++) {
        float org[3], dir[3], t;
        for (int k = 0; k < 3; k++) {
            org[k] = (float)random_between(&seed, -10.0, 10.0);
            dir[k] = (float)random_between(&seed, -1.0, 1.0);
        }
        const int64_t triangle = trace(&t, &fixture->packed, org, dir);
        const double widest = brute_force(&fixture->geometry, org, dir, EDGE);
        const double narrowest = brute_force(&fixture->geometry, org, dir, -EDGE);
        if (triangle < 0) {
            assert_true(isinf(narrowest));
            continue;
        }
        assert_true(t >= widest * (1.0 - EPSILON) - EPSILON);
        assert_true(t <= narrowest * (1.0 + EPSILON) + EPSILON);
        hits++;
    }
    assert_in_range(hits, RAYS / 10, RAYS);
}

static void trace_agrees_with_brute_force(void **state)
{
    (void)state;
    struct fixture fixture;
    build(&fixture, make_soup(1, TRIANGLES, 8.0, 1.0), 0.0f);
    check_rays(&fixture, 2);
    release(&fixture);
}

static void trace_agrees_with_brute_force_after_splitting(void **state)
{
    (void)state;
    struct fixture fixture;
    build(&fixture, make_soup(3, TRIANGLES / 10, 8.0, 8.0), 1.0f);
    assert_true(fixture.ref_count > TRIANGLES);
    check_rays(&fixture, 4);
    release(&fixture);
}

static void references_name_their_triangle_and_mask(void **state)
{
    (void)state;
    struct fixture fixture;
    build(&fixture, make_soup(5, TRIANGLES, 8.0, 1.0), 2.0f);
    assert_int_equal(fixture.packed.ref_count, fixture.ref_count);
    for (uint32_t i = 0; i < fixture.ref_count; i++) {
        const uint32_t word = fixture.packed.refs[i];
        const uint32_t triangle = fixture.refs[fixture.bvh.order[i]].triangle;
        assert_int_equal(word & BVH_REF_TRIANGLE, triangle);
        assert_int_equal((word & BVH_REF_ALPHA) != 0, triangle % 3 == 0);
    }
    release(&fixture);
}

// Checks that a node's children hold the build tree's, depth first, and counts nodes.
static void check_boxes(const struct fixture *fixture, int32_t packed_index, uint32_t build_index,
                        int32_t *next)
{
    const struct bvh_node *node = &fixture->packed.nodes[packed_index];
    assert_int_equal(packed_index, *next);
    ++*next;
    for (int side = 0; side < 2; side++) {
        const uint32_t index = fixture->bvh.nodes[build_index].left + (uint32_t)side;
        const struct bvh_build_node *child = &fixture->bvh.nodes[index];
        const int32_t word = child_word(node, side);
        float lo[3], hi[3];
        child_box(lo, hi, node, side);
        for (int k = 0; k < 3; k++)
            assert_true(lo[k] < child->lo[k] && hi[k] > child->hi[k]);
        if (child->count > 0)
            assert_int_equal(~word, child->left << BVH_LEAF_BITS | child->count);
        else
            check_boxes(fixture, word, index, next);
    }
}

static void packed_boxes_hold_the_tree_depth_first(void **state)
{
    (void)state;
    struct fixture fixture;
    int32_t next = 0;
    build(&fixture, make_soup(6, TRIANGLES, 8.0, 1.0), 0.0f);
    check_boxes(&fixture, 0, 0, &next);
    assert_int_equal(next, fixture.packed.node_count);
    release(&fixture);
}

// Over the triangles of the 4-wide layout, leaves have at least those of the tree's.
static void check_leaves_over(const struct fixture *fixture, const struct packed_bvh *over,
                              const struct quad_bvh *quad, int32_t packed_index,
                              uint32_t build_index)
{
    for (int side = 0; side < 2; side++) {
        const uint32_t index = fixture->bvh.nodes[build_index].left + (uint32_t)side;
        const struct bvh_build_node *child = &fixture->bvh.nodes[index];
        const int32_t word = child_word(&over->nodes[packed_index], side);
        if (child->count == 0) {
            check_leaves_over(fixture, over, quad, word, index);
            continue;
        }
        const uint32_t first = (uint32_t)~word >> BVH_LEAF_BITS;
        const uint32_t end = first + ((uint32_t)~word & BVH_LEAF_MAX);
        assert_true(end <= quad->ref_count && end - first >= 1);
        for (uint32_t k = 0; k < child->count; k++) {
            const uint32_t ref = fixture->packed.refs[child->left + k];
            uint32_t i = first;
            while (i < end && quad->refs[i] != ref)
                i++;
            assert_true(i < end);
        }
    }
}

static void leaves_over_another_layout_have_their_triangles(void **state)
{
    (void)state;
    for (int split = 0; split < 2; split++) {
        struct fixture fixture;
        struct packed_bvh over;
        struct quad_bvh quad;
        build(&fixture, make_soup(7, TRIANGLES, 8.0, 4.0), split ? 1.0f : 0.0f);
        assert_int_equal(
            quad_bvh_pack(&quad, &fixture.bvh, fixture.refs, &fixture.geometry, materials),
            STATUS_OK);
        assert_true(!split || quad.ref_count < fixture.packed.ref_count); // some stand once
        assert_int_equal(bvh_pack_over(&over, &fixture.bvh, quad.places), STATUS_OK);
        assert_int_equal(over.node_count, fixture.packed.node_count);
        assert_null(over.woop);
        check_leaves_over(&fixture, &over, &quad, 0, 0);
        packed_bvh_free(&over);
        quad_bvh_free(&quad);
        release(&fixture);
    }
}

static void small_scenes_have_a_root(void **state)
{
    (void)state;
    static const float corners[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
    static const float org[3] = {0.01f, 0.02f, -3.0f};
    static const float dir[3] = {1e-3f, 1e-3f, 1.0f};
    for (uint32_t count = 0; count < 2; count++) {
        struct fixture fixture;
        float t;
        build(&fixture, make_geometry(corners, count), 0.0f);
        assert_int_equal(fixture.packed.node_count, 1);
        assert_int_equal(trace(&t, &fixture.packed, org, dir), (int)count - 1);
        if (count == 1)
            assert_true(fabs(t - 3.0) < EPSILON);

        // Every number is finite and the empty leaves are empty.
        for (int side = (int)count; side < 2; side++) {
            float lo[3], hi[3];
            child_box(lo, hi, &fixture.packed.nodes[0], side);
            assert_int_equal(child_word(&fixture.packed.nodes[0], side), ~0);
            for (int k = 0; k < 3; k++)
                assert_true(isfinite(lo[k]) && isfinite(hi[k]));
        }
        release(&fixture);
    }
}

static void trees_deeper_than_the_stack_are_a_limit(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    const struct bvh bvh = {.node_count = 1, .depth = BVH_STACK_SIZE + 1};
    struct packed_bvh packed;
    assert_int_equal(bvh_pack(&packed, &bvh, NULL, &geometry, materials), STATUS_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trace_agrees_with_brute_force),
        cmocka_unit_test(trace_agrees_with_brute_force_after_splitting),
        cmocka_unit_test(references_name_their_triangle_and_mask),
        cmocka_unit_test(packed_boxes_hold_the_tree_depth_first),
        cmocka_unit_test(leaves_over_another_layout_have_their_triangles),
        cmocka_unit_test(small_scenes_have_a_root),
        cmocka_unit_test(trees_deeper_than_the_stack_are_a_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
