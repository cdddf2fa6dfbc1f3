/* simulation_extend.c: adds force fields to a running simulation, adds and removes disks; see
 * slipdisk/simulation.h. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/overlaps.h"
#include "model/state.h"
#include "physics/contact/energy.h"
#include "physics/contact/evaluate.h"
#include "physics/neighbours/neighbours.h"
#include "physics/small/lanes.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/step/engine.h"
#include "physics/system/bodies.h"
#include "physics/system/fields.h"
#include "run/loop.h"
#include "run/simulation_private.h"

/* --- Force fields ----------------------------------------------------------------------------- */

sd_status simulation_store_all(sd_simulation *sim, sd_messages *messages) {
  return simulation_state(sim) ? SD_OK
                               : sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
}

static sd_status add_force_field(sd_simulation *sim, sd_force_field *field, void *user,
                                 sd_messages *messages) {
  engine *e = &sim->engine;
  sd_status status = SD_OK;
  if (!field) return sd_fail(messages, SD_ERROR_USER, "force field: expected a function, not NULL");
  /* the step for small systems cannot apply force fields: change to the general step */
  if (engine_lanes(e)) {
    status = simulation_store_all(sim, messages);
    if (status == SD_OK) status = loop_rebuild(e, false, messages);
  }
  if (status == SD_OK && fields_add(e, field, user) != SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for a force field");
  return status;
}

sd_status sd_simulation_add_force_field(sd_simulation *sim, sd_force_field *field, void *user,
                                        sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_add_force_field", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = add_force_field(sim, field, user, messages);
  simulation_leave(sim, outer);
  return status;
}

/* --- Adding and removing disks ---------------------------------------------------------------- */

/* Adds the energy of added or removed disks to energy_start, so that the residual of the energy
 * budget stays as it was. residual: the residual before the change. */
static void keep_residual(engine *e, double residual) {
  e->state->energy_start += energy_residual(e) - residual;
}

/* Subtracts the contact forces of removed disks from the forces on their partners, because the next
 * step computes the work on prescribed bodies from these forces. */
static void take_forces_off(engine *e) {
  sd_state *s = e->state;
  for (size_t k = 0; k < engine_candidates(e); k++) {
    if (!engine_contact_closed(e, k)) continue;
    const size_t a = engine_contact_a(e, k), b = engine_contact_b(e, k);
    if ((a >= s->n_free || body_in_play(s, a)) && (b >= s->n_free || body_in_play(s, b))) continue;
    const contact_reaction r = contact_reaction_of(e, k);
    s->force_x[a] += r.fx;
    s->force_y[a] += r.fy;
    s->torque[a] -= r.torque_a;
    s->force_x[b] -= r.fx;
    s->force_y[b] -= r.fy;
    s->torque[b] -= r.torque_b;
  }
}

/* Removes the stored contacts of disks that are not in play. */
static void drop_contacts_of_removed(sd_state *s, const engine *e) {
  size_t kept = 0;
  for (size_t c = 0; c < s->n_contacts; c++) {
    const uint32_t ends[2] = {engine_slot(e, s->contact_a[c]), engine_slot(e, s->contact_b[c])};
    bool in_play = true;
    for (int k = 0; k < 2; k++)
      in_play = in_play && (ends[k] >= s->n_free || body_in_play(s, ends[k]));
    if (!in_play) continue;
    for (size_t k = 0; k < sd_field_count; k++) {
      const sd_field *f = &sd_fields[k];
      if (!state_of_contacts(f->extent) || sd_extent_size(s, f->extent) == 0) continue;
      char *column = sd_field_data(s, f);
      const size_t size = sd_type_size(f->type);
      memmove(column + kept * size, column + c * size, size);
    }
    kept++;
  }
  s->n_contacts = kept;
}

/* Checks that all n disks can be removed: they must be free, in play and in no clump. */
static sd_status check_removable(const engine *e, size_t n, const uint32_t *disks,
                                 sd_messages *messages) {
  char name[96];
  if (!disks && n)
    return sd_fail(messages, SD_ERROR_USER, "remove_disks: expected %zu numbers, not NULL", n);
  for (size_t k = 0; k < n; k++) {
    if (disks[k] >= e->model->n_disks)
      return sd_fail(messages, SD_ERROR_USER,
                     "disk %u cannot be taken out: expected a free disk, of %zu disks", disks[k],
                     e->model->n_disks);
    if (engine_slot(e, disks[k]) >= e->state->n_free)
      return sd_fail(messages, SD_ERROR_USER, "%s cannot be taken out: expected a free disk",
                     sd_model_body_name(e->model, disks[k], name, sizeof name));
    if (e->model->disks[disks[k]].clump > 0)
      return sd_fail(messages, SD_ERROR_USER, "%s cannot be taken out: it belongs to a clump",
                     sd_model_body_name(e->model, disks[k], name, sizeof name));
    if (!body_in_play(e->state, engine_slot(e, disks[k])))
      return sd_fail(messages, SD_ERROR_USER, "%s cannot be taken out: it is not in play",
                     sd_model_body_name(e->model, disks[k], name, sizeof name));
  }
  return SD_OK;
}

static sd_status remove_disks(sd_simulation *sim, size_t n, const uint32_t *disks,
                              sd_messages *messages) {
  engine *e = &sim->engine;
  sd_state *s = e->state;
  sd_status status = check_removable(e, n, disks, messages);
  if (status == SD_OK) status = simulation_store_all(sim, messages);
  if (status != SD_OK || n == 0) return status;
  const double residual = energy_residual(e);
  for (size_t k = 0; k < n; k++) s->activity[engine_slot(e, disks[k])] = SD_REMOVED;
  take_forces_off(e);
  for (size_t k = 0; k < n; k++) {
    const uint32_t i = engine_slot(e, disks[k]);
    for (int c = 0; c < SD_COORDINATES; c++) {
      const columns *q = engine_columns(e, c);
      q->v[i] = q->q2[i] = q->q3[i] = q->q4[i] = q->q5[i] = q->force[i] = 0.0;
    }
  }
  drop_contacts_of_removed(s, e);
  status = loop_rebuild(e, false, messages);
  if (status == SD_OK) cell_renew(e);
  if (status == SD_OK) keep_residual(e, residual);
  return status;
}

sd_status sd_simulation_remove_disks(sd_simulation *sim, size_t n, const uint32_t *disks,
                                     sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_remove_disks", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = remove_disks(sim, n, disks, messages);
  simulation_leave(sim, outer);
  return status;
}

/* Increases the numbers of walls by n in motions, watched contacts and bonds, since walls are
 * numbered after the disks. first: number of the first wall. */
static void shift_walls(sd_model *m, uint32_t first, uint32_t n) {
  for (size_t k = 0; k < m->n_motions; k++) {
    sd_motion *q = &m->motions[k];
    for (size_t b = 0; b < q->n_bodies; b++) q->bodies[b] += q->bodies[b] >= first ? n : 0;
    for (int side = 0; side < 2; side++) q->beside[side] += q->beside[side] >= first ? n : 0;
  }
  for (size_t k = 0; k < m->n_slides; k++)
    for (int side = 0; side < 2; side++)
      m->slides[k].partner[side] += m->slides[k].partner[side] >= first ? n : 0;
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_bonding *q = &m->phases[k].bond;
    uint32_t *between = (uint32_t *)(uintptr_t)q->between;
    for (size_t b = 0; b < q->n_between; b++) between[b] += between[b] >= first ? n : 0;
    uint32_t *joined = (uint32_t *)(uintptr_t)q->pairs;
    for (size_t b = 0; b < 2 * q->n_pairs; b++) joined[b] += joined[b] >= first ? n : 0;
  }
}

