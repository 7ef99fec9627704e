// Rooms with many lights against their references.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "reference.h"

#define ROOMS "manylights/rooms_"

// clang-format off
static const struct reference references[] = {
    {"rooms_100_d2", ROOMS "100.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00166, NULL},
    {"rooms_100_range_d2", ROOMS "100_range.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00126, NULL},
    {"rooms_1000_d2", ROOMS "1000.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00268, NULL},
    {"rooms_1000_range_d2", ROOMS "1000_range.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00194, NULL},
    {"rooms_10000_d2", ROOMS "10000.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00414, NULL},
    {"rooms_10000_range_d2", ROOMS "10000_range.gltf", 2, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00259, NULL},
};
// clang-format on

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[0]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[1]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[2]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[3]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[4]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[5]),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
