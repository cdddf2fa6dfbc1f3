/* lanes_motion.c: see lanes_motion.h. */
#include "physics/small/lanes_motion.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "physics/small/lanes_signal.h"
#include "physics/motion/motion.h"
#include "physics/motion/oscillators.h"

enum { BATCH = MOTION_BATCH };
_Static_assert(SCENE_STEPS == BATCH + 1, "a scene holds a batch and the step before");

struct lanes_motion {
  size_t width, n, first_slot, n_slots; /* prescribed bodies */
  engine **systems;                     /* [width] */
  const kernels *kernels;
  double *scene;         /* [n_slots][POSES][SCENE_STEPS][width] */
  lanes_signal *signals; /* [n_motions] */
  oscillators *draws;    /* [n_motions] */
  double *room;          /* [n_motions][3][BATCH][width] */
  size_t n_places, capacity;
  lanes_place *places;
  const lanes_signal **terms;
  lanes_place **movers; /* of each signal: as many as its motion has bodies */
  int64_t first;        /* step of system 0 before the batch */
  bool filled;
  int64_t known; /* last row in range */
};

static double *vectors(size_t n, size_t width) {
  size_t bytes = (n * width * sizeof(double) + 127) / 64 * 64;
  double *p = aligned_alloc(64, bytes);
  if (p) memset(p, 0, bytes);
  return p;
}

static void set_wave(lanes_signal *s, size_t l, const wave *w) {
  s->rate[l] = w->rate;
  s->rate_high[l] = w->rate_high;
  s->rate_low[l] = w->rate_low;
  s->offset[l] = w->offset;
  s->scale_u[l] = w->scale_u;
  s->scale_v[l] = w->scale_v;
  for (size_t k = 0; k < 2 * WAVE_FINE; k++) {
    s->sine[k][l] = w->sine[k];
    s->cosine[k][l] = w->cosine[k];
  }
}

/* Constants of a motion, from those that the systems keep. */
static void set_signal(lanes_motion *m, size_t k) {
  lanes_signal *s = &m->signals[k];
  s->kind = m->systems[0]->model->motions[k].kind;
  s->motion = k;
  s->anchor = -1;
  s->draws = &m->draws[k];
  s->draws->count = m->width;
  s->interval = m->systems[0]->model->motions[k].interval;
  s->per_interval = 1.0 / (double)s->interval;
  for (size_t part = 0; part < 3; part++) s->room[part] = m->room + (3 * k + part) * BATCH * m->width;
  for (size_t l = 0; l < m->width; l++) {
    const engine *e = m->systems[l];
    const sd_motion *motion = &e->model->motions[k];
    const signal *from = &motion_signals(e)->item[k];
    assert(motion->kind == s->kind && motion->interval == s->interval);
    set_wave(s, l, &from->wave);
    s->dt[l] = e->work.dt;
    s->ramp[l] = motion->ramp;
    s->ramped = s->ramped || motion->ramp > 0.0;
    s->h[l] = (double)motion->interval * e->work.dt;
    s->per_h[l] = 1.0 / s->h[l];
    s->velocity[l] = motion->velocity;
    s->per_step[l] = motion->velocity * e->work.dt;
    if (s->kind == SD_MOTION_RANDOM)
      oscillators_set(s->draws, l, &from->step, e->model->seed, motion->stream);
  }
}

