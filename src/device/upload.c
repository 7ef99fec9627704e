#include "device/upload.h"

#include <stdlib.h>
#include <string.h>

// The arrays of a BVH, whatever its layout.
struct bvh_arrays {
    const void *nodes, *woop, *refs;
    size_t nodes_size, woop_size, refs_size; // bytes
};

static struct bvh_arrays find_arrays(const struct upload_source *source, enum bvh_layout layout)
{
    const struct packed_bvh *bvh = source->bvh;
    const struct wide_bvh *wide = source->wide;
    const struct quad_bvh *quad = source->quad;
    const struct compressed_bvh *compressed = source->compressed;
    if (layout == LAYOUT_WIDE)
        return (struct bvh_arrays){
            .nodes = wide->nodes,
            .woop = wide->blocks,
            .refs = wide->refs,
            .nodes_size = wide->node_count * sizeof(*wide->nodes),
            .woop_size = wide->block_count * sizeof(*wide->blocks),
            .refs_size = (size_t)wide->block_count * WIDE_BLOCK * sizeof(*wide->refs),
        };
    if (layout == LAYOUT_QUAD)
        return (struct bvh_arrays){
            .nodes = quad->nodes,
            .woop = quad->woop,
            .refs = quad->refs,
            .nodes_size = quad->node_count * sizeof(*quad->nodes),
            .woop_size = quad->ref_count * sizeof(*quad->woop),
            .refs_size = quad->ref_count * sizeof(*quad->refs),
        };
    if (layout == LAYOUT_COMPRESSED)
        return (struct bvh_arrays){
            .nodes = compressed->nodes,
            .woop = compressed->woop,
            .refs = compressed->refs,
            .nodes_size = compressed->node_count * sizeof(*compressed->nodes),
            .woop_size = compressed->ref_count * sizeof(*compressed->woop),
            .refs_size = compressed->ref_count * sizeof(*compressed->refs),
        };
    return (struct bvh_arrays){
        .nodes = bvh->nodes,
        .woop = bvh->woop,
        .refs = bvh->refs,
        .nodes_size = bvh->node_count * sizeof(*bvh->nodes),
        .woop_size = bvh->ref_count * sizeof(*bvh->woop),
        .refs_size = bvh->ref_count * sizeof(*bvh->refs),
    };
}

// The layout whose triangles a layout's nodes are over.
static enum bvh_layout find_leaves(const struct upload_source *source, enum bvh_layout layout)
{
    return layout == LAYOUT_BINARY && source->bvh->woop == NULL ? LAYOUT_QUAD : layout;
}

static bool is_in(unsigned layouts, enum bvh_layout layout)
{
    return (layouts >> layout & 1u) != 0;
}

// The layouts whose triangles these layouts are over.
static unsigned all_leaves(const struct upload_source *source, unsigned layouts)
{
    unsigned leaves = 0;
    for (enum bvh_layout layout = LAYOUT_BINARY; layout < LAYOUT_END; layout++)
        if (is_in(layouts, layout))
            leaves |= 1u << find_leaves(source, layout);
    return leaves;
}

static uint64_t bvh_size(const struct upload_source *source)
{
    const unsigned leaves = all_leaves(source, source->layouts);
    uint64_t size = 0;
    for (enum bvh_layout layout = LAYOUT_BINARY; layout < LAYOUT_END; layout++) {
        const struct bvh_arrays arrays = find_arrays(source, layout);
        size += is_in(source->layouts, layout) ? arrays.nodes_size : 0;
        size += is_in(leaves, layout) ? arrays.woop_size + arrays.refs_size : 0;
    }
    return size;
}

struct upload_sizes upload_sizes(const struct upload_source *source)
{
    const struct geometry *geometry = source->geometry;
    const uint64_t vertices = geometry->vertex_count;
    const uint64_t lights = source->emitters->light_count;
    struct upload_sizes sizes = {
        .bvh = bvh_size(source),
        .geometry = vertices * sizeof(struct vertex) +
                    (geometry->colors != NULL ? vertices * sizeof(*geometry->colors) : 0) +
                    (geometry->tangents != NULL ? vertices * sizeof(*geometry->tangents) : 0) +
                    geometry->triangle_count * sizeof(struct triangle),
        .materials = source->materials->material_count * sizeof(struct material) +
                     source->materials->texel_count * sizeof(uint32_t),
        .lights =
            lights * sizeof(struct light) +
            source->emitters->shape_count * sizeof(struct light_shape) +
            (source->light_tree->light_count + source->light_bvh->light_count) * sizeof(uint32_t) +
            source->light_tree->node_count * (sizeof(struct light_node) + sizeof(uint32_t)) +
            source->light_bvh->node_count * (sizeof(struct light_bvh_node) + sizeof(uint32_t)) +
            source->emitters->directional_count * sizeof(struct directional_light) +
            environment_size(source->environment),
    };
    if (source->emitters->triangle_emitters != NULL)
        sizes.lights += geometry->triangle_count * sizeof(uint32_t);
    return sizes;
}

