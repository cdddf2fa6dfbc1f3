/* test_packings_deck.c: containers and packings of decks: what arrives in the model, and that the echo makes the same
 * disks again. Then those that are refused, and with which words. */
#include "model/containers.h"
#include "model/model.h"
#include "model/state.h"
#include "packings_decks.h"
#include "slipdisk/deck.h"

static void near_to(double value, double expected, const char *what) {
  if (fabs(value - expected) <= 1e-12 * (1 + fabs(expected))) return;
  print_error("%s: %.15g, expected %.15g\n", what, value, expected);
  fail();
}

static const sd_wall *wall_of(const sd_model *m, const char *name) {
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].name && strcmp(m->walls[w].name, name) == 0) return &m->walls[w];
  print_error("no wall \"%s\"\n", name);
  fail();
  return NULL;
}

/* The points of a wall, in order. */
static void check_points(const sd_model *m, const char *name, size_t n, const double (*points)[2]) {
  const sd_wall *wall = wall_of(m, name);
  assert_int_equal(wall->n_points, n);
  assert_int_equal(wall->material, 0);
  for (size_t k = 0; k < n; k++)
    for (int c = 0; c < 2; c++) near_to(wall->points[k][c], points[k][c], name);
}

static void check_region(const sd_model *m, double x0, double x1, double y0, double y1, bool px,
                         bool py) {
  near_to(m->region_lower[0], x0, "region");
  near_to(m->region_upper[0], x1, "region");
  near_to(m->region_lower[1], y0, "region");
  near_to(m->region_upper[1], y1, "region");
  assert_true(m->periodic[0] == px && m->periodic[1] == py);
  if (px) assert_true(m->lower[0] == m->region_lower[0] && m->upper[0] == m->region_upper[0]);
  if (py) assert_true(m->lower[1] == m->region_lower[1] && m->upper[1] == m->region_upper[1]);
}

static void test_box(void **state) {
  sd_model *m =
      good(HEAD ONE
           "container = { type = \"box\"; width = 10; height = 8; origin = (5, 1); open = false; };"
           "walls = ( { name = \"peg\"; type = \"segment\"; points = ((4, 5), (6, 5)); } );");
  assert_int_equal(m->container, SD_CONTAINER_BOX);
  assert_int_equal(m->n_walls, 5);
  assert_string_equal(m->walls[0].name, "peg");
  check_region(m, 0, 10, 1, 9, false, false);
  check_points(m, "floor", 2, (const double[2][2]){{0, 1}, {10, 1}});
  check_points(m, "left", 2, (const double[2][2]){{0, 9}, {0, 1}});
  check_points(m, "right", 2, (const double[2][2]){{10, 1}, {10, 9}});
  check_points(m, "lid", 2, (const double[2][2]){{10, 9}, {0, 9}});
  for (size_t w = 1; w < 5; w++) assert_int_equal(m->walls[w].kind, SD_WALL_LINE);
  near_to(wall_of(m, "floor")->pivot[0], 5, "pivot");
  sd_model_free(m);
  m = good(HEAD ONE BOX);
  assert_int_equal(m->n_walls, 3);
  sd_model_free(m);
}

/* Motions find the walls of a container and the disks of a bed. */
static void test_bed_and_channel(void **state) {
  sd_model *m = good(HEAD ONE "container = { type = \"channel\"; width = 10; height = 8; };"
                              "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = "
                              "\"velocity\"; velocity = 1; } );");
  check_region(m, -5, 5, 0, 8, true, false);
  assert_int_equal(m->n_walls, 1);
  assert_int_equal(m->motions[0].bodies[0], m->n_disks);
  sd_model_free(m);
  m = good(HEAD ONE
           "container = { type = \"bed\"; width = 10; height = 8; radius = 0.3; spacing = 0.7; };"
           "disks = ( { x = 0; y = 4; radius = 0.3; mass = 1; } );"
           "motions = ( { group = \"floor\"; coordinate = \"x\"; type = \"velocity\"; velocity = "
           "1; } );");
  check_region(m, -5, 5, 0, 8, true, false);
  assert_int_equal(m->n_walls, 0);
  assert_int_equal(m->n_disks, 1 + 14 + 1); /* 10/0.7 = 14.3 */
  assert_int_equal(m->n_free, 2);
  assert_int_equal(m->motions[0].n_bodies, 14);
  for (size_t k = 1; k < 15; k++) {
    const sd_disk *d = &m->disks[k];
    assert_true(d->driven && d->radius == 0.3);
    assert_string_equal(m->groups[d->group], "floor");
    near_to(d->position[0], -5 + (k - 0.5) * 10 / 14, "place in the floor");
    near_to(d->position[1], -0.3, "height of the floor");
  }
  assert_false(m->disks[15].driven);
  sd_model_free(m);
}

