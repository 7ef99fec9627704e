// Sibenik with five lights against its references.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "reference.h"

#define SIBENIK "sibenik/sibenik_5lights_diffuse.gltf"

// clang-format off
// The two nearest capitals on the right: their inlays lie in one plane with the stone under them,
// so which is seen is arbitrary, and their interpolated normals at sharp edges follow another rule
// in the reference.
#define CAPITALS {{16, 1, 19, 3}, {13, 4, 14, 5}}

static const struct reference references[] = {
    {"sibenik_d1", SIBENIK, 1, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.000244, CAPITALS},
    {"sibenik_d5", SIBENIK, 5, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00137, CAPITALS},
    {"sibenik_E_d5", SIBENIK, 5, LK_IRRADIANCE, LK_BRDF_GLTF, 4, 0.00714, CAPITALS},
};
// clang-format on

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[0]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[1]),
        cmocka_unit_test_prestate(image_agrees_with_its_reference, (void *)&references[2]),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
