/* rain.c: releases batches of falling disks: times, disks and positions of the batches (see
 * rain.h). */
#include "base/gsl.h"
#include "pack/rain.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/clumps.h"
#include "physics/contact/energy.h"
#include "physics/contact/walls.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/system/bodies.h"
#include "physics/system/clumps.h"
#include "physics/system/fields.h"

/* ROW_FILL: largest fraction of a row's width that the diameters of its disks take. ROW_GAP:
 * vertical gap above a row, as a fraction of its largest radius. */
static const double ROW_FILL = 0.9, ROW_GAP = 0.1;
/* Relative tolerance: a disk that overlaps a wall by no more than this fraction of its radius is
 * accepted. */
static const double ROUNDING = 1e-9;

/* --- times of batches ------------------------------------------------------------------------- */

int64_t rain_next(const engine *e, int64_t step) {
  int64_t next = INT64_MAX;
  for (size_t k = 0; k < e->model->n_rains; k++) {
    const sd_rain *r = &e->model->rains[k];
    int64_t batches = (int64_t)((r->count + r->batch - 1) / r->batch);
    int64_t batch = step < 0 ? 0 : step / r->interval + 1;
    if (batch < batches && batch * r->interval < next) next = batch * r->interval;
  }
  return next;
}

int64_t rain_waiting(const sd_model *m, const sd_state *s) {
  int64_t all = 0;
  for (size_t k = 0; k < m->n_rains; k++) all += (int64_t)m->rains[k].count;
  assert(s->released >= 0 && s->released <= all);
  return all - s->released;
}

bool rain_waits(const engine *e) { return rain_waiting(e->model, e->state) > 0; }

/* Release position of one disk; leads: 1 for the first disk of a grain (a single disk or a clump),
 * else 0. */
typedef struct rain_drop {
  uint32_t disk, leads;
  double x, y;
} rain_drop;

/* --- obstacles -------------------------------------------------------------------------------- */

/* Returns the height of the top of the highest disk in the strip (range of x) of the rain, at least
 * r->floor - r->gap. */
static double top_of(const engine *e, const sd_rain *r) {
  const sd_state *s = e->state;
  double top = r->floor - r->gap, middle = 0.5 * (r->lower + r->upper),
         half = 0.5 * (r->upper - r->lower);
  for (size_t i = 0; i < s->n_disks; i++) {
    if (i < s->n_free && !body_in_play(s, i)) continue;
    double dx = engine_nearest(e, SD_X, s->x[i] - middle);
    if (fabs(dx) < half + s->radius[i]) top = math_max(top, s->y[i] + s->radius[i]);
  }
  return top;
}

/* Returns true if the arc-shaped wall segment overlaps a disk at (x, y), or crosses the vertical
 * line below its centre at a height above `low`; a circle crosses it up to twice. q: point of g
 * nearest to (x, y). If g is the end point of an arc, only the overlap counts. */
static bool arc_blocks(const placed_segment *g, const nearest_point *q, double x, double y,
                       double radius, double low) {
  if (q->active && math_hypot(q->dx, q->dy) < radius * (1.0 - ROUNDING)) return true;
  const double dx = x - g->x;
  if (g->piece != SD_PIECE_CURVE || fabs(dx) >= g->radius) return false;
  for (int side = -1; side <= 1; side += 2) {
    const double height = g->y + side * sqrt(g->radius * g->radius - dx * dx);
    if (walls_nearest(g, x, height).active && height > low && height < y) return true;
  }
  return false;
}

/* Returns true if the wall segment overlaps a disk at (x, y), or passes below its centre at a
 * height above `low`. */
static bool segment_blocks(const placed_segment *g, double x, double y, double radius, double low) {
  nearest_point q = walls_nearest(g, x, y);
  if (g->piece != SD_PIECE_STRAIGHT) return arc_blocks(g, &q, x, y, radius, low);
  if (math_hypot(q.dx, q.dy) < radius * (1.0 - ROUNDING)) return true;
  if (g->tx == 0.0) return false;
  double along = (x - g->x) / g->tx, height = g->y + along * g->ty;
  return along >= g->backwards && along <= g->length && height > low && height < y;
}