sd_status lanes_motion_new(size_t width, size_t n, engine *const *systems, lanes_motion **out) {
  lanes_motion *m = calloc(1, sizeof *m);
  *out = m;
  if (!m) return SD_ERROR_IO;
  const sd_state *s = systems[0]->state;
  const sd_model *model = systems[0]->model;
  size_t n_motions = model->n_motions, terms = 0;
  m->width = width;
  m->n = n;
  m->kernels = systems[0]->work.kernels;
  m->first_slot = s->n_free;
  m->n_slots = s->n_bodies - s->n_free;
  for (size_t k = 0; k < n_motions; k++) terms += model->motions[k].n_bodies;
  m->capacity = terms < 3 * m->n_slots ? terms : 3 * m->n_slots;
  m->systems = calloc(width, sizeof *m->systems);
  m->terms = calloc(terms + 1, sizeof *m->terms);
  m->movers = calloc(terms + 1, sizeof *m->movers);
  m->scene = vectors(m->n_slots * POSES * SCENE_STEPS, width);
  m->signals = (lanes_signal *)vectors(n_motions + 1, sizeof *m->signals / sizeof(double));
  m->places = (lanes_place *)vectors(m->capacity + 1, sizeof *m->places / sizeof(double));
  m->draws = oscillators_new(n_motions + 1);
  m->room = vectors(3 * BATCH * n_motions, width);
  if (!m->systems || !m->terms || !m->movers || !m->scene || !m->signals || !m->places || !m->draws ||
      !m->room) {
    lanes_motion_free(m);
    *out = NULL;
    return SD_ERROR_IO;
  }
  for (size_t l = 0; l < width; l++) m->systems[l] = systems[l < n ? l : 0];
  lanes_place **movers = m->movers;
  for (size_t k = 0; k < n_motions; movers += model->motions[k++].n_bodies) {
    set_signal(m, k);
    m->signals[k].places = movers;
  }
  return SD_OK;
}

void lanes_motion_free(lanes_motion *m) {
  if (!m) return;
  free(m->systems);
  free(m->terms);
  free(m->movers);
  free(m->scene);
  free(m->signals);
  free(m->places);
  free(m->draws);
  free(m->room);
  free(m);
}

/* --- load and store ---------------------------------------------------------------------------------- */

static double *stretch_of(const lanes_motion *m, uint32_t slot, int which) {
  return m->scene + ((slot - m->first_slot) * POSES + (size_t)which) * SCENE_STEPS * m->width;
}

/* Everything at rest where the states say. */
static void load_still(lanes_motion *m) {
  for (uint32_t i = 0; i < m->n_slots; i++)
    for (size_t l = 0; l < m->width; l++) {
      const sd_state *s = m->systems[l]->state;
      uint32_t slot = (uint32_t)m->first_slot + i;
      double now[POSES] = {s->x[slot], s->y[slot], s->theta[slot], s->vx[slot], s->vy[slot], s->omega[slot]};
      for (int c = 0; c < POSES; c++)
        for (size_t k = 0; k < SCENE_STEPS; k++) stretch_of(m, slot, c)[k * m->width + l] = now[c];
    }
}

static void load_signals(lanes_motion *m) {
  for (size_t k = 0; k < m->systems[0]->model->n_motions; k++) {
    lanes_signal *s = &m->signals[k];
    s->runs = m->systems[0]->state->motion_start[k] >= 0;
    s->n_places = 0;
    s->elsewhere = false;
    for (size_t l = 0; s->runs && s->kind == SD_MOTION_RANDOM && l < m->width; l++)
      oscillators_load(s->draws, l, m->systems[l]->state, k, s->interval);
  }
}

static void add_place(lanes_signal *s, lanes_place *p) { s->places[s->n_places++] = p; }

/* Place k: that of motion.c, whose terms say which signals. */
static void load_place(lanes_motion *m, size_t k, const placed *from, const lanes_signal **terms) {
  lanes_place *p = &m->places[k];
  size_t w = m->width;
  p->slot = from->slot;
  p->coordinate = from->coordinate;
  p->signals = terms;
  p->n_signals = from->count;
  p->stride = w;
  p->value = stretch_of(m, p->slot, p->coordinate) + w;
  p->velocity = stretch_of(m, p->slot, POSE_VX + p->coordinate) + w;
  for (size_t t = 0; t < from->count; t++) terms[t] = &m->signals[motion_term(m->systems[0], from, t)];
  p->turned = false;
  for (size_t l = 0; l < w; l++) {
    motion_offset(m->systems[l], p->slot, p->coordinate, &p->off[l], &p->base[l]);
    p->turned = p->turned || p->off[l] != 0.0;
  }
  if (p->n_signals == 1 && !p->turned)
    add_place(&m->signals[terms[0]->motion], p);
  else
    for (size_t t = 0; t < from->count; t++) m->signals[terms[t]->motion].elsewhere = true;
}

