// Packed unit vectors come back within the error that the header states.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "prep/prep_support.h"
#include "shared/oct.h"

#define COUNT     2000000
#define MAX_ERROR 0.004 // degrees; the header says 0.0037

static double error_degrees(const double *v)
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const float4 n = oct_unpack(
        oct_pack((float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length)));

    // By the cross product, which is exact for small angles.
    const double x = v[1] * n.z - v[2] * n.y;
    const double y = v[2] * n.x - v[0] * n.z;
    const double z = v[0] * n.y - v[1] * n.x;
    const double along = v[0] * n.x + v[1] * n.y + v[2] * n.z;
    return atan2(sqrt(x * x + y * y + z * z), along) * 180.0 / acos(-1.0);
}

static void directions_come_back(void **state)
{
    (void)state;
    uint64_t seed = 1;
    double worst = 0.0;
    for (int i = 0; i < COUNT; i++) {
        const double v[3] = {random_between(&seed, -1.0, 1.0), random_between(&seed, -1.0, 1.0),
                             random_between(&seed, -1.0, 1.0)};
        worst = fmax(worst, error_degrees(v));
    }
    assert_true(worst < MAX_ERROR);
    assert_true(worst > MAX_ERROR / 2.0); // else the header promises too little
}

static void axes_and_edges_come_back(void **state)
{
    (void)state;
    for (int i = 0; i < 27; i++) {
        const double v[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        if (i == 13)
            continue; // no direction
        assert_true(error_degrees(v) < MAX_ERROR);
        if (fabs(v[0]) + fabs(v[1]) + fabs(v[2]) == 1.0)
            assert_true(error_degrees(v) == 0.0);
    }
}

static void folded_edges_come_back(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int i = 0; i < COUNT / 10; i++) {
        double v[3] = {random_between(&seed, -1.0, 1.0), random_between(&seed, -1.0, 1.0),
                       random_between(&seed, -1.0, 1.0)};
        v[i % 3] = (i & 1 ? 1e-6 : -1e-6) * (i % 7);
        assert_true(error_degrees(v) < MAX_ERROR);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_come_back),
        cmocka_unit_test(axes_and_edges_come_back),
        cmocka_unit_test(folded_edges_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
