#include "cli/bench_table.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "core/file.h"

static struct bench_cell *add_cell(struct bench_table *table)
{
    if (table->cell_count == table->capacity) {
        const size_t capacity = table->capacity > 0 ? 2 * table->capacity : 64;
        struct bench_cell *cells = realloc(table->cells, capacity * sizeof(*cells));
        if (cells == NULL) {
            table->failed = true;
            return NULL;
        }
        table->cells = cells;
        table->capacity = capacity;
    }
    struct bench_cell *cell = &table->cells[table->cell_count++];
    *cell = (struct bench_cell){.number = NAN};
    return cell;
}

void bench_text(struct bench_table *table, const char *text)
{
    struct bench_cell *cell = add_cell(table);
    if (cell != NULL)
        snprintf(cell->text, sizeof(cell->text), "%s", text);
}

void bench_number(struct bench_table *table, double value)
{
    struct bench_cell *cell = add_cell(table);
    if (cell != NULL)
        cell->number = value;
}

static size_t row_count(const struct bench_table *table)
{
    return table->cell_count / table->column_count;
}

// What a reader sees of a cell.
static void format_cell(char *text, size_t size, const struct bench_table *table, size_t row,
                        size_t column)
{
    const struct bench_cell *cell = &table->cells[row * table->column_count + column];
    const char *format = table->columns[column].format;
    if (format == NULL)
        snprintf(text, size, "%s", cell->text);
    else if (isfinite(cell->number))
        snprintf(text, size, format, cell->number);
    else
        snprintf(text, size, "-");
}

void bench_table_json(struct json *json, const struct bench_table *table)
{
    json_array(json, table->key);
    for (size_t row = 0; row < row_count(table); row++) {
        json_object(json, NULL);
        for (size_t c = 0; c < table->column_count; c++) {
            const struct bench_cell *cell = &table->cells[row * table->column_count + c];
            if (table->columns[c].format == NULL)
                json_string(json, table->columns[c].key, cell->text);
            else
                json_double(json, table->columns[c].key, cell->number);
        }
        json_object_end(json);
    }
    json_array_end(json);
}

enum status bench_table_csv(const struct bench_table *table, const char *folder)
{
    char name[64];
    struct bench_text_file file = {0};
    snprintf(name, sizeof(name), "%s.csv", table->key);
    if (table->failed)
        return status_fail(STATUS_NO_MEMORY, "%s: not enough memory", name);
    const enum status status = bench_file_open(&file, folder, name);
    if (status != STATUS_OK)
        return status;
    for (size_t c = 0; c < table->column_count; c++)
        fprintf(file.stream, "%s%s", c > 0 ? "," : "", table->columns[c].key);
    for (size_t i = 0; i < table->cell_count; i++) {
        const struct bench_cell *cell = &table->cells[i];
        const size_t c = i % table->column_count;
        fputs(c > 0 ? "," : "\n", file.stream);
        if (table->columns[c].format == NULL)
            fprintf(file.stream, "\"%s\"", cell->text);
        else if (isfinite(cell->number))
            fprintf(file.stream, "%.9g", cell->number);
    }
    fputc('\n', file.stream);
    return bench_file_close(&file);
}

void bench_table_markdown(FILE *file, const struct bench_table *table)
{
    fprintf(file, "\n### %s\n\n|", table->title);
    for (size_t c = 0; c < table->column_count; c++)
        fprintf(file, " %s |", table->columns[c].heading);
    fprintf(file, "\n|");
    for (size_t c = 0; c < table->column_count; c++)
        fprintf(file, "%s|", table->columns[c].format != NULL ? "---:" : "---");
    for (size_t row = 0; row < row_count(table); row++) {
        fprintf(file, "\n|");
        for (size_t c = 0; c < table->column_count; c++) {
            char text[128];
            format_cell(text, sizeof(text), table, row, c);
            fprintf(file, " %s |", text);
        }
    }
    fprintf(file, "\n");
}

// Characters of the widest cell of a column, or of its key.
static int column_width(const struct bench_table *table, size_t column)
{
    size_t width = strlen(table->columns[column].key);
    for (size_t row = 0; row < row_count(table); row++) {
        char text[128];
        format_cell(text, sizeof(text), table, row, column);
        width = strlen(text) > width ? strlen(text) : width;
    }
    return (int)width;
}

void bench_table_print(FILE *file, const struct bench_table *table)
{
    fprintf(file, "%s\n", table->title);
    for (size_t row = 0; row <= row_count(table); row++) { // the keys come first
        for (size_t c = 0; c < table->column_count; c++) {
            char text[128];
            if (row == 0)
                snprintf(text, sizeof(text), "%s", table->columns[c].key);
            else
                format_cell(text, sizeof(text), table, row - 1, c);
            const int width = column_width(table, c);
            fprintf(file, "%*s  ", table->columns[c].format != NULL ? width : -width, text);
        }
        fputc('\n', file);
    }
}

void bench_table_free(struct bench_table *table)
{
    free(table->cells);
    table->cells = NULL;
    table->cell_count = table->capacity = 0;
}

void bench_json_begin(struct json *json, const char *experiment,
                      const struct lk_device_info *device)
{
    json_object(json, NULL);
    json_string(json, "experiment", experiment);
    json_string(json, "version", lk_version());
    json_object(json, "device");
    json_string(json, "platform", device->platform);
    json_string(json, "name", device->name);
    json_string(json, "driver", device->driver);
    json_string(json, "type", device->type);
    json_uint(json, "compute_units", device->compute_units);
    json_object_end(json);
}

enum status bench_json_write(struct json *json, const char *folder, const char *name)
{
    char path[4096];
    json_object_end(json);
    enum status status = json_finish(json);
    if (status == STATUS_OK)
        status = bench_path(path, sizeof(path), folder, name);
    if (status == STATUS_OK)
        status = file_write(path, json->text, json->size);
    return status;
}

enum status bench_file_open(struct bench_text_file *out, const char *folder, const char *name)
{
    const enum status status = bench_path(out->path, sizeof(out->path), folder, name);
    if (status != STATUS_OK)
        return status;
    out->stream = open_memstream(&out->text, &out->size);
    return out->stream != NULL ? STATUS_OK
                               : status_fail(STATUS_NO_MEMORY, "%s: not enough memory", out->path);
}

enum status bench_file_close(struct bench_text_file *file)
{
    const bool closed = fclose(file->stream) == 0;
    const enum status status =
        closed ? file_write(file->path, file->text, file->size)
               : status_fail(STATUS_NO_MEMORY, "%s: not enough memory", file->path);
    free(file->text);
    *file = (struct bench_text_file){0};
    return status;
}

enum status bench_path(char *out, size_t size, const char *folder, const char *name)
{
    if ((size_t)snprintf(out, size, "%s/%s", folder, name) >= size)
        return status_fail(STATUS_USAGE, "%s: the name of this folder is too long", folder);
    return STATUS_OK;
}

enum status bench_folder(const char *folder)
{
    char path[4096];
    if ((size_t)snprintf(path, sizeof(path), "%s", folder) >= sizeof(path))
        return status_fail(STATUS_USAGE, "%s: the name of this folder is too long", folder);
    for (char *slash = strchr(path + 1, '/');; slash = strchr(slash + 1, '/')) {
        if (slash != NULL)
            *slash = '\0';
        if (mkdir(path, 0777) != 0 && errno != EEXIST)
            return status_fail(STATUS_WRITE, "%s: cannot make this folder: %s", path,
                               strerror(errno));
        if (slash == NULL)
            return STATUS_OK;
        *slash = '/';
    }
}
