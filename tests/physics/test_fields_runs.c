/* test_fields_runs.c: packings with fields: the same bits for any threads, instruction set, restart and rebuilt list; energy budget;
 * groups, phases, disks that come and go; mistakes and warnings. */
#include "brief.h"
#include "deck_runs.h"
#include "physics/system/kernels.h"

#define MATERIAL "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 1; mu = 0.5; } );\n"

/* Every kind: all on, then some, then others; one is on a group. */
static const char every_kind[] =
    "fields = ( { name = \"air\"; type = \"drag\"; gamma = 3; gamma_rotation = 2; per = "
    "\"mass\"; flow = (0.5, 0); shear_rate = 2; swirl = 0.3; centre = (0.1, 0.2); },\n"
    "{ name = \"oil\"; type = \"drag\"; gamma = 0.4; per = \"radius\"; group = \"grains\"; },\n"
    "{ name = \"pull\"; type = \"central\"; strength = 0.1; power = -2; softening = 0.05; centre "
    "= (0.5, 0.5); per = \"mass\"; },\n"
    "{ name = \"push\"; type = \"central\"; strength = -0.02; power = 3; disk = (0, 3, 5); },\n"
    "{ name = \"frame\"; type = \"rotation\"; omega = 3; centre = (0.3, 0); },\n"
    "{ name = \"local\"; type = \"damping\"; alpha = 0.2; } );\n"
    "phases = ( { steps = 150; }, { steps = 1; fields = (); }, { steps = 100; fields = (\"oil\", "
    "\"local\", 4); }, { steps = 100000; } );\n";

static sd_model *packing(int n, int wide, const char *integrator) {
  text t = {0};
  const double width = 0.042 * wide + 0.02;
  text_add(&t,
           "dt = 2e-5; integrator = \"%s\"; gravity = { g = 9.81; };\n" MATERIAL
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (",
           integrator);
  add_lattice(&t, n - n / 3, wide, 0.03, 0.028, 0.0405, 0.0182, 21);
  text_add(
      &t,
      "); }, { columns = (\"x\", \"y\", \"radius\"); density = 3.57; group = \"grains\"; rows = (");
  add_lattice(&t, n / 3, wide, 0.03, 0.028 + 0.042 * ((n - n / 3 + wide - 1) / wide), 0.0405,
              0.0182, 5);
  text_add(
      &t,
      "); } );\nwalls = ( { name = \"box\"; type = \"polyline\"; points = ((0, 4), (0, 0), (%g, "
      "0), "
      "(%g, 4)); } );\n"
      "locks = ( { disk = 2; coordinates = \"y\"; } );\n"
      "motions = ( { wall = \"box\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 1e-3; "
      "frequency = 80; },\n"
      "{ disk = 4; coordinate = \"x\"; type = \"harmonic\"; amplitude = 1e-3; frequency = 50; } "
      ");\n%s",
      width, width, every_kind);
  return model_of_text(&t);
}

/* The residual of a packing with every field: small, and of second order with Verlet. */
static void the_budget_closes(void **unused) {
  static const char *const integrators[] = {"gear5", "verlet"};
  for (int c = 0; c < 2; c++) {
    sd_model *model = packing(61, 9, integrators[c]);
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, 20000);
    const sd_energy e = sd_simulation_energy(sim);
    print_message(
        "  %s: residual %.2g of the scale; work %.3g, drag %.3g, damping %.3g, viscous %.3g\n",
        integrators[c], e.residual / e.scale, e.work, e.drag, e.damping, e.viscous);
    assert_true(e.drag > 1e-3 && e.damping > 1e-4);
    between(fabs(e.residual / e.scale), 0, c ? 3e-6 : 3e-5, "residual");
    end_run(sim, model);
  }
}

