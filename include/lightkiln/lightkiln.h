/**
 * @file
 * lightkiln: path-traced global illumination for glTF levels on any OpenCL device.
 *
 * The whole of it on one page:
 *
 *     struct lk_settings settings;
 *     lk_settings_init(&settings);
 *     settings.spp = 256;
 *
 *     struct lk_scene *scene = NULL;
 *     struct lk_image *image = NULL;
 *     if (lk_scene_load(&scene, "level.glb") != LK_OK ||
 *         lk_render(&image, scene, &settings, NULL) != LK_OK ||
 *         lk_image_write(image, "level.exr", NULL) != LK_OK)
 *         fprintf(stderr, "%s\n", lk_error());
 *     lk_image_free(image);
 *     lk_scene_free(scene);
 *
 * Conventions. Every function that can fail returns an lk_status; its result goes through the first
 * parameter, on success only, and lk_error() then tells what went wrong, naming the file, mesh or
 * device. Metres, Y up, linear Rec. 709; light in the file's units (candela, lux, and cd/m2 for
 * radiance). Functions may be called from any thread, but one object from one at a time. Free
 * functions accept NULL.
 */
#ifndef LIGHTKILN_LIGHTKILN_H
#define LIGHTKILN_LIGHTKILN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LK_API __attribute__((visibility("default")))

enum lk_status {
    LK_OK,
    LK_NO_MEMORY,   // host or device memory
    LK_IO,          // a file cannot be read
    LK_WRITE,       // a file cannot be written; an old one is left alone
    LK_FORMAT,      // bad input
    LK_UNSUPPORTED, // input that needs what is not there
    LK_LIMIT,       // input larger than the engine's indices reach
    LK_NO_DEVICE,   // no OpenCL device matches
    LK_DEVICE,      // an OpenCL call failed
    LK_USAGE,       // an argument is out of range
    LK_CANCELLED    // the progress function said so; the image holds what was finished
};

/** What went wrong last on this thread; "" if nothing has. Valid until the thread's next failure.
 */
LK_API const char *lk_error(void);

/** A status as words, "out of memory". */
LK_API const char *lk_status_name(enum lk_status status);

/** "0.1.0 (commit)". */
LK_API const char *lk_version(void);

enum lk_log_level { LK_LOG_ERROR, LK_LOG_WARNING, LK_LOG_INFO, LK_LOG_DEBUG };

typedef void lk_log_function(void *user, enum lk_log_level level, const char *message);

/** Sends messages up to `level` to `function`, or to stderr if it is NULL. At the start: warnings,
 * to stderr. It is called one message at a time, during a render from any thread. */
LK_API void lk_log_set(enum lk_log_level level, lk_log_function *function, void *user);

/** Counts the warnings since the program began, shown or not. */
LK_API unsigned lk_warning_count(void);

// ---- Scenes
// -----------------------------------------------------------------------------------------------------

/** A loaded scene. Opaque. */
struct lk_scene;

/**
 * Loads glTF 2.0 (.gltf or .glb); "-" reads a GLB from standard input.
 *
 * @retval LK_IO, LK_FORMAT, LK_UNSUPPORTED, LK_LIMIT, LK_NO_MEMORY
 */
LK_API enum lk_status lk_scene_load(struct lk_scene **out, const char *path);

LK_API void lk_scene_free(struct lk_scene *scene);

struct lk_lights {
    uint64_t point, spot, rect, disc, directional; // the sun of a sky is directional
    uint64_t emissive_triangles;                   // those in rectangles, too
    uint64_t drawn; // that a hit draws from: all but directional, a rectangle as one
};

/** Bytes on the device, but for peak_host. */
struct lk_memory {
    uint64_t bvh;       // nodes, Woop rows, reference words
    uint64_t geometry;  // vertices, triangles
    uint64_t materials; // with textures
    uint64_t lights;    // with their hierarchy and the environment
    uint64_t rays;      // per-path data of the ray queue
    uint64_t samples;   // what all paths share: points of samples, the list of pixels
    uint64_t film;      // accumulators
    uint64_t total_device;
    uint64_t peak_host; // largest resident size of this process so far
};

