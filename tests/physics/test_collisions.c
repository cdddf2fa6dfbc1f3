/* test_collisions.c: single collisions against closed forms, and Chung & Ooi's tests 1-8 with disks.
 *
 * C. Y. Chung & J. Y. Ooi, Granular Matter 13, 643 (2011), adapted to the linear law. Where the contact sticks
 * there is no closed form: `reference` integrates the two bodies with steps of its own, angle by atan2 and all.
 */
#include "brief.h"
#include "system.h"

enum { DISKS, LINE, LINE_BACK, SEGMENT, POLYLINE, CIRCLE, DRUM, KINDS };
static const char *const kind_names[] = {
    "disks", "line", "line from behind", "segment", "polyline", "circle", "drum"};

/* A disk hits a partner whose surface lies in direction beta; the partner (if a wall) and the frame move. */
typedef struct hit {
  int kind;
  double beta; /* direction from the disk to the partner's surface */
  double radius[2], mass[2];
  double speed, slide; /* of approach, and of the disk along t, relative to the partner */
  double spin[2];
  double frame[2]; /* velocity of the partner */
  sd_contact_law law;
  sd_integrator integrator;
  sd_variant variant;
  double dt;
} hit;

typedef struct outcome {
  double v_n, v_t; /* relative velocity after: v_n > 0 apart, v_t of the disk along t */
  double spin[2];
  double duration;       /* with F_n > 0 */
  double overlap, force; /* largest */
  double work_out;       /* largest difference between a half sine and the force, relative */
  sd_energy energy;
} outcome;

static void hit_wall(sd_model *m, const hit *h) {
  double nx = cos(h->beta), ny = sin(h->beta), r = h->radius[0];
  double along = h->kind == LINE_BACK ? -1 : 1;
  double p[3][2], at[3] = {-6, h->kind == POLYLINE ? -1 : 4, 4};
  for (int k = 0; k < 3; k++) {
    p[k][0] = r * nx - along * at[k] * ny;
    p[k][1] = r * ny + along * at[k] * nx;
  }
  size_t w = 0;
  if (h->kind == CIRCLE)
    w = system_circle(m, (r + h->radius[1]) * nx, (r + h->radius[1]) * ny, h->radius[1], false);
  else if (h->kind == DRUM)
    w = system_circle(m, (r - h->radius[1]) * nx, (r - h->radius[1]) * ny, h->radius[1], true);
  else if (h->kind == POLYLINE)
    w = system_straight(m, SD_WALL_POLYLINE, 3, (const double(*)[2])p);
  else
    w = system_straight(m, h->kind == SEGMENT ? SD_WALL_SEGMENT : SD_WALL_LINE, 2,
                        (const double(*)[2])p);
  for (int c = 0; c < 2; c++)
    if (h->frame[c] != 0) system_move(m, system_wall_body(m, w), c, h->frame[c]);
  if (h->spin[1] != 0) system_move(m, system_wall_body(m, w), SD_THETA, h->spin[1]);
}

static sd_simulation *hit_start(const hit *h) {
  sd_model *m = system_new(h->integrator, h->variant, h->dt, h->law);
  double nx = cos(h->beta), ny = sin(h->beta);
  system_disk(m, 0, 0, h->radius[0], h->mass[0]);
  double share = 1;
  if (h->kind == DISKS) {
    double sum = h->radius[0] + h->radius[1];
    system_disk(m, sum * nx, sum * ny, h->radius[1], h->mass[1]);
    system_velocity(m, 1, h->frame[0], h->frame[1], h->spin[1]);
  } else {
    hit_wall(m, h);
  }
  system_velocity(m, 0, h->frame[0] + share * (h->speed * nx - h->slide * ny),
                  h->frame[1] + share * (h->speed * ny + h->slide * nx), h->spin[0]);
  return system_start(m);
}

static double reduced(const hit *h) {
  return h->kind == DISKS ? h->mass[0] * h->mass[1] / (h->mass[0] + h->mass[1]) : h->mass[0];
}

