// lib/lanes.h beside what single paths do.

#include "lib/bsdf.h"
#include "lib/lanes.h"
#include "lib/samples.h"
#include "test.h"

// What the two sides make of one case.
struct lanes_case {
    float4 numbers; // bits of those of the slot's path
    float4 normal;  // unpacked from the word
    float4 dir;     // about the case's unit vector
    float4 shares;  // packed and unpacked
    float4 weights; // cosine, sine, weight
    float4 place;   // bits of pixel, sample; the case's unit vector packed
};

// in: a unit vector, a word, and four numbers 0 .. 1 a case; the slot is the case's number.
TEST_KERNEL lanes_single(__constant struct settings *settings, const struct batch batch,
                         __global const uint4 *points, __global const uint *places,
                         __global const float4 *vectors, __global const uint *words,
                         __global const float4 *units, const uint count,
                         __global struct lanes_case *out)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const struct path_place place = samples_place(batch, places, i);
    const float2 turn = cos_sin_turn(units[i].y);
    struct lanes_case c;
    c.numbers =
        as_float4(samples_draw(settings, points, place.pixel, place.sample, 1, RNG_USE_LIGHT, 3));
    c.normal = (float4)(normalize(oct_unpack(words[i]).xyz), 0.0f);
    c.dir = (float4)(sample_cosine(vectors[i].xyz, units[i].x, units[i].y), 0.0f);
    c.shares = bsdf_unpack_shares(bsdf_pack_shares(units[i]));
    c.weights = (float4)(turn, mis_weight(units[i].z, units[i].w), 0.0f);
    c.place = as_float4(
        (uint4)(place.pixel, place.sample, oct_pack(vectors[i].x, vectors[i].y, vectors[i].z), 0));
    out[i] = c;
}

// The same, LANES cases an item; count is a multiple.
TEST_KERNEL lanes_together(__constant struct settings *settings, const struct batch batch,
                           __global const uint4 *points, __global const uint *places,
                           __global const float4 *vectors, __global const uint *words,
                           __global const float4 *units, const uint count,
                           __global struct lanes_case *out)
{
    const uint first = get_global_id(0) * LANES;
    if (first >= count)
        return;
    uint slots[LANES];
    lanes_store(first + lanes_as_uint(LANES_ORDER), slots);
    const struct lanes_place place = lanes_place(batch, places, lanes_load(slots), 1);
    const struct lanes4 vector = LANES_OF(vectors, slots, );
    const struct lanes4 unit = LANES_OF(units, slots, );
    const lanes_float zero = (lanes_float)(0.0f);
    lanes_float cosine, sine;
    lanes_cos_sin_turn(&cosine, &sine, unit.y);
    const struct lanes_numbers numbers =
        lanes_draw(settings, points, place, place.sample, RNG_USE_LIGHT, (lanes_uint)(3u));
    const struct lanes4 number_rows = {lanes_as_float(numbers.x), lanes_as_float(numbers.y),
                                       lanes_as_float(numbers.z), lanes_as_float(numbers.w)};
    const struct lanes4 words_row = {lanes_as_float(place.pixel), lanes_as_float(place.sample),
                                     lanes_as_float(lanes_oct_pack(lanes3_xyz(vector))), zero};
    const struct lanes4 weights = {cosine, sine, lanes_mis_weight(unit.z, unit.w), zero};
    const struct lanes4 shares =
        lanes_unpack_shares(lanes_as_uint(lanes_pack_shares(unit.x, unit.y)),
                            lanes_as_uint(lanes_pack_shares(unit.z, unit.w)));
    const lanes_uint word = LANES_WORD(lanes_uint, words, slots, );

    LANES_STORE(out, slots, .normal, LANES_ALL, lanes4_make(lanes_oct_unpack(word), zero));
    LANES_STORE(out, slots, .dir, LANES_ALL,
                lanes4_make(lanes_sample_cosine(lanes3_xyz(vector), unit.x, unit.y), zero));
    LANES_STORE(out, slots, .shares, LANES_ALL, shares);
    LANES_STORE(out, slots, .weights, LANES_ALL, weights);
    LANES_STORE(out, slots, .numbers, LANES_ALL, number_rows);
    LANES_STORE(out, slots, .place, LANES_ALL, words_row);
}
