/**
 * @file
 * Numbers of paths side by side, one in each of LANES lanes, 8 or 16: their types, and rows of
 * slots turned into them and back.
 */
#ifndef LIB_LANES_ROWS_H
#define LIB_LANES_ROWS_H

#include "lib/eight.h"

#ifndef LANES
#define LANES 8 // or 16
#endif

#define LANES_ALL ((1u << LANES) - 1u) // bits of all

// LANES_NAME(float) is float8 or float16, and what begins with that.
#if LANES == 16
#define LANES_NAME(name) name##16
#else
#define LANES_NAME(name) name##8
#endif

typedef LANES_NAME(float) lanes_float;
typedef LANES_NAME(int) lanes_int;
typedef LANES_NAME(uint) lanes_uint;

#define lanes_to_float(x) LANES_NAME(convert_float)(x)
#define lanes_to_int(x)   LANES_NAME(convert_int)(x)
#define lanes_as_float(x) LANES_NAME(as_float)(x)
#define lanes_as_int(x)   LANES_NAME(as_int)(x)
#define lanes_as_uint(x)  LANES_NAME(as_uint)(x)
#define lanes_min(a, b)   LANES_NAME(min)(a, b)
#define lanes_max(a, b)   LANES_NAME(max)(a, b)
#define lanes_rsqrt(x)    LANES_NAME(rsqrt)(x)
#define lanes_bits(mask)  LANES_NAME(bits)(mask)

#define lanes_load(from)         LANES_NAME(vload)(0, from)
#define lanes_store(lanes, into) LANES_NAME(vstore)(lanes, 0, into)

#if LANES == 16
#define LANES_ORDER ((lanes_int)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#else
#define LANES_ORDER ((lanes_int)(0, 1, 2, 3, 4, 5, 6, 7))
#endif

struct lanes3 {
    lanes_float x, y, z;
};

struct lanes4 {
    lanes_float x, y, z, w;
};

// Every fourth of the lanes' rows of four numbers: in the first those of lanes 0, 4 and so on.
struct lanes_rows {
    lanes_float r0, r1, r2, r3;
};

// Of each four lanes the first two or the last two, of l and r in turns: as numbers, or as pairs.
static inline lanes_float lanes_first_numbers(const lanes_float l, const lanes_float r)
{
#if LANES == 16
    return (lanes_float)(l.s0, r.s0, l.s1, r.s1, l.s4, r.s4, l.s5, r.s5, l.s8, r.s8, l.s9, r.s9,
                         l.sc, r.sc, l.sd, r.sd);
#else
    return (lanes_float)(l.s0, r.s0, l.s1, r.s1, l.s4, r.s4, l.s5, r.s5);
#endif
}

static inline lanes_float lanes_last_numbers(const lanes_float l, const lanes_float r)
{
#if LANES == 16
    return (lanes_float)(l.s2, r.s2, l.s3, r.s3, l.s6, r.s6, l.s7, r.s7, l.sa, r.sa, l.sb, r.sb,
                         l.se, r.se, l.sf, r.sf);
#else
    return (lanes_float)(l.s2, r.s2, l.s3, r.s3, l.s6, r.s6, l.s7, r.s7);
#endif
}

static inline lanes_float lanes_first_pairs(const lanes_float l, const lanes_float r)
{
#if LANES == 16
    return (lanes_float)(l.s0, l.s1, r.s0, r.s1, l.s4, l.s5, r.s4, r.s5, l.s8, l.s9, r.s8, r.s9,
                         l.sc, l.sd, r.sc, r.sd);
#else
    return (lanes_float)(l.s0, l.s1, r.s0, r.s1, l.s4, l.s5, r.s4, r.s5);
#endif
}

static inline lanes_float lanes_last_pairs(const lanes_float l, const lanes_float r)
{
#if LANES == 16
    return (lanes_float)(l.s2, l.s3, r.s2, r.s3, l.s6, l.s7, r.s6, r.s7, l.sa, l.sb, r.sa, r.sb,
                         l.se, l.sf, r.se, r.sf);
#else
    return (lanes_float)(l.s2, l.s3, r.s2, r.s3, l.s6, l.s7, r.s6, r.s7);
#endif
}

static inline struct lanes4 lanes_turn(const struct lanes_rows r)
{
    const lanes_float first_01 = lanes_first_numbers(r.r0, r.r1);
    const lanes_float last_01 = lanes_last_numbers(r.r0, r.r1);
    const lanes_float first_23 = lanes_first_numbers(r.r2, r.r3);
    const lanes_float last_23 = lanes_last_numbers(r.r2, r.r3);
    struct lanes4 out;
    out.x = lanes_first_pairs(first_01, first_23);
    out.y = lanes_last_pairs(first_01, first_23);
    out.z = lanes_first_pairs(last_01, last_23);
    out.w = lanes_last_pairs(last_01, last_23);
    return out;
}

static inline struct lanes_rows lanes_turn_back(const struct lanes4 v)
{
    const lanes_float first_xy = lanes_first_numbers(v.x, v.y);
    const lanes_float last_xy = lanes_last_numbers(v.x, v.y);
    const lanes_float first_zw = lanes_first_numbers(v.z, v.w);
    const lanes_float last_zw = lanes_last_numbers(v.z, v.w);
    struct lanes_rows out;
    out.r0 = lanes_first_pairs(first_xy, first_zw);
    out.r1 = lanes_last_pairs(first_xy, first_zw);
    out.r2 = lanes_first_pairs(last_xy, last_zw);
    out.r3 = lanes_last_pairs(last_xy, last_zw);
    return out;
}

// The mask of bits.
static inline lanes_int lanes_mask(const uint bits)
{
    return ((lanes_int)(int)bits & ((lanes_int)(1) << LANES_ORDER)) != 0;
}

