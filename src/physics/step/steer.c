/* steer.c: changes of bodies between two steps; implements steer.h. */
#include "physics/step/steer.h"

#include <math.h>

#include "physics/contact/energy.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/motion/motion.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/step/step.h"
#include "physics/system/bodies.h"
#include "physics/system/halo.h"
#include "physics/system/fields.h"

/* Sets the third and higher derivatives of a coordinate to 0, as at step 0: those of the motion
 * before the change are not those after it. */
static void restart(engine *e, size_t slot, int c) {
  const columns *q = &e->work.columns[c];
  q->q3[slot] = q->q4[slot] = q->q5[slot] = 0.0;
}

/* Adds the jump of a disk's angle to the angles from which its measured rotation counts, so that
 * the jump does not count as rotation. */
static void shift_measured(sd_state *s, const sd_model *m, size_t slot, double jump) {
  for (size_t k = 0; k < s->n_rotations; k++) {
    if (m->rotations[k] != s->id[slot]) continue;
    s->rotation_start[k] += jump;
    s->rotation_last[k] += jump;
    s->rotation_stop[k] += jump;
  }
}

void steer_place(engine *e, size_t slot, int c, double value) {
  sd_state *s = e->state;
  if (c == SD_THETA) {
    const double before = s->theta[slot] + s->turn[slot];
    s->turn[slot] = 8.0 * nearbyint(value / 8.0);
    s->theta[slot] = value - s->turn[slot];
    shift_measured(s, e->model, slot, s->theta[slot] + s->turn[slot] - before);
  } else {
    e->work.columns[c].q[slot] = value;
    cell_enter(e, (uint32_t)slot);
  }
  restart(e, slot, c);
}

void steer_speed(engine *e, size_t slot, int c, double value) {
  e->work.columns[c].v[slot] = value;
  restart(e, slot, c);
}

void steer_size(engine *e, size_t slot, double radius, double mass, double inertia) {
  e->state->radius[slot] = radius;
  e->state->mass[slot] = mass;
  e->state->inertia[slot] = inertia;
  for (int c = 0; c < SD_COORDINATES; c++) restart(e, slot, c);
}

sd_status steer_end_contacts(engine *e, const bool *moved) {
  const sd_status status = contacts_end(e, moved);
  return status == SD_OK ? contacts_store(e) : status;
}

void steer_keep_displacements(engine *e, const bool *changed) {
  pairs *p = &e->work.pairs;
  const size_t n_free = e->state->n_free;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    const size_t a = (size_t)p->a[k], b = (size_t)p->b[k];
    if (!changed[a] && !(b < n_free && changed[b])) continue;
    const contact_geometry g = contact_geometry_of(e, k);
    pairs_shift_lambda(p, k, (g.lambda - PAIR(p, k, zeta)) - PAIR(p, k, lambda_ref));
    if (p->more && e->work.features & LAW_ROLLING)
      pairs_shift_rho(p, k, (contact_rho_of(e, k) - MORE(p, k, rho)) - MORE(p, k, rho_ref));
  }
}

/* --- holding and releasing -------------------------------------------------------------------- */

sd_status steer_hold(engine *e, uint32_t disk, bool hold) {
  sd_state *s = e->state;
  const uint32_t slot = engine_slot(e, disk);
  const sd_disk *d = &e->model->disks[disk];
  if (slot >= s->n_free || hold == (s->activity[slot] == SD_HELD)) return SD_OK;
  if (!body_in_play(s, slot)) return SD_OK;
  s->activity[slot] = hold ? SD_HELD : SD_IN_PLAY;
  for (int c = 0; c < SD_COORDINATES; c++) {
    if (!d->holds[c]) continue;
    const columns *q = &e->work.columns[c];
    if (hold) q->v[slot] = q->q2[slot] = 0.0;
    restart(e, slot, c);
  }
  return hold ? motion_take_over(e, disk) : SD_OK;
}

bool steer_is_due(const engine *e) {
  const sd_phase *p = &e->model->phases[e->state->phase];
  return p->n_hold + p->n_release > 0;
}

sd_status steer_begin_phase(engine *e) {
  const sd_phase *p = &e->model->phases[e->state->phase];
  sd_status status = SD_OK;
  if (!steer_is_due(e)) return SD_OK;
  for (size_t k = 0; k < p->n_hold && status == SD_OK; k++)
    status = steer_hold(e, p->hold[k], true);
  for (size_t k = 0; k < p->n_release && status == SD_OK; k++)
    status = steer_hold(e, p->release[k], false);
  if (e->halo) halo_refresh(e, NULL); /* ghosts of held disks rest, too */
  bodies_fill_constants(e);
  return status;
}

/* --- budget ----------------------------------------------------------------------------------- */

sd_status steer_finish(engine *e, double residual, bool holds, sd_messages *messages) {
  fields_renew(e);
  const sd_status status = renew_forces(e, messages);
  if (status != SD_OK) return status;
  *(holds ? &e->state->energy_start : &e->state->work_driven) += energy_residual(e) - residual;
  return status;
}
