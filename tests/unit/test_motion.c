/* test_motion.c: prescribed motions against their formulas in extended precision, phases, sums, ramps, locks,
 * and the elasto-plastic oscillator. */
#include "brief.h"
#include "deck_runs.h"
#include "model/model.h"
#include "model/motions.h"

#define DT 0x1p-12 /* a power of 2: step * DT is exact */

typedef struct value {
  long double u, v;
} value;

/* A driven disk and two walls, all moved by the same entries; DISKS names the bodies of a motion. */
#define BODIES "disk = \"d\"; wall = [\"line\", \"ring\"];"
static sd_model *driven(double theta, const char *moves, const char *phases) {
  text t = {0};
  text_add(&t, "dt = %.17g; materials = ( { name = \"m\"; k_n = 1e3; } );\n", DT);
  text_add(&t,
           "disks = ( { name = \"d\"; x = 0; y = 0; theta = %.17g; radius = 1; mass = 1; fixed = "
           "true; } );\n",
           theta);
  text_add(&t, "walls = ( { name = \"line\"; type = \"line\"; pivot = (0, 0); points = ((500, 90), "
               "(501, 90)); },"
               "{ name = \"ring\"; type = \"circle\"; center = (0, 0); radius = 900; side = "
               "\"inside\"; } );\n");
  text_add(&t, "motions = ( %s );\n %s\n", moves, phases);
  return model_of_text(&t);
}

static value measured(const sd_state *s, size_t i, int c) {
  if (c == SD_X) return (value){s->x[i], s->vx[i]};
  if (c == SD_Y) return (value){s->y[i], s->vy[i]};
  return (value){(long double)s->turn[i] + s->theta[i], s->omega[i]};
}

/* Compares every body's coordinate at every step with f(t); errors relative to the scales. */
static void compare(const char *name, const char *moves, int coordinate, double theta, int steps,
                    double u_scale, double v_scale, double bound, value (*f)(long double t)) {
  sd_model *model = driven(theta, moves, "steps = 1000000000;");
  sd_simulation *sim = begin_run(model, 1);
  double worst_u = 0.0, worst_v = 0.0;
  for (int k = 1; k <= steps; k++) {
    advance(sim, 1);
    value exact = f((long double)DT * k);
    for (size_t i = 0; i < 3; i++) {
      value now = measured(engine_of(sim)->state, i, coordinate);
      if (coordinate == SD_THETA && i == 0) now.u -= theta;
      worst_u = fmax(worst_u, (double)fabsl(now.u - exact.u) / u_scale);
      worst_v = fmax(worst_v, (double)fabsl(now.v - exact.v) / v_scale);
    }
  }
  print_message("  %-34s relative errors: u %.2g, u' %.2g\n", name, worst_u, worst_v);
  between(worst_u, 0, bound, name);
  between(worst_v, 0, bound, name);
  end_run(sim, model);
}

#define W 62.8L
#define A 0.125L
#define PHI 0.7L
static value velocity(long double t) { return (value){(long double)3.7 * t, 3.7}; }
static value harmonic(long double t) {
  long double p = (long double)62.8 * t + (long double)0.7;
  return (value){A * sinl(p), A * (long double)62.8 * cosl(p)};
}
static value parabolic(long double t) { /* eq. 21, 22 */
  const long double pi = acosl(-1.0L), w = 62.8;
  long double p = w * t + (long double)0.7, z = (p - 2 * pi * nearbyintl(p / (2 * pi))) / pi,
              s = z < 0 ? 1 : -1;
  return (value){4 * A * (s * z * z + z), 4 * A * w / pi * (2 * s * z + 1)};
}
static value sum(long double t) {
  value a = velocity(t), b = harmonic(t), c = parabolic(t);
  return (value){a.u + b.u + c.u, a.v + b.v + c.v};
}
static value ramped(long double t, value f, long double ramp) {
  long double s = t / ramp;
  if (s >= 1) return f;
  long double r = s * s * s * (10 - 15 * s + 6 * s * s), dr = 30 * s * s * (1 - s) * (1 - s) / ramp;
  return (value){f.u * r, f.v * r + f.u * dr};
}
static value ramped_harmonic(long double t) { return ramped(t, harmonic(t), 0.5L); }
static value ramped_velocity(long double t) { return ramped(t, velocity(t), 0.5L); }
static value ramped_sum(long double t) {
  value a = ramped_velocity(t), b = harmonic(t);
  return (value){a.u + b.u, a.v + b.v};
}

