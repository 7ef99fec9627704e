#include "core/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>

static enum log_level highest_level = LOG_WARNING;
static log_function *sink;        // NULL: stderr
static void *sink_user;           // passed to sink
static atomic_uint warning_count; // warnings so far

// Several devices have a thread each.
static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;

void log_set_level(enum log_level level)
{
    highest_level = level;
}

void log_set_function(log_function *function, void *user)
{
    sink = function;
    sink_user = user;
}

unsigned log_warning_count(void)
{
    return atomic_load(&warning_count);
}

void log_message(enum log_level level, const char *format, ...)
{
    if (level == LOG_WARNING)
        atomic_fetch_add(&warning_count, 1);
    if (level > highest_level)
        return;

    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof(text), format, args);
    va_end(args);

    static const char *const prefixes[] = {"error: ", "warning: ", "", ""};
    pthread_mutex_lock(&one_at_a_time);
    if (sink != NULL)
        sink(sink_user, level, text);
    else
        fprintf(stderr, "lightkiln: %s%s\n", prefixes[level], text);
    pthread_mutex_unlock(&one_at_a_time);
}