struct lk_scene_info {
    const char *file;         // as given; borrowed from the scene
    uint64_t triangles;       // after flattening instances
    uint64_t triangles_split; // references in the BVH, after early split clipping
    uint64_t instances, materials, textures, cameras;
    struct lk_lights lights;
    struct lk_memory memory; // for the given settings; rays and film by image size and queue
    uint32_t width, height;  // of the image these settings ask for
};

struct lk_settings;

/**
 * Tells what a render of this scene would hold, without rendering or touching any device. Does the
 * preparation if it has not been done for these settings. The ray queue is taken as large as the
 * image or 2^21 paths, whichever is less, and the BVH as binary unless the settings name a layout.
 */
LK_API enum lk_status lk_scene_info(struct lk_scene_info *out, struct lk_scene *scene,
                                    const struct lk_settings *settings);

/** The name of camera `index`, its node's if it has none, "" if neither; NULL past the last.
 * Borrowed from the scene. */
LK_API const char *lk_scene_camera(const struct lk_scene *scene, size_t index);

// ---- Devices
// ----------------------------------------------------------------------------------------------------

struct lk_device_info {
    char platform[128];
    char name[128];
    char driver[128];
    char version[128];                     // what the device says of its OpenCL
    char type[16];                         // "cpu", "gpu", "accelerator", "custom"
    uint32_t platform_index, device_index; // the P:D of --device
    uint32_t compute_units;
    uint64_t global_memory, max_allocation, local_memory; // bytes
    bool usable;                                          // OpenCL 1.2 with a compiler
    char reason[128];                                     // if not usable: why
};

/**
 * Describes device `index` of all platforms.
 *
 * @retval LK_NO_DEVICE  No platform, or `index` is past the last device.
 */
LK_API enum lk_status lk_device_info(struct lk_device_info *out, size_t index);

// ---- Rendering
// --------------------------------------------------------------------------------------------------

enum lk_quantity {
    LK_RADIANCE,   // what the camera sees, cd/m2
    LK_IRRADIANCE, // at the first hit, all that arrives on the shaded side, lux; its own colour and
                   // emission are left out
    LK_DIRECT      // radiance of emission and direct light alone
};

enum lk_brdf {
    LK_BRDF_GLTF, // metallic-roughness of glTF 2.0 appendix B, and specular-glossiness
    LK_BRDF_PHONG // the thesis's: diffuse + specular colour, exponent from glossiness, 1 is a
                  // mirror, no Fresnel
};

enum lk_light_sampler {
    LK_LIGHTS_AUTO,      // importance
    LK_LIGHTS_TREE,      // the light tree of thesis section 3.4
    LK_LIGHTS_UNIFORM,   // one of all
    LK_LIGHTS_ALL,       // every light at every hit
    LK_LIGHTS_IMPORTANCE // several by estimated contribution (Conty Estevez and Kulla 2018)
};

enum lk_sampler {
    LK_SAMPLER_SOBOL, // spread evenly among each other: Owen-scrambled Sobol points
    LK_SAMPLER_RANDOM // independent
};

enum lk_trace {
    LK_TRACE_AUTO,       // by the device; a GPU measures what is fast in this scene
    LK_TRACE_SIMPLE,     // one ray a work item
    LK_TRACE_PERSISTENT, // work fetched from a queue (Aila & Laine 2009)
    LK_TRACE_POSTPONING, // one ray a work item; a warp tests leaves together (NVIDIA)
    LK_TRACE_WARPS       // the same, with a queue for each warp, or over wider BVHs for each lane
};

enum lk_bvh {
    LK_BVH_AUTO,      // as LK_TRACE_AUTO
    LK_BVH_BINARY,    // the thesis's
    LK_BVH_WIDE,      // 8 children a node, triangles by four: for CPUs
    LK_BVH_QUAD,      // 4 children a node, boxes as bytes: for GPUs
    LK_BVH_COMPRESSED // 8 children a node, boxes as bytes (Ylitie et al. 2017): for GPUs
};

enum lk_bvh_build {
    LK_BVH_BUILD_SBVH,  // may split triangles (Stich et al. 2009), improved by reinsertion
    LK_BVH_BUILD_THESIS // thesis section 3.1
};

enum lk_textures {
    LK_TEXTURES_AUTO,
    LK_TEXTURES_BOUND, // rays sorted by material, one launch each with its images bound (thesis
                       // section 3.3)
    LK_TEXTURES_POOL   // one launch over all texels
};

