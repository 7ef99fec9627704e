#include "film/noise.h"

#include <math.h>
#include <stdlib.h>

#define HALF_PIXELS   128u  // of half a tile
#define FIRST_SAMPLES 8u    // least that two estimates are compared from
#define TILES_SHARE   0.99  // of the tiles are to be below the noise
#define DARK_SHARE    0.1   // of the picture's mean: darker tiles need not be better than it
#define NOTHING       1e-30 // so that black is not divided by black
#define TIGHTER       0.9   // if every half is where it was to be, and it is not enough
#define TIGHTEST      1e-6

enum status noise_create(struct noise *out, uint32_t pixel_count, double asked)
{
    struct noise noise = {.pixel_count = pixel_count, .asked = asked, .reached = -1.0};
    noise.tile_count = ((pixel_count - 1) >> NOISE_TILE_SHIFT) + 1;
    noise.halves = calloc(noise.tile_count, 2 * sizeof(*noise.halves));
    noise.errors = calloc(noise.tile_count, sizeof(*noise.errors));
    noise.before = calloc(pixel_count, 3 * sizeof(*noise.before));
    noise.places = calloc(pixel_count, sizeof(*noise.places));
    if (noise.halves == NULL || noise.errors == NULL || noise.before == NULL ||
        noise.places == NULL) {
        noise_free(&noise);
        return status_fail(STATUS_NO_MEMORY, "no memory to estimate the noise of %u pixels",
                           pixel_count);
    }
    *out = noise;
    return STATUS_OK;
}

// The samples that a pixel has after the round that it has `samples` before.
static uint64_t next_samples(uint64_t samples)
{
    if (samples == 0)
        return 1;
    if (samples < FIRST_SAMPLES)
        return FIRST_SAMPLES;
    if (samples < 2 * FIRST_SAMPLES)
        return 2 * FIRST_SAMPLES;
    uint64_t step = 16;
    while (4 * step <= samples)
        step *= 2;
    return samples + step;
}

// The place of a half's pixel i; they lie two apart.
static uint32_t half_place(uint32_t half, uint32_t i)
{
    return (half >> 1 << NOISE_TILE_SHIFT) + 2 * i + (half & 1);
}

// Pixels of a half: fewer, or none, at the picture's end.
static uint32_t half_size(const struct noise *noise, uint32_t half)
{
    const uint32_t first = half_place(half, 0);
    if (first >= noise->pixel_count)
        return 0;
    const uint32_t count = (noise->pixel_count - first + 1) / 2;
    return count < HALF_PIXELS ? count : HALF_PIXELS;
}

static double channel(const struct film_pixel *pixel, int c)
{
    const float4 *sum = &pixel->sum;
    const float4 *carry = &pixel->carry;
    return c == 0   ? (double)sum->x - carry->x
           : c == 1 ? (double)sum->y - carry->y
                    : (double)sum->z - carry->z;
}

// Takes the measures of a half that went through a round.
static void measure(struct noise *noise, const struct canvas *canvas, uint32_t half)
{
    const uint32_t size = half_size(noise, half);
    const double first = (double)noise->round.first_sample;
    const double all = (double)noise->round.end_sample;
    const double share = first / all * (1.0 - first / all); // of (A - B)^2 that is the error
    const double scale = 1.0 / (3.0 * size);
    struct noise_half out = {.samples = (uint32_t)noise->round.end_sample};
    for (uint32_t i = 0; i < size; i++) {
        const uint32_t place = half_place(half, i);
        for (int c = 0; c < 3; c++) {
            const double sum = channel(&canvas->pixels[place], c);
            const double before = noise->before[3 * (size_t)place + c];
            const double apart = before / first - (sum - before) / (all - first);
            out.variance += scale * share * apart * apart;
            out.square += scale * (sum / all) * (sum / all);
            out.mean += scale * (sum / all);
        }
    }
    noise->halves[half] = out;
}

double noise_dark_square(double mean)
{
    return fmax(DARK_SHARE * mean * DARK_SHARE * mean, NOTHING);
}

static double dark_square(const struct noise *noise)
{
    double mean = 0.0;
    for (uint32_t h = 0; h < 2 * noise->tile_count; h++)
        mean += noise->halves[h].mean * half_size(noise, h);
    return noise_dark_square(mean / noise->pixel_count);
}

