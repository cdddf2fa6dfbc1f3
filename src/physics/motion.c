/* motion.c: signals, their batches, and placing of prescribed bodies; see motion.h. */
#include "physics/motion.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_spline.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "physics/engine.h"
#include "physics/feedback.h"
#include "physics/kernels.h"
#include "physics/neighbours.h"
#include "physics/random.h"

/* One signal: MOTION_BATCH values of u, du/dt, and what u lost to rounding, one behind the other. */
typedef struct signal {
  double u[MOTION_BATCH], v[MOTION_BATCH], low[MOTION_BATCH];
  /* random: oscillator at draws base, base + 1, ... (draw k falls on step start + k * interval), in a group */
  double *draw_u, *draw_v;
  int64_t base;
  gsl_spline *spline;
  gsl_interp_accel *accel;
} signal;

struct motions {
  signal *signals; /* [n_motions] */
  size_t n_groups;
  oscillators *groups; /* random motions, eight by eight */
  random_step *random; /* [n_motions] */
  int64_t first;       /* step of the batch's first value */
  size_t n_placed;
  placed *places;
  const double **terms; /* signals: u, v, low */
  feedbacks feedbacks;
  bool moves_walls;
  bool quiet; /* nothing in this batch can make the lists stale or leave its range */
};

/* --- kinds ------------------------------------------------------------------------------------------- */

typedef struct batch {
  const engine *e;
  const sd_motion *motion;
  signal *signal;
  int64_t local; /* steps since the motion was switched on, of the batch's first value */
} batch;

/* p = c l exactly as p + low: a support that turned 1e4 rad is still placed to 1e-15 (physics.md 2, trap 4). */
static void fill_velocity(batch *b) {
  double c = b->motion->velocity * b->e->work.dt;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double l = (double)(b->local + k);
    b->signal->u[k] = c * l;
    b->signal->low[k] = fma(c, l, -b->signal->u[k]);
    b->signal->v[k] = b->motion->velocity;
  }
}

/* Phase of the motion in turns. */
static void fill_turns(const batch *b, double *turns) {
  const double per_turn = 0.5 / M_PI;
  double rate = b->motion->omega * b->e->work.dt * per_turn, offset = b->motion->phase * per_turn;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double t = rate * (double)(b->local + k);
    turns[k] = (t - floor(t)) + offset;
  }
}

static void fill_harmonic(batch *b) {
  double turns[MOTION_BATCH], s[MOTION_BATCH], c[MOTION_BATCH];
  fill_turns(b, turns);
  b->e->work.kernels->sine_cosine(turns, MOTION_BATCH, s, c);
  double speed = b->motion->amplitude * b->motion->omega;
  for (int k = 0; k < MOTION_BATCH; k++) {
    b->signal->u[k] = b->motion->amplitude * s[k];
    b->signal->v[k] = speed * c[k];
  }
}

/* eq. 21 and its derivative (22), with t counted in half periods: z in [-1, 1]. */
static void fill_parabolic(batch *b) {
  double turns[MOTION_BATCH], speed = b->motion->omega / M_PI;
  fill_turns(b, turns);
  for (int k = 0; k < MOTION_BATCH; k++) {
    double z = 2.0 * (turns[k] - nearbyint(turns[k])), bend = z < 0.0 ? 1.0 : -1.0;
    b->signal->u[k] = 4.0 * b->motion->amplitude * (bend * z * z + z);
    b->signal->v[k] = 4.0 * b->motion->amplitude * speed * (2.0 * bend * z + 1.0);
  }
}

/* A value per step from the draws. Between draws: the cubic that matches displacement and velocity at both
 * ends, with its own derivative as velocity. */
