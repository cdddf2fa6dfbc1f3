/* sample.c: running statistics in the state; see sample.h. */
#include "measure/sample.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "model/visits.h"
#include "physics/step/access.h"

static double angle_of(const engine *e, size_t k) {
  uint32_t slot = engine_slot(e, e->model->rotations[k]);
  return e->state->theta[slot] + e->state->turn[slot];
}

/* Contact k (two per watch) as it is now, and its normal force. */
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
  for (size_t c = 2 * k; s->measured == 0 && c < 2 * k + 2; c++) contact_now(e, c, &s->visit_reference[c]);
}

void sample_begin(engine *e) {
  sd_state *s = e->state;
  double force;
  for (size_t k = 0; k < s->n_rotations; k++) {
    double angle = angle_of(e, k);
    double unmeasured = s->measured == 0 ? angle - s->rotation_start[k] : angle - s->rotation_stop[k];
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
  for (size_t k = 0; k < e->state->n_rotations; k++) e->state->rotation_stop[k] = angle_of(e, k);
}

/* Neighbouring bins become one: the record covers any length with SD_BINS bins at most. */
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
    double angle = angle_of(e, k);
    s->rotation_bin[k * SD_BINS + (size_t)s->bins] = angle - s->rotation_last[k];
    s->rotation_last[k] = angle;
  }
  if (++s->bins == SD_BINS) halve_bins(s);
}

/* In the order of sums of lanes_pass.h. */
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

void sample_step(engine *e) {
  sd_state *s = e->state;
  s->measured++;
  for (size_t k = 0; k < s->n_slides; k++) count_slides(e, k);
  sample_bins(e);
}

/* bin_steps is a power of two */
void sample_bins(engine *e) {
  const sd_state *s = e->state;
  if (s->n_rotations && (s->measured & (s->bin_steps - 1)) == 0) close_bin(e);
}

int64_t sample_room(const engine *e) {
  const sd_state *s = e->state;
  return s->n_rotations ? s->bin_steps - (s->measured & (s->bin_steps - 1)) : INT64_MAX;
}
