/* test_core.c: the core by itself, linked with GSL alone: a model is built, packed, stepped and measured without files,
 * decks, sessions and printing. Built alone by -DSLIPDISK_CORE=ON. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "base/team.h"
#include "measure/error_bar.h"
#include "model/state.h"
#include "pack/sizes.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/step/step.h"
#include "slipdisk/measure.h"

static const double G = 9.81, DT = 1e-4;

static sd_model *model_of(size_t n, double (*place)[2], const double *radius) {
  sd_messages *messages = sd_messages_new();
  sd_model *m = sd_model_new();
  const sd_contact_law law = {.k_n = 1e5, .k_t = 8e4, .gamma_n = 3, .mu = 0.5};
  sd_model_set(m, "dt", DT);
  sd_model_set_text(m, "integrator", "verlet");
  sd_model_set_gravity(m, 0, -G);
  sd_model_add_material(m, "steel", &law);
  for (size_t k = 0; k < n; k++)
    sd_model_add_disk(m, &(sd_disk){.position = {place[k][0], place[k][1], 0},
                                    .radius = radius[k],
                                    .mass = 1,
                                    .group = -1});
  double points[2][2] = {{-50, 0}, {50, 0}};
  sd_model_add_wall(
      m, &(sd_wall){.name = "floor", .kind = SD_WALL_LINE, .n_points = 2, .points = points});
  assert_int_equal(sd_model_finish(m, messages), SD_OK);
  sd_messages_free(messages);
  return m;
}

static engine engine_of(const sd_model *m, sd_messages *messages) {
  engine e = {.model = m, .state = sd_state_new(m)};
  assert_non_null(e.state);
  assert_int_equal(engine_fill_state(m, e.state), SD_OK);
  assert_int_equal(engine_build(&e, 1, messages), SD_OK);
  return e;
}

static void advance(engine *e, int64_t n) {
  step_begin(e, n);
  for (int64_t k = 0; k < n; k++) step_once(e, &(team){.size = 1});
  assert_int_equal(engine_status(e), SD_OK);
}

/* y = y_0 - g t^2/2, to rounding: velocity Verlet is exact in a constant field. */
static void test_falls(void **state) {
  (void)state;
  sd_messages *messages = sd_messages_new();
  sd_model *m = model_of(1, (double[][2]){{0, 20}}, (double[]){1});
  engine e = engine_of(m, messages);
  motion_begin_phase(&e);
  assert_int_equal(engine_start(&e, messages), SD_OK);
  advance(&e, 10000);
  const double t = 10000 * DT;
  assert_true(fabs(e.state->y[0] - (20 - 0.5 * G * t * t)) < 1e-9);
  engine_free(&e);
  sd_state_free(e.state);
  sd_model_free(m);
  sd_messages_free(messages);
}

/* Disks of drawn sizes fall onto the floor and onto each other: the budget of energy closes. */
static void test_budget(void **state) {
  (void)state;
  enum { N = 20 };
  double place[N][2], radius[N];
  const sizes s = {.kind = SD_SIZES_UNIFORM, .lower = 0.4, .upper = 0.6};
  gsl_rng *random = sizes_random(7, 0);
  sizes_draw(&s, random, N, radius);
  gsl_rng_free(random);
  for (int k = 0; k < N; k++) {
    place[k][0] = 1.25 * (k % 5) + 0.3 * (k / 5 % 2);
    place[k][1] = 1.0 + 1.25 * (k / 5) + 0.1 * (k % 3);
  }
  sd_messages *messages = sd_messages_new();
  sd_model *m = model_of(N, place, radius);
  engine e = engine_of(m, messages);
  motion_begin_phase(&e);
  assert_int_equal(engine_start(&e, messages), SD_OK);
  const sd_energy before = energy_of(&e);
  double heights[100];
  for (int k = 0; k < 100; k++) {
    advance(&e, 200);
    heights[k] = e.state->y[0];
  }
  const sd_energy after = energy_of(&e);
  assert_true(after.viscous > 0 && after.friction > 0);
  assert_true(fabs(after.residual) < 1e-4 * (fabs(before.external)));
  const sd_mean mean = sd_mean_of(heights, 100, true);
  assert_true(mean.used > 0 && isfinite(mean.mean));
  engine_free(&e);
  sd_state_free(e.state);
  sd_model_free(m);
  sd_messages_free(messages);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_falls), cmocka_unit_test(test_budget)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
