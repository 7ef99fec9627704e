/**
 * @file
 * The BSDFs: glTF 2.0's, and with BRDF_PHONG the thesis's. lib/bsdf_lanes.h has glTF's for hits
 * side by side.
 *
 * glTF: appendix B of the specification: a metal and a dielectric mixed by metalness, both with
 * a GGX microfacet lobe, the dielectric over a Lambert base. Mixed before it is stored: with
 * F = f0 + (f90 - f0) (1 - VoH)^5, f = (1 - Fd) diffuse / pi + F D V, where f0 and f90 are those of
 * the mixture and Fd is the dielectric's own F. Sampled by visible normals (E. Heitz, "Sampling the
 * GGX Distribution of Visible Normals", JCGT 7(4), 2018).
 *
 * Phong: diffuse / pi + f0 (n + 1) / (2 pi) cos^n(angle to the mirrored view) / cos(theta), which
 * is thesis A.1.2 with the factor that keeps its energy whatever n is; its limit is the mirror.
 *
 * Lambert is either with f0 = f90 = 0. With SHEEN_LOBE a negative alpha stands for lib/sheen.h's
 * lobe alone, of colour f0 and that roughness.
 */
#ifndef LIB_BSDF_H
#define LIB_BSDF_H

#include "lib/math.h"
#include "lib/sheen.h"
#include "shared/material.h"
#include "shared/oct.h"
#include "shared/path.h"
#include "shared/ray.h"

// Parameters at one hit.
struct bsdf {
    float3 normal;       // unit shading normal, viewer's side
    float3 geometric;    // unit geometric normal, viewer's side
    float3 view;         // unit direction to the viewer
    float3 diffuse;      // diffuse colour
    float3 f0;           // specular colour at normal incidence
    float f90;           // at grazing incidence
    float alpha;         // microfacet alpha, or Phong exponent; < 0: sheen of that roughness
    float dielectric_f0; // of the dielectric alone
    float dielectric_f90;
    bool mirror; // the specular lobe is a perfect mirror (Phong only)
};

// One sampled direction.
struct bsdf_sample {
    float3 dir;    // unit; all 0 if there is none
    float3 weight; // f cos / density
    float density; // of all lobes that light samples reach, 1/sr
    bool specular; // the mirror lobe was taken
};

// Whether nothing but the Lambert term is left.
static inline bool bsdf_is_lambert(const struct bsdf *b)
{
#if LAYERS
    if (b->dielectric_f90 > 0.0f)
        return false; // what comes through a coat that reflects some of it
#endif
    return max3(b->f0) <= 0.0f && b->f90 <= 0.0f;
}

static inline float bsdf_fifth_power(const float x)
{
    const float x2 = x * x;
    return x2 * x2 * x;
}

#if !BRDF_PHONG

// GGX distribution of normals, appendix B.3.2. With 1 = cos2 + sin2 its cos2 (a2 - 1) + 1 becomes a
// sum: the difference would leave no digits of a2 where the lobe is narrow.
static inline float bsdf_ggx_d(const float3 normal, const float3 half_dir, const float alpha)
{
    const float a2 = alpha * alpha;
    const float cos_h = max2(dot(normal, half_dir), 0.0f);
    const float3 across = cross(normal, half_dir);
    const float d = cos_h * cos_h * a2 + dot(across, across);
    return a2 * INV_PI / (d * d);
}

// NoX + sqrt(a^2 + (1 - a^2) NoX^2): half of Smith's masking for one side is NoX over it.
static inline float bsdf_smith(const float nox, const float alpha)
{
    const float a2 = alpha * alpha;
    return nox + sqrt(a2 + (1.0f - a2) * nox * nox);
}

// What the diffuse base gets to see: the dielectric reflects the rest.
static inline float bsdf_base_share(const struct bsdf *b, const float grazing)
{
    return 1.0f - (b->dielectric_f0 + (b->dielectric_f90 - b->dielectric_f0) * grazing);
}

#endif

