// Sampling lights that have an area: densities are those of solid angle.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "light_samples.h"

#define POINTS        40
#define ANGLE_EPSILON 2e-3 // relative: the grid's error from half a size away
#define VALUE_EPSILON 1e-5 // relative: a few roundings

// The mean of 1 / density over all places is the solid angle.
static void check_angle(bool rectangle, bool two_sided)
{
    uint64_t seed = 1;
    for (int i = 0; i < POINTS; i++) {
        double normal[3], point[3];
        const double side = i & 1 ? -1.0 : 1.0;
        const struct shaped_light light = make_area_light(rectangle, two_sided, normal, &seed);
        random_point(point, normal, side, &seed);
        sample_from(&light, point);
        double sum = 0.0;
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const float4 value = fixture.cell_values[cell];
            if (side < 0.0 && !two_sided) {
                assert_true(value.x == 0.0f && value.y == 0.0f && value.z == 0.0f);
                continue;
            }
            assert_true(value.x == 2.0f && value.y == 3.0f && value.z == 4.0f);
            sum += 1.0 / value.w / CELLS;
        }
        const double angle = side < 0.0 && !two_sided ? 0.0 : light_angle(&light, rectangle, point);
        assert_close(sum, angle, ANGLE_EPSILON * angle);
    }
}

static void densities_integrate_to_the_solid_angle(void **state)
{
    device_of(state);
    check_angle(false, false);
    check_angle(false, true);
    check_angle(true, false);
    check_angle(true, true);
}

// Each sample lies on the light, at the distance that it says.
static void samples_lie_on_the_light(void **state)
{
    device_of(state);
    uint64_t seed = 2;
    for (int i = 0; i < 8; i++) {
        const bool rectangle = i & 1;
        double normal[3], point[3], to[3], e[3], u[3], v[3], cross[3];
        const struct shaped_light light = make_area_light(rectangle, false, normal, &seed);
        random_point(point, normal, 1.0, &seed);
        sample_from(&light, point);
        vec3_load(u, &light.shape.edge_u.x);
        vec3_load(v, &light.shape.edge_v.x);
        vec3_cross(cross, u, v);
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const float4 dir = fixture.cell_dirs[cell];
            for (int k = 0; k < 3; k++)
                to[k] = point[k] + (double)dir.w * (&dir.x)[k] - (&light.light.org_range.x)[k];
            assert_close(vec3_dot(to, normal), 0.0, VALUE_EPSILON * dir.w);
            vec3_cross(e, to, v);
            const double s = vec3_dot(e, cross) / vec3_dot(cross, cross);
            vec3_cross(e, u, to);
            const double t = vec3_dot(e, cross) / vec3_dot(cross, cross);
            assert_true(s > 0.0 && t > 0.0);
            assert_true(rectangle ? s < 1.0 && t < 1.0 : s + t < 1.0 + 1e-4);
        }
    }
}

// A disc seen from its axis, where it takes 2 pi (1 - cos) of its angle; its places are even: half
// of them lie within 1 / sqrt(2) of the radius.
static void discs_are_sampled_evenly(void **state)
{
    device_of(state);
    const double radius = 0.8;
    const double height = 1.5;
    const double point[3] = {0.0, 0.0, height};
    const struct shaped_light light = {
        .light = {.color_kind = {2.0f, 3.0f, 4.0f, bits_float(LIGHT_DISC)}},
        .shape = {.edge_u = {(float)radius, 0.0f, 0.0f, (float)(PI * radius * radius)},
                  .edge_v = {0.0f, (float)radius, 0.0f, bits_float(EMITTER_NONE)}},
    };
    sample_from(&light, point);
    double sum = 0.0;
    uint32_t inner = 0;
    for (uint32_t cell = 0; cell < CELLS; cell++) {
        const float4 dir = fixture.cell_dirs[cell];
        const double x = (double)dir.w * dir.x;
        const double y = (double)dir.w * dir.y;
        assert_close(height + (double)dir.w * dir.z, 0.0, VALUE_EPSILON);
        assert_true(sqrt(x * x + y * y) <= radius * (1.0 + VALUE_EPSILON));
        inner += x * x + y * y < 0.5 * radius * radius;
        sum += 1.0 / fixture.cell_values[cell].w / CELLS;
    }
    const double angle = 2.0 * PI * (1.0 - height / sqrt(radius * radius + height * height));
    assert_close(sum, angle, ANGLE_EPSILON * angle);
    assert_close((double)inner / CELLS, 0.5, 0.01);
}

// Four texels, taken nearest: each quarter of the uv square has its own emission.
static void textured_triangles_emit_their_texels(void **state)
{
    device_of(state);
    static const uint32_t texels[4] = {0xff0000ff, 0xff00ff00, 0xffff0000, 0xff000000};
    struct vertex corners[3] = {0};
    struct material material = {.base = {1.0f, 1.0f, 1.0f, 1.0f}};
    struct texture_slot *slot = &material.textures[TEXTURE_EMISSIVE];
    *slot = (struct texture_slot){.uv_matrix = {1.0f, 0.0f, 0.0f, 1.0f},
                                  .size = 2 | 2 << 16,
                                  .flags = TEXTURE_PRESENT | TEXTURE_NEAREST};
    const struct triangle triangle = {0, 1, 2, 0};
    corners[1].uv.x = 1.0f;
    corners[2].uv.y = 1.0f;
    uint64_t seed = 4;
    double normal[3], point[3];
    const struct shaped_light light = make_area_light(false, false, normal, &seed);
    random_point(point, normal, 1.0, &seed);
    struct gpu *gpu = fixture.gpu;
    assert_ok(buffer_write(gpu, &fixture.texels, texels, sizeof(texels)));
    assert_ok(buffer_write(gpu, &fixture.vertices, corners, sizeof(corners)));
    assert_ok(buffer_write(gpu, &fixture.triangles, &triangle, sizeof(triangle)));
    assert_ok(buffer_write(gpu, &fixture.materials, &material, sizeof(material)));
    sample_from(&light, point);
    for (uint32_t i = 0; i < CELLS; i++) {
        const float4 n = fixture.cell_numbers[i];
        const bool folded = n.x + n.y > 1.0f;
        const double s = folded ? 1.0 - n.x : n.x;
        const double t = folded ? 1.0 - n.y : n.y;
        const uint32_t texel = texels[(s > 0.5) + 2 * (t > 0.5)];
        const double expected[3] = {texel & 1 ? 2.0 : 0.0, texel >> 8 & 1 ? 3.0 : 0.0,
                                    texel >> 16 & 1 ? 4.0 : 0.0};
        assert_close3(fixture.cell_values[i], expected, 0.0);
    }
    memset(&material, 0, sizeof(material));
    assert_ok(buffer_write(gpu, &fixture.materials, &material, sizeof(material)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_integrate_to_the_solid_angle),
        cmocka_unit_test(samples_lie_on_the_light),
        cmocka_unit_test(discs_are_sampled_evenly),
        cmocka_unit_test(textured_triangles_emit_their_texels),
    };
    return cmocka_run_group_tests(tests, light_setup, light_teardown);
}
