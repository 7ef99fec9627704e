// The JSON writer against texts written by hand and RFC 8259.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/json.h"

static void json_nests(void **state)
{
    (void)state;
    struct json json = {0};
    json_object(&json, NULL);
    json_string(&json, "a", "x");
    json_object(&json, "empty");
    json_object_end(&json);
    json_array(&json, "list");
    json_uint(&json, NULL, 1);
    json_bool(&json, NULL, true);
    json_null(&json, NULL);
    json_array_end(&json);
    json_object_end(&json);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, "{\n  \"a\": \"x\",\n  \"empty\": {},\n  \"list\": [\n    1,\n"
                                   "    true,\n    null\n  ]\n}\n");
    json_free(&json);
    assert_null(json.text);
}

static void compact_json_has_no_blanks(void **state)
{
    (void)state;
    struct json json = {.compact = true};
    json_object(&json, NULL);
    json_double(&json, "a", 0.5);
    json_array(&json, "b");
    json_uint(&json, NULL, UINT64_MAX);
    json_string(&json, NULL, NULL);
    json_array_end(&json);
    json_object_end(&json);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, "{\"a\":0.5,\"b\":[18446744073709551615,null]}");
    json_free(&json);
}

static void assert_string_becomes(const char *value, const char *expected)
{
    struct json json = {.compact = true};
    json_string(&json, NULL, value);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, expected);
    json_free(&json);
}

static void json_strings_are_escaped(void **state)
{
    (void)state;
    assert_string_becomes("", "\"\"");
    assert_string_becomes("a\"b\\c", "\"a\\\"b\\\\c\"");
    assert_string_becomes("a\nb\x01", "\"a\\u000ab\\u0001\"");
    assert_string_becomes("\xc3\xa9 \xe2\x82\xac \xf0\x9f\x94\xa5",
                          "\"\xc3\xa9 \xe2\x82\xac \xf0\x9f\x94\xa5\"");
}

static void json_strings_are_always_utf8(void **state)
{
    (void)state;
    assert_string_becomes("a\xff", "\"a\xef\xbf\xbd\"");
    assert_string_becomes("\xc3", "\"\xef\xbf\xbd\"");
    assert_string_becomes("\xc0\xaf", "\"\xef\xbf\xbd\xef\xbf\xbd\""); // overlong
    assert_string_becomes("\xed\xa0\x80", "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"");
}

static void assert_double_becomes(double value, const char *expected)
{
    struct json json = {.compact = true};
    json_double(&json, NULL, value);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, expected);
    json_free(&json);
}

static void json_numbers_are_short_and_finite(void **state)
{
    (void)state;
    assert_double_becomes(0.1, "0.1");
    assert_double_becomes(-2.0, "-2");
    assert_double_becomes(1e300, "1e+300");
    assert_double_becomes((double)NAN, "null");
    assert_double_becomes((double)-INFINITY, "null");

    struct json json = {.compact = true};
    json_float(&json, NULL, 0.1f);
    assert_int_equal(json_finish(&json), STATUS_OK);
    assert_string_equal(json.text, "0.1");
    json_free(&json);
}

static void json_numbers_come_back_exactly(void **state)
{
    (void)state;
    uint64_t bits = 0x243f6a8885a308d3u;
    for (int i = 0; i < 2000; i++) {
        bits = bits * 6364136223846793005u + 1442695040888963407u;
        double value;
        memcpy(&value, &bits, sizeof(value));
        if (!isfinite(value))
            continue;
        struct json json = {.compact = true};
        json_double(&json, NULL, value);
        assert_int_equal(json_finish(&json), STATUS_OK);
        assert_true(strtod(json.text, NULL) == value);
        json_free(&json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(json_nests),
        cmocka_unit_test(compact_json_has_no_blanks),
        cmocka_unit_test(json_strings_are_escaped),
        cmocka_unit_test(json_strings_are_always_utf8),
        cmocka_unit_test(json_numbers_are_short_and_finite),
        cmocka_unit_test(json_numbers_come_back_exactly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