static void test_hopper(void **state) {
  sd_model *m =
      good(HEAD ONE "container = { type = \"hopper\"; width = 10; height = 12; outlet = 2; "
                    "angle = \"pi/4\"; origin = (1, 3); };");
  check_region(m, -4, 6, 3, 15, false, false);
  check_points(m, "left", 3, (const double[3][2]){{-4, 15}, {-4, 7}, {0, 3}});
  check_points(m, "right", 3, (const double[3][2]){{6, 15}, {6, 7}, {2, 3}});
  /* the site at the lower left corner lies outside */
  assert_true(fabs(m->disks[0].position[0] - 1) < 1);
  sd_model_free(m);
  m = good(HEAD ONE
           "container = { type = \"hopper\"; width = 10; height = 12; outlet = 2; angle = 0; };");
  check_points(m, "left", 3, (const double[3][2]){{-5, 12}, {-5, 0}, {-1, 0}});
  sd_model_free(m);
}

static void test_drum_and_periodic(void **state) {
  sd_model *m = good(HEAD ONE "container = { type = \"drum\"; radius = 4; origin = (1, 2); };");
  check_region(m, -3, 5, -2, 6, false, false);
  const sd_wall *drum = wall_of(m, "drum");
  assert_true(drum->kind == SD_WALL_CIRCLE && drum->inside && drum->radius == 4);
  assert_true(drum->pivot[0] == 1 && drum->pivot[1] == 2);
  sd_model_free(m);
  m = good(HEAD ONE "container = { type = \"polygon\"; radius = 4; sides = 4; origin = (1, 2); };");
  const double half = 4 / sqrt(2);
  check_region(m, 1 - half, 1 + half, 2 - half, 2 + half, false, false);
  check_points(
      m, "polygon", 4,
      (const double[4][2]){
          {1 - half, 2 - half}, {1 + half, 2 - half}, {1 + half, 2 + half}, {1 - half, 2 + half}});
  const sd_wall *square = wall_of(m, "polygon");
  assert_true(square->kind == SD_WALL_POLYLINE && square->closed);
  near_to(square->pivot[0], 1, "x about which it turns");
  near_to(square->pivot[1], 2, "y about which it turns");
  sd_model_free(m);
  m = good(HEAD ONE
           "container = { type = \"periodic\"; width = 10; height = 8; origin = (1, 2); };");
  check_region(m, 1, 11, 2, 10, true, true);
  assert_int_equal(m->n_walls, 0);
  sd_model_free(m);
}

/* Of two materials the container must name one. */
static void test_container_material(void **state) {
#define TWO                                                                                        \
  "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; }, { name = \"w\"; k_n = 10; } " \
  ");"                                                                                             \
  "material_pairs = ( { materials = (\"m\", \"w\"); k_n = 5; } );"                                 \
  "packings = ( { type = \"square\"; count = 1; material = \"m\"; " MONO " } );"
  refused(TWO BOX, "container.material: missing: expected the name of a material");
  sd_model *m =
      good(TWO "container = { type = \"box\"; width = 10; height = 8; material = \"w\"; };");
  assert_int_equal(wall_of(m, "left")->material, 1);
  assert_int_equal(m->disks[0].material, 0);
  sd_model_free(m);
  sd_model_free(good(TWO PERIODIC));
}

/* Every pair of disks that are in play, and every straight or round wall: no overlap beyond rounding. */
static void check_clear(const sd_model *m) {
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *a = &m->disks[i];
    for (size_t j = 0; j < i; j++) {
      const sd_disk *b = &m->disks[j];
      double d[2];
      if (a->waiting != b->waiting || (a->driven && b->driven)) continue;
      for (int c = 0; c < 2; c++) {
        double length = m->upper[c] - m->lower[c];
        d[c] = fabs(a->position[c] - b->position[c]);
        if (m->periodic[c]) d[c] = fmin(d[c], length - d[c]);
      }
      if (hypot(d[0], d[1]) < (a->radius + b->radius) * (1 - 1e-9))
        fail_msg("disks %zu, %zu overlap", i, j);
    }
    for (size_t w = 0; w < m->n_walls && !a->waiting; w++) {
      const sd_wall *wall = &m->walls[w];
      double x = a->position[0], y = a->position[1], gap = HUGE_VAL;
      if (wall->kind == SD_WALL_CIRCLE)
        gap = wall->radius - hypot(x - wall->pivot[0], y - wall->pivot[1]);
      if (wall->kind == SD_WALL_CIRCLE && !wall->inside) gap = -gap;
      for (size_t k = 0; k + 1 < wall->n_points; k++) {
        const double *p = wall->points[k], *q = wall->points[k + 1];
        double tx = q[0] - p[0], ty = q[1] - p[1],
               s = ((x - p[0]) * tx + (y - p[1]) * ty) / (tx * tx + ty * ty);
        if (wall->kind != SD_WALL_LINE) s = fmax(0, fmin(1, s));
        gap = fmin(gap, hypot(x - p[0] - s * tx, y - p[1] - s * ty));
      }
      if (gap < a->radius * (1 - 1e-9)) fail_msg("disk %zu is in wall %zu", i, w);
    }
  }
}

