/* sample.c: adds measured steps to the running statistics in the state (see sample.h). */
#include "measure/sample.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "model/model.h"
#include "model/state.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/system/bodies.h"

static double angle_of(const sd_state *s, size_t slot) { return s->theta[slot] + s->turn[slot]; }

static double watched_angle(const engine *e, size_t k) {
  return angle_of(e->state, engine_slot(e, e->model->rotations[k]));
}

/* Returns the state of watched contact k (each watched pair has two): open, stuck, or sliding with
 * a sign; *force receives its normal force. */
static int contact_now(const engine *e, size_t k, double *force) {
  int64_t at = engine_watched(e, k);
  *force = at < 0 ? 0.0 : engine_contact_force(e, (size_t)at);
  if (at < 0) return SD_OPEN;
  int sliding = engine_contact_sliding(e, (size_t)at);
  return sliding > 0 ? SD_SLIDE_POSITIVE : sliding < 0 ? SD_SLIDE_NEGATIVE : SD_STUCK;
}

static void begin_visits(engine *e, size_t k) {
  sd_state *s = e->state;
  visits_cut(s, k);
  for (size_t c = 2 * k; s->measured == 0 && c < 2 * k + 2; c++)
    contact_now(e, c, &s->visit_reference[c]);
}

void sample_begin(engine *e) {
  sd_state *s = e->state;
  double force;
  for (size_t k = 0; k < s->n_rotations; k++) {
    double angle = watched_angle(e, k);
    double unmeasured =
        s->measured == 0 ? angle - s->rotation_start[k] : angle - s->rotation_stop[k];
    s->rotation_start[k] += unmeasured;
    s->rotation_last[k] = s->measured == 0 ? angle : s->rotation_last[k] + unmeasured;
  }
  for (size_t k = 0; k < 2 * s->n_slides; k++) {
    if (s->measured == 0) s->slide_force_min[k] = HUGE_VAL;
    s->slide_was_open[k] = contact_now(e, k, &force) == SD_OPEN;
  }
  for (size_t k = 0; k < s->n_visits; k++) begin_visits(e, k);
}

void sample_end(engine *e) {
  for (size_t k = 0; k < e->state->n_rotations; k++)
    e->state->rotation_stop[k] = watched_angle(e, k);
}

/* Merges each two neighbouring bins into one, so that a record of any length needs at most SD_BINS
 * bins. */
static void halve_bins(sd_state *s) {
  for (size_t k = 0; k < s->n_rotations; k++) {
    double *bin = s->rotation_bin + k * SD_BINS;
    for (int b = 0; b < SD_BINS / 2; b++) bin[b] = bin[2 * b] + bin[2 * b + 1];
    for (int b = SD_BINS / 2; b < SD_BINS; b++) bin[b] = 0.0;
  }
  assert(s->bins == SD_BINS);
  s->bins /= 2;
  s->bin_steps *= 2;
}

static void close_bin(engine *e) {
  sd_state *s = e->state;
  assert(s->bins >= 0 && s->bins < SD_BINS && (s->bins + 1) * s->bin_steps == s->measured);
  for (size_t k = 0; k < s->n_rotations; k++) {
    double angle = watched_angle(e, k);
    s->rotation_bin[k * SD_BINS + (size_t)s->bins] = angle - s->rotation_last[k];
    s->rotation_last[k] = angle;
  }
  if (++s->bins == SD_BINS) halve_bins(s);
}

/* Adds one step to the sums of the current visit of watched pair k, i.e. its stay in one sliding
 * configuration. lanes_pass.h adds in the same order, so that the results are bitwise equal. */
