/**
 * @file
 * Boxes on a grid of bytes (shared/byte_planes.h), rounded outwards.
 */
#ifndef PREP_BYTE_GRID_H
#define PREP_BYTE_GRID_H

#include <stdbool.h>
#include <stdint.h>

#define BYTE_GRID_BOXES 8u

/** Boxes that share a grid. */
struct byte_boxes {
    float lo[BYTE_GRID_BOXES][3], hi[BYTE_GRID_BOXES][3]; // m
    uint32_t count;
};

/** Their planes across one axis. */
struct byte_planes {
    float origin, scale; // m; a plane lies at origin + scale * (1 + byte * 2^-BYTE_PLANE_SHIFT)
    unsigned char lo[BYTE_GRID_BOXES], hi[BYTE_GRID_BOXES]; // [count of the boxes]
};

/**
 * Lays a grid along an axis and puts the boxes' planes on it, outwards by a little more than
 * kernels lose.
 *
 * @param power_of_two  Of the scale.
 * @return False if no grid reaches over the boxes.
 */
bool byte_grid_lay(struct byte_planes *out, const struct byte_boxes *boxes, int axis,
                   bool power_of_two);

#endif
