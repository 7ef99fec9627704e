#include "support.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void check_ok(enum status status, const char *file, int line)
{
    if (status == STATUS_OK)
        return;
    print_error("%s: %s\n", status_name(status), status_message());
    _fail(file, line);
}

void check_close(double actual, double expected, double epsilon, const char *file, int line)
{
    if (fabs(actual - expected) <= epsilon)
        return;
    print_error("%.9g is not %.9g +- %.3g\n", actual, expected, epsilon);
    _fail(file, line);
}

void check_close3(float4 actual, const double *expected, double epsilon, const char *file, int line)
{
    if (fabs(actual.x - expected[0]) <= epsilon && fabs(actual.y - expected[1]) <= epsilon &&
        fabs(actual.z - expected[2]) <= epsilon)
        return;
    print_error("(%.9g, %.9g, %.9g) is not (%.9g, %.9g, %.9g) +- %.3g\n", actual.x, actual.y,
                actual.z, expected[0], expected[1], expected[2], epsilon);
    _fail(file, line);
}

uint32_t float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

float bits_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

int device_setup(void **state)
{
    static struct gpu gpu;
    const char *selector = getenv("LIGHTKILN_TEST_DEVICE");
    *state = NULL;
    struct gpu_info info;
    size_t count = 0;
    enum status status = gpu_select(&info, &count, 1, selector);
    if (status == STATUS_OK)
        status = gpu_open(&gpu, &info, false, 0);
    if (status == STATUS_OK) {
        *state = &gpu;
        return 0;
    }

    // A device that was asked for has to be there.
    if (status == STATUS_NO_DEVICE && selector == NULL) {
        printf("note: no OpenCL device, the tests of kernels are skipped: %s\n", status_message());
        return 0;
    }
    print_error("%s: %s\n", status_name(status), status_message());
    return -1;
}

int device_teardown(void **state)
{
    if (*state != NULL)
        gpu_close(*state);
    return 0;
}

struct gpu *device_of(void **state)
{
    if (*state == NULL)
        skip();
    return *state;
}

struct program device_program(const struct gpu *gpu, const char *name,
                              const struct program_options *options)
{
    static const struct program_options none;
    struct program program = {0};
    for (size_t i = 0; i < test_cl_source_count; i++) {
        const struct cl_source *source = &test_cl_sources[i];
        if (strcmp(source->name, name) == 0)
            assert_ok(program_build_text(&program, gpu, source->text, source->size,
                                         options != NULL ? options : &none));
    }
    assert_non_null(program.handle);
    return program;
}

struct buffer device_buffer(struct gpu *gpu, const void *data, size_t size)
{
    struct buffer buffer;
    assert_ok(buffer_create(&buffer, gpu, size, data, "a test's buffer"));
    if (data == NULL)
        assert_ok(buffer_clear(gpu, &buffer));
    return buffer;
}

void device_run(struct gpu *gpu, const struct program *program, const char *name,
                const struct kernel_arg *args, size_t arg_count, size_t items)
{
    struct kernel kernel;
    assert_ok(kernel_create(&kernel, gpu, program, name));
    assert_ok(kernel_enqueue(gpu, &kernel, args, arg_count, items));
    kernel_free(&kernel);
}
