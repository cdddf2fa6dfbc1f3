/* access.h: read access to a system, for the code that measures, makes packings and runs. Only
 * physics/ may use `work` directly (tests/docs/test_floors.py). Many functions are inline, since
 * they are called in every step.
 *
 * Candidates are pairs that are near enough to touch soon, in a fixed order; overlap and force of a
 * candidate that is open are zero.
 */
#ifndef PHYSICS_ACCESS_H
#define PHYSICS_ACCESS_H

#include <math.h>

#include "base/math.h"
#include "model/normal_laws.h"
#include "physics/contact/walls.h"
#include "physics/contact/pairs.h"
#include "physics/system/kernels.h"
#include "physics/system/work.h"

/* --- bodies and box --------------------------------------------------------------------------- */

/* Returns the slot of the body with this number; SLOT_NONE if it is on another rank. */
static inline uint32_t engine_slot(const engine *e, uint32_t body) {
  return slot_of(&e->work.slots, body);
}
static inline const slot_table *engine_slots(const engine *e) { return &e->work.slots; }
/* engine_length returns the present length of the periodic box along direction c, 0 if c is not
 * periodic; engine_lower returns its lower bound, -infinity if c is not periodic. */
static inline double engine_length(const engine *e, int c) { return e->work.length[c]; }
static inline double engine_lower(const engine *e, int c) { return e->work.lower[c]; }
static inline bool engine_beyond(const engine *e, int c, double x) {
  return x < e->work.lower[c] || x >= e->work.upper[c];
}
/* Returns the difference d of two coordinates along direction c, reduced to the nearest periodic
 * image. */
static inline double engine_nearest(const engine *e, int c, double d) {
  return e->work.periodic[c] ? d - e->work.length[c] * nearbyint(d * e->work.inverse_length[c]) : d;
}
/* Returns the columns of coordinate c of the free disks: value, derivatives, contact force,
 * constant force, inverse mass. */
static inline const columns *engine_columns(const engine *e, int c) { return &e->work.columns[c]; }
/* engine_clumps returns the number of clumps (rigid bodies of several disks), engine_clump_columns
 * the columns of coordinate c of the clumps. The disks of a clump are free disks, but their inverse
 * masses are 0, so that forces do not move them singly. */
static inline size_t engine_clumps(const engine *e) { return e->work.clumps.count; }
static inline const columns *engine_clump_columns(const engine *e, int c) {
  return &e->work.clumps.columns[c];
}
static inline bool engine_in_clump(const engine *e, size_t slot) {
  return e->work.clumps.count && e->work.clumps.of[slot] >= 0;
}
/* Sets q2, dt^2/2 times the acceleration along coordinate c, of the free disk in this slot, from
 * this contact force and the constant force on the disk. */
static inline void engine_accelerate(const engine *e, int c, size_t slot, double force) {
  const columns *q = &e->work.columns[c];
  q->q2[slot] = e->work.half_dt2 * ((force + q->constant[slot]) * q->inverse[slot]);
}
/* Moves all wall segments to the present poses of their walls. A step moves only the segments in
 * candidate pairs. */
void engine_pose_walls(engine *e);
/* Returns wall segment k in its present position; call engine_pose_walls before. */
static inline const placed_segment *engine_segment(const engine *e, size_t k) {
  return &e->work.segments[k];
}
static inline const double *engine_periods(const engine *e) { return e->work.length; }

/* --- contacts --------------------------------------------------------------------------------- */

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
/* Writes to n[] the reference direction of the closed contact k: a unit vector from a towards b,
 * within about 1/64 rad of the present normal. */
static inline void engine_contact_direction(const engine *e, size_t k, double n[2]) {
  n[0] = PAIR(&e->work.pairs, k, ex);
  n[1] = PAIR(&e->work.pairs, k, ey);
}
/* Returns the sign (+1 or -1) of the torque on both disks if contact k slides; 0 if it is stuck or
 * open. */
static inline int engine_contact_sliding(const engine *e, size_t k) {
  return pairs_slide_sign(&e->work.pairs, k);
}
/* Returns tau, the tangential force of contact k. A positive tau turns both disks
 * counter-clockwise. */
static inline double engine_contact_tau(const engine *e, size_t k) {
  if (e->work.pairs.more) return MORE(&e->work.pairs, k, tau);
  return -(e->work.laws[PAIR(&e->work.pairs, k, law)].k_t * PAIR(&e->work.pairs, k, zeta));
}
static inline double engine_contact_stiffness(const engine *e, size_t k) {
  const sd_contact_law law = contact_law_of(e, k);
  return law_stiffness(&law, math_max(engine_contact_overlap(e, k), 0.0));
}
/* Indices of candidates. The candidate pairs of the body in `slot` are engine_candidate(e, at), for
 * `at` from engine_first(e, slot) to engine_first(e, slot + 1) - 1. */
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
/* Returns the candidate pair of watched contact k, or -1 if it is open. (The model names disks to
 * watch, with two contacts each.) If the partner is a wall of several segments, returns the pair
 * with the largest normal force. */
int64_t engine_watched(const engine *e, size_t k);

/* Force and torque of one contact on a body. They are stored singly for all prescribed bodies
 * and some free disks: engine_listed returns the number of these bodies, engine_kept_slot the
 * slot of the k-th, and engine_push the force of its i-th candidate on it. */
typedef struct contact_push {
  double x, y, torque;
} contact_push;
static inline size_t engine_listed(const engine *e) { return e->work.sums.n_listed; }
static inline size_t engine_kept_slot(const engine *e, size_t k) { return e->work.sums.listed[k]; }
static inline contact_push engine_push(const engine *e, size_t k, size_t i) {
  const double *row = e->work.sums.row + SUM_ROW * (e->work.sums.single[k] + i);
  double radius = e->state->radius[engine_kept_slot(e, k)];
  double torque = radius != 0.0 ? row[SUM_TORQUE] * radius : row[SUM_TORQUE];
  if (e->work.features & LAW_ROLLING && engine_kept_slot(e, k) < e->state->n_disks)
    torque += row[SUM_COUPLE];
  return (contact_push){row[SUM_X], row[SUM_Y], torque};
}

/* --- the step --------------------------------------------------------------------------------- */

static inline sd_status engine_status(const engine *e) { return e->work.status; }
/* Prepares for steps: errors will be reported to `messages`, and the status is cleared. */
static inline void engine_ready(engine *e, sd_messages *messages) {
  e->work.messages = messages;
  e->work.status = SD_OK;
}
static inline void engine_tell(engine *e, sd_messages *messages) { e->work.messages = messages; }
static inline void engine_end(engine *e, sd_status status) { e->work.status = status; }
/* Returns the Verlet margin. A pair is a candidate if its gap is below this margin plus the range
 * of attraction. */
static inline double engine_skin(const engine *e) { return e->work.skin; }
/* Returns true if the neighbour lists would be stale after the next step, since a free disk or a
 * wall moves too far in it. */
bool engine_outruns(engine *e);
/* Returns a Verlet margin that is wide enough for one step: no free disk then moves so far in the
 * next step that new lists become stale. */
double engine_outrun_skin(const engine *e);
static inline int engine_threads(const engine *e) { return e->work.n_threads; }
static inline const kernels *engine_kernels(const engine *e) { return e->work.kernels; }
/* Returns the data of this system if it runs in SIMD lanes (lanes.h); NULL if it uses the general
 * step. */
static inline lanes *engine_lanes(const engine *e) { return e->work.lanes; }
static inline lanes **engine_lanes_place(engine *e) { return &e->work.lanes; }

#endif
