// lib/lanes.h with sixteen lanes, and without x86's instructions.

#define LANES         16
#define WIDE_PORTABLE 1

#include "lanes.cl"
