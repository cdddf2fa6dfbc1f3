/* relax.c: FIRE at a fixed time step; see relax.h.
 *
 *   P > 0:   v <- (1 - alpha) v + alpha |v| F/|F|,  after PATIENCE such steps alpha <- max(SHRINK alpha, LEAST)
 *   P <= 0:  v <- 0,  alpha <- ALPHA                 with P = F . v
 *
 * over all free coordinates at once. With masses M the norms are |v|^2 = sum M v^2 and |F|^2 = sum F^2/M, and the
 * direction F/|F| of the scaled coordinates is that of the accelerations F/M. LEAST is not in the paper: a
 * compression that holds a pressure feeds slow flows for thousands of steps, in which P stays positive, and
 * without it nothing would brake them.
 */
#include "pack/relax.h"

#include <math.h>

#include "physics/engine.h"

enum { PATIENCE = 5 };
static const double ALPHA = 0.1, SHRINK = 0.99, LEAST = 0.01;

void relax_begin(engine *e) {
  e->state->relax_alpha = ALPHA;
  e->state->relax_steps = 0;
}

/* Has this coordinate of this disk an equilibrium to find? */
static bool moves(const engine *e, const columns *c, size_t i) {
  return c->inverse[i] != 0.0 && engine_in_play(e->state, i);
}

static const double *inertia_of(const sd_state *s, int coordinate) {
  return coordinate == SD_THETA ? s->inertia : s->mass;
}

/* v <- keep v + steer F/M; what the kinetic energy loses by it. */
static double change(engine *e, double keep, double steer) {
  double taken = 0.0;
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = &e->work.columns[k];
    const double *mass = inertia_of(e->state, k);
    for (size_t i = 0; i < e->state->n_free; i++) {
      if (!moves(e, c, i)) continue;
      double before = c->v[i];
      c->v[i] = keep * before + steer * ((c->force[i] + c->constant[i]) * c->inverse[i]);
      taken += 0.5 * mass[i] * (before - c->v[i]) * (before + c->v[i]);
    }
  }
  return taken;
}

/* The higher derivatives of Gear's predictor belong to the motion that was stopped. */
static void forget_derivatives(engine *e) {
  if (e->model->integrator != SD_GEAR5) return;
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = &e->work.columns[k];
    for (size_t i = 0; i < e->state->n_free; i++)
      if (moves(e, c, i)) c->q3[i] = c->q4[i] = c->q5[i] = 0.0;
  }
}

void relax_step(engine *e) {
  sd_state *s = e->state;
  double power = 0.0, speed2 = 0.0, push2 = 0.0;
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = &e->work.columns[k];
    const double *mass = inertia_of(s, k);
    for (size_t i = 0; i < s->n_free; i++) {
      if (!moves(e, c, i)) continue;
      double force = c->force[i] + c->constant[i];
      power += force * c->v[i];
      speed2 += mass[i] * c->v[i] * c->v[i];
      push2 += force * force * c->inverse[i];
    }
  }
  if (power > 0.0) {
    s->relaxed += change(e, 1.0 - s->relax_alpha, s->relax_alpha * sqrt(speed2 / push2));
    if (++s->relax_steps > PATIENCE) s->relax_alpha = fmax(SHRINK * s->relax_alpha, LEAST);
    return;
  }
  s->relaxed += change(e, 0.0, 0.0);
  forget_derivatives(e);
  relax_begin(e);
}
