// Our own tangents are those of files that bring some.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/status.h"
#include "scene/gltf_import.h"

#define LEAST_COSINE 0.9999 // between the two: half a degree

// Copies a GLB with its tangents named as something that nobody reads; false if there is no file.
static bool hide_tangents(const char *copy, const char *path)
{
    FILE *in = fopen(path, "rb");
    if (in == NULL)
        return false;
    FILE *out = fopen(copy, "wb");
    assert_non_null(out);
    static const char name[] = "\"TANGENT\"";
    const size_t length = sizeof(name) - 1;
    size_t matched = 0;
    unsigned found = 0;
    for (int c = fgetc(in); c != EOF; c = fgetc(in)) {
        matched = c == name[matched] ? matched + 1 : (c == name[0] ? 1 : 0);
        fputc(c, out);
        if (matched < length)
            continue;
        fseek(out, -(long)length + 1, SEEK_CUR);
        fputc('_', out);
        fseek(out, 0, SEEK_END);
        matched = 0;
        found++;
    }
    fclose(in);
    assert_int_equal(fclose(out), 0);
    assert_true(found > 0);
    return true;
}

static void compare(const struct scene_mesh *theirs, const struct scene_mesh *ours)
{
    assert_int_equal(theirs->triangle_count, ours->triangle_count);
    if (theirs->tangents == NULL)
        return;
    for (size_t i = 0; i < (size_t)theirs->triangle_count * 3; i++) {
        const float *a = theirs->tangents + theirs->indices[i] * (size_t)4;
        const float *b = ours->tangents + ours->indices[i] * (size_t)4;
        assert_true((double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2] > LEAST_COSINE);
        assert_true(a[3] == b[3]);
    }
}

static void made_tangents_are_those_of_the_file(void **state)
{
    (void)state;
    const char *shared = getenv("LIGHTKILN_SHARED");
    char path[512];
    char copy[] = "/tmp/lightkiln-tangents-XXXXXX";
    snprintf(path, sizeof(path), "%s/scenes/features/AlphaBlendModeTest/AlphaBlendModeTest.glb",
             shared != NULL ? shared : "../shared");
    const int file = mkstemp(copy);
    assert_true(file >= 0);
    close(file);
    if (!hide_tangents(copy, path)) {
        unlink(copy);
        print_message("skipped: there is no file %s\n", path);
        skip();
    }
    struct scene theirs = {0};
    struct scene ours = {0};
    assert_int_equal(gltf_import(&theirs, path), STATUS_OK);
    assert_int_equal(gltf_import(&ours, copy), STATUS_OK);
    unlink(copy);
    assert_int_equal(theirs.mesh_count, ours.mesh_count);
    for (uint32_t i = 0; i < theirs.mesh_count; i++)
        compare(&theirs.meshes[i], &ours.meshes[i]);
    scene_free(&ours);
    scene_free(&theirs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(made_tangents_are_those_of_the_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