// The shading normal turned towards the geometric one until what is mirrored at it stays above the
// surface: a metal would be black there.
static inline float3 bsdf_bend_normal(const struct bsdf *b)
{
    const float3 mirrored = 2.0f * dot(b->normal, b->view) * b->normal - b->view;
    const float view_z = dot(b->view, b->geometric);
    const float least = min2(0.9f * view_z, 0.025f); // cosine of the mirrored view
    if (dot(mirrored, b->geometric) >= least)
        return b->normal;

    // In the plane of both normals, z along the geometric one: 2 (N V) Nz - Vz = least, which
    // squared is quadratic in Nz^2.
    const float3 across = b->normal - dot(b->normal, b->geometric) * b->geometric;
    if (dot(across, across) < 1e-12f)
        return b->geometric;
    const float3 x = normalize(across);
    const float view_x = dot(b->view, x);
    const float a = max2(view_x * view_x + view_z * view_z, 1e-12f);
    const float half_b = a + view_z * least;
    const float c = (least + view_z) * (least + view_z);
    const float root = sqrt(max2(half_b * half_b - a * c, 0.0f));
    const float z2 = clamp(0.5f * (half_b + (view_x < 0.0f ? root : -root)) / a, 0.0f, 1.0f);
    const float3 bent = sqrt(1.0f - z2) * x + sqrt(z2) * b->geometric;
    return dot(bent, b->view) > 1e-4f ? bent : b->geometric;
}

// How likely sampling takes the specular lobe.
static inline float bsdf_specular_share(const struct bsdf *b)
{
#if BRDF_PHONG
    const float specular = luminance(b->f0);
    const float diffuse = luminance(b->diffuse);
#else
    const float nov = max2(dot(b->normal, b->view), 0.0f);
    const float grazing = bsdf_fifth_power(1.0f - nov);
    const float specular = luminance(b->f0 + ((float3)(b->f90) - b->f0) * grazing);
    const float diffuse = luminance(b->diffuse) * bsdf_base_share(b, grazing);
#endif
    const float sum = specular + diffuse;
    return sum > 0.0f ? specular / sum : 0.0f;
}

// f cos(theta) for light from `dir`, and the density with which sampling finds that direction.
// Both are 0 below the geometric or the shading surface, and the mirror lobe has no part in either.
static inline float3 bsdf_eval(float *density, const struct bsdf *b, const float3 dir)
{
    const float nol = dot(b->normal, dir);
    *density = 0.0f;
    if (nol <= 0.0f || dot(b->geometric, dir) <= 0.0f)
        return (float3)(0.0f);
#if SHEEN_LOBE
    if (b->alpha < 0.0f) {
        *density = 0.5f * INV_PI;
        const float nov = max2(dot(b->normal, b->view), 1e-6f);
        return b->f0 * sheen_lobe(nol, nov, dot(b->normal, normalize(dir + b->view)), -b->alpha);
    }
#endif
    const float3 lambert = b->diffuse * (nol * INV_PI);
    if (bsdf_is_lambert(b)) {
        *density = nol * INV_PI;
        return lambert;
    }

    const float share = bsdf_specular_share(b);
    *density = (1.0f - share) * nol * INV_PI;
#if BRDF_PHONG
    if (b->mirror)
        return lambert;
    const float3 mirrored = 2.0f * dot(b->normal, b->view) * b->normal - b->view;
    const float cos_lobe = dot(mirrored, dir);
    if (cos_lobe <= 0.0f)
        return lambert;
    const float lobe = (b->alpha + 1.0f) * (0.5f * INV_PI) * powr(cos_lobe, b->alpha);
    *density += share * lobe;
    return lambert + b->f0 * lobe;
#else
    const float3 half_dir = normalize(dir + b->view);
    const float nov = max2(dot(b->normal, b->view), 1e-6f);
    const float voh = min2(max2(dot(b->view, half_dir), 0.0f), 1.0f);
    const float grazing = bsdf_fifth_power(1.0f - voh);
    const float3 fresnel = b->f0 + ((float3)(b->f90) - b->f0) * grazing;
    const float d = bsdf_ggx_d(b->normal, half_dir, b->alpha);
    const float smith_v = bsdf_smith(nov, b->alpha);

    // Visible normals: density of the half vector D G1(v) VoH / NoV, Jacobian 1 / (4 VoH).
    *density += share * d * 0.5f / smith_v;
    return lambert * bsdf_base_share(b, grazing) +
           fresnel * (d * nol / (smith_v * bsdf_smith(nol, b->alpha)));
#endif
}

#if BRDF_PHONG

// Draws from the specular lobe.
static inline float3 bsdf_sample_specular(const struct bsdf *b, const float u0, const float u1)
{
    const float3 mirrored = 2.0f * dot(b->normal, b->view) * b->normal - b->view;
    if (b->mirror)
        return mirrored;
    const float cos_lobe = powr(u0, 1.0f / (b->alpha + 1.0f));
    const float sin_lobe = sqrt(max2(1.0f - cos_lobe * cos_lobe, 0.0f));
    const float2 turn = cos_sin_turn(u1);
    float3 tangent, bitangent;
    frame_build(&tangent, &bitangent, mirrored);
    return sin_lobe * (turn.x * tangent + turn.y * bitangent) + cos_lobe * mirrored;
}

