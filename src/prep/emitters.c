#include "prep/emitters.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"

#define LIGHT_LIMIT         (1u << 22) // shared/rng.h numbers lights in 22 bits
#define PI                  3.14159265358979323846
#define RECTANGLE_TOLERANCE 1e-4 // of the shorter side, and the cosine of the corner
#define CONE_MIN            1e-3 // least difference of a cone's cosines (KHR_lights_punctual)

// What the collection reads and where it writes.
struct collector {
    const struct scene *scene;
    const struct geometry *geometry;
    const double *luminance; // [material_count] mean emitted, cd/m2; 0: emits nothing
    struct emitters *emitters;
};

static double luminance_of(double r, double g, double b)
{
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

static float bits_to_float(uint bits)
{
    float f;
    memcpy(&f, &bits, sizeof(f));
    return f;
}

static double srgb_to_linear(double x)
{
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

// Averages the linear colour of an sRGB image.
static void find_mean(double *out, const struct scene_image *image)
{
    // Count the values first: whole numbers sum up without error, and 256 of them are decoded.
    uint64_t counts[3][256] = {{0}};
    const uint64_t texels = (uint64_t)image->width * image->height;
    for (uint64_t i = 0; i < texels; i++)
        for (int k = 0; k < 3; k++)
            counts[k][image->rgba[4 * i + k]]++;

    for (int k = 0; k < 3; k++) {
        double sum = 0.0;
        for (int value = 0; value < 256; value++)
            sum += (double)counts[k][value] * srgb_to_linear(value / 255.0);
        out[k] = sum / (double)texels;
    }
}

// Mean luminance that a material emits; 0 if none.
static double find_luminance(const struct scene *scene, const struct scene_material *material)
{
    const float *e = material->emission;
    double mean[3] = {1.0, 1.0, 1.0};
    if (material->unlit || !(luminance_of(e[0], e[1], e[2]) > 0.0))
        return 0.0;
    if (material->emissive_texture.texture != SCENE_NONE)
        find_mean(mean, &scene->images[scene->textures[material->emissive_texture.texture].image]);
    return luminance_of(e[0] * mean[0], e[1] * mean[1], e[2] * mean[2]);
}

// Adds a light to the tree's. False if it is left out, since its power does not count in float.
static bool add_light(struct collector *collector, const struct light *light, double power)
{
    struct emitters *emitters = collector->emitters;
    const float rounded = (float)fmin(power, FLT_MAX);
    if (!(rounded > 0.0f))
        return false;
    emitters->lights[emitters->light_count] = *light;
    emitters->power[emitters->light_count] = rounded;
    emitters->light_count++;
    return true;
}

static void add_punctual(struct collector *collector, const struct scene_light *light)
{
    struct emitters *emitters = collector->emitters;
    const float *color = light->color;
    const float *position = light->position;
    const float *dir = light->direction;
    const double luminance = luminance_of(color[0], color[1], color[2]);
    if (!(luminance > 0.0))
        return;

    struct light out = {
        .org_range = {position[0], position[1], position[2],
                      light->range > 0.0f ? light->range : LIGHT_NO_RANGE},
        .color_kind = {color[0], color[1], color[2], bits_to_float(LIGHT_POINT)},
    };
    switch (light->type) {
    case SCENE_LIGHT_DIRECTIONAL:
        emitters->directional[emitters->directional_count++] = (struct directional_light){
            .dir = {dir[0], dir[1], dir[2], 0.0f}, .color = {color[0], color[1], color[2], 0.0f}};
        break;
    case SCENE_LIGHT_POINT:
        emitters->point_count += add_light(collector, &out, luminance * 4.0 * PI);
        break;
    case SCENE_LIGHT_SPOT: {
        const double outer = cos(light->outer_angle_rad);
        const double scale = 1.0 / fmax(CONE_MIN, cos(light->inner_angle_rad) - outer);
        out.color_kind.w = bits_to_float(LIGHT_SPOT);
        out.edge_u = (float4){dir[0], dir[1], dir[2], (float)scale};
        out.edge_v.w = (float)(-outer * scale);
        emitters->spot_count += add_light(collector, &out, luminance * 2.0 * PI * (1.0 - outer));
        break;
    }
    }
}

static void load_corners(double out[3][3], const struct geometry *geometry, uint32_t index)
{
    const struct triangle *triangle = &geometry->triangles[index];
    vec3_position(out[0], &geometry->vertices[triangle->v0]);
    vec3_position(out[1], &geometry->vertices[triangle->v1]);
    vec3_position(out[2], &geometry->vertices[triangle->v2]);
}

// Adds a surface with a corner and two edges. False if it is left out.
static bool add_surface(struct collector *collector, enum light_type type, uint32_t triangle,
                        const double *corner, const double *u, const double *v)
{
    const uint material = collector->geometry->triangles[triangle].material;
    const struct scene_material *source = &collector->scene->materials[material];
    double normal[3];
    vec3_cross(normal, u, v);
    const double area = vec3_length(normal) * (type == LIGHT_TRIANGLE ? 0.5 : 1.0);
    const uint kind = (uint)type | (source->double_sided ? LIGHT_TWO_SIDED : 0u);
    const struct light light = {
        .org_range = {(float)corner[0], (float)corner[1], (float)corner[2], LIGHT_NO_RANGE},
        .color_kind = {source->emission[0], source->emission[1], source->emission[2],
                       bits_to_float(kind)},
        .edge_u = {(float)u[0], (float)u[1], (float)u[2], (float)area},
        .edge_v = {(float)v[0], (float)v[1], (float)v[2], bits_to_float(triangle)},
    };
    const double sides = source->double_sided ? 2.0 : 1.0;
    return (float)area > 0.0f &&
           add_light(collector, &light, collector->luminance[material] * area * PI * sides);
}

static bool is_same(const double *a, const double *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// Finds whether two triangles with the same front share their longest edge such that they make a
// rectangle: then gives its corner off that edge, and its edges from there.
static bool find_rectangle(double *corner, double *u, double *v, double a[3][3], double b[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            // The edge from s to t of the first runs from t to s in the second.
            const double *p = a[(i + 2) % 3];
            const double *s = a[i];
            const double *t = a[(i + 1) % 3];
            const double *q = b[(j + 2) % 3];
            if (!is_same(s, b[(j + 1) % 3]) || !is_same(t, b[j]))
                continue;

            // With p, s, t counter-clockwise, the sides from p are s - p and t - p, in this order.
            double miss[3];
            vec3_sub(u, s, p);
            vec3_sub(v, t, p);
            for (int k = 0; k < 3; k++)
                miss[k] = q[k] - (p[k] + u[k] + v[k]);
            const double u_length = vec3_length(u);
            const double v_length = vec3_length(v);
            memcpy(corner, p, sizeof(double[3]));
            return vec3_length(miss) <= RECTANGLE_TOLERANCE * fmin(u_length, v_length) &&
                   fabs(vec3_dot(u, v)) <= RECTANGLE_TOLERANCE * u_length * v_length;
        }
    }
    return false;
}

// Adds a triangle and the next one as a rectangle. False if they do not make one.
static bool add_rectangle(struct collector *collector, uint32_t triangle)
{
    const struct geometry *geometry = collector->geometry;
    if (triangle + 1 >= geometry->triangle_count)
        return false;
    const uint32_t material = geometry->triangles[triangle].material;
    const struct scene_material *source = &collector->scene->materials[material];
    if (geometry->triangles[triangle + 1].material != material || source->masked ||
        source->blended || source->emissive_texture.texture != SCENE_NONE)
        return false;

    double a[3][3], b[3][3], corner[3], u[3], v[3];
    load_corners(a, geometry, triangle);
    load_corners(b, geometry, triangle + 1);
    return find_rectangle(corner, u, v, a, b) &&
           add_surface(collector, LIGHT_RECTANGLE, triangle, corner, u, v);
}

static bool add_triangle(struct collector *collector, uint32_t triangle)
{
    double p[3][3], u[3], v[3];
    load_corners(p, collector->geometry, triangle);
    vec3_sub(u, p[1], p[0]);
    vec3_sub(v, p[2], p[0]);
    return add_surface(collector, LIGHT_TRIANGLE, triangle, p[0], u, v);
}

// Adds all emissive triangles, in order, and notes which light each is.
static void add_surfaces(struct collector *collector)
{
    struct emitters *emitters = collector->emitters;
    const struct geometry *geometry = collector->geometry;
    for (uint32_t i = 0; i < geometry->triangle_count; i++)
        emitters->triangle_emitters[i] = EMITTER_NONE;

    for (uint32_t i = 0; i < geometry->triangle_count; i++) {
        const uint32_t light = emitters->light_count;
        if (!(collector->luminance[geometry->triangles[i].material] > 0.0))
            continue;
        if (add_rectangle(collector, i)) {
            emitters->triangle_emitters[i++] = light;
            emitters->triangle_emitters[i] = light;
            emitters->rectangle_count++;
            emitters->emissive_triangles += 2;
        } else if (add_triangle(collector, i)) {
            emitters->triangle_emitters[i] = light;
            emitters->triangle_count++;
            emitters->emissive_triangles++;
        }
    }
}

// Allocates room for all that may be a light. `surface_count` triangles may emit.
static enum status reserve(struct emitters *emitters, uint32_t punctual_count,
                           uint32_t surface_count, uint32_t triangle_count)
{
    const size_t count = (size_t)punctual_count + surface_count;
    emitters->lights = array_alloc(count, sizeof(*emitters->lights));
    emitters->power = array_alloc(count, sizeof(*emitters->power));
    emitters->directional = array_alloc(punctual_count, sizeof(*emitters->directional));
    if (surface_count > 0)
        emitters->triangle_emitters =
            array_alloc(triangle_count, sizeof(*emitters->triangle_emitters));
    if (emitters->lights == NULL || emitters->power == NULL || emitters->directional == NULL ||
        (surface_count > 0 && emitters->triangle_emitters == NULL))
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu lights", count);
    return STATUS_OK;
}

enum status emitters_build(struct emitters *out, const struct scene *scene,
                           const struct geometry *geometry)
{
    enum status status = STATUS_OK;
    struct emitters emitters = {0};
    struct collector collector = {.scene = scene, .geometry = geometry, .emitters = &emitters};
    double *luminance = array_alloc(scene->material_count, sizeof(*luminance));
    if (luminance == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u materials", scene->material_count);

    // Find which materials emit, and count their triangles.
    uint32_t surface_count = 0;
    for (uint32_t i = 0; i < scene->material_count; i++)
        luminance[i] = find_luminance(scene, &scene->materials[i]);
    for (uint32_t i = 0; i < geometry->triangle_count; i++)
        surface_count += luminance[geometry->triangles[i].material] > 0.0;
    collector.luminance = luminance;
    status = reserve(&emitters, scene->light_count, surface_count, geometry->triangle_count);
    if (status != STATUS_OK)
        goto cleanup;

    // Punctual lights first, in the order of the file, then surfaces.
    for (uint32_t i = 0; i < scene->light_count; i++)
        add_punctual(&collector, &scene->lights[i]);
    if (surface_count > 0)
        add_surfaces(&collector);
    if (emitters.light_count >= LIGHT_LIMIT) {
        status = status_fail(STATUS_LIMIT,
                             "%u lights, not less than %u: give fewer surfaces an "
                             "emissive material",
                             emitters.light_count, LIGHT_LIMIT);
        goto cleanup;
    }
    if (emitters.emissive_triangles == 0) {
        free(emitters.triangle_emitters);
        emitters.triangle_emitters = NULL;
    }
    *out = emitters;
    emitters = (struct emitters){0}; // the caller owns it now

cleanup:
    emitters_free(&emitters);
    free(luminance);
    return status;
}

void emitters_free(struct emitters *emitters)
{
    free(emitters->directional);
    free(emitters->triangle_emitters);
    free(emitters->power);
    free(emitters->lights);
    *emitters = (struct emitters){0};
}
