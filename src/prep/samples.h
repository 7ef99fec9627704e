/**
 * @file
 * The points that samples are made of: for each block of four dimensions of a path a table of
 * Owen-scrambled Sobol points, which kernels shift apart (cl/lib/samples.h).
 *
 * Source: the first four dimensions of the sequence of S. Joe, F. Kuo, "Constructing Sobol
 * Sequences with Better Two-Dimensional Projections", SIAM J. Sci. Comput. 30(5), 2008; nested
 * uniform scrambling of A. Owen, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences", 1995; blocks
 * padded by shuffling their points, as in B. Burley, "Practical Hash-Based Owen Scrambling", JCGT
 * 9(4), 2020. Differs from Burley: the table is scrambled bit by bit on the host, once, and pixels
 * differ by a digital shift of each dimension. A shifted Owen-scrambled set is one, so that a
 * pixel's error is what it would be with a scrambling of its own, for the cost of a table's row and
 * an exclusive or.
 */
#ifndef PREP_SAMPLES_H
#define PREP_SAMPLES_H

#include "core/status.h"
#include "shared/base.h"

/**
 * Makes the table for paths of up to `depth` shaded hits.
 *
 * @param[out] out  [rng_block_count(depth) << shift], by block, then by number; for free().
 * @param seed      Other seeds scramble and shuffle otherwise.
 * @param shift     Log2 of the points of a block, 0 .. 16; 0 makes one point of zeros, which leaves
 *                  nothing but the shift, a random number of its own for every sample.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status samples_build(uint4 **out, uint seed, uint depth, uint shift);

#endif