static double area_of(const sd_model *m) {
  double sum = 0;
  for (size_t i = 0; i < m->n_disks; i++)
    if (!m->disks[i].driven) sum += M_PI * m->disks[i].radius * m->disks[i].radius;
  return sum;
}

#define LIST "sizes = \"list\"; radii = (0.2, 0.28); density = 2;"
#define HOPPER                                                                                     \
  "container = { type = \"hopper\"; width = 10; height = 12; outlet = 2; angle = \"45 deg\"; };\n"
#define BED "container = { type = \"bed\"; width = 10; height = 8; radius = 0.3; };\n"
#define CHANNEL "container = { type = \"channel\"; width = 10; height = 8; };\n"

/* Each type in each container: nothing overlaps, nothing is outside, mass and group are right. */
static void test_all_types(void **state) {
  static const char *const containers[] = {BOX, CHANNEL, BED, HOPPER, DRUM, PERIODIC};
  static const char *const types[] = {"type = \"triangular\"; spacing = 0.6; jitter = 1;",
                                      "type = \"square\"; spacing = 0.6; jitter = 0.5;",
                                      "type = \"random\"; fraction = 0.42;", "type = \"front\";",
                                      "type = \"rain\"; count = 60; x = (-3, 3); y = (-3, 3.5);"};
  for (size_t c = 0; c < 6; c++)
    for (size_t k = 0; k < 5; k++) {
      char text[1024];
      bool rain = k == 4;
      if (rain && c == 5) continue;
      snprintf(text, sizeof text, HEAD "%s packings = ( { %s group = \"g\"; " LIST " } );",
               containers[c], types[k]);
      if (rain && c != 4) *strstr(strstr(text, "y = ("), "-3") = ' '; /* y from 3 */
      sd_model *m = good(text);
      check_clear(m);
      assert_true(rain ? m->n_free == 60 : m->n_free > 100);
      for (size_t i = 0; i < m->n_disks; i++) {
        const sd_disk *d = &m->disks[i];
        if (d->driven) continue;
        assert_true(d->radius == 0.2 || d->radius == 0.28);
        near_to(d->mass, 2 * M_PI * d->radius * d->radius, "mass");
        assert_string_equal(m->groups[d->group], "g");
        assert_true(d->waiting == rain);
        for (int a = 0; a < 2 && !rain; a++) {
          double margin = m->periodic[a] ? 0 : d->radius * (1 - 1e-9);
          assert_true(d->position[a] - margin >= m->region_lower[a]);
          assert_true(d->position[a] + margin <= m->region_upper[a]);
        }
        if (c == 3 && !rain) assert_true(fabs(d->position[0]) < 1 + fmin(4, d->position[1]));
      }
      sd_model_free(m);
    }
}

/* The fraction is that of the part of the region that lies inside the container. */
static void test_fraction(void **state) {
  static const struct {
    const char *text;
    double area;
  } row[] = {{BOX, 80}, {HOPPER, 10 * 12 - 16}, {DRUM, M_PI * 25}, {PERIODIC, 80}};
  for (size_t k = 0; k < 4; k++) {
    char text[1024];
    snprintf(text, sizeof text,
             HEAD "%s packings = ( { type = \"random\"; fraction = 0.4; " LIST " } );",
             row[k].text);
    sd_model *m = good(text);
    double mean = M_PI * (0.2 * 0.2 + 0.28 * 0.28) / 2;
    assert_true(fabs(area_of(m) - 0.4 * row[k].area) <= mean);
    sd_model_free(m);
    snprintf(
        text, sizeof text,
        HEAD
        "%s packings = ( { type = \"random\"; fraction = 0.4; sizes = \"powerlaw\"; exponent = "
        "3; lower = 0.1; upper = 0.5; mass = 3; } );",
        row[k].text);
    m = good(text);
    assert_true(fabs(area_of(m) - 0.4 * row[k].area) <= M_PI * 0.25 / 2);
    assert_true(m->disks[0].mass == 3);
    sd_model_free(m);
  }
}