static outcome hit_run(const hit *h) {
  sd_simulation *s = hit_start(h);
  outcome out = {0};
  double m = reduced(h), w = sqrt(h->law.k_n / m), scale = h->speed * sqrt(h->law.k_n * m);
  int64_t pushing = 0;
  bool pushed = false;
  for (int64_t k = 1;; k++) {
    system_advance(s, 1);
    system_contact c = system_touch(s, 0, 1);
    assert_true(c.pieces <= 1);
    if (c.force > 0) pushing++, pushed = true;
    out.overlap = fmax(out.overlap, c.overlap);
    out.force = fmax(out.force, c.force);
    double sine = fmax(scale * sin(w * (double)k * h->dt), 0);
    if (w * (double)k * h->dt < M_PI)
      out.work_out = fmax(out.work_out, fabs(c.force - sine) / scale);
    if (pushed && c.force <= 0) break;
    if ((double)k * h->dt * w > 100)
      fail_msg("%s, beta %g: never apart", kind_names[h->kind], h->beta);
  }
  out.duration = (double)pushing * h->dt;
  for (int k = 0; k < 400 && system_touch(s, 0, 1).closed; k++) system_advance(s, 1000);
  assert_false(system_touch(s, 0, 1).closed);
  system_body a = system_at(s, 0), b = system_at(s, 1);
  if (h->kind != DISKS) b.vx = h->frame[0], b.vy = h->frame[1];
  double nx = cos(h->beta), ny = sin(h->beta);
  out.v_n = (b.vx - a.vx) * nx + (b.vy - a.vy) * ny;
  out.v_t = (b.vx - a.vx) * ny - (b.vy - a.vy) * nx;
  out.spin[0] = a.omega;
  out.spin[1] = b.omega;
  out.energy = sd_simulation_energy(s);
  system_end(s);
  return out;
}

static hit head_on(int kind, sd_integrator integrator, sd_variant variant, double k_n,
                   double mass) {
  hit h = {.kind = kind,
           .radius = {1, kind == DRUM ? 5 : 1.7},
           .mass = {mass, 2.3},
           .speed = 0.1,
           .law = {.k_n = k_n, .k_t = 0.7 * k_n, .mu = 0.5},
           .integrator = integrator,
           .variant = variant};
  h.dt = 1e-4 / sqrt(k_n / reduced(&h));
  return h;
}

static void restitution_over_a_grid_of_damping(void **unused) {
  static const double damping[] = {0, 0.01, 0.1, 0.3, 0.7, 0.95, 1, 1.05, 1.5, 3};
  double worst = 0, late = 0;
  int run = 0;
  for (int kind = 0; kind < KINDS; kind++)
    for (int integrator = 0; integrator < 2; integrator++)
      for (size_t d = 0; d < sizeof damping / sizeof *damping; d += BRIEF(1, 4), run++) {
        /* masses, directions, variants and frames change from run to run */
        hit h =
            head_on(kind, (sd_integrator)integrator, (sd_variant)(run % 2), 1e4, run % 3 ? 1 : 0.2);
        h.beta = run % 4 ? 0.37 * run : M_PI + (run % 3 - 1) * 1e-17;
        h.frame[0] = run % 5 ? 0.03 : 0;
        h.frame[1] = run % 5 ? -0.05 : 0;
        double m = reduced(&h);
        h.law.gamma_n = 2 * damping[d] * sqrt(h.law.k_n * m);
        sd_collision expected = sd_restitution(h.law.k_n, h.law.gamma_n, m);
        outcome out = hit_run(&h);
        double e = out.v_n / h.speed;
        SYSTEM_NEAR(e, expected.restitution, 1e-4, "%s, %s, damping %g: restitution",
                    kind_names[kind], system_integrators[integrator], damping[d]);
        SYSTEM_NEAR(out.duration, expected.duration, 2.5 * h.dt, "%s, damping %g: duration",
                    kind_names[kind], damping[d]);
        SYSTEM_NEAR(out.v_t, 0, 1e-9, "%s: nothing along the surface", kind_names[kind]);
        SYSTEM_NEAR(out.spin[0], 0, 1e-8, "%s: no spin", kind_names[kind]);
        worst = fmax(worst, fabs(e - expected.restitution));
        late = fmax(late, fabs(out.duration - expected.duration) / h.dt);
      }
  print_message("restitution: largest error %.2g; duration: %.2g steps\n", worst, late);
}

