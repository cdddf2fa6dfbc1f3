/* bodies.h: what the system knows of its bodies and its box beside the state. */
#ifndef PHYSICS_BODIES_H
#define PHYSICS_BODIES_H

#include "physics/system/work.h"

/* Inverse masses and constant forces in work: 0 where a coordinate is locked or named by a motion, since what
 * it feels changes nothing, and of disks that are not in play. */
void bodies_fill_constants(engine *e);

/* Does the free disk in this slot take part, wherever it is? */
static inline bool body_in_play(const sd_state *s, size_t slot) {
  return s->activity[slot] == SD_IN_PLAY || s->activity[slot] == SD_OUTSIDE;
}

/* Where the pairs see the body in this slot, from its pose, should it be a prescribed one: free disks are seated in every
 * step. */
static inline void body_pack(const engine *e, size_t slot) {
  const sd_state *s = e->state;
  if (slot < s->n_free) return;
  double *row = e->work.packed + PACKED_ROW * (size_t)e->work.row[slot];
  row[PACKED_X] = s->x[slot];
  row[PACKED_Y] = s->y[slot];
  row[PACKED_ARC] = s->radius[slot] * s->theta[slot];
  row[PACKED_RADIUS] = s->radius[slot];
  row[PACKED_VX] = s->vx[slot];
  row[PACKED_VY] = s->vy[slot];
  row[PACKED_INVERSE_MASS] = 0.0;
}

/* About which the lengths of the region change: its lower corner. */
double box_corner(const sd_model *model, int coordinate);
/* Edges of the periodic box in work, from model and state->box_scale. */
void box_update(engine *e);

#endif