sd_model *simulation_model_copy(const sd_model *old, sd_messages *messages) {
  sd_model *m = sd_model_clone(old);
  if (m)
    m->n_memories = m->n_derivatives = m->tiles.n_contacts = 0;
  else
    sd_fail(messages, SD_ERROR_IO, "out of memory for the model");
  return m;
}

/* Makes a copy of the model with n more disks. */
static sd_status larger_model(const sd_model *old, size_t n, const sd_disk *disks, sd_model **out,
                              sd_messages *messages) {
  sd_model *m = *out = simulation_model_copy(old, messages);
  if (!m) return SD_ERROR_IO;
  const uint32_t first = (uint32_t)old->n_disks;
  shift_walls(m, first, (uint32_t)n);
  sd_model_add_disks(m, n, disks);
  sd_status status = SD_OK;
  for (size_t k = first; k < m->n_disks; k++) {
    sd_disk *d = &m->disks[k];
    d->waiting = false;
    if (d->driven || (d->locked[SD_X] && d->locked[SD_Y] && d->locked[SD_THETA]))
      status = sd_fail(messages, SD_ERROR_USER,
                       "disk %zu: expected a free disk, with a coordinate that is not locked", k);
  }
  if (status == SD_OK) status = model_finish_again(m, messages);
  if (status == SD_OK) return SD_OK;
  sd_model_free(m);
  *out = NULL;
  return status;
}

/* Makes the state for the larger model: rows of the old free disks, then of the n new disks, then
 * of the other bodies. */
