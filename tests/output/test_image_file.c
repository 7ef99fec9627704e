// Image files: what is written comes back, whole or not at all.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/file.h"
#include "film/tonemap.h"
#include "lightkiln/image.h"
#include "output/image_file.h"
#include "scene/image_io.h"
#include "folder.h"

#define WIDTH  7u
#define HEIGHT 5u

static float picture[WIDTH * HEIGHT * 3];
static struct lk_render_info info;

static int make_picture(void **state)
{
    for (unsigned i = 0; i < WIDTH * HEIGHT * 3; i++)
        picture[i] = (float)i * 0.03125f;
    info.spp = 16.0;
    info.settings.seed = 7;
    info.device_count = 1;
    strcpy(info.devices[0].info.name, "a device");
    return folder_setup(state);
}

static enum status write_picture(const char *path)
{
    return image_file_write(path, picture, WIDTH, HEIGHT, &info, "1", 0.0f, TONEMAP_REINHARD);
}

static void assert_comes_back(const char *name, float tolerance)
{
    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(write_picture(in_folder(name)), STATUS_OK);
    assert_int_equal(image_read_rgb(&rgb, &width, &height, in_folder(name)), STATUS_OK);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    for (unsigned i = 0; i < WIDTH * HEIGHT * 3; i++)
        if (!(fabsf(rgb[i] - picture[i]) <= tolerance * fmaxf(picture[i], 0.1f)))
            fail_msg("%s: value %u is %g, not %g", name, i, (double)rgb[i], (double)picture[i]);
    free(rgb);
}

static void linear_formats_keep_every_value(void **state)
{
    (void)state;
    assert_comes_back("a.exr", 0.0f);
    assert_comes_back("a.tif", 0.0f);
    assert_comes_back("a.tiff", 0.0f);
    assert_comes_back("A.EXR", 0.0f);
    assert_comes_back("a.hdr", 0.35f); // three mantissas of 8 bits share an exponent
}

static void png_holds_the_display_transform(void **state)
{
    (void)state;
    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(write_picture(in_folder("a.png")), STATUS_OK);
    assert_int_equal(image_read_rgb(&rgb, &width, &height, in_folder("a.png")), STATUS_OK);

    float display[WIDTH * HEIGHT * 3];
    tonemap_apply(display, picture, WIDTH * HEIGHT, 0.0f, TONEMAP_REINHARD);
    for (unsigned i = 0; i < WIDTH * HEIGHT * 3; i++)
        assert_true(fabsf(tonemap_srgb_encode(rgb[i]) - display[i]) <= 0.5f / 255.0f + 1e-3f);
    free(rgb);
}

static void equal_pictures_are_equal_files(void **state)
{
    (void)state;
    static const char *const names[] = {"a.exr", "a.hdr", "a.png", "a.jpg", "a.tif"};
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        char *first = NULL;
        char *second = NULL;
        size_t first_size = 0;
        size_t second_size = 0;
        assert_int_equal(write_picture(in_folder(names[i])), STATUS_OK);
        assert_int_equal(file_read(&first, &first_size, in_folder(names[i])), STATUS_OK);
        sleep(1); // a date would show
        info.settings.queue += 1000;
        assert_int_equal(write_picture(in_folder(names[i])), STATUS_OK);
        assert_int_equal(file_read(&second, &second_size, in_folder(names[i])), STATUS_OK);
        assert_int_equal(first_size, second_size);
        if (memcmp(first, second, first_size) != 0)
            fail_msg("%s: the files differ", names[i]);
        free(first);
        free(second);
    }
}

static void exr_tells_how_it_was_made(void **state)
{
    (void)state;
    char *bytes = NULL;
    size_t size = 0;
    assert_int_equal(write_picture(in_folder("a.exr")), STATUS_OK);
    assert_int_equal(file_read(&bytes, &size, in_folder("a.exr")), STATUS_OK);
    static const char *const texts[] = {"lightkiln 1",        "lightkiln:seed",
                                        "lightkiln:settings", "lightkiln:device",
                                        "a device",           "lightkiln:samples_per_pixel",
                                        "lightkiln:units",    "cd/m2"};
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++)
        assert_non_null(memmem(bytes, size, texts[i], strlen(texts[i])));
    free(bytes);
}

static void unknown_extensions_are_refused_at_once(void **state)
{
    (void)state;
    static const char *const names[] = {"a", "a.bmp", "a.exr/b", "exr", "a.exr.gz", ""};
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        enum image_kind kind;
        assert_int_equal(image_file_kind(&kind, names[i]), STATUS_USAGE);
        assert_int_equal(write_picture(names[i]), STATUS_USAGE);
    }
}

static void public_image_functions_agree(void **state)
{
    (void)state;
    assert_int_equal(write_picture(in_folder("a.exr")), STATUS_OK);
    assert_int_equal(lk_image_can_write(in_folder("b.png")), LK_OK);
    assert_int_equal(lk_image_can_write(in_folder("b.xyz")), LK_USAGE);
    assert_int_equal(lk_image_can_write(in_folder("none/b.png")), LK_WRITE);

    struct lk_image *image = NULL;
    struct lk_image *difference = NULL;
    struct lk_comparison result;
    assert_int_equal(lk_image_read(&image, in_folder("none.exr")), LK_IO);
    assert_null(image);
    assert_int_equal(lk_image_read(&image, in_folder("a.exr")), LK_OK);
    assert_null(lk_image_info(image));
    assert_int_equal(lk_report_write(image, in_folder("a.json")), LK_USAGE);
    assert_int_equal(lk_image_write(image, in_folder("none/b.exr"), NULL), LK_WRITE);
    assert_int_equal(lk_image_write(image, in_folder("b.exr"), NULL), LK_OK);
    assert_int_equal(lk_compare(&result, &difference, image, image), LK_OK);
    assert_true(result.rmse == 0.0);

    uint32_t width = 0;
    uint32_t height = 0;
    assert_true(lk_image_pixels(difference, &width, &height)[3] == 0.0f);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    lk_image_free(difference);
    lk_image_free(image);
    lk_image_free(NULL);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make_picture, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(linear_formats_keep_every_value),        TEST(png_holds_the_display_transform),
        TEST(equal_pictures_are_equal_files),         TEST(exr_tells_how_it_was_made),
        TEST(unknown_extensions_are_refused_at_once), TEST(public_image_functions_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