static void fields_act_on_groups_in_phases(void **unused) {
  sd_model *model = model_of(
      "dt = 1e-3; integrator = \"verlet\"; " MATERIAL
      "disk_rows = ( { columns = (\"x\", \"y\"); radius = 1; mass = 1; vx = 1; rows = ((0, 0), "
      "(0, 3)); },\n"
      "{ columns = (\"x\", \"y\"); radius = 1; mass = 1; vx = 1; group = \"g\"; rows = ((0, 6), "
      "(0, 9)); } );\n"
      "fields = ( { name = \"d\"; type = \"drag\"; gamma = 2; group = \"g\"; }, { type = "
      "\"drag\"; gamma = 1; disk = 1; } );\n"
      "phases = ( { time = 1; }, { time = 1; fields = 1; }, { time = 1; fields = (); } );");
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, 3000);
  const sd_state *s = sd_simulation_state(sim);
  const double expected[] = {1, exp(-2), exp(-2), exp(-2)};
  for (int i = 0; i < 4; i++) between(s->vx[i], expected[i] - 2e-3, expected[i] + 2e-3, "velocity");
  assert_true(s->vx[0] == 1 && s->power_drag[3] == 0);
  const sd_energy e = sd_simulation_energy(sim);
  between(e.drag, 1.5 * (1 - exp(-4)) - 1e-2, 1.5 * (1 - exp(-4)) + 1e-2, "drag");
  between(fabs(e.residual), 0, 1e-5, "residual, where fields go on and off");
  end_run(sim, model);
}

static void lift(const sd_force_columns *c, void *user) {
  (void)user;
  for (size_t i = 0; i < c->n_free; i++) c->force_y[i] += 0.4 * c->mass[i];
}

static void disks_come_and_go(void **unused) {
  static const char *const integrators[] = {"gear5", "verlet"};
  for (int c = 0; c < 2; c++) {
    sd_model *model = packing(41, 9, integrators[c]);
    sd_simulation *sim = begin_run(model, 1);
    assert_int_equal(sd_simulation_add_force_field(sim, lift, NULL, NULL), SD_OK);
    advance(sim, 500);
    const double before = sd_simulation_energy(sim).residual;
    const uint32_t gone[] = {7, 20};
    assert_int_equal(sd_simulation_remove_disks(sim, 2, gone, NULL), SD_OK);
    const sd_disk more[] = {{.position = {0.1, 1, 0}, .radius = 0.02, .mass = 0.004, .group = -1},
                            {.position = {0.2, 1, 0},
                             .velocity = {1, 0, 0},
                             .radius = 0.02,
                             .mass = 0.004,
                             .group = -1}};
    uint32_t first;
    assert_int_equal(sd_simulation_add_disks(sim, 2, more, &first, NULL), SD_OK);
    const sd_energy e = sd_simulation_energy(sim);
    between(fabs(e.residual - before), 0, 1e-15, "residual when disks come and go");
    const sd_state *s = sd_simulation_state(sim);
    const uint32_t slot = sd_simulation_slot(sim, first + 1);
    assert_true(s->field_x[slot] != 0 && s->power_drag[slot] > 0);
    advance(sim, 2000);
    assert_true(sd_simulation_state(sim)->loss_drag[sd_simulation_slot(sim, first + 1)] > 0);
    between(fabs(sd_simulation_energy(sim).residual / sd_simulation_energy(sim).scale), 0, 1e-3,
            "residual");
    end_run(sim, model);
  }
}

/* Rain sinks in a fluid, and the box is compressed while it drags. */
static void rain_and_compression(void **unused) {
  sd_model *model = model_of(
      "dt = 2e-5; integrator = \"verlet\"; gravity = { g = 9.81; }; " MATERIAL
      "container = { type = \"box\"; width = 0.5; height = 1; };\n"
      "packings = ( { type = \"rain\"; count = 40; rows = 2; radius = 0.02; density = 3.57; } );\n"
      "fields = ( { type = \"drag\"; gamma = 20; per = \"mass\"; }, { name = \"local\"; type = "
      "\"damping\"; alpha = 0.5; } );\n"
      "phases = ( { time = 1.5; }, { time = 0.5; } );");
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, 100000);
  const sd_energy e = sd_simulation_energy(sim);
  print_message("  rain: residual %.2g of the scale; drag %.3g, damping %.3g\n",
                e.residual / e.scale, e.drag, e.damping);
  between(fabs(e.residual / e.scale), 0, 1e-5, "residual of rain");
  assert_true(e.drag > 0 && e.damping > 0);
  end_run(sim, model);
  model = model_of(
      "dt = 2e-5; integrator = \"verlet\"; " MATERIAL
      "container = { type = \"periodic\"; width = 1; height = 1; };\n"
      "packings = ( { type = \"random\"; count = 200; radius = 0.02; density = 3.57; } );\n"
      "fields = ( { type = \"drag\"; gamma = 50; per = \"mass\"; flow = (0.3, 0); } );\n"
      "phases = ( { time = 1; compress = { fraction = 0.84; rate = 1; }; } );");
  sim = begin_run(model, 1);
  advance(sim, 50000);
  const sd_energy c = sd_simulation_energy(sim);
  print_message("  compressed: residual %.2g of the scale; work %.3g, drag %.3g\n",
                c.residual / c.scale, c.work, c.drag);
  between(fabs(c.residual / c.scale), 0, 1e-5, "residual of a compression");
  end_run(sim, model);
}

