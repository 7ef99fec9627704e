/**
 * @file
 * Looking up the environment, and drawing directions towards it (shared/environment.h).
 */
#ifndef LIB_ENVIRONMENT_H
#define LIB_ENVIRONMENT_H

#include "lib/math.h"
#include "shared/environment.h"
#include "shared/rng.h"

// One direction towards the environment.
struct environment_sample {
    float3 dir;      // unit
    float3 radiance; // rgb from there, cd/m2
    float density;   // 1/sr
};

// The place of a direction on the map: column 0 .. width, row 0 .. height.
static inline float2 environment_place(const struct environment_map map, const float3 dir)
{
    float u = 0.5f + atan2(dir.x, -dir.z) * (0.5f * INV_PI) + map.turn;
    u -= floor(u);
    const float v = atan2(sqrt(dir.x * dir.x + dir.z * dir.z), dir.y) * INV_PI;
    return (float2)(u * (float)map.width, v * (float)map.height);
}

// The density with which environment_draw() comes to the direction at a place, 1/sr.
static inline float environment_density(const struct environment_map map,
                                        __global const float4 *restrict texels, const float2 place)
{
    const uint column = min((uint)place.x, map.width - 1);
    const uint row = min((uint)place.y, map.height - 1);
    return texels[row * map.width + column].w;
}

// Radiance at a place: bilinear; columns go round, rows end at the poles.
static inline float3 environment_radiance(const struct environment_map map,
                                          __global const float4 *restrict texels,
                                          const float2 place)
{
    const int width = (int)map.width;
    const int last = (int)map.height - 1;
    const float2 corner = floor(place - 0.5f);
    const float2 blend = place - 0.5f - corner;
    const int left = (int)corner.x;
    const int column0 = left < 0 ? width - 1 : min(left, width - 1);
    const int column1 = left + 1 >= width ? 0 : left + 1;
    const int row0 = clamp((int)corner.y, 0, last) * width;
    const int row1 = clamp((int)corner.y + 1, 0, last) * width;
    return mix(mix(texels[row0 + column0].xyz, texels[row0 + column1].xyz, blend.x),
               mix(texels[row1 + column0].xyz, texels[row1 + column1].xyz, blend.x), blend.y);
}

// Draws a direction.
//
//   bits  128 random bits
static inline struct environment_sample environment_draw(
    const struct environment_map map, __global const float4 *restrict texels,
    __global const struct environment_alias *restrict alias, const uint4 bits)
{
    // Pick a texel: all 32 bits, since large maps have more texels than 24 bits tell apart.
    uint texel = mul_hi(bits.x, map.width * map.height);
    if (rng_unit(bits.w) >= alias[texel].keep)
        texel = alias[texel].other;

    // Pick a place in it, even over its solid angle.
    const float column = (float)(texel % map.width) + rng_unit(bits.y);
    const uint row = texel / map.width;
    const float step = PI / (float)map.height;
    const float y = mix(cos((float)row * step), cos((float)(row + 1) * step), rng_unit(bits.z));
    const float level = sqrt(max2(1.0f - y * y, 0.0f));
    float turn = column / (float)map.width + 0.5f - map.turn;
    turn -= floor(turn);
    const float2 around = cos_sin_turn(turn);

    struct environment_sample out;
    out.dir = (float3)(level * around.y, y, -level * around.x);
    const float2 place = (float2)(column, acos(y) * INV_PI * (float)map.height);
    out.radiance = environment_radiance(map, texels, place);
    out.density = texels[texel].w;
    return out;
}

#endif
