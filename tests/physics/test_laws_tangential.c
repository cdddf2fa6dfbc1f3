/* test_laws_tangential.c: dashpots, springs that stiffen with the overlap, static and kinetic friction, critical loads; oblique impacts.
 *
 * A disk of inertia m R^2/2 that cannot leave a floor has 1/m* = 1/m + R^2/I = 3/m in its tangential motion.
 */
#include "brief.h"
#include "laws.h"

static const double m = 0.7, R = 0.4, g = 9.81;

static void head(text *t, double dt, int integrator) {
  text_add(t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n",
           dt, system_integrators[integrator]);
}

/* Tangential oscillation of a disk on a floor and of a pair whose centres are held: exp(-b t) cos(w t) and so on. */
static void dashpot(void **unused) {
  for (int pair = 0; pair < 2; pair++)
    for (int mindlin = 0; mindlin < 2; mindlin++)
      for (int i = 0; i < 2; i++) {
        law l = {.k_n = 1e6, .mu = 1e6, .k_t = 1e4, .gamma_t = 8, .tangential = mindlin};
        const double dt = 2e-6, rb = 0.3, mb = 0.2, overlap = pair ? 1e-3 : m * g / l.k_n,
                     speed = 0.1;
        if (mindlin) l.k_t = 1e4 / sqrt(overlap);
        text t = {0};
        head(&t, dt, i);
        text_add(&t, "gravity = { g = %.17g; }; materials = ( ", pair ? 0 : g);
        law_add(&t, "name = \"m\"", &l);
        text_add(&t, " );\ndisks = ( { x = 0; y = 0; radius = %g; mass = %g; ", R, m);
        if (pair)
          text_add(&t,
                   "omega = %.17g; locked = (\"x\", \"y\"); },\n"
                   "{ x = %.17g; y = 0; radius = %g; mass = %g; locked = (\"x\", \"y\"); } );\n",
                   speed / R, R + rb - overlap, rb, mb);
        else
          text_add(&t,
                   "vx = %.17g; } );\n"
                   "walls = ( { type = \"line\"; points = ( (-1, %.17g), (1, %.17g) ); } );\n",
                   speed, overlap - R, overlap - R);
        sd_simulation *s = laws_begin(&t, false);
        double inverse = pair ? 2 / m + 2 / mb : 3 / m, b = 0.5 * l.gamma_t * inverse;
        double w = sqrt(1e4 * inverse - b * b), worst = 0;
        for (int k = 1; k <= 400; k++) {
          system_advance(s, 20);
          double now = 20 * k * dt,
                 e = speed * exp(-b * now) * (cos(w * now) - b / w * sin(w * now));
          system_body one = system_at(s, 0), two = {0};
          if (pair) two = system_at(s, 1);
          double surface = pair ? R * one.omega + rb * two.omega : one.vx + R * one.omega;
          worst = fmax(worst, fabs(surface - e) / speed);
          /* force and couples of one and the same tau */
          double kept =
              pair ? m * R * one.omega - mb * rb * two.omega : one.vx - 0.5 * R * one.omega;
          SYSTEM_NEAR(kept, pair ? m * speed : speed, 1e-9, "one force on both");
        }
        print_message("dashpot, %s, %s, %s: error %.1e, residual %.1e\n", pair ? "pair" : "floor",
                      mindlin ? "mindlin" : "spring", system_integrators[i], worst,
                      laws_residual(s));
        SYSTEM_NEAR(worst, 0, 1e-4, "tangential oscillation");
        assert_true(laws_residual(s) < 1e-6);
        system_end(s);
      }
}

