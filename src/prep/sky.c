#include "prep/sky.h"

#include <float.h>
#include <math.h>

#include "prep/color.h"

#define GROUND_ALBEDO   0.2      // of soil and grass
#define SOLAR_CONSTANT  128000.0 // lux outside the atmosphere
#define RADIANS(degree) ((degree) * (M_PI / 180.0))

// Perez' five coefficients and the value at the zenith, of Y (kcd/m2), x and y.
struct channel {
    double perez[5];
    double zenith;
};

// Perez' function of the angle to the zenith and to the sun.
static double perez(const struct channel *c, double cos_theta, double gamma)
{
    const double cos_gamma = cos(gamma);
    return (1.0 + c->perez[0] * exp(c->perez[1] / cos_theta)) *
           (1.0 + c->perez[2] * exp(c->perez[3] * gamma) + c->perez[4] * cos_gamma * cos_gamma);
}

// Appendix A.2. theta: the sun's angle to the zenith; t: turbidity.
static void find_channels(struct channel out[3], double theta, double t)
{
    const double t2 = theta * theta;
    const double t3 = t2 * theta;
    const double chi = (4.0 / 9.0 - t / 120.0) * (M_PI - 2.0 * theta);
    out[0] = (struct channel){
        {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
         -0.0670 * t + 0.3703},
        (4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192,
    };
    out[1] = (struct channel){
        {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
         -0.0033 * t + 0.0452},
        t * t * (0.00166 * t3 - 0.00375 * t2 + 0.00209 * theta) +
            t * (-0.02903 * t3 + 0.06377 * t2 - 0.03202 * theta + 0.00394) +
            (0.11693 * t3 - 0.21196 * t2 + 0.06052 * theta + 0.25886),
    };
    out[2] = (struct channel){
        {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
         -0.0109 * t + 0.0529},
        t * t * (0.00275 * t3 - 0.00610 * t2 + 0.00317 * theta) +
            t * (-0.04214 * t3 + 0.08970 * t2 - 0.04153 * theta + 0.00516) +
            (0.15346 * t3 - 0.26756 * t2 + 0.06670 * theta + 0.26688),
    };
    out[0].zenith = fmax(out[0].zenith, 0.0);
}

// CIE x, y and luminance to linear Rec. 709; what lies outside of it is clipped.
static void from_xyy(double *rgb, double x, double y, double luminance)
{
    const double big_x = luminance * x / y;
    const double big_z = luminance * (1.0 - x - y) / y;
    rgb[0] = fmax(3.2404542 * big_x - 1.5371385 * luminance - 0.4985314 * big_z, 0.0);
    rgb[1] = fmax(-0.9692660 * big_x + 1.8760108 * luminance + 0.0415560 * big_z, 0.0);
    rgb[2] = fmax(0.0556434 * big_x - 0.2040259 * luminance + 1.0572252 * big_z, 0.0);
}

// The sun's illuminance on a surface that faces it: the solar constant, less what the air scatters
// and the ozone takes (appendix A.1), at the dominant wavelengths of Rec. 709.
static void find_sun(double *rgb, double theta, double turbidity)
{
    static const double wavelengths[3] = {0.611, 0.549, 0.465}; // um
    static const double ozone[3] = {0.120, 0.085, 0.010};       // 1/cm (appendix, table 2)
    const double degrees = theta * (180.0 / M_PI);
    const double mass = 1.0 / (cos(theta) + 0.15 * pow(93.885 - degrees, -1.253));
    const double beta = 0.04608 * turbidity - 0.04586;
    for (int k = 0; k < 3; k++) {
        const double rayleigh = 0.008735 * pow(wavelengths[k], -4.08) * mass;
        const double aerosol = beta * pow(wavelengths[k], -1.3) * mass;
        rgb[k] = SOLAR_CONSTANT * exp(-rayleigh - aerosol - 0.35 * ozone[k] * mass);
    }
}

static void set_texel(float4 *texel, const double *rgb, double factor)
{
    texel->x = (float)fmin(rgb[0] * factor, FLT_MAX);
    texel->y = (float)fmin(rgb[1] * factor, FLT_MAX);
    texel->z = (float)fmin(rgb[2] * factor, FLT_MAX);
    texel->w = 0.0f;
}

void sky_bake(float4 *texels, struct directional_light *sun, const struct sky *sky)
{
    const double theta = RADIANS(90.0 - sky->elevation_deg);
    const double azimuth = RADIANS((double)sky->azimuth_deg);
    const double to_sun[3] = {sin(theta) * sin(azimuth), cos(theta), -sin(theta) * cos(azimuth)};
    struct channel channels[3];
    double at_zenith[3], sun_rgb[3];
    find_channels(channels, theta, sky->turbidity);
    for (int k = 0; k < 3; k++)
        at_zenith[k] = perez(&channels[k], 1.0, theta);

    // The sky, and what it sends to the level ground.
    double ground[3] = {0.0, 0.0, 0.0};
    for (uint y = 0; y < SKY_HEIGHT / 2; y++) {
        const double angle = (y + 0.5) * M_PI / SKY_HEIGHT;
        const double cosine = cos(angle);
        const double weight = cosine * sin(angle) * (M_PI / SKY_HEIGHT) * (2.0 * M_PI / SKY_WIDTH);
        for (uint x = 0; x < SKY_WIDTH; x++) {
            const double turn = 2.0 * M_PI * ((x + 0.5) / SKY_WIDTH - 0.5);
            const double along =
                sin(angle) * (sin(turn) * to_sun[0] - cos(turn) * to_sun[2]) + cosine * to_sun[1];
            const double gamma = acos(fmin(fmax(along, -1.0), 1.0));
            double xyy[3], rgb[3];
            for (int k = 0; k < 3; k++)
                xyy[k] = channels[k].zenith * perez(&channels[k], cosine, gamma) / at_zenith[k];
            from_xyy(rgb, xyy[1], xyy[2], 1000.0 * xyy[0]);
            set_texel(&texels[y * SKY_WIDTH + x], rgb, sky->strength);
            for (int k = 0; k < 3; k++)
                ground[k] += weight * rgb[k];
        }
    }

    find_sun(sun_rgb, theta, sky->turbidity);
    for (int k = 0; k < 3; k++)
        ground[k] = (ground[k] + sun_rgb[k] * to_sun[1]) * (GROUND_ALBEDO / M_PI);
    for (uint i = SKY_HEIGHT / 2 * SKY_WIDTH; i < SKY_HEIGHT * SKY_WIDTH; i++)
        set_texel(&texels[i], ground, sky->strength);

    sun->dir = (float4){(float)-to_sun[0], (float)-to_sun[1], (float)-to_sun[2], 0.0f};
    set_texel(&sun->color, sun_rgb, sky->strength);
}
