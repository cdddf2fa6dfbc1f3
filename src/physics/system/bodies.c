/* bodies.c: constants of the bodies, and edges of the periodic box; see bodies.h. */
#include "physics/system/bodies.h"

#include "model/cell.h"
#include "physics/system/clumps.h"
#include "physics/system/fields.h"

#include <assert.h>
#include <math.h>
#include <string.h>

bool body_is_moved(const engine *e, uint32_t body, size_t slot) {
  return slot >= e->state->n_free || !disk_holds(&e->model->disks[body]) ||
         e->state->activity[slot] == SD_HELD;
}

/* Notes values that are the same for all disks, so that loops need not read them disk by disk:
 * whether inverse masses along x and y are equal, and which constant forces are 0. */
static void note_sameness(engine *e) {
  work *w = &e->work;
  const size_t n = e->state->n_free;
  bool same = n == 0 || memcmp(w->inverse_mass_x, w->inverse_mass_y, n * sizeof(double)) == 0;
  w->columns[SD_Y].inverse = same ? w->inverse_mass_x : w->inverse_mass_y;
  for (int c = 0; c < SD_COORDINATES; c++) {
    w->nothing_constant[c] = true;
    for (size_t i = 0; i < n && w->nothing_constant[c]; i++)
      w->nothing_constant[c] = w->columns[c].constant[i] == 0.0;
  }
}

void bodies_fill_constants(engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  work *w = &e->work;
  for (size_t i = 0; i < s->n_free; i++) {
    assert(s->id[i] < m->n_disks);
    const sd_disk *d = &m->disks[s->id[i]];
    const double mass = s->mass[i], inertia = s->inertia[i];
    assert(!d->driven && mass > 0.0 && inertia > 0.0);
    if (d->clump > 0 &&
        body_in_play(s, i)) { /* the disk moves with its clump, and its weight acts on the clump */
      w->inverse_mass_x[i] = w->inverse_mass_y[i] = w->inverse_inertia[i] = 0.0;
      w->constant_x[i] = d->force[SD_X];
      w->constant_y[i] = d->force[SD_Y];
      w->constant_torque[i] = d->force[SD_THETA];
      continue;
    }
    if (!body_in_play(s, i)) {
      w->inverse_mass_x[i] = w->inverse_mass_y[i] = w->inverse_inertia[i] = 0.0;
      w->constant_x[i] = w->constant_y[i] = w->constant_torque[i] = 0.0;
      continue;
    }
    const bool held = s->activity[i] == SD_HELD;
    w->inverse_mass_x[i] = d->locked[SD_X] || (held && d->holds[SD_X]) ? 0.0 : 1.0 / mass;
    w->inverse_mass_y[i] = d->locked[SD_Y] || (held && d->holds[SD_Y]) ? 0.0 : 1.0 / mass;
    w->inverse_inertia[i] =
        d->locked[SD_THETA] || (held && d->holds[SD_THETA]) ? 0.0 : 1.0 / inertia;
    w->constant_x[i] = mass * m->gravity[0] + d->force[SD_X];
    w->constant_y[i] = mass * m->gravity[1] + d->force[SD_Y];
    w->constant_torque[i] = d->force[SD_THETA];
  }
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      uint32_t slot = slot_of(&w->slots, m->motions[k].bodies[b]);
      assert(slot < s->n_bodies + s->n_clumps && m->motions[k].coordinate >= 0 &&
             m->motions[k].coordinate < SD_MOVED);
      /* Skip prescribed bodies, and clumps: clumps_fill_constants sets their inverse masses. */
      if (slot >= s->n_free || !body_is_moved(e, m->motions[k].bodies[b], slot)) continue;
      int c = m->motions[k].coordinate;
      (c == SD_X   ? w->inverse_mass_x
       : c == SD_Y ? w->inverse_mass_y
                   : w->inverse_inertia)[slot] = 0.0;
    }
  clumps_fill_constants(e);
  note_sameness(e);
  body_forces_fill(e);
  fields_attach(e);
}

double box_corner(const sd_model *m, int c) {
  return m->periodic[c] ? m->lower[c] : m->region_lower[c];
}

void box_update(engine *e) {
  const sd_model *m = e->model;
  work *w = &e->work;
  assert(e->state->box_scale > 0.0);
  for (int c = 0; c < 2; c++) {
    double upper = m->upper[c], scale = cell_scale(e->state, c);
    if (scale != 1.0) upper = m->lower[c] + scale * (m->upper[c] - m->lower[c]);
    w->periodic[c] = m->periodic[c];
    w->lower[c] = m->periodic[c] ? m->lower[c] : -HUGE_VAL;
    w->upper[c] = m->periodic[c] ? upper : HUGE_VAL;
    w->length[c] = m->periodic[c] ? upper - m->lower[c] : 0.0;
    w->inverse_length[c] = m->periodic[c] ? 1.0 / w->length[c] : 0.0;
    assert(w->lower[c] < w->upper[c] && w->length[c] >= 0.0 && isfinite(w->inverse_length[c]));
  }
  w->offset = cell_offset(m, e->state);
}
