/**
 * @file
 * Planes of boxes as bytes: what the layouts of a BVH whose nodes have a grid of their own share.
 *
 * A kernel makes the float 1 + byte * 2^-BYTE_PLANE_SHIFT by putting the byte among the bits of 1,
 * and multiplies it by the grid's cell times 2^BYTE_PLANE_SHIFT: cheaper than converting it, and
 * off by 2^-9 of a cell at most.
 */
#ifndef SHARED_BYTE_PLANES_H
#define SHARED_BYTE_PLANES_H

#include "shared/base.h"

#define BYTE_PLANE_SHIFT 15 // binary places below 1 of a byte's lowest bit

#endif
