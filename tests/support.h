/**
 * @file
 * What all tests share: comparisons of numbers, and single kernels run on whatever OpenCL device
 * there is.
 *
 * Kernels for tests stand in tests/device/NAME.cl and include what they test from lib/ and shared/;
 * scripts/embed_cl puts them into test_cl_sources. Each runs in groups of WG_TEST items.
 */
#ifndef TESTS_SUPPORT_H
#define TESTS_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

#include "core/status.h"
#include "device/buffer.h"
#include "device/cl_sources.h"
#include "device/gpu.h"
#include "device/program.h"
#include "shared/base.h"

/** [test_cl_source_count], in the order of the names. */
extern const struct cl_source test_cl_sources[];
extern const size_t test_cl_source_count;

// ---- comparisons: they fail the test and print both sides

void check_ok(enum status status, const char *file, int line);
void check_close(double actual, double expected, double epsilon, const char *file, int line);
void check_close3(float4 actual, const double *expected, double epsilon, const char *file,
                  int line);

/** The status is STATUS_OK; else its message is printed. */
#define assert_ok(status) check_ok(status, __FILE__, __LINE__)

/** |actual - expected| <= epsilon; NaN never is. */
#define assert_close(actual, expected, epsilon)                                                    \
    check_close(actual, expected, epsilon, __FILE__, __LINE__)

/** The same for x, y and z against expected[3]. */
#define assert_close3(actual, expected, epsilon)                                                   \
    check_close3(actual, expected, epsilon, __FILE__, __LINE__)

/** The bits of a float, and a float of bits: what as_uint() and as_float() are on the device. */
uint32_t float_bits(float value);
float bits_float(uint32_t bits);

// ---- the device

/**
 * Opens the device of a group of tests: the best there is, or what LIGHTKILN_TEST_DEVICE selects.
 * Without any OpenCL device a line says so, and every test of the group is skipped.
 */
int device_setup(void **state);

/** Closes it. */
int device_teardown(void **state);

/** The group's device; skips the test if there is none. */
struct gpu *device_of(void **state);

/** Builds tests/device/NAME.cl; options may be NULL: none. */
struct program device_program(const struct gpu *gpu, const char *name,
                              const struct program_options *options);

/** Makes a buffer of `size` bytes; data may be NULL: all zero. */
struct buffer device_buffer(struct gpu *gpu, const void *data, size_t size);

/** Runs one kernel of a program once over `items` items. */
void device_run(struct gpu *gpu, const struct program *program, const char *name,
                const struct kernel_arg *args, size_t arg_count, size_t items);

/** device_run() with an array of arguments. */
#define DEVICE_RUN(gpu, program, name, args, items)                                                \
    device_run(gpu, program, name, args, sizeof(args) / sizeof((args)[0]), items)

#endif
