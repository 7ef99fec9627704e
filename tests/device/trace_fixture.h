/**
 * @file
 * Every variant of the trace kernel, and scenes uploaded for all of them.
 */
#ifndef TESTS_DEVICE_TRACE_FIXTURE_H
#define TESTS_DEVICE_TRACE_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "prep/bvh_reinsert.h"
#include "prep/sbvh.h"
#include "stage_support.h"
#include "trace_oracle.h"
#include "trace_rays.h"

#define VARIANT_COUNT 39
#define BLENDED_ALPHA 0.4
#define RAYS          2100u
#define UNTOUCHED     0xdeadbeefu // hit.triangle of slots that no ray is in

/** The materials of every scene. */
enum { SOLID, CUT_OUT, BLENDED, MATERIALS };

/** The BVHs that every scene is uploaded with. */
enum tree {
    TREE_BINARY,
    TREE_TEXTURE,
    TREE_SPLIT,
    TREE_WIDE,
    TREE_WIDE_SPLIT,
    TREE_QUAD,
    TREE_QUAD_SPLIT,
    TREE_OVER, // binary, over the triangles of the 4-wide one; with splits
    TREE_COMPRESSED,
    TREE_COMPRESSED_SPLIT,
    TREES
};

/** A variant of the trace kernel. */
struct variant {
    enum tree tree;
    struct program_options options;
    const char *source; // in tests/device/ or, if NULL, cl/trace.cl
    bool packets;       // of neighbours in the queue, on CPUs
    struct trace trace;
};

static const struct variant all_variants[VARIANT_COUNT] = {
    {.tree = TREE_BINARY, .options = {0}},
    {.tree = TREE_BINARY, .options = {.alpha = true}},
    {.tree = TREE_BINARY, .options = {.persistent = true}},
    {.tree = TREE_BINARY, .options = {.persistent = true, .alpha = true}},
    {.tree = TREE_BINARY, .options = {.persistent = true, .alpha = true}, .source = "trace_warp"},
    {.tree = TREE_SPLIT, .options = {0}},
    {.tree = TREE_SPLIT, .options = {.persistent = true, .alpha = true}},
    {.tree = TREE_OVER, .options = {0}},
    {.tree = TREE_OVER, .options = {.persistent = true, .alpha = true}},
    {.tree = TREE_WIDE, .options = {.bvh_wide = true}},
    {.tree = TREE_WIDE_SPLIT, .options = {.bvh_wide = true, .alpha = true}},
    {.tree = TREE_WIDE_SPLIT, .options = {.bvh_wide = true, .persistent = true}},
    {.tree = TREE_WIDE, .options = {.bvh_wide = true, .persistent = true, .alpha = true}},
    {.tree = TREE_WIDE_SPLIT,
     .options = {.bvh_wide = true, .alpha = true},
     .source = "trace_portable"},
    {.tree = TREE_QUAD, .options = {.bvh_quad = true}},
    {.tree = TREE_QUAD_SPLIT, .options = {.bvh_quad = true, .alpha = true}},
    {.tree = TREE_QUAD_SPLIT, .options = {.bvh_quad = true, .persistent = true}},
    {.tree = TREE_QUAD, .options = {.bvh_quad = true, .persistent = true, .alpha = true}},
    {.tree = TREE_QUAD_SPLIT, .options = {.bvh_quad = true, .warp_votes = true}},
    {.tree = TREE_QUAD,
     .options = {.bvh_quad = true, .warp_votes = true, .persistent = true, .alpha = true}},
    {.tree = TREE_COMPRESSED, .options = {.bvh_compressed = true}},
    {.tree = TREE_COMPRESSED_SPLIT, .options = {.bvh_compressed = true, .alpha = true}},
    {.tree = TREE_COMPRESSED_SPLIT, .options = {.bvh_compressed = true, .persistent = true}},
    {.tree = TREE_COMPRESSED,
     .options = {.bvh_compressed = true, .persistent = true, .alpha = true}},
    {.tree = TREE_COMPRESSED_SPLIT, .options = {.bvh_compressed = true, .warp_votes = true}},
    {.tree = TREE_COMPRESSED,
     .options = {.bvh_compressed = true, .warp_votes = true, .alpha = true}},
    {.tree = TREE_COMPRESSED,
     .options = {.bvh_compressed = true, .warp_votes = true, .persistent = true}},
    {.tree = TREE_COMPRESSED_SPLIT,
     .options = {.bvh_compressed = true, .warp_votes = true, .persistent = true, .alpha = true}},
    {.tree = TREE_WIDE, .options = {.bvh_wide = true}, .packets = true},
    {.tree = TREE_WIDE_SPLIT, .options = {.bvh_wide = true, .alpha = true}, .packets = true},
    {.tree = TREE_WIDE,
     .options = {.bvh_wide = true, .alpha = true},
     .source = "trace_portable",
     .packets = true},
    {.tree = TREE_BINARY, .options = {.warp_votes = true}},
    {.tree = TREE_SPLIT, .options = {.warp_votes = true, .alpha = true}},
    {.tree = TREE_SPLIT, .options = {.warp_votes = true, .persistent = true}},
    {.tree = TREE_BINARY, .options = {.warp_votes = true, .persistent = true, .alpha = true}},
    {.tree = TREE_TEXTURE, .options = {.nodes_image = true}},
    {.tree = TREE_TEXTURE, .options = {.nodes_image = true, .alpha = true}},
    {.tree = TREE_TEXTURE, .options = {.nodes_image = true, .persistent = true}},
    {.tree = TREE_TEXTURE, .options = {.nodes_image = true, .persistent = true, .alpha = true}},
};

