/* Configurations with closed forms: lattices under known overlaps, a disk between walls, radical cells, rattlers, areas of
 * cut disks. Frames of runs as configurations: contacts against the engine's own forces, contacts that are found again,
 * disks that are not there. */
#include "base/memory.h"
#include "brief.h"
#include "deck_runs.h"
#include "measure/cells.h"
#include "measure/correlation.h"
#include "measure/stress.h"
#include "system.h"

static const sd_contact_law LAW = {.k_n = 1000.0, .k_t = 500.0, .gamma_n = 1.0, .mu = 0.3};

/* A frame of the model's own start. */
static configuration at_start(const sd_model *m) {
  frame_data f;
  configuration c;
  sd_messages *messages = sd_messages_new();
  assert_int_equal(frame_data_new(&f, m->n_disks, m->n_walls, messages), SD_OK);
  for (size_t i = 0; i < m->n_disks; i++)
    for (int k = 0; k < 2; k++) {
      f.position[i][k] = m->disks[i].position[k];
      f.velocity[i][k] = m->disks[i].velocity[k];
    }
  for (size_t w = 0; w < m->n_walls; w++)
    for (int k = 0; k < 2; k++) f.position[m->n_disks + w][k] = m->walls[w].pivot[k];
  sd_status status = configuration_new(&c, m, &f, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  sd_messages_free(messages);
  frame_data_free(&f);
  return c;
}

static stress stress_of(const configuration *c, const region *g) {
  stress s;
  assert_int_equal(stress_new(&s, c, g, NULL), SD_OK);
  return s;
}

static cells cells_of(const configuration *c, const region *counted) {
  cells t;
  region whole = configuration_region(c, NULL);
  sd_messages *messages = sd_messages_new();
  sd_status status = cells_new(&t, c, &whole, counted ? counted : &whole, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  sd_messages_free(messages);
  return t;
}

static void periodic(sd_model *m, double x, double y, double width, double height) {
  const double low[2] = {x, y}, size[2] = {width, height};
  for (int k = 0; k < 2; k++) {
    m->periodic[k] = true;
    m->lower[k] = m->region_lower[k] = low[k];
    m->upper[k] = m->region_upper[k] = low[k] + size[k];
  }
}

enum { COLUMNS = 12, ROWS = 14 };

/* Spacing a, every other row shifted: triangular when rows are a sqrt(3)/2 apart. */
static sd_model *lattice(double a, double row, double shift, double radius) {
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
  for (int j = 0; j < ROWS; j++)
    for (int i = 0; i < COLUMNS; i++)
      system_disk(m, a * (i + (j % 2 ? shift : 0.0) + 0.3), row * (j + 0.4), radius, 1.0);
  periodic(m, 0.0, 0.0, a * COLUMNS, row * ROWS);
  return m;
}

/* Disks in the shell about r, from g(r). */
static double shell(const correlation *t, double r, double width) {
  double n = (double)t->n_disks, sum = 0.0;
  for (size_t k = 0; k < t->pairs->n; k++) {
    double low = t->pairs->range[k], high = t->pairs->range[k + 1];
    if (low < r + width && high > r - width)
      sum += t->pairs->bin[k] * t->density * (n - 1.0) / n * M_PI * (high * high - low * low);
  }
  return sum;
}

static void check_lattice(double row, double shift, double contacts, double pressure,
                          double fraction, const double (*shells)[2], size_t n_shells) {
  const double radius = 0.5, overlap = 1e-3, a = 2.0 * radius - overlap, force = LAW.k_n * overlap;
  sd_model *m = lattice(a, a * row, shift, radius);
  configuration c = at_start(m);
  assert_true(c.recomputed);
  region g = configuration_region(&c, NULL);
  stress s = stress_of(&c, &g);
  SYSTEM_NEAR(s.z, contacts, 0.0, "z");
  SYSTEM_NEAR(s.z_backbone, contacts, 0.0, "z without rattlers");
  assert_int_equal(s.rattlers, 0);
  SYSTEM_NEAR(s.fraction, fraction * 4.0 * radius * radius / (a * a), 1e-13, "packing fraction");
  SYSTEM_NEAR(s.contact_principal.mean, pressure * force / a, 1e-10 * force, "pressure");
  SYSTEM_NEAR(s.contact_principal.deviator, 0.0, 1e-10 * force, "deviator");
  SYSTEM_NEAR(s.fabric[STRESS_XX], 0.5, 1e-13, "fabric xx");
  SYSTEM_NEAR(s.fabric[STRESS_XY], 0.0, 1e-13, "fabric xy");
  SYSTEM_NEAR(s.anisotropy, 0.0, 1e-12, "anisotropy");
  SYSTEM_NEAR(s.overlap_max, overlap, 1e-14, "overlap");
  SYSTEM_NEAR(s.mean_force, force, 1e-11 * force, "mean force");

  cells t = cells_of(&c, NULL);
  assert_int_equal(t.n_closed, m->n_disks);
  for (size_t i = 0; i < t.n; i++) {
    SYSTEM_NEAR(t.area[i], a * a * row, 1e-12, "cell %zu", i);
    SYSTEM_NEAR(s.virial[i] / (2.0 * t.area[i]), pressure * force / a, 1e-9 * force,
                "pressure of disk %zu", i);
  }
  SYSTEM_NEAR(t.deviation, 0.0, 1e-12, "spread of the local fraction");
  SYSTEM_NEAR(t.inside, s.fraction, 1e-12, "fraction inside");

  correlation q;
  assert_int_equal(correlation_new(&q, &c, &g, 200, NULL), SD_OK);
  for (size_t k = 0; k < n_shells; k++)
    SYSTEM_NEAR(shell(&q, a * shells[k][0], 0.08 * a), shells[k][1], 1e-9, "neighbours at %g a",
                shells[k][0]);
  SYSTEM_NEAR(shell(&q, 0.5 * a, 0.4 * a), 0.0, 0.0, "neighbours nearer than a");
  SYSTEM_NEAR(q.normal.mean, force, 1e-11 * force, "mean of P(f)");
  SYSTEM_NEAR(q.normal.deviation, 0.0, 1e-11, "spread of P(f)");
  assert_int_equal(q.tangential.n, 0);
  correlation_free(&q);
  cells_free(&t);
  stress_free(&s);
  configuration_free(&c);
  sd_model_free(m);
}

static void test_triangular(void **state) {
  /* 3 contacts per disk, each F a in stress; cell a^2 sqrt(3)/2 */
  static const double shells[][2] = {{1.0, 6}, {1.7320508, 6}, {2.0, 6}, {2.6457513, 12}};
  check_lattice(0.5 * sqrt(3.0), 0.5, 6.0, sqrt(3.0), M_PI / (2.0 * sqrt(3.0)), shells, 4);
}

static void test_square(void **state) {
  static const double shells[][2] = {{1.0, 4}, {1.4142136, 4}, {2.0, 4}, {2.2360680, 8}};
  check_lattice(1.0, 0.0, 4.0, 1.0, M_PI / 4.0, shells, 4);
}

/* A part of a lattice, across the edge of the periodic box: the same stress and packing fraction. */
static void test_part_of_lattice(void **state) {
  const double radius = 0.5, a = 2.0 * radius - 1e-3;
  sd_model *m = lattice(a, a, 0.0, radius);
  configuration c = at_start(m);
  const double wanted[4] = {-2.0 * a, 3.0 * a, 2.7 * a, 6.7 * a};
  region g = configuration_region(&c, wanted);
  stress s = stress_of(&c, &g);
  SYSTEM_NEAR(s.fraction, M_PI / 4.0 / (a * a), 1e-12, "packing fraction");
  SYSTEM_NEAR(s.contact[STRESS_XX], LAW.k_n * 1e-3 / a, 1e-10, "stress xx");
  SYSTEM_NEAR(s.contact[STRESS_YY], LAW.k_n * 1e-3 / a, 1e-10, "stress yy");
  assert_int_equal(s.free, 20);
  stress_free(&s);
  configuration_free(&c);
  sd_model_free(m);
}

static void test_disk_between_walls(void **state) {
  const double overlap = 1e-3, radius = 0.5, half = radius - overlap, width = 3.0;
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
  system_disk(m, 0.2, 0.0, radius, 1.0);
  const double low[2][2] = {{-1, -half}, {1, -half}}, high[2][2] = {{-1, half}, {1, half}};
  system_straight(m, SD_WALL_LINE, 2, low);
  system_straight(m, SD_WALL_SEGMENT, 2, high);
  m->region_lower[0] = -0.5 * width, m->region_upper[0] = 0.5 * width;
  m->region_lower[1] = -half, m->region_upper[1] = half;
  configuration c = at_start(m);
  region g = configuration_region(&c, NULL);
  stress s = stress_of(&c, &g);
  assert_int_equal(s.n_contacts, 2);
  assert_int_equal(s.n_wall, 2);
  SYSTEM_NEAR(s.z, 2.0, 0.0, "z");
  assert_int_equal(s.rattlers, 0);
  /* the force on each wall, over its length */
  SYSTEM_NEAR(s.contact[STRESS_YY], LAW.k_n * overlap / width, 1e-12, "stress yy");
  SYSTEM_NEAR(s.contact[STRESS_XX], 0.0, 1e-15, "stress xx");
  SYSTEM_NEAR(s.contact_principal.angle, 0.5 * M_PI, 1e-12, "angle");
  SYSTEM_NEAR(s.anisotropy, 2.0, 1e-12, "anisotropy: all along one direction");
  SYSTEM_NEAR(s.fabric_angle, 0.5 * M_PI, 1e-12, "its direction");
  /* what the two walls cut off is a segment of height overlap each */
  double angle = 2.0 * acos(half / radius), segment = 0.5 * radius * radius * (angle - sin(angle));
  SYSTEM_NEAR(s.fraction, (M_PI * radius * radius - 2.0 * segment) / (width * 2.0 * half), 1e-14,
              "fraction");
  stress_free(&s);
  configuration_free(&c);
  sd_model_free(m);
}

/* A square lattice that fills a box with walls has square cells; without a lid the upper row is open. */
static void test_cells_at_walls(void **state) {
  for (int lid = 0; lid < 2; lid++) {
    sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
    for (int row = 0; row < 5; row++)
      for (int k = 0; k < 5; k++) system_disk(m, 0.5 + k, 0.5 + row, 0.5, 1.0);
    const double lines[4][2][2] = {
        {{0, 0}, {1, 0}}, {{0, 0}, {0, 1}}, {{5, 0}, {5, 1}}, {{0, 5}, {1, 5}}};
    for (int w = 0; w < 3 + lid; w++) system_straight(m, SD_WALL_LINE, 2, lines[w]);
    m->region_upper[0] = 5.0;
    m->region_upper[1] = lid ? 5.0 : 9.0;
    configuration c = at_start(m);
    cells t = cells_of(&c, NULL);
    assert_int_equal(t.n_closed, lid ? 25 : 20);
    for (size_t i = 0; i < 25; i++) {
      assert_int_equal(t.closed[i], lid || i < 20);
      SYSTEM_NEAR(t.area[i], t.closed[i] ? 1.0 : 5.0, 1e-12, "cell %zu", i);
    }
    SYSTEM_NEAR(t.inside, M_PI / 4.0, 1e-12, "fraction inside");
    cells_free(&t);
    configuration_free(&c);
    sd_model_free(m);
  }
}

/* The same in a box that stands askew. */
static void test_cells_at_inclined_walls(void **state) {
  const double cosine = cos(0.5), sine = sin(0.5);
  const double corners[4][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3}};
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
  for (int k = 0; k < 9; k++) {
    const double x = 0.5 + k % 3, y = 0.5 + k / 3;
    system_disk(m, cosine * x - sine * y, sine * x + cosine * y, 0.5, 1.0);
  }
  for (int w = 0; w < 4; w++) {
    double ends[2][2];
    for (int end = 0; end < 2; end++) {
      const double *p = corners[(w + end) % 4];
      ends[end][0] = cosine * p[0] - sine * p[1];
      ends[end][1] = sine * p[0] + cosine * p[1];
    }
    system_straight(m, w % 2 ? SD_WALL_SEGMENT : SD_WALL_LINE, 2, (const double(*)[2])ends);
  }
  for (int k = 0; k < 2; k++) m->region_lower[k] = -9, m->region_upper[k] = 9;
  configuration c = at_start(m);
  cells t = cells_of(&c, NULL);
  assert_int_equal(t.n_closed, 9);
  for (size_t i = 0; i < 9; i++) SYSTEM_NEAR(t.area[i], 1.0, 1e-12, "cell %zu", i);
  cells_free(&t);
  configuration_free(&c);
  sd_model_free(m);
}

/* One disk in the middle of a drum, and six about one. */
static void test_cells_in_drum(void **state) {
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
  m->container = SD_CONTAINER_DRUM;
  system_disk(m, 1.0, 2.0, 0.5, 1.0);
  for (int k = 0; k < 6; k++)
    system_disk(m, 1.0 + cos(k * M_PI / 3), 2.0 + sin(k * M_PI / 3), 0.5, 1.0);
  size_t drum = system_circle(m, 1.0, 2.0, 1.5, true);
  m->walls[drum].name = memory_text("drum");
  for (int k = 0; k < 2; k++) m->region_lower[k] = k - 0.5, m->region_upper[k] = k + 2.5;
  configuration c = at_start(m);
  region g = configuration_region(&c, NULL);
  assert_true(g.outline.radius == 1.5);
  stress s = stress_of(&c, &g);
  SYSTEM_NEAR(s.fraction, 7.0 / 9.0, 1e-12, "packing fraction");
  cells t = cells_of(&c, NULL);
  double inner = 0.5 * sqrt(3.0); /* a hexagon whose edges are 1/2 from its centre */
  assert_int_equal(t.n_closed, 7);
  SYSTEM_NEAR(t.area[0], inner, 1e-12, "inner cell");
  for (size_t i = 1; i < 7; i++)
    SYSTEM_NEAR(t.area[i], (M_PI * 2.25 - inner) / 6.0, 1e-12, "outer cell");
  cells_free(&t);
  stress_free(&s);
  configuration_free(&c);
  sd_model_free(m);
}

static sd_model *scattered(int n, double width, double height, uint64_t seed) {
  sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
  for (int k = 0; k < n; k++)
    system_disk(m, -1.0 + width * next_uniform(&seed), 2.0 + height * next_uniform(&seed),
                0.02 + 0.08 * next_uniform(&seed), 1.0);
  periodic(m, -1.0, 2.0, width, height);
  return m;
}

/* Area of the points that are nearest to disk i in power distance, by cutting with every disk and image. */
static double cell_by_force(const sd_model *m, size_t i) {
  enum { MOST = 400 };
  static double at[2][MOST][2];
  double length[2] = {m->upper[0] - m->lower[0], m->upper[1] - m->lower[1]};
  size_t n = 4, from = 0;
  for (int k = 0; k < 4; k++) {
    at[0][k][0] = (k == 1 || k == 2) ? length[0] : -length[0];
    at[0][k][1] = k >= 2 ? length[1] : -length[1];
  }
  for (size_t j = 0; j < m->n_disks; j++)
    for (int image = 0; image < 25; image++) {
      int across = image % 5 - 2, up = image / 5 - 2;
      double x = m->disks[j].position[0] - m->disks[i].position[0] + across * length[0];
      double y = m->disks[j].position[1] - m->disks[i].position[1] + up * length[1];
      if (x == 0.0 && y == 0.0) continue;
      double r = m->disks[i].radius, s = m->disks[j].radius,
             d = 0.5 * (x * x + y * y + r * r - s * s);
      size_t kept = 0, to = 1 - from;
      for (size_t k = 0; k < n; k++) {
        const double *p = at[from][k], *q = at[from][(k + 1) % n];
        double dp = x * p[0] + y * p[1] - d, dq = x * q[0] + y * q[1] - d, t = dp / (dp - dq);
        if (dp <= 0.0) memcpy(at[to][kept++], p, sizeof at[0][0]);
        if ((dp <= 0.0) == (dq <= 0.0)) continue;
        at[to][kept][0] = p[0] + t * (q[0] - p[0]);
        at[to][kept++][1] = p[1] + t * (q[1] - p[1]);
        assert_true(kept < MOST - 2);
      }
      n = kept;
      from = to;
    }
  double twice = 0.0;
  for (size_t k = 0; k < n; k++) {
    const double *p = at[from][k], *q = at[from][(k + 1) % n];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return 0.5 * twice;
}

static void test_radical_cells(void **state) {
  for (uint64_t seed = 1; seed <= 6; seed++) {
    sd_model *m = scattered(seed == 6 ? 3 : 60, 1.0, seed % 2 ? 1.0 : 3.0, seed);
    configuration c = at_start(m);
    cells t = cells_of(&c, NULL);
    for (size_t i = 0; i < m->n_disks; i++) {
      double area = cell_by_force(m, i);
      if (area > 0.0)
        SYSTEM_NEAR(t.area[i], area, 1e-12, "seed %d, cell %zu", (int)seed, i);
      else
        assert_true(isnan(t.area[i]));
    }
    double box = (m->upper[0] - m->lower[0]) * (m->upper[1] - m->lower[1]);
    SYSTEM_NEAR(t.total, box, 1e-12 * box, "all cells");
    cells_free(&t);
    configuration_free(&c);
    sd_model_free(m);
  }
}

static void test_many_radical_cells(void **state) {
  sd_model *m = scattered(BRIEF(20000, 2000), 7.0, 11.0, 9);
  configuration c = at_start(m);
  cells t = cells_of(&c, NULL);
  SYSTEM_NEAR(t.total, 77.0, 77.0 * 1e-12, "all cells");
  cells_free(&t);
  configuration_free(&c);
  sd_model_free(m);
}

/* Disks on one line, and a single one, have cells, too: nothing that spans a plane. */
static void test_flat_cells(void **state) {
  for (int n = 1; n <= 5; n += 4) {
    sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, LAW);
    for (int k = 0; k < n; k++) system_disk(m, k, 0.0, 0.5, 1.0);
    m->region_lower[0] = -0.5, m->region_upper[0] = n - 0.5;
    m->region_lower[1] = -2.0, m->region_upper[1] = 2.0;
    configuration c = at_start(m);
    cells t = cells_of(&c, NULL);
    for (int k = 0; k < n; k++) SYSTEM_NEAR(t.area[k], 4.0, 1e-12, "cell %d of %d", k, n);
    assert_int_equal(t.n_closed, 0);
    cells_free(&t);
    configuration_free(&c);
    sd_model_free(m);
  }
}

/* Points without correlation: g = 1, also near the edges of an open window. */
static void test_ideal_pairs(void **state) {
  for (int open = 0; open < 2; open++) {
    sd_model *m = scattered(4000, 10.0, 10.0, 5);
    for (size_t i = 0; i < m->n_disks; i++) m->disks[i].radius = 0.05;
    if (open) m->periodic[0] = m->periodic[1] = false;
    configuration c = at_start(m);
    region g = configuration_region(&c, NULL);
    correlation t;
    assert_int_equal(correlation_new(&t, &c, &g, 5, NULL), SD_OK);
    SYSTEM_NEAR(t.reach, 0.5, 1e-12, "reach: five diameters");
    /* pairs in bin k: 4000^2/2 pi (2k + 1) 0.01/100; the error bar is that of their number */
    for (size_t k = 0; k < 5; k++)
      SYSTEM_NEAR(t.pairs->bin[k], 1.0, 4.0 / sqrt(8e6 * M_PI * (double)(2 * k + 1) * 1e-4),
                  "g, bin %zu", k);
    correlation_free(&t);
    configuration_free(&c);
    sd_model_free(m);
  }
}

/* A chain that hangs on a ring of disks: its end is a rattler, and then the next. */
static void test_rattlers(void **state) {
  for (int smooth = 0; smooth < 2; smooth++) {
    sd_contact_law law = LAW;
    if (smooth) law.mu = 0.0;
    sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-3, law);
    const double a = 0.999;
    const double at[][2] = {{0, 0},     {a, 0},     {a, a},     {0, a},
                            {2 * a, 0}, {3 * a, 0}, {4 * a, 0}, {9, 9}};
    for (size_t k = 0; k < 8; k++) system_disk(m, at[k][0], at[k][1], 0.5, 1.0);
    configuration c = at_start(m);
    region g = configuration_region(&c, NULL);
    stress s = stress_of(&c, &g);
    assert_int_equal(s.n_contacts, 7);
    /* with friction the ring of four stays, each with two contacts; without it nothing does */
    assert_int_equal(s.rattlers, smooth ? 8 : 4);
    for (size_t k = 0; k < 8; k++) assert_int_equal(s.rattler[k], smooth || k >= 4);
    SYSTEM_NEAR(s.z, 14.0 / 8.0, 1e-15, "z");
    if (smooth)
      assert_true(isnan(s.z_backbone));
    else
      SYSTEM_NEAR(s.z_backbone, 2.0, 1e-15, "z without rattlers");
    stress_free(&s);
    configuration_free(&c);
    sd_model_free(m);
  }
}

