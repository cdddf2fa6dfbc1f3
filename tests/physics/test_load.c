/* test_load.c: walls that the disks move (loads and servos) against closed forms, their energy budget and their
 * bits; and accelerations in units of g. */
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "brief.h"
#include "deck_runs.h"

static const char *const integrators[] = {"gear5", "verlet"};

static sd_model *model_with(const char *integrator, double dt, const char *rest) {
  text t = {0};
  text_add(&t, "integrator = \"%s\"; dt = %.17g;\n%s", integrator, dt, rest);
  return model_of_text(&t);
}

static void end(sd_simulation *sim) {
  sd_model *model = (sd_model *)(uintptr_t)sd_simulation_model(sim);
  end_run(sim, model);
}

typedef struct wall_now {
  double x, y, vx, vy, fx, fy;
} wall_now;

static wall_now wall_of(sd_simulation *sim, const char *name) {
  const sd_model *m = sd_simulation_model(sim);
  const sd_state *s = sd_simulation_state(sim);
  for (uint32_t w = 0; w < m->n_walls; w++) {
    if (!m->walls[w].name || strcmp(m->walls[w].name, name) != 0) continue;
    uint32_t k = sd_simulation_slot(sim, (uint32_t)m->n_disks + w);
    return (wall_now){s->x[k], s->y[k], s->vx[k], s->vy[k], s->force_x[k], s->force_y[k]};
  }
  fail();
  return (wall_now){0};
}

#define FLOOR_AND_LID                                                                              \
  "walls = ( { name = \"floor\"; type = \"line\"; points = ((-1, 0), (1, 0)); },"                  \
  "{ name = \"lid\"; type = \"line\"; points = ((-1, %.17g), (1, %.17g)); } );\n"

/* With constant acceleration velocity Verlet is exact. */
static void a_lid_falls_freely(void **unused) {
  for (int i = 0; i < 2; i++) {
    sd_model *m = model_with(
        integrators[i], 1e-3,
        "gravity = { g = 9.5; tilt = 0.3; }; materials = ( { name = \"m\"; k_n = 1e4; } );\n"
        "disks = ( { x = 0; y = -50; radius = 1; mass = 1; fixed = true; } );\n"
        "walls = ( { name = \"lid\"; type = \"line\"; points = ((-1, 100), (1, 100)); },"
        "{ name = \"side\"; type = \"segment\"; points = ((60, 0), (60, 1)); } );\n"
        "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = 0.7; force = 2; "
        "},\n"
        "{ wall = \"side\"; coordinate = \"x\"; type = \"load\"; mass = 3; } );\nsteps = 3000;\n");
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 2000);
    wall_now lid = wall_of(sim, "lid"), side = wall_of(sim, "side");
    double a = -9.5 * cos(0.3) + 2 / 0.7, b = -9.5 * sin(0.3);
    between(lid.y - (100 + 0.5 * a * 4), -1e-11, 1e-11, "way of the lid");
    between(lid.vy - a * 2, -1e-12, 1e-12, "velocity of the lid");
    between(side.x - (60 + 0.5 * b * 4), -1e-11, 1e-11, "way of the side");
    between(side.vx - b * 2, -1e-12, 1e-12, "velocity of the side");
    between(fabs(lid.x) + fabs(side.y - 0.5), 0, 0, "other coordinates");
    end(sim);
  }
}

/* A disk on a floor under a lid comes to rest with the two overlaps that carry what lies on them. */
static void static_overlaps_carry_the_load(void **unused) {
  const double k = 1e4, g = 9.81, lid_mass = 0.5, mass = 0.1, force = -3, radius = 0.1;
  for (int i = 0; i < 2; i++) {
    text t = {0};
    text_add(
        &t,
        "gravity = { g = %.17g; }; materials = ( { name = \"m\"; k_n = %.17g; k_t = 5e3; mu = 0.3; "
        "gamma_n = "
        "20; } );\ndisks = ( { x = 0; y = 0.1; radius = %.17g; mass = %.17g; } );\n" FLOOR_AND_LID
        "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = %.17g; force = "
        "%.17g; } "
        ");\ntime = 100;\n",
        g, k, radius, mass, 0.2, 0.2, lid_mass, force);
    sd_model *m = model_with(integrators[i], 1e-4, t.s);
    free(t.s);
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 40000);
    wall_now lid = wall_of(sim, "lid"), floor = wall_of(sim, "floor");
    double on_disk = lid_mass * g - force, on_floor = on_disk + mass * g;
    double expected = 2 * radius - on_disk / k - on_floor / k;
    print_message("  %s: lid at %.15g, theory %.15g\n", integrators[i], lid.y, expected);
    between(lid.y - expected, -1e-12, 1e-12, "height of the lid");
    between(lid.fy - on_disk, -1e-8, 1e-8, "force on the lid");
    between(floor.fy + on_floor, -1e-8, 1e-8, "force on the floor");
    between(fabs(lid.vy), 0, 1e-10, "velocity of the lid");
    end(sim);
  }
}

