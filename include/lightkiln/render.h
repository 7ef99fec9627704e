/**
 * @file
 * Rendering, and what is told about it.
 */
#ifndef LIGHTKILN_RENDER_H
#define LIGHTKILN_RENDER_H

#include <stdbool.h>
#include <stdint.h>

#include "lightkiln/device.h"
#include "lightkiln/scene.h"
#include "lightkiln/settings.h"
#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What the progress function hears, a few times a second. */
struct lk_progress {
    const char *stage;  // "preparing", "building kernels", "rendering"
    double fraction;    // 0 .. 1 of the stage
    double elapsed_s;   // since lk_render() was called
    double remaining_s; // estimate; negative while unknown
    double spp;         // samples per pixel so far
    double mrays_per_s; // million rays a second so far, shadow rays counted
};

/** Who hears it. */
struct lk_progress_hook {
    bool (*function)(void *user, const struct lk_progress *progress); // false cancels; borrowed
    void *user;
};

struct lk_image; // lightkiln/image.h

/**
 * Renders. Equal scene, settings and device give equal bits. So do several devices of one kind, and
 * the same bits as one of them: who does which part changes nothing. Devices of different kinds
 * round differently, so that the picture may differ from run to run by what each makes of the same
 * paths.
 *
 * @param[out] out  Written on LK_OK and on LK_CANCELLED (then with what was finished, if anything
 * was, else NULL).
 * @param hook      NULL: none.
 * @retval LK_USAGE      A setting is out of range, or there is no such camera.
 * @retval LK_NO_DEVICE  No usable device matches.
 * @retval LK_NO_MEMORY  It does not fit the host or the device; names the largest users.
 * @retval LK_DEVICE     An OpenCL call failed; names it.
 * @retval LK_CANCELLED  The hook returned false.
 */
LK_API enum lk_status lk_render(struct lk_image **out, struct lk_scene *scene,
                                const struct lk_settings *settings,
                                const struct lk_progress_hook *hook);

/** What all launches of one kernel took. */
struct lk_kernel_time {
    char name[32];
    uint64_t calls;
    double time_s;
    uint64_t rays;  // that it traced; 0: it traces none
    uint64_t bytes; // that it read and wrote in whole rows, without caches; 0: not known
};

/** Kinds of rays, each of which is traced in a way of its own. */
enum lk_rays {
    LK_RAYS_CAMERA,
    LK_RAYS_FIRST_BOUNCE,
    LK_RAYS_LATER_BOUNCES,
    LK_RAYS_SHADOW,
    LK_RAYS_COUNT
};

/** Why rays are traced as they are. */
enum lk_reason {
    LK_REASON_FORCED, // the settings say so
    LK_REASON_RULE,   // by the kind of the device, and where a bounce is one kernel
    LK_REASON_PROBE,  // measured in this render
    LK_REASON_CACHE   // measured before, on this device in a scene as large as this
};

/** How rays of one kind are traced. */
struct lk_tracing {
    enum lk_trace trace;
    enum lk_bvh bvh;
    enum lk_reason reason;
};

/** Most that are told of. */
#define LK_KERNELS_MAX 32
#define LK_DEVICES_MAX 16

/** One device's part of a render. */
struct lk_device_share {
    struct lk_device_info info; // compute_units: those it used
    enum lk_trace trace;        // as chosen for it: how later bounces are traced
    enum lk_bvh bvh;
    struct lk_tracing tracing[LK_RAYS_COUNT]; // how all rays are
    double probe_s;                           // measuring that took
    bool fused;                               // a bounce, or a whole path, was one kernel
    enum lk_textures textures;
    uint32_t queue;
    uint64_t memory; // bytes it takes there
    uint64_t paths;  // that it finished
    double busy_s;   // rendering them took
};

/** What a render did. Times in seconds. */
struct lk_render_info {
    struct lk_scene_info scene; // file is borrowed from the image
    struct lk_settings
        settings; // with every default filled in; strings are borrowed from the image
    struct lk_device_info device; // the first of
    uint32_t device_count;        // those that took part;
    struct lk_device_share devices[LK_DEVICES_MAX];
    // With several devices, upload and kernel_build are those of the slowest, and render begins
    // when the first is ready.
    struct {
        double import, prepare, upload, kernel_build, render, total;
    } time_s;
    uint64_t rays_camera, rays_indirect, rays_shadow;
    uint64_t rays_directional; // those of rays_shadow towards directional lights and surroundings
    uint64_t paths;
    double spp;                   // samples per pixel, with a fraction if pixels differ
    double noise;                 // reached, as estimated if settings.noise is set; else, and where
                                  // pixels have 8 samples or less, negative
    uint32_t kernels_from_source; // programs compiled, 0 on a warm start
    uint32_t kernel_count;        // kernels, 0 without profile
    struct lk_kernel_time kernels[LK_KERNELS_MAX];
};

/** The info of a rendered image; NULL for one that was read from a file. Borrowed. */
LK_API const struct lk_render_info *lk_image_info(const struct lk_image *image);

/** Writes the JSON report of a rendered image. @retval LK_WRITE, LK_USAGE (not a rendered image) */
LK_API enum lk_status lk_report_write(const struct lk_image *image, const char *path);

#ifdef __cplusplus
}
#endif

#endif
