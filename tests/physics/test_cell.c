/* test_cell.c: periodic boxes that deform: images that move, closed forms of a lattice, the same cell seen otherwise, the energy
 * budget, stresses that are reached, and the same bits whatever happens on the way. */
#include "stresses.h"
#include "model/cell.h"
#include "physics/system/box.h"

static sd_model *pair_model(const char *integrator, const char *variant, bool boxed) {
  text t = {0};
  const double lift = boxed ? 0.0 : 10.0, flow = boxed ? 0.0 : 0.05 * 10.0;
  text_add(
      &t,
      "dt = 5e-4; integrator = \"%s\"; contact_variant = \"%s\";\n"
      "materials = ( { name = \"m\"; k_n = 100; k_t = 70; mu = 0.3; gamma_n = 0.5; } );\n"
      "disks = ( { x = 5.1; y = 9.98; radius = 0.5; mass = 1.3; vx = 0.1; vy = 0.4; omega = 2; },\n"
      "  { x = 5.5; y = %.17g; radius = 0.6; mass = 1; vx = %.17g; vy = -0.5; omega = 1; } );\n"
      "measure = { rotation = (); };\n",
      integrator, variant, 1.02 + lift, -0.6 + flow);
  if (boxed)
    text_add(&t, "box = { x = (0, 10); y = (0, 10); periodic = \"xy\"; };\n"
                 "phases = ( { steps = 3000; cell = { rate_xy = 0.05; boundary = true; }; } );\n");
  else
    text_add(&t, "steps = 3000;\n");
  return model_of_text(&t);
}

/* A disk and the image of another: the same as that disk beside one that is where the image is, and as fast. The first goes
 * through the edge of the box while they touch. */
static void test_pair(void **unused) {
  for (int k = 0; k < 4; k++) {
    const char *integrator = k % 2 ? "gear5" : "verlet",
               *variant = k / 2 ? "paper" : "conservative";
    sd_model *m = pair_model(integrator, variant, true),
             *open = pair_model(integrator, variant, false);
    sd_simulation *sim = begin_run(m, 1), *beside = begin_run(open, 1);
    double most = 0.0;
    int64_t touched = 0, wrapped = 0;
    for (int step = 0; step < 3000; step++) {
      advance(sim, 1);
      advance(beside, 1);
      const sd_state *s = sd_simulation_state(sim), *p = sd_simulation_state(beside);
      const double offset = cell_offset(m, s), speed = 10.0 * s->cell_speed[CELL_OFFSET];
      for (int i = 0; i < 2; i++) {
        const double ny = s->image_y[i] + i, nx = s->image_x[i];
        most = fmax(most, fabs(s->x[i] + 10.0 * nx + offset * ny - p->x[i]));
        most = fmax(most, fabs(s->y[i] + 10.0 * ny - p->y[i]));
        most = fmax(most, fabs(s->vx[i] + speed * ny - p->vx[i]));
        most = fmax(most, fabs(s->omega[i] - p->omega[i]));
      }
      assert_int_equal(s->n_contacts, p->n_contacts);
      touched += s->n_contacts > 0;
      wrapped += s->n_contacts > 0 && s->image_y[0] == 1;
    }
    const sd_energy a = sd_simulation_energy(sim), b = sd_simulation_energy(beside);
    print_message("  %s %s: %lld steps in touch, %lld of them beyond the edge; apart by %.2g\n",
                  integrator, variant, (long long)touched, (long long)wrapped, most);
    assert_true(touched > 300 && wrapped > 100 && touched > wrapped + 20);
    assert_true(most < 2e-11);
    assert_true(b.friction > 1e-4 && b.viscous > 1e-4);
    between(a.friction / b.friction - 1, -1e-9, 1e-9, "friction");
    between(a.viscous / b.viscous - 1, -1e-9, 1e-9, "viscous");
    between(a.residual / a.scale, -2e-5, 2e-5, "residual");
    sd_simulation_free(sim);
    end_run(beside, m);
    sd_model_free(open);
  }
}

