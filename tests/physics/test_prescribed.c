/* test_prescribed.c: an element test: bodies that are all prescribed feel what they touch. Forces, budget, history. */
#include "deck_runs.h"
#include "model/model.h"

#define HEAD                                                                                       \
  "dt = 1e-4; steps = 20000; materials = ( { name = \"m\"; k_n = 1e4; k_t = 8e3; gamma_n = 2.0; "  \
  "mu = 0.5; "                                                                                     \
  "} );\n"
#define HELD "name = \"held\"; x = 5.0; y = 0.0; radius = 0.5; mass = 1.0; "
#define LED "name = \"led\"; x = 5.0; y = 1.01; radius = 0.5; mass = 1.0; "
#define FIXED "fixed = true; "
#define LOCKED "locked = (\"x\", \"y\", \"theta\"); "
#define DISKS(a, b) "disks = ( { " a " }, { " b " } ); "
#define PRESS(body, v) "{ " body "; coordinate = \"y\"; type = \"velocity\"; velocity = " v "; }"
#define SLIDE(body)                                                                                \
  "{ " body "; coordinate = \"x\"; type = \"harmonic\"; amplitude = 0.004; omega = 6.0; }"
#define TURN(body) "{ " body "; coordinate = \"theta\"; type = \"velocity\"; velocity = 0.05; }"
#define MOTIONS(what) "motions = ( " what " ); "
#define WALL                                                                                       \
  "walls = ( { name = \"w\"; type = \"line\"; points = ((0.0, -0.51), (1.0, -0.51)); } ); "
#define BOX "box = { x = (4.99, 9.0); y = (-9.0, 9.0); periodic = \"x\"; }; "

typedef struct outcome {
  double normal, tangential; /* sizes of the forces on body 0 */
  sd_energy energy;
} outcome;

static outcome run(const char *deck, const char *integrator) {
  sd_model *m = NULL;
  sd_messages *messages = sd_messages_new();
  sd_deck_load_text(deck, "test.cfg", 1, &integrator, &m, messages);
  if (!m) sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_non_null(m);
  sd_simulation *s = NULL;
  assert_int_equal(sd_simulation_new(m, 1, &s, NULL), SD_OK);
  for (int k = 0; k < 2; k++) {
    assert_int_equal(sd_simulation_advance(s, 10000, NULL), SD_OK);
    assert_int_equal(sd_simulation_rebuild(s, NULL), SD_OK);
  }
  const sd_state *state = sd_simulation_state(s);
  outcome o = {.energy = sd_simulation_energy(s)};
  for (size_t i = 0; i < state->n_bodies; i++)
    if (state->id[i] == 0) {
      o.normal = fabs(state->force_y[i]);
      o.tangential = fabs(state->force_x[i]);
    }
  end_run(s, m);
  return o;
}

