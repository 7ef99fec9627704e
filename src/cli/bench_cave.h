/**
 * @file
 * A scene of any size: a cave with rough walls, seen from inside, lit by small triangles before its
 * walls.
 *
 * However many lights there are, they send the same light together.
 */
#ifndef CLI_BENCH_CAVE_H
#define CLI_BENCH_CAVE_H

#include <stdint.h>

#include "core/status.h"

/**
 * Writes the cave as a GLB file.
 *
 * @param triangles  About as many the walls have, 100 .. 10^8.
 * @param lights     1 .. 10^7.
 * @retval STATUS_WRITE, STATUS_NO_MEMORY
 */
enum status bench_cave_write(const char *path, uint32_t triangles, uint32_t lights);

#endif