enum { WIDE = 6, HIGH = 6 };

static sd_model *lattice(double dt, double overlap, const char *phases) {
  text t = {0};
  const double a = 1.0 - overlap, height = a * sqrt(0.75);
  text_add(&t,
           "dt = %g; max_overlap = 0.9; integrator = \"verlet\"; materials = ( { name = \"m\"; k_n "
           "= 2; } );\n"
           "box = { x = (1, %.17g); y = (-2, %.17g); periodic = \"xy\"; };\n"
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); mass = 1; rows = (",
           dt, 1.0 + a * WIDE, -2.0 + height * HIGH);
  for (int row = 0; row < HIGH; row++)
    for (int k = 0; k < WIDE; k++)
      text_add(&t, "%s(%.17g, %.17g, 0.5)", row || k ? ", " : "",
               1.0 + a * (k + 0.5 * (row % 2) + 0.2), -2.0 + height * (row + 0.3));
  text_add(&t, "); } ); measure = { rotation = (); };\n%s", phases);
  return model_of_text(&t);
}

/* Stress of a triangular lattice of springs whose bonds F takes along: three bonds a disk, for two compression positive. */
static void lattice_stress(double k_n, double overlap, const double f[4], double s[4]) {
  const double a = 1.0 - overlap,
               bond[3][2] = {{a, 0}, {0.5 * a, a * sqrt(0.75)}, {-0.5 * a, a * sqrt(0.75)}};
  const double area = a * a * sqrt(0.75) * (f[0] * f[3] - f[1] * f[2]);
  for (int e = 0; e < 4; e++) s[e] = 0.0;
  for (int b = 0; b < 3; b++) {
    const double l[2] = {f[0] * bond[b][0] + f[1] * bond[b][1],
                         f[2] * bond[b][0] + f[3] * bond[b][1]};
    const double r = hypot(l[0], l[1]), force = fmax(k_n * (1.0 - r), 0.0);
    for (int e = 0; e < 4; e++) s[e] += force / r * l[e / 2] * l[e % 2] / area;
  }
}

static void deformation(const sd_model *m, const sd_state *s, double f[4]) {
  f[0] = s->cell[CELL_X];
  f[1] = cell_offset(m, s) / (m->upper[1] - m->lower[1]);
  f[2] = 0.0;
  f[3] = s->cell[CELL_Y];
}

/* All disks keep their places in the cell; the stress is that of the closed form at any strain. */
static void test_lattice(void **unused) {
  const char *phases[] = {"cell = { rate_xy = 1e-3; };",
                          "cell = { rate_xx = -3e-4; rate_yy = 2e-4; rate_xy = 1e-3; };",
                          "cell = { rate_xx = -2e-4; rate_yy = -2e-4; };"};
  for (int k = 0; k < 3; k++) {
    char phase[200];
    snprintf(phase, sizeof phase, "phases = ( { steps = 1600; %s } );", phases[k]);
    sd_model *m = lattice(0.05, 0.1, phase);
    sd_simulation *sim = begin_run(m, 1);
    for (int part = 1; part <= 4; part++) {
      double f[4], expected[4], contact[4], kinetic[4];
      advance(sim, 400);
      const sd_state *s = sd_simulation_state(sim);
      deformation(m, s, f);
      lattice_stress(2.0, 0.1, f, expected);
      stress_of(sim, contact, kinetic);
      for (int e = 0; e < 4; e++) {
        between(contact[e] - expected[e], -1e-11, 1e-11, "stress");
        between(kinetic[e], -1e-12, 1e-12, "kinetic stress");
      }
      assert_true(fabs(expected[0]) > 0.05);
      for (size_t i = 0; i < s->n_free; i++)
        between(hypot(s->nonaffine_x[i], s->nonaffine_y[i]), 0.0, 2.0 * (k == 0 ? 0.15 : 0.2),
                "drift");
      double low = 1e300, high = -1e300;
      for (size_t i = 0; i < s->n_free; i++) {
        low = fmin(low, fmin(s->nonaffine_x[i] - s->nonaffine_x[0],
                             s->nonaffine_y[i] - s->nonaffine_y[0]));
        high = fmax(high, fmax(s->nonaffine_x[i] - s->nonaffine_x[0],
                               s->nonaffine_y[i] - s->nonaffine_y[0]));
      }
      between(low, -1e-11, 0.0, "non-affine");
      between(high, 0.0, 1e-11, "non-affine");
    }
    const sd_state *s = sd_simulation_state(sim);
    if (k == 1) {
      between(log(s->cell[CELL_X]) / (-3e-4 * 80) - 1, -1e-12, 1e-12, "strain in x");
      between(log(s->cell[CELL_Y]) / (2e-4 * 80) - 1, -1e-12, 1e-12, "strain in y");
    }
    end_run(sim, m);
  }
}

