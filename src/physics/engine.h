/* engine.h: building the work of a system from model and state, and throwing it away. */
#ifndef PHYSICS_ENGINE_H
#define PHYSICS_ENGINE_H

#include "physics/work.h"

/* Fills the state of step 0 from the model: poses, slots, and the contacts that the packing brings along.
 * SD_ERROR_IO: no memory for these. */
sd_status engine_fill_state(const sd_model *model, sd_state *state);

/* Work for e->model and e->state (both set, the rest zero), up to the lists; contacts come from the state. */
sd_status engine_build(engine *e, int threads, sd_messages *messages);
void engine_free(engine *e);

/* Inverse masses and constant forces in work: 0 where a coordinate is locked or named by a motion, since what
 * it feels changes nothing, and of disks that are not in play. */
void engine_fill_constants(engine *e);

/* Does the free disk in this slot take part, wherever it is? */
static inline bool engine_in_play(const sd_state *s, size_t slot) {
  return s->activity[slot] == SD_IN_PLAY || s->activity[slot] == SD_OUTSIDE;
}

/* Where the pairs see the body in this slot, from its pose, should it be a prescribed one: free disks are seated in every
 * step. */
static inline void engine_seat(const engine *e, size_t slot) {
  const sd_state *s = e->state;
  if (slot < s->n_free) return;
  double *row = e->work.seats + SEAT_ROW * (size_t)e->work.row[slot];
  row[SEAT_X] = s->x[slot];
  row[SEAT_Y] = s->y[slot];
  row[SEAT_ARC] = s->radius[slot] * s->theta[slot];
  row[SEAT_RADIUS] = s->radius[slot];
  row[SEAT_VX] = s->vx[slot];
  row[SEAT_VY] = s->vy[slot];
}

/* About which the lengths of the region change: its lower corner. */
double engine_corner(const sd_model *model, int coordinate);
/* Edges of the periodic box in work, from model and state->box_scale. */
void engine_place_box(engine *e);

/* At step 0, once the first phase's motions run: contacts that are closed at the start begin (lambda* =
 * lambda) or, where the packing brings them along, go on; accelerations follow from the forces, and the energy
 * is noted. Contacts of the packing that do not touch are dropped, with a warning. */
sd_status engine_start(engine *e, sd_messages *messages);

#endif
