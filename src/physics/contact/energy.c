/* energy.c: the energy budget, and energy losses of contacts; implements energy.h. */
#include "physics/contact/energy.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/exact_sum.h"
#include "base/math.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/system/box.h"
#include "physics/system/clumps.h"
#include "physics/system/halo.h"

/* Exact sums over disks and contacts, one for each member of sd_energy. Exact sums do not depend on
 * the order of their terms, so that the total over ranks has the same bits as in a run in one
 * process. */
enum { ENERGY_SUMS = sizeof(sd_energy) / sizeof(double) };
typedef struct energy_sums {
  exact_sum of[ENERGY_SUMS];
} energy_sums;

/* Adds x to the exact sum of this member of sd_energy. */
#define ADD(sum, member, x)                                                                        \
  exact_sum_add(&(sum)->of[offsetof(sd_energy, member) / sizeof(double)], x)

/* Adds the energies of the free disks, and the losses in contacts that have ended. Coordinates that
 * are locked or prescribed (inverse mass 0) have no energy here: the work that they do is counted
 * instead. */
static void add_disks(const engine *e, energy_sums *sum) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  for (size_t i = 0; i < s->n_free; i++) {
    double kinetic = 0.0, external = 0.0;
    if (w->inverse_mass_x[i] != 0.0) {
      kinetic += 0.5 * s->mass[i] * s->vx[i] * s->vx[i];
      external -= w->constant_x[i] * box_absolute_x(e, i);
    }
    if (w->inverse_mass_y[i] != 0.0) {
      kinetic += 0.5 * s->mass[i] * s->vy[i] * s->vy[i];
      external -= w->constant_y[i] * box_absolute_y(e, i);
    }
    if (w->inverse_inertia[i] != 0.0) {
      ADD(sum, kinetic_rotation, 0.5 * s->inertia[i] * s->omega[i] * s->omega[i]);
      external -= w->constant_torque[i] * (s->theta[i] + s->turn[i]);
    }
    ADD(sum, kinetic_translation, kinetic);
    ADD(sum, external, external);
    if (s->n_fielded) {
      ADD(sum, work, s->field_work[i]);
      ADD(sum, drag, s->loss_drag[i]);
      ADD(sum, damping, s->loss_damping[i]);
    }
    ADD(sum, viscous, s->past_viscous[i]);
    ADD(sum, friction, s->past_friction[i]);
    ADD(sum, opening, s->loss_opening[i]);
    ADD(sum, nonconservative_work, s->past_nonconservative_work[i]);
    if (s->law_columns) ADD(sum, rolling, s->past_rolling[i]);
    if (s->law_columns) ADD(sum, bridge, s->loss_bridge[i]);
  }
}

static void add_contacts(const engine *e, energy_sums *sum) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k) || !halo_counts(e, k)) continue;
    const contact_energies u = contact_energies_of(e, k);
    ADD(sum, elastic_normal, u.normal);
    ADD(sum, elastic_tangential, u.tangential);
    ADD(sum, elastic_rolling, u.rolling);
    ADD(sum, cohesion, u.cohesion);
    if (p->more) ADD(sum, rolling, MORE(p, k, rolling));
    ADD(sum, viscous, PAIR(p, k, viscous));
    ADD(sum, friction, PAIR(p, k, friction));
    ADD(sum, nonconservative_work, PAIR(p, k, nonconservative_work));
  }
}

static void add_up(const engine *e, energy_sums *sum) {
  sd_energy rigid = {0};
  memset(sum, 0, sizeof *sum);
  add_disks(e, sum);
  add_contacts(e, sum);
  clumps_add_energy(e, &rigid);
  for (size_t k = 0; k < ENERGY_SUMS; k++) exact_sum_add(&sum->of[k], ((const double *)&rigid)[k]);
}

/* Rounds the exact sums to an sd_energy, and computes its residual and the residual's scale. */
static sd_energy budget_of(const sd_state *s, const energy_sums *exact) {
  sd_energy sum = {0};
  for (size_t k = 0; k < ENERGY_SUMS; k++) ((double *)&sum)[k] = exact_sum_value(&exact->of[k]);
  sum.start = s->energy_start;
  sum.work += s->work_driven;
  sum.relaxed = s->relaxed;
  sum.residual =
      (energy_total(&sum) - sum.start) - (sum.work + sum.nonconservative_work) + energy_lost(&sum);
  /* The residual is compared with work plus losses; if these vanish, as in a conservative
   * collision, with the kinetic energy; for a system at rest, with the rounding error of the stored
   * energies. */
  double done = fabs(sum.work) + fabs(sum.viscous) + fabs(sum.friction) + fabs(sum.rolling) +
                fabs(sum.bridge) + fabs(sum.opening) + fabs(sum.drag) + fabs(sum.damping) +
                fabs(sum.relaxed);
  double rounding = 1e-9 * (sum.elastic_normal + sum.elastic_tangential + fabs(sum.external));
  sum.scale = math_max(done, math_max(sum.kinetic_translation + sum.kinetic_rotation, rounding));
  return sum;
}

