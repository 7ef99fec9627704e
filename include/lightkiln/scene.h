/**
 * @file
 * Scenes: what a file says, and what it takes to render.
 */
#ifndef LIGHTKILN_SCENE_H
#define LIGHTKILN_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A loaded scene. Opaque. */
struct lk_scene;

/**
 * Loads glTF 2.0 (.gltf or .glb); "-" reads a GLB from standard input.
 *
 * @retval LK_IO, LK_FORMAT, LK_UNSUPPORTED, LK_LIMIT, LK_NO_MEMORY
 */
LK_API enum lk_status lk_scene_load(struct lk_scene **out, const char *path);

/** Releases it; what was borrowed from it is gone, too. NULL is accepted. */
LK_API void lk_scene_free(struct lk_scene *scene);

/** How many lights there are of each kind. */
struct lk_lights {
    uint64_t point, spot, rect, disc, directional; // the sun of a sky is directional
    uint64_t emissive_triangles;                   // those in rectangles, too
    uint64_t drawn; // that a hit draws from: all but directional, a rectangle as one
};

/** Bytes on the device, but for peak_host. */
struct lk_memory {
    uint64_t bvh;       // nodes, Woop rows, reference words
    uint64_t geometry;  // vertices, triangles
    uint64_t materials; // with textures
    uint64_t lights;    // with their hierarchy and the environment
    uint64_t rays;      // per-path data of the ray queue
    uint64_t samples;   // what all paths share: points of samples, the list of pixels
    uint64_t film;      // accumulators
    uint64_t total_device;
    uint64_t peak_host; // largest resident size of this process so far
};

/** What a scene holds, and what its render does. */
struct lk_scene_info {
    const char *file;         // as given; borrowed from the scene
    uint64_t triangles;       // after flattening instances
    uint64_t triangles_split; // references in the BVH, after early split clipping
    uint64_t instances, materials, textures, cameras;
    struct lk_lights lights;
    struct lk_memory memory; // for the given settings; rays and film by image size and queue
    uint32_t width, height;  // of the image these settings ask for
};

struct lk_settings;

/**
 * Tells what a render of this scene would hold, without rendering or touching any device. Does the
 * preparation if it has not been done for these settings. The ray queue is taken as large as the
 * image or 2^21 paths, whichever is less, and the BVH as binary unless the settings name a layout.
 *
 * @retval LK_USAGE (a setting is out of range, or there is no such camera), LK_NO_MEMORY,
 * LK_FORMAT, LK_LIMIT; LK_IO (the image of the surroundings)
 */
LK_API enum lk_status lk_scene_info(struct lk_scene_info *out, struct lk_scene *scene,
                                    const struct lk_settings *settings);

/** The name of camera `index`, its node's if it has none, "" if neither; NULL past the last.
 * Borrowed from the scene. */
LK_API const char *lk_scene_camera(const struct lk_scene *scene, size_t index);

/** World-space triangles. Borrowed from the scene. */
struct lk_geometry {
    const float *positions;  // xyz of vertex i at positions + i * position_stride, m
    const uint32_t *corners; // the three vertices of triangle i at corners + i * corner_stride
    size_t position_stride, corner_stride; // in elements of these arrays
    uint64_t vertex_count, triangle_count;
};

/** Flattens the scene's instances, unless that has been done. @retval LK_NO_MEMORY, LK_FORMAT,
 * LK_LIMIT */
LK_API enum lk_status lk_scene_geometry(struct lk_geometry *out, struct lk_scene *scene);

/**
 * Tells where a light is.
 *
 * @param[out] place  xyz and 1: position, m, of a surface its middle; xyz and 0: unit direction
 * towards a light that is far away.
 * @return False if `index` is past the last light, or lk_scene_geometry() was not called yet.
 */
LK_API bool lk_scene_light(float place[4], const struct lk_scene *scene, size_t index);

#ifdef __cplusplus
}
#endif

#endif
