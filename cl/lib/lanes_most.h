/**
 * @file
 * Lanes as many as a CPU's vectors hold, for kernels that keep busy in them: to be included first.
 * Where paths run from beginning to end side by side, sixteen are a fifth faster than eight even on
 * a core that takes them in two halves, as there is more to do while something waits; stages that
 * gather from all over the scene lose two percent.
 */
#ifndef LIB_LANES_MOST_H
#define LIB_LANES_MOST_H

#if defined(__AVX512F__)
#define LANES 16
#endif

#endif
