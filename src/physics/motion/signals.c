/* signals.c: computes the signals of the motions of one system; see signals.h. */

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "physics/motion/signals.h"
#include "model/model.h"
#include "physics/system/kernels.h"

/* --- values by source ------------------------------------------------------------------------- */

typedef struct batch {
  const engine *e;
  const motion_kernels *k;
  const sd_motion *motion;
  motion_signal *signal;
  int64_t local;       /* number of steps from the start of the motion to the first value */
  double *u, *v, *low; /* memory that the values are written to; unused if they exist elsewhere */
} batch;

/* Computes a signal of constant velocity: u = c l for step l, with c = velocity * dt. The product
 * is exact as u + low, so a support that has turned by 1e4 rad is still placed to 1e-15. */
static void fill_steady(batch *b) {
  double c = b->motion->velocity * b->e->work.dt;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double l = (double)(b->local + k);
    b->u[k] = c * l;
    b->low[k] = fma(c, l, -b->u[k]);
    b->v[k] = b->motion->velocity;
  }
  b->signal->now.low = b->low;
}

static void fill_table(batch *b) {
  const sd_motion *m = b->motion;
  double from = m->table_time[0], to = m->table_time[m->n_table - 1], span = to - from;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double t = (double)(b->local + k) * b->e->work.dt;
    if (m->periodic) t = from + (t - from) - span * floor((t - from) / span);
    bool beyond = !m->periodic && (t < from || t > to);
    double at = t < from ? from : t > to ? to : t;
    b->u[k] = m->amplitude * spline_value(&b->signal->spline, at);
    b->v[k] = m->amplitude * (beyond ? 0.0 : spline_slope(&b->signal->spline, at));
  }
}

/* Computes a random signal from the states of its oscillator: these states themselves if there is a
 * random step in every time step, else cubics between them. */
static void fill_random(batch *b, const signals *all) {
  motion_signal *s = b->signal;
  const oscillators *g = &all->groups[s->group];
  const double *u = all->draws[s->group][0][s->lane], *v = all->draws[s->group][1][s->lane];
  int64_t m = b->motion->interval;
  assert(s->lane < g->count && g->interval == m && g->base[s->lane] >= 0);
  if (m == 1) {
    size_t row = (size_t)(b->local - g->base[s->lane]);
    assert(row + MOTION_BATCH <= OSCILLATOR_ROWS);
    s->now = (signal_values){u + row, v + row, NULL};
    return;
  }
  double h = (double)m * b->e->work.dt;
  draw_series d = {u, v, h, 1.0 / h, 1.0 / (double)m, m, g->base[s->lane]};
  b->k->cubics(&d, b->local, MOTION_BATCH, b->u, b->v);
}

/* Multiplies the values by the fade-in factor, if the ramp has not ended yet. Values in memory of
 * the oscillators are copied to memory of the signal first. */
static void fade_in(batch *b) {
  signal_values *now = &b->signal->now;
  if ((double)b->local * b->e->work.dt >= b->motion->ramp) return;
  if (now->u != b->u) {
    memcpy(b->u, now->u, MOTION_BATCH * sizeof *b->u);
    memcpy(b->v, now->v, MOTION_BATCH * sizeof *b->v);
    now->u = b->u;
    now->v = b->v;
  }
  b->k->fade(b->e->work.dt, b->motion->ramp, b->local, MOTION_BATCH, b->u, b->v,
             now->low ? b->low : NULL);
}

/* Computes MOTION_BATCH steps of one signal, from `local` steps after its start on. all: may be
 * NULL unless the signal is random. */
static void fill(const engine *e, const signals *all, motion_signal *s, size_t motion,
                 int64_t local) {
  const sd_motion *m = &e->model->motions[motion];
  assert(local >= 0);
  batch b = {e,
             e->work.kernels->motion,
             m,
             s,
             local,
             .u = s->values[0] + WAVE_FINE,
             .v = s->values[1] + WAVE_FINE,
             .low = s->values[2] + WAVE_FINE};
  s->now = (signal_values){b.u, b.v, NULL};
  switch (motion_source(m)) {
    case SIGNAL_STEADY: fill_steady(&b); break;
    case SIGNAL_WAVE: b.k->wave(&s->wave, local, MOTION_BATCH, b.u, b.v); break;
    case SIGNAL_TABLE: fill_table(&b); break;
    case SIGNAL_RANDOM: fill_random(&b, all); break;
    case SIGNAL_FEEDBACK: assert(!"known ahead");
  }
  if (m->ramp > 0.0) fade_in(&b);
}

void signals_fill_table(const engine *e, motion_signal *s, size_t motion, int64_t local) {
  assert(motion_source(&e->model->motions[motion]) == SIGNAL_TABLE);
  fill(e, NULL, s, motion, local);
}

/* Advances the oscillators of all running random motions up to the random step after the last of
 * the steps computed ahead. */
static void draw_ahead(const engine *e, signals *all, int64_t first) {
  const motion_kernels *k = e->work.kernels->motion;
  int64_t firsts[OSCILLATORS];
  for (size_t l = 0; l < OSCILLATORS; l++) firsts[l] = first;
  for (size_t n = 0; n < all->n_groups; n++) {
    oscillators *g = &all->groups[n];
    size_t rows = oscillators_ahead(k, g, firsts, MOTION_BATCH, g->interval);
    assert(rows <= OSCILLATOR_ROWS);
    k->spread(g, rows, all->draws[n][0], all->draws[n][1]);
  }
}