/* A later packing finds the disks of the earlier ones; regions may overlap. */
static void test_several(void **state) {
  sd_model *m = good(
      HEAD BOX
      "disks = ( { x = 0; y = 3; radius = 1; mass = 1; } );"
      "walls = ( { type = \"circle\"; center = (3, 3); radius = 1; side = \"outside\"; } );"
      "packings = ( { type = \"random\"; count = 5; radius = 0.6; density = 1; group = \"a\"; },"
      "  { type = \"triangular\"; y = (0, 2); spacing = 0.6; group = \"b\"; " MONO " },"
      "  { type = \"front\"; y = (0, 6); group = \"c\"; " LIST " },"
      "  { type = \"rain\"; count = 30; group = \"d\"; " MONO " },"
      "  { type = \"rain\"; count = 20; x = (0, 4); y = (0, 30); group = \"e\"; " MONO " } );");
  check_clear(m);
  size_t count[5] = {0};
  for (size_t i = 1; i < m->n_disks; i++) count[m->disks[i].group]++;
  assert_true(count[0] == 5 && count[1] > 10 && count[2] > 30 && count[3] == 30 && count[4] == 20);
  assert_int_equal(m->n_rains, 2);
  assert_int_equal(m->rains[1].first, m->rains[0].first + 30);
  sd_model_free(m);
}

static void test_rain(void **state) {
  sd_model *m =
      good(HEAD HOPPER "packings = ( { type = \"rain\"; count = 400; rows = 3; speed = 2; " MONO
                       " } );");
  const sd_rain *r = &m->rains[0];
  assert_true(r->first == 0 && r->count == 400);
  assert_true(r->batch >= 3 * 16 && r->batch <= 3 * 20);
  assert_true(r->lower == -5 && r->upper == 5 && r->gap == 0.25 && r->speed == 2);
  near_to(r->floor, 4, "where the hopper is as wide as the rain");
  /* 2 t + 10 t^2/2 = 1.5 */
  double t = (-2 + sqrt(4 + 4 * 5 * 1.5)) / 10;
  assert_int_equal(r->interval, (int64_t)ceil(t / 1e-3));
  for (size_t i = 0; i < 400; i++) {
    const sd_disk *d = &m->disks[i];
    assert_true(d->waiting && d->position[1] - d->radius > 12 &&
                fabs(d->position[0]) < 5 - d->radius);
    assert_true(d->velocity[0] == 0 && d->velocity[1] == 0);
  }
  check_clear(m);
  sd_model_free(m);
  m = good(HEAD BOX "packings = ( { type = \"rain\"; count = 5; interval = 0.0315; gap = 1; " MONO
                    " } );");
  assert_true(m->rains[0].interval == 32 && m->rains[0].batch == 5 && m->rains[0].gap == 1);
  sd_model_free(m);
}

static bool same_disks(const sd_model *a, const sd_model *b) {
  if (a->n_disks != b->n_disks) return false;
  for (size_t i = 0; i < a->n_disks; i++) {
    const sd_disk *p = &a->disks[i], *q = &b->disks[i];
    if (p->position[0] != q->position[0] || p->position[1] != q->position[1] ||
        p->position[2] != q->position[2] || p->radius != q->radius || p->mass != q->mass ||
        p->inertia != q->inertia || p->group != q->group || p->waiting != q->waiting ||
        p->driven != q->driven)
      return false;
  }
  return true;
}

/* One of each, with sizes of each kind; two alike. */
static const char *const mixed = HEAD
    "container = { type = \"bed\"; width = 10; height = 20; radius = 0.3; };\n"
    "packings = ( { type = \"triangular\"; y = (0, 2); jitter = 0.5; sizes = \"uniform\"; lower "
    "= 0.2; upper = 0.3; density = 1; },"
    "  { type = \"square\"; y = (2, 4); jitter = 0.5; sizes = \"gaussian\"; radius = 0.25; "
    "deviation = 0.02; mass = 1; },"
    "  { type = \"random\"; y = (4, 8); fraction = 0.3; sizes = \"lognormal\"; radius = 0.25; "
    "deviation = 0.2; density = 1; },"
    "  { type = \"random\"; y = (8, 12); fraction = 0.3; sizes = \"lognormal\"; radius = 0.25; "
    "deviation = 0.2; density = 1; },"
    "  { type = \"front\"; y = (12, 16); sizes = \"powerlaw\"; exponent = 2.2; lower = 0.1; "
    "upper = 0.4; density = 1; },"
    "  { type = \"rain\"; count = 40; y = (16, 20); sizes = \"list\"; radii = (0.1, 0.2, 0.3); "
    "weights = (3, 2, 1); density = 1; } );\n";