/* The error of e is due to the first step, in which the viscous force appears: first order in dt. */
static void restitution_converges(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++) {
    double error[3];
    for (int k = 0; k < 3; k++) {
      hit h = head_on(DISKS, (sd_integrator)integrator, SD_PAPER, 1e4, 1);
      double m = reduced(&h);
      h.law.gamma_n = 0.6 * sqrt(h.law.k_n * m);
      h.dt = 4e-3 / (1 << k) / sqrt(h.law.k_n / m);
      error[k] =
          fabs(hit_run(&h).v_n / h.speed - sd_restitution(h.law.k_n, h.law.gamma_n, m).restitution);
    }
    print_message("restitution, %s: errors %.2g %.2g %.2g at w dt = 4e-3, 2e-3, 1e-3\n",
                  system_integrators[integrator], error[0], error[1], error[2]);
    assert_true(error[0] < 4e-3 && error[1] < 0.6 * error[0] && error[2] < 0.6 * error[1]);
  }
}

/* Half a sine: F = v sqrt(k m) sin(w t), largest overlap v sqrt(m/k), duration pi sqrt(m/k). */
static void tests_1_and_2_elastic_normal_impact(void **unused) {
  for (int kind = 0; kind < KINDS; kind++)
    for (int integrator = 0; integrator < 2; integrator++) {
      hit h = head_on(kind, (sd_integrator)integrator, SD_CONSERVATIVE, 2e5, 1.5);
      if (kind == DISKS) h.mass[1] = h.mass[0], h.radius[1] = h.radius[0];
      h.dt *= 10;
      h.beta = 2.1;
      outcome out = hit_run(&h);
      double m = reduced(&h), root = sqrt(m / h.law.k_n);
      SYSTEM_NEAR(out.work_out, 0, 5e-6, "%s: force against time", kind_names[kind]);
      SYSTEM_NEAR(out.overlap, h.speed * root, 1e-6 * h.speed * root, "%s: overlap",
                  kind_names[kind]);
      SYSTEM_NEAR(out.force, h.speed * sqrt(m * h.law.k_n), 1e-6 * h.speed * sqrt(m * h.law.k_n),
                  "force");
      SYSTEM_NEAR(out.duration, M_PI * root, 2 * h.dt, "%s: duration", kind_names[kind]);
      SYSTEM_NEAR(out.v_n, h.speed, 1e-6 * h.speed, "%s: speed", kind_names[kind]);
      /* the force of the last step works over the gap, too: what that gives is booked, and nothing else is lost */
      double gained = 0.5 * m * (out.v_n * out.v_n - h.speed * h.speed);
      SYSTEM_NEAR(out.energy.viscous + gained, 0, 5e-8 * h.speed * h.speed, "no other loss");
    }
}

/* gamma_n such that e is what was asked for (Chung & Ooi 3), found by bisection of the closed form. */
static void test_3_restitution_asked_for(void **unused) {
  for (double e = 0.2; e < 1.01; e += BRIEF(0.2, 0.8))
    for (int kind = 0; kind < KINDS; kind++) {
      hit h = head_on(kind, SD_GEAR5, SD_PAPER, 1e6, 4);
      double m = reduced(&h), low = 0, high = 4 * sqrt(h.law.k_n * m);
      for (int k = 0; k < 60; k++) {
        h.law.gamma_n = 0.5 * (low + high);
        *(sd_restitution(h.law.k_n, h.law.gamma_n, m).restitution > e ? &low : &high) =
            h.law.gamma_n;
      }
      outcome out = hit_run(&h);
      SYSTEM_NEAR(out.v_n / h.speed, e, 1e-4, "%s: restitution", kind_names[kind]);
      double kinetic = 0.5 * m * h.speed * h.speed;
      SYSTEM_NEAR(out.energy.viscous / kinetic, 1 - e * e, 2e-4, "%s: viscous loss",
                  kind_names[kind]);
    }
}

typedef struct planar {
  double x[6], v[6]; /* x, y, theta of both */
} planar;

typedef struct reference_run {
  const hit *h;
  double star, beta; /* lambda*, and the last angle: unwrapped */
} reference_run;

