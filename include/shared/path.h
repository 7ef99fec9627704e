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
    uint pixel_count;  // pixels of the image
    uint sample_shift; // log2 of the samples in a pass; the passes of a batch are alike
    uint pad0, pad1, pad2;
};
SHARED_SIZE(batch, 32);

// Whose path a slot holds.
struct path_place {
    uint pixel;  // in Z-order
    uint sample; // number
};

static inline struct path_place batch_place(const struct batch batch, const uint slot)
{
    const uint pass_size = batch.pixel_count << batch.sample_shift;
    const uint in_batch = batch.first + slot;
    const uint pass = in_batch / pass_size;
    const uint in_pass = in_batch - pass * pass_size;
    struct path_place place;
    place.pixel = in_pass >> batch.sample_shift;
    place.sample = batch.first_sample + (pass << batch.sample_shift) +
                   (in_pass & ((1u << batch.sample_shift) - 1u));
    return place;
}

// Flags of a path, the low bits of path.radiance_flags.w.
#define PATH_ALIVE    1u // has a ray to trace
#define PATH_SPECULAR 2u // no light sample could have met this ray: count emission in full
#define PATH_COLLECT  4u // past the last shaded hit: the ray only collects emission

// What a path carries from bounce to bounce.
struct path {
    float4 throughput_pdf; // rgb weight of what arrives; w solid-angle density of the ray's
                           // direction, 1/sr
    float4 radiance_flags; // rgb collected so far; w bits: PATH_...
};
SHARED_SIZE(path, 32);

// Flags of a shaded hit, shade.flags.
#define SHADE_ACTIVE    1u // there is a surface to light
#define SHADE_NO_BOUNCE 2u // no ray follows that could meet a light: light samples count in full
#define SHADE_MIRROR    4u // the specular lobe is a perfect mirror, out of reach of light samples

// One shaded hit: written by material, read by direct and directional.
struct shade {
    float4 org_normal; // xyz where rays leave the surface, m; w bits of its normal, viewer's side
    float4 diffuse_alpha; // rgb diffuse colour; w microfacet alpha, or Phong exponent
    float4 f0_f90;        // rgb specular colour at normal incidence; w at grazing incidence
    float4 throughput_f; // rgb weight of the path so far; w dielectric reflectance (largest of rgb)
    uint normal;         // bits of the shading normal, oct_pack()
    uint view;           // bits of the direction to the viewer, oct_pack()
    float dielectric_f90; // the dielectric's reflectance at grazing incidence
    uint flags;           // SHADE_...
};
SHARED_SIZE(shade, 80);

// One set for each bounce. Stages read their counts here, so the host never waits inside a batch.
struct counters {
    uint active;           // paths alive at the start of the bounce
    uint trace_head;       // next ray of the persistent trace kernel
    uint direct_head;      // next hit of the persistent direct kernel
    uint directional_head; // next hit of the persistent directional kernel
    uint shadow_rays;      // shadow rays traced towards lights drawn
    uint directional_rays; // shadow rays traced towards directional lights and the environment
    uint pad0, pad1;
};
SHARED_SIZE(counters, 32);

#endif