/* A lid of mass M on a disk of mass m on a floor, no viscosity, in its slow mode about the rest position:
 * M y'' = -k (y - d), m d'' = -k d + k (y - d), with y and d the displacements of lid and disk. Largest deviation of the lid
 * from the cosine over some periods, relative to the amplitude. */
static double oscillation_error(const char *integrator, double dt, double mass, double lid_mass) {
  const double k = 1e4, weight = 5, amplitude = 1e-5, radius = 0.1;
  bool locked = mass == 0;
  double a = 2 * k / (locked ? 1 : mass), b = k / lid_mass, c = b * k / (locked ? 1 : mass);
  double w2 = locked ? b : 0.5 * (a + b) - sqrt(0.25 * (a - b) * (a - b) + c), w = sqrt(w2);
  double share = locked ? 0 : 1 - w2 / b; /* of the disk in the lid's displacement */
  double y = 2 * radius - weight / k * (locked ? 1 : 2) + amplitude;
  text t = {0};
  text_add(&t, "materials = ( { name = \"m\"; k_n = %.17g; } );\n", k);
  text_add(&t, "disks = ( { x = 0; y = %.17g; radius = %.17g; mass = %.17g; %s } );\n",
           radius - (locked ? 0 : weight / k) + share * amplitude, radius, locked ? 1 : mass,
           locked ? "locked = (\"x\", \"y\");" : "");
  text_add(
      &t,
      FLOOR_AND_LID
      "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = %.17g; force = "
      "%.17g; } );\ntime = 100;\n",
      y, y, lid_mass, -weight);
  sd_model *m = model_with(integrator, dt, t.s);
  free(t.s);
  sd_simulation *sim = begin_run(m, 1);
  double worst = 0;
  int steps = (int)(5 * 2 * M_PI / w / dt);
  for (int n = 1; n <= steps; n++) {
    advance(sim, 1);
    double off = wall_of(sim, "lid").y - (y - amplitude) - amplitude * cos(w * n * dt);
    worst = fmax(worst, fabs(off) / amplitude);
  }
  end(sim);
  return worst;
}

static void a_lid_oscillates_as_theory_says(void **unused) {
  for (int i = 0; i < 2; i++)
    for (int free_disk = 0; free_disk < 2; free_disk++) {
      double mass = free_disk ? 0.2 : 0,
             coarse = oscillation_error(integrators[i], 2e-4, mass, 0.5),
             fine = oscillation_error(integrators[i], 1e-4, mass, 0.5);
      print_message("  %s, disk %s: off by %.3g of the amplitude, %.3g with half the time step\n",
                    integrators[i], free_disk ? "free" : "locked", coarse, fine);
      between(fine, 0, 3e-4, "error of the oscillation");
      between(coarse / fine, 3.9, 4.1, "order of the error");
    }
}