/* Forces at (x, v); moves lambda* only when told to. False when apart. */
static bool reference_forces(reference_run *q, const planar *p, double f[6], bool commit) {
  const hit *h = q->h;
  double ra = h->radius[0], rb = h->kind == DRUM ? -h->radius[1] : h->radius[1];
  double dx = p->x[3] - p->x[0], dy = p->x[4] - p->x[1];
  if (rb < 0) dx = -dx, dy = -dy;
  double r = hypot(dx, dy), nx = dx / r, ny = dy / r;
  if (rb < 0) r = -r;
  double delta = ra + rb - r;
  memset(f, 0, 6 * sizeof *f);
  if (delta <= 0) return false;
  double beta = atan2(ny, nx);
  beta += 2 * M_PI * nearbyint((q->beta - beta) / (2 * M_PI));
  double approach = (p->v[3] - p->v[0]) * nx + (p->v[4] - p->v[1]) * ny;
  double normal = fmax(h->law.k_n * delta - h->law.gamma_n * approach, 0);
  double lambda = ra * p->x[2] + rb * p->x[5] - beta * (ra + rb),
         cap = h->law.mu * normal / h->law.k_t;
  double zeta = fmin(fmax(lambda - q->star, -cap), cap);
  if (commit) q->star = lambda - zeta, q->beta = beta;
  double tau = -h->law.k_t * zeta, push = h->variant == SD_CONSERVATIVE ? tau * (ra + rb) / r : tau;
  f[3] = normal * nx + push * ny;
  f[4] = normal * ny - push * nx;
  f[0] = -f[3];
  f[1] = -f[4];
  f[2] = tau * ra;
  f[5] = tau * rb;
  return true;
}

/* Leapfrog with half steps of velocity; forces see the velocity in the middle of the step, twice improved. */
static outcome reference(const hit *h, double dt) {
  double nx = cos(h->beta), ny = sin(h->beta);
  bool disks = h->kind == DISKS;
  double sum = h->radius[0] + (h->kind == DRUM ? -h->radius[1] : h->radius[1]);
  double inertia[2] = {0.5 * h->mass[0] * h->radius[0] * h->radius[0],
                       0.5 * h->mass[1] * h->radius[1] * h->radius[1]};
  double inverse[6] = {1 / h->mass[0], 1 / h->mass[0], 1 / inertia[0], 0, 0, 0};
  if (disks) inverse[3] = inverse[4] = 1 / h->mass[1], inverse[5] = 1 / inertia[1];
  planar p = {.x = {0, 0, 0, sum * nx, sum * ny, 0},
              .v = {h->speed * nx - h->slide * ny, h->speed * ny + h->slide * nx, h->spin[0], 0, 0,
                    h->spin[1]}};
  reference_run q = {.h = h, .beta = h->beta, .star = -h->beta * sum};
  double f[6];
  bool touching = true;
  for (int64_t k = 0; touching || k < 3; k++) {
    planar half = p;
    for (int c = 0; c < 6; c++) half.x[c] = p.x[c] + 0.5 * dt * p.v[c];
    for (int again = 0; again < 3; again++) {
      touching = reference_forces(&q, &half, f, false);
      for (int c = 0; c < 6; c++) half.v[c] = p.v[c] + 0.5 * dt * f[c] * inverse[c];
    }
    reference_forces(&q, &half, f, true);
    for (int c = 0; c < 6; c++) {
      p.v[c] += dt * f[c] * inverse[c];
      p.x[c] = half.x[c] + 0.5 * dt * p.v[c];
    }
  }
  return (outcome){.v_n = (p.v[3] - p.v[0]) * nx + (p.v[4] - p.v[1]) * ny,
                   .v_t = (p.v[3] - p.v[0]) * ny - (p.v[4] - p.v[1]) * nx,
                   .spin = {p.v[2], p.v[5]}};
}

