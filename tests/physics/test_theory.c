/* test_theory.c: closed forms against linear algebra, quadrature and direct integration in time. */
#include <gsl/gsl_integration.h>

#include "unit.h"
#include "slipdisk/theory.h"

static void near(double value, double expected, double tolerance, const char *what) {
  if (!(fabs(value - expected) <= tolerance)) {
    print_error("%s: %.15g, expected %.15g within %.2g\n", what, value, expected, tolerance);
    fail();
  }
}

/* The paper's deck: m = 0.1, g = 10, R = 1, mu = 0.1, theta_h = pi/6; w_b = 20 pi. */
static const double w_b = 20 * M_PI;
static sd_three_disk paper(double tilt) {
  return (sd_three_disk){.tilt = tilt,
                         .half_aperture = M_PI / 6,
                         .mu = 0.1,
                         .weight = 1,
                         .radius = 1,
                         .inertia = 0.05};
}

static sd_drive turning(sd_waveform waveform, double amplitude, double phase) {
  return (sd_drive){.waveform = waveform,
                    .omega = w_b,
                    .amplitude = {amplitude, amplitude},
                    .phase = {0, phase},
                    .support_radius = {1, 1}};
}

static const int signs[4][2] = {{1, 1}, {1, -1}, {-1, 1}, {-1, -1}};

static void tep_closed_forms_solve_the_force_balance(void **unused) {
  for (double half = 0.2; half < 1.5; half += 0.13)
    for (double tilt = -0.3; tilt < 0.31; tilt += 0.05)
      for (double mu = 0.01; mu < 0.9; mu *= 1.7)
        for (int s1 = -1; s1 <= 1; s1++)
          for (int s2 = -1; s2 <= 1; s2++) {
            sd_three_disk d = {tilt, half, mu, 2.5, 0.7, 1};
            sd_tep tep = sd_tep_solve(&d, s1, s2);
            double closed = sd_tep_torque(&d, s1, s2);
            /* near the wedge tan(theta_h) = mu the balance is singular and both lose digits alike */
            near(tep.torque, closed, 1e-12 * (1 + closed * closed), "torque");
            double a1 = half - tilt, a2 = half + tilt, n1 = tep.normal[0], n2 = tep.normal[1];
            double scale = 1e-13 * (1 + fabs(n1) + fabs(n2));
            near(n1 * sin(a1) - n2 * sin(a2) + mu * (s1 * n1 * cos(a1) + s2 * n2 * cos(a2)), 0,
                 10 * scale, "x");
            near(n1 * cos(a1) + n2 * cos(a2) + mu * (s2 * n2 * sin(a2) - s1 * n1 * sin(a1)), 2.5,
                 10 * scale, "y");
          }
}

static void tep_matches_the_printed_formulas(void **unused) {
  sd_three_disk d = paper(0.04 * M_PI);
  double mu = 0.1, c = cos(d.tilt), s = sin(d.tilt), ch = cos(d.half_aperture),
         sh = sin(d.half_aperture);
  near(sd_tep_torque(&d, 1, 1), mu * (c + mu * s) / ((1 + mu * mu) * ch), 1e-16, "(15)");
  near(sd_tep_torque(&d, -1, -1), -mu * (c - mu * s) / ((1 + mu * mu) * ch), 1e-16, "(16)");
  near(sd_tep_torque(&d, 1, -1), mu * s / (sh + mu * ch), 1e-16, "(17)");
  near(sd_tep_torque(&d, -1, 1), -mu * s / (sh - mu * ch), 1e-16, "(18)");
  double pp = sd_tep_torque(&d, 1, 1), mm = sd_tep_torque(&d, -1, -1);
  double sum = pp + mm + sd_tep_torque(&d, 1, -1) + sd_tep_torque(&d, -1, 1);
  near(sd_slight_tilt_torque(&d), sum / 4, 1e-16, "(19)");
  near(sd_slight_tilt_torque_sync(&d), (pp + mm) / 2, 1e-16, "(31), corrected");
  near(sd_tep_solve(&d, 1, 1).torque, 0.114858, 5e-7, "number");
}

