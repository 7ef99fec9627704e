/**
 * @file
 * A table of results, which becomes JSON, a CSV file and Markdown alike.
 *
 * Cells are added row by row, in the order of the columns. Running out of memory is remembered and
 * told by the functions that write.
 */
#ifndef CLI_BENCH_TABLE_H
#define CLI_BENCH_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "core/json.h"
#include "core/status.h"
#include "lightkiln/lightkiln.h"

struct bench_column {
    const char *key;     // in JSON and CSV
    const char *heading; // in Markdown
    const char *format;  // of a double in Markdown; NULL: the column holds texts
};

struct bench_cell {
    char text[160];
    double number; // not finite: none
};

struct bench_table {
    const char *key, *title;
    const struct bench_column *columns; // [column_count]; borrowed, as the texts
    size_t column_count;
    struct bench_cell *cells; // [cell_count]; owned
    size_t cell_count, capacity;
    bool failed; // out of memory
};

/** The next cell of a text column; what does not fit is cut. */
void bench_text(struct bench_table *table, const char *text);

/** The next cell of a number column; a value that is not finite leaves it empty. */
void bench_number(struct bench_table *table, double value);

/** An array of objects, one for each row, under the table's key. */
void bench_table_json(struct json *json, const struct bench_table *table);

/** Writes FOLDER/KEY.csv. @retval STATUS_WRITE, STATUS_NO_MEMORY */
enum status bench_table_csv(const struct bench_table *table, const char *folder);

/** A heading and the table. */
void bench_table_markdown(FILE *file, const struct bench_table *table);

/** The table in columns for a terminal. */
void bench_table_print(FILE *file, const struct bench_table *table);

void bench_table_free(struct bench_table *table);

/** Begins the object that all experiments write: what was run, by which version, where. */
void bench_json_begin(struct json *json, const char *experiment,
                      const struct lk_device_info *device);

/** Ends that object and writes FOLDER/NAME; the text stays. @retval STATUS_WRITE, STATUS_NO_MEMORY
 */
enum status bench_json_write(struct json *json, const char *folder, const char *name);

/** A text in the making; it becomes a file when it is closed. */
struct bench_text_file {
    FILE *stream;
    char path[4096];
    char *text; // [size]; owned
    size_t size;
};

/** @retval STATUS_NO_MEMORY, STATUS_USAGE */
enum status bench_file_open(struct bench_text_file *out, const char *folder, const char *name);

/** Writes the file and releases all. @retval STATUS_WRITE, STATUS_NO_MEMORY */
enum status bench_file_close(struct bench_text_file *file);

/** FOLDER/NAME into `out`. @retval STATUS_USAGE  It is too long. */
enum status bench_path(char *out, size_t size, const char *folder, const char *name);

/** Makes a folder and those above it. @retval STATUS_WRITE */
enum status bench_folder(const char *folder);

#endif
