// Traces the same triangles with the same rays as a peer does, in turns, and prints the ratios.
//
//   peers embree SCENE [the options of `lightkiln bench`]
//
// The machine's absolute speed drifts, so runs of both sides alternate, and a ratio is the median
// of those of neighbouring runs. Embree is given the best build quality, one thread a core, and
// denormals flushed to zero, as its manual advises; rays one by one (rtcIntersect1, rtcOccluded1),
// and primary rays also in packets of 16.

#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xmmintrin.h>

#include "cli/bench_rays.h"
#include "cli/options.h"
#include "core/clock.h"

#define CHUNK   4096u // rays that a thread takes at a time
#define PACKET  16
#define RUN_MAX 1000

enum side { OURS, THESIS, EMBREE, EMBREE_PACKETS, SIDES };

static const char *const side_names[SIDES] = {"lightkiln", "thesis variant", "embree single",
                                              "embree packets"};

struct peers {
    struct options options;
    struct lk_scene *scene;            // owned
    struct lk_tracer *tracers[EMBREE]; // ours; owned
    struct ray_set sets[RAY_CLASSES];
    struct lk_geometry geometry;
    RTCDevice device;    // owned
    RTCScene embree;     // owned
    double embree_s;     // its build took
    struct lk_hit *hits; // [rays of the largest set] of Embree; owned
    double seconds[RAY_CLASSES][SIDES][RUN_MAX];
    uint32_t differ[RAY_CLASSES]; // hits of ours and Embree that are not at one place
};

// ---- Embree

static void build_embree(struct peers *p)
{
    const struct lk_geometry *g = &p->geometry;
    const double start = clock_seconds();
    p->device = rtcNewDevice(NULL);
    RTCGeometry mesh = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g->positions, 0,
                               g->position_stride * sizeof(float), g->vertex_count);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g->corners, 0,
                               g->corner_stride * sizeof(uint32_t), g->triangle_count);
    rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(mesh);
    p->embree = rtcNewScene(p->device);
    rtcSetSceneBuildQuality(p->embree, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(p->embree, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(p->embree);
    p->embree_s = clock_seconds() - start;
}

static struct RTCRay make_ray(const struct lk_ray *ray)
{
    const struct RTCRay made = {
        .org_x = ray->org[0],
        .org_y = ray->org[1],
        .org_z = ray->org[2],
        .tnear = ray->tmin,
        .dir_x = ray->dir[0],
        .dir_y = ray->dir[1],
        .dir_z = ray->dir[2],
        .tfar = ray->tmax,
        .mask = 0xffffffffu,
    };
    return made;
}

static void intersect(const struct peers *p, struct lk_hit *hits, const struct lk_ray *rays,
                      uint32_t count)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (uint32_t i = 0; i < count; i++) {
        struct RTCRayHit ray = {.ray = make_ray(&rays[i])};
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(p->embree, &context, &ray);
        const bool is_hit = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits[i] = (struct lk_hit){ray.ray.tfar, ray.hit.u, ray.hit.v,
                                  is_hit ? ray.hit.primID : LK_HIT_NONE};
    }
}

static void occlude(const struct peers *p, struct lk_hit *hits, const struct lk_ray *rays,
                    uint32_t count)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (uint32_t i = 0; i < count; i++) {
        struct RTCRay ray = make_ray(&rays[i]);
        rtcOccluded1(p->embree, &context, &ray);
        hits[i].triangle = ray.tfar < 0.0f ? 0 : LK_HIT_NONE;
    }
}

