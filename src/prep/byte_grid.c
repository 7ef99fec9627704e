#include "prep/byte_grid.h"

#include <float.h>
#include <math.h>

#include "prep/vec3.h"
#include "shared/byte_planes.h"

// Planes are put outwards by this part of a cell: beside 1, the float that a byte becomes keeps
// 2^-9 of one.
#define CELL_MARGIN 0x1p-6

// Cells between the first and the last plane: room is left for margins and for rounding.
#define CELLS 254.0

bool byte_grid_lay(struct byte_planes *out, const struct byte_boxes *boxes, int axis,
                   bool power_of_two)
{
    float least = boxes->count > 0 ? FLT_MAX : 0.0f;
    float most = -least;
    for (uint32_t i = 0; i < boxes->count; i++) {
        least = fminf(least, boxes->lo[i][axis]);
        most = fmaxf(most, boxes->hi[i][axis]);
    }

    // An origin, 2^BYTE_PLANE_SHIFT cells below, may be rounded down by as much as it is precise.
    const double extent = (double)most - least + fabs(least) * 0x1p-22 + FLT_MIN;
    double exact = extent / CELLS * (1 << BYTE_PLANE_SHIFT);
    if (power_of_two)
        exact = exp2(ceil(log2(exact)));
    if (exact > FLT_MAX)
        return false;
    out->scale = float_above(exact);
    const double cell = out->scale / (double)(1 << BYTE_PLANE_SHIFT);
    out->origin = float_below(least - CELL_MARGIN * cell - out->scale);
    const double first = (double)out->origin + out->scale; // where byte 0 lies
    for (uint32_t i = 0; i < boxes->count; i++) {
        const double lo = floor(((double)boxes->lo[i][axis] - first) / cell - CELL_MARGIN);
        const double hi = ceil(((double)boxes->hi[i][axis] - first) / cell + CELL_MARGIN);
        out->lo[i] = (unsigned char)fmax(lo, 0.0); // -1 if the quotient rounds
        out->hi[i] = (unsigned char)fmin(hi, 255.0);
    }
    return true;
}
