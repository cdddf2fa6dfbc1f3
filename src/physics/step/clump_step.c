/* clump_step.c: see clump_step.h. */
#include "physics/step/clump_step.h"

#include <assert.h>

#include "physics/contact/pairs.h"
#include "physics/motion/motion.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/step/integrate_pass.h"

static void share_of(const engine *e, const team *t, size_t *begin, size_t *end) {
  team_share(t, e->work.clumps.count, begin, end);
}

void clumps_predict(engine *e, const team *t) {
  const work *w = &e->work;
  size_t begin, end;
  share_of(e, t, &begin, &end);
  for (int q = 0; q < SD_COORDINATES; q++) {
    const columns *c = &w->clumps.columns[q];
    for (size_t k = begin; k < end; k++) {
      if (c->inverse[k] == 0.0) continue;
      nordsieck_w1 n = {.q = c->q[k], .v = c->v[k], .q2 = c->q2[k]};
      if (e->model->integrator == SD_GEAR5)
        gear_predict_at_w1(c, k, w->dt, w->per_dt, &n);
      else
        verlet_predict_w1(&n, w->dt, w->per_dt);
      c->q[k] = n.q;
      c->v[k] = n.v;
    }
  }
  if (t->rank == 0) motion_pose_clumps(e);
}

void clumps_place(engine *e, const team *t) {
  size_t begin, end;
  share_of(e, t, &begin, &end);
  for (size_t k = begin; k < end; k++) clump_place(e, k);
}

static bool out_of(const work *w, double x, double y, double theta) {
  return theta > 4.0 || theta < -4.0 || x < w->lower[0] || x >= w->upper[0] || y < w->lower[1] ||
         y >= w->upper[1];
}

/* Returns the damping that acted. */
static clump_load correct(const engine *e, size_t k) {
  const work *w = &e->work;
  clump_load constant = clump_constant(e, k), all = constant;
  for (int q = 0; q < SD_COORDINATES; q++) all.on[q] += w->clumps.columns[q].force[k];
  const double kappa = e->model->integrator == SD_GEAR5 ? GEAR1 * w->per_dt : w->per_dt;
  const clump_load damped = clump_damping(e, k, kappa, &all);
  for (int q = 0; q < SD_COORDINATES; q++) {
    const columns *c = &w->clumps.columns[q];
    if (c->inverse[k] == 0.0) continue;
    const double a = accelerate_w1(c->force[k], constant.on[q] + damped.on[q], c->inverse[k], w->half_dt2);
    nordsieck_w1 n = {c->q[k], c->v[k], c->q2[k], c->q3[k], c->q4[k], c->q5[k]};
    if (e->model->integrator == SD_GEAR5)
      gear_correct_w1(&n, a, w->per_dt);
    else
      verlet_correct_w1(&n, a, w->per_dt);
    c->q[k] = n.q;
    c->v[k] = n.v;
    c->q2[k] = n.q2;
    c->q3[k] = n.q3;
    c->q4[k] = n.q4;
    c->q5[k] = n.q5;
  }
  return damped;
}

void clumps_correct(engine *e, const team *t) {
  const sd_state *s = e->state;
  work *w = &e->work;
  event_list *returns = &w->threads[t->rank].returns;
  size_t begin, end;
  share_of(e, t, &begin, &end);
  for (size_t k = begin; k < end; k++) {
    clump_sum(e, k);
    const double booked = clump_field_booked(e, k);
    const clump_load damped = correct(e, k);
    clump_place(e, k);
    clump_book_field(e, k, booked, w->dt);
    clump_book_damping(e, k, &damped, w->dt);
    if (out_of(w, s->clump_x[k], s->clump_y[k], s->clump_theta[k]))
      event_add(returns, (uint32_t)(s->n_bodies + k));
    for (size_t n = w->clumps.start[k]; n < w->clumps.start[k + 1]; n++) {
      const uint32_t i = w->clumps.member[n];
      if (out_of(w, s->x[i], s->y[i], s->theta[i]))
        event_add(returns, i); /* the corrector may have noted it, too */
    }
  }
}

void clumps_wrap(engine *e, size_t k) {
  sd_state *s = e->state;
  const work *w = &e->work;
  double *at[] = {s->clump_x + k, s->clump_y + k}, *theta = s->clump_theta + k;
  int32_t *image[] = {s->clump_image_x + k, s->clump_image_y + k};
  const double turn = *theta > 4.0 ? 8.0 : *theta < -4.0 ? -8.0 : 0.0;
  *theta -= turn;
  s->clump_turn[k] += turn;
  for (int q = 0; q < 2; q++) {
    const int way = *at[q] < w->lower[q] ? 1 : *at[q] >= w->upper[q] ? -1 : 0;
    if (way == 0) continue;
    *at[q] += way * w->length[q];
    *image[q] -= way;
  }
  motion_wrapped(e, (uint32_t)(s->n_bodies + k));
}
