/* test_walls.c: memory around corners, ends and joints of straight walls; walls that move and turn; rolling.
 *
 * A disk is led around a wall along a prescribed path. `follow` integrates lambda in the test's own way, from
 * the nearest point of the whole wall, and everything the engine says is compared with that at every step.
 */
#include "model/overlaps.h"
#include "system.h"

enum { MOST_CORNERS = 8, TABLE = 2000 };

typedef struct round_trip {
  size_t n;
  double corner[MOST_CORNERS][2]; /* of the wall; a segment is passed on both sides */
  bool closed;                    /* a polygon, else a segment */
  double pivot[2], move[2], turn; /* the wall's: point and velocities */
  double laps;                    /* negative: the other way round */
  double period;                  /* of one lap */
  double k_t;
} round_trip;

static double cross(const double a[2], const double b[2]) { return a[0] * b[1] - a[1] * b[0]; }
static double dot(const double a[2], const double b[2]) { return a[0] * b[0] + a[1] * b[1]; }

/* +1: the outside is on the left of the direction in which the corners are listed. */
static double outside(const round_trip *trip) {
  double area = 0;
  for (size_t k = 0; k < trip->n; k++)
    area += cross(trip->corner[k], trip->corner[(k + 1) % trip->n]);
  return area > 0 ? -1 : 1;
}

static double edge_of(const round_trip *trip, size_t k, double t[2]) {
  const double *p = trip->corner[k % trip->n], *q = trip->corner[(k + 1) % trip->n];
  double length = hypot(q[0] - p[0], q[1] - p[1]);
  t[0] = (q[0] - p[0]) / length;
  t[1] = (q[1] - p[1]) / length;
  return length;
}

static double exterior(const double t[2], const double u[2]) {
  double angle = fabs(atan2(cross(t, u), dot(t, u)));
  return angle > M_PI - 1e-9 ? M_PI : angle;
}

/* Centre after the way s in [0, length of a lap), at distance d; returns the length of a lap. */
static double path_at(const round_trip *trip, double d, double s, double out[2]) {
  double side = outside(trip), lap = 0;
  bool found = false;
  for (size_t k = 0; k < trip->n; k++) {
    double t[2], u[2], length = edge_of(trip, k, t);
    edge_of(trip, k + 1, u);
    double turn = exterior(t, u);
    const double *p = trip->corner[k], *q = trip->corner[(k + 1) % trip->n];
    if (!found && s <= lap + length) {
      out[0] = p[0] + (s - lap) * t[0] - side * d * t[1];
      out[1] = p[1] + (s - lap) * t[1] + side * d * t[0];
      found = true;
    } else if (!found && s <= lap + length + d * turn) {
      double angle = -side * (s - lap - length) / d, nx = -side * t[1], ny = side * t[0];
      out[0] = q[0] + d * (cos(angle) * nx - sin(angle) * ny);
      out[1] = q[1] + d * (sin(angle) * nx + cos(angle) * ny);
      found = true;
    }
    lap += length + d * turn;
  }
  return lap;
}

/* Centre at time t in space: the path in the wall's frame, and the wall's pose. */
static void place_at(const round_trip *trip, double d, double t, double out[2]) {
  double p[2], lap = path_at(trip, d, 0, p), s = fmod(lap * t / trip->period, lap);
  if (trip->laps < 0) s = lap - s;
  path_at(trip, d, fmod(s + 0.1 * lap, lap), p);
  double rx = p[0] - trip->pivot[0], ry = p[1] - trip->pivot[1], c = cos(trip->turn * t),
         i = sin(trip->turn * t);
  out[0] = trip->pivot[0] + trip->move[0] * t + c * rx - i * ry;
  out[1] = trip->pivot[1] + trip->move[1] * t + i * rx + c * ry;
}

