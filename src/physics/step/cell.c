/* cell.c: implements cell.h, a deforming periodic box.
 *
 * Work of the box. Let f be the force on disk b of a contact that touches the image of b n cells
 * away; the image moves with h' n. The power is P = sum f . h' n = T : h', with T = sum f (x) n; it
 * is integrated over the step by the trapezoidal rule. A disk that is wrapped by n cells changes
 * its kinetic energy, and T by the forces on it. The virial of all contacts, S V = sum f (x) (r_b -
 * r_a - h n) = sum_i F_i (x) r_i - T h^T, needs sums over disks only.
 *
 * Stress control of a component: rate' = (stress - wanted)/(p t^2) - 2 (rate - mean)/t, where p is
 * the largest of the wanted stresses and t the response time. So the box has an inertia p t^2, and
 * is critically damped if the stiffness of the packing is p. Only the deviation of the rate from
 * its running mean (over MEAN_TIMES t) is damped: steady flows are not slowed, and the time average
 * of the stress is the wanted one.
 */
#include "physics/step/cell.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/exact_sum.h"
#include "base/math.h"
#include "model/cell.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"
#include "physics/system/fields.h"

enum { T_XX, T_XY, T_YX, T_YY };

/* --- shape ------------------------------------------------------------------------------------ */

static double value_at(const sd_state *s, double dt, int k, int64_t step) {
  return s->cell_start[k] + (double)(step - s->cell_from[k]) * dt * s->cell_speed[k];
}

void cell_pose(engine *e, int64_t step) {
  sd_state *s = e->state;
  if (!s->n_cell) return;
  for (int k = 0; k < CELL_COLUMNS; k++) s->cell[k] = value_at(s, e->work.dt, k, step);
  box_update(e);
  neighbours_deform(e, step);
}

/* Returns the unit of shape column k, a length: the undeformed box length along y for CELL_Y, along
 * x for CELL_X and CELL_OFFSET (the offset is stored in units of the x length). */
static double unit_of(const engine *e, int k) {
  const sd_model *m = e->model;
  const int c = k == CELL_Y ? SD_Y : SD_X;
  return e->state->box_scale * (m->upper[c] - m->lower[c]);
}

/* --- rates ------------------------------------------------------------------------------------ */

void cell_gradient(const engine *e, double g[SD_CELL_COMPONENTS]) {
  const work *w = &e->work;
  g[SD_CELL_XX] = w->cell.speed[CELL_X] / w->length[0];
  g[SD_CELL_YY] = w->cell.speed[CELL_Y] / w->length[1];
  g[SD_CELL_XY] = (w->cell.speed[CELL_OFFSET] - g[SD_CELL_XX] * w->offset) / w->length[1];
}

/* Adds (x, y) to the velocity of disk i, and returns the kinetic energy that the disk gains. The
 * powers of force fields are updated, too, since their trapezoidal sum over the next step begins
 * with the new velocity. */
static double jump(engine *e, size_t i, double x, double y) {
  sd_state *s = e->state;
  const double gained = s->mass[i] * (s->vx[i] * x + s->vy[i] * y + 0.5 * (x * x + y * y));
  if (e->fields) s->field_power += e->fields->force[SD_X][i] * x + e->fields->force[SD_Y][i] * y;
  if (s->n_fielded) s->power_work[i] += s->field_x[i] * x + s->field_y[i] * y;
  s->vx[i] += x;
  s->vy[i] += y;
  return gained;
}

/* Changes the velocity of each disk by (change of the velocity gradient) times (position). The
 * position is measured from the lower corner for xx and yy, and from mid-height for shear, so that
 * a uniform packing gets no momentum from shear. */
static void take_up(engine *e, const double change[SD_CELL_COMPONENTS]) {
  sd_state *s = e->state;
  const work *w = &e->work;
  const double middle = w->lower[1] + 0.5 * w->length[1];
  double done = 0.0;
  for (size_t i = 0; i < s->n_free; i++) {
    if (!body_in_play(s, i)) continue;
    const double x = change[SD_CELL_XX] * (s->x[i] - w->lower[0]) +
                     change[SD_CELL_XY] * (s->y[i] - middle),
                 y = change[SD_CELL_YY] * (s->y[i] - w->lower[1]);
    done += jump(e, i, x, y);
  }
  /* before step 0 this energy is part of the initial energy */
  if (s->step > 0) s->work_driven += done;
}