static void wedge_is_refused(void **unused) {
  sd_three_disk d = paper(0.05);
  d.mu = 1; /* tan(theta_h) < mu: the disk is locked between the supports in S-+ */
  assert_false(sd_tep_solve(&d, -1, 1).stable);
  assert_true(sd_tep_solve(&d, 1, -1).stable);
  sd_drive drive = turning(SD_SINE, 0.01, 1);
  sd_sliding out;
  double mean;
  sd_messages *m = sd_messages_new();
  assert_int_equal(sd_sliding_solve(&d, &drive, &out, m), SD_ERROR_USER);
  assert_int_equal(sd_sliding_limit(&d, &drive, &mean, m), SD_ERROR_USER);
  drive.omega = 0;
  d = paper(0.05);
  assert_int_equal(sd_sliding_solve(&d, &drive, &out, m), SD_ERROR_USER);
  drive.omega = NAN;
  assert_int_equal(sd_sliding_solve(&d, &drive, &out, m), SD_ERROR_USER);
  assert_int_equal(sd_messages_errors(m), 4);
  sd_messages_free(m);
}

static void sync_parabola_is_exact(void **unused) {
  const double amplitudes[] = {1e-3, 4e-3, 1e-2, 4e-2, 1e-1, 10};
  for (size_t k = 0; k < sizeof amplitudes / sizeof *amplitudes; k++)
    for (double tilt = -0.08 * M_PI; tilt < 0.3; tilt += 0.04 * M_PI) {
      sd_three_disk d = paper(tilt);
      sd_drive drive = turning(SD_PARABOLA, amplitudes[k], 0);
      sd_sliding out;
      assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
      sd_sync sync = sd_sync_parabola(&d, amplitudes[k], w_b);
      double scale = amplitudes[k] * w_b;
      assert_true(out.permanent && sync.permanent);
      near(out.mean, sd_sync_mean_parabola(&d, amplitudes[k], w_b), 1e-12 * scale, "(30)");
      near(sync.mean, out.mean, 1e-12 * scale, "(29)");
      near(out.duration[SD_PP], sync.pp, 1e-11 * sync.pp, "(26)");
      near(out.duration[SD_MM], sync.mm, 1e-11 * sync.mm, "(27)");
      near(sync.t2 - sync.t1, sync.mm, 1e-14, "(25), (43)");
      near(sd_sliding_omega(&out, sync.t2), sd_sliding_support(&d, &drive, 0, sync.t2),
           1e-11 * scale, "t2");
      near(sd_sliding_omega(&out, sync.t1), sd_sliding_support(&d, &drive, 0, sync.t1),
           1e-11 * scale, "t1");
    }
}

static void sync_sine_closed_form_and_limit(void **unused) {
  for (double amplitude = 2e-3; amplitude < 50; amplitude *= 3) {
    sd_three_disk d = paper(0.06 * M_PI);
    sd_drive drive = turning(SD_SINE, amplitude, 0);
    sd_sliding out;
    double limit, scale = amplitude * w_b;
    assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
    assert_int_equal(sd_sliding_limit(&d, &drive, &limit, NULL), SD_OK);
    assert_true(out.permanent);
    near(out.mean, sd_sync_mean_sine(&d, amplitude, w_b), 1e-12 * scale, "sine, any amplitude");
    near(limit, sd_sync_limit_sine(&d, amplitude, w_b), 1e-12 * scale, "sine, limit");
    /* the durations are those of the limit at any amplitude; the mean is less by a term of second order */
    near(out.duration[SD_PP] / out.period, (1 - 0.1 * tan(d.tilt)) / 2, 1e-12, "fraction of S++");
    double rate = sd_tep_torque(&d, 1, 1) / (d.inertia * amplitude * w_b * w_b);
    near(out.mean / limit, 1, 1.3 * rate * rate, "approach to the limit");
  }
  /* too weak for permanent sliding */
  sd_three_disk d = paper(0.06 * M_PI);
  assert_true(isnan(sd_sync_mean_sine(&d, 2e-4, w_b)));
}