#define VELOCITY "type = \"velocity\"; velocity = 3.7;"
#define HARMONIC "type = \"harmonic\"; amplitude = 0.125; omega = 62.8; phase = 0.7;"
#define PARABOLIC "type = \"parabolic\"; amplitude = 0.125; omega = 62.8; phase = 0.7;"
#define ON(c) "{ " BODIES " coordinate = \"" c "\"; "

static void signals_follow_their_formulas(void **unused) {
  enum { N = 10000 };
  double speed = (double)(A * W);
  compare("velocity x", ON("x") VELOCITY "}", SD_X, 0, N, 10, 3.7, 1e-15, velocity);
  compare("velocity theta", ON("theta") VELOCITY "}", SD_THETA, 0.3, N, 10, 3.7, 1e-15, velocity);
  /* the phase, in turns of up to 24, is known to 2^-53 times that */
  compare("harmonic y", ON("y") HARMONIC "}", SD_Y, 0, N, 0.125, speed, 3e-14, harmonic);
  compare("harmonic theta", ON("theta") HARMONIC "}", SD_THETA, 3.9, N, 0.125, speed, 3e-14,
          harmonic);
  compare("parabolic x", ON("x") PARABOLIC "}", SD_X, 0, N, 0.125, speed, 3e-14, parabolic);
  compare("parabolic theta", ON("theta") PARABOLIC "}", SD_THETA, 0, N, 0.125, speed, 3e-14,
          parabolic);
  compare("sum of three, y", ON("y") VELOCITY "}," ON("y") HARMONIC "}," ON("y") PARABOLIC "}",
          SD_Y, 0, N, 10, 2.3 * speed, 3e-14, sum);
  compare("sum of three, theta",
          ON("theta") VELOCITY "}," ON("theta") HARMONIC "}," ON("theta") PARABOLIC "}", SD_THETA,
          0, N, 10, 2.3 * speed, 3e-14, sum);
  compare("ramped harmonic x", ON("x") HARMONIC "ramp = 0.5; }", SD_X, 0, N, 0.125, speed, 3e-14,
          ramped_harmonic);
  compare("ramped velocity theta", ON("theta") VELOCITY "ramp = 0.5; }", SD_THETA, 0, N, 10, 3.7,
          1e-15, ramped_velocity);
  compare("ramped and not", ON("theta") VELOCITY "ramp = 0.5; }," ON("theta") HARMONIC "}",
          SD_THETA, 0, N, 10, speed, 3e-14, ramped_sum);
}

/* Of every smooth signal: u' against the difference of u of sixth order, over the ends of ramps, batches and
 * table knots, where third derivatives jump, and those of random draws, where accelerations do. */
static void velocity_is_the_derivative(void **unused) {
  const char *const decks[] = {
      ON("x") HARMONIC "}",
      ON("x") HARMONIC "ramp = 0.3; }",
      ON("x") VELOCITY "ramp = 0.7; }," ON("x") HARMONIC "ramp = 0.1; }",
      ON("theta") "type = \"table\"; times = (0, 0.1, 0.25, 0.3, 1.2); values = (0, 1, -1, 2, "
                  "1.5); factor = 0.3; }",
      ON("theta") "type = \"table\"; times = (0, 0.1, 0.25, 0.3); values = (1, 1.2, -1, 1); "
                  "periodic = true; ramp = 0.2; }",
      ON("x") "type = \"random\"; amplitude = 0.1; omega = 10; interval = 128; ramp = 0.5; }",
  };
  for (size_t d = 0; d < sizeof decks / sizeof *decks; d++) {
    sd_model *model = driven(0, decks[d], "steps = 1000000;");
    sd_simulation *sim = begin_run(model, 1);
    enum { N = 4200 };
    static double u[N], v[N];
    double worst = 0.0, jump = 0.0, speed = 0.0;
    int rough = 0;
    for (int k = 0; k < N; k++) {
      advance(sim, 1);
      value now = measured(engine_of(sim)->state, 0, model->motions[0].coordinate);
      u[k] = (double)now.u;
      v[k] = (double)now.v;
      speed = fmax(speed, fabs(v[k]));
    }
    for (int k = 3; k + 3 < N; k++) {
      double d6 = (45 * (u[k + 1] - u[k - 1]) - 9 * (u[k + 2] - u[k - 2]) + (u[k + 3] - u[k - 3])) /
                  (60 * DT);
      double error = fabs(d6 - v[k]) / speed;
      jump = fmax(jump, fabs(v[k + 1] - v[k]) / speed);
      if (error > 3e-10) /* within three steps of a knot */
        rough++;
      else
        worst = fmax(worst, error);
      between(error, 0, d < 5 ? 1e-4 : 0.01, "u' against the difference of u, next to a knot");
    }
    print_message("  signal %zu: u' off by %.2g of the largest, %d steps next to knots, largest "
                  "change %.3g\n",
                  d, worst, rough, jump);
    between(rough, 0,
            d < 2    ? 6
            : d == 2 ? 12
            : d == 3 ? 6 * 5
            : d == 4 ? 6 * 12
                     : 6 * 34,
            "steps next to knots");
    between(jump, 0, 0.05, "change of u' in one step");
    end_run(sim, model);
  }
}

