/**
 * @file
 * What went wrong, and what is said meanwhile.
 */
#ifndef LIGHTKILN_STATUS_H
#define LIGHTKILN_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#define LK_API __attribute__((visibility("default")))

enum lk_status {
    LK_OK,
    LK_NO_MEMORY,   // host or device memory
    LK_IO,          // a file cannot be read
    LK_WRITE,       // a file cannot be written; an old one is left alone
    LK_FORMAT,      // bad input
    LK_UNSUPPORTED, // input that needs what is not there
    LK_LIMIT,       // input larger than the engine's indices reach
    LK_NO_DEVICE,   // no OpenCL device matches
    LK_DEVICE,      // an OpenCL call failed
    LK_USAGE,       // an argument is out of range
    LK_CANCELLED    // the progress function said so; the image holds what was finished
};

/** What went wrong last on this thread; "" if nothing has. Valid until the thread's next failure.
 */
LK_API const char *lk_error(void);

/** A status as words, "out of memory". */
LK_API const char *lk_status_name(enum lk_status status);

/** "0.1.0 (commit)". */
LK_API const char *lk_version(void);

enum lk_log_level { LK_LOG_ERROR, LK_LOG_WARNING, LK_LOG_INFO, LK_LOG_DEBUG };

typedef void lk_log_function(void *user, enum lk_log_level level, const char *message);

/** Sends messages up to `level` to `function`, or to stderr if it is NULL. At the start: warnings,
 * to stderr. It is called one message at a time, during a render from any thread. */
LK_API void lk_log_set(enum lk_log_level level, lk_log_function *function, void *user);

/** Counts the warnings since the program began, shown or not. */
LK_API unsigned lk_warning_count(void);

#ifdef __cplusplus
}
#endif

#endif
