/* test_arcs.c: walls that are part of a circle: a pendulum, ways around both ends, a ring against a circle, a disk that lies on the rims,
 * one that rolls off the end, distances and boxes. */
#include "model/walls.h"
#include "model/motions.h"
#include "model/overlaps.h"
#include "physics/contact/walls.h"
#include "system.h"

static const sd_contact_law rough = {.k_n = 1e7, .k_t = 1e7, .mu = 10};

static uint32_t add_arc(sd_model *m, double x, double y, double radius, double from, double to) {
  const sd_wall w = {.kind = SD_WALL_ARC,
                     .center = {x, y},
                     .pivot = {x, y},
                     .radius = radius,
                     .from = from,
                     .to = to};
  sd_model_add_wall(m, &w);
  return (uint32_t)(m->n_disks + m->n_walls - 1);
}

/* Rolling without slip in a bowl: T = 2 pi sqrt(3 l/(2 g)) (1 + A^2/16 + 11 A^4/3072), l = radius - R; no energy is lost. */
static void test_a_pendulum(void **unused) {
  const double radius = 5, r = 1, g = 10, mass = 0.1, amplitude = 0.2;
  for (int k = 0; k < 2; k++) {
    const double dt = k ? 5e-6 : 2e-5; /* Gear damps what oscillates fast */
    sd_model *m = system_new(k ? SD_GEAR5 : SD_VERLET, SD_CONSERVATIVE, dt, rough);
    const double deep = mass * g * cos(amplitude) / rough.k_n, l = radius - r + deep;
    m->gravity[1] = -g;
    system_disk(m, l * sin(amplitude), radius - l * cos(amplitude), r, mass);
    add_arc(m, 0, radius, radius, -M_PI + 0.3, -0.3);
    sd_simulation *s = system_start(m);
    /* passes of the lowest point */
    double first = 0, last = 0, before = system_at(s, 0).x, most = 0;
    int passes = 0;
    for (int64_t n = 1; passes < 5; n++) {
      system_advance(s, 1);
      const double x = system_at(s, 0).x;
      if (n % 1000 == 0) {
        const sd_energy e = sd_simulation_energy(s);
        most = fmax(most, fabs(e.residual));
        assert_true(e.friction == 0);
      }
      if ((x > 0) != (before > 0)) {
        last = dt * ((double)n - x / (x - before));
        if (passes++ == 0) first = last;
      }
      before = x;
    }
    const double a2 = amplitude * amplitude, small = 2 * M_PI * sqrt(1.5 * l / g);
    SYSTEM_NEAR((last - first) / 2, small * (1 + a2 / 16 + 11 * a2 * a2 / 3072), 2e-5 * small,
                "period, %s", system_integrators[!k]);
    SYSTEM_NEAR(most / (mass * g * l * (1 - cos(amplitude))), 0, 1e-7, "energy, %s",
                system_integrators[!k]);
    SYSTEM_NEAR((double)system_touch(s, 0, 1).pieces, 1, 0, "one contact");
    system_end(s);
  }
}

/* A disk is led around an arc, over the outer side, one end, the inner side, the other end; the arc may move and turn. In a lap the
 * nearest point makes twice the length of the arc, and the contact turns once. */
typedef struct lap {
  double radius, from, to, turn, move;
} lap;
enum { ROWS = 4000 };

/* Place after the part s of a lap, at distance d from the arc, in its frame. */
static double way_at(const lap *arc, double d, double s, double p[2]) {
  const double open = arc->to - arc->from,
               part[] = {(arc->radius + d) * open, M_PI * d, (arc->radius - d) * open, M_PI * d};
  const double whole = part[0] + part[1] + part[2] + part[3];
  double left = s * whole;
  int k = 0;
  while (k < 3 && left > part[k]) left -= part[k++];
  const double angle = k == 0   ? arc->from + left / (arc->radius + d)
                       : k == 1 ? arc->to
                       : k == 2 ? arc->to - left / (arc->radius - d)
                                : arc->from;
  const double r = k == 0 ? arc->radius + d : arc->radius - d,
               around = k == 1 ? arc->to + left / d : arc->from + M_PI + left / d;
  const bool cap = k % 2;
  p[0] = (cap ? arc->radius : r) * cos(angle) + (cap ? d * cos(around) : 0);
  p[1] = (cap ? arc->radius : r) * sin(angle) + (cap ? d * sin(around) : 0);
  return whole;
}