static const struct {
  const char *name;
  law law;
} laws[] = {
    {"spring", {.k_n = 1e4, .gamma_n = 3, .mu = 0.4, .k_t = 7e3}},
    {"spring and dashpot", {.k_n = 1e4, .gamma_n = 3, .mu = 0.4, .k_t = 7e3, .gamma_t = 2}},
    {"mindlin",
     {.normal = SD_NORMAL_HERTZ,
      .k_n = 1e5,
      .restitution = 0.8,
      .mu = 0.4,
      .k_t = 1.2e5,
      .tangential = SD_TANGENTIAL_MINDLIN}},
    {"mindlin and dashpot",
     {.normal = SD_NORMAL_HERTZ,
      .k_n = 1e5,
      .restitution = 0.8,
      .mu = 0.4,
      .k_t = 1.2e5,
      .tangential = SD_TANGENTIAL_MINDLIN,
      .gamma_t = 1}},
    {"kinetic friction",
     {.k_n = 1e4, .restitution = 0.9, .mu = 0.5, .mu_kinetic = 0.2, .k_t = 7e3}},
    {"critical load",
     {.k_n = 1e4, .gamma_n = 3, .mu = 0.5, .k_t = 7e3, .critical_load = 5, .gamma_t = 2}},
    {"critical load and mindlin",
     {.normal = SD_NORMAL_HERTZ,
      .k_n = 1e5,
      .restitution = 0.8,
      .mu = 0.5,
      .mu_kinetic = 0.4,
      .critical_load = 5,
      .k_t = 1.2e5,
      .tangential = SD_TANGENTIAL_MINDLIN}},
    {"everything",
     {.normal = SD_NORMAL_HERTZ,
      .k_n = 1e5,
      .restitution = 0.8,
      .gamma_n = 0.5,
      .damping_pulls = true,
      .mu = 0.5,
      .mu_kinetic = 0.3,
      .k_t = 1.2e5,
      .tangential = SD_TANGENTIAL_MINDLIN,
      .gamma_t = 1,
      .k_r = 3e3,
      .gamma_r = 0.5,
      .mu_r = 0.1}},
};

/* Both end with the velocities of the reference, at every angle of incidence. */
static void oblique(void **unused) {
  static const double angles[] = {0.02, 0.1, 0.3, 0.6, 0.9, 1.2, 1.5};
  for (size_t n = 0; n < sizeof laws / sizeof *laws; n++) {
    const law *l = &laws[n].law;
    double worst = 0;
    for (size_t k = 0; k < sizeof angles / sizeof *angles; k += BRIEF(1, 3))
      for (int floor = 0; floor < 2; floor++) {
        hit h = {.floor = floor,
                 .radius = {0.4, 0.3},
                 .mass = {0.7, 0.2},
                 .beta = -0.4 + 0.3 * (double)k};
        h.integrator = floor ? SD_GEAR5 : SD_VERLET;
        double along = floor ? -0.5 * M_PI : h.beta, speed = 0.5,
               rate = l->normal == SD_NORMAL_HERTZ ? 70 : 150;
        double v = speed * cos(angles[k]), u = speed * sin(angles[k]);
        h.velocity[0][0] = v * cos(along) - u * sin(along);
        h.velocity[0][1] = v * sin(along) + u * cos(along);
        h.velocity[0][2] = floor ? 0 : 0.2;
        h.dt = 4e-5 / rate;
        h.gap = 10.3 * v * h.dt;
        sd_simulation *s = laws_impact(l, &h);
        reference q = reference_new(l, &h);
        reference_advance(&q, 4 * h.dt, 25);
        for (int64_t step = 25; q.reach > 0 || step < 100; step++) {
          if (step > 1000000) fail_msg("%s: never apart", laws[n].name);
          reference_advance(&q, 4 * h.dt, 1);
        }
        for (int part = 0; part < 400 && (part < 10 || system_touch(s, 0, 1).closed); part++)
          system_advance(s, 10000);
        assert_false(system_touch(s, 0, 1).closed);
        same_velocities(s, &q, speed, 1e-4, laws[n].name);
        worst = fmax(worst, laws_residual(s));
        system_end(s);
      }
    print_message("oblique, %s: residual %.1e\n", laws[n].name, worst);
    assert_true(worst < 1e-6);
  }
}

/* Rebound of the contact point against its incidence, after Maw, Barber and Fawcett (Wear 38, 101): backwards at small angles,
 * where the spring gives back, and in gross sliding u' = u - 3 mu (1 + e) v at large ones. */
