#include "prepare.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "core/log.h"
#include "prep/bvh.h"
#include "prep/bvh_reinsert.h"
#include "prep/presplit.h"
#include "prep/sbvh.h"

enum status prepare_geometry(struct lk_scene *scene)
{
    struct prepared *p = &scene->prepared;
    if (p->ready)
        return STATUS_OK;
    const double start = clock_seconds();
    enum status status = geometry_build(&p->geometry, &scene->scene);
    if (status == STATUS_OK)
        status = emitters_build(&p->emitters, &scene->scene, &p->geometry);
    if (status == STATUS_OK)
        status = material_set_build(&p->materials, &scene->scene);
    if (status != STATUS_OK) {
        prepared_free(p);
        return status;
    }
    p->ready = true;
    p->geometry_s = clock_seconds() - start;
    return STATUS_OK;
}

// Builds a tree and packs it into the layouts asked for.
static enum status build_bvh(struct prepared *out, const struct geometry *geometry,
                             const struct scene_material *materials)
{
    const struct bvh_request *request = &out->bvh_request;
    struct tri_ref *refs = NULL;
    uint32_t ref_count = 0;
    struct bvh bvh = {0};
    enum status status = presplit(&refs, &ref_count, geometry, request->split_threshold);
    if (status == STATUS_OK && request->build == LK_BVH_BUILD_THESIS)
        status = bvh_build(&bvh, refs, ref_count, request->leaf_size);
    else if (status == STATUS_OK)
        status = sbvh_build(&bvh, refs, ref_count, geometry, request->leaf_size);
    if (status == STATUS_OK && request->build == LK_BVH_BUILD_SBVH)
        status = bvh_reinsert(&bvh, refs, geometry);
    if (status == STATUS_OK && request->wide)
        status = wide_bvh_pack(&out->wide, &bvh, refs, geometry, materials);
    if (status == STATUS_OK && request->quad)
        status = quad_bvh_pack(&out->quad, &bvh, refs, geometry, materials);
    if (status == STATUS_OK && request->compressed)
        status = compressed_bvh_pack(&out->compressed, &bvh, refs, geometry, materials);
    if (status == STATUS_OK && request->binary && request->quad) // both over the same triangles
        status = bvh_pack_over(&out->bvh, &bvh, out->quad.places);
    else if (status == STATUS_OK && request->binary)
        status = bvh_pack(&out->bvh, &bvh, refs, geometry, materials);
    free(out->quad.places); // no other layout is made later
    out->quad.places = NULL;
    out->reference_count = bvh.ref_count;
    bvh_free(&bvh);
    free(refs);
    return status;
}

// Whether what was built for one request serves another.
static bool serves(const struct bvh_request *built, const struct bvh_request *asked)
{
    return built->split_threshold == asked->split_threshold &&
           built->leaf_size == asked->leaf_size && built->build == asked->build &&
           built->binary >= asked->binary && built->wide >= asked->wide &&
           built->quad >= asked->quad && built->compressed >= asked->compressed;
}

static enum status prepare_bvh(struct prepared *p, const struct scene *scene,
                               const struct lk_settings *settings, unsigned layouts)
{
    struct prepared made = {.bvh_request = {
                                .split_threshold = settings->split_threshold,
                                .leaf_size = settings->leaf_size,
                                .build = settings->bvh_build,
                                .binary = (layouts >> LK_BVH_BINARY & 1) != 0,
                                .wide = (layouts >> LK_BVH_WIDE & 1) != 0,
                                .quad = (layouts >> LK_BVH_QUAD & 1) != 0,
                                .compressed = (layouts >> LK_BVH_COMPRESSED & 1) != 0,
                            }};
    if (serves(&p->bvh_request, &made.bvh_request))
        return STATUS_OK;
    const double start = clock_seconds();
    const enum status status = build_bvh(&made, &p->geometry, scene->materials);
    if (status != STATUS_OK) {
        compressed_bvh_free(&made.compressed);
        quad_bvh_free(&made.quad);
        wide_bvh_free(&made.wide);
        return status;
    }
    compressed_bvh_free(&p->compressed);
    quad_bvh_free(&p->quad);
    wide_bvh_free(&p->wide);
    packed_bvh_free(&p->bvh);
    p->bvh = made.bvh;
    p->wide = made.wide;
    p->quad = made.quad;
    p->compressed = made.compressed;
    p->reference_count = made.reference_count;
    p->bvh_request = made.bvh_request;
    p->bvh_s = clock_seconds() - start;
    log_message(LOG_INFO, "built a BVH of %u triangles, %u references in %.2f s",
                p->geometry.triangle_count, p->reference_count, p->bvh_s);
    return STATUS_OK;
}