static void test_cut_disks(void **state) {
  region g = {.lower = {0, 0}, .upper = {10, 10}};
  double r = 0.7, all = M_PI * r * r;
  SYSTEM_NEAR(region_disk(&g, 5, 5, r), all, 0.0, "inside");
  SYSTEM_NEAR(region_disk(&g, 0, 5, r), 0.5 * all, 1e-15, "half");
  SYSTEM_NEAR(region_disk(&g, 10, 0, r), 0.25 * all, 1e-15, "quarter");
  SYSTEM_NEAR(region_disk(&g, -1, 5, r), 0.0, 0.0, "outside");
  double h = 0.2, segment = r * r * acos(h / r) - h * sqrt(r * r - h * h);
  SYSTEM_NEAR(region_disk(&g, 5, h, r), all - segment, 1e-14, "segment");
  SYSTEM_NEAR(region_disk(&g, 5, -h, r), segment, 1e-14, "the other part");
  /* larger than the region: all of it */
  SYSTEM_NEAR(region_disk(&g, 5, 5, 100), 100.0, 1e-11, "covered");
  /* tiles of the plane add up */
  double sum = 0.0;
  for (int k = 0; k < 36; k++) {
    int i = k % 6, j = k / 6;
    region tile = {.lower = {0.3 * i, 0.3 * j}, .upper = {0.3 * (i + 1), 0.3 * (j + 1)}};
    sum += region_disk(&tile, 0.91, 0.85, r);
  }
  SYSTEM_NEAR(sum, all, 1e-14, "tiles");
  /* a drum: two circles whose centres are d apart */
  region drum = {.outline.radius = 1.0};
  SYSTEM_NEAR(region_disk(&drum, 0.2, 0.1, 0.5), 0.25 * M_PI, 1e-15, "inside a drum");
  SYSTEM_NEAR(region_disk(&drum, 1.0, 0.0, 1.0), 2.0 * M_PI / 3.0 - 0.5 * sqrt(3.0), 1e-14, "lens");
}

