/**
 * @file
 * What is said on stderr during a render: on a terminal one line that is rewritten, else a whole
 * line every few seconds; and warnings between, which never run into that line.
 */
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include <stdbool.h>

#include "lightkiln/lightkiln.h"

struct progress {
    bool quiet;       // show no progress
    bool strict;      // a warning cancels
    bool terminal;    // stderr can rewrite a line
    bool line_shown;  // the cursor is on a progress line
    double shown_s;   // when the last whole line was printed, as lk_progress counts
    bool first_shown; // shown_s is valid
};

/** Looks at stderr. */
void progress_init(struct progress *progress, bool quiet, bool strict);

/** The progress function of a render; user is a struct progress. False once an interrupt has come,
 * or a warning if strict. */
bool progress_report(void *user, const struct lk_progress *now);

/** The log function of a render; user is a struct progress. */
void progress_log(void *user, enum lk_log_level level, const char *message);

/** Removes the progress line, if one is shown. */
void progress_end(struct progress *progress);

/** Makes SIGINT and SIGTERM be noted; a second one kills. */
void progress_catch_interrupts(void);

/** Has an interrupt come? */
bool progress_is_interrupted(void);

#endif