#else

// Draws from the specular lobe: a visible normal, and the view mirrored at it (Heitz 2018, listing
// 1).
static inline float3 bsdf_sample_specular(const struct bsdf *b, const float u0, const float u1)
{
    float3 tangent, bitangent;
    frame_build(&tangent, &bitangent, b->normal);
    const float3 view = (float3)(dot(b->view, tangent), dot(b->view, bitangent),
                                 max2(dot(b->view, b->normal), 1e-6f));

    // Stretch the view, so that the surface becomes a hemisphere.
    const float3 v = normalize((float3)(b->alpha * view.x, b->alpha * view.y, view.z));

    // Draw a point on the hemisphere's projection towards the view.
    const float length2 = v.x * v.x + v.y * v.y;
    const float3 t1 =
        length2 > 0.0f ? (float3)(-v.y, v.x, 0.0f) * rsqrt(length2) : (float3)(1.0f, 0.0f, 0.0f);
    const float3 t2 = cross(v, t1);
    const float r = sqrt(u0);
    const float2 turn = cos_sin_turn(u1);
    const float p1 = r * turn.x;
    const float s = 0.5f * (1.0f + v.z);
    const float p2 = (1.0f - s) * sqrt(max2(1.0f - p1 * p1, 0.0f)) + s * r * turn.y;
    const float3 on = p1 * t1 + p2 * t2 + sqrt(max2(1.0f - p1 * p1 - p2 * p2, 0.0f)) * v;

    // Stretch it back.
    const float3 h = normalize((float3)(b->alpha * on.x, b->alpha * on.y, max2(on.z, 1e-6f)));
    const float3 half_dir = h.x * tangent + h.y * bitangent + h.z * b->normal;
    return 2.0f * dot(b->view, half_dir) * half_dir - b->view;
}

#endif

#if SHEEN_LOBE

// Draws from the hemisphere evenly, which the lobe's authors found the best of simple ways.
static inline float3 bsdf_sample_sheen(const struct bsdf *b, const float u0, const float u1)
{
    float3 tangent, bitangent;
    frame_build(&tangent, &bitangent, b->normal);
    const float level = sqrt(max2(1.0f - u0 * u0, 0.0f));
    const float2 turn = cos_sin_turn(u1);
    return level * (turn.x * tangent + turn.y * bitangent) + u0 * b->normal;
}

#endif

// Draws a direction to go on in.
//
//   u  three uniform numbers: lobe, direction
static inline struct bsdf_sample bsdf_sample(const struct bsdf *b, const float3 u)
{
    struct bsdf_sample out;
    out.dir = (float3)(0.0f);
    out.weight = (float3)(0.0f);
    out.density = 0.0f;
    out.specular = false;

    const bool lambert = bsdf_is_lambert(b);
    const float share = lambert ? 0.0f : bsdf_specular_share(b);
    const bool specular = u.x < share;
    float3 dir;
#if SHEEN_LOBE
    if (b->alpha < 0.0f)
        dir = bsdf_sample_sheen(b, u.y, u.z);
    else
#endif
        dir = specular ? bsdf_sample_specular(b, u.y, u.z) : sample_cosine(b->normal, u.y, u.z);
    if (dot(dir, b->geometric) <= 0.0f || dot(dir, b->normal) <= 0.0f)
        return out;

    // Cosine sampling of Lambert leaves nothing but the colour: the cosine rides out.
    if (lambert) {
        out.dir = dir;
        out.weight = b->diffuse;
        out.density = dot(dir, b->normal) * INV_PI;
        return out;
    }
    if (specular && b->mirror) {
        out.dir = normalize(dir);
        out.weight = b->f0 / share;
        out.specular = true;
        return out;
    }
    const float3 unit = normalize(dir);
    const float3 value = bsdf_eval(&out.density, b, unit);
    if (out.density <= 0.0f)
        return out;
    out.dir = unit;
    out.weight = value / out.density;
    return out;
}

