/* test_relax.c: the relaxer finds equilibrium, takes out what it says, and leaves alone what it may not touch. */
#include "deck_runs.h"
#include "model/model.h"
#include "pack/relax.h"
#include "physics/system/bodies.h"
#include "physics/step/engine.h"

/* A heap of disks in a box, thrown in every direction; one is locked in x, one turns at a given speed. */
static sd_model *heap_new(const char *integrator, double dt, double gamma_n, const char *phases) {
  text t = {0};
  uint64_t seed = 9;
  text_add(
      &t,
      "dt = %g; integrator = \"%s\"; contact_variant = \"conservative\"; gravity = { g = 1; };\n"
      "materials = ( { name = \"m\"; k_n = 1e3; k_t = 7e2; gamma_n = %g; mu = 0.4; } );\n"
      "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); }, { name = "
      "\"left\"; type = \"line\"; points = ((0, 0), (0, 1)); }, { name = \"right\"; type = "
      "\"line\"; points = ((7, 0), (7, 1)); } );\n"
      "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\", \"omega\"); density "
      "= 1; rows = (",
      dt, integrator, gamma_n);
  for (int k = 0; k < 30; k++) {
    double v[5];
    int row = k / 6;
    for (int c = 0; c < 5; c++) v[c] = next_uniform(&seed) - 0.5;
    text_add(&t, "%s(%.6f, %.6f, %.4f, %.6f, %.6f, %.6f)", k ? ", " : "",
             0.6 + 1.15 * (k % 6) + 0.1 * v[0], 0.6 + 1.15 * row, 0.45 + 0.1 * v[1],
             k == 3 ? 0.0 : v[2], v[3], k == 8 ? 0.0 : 2 * v[4]);
  }
  text_add(&t,
           "); } );\nlocks = ( { disk = 3; coordinates = \"x\"; } );\n"
           "motions = ( { name = \"turn\"; disk = 8; coordinate = \"theta\"; type = \"velocity\"; "
           "velocity = "
           "0.01; } "
           ");\nmeasure = { rotation = (0); };\n%s",
           phases);
  return model_of_text(&t);
}

static double kinetic(const sd_energy *e) { return e->kinetic_translation + e->kinetic_rotation; }

/* Root mean square of the force (or torque over radius) on what is free, over the mean weight. */
static double imbalance(sd_simulation *sim) {
  const engine *e = engine_of(sim);
  const sd_state *s = sd_simulation_state(sim);
  double sum = 0.0, weight = 0.0;
  for (size_t i = 0; i < s->n_free; i++) {
    weight += s->mass[i] / (double)s->n_free;
    for (int k = 0; k < SD_COORDINATES; k++) {
      const columns *c = &e->work.columns[k];
      double arm = k == SD_THETA ? s->radius[i] : 1.0;
      if (c->inverse[i] != 0.0) sum += pow((c->force[i] + c->constant[i]) / arm, 2);
    }
  }
  return sqrt(sum / (double)s->n_free) / weight;
}

/* Without any viscosity, a heap with friction comes to rest in force balance. */
static void test_equilibrium(void **unused) {
  for (int k = 0; k < 2; k++) {
    sd_model *m = heap_new(k ? "gear5" : "verlet", 5e-4, 0.0,
                           "phases = ( { steps = 45000; relax = true; motions = (); } );");
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 45000);
    sd_energy e = sd_simulation_energy(sim);
    print_message("  %s: imbalance %.2g, kinetic %.2g, relaxed %.4g, friction %.4g, residual %.2g, "
                  "%zu contacts\n",
                  k ? "gear5" : "verlet", imbalance(sim), kinetic(&e), e.relaxed, e.friction,
                  e.residual, sd_simulation_state(sim)->n_contacts);
    assert_true(imbalance(sim) < 1e-8);
    assert_true(sd_simulation_state(sim)->n_contacts > 40);
    assert_true(e.relaxed > 0.5 * (e.start - e.external));
    assert_true(fabs(e.residual) < 1e-3 * e.scale);
    end_run(sim, m);
  }
}

/* The residual is the integrator's: velocity Verlet is of second order. */
static void test_energy(void **unused) {
  double residual[2];
  for (int k = 0; k < 2; k++) {
    sd_model *m =
        heap_new("verlet", k ? 2e-4 : 4e-4, 1.0, "phases = ( { time = 3; relax = true; } );");
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, m->phases[0].steps);
    sd_energy e = sd_simulation_energy(sim);
    residual[k] = fabs(e.residual) / e.scale;
    print_message("  dt %g: relaxed %.4g, friction %.4g, viscous %.4g, residual %.2g of %.3g\n",
                  m->dt, e.relaxed, e.friction, e.viscous, e.residual, e.scale);
    end_run(sim, m);
  }
  assert_true(residual[0] < 1e-3 && residual[1] < 0.5 * residual[0]);
}