/* Sets the rate of change of shape column k, from the present step on. If the rate is the same as
 * before, the starting point of the linear motion is kept, too, so that rounding errors do not
 * change. */
static void set_speed(engine *e, int k, double speed) {
  sd_state *s = e->state;
  if (speed == s->cell_speed[k]) return;
  s->cell_start[k] = s->cell[k];
  s->cell_from[k] = s->step;
  s->cell_speed[k] = speed;
  if (k != CELL_SHEAR) e->work.cell.speed[k] = speed * unit_of(e, k);
}

/* Sets the velocity gradient of the box from the present step on. over: time until the next change;
 * in this time box lengths change by exactly exp(rate * over). boundary: true if disks keep their
 * velocities. */
static void set_gradient(engine *e, const double rate[SD_CELL_COMPONENTS], double over,
                         bool boundary) {
  sd_state *s = e->state;
  double before[SD_CELL_COMPONENTS], after[SD_CELL_COMPONENTS];
  cell_gradient(e, before);
  const double xx = rate[SD_CELL_XX] != 0.0 ? math_expm1(rate[SD_CELL_XX] * over) / over : 0.0;
  const double yy = rate[SD_CELL_YY] != 0.0 ? math_expm1(rate[SD_CELL_YY] * over) / over : 0.0;
  set_speed(e, CELL_X, xx * s->cell[CELL_X]);
  set_speed(e, CELL_Y, yy * s->cell[CELL_Y]);
  set_speed(e, CELL_SHEAR, rate[SD_CELL_XY]);
  set_speed(e, CELL_OFFSET,
            rate[SD_CELL_XY] * s->cell[CELL_Y] * unit_of(e, CELL_Y) / unit_of(e, CELL_X) +
                xx * s->cell[CELL_OFFSET]);
  cell_gradient(e, after);
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) after[k] -= before[k];
  if (!boundary && (after[0] != 0.0 || after[1] != 0.0 || after[2] != 0.0)) take_up(e, after);
  cell_pose(e, s->step);
}

/* --- stress ----------------------------------------------------------------------------------- */

/* Measures the stress in the box, from contacts and velocity fluctuations about the mean flow:
 * components xx, yy and xy, positive in compression, unit: force/length. */
static void measure_stress(const engine *e, double stress[SD_CELL_COMPONENTS]) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const double *t = s->cell_force;
  enum { XX, YY, XY, MASS, PX, PY, SUMS };
  double g[SD_CELL_COMPONENTS], of[SUMS];
  exact_sum sum[SUMS] = {0};
  cell_gradient(e, g);
  for (size_t i = 0; i < s->n_free; i++) {
    if (!body_in_play(s, i)) continue;
    const double x = s->x[i] - w->lower[0], y = s->y[i] - w->lower[1], m = s->mass[i];
    const double vx = s->vx[i] - (g[SD_CELL_XX] * x + g[SD_CELL_XY] * y),
                 vy = s->vy[i] - g[SD_CELL_YY] * y;
    const double of_disk[SUMS] = {[XX] = s->force_x[i] * x + m * (vx * vx),
                                  [YY] = s->force_y[i] * y + m * (vy * vy),
                                  [XY] = s->force_x[i] * y + m * (vx * vy),
                                  [MASS] = m,
                                  [PX] = m * vx,
                                  [PY] = m * vy};
    for (int k = 0; k < SUMS; k++) exact_sum_add(&sum[k], of_disk[k]);
  }
  for (int k = 0; k < SUMS; k++) of[k] = exact_sum_value(&sum[k]);
  const double area = w->length[0] * w->length[1], per_mass = of[MASS] > 0.0 ? 1.0 / of[MASS] : 0.0;
  of[XX] -= of[PX] * of[PX] * per_mass + t[T_XX] * w->length[0] + t[T_XY] * w->offset;
  of[YY] -= of[PY] * of[PY] * per_mass + t[T_YY] * w->length[1];
  of[XY] -= of[PX] * of[PY] * per_mass + t[T_XY] * w->length[1];
  stress[SD_CELL_XX] = of[XX] / area;
  stress[SD_CELL_YY] = of[YY] / area;
  stress[SD_CELL_XY] = of[XY] / area;
}

