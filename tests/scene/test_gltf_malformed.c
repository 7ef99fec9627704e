#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "gltf_support.h"

#define TRIANGLES ONE_MESH("\"attributes\":{\"POSITION\":0},\"indices\":1")

// A node with one light of EXT_lights_area.
#define AREA_LIGHT(members)                                                                        \
    ",\"nodes\":[{\"extensions\":{\"EXT_lights_area\":{\"light\":0}}}],\"extensions\":"            \
    "{\"EXT_lights_area\":{\"lights\":[{" members "}]}}"

// A scene with one light of EXT_lights_image_based.
#define IMAGE_LIGHT(members)                                                                       \
    ",\"scenes\":[{\"extensions\":{\"EXT_lights_image_based\":{\"light\":0}}}],\"extensions\":"    \
    "{\"EXT_lights_image_based\":{\"lights\":[{" members "}]}}"

// Members that must be refused, with the status and a part of the message.
static const struct {
    const char *members;
    enum status status;
    const char *part;
} refusals[] = {
    // Things that do not exist.
    {ONE_MESH("\"attributes\":{\"POSITION\":99}"), STATUS_FORMAT, "accessor 99"},
    {ONE_MESH("\"attributes\":{\"POSITION\":-5}"), STATUS_FORMAT, "mesh \"door\", primitive 0"},
    {ONE_MESH("\"attributes\":{\"POSITION\":0},\"material\":3"), STATUS_FORMAT, "material 3"},
    {",\"scene\":4,\"scenes\":[{}]", STATUS_FORMAT, "scene 4"},
    {",\"scenes\":[{\"nodes\":[1]}],\"nodes\":[{}]", STATUS_FORMAT, "node 1"},
    {",\"nodes\":[{\"mesh\":2}]", STATUS_FORMAT, "mesh 2"},
    {",\"nodes\":[{\"camera\":2}]", STATUS_FORMAT, "camera 2"},
    {",\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]", STATUS_FORMAT,
     "light 0"},
    // Wrong elements.
    {ONE_MESH("\"attributes\":{\"POSITION\":1}"), STATUS_FORMAT, "has 1 numbers, not 3"},
    {ONE_MESH("\"attributes\":{\"POSITION\":0,\"NORMAL\":6}"), STATUS_FORMAT, "NORMAL has 3"},
    {ONE_MESH("\"attributes\":{\"POSITION\":6}"), STATUS_FORMAT, "not finite"},
    {ONE_MESH("\"attributes\":{\"POSITION\":0},\"indices\":4"), STATUS_FORMAT, "restart"},
    {ONE_MESH("\"attributes\":{\"POSITION\":6},\"indices\":1"), STATUS_FORMAT, "not finite"},
    {ONE_MESH("\"attributes\":{\"POSITION\":0},\"mode\":7"), STATUS_FORMAT, "mode 7"},
    // Hierarchies that are none.
    {",\"nodes\":[{\"children\":[0]}]", STATUS_FORMAT, "its own ancestor"},
    {",\"nodes\":[{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}]", STATUS_FORMAT,
     "two parents"},
    {",\"nodes\":[{},{\"children\":[2]},{\"children\":[1]}]", STATUS_FORMAT, "its own ancestor"},
    {",\"scenes\":[{\"nodes\":[1]}],\"nodes\":[{\"children\":[1]},{}]", STATUS_FORMAT, "no root"},
    {",\"nodes\":[{\"rotation\":[0,0,0,0]}]", STATUS_FORMAT, "quaternion"},
    {",\"nodes\":[{\"scale\":[1,1]}]", STATUS_FORMAT, "scale has 2 numbers"},
    {",\"nodes\":[{\"translation\":[1e300,0,0]}]", STATUS_FORMAT, "translation"},
    {",\"nodes\":[{\"translation\":[1e999,0,0]}]", STATUS_FORMAT, "overflow"},
    // Cameras and lights that cannot be.
    {",\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
     "{\"yfov\":4,\"znear\":1}}]",
     STATUS_FORMAT, "yfov"},
    {",\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],\"extensions\":"
     "{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":-1}]}}",
     STATUS_FORMAT, "negative"},
    {",\"scenes\":[{\"extensions\":{\"EXT_lights_image_based\":{\"light\":0}}}]", STATUS_FORMAT,
     "image-based light 0"},
    {IMAGE_LIGHT("\"intensity\":1"), STATUS_FORMAT, "image-based light 0: specularImages"},
    {IMAGE_LIGHT("\"specularImages\":[[0,0,0,0,0]]"), STATUS_FORMAT, "six images"},
    {IMAGE_LIGHT("\"specularImages\":[[0,0,0,0,0,0]]"), STATUS_FORMAT, "image 0"},
    {IMAGE_LIGHT("\"intensity\":-1,\"specularImages\":[]"), STATUS_FORMAT, "intensity of -1"},
    {IMAGE_LIGHT("\"rotation\":[0,0,0,0],\"specularImages\":[]"), STATUS_FORMAT, "quaternion"},
    {AREA_LIGHT("\"type\":\"sphere\""), STATUS_FORMAT, "type \"sphere\""},
    {AREA_LIGHT("\"name\":\"lamp\""), STATUS_FORMAT, "area light 0: type"},
    {AREA_LIGHT("\"type\":\"disk\",\"size\":0"), STATUS_FORMAT, "size 0"},
    {AREA_LIGHT("\"type\":\"disk\",\"size\":1e300"), STATUS_FORMAT, "its size"},
    {AREA_LIGHT("\"type\":\"rect\",\"rect\":{\"aspect\":-1}"), STATUS_FORMAT, "aspect -1"},
    {AREA_LIGHT("\"type\":\"rect\",\"color\":[1,1]"), STATUS_FORMAT, "color"},
    {AREA_LIGHT("\"type\":\"rect\",\"intensity\":-2"), STATUS_FORMAT, "negative"},
    {",\"nodes\":[{\"extensions\":{\"EXT_lights_area\":{\"light\":0}}}]", STATUS_FORMAT,
     "area light 0"},
    // Extensions.
    {",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]", STATUS_UNSUPPORTED,
     "KHR_draco_mesh_compression"},
    {",\"extensionsRequired\":[\"VENDOR_fog\"]", STATUS_UNSUPPORTED, "VENDOR_fog"},
    {",\"meshes\":{}", STATUS_FORMAT, "\"meshes\" is not an array"},
};