// Puts a number into one lane. What is stored number by number and loaded as one waits until all
// stores before it are done, and those of paths miss the cache: of raygen it was three quarters.
static inline lanes_float lanes_put(const lanes_float lanes, const uint lane, const float number)
{
    const lanes_int here = LANES_ORDER == (lanes_int)(int)lane;
    return here ? (lanes_float)(number) : lanes;
}

static inline lanes_uint lanes_put_word(const lanes_uint lanes, const uint lane, const uint word)
{
    return lanes_as_uint(lanes_put(lanes_as_float(lanes), lane, as_float(word)));
}

// Rows that are all the same.
static inline struct lanes4 lanes_same(const float4 row)
{
    const struct lanes4 out = {row.x, row.y, row.z, row.w};
    return out;
}

// The same numbers: nothing is made of them before. LLVM works out where rows are even for the
// branch that is not taken.
static inline lanes_uint lanes_from_here(const lanes_uint lanes)
{
    return lanes_as_uint(LANES_NAME(whole)(lanes_as_float(lanes)));
}

// LANES_OF(array, index, .member): a row of each lane's element, index[LANES] being its number.
#define LANES_AT(array, index, member, lane) array[(index)[lane]] member
#if LANES == 16
#define LANES_ROWS(array, index, member, lane)                                                     \
    whole16((lanes_float)(LANES_AT(array, index, member, lane),                                    \
                          LANES_AT(array, index, member, lane + 4),                                \
                          LANES_AT(array, index, member, lane + 8),                                \
                          LANES_AT(array, index, member, lane + 12)))
#else
#define LANES_ROWS(array, index, member, lane)                                                     \
    whole8((lanes_float)(LANES_AT(array, index, member, lane),                                     \
                         LANES_AT(array, index, member, lane + 4)))
#endif
#define LANES_OF(array, index, member)                                                             \
    lanes_turn((struct lanes_rows){                                                                \
        LANES_ROWS(array, index, member, 0), LANES_ROWS(array, index, member, 1),                  \
        LANES_ROWS(array, index, member, 2), LANES_ROWS(array, index, member, 3)})

// The same of one number; type is lanes_float or lanes_uint.
#define LANES_FOUR(array, index, member, lane)                                                     \
    LANES_AT(array, index, member, lane), LANES_AT(array, index, member, lane + 1),                \
        LANES_AT(array, index, member, lane + 2), LANES_AT(array, index, member, lane + 3)
#if LANES == 16
#define LANES_WORD(type, array, index, member)                                                     \
    (type)(LANES_FOUR(array, index, member, 0), LANES_FOUR(array, index, member, 4),               \
           LANES_FOUR(array, index, member, 8), LANES_FOUR(array, index, member, 12))
#else
#define LANES_WORD(type, array, index, member)                                                     \
    (type)(LANES_FOUR(array, index, member, 0), LANES_FOUR(array, index, member, 4))
#endif

// What f() gives of each lane's number.
#define LANES_EACH_FOUR(f, numbers, lane)                                                          \
    f((numbers)[lane]), f((numbers)[lane + 1]), f((numbers)[lane + 2]), f((numbers)[lane + 3])
#if LANES == 16
#define LANES_EACH(type, f, numbers)                                                               \
    (type)(LANES_EACH_FOUR(f, numbers, 0), LANES_EACH_FOUR(f, numbers, 4),                         \
           LANES_EACH_FOUR(f, numbers, 8), LANES_EACH_FOUR(f, numbers, 12))
#else
#define LANES_EACH(type, f, numbers)                                                               \
    (type)(LANES_EACH_FOUR(f, numbers, 0), LANES_EACH_FOUR(f, numbers, 4))
#endif

// LANES_STORE(array, index, .member, bits, lanes4): writes the rows of those lanes that have a bit.
#define LANES_PUT(array, index, member, bits, lane, row)                                           \
    if ((bits) & (1u << (lane)))                                                                   \
    LANES_AT(array, index, member, lane) = row
#define LANES_PUT_FOUR(array, index, member, bits, lane, rows, part)                               \
    LANES_PUT(array, index, member, bits, lane, (rows).r0.part);                                   \
    LANES_PUT(array, index, member, bits, lane + 1, (rows).r1.part);                               \
    LANES_PUT(array, index, member, bits, lane + 2, (rows).r2.part);                               \
    LANES_PUT(array, index, member, bits, lane + 3, (rows).r3.part)
#if LANES == 16
#define LANES_PUT_ALL(array, index, member, bits, rows)                                            \
    LANES_PUT_FOUR(array, index, member, bits, 0, rows, s0123);                                    \
    LANES_PUT_FOUR(array, index, member, bits, 4, rows, s4567);                                    \
    LANES_PUT_FOUR(array, index, member, bits, 8, rows, s89ab);                                    \
    LANES_PUT_FOUR(array, index, member, bits, 12, rows, scdef)
#else
#define LANES_PUT_ALL(array, index, member, bits, rows)                                            \
    LANES_PUT_FOUR(array, index, member, bits, 0, rows, s0123);                                    \
    LANES_PUT_FOUR(array, index, member, bits, 4, rows, s4567)
#endif
#define LANES_STORE(array, index, member, bits, value)                                             \
    do {                                                                                           \
        const struct lanes_rows lanes_rows_ = lanes_turn_back(value);                              \
        const uint lanes_bits_ = bits;                                                             \
        if (lanes_bits_ == LANES_ALL) { /* as most times */                                        \
            LANES_PUT_ALL(array, index, member, LANES_ALL, lanes_rows_);                           \
            break;                                                                                 \
        }                                                                                          \
        LANES_PUT_ALL(array, index, member, lanes_bits_, lanes_rows_);                             \
    } while (false)

#endif