/* Flat wall: two oscillators, the normal one in closed form. v_t and R spin after, relative to the wall. */
static outcome oscillators(const hit *h) {
  double b = h->law.gamma_n / (2 * h->mass[0]), w = sqrt(h->law.k_n / h->mass[0] - b * b);
  sd_collision c = sd_restitution(h->law.k_n, h->law.gamma_n, h->mass[0]);
  const int n = 400000;
  double dt = c.duration / n, v = h->slide, u = h->radius[0] * h->spin[0], zeta = 0;
  double mass = h->mass[0];
  for (int k = 0; k < n; k++) {
    double t = (k + 0.5) * dt, delta = h->speed / w * exp(-b * t) * sin(w * t);
    double rate = h->speed * exp(-b * t) * (cos(w * t) - b / w * sin(w * t));
    double cap = h->law.mu * fmax(h->law.k_n * delta + h->law.gamma_n * rate, 0) / h->law.k_t;
    zeta = fmin(fmax(zeta + 0.5 * dt * (v + u), -cap), cap);
    v -= dt * h->law.k_t * zeta / mass;
    u -= dt * h->law.k_t * zeta * 2 / mass; /* R torque/I = 2 R^2 tau/(m R^2) */
    zeta += 0.5 * dt * (v + u);
  }
  return (outcome){.v_n = h->speed * c.restitution, .v_t = v, .spin = {u / h->radius[0], 0}};
}

static void compare(const hit *h, const outcome *out, const outcome *expected, double tolerance,
                    const char *what) {
  double scale =
      h->speed + fabs(h->slide) + h->radius[0] * fabs(h->spin[0]) + h->radius[1] * fabs(h->spin[1]);
  const char *kind = kind_names[h->kind], *integrator = system_integrators[h->integrator];
  SYSTEM_NEAR(out->v_n, expected->v_n, tolerance * scale, "%s, %s, %s: v_n", what, kind,
              integrator);
  SYSTEM_NEAR(out->v_t, expected->v_t, tolerance * scale, "%s, %s, %s: v_t", what, kind,
              integrator);
  SYSTEM_NEAR(h->radius[0] * out->spin[0], h->radius[0] * expected->spin[0], tolerance * scale,
              "%s, %s, %s: spin", what, kind, integrator);
  if (h->kind == DISKS)
    SYSTEM_NEAR(h->radius[1] * out->spin[1], h->radius[1] * expected->spin[1], tolerance * scale,
                "%s, %s, %s: spin of the other", what, kind, integrator);
}

static hit oblique(int kind, int integrator, double e_damping) {
  hit h = head_on(kind, (sd_integrator)integrator, SD_CONSERVATIVE, 1e6, 1);
  h.law.k_t = 2.0 / 7.0 * h.law.k_n;
  h.law.mu = 0.3;
  h.law.gamma_n = 2 * e_damping * sqrt(h.law.k_n * reduced(&h));
  h.dt = 2e-4 / sqrt(h.law.k_n / reduced(&h));
  h.beta = 2.8;
  return h;
}

/* Sliding all through: with a stiff skin, whose stretching takes next to no time. */
static void check_gross_sliding(const hit *soft, double e, const char *what) {
  hit h = *soft;
  h.law.k_t = 100 * h.law.k_n;
  outcome out = hit_run(&h);
  double m = h.mass[0], r = h.radius[0], sense = h.slide + r * h.spin[0] < 0 ? -1 : 1;
  sd_oblique slid =
      sd_gross_sliding(m, 0.5 * m * r * r, r, h.law.mu, e, h.speed, h.slide, h.spin[0]);
  assert_true(slid.sliding);
  outcome closed = {.v_n = slid.v_n, .v_t = slid.v_t, .spin = {slid.spin, 0}};
  compare(&h, &out, &closed, 3e-5, "gross sliding");
  double scale = fabs(h.slide) + r * fabs(h.spin[0]), impulse = h.law.mu * (1 + e) * h.speed;
  SYSTEM_NEAR(out.v_t, h.slide - sense * impulse, 3e-5 * scale, "%s: v_t", what);
  SYSTEM_NEAR(r * (out.spin[0] - h.spin[0]), -sense * 2 * impulse, 3e-5 * scale, "%s: R d omega",
              what);
  double before = m * (h.slide * h.slide + 0.5 * r * r * h.spin[0] * h.spin[0]);
  double after = m * (slid.v_t * slid.v_t + 0.5 * r * r * slid.spin * slid.spin);
  SYSTEM_NEAR(out.energy.friction, 0.5 * (before - after), 1e-4 * before, "%s: friction", what);
  SYSTEM_NEAR(out.energy.viscous, 0.5 * m * (1 - e * e) * h.speed * h.speed,
              1e-4 * m * h.speed * h.speed, "%s: viscosity", what);
}

