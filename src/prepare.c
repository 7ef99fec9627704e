#include "prepare.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "core/log.h"
#include "prep/bvh.h"
#include "prep/presplit.h"

static enum status prepare_bvh(struct prepared *out, const struct scene *scene)
{
    enum status status = STATUS_OK;
    struct tri_ref *refs = NULL;
    uint32_t ref_count = 0;
    struct bvh bvh = {0};

    status = presplit(&refs, &ref_count, &out->geometry, out->split_threshold);
    if (status != STATUS_OK)
        goto cleanup;
    status = bvh_build(&bvh, refs, ref_count, out->leaf_size);
    if (status != STATUS_OK)
        goto cleanup;
    status = bvh_pack(&out->bvh, &bvh, refs, &out->geometry, scene->materials);

cleanup:
    bvh_free(&bvh);
    free(refs);
    return status;
}

// Builds the hierarchy over lights that the sampler draws from.
static enum status prepare_lights(struct prepared *out)
{
    const struct emitters *emitters = &out->emitters;
    if (out->light_sampler == LK_LIGHTS_TREE)
        return light_tree_build(&out->light_tree, emitters->lights, emitters->shapes,
                                emitters->power, emitters->light_count);
    if (out->light_sampler == LK_LIGHTS_IMPORTANCE)
        return light_bvh_build(&out->light_bvh, emitters->lights, emitters->shapes, emitters->power,
                               emitters->light_count);
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

enum status prepare_scene(struct lk_scene *scene, const struct lk_settings *settings)
{
    struct prepared *old = &scene->prepared;
    const enum status surrounded =
        prepare_surroundings(&scene->surroundings, &scene->scene, settings);
    if (surrounded != STATUS_OK)
        return surrounded;
    if (old->ready && old->split_threshold == settings->split_threshold &&
        old->leaf_size == settings->leaf_size && old->light_sampler == settings->light_sampler)
        return STATUS_OK;
    const double start = clock_seconds();
    struct prepared p = {
        .split_threshold = settings->split_threshold,
        .leaf_size = settings->leaf_size,
        .light_sampler = settings->light_sampler,
    };
    enum status status = geometry_build(&p.geometry, &scene->scene);
    if (status == STATUS_OK)
        status = prepare_bvh(&p, &scene->scene);
    if (status == STATUS_OK)
        status = emitters_build(&p.emitters, &scene->scene, &p.geometry);
    if (status == STATUS_OK)
        status = prepare_lights(&p);
    if (status == STATUS_OK)
        status = material_set_build(&p.materials, &scene->scene);
    if (status != STATUS_OK) {
        prepared_free(&p);
        return status;
    }
    p.ready = true;
    p.seconds = clock_seconds() - start;
    log_message(LOG_INFO, "prepared %u triangles, %u references, %u lights in %.2f s",
                p.geometry.triangle_count, p.bvh.ref_count, p.emitters.light_count, p.seconds);
    prepared_free(old);
    *old = p;
    return STATUS_OK;
}

void prepared_free(struct prepared *prepared)
{
    material_set_free(&prepared->materials);
    light_bvh_free(&prepared->light_bvh);
    light_tree_free(&prepared->light_tree);
    emitters_free(&prepared->emitters);
    packed_bvh_free(&prepared->bvh);
    geometry_free(&prepared->geometry);
    *prepared = (struct prepared){0};
}

struct upload_source prepared_source(const struct lk_scene *scene)
{
    const struct prepared *prepared = &scene->prepared;
    const struct upload_source source = {
        .geometry = &prepared->geometry,
        .bvh = &prepared->bvh,
        .emitters = &prepared->emitters,
        .environment = &scene->surroundings.environment,
        .light_tree = &prepared->light_tree,
        .light_bvh = &prepared->light_bvh,
        .materials = &prepared->materials,
    };
    return source;
}
