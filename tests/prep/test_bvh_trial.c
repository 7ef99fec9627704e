// Trial rays: that what is counted is what a tree costs.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <omp.h>

#include "prep/bvh_trial.h"
#include "prep_support.h"

// The work of rays through the thesis's tree of a geometry. Takes it over.
static double try_tree(struct geometry geometry, uint32_t leaf_size)
{
    struct tri_ref *refs;
    uint32_t ref_count;
    struct bvh bvh;
    double work;
    assert_int_equal(presplit(&refs, &ref_count, &geometry, 0.0f), STATUS_OK);
    assert_int_equal(bvh_build(&bvh, refs, ref_count, leaf_size), STATUS_OK);
    assert_int_equal(bvh_trial(&work, &bvh, refs, &geometry), STATUS_OK);
    bvh_free(&bvh);
    free(refs);
    geometry_free(&geometry);
    return work;
}

// ---- laws

static void every_ray_tests_all_of_a_single_leaf(void **state)
{
    (void)state;
    for (uint32_t count = 1; count < 8; count++)
        assert_true(try_tree(make_soup(count, count, 1.0, 1.0), 8) == count);
}

static void the_empty_tree_costs_nothing(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    const struct bvh bvh = {0};
    double work = 1.0;
    assert_int_equal(bvh_trial(&work, &bvh, NULL, &geometry), STATUS_OK);
    assert_true(work == 0.0);
}

// Two heaps far apart: a ray that leaves one visits the root, and what is in that heap, but for few
// that fly into the other one.
static void rays_do_not_look_into_what_they_miss(void **state)
{
    (void)state;
    static float corners[9 * 400];
    uint64_t seed = 3;
    for (uint32_t i = 0; i < 9 * 400; i++)
        corners[i] = (float)random_unit(&seed) + (i < 9 * 200 ? 0.0f : 1000.0f);
    const double one = try_tree(make_geometry(corners, 200), 2);
    const double other = try_tree(make_geometry(corners + 9 * 200, 200), 2);
    const double both = try_tree(make_geometry(corners, 400), 2);
    assert_true(both > 0.9 * (one + other) / 2.0 && both < 1.1 * (one + other) / 2.0 + 2.0);
}

// A leaf of all triangles costs what there are.
static void trees_are_cheaper_than_none(void **state)
{
    (void)state;
    assert_true(try_tree(make_soup(1, 31, 10.0, 0.1), 32) == 31.0);
    assert_true(try_tree(make_soup(1, 31, 10.0, 0.1), 2) < 15.0);
}

static void the_work_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    const double one = try_tree(make_soup(4, 2000, 1.0, 0.2), 8);
    omp_set_num_threads(5);
    const double many = try_tree(make_soup(4, 2000, 1.0, 0.2), 8);
    omp_set_num_threads(threads);
    assert_true(one == many);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_ray_tests_all_of_a_single_leaf),
        cmocka_unit_test(the_empty_tree_costs_nothing),
        cmocka_unit_test(rays_do_not_look_into_what_they_miss),
        cmocka_unit_test(trees_are_cheaper_than_none),
        cmocka_unit_test(the_work_is_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
