#include "prep/flatten.h"

#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"
#include "shared/bvh.h"
#include "shared/oct.h"

// Where one instance goes, and how.
struct placement {
    const struct scene_mesh *mesh;
    const double *to_world;  // 3x4
    double normal_matrix[9]; // inverse transpose times a positive number
    bool turned;             // negative determinant: winding is turned round
    bool lacks_normals;      // some normals are zero or not finite
    bool out_of_range;       // some positions do not fit in float
    uint32_t vertex_first;
    uint32_t triangle_first;
};

// Prepares one instance. The cofactors of a matrix are its inverse transpose times its determinant,
// and exist for singular matrices as well.
static void place_instance(struct placement *out, const struct scene *scene, uint32_t instance)
{
    const double *m = scene->instances[instance].to_world;
    const double row[3][3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
    vec3_cross(out->normal_matrix + 0, row[1], row[2]);
    vec3_cross(out->normal_matrix + 3, row[2], row[0]);
    vec3_cross(out->normal_matrix + 6, row[0], row[1]);

    out->mesh = &scene->meshes[scene->instances[instance].mesh];
    out->to_world = m;
    out->turned = vec3_dot(row[0], out->normal_matrix) < 0.0;
    out->lacks_normals = false;
    out->out_of_range = false;
    if (out->turned)
        for (int k = 0; k < 9; k++)
            out->normal_matrix[k] = -out->normal_matrix[k];
}

// Computes a vertex's unit normal in the world. False if there is none.
static bool place_normal(double *out, const struct placement *placement, uint32_t vertex)
{
    double local[3];
    vec3_load(local, placement->mesh->normals + 3 * (size_t)vertex);
    for (int k = 0; k < 3; k++)
        out[k] = vec3_dot(placement->normal_matrix + 3 * k, local);

    // Scale by the largest component first, so that squares neither overflow nor vanish.
    const double largest = fmax(fabs(out[0]), fmax(fabs(out[1]), fabs(out[2])));
    if (!(largest > 0.0 && largest <= DBL_MAX))
        return false;
    for (int k = 0; k < 3; k++)
        out[k] /= largest;
    const double length = vec3_length(out);
    for (int k = 0; k < 3; k++)
        out[k] /= length;
    return isfinite(length);
}

static void set_normal(struct vertex *vertex, const double *normal)
{
    const uint bits = oct_pack((float)normal[0], (float)normal[1], (float)normal[2]);
    memcpy(&vertex->pos_normal.w, &bits, sizeof(bits));
}

// Places vertices, shared among the threads of the team. Those without a normal get +Y for now.
static void place_vertices(struct vertex *vertices, struct placement *placement)
{
    static const double up[3] = {0.0, 1.0, 0.0};
    const struct scene_mesh *mesh = placement->mesh;
    const double *m = placement->to_world;

#pragma omp for schedule(static) nowait
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        struct vertex *vertex = &vertices[placement->vertex_first + i];
        double local[3], world[3], normal[3];
        bool in_range = true;

        vec3_load(local, mesh->positions + 3 * (size_t)i);
        for (int k = 0; k < 3; k++) {
            world[k] = vec3_dot(m + 4 * k, local) + m[4 * k + 3];
            in_range = in_range && fabs(world[k]) <= FLT_MAX;
        }
        if (!in_range) {
#pragma omp atomic write
            placement->out_of_range = true;
            continue;
        }

        vertex->pos_normal = (float4){(float)world[0], (float)world[1], (float)world[2], 0.0f};
        const bool has_normal = place_normal(normal, placement, i);
        set_normal(vertex, has_normal ? normal : up);
        if (!has_normal) {
#pragma omp atomic write
            placement->lacks_normals = true;
        }

        const float *uv0 = mesh->uv0 != NULL ? mesh->uv0 + 2 * (size_t)i : NULL;
        const float *uv1 = mesh->uv1 != NULL ? mesh->uv1 + 2 * (size_t)i : NULL;
        vertex->uv = (float4){uv0 != NULL ? uv0[0] : 0.0f, uv0 != NULL ? uv0[1] : 0.0f,
                              uv1 != NULL ? uv1[0] : 0.0f, uv1 != NULL ? uv1[1] : 0.0f};
    }
}