static void lead(sd_model *m, const round_trip *trip, double d) {
  size_t n = (size_t)(fabs(trip->laps) * TABLE) + 1;
  double start[2];
  place_at(trip, d, 0, start);
  for (int c = 0; c < 2; c++) {
    m->disks[0].position[c] = start[c];
    sd_motion *q = system_motion(m, 0, c, SD_MOTION_TABLE);
    q->amplitude = 1;
    q->n_table = n;
    q->table_time = malloc(n * sizeof(double));
    q->table_value = malloc(n * sizeof(double));
    for (size_t k = 0; k < n; k++) {
      double p[2];
      q->table_time[k] = (double)k * trip->period / TABLE;
      place_at(trip, d, q->table_time[k], p);
      q->table_value[k] = p[c] - start[c];
    }
  }
}

typedef struct follower {
  double arc, angle, side;
  bool flat;
  double zeta, distance, lap;
} follower;

/* Nearest point of all edges to p in the wall's frame. */
static follower nearest_on_wall(const round_trip *trip, const double p[2], double wall_angle) {
  follower best = {.distance = HUGE_VAL};
  double arc = 0;
  for (size_t k = 0; k < (trip->closed ? trip->n : trip->n - 1); k++) {
    double t[2], length = edge_of(trip, k, t);
    double r[2] = {p[0] - trip->corner[k][0], p[1] - trip->corner[k][1]}, u = dot(r, t);
    double on = fmin(fmax(u, 0), length), q[2] = {on * t[0] - r[0], on * t[1] - r[1]};
    double distance = hypot(q[0], q[1]);
    if (distance < best.distance)
      best = (follower){.arc = arc + on,
                        .angle = atan2(q[1], q[0]) + wall_angle,
                        .side = cross(t, r) > 0 ? 1 : -1,
                        .flat = on == u,
                        .distance = distance};
    arc += length;
  }
  best.lap = arc;
  return best;
}

static void follow(follower *f, const round_trip *trip, const system_body *disk,
                   const system_body *wall, double radius) {
  double rx = disk->x - wall->x, ry = disk->y - wall->y, angle = (double)wall->theta;
  double c = cos(angle), i = sin(angle);
  double p[2] = {trip->pivot[0] + c * rx + i * ry, trip->pivot[1] - i * rx + c * ry};
  follower now = nearest_on_wall(trip, p, angle);
  if (f->lap > 0) {
    double way = now.arc - f->arc, turned = now.angle - f->angle;
    if (trip->closed) way -= now.lap * nearbyint(way / now.lap);
    turned -= 2 * M_PI * nearbyint(turned / (2 * M_PI));
    now.zeta = f->zeta - radius * turned + (now.flat ? now.side : f->side) * way;
  }
  *f = now;
}

