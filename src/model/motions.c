/* motions.c: checks of prescribed motions, estimates of their displacements, and the search for
 * disks that motions prescribe; see motions.h. */
#include "model/motions.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/rows.h"

#define LANE_WIDTH 1
#include "base/lane.h"

#include "base/math.h"
#include "model/waveforms.h"

/* --- kinds of motion -------------------------------------------------------------------------- */

void check_square(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_motion *q = &m->motions[k];
  const double least = 8.0; /* smallest number of time steps per change of sides */
  double steps = q->rise * M_PI / (fabs(q->omega) * m->dt);
  if (!(q->rise > 0.0 && q->rise <= 1.0))
    fail_about(messages, about_motion(m, k), "rise = %g: expected a number > 0, at most 1",
               q->rise);
  else if (steps < least)
    fail_about(messages, about_motion(m, k),
               "rise = %g: a change of sides takes %.3g steps, expected %g or more: a larger rise "
               "or a smaller dt",
               q->rise, steps, least);
}

static void check_random(const sd_model *m, size_t k, sd_messages *msg) {
  const sd_motion *q = &m->motions[k];
  if (!(q->omega > 0.0) || !(q->damping > 0.0) || q->interval < 1)
    fail_about(msg, about_motion(m, k), "expected omega > 0, damping > 0, interval >= 1");
}

static void check_table(const sd_model *m, size_t k, sd_messages *msg) {
  const sd_motion *q = &m->motions[k];
  if (q->n_table < 3) fail_about(msg, about_motion(m, k), "table: expected 3 rows or more");
  for (size_t r = 0; r < q->n_table; r++)
    if (!isfinite(q->table_time[r]) || !isfinite(q->table_value[r])) {
      fail_about(msg, about_motion(m, k), "table: expected finite numbers (row %zu)", r);
      break;
    }
  for (size_t r = 1; r < q->n_table; r++)
    if (!(q->table_time[r] > q->table_time[r - 1])) {
      fail_about(msg, about_motion(m, k), "table: time must increase (row %zu)", r);
      break;
    }
  if (q->periodic && q->n_table && q->table_value[0] != q->table_value[q->n_table - 1])
    fail_about(msg, about_motion(m, k), "table: periodic, so the last value must equal the first");
}

#define ROW(kind, word, source, amplitude, check, ...) [kind] = {#word, source, amplitude, check},
const motion_kind motion_kinds[SD_MOTION_KINDS] = {MOTION_KINDS(ROW)};
#undef ROW

double motion_period(const sd_motion *q) {
  if (motion_is_wave(q)) return 2 * M_PI / fabs(q->omega);
  return motion_source(q) == SIGNAL_TABLE && q->periodic
             ? q->table_time[q->n_table - 1] - q->table_time[0]
             : 0;
}

/* Fewest steps per cycle of a wave; with fewer, its samples are those of a slower wave
 * (aliasing). */
static const double FEWEST_STEPS = 4;

void motion_check(const sd_model *m, size_t k, sd_messages *msg) {
  const sd_motion *q = &m->motions[k];
  const bool swings = motion_is_wave(q) && q->amplitude != 0 && m->dt > 0;
  const double steps = swings ? motion_period(q) / m->dt : HUGE_VAL;
  if (steps < FEWEST_STEPS)
    fail_about(msg, about_motion(m, k),
               "a cycle takes %.3g steps: expected %g or more: a lower frequency or a smaller dt",
               steps, FEWEST_STEPS);
  if (motion_kinds[q->kind].check) motion_kinds[q->kind].check(m, k, msg);
}

double motion_amplitude(const sd_motion *q) {
  return motion_is_wave(q) || motion_source(q) == SIGNAL_RANDOM ? fabs(q->amplitude) : HUGE_VAL;
}

void motion_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
#define SHAPE_CASE(kind, word, ...)                                                                \
  case kind: word##_shape(q, shape); return;
  switch (q->kind) {
    WAVEFORMS(SHAPE_CASE)
    default: assert(!"a wave");
  }
#undef SHAPE_CASE
}