enum { KNOTS = 6 };
static const double knot_t[KNOTS] = {0.1, 0.35, 0.5, 0.9, 1.0, 1.4},
                    knot_u[KNOTS] = {0.2, 1, -0.5, 0.3, 0.4, -1};

/* Natural cubic spline in extended precision: second derivatives by elimination. */
static value natural_spline(long double t) {
  long double m[KNOTS] = {0}, d[KNOTS] = {0}, r[KNOTS] = {0};
  if (t < knot_t[0]) return (value){knot_u[0], 0};
  if (t > knot_t[KNOTS - 1]) return (value){knot_u[KNOTS - 1], 0};
  for (int k = 1; k < KNOTS - 1; k++) {
    long double a = (long double)knot_t[k] - knot_t[k - 1],
                b = (long double)knot_t[k + 1] - knot_t[k];
    d[k] = 2 * (a + b);
    r[k] = 6 * (((long double)knot_u[k + 1] - knot_u[k]) / b -
                ((long double)knot_u[k] - knot_u[k - 1]) / a);
    if (k > 1) {
      d[k] -= a * a / d[k - 1];
      r[k] -= a * r[k - 1] / d[k - 1];
    }
  }
  for (int k = KNOTS - 2; k > 0; k--)
    m[k] = (r[k] - ((long double)knot_t[k + 1] - knot_t[k]) * m[k + 1]) / d[k];
  int k = 0;
  while (k < KNOTS - 2 && t > knot_t[k + 1]) k++;
  long double h = (long double)knot_t[k + 1] - knot_t[k], x = (t - knot_t[k]) / h, y = 1 - x;
  long double u = y * knot_u[k] + x * knot_u[k + 1] +
                  h * h / 6 * ((y * y * y - y) * m[k] + (x * x * x - x) * m[k + 1]);
  long double v = ((long double)knot_u[k + 1] - knot_u[k]) / h +
                  h / 6 * ((3 * x * x - 1) * m[k + 1] - (3 * y * y - 1) * m[k]);
  return (value){u, v};
}

#define TABLE                                                                                      \
  "type = \"table\"; times = (0.1, 0.35, 0.5, 0.9, 1.0, 1.4); values = (0.2, 1, -0.5, 0.3, 0.4, "  \
  "-1);"

static void tables_are_natural_splines(void **unused) {
  compare("table x", ON("x") TABLE "}", SD_X, 0, 8000, 1, 10, 1e-15, natural_spline);
  compare("table theta", ON("theta") TABLE "}", SD_THETA, 1, 8000, 1, 10, 1e-15, natural_spline);
}