/* Leads a disk that does not turn around the wall; mu so large that it never slides. */
static void go_round(const round_trip *trip, sd_integrator integrator, const char *what) {
  const double radius = 0.5, depth = 0.004, dt = 1e-4;
  sd_model *m =
      system_new(integrator, SD_PAPER, dt,
                 (sd_contact_law){.k_n = 1e4, .k_t = trip->k_t, .gamma_n = 0, .mu = 1e12});
  system_disk(m, 0, 0, radius, 1);
  m->disks[0].inertia = 1e90;
  lead(m, trip, radius - depth);
  size_t w =
      system_straight(m, trip->closed ? SD_WALL_POLYLINE : SD_WALL_SEGMENT, trip->n, trip->corner);
  m->walls[w].closed = trip->closed;
  for (int c = 0; c < 2; c++) {
    m->walls[w].pivot[c] = trip->pivot[c];
    system_move(m, system_wall_body(m, w), c, trip->move[c]);
  }
  system_move(m, system_wall_body(m, w), SD_THETA, trip->turn);
  sd_simulation *s = system_start(m);

  follower f = {0};
  double worst = 0, most = 0, before = 0, lost = 0, hole = 0;
  bool was_passed = false;
  uint32_t part = 0;
  int64_t steps = (int64_t)(fabs(trip->laps) * trip->period / dt);
  for (int64_t k = 0; k <= steps; k++) {
    if (k) system_advance(s, 1);
    system_body disk = system_at(s, 0), wall = system_at(s, 1);
    follow(&f, trip, &disk, &wall, radius);
    system_contact c = system_touch(s, 0, 1);
    if (c.pieces != 1) fail_msg("%s: %zu contacts at step %lld", what, c.pieces, (long long)k);
    SYSTEM_NEAR(c.stretch, f.zeta, 1e-11, "%s: stretch at step %lld", what, (long long)k);
    SYSTEM_NEAR(c.force, 1e4 * (radius - f.distance), 1e-9, "%s: force at step %lld", what,
                (long long)k);
    /* action and reaction, and their moments about the origin */
    double scale = fabs(disk.force_x) + fabs(disk.force_y) + fabs(disk.torque) + 1;
    SYSTEM_NEAR(disk.force_x, -wall.force_x, 0, "%s: reaction", what);
    SYSTEM_NEAR(disk.x * disk.force_y - disk.y * disk.force_x + disk.torque +
                    wall.x * wall.force_y - wall.y * wall.force_x + wall.torque,
                0, 1e-13 * scale * (1 + fabs(wall.x) + fabs(wall.y)) * 10, "%s: moments", what);
    /* The memory is handed over when history is committed: in the step that passes a joint the new piece
     * has none yet, and there is no tangential force. */
    bool passed = k > 0 && c.part != part && trip->closed;
    double missing = disk.torque + trip->k_t * f.zeta * radius;
    if (k && !passed) SYSTEM_NEAR(missing, 0, 1e-10 * trip->k_t, "%s: torque", what);
    if (was_passed) hole += 0.5 * lost * (f.zeta - before);
    was_passed = passed;
    lost = missing / radius;
    if (passed) hole += 0.5 * lost * (f.zeta - before);
    before = f.zeta;
    part = c.part;
    worst = fmax(worst, fabs(c.stretch - f.zeta));
    most = fmax(most, fabs(f.zeta));
  }
  sd_energy energy = sd_simulation_energy(s);
  double scale = fabs(energy.work) + energy.elastic_tangential,
         residual = (energy.residual - hole) / scale;
  print_message("%s: stretch up to %.3g, error %.1e; energy residual %.1e, and %.1e at joints\n",
                what, most, worst, residual, hole / scale);
  assert_true(fabs(residual) < 2e-6);
  assert_true(fabs(hole) < 5e-4 * scale);
  system_end(s);
}

static round_trip square(void) {
  return (round_trip){.n = 4,
                      .corner = {{0, 0}, {0, 2}, {3, 2}, {3, 0}},
                      .closed = true,
                      .laps = 1.7,
                      .period = 1,
                      .k_t = 3e3};
}

static void disk_led_around_polygons(void **unused) {
  round_trip trip = square();
  go_round(&trip, SD_GEAR5, "square");
  trip.laps = -1.7;
  go_round(&trip, SD_VERLET, "square, backwards");
  /* listed the other way round: the disk is on the right of every piece */
  round_trip right = {.n = 5,
                      .corner = {{0, 0}, {2, -0.5}, {2.5, 1}, {1, 2.5}, {-0.3, 1}},
                      .closed = true,
                      .laps = 2.3,
                      .period = 1,
                      .k_t = 1e3};
  go_round(&right, SD_GEAR5, "pentagon, right side");
  right.laps = -2.3;
  go_round(&right, SD_GEAR5, "pentagon, right side, backwards");
  right.pivot[0] = -6, right.pivot[1] = 4;
  right.move[0] = 0.7, right.move[1] = -1.1;
  right.turn = 1.3;
  go_round(&right, SD_GEAR5, "pentagon that moves and turns about a far pivot");
  right.turn = -9;
  go_round(&right, SD_VERLET, "pentagon that turns quickly");
}

