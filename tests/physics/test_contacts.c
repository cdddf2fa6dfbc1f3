/* test_contacts.c: the memory of a contact: exact through any number of turns, forgotten when it opens, free
 * where nothing presses, and with the constants of the right pair of materials.
 */
#include "brief.h"
#include "system.h"

/* lambda of a pair in long double, beta unwrapped from step to step; radius_b < 0: a drum. */
typedef struct own_lambda {
  long double beta, start;
  bool begun;
} own_lambda;

static double own_stretch(own_lambda *own, const system_body *a, const system_body *b,
                          double radius_a, double radius_b) {
  long double sum = (long double)radius_a + radius_b, sign = sum < 0 ? -1 : 1;
  long double dx = (long double)b->x - a->x, dy = (long double)b->y - a->y;
  long double beta = atan2l(sign * dy, sign * dx), turn = 2 * acosl(-1.0L);
  if (own->begun) beta += turn * nearbyintl((own->beta - beta) / turn);
  own->beta = beta;
  long double lambda = radius_a * a->theta + radius_b * b->theta - beta * sum;
  if (!own->begun) own->start = lambda;
  own->begun = true;
  return (double)(lambda - own->start);
}

/* At the coordinates of the state, from the energy that is stored there: with Gear forces act at the predicted ones. */
static double stored_zeta(sd_simulation *s, const system_contact *c) {
  const double k_t = sd_simulation_model(s)->laws[0].k_t;
  return copysign(sqrt(2 * sd_simulation_energy(s).elastic_tangential / k_t), c->stretch);
}

/* Compares with the engine for n steps. Returns the turns of the contact line. */
static double compare_stretch(sd_simulation *s, uint32_t b, double radius_b, int64_t n,
                              double bound, const char *what) {
  double radius = sd_simulation_model(s)->disks[0].radius, worst = 0, most = 0;
  own_lambda own = {0};
  long double first = 0;
  for (int64_t k = 0; k <= n; k++) {
    if (k) system_advance(s, 1);
    system_body one = system_at(s, 0), other = system_at(s, b);
    double zeta = own_stretch(&own, &one, &other, radius, radius_b);
    system_contact c = system_touch(s, 0, b);
    if (!c.closed || c.slide) fail_msg("%s: open or sliding at step %lld", what, (long long)k);
    const double stored = stored_zeta(s, &c);
    worst = fmax(worst, fabs(stored - zeta));
    most = fmax(most, fabs(zeta));
    if (k == 0) first = own.beta;
  }
  double turns = (double)((own.beta - first) / (2 * acosl(-1.0L)));
  print_message("%s: %.1f turns, stretch up to %.2g, error %.1e\n", what, turns, most, worst);
  SYSTEM_NEAR(worst, 0, bound * radius, "%s: lambda - lambda*", what);
  return turns;
}

/* Rolls along the inside of a drum without gravity: the centrifugal force presses it on. */
static void pair_revolves_in_a_drum(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int sense = -1; sense <= 1; sense += 2) {
      const double k_n = 1e4, radius = 0.3, hollow = 1, speed = 2;
      sd_model *m = system_new((sd_integrator)integrator, SD_CONSERVATIVE, 1e-4,
                               (sd_contact_law){.k_n = k_n, .k_t = 3e3, .gamma_n = 10, .mu = 1e9});
      double way = hollow - radius, press = speed * speed / way / k_n;
      system_disk(m, way + press, 0, radius, 1);
      /* not quite rolling: the skin rings */
      system_velocity(m, 0, 0, sense * speed, -sense * 1.02 * speed / radius);
      size_t w = system_circle(m, 0, 0, hollow, true);
      system_move(m, system_wall_body(m, w), SD_THETA, 0.1 * sense);
      sd_simulation *s = system_start(m);
      double turns = compare_stretch(s, 1, -hollow, 240000, 1e-12, "drum");
      assert_true(fabs(turns) > 10);
      system_end(s);
    }
}

