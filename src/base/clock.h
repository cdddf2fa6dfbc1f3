/* clock.h: a monotonic clock, for progress reports and for measuring costs. */
#ifndef SLIPDISK_BASE_CLOCK_H
#define SLIPDISK_BASE_CLOCK_H

double clock_seconds(void); /* Returns seconds since an arbitrary fixed moment; monotonic. */

#endif