sd_energy energy_of_part(const engine *e) {
  energy_sums sum;
  add_up(e, &sum);
  return budget_of(e->state, &sum);
}

sd_energy energy_of(engine *e) {
  energy_sums sum;
  if (e->halo) halo_refresh(e, NULL);
  add_up(e, &sum);
  comm_total_exact(e->comm, sum.of, ENERGY_SUMS);
  return budget_of(e->state, &sum);
}

void losses_end(engine *e, pairs *p, size_t k) {
  sd_state *s = e->state;
  double *viscous = &PAIR(p, k, viscous), *friction = &PAIR(p, k, friction),
         *beyond = &PAIR(p, k, nonconservative_work);
  if (*viscous != 0.0) losses_share(e, s->past_viscous, p->a[k], p->b[k], *viscous);
  if (*friction != 0.0) losses_share(e, s->past_friction, p->a[k], p->b[k], *friction);
  if (*beyond != 0.0) losses_share(e, s->past_nonconservative_work, p->a[k], p->b[k], *beyond);
  assert((*viscous == 0.0 && *friction == 0.0 && *beyond == 0.0) || p->a[k] != PAIR_PADDING);
  if (p->more && MORE(p, k, rolling) != 0.0)
    losses_share(e, s->past_rolling, p->a[k], p->b[k], MORE(p, k, rolling));
  losses_forget(p, k);
}

/* Number of ranges into which losses_end_all divides the list of pairs. All threads search for
 * ranges with losses; then one thread adds these losses in the order of the pairs. */
enum { PIECES = 256 };
typedef struct look_task {
  const pairs *p;
  bool any[PIECES]; /* true for each range in which at least one pair has a loss */
} look_task;

/* Returns the first block of pairs in range `piece`. */
static size_t piece_begin(const pairs *p, size_t piece) {
  return (p->count + PAIR_BLOCK - 1) / PAIR_BLOCK * piece / PIECES;
}

static bool any_loss(const pairs *p, size_t block) {
  const pair_block *b = &p->block[block];
  bool any = false;
  for (size_t k = 0; k < PAIR_BLOCK; k++)
    any |= b->viscous[k] != 0.0 || b->friction[k] != 0.0 || b->nonconservative_work[k] != 0.0;
  for (size_t k = 0; p->more && k < PAIR_BLOCK; k++) any |= p->more[block].rolling[k] != 0.0;
  return any;
}

static void look_together(const team *t, void *with) {
  look_task *l = with;
  for (size_t piece = (size_t)t->rank; piece < PIECES; piece += (size_t)t->size) {
    l->any[piece] = false;
    for (size_t b = piece_begin(l->p, piece); b < piece_begin(l->p, piece + 1) && !l->any[piece];
         b++)
      l->any[piece] = any_loss(l->p, b);
  }
}

void losses_end_all(engine *e, pairs *p) {
  look_task l = {.p = p};
  pool_run(work_pool(e), look_together, &l);
  for (size_t piece = 0; piece < PIECES; piece++)
    for (size_t b = piece_begin(p, piece); l.any[piece] && b < piece_begin(p, piece + 1); b++)
      for (size_t k = PAIR_BLOCK * b; k < PAIR_BLOCK * (b + 1) && k < p->count; k++)
        if (p->a[k] >= 0) losses_end(e, p, k);
}

/* Adds the losses of each disk's contacts in the order of the pairs, so that the bits of the sums
 * do not depend on the number of threads. */
void losses_update(engine *e) {
  sd_state *s = e->state;
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  for (size_t i = 0; i < s->n_free; i++) {
    double viscous = 0.0, friction = 0.0, beyond = 0.0;
    for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
      size_t k = n->entry[at] / 2, other = (size_t)(n->entry[at] & 1 ? p->a[k] : p->b[k]);
      double share = other < s->n_free + s->n_ghosts ? 0.5 : 1.0;
      viscous += share * PAIR(p, k, viscous);
      friction += share * PAIR(p, k, friction);
      beyond += share * PAIR(p, k, nonconservative_work);
    }
    s->loss_viscous[i] = s->past_viscous[i] + viscous;
    s->loss_friction[i] = s->past_friction[i] + friction;
    s->nonconservative_work[i] = s->past_nonconservative_work[i] + beyond;
  }
}
