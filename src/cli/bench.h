/**
 * @file
 * The experiments of `lightkiln bench`, one file each.
 */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include "cli/options.h"
#include "core/status.h"

/** Section 4 of the thesis, on the scenes named or on those that scripts/make_scenes writes. */
enum status bench_report(const struct options *options);

/** Every light sampler for the same time. */
enum status bench_lights(const struct options *options);

/** Rays a second of every way to trace, for every class of rays. STATUS_DEVICE if a hit is wrong.
 */
enum status bench_trace(const struct options *options);

/** Paths a second of the whole pipeline, the thesis's way and the default one. */
enum status bench_pipeline(const struct options *options);

/** Bytes and rays a second against the size of the ray queue. */
enum status bench_memory(const struct options *options);

/** Cost against triangles, and against lights. */
enum status bench_scale(const struct options *options);

#endif
