/* test_laws_rolling.c: resistance to rolling: rocking in the spring, rolling to rest, slopes, pairs of disks, drums.
 *
 * A disk of mass m and inertia m R^2/2 that rolls has 3 m/2 behind its centre: rocking w^2 = k_r/(3 m/2), slowing down
 * mu_r F_n/(3 m/2).
 */
#include <gsl/gsl_linalg.h>

#include "brief.h"
#include "laws.h"

static const double m = 0.7, R = 0.4, g = 9.81;

/* A disk lies on the floor with its weight, and rolls. */
static sd_simulation *lying(const law *l, sd_integrator integrator, double dt, double speed,
                            double tilt) {
  text t = {0};
  text_add(&t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n",
           dt, system_integrators[integrator]);
  text_add(&t, "gravity = { g = %.17g; tilt = %.17g; }; materials = ( ", g, tilt);
  law_add(&t, "name = \"m\"", l);
  text_add(&t,
           " );\ndisks = ( { x = 0; y = %.17g; radius = %.17g; mass = %.17g; vx = %.17g; omega = "
           "%.17g; } );\n"
           "walls = ( { type = \"line\"; points = ( (-1, 0), (1, 0) ); } );\n",
           R - m * g * cos(tilt) / l->k_n, R, m, speed, -speed / R);
  return laws_begin(&t, false);
}

/* exp(a t) of the linear system of x, R theta, and their rates. */
static void linear_motion(const law *l, double t, double s[4]) {
  double inertia = 0.5 * m;
  double a[16] = {0, 0, t, 0, 0, 0, 0, t}, e[16], from[4] = {s[0], s[1], s[2], s[3]};
  for (int c = 0; c < 2; c++) { /* c = 0: springs, 1: dashpots */
    double tangential = c ? l->gamma_t : l->k_t, rolling = c ? l->gamma_r : l->k_r;
    a[8 + 2 * c] = a[9 + 2 * c] = -t * tangential / m;
    a[12 + 2 * c] = -t * tangential / inertia;
    a[13 + 2 * c] = -t * (tangential + rolling) / inertia;
  }
  gsl_matrix_view from_a = gsl_matrix_view_array(a, 4, 4), to = gsl_matrix_view_array(e, 4, 4);
  assert_int_equal(gsl_linalg_exponential_ss(&from_a.matrix, &to.matrix, GSL_PREC_DOUBLE),
                   GSL_SUCCESS);
  for (int i = 0; i < 4; i++) {
    s[i] = 0;
    for (int j = 0; j < 4; j++) s[i] += e[4 * i + j] * from[j];
  }
}

/* Springs and dashpots that do not give way: matrix exponential; and the period of rocking. */
static void rocking(void **unused) {
  for (int i = 0; i < 2; i++)
    for (int damped = 0; damped < 2; damped++) {
      law l = {.k_n = 1e5, .k_t = 4e4, .mu = 1e3, .k_r = 50, .mu_r = 1e3};
      if (damped) l.gamma_t = 5, l.gamma_r = 1.5;
      const double dt = 2e-6, speed = 0.2, w = sqrt(l.k_r / (1.5 * m));
      sd_simulation *s = lying(&l, (sd_integrator)i, dt, speed, 0);
      double worst = 0, before = 0, zero = 0;
      for (int k = 1; k <= 400; k++) {
        system_advance(s, 1000);
        double at[4] = {0, 0, speed, -speed};
        linear_motion(&l, 1000 * k * dt, at);
        system_body b = system_at(s, 0);
        worst = fmax(worst, fmax(fabs(b.x - at[0]), fabs(R * (double)b.theta - at[1])) * w / speed);
        worst = fmax(worst, fabs(b.vx - at[2]) / speed);
        if (before > 0 && b.x <= 0) zero = 1000 * dt * (k - 1 + before / (before - b.x));
        before = b.x;
        if (zero > 0) break;
      }
      /* b = gamma_r/(3 m): half a period is pi/sqrt(w^2 - b^2) */
      double decay = l.gamma_r / (3 * m), half = M_PI / sqrt(w * w - decay * decay);
      print_message("rocking, %s, %s: error %.1e, half period %.6f, rolling %.6f, residual %.1e\n",
                    system_integrators[i], damped ? "damped" : "not damped", worst, zero, half,
                    laws_residual(s));
      SYSTEM_NEAR(worst, 0, 1e-4, "rocking");
      SYSTEM_NEAR(zero, half, 2e-3 * half, "half a period, without the give of k_t");
      assert_true(laws_residual(s) < 1e-6);
      system_end(s);
    }
}