static void test_echo(void **state) {
  sd_model *m = good(mixed), *again = good(sd_model_deck(m)->full);
  assert_true(same_disks(m, again));
  assert_int_equal(again->n_rains, 1);
  assert_memory_equal(m->rains, again->rains, sizeof *m->rains);
  /* the groups are still there, with their defaults, and the second echo is the first */
  assert_non_null(strstr(sd_model_deck(m)->full, "container = { type = \"bed\";"));
  assert_non_null(strstr(sd_model_deck(m)->full, "spacing = 0.6;"));
  assert_non_null(strstr(sd_model_deck(m)->full, "gap = 0.3;"));
  assert_null(strstr(sd_model_deck(m)->full, "disk_rows"));
  sd_model *third = good(sd_model_deck(again)->full);
  assert_true(same_disks(m, third));
  assert_string_equal(sd_model_deck(again)->full, sd_model_deck(third)->full);
  sd_model_free(third);
  sd_model_free(again);
  sd_model_free(m);
}

static void test_seed(void **state) {
  sd_model *m = good(mixed), *same = load(mixed, "seed=1", NULL),
           *other = load(mixed, "seed=2", NULL);
  assert_non_null(same);
  assert_non_null(other);
  assert_true(same_disks(m, same));
  assert_false(same_disks(m, other));
  sd_model_free(same);
  sd_model_free(other);
  sd_model_free(m);
  /* two packings that say the same differ: their numbers are part of the seed */
  m = good(HEAD BOX "packings = ( { type = \"random\"; count = 50; sizes = \"uniform\"; lower = "
                    "0.1; upper = 0.2; mass = 1; },"
                    "{ type = \"random\"; count = 50; sizes = \"uniform\"; lower = 0.1; upper = "
                    "0.2; mass = 1; } );");
  assert_true(m->disks[0].radius != m->disks[50].radius);
  sd_model_free(m);
}

/* Setting one of two keys that exclude each other takes the other away. */
static void test_overrides(void **state) {
  const char *text =
      HEAD BOX "packings = ( { type = \"random\"; count = 10; " MONO " } );"
               "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; "
               "amplitude = 0.1; omega = 2; } );";
  sd_model *m = load(text, "packings[0].fraction=0.2", "packings[0].mass=7");
  assert_non_null(m);
  assert_int_equal(m->n_disks, 81); /* 0.2 * 80/(pi/16) */
  assert_true(m->disks[0].mass == 7);
  sd_model_free(m);
  m = load(text, "packings[0].count=12", "motions[0].acceleration=2");
  assert_non_null(m);
  assert_int_equal(m->n_disks, 12);
  near_to(m->motions[0].amplitude, 2 * 10 / 4.0, "amplitude");
  sd_model_free(m);
}

#define CONTAINER(keys) HEAD ONE "container = { " keys " };\n"