/** The group's state. */
struct fixture {
    struct gpu *gpu;
    struct variant variants[VARIANT_COUNT];
    uint32_t variant_count; // those through textures come last, and need images
    struct program any_hit[TREES];
    struct wavefront wavefront; // of RAYS paths
};

/** A scene on host and device. */
struct trace_scene {
    struct geometry geometry;
    struct material materials[MATERIALS];
    struct scene_material scene_materials[MATERIALS];
    uint32_t ref_count;
    struct device_scene trees[TREES];
};

static inline bool is_wide(enum tree tree)
{
    return tree == TREE_WIDE || tree == TREE_WIDE_SPLIT;
}

static inline bool is_quad(enum tree tree)
{
    return tree == TREE_QUAD || tree == TREE_QUAD_SPLIT;
}

static inline bool is_compressed(enum tree tree)
{
    return tree == TREE_COMPRESSED || tree == TREE_COMPRESSED_SPLIT;
}

static inline bool is_split(enum tree tree)
{
    return tree == TREE_SPLIT || tree == TREE_WIDE_SPLIT || tree == TREE_QUAD_SPLIT ||
           tree == TREE_COMPRESSED_SPLIT || tree == TREE_OVER;
}

static inline enum bvh_layout layout_of(enum tree tree)
{
    return is_wide(tree)         ? LAYOUT_WIDE
           : is_quad(tree)       ? LAYOUT_QUAD
           : is_compressed(tree) ? LAYOUT_COMPRESSED
                                 : LAYOUT_BINARY;
}

static inline void build_variant(struct variant *variant, struct gpu *gpu)
{
    uint32_t built = 0;
    variant->options.ray_spans = true;
    if (variant->source == NULL) {
        assert_ok(trace_build(&variant->trace, gpu, &variant->options, &built));
        return;
    }
    struct program program = device_program(gpu, variant->source, &variant->options);
    assert_ok(kernel_create(&variant->trace.kernel, gpu, &program, "trace"));
    variant->trace.kernel.persistent = variant->options.persistent;
    variant->trace.layout = program_layout(&variant->options);
    if (variant->packets)
        assert_ok(kernel_create(&variant->trace.packets, gpu, &program, "trace_packets"));
    program_free(&program);
}

