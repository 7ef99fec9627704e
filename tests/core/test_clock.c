// The clock against the sleep it measures.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <time.h>

#include "core/clock.h"

static void clock_measures_a_sleep(void **state)
{
    (void)state;
    const double before = clock_seconds();
    const struct timespec wait = {.tv_nsec = 20000000};
    nanosleep(&wait, NULL);
    const double passed = clock_seconds() - before;
    assert_true(passed >= 0.0199);
    assert_true(passed < 60.0); // a loaded machine wakes late, but not that late
}

static void clock_never_goes_back(void **state)
{
    (void)state;
    double last = clock_seconds();
    for (int i = 0; i < 10000; i++) {
        const double now = clock_seconds();
        assert_true(now >= last);
        last = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clock_measures_a_sleep),
        cmocka_unit_test(clock_never_goes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
