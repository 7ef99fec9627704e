/**
 * @file
 * The JSON report of a render, and the part of it that goes into an image's header. Names never
 * change meaning; new ones may be added.
 */
#ifndef OUTPUT_REPORT_H
#define OUTPUT_REPORT_H

#include "core/json.h"
#include "lightkiln/render.h"

/**
 * Writes the whole report.
 *
 * @param json     At its start; json_finish() is called here.
 * @param version  Of the program.
 * @param write_s  Seconds spent writing image files.
 * @retval STATUS_NO_MEMORY  The text does not fit.
 */
enum status report_write(struct json *json, const struct lk_render_info *info, const char *version,
                         double write_s);

/** Writes the settings that shape the picture, as one object: not those that promise the same bits
 * whatever they are (queue, memory, cache, profile), so that equal pictures are equal files. */
void report_picture_settings(struct json *json, const char *key,
                             const struct lk_settings *settings);

#endif