static inline struct fixture make_fixture(struct gpu *gpu)
{
    struct fixture f = {.gpu = gpu};
    const bool votes = program_takes_votes(gpu);
    for (int i = 0; i < VARIANT_COUNT; i++) {
        const struct program_options *options = &all_variants[i].options;
        if ((options->nodes_image && !gpu->info.has_images) || (options->warp_votes && !votes) ||
            (all_variants[i].packets && !gpu->info.is_cpu))
            continue;
        struct variant *variant = &f.variants[f.variant_count++];
        *variant = all_variants[i];
        build_variant(variant, gpu);
    }
    for (enum tree tree = 0; tree < TREES; tree++) {
        const struct program_options options = {.alpha = true,
                                                .bvh_wide = is_wide(tree),
                                                .bvh_quad = is_quad(tree),
                                                .bvh_compressed = is_compressed(tree)};
        if (tree != TREE_TEXTURE)
            f.any_hit[tree] = device_program(gpu, "any_hit", &options);
    }
    f.wavefront = make_wavefront(gpu, RAYS, 1);
    return f;
}

static inline void release_fixture(struct fixture *f)
{
    wavefront_free(f->gpu, &f->wavefront);
    for (int tree = 0; tree < TREES; tree++)
        program_free(&f->any_hit[tree]);
    for (uint32_t i = 0; i < f->variant_count; i++)
        trace_free(&f->variants[i].trace);
}

// Builds, packs and uploads one of a scene's BVHs.
static inline void make_tree(struct trace_scene *scene, enum tree tree, const struct fixture *f,
                             const struct tri_ref *refs)
{
    static const struct emitters no_emitters;
    static const struct light_tree no_tree;
    static const struct light_bvh no_bvh;
    static const struct environment no_environment;
    struct bvh bvh;
    struct packed_bvh packed = {0};
    struct wide_bvh wide = {0};
    struct quad_bvh quad = {0};
    struct compressed_bvh compressed = {0};
    if (is_split(tree)) {
        assert_ok(sbvh_build(&bvh, refs, scene->ref_count, &scene->geometry, 8));
        assert_ok(bvh_reinsert(&bvh, refs, &scene->geometry));
    } else {
        assert_ok(bvh_build(&bvh, refs, scene->ref_count, 8));
    }
    if (is_wide(tree))
        assert_ok(wide_bvh_pack(&wide, &bvh, refs, &scene->geometry, scene->scene_materials));
    else if (is_quad(tree) || tree == TREE_OVER)
        assert_ok(quad_bvh_pack(&quad, &bvh, refs, &scene->geometry, scene->scene_materials));
    else if (is_compressed(tree))
        assert_ok(
            compressed_bvh_pack(&compressed, &bvh, refs, &scene->geometry, scene->scene_materials));
    else
        assert_ok(bvh_pack(&packed, &bvh, refs, &scene->geometry, scene->scene_materials));
    if (tree == TREE_OVER)
        assert_ok(bvh_pack_over(&packed, &bvh, quad.places));
    const struct material_set materials = {.materials = scene->materials,
                                           .material_count = MATERIALS};
    const struct upload_source source = {.geometry = &scene->geometry,
                                         .bvh = &packed,
                                         .wide = &wide,
                                         .quad = &quad,
                                         .layouts = 1u << layout_of(tree),
                                         .compressed = &compressed,
                                         .emitters = &no_emitters,
                                         .environment = &no_environment,
                                         .light_tree = &no_tree,
                                         .light_bvh = &no_bvh,
                                         .materials = &materials};
    assert_ok(upload(&scene->trees[tree], f->gpu, &source, tree == TREE_TEXTURE, false));
    compressed_bvh_free(&compressed);
    quad_bvh_free(&quad);
    wide_bvh_free(&wide);
    packed_bvh_free(&packed);
    bvh_free(&bvh);
}

