/* test_laws_cohesion.c: attraction: pull-off force, force against distance, work of separation, bridges that form and break,
 * impact speeds below which disks stick, friction under attraction.
 */
#include "brief.h"
#include "laws.h"

static const char *word_of(const law *l) {
  return l->cohesion == SD_COHESION_BRIDGE ? "bridge" : "constant";
}

static const law constant = {
    .k_n = 1e4, .cohesion = SD_COHESION_CONSTANT, .pull_off = 3, .range = 2e-3};
static const law bridge = {
    .k_n = 1e4, .cohesion = SD_COHESION_BRIDGE, .pull_off = 3, .range = 1e-3, .rupture = 4e-3};
static const law *const both[] = {&constant, &bridge};

/* Energy that it takes to part two touching disks. */
static double work_of_parting(const law *l) {
  if (l->cohesion == SD_COHESION_BRIDGE)
    return l->pull_off * l->range * (1 - exp(-l->rupture / l->range));
  return 0.5 * l->pull_off * l->range;
}

static void head(text *t, double dt, int integrator, const law *l, const char *more) {
  text_add(
      t, "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15; %s\n",
      dt, system_integrators[integrator], more);
  text_add(t, "materials = ( ");
  law_add(t, "name = \"m\"", l);
  text_add(t, " );\n");
}

/* A held disk, or disk and wall; the other comes, touches by 1e-3, goes beyond every range, and comes again to a gap of a
 * quarter of the range. */
static void force_against_distance(void **unused) {
  for (int k = 0; k < 2; k++)
    for (int hertz = 0; hertz < 2; hertz++)
      for (int wall = 0; wall < 3; wall++) {
        law l = *both[k];
        l.normal = hertz;
        if (hertz) l.k_n *= 30;
        const double dt = 1e-4, far = 6e-3, near = -1e-3;
        text t = {0};
        head(&t, dt, SD_VERLET, &l, "");
        text_add(&t, "disks = ( { x = 0; y = 0; radius = 1; mass = 1; locked = (\"x\", \"y\"); }");
        if (wall == 0)
          text_add(&t,
                   ", { name = \"o\"; x = %.17g; y = 0; radius = 0.5; mass = 1; fixed = true; }",
                   1.5 + far);
        text_add(&t, " );\n");
        if (wall == 1)
          text_add(&t,
                   "walls = ( { name = \"o\"; type = \"line\"; points = ( (%.17g, -1), (%.17g, 1) "
                   "); } );\n",
                   1 + far, 1 + far);
        if (wall == 2)
          text_add(&t,
                   "walls = ( { name = \"o\"; type = \"circle\"; center = (%.17g, 0); radius = "
                   "2; side = \"outside\"; } );\n",
                   3 + far);
        text_add(&t,
                 "motions = ( { %s = \"o\"; coordinate = \"x\"; type = \"table\"; times = (0, 1, "
                 "2, 3, 4, 5, 6); values = (0, %.17g, %.17g, 0, 0, %.17g, %.17g); } );\n",
                 wall ? "wall" : "disk", near - far, near - far, 0.25 * l.range - far,
                 0.25 * l.range - far);
        sd_simulation *s = laws_begin(&t, false);
        double tension = 0, worst = 0;
        bool bridged = false;
        double gap = far;
        int formed = 0;
        for (int n = 0; n < 60000; n++) {
          system_advance(s, 1);
          gap = system_at(s, 1).x - (wall == 0 ? 1.5 : wall == 1 ? 1 : 3);
          formed += gap < 0 && !bridged;
          bridged = gap < 0 || (bridged && gap < l.rupture);
          double force = law_repulsion(&l, -gap) - law_attraction(&l, -gap, bridged);
          worst = fmax(worst, fabs(-system_at(s, 0).force_x - force));
          tension = fmax(tension, system_at(s, 0).force_x);
        }
        print_message("%s, %s, %s: largest tension %.7f, error of the force %.1e\n", word_of(&l),
                      hertz ? "hertz" : "linear",
                      wall == 0   ? "disks"
                      : wall == 1 ? "line"
                                  : "circle",
                      tension, worst);
        SYSTEM_NEAR(tension, l.pull_off, 1e-4 * l.pull_off, "%s: pull-off force", word_of(&l));
        SYSTEM_NEAR(worst, 0, 1e-9 * l.pull_off, "%s: force against distance", word_of(&l));
        sd_energy e = sd_simulation_energy(s);
        /* each bridge that forms loses its work of parting; the drive puts it in when it breaks */
        double expected = k ? formed * work_of_parting(&l) : 0, part = fmax(1 - gap / l.range, 0);
        double stored = k ? 0 : -0.5 * l.pull_off * l.range * part * part;
        if (bridged && k)
          stored = -l.pull_off * l.range * (exp(-gap / l.range) - exp(-l.rupture / l.range));
        assert_true(formed > 0 && gap > 0);
        SYSTEM_NEAR(e.bridge, expected, 1e-9, "%s: lost to bridges", word_of(&l));
        SYSTEM_NEAR(e.cohesion, stored, 1e-9, "%s: stored", word_of(&l));
        SYSTEM_NEAR(e.work, expected + stored, 1e-4 * (1 + formed) * work_of_parting(&l),
                    "%s: work", word_of(&l));
        SYSTEM_NEAR(e.residual, 0, 1e-6 * work_of_parting(&l), "%s: residual", word_of(&l));
        system_end(s);
      }
}

