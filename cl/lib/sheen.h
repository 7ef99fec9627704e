/**
 * @file
 * Sheen: the soft light that fibres standing off a cloth send back at grazing angles.
 *
 * Source: KHR_materials_sheen, that is A. Conty Estevez and C. Kulla, "Production Friendly
 * Microfacet Sheen BRDF", SIGGRAPH 2017: the distribution D = (2 + 1/a) sin^(1/a) / (2 pi) with a
 * the roughness squared, and their fit of its shadowing.
 * Differs from them: the fit sends back more than it gets where a low roughness is seen at a
 * grazing angle, up to three times; the lobe is divided by what it would send back in either
 * direction where that is more than 1. No softening of the terminator, so that it is the same both
 * ways.
 */
#ifndef LIB_SHEEN_H
#define LIB_SHEEN_H

#include "lib/math.h"

#if SHEEN_LOBE

#define SHEEN_LEAST  0.07f // roughness: below it there would be light at the very rim alone
#define SHEEN_STEPS  15    // between the table's rows, and its columns
#define SHEEN_MISSED 1.02f // the table between its entries is at most this much too low

// What the lobe of a white sheen sends back of even light, before it is divided: rows by roughness
// from SHEEN_LEAST to 1, columns by the square root of the view's cosine, both in even steps. The
// formulas integrated over the hemisphere in double precision; at cosine 0, where they have a pole,
// the value at 0.001.
__constant float sheen_table[(SHEEN_STEPS + 1) * (SHEEN_STEPS + 1)] = {
    // clang-format off
    2.9189f, 2.8295f, 2.0963f, 1.3169f, 0.7201f, 0.3363f, 0.1288f, 0.0381f, 0.0080f, 0.0011f, 0.0001f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f,
    1.6301f, 1.6572f, 1.4050f, 1.0675f, 0.7552f, 0.4989f, 0.3051f, 0.1698f, 0.0841f, 0.0358f, 0.0125f, 0.0033f, 0.0006f, 0.0001f, 0.0000f, 0.0000f,
    1.1769f, 1.2212f, 1.0937f, 0.8945f, 0.6955f, 0.5180f, 0.3686f, 0.2487f, 0.1572f, 0.0915f, 0.0479f, 0.0217f, 0.0081f, 0.0022f, 0.0003f, 0.0000f,
    0.9601f, 1.0087f, 0.9318f, 0.7933f, 0.6487f, 0.5142f, 0.3950f, 0.2928f, 0.2078f, 0.1397f, 0.0876f, 0.0501f, 0.0254f, 0.0105f, 0.0029f, 0.0002f,
    0.8443f, 0.8948f, 0.8436f, 0.7369f, 0.6219f, 0.5122f, 0.4122f, 0.3231f, 0.2455f, 0.1793f, 0.1244f, 0.0809f, 0.0484f, 0.0253f, 0.0101f, 0.0016f,
    0.7818f, 0.8343f, 0.7981f, 0.7095f, 0.6117f, 0.5170f, 0.4292f, 0.3493f, 0.2774f, 0.2137f, 0.1583f, 0.1114f, 0.0740f, 0.0445f, 0.0220f, 0.0062f,
    0.7519f, 0.8067f, 0.7799f, 0.7022f, 0.6147f, 0.5292f, 0.4490f, 0.3750f, 0.3072f, 0.2456f, 0.1902f, 0.1414f, 0.1007f, 0.0665f, 0.0380f, 0.0150f,
    0.7438f, 0.8012f, 0.7807f, 0.7093f, 0.6279f, 0.5477f, 0.4722f, 0.4019f, 0.3367f, 0.2764f, 0.2210f, 0.1708f, 0.1277f, 0.0902f, 0.0570f, 0.0279f,
    0.7510f, 0.8111f, 0.7949f, 0.7270f, 0.6487f, 0.5715f, 0.4985f, 0.4302f, 0.3663f, 0.3066f, 0.2509f, 0.1996f, 0.1547f, 0.1146f, 0.0779f, 0.0441f,
    0.7689f, 0.8319f, 0.8183f, 0.7519f, 0.6748f, 0.5987f, 0.5267f, 0.4592f, 0.3958f, 0.3361f, 0.2798f, 0.2274f, 0.1810f, 0.1390f, 0.0997f, 0.0626f,
    0.7937f, 0.8592f, 0.8471f, 0.7807f, 0.7035f, 0.6273f, 0.5554f, 0.4879f, 0.4244f, 0.3643f, 0.3073f, 0.2537f, 0.2061f, 0.1626f, 0.1214f, 0.0820f,
    0.8215f, 0.8890f, 0.8775f, 0.8102f, 0.7321f, 0.6552f, 0.5828f, 0.5148f, 0.4509f, 0.3902f, 0.3324f, 0.2779f, 0.2293f, 0.1847f, 0.1423f, 0.1015f,
    0.8477f, 0.9166f, 0.9049f, 0.8365f, 0.7573f, 0.6796f, 0.6065f, 0.5381f, 0.4737f, 0.4126f, 0.3543f, 0.2991f, 0.2499f, 0.2047f, 0.1616f, 0.1201f,
    0.8672f, 0.9367f, 0.9248f, 0.8556f, 0.7756f, 0.6975f, 0.6242f, 0.5558f, 0.4914f, 0.4302f, 0.3718f, 0.3165f, 0.2672f, 0.2218f, 0.1786f, 0.1370f,
    0.8746f, 0.9440f, 0.9321f, 0.8630f, 0.7834f, 0.7059f, 0.6333f, 0.5657f, 0.5020f, 0.4416f, 0.3838f, 0.3291f, 0.2803f, 0.2355f, 0.1928f, 0.1518f,
    0.8644f, 0.9329f, 0.9218f, 0.8545f, 0.7770f, 0.7016f, 0.6312f, 0.5655f, 0.5038f, 0.4452f, 0.3891f, 0.3359f, 0.2886f, 0.2451f, 0.2036f, 0.1638f,
    // clang-format on
};

