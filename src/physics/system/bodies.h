/* bodies.h: constants of the bodies, displacement of moving wall surfaces, packed bodies (what the
 * pair loop reads of a body), and the periodic box in work. */
#ifndef PHYSICS_BODIES_H
#define PHYSICS_BODIES_H

#include "physics/system/work.h"

/* Sets inverse masses and constant forces of the free disks in work. Inverse masses and moments of
 * inertia are 0 for coordinates that are locked or moved by a motion, since forces do not move
 * them. Inverse masses and constant forces are 0 for disks that are not in play. */
void bodies_fill_constants(engine *e);

/* True if the free disk in this slot takes part in the run: it is not waiting and has not been
 * removed. */
static inline bool body_in_play(const sd_state *s, size_t slot) {
  const int32_t a = s->activity[slot];
  return a == SD_IN_PLAY || a == SD_OUTSIDE || a == SD_HELD;
}

/* False if motions that name the body in this slot do not move it now, since it is a disk that was
 * released. */
bool body_is_moved(const engine *e, uint32_t body, size_t slot);

/* Returns the displacement of a wall's moving surface (conveyor belt, rotating drum) along the
 * wall, counter-clockwise on a round wall; 0 for disks. It enters the tangential displacement
 * lambda of contacts. */
static inline double body_surface(const sd_state *s, size_t slot) {
  return slot >= s->n_disks && s->n_surfaces > 0 ? s->surface[slot - s->n_disks] : 0.0;
}

/* Unit in which displacements of moving surfaces are wrapped: multiples of this length are kept in
 * state->surface_turn, so that lambda stays small. */
static inline double body_surface_turn(const engine *e) { return 8.0 * e->work.surface_unit; }

/* Returns the arc length R theta of a body, plus the displacement of the moving surface of a
 * wall. */
static inline double body_arc(const sd_state *s, size_t slot) {
  const double arc = s->radius[slot] * s->theta[slot];
  return slot >= s->n_disks && s->n_surfaces > 0
             ? arc + (s->radius[slot] < 0.0 ? -1.0 : 1.0) * s->surface[slot - s->n_disks]
             : arc;
}

/* Returns the time derivative of body_arc: R omega, plus the speed of the moving surface of a
 * wall. */
static inline double body_spin(const sd_state *s, size_t slot) {
  const double spin = s->radius[slot] * s->omega[slot];
  return slot >= s->n_disks && s->n_surfaces > 0
             ? spin + (s->radius[slot] < 0.0 ? -1.0 : 1.0) * s->surface_speed[slot - s->n_disks]
             : spin;
}

/* Updates the packed body (what the pair loop reads) of a prescribed body or a ghost from its pose
 * in the state. Free disks are skipped, since they are packed in every step. */
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

/* Returns one coordinate of the lower corner of the region. This corner stays fixed when the
 * lengths of the region are scaled. */
double box_corner(const sd_model *model, int coordinate);
/* Sets the edges of the periodic box and its Lees-Edwards offset in work, from the model and the
 * scales in the state. */
void box_update(engine *e);

#endif