/* A pair at rest: delta = pull_off/k_n without a load; the attraction is no force on both in sum. */
static void rest_of_a_pair(void **unused) {
  for (int k = 0; k < 2; k++) {
    law l = *both[k];
    l.gamma_n = 20;
    hit h = {.radius = {0.5, 0.4},
             .mass = {0.1, 0.2},
             .beta = 2,
             .gap = -1e-6,
             .dt = 2.5e-6,
             .integrator = SD_VERLET};
    sd_simulation *s = laws_impact(&l, &h);
    system_advance(s, 400000);
    system_body a = system_at(s, 0), b = system_at(s, 1);
    double delta = 0.9 - hypot(b.x - a.x, b.y - a.y);
    SYSTEM_NEAR(delta, l.pull_off / l.k_n, 1e-9, "%s: overlap at rest", word_of(&l));
    SYSTEM_NEAR(h.mass[0] * a.vx + h.mass[1] * b.vx, 0, 1e-14, "momentum");
    sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.cohesion, -work_of_parting(&l) - l.pull_off * delta, 1e-8, "%s: stored",
                word_of(&l));
    print_message(
        "%s: residual %.2e of %.2e; start %.3e cohesion %.3e bridge %.3e visc %.3e el %.3e\n",
        word_of(&l), e.residual, e.scale, e.start, e.cohesion, e.bridge, e.viscous,
        e.elastic_normal);
    assert_true(laws_residual(s) < 1e-6);
    system_end(s);
  }
}

static hit head_on(double speed, double gap, double dt, sd_integrator integrator) {
  hit h = {.radius = {0.5, 0.4},
           .mass = {0.1, 0.3},
           .beta = 0.3,
           .gap = gap,
           .dt = dt,
           .integrator = integrator};
  h.velocity[0][0] = speed * cos(h.beta);
  h.velocity[0][1] = speed * sin(h.beta);
  return h;
}

/* Relative speed after the impact; 0: they stick. */
static double speed_after(const law *l, const hit *h, double time, sd_energy *energy) {
  sd_simulation *s = laws_impact(l, h);
  system_advance(s, (int64_t)(time / h->dt));
  system_body a = system_at(s, 0), b = system_at(s, 1);
  bool apart = !system_touch(s, 0, 1).closed;
  *energy = sd_simulation_energy(s);
  system_end(s);
  return apart ? (b.vx - a.vx) * cos(h->beta) + (b.vy - a.vy) * sin(h->beta) : 0;
}