static void rebound(void **unused) {
  for (int kind = 0; kind < 2; kind++) {
    law l = {.normal = kind,
             .tangential = kind,
             .k_n = 1e5,
             .restitution = 0.9,
             .mu = 0.3,
             .k_t = kind ? 1e5 : 7e4};
    for (int k = 0; k < 12; k++) {
      double ratio = 0.25 * (k + 1), v = 0.2, u = ratio * v;
      hit h = {.floor = true,
               .radius = {R},
               .mass = {m},
               .velocity = {{u, -v}},
               .integrator = SD_VERLET,
               .dt = 1e-7};
      h.gap = 1e-6 * v;
      sd_simulation *s = laws_impact(&l, &h);
      for (int part = 0; part < 100 && (part < 2 || sd_simulation_state(s)->n_contacts); part++)
        system_advance(s, 20000);
      system_body b = system_at(s, 0);
      double after = (b.vx + R * b.omega) / v, gross = ratio - 3 * l.mu * (1 + l.restitution);
      if (ratio < 0.8) assert_true(after < -0.1 * ratio);
      if (gross > 0.6) SYSTEM_NEAR(after, gross, 2e-4 * ratio, "gross sliding at %g", ratio);
      system_end(s);
    }
  }
}

/* Flies at a floor, the point of contact at `ratio` times the speed along it; returns what it has after, over the speed. */
static double critical_impact(const law *l, double v, double ratio, sd_energy *e) {
  hit h = {.floor = true,
           .radius = {R},
           .mass = {m},
           .velocity = {{0.5 * ratio * v, -v, 0.5 * ratio * v / R}},
           .integrator = SD_VERLET,
           .dt = 1e-7};
  h.gap = 1e-6 * v;
  sd_simulation *s = laws_impact(l, &h);
  for (int part = 0; part < 100 && (part < 2 || sd_simulation_state(s)->n_contacts); part++)
    system_advance(s, 20000);
  system_body b = system_at(s, 0);
  *e = sd_simulation_energy(s);
  SYSTEM_NEAR(e->residual / e->scale, 0, 1e-6, "residual of an impact");
  system_end(s);
  return (b.vx + R * b.omega) / v;
}

/* Impacts whose peak stays below the critical load feel no friction at all. Above it, in gross sliding, the linear law gives the
 * impulse mu (2 P cos(phi) - F_c (pi - 2 phi))/w of mu (P sin(w t) - F_c), with sin(phi) = F_c/P. */
static void impact_over_critical_load(void **unused) {
  const double v = 0.2, ratio = 5;
  for (int kind = 0; kind < 2; kind++) {
    law l = {.normal = kind, .tangential = kind, .k_n = 1e5, .mu = 0.3, .k_t = 1e5, .gamma_t = 1};
    const double w = sqrt(l.k_n / m),
                 peak = kind ? l.k_n * pow(5 * m * v * v / (4 * l.k_n), 0.6) : v * m * w;
    sd_energy e;
    l.critical_load = 1.0001 * peak;
    double after = critical_impact(&l, v, ratio, &e);
    SYSTEM_NEAR(after, ratio, 1e-14, "frictionless below the critical load");
    SYSTEM_NEAR(e.friction + e.opening, 0, 0, "nothing to lose");
    l.critical_load = 0.99 * peak;
    after = critical_impact(&l, v, ratio, &e);
    assert_true(after < ratio - 1e-4 && e.friction > 0);
    for (double part = 0.2; !kind && part < 1; part += 0.3) {
      l.critical_load = part * peak;
      const double phi = asin(part), lost = l.mu * v * (2 * cos(phi) - part * (M_PI - 2 * phi));
      after = critical_impact(&l, v, ratio, &e);
      print_message("critical load of %.1f peaks: loses %.6f, expected %.6f\n", part, ratio - after,
                    3 * lost / v);
      SYSTEM_NEAR(ratio - after, 3 * lost / v, 1e-5, "gross sliding above the critical load");
    }
  }
}

