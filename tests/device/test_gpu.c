// Choosing devices, and parts of one. PoCL is told to show its CPU twice.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device/gpu.h"
#include "support.h"

#define MAX 8

// The devices that a list names; skips the test where there are not two.
static size_t select_some(struct gpu_info *out, const char *list)
{
    size_t count = 0;
    if (gpu_describe(&out[0], 1) != STATUS_OK) {
        print_message("note: skipped, %s\n", status_message());
        skip();
    }
    assert_ok(gpu_select(out, &count, MAX, list));
    return count;
}

static bool is_same(const struct gpu_info *a, const struct gpu_info *b)
{
    return a->platform_index == b->platform_index && a->device_index == b->device_index;
}

static void devices_come_in_the_order_of_the_list_and_once(void **state)
{
    (void)state;
    struct gpu_info first[MAX], second[MAX], all[MAX], best[MAX];
    char list[64];
    const size_t count = select_some(all, "all");
    assert_in_range(count, 1, MAX);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i; j++)
            assert_false(is_same(&all[i], &all[j]));
    assert_int_equal(select_some(best, NULL), 1);
    assert_true(is_same(&best[0], &all[0]));
    if (count < 2)
        skip();
    snprintf(list, sizeof(list), "%u:%u,%u:%u", all[1].platform_index, all[1].device_index,
             all[0].platform_index, all[0].device_index);
    assert_int_equal(select_some(first, list), 2);
    assert_true(is_same(&first[0], &all[1]) && is_same(&first[1], &all[0]));

    // A word takes what the words before it have left.
    snprintf(list, sizeof(list), "%u:%u,best", all[0].platform_index, all[0].device_index);
    assert_int_equal(select_some(second, list), 2);
    assert_true(is_same(&second[1], &all[1]));
}

static void more_devices_than_may_be_taken_are_refused(void **state)
{
    (void)state;
    struct gpu_info out[MAX];
    size_t count = select_some(out, "all");
    if (count < 2)
        skip();
    assert_int_equal(gpu_select(out, &count, 1, "all"), STATUS_USAGE);
    assert_int_equal(gpu_select(out, &count, 1, "best,best"), STATUS_USAGE);
}

static void units_are_left_alone_where_a_device_can_be_parted(void **state)
{
    (void)state;
    struct gpu_info info[MAX];
    struct gpu gpu = {0};
    if (select_some(info, NULL) < 1 || info[0].compute_units < 2)
        skip();
    assert_ok(gpu_open(&gpu, &info[0], false, 1));
    assert_in_range(gpu.info.compute_units, info[0].compute_units - 1, info[0].compute_units);
    uint32_t word = 7;
    struct buffer buffer = device_buffer(&gpu, NULL, sizeof(word)); // all zero
    assert_ok(buffer_read(&gpu, &buffer, &word, sizeof(word)));
    assert_int_equal(word, 0);
    buffer_free(&gpu, &buffer);
    gpu_close(&gpu);
    assert_ok(gpu_open(&gpu, &info[0], false, info[0].compute_units)); // none would be left
    assert_int_equal(gpu.info.compute_units, info[0].compute_units);
    gpu_close(&gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(devices_come_in_the_order_of_the_list_and_once),
        cmocka_unit_test(more_devices_than_may_be_taken_are_refused),
        cmocka_unit_test(units_are_left_alone_where_a_device_can_be_parted),
    };
    setenv("POCL_DEVICES", "pthread pthread", 0); // read when PoCL starts
    return cmocka_run_group_tests(tests, NULL, NULL);
}