static void test_container_mistakes(void **state) {
  refused(HEAD ONE BOX "box = { x = (0, 1); };",
          "box.x = (0, 1): given together with container \"box\", which has its own edges");
  refused(
      CONTAINER(
          "type = \"channel\"; width = 10; height = 8;") "box = { periodic = \"y\"; y = (0, 8); };",
      "box.y = (0, 8): given together with container \"channel\", which has its own edges\n"
      "box.periodic = \"y\": given together with container \"channel\", which is periodic in x");
  refused(CONTAINER("type = \"bag\"; width = 10;"),
          "container.type = \"bag\": expected one of \"box\", \"channel\", \"bed\", \"hopper\", "
          "\"drum\", \"polygon\", \"periodic\"; did you mean \"box\"?");
  refused(CONTAINER("type = \"box\"; width = 10;"),
          "container.height: missing: type \"box\" needs it (inner height)");
  refused(CONTAINER("type = \"box\"; width = 10; height = -1;"),
          "container.height = -1: expected a number > 0");
  refused(CONTAINER("type = \"drum\"; radius = 5; width = 10;"),
          "container.width = 10: does not belong to type \"drum\"");
  refused(CONTAINER("type = \"hopper\"; width = 10; height = 12; outlet = 11; angle = 1;"),
          "container.outlet = 11: expected less than the width, 10");
  refused(
      CONTAINER("type = \"hopper\"; width = 10; height = 12; outlet = 2; angle = \"pi/2\";"),
      "container.angle = \"pi/2\": expected an inclination from 0 to 1.5, less than a right angle");
  refused(CONTAINER("type = \"hopper\"; width = 10; height = 4; outlet = 2; angle = \"45 deg\";"),
          "container.height = 4: the inclined walls alone are 4 high; expected more");
  refused(CONTAINER("type = \"polygon\"; radius = 4; sides = 2;"),
          "container.sides = 2: expected from 3 to 64");
  refused(CONTAINER("type = \"bed\"; width = 10; height = 8; radius = 1e-9;"),
          "container.spacing: the floor would have 5e+09 disks; expected 1e6 at most");
  refused(CONTAINER("type = \"box\"; width = 10; height = 8; material = \"steel\";"),
          "container.material = \"steel\": no material is called that; there is \"m\"");
  refused(HEAD ONE BOX
          "walls = ( { name = \"left\"; type = \"line\"; points = ((0, 0), (1, 0)); } );",
          "container.type = \"box\": it has a wall \"left\", but a wall or a disk of the deck is "
          "called so");
  refused(HEAD ONE BOX "disks = ( { name = \"floor\"; x = 0; y = 6; radius = 1; mass = 1; } );",
          "container.type = \"box\": it has a wall \"floor\", but a wall or a disk of the deck is "
          "called so");
  refused(CONTAINER("type = \"bed\"; width = 10; height = 8; radius = 0.3;") "disks = ( { x = 0; y "
                                                                             "= 4; radius = 0.3; "
                                                                             "mass = 1; group = "
                                                                             "\"floor\"; } );",
          "container.type = \"bed\": its floor is the group \"floor\", but the deck has disks in "
          "this group");
}

#define PACKING(keys) "packings = ( { " keys " } );\n"
#define RANDOM(keys) HEAD BOX PACKING("type = \"random\"; count = 9; density = 1; " keys)

static void test_what_cannot_fit(void **state) {
  refused(
      HEAD BOX PACKING("type = \"random\"; count = 1000; " MONO),
      "packings[0]: 1000 disks of area 196.35 in all in a region of area 80: a packing fraction "
      "of 2.454; expected at most 0.9069");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 0.95; " MONO),
          "packings[0].fraction = 0.95: more than the densest packing of equal disks has; "
          "expected at most 0.9069");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 1.5; " MONO),
          "packings[0].fraction = 1.5: expected a number > 0 and <= 1");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 1e-4; " MONO),
          "packings[0].fraction = 0.0001: less than one disk in a region of area 80");
  refused(HEAD BOX PACKING("type = \"square\"; count = 321; " MONO),
          "packings[0].count = 321: the lattice has 320 free sites only");
  refused(HEAD BOX PACKING("type = \"square\"; y = (0, 1); x = (0, 1); radius = 0.6; mass = 1;"),
          "packings[0]: a disk of radius 0.6 does not fit into a region that is 1 wide\n"
          "packings[0]: a disk of radius 0.6 does not fit into a region that is 1 high");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 1e-6; radius = 1e-7; mass = 1;"),
          "packings[0].spacing = 1e-06: the lattice has about 9.23761e+13 sites; expected at most "
          "200000000");
  refused(HEAD BOX PACKING("type = \"square\"; count = 3; spacing = 9; " MONO),
          "packings[0]: the lattice has no free site in the region");
  refused(HEAD BOX PACKING("type = \"random\"; count = 1000000000; radius = 1e-6; mass = 1;"),
          "packings[0]: 1e+09 disks; expected at most 200000000");
  refused(
      HEAD BOX PACKING("type = \"rain\"; count = 400; " MONO),
      "packings[0]: 400 disks of area 78.5398 in all in a region of area 80: a packing fraction "
      "of 0.9817; expected at most 0.9069");
  refused(HEAD BOX "disks = ( { x = 0; y = 4; radius = 3.9; mass = 1; } );" PACKING(
              "type = \"front\"; x = (-1, 1); y = (3, 5); " MONO),
          "packings[0]: the front found no place for a disk in the region");
}

