/**
 * @file
 * Whether a caller's settings make sense, before anything is done with them, and what is taken
 * where they leave it open.
 */
#ifndef SETTINGS_H
#define SETTINGS_H

#include "core/status.h"
#include "device/gpu.h"
#include "device/program.h"
#include "lightkiln/settings.h"

/** STATUS_USAGE, naming the first setting that is out of range or does not go with another. */
enum status settings_check(const struct lk_settings *settings);

/**
 * Paths in flight on a GPU: an H100 needs 2 M rays to be full (241 Mrays/s at 32 K, 2759 at 2 M).
 * Twice as many, 185 MB more, render Sponza at 9 % more paths/s and Sibenik at 4 %; without Russian
 * roulette, 6 and 4 %. Places of paths that have ended are not given to new ones: that would bring
 * about as much, but what a path has collected must wait till it is its turn in the pixel's sum,
 * for each path that has ended another 16 bytes.
 */
#define SETTINGS_QUEUE_GPU (1u << 21)

/**
 * Paths in flight on a CPU where whole paths may be one kernel: nothing is handed on from stage to
 * stage that should stay in the last cache, and each launch leaves two cores idle for a while. Two
 * render the Cornell box at 5 % more paths/s than with a quarter of it; Sibenik, by stages, would
 * lose 3 %.
 */
#define SETTINGS_QUEUE_PATHS (252u << 10)

/** Decides on a light sampler where that is left open. */
void settings_choose_sampler(struct lk_settings *settings);

/** Decides on the rest of what is left open, by the device. */
void settings_choose_variants(struct lk_settings *settings, const struct gpu *gpu);

/**
 * Whether a device can do what was chosen.
 *
 * @retval STATUS_UNSUPPORTED  It has no warps that vote.
 */
enum status settings_check_device(const struct lk_settings *settings, const struct gpu *gpu);

/** The variant of the kernels that settings without any "auto" ask for, as far as they say. */
struct program_options settings_program_options(const struct lk_settings *settings);

#endif
