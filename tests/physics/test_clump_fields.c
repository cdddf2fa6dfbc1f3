/* Fields on clumps: drag, Coriolis forces, damping, fields of programs. */
#include "brief.h"
#include "clump_systems.h"
#include "deck_runs.h"

static sd_simulation *dimer_in(const char *acting, const char *motion) {
  text deck = {0};
  text_add(&deck,
           "integrator = \"verlet\"; dt = 1e-3; time = 200; materials = ( { name = \"m\"; k_n = 1; "
           "} );\n"
           "disk_rows = ( { columns = (\"x\", \"y\"); radius = 1; mass = 0.7; rows = ((-0.8, 0), "
           "(0.8, 0)); } "
           ");\nclumps = ( { disk = (0, 1); %s } );\nfields = ( %s );\n",
           motion, acting);
  sd_model *m = model_of_text(&deck);
  return begin_run(m, 1);
}

static void free_both(sd_simulation *s) {
  sd_model *m = (sd_model *)(uintptr_t)sd_simulation_model(s);
  end_run(s, m);
}

/* The velocity in drag and in the Coriolis force is the corrected one of the clump: strong drag is stable, Coriolis forces do no
 * work. The central field takes the centrifugal force away. */
static void fields_take_the_corrected_velocity_of_a_clump(void **unused) {
  sd_simulation *s = dimer_in(
      "{ type = \"drag\"; gamma = 3e3; gamma_rotation = 1e3; flow = (0.3, -0.2); swirl = 0.5; }",
      "velocity = (3, -1); omega = 2;");
  advance(s, 50);
  const sd_state *q = sd_simulation_state(s);
  SYSTEM_NEAR(q->clump_vx[0], 0.3 - 0.5 * q->clump_y[0], 1e-3, "velocity of the stream");
  SYSTEM_NEAR(q->clump_vy[0], -0.2 + 0.5 * q->clump_x[0], 1e-3, "velocity of the stream");
  SYSTEM_NEAR(q->clump_omega[0], 0.5, 1e-3, "spin of the stream");
  free_both(s);
  s = dimer_in(
      "{ type = \"rotation\"; omega = 3; }, { type = \"central\"; strength = 9; per = \"mass\"; }",
      "velocity = (0.6, -0.8); omega = 2;");
  advance(s, 100000);
  q = sd_simulation_state(s);
  SYSTEM_NEAR(hypot(q->clump_vx[0], q->clump_vy[0]), 1, 1e-10, "speed under the Coriolis force");
  SYSTEM_NEAR(q->clump_omega[0], 2, 1e-10, "spin under the Coriolis force");
  const sd_energy e = sd_simulation_energy(s);
  SYSTEM_NEAR(e.residual, 0, 1e-9 * e.scale, "energy");
  free_both(s);
}

/* Drag f v on each of two disks, f_r omega about each: the clump slows down with 2 f/M and turns slower with (2 f d^2 + 2 f_r)/I. */
static void drag_acts_on_each_disk(void **unused) {
  const double f = 0.3, f_r = 0.05, d = 0.8, M = 1.4, I = 2 * 0.7 * (0.5 + d * d), t = 2;
  for (int integrator = 0; integrator < 2; integrator++) {
    text deck = {0};
    text_add(
        &deck,
        "integrator = \"%s\"; dt = 1e-3; time = 2; materials = ( { name = \"m\"; k_n = 1; k_t = "
        "1; gamma_n = 0; mu = 0; } );\n"
        "disk_rows = ( { columns = (\"x\", \"y\"); radius = 1; mass = 0.7; rows = ((-0.8, 0), "
        "(0.8, 0)); } );\n"
        "clumps = ( { disk = (0, 1); velocity = (3, -1); omega = 2; } );\n"
        "fields = ( { type = \"drag\"; gamma = %g; gamma_rotation = %g; } );\n",
        integrator ? "verlet" : "gear5", f, f_r);
    sd_model *m = model_of_text(&deck);
    sd_simulation *s = begin_run(m, 1);
    advance(s, 2000);
    const sd_state *q = sd_simulation_state(s);
    const double slowed = exp(-2 * f * t / M), turned = exp(-(2 * f * d * d + 2 * f_r) * t / I);
    SYSTEM_NEAR(q->clump_vx[0], 3 * slowed, 1e-6, "velocity along x");
    SYSTEM_NEAR(q->clump_vy[0], -slowed, 1e-6, "velocity along y");
    SYSTEM_NEAR(q->clump_omega[0], 2 * turned, 1e-6, "angular velocity");
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.drag, 5 * M * (1 - slowed * slowed) + 2 * I * (1 - turned * turned), 1e-5,
                "lost to drag");
    SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "energy");
    end_run(s, m);
  }
}