/* Constants of the stress control. RESPONSE: response time in units of sqrt(mean mass/stress),
 * about the time in which this stress moves a disk by its own size. MEAN_TIMES: averaging time of
 * the mean rate, in response times. */
static const double RESPONSE = 4.0, MEAN_TIMES = 4.0;
static double response_of(const engine *e, const sd_cell *c, double stress) {
  double mass = 0.0;
  if (c->response > 0.0) return c->response;
  for (size_t i = 0; i < e->state->n_free; i++) mass += e->state->mass[i];
  return RESPONSE * sqrt(mass / (double)e->state->n_free / stress);
}

bool cell_near(const engine *e, double part) {
  const sd_cell *c = &e->model->phases[e->state->phase].cell;
  double stress[SD_CELL_COMPONENTS], scale = 0.0, off = 0.0;
  if (!c->asked) return true;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    if (c->controlled[k]) scale = math_max(scale, fabs(c->stress[k]));
  measure_stress(e, stress);
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    if (c->controlled[k]) off = math_max(off, fabs(stress[k] - c->stress[k]));
  return off <= part * scale;
}

/* Chooses the deformation rates for the time `over` until the next change: given rates are taken
 * from the model, controlled ones follow from the measured stress (equation at the top of this
 * file). */
static void choose_rates(const engine *e, const sd_cell *c, double over,
                         double rate[SD_CELL_COMPONENTS]) {
  double stress[SD_CELL_COMPONENTS], now[SD_CELL_COMPONENTS], scale = 0.0;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    rate[k] = c->rate[k];
    if (c->controlled[k]) scale = math_max(scale, fabs(c->stress[k]));
  }
  if (scale == 0.0) return;
  measure_stress(e, stress);
  cell_gradient(e, now);
  const double t = response_of(e, c, scale);
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    if (!c->controlled[k]) continue;
    double *mean = &e->state->cell_mean[k];
    const double push = (stress[k] - c->stress[k]) / (scale * t * t) + 2.0 * *mean / t;
    rate[k] = (now[k] + over * push) / (1.0 + 2.0 * over / t);
    if (c->max_rate > 0.0 && fabs(rate[k]) > c->max_rate)
      rate[k] = copysign(c->max_rate, rate[k]);
    else
      *mean += over / (MEAN_TIMES * t) * (rate[k] - *mean);
  }
}

/* --- nonaffine displacements ------------------------------------------------------------------ */

void cell_enter(engine *e, uint32_t i) {
  sd_state *s = e->state;
  const work *w = &e->work;
  if (!s->n_cell) return;
  s->cell_v[i] = (s->y[i] - w->lower[1]) * w->inverse_length[1];
  s->cell_u[i] = (s->x[i] - w->lower[0] - w->offset * s->cell_v[i]) * w->inverse_length[0];
}

static void note_places(engine *e) {
  for (uint32_t i = 0; i < e->state->n_free; i++) cell_enter(e, i);
}

/* Adds to each disk's nonaffine displacement what it has moved relative to the box since the last
 * call, `since` steps ago. This is h du, where u is the position in units of the box vectors, and h
 * their matrix in the middle of these steps. */
static void add_displacements(engine *e, int64_t since) {
  sd_state *s = e->state;
  const work *w = &e->work;
  double h[3];
  for (int k = 0; k < 3; k++)
    h[k] = 0.5 * unit_of(e, k) * (s->cell[k] + value_at(s, w->dt, k, s->step - since));
  for (size_t i = 0; i < s->n_free; i++) {
    const double v = (s->y[i] - w->lower[1]) * w->inverse_length[1],
                 u = (s->x[i] - w->lower[0] - w->offset * v) * w->inverse_length[0];
    double dv = v - s->cell_v[i], du = u - s->cell_u[i];
    dv -= nearbyint(dv);
    du -= nearbyint(du);
    s->nonaffine_x[i] += h[CELL_X] * du + h[CELL_OFFSET] * dv;
    s->nonaffine_y[i] += h[CELL_Y] * dv;
  }
}

