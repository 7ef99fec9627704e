/**
 * @file
 * What stands behind the public API's opaque handles.
 */
#ifndef ENGINE_H
#define ENGINE_H

#include "lightkiln/lightkiln.h"
#include "prep/bvh_pack.h"
#include "prep/emitters.h"
#include "prep/environment.h"
#include "prep/flatten.h"
#include "prep/light_bvh.h"
#include "prep/light_tree.h"
#include "prep/textures.h"
#include "scene/scene.h"

/** What prep/ makes of a scene. All zero: not prepared. */
struct prepared {
    struct geometry geometry;
    struct packed_bvh bvh;
    struct emitters emitters;
    struct light_tree light_tree; // empty unless the sampler is tree
    struct light_bvh light_bvh;   // empty unless it is importance
    struct material_set materials;
    float split_threshold; // settings it was made with
    uint32_t leaf_size;
    enum lk_light_sampler light_sampler;
    bool ready;
    double seconds; // it took
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

#endif
