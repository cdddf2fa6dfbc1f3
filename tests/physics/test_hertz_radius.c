/* test_hertz_radius.c: Hertz' law by a modulus, k_h = 4/3 E* sqrt(R_eff): closed forms of
 * impacts on bodies of other radii, the same motion as by the k_n and k_t of the pair, a disk
 * that rolls onto an arc, changes of a running simulation. */
#include "laws.h"

enum { DISK, FIXED, LINE, SEGMENT, ROUND, HOLLOW, HILL, BOWL, SHAPES };
static const char *const shapes[] = {"disk",  "fixed disk", "line", "segment",
                                     "round", "hollow",     "hill", "bowl"};

typedef struct impact {
  int shape;
  double ra, rb; /* of the disk, and of the other body; straight walls: any */
  bool general;  /* not the step of small systems */
  int integrator;
  double dt, vx, vy, omega;
} impact;

static const double mass_a = 0.1, mass_b = 0.3, gap = 1e-6;

static double mass_of(const impact *q) {
  return q->shape == DISK ? mass_a * mass_b / (mass_a + mass_b) : mass_a;
}

/* Returns R_eff by the formula of each shape; law_arm is not used. */
static double radius_of(const impact *q) {
  if (q->shape == LINE || q->shape == SEGMENT) return q->ra;
  const bool inside = q->shape == HOLLOW || q->shape == BOWL;
  return 1 / (1 / q->ra + (inside ? -1 : 1) / q->rb);
}

/* The disk's centre is the origin; the other body lies below it. */
static sd_simulation *begin_impact(const impact *q, const law *l) {
  const double below = -q->ra - gap;
  text t = {0};
  text_add(&t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n"
           "materials = ( ",
           q->dt, system_integrators[q->integrator]);
  law_add(&t, "name = \"m\"", l);
  text_add(&t,
           " );\ndisks = ( { x = 0; y = 0; radius = %.17g; mass = %.17g; vx = %.17g; vy = %.17g; "
           "omega = %.17g; }",
           q->ra, mass_a, q->vx, q->vy, q->omega);
  if (q->shape <= FIXED)
    text_add(&t, ", { x = 0; y = %.17g; radius = %.17g; mass = %.17g; fixed = %s; }", below - q->rb,
             q->rb, mass_b, q->shape == FIXED ? "true" : "false");
  text_add(&t, " );\n");
  if (q->shape == LINE || q->shape == SEGMENT)
    text_add(&t, "walls = ( { type = \"%s\"; points = ( (-1, %.17g), (1, %.17g) ); } );\n",
             shapes[q->shape], below, below);
  if (q->shape == ROUND || q->shape == HOLLOW)
    text_add(&t,
             "walls = ( { type = \"circle\"; center = (0, %.17g); radius = %.17g; side = \"%s\"; } "
             ");\n",
             q->shape == ROUND ? below - q->rb : below + q->rb, q->rb,
             q->shape == ROUND ? "outside" : "inside");
  if (q->shape == HILL || q->shape == BOWL)
    text_add(&t,
             "walls = ( { type = \"arc\"; center = (0, %.17g); radius = %.17g; from = \"%d deg\"; "
             "to = \"%d deg\"; } );\n",
             q->shape == HILL ? below - q->rb : below + q->rb, q->rb, q->shape == HILL ? 30 : 210,
             q->shape == HILL ? 150 : 330);
  return laws_begin(&t, q->general);
}

/* Visits all shapes, ratios of the radii, steps and integrators. */
#define EACH_IMPACT(q)                                                                             \
  for (int case_ = 0; case_ < SHAPES * 4 * 4; case_++)                                             \
    for (impact q = {.shape = case_ % SHAPES,                                                      \
                    .ra = 0.3,                                                                     \
                    .rb = 0.3 * ratios[case_ / SHAPES % 4],                                        \
                    .general = case_ / SHAPES / 4 & 1,                                             \
                    .integrator = case_ / SHAPES / 8};                                             \
         is_possible(&q); q.ra = 0)