static void disk_led_around_both_ends_of_a_segment(void **unused) {
  round_trip trip = {.n = 2,
                     .corner = {{0.3, 0.2}, {2, 1}},
                     .pivot = {0.3, 0.2},
                     .laps = 2.4,
                     .period = 1,
                     .k_t = 1e3};
  go_round(&trip, SD_GEAR5, "segment");
  trip.laps = -2.4;
  go_round(&trip, SD_VERLET, "segment, backwards");
  trip.pivot[0] = 11, trip.pivot[1] = -3;
  trip.move[0] = -0.4;
  trip.turn = 2.2;
  go_round(&trip, SD_GEAR5, "segment that moves and turns about a far pivot");
}

/* A smooth disk in a groove of slopes a (left) and b (right): forces m g sin b/sin(a + b), m g sin a/sin(a + b). */
static void groove_has_two_contacts(void **unused) {
  for (int way = 0; way < 2; way++)
    for (double a = 0.3; a < 1.5; a += 0.35) {
      double b = 0.9 - 0.3 * a, weight = 9.81, k_n = 1e4;
      sd_model *m = system_new(way ? SD_VERLET : SD_GEAR5, SD_PAPER, 1e-4,
                               (sd_contact_law){.k_n = k_n, .k_t = 0, .gamma_n = 60, .mu = 0});
      m->gravity[1] = -weight;
      /* touches both sides when its centre is on the bisector */
      double half = 0.5 * (M_PI - a - b), up = 0.5 / sin(half), lean = b + half - M_PI / 2;
      system_disk(m, -up * sin(lean), up * cos(lean), 0.5, 1);
      double points[3][2] = {{-3 * cos(a), 3 * sin(a)}, {0, 0}, {3 * cos(b), 3 * sin(b)}};
      if (way) {
        double left[2] = {points[0][0], points[0][1]};
        memcpy(points[0], points[2], sizeof left);
        memcpy(points[2], left, sizeof left);
      }
      system_straight(m, SD_WALL_POLYLINE, 3, (const double(*)[2])points);
      sd_simulation *s = system_start(m);
      system_advance(s, 40000);
      const sd_state *q = sd_simulation_state(s);
      assert_int_equal(q->n_contacts, 2);
      double left = weight * sin(b) / sin(a + b), right = weight * sin(a) / sin(a + b);
      /* the disk sinks by delta: slopes stay, so forces are those of the undeformed groove exactly */
      SYSTEM_NEAR(q->contact_force[way], left, 1e-8, "left slope %g", a);
      SYSTEM_NEAR(q->contact_force[1 - way], right, 1e-8, "right slope, left %g", a);
      system_end(s);
    }
}

static const sd_contact_law joint_laws[] = {{.k_n = 1e4},
                                            {.k_n = 1e4, .k_t = 7e3, .mu = 0.3},
                                            {.k_n = 1e4, .k_t = 7e3, .gamma_n = 30, .mu = 0.3}};

/* A disk on a straight wall with joints at -1, 0 and 1, or without; on its upper or on its lower side. */
static sd_simulation *on_jointed_wall(sd_integrator integrator, sd_contact_law law, bool jointed,
                                      double side, double x, double vx) {
  const double weight = 9.81, points[5][2] = {{-3, 0}, {-1, 0}, {0, 0}, {1, 0}, {3, 0}};
  sd_model *m = system_new(integrator, SD_CONSERVATIVE, 1e-4, law);
  m->gravity[1] = -side * weight;
  system_disk(m, x, side * (0.5 - weight / law.k_n), 0.5, 1);
  system_velocity(m, 0, vx, 0, 0);
  if (jointed)
    system_straight(m, SD_WALL_POLYLINE, 5, points);
  else
    system_straight(m, SD_WALL_SEGMENT, 2, (const double[2][2]){{-3, 0}, {3, 0}});
  return system_start(m);
}