/* At t = 2 the overlap is 0.03: whatever is held and whatever is led, by whichever words. */
static void one_force_however_it_is_led(void **unused) {
  static const char *const decks[] = {
      HEAD DISKS(HELD FIXED, LED FIXED) MOTIONS(PRESS("disk = \"led\"", "-0.02")),
      HEAD DISKS(HELD FIXED, LED FIXED) MOTIONS(PRESS("disk = \"held\"", "0.02")),
      HEAD DISKS(HELD LOCKED, LED FIXED) MOTIONS(PRESS("disk = \"led\"", "-0.02")),
      HEAD DISKS(HELD FIXED, LED "locked = (\"x\", \"theta\"); ")
          MOTIONS(PRESS("disk = \"led\"", "-0.02")),
      HEAD DISKS(HELD FIXED, LED FIXED)
          MOTIONS(PRESS("disk = \"held\"", "0.01") ", " PRESS("disk = \"led\"", "-0.01")),
      HEAD DISKS(HELD FIXED, LED FIXED) MOTIONS(
          "{ disk = \"led\"; coordinate = \"y\"; type = \"table\"; times = (0.0, 1.0, 2.0); "
          "values = (0.0, -0.02, -0.04); }"),
      HEAD BOX DISKS(HELD FIXED, LED FIXED) MOTIONS(PRESS("disk = \"led\"", "-0.02")),
      HEAD WALL DISKS(HELD FIXED, "x = 50.0; y = 50.0; radius = 0.5; mass = 1.0; fixed = true;")
          MOTIONS(PRESS("wall = \"w\"", "0.02")),
      HEAD WALL DISKS(HELD FIXED, "x = 50.0; y = 50.0; radius = 0.5; mass = 1.0; fixed = true;")
          MOTIONS(PRESS("disk = \"held\"", "-0.02")),
  };
  static const char *const integrators[] = {"integrator=verlet", "integrator=gear5"};
  for (size_t k = 0; k < sizeof decks / sizeof *decks; k++)
    for (int i = 0; i < 2; i++) {
      const outcome o = run(decks[k], integrators[i]);
      print_message("%zu %s: %.9g, work %.9g, residual %.1e\n", k, integrators[i], o.normal,
                    o.energy.work, o.energy.residual);
      between(o.normal, 300.04 - 1e-6, 300.04 + 1e-6, "normal force"); /* k_n 0.03 + gamma_n 0.02 */
      between(o.energy.elastic_normal, 4.5 - 1e-6, 4.5 + 1e-6, "energy");
      between(o.energy.work, 4.5012 - 1e-5, 4.5012 + 1e-5, "work of the bodies that are led");
      between(o.energy.viscous, 0.0012 - 1e-5, 0.0012 + 1e-5, "viscous loss");
      between(fabs(o.energy.residual), 0, 1e-6, "residual");
    }
}

/* Sideways and by turning: friction is at most mu F_n, and what is held or led first makes no difference. */
static void friction_has_its_history(void **unused) {
#define ALL(body) MOTIONS(PRESS(body, "-0.02") ", " SLIDE(body) ", " TURN(body))
  static const char *const decks[] = {
      HEAD DISKS(HELD FIXED, LED FIXED) ALL("disk = \"led\""),
      HEAD DISKS(HELD LOCKED, LED FIXED) ALL("disk = \"led\""),
      HEAD DISKS(HELD "inertia = 1e15; locked = (\"x\", \"y\"); ", LED FIXED) ALL("disk = \"led\""),
  };
  outcome o[3];
  for (size_t k = 0; k < 3; k++) {
    o[k] = run(decks[k], "integrator=verlet");
    between(o[k].energy.friction, 0.1, 10, "friction");
    between(fabs(o[k].energy.residual), 0, 1e-5, "residual");
    between(o[k].tangential, o[0].tangential * (1 - 1e-9), o[0].tangential * (1 + 1e-9),
            "tangential force");
    between(o[k].normal, o[0].normal * (1 - 1e-9), o[0].normal * (1 + 1e-9), "normal force");
  }
}

/* Beside a free disk, and where nothing moves, they are held as ever. */
static void supports_stay_supports(void **unused) {
  static const struct {
    const char *deck;
    size_t n_free;
  } decks[] = {
      {HEAD DISKS(HELD FIXED, "x = 5.0; y = 0.5; radius = 0.5; mass = 1.0; fixed = true;"), 0},
      {HEAD DISKS(HELD FIXED, LED FIXED)
           MOTIONS("{ disk = \"led\"; coordinate = \"y\"; type = \"fixed\"; }"),
       0},
      {HEAD DISKS(HELD FIXED, LED) MOTIONS(PRESS("disk = \"held\"", "0.02")), 1},
      {HEAD DISKS(HELD FIXED, LED FIXED) MOTIONS(PRESS("disk = \"led\"", "0.02")), 1},
  };
  for (size_t k = 0; k < sizeof decks / sizeof *decks; k++) {
    sd_model *m = model_of(decks[k].deck);
    assert_int_equal(m->n_free, decks[k].n_free);
    sd_model_free(m);
  }
}

RUN_TESTS(TEST(one_force_however_it_is_led), TEST(friction_has_its_history),
          TEST(supports_stay_supports))
