// Rooms with many lights against their references.

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
    return references_run(references, sizeof(references) / sizeof(references[0]), NULL);
}
