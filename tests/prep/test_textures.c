// Materials and the texel pool: every texel of every image in use, once, where its slots say.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/textures.h"

#define IMAGES 4

// Images of different sizes, two materials; image 1 is used by nobody, image 2 twice.
struct fixture {
    struct scene_image images[IMAGES];
    struct scene_texture textures[IMAGES + 1];
    struct scene_material materials[2];
    struct scene_mesh meshes[2];
    float color[4];
    struct scene scene;
};

static struct scene_texture_use use_of(int32_t texture, uint32_t texcoord)
{
    return (struct scene_texture_use){
        .texture = texture, .texcoord = texcoord, .uv_matrix = {2, 3, 4, 5}, .uv_offset = {6, 7}};
}

static void make_fixture(struct fixture *out)
{
    memset(out, 0, sizeof(*out));
    for (uint32_t i = 0; i < IMAGES; i++) {
        struct scene_image *image = &out->images[i];
        image->name = "";
        image->width = 3 + i;
        image->height = 7 - i;
        image->rgba = malloc(4 * (size_t)image->width * image->height);
        for (uint32_t j = 0; j < 4 * image->width * image->height; j++)
            image->rgba[j] = (uint8_t)(j * 31 + i * 97);
        out->textures[i].image = (int32_t)i;
    }
    out->textures[0].nearest = true;
    out->textures[0].wrap_s = TEXTURE_WRAP_MIRROR;
    out->textures[0].wrap_t = TEXTURE_WRAP_CLAMP;
    out->textures[IMAGES].image = 2;

    for (int i = 0; i < 2; i++) {
        struct scene_material *material = &out->materials[i];
        *material = (struct scene_material){.name = "",
                                            .base_color = {0.1f, 0.2f, 0.3f, 0.4f},
                                            .metallic = 0.5f,
                                            .roughness = 0.6f,
                                            .specular_color = {0.7f, 0.8f, 0.9f},
                                            .specular_strength = 0.15f,
                                            .glossiness = 0.25f,
                                            .emission = {1, 2, 3},
                                            .alpha_cutoff = 0.35f};
        material->base_texture = use_of(0, 1);
        material->surface_texture = use_of(2, 0);
        material->emissive_texture = use_of(IMAGES, 0);
        material->specular_texture = use_of(3, 0);
        struct scene_texture_use *const unused[] = {
            &material->specular_color_texture,
            &material->normal_texture,
            &material->transmission_texture,
            &material->diffuse_transmission_texture,
            &material->coat_texture,
            &material->coat_roughness_texture,
            &material->coat_normal_texture,
            &material->sheen_color_texture,
            &material->sheen_roughness_texture,
            &material->diffuse_transmission_color_texture,
        };
        for (size_t k = 0; k < sizeof(unused) / sizeof(unused[0]); k++)
            *unused[k] = use_of(SCENE_NONE, 0);
    }
    out->materials[1].specular_glossiness = true;
    out->materials[1].masked = true;
    out->materials[1].double_sided = true;
    out->materials[1].unlit = true;
    out->meshes[0].material = 0;
    out->meshes[0].colors = out->color;
    out->meshes[1].material = 1;
    out->scene = (struct scene){.images = out->images,
                                .textures = out->textures,
                                .materials = out->materials,
                                .meshes = out->meshes,
                                .image_count = IMAGES,
                                .texture_count = IMAGES + 1,
                                .material_count = 2,
                                .mesh_count = 2};
}

static void release(struct fixture *fixture)
{
    for (int i = 0; i < IMAGES; i++)
        free(fixture->images[i].rgba);
}

static void check_texels(const struct material_set *set, const struct texture_slot *slot,
                         const struct scene_image *image)
{
    assert_int_equal(slot->size & 0xffffu, image->width);
    assert_int_equal(slot->size >> 16, image->height);
    for (uint32_t i = 0; i < image->width * image->height; i++)
        for (uint32_t k = 0; k < 4; k++)
            assert_int_equal(set->texels[slot->texel_first + i] >> (8 * k) & 255u,
                             image->rgba[4 * i + k]);
}

static void slots_lead_to_their_texels(void **state)
{
    (void)state;
    struct fixture fixture;
    struct material_set set;
    make_fixture(&fixture);
    assert_int_equal(material_set_build(&set, &fixture.scene), STATUS_OK);
    for (int i = 0; i < 2; i++) {
        const struct texture_slot *slots = set.materials[i].textures;
        check_texels(&set, &slots[TEXTURE_BASE], &fixture.images[0]);
        check_texels(&set, &slots[TEXTURE_SURFACE], &fixture.images[2]);
        check_texels(&set, &slots[TEXTURE_EMISSIVE], &fixture.images[2]);
        check_texels(&set, &slots[TEXTURE_SPECULAR], &fixture.images[3]);
        assert_int_equal(slots[TEXTURE_SPECULAR_COLOR].flags, 0);
    }
    material_set_free(&set);
    release(&fixture);
}

