/* clump_step.c: predictor and corrector of clumps; implements clumps_... of step.h. */
#include "model/model.h"
#include "physics/step/step.h"

#include "model/field_kinds.h"
#include "physics/contact/pairs.h"
#include "physics/motion/motion.h"
#include "physics/system/fields.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/step/integrate_pass.h"
#include "physics/step/field_pass.h"

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

/* --- force fields ----------------------------------------------------------------------------- */

/* Linear system a u = r for the corrected velocity u = (V_x, V_y, Omega) of a clump. Field forces
 * depend on this velocity: row q of the system is u[q] - gain[q] F_q(u) = r[q], where F(u) is the
 * velocity-dependent part of the field forces and torque at u, summed over the disks of the
 * clump. */
typedef struct field_system {
  double a[SD_COORDINATES][SD_COORDINATES], r[SD_COORDINATES];
} field_system;

/* Adds the terms of one disk to the matrix. The disk is at (x, y) from the clump's centre, where
 * the velocity is V + Omega x (x, y). Its drag coefficients f and f_r and Coriolis coefficient b
 * are in s (f = drag[0], f_r = drag[1], b = turn). */
static void add_disk(field_system *m, const double gain[SD_COORDINATES], const field_sum_w1 *s,
                     double x, double y) {
  const double f = s->drag[0], b = s->turn;
  const double taken[SD_COORDINATES][SD_COORDINATES] = {
      {f, -b, -(f * y + b * x)},
      {b, f, f * x - b * y},
      {b * x - f * y, f * x + b * y, s->drag[1] + f * (x * x + y * y)}};
  for (int q = 0; q < SD_COORDINATES; q++)
    for (int c = 0; c < SD_COORDINATES; c++) m->a[q][c] += gain[q] * taken[q][c];
}

/* Solves the system by Gaussian elimination without pivoting. Pivots are at least 1, since the
 * terms added to the unit matrix are dissipative or rotate only. The solution replaces m->r. */
static void solve(field_system *m) {
  for (int q = 0; q < SD_COORDINATES; q++)
    for (int below = q + 1; below < SD_COORDINATES; below++) {
      const double share = m->a[below][q] / m->a[q][q];
      for (int c = q; c < SD_COORDINATES; c++) m->a[below][c] -= share * m->a[q][c];
      m->r[below] -= share * m->r[q];
    }
  for (int q = SD_COORDINATES - 1; q >= 0; q--) {
    for (int c = q + 1; c < SD_COORDINATES; c++) m->r[q] -= m->a[q][c] * m->r[c];
    m->r[q] /= m->a[q][q];
  }
}

/* Computes the velocity u that the corrector would give to clump k without non-viscous damping.
 * Field forces are evaluated at this velocity, as field_forces (field_pass.h) does for single
 * disks. */
static void field_speed(const engine *e, const view *v, size_t k, double u[SD_COORDINATES]) {
  const work *w = &e->work;
  const clumps *c = &w->clumps;
  const body_forces *f = w->body_forces;
  const double kappa = e->model->integrator == SD_GEAR5 ? GEAR1 * w->per_dt : w->per_dt;
  double gain[SD_COORDINATES], load[SD_COORDINATES];
  field_system m = {.a = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  for (int q = 0; q < SD_COORDINATES; q++) {
    gain[q] = c->columns[q].inverse[k] * (kappa * w->half_dt2);
    load[q] = c->columns[q].force[k] + c->columns[q].constant[k];
  }
  for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
    const uint32_t i = c->member[n];
    field_sum_w1 s = {0};
    field_sums_w1(f, v, i, &s);
    const double x = c->arm_x[n], y = c->arm_y[n];
    const double fx = f->base[SD_X][i] + (s.place[0] + s.flow[SD_X]);
    const double fy = f->base[SD_Y][i] + (s.place[1] + s.flow[SD_Y]);
    load[SD_X] += fx;
    load[SD_Y] += fy;
    load[SD_THETA] += f->base[SD_THETA][i] + s.flow[SD_THETA] + (x * fy - y * fx);
    add_disk(&m, gain, &s, x, y);
  }
  for (int q = 0; q < SD_COORDINATES; q++)
    m.r[q] = c->columns[q].v[k] + (gain[q] * load[q] - kappa * c->columns[q].q2[k]);
  solve(&m);
  for (int q = 0; q < SD_COORDINATES; q++) u[q] = m.r[q];
}

/* Recomputes forces and powers of fields on the disks of clump k, at the clump's corrected
 * velocity. The corrector of the disks has evaluated them at the predicted velocity, which is not
 * exact for disks in clumps. */
static void correct_fields(engine *e, size_t k) {
  const work *w = &e->work;
  const clumps *c = &w->clumps;
  const body_forces *f = w->body_forces;
  sd_state *s = e->state;
  const view v = view_of(e, 0);
  double u[SD_COORDINATES];
  field_speed(e, &v, k, u);
  for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
    const uint32_t i = c->member[n];
    const double sum[] = {s->force_x[i], s->force_y[i], s->torque[i]};
    const double speed[] = {u[SD_X] - u[SD_THETA] * c->arm_y[n],
                            u[SD_Y] + u[SD_THETA] * c->arm_x[n], u[SD_THETA]};
    double before[FIELD_POWERS];
    field_force_w1 of;
    s->vx[i] = speed[SD_X];
    s->vy[i] = speed[SD_Y];
    s->omega[i] = speed[SD_THETA];
    for (int p = 0; p < FIELD_POWERS; p++) before[p] = f->power[p][i];
    field_forces_w1(f, &v, i, 0.0, sum, &of);
    field_book_w1(f, &v, i, 0.0, &of, speed);
    for (int p = 0; p < FIELD_POWERS; p++)
      f->sum[p][i] += 0.5 * w->dt * (f->power[p][i] - before[p]);
  }
}

/* --- corrector -------------------------------------------------------------------------------- */

/* Corrects the coordinates of clump k. Returns the non-viscous damping forces and torque on it,
 * which are needed for the energy balance. */
static clump_load correct(const engine *e, size_t k) {
  const work *w = &e->work;
  clump_load constant = clump_constant(e, k), all = constant;
  for (int q = 0; q < SD_COORDINATES; q++) all.on[q] += w->clumps.columns[q].force[k];
  const double kappa = e->model->integrator == SD_GEAR5 ? GEAR1 * w->per_dt : w->per_dt;
  const clump_load damped = clump_damping(e, k, kappa, &all);
  for (int q = 0; q < SD_COORDINATES; q++) {
    const columns *c = &w->clumps.columns[q];
    if (c->inverse[k] == 0.0) continue;
    const double a =
        accelerate_w1(c->force[k], constant.on[q] + damped.on[q], c->inverse[k], w->half_dt2);
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
    if (w->body_forces) correct_fields(e, k);
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
        /* a repetition does no harm: the corrector of the disks may have added this disk already */
        event_add(returns, i);
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
