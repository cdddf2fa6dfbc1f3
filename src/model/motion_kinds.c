/* motion_kinds.c: see motion_kinds.h. */
#include "model/motion_kinds.h"

#include <assert.h>

#define LANE_WIDTH 1
#include "base/lane.h"

#include "model/waveforms.h"

static void check_random(const sd_motion *q, double dt, const char *name, sd_messages *msg) {
  (void)dt;
  if (!(q->omega > 0.0) || !(q->damping > 0.0) || q->interval < 1)
    sd_fail(msg, SD_ERROR_USER, "motion \"%s\": expected omega > 0, damping > 0, interval >= 1", name);
}

static void check_table(const sd_motion *q, double dt, const char *name, sd_messages *msg) {
  (void)dt;
  if (q->n_table < 3) sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: expected 3 rows or more", name);
  for (size_t r = 0; r < q->n_table; r++)
    if (!isfinite(q->table_time[r]) || !isfinite(q->table_value[r])) {
      sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: expected finite numbers (row %zu)", name, r);
      break;
    }
  for (size_t r = 1; r < q->n_table; r++)
    if (!(q->table_time[r] > q->table_time[r - 1])) {
      sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: time must increase (row %zu)", name, r);
      break;
    }
  if (q->periodic && q->n_table && q->table_value[0] != q->table_value[q->n_table - 1])
    sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: periodic, so the last value must equal the first",
            name);
}

#define ROW(kind, word, source, amplitude, check, ...) [kind] = {#word, source, amplitude, check},
const motion_kind motion_kinds[SD_MOTION_KINDS] = {MOTION_KINDS(ROW)};
#undef ROW

double motion_period(const sd_motion *q) {
  if (motion_is_wave(q)) return 2 * M_PI / fabs(q->omega);
  return motion_source(q) == SIGNAL_TABLE && q->periodic ? q->table_time[q->n_table - 1] - q->table_time[0]
                                                         : 0;
}

/* Steps per cycle of a wave below which its values at the steps are those of another wave. */
static const double FEWEST_STEPS = 4;

void motion_check(const sd_motion *q, double dt, const char *name, sd_messages *messages) {
  const bool swings = motion_is_wave(q) && q->amplitude != 0 && dt > 0;
  const double steps = swings ? motion_period(q) / dt : HUGE_VAL;
  if (steps < FEWEST_STEPS)
    sd_fail(messages, SD_ERROR_USER,
            "%s: a cycle takes %.3g steps: expected %g or more: a lower frequency or a smaller dt", name,
            steps, FEWEST_STEPS);
  if (motion_kinds[q->kind].check) motion_kinds[q->kind].check(q, dt, q->name ? q->name : "?", messages);
}

double motion_reach(const sd_motion *q) {
  return motion_is_wave(q) || motion_source(q) == SIGNAL_RANDOM ? fabs(q->amplitude) : HUGE_VAL;
}

void motion_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
#define SHAPE_CASE(kind, word, ...)                                                                          \
  case kind: word##_shape(q, shape); return;
  switch (q->kind) {
    WAVEFORMS(SHAPE_CASE)
    default: assert(!"a wave");
  }
#undef SHAPE_CASE
}

/* Straight between its rows. */
static double table_at(const sd_motion *q, double t) {
  const size_t last = q->n_table - 1;
  const double from = q->table_time[0], to = q->table_time[last];
  if (q->periodic) t -= (to - from) * floor((t - from) / (to - from));
  if (!(t > from)) return q->amplitude * q->table_value[0];
  if (!(t < to)) return q->amplitude * q->table_value[last];
  size_t low = 0, high = last;
  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    *(q->table_time[middle] <= t ? &low : &high) = middle;
  }
  const double part = (t - q->table_time[low]) / (q->table_time[high] - q->table_time[low]);
  return q->amplitude * (q->table_value[low] + part * (q->table_value[high] - q->table_value[low]));
}

double motion_at(const sd_motion *q, double t) {
  double shape[WAVE_SHAPE] = {0}, u = 0, v;
  const double part = q->ramp > 0 && t < q->ramp ? t / q->ramp : 1;
  if (motion_source(q) == SIGNAL_STEADY) return part * q->velocity * t;
  if (motion_source(q) == SIGNAL_TABLE) return part * table_at(q, t);
  if (!motion_is_wave(q)) return 0;
  if (q->kind == SD_MOTION_HARMONIC) return part * q->amplitude * sin(q->omega * t + q->phase);
  motion_shape(q, shape);
  wave_at_w1(q->kind, (q->omega * t + q->phase) / (2 * M_PI), shape, &u, &v);
  return part * u;
}

double motion_first(const sd_motion *q) {
  if (q->ramp > 0) return 0;
  return motion_source(q) == SIGNAL_RANDOM ? 3 * q->amplitude : motion_at(q, 0);
}

/* Beside each row, to either side. */
static double table_stride(const sd_motion *q, double dt) {
  double most = 0;
  for (size_t r = 0; r < q->n_table; r++) {
    const double here = q->amplitude * q->table_value[r], t = q->table_time[r];
    if (t + dt > 0) most = fmax(most, fabs(table_at(q, t + dt) - here));
    if (t > 0) most = fmax(most, fabs(table_at(q, fmax(t - dt, 0)) - here));
  }
  return most;
}

double motion_stride(const sd_motion *q, double dt) {
  double shape[WAVE_SHAPE];
  switch (motion_source(q)) {
    case SIGNAL_STEADY: return fabs(q->velocity) * dt;
    case SIGNAL_TABLE: return table_stride(q, dt);
    case SIGNAL_RANDOM:
      return 3 * fabs(q->amplitude) * fmin(q->omega * dt * (double)q->interval, 2) / (double)q->interval;
    case SIGNAL_FEEDBACK: return q->kind == SD_MOTION_SERVO ? q->velocity * dt : 0;
    case SIGNAL_WAVE: break;
  }
  motion_shape(q, shape); /* the second number is the largest velocity */
  return fmin(fabs(shape[1]) * dt, 2 * fabs(q->amplitude));
}
