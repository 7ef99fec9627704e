/**
 * @file
 * What stands behind the public API's opaque handles.
 */
#ifndef ENGINE_H
#define ENGINE_H

#include "device/gpu.h"
#include "lightkiln/lightkiln.h"
#include "prep/bvh_compressed.h"
#include "prep/bvh_pack.h"
#include "prep/bvh_quad.h"
#include "prep/bvh_wide.h"
#include "prep/emitters.h"
#include "prep/environment.h"
#include "prep/flatten.h"
#include "prep/light_bvh.h"
#include "prep/light_tree.h"
#include "prep/textures.h"
#include "scene/scene.h"

/** What a BVH is made from, beside the geometry. All zero: none is made. */
struct bvh_request {
    float split_threshold;
    uint32_t leaf_size;
    enum lk_bvh_build build;
    bool binary, wide, quad, compressed; // the layouts it is packed into
};

/** What prep/ makes of a scene, each part once for as long as its settings stay. All zero: not
 * prepared. */
struct prepared {
    struct geometry geometry;
    struct emitters emitters;
    struct material_set materials;
    bool ready; // those above

    struct packed_bvh bvh;            // empty unless that layout is asked for
    struct wide_bvh wide;             // the same
    struct quad_bvh quad;             // the same
    struct compressed_bvh compressed; // the same
    uint32_t reference_count;
    struct bvh_request bvh_request;

    struct light_tree light_tree;        // empty unless the sampler is tree
    struct light_bvh light_bvh;          // empty unless it is importance
    enum lk_light_sampler light_sampler; // auto: none is made

    double geometry_s, bvh_s, lights_s; // they took
};

/** The environment of the last settings. All zero: none. */
struct surroundings {
    struct environment environment;
    struct environment_request request; // what it was made from; its path is owned
    double seconds;                     // it took
};

struct lk_scene {
    struct scene scene;
    struct prepared prepared;
    struct surroundings surroundings;
    double import_s;
};

struct lk_image {
    float *rgb; // [width * height * 3], rows from the top; owned
    uint32_t width, height;
    bool rendered;              // info is valid
    struct lk_render_info info; // its strings are owned
    double write_s;             // spent by lk_image_write() so far
};

/** Tells of a device in public words. */
void engine_describe_device(struct lk_device_info *out, const struct gpu_info *info);

#endif