static int compare_errors(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

double noise_of_tiles(double *squared_errors, uint32_t count)
{
    qsort(squared_errors, count, sizeof(*squared_errors), compare_errors);
    return sqrt(squared_errors[(uint32_t)ceil(TILES_SHARE * count) - 1]);
}

double noise_estimate(const struct noise *noise, const struct canvas *canvas)
{
    const double dark = dark_square(noise);
    for (uint32_t tile = 0; tile < noise->tile_count; tile++) {
        double variance = 0.0;
        double square = 0.0;
        double size = 0.0;
        for (uint32_t h = 2 * tile; h < 2 * tile + 2; h++) {
            const struct noise_half *half = &noise->halves[h];
            const uint32_t count = half_size(noise, h);
            double now = 0.0; // samples of its pixels
            for (uint32_t i = 0; i < count; i++)
                now += canvas->samples[half_place(h, i)];
            if (count > 0 && half->samples == 0)
                return -1.0;
            if (count > 0)
                variance += count * half->variance * half->samples * count / now;
            square += count * half->square;
            size += count;
        }
        noise->errors[tile] = variance / fmax(square - variance, size * dark);
    }
    return noise_of_tiles(noise->errors, noise->tile_count);
}

// The squared error of a half, as its sibling tells it.
static double told_error(const struct noise *noise, uint32_t half, double dark)
{
    const uint32_t other = half_size(noise, half ^ 1u) > 0 ? half ^ 1u : half;
    const struct noise_half *from = &noise->halves[other];
    const double square = fmax(from->square - from->variance, dark);
    return from->variance / square * from->samples / noise->halves[half].samples;
}

// Marks the halves that go on: of those above the error asked for the ones with the fewest samples,
// since the pixels of a round have equally many. Returns these; UINT64_MAX if none may go on.
static uint64_t choose(struct noise *noise, uint64_t most)
{
    const double dark = dark_square(noise);
    uint64_t fewest = UINT64_MAX;
    for (double part = 1.0; fewest == UINT64_MAX && part > TIGHTEST; part *= TIGHTER)
        for (uint32_t h = 0; h < 2 * noise->tile_count; h++) {
            struct noise_half *half = &noise->halves[h];
            half->goes_on = half_size(noise, h) > 0 && half->samples < most &&
                            sqrt(told_error(noise, h, dark)) > part * noise->asked;
            if (half->goes_on && half->samples < fewest)
                fewest = half->samples;
        }
    for (uint32_t h = 0; h < 2 * noise->tile_count; h++)
        noise->halves[h].goes_on = noise->halves[h].goes_on && noise->halves[h].samples == fewest;
    return fewest;
}

// Lists the pixels of the halves that go on, and keeps their sums.
static void list(struct noise *noise, const struct canvas *canvas)
{
    uint32_t count = 0;
    for (uint32_t place = 0; place < noise->pixel_count; place++) {
        if (!noise->halves[2 * (place >> NOISE_TILE_SHIFT) + (place & 1)].goes_on)
            continue;
        for (int c = 0; c < 3; c++)
            noise->before[3 * (size_t)place + c] = (float)channel(&canvas->pixels[place], c);
        noise->places[count++] = place;
    }
    noise->round.pixel_count = count;
}

bool noise_next(struct noise *noise, const struct canvas *canvas, uint64_t most, struct span *out)
{
    struct span *round = &noise->round;
    uint64_t samples = round->end_sample;
    if (round->first_sample < FIRST_SAMPLES) {
        for (uint32_t h = 0; h < 2 * noise->tile_count; h++)
            noise->halves[h].goes_on = true;
    } else {
        for (uint32_t h = 0; h < 2 * noise->tile_count; h++)
            if (noise->halves[h].goes_on && half_size(noise, h) > 0)
                measure(noise, canvas, h);
        noise->reached = noise_estimate(noise, canvas);
        samples = noise->reached <= noise->asked ? UINT64_MAX : choose(noise, most);
    }
    if (samples >= most)
        return false;
    const uint64_t next = next_samples(samples);
    *round = (struct span){.first_sample = samples, .end_sample = next < most ? next : most};
    list(noise, canvas);
    round->places = noise->reached < 0.0 ? NULL : noise->places;
    *out = *round;
    return true;
}

void noise_free(struct noise *noise)
{
    free(noise->places);
    free(noise->before);
    free(noise->errors);
    free(noise->halves);
    *noise = (struct noise){0};
}
