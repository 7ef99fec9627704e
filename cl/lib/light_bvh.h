/**
 * @file
 * Drawing lights by their estimated contribution, from the 8-wide light BVH (prep/light_bvh.h).
 *
 * Source of the estimate: A. Conty Estevez, C. Kulla, 2018, section 4.2: power over squared
 * distance, times the largest cosines that the bounds allow at the light and at the surface.
 * Differs from it: the window of KHR_lights_punctual's range is a factor, so that lights out of
 * reach have probability 0. All bounds err on the side of more, so no light that contributes has.
 *
 * Near a cluster the estimate is worth little: a light beside the point may send more than all the
 * others together. Clusters near the point are therefore replaced by their children first, as the
 * paper's splitting does (section 5.4), but the heaviest first and not more than some: what comes
 * out is a cut of the tree, the same for all draws at the point.
 *
 * Differs from the paper's splitting: not every cluster of the cut gets a ray. Lights are taken by
 * systematic sampling (W. G. Madow, L. H. Madow, "On the Theory of Systematic Sampling", 1944):
 * they lie side by side on a line, each as long as its share of the draws, and positions one apart,
 * the first of which is random, take the lights that they fall into. A light as long as 1 or longer
 * is always taken, once; so few lights that send about as much are all taken, and where one
 * outshines the others little more than one ray is spent. The line is never made: a cluster's part
 * of it is divided only if positions fall into it.
 */
#ifndef LIB_LIGHT_BVH_H
#define LIB_LIGHT_BVH_H

#include "lib/math.h"
#include "shared/geometry.h"
#include "shared/light.h"
#include "shared/rng.h"

#ifndef LIGHT_BVH_FLAT
#define LIGHT_BVH_FLAT 0 // all lights are below the root: there is no other node
#endif

#define LIGHT_CUT_SPLITS 8 // clusters that are replaced at most: 10,000 lights want so many
#define LIGHT_CUT_MOST   (LIGHT_BVH_WIDTH + (LIGHT_BVH_WIDTH - 1) * LIGHT_CUT_SPLITS)
#define LIGHT_CUT_NEAR   4.0f // squared distance, in squared radii, of clusters worth replacing

// Cosine of max(0, a - b) from cosines and sines of angles within 0 .. pi.
static inline float8 light_bvh_cos_minus(const float8 cos_a, const float8 sin_a, const float8 cos_b,
                                         const float8 sin_b)
{
    return select(cos_a * cos_b + sin_a * sin_b, (float8)(1.0f), cos_a > cos_b);
}

static inline float8 light_bvh_sine(const float8 cosine)
{
    return sqrt(max((float8)(0.0f), 1.0f - cosine * cosine));
}

// Estimates what the lights below each of a node's children send to p.
//
//   near_out  out: all bits set where p is too near for the estimate to be worth much
//   normal    unit, of the surface at p
static inline float8 light_bvh_weigh(int8 *near_out, __global const struct light_bvh_node *node,
                                     const float3 p, const float3 normal)
{
    __global const float *rows = (__global const float *)node;
    const float8 x = vload8(0, rows) - p.x;
    const float8 y = vload8(1, rows) - p.y;
    const float8 z = vload8(2, rows) - p.z;
    const float8 radius = vload8(3, rows);
    const float8 power = vload8(4, rows);
    const float8 range = vload8(5, rows);
    const float8 axis_x = vload8(6, rows);
    const float8 axis_y = vload8(7, rows);
    const float8 axis_z = vload8(8, rows);
    const float8 cos_o = vload8(9, rows);
    const float8 cos_e = vload8(10, rows);

    // Find how large the sphere looks: half its angle is b.
    const float8 radius2 = radius * radius;
    const float8 distance2 = x * x + y * y + z * z;
    const float8 apart2 = max(distance2, (float8)(1e-30f));
    const float8 distance = sqrt(apart2);
    const float8 inverse = 1.0f / distance;
    const int8 inside = distance2 <= radius2;
    const float8 sin_b = select(radius * inverse, (float8)(0.0f), inside);
    const float8 cos_b = select(light_bvh_sine(sin_b), (float8)(-1.0f), inside);

    // Bound the cosine at the lights: angle to the axis, less the cone, less the sphere.
    const float8 along = -(axis_x * x + axis_y * y + axis_z * z) * inverse;
    const float8 cos_w = select(along, fabs(along), power < 0.0f);
    const float8 cos_wo =
        light_bvh_cos_minus(cos_w, light_bvh_sine(cos_w), cos_o, light_bvh_sine(cos_o));
    const float8 cos_light = light_bvh_cos_minus(cos_wo, light_bvh_sine(cos_wo), cos_b, sin_b);

    // Bound the cosine at the surface.
    const float8 cos_n = (normal.x * x + normal.y * y + normal.z * z) * inverse;
    const float8 cos_surface = light_bvh_cos_minus(cos_n, light_bvh_sine(cos_n), cos_b, sin_b);

    // Window the range at the nearest that a light can be.
    const float8 near = max(distance - radius, (float8)(0.0f)) / range;
    const float8 near2 = near * near;
    const float8 window = 1.0f - near2 * near2;

    const float8 lit = max(cos_light, (float8)(1e-3f)); // at the very edge of a cone
    const float8 weight = fabs(power) * lit * cos_surface * window / max(apart2, radius2);
    *near_out = distance2 < LIGHT_CUT_NEAR * radius2;
    const int8 dark = cos_light <= cos_e || cos_surface <= 0.0f || near >= 1.0f;
    return select(weight, (float8)(0.0f), dark);
}

