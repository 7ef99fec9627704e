/**
 * @file
 * Colours as preparation computes with them: linear Rec. 709.
 */
#ifndef PREP_COLOR_H
#define PREP_COLOR_H

#include <math.h>

/** Luminance of linear Rec. 709. */
static inline double color_luminance(double r, double g, double b)
{
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** The linear value of an sRGB one, both 0 .. 1. */
static inline double color_from_srgb(double x)
{
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

#endif