/* A table that repeats: the same in every period, also where step * dt falls on the end of one, for any length. */
static void periodic_tables_repeat(void **unused) {
  for (int steps = 10; steps < 60; steps++) {
    text t = {0};
    double dt = 1e-4, span = steps * dt; /* whole steps, though not to the last bit */
    text_add(&t, "dt = %.17g; materials = ( { name = \"m\"; k_n = 1; } ); steps = 1000000;\n", dt);
    text_add(&t, "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n");
    text_add(&t,
             "motions = ( { disk = 0; coordinate = \"x\"; type = \"table\"; periodic = true;"
             "times = (%.17g, %.17g, %.17g, %.17g); values = (0, 1, -1, 0); } );\n",
             0.003, 0.003 + span * 0.25, 0.003 + span * 0.75, 0.003 + span);
    sd_model *model = model_of(t.s);
    sd_simulation *sim = begin_run(model, 1);
    double u[60], v[60], worst = 0.0, speed = 4 / span;
    for (int k = 0; k < 40 * steps; k++) {
      advance(sim, 1);
      const sd_state *s = engine_of(sim)->state;
      if (k >= steps)
        worst = fmax(worst, fabs(s->x[0] - u[k % steps]) + fabs(s->vx[0] - v[k % steps]) / speed);
      u[k % steps] = s->x[0];
      v[k % steps] = s->vx[0];
    }
    between(worst, 0, 1e-9, "difference between two periods of a table");
    end_run(sim, model);
    free(t.s);
  }
}

static void angles_stay_exact_beyond_1e4_rad(void **unused) {
  const double rates[] = {987.654321, -1234.5678};
  for (int r = 0; r < 2; r++) {
    text t = {0};
    text_add(&t, ON("theta") "type = \"velocity\"; velocity = %.17g; }", rates[r]);
    sd_model *model = driven(0.3, t.s, "steps = 10000000;");
    sd_simulation *sim = begin_run(model, 1);
    double worst = 0.0, range = 0.0, most = 0.0;
    for (int k = 1; k <= 200; k++) {
      advance(sim, 1000);
      const sd_state *s = engine_of(sim)->state;
      for (size_t i = 0; i < 3; i++) {
        /* in two parts, since an angle of this size leaves 1e-15 of a long double */
        double per_step = rates[r] * DT, high = (float)per_step;
        long double exact = ((long double)high * (1000 * k) - s->turn[i]) +
                            (long double)(per_step - high) * (1000 * k);
        worst = fmax(worst, (double)fabsl(exact + (i == 0 ? 0.3 : 0.0) - s->theta[i]));
        range = fmax(range, fabs(s->theta[i]));
        most = fmax(most, fabs(s->turn[i]));
        assert_true(s->turn[i] == 8 * nearbyint(s->turn[i] / 8));
      }
    }
    print_message("  after %.0f rad: off by %.2g\n", most, worst);
    assert_true(most > 3e4);
    between(range, 0, 4.5, "range of theta");
    between(worst, 0, 2e-15, "error of the angle");
    end_run(sim, model);
    free(t.s);
  }
}

/* On, off, on again: it stays where it was, and begins anew from there. Another motion goes on all the time. */
static void phases_switch_motions(void **unused) {
  const char *coordinates[] = {"x", "theta"};
  for (int c = 0; c < 2; c++) {
    text t = {0};
    text_add(&t, "{ name = \"a\"; " BODIES " coordinate = \"%s\"; " HARMONIC " },", coordinates[c]);
    text_add(&t, "{ name = \"b\"; " BODIES " coordinate = \"%s\"; " VELOCITY " }", coordinates[c]);
    sd_model *model = driven(
        0, t.s,
        "phases = ( { steps = 1000; motions = [\"a\"]; }, { steps = 777; motions = []; },"
        "{ steps = 900; }, { steps = 500; motions = [\"b\"]; }, { steps = 100; motions = []; } );");
    sd_simulation *sim = begin_run(model, 1);
    int coordinate = c ? SD_THETA : SD_X;
    value at = {0, 0}, before = {0, 0};
    for (int k = 1; k <= 3277; k++) {
      advance(sim, 1);
      value expected;
      long double first = harmonic(1000 * (long double)DT).u;
      if (k < 1000)
        expected = harmonic(k * (long double)DT);
      else if (k <= 1777)
        expected = (value){first, 0};
      else if (k < 2677) {
        long double s = (k - 1777) * (long double)DT;
        expected = (value){first + harmonic(s).u + velocity(s).u, harmonic(s).v + velocity(s).v};
      } else { /* a is left where it was after 900 steps, b goes on */
        long double s = (k < 3177 ? k - 1777 : 3177 - 1777) * (long double)DT;
        expected =
            (value){first + harmonic(900 * (long double)DT).u + velocity(s).u, k < 3177 ? 3.7L : 0};
      }
      for (size_t i = 0; i < 3; i++) {
        at = measured(engine_of(sim)->state, i, coordinate);
        between((double)(at.u - expected.u), -3e-14, 3e-14, "displacement over phases");
        /* after the last step of a phase what is switched off has no velocity any more */
        if (k != 2677) between((double)(at.v - expected.v), -3e-13, 3e-13, "velocity over phases");
      }
      if (k > 1 && k != 1001 && k != 1778) /* harmonic begins at A sin(phi) */
        between((double)(at.u - before.u), -0.01, 0.01, "jump of the displacement");
      before = at;
    }
    assert_true(sd_simulation_finished(sim));
    end_run(sim, model);
    free(t.s);
  }
}