static void place_at(const lap *arc, double d, double t, double p[2]) {
  double q[2];
  way_at(arc, d, fmod(0.13 + t, 1), q);
  const double c = cos(arc->turn * t), i = sin(arc->turn * t);
  p[0] = arc->move * t + c * q[0] - i * q[1];
  p[1] = i * q[0] + c * q[1];
}

static void test_around_the_ends(void **unused) {
  const lap laps[] = {{3, 0.3, 2.5, 0, 0}, {3, -0.7, 4.2, 0, 0},    {3, 1, 1.2, 0, 0},
                      {2, 0, M_PI, 0, 0},  {3, 0.3, 2.5, 2.1, 0.7}, {3, -0.7, 4.2, -8, -0.2}};
  const double r = 0.5, d = 0.49;
  for (size_t k = 0; k < sizeof laps / sizeof *laps; k++) {
    const lap *arc = &laps[k];
    sd_model *m =
        system_new(SD_VERLET, SD_PAPER, 2e-4, (sd_contact_law){.k_n = 100, .k_t = 10, .mu = 1e6});
    double start[2], p[2];
    place_at(arc, d, 0, start);
    system_disk(m, start[0], start[1], r, 1);
    m->disks[0].inertia = 1e9;
    add_arc(m, 0, 0, arc->radius, arc->from, arc->to);
    system_move(m, 1, SD_X, arc->move);
    system_move(m, 1, SD_THETA, arc->turn);
    for (int c = 0; c < 2; c++) {
      sd_motion *q = system_motion(m, 0, c, SD_MOTION_TABLE);
      q->amplitude = 1;
      q->n_table = 2 * ROWS + 1;
      q->table_time = malloc(q->n_table * sizeof(double));
      q->table_value = malloc(q->n_table * sizeof(double));
      for (size_t n = 0; n < q->n_table; n++) {
        q->table_time[n] = (double)n / ROWS;
        place_at(arc, d, q->table_time[n], p);
        q->table_value[n] = p[c] - start[c];
      }
    }
    sd_simulation *s = system_start(m);
    unsigned parts = 0;
    for (int n = 0; n < 5000; n++) {
      system_advance(s, 1);
      const system_contact now = system_touch(s, 0, 1);
      assert_true(now.closed && now.pieces == 1);
      SYSTEM_NEAR(now.overlap, r - d, 2e-4, "overlap, lap %zu", k);
      parts |= 1u << now.part;
    }
    assert_int_equal(parts, 7);
    const double theta = (double)system_at(s, 0).theta,
                 length = arc->radius * (arc->to - arc->from);
    SYSTEM_NEAR(system_touch(s, 0, 1).stretch, r * (theta - 2 * M_PI - arc->turn) - 2 * length,
                1e-9, "lap %zu", k);
    system_end(s);
  }
}