/* Subtracts a whole number of box lengths from the offset, so that it is at most half a box length.
 * The lattice of periodic images stays the same, but images get other cell numbers, so all
 * quantities that use cell numbers are converted. */
static void flip_offset(engine *e) {
  sd_state *s = e->state;
  work *w = &e->work;
  const double n = nearbyint(s->cell[CELL_OFFSET] / s->cell[CELL_X]);
  if (n == 0.0) return;
  for (int k = 0; k < 3; k++) {
    s->cell_start[k] = s->cell[k];
    s->cell_from[k] = s->step;
  }
  s->cell_start[CELL_OFFSET] -= n * s->cell_start[CELL_X];
  s->cell_speed[CELL_OFFSET] -= n * s->cell_speed[CELL_X];
  w->cell.speed[CELL_OFFSET] -= n * w->cell.speed[CELL_X];
  w->cell.list[CELL_OFFSET] -= n * w->cell.list[CELL_X];
  s->cell_force[T_XX] += n * s->cell_force[T_XY];
  s->cell_force[T_YX] += n * s->cell_force[T_YY];
  for (size_t i = 0; i < s->n_bodies; i++) s->image_x[i] += (int32_t)n * s->image_y[i];
  cell_pose(e, s->step);
}

/* --- contact forces across the edges ---------------------------------------------------------- */

static double power_of(const engine *e) {
  const double *t = e->state->cell_force, *speed = e->work.cell.speed;
  return t[T_XX] * speed[CELL_X] + t[T_XY] * speed[CELL_OFFSET] + t[T_YY] * speed[CELL_Y];
}

/* Recomputes the tensor T, the forces across the box edges (top of this file), from the present
 * contacts. */
static void sum_forces(engine *e) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double *t = e->state->cell_force;
  for (int k = 0; k < CELL_COLUMNS; k++) t[k] = 0.0;
  for (size_t k = 0; k < p->n_round; k++) {
    if (!pairs_closed(p, k)) continue;
    double dx = s->x[p->b[k]] - s->x[p->a[k]], dy = s->y[p->b[k]] - s->y[p->a[k]];
    const box_image n = box_nearest(&e->work, &dx, &dy);
    if (n.x == 0.0 && n.y == 0.0) continue;
    const contact_reaction f = contact_reaction_of(e, k);
    t[T_XX] += f.fx * n.x;
    t[T_XY] += f.fx * n.y;
    t[T_YX] += f.fy * n.x;
    t[T_YY] += f.fy * n.y;
  }
}

void cell_renew(engine *e) {
  if (e->state->n_cell) sum_forces(e);
}

/* Adds up the forces thread by thread; threads have ascending ranges of pairs, so this is the order
 * of pairs. */
sd_status cell_work(engine *e, bool start) {
  work *w = &e->work;
  if (!w->cell.on) return SD_OK;
  double *t = e->state->cell_force, before = power_of(e);
  for (int k = 0; k < CELL_COLUMNS; k++) t[k] = 0.0;
  for (int k = 0; k < w->n_threads; k++) {
    crossing_list *list = &w->threads[k].crossings;
    if (list->failed)
      return sd_fail(w->messages, SD_ERROR_IO, "out of memory for contacts across the box");
    for (const crossing *c = list->item; c < list->item + list->count; c++) {
      t[T_XX] += c->fx * c->nx;
      t[T_XY] += c->fx * c->ny;
      t[T_YX] += c->fy * c->nx;
      t[T_YY] += c->fy * c->ny;
    }
    list->count = 0;
  }
  if (!start) e->state->work_driven += 0.5 * w->dt * (before + power_of(e));
  return SD_OK;
}

void cell_wrap(engine *e, uint32_t i, double nx, double ny) {
  sd_state *s = e->state;
  work *w = &e->work;
  const incidence *n = &w->incidence;
  const pairs *p = &w->pairs;
  if (!w->cell.on) return;
  assert(i < s->n_free);
  w->x0[i] -= w->cell.list[CELL_X] * nx + w->cell.list[CELL_OFFSET] * ny;
  w->y0[i] -= w->cell.list[CELL_Y] * ny;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
    const size_t k = n->entry[at] / 2;
    if (!pairs_closed(p, k)) continue;
    const contact_reaction f = contact_reaction_of(e, k);
    /* f is the force on body b; sign: +1 if disk i is b, -1 if it is a */
    const double sign = n->entry[at] & 1 ? 1.0 : -1.0;
    s->cell_force[T_XX] -= sign * f.fx * nx;
    s->cell_force[T_XY] -= sign * f.fx * ny;
    s->cell_force[T_YX] -= sign * f.fy * nx;
    s->cell_force[T_YY] -= sign * f.fy * ny;
  }
  const double x = w->cell.speed[CELL_X] * nx + w->cell.speed[CELL_OFFSET] * ny,
               y = w->cell.speed[CELL_Y] * ny;
  s->work_driven += jump(e, i, -x, -y);
}