/* Above a joint exactly, one piece carries the disk, not two. */
static void joint_below_a_disk_is_not_felt(void **unused) {
  for (int c = 0; c < 12; c++) {
    sd_simulation *s = on_jointed_wall(c % 2 ? SD_VERLET : SD_GEAR5, joint_laws[c / 2 % 3], true,
                                       c < 6 ? 1 : -1, 0, 0);
    assert_int_equal(system_touch(s, 0, 1).pieces, 1);
    SYSTEM_NEAR(fabs(system_at(s, 0).force_y), 9.81, 1e-9, "force at the start");
    system_advance(s, 100);
    assert_int_equal(system_touch(s, 0, 1).pieces, 1);
    SYSTEM_NEAR(fabs(system_at(s, 0).force_y), 9.81, 1e-9, "force of a disk at rest");
    system_end(s);
  }
}

/* Sliding over joints is the same as over one piece. With friction it is so to the order of dt: in the step in
 * which the trial coordinates pass a joint, the skin's force is missing. */
static void joints_on_the_way_are_not_felt(void **unused) {
  for (int c = 0; c < 12; c++) {
    sd_simulation *s[2];
    sd_energy energy[2];
    const sd_contact_law *law = &joint_laws[c / 2 % 3];
    for (int k = 0; k < 2; k++) {
      s[k] = on_jointed_wall(c % 2 ? SD_VERLET : SD_GEAR5, *law, k, c < 6 ? 1 : -1, -1.5, 3);
      system_advance(s[k], 10000);
      energy[k] = sd_simulation_energy(s[k]);
    }
    system_body one = system_at(s[0], 0), two = system_at(s[1], 0);
    assert_true(one.x > 0.3);
    double near = law->mu > 0.0 ? 2 * law->mu * 9.81 * 1e-4 : 1e-11;
    SYSTEM_NEAR(two.x, one.x, near, "case %d: x", c);
    SYSTEM_NEAR((double)two.theta, (double)one.theta, 4 * near, "case %d: angle", c);
    SYSTEM_NEAR(energy[1].opening, 0, 1e-10, "case %d: dropped", c);
    SYSTEM_NEAR(energy[1].viscous, energy[0].viscous, 3 * near, "case %d: viscous loss", c);
    SYSTEM_NEAR(energy[1].friction, energy[0].friction, 6 * near, "case %d: frictional loss", c);
    SYSTEM_NEAR(energy[1].residual, energy[0].residual, 6 * near, "case %d: residual", c);
    system_end(s[0]);
    system_end(s[1]);
  }
}

typedef struct slide_case {
  double angle, speed, belt; /* of the wall's direction; of the disk; of the wall along itself */
  sd_wall_kind kind;
  bool back; /* on the right side of the wall */
  sd_integrator integrator;
  double dt;
} slide_case;

/* Slides with mu m g, then rolls: u = 2 u0/3 (relative to the wall) after u0/(3 mu g). While the skin stretches,
 * for x0/u0 with x0 = mu m g/k_t, half of the impulse is missing: the time grows by half of that. */
