/* neighbours.h: cell grid, search for pairs, and Verlet list of candidate pairs.
 *
 * The list holds every pair nearer than the skin, and every closed contact; it is rebuilt when a body has
 * moved almost half the skin.
 * Contact memory is carried over. A rebuild changes no bit of what follows: sums run in the order of
 * slots, and a candidate that is open adds zero.
 */
#ifndef PHYSICS_NEIGHBOURS_H
#define PHYSICS_NEIGHBOURS_H

#include "physics/neighbours/grid.h"
#include "physics/system/work.h"

/* Rebuilds grid, pairs, incidence and watched contacts from the present positions. Errors: a position that
 * is not finite (SD_ERROR_NUMERIC), no memory (SD_ERROR_IO). */
sd_status neighbours_build(engine *e, sd_messages *messages);
/* Before lists are built because they are stale: a skin that costs less, by how long the last ones stood. Lists are of no
 * influence on the bits, and so is this. Nothing where the model gives the skin. */
void neighbours_tune(engine *e);
void neighbours_free(engine *e);
/* All lengths have just changed by the factor f, and the box with them. False: what was too far
 * to be a candidate may touch now, lists are to be made anew. */
bool neighbours_rescale(engine *e, double f);
/* Lists that were built for a box at rest, which has not changed since, go on in one that deforms. */
void neighbours_follow(engine *e);
/* The periodic box has the shape of this step: how far it takes positions along until the step that follows. */
void neighbours_deform(engine *e, int64_t step);
/* SD_ERROR_NUMERIC when a pose is not finite; step is the one that the message names. */
sd_status neighbours_check_finite(const engine *e, int64_t step, sd_messages *messages);
/* Of where free disks will be after the next step, as far as lists follow it. */
sd_status neighbours_check_next(const engine *e, sd_messages *messages);

/* Has the prescribed body in this slot moved or turned beyond the limit since the last build? */
static inline bool neighbours_moved(const engine *e, uint32_t slot) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[slot] - w->x0[slot], dy = s->y[slot] - w->y0[slot], d2 = dx * dx + dy * dy;
  if (slot < s->n_disks) return !(d2 <= w->moved_limit2);
  /* a wall: pivot's way and the way of its farthest point, each half of the limit */
  double swing = (s->theta[slot] + s->turn[slot] - w->theta0[slot]) * w->reach[slot - s->n_disks];
  return !(4.0 * d2 <= w->moved_limit2 && 4.0 * swing * swing <= w->moved_limit2);
}

/* --- the search for pairs that are near, by all threads --------------------------------------- */

/* Fills `to`, whose round pairs are complete then, with whole blocks. SD_ERROR_IO without memory. */
sd_status candidates_find(const engine *e, const grid *g, pairs *to);

#endif