/* The spring takes the limit after x_1 = mu_r m g/k_r, from where on the disk slows down evenly; it stops, and rocks back. */
static void rolling_to_rest(void **unused) {
  for (int i = 0; i < 2; i++) {
    const law l = {.k_n = 1e6, .k_t = 1e6, .mu = 0.5, .k_r = 500, .mu_r = 0.02};
    const double dt = 4e-6, speed = 0.8, limit = l.mu_r * m * g, mass = 1.5 * m,
                 w = sqrt(l.k_r / mass);
    double x1 = limit / l.k_r, v1 = sqrt(speed * speed - w * w * x1 * x1), slowing = limit / mass;
    double rest = x1 + 0.5 * v1 * v1 / slowing, t1 = asin(w * x1 / speed) / w,
           t = t1 + v1 / slowing;
    sd_simulation *s = lying(&l, (sd_integrator)i, dt, speed, 0);
    double late = 0.6 * t;
    system_advance(s, (int64_t)nearbyint(late / dt));
    late = (double)sd_simulation_step(s) * dt - t1;
    system_body b = system_at(s, 0);
    SYSTEM_NEAR(b.vx, v1 - slowing * late, 1e-4 * speed, "speed after a while");
    SYSTEM_NEAR(b.x, x1 + v1 * late - 0.5 * slowing * late * late, 1e-4 * rest,
                "way after a while");
    SYSTEM_NEAR(R * b.omega, -b.vx, 2e-4 * speed, "it rolls");
    double most = 0, when = 0;
    for (; b.vx > -1e-3 * speed; system_advance(s, 10), b = system_at(s, 0))
      if (b.x > most) most = b.x, when = (double)sd_simulation_step(s) * dt;
    sd_energy e = sd_simulation_energy(s);
    print_message(
        "rolls to rest, %s: way %.6f, expected %.6f, time %.5f, expected %.5f, residual %.1e\n",
        system_integrators[i], most, rest, when, t, laws_residual(s));
    SYSTEM_NEAR(most, rest, 1e-4 * rest, "way");
    SYSTEM_NEAR(when, t, 2e-3 * t, "time");
    SYSTEM_NEAR(e.rolling, limit * (most - x1), 1e-4 * e.rolling, "lost to rolling");
    SYSTEM_NEAR(e.viscous, 0, 1e-12, "lost to viscosity");
    assert_true(laws_residual(s) < 1e-6);
    /* rocks about the place where the spring is free: a limit's length before */
    double low = most;
    for (int k = 0; k < (int)(M_PI / w / dt / 100) + 20; k++) {
      system_advance(s, 100);
      low = fmin(low, system_at(s, 0).x);
    }
    SYSTEM_NEAR(most - low, 2 * x1, 1e-3 * x1, "rocks back");
    system_end(s);
  }
}

/* mu_r keeps it at rest below its angle; above, it rolls with 2/3 g (sin - mu_r cos). */
static void slope(void **unused) {
  const law l = {
      .k_n = 1e6, .k_t = 1e6, .mu = 0.5, .gamma_t = 100, .k_r = 5e3, .gamma_r = 40, .mu_r = 0.1};
  for (int k = -1; k <= 1; k += 2) {
    const double tilt = atan(l.mu_r * (1 + 0.3 * k)), dt = 4e-6;
    sd_simulation *s = lying(&l, SD_VERLET, dt, 0, tilt);
    system_advance(s, 250000);
    system_body b = system_at(s, 0), c;
    system_advance(s, 250000);
    c = system_at(s, 0);
    double expected = k < 0 ? 0 : -2.0 / 3 * g * (sin(tilt) - l.mu_r * cos(tilt));
    SYSTEM_NEAR((c.vx - b.vx) / (250000 * dt), expected, 1e-4 * g * l.mu_r,
                "acceleration on a slope");
    if (k < 0)
      SYSTEM_NEAR(c.x, -m * g * sin(tilt) * (1 / l.k_r + 1 / l.k_t), 1e-3 * m * g * l.mu_r / l.k_r,
                  "leans on the spring");
    assert_true(laws_residual(s) < 1e-6);
    system_end(s);
  }
}