static void sum_visits(engine *e, size_t k, const int now[2], const double force[2]) {
  sd_state *s = e->state;
  const int class = visits_class(now[0], now[1]);
  const int64_t before = s->measured - 1;
  double tau[2] = {0.0, 0.0}, *part = s->visit_part + VISIT_SUMS * k;
  if (class != s->visit_class[k] || visits_left(s, k, before) == 0.0) {
    visits_next(s, k, class, part, 1, before);
    memset(part, 0, VISIT_SUMS * sizeof *part);
  }
  for (size_t side = 0; side < 2; side++) {
    int64_t at = engine_watched(e, 2 * k + side);
    if (at >= 0) tau[side] = engine_contact_tau(e, (size_t)at);
  }
  const double torque = (tau[0] + tau[1]) * s->radius[engine_slot(e, e->model->slides[k].disk)];
  part[VISIT_TORQUE] += torque;
  part[VISIT_TORQUE2] += torque * torque;
  for (size_t side = 0; side < 2; side++) {
    const double beyond = force[side] - s->visit_reference[2 * k + side];
    part[VISIT_FORCE + 2 * side] += beyond;
    part[VISIT_FORCE2 + 2 * side] += beyond * beyond;
  }
}

static void count_slides(engine *e, size_t k) {
  sd_state *s = e->state;
  int now[2];
  double forces[2];
  for (size_t side = 0; side < 2; side++) {
    size_t c = 2 * k + side;
    now[side] = contact_now(e, c, &forces[side]);
    const double force = forces[side];
    if (force < s->slide_force_min[c]) s->slide_force_min[c] = force;
    int open = now[side] == SD_OPEN;
    if (open == s->slide_was_open[c]) continue;
    s->slide_openings[c] += open;
    s->slide_was_open[c] = open;
  }
  s->slide_count[16 * k + 4 * (size_t)now[0] + (size_t)now[1]]++;
  if (s->n_visits) sum_visits(e, k, now, forces);
}

void sample_steps(engine *e, int64_t n) {
  sd_state *s = e->state;
  assert(n == 1 || n <= sample_steps_to_look(e));
  s->measured += n;
  for (size_t k = 0; k < s->n_slides; k++) count_slides(e, k);
  sample_bins(e);
}

/* Closes the current bin of the watched angles if it is complete. bin_steps is a power of two. */
void sample_bins(engine *e) {
  const sd_state *s = e->state;
  if (s->n_rotations && (s->measured & (s->bin_steps - 1)) == 0) close_bin(e);
}

int64_t sample_steps_to_bin_end(const engine *e) {
  const sd_state *s = e->state;
  return s->n_rotations ? s->bin_steps - (s->measured & (s->bin_steps - 1)) : INT64_MAX;
}

static int64_t bin_length(int64_t measured);

int64_t sample_steps_to_look(const engine *e) {
  const sd_state *s = e->state;
  const int64_t bins = sample_steps_to_bin_end(e);
  if (s->n_slides) return 1;
  if (!e->model->measure_disks) return bins;
  const int64_t every = e->model->measure_every, length = bin_length(s->measured),
                sample = every - s->measured % every, close = length - s->measured % length;
  const int64_t means = sample < close ? sample : close;
  return bins < means ? bins : means;
}

/* --- means of every disk ---------------------------------------------------------------------- */

static double absolute_x(const engine *e, size_t i) {
  return e->state->x[i] + e->state->image_x[i] * engine_length(e, SD_X);
}

static double absolute_y(const engine *e, size_t i) {
  return e->state->y[i] + e->state->image_y[i] * engine_length(e, SD_Y);
}

void disks_begin(engine *e) {
  sd_state *s = e->state;
  losses_update(e);
  for (size_t i = 0; i < s->n_means; i++) {
    double angle = angle_of(s, i);
    if (s->measured == 0) {
      bool there = body_in_play(s, i);
      s->mean_angle[i] = s->mean_last[i] = angle;
      s->mean_x0[i] = there ? absolute_x(e, i) : NAN;
      s->mean_y0[i] = there ? absolute_y(e, i) : NAN;
    } else {
      double unmeasured = angle - s->mean_stop[i];
      s->mean_angle[i] += unmeasured;
      s->mean_last[i] += unmeasured;
    }
    s->sum_viscous[i] -= s->loss_viscous[i];
    s->sum_friction[i] -= s->loss_friction[i];
    s->sum_opening[i] -= s->loss_opening[i];
  }
}