/* Constant attraction gives back what it took; a bridge takes W at each impact: v'^2 = v^2 - 2 W/m. Below sqrt(2 W/m) it sticks. */
static void bridges_in_impacts(void **unused) {
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < 2; i++) {
      const law *l = both[k];
      hit h = head_on(0, 3e-3, 2.5e-7, (sd_integrator)i);
      double m = hit_mass(&h), taken = work_of_parting(l), critical = k ? sqrt(2 * taken / m) : 0;
      static const double factors[] = {0.999, 1.001, 1.5, 4};
      for (size_t n = 0; n < 4; n++) {
        double speed = factors[n] * (k ? critical : 0.3);
        h = head_on(speed, 3e-3, 2.5e-7, (sd_integrator)i);
        sd_energy e;
        double after = speed_after(l, &h, 0.01 / speed + 0.1, &e),
               expected = sqrt(fmax(speed * speed - critical * critical, 0));
        /* near the critical speed a small energy is a large speed */
        SYSTEM_NEAR(after * after, expected * expected, 1e-4 * speed * speed,
                    "%s: speed^2 after %g", word_of(l), speed);
        SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "%s: residual", word_of(l));
        /* one that sticks bounces, without damping, in its bridge */
        SYSTEM_NEAR(e.bridge, k ? taken : 0, 1e-9, "%s: lost to a bridge", word_of(l));
      }
    }
}

/* Constant attraction and viscosity without the cutoff: between touch and parting the overlap is an oscillator about pull_off/k_n;
 * closed form of the speed at which delta = 0 again, and of the impact that just parts. */
static double parting_speed(const law *l, double m, double speed) {
  double v = sqrt(speed * speed + 2 * work_of_parting(l) / m); /* at touch */
  double b = 0.5 * l->gamma_n / m, w = sqrt(l->k_n / m - b * b), rest = l->pull_off / l->k_n;
  /* y = delta - rest = exp(-b t) (-rest cos + (v - b rest)/w sin) */
  double from = 0, to = 0, c = (v - b * rest) / w;
  for (double t = 0.1 / w;; t += 0.01 / w) { /* the first return to 0 */
    double y = rest + exp(-b * t) * (-rest * cos(w * t) + c * sin(w * t));
    if (y < 0) {
      from = t - 0.01 / w, to = t;
      break;
    }
    if (w * t > 7) return 0;
  }
  for (int k = 0; k < 60; k++) {
    double t = 0.5 * (from + to);
    *(rest + exp(-b * t) * (-rest * cos(w * t) + c * sin(w * t)) > 0 ? &from : &to) = t;
  }
  double t = from, sine = -rest * cos(w * t) + c * sin(w * t),
         cosine = w * (rest * sin(w * t) + c * cos(w * t));
  double out = -exp(-b * t) * (cosine - b * sine);
  double left = out * out - 2 * work_of_parting(l) / m;
  return left > 0 ? sqrt(left) : 0;
}

static void critical_speed(void **unused) {
  law l = constant;
  l.gamma_n = 8, l.damping_pulls = true;
  hit h = head_on(0, 3e-3, 2.5e-7, SD_VERLET);
  double m = hit_mass(&h), low = 0, high = 2;
  for (int k = 0; k < 60; k++) {
    double v = 0.5 * (low + high);
    *(parting_speed(&l, m, v) > 0 ? &high : &low) = v;
  }
  print_message("critical speed %.6f\n", low);
  assert_true(low > 0.05);
  static const double factors[] = {0.999, 1.001, 1.2, 3};
  for (size_t k = 0; k < 4; k++) {
    double speed = factors[k] * low, expected = parting_speed(&l, m, speed);
    h = head_on(speed, 3e-3, 2.5e-7, SD_VERLET);
    sd_energy e;
    double after = speed_after(&l, &h, 0.01 / speed + 0.1, &e);
    SYSTEM_NEAR(after * after, expected * expected, 1e-4 * speed * speed, "speed^2 after %g",
                speed);
    SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "residual");
  }
}