/* Tiles over a hexagon of radius 1 have its area and disks' areas in it; a line through it has the
 * length of its chord. */
static void test_outline(void **state) {
  container c = {.kind = SD_CONTAINER_POLYGON, .radius = 1, .sides = 6, .angle = 0.3};
  container_shape(&c);
  region hexagon = {0};
  region_use_outline(&hexagon, &c.outline, true);
  SYSTEM_NEAR(region_area(&hexagon), 1.5 * sqrt(3.0), 1e-14, "area");
  SYSTEM_NEAR(region_disk(&hexagon, 0.1, 0.0, 0.5), 0.25 * M_PI, 1e-14, "a disk inside");
  SYSTEM_NEAR(region_disk(&hexagon, 0.3, 0.1, 9.0), region_area(&hexagon), 1e-13, "covered");
  const double middle = c.angle - M_PI / 2, x = sqrt(0.75) * cos(middle),
               y = sqrt(0.75) * sin(middle);
  SYSTEM_NEAR(region_disk(&hexagon, x, y, 0.4), 0.08 * M_PI, 1e-14, "half a disk on a side");
  SYSTEM_NEAR(region_line(&hexagon, -2 * x, -2 * y, 4 * x, 4 * y), 0.5, 1e-14, "half of a line");
  SYSTEM_NEAR(region_line(&hexagon, 0, 0, 2 * x, 2 * y), 0.5, 1e-14, "from the centre");
  SYSTEM_NEAR(region_line(&hexagon, 2 * x, 2 * y, y, -x), 0.0, 0.0, "outside");
  assert_true(region_holds(&hexagon, 0.99 * x, 0.99 * y) &&
              !region_holds(&hexagon, 1.01 * x, 1.01 * y));
  double area = 0.0, disk = 0.0;
  for (int k = 0; k < 400; k++) {
    region part = {.lower = {-2, -1.2 + 0.006 * k}, .upper = {2, -1.2 + 0.006 * (k + 1)}};
    region_use_outline(&part, &c.outline, false);
    area += part.outline.n > 0 ? region_area(&part) : 0.0;
    disk += part.outline.n > 0 ? region_disk(&part, 0.7, 0.2, 0.5) : 0.0;
  }
  SYSTEM_NEAR(area, region_area(&hexagon), 1e-13, "slices of the hexagon");
  SYSTEM_NEAR(disk, region_disk(&hexagon, 0.7, 0.2, 0.5), 1e-13, "slices of a disk");
}

