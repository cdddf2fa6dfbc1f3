/* neighbours.h: cell grid, search for pairs, and Verlet list of candidate pairs.
 *
 * The list holds every pair whose surfaces are nearer than the Verlet margin `skin`, and every
 * closed contact; it is rebuilt when a body has moved almost half the margin. Contact records are
 * carried over from the old list. A rebuild changes no bit of the results: sums run in the order of
 * slots, and an open candidate adds zero.
 */
#ifndef PHYSICS_NEIGHBOURS_H
#define PHYSICS_NEIGHBOURS_H

#include "physics/neighbours/grid.h"
#include "physics/system/work.h"

/* Rebuilds grid, candidate pairs, incidence lists and watched contacts from the present positions.
 * Returns SD_ERROR_NUMERIC if a position is not finite, SD_ERROR_IO if memory runs out. */
sd_status neighbours_build(engine *e, sd_messages *messages);
/* Adapts the Verlet margin, so that lists cost less, to the number of steps that the last lists
 * were valid; call it before stale lists are rebuilt. The margin has no influence on the bits of
 * results. Does nothing if the model sets the margin. */
void neighbours_tune(engine *e);
void neighbours_free(engine *e);
/* Adapts the lists after all lengths, the box included, were multiplied by f. Returns false if the
 * lists must be rebuilt, because pairs that were too far apart to be candidates may touch now. */
bool neighbours_rescale(engine *e, double f);
/* Makes the present shape of the box the reference shape of the lists: lists that were built for a
 * box at rest, unchanged since, remain valid when it starts to deform. */
void neighbours_follow(engine *e);
/* Sets the step at which the periodic box has its present shape, and from it how far the deforming
 * box will displace positions, relative to the lists, until the following step. */
void neighbours_deform(engine *e, int64_t step);
/* Returns SD_ERROR_NUMERIC if a pose of any body is not finite; the message names `step`. */
sd_status neighbours_check_finite(const engine *e, int64_t step, sd_messages *messages);
/* Returns SD_ERROR_NUMERIC if a pose that free disks will have after the next step, extrapolated as
 * the test for stale lists does, is not finite. */
sd_status neighbours_check_next(const engine *e, sd_messages *messages);

/* Returns true if the prescribed body in this slot has moved or turned so far since the last build
 * that the lists are stale. */
static inline bool neighbours_moved(const engine *e, uint32_t slot) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[slot] - w->x0[slot], dy = s->y[slot] - w->y0[slot], d2 = dx * dx + dy * dy;
  if (slot < s->n_disks) return !(d2 <= w->moved_limit2);
  /* A wall: the displacement of its pivot and that of its farthest point by rotation may each be
   * half of the limit. */
  double swing = (s->theta[slot] + s->turn[slot] - w->theta0[slot]) * w->reach[slot - s->n_disks];
  return !(4.0 * d2 <= w->moved_limit2 && 4.0 * swing * swing <= w->moved_limit2);
}

/* --- search for candidate pairs, by all threads ----------------------------------------------- */

/* Fills `to` with the candidate pairs, each list ending with a padded block: a and b are slots,
 * part is the wall segment. Returns SD_ERROR_IO if memory runs out. */
sd_status candidates_find(const engine *e, const grid *g, pairs *to);

#endif
