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

/* How far the wall's surface is along it, counter-clockwise about a round wall. The pairs see it through lambda. */
static inline double body_surface(const sd_state *s, size_t slot) {
  return slot >= s->n_disks && s->n_surfaces > 0 ? s->surface[slot - s->n_disks] : 0.0;
}

/* Part of it stands in surface_turn, in multiples of this length, so that lambda stays small. */
static inline double body_surface_turn(const engine *e) { return 8.0 * e->work.surface_unit; }

/* R theta, and what the surface adds to it. */
static inline double body_arc(const sd_state *s, size_t slot) {
  const double arc = s->radius[slot] * s->theta[slot];
  return slot >= s->n_disks && s->n_surfaces > 0
             ? arc + (s->radius[slot] < 0.0 ? -1.0 : 1.0) * s->surface[slot - s->n_disks]
             : arc;
}

/* Its derivative. */
static inline double body_spin(const sd_state *s, size_t slot) {
  const double spin = s->radius[slot] * s->omega[slot];
  return slot >= s->n_disks && s->n_surfaces > 0
             ? spin + (s->radius[slot] < 0.0 ? -1.0 : 1.0) * s->surface_speed[slot - s->n_disks]
             : spin;
}

/* Where the pairs see the body in this slot, from its pose, should it be a prescribed one: free disks are seated in every
 * step. */
static inline void body_pack(const engine *e, size_t slot) {
  const sd_state *s = e->state;
  if (slot < s->n_free) return;
  double *row = e->work.packed + PACKED_ROW * (size_t)e->work.row[slot];
  row[PACKED_X] = s->x[slot];
  row[PACKED_Y] = s->y[slot];
  row[PACKED_ARC] = body_arc(s, slot);
  row[PACKED_RADIUS] = s->radius[slot];
  row[PACKED_VX] = s->vx[slot];
  row[PACKED_VY] = s->vy[slot];
  row[PACKED_INVERSE_MASS] = 0.0;
  row[PACKED_SPIN] = body_spin(s, slot);
}

/* About which the lengths of the region change: its lower corner. */
double box_corner(const sd_model *model, int coordinate);
/* Edges of the periodic box in work, from model and state->box_scale. */
void box_update(engine *e);

#endif
