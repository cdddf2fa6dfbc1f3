/* fields.c: force fields of the calling program and of the model; see fields.h. */
#include "physics/system/fields.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/field_kinds.h"
#include "model/model.h"
#include "physics/system/bodies.h"
#include "physics/system/clumps.h"
#include "physics/system/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "base/vmath.h"

/* Sets `total` to the constant forces plus the fields of the calling program. */
static void sum_up(engine *e) {
  for (int c = 0; c < SD_COORDINATES; c++) {
    const work *w = &e->work;
    const double *constant = c == SD_X   ? w->constant_x
                             : c == SD_Y ? w->constant_y
                                         : w->constant_torque;
    for (size_t i = 0; i < e->state->n_free; i++)
      e->fields->total[c][i] = constant[i] + e->fields->force[c][i];
  }
}

void fields_attach(engine *e) {
  for (int c = 0; e->fields && c < SD_COORDINATES; c++) {
    e->work.columns[c].constant = e->fields->total[c];
    e->work.nothing_constant[c] = false;
  }
  if (e->fields) sum_up(e);
  body_forces_attach(e);
}

static void evaluate(engine *e, int64_t step) {
  const sd_state *s = e->state;
  fields *f = e->fields;
  for (int c = 0; c < SD_COORDINATES; c++) memset(f->force[c], 0, s->n_free * sizeof(double));
  const sd_force_columns present = {.step = step,
                                    .time = (double)step * e->work.dt,
                                    .n_free = s->n_free,
                                    .n_bodies = s->n_bodies,
                                    .id = s->id,
                                    .x = s->x,
                                    .y = s->y,
                                    .theta = s->theta,
                                    .turn = s->turn,
                                    .vx = s->vx,
                                    .vy = s->vy,
                                    .omega = s->omega,
                                    .radius = s->radius,
                                    .mass = s->mass,
                                    .inertia = s->inertia,
                                    .material = s->material,
                                    .group = s->group,
                                    .activity = s->activity,
                                    .force_x = f->force[SD_X],
                                    .force_y = f->force[SD_Y],
                                    .torque = f->force[SD_THETA]};
  f->calling = true;
  for (size_t k = 0; k < f->n; k++) f->item[k].call(&present, f->item[k].user);
  f->calling = false;
  /* The function of the calling program has forked: the child process lacks the threads of the
   * step. */
  if (pool_forked(e->pool)) e->work.status = SD_ERROR_USER;
  sum_up(e);
}

void fields_apply(engine *e) {
  if (e->fields) evaluate(e, e->state->step + 1);
}

/* Returns the power of the calling program's fields on coordinates that are not locked or
 * prescribed, summed in the order of slots. */
static double power(const engine *e) {
  double sum = 0.0;
  for (int c = 0; c < SD_COORDINATES; c++) {
    const columns *q = &e->work.columns[c];
    for (size_t i = 0; i < e->state->n_free; i++)
      if (q->inverse[i] != 0.0) sum += e->fields->force[c][i] * q->v[i];
  }
  for (size_t k = 0; k < e->work.clumps.count; k++) {
    const clump_load load = clumps_load_of(e, k, e->fields->force[SD_X], e->fields->force[SD_Y],
                                           e->fields->force[SD_THETA]);
    for (int c = 0; c < SD_COORDINATES; c++)
      if (e->work.clumps.columns[c].inverse[k] != 0.0)
        sum += load.on[c] * e->work.clumps.columns[c].v[k];
  }
  return sum;
}

void fields_work(engine *e) {
  if (!e->fields) return;
  const double now = power(e);
  e->state->work_driven += 0.5 * e->work.dt * (e->state->field_power + now);
  e->state->field_power = now;
}

void fields_renew(engine *e) {
  if (!e->fields) return;
  evaluate(e, e->state->step);
  e->state->field_power = power(e);
}

static void free_columns(fields *f) {
  for (int c = 0; c < SD_COORDINATES; c++) {
    free(f->force[c]);
    free(f->total[c]);
  }
}

sd_status fields_resize(engine *e) {
  fields *f = e->fields;
  memory_column column[2 * SD_COORDINATES];
  if (!f) return SD_OK;
  free_columns(f);
  for (int c = 0; c < SD_COORDINATES; c++) {
    column[2 * c] = (memory_column){&f->force[c], e->state->n_free, sizeof(double)};
    column[2 * c + 1] = (memory_column){&f->total[c], e->state->n_free, sizeof(double)};
  }
  return memory_rows(2 * SD_COORDINATES, column) ? SD_OK : SD_ERROR_IO;
}

sd_status fields_add(engine *e, sd_force_field *call, void *user) {
  assert(!e->work.lanes && call);
  if (!e->fields) {
    e->fields = memory_new(1, sizeof *e->fields);
    if (fields_resize(e) != SD_OK) {
      fields_free(e);
      return SD_ERROR_IO;
    }
  }
  fields *f = e->fields;
  f->item = memory_grow(f->item, f->n + 1, sizeof *f->item);
  f->item[f->n].call = call;
  f->item[f->n].user = user;
  f->n++;
  fields_attach(e);
  if (e->state->step > 0) return SD_OK;
  evaluate(e, 0);
  e->state->field_power = power(e);
  body_forces_renew(e, 0, e->state->n_free);
  for (int c = 0; c < SD_COORDINATES; c++) {
    const columns *q = &e->work.columns[c];
    for (size_t i = 0; i < e->state->n_free; i++)
      q->q2[i] = e->work.half_dt2 * ((q->force[i] + q->constant[i]) * q->inverse[i]);
  }
  clumps_accelerate(e);
  return SD_OK;
}

void fields_free(engine *e) {
  if (!e->fields) return;
  free_columns(e->fields);
  free(e->fields->item);
  free(e->fields);
  e->fields = NULL;
}

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

/* Sets the weights with which a force field acts on the free disk in slot i; 0 if the disk is not
 * in play. */
static void weigh(const sd_state *s, body_force_row *r, size_t i) {
  const field_weight w = field_weight_of(r->field, s->radius[i], s->mass[i], s->inertia[i]);
  const bool acts = body_in_play(s, i);
  r->weight[i] = acts ? w.force : 0.0;
  r->turn_weight[i] = acts ? w.torque : 0.0;
}

/* Moves Cundall's damping from the disks of clumps to the clumps, since it acts on a clump as a
 * whole: the damping coefficients of a clump are those of the field times the mean weight of the
 * clump's disks, weighted by mass. */
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
  /* The trapezoidal rule of the next step must not use powers of absent disks. */
  for (size_t i = 0; i < s->n_free; i++)
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

void body_forces_at(engine *e, int64_t step) {
  body_forces *f = e->work.body_forces;
  for (size_t k = 0; f && k < f->n; k++) {
    const sd_body_force *field = f->row[k].field;
    if (field->kind != SD_FIELD_GRAVITY) continue;
    const double turns = (field->tilt + field->omega * ((double)step * e->work.dt)) * (0.5 / M_PI);
    double s, c;
    sine_cosine_w1(turns, &s, &c);
    f->row[k].push[0] = -field->g * s;
    f->row[k].push[1] = -field->g * c;
  }
}

void body_forces_renew(engine *e, size_t begin, size_t end) {
  if (!e->work.body_forces) return;
  body_forces_at(e, e->state->step);
  assert(begin <= end && end <= e->state->n_free && e->work.body_forces->base[SD_X]);
  e->work.kernels->fields(e, begin, end);
}
