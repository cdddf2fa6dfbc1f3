/* lanes_motion.c: see lanes_motion.h. */
#include "physics/lanes_motion.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "physics/motion.h"

/* A prescribed coordinate with a running motion. */
typedef struct lanes_place {
  uint32_t slot;
  int coordinate;
  double *value, *velocity; /* [ROWS][width] each, with the stride of the rows */
  double *low, *high;       /* [width] */
} lanes_place;

enum { ROWS = MOTION_BATCH + 1 };

struct lanes_motion {
  size_t width, n, first_slot, n_slots; /* prescribed bodies */
  engine **systems;                     /* [width] */
  lanes_pose *poses;                    /* [n_slots][POSES] */
  double *still;                        /* [n_slots][POSES][width]: where nothing moves */
  size_t n_places, capacity;
  lanes_place *places;
  double *rows;   /* [ROWS][2 n_places][width] */
  double *ranges; /* [2 n_places][width] */
  int64_t first;  /* step of system 0 before the batch */
  bool filled;
  int64_t known; /* last row in range */
};

static double *vectors(size_t n, size_t width) {
  size_t bytes = (n * width * sizeof(double) + 127) / 64 * 64;
  double *p = aligned_alloc(64, bytes);
  if (p) memset(p, 0, bytes);
  return p;
}

sd_status lanes_motion_new(size_t width, size_t n, engine *const *systems, lanes_motion **out) {
  lanes_motion *m = calloc(1, sizeof *m);
  *out = m;
  if (!m) return SD_ERROR_IO;
  const sd_state *s = systems[0]->state;
  const sd_model *model = systems[0]->model;
  m->width = width;
  m->n = n;
  m->first_slot = s->n_free;
  m->n_slots = s->n_bodies - s->n_free;
  for (size_t k = 0; k < model->n_motions; k++) m->capacity += model->motions[k].n_bodies;
  if (m->capacity > 3 * m->n_slots) m->capacity = 3 * m->n_slots;
  m->systems = calloc(width, sizeof *m->systems);
  m->poses = calloc(m->n_slots * POSES + 1, sizeof *m->poses);
  m->places = calloc(m->capacity + 1, sizeof *m->places);
  m->still = vectors(m->n_slots * POSES, width);
  m->rows = vectors(ROWS * 2 * m->capacity, width);
  m->ranges = vectors(2 * m->capacity, width);
  if (!m->systems || !m->poses || !m->places || !m->still || !m->rows || !m->ranges) {
    lanes_motion_free(m);
    *out = NULL;
    return SD_ERROR_IO;
  }
  for (size_t l = 0; l < width; l++) m->systems[l] = systems[l < n ? l : 0];
  return SD_OK;
}

void lanes_motion_free(lanes_motion *m) {
  if (!m) return;
  free(m->systems);
  free(m->poses);
  free(m->places);
  free(m->still);
  free(m->rows);
  free(m->ranges);
  free(m);
}

/* --- load and store ---------------------------------------------------------------------------------- */

static lanes_pose *pose_of(lanes_motion *m, uint32_t slot) {
  return m->poses + (slot - m->first_slot) * POSES;
}

/* Everything at rest where the states say. */
static void load_still(lanes_motion *m) {
  for (size_t i = 0; i < m->n_slots; i++)
    for (size_t l = 0; l < m->width; l++) {
      const sd_state *s = m->systems[l]->state;
      size_t slot = m->first_slot + i;
      double now[POSES] = {s->x[slot], s->y[slot], s->theta[slot], s->vx[slot], s->vy[slot], s->omega[slot]};
      for (size_t c = 0; c < POSES; c++) m->still[(i * POSES + c) * m->width + l] = now[c];
    }
  for (size_t k = 0; k < m->n_slots * POSES; k++)
    m->poses[k] = (lanes_pose){m->still + k * m->width, 0, NULL, NULL};
}

static void load_place(lanes_motion *m, lanes_place *p, size_t k) {
  size_t stride = 2 * m->n_places, w = m->width;
  p->value = m->rows + 2 * k * w;
  p->velocity = p->value + w;
  p->low = m->ranges + 2 * k * w;
  p->high = p->low + w;
  lanes_pose *pose = pose_of(m, p->slot);
  memcpy(p->value, pose[p->coordinate].at, w * sizeof(double));
  for (size_t l = 0; l < w; l++) {
    const sd_state *s = m->systems[l]->state;
    const double *speed[] = {s->vx, s->vy, s->omega};
    p->velocity[l] = speed[p->coordinate][p->slot];
  }
  pose[p->coordinate] = (lanes_pose){p->value, stride, p->low, p->high};
  pose[POSE_VX + p->coordinate] = (lanes_pose){p->velocity, stride, NULL, NULL};
}

void lanes_motion_load(lanes_motion *m) {
  for (size_t l = 0; l < m->n; l++) motion_reload(m->systems[l]);
  load_still(m);
  size_t n;
  const placed *from = motion_places(m->systems[0], &n);
  m->n_places = 0;
  for (size_t k = 0; k < n; k++)
    if (from[k].slot >= m->first_slot) m->n_places++;
  assert(m->n_places == n && n <= m->capacity);
  for (size_t k = 0; k < n; k++) {
    m->places[k] = (lanes_place){.slot = from[k].slot, .coordinate = from[k].coordinate};
    load_place(m, &m->places[k], k);
  }
  m->first = m->systems[0]->state->step;
  m->filled = false;
}

void lanes_motion_store(lanes_motion *m) {
  for (size_t l = 0; l < m->n; l++) {
    motion_store(m->systems[l]);
    motion_reload(m->systems[l]);
  }
}

/* --- the batch --------------------------------------------------------------------------------------- */

static void fill(lanes_motion *m) {
  size_t w = m->width, row = 2 * m->n_places * w;
  m->known = MOTION_BATCH;
  m->filled = true;
  for (size_t l = 0; l < w; l++) {
    engine *e = m->systems[l];
    size_t n;
    motion_ahead(e);
    assert(motion_index(e) == 0);
    const placed *from = motion_places(e, &n);
    for (size_t p = 0; p < n; p++) {
      lanes_place *to = &m->places[p];
      for (size_t k = 0; k < MOTION_BATCH; k++) {
        to->value[(k + 1) * row + l] = from[p].value[k];
        to->velocity[(k + 1) * row + l] = from[p].velocity[k];
        if (!motion_in_range(e, to->coordinate, from[p].value[k]) && (int64_t)k < m->known)
          m->known = (int64_t)k;
      }
      to->low[l] = from[p].low;
      to->high[l] = from[p].high;
    }
  }
}

int64_t lanes_motion_ahead(lanes_motion *m) {
  size_t row = 2 * m->n_places * m->width;
  int64_t k = m->systems[0]->state->step + 1 - m->first;
  if (!m->filled || k > MOTION_BATCH) {
    memcpy(m->rows, m->rows + (size_t)(k - 1) * row, row * sizeof(double));
    m->first += k - 1;
    k = 1;
    fill(m);
  }
  return m->known - k + 1;
}

int64_t lanes_motion_first(const lanes_motion *m) { return m->first; }

const lanes_pose *lanes_motion_pose(const lanes_motion *m, uint32_t slot) {
  return m->poses + (slot - m->first_slot) * POSES;
}
