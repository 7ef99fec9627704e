// Placing instances: transforms against their definition, and what must not change under them.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>

#include "prep/flatten.h"
#include "prep_support.h"
#include "shared/bvh.h"
#include "shared/oct.h"

#define ROUNDS         500
#define FLOAT_EPSILON  0x1p-23 // one rounding to float
#define NORMAL_EPSILON 2e-4    // two roundings of the octahedral code, radians

// A tetrahedron with a vertex for each corner of each face, and the faces' normals.
#define TETRA_VERTICES 12

struct tetra {
    float positions[TETRA_VERTICES * 3], normals[TETRA_VERTICES * 3];
    uint32_t indices[TETRA_VERTICES];
    struct scene_mesh mesh;
};

static void face_normal(double *out, const double *a, const double *b, const double *c)
{
    double length = 0.0;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3;
        const int j = (k + 2) % 3;
        out[k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
        length += out[k] * out[k];
    }
    for (int k = 0; k < 3; k++)
        out[k] /= sqrt(length);
}

static void make_tetra(struct tetra *out)
{
    static const double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (int i = 0; i < TETRA_VERTICES; i++) {
        const int *face = faces[i / 3];
        double normal[3];
        face_normal(normal, corners[face[0]], corners[face[1]], corners[face[2]]);
        for (int k = 0; k < 3; k++) {
            out->positions[3 * i + k] = (float)corners[face[i % 3]][k];
            out->normals[3 * i + k] = (float)normal[k];
        }
        out->indices[i] = (uint32_t)i;
    }
    out->mesh = (struct scene_mesh){.name = "tetra",
                                    .vertex_count = TETRA_VERTICES,
                                    .triangle_count = 4,
                                    .positions = out->positions,
                                    .normals = out->normals,
                                    .indices = out->indices,
                                    .material = 3};
}

static void random_transform(double *out, uint64_t *seed)
{
    for (int k = 0; k < 12; k++)
        out[k] = random_between(seed, -2.0, 2.0);
}

static void position_of(double *out, const struct geometry *geometry, uint32_t vertex)
{
    const float4 row = geometry->vertices[vertex].pos_normal;
    out[0] = row.x;
    out[1] = row.y;
    out[2] = row.z;
}

static void normal_of(double *out, const struct geometry *geometry, uint32_t vertex)
{
    uint bits;
    memcpy(&bits, &geometry->vertices[vertex].pos_normal.w, sizeof(bits));
    const float4 n = oct_unpack(bits);
    const double length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    out[0] = n.x / length;
    out[1] = n.y / length;
    out[2] = n.z / length;
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The angle between two unit vectors.
static double angle(const double *a, const double *b)
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return 2.0 * asin(fmin(0.5 * sqrt(dot(d, d)), 1.0));
}

static void positions_follow_the_matrix(void **state)
{
    (void)state;
    uint64_t seed = 1;
    struct tetra tetra;
    struct scene_instance instances[ROUNDS] = {0};
    make_tetra(&tetra);
    for (int i = 0; i < ROUNDS; i++)
        random_transform(instances[i].to_world, &seed);
    const struct scene scene = {
        .meshes = &tetra.mesh, .mesh_count = 1, .instances = instances, .instance_count = ROUNDS};
    struct geometry geometry;
    assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);
    assert_int_equal(geometry.vertex_count, ROUNDS * TETRA_VERTICES);
    assert_int_equal(geometry.triangle_count, ROUNDS * 4);
    for (uint32_t i = 0; i < geometry.vertex_count; i++) {
        const double *m = instances[i / TETRA_VERTICES].to_world;
        const float *p = tetra.positions + 3 * (i % TETRA_VERTICES);
        double found[3];
        position_of(found, &geometry, i);
        for (int k = 0; k < 3; k++) {
            const double expected =
                m[4 * k] * p[0] + m[4 * k + 1] * p[1] + m[4 * k + 2] * p[2] + m[4 * k + 3];
            assert_true(fabs(found[k] - expected) <= FLOAT_EPSILON * fabs(expected));
            assert_true(geometry.lo[k] <= found[k] && found[k] <= geometry.hi[k]);
        }
    }
    geometry_free(&geometry);
}