static const double ratios[] = {1, 1.0 / 3, 0.05, 7};

/* A hollow body is larger than the disk; a flat one has one radius. */
static bool is_possible(const impact *q) {
  const bool hollow = q->shape == HOLLOW || q->shape == BOWL,
             flat = q->shape == LINE || q->shape == SEGMENT;
  return q->ra > 0 && !(hollow && q->rb <= q->ra) && !(flat && q->rb != q->ra);
}

static const double modulus = 1e5, nu = 0.3;

/* Duration 2 (5 m/4 k)^(2/5) v^(-1/5) I, I = sqrt(pi) Gamma(7/5)/Gamma(9/10) (2.94 (5 m/4
 * k)^(2/5) v^(-1/5)), largest overlap (5 m v^2/4 k)^(2/5), with k = 4/3 E* sqrt(R_eff). */
static void elastic_impacts(void **unused) {
  const law l = {.normal = SD_NORMAL_HERTZ, .E_star = modulus};
  const double v = 0.2, integral = sqrt(M_PI) * tgamma(1.4) / tgamma(0.9);
  double worst[3] = {0};
  int n = 0;
  EACH_IMPACT(q) {
    const double k = 4.0 / 3 * modulus * sqrt(radius_of(&q)), m = mass_of(&q);
    const double t = 2 * pow(1.25 * m / k, 0.4) * pow(v, -0.2) * integral,
                 depth = pow(1.25 * m * v * v / k, 0.4);
    q.dt = t / 4000;
    q.vy = -v;
    sd_simulation *s = begin_impact(&q, &l);
    double deepest = 0;
    int64_t closed = 0;
    for (int64_t step = 0; step < 40000; step++) {
      system_advance(s, 1);
      const sd_state *state = sd_simulation_state(s);
      if (closed && !state->n_contacts) break;
      closed += state->n_contacts > 0;
      if (state->n_contacts) deepest = fmax(deepest, state->contact_overlap[0]);
    }
    const double e = (system_at(s, 0).vy - (q.shape == DISK ? system_at(s, 1).vy : 0)) / v,
                 off[] = {fabs((double)closed * q.dt / t - 1), fabs(deepest / depth - 1),
                          laws_residual(s)};
    SYSTEM_NEAR((double)closed * q.dt, t, 3 * q.dt, "%s, %g: duration", shapes[q.shape], q.rb);
    SYSTEM_NEAR(deepest, depth, 2e-6 * depth, "%s, %g: largest overlap", shapes[q.shape], q.rb);
    SYSTEM_NEAR(e, 1, 1e-6, "%s, %g: speed after the impact", shapes[q.shape], q.rb);
    SYSTEM_NEAR(off[2], 0, 1e-6, "%s, %g: residual", shapes[q.shape], q.rb);
    for (int c = 0; c < 3; c++) worst[c] = fmax(worst[c], off[c]);
    n++;
    system_end(s);
  }
  print_message("%d elastic impacts: duration within %.1e, overlap within %.1e, residual %.1e\n", n,
                worst[0], worst[1], worst[2]);
  assert_true(n > 60);
}

/* The restitution and everything that refers to k_n and k_t: a law by modulus moves the bodies
 * as the law with the stiffnesses of this pair does, and has the same energies. */
