/**
 * @file
 * The scene on the device. Every array is owned by exactly one buffer here.
 */
#ifndef DEVICE_UPLOAD_H
#define DEVICE_UPLOAD_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "device/buffer.h"
#include "device/program.h"
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

/** What is to be uploaded; borrowed. */
struct upload_source {
    const struct geometry *geometry;
    const struct packed_bvh *bvh; // without triangles, it is over those of quad
    const struct wide_bvh *wide;
    const struct quad_bvh *quad;
    const struct compressed_bvh *compressed;
    unsigned layouts; // of these, those to be uploaded: the sum of 1 << LAYOUT_...
    const struct emitters *emitters;
    const struct environment *environment;
    const struct light_tree *light_tree; // the one that the sampler needs,
    const struct light_bvh *light_bvh;   // or neither; the others are empty
    const struct material_set *materials;
};

/** Bytes of each kind. */
struct upload_sizes {
    uint64_t bvh, geometry, materials, lights;
};

/** One layout of the BVH. */
struct device_bvh {
    struct buffer nodes; // struct bvh_node, or a view of them as a 1D texture, or another layout's
    struct buffer node_rows;  // what the view views; empty without one
    enum bvh_layout leaves;   // the layout whose triangles these nodes are over
    struct buffer woop, refs; // struct woop, or woop_block; empty in a layout over another's
};

/** All zero is a valid empty one. */
struct device_scene {
    struct device_bvh bvhs[LAYOUT_END]; // by layout; those that were not uploaded are empty
    struct buffer vertices, colors, tangents, triangles, triangle_emitters;
    struct buffer materials, texels;
    struct buffer *images;     // [image_count], the first white for slots without one; owned
    uint32_t image_count;      // 0 unless textures are bound
    uint32_t *material_images; // [material_count * TEXTURE_USE_COUNT] index into images; owned
    struct buffer lights, shapes, light_nodes, light_parents, light_leaves, directional;
    struct buffer map_texels, map_alias; // of the environment
    struct environment_map map;          // 0 x 0 without one
    uint32_t material_count, light_count, directional_count;
    uint32_t emitter_count; // lights that a ray can meet: triangles, and the environment
    bool alpha;             // some material lets rays by
    bool normal_maps;       // some material has one
    bool layers;            // some material has some of lib/layers.h
    bool sheen;             // some material has a sheen
    bool few_lights;        // the root of the light BVH has them all
    uint32_t untextured;    // bits of enum texture_use: no material has such a texture
    bool glossy;            // some material has more than a Lambert term
    bool lambert;           // all have it and no more: neither layers, normal maps, vertex colours
                            // nor unlit ones
};

/** What upload() will take on the device, images apart; of the BVH, all layouts asked for. */
struct upload_sizes upload_sizes(const struct upload_source *source);

/**
 * Copies a scene to the device.
 *
 * @param nodes_image     Nodes of the binary BVH as a 1D texture.
 * @param textures_bound  Make an image of every texture.
 * @retval STATUS_NO_MEMORY, STATUS_DEVICE, STATUS_LIMIT
 */
enum status upload(struct device_scene *out, struct gpu *gpu, const struct upload_source *source,
                   bool nodes_image, bool textures_bound);

/** Releases layouts of the BVH that are not among these, but for triangles that those need. */
void device_scene_keep(struct gpu *gpu, struct device_scene *scene, unsigned layouts);

/** Releases everything. Safe on an empty one. */
void device_scene_free(struct gpu *gpu, struct device_scene *scene);

#endif