// Adds those of a node's children that can contribute.
//
//   weights  [.. LIGHT_CUT_MOST] estimates, negative where they are worth little and there is
//            something better below
//   words    [.. LIGHT_CUT_MOST] child words
// Returns how many there are now.
static inline uint light_cut_add(float *weights, uint *words, uint count,
                                 __global const struct light_bvh_node *node, const float3 p,
                                 const float3 normal)
{
    int8 near;
    float node_weights[8];
    int node_near[8];
    const float8 estimates = light_bvh_weigh(&near, node, p, normal);
    if (!any(estimates > 0.0f))
        return count;
    vstore8(estimates, 0, node_weights);
    vstore8(near, 0, node_near);
    for (int i = 0; i < 8; i++) {
        if (node_weights[i] > 0.0f) {
            const uint word = ((__global const uint *)node)[11 * 8 + i];
            const bool improves = node_near[i] && !(word & LIGHT_BVH_LEAF);
            weights[count] = improves ? -node_weights[i] : node_weights[i];
            words[count++] = word;
        }
    }
    return count;
}

// Makes all weights positive; returns their sum.
static inline float light_cut_sum(float *weights, const uint count)
{
    float sum = 0.0f;
    for (uint i = 0; i < count; i++) {
        weights[i] = fabs(weights[i]);
        sum += weights[i];
    }
    return sum;
}

// Cuts the tree for the point p: lights and clusters that hold all lights which can contribute.
//
//   sum      out: of the weights
//   weights  out: [LIGHT_CUT_MOST] what each is estimated to send, > 0
//   words    out: [LIGHT_CUT_MOST] child words
// Returns how many they are.
static inline uint light_cut(float *sum, float *weights, uint *words,
                             __global const struct light_bvh_node *nodes, const float3 p,
                             const float3 normal)
{
    uint node = 0; // to be added: the root, then what is replaced
    uint count = 0;
    for (int split = 0;; split++) {
        count = light_cut_add(weights, words, count, &nodes[node], p, normal);
        uint heaviest = 0;
        float least = 0.0f;
        for (uint i = 0; i < count; i++) {
            if (weights[i] < least) {
                least = weights[i];
                heaviest = i;
            }
        }
        if (LIGHT_BVH_FLAT || !(least < 0.0f) || split == LIGHT_CUT_SPLITS)
            break;
        node = words[heaviest];
        count--;
        weights[heaviest] = weights[count];
        words[heaviest] = words[count];
    }
    *sum = light_cut_sum(weights, count);
    return count;
}

// A walk to the lights that are taken: parts of the line that positions fall into, those of
// clusters still to be divided.
struct light_walk {
    uint count;                     // parts left
    uint bits;                      // random
    uint words[LIGHT_WALK_MOST];    // child word of each part
    float lengths[LIGHT_WALK_MOST]; // its length: the draws that fall into it, on average
    float numbers[LIGHT_WALK_MOST]; // first position from its start, < 1; in its lengths where it
                                    // is shorter than 1 and the position its only one
};

