/**
 * @file
 * What the engine says while it works: warnings and notes, to stderr or to a function of the user.
 */
#ifndef CORE_LOG_H
#define CORE_LOG_H

enum log_level { LOG_ERROR, LOG_WARNING, LOG_INFO, LOG_DEBUG };

/** Receives one message without line end. */
typedef void log_function(void *user, enum log_level level, const char *message);

/** Sets the highest level that is passed on; LOG_WARNING at the start. */
void log_set_level(enum log_level level);

/** Sends messages to `function`; NULL for stderr, as at the start. */
void log_set_function(log_function *function, void *user);

/** Counts the warnings given so far in this process, shown or not: --strict looks at it. */
unsigned log_warning_count(void);

/** Passes a message on if the level is within the set one. As printf; one sentence, no line end. */
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void log_message(enum log_level level, const char *format, ...);

#endif
