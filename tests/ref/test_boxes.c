// The Cornell box and the scenes of single effects against their references.

#include "reference.h"

#define CORNELL "cornell/cornell.gltf"
#define SPHERES "cornell/cornell_spheres.gltf"
#define PLANE   "units/plane.gltf"
#define SPOT    "units/spot.gltf"
#define MIRROR  "units/mirror.gltf"

// Variance is measured on the Cornell box's irradiance: of its radiance, nine tenths of the
// variance lie in the hundred pixels of the lamp's outline, too few to measure it by.
#define VARIANCE_REFERENCE 2

// clang-format off
static const struct reference references[] = {
    {"cornell_d1", CORNELL, 1, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.00032, NULL},
    {"cornell_d5", CORNELL, 5, LK_RADIANCE, LK_BRDF_GLTF, 4, 0.000428, NULL},
    {"cornell_E_d5", CORNELL, 5, LK_IRRADIANCE, LK_BRDF_GLTF, 4, 0.0019, NULL},
    {"cornell_spheres_d5", SPHERES, 5, LK_RADIANCE, LK_BRDF_GLTF, 8, 0.000456, NULL},
    {"units_plane_d1", PLANE, 1, LK_RADIANCE, LK_BRDF_GLTF, 4, 4.41e-6, NULL},
    {"units_plane_E_d1", PLANE, 1, LK_IRRADIANCE, LK_BRDF_GLTF, 4, 2.77e-5, NULL},
    {"units_spot_d1", SPOT, 1, LK_RADIANCE, LK_BRDF_GLTF, 16, 0.000479, NULL},
    {"units_spot_d5", SPOT, 5, LK_RADIANCE, LK_BRDF_GLTF, 16, 0.000467, NULL},
    {"units_mirror_d5", MIRROR, 5, LK_RADIANCE, LK_BRDF_PHONG, 16, 0.000274, NULL},
};
// clang-format on

int main(void)
{
    return references_run(references, sizeof(references) / sizeof(references[0]),
                          &references[VARIANCE_REFERENCE]);
}
