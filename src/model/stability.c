/* stability.c: stability limit of the time step.
 *
 * A disk between two supports is an oscillator x'' = -w^2 x - c x' with w^2 = 2 k/m and c = 2
 * gamma_n/m along the normal, and w^2 = 2 k_t (1/m + R^2/I), c = 2 gamma_t (1/m + R^2/I) along
 * the tangent; rolling resistance at both supports adds 2 k_r R^2/I to this w^2 and
 * 2 (gamma_r + drag_r) R^2/I to this c. Bonds add their stiffnesses and viscosities. A stiffness
 * that depends on the overlap is taken at 0.01 R, one that depends on R_eff at R, which is that of
 * a straight wall; a beam at the length 2 R. Both integrators use the velocity predicted from the
 * old acceleration. An eigenvalue of their step passes -1, and the motion blows up within a few
 * steps, beyond
 *
 *   a (w dt)^2 + b c dt = 1        Verlet: a = 1/4,   b = 1
 *                                  Gear:   a = 47/30, b = 551/90
 *
 * (tests/physics/test_stability.c). In a packing, where a disk has up to six contacts, the limit
 * is up to three times shorter. */
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/clumps.h"
#include "model/field_kinds.h"
#include "model/laws.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/rows.h"

/* Coefficients a (STIFF) and b (VISCOUS) of the stability condition a (w dt)^2 + b c dt <= 1. */
static const double STIFF[] = {[SD_GEAR5] = 47.0 / 30, [SD_VERLET] = 0.25};
static const double VISCOUS[] = {[SD_GEAR5] = 551.0 / 90, [SD_VERLET] = 1};

/* Normal and tangential oscillation of a disk between two bodies of one material. */
typedef struct oscillator {
  double normal2, tangential2; /* squared angular frequencies w^2, 1/time^2 */
  double damping, friction;    /* damping rates c of the two oscillations, 1/time */
} oscillator;

/* Returns frequencies and damping rates of a disk between two bodies (docs/physics.md 5). tsuji:
 * coefficient of the damping by restitution, from law_tsuji; moved: bits 1 << coordinate for
 * each coordinate that motions prescribe. */
static oscillator oscillator_of(const sd_disk *d, const sd_contact_law *law, double tsuji,
                                unsigned moved) {
  bool still = (d->locked[SD_X] || moved & 1u << SD_X) && (d->locked[SD_Y] || moved & 1u << SD_Y);
  bool turns = !d->locked[SD_THETA] && !(moved & 1u << SD_THETA);
  const sd_contact_law flat = law_at(law, d->radius);
  double inverse_mass = still ? 0.0 : 1.0 / d->mass;
  double inverse_inertia = turns ? d->radius * d->radius / d->inertia : 0.0;
  double gamma = law->gamma_n, rubs = law->mu > 0.0 ? 2.0 * (inverse_mass + inverse_inertia) : 0.0;
  double k_t =
      law->tangential == SD_TANGENTIAL_MINDLIN ? flat.k_t * sqrt(0.01 * d->radius) : flat.k_t;
  if (tsuji > 0.0)
    gamma += normal_laws[law->normal].viscosity(tsuji * sqrt(d->mass * flat.k_n), 0.01 * d->radius);
  /* bonds act beside the contact; with a disk of the same size R_eff is R/2 */
  const sd_contact_law bond = bond_law_at(law, d->radius, d->radius, 0.5 * d->radius);
  const double shears = 2.0 * (inverse_mass + inverse_inertia), bends = 0.5 * inverse_inertia;
  return (oscillator){
      .normal2 = 2.0 * (law_typical_stiffness(law, d->radius) + bond.bond_k_n) * inverse_mass,
      .tangential2 = k_t * rubs + 2.0 * law->k_r * inverse_inertia + bond.bond_k_t * shears +
                     bond.bond_k_r * bends,
      .damping = 2.0 * (gamma + law->bond_gamma_n) * inverse_mass,
      .friction = law->gamma_t * rubs + 2.0 * (law->gamma_r + law->drag_r) * inverse_inertia +
                  law->bond_gamma_t * shears + law->bond_gamma_r * bends};
}

bool law_is_as_stiff(const sd_contact_law *a, const sd_contact_law *b) {
  const sd_disk unit = {.radius = 1.0, .mass = 1.0, .inertia = 1.0};
  const oscillator p = oscillator_of(&unit, a, law_tsuji(a), 0),
                   q = oscillator_of(&unit, b, law_tsuji(b), 0);
  return p.normal2 == q.normal2 && p.tangential2 == q.tangential2 && p.damping == q.damping &&
         p.friction == q.friction;
}

/* Returns the disk in this row; if it belongs to a clump, with the smallest effective mass and
 * inertia that a contact sees (clump_effective_disk). */
