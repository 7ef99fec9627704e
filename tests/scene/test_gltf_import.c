#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "gltf_support.h"
#include "scene/image_io.h"

// Rounding of float sums of a few terms near 1.
#define EPSILON 1e-6f

static void must_import(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s", status_message());
}

// Corner of a triangle of a mesh.
static const float *corner(const struct scene_mesh *mesh, uint32_t triangle, uint32_t k)
{
    return mesh->positions + mesh->indices[triangle * 3 + k] * (size_t)3;
}

// Twice the signed area in the xy plane.
static float doubled_area(const struct scene_mesh *mesh, uint32_t triangle)
{
    const float *a = corner(mesh, triangle, 0);
    const float *b = corner(mesh, triangle, 1);
    const float *c = corner(mesh, triangle, 2);
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static void lists_strips_and_fans_cover_the_same_square(void **state)
{
    (void)state;
    static const char *const primitives[] = {"\"indices\":1", "\"indices\":2,\"mode\":5",
                                             "\"indices\":3,\"mode\":6", "\"mode\":5"};
    for (int i = 0; i < 4; i++) {
        struct scene scene;
        must_import(
            import_members(&scene, ONE_MESH("\"attributes\":{\"POSITION\":0},%s"), primitives[i]));
        assert_int_equal(scene.mesh_count, 1);
        assert_int_equal(scene.meshes[0].triangle_count, 2);
        assert_float_equal(doubled_area(&scene.meshes[0], 0), 1.0f, EPSILON);
        assert_float_equal(doubled_area(&scene.meshes[0], 1), 1.0f, EPSILON);
        scene_free(&scene);
    }
}

static void faces_without_normals_are_flat(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(&scene, ONE_MESH("\"attributes\":{\"POSITION\":0},\"indices\":1")));
    const struct scene_mesh *mesh = &scene.meshes[0];
    assert_int_equal(mesh->vertex_count, 6);
    for (uint32_t v = 0; v < 6; v++) {
        assert_float_equal(mesh->normals[v * 3], 0.0f, 0.0f);
        assert_float_equal(mesh->normals[v * 3 + 1], 0.0f, 0.0f);
        assert_float_equal(mesh->normals[v * 3 + 2], 1.0f, 0.0f);
    }
    scene_free(&scene);
}

static void normals_of_no_length_are_those_of_the_faces(void **state)
{
    (void)state;
    struct scene scene;
    // The square's corners serve as normals, and that at the origin has none.
    must_import(import_members(
        &scene, ONE_MESH("\"attributes\":{\"POSITION\":0,\"NORMAL\":0},\"indices\":1")));
    assert_non_null(strstr(last_warning, "mesh \"door\", primitive 0"));
    assert_float_equal(scene.meshes[0].normals[2], 1.0f, EPSILON);
    assert_float_equal(scene.meshes[0].normals[3], 1.0f, EPSILON);
    scene_free(&scene);
}

static void whole_numbers_are_normalised(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene,
        ONE_MESH("\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"COLOR_0\":5},\"indices\":1")));
    const float *color = scene.meshes[0].colors;
    for (int v = 0; v < 4; v++) {
        assert_float_equal(color[v * 4], 0.0f, 0.0f);
        assert_float_equal(color[v * 4 + 1], 0.2f, EPSILON);
        assert_float_equal(color[v * 4 + 2], 0.4f, EPSILON);
        assert_float_equal(color[v * 4 + 3], 1.0f, 0.0f);
    }
    scene_free(&scene);
}

static void sparse_values_replace_zeros(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene, ONE_MESH("\"attributes\":{\"POSITION\":7,\"NORMAL\":0},\"indices\":1")));
    const float *p = scene.meshes[0].positions;
    for (int i = 0; i < 9; i++)
        assert_float_equal(p[i], 0.0f, 0.0f);
    assert_float_equal(p[9], 2.0f, 0.0f);
    assert_float_equal(p[10], 2.0f, 0.0f);
    scene_free(&scene);
}