enum lk_nodes {
    LK_NODES_BUFFER,
    LK_NODES_TEXTURE // binary BVH's nodes through a 1D texture (thesis section 3.2)
};

enum lk_tonemap {
    LK_TONEMAP_AUTO, // aces for 8-bit files
    LK_TONEMAP_NONE,
    LK_TONEMAP_REINHARD,
    LK_TONEMAP_ACES
};

/** Fill with lk_settings_init() first; a 0 or NULL where that is noted asks for the default. */
struct lk_settings {
    uint32_t width, height; // pixels, 1 .. 16384; 0: 1024 wide, or by the camera's aspect
    const char *camera;     // name, node's name or index; NULL: the first
    uint32_t spp;           // stop after so many samples per pixel; default 64; 0: no such limit
    double time_s;          // stop after so many seconds of rendering; 0: no such limit
    float noise;            // stop at this noise, the relative error that one tile of 256 pixels in
                            // a hundred exceeds; noisier tiles get more samples than others. A
                            // tile's error is the root mean square over pixels and channels of what
                            // they are off, relative to that of their values, or to a tenth of the
                            // picture's mean where this is more. 0: no such limit
    uint32_t depth;         // shaded hits of a path, 1 .. 255; default 5
    uint32_t roulette_depth; // first hits that every path goes on from; at later ones Russian
                             // roulette may end it (thesis section 3.5), which changes noise and
                             // time but no mean. 0 .. 255; default 2; the depth: never
    uint32_t shadow_rays;    // times that a hit draws lights, 1 .. 64; default 1. Tree and uniform
                             // draw one light each time and send one shadow ray, importance up to
                             // 8, none of them twice, and fewer where few lights send nearly
                             // all; all takes no notice
    enum lk_light_sampler light_sampler;
    enum lk_sampler sampler; // how samples of a pixel are spread
    enum lk_quantity quantity;
    enum lk_brdf brdf;
    const char *env;        // lat-long image that lights the scene, HDR or EXR; its middle looks
                            // along -Z, +X is to the right of that; NULL: none
    float env_rotation_deg; // of that image about +Y, counter-clockwise from above; default 0
    float env_strength;     // factor of that image, or of sky and sun; default 1. Both are applied
                            // to the scene's own image, if it has one, where none is asked for
    float background[3];    // radiance from all around, cd/m2; default 0, 0, 0
    float sky_sun_deg[2];   // azimuth (0 is -Z, 90 is +X) and elevation, up to 90, of the sun of
                            // a clear sky; elevation 0: no sky. Of env, background and sky at
                            // most one
    float sky_turbidity;    // haze of that sky, 2 .. 10; default 3
    const char *device;     // devices, with commas between: each takes the best that matches and
                            // is not taken, of "cpu", "gpu", "P:D" or part of a name; "all" takes
                            // every one. NULL: the best
    enum lk_trace trace;
    enum lk_bvh bvh;
    enum lk_bvh_build bvh_build;
    enum lk_textures textures;
    enum lk_nodes nodes;
    float split_threshold; // largest box surface of a reference, m2; 0: no splitting
    uint32_t leaf_size;    // no leaf has so many triangles, 2 .. 32; by the thesis's builder every
                           // node with fewer is one; default 8
    uint32_t seed;
    uint32_t queue;        // paths in flight; 0: by the device
    uint64_t memory_limit; // bytes on the device; 0: what the device has
    bool profile;          // time every kernel
    bool no_cache;         // build kernels from source, and measure anew how to trace
};

LK_API void lk_settings_init(struct lk_settings *settings);

/** What the progress function hears, a few times a second. */
struct lk_progress {
    const char *stage;  // "preparing", "building kernels", "rendering"
    double fraction;    // 0 .. 1 of the stage
    double elapsed_s;   // since lk_render() was called
    double remaining_s; // estimate; negative while unknown
    double spp;         // samples per pixel so far
    double mrays_per_s; // million rays a second so far, shadow rays counted
};

struct lk_progress_hook {
    bool (*function)(void *user, const struct lk_progress *progress); // false cancels; borrowed
    void *user;
};