/* A ring does what a circle does, inside and outside, at rest and turning. */
static void test_a_ring_is_a_circle(void **unused) {
  const sd_contact_law law = {.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .mu = 0.3};
  for (int inside = 0; inside < 2; inside++)
    for (int turns = 0; turns < 2; turns++) {
      sd_simulation *s[2];
      for (int ring = 0; ring < 2; ring++) {
        sd_model *m = system_new(SD_GEAR5, SD_CONSERVATIVE, 1e-5, law);
        if (inside) m->gravity[1] = -10;
        system_disk(m, inside ? 1.5 : 3.49, 0, 0.5, 0.1);
        if (!inside) { /* pulled to a corner of the ring */
          m->disks[0].force[SD_X] = -5;
          system_velocity(m, 0, 0, 0.6, 5);
        }
        if (ring)
          add_arc(m, 0, 0, 3, 0.2, 0.2 + 2 * M_PI);
        else
          system_circle(m, 0, 0, 3, inside);
        if (turns) system_shake(m, 1, SD_THETA, 0.7, 5, 0);
        s[ring] = system_start(m);
      }
      for (int n = 0; n < 40; n++) {
        for (int ring = 0; ring < 2; ring++) system_advance(s[ring], 2500);
        const system_body a = system_at(s[0], 0), b = system_at(s[1], 0);
        SYSTEM_NEAR(b.x, a.x, 1e-8, "x, inside %d", inside);
        SYSTEM_NEAR(b.y, a.y, 1e-8, "y, inside %d", inside);
        SYSTEM_NEAR(b.omega, a.omega, 1e-6, "omega, inside %d", inside);
        const sd_energy p = sd_simulation_energy(s[0]), q = sd_simulation_energy(s[1]);
        SYSTEM_NEAR(q.friction, p.friction, 1e-7 * p.scale, "friction, inside %d", inside);
        SYSTEM_NEAR(q.work, p.work, 1e-7 * p.scale, "work, inside %d", inside);
      }
      for (int ring = 0; ring < 2; ring++) system_end(s[ring]);
    }
}

/* A disk larger than a bowl lies on both of its rims: each carries half of the weight. */
static void test_on_the_rims(void **unused) {
  sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-5,
                           (sd_contact_law){.k_n = 1e5, .k_t = 1e5, .gamma_n = 30, .mu = 0});
  m->gravity[1] = -10;
  system_disk(m, 0.01, sqrt(3) + 0.001, 2, 0.2);
  add_arc(m, 0, 0, 1, -M_PI, 0);
  sd_simulation *s = system_start(m);
  system_advance(s, 300000);
  const sd_state *q = sd_simulation_state(s);
  assert_int_equal(q->n_contacts, 2);
  for (int k = 0; k < 2; k++)
    SYSTEM_NEAR(q->contact_force[k], 0.5 * 0.2 * 10 / (sqrt(3) / 2), 1e-3, "rim %d", k);
  SYSTEM_NEAR(system_at(s, 0).x, 0, 1e-4, "between them");
  system_end(s);
}

/* From rest at height h on a quarter of a circle a disk comes to its level end with v^2 = 4 g h/3, and flies on. */
static void test_off_the_end(void **unused) {
  const double radius = 4, r = 0.5, g = 10, dt = 1e-5, angle = 1.0, l = radius - r;
  sd_model *m = system_new(SD_VERLET, SD_CONSERVATIVE, dt, rough);
  m->gravity[1] = -g;
  system_disk(m, -l * sin(angle), radius - l * cos(angle), r, 0.1);
  add_arc(m, 0, radius, radius, -M_PI, -M_PI / 2);
  sd_simulation *s = system_start(m);
  while (system_at(s, 0).x < r + 0.2) system_advance(s, 10);
  assert_int_equal(sd_simulation_state(s)->n_contacts, 0);
  const double v2 = 4.0 / 3.0 * g * l * (1 - cos(angle));
  SYSTEM_NEAR(system_at(s, 0).vx / sqrt(v2), 1, 3e-3, "speed"); /* it tips over the end */
  const sd_energy e = sd_simulation_energy(s);
  SYSTEM_NEAR((e.residual) / e.scale, 0, 1e-6, "residual");
  system_end(s);
}

/* On which side of an arc the disks are is what its middle says, not its centre; a ring has none. */
static void test_sides(void **unused) {
  sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-5, rough);
  system_disk(m, 0, 1.1, 1, 1);
  const uint32_t bowl = add_arc(m, 0, 5, 5, -2, -1), roof = add_arc(m, 0, 3, 5, 1, 2),
                 ring = add_arc(m, 0, 3, 20, 0, 2 * M_PI);
  sd_simulation *s = system_start(m);
  assert_int_equal(sd_model_side(m, bowl, SD_Y), 1);
  assert_int_equal(sd_model_side(m, roof, SD_Y), -1);
  assert_int_equal(sd_model_side(m, ring, SD_Y), 0);
  system_end(s);
}

