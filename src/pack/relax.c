/* relax.c: FIRE at a fixed time step (see relax.h).
 *
 *   P > 0:   v <- (1 - alpha) v + alpha |v| F/|F|, and after PATIENCE such steps
 *            alpha <- max(SHRINK alpha, min(ALPHA, BRAKE/n))
 *   P <= 0:  v <- 0, alpha <- ALPHA
 *
 * with P = F . v and n the number of steps since the last stop. All free coordinates form one
 * vector v. With masses M the norms are |v|^2 = sum M v^2 and |F|^2 = sum F^2/M, and the direction
 * F/|F| of the scaled coordinates is that of the accelerations F/M. BRAKE is not in Bitzek et al.:
 * a compression at constant pressure feeds slow flows for thousands of steps, and only BRAKE damps
 * them. As it falls as 1/n, it is strong enough for these flows and does not overdamp the slow
 * modes of large packings, whose periods of some 1e4 steps are not known beforehand.
 *
 * The sums are exact, so that they depend neither on the threads nor on the ranks. */
#include "pack/relax.h"

#include <assert.h>
#include <math.h>

#include "base/math.h"
#include "model/model.h"
#include "physics/step/access.h"
#include "physics/system/clumps.h"

enum { PATIENCE = 5 };
static const double ALPHA = 0.1, SHRINK = 0.99, BRAKE = 2.0;

void relax_begin(engine *e) {
  e->state->relax_alpha = ALPHA;
  e->state->relax_steps = 0;
}

/* Returns `value`, or 0 if the inverse mass of coordinate i is 0: the coordinate is locked or
 * prescribed, or its disk is not in play. */
static inline double free_part(const columns *c, size_t i, double value) {
  return c->inverse[i] != 0.0 ? value : 0.0;
}

static void measure_clumps(const engine *e, const team *t, exact_sum *sum) {
  size_t begin, end;
  team_share(t, engine_clumps(e), &begin, &end);
  for (size_t i = begin; i < end; i++) {
    const clump_load load = clump_total(e, i);
    for (int k = 0; k < SD_COORDINATES; k++) {
      const columns *c = engine_clump_columns(e, k);
      if (c->inverse[i] == 0.0) continue;
      exact_sum_add(&sum[RELAX_POWER], load.on[k] * c->v[i]);
      exact_sum_add(&sum[RELAX_SPEED2], c->v[i] * c->v[i] / c->inverse[i]);
      exact_sum_add(&sum[RELAX_PUSH2], load.on[k] * load.on[k] * c->inverse[i]);
    }
  }
}

/* Adds the terms of this thread's disks and clumps to the sums. The three coordinates of a disk are
 * added in floating point first, since an exact addition costs more. */
static void measure(const engine *e, const team *t, exact_sum *sum) {
  const columns *x = engine_columns(e, SD_X), *y = engine_columns(e, SD_Y),
                *a = engine_columns(e, SD_THETA);
  const double *mass = e->state->mass, *inertia = e->state->inertia;
  size_t begin, end;
  team_share(t, e->state->n_free, &begin, &end);
  for (size_t i = begin; i < end; i++) {
    const double fx = free_part(x, i, x->force[i] + x->constant[i]), vx = free_part(x, i, x->v[i]),
                 fy = free_part(y, i, y->force[i] + y->constant[i]), vy = free_part(y, i, y->v[i]),
                 fa = free_part(a, i, a->force[i] + a->constant[i]), va = free_part(a, i, a->v[i]);
    exact_sum_add(&sum[RELAX_POWER], fx * vx + fy * vy + fa * va);
    exact_sum_add(&sum[RELAX_SPEED2], mass[i] * vx * vx + mass[i] * vy * vy + inertia[i] * va * va);
    exact_sum_add(&sum[RELAX_PUSH2],
                  fx * fx * x->inverse[i] + fy * fy * y->inverse[i] + fa * fa * a->inverse[i]);
  }
  measure_clumps(e, t, sum);
}

