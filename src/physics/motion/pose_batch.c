/* pose_batch.c: prescribed poses of several systems side by side; see motion.h. */
#include "physics/motion/pose_batch.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/model.h"
#include "physics/motion/signals.h"
#include "physics/system/kernels.h"

enum { BATCH = MOTION_BATCH };

struct pose_batch {
  /* width: number of vector lanes; n: number of systems; first slot and number of slots of the
   * prescribed bodies */
  size_t width, n, first_slot, n_slots;
  engine **systems; /* [width] system of each lane */
  const motion_kernels *kernels;
  double *poses;         /* [n_slots][POSES][POSE_STEPS][width] poses of the prescribed bodies */
  lanes_signal *signals; /* [n_motions] signal of each motion */
  oscillators *draws;    /* [n_motions] oscillators of each random motion */
  double *rows;          /* [n_motions][3][BATCH][width] memory that lanes_signal.rows points to */
  size_t n_coordinates, capacity;
  lanes_pose *coordinates;
  const lanes_signal **terms;
  /* memory for lanes_signal.alone, one entry per motion and body of the motion */
  lanes_pose **alone;
  int64_t first; /* last step of system 0 before the steps computed ahead */
  bool filled;   /* true if the steps ahead have been computed */
  int64_t known; /* index of the last computed step at which all angles are in their range */
};

static double *vectors(size_t n, size_t width) { return memory_lines(n * width * sizeof(double)); }

static void set_wave(lanes_signal *s, size_t l, const wave *w) {
  s->rate[l] = w->rate;
  s->rate_high[l] = w->rate_high;
  s->rate_low[l] = w->rate_low;
  s->offset[l] = w->offset;
  for (size_t k = 0; k < WAVE_SHAPE; k++) s->shape[k][l] = w->shape[k];
  for (size_t k = 0; k < 2 * WAVE_FINE; k++) {
    s->sine[k][l] = w->sine[k];
    s->cosine[k][l] = w->cosine[k];
  }
}

/* Copies the constants of motion k from all systems to the vector lanes. */
static void set_signal(pose_batch *m, size_t k) {
  lanes_signal *s = &m->signals[k];
  s->form = m->systems[0]->model->motions[k].kind;
  s->source = motion_kinds[s->form].source;
  s->motion = k;
  s->anchor = -1;
  s->draws = &m->draws[k];
  s->draws->count = m->width;
  s->interval = m->systems[0]->model->motions[k].interval;
  s->per_interval = 1.0 / (double)s->interval;
  for (size_t part = 0; part < 3; part++)
    s->rows[part] = m->rows + (3 * k + part) * BATCH * m->width;
  for (size_t l = 0; l < m->width; l++) {
    const engine *e = m->systems[l];
    const sd_motion *motion = &e->model->motions[k];
    const motion_signal *from = &motion_signals(e)->item[k];
    assert(motion->kind == s->form && motion->interval == s->interval);
    set_wave(s, l, &from->wave);
    s->dt[l] = e->work.dt;
    s->ramp[l] = motion->ramp;
    s->ramped = s->ramped || motion->ramp > 0.0;
    s->h[l] = (double)motion->interval * e->work.dt;
    s->per_h[l] = 1.0 / s->h[l];
    s->velocity[l] = motion->velocity;
    s->per_step[l] = motion->velocity * e->work.dt;
    if (s->source == SIGNAL_RANDOM)
      oscillators_set(s->draws, l, &from->step, e->model->seed, motion->stream);
  }
}

pose_batch *pose_batch_new(size_t width, size_t n, engine *const *systems) {
  pose_batch *m = memory_new(1, sizeof *m);
  const sd_state *s = systems[0]->state;
  const sd_model *model = systems[0]->model;
  size_t n_motions = model->n_motions, terms = 0;
  m->width = width;
  m->n = n;
  m->kernels = systems[0]->work.kernels->motion;
  m->first_slot = s->n_free;
  m->n_slots = s->n_bodies - s->n_free;
  for (size_t k = 0; k < n_motions; k++) terms += model->motions[k].n_bodies;
  assert(n >= 1 && n <= width && width <= SIGNAL_LANES && width <= OSCILLATORS);
  m->capacity = terms < 3 * m->n_slots ? terms : 3 * m->n_slots;
  m->systems = memory_new(width, sizeof *m->systems);
  m->terms = memory_new(terms, sizeof *m->terms);
  m->alone = memory_new(terms, sizeof *m->alone);
  m->poses = vectors(m->n_slots * POSES * POSE_STEPS, width);
  m->signals = memory_lines(n_motions * sizeof *m->signals);
  m->coordinates = memory_lines(m->capacity * sizeof *m->coordinates);
  m->draws = oscillators_new(n_motions);
  m->rows = vectors(3 * BATCH * n_motions, width);
  for (size_t l = 0; l < width; l++) m->systems[l] = systems[l < n ? l : 0];
  lanes_pose **alone = m->alone;
  for (size_t k = 0; k < n_motions; alone += model->motions[k++].n_bodies) {
    set_signal(m, k);
    assert(alone <= m->alone + terms);
    m->signals[k].alone = alone;
  }
  return m;
}

