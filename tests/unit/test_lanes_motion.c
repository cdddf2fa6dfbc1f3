/* test_lanes_motion.c: poses of several systems side by side: the bits that each system computes by itself, for every
 * kind of motion, on every instruction set, over batches, and after going back to the states and on from there. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "deck_runs.h"
#include "physics/system/kernels.h"
#include "physics/motion/motion.h"

enum { MOST = 8, FIRST = 1, BODIES = 3 /* a free disk in slot 0, two driven ones and a wall */ };

/* A motion's text; @A, @W, @P, @R, @S and @V are an amplitude, frequency, phase, ramp, rise and velocity of this lane. */
static void add_motion(text *t, const char *motion, double x) {
  for (const char *c = motion; *c; c++) {
    if (*c != '@') {
      text_add(t, "%c", *c);
      continue;
    }
    c++;
    text_add(t, "%.17g",
             *c == 'A'   ? 0.01 * x
             : *c == 'W' ? 300 + 17.3 * x
             : *c == 'P' ? 0.4 * x
             : *c == 'S' ? 0.1 + 0.1 * x
             : *c == 'R' ? (x == 3 ? 0 : 0.002 + 0.0007 * x)
                         : 0.1 + 0.13 * x);
  }
}

/* Systems with the same bodies and motions; every number differs. The motions begin after `rest` steps. */
static sd_model *system_of(const char *const *moves, size_t n_moves, int l, int rest) {
  text t = {0};
  double x = l + 1;
  text_add(&t, "dt = %.17g; seed = %lld; materials = ( { name = \"m\"; k_n = 1e3; } );\n",
           1e-4 / (1 + 0.3 * x), 1 + (long long)l * 5000000007);
  text_add(
      &t,
      "disks = ( { name = \"free\"; x = 0; y = 0; radius = 1; mass = 1; },\n"
      "{ name = \"a\"; x = %.17g; y = -3; theta = %.17g; radius = 1; mass = 1; fixed = true; },\n"
      "{ name = \"b\"; x = 5; y = %.17g; theta = %.17g; radius = 1; mass = 1; fixed = true; } );\n",
      -5 + 0.1 * x, 0.2 * x, -3 - 0.3 * x, 8.0 * l + 0.01);
  text_add(&t,
           "walls = ( { name = \"w\"; type = \"circle\"; center = (%.17g, 0); radius = 900; side = "
           "\"inside\"; } );\n",
           0.7 * x);
  text_add(&t, "motions = (");
  for (size_t k = 0; k < n_moves; k++) {
    text_add(&t, "%s{ ", k ? ", " : "");
    add_motion(&t, moves[k], x);
    text_add(&t, " }");
  }
  text_add(&t,
           ");\nphases = ( { name = \"rest\"; steps = %d; motions = []; }, { name = \"go\"; steps "
           "= 1000000; "
           "} );\n",
           rest);
  sd_model *model = model_of(t.s);
  free(t.s);
  return model;
}

typedef struct herd {
  size_t width;
  sd_model *model[MOST];
  sd_simulation *alone[MOST], *beside[MOST];
  engine *one[MOST], *lane[MOST];
  pose_batch *m;
  int64_t steps; /* that the motions have run */
} herd;

static herd herd_new(const char *const *moves, size_t n_moves, size_t n, int rest) {
  herd h = {0};
  engine *systems[MOST] = {NULL};
  for (size_t l = 0; l < n; l++) {
    int waits = rest + 3 * (int)l;
    h.model[l] = system_of(moves, n_moves, (int)l, waits);
    h.alone[l] = begin_run(h.model[l], 1);
    h.beside[l] = begin_run(h.model[l], 1);
    advance(h.alone[l], waits);
    advance(h.beside[l], waits);
    h.one[l] = engine_of(h.alone[l]);
    h.lane[l] = systems[l] = engine_of(h.beside[l]);
    assert_int_equal(h.one[l]->state->phase, 1);
  }
  h.width = kernels_choose()->lane_width;
  assert_true(n <= h.width);
  h.m = pose_batch_new(h.width, n, systems);
  pose_batch_load(h.m);
  return h;
}

static void herd_free(herd *h) {
  pose_batch_free(h->m);
  for (size_t l = 0; l < MOST && h->model[l]; l++) {
    sd_simulation_free(h->alone[l]);
    sd_simulation_free(h->beside[l]);
    sd_model_free(h->model[l]);
  }
}

