#include "prep/emitters.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/color.h"
#include "prep/emission.h"
#include "prep/vec3.h"

#define LIGHT_LIMIT         (1u << 22) // shared/rng.h numbers lights in 22 bits
#define PI                  3.14159265358979323846
#define RECTANGLE_TOLERANCE 1e-4 // of the shorter side, and the cosine of the corner
#define CONE_MIN            1e-3 // least difference of a cone's cosines (KHR_lights_punctual)

// What the collection reads and where it writes.
struct collector {
    const struct scene *scene;
    const struct geometry *geometry;
    const struct emission *emission;
    struct emitters *emitters;
};

static float bits_to_float(uint bits)
{
    float f;
    memcpy(&f, &bits, sizeof(f));
    return f;
}

// Adds a light to the hierarchy's, with a shape if it has one. False if it is left out, since its
// power does not count in float.
static bool add_light(struct collector *collector, struct light *light, uint32_t kind,
                      const struct light_shape *shape, double power)
{
    struct emitters *emitters = collector->emitters;
    const float rounded = (float)fmin(power, FLT_MAX);
    if (!(rounded > 0.0f))
        return false;
    if (shape != NULL) {
        kind |= emitters->shape_count << LIGHT_SHAPE_SHIFT;
        emitters->shapes[emitters->shape_count++] = *shape;
    }
    light->color_kind.w = bits_to_float(kind);
    emitters->lights[emitters->light_count] = *light;
    emitters->power[emitters->light_count] = rounded;
    emitters->light_count++;
    return true;
}

static bool add_spot(struct collector *collector, const struct scene_light *source,
                     struct light *light, double luminance)
{
    const float *dir = source->direction;
    const double outer = cos(source->outer_angle_rad);
    const double scale = 1.0 / fmax(CONE_MIN, cos(source->inner_angle_rad) - outer);
    const struct light_shape shape = {
        .edge_u = {dir[0], dir[1], dir[2], (float)scale},
        .edge_v = {0.0f, 0.0f, 0.0f, (float)(-outer * scale)},
    };
    return add_light(collector, light, LIGHT_SPOT, &shape, luminance * 2.0 * PI * (1.0 - outer));
}

// Adds a rectangle or disc that is no surface of the scene.
static bool add_area(struct collector *collector, const struct scene_light *source,
                     struct light *light, double luminance)
{
    const bool disc = source->type == SCENE_LIGHT_DISC;
    double u[3], v[3], normal[3];
    vec3_load(u, source->half_u);
    vec3_load(v, source->half_v);
    vec3_cross(normal, u, v);
    const double area = vec3_length(normal) * (disc ? PI : 4.0);
    const float side = disc ? 1.0f : 2.0f; // in half edges
    const struct light_shape shape = {
        .edge_u = {side * source->half_u[0], side * source->half_u[1], side * source->half_u[2],
                   (float)area},
        .edge_v = {side * source->half_v[0], side * source->half_v[1], side * source->half_v[2],
                   bits_to_float(EMITTER_NONE)},
    };
    if (!disc) {
        light->org_range.x -= source->half_u[0] + source->half_v[0];
        light->org_range.y -= source->half_u[1] + source->half_v[1];
        light->org_range.z -= source->half_u[2] + source->half_v[2];
    }
    return (float)area > 0.0f && add_light(collector, light, disc ? LIGHT_DISC : LIGHT_RECTANGLE,
                                           &shape, luminance * area * PI);
}