static void a_matrix_is_its_translation_rotation_and_scale(void **state)
{
    (void)state;
    // A quarter turn about z, scale 2, 3, 4, moved by 5, 6, 7.
    static const char *const transforms[] = {
        "\"matrix\":[0,2,0,0,-3,0,0,0,0,0,4,0,5,6,7,1]",
        "\"translation\":[5,6,7],\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],"
        "\"scale\":[2,3,4]"};
    static const double expected[12] = {0, -3, 0, 5, 2, 0, 0, 6, 0, 0, 4, 7};
    for (int i = 0; i < 2; i++) {
        struct scene scene;
        must_import(import_members(
            &scene,
            ",\"nodes\":[{\"children\":[1],%s},{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
            transforms[i]));
        assert_int_equal(scene.instance_count, 1);
        for (int k = 0; k < 12; k++)
            assert_true(fabs(scene.instances[0].to_world[k] - expected[k]) < 1e-12);
        scene_free(&scene);
    }
}

static void a_mesh_placed_twice_is_kept_once(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene, ",\"nodes\":[{\"mesh\":0},{\"mesh\":0}],\"scenes\":[{\"nodes\":[0,1]}],"
                "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"));
    assert_int_equal(scene.mesh_count, 1);
    assert_int_equal(scene.instance_count, 2);
    scene_free(&scene);
}

static void the_default_scene_is_shown(void **state)
{
    (void)state;
    static const struct {
        const char *members;
        uint32_t instance_count;
    } cases[] = {{"\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1,2]}]", 1},
                 {"\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1,2]}]", 2},
                 {"\"samplers\":[]", 3}};
    for (int i = 0; i < 3; i++) {
        struct scene scene;
        must_import(import_members(
            &scene,
            ",%s,\"nodes\":[{\"mesh\":0},{\"mesh\":0},{\"mesh\":0}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]",
            cases[i].members));
        assert_int_equal(scene.instance_count, cases[i].instance_count);
        assert_int_equal(warning_total, i == 2 ? 1 : 0);
        scene_free(&scene);
    }
}

static void scale_changes_no_light(void **state)
{
    (void)state;
    static const char *const scales[] = {"1,1,1", "3,3,3", "1,1,-2", "0.1,5,0.3"};
    for (int i = 0; i < 4; i++) {
        struct scene scene;
        // A quarter turn about x takes -z to +y.
        must_import(import_members(
            &scene,
            ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\",\"spot\":{},"
            "\"color\":[0.5,1,0],\"intensity\":10}]}},\"scenes\":[{\"nodes\":[0]}],"
            "\"nodes\":[{\"translation\":[1,2,3],\"scale\":[%s],"
            "\"rotation\":[0.7071067811865476,0,0,0.7071067811865476],"
            "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]",
            scales[i]));
        const struct scene_light *light = &scene.lights[0];
        assert_int_equal(scene.light_count, 1);
        assert_int_equal(light->type, SCENE_LIGHT_SPOT);
        assert_float_equal(light->direction[0], 0.0f, EPSILON);
        assert_float_equal(light->direction[1], 1.0f, EPSILON);
        assert_float_equal(light->direction[2], 0.0f, EPSILON);
        assert_float_equal(light->position[2], 3.0f, EPSILON);
        assert_float_equal(light->color[0], 5.0f, EPSILON);
        assert_float_equal(light->color[1], 10.0f, EPSILON);
        assert_float_equal(light->range, 0.0f, 0.0f);
        assert_float_equal(light->inner_angle_rad, 0.0f, 0.0f);
        assert_float_equal(light->outer_angle_rad, 0.785398163f, EPSILON);
        scene_free(&scene);
    }
}

