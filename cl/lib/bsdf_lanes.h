/**
 * @file
 * BSDFs of hits side by side, on CPUs: the Lambert term, and glTF's specular lobe (lib/bsdf.h,
 * where the formulas are told). Mirrors, sheens and Phong's lobe are evaluated one by one.
 */
#ifndef LIB_BSDF_LANES_H
#define LIB_BSDF_LANES_H

#include "lib/shade_lanes.h"
#include "shared/material.h"
#include "shared/path.h"
#include "shared/ray.h"

#if SHADE_LANES

// What bsdf_load() loads, and the weights of the paths.
struct bsdf_lanes {
    struct lanes3 org; // where rays leave the surfaces
    struct lanes3 normal, geometric;
    struct lanes3 diffuse;
    struct lanes3 throughput;
    lanes_int alone; // PATH_NO_BOUNCE
    uint glossy;     // bits of those that are more than Lambert; what follows is set if one is
    struct lanes3 view, f0;
    lanes_float f90, alpha, dielectric_f0, dielectric_f90;
    lanes_float share; // how likely sampling takes the specular lobe
};

static inline lanes_float bsdf_lanes_fifth_power(const lanes_float x)
{
    const lanes_float x2 = x * x;
    return x2 * x2 * x;
}

// f0 + (f90 - f0) grazing
static inline struct lanes3 bsdf_lanes_fresnel(const struct bsdf_lanes *b,
                                               const lanes_float grazing)
{
    return lanes3_make(MULADD(b->f90 - b->f0.x, grazing, b->f0.x),
                       MULADD(b->f90 - b->f0.y, grazing, b->f0.y),
                       MULADD(b->f90 - b->f0.z, grazing, b->f0.z));
}

// bsdf_base_share()
static inline lanes_float bsdf_lanes_base_share(const struct bsdf_lanes *b,
                                                const lanes_float grazing)
{
    return 1.0f - MULADD(b->dielectric_f90 - b->dielectric_f0, grazing, b->dielectric_f0);
}

// bsdf_specular_share()
static inline lanes_float bsdf_lanes_share(const struct bsdf_lanes *b)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const lanes_float nov = lanes_max(lanes3_dot(b->normal, b->view), zero);
    const lanes_float grazing = bsdf_lanes_fifth_power(1.0f - nov);
    const lanes_float specular = lanes_luminance(bsdf_lanes_fresnel(b, grazing));
    const lanes_float diffuse = lanes_luminance(b->diffuse) * bsdf_lanes_base_share(b, grazing);
    const lanes_float sum = specular + diffuse;
    return sum > 0.0f ? specular / sum : zero;
}

// bsdf_smith()
static inline lanes_float bsdf_lanes_smith(const lanes_float nox, const lanes_float a2)
{
    return nox + sqrt(MULADD((1.0f - a2) * nox, nox, a2));
}

// Reads those of the slots that have a bit and are shaded side by side. Returns bits of them.
static inline uint bsdf_lanes_load(struct bsdf_lanes *out, const uint *slots, const uint bits,
                                   __global const struct ray *rays,
                                   __global const struct path *paths,
                                   __global const struct shade *shades)
{
    const struct lanes4 throughput = LANES_OF(paths, slots, .throughput_bits);
    const struct lanes4 shade = LANES_OF(((__global const float4 *)shades), slots, );
    const struct lanes4 org = LANES_OF(rays, slots, .org);
    const lanes_float normal = LANES_WORD(lanes_float, paths, slots, .radiance_normal.w);
    const struct lanes4 diffuse =
        lanes_unpack_shares(lanes_as_uint(shade.x), lanes_as_uint(shade.y));
    const lanes_uint path_bits = lanes_as_uint(throughput.w);
    out->org = lanes3_xyz(org);
    out->normal = lanes_oct_unpack(lanes_as_uint(normal));
    out->geometric = lanes_oct_unpack(lanes_as_uint(org.w));
    out->diffuse = lanes3_xyz(diffuse);
    out->throughput = lanes3_xyz(throughput);
    out->alone = (path_bits & PATH_NO_BOUNCE) != 0u;

    const lanes_uint others = path_bits & (PATH_MIRROR | PATH_SHEEN);
    const lanes_uint specular =
        (path_bits & (0xffu << PATH_F90_SHIFT)) | lanes_as_uint(shade.z) | lanes_as_uint(shade.w);
    const uint lambert = bits & lanes_bits((others | specular) == 0u);
#if BRDF_PHONG
    out->glossy = 0;
    return lambert;
#else
    out->glossy = bits & lanes_bits(others == 0u) & ~lambert;
    if (out->glossy == 0)
        return lambert;
    const struct lanes3 dir = lanes3_xyz(LANES_OF(rays, slots, .dir));
    const struct lanes4 f0 = lanes_unpack_shares(lanes_as_uint(shade.z), lanes_as_uint(shade.w));
    const lanes_float roughness =
        lanes_to_float(lanes_as_int(path_bits >> PATH_ROUGHNESS_SHIFT)) * (1.0f / 65535.0f);
    out->view = lanes3_make(-dir.x, -dir.y, -dir.z);
    out->f0 = lanes3_xyz(f0);
    out->f90 = f0.w;
    out->alpha = lanes_max(roughness * roughness, (lanes_float)(MATERIAL_SMOOTH));
    out->dielectric_f0 = diffuse.w;
    out->dielectric_f90 =
        lanes_to_float(lanes_as_int((path_bits >> PATH_F90_SHIFT) & 0xffu)) * (1.0f / 255.0f);
    out->share = bsdf_lanes_share(out);
    return lambert | out->glossy;
#endif
}

