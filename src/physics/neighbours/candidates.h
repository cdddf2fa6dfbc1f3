/* candidates.h: the search for pairs that are near, by all threads. */
#ifndef PHYSICS_CANDIDATES_H
#define PHYSICS_CANDIDATES_H

#include "physics/neighbours/grid.h"
#include "physics/system/work.h"

/* Fills `to`, whose round pairs are complete then, with whole blocks. SD_ERROR_IO without memory. */
sd_status candidates_find(const engine *e, const grid *g, pairs *to);

#endif