static void cameras_keep_names_and_place(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene,
        ",\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}},"
        "{\"name\":\"plan\",\"type\":\"orthographic\",\"orthographic\":{\"xmag\":2,\"ymag\":3,"
        "\"zfar\":9,\"znear\":1}}],\"scenes\":[{\"nodes\":[0,1]}],"
        "\"nodes\":[{\"name\":\"eye\",\"camera\":0,\"translation\":[0,0,4]},{\"camera\":1}]"));
    assert_int_equal(scene.camera_count, 2);
    assert_string_equal(scene.cameras[0].node_name, "eye");
    assert_float_equal(scene.cameras[0].yfov_rad, 0.8f, EPSILON);
    assert_float_equal(scene.cameras[0].aspect, 0.0f, 0.0f);
    assert_true(scene.cameras[0].to_world[11] == 4.0);
    assert_string_equal(scene.cameras[1].name, "plan");
    assert_true(scene.cameras[1].orthographic);
    assert_float_equal(scene.cameras[1].ymag, 3.0f, 0.0f);
    scene_free(&scene);
}

static void a_material_is_what_its_extensions_make_it(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene,
        ONE_MESH(
            "\"attributes\":{\"POSITION\":0},\"material\":0") ",\"materials\":[{"
                                                              "\"emissiveFactor\":[1,0.5,0],"
                                                              "\"alphaMode\":\"MASK\","
                                                              "\"doubleSided\":true,\"extensions\":"
                                                              "{"
                                                              "\"KHR_materials_emissive_strength\":"
                                                              "{\"emissiveStrength\":8},"
                                                              "\"KHR_materials_specular\":{"
                                                              "\"specularFactor\":0.25},"
                                                              "\"KHR_materials_ior\":{\"ior\":1.5},"
                                                              "\"KHR_materials_unlit\":{}}}]"));
    const struct scene_material *material = &scene.materials[0];
    assert_int_equal(scene.material_count, 1);
    assert_float_equal(material->emission[0], 8.0f, EPSILON);
    assert_float_equal(material->emission[1], 4.0f, EPSILON);
    assert_float_equal(material->specular_strength, 0.25f, 0.0f);
    assert_float_equal(material->specular_color[0], 1.0f, EPSILON);
    assert_float_equal(material->alpha_cutoff, 0.5f, 0.0f);
    assert_true(material->masked && material->double_sided && material->unlit);
    assert_float_equal(material->roughness, 1.0f, 0.0f);
    assert_int_equal(material->base_texture.texture, SCENE_NONE);
    scene_free(&scene);
}

// Writes a PNG of this width and one row, all red.
static void write_red_png(const char *name, uint32_t width)
{
    char path[128];
    static const float red[12] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
    snprintf(path, sizeof(path), "%s/%s", gltf_folder, name);
    assert_int_equal(image_write_rgb(path, red, width, 1, NULL, 0), STATUS_OK);
}

// The texture "plain.png", better as "bc d.png", turned by a quarter and on the second UVs.
#define TEXTURED_MATERIAL                                                                          \
    ",\"images\":[{\"uri\":\"plain.png\"},{\"uri\":\"b%%63%%20d.png\"},{\"uri\":\"none.png\"}],"   \
    "\"textures\":[{\"source\":0,\"sampler\":0,\"extensions\":{\"EXT_texture_webp\":{\"source\":"  \
    "1}"                                                                                           \
    "}}],\"samplers\":[{\"magFilter\":9728,\"wrapS\":33071,\"wrapT\":33648}],"                     \
    "\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{"          \
    "\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"texCoord\":1,"                       \
    "\"rotation\":1.5707963267948966,\"scale\":[2,3],\"offset\":[0.5,0]}}}}},{"                    \
    "\"emissiveTexture\":{\"index\":9}}]"

