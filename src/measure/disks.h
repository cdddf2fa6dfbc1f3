/* disks.h: means of every free disk, gathered in the state's columns mean_* while a run measures. */
#ifndef MEASURE_DISKS_H
#define MEASURE_DISKS_H

#include "physics/work.h"

/* As watch_begin, watch_step and watch_end; no-ops unless the model asks for them. */
void disks_begin(engine *e);
void disks_step(engine *e);
void disks_end(engine *e);

#endif
