/* validation.h: runs of the decks that ship, for test_validation.c and slow_validation.c.
 *
 * Decks are read as the program reads them, with overrides as after -D.
 */
#ifndef TESTS_VALIDATION_H
#define TESTS_VALIDATION_H

#include "unit.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"
#include "slipdisk/theory.h"

HELPER void between(double value, double low, double high, const char *what) {
  if (value >= low && value <= high) return;
  print_error("%s: %.10g, expected %.10g to %.10g\n", what, value, low, high);
  fail();
}

/* within a relative tolerance */
HELPER void close_to(double value, double expected, double relative, const char *what) {
  double width = relative * fabs(expected);
  between(value, expected - width, expected + width, what);
}

typedef struct trial {
  sd_model *model;
  sd_simulation *sim;
} trial;

/* deck: path below inputs/; each override "path=value" is closed by a semicolon. */
HELPER SD_PRINTF(2, 3) trial trial_begin(const char *deck, const char *overrides, ...) {
  enum { MOST = 24 };
  char text[2048], path[1024];
  const char *list[MOST];
  size_t n = 0;
  va_list args;
  va_start(args, overrides);
  vsnprintf(text, sizeof text, overrides, args);
  va_end(args);
  char *save = NULL;
  for (char *item = strtok_r(text, ";", &save); item; item = strtok_r(NULL, ";", &save)) {
    assert_true(n < MOST);
    list[n++] = item;
  }
  snprintf(path, sizeof path, "%s/inputs/%s", SLIPDISK_SOURCE_DIR, deck);
  trial run = {NULL, NULL};
  sd_messages *messages = sd_messages_new();
  if (sd_deck_load(path, n, list, &run.model, messages) == SD_OK)
    sd_simulation_new(run.model, 1, &run.sim, messages);
  if (!run.sim) sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_non_null(run.sim);
  return run;
}

HELPER void trial_end(trial *run) {
  sd_simulation_free(run->sim);
  sd_model_free(run->model);
}

HELPER void trial_advance(trial *run, int64_t steps) {
  sd_messages *messages = sd_messages_new();
  sd_status status = sd_simulation_advance(run->sim, steps, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_int_equal(status, SD_OK);
}

/* Residual of the energy budget over the work done and the energy lost. */
HELPER double trial_residual(const trial *run) {
  sd_energy energy = sd_simulation_energy(run->sim);
  return fabs(energy.residual) / energy.scale;
}

/* Torque of all contacts on a disk at the last step. */
HELPER double trial_torque(trial *run, uint32_t body) {
  return sd_simulation_state(run->sim)->torque[sd_simulation_slot(run->sim, body)];
}

HELPER sd_slide trial_slide(trial *run) {
  return sd_slide_of(run->model, sd_simulation_state(run->sim), 0);
}

typedef struct vibrated {
  sd_rotation rotation;
  sd_slide slide;
  double residual;
} vibrated;

/* inputs/three_disk/random.cfg over a measured time, tilt in units of pi. more: overrides, may be "". */
HELPER vibrated vibrate(double tilt, double dt, double time, unsigned seed, const char *more) {
  trial run = trial_begin(
      "three_disk/random.cfg",
      "gravity.tilt=%.17g pi;dt=%.17g;seed=%u;phases.settle.time=1;phases.measure.time=%.17g;%s",
      tilt, dt, seed, time, more);
  trial_advance(&run, sd_model_steps(run.model));
  vibrated out = {.rotation = sd_rotation_of(run.model, sd_simulation_state(run.sim), 0),
                  .slide = trial_slide(&run),
                  .residual = trial_residual(&run)};
  trial_end(&run);
  return out;
}

typedef struct turned {
  double omega;     /* mean over the last period, half way between the runs from both sides */
  double bracket;   /* half the distance of the two */
  double exact;     /* permanent sliding, centre at its TEP at once */
  double deviation; /* omega/exact - 1 */
  double residual;
  sd_slide slide; /* of one run */
} turned;

typedef struct drive {
  bool opposite; /* phase between the supports: pi, else 0 */
  sd_waveform waveform;
  double amplitude, w; /* Theta_b; w_b in units of pi, so that the period is 2/w */
  double tilt;         /* in units of pi */
  double time, dt;
  const char *more; /* overrides of either deck */
} drive;

HELPER sd_three_disk paper_disk(double tilt) {
  return (sd_three_disk){.tilt = tilt * M_PI,
                         .half_aperture = M_PI / 6,
                         .mu = 0.1,
                         .weight = 1,
                         .radius = 1,
                         .inertia = 0.05};
}

HELPER double drive_exact(const drive *d) {
  sd_three_disk disk = paper_disk(d->tilt);
  sd_drive supports = {.waveform = d->waveform,
                       .omega = d->w * M_PI,
                       .amplitude = {d->amplitude, d->amplitude},
                       .phase = {0, d->opposite ? M_PI : 0},
                       .support_radius = {1, 1}};
  sd_sliding solution;
  assert_int_equal(sd_sliding_solve(&disk, &supports, &solution, NULL), SD_OK);
  return solution.mean;
}

/* One run that starts with the spin `start`; returns the mean velocity over the last whole period.
 * The supports turn from the first step on; statistics count the second half. */
HELPER double drive_run(const drive *d, double start, turned *out) {
  int64_t period = llround(2 / d->w / d->dt), half = llround(d->time * d->w / 4);
  trial run =
      trial_begin(d->opposite ? "three_disk/async.cfg" : "three_disk/sync.cfg",
                  "motions[*].type=%s;motions[*].amplitude=%.17g;motions[*].omega=%.17g pi;"
                  "gravity.tilt=%.17g pi;dt=%.17g;disks[0].omega=%.17g;phases.rest.motions=%s;"
                  "phases.rest.steps=%lld;phases.measure.steps=%lld;%s",
                  d->waveform == SD_SINE ? "harmonic" : "parabolic", d->amplitude, d->w, d->tilt,
                  d->dt, start, d->opposite ? "(0, 1)" : "(0)", (long long)(period * half),
                  (long long)(period * half), d->more ? d->more : "");
  trial_advance(&run, period * (2 * half - 1));
  double before = sd_simulation_angle(run.sim, 0);
  trial_advance(&run, period);
  double omega = (sd_simulation_angle(run.sim, 0) - before) / ((double)period * d->dt);
  out->residual = trial_residual(&run);
  out->slide = trial_slide(&run);
  trial_end(&run);
  return omega;
}

/* The periodic state, approached from both sides: torques fall when Omega rises, so that all solutions draw
 * nearer to one another and the state lies between a slower and a faster one. */
HELPER turned drive_periodic(const drive *d) {
  turned out = {.exact = drive_exact(d)};
  double below = drive_run(d, 0.93 * out.exact, &out), above = drive_run(d, 1.07 * out.exact, &out);
  out.omega = (below + above) / 2;
  out.bracket = fabs(above - below) / 2;
  out.deviation = out.omega / out.exact - 1;
  return out;
}

#endif
