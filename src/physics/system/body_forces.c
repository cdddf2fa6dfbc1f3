/* body_forces.c: see body_forces.h. */
#include "physics/system/body_forces.h"

#include <assert.h>
#include <stdlib.h>

#include "base/arena.h"
#include "base/memory.h"
#include "model/field_kinds.h"
#include "physics/system/bodies.h"
#include "physics/system/fields.h"
#include "physics/system/kernels.h"

sd_status body_forces_new(engine *e) {
  const size_t n = e->model->n_fields, bytes = e->state->n_free * sizeof(double);
  if (n == 0) return SD_OK;
  body_forces *f = e->work.body_forces = memory_new(1, sizeof *f + n * sizeof f->row[0]);
  f->n = n;
  arena_plan plan = {0};
  for (size_t k = 0; k < 2 * n + SD_COORDINATES; k++) arena_column(&plan, bytes);
  char *room = f->arena = arena_new(&plan);
  if (!room) return SD_ERROR_IO;
  plan = (arena_plan){0};
  for (size_t k = 0; k < n; k++) {
    f->row[k].field = &e->model->fields[k];
    f->row[k].weight = (double *)(void *)(room + arena_column(&plan, bytes));
    f->row[k].turn_weight = (double *)(void *)(room + arena_column(&plan, bytes));
  }
  for (int c = 0; c < SD_COORDINATES; c++)
    f->total[c] = (double *)(void *)(room + arena_column(&plan, bytes));
  return SD_OK;
}

void body_forces_free(engine *e) {
  if (!e->work.body_forces) return;
  arena_free(e->work.body_forces->arena);
  free(e->work.body_forces);
  e->work.body_forces = NULL;
}

static void weigh(const sd_state *s, body_force_row *r, size_t i) {
  const field_weight w = field_weight_of(r->field, s->radius[i], s->mass[i], s->inertia[i]);
  const bool acts = body_in_play(s, i);
  r->weight[i] = acts ? w.force : 0.0;
  r->turn_weight[i] = acts ? w.torque : 0.0;
}

/* Damping acts on a clump as a whole, with the mean of its disks' fractions. */
static void take_damping(engine *e, body_force_row *r) {
  const clumps *c = &e->work.clumps;
  for (size_t k = 0; k < c->count; k++) {
    double mass = 0.0, weighed = 0.0;
    for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
      const uint32_t i = c->member[n];
      mass += e->state->mass[i];
      weighed += e->state->mass[i] * r->weight[i];
      r->weight[i] = 0.0;
    }
    c->alpha[k] += r->field->alpha * (weighed / mass);
    c->alpha_rotation[k] += r->field->alpha_rotation * (weighed / mass);
  }
}

void body_forces_fill(engine *e) {
  body_forces *f = e->work.body_forces;
  const sd_state *s = e->state;
  if (!f) return;
  f->phase = s->phase;
  for (size_t i = 0; i < s->n_free; i++) /* what is out of play keeps no power for the next step */
    if (!body_in_play(s, i)) s->power_work[i] = s->power_drag[i] = s->power_damping[i] = 0.0;
  for (size_t k = 0; k < e->work.clumps.count; k++)
    e->work.clumps.alpha[k] = e->work.clumps.alpha_rotation[k] = 0.0;
  for (size_t k = 0; k < f->n; k++) {
    body_force_row *r = &f->row[k];
    const bool on = body_force_is_on(e->model, k, s->phase), all = r->field->n_disks == 0;
    for (size_t i = 0; i < s->n_free; i++) {
      if (on && all)
        weigh(s, r, i);
      else
        r->weight[i] = r->turn_weight[i] = 0.0;
    }
    for (size_t n = 0; on && n < r->field->n_disks; n++) {
      const uint32_t slot = slot_of(&e->work.slots, r->field->disks[n]);
      if (slot < s->n_free) weigh(s, r, slot);
    }
    if (r->field->kind == SD_FIELD_DAMPING) take_damping(e, r);
  }
}

void body_forces_attach(engine *e) {
  body_forces *f = e->work.body_forces;
  const sd_state *s = e->state;
  work *w = &e->work;
  if (!f) return;
  double *const constant[] = {w->constant_x, w->constant_y, w->constant_torque};
  double *const force[] = {s->field_x, s->field_y, s->field_torque};
  double *const power[] = {s->power_work, s->power_drag, s->power_damping};
  double *const sum[] = {s->field_work, s->loss_drag, s->loss_damping};
  f->clumped = w->clumps.count ? w->clumps.clumped : NULL;
  for (int c = 0; c < SD_COORDINATES; c++) {
    f->force[c] = force[c];
    f->power[c] = power[c];
    f->sum[c] = sum[c];
    f->base[c] = e->fields ? e->fields->total[c] : constant[c];
    w->columns[c].constant = f->total[c];
    w->nothing_constant[c] = false;
    for (size_t i = 0; i < s->n_free; i++) f->total[c][i] = f->base[c][i] + force[c][i];
  }
}

void body_forces_renew(engine *e, size_t begin, size_t end) {
  if (!e->work.body_forces) return;
  assert(begin <= end && end <= e->state->n_free && e->work.body_forces->base[SD_X]);
  e->work.kernels->fields(e, begin, end);
}
