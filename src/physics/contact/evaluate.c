/* evaluate.c: see evaluate.h. */
#include "physics/system/halo.h"
#include "physics/contact/evaluate.h"

#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/contact/contact_step.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/segment_pass.h"

/* Of a round pair, as the pass sees it. */
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

/* lever: at which the tangential force acts. */
static pair_geometry_w1 present(const engine *e, size_t k, double *lever) {
  assert(k < e->work.pairs.count && e->work.pairs.a[k] != PAIR_PADDING);
  pair_input_w1 in;
  nearest_points_w1 found;
  if (pairs_is_segment(&e->work.pairs, k)) {
    nearest_of_w1(e, k, &in, &found);
  } else {
    in = round_input(e, k);
  }
  const pair_geometry_w1 g = pair_geometry_of_w1(&in);
  const bool piece = pairs_is_segment(&e->work.pairs, k);
  *lever = piece && found.flat[0] > 0.0 ? found.flat[0] : piece || e->work.conservative ? g.lever : 1.0;
  return g;
}

contact_geometry contact_geometry_of(const engine *e, size_t k) {
  double lever;
  const pair_geometry_w1 g = present(e, k, &lever);
  return (contact_geometry){g.nx, g.ny, g.reach, g.lambda, g.turned};
}

/* Of general laws; delta, lambda, rho: at the corrected coordinates, where those of the forces are others (Gear). */
static void energies_of_general(const engine *e, size_t k, double delta, double lambda, double rho,
                                contact_energies *u) {
  const pairs *p = &e->work.pairs;
  const law_row *l = &e->work.laws[PAIR(p, k, law)];
  const cohesion_w1 c = {.bridge = l->bridge > 0.0,
                         .pull_off = l->pull_off,
                         .range = l->range,
                         .per_range = l->per_range,
                         .broken = l->broken};
  u->cohesion = cohesion_energy_w1(&c, delta);
  u->rolling = 0.5 * l->k_r * rho * rho;
  if (l->mindlin == 0.0) return;
  /* y at the forces' coordinates, and the way from there */
  const double was = sqrt(l->k_t * sqrt(fmax(PAIR(p, k, overlap), 0.0))),
               now = sqrt(l->k_t * sqrt(fmax(delta, 0.0)));
  const double y =
      was * PAIR(p, k, zeta) + 0.5 * (was + now) * (lambda - PAIR(p, k, lambda_ref) - PAIR(p, k, zeta));
  u->tangential = 0.5 * y * y;
}

/* Rolling displacement, as the passes have it. */
static double rho_now(const sd_state *s, size_t a, size_t b) {
  const double ra = s->radius[a], rb = s->radius[b], arc = ra * s->theta[a];
  return rb == 0.0 ? ra * (s->theta[a] - s->theta[b]) : (rb * arc - ra * body_arc(s, b)) / (ra + rb);
}

contact_energies contact_energies_of(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  const sd_state *s = e->state;
  const sd_contact_law *law = &e->model->laws[PAIR(p, k, law)];
  double delta = PAIR(p, k, overlap), zeta = PAIR(p, k, zeta), rho = p->more ? MORE(p, k, rho) : 0.0;
  if (e->model->integrator ==
      SD_GEAR5) { /* forces acted at the predicted coordinates, energy is stored at the corrected ones */
    const contact_geometry g = contact_geometry_of(e, k);
    delta = g.overlap;
    zeta = g.lambda - PAIR(p, k, lambda_ref);
    if (p->more) rho = rho_now(s, (size_t)p->a[k], (size_t)p->b[k]) - MORE(p, k, rho_ref);
  }
  contact_energies u = {.normal = law_energy(law, fmax(delta, 0.0)),
                        .tangential = 0.5 * law->k_t * zeta * zeta};
  if (p->more) energies_of_general(e, k, delta, zeta + PAIR(p, k, lambda_ref), rho, &u);
  return u;
}

contact_reaction contact_reaction_of(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double lever;
  const pair_geometry_w1 g = present(e, k, &lever);
  const contact_constants_w1 law = {.k_t = e->work.laws[PAIR(p, k, law)].k_t};
  const contact_memory_w1 m = {
      .zeta = PAIR(p, k, zeta), .force = PAIR(p, k, force), .tau = p->more ? MORE(p, k, tau) : 0.0};
  const double couple = p->more ? MORE(p, k, roll) * law_arm(s->radius[p->a[k]], s->radius[p->b[k]]) : 0.0;
  contact_output_w1 out;
  contact_force_w1(&g, &law, lever, e->work.features, &m, &out);
  const int32_t a = p->a[k], b = p->b[k];
  const double rx = s->x[a] - s->x[b], ry = s->y[a] - s->y[b];
  return (contact_reaction){.fx = out.fx,
                            .fy = out.fy,
                            .torque_a = out.tau * s->radius[a] + couple,
                            .torque_b =
                                (pairs_is_segment(p, k) ? rx * out.fy - ry * out.fx - out.tau * s->radius[a]
                                                        : out.tau * s->radius[b]) -
                                couple};
}

void contact_evaluate_again(engine *e, size_t k) {
  assert(pairs_is_segment(&e->work.pairs, k) && k < e->work.pairs.count);
  evaluate_segments_w1(e, &e->work.threads[0], k, 0);
}