static void fronts_stay_fronts(void **state)
{
    (void)state;
    uint64_t seed = 2;
    struct tetra tetra;
    make_tetra(&tetra);
    int mirrored = 0;
    for (int round = 0; round < ROUNDS; round++) {
        struct scene_instance instance = {0};
        random_transform(instance.to_world, &seed);
        const double *m = instance.to_world;
        const double det = m[0] * (m[5] * m[10] - m[6] * m[9]) -
                           m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
        if (fabs(det) < 0.1)
            continue; // too flat for the test's own arithmetic
        mirrored += det < 0.0;
        const struct scene scene = {
            .meshes = &tetra.mesh, .mesh_count = 1, .instances = &instance, .instance_count = 1};
        struct geometry geometry;
        assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);

        // Every face looks away from the middle, and its vertices' normals are its own.
        double middle[3] = {0.0};
        for (uint32_t i = 0; i < TETRA_VERTICES; i++) {
            double p[3];
            position_of(p, &geometry, i);
            for (int k = 0; k < 3; k++)
                middle[k] += p[k] / TETRA_VERTICES;
        }
        for (int i = 0; i < 4; i++) {
            const struct triangle *triangle = &geometry.triangles[i];
            double a[3], b[3], c[3], face[3], normal[3];
            position_of(a, &geometry, triangle->v0);
            position_of(b, &geometry, triangle->v1);
            position_of(c, &geometry, triangle->v2);
            face_normal(face, a, b, c);
            normal_of(normal, &geometry, triangle->v0);
            const double outwards[3] = {a[0] - middle[0], a[1] - middle[1], a[2] - middle[2]};
            assert_true(dot(face, outwards) > 0.0);
            assert_true(angle(face, normal) <= NORMAL_EPSILON);
            assert_int_equal(triangle->material, 3);
        }
        geometry_free(&geometry);
    }
    assert_in_range(mirrored, ROUNDS / 4, ROUNDS * 3 / 4);
}

static void zero_and_infinite_normals_become_the_faces(void **state)
{
    (void)state;
    static const float bad[] = {0.0f, INFINITY, NAN};
    for (int round = 0; round < 3; round++) {
        struct tetra tetra;
        make_tetra(&tetra);
        struct geometry good, repaired;
        struct scene_instance instance = {.to_world = {1, 2, 0, 0, 0, 1, -1, 5, 0, 0, -1, 0}};
        const struct scene scene = {
            .meshes = &tetra.mesh, .mesh_count = 1, .instances = &instance, .instance_count = 1};
        assert_int_equal(geometry_build(&good, &scene), STATUS_OK);
        for (int i = 0; i < TETRA_VERTICES * 3; i++)
            tetra.normals[i] = bad[round];
        assert_int_equal(geometry_build(&repaired, &scene), STATUS_OK);
        for (uint32_t i = 0; i < TETRA_VERTICES; i++) {
            double a[3], b[3];
            normal_of(a, &good, i);
            normal_of(b, &repaired, i);
            assert_true(angle(a, b) <= NORMAL_EPSILON);
        }
        geometry_free(&repaired);
        geometry_free(&good);
    }
}

static void singular_transforms_give_unit_normals(void **state)
{
    (void)state;
    static const double scales[][3] = {
        {0, 1, 1}, {1, 0, 1}, {0, 0, 1}, {0, 0, 0}, {1e-160, 1e-160, 1e-160}, {1e-30, 1, 1e30}};
    struct tetra tetra;
    make_tetra(&tetra);
    for (size_t i = 0; i < sizeof(scales) / sizeof(scales[0]); i++) {
        struct scene_instance instance = {0};
        for (int k = 0; k < 3; k++)
            instance.to_world[5 * k] = scales[i][k];
        const struct scene scene = {
            .meshes = &tetra.mesh, .mesh_count = 1, .instances = &instance, .instance_count = 1};
        struct geometry geometry;
        assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);
        for (uint32_t j = 0; j < TETRA_VERTICES; j++) {
            double normal[3];
            normal_of(normal, &geometry, j);
            assert_true(fabs(dot(normal, normal) - 1.0) < NORMAL_EPSILON);
        }
        geometry_free(&geometry);
    }
}