// Adds a light that the file places by a node.
static void add_placed(struct collector *collector, const struct scene_light *light)
{
    struct emitters *emitters = collector->emitters;
    const float *color = light->color;
    const float *position = light->position;
    const float *dir = light->direction;
    const double luminance = color_luminance(color[0], color[1], color[2]);
    if (!(luminance > 0.0))
        return;

    struct light out = {
        .org_range = {position[0], position[1], position[2],
                      light->range > 0.0f ? light->range : LIGHT_NO_RANGE},
        .color_kind = {color[0], color[1], color[2], 0.0f},
    };
    switch (light->type) {
    case SCENE_LIGHT_DIRECTIONAL:
        emitters->directional[emitters->directional_count++] = (struct directional_light){
            .dir = {dir[0], dir[1], dir[2], 0.0f}, .color = {color[0], color[1], color[2], 0.0f}};
        break;
    case SCENE_LIGHT_POINT:
        emitters->point_count +=
            add_light(collector, &out, LIGHT_POINT, NULL, luminance * 4.0 * PI);
        break;
    case SCENE_LIGHT_SPOT:
        emitters->spot_count += add_spot(collector, light, &out, luminance);
        break;
    case SCENE_LIGHT_RECTANGLE:
        emitters->rectangle_count += add_area(collector, light, &out, luminance);
        break;
    case SCENE_LIGHT_DISC:
        emitters->disc_count += add_area(collector, light, &out, luminance);
        break;
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
    const uint32_t kind = (uint32_t)type | (source->double_sided ? LIGHT_TWO_SIDED : 0u);
    struct light light = {
        .org_range = {(float)corner[0], (float)corner[1], (float)corner[2], LIGHT_NO_RANGE},
        .color_kind = {source->emission[0], source->emission[1], source->emission[2], 0.0f},
    };
    const struct light_shape shape = {
        .edge_u = {(float)u[0], (float)u[1], (float)u[2], (float)area},
        .edge_v = {(float)v[0], (float)v[1], (float)v[2], bits_to_float(triangle)},
    };
    const double sides = source->double_sided ? 2.0 : 1.0;
    const double luminance = emission_of(collector->emission, collector->geometry, triangle);
    return (float)area > 0.0f &&
           add_light(collector, &light, kind, &shape, luminance * area * PI * sides);
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
        if (!(emission_of(collector->emission, geometry, i) > 0.0))
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

// Allocates room for all that may be a light: of those that the file places, `shape_count` are no
// points; `surface_count` triangles may emit.
static enum status reserve(struct emitters *emitters, const struct scene *scene,
                           uint32_t shape_count, uint32_t surface_count, uint32_t triangle_count)
{
    const size_t count = (size_t)scene->light_count + surface_count;
    emitters->lights = array_alloc(count, sizeof(*emitters->lights));
    emitters->power = array_alloc(count, sizeof(*emitters->power));
    emitters->shapes = array_alloc((size_t)shape_count + surface_count, sizeof(*emitters->shapes));
    emitters->directional = array_alloc(scene->light_count, sizeof(*emitters->directional));
    if (surface_count > 0)
        emitters->triangle_emitters =
            array_alloc(triangle_count, sizeof(*emitters->triangle_emitters));
    if (emitters->lights == NULL || emitters->power == NULL || emitters->shapes == NULL ||
        emitters->directional == NULL || (surface_count > 0 && emitters->triangle_emitters == NULL))
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu lights", count);
    return STATUS_OK;
}

enum status emitters_build(struct emitters *out, const struct scene *scene,
                           const struct geometry *geometry)
{
    struct emitters emitters = {0};
    struct emission emission = {0};
    struct collector collector = {
        .scene = scene, .geometry = geometry, .emission = &emission, .emitters = &emitters};
    enum status status = emission_build(&emission, scene, geometry);
    if (status != STATUS_OK)
        return status;

    // Count what may be a light.
    uint32_t surface_count = 0;
    uint32_t shape_count = 0;
    for (uint32_t i = 0; i < geometry->triangle_count; i++)
        surface_count += emission_of(&emission, geometry, i) > 0.0;
    for (uint32_t i = 0; i < scene->light_count; i++)
        shape_count += scene->lights[i].type != SCENE_LIGHT_POINT;
    status = reserve(&emitters, scene, shape_count, surface_count, geometry->triangle_count);
    if (status != STATUS_OK)
        goto cleanup;

    // Lights that nodes place first, in the order of the file, then surfaces.
    for (uint32_t i = 0; i < scene->light_count; i++)
        add_placed(&collector, &scene->lights[i]);
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
    emission_free(&emission);
    return status;
}

void emitters_free(struct emitters *emitters)
{
    free(emitters->directional);
    free(emitters->triangle_emitters);
    free(emitters->power);
    free(emitters->shapes);
    free(emitters->lights);
    *emitters = (struct emitters){0};
}