void disks_end(engine *e) {
  sd_state *s = e->state;
  losses_update(e);
  for (size_t i = 0; i < s->n_means; i++) {
    s->mean_stop[i] = angle_of(s, i);
    s->sum_viscous[i] += s->loss_viscous[i];
    s->sum_friction[i] += s->loss_friction[i];
    s->sum_opening[i] += s->loss_opening[i];
  }
}

/* --- record of angles ------------------------------------------------------------------------- */

/* Returns the number of steps per bin after `measured` steps: the smallest power of two for which
 * the record is not full. */
static int64_t bin_length(int64_t measured) {
  assert(measured >= 0);
  int64_t steps = 1;
  while (measured / steps >= SD_MEAN_BINS) steps *= 2;
  return steps;
}

/* Stores the angle turned in bin b for disks begin ... end - 1. If b is the last bin, merges each
 * two neighbouring bins into one. */
static void close_mean_bin(sd_state *s, size_t begin, size_t end, size_t b) {
  assert(b < SD_MEAN_BINS && end <= s->n_means);
  for (size_t i = begin; i < end; i++) {
    double *bin = s->mean_bin + i * SD_MEAN_BINS, angle = angle_of(s, i);
    bin[b] = angle - s->mean_last[i];
    s->mean_last[i] = angle;
    if (b + 1 < SD_MEAN_BINS) continue;
    for (size_t k = 0; k < SD_MEAN_BINS / 2; k++) bin[k] = bin[2 * k] + bin[2 * k + 1];
    memset(bin + SD_MEAN_BINS / 2, 0, SD_MEAN_BINS / 2 * sizeof *bin);
  }
}

/* --- samples ---------------------------------------------------------------------------------- */

/* Adds the contacts of each disk, their sliding and their normal forces to its sums. Candidate
 * pairs that are open have no overlap and no force and do not slide, so they add nothing. */
static void sample_contacts(engine *e, size_t begin, size_t end) {
  sd_state *s = e->state;
  for (size_t i = begin; i < end; i++) {
    double contacts = 0.0, sliding = 0.0, force = 0.0;
    for (size_t at = engine_first(e, i); at < engine_first(e, i + 1); at++) {
      size_t k = engine_candidate(e, at);
      /* A pair held by attraction alone is no contact. */
      const bool touches = engine_contact_overlap(e, k) > 0.0;
      contacts += touches ? 1.0 : 0.0;
      sliding += touches && engine_contact_sliding(e, k) != 0 ? 1.0 : 0.0;
      force += engine_contact_force(e, k);
    }
    s->sum_contacts[i] += contacts;
    s->sum_sliding[i] += sliding;
    s->sum_force[i] += force;
  }
}

/* Adds the displacements of n disks from their start points along one coordinate, and the squares,
 * to sum[] and square[]. length: length of the periodic box along this coordinate, 0: not
 * periodic. */
static void add_displacements(size_t n, const double *restrict x, const int32_t *restrict image,
                              double length, const double *restrict start, double *restrict sum,
                              double *restrict square) {
  for (size_t i = 0; i < n; i++) {
    double d = x[i] + image[i] * length - start[i];
    sum[i] += d;
    square[i] += d * d;
  }
}

static void add_energies(size_t n, const double *restrict mass, const double *restrict vx,
                         const double *restrict vy, double *restrict sum) {
  for (size_t i = 0; i < n; i++) sum[i] += 0.5 * mass[i] * (vx[i] * vx[i] + vy[i] * vy[i]);
}

