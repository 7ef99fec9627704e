/**
 * @file
 * What rays find at the triangles of lib/traverse_few.h, all Lambert: worked out once for each of
 * their sides, so that hits of a path look it up.
 *
 * It is what lib/material_lanes.h computes at every hit, with colours and normals rounded as its
 * stage hands them on.
 */
#ifndef LIB_FEW_SURFACE_H
#define LIB_FEW_SURFACE_H

#include "lib/material_lanes.h"
#include "lib/traverse_few.h"

#if SHADE_LANES

// few_corners.geometric_flags.w
#define FEW_SHINES   1u // one of its sides
#define FEW_SMOOTH   2u // its corners' normals differ: the shading normal is to be blended
#define FEW_TEXTURED 4u // has a texture of the base colour

// A triangle, by place in struct few.
struct few_corners {
    float4 corner_red;  // the first; of the diffuse colour
    float4 edge1_green; // from there to the second
    float4 edge2_blue;  // to the third
    float4 geometric_flags;
};

// A side of it: 2 place that in front, 2 place + 1 that behind. Normals are on that side.
struct few_side {
    float4 geometric;
    float4 normal;   // shading normal, of smooth ones that of the first corner
    float4 emission; // without its texture
    float4 pad0;     // two shifts find a row of 64 bytes, three instructions one of 48
};

struct few_surface {
    struct few_corners corners[FEW_MOST];
    float4 normals[FEW_MOST]; // of the triangles' corners, oct_pack()
    struct few_side sides[2 * FEW_MOST];
};

// As material hands normals on.
static inline struct lanes3 few_round_normal(const struct lanes3 normal)
{
    return lanes_oct_unpack(lanes_oct_pack(normal));
}

// As it hands colours on.
static inline struct lanes3 few_round_color(const struct lanes3 color)
{
    const lanes_uint xy = lanes_as_uint(lanes_pack_shares(color.x, color.y));
    const lanes_uint z = lanes_as_uint(lanes_pack_shares(color.z, (lanes_float)(0.0f)));
    return lanes3_xyz(lanes_unpack_shares(xy, z));
}

// Works out those from place `first` on, as many as there are lanes; past the end the last one
// stands in.
static inline void few_surface_some(struct few_surface *out, const struct few *few,
                                    const uint first, const struct surface *s)
{
    struct material_lanes_hits h;
    uint place[LANES], side[LANES];
    for (uint k = 0; k < LANES; k++)
        place[k] = min(first + k, few->count - 1);
    const lanes_float zero = (lanes_float)(0.0f);
    const struct lanes4 corners = {zero, zero, zero,
                                   lanes_as_float(LANES_WORD(lanes_uint, few->names, place, ))};
    material_lanes_see(&h, LANES_ALL, corners, s);
    const struct lanes4 row0 = LANES_OF(s->vertices, h.v0, .pos_normal);
    const struct lanes4 row1 = LANES_OF(s->vertices, h.v1, .pos_normal);
    const struct lanes4 row2 = LANES_OF(s->vertices, h.v2, .pos_normal);
    const struct lanes4 emission = LANES_OF(s->materials, h.material, .emission);
    const struct lanes4 base = LANES_OF(s->materials, h.material, .base);

    // The triangles.
    const struct lanes3 edge1 = lanes3_sub(lanes3_xyz(row1), lanes3_xyz(row0));
    const struct lanes3 edge2 = lanes3_sub(lanes3_xyz(row2), lanes3_xyz(row0));
    const struct lanes3 geometric = lanes3_normalize(lanes3_cross(edge1, edge2));
    const lanes_uint n0 = lanes_as_uint(row0.w);
    const lanes_int smooth = (lanes_as_uint(row1.w) != n0) | (lanes_as_uint(row2.w) != n0);
    const lanes_int shines = lanes3_max(lanes3_xyz(emission)) > 0.0f;
    const lanes_uint bits =
        lanes_as_uint((shines & (lanes_int)(FEW_SHINES)) | (smooth & (lanes_int)(FEW_SMOOTH)) |
                      (lanes_mask(h.textured) & (lanes_int)(FEW_TEXTURED)));
    const struct lanes3 diffuse = few_round_color(lanes3_xyz(base));
    const struct lanes4 normals = {row0.w, row1.w, row2.w, row2.w};
    LANES_STORE(out->corners, place, .corner_red, LANES_ALL,
                lanes4_make(lanes3_xyz(row0), diffuse.x));
    LANES_STORE(out->corners, place, .edge1_green, LANES_ALL, lanes4_make(edge1, diffuse.y));
    LANES_STORE(out->corners, place, .edge2_blue, LANES_ALL, lanes4_make(edge2, diffuse.z));
    LANES_STORE(out->corners, place, .geometric_flags, LANES_ALL,
                lanes4_make(geometric, lanes_as_float(bits)));
    LANES_STORE(out->normals, place, , LANES_ALL, normals);

    // Their sides.
    const struct lanes3 normal = hit_lanes_normal(n0, n0, n0, zero, zero, geometric);
    for (uint behind = 0; behind < 2; behind++) {
        const lanes_float sign = (lanes_float)(behind != 0 ? -1.0f : 1.0f);
        const lanes_int is_lit =
            behind != 0 ? (h.flags & MATERIAL_EMITS_BACK) != 0u : (lanes_int)(-1);
        for (uint k = 0; k < LANES; k++)
            side[k] = 2 * place[k] + behind;
        LANES_STORE(out->sides, side, .geometric, LANES_ALL,
                    lanes4_make(few_round_normal(lanes3_scale(geometric, sign)), zero));
        LANES_STORE(out->sides, side, .normal, LANES_ALL,
                    lanes4_make(few_round_normal(lanes3_scale(normal, sign)), zero));
        LANES_STORE(
            out->sides, side, .emission, LANES_ALL,
            lanes4_make(lanes3_select(is_lit, lanes3_xyz(emission), lanes3_make(zero, zero, zero)),
                        zero));
    }
}

static inline void few_surface_begin(struct few_surface *out, const struct few *few,
                                     const struct surface *s)
{
    for (uint first = 0; first < few->count; first += LANES)
        few_surface_some(out, few, first, s);
}

#endif

#endif
