/* test_contact_forces.c: the force of a contact is one, whoever asks: what moves the disk and its wall is what contact tables, groups, stress and
 * single contacts of the engine say, for all shapes and laws. */
#include "measure/resultant.h"
#include "measure/stress.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/step/access.h"
#include "run/simulation_private.h"
#include "system.h"

static const struct {
  const char *name;
  sd_contact_law law;
} laws[] = {
    {"linear", {.k_n = 1e3, .k_t = 5e2, .gamma_n = 1, .mu = 0.3}},
    {"dashpots, rolling",
     {.k_n = 1e3,
      .k_t = 5e2,
      .gamma_n = 1,
      .gamma_t = 2,
      .mu = 0.3,
      .k_r = 300,
      .mu_r = 0.2,
      .gamma_r = 1}},
    {"rolling backwards",
     {.k_n = 1e3, .k_t = 5e2, .gamma_n = 1, .mu = 0.3, .k_r = 300, .mu_r = 0.2}},
    {"mindlin, pull-off",
     {.normal = SD_NORMAL_HERTZ,
      .tangential = SD_TANGENTIAL_MINDLIN,
      .k_n = 3e3,
      .k_t = 2e3,
      .mu = 0.3,
      .cohesion = SD_COHESION_CONSTANT,
      .pull_off = 2,
      .range = 0.02}},
    {"kinetic, bridge",
     {.k_n = 1e3,
      .k_t = 5e2,
      .gamma_n = 1,
      .mu = 0.4,
      .mu_kinetic = 0.2,
      .cohesion = SD_COHESION_BRIDGE,
      .pull_off = 2,
      .range = 0.02,
      .rupture = 0.05}},
};

enum {
  DISK,
  FIXED,
  LINE,
  SEGMENT,
  END,
  POLYLINE,
  VERTEX,
  INSIDE,
  OUTSIDE,
  BOWL,
  ROOF,
  RIM,
  SHAPES
};
static const char *const shapes[] = {
    "disk",   "fixed disk",  "line",        "segment",   "end of a segment", "polyline",
    "vertex", "in a circle", "on a circle", "in an arc", "on an arc",        "end of an arc"};

static void add_arc(sd_model *m, double y, double from, double to) {
  sd_model_add_wall(m, &(sd_wall){.kind = SD_WALL_ARC,
                                  .center = {0, y},
                                  .pivot = {0.3, y},
                                  .radius = 2,
                                  .from = from,
                                  .to = to});
}

/* What the disk at (0, 1) stands on at (0, 0), or beside it. */
static void add_partner(sd_model *m, int shape) {
  const double flat[][2] = {{-3, 0}, {3, 0}}, half[][2] = {{-3, -0.2}, {-0.3, 0}},
               bent[][2] = {{-3, 0}, {-1, 0}, {2, 0}, {3, 1}},
               roof[][2] = {{-2, -1}, {0, 0}, {2, -1.1}};
  if (shape == DISK || shape == FIXED) system_disk(m, 0, -0.7, 0.7, 3);
  if (shape == FIXED) {
    m->disks[1].driven = true;
    for (int c = 0; c < 3; c++) m->disks[1].locked[c] = true;
  }
  if (shape == LINE) system_straight(m, SD_WALL_LINE, 2, flat);
  if (shape == SEGMENT) system_straight(m, SD_WALL_SEGMENT, 2, flat);
  if (shape == END) system_straight(m, SD_WALL_SEGMENT, 2, half);
  if (shape == POLYLINE) system_straight(m, SD_WALL_POLYLINE, 4, bent);
  if (shape == VERTEX) system_straight(m, SD_WALL_POLYLINE, 3, roof);
  if (shape == INSIDE) system_circle(m, 0, 2, 2, true);
  if (shape == OUTSIDE) system_circle(m, 0, -2, 2, false);
  if (shape == BOWL) add_arc(m, 2, -2, -1);
  if (shape == ROOF) add_arc(m, -2, 1, 2);
  if (shape == RIM) add_arc(m, -2, M_PI / 2 + 0.1, 3);
}

static sd_simulation *start(int shape, size_t law, sd_variant variant) {
  sd_model *m = system_new(SD_VERLET, variant, 1e-3, laws[law].law);
  const double lift = shape == END ? 0.94 : shape == RIM ? 0.965 : 0.99;
  system_disk(m, 0, lift, 1, 2);
  system_velocity(m, 0, 0.3, -0.5, strstr(laws[law].name, "backwards") ? -5 : 5);
  m->gravity[SD_Y] = -10;
  add_partner(m, shape);
  sd_model_add_group(m, "one", 1, &(uint32_t){0});
  if (m->n_disks > 1) sd_model_add_group(m, "two", 1, &(uint32_t){1});
  m->measure_groups = m->measure_walls = true;
  m->contact_disks = calloc(1, sizeof *m->contact_disks);
  m->n_contact_disks = 1;
  return system_start(m);
}

