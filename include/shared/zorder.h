/**
 * @file
 * The order in which pixels enter the ray queue: Z-order (Morton order) inside tiles, tiles by
 * rows.
 *
 * The thesis (section 3.5) walks the whole image in Z-order, which is a bijection for squares of a
 * power of two only. Tiles keep it one at any size: a whole tile is walked in Z-order, a cut one at
 * the right or lower edge row by row. A tile is 1024 rays, far more than share a warp or a cache
 * line, so nothing of the coherence is lost.
 */
#ifndef SHARED_ZORDER_H
#define SHARED_ZORDER_H

#include "shared/base.h"

#define ZORDER_TILE 32u // pixels on a side; a power of two, at most 65536

// Drops the odd bits and closes the gaps: ...d-c-b-a -> ...dcba.
static inline uint zorder_compact_bits(uint v)
{
    v &= 0x55555555u;
    v = (v | (v >> 1)) & 0x33333333u;
    v = (v | (v >> 2)) & 0x0f0f0f0fu;
    v = (v | (v >> 4)) & 0x00ff00ffu;
    v = (v | (v >> 8)) & 0x0000ffffu;
    return v;
}

// Column and row of the pixel at place `index` of the order, 0 <= index < width * height.
static inline uint2 zorder_place(uint index, uint width, uint height)
{
    // Find the band of tiles, then the tile in it.
    const uint band = index / (width * ZORDER_TILE);
    const uint y0 = band * ZORDER_TILE;
    const uint band_height = height - y0 < ZORDER_TILE ? height - y0 : ZORDER_TILE;
    const uint in_band = index - y0 * width;
    const uint x0 = in_band / (ZORDER_TILE * band_height) * ZORDER_TILE;
    const uint tile_width = width - x0 < ZORDER_TILE ? width - x0 : ZORDER_TILE;
    const uint in_tile = in_band - x0 * band_height;

    // Find the pixel in the tile.
    uint2 place;
    if (tile_width == ZORDER_TILE && band_height == ZORDER_TILE) {
        place.x = x0 + zorder_compact_bits(in_tile);
        place.y = y0 + zorder_compact_bits(in_tile >> 1);
    } else {
        place.x = x0 + in_tile % tile_width;
        place.y = y0 + in_tile / tile_width;
    }
    return place;
}

// That pixel's number, x + y * width.
static inline uint zorder_pixel(uint index, uint width, uint height)
{
    const uint2 place = zorder_place(index, width, height);
    return place.y * width + place.x;
}

#endif
