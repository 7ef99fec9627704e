#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "core/file.h"
#include "core/status.h"
#include "scene/image_io.h"
#include "folder.h"

#define WIDTH  5u
#define HEIGHT 3u

static float picture[WIDTH * HEIGHT * 3];

static int make_picture(void **state)
{
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; i++)
        picture[i] = (float)(i * i % 97) / 96.0f;
    return folder_setup(state);
}

static void write_picture(const char *name)
{
    const struct image_attribute attributes[] = {{"lightkiln:seed", "7"}};
    assert_int_equal(image_write_rgb(in_folder(name), picture, WIDTH, HEIGHT, attributes, 1),
                     STATUS_OK);
}

// Largest difference between the picture and a file.
static float largest_error(const char *name, float (*expect)(float))
{
    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(image_read_rgb(&rgb, &width, &height, in_folder(name)), STATUS_OK);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    float largest = 0.0f;
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; i++)
        largest = fmaxf(largest, fabsf(rgb[i] - expect(picture[i])));
    free(rgb);
    return largest;
}

static float same(float value)
{
    return value;
}

static float linear_of_srgb(float value)
{
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

static void float_files_come_back_exactly(void **state)
{
    (void)state;
    write_picture("exact.exr");
    write_picture("exact.tif");
    assert_true(largest_error("exact.exr", same) == 0.0f);
    assert_true(largest_error("exact.tif", same) == 0.0f);
}

static void shared_exponents_come_back_within_their_step(void **state)
{
    (void)state;
    write_picture("near.hdr");
    assert_true(largest_error("near.hdr", same) < 1.0f / 127.0f);
}

static void eight_bit_files_are_read_as_srgb(void **state)
{
    (void)state;
    write_picture("coded.png");
    // Half a step of 1/255, where sRGB is steepest (2.3 times).
    assert_true(largest_error("coded.png", linear_of_srgb) < 2.3f * 0.5f / 255.0f);
}

static void equal_pictures_are_equal_files(void **state)
{
    (void)state;
    static const char *const extensions[] = {"exr", "hdr", "tif", "png", "jpg"};
    char names[5][2][16];
    for (int i = 0; i < 5; i++) {
        snprintf(names[i][0], sizeof(names[i][0]), "first.%s", extensions[i]);
        snprintf(names[i][1], sizeof(names[i][1]), "second.%s", extensions[i]);
        write_picture(names[i][0]);
    }
    // A time stamp would differ after more than a second.
    usleep(1100 * 1000);
    for (int i = 0; i < 5; i++) {
        char *bytes[2] = {NULL, NULL};
        size_t sizes[2];
        write_picture(names[i][1]);
        for (int k = 0; k < 2; k++)
            assert_int_equal(file_read(&bytes[k], &sizes[k], in_folder(names[i][k])), STATUS_OK);
        assert_int_equal(sizes[0], sizes[1]);
        assert_memory_equal(bytes[0], bytes[1], sizes[0]);
        free(bytes[0]);
        free(bytes[1]);
    }
}

static void decoding_inverts_quantising(void **state)
{
    (void)state;
    char *bytes = NULL;
    size_t size = 0;
    uint8_t *rgba = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    write_picture("decode.png");
    assert_int_equal(file_read(&bytes, &size, in_folder("decode.png")), STATUS_OK);
    assert_int_equal(image_decode(&rgba, &width, &height, bytes, size, "decode.png"), STATUS_OK);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        for (size_t c = 0; c < 3; c++)
            assert_int_equal(rgba[i * 4 + c], (int)(picture[i * 3 + c] * 255.0f + 0.5f));
        assert_int_equal(rgba[i * 4 + 3], 255);
    }
    free(rgba);
    free(bytes);
}

static void webp_colours_are_not_multiplied_by_alpha(void **state)
{
    (void)state;
    // 4 x 4 texels of 200, 100, 50 with alpha 64, lossless.
    static const uint8_t webp[] = {0x52, 0x49, 0x46, 0x46, 0x1e, 0x00, 0x00, 0x00, 0x57, 0x45,
                                   0x42, 0x50, 0x56, 0x50, 0x38, 0x4c, 0x11, 0x00, 0x00, 0x00,
                                   0x2f, 0x03, 0xc0, 0x00, 0x10, 0x07, 0x50, 0xb2, 0x22, 0x57,
                                   0xa6, 0x40, 0x81, 0x88, 0xe8, 0x7f, 0x00, 0x00};
    uint8_t *rgba = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(image_decode(&rgba, &width, &height, webp, sizeof(webp), "webp"), STATUS_OK);
    assert_int_equal(width, 4);
    // The reader's rounding at alpha 64 is half of 255 / 64.
    assert_in_range(rgba[0], 198, 202);
    assert_in_range(rgba[1], 98, 102);
    assert_in_range(rgba[2], 48, 52);
    assert_int_equal(rgba[3], 64);
    free(rgba);
}

static void every_cut_of_an_image_is_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"cut.png", "cut.jpg"};
    for (int n = 0; n < 2; n++) {
        char *bytes = NULL;
        size_t size = 0;
        write_picture(names[n]);
        assert_int_equal(file_read(&bytes, &size, in_folder(names[n])), STATUS_OK);
        for (size_t cut = 0; cut < size; cut++) {
            uint8_t *rgba = NULL;
            uint32_t width = 0;
            uint32_t height = 0;
            assert_int_equal(image_decode(&rgba, &width, &height, bytes, cut, names[n]),
                             STATUS_FORMAT);
            assert_non_null(strstr(status_message(), names[n]));
            assert_null(rgba);
        }
        free(bytes);
    }
}

static void unknown_names_are_refused(void **state)
{
    (void)state;
    assert_int_equal(image_write_rgb(in_folder("a.bmp"), picture, WIDTH, HEIGHT, NULL, 0),
                     STATUS_USAGE);
    assert_int_equal(image_write_rgb(in_folder("a"), picture, WIDTH, HEIGHT, NULL, 0),
                     STATUS_USAGE);
}

static void an_unwritable_place_is_a_status(void **state)
{
    (void)state;
    assert_int_equal(image_write_rgb(in_folder("none/a.exr"), picture, WIDTH, HEIGHT, NULL, 0),
                     STATUS_WRITE);
}

static void a_missing_file_is_a_status(void **state)
{
    (void)state;
    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(image_read_rgb(&rgb, &width, &height, in_folder("none.exr")), STATUS_IO);
    assert_null(rgb);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(float_files_come_back_exactly),
        cmocka_unit_test(shared_exponents_come_back_within_their_step),
        cmocka_unit_test(eight_bit_files_are_read_as_srgb),
        cmocka_unit_test(equal_pictures_are_equal_files),
        cmocka_unit_test(decoding_inverts_quantising),
        cmocka_unit_test(webp_colours_are_not_multiplied_by_alpha),
        cmocka_unit_test(every_cut_of_an_image_is_refused),
        cmocka_unit_test(unknown_names_are_refused),
        cmocka_unit_test(an_unwritable_place_is_a_status),
        cmocka_unit_test(a_missing_file_is_a_status),
    };
    return cmocka_run_group_tests(tests, make_picture, folder_teardown);
}
