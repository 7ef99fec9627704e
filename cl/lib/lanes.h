/**
 * @file
 * Paths side by side, one in each lane of a CPU's vectors: what PoCL does not make of work items by
 * itself. Vectors of three or four are structs of lanes_float; a mask is a lanes_int, all bits or
 * none in each lane.
 *
 * What is computed in a lane depends on that lane alone, so results do not depend on who is whose
 * neighbour, nor on how many there are.
 */
#ifndef LIB_LANES_H
#define LIB_LANES_H

#include "lib/lanes_rows.h"
#include "lib/math.h"
#include "lib/samples.h"
#include "shared/path.h"

// ---- Vectors

static inline struct lanes3 lanes3_make(const lanes_float x, const lanes_float y,
                                        const lanes_float z)
{
    const struct lanes3 out = {x, y, z};
    return out;
}

static inline struct lanes3 lanes3_xyz(const struct lanes4 v)
{
    return lanes3_make(v.x, v.y, v.z);
}

// Puts a vector into one lane: lanes_put().
static inline struct lanes3 lanes3_put(const struct lanes3 lanes, const uint lane, const float3 v)
{
    return lanes3_make(lanes_put(lanes.x, lane, v.x), lanes_put(lanes.y, lane, v.y),
                       lanes_put(lanes.z, lane, v.z));
}

static inline struct lanes4 lanes4_make(const struct lanes3 v, const lanes_float w)
{
    const struct lanes4 out = {v.x, v.y, v.z, w};
    return out;
}

