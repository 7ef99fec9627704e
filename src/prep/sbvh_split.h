/**
 * @file
 * The ways to split a node of the SBVH (prep/sbvh.h): by objects, in space.
 */
#ifndef PREP_SBVH_SPLIT_H
#define PREP_SBVH_SPLIT_H

#include <stdint.h>

#include "prep/box.h"
#include "prep/flatten.h"
#include "prep/presplit.h"

// Overlap of an object split's children, part of the root's surface, from which on splits in space
// are tried (Stich et al., section 4.5). With 1e-5 as there, a build of Sponza takes 1.6 times as
// long, and no ray is faster.
#define SPLIT_ALPHA 1e-4

/** Parts of triangles, in any order. */
struct part_set {
    struct box *boxes;               // of each part
    uint32_t *order;                 // which of refs[] each is a part of
    const struct tri_ref *refs;      // borrowed
    const struct geometry *geometry; // borrowed
};

/** The cheapest way found to deal out whole references by their centers. */
struct object_split {
    int axis;       // -1: no plane parts the centers
    int plane;      // references with a bin below go left; 0: those with their center below lo
    float lo;       // of the centers on the axis
    float scale;    // bins a metre
    double cost;    // references times half surface, m2; DBL_MAX with axis -1
    double overlap; // half surface of what both sides share, m2
};

/** The cheapest plane found to cut references at. */
struct spatial_split {
    int axis;
    float at;               // m
    double cost;            // as above; DBL_MAX: none found
    struct box left, right; // of the sides
    uint32_t left_count, right_count;
};

void split_find_object(struct object_split *out, const struct part_set *parts, uint32_t first,
                       uint32_t count, const struct box *centers);

void split_find_spatial(struct spatial_split *out, const struct part_set *parts, uint32_t first,
                        uint32_t count, const struct box *bounds);

/** Reorders parts. Returns how many went left. */
uint32_t split_objects(struct part_set *parts, uint32_t first, uint32_t count,
                       const struct object_split *split);

/**
 * Cuts parts at a plane, each as far as that is cheaper than to put it on one side whole.
 *
 * @param[out] new_count  Parts there are now: left ones first, right ones behind.
 * @param room            Places from `first` on.
 * @return How many are left.
 */
uint32_t split_spatially(uint32_t *new_count, struct part_set *parts, uint32_t first,
                         uint32_t count, uint32_t room, const struct spatial_split *split);

/** Moves parts to a later place; the two may overlap. */
void split_move(struct part_set *parts, uint32_t from, uint32_t to, uint32_t count);

#endif