/* Disk 0, whose centre is held and that does not turn in the end (its inertia is huge), feels disk 1 come and go. Returns the energy
 * stored tangentially at the end. turns: swings of the angle to one of the overlap. */
static double driven_cycle(bool mindlin, int turns, double periods, double dt, double *lost) {
  const law l = {.normal = SD_NORMAL_HERTZ,
                 .tangential = mindlin,
                 .k_n = 1e4,
                 .k_t = mindlin ? 3e5 : 1e4,
                 .mu = 1e9};
  text t = {0};
  head(&t, dt, SD_VERLET);
  text_add(&t, "materials = ( ");
  law_add(&t, "name = \"m\"", &l);
  text_add(&t,
           " );\n"
           "disks = ( { x = 0; y = 0; radius = 1; mass = 1; inertia = 1e90; locked = (\"x\", "
           "\"y\"); },\n"
           "{ name = \"d\"; x = %.17g; y = 0; radius = 1; mass = 1; fixed = true; } );\n"
           "motions = ( { disk = \"d\"; coordinate = \"x\"; type = \"harmonic\"; amplitude = "
           "2e-3; omega = \"2 pi\"; }, { disk = \"d\"; coordinate = \"theta\"; type = "
           "\"harmonic\"; amplitude = 0.01; omega = \"%d pi\"; } );\n",
           1.995, 2 * turns);
  sd_simulation *s = laws_begin(&t, false);
  system_advance(s, (int64_t)nearbyint(periods / dt));
  sd_energy e = sd_simulation_energy(s);
  *lost = e.friction + e.viscous + e.opening;
  SYSTEM_NEAR(e.residual, 0, 1e-7, "residual of a driven cycle, of 0.5 that are stored");
  double stored = e.elastic_tangential;
  system_end(s);
  return stored;
}

/* Overlap and tangential way in phase: the way back is the way there, and all energy comes back. Out of phase y goes round a loop
 * and is left with the integral of s dlambda, whose energy the drive has put in. */
static void closed_cycles(void **unused) {
  for (int mindlin = 0; mindlin < 2; mindlin++) {
    double lost;
    double peak = driven_cycle(mindlin, 1, 0.25, 1e-4, &lost);
    double rest = driven_cycle(mindlin, 1, 3, 1e-4, &lost);
    print_message("%s: %.3e stored at the peak, %.1e after three cycles, lost %.1e\n",
                  mindlin ? "mindlin" : "spring", peak, rest, lost);
    assert_true(peak > 1e-3);
    SYSTEM_NEAR(rest, 0, 1e-9 * peak, "given back");
    SYSTEM_NEAR(lost, 0, 1e-12 * peak, "nothing is lost");
    double left = driven_cycle(mindlin, 2, 1, 1e-4, &lost), y = 0;
    /* theta = 0.01 sin 2p, overlap = 0.005 - 0.002 sin p: integral of sqrt(k_t) delta^(1/4) dlambda */
    for (int k = 0; k < 100000; k++) {
      double p = 2 * M_PI * (k + 0.5) / 100000;
      y += sqrt(3e5) * pow(0.005 - 2e-3 * sin(p), 0.25) * 0.02 * cos(2 * p) * 2 * M_PI / 100000;
    }
    double expected = mindlin ? 0.5 * y * y : 0;
    print_message("%s: %.6e left of a loop, expected %.6e\n", mindlin ? "mindlin" : "spring", left,
                  expected);
    SYSTEM_NEAR(left, expected, 1e-4 * expected + 1e-9 * peak, "left of a loop");
    SYSTEM_NEAR(lost, 0, 1e-12 * peak, "nothing is lost");
  }
}

static const double stop_k = 1e3;