/* A disk is led around a turning one, and rolls on it. */
static void pair_revolves_ten_turns_stuck(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int variant = 0; variant < 2; variant++) {
      if (BRIEF(0, variant != integrator)) continue;
      const double r = 0.4, q = 0.7, overlap = 1e-3, turn = 2 * M_PI, way = r + q - overlap,
                   phase = 2.9;
      sd_model *m = system_new((sd_integrator)integrator, (sd_variant)variant, 1e-4,
                               (sd_contact_law){.k_n = 1e4, .k_t = 2e3, .gamma_n = 0, .mu = 1e9});
      system_disk(m, 0.2, -0.1, r, 1);
      system_disk(m, 0.2, -0.1, q, 1);
      m->disks[1].driven = true;
      m->disks[0].position[0] += way * sin(phase);
      m->disks[0].position[1] += way * sin(phase + 0.5 * M_PI);
      /* the harmonic motions start at u(0) = way sin(phase), on top of the position */
      m->disks[0].position[0] = 0.2;
      m->disks[0].position[1] = -0.1;
      system_shake(m, 0, SD_X, way, turn, phase);
      system_shake(m, 0, SD_Y, way, turn, phase + 0.5 * M_PI);
      system_move(m, 1, SD_THETA, -3.7);
      m->disks[0].velocity[SD_THETA] = -turn * (r + q) / r + 3.7 * q / r + 0.05;
      sd_simulation *s = system_start(m);
      system_advance(s, 1); /* the motions are in place; contact begins here at the latest */
      system_contact c = system_touch(s, 0, 1);
      double zero = stored_zeta(s, &c);
      own_lambda own = {0};
      double worst = 0, most = 0;
      for (int64_t k = 0; k <= 110000; k++) {
        if (k) system_advance(s, 1);
        system_body a = system_at(s, 0), b = system_at(s, 1);
        c = system_touch(s, 0, 1);
        assert_true(c.closed && !c.slide);
        double zeta = own_stretch(&own, &a, &b, r, q);
        worst = fmax(worst, fabs(stored_zeta(s, &c) - zero - zeta));
        most = fmax(most, fabs(zeta));
      }
      print_message("around a disk: 11 turns, stretch up to %.2g, error %.1e\n", most, worst);
      SYSTEM_NEAR(worst, 0, 1e-12 * r, "around a disk: lambda - lambda*");
      system_end(s);
    }
}

/* 1e4 rad of a support; the disk on it turns back as much. */
static void ten_thousand_radians_against_a_support(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++) {
    const double rate = 2000, dt = 1e-5;
    sd_model *m = system_new((sd_integrator)integrator, SD_PAPER, dt,
                             (sd_contact_law){.k_n = 1e3, .k_t = 1e6, .gamma_n = 10, .mu = 1e9});
    system_disk(m, 0, 1.999, 1, 0.1);
    system_disk(m, 0, 0, 1, 0.1);
    m->disks[0].locked[SD_X] = m->disks[0].locked[SD_Y] = m->disks[1].driven = true;
    m->disks[0].velocity[SD_THETA] = -rate * (1 + 1e-5);
    system_move(m, 1, SD_THETA, rate);
    sd_simulation *s = system_start(m);
    compare_stretch(s, 1, 1, 500000, 1e-12, "turning by 1e4 rad");
    system_body support = system_at(s, 1), disk = system_at(s, 0);
    /* dt is not a decimal number, so neither is the time */
    SYSTEM_NEAR((double)(support.theta - (long double)rate * dt * 500000), 0, 2e-12,
                "angle of the support");
    SYSTEM_NEAR((double)disk.theta, -1e4, 1e-3, "angle of the disk");
    system_end(s);
  }
}

/* A spinning disk is pressed on a wall and lifted, again and again: the stretch is that since the moment of touch, at
 * which 0.001 + 0.01 sin(20 t) = 0. */