/* The numbers in these messages follow from the generators. */
static void test_generators_that_end(void **state) {
  size_t placed, all;
  double fraction, asked;
  assert_null(load(HEAD BOX PACKING("type = \"random\"; fraction = 0.6; " MONO), NULL, NULL));
  assert_int_equal(sscanf(sd_messages_text(messages, 0),
                          "test.cfg:%*d: packings[0].fraction = 0.6: random placement found no "
                          "room for more than %zu of %zu disks, a fraction of %lf of the region "
                          "where %lf was asked for; expected less, or type \"front\"",
                          &placed, &all, &fraction, &asked),
                   4);
  assert_int_equal(all, 244); /* 0.6 * 80/(pi/16) */
  assert_true(fabs(fraction - placed * M_PI / 16 / 80) < 5e-4 &&
              fabs(asked - all * M_PI / 16 / 80) < 5e-4);
  assert_true(fraction > 0.46 && fraction < 0.55);
  assert_null(load(HEAD BOX PACKING("type = \"front\"; count = 360; " MONO), NULL, NULL));
  assert_int_equal(sscanf(sd_messages_text(messages, 0),
                          "test.cfg:%*d: packings[0].count = 360: the front has filled the "
                          "region with %zu disks, a fraction of %lf",
                          &placed, &fraction),
                   2);
  assert_true(fabs(fraction - placed * M_PI / 16 / 80) < 5e-4 && fraction > 0.78);
}

static void test_region_mistakes(void **state) {
  refused(HEAD PACKING("type = \"random\"; count = 3; x = (0, 1); " MONO),
          "packings[0].y: missing: expected (lower, upper), since no container and no box gives "
          "edges in y");
  refused(RANDOM("radius = 0.1; x = (1, 0);"),
          "packings[0].x = (1, 0): expected (lower, upper) with lower < upper");
  refused(RANDOM("radius = 0.1; x = (-6, 0);"),
          "packings[0].x = (-6, 0): reaches beyond the container, from -5 to 5");
  refused(RANDOM("radius = 0.1; y = (-1, 2);"),
          "packings[0].y = (-1, 2): reaches beyond the container, from 0 to 8");
  refused(HEAD "container = { type = \"box\"; width = 10; height = 8; open = false; };" PACKING(
              "type = \"random\"; count = 3; y = (0, 9); " MONO),
          "packings[0].y = (0, 9): reaches beyond the container, from 0 to 8");
  refused(HEAD PERIODIC PACKING("type = \"random\"; count = 3; x = (9, 11); " MONO),
          "packings[0].x = (9, 11): reaches beyond the periodic box, from 0 to 10");
  refused(HEAD DRUM PACKING(
              "type = \"random\"; count = 3; x = (4.9, 5); y = (4.9, 5); radius = 0.01; mass = 1;"),
          "packings[0]: its region lies outside the container");
  /* over the open top of a box there is room; edges of a box without walls do, too */
  sd_model_free(good(RANDOM("radius = 0.1; y = (0, 20);")));
  sd_model_free(good(
      HEAD "box = { x = (0, 4); y = (0, 4); };" PACKING("type = \"random\"; count = 3; " MONO)));
  /* a container with mistakes does not lead to more of them */
  refused(HEAD "container = { type = \"box\"; width = 10; height = 0; };" PACKING(
              "type = \"random\"; count = 3; " MONO),
          "container.height = 0: expected a number > 0");
}

static void test_size_mistakes(void **state) {
  refused(RANDOM(""), "packings[0].radius: missing: sizes \"mono\" needs it (radius; gaussian: "
                      "mean; lognormal: median)");
  refused(RANDOM("sizes = \"mono\"; radius = 1; lower = 1;"),
          "packings[0].lower = 1: does not belong to sizes \"mono\"");
  refused(RANDOM("sizes = \"normal\"; radius = 1;"),
          "packings[0].sizes = \"normal\": expected one of \"mono\", \"list\", \"uniform\", "
          "\"gaussian\", \"lognormal\", \"powerlaw\"; did you mean \"gaussian\"?");
  refused(RANDOM("sizes = \"uniform\"; lower = 0.3; upper = 0.2;"),
          "packings[0].upper = 0.2: expected more than lower, 0.3");
  refused(RANDOM("sizes = \"powerlaw\"; exponent = 2; lower = 0.2; upper = 0.2;"),
          "packings[0].upper = 0.2: expected more than lower, 0.2");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.01; lower = 0.3;"),
          "packings[0].lower = 0.3: expected less than upper, 0.23");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.1;"),
          "packings[0].lower: missing: 3 deviations below the mean is -0.1; expected a radius > 0");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = -0.1;"),
          "packings[0].deviation = -0.1: expected a number > 0");
  refused(
      RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.01; lower = 0.3; upper = 0.4;"),
      "packings[0].lower = 0.3: only 7.61985e-24 of the distribution lies between lower and upper");
  refused(RANDOM("sizes = \"list\"; radii = ();"),
          "packings[0].radii = (): expected a list of numbers > 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, -0.2);"),
          "packings[0].radii[1] = -0.2: expected a number > 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, \"b\");"),
          "packings[0].radii[1] = \"b\": expected a number; no constant is called \"b\"");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (1, 2, 3);"),
          "packings[0].weights = (1, 2, 3): 3 weights for 2 radii; expected one for each");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (1, -2);"),
          "packings[0].weights[1] = -2: expected a number >= 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (0, 0);"),
          "packings[0].weights = (0, 0): all are 0");
}