/* A sledge on a belt, held by a stop on its right. */
static sd_simulation *sledge(const law *l, double dt, double belt, double speed, bool stop) {
  text t = {0};
  head(&t, dt, SD_VERLET);
  text_add(&t, "gravity = { g = %.17g; }; materials = ( ", g);
  law_add(&t, "name = \"sledge\"", &(law){.k_n = 1});
  text_add(&t, ", ");
  law_add(&t, "name = \"belt\"", &(law){.k_n = 1});
  text_add(&t, ", ");
  law_add(&t, "name = \"stop\"", &(law){.k_n = 1});
  text_add(&t, " ); material_pairs = ( ");
  law_add(&t, "materials = (\"sledge\", \"belt\")", l);
  text_add(&t, ", ");
  law_add(&t, "materials = (\"sledge\", \"stop\")", &(law){.k_n = stop_k});
  text_add(&t,
           " );\ndisks = ( { x = 0; y = %.17g; radius = %g; mass = %g; vx = %.17g; locked = "
           "(\"theta\"); "
           "material = \"sledge\"; } );\n"
           "walls = ( { name = \"b\"; type = \"line\"; points = ( (-1, 0), (1, 0) ); material = "
           "\"belt\"; }",
           R - (m * g + l->pull_off) / l->k_n, R, m, speed);
  if (stop)
    text_add(&t, ", { type = \"line\"; points = ( (%g, -1), (%g, 1) ); material = \"stop\"; }", R,
             R);
  text_add(&t,
           " );\nmotions = ( { wall = \"b\"; coordinate = \"x\"; type = \"velocity\"; velocity = "
           "%.17g; } );\n",
           belt);
  return laws_begin(&t, false);
}

/* Slides with mu_k and stops after v^2/(2 mu_k g); the first way is that of the spring up to the static limit. */
static void sledge_stops(void **unused) {
  const law l = {.k_n = 1e5, .mu = 0.5, .mu_kinetic = 0.3, .k_t = 1e6};
  const double speed = 0.7, dt = 1e-6, x1 = l.mu * m * g / l.k_t, w2 = l.k_t / m;
  double v2 = speed * speed - w2 * x1 * x1, way = x1 + 0.5 * v2 / (l.mu_kinetic * g);
  sd_simulation *s = sledge(&l, dt, 0, speed, false);
  double most = 0;
  for (int k = 0; k < 100000; k++) {
    system_advance(s, 10);
    system_body b = system_at(s, 0);
    if (b.x > 0.1 * way && b.vx > 1e-3)
      SYSTEM_NEAR(b.force_x, -l.mu_kinetic * m * g, 1e-6 * m * g, "friction while it slides");
    most = fmax(most, b.x);
    if (b.vx < 0) break;
  }
  sd_energy e = sd_simulation_energy(s);
  print_message("sledge: way %.6f, expected %.6f, residual %.1e\n", most, way, laws_residual(s));
  SYSTEM_NEAR(most, way, 1e-4 * way, "way of a sledge");
  SYSTEM_NEAR(e.friction, 0.5 * m * speed * speed, 2e-4 * e.friction, "lost to friction");
  assert_true(laws_residual(s) < 1e-6);
  system_end(s);
}

/* On a floor that it presses with N a sledge slides freely if N is below the critical load, else it slows down by
 * mu (N - F_c)/m and stops. */