static sd_disk felt_at(const sd_model *m, size_t row) {
  return row < model_held(m) ? clump_effective_disk(m, row) : *rows_disk(m, row);
}

double sd_model_shortest_period(const sd_model *m, uint32_t *disk) {
  double fastest = 0.0;
  uint32_t first = 0;
  for (size_t row = 0; row < rows_count(m); row++)
    for (size_t b = 0; b < m->n_materials && !rows_disk(m, row)->driven; b++) {
      const sd_contact_law *law = sd_model_law(m, rows_disk(m, row)->material, (int)b);
      if (!law_is_given(law)) continue;
      const sd_disk felt = felt_at(m, row);
      const oscillator o = oscillator_of(&felt, law, 0.0, 0);
      double w2 = math_max(o.normal2, o.tangential2);
      const uint32_t number = rows_number(m, row);
      if (!(w2 > fastest) && !(w2 == fastest && number < first)) continue;
      fastest = w2;
      first = number;
    }
  fastest = rows_extreme(m, fastest, &first);
  if (disk && fastest > 0.0) *disk = first;
  return fastest > 0.0 ? 2.0 * M_PI / sqrt(fastest) : HUGE_VAL;
}

/* Returns the longest stable time step t of an oscillation with squared frequency w2 and damping
 * rate c: the positive root of a w2 t^2 + b c t = 1. HUGE_VAL: no limit. */
static double longest(const sd_model *m, double w2, double c) {
  double a = STIFF[m->integrator] * w2, b = VISCOUS[m->integrator] * c,
         s = b + sqrt(b * b + 4.0 * a);
  return s > 0.0 ? 2.0 / s : HUGE_VAL;
}

/* Returns the limit of the time step that the oscillations of one disk set. */
static sd_step_limit limit_of(const sd_model *m, const oscillator *o, uint32_t disk) {
  /* viscous: value of the term b c dt at the limit, where a (w dt)^2 + b c dt is 1 */
  const double normal = longest(m, o->normal2, o->damping),
               tangential = longest(m, o->tangential2, o->friction),
               viscous = VISCOUS[m->integrator] * o->damping * normal;
  return (sd_step_limit){.dt = math_min(normal, tangential),
                         .disk = disk,
                         .bound = tangential < normal ? SD_BOUND_TANGENTIAL
                                  : viscous > 0.5     ? SD_BOUND_VISCOSITY
                                                      : SD_BOUND_NORMAL};
}

/* True if limit a is shorter than limit b, or equal and set by a disk with a lower number. */
static bool is_shorter(const sd_step_limit *a, const sd_step_limit *b) {
  return a->dt < b->dt || (a->dt == b->dt && isfinite(a->dt) && a->disk < b->disk);
}

/* Collective. Returns the limit of the time step that contacts set for the disks of this rank. */
static sd_step_limit limit_here(const sd_model *m) {
  sd_step_limit limit = {.dt = HUGE_VAL};
  size_t laws = m->n_materials * m->n_materials;
  double *tsuji = memory_new(laws, sizeof *tsuji);
  law_use *use = memory_new(m->n_materials, sizeof *use);
  unsigned char *moved = model_moved(m);
  if (!moved) shortage_note();
  laws_count_uses(m, use);
  for (size_t k = 0; k < laws; k++) tsuji[k] = law_tsuji(&m->laws[k]);
  for (size_t row = 0; row < rows_count(m); row++)
    for (size_t b = 0; b < m->n_materials && !rows_disk(m, row)->driven; b++) {
      const size_t own = (size_t)rows_disk(m, row)->material;
      const sd_contact_law *law = sd_model_law(m, (int)own, (int)b);
      if (!law_is_given(law) || use[b].count == (own == b)) continue;
      const sd_disk felt = felt_at(m, row);
      const oscillator o = oscillator_of(&felt, law, tsuji[law - m->laws],
                                         moved && row < model_held(m) ? moved[row] : 0);
      const sd_step_limit now = limit_of(m, &o, rows_number(m, row));
      if (is_shorter(&now, &limit)) limit = now;
    }
  free(moved);
  free(use);
  free(tsuji);
  return limit;
}

sd_step_limit sd_model_step_limit(const sd_model *m) {
  if (m->parted) return m->limit;
  const size_t ranks = (size_t)comm_size(m->comm);
  sd_step_limit limit = limit_here(m), *all = memory_new(ranks, sizeof *all);
  body_forces_limit(m, &limit);
  comm_gather_one(m->comm, &limit, all, sizeof limit);
  for (size_t q = 0; q < ranks; q++)
    if (is_shorter(&all[q], &limit)) limit = all[q];
  free(all);
  return limit;
}