void pose_batch_free(pose_batch *m) {
  if (!m) return;
  free(m->systems);
  free(m->terms);
  free(m->alone);
  free(m->poses);
  free(m->signals);
  free(m->coordinates);
  free(m->draws);
  free(m->rows);
  free(m);
}

/* --- load and store --------------------------------------------------------------------------- */

/* Returns the values of one component (`which`: POSE_X ...) of the pose of the body in a slot:
 * m->width numbers per step. */
static double *pose_row(const pose_batch *m, uint32_t slot, int which) {
  assert(slot >= m->first_slot && slot < m->first_slot + m->n_slots && which >= 0 && which < POSES);
  return m->poses + ((slot - m->first_slot) * POSES + (size_t)which) * POSE_STEPS * m->width;
}

/* Sets the poses of all steps to the present poses in the states; poses that running motions move
 * are overwritten later. */
static void load_still(pose_batch *m) {
  for (uint32_t i = 0; i < m->n_slots; i++)
    for (size_t l = 0; l < m->width; l++) {
      const sd_state *s = m->systems[l]->state;
      uint32_t slot = (uint32_t)m->first_slot + i;
      double now[POSES] = {s->x[slot],  s->y[slot],  s->theta[slot],
                           s->vx[slot], s->vy[slot], s->omega[slot]};
      for (int c = 0; c < POSES; c++)
        for (size_t k = 0; k < POSE_STEPS; k++) pose_row(m, slot, c)[k * m->width + l] = now[c];
    }
}

static void load_signals(pose_batch *m) {
  for (size_t k = 0; k < m->systems[0]->model->n_motions; k++) {
    lanes_signal *s = &m->signals[k];
    s->runs = m->systems[0]->state->motion_start[k] >= 0;
    s->n_alone = 0;
    s->shared = false;
    for (size_t l = 0; s->runs && s->source == SIGNAL_RANDOM && l < m->width; l++)
      oscillators_load(s->draws, l, m->systems[l]->state, k, s->interval);
  }
}

static void add_alone(lanes_signal *s, lanes_pose *p) { s->alone[s->n_alone++] = p; }

/* Sets prescribed coordinate k of all systems from that of system 0 (`from`). terms: memory for the
 * list of signals that are added to it. */
static void load_coordinate(pose_batch *m, size_t k, const prescribed *from,
                            const lanes_signal **terms) {
  lanes_pose *p = &m->coordinates[k];
  size_t w = m->width;
  p->slot = from->slot;
  p->coordinate = from->coordinate;
  p->signals = terms;
  p->n_signals = from->count;
  p->stride = w;
  p->value = pose_row(m, p->slot, p->coordinate) + w;
  p->velocity = pose_row(m, p->slot, POSE_VX + p->coordinate) + w;
  for (size_t t = 0; t < from->count; t++)
    terms[t] = &m->signals[motion_term(m->systems[0], from, t)];
  p->turned = false;
  for (size_t l = 0; l < w; l++) {
    motion_offset(m->systems[l], p->slot, p->coordinate, &p->off[l], &p->base[l]);
    p->turned = p->turned || p->off[l] != 0.0;
  }
  if (p->n_signals == 1 && !p->turned)
    add_alone(&m->signals[terms[0]->motion], p);
  else
    for (size_t t = 0; t < from->count; t++) m->signals[terms[t]->motion].shared = true;
}

void pose_batch_load(pose_batch *m) {
  for (size_t l = 0; l < m->n; l++) motion_reload(m->systems[l]);
  load_still(m);
  load_signals(m);
  const prescribed *from = motion_prescribed(m->systems[0], &m->n_coordinates);
  assert(m->n_coordinates <= m->capacity);
  const lanes_signal **terms = m->terms;
  for (size_t k = 0; k < m->n_coordinates; terms += from[k++].count)
    load_coordinate(m, k, &from[k], terms);
  m->first = m->systems[0]->state->step;
  m->filled = false;
}

