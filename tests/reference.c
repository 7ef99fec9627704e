#include "reference.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render_support.h"

#define BLOCK          16   // pixels on a side
#define SEEDS          16   // renders of one set
#define MEAN_ALLOWED   0.01 // of the reference's mean, for the image and on top of a block's error
#define ERRORS_ALLOWED 4.0  // standard errors of a block

// Where a block was black in every render, its standard error says nothing: light that none of its
// 16,384 samples or more has met may be there, up to this share of the image's mean.
#define UNSEEN_ALLOWED 1e-3

// A reference image and its scene, opened.
struct subject {
    const struct reference *reference;
    struct lk_scene *scene;
    struct lk_image *image;
    uint32_t width, height, columns, block_count;
    double *truth;       // [block_count] block means of the reference; owned
    double *values;      // [block_count * SEEDS] block means of the renders; owned
    double *misses;      // [block_count] difference over what is allowed, signed; owned
    uint32_t first_seed; // of the values
};

// ---- Blocks

static bool is_left_out(const struct subject *s, uint32_t block)
{
    return s->reference->blocks != NULL && s->reference->blocks[block] != '.';
}

// Number of pixels: those at the bottom and on the right may be cut.
static uint32_t block_pixels(const struct subject *s, uint32_t block)
{
    const uint32_t x = block % s->columns * BLOCK;
    const uint32_t y = block / s->columns * BLOCK;
    const uint32_t width = s->width - x < BLOCK ? s->width - x : BLOCK;
    const uint32_t height = s->height - y < BLOCK ? s->height - y : BLOCK;
    return width * height;
}

// Means over the pixels and channels of each block, to out[block * stride].
static void find_block_means(double *out, uint32_t stride, const struct subject *s,
                             const struct lk_image *image)
{
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    for (uint32_t i = 0; i < s->block_count; i++)
        out[(size_t)i * stride] = 0.0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const uint32_t block = y / BLOCK * s->columns + x / BLOCK;
            const float *p = pixels + 3 * ((size_t)y * width + x);
            out[(size_t)block * stride] +=
                ((double)p[0] + p[1] + p[2]) / (3.0 * block_pixels(s, block));
        }
}

// Mean of the image as blocks tell it, those left out excepted.
static double find_mean(const struct subject *s, const double *means, uint32_t stride)
{
    double sum = 0.0;
    double pixels = 0.0;
    for (uint32_t i = 0; i < s->block_count; i++) {
        if (is_left_out(s, i))
            continue;
        sum += means[(size_t)i * stride] * block_pixels(s, i);
        pixels += block_pixels(s, i);
    }
    return sum / pixels;
}

// ---- Opening

static const char *shared_path(char *out, size_t size, const char *folder, const char *name,
                               const char *extension)
{
    const char *shared = getenv("LIGHTKILN_SHARED");
    snprintf(out, size, "%s/%s/%s%s", shared != NULL ? shared : "../shared", folder, name,
             extension);
    return out;
}

static void open_subject(struct subject *s, const struct reference *reference)
{
    char path[512];
    *s = (struct subject){.reference = reference};
    skip_without_device();
    shared_path(path, sizeof(path), "refs", reference->name, ".exr");
    if (access(path, R_OK) != 0) {
        print_message("note: skipped, there is no %s\n", path);
        skip();
    }
    if (lk_image_read(&s->image, path) != LK_OK ||
        lk_scene_load(&s->scene, shared_path(path, sizeof(path), "scenes", reference->scene, "")) !=
            LK_OK)
        fail_msg("%s", lk_error());
    lk_image_pixels(s->image, &s->width, &s->height);
    s->columns = (s->width + BLOCK - 1) / BLOCK;
    s->block_count = s->columns * ((s->height + BLOCK - 1) / BLOCK);
    if (reference->blocks != NULL)
        assert_int_equal(strlen(reference->blocks), s->block_count);
    s->truth = calloc(s->block_count, sizeof(*s->truth));
    s->values = calloc((size_t)s->block_count * SEEDS, sizeof(*s->values));
    s->misses = calloc(s->block_count, sizeof(*s->misses));
    assert_true(s->truth != NULL && s->values != NULL && s->misses != NULL);
    find_block_means(s->truth, 1, s, s->image);
}

static void close_subject(struct subject *s)
{
    free(s->misses);
    free(s->values);
    free(s->truth);
    lk_scene_free(s->scene);
    lk_image_free(s->image);
}

static struct lk_settings subject_settings(const struct subject *s, uint32_t spp)
{
    struct lk_settings settings = test_settings(s->width, s->height, spp);
    settings.depth = s->reference->depth;
    settings.quantity = s->reference->quantity;
    settings.brdf = s->reference->brdf;
    return settings;
}