static void bad_files_are_refused_by_name(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof(refusals) / sizeof(refusals[0]); i++) {
        struct scene scene;
        const enum status status = import_members(&scene, "%s", refusals[i].members);
        if (status != refusals[i].status || strstr(status_message(), refusals[i].part) == NULL)
            fail_msg("%s: status %d, \"%s\"", refusals[i].members, status, status_message());
        assert_non_null(strstr(status_message(), gltf_path));
        assert_null(scene.arena.blocks);
    }
}

static void nothing_outside_the_folder_is_read(void **state)
{
    (void)state;
    static const char *const uris[] = {"../data.bin",        "%2e%2e/data.bin",
                                       "a/../../data.bin",   "/etc/passwd",
                                       "file:///etc/passwd", "http://example.org/data.bin",
                                       "%2Fetc%2Fpasswd",    "data.bin%00.png",
                                       "none.bin",           "."};
    for (size_t i = 0; i < sizeof(uris) / sizeof(uris[0]); i++) {
        struct scene scene;
        const enum status status = import_members(
            &scene,
            TRIANGLES ",\"buffers\":[{\"name\":\"walls\",\"byteLength\":152,\"uri\":\"%s\"}]",
            uris[i]);
        assert_int_not_equal(status, STATUS_OK);
        assert_non_null(strstr(status_message(), "buffer \"walls\""));
    }
}