/* A lid falls on a bed of disks and bounces; residual of the energy budget over its scale. */
static double bouncing_residual(const char *integrator, double dt, double *scale) {
  text t = {0};
  text_add(&t,
           "gravity = { g = 9.81; }; materials = ( { name = \"m\"; k_n = 1e4; k_t = 5e3; gamma_n = "
           "2; mu = 0.3; } "
           ");\ndisk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(&t, 24, 6, 0.021, 0.0215, 0.042, 0.02, 5);
  text_add(&t, "); } );\n"
               "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); },\n"
               "{ name = \"left\"; type = \"line\"; points = ((0, 0), (0, 1)); }, { name = "
               "\"right\"; type = \"line\"; points = ((0.252, 0), (0.252, 1)); },\n"
               "{ name = \"lid\"; type = \"line\"; points = ((0, 0.24), (1, 0.24)); } );\n"
               "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = 0.05; "
               "force = -0.5; } );\n"
               "time = 0.6;\n");
  sd_model *m = model_with(integrator, dt, t.s);
  free(t.s);
  sd_simulation *sim = begin_run(m, 1);
  double lowest = 1, highest = 0, worst = 0;
  while (!sd_simulation_finished(sim)) {
    advance(sim, (int64_t)(0.001 / dt + 0.5));
    sd_energy now = sd_simulation_energy(sim);
    double y = wall_of(sim, "lid").y;
    lowest = fmin(lowest, y);
    if (lowest < 0.19) highest = fmax(highest, y - lowest);
    worst = fmax(worst, fabs(now.residual));
    *scale = now.scale;
  }
  between(highest, 0.003, 0.2, "rebound of the lid");
  end(sim);
  return worst;
}

static void the_energy_budget_closes(void **unused) {
  for (int i = 0; i < 2; i++) {
    double residual[3] = {0}, scale = 0;
    for (int n = 0; n < BRIEF(3, 1); n++)
      residual[n] = bouncing_residual(integrators[i], 4e-5 / (1 << n), &scale) / scale;
    print_message(
        "  %s: largest residual over the scale %.3g at dt = 4e-5, %.3g at 2e-5, %.3g at 1e-5\n",
        integrators[i], residual[0], residual[1], residual[2]);
    if (BRIEF(0, 1)) continue;
    between(residual[2], 0, 1e-3, "residual");
    between(residual[0] / residual[2], 3, 1e9, "fall of the residual");
  }
}

/* A lid on one disk, and one beside it that pushes along itself: the friction on a floor gives way at mu N. */
static void a_servo_reaches_its_force(void **unused) {
  for (int i = 0; i < 2; i++)
    for (int fast = 0; fast < 2; fast++) {
      text t = {0};
      text_add(&t,
               "gravity = { g = 10; }; materials = ( { name = \"m\"; k_n = 1e4; k_t = 5e3; gamma_n "
               "= 2; mu = 0.3; "
               "} );\ndisks = ( { x = 0; y = 0.0995; radius = 0.1; mass = 0.1; } );\n" FLOOR_AND_LID
               "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"servo\"; force = -4; "
               "speed = %g; } "
               ");\ntime = 100;\n",
               0.25, 0.25, fast ? 2.0 : 0.05);
      sd_model *m = model_with(integrators[i], 1e-4, t.s);
      free(t.s);
      sd_simulation *sim = begin_run(m, 1);
      double speed = fast ? 2.0 : 0.05, fastest = 0;
      for (int n = 0; n < 30000; n++) {
        advance(sim, 1);
        fastest = fmax(fastest, fabs(wall_of(sim, "lid").vy));
      }
      wall_now lid = wall_of(sim, "lid");
      print_message("  %s, speed %g: force %.12g\n", integrators[i], speed, lid.fy);
      between(lid.fy - 4, -1e-9, 1e-9, "force on the lid");
      between(fastest, 0.5 * speed, speed, "speed of the lid");
      between(lid.y - (0.2 - 4 / 1e4 - 5 / 1e4), -1e-12, 1e-12, "height of the lid");
      end(sim);
    }
}

/* A run that begins in equilibrium stays there: the servo knows the forces of step 0. */
static void a_servo_begins_at_its_force(void **unused) {
  text t = {0};
  text_add(&t,
           "materials = ( { name = \"m\"; k_n = 1e4; gamma_n = 1; } );\n"
           "disks = ( { x = 0; y = %.17g; radius = 1; mass = 1; } );\n" FLOOR_AND_LID
           "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"servo\"; force = -4; speed "
           "= 1; } );\n"
           "steps = 1000;\n",
           1 - 4e-4, 2 - 8e-4, 2 - 8e-4);
  sd_model *m = model_with("verlet", 1e-4, t.s);
  free(t.s);
  sd_simulation *sim = begin_run(m, 1);
  for (int k = 0; k < 20; k++) {
    advance(sim, 1 + 3 * k);
    wall_now lid = wall_of(sim, "lid");
    between(lid.vy, -1e-9, 1e-9, "velocity of the lid");
    between(lid.y - (2 - 8e-4), -1e-12, 1e-12, "way of the lid");
  }
  end(sim);
}

/* Four walls around a lattice, or around the same disks with friction, each under its own servo. */
static void add_box(text *t, const char *friction, double speed) {
  text_add(t, "materials = ( { name = \"m\"; k_n = 1e4; gamma_n = 2; %s } );\n", friction);
  text_add(t, "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(t, 100, 10, 0.021, 0.021, 0.042, 0.02, 5);
  text_add(t,
           "); } );\n"
           "container = { type = \"box\"; width = 0.42; height = 0.42; origin = (0.21, 0); open "
           "= false; };\n"
           "motions = ( { wall = (\"left\", \"right\"); coordinate = \"x\"; type = \"servo\"; "
           "pressure = 5; speed = %.17g; }, { wall = (\"floor\", \"lid\"); coordinate = \"y\"; "
           "type = \"servo\"; pressure = 5; speed = %.17g; } );\n",
           speed, speed);
}

static void four_walls_hold_a_pressure(void **unused) {
  static const char *const frictions[] = {"", "k_t = 5e3; mu = 0.5;"};
  for (int f = 0; f < 2; f++) {
    text t = {0};
    add_box(&t, frictions[f], 0.1);
    text_add(&t, "time = 10;\n");
    sd_model *m = model_with("gear5", 2e-5, t.s);
    free(t.s);
    sd_simulation *sim = begin_run(m, 1);
    double worst = 1;
    for (int n = 0; n < 20 && worst > 1e-3; n++) {
      advance(sim, 2500);
      wall_now left = wall_of(sim, "left"), right = wall_of(sim, "right"),
               floor = wall_of(sim, "floor"), lid = wall_of(sim, "lid");
      double width = right.x - left.x, height = lid.y - floor.y;
      double p[4] = {-left.fx / height, right.fx / height, -floor.fy / width, lid.fy / width};
      worst = 0;
      for (int k = 0; k < 4; k++) worst = fmax(worst, fabs(p[k] / 5 - 1));
      print_message("  %.2f s: %.4f wide, %.4f high; pressures %.5f %.5f %.5f %.5f\n",
                    sd_simulation_time(sim), width, height, p[0], p[1], p[2], p[3]);
    }
    between(worst, 0, 0.01, "deviation of a pressure");
    end(sim);
  }
}

/* Few disks and round walls: the step for few disks knows no such walls. */
static void a_round_load_among_few_disks(void **unused) {
  sd_model *m = model_with(
      "gear5", 1e-4,
      "materials = ( { name = \"m\"; k_n = 1e4; } ); disks = ( { x = 0; y = 0; radius = 0.1; mass "
      "= 1; locked = (\"x\", \"y\"); } );\nwalls = ( { name = \"ball\"; type = \"circle\"; center "
      "= (0, 0.5); radius = 0.2; side = \"outside\"; } );\nmotions = ( { wall = \"ball\"; "
      "coordinate = \"y\"; type = "
      "\"load\"; mass = 2; force = -8; } );\ntime = 10;\n");
  sd_simulation *sim = begin_run(m, 1);
  assert_false(simulation_is_small(sim));
  /* it falls by 0.2, sinks in, and is thrown back to where it was */
  double fall = sqrt(2 * 0.2 / 4), w = sqrt(1e4 / 2), v = 4 * fall, rest = 8 / 1e4;
  double touch = 2 * (M_PI - atan2(v / w, rest)) / w, deepest = rest + hypot(v / w, rest),
         lowest = 1;
  int64_t steps = (int64_t)((2 * fall + touch) / 1e-4 + 0.5);
  for (int64_t n = 0; n < steps; n++) {
    advance(sim, 1);
    lowest = fmin(lowest, wall_of(sim, "ball").y);
  }
  between(lowest - (0.3 - deepest), -1e-4 * deepest, 1e-4 * deepest, "deepest point");
  between(wall_of(sim, "ball").y, 0.5 - 1e-5, 0.5 + 1e-5, "height after the bounce");
  end(sim);
}

#define SHAKEN                                                                                     \
  "dt = 1e-5; steps = 10; materials = ( { name = \"m\"; k_n = 1e4; } );\n"                         \
  "disks = ( { name = \"d\"; x = 0; y = 0.2; radius = 0.1; mass = 1; } );\n"                       \
  "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); },\n"                 \
  "{ name = \"lid\"; type = \"line\"; points = ((0, 1), (1, 1)); } );\n"

static void accelerations_are_amplitudes(void **unused) {
  const char *const deck = "gravity = { g = 9.81; tilt = 0.2; };\n" SHAKEN
                           "motions = ( { name = \"h\"; wall = \"floor\"; coordinate = \"y\"; "
                           "type = \"harmonic\"; acceleration = 2; omega = 300; },\n"
                           "{ name = \"p\"; wall = \"floor\"; coordinate = \"y\"; type = "
                           "\"parabolic\"; acceleration = 2; omega = 300; },\n"
                           "{ name = \"r\"; wall = \"floor\"; coordinate = (\"x\", \"y\"); type "
                           "= \"random\"; acceleration = 2; frequency = 50; } );\n";
  sd_model *m = model_of(deck), *again = NULL;
  double w = 2 * M_PI * 50, g = 9.81;
  between(m->motions[0].amplitude / (2 * g / 9e4) - 1, -1e-15, 1e-15, "amplitude, harmonic");
  between(m->motions[1].amplitude / (2 * g * M_PI * M_PI / 8 / 9e4) - 1, -1e-15, 1e-15,
          "amplitude, parabolic");
  between(m->motions[3].amplitude / (2 * g / (w * w)) - 1, -1e-15, 1e-15, "amplitude, random");

  /* the second differences of the signals themselves */
  sd_motion *q[2] = {&m->motions[0], &m->motions[1]};
  for (int k = 0; k < 2; k++) {
    for (size_t j = 0; j < m->n_motions; j++) m->phases[0].active[j] = &m->motions[j] == q[k];
    m->phases[0].steps = 5000;
    sd_simulation *sim = begin_run(m, 1);
    double before = 0, largest = 0, least = 1e9;
    for (int n = 0; n < 4200; n++) {
      advance(sim, 1);
      double now = wall_of(sim, "floor").vy, a = fabs(now - before) / m->dt;
      before = now;
      if (n == 0) continue;
      largest = fmax(largest, a);
      if (a > 0.9 * 2 * g) least = fmin(least, a);
    }
    between(largest / (2 * g), 1 - 1e-5, 1 + 1e-5, "largest acceleration");
    if (k == 1) between(least / (2 * g), 1 - 1e-5, 1 + 1e-5, "least acceleration of the parabola");
    sd_simulation_free(sim);
  }

  assert_non_null(strstr(sd_model_deck(m)->full, "acceleration"));
  assert_null(strstr(sd_model_deck(m)->full, "amplitude"));
  const char *const set[] = {"motions.h.acceleration=3"};
  assert_int_equal(sd_deck_load_text(sd_model_deck(m)->full, "echo", 1, set, &again, NULL), SD_OK);
  between(again->motions[0].amplitude / (3 * g / 9e4) - 1, -1e-15, 1e-15, "amplitude, set again");
  assert_true(again->motions[1].amplitude == m->motions[1].amplitude);
  sd_model_free(again);
  sd_model_free(m);
}

/* One message, which says what. */
static void message_of(const char *deck, const char *moves, size_t errors, const char *what) {
  text t = {0};
  sd_model *m = NULL;
  sd_messages *messages = sd_messages_new();
  text_add(&t, "%s" SHAKEN "%s", deck, moves);
  sd_deck_load_text(t.s, "test.cfg", 0, NULL, &m, messages);
  bool said = sd_messages_count(messages) == 1 && strstr(sd_messages_text(messages, 0), what);
  if (sd_messages_errors(messages) != errors || !said) {
    print_error("%s\nexpected: %s\n", moves, what);
    sd_messages_print(messages, stderr);
    fail();
  }
  sd_messages_free(messages);
  sd_model_free(m);
  free(t.s);
}

#define G10 "gravity = { g = 10; };\n"
#define LID(keys) "motions = ( { name = \"a\"; wall = \"lid\"; coordinate = \"y\"; " keys " } );\n"

static void mistakes_are_refused(void **unused) {
  static const struct {
    const char *deck, *motions, *what;
    size_t errors;
  } cases[] = {
      {"", LID("type = \"harmonic\"; omega = 5; acceleration = 2;"), "no gravity", 1},
      {G10, LID("type = \"harmonic\"; omega = 5; acceleration = 2; amplitude = 1;"),
       "expected one of them", 1},
      {G10, LID("type = \"harmonic\"; omega = 5; acceleration = 0;"), "> 0", 1},
      {G10,
       "motions = ( { disk = \"d\"; coordinate = \"theta\"; type = \"harmonic\"; omega = 5; "
       "acceleration = 1; } );",
       "expected amplitude", 1},
      {G10, LID("type = \"load\"; mass = 0;"), "motions[0].mass = 0", 1},
      {G10, LID("type = \"load\"; mass = -1;"), "> 0", 1},
      {G10, LID("type = \"load\"; mass = 1; ramp = 1;"), "does not belong", 1},
      {G10, "motions = ( { disk = \"d\"; coordinate = \"y\"; type = \"load\"; mass = 1; } );",
       "expected wall", 1},
      {G10,
       "motions = ( { wall = \"lid\"; coordinate = (\"x\", \"y\"); type = \"load\"; mass = 1; } );",
       "expected \"x\" or \"y\"", 1},
      {G10, "motions = ( { wall = \"lid\"; coordinate = \"theta\"; type = \"load\"; mass = 1; } );",
       "expected \"x\" or \"y\"", 1},
      {G10,
       "motions = ( { wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = 1; }, { name = "
       "\"b\"; wall = (0, 1); coordinate = \"y\"; type = \"velocity\"; velocity = 1; } );",
       "motions[1] moves the same coordinate", 1},
      {G10, LID("type = \"load\"; mass = 1; force = 11;"), "nothing will hold it", 0},
      {G10, "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"load\"; mass = 1; } );",
       "nothing will hold it", 0},
      {"", LID("type = \"servo\"; force = 1; speed = 1;"), "nothing will hold it", 0},
      {G10, LID("type = \"load\"; mass = 1e-9;"), "0.199 time steps", 0},
      {"", LID("type = \"servo\"; force = 0; speed = 1;"), "other than 0", 1},
      {"", LID("type = \"servo\"; force = -1; speed = 0;"), "speed = 0", 1},
      {"", LID("type = \"servo\"; pressure = -1; speed = 1; length = 1;"), "> 0", 1},
      {"", LID("type = \"servo\"; pressure = 1; speed = 1;"), "expected the length", 1},
      {"", LID("type = \"servo\"; force = -1; speed = 1; length = 1;"), "with pressure only", 1},
      {"",
       "motions = ( { wall = \"lid\"; coordinate = \"x\"; type = \"servo\"; pressure = 1; speed "
       "= 1; length = 1; } );",
       "does not press along x", 1},
  };
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    message_of(cases[k].deck, cases[k].motions, cases[k].errors, cases[k].what);
}

/* Load and prescribed motion of a wall in different phases; default force and length stay out of the echo's way. */
static void a_deck_reads_back(void **unused) {
  sd_model *m = model_of(
      G10
      "dt = 1e-5; materials = ( { name = \"m\"; k_n = 1e4; } ); container = { type = \"box\"; "
      "width = 2; height = 3; open = false; };\n"
      "disks = ( { x = 0; y = 0.2; radius = 0.1; mass = 1; } );\n"
      "motions = ( { name = \"l\"; wall = \"lid\"; coordinate = \"y\"; type = \"load\"; mass = "
      "2; },\n"
      "{ name = \"s\"; wall = (\"left\", \"right\"); coordinate = \"x\"; type = \"servo\"; "
      "pressure = 3; speed = 1; },\n"
      "{ name = \"v\"; wall = \"lid\"; coordinate = \"y\"; type = \"velocity\"; velocity = -1; } "
      ");\n"
      "phases = ( { steps = 5; motions = \"v\"; }, { steps = 5; motions = (\"l\", \"s\"); } );\n");
  assert_int_equal(m->n_motions, 4);
  between(m->motions[0].force, -20, -20, "weight");
  between(m->motions[1].pressure, 3, 3, "pressure of the left wall");
  between(m->motions[2].pressure, -3, -3, "pressure of the right wall");
  between(m->motions[2].length, 3, 3, "length");
  const uint32_t *beside = m->motions[2].beside;
  assert_string_equal(m->walls[beside[0] - m->n_disks].name, "floor");
  assert_string_equal(m->walls[beside[1] - m->n_disks].name, "lid");
  sd_model *again = model_of(sd_model_deck(m)->full);
  assert_true(again->motions[2].length == 3 && again->motions[0].force == -20);
  assert_memory_equal(again->motions[2].beside, beside, sizeof m->motions[2].beside);
  sd_model_free(again);
  sd_model_free(m);
}

RUN_TESTS(TEST(a_lid_falls_freely), TEST(static_overlaps_carry_the_load),
          TEST(a_lid_oscillates_as_theory_says), TEST(the_energy_budget_closes),
          TEST(a_servo_reaches_its_force), TEST(a_servo_begins_at_its_force),
          TEST(four_walls_hold_a_pressure), TEST(a_round_load_among_few_disks),
          TEST(accelerations_are_amplitudes), TEST(mistakes_are_refused), TEST(a_deck_reads_back))