static void new_contact_starts_at_the_moment_of_touch(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int round = 0; round < 2; round++) {
      const double radius = 0.5, dt = 1e-4, spin = 3;
      sd_model *m = system_new((sd_integrator)integrator, SD_PAPER, dt,
                               (sd_contact_law){.k_n = 1e4, .k_t = 1e3, .gamma_n = 0, .mu = 1e9});
      system_disk(m, 0, radius + 0.001, radius, 1);
      m->disks[0].inertia = 1e90;
      system_velocity(m, 0, 0, 0, spin);
      m->disks[0].locked[SD_X] = true;
      system_shake(m, 0, SD_Y, 0.01, 20, 0);
      if (round)
        system_circle(m, 0, -2, 2, false);
      else
        system_straight(m, SD_WALL_LINE, 2, (const double[][2]){{-1, 0}, {1, 0}});
      sd_simulation *s = system_start(m);
      bool was = false;
      int begun = 0;
      long double from = 0;
      double dropped = 0, stretch = 0, first = 0;
      for (int k = 0; k < 20000; k++) {
        system_advance(s, 1);
        system_contact c = system_touch(s, 0, 1);
        long double theta = system_at(s, 0).theta;
        if (c.closed && !was) {
          const double touch = ((2 * begun + 1) * M_PI + asin(0.1)) / 20;
          from = theta, first = c.stretch, begun++;
          /* of second order: a dt^2/2 over u_n, times the speed of the surface */
          SYSTEM_NEAR(first, radius * spin * ((k + 1) * dt - touch), 2e-8,
                      "stretch at the first evaluation");
        }
        if (was && !c.closed) dropped += 0.5 * 1e3 * stretch * stretch;
        stretch = c.stretch;
        if (c.closed)
          SYSTEM_NEAR(c.stretch, first + (double)(radius * (theta - from)), 1e-14, "stretch");
        was = c.closed;
      }
      assert_in_range(begun, 6, 7);
      sd_energy e = sd_simulation_energy(s);
      SYSTEM_NEAR(e.opening, dropped, 1e-12 * dropped, "what the skin still held when it opened");
      assert_true(dropped > 0 &&
                  fabs(e.friction) < 0.01 * dropped); /* steps of touch and of separation */
      system_end(s);
    }
}

/* Drawn back faster than the spring follows: delta > 0, F_n = 0, lambda* follows lambda. */
static void skin_is_free_where_nothing_presses(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++) {
    const double radius = 0.5, dt = 1e-4, spin = 0.3, k_n = 1e4, gamma = 2000;
    sd_model *m = system_new((sd_integrator)integrator, SD_PAPER, dt,
                             (sd_contact_law){.k_n = k_n, .k_t = 1e3, .gamma_n = gamma, .mu = 1e9});
    system_disk(m, 0, radius - 0.01, radius, 1);
    m->disks[0].inertia = 1e90;
    system_velocity(m, 0, 0, 0, spin);
    m->disks[0].locked[SD_X] = true;
    system_shake(m, 0, SD_Y, 0.009, 20, 0); /* never leaves the wall */
    system_straight(m, SD_WALL_LINE, 2, (const double[][2]){{-1, 0}, {1, 0}});
    sd_simulation *s = system_start(m);
    int freed = 0, pressed = 0;
    long double from = 0;
    for (int k = 0; k < 20000; k++) {
      system_advance(s, 1);
      system_contact c = system_touch(s, 0, 1);
      system_body d = system_at(s, 0);
      assert_true(c.closed && c.overlap > 0);
      double force = fmax(k_n * (radius - d.y) - gamma * d.vy, 0);
      SYSTEM_NEAR(c.force, force, 1e-9, "normal force");
      if (c.force <= 0) {
        assert_true(c.stretch == 0 && d.torque == 0 && d.force_x == 0 && d.force_y == 0);
        from = d.theta;
        freed++;
      } else if (freed) {
        SYSTEM_NEAR(c.stretch, (double)(radius * (d.theta - from)), 1e-14,
                    "stretch since it was pressed");
        pressed++;
      }
    }
    assert_true(freed > 2000 && pressed > 2000);
    system_end(s);
  }
}

/* Disks of three materials hit fixed ones of each, all in one system: restitution, largest overlap, skin and
 * friction tell k_n, gamma_n, k_t and mu of the pair apart. */