void signals_fill(const engine *e, signals *all, int64_t first) {
  draw_ahead(e, all, first);
  for (size_t k = 0; k < e->model->n_motions; k++)
    if (e->state->motion_start[k] >= 0 && !motion_is_feedback(&e->model->motions[k]))
      fill(e, all, &all->item[k], k, first - e->state->motion_start[k]);
}

/* --- tables ----------------------------------------------------------------------------------- */

static sd_status table_new(motion_signal *s, const sd_motion *m, sd_messages *messages) {
  assert(m->n_table >= 3);
  if (spline_new(&s->spline, m->table_time, m->table_value, m->n_table, m->periodic)) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER, "motion \"%s\": no spline through its table",
                 m->name ? m->name : "?");
}

/* Sets the constants of a wave, among them sine and cosine of the phase advance in 0, 1, ... 7
 * steps and in 0, 8, ... 56 steps. */
static void wave_new(const engine *e, wave *w, const sd_motion *m) {
  const double per_turn = 0.5 / M_PI;
  double t[2 * WAVE_FINE];
  w->form = m->kind;
  w->rate = m->omega * e->model->dt * per_turn;
  /* rounded to 24 binary digits, so that products with step numbers are exact */
  w->rate_high = (double)(float)w->rate;
  w->rate_low = w->rate - w->rate_high;
  w->offset = m->phase * per_turn;
  motion_shape(m, w->shape);
  for (int k = 0; k < WAVE_FINE; k++) {
    t[k] = w->rate * k;
    t[WAVE_FINE + k] = w->rate * (WAVE_FINE * k);
  }
  e->work.kernels->motion->sine_cosine(t, 2 * WAVE_FINE, w->sine, w->cosine);
  w->from = -1;
}

/* Assigns random motion k to a free vector lane of a group of oscillators with the same interval
 * between random steps. */
static void join_group(const engine *e, signals *all, size_t k) {
  motion_signal *s = &all->item[k];
  const sd_motion *m = &e->model->motions[k];
  s->step = random_step_new(m->omega, m->damping, m->amplitude, (double)m->interval * e->model->dt);
  oscillators *last = all->groups + all->n_groups - 1;
  if (all->n_groups == 0 || last->count == OSCILLATORS || last->interval != m->interval) {
    last = &all->groups[all->n_groups++];
    last->interval = m->interval;
  }
  s->group = all->n_groups - 1;
  s->lane = last->count++;
  assert(s->lane < OSCILLATORS && last->interval >= 1);
  oscillators_set(last, s->lane, &s->step, e->model->seed, m->stream);
}

sd_status signals_new(const engine *e, signals *all, sd_messages *messages) {
  const sd_model *m = e->model;
  size_t n = 0;
  for (size_t k = 0; k < m->n_motions; k++) n += m->motions[k].kind == SD_MOTION_RANDOM;
  all->item = memory_new(m->n_motions, sizeof *all->item);
  all->groups = oscillators_new(n);
  all->draws = memory_new(n, sizeof *all->draws);
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *motion = &m->motions[k];
    switch (motion_source(motion)) {
      case SIGNAL_WAVE: wave_new(e, &all->item[k].wave, motion); break;
      case SIGNAL_RANDOM: join_group(e, all, k); break;
      case SIGNAL_TABLE:
        if (table_new(&all->item[k], motion, messages) != SD_OK) return SD_ERROR_USER;
        break;
      case SIGNAL_STEADY:
      case SIGNAL_FEEDBACK: break;
    }
  }
  return SD_OK;
}

void signals_free(const engine *e, signals *all) {
  for (size_t k = 0; all->item && k < e->model->n_motions; k++) spline_free(&all->item[k].spline);
  free(all->item);
  free(all->groups);
  free(all->draws);
}

/* --- the state -------------------------------------------------------------------------------- */

void signals_load(const engine *e, signals *all) {
  for (size_t k = 0; k < e->model->n_motions; k++) {
    const sd_motion *m = &e->model->motions[k];
    if (m->kind != SD_MOTION_RANDOM) continue;
    oscillators *g = &all->groups[all->item[k].group];
    if (e->state->motion_start[k] < 0)
      oscillators_rest(g, all->item[k].lane);
    else
      oscillators_load(g, all->item[k].lane, e->state, k, m->interval);
  }
}

void signals_store(const engine *e, const signals *all) {
  for (size_t k = 0; k < e->model->n_motions; k++) {
    const sd_motion *m = &e->model->motions[k];
    if (m->kind != SD_MOTION_RANDOM || e->state->motion_start[k] < 0) continue;
    oscillators_store(&all->groups[all->item[k].group], all->item[k].lane, e->state, k,
                      m->interval);
  }
}

void signals_start_random(const engine *e, const signals *all, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  const random_step *r = &all->item[k].step;
  sd_state *s = e->state;
  double a, b;
  e->work.kernels->motion->normals(e->model->seed, m->stream, RANDOM_START, s->step, 1, &a, &b);
  double u = m->amplitude * a, v = m->omega * m->amplitude * b;
  s->motion_u0[k] = u;
  s->motion_v0[k] = v;
  e->work.kernels->motion->normals(e->model->seed, m->stream, RANDOM_STEP, 2 * s->step + 1, 1, &a,
                                   &b);
  /* The order of these sums is that in kernel_random.c, so both give the same bits. */
  s->motion_u1[k] = r->propagator[0][0] * u + (r->propagator[0][1] * v + r->cholesky[0] * a);
  s->motion_v1[k] = r->propagator[1][1] * v +
                    (r->propagator[1][0] * u + (r->cholesky[1] * a + r->cholesky[2] * b));
}
