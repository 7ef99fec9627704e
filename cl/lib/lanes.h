/**
 * @file
 * Eight paths side by side, one in each lane of a CPU's vectors: what PoCL does not make of eight
 * work items by itself. Vectors of three or four are structs of float8; a mask is an int8, all bits
 * or none in each lane.
 *
 * What is computed in a lane depends on that lane alone, so results do not depend on who is whose
 * neighbour.
 */
#ifndef LIB_LANES_H
#define LIB_LANES_H

#include "lib/eight.h"
#include "lib/math.h"
#include "lib/samples.h"
#include "shared/path.h"

#define LANES PATH_LANES

struct lanes3 {
    float8 x, y, z;
};

struct lanes4 {
    float8 x, y, z, w;
};

// ---- Rows of eight slots, and back

// Turns eight rows of four numbers into four of eight.
static inline struct lanes4 lanes_turn(const float4 r0, const float4 r1, const float4 r2,
                                       const float4 r3, const float4 r4, const float4 r5,
                                       const float4 r6, const float4 r7)
{
    const float8 a = lanes_whole((float8)(r0, r4));
    const float8 b = lanes_whole((float8)(r1, r5));
    const float8 c = lanes_whole((float8)(r2, r6));
    const float8 d = lanes_whole((float8)(r3, r7));
    const float8 ab_lo = (float8)(a.s0, b.s0, a.s1, b.s1, a.s4, b.s4, a.s5, b.s5);
    const float8 ab_hi = (float8)(a.s2, b.s2, a.s3, b.s3, a.s6, b.s6, a.s7, b.s7);
    const float8 cd_lo = (float8)(c.s0, d.s0, c.s1, d.s1, c.s4, d.s4, c.s5, d.s5);
    const float8 cd_hi = (float8)(c.s2, d.s2, c.s3, d.s3, c.s6, d.s6, c.s7, d.s7);
    struct lanes4 out;
    out.x = (float8)(ab_lo.s01, cd_lo.s01, ab_lo.s45, cd_lo.s45);
    out.y = (float8)(ab_lo.s23, cd_lo.s23, ab_lo.s67, cd_lo.s67);
    out.z = (float8)(ab_hi.s01, cd_hi.s01, ab_hi.s45, cd_hi.s45);
    out.w = (float8)(ab_hi.s23, cd_hi.s23, ab_hi.s67, cd_hi.s67);
    return out;
}

// Eight rows, as lanes_turn() takes them: lanes 0 and 4 in the first, and so on.
struct lanes_rows {
    float8 r04, r15, r26, r37;
};

static inline struct lanes_rows lanes_turn_back(const struct lanes4 v)
{
    const float8 xy_lo = (float8)(v.x.s0, v.y.s0, v.x.s1, v.y.s1, v.x.s4, v.y.s4, v.x.s5, v.y.s5);
    const float8 xy_hi = (float8)(v.x.s2, v.y.s2, v.x.s3, v.y.s3, v.x.s6, v.y.s6, v.x.s7, v.y.s7);
    const float8 zw_lo = (float8)(v.z.s0, v.w.s0, v.z.s1, v.w.s1, v.z.s4, v.w.s4, v.z.s5, v.w.s5);
    const float8 zw_hi = (float8)(v.z.s2, v.w.s2, v.z.s3, v.w.s3, v.z.s6, v.w.s6, v.z.s7, v.w.s7);
    struct lanes_rows out;
    out.r04 = (float8)(xy_lo.s01, zw_lo.s01, xy_lo.s45, zw_lo.s45);
    out.r15 = (float8)(xy_lo.s23, zw_lo.s23, xy_lo.s67, zw_lo.s67);
    out.r26 = (float8)(xy_hi.s01, zw_hi.s01, xy_hi.s45, zw_hi.s45);
    out.r37 = (float8)(xy_hi.s23, zw_hi.s23, xy_hi.s67, zw_hi.s67);
    return out;
}

// The mask of bits.
static inline int8 lanes_mask(const uint bits)
{
    return ((int8)(int)bits & (int8)(1, 2, 4, 8, 16, 32, 64, 128)) != 0;
}