/* The oscillators, and the closed form where the surface slides all through. Returns whether it did. */
static bool check_wall_hit(const hit *h, double tolerance, const char *what) {
  outcome out = hit_run(h), expected = oscillators(h);
  compare(h, &out, &expected, tolerance, what);
  double e = sd_restitution(h->law.k_n, h->law.gamma_n, h->mass[0]).restitution;
  bool sliding = fabs(h->slide + h->radius[0] * h->spin[0]) > 3.3 * h->law.mu * (1 + e) * h->speed;
  if (sliding && h->frame[0] == 0) check_gross_sliding(h, e, what);
  return sliding;
}

static void test_4_oblique_impact_at_constant_speed(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int kind = LINE; kind <= POLYLINE; kind++) {
      int slid = 0;
      for (double angle = 0.05; angle < 1.4; angle += BRIEF(0.15, 1.2)) {
        hit h = oblique(kind, integrator, 0.05);
        h.speed = 0.2 * cos(angle);
        h.slide = 0.2 * sin(angle);
        slid += check_wall_hit(&h, 1e-4, "test 4");
      }
      assert_in_range(slid, 1, 8);
    }
}

static void test_5_oblique_impact_at_constant_normal_velocity(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int kind = LINE; kind <= POLYLINE; kind++)
      for (double ratio = -5; ratio < 5.1; ratio += BRIEF(0.63, 5.04)) {
        hit h = oblique(kind, integrator, ratio > 0 ? 0.1 : 0);
        h.slide = ratio * h.speed;
        h.frame[0] = 0.02;
        check_wall_hit(&h, 1e-4, "test 5");
      }
}

static void test_6_spinning_disk_on_a_wall(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int kind = LINE; kind <= POLYLINE; kind++)
      for (double spin = -0.6; spin < 0.61; spin += BRIEF(0.1, 0.6)) {
        hit h = oblique(kind, integrator, 0.1);
        h.spin[0] = spin;
        h.radius[0] = 0.8;
        check_wall_hit(&h, 1e-4, "test 6");
      }
}

static void test_7_two_equal_spinning_disks(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int variant = BRIEF(0, integrator); variant < BRIEF(2, integrator + 1); variant++)
      for (double spin = -1; spin < 1.01; spin += BRIEF(0.23, 0.92)) {
        hit h = oblique(DISKS, integrator, 0.1);
        h.variant = (sd_variant)variant;
        h.radius[1] = h.radius[0];
        h.mass[1] = h.mass[0];
        h.beta = M_PI; /* across the branch cut of the angle */
        h.spin[0] = h.spin[1] = spin;
        outcome out = hit_run(&h), expected = reference(&h, 0.25 * h.dt);
        compare(&h, &out, &expected, 1e-4, "test 7");
        /* equal disks with equal spins stay so, and keep their centre */
        SYSTEM_NEAR(out.spin[0], out.spin[1], 1e-12, "test 7: symmetry");
      }
}

static void test_8_two_different_spinning_disks(void **unused) {
  double worst = 0;
  for (int integrator = 0; integrator < 2; integrator++)
    for (int variant = BRIEF(0, integrator); variant < BRIEF(2, integrator + 1); variant++)
      for (double spin = -1; spin < 1.01; spin += BRIEF(0.23, 0.92)) {
        hit h = oblique(DISKS, integrator, 0.03);
        h.variant = (sd_variant)variant;
        h.law.k_n = 1e4; /* soft: overlaps of 1 % */
        h.law.gamma_n = 1;
        h.dt = 2e-4 / sqrt(h.law.k_n / reduced(&h));
        h.spin[0] = spin;
        h.spin[1] = -0.3 * spin;
        h.slide = 0.1;
        outcome out = hit_run(&h), expected = reference(&h, 0.25 * h.dt);
        compare(&h, &out, &expected, 1e-4, "test 8");
        worst = fmax(worst, fabs(out.v_t - expected.v_t));
      }
  print_message("test 8: largest difference in v_t from the reference %.2g\n", worst);
}

