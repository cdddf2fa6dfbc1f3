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
#include "slipdisk/model.h"
#include "model/state.h"
#include "physics/neighbours/grid.h"
#include "physics/system/work.h"

/* Rebuilds the lists from the present positions: grid, candidate pairs, contacts of each body,
 * watched contacts. Returns SD_ERROR_NUMERIC if a position is not finite, SD_ERROR_IO if memory
 * runs out. */
sd_status neighbours_build(engine *e, sd_messages *messages);
/* Adapts the Verlet margin to the number of steps for which the last lists were valid, to reduce
 * the cost of lists; call it before stale lists are rebuilt. The margin changes no bit of the
 * results. Does nothing if the model sets the margin. */
void neighbours_tune(engine *e);
void neighbours_free(engine *e);
/* Adapts the lists after all lengths, the box included, were multiplied by f. Returns false if the
 * lists must be rebuilt, because pairs that were too far apart to be candidates may touch now. */
bool neighbours_rescale(engine *e, double f);
/* Makes the present shape of the box the reference shape of the lists: lists that were built for a
 * box at rest, unchanged since, remain valid when it starts to deform. */
void neighbours_follow(engine *e);
/* Call it with the step at which the periodic box has its present shape. Computes how far the
 * deforming box displaces positions from when the lists were built to the end of the following
 * step. */
void neighbours_deform(engine *e, int64_t step);
/* Checks the poses of all bodies. Returns SD_ERROR_NUMERIC, with a message that names `step`, if a
 * coordinate is not finite. */
sd_status neighbours_check_finite(const engine *e, int64_t step, sd_messages *messages);
/* Extrapolates the poses of the free disks to the next step, as the test for stale lists does.
 * Returns SD_ERROR_NUMERIC if one is not finite. */
sd_status neighbours_check_next(const engine *e, sd_messages *messages);

/* Returns true if the prescribed body in this slot has moved or turned so far since the last build
 * that the lists are stale. */
static inline bool neighbours_moved(const engine *e, uint32_t slot) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[slot] - w->x0[slot], dy = s->y[slot] - w->y0[slot], d2 = dx * dx + dy * dy;
  if (slot < s->n_disks) return !(d2 <= w->moved_limit2);
  /* For a wall, the displacement of the pivot and the displacement of its farthest point by
   * rotation may each be half of the limit. */
  double swing = (s->theta[slot] + s->turn[slot] - w->theta0[slot]) * w->reach[slot - s->n_disks];
  return !(4.0 * d2 <= w->moved_limit2 && 4.0 * swing * swing <= w->moved_limit2);
}

/* --- search for candidate pairs, by all threads ----------------------------------------------- */

/* Fills `to` with the candidate pairs. Each of the lists in it (round bodies, ghosts, wall
 * segments) begins with a new block (PAIR_BLOCK pairs); a and b are set to slots, part to the index
 * of the wall segment. Returns SD_ERROR_IO if memory runs out. */
sd_status candidates_find(const engine *e, const grid *g, pairs *to);

/* Tables computed from a list of pairs: the contacts of each body, the rows in which pairs read
 * bodies and add forces, and the division among threads. */

/* Builds these tables for the present pairs: contacts of each body, chunks, and rows of packed
 * bodies and force sums. Returns SD_ERROR_IO if memory runs out. */
sd_status pairs_list(engine *e);
void pairs_list_free(engine *e);
/* Sets the force sums of all bodies to zero, before forces are added. */
void pairs_clear_sums(engine *e);
/* Sets the other force sums to zero: those of prescribed bodies, and those of single contacts. The
 * rows of free disks are cleared when the disks are packed, that is, when their coordinates are
 * copied for the pass over pairs. */
void pairs_clear_single(engine *e);
/* For each body in slots [begin, end) for which every contact has its own row of forces, adds these
 * rows up, in the order of pairs. The sum of a prescribed body includes the contacts on all
 * ranks. */
void sums_add_listed(const engine *e, size_t begin, size_t end);
/* Clears these rows. */
void sums_clear_listed(engine *e, size_t begin, size_t end);
/* Returns the index in sums.listed of the first body in this slot or a higher one. */
size_t sums_first_listed(const sums *m, size_t slot);
/* Returns the number of rows in the table of packed bodies (work.packed): those of free disks, of
 * all other bodies, and one row for padding (pairs that fill up a block). */
size_t rows_of_bodies(const engine *e);

/* Assigns slots to the free disks so that disks near each other in space are near each other in
 * memory.
 *
 * Slots are part of the state, and forces are summed in their order. So slots change only at steps
 * that depend on nothing but model and state: at the start, and where a phase begins.
 */

/* Smallest number of free disks that are sorted. Fewer disks fit into the cache in any order; they
 * stay in the order of the deck (the input file). */
enum { ORDER_LEAST = 1000 };

/* Sorts the free disks by strips across the longer side of their bounding box, and within a strip
 * by the coordinate along it. Strips of a periodic side are interleaved, so that those at its two
 * ends are neighbours in memory. Disks that wait or were removed come last, in the order of the
 * deck. The contacts in the state are sorted accordingly. Returns SD_ERROR_IO if memory runs
 * out. */
sd_status order_disks(const sd_model *model, sd_state *state);
/* Sort key of a disk. Disks that take part in the run come first; they are sorted by level of size,
 * then strip, then coordinate along the strip. */
typedef struct order_place {
  uint64_t strip; /* number of the strip; UINT64_MAX: the disk waits or was removed */
  double along;
  uint32_t id, slot; /* number of the body, and its slot before sorting */
  uint32_t level;    /* level of size; the lowest level has the smallest disks */
} order_place;
int order_by_place(const void *one, const void *two);
/* Sorts the free disks of one rank, but not their contacts, and writes their sort keys to
 * list[n_free], from which the order of the disks of all ranks can be found. c: all ranks, in a
 * collective call; NULL: there is only this one. Returns SD_ERROR_IO if memory runs out. */
sd_status order_part(const sd_model *model, sd_state *state, const comm *c, order_place *list);
/* Sorts the contacts in the state as the lists of pairs are sorted: disk a is the one in the lower
 * slot; contacts of round bodies come before those with wall segments, each sorted by slots.
 * Returns SD_ERROR_IO, with nothing changed, if memory runs out. */
sd_status order_contacts(const sd_model *model, sd_state *state);

#endif
