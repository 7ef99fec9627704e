/**
 * @file
 * Time that only goes forward.
 */
#ifndef CORE_CLOCK_H
#define CORE_CLOCK_H

/** Seconds since some fixed moment; for differences. */
double clock_seconds(void);

#endif
