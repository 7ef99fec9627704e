/**
 * @file
 * Which form of the kernels traces which rays: what there is to choose among on a device, the rule
 * where nothing is known, and what probes (probe.h) have found before.
 *
 * A form is a layout of the BVH and a way to walk it. What a probe finds is kept as a note in the
 * build cache, by device, driver, kernel text, candidates and size of the scene, and for as long as
 * the process lives, so that equal devices that share a render trace alike.
 */
#ifndef CHOICE_H
#define CHOICE_H

#include <stdbool.h>
#include <stdint.h>

#include "device/build_cache.h"
#include "device/gpu.h"
#include "engine.h"
#include "pipeline/pipeline.h"

#define FORM_TRACES  1u // traces rays of paths
#define FORM_SHADOWS 2u // traces shadow rays
#define FORM_FOLLOWS 4u // does so, unmeasured, where later bounces are traced over its layout

struct form {
    enum lk_trace trace; // not auto
    enum lk_bvh bvh;     // not auto
    unsigned uses;       // FORM_...
    const char *more;    // options for the compiler; NULL: none. Borrowed
};

/** One device's. */
struct choice {
    struct form forms[PIPELINE_FORMS_MAX]; // if it is open, the first is the plainest, and traces
    uint32_t form_count;
    uint32_t of[RAY_CLASSES]; // index of the form that traces them
    enum lk_reason reasons[RAY_CLASSES];
    enum fusion fusion;   // what is to be one kernel, if the scene lets it
    bool open;            // a probe is to decide
    bool broken;          // it did, and nothing can be taken; choice_fall_back() is left
    struct build_key key; // of what it finds
    double probe_s;       // it took
};

/** What tests set: candidates in place of the device's own, on any device. */
extern const struct form *choice_candidates;
extern uint32_t choice_candidate_count;

/** What tests set: bounces are one kernel in scenes of any size, on CPUs, too. */
extern bool choice_always_fuses;

/**
 * Finds the forms that fit a device and the settings, and takes the rule's for all rays. On CPUs
 * paths are to be one kernel, unless a traversal is forced or kernels are to be timed, each by
 * itself.
 *
 * @param asked  The render's settings; what they force is kept.
 * @param rule   The same with what the rule takes (settings_choose_variants()).
 */
void choice_begin(struct choice *out, const struct lk_settings *asked,
                  const struct lk_settings *rule, const struct gpu *gpu);

/**
 * Takes what a probe has found before, on such a device and in such a scene, if it has.
 *
 * @param scene     Its geometry is prepared.
 * @param no_cache  Look no further than this process.
 */
void choice_recall(struct choice *choice, const struct gpu *gpu, const struct lk_scene *scene,
                   const struct lk_settings *settings);

/**
 * Lets bounces be one kernel, and settles on its form of tracing, where that pays: on GPUs in small
 * scenes with textures from the pool and no far lights, unless another form is forced or kernels
 * are to be timed, each by itself.
 *
 * @param rule  As above.
 * @return whether it does.
 */
bool choice_fuse(struct choice *choice, const struct gpu *gpu, const struct lk_scene *scene,
                 const struct lk_settings *rule);

/** Looks again, by the same key. @return whether it was found. */
bool choice_recall_again(struct choice *choice, bool no_cache);

/** Keeps what a probe has found. */
void choice_keep(const struct choice *choice, bool no_cache);

/** Forgets what this process has found; files stay. */
void choice_forget(void);

/** Settles on the plain form over the rule's layout: where others do not work. */
void choice_fall_back(struct choice *choice);

/** The layouts that are needed: all candidates' as long as the choice is open. */
unsigned choice_layouts(const struct choice *choice);

/** Whether these are several. */
bool choice_has_layouts(const struct choice *choice);

/** Lets shadow rays follow later bounces: over the same layout, if a form can. */
void choice_follow(struct choice *choice);

/** Whether a form may trace rays of a kind. */
bool form_has(const struct form *form, enum ray_class class);

/** "quad postponing". @return out. */
const char *form_name(char *out, size_t size, const struct form *form);

#endif
