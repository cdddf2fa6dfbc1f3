/* watch.h: what is counted at every measured step: sliding configurations and angles of the watched disks. */
#ifndef MEASURE_WATCH_H
#define MEASURE_WATCH_H

#include "physics/system/work.h"

/* A measured phase begins or goes on after one that was not measured. */
void watch_begin(engine *e);
/* A measured phase ends. */
void watch_end(engine *e);
/* One measured step was completed. */
void watch_step(engine *e);
/* The parts of it, for a loop that counts configurations and steps by itself: the angles, which must be new, at the
 * end of a bin; measured steps until then. */
void watch_bins(engine *e);
int64_t watch_room(const engine *e);

#endif