static void fill_random(batch *b) {
  signal *s = b->signal;
  int64_t m = b->motion->interval;
  if (m == 1) {
    memcpy(s->u, s->draw_u + (b->local - s->base), sizeof s->u);
    memcpy(s->v, s->draw_v + (b->local - s->base), sizeof s->v);
    return;
  }
  double h = (double)m * b->e->work.dt;
  for (int k = 0; k < MOTION_BATCH; k++) {
    int64_t at = (b->local + k) / m - s->base, rest = (b->local + k) % m;
    double u0 = s->draw_u[at], v0 = s->draw_v[at];
    s->u[k] = u0;
    s->v[k] = v0;
    if (rest == 0) continue;
    double z = (double)rest / (double)m, u1 = s->draw_u[at + 1], v1 = s->draw_v[at + 1];
    double rise = u1 - u0, a = h * v0 - rise, c = rise - h * v1, w = 1.0 - z;
    s->u[k] = w * u0 + z * u1 + z * w * (a * w + c * z);
    s->v[k] = (rise + (1.0 - 2.0 * z) * (a * w + c * z) + z * w * (c - a)) / h;
  }
}

static void fill_table(batch *b) {
  const sd_motion *m = b->motion;
  double from = m->table_time[0], to = m->table_time[m->n_table - 1], span = to - from;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double t = (double)(b->local + k) * b->e->work.dt;
    if (m->periodic) t = from + (t - from) - span * floor((t - from) / span);
    bool beyond = !m->periodic && (t < from || t > to);
    double at = t < from ? from : t > to ? to : t, u = 0.0, v = 0.0;
    gsl_spline_eval_e(b->signal->spline, at, b->signal->accel, &u);
    if (!beyond) gsl_spline_eval_deriv_e(b->signal->spline, at, b->signal->accel, &v);
    b->signal->u[k] = m->amplitude * u;
    b->signal->v[k] = m->amplitude * v;
  }
}

typedef struct motion_kind {
  const char *name;
  void (*fill)(batch *b);
} motion_kind;

static const motion_kind motion_kinds[SD_MOTION_KINDS] = {
    [SD_MOTION_VELOCITY] = {"velocity", fill_velocity},
    [SD_MOTION_HARMONIC] = {"harmonic", fill_harmonic},
    [SD_MOTION_PARABOLIC] = {"parabolic", fill_parabolic},
    [SD_MOTION_RANDOM] = {"random", fill_random},
    [SD_MOTION_TABLE] = {"table", fill_table},
    [SD_MOTION_LOAD] = {"load", NULL}, /* feedback.h */
    [SD_MOTION_SERVO] = {"servo", NULL},
};

/* Fades in: u r(t), r = 6 s^5 - 15 s^4 + 10 s^3, s = t/ramp; the velocity follows. */
static void fade_in(batch *b) {
  double ramp = b->motion->ramp;
  for (int k = 0; k < MOTION_BATCH; k++) {
    double s = (double)(b->local + k) * b->e->work.dt / ramp;
    if (s >= 1.0) break;
    double r = s * s * s * (s * (6.0 * s - 15.0) + 10.0), dr = 30.0 * s * s * (s - 1.0) * (s - 1.0) / ramp;
    b->signal->v[k] = b->signal->v[k] * r + b->signal->u[k] * dr;
    b->signal->u[k] *= r;
    b->signal->low[k] *= r;
  }
}

bool motion_in_range(const engine *e, int coordinate, double at) {
  if (coordinate == SD_THETA) return at >= -4.0 && at <= 4.0;
  return at >= e->work.lower[coordinate] && at < e->work.upper[coordinate];
}

/* Sums a coordinate's signals. */
static void fill_place(engine *e, placed *p) {
  const motions *q = e->work.motions;
  const sd_state *s = e->state;
  uint32_t i = p->slot;
  double off = p->coordinate == SD_X   ? s->image_x[i] * e->work.length[0]
               : p->coordinate == SD_Y ? s->image_y[i] * e->work.length[1]
                                       : s->turn[i];
  const double *base = p->coordinate == SD_X ? s->base_x : p->coordinate == SD_Y ? s->base_y : s->base_theta;
  place_batch b = {q->terms + p->first, p->count, off, base[i], p->value, p->velocity, 0.0, 0.0};
  e->work.kernels->place(&b, MOTION_BATCH);
  p->low = b.low;
  p->high = b.high;
}

/* Far from every limit even if the lists are rebuilt on the way: half the limit per coordinate, halved
 * again for walls, which also swing. */
