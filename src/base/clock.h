/* clock.h: a monotonic clock, for progress reports and for measuring run times. */
#ifndef SLIPDISK_BASE_CLOCK_H
#define SLIPDISK_BASE_CLOCK_H

/* Returns the time in seconds since an arbitrary fixed moment; it never goes backwards. */
double clock_seconds(void);

#endif
