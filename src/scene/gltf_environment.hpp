/**
 * @file
 * The surroundings that a glTF gives itself: EXT_lights_image_based.
 *
 * Of the extension's cube map the faces of the sharpest level are read and made into a lat-long
 * image; its blurred levels and its irradiance coefficients, which say the same for renderers that
 * do not integrate, are not looked at. Its numbers are taken for cd/m2 as they stand. Faces run +X,
 * -X, +Y, -Y, +Z, -Z and show what is seen from within, upright, the top of +Y being -Z and that of
 * -Y +Z. PNG and JPEG are sRGB; alpha divides (RGBD).
 */
#ifndef SCENE_GLTF_ENVIRONMENT_HPP
#define SCENE_GLTF_ENVIRONMENT_HPP

#include "scene/gltf_context.hpp"

/** Makes the scene's environment if the scene that is shown has one. */
void load_environment(import_context &context);

#endif