static void told(const char *fields_text, const char *expected) {
  text t = {0};
  text_add(&t,
           "dt = 1e-3; steps = 10; gravity = { g = 0; }; " MATERIAL
           "disks = ( { name = \"d\"; x = 0; y = 0; radius = 1; mass = 1; } );\nfields = ( %s );",
           fields_text);
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  sd_deck_load_text(t.s, "test.cfg", 0, NULL, &model, messages);
  if (model) sd_model_advise(model, messages);
  bool found = !expected && sd_messages_count(messages) == 0;
  for (size_t k = 0; k < sd_messages_count(messages); k++) {
    if (expected && strstr(sd_messages_text(messages, k), expected)) found = true;
    if (!found) print_error("%s\n", sd_messages_text(messages, k));
  }
  if (!found) print_error("expected: %s\n", expected ? expected : "(nothing)");
  assert_true(found);
  sd_messages_free(messages);
  sd_model_free(model);
  free(t.s);
}

static void mistakes_are_told(void **unused) {
  told("{ type = \"drag\"; gamma = 1; }", NULL);
  told("{ type = \"drag\"; }", "test.cfg:3: fields[0].gamma: missing: type \"drag\" needs it");
  told("{ type = \"drag\"; gamma = -1; }", "expected a number >= 0");
  told("{ type = \"drag\"; gamma = 1; alpha = 0.3; }",
       "fields[0].alpha = 0.3: does not belong to type \"drag\"");
  told("{ type = \"dampings\"; alpha = 0.3; }", "did you mean \"damping\"?");
  told("{ type = \"damping\"; alpha = 1; }",
       "fields[0].alpha = 1: it would hold every disk where it is");
  told("{ type = \"damping\"; alpha = 0.6; }, { type = \"damping\"; alpha = 0.5; }",
       "damping fields take 1.1 of the force");
  told("{ type = \"central\"; strength = 1; power = 9; }", "expected a whole number from -8 to 8");
  told("{ type = \"rotation\"; omega = \"0.5 pi\"; }", NULL);
  told("{ type = \"rotation\"; omega = 100; }", "the frame turns by 0.1 rad in a time step");
  told("{ name = \"a\"; type = \"rotation\"; omega = 1; }, { name = \"a\"; type = \"rotation\"; "
       "omega = 1; }",
       "two fields have this name");
  told("{ type = \"drag\"; gamma = 1; group = \"grains\"; }", "no group of disks is called that");
  told("{ type = \"drag\"; gamma = 1; disk = \"e\"; }", "no disk is called that");
  told("{ type = \"drag\"; gamma = 300; }", "drag stops disk \"d\" within 3.3 time steps");
  told("{ type = \"drag\"; gamma = 2000; }",
       "from which on gear5 blows up (drag and springs of fields of disk \"d\"");
  told("{ type = \"central\"; strength = 1e6; per = \"mass\"; }",
       "from which on gear5 blows up (drag and springs of fields");
}

