/**
 * @file
 * Renders against the reference images of ../shared/refs (LIGHTKILN_SHARED names the folder
 * otherwise). Without the folder they are skipped.
 *
 * Each image is rendered with several seeds, so that every block's mean comes with a standard error
 * of its own. Paths that carry much light and are rare make a block's mean too low and its error
 * far too small while none has come; a block is therefore wrong only if two independent sets of
 * seeds say so, both on the same side. That hides no fault: what is wrong stays wrong with other
 * seeds. Seeds are fixed, so what passes on a device passes there always.
 */
#ifndef TESTS_REFERENCE_H
#define TESTS_REFERENCE_H

#include <stddef.h>
#include <stdint.h>

#include "lightkiln/settings.h"

/** One line of refs.md, and how to render it. */
struct reference {
    const char *name;  // of the image
    const char *scene; // below scenes/
    uint32_t depth;
    enum lk_quantity quantity;
    enum lk_brdf brdf;
    uint32_t spp; // of each seed; 16 seeds make a set
    double noise; // RMSE left of refs.md

    // A letter for each block, row by row; '.' is judged, what else is left out. NULL: all judged.
    const char *blocks;
};

/**
 * Judges each of references [count] by image_agrees_with_its_reference(): the image's mean is
 * within 1 % of the reference's, and no 16 x 16 block's mean is off by more than four of its
 * standard errors and 1 %. So for every variant of traversal that the device has: it renders one of
 * the seeds, or two, whose blocks may be off by as much from those of the same seed.
 *
 * Then, unless it is NULL, judges `varied` by variance_falls_as_one_over_samples(): the variance of
 * random samples against the reference falls as 1 / N from 16 to 256 samples per pixel; that of
 * spread ones is less than three quarters of it at 64.
 *
 * @return What main() is to return.
 */
int references_run(const struct reference *references, size_t count,
                   const struct reference *varied);

#endif