static void attributes_are_kept_or_filled(void **state)
{
    (void)state;
    struct tetra with, without;
    float uv0[TETRA_VERTICES * 2], uv1[TETRA_VERTICES * 2], colors[TETRA_VERTICES * 4];
    uint64_t seed = 3;
    for (int i = 0; i < TETRA_VERTICES * 2; i++) {
        uv0[i] = (float)random_between(&seed, -5.0, 5.0);
        uv1[i] = (float)random_between(&seed, -5.0, 5.0);
    }
    for (int i = 0; i < TETRA_VERTICES * 4; i++)
        colors[i] = (float)random_between(&seed, -0.25, 1.25);
    make_tetra(&with);
    make_tetra(&without);
    with.mesh.uv0 = uv0;
    with.mesh.uv1 = uv1;
    with.mesh.colors = colors;
    struct scene_mesh meshes[2] = {without.mesh, with.mesh};
    struct scene_instance instances[2] = {{.mesh = 0}, {.mesh = 1}};
    struct scene scene = {
        .meshes = meshes, .mesh_count = 2, .instances = instances, .instance_count = 2};
    struct geometry geometry;
    assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);
    assert_non_null(geometry.colors);
    for (uint32_t i = 0; i < TETRA_VERTICES; i++) {
        const float4 none = geometry.vertices[i].uv;
        const float4 some = geometry.vertices[TETRA_VERTICES + i].uv;
        assert_true(none.x == 0.0f && none.y == 0.0f && none.z == 0.0f && none.w == 0.0f);
        assert_true(some.x == uv0[2 * i] && some.y == uv0[2 * i + 1]);
        assert_true(some.z == uv1[2 * i] && some.w == uv1[2 * i + 1]);

        const uint2 white = geometry.colors[i];
        const uint2 color = geometry.colors[TETRA_VERTICES + i];
        assert_true(white.x == 0xffffffffu && white.y == 0xffffffffu);
        const uint found[4] = {color.x & 0xffffu, color.x >> 16, color.y & 0xffffu, color.y >> 16};
        for (int k = 0; k < 4; k++) {
            const double expected = fmin(fmax(colors[4 * i + k], 0.0), 1.0) * 65535.0;
            assert_true(fabs(found[k] - expected) <= 0.51); // half a step, and float's rounding
        }
    }
    geometry_free(&geometry);

    scene.instance_count = 1; // of the mesh without colours
    assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);
    assert_null(geometry.colors);
    geometry_free(&geometry);
}

static void positions_out_of_range_name_the_mesh(void **state)
{
    (void)state;
    static const double bad[] = {1e39, INFINITY, NAN};
    struct tetra tetra;
    make_tetra(&tetra);
    for (int i = 0; i < 3; i++) {
        struct scene_instance instance = {.to_world = {bad[i], 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
        const struct scene scene = {
            .meshes = &tetra.mesh, .mesh_count = 1, .instances = &instance, .instance_count = 1};
        struct geometry geometry;
        assert_int_equal(geometry_build(&geometry, &scene), STATUS_FORMAT);
        assert_non_null(strstr(status_message(), "tetra"));
    }
}

static void too_many_triangles_are_a_limit(void **state)
{
    (void)state;
    struct scene_mesh mesh = {.name = "large", .triangle_count = BVH_REF_TRIANGLE};
    struct scene_instance instances[2] = {{.mesh = 0}, {.mesh = 0}};
    const struct scene scene = {
        .meshes = &mesh, .mesh_count = 1, .instances = instances, .instance_count = 2};
    struct geometry geometry;
    assert_int_equal(geometry_build(&geometry, &scene), STATUS_LIMIT);
}

static void an_empty_scene_is_empty_geometry(void **state)
{
    (void)state;
    const struct scene scene = {0};
    struct geometry geometry;
    assert_int_equal(geometry_build(&geometry, &scene), STATUS_OK);
    assert_int_equal(geometry.triangle_count, 0);
    for (int k = 0; k < 3; k++)
        assert_true(geometry.lo[k] == 0.0f && geometry.hi[k] == 0.0f);
    geometry_free(&geometry);
    geometry_free(&geometry);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(positions_follow_the_matrix),
        cmocka_unit_test(fronts_stay_fronts),
        cmocka_unit_test(zero_and_infinite_normals_become_the_faces),
        cmocka_unit_test(singular_transforms_give_unit_normals),
        cmocka_unit_test(attributes_are_kept_or_filled),
        cmocka_unit_test(positions_out_of_range_name_the_mesh),
        cmocka_unit_test(too_many_triangles_are_a_limit),
        cmocka_unit_test(an_empty_scene_is_empty_geometry),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