static void near(double got, double expected, const char *what, int shape, size_t law,
                 int variant) {
  SYSTEM_NEAR(got, expected, 1e-10 * (1 + fabs(expected)), "%s: %s, %s, %s", what, shapes[shape],
              laws[law].name, system_variants[variant]);
}
#define NEAR(got, expected, what) near(got, expected, what, shape, law, variant)

/* The contact alone, as tables, pictures and stress have it. */
static void check_tables(sd_simulation *s, int shape, size_t law, int variant) {
  const sd_model *m = sd_simulation_model(s);
  const system_body a = system_at(s, 0);
  configuration c;
  frame_data f;
  stress t;
  assert_int_equal(frame_data_of_state(&f, m, sd_simulation_state(s), NULL), SD_OK);
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  assert_int_equal(c.n_contacts, 1);
  NEAR(-c.contacts->fx, a.force_x, "x of the table");
  NEAR(-c.contacts->fy, a.force_y, "y of the table");
  NEAR(m->disks[0].radius * c.contacts->tau + c.contacts->couple, a.torque, "torque of the table");
  const double box[] = {-9, 9, -9, 9};
  const region g = configuration_region(&c, box);
  assert_int_equal(stress_new(&t, &c, &g, NULL), SD_OK);
  NEAR(t.resultant[0][0], a.force_x, "unbalanced x");
  NEAR(t.resultant[0][1], a.force_y - 20, "unbalanced y");
  const double area = 18 * 18;
  NEAR(t.contact[STRESS_XY] * area, -c.contacts->lx * a.force_y, "stress xy");
  NEAR(t.contact[STRESS_YX] * area, -c.contacts->ly * a.force_x, "stress yx");
  stress_free(&t);
  configuration_free(&c);
  frame_data_free(&f);
}

/* Series of the group of the disk, of the disk, of the wall or other group. */
static void check_series(sd_simulation *s, int shape, size_t law, int variant) {
  const sd_model *m = sd_simulation_model(s);
  const system_body a = system_at(s, 0), b = system_at(s, 1);
  resultants r;
  resultants_new(&r, m);
  assert_int_equal(resultants_compute(&r, m, sd_simulation_state(s),
                                      engine_slots(simulation_engine(s)), NULL, NULL),
                   SD_OK);
  const resultant *of_b = m->n_walls ? r.wall : &r.group[1];
  NEAR(r.group[0].force_x, a.force_x, "x of the group");
  NEAR(r.group[0].force_y, a.force_y, "y of the group");
  NEAR(r.group[0].torque, a.torque, "torque of the group");
  NEAR(r.disk[0].torque, a.torque, "torque of the disk");
  NEAR(of_b->force_x, -a.force_x, "x of its partner");
  NEAR(of_b->force_y, -a.force_y, "y of its partner");
  NEAR(of_b->torque, b.torque, "torque of its partner");
  resultants_free(&r);
}

/* The engine's own look at one contact; balance of angular momentum where the force is that of an energy. */
static void check_engine(sd_simulation *s, int shape, size_t law, int variant) {
  const engine *e = simulation_engine(s);
  const pairs *p = &e->work.pairs;
  const system_body a = system_at(s, 0), b = system_at(s, 1);
  size_t closed = 0;
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] < 0 || !pairs_closed(p, k)) continue;
    const contact_reaction r = contact_reaction_of(e, k);
    const double sign =
        e->state->id[p->a[k]] == 0 ? -1 : 1; /* of two disks the first has the lower slot */
    NEAR(sign * r.fx, a.force_x, "x of the engine");
    NEAR(sign * r.fy, a.force_y, "y of the engine");
    NEAR(sign < 0 ? r.torque_a : r.torque_b, a.torque, "torque of the engine");
    NEAR(sign < 0 ? r.torque_b : r.torque_a, b.torque, "torque on its partner");
    closed++;
  }
  assert_int_equal(closed, 1);
  const bool round = shape == DISK || shape == FIXED || shape == INSIDE || shape == OUTSIDE;
  if (variant == SD_PAPER && round) return;
  NEAR(a.torque + b.torque, -(a.x - b.x) * a.force_y + (a.y - b.y) * a.force_x, "angular momentum");
}

static void test_one_force(void **unused) {
  for (int shape = 0; shape < SHAPES; shape++)
    for (size_t law = 0; law < sizeof laws / sizeof *laws; law++)
      for (int variant = 0; variant < 2; variant++) {
        sd_simulation *s = start(shape, law, variant ? SD_CONSERVATIVE : SD_PAPER);
        double most = 0;
        for (int n = 0; n < 12; n++) {
          system_advance(s, 2);
          check_tables(s, shape, law, variant);
          check_series(s, shape, law, variant);
          check_engine(s, shape, law, variant);
          most = fmax(most, fabs(system_at(s, 0).torque));
        }
        assert_true(most > 0.05); /* it is dragged along its partner */
        system_end(s);
      }
}

RUN_TESTS(TEST(test_one_force))