static void sledge_over_critical_load(void **unused) {
  const double weight = m * g, speed = 0.3, dt = 1e-6;
  for (int kind = 0; kind < 4; kind++)
    for (int above = 0; above < 2; above++) {
      law l = {.k_n = 1e5, .mu = 0.5, .k_t = 1e6, .critical_load = (above ? 0.4 : 1.01) * weight};
      if (kind & 1) l.tangential = SD_TANGENTIAL_MINDLIN, l.k_t /= sqrt(weight / l.k_n);
      if (kind & 2) l.mu_kinetic = 0.3, l.gamma_t = 100;
      const double mu = kind & 2 ? l.mu_kinetic : l.mu, friction = mu * (weight - l.critical_load);
      sd_simulation *s = sledge(&l, dt, 0, speed, false);
      system_advance(s, 20000);
      system_body b = system_at(s, 0);
      sd_energy e = sd_simulation_energy(s);
      if (!above) {
        SYSTEM_NEAR(b.force_x, 0, 0, "no force below the critical load");
        SYSTEM_NEAR(b.vx, speed, 1e-15, "slides freely");
        SYSTEM_NEAR(e.friction + e.elastic_tangential, 0, 0, "no loss below the critical load");
      } else {
        SYSTEM_NEAR(b.force_x, -friction, 1e-6 * weight, "friction above the critical load");
        system_advance(s, 20000);
        const double slowed = b.vx - system_at(s, 0).vx;
        SYSTEM_NEAR(slowed, friction / m * 20000 * dt, 1e-6 * speed, "slows down");
        system_advance(s, 300000);
        b = system_at(s, 0);
        assert_true(fabs(b.vx) < 0.02 * speed && fabs(b.force_x) < l.mu / mu * friction * 1.01);
      }
      assert_true(laws_residual(s) < 1e-6);
      system_end(s);
    }
}

/* On a slow belt against a stop: it sticks until mu W, slips with mu_k W, sticks again: period of the closed form (Den Hartog,
 * Mechanical Vibrations, 7.3) for a stiff k_t, whole motion of the reference. */
static void stick_slip(void **unused) {
  const law l = {.k_n = 1e5, .mu = 0.5, .mu_kinetic = 0.3, .k_t = 1e6, .gamma_t = 1200};
  const double belt = 0.02, dt = 2e-6, weight = m * g, w = sqrt(stop_k / m);
  sd_simulation *s = sledge(&l, dt, belt, 0, true);
  hit h = {.floor = true, .radius = {R, 0}, .mass = {m, 1}, .gravity = g, .gap = -weight / l.k_n};
  reference q = reference_new(&l, &h);
  q.stop = stop_k, q.belt = belt, q.locked = true;
  double first = 0, least = 1e9, last = 0, period = 0, worst = 0;
  int slips = 0;
  bool slipping = false;
  for (int k = 0; k < 100000 && slips < 4; k++) {
    system_advance(s, 10);
    reference_advance(&q, 10 * dt, 1);
    system_body b = system_at(s, 0);
    worst = fmax(worst, fabs(b.x - q.s[AT]) * stop_k / weight);
    double friction = (b.force_x + stop_k * fmax(b.x, 0)) / weight, now = 10 * dt * k;
    if (slips == 0 && b.x * stop_k > 0.4 * weight) first = fmax(first, friction);
    if (b.vx < -0.5 * belt && !slipping) slips++, period = now - last, last = now;
    slipping = b.vx < -0.5 * belt || (slipping && b.vx < 0.5 * belt);
    if (slips > 0) least = fmin(least, b.x);
  }
  double drop = (l.mu - l.mu_kinetic) * weight / stop_k, phi = atan(drop * w / belt);
  double expected = 2 * drop / belt + (2 * M_PI - 2 * phi) / w;
  /* sticks over 2 drop at the belt's speed, slips for the rest of a turn of the oscillator */
  double swing = hypot(drop, belt / w), low = l.mu_kinetic * weight / stop_k - swing;
  print_message(
      "stick-slip: starts at %.6f, period %.5f, closed form %.5f, lowest %.6f, closed form %.6f; "
      "reference within %.1e, residual %.1e\n",
      first, period, expected, least, low, worst, laws_residual(s));
  SYSTEM_NEAR(first, l.mu, 1e-4 * l.mu, "starts at mu");
  SYSTEM_NEAR(period, expected, 1e-2 * expected, "period");
  SYSTEM_NEAR(least, low, 2e-2 * swing, "lowest");
  SYSTEM_NEAR(worst, 0, 1e-3, "whole motion");
  assert_true(laws_residual(s) < 1e-6);
  system_end(s);
}

RUN_TESTS(TEST(dashpot), TEST(oblique), TEST(rebound), TEST(impact_over_critical_load),
          TEST(closed_cycles), TEST(sledge_stops), TEST(sledge_over_critical_load),
          TEST(stick_slip))