static uint pack_unorm16(float x, float y)
{
    const uint low = (uint)(fminf(fmaxf(x, 0.0f), 1.0f) * 65535.0f + 0.5f);
    const uint high = (uint)(fminf(fmaxf(y, 0.0f), 1.0f) * 65535.0f + 0.5f);
    return low | high << 16;
}

// Packs colours, shared among the threads of the team; white where the mesh has none.
static void place_colors(uint2 *colors, const struct placement *placement)
{
    const struct scene_mesh *mesh = placement->mesh;
#pragma omp for schedule(static) nowait
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        static const float white[4] = {1.0f, 1.0f, 1.0f, 1.0f};
        const float *c = mesh->colors != NULL ? mesh->colors + 4 * (size_t)i : white;
        colors[placement->vertex_first + i] =
            (uint2){pack_unorm16(c[0], c[1]), pack_unorm16(c[2], c[3])};
    }
}

// Places tangents, shared among the threads of the team; +X where the mesh has none.
static void place_tangents(uint *tangents, const struct placement *placement)
{
    const struct scene_mesh *mesh = placement->mesh;
#pragma omp for schedule(static) nowait
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        double world[3] = {1.0, 0.0, 0.0};
        bool against = false;
        if (mesh->tangents != NULL) {
            double local[3];
            const float *tangent = mesh->tangents + 4 * (size_t)i;
            vec3_load(local, tangent);
            for (int k = 0; k < 3; k++)
                world[k] = vec3_dot(placement->to_world + 4 * k, local);
            // A mirrored instance turns the frame's hand.
            against = (tangent[3] < 0.0f) != placement->turned;
        }
        const double largest = fmax(fabs(world[0]), fmax(fabs(world[1]), fabs(world[2])));
        const double scale = largest > 0.0 && largest <= DBL_MAX ? 1.0 / largest : 0.0;
        tangents[placement->vertex_first + i] =
            scale > 0.0 ? tangent_pack((float)(world[0] * scale), (float)(world[1] * scale),
                                       (float)(world[2] * scale), against)
                        : tangent_pack(1.0f, 0.0f, 0.0f, against);
    }
}

// Places triangles, shared among the threads of the team.
static void place_triangles(struct triangle *triangles, const struct placement *placement)
{
    const struct scene_mesh *mesh = placement->mesh;
    const uint32_t first = placement->vertex_first;
#pragma omp for schedule(static) nowait
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->indices + 3 * (size_t)i;
        triangles[placement->triangle_first + i] =
            (struct triangle){first + corner[0], first + corner[placement->turned ? 2 : 1],
                              first + corner[placement->turned ? 1 : 2], mesh->material};
    }
}

// Gives vertices without a normal that of the first face with an area that they belong to.
static enum status repair_normals(struct geometry *geometry, const struct placement *placement)
{
    const struct scene_mesh *mesh = placement->mesh;
    bool *lacking = array_alloc(mesh->vertex_count, sizeof(*lacking));
    if (lacking == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for the normals of mesh \"%s\"",
                           mesh->name);

    double normal[3];
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        lacking[i] = !place_normal(normal, placement, i);

    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const struct triangle *triangle = &geometry->triangles[placement->triangle_first + i];
        const uint corner[3] = {triangle->v0, triangle->v1, triangle->v2};
        double p[3][3];
        for (int k = 0; k < 3; k++)
            vec3_position(p[k], &geometry->vertices[corner[k]]);

        vec3_face(normal, p[0], p[1], p[2]);
        const double length = vec3_length(normal);
        if (!(length > 0.0))
            continue; // no area, no direction
        for (int k = 0; k < 3; k++)
            normal[k] /= length;
        for (int k = 0; k < 3; k++) {
            bool *lacks = &lacking[corner[k] - placement->vertex_first];
            if (*lacks)
                set_normal(&geometry->vertices[corner[k]], normal);
            *lacks = false;
        }
    }
    free(lacking);
    return STATUS_OK;
}