/* Changes the velocities of this thread's clumps: v <- keep v + steer F/M. */
static void change_clumps(engine *e, const team *t, double keep, double steer) {
  size_t begin, end;
  team_share(t, engine_clumps(e), &begin, &end);
  for (size_t i = begin; i < end; i++) {
    const clump_load load = clump_total(e, i);
    for (int k = 0; k < SD_COORDINATES; k++) {
      const columns *c = engine_clump_columns(e, k);
      if (c->inverse[i] != 0.0) c->v[i] = keep * c->v[i] + steer * (load.on[k] * c->inverse[i]);
      if (c->inverse[i] != 0.0 && keep == 0.0 && e->model->integrator == SD_GEAR5)
        c->q3[i] = c->q4[i] = c->q5[i] = 0.0;
    }
  }
}

static void change(engine *e, const team *t, double keep, double steer) {
  size_t begin, end;
  team_share(t, e->state->n_free, &begin, &end);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = engine_columns(e, k);
    for (size_t i = begin; i < end; i++) {
      double v = keep * c->v[i] + steer * ((c->force[i] + c->constant[i]) * c->inverse[i]);
      c->v[i] = c->inverse[i] != 0.0 ? v : c->v[i];
    }
  }
}

/* Sets the higher derivatives of Gear's predictor to 0, as they describe the motion that was
 * stopped. */
static void forget_derivatives(engine *e, const team *t) {
  size_t begin, end;
  if (e->model->integrator != SD_GEAR5) return;
  team_share(t, e->state->n_free, &begin, &end);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = engine_columns(e, k);
    for (size_t i = begin; i < end; i++)
      if (c->inverse[i] != 0.0) c->q3[i] = c->q4[i] = c->q5[i] = 0.0;
  }
}

/* Adds up the sums of all threads and ranks; called by the first thread. */
static void add_up(const engine *e, const team *t, relax_sums *of_team) {
  for (int n = 1; n < t->size; n++)
    for (int k = 0; k < RELAX_SUMS; k++) exact_sum_merge(&of_team->of[k], &of_team[n].of[k]);
  comm_total_exact(e->comm, of_team->of, RELAX_SUMS);
  for (int k = 0; k < RELAX_SUMS; k++) of_team->total[k] = exact_sum_value(&of_team->of[k]);
}

void relax_step(engine *e, const team *t, relax_sums *of_team) {
  sd_state *s = e->state;
  of_team[t->rank] = (relax_sums){0};
  measure(e, t, of_team[t->rank].of);
  team_wait(t);
  if (t->rank == 0) add_up(e, t, of_team);
  team_wait(t);
  const double power = of_team->total[RELAX_POWER], speed2 = of_team->total[RELAX_SPEED2],
               push2 = of_team->total[RELAX_PUSH2];
  const bool downhill = power > 0.0;
  const double keep = downhill ? 1.0 - s->relax_alpha : 0.0;
  const double steer = downhill ? s->relax_alpha * sqrt(speed2 / push2) : 0.0;
  change(e, t, keep, steer);
  change_clumps(e, t, keep, steer);
  if (!downhill) forget_derivatives(e, t);
  team_wait(t);
  if (t->rank > 0) return;
  clumps_place_all(e);
  assert(!(speed2 < 0.0) && !(push2 < 0.0) && s->relax_alpha >= 0.0 && s->relax_alpha <= ALPHA);
  /* Kinetic energy removed: sum M v^2/2 before minus after, computed from the sums. */
  s->relaxed +=
      0.5 * (speed2 - (keep * keep * speed2 + 2.0 * keep * steer * power + steer * steer * push2));
  if (!downhill)
    relax_begin(e);
  else if (++s->relax_steps > PATIENCE)
    s->relax_alpha =
        math_max(SHRINK * s->relax_alpha, math_min(ALPHA, BRAKE / (double)s->relax_steps));
}
