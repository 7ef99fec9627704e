#include "prep/woop.h"

#include <stdbool.h>
#include <string.h>

#include "prep/vec3.h"

// Makes a row that measures along `axis` from point a. False if it does not fit in float.
static bool set_row(float4 *out, const double *axis, const double *a)
{
    const double row[4] = {axis[0], axis[1], axis[2], -vec3_dot(axis, a)};
    for (int k = 0; k < 4; k++)
        if (!(fabs(row[k]) <= FLT_MAX))
            return false;
    *out = (float4){(float)row[0], (float)row[1], (float)row[2], (float)row[3]};
    return true;
}

// The inverse of the matrix [ab, ac, n, a] with n the unit normal: its determinant is |ab x ac|,
// and its rows are the cross products of its columns divided by that. The third column may have any
// length, since only a quotient of the third row is used; unit length keeps that row in range.
void woop_build(struct woop *out, const float *a, const float *b, const float *c)
{
    double pa[3], pb[3], pc[3], ab[3], ac[3], normal[3], u[3], v[3];
    vec3_load(pa, a);
    vec3_load(pb, b);
    vec3_load(pc, c);
    vec3_sub(ab, pb, pa);
    vec3_sub(ac, pc, pa);
    vec3_cross(normal, ab, ac);

    const double det = vec3_length(normal);
    for (int k = 0; k < 3; k++)
        normal[k] /= det;
    vec3_cross(u, ac, normal);
    vec3_cross(v, normal, ab);
    for (int k = 0; k < 3; k++) {
        u[k] /= det;
        v[k] /= det;
    }

    // No area, or rows that float does not hold.
    if (!(det > 0.0) || !set_row(&out->row_w, normal, pa) || !set_row(&out->row_u, u, pa) ||
        !set_row(&out->row_v, v, pa))
        memset(out, 0, sizeof(*out));
}