static void async_small_tilt_slope(void **unused) {
  sd_sliding out;
  const double amplitudes[] = {4e-3, 4e-2, 1, 100};
  for (size_t k = 0; k < 4; k++) {
    sd_three_disk d = paper(1e-6);
    sd_drive drive = turning(SD_PARABOLA, amplitudes[k], M_PI);
    assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
    assert_true(out.permanent);
    double first = sd_async_first_order(&d, amplitudes[k], w_b);
    near(out.mean / first, 1, 1e-5, "slope of (35)");
  }
  for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++)
    for (double tilt = -0.25; tilt < 0.3; tilt += 0.1) {
      double limit;
      sd_three_disk d = paper(tilt);
      sd_drive drive = turning((sd_waveform)shape, 0.04, M_PI);
      assert_int_equal(sd_sliding_limit(&d, &drive, &limit, NULL), SD_OK);
      near(limit, sd_async_limit(&d, drive.waveform, 0.04, w_b), 1e-12, "limit, opposite phases");
    }
  for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++)
    for (double tilt = 0.05; tilt < 0.3; tilt += 0.1) {
      double below, above;
      sd_three_disk d = paper(tilt);
      sd_drive drive = turning((sd_waveform)shape, 0.04, sd_reversal_phase(&d) - 1e-4);
      assert_int_equal(sd_sliding_limit(&d, &drive, &below, NULL), SD_OK);
      drive.phase[1] += 2e-4;
      assert_int_equal(sd_sliding_limit(&d, &drive, &above, NULL), SD_OK);
      assert_true(below > 0 && above < 0);
    }
  sd_three_disk d = paper(0.04 * M_PI);
  near(sd_async_first_order(&d, 0.04, w_b) / (0.04 * w_b), -0.0500, 5e-5, "(35) at 0.04 pi");
}

/* (21) and (22) as they are printed, in the interval of the print. */
static void parabola_and_its_velocity_are_the_print(void **unused) {
  sd_three_disk d = paper(0.1);
  sd_drive drive = turning(SD_PARABOLA, 0.3, 0);
  double a = 0.3, pi2 = M_PI * M_PI;
  for (double t = -0.0499; t < 0.05; t += 0.0007) {
    double side = t < 0 ? 1 : -1;
    near(sd_sliding_angle(&drive, 0, t),
         side * 4 * a * w_b * w_b / pi2 * t * t + 4 * a * w_b / M_PI * t, 1e-14, "(21)");
    near(sd_sliding_support(&d, &drive, 0, t),
         -side * 8 * a * w_b * w_b / pi2 * t - 4 * a * w_b / M_PI, 1e-12, "(22)");
    for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++) {
      drive = turning((sd_waveform)shape, 0.3, 1.3);
      drive.support_radius[1] = 1.7;
      double h = 1e-7,
             rate = (sd_sliding_angle(&drive, 1, t + h) - sd_sliding_angle(&drive, 1, t - h)) /
                    (2 * h);
      near(-1.7 * rate, sd_sliding_support(&d, &drive, 1, t), 2e-4, "velocity");
    }
    drive = turning(SD_PARABOLA, 0.3, 0);
  }
}

/* Times from the print's (25), (43) against the corners of the periodic solution, from the weakest drive of permanent
 * sliding on; Omega(t) of (28) between them; below the weakest drive contacts stick. */
static void transition_times_of_supports_in_phase(void **unused) {
  for (double half = 0.3; half < 1.2; half += 0.2)
    for (double tilt = -0.4 * half; tilt < 0.41 * half; tilt += 0.2 * half)
      for (double strength = 1.001; strength < 1e5; strength *= 6) {
        sd_three_disk d = {tilt, half, 0.15, 2, 0.8, 0.3};
        double plus = sd_tep_torque(&d, 1, 1), minus = sd_tep_torque(&d, -1, -1);
        double weakest = fmax(plus, -minus) * M_PI * M_PI / (8 * d.inertia * w_b * w_b);
        sd_drive drive = turning(SD_PARABOLA, strength * weakest, 0);
        drive.support_radius[0] = drive.support_radius[1] = d.radius;
        sd_sliding out;
        sd_sync s = sd_sync_parabola(&d, strength * weakest, w_b);
        assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
        assert_true(out.permanent && s.permanent);
        /* t1 lies before t = 0, in the half period in which the support's velocity falls */
        assert_int_equal(out.n_pieces, 3);
        near(out.pieces[1].start, s.t2, 1e-12, "t2");
        near(out.pieces[2].start, s.t1 + out.period, 1e-12, "t1");
        assert_int_equal(out.pieces[1].sign[0], 1);
        assert_int_equal(out.pieces[2].sign[0], -1);
        double scale = strength * weakest * w_b;
        for (double t = s.t1; t < s.t1 + out.period; t += out.period / 57) {
          double from = t < s.t2 ? s.t1 : s.t2, torque = t < s.t2 ? minus : plus;
          double omega = sd_sliding_support(&d, &drive, 0, from) + torque * (t - from) / d.inertia;
          near(sd_sliding_omega(&out, t), omega, 1e-11 * scale, "(28)");
        }
        drive.amplitude[0] = drive.amplitude[1] = weakest / strength;
        assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
        assert_false(out.permanent || sd_sync_parabola(&d, weakest / strength, w_b).permanent);
      }
}

