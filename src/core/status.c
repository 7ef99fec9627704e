#include "core/status.h"

#include <stdarg.h>
#include <stdio.h>

// Long enough for a kernel's build log, which is the longest message there is.
static _Thread_local char message[16384];

enum status status_fail(enum status code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof(message), format, args);
    va_end(args);
    return code;
}

const char *status_message(void)
{
    return message;
}

const char *status_name(enum status code)
{
    static const char *const names[] = {
#define STATUS_NAME(code, text) text,
        STATUS_LIST(STATUS_NAME)
#undef STATUS_NAME
    };
    return (unsigned)code < sizeof(names) / sizeof(names[0]) ? names[code] : "unknown status";
}