static void slide_then_roll(const slide_case *c) {
  const double g = 9.81, mu = 0.3, k_n = 1e5, k_t = 1e6, mass = 2, radius = 0.5;
  sd_model *m = system_new(c->integrator, SD_PAPER, c->dt,
                           (sd_contact_law){.k_n = k_n, .k_t = k_t, .gamma_n = 200, .mu = mu});
  double tx = cos(c->angle), ty = sin(c->angle), up = c->back ? -1 : 1;
  double nx = -ty * up, ny = tx * up; /* from the wall to the disk */
  m->gravity[0] = -g * nx;
  m->gravity[1] = -g * ny;
  double height = radius - mass * g / k_n;
  system_disk(m, 0.3 * tx + height * nx, 0.3 * ty + height * ny, radius, mass);
  system_velocity(m, 0, c->speed * tx, c->speed * ty, 0);
  double points[2][2] = {{-20 * tx, -20 * ty}, {20 * tx, 20 * ty}};
  size_t w = system_straight(m, c->kind, 2, (const double(*)[2])points);
  if (c->belt != 0) {
    system_move(m, system_wall_body(m, w), SD_X, c->belt * tx);
    system_move(m, system_wall_body(m, w), SD_Y, c->belt * ty);
  }
  sd_simulation *s = system_start(m);
  double u0 = c->speed - c->belt, time, speed;
  sd_slide_to_roll(mass, 0.5 * mass * radius * radius, radius, mu, g, fabs(u0), &time, &speed);
  SYSTEM_NEAR(time, fabs(u0) / (3 * mu * g), 1e-15, "closed form");
  double load = mu * mass * g / k_t / fabs(u0), expected = time + 0.5 * load;

  system_advance(s, (int64_t)(2 * load / c->dt));
  system_contact touch = system_touch(s, 0, 1);
  assert_true(touch.slide != 0);
  while (touch.slide != 0) {
    system_advance(s, 1);
    touch = system_touch(s, 0, 1);
    SYSTEM_NEAR(touch.force, mass * g, 1e-6, "weight");
    assert_true(sd_simulation_time(s) < 2 * time);
  }
  SYSTEM_NEAR(sd_simulation_time(s), expected, 3 * c->dt + 0.01 * load,
              "angle %g: time until it rolls", c->angle);
  /* the skin rings without damping: mean over whole periods of it */
  double period = 2 * M_PI / sqrt(k_t * 3 / mass), u = 0, spin = 0;
  int64_t n = (int64_t)nearbyint(20 * period / c->dt);
  for (int64_t k = 0; k < n; k++) {
    system_advance(s, 1);
    system_body d = system_at(s, 0);
    u += (d.vx * tx + d.vy * ty - c->belt) / (double)n;
    spin += d.omega / (double)n;
    /* friction cannot change the angular momentum about the line of contact */
    SYSTEM_NEAR((d.vx * tx + d.vy * ty) - up * 0.5 * radius * d.omega, c->speed, 1e-9,
                "angular momentum");
  }
  SYSTEM_NEAR(u, 2 * u0 / 3, 2e-4 * fabs(u0), "angle %g: speed of rolling", c->angle);
  SYSTEM_NEAR(spin, -up * 2 * u0 / 3 / radius, 4e-4 * fabs(u0), "angle %g: spin", c->angle);
  sd_energy e = sd_simulation_energy(s);
  /* in the wall's frame m u0^2/6 is lost; the skin that still rings has the rest */
  double lost = mass * u0 * u0 / 6;
  SYSTEM_NEAR(e.friction, lost, 2e-3 * lost, "angle %g: friction", c->angle);
  SYSTEM_NEAR(e.residual, 0, 1e-5 * e.scale, "angle %g: energy", c->angle);
  system_end(s);
}

static void sliding_turns_into_rolling(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_integrator i = (sd_integrator)integrator;
    slide_case cases[] = {
        {0, 0.5, 0, SD_WALL_LINE, false, i, 1e-5},
        {0.7, -0.4, 0, SD_WALL_LINE, false, i, 1e-5},
        {M_PI, 0.5, 0, SD_WALL_SEGMENT, false, i, 1e-5},
        {2.5, 0.5, 0, SD_WALL_LINE, true, i, 1e-5},
        {0, 0, 0.6, SD_WALL_LINE, false, i, 1e-5},
        {-1.9, 0.2, -0.4, SD_WALL_SEGMENT, true, i, 1e-5},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) slide_then_roll(&cases[k]);
  }
}