/* Two disks whose centres are held turn against each other. */
static void held_pair(void **unused) {
  for (int sliding = 0; sliding < 2; sliding++)
    for (int i = 0; i < 2; i++) {
      const double ra = 0.5, rb = 0.3, ma = 0.6, mb = 0.2, reduced = ra * rb / (ra + rb),
                   overlap = 1e-3;
      law l = {.k_n = 1e4, .k_r = 300, .mu_r = sliding ? 0.05 : 1e3, .gamma_r = sliding ? 0 : 0.5};
      const double dt = 1e-5, spin = 3, inverse = 2 / (ma * ra * ra) + 2 / (mb * rb * rb);
      text t = {0};
      text_add(
          &t,
          "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n",
          dt, system_integrators[i]);
      text_add(&t, "materials = ( ");
      law_add(&t, "name = \"m\"", &l);
      text_add(&t,
               " );\ndisks = ( { x = 0; y = 0; radius = %g; mass = %g; locked = (\"x\", \"y\"); "
               "omega = %g; },\n"
               "{ x = %.17g; y = 0; radius = %g; mass = %g; locked = (\"x\", \"y\"); } );\n",
               ra, ma, spin, ra + rb - overlap, rb, mb);
      sd_simulation *s = laws_begin(&t, false);
      /* the difference of the angles: an oscillator of 1/inverse, or a brake; their mean goes on */
      double force = l.mu_r * l.k_n * overlap;
      double b = 0.5 * l.gamma_r * reduced * reduced * inverse,
             w = sqrt(l.k_r * reduced * reduced * inverse - b * b), worst = 0;
      double x1 = force / l.k_r, w0 = sqrt(l.k_r * reduced * reduced * inverse), t1 = 0, v1 = 0;
      if (sliding) {
        t1 = asin(w0 * x1 / (reduced * spin)) / w0;
        v1 = spin * cos(w0 * t1);
      }
      for (int k = 1; k <= 100; k++) {
        system_advance(s, 400);
        double now = 400 * k * dt;
        system_body one = system_at(s, 0), two = system_at(s, 1);
        double difference = spin * exp(-b * now) * (cos(w * now) - b / w * sin(w * now));
        if (sliding)
          difference =
              now < t1 ? spin * cos(w0 * now) : v1 - force * reduced * inverse * (now - t1);
        if (sliding && difference < 0) break;
        worst = fmax(worst, fabs(one.omega - two.omega - difference) / spin);
        /* opposite couples */
        SYSTEM_NEAR(ma * ra * ra * (one.omega - spin) + mb * rb * rb * two.omega, 0, 1e-11,
                    "angular momentum");
      }
      print_message("held pair, %s, %s: error %.1e, residual %.1e\n", sliding ? "slider" : "spring",
                    system_integrators[i], worst, laws_residual(s));
      SYSTEM_NEAR(worst, 0, 1e-4, "difference of the spins");
      assert_true(laws_residual(s) < 1e-6);
      system_end(s);
    }
}

/* Small swings at the bottom of a drum, with R_eff = R R_w/(R_w - R): 3/2 m s'' = -m g s/(R_w - R) - k_r (R_eff/R)^2 s. And
 * a disk on a fixed round top, which k_r holds, with R_eff = R R_b/(R + R_b). */
static void round_walls(void **unused) {
  for (int top = 0; top < 2; top++) {
    const law l = {.k_n = 1e6, .k_t = 1e6, .mu = 10, .k_r = 60, .mu_r = 10};
    const double dt = 4e-6, wall = 1.3, speed = 1e-3, apart = top ? wall + R : wall - R;
    text t = {0};
    text_add(
        &t,
        "dt = %.17g; integrator = \"verlet\"; contact_variant = \"conservative\"; steps = 1e15;\n",
        dt);
    text_add(&t, "gravity = { g = %.17g; }; materials = ( ", g);
    law_add(&t, "name = \"m\"", &l);
    text_add(
        &t,
        " );\ndisks = ( { x = 0; y = %.17g; radius = %.17g; mass = %.17g; vx = %.17g; omega = "
        "%.17g; } );\n"
        "walls = ( { type = \"circle\"; center = (0, 0); radius = %.17g; side = \"%s\"; } );\n",
        (top ? apart : -apart) - m * g / l.k_n, R, m, speed, -speed / R, wall,
        top ? "outside" : "inside");
    sd_simulation *s = laws_begin(&t, false);
    double reduced = R * wall / apart,
           w2 = ((top ? -g : g) / apart + l.k_r / m * pow(reduced / R, 2)) / 1.5;
    double half = M_PI / sqrt(w2), before = 0, zero = 0;
    for (int k = 1; k < 1000000 && !(zero > 0); k++) {
      system_advance(s, 100);
      double x = system_at(s, 0).x;
      if (before > 0 && x <= 0) zero = 100 * dt * (k - 1 + before / (before - x));
      before = x;
    }
    print_message("%s: half a period %.6f, expected %.6f, residual %.1e\n",
                  top ? "round top" : "drum", zero, half, laws_residual(s));
    /* k_t gives way by k_r/k_t, the weight by m g/k_n/R */
    SYSTEM_NEAR(zero, half, 2e-4 * half, "half a period");
    assert_true(laws_residual(s) < 1e-6);
    system_end(s);
  }
}