static bool circle_blocks(const engine *e, size_t slot, double x, double y, double radius) {
  const sd_state *s = e->state;
  double dx = engine_nearest(e, SD_X, s->x[slot] - x), dy = s->y[slot] - y;
  double r = math_hypot(dx, dy), wall = s->radius[slot];
  return wall < 0.0 ? r + radius > -wall * (1.0 + ROUNDING)
                    : r < (wall + radius) * (1.0 - ROUNDING);
}

/* Returns the name of the first obstacle found for a disk that starts at (x, y) and falls to y =
 * low; NULL: the way is free. text: buffer for the name. */
static const char *obstacle(const engine *e, double x, double y, double radius, double low,
                            char *text, size_t size) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  for (size_t k = 0; k < m->n_segments; k++) {
    placed_segment image;
    const placed_segment *g = walls_image(engine_periods(e), engine_segment(e, k), x, y, &image);
    if (segment_blocks(g, x, y, radius, low))
      return sd_model_body_name(m, m->segments[k].body, text, size);
  }
  for (size_t slot = s->n_disks; slot < s->n_bodies; slot++)
    if (s->radius[slot] != 0.0 && circle_blocks(e, slot, x, y, radius))
      return sd_model_body_name(m, s->id[slot], text, size);
  if (m->bounds.given && !(x >= m->bounds.lower[SD_X] && x <= m->bounds.upper[SD_X] &&
                           y >= m->bounds.lower[SD_Y] && y <= m->bounds.upper[SD_Y]))
    return "the end of the bounds";
  return engine_beyond(e, SD_Y, y) ? "the edge of the periodic box" : NULL;
}

/* --- rows ------------------------------------------------------------------------------------- */

static clump_grain grain_of(const rain_sizes *b, size_t disk, size_t end) {
  return b->radius ? (clump_grain){1, b->radius[disk - b->first]}
                   : clumps_grain(b->model, disk, end);
}

size_t rain_row(const rain_sizes *b, size_t first, size_t end, double width) {
  double taken = 0.0;
  size_t n = 0;
  while (first + n < end) {
    const clump_grain grain = grain_of(b, first + n, end);
    taken += 2.0 * grain.radius;
    if (n > 0 && taken > ROW_FILL * width) break;
    n += grain.disks;
  }
  return n;
}