// f cos(theta) for light from `dir`, and the density with which sampling finds it: bsdf_eval(), for
// directions above both surfaces.
static inline struct lanes3 bsdf_lanes_eval(lanes_float *density, const struct bsdf_lanes *b,
                                            const struct lanes3 dir)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const lanes_float nol = lanes3_dot(b->normal, dir);
    const lanes_float cosine_density = nol * INV_PI;
    const struct lanes3 lambert = lanes3_scale(b->diffuse, cosine_density);
    *density = cosine_density;
    if (b->glossy == 0)
        return lambert;

    const struct lanes3 half_dir = lanes3_normalize(lanes3_add(dir, b->view));
    const lanes_float nov = lanes_max(lanes3_dot(b->normal, b->view), (lanes_float)(1e-6f));
    const lanes_float voh = lanes_min(lanes_max(lanes3_dot(b->view, half_dir), zero), zero + 1.0f);
    const lanes_float grazing = bsdf_lanes_fifth_power(1.0f - voh);

    // bsdf_ggx_d()
    const lanes_float a2 = b->alpha * b->alpha;
    const lanes_float cos_h = lanes_max(lanes3_dot(b->normal, half_dir), zero);
    const struct lanes3 across = lanes3_cross(b->normal, half_dir);
    const lanes_float spread = MULADD(cos_h * cos_h, a2, lanes3_dot(across, across));
    const lanes_float d = a2 * INV_PI / (spread * spread);

    const lanes_float lobe = d / bsdf_lanes_smith(nov, a2);
    const struct lanes3 specular =
        lanes3_scale(bsdf_lanes_fresnel(b, grazing), lobe * nol / bsdf_lanes_smith(nol, a2));
    const struct lanes3 both = lanes3_muladd(lambert, bsdf_lanes_base_share(b, grazing), specular);
    const lanes_int glossy = lanes_mask(b->glossy);
    const lanes_float of_both =
        MULADD(b->share, 0.5f * lobe, MULADD(-b->share, cosine_density, cosine_density));
    *density = glossy ? of_both : cosine_density;
    return lanes3_select(glossy, both, lambert);
}

// Draws from the specular lobes: bsdf_sample_specular().
static inline struct lanes3 bsdf_lanes_draw_specular(const struct bsdf_lanes *b,
                                                     const lanes_float u0, const lanes_float u1)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const lanes_float least = (lanes_float)(1e-6f);
    struct lanes3 tangent, bitangent;
    lanes_frame(&tangent, &bitangent, b->normal);

    // Stretch the view, so that the surface becomes a hemisphere.
    const struct lanes3 v = lanes3_normalize(lanes3_make(
        b->alpha * lanes3_dot(b->view, tangent), b->alpha * lanes3_dot(b->view, bitangent),
        lanes_max(lanes3_dot(b->view, b->normal), least)));

    // Draw a point on the hemisphere's projection towards the view.
    const lanes_float length2 = MULADD(v.x, v.x, v.y * v.y);
    const lanes_float scale = lanes_rsqrt(length2);
    const lanes_int tilted = length2 > 0.0f;
    const struct lanes3 t1 =
        lanes3_make(tilted ? -v.y * scale : zero + 1.0f, tilted ? v.x * scale : zero, zero);
    const struct lanes3 t2 = lanes3_cross(v, t1);
    const lanes_float r = sqrt(u0);
    lanes_float cosine, sine;
    lanes_cos_sin_turn(&cosine, &sine, u1);
    const lanes_float p1 = r * cosine;
    const lanes_float s = MULADD((lanes_float)(0.5f), v.z, zero + 0.5f);
    const lanes_float left = lanes_max(1.0f - p1 * p1, zero);
    const lanes_float p2 = MULADD(1.0f - s, sqrt(left), s * r * sine);
    const lanes_float up = sqrt(lanes_max(left - p2 * p2, zero));
    const struct lanes3 on = lanes3_muladd(t1, p1, lanes3_muladd(t2, p2, lanes3_scale(v, up)));

    // Stretch it back.
    const struct lanes3 h =
        lanes3_normalize(lanes3_make(b->alpha * on.x, b->alpha * on.y, lanes_max(on.z, least)));
    const struct lanes3 half_dir =
        lanes3_muladd(tangent, h.x, lanes3_muladd(bitangent, h.y, lanes3_scale(b->normal, h.z)));
    return lanes3_sub(lanes3_scale(half_dir, 2.0f * lanes3_dot(b->view, half_dir)), b->view);
}

// Draws directions to go on in: bsdf_sample(). They weigh what bsdf_lanes_weigh() says if they are
// above both surfaces, else nothing.
//
//   u, u0, u1  uniform numbers: lobe, direction
static inline struct lanes3 bsdf_lanes_draw(const struct bsdf_lanes *b, const lanes_float u,
                                            const lanes_float u0, const lanes_float u1)
{
    const struct lanes3 dir = lanes_sample_cosine(b->normal, u0, u1);
    if (b->glossy == 0)
        return dir;
    const lanes_int specular = lanes_mask(b->glossy) & (u < b->share);
    if (lanes_bits(specular) == 0)
        return dir;
    return lanes3_select(specular, lanes3_normalize(bsdf_lanes_draw_specular(b, u0, u1)), dir);
}

// f cos(theta) / density of directions that were drawn, above both surfaces.
static inline struct lanes3 bsdf_lanes_weigh(lanes_float *density, const struct bsdf_lanes *b,
                                             const struct lanes3 dir)
{
    const struct lanes3 value = bsdf_lanes_eval(density, b, dir);

    // Cosine sampling of Lambert leaves nothing but the colour: the cosine rides out.
    if (b->glossy == 0)
        return b->diffuse;
    return lanes3_select(lanes_mask(b->glossy), lanes3_scale(value, 1.0f / *density), b->diffuse);
}

#endif

#endif