static void test_packing_mistakes(void **state) {
  refused(HEAD BOX PACKING("type = \"random\"; " MONO),
          "packings[0].count/fraction: missing: type \"random\" needs it (number of disks)");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; fraction = 0.2; " MONO),
          "packings[0].fraction = 0.2: given together with count; expected one of them");
  refused(HEAD BOX PACKING("type = \"random\"; count = 0; " MONO),
          "packings[0].count = 0: expected a whole number >= 1");
  refused(HEAD BOX PACKING("type = \"front\"; jitter = 0.5; " MONO),
          "packings[0].jitter = 0.5: does not belong to type \"front\"");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; radius = 0.1;"),
          "packings[0].mass: missing: expected mass or density > 0");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; mass = 1; " MONO),
          "packings[0].density = 2: given together with mass; expected one of them");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; material = \"n\"; " MONO),
          "packings[0].material = \"n\": no material is called that; there is \"m\"");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 0.49; " MONO),
          "packings[0].spacing = 0.49: expected at least the largest diameter, 0.5");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 0.6; jitter = 1.1; " MONO),
          "packings[0].jitter = 1.1: expected at most 1; beyond it disks could overlap");
}

static void test_tile_mistakes(void **state) {
  refused(HEAD BOX PACKING("type = \"front\"; tiles = 2; " MONO),
          "packings[0].count: missing: expected the number of disks, which tiles share");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 0.2; tiles = 2; " MONO),
          "packings[0].count: missing: expected the number of disks, which tiles share");
  refused(HEAD BOX PACKING("type = \"front\"; count = 3; tiles = 4; " MONO),
          "packings[0].tiles = 4: expected at most one for each of the 3 disks");
  refused(HEAD BOX PACKING("type = \"front\"; count = 50; tiles = 30; " MONO),
          "packings[0].tiles = 30: each is 0.333333 wide; expected fewer, so that a disk of "
          "radius 0.25 fits between their edges");
  refused(HEAD BOX PACKING("type = \"rain\"; count = 50; tiles = 51; " MONO),
          "packings[0].tiles = 51: expected at most one for each of the 50 disks");
  refused(HEAD BOX PACKING("type = \"square\"; count = 50; tiles = 2; jitter = 1.1; " MONO),
          "packings[0].jitter = 1.1: expected at most 1; beyond it disks could overlap");
  refused(HEAD BOX PACKING("type = \"square\"; count = 20; tiles = 3; y = (0, 0.6); " MONO),
          "packings[0].count = 20: tile 0 of 3 holds 6 disks only, where 7 were asked for; "
          "expected fewer disks or a larger region");
}

static void test_rain_mistakes(void **state) {
#define RAIN(keys) PACKING("type = \"rain\"; count = 9; " keys MONO)
  refused(HEAD BOX PACKING("type = \"rain\"; " MONO),
          "packings[0].count: missing: type \"rain\" needs it (number of disks)");
  refused(HEAD BOX RAIN("rows = 0; "), "packings[0].rows = 0: expected a whole number >= 1");
  refused(HEAD PERIODIC RAIN(""), "packings[0]: rain cannot fall in a box that is periodic in y");
  refused(HEAD DRUM RAIN(""),
          "packings[0]: rain needs x and y, a rectangle that lies inside the container");
  refused(HEAD DRUM RAIN("x = (-2, 2); y = (0, 1.5); "),
          "packings[0].rows: a batch is 2 high, the region only 1.5");
  refused("dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );" BOX RAIN(""),
          "packings[0]: nothing falls; expected gravity that points down (g > 0), or a speed > 0");
  sd_model_free(good("dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );" BOX RAIN(
      "speed = 1; ")));
}

RUN_TESTS_BETWEEN(NULL, tear_down, TEST(test_box), TEST(test_bed_and_channel), TEST(test_hopper),
                  TEST(test_drum_and_periodic), TEST(test_container_material), TEST(test_all_types),
                  TEST(test_fraction), TEST(test_several), TEST(test_rain), TEST(test_echo),
                  TEST(test_seed), TEST(test_overrides), TEST(test_container_mistakes),
                  TEST(test_what_cannot_fit), TEST(test_generators_that_end),
                  TEST(test_region_mistakes), TEST(test_size_mistakes), TEST(test_packing_mistakes),
                  TEST(test_rain_mistakes), TEST(test_tile_mistakes))
