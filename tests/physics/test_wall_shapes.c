/* test_wall_shapes.c: one wall in several shapes gives one motion and one energy budget, whatever a contact remembers or costs: joints of
 * arcs, polylines and walls that meet are no events. */
#include "system.h"

static const struct {
  const char *name;
  sd_contact_law law;
} laws[] = {
    {"linear", {.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .mu = 0.3}},
    {"kinetic", {.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .mu = 0.4, .mu_kinetic = 0.15}},
    {"dashpot", {.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .gamma_t = 2, .mu = 0.3}},
    {"hertz, mindlin",
     {.normal = SD_NORMAL_HERTZ,
      .tangential = SD_TANGENTIAL_MINDLIN,
      .k_n = 1e5,
      .k_t = 5e4,
      .gamma_n = 1,
      .mu = 0.3}},
    {"rolling",
     {.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .mu = 0.5, .k_r = 2e3, .mu_r = 0.05, .gamma_r = 1}},
    {"pull-off",
     {.k_n = 1e4,
      .k_t = 5e3,
      .gamma_n = 1,
      .mu = 0.3,
      .cohesion = SD_COHESION_CONSTANT,
      .pull_off = 2,
      .range = 0.02}},
    {"bridge",
     {.k_n = 1e4,
      .k_t = 5e3,
      .gamma_n = 1,
      .mu = 0.3,
      .cohesion = SD_COHESION_BRIDGE,
      .pull_off = 2,
      .range = 0.02,
      .rupture = 0.05}},
};
enum { LAWS = sizeof laws / sizeof *laws };

static void add_arc(sd_model *m, double radius, double from, double to) {
  sd_model_add_wall(m, &(sd_wall){.kind = SD_WALL_ARC, .radius = radius, .from = from, .to = to});
}

static void add_straight(sd_model *m, double x0, double y0, double x1, double y1) {
  const double points[2][2] = {{x0, y0}, {x1, y1}};
  system_straight(m, SD_WALL_SEGMENT, 2, points);
}

/* All walls move together. */
static void shake_all(sd_model *m, int coordinate, double amplitude, double omega) {
  system_shake(m, 1, coordinate, amplitude, omega, 0);
  sd_motion *q = &m->motions[m->n_motions - 1];
  for (uint32_t w = 1; w < m->n_walls; w++) {
    q->bodies = system_grow(q->bodies, q->n_bodies, sizeof *q->bodies);
    q->bodies[q->n_bodies++] = 1 + w;
  }
}

enum { CIRCLE, RING, HALVES, FOUR, ROUND_SHAPES };
static const char *const round_shapes[] = {"circle", "ring", "two arcs", "four arcs"};

static void add_round(sd_model *m, int shape, bool inside) {
  const double radius = 3;
  if (shape == CIRCLE) system_circle(m, 0, 0, radius, inside);
  if (shape == RING) add_arc(m, radius, 0.2, 0.2 + 2 * M_PI);
  for (int k = 0; shape == HALVES && k < 2; k++)
    add_arc(m, radius, 0.7 + k * M_PI, 0.7 + (k + 1) * M_PI);
  for (int k = 0; shape == FOUR && k < 4; k++)
    add_arc(m, radius, 2.2 - k * M_PI / 2, 2.2 - (k - 1) * M_PI / 2);
}

/* Pressed on the wall and set going, the disk makes more than a turn around it. */
static sd_simulation *start_round(int shape, bool inside, bool turns, size_t law,
                                  sd_integrator integrator) {
  sd_model *m = system_new(integrator, SD_CONSERVATIVE, 5e-5, laws[law].law);
  system_disk(m, 0, inside ? -2.3991 : 3.6009, 0.6, 0.1);
  system_velocity(m, 0, inside ? -11 : 0.6, -0.1, -5);
  m->fields = system_grow(m->fields, m->n_fields++, sizeof *m->fields);
  m->fields[0] = (sd_body_force){.kind = SD_FIELD_CENTRAL, .strength = inside ? 0 : 4, .power = 1};
  add_round(m, shape, inside);
  if (turns) shake_all(m, SD_THETA, 0.7, 5);
  return system_start(m);
}

static void compare(sd_simulation *one, sd_simulation *two, const char *shape, const char *law,
                    double within) {
  const system_body a = system_at(one, 0), b = system_at(two, 0);
  SYSTEM_NEAR(b.x, a.x, within, "x of %s, %s", shape, law);
  SYSTEM_NEAR(b.y, a.y, within, "y of %s, %s", shape, law);
  SYSTEM_NEAR(b.omega, a.omega, 100 * within, "omega of %s, %s", shape, law);
  SYSTEM_NEAR(b.torque, a.torque, 1e4 * within, "torque of %s, %s", shape, law);
  const sd_energy p = sd_simulation_energy(one), q = sd_simulation_energy(two);
  const double near = 30 * within * p.scale;
  SYSTEM_NEAR(q.friction, p.friction, near, "friction of %s, %s", shape, law);
  SYSTEM_NEAR(q.viscous, p.viscous, near, "viscous of %s, %s", shape, law);
  SYSTEM_NEAR(q.rolling, p.rolling, near, "rolling of %s, %s", shape, law);
  SYSTEM_NEAR(q.bridge, p.bridge, near, "bridge of %s, %s", shape, law);
  SYSTEM_NEAR(q.opening, p.opening, near, "opening of %s, %s", shape, law);
  SYSTEM_NEAR(q.work, p.work, near, "work of %s, %s", shape, law);
  SYSTEM_NEAR(q.elastic_rolling, p.elastic_rolling, near, "elastic rolling of %s, %s", shape, law);
  SYSTEM_NEAR(q.cohesion, p.cohesion, near, "cohesion of %s, %s", shape, law);
}