/* The cycle of (32)-(34), S-- S-+ S++ S+-, is that of a weak drive; of a strong one it is S++ S+- S++ S-+.
 * At small tilt they meet where T++/(I slope) = mu cot theta_h, the slope being that of the supports' velocity. */
static void cycle_of_supports_in_opposite_phases(void **unused) {
  for (double half = 0.3; half < 1.3; half += 0.2)
    for (double mu = 0.02; mu < 0.25; mu *= 2)
      for (int weak = 0; weak < 2; weak++) {
        sd_three_disk d = {1e-6, half, mu, 2, 0.8, 0.3};
        double border =
            sd_tep_torque(&d, 1, 1) * M_PI * M_PI / (8 * d.inertia * w_b * w_b) * tan(half) / mu;
        double amplitude = border * (weak ? 0.99 : 1.01);
        sd_drive drive = turning(SD_PARABOLA, amplitude, M_PI);
        drive.support_radius[0] = drive.support_radius[1] = d.radius;
        sd_sliding out;
        assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
        assert_true(out.permanent);
        /* from t = 0, support 1 at its least: S-+, around a quarter period S++, then S+-, the other crossing, S-+ */
        assert_int_equal(out.n_pieces, 5);
        const int expected[5][2] = {
            {-1, 1}, {1, 1}, {1, -1}, {weak ? -1 : 1, weak ? -1 : 1}, {-1, 1}};
        /* support met at the corner before: (32), (33) for the weak drive */
        const int met[5] = {-1, 0, 1, weak ? 0 : 1, weak ? 1 : 0};
        for (int k = 0; k < 5; k++) {
          const sd_sliding_piece *p = &out.pieces[k];
          assert_memory_equal(p->sign, expected[k], sizeof expected[k]);
          near(p->acceleration, sd_tep_torque(&d, p->sign[0], p->sign[1]) / d.inertia, 1e-12,
               "(34)");
          if (met[k] < 0) continue;
          near(p->omega, sd_sliding_support(&d, &drive, met[k], p->start), 1e-12 * amplitude * w_b,
               "(32), (33)");
        }
        assert_true((out.duration[SD_MM] > 0) == weak);
      }
}

/* (35) is the slope at zero tilt in both cycles, whatever the drive; for the sine it is pi^2/8 of this. Without tilt the
 * durations depend, for strong drive, on the phase alone. */
static void small_tilt_whatever_the_drive(void **unused) {
  sd_sliding out;
  for (double tilt = 1e-4; tilt > 5e-7;
       tilt /= 10) /* what is left is of the next order in the tilt */
    for (double half = 0.3; half < 1.3; half += 0.3)
      for (double mu = 0.02; mu < 0.25; mu *= 3)
        for (double ratio = 0.7; ratio > 1e-3; ratio /= 3) { /* torque/(I slope) */
          for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++) {
            sd_three_disk d = {tilt, half, mu, 2, 0.8, 0.3};
            double slope = shape == SD_SINE ? 1 : 8 / (M_PI * M_PI);
            double amplitude = sd_tep_torque(&d, 1, 1) / (ratio * slope * d.inertia * w_b * w_b);
            sd_drive drive = turning((sd_waveform)shape, amplitude, M_PI);
            drive.support_radius[0] = drive.support_radius[1] = d.radius;
            assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
            assert_true(out.permanent);
            double first =
                sd_async_first_order(&d, amplitude, w_b) * (shape == SD_SINE ? M_PI * M_PI / 8 : 1);
            near(out.mean / first, 1, 10 * tilt, "slope");
          }
        }
  for (double phase = 0; phase <= M_PI; phase += M_PI / 8) {
    sd_three_disk d = paper(0);
    sd_drive drive = turning(SD_SINE, 40, phase);
    assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
    for (int k = 0; k < 4; k++) {
      double part = k == SD_PP || k == SD_MM ? (1 - phase / M_PI) / 2 : phase / (2 * M_PI);
      near(out.duration[k], part * out.period, 2e-6 * out.period, "no tilt");
    }
  }
}