/**
 * Builds the BVHs of a geometry and uploads all; takes the geometry over.
 *
 * @param split  Threshold of early split clipping, m2; 0: none.
 */
static inline void make_scene(struct trace_scene *out, const struct fixture *f,
                              struct geometry geometry, float split)
{
    struct tri_ref *refs = NULL;
    *out = (struct trace_scene){.geometry = geometry};
    for (int i = 0; i < MATERIALS; i++)
        out->materials[i].base.w = i == SOLID ? 1.0f : (float)BLENDED_ALPHA;
    out->materials[CUT_OUT].emission.w = 0.5f; // cut-off
    out->materials[CUT_OUT].flags = MATERIAL_MASKED;
    out->materials[BLENDED].flags = MATERIAL_BLENDED;
    out->scene_materials[CUT_OUT].masked = true;
    out->scene_materials[BLENDED].blended = true;
    assert_ok(presplit(&refs, &out->ref_count, &out->geometry, split));
    assert_true(split == 0.0f || out->ref_count > geometry.triangle_count);
    for (int tree = 0; tree < TREES; tree++)
        if (tree != TREE_TEXTURE || f->gpu->info.has_images)
            make_tree(out, tree, f, refs);
    free(refs);
}

static inline void release_scene(struct trace_scene *scene, const struct fixture *f)
{
    for (int tree = 0; tree < TREES; tree++)
        device_scene_free(f->gpu, &scene->trees[tree]);
    geometry_free(&scene->geometry);
}

/** Traces rays[0 .. RAYS) by the queue's first `count` slots; hits of other slots are UNTOUCHED. */
static inline void run_variant(struct hit *hits, const struct fixture *f,
                               const struct variant *variant, const struct trace_scene *scene,
                               const struct ray *rays, const uint32_t *queue, uint32_t count)
{
    const struct wavefront *w = &f->wavefront;
    for (uint32_t i = 0; i < RAYS; i++)
        hits[i] = (struct hit){.triangle = UNTOUCHED};
    assert_ok(buffer_write(f->gpu, &w->hits, hits, RAYS * sizeof(*hits)));
    assert_ok(buffer_write(f->gpu, &w->rays, rays, RAYS * sizeof(*rays)));
    assert_ok(buffer_write(f->gpu, &w->queue[1], queue, RAYS * sizeof(*queue)));
    write_counters(f->gpu, w, 1, count);
    const struct stage_context context = {
        .gpu = f->gpu,
        .scene = &scene->trees[variant->tree],
        .wavefront = w,
        .batch = {.count = RAYS, .pixel_count = RAYS},
        .bounce = 1,
        .coherent = variant->packets,
    };
    assert_ok(trace_enqueue(&variant->trace, &context));
    assert_ok(buffer_read(f->gpu, &w->hits, hits, RAYS * sizeof(*hits)));
}

/** Asks for any hit of rays[0 .. RAYS) in one of the BVHs, not the texture. */
static inline void run_any_hit(struct hit *hits, const struct fixture *f,
                               const struct trace_scene *scene, enum tree tree,
                               const struct ray *rays)
{
    const uint32_t count = RAYS;
    assert_ok(buffer_write(f->gpu, &f->wavefront.rays, rays, RAYS * sizeof(*rays)));
    const struct kernel_arg args[] = {
        ARGS_TRACED(&scene->trees[tree], layout_of(tree)),
        ARG_BUFFER(&f->wavefront.rays),
        ARG_BUFFER(&f->wavefront.hits),
        ARG_VALUE(count),
    };
    DEVICE_RUN(f->gpu, &f->any_hit[tree], "any_hit", args, count);
    assert_ok(buffer_read(f->gpu, &f->wavefront.hits, hits, RAYS * sizeof(*hits)));
}

#endif
