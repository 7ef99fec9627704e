// The order of pixels is a bijection at any size, and Z-order in whole tiles.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdlib.h>

#include "shared/zorder.h"

static void check_bijection(uint32_t width, uint32_t height)
{
    const uint32_t count = width * height;
    uint8_t *seen = calloc(count, 1);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t pixel = zorder_pixel(i, width, height);
        assert_true(pixel < count);
        assert_int_equal(seen[pixel]++, 0);
    }
    free(seen);
}

static void every_pixel_has_one_place(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {
        {1, 1},   {1, 100}, {100, 1}, {2, 2},    {31, 33},  {32, 32},     {33, 31},
        {33, 64}, {64, 33}, {65, 97}, {1000, 3}, {3, 1000}, {1024, 1024}, {1920, 1080},
    };
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++)
        check_bijection(sizes[i][0], sizes[i][1]);
    for (uint32_t width = 1; width <= 70; width += 3)
        for (uint32_t height = 1; height <= 70; height++)
            check_bijection(width, height);
}

// Takes every second bit, one by one.
static uint32_t every_second_bit(uint32_t v)
{
    uint32_t out = 0;
    for (int bit = 0; bit < 16; bit++)
        out |= (v >> (2 * bit) & 1u) << bit;
    return out;
}

static void whole_tiles_are_walked_in_z_order(void **state)
{
    (void)state;
    const uint32_t width = 3 * ZORDER_TILE + 5;
    const uint32_t height = 2 * ZORDER_TILE + 1;
    const uint32_t tile_size = ZORDER_TILE * ZORDER_TILE;
    for (uint32_t band = 0; band < 2; band++) {
        for (uint32_t column = 0; column < 3; column++) {
            const uint32_t first = band * ZORDER_TILE * width + column * tile_size;
            for (uint32_t i = 0; i < tile_size; i++) {
                const uint32_t x = column * ZORDER_TILE + every_second_bit(i);
                const uint32_t y = band * ZORDER_TILE + every_second_bit(i >> 1);
                assert_int_equal(zorder_pixel(first + i, width, height), y * width + x);
            }
        }
    }
}

static void tiles_stay_together(void **state)
{
    (void)state;
    const uint32_t width = 2 * ZORDER_TILE + 7;
    const uint32_t height = ZORDER_TILE + 9;
    uint32_t tiles = 1;
    uint32_t last_x = 0;
    uint32_t last_y = 0;
    for (uint32_t i = 0; i < width * height; i++) {
        const uint32_t pixel = zorder_pixel(i, width, height);
        const uint32_t x = pixel % width / ZORDER_TILE;
        const uint32_t y = pixel / width / ZORDER_TILE;
        tiles += x != last_x || y != last_y;
        last_x = x;
        last_y = y;
    }
    assert_int_equal(tiles, 6); // three columns by two bands, each entered once
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_has_one_place),
        cmocka_unit_test(whole_tiles_are_walked_in_z_order),
        cmocka_unit_test(tiles_stay_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