/* A floor that turns about its pivot takes a disk with it: the rolling spring feels the wall's angle. */
static void turning_floor(void **unused) {
  const law l = {.k_n = 1e4, .k_r = 300, .mu_r = 1e3};
  const double dt = 1e-5, turn = 0.2;
  text t = {0};
  text_add(
      &t,
      "dt = %.17g; integrator = \"verlet\"; contact_variant = \"conservative\"; steps = 1e15;\n",
      dt);
  text_add(&t, "materials = ( ");
  law_add(&t, "name = \"m\"", &l);
  text_add(&t,
           " );\ndisks = ( { x = 0; y = %.17g; radius = %.17g; mass = %.17g; locked = (\"x\", "
           "\"y\"); } );\n"
           "walls = ( { name = \"f\"; type = \"line\"; points = ( (-1, 0), (1, 0) ); pivot = (0, "
           "0); } );\n"
           "motions = ( { wall = \"f\"; coordinate = \"theta\"; type = \"velocity\"; velocity = "
           "%g; } );\n",
           R - 1e-3, R, m, turn);
  sd_simulation *s = laws_begin(&t, false);
  double w = sqrt(l.k_r * 2 / m), worst = 0;
  for (int k = 1; k < 100; k++) {
    system_advance(s, 100);
    worst = fmax(worst, fabs(system_at(s, 0).omega - turn * (1 - cos(w * 100 * k * dt))) / turn);
  }
  SYSTEM_NEAR(worst, 0, 1e-4, "the floor turns the disk");
  assert_true(laws_residual(s) < 1e-6);
  system_end(s);
}

/* Below the critical load of friction the centre of a disk on a floor keeps its velocity, but rolling friction slows down its
 * rotation, by 2 mu_r g/R. */
static void below_critical_load(void **unused) {
  const law l = {
      .k_n = 1e5, .k_t = 4e5, .mu = 0.5, .k_r = 1e4, .mu_r = 0.02, .critical_load = 1.01 * m * g};
  const double dt = 2e-6, speed = 0.8, t = 0.1;
  sd_simulation *s = lying(&l, SD_VERLET, dt, speed, 0);
  system_advance(s, 10000);
  const double before = system_at(s, 0).omega;
  system_advance(s, (int64_t)(t / dt));
  const system_body b = system_at(s, 0);
  SYSTEM_NEAR(b.vx, speed, 1e-15, "no friction");
  SYSTEM_NEAR(R * (b.omega - before), 2 * l.mu_r * g * t, 1e-6 * speed, "rolling friction");
  SYSTEM_NEAR(sd_simulation_energy(s).friction, 0, 0, "nothing lost to friction");
  assert_true(laws_residual(s) < 1e-6);
  system_end(s);
}

/* A disk that rolls on a floor slows down as exp(-t drag_r/(3 m/2)); all that it loses is viscous. */
static void drag(void **unused) {
  for (int i = 0; i < 2; i++) {
    const law l = {.k_n = 1e5, .k_t = 4e5, .gamma_t = 40, .mu = 1e3, .drag_r = 2};
    const double dt = 2e-6, speed = 0.2, rate = l.drag_r / (1.5 * m), t = 0.4;
    sd_simulation *s = lying(&l, (sd_integrator)i, dt, speed, 0);
    system_advance(s, (int64_t)(t / dt));
    const system_body b = system_at(s, 0);
    const sd_energy e = sd_simulation_energy(s);
    const double lost = 0.75 * m * speed * speed * (1 - exp(-2 * rate * t));
    print_message("drag, %s: speed %.8f, expected %.8f, viscous %.8f, expected %.8f\n",
                  system_integrators[i], b.vx, speed * exp(-rate * t), e.viscous, lost);
    SYSTEM_NEAR(b.vx, speed * exp(-rate * t), 1e-4 * speed, "speed");
    SYSTEM_NEAR(R * (double)b.theta, -b.x, 1e-4 * speed * t, "it rolls");
    SYSTEM_NEAR(e.viscous, lost, 1e-3 * lost, "loss");
    SYSTEM_NEAR(e.rolling + e.friction, 0, 1e-12, "nothing else is lost");
    assert_true(laws_residual(s) < 1e-6);
    system_end(s);
  }
}

RUN_TESTS(TEST(rocking), TEST(drag), TEST(rolling_to_rest), TEST(below_critical_load), TEST(slope),
          TEST(held_pair), TEST(round_walls), TEST(turning_floor))
