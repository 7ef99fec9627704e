/**
 * @file
 * Lights clustered into a binary tree by where they are, how strong, and which way they shine: what
 * the light BVH is made from.
 *
 * Source: A. Conty Estevez, C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree
 * Splitting", PACMCGIT 1(2), 2018: top-down by the surface area orientation heuristic.
 * Differs from it: cones do not grow light by light, which depends on their order and takes
 * trigonometry for each. A set's axis is the middle of the box of its lights' axes; a candidate's
 * cone is bounded from that box, and a node's is the narrowest about its axis.
 */
#ifndef PREP_LIGHT_CLUSTER_H
#define PREP_LIGHT_CLUSTER_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "shared/light.h"

/** What is known of a set of lights. */
struct light_bounds {
    float lo[3], hi[3]; // of positions, m
    float axis[3];      // unit
    float cos_o;        // of the widest angle between the axis and a light's own
    float cos_e;        // of the widest angle of emission off a light's own axis
    float power;        // cd: sum of intensities, or of radiance times area
    float range;        // m, the largest; FLT_MAX without
    bool two_sided;     // some light is
};

/** A node of the tree. */
struct light_cluster {
    struct light_bounds bounds;
    uint32_t left;  // several lights: left child, the right one is left + 1; one: the light
    uint32_t count; // lights below
};

/**
 * Builds the tree.
 *
 * @param[out] out  [2 * light_count - 1], root at 0; to be released with free().
 * @param lights, shapes, power  As light_bvh_build() takes them; light_count > 0.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status light_clusters_build(struct light_cluster **out, const struct light *lights,
                                 const struct light_shape *shapes, const float *power,
                                 uint32_t light_count);

#endif
