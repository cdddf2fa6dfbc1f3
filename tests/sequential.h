/* sequential.h: what ending a run by its own error bar does to the result, on records whose mean is known.
 *
 * Autoregressive records of variance 1 stand for the rate of a disk, one sample per step. They go through the bins
 * of a state, sd_goal_look and sd_goal_of like those of a run. The goal is the true error of `wanted` steps, so
 * that a run which knew the true error would end there.
 */
#ifndef TESTS_SEQUENTIAL_H
#define TESTS_SEQUENTIAL_H

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "unit.h"
#include "model/state.h"
#include "slipdisk/measure.h"

typedef struct sequential {
  double rho;            /* correlation of neighbours; tau = (1 + rho)/(1 - rho)/2 */
  int64_t wanted, least; /* steps */
  double mean;           /* 0: the goal is absolute, else a fraction of the mean */
} sequential;

/* Means over many records. */
typedef struct sequential_found {
  double length,
      early;    /* of the record in `wanted`; part of the records that are less than half of it */
  double error; /* error bar over the true error of a record so long */
  double within, chi2;             /* part within one error bar; ((mean - true)/error)^2 */
  double bias;                     /* of the mean, in goals */
  double reached;                  /* part whose goal was reached before 16 times `wanted` */
  double fixed_within, fixed_chi2; /* of the same records, all of the length `wanted` */
} sequential_found;

/* A record that grows, as sums from its start. */
typedef struct growing {
  gsl_rng *random;
  double rho, mean, last, *sum;
  int64_t n;
} growing;

static inline void grow(growing *g, int64_t n) {
  if (g->n == 0) g->last = gsl_ran_gaussian_ziggurat(g->random, 1);
  for (; g->n < n; g->n++) {
    g->sum[g->n + 1] = g->sum[g->n] + g->mean + g->last;
    g->last =
        g->rho * g->last + sqrt(1 - g->rho * g->rho) * gsl_ran_gaussian_ziggurat(g->random, 1);
  }
}

/* The state after n steps: bins as measure/sample.c makes them. */
static inline void fill_bins(sd_state *state, const growing *g, int64_t n) {
  state->measured = n;
  state->bin_steps = 1;
  while (n / state->bin_steps >= SD_BINS) state->bin_steps *= 2;
  state->bins = n / state->bin_steps;
  for (int64_t b = 0; b < state->bins; b++)
    state->rotation_bin[b] = g->sum[(b + 1) * state->bin_steps] - g->sum[b * state->bin_steps];
}

/* Standard error of the mean of n samples, exactly. */
static inline double exact_error(int64_t n, double rho) {
  double m = (double)n;
  return sqrt(((1 + rho) / (1 - rho) - 2 * rho * (1 - pow(rho, m)) / (m * (1 - rho) * (1 - rho))) /
              m);
}

static inline sequential_found sequential_trial(const sequential *c, int seeds) {
  double bins[SD_BINS], zero = 0, goal = exact_error(c->wanted, c->rho), part = 1.0 / seeds;
  sd_disk disk = {.radius = 1};
  uint32_t watched = 0;
  sd_phase phase = {.steps = 16 * c->wanted, .measure = true};
  sd_model model = {.dt = 1,
                    .n_disks = 1,
                    .disks = &disk,
                    .n_rotations = 1,
                    .rotations = &watched,
                    .n_phases = 1,
                    .phases = &phase,
                    .until = {.asked = true, .least = c->least}};
  *(c->mean > 0 ? &model.until.relative : &model.until.error) = c->mean > 0 ? goal / c->mean : goal;
  sd_state state = {
      .n_rotations = 1, .rotation_bin = bins, .rotation_start = &zero, .rotation_last = &zero};
  growing g = {.random = gsl_rng_alloc(gsl_rng_mt19937), .rho = c->rho, .mean = c->mean};
  g.sum = calloc((size_t)phase.steps + 1, sizeof *g.sum);
  assert_non_null(g.random);
  assert_non_null(g.sum);

  sequential_found found = {0};
  for (int seed = 0; seed < seeds; seed++) {
    sd_goal now = {0};
    int64_t n = 0;
    for (g.n = 0; n < phase.steps && !now.reached;) {
      n = sd_goal_look(&model, n);
      grow(&g, n);
      fill_bins(&state, &g, n);
      now = sd_goal_of(&model, &state);
    }
    double off = now.value - c->mean;
    found.length += part * (double)n / (double)c->wanted;
    found.early += part * (2 * n < c->wanted);
    found.error += part * now.error / exact_error(n, c->rho);
    found.within += part * (fabs(off) < now.error);
    found.chi2 += part * off * off / (now.error * now.error);
    found.bias += part * off / goal;
    found.reached += part * now.reached;

    grow(&g, c->wanted);
    fill_bins(&state, &g, c->wanted);
    now = sd_goal_of(&model, &state);
    off = now.value - c->mean;
    found.fixed_within += part * (fabs(off) < now.error);
    found.fixed_chi2 += part * off * off / (now.error * now.error);
  }
  free(g.sum);
  gsl_rng_free(g.random);
  return found;
}

static inline void print_sequential(const sequential *c, const sequential_found *f) {
  double tau = (1 + c->rho) / (1 - c->rho) / 2;
  print_message("| %4.1f | %5.0f | %5.0f | %5.3f | %4.2f | %4.2f | %4.2f | %4.2f | %4.2f | %5.2f | "
                "%4.2f | %4.2f |\n",
                tau, (double)c->least / tau, (double)c->wanted / tau,
                c->mean > 0 ? exact_error(c->wanted, c->rho) / c->mean : 0.0, f->length, f->early,
                f->error, f->within, f->chi2, f->bias, f->fixed_within, f->fixed_chi2);
}

#endif
