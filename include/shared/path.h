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

// path.flags
#define PATH_SPECULAR 1u // the last bounce cannot be met by light sampling: count emission in full
#define PATH_LAST     2u // after this hit the path only collects emission

// What a path carries from bounce to bounce.
struct path {
    float4 throughput_pdf; // rgb weight of what arrives; w solid-angle density of the ray's
                           // direction, 1/sr
    float4 radiance_flags; // rgb collected so far; w bits: PATH_...
};
SHARED_SIZE(path, 32);

// shade.flags, low bits
#define SHADE_ACTIVE 1u // there is a surface to light here

// One shaded hit: written by material, read by direct and directional.
struct shade {
    float4 org_normal;    // xyz origin for rays that leave the surface, m; w bits of the geometric
                          // normal, on the side of the viewer
    float4 diffuse_alpha; // rgb diffuse colour; w roughness alpha of the microfacets, or the Phong
                          // exponent, 0: none
    float4 f0_f90;        // rgb specular colour at normal incidence; w at grazing incidence
    float4 throughput_f;  // rgb weight of the path before this bounce; w largest dielectric
                          // reflectance at normal incidence
    uint normal;          // bits of the shading normal, oct_pack()
    uint view;            // bits of the unit direction to the viewer
    float specular;       // strength of the dielectric layer, its reflectance at grazing incidence
    uint flags;           // SHADE_..., PATH_... of this hit
};
SHARED_SIZE(shade, 80);

// One set for each bounce; every stage reads its own count here, so the host never waits inside a
// batch.
struct counters {
    uint active;           // paths alive at the start of the bounce
    uint trace_head;       // next ray of the persistent trace kernel
    uint direct_head;      // next hit of the persistent direct kernel
    uint directional_head; // next hit of the persistent directional kernel
    uint rays;             // rays traced
    uint shadow_rays;      // shadow rays traced
    uint pad0, pad1;
};
SHARED_SIZE(counters, 32);

#endif
