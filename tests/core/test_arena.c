#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/arena.h"

static void memory_is_zeroed_aligned_and_apart(void **state)
{
    (void)state;
    struct arena arena = {0};
    unsigned char *pieces[200];
    // Sizes on both sides of the size from which a piece gets a block of its own.
    for (size_t i = 0; i < 200; i++) {
        const size_t size = i * i * 3 + 1;
        pieces[i] = arena_alloc(&arena, size, 1);
        assert_non_null(pieces[i]);
        assert_int_equal((uintptr_t)pieces[i] % _Alignof(max_align_t), 0);
        for (size_t k = 0; k < size; k++)
            assert_int_equal(pieces[i][k], 0);
        memset(pieces[i], (int)i + 1, size);
    }
    for (size_t i = 0; i < 200; i++) {
        assert_int_equal(pieces[i][0], (unsigned char)(i + 1));
        assert_int_equal(pieces[i][i * i * 3], (unsigned char)(i + 1));
    }
    arena_free(&arena);
    assert_null(arena.blocks);
    assert_int_equal(arena.total_size, 0);
}

static void products_that_overflow_are_refused(void **state)
{
    (void)state;
    struct arena arena = {0};
    assert_null(arena_alloc(&arena, SIZE_MAX / 2, 4));
    assert_null(arena_alloc(&arena, SIZE_MAX, 1));
    assert_null(arena_alloc(&arena, SIZE_MAX - 8, 1));
    assert_null(arena.blocks);
}

static void no_elements_are_a_pointer_and_strings_are_copied(void **state)
{
    (void)state;
    struct arena arena = {0};
    assert_non_null(arena_alloc(&arena, 0, 16));
    const char text[] = "door";
    char *copy = arena_strdup(&arena, text);
    assert_string_equal(copy, text);
    assert_ptr_not_equal(copy, text);
    arena_free(&arena);
    arena_free(&arena);
}

static void what_is_adopted_stays_as_it_is_until_the_end(void **state)
{
    (void)state;
    struct arena arena = {0};
    unsigned char *adopted[3];
    for (size_t i = 0; i < 3; i++) {
        adopted[i] = malloc(100);
        assert_non_null(adopted[i]);
        memset(adopted[i], (int)i + 1, 100);
        assert_true(arena_adopt(&arena, adopted[i], 100));
        assert_non_null(arena_alloc(&arena, 1000, 1));
    }
    assert_true(arena.total_size >= 3 * 1100);
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 100; k++)
            assert_int_equal(adopted[i][k], i + 1);
    arena_free(&arena); // and the sanitizer finds nothing left
    assert_null(arena.guests);
    assert_int_equal(arena.total_size, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_zeroed_aligned_and_apart),
        cmocka_unit_test(products_that_overflow_are_refused),
        cmocka_unit_test(no_elements_are_a_pointer_and_strings_are_copied),
        cmocka_unit_test(what_is_adopted_stays_as_it_is_until_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