/* Direct integration of I dOmega/dt = T(signs) by Euler steps, from rest to the periodic state. */
static double integrated(const sd_three_disk *d, const sd_drive *drive, int periods,
                         double duration[4]) {
  enum { STEPS = 20000 };
  double torque[4], omega = 0, dt = 2 * M_PI / drive->omega / STEPS, sum = 0;
  for (int k = 0; k < 4; k++) torque[k] = sd_tep_solve(d, signs[k][0], signs[k][1]).torque;
  for (int p = 0; p < periods; p++) {
    sum = 0;
    for (int k = 0; k < 4; k++) duration[k] = 0;
    for (int n = 0; n < STEPS; n++) {
      double t = (n + 0.5) * dt, support[2];
      for (int i = 0; i < 2; i++) {
        double v = drive->omega * t + drive->phase[i], r = remainder(v, 2 * M_PI);
        double rate = drive->waveform == SD_SINE ? cos(v) : 4 / M_PI * (1 - 2 * fabs(r) / M_PI);
        support[i] =
            -drive->amplitude[i] * drive->omega * rate * drive->support_radius[i] / d->radius;
      }
      int k = 2 * (support[0] < omega) + (support[1] < omega);
      omega += torque[k] / d->inertia * dt / 2;
      sum += omega * dt;
      omega += torque[k] / d->inertia * dt / 2;
      duration[k] += dt;
    }
  }
  return sum / (2 * M_PI / drive->omega);
}

static void periodic_solution_is_where_time_stepping_ends(void **unused) {
  const double phases[] = {0, 1.1, M_PI};
  for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++)
    for (int p = 0; p < 3; p++) {
      sd_three_disk d = paper(0.07 * M_PI);
      sd_drive drive = turning((sd_waveform)shape, 2e-3, phases[p]);
      sd_sliding out;
      double duration[4];
      assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
      double mean = integrated(&d, &drive, 80, duration), scale = 2e-3 * w_b;
      print_message("  %s phase %.3f: Omega/(Theta_b w_b) = %.6f, stepped %.6f; stuck %.3f\n",
                    shape == SD_SINE ? "sine" : "parabola", phases[p], out.mean / scale,
                    mean / scale, out.stuck / out.period);
      assert_true(out.permanent);
      near(mean, out.mean, 2e-4 * scale, "mean");
      for (int k = 0; k < 4; k++) near(duration[k], out.duration[k], 2e-4 * out.period, "duration");
    }
}

static void weak_and_uneven_drives_stick_as_time_stepping_does(void **unused) {
  int sticking = 0;
  for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++)
    for (double amplitude = 1e-4; amplitude < 1.3e-3; amplitude *= 1.6)
      for (double phase = 0; phase < 6.3; phase += 0.5) {
        sd_three_disk d = paper(0.07 * M_PI);
        sd_drive drive = turning((sd_waveform)shape, amplitude, phase);
        drive.amplitude[1] *= 0.8;
        drive.support_radius[0] = 1.1;
        sd_sliding out;
        double duration[4], scale = amplitude * w_b;
        assert_int_equal(sd_sliding_solve(&d, &drive, &out, NULL), SD_OK);
        if (!out.permanent) sticking++;
        near(integrated(&d, &drive, 15, duration), out.mean, 1.5e-3 * scale, "mean with sticking");
      }
  assert_true(sticking > 20);
  print_message("  %d of 156 drives stick at times\n", sticking);
}

