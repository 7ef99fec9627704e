#include "core/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void append(struct json *json, const char *bytes, size_t size)
{
    if (json->failed)
        return;
    if (json->capacity - json->size <= size) {
        const size_t capacity = 2 * json->capacity + size + 256;
        char *larger = realloc(json->text, capacity);
        if (larger == NULL) {
            json->failed = true;
            return;
        }
        json->text = larger;
        json->capacity = capacity;
    }
    memcpy(json->text + json->size, bytes, size);
    json->size += size;
    json->text[json->size] = '\0';
}

static void append_text(struct json *json, const char *text)
{
    append(json, text, strlen(text));
}

static void new_line(struct json *json)
{
    if (json->compact)
        return;
    append_text(json, "\n");
    for (unsigned i = 0; i < json->depth; i++)
        append_text(json, "  ");
}

// Bytes of the UTF-8 sequence at `s`; 0 if it is none (RFC 3629, section 4).
static size_t utf8_length(const unsigned char *s)
{
    if (s[0] < 0x80)
        return 1;
    const size_t length = s[0] >= 0xf0 ? 4 : s[0] >= 0xe0 ? 3 : 2;
    if (s[0] < 0xc2 || s[0] > 0xf4)
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((s[i] & 0xc0) != 0x80)
            return 0; // also at the NUL

    // Refuse overlong forms, surrogates and what lies past the last code point.
    const bool bad = (s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) ||
                     (s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f);
    return bad ? 0 : length;
}

static void append_string(struct json *json, const char *value)
{
    append_text(json, "\"");
    const unsigned char *s = (const unsigned char *)value;
    while (*s != '\0') {
        const size_t length = utf8_length(s);
        if (length == 0) {
            append_text(json, "\xef\xbf\xbd");
            s++;
        } else if (*s == '"' || *s == '\\') {
            const char escaped[3] = {'\\', (char)*s++, '\0'};
            append_text(json, escaped);
        } else if (*s < 0x20 || *s == 0x7f) {
            char escaped[8];
            snprintf(escaped, sizeof(escaped), "\\u%04x", *s++);
            append_text(json, escaped);
        } else {
            append(json, (const char *)s, length);
            s += length;
        }
    }
    append_text(json, "\"");
}

// Writes what stands before a value: comma, line break, key.
static void begin_value(struct json *json, const char *key)
{
    if (json->follows)
        append_text(json, ",");
    if (json->depth > 0)
        new_line(json);
    if (key != NULL) {
        append_string(json, key);
        append_text(json, json->compact ? ":" : ": ");
    }
    json->follows = true;
}

static void begin_group(struct json *json, const char *key, const char *bracket)
{
    begin_value(json, key);
    append_text(json, bracket);
    json->depth++;
    json->follows = false;
}

static void end_group(struct json *json, const char *bracket)
{
    json->depth--;
    if (json->follows)
        new_line(json);
    append_text(json, bracket);
    json->follows = true;
}

void json_object(struct json *json, const char *key)
{
    begin_group(json, key, "{");
}

void json_object_end(struct json *json)
{
    end_group(json, "}");
}

void json_array(struct json *json, const char *key)
{
    begin_group(json, key, "[");
}

void json_array_end(struct json *json)
{
    end_group(json, "]");
}

void json_string(struct json *json, const char *key, const char *value)
{
    if (value == NULL) {
        json_null(json, key);
        return;
    }
    begin_value(json, key);
    append_string(json, value);
}

// Writes digits with a point, whatever the locale's decimal mark is.
static void append_number(struct json *json, const char *key, char *digits)
{
    begin_value(json, key);
    for (char *c = digits; *c != '\0'; c++)
        if (strchr("0123456789+-e", *c) == NULL)
            *c = '.';
    append_text(json, digits);
}

void json_double(struct json *json, const char *key, double value)
{
    if (!isfinite(value)) {
        json_null(json, key);
        return;
    }
    char digits[40];
    for (int precision = 15; precision <= 17; precision++) {
        snprintf(digits, sizeof(digits), "%.*g", precision, value);
        if (strtod(digits, NULL) == value)
            break;
    }
    append_number(json, key, digits);
}

void json_float(struct json *json, const char *key, float value)
{
    if (!isfinite(value)) {
        json_null(json, key);
        return;
    }
    char digits[40];
    for (int precision = 6; precision <= 9; precision++) {
        snprintf(digits, sizeof(digits), "%.*g", precision, (double)value);
        if (strtof(digits, NULL) == value)
            break;
    }
    append_number(json, key, digits);
}

void json_uint(struct json *json, const char *key, uint64_t value)
{
    char digits[24];
    snprintf(digits, sizeof(digits), "%llu", (unsigned long long)value);
    append_number(json, key, digits);
}

void json_bool(struct json *json, const char *key, bool value)
{
    begin_value(json, key);
    append_text(json, value ? "true" : "false");
}

void json_null(struct json *json, const char *key)
{
    begin_value(json, key);
    append_text(json, "null");
}

enum status json_finish(struct json *json)
{
    if (!json->compact)
        append_text(json, "\n");
    if (json->failed)
        return status_fail(STATUS_NO_MEMORY, "not enough memory for a report");
    return STATUS_OK;
}

enum status json_print(struct json *json)
{
    const enum status status = json_finish(json);
    if (status == STATUS_OK)
        fputs(json->text, stdout);
    json_free(json);
    return status;
}

void json_free(struct json *json)
{
    free(json->text);
    *json = (struct json){.compact = json->compact};
}
