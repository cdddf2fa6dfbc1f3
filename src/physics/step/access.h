/* access.h: what measuring, packing and running see of a system. `work` is the engine's own: outside physics/ nothing
 * reaches into it (tests/docs/test_floors.py). Inline: some of this is read in every step.
 *
 * Candidates are pairs near enough to touch, in a fixed order; open ones have no overlap and no force.
 */
#ifndef PHYSICS_ACCESS_H
#define PHYSICS_ACCESS_H

#include <math.h>

#include "model/law_features.h"
#include "model/normal_laws.h"
#include "physics/contact/pairs.h"
#include "physics/system/kernels.h"
#include "physics/system/work.h"

/* --- bodies and box ------------------------------------------------------------------------------------ */

/* SLOT_NONE: the body is on another rank. */
static inline uint32_t engine_slot(const engine *e, uint32_t body) {
  return slot_of(&e->work.slots, body);
}
static inline const slot_table *engine_slots(const engine *e) { return &e->work.slots; }
/* Of the periodic box as it is now; 0 where it is open. */
static inline double engine_length(const engine *e, int c) { return e->work.length[c]; }
static inline double engine_lower(const engine *e, int c) { return e->work.lower[c]; }
static inline bool engine_beyond(const engine *e, int c, double x) {
  return x < e->work.lower[c] || x >= e->work.upper[c];
}
/* Difference of two coordinates to the nearest image. */
static inline double engine_nearest(const engine *e, int c, double d) {
  return e->work.periodic[c] ? d - e->work.length[c] * nearbyint(d * e->work.inverse_length[c]) : d;
}
/* Coordinate c of the free disks, and what pushes it. */
static inline const columns *engine_columns(const engine *e, int c) { return &e->work.columns[c]; }
/* The same of the clumps. Disks of a clump are free disks that nothing pushes: no inverse masses. */
static inline size_t engine_clumps(const engine *e) { return e->work.clumps.count; }
static inline const columns *engine_clump_columns(const engine *e, int c) {
  return &e->work.clumps.columns[c];
}
static inline bool engine_in_clump(const engine *e, size_t slot) {
  return e->work.clumps.count && e->work.clumps.of[slot] >= 0;
}
/* q2 of a free disk from the forces on it. */
static inline void engine_accelerate(const engine *e, int c, size_t slot, double force) {
  const columns *q = &e->work.columns[c];
  q->q2[slot] = e->work.half_dt2 * ((force + q->constant[slot]) * q->inverse[slot]);
}
/* Brings all pieces of the walls to where they are now; a step does so for those in the list of pairs. */
void engine_pose_walls(engine *e);
/* Piece k of the walls, where it is after engine_pose_walls. */
static inline const placed_segment *engine_segment(const engine *e, size_t k) {
  return &e->work.segments[k];
}
static inline const double *engine_periods(const engine *e) { return e->work.length; }

/* --- contacts ------------------------------------------------------------------------------------------- */

static inline size_t engine_candidates(const engine *e) { return e->work.pairs.count; }
static inline size_t engine_contact_a(const engine *e, size_t k) {
  return (size_t)e->work.pairs.a[k];
}
static inline size_t engine_contact_b(const engine *e, size_t k) {
  return (size_t)e->work.pairs.b[k];
}
static inline bool engine_contact_closed(const engine *e, size_t k) {
  return pairs_closed(&e->work.pairs, k);
}
static inline double engine_contact_force(const engine *e, size_t k) {
  return PAIR(&e->work.pairs, k, force);
}
static inline double engine_contact_overlap(const engine *e, size_t k) {
  return PAIR(&e->work.pairs, k, overlap);
}
/* Reference direction of a closed contact: its normal from a on, within 1/64. */
static inline void engine_contact_direction(const engine *e, size_t k, double n[2]) {
  n[0] = PAIR(&e->work.pairs, k, ex);
  n[1] = PAIR(&e->work.pairs, k, ey);
}
/* +1, -1: sliding with that sign of torque; 0: stuck or open. */
static inline int engine_contact_sliding(const engine *e, size_t k) {
  return pairs_slide_sign(&e->work.pairs, k);
}
/* tau, which turns both disks. */
static inline double engine_contact_tau(const engine *e, size_t k) {
  if (e->work.pairs.more) return MORE(&e->work.pairs, k, tau);
  return -(e->model->laws[PAIR(&e->work.pairs, k, law)].k_t * PAIR(&e->work.pairs, k, zeta));
}
static inline double engine_contact_stiffness(const engine *e, size_t k) {
  return law_stiffness(&e->model->laws[PAIR(&e->work.pairs, k, law)],
                       fmax(engine_contact_overlap(e, k), 0.0));
}
/* The candidates of a body are engine_candidate(e, at) for at in [first, first of the next slot). */
static inline size_t engine_first(const engine *e, size_t slot) {
  return e->work.incidence.start[slot];
}
static inline size_t engine_candidate(const engine *e, size_t at) {
  return e->work.incidence.entry[at] / 2;
}
static inline size_t engine_partner(const engine *e, size_t at) {
  size_t k = engine_candidate(e, at);
  return e->work.incidence.entry[at] & 1 ? engine_contact_a(e, k) : engine_contact_b(e, k);
}
/* The watched contact k (two per watch): the candidate that it is now, of several pieces of one wall the one that
 * presses most; -1: open. */
int64_t engine_watched(const engine *e, size_t k);

/* Bodies of which the force of each contact is kept apart: the prescribed ones. Their slots, and what the i-th candidate does
 * to the k-th of them. */
typedef struct contact_push {
  double x, y, torque;
} contact_push;
static inline size_t engine_kept(const engine *e) { return e->work.sums.n_listed; }
static inline size_t engine_kept_slot(const engine *e, size_t k) { return e->work.sums.listed[k]; }
static inline contact_push engine_push(const engine *e, size_t k, size_t i) {
  const double *row = e->work.sums.row + SUM_ROW * (e->work.sums.single[k] + i);
  double radius = e->state->radius[engine_kept_slot(e, k)];
  double torque = radius != 0.0 ? row[SUM_TURN] * radius : row[SUM_TURN];
  if (e->work.features & LAW_ROLLING && engine_kept_slot(e, k) < e->state->n_disks)
    torque += row[SUM_COUPLE];
  return (contact_push){row[SUM_X], row[SUM_Y], torque};
}

/* --- the step ------------------------------------------------------------------------------------------- */

static inline sd_status engine_status(const engine *e) { return e->work.status; }
/* Before steps: messages go there, and nothing has gone wrong. */
static inline void engine_ready(engine *e, sd_messages *messages) {
  e->work.messages = messages;
  e->work.status = SD_OK;
}
static inline void engine_tell(engine *e, sd_messages *messages) { e->work.messages = messages; }
static inline void engine_end(engine *e, sd_status status) { e->work.status = status; }
/* By how much lists reach further than contacts. */
static inline double engine_skin(const engine *e) { return e->work.skin; }
/* Would a free disk or a wall leave the lists in one step? */
bool engine_outruns(engine *e);
/* The skin that no free disk outruns in one step. */
double engine_outrun_skin(const engine *e);
static inline int engine_threads(const engine *e) { return e->work.n_threads; }
static inline const kernels *engine_kernels(const engine *e) { return e->work.kernels; }
/* Rows of a small system; NULL: it takes the general step. */
static inline lanes *engine_lanes(const engine *e) { return e->work.lanes; }
static inline lanes **engine_lanes_place(engine *e) { return &e->work.lanes; }

#endif