/* Value of a tabulated motion at time t: linear interpolation between rows of the table, times
 * the amplitude. */
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
  if (q->kind == SD_MOTION_HARMONIC) return part * q->amplitude * math_sin(q->omega * t + q->phase);
  motion_shape(q, shape);
  wave_at_w1(q->kind, (q->omega * t + q->phase) / (2 * M_PI), shape, &u, &v);
  return part * u;
}

double motion_first(const sd_motion *q) {
  if (q->ramp > 0) return 0;
  return motion_source(q) == SIGNAL_RANDOM ? 3 * q->amplitude : motion_at(q, 0);
}

/* Largest displacement of a tabulated motion within a time dt before or after any row of the
 * table. */
static double table_stride(const sd_motion *q, double dt) {
  double most = 0;
  for (size_t r = 0; r < q->n_table; r++) {
    const double here = q->amplitude * q->table_value[r], t = q->table_time[r];
    if (t + dt > 0) most = math_max(most, fabs(table_at(q, t + dt) - here));
    if (t > 0) most = math_max(most, fabs(table_at(q, math_max(t - dt, 0)) - here));
  }
  return most;
}

double motion_stride(const sd_motion *q, double dt) {
  double shape[WAVE_SHAPE];
  switch (motion_source(q)) {
    case SIGNAL_STEADY: return fabs(q->velocity) * dt;
    case SIGNAL_TABLE: return table_stride(q, dt);
    case SIGNAL_RANDOM:
      return 3 * fabs(q->amplitude) * math_min(q->omega * dt * (double)q->interval, 2) /
             (double)q->interval;
    case SIGNAL_FEEDBACK: return q->kind == SD_MOTION_SERVO ? q->velocity * dt : 0;
    case SIGNAL_WAVE: break;
  }
  motion_shape(q, shape); /* shape[1] is the largest velocity of the wave */
  return math_min(fabs(shape[1]) * dt, 2 * fabs(q->amplitude));
}

/* --- prescribed disks ------------------------------------------------------------------------- */

/* Makes a driven disk free, with all coordinates locked. Contacts are evaluated only if one of
 * the bodies is a free disk; in a model without free disks, this function is applied to the
 * disks that motions move, or to all disks if motions move walls. */
static void free_one(sd_model *m, size_t disk) {
  sd_disk *d = &m->disks[disk];
  if (!d->driven || !(d->mass > 0) || d->clump > 0) return;
  d->driven = false;
  for (int c = 0; c < SD_COORDINATES; c++) d->locked[c] = true;
  m->n_free++;
}

/* Makes disks free, with locked coordinates, in a model without free disks: those that motions
 * move, and all disks if motions move walls. */
static void free_moved_disks(sd_model *m) {
  bool walls = false;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      const bool leads = m->motions[k].amplitude != 0 || m->motions[k].velocity != 0;
      if (body < m->n_disks && leads) free_one(m, body);
      walls = walls || (body >= m->n_disks && body < m->n_disks + m->n_walls);
    }
  for (size_t i = 0; walls && i < m->n_disks; i++) free_one(m, i);
}

unsigned char *model_moved(const sd_model *m) {
  unsigned char *moved;
  if (!memory_row(&moved, model_held(m), 1)) return NULL;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      uint32_t body = m->motions[k].bodies[b];
      if (body < model_held(m)) moved[body] |= (unsigned char)(1u << m->motions[k].coordinate);
    }
  return moved;
}

void model_make_holdable(sd_model *m, uint32_t disk, unsigned moved) {
  sd_disk *d = &m->disks[disk];
  if (disk_holds(d)) return;
  d->held = d->held || d->driven || moved;
  for (int c = 0; c < SD_COORDINATES; c++)
    d->holds[c] = d->driven || (moved & 7) == 0 || moved >> c & 1;
  d->driven = false;
}

/* Makes the disks that are held from the start, or that a phase holds or releases, holdable. */
static void find_holdable(sd_model *m, const unsigned char *moved) {
  for (uint32_t i = 0; i < model_held(m); i++)
    if (m->disks[i].held) model_make_holdable(m, i, moved[i]);
  for (size_t k = 0; k < m->n_phases; k++)
    for (size_t n = 0; n < m->phases[k].n_hold + m->phases[k].n_release; n++) {
      const sd_phase *p = &m->phases[k];
      const uint32_t disk = n < p->n_hold ? p->hold[n] : p->release[n - p->n_hold];
      if (disk < model_held(m)) model_make_holdable(m, disk, moved[disk]);
    }
}

