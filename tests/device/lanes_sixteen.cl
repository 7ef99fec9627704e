// lib/lanes.h with sixteen lanes.

#define LANES 16

#include "lanes.cl"