static enum status upload_nodes(struct device_bvh *out, struct gpu *gpu,
                                const struct bvh_arrays *arrays, bool nodes_image)
{
    struct buffer *rows = nodes_image ? &out->node_rows : &out->nodes;
    enum status status = buffer_create(rows, gpu, arrays->nodes_size, arrays->nodes, "BVH nodes");
    if (status == STATUS_OK && nodes_image)
        status = buffer_view_rows(&out->nodes, gpu, rows, "BVH nodes");
    return status;
}

static enum status upload_bvhs(struct device_scene *out, struct gpu *gpu,
                               const struct upload_source *source, bool nodes_image)
{
    const unsigned leaves = all_leaves(source, source->layouts);
    enum status status = STATUS_OK;
    for (enum bvh_layout layout = LAYOUT_BINARY; layout < LAYOUT_END; layout++) {
        const struct bvh_arrays arrays = find_arrays(source, layout);
        struct device_bvh *bvh = &out->bvhs[layout];
        bvh->leaves = find_leaves(source, layout);
        if (status == STATUS_OK && is_in(source->layouts, layout))
            status = upload_nodes(bvh, gpu, &arrays, nodes_image);
        if (status == STATUS_OK && is_in(leaves, layout))
            status =
                buffer_create(&bvh->woop, gpu, arrays.woop_size, arrays.woop, "triangle matrices");
        if (status == STATUS_OK && is_in(leaves, layout))
            status = buffer_create(&bvh->refs, gpu, arrays.refs_size, arrays.refs,
                                   "triangle references");
    }
    return status;
}

static enum status upload_geometry(struct device_scene *out, struct gpu *gpu,
                                   const struct geometry *geometry)
{
    enum status status =
        buffer_create(&out->vertices, gpu, geometry->vertex_count * sizeof(*geometry->vertices),
                      geometry->vertices, "vertices");
    if (status == STATUS_OK)
        status = buffer_create(
            &out->colors, gpu,
            geometry->colors != NULL ? geometry->vertex_count * sizeof(*geometry->colors) : 0,
            geometry->colors, "vertex colours");
    if (status == STATUS_OK)
        status = buffer_create(
            &out->tangents, gpu,
            geometry->tangents != NULL ? geometry->vertex_count * sizeof(*geometry->tangents) : 0,
            geometry->tangents, "tangents");
    if (status == STATUS_OK)
        status = buffer_create(&out->triangles, gpu,
                               geometry->triangle_count * sizeof(*geometry->triangles),
                               geometry->triangles, "triangles");
    return status;
}

// Uploads a hierarchy over lights; an empty one where the sampler needs none.
static enum status upload_hierarchy(struct device_scene *out, struct gpu *gpu, const void *nodes,
                                    size_t nodes_size, const uint32_t *parents, uint32_t node_count,
                                    const uint32_t *leaves, uint32_t light_count)
{
    enum status status =
        buffer_create(&out->light_nodes, gpu, nodes_size, nodes, "light hierarchy");
    if (status == STATUS_OK)
        status = buffer_create(&out->light_parents, gpu, node_count * sizeof(*parents), parents,
                               "light hierarchy");
    if (status == STATUS_OK)
        status = buffer_create(&out->light_leaves, gpu, light_count * sizeof(*leaves), leaves,
                               "light hierarchy");
    return status;
}