static void sample_poses(engine *e, size_t begin, size_t end) {
  sd_state *s = e->state;
  const double length[2] = {engine_length(e, SD_X), engine_length(e, SD_Y)};
  size_t k = begin, n = end - begin;
  add_displacements(n, s->x + k, s->image_x + k, length[0], s->mean_x0 + k, s->sum_x + k,
                    s->sum_xx + k);
  add_displacements(n, s->y + k, s->image_y + k, length[1], s->mean_y0 + k, s->sum_y + k,
                    s->sum_yy + k);
  add_energies(n, s->mass + k, s->vx + k, s->vy + k, s->sum_kinetic + k);
  for (size_t i = begin; i < end; i++)
    s->sum_spin[i] += 0.5 * s->inertia[i] * s->omega[i] * s->omega[i];
}

/* --- power of prescribed bodies --------------------------------------------------------------- */

/* Velocities of the prescribed coordinates of a body; 0 for its free coordinates. */
typedef struct drive {
  double vx, vy, omega;
} drive;

static drive drive_of(const engine *e, size_t slot) {
  const sd_state *s = e->state;
  drive d = {s->vx[slot], s->vy[slot], s->omega[slot]};
  if (slot >= s->n_free && slot < s->n_free + s->n_ghosts) return (drive){0};
  if (slot >= s->n_free) return d;
  if (engine_columns(e, SD_X)->inverse[slot] != 0.0) d.vx = 0.0;
  if (engine_columns(e, SD_Y)->inverse[slot] != 0.0) d.vy = 0.0;
  if (engine_columns(e, SD_THETA)->inverse[slot] != 0.0) d.omega = 0.0;
  return d;
}

/* Returns the power that a body with the prescribed motion d transfers to its partner through one
 * contact: minus the power of the contact force on the body. push: this force and its torque, the
 * same as in motion_work. */
static double power_of(contact_push push, drive d) {
  return -((push.x * d.vx + push.y * d.vy) + push.torque * d.omega);
}

/* Adds the power of a body with prescribed coordinates to the sums of the free disks that it
 * touches. A free disk with prescribed coordinates may touch a wall or a prescribed disk: this
 * power is added to the disk itself, as no free disk is on the other side. */
static void add_power(engine *e, size_t kept) {
  sd_state *s = e->state;
  size_t slot = engine_kept_slot(e, kept), first = engine_first(e, slot);
  drive d = drive_of(e, slot);
  if (d.vx == 0.0 && d.vy == 0.0 && d.omega == 0.0) return;
  for (size_t at = first; at < engine_first(e, slot + 1); at++) {
    if (!engine_contact_closed(e, engine_candidate(e, at))) continue;
    size_t other = engine_partner(e, at);
    s->sum_injected[other < s->n_free ? other : slot] +=
        power_of(engine_push(e, kept, at - first), d);
  }
}

/* Adds the powers of all bodies with prescribed coordinates, in the order of their slots. They are
 * few, so one thread does it. */
static void sample_powers(engine *e) {
  for (size_t k = 0; k < engine_listed(e); k++) add_power(e, k);
}

/* --- step ------------------------------------------------------------------------------------- */

void disks_step(engine *e, const team *t, int64_t measured) {
  sd_state *s = e->state;
  /* no early return for ranks without disks: they count samples, too */
  if (!e->model->measure_disks) return;
  size_t begin, end;
  team_share(t, s->n_means, &begin, &end);
  int64_t length = bin_length(measured - 1);
  bool sampled = measured % e->model->measure_every == 0;
  if (measured % length == 0) close_mean_bin(s, begin, end, (size_t)(measured / length - 1));
  if (sampled) {
    sample_contacts(e, begin, end);
    sample_poses(e, begin, end);
  }
  if (t->rank != 0) return;
  if (sampled) sample_powers(e);
  s->mean_samples += sampled;
  s->mean_bin_steps = bin_length(measured);
  s->mean_bins = measured / s->mean_bin_steps;
}
