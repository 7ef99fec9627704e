/**
 * @file
 * What a render, and a tracer, can be asked for.
 */
#ifndef LIGHTKILN_SETTINGS_H
#define LIGHTKILN_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a pixel holds. */
enum lk_quantity {
    LK_RADIANCE,   // what the camera sees, cd/m2
    LK_IRRADIANCE, // at the first hit, all that arrives on the shaded side, lux; its own colour and
                   // emission are left out
    LK_DIRECT      // radiance of emission and direct light alone
};

/** How surfaces reflect. */
enum lk_brdf {
    LK_BRDF_GLTF, // metallic-roughness of glTF 2.0 appendix B, and specular-glossiness
    LK_BRDF_PHONG // the thesis's: diffuse + specular colour, exponent from glossiness, 1 is a
                  // mirror, no Fresnel
};

/** Which lights a hit draws. */
enum lk_light_sampler {
    LK_LIGHTS_AUTO,      // importance
    LK_LIGHTS_TREE,      // the light tree of thesis section 3.4
    LK_LIGHTS_UNIFORM,   // one of all
    LK_LIGHTS_ALL,       // every light at every hit
    LK_LIGHTS_IMPORTANCE // several by estimated contribution (Conty Estevez and Kulla 2018)
};

/** How samples of a pixel are spread. */
enum lk_sampler {
    LK_SAMPLER_SOBOL, // spread evenly among each other: Owen-scrambled Sobol points
    LK_SAMPLER_RANDOM // independent
};

/** How kernels walk the BVH. Neither this nor what follows changes the picture, but for rounding.
 */
enum lk_trace {
    LK_TRACE_AUTO,       // by the device; a GPU measures what is fast in this scene
    LK_TRACE_SIMPLE,     // one ray a work item
    LK_TRACE_PERSISTENT, // work fetched from a queue (Aila & Laine 2009)
    LK_TRACE_POSTPONING, // one ray a work item; a warp tests leaves together (NVIDIA)
    LK_TRACE_WARPS       // the same, with a queue for each warp, or over wider BVHs for each lane
};

/** How the BVH lies in the device's memory. */
enum lk_bvh {
    LK_BVH_AUTO,      // as LK_TRACE_AUTO
    LK_BVH_BINARY,    // the thesis's
    LK_BVH_WIDE,      // 8 children a node, triangles by four: for CPUs
    LK_BVH_QUAD,      // 4 children a node, boxes as bytes: for GPUs
    LK_BVH_COMPRESSED // 8 children a node, boxes as bytes (Ylitie et al. 2017): for GPUs
};

/** Who builds it. */
enum lk_bvh_build {
    LK_BVH_BUILD_SBVH,  // may split triangles (Stich et al. 2009), improved by reinsertion
    LK_BVH_BUILD_THESIS // thesis section 3.1
};

/** How kernels come by textures. */
enum lk_textures {
    LK_TEXTURES_AUTO,
    LK_TEXTURES_BOUND, // rays sorted by material, one launch each with its images bound (thesis
                       // section 3.3)
    LK_TEXTURES_POOL   // one launch over all texels
};

/** Where kernels read its nodes from. */
enum lk_nodes {
    LK_NODES_BUFFER,
    LK_NODES_TEXTURE // binary BVH's nodes through a 1D texture (thesis section 3.2)
};

/** What is asked for. Fill with lk_settings_init() first; a 0 or NULL where that is noted asks for
 * the default. */
struct lk_settings {
    uint32_t width, height; // pixels, 1 .. 16384; 0: 1024 wide, or by the camera's aspect
    const char *camera;     // name, node's name or index; NULL: the first
    uint32_t spp;           // stop after so many samples per pixel; default 64; 0: no such limit
    double time_s;          // stop after so many seconds of rendering; 0: no such limit
    float noise;            // stop at this noise, the relative error that one tile of 256 pixels in
                            // a hundred exceeds; noisier tiles get more samples than others. A
                            // tile's error is the root mean square over pixels and channels of what
                            // they are off, relative to that of their values, or to a tenth of the
                            // picture's mean where this is more. 0: no such limit
    uint32_t depth;         // shaded hits of a path, 1 .. 255; default 5
    uint32_t roulette_depth; // first hits that every path goes on from; at later ones Russian
                             // roulette may end it (thesis section 3.5), which changes noise and
                             // time but no mean. 0 .. 255; default 2; the depth: never
    uint32_t shadow_rays;    // times that a hit draws lights, 1 .. 64; default 1. Tree and uniform
                             // draw one light each time and send one shadow ray, importance up to
                             // 8, none of them twice, and fewer where few lights send nearly
                             // all; all takes no notice
    enum lk_light_sampler light_sampler;
    enum lk_sampler sampler; // how samples of a pixel are spread
    enum lk_quantity quantity;
    enum lk_brdf brdf;
    const char *env;        // lat-long image that lights the scene, HDR or EXR; its middle looks
                            // along -Z, +X is to the right of that; NULL: none
    float env_rotation_deg; // of that image about +Y, counter-clockwise from above; default 0
    float env_strength;     // factor of that image, or of sky and sun; default 1. Both are applied
                            // to the scene's own image, if it has one, where none is asked for
    float background[3];    // radiance from all around, cd/m2; default 0, 0, 0
    float sky_sun_deg[2];   // azimuth (0 is -Z, 90 is +X) and elevation, up to 90, of the sun of
                            // a clear sky; elevation 0: no sky. Of env, background and sky at
                            // most one
    float sky_turbidity;    // haze of that sky, 2 .. 10; default 3
    const char *device;     // devices, with commas between: each takes the best that matches and
                            // is not taken, of "cpu", "gpu", "P:D" or part of a name; "all" takes
                            // every one. NULL: the best
    enum lk_trace trace;
    enum lk_bvh bvh;
    enum lk_bvh_build bvh_build;
    enum lk_textures textures;
    enum lk_nodes nodes;
    float split_threshold; // largest box surface of a reference, m2; 0: no splitting
    uint32_t leaf_size;    // no leaf has so many triangles, 2 .. 32; by the thesis's builder every
                           // node with fewer is one; default 8
    uint32_t seed;
    uint32_t queue;        // paths in flight; 0: by the device and the scene
    uint64_t memory_limit; // bytes on the device; 0: what the device has
    bool profile;          // time every kernel, each stage by itself
    bool no_cache;         // build kernels from source, and measure anew how to trace
};

/** Sets every default. */
LK_API void lk_settings_init(struct lk_settings *settings);

#ifdef __cplusplus
}
#endif

#endif