// ---- Laws

// Renders one set of seeds, SEEDS from the first on. Returns the mean and its error.
static struct estimate render_set(struct subject *s, uint32_t first_seed)
{
    double means[SEEDS];
    struct lk_settings settings = subject_settings(s, s->reference->spp);
    s->first_seed = first_seed;
    for (uint32_t i = 0; i < SEEDS; i++) {
        settings.seed = first_seed + i;
        struct lk_image *image = render(s->scene, &settings);
        find_block_means(s->values + i, SEEDS, s, image);
        means[i] = find_mean(s, s->values + i, SEEDS);
        lk_image_free(image);
    }
    return estimate_values(means, SEEDS);
}

// By how many times what is allowed a block of the last set is off.
static double find_miss(const struct subject *s, uint32_t block, double image_mean)
{
    const struct estimate seen = estimate_values(s->values + (size_t)block * SEEDS, SEEDS);
    const double truth = s->truth[block];
    const double noise = s->reference->noise / sqrt(block_pixels(s, block)); // of the reference
    double allowed =
        ERRORS_ALLOWED * sqrt(seen.error * seen.error + noise * noise) + MEAN_ALLOWED * truth;
    if (seen.mean == 0.0)
        allowed = fmax(allowed, UNSEEN_ALLOWED * image_mean);
    return allowed > 0.0 ? (seen.mean - truth) / allowed : 0.0;
}

// Judges the last set. A block keeps the smaller of its misses if both are on one side, else none.
// Returns the worst block.
static uint32_t judge_blocks(struct subject *s, double image_mean, bool first)
{
    uint32_t worst = 0;
    for (uint32_t i = 0; i < s->block_count; i++) {
        const double miss = is_left_out(s, i) ? 0.0 : find_miss(s, i, image_mean);
        const double before = s->misses[i];
        if (first)
            s->misses[i] = miss;
        else
            s->misses[i] = miss * before < 0.0 ? 0.0 : fabs(miss) < fabs(before) ? miss : before;
        if (fabs(s->misses[i]) > fabs(s->misses[worst]))
            worst = i;
    }
    return worst;
}

// Renders one seed of the last set by a variant, which takes the same paths but for the few that
// rounding sends another way. Finds by how many times what its reference is allowed each block is
// off the set's own render.
static enum lk_status find_variant_misses(double *misses, const struct subject *s,
                                          const struct lk_settings *variant, uint32_t index)
{
    struct lk_image *image = NULL;
    struct lk_settings settings = *variant;
    settings.seed = s->first_seed + index;
    const enum lk_status status = lk_render(&image, s->scene, &settings, NULL);
    if (status != LK_OK)
        return status;
    find_block_means(misses, 1, s, image);
    for (uint32_t i = 0; i < s->block_count; i++) {
        const double *values = s->values + (size_t)i * SEEDS;
        const double error = estimate_values(values, SEEDS).error;
        const double allowed = ERRORS_ALLOWED * error + MEAN_ALLOWED * s->truth[i];
        const double off = misses[i] - values[index];
        misses[i] = is_left_out(s, i) || off == 0.0 ? 0.0 : off / allowed;
    }
    lk_image_free(image);
    return LK_OK;
}

// Judges a variant. As for the reference, a block is wrong only if two seeds say so, both on one
// side: one path that carries much light may go another way. Returns the number of variants judged:
// none if the device does not have this one.
static uint32_t judge_variant(const struct subject *s, const struct lk_settings *variant)
{
    double *misses = calloc(2 * (size_t)s->block_count, sizeof(*misses));
    assert_non_null(misses);
    double *others = misses + s->block_count;
    enum lk_status status = find_variant_misses(misses, s, variant, 0);
    bool is_off = false;
    for (uint32_t i = 0; i < s->block_count && status == LK_OK; i++)
        is_off = is_off || !(fabs(misses[i]) <= 1.0);
    if (is_off)
        status = find_variant_misses(others, s, variant, 1);
    for (uint32_t i = 0; i < s->block_count && is_off && status == LK_OK; i++)
        if (!(fabs(misses[i]) <= 1.0) && !(fabs(others[i]) <= 1.0) &&
            !(misses[i] * others[i] < 0.0))
            fail_msg("%s, trace %d, BVH %d, build %d, nodes %d, textures %d: block (%u, %u) is "
                     "%.2f and %.2f times as far off as is allowed",
                     s->reference->name, variant->trace, variant->bvh, variant->bvh_build,
                     variant->nodes, variant->textures, i % s->columns, i / s->columns, misses[i],
                     others[i]);
    free(misses);
    if (status != LK_OK && status != LK_UNSUPPORTED)
        fail_msg("%s", lk_error());
    return status == LK_OK;
}

