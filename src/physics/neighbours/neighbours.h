/* neighbours.h: cell grid, search for pairs, and Verlet list of candidate pairs.
 *
 * The list holds every pair whose surfaces are nearer than the Verlet margin `skin`, and every
 * closed contact; it is rebuilt when a body has moved almost half the margin. Contact records are
 * carried over from the old list. A rebuild changes no bit of the results: sums run in the order of
 * slots, and an open candidate adds zero.
 */
#ifndef PHYSICS_NEIGHBOURS_H
#define PHYSICS_NEIGHBOURS_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"
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

/* Tables that follow from a list of pairs: the contacts of each body, the rows in which
 * pairs read bodies and add forces, and the division among threads.
 */

/* Builds incidence lists, chunks, and rows of packed bodies and force sums for the present pairs.
 * Returns SD_ERROR_IO if memory runs out. */
sd_status pairs_list(engine *e);
void pairs_list_free(engine *e);
/* Sets the force sums of all bodies to zero, before forces are added. */
void pairs_clear_sums(engine *e);
/* Does the same except for the rows of free disks, which are cleared when the disks are packed. */
void pairs_clear_single(engine *e);
/* Adds up the forces of single contacts on each listed body in slots [begin, end), in the order of
 * pairs; for prescribed bodies those of the contacts on all ranks. */
void sums_add_listed(const engine *e, size_t begin, size_t end);

/* Assigns slots to the free disks so that disks near each other in space are near each
 * other in memory.
 *
 * Slots are part of the state, and sums run in their order. So they change only at steps that model
 * and state determine: at the start, and where a phase begins.
 */

/* Least number of free disks that are sorted. Fewer fit into the cache in any order, and stay in
 * the order of the deck. */
enum { ORDER_LEAST = 1000 };

/* Sorts the free disks by strips across the longer side of their bounding box, and within a strip
 * by the coordinate along it. A periodic side is folded, so that strips at its two ends are
 * neighbours in memory. Disks that wait or were taken out come last, in the order of the deck. The
 * contacts in the state are sorted accordingly. Returns SD_ERROR_IO if memory runs out. */
sd_status order_disks(const sd_model *model, sd_state *state);
/* Sort key of a disk: disks in play first, then by level of size, strip, and coordinate along the
 * strip. */
typedef struct order_place {
  uint64_t strip; /* number of the strip; UINT64_MAX: the disk waits or was taken out */
  double along;
  uint32_t id, slot; /* body number, and the slot before sorting */
  uint32_t level;    /* level of size, the smallest disks first */
} order_place;
int order_by_place(const void *one, const void *two);
/* Sorts the free disks of one rank, without contacts, and returns their keys in list[n_free], by
 * which all ranks together can be sorted. c: all ranks, in a collective call; NULL: there is only
 * this one. Returns SD_ERROR_IO if memory runs out. */
sd_status order_part(const sd_model *model, sd_state *state, const comm *c, order_place *list);
/* Sorts the contacts in the state, whatever their order, as the lists of pairs are: the disk in the
 * lower slot is a, round contacts come before those with wall segments, each sorted by slots.
 * Returns SD_ERROR_IO, with nothing changed, if memory runs out. */
sd_status order_contacts(const sd_model *model, sd_state *state);

#endif