static sd_status larger_state(const sd_model *m, const sd_state *old, size_t n, sd_state **out) {
  sd_state *s = *out = sd_state_new(m);
  const uint32_t first = (uint32_t)old->n_disks;
  if (!s || state_size_like(s, old) != SD_OK) {
    sd_state_free(s);
    *out = NULL;
    return SD_ERROR_IO;
  }
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const size_t size = sd_type_size(f->type), all = sd_extent_size(old, f->extent);
    const size_t front = f->extent == SD_PER_BODY ? old->n_free : all;
    char *to = sd_field_data(s, f);
    const char *from = sd_field_data(old, f);
    if (all == 0) continue;
    memcpy(to, from, front * size);
    memcpy(to + (front + n) * size, from + front * size, (all - front) * size);
  }
  for (size_t i = 0; i < s->n_bodies; i++) s->id[i] += s->id[i] >= first ? (uint32_t)n : 0;
  for (size_t c = 0; c < s->n_contacts; c++)
    s->contact_b[c] += s->contact_b[c] >= first ? (uint32_t)n : 0;
  for (size_t k = 0; k < s->n_breaks; k++)
    s->break_b[k] += s->break_b[k] >= first ? (uint32_t)n : 0;
  for (size_t k = 0; k < n; k++)
    engine_fill_disk(s, &m->disks[first + k], first + (uint32_t)k, (uint32_t)(old->n_free + k));
  if (s->n_free >= ORDER_LEAST && order_disks(m, s) != SD_OK) {
    sd_state_free(s);
    *out = NULL;
    return SD_ERROR_IO;
  }
  return SD_OK;
}

/* Checks that the new disks are in the periodic box, which may have been compressed since the model
 * was made. */
static sd_status check_box(const engine *e, size_t n, const sd_disk *disks, sd_messages *messages) {
  sd_status status = SD_OK;
  for (size_t k = 0; k < n; k++)
    for (int c = 0; c < 2; c++)
      if (engine_length(e, c) > 0.0 && engine_beyond(e, c, disks[k].position[c]))
        status = sd_fail(messages, SD_ERROR_USER,
                         "disk %zu: %c = %g lies outside the periodic box, which is %g wide now",
                         e->model->n_disks + k, c == SD_X ? 'x' : 'y', disks[k].position[c],
                         engine_length(e, c));
  return status;
}

/* Check that no disk that is new or was moved overlaps another body by more than max_overlap, as
 * for the disks of a deck. */
typedef struct overlap_check {
  const sd_model *m; /* model with the bodies at their present positions */
  const bool *fresh; /* [n_disks] true for the disks to be checked */
  sd_status status;
  sd_messages *messages;
} overlap_check;

static bool check_overlap(void *user, const overlap *o) {
  overlap_check *c = user;
  const sd_model *m = c->m;
  /* radius of the smaller disk, or of the disk in a pair with a wall */
  const double smaller = m->disks[o->a].radius;
  if (!c->fresh[o->a] && !(o->b < m->n_disks && c->fresh[o->b])) return false;
  if (!o->coincident && o->depth <= m->max_overlap * smaller) return false;
  char one[96], two[96];
  const bool later = o->b < m->n_disks && o->b > o->a;
  sd_model_body_name(m, later ? o->b : o->a, one, sizeof one);
  sd_model_body_name(m, later ? o->a : o->b, two, sizeof two);
  c->status =
      o->coincident
          ? sd_fail(c->messages, SD_ERROR_USER, "%s and %s have the same centre", one, two)
          : sd_fail(c->messages, SD_ERROR_USER,
                    "%s and %s overlap by %g, more than max_overlap = %g of the %sradius %g", one,
                    two, o->depth, m->max_overlap, o->b < m->n_disks ? "smaller " : "", smaller);
  return true;
}

sd_status simulation_present(const engine *e, const sd_model *model, sd_model *now,
                             sd_messages *messages) {
  const sd_state *s = e->state;
  *now = *model;
  now->disks = NULL;
  if (!memory_resize_row(&now->disks, now->n_disks, sizeof *now->disks))
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the disks");
  memcpy(now->disks, model->disks, now->n_disks * sizeof *now->disks);
  for (size_t i = 0; i < e->model->n_disks; i++) {
    const uint32_t slot = engine_slot(e, (uint32_t)i);
    const bool here = slot >= s->n_free || body_in_play(s, slot);
    /* a disk that is not in play touches nothing: give it no position */
    now->disks[i].position[SD_X] = here ? s->x[slot] : NAN;
    now->disks[i].position[SD_Y] = here ? s->y[slot] : NAN;
  }
  for (int c = 0; c < 2; c++)
    if (now->periodic[c]) {
      now->lower[c] = engine_lower(e, c);
      now->upper[c] = now->lower[c] + engine_length(e, c);
    }
  return SD_OK;
}