static double pose_of(const herd *h, uint32_t slot, int which, size_t l) {
  int64_t k = h->lane[0]->state->step + 1 - pose_batch_first(h->m);
  size_t stretch = (slot - h->lane[0]->state->n_free) * POSES + (size_t)which;
  return pose_batch_poses(h->m)[(stretch * POSE_STEPS + (size_t)k) * h->width + l];
}

static void same_pose(const herd *h, uint32_t slot, int which, size_t l, double expected) {
  double now = pose_of(h, slot, which, l);
  uint64_t bits, expected_bits;
  memcpy(&bits, &now, sizeof bits);
  memcpy(&expected_bits, &expected, sizeof bits);
  if (bits == expected_bits) return;
  print_error("slot %u, pose %d, lane %zu, after %lld steps: %.17g, alone %.17g\n", slot, which, l,
              (long long)h->steps, now, expected);
  fail();
}

/* The next step of all systems, as each computes it by itself. */
static void compare_step(herd *h) {
  assert_true(pose_batch_ahead(h->m) > 0);
  for (size_t l = 0; l < MOST && h->model[l]; l++) {
    engine *e = h->one[l];
    sd_state *s = e->state;
    size_t n;
    motion_ahead(e);
    for (prescribed *p = motion_prescribed(e, &n), *end = p + n; p < end; p++) {
      double value = p->value[motion_index(e)], velocity = p->velocity[motion_index(e)];
      *p->at = value;
      *p->speed = velocity;
    }
    for (uint32_t i = FIRST; i < FIRST + BODIES; i++) {
      const double poses[POSES] = {s->x[i], s->y[i], s->theta[i], s->vx[i], s->vy[i], s->omega[i]};
      for (int c = 0; c < POSES; c++) same_pose(h, i, c, l, poses[c]);
    }
  }
  for (size_t l = 0; l < MOST && h->model[l]; l++) {
    h->one[l]->state->step++;
    h->lane[l]->state->step++;
  }
  h->steps++;
}

/* Oscillators as the states hold them; poses go along, as those who run the lanes bring them. */
static void compare_states(herd *h) {
  pose_batch_store(h->m);
  for (size_t l = 0; l < MOST && h->model[l]; l++) {
    sd_state *s = h->one[l]->state, *t = h->lane[l]->state;
    motion_store(h->one[l]);
    const size_t bytes = s->n_motions * sizeof(double);
    assert_memory_equal(s->motion_u0, t->motion_u0, bytes);
    assert_memory_equal(s->motion_v0, t->motion_v0, bytes);
    assert_memory_equal(s->motion_u1, t->motion_u1, bytes);
    assert_memory_equal(s->motion_v1, t->motion_v1, bytes);
    for (size_t c = 0; c < 3; c++) {
      double *from[] = {s->x, s->y, s->theta, s->vx, s->vy, s->omega};
      double *to[] = {t->x, t->y, t->theta, t->vx, t->vy, t->omega};
      memcpy(to[c], from[c], s->n_bodies * sizeof(double));
      memcpy(to[c + 3], from[c + 3], s->n_bodies * sizeof(double));
    }
  }
}

/* A single one goes on by itself from what the lanes have stored. */
static void go_on_alone(herd *h, int steps) {
  for (int k = 0; k < steps; k++)
    for (size_t l = 0; l < MOST && h->model[l]; l++) {
      engine *both[] = {h->one[l], h->lane[l]};
      double value[2][3 * BODIES + 3];
      size_t n = 0;
      for (int side = 0; side < 2; side++) {
        motion_ahead(both[side]);
        const prescribed *p = motion_prescribed(both[side], &n);
        for (size_t i = 0; i < n; i++) {
          value[side][i] = p[i].value[motion_index(both[side])];
          *p[i].at = value[side][i];
          *p[i].speed = p[i].velocity[motion_index(both[side])];
        }
        both[side]->state->step++;
      }
      assert_memory_equal(value[0], value[1], n * sizeof(double));
    }
  h->steps += steps;
  for (size_t l = 0; l < MOST && h->model[l]; l++) motion_store(h->lane[l]);
  pose_batch_load(h->m);
}

