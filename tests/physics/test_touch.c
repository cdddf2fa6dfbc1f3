/* Impacts at all phases of the time step: the tangential spring, rolling and the budget begin at the moment of touch, so that the
 * outgoing spin is of second order in dt where friction limits it, and elastic contacts lose nothing on average. */
#include "brief.h"
#include "brief.h"
#include "slipdisk/deck.h"
#include "system.h"

enum { PHASES = 16 };
static const double radius = 0.1, stiffness = 1e4, speed = 1;

static const char *const shapes[][2] = {
    {"line", "walls = ( { type = \"line\"; points = ((0, 0), (1, 0)); } );"},
    {"segment", "walls = ( { type = \"segment\"; points = ((-1, 0), (1, 0)); } );"},
    {"arc",
     "walls = ( { type = \"arc\"; center = (0, 1); radius = 1; from = -2.5; to = -0.6; } );"},
    {"container",
     "walls = ( { type = \"circle\"; center = (0, 1); radius = 1; side = \"inside\"; } );"},
    {"end", "walls = ( { type = \"segment\"; points = ((0, -1), (0, 0)); } );"},
    {"held disk", "disks = ( %s, { x = 0; y = -0.2; radius = 0.2; mass = 1; fixed = true; } );"},
    {"free disk", "disks = ( %s, { x = 0; y = -0.2; radius = 0.2; mass = 3; omega = 2; } );"}};
enum { SHAPES = sizeof shapes / sizeof *shapes, WALLS = 5 };

typedef struct law {
  const char *name, *keys;
  double coarse,
      fine; /* most rms error of the outgoing spin, over the speed, at 50 and 200 steps per contact */
} law;
/* Of second order, but where a force appears at once in the step after an event: dashpots at touch, mu_kinetic after sliding has
 * begun. */
static const law laws[] = {
    {"friction", "k_n = 1e4; k_t = 8e3; mu = 0.5;", 6e-4, 4e-5},
    {"dashpots", "k_n = 1e4; k_t = 8e3; mu = 0.3; gamma_n = 10; gamma_t = 5;", 9e-4, 2e-4},
    {"kinetic", "k_n = 1e4; k_t = 8e3; mu = 0.5; mu_kinetic = 0.4;", 8e-3, 2e-3},
    {"rolling", "k_n = 1e4; k_t = 8e3; mu = 0.5; k_r = 4e3; mu_r = 0.1;", 6e-4, 4e-5},
    {"attraction",
     "k_n = 1e4; k_t = 8e3; mu = 0.5; cohesion = \"constant\"; pull_off = 1; range = 0.005;", 6e-4,
     4e-5},
    {"Mindlin", "law = \"hertz\"; k_n = 1e5; k_t = 8e4; tangential = \"mindlin\"; mu = 0.5;",
     1.2e-3, 2e-4},
};
enum { LAWS = sizeof laws / sizeof *laws };

static void start(const char *deck, sd_simulation **s, sd_model **model) {
  sd_messages *m = sd_messages_new();
  *s = NULL;
  if (sd_deck_load_text(deck, "deck", 0, NULL, model, m) != SD_OK ||
      sd_simulation_new(*model, 1, s, m) != SD_OK)
    sd_messages_print(m, stderr);
  sd_messages_free(m);
  assert_non_null(*s);
}

typedef struct outcome {
  double spin;
  sd_energy energy;
} outcome;