static void frame_of(frame_data *f, const sd_model *m, const sd_state *s, bool contacts) {
  assert_int_equal(frame_data_of_state(f, m, s, NULL), SD_OK);
  f->has_contacts = contacts;
}

/* Disks in a tilted trough of all kinds of walls, one of which turns. */
static sd_simulation *trough(const char *integrator, const char *variant, double gamma_n) {
  text t = {0};
  text_add(&t,
           "dt = 1e-4; integrator = \"%s\"; contact_variant = \"%s\"; gravity = { g = 10.0; tilt = "
           "0.1; };\n",
           integrator, variant);
  text_add(&t, "materials = ( { name = \"m\"; k_n = 1e6; k_t = 6e5; gamma_n = %g; mu = 0.4; } );\n",
           gamma_n);
  text_add(&t, "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 10.0; rows = (");
  uint64_t seed = 3;
  for (int k = 0; k < 40; k++) {
    double x = next_uniform(&seed), y = next_uniform(&seed), r = next_uniform(&seed);
    int column = k % 8, row = k / 8;
    text_add(&t, "%s(%.6f, %.6f, %.6f)", k ? ", " : "", -3.4 + column + 0.03 * x,
             1.2 + row + 0.03 * y, 0.36 + 0.13 * r);
  }
  text_add(
      &t,
      "); } );\nwalls = ( { name = \"floor\"; type = \"polyline\"; points = ((-4.5, 3.0), (-4.0, "
      "0.2), (-1.0, "
      "-0.4), (1.5, 0.0), (4.5, 0.5), (4.6, 4.0)); },\n"
      " { name = \"peg\"; type = \"circle\"; center = (0.0, -0.1); side = \"outside\"; radius = "
      "0.6; },\n"
      " { name = \"bar\"; type = \"segment\"; points = ((-2.0, 0.3), (-1.0, 0.1)); },\n"
      " { name = \"line\"; type = \"line\"; points = ((-4.0, 0.3), (-1.0, -0.3)); } );\n"
      "motions = ( { name = \"turn\"; wall = \"bar\"; coordinate = \"theta\"; type = \"harmonic\"; "
      "amplitude = 0.2; "
      "frequency = 1.0; } );\nphases = ( { steps = 100000; } );\n");
  sd_simulation *sim = begin_run(model_of(t.s), 1);
  free(t.s);
  return sim;
}

