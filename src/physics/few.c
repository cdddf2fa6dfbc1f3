/* few.c: moving few disks between the state and struct few; see few.h. */
#include "physics/few.h"

#include <stdlib.h>
#include <string.h>

#include "physics/contacts.h"
#include "physics/kernels.h"
#include "physics/neighbours.h"

/* Something is done to the system between steps, or looked at after them, that struct few does not follow, or a
 * wall moves by itself. */
static bool has_more_to_do(const sd_model *m) {
  bool more =
      m->measure_disks || m->n_rains > 0 || (m->bounds.given && m->bounds.outside == SD_OUTSIDE_REMOVE);
  for (size_t k = 0; k < m->n_phases; k++) more = more || m->phases[k].relax || m->phases[k].compress.asked;
  for (size_t k = 0; k < m->n_motions; k++)
    more = more || m->motions[k].kind == SD_MOTION_LOAD || m->motions[k].kind == SD_MOTION_SERVO;
  return more;
}

sd_status few_new(engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  if (s->n_free > FEW_FREE || s->n_bodies > FEW_BODIES || e->model->n_segments > 0 || w->periodic[0] ||
      w->periodic[1] || w->n_threads != 1 || has_more_to_do(e->model))
    return SD_OK;
  few *f = aligned_alloc(64, (sizeof *f + 63) / 64 * 64);
  if (!f) return SD_ERROR_IO;
  memset(f, 0, sizeof *f);
  f->columns = (columns){f->q[0],  f->v[0],     f->q2[0],       f->q3[0],     f->q4[0],
                         f->q5[0], f->force[0], f->constant[0], f->inverse[0]};
  e->work.few = f;
  return SD_OK;
}

void few_free(engine *e) {
  few *f = e->work.few;
  if (!f) return;
  free(f->a);
  free(f->b);
  free(f->places);
  free(f);
  e->work.few = NULL;
}

/* Rows of the present list of pairs. */
static sd_status list_pairs(engine *e) {
  few *f = e->work.few;
  const pairs *p = &e->work.pairs;
  if (p->count > f->pairs_capacity) {
    free(f->a);
    free(f->b);
    f->pairs_capacity = p->count + 8;
    f->a = malloc(f->pairs_capacity * sizeof *f->a);
    f->b = malloc(f->pairs_capacity * sizeof *f->b);
    if (!f->a || !f->b) return SD_ERROR_IO;
  }
  for (size_t k = 0; k < p->count; k++) {
    f->a[k] = 4 * p->a[k];
    f->b[k] = 4 * p->b[k];
  }
  f->builds = e->work.builds;
  return SD_OK;
}

static sd_status list_places(engine *e) {
  few *f = e->work.few;
  placed *from = motion_places(e, &f->n_places);
  if (f->n_places > f->places_capacity) {
    free(f->places);
    f->places_capacity = f->n_places;
    f->places = malloc(f->places_capacity * sizeof *f->places);
    if (!f->places) return SD_ERROR_IO;
  }
  for (size_t k = 0; k < f->n_places; k++) {
    uint32_t i = from[k].slot;
    int c = from[k].coordinate;
    f->places[k] = (few_place){&f->q[i][c], &f->v[i][c], &f->force[i][c], &from[k]};
  }
  return SD_OK;
}

sd_status few_load(engine *e) {
  few *f = e->work.few;
  const sd_state *s = e->state;
  for (size_t i = 0; i < s->n_bodies; i++) {
    memcpy(f->q[i], (double[4]){s->x[i], s->y[i], s->theta[i]}, sizeof f->q[i]);
    memcpy(f->v[i], (double[4]){s->vx[i], s->vy[i], s->omega[i]}, sizeof f->v[i]);
    memcpy(f->force[i], (double[4]){s->force_x[i], s->force_y[i], s->torque[i]}, sizeof f->force[i]);
    f->radius[i][0] = s->radius[i];
  }
  const columns *c = e->work.columns;
  for (size_t i = 0; i < s->n_free; i++)
    for (int k = 0; k < SD_COORDINATES; k++) {
      f->q2[i][k] = c[k].q2[i];
      f->q3[i][k] = c[k].q3[i];
      f->q4[i][k] = c[k].q4[i];
      f->q5[i][k] = c[k].q5[i];
      f->constant[i][k] = c[k].constant[i];
      f->inverse[i][k] = c[k].inverse[i];
    }
  if (list_pairs(e) != SD_OK || list_places(e) != SD_OK) return SD_ERROR_IO;
  return SD_OK;
}

