/* test_surfaces.c: walls whose surface runs (conveyors): disks that are taken along, the energy that this costs, belts that turn back,
 * and that a surface is what a wall that moves along itself, or a round wall that turns, would be. */
#include "system.h"

static const sd_contact_law law = {.k_n = 1e5, .k_t = 1e6, .gamma_n = 20, .mu = 0.2};
enum { SHAPES = 5 };
static const char *const shape_names[SHAPES] = {"line", "segment", "polyline", "arc", "drum"};
#define MASS 0.1
#define GRAVITY 10.0
#define RADIUS 1.0

/* A wall whose surface is at y = 0 at x = 0 and runs to the right there when its speed is positive; arcs and drums are so large that it
 * hardly bends on the way. Their radius. */
#define LARGE 1e5

static sd_wall wall_of(int shape, double (*points)[2]) {
  static const double line[3][2] = {{-50, 0}, {0.1, 0}, {50, 0}};
  memcpy(points, line, sizeof line);
  sd_wall w = {.points = points, .n_points = 2};
  if (shape < 2) memcpy(points[1], line[2], sizeof line[2]);
  if (shape == 0) w.kind = SD_WALL_LINE;
  if (shape == 1) w.kind = SD_WALL_SEGMENT;
  if (shape == 2) w.kind = SD_WALL_POLYLINE, w.n_points = 3;
  if (shape == 3)
    w = (sd_wall){.kind = SD_WALL_ARC,
                  .center = {0, LARGE},
                  .pivot = {0, LARGE},
                  .radius = LARGE,
                  .from = -M_PI,
                  .to = 0};
  if (shape == 4)
    w = (sd_wall){.kind = SD_WALL_CIRCLE, .pivot = {0, LARGE}, .radius = LARGE, .inside = true};
  return w;
}

static sd_model *on_belt(int shape, double dt) {
  sd_model *m = system_new(SD_VERLET, SD_CONSERVATIVE, dt, law);
  double points[3][2];
  const sd_wall w = wall_of(shape, points);
  m->gravity[1] = -GRAVITY;
  system_disk(m, 0, RADIUS - MASS * GRAVITY / law.k_n, RADIUS, MASS);
  sd_model_add_wall(m, &w);
  return m;
}

typedef struct means {
  double speed, omega, work;
} means;

/* Over periods of the skin's spring, which nothing damps. */
static means mean_of(sd_simulation *s, double period, double dt) {
  means sum = {0};
  const int n = (int)lround(10 * period / dt);
  for (int k = 0; k < n; k++) {
    system_advance(s, 1);
    sum.speed += system_at(s, 0).vx / n;
    sum.omega += system_at(s, 0).omega / n;
    sum.work += sd_simulation_energy(s).work / n;
  }
  return sum;
}

/* Slides for v/(3 mu g), then rolls with v/3; the belt spends m v^2/3, of which half is lost. */
static void test_a_disk_is_taken_along(void **unused) {
  const double v = 3, dt = 2e-6, time = v / (3 * law.mu * GRAVITY);
  for (int shape = 0; shape < SHAPES; shape++) {
    sd_model *m = on_belt(shape, dt);
    system_move(m, 1, SD_SURFACE, v);
    sd_simulation *s = system_start(m);
    system_advance(s, (int64_t)(0.99 * time / dt));
    SYSTEM_NEAR(system_at(s, 0).vx, 0.99 * v / 3, 1e-4 * v, "%s: sliding", shape_names[shape]);
    assert_int_equal(system_touch(s, 0, 1).slide, 1);
    system_advance(s, (int64_t)(0.5 * time / dt));
    const means mean = mean_of(s, 2 * M_PI * sqrt(MASS / (3 * law.k_t)), dt);
    SYSTEM_NEAR(mean.speed, v / 3, 1e-4 * v / 3, "%s: speed", shape_names[shape]);
    SYSTEM_NEAR(mean.omega, 2 * v / 3 / RADIUS, 1e-4 * v, "%s: rotation", shape_names[shape]);
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.friction, MASS * v * v / 6, 1e-4 * MASS * v * v / 6, "%s: lost",
                shape_names[shape]);
    SYSTEM_NEAR(mean.work, MASS * v * v / 3, 1e-4 * MASS * v * v / 3, "%s: work",
                shape_names[shape]);
    /* where a disk goes from one piece to the next the force along the wall is missing for a step */
    const double step = shape == 2 ? law.mu * MASS * GRAVITY * v * dt / e.scale : 0;
    SYSTEM_NEAR(e.residual / e.scale, 0, 1e-7 + step, "%s: residual", shape_names[shape]);
    system_end(s);
  }
}