/* Touch lies `phase` steps after an evaluation. */
static outcome impact(int shape, const law *l, int integrator, int steps, double phase) {
  char disk[300], bodies[600], deck[2000];
  const double contact = M_PI * sqrt(1 / stiffness), dt = contact / steps,
               gap = 0.01 + phase * speed * dt;
  snprintf(disk, sizeof disk,
           "{ x = %.17g; y = %.17g; vx = 0.7; vy = %.17g; radius = %g; mass = 1; }",
           -0.7 * gap / speed, radius + gap, -speed, radius);
  if (shape < WALLS)
    snprintf(bodies, sizeof bodies, "disks = ( %s ); %s", disk, shapes[shape][1]);
  else
    snprintf(bodies, sizeof bodies, shapes[shape][1], disk);
  snprintf(
      deck, sizeof deck,
      "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; max_overlap = 0.9; %s "
      "materials = ( { name = \"m\"; %s } ); phases = ( { steps = %d; } );",
      dt, integrator ? "verlet" : "gear5", bodies, l->keys, 2 * steps + (int)(0.01 / dt));
  sd_simulation *s;
  sd_model *model;
  start(deck, &s, &model);
  assert_int_equal(sd_simulation_advance(s, 2 * steps + (int)(0.01 / dt), NULL), SD_OK);
  const outcome out = {radius * (double)system_at(s, 0).omega, sd_simulation_energy(s)};
  sd_simulation_free(s);
  sd_model_free(model);
  return out;
}

static double error_of(int shape, const law *l, int integrator, int steps, double right) {
  double sum = 0;
  for (int k = 0; k < PHASES; k++) {
    const double e = impact(shape, l, integrator, steps, (k + 0.5) / PHASES).spin - right;
    sum += e * e;
  }
  return sqrt(sum / PHASES) / speed;
}

static void spin_is_of_second_order(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++)
    for (int shape = 0; shape < SHAPES; shape++)
      for (int k = 0; k < LAWS; k++) {
        const double right = impact(shape, &laws[k], integrator, 5000, 0.5).spin;
        const double coarse = error_of(shape, &laws[k], integrator, 50, right),
                     fine = error_of(shape, &laws[k], integrator, 200, right);
        print_message("%s, %s, %s: %.1e at 50 steps, %.1e at 200\n",
                      integrator ? "verlet" : "gear5", shapes[shape][0], laws[k].name, coarse,
                      fine);
        assert_true(coarse < laws[k].coarse && fine < laws[k].fine);
      }
}

/* A disk to and fro between two walls, 1000 impacts, in a material without losses: before the force of the last step was booked, 0.3
 * to 0.6 of its energy was told as viscous loss. The residual is what the integrator itself gains or loses. */
static void elastic_contacts_lose_nothing(void **unused) {
  static const char *const elastic[] = {"k_n = 1e4;", "law = \"hertz\"; k_n = 1e5;",
                                        "k_n = 1e4; k_t = 8e3; mu = 1e9;",
                                        "k_n = 1e4; k_t = 8e3; mu = 1e9; k_r = 4e3; mu_r = 1e9;"};
  for (int integrator = 0; integrator < 2; integrator++)
    for (size_t k = 0; k < sizeof elastic / sizeof *elastic; k++) {
      char deck[1000];
      snprintf(deck, sizeof deck,
               "dt = %.17g; integrator = \"%s\"; max_overlap = 0.9; disks = ( { x = 0.31; y = 0; "
               "vx = 1; radius = 0.1; mass = 1; } ); walls = ( { type = \"line\"; points = ((0, "
               "0), (0, 1)); }, { type = \"line\"; points = ((1, 0), (1, 1)); } ); materials = ( "
               "{ name = \"m\"; %s } ); time = %d;",
               M_PI / sqrt(stiffness) / 50, integrator ? "verlet" : "gear5", elastic[k],
               BRIEF(830, 40));
      sd_simulation *s;
      sd_model *model;
      start(deck, &s, &model);
      assert_int_equal(sd_simulation_advance(s, INT64_MAX, NULL), SD_OK);
      const sd_energy e = sd_simulation_energy(s);
      print_message("%s, %s: viscous %.1e, friction %.1e, opening %.1e, residual %.1e of %g\n",
                    integrator ? "verlet" : "gear5", elastic[k], e.viscous, e.friction, e.opening,
                    e.residual, e.start);
      assert_true(fabs(e.viscous) < 5e-3 * e.start && fabs(e.friction) + fabs(e.opening) < 1e-12);
      assert_true(fabs(e.residual) < 5e-3 * e.start);
      sd_simulation_free(s);
      sd_model_free(model);
    }
}

RUN_TESTS(TEST(spin_is_of_second_order), TEST(elastic_contacts_lose_nothing))