static void load_packet(struct RTCRayHit16 *out, int *valid, const struct lk_ray *rays,
                        uint32_t count)
{
    memset(out, 0, sizeof(*out));
    for (uint32_t k = 0; k < PACKET; k++) {
        const struct lk_ray *ray = &rays[k < count ? k : 0];
        valid[k] = k < count ? -1 : 0;
        out->ray.org_x[k] = ray->org[0];
        out->ray.org_y[k] = ray->org[1];
        out->ray.org_z[k] = ray->org[2];
        out->ray.tnear[k] = ray->tmin;
        out->ray.dir_x[k] = ray->dir[0];
        out->ray.dir_y[k] = ray->dir[1];
        out->ray.dir_z[k] = ray->dir[2];
        out->ray.tfar[k] = ray->tmax;
        out->ray.mask[k] = 0xffffffffu;
        out->hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
}

static void intersect_packets(const struct peers *p, struct lk_hit *hits, const struct lk_ray *rays,
                              uint32_t count)
{
    struct RTCIntersectContext context;
    struct RTCRayHit16 packet;
    _Alignas(64) int valid[PACKET];
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (uint32_t i = 0; i < count; i += PACKET) {
        const uint32_t part = count - i < PACKET ? count - i : PACKET;
        load_packet(&packet, valid, rays + i, part);
        rtcIntersect16(valid, p->embree, &context, &packet);
        for (uint32_t k = 0; k < part; k++) {
            const bool is_hit = packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
            hits[i + k] = (struct lk_hit){packet.ray.tfar[k], packet.hit.u[k], packet.hit.v[k],
                                          is_hit ? packet.hit.primID[k] : LK_HIT_NONE};
        }
    }
}

// Traces a whole set with all threads. Returns the seconds it took.
static double run_embree(struct peers *p, const struct ray_set *set, bool packets)
{
    const double start = clock_seconds();
    const uint32_t chunks = (set->count + CHUNK - 1) / CHUNK;
#pragma omp parallel
    {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#pragma omp for schedule(dynamic)
        for (uint32_t i = 0; i < chunks; i++) {
            const uint32_t first = i * CHUNK;
            const uint32_t count = set->count - first < CHUNK ? set->count - first : CHUNK;
            if (packets)
                intersect_packets(p, p->hits + first, set->rays + first, count);
            else if (set->any_hit)
                occlude(p, p->hits + first, set->rays + first, count);
            else
                intersect(p, p->hits + first, set->rays + first, count);
        }
    }
    return clock_seconds() - start;
}

// ---- both

static bool takes_part(enum side side, enum ray_class class)
{
    return side != EMBREE_PACKETS || class == RAYS_PRIMARY;
}

static enum status run_side(struct peers *p, double *seconds, enum ray_class class, enum side side)
{
    const struct ray_set *set = &p->sets[class];
    if (side >= EMBREE) {
        *seconds = run_embree(p, set, side == EMBREE_PACKETS);
        return STATUS_OK;
    }
    return (enum status)lk_tracer_run(p->tracers[side], seconds, set->any_hit, 1);
}

// Counts the hits of the last runs that differ.
static enum status count_differences(struct peers *p, enum ray_class class)
{
    const struct ray_set *set = &p->sets[class];
    struct lk_hit *ours = malloc((set->count + 1) * sizeof(*ours));
    if (ours == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u hits", set->count);
    const enum status status = (enum status)lk_tracer_hits(p->tracers[OURS], ours);
    run_embree(p, set, false);
    for (uint32_t i = 0; i < set->count && status == STATUS_OK; i++) {
        const bool one_kind =
            (ours[i].triangle == LK_HIT_NONE) == (p->hits[i].triangle == LK_HIT_NONE);
        const bool far = !set->any_hit && ours[i].triangle != LK_HIT_NONE &&
                         fabsf(ours[i].t - p->hits[i].t) > 1e-3f * (1.0f + p->hits[i].t);
        p->differ[class] += !one_kind || far;
    }
    free(ours);
    return status;
}

static enum status measure_class(struct peers *p, enum ray_class class)
{
    const struct ray_set *set = &p->sets[class];
    double unused;
    enum status status = STATUS_OK;
    for (int i = 0; i < EMBREE && status == STATUS_OK; i++)
        status = (enum status)lk_tracer_set_rays(p->tracers[i], set->rays, set->count);
    for (int i = 0; i < 2 * SIDES && status == STATUS_OK; i++) // warm up
        if (takes_part(i % SIDES, class))
            status = run_side(p, &unused, class, i % SIDES);
    for (uint32_t run = 0; run < p->options.runs && status == STATUS_OK; run++)
        for (int side = 0; side < SIDES && status == STATUS_OK; side++)
            if (takes_part(side, class))
                status = run_side(p, &p->seconds[class][side][run], class, side);
    return status == STATUS_OK ? count_differences(p, class) : status;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts what a row shows and prints it: least, median, most.
static void print_cell(double *values, uint32_t count, const char *format)
{
    char text[64];
    qsort(values, count, sizeof(*values), compare_doubles);
    snprintf(text, sizeof(text), format, values[count / 2], values[0], values[count - 1]);
    printf(" %-20s", text);
}

// Prints the ratios of ours to one side of Embree's.
static void print_ratios(const struct peers *p, enum side ours, enum side other)
{
    char name[64];
    snprintf(name, sizeof(name), "%s / %s", side_names[ours], side_names[other]);
    printf("%-32s", name);
    for (int class = 0; class < RAY_CLASSES; class ++) {
        double ratios[RUN_MAX];
        if (!takes_part(other, class))
            continue;
        for (uint32_t run = 0; run < p->options.runs; run++)
            ratios[run] = p->seconds[class][other][run] / p->seconds[class][ours][run];
        print_cell(ratios, p->options.runs, "%.3f (%.2f-%.2f)");
    }
    printf("\n");
}

static void print_rates(const struct peers *p, enum side side)
{
    printf("%-32s", side_names[side]);
    for (int class = 0; class < RAY_CLASSES; class ++) {
        double rates[RUN_MAX];
        if (!takes_part(side, class))
            continue;
        for (uint32_t run = 0; run < p->options.runs; run++)
            rates[run] = p->sets[class].count / p->seconds[class][side][run] * 1e-6;
        print_cell(rates, p->options.runs, "%.2f (%.2f-%.2f)");
    }
    printf("\n");
}

static void print_tables(const struct peers *p)
{
    const struct lk_tracer_info *info = lk_tracer_info(p->tracers[OURS]);
    printf("%s, %llu triangles, %u x %u, %u view%s, %s\n", p->options.operands[1],
           (unsigned long long)p->geometry.triangle_count, info->width, info->height,
           p->options.views, p->options.views > 1 ? "s" : "", info->device.name);
    printf("build, s: %s %.2f, %s %.2f, Embree %.2f\n", side_names[OURS], info->build_s,
           side_names[THESIS], lk_tracer_info(p->tracers[THESIS])->build_s, p->embree_s);
    printf("%-32s", "Mrays/s: median (least-most)");
    for (int class = 0; class < RAY_CLASSES; class ++)
        printf(" %-20s", ray_class_names[class]);
    printf("\n");
    for (int side = 0; side < SIDES; side++)
        print_rates(p, side);
    print_ratios(p, OURS, EMBREE);
    print_ratios(p, OURS, EMBREE_PACKETS);
    print_ratios(p, THESIS, EMBREE);
    printf("%-32s", "hits that differ, of");
    for (int class = 0; class < RAY_CLASSES; class ++) {
        char text[32];
        snprintf(text, sizeof(text), "%u, %u", p->differ[class], p->sets[class].count);
        printf(" %-20s", text);
    }
    printf("\n");
}

static enum status run(struct peers *p)
{
    struct lk_settings thesis = p->options.settings;
    thesis.bvh_build = LK_BVH_BUILD_THESIS;
    thesis.bvh = LK_BVH_BINARY;
    thesis.trace = LK_TRACE_PERSISTENT;
    enum status status = (enum status)lk_scene_load(&p->scene, p->options.operands[1]);
    if (status == STATUS_OK)
        status = (enum status)lk_tracer_create(&p->tracers[OURS], p->scene, &p->options.settings);
    if (status == STATUS_OK)
        status = (enum status)lk_tracer_create(&p->tracers[THESIS], p->scene, &thesis);
    if (status == STATUS_OK)
        status = ray_sets_make(p->sets, p->scene, p->tracers[OURS], p->options.views);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_geometry(&p->geometry, p->scene);
    if (status == STATUS_OK) {
        p->hits = calloc(p->sets[RAYS_PRIMARY].count, sizeof(*p->hits));
        if (p->hits == NULL)
            status = status_fail(STATUS_NO_MEMORY, "no memory for hits");
    }
    if (status == STATUS_OK)
        build_embree(p);
    for (int class = 0; class < RAY_CLASSES && status == STATUS_OK; class ++)
        status = measure_class(p, class);
    return status;
}

static void release(struct peers *p)
{
    free(p->hits);
    if (p->embree != NULL)
        rtcReleaseScene(p->embree);
    if (p->device != NULL)
        rtcReleaseDevice(p->device);
    ray_sets_free(p->sets);
    for (int i = 0; i < EMBREE; i++)
        lk_tracer_free(p->tracers[i]);
    lk_scene_free(p->scene);
    free(p);
}

// OpenMP's threads would spin for a while after their work, on the cores that the other side's run
// wants. Only the environment keeps them from it, from the start of the program.
static void start_again_passive(char **argv)
{
    if (getenv("OMP_WAIT_POLICY") != NULL)
        return;
    setenv("OMP_WAIT_POLICY", "passive", 1);
    execv("/proc/self/exe", argv);
}

int main(int argc, char **argv)
{
    start_again_passive(argv);
    struct peers *p = calloc(1, sizeof(*p));
    if (p == NULL)
        return 1;
    enum status status = options_parse(&p->options, COMMAND_BENCH, argv + 1, argc - 1);
    if (status == STATUS_OK && strcmp(p->options.operands[0], "embree") != 0)
        status = status_fail(STATUS_USAGE, "there is no peer %s; there is embree",
                             p->options.operands[0]);
    if (status == STATUS_OK)
        status = run(p);
    if (status == STATUS_OK)
        print_tables(p);
    else
        fprintf(stderr, "peers: %s\n", lk_error());
    release(p);
    return status != STATUS_OK;
}