void pose_batch_store(pose_batch *m) {
  for (size_t k = 0; m->filled && k < m->systems[0]->model->n_motions; k++) {
    const lanes_signal *s = &m->signals[k];
    for (size_t l = 0; s->runs && s->source == SIGNAL_RANDOM && l < m->n; l++)
      oscillators_store(s->draws, l, m->systems[l]->state, k, s->interval);
  }
  for (size_t l = 0; l < m->n; l++) motion_reload(m->systems[l]);
}

/* --- the batch -------------------------------------------------------------------------------- */

/* Computes a tabulated motion for BATCH steps ahead, one system after the other. */
static void fill_table(pose_batch *m, lanes_signal *s, int64_t local) {
  s->u = s->rows[0];
  s->v = s->rows[1];
  s->stride = m->width;
  s->posed = false;
  for (size_t l = 0; l < m->width; l++) {
    motion_signal *from = &motion_signals(m->systems[l])->item[s->motion];
    signals_fill_table(m->systems[l], from, s->motion, local);
    for (size_t k = 0; k < BATCH; k++) {
      s->rows[0][k * m->width + l] = from->now.u[k];
      s->rows[1][k * m->width + l] = from->now.v[k];
    }
  }
}

/* Returns the index of the last step before an angle (coordinate p) leaves its range in some
 * system; BATCH if all stay in range. */
static int64_t last_in_range(const pose_batch *m, const lanes_pose *p) {
  if (p->coordinate != SD_THETA || !m->kernels->lanes_beyond(p, BATCH, 4.0)) return BATCH;
  int64_t last = BATCH;
  for (size_t l = 0; l < m->width; l++)
    for (int64_t k = 0; k < last; k++)
      if (!motion_in_range(m->systems[l], SD_THETA, p->value[(size_t)k * p->stride + l])) last = k;
  return last;
}

/* Computes signals and poses of the next BATCH steps. */
static void fill(pose_batch *m) {
  int64_t first[OSCILLATORS] = {0};
  const sd_state *s = m->systems[0]->state;
  for (size_t l = 0; l < m->width; l++) first[l] = m->systems[l]->state->step + 1;
  for (size_t k = 0; k < m->systems[0]->model->n_motions; k++) {
    lanes_signal *one = &m->signals[k];
    if (!one->runs) continue;
    if (one->source == SIGNAL_RANDOM)
      oscillators_ahead(m->kernels, one->draws, first, BATCH, one->interval);
    if (one->source == SIGNAL_TABLE)
      fill_table(m, one, first[0] - s->motion_start[k]);
    else
      m->kernels->lanes_signal(one, first[0] - s->motion_start[k], BATCH);
  }
  m->known = BATCH;
  for (size_t k = 0; k < m->n_coordinates; k++) {
    const lanes_pose *p = &m->coordinates[k];
    if (p->n_signals > 1 || p->turned || !p->signals[0]->posed) m->kernels->lanes_sum(p, BATCH);
    int64_t last = last_in_range(m, p);
    if (last < m->known) m->known = last;
  }
  m->filled = true;
}

/* Starts new steps ahead after the present step k, whose poses are copied to index 0. */
static void begin_batch(pose_batch *m, int64_t k) {
  size_t w = m->width;
  for (size_t p = 0; k > 0 && p < m->n_coordinates; p++) {
    double *value = m->coordinates[p].value - w, *velocity = m->coordinates[p].velocity - w;
    memcpy(value, value + (size_t)k * w, w * sizeof(double));
    memcpy(velocity, velocity + (size_t)k * w, w * sizeof(double));
  }
  m->first += k;
}

int64_t pose_batch_ahead(pose_batch *m) {
  int64_t k = m->systems[0]->state->step + 1 - m->first;
  assert(k >= 1 && k <= BATCH + 1);
  if (!m->filled || k > BATCH) {
    begin_batch(m, k - 1);
    k = 1;
    fill(m);
  }
  assert(m->known >= 0 && m->known <= BATCH);
  return m->known - k + 1;
}

int64_t pose_batch_first(const pose_batch *m) { return m->first; }

const double *pose_batch_poses(const pose_batch *m) { return m->poses; }