// Puts a number into one lane. What is stored number by number and loaded as eight waits until all
// stores before it are done, and those of paths miss the cache: of raygen it was three quarters.
static inline float8 lanes_put(const float8 lanes, const uint lane, const float number)
{
    const int8 here = (int8)(0, 1, 2, 3, 4, 5, 6, 7) == (int8)(int)lane;
    return here ? (float8)(number) : lanes;
}

static inline uint8 lanes_put_word(const uint8 lanes, const uint lane, const uint word)
{
    return as_uint8(lanes_put(as_float8(lanes), lane, as_float(word)));
}

// Eight rows that are all the same.
static inline struct lanes4 lanes_same(const float4 row)
{
    const struct lanes4 out = {row.x, row.y, row.z, row.w};
    return out;
}

// LANES_OF(array, index, .member): a row of each lane's element, index[LANES] being its number.
#define LANES_OF(array, index, member)                                                             \
    lanes_turn(array[(index)[0]] member, array[(index)[1]] member, array[(index)[2]] member,       \
               array[(index)[3]] member, array[(index)[4]] member, array[(index)[5]] member,       \
               array[(index)[6]] member, array[(index)[7]] member)

// The same of one number; type is float8 or uint8.
#define LANES_WORD(type, array, index, member)                                                     \
    (type)(array[(index)[0]] member, array[(index)[1]] member, array[(index)[2]] member,           \
           array[(index)[3]] member, array[(index)[4]] member, array[(index)[5]] member,           \
           array[(index)[6]] member, array[(index)[7]] member)

// LANES_STORE(array, index, .member, bits, lanes4): writes the rows of those lanes that have a bit.
#define LANES_STORE(array, index, member, bits, value)                                             \
    do {                                                                                           \
        const struct lanes_rows lanes_rows_ = lanes_turn_back(value);                              \
        const uint lanes_bits_ = bits;                                                             \
        if (lanes_bits_ == 0xffu) { /* as most times */                                            \
            array[(index)[0]] member = lanes_rows_.r04.lo;                                         \
            array[(index)[1]] member = lanes_rows_.r15.lo;                                         \
            array[(index)[2]] member = lanes_rows_.r26.lo;                                         \
            array[(index)[3]] member = lanes_rows_.r37.lo;                                         \
            array[(index)[4]] member = lanes_rows_.r04.hi;                                         \
            array[(index)[5]] member = lanes_rows_.r15.hi;                                         \
            array[(index)[6]] member = lanes_rows_.r26.hi;                                         \
            array[(index)[7]] member = lanes_rows_.r37.hi;                                         \
            break;                                                                                 \
        }                                                                                          \
        if (lanes_bits_ & 1u)                                                                      \
            array[(index)[0]] member = lanes_rows_.r04.lo;                                         \
        if (lanes_bits_ & 2u)                                                                      \
            array[(index)[1]] member = lanes_rows_.r15.lo;                                         \
        if (lanes_bits_ & 4u)                                                                      \
            array[(index)[2]] member = lanes_rows_.r26.lo;                                         \
        if (lanes_bits_ & 8u)                                                                      \
            array[(index)[3]] member = lanes_rows_.r37.lo;                                         \
        if (lanes_bits_ & 16u)                                                                     \
            array[(index)[4]] member = lanes_rows_.r04.hi;                                         \
        if (lanes_bits_ & 32u)                                                                     \
            array[(index)[5]] member = lanes_rows_.r15.hi;                                         \
        if (lanes_bits_ & 64u)                                                                     \
            array[(index)[6]] member = lanes_rows_.r26.hi;                                         \
        if (lanes_bits_ & 128u)                                                                    \
            array[(index)[7]] member = lanes_rows_.r37.hi;                                         \
    } while (false)

// ---- Vectors

static inline struct lanes3 lanes3_make(const float8 x, const float8 y, const float8 z)
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

static inline struct lanes4 lanes4_make(const struct lanes3 v, const float8 w)
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

