// The scatter kernel as GPUs have it: an item takes one path.

#define SHADE_LANES 0

#include "scatter.cl"
