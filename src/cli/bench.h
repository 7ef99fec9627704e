/**
 * @file
 * The experiments of `lightkiln bench`, one file each.
 */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include "cli/options.h"
#include "core/status.h"

/** Every light sampler for the same time. */
enum status bench_lights(const struct options *options);

/** Rays a second of every way to trace, for every class of rays. STATUS_DEVICE if a hit is wrong.
 */
enum status bench_trace(const struct options *options);

#endif
