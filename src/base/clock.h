/* clock.h: time that passes, for progress and costs. */
#ifndef SLIPDISK_BASE_CLOCK_H
#define SLIPDISK_BASE_CLOCK_H

double clock_seconds(void); /* monotonic */

#endif