static void test_round_walls(void **unused) {
  for (size_t law = 0; law < LAWS; law++)
    for (int inside = 0; inside < 2; inside++)
      for (int turns = 0; turns < 2; turns++) {
        const sd_integrator integrator = turns ? SD_GEAR5 : SD_VERLET;
        sd_simulation *s[ROUND_SHAPES];
        for (int shape = 0; shape < ROUND_SHAPES; shape++)
          s[shape] = start_round(shape, inside, turns, law, integrator);
        for (int n = 0; n < 40; n++)
          for (int shape = 0; shape < ROUND_SHAPES; shape++) {
            system_advance(s[shape], 1000);
            if (shape) compare(s[0], s[shape], round_shapes[shape], laws[law].name, 1e-7);
          }
        for (int shape = 0; shape < ROUND_SHAPES; shape++) system_end(s[shape]);
      }
}

enum { LINE, SEGMENT, TWO, AGAINST, FIVE, POLYLINE, STRAIGHT_SHAPES };
static const char *const straight_shapes[] = {
    "line", "segment", "two segments", "segments of opposite ways", "five segments", "polyline"};

/* On the line through the origin in direction d. */
static void add_flat(sd_model *m, int shape, const double d[2]) {
  const double joints[] = {-40, -0.5, 0, 0.3, 1.1, 50};
  double points[6][2];
  for (int k = 0; k < 6; k++)
    for (int c = 0; c < 2; c++) points[k][c] = joints[k] * d[c];
#define PIECE(p, q) add_straight(m, points[p][0], points[p][1], points[q][0], points[q][1])
  if (shape == LINE) system_straight(m, SD_WALL_LINE, 2, (const double(*)[2])(points + 2));
  if (shape == SEGMENT) PIECE(0, 5);
  if (shape == TWO) PIECE(0, 2), PIECE(2, 5);
  if (shape == AGAINST) PIECE(2, 0), PIECE(2, 5);
  for (int k = 5; shape == FIVE && k > 0; k--) PIECE(k, k - 1);
  if (shape == POLYLINE) system_straight(m, SD_WALL_POLYLINE, 6, (const double(*)[2])points);
#undef PIECE
}

static void test_straight_walls(void **unused) {
  for (size_t law = 0; law < LAWS; law++)
    for (int way = 0; way < 8; way++) {
      const double angle = way % 2 ? 0.37 : 0, d[2] = {cos(angle), sin(angle)};
      const int below = way / 2 % 2, moves = way / 4;
      sd_simulation *s[STRAIGHT_SHAPES];
      for (int shape = 0; shape < STRAIGHT_SHAPES; shape++) {
        sd_model *m = system_new(way & 1 ? SD_GEAR5 : SD_VERLET, SD_PAPER, 5e-5, laws[law].law);
        const double side = below ? -1 : 1, r = 0.6, gap = 0.60037,
                     n[2] = {-side * d[1], side * d[0]};
        system_disk(m, -d[0] + gap * n[0], -d[1] + gap * n[1], r, 0.1);
        system_velocity(m, 0, 2 * d[0] - 0.05 * n[0], 2 * d[1] - 0.05 * n[1], 7);
        m->gravity[SD_X] = -10 * n[0];
        m->gravity[SD_Y] = -10 * n[1];
        add_flat(m, shape, d);
        if (moves) shake_all(m, SD_X, 0.1, 5);
        if (moves) shake_all(m, SD_Y, 0.05, 7);
        s[shape] = system_start(m);
      }
      for (int n = 0; n < 30; n++)
        for (int shape = 0; shape < STRAIGHT_SHAPES; shape++) {
          system_advance(s[shape], 800);
          if (shape) compare(s[0], s[shape], straight_shapes[shape], laws[law].name, 1e-9);
        }
      for (int shape = 0; shape < STRAIGHT_SHAPES; shape++) system_end(s[shape]);
    }
}

