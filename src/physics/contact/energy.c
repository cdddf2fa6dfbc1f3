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

/* Returns the energies of a free disk, and the losses in contacts that have ended. Coordinates that
 * are locked or prescribed (inverse mass 0) have no energy here: the work that they do is counted
 * instead. */
static sd_energy of_disk(const engine *e, size_t i) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  sd_energy u = {.viscous = s->past_viscous[i],
                 .friction = s->past_friction[i],
                 .opening = s->loss_opening[i],
                 .nonconservative_work = s->past_nonconservative_work[i]};
  if (w->inverse_mass_x[i] != 0.0) {
    u.kinetic_translation += 0.5 * s->mass[i] * s->vx[i] * s->vx[i];
    u.external -= w->constant_x[i] * box_absolute_x(e, i);
  }
  if (w->inverse_mass_y[i] != 0.0) {
    u.kinetic_translation += 0.5 * s->mass[i] * s->vy[i] * s->vy[i];
    u.external -= w->constant_y[i] * box_absolute_y(e, i);
  }
  if (w->inverse_inertia[i] != 0.0) {
    u.kinetic_rotation = 0.5 * s->inertia[i] * s->omega[i] * s->omega[i];
    u.external -= w->constant_torque[i] * (s->theta[i] + s->turn[i]);
  }
  if (s->n_fielded) {
    u.work = s->field_work[i];
    u.drag = s->loss_drag[i];
    u.damping = s->loss_damping[i];
  }
  if (s->law_columns) {
    u.rolling = s->past_rolling[i];
    u.bridge = s->loss_bridge[i];
    u.broken_tension = s->broken_tension[i];
    u.broken_shear = s->broken_shear[i];
    u.broken_bending = s->broken_bending[i];
  }
  return u;
}

static sd_energy of_contact(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  const contact_energies u = contact_energies_of(e, k);
  return (sd_energy){.elastic_normal = u.normal,
                     .elastic_tangential = u.tangential,
                     .elastic_rolling = u.rolling,
                     .elastic_bond = u.bond,
                     .cohesion = u.cohesion,
                     .rolling = p->more ? MORE(p, k, rolling) : 0.0,
                     .viscous = PAIR(p, k, viscous),
                     .friction = PAIR(p, k, friction),
                     .nonconservative_work = PAIR(p, k, nonconservative_work)};
}

/* Calls add() for each free disk, each closed contact that this rank counts, and the clumps. */
static void visit(const engine *e, void (*add)(exact_sum *sum, const sd_energy *u),
                  exact_sum *sum) {
  const pairs *p = &e->work.pairs;
  for (size_t i = 0; i < e->state->n_free; i++) {
    const sd_energy u = of_disk(e, i);
    add(sum, &u);
  }
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k) || !halo_counts(e, k)) continue;
    const sd_energy u = of_contact(e, k);
    add(sum, &u);
  }
  sd_energy rigid = {0};
  clumps_add_energy(e, &rigid);
  add(sum, &rigid);
}

static void add_members(exact_sum *sum, const sd_energy *u) {
  const double *member = (const double *)u;
  for (size_t k = 0; k < ENERGY_SUMS; k++)
    if (member[k] != 0.0) exact_sum_add(&sum[k], member[k]);
}

/* Returns what the members of a budget leave unaccounted for. */
static double residual_of(const sd_energy *u) {
  return (energy_total(u) - u->start) - (u->work + u->nonconservative_work) + energy_lost(u);
}

static void add_residual(exact_sum *sum, const sd_energy *u) { exact_sum_add(sum, residual_of(u)); }

static void add_up(const engine *e, energy_sums *sum) {
  memset(sum, 0, sizeof *sum);
  visit(e, add_members, sum->of);
}

/* Rounds the exact sums to an sd_energy, and computes its residual and the residual's scale. */
static sd_energy budget_of(const sd_state *s, const energy_sums *exact) {
  sd_energy sum = {0};
  for (size_t k = 0; k < ENERGY_SUMS; k++) ((double *)&sum)[k] = exact_sum_value(&exact->of[k]);
  sum.start = s->energy_start;
  sum.work += s->work_driven;
  sum.relaxed = s->relaxed;
  sum.residual = residual_of(&sum);
  /* The residual is compared with work plus losses; if these vanish, as in a conservative
   * collision, with the kinetic energy; for a system at rest, with the rounding error of the stored
   * energies. */
  double done = fabs(sum.work) + fabs(sum.viscous) + fabs(sum.friction) + fabs(sum.rolling) +
                fabs(sum.bridge) + fabs(sum.opening) + fabs(sum.broken_tension) +
                fabs(sum.broken_shear) + fabs(sum.broken_bending) + fabs(sum.drag) +
                fabs(sum.damping) + fabs(sum.relaxed);
  double rounding =
      1e-9 * (sum.elastic_normal + sum.elastic_tangential + sum.elastic_bond + fabs(sum.external));
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

double energy_residual(engine *e) {
  exact_sum sum = {0};
  if (e->halo) halo_refresh(e, NULL);
  visit(e, add_residual, &sum);
  comm_total_exact(e->comm, &sum, 1);
  const sd_energy run = {
      .start = e->state->energy_start, .work = e->state->work_driven, .relaxed = e->state->relaxed};
  add_residual(&sum, &run);
  return exact_sum_value(&sum);
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