static void a_path_may_turn_within_the_folder(void **state)
{
    (void)state;
    struct scene scene;
    assert_int_equal(import_members(&scene, TRIANGLES ",\"buffers\":[{\"byteLength\":152,"
                                                      "\"uri\":\"./a/../d%%61ta.bin\"}]"),
                     STATUS_IO); // there is no folder a
    assert_int_equal(import_members(&scene, TRIANGLES ",\"buffers\":[{\"byteLength\":152,"
                                                      "\"uri\":\"./d%%61ta.bin\"}]"),
                     STATUS_OK);
    scene_free(&scene);
}

static void sizes_that_overflow_are_refused(void **state)
{
    (void)state;
    static const char *const accessors[] = {
        "\"bufferView\":0,\"count\":4611686018427387904",
        "\"bufferView\":0,\"count\":18446744073709551615",
        "\"bufferView\":0,\"count\":4,\"byteOffset\":18446744073709551612",
        "\"bufferView\":0,\"count\":5",
        "\"bufferView\":0,\"count\":4,\"byteOffset\":4",
        "\"bufferView\":6,\"count\":4",
        "\"bufferView\":5,\"count\":4",
        "\"count\":2147483647",
        "\"count\":4,\"sparse\":{\"count\":5,\"indices\":{\"bufferView\":4,\"componentType\":5121},"
        "\"values\":{\"bufferView\":5}}",
        "\"count\":3,\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":4,\"componentType\":5121},"
        "\"values\":{\"bufferView\":5}}",
    };
    for (size_t i = 0; i < sizeof(accessors) / sizeof(accessors[0]); i++) {
        struct scene scene;
        const enum status status =
            import_members(&scene,
                           ONE_MESH("\"attributes\":{\"POSITION\":0}") ",\"accessors\":[{"
                                                                       "\"componentType\":5126,"
                                                                       "\"type\":\"VEC3\",%s}]",
                           accessors[i]);
        if (status != STATUS_FORMAT && status != STATUS_LIMIT)
            fail_msg("%s: status %d", accessors[i], status);
    }
}

static void a_missing_texture_names_its_material(void **state)
{
    (void)state;
    struct scene scene;
    assert_int_equal(import_members(&scene, ONE_MESH("\"attributes\":{\"POSITION\":0},\"material\":"
                                                     "0") ",\"images\":[{"
                                                          "\"uri\":\"none.png\"}],\"textures\":[{"
                                                          "\"source\":0}],\"materials\":[{"
                                                          "\"name\":\"paint\",\"emissiveTexture\":{"
                                                          "\"index\":0}}]"),
                     STATUS_IO);
    assert_non_null(strstr(status_message(), "paint"));
    assert_non_null(strstr(status_message(), "none.png"));
}

static void optional_extensions_are_told_once(void **state)
{
    (void)state;
    struct scene scene;
    assert_int_equal(import_members(&scene,
                                    TRIANGLES ",\"extensionsUsed\":[\"VENDOR_fog\",\"VENDOR_rain\","
                                              "\"KHR_materials_unlit\"]"),
                     STATUS_OK);
    assert_int_equal(warning_total, 1);
    assert_non_null(strstr(last_warning, "VENDOR_fog, VENDOR_rain"));
    assert_null(strstr(last_warning, "unlit"));
    scene_free(&scene);
}

static void deep_text_is_refused_and_deep_nodes_load(void **state)
{
    (void)state;
    struct scene scene;
    const size_t depth = 100000;
    char *text = malloc(depth * 40 + 1000);
    size_t used = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"extras\":");
    memset(text + used, '[', depth);
    text[used + depth] = '\0';
    assert_int_equal(import_text(&scene, text), STATUS_FORMAT);

    used = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[");
    for (size_t i = 1; i < depth; i++)
        used += (size_t)sprintf(text + used, "{\"children\":[%zu]},", i);
    strcpy(text + used, "{}]}");
    assert_int_equal(import_text(&scene, text), STATUS_OK);
    scene_free(&scene);
    free(text);
}

static void put_u32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> (8 * i));
}

