/**
 * @file
 * What a sample of rays should hit, by all triangles in double precision (T. Moeller, B. Trumbore,
 * "Fast, Minimum Storage Ray/Triangle Intersection", JGT 1997).
 *
 * Devices compute in float, so a ray that runs along an edge may hit or pass. Two answers are kept:
 * the nearest hit of triangles a little larger, and that of triangles a little smaller than they
 * are. What lies between is right.
 */
#ifndef CLI_BENCH_ORACLE_H
#define CLI_BENCH_ORACLE_H

#include "cli/bench_rays.h"

/** The answers for rays 0, step, 2 step and so on of a set. All zero: none. */
struct oracle {
    double *least, *most; // [count] bounds of the nearest hit's distance, INFINITY: none; owned
    uint32_t count, step;
};

/**
 * Asks all triangles; takes all host threads for about a second.
 *
 * @param[out] out  Written on success only; release with oracle_free().
 * @retval STATUS_NO_MEMORY
 */
enum status oracle_build(struct oracle *out, const struct lk_geometry *geometry,
                         const struct ray_set *set);

/** Counts the sample's hits that cannot be right. @param hits [set->count] */
uint32_t oracle_count_wrong(const struct oracle *oracle, const struct ray_set *set,
                            const struct lk_hit *hits);

void oracle_free(struct oracle *oracle);

#endif
