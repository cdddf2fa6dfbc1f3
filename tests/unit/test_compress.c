/* test_compress.c: changes of the lengths of a region: targets, pressure, contacts that keep their stretch, the
 * energy budget, and the same bits whatever happens on the way. */
#include "deck_runs.h"
#include "measure/resultant.h"
#include "model/model.h"
#include "pack/compress.h"
#include "physics/step/access.h"

typedef struct request {
  const char *integrator;
  double dt, mu, gamma_n, spread; /* spread: of random velocities */
  int wide;                       /* wide * wide disks */
  bool walls;                     /* four lines, else periodic in x and y */
  double corner;                  /* lower left */
} request;

static const request usual = {
    .integrator = "verlet", .dt = 0.05, .mu = 0.5, .gamma_n = 0.3, .wide = 12};

/* Bidisperse disks on a disordered lattice, radii near 0.5 and 0.7, spacing 1.6: packing fraction 0.45. */
static void begin_deck(text *t, const request *r) {
  double spacing = 1.6, size = spacing * r->wide, low = r->corner, high = low + size;
  uint64_t seed = 77;
  text_add(t,
           "dt = %g; integrator = \"%s\"; contact_variant = \"conservative\"; box = { x = "
           "(%.17g, %.17g); y = (%.17g, %.17g); periodic = \"%s\"; };\n"
           "materials = ( { name = \"m\"; k_n = 1.0; k_t = 0.7; gamma_n = %g; mu = %g; } );\n"
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\", \"omega\"); "
           "density = 1; rows = (",
           r->dt, r->integrator, low, high, low, high, r->walls ? "none" : "xy", r->gamma_n, r->mu);
  for (int k = 0; k < r->wide * r->wide; k++) {
    double v[5];
    int row = k / r->wide;
    for (int c = 0; c < 5; c++) v[c] = next_uniform(&seed) - 0.5;
    text_add(t, "%s(%.9f, %.9f, %.2f, %.9f, %.9f, %.9f)", k ? ", " : "",
             low + spacing * (k % r->wide + 0.5) + 0.15 * v[0],
             low + spacing * (row + 0.5) + 0.15 * v[1], next_bits(&seed) % 2 ? 0.7 : 0.5,
             r->spread * v[2], r->spread * v[3], r->spread * v[4]);
  }
  text_add(t, "); } );\nmeasure = { rotation = (0, 1); };\n");
  if (!r->walls) return;
  text_add(t,
           "walls = ( { name = \"floor\"; type = \"line\"; points = ((%.17g, %.17g), (%.17g, "
           "%.17g)); },\n"
           "{ name = \"lid\"; type = \"line\"; points = ((%.17g, %.17g), (%.17g, %.17g)); },\n"
           "{ name = \"left\"; type = \"line\"; points = ((%.17g, %.17g), (%.17g, %.17g)); },\n"
           "{ name = \"right\"; type = \"line\"; points = ((%.17g, %.17g), (%.17g, %.17g)); } );\n",
           low, low, high, low, low, high, high, high, low, low, low, high, high, low, high, high);
}

static sd_model *end_deck(text *t, const char *phases) {
  text_add(t, "%s", phases);
  sd_model *m = model_of(t->s);
  free(t->s);
  return m;
}

static sd_model *model_with(const request *r, const char *phases) {
  text t = {0};
  begin_deck(&t, r);
  return end_deck(&t, phases);
}