static bool place_is_quiet(const engine *e, const placed *p) {
  const work *w = &e->work;
  const sd_state *s = e->state;
  bool wall = p->slot >= s->n_disks;
  double from = p->coordinate == SD_X   ? w->x0[p->slot]
                : p->coordinate == SD_Y ? w->y0[p->slot]
                                        : w->theta0[p->slot] - s->turn[p->slot];
  double arm = p->coordinate != SD_THETA ? 1.0 : wall ? w->reach[p->slot - s->n_disks] : 0.0;
  double most = (wall ? 0.04 : 0.12) * w->moved_limit2;
  double down = (p->low - from) * arm, up = (p->high - from) * arm;
  return down * down <= most && up * up <= most && motion_in_range(e, p->coordinate, p->low) &&
         motion_in_range(e, p->coordinate, p->high);
}

/* New draws of every running random motion, up to the one after the batch's last step. */
static void draw_ahead(engine *e, int64_t first) {
  motions *q = e->work.motions;
  for (size_t n = 0; n < q->n_groups; n++) {
    oscillators *g = &q->groups[n];
    size_t most = 0;
    for (size_t l = 0; l < g->count; l++) {
      size_t k = g->motion[l];
      const sd_motion *motion = &e->model->motions[k];
      signal *s = &q->signals[k];
      int64_t start = e->state->motion_start[k], m = motion->interval;
      if (start < 0) continue;
      /* keep the two draws around the step before the batch */
      int64_t low = (first - start - 1) / m, high = (first - start + MOTION_BATCH - 1) / m + 1;
      if (low < s->base) low = s->base; /* the batch begins with the last step that was taken */
      for (int64_t two = 0; two < 2; two++) {
        s->draw_u[two] = s->draw_u[two + low - s->base];
        s->draw_v[two] = s->draw_v[two + low - s->base];
      }
      s->base = low;
      size_t needed = (size_t)(high - low - 1);
      if (needed > most) most = needed;
      e->work.kernels->normals(e->model->seed, motion->stream, RANDOM_STEP, start + low + 2, needed,
                               g->normal1[l], g->normal2[l]);
    }
    e->work.kernels->oscillate(g, most);
  }
}

static void fill(engine *e, int64_t first) {
  motions *q = e->work.motions;
  draw_ahead(e, first);
  q->first = first;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    if (e->state->motion_start[k] < 0 || feedback_drives(&e->model->motions[k])) continue;
    batch b = {e, &e->model->motions[k], &q->signals[k], first - e->state->motion_start[k]};
    motion_kinds[b.motion->kind].fill(&b);
    if (b.motion->ramp > 0.0) fade_in(&b);
  }
  q->quiet = q->feedbacks.count == 0;
  for (size_t k = 0; k < q->n_placed; k++) {
    fill_place(e, &q->places[k]);
    q->quiet = q->quiet && place_is_quiet(e, &q->places[k]);
  }
}

/* --- tables ------------------------------------------------------------------------------------------ */

static sd_status spline_new(signal *s, const sd_motion *m, sd_messages *messages) {
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  const gsl_interp_type *type = m->periodic ? gsl_interp_cspline_periodic : gsl_interp_cspline;
  s->spline = gsl_spline_alloc(type, m->n_table);
  s->accel = gsl_interp_accel_alloc();
  int bad = !s->spline || !s->accel || gsl_spline_init(s->spline, m->table_time, m->table_value, m->n_table);
  gsl_set_error_handler(handler);
  if (!bad) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER, "motion \"%s\": no spline through its table",
                 m->name ? m->name : "?");
}

static sd_status join_group(engine *e, size_t k) {
  motions *q = e->work.motions;
  const sd_motion *m = &e->model->motions[k];
  if (q->n_groups == 0 || q->groups[q->n_groups - 1].count == OSCILLATORS) q->n_groups++;
  oscillators *g = &q->groups[q->n_groups - 1];
  size_t l = g->count++;
  random_step r = random_step_new(m->omega, m->damping, m->amplitude, (double)m->interval * e->model->dt);
  if (isnan(r.cholesky[0])) return SD_ERROR_IO;
  q->random[k] = r;
  g->motion[l] = k;
  g->uu[l] = r.propagator[0][0];
  g->uv[l] = r.propagator[0][1];
  g->vu[l] = r.propagator[1][0];
  g->vv[l] = r.propagator[1][1];
  g->noise_u[l] = r.cholesky[0];
  g->noise_vu[l] = r.cholesky[1];
  g->noise_vv[l] = r.cholesky[2];
  q->signals[k].draw_u = g->u[l];
  q->signals[k].draw_v = g->v[l];
  return SD_OK;
}