// Judges every form of the kernels over every layout of the BVH, then the thesis's: its builder,
// its queue, nodes and materials in textures. Returns their number.
static uint32_t judge_variants(const struct subject *s)
{
    uint32_t count = 0;
    struct lk_settings variant = subject_settings(s, s->reference->spp);
    for (variant.bvh = LK_BVH_BINARY; variant.bvh <= LK_BVH_COMPRESSED; variant.bvh++)
        for (variant.trace = LK_TRACE_SIMPLE; variant.trace <= LK_TRACE_WARPS; variant.trace++)
            count += judge_variant(s, &variant);
    variant.bvh = LK_BVH_BINARY;
    variant.trace = LK_TRACE_PERSISTENT;
    variant.bvh_build = LK_BVH_BUILD_THESIS;
    variant.nodes = LK_NODES_TEXTURE;
    variant.textures = LK_TEXTURES_BOUND;
    return count + judge_variant(s, &variant);
}

static void image_agrees_with_its_reference(void **state)
{
    struct subject s;
    open_subject(&s, *state);
    const char *name = s.reference->name;
    const double truth = find_mean(&s, s.truth, 1);

    // Judge by one set of seeds, and if a block is off, by another.
    struct estimate mean = render_set(&s, 1);
    uint32_t worst = judge_blocks(&s, truth, true);
    int sets = 1;
    if (fabs(s.misses[worst]) > 1.0) {
        const struct estimate other = render_set(&s, 1 + SEEDS);
        mean.mean = 0.5 * (mean.mean + other.mean);
        mean.error = 0.5 * hypot(mean.error, other.error);
        worst = judge_blocks(&s, truth, false);
        sets = 2;
    }
    print_message("note: %s: mean %+.2f %% +- %.2f; worst block (%u, %u) %+.2f of what is allowed, "
                  "%d set(s); %u variants\n",
                  name, 100.0 * (mean.mean / truth - 1.0), 100.0 * mean.error / truth,
                  worst % s.columns, worst / s.columns, s.misses[worst], sets, judge_variants(&s));
    if (!(fabs(mean.mean - truth) <= MEAN_ALLOWED * truth))
        fail_msg("%s: the mean is %g, the reference's %g", name, mean.mean, truth);
    if (!(fabs(s.misses[worst]) <= 1.0))
        fail_msg("%s: block (%u, %u) is %.2f times as far off as is allowed", name,
                 worst % s.columns, worst / s.columns, fabs(s.misses[worst]));
    close_subject(&s);
}

// The variance against the reference (thesis section 4.2.2) less the reference's own.
static double find_variance(struct subject *s, enum lk_sampler sampler, uint32_t spp)
{
    struct lk_settings settings = subject_settings(s, spp);
    struct lk_comparison comparison;
    settings.sampler = sampler;
    settings.seed = 1000 + spp; // independent renders
    struct lk_image *image = render(s->scene, &settings);
    assert_int_equal(lk_compare(&comparison, NULL, image, s->image), LK_OK);
    lk_image_free(image);
    return comparison.variance - 3.0 * s->reference->noise * s->reference->noise;
}

static void variance_falls_as_one_over_samples(void **state)
{
    struct subject s;
    open_subject(&s, *state);
    const double v16 = find_variance(&s, LK_SAMPLER_RANDOM, 16);
    const double v64 = find_variance(&s, LK_SAMPLER_RANDOM, 64);
    const double v256 = find_variance(&s, LK_SAMPLER_RANDOM, 256);
    const double spread64 = find_variance(&s, LK_SAMPLER_SOBOL, 64);
    const double slope = log(v256 / v16) / log(16.0);
    print_message("note: variance with 16, 64, 256 spp: %.3g, %.3g, %.3g, slope %.3f; with 64 "
                  "spread ones %.3g\n",
                  v16, v64, v256, slope, spread64);

    // 65,536 pixels give each variance to 1 %, and so the slope over a factor of 16 to 0.005 and
    // over one of 4 to 0.01; four times that is allowed.
    assert_true(fabs(slope + 1.0) < 0.02);
    assert_true(fabs(log(v64 / v16) / log(4.0) + 1.0) < 0.04);
    assert_true(spread64 < 0.75 * v64);
    close_subject(&s);
}

int references_run(const struct reference *references, size_t count, const struct reference *varied)
{
    struct CMUnitTest tests[count + (varied != NULL)];
    for (size_t i = 0; i < count; i++)
        tests[i] = (struct CMUnitTest)cmocka_unit_test_prestate(image_agrees_with_its_reference,
                                                                (void *)&references[i]);
    if (varied != NULL)
        tests[count] = (struct CMUnitTest)cmocka_unit_test_prestate(
            variance_falls_as_one_over_samples, (void *)varied);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
