/**
 * @file
 * The display transform of 8-bit files: exposure, tone curve, sRGB encoding.
 *
 * In: linear Rec. 709. Out: display values 0 .. 1, ready to be quantised. Sources: the curve `aces`
 * is S. Hill's fit of the ACES reference rendering and sRGB output transforms (in M. Pettineo,
 * "BakingLab", ACES.hlsl); `reinhard` is E. Reinhard et al., "Photographic Tone Reproduction for
 * Digital Images", SIGGRAPH 2002, equation 3; the encoding is IEC 61966-2-1.
 */
#ifndef FILM_TONEMAP_H
#define FILM_TONEMAP_H

#include <stddef.h>

enum tonemap { TONEMAP_NONE, TONEMAP_REINHARD, TONEMAP_ACES };

/**
 * Transforms pixels for a display. NaN becomes black, infinity and what is too bright white.
 *
 * @param[out] display  [pixel_count * 3], may be `rgb` itself.
 * @param rgb           [pixel_count * 3], linear.
 * @param exposure_ev   Stops: light is multiplied by 2^exposure_ev.
 */
void tonemap_apply(float *display, const float *rgb, size_t pixel_count, float exposure_ev,
                   enum tonemap tonemap);

/** Encodes one linear value, 0 .. 1, for an sRGB display. */
float tonemap_srgb_encode(float linear);

#endif
