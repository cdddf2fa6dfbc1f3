/* slow_validation.c: longer runs of the decks that ship: the step of 1e-6, convergence in the time step, error
 * bars against the scatter of seeds, and how the theory of permanent sliding is approached.
 */
#include "validation.h"

static void decks_own_step(void **unused) {
  vibrated tilted = vibrate(0.04, 1e-6, 60, 1, ""), level = vibrate(0, 1e-6, 60, 1, "");
  print_message("dt 1e-6: Omega %.3g +- %.2g, without tilt %.3g +- %.2g\n", tilted.rotation.omega,
                tilted.rotation.error, level.rotation.omega, level.rotation.error);
  assert_true(tilted.rotation.omega < -5 * tilted.rotation.error);
  assert_true(fabs(level.rotation.omega) < 2 * level.rotation.error);
  assert_int_equal(tilted.slide.openings[0] + tilted.slide.openings[1], 0);
  between(tilted.residual, 0, 1e-8, "energy residual");
}

/* The same signal is not the same at another step, so results agree within error bars; the two integrators see
 * the same signal, and differ by much less. */
static void step_and_integrator_do_not_matter(void **unused) {
  const double steps[] = {2e-5, 1e-5, 5e-6};
  vibrated last = {.residual = 0};
  for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
    vibrated gear = vibrate(0.04, steps[k], 200, 1, ""),
             verlet = vibrate(0.04, steps[k], 200, 1, "integrator=verlet;");
    double gear_omega = gear.rotation.turned / gear.rotation.measured;
    double verlet_omega = verlet.rotation.turned / verlet.rotation.measured;
    print_message("dt %g: Omega %.4g +- %.2g, all of the run %.7g (gear5) %.7g (verlet)\n",
                  steps[k], gear.rotation.omega, gear.rotation.error, gear_omega, verlet_omega);
    close_to(verlet_omega, gear_omega, 1e-3, "integrator");
    if (k > 0)
      between(fabs(gear.rotation.omega - last.rotation.omega) /
                  hypot(gear.rotation.error, last.rotation.error),
              0, 3, "standard errors between two steps");
    last = gear;
  }
}

/* Sum of squares over 8 seeds: chi^2 of 7 degrees of freedom, within its central 99.8 %. */
static void error_bars_are_the_scatter_of_seeds(void **unused) {
  enum { SEEDS = 8 };
  const double tilts[] = {0.04, 0};
  for (int k = 0; k < 2; k++) {
    double omega[SEEDS], error[SEEDS], sum = 0, squares = 0, weight = 0, chi = 0;
    for (unsigned s = 0; s < SEEDS; s++) {
      vibrated v = vibrate(tilts[k], 1e-5, 100, s + 1, "");
      omega[s] = v.rotation.omega;
      error[s] = v.rotation.error;
      sum += omega[s] / SEEDS;
      weight += error[s] * error[s] / (SEEDS * SEEDS);
    }
    for (int s = 0; s < SEEDS; s++) {
      squares += (omega[s] - sum) * (omega[s] - sum) / (SEEDS - 1);
      chi += (omega[s] - sum) * (omega[s] - sum) / (error[s] * error[s]);
    }
    print_message("tilt %g pi: mean of seeds %.4g +- %.2g, scatter %.3g, chi^2 %.2f\n", tilts[k],
                  sum, sqrt(weight), sqrt(squares), chi);
    between(chi, 0.6, 24.3, "chi^2 of 8 seeds");
    if (k == 0)
      assert_true(sum < -15 * sqrt(weight));
    else
      assert_true(fabs(sum) < 2 * sqrt(weight));
  }
}

static drive paper_drive(bool opposite) {
  return (drive){.opposite = opposite,
                 .waveform = SD_PARABOLA,
                 .amplitude = 0.04,
                 .w = 20,
                 .tilt = 0.04,
                 .time = 12,
                 .dt = 1e-5};
}

static void periodic_states_converge_in_the_step(void **unused) {
  for (int opposite = 0; opposite < 2; opposite++)
    for (int verlet = 0; verlet < 2; verlet++) {
      drive d = paper_drive(opposite != 0);
      d.more = verlet ? "integrator=verlet;" : NULL;
      turned coarse = drive_periodic(&d);
      d.dt = 1e-6;
      turned fine = drive_periodic(&d);
      print_message("%s, %s: %.7f at dt = 1e-5, %.7f at 1e-6\n", opposite ? "opposite" : "in phase",
                    verlet ? "verlet" : "gear5", coarse.omega, fine.omega);
      close_to(coarse.omega, fine.omega, opposite ? 5e-4 : 2e-3, "dt = 1e-5 against 1e-6");
      between(fine.residual, 0, 1e-11, "energy residual");
    }
}

/* Slower (the centre's lag is a smaller part of the period) and stronger (its velocity a smaller part of the
 * surface's) drive: the deviation from the theory falls until the supports' overlap is felt. In phase that is
 * soon: Omega is 1/80 of what each torque would give, and the overlap changes the torques by some 1e-5. */
static void slow_and_strong_drive_meets_the_theory(void **unused) {
  for (int opposite = 0; opposite < 2; opposite++) {
    double last = 1;
    for (int k = 0; k < 4; k++) {
      drive d = paper_drive(opposite != 0);
      d.w = 20 / (double)(1 << k);
      d.amplitude = 12.8 / d.w;
      d.time = 160;
      turned t = drive_periodic(&d);
      print_message("%s, Theta_b w_b = 12.8 pi, w_b = %g pi: off by %.2f %%\n",
                    opposite ? "opposite" : "in phase", d.w, 100 * t.deviation);
      assert_true(t.bracket < 0.001 * fabs(t.exact));
      if (opposite) {
        assert_true(fabs(t.deviation) < last);
        last = fabs(t.deviation);
      }
      if (d.w <= 5) between(fabs(t.deviation), 0, opposite ? 0.01 : 0.005, "deviation");
    }
    if (opposite) between(last, 0, 0.005, "deviation at w_b = 2.5 pi");
  }
}

RUN_TESTS(TEST(decks_own_step), TEST(step_and_integrator_do_not_matter),
          TEST(error_bars_are_the_scatter_of_seeds), TEST(periodic_states_converge_in_the_step),
          TEST(slow_and_strong_drive_meets_the_theory))