// Divides a part of the line and keeps the pieces that positions fall into.
//
//   weights, words  [count] by which it is divided, and into what
//   sum             of the weights
//   length, number  of the part, as struct light_walk has them
static inline void light_walk_divide(struct light_walk *walk, const float *weights,
                                     const uint *words, const uint count, const float sum,
                                     const float length, float number)
{
    const float unit = min2(length, 1.0f); // of what follows, in draws
    const float scale = max2(length, 1.0f) / sum;
    float before = 0.0f; // sum of the weights up to here
    float start = 0.0f;  // of the piece
    for (uint i = 0; i < count; i++) {
        before += weights[i];
        const float end = before * scale;
        if (number < end && walk->count < LIGHT_WALK_MOST) {
            const float part = weights[i] * scale;
            float first = max2(number - start, 0.0f);
            if (part * unit < 1.0f) {
                // Where it lies in the piece is the next number, with new bits for those used up.
                walk->bits = rng_mix(walk->bits);
                first += rng_unit(walk->bits) * RNG_UNIT_STEP;
                first = min2(first / part, RNG_UNIT_MAX);
            }
            walk->words[walk->count] = words[i];
            walk->lengths[walk->count] = part * unit;
            walk->numbers[walk->count] = first;
            walk->count++;
            number = length < 1.0f ? FLT_MAX : number + ceil(end - number);
        }
        start = end;
    }
}

// Begins a walk at p.
//
//   draws  1 .. LIGHT_WALK_MOST: sum over all lights of the times that they would be taken, on
//          average, if one could be taken twice
//   bits   32 random bits: their order is kept, near numbers draw near lights
static inline void light_walk_begin(struct light_walk *walk,
                                    __global const struct light_bvh_node *nodes, const float3 p,
                                    const float3 normal, const float draws, const uint bits)
{
    float weights[LIGHT_CUT_MOST];
    uint words[LIGHT_CUT_MOST];
    float sum;
    const uint count = light_cut(&sum, weights, words, nodes, p, normal);
    walk->count = 0;
    walk->bits = bits;
    light_walk_divide(walk, weights, words, count, sum, draws, rng_unit(bits));
}

// A walk that takes the first light.
static inline void light_walk_take_first(struct light_walk *walk)
{
    walk->count = 1;
    walk->words[0] = LIGHT_BVH_LEAF;
    walk->lengths[0] = 1.0f;
}

// Goes on to the next light.
//
//   expected  out: how often walks take it, on average, <= 1
// Returns its index, or EMITTER_NONE at the end. No light comes twice.
static inline uint light_walk_next(float *expected, struct light_walk *walk,
                                   __global const struct light_bvh_node *nodes, const float3 p,
                                   const float3 normal)
{
    while (walk->count > 0) {
        const uint last = --walk->count;
        const uint word = walk->words[last];
        const float length = walk->lengths[last];
        if (LIGHT_BVH_FLAT || (word & LIGHT_BVH_LEAF)) {
            *expected = min2(length, 1.0f);
            return word & ~LIGHT_BVH_LEAF;
        }
        float weights[8];
        uint words[8];
        const uint count = light_cut_add(weights, words, 0, &nodes[word], p, normal);
        const float sum = light_cut_sum(weights, count);
        light_walk_divide(walk, weights, words, count, sum, length, walk->numbers[last]);
    }
    return EMITTER_NONE;
}

// This light's share of all draws of a walk at p: walks up from its leaf to the cut.
static inline float light_bvh_share(__global const struct light_bvh_node *nodes,
                                    __global const uint *parents, __global const uint *leaves,
                                    const float3 p, const float3 normal, const uint light)
{
    float cut_weights[LIGHT_CUT_MOST];
    uint cut_words[LIGHT_CUT_MOST];
    float cut_sum;
    const uint cut_count = light_cut(&cut_sum, cut_weights, cut_words, nodes, p, normal);
    float share = 1.0f;
    uint word = LIGHT_BVH_LEAF | light;
    for (uint place = leaves[light]; place != LIGHT_BVH_ROOT; place = parents[place >> 3]) {
        for (uint i = 0; i < cut_count; i++)
            if (cut_words[i] == word)
                return share * cut_weights[i] / cut_sum;
        if (LIGHT_BVH_FLAT)
            break;
        word = place >> 3;
        float weights[8];
        uint words[8];
        const uint count = light_cut_add(weights, words, 0, &nodes[word], p, normal);
        const float sum = light_cut_sum(weights, count);
        float weight = 0.0f;
        const uint child = ((__global const uint *)&nodes[word])[11 * 8 + (place & 7u)];
        for (uint i = 0; i < count; i++)
            weight = words[i] == child ? weights[i] : weight;
        if (!(weight > 0.0f))
            return 0.0f;
        share *= weight / sum;
    }
    return 0.0f;
}

#endif
