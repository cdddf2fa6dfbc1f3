/* settle.h: is a packing at rest? (sd_settle in model.h) */
#ifndef PACK_SETTLE_H
#define PACK_SETTLE_H

#include "physics/work.h"

/* Kinetic energy per free disk in play; mean resultant force on one (contacts, gravity, body forces) over the
 * mean normal force of a closed contact, 0 when there is neither, infinite without contacts. */
typedef struct settle_measure {
  double kinetic, unbalanced;
} settle_measure;

settle_measure settle_look(const engine *e);
/* All criteria of the running phase hold. */
bool settle_reached(const engine *e);

#endif
