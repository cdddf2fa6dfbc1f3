/* theory_solve.c: which formulas apply to the three disks of a deck, and their values. */
#include <math.h>

#include "app/theory/theory.h"

const char *const theory_configurations[4] = {[SD_PP] = "++", [SD_PM] = "+-", [SD_MP] = "-+", [SD_MM] = "--"};

static const int signs[4][2] = {[SD_PP] = {1, 1}, [SD_PM] = {1, -1}, [SD_MP] = {-1, 1}, [SD_MM] = {-1, -1}};

/* Phases nearer than this are the same. */
static const double SAME = 1e-9;

static int sign(double x) { return (x > 0) - (x < 0); }

/* Torques fall with Omega from T++ > 0 below both supports to T-- < 0 above both; a free disk ends with the
 * support at which they change sign. */
static void solve_steady(const theory_case *c, theory_result *r) {
  double w[2];
  for (int i = 0; i < 2; i++) {
    w[i] = -c->velocity[i] * c->support_radius[i] / c->disk.radius;
    r->signs[i] = sign(w[i] - c->spin);
  }
  double between = r->torque[w[0] > w[1] ? SD_PM : SD_MP];
  r->final_spin = between > 0 ? fmax(w[0], w[1]) : between < 0 ? fmin(w[0], w[1]) : NAN;
  if (w[0] == w[1]) r->final_spin = w[0];
  if (c->locked) r->final_spin = NAN;
}

static void solve_closed(const theory_case *c, theory_result *r) {
  const sd_drive *d = &c->drive;
  const sd_three_disk *disk = &c->disk;
  bool sine = d->waveform == SD_SINE;
  double slope = sine ? M_PI * M_PI / 8 : 1; /* of a sine against its parabola, at zero velocity */
  if (!r->even) return;
  if (r->relation == THEORY_IN_PHASE) {
    if (sine)
      r->sine = sd_sync_mean_sine(disk, r->amplitude, d->omega);
    else
      r->parabola = sd_sync_parabola(disk, r->amplitude, d->omega);
    r->first_order = slope * sd_sync_mean_parabola(disk, r->amplitude, d->omega);
  } else if (r->relation == THEORY_OPPOSITE) {
    r->first_order = slope * sd_async_first_order(disk, r->amplitude, d->omega);
  }
}

static sd_status solve_periodic(const theory_case *c, theory_result *r, sd_messages *messages) {
  sd_drive exact = c->drive, *d = &exact;
  double a[2];
  for (int i = 0; i < 2; i++) a[i] = d->amplitude[i] * d->support_radius[i] / c->disk.radius;
  r->amplitude = fmax(a[0], a[1]);
  r->even = fabs(a[0] - a[1]) <= 1e-12 * r->amplitude;
  r->apart = remainder(d->phase[1] - d->phase[0], 2 * M_PI);
  if (fabs(r->apart) > M_PI - SAME) r->apart = M_PI;
  if (fabs(r->apart) < SAME) r->apart = 0;
  d->phase[1] = d->phase[0] + r->apart;
  r->relation = r->apart == 0 ? THEORY_IN_PHASE : r->apart == M_PI ? THEORY_OPPOSITE : THEORY_OTHER_PHASE;
  double largest = 0;
  for (int k = 0; k < 4; k++)
    if (r->relation != THEORY_IN_PHASE || !r->even || k == SD_PP || k == SD_MM)
      largest = fmax(largest, fabs(r->torque[k]));
  r->ratio = largest / (c->disk.inertia * r->amplitude * d->omega * d->omega);
  sd_status status = sd_sliding_solve(&c->disk, d, &r->solution, messages);
  r->solved = status == SD_OK;
  if (status) return status; /* where a configuration has no equilibrium no formula holds */
  solve_closed(c, r);
  return sd_sliding_limit(&c->disk, d, &r->limit, messages);
}

sd_status theory_case_solve(const theory_case *c, theory_result *r, sd_messages *messages) {
  *r = (theory_result){.apart = NAN,
                       .amplitude = NAN,
                       .ratio = NAN,
                       .parabola = {.t1 = NAN, .t2 = NAN, .pp = NAN, .mm = NAN, .mean = NAN},
                       .first_order = NAN,
                       .sine = NAN,
                       .limit = NAN,
                       .final_spin = NAN};
  for (int k = 0; k < 4; k++) {
    r->tep[k] = sd_tep_solve(&c->disk, signs[k][0], signs[k][1]);
    r->torque[k] = sd_tep_torque(&c->disk, signs[k][0], signs[k][1]);
  }
  r->slight = sd_slight_tilt_torque(&c->disk);
  r->sync = sd_slight_tilt_torque_sync(&c->disk);
  if (c->kind == THEORY_STEADY) solve_steady(c, r);
  return c->kind == THEORY_PERIODIC ? solve_periodic(c, r, messages) : SD_OK;
}