/** A rendered image, with what is to be told about it. Opaque. */
struct lk_image;

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
    LK_REASON_RULE,   // by the kind of the device
    LK_REASON_PROBE,  // measured in this render
    LK_REASON_CACHE   // measured before, on this device in a scene as large as this
};

/** How rays of one kind are traced. */
struct lk_tracing {
    enum lk_trace trace;
    enum lk_bvh bvh;
    enum lk_reason reason;
};

#define LK_KERNELS_MAX 32
#define LK_DEVICES_MAX 16

/** One device's part of a render. */
struct lk_device_share {
    struct lk_device_info info; // compute_units: those it used
    enum lk_trace trace;        // as chosen for it: how later bounces are traced
    enum lk_bvh bvh;
    struct lk_tracing tracing[LK_RAYS_COUNT]; // how all rays are
    double probe_s;                           // measuring that took
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

/** Width, height and pixels of an image: [width * height * 3] linear RGB, rows from the top.
 * Borrowed. */
LK_API const float *lk_image_pixels(const struct lk_image *image, uint32_t *width,
                                    uint32_t *height);

/** Display transform of 8-bit files; never touches the others. NULL where it is taken: exposure 0,
 * tonemap auto. */
struct lk_display {
    float exposure_ev; // stops
    enum lk_tonemap tonemap;
};

/**
 * Writes .exr, .hdr, .tif (linear float), .png or .jpg (8 bits, exposed, tone-mapped, sRGB). Whole
 * or not at all.
 *
 * @retval LK_USAGE  The extension is none of these.
 * @retval LK_WRITE  It cannot be written; an old file is left alone.
 */
LK_API enum lk_status lk_image_write(const struct lk_image *image, const char *path,
                                     const struct lk_display *display);

/** Checks that lk_image_write() knows the extension and may write there, before hours are spent.
 * LK_USAGE or LK_WRITE if not. */
LK_API enum lk_status lk_image_can_write(const char *path);

/** Reads an image file as linear RGB; 8-bit files are decoded from sRGB. */
LK_API enum lk_status lk_image_read(struct lk_image **out, const char *path);

/**
 * Makes an image of one's own pixels.
 *
 * @param pixels  [width * height * 3] linear RGB, rows from the top; copied.
 * @retval LK_USAGE, LK_NO_MEMORY
 */
LK_API enum lk_status lk_image_create(struct lk_image **out, const float *pixels, uint32_t width,
                                      uint32_t height);

LK_API void lk_image_free(struct lk_image *image);

/** Writes the JSON report of a rendered image. @retval LK_WRITE, LK_USAGE (not a rendered image) */
LK_API enum lk_status lk_report_write(const struct lk_image *image, const char *path);

// ---- Rays
// --------------------------------------------------------------------------------------------------------

/** A ray of the caller's, world space. */
struct lk_ray {
    float org[3]; // m
    float tmin;   // nearest hit accepted, m
    float dir[3]; // unit vector
    float tmax;   // farthest hit accepted, m
};

#define LK_HIT_NONE 0xffffffffu

struct lk_hit {
    float t;           // distance, m
    float u, v;        // weights of the triangle's second and third corner
    uint32_t triangle; // or LK_HIT_NONE
};

/** World-space triangles. Borrowed from the scene. */
struct lk_geometry {
    const float *positions;  // xyz of vertex i at positions + i * position_stride, m
    const uint32_t *corners; // the three vertices of triangle i at corners + i * corner_stride
    size_t position_stride, corner_stride; // in elements of these arrays
    uint64_t vertex_count, triangle_count;
};

/** Flattens the scene's instances, unless that has been done. @retval LK_NO_MEMORY, LK_FORMAT,
 * LK_LIMIT */
LK_API enum lk_status lk_scene_geometry(struct lk_geometry *out, struct lk_scene *scene);

/**
 * Tells where a light is.
 *
 * @param[out] place  xyz and 1: position, m, of a surface its middle; xyz and 0: unit direction
 * towards a light that is far away.
 * @return False if `index` is past the last light, or lk_scene_geometry() was not called yet.
 */
LK_API bool lk_scene_light(float place[4], const struct lk_scene *scene, size_t index);

/** What a ray visits on average. */
struct lk_visits {
    double nodes;     // of the binary BVH, each with the boxes of two children
    double triangles; // tested
};

/**
 * Counts, on the host, what rays visit of a scene's binary BVH: how hard they are to trace,
 * whatever traces them. All triangles are solid.
 *
 * @param settings  All that concerns building the BVH is looked at.
 * @param rays      [count]
 * @param step      Every step-th of them is looked at: 1 at least.
 * @param any_hit   They end at the first hit found.
 * @retval LK_USAGE (a step of 0), LK_NO_MEMORY, LK_FORMAT, LK_LIMIT
 */
LK_API enum lk_status lk_scene_visits(struct lk_visits *out, struct lk_scene *scene,
                                      const struct lk_settings *settings, const struct lk_ray *rays,
                                      uint32_t count, uint32_t step, bool any_hit);

/** A scene's triangles on a device, to trace rays of one's own. All of them are solid, whatever
 * their materials say. Opaque. */
struct lk_tracer;

struct lk_tracer_info {
    struct lk_device_info device;
    struct lk_settings settings; // with every default that matters here filled in; borrowed strings
    uint32_t width, height;      // of the camera's image; width * height rays fit
    uint64_t references;         // to triangles that the builder made
    uint64_t bvh_size;           // bytes on the device
    double build_s;              // building and packing the BVH took
};

/**
 * Prepares the triangles, opens a device and builds the kernels. Nothing is measured: what the
 * settings leave open goes by the kind of the device.
 *
 * @param settings  Device, camera, width, height, seed, and all that concerns BVH and traversal are
 * looked at. The strings must outlive the tracer.
 * @retval as lk_render()
 */
LK_API enum lk_status lk_tracer_create(struct lk_tracer **out, struct lk_scene *scene,
                                       const struct lk_settings *settings);

LK_API void lk_tracer_free(struct lk_tracer *tracer);

LK_API const struct lk_tracer_info *lk_tracer_info(const struct lk_tracer *tracer);

/** Makes the camera's rays, one a pixel in the order of the ray queue, as a render's first sample
 * has them. @param[out] rays [width * height] */
LK_API enum lk_status lk_tracer_camera_rays(struct lk_tracer *tracer, struct lk_ray *rays);

/** Copies rays to the device: [count], at most width * height. */
LK_API enum lk_status lk_tracer_set_rays(struct lk_tracer *tracer, const struct lk_ray *rays,
                                         uint32_t count);

#define LK_LAUNCHES_MAX 64

/**
 * Traces the rays and waits.
 *
 * @param[out] seconds  One launch took, on average. NULL: not asked for.
 * @param any_hit       Ask only whether there is a hit: of lk_hit, only triangle has a meaning, and
 * is 0 or LK_HIT_NONE.
 * @param launches      Times to do it, back to back, 1 .. LK_LAUNCHES_MAX.
 */
LK_API enum lk_status lk_tracer_run(struct lk_tracer *tracer, double *seconds, bool any_hit,
                                    uint32_t launches);

/** Copies the hits of the last run: [count of the rays set]. */
LK_API enum lk_status lk_tracer_hits(struct lk_tracer *tracer, struct lk_hit *hits);

// ---- Comparison
// -------------------------------------------------------------------------------------------------

struct lk_comparison {
    double variance; // thesis section 4.2.2: mean over pixels of the summed squared differences of
                     // R, G and B
    double rmse;     // root mean square over pixels and channels
    double relative_mse; // mean over pixels and channels of d^2 / (reference^2 + 0.01)
    double noise;        // as in struct lk_settings: what one tile in a hundred exceeds
    double psnr_db;      // with the reference's largest value as peak; infinite for equal images
    double maximum;      // largest absolute difference
    uint32_t maximum_x, maximum_y; // where
    double mean[3], reference_mean[3];
    uint64_t not_finite; // values of the image left out because they are not finite
};

/**
 * Compares two images of one size.
 *
 * @param[out] difference  NULL, or the absolute difference as an image, to be freed by the caller.
 * @retval LK_FORMAT  The sizes differ. @retval LK_NO_MEMORY
 */
LK_API enum lk_status lk_compare(struct lk_comparison *out, struct lk_image **difference,
                                 const struct lk_image *image, const struct lk_image *reference);

#ifdef __cplusplus
}
#endif

#endif