static void same_as_by_stiffness(void **unused) {
  static const law tails[] = {
      {.restitution = 0.6},
      {.restitution = 0.6, .damping_pulls = true, .mu = 0.4, .tangential = SD_TANGENTIAL_MINDLIN},
      {.gamma_n = 1,
       .mu = 0.4,
       .mu_kinetic = 0.3,
       .tangential = SD_TANGENTIAL_MINDLIN,
       .gamma_t = 0.5},
      {.gamma_n = 1, .mu = 0.4, .k_t = 2e3, .gamma_t = 0.5}, /* k_t as given, with E_star */
      {.mu = 0.5, .tangential = SD_TANGENTIAL_MINDLIN, .k_r = 1e3, .gamma_r = 0.1, .mu_r = 0.1},
      {.mu = 0.5,
       .tangential = SD_TANGENTIAL_MINDLIN,
       .cohesion = SD_COHESION_BRIDGE,
       .pull_off = 0.1,
       .range = 1e-4,
       .rupture = 2e-4}};
  double worst = 0;
  for (size_t tail = 0; tail < sizeof tails / sizeof *tails; tail++) EACH_IMPACT(q) {
      const double k = 4.0 / 3 * modulus * sqrt(radius_of(&q));
      q.dt = 2e-5;
      q.vx = 0.3;
      q.vy = -0.2;
      q.omega = 0.5;
      law by_modulus = tails[tail], by_stiffness = tails[tail];
      by_modulus.normal = by_stiffness.normal = SD_NORMAL_HERTZ;
      by_modulus.E_star = modulus;
      by_stiffness.k_n = k;
      if (tails[tail].tangential == SD_TANGENTIAL_MINDLIN) by_modulus.poisson = nu;
      if (tails[tail].tangential == SD_TANGENTIAL_MINDLIN)
        by_stiffness.k_t = k * 3 * (1 - nu) / (2 - nu);
      sd_simulation *s[] = {begin_impact(&q, &by_modulus), begin_impact(&q, &by_stiffness)};
      for (int part = 0; part < 8; part++) {
        for (int which = 0; which < 2; which++) system_advance(s[which], 300);
        const system_body a = system_at(s[0], 0), b = system_at(s[1], 0);
        const sd_energy one = sd_simulation_energy(s[0]), two = sd_simulation_energy(s[1]);
        const double off[] = {a.vx - b.vx, a.vy - b.vy, q.ra * (a.omega - b.omega)};
        for (int c = 0; c < 3; c++) {
          SYSTEM_NEAR(off[c], 0, 1e-11, "%s, %g, law %zu, part %d: velocity %d", shapes[q.shape],
                      q.rb, tail, part, c);
          worst = fmax(worst, fabs(off[c]));
        }
        for (size_t c = 0; c < offsetof(sd_energy, residual) / sizeof(double); c++)
          SYSTEM_NEAR(((const double *)&one)[c], ((const double *)&two)[c], 1e-12 * mass_a,
                      "%s, %g, law %zu, part %d: energy %zu", shapes[q.shape], q.rb, tail, part, c);
      }
      system_end(s[0]);
      system_end(s[1]);
    }
  print_message("velocities by modulus and by stiffness differ by %.1e at most\n", worst);
}

/* Small systems and the general step: the same bits. */
static void two_ways(void **unused) {
  const law l = {.normal = SD_NORMAL_HERTZ,
                 .E_star = modulus,
                 .poisson = nu,
                 .tangential = SD_TANGENTIAL_MINDLIN,
                 .mu = 0.4,
                 .mu_kinetic = 0.3,
                 .gamma_t = 0.5,
                 .restitution = 0.7,
                 .k_r = 1e3,
                 .mu_r = 0.1};
  EACH_IMPACT(q) {
    if (q.general) continue;
    q.dt = 2e-5;
    q.vx = 0.3;
    q.vy = -0.2;
    impact other = q;
    other.general = true;
    sd_simulation *one = begin_impact(&q, &l), *two = begin_impact(&other, &l);
    for (int part = 0; part < 8; part++) {
      system_advance(one, 300);
      system_advance(two, 300);
      const system_body a = system_at(one, 0), b = system_at(two, 0);
      assert_true(a.x == b.x && a.vx == b.vx && a.vy == b.vy && a.theta == b.theta);
    }
    system_end(one);
    system_end(two);
  }
}

/* A disk on a floor that continues in a bowl, a quarter of a circle: it rolls up and comes back.
 * R_eff, and with it the energy, changes where the floor ends; the budget closes with the square
 * of the step, and the disk comes back with the speed that the losses leave. */