sd_status motion_new(engine *e, sd_messages *messages) {
  const sd_model *m = e->model;
  motions *q = calloc(1, sizeof *q);
  e->work.motions = q;
  size_t terms = 0;
  for (size_t k = 0; k < m->n_motions; k++) terms += m->motions[k].n_bodies;
  if (q) {
    q->signals = calloc(m->n_motions + 1, sizeof *q->signals);
    q->places =
        calloc(3 * sd_model_bodies(m) < terms ? 3 * sd_model_bodies(m) + 1 : terms + 1, sizeof *q->places);
    q->terms = calloc(terms + 1, sizeof *q->terms);
    q->groups = calloc(m->n_motions / OSCILLATORS + 1, sizeof *q->groups);
    q->random = calloc(m->n_motions + 1, sizeof *q->random);
  }
  if (!q || !q->signals || !q->places || !q->terms || !q->groups || !q->random ||
      feedback_new(e, &q->feedbacks) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the motions");
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *motion = &m->motions[k];
    signal *s = &q->signals[k];
    if (motion->kind == SD_MOTION_RANDOM && join_group(e, k) != SD_OK)
      return sd_fail(messages, SD_ERROR_IO, "out of memory for the motions");
    if (motion->kind == SD_MOTION_TABLE && spline_new(s, motion, messages) != SD_OK) return SD_ERROR_USER;
  }
  return SD_OK;
}

void motion_free(engine *e) {
  motions *q = e->work.motions;
  if (!q) return;
  for (size_t k = 0; q->signals && k < e->model->n_motions; k++) {
    gsl_spline_free(q->signals[k].spline);
    gsl_interp_accel_free(q->signals[k].accel);
  }
  free(q->signals);
  free(q->places);
  free(q->terms);
  free(q->groups);
  free(q->random);
  feedback_free(&q->feedbacks);
  free(q);
  e->work.motions = NULL;
}

static void place_new(engine *e, placed *p, size_t c, size_t first, size_t count) {
  sd_state *s = e->state;
  double *at[] = {s->x, s->y, s->theta}, *speed[] = {s->vx, s->vy, s->omega};
  double *force[] = {s->force_x, s->force_y, s->torque};
  size_t slot = c / 3, k = c % 3;
  p->slot = (uint32_t)slot;
  p->coordinate = (int)k;
  p->first = first;
  p->count = count;
  p->at = at[k] + slot;
  p->last = *p->at;
  p->speed = speed[k] + slot;
  p->force = force[k] + slot;
}

/* Coordinates with a running motion, by slot and coordinate; terms in the deck's order. */
static sd_status list_places(engine *e) {
  const sd_model *m = e->model;
  motions *q = e->work.motions;
  size_t n = 3 * e->state->n_bodies, terms = 0;
  size_t *count = calloc(n + 1, sizeof *count), *at = calloc(n + 1, sizeof *at);
  q->n_placed = 0;
  q->moves_walls = false;
  for (int pass = 0; count && at && pass < 2; pass++) {
    for (size_t k = 0; k < m->n_motions; k++) {
      if (e->state->motion_start[k] < 0) continue;
      for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
        uint32_t slot = e->work.slot[m->motions[k].bodies[b]];
        size_t c = 3 * (size_t)slot + (size_t)m->motions[k].coordinate;
        if (slot >= e->state->n_disks) q->moves_walls = true;
        if (feedback_drives(&m->motions[k])) continue;
        if (pass == 0)
          count[c]++;
        else
          q->terms[at[c]++] = q->signals[k].u;
      }
    }
    for (size_t c = 0; pass == 0 && c < n; c++) {
      if (!count[c]) continue;
      place_new(e, &q->places[q->n_placed++], c, terms, count[c]);
      at[c] = terms;
      terms += count[c];
    }
  }
  feedback_list(e, &q->feedbacks);
  bool failed = !count || !at;
  free(count);
  free(at);
  return failed ? SD_ERROR_IO : SD_OK;
}