// Microfacet alpha of a roughness; with BRDF_PHONG the exponent whose lobe is as wide as GGX's.
static inline float bsdf_alpha(const float roughness)
{
#if BRDF_PHONG
    const float alpha2 = max2(roughness * roughness * roughness * roughness, 1e-12f);
    return max2(2.0f / alpha2 - 2.0f, 0.0f);
#else
    return max2(roughness * roughness, MATERIAL_SMOOTH);
#endif
}

// The roughness that an alpha stands for.
static inline float bsdf_roughness(const float alpha)
{
    if (alpha < 0.0f)
        return -alpha; // a sheen's own
#if BRDF_PHONG
    return sqrt(sqrt(2.0f / (alpha + 2.0f)));
#else
    return sqrt(alpha);
#endif
}

// Four shares of one to 65535ths and back.
static inline uint2 bsdf_pack_shares(const float4 shares)
{
    const float4 scaled = clamp(shares, 0.0f, 1.0f) * 65535.0f + 0.5f;
    return (uint2)((uint)scaled.x | ((uint)scaled.y << 16),
                   (uint)scaled.z | ((uint)scaled.w << 16));
}

static inline float4 bsdf_unpack_shares(const uint2 packed)
{
    return (float4)((float)(packed.x & 0xffffu), (float)(packed.x >> 16),
                    (float)(packed.y & 0xffffu), (float)(packed.y >> 16)) /
           65535.0f;
}

// What of a BSDF stands in the bits of its path, path.throughput_bits.w.
static inline uint bsdf_bits(const struct bsdf *b)
{
    return (b->mirror ? PATH_MIRROR : 0u) | (b->alpha < 0.0f ? PATH_SHEEN : 0u) |
           (uint)(clamp(b->dielectric_f90, 0.0f, 1.0f) * 255.0f + 0.5f) << PATH_F90_SHIFT |
           (uint)(clamp(bsdf_roughness(b->alpha), 0.0f, 1.0f) * 65535.0f + 0.5f)
               << PATH_ROUGHNESS_SHIFT;
}

// Writes a hit for the stages that light it and go on from it.
//
//   org         where rays leave it
//   throughput  rgb weight of what it sends to the viewer
//   radiance    rgb collected so far
//   flags       PATH_... but for those of the lobes
static inline void bsdf_store(__global struct ray *ray, __global struct path *path,
                              __global struct shade *shade, const struct bsdf *b, const float3 org,
                              const float3 throughput, const float3 radiance, const uint flags)
{
    ray->org = (float4)(org, as_float(oct_pack(b->geometric.x, b->geometric.y, b->geometric.z)));
#if LAYERS
    ray->dir.xyz = -b->view; // some turn to the other side
#endif
    path->throughput_bits = (float4)(throughput, as_float(flags | bsdf_bits(b)));
    path->radiance_normal =
        (float4)(radiance, as_float(oct_pack(b->normal.x, b->normal.y, b->normal.z)));
    shade->diffuse_f0 = bsdf_pack_shares((float4)(b->diffuse, b->dielectric_f0));
    shade->specular_f90 = bsdf_pack_shares((float4)(b->f0, b->f90));
}

// The unit shading normal of a path's hit, viewer's side.
static inline float3 bsdf_normal(__global const struct path *path)
{
    return normalize(oct_unpack(as_uint(path->radiance_normal.w)).xyz);
}

// Reads back what bsdf_store() wrote of the BSDF.
static inline struct bsdf bsdf_load(__global const struct ray *ray,
                                    __global const struct path *path,
                                    __global const struct shade *shade)
{
    const uint bits = as_uint(path->throughput_bits.w);
    const float4 diffuse_f0 = bsdf_unpack_shares(shade->diffuse_f0);
    const float4 specular_f90 = bsdf_unpack_shares(shade->specular_f90);
    const float roughness = (float)(bits >> PATH_ROUGHNESS_SHIFT) / 65535.0f;
    struct bsdf b;
    b.normal = bsdf_normal(path);
    b.geometric = normalize(oct_unpack(as_uint(ray->org.w)).xyz);
    b.view = -ray->dir.xyz;
    b.diffuse = diffuse_f0.xyz;
    b.dielectric_f0 = diffuse_f0.w;
    b.f0 = specular_f90.xyz;
    b.f90 = specular_f90.w;
    b.dielectric_f90 = (float)((bits >> PATH_F90_SHIFT) & 0xffu) / 255.0f;
    b.alpha = (bits & PATH_SHEEN) ? -roughness : bsdf_alpha(roughness);
    b.mirror = (bits & PATH_MIRROR) != 0;
    return b;
}

#endif