static double roll_into_bowl(int integrator, double dt, bool mindlin, double *viscous) {
  text t = {0};
  const law l = {.normal = SD_NORMAL_HERTZ,
                 .E_star = modulus,
                 .mu = 0.5,
                 .tangential = mindlin,
                 .poisson = mindlin ? nu : 0,
                 .k_t = mindlin ? 0 : 1e4,
                 .gamma_n = 5};
  text_add(&t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n"
           "gravity = { g = 9.81; };\nmaterials = ( ",
           dt, system_integrators[integrator]);
  law_add(&t, "name = \"m\"", &l);
  text_add(&t, " );\nwalls = ( { type = \"segment\"; points = ( (-1, 0), (0, 0) ); },\n"
               "{ type = \"arc\"; center = (0, 0.5); radius = 0.5; from = \"-90 deg\"; to = \"0 "
               "deg\"; } );\n"
               "disks = ( { x = -0.1; y = 0.29999; radius = 0.3; mass = 0.1; vx = 0.5; omega = "
               "-1.6666; } );\n");
  sd_simulation *s = laws_begin(&t, true);
  bool on_arc = false;
  for (int part = 0; part < 100; part++) {
    system_advance(s, (int64_t)(0.01 / dt + 0.5));
    on_arc = on_arc || system_at(s, 0).x > 0.005;
  }
  assert_true(on_arc && system_at(s, 0).x < -0.05 && system_at(s, 0).vx < -0.3);
  const double residual = sd_simulation_energy(s).residual;
  *viscous = sd_simulation_energy(s).viscous;
  system_end(s);
  return fabs(residual);
}

static void joints(void **unused) {
  const double kinetic = 0.5 * 0.1 * 1.5 * 0.25;
  for (int mindlin = 0; mindlin < 2; mindlin++)
    for (int integrator = 0; integrator < 2; integrator++) {
      double viscous;
      const double coarse = roll_into_bowl(integrator, 2e-5, mindlin, &viscous),
                   fine = roll_into_bowl(integrator, 1e-5, mindlin, &viscous);
      print_message("into a bowl, %s%s: residual over the kinetic energy %.1e, with half the step "
                    "%.1e; viscous %.1e\n",
                    system_integrators[integrator], mindlin ? ", mindlin" : "", coarse / kinetic,
                    fine / kinetic, viscous / kinetic);
      assert_true(fine < 1e-6 * kinetic && fine < coarse);
    }
}

static double get(sd_simulation *s, const char *name) { return sd_simulation_get(s, name, 0); }

static void set(sd_simulation *s, const char *name, double value, const char *refused) {
  sd_messages *messages = sd_messages_new();
  const uint32_t first = 0;
  const sd_status status = sd_simulation_set(s, name, 1, &first, &value, messages);
  if ((status != SD_OK) != (refused != NULL) ||
      (refused && !strstr(sd_messages_text(messages, 0), refused))) {
    sd_messages_print(messages, stderr);
    fail_msg("%s = %g: expected %s", name, value, refused ? refused : "no message");
  }
  sd_messages_free(messages);
}

/* Modulus, Poisson's ratio and radius change while disks touch: the change of the energy is
 * work, the residual stays. */