void lanes_motion_load(lanes_motion *m) {
  for (size_t l = 0; l < m->n; l++) motion_reload(m->systems[l]);
  load_still(m);
  load_signals(m);
  const placed *from = motion_places(m->systems[0], &m->n_places);
  assert(m->n_places <= m->capacity);
  const lanes_signal **terms = m->terms;
  for (size_t k = 0; k < m->n_places; terms += from[k++].count) load_place(m, k, &from[k], terms);
  m->first = m->systems[0]->state->step;
  m->filled = false;
}

void lanes_motion_store(lanes_motion *m) {
  for (size_t k = 0; m->filled && k < m->systems[0]->model->n_motions; k++) {
    const lanes_signal *s = &m->signals[k];
    for (size_t l = 0; s->runs && s->kind == SD_MOTION_RANDOM && l < m->n; l++)
      oscillators_store(s->draws, l, m->systems[l]->state, k, s->interval);
  }
  for (size_t l = 0; l < m->n; l++) motion_reload(m->systems[l]);
}

/* --- the batch --------------------------------------------------------------------------------------- */

/* Tables are looked up system by system. */
static void fill_table(lanes_motion *m, lanes_signal *s, int64_t local) {
  s->u = s->room[0];
  s->v = s->room[1];
  s->stride = m->width;
  s->placed = false;
  for (size_t l = 0; l < m->width; l++) {
    signal *from = &motion_signals(m->systems[l])->item[s->motion];
    signals_fill_one(m->systems[l], from, s->motion, local);
    for (size_t k = 0; k < BATCH; k++) {
      s->room[0][k * m->width + l] = from->now.u[k];
      s->room[1][k * m->width + l] = from->now.v[k];
    }
  }
}

/* The last row before some lane's angle leaves its range. */
static int64_t last_in_range(const lanes_motion *m, const lanes_place *p) {
  if (p->coordinate != SD_THETA || !m->kernels->lanes_beyond(p, BATCH, 4.0)) return BATCH;
  int64_t last = BATCH;
  for (size_t l = 0; l < m->width; l++)
    for (int64_t k = 0; k < last; k++)
      if (!motion_in_range(m->systems[l], SD_THETA, p->value[(size_t)k * p->stride + l])) last = k;
  return last;
}

static void fill(lanes_motion *m) {
  int64_t first[OSCILLATORS] = {0};
  const sd_state *s = m->systems[0]->state;
  for (size_t l = 0; l < m->width; l++) first[l] = m->systems[l]->state->step + 1;
  for (size_t k = 0; k < m->systems[0]->model->n_motions; k++) {
    lanes_signal *one = &m->signals[k];
    if (!one->runs) continue;
    if (one->kind == SD_MOTION_RANDOM) oscillators_ahead(m->kernels, one->draws, first, BATCH, one->interval);
    if (one->kind == SD_MOTION_TABLE)
      fill_table(m, one, first[0] - s->motion_start[k]);
    else
      m->kernels->lanes_signal(one, first[0] - s->motion_start[k], BATCH);
  }
  m->known = BATCH;
  for (size_t k = 0; k < m->n_places; k++) {
    const lanes_place *p = &m->places[k];
    if (p->n_signals > 1 || p->turned || !p->signals[0]->placed) m->kernels->lanes_place(p, BATCH);
    int64_t last = last_in_range(m, p);
    if (last < m->known) m->known = last;
  }
  m->filled = true;
}

/* Step k of the scene becomes the one before the batch. */
static void turn_over(lanes_motion *m, int64_t k) {
  size_t w = m->width;
  for (size_t p = 0; k > 0 && p < m->n_places; p++) {
    double *value = m->places[p].value - w, *velocity = m->places[p].velocity - w;
    memcpy(value, value + (size_t)k * w, w * sizeof(double));
    memcpy(velocity, velocity + (size_t)k * w, w * sizeof(double));
  }
  m->first += k;
}

int64_t lanes_motion_ahead(lanes_motion *m) {
  int64_t k = m->systems[0]->state->step + 1 - m->first;
  if (!m->filled || k > BATCH) {
    turn_over(m, k - 1);
    k = 1;
    fill(m);
  }
  return m->known - k + 1;
}

int64_t lanes_motion_first(const lanes_motion *m) { return m->first; }

const double *lanes_motion_scene(const lanes_motion *m) { return m->scene; }
