#include "settings.h"

#include <math.h>
#include <stddef.h>

#include "core/choices.h"

// Paths; what stages hand on stays in the last cache. Below 2^16, since PoCL compiles every kernel
// once for grids smaller than that and once more for others, 0.8 s of a cold start in the box.
#define QUEUE_CPU    (63u << 10)
#define MEMORY_SHARE 0.9 // of the device's memory that may be planned with

// Checks what makes the environment.
static enum status check_environment(const struct lk_settings *s)
{
    const float *color = s->background;
    const bool has_background = color[0] != 0.0f || color[1] != 0.0f || color[2] != 0.0f;
    if ((s->env != NULL) + has_background + (s->sky_sun_deg[1] != 0.0f) > 1)
        return status_fail(STATUS_USAGE, "of an environment image, a sky and a background at most "
                                         "one can be had");
    for (int k = 0; k < 3; k++)
        if (!isfinite(color[k]) || color[k] < 0.0f)
            return status_fail(STATUS_USAGE, "a background of %g, %g, %g is none", (double)color[0],
                               (double)color[1], (double)color[2]);
    if (!isfinite(s->env_rotation_deg))
        return status_fail(STATUS_USAGE, "the environment's rotation is not a finite number");
    if (!isfinite(s->env_strength) || s->env_strength < 0.0f)
        return status_fail(STATUS_USAGE, "an environment strength of %g is none",
                           (double)s->env_strength);
    if (!isfinite(s->sky_sun_deg[0]) || !(s->sky_sun_deg[1] >= 0.0f && s->sky_sun_deg[1] <= 90.0f))
        return status_fail(STATUS_USAGE, "a sun %g degrees above the horizon is not within 0 .. 90",
                           (double)s->sky_sun_deg[1]);
    if (!(s->sky_turbidity >= 2.0f && s->sky_turbidity <= 10.0f))
        return status_fail(STATUS_USAGE, "a turbidity of %g is not within 2 .. 10",
                           (double)s->sky_turbidity);
    return STATUS_OK;
}

enum status settings_check(const struct lk_settings *s)
{
    if (!isfinite(s->noise) || s->noise < 0.0f)
        return status_fail(STATUS_USAGE, "a noise of %g is none", (double)s->noise);
    if (s->spp == 0 && !(s->time_s > 0.0) && s->noise == 0.0f)
        return status_fail(STATUS_USAGE, "neither samples nor time nor noise end this render");
    if (s->spp > 1u << 24)
        return status_fail(STATUS_USAGE, "%u samples per pixel are more than 16777216", s->spp);
    if (!isfinite(s->time_s) || s->time_s < 0.0)
        return status_fail(STATUS_USAGE, "a time of %g s is none", s->time_s);
    if (s->depth < 1 || s->depth > 255)
        return status_fail(STATUS_USAGE, "a depth of %u is not within 1 .. 255", s->depth);
    if (s->roulette_depth > 255)
        return status_fail(STATUS_USAGE, "a roulette depth of %u is not within 0 .. 255",
                           s->roulette_depth);
    if (s->shadow_rays < 1 || s->shadow_rays > 64)
        return status_fail(STATUS_USAGE, "%u shadow rays are not within 1 .. 64", s->shadow_rays);
    if (s->leaf_size < 2 || s->leaf_size > 32)
        return status_fail(STATUS_USAGE, "a leaf size of %u is not within 2 .. 32", s->leaf_size);
    if (s->bvh > LK_BVH_BINARY && s->nodes == LK_NODES_TEXTURE)
        return status_fail(STATUS_USAGE,
                           "a texture holds nodes of the binary BVH only: --bvh %s "
                           "goes with --nodes buffer",
                           choices_bvh[s->bvh]);
    if (!isfinite(s->split_threshold) || s->split_threshold < 0.0f)
        return status_fail(STATUS_USAGE, "a split threshold of %g m2 is none",
                           (double)s->split_threshold);
    return check_environment(s);
}

// At equal samples importance has a sixtieth to a three hundredth of the others' variance in rooms
// of 1000 and 10000 lights and a quarter in Sibenik (5), for 1.2 to 1.6 times their time (H100).
void settings_choose_sampler(struct lk_settings *settings)
{
    if (settings->light_sampler == LK_LIGHTS_AUTO)
        settings->light_sampler = LK_LIGHTS_IMPORTANCE;
}

void settings_choose_variants(struct lk_settings *settings, const struct gpu *gpu)
{
    const struct gpu_info *info = &gpu->info;

    // Over nodes of bytes, warps trace later bounces in Sponza at a quarter more rays/s than the
    // binary BVH gives and primary rays at a tenth less. Whole renders of depth 5 on an H100 gain
    // 23 % in Sponza (262,000 triangles), 9 % in Sibenik (80,000), and lose 5 % in a level of
    // 45,000.
    if (settings->trace == LK_TRACE_AUTO && settings->bvh == LK_BVH_AUTO &&
        settings->nodes == LK_NODES_BUFFER && !info->is_cpu && program_takes_votes(gpu)) {
        settings->trace = LK_TRACE_WARPS;
        settings->bvh = LK_BVH_QUAD;
    }

    // PoCL keeps the stack of every item of a plain group apart, which leaves the first cache; the
    // queue takes groups of one (Sponza, wide: up to 7 % more rays/s).
    if (settings->trace == LK_TRACE_AUTO)
        settings->trace = info->is_cpu ? LK_TRACE_PERSISTENT : LK_TRACE_SIMPLE;
    if (settings->bvh == LK_BVH_AUTO)
        settings->bvh =
            info->is_cpu && settings->nodes == LK_NODES_BUFFER ? LK_BVH_WIDE : LK_BVH_BINARY;
    if (settings->textures == LK_TEXTURES_AUTO)
        settings->textures = LK_TEXTURES_POOL;
    if (settings->queue == 0)
        settings->queue = info->is_cpu ? QUEUE_CPU : SETTINGS_QUEUE_GPU;
    if (settings->memory_limit == 0)
        settings->memory_limit = (uint64_t)((double)info->global_memory * MEMORY_SHARE);
}

static bool has_votes(const struct lk_settings *settings)
{
    return settings->trace == LK_TRACE_POSTPONING || settings->trace == LK_TRACE_WARPS;
}

enum status settings_check_device(const struct lk_settings *settings, const struct gpu *gpu)
{
    if (!has_votes(settings))
        return STATUS_OK;
    if (settings->bvh == LK_BVH_WIDE)
        return status_fail(STATUS_UNSUPPORTED,
                           "--trace postponing and warps go with --bvh binary, quad or compressed");
    if (!program_takes_votes(gpu))
        return status_fail(STATUS_UNSUPPORTED,
                           "device \"%s\" has no warps that vote; use --trace simple or persistent",
                           gpu->info.name);
    return STATUS_OK;
}

struct program_options settings_program_options(const struct lk_settings *settings)
{
    const struct program_options options = {
        .persistent = settings->trace == LK_TRACE_PERSISTENT || settings->trace == LK_TRACE_WARPS,
        .warp_votes = has_votes(settings),
        .bvh_wide = settings->bvh == LK_BVH_WIDE,
        .bvh_quad = settings->bvh == LK_BVH_QUAD,
        .bvh_compressed = settings->bvh == LK_BVH_COMPRESSED,
        .nodes_image = settings->nodes == LK_NODES_TEXTURE,
        .textures_bound = settings->textures == LK_TEXTURES_BOUND,
        .light_sampler = (int)settings->light_sampler,
        .brdf_phong = settings->brdf == LK_BRDF_PHONG,
        .no_cache = settings->no_cache,
    };
    return options;
}
