/* evaluate.c: geometry, force and energy of single contacts; implements evaluate.h. */
#include "physics/contact/evaluate.h"

#include "model/model.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"
#include "physics/system/halo.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "base/math.h"
#include "physics/contact/contact_step.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/segment_pass.h"

/* Collects the input of the geometry of a pair of round bodies from the state. (In steps
 * pair_pass.h takes it from packed bodies.) */
static pair_input_w1 round_input(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const int32_t a = w->pairs.a[k], b = w->pairs.b[k];
  pair_input_w1 in = {.dx = s->x[b] - s->x[a],
                      .dy = s->y[b] - s->y[a],
                      .dvx = s->vx[b] - s->vx[a],
                      .dvy = s->vy[b] - s->vy[a],
                      .sum = s->radius[b] + s->radius[a],
                      .arc = body_arc(s, (size_t)b) + s->radius[a] * s->theta[a],
                      .ex = PAIR(&w->pairs, k, ex),
                      .ey = PAIR(&w->pairs, k, ey)};
  const box_image n = box_nearest(w, &in.dx, &in.dy);
  in.dvx -= w->cell.speed[0] * n.x + w->cell.speed[2] * n.y;
  in.dvy -= w->cell.speed[1] * n.y;
  return in;
}

/* Returns the geometry of pair k at the present coordinates, and the input of this geometry in *in.
 * For a wall segment the nearest point is stored in *found, too. */
static pair_geometry_w1 present(const engine *e, size_t k, nearest_points_w1 *found,
                                pair_input_w1 *in) {
  assert(k < e->work.pairs.count && e->work.pairs.a[k] != PAIR_PADDING);
  if (pairs_is_segment(&e->work.pairs, k))
    nearest_of_w1(e, k, in, found);
  else
    *in = round_input(e, k);
  return pair_geometry_of_w1(in);
}

contact_geometry contact_geometry_of(const engine *e, size_t k) {
  nearest_points_w1 found;
  pair_input_w1 in;
  const pair_geometry_w1 g = present(e, k, &found, &in);
  return (contact_geometry){g.nx, g.ny, g.reach, g.lambda, g.turned};
}

/* Returns the elastic energy of the bond of pair k. rho: rolling displacement R_eff (theta_a -
 * theta_b). */
static double bond_energy_of(const engine *e, size_t k, double delta, double lambda, double rho) {
  const pairs *p = &e->work.pairs;
  const double ra = e->state->radius[p->a[k]], rb = e->state->radius[p->b[k]];
  const double arm = walls_arm(ra, pairs_is_segment(p, k) ? joints_radius(e, k) : rb);
  const bool wall = (size_t)p->b[k] >= e->state->n_disks;
  const sd_contact_law l = bond_law_at(&e->model->laws[PAIR(p, k, law)], ra, wall ? 0.0 : rb, arm);
  const double normal = MORE(p, k, bond_overlap) - delta, shear = lambda - MORE(p, k, bond_lambda),
               bend = rho - MORE(p, k, bond_rho);
  return 0.5 *
         (l.bond_k_n * normal * normal + l.bond_k_t * shear * shear + l.bond_k_r * bend * bend);
}

/* Sets the energies in *u that only general laws have: cohesion, rolling, and the tangential
 * energy with Mindlin's law of stiffness k_t. delta, lambda, rho: values at the corrected
 * coordinates; with Gear's integrator forces were evaluated at other coordinates, the predicted
 * ones. */
static void energies_of_general(const engine *e, size_t k, double k_t, double delta, double lambda,
                                double rho, contact_energies *u) {
  const pairs *p = &e->work.pairs;
  const law_row *l = &e->work.laws[PAIR(p, k, law)];
  const cohesion_w1 c = {.bridge = l->bridge > 0.0,
                         .pull_off = l->pull_off,
                         .range = l->range,
                         .per_range = l->per_range,
                         .broken = l->broken};
  u->cohesion = cohesion_energy_w1(&c, delta);
  u->rolling = 0.5 * l->k_r * rho * rho;
  if (MORE(p, k, bond) > 0.0)
    u->bond = bond_energy_of(e, k, delta, lambda, rho + MORE(p, k, rho_ref));
  if (l->mindlin == 0.0) return;
  /* y = sqrt(K) zeta, where the tangential energy is y^2/2 (law_tangential.h): the value when
   * forces were evaluated, plus its change since then */
  const double was = sqrt(k_t * sqrt(math_max(PAIR(p, k, overlap), 0.0))),
               now = sqrt(k_t * sqrt(math_max(delta, 0.0)));
  const double y = was * PAIR(p, k, zeta) +
                   0.5 * (was + now) * (lambda - PAIR(p, k, lambda_ref) - PAIR(p, k, zeta));
  u->tangential = 0.5 * y * y;
}