static void images_in_use_are_pooled_once(void **state)
{
    (void)state;
    struct fixture fixture;
    struct material_set set;
    uint64_t expected = 0;
    make_fixture(&fixture);
    for (int i = 0; i < IMAGES; i++)
        if (i != 1)
            expected += fixture.images[i].width * fixture.images[i].height;
    assert_int_equal(material_set_build(&set, &fixture.scene), STATUS_OK);
    assert_int_equal(set.texel_count, expected);
    assert_int_equal(set.materials[0].textures[TEXTURE_SURFACE].texel_first,
                     set.materials[1].textures[TEXTURE_EMISSIVE].texel_first);
    material_set_free(&set);
    release(&fixture);
}

static void flags_say_how_a_texture_is_read(void **state)
{
    (void)state;
    struct fixture fixture;
    struct material_set set;
    make_fixture(&fixture);
    assert_int_equal(material_set_build(&set, &fixture.scene), STATUS_OK);
    for (int i = 0; i < 2; i++) {
        const struct texture_slot *slots = set.materials[i].textures;
        const struct texture_slot *base = &slots[TEXTURE_BASE];
        assert_int_equal(base->flags, TEXTURE_PRESENT | TEXTURE_UV1 | TEXTURE_NEAREST |
                                          TEXTURE_SRGB |
                                          TEXTURE_WRAP_MIRROR << TEXTURE_WRAP_S_SHIFT |
                                          TEXTURE_WRAP_CLAMP << TEXTURE_WRAP_T_SHIFT);
        assert_true(base->uv_matrix.x == 2 && base->uv_matrix.y == 3 && base->uv_matrix.z == 4 &&
                    base->uv_matrix.w == 5 && base->uv_offset.x == 6 && base->uv_offset.y == 7);
        assert_int_equal(slots[TEXTURE_EMISSIVE].flags, TEXTURE_PRESENT | TEXTURE_SRGB);
        assert_int_equal(slots[TEXTURE_SPECULAR].flags, TEXTURE_PRESENT);

        // Only specular-glossiness keeps a colour in the surface texture.
        assert_int_equal(slots[TEXTURE_SURFACE].flags,
                         TEXTURE_PRESENT | (i == 1 ? TEXTURE_SRGB : 0u));
    }
    material_set_free(&set);
    release(&fixture);
}

static void factors_and_flags_are_the_files(void **state)
{
    (void)state;
    struct fixture fixture;
    struct material_set set;
    make_fixture(&fixture);
    assert_int_equal(material_set_build(&set, &fixture.scene), STATUS_OK);
    const struct material *material = &set.materials[0];
    assert_true(material->base.x == 0.1f && material->base.w == 0.4f);
    assert_true(material->emission.z == 3.0f && material->emission.w == 0.35f);
    assert_true(material->specular.x == 0.7f && material->specular.w == 0.15f);
    assert_true(material->metallic == 0.5f && material->roughness == 0.6f);
    assert_true(material->glossiness == 0.25f);
    assert_int_equal(material->flags, MATERIAL_VERTEX_COLOR);
    assert_int_equal(set.materials[1].flags, MATERIAL_SPECULAR_GLOSSINESS | MATERIAL_MASKED |
                                                 MATERIAL_EMITS_BACK | MATERIAL_UNLIT);
    material_set_free(&set);
    release(&fixture);
}

static void too_many_texels_are_a_limit(void **state)
{
    (void)state;
    struct fixture fixture;
    struct material_set set;
    make_fixture(&fixture);
    for (int i = 0; i < IMAGES; i++)
        fixture.images[i].width = fixture.images[i].height = 65535;
    assert_int_equal(material_set_build(&set, &fixture.scene), STATUS_LIMIT);
    release(&fixture);
}

static void an_empty_scene_has_no_materials(void **state)
{
    (void)state;
    const struct scene scene = {0};
    struct material_set set;
    assert_int_equal(material_set_build(&set, &scene), STATUS_OK);
    assert_int_equal(set.material_count, 0);
    assert_int_equal(set.texel_count, 0);
    material_set_free(&set);
    material_set_free(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slots_lead_to_their_texels),
        cmocka_unit_test(images_in_use_are_pooled_once),
        cmocka_unit_test(flags_say_how_a_texture_is_read),
        cmocka_unit_test(factors_and_flags_are_the_files),
        cmocka_unit_test(too_many_texels_are_a_limit),
        cmocka_unit_test(an_empty_scene_has_no_materials),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
