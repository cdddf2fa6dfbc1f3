/* kernel_few.c: one step of few disks (few.h), the same statements as step.c in one function; compiled once
 * per instruction set.
 */
#include <string.h>

#include "physics/contacts.h"
#include "physics/few.h"
#include "physics/kernel_path.h"
#include "physics/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/law.h"
#include "physics/pair_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH 2
#include "base/lane.h"
#include "physics/integrate_pass.h"
#include "physics/law.h"
#include "physics/pair_pass.h"
#undef LANE_WIDTH
#if VECTOR_WIDTH > 2
#define LANE_WIDTH 4
#include "base/lane.h"
#include "physics/integrate_pass.h"
#define FOR_ROW(pass, i, a, b) pass##_at_w4(&f->columns, 4 * (i), a, b)
LANE_INLINE void store_row(double *row, double x, double y, double theta) {
  store_w4(row, (real_w4){x, y, theta, 0.0});
}
#else
LANE_INLINE void store_row(double *row, double x, double y, double theta) {
  store_w2(row, (real_w2){x, y});
  store_w2(row + 2, (real_w2){theta, 0.0});
}
#define FOR_ROW(pass, i, a, b)                                                                               \
  do {                                                                                                       \
    pass##_at_w2(&f->columns, 4 * (i), a, b);                                                                   \
    pass##_at_w2(&f->columns, 4 * (i) + 2, a, b);                                                               \
  } while (0)
#endif

LANE_INLINE bool predict(engine *e, few *f) {
  const work *w = &e->work;
  bool gear = e->model->integrator == SD_GEAR5, stale = false;
  for (size_t i = 0; i < e->state->n_free; i++) {
    if (gear)
      FOR_ROW(gear_predict, i, w->dt, w->per_dt);
    else
      FOR_ROW(verlet_predict, i, w->dt, w->per_dt);
    double dx = f->q[i][SD_X] - w->x0[i], dy = f->q[i][SD_Y] - w->y0[i];
    stale |= !(dx * dx + dy * dy <= w->moved_limit2);
  }
  return stale;
}

LANE_INLINE void place(few *f, int64_t k) {
  for (few_place *p = f->places; p < f->places + f->n_places; p++) {
    double after = p->from->value[k];
    p->from->moved = after - p->from->last;
    p->from->force_before = *p->force;
    *p->at = p->from->last = after;
    *p->speed = p->from->velocity[k];
  }
}

LANE_INLINE void pair_passes(engine *e, thread_work *mine, const pair_view *view, int pass) {
  size_t at = 0, n = e->work.pairs.count;
  for (; at + 2 <= n; at += 2) round_pass_w2(e, mine, view, at, pass);
  if (at < n) round_pass_w1(e, mine, view, at, pass);
}

LANE_INLINE void gather(engine *e, few *f) {
  const pairs *p = &e->work.pairs;
  const size_t *start = e->work.incidence.start;
  const uint32_t *entry = e->work.incidence.entry;
  for (size_t i = 0; i < e->state->n_bodies; i++) {
    double fx = 0.0, fy = 0.0, tau = 0.0;
    for (size_t at = start[i]; at < start[i + 1]; at++) {
      size_t k = entry[at] / 2;
      double sign = entry[at] & 1 ? 1.0 : -1.0;
      fx += sign * p->fx[k];
      fy += sign * p->fy[k];
      tau += p->tau[k];
    }
    /* stored as the corrector loads it: narrower stores could not be forwarded to its wide load */
    store_row(f->force[i], fx, fy, tau * f->radius[i][0]);
  }
}

LANE_INLINE void book_work(engine *e, const few *f) {
  double done = 0.0;
  for (const few_place *p = f->places; p < f->places + f->n_places; p++)
    done += (p->from->force_before + *p->force) * p->from->moved;
  /* statistics look at the state */
  for (const few_place *p = f->places; p < f->places + f->n_places; p++) *p->from->at = p->from->last;
  e->state->work_driven -= 0.5 * done;
}