/* Down a slope without sliding: g sin(a) 2/3; steeper than tan a = 3 mu it slides: g (sin a - mu cos a). */
static void disk_goes_down_a_slope(void **unused) {
  const double g = 9.81, mu = 0.2, k_n = 1e5, k_t = 1e6, mass = 1, radius = 0.5, dt = 2e-5,
               time = 0.5;
  for (int integrator = 0; integrator < 2; integrator++)
    for (double a = 0.1; a < 0.9; a += 0.2) {
      sd_model *m = system_new((sd_integrator)integrator, SD_CONSERVATIVE, dt,
                               (sd_contact_law){.k_n = k_n, .k_t = k_t, .gamma_n = 100, .mu = mu});
      m->gravity[0] = -g * sin(a);
      m->gravity[1] = -g * cos(a);
      system_disk(m, 0, radius - mass * g * cos(a) / k_n, radius, mass);
      double points[2][2] = {{-1, 0}, {1, 0}};
      system_straight(m, SD_WALL_LINE, 2, (const double(*)[2])points);
      sd_simulation *s = system_start(m);
      system_advance(s, (int64_t)nearbyint(time / dt));
      bool rolls = tan(a) < 3 * mu;
      double acceleration = rolls ? 2.0 / 3.0 * g * sin(a) : g * (sin(a) - mu * cos(a));
      /* before it slides the skin stretches like an oscillator, and friction is less */
      double w = sqrt(3 * k_t / mass), load = rolls ? 0 : acos(1 - 3 * mu / tan(a)) / w;
      double more = mu * g * cos(a) * load - g * sin(a) / 3 * (load - sin(w * load) / w);
      SYSTEM_NEAR(system_at(s, 0).x, -0.5 * acceleration * time * time - more * time,
                  2 * mass * g / k_t, "slope %g: way", a);
      assert_int_equal(system_touch(s, 0, 1).slide != 0, !rolls);
      system_end(s);
    }
}

/* A disk that cannot turn is carried up to the angle of friction; there it slides. */
static void drum_drags_a_disk_to_the_angle_of_friction(void **unused) {
  for (int variant = 0; variant < 2; variant++)
    for (int sense = -1; sense <= 1; sense += 2) {
      const double g = 9.81, mu = 0.4, k_n = 1e5, dt = 4e-5, hollow = 2, radius = 0.25;
      sd_model *m =
          system_new(SD_GEAR5, (sd_variant)variant, dt,
                     (sd_contact_law){.k_n = k_n, .k_t = 0.5 * k_n, .gamma_n = 300, .mu = mu});
      m->gravity[1] = -g;
      system_disk(m, 0, -(hollow - radius) - g / k_n, radius, 1);
      m->disks[0].locked[SD_THETA] = true;
      size_t w = system_circle(m, 0, 0, hollow, true);
      system_move(m, system_wall_body(m, w), SD_THETA, sense * 0.02);
      sd_simulation *s = system_start(m);
      system_advance(s, 800000); /* carried up, slips back, and so on */
      double mean = 0;
      for (int k = 0; k < 8000; k++) {
        system_advance(s, 100);
        system_body d = system_at(s, 0);
        mean += atan2(d.x, -d.y) / 8000;
      }
      SYSTEM_NEAR(mean, sense * atan(mu), 2e-3, "%s: angle", system_variants[variant]);
      sd_energy e = sd_simulation_energy(s);
      SYSTEM_NEAR(e.residual, 0, 2e-4 * e.scale, "%s: energy", system_variants[variant]);
      system_end(s);
    }
}

/* A free disk rolls at the drum's surface speed and stays at the bottom. */
static void disk_rolls_in_a_turning_drum(void **unused) {
  const double g = 9.81, k_n = 1e5, dt = 2e-5, hollow = 2, radius = 0.25, turn = 0.8;
  sd_model *m =
      system_new(SD_GEAR5, SD_CONSERVATIVE, dt,
                 (sd_contact_law){.k_n = k_n, .k_t = 0.5 * k_n, .gamma_n = 300, .mu = 0.5});
  m->gravity[1] = -g;
  system_disk(m, 0, -(hollow - radius) - g / k_n, radius, 1);
  system_velocity(m, 0, 0, 0, turn * hollow / radius);
  system_circle(m, 0, 0, hollow, true);
  system_move(m, 1, SD_THETA, turn);
  sd_simulation *s = system_start(m);
  system_advance(s, 1000000);
  system_body d = system_at(s, 0);
  SYSTEM_NEAR(atan2(d.x, -d.y), 0, 1e-9, "stays at the bottom");
  SYSTEM_NEAR(d.omega, turn * hollow / radius, 1e-9, "surface speeds");
  SYSTEM_NEAR(system_touch(s, 0, 1).stretch, 0, 1e-12, "nothing stretched");
  system_end(s);
}

