/* theory_solve.c: selects the formulas that apply to the three disks of a deck, and evaluates
 * them. */
#include <math.h>

#include "app/theory/theory.h"

static const int signs[4][2] = {
    [SD_PP] = {1, 1}, [SD_PM] = {1, -1}, [SD_MP] = {-1, 1}, [SD_MM] = {-1, -1}};

/* Phases that differ by less than this many rad count as equal. */
static const double SAME = 1e-9;

static int sign(double x) { return (x > 0) - (x < 0); }

/* Solves the case of steady drive. The torque on the upper disk falls with its angular velocity
 * Omega: it is positive (torque of S++) when Omega is below the values at which the disk would roll
 * on either support, and negative (S--) when Omega is above both. A disk free to rotate ends at the
 * Omega at which the torque changes sign. */
static void solve_steady(theory_case *c) {
  double w[2];
  for (int i = 0; i < 2; i++) {
    w[i] = -c->velocity[i] * c->support_radius[i] / c->disk.radius;
    c->signs[i] = sign(w[i] - c->spin);
  }
  double between = c->torque[w[0] > w[1] ? SD_PM : SD_MP];
  c->final_spin = between > 0 ? fmax(w[0], w[1]) : between < 0 ? fmin(w[0], w[1]) : NAN;
  if (w[0] == w[1]) c->final_spin = w[0];
  if (c->locked) c->final_spin = NAN;
  if (c->signs[0] && c->signs[1])
    c->start_torque = sd_tep_torque(&c->disk, c->signs[0], c->signs[1]);
}

static void solve_closed(theory_case *c) {
  const sd_drive *d = &c->drive;
  const sd_three_disk *disk = &c->disk;
  bool sine = d->waveform == SD_SINE;
  /* Acceleration at velocity 0 of a sine divided by that of the parabolic wave with the same
   * amplitude */
  double slope = sine ? M_PI * M_PI / 8 : 1;
  if (!c->even) return;
  if (c->relation == THEORY_IN_PHASE) {
    if (sine)
      c->sine = sd_sync_mean_sine(disk, c->amplitude, d->omega);
    else
      c->parabola = sd_sync_parabola(disk, c->amplitude, d->omega);
    c->first_order = slope * sd_sync_mean_parabola(disk, c->amplitude, d->omega);
  } else if (c->relation == THEORY_OPPOSITE) {
    c->first_order = slope * sd_async_first_order(disk, c->amplitude, d->omega);
  }
}

static sd_status solve_periodic(theory_case *c, sd_messages *messages) {
  sd_drive exact = c->drive, *d = &exact;
  double a[2];
  for (int i = 0; i < 2; i++) a[i] = d->amplitude[i] * d->support_radius[i] / c->disk.radius;
  c->amplitude = fmax(a[0], a[1]);
  c->even = fabs(a[0] - a[1]) <= 1e-12 * c->amplitude;
  c->apart = remainder(d->phase[1] - d->phase[0], 2 * M_PI);
  if (fabs(c->apart) > M_PI - SAME) c->apart = M_PI;
  if (fabs(c->apart) < SAME) c->apart = 0;
  d->phase[1] = d->phase[0] + c->apart;
  c->relation = c->apart == 0      ? THEORY_IN_PHASE
                : c->apart == M_PI ? THEORY_OPPOSITE
                                   : THEORY_OTHER_PHASE;
  double largest = 0;
  for (int k = 0; k < 4; k++)
    if (c->relation != THEORY_IN_PHASE || !c->even || k == SD_PP || k == SD_MM)
      largest = fmax(largest, fabs(c->torque[k]));
  c->ratio = largest / (c->disk.inertia * c->amplitude * d->omega * d->omega);
  sd_status status = sd_sliding_solve(&c->disk, d, &c->solution, messages);
  c->solved = status == SD_OK;
  if (status) return status; /* No formula applies if a sliding configuration has no equilibrium */
  solve_closed(c);
  return sd_sliding_limit(&c->disk, d, &c->limit, messages);
}

sd_status theory_case_solve(theory_case *c, sd_messages *messages) {
  for (int k = 0; k < 4; k++) {
    c->tep[k] = sd_tep_solve(&c->disk, signs[k][0], signs[k][1]);
    c->torque[k] = sd_tep_torque(&c->disk, signs[k][0], signs[k][1]);
  }
  c->slight = sd_slight_tilt_torque(&c->disk);
  c->sync = sd_slight_tilt_torque_sync(&c->disk);
  c->sense = sign(c->shared ? c->sync : c->slight);
  if (tan(c->disk.half_aperture) > c->disk.mu) c->reversal = sd_reversal_phase(&c->disk);
  if (c->kind == THEORY_STEADY) solve_steady(c);
  const sd_sliding *x = &c->solution;
  const sd_status status = c->kind == THEORY_PERIODIC ? solve_periodic(c, messages) : SD_OK;
  c->mean_scaled = x->mean * c->t_g;
  c->mean_normalised = x->mean / (c->amplitude * c->drive.omega);
  for (int k = 0; k < 4; k++) c->fraction[k] = x->duration[k] / x->period;
  c->stuck = x->stuck / x->period;
  c->permanent = c->solved ? x->permanent : NAN;
  return status;
}