static double *base_of(sd_state *s, int coordinate) {
  return coordinate == SD_X ? s->base_x : coordinate == SD_Y ? s->base_y : s->base_theta;
}

/* How many running motions add to each coordinate of each body (by 3 slot + coordinate): counts motion k in
 * (by = 1) or out (by = -1). */
static void count_mover(const engine *e, int32_t *movers, size_t k, int by) {
  const sd_motion *m = &e->model->motions[k];
  for (size_t b = 0; b < m->n_bodies; b++)
    movers[3 * (size_t)e->work.slot[m->bodies[b]] + (size_t)m->coordinate] += by;
}

/* Stands still where the base and the images say. */
static void rest(engine *e, uint32_t slot, int coordinate) {
  sd_state *s = e->state;
  if (coordinate == SD_THETA) {
    s->theta[slot] = s->base_theta[slot] - s->turn[slot];
    s->omega[slot] = 0.0;
  } else if (coordinate == SD_X) {
    s->x[slot] = s->base_x[slot] - s->image_x[slot] * e->work.length[0];
    s->vx[slot] = 0.0;
  } else {
    s->y[slot] = s->base_y[slot] - s->image_y[slot] * e->work.length[1];
    s->vy[slot] = 0.0;
  }
}

/* A random signal begins in its stationary law; its first step is drawn too. */
static void start_random(engine *e, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  const random_step *r = &e->work.motions->random[k];
  sd_state *s = e->state;
  double a[16], b[16];
  e->work.kernels->normals(e->model->seed, m->stream, RANDOM_START, s->step, 1, a, b);
  double u = m->amplitude * a[0], v = m->omega * m->amplitude * b[0];
  s->motion_u0[k] = u;
  s->motion_v0[k] = v;
  e->work.kernels->normals(e->model->seed, m->stream, RANDOM_STEP, s->step + 1, 1, a, b);
  /* as the kernel sums it */
  s->motion_u1[k] = r->propagator[0][0] * u + (r->propagator[0][1] * v + r->cholesky[0] * a[0]);
  s->motion_v1[k] =
      r->propagator[1][1] * v + (r->propagator[1][0] * u + (r->cholesky[1] * a[0] + r->cholesky[2] * b[0]));
}

/* The last value stays in the base; a motion that never took a step displaced nothing. What no other motion
 * moves comes to rest. */
static void switch_off(engine *e, int32_t *movers, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  const motions *q = e->work.motions;
  sd_state *s = e->state;
  double *base = base_of(s, m->coordinate);
  if (feedback_drives(m))
    feedback_end(e, k);
  else if (s->step > s->motion_start[k])
    for (size_t b = 0; b < m->n_bodies; b++)
      base[e->work.slot[m->bodies[b]]] += q->signals[k].u[s->step - q->first];
  s->motion_start[k] = -1;
  count_mover(e, movers, k, -1);
  for (size_t b = 0; b < m->n_bodies; b++) {
    uint32_t slot = e->work.slot[m->bodies[b]];
    if (movers[3 * (size_t)slot + (size_t)m->coordinate] == 0) rest(e, slot, m->coordinate);
  }
}

static void switch_on(engine *e, int32_t *movers, size_t k) {
  e->state->motion_start[k] = e->state->step;
  count_mover(e, movers, k, 1);
  if (e->model->motions[k].kind == SD_MOTION_RANDOM) start_random(e, k);
  if (feedback_drives(&e->model->motions[k])) feedback_begin(e, k);
}

sd_status motion_begin_phase(engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  motion_store(e);
  const bool *active = m->phases[s->phase].active;
  int32_t *movers = calloc(3 * s->n_bodies, sizeof *movers);
  if (!movers) return SD_ERROR_IO;
  for (size_t k = 0; k < m->n_motions; k++)
    if (s->motion_start[k] >= 0) count_mover(e, movers, k, 1);
  if (e->work.motions->first < 0) fill(e, s->step); /* the last values are not known */
  for (size_t k = 0; k < m->n_motions; k++) {
    bool on = s->motion_start[k] >= 0;
    if (on && !active[k]) switch_off(e, movers, k);
    if (!on && active[k]) switch_on(e, movers, k);
  }
  free(movers);
  return motion_resume(e);
}