/* Distances of the model, nearest points of the physics and the box of the pieces agree with points along the arc. */
static void test_geometry(void **unused) {
  uint64_t seed = 7;
  for (int n = 0; n < 200; n++) {
    double u[6];
    for (int k = 0; k < 6; k++) {
      seed = seed * 6364136223846793005u + 1442695040888963407u;
      u[k] = (double)(seed >> 11) * 0x1p-53;
    }
    sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1});
    system_disk(m, 100, 100, 1, 1);
    const double from = 7 * u[0] - 3, to = from + (n % 10 ? 0.02 + 6 * u[1] : 2 * M_PI),
                 radius = 0.5 + u[2];
    add_arc(m, 1, -1, radius, from, to);
    sd_simulation *s = system_start(m);
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL}, nearest = HUGE_VAL,
           active = HUGE_VAL;
    const double at[2] = {1 + 4 * u[3] - 2, -1 + 4 * u[4] - 2};
    for (int k = 0; k <= 20000; k++) {
      const double a = from + (to - from) * k / 20000,
                   p[2] = {1 + radius * cos(a), -1 + radius * sin(a)};
      for (int c = 0; c < 2; c++) low[c] = fmin(low[c], p[c]), high[c] = fmax(high[c], p[c]);
      nearest = fmin(nearest, hypot(p[0] - at[0], p[1] - at[1]));
    }
    SYSTEM_NEAR(arc_distance(&m->walls[0], at), nearest, 1e-6, "distance %d", n);
    double box[2][2] = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
    for (size_t k = 0; k < m->n_segments; k++) {
      const placed_segment g =
          walls_place(&m->segments[k], m->walls[0].pivot[0], m->walls[0].pivot[1], 1, 0, 1);
      const nearest_point q = walls_nearest(&g, at[0], at[1]);
      double lower[2], upper[2];
      walls_bounds(&g, lower, upper);
      for (int c = 0; c < 2; c++)
        box[0][c] = fmin(box[0][c], lower[c]), box[1][c] = fmax(box[1][c], upper[c]);
      if (q.active) active = fmin(active, hypot(q.dx, q.dy));
    }
    SYSTEM_NEAR(active, nearest, 1e-6, "nearest point %d", n);
    for (int c = 0; c < 2; c++) {
      SYSTEM_NEAR(box[0][c], low[c], 1e-6, "box %d", n);
      SYSTEM_NEAR(box[1][c], high[c], 1e-6, "box %d", n);
    }
    system_end(s);
  }
}

/* From each end the wall leads away along the tangent. */
static void test_ends(void **unused) {
  const double from = 0.3, to = 2.0, radius = 1.5;
  sd_model *m = system_new(SD_VERLET, SD_CONSERVATIVE, 1e-4, rough);
  add_arc(m, 1, 2, radius, from, to);
  size_t n = 0;
  wall_end *ends = joints_ends(m, &n);
  assert_int_equal(n, 2);
  for (size_t k = 0; k < n; k++) {
    const double angle = ends[k].end ? to : from, into = ends[k].end ? -1 : 1;
    SYSTEM_NEAR(ends[k].at[0], 1 + radius * cos(angle), 1e-15, "x of end %zu", k);
    SYSTEM_NEAR(ends[k].at[1], 2 + radius * sin(angle), 1e-15, "y of end %zu", k);
    SYSTEM_NEAR(ends[k].way[0], -into * sin(angle), 1e-15, "x of the tangent at end %zu", k);
    SYSTEM_NEAR(ends[k].way[1], into * cos(angle), 1e-15, "y of the tangent at end %zu", k);
    SYSTEM_NEAR(ends[k].along, radius * (to - from), 1e-15, "length at end %zu", k);
  }
  free(ends);
  /* the farthest point of the circle from the pivot */
  m->walls[0].pivot[0] = 4;
  m->walls[0].pivot[1] = -2;
  SYSTEM_NEAR(strides_arm(m, 0), 5 + radius, 1e-15, "arm");
  sd_model_free(m);
}

RUN_TESTS(TEST(test_a_pendulum), TEST(test_around_the_ends), TEST(test_a_ring_is_a_circle),
          TEST(test_on_the_rims), TEST(test_off_the_end), TEST(test_geometry), TEST(test_sides),
          TEST(test_ends))