static void only_the_textures_that_are_seen_are_read(void **state)
{
    (void)state;
    struct scene scene;
    write_red_png("plain.png", 2);
    write_red_png("bc d.png", 3);
    must_import(import_members(&scene, ONE_MESH("\"attributes\":{\"POSITION\":0},\"material\":0")
                                           TEXTURED_MATERIAL));
    assert_int_equal(scene.image_count, 1);
    assert_int_equal(scene.images[0].width, 3);
    assert_int_equal(scene.images[0].rgba[0], 255);
    assert_int_equal(scene.images[0].rgba[1], 0);
    assert_int_equal(scene.images[0].rgba[3], 255);
    assert_int_equal(scene.textures[0].wrap_s, 1);
    assert_int_equal(scene.textures[0].wrap_t, 2);
    assert_true(scene.textures[0].nearest);

    // Counter-clockwise with v downwards: (1, 0) goes to (0, -1), and (0, 1) to (1, 0).
    const struct scene_texture_use *use = &scene.materials[0].base_texture;
    static const float expected[4] = {0, 3, -2, 0};
    assert_int_equal(use->texcoord, 1);
    for (int i = 0; i < 4; i++)
        assert_float_equal(use->uv_matrix[i], expected[i], EPSILON);
    assert_float_equal(use->uv_offset[0], 0.5f, 0.0f);
    scene_free(&scene);
}

static void morph_targets_are_added_by_their_weights(void **state)
{
    (void)state;
    struct scene scene;
    must_import(import_members(
        &scene, ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"weights\":"
                "[0.5],\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0},\"indices\":1,"
                "\"targets\":[{\"POSITION\":7}]}]}]"));
    assert_float_equal(scene.meshes[0].positions[3], 1.0f, 0.0f);
    assert_float_equal(scene.meshes[0].positions[9], 2.0f, EPSILON);
    assert_float_equal(scene.meshes[0].positions[10], 2.0f, EPSILON);
    scene_free(&scene);
}

static void a_skin_replaces_the_place_of_its_node(void **state)
{
    (void)state;
    struct scene scene;
    // COLOR_0's numbers serve as joints and weights: where the weight is not 0, the joint is one
    // of those that are moved by 7.
    static char joints[1024];
    size_t used = 0;
    for (int i = 0; i < 256; i++)
        used += (size_t)snprintf(joints + used, sizeof(joints) - used, i > 0 ? ",1" : "1");
    must_import(import_members(
        &scene,
        ",\"scenes\":[{\"nodes\":[0,1]}],\"skins\":[{\"joints\":[%s]}],\"nodes\":[{\"mesh\":0,"
        "\"skin\":0,\"translation\":[100,0,0]},{\"translation\":[7,0,0]}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"JOINTS_0\":5,"
        "\"WEIGHTS_0\":5},\"indices\":1}]}]",
        joints));
    assert_float_equal(scene.meshes[0].positions[0], 7.0f, 1e-5f);
    assert_float_equal(scene.meshes[0].positions[3], 8.0f, 1e-5f);
    assert_true(scene.instances[0].to_world[3] == 0.0);
    scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_strips_and_fans_cover_the_same_square),
        cmocka_unit_test(faces_without_normals_are_flat),
        cmocka_unit_test(normals_of_no_length_are_those_of_the_faces),
        cmocka_unit_test(whole_numbers_are_normalised),
        cmocka_unit_test(sparse_values_replace_zeros),
        cmocka_unit_test(a_matrix_is_its_translation_rotation_and_scale),
        cmocka_unit_test(a_mesh_placed_twice_is_kept_once),
        cmocka_unit_test(the_default_scene_is_shown),
        cmocka_unit_test(scale_changes_no_light),
        cmocka_unit_test(cameras_keep_names_and_place),
        cmocka_unit_test(a_material_is_what_its_extensions_make_it),
        cmocka_unit_test(only_the_textures_that_are_seen_are_read),
        cmocka_unit_test(morph_targets_are_added_by_their_weights),
        cmocka_unit_test(a_skin_replaces_the_place_of_its_node),
    };
    return cmocka_run_group_tests(tests, make_gltf_folder, remove_gltf_folder);
}
