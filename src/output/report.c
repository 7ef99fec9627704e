#include "output/report.h"

#include "core/choices.h"

static void write_scene(struct json *json, const struct lk_scene_info *scene)
{
    json_object(json, "scene");
    json_string(json, "file", scene->file);
    json_uint(json, "triangles", scene->triangles);
    json_uint(json, "triangles_split", scene->triangles_split);
    json_uint(json, "instances", scene->instances);
    json_uint(json, "materials", scene->materials);
    json_uint(json, "textures", scene->textures);
    json_uint(json, "cameras", scene->cameras);
    json_object(json, "lights");
    json_uint(json, "point", scene->lights.point);
    json_uint(json, "spot", scene->lights.spot);
    json_uint(json, "rect", scene->lights.rect);
    json_uint(json, "disc", scene->lights.disc);
    json_uint(json, "directional", scene->lights.directional);
    json_uint(json, "emissive_triangles", scene->lights.emissive_triangles);
    json_uint(json, "drawn", scene->lights.drawn);
    json_object_end(json);
    json_object_end(json);
}

// What lights the scene from far away, as the options name it.
static void write_environment(struct json *json, const struct lk_settings *settings)
{
    json_string(json, "env", settings->env);
    json_float(json, "env_rotation", settings->env_rotation_deg);
    json_float(json, "env_strength", settings->env_strength);
    json_array(json, "background");
    for (int k = 0; k < 3; k++)
        json_float(json, NULL, settings->background[k]);
    json_array_end(json);
    json_array(json, "sky");
    for (int k = 0; k < 2; k++)
        json_float(json, NULL, settings->sky_sun_deg[k]);
    json_array_end(json);
    json_float(json, "sky_turbidity", settings->sky_turbidity);
}

static void write_picture_settings(struct json *json, const struct lk_settings *settings)
{
    json_uint(json, "width", settings->width);
    json_uint(json, "height", settings->height);
    json_string(json, "camera", settings->camera);
    json_uint(json, "spp", settings->spp);
    json_float(json, "noise", settings->noise);
    json_uint(json, "depth", settings->depth);
    json_uint(json, "roulette_depth", settings->roulette_depth);
    json_uint(json, "shadow_rays", settings->shadow_rays);
    json_string(json, "light_sampler", choices_light_sampler[settings->light_sampler]);
    json_string(json, "sampler", choices_sampler[settings->sampler]);
    json_string(json, "quantity", choices_quantity[settings->quantity]);
    json_string(json, "brdf", choices_brdf[settings->brdf]);
    write_environment(json, settings);
    json_string(json, "trace", choices_trace[settings->trace]);
    json_string(json, "bvh", choices_bvh[settings->bvh]);
    json_string(json, "bvh_build", choices_bvh_build[settings->bvh_build]);
    json_string(json, "textures", choices_textures[settings->textures]);
    json_string(json, "nodes", choices_nodes[settings->nodes]);
    json_float(json, "split_threshold", settings->split_threshold);
    json_uint(json, "leaf_size", settings->leaf_size);
    json_uint(json, "seed", settings->seed);
}

void report_picture_settings(struct json *json, const char *key, const struct lk_settings *settings)
{
    json_object(json, key);
    write_picture_settings(json, settings);
    json_object_end(json);
}

static void write_settings(struct json *json, const struct lk_settings *settings)
{
    json_object(json, "settings");
    write_picture_settings(json, settings);
    json_double(json, "time", settings->time_s);
    json_string(json, "device", settings->device);
    json_uint(json, "queue", settings->queue);
    json_double(json, "memory_limit", (double)settings->memory_limit * 1e-6); // MB, as the option
    json_bool(json, "profile", settings->profile);
    json_bool(json, "no_cache", settings->no_cache);
    json_object_end(json);
}

// How rays of each kind are traced, and why.
static void write_tracing(struct json *json, const struct lk_device_share *share)
{
    json_object(json, "tracing");
    for (int i = 0; i < LK_RAYS_COUNT; i++) {
        json_object(json, choices_rays[i]);
        json_string(json, "bvh", choices_bvh[share->tracing[i].bvh]);
        json_string(json, "trace", choices_trace[share->tracing[i].trace]);
        json_string(json, "from", choices_reason[share->tracing[i].reason]);
        json_object_end(json);
    }
    json_double(json, "probe_s", share->probe_s);
    json_bool(json, "fused", share->fused);
    json_object_end(json);
}