/* A motion that is on in all phases: the same bits as in one long phase. */
static void motions_go_on_over_phases(void **unused) {
  const char *moves = ON("x") HARMONIC "ramp = 0.2; }," ON("theta") VELOCITY "}," ON("y") TABLE
      "}," ON("y") "type = \"random\"; amplitude = 0.1; omega = 3; interval = 7; independent = "
                   "true; }," ON("x") "type = \"random\"; amplitude = 0.1; omega = 3; }";
  sd_model *one = driven(0, moves, "steps = 4000;");
  sd_model *many =
      driven(0, moves,
             "phases = ( { steps = 1; }, { steps = 62; }, { steps = 64; }, { steps = 1000; },"
             "{ steps = 1; }, { steps = 2872; } );");
  sd_simulation *a = begin_run(one, 1), *b = begin_run(many, 1);
  for (int k = 0; k < 4000; k++) {
    advance(a, 1);
    advance(b, 1);
    const sd_state *s = engine_of(a)->state, *t = engine_of(b)->state;
    const double *x[] = {s->x, s->y, s->theta, s->turn, s->vx, s->vy, s->omega};
    const double *y[] = {t->x, t->y, t->theta, t->turn, t->vx, t->vy, t->omega};
    for (int i = 0; i < 7; i++) assert_memory_equal(x[i], y[i], 3 * sizeof(double));
  }
  assert_true(sd_simulation_finished(b));
  sd_simulation_free(a);
  end_run(b, one);
  sd_model_free(many);
}

static sd_model *three_free(const char *integrator, const char *first, const char *moves) {
  text t = {0};
  text_add(&t, "dt = 1e-4; integrator = \"%s\"; gravity = { g = 10; };\n", integrator);
  text_add(&t,
           "materials = ( { name = \"m\"; k_n = 1e4; k_t = 1e4; gamma_n = 20; mu = 0.3; } );\n");
  text_add(&t, "disks = ( { name = \"wheel\"; radius = 0.5; mass = 2; %s } );\n", first);
  text_add(&t, "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );\n");
  text_add(&t, "motions = ( %s ); steps = 100000;\n", moves);
  return model_of_text(&t);
}

/* Theta is driven: the centre falls freely, then is dragged along the floor with mu g until it rolls. */
static void a_driven_wheel_pulls_itself_along(void **unused) {
  const char *names[] = {"gear5", "verlet"};
  for (int k = 0; k < 2; k++) {
    const char *spin =
        "{ disk = \"wheel\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 4; }";
    sd_model *model = three_free(names[k], "x = 0; y = 5; vx = 1;", spin);
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, 5000);
    const sd_state *s = engine_of(sim)->state;
    between(s->x[0], 0.5 - 1e-12, 0.5 + 1e-12, "x of a falling wheel");
    between(s->y[0], 5 - 1.25 - 1e-11, 5 - 1.25 + 1e-11, "y of a falling wheel");
    between(s->theta[0] + s->turn[0], 2 - 1e-14, 2 + 1e-14, "angle of a falling wheel");
    end_run(sim, model);

    model = three_free(names[k], "x = 0; y = 0.498;", spin); /* 2 k_n overlap: in equilibrium */
    sim = begin_run(model, 1);
    advance(sim, 4000);
    s = engine_of(sim)->state;
    between(s->vx[0], -1.2 - 2e-3, -1.2 + 2e-3, "speed after 0.4 of sliding: mu g t");
    advance(sim, 10000);
    double ring = 0.3 * 20 / sqrt(1e4 * 2),
           x = s->x[0]; /* the skin keeps ringing: speed mu m g/sqrt(k_t m) */
    between(s->vx[0], -2 - 1.01 * ring, -2 + 1.01 * ring, "speed of rolling");
    advance(sim, 10000);
    s = engine_of(sim)->state;
    between(s->x[0] - x, -2 - 1.3e-3, -2 + 1.3e-3, "way of rolling");
    between(s->theta[0] + s->turn[0], 9.6 - 1e-13, 9.6 + 1e-13, "angle of the wheel");
    sd_energy energy = sd_simulation_energy(sim);
    between(energy.residual / energy.scale, -2e-4, 2e-4, "energy residual/scale of the wheel");
    end_run(sim, model);
  }
}