double contact_rho_of(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const size_t a = (size_t)p->a[k], b = (size_t)p->b[k];
  if (pairs_is_segment(p, k))
    return walls_arm(s->radius[a], joints_radius(e, k)) * (s->theta[a] - s->theta[b]);
  const double ra = s->radius[a], rb = s->radius[b], arc = ra * s->theta[a];
  return (rb * arc - ra * body_arc(s, b)) / (ra + rb);
}

contact_energies contact_energies_of(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  const sd_contact_law law = contact_law_of(e, k);
  double delta = PAIR(p, k, overlap), zeta = PAIR(p, k, zeta),
         rho = p->more ? MORE(p, k, rho) : 0.0;
  /* The record has, with Gear's integrator, values at the predicted coordinates, but the energy is
   * that at the corrected ones. */
  if (e->model->integrator == SD_GEAR5) {
    const contact_geometry g = contact_geometry_of(e, k);
    delta = g.overlap;
    zeta = g.lambda - PAIR(p, k, lambda_ref);
    if (p->more) rho = contact_rho_of(e, k) - MORE(p, k, rho_ref);
  }
  contact_energies u = {.normal = law_energy(&law, math_max(delta, 0.0)),
                        .tangential = 0.5 * law.k_t * zeta * zeta};
  if (p->more) energies_of_general(e, k, law.k_t, delta, zeta + PAIR(p, k, lambda_ref), rho, &u);
  return u;
}

/* Returns the lever of the tangential force: 1 between the ends of a straight wall segment and, for
 * two round bodies, in the paper's variant (docs/physics.md, section 3); else (R_a + R_b)/r. */
static double lever_at(const contact_place *at, const pair_geometry_w1 *g) {
  if (!at->piece) return at->conservative ? g->lever : 1.0;
  return at->nearest.flat ? walls_lever(at->piece, &at->nearest, at->ra) : g->lever;
}

contact_reaction contact_reaction_at(const contact_place *at, double force, double tau,
                                     double roll) {
  const pair_input_w1 in = {.dx = at->dx, .dy = at->dy, .sum = at->rb + at->ra};
  const pair_geometry_w1 g = pair_geometry_of_w1(&in);
  const contact_memory_w1 m = {.force = force, .tau = tau};
  const contact_constants_w1 unused = {.k_t = 0.0};
  contact_output_w1 out;
  contact_force_w1(&g, &unused, lever_at(at, &g), LAW_GENERAL, &m, &out);
  const double rb = at->piece ? walls_radius(at->piece, at->nearest.side) : at->rb;
  const double couple = roll == 0.0 ? 0.0 : roll * walls_arm(at->ra, rb);
  const double turn =
      at->piece ? at->arm_x * out.fy - at->arm_y * out.fx - tau * at->ra : tau * at->rb;
  return (contact_reaction){.nx = g.nx,
                            .ny = g.ny,
                            .fx = out.fx,
                            .fy = out.fy,
                            .torque_a = tau * at->ra + couple,
                            .torque_b = turn - couple,
                            .couple = couple};
}

/* Returns the tangential force tau of contact k, from its record. */
static double tau_of(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  return p->more ? MORE(p, k, tau) : -(e->work.laws[PAIR(p, k, law)].k_t * PAIR(p, k, zeta));
}

/* Returns the force and torques of contact k. If k is with a wall segment, the nearest point is
 * stored in *found. */
static contact_reaction reaction_of(const engine *e, size_t k, nearest_points_w1 *found) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const int32_t a = p->a[k], b = p->b[k];
  pair_input_w1 in;
  present(e, k, found, &in);
  contact_place at = {.dx = in.dx,
                      .dy = in.dy,
                      .ra = s->radius[a],
                      .rb = s->radius[b],
                      .conservative = e->work.conservative};
  if (pairs_is_segment(p, k)) {
    at.piece = &e->work.segments[p->part[k]];
    at.nearest = found->q[0];
    at.arm_x = s->x[a] - (s->x[b] + found->shift_x[0]);
    at.arm_y = s->y[a] - (s->y[b] + found->shift_y[0]);
  }
  return contact_reaction_at(&at, PAIR(p, k, force), tau_of(e, k),
                             p->more ? MORE(p, k, roll) : 0.0);
}

contact_reaction contact_reaction_of(const engine *e, size_t k) {
  nearest_points_w1 found;
  return reaction_of(e, k, &found);
}

void contact_sum(engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  nearest_points_w1 found;
  const contact_reaction r = reaction_of(e, k, &found);
  const contact_output_w1 out = {.fx = r.fx, .fy = r.fy, .tau = tau_of(e, k), .couple = r.couple};
  const location_w1 at = {p->block + k / PAIR_BLOCK, k % PAIR_BLOCK};
  if (pairs_is_segment(p, k)) {
    scatter_segments_w1(e, k, &found, &out);
    return;
  }
  scatter_w1(e->work.sums.row, at, &out);
  if (e->work.features & LAW_ROLLING) scatter_couple_w1(e, at, &out);
}