// Makes a GLB of DATA_JSON with one mesh and data.bin within; returns its size.
static size_t make_glb(uint8_t *glb)
{
    char json[4096];
    snprintf(json, sizeof(json), "%s%s,\"buffers\":[{\"byteLength\":152}]}", DATA_JSON, TRIANGLES);
    while (strlen(json) % 4 != 0)
        strcat(json, " ");
    const uint32_t json_size = (uint32_t)strlen(json);
    memcpy(glb, "glTF", 4);
    put_u32(glb + 4, 2);
    put_u32(glb + 8, 12 + 8 + json_size + 8 + DATA_SIZE);
    put_u32(glb + 12, json_size);
    memcpy(glb + 16, "JSON", 4);
    memcpy(glb + 20, json, json_size);
    put_u32(glb + 20 + json_size, DATA_SIZE);
    memcpy(glb + 24 + json_size, "BIN", 4);
    fill_data(glb + 28 + json_size);
    return 28 + json_size + DATA_SIZE;
}

static enum status import_glb(struct scene *scene, const uint8_t *glb, size_t size)
{
    char path[128];
    *scene = (struct scene){0};
    snprintf(path, sizeof(path), "%s/test.glb", gltf_folder);
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(glb, 1, size, file) != size || fclose(file) != 0)
        abort();
    return gltf_import(scene, path);
}

static void standard_input_is_a_file_without_a_folder(void **state)
{
    (void)state;
    uint8_t glb[4096];
    const size_t size = make_glb(glb);
    struct scene scene;
    assert_int_equal(import_glb(&scene, glb, size), STATUS_OK);
    scene_free(&scene);
    char path[128];
    snprintf(path, sizeof(path), "%s/test.glb", gltf_folder);
    assert_non_null(freopen(path, "rb", stdin));
    assert_int_equal(gltf_import(&scene, "-"), STATUS_OK);
    assert_int_equal(scene.meshes[0].triangle_count, 2);
    scene_free(&scene);

    assert_int_equal(import_members(&scene, TRIANGLES), STATUS_OK);
    scene_free(&scene);
    assert_non_null(freopen(gltf_path, "rb", stdin));
    assert_int_equal(gltf_import(&scene, "-"), STATUS_IO);
    assert_non_null(strstr(status_message(), "standard input"));
}

static void every_cut_of_a_glb_is_refused(void **state)
{
    (void)state;
    uint8_t glb[4096];
    const size_t size = make_glb(glb);
    struct scene scene;
    assert_int_equal(import_glb(&scene, glb, size), STATUS_OK);
    assert_int_equal(scene.meshes[0].triangle_count, 2);
    scene_free(&scene);
    for (size_t cut = 0; cut < size; cut += 3)
        assert_int_equal(import_glb(&scene, glb, cut), STATUS_FORMAT);
}

static void a_changed_byte_never_crashes(void **state)
{
    (void)state;
    static const uint8_t values[] = {0x00, 0xff, '9', '-', '"', '{'};
    uint8_t glb[4096];
    const size_t size = make_glb(glb);
    for (size_t at = 0; at < size; at++) {
        const uint8_t kept = glb[at];
        glb[at] = values[at % sizeof(values)];
        struct scene scene;
        if (import_glb(&scene, glb, size) == STATUS_OK)
            scene_free(&scene);
        glb[at] = kept;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_files_are_refused_by_name),
        cmocka_unit_test(nothing_outside_the_folder_is_read),
        cmocka_unit_test(a_path_may_turn_within_the_folder),
        cmocka_unit_test(sizes_that_overflow_are_refused),
        cmocka_unit_test(a_missing_texture_names_its_material),
        cmocka_unit_test(optional_extensions_are_told_once),
        cmocka_unit_test(deep_text_is_refused_and_deep_nodes_load),
        cmocka_unit_test(standard_input_is_a_file_without_a_folder),
        cmocka_unit_test(every_cut_of_a_glb_is_refused),
        cmocka_unit_test(a_changed_byte_never_crashes),
    };
    return cmocka_run_group_tests(tests, make_gltf_folder, remove_gltf_folder);
}