static void locks_and_forces_hold(void **unused) {
  const char *names[] = {"gear5", "verlet"};
  for (int k = 0; k < 2; k++) {
    sd_model *model = three_free(
        names[k], "x = 0.3; y = 5; force = (3, 20); torque = 0.5; locked = [\"x\"];", "");
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, 10000);
    const sd_state *s = engine_of(sim)->state;
    assert_true(s->x[0] == 0.3 && s->vx[0] == 0.0);
    between(s->y[0], 5 - 1e-11, 5 + 1e-11, "y with a force against gravity");
    between(s->theta[0] + s->turn[0], 1 - 1e-12, 1 + 1e-12, "angle under a torque");
    between(s->omega[0], 2 - 1e-12, 2 + 1e-12, "angular velocity under a torque");
    end_run(sim, model);

    model = three_free(names[k], "x = 0.3; y = 0.49; vx = 2; locked = [\"y\", \"theta\"];", "");
    sim = begin_run(model, 1);
    advance(
        sim,
        1000); /* pressed by k_n 0.01 = 100, mu = 0.3: the skin yields at 30, then 15 of deceleration */
    s = engine_of(sim)->state;
    double w = sqrt(1e4 / 2), yield = asin(0.003 * w / 2) / w,
           v = 2 * cos(w * yield) - 15 * (0.1 - yield);
    assert_true(s->y[0] == 0.49 && s->theta[0] == 0.0 && s->omega[0] == 0.0);
    between(s->vx[0], v - 2e-4, v + 2e-4, "speed of a locked disk that slides");
    end_run(sim, model);
  }
}

/* A disk rides on a floor that passes the edge of the box again and again: nothing happens to it. */
static void a_floor_may_leave_its_periodic_box(void **unused) {
  const double speeds[] = {1.0, -1.0, 1.0};
  for (int c = 0; c < 3; c++) {
    text t = {0};
    text_add(&t,
             "dt = 1e-4; gravity = { g = 10; }; box = { x = (0, 1); y = (-3, 3); periodic = "
             "\"%s\"; };\n",
             c < 2 ? "x" : "xy");
    text_add(&t,
             "materials = ( { name = \"m\"; k_n = 1e4; k_t = 1e4; gamma_n = 20; mu = 0.3; } );\n");
    text_add(&t, "disks = ( { x = 0.3; y = 0.099; vx = %g; radius = 0.1; mass = 1; } );\n",
             speeds[c]);
    text_add(
        &t,
        "walls = ( { name = \"floor\"; type = \"line\"; pivot = (0.25, 0); points = ((0, 0), (1, "
        "0)); } );\n");
    text_add(&t,
             "motions = ( { wall = \"floor\"; coordinate = \"x\"; type = \"velocity\"; velocity "
             "= %g; } ); steps = 100000;\n",
             speeds[c]);
    sd_model *model = model_of(t.s);
    sd_simulation *sim = begin_run(model, 1);
    double torque = 0.0, speed = 0.0;
    for (int k = 0; k < 25000; k++) {
      advance(sim, 1);
      const sd_state *s = engine_of(sim)->state;
      torque = fmax(torque, fabs(s->torque[0]));
      speed = fmax(speed, fabs(s->vx[0] - speeds[c]));
    }
    assert_true(abs(engine_of(sim)->state->image_x[1]) >= 2);
    between(torque, 0, 1e-8, "largest torque on a disk that rides along"); /* k_t times rounding */
    between(speed, 0, 1e-9, "largest change of speed of a disk that rides along");
    end_run(sim, model);
    free(t.s);
  }
}