void few_store(engine *e) {
  const few *f = e->work.few;
  sd_state *s = e->state;
  for (size_t i = 0; i < s->n_bodies; i++) {
    s->x[i] = f->q[i][SD_X];
    s->y[i] = f->q[i][SD_Y];
    s->theta[i] = f->q[i][SD_THETA];
    s->vx[i] = f->v[i][SD_X];
    s->vy[i] = f->v[i][SD_Y];
    s->omega[i] = f->v[i][SD_THETA];
    s->force_x[i] = f->force[i][SD_X];
    s->force_y[i] = f->force[i][SD_Y];
    s->torque[i] = f->force[i][SD_THETA];
  }
  const columns *c = e->work.columns;
  for (size_t i = 0; i < s->n_free; i++)
    for (int k = 0; k < SD_COORDINATES; k++) {
      c[k].q2[i] = f->q2[i][k];
      c[k].q3[i] = f->q3[i][k];
      c[k].q4[i] = f->q4[i][k];
      c[k].q5[i] = f->q5[i][k];
    }
}

bool few_ready(engine *e) { return motion_ahead(e) && e->work.few->builds == e->work.builds; }

/* The rows hold trial coordinates, the pending commit wants the corrected ones: it gets them for a while; for
 * good when the step that they belong to went wrong. */
static void finish_before(engine *e, few_measure *measure) {
  few *f = e->work.few;
  few_rows q, v;
  memcpy(q, f->q, sizeof q);
  memcpy(v, f->v, sizeof v);
  memcpy(f->q, f->q_before, sizeof q);
  memcpy(f->v, f->v_before, sizeof v);
  e->work.kernels->few_finish(e, measure);
  if (e->work.status != SD_OK) return;
  memcpy(f->q, q, sizeof q);
  memcpy(f->v, v, sizeof v);
}

sd_status few_rebuild(engine *e, few_measure *measure) {
  if (e->work.few->pending) finish_before(e, measure);
  if (e->work.status != SD_OK) return e->work.status;
  few_store(e);
  sd_status status = neighbours_build(e, e->work.messages);
  if (status == SD_OK && list_pairs(e) != SD_OK)
    status = sd_fail(e->work.messages, SD_ERROR_IO, "out of memory for the list of neighbours");
  return status;
}

/* The step that the events belong to is complete: its coordinates are the ones before the trial, if any. */
sd_status few_events(engine *e) {
  few *f = e->work.few;
  sd_state *s = e->state;
  double(*q)[4] = f->pending ? f->q_before : f->q;
  for (size_t i = 0; i < s->n_bodies; i++) {
    s->x[i] = q[i][SD_X];
    s->y[i] = q[i][SD_Y];
    s->theta[i] = q[i][SD_THETA];
  }
  bool returns = e->work.threads[0].returns.count != 0;
  s->step--; /* messages and motions count from the step that is being taken */
  sd_status status = contacts_events(e, e->work.messages);
  s->step++;
  if (status != SD_OK && f->pending) { /* the run ends here: back from the trial coordinates */
    memcpy(f->q, f->q_before, sizeof f->q);
    memcpy(f->v, f->v_before, sizeof f->v);
  }
  for (size_t i = 0; returns && i < s->n_bodies; i++) f->q[i][SD_THETA] = s->theta[i]; /* the box is open */
  return status;
}