static inline struct lanes3 lanes3_add(const struct lanes3 a, const struct lanes3 b)
{
    return lanes3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct lanes3 lanes3_sub(const struct lanes3 a, const struct lanes3 b)
{
    return lanes3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline struct lanes3 lanes3_mul(const struct lanes3 a, const struct lanes3 b)
{
    return lanes3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline struct lanes3 lanes3_scale(const struct lanes3 a, const lanes_float s)
{
    return lanes3_make(a.x * s, a.y * s, a.z * s);
}

// a s + b
static inline struct lanes3 lanes3_muladd(const struct lanes3 a, const lanes_float s,
                                          const struct lanes3 b)
{
    return lanes3_make(MULADD(a.x, s, b.x), MULADD(a.y, s, b.y), MULADD(a.z, s, b.z));
}

static inline lanes_float lanes3_dot(const struct lanes3 a, const struct lanes3 b)
{
    return MULADD(a.x, b.x, MULADD(a.y, b.y, a.z * b.z));
}

static inline struct lanes3 lanes3_cross(const struct lanes3 a, const struct lanes3 b)
{
    return lanes3_make(MULADD(a.y, b.z, -a.z * b.y), MULADD(a.z, b.x, -a.x * b.z),
                       MULADD(a.x, b.y, -a.y * b.x));
}

static inline struct lanes3 lanes3_normalize(const struct lanes3 a)
{
    return lanes3_scale(a, lanes_rsqrt(lanes3_dot(a, a)));
}

// a where the mask is set, else b.
static inline struct lanes3 lanes3_select(const lanes_int mask, const struct lanes3 a,
                                          const struct lanes3 b)
{
    return lanes3_make(mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z);
}

static inline lanes_float lanes3_max(const struct lanes3 a)
{
    return lanes_max(lanes_max(a.x, a.y), a.z);
}

// The largest whole numbers that are not larger. PoCL's floor() is a function, and takes as long as
// ten products.
static inline lanes_float lanes_floor(const lanes_float x)
{
    const lanes_float cut = lanes_to_float(lanes_to_int(x));
    const lanes_float below = cut - (cut > x ? (lanes_float)(1.0f) : (lanes_float)(0.0f));
    return fabs(x) < 8388608.0f ? below : x; // from 2^23 on all are whole
}

// ---- Twins of what single paths use

// luminance()
static inline lanes_float lanes_luminance(const struct lanes3 v)
{
    return MULADD(0.2126f, v.x, MULADD(0.7152f, v.y, 0.0722f * v.z));
}

// oct_unpack(), normalised.
static inline struct lanes3 lanes_oct_unpack(const lanes_uint packed)
{
    const lanes_float x = lanes_to_float(lanes_as_int(packed << 16) >> 16) * (1.0f / 32767.0f);
    const lanes_float y = lanes_to_float(lanes_as_int(packed) >> 16) * (1.0f / 32767.0f);
    const lanes_float z = 1.0f - fabs(x) - fabs(y);
    const lanes_float folded_x = copysign(1.0f - fabs(y), x);
    const lanes_float folded_y = copysign(1.0f - fabs(x), y);
    const lanes_int below = z < 0.0f;
    return lanes3_normalize(lanes3_make(below ? folded_x : x, below ? folded_y : y, z));
}

// oct_pack()
static inline lanes_uint lanes_oct_pack(const struct lanes3 n)
{
    const lanes_float scale = 1.0f / (fabs(n.x) + fabs(n.y) + fabs(n.z));
    const lanes_float u = n.x * scale;
    const lanes_float v = n.y * scale;
    const lanes_int below = n.z < 0.0f;
    const lanes_float x = (below ? copysign(1.0f - fabs(v), u) : u) * 32767.0f;
    const lanes_float y = (below ? copysign(1.0f - fabs(u), v) : v) * 32767.0f;
    const lanes_uint low =
        lanes_as_uint(lanes_to_int(x + copysign((lanes_float)(0.5f), x))) & 0xffffu;
    return low | lanes_as_uint(lanes_to_int(y + copysign((lanes_float)(0.5f), y))) << 16;
}

// cos_sin_turn()
static inline void lanes_cos_sin_turn(lanes_float *cosine, lanes_float *sine, const lanes_float u)
{
    const lanes_int quarter = lanes_to_int(4.0f * u + 0.5f);
    const lanes_float a = (4.0f * u - lanes_to_float(quarter)) * (0.5f * PI);
    const lanes_float a2 = a * a;
    const lanes_float s =
        a * (1.0f + a2 * (-1.0f / 6.0f + a2 * (1.0f / 120.0f - a2 * (1.0f / 5040.0f))));
    const lanes_float c =
        1.0f + a2 * (-0.5f + a2 * (1.0f / 24.0f + a2 * (-1.0f / 720.0f + a2 * (1.0f / 40320.0f))));
    const lanes_int is_odd = (quarter & 1) != 0;
    const lanes_float x = is_odd ? s : c;
    const lanes_float y = is_odd ? c : s;
    *cosine = lanes_as_float(lanes_as_int(x) ^ (((quarter + 1) & 2) << 30));
    *sine = lanes_as_float(lanes_as_int(y) ^ ((quarter & 2) << 30));
}

// frame_build()
static inline void lanes_frame(struct lanes3 *tangent, struct lanes3 *bitangent,
                               const struct lanes3 n)
{
    const lanes_float sign = copysign((lanes_float)(1.0f), n.z);
    const lanes_float a = -1.0f / (sign + n.z);
    const lanes_float b = n.x * n.y * a;
    *tangent = lanes3_make(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *bitangent = lanes3_make(b, sign + n.y * n.y * a, -n.y);
}

// sample_cosine()
static inline struct lanes3 lanes_sample_cosine(const struct lanes3 n, const lanes_float u0,
                                                const lanes_float u1)
{
    const lanes_float r = sqrt(u0);
    lanes_float cosine, sine;
    lanes_cos_sin_turn(&cosine, &sine, u1);
    const lanes_float x = r * cosine;
    const lanes_float y = r * sine;
    const lanes_float z = sqrt(1.0f - u0);
    struct lanes3 tangent, bitangent;
    lanes_frame(&tangent, &bitangent, n);
    return lanes3_muladd(tangent, x, lanes3_muladd(bitangent, y, lanes3_scale(n, z)));
}

// mis_weight()
static inline lanes_float lanes_mis_weight(const lanes_float mine, const lanes_float other)
{
    const lanes_float ratio = other / mine;
    return 1.0f / (1.0f + ratio * ratio);
}

// Four shares of one, of 65535ths: bsdf_unpack_shares().
static inline struct lanes4 lanes_unpack_shares(const lanes_uint xy, const lanes_uint zw)
{
    const float step = 1.0f / 65535.0f;
    const struct lanes4 out = {lanes_to_float(lanes_as_int(xy & 0xffffu)) * step,
                               lanes_to_float(lanes_as_int(xy >> 16)) * step,
                               lanes_to_float(lanes_as_int(zw & 0xffffu)) * step,
                               lanes_to_float(lanes_as_int(zw >> 16)) * step};
    return out;
}

// Two shares of one to 65535ths: bsdf_pack_shares().
static inline lanes_float lanes_pack_shares(const lanes_float low, const lanes_float high)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const lanes_float one = (lanes_float)(1.0f);
    const lanes_float x = lanes_min(lanes_max(low, zero), one) * 65535.0f + 0.5f;
    const lanes_float y = lanes_min(lanes_max(high, zero), one) * 65535.0f + 0.5f;
    return lanes_as_float(lanes_to_int(x) | lanes_to_int(y) << 16);
}

// ---- Numbers

// Whose paths, and at which bounce.
struct lanes_place {
    lanes_uint pixel, sample, bounce;
};

struct lanes_numbers {
    lanes_uint x, y, z, w;
};

// rng_unit()
static inline lanes_float lanes_unit(const lanes_uint bits)
{
    return lanes_to_float(lanes_as_int(bits >> 8)) * RNG_UNIT_STEP;
}

// samples_place(), all at one bounce.
static inline struct lanes_place lanes_place(const struct batch batch,
                                             __global const uint *restrict places,
                                             const lanes_uint slot, const uint bounce)
{
    const uint pass_size = batch.pixel_count << batch.sample_shift;
    const lanes_uint in_batch = batch.first + slot;
    lanes_uint pass = (lanes_uint)(0u);
    if (lanes_bits(in_batch >= pass_size) != 0)
        pass = in_batch / pass_size;
    const lanes_uint in_pass = in_batch - pass * pass_size;
    uint pixel[LANES];
    lanes_store(batch.first_pixel + (in_pass >> batch.sample_shift), pixel);
    struct lanes_place out;
    out.pixel = LANES_WORD(lanes_uint, places, pixel, );
    out.sample = batch.first_sample + (pass << batch.sample_shift) +
                 (in_pass & ((1u << batch.sample_shift) - 1u));
    out.bounce = (lanes_uint)(bounce);
    return out;
}

// samples_draw()
//
//   number  in the sequence, the places' samples but for several draws of one kind
INLINED struct lanes_numbers lanes_draw(__constant struct settings *settings,
                                        __global const uint4 *restrict points,
                                        const struct lanes_place place, const lanes_uint number,
                                        const uint use, const lanes_uint index)
{
    const uint shift = settings->point_shift;
    struct lanes_numbers turn;
    turn.x = place.pixel;
    turn.y = number >> shift;
    turn.z =
        (place.bounce << RNG_DEPTH_SHIFT) | rng_dimension(0, use, 0) | (index & RNG_INDEX_MASK);
    turn.w = (lanes_uint)(settings->seed);
    RNG_SCRAMBLE(turn);

    const uint first = rng_block(0, use); // from bounce to bounce they are equally far apart
    const lanes_uint block = first + place.bounce * (rng_block(1, use) - first);
    uint row[LANES];
    lanes_store((block << shift) + (number & ((1u << shift) - 1u)), row);
    __global const float4 *rows = (__global const float4 *)points;
    const struct lanes4 point = LANES_OF(rows, row, );
    turn.x ^= lanes_as_uint(point.x);
    turn.y ^= lanes_as_uint(point.y);
    turn.z ^= lanes_as_uint(point.z);
    turn.w ^= lanes_as_uint(point.w);
    return turn;
}

#endif
