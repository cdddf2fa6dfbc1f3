/* sample.h: what is counted at every measured step: sliding configurations and angles of the watched disks. */
#ifndef MEASURE_SAMPLE_H
#define MEASURE_SAMPLE_H

#include "physics/system/work.h"

/* A measured phase begins or goes on after one that was not measured. */
void sample_begin(engine *e);
/* A measured phase ends. */
void sample_end(engine *e);
/* One measured step was completed. */
void sample_step(engine *e);
/* The parts of it, for a loop that counts configurations and steps by itself: the angles, which must be new, at the
 * end of a bin; measured steps until then. */
void sample_bins(engine *e);
int64_t sample_room(const engine *e);

#endif