static void solution_is_consistent_and_symmetric(void **unused) {
  for (int shape = SD_SINE; shape <= SD_PARABOLA; shape++)
    for (double phase = 0; phase < 2 * M_PI; phase += 0.1)
      for (double amplitude = 1e-4; amplitude < 1; amplitude *= 5) {
        sd_three_disk d = paper(0.04 * M_PI), mirror = paper(-0.04 * M_PI), upright = paper(0);
        sd_drive drive = turning((sd_waveform)shape, amplitude, phase);
        sd_sliding a, b, c;
        double scale = amplitude * w_b, limit;
        assert_int_equal(sd_sliding_solve(&d, &drive, &a, NULL), SD_OK);
        assert_int_equal(sd_sliding_solve(&upright, &drive, &c, NULL), SD_OK);
        assert_int_equal(sd_sliding_limit(&d, &drive, &limit, NULL), SD_OK);
        drive.phase[0] = phase + M_PI;
        drive.phase[1] = M_PI;
        assert_int_equal(sd_sliding_solve(&mirror, &drive, &b, NULL), SD_OK);
        near(b.mean, -a.mean, 1e-9 * scale, "mirror image");
        near(c.mean, 0, 1e-9 * scale, "no tilt");
        if (amplitude > 0.05) near(a.mean, limit, 0.01 * scale, "limit of strong drive");
        double sum = a.stuck, impulse = 0, turned = 0;
        for (int k = 0; k < 4; k++) {
          sum += a.duration[k];
          impulse += a.duration[k] * sd_tep_torque(&d, signs[k][0], signs[k][1]);
        }
        near(sum, a.period, 1e-12 * a.period, "durations");
        if (a.permanent) near(impulse, 0, 1e-12 * a.period, "torques cancel (41)");
        enum { POINTS = 2000 };
        for (int k = 0; k < POINTS; k++)
          turned += sd_sliding_omega(&a, (k + 0.5) / POINTS * a.period) / POINTS;
        near(turned, a.mean, 2e-6 * scale, "mean of Omega(t)");
        for (size_t k = 0; k < a.n_pieces; k++) {
          double t = a.pieces[k].start, jump = sd_sliding_omega(&a, t + 1e-9 * a.period) -
                                               sd_sliding_omega(&a, t - 1e-9 * a.period);
          near(jump, 0, 1e-7 * scale, "Omega is continuous");
        }
      }
}

/* Kick-drift-kick would do for no damping; with it, classical Runge-Kutta to the cutoff. */
static sd_collision collided(double k, double gamma, double m) {
  double x = 0, v = 1, t = 0, h = 2e-5 / (sqrt(k / m) + gamma / m);
  for (;;) {
    double kx[4], kv[4];
    for (int s = 0; s < 4; s++) {
      double part = s == 0 ? 0 : s == 3 ? h : h / 2;
      double xs = x + (s ? part * kx[s - 1] : 0), vs = v + (s ? part * kv[s - 1] : 0);
      kx[s] = vs;
      kv[s] = -(k * xs + gamma * vs) / m;
    }
    double xn = x + h / 6 * (kx[0] + 2 * kx[1] + 2 * kx[2] + kx[3]);
    double vn = v + h / 6 * (kv[0] + 2 * kv[1] + 2 * kv[2] + kv[3]);
    double force = k * x + gamma * v, next = k * xn + gamma * vn;
    if (next <= 0 && t > 0) {
      double part = force / (force - next);
      return (sd_collision){-(v + part * (vn - v)), t + part * h};
    }
    x = xn, v = vn, t += h;
  }
}

static void restitution_against_integration(void **unused) {
  const double damping[] = {0, 0.1, 0.5, 0.7, 0.75, 0.9, 1, 1.1, 1.3, 2}; /* of critical */
  for (size_t i = 0; i < sizeof damping / sizeof *damping; i++) {
    double k = 1000, m = 0.1, gamma = damping[i] * 2 * sqrt(k * m);
    sd_collision a = sd_restitution(k, gamma, m), b = collided(k, gamma, m);
    near(a.restitution, b.restitution, 1e-8, "restitution");
    near(a.duration, b.duration, 1e-8, "duration");
  }
  near(sd_restitution(1000, 0, 0.1).duration, M_PI * sqrt(0.1 / 1000), 1e-16, "half a sine");
  near(sd_restitution(1000, 20, 0.1).restitution, exp(-2), 1e-15, "critical");
  near(sd_restitution(1000, 20 * (1 + 1e-9), 0.1).restitution, exp(-2), 1e-8,
       "just above critical");
  near(sd_restitution(1000, 20 * (1 - 1e-9), 0.1).restitution, exp(-2), 1e-8,
       "just below critical");
  /* strong damping: v/b -> 1, b t_c -> 2 ln(2 b/w0) */
  near(sd_restitution(1, 2e6, 1).restitution * 4e12, 1, 1e-9, "strong damping");
}

