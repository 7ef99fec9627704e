/**
 * @file
 * The state of a path in flight, and the counters that stages hand to each other.
 */
#ifndef SHARED_PATH_H
#define SHARED_PATH_H

#include "shared/base.h"

// The paths of one batch: `count` consecutive places of the sequence (sample, pixel in Z-order).
// Slot i of the queue holds place first_pixel + i, counted from the first pixel of first_sample.
struct batch {
    uint first_pixel;  // place in Z-order of slot 0, < pixel_count
    uint first_sample; // sample number of slot 0
    uint count;        // slots in use
    uint pixel_count;  // pixels of the image
};
SHARED_SIZE(batch, 16);

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
    uint shadow_rays;      // shadow rays traced
    uint pad0, pad1, pad2;
};
SHARED_SIZE(counters, 32);

#endif