/* As a disk (test_fields.c): thrown upwards it rises with g (1 + alpha) and falls with g (1 - alpha); a torque turns it with
 * 1 - alpha_rotation. */
static void damping_acts_on_the_whole_clump(void **unused) {
  const double alpha = 0.4, g = 10, v0 = 7, up = v0 / (g * (1 + alpha)), top = 0.5 * v0 * up,
               M = 1.4, I = 2 * 0.7 * (0.5 + 0.8 * 0.8);
  const int steps = 10000;
  for (int integrator = 0; integrator < 2; integrator++) {
    text deck = {0};
    text_add(
        &deck,
        "integrator = \"%s\"; dt = %.17g; time = 10; gravity = { g = %g; }; materials = ( { name "
        "= \"m\"; k_n = 1; k_t = 1; gamma_n = 0; mu = 0; } );\n"
        "disk_rows = ( { columns = (\"x\", \"y\"); radius = 1; mass = 0.7; rows = ((-0.8, 0), "
        "(0.8, 0)); } );\n"
        "clumps = ( { disk = (0, 1); velocity = (0, %g); torque = 3; } );\n"
        "fields = ( { type = \"damping\"; alpha = %g; alpha_rotation = 0.25; } );\n",
        integrator ? "verlet" : "gear5", up / steps, g, v0, alpha);
    sd_model *m = model_of_text(&deck);
    sd_simulation *s = begin_run(m, 1);
    advance(s, steps);
    SYSTEM_NEAR(sd_simulation_state(s)->clump_y[0], top, 1e-4 * top, "top of the flight");
    advance(s, 3 * steps);
    const sd_state *q = sd_simulation_state(s);
    const double fall = 0.5 * g * (1 - alpha) * 9 * up * up;
    SYSTEM_NEAR(q->clump_y[0], top - fall, 1e-4 * fall, "fall");
    SYSTEM_NEAR(q->clump_omega[0], 0.75 * 3 / I * 4 * up, 1e-4, "spin");
    const sd_energy e = sd_simulation_energy(s);
    const double turned = 0.5 * 0.75 * 3 / I * 16 * up * up,
                 lost = alpha * M * g * (top + fall) + 0.25 * 3 * turned;
    SYSTEM_NEAR(e.damping, lost, 1e-4 * lost, "lost to damping");
    SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "energy");
    end_run(s, m);
  }
}

/* A field of the program pushes each disk: a couple of forces turns the clump. */
static void push_apart(const sd_force_columns *c, void *user) {
  for (size_t i = 0; i < c->n_free; i++)
    c->force_y[i] += (c->id[i] ? 1 : -1) * *(const double *)user;
}

static void fields_of_programs_have_levers(void **unused) {
  double force = 0.1;
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1e4});
  add_dimer(m, 0, 0, 0, 0.8, 1, 0.7);
  sd_simulation *s = system_start(m);
  assert_int_equal(sd_simulation_add_force_field(s, push_apart, &force, NULL), SD_OK);
  system_advance(s, 3000);
  const sd_state *q = sd_simulation_state(s);
  const double I = clump_of(s, 0)->inertia, angle = (double)system_at(s, 0).theta;
  /* 1/2 I w^2 = 2 f d sin(angle) */
  SYSTEM_NEAR(0.5 * I * q->clump_omega[0] * q->clump_omega[0], 2 * force * 0.8 * sin(angle), 1e-8,
              "energy of rotation");
  const sd_energy e = sd_simulation_energy(s);
  assert_true(angle > 0.3);
  SYSTEM_NEAR(q->clump_vy[0], 0, 1e-14, "velocity");
  SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "energy");
  system_end(s);
}

RUN_TESTS(TEST(drag_acts_on_each_disk), TEST(fields_take_the_corrected_velocity_of_a_clump),
          TEST(damping_acts_on_the_whole_clump), TEST(fields_of_programs_have_levers))