// Uploads the environment, and the directional lights with its sun.
static enum status upload_far_lights(struct device_scene *out, struct gpu *gpu,
                                     const struct emitters *emitters,
                                     const struct environment *environment)
{
    const uint32_t count = emitters->directional_count + environment->has_sun;
    const size_t texels = (size_t)environment->map.width * environment->map.height;
    struct directional_light *lights = calloc((size_t)count + 1, sizeof(*lights));
    if (lights == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u directional lights", count);
    if (emitters->directional_count > 0)
        memcpy(lights, emitters->directional, emitters->directional_count * sizeof(*lights));
    lights[emitters->directional_count] = environment->sun;
    enum status status = buffer_create(&out->directional, gpu, count * sizeof(*lights), lights,
                                       "directional lights");
    free(lights);
    if (status == STATUS_OK)
        status = buffer_create(&out->map_texels, gpu, texels * sizeof(*environment->texels),
                               environment->texels, "environment");
    if (status == STATUS_OK)
        status = buffer_create(&out->map_alias, gpu, texels * sizeof(*environment->alias),
                               environment->alias, "environment");
    out->directional_count = count;
    out->map = environment->map;
    return status;
}

static enum status upload_lights(struct device_scene *out, struct gpu *gpu,
                                 const struct upload_source *source)
{
    const struct emitters *emitters = source->emitters;
    const struct light_tree *tree = source->light_tree;
    const struct light_bvh *bvh = source->light_bvh;
    const size_t words = sizeof(uint32_t);
    enum status status = buffer_create(
        &out->triangle_emitters, gpu,
        emitters->triangle_emitters != NULL ? source->geometry->triangle_count * words : 0,
        emitters->triangle_emitters, "emitters of triangles");
    if (status == STATUS_OK)
        status = buffer_create(&out->lights, gpu, emitters->light_count * sizeof(*emitters->lights),
                               emitters->lights, "lights");
    if (status == STATUS_OK)
        status = buffer_create(&out->shapes, gpu, emitters->shape_count * sizeof(*emitters->shapes),
                               emitters->shapes, "shapes of lights");
    if (status == STATUS_OK && source->light_bvh->node_count > 0)
        status = upload_hierarchy(out, gpu, bvh->nodes, bvh->node_count * sizeof(*bvh->nodes),
                                  bvh->parents, bvh->node_count, bvh->leaves, bvh->light_count);
    else if (status == STATUS_OK)
        status = upload_hierarchy(out, gpu, tree->nodes, tree->node_count * sizeof(*tree->nodes),
                                  tree->parents, tree->node_count, tree->leaves, tree->light_count);
    if (status == STATUS_OK)
        status = upload_far_lights(out, gpu, emitters, source->environment);
    out->light_count = emitters->light_count;
    out->few_lights = bvh->node_count == 1;
    out->emitter_count = emitters->emissive_triangles + (out->map.width > 0);
    return status;
}

// Makes an image of every texture, once, and notes which ones a material binds.
static enum status upload_images(struct device_scene *out, struct gpu *gpu,
                                 const struct material_set *set)
{
    const size_t slot_count = (size_t)set->material_count * TEXTURE_USE_COUNT;
    uint32_t *firsts = calloc(slot_count + 1, sizeof(*firsts)); // texel_first of each image
    out->images = calloc(slot_count + 1, sizeof(*out->images));
    out->material_images = calloc(slot_count + 1, sizeof(*out->material_images));
    if (firsts == NULL || out->images == NULL || out->material_images == NULL) {
        free(firsts);
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu texture slots", slot_count);
    }

    static const uint32_t white = 0xffffffffu;
    enum status status = buffer_create_image(&out->images[0], gpu, 1, 1, &white, "white texture");
    out->image_count = 1;
    for (size_t i = 0; i < slot_count && status == STATUS_OK; i++) {
        const struct texture_slot *slot =
            &set->materials[i / TEXTURE_USE_COUNT].textures[i % TEXTURE_USE_COUNT];
        if (!(slot->flags & TEXTURE_PRESENT))
            continue;
        uint32_t image = 1;
        while (image < out->image_count && firsts[image] != slot->texel_first)
            image++;
        out->material_images[i] = image;
        if (image < out->image_count)
            continue;
        firsts[image] = slot->texel_first;
        status = buffer_create_image(&out->images[image], gpu, slot->size & 0xffffu,
                                     slot->size >> 16, set->texels + slot->texel_first, "texture");
        out->image_count += status == STATUS_OK;
    }
    free(firsts);
    return status;
}

static enum status upload_materials(struct device_scene *out, struct gpu *gpu,
                                    const struct material_set *set, bool textures_bound)
{
    enum status status =
        buffer_create(&out->materials, gpu, set->material_count * sizeof(*set->materials),
                      set->materials, "materials");
    if (status == STATUS_OK)
        status = buffer_create(&out->texels, gpu, set->texel_count * sizeof(*set->texels),
                               set->texels, "textures");
    if (status == STATUS_OK && textures_bound)
        status = upload_images(out, gpu, set);
    out->material_count = set->material_count;
    out->untextured = (1u << TEXTURE_USE_COUNT) - 1;
    out->lambert = true;
    const uint passing = MATERIAL_MASKED | MATERIAL_BLENDED | MATERIAL_TRANSMITS;
    for (uint32_t i = 0; i < set->material_count; i++) {
        const uint flags = set->materials[i].flags;
        for (int use = 0; use < TEXTURE_USE_COUNT; use++)
            if (set->materials[i].textures[use].flags & TEXTURE_PRESENT)
                out->untextured &= ~(1u << use);
        out->alpha |= (flags & passing) != 0;
        out->normal_maps |= (flags & (MATERIAL_NORMAL_MAP | MATERIAL_COAT_NORMAL_MAP)) != 0;
        out->layers |= (flags & MATERIAL_LAYERED) != 0;
        out->sheen |= (flags & MATERIAL_SHEEN) != 0;
        out->lambert =
            out->lambert && (flags & (MATERIAL_LAMBERT | MATERIAL_EXTRAS)) == MATERIAL_LAMBERT;
        out->glossy |= (flags & (MATERIAL_LAMBERT | MATERIAL_LAYERED)) != MATERIAL_LAMBERT;
    }
    return status;
}

enum status upload(struct device_scene *out, struct gpu *gpu, const struct upload_source *source,
                   bool nodes_image, bool textures_bound)
{
    struct device_scene scene = {0};
    enum status status = upload_bvhs(&scene, gpu, source, nodes_image);
    if (status == STATUS_OK)
        status = upload_geometry(&scene, gpu, source->geometry);
    if (status == STATUS_OK)
        status = upload_lights(&scene, gpu, source);
    if (status == STATUS_OK)
        status = upload_materials(&scene, gpu, source->materials, textures_bound);
    if (status != STATUS_OK) {
        device_scene_free(gpu, &scene);
        return status;
    }
    *out = scene;
    return STATUS_OK;
}

void device_scene_keep(struct gpu *gpu, struct device_scene *scene, unsigned layouts)
{
    unsigned leaves = 0;
    for (enum bvh_layout layout = LAYOUT_BINARY; layout < LAYOUT_END; layout++)
        if (is_in(layouts, layout))
            leaves |= 1u << scene->bvhs[layout].leaves;
    for (enum bvh_layout layout = LAYOUT_BINARY; layout < LAYOUT_END; layout++) {
        struct device_bvh *bvh = &scene->bvhs[layout];
        if (!is_in(leaves, layout)) {
            buffer_free(gpu, &bvh->refs);
            buffer_free(gpu, &bvh->woop);
        }
        if (!is_in(layouts, layout)) {
            buffer_free(gpu, &bvh->nodes);
            buffer_free(gpu, &bvh->node_rows);
        }
    }
}

void device_scene_free(struct gpu *gpu, struct device_scene *scene)
{
    buffer_free(gpu, &scene->map_alias);
    buffer_free(gpu, &scene->map_texels);
    buffer_free(gpu, &scene->directional);
    buffer_free(gpu, &scene->light_leaves);
    buffer_free(gpu, &scene->light_parents);
    buffer_free(gpu, &scene->light_nodes);
    buffer_free(gpu, &scene->shapes);
    buffer_free(gpu, &scene->lights);
    for (uint32_t i = 0; i < scene->image_count; i++)
        buffer_free(gpu, &scene->images[i]);
    free(scene->images);
    free(scene->material_images);
    buffer_free(gpu, &scene->texels);
    buffer_free(gpu, &scene->materials);
    buffer_free(gpu, &scene->triangle_emitters);
    buffer_free(gpu, &scene->triangles);
    buffer_free(gpu, &scene->tangents);
    buffer_free(gpu, &scene->colors);
    buffer_free(gpu, &scene->vertices);
    device_scene_keep(gpu, scene, 0);
    *scene = (struct device_scene){0};
}