// Bounds what the triangles reach; vertices that none uses do not count.
static void find_bounds(struct geometry *geometry)
{
    if (geometry->triangle_count == 0)
        return;
    float lo[3] = {FLT_MAX, FLT_MAX, FLT_MAX};
    float hi[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
#pragma omp parallel for schedule(static) reduction(min : lo[:3]) reduction(max : hi[:3])
    for (uint32_t i = 0; i < geometry->triangle_count; i++) {
        const struct triangle *triangle = &geometry->triangles[i];
        const uint corner[3] = {triangle->v0, triangle->v1, triangle->v2};
        for (int j = 0; j < 3; j++) {
            const float4 row = geometry->vertices[corner[j]].pos_normal;
            const float p[3] = {row.x, row.y, row.z};
            for (int k = 0; k < 3; k++) {
                lo[k] = fminf(lo[k], p[k]);
                hi[k] = fmaxf(hi[k], p[k]);
            }
        }
    }
    memcpy(geometry->lo, lo, sizeof(lo));
    memcpy(geometry->hi, hi, sizeof(hi));
}

// Counts what the instances need, and prepares each.
static enum status place_instances(struct geometry *geometry, struct placement *placements,
                                   bool *has_colors, bool *has_tangents, const struct scene *scene)
{
    uint64_t vertex_count = 0;
    uint64_t triangle_count = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        struct placement *placement = &placements[i];
        place_instance(placement, scene, i);
        placement->vertex_first = (uint32_t)vertex_count;
        placement->triangle_first = (uint32_t)triangle_count;
        vertex_count += placement->mesh->vertex_count;
        triangle_count += placement->mesh->triangle_count;
        *has_colors = *has_colors || placement->mesh->colors != NULL;
        *has_tangents = *has_tangents || placement->mesh->tangents != NULL;

        const uint64_t limit = BVH_REF_TRIANGLE;
        if (vertex_count > limit || triangle_count > limit)
            return status_fail(STATUS_LIMIT,
                               "%s: more than %u triangles or vertices once instances are placed",
                               scene->file != NULL ? scene->file : "scene", BVH_REF_TRIANGLE);
    }
    geometry->vertex_count = (uint32_t)vertex_count;
    geometry->triangle_count = (uint32_t)triangle_count;
    return STATUS_OK;
}

// Fills the arrays, all threads on each instance in turn: there may be one large or many small.
static void fill(struct geometry *geometry, struct placement *placements, uint32_t count)
{
#pragma omp parallel
    for (uint32_t i = 0; i < count; i++) {
        place_vertices(geometry->vertices, &placements[i]);
        place_triangles(geometry->triangles, &placements[i]);
        if (geometry->colors != NULL)
            place_colors(geometry->colors, &placements[i]);
        if (geometry->tangents != NULL)
            place_tangents(geometry->tangents, &placements[i]);
    }
}

enum status geometry_build(struct geometry *out, const struct scene *scene)
{
    enum status status = STATUS_OK;
    struct geometry geometry = {0};
    bool has_colors = false;
    bool has_tangents = false;
    struct placement *placements = array_alloc(scene->instance_count, sizeof(*placements));
    if (placements == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u instances", scene->instance_count);

    status = place_instances(&geometry, placements, &has_colors, &has_tangents, scene);
    if (status != STATUS_OK)
        goto cleanup;

    geometry.vertices = array_alloc(geometry.vertex_count, sizeof(*geometry.vertices));
    geometry.triangles = array_alloc(geometry.triangle_count, sizeof(*geometry.triangles));
    if (has_colors)
        geometry.colors = array_alloc(geometry.vertex_count, sizeof(*geometry.colors));
    if (has_tangents)
        geometry.tangents = array_alloc(geometry.vertex_count, sizeof(*geometry.tangents));
    if (geometry.vertices == NULL || geometry.triangles == NULL ||
        (has_colors && geometry.colors == NULL) || (has_tangents && geometry.tangents == NULL)) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for %u vertices and %u triangles",
                             geometry.vertex_count, geometry.triangle_count);
        goto cleanup;
    }

    fill(&geometry, placements, scene->instance_count);
    for (uint32_t i = 0; i < scene->instance_count && status == STATUS_OK; i++) {
        if (placements[i].out_of_range)
            status = status_fail(STATUS_FORMAT,
                                 "mesh \"%s\": its transform takes a position out of range",
                                 placements[i].mesh->name);
        else if (placements[i].lacks_normals)
            status = repair_normals(&geometry, &placements[i]);
    }
    if (status != STATUS_OK)
        goto cleanup;

    find_bounds(&geometry);
    *out = geometry;
    geometry = (struct geometry){0}; // the caller owns it now

cleanup:
    geometry_free(&geometry);
    free(placements);
    return status;
}

void geometry_free(struct geometry *geometry)
{
    free(geometry->triangles);
    free(geometry->tangents);
    free(geometry->colors);
    free(geometry->vertices);
    *geometry = (struct geometry){0};
}