static void run_decks(const char *const *moves, size_t n_moves) {
  const char *const paths[] = {"baseline", "avx2", "avx512"};
  for (size_t p = 0; p < 3; p++) {
    if (!kernels_named(paths[p])) continue;
    setenv("SLIPDISK_PATH", paths[p], 1);
    size_t width = kernels_named(paths[p])->lane_width;
    for (int c = 0; c < 6; c++) {
      herd h = herd_new(moves, n_moves, c < 3 ? width : width - 1,
                        10 + c); /* both parities of the start */
      const int pieces[] = {1, 2, 40, 64, 33, 150, 7};
      for (size_t k = 0; k < 7; k++) {
        for (int n = 0; n < pieces[(k + (size_t)c) % 7]; n++) compare_step(&h);
        compare_states(&h);
        if (k % 3 == 0)
          go_on_alone(&h, 1 + 70 * (int)(k / 3));
        else if (k % 3 == 1)
          pose_batch_load(h.m);
        else
          pose_batch_load(h.m), compare_states(&h), pose_batch_load(h.m);
      }
      herd_free(&h);
    }
  }
  unsetenv("SLIPDISK_PATH");
}

#define RUN(...)                                                                                   \
  do {                                                                                             \
    const char *const moves[] = {__VA_ARGS__};                                                     \
    run_decks(moves, sizeof moves / sizeof *moves);                                                \
  } while (0)

#define RANDOM(m)                                                                                  \
  "disk = [\"a\", \"b\"]; coordinate = (\"x\", \"y\", \"theta\"); type = \"random\"; interval "    \
  "= " #m "; "                                                                                     \
  "amplitude = @A; omega = @W; damping = @V;"

static void random_motions(void **unused) {
  (void)unused;
  RUN(RANDOM(1));
  RUN(RANDOM(2));
  RUN(RANDOM(7));
  RUN(RANDOM(10));
  RUN(RANDOM(100));
  RUN(RANDOM(1) " ramp = @R;");
  RUN(RANDOM(3) " ramp = @R;");
}

static void waves(void **unused) {
  (void)unused;
#define WAVE(coordinate, type)                                                                     \
  "disk = [\"a\", \"b\"]; coordinate = \"" coordinate "\"; type = \"" type "\"; "                  \
  "amplitude = @A; omega = @W; phase = @P;"
  RUN(WAVE("theta", "harmonic"));
  RUN(WAVE("theta", "parabolic"));
  RUN(WAVE("theta", "triangle"));
  RUN(WAVE("theta", "square") " rise = @S;");
  RUN(WAVE("y", "triangle") " ramp = @R;", WAVE("x", "square") " rise = @S; ramp = @R;",
      WAVE("x", "triangle"));
  RUN(WAVE("y", "harmonic") " ramp = @R;", WAVE("x", "parabolic") " ramp = @R;");
}

static void velocities_and_tables(void **unused) {
  (void)unused;
#define VELOCITY                                                                                   \
  "disk = \"a\"; coordinate = (\"x\", \"theta\"); type = \"velocity\"; velocity = @V;"
#define TABLE                                                                                      \
  "wall = \"w\"; coordinate = \"y\"; type = \"table\"; times = (0, 0.001, 0.002, 0.005); "         \
  "values = (0, 1, -1, 0); factor = @A; periodic = true;"
  RUN(VELOCITY);
  RUN(VELOCITY " ramp = @R;");
  RUN(TABLE);
  RUN(TABLE " ramp = @R;");
}

/* Several on one coordinate, and some that go beside them. */
static void several_motions(void **unused) {
  (void)unused;
  RUN(VELOCITY " ramp = @R;", WAVE("x", "harmonic"), RANDOM(1), RANDOM(7) " ramp = @R;", TABLE,
      WAVE("theta", "parabolic"), WAVE("theta", "harmonic"));
}

/* A lane's angle is about to leave [-4, 4]: so many steps are ready, and no more. */
static void ends_where_an_angle_leaves_its_range(void **unused) {
  (void)unused;
  const char *const moves[] = {
      "disk = \"a\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 700;"};
  herd h = herd_new(moves, 1, 2, 10);
  int64_t ready;
  while ((ready = pose_batch_ahead(h.m)) > 0) {
    assert_true(ready <= 64);
    for (int64_t k = 0; k < ready; k++) {
      compare_step(&h);
      for (size_t l = 0; l < 2; l++) assert_true(fabs(h.one[l]->state->theta[1]) <= 4.0);
    }
  }
  /* the next step of one of them is beyond */
  bool beyond = false;
  for (size_t l = 0; l < 2; l++) {
    size_t n;
    motion_ahead(h.one[l]);
    beyond = beyond || motion_prescribed(h.one[l], &n)->value[motion_index(h.one[l])] > 4.0;
  }
  assert_true(beyond);
  assert_true(h.steps > 20);
  herd_free(&h);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_motions),
      cmocka_unit_test(waves),
      cmocka_unit_test(velocities_and_tables),
      cmocka_unit_test(several_motions),
      cmocka_unit_test(ends_where_an_angle_leaves_its_range),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
