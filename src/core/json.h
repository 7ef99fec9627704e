/**
 * @file
 * Writes JSON (RFC 8259) into memory: objects, arrays, strings, numbers, truths.
 *
 * Every function takes a key, which is NULL in an array and at the top. Running out of memory is
 * remembered and told once, by json_finish().
 */
#ifndef CORE_JSON_H
#define CORE_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/status.h"

/** What is written so far. All zero is a valid start, and writes one value a line. */
struct json {
    char *text; // [size] and a NUL; owned
    size_t size, capacity;
    unsigned depth; // of open objects and arrays
    bool compact;   // set it first: no line breaks, no spaces
    bool follows;   // a value stands before the next one
    bool failed;    // out of memory
};

void json_object(struct json *json, const char *key);
void json_object_end(struct json *json);
void json_array(struct json *json, const char *key);
void json_array_end(struct json *json);

/** A string, escaped; NULL becomes null. Bytes that are not UTF-8 become U+FFFD. */
void json_string(struct json *json, const char *key, const char *value);

/** The shortest digits that give the same double again; null if it is not finite. */
void json_double(struct json *json, const char *key, double value);

/** As json_double(), for the same float again. */
void json_float(struct json *json, const char *key, float value);

void json_uint(struct json *json, const char *key, uint64_t value);
void json_bool(struct json *json, const char *key, bool value);
void json_null(struct json *json, const char *key);

/** Ends the text with a line end (not a compact one). STATUS_NO_MEMORY if anything was lost. */
enum status json_finish(struct json *json);

/** As json_finish(), then prints the text on stdout, if nothing was lost, and releases it. */
enum status json_print(struct json *json);

/** Releases the text and leaves an empty one. */
void json_free(struct json *json);

#endif