static void warnings_of_boxes_frames_and_phases(void **unused) {
  struct {
    const char *deck, *expected;
  } decks[] = {
      {"gravity = { g = 1; }; steps = 9; fields = ( { name = \"f\"; type = \"rotation\"; omega = "
       "1; } );",
       "fields.f: gravity turns with the frame"},
      {"box = { x = (-9, 9); periodic = \"x\"; }; steps = 9; fields = ( { type = \"central\"; "
       "strength = 1; } );",
       "fields[0]: the force depends on place along x, where the box repeats"},
      {"box = { x = (-9, 9); periodic = \"x\"; }; steps = 9; fields = ( { type = \"drag\"; gamma "
       "= 1; shear_rate = 1; } );",
       NULL},
      {"box = { y = (-9, 9); periodic = \"y\"; }; steps = 9; fields = ( { type = \"drag\"; gamma "
       "= 1; shear_rate = 1; } );",
       "depends on place along y"},
      {"fields = ( { name = \"f\"; type = \"drag\"; gamma = 1; } ); phases = ( { steps = 9; "
       "fields = (); } );",
       "fields.f: it is on in no phase"},
      {"fields = ( { type = \"drag\"; gamma = 1; } ); phases = ( { steps = 9; settle = { kinetic "
       "= 1; }; } );",
       NULL},
      {"fields = ( { type = \"damping\"; alpha = 0.5; } ); phases = ( { steps = 9; fields = (); "
       "settle = { kinetic = 1; }; }, { steps = 9; } );",
       "nothing takes energy out"},
  };
  for (size_t k = 0; k < sizeof decks / sizeof *decks; k++) {
    text t = {0};
    text_add(&t,
             "dt = 1e-3; materials = ( { name = \"a\"; k_n = 1e4; } ); disks = ( { x = 0; y = 0; "
             "radius = 1; mass = 1; }, { x = 3; y = 0; radius = 1; mass = 1; } );\n"
             "%s",
             decks[k].deck);
    sd_model *model = model_of(t.s);
    sd_messages *messages = sd_messages_new();
    sd_model_advise(model, messages);
    if (sd_messages_count(messages) != (decks[k].expected != NULL))
      for (size_t j = 0; j < sd_messages_count(messages); j++)
        print_error("%s: %s\n", decks[k].deck, sd_messages_text(messages, j));
    assert_int_equal(sd_messages_count(messages), decks[k].expected != NULL);
    if (decks[k].expected && !strstr(sd_messages_text(messages, 0), decks[k].expected))
      fail_msg("%s", sd_messages_text(messages, 0));
    sd_messages_free(messages);
    sd_model_free(model);
    free(t.s);
  }
}

/* What a program adds is told by sd_model_finish; a copy of the model owns its fields. */
static void models_own_their_fields(void **unused) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-3);
  sd_model_add_material(m, "a", &(sd_contact_law){.k_n = 1e4});
  sd_model_add_disk(m, &(sd_disk){.radius = 1, .mass = 1, .velocity = {1, 0, 0}});
  const bool on[] = {true};
  uint32_t *disks = malloc(sizeof *disks);
  disks[0] = 0;
  assert_int_equal(sd_model_add_field(m, &(sd_body_force){.name = "d",
                                                          .kind = SD_FIELD_DRAG,
                                                          .gamma = 1,
                                                          .n_disks = 1,
                                                          .disks = disks}),
                   0);
  free(disks);
  sd_model_add_phase(m, &(sd_phase){.steps = 1000, .fields = (bool *)(uintptr_t)on});
  assert_int_equal(sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_DRAG, .gamma = 5}),
                   1); /* off in that phase */
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  sd_model *copy = sd_model_clone(m);
  sd_model_free(m);
  assert_non_null(copy);
  sd_simulation *sim = begin_run(copy, 1);
  advance(sim, 1000);
  between(sd_simulation_state(sim)->vx[0], exp(-1) - 1e-5, exp(-1) + 1e-5, "velocity");
  sd_simulation_free(sim);
  sd_messages *messages = sd_messages_new();
  sd_model_add_field(copy, &(sd_body_force){.kind = (sd_field_kind)9});
  sd_model_add_field(copy, &(sd_body_force){.kind = SD_FIELD_CENTRAL, .strength = NAN});
  assert_int_equal(sd_model_finish(copy, messages), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "kind 9"));
  sd_messages_free(messages);
  sd_model_free(copy);
}

RUN_TESTS(TEST(the_budget_closes), TEST(fields_act_on_groups_in_phases), TEST(disks_come_and_go),
          TEST(rain_and_compression), TEST(mistakes_are_told),
          TEST(warnings_of_boxes_frames_and_phases), TEST(models_own_their_fields))