static void sliding_collisions_and_rolling(void **unused) {
  double m = 2, r = 0.5, inertia = m * r * r / 2, mu = 0.2, e = 0.8;
  sd_oblique a = sd_gross_sliding(m, inertia, r, mu, e, 1.5, 4, 0);
  near(a.v_t, 4 - mu * (1 + e) * 1.5, 1e-14, "v_t");
  near(fabs(r * a.spin), 2 * mu * (1 + e) * 1.5, 1e-14, "R spin");
  near(a.v_n, 1.2, 1e-14, "v_n");
  assert_true(a.sliding);
  assert_false(sd_gross_sliding(m, inertia, r, mu, e, 1.5, 1, 0).sliding);
  sd_oblique b = sd_gross_sliding(m, inertia, r, mu, e, 1.5, -4, 0);
  near(b.v_t, -a.v_t, 1e-14, "other way");
  near(b.spin, -a.spin, 1e-14, "other way");
  double time, speed;
  sd_slide_to_roll(m, inertia, r, mu, 10, 3, &time, &speed);
  near(speed, 2, 1e-14, "2 u/3");
  near(time, 3 / (3 * mu * 10), 1e-14, "u/(3 mu g)");
}

typedef struct spectrum {
  double w, c;
  int power;
} spectrum;

static double density(double nu, void *argument) {
  const spectrum *s = argument;
  double a = s->w * s->w - nu * nu, b = 2 * s->c * s->w * nu;
  return 4 * s->c * pow(s->w, 3) / (a * a + b * b) * pow(nu, s->power) / M_PI;
}

static void vibration_covariance_is_the_transform_of_its_spectrum(void **unused) {
  const double dampings[] = {0.2, 0.5, 0.999999, 1, 1.000001, 3};
  gsl_integration_workspace *w1 = gsl_integration_workspace_alloc(1000);
  gsl_integration_workspace *w2 = gsl_integration_workspace_alloc(1000);
  gsl_integration_qawo_table *table = gsl_integration_qawo_table_alloc(1, 1, GSL_INTEG_COSINE, 100);
  for (size_t i = 0; i < 6; i++)
    for (double lag = 0.3; lag < 4; lag += 0.8) {
      spectrum s = {.w = 2, .c = dampings[i]};
      double c[3], got, error;
      sd_vibration_covariance(s.w, s.c, 1, lag, c);
      gsl_function f = {density, &s};
      gsl_integration_qawo_table_set(table, lag, 1, GSL_INTEG_COSINE);
      gsl_integration_qawf(&f, 0, 1e-9, 1000, w1, w2, table, &got, &error);
      near(c[0], got, 1e-8, "<x x>");
      s.power = 2;
      gsl_integration_qawf(&f, 0, 1e-9, 1000, w1, w2, table, &got, &error);
      near(c[2], got, 1e-7, "<x' x'>");
      s.power = 1;
      gsl_integration_qawo_table_set(table, lag, 1, GSL_INTEG_SINE);
      gsl_integration_qawf(&f, 0, 1e-9, 1000, w1, w2, table, &got, &error);
      near(c[1], -got, 1e-8, "<x x'>");
    }
  gsl_integration_qawo_table_free(table);
  gsl_integration_workspace_free(w1);
  gsl_integration_workspace_free(w2);

  double c[3];
  sd_vibration_covariance(20 * M_PI, 0.5, 1e-4, 0, c);
  near(c[0], 1e-8, 1e-22, "<x x>(0)");
  near(c[1], 0, 0, "<x x'>(0)");
  near(c[2], 400 * M_PI * M_PI * 1e-8, 1e-18, "<x' x'>(0)");
  sd_vibration_covariance(1, 50, 1, 1e5, c);
  assert_true(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]));
}

RUN_TESTS(TEST(tep_closed_forms_solve_the_force_balance), TEST(tep_matches_the_printed_formulas),
          TEST(wedge_is_refused), TEST(sync_parabola_is_exact),
          TEST(sync_sine_closed_form_and_limit), TEST(async_small_tilt_slope),
          TEST(parabola_and_its_velocity_are_the_print),
          TEST(transition_times_of_supports_in_phase), TEST(cycle_of_supports_in_opposite_phases),
          TEST(small_tilt_whatever_the_drive), TEST(periodic_solution_is_where_time_stepping_ends),
          TEST(weak_and_uneven_drives_stick_as_time_stepping_does),
          TEST(solution_is_consistent_and_symmetric), TEST(restitution_against_integration),
          TEST(sliding_collisions_and_rolling),
          TEST(vibration_covariance_is_the_transform_of_its_spectrum))