/* Over a convex corner, into a concave one: a polyline, and segments in any order and way. */
static void test_corners(void **unused) {
  const double points[4][2] = {{-3, 0.2}, {0, 0}, {1.5, -0.9}, {5, -0.2}};
  for (size_t law = 0; law < LAWS; law++) {
    sd_simulation *s[4];
    for (int shape = 0; shape < 4; shape++) {
      sd_model *m = system_new(SD_VERLET, SD_PAPER, 5e-5, laws[law].law);
      system_disk(m, -1.5, 0.61, 0.5, 0.1);
      system_velocity(m, 0, 1.6, 0, 0);
      m->gravity[SD_Y] = -10;
      for (int k = 0; shape && k < 3; k++) {
        const int at = shape & 1 ? k : 2 - k, back = shape == 3 ? k % 2 : shape == 2;
        add_straight(m, points[at + back][0], points[at + back][1], points[at + !back][0],
                     points[at + !back][1]);
      }
      if (!shape) system_straight(m, SD_WALL_POLYLINE, 4, points);
      s[shape] = system_start(m);
    }
    for (int n = 0; n < 40; n++)
      for (int shape = 0; shape < 4; shape++) {
        system_advance(s[shape], 1000);
        if (shape) compare(s[0], s[shape], "segments at corners", laws[law].name, 1e-7);
      }
    assert_true(system_at(s[0], 0).x > 0.5);
    for (int shape = 0; shape < 4; shape++) system_end(s[shape]);
  }
}

/* A stadium of two segments and two arcs: a disk that sticks to it runs around it, inside or outside, and always has one contact. */
static void test_a_stadium(void **unused) {
  for (int inside = 0; inside < 2; inside++) {
    const sd_contact_law sticky = {
        .k_n = 1e4, .cohesion = SD_COHESION_CONSTANT, .pull_off = 2, .range = 0.1};
    sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-4, sticky);
    const double v = 2, r = inside ? 0.7 : 1.3, deep = 2e-4;
    system_disk(m, -0.9, inside ? -r - deep : -r + deep, 0.3, 0.1);
    system_velocity(m, 0, v, 0, 0);
    add_straight(m, -1, -1, 1, -1);
    sd_model_add_wall(
        m,
        &(sd_wall){
            .kind = SD_WALL_ARC, .center = {1, 0}, .radius = 1, .from = -M_PI / 2, .to = M_PI / 2});
    add_straight(m, -1, 1, 1, 1);
    sd_model_add_wall(m, &(sd_wall){.kind = SD_WALL_ARC,
                                    .center = {-1, 0},
                                    .radius = 1,
                                    .from = M_PI / 2,
                                    .to = 1.5 * M_PI});
    sd_simulation *s = system_start(m);
    const sd_energy start = sd_simulation_energy(s);
    size_t laps = 0;
    bool right = false;
    for (int n = 0; n < 120000; n++) {
      system_advance(s, 1);
      assert_true(sd_simulation_state(s)->n_contacts <= 1);
      if ((system_at(s, 0).x > 1) != right) laps += right, right = !right;
    }
    assert_true(laps > 1);
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.residual, 0, 1e-4 * start.kinetic_translation, "energy");
    system_end(s);
  }
}

/* A disk that lies on a joint is carried once: of two, three walls, also of different materials, level and tilted. */
static void test_on_a_joint(void **unused) {
  const sd_contact_law one = {.k_n = 1e4, .gamma_n = 3}, table[] = {one, one, one, one};
  for (int kind = 0; kind < 6; kind++) {
    const double angle = kind % 2 ? 0.37 : 0, d[2] = {cos(angle), sin(angle)};
    sd_model *m = system_new_laws(SD_VERLET, SD_PAPER, 1e-4, 2, table);
    m->gravity[SD_X] = 10 * d[1];
    m->gravity[SD_Y] = -10 * d[0];
    system_disk(m, 0.1 * d[0] - 0.5 * d[1], 0.1 * d[1] + 0.5 * d[0], 0.5, 0.1);
    if (kind / 2 == 2) {
      const double points[][2] = {
          {-d[0], -d[1]}, {0.1 * d[0], 0.1 * d[1]}, {0.3 * d[0], 0.3 * d[1]}};
      system_straight(m, SD_WALL_POLYLINE, 3, points);
    } else {
      add_straight(m, -d[0], -d[1], 0.1 * d[0], 0.1 * d[1]);
      add_straight(m, 0.1 * d[0], 0.1 * d[1], d[0], d[1]);
    }
    if (kind / 2 == 1)
      add_straight(m, 0.1 * d[0], 0.1 * d[1], 0.5 * d[0] + d[1], 0.5 * d[1] - d[0]);
    if (kind / 2 < 2) m->walls[1].material = 1;
    sd_simulation *s = system_start(m);
    system_advance(s, 20000);
    assert_int_equal(sd_simulation_state(s)->n_contacts, 1);
    SYSTEM_NEAR(hypot(system_at(s, 0).force_x, system_at(s, 0).force_y), 1, 1e-6, "weight, case %d",
                kind);
    system_end(s);
  }
}

RUN_TESTS(TEST(test_round_walls), TEST(test_straight_walls), TEST(test_corners),
          TEST(test_a_stadium), TEST(test_on_a_joint))
