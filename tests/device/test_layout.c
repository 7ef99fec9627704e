// Host and device mean the same by every shared struct.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <string.h>

#include "layout_list.h"
#include "support.h"

// A struct (member NULL) or a member, as the host has it.
struct entry {
    const char *name, *member;
    uint32_t offset, size;
};

#define HOST_STRUCT(name) {#name, NULL, 0, sizeof(struct name)},
#define HOST_MEMBER(name, member)                                                                  \
    {#name, #member, offsetof(struct name, member), sizeof(((struct name *)NULL)->member)},

static const struct entry entries[] = {LAYOUT_LIST(HOST_STRUCT, HOST_MEMBER)};

#define ENTRY_COUNT (sizeof(entries) / sizeof(entries[0]))

static void sizes_and_offsets_are_the_same_on_the_device(void **state)
{
    struct gpu *gpu = device_of(state);
    struct program program = device_program(gpu, "layout", NULL);
    struct buffer out = device_buffer(gpu, NULL, 2 * ENTRY_COUNT * sizeof(uint32_t));
    const struct kernel_arg args[] = {ARG_BUFFER(&out)};
    uint32_t device[2 * ENTRY_COUNT];
    DEVICE_RUN(gpu, &program, "layout_write", args, 1);
    assert_ok(buffer_read(gpu, &out, device, sizeof(device)));
    for (size_t i = 0; i < ENTRY_COUNT; i++) {
        const struct entry *entry = &entries[i];
        if (device[2 * i] != entry->offset || device[2 * i + 1] != entry->size)
            fail_msg("struct %s, %s: offset %u, size %u on the device, %u, %u on the host",
                     entry->name, entry->member != NULL ? entry->member : "whole", device[2 * i],
                     device[2 * i + 1], entry->offset, entry->size);
    }
    buffer_free(gpu, &out);
    program_free(&program);
}

// Also shows that the list leaves no member out.
static void structs_have_no_hidden_padding(void **state)
{
    (void)state;
    uint32_t end = 0;
    for (size_t i = 0; i < ENTRY_COUNT; i++) {
        const struct entry *entry = &entries[i];
        if (entry->member != NULL) {
            assert_int_equal(entry->offset, end);
            end += entry->size;
        }
        if (i + 1 == ENTRY_COUNT || entries[i + 1].member == NULL) {
            size_t whole = i;
            while (entries[whole].member != NULL)
                whole--;
            assert_int_equal(entries[whole].size, end);
            end = 0;
        }
    }
}

static const char *layout_text(void)
{
    for (size_t i = 0; i < test_cl_source_count; i++)
        if (strcmp(test_cl_sources[i].name, "layout") == 0)
            return test_cl_sources[i].text;
    return NULL;
}

// The kernel's text holds all shared headers that the list includes.
static void every_shared_struct_is_in_the_list(void **state)
{
    (void)state;
    static const char mark[] = "\nSHARED_SIZE(";
    size_t found = 0;
    size_t listed = 0;
    for (size_t i = 0; i < ENTRY_COUNT; i++)
        listed += entries[i].member == NULL;
    const char *text = layout_text();
    assert_non_null(text);
    while ((text = strstr(text, mark)) != NULL) {
        text += sizeof(mark) - 1;
        const size_t length = strcspn(text, ",");
        size_t i = 0;
        while (i < ENTRY_COUNT &&
               (strlen(entries[i].name) != length || strncmp(entries[i].name, text, length) != 0))
            i++;
        if (i == ENTRY_COUNT)
            fail_msg("struct %.*s is not in LAYOUT_LIST", (int)length, text);
        found++;
    }
    assert_int_equal(found, listed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_and_offsets_are_the_same_on_the_device),
        cmocka_unit_test(structs_have_no_hidden_padding),
        cmocka_unit_test(every_shared_struct_is_in_the_list),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
