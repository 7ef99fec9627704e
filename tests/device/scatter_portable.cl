// The scatter kernel as GPUs have it: groups of items whose paths find their places together.

#define SHADE_LANES 0

#include "scatter.cl"