static inline struct lanes3 lanes3_scale(const struct lanes3 a, const float8 s)
{
    return lanes3_make(a.x * s, a.y * s, a.z * s);
}

// a s + b
static inline struct lanes3 lanes3_muladd(const struct lanes3 a, const float8 s,
                                          const struct lanes3 b)
{
    return lanes3_make(MULADD(a.x, s, b.x), MULADD(a.y, s, b.y), MULADD(a.z, s, b.z));
}

static inline float8 lanes3_dot(const struct lanes3 a, const struct lanes3 b)
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
    return lanes3_scale(a, 1.0f / sqrt(lanes3_dot(a, a)));
}

// a where the mask is set, else b.
static inline struct lanes3 lanes3_select(const int8 mask, const struct lanes3 a,
                                          const struct lanes3 b)
{
    return lanes3_make(mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z);
}

static inline float8 lanes3_max(const struct lanes3 a)
{
    return max8(max8(a.x, a.y), a.z);
}

// The largest whole numbers that are not larger. PoCL's floor() is a function, and takes as long as
// ten products.
static inline float8 lanes_floor(const float8 x)
{
    const float8 cut = convert_float8(convert_int8(x));
    const float8 below = cut - (cut > x ? (float8)(1.0f) : (float8)(0.0f));
    return fabs(x) < 8388608.0f ? below : x; // from 2^23 on all are whole
}

// ---- Twins of what single paths use

// oct_unpack(), normalised.
static inline struct lanes3 lanes_oct_unpack(const uint8 packed)
{
    const float8 x = convert_float8(as_int8(packed << 16) >> 16) * (1.0f / 32767.0f);
    const float8 y = convert_float8(as_int8(packed) >> 16) * (1.0f / 32767.0f);
    const float8 z = 1.0f - fabs(x) - fabs(y);
    const float8 folded_x = copysign(1.0f - fabs(y), x);
    const float8 folded_y = copysign(1.0f - fabs(x), y);
    const int8 below = z < 0.0f;
    return lanes3_normalize(lanes3_make(below ? folded_x : x, below ? folded_y : y, z));
}

// oct_pack()
static inline uint8 lanes_oct_pack(const struct lanes3 n)
{
    const float8 scale = 1.0f / (fabs(n.x) + fabs(n.y) + fabs(n.z));
    const float8 u = n.x * scale;
    const float8 v = n.y * scale;
    const int8 below = n.z < 0.0f;
    const float8 x = (below ? copysign(1.0f - fabs(v), u) : u) * 32767.0f;
    const float8 y = (below ? copysign(1.0f - fabs(u), v) : v) * 32767.0f;
    const uint8 low = as_uint8(convert_int8(x + copysign((float8)(0.5f), x))) & 0xffffu;
    return low | as_uint8(convert_int8(y + copysign((float8)(0.5f), y))) << 16;
}

// cos_sin_turn()
static inline void lanes_cos_sin_turn(float8 *cosine, float8 *sine, const float8 u)
{
    const int8 quarter = convert_int8(4.0f * u + 0.5f);
    const float8 a = (4.0f * u - convert_float8(quarter)) * (0.5f * PI);
    const float8 a2 = a * a;
    const float8 s =
        a * (1.0f + a2 * (-1.0f / 6.0f + a2 * (1.0f / 120.0f - a2 * (1.0f / 5040.0f))));
    const float8 c =
        1.0f + a2 * (-0.5f + a2 * (1.0f / 24.0f + a2 * (-1.0f / 720.0f + a2 * (1.0f / 40320.0f))));
    const int8 is_odd = (quarter & 1) != 0;
    const float8 x = is_odd ? s : c;
    const float8 y = is_odd ? c : s;
    *cosine = as_float8(as_int8(x) ^ (((quarter + 1) & 2) << 30));
    *sine = as_float8(as_int8(y) ^ ((quarter & 2) << 30));
}