static void test_a_block_reaches_the_speed_of_the_belt(void **unused) {
  const double v = 1, dt = 2e-6;
  for (int shape = 0; shape < SHAPES; shape++) {
    sd_model *m = on_belt(shape, dt);
    m->disks[0].locked[SD_THETA] = true;
    system_move(m, 1, SD_SURFACE, v);
    sd_simulation *s = system_start(m);
    system_advance(s, (int64_t)(1.1 * v / (law.mu * GRAVITY) / dt));
    SYSTEM_NEAR(mean_of(s, 2 * M_PI * sqrt(MASS / law.k_t), dt).speed, v, 1e-4 * v, "%s: speed",
                shape_names[shape]);
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.friction, MASS * v * v / 2, 1e-4 * MASS * v * v / 2, "%s: lost",
                shape_names[shape]);
    system_end(s);
  }
}

/* A line that moves along itself, and a drum that turns, do the same as their surface alone. */
static void test_a_surface_is_a_wall_that_moves(void **unused) {
  for (int shape = 0; shape < SHAPES; shape += SHAPES - 1) {
    sd_simulation *s[2];
    for (int k = 0; k < 2; k++) {
      sd_model *m = on_belt(shape, 1e-5);
      const bool drum = shape == SHAPES - 1;
      if (drum) { /* small, so that it is seen to be round */
        m->walls[0].radius = 4;
        m->walls[0].pivot[1] = 4;
      }
      system_shake(m, 1,
                   k == 0 ? SD_SURFACE
                   : drum ? SD_THETA
                          : SD_X,
                   k == 1 && drum ? 0.05 : 0.2, 30, 0.3);
      s[k] = system_start(m);
    }
    for (int n = 0; n < 100; n++) {
      system_advance(s[0], 500);
      system_advance(s[1], 500);
      const system_body a = system_at(s[0], 0), b = system_at(s[1], 0);
      SYSTEM_NEAR(a.x, b.x, 1e-9, "%s: x", shape_names[shape]);
      SYSTEM_NEAR(a.omega, b.omega, 1e-8, "%s: omega", shape_names[shape]);
      const sd_energy p = sd_simulation_energy(s[0]), q = sd_simulation_energy(s[1]);
      SYSTEM_NEAR(p.work, q.work, 1e-9 * q.scale, "%s: work", shape_names[shape]);
      SYSTEM_NEAR(p.friction, q.friction, 1e-9 * q.scale, "%s: friction", shape_names[shape]);
    }
    const sd_energy e = sd_simulation_energy(s[0]);
    assert_true(e.friction > 0 && e.work > 0);
    for (int k = 0; k < 2; k++) system_end(s[k]);
  }
}

/* The other side of a wall runs back, and a disk that is carried around an end feels the belt all the way. */
static void test_the_other_side_runs_back(void **unused) {
  for (int shape = 0; shape < 2; shape++) {
    sd_model *m = on_belt(shape, 2e-6);
    m->gravity[1] = GRAVITY;
    m->disks[0].position[1] *= -1;
    system_move(m, 1, SD_SURFACE, 3);
    sd_simulation *s = system_start(m);
    system_advance(s, (int64_t)(0.25 / 2e-6));
    SYSTEM_NEAR(system_at(s, 0).vx, -0.25 * law.mu * GRAVITY, 1e-4, "%s", shape_names[shape]);
    system_end(s);
  }
}

/* lambda stays small however far the belt runs: a disk held in place sees the same force after 1e8 radii. */
static void test_far(void **unused) {
  sd_model *m = on_belt(1, 1e-4);
  m->disks[0].locked[SD_X] = m->disks[0].locked[SD_THETA] = true;
  system_shake(m, 1, SD_SURFACE, 1e-8, 2 * M_PI, 0);
  system_move(m, 1, SD_SURFACE, 1e6);
  m->phases = NULL;
  sd_simulation *s = system_start(m);
  for (int n = 0; n < 10; n++) {
    system_advance(s, 100000);
    SYSTEM_NEAR(system_at(s, 0).force_x, law.mu * MASS * GRAVITY, 1e-6, "sliding");
    const sd_state *q = sd_simulation_state(s);
    assert_true(fabs(q->surface[0]) <= 4 && fabs(q->contact_lambda_ref[0]) < 60);
    SYSTEM_NEAR(q->surface_turn[0] + q->surface[0], 1e7 * (n + 1), 1e-6, "way");
  }
  const sd_energy e = sd_simulation_energy(s);
  SYSTEM_NEAR(e.residual / e.scale, 0, 1e-9, "residual");
  SYSTEM_NEAR(e.friction / (law.mu * MASS * GRAVITY * 1e8), 1, 1e-6, "friction");
  system_end(s);
}

RUN_TESTS(TEST(test_a_disk_is_taken_along), TEST(test_a_block_reaches_the_speed_of_the_belt),
          TEST(test_a_surface_is_a_wall_that_moves), TEST(test_the_other_side_runs_back),
          TEST(test_far))