sd_status simulation_check_overlaps(const engine *e, const sd_model *now, const bool *fresh,
                                    sd_messages *messages) {
  const sd_state *s = e->state;
  overlap_check check = {now, fresh, SD_OK, messages};
  const size_t n_disks = now->n_disks;
  assert(fresh || n_disks == 0);
  if (!(now->max_overlap > 0.0)) return SD_OK;
  if (overlaps_of_disks(now, check_overlap, &check) != SD_OK)
    check.status = sd_fail(messages, SD_ERROR_IO, "out of memory for the overlaps");
  for (uint32_t i = 0; check.status == SD_OK && i < n_disks; i++)
    for (uint32_t w = 0; fresh[i] && check.status == SD_OK && w < now->n_walls; w++) {
      const uint32_t slot = engine_slot(e, (uint32_t)e->model->n_disks + w);
      const double pose[3] = {s->x[slot], s->y[slot], s->turn[slot] + s->theta[slot]};
      const uint32_t wall = (uint32_t)now->n_disks + w;
      check_overlap(
          &check,
          &(overlap){i, wall, i, -overlaps_gap(now, i, now->disks[i].position, wall, pose), false});
    }
  return check.status;
}

/* Checks the overlaps of the new disks of `model` with all bodies at their present positions. */
static sd_status check_new(const engine *e, const sd_model *model, sd_messages *messages) {
  sd_model now;
  bool *fresh = NULL;
  sd_status status = simulation_present(e, model, &now, messages);
  if (status != SD_OK) return status;
  if (!memory_row(&fresh, now.n_disks, sizeof *fresh))
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for the overlaps");
  for (size_t i = e->model->n_disks; fresh && i < now.n_disks; i++) fresh[i] = true;
  if (status == SD_OK) status = simulation_check_overlaps(e, &now, fresh, messages);
  free(fresh);
  free(now.disks);
  return status;
}

static sd_status add_disks(sd_simulation *sim, size_t n, const sd_disk *disks, uint32_t *first,
                           sd_messages *messages) {
  engine *e = &sim->engine;
  const uint32_t number = (uint32_t)e->model->n_disks;
  sd_model *model;
  sd_state *state;
  if (first) *first = number;
  if (n == 0) return SD_OK;
  if (!disks) return sd_fail(messages, SD_ERROR_USER, "add_disks: expected %zu disks, not NULL", n);
  if (n > LIMIT_DISKS - e->model->n_disks)
    return sd_fail(messages, SD_ERROR_USER, "add_disks: %zu disks: expected at most %d in all", n,
                   LIMIT_DISKS);
  if (e->model->measure_disks)
    return sd_fail(messages, SD_ERROR_USER,
                   "disks cannot be added while means of every disk are measured (measure.disks)");
  sd_status status = check_box(e, n, disks, messages);
  if (status == SD_OK) status = simulation_store_all(sim, messages);
  if (status == SD_OK) status = larger_model(e->model, n, disks, &model, messages);
  if (status != SD_OK) return status;
  status = check_new(e, model, messages);
  if (status != SD_OK) {
    sd_model_free(model);
    return status;
  }
  if (larger_state(model, e->state, n, &state) != SD_OK) {
    sd_model_free(model);
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the state");
  }
  const double residual = energy_residual(e);
  const bool small = engine_lanes(e) && lanes_suit(model);
  sd_state *old = e->state;
  e->state = state;
  e->model = model;
  if (fields_resize(e) != SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for a force field");
  if (status == SD_OK)
    status = loop_rebuild(e, small, messages);
  else
    loop_release(e);
  sd_state_free(old);
  sd_model_free(sim->owned);
  sim->owned = model;
  if (status != SD_OK) return status;
  for (uint32_t k = 0; k < n; k++) cell_enter(e, engine_slot(e, number + k));
  for (uint32_t k = 0; k < n; k++)
    body_forces_renew(e, engine_slot(e, number + k), engine_slot(e, number + k) + 1);
  for (uint32_t k = 0; k < n; k++) /* new disks begin with the acceleration of gravity */
    for (int c = 0; c < SD_COORDINATES; c++)
      engine_accelerate(e, c, engine_slot(e, number + k), 0.0);
  keep_residual(e, residual);
  return SD_OK;
}

sd_status sd_simulation_add_disks(sd_simulation *sim, size_t n, const sd_disk *disks,
                                  uint32_t *first, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_add_disks", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = add_disks(sim, n, disks, first, messages);
  simulation_leave(sim, outer);
  return status;
}
