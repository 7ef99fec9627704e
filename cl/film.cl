// Stage 9, film: adds the finished paths of a batch to the pixels.
//
//   in    paths
//   out   film[place in Z-order]
//   next  raygen of the next batch
//
// One item a pixel, its samples in order: the sum does not depend on how paths were cut into
// batches. Slots are counted from the first pixel's first sample in the pass, which may lie in the
// batch before.

#include "lib/math.h"
#include "shared/film.h"
#include "shared/path.h"

#ifndef WG_FILM
#define WG_FILM 64 // work items in a group
#endif

__kernel __attribute__((reqd_work_group_size(WG_FILM, 1, 1))) void film(
    const struct batch batch, __global const struct path *restrict paths,
    __global struct film_pixel *restrict film)
{
    const uint item = get_global_id(0);
    const uint run = 1u << batch.sample_shift; // slots of a pixel in one pass
    const uint cut = batch.first & (run - 1u); // of the first pixel, those in the batch before
    const uint pixels = (batch.count + cut + run - 1u) >> batch.sample_shift;
    if (item >= min(pixels, batch.pixel_count))
        return; // the launch is rounded up to whole groups
    const uint place = ((batch.first >> batch.sample_shift) + item) % batch.pixel_count;

    float4 sum = film[place].sum;
    float4 carry = film[place].carry;
    for (uint begin = item * run; begin < batch.count + cut; begin += batch.pixel_count * run) {
        const uint end = min(begin + run, batch.count + cut);
        for (uint i = max(begin, cut); i < end; i++) {
            const float3 radiance = paths[i - cut].radiance_normal.xyz;
            const float light = luminance(radiance);
            const float4 value = (float4)(radiance, light * light) - carry;
            const float4 next = sum + value;
            carry = (next - sum) - value;
            sum = next;
        }
    }
    film[place].sum = sum;
    film[place].carry = carry;
}
