/**
 * @file
 * What the film keeps of a pixel.
 */
#ifndef SHARED_FILM_H
#define SHARED_FILM_H

#include "shared/base.h"

// The sum over the samples of one pixel, compensated (W. Kahan, 1965): sum + carry is the sum to
// about twice a float's precision, so that the 65536th sample counts as much as the first.
struct film_pixel {
    float4 sum;   // rgb; w luminance squared
    float4 carry; // what rounding took from each
};
SHARED_SIZE(film_pixel, 32);

#endif