void motion_reload(engine *e) {
  motions *q = e->work.motions;
  const sd_state *s = e->state;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    if (s->motion_start[k] < 0 || e->model->motions[k].kind != SD_MOTION_RANDOM) continue;
    signal *g = &q->signals[k];
    g->base = (s->step - s->motion_start[k]) / e->model->motions[k].interval;
    g->draw_u[0] = s->motion_u0[k];
    g->draw_v[0] = s->motion_v0[k];
    g->draw_u[1] = s->motion_u1[k];
    g->draw_v[1] = s->motion_v1[k];
  }
  q->first = INT64_MIN / 2; /* nothing computed yet */
  for (size_t k = 0; k < q->n_placed; k++) q->places[k].last = *q->places[k].at;
}

sd_status motion_resume(engine *e) {
  motion_reload(e);
  return list_places(e);
}

void motion_store(engine *e) {
  motions *q = e->work.motions;
  sd_state *s = e->state;
  if (!q || q->first < 0) return;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    if (s->motion_start[k] < 0 || e->model->motions[k].kind != SD_MOTION_RANDOM) continue;
    const signal *g = &q->signals[k];
    int64_t at = (s->step - s->motion_start[k]) / e->model->motions[k].interval - g->base;
    s->motion_u0[k] = g->draw_u[at];
    s->motion_v0[k] = g->draw_v[at];
    s->motion_u1[k] = g->draw_u[at + 1];
    s->motion_v1[k] = g->draw_v[at + 1];
  }
}

bool motion_moves_walls(const engine *e) { return e->work.motions->moves_walls; }

int64_t motion_index(const engine *e) { return e->state->step + 1 - e->work.motions->first; }

placed *motion_places(engine *e, size_t *n) {
  *n = e->work.motions->n_placed;
  return e->work.motions->places;
}

bool motion_ahead(engine *e) {
  int64_t k = motion_index(e);
  if (k < 0 || k >= MOTION_BATCH) fill(e, e->state->step + 1);
  return e->work.motions->quiet;
}

void motion_place(engine *e, thread_work *mine) {
  motions *q = e->work.motions;
  const sd_state *s = e->state;
  motion_ahead(e);
  int64_t k = motion_index(e);
  for (placed *p = q->places; p < q->places + q->n_placed; p++) {
    double after = p->value[k];
    p->moved = 0.0;
    if (p->slot < s->n_free && !engine_in_play(s, p->slot)) continue; /* it waits, or was taken out */
    p->moved = after - p->last;
    p->force_before = *p->force;
    *p->at = p->last = after;
    *p->speed = p->velocity[k];
  }
  if (q->quiet) return;
  feedback_place(e, &q->feedbacks, mine);
  for (const placed *p = q->places; p < q->places + q->n_placed; p++) {
    if (neighbours_moved(e, p->slot)) mine->stale = true;
    /* free disks with a prescribed coordinate are looked at by the corrector */
    if (p->slot >= s->n_free && !motion_in_range(e, p->coordinate, *p->at))
      event_add(&mine->returns, p->slot, 0.0);
  }
}

void motion_came_back(engine *e, uint32_t slot) {
  motions *q = e->work.motions;
  bool known = q->first >= 0 && e->state->step + 1 - q->first < MOTION_BATCH;
  for (size_t k = 0; k < q->n_placed; k++) {
    if (q->places[k].slot != slot) continue;
    q->places[k].last = *q->places[k].at;
    if (known) fill_place(e, &q->places[k]);
  }
}

void motion_work(engine *e) {
  motions *q = e->work.motions;
  double done = feedback_correct(e, &q->feedbacks);
  for (const placed *p = q->places; p < q->places + q->n_placed; p++)
    done += (p->force_before + *p->force) * p->moved;
  e->state->work_driven -= 0.5 * done;
}