static void pairs_of_materials_have_their_own_constants(void **unused) {
  enum { M = 3 };
  sd_contact_law laws[M * M];
  for (int a = 0; a < M; a++)
    for (int b = 0; b < M; b++) {
      int low = a < b ? a : b, high = a < b ? b : a, k = 3 * low + high;
      laws[M * a + b] = (sd_contact_law){.k_n = 1e4 * (1 + k),
                                         .k_t = 1e6 * (1 + 0.37 * k),
                                         .gamma_n = 15 * (1 + 0.2 * k),
                                         .mu = 0.02 * (1 + k)};
    }
  for (int kind = 0; kind < 3; kind += BRIEF(1, 2)) { /* fixed disks, lines, circles */
    const double speed = 0.1, slide = -0.15, dt = 2e-7;
    sd_model *m = system_new_laws(kind ? SD_GEAR5 : SD_VERLET, SD_CONSERVATIVE, dt, M, laws);
    for (int k = 0; k < M * M; k++) {
      uint32_t d = system_disk(m, 4 * k, 1, 1, 1);
      system_velocity(m, d, slide, -speed, 0);
      m->disks[d].material = k / M;
    }
    for (int k = 0; k < M * M; k++) {
      double x = 4 * k;
      if (kind == 0) {
        uint32_t d = system_disk(m, x, -1, 1, 1);
        m->disks[d].driven = true;
        m->disks[d].material = k % M;
      } else {
        size_t w = kind == 1 ? system_straight(m, SD_WALL_SEGMENT, 2,
                                               (const double[][2]){{x - 1, 0}, {x + 1, 0}})
                             : system_circle(m, x, -1, 1, false);
        m->walls[w].material = k % M;
      }
    }
    sd_simulation *s = system_start(m);
    double most[M * M] = {0};
    for (int step = 0; step < 180000; step++) {
      system_advance(s, 1);
      if (step % 100 != 0) continue;
      const sd_state *q = sd_simulation_state(s);
      for (size_t c = 0; c < q->n_contacts; c++) {
        uint32_t a = q->contact_a[c];
        assert_int_equal(q->contact_b[c], a + M * M);
        const sd_contact_law *law = &laws[a];
        most[a] = fmax(most[a], q->contact_overlap[c]);
        double tau = -law->k_t * q->contact_zeta[c], cap = law->mu * q->contact_force[c];
        assert_true(fabs(tau) <= cap * (1 + 1e-12));
        if (q->contact_slide[c]) SYSTEM_NEAR(fabs(tau), cap, 1e-9 * cap + 1e-15, "Amonton");
      }
    }
    for (uint32_t k = 0; k < M * M; k++) {
      const sd_contact_law *law = &laws[k];
      system_body d = system_at(s, k);
      assert_false(system_touch(s, k, k + M * M).closed);
      double e = sd_restitution(law->k_n, law->gamma_n, 1).restitution, b = 0.5 * law->gamma_n;
      double w = sqrt(law->k_n - b * b), deep = speed / sqrt(law->k_n) * exp(-b / w * atan2(w, b));
      /* the normal of a round partner turns on the way */
      double bend = kind == 1 ? 0 : 1.5e-2;
      SYSTEM_NEAR(d.vy / speed, e, 1e-4 + bend, "pair %u: restitution", k);
      SYSTEM_NEAR(most[k] / deep, 1, 1e-3 + bend, "pair %u: overlap", k);
      if (kind == 1)
        SYSTEM_NEAR((d.vx - slide) / (law->mu * (1 + e) * speed), 1, 5e-3, "pair %u: friction", k);
      SYSTEM_NEAR(d.omega / (2 * law->mu * (1 + e) * speed), 1, 5e-3 + bend, "pair %u: spin", k);
    }
    system_end(s);
  }
}

RUN_TESTS(TEST(pair_revolves_in_a_drum), TEST(pair_revolves_ten_turns_stuck),
          TEST(ten_thousand_radians_against_a_support),
          TEST(new_contact_starts_at_the_moment_of_touch), TEST(skin_is_free_where_nothing_presses),
          TEST(pairs_of_materials_have_their_own_constants))