/* Up and down again; the last change lands on the target. */
static void test_fraction(void **unused) {
  sd_model *m = model_with(
      &usual, "phases = ( { steps = 4000; compress = { fraction = 0.6; rate = 1e-3; }; }, "
              "{ steps = 4000; compress = { fraction = 0.5; rate = 1e-3; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  double start = compress_fraction(engine_of(sim));
  advance(sim, 8);
  double most = 1e-3 * 0.05 * COMPRESS_EVERY, scale = sd_simulation_state(sim)->box_scale;
  between(scale - (1.0 - most), -1e-15, 1e-15, "one change at the full rate");
  advance(sim, 3992);
  between(compress_fraction(engine_of(sim)) - 0.6, -1e-12, 1e-12, "fraction reached");
  advance(sim, 4000);
  const sd_state *s = sd_simulation_state(sim);
  between(compress_fraction(engine_of(sim)) - 0.5, -1e-12, 1e-12, "fraction reached from above");
  between(s->box_scale - sqrt(start / 0.5), -1e-12, 1e-12, "scale");
  end_run(sim, m);
}

/* As rows of the series have it. */
static double recorded_pressure(sd_simulation *sim) {
  const sd_model *m = sd_simulation_model(sim);
  resultants r;
  resultants_new(&r, m);
  const sd_state *s = sd_simulation_state(sim);
  assert_int_equal(resultants_compute(&r, m, s, engine_slots(engine_of(sim)), NULL, NULL), SD_OK);
  const double p = r.pressure;
  assert_true(fabs(r.fraction / compress_fraction(engine_of(sim)) - 1.0) < 1e-13);
  resultants_free(&r);
  return p;
}

/* From below and from above, jammed, until nothing moves. */
static void test_pressure(void **unused) {
  for (int walls = 0; walls < 2; walls++) {
    request r = usual;
    r.walls = walls;
    r.mu = 0.0;
    sd_model *m = model_with(
        &r, "phases = ( { steps = 9000; relax = true; compress = { fraction = 0.88; rate = 1e-3; "
            "}; },\n"
            "{ steps = 60000; relax = true; settle = { unbalanced = 1e-4; every = 100; };"
            "  compress = { pressure = 2e-3; rate = 1e-3; }; },\n"
            "{ steps = 60000; relax = true; settle = { unbalanced = 1e-4; every = 100; };"
            "  compress = { pressure = 4e-3; rate = 1e-3; }; }, { steps = 10; } );");
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 9000);
    assert_true(compress_pressure(engine_of(sim)) > 5e-3);
    const double target[2] = {2e-3, 4e-3};
    for (int k = 0; k < 2; k++) {
      while (sd_simulation_state(sim)->phase == k + 1) advance(sim, 100);
      assert_true(sd_simulation_state(sim)->step < 9000 + 60000 * (k + 1));
      double p = compress_pressure(engine_of(sim));
      between(p / target[k], 1.0 - 1e-3, 1.0 + 1e-3, walls ? "pressure, walls" : "pressure");
      between(recorded_pressure(sim) / p - 1.0, -1e-13, 1e-13, "recorded");
    }
    end_run(sim, m);
  }
}

/* A square lattice of equal disks that overlap by d: p = k d / spacing. */
static void test_pressure_of_a_lattice(void **unused) {
  text t = {0};
  double d = 1e-3, spacing = 1.0 - d;
  int n = 8;
  text_add(&t,
           "dt = 0.01; box = { x = (0, %.17g); y = (0, %.17g); periodic = \"xy\"; };\n"
           "materials = ( { name = \"m\"; k_n = 3.0; } ); disk_rows = ( { columns = (\"x\", "
           "\"y\", \"radius\"); mass = 1; rows = (",
           n * spacing, n * spacing);
  for (int row = 0; row < n; row++)
    for (int k = 0; k < n; k++)
      text_add(&t, "%s(%.17g, %.17g, 0.5)", row || k ? ", " : "", spacing * k, spacing * row);
  text_add(&t, "); } );\n");
  sd_model *m = end_deck(
      &t,
      "phases = ( { steps = 10; }, { steps = 10; compress = { pressure = 1; rate = 1e-3; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  between(compress_pressure(engine_of(sim)) / (3.0 * d / spacing), 1.0 - 1e-11, 1.0 + 1e-11,
          "lattice");
  between(compress_fraction(engine_of(sim)) / (M_PI / 4.0 / (spacing * spacing)), 1.0 - 1e-12,
          1.0 + 1e-12, "fraction");
  end_run(sim, m);
}