/* --- phases ----------------------------------------------------------------------------------- */

/* Returns true if periodic images are shifted, or if they move or will do so in this phase. */
static bool matters(const engine *e) {
  const sd_state *s = e->state;
  bool on = s->phase < (int64_t)e->model->n_phases && e->model->phases[s->phase].cell.asked;
  on |= s->cell[CELL_OFFSET] != 0.0;
  for (int k = 0; k < CELL_COLUMNS; k++) on |= s->cell_speed[k] != 0.0;
  return on;
}

void cell_attach(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  if (!s->n_cell) return;
  w->cell.on = matters(e);
  for (int k = 0; k < 3; k++) w->cell.speed[k] = s->cell_speed[k] * unit_of(e, k);
  w->cell.step = s->step;
}

/* Starts with the rates of a phase that deforms the box otherwise than the phase before. */
static void begin_rates(engine *e, const sd_cell *c) {
  sd_state *s = e->state;
  const double over = CELL_EVERY * e->work.dt;
  double rate[SD_CELL_COMPONENTS];
  sum_forces(e);
  cell_gradient(e, rate);
  /* controlled components begin with their present rates */
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    if (!c->controlled[k]) rate[k] = c->rate[k];
  memcpy(s->cell_mean, rate, sizeof rate);
  const bool was_on = e->work.cell.on;
  if (!was_on) neighbours_follow(e);
  e->work.cell.on |= c->asked;
  set_gradient(e, rate, over, c->boundary);
  e->work.cell.on = matters(e);
  /* force a rebuild of the lists, which have followed the deformation until now */
  if (was_on && !e->work.cell.on) e->work.moved_limit2 = -1.0;
}

void cell_begin(engine *e) {
  static const sd_cell still = {0};
  sd_state *s = e->state;
  if (!s->n_cell) return;
  const sd_cell *c = &e->model->phases[s->phase].cell;
  if (!c->asked) c = &still;
  if (!state_goes_on(e->model, s, cell_alike)) begin_rates(e, c);
  if (c == &still) return;
  for (size_t i = 0; i < s->n_free; i++) s->nonaffine_x[i] = s->nonaffine_y[i] = 0.0;
  note_places(e);
}

/* Checks that the box is still so wide that the nearest image is unique. Returns SD_ERROR_NUMERIC
 * with a message if it is not. The same is checked at the start of a run. */
static sd_status check_width(const engine *e, sd_messages *messages) {
  const double least = cell_least_length(e->model, NULL);
  for (int c = 0; c < 2; c++)
    if (!(e->work.length[c] > least))
      return sd_fail(messages, SD_ERROR_NUMERIC,
                     "step %lld: the deformed box is %g long in %c; expected more than %g, 4.8 "
                     "times the largest "
                     "radius and twice the reach of attraction",
                     (long long)e->state->step, e->work.length[c], c == SD_X ? 'x' : 'y', least);
  return SD_OK;
}

sd_status cell_change(engine *e, sd_messages *messages) {
  sd_state *s = e->state;
  const sd_cell *c = &e->model->phases[s->phase].cell;
  const double over = CELL_EVERY * e->work.dt;
  double rate[SD_CELL_COMPONENTS];
  assert(c->asked && e->work.cell.on);
  if (check_width(e, messages) != SD_OK) return SD_ERROR_NUMERIC;
  add_displacements(e, s->phase_step < CELL_EVERY ? s->phase_step : CELL_EVERY);
  flip_offset(e);
  choose_rates(e, c, over, rate);
  set_gradient(e, rate, over, c->boundary);
  note_places(e);
  return SD_OK;
}