// Builds the hierarchy over lights that the sampler draws from.
static enum status prepare_lights(struct prepared *p, enum lk_light_sampler sampler)
{
    const struct emitters *emitters = &p->emitters;
    if (p->light_sampler == sampler)
        return STATUS_OK;
    const double start = clock_seconds();
    struct light_tree tree = {0};
    struct light_bvh bvh = {0};
    enum status status = STATUS_OK;
    if (sampler == LK_LIGHTS_TREE)
        status = light_tree_build(&tree, emitters->lights, emitters->shapes, emitters->power,
                                  emitters->light_count);
    if (sampler == LK_LIGHTS_IMPORTANCE)
        status = light_bvh_build(&bvh, emitters->lights, emitters->shapes, emitters->power,
                                 emitters->light_count);
    if (status != STATUS_OK)
        return status;
    light_bvh_free(&p->light_bvh);
    light_tree_free(&p->light_tree);
    p->light_tree = tree;
    p->light_bvh = bvh;
    p->light_sampler = sampler;
    p->lights_s = clock_seconds() - start;
    return STATUS_OK;
}

static bool is_same_request(const struct environment_request *a,
                            const struct environment_request *b)
{
    const bool same_path =
        a->path == b->path || (a->path != NULL && b->path != NULL && strcmp(a->path, b->path) == 0);
    return same_path && a->own == b->own && a->rotation_deg == b->rotation_deg &&
           a->strength == b->strength && a->sky_azimuth_deg == b->sky_azimuth_deg &&
           a->sky_elevation_deg == b->sky_elevation_deg && a->sky_turbidity == b->sky_turbidity &&
           memcmp(a->background, b->background, sizeof(a->background)) == 0;
}

static enum status prepare_surroundings(struct surroundings *old, const struct scene *scene,
                                        const struct lk_settings *settings)
{
    const double start = clock_seconds();
    struct surroundings made = {
        .request = {.path = settings->env,
                    .rotation_deg = settings->env_rotation_deg,
                    .strength = settings->env_strength,
                    .sky_azimuth_deg = settings->sky_sun_deg[0],
                    .sky_elevation_deg = settings->sky_sun_deg[1],
                    .sky_turbidity = settings->sky_turbidity,
                    .own = &scene->environment},
    };
    memcpy(made.request.background, settings->background, sizeof(made.request.background));
    if (is_same_request(&made.request, &old->request))
        return STATUS_OK;
    const enum status status = environment_build(&made.environment, &made.request);
    if (status != STATUS_OK)
        return status;
    made.request.path = settings->env != NULL ? strdup(settings->env) : NULL;
    made.seconds = clock_seconds() - start;
    surroundings_free(old);
    *old = made;
    return STATUS_OK;
}

void surroundings_free(struct surroundings *surroundings)
{
    environment_free(&surroundings->environment);
    free((char *)surroundings->request.path);
    *surroundings = (struct surroundings){0};
}

enum status prepare_scene(struct lk_scene *scene, const struct lk_settings *settings,
                          unsigned layouts)
{
    struct prepared *p = &scene->prepared;
    enum status status = prepare_surroundings(&scene->surroundings, &scene->scene, settings);
    if (status == STATUS_OK)
        status = prepare_geometry(scene);
    if (status == STATUS_OK)
        status = prepare_bvh(p, &scene->scene, settings, layouts);
    if (status == STATUS_OK)
        status = prepare_lights(p, settings->light_sampler);
    return status;
}

void prepared_free(struct prepared *prepared)
{
    material_set_free(&prepared->materials);
    light_bvh_free(&prepared->light_bvh);
    light_tree_free(&prepared->light_tree);
    emitters_free(&prepared->emitters);
    compressed_bvh_free(&prepared->compressed);
    quad_bvh_free(&prepared->quad);
    wide_bvh_free(&prepared->wide);
    packed_bvh_free(&prepared->bvh);
    geometry_free(&prepared->geometry);
    *prepared = (struct prepared){0};
}

double prepared_seconds(const struct lk_scene *scene)
{
    const struct prepared *p = &scene->prepared;
    return p->geometry_s + p->bvh_s + p->lights_s + scene->surroundings.seconds;
}

struct upload_source prepared_source(const struct lk_scene *scene, unsigned layouts)
{
    const struct prepared *prepared = &scene->prepared;
    const struct upload_source source = {
        .geometry = &prepared->geometry,
        .bvh = &prepared->bvh,
        .wide = &prepared->wide,
        .quad = &prepared->quad,
        .compressed = &prepared->compressed,
        .layouts = layouts,
        .emitters = &prepared->emitters,
        .environment = &scene->surroundings.environment,
        .light_tree = &prepared->light_tree,
        .light_bvh = &prepared->light_bvh,
        .materials = &prepared->materials,
    };
    return source;
}