/* Mixes the bits of z (splitmix64), so that neighbouring seeds give unrelated sequences. */
static uint64_t mixed(uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

static gsl_rng *numbers_of(const engine *e, const sd_rain *r, int64_t batch) {
  uint64_t rain = (uint64_t)(r - e->model->rains);
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  gsl_rng *numbers = gsl_rng_alloc(gsl_rng_mt19937);
  gsl_set_error_handler(handler);
  uint64_t seed = mixed(mixed(mixed(e->model->seed) ^ rain) ^ (uint64_t)batch);
  if (!numbers) memory_lacks(0);
  gsl_rng_set(numbers, (unsigned long)(seed & 0xffffffffu));
  return numbers;
}

/* --- disks of a batch and their positions ----------------------------------------------------- */

static bool is_due(const engine *e, const sd_rain *r) {
  int64_t batch = e->state->step / r->interval;
  return e->state->step % r->interval == 0 &&
         batch < (int64_t)((r->count + r->batch - 1) / r->batch);
}

/* Returns the number of the first disk of the batch that is due at the present step. */
static size_t first_due(const engine *e, const sd_rain *r) {
  return r->first + (size_t)(e->state->step / r->interval) * r->batch;
}

static size_t count_due(const engine *e, const sd_rain *r) {
  const size_t left = r->first + r->count - first_due(e, r);
  return left < r->batch ? left : r->batch;
}

/* Returns the number of grains (single disks or clumps) among the disks first ... first + n - 1.
 * *largest: largest radius of a grain; *taken: sum of the grains' diameters. */
static size_t measure_row(const rain_sizes *b, size_t first, size_t n, double *largest,
                          double *taken) {
  size_t grains = 0;
  *largest = *taken = 0.0;
  for (size_t k = 0; k < n; grains++) {
    const clump_grain grain = grain_of(b, first + k, first + n);
    *taken += 2.0 * grain.radius;
    *largest = math_max(*largest, grain.radius);
    k += grain.disks;
  }
  return grains;
}

/* Places the disks first ... first + n - 1 side by side in a row whose lower edge is y = low, and
 * stores their positions in drops[0 ... n - 1]. Returns SD_ERROR_NUMERIC if something is in the way
 * of a disk that falls to y = end. gaps: scratch array of n numbers. */
static sd_status place_row(const engine *e, const sd_rain *r, const rain_sizes *b, size_t first,
                           size_t n, double low, double end, gsl_rng *numbers, double *gaps,
                           rain_drop *drops, sd_messages *messages) {
  const sd_model *m = e->model;
  double taken, largest;
  const size_t grains = measure_row(b, first, n, &largest, &taken);
  for (size_t k = 0; k < grains; k++) gaps[k] = gsl_rng_uniform(numbers);
  gsl_sort(gaps, 1, grains);
  double left = r->lower, slack = r->upper - r->lower - taken;
  uint32_t disk = (uint32_t)first;
  for (size_t k = 0; k < grains; k++) {
    const clump_grain grain = grain_of(b, disk, first + n);
    double radius = grain.radius, x = left + slack * gaps[k] + radius;
    double y = low + radius + 2.0 * (largest - radius) * gsl_rng_uniform(numbers);
    char name[96], wall[96];
    const char *what = obstacle(e, x, y, radius, end, wall, sizeof wall);
    if (what)
      return sd_fail(
          messages, SD_ERROR_NUMERIC,
          "step %lld: rain: %s has no room at (%g, %g), %s is in the way; expected a higher "
          "container, fewer disks, or more time between batches",
          (long long)e->state->step, sd_model_body_name(m, disk, name, sizeof name), x, y, what);
    for (size_t i = 0; i < grain.disks; i++)
      *drops++ = (rain_drop){disk + (uint32_t)i, i == 0, x, y};
    left += 2.0 * radius;
    disk += (uint32_t)grain.disks;
  }
  return SD_OK;
}

/* Computes the positions of all disks of the batch that is due, in rows above y = top. drops:
 * receives one element per disk of the batch. radius: radii of these disks, NULL: those of the
 * model. The walls must be at their poses of the current step. */
static sd_status plan(const engine *e, const sd_rain *r, double top, const double *radius,
                      rain_drop *drops, sd_messages *messages) {
  const size_t begin = first_due(e, r), last = begin + count_due(e, r);
  const rain_sizes b = {e->model, radius, begin};
  double *gaps = NULL, low = top + r->gap;
  if (!memory_resize_row(&gaps, last - begin, sizeof *gaps))
    return sd_fail(messages, SD_ERROR_IO, "out of memory for a batch of rain");
  gsl_rng *numbers = numbers_of(e, r, e->state->step / r->interval);
  sd_status status = SD_OK;
  /* one row above the other */
  for (size_t n, first = begin; status == SD_OK && first < last; first += n) {
    double largest, taken;
    n = rain_row(&b, first, last, r->upper - r->lower);
    measure_row(&b, first, n, &largest, &taken);
    /* Search for obstacles down to a point below the top of the highest disk, so that a lid that
     * presses on this disk is found. */
    double end = math_max(top - 0.5 * largest, r->floor);
    status =
        place_row(e, r, &b, first, n, low, end, numbers, gaps, drops + (first - begin), messages);
    low += (2.0 + ROW_GAP) * largest;
  }
  free(gaps);
  gsl_rng_free(numbers);
  return status;
}

/* --- release ---------------------------------------------------------------------------------- */

/* Returns the index in the state (slot) of a waiting disk; n_free if another rank has it. */
static size_t slot_here(const engine *e, size_t disk) {
  const size_t slot = engine_slot(e, (uint32_t)disk);
  return slot < e->state->n_free ? slot : e->state->n_free;
}

static void fill_radii(const engine *e, const sd_rain *r, double *radius) {
  const size_t first = first_due(e, r), n = count_due(e, r);
  for (size_t k = 0; k < n; k++) {
    const size_t i = slot_here(e, first + k);
    radius[k] = i < e->state->n_free ? e->state->radius[i] : 0.0;
  }
}

static void set_out(engine *e, const sd_rain *r, const rain_drop *drops) {
  sd_state *s = e->state;
  const size_t n = count_due(e, r);
  for (size_t k = 0; k < n; k++) {
    const rain_drop *d = &drops[k];
    const size_t i = slot_here(e, d->disk);
    s->released++;
    if (i == s->n_free) continue;
    assert(s->activity[i] == SD_WAITING);
    s->activity[i] = SD_IN_PLAY;
    s->x[i] = d->x;
    s->y[i] = d->y;
    s->vy[i] = -r->speed;
    const int clump = e->model->disks[d->disk].clump;
    if (clump > 0 && d->leads) clump_set_out(e, (size_t)clump - 1, d->x, d->y, -r->speed);
  }
}

/* Sets the accelerations of the released disks to those of free fall: gravity and fields, no
 * contacts. */
static void accelerate(engine *e, const sd_rain *r) {
  const size_t first = first_due(e, r), n = count_due(e, r);
  for (size_t k = first; k < first + n; k++) {
    const size_t i = slot_here(e, k);
    if (i == e->state->n_free) continue;
    body_forces_renew(e, i, i + 1);
    for (int c = 0; c < SD_COORDINATES; c++) engine_accelerate(e, c, i, 0.0);
  }
  for (size_t k = first; k < first + n; k++) {
    const sd_disk *d = &e->model->disks[k];
    if (d->clump > 0 && e->model->clumps[d->clump - 1].disks[0] == k)
      clump_accelerate(e, (size_t)d->clump - 1);
  }
}

/* Sends the radii of the disks of a batch to all ranks. Each rank has 0 in place of the radii of
 * other ranks' disks, so the sum over the ranks of the bit patterns, as integers, is exactly the
 * bit pattern of the radius. bits: scratch array of n numbers. */
static void share_radii(const engine *e, const sd_rain *r, size_t n, double *radius,
                        int64_t *bits) {
  fill_radii(e, r, radius);
  memcpy(bits, radius, n * sizeof *bits);
  comm_add(e->comm, bits, n);
  memcpy(radius, bits, n * sizeof *bits);
}

/* Releases one batch: rank 0 computes the positions and broadcasts them; each rank releases the
 * disks that it has. */
static sd_status release(engine *e, const sd_rain *r, sd_messages *messages) {
  const comm *c = e->comm;
  const size_t n = count_due(e, r);
  const double top = comm_largest(c, top_of(e, r));
  rain_drop *drops;
  double *radius;
  int64_t *bits;
  const memory_column arrays[] = {
      {&drops, n, sizeof *drops}, {&radius, n, sizeof *radius}, {&bits, n, sizeof *bits}};
  sd_status status = memory_rows(sizeof arrays / sizeof *arrays, arrays) ? SD_OK : SD_ERROR_IO;
  if (status != SD_OK) sd_fail(messages, status, "out of memory for a batch of rain");
  status = comm_agree(c, status);
  if (status == SD_OK) share_radii(e, r, n, radius, bits);
  if (status == SD_OK && comm_rank(c) == 0)
    status = plan(e, r, top, c ? radius : NULL, drops, messages);
  status = comm_agree(c, status);
  if (status == SD_OK) comm_broadcast(c, drops, n * sizeof *drops);
  if (status == SD_OK) set_out(e, r, drops);
  free(bits);
  free(radius);
  free(drops);
  return status;
}

sd_status rain_release(engine *e, sd_messages *messages) {
  const sd_model *m = e->model;
  sd_energy before = energy_of(e);
  sd_status status = SD_OK;
  engine_pose_walls(e);
  for (size_t k = 0; k < m->n_rains && status == SD_OK; k++)
    if (is_due(e, &m->rains[k])) status = release(e, &m->rains[k], messages);
  if (status != SD_OK) return status;
  bodies_fill_constants(e);
  for (size_t k = 0; k < m->n_rains; k++)
    if (is_due(e, &m->rains[k])) accelerate(e, &m->rains[k]);
  status = engine_renew(e, messages);
  if (status != SD_OK) return status;
  sd_energy after = energy_of(e);
  e->state->energy_start += energy_total(&after) - energy_total(&before);
  return SD_OK;
}
