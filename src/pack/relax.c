/* relax.c: FIRE at a fixed time step; see relax.h.
 *
 *   P > 0:   v <- (1 - alpha) v + alpha |v| F/|F|,   after PATIENCE such steps alpha <- max(SHRINK alpha, BRAKE/n)
 *   P <= 0:  v <- 0,  alpha <- ALPHA                 with P = F . v, n the steps since the last stop
 *
 * over all free coordinates at once. With masses M the norms are |v|^2 = sum M v^2 and |F|^2 = sum F^2/M, and the
 * direction F/|F| of the scaled coordinates is that of the accelerations F/M. BRAKE is not in the paper: without
 * it nothing would brake the slow flows that a compression at constant pressure feeds for thousands of steps. A
 * brake that falls as 1/n is strong enough for these and does not overdamp the slow modes of large packings, whose
 * periods of some 1e4 steps are not known beforehand.
 *
 * Sums go over fixed blocks of disks and then over the blocks, so that they do not depend on the threads.
 */
#include "pack/relax.h"

#include <assert.h>
#include <math.h>

#include "physics/step/access.h"
#include "physics/system/clumps.h"

enum { PATIENCE = 5 };
static const double ALPHA = 0.1, SHRINK = 0.99, BRAKE = 2.0;

void relax_begin(engine *e) {
  e->state->relax_alpha = ALPHA;
  e->state->relax_steps = 0;
}

static const double *inertia_of(const sd_state *s, int coordinate) {
  return coordinate == SD_THETA ? s->inertia : s->mass;
}

static void block_of(const engine *e, size_t block, size_t *begin, size_t *end) {
  team_share(&(team){.rank = (int)block, .size = RELAX_BLOCKS}, e->state->n_free, begin, end);
}

/* The blocks of one thread. */
static void blocks_of(const team *t, size_t *begin, size_t *end) {
  *begin = RELAX_BLOCKS * (size_t)t->rank / (size_t)t->size;
  *end = RELAX_BLOCKS * ((size_t)t->rank + 1) / (size_t)t->size;
}

static double total(const double *blocks) {
  double sum = 0.0;
  for (size_t b = 0; b < RELAX_BLOCKS; b++) sum += blocks[b];
  return sum;
}

/* Coordinates that are held, and disks that are not in play, have no inverse mass and no equilibrium to find. */
static inline double free_part(const columns *c, size_t i, double value) {
  return c->inverse[i] != 0.0 ? value : 0.0;
}

/* Power and the squares of both norms, in several sums side by side, so that none waits for itself. */
enum { SIDE_BY_SIDE = 4 };

static void clumps_of(const engine *e, size_t block, size_t *begin, size_t *end) {
  team_share(&(team){.rank = (int)block, .size = RELAX_BLOCKS}, engine_clumps(e), begin, end);
}

static void measure_clumps(const engine *e, size_t block, double *power, double *speed2, double *push2) {
  size_t begin, end;
  clumps_of(e, block, &begin, &end);
  for (size_t i = begin; i < end; i++) {
    const clump_load load = clump_total(e, i);
    for (int k = 0; k < SD_COORDINATES; k++) {
      const columns *c = engine_clump_columns(e, k);
      if (c->inverse[i] == 0.0) continue;
      *power += load.on[k] * c->v[i];
      *speed2 += c->v[i] * c->v[i] / c->inverse[i];
      *push2 += load.on[k] * load.on[k] * c->inverse[i];
    }
  }
}

static void measure(const engine *e, size_t block, relax_sums *team_sums) {
  double power[SIDE_BY_SIDE] = {0}, speed2[SIDE_BY_SIDE] = {0}, push2[SIDE_BY_SIDE] = {0};
  size_t begin, end;
  block_of(e, block, &begin, &end);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = engine_columns(e, k);
    const double *mass = inertia_of(e->state, k);
    for (size_t i = begin; i < end; i += SIDE_BY_SIDE) {
      size_t n = end - i < SIDE_BY_SIDE ? end - i : SIDE_BY_SIDE;
      for (size_t j = 0; j < n; j++) {
        double force = free_part(c, i + j, c->force[i + j] + c->constant[i + j]);
        double v = free_part(c, i + j, c->v[i + j]);
        power[j] += force * v;
        speed2[j] += mass[i + j] * v * v;
        push2[j] += force * force * c->inverse[i + j];
      }
    }
  }
  measure_clumps(e, block, &power[0], &speed2[0], &push2[0]);
  team_sums->power[block] = (power[0] + power[1]) + (power[2] + power[3]);
  team_sums->speed2[block] = (speed2[0] + speed2[1]) + (speed2[2] + speed2[3]);
  team_sums->push2[block] = (push2[0] + push2[1]) + (push2[2] + push2[3]);
}

/* v <- keep v + steer F/M */
static void change_clumps(engine *e, size_t block, double keep, double steer) {
  size_t begin, end;
  clumps_of(e, block, &begin, &end);
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

static void change(engine *e, size_t block, double keep, double steer) {
  size_t begin, end;
  block_of(e, block, &begin, &end);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = engine_columns(e, k);
    for (size_t i = begin; i < end; i++) {
      double v = keep * c->v[i] + steer * ((c->force[i] + c->constant[i]) * c->inverse[i]);
      c->v[i] = c->inverse[i] != 0.0 ? v : c->v[i];
    }
  }
}

/* The higher derivatives of Gear's predictor belong to the motion that was stopped. */
static void forget_derivatives(engine *e, size_t block) {
  size_t begin, end;
  if (e->model->integrator != SD_GEAR5) return;
  block_of(e, block, &begin, &end);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = engine_columns(e, k);
    for (size_t i = begin; i < end; i++)
      if (c->inverse[i] != 0.0) c->q3[i] = c->q4[i] = c->q5[i] = 0.0;
  }
}

void relax_step(engine *e, const team *t, relax_sums *team_sums) {
  sd_state *s = e->state;
  size_t begin, end;
  blocks_of(t, &begin, &end);
  for (size_t b = begin; b < end; b++) measure(e, b, team_sums);
  team_wait(t);
  const double power = total(team_sums->power), speed2 = total(team_sums->speed2),
               push2 = total(team_sums->push2);
  const bool downhill = power > 0.0;
  const double keep = downhill ? 1.0 - s->relax_alpha : 0.0;
  const double steer = downhill ? s->relax_alpha * sqrt(speed2 / push2) : 0.0;
  for (size_t b = begin; b < end; b++) {
    change(e, b, keep, steer);
    change_clumps(e, b, keep, steer);
    if (!downhill) forget_derivatives(e, b);
  }
  team_wait(t);
  if (t->rank > 0) return;
  clumps_place_all(e);
  assert(!(speed2 < 0.0) && !(push2 < 0.0) && s->relax_alpha >= 0.0 && s->relax_alpha <= ALPHA);
  /* M v^2/2 before and after, summed up: nobody has to look at the disks again */
  s->relaxed += 0.5 * (speed2 - (keep * keep * speed2 + 2.0 * keep * steer * power + steer * steer * push2));
  if (!downhill)
    relax_begin(e);
  else if (++s->relax_steps > PATIENCE)
    s->relax_alpha = fmax(SHRINK * s->relax_alpha, fmin(ALPHA, BRAKE / (double)s->relax_steps));
}