/* Forces of the contacts of each disk add up to what the engine has in its state. Returns which kinds of bodies are
 * touched: a bit for each wall, and one for disks. */
static unsigned compare_forces(sd_simulation *sim, const char *what) {
  const sd_model *m = sd_simulation_model(sim);
  const sd_state *s = sd_simulation_state(sim);
  frame_data f;
  configuration c;
  frame_of(&f, m, s, true);
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  region g = configuration_region(&c, NULL);
  stress q;
  assert_int_equal(stress_new(&q, &c, &g, NULL), SD_OK);
  double weight = m->disks[0].mass * 10.0;
  for (uint32_t i = 0; i < m->n_disks; i++) {
    uint32_t k = sd_simulation_slot(sim, i);
    double x = s->force_x[k] + m->disks[i].mass * m->gravity[0];
    double y = s->force_y[k] + m->disks[i].mass * m->gravity[1];
    SYSTEM_NEAR(q.resultant[i][0], x, 1e-9 * weight, "%s: x force on disk %u", what, i);
    SYSTEM_NEAR(q.resultant[i][1], y, 1e-9 * weight, "%s: y force on disk %u", what, i);
  }
  unsigned touched = 0;
  for (size_t k = 0; k < c.n_contacts; k++)
    if (c.contacts[k].force > 0.0)
      touched |= 1u << (c.contacts[k].b < 40 ? 4 : c.contacts[k].b - 40);
  stress_free(&q);
  configuration_free(&c);
  frame_data_free(&f);
  return touched;
}

