/**
 * @file
 * The state of a path in flight, and the counters that stages hand to each other.
 */
#ifndef SHARED_PATH_H
#define SHARED_PATH_H

#include "shared/base.h"

// The paths of one batch: `count` consecutive places of the sequence (pass, pixel in Z-order,
// sample of the pass). A pass takes 2^sample_shift samples of every pixel, side by side, so that
// rays that run alike and fetch the same texels lie next to each other.
struct batch {
    uint first;        // place of slot 0 in its pass, < pixel_count << sample_shift
    uint first_sample; // first sample number of that pass
    uint count;        // slots in use
    uint pixel_count;  // pixels of a pass: the image's, or a span's
    uint sample_shift; // log2 of the samples in a pass; the passes of a batch are alike
    uint first_pixel;  // added to the pixels counted through
    uint pad0, pad1;
};
SHARED_SIZE(batch, 32);

// Whose path a slot holds.
struct path_place {
    uint pixel;  // among those counted through; of samples_place(), in Z-order
    uint sample; // number
};

static inline struct path_place batch_place(const struct batch batch, const uint slot)
{
    const uint pass_size = batch.pixel_count << batch.sample_shift;
    const uint in_batch = batch.first + slot;
    const uint pass = in_batch / pass_size;
    const uint in_pass = in_batch - pass * pass_size;
    struct path_place place;
    place.pixel = batch.first_pixel + (in_pass >> batch.sample_shift);
    place.sample = batch.first_sample + (pass << batch.sample_shift) +
                   (in_pass & ((1u << batch.sample_shift) - 1u));
    return place;
}

// Flags of a path, the low bits of path.throughput_bits.w. Raygen and scatter write the first
// three, for the ray; material the others, for the hit.
#define PATH_ALIVE     1u  // has a ray to trace
#define PATH_SPECULAR  2u  // no light sample could have met this ray: count emission in full
#define PATH_COLLECT   4u  // past the last shaded hit: the ray only collects emission
#define PATH_SHADED    8u  // there is a surface to light
#define PATH_NO_BOUNCE 16u // no ray follows that could meet a light: light samples count in full
#define PATH_MIRROR    32u // the specular lobe is a perfect mirror, out of reach of light samples
#define PATH_SHEEN     64u // the specular lobe is a sheen

// Above the flags: the dielectric's reflectance at grazing incidence, in 255ths, and the roughness
// of the specular lobe, in 65535ths.
#define PATH_F90_SHIFT       8
#define PATH_ROUGHNESS_SHIFT 16

// What a path carries from bounce to bounce, and of its shaded hit what finds room: with its ray
// and its hit 80 bytes.
struct path {
    float4 throughput_bits; // rgb weight of what arrives; w bits: flags and the surface's, as above
    float4 radiance_normal; // rgb collected so far; w bits of the shading normal at the hit that is
                            // or was shaded last, viewer's side, oct_pack()
};
SHARED_SIZE(path, 32);

// The colours of a shaded hit, in 65535ths. Material writes them where the hit was.
struct shade {
    uint2 diffuse_f0;   // rgb diffuse; w the dielectric's reflectance at normal incidence
    uint2 specular_f90; // rgb specular at normal incidence; w at grazing incidence
};
SHARED_SIZE(shade, 16);

#define PATH_RUN 128u // neighbours in the queue that one of a CPU's work items takes at once

// One set for each bounce. Stages read their counts here, so the host never waits inside a batch.
struct counters {
    uint active;           // paths alive at the start of the bounce
    uint trace_head;       // next ray of the persistent trace kernel
    uint direct_head;      // next hit of the persistent direct kernel
    uint directional_head; // next hit of the persistent directional kernel
    // Of all batches so far, modulo 2^32: the host need not read them after each.
    uint shadow_rays;      // shadow rays traced towards lights drawn
    uint directional_rays; // shadow rays traced towards directional lights and the environment
    uint rays;             // that were active in the batches before
    uint pad0;
};
SHARED_SIZE(counters, 32);

#endif
