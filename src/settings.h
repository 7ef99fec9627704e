/**
 * @file
 * Whether a caller's settings make sense, before anything is done with them.
 */
#ifndef SETTINGS_H
#define SETTINGS_H

#include "core/status.h"
#include "lightkiln/lightkiln.h"

/** STATUS_USAGE, naming the first setting that is out of range or does not go with another. */
enum status settings_check(const struct lk_settings *settings);

#endif