/* x of the block of a deck that ships, at the end of every period of the shaking from the first one on. */
static void oscillate(const char *path, size_t n, const char *const *overrides, int periods,
                      double *x) {
  sd_model *model = NULL;
  assert_int_equal(sd_deck_load(path, n, overrides, &model, NULL), SD_OK);
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, model->phases[0].steps);
  for (int k = 0; k <= periods; k++) {
    x[k] = engine_of(sim)->state->x[0];
    advance(sim, 10000);
  }
  end_run(sim, model);
}

#define EPO SLIPDISK_SOURCE_DIR "/inputs/epo/"
enum {
  PERIODS = BRIEF(298, 6),
  LAST = BRIEF(40, 6)
}; /* the start is forgotten over pi A w/(2 mu g) = 10 periods */
#define LONGER "dt=1e-5", "phases.rest.steps=5e4", "phases.measure.steps=3e6"

static void is_mirrored(const double *x, const double *mirrored) {
  double worst = 0.0;
  for (int k = 0; k <= PERIODS; k++) worst = fmax(worst, fabs(x[k] + mirrored[k]));
  print_message("  mirror image: off by %.2g\n", worst);
  between(worst, 0, 1e-9, "difference from the mirror image");
}

static void equal_limits_do_not_drift(void **unused) {
  static double x[PERIODS + 1], mirrored[PERIODS + 1];
  const char *mirror[] = {LONGER, "motions.shake.amplitude=-0.01"};
  oscillate(EPO "symmetric.cfg", 3, mirror, PERIODS, x);
  oscillate(EPO "symmetric.cfg", 4, mirror, PERIODS, mirrored);
  double drift = (x[PERIODS] - x[PERIODS - LAST]) / LAST / 0.1;
  print_message("  equal limits: drift %.2g (A w = 0.63); first to last period: %.3g\n", drift,
                x[PERIODS] - x[0]);
  if (BRIEF(1, 0)) between(drift, -1e-9, 1e-9, "drift with equal limits");
  is_mirrored(x, mirrored);
}

/* In the limit A w^2 >> mu g, sliding forward (mu g + a) for a share p of the time and backward (mu g - a) for
 * the rest balances: p = (mu g - a)/(2 mu g), drift = A w cos(pi p). */
static void unequal_limits_drift(void **unused) {
  static double x[PERIODS + 1], mirrored[PERIODS + 1];
  const char *mirror[] = {LONGER, "motions.shake.amplitude=-0.01", "disks.block.force=(-0.02, 0)"};
  oscillate(EPO "asymmetric.cfg", 3, mirror, PERIODS, x);
  oscillate(EPO "asymmetric.cfg", 5, mirror, PERIODS, mirrored);
  double drift = (x[PERIODS] - x[PERIODS - LAST]) / LAST / 0.1,
         limit = 0.01 * 20 * M_PI * cos(0.4 * M_PI);
  print_message("  unequal limits: drift %.6f, limit of strong shaking %.6f\n", drift, limit);
  if (BRIEF(1, 0)) between(drift / limit, 0.98, 1.02, "drift/its limit");
  is_mirrored(x, mirrored);
}

/* The way of a wave in a step is that at its largest speed, but not more than from one end to the
 * other. */
static void strides_end_at_twice_the_amplitude(void **unused) {
  const sd_motion q = {.kind = SD_MOTION_HARMONIC, .amplitude = 0.3, .omega = 5};
  between(motion_stride(&q, 0.1), 0.15 - 1e-15, 0.15 + 1e-15, "short step");
  between(motion_stride(&q, 10), 0.6, 0.6, "long step");
}

RUN_TESTS(TEST(signals_follow_their_formulas), TEST(velocity_is_the_derivative),
          TEST(tables_are_natural_splines), TEST(periodic_tables_repeat),
          TEST(angles_stay_exact_beyond_1e4_rad), TEST(phases_switch_motions),
          TEST(motions_go_on_over_phases), TEST(a_driven_wheel_pulls_itself_along),
          TEST(locks_and_forces_hold), TEST(a_floor_may_leave_its_periodic_box),
          TEST(equal_limits_do_not_drift), TEST(unequal_limits_drift),
          TEST(strides_end_at_twice_the_amplitude))
