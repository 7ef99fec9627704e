/**
 * @file
 * How failures travel: a code that is returned, and one message that is said where the failure is
 * known.
 *
 * Whoever detects a failure returns status_fail(code, "what, which, why"). All above pass the code
 * on. The message belongs to the thread and is printed once, by main.
 */
#ifndef CORE_STATUS_H
#define CORE_STATUS_H

// code, name of the code
#define STATUS_LIST(X)                                                                             \
    X(OK, "ok")                                                                                    \
    X(NO_MEMORY, "out of memory")                                                                  \
    X(IO, "cannot read")                                                                           \
    X(WRITE, "cannot write")                                                                       \
    X(FORMAT, "bad input")                                                                         \
    X(UNSUPPORTED, "unsupported input")                                                            \
    X(LIMIT, "limit exceeded")                                                                     \
    X(NO_DEVICE, "no usable device")                                                               \
    X(DEVICE, "device failure")                                                                    \
    X(USAGE, "wrong usage")                                                                        \
    X(CANCELLED, "cancelled")

enum status {
#define STATUS_ENUM(code, text) STATUS_##code,
    STATUS_LIST(STATUS_ENUM)
#undef STATUS_ENUM
};

/**
 * Keeps a message for the thread and returns `code`, so that a failure is one line: return
 * status_fail(...).
 *
 * @param code    Not STATUS_OK.
 * @param format  As printf; names the thing (file, mesh, material, call) and, where there is one,
 * the fix. No full stop.
 */
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
enum status
status_fail(enum status code, const char *format, ...);

/** The message of the thread's last failure; "" if there was none. Valid until the next
 * status_fail(). */
const char *status_message(void);

/** The name of a code, as "out of memory". Never NULL. */
const char *status_name(enum status code);

#endif