/* At rest in a box, the virial is the mean of the pressures on the walls. */
static void test_pressure_on_walls(void **unused) {
  request r = usual;
  r.walls = true;
  r.corner = -3.0;
  r.mu = 0.0; /* the first moment of tangential tractions on a wall would count, too */
  sd_model *m = model_with(
      &r, "phases = ( { steps = 12000; relax = true; compress = { fraction = 0.87; rate = "
          "1e-3; }; }, { steps = 60000; relax = true; settle = { unbalanced = 1e-9; }; }, "
          "{ steps = 10; } );");
  sd_simulation *sim = begin_run(m, 1);
  while (sd_simulation_state(sim)->phase < 2) advance(sim, 1000);
  const sd_state *s = sd_simulation_state(sim);
  double length = s->box_scale * (m->region_upper[0] - m->region_lower[0]), wall[4];
  for (uint32_t k = 0; k < 4; k++) {
    uint32_t slot = sd_simulation_slot(sim, (uint32_t)m->n_disks + k);
    wall[k] = fabs(k < 2 ? s->force_y[slot] : s->force_x[slot]) / length;
  }
  double mean = 0.25 * (wall[0] + wall[1] + wall[2] + wall[3]);
  print_message("  walls %.6g %.6g %.6g %.6g, virial %.9g, mean %.9g\n", wall[0], wall[1], wall[2],
                wall[3], compress_pressure(engine_of(sim)), mean);
  assert_true(mean > 1e-3);
  between(compress_pressure(engine_of(sim)) / mean, 1.0 - 1e-6, 1.0 + 1e-6, "pressure");
  end_run(sim, m);
}

/* Of the two states in which both contacts are closed, and the same. */
static size_t compare_stretches(const sd_state *a, const sd_state *b, double *most,
                                double *largest) {
  size_t n = 0;
  for (size_t c = 0, d = 0; c < a->n_contacts; c++)
    for (d = 0; d < b->n_contacts; d++) {
      if (a->contact_a[c] != b->contact_a[d] || a->contact_b[c] != b->contact_b[d]) continue;
      if (b->contact_slide[d] != 0) continue;
      *most = fmax(*most, fabs(a->contact_zeta[c] - b->contact_zeta[d]));
      *largest = fmax(*largest, fabs(a->contact_zeta[c]));
      n++;
    }
  return n;
}

/* A change puts in what it books; no stretch changes, with disks nor with walls; all lies in the new box. */
static void test_one_change(void **unused) {
  for (int walls = 0; walls < 2; walls++) {
    request r = usual;
    r.walls = walls;
    r.spread = 0.5;
    r.corner = 1.5;
    sd_model *m = model_with(
        &r, "gravity = { g = 1e-3; tilt = 0.2; };\n"
            "phases = ( { steps = 6007; compress = { fraction = 0.88; rate = 1e-3; }; } );");
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 6005);
    sd_state *before = copy_of(m, sd_simulation_state(sim));
    sd_energy old = sd_simulation_energy(sim);
    assert_int_equal(compress_step(engine_of(sim), NULL), SD_OK);
    const sd_state *after = sd_simulation_state(sim);
    sd_energy new = sd_simulation_energy(sim);
    double f = after->box_scale / before->box_scale;
    assert_true(f < 1.0);
    double most = 0.0, largest = 0.0;
    size_t n = compare_stretches(before, after, &most, &largest);
    print_message(
        "  %zu contacts, stretches of up to %.3g changed by %.2g; work %.3g, residual by %.2g\n", n,
        largest, most, new.work - old.work, new.residual - old.residual);
    assert_true(n > 150 && largest > 1e-4);
    assert_true(most < 1e-13);
    assert_true(new.work - old.work != 0.0);
    assert_true(fabs(new.residual - old.residual) < 1e-14 * (old.scale + fabs(old.external)));
    assert_true(new.viscous == old.viscous &&new.kinetic_translation == old.kinetic_translation);
    for (size_t i = 0; i < after->n_bodies; i++) {
      between(after->x[i] - (1.5 + f * (before->x[i] - 1.5)), -1e-13, 1e-13, "x");
      between(after->base_y[i] - (1.5 + f * (before->base_y[i] - 1.5)), -1e-13, 1e-13, "base y");
      assert_true(after->theta[i] == before->theta[i] && after->vx[i] == before->vx[i]);
    }
    const work *w = &engine_of(sim)->work;
    if (!walls)
      between(w->length[0] / (f * before->box_scale * 1.6 * 12), 1 - 1e-14, 1 + 1e-14, "length");
    sd_state_free(before);
    end_run(sim, m);
  }
}

