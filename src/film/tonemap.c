#include "film/tonemap.h"

#include <math.h>

// Luminance of linear Rec. 709 (ITU-R BT.709-6, section 3).
static float luminance(const float *rgb)
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

// NaN and negative values become 0, infinity the largest number.
static float clean(float x)
{
    return x > 0.0f ? fminf(x, 1e30f) : 0.0f;
}

static float clamp_unit(float x)
{
    return x > 0.0f ? fminf(x, 1.0f) : 0.0f;
}

// Darkens a pixel by its luminance, so that hues stay.
static void reinhard(float *rgb)
{
    const float scale = 1.0f / (1.0f + luminance(rgb));
    for (int i = 0; i < 3; i++)
        rgb[i] *= scale;
}

static void multiply(float *rgb, const float matrix[3][3])
{
    const float in[3] = {rgb[0], rgb[1], rgb[2]};
    for (int i = 0; i < 3; i++)
        rgb[i] = matrix[i][0] * in[0] + matrix[i][1] * in[1] + matrix[i][2] * in[2];
}

static void aces(float *rgb)
{
    // sRGB to XYZ, D65 to D60, to AP1, RRT saturation.
    static const float to_aces[3][3] = {
        {0.59719f, 0.35458f, 0.04823f},
        {0.07600f, 0.90834f, 0.01566f},
        {0.02840f, 0.13383f, 0.83777f},
    };
    // ODT saturation, to XYZ, D60 to D65, to sRGB.
    static const float to_srgb[3][3] = {
        {1.60475f, -0.53108f, -0.07367f},
        {-0.10208f, 1.10813f, -0.00605f},
        {-0.00327f, -0.07276f, 1.07602f},
    };

    multiply(rgb, to_aces);
    for (int i = 0; i < 3; i++) {
        // The fit is flat long before its square would overflow.
        const float v = fminf(rgb[i], 1e6f);
        const float a = v * (v + 0.0245786f) - 0.000090537f;
        const float b = v * (0.983729f * v + 0.4329510f) + 0.238081f;
        rgb[i] = a / b;
    }
    multiply(rgb, to_srgb);
}

float tonemap_srgb_encode(float linear)
{
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

void tonemap_apply(float *display, const float *rgb, size_t pixel_count, float exposure_ev,
                   enum tonemap tonemap)
{
    const float scale = exp2f(exposure_ev);
    for (size_t pixel = 0; pixel < pixel_count; pixel++) {
        float value[3];
        for (int i = 0; i < 3; i++)
            value[i] = clean(rgb[pixel * 3 + i] * scale);

        switch (tonemap) {
        case TONEMAP_NONE:
            break;
        case TONEMAP_REINHARD:
            reinhard(value);
            break;
        case TONEMAP_ACES:
            aces(value);
            break;
        }
        for (int i = 0; i < 3; i++)
            display[pixel * 3 + i] = tonemap_srgb_encode(clamp_unit(value[i]));
    }
}
