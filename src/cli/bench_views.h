/**
 * @file
 * Views from many places of a level, so that what is measured does not hang on one camera.
 *
 * Places are found by paths of the camera's: half way along segments between their second and their
 * third hit, which lie inside whatever the level encloses. Each view is the one that sees farthest,
 * on average and with a miss seeing nothing, of a few places and eight level headings: a view that
 * mostly looks out of the level is hardly ever it. It spans 90 degrees and is square.
 */
#ifndef CLI_BENCH_VIEWS_H
#define CLI_BENCH_VIEWS_H

#include "cli/bench_rays.h"

/**
 * Makes the rays of views: as many squares as fit the tracer's image, one after the other, each in
 * Morton order. The same segments give the same rays.
 *
 * @param[out] out  To be freed; written on success only.
 * @param segments  The rays that places are on; they and their hits are in the paths' order.
 * @param hits      [segments->count]
 * @param views     1 at least.
 * @retval STATUS_USAGE  The tracer's image is too small for so many.
 * @retval STATUS_UNSUPPORTED  No segment has a hit.
 */
enum status views_make(struct ray_set *out, struct lk_tracer *tracer,
                       const struct ray_set *segments, const struct lk_hit *hits, uint32_t views);

#endif