/* Damping with the cutoff, hertz, oblique, spinning: the reference. */
static void against_the_reference(void **unused) {
  for (int k = 0; k < 2; k++)
    for (int hertz = 0; hertz < 2; hertz++)
      for (int floor = 0; floor < 2; floor++) {
        law l = *both[k];
        l.normal = hertz, l.tangential = hertz;
        l.restitution = 0.8, l.mu = 0.4, l.mu_kinetic = 0.3, l.gamma_t = 0.5;
        l.k_n = hertz ? 2e5 : 1e4, l.k_t = hertz ? 1e5 : 6e3;
        l.k_r = 1e3, l.mu_r = 0.1;
        hit h = head_on(0.9, 3e-3, 2e-7, SD_VERLET);
        h.floor = floor;
        h.velocity[0][0] = 0.5, h.velocity[0][1] = floor ? -0.8 : 0.5, h.velocity[0][2] = 0.7;
        sd_simulation *s = laws_impact(&l, &h);
        reference q = reference_new(&l, &h);
        system_advance(s, 200000);
        reference_advance(&q, 1e-6, 40000);
        same_velocities(s, &q, 0.9, 1e-4, word_of(&l));
        print_message("%s, %s, %s: residual %.1e\n", word_of(&l), hertz ? "hertz" : "linear",
                      floor ? "floor" : "disks", laws_residual(s));
        assert_true(laws_residual(s) < 1e-6);
        system_end(s);
      }
}

/* A sledge on a tilted floor: friction bears mu (W cos + pull_off), and it hangs from a ceiling as well. */
static void friction_under_attraction(void **unused) {
  const double m = 0.5, g = 9.81, R = 0.3, mu = 0.4;
  for (int k = 0; k < 2; k++)
    for (int ceiling = 0; ceiling < 2; ceiling++)
      for (int over = -1; over <= 1; over += 2) {
        law l = *both[k];
        l.mu = mu, l.k_t = 1e4, l.gamma_n = 20, l.gamma_t = 20;
        l.pull_off = 1.6 * m * g;
        /* held: g sin <= mu (+-g cos + P/m) */
        double sign = ceiling ? -1 : 1, low = 0, high = 0.5 * M_PI;
        for (int n = 0; n < 60; n++) {
          double a = 0.5 * (low + high);
          *(sin(a) < mu * (sign * cos(a) + 1.6) ? &low : &high) = a;
        }
        double tilt = low * (1 + 0.02 * over), dt = 1e-5;
        text t = {0};
        char gravity[128];
        snprintf(gravity, sizeof gravity, "gravity = { g = %.17g; tilt = %.17g; };", g, tilt);
        head(&t, dt, SD_VERLET, &l, gravity);
        double rest = (sign * m * g * cos(tilt) + l.pull_off) / l.k_n, y = sign * (R - rest);
        text_add(
            &t,
            "disks = ( { x = 0; y = %.17g; radius = %g; mass = %g; locked = (\"theta\"); } );\n"
            "walls = ( { type = \"line\"; points = ( (-1, 0), (1, 0) ); } );\n",
            y, R, m);
        sd_simulation *s = laws_begin(&t, false);
        system_advance(s, 40000);
        double v = system_at(s, 0).vx;
        system_advance(s, 10000);
        double a = (system_at(s, 0).vx - v) / (10000 * dt);
        double expected =
            over < 0 ? 0 : -g * sin(tilt) + mu * (sign * g * cos(tilt) + l.pull_off / m);
        SYSTEM_NEAR(a, expected, 1e-4 * g, "%s, %s: acceleration", word_of(&l),
                    ceiling ? "ceiling" : "floor");
        print_message("%s, %s: residual %.2e\n", word_of(&l), ceiling ? "ceiling" : "floor",
                      laws_residual(s));
        assert_true(laws_residual(s) < 1e-6);
        system_end(s);
      }
}

RUN_TESTS(TEST(force_against_distance), TEST(rest_of_a_pair), TEST(bridges_in_impacts),
          TEST(critical_speed), TEST(against_the_reference), TEST(friction_under_attraction))