static void expect(sd_model *m, const char *error) {
  m->phases = calloc(1, sizeof *m->phases);
  m->n_phases = 1;
  m->phases[0] = (sd_phase){.steps = 1, .active = calloc(1, sizeof(bool))};
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_model_finish(m, messages), error ? SD_ERROR_USER : SD_OK);
  if (error && !strstr(sd_messages_text(messages, 0), error))
    fail_msg("%s", sd_messages_text(messages, 0));
  sd_messages_free(messages);
  sd_model_free(m);
}

static void walls_that_cannot_be_are_refused(void **unused) {
  for (int c = 0; c < 8; c++) {
    sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-4, joint_laws[0]);
    system_disk(m, 0, 0, 0.5, 1);
    if (c < 4) { /* in a periodic box the nearest image must be the only one */
      m->periodic[0] = true;
      m->lower[0] = -3, m->upper[0] = 3;
      system_circle(m, 0, 4, c < 2 ? 2.4 : 2.9, c % 2);
      expect(m, c == 2 ? "the periodic box must be wider than 6.8" : NULL);
    } else if (c < 6) {
      m->disks[0].driven = c == 5;
      system_circle(m, 0.05, 0, 0.49, true);
      expect(m, c == 4 ? "of radius 0.5, does not fit into it" : NULL);
    } else {
      size_t w = system_straight(m, SD_WALL_POLYLINE, 4,
                                 (const double[4][2]){{2, 0}, {3, 0}, {3, 1}, {2, 0}});
      m->walls[w].closed = c == 7;
      expect(m, c == 7 ? "points 3 and 0 coincide" : NULL);
    }
  }
}

/* Gap between a disk and the nearest image of a segment of length 6 in a box of 10, which lies
 * level or stands upright. */
static void gaps_are_to_the_nearest_image(void **unused) {
  static const struct {
    double across, beside, gap; /* of the centre of a disk of radius 0.5 */
  } at[] = {{0, 2, 1.5},  {2, -1, 0.5}, {4.5, 0, 1}, {5.5, 0, 1},
            {-5.5, 0, 1}, {14.5, 0, 1}, {0, 9, 0.5}, {1, -8, 1.5}};
  for (int upright = 0; upright < 2; upright++) {
    sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-4, joint_laws[0]);
    system_disk(m, 0, 2, 0.5, 1);
    system_straight(m, SD_WALL_SEGMENT, 2, (const double[2][2]){{-3, 0}, {3, 0}});
    m->walls[0].pivot[0] = 0;
    for (int c = 0; c < 2; c++) m->periodic[c] = true, m->lower[c] = -5, m->upper[c] = 5;
    assert_true(overlaps_first_gap(m, 0, 1) == 1.5);
    for (size_t k = 0; k < sizeof at / sizeof *at; k++) {
      const double way[2] = {at[k].across, at[k].beside},
                   x[2] = {upright ? -way[1] : way[0], way[upright ? 0 : 1]};
      SYSTEM_NEAR(overlaps_gap(m, 0, x, 1, (const double[3]){0, 0, upright ? M_PI / 2 : 0}),
                  at[k].gap, 1e-14, "gap %zu", k);
    }
    sd_model_free(m);
  }
}

RUN_TESTS(TEST(disk_led_around_polygons), TEST(disk_led_around_both_ends_of_a_segment),
          TEST(groove_has_two_contacts), TEST(joint_below_a_disk_is_not_felt),
          TEST(joints_on_the_way_are_not_felt), TEST(sliding_turns_into_rolling),
          TEST(disk_goes_down_a_slope), TEST(walls_that_cannot_be_are_refused),
          TEST(drum_drags_a_disk_to_the_angle_of_friction), TEST(disk_rolls_in_a_turning_drum),
          TEST(gaps_are_to_the_nearest_image))