/* The residual is the integrator's: it falls with the square of dt. */
static void test_energy(void **unused) {
  double residual[2];
  for (int k = 0; k < 2; k++) {
    request r = usual;
    r.dt = k ? 0.02 : 0.04;
    char phases[200];
    snprintf(phases, sizeof phases,
             "phases = ( { time = 480; compress = { fraction = 0.88; rate = 8e-4; }; } );");
    sd_model *m = model_with(&r, phases);
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, m->phases[0].steps);
    sd_energy e = sd_simulation_energy(sim);
    residual[k] = fabs(e.residual) / e.work;
    print_message("  dt %g: work %.4g, elastic %.4g, viscous %.4g, friction %.4g, opening %.2g, "
                  "residual/work %.2g\n",
                  r.dt, e.work, e.elastic_normal + e.elastic_tangential, e.viscous, e.friction,
                  e.opening, e.residual / e.work);
    assert_true(e.work > 0.0 && e.friction > 0.01 * e.work && e.elastic_normal > 0.1 * e.work);
    end_run(sim, m);
  }
  assert_true(residual[0] < 2e-5);
  assert_true(residual[1] < 0.4 * residual[0]);
}

static void refused(const char *more, const char *phases, const char *expected) {
  text t = {0};
  begin_deck(&t, &usual);
  text_add(&t, "%s%s", more, phases);
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  assert_int_equal(sd_deck_load_text(t.s, "test.cfg", 0, NULL, &m, messages), SD_ERROR_USER);
  bool found = false;
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    found = found || strstr(sd_messages_text(messages, k), expected);
  if (!found) sd_messages_print(messages, stderr);
  assert_true(found);
  sd_messages_free(messages);
  free(t.s);
}

static void test_refused(void **unused) {
  const char *phase = "phases = ( { steps = 10; compress = { fraction = 0.6; rate = 1e-3; }; } );";
  refused("walls = ( { name = \"shelf\"; type = \"segment\"; points = ((1, 1), (2, 1)); } );\n",
          phase, "wall \"shelf\" has a size of its own");
  refused("motions = ( { name = \"pull\"; disk = 3; coordinate = \"x\"; type = \"velocity\"; "
          "velocity = 1; } );\n",
          phase, "motions[0]: it prescribes positions that phases[0].compress changes");
  refused("", "phases = ( { steps = 10; compress = { fraction = 0.6; rate = 1; }; } );",
          "expected a number > 0 and at most 0.02");
  refused("", "phases = ( { steps = 10; compress = { rate = 1e-3; }; } );",
          "either pressure or fraction");
}

/* The least width of a periodic box is looked at on the way, too. */
static void test_too_narrow(void **unused) {
  request r = usual;
  r.wide = 3; /* 4.8 long, where 3.36 is the least */
  sd_model *m = model_with(
      &r, "max_overlap = 1; phases = ( { steps = 4000; relax = true; compress = { pressure = "
          "50; rate = 1e-2; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_simulation_advance(sim, 4000, messages), SD_ERROR_NUMERIC);
  assert_non_null(strstr(sd_messages_text(messages, 0), "compressed box"));
  sd_messages_free(messages);
  end_run(sim, m);
}

/* With attraction it is longer: 4.4 here; a fraction of 0.1 is reached at 3.96. */
static void test_too_narrow_to_attract(void **unused) {
  sd_model *m = model_of(
      "dt = 0.05; integrator = \"verlet\"; box = { x = (0, 9); y = (0, 9); periodic = \"xy\"; };\n"
      "materials = ( { name = \"m\"; k_n = 1; cohesion = \"constant\"; pull_off = 1e-9; range = 1; "
      "} );\n"
      "disk_rows = ( { columns = (\"x\", \"y\"); radius = 0.5; density = 1; rows = ((2, 2), (6, "
      "6)); } );\n"
      "phases = ( { steps = 4000; compress = { fraction = 0.1; rate = 1e-2; }; } );");
  sd_simulation *sim = begin_run(m, 1);
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_simulation_advance(sim, 4000, messages), SD_ERROR_NUMERIC);
  assert_non_null(strstr(sd_messages_text(messages, 0),
                         "twice the gap over which disks attract each other (1)"));
  sd_messages_free(messages);
  end_run(sim, m);
}

RUN_TESTS(TEST(test_fraction), TEST(test_pressure), TEST(test_pressure_of_a_lattice),
          TEST(test_pressure_on_walls), TEST(test_one_change), TEST(test_energy),
          TEST(test_refused), TEST(test_too_narrow), TEST(test_too_narrow_to_attract))
