#include "cli/bench_rays.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench_views.h"

#define VIEWS_BOUNCE (RAYS_BOUNCE_1 + 1) // whose rays views stand on

#define PI           3.14159265358979f
#define OFFSET       1e-4f   // of the scene's scale at the hit: rays leave that far above a face
#define SHADOW_REACH 0.9999f // part of the way to a light that is asked about

const char *const ray_class_names[RAY_CLASSES] = {"primary",  "bounce 1", "bounce 2",
                                                  "bounce 3", "bounce 4", "shadow"};

const float *ray_corner(const struct lk_geometry *geometry, uint32_t triangle, int corner)
{
    const uint32_t vertex = geometry->corners[triangle * geometry->corner_stride + (size_t)corner];
    return geometry->positions + vertex * geometry->position_stride;
}

static float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Scales a vector to unit length. False if it has none.
static bool normalize(float *v)
{
    const float length = sqrtf(dot(v, v));
    if (!(length > 0.0f && isfinite(length)))
        return false;
    for (int k = 0; k < 3; k++)
        v[k] /= length;
    return true;
}

// A number in [0, 1) that depends on all of its arguments (splitmix64).
static float random_unit(uint64_t ray, uint64_t salt)
{
    uint64_t z = (ray * 16 + salt + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (float)((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

// The unit normal of a face on the side that the ray comes from.
static bool face_normal(float *out, const struct lk_geometry *geometry, const struct lk_ray *ray,
                        uint32_t triangle)
{
    const float *a = ray_corner(geometry, triangle, 0);
    const float *b = ray_corner(geometry, triangle, 1);
    const float *c = ray_corner(geometry, triangle, 2);
    const float ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const float ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    for (int k = 0; k < 3; k++)
        out[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
    if (!normalize(out))
        return false;
    if (dot(out, ray->dir) > 0.0f)
        for (int k = 0; k < 3; k++)
            out[k] = -out[k];
    return true;
}

// Starts a ray a little above where another one hit.
static void leave(struct lk_ray *out, const struct lk_ray *ray, float t, const float *normal)
{
    float largest = 1.0f;
    for (int k = 0; k < 3; k++) {
        out->org[k] = ray->org[k] + t * ray->dir[k];
        largest = fmaxf(largest, fabsf(out->org[k]));
    }
    for (int k = 0; k < 3; k++)
        out->org[k] += normal[k] * OFFSET * largest;
    out->tmin = 0.0f;
    out->tmax = FLT_MAX;
}

// Turns a ray that leaves a face to one side or another: a point on a sphere that touches it.
static bool scatter(struct lk_ray *ray, const float *normal, uint32_t index, uint32_t salt)
{
    const float z = 1.0f - 2.0f * random_unit(index, 2 * salt);
    const float turn = 2.0f * PI * random_unit(index, 2 * salt + 1);
    const float radius = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    ray->dir[0] = normal[0] + radius * cosf(turn);
    ray->dir[1] = normal[1] + radius * sinf(turn);
    ray->dir[2] = normal[2] + z;
    return normalize(ray->dir);
}

// Aims a ray at a light. False if the light is behind the face.
static bool aim(struct lk_ray *ray, const float *normal, const float *place)
{
    for (int k = 0; k < 3; k++)
        ray->dir[k] = place[k] - place[3] * ray->org[k];
    const float length = sqrtf(dot(ray->dir, ray->dir));
    if (place[3] > 0.0f)
        ray->tmax = length * SHADOW_REACH;
    return normalize(ray->dir) && dot(ray->dir, normal) > 0.0f;
}

// The lights of a scene; one straight above if there is none.
struct lights {
    float (*places)[4]; // [count]; owned
    size_t count;
};

static enum status find_lights(struct lights *out, const struct lk_scene *scene)
{
    float place[4] = {0.0f, 1.0f, 0.0f, 0.0f};
    size_t count = 0;
    while (lk_scene_light(place, scene, count))
        count++;
    float(*places)[4] = malloc((count + 1) * sizeof(*places));
    if (places == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu lights", count);
    for (size_t i = 0; i < count; i++)
        lk_scene_light(places[i], scene, i);
    memcpy(places[count], place, sizeof(place));
    *out = (struct lights){places, count > 0 ? count : 1};
    return STATUS_OK;
}

// Makes the rays that follow a set's hits: a bounce, or shadow rays towards lights.
static enum status follow(struct ray_set *out, const struct ray_set *set, const struct lk_hit *hits,
                          const struct lk_geometry *geometry, const struct lights *lights,
                          uint32_t salt)
{
    struct ray_set made = {.any_hit = lights != NULL};
    made.rays = malloc((set->count + 1) * sizeof(*made.rays));
    if (made.rays == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u rays", set->count);
    for (uint32_t i = 0; i < set->count; i++) {
        float normal[3];
        struct lk_ray *ray = &made.rays[made.count];
        if (hits[i].triangle == LK_HIT_NONE ||
            !face_normal(normal, geometry, &set->rays[i], hits[i].triangle))
            continue;
        leave(ray, &set->rays[i], hits[i].t, normal);
        if (lights == NULL) {
            made.count += scatter(ray, normal, i, salt);
        } else {
            const size_t light = (size_t)(random_unit(i, 15) * (float)lights->count);
            made.count += aim(ray, normal, lights->places[light]);
        }
    }
    *out = made;
    return STATUS_OK;
}

enum status ray_set_trace(struct lk_hit *hits, struct lk_tracer *tracer, const struct ray_set *set)
{
    enum lk_status status = lk_tracer_set_rays(tracer, set->rays, set->count);
    if (status == LK_OK)
        status = lk_tracer_run(tracer, NULL, false, 1);
    if (status == LK_OK)
        status = lk_tracer_hits(tracer, hits);
    return (enum status)status;
}

// What rays are made with.
struct maker {
    struct lk_tracer *tracer;
    struct lk_geometry geometry;
    struct lights lights;
    struct lk_hit *hits; // [width * height of the tracer's image] of the last set traced; owned
};

// Makes the bounces from sets[first] to sets[last].
static enum status bounce(struct ray_set *sets, const struct maker *m, uint32_t first,
                          uint32_t last)
{
    enum status status = STATUS_OK;
    for (uint32_t i = first; i < last && status == STATUS_OK; i++) {
        status = ray_set_trace(m->hits, m->tracer, &sets[i]);
        if (status == STATUS_OK)
            status = follow(&sets[i + 1], &sets[i], m->hits, &m->geometry, NULL, i);
    }
    return status;
}

// Puts the rays of views in the place of the camera's.
static enum status look_around(struct ray_set *primary, const struct maker *m, uint32_t views)
{
    struct ray_set paths[RAY_CLASSES] = {[RAYS_PRIMARY] = *primary};
    *primary = (struct ray_set){0};
    enum status status = bounce(paths, m, RAYS_PRIMARY, VIEWS_BOUNCE);
    if (status == STATUS_OK)
        status = ray_set_trace(m->hits, m->tracer, &paths[VIEWS_BOUNCE]);
    if (status == STATUS_OK)
        status = views_make(primary, m->tracer, &paths[VIEWS_BOUNCE], m->hits, views);
    ray_sets_free(paths);
    return status;
}

static enum status make_all(struct ray_set *sets, const struct maker *m, uint32_t views)
{
    const struct lk_tracer_info *info = lk_tracer_info(m->tracer);
    struct ray_set *primary = &sets[RAYS_PRIMARY];
    primary->count = info->width * info->height;
    primary->rays = malloc(primary->count * sizeof(*primary->rays));
    if (primary->rays == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u rays", primary->count);
    enum status status = (enum status)lk_tracer_camera_rays(m->tracer, primary->rays);
    if (status == STATUS_OK && views > 1)
        status = look_around(primary, m, views);
    if (status == STATUS_OK)
        status = ray_set_trace(m->hits, m->tracer, primary);
    if (status == STATUS_OK)
        status = follow(&sets[RAYS_SHADOW], primary, m->hits, &m->geometry, &m->lights, 0);
    if (status == STATUS_OK)
        status = bounce(sets, m, RAYS_PRIMARY, RAYS_BOUNCE_4);
    return status;
}

enum status ray_sets_make(struct ray_set *out, struct lk_scene *scene, struct lk_tracer *tracer,
                          uint32_t views)
{
    struct ray_set sets[RAY_CLASSES] = {0};
    const struct lk_tracer_info *info = lk_tracer_info(tracer);
    const uint32_t count = info->width * info->height;
    struct maker m = {.tracer = tracer, .hits = malloc(count * sizeof(*m.hits))};
    enum status status = STATUS_OK;
    if (m.hits == NULL)
        status = status_fail(STATUS_NO_MEMORY, "no memory for %u hits", count);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_geometry(&m.geometry, scene);
    if (status == STATUS_OK)
        status = find_lights(&m.lights, scene);
    if (status == STATUS_OK)
        status = make_all(sets, &m, views);
    if (status == STATUS_OK)
        memcpy(out, sets, sizeof(sets));
    else
        ray_sets_free(sets);
    free(m.lights.places);
    free(m.hits);
    return status;
}

void ray_sets_free(struct ray_set *sets)
{
    for (int i = 0; i < RAY_CLASSES; i++) {
        free(sets[i].rays);
        sets[i] = (struct ray_set){0};
    }
}