static void test_forces_of_a_run(void **state) {
  for (int v = 0; v < 2; v++) {
    sd_simulation *sim = trough("verlet", system_variants[v], 500.0);
    const sd_model *m = sd_simulation_model(sim);
    unsigned touched = 0;
    for (int k = 0; k < 15; k++) {
      advance(sim, 1000);
      touched |= compare_forces(sim, system_variants[v]);
    }
    assert_int_equal(touched, 31); /* disks and every kind of wall */
    sd_simulation_free(sim);
    sd_model_free((sd_model *)(uintptr_t)m);
  }
}

static int by_bodies(const void *x, const void *y) {
  const config_contact *p = x, *q = y;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  if (p->b != q->b) return p->b < q->b ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

/* Contacts that are found again are those that were stored. With velocity Verlet and no viscosity to rounding; with Gear but
 * for the correction of one step, which the damping multiplies. */
static void recompute(const char *integrator, double gamma_n, double bound, double bound_n,
                      double bound_f) {
  sd_simulation *sim = trough(integrator, "paper", gamma_n);
  const sd_model *m = sd_simulation_model(sim);
  advance(sim, 7000);
  frame_data f[2];
  configuration c[2];
  for (int k = 0; k < 2; k++) {
    frame_of(&f[k], m, sd_simulation_state(sim), k == 0);
    assert_int_equal(configuration_new(&c[k], m, &f[k], NULL), SD_OK);
    assert_int_equal(c[k].recomputed, k == 1);
    qsort(c[k].contacts, c[k].n_contacts, sizeof *c[k].contacts, by_bodies);
  }
  assert_int_equal(c[0].n_contacts, c[1].n_contacts);
  for (size_t k = 0; k < c[0].n_contacts; k++) {
    const config_contact *p = &c[0].contacts[k], *q = &c[1].contacts[k];
    assert_int_equal(by_bodies(p, q), 0);
    SYSTEM_NEAR(q->overlap, p->overlap, bound, "overlap %u %u", p->a, p->b);
    SYSTEM_NEAR(q->force, p->force, 1e-7 + bound_f * (1.0 + p->force), "force %u %u", p->a, p->b);
    SYSTEM_NEAR(q->nx, p->nx, bound_n, "direction %u %u", p->a, p->b);
    assert_true(isnan(q->tau) && isfinite(p->tau));
  }
  for (int k = 0; k < 2; k++) {
    configuration_free(&c[k]);
    frame_data_free(&f[k]);
  }
  sd_simulation_free(sim);
  sd_model_free((sd_model *)(uintptr_t)m);
}

static void test_recomputed_contacts(void **state) {
  recompute("verlet", 0.0, 1e-13, 1e-12, 0.0);
  recompute("gear5", 500.0, 1e-8, 1e-10, 1e-3);
}

/* Disks that wait or were removed are not there; numbers are those of the deck. */
static void test_absent_disks(void **state) {
  sd_model *m =
      system_new(SD_GEAR5, SD_PAPER, 1e-3,
                 (sd_contact_law){.k_n = 1000.0, .k_t = 500.0, .gamma_n = 1.0, .mu = 0.3});
  for (int k = 0; k < 6; k++) system_disk(m, 0.99 * k, 0.0, 0.5, 1.0);
  frame_data f;
  assert_int_equal(frame_data_new(&f, 6, 0, NULL), SD_OK);
  for (int k = 0; k < 6; k++) f.position[k][0] = 0.99 * k;
  f.activity[1] = SD_WAITING;
  f.activity[4] = SD_REMOVED;
  f.activity[5] = SD_OUTSIDE;
  configuration c;
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  assert_int_equal(c.model->n_disks, 4);
  assert_int_equal(c.n_waiting, 1);
  assert_int_equal(c.n_removed, 1);
  const uint32_t number[] = {0, 2, 3, 5};
  for (int k = 0; k < 4; k++) assert_int_equal(c.number[k], number[k]);
  assert_int_equal(c.n_contacts, 1); /* of disks 2 and 3 */
  configuration_free(&c);
  /* a table that speaks of a disk that is not there */
  assert_int_equal(frame_data_contacts(&f, 1, NULL), SD_OK);
  f.a[0] = 0, f.b[0] = 1;
  sd_messages *messages = sd_messages_new();
  assert_int_equal(configuration_new(&c, m, &f, messages), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "bodies 0 and 1"));
  configuration_free(&c);
  sd_messages_free(messages);
  frame_data_free(&f);
  sd_model_free(m);
}

RUN_TESTS(TEST(test_triangular), TEST(test_square), TEST(test_part_of_lattice),
          TEST(test_disk_between_walls), TEST(test_cells_at_walls),
          TEST(test_cells_at_inclined_walls), TEST(test_cells_in_drum), TEST(test_radical_cells),
          TEST(test_many_radical_cells), TEST(test_flat_cells), TEST(test_ideal_pairs),
          TEST(test_rattlers), TEST(test_cut_disks), TEST(test_outline), TEST(test_forces_of_a_run),
          TEST(test_recomputed_contacts), TEST(test_absent_disks))
