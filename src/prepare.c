#include "prepare.h"

#include <stdlib.h>

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

enum status prepare_scene(struct lk_scene *scene, float split_threshold, uint32_t leaf_size)
{
    struct prepared *old = &scene->prepared;
    if (old->ready && old->split_threshold == split_threshold && old->leaf_size == leaf_size)
        return STATUS_OK;
    const double start = clock_seconds();
    struct prepared p = {.split_threshold = split_threshold, .leaf_size = leaf_size};
    enum status status = geometry_build(&p.geometry, &scene->scene);
    if (status == STATUS_OK)
        status = prepare_bvh(&p, &scene->scene);
    if (status == STATUS_OK)
        status = emitters_build(&p.emitters, &scene->scene, &p.geometry);
    if (status == STATUS_OK)
        status = light_tree_build(&p.light_tree, p.emitters.lights, p.emitters.power,
                                  p.emitters.light_count);
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
    light_tree_free(&prepared->light_tree);
    emitters_free(&prepared->emitters);
    packed_bvh_free(&prepared->bvh);
    geometry_free(&prepared->geometry);
    *prepared = (struct prepared){0};
}

struct upload_source prepared_source(const struct prepared *prepared)
{
    const struct upload_source source = {
        .geometry = &prepared->geometry,
        .bvh = &prepared->bvh,
        .emitters = &prepared->emitters,
        .light_tree = &prepared->light_tree,
        .materials = &prepared->materials,
    };
    return source;
}