/* lambda = mu = sqrt(3)/4 k of a triangular lattice of springs (L. D. Landau, E. M. Lifshitz; M. F. Thorpe, P. N. Sen, J. Acoust.
 * Soc. Am. 77, 1674): for strains e the stresses change by - lambda e_kk - 2 mu e. */
static void test_moduli(void **unused) {
  const double strain = 1e-6, overlap = 1e-5, k_n = 2.0, mu = 0.25 * sqrt(3.0) * k_n;
  const char *rates[3] = {"rate_xx = %.17g;", "rate_yy = %.17g;", "rate_xy = %.17g;"};
  const double modulus[3][3] = {{3 * mu, mu, 0}, {mu, 3 * mu, 0}, {0, 0, mu}};
  for (int k = 0; k < 3; k++) {
    char rate[60], phase[200];
    double before[4], after[4], kinetic[4];
    snprintf(rate, sizeof rate, rates[k], strain / 40.0);
    snprintf(phase, sizeof phase, "phases = ( { steps = 800; cell = { %s }; } );", rate);
    sd_model *m = lattice(0.05, overlap, phase);
    sd_simulation *sim = begin_run(m, 1);
    stress_of(sim, before, kinetic);
    advance(sim, 800);
    stress_of(sim, after, kinetic);
    const double change[3] = {(before[0] - after[0]) / strain, (before[3] - after[3]) / strain,
                              (before[2] - after[2]) / strain};
    print_message("  %s: %.7f %.7f %.7f\n", rate, change[0], change[1], change[2]);
    for (int c = 0; c < 3; c++) between((change[c] - modulus[k][c]) / mu, -1e-4, 1e-4, "modulus");
    end_run(sim, m);
  }
}

/* Sheared by a whole length, or by two, it is the same cell: stress and offset are those of the start. */
static void test_whole_shear(void **unused) {
  const double a = 0.9, whole = a * WIDE / (a * sqrt(0.75) * HIGH);
  char phase[200];
  snprintf(phase, sizeof phase, "phases = ( { steps = 4000; cell = { rate_xy = %.17g; }; } );",
           whole / 1.2);
  sd_model *m = lattice(6e-4, 0.1, phase);
  sd_simulation *sim = begin_run(m, 1);
  double start[4], now[4], kinetic[4];
  stress_of(sim, start, kinetic);
  for (int k = 1; k <= 2; k++) {
    advance(sim, 2000);
    const sd_state *s = sd_simulation_state(sim);
    stress_of(sim, now, kinetic);
    for (int e = 0; e < 4; e++) between(now[e] - start[e], -1e-10, 1e-10, "stress");
    between(s->cell[CELL_OFFSET], -1e-12, 1e-12, "offset");
    between(s->cell[CELL_SHEAR] / (k * whole) - 1, -1e-13, 1e-13, "shear");
    /* where their way has led them: x by shear times height beside the mean */
    for (size_t i = 0; i < s->n_free; i++) {
      const double y = s->y[i] + s->image_y[i] * (m->upper[1] - m->lower[1]);
      const double x =
          s->x[i] + s->image_x[i] * (m->upper[0] - m->lower[0]) + s->image_y[i] * cell_offset(m, s);
      const sd_disk *d = &m->disks[s->id[i]];
      const double middle = 0.5 * (m->lower[1] + m->upper[1]);
      between(x - d->position[0] - k * whole * (d->position[1] - middle), -1e-10, 1e-10,
              "absolute x");
      between(y - d->position[1], -1e-10, 1e-10, "absolute y");
    }
  }
  assert_true(fabs(start[0]) > 0.1);
  end_run(sim, m);
}