LANE_INLINE bool correct(engine *e, thread_work *mine, few *f) {
  const work *w = &e->work;
  bool gear = e->model->integrator == SD_GEAR5, out = false;
  for (size_t i = 0; i < e->state->n_free; i++) {
    if (gear)
      FOR_ROW(gear_correct, i, w->half_dt2, w->per_dt);
    else
      FOR_ROW(verlet_correct, i, w->half_dt2, w->per_dt);
    double theta = f->q[i][SD_THETA];
    e->state->theta[i] = theta;
    if (theta > 4.0 || theta < -4.0) {
      event_add(&mine->returns, (uint32_t)i, 0.0);
      out = true;
    }
  }
  return out;
}

LANE_INLINE pair_view view_of(const few *f, few_rows q, few_rows v) {
  return (pair_view){q[0], q[0] + SD_Y, q[0] + SD_THETA, v[0], v[0] + SD_Y, f->radius[0], f->a, f->b};
}

/* What follows a commit: losses, rare events, statistics of a measured step. */
LANE_INLINE bool committed(engine *e, few_measure *measure) {
  work *w = &e->work;
  bool events = contacts_any_event(w);
  w->kernels->losses(e, 0, e->state->n_free);
  if (events) w->status = few_events(e);
  if (measure && w->status == SD_OK) measure(e);
  return events;
}

void KERNEL(kernel_few_step)(engine *e, few_measure *measure);
void KERNEL(kernel_few_finish)(engine *e, few_measure *measure);

/* Writes the history of the last step from where its corrected coordinates still stand. */
void KERNEL(kernel_few_finish)(engine *e, few_measure *measure) {
  few *f = e->work.few;
  if (!f->pending) return;
  f->pending = false;
  const pair_view now = view_of(f, f->q, f->v);
  pair_passes(e, &e->work.threads[0], &now, PASS_COMMIT);
  committed(e, measure);
}

/* The commit of the last step and the forces of this one, side by side: neither waits for the other's square
 * root and division. Rare events change the memory that the forces have read: then these are done again. */
LANE_INLINE void commit_and_force(engine *e, few *f, few_measure *measure) {
  thread_work *mine = &e->work.threads[0];
  const pair_view before = view_of(f, f->q_before, f->v_before), now = view_of(f, f->q, f->v);
  size_t at = 0, n = e->work.pairs.count;
  for (; at + 2 <= n; at += 2) {
    round_pass_w2(e, mine, &before, at, PASS_COMMIT);
    round_pass_w2(e, mine, &now, at, PASS_FORCE);
  }
  if (at < n) {
    round_pass_w1(e, mine, &before, at, PASS_COMMIT);
    round_pass_w1(e, mine, &now, at, PASS_FORCE);
  }
  if (committed(e, measure) && e->work.status == SD_OK) pair_passes(e, mine, &now, PASS_FORCE);
}

void KERNEL(kernel_few_step)(engine *e, few_measure *measure) {
  work *w = &e->work;
  few *f = w->few;
  thread_work *mine = &w->threads[0];
  const bool one_pass = e->model->integrator == SD_VERLET;

  if (f->pending)
    for (size_t i = 0; i < e->state->n_bodies; i++) {
      memcpy(f->q_before[i], f->q[i], sizeof f->q[i]);
      memcpy(f->v_before[i], f->v[i], sizeof f->v[i]);
    }
  bool stale = predict(e, f);
  place(f, motion_index(e));
  if (stale && (w->status = few_rebuild(e, measure)) != SD_OK) return;

  const pair_view now = view_of(f, f->q, f->v);
  if (one_pass)
    pair_passes(e, mine, &now, PASS_FORCE | PASS_COMMIT);
  else if (f->pending)
    commit_and_force(e, f, measure);
  else
    pair_passes(e, mine, &now, PASS_FORCE);
  if (w->status != SD_OK) return;
  gather(e, f);
  book_work(e, f);
  f->pending = !one_pass;
  bool returns = correct(e, mine, f);
  e->state->step++;
  if (one_pass)
    committed(e, measure);
  else if (returns) /* it changes the coordinates that the next step starts from */
    KERNEL(kernel_few_finish)(e, measure);
}
