/* energy.c: sums of the energy budget; see energy.h and sd_energy. */
#include "physics/contact/energy.h"

#include <math.h>

#include "model/normal_laws.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"

/* Coordinates that are held or prescribed carry no energy of the system: their work is counted instead. */
static void add_disks(const engine *e, sd_energy *sum) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  for (size_t i = 0; i < s->n_free; i++) {
    double x = s->x[i] + s->image_x[i] * w->length[0], y = s->y[i] + s->image_y[i] * w->length[1];
    if (w->inverse_mass_x[i] != 0.0) {
      sum->kinetic_translation += 0.5 * s->mass[i] * s->vx[i] * s->vx[i];
      sum->external -= w->constant_x[i] * x;
    }
    if (w->inverse_mass_y[i] != 0.0) {
      sum->kinetic_translation += 0.5 * s->mass[i] * s->vy[i] * s->vy[i];
      sum->external -= w->constant_y[i] * y;
    }
    if (w->inverse_inertia[i] != 0.0) {
      sum->kinetic_rotation += 0.5 * s->inertia[i] * s->omega[i] * s->omega[i];
      sum->external -= w->constant_torque[i] * (s->theta[i] + s->turn[i]);
    }
    sum->viscous += s->past_viscous[i];
    sum->friction += s->past_friction[i];
    sum->opening += s->loss_opening[i];
    sum->nonconservative_work += s->past_nonconservative_work[i];
  }
}

sd_energy energy_of(const engine *e) {
  sd_energy sum = {0};
  const pairs *p = &e->work.pairs;
  add_disks(e, &sum);
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    double delta = PAIR(p, k, overlap), zeta = PAIR(p, k, zeta);
    if (e->model->integrator ==
        SD_GEAR5) { /* forces acted at the predicted coordinates, energy is stored at the corrected ones */
      const contact_geometry g = contact_geometry_of(e, k);
      delta = fmax(g.overlap, 0.0);
      zeta = g.lambda - PAIR(p, k, lambda_ref);
    }
    const sd_contact_law *law = &e->model->laws[PAIR(p, k, law)];
    sum.elastic_normal += law_energy(law, delta);
    sum.elastic_tangential += 0.5 * law->k_t * zeta * zeta;
    sum.viscous += PAIR(p, k, viscous);
    sum.friction += PAIR(p, k, friction);
    sum.nonconservative_work += PAIR(p, k, nonconservative_work);
  }
  sum.start = e->state->energy_start;
  sum.work = e->state->work_driven;
  sum.relaxed = e->state->relaxed;
  sum.residual = (energy_total(&sum) - sum.start) - (sum.work + sum.nonconservative_work) +
                 (sum.viscous + sum.friction + sum.opening + sum.relaxed);
  /* where nothing is done and nothing lost, as in a conservative collision, the motion itself is the scale; at
   * rest it is what rounding can do to the energies that are there */
  double done =
      fabs(sum.work) + fabs(sum.viscous) + fabs(sum.friction) + fabs(sum.opening) + fabs(sum.relaxed);
  double rounding = 1e-9 * (sum.elastic_normal + sum.elastic_tangential + fabs(sum.external));
  sum.scale = fmax(done, fmax(sum.kinetic_translation + sum.kinetic_rotation, rounding));
  return sum;
}