// sample_cosine()
static inline struct lanes3 lanes_sample_cosine(const struct lanes3 n, const float8 u0,
                                                const float8 u1)
{
    const float8 r = sqrt(u0);
    float8 cosine, sine;
    lanes_cos_sin_turn(&cosine, &sine, u1);
    const float8 x = r * cosine;
    const float8 y = r * sine;
    const float8 z = sqrt(1.0f - u0);

    // The frame of frame_build().
    const float8 sign = copysign((float8)(1.0f), n.z);
    const float8 a = -1.0f / (sign + n.z);
    const float8 b = n.x * n.y * a;
    const struct lanes3 tangent = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    const struct lanes3 bitangent = {b, sign + n.y * n.y * a, -n.y};
    return lanes3_normalize(
        lanes3_muladd(tangent, x, lanes3_muladd(bitangent, y, lanes3_scale(n, z))));
}

// mis_weight()
static inline float8 lanes_mis_weight(const float8 mine, const float8 other)
{
    const float8 ratio = other / mine;
    return 1.0f / (1.0f + ratio * ratio);
}

// Four shares of one, of 65535ths: bsdf_unpack_shares().
static inline struct lanes4 lanes_unpack_shares(const uint8 xy, const uint8 zw)
{
    const float step = 1.0f / 65535.0f;
    const struct lanes4 out = {
        convert_float8(as_int8(xy & 0xffffu)) * step, convert_float8(as_int8(xy >> 16)) * step,
        convert_float8(as_int8(zw & 0xffffu)) * step, convert_float8(as_int8(zw >> 16)) * step};
    return out;
}

// Two shares of one to 65535ths: bsdf_pack_shares().
static inline float8 lanes_pack_shares(const float8 low, const float8 high)
{
    const float8 zero = (float8)(0.0f);
    const float8 one = (float8)(1.0f);
    const float8 x = min8(max8(low, zero), one) * 65535.0f + 0.5f;
    const float8 y = min8(max8(high, zero), one) * 65535.0f + 0.5f;
    return as_float8(convert_int8(x) | convert_int8(y) << 16);
}

// ---- Numbers

struct lanes_place {
    uint8 pixel, sample;
};

struct lanes_numbers {
    uint8 x, y, z, w;
};

// rng_unit()
static inline float8 lanes_unit(const uint8 bits)
{
    return convert_float8(as_int8(bits >> 8)) * RNG_UNIT_STEP;
}

// samples_place()
static inline struct lanes_place lanes_place(const struct batch batch,
                                             __global const uint *restrict places, const uint8 slot)
{
    const uint pass_size = batch.pixel_count << batch.sample_shift;
    const uint8 in_batch = batch.first + slot;
    uint8 pass = (uint8)(0u);
    if (lanes_bits(in_batch >= pass_size) != 0)
        pass = in_batch / pass_size;
    const uint8 in_pass = in_batch - pass * pass_size;
    uint pixel[LANES];
    vstore8(batch.first_pixel + (in_pass >> batch.sample_shift), 0, pixel);
    struct lanes_place out;
    out.pixel = LANES_WORD(uint8, places, pixel, );
    out.sample = batch.first_sample + (pass << batch.sample_shift) +
                 (in_pass & ((1u << batch.sample_shift) - 1u));
    return out;
}

// samples_draw()
static inline struct lanes_numbers lanes_draw(__constant struct settings *settings,
                                              __global const uint4 *restrict points,
                                              const uint8 pixel, const uint8 number,
                                              const uint bounce, const uint use, const uint8 index)
{
    const uint shift = settings->point_shift;
    struct lanes_numbers turn;
    turn.x = pixel;
    turn.y = number >> shift;
    turn.z = rng_dimension(bounce, use, 0) | (index & RNG_INDEX_MASK);
    turn.w = (uint8)(settings->seed);
    RNG_SCRAMBLE(turn);

    uint place[LANES];
    vstore8((rng_block(bounce, use) << shift) + (number & ((1u << shift) - 1u)), 0, place);
    __global const float4 *rows = (__global const float4 *)points;
    const struct lanes4 point = LANES_OF(rows, place, );
    turn.x ^= as_uint8(point.x);
    turn.y ^= as_uint8(point.y);
    turn.z ^= as_uint8(point.z);
    turn.w ^= as_uint8(point.w);
    return turn;
}

#endif