sd_status model_find_driven(sd_model *m) {
  unsigned char *held = model_moved(m);
  if (!held) return SD_ERROR_IO;
  m->n_free = m->n_disks - model_held(m);
  find_holdable(m, held);
  for (size_t i = 0; i < model_held(m); i++) {
    for (int c = 0; c < 3; c++)
      if (m->disks[i].locked[c]) held[i] |= (unsigned char)(1u << c);
    if (held[i] == 7 && !disk_holds(&m->disks[i])) m->disks[i].driven = true;
    m->n_free += !m->disks[i].driven;
  }
  free(held);
  if (m->n_free == 0) free_moved_disks(m);
  assert(m->n_free <= m->n_disks);
  return SD_OK;
}

double strides_arm(const sd_model *m, uint32_t body) {
  if (body < m->n_disks || body >= m->n_disks + m->n_walls) return 0;
  const sd_wall *w = &m->walls[body - m->n_disks];
  double ends = 0;
  if (w->kind == SD_WALL_CIRCLE) return 0;
  if (w->kind == SD_WALL_ARC)
    ends = math_hypot(w->center[0] - w->pivot[0], w->center[1] - w->pivot[1]) + w->radius;
  for (size_t k = 0; k < w->n_points; k++)
    ends = math_max(ends, math_hypot(w->points[k][0] - w->pivot[0], w->points[k][1] - w->pivot[1]));
  return ends;
}

/* Displacement of a body's farthest point per unit of motion q, divided by the radius of the
 * smallest free disk; 0: motion of a surface, or no free disk. */
static double lever(const sd_model *m, const sd_motion *q, uint32_t body) {
  if (!(m->smallest_radius > 0) || !isfinite(m->smallest_radius) || q->coordinate == SD_SURFACE)
    return 0;
  return (q->coordinate == SD_THETA ? strides_arm(m, body) : 1) / m->smallest_radius;
}

/* True if the motion is switched on in any phase of the run. */
static bool runs(const sd_model *m, size_t motion) {
  bool any = m->n_phases == 0;
  for (size_t k = 0; k < m->n_phases; k++)
    any = any || !m->phases[k].active || m->phases[k].active[motion];
  return any;
}

bool strides_longest(const sd_model *m, body_stride *longest) {
  const size_t n = model_movables(m);
  body_stride *all;
  double *sums;
  *longest = (body_stride){0};
  if (!memory_rows(2, (memory_column[]){{&all, n, sizeof *all}, {&sums, n, sizeof *sums}})) {
    shortage_note();
    return false;
  }
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    const double far = runs(m, k) ? motion_stride(q, m->dt) : 0;
    for (size_t b = 0; b < q->n_bodies && far > 0; b++) {
      const uint32_t body = q->bodies[b];
      const double length = far * lever(m, q, body);
      sums[body] += length;
      if (length > all[body].length) all[body] = (body_stride){body, k, length};
      if (sums[body] > longest->length)
        *longest = (body_stride){body, all[body].motion, sums[body]};
    }
  }
  free(all);
  free(sums);
  return longest->length > 0;
}

/* Safety factor: in one step a random motion, or the spline through a table, can move farther
 * than the estimate motion_stride, but not by this factor. */
static const double FARTHER = 3;

bool strides_are_long(const sd_model *m) {
  const double limit = m->limits.displacement;
  body_stride longest;
  if (!(limit > 0) || m->n_motions == 0) return false;
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (motion_is_feedback(q)) return true;
    if (FARTHER * strides_first_jump(m, k) > STRIDES_JUMP * limit) return true;
  }
  return strides_longest(m, &longest) && FARTHER * longest.length > STRIDES_JUMP * limit;
}

double strides_first_jump(const sd_model *m, size_t motion) {
  const sd_motion *q = &m->motions[motion];
  double most = 0;
  if (!runs(m, motion)) return 0;
  for (size_t b = 0; b < q->n_bodies; b++) most = math_max(most, lever(m, q, q->bodies[b]));
  return most * fabs(motion_first(q));
}