// Each device, what was chosen for it, and its part of the paths.
static void write_devices(struct json *json, const struct lk_render_info *info)
{
    json_array(json, "device");
    for (uint32_t i = 0; i < info->device_count; i++) {
        const struct lk_device_share *share = &info->devices[i];
        json_object(json, NULL);
        json_string(json, "platform", share->info.platform);
        json_string(json, "name", share->info.name);
        json_string(json, "driver", share->info.driver);
        json_string(json, "type", share->info.type);
        json_uint(json, "compute_units", share->info.compute_units);
        json_string(json, "trace", choices_trace[share->trace]);
        json_string(json, "bvh", choices_bvh[share->bvh]);
        write_tracing(json, share);
        json_string(json, "textures", choices_textures[share->textures]);
        json_uint(json, "queue", share->queue);
        json_uint(json, "memory_bytes", share->memory);
        json_uint(json, "paths", share->paths);
        json_double(json, "share",
                    info->paths > 0 ? (double)share->paths / (double)info->paths : 0.0);
        json_double(json, "busy_s", share->busy_s);
        json_object_end(json);
    }
    json_array_end(json);
}

static void write_memory(struct json *json, const struct lk_memory *memory)
{
    json_object(json, "memory_bytes");
    json_uint(json, "bvh", memory->bvh);
    json_uint(json, "geometry", memory->geometry);
    json_uint(json, "materials", memory->materials);
    json_uint(json, "lights", memory->lights);
    json_uint(json, "rays", memory->rays);
    json_uint(json, "samples", memory->samples);
    json_uint(json, "film", memory->film);
    json_uint(json, "total_device", memory->total_device);
    json_uint(json, "peak_host", memory->peak_host);
    json_object_end(json);
}

static void write_times(struct json *json, const struct lk_render_info *info, double write_s)
{
    json_object(json, "time_s");
    json_double(json, "import", info->time_s.import);
    json_double(json, "prepare", info->time_s.prepare);
    json_double(json, "upload", info->time_s.upload);
    json_double(json, "kernel_build", info->time_s.kernel_build);
    json_double(json, "render", info->time_s.render);
    json_double(json, "write", write_s);
    json_double(json, "total", info->time_s.total + write_s);
    json_object_end(json);
}

static void write_kernels(struct json *json, const struct lk_render_info *info)
{
    double total_s = 0.0;
    for (uint32_t i = 0; i < info->kernel_count; i++)
        total_s += info->kernels[i].time_s;

    json_array(json, "kernels");
    for (uint32_t i = 0; i < info->kernel_count; i++) {
        const struct lk_kernel_time *kernel = &info->kernels[i];
        json_object(json, NULL);
        json_string(json, "name", kernel->name);
        json_uint(json, "calls", kernel->calls);
        json_double(json, "time_s", kernel->time_s);
        json_double(json, "share", total_s > 0.0 ? kernel->time_s / total_s : 0.0);
        if (kernel->rays > 0)
            json_double(json, "rays_per_s", (double)kernel->rays / kernel->time_s);
        if (kernel->bytes > 0)
            json_double(json, "bytes_per_s", (double)kernel->bytes / kernel->time_s);
        json_object_end(json);
    }
    json_array_end(json);
}

static void write_rays(struct json *json, const struct lk_render_info *info)
{
    const uint64_t total = info->rays_camera + info->rays_indirect + info->rays_shadow;
    const double seconds = info->time_s.render;
    json_object(json, "rays");
    json_uint(json, "camera", info->rays_camera);
    json_uint(json, "indirect", info->rays_indirect);
    json_uint(json, "shadow", info->rays_shadow);
    json_uint(json, "directional", info->rays_directional);
    json_uint(json, "total", total);
    json_object_end(json);
    json_uint(json, "paths", info->paths);
    json_double(json, "spp", info->spp);
    json_double(json, "rays_per_s", seconds > 0.0 ? (double)total / seconds : 0.0);
    json_double(json, "paths_per_s", seconds > 0.0 ? (double)info->paths / seconds : 0.0);
}

enum status report_write(struct json *json, const struct lk_render_info *info, const char *version,
                         double write_s)
{
    json_object(json, NULL);
    json_string(json, "version", version);
    write_scene(json, &info->scene);
    write_settings(json, &info->settings);
    write_devices(json, info);
    write_memory(json, &info->scene.memory);
    write_times(json, info, write_s);
    if (info->kernel_count > 0)
        write_kernels(json, info);
    write_rays(json, info);
    json_uint(json, "kernels_from_source", info->kernels_from_source);
    if (info->noise >= 0.0)
        json_double(json, "noise", info->noise);
    else
        json_null(json, "noise"); // not estimated
    json_object_end(json);
    return json_finish(json);
}