static void steering(void **unused) {
  const law l = {.normal = SD_NORMAL_HERTZ,
                 .E_star = modulus,
                 .poisson = nu,
                 .tangential = SD_TANGENTIAL_MINDLIN,
                 .mu = 0.4,
                 .gamma_n = 1};
  const double ratio = 3 * (1 - 0.2) / (2 - 0.2);
  EACH_IMPACT(q) {
    if (q.shape == SEGMENT || q.shape == BOWL) continue;
    q.dt = 2e-5;
    q.vy = -0.2;
    q.vx = 0.1;
    sd_simulation *s = begin_impact(&q, &l);
    sd_model *first = (sd_model *)(uintptr_t)sd_simulation_model(s); /* set makes another one */
    system_advance(s, 150);
    assert_true(sd_simulation_state(s)->n_contacts == 1);
    const sd_energy before = sd_simulation_energy(s);
    set(s, "law.E_star", 2 * modulus, NULL);
    const sd_energy after = sd_simulation_energy(s);
    SYSTEM_NEAR(after.elastic_normal, 2 * before.elastic_normal, 1e-12 * after.elastic_normal,
                "energy");
    SYSTEM_NEAR(after.residual, before.residual, 1e-14, "residual");
    assert_true(get(s, "law.k_n") == 4.0 / 3 * 2 * modulus && get(s, "law.E_star") == 2 * modulus);
    set(s, "law.poisson", 0.2, NULL);
    SYSTEM_NEAR(get(s, "law.k_t"), 4.0 / 3 * 2 * modulus * ratio, 1e-9, "k_t");
    set(s, "radius", 0.301 * q.ra / 0.3, NULL);
    system_advance(s, 300);
    SYSTEM_NEAR(laws_residual(s), 0, 1e-3, "%s: residual", shapes[q.shape]);
    set(s, "law.k_n", 1e4, "with E_star the stiffness is 4/3 E_star sqrt(R_eff)");
    set(s, "law.k_t", 1e4, "with poisson it is 3 (1 - nu)/(2 - nu) k_n");
    set(s, "law.E_star", 0, "material");
    set(s, "law.poisson", 0.6, "expected at most 0.5");
    set(s, "law.poisson", -1, "expected a number > 0");
    end_run(s, first);
  }
}

static void from_c(void **unused) {
  static const struct {
    sd_contact_law law;
    const char *says; /* NULL: a right law */
  } list[] = {
      {{.E_star = 3, .normal = SD_NORMAL_HERTZ}, NULL},
      {{.E_star = 3, .k_n = 4, .normal = SD_NORMAL_HERTZ}, NULL},
      {{.E_star = 3,
        .poisson = 0.5,
        .mu = 1,
        .normal = SD_NORMAL_HERTZ,
        .tangential = SD_TANGENTIAL_MINDLIN},
       NULL},
      {{.E_star = 3}, "a modulus is for law = \"hertz\""},
      {{.E_star = 3, .k_n = 5, .normal = SD_NORMAL_HERTZ}, "leave out one of the two"},
      {{.E_star = 3, .poisson = 0.3, .normal = SD_NORMAL_HERTZ}, "is for tangential = \"mindlin\""},
      {{.k_n = 3, .poisson = 0.3, .normal = SD_NORMAL_HERTZ, .tangential = SD_TANGENTIAL_MINDLIN},
       "without E_star"},
      {{.E_star = 3,
        .poisson = 0.6,
        .normal = SD_NORMAL_HERTZ,
        .tangential = SD_TANGENTIAL_MINDLIN},
       "at most 0.5"},
      {{.E_star = -3, .normal = SD_NORMAL_HERTZ}, "expected a number > 0"},
      {{.k_n = 3, .E_star = -3, .normal = SD_NORMAL_HERTZ}, "expected a number > 0"},
  };
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    sd_model *m = sd_model_new();
    sd_messages *messages = sd_messages_new();
    sd_model_set(m, "dt", 1e-3);
    const int material = sd_model_add_material(m, "m", &list[k].law);
    sd_model_add_disk(m, &(sd_disk){.material = material, .radius = 1, .mass = 1});
    const sd_status status = sd_model_finish(m, messages);
    if ((status != SD_OK) != (list[k].says != NULL) ||
        (list[k].says && !strstr(sd_messages_text(messages, 0), list[k].says))) {
      sd_messages_print(messages, stderr);
      fail_msg("law %zu: expected %s", k, list[k].says ? list[k].says : "no message");
    }
    if (!list[k].says) assert_true(sd_model_law(m, 0, 0)->k_n == 4);
    sd_messages_free(messages);
    sd_model_free(m);
  }
}

RUN_TESTS(TEST(elastic_impacts), TEST(same_as_by_stiffness), TEST(two_ways), TEST(joints),
          TEST(steering), TEST(from_c))