/* Steered or stopped, it books exactly what the kinetic energy loses. */
static void test_booked(void **unused) {
  sd_model *m = heap_new("gear5", 5e-4, 1.0, "phases = ( { steps = 16000; } );");
  sd_simulation *sim = begin_run(m, 1);
  int stopped = 0, steered = 0, changed = 0;
  relax_sums sums_of_team;
  advance(sim, 4000);
  for (int n = 0; n < 300; n++) {
    advance(sim, 40);
    sd_state *before = copy_of(m, sd_simulation_state(sim));
    sd_energy old = sd_simulation_energy(sim);
    relax_step(engine_of(sim), &(team){.size = 1}, &sums_of_team);
    const sd_state *s = sd_simulation_state(sim);
    sd_energy new = sd_simulation_energy(sim);
    double taken = kinetic(&old) - kinetic(&new);
    double rounding = 1e-15 * (new.relaxed + old.scale);
    between(new.relaxed - old.relaxed - taken, -rounding, rounding, "taken");
    between(new.residual - old.residual, -rounding, rounding, "residual");
    uint32_t locked = sd_simulation_slot(sim, 3), turned = sd_simulation_slot(sim, 8);
    assert_true(s->vx[locked] == before->vx[locked] && s->omega[turned] == before->omega[turned]);
    changed += s->vy[locked] != before->vy[locked];
    assert_true(s->x[0] == before->x[0] && s->theta[0] == before->theta[0]);
    bool stop = s->relax_steps == 0;
    stopped += stop;
    steered += !stop;
    if (stop) {
      assert_true(kinetic(&new) == 0.0);
      assert_true(s->x3[0] == 0.0 && s->theta5[0] == 0.0);
    }
    sd_state_free(before);
  }
  print_message("  stopped %d times, steered %d times\n", stopped, steered);
  assert_true(stopped > 3 && steered > 30 && changed > 30);
  end_run(sim, m);
}

/* Disks that are not in play keep their velocity. */
static void test_out_of_play(void **unused) {
  sd_model *m = heap_new("verlet", 5e-4, 1.0, "phases = ( { steps = 4000; } );");
  sd_simulation *sim = begin_run(m, 1);
  sd_state *s = engine_of(sim)->state;
  advance(sim, 10);
  s->activity[5] = SD_REMOVED;
  s->activity[6] = SD_OUTSIDE;
  bodies_fill_constants(engine_of(sim));
  double kept = s->vx[5], lost = s->vx[6];
  relax_sums sums_of_team;
  relax_step(engine_of(sim), &(team){.size = 1}, &sums_of_team);
  assert_true(s->vx[5] == kept && s->vx[6] != lost);
  end_run(sim, m);
}

/* A disk on two supports, which would otherwise have a step of its own: delta = m g/(2 k sin^2) on two supports. */
static void test_few(void **unused) {
  sd_model *m =
      model_of("dt = 1e-3; gravity = { g = 10; };\n"
               "materials = ( { name = \"m\"; k_n = 1e3; k_t = 0; gamma_n = 0; mu = 0; } );\n"
               "disks = ( { x = 0; y = 0.01; radius = 1; mass = 0.1; }, { x = -1; y = "
               "-1.7320508075688772; radius = 1; mass = 0.1; fixed = true; }, { x = 1; y = "
               "-1.7320508075688772; radius = 1; mass = 0.1; fixed = true; } );\n"
               "phases = ( { steps = 10; }, { steps = 4000; relax = true; } );");
  sd_simulation *sim = begin_run(m, 1);
  advance(sim, 4010);
  const sd_state *s = sd_simulation_state(sim);
  sd_energy e = sd_simulation_energy(sim);
  assert_int_equal(s->n_contacts, 2);
  double height = s->y[0] - s->y[1], r = 2.0 - s->contact_overlap[0];
  between(2.0 * 1e3 * s->contact_overlap[0] * height / r, 1.0 - 1e-9, 1.0 + 1e-9, "weight carried");
  assert_true(kinetic(&e) < 1e-18);
  end_run(sim, m);
}

RUN_TESTS(TEST(test_equilibrium), TEST(test_energy), TEST(test_booked), TEST(test_out_of_play),
          TEST(test_few))
