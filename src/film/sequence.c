#include "film/sequence.h"

// Samples of a pixel that lie side by side: 16 share most nodes and texels of their camera rays and
// make half a warp. On a CPU Sponza takes 17 % less time at depth 1, and 5 % less at depth 5.
#define PASS_SHIFT_MAX 4u

#define PASS_SIZE_MAX (1ull << 30) // paths of one pass, so that places fit 32 bits

// Sets the size of the pass that begins.
static void begin_pass(struct sequence *s)
{
    const uint64_t left = s->span.end_sample - s->first_sample;
    uint32_t shift = 0;
    while (shift < PASS_SHIFT_MAX && (!s->even || (2ull << shift) <= s->first_sample) &&
           (2ull << shift) <= left &&
           ((uint64_t)s->span.pixel_count << (shift + 1)) <= PASS_SIZE_MAX)
        shift++;
    s->sample_shift = shift;
    s->done = 0;
}

static uint64_t pass_size(const struct sequence *s)
{
    return (uint64_t)s->span.pixel_count << s->sample_shift;
}

void sequence_begin(struct sequence *sequence, const struct span *span, bool even)
{
    *sequence = (struct sequence){.span = *span, .first_sample = span->first_sample, .even = even};
    begin_pass(sequence);
}

bool sequence_ended(const struct sequence *s)
{
    return s->first_sample >= s->span.end_sample;
}

// Paths up to the end of the last pass that is as large as this one.
static uint64_t paths_alike(const struct sequence *s)
{
    uint64_t passes = 1;
    if (s->sample_shift == PASS_SHIFT_MAX) {
        const uint64_t left = (s->span.end_sample - s->first_sample) >> PASS_SHIFT_MAX;
        passes = left < UINT32_MAX ? left : UINT32_MAX;
    }
    return passes * pass_size(s) - s->done;
}

struct batch sequence_batch(const struct sequence *s, uint32_t paths)
{
    const uint64_t alike = paths_alike(s);
    return (struct batch){
        .first = (uint32_t)s->done,
        .first_sample = (uint32_t)s->first_sample,
        .count = paths < alike ? paths : (uint32_t)alike,
        .pixel_count = s->span.pixel_count,
        .sample_shift = s->sample_shift,
        .first_pixel = s->span.places != NULL ? 0 : s->span.first_pixel,
    };
}

void sequence_advance(struct sequence *s, const struct batch *batch)
{
    const uint64_t done = s->done + batch->count;
    const uint64_t passes = done / pass_size(s);
    s->first_sample += passes << s->sample_shift;
    s->done = done % pass_size(s);
    if (passes > 0 && s->done == 0)
        begin_pass(s);
}

uint64_t sequence_paths(const struct sequence *s)
{
    return (s->first_sample - s->span.first_sample) * s->span.pixel_count + s->done;
}

uint64_t sequence_samples(const struct sequence *s, uint32_t index)
{
    const uint64_t before = (uint64_t)index << s->sample_shift; // of the pass, before this pixel's
    const uint64_t own = s->done > before ? s->done - before : 0;
    const uint64_t most = 1ull << s->sample_shift;
    return s->first_sample + (own < most ? own : most);
}