// The table's value between its entries.
static inline float sheen_albedo(const float cosine, const float roughness)
{
    const float x = sqrt(clamp(cosine, 0.0f, 1.0f)) * (float)SHEEN_STEPS;
    const float y =
        clamp((roughness - SHEEN_LEAST) / (1.0f - SHEEN_LEAST), 0.0f, 1.0f) * (float)SHEEN_STEPS;
    const int column = min((int)x, SHEEN_STEPS - 1);
    const int row = min((int)y, SHEEN_STEPS - 1);
    __constant const float *at = sheen_table + row * (SHEEN_STEPS + 1) + column;
    const float across = x - (float)column;
    return mix(mix(at[0], at[1], across), mix(at[SHEEN_STEPS + 1], at[SHEEN_STEPS + 2], across),
               y - (float)row);
}

// What a white sheen sends back of even light, 0 .. 1.
static inline float sheen_share(const float cosine, const float roughness)
{
    return min2(sheen_albedo(cosine, roughness), 1.0f);
}

// The fit's L of their section 3: the logarithm of Smith's lambda.
static inline float sheen_shadow_log(const float x, const float rest)
{
    const float a = mix(21.5473f, 25.3245f, rest);
    const float b = mix(3.82987f, 3.32435f, rest);
    const float c = mix(0.19823f, 0.16801f, rest);
    const float d = mix(-1.97760f, -1.27393f, rest);
    const float e = mix(-4.32054f, -4.85967f, rest);
    return a / (1.0f + b * powr(x, c)) + d * x + e;
}

// Smith's lambda of one direction.
static inline float sheen_shadow(const float cosine, const float alpha)
{
    const float rest = (1.0f - alpha) * (1.0f - alpha);
    return cosine < 0.5f ? exp(sheen_shadow_log(cosine, rest))
                         : exp(2.0f * sheen_shadow_log(0.5f, rest) -
                               sheen_shadow_log(max2(1.0f - cosine, 0.0f), rest));
}

// f cos(theta) of a white sheen.
//
//   nol, nov, noh  cosines of light, view and half vector, the first two > 0
static inline float sheen_lobe(const float nol, const float nov, const float noh,
                               const float roughness)
{
    const float alpha = roughness * roughness;
    const float sin2 = max2(1.0f - noh * noh, 0.0f);
    const float d = (2.0f + 1.0f / alpha) * (0.5f * INV_PI) * powr(sin2, 0.5f / alpha);
    const float shadowing = 1.0f + sheen_shadow(nol, alpha) + sheen_shadow(nov, alpha);
    const float most = max2(sheen_albedo(nol, roughness), sheen_albedo(nov, roughness));
    return d / (4.0f * nov * shadowing * max2(SHEEN_MISSED * most, 1.0f));
}

#endif
#endif