typedef struct request {
  const char *integrator, *variant, *more;
  double dt, shift[2]; /* of all disks, back into the box */
  double skin;
} request;

static const request usual = {
    .integrator = "verlet", .variant = "conservative", .more = "", .dt = 0.04};

enum { SIDE = 12 };
static const double EDGE = 1.15 * SIDE;

static sd_model *packing(const request *r, const char *phases) {
  text t = {0};
  uint64_t seed = 5;
  text_add(&t,
           "dt = %g; integrator = \"%s\"; contact_variant = \"%s\"; skin = %g;\n"
           "box = { x = (0, %.17g); y = (0, %.17g); periodic = \"xy\"; };\n"
           "materials = ( { name = \"m\"; k_n = 1.0; k_t = 0.7; gamma_n = 0.3; mu = 0.4; } );\n"
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 1; rows = (",
           r->dt, r->integrator, r->variant, r->skin, EDGE, EDGE);
  for (int k = 0; k < SIDE * SIDE; k++) {
    double at[2];
    const int place[2] = {k % SIDE, k / SIDE};
    for (int c = 0; c < 2; c++) {
      at[c] = 1.15 * (place[c] + 0.5) + 0.2 * (next_uniform(&seed) - 0.5) + r->shift[c];
      at[c] -= EDGE * floor(at[c] / EDGE);
    }
    text_add(&t, "%s(%.17g, %.17g, %.2f)", k ? ", " : "", at[0], at[1],
             0.4 + 0.2 * next_uniform(&seed));
  }
  text_add(&t, "); } ); measure = { rotation = (); };\n%s%s", r->more, phases);
  return model_of_text(&t);
}

/* Where the box begins has no meaning: all positions shifted, all else is the same but for a common velocity. */
static void test_translation(void **unused) {
  request r = usual;
  const char *phases = "phases = ( { steps = 1000; cell = { rate_xx = -1e-3; rate_yy = -5e-4; "
                       "rate_xy = 0.01; }; } );";
  sd_model *m = packing(&r, phases);
  r.shift[0] = 3.21;
  r.shift[1] = 5.43;
  sd_model *n = packing(&r, phases);
  sd_simulation *sim = begin_run(m, 1), *moved = begin_run(n, 1);
  advance(sim, 1000);
  advance(moved, 1000);
  const sd_state *s = sd_simulation_state(sim), *p = sd_simulation_state(moved);
  double most = 0.0, spin = 0.0, first[2] = {0};
  for (size_t i = 0; i < s->n_free; i++) {
    double dx = p->x[i] - s->x[i] - first[0], dy = p->y[i] - s->y[i] - first[1];
    box_nearest(&engine_of(sim)->work, &dx, &dy);
    if (i == 0) {
      first[0] = dx;
      first[1] = dy;
    } else {
      most = fmax(most, hypot(dx, dy));
    }
    spin = fmax(spin, fabs(p->omega[i] - s->omega[i]));
  }
  print_message("  %zu contacts, apart by %.2g, spins by %.2g\n", s->n_contacts, most, spin);
  assert_true(s->n_contacts > 20 && s->n_contacts == p->n_contacts);
  assert_true(most < 1e-9 && spin < 1e-9);
  assert_true(hypot(first[0], first[1]) > 1.0);
  const sd_energy a = sd_simulation_energy(sim), b = sd_simulation_energy(moved);
  between(b.friction / a.friction - 1, -1e-8, 1e-8, "friction");
  sd_simulation_free(sim);
  end_run(moved, m);
  sd_model_free(n);
}

static const char *const lively =
    "phases = ( { time = 100; cell = { rate_xy = 0.01; rate_xx = -1e-3; rate_yy = -1e-3; }; },\n"
    "{ time = 200; cell = { rate_xy = 0.01; stress_xx = 0.02; stress_yy = 0.02; }; },\n"
    "{ time = 60; cell = { stress_xy = -4e-3; stress_yy = 0.02; boundary = true; }; }, { time = "
    "20; } );";

/* The residual is that of the integrator: it falls with the square of dt. */
static void test_energy(void **unused) {
  for (int k = 0; k < 4; k++) {
    double residual[2];
    request r = usual;
    r.integrator = k % 2 ? "gear5" : "verlet";
    r.variant = k / 2 ? "paper" : "conservative";
    r.more = k == 3 ? "fields = ( { type = \"drag\"; gamma = 0.01; } );\n" : "";
    for (int fine = 0; fine < 2; fine++) {
      r.dt = fine ? 0.01 : 0.02;
      sd_model *m = packing(&r, lively);
      sd_simulation *sim = begin_run(m, 1);
      advance(sim, sd_model_steps(m));
      const sd_energy e = sd_simulation_energy(sim);
      residual[fine] = fabs(e.residual) / e.scale;
      print_message("  %s %s dt %g: work %.4g, friction %.4g, residual/scale %.2g\n", r.integrator,
                    r.variant, r.dt, e.work, e.friction, e.residual / e.scale);
      assert_true(e.friction > 0.1 * e.work && e.viscous > 0.1 * e.work);
      end_run(sim, m);
    }
    assert_true(residual[0] < 2e-5);
    assert_true(residual[1] < 0.4 * residual[0]);
  }
}

/* Mean over the second half of the time is what was asked for: contacts and velocities beside the flow. */
static void test_stress_is_reached(void **unused) {
  sd_model *m =
      packing(&usual, "phases = ( { steps = 40000; cell = { rate_xy = 0.003; stress_xx = 0.01; "
                      "stress_yy = 0.01; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  double mean[4] = {0}, contact[4], kinetic[4];
  int samples = 0;
  advance(sim, 10000);
  while (!sd_simulation_finished(sim)) {
    advance(sim, 20);
    stress_of(sim, contact, kinetic);
    for (int e = 0; e < 4; e++) mean[e] += contact[e] + kinetic[e];
    samples++;
  }
  for (int e = 0; e < 4; e++) mean[e] /= samples;
  const sd_state *s = sd_simulation_state(sim);
  print_message("  xx %.5f yy %.5f xy %.5f %.5f; lengths %.4f %.4f\n", mean[0], mean[3], mean[1],
                mean[2], s->cell[0], s->cell[1]);
  between(mean[0] / 0.01, 0.98, 1.02, "stress_xx");
  between(mean[3] / 0.01, 0.98, 1.02, "stress_yy");
  between(-mean[2] / mean[3], 0.15, 0.5, "effective friction");
  assert_true(fabs(s->cell[CELL_X] - 1) > 0.01);
  end_run(sim, m);
}

/* A phase that settles waits for the stress, also where all else has long been fulfilled. */
static void test_settles_at_the_stress(void **unused) {
  sd_model *m = packing(
      &usual,
      "phases = ( { steps = 40000; cell = { stress_xx = 0.01; stress_yy = 0.01; }; settle = { "
      "kinetic = 1e9; every = 100; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  double contact[4], kinetic[4];
  stress_of(sim, contact, kinetic);
  assert_true(fabs(contact[0] / 0.01 - 1) > 0.05);
  advance(sim, 40000);
  stress_of(sim, contact, kinetic);
  const sd_state *s = sd_simulation_state(sim);
  print_message("  %lld steps; xx %.5f yy %.5f\n", (long long)s->step, contact[0] + kinetic[0],
                contact[3] + kinetic[3]);
  assert_true(sd_simulation_finished(sim) && s->step < 40000 && s->phase_reached[0]);
  between((contact[0] + kinetic[0]) / 0.01, 0.9899, 1.0101, "stress_xx");
  between((contact[3] + kinetic[3]) / 0.01, 0.9899, 1.0101, "stress_yy");
  end_run(sim, m);
}

static void refused(const char *deck, const char *expected) {
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  sd_deck_load_text(deck, "test.cfg", 0, NULL, &m, messages);
  bool found = false;
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    found = found || strstr(sd_messages_text(messages, k), expected);
  if (m || !found) {
    print_error("expected \"%s\", got:\n", expected);
    sd_messages_print(messages, stderr);
    fail();
  }
  sd_messages_free(messages);
}

static void test_mistakes(void **unused) {
#define DECK(box, more, cell)                                                                      \
  "dt = 1e-3; materials = ( { name = \"m\"; k_n = 1; } ); disks = ( { x = 1; y = 1; radius = "     \
  "0.5; mass = "                                                                                   \
  "1; } );"                                                                                        \
  "box = { x = (0, 9); y = (0, 9); periodic = \"" box "\"; };" more                                \
  "phases = ( { steps = 9; cell = { " cell " }; } );"
  refused(DECK("x", "", "rate_xy = 1;"), "expected a box that is periodic in x and y");
  refused(DECK("xy", "gravity = { g = 1; };", "rate_xy = 1;"), "expected no gravity");
  refused(DECK("xy", "", "rate_xy = 1; stress_xy = 2;"), "given together with rate_xy");
  refused(DECK("xy", "", "rate_xx = 2;"), "cell.rate_xx = 2: expected at most 1");
  refused(DECK("xy", "", "stress_xx = 0;"), "all stresses are 0");
  refused(DECK("xy", "", "rate_zz = 1;"), "rate_zz");
  refused(DECK("xy",
               "walls = ( { name = \"w\"; type = \"circle\"; center = (5, 5); radius = 1; side = "
               "\"outside\"; } );",
               "rate_xy = 1;"),
          "expected no walls");
  /* 9 exp(-2.5) is 0.74, below 2.4 */
  refused("dt = 1e-3; materials = ( { name = \"m\"; k_n = 1; } );\n"
          "disks = ( { x = 1; y = 1; radius = 0.5; mass = 1; } );\n"
          "box = { x = (0, 9); y = (0, 9); periodic = \"xy\"; };\n"
          "phases = ( { time = 1; cell = { rate_xx = -0.1; }; },\n"
          "  { time = 5; cell = { rate_yy = -0.5; }; } );",
          "test.cfg:5: phases[1].cell.rate_yy = -0.5: the box is 0.7388 long in y at the end of "
          "this phase; expected more than 2.4");
  refused(DECK("xy", "measure = { disks = true; };", "rate_xy = 1;"), "measure.disks");
}

/* A run that goes on from its state, in the middle of a phase, deforms the box as before. */
static void test_goes_on(void **unused) {
  sd_simulation *sim[2];
  sd_model *m[2];
  for (int k = 0; k < 2; k++) {
    m[k] = lattice(5e-3, 0.02,
                   "phases = ( { steps = 900; cell = { rate_xy = 0.15; rate_xx = -0.05; }; } );");
    sim[k] = begin_run(m[k], 1);
    advance(sim[k], 333);
    if (k) sim[k] = go_on_from_copy(sim[k], 1);
    advance(sim[k], 333);
  }
  same_states(sd_simulation_state(sim[0]), sd_simulation_state(sim[1]), "from a copy");
  for (int k = 0; k < 2; k++) end_run(sim[k], m[k]);
}

RUN_TESTS(TEST(test_pair), TEST(test_lattice), TEST(test_moduli), TEST(test_whole_shear),
          TEST(test_translation), TEST(test_energy), TEST(test_stress_is_reached),
          TEST(test_settles_at_the_stress), TEST(test_mistakes), TEST(test_goes_on))