static void round_walls_turning_with_a_disk_on_them(void **unused) {
  for (int kind = CIRCLE; kind <= DRUM; kind++)
    for (int integrator = 0; integrator < 2; integrator++)
      for (int variant = 0; variant < 2; variant++)
        for (double spin = -0.5; spin < 0.6; spin += 0.25) {
          hit h = oblique(kind, integrator, 0.1);
          h.variant = (sd_variant)variant;
          h.law.k_n = 1e4;
          h.law.gamma_n = 2;
          h.dt = 2e-4 / sqrt(h.law.k_n / h.mass[0]);
          h.slide = -0.13;
          h.spin[0] = 0.1;
          h.spin[1] = spin;
          outcome out = hit_run(&h), expected = reference(&h, 0.25 * h.dt);
          compare(&h, &out, &expected, 1e-4, "turning round wall");
        }
}

/* Gear's predicted and corrected coordinates can differ in whether a disk touches that arrives at touch to rounding. A
 * contact begins where its force is evaluated: no force acts without it, and the energy budget closes. */
static void arrival_at_touch_to_rounding(void **state) {
  const double dt = 1e-5, speed = 1, gamma_n = 1, one_step = gamma_n * speed * speed * dt;
  const sd_contact_law law = {.k_n = 1e3, .k_t = 500, .gamma_n = gamma_n, .mu = 0.1};
  static const int kinds[] = {DISKS, LINE, SEGMENT, POLYLINE, CIRCLE};
  int found = 0;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (int steps = 90; steps < 93; steps++)
      for (int ulps = -4; ulps <= 4; ulps++)
        for (int integrator = SD_GEAR5; integrator <= SD_VERLET; integrator++) {
          hit h = {.kind = kinds[kind], .radius = {1, 1}, .mass = {0.1, 0.2}, .law = law, .dt = dt};
          sd_model *m = system_new((sd_integrator)integrator, SD_PAPER, dt, law);
          system_disk(m, -steps * dt * speed + ulps * 1.1e-16, 0, 1, 0.1);
          if (h.kind == DISKS)
            system_disk(m, 2, 0, 1, 0.2);
          else
            hit_wall(m, &h);
          system_velocity(m, 0, speed, 0.3, 0);
          sd_simulation *s = system_start(m);
          assert_int_equal(sd_simulation_advance(s, steps - 1, NULL), SD_OK);
          double before = 0;
          for (int k = 0; k < 3; k++) {
            assert_int_equal(sd_simulation_advance(s, 1, NULL), SD_OK);
            bool apart = sd_simulation_state(s)->n_contacts == 0;
            double pushed = fabs(sd_simulation_state(s)->vx[0] - speed);
            assert_false(apart && pushed > 1e-9 && before == 0);
            found += !apart && before == 0;
            before = pushed > 1e-9;
          }
          assert_int_equal(sd_simulation_advance(s, 6000, NULL), SD_OK);
          sd_energy e = sd_simulation_energy(s);
          assert_int_equal(sd_simulation_state(s)->n_contacts, 0);
          SYSTEM_NEAR(e.residual, 0, 1e-3 * one_step, "%s on %s, %d steps, %d ulps: residual",
                      system_integrators[integrator], kind_names[h.kind], steps, ulps);
          system_end(s);
        }
  assert_true(found >= 200); /* they do touch */
}

RUN_TESTS(TEST(restitution_over_a_grid_of_damping), TEST(restitution_converges),
          TEST(arrival_at_touch_to_rounding), TEST(tests_1_and_2_elastic_normal_impact),
          TEST(test_3_restitution_asked_for), TEST(test_4_oblique_impact_at_constant_speed),
          TEST(test_5_oblique_impact_at_constant_normal_velocity),
          TEST(test_6_spinning_disk_on_a_wall), TEST(test_7_two_equal_spinning_disks),
          TEST(test_8_two_different_spinning_disks), TEST(round_walls_turning_with_a_disk_on_them))
