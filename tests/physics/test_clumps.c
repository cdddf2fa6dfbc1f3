/* Clumps: free motion, closed forms of collision and rocking, prescribed coordinates, edges of a
 * periodic box, energy budgets. Fields: test_clump_fields.c. */
#include "brief.h"
#include "clump_systems.h"
#include "deck_runs.h"

/* Of disks that are what they seem: neither scaled nor held. */
typedef struct momenta {
  double x, y, angular;
} momenta;
static momenta momenta_of(sd_simulation *s) {
  momenta p = {0};
  const sd_model *m = sd_simulation_model(s);
  for (uint32_t i = 0; i < m->n_disks; i++) {
    const system_body b = system_at(s, i);
    const sd_disk *d = &m->disks[i];
    p.x += d->mass * b.vx;
    p.y += d->mass * b.vy;
    p.angular += d->inertia * b.omega + d->mass * (b.x * b.vy - b.y * b.vx);
  }
  return p;
}

static void a_free_clump_keeps_its_momenta(void **unused) {
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_model *m =
        system_new((sd_integrator)integrator, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1e4});
    const uint32_t disks[] = {system_disk(m, 0.2, 0, 1, 1), system_disk(m, 1.7, 0.2, 0.7, 0.5),
                              system_disk(m, 1, 1, 0.3, 2)};
    add_clump(m, 3, disks, 0.3, 0.1, 2.0);
    sd_simulation *s = system_start(m);
    const sd_clump *c = clump_of(s, 0);
    double inertia = 0;
    for (int k = 0; k < 3; k++) {
      const sd_disk *d = &m->disks[disks[k]];
      inertia += d->mass * (d->radius * d->radius / 2 + pow(d->position[0] - c->position[0], 2) +
                            pow(d->position[1] - c->position[1], 2));
    }
    SYSTEM_NEAR(c->mass, 3.5, 1e-14, "mass");
    SYSTEM_NEAR(c->inertia, inertia, 1e-14 * inertia, "moment of inertia");
    const momenta before = momenta_of(s);
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.kinetic_translation + e.kinetic_rotation, 3.5 * 0.05 + inertia * 2, 1e-13,
                "energy");
    system_advance(s, 100000);
    const momenta after = momenta_of(s);
    SYSTEM_NEAR(after.x, before.x, 1e-12, "momentum along x");
    SYSTEM_NEAR(after.y, before.y, 1e-12, "momentum along y");
    SYSTEM_NEAR(after.angular, before.angular, 1e-11,
                "angular momentum"); /* 30 lengths from the origin */
    SYSTEM_NEAR(sd_simulation_energy(s).residual, 0, 1e-12, "energy");
    const system_body a = system_at(s, 0), b = system_at(s, 1);
    SYSTEM_NEAR(hypot(b.x - a.x, b.y - a.y), hypot(1.5, 0.2), 1e-13, "distance");
    SYSTEM_NEAR((double)a.theta, 200, 1e-9, "angle");
    /* 200 rad about the centre, which has gone its way */
    const double x = 0.2 - c->position[0], y = -c->position[1], cosine = cos(200), sine = sin(200);
    SYSTEM_NEAR(a.x, c->position[0] + 30 + cosine * x - sine * y, 1e-9, "place of a disk, x");
    SYSTEM_NEAR(a.y, c->position[1] + 10 + sine * x + cosine * y, 1e-9, "place of a disk, y");
    system_end(s);
  }
}

/* Two clumps collide with friction: the conservative variant keeps all momenta. */
static void a_collision_keeps_the_momenta(void **unused) {
  const sd_contact_law law = {.k_n = 1e5, .k_t = 1e5, .gamma_n = 2, .mu = 0.3};
  sd_model *m = system_new(SD_GEAR5, SD_CONSERVATIVE, 1e-5, law);
  add_dimer(m, 0, 0, 0.3, 0.8, 1, 1);
  add_dimer(m, 4.2, 0.9, 2.0, 0.5, 0.8, 0.7);
  m->clumps[0].velocity[SD_X] = 2;
  m->clumps[0].velocity[SD_THETA] = 3;
  sd_simulation *s = system_start(m);
  const momenta before = momenta_of(s);
  system_advance(s, 200000);
  const momenta after = momenta_of(s);
  const sd_energy e = sd_simulation_energy(s);
  assert_true(e.friction > 1e-3 && e.viscous > 1e-3);
  SYSTEM_NEAR(after.x, before.x, 1e-11, "momentum along x");
  SYSTEM_NEAR(after.y, before.y, 1e-11, "momentum along y");
  SYSTEM_NEAR(after.angular, before.angular, 1e-9, "angular momentum");
  SYSTEM_NEAR(e.residual, 0, 1e-7 * e.scale, "energy");
  system_end(s);
}

static size_t floor_at(sd_model *m, double y) {
  return system_straight(m, SD_WALL_LINE, 2, (const double[][2]){{-1, y}, {1, y}});
}

/* One end of a dimer falls on a smooth wall: the impulse J = 2 v/(1/M + l^2/I), l its arm, leaves v - J/M and J l/I. */
static void one_end_falls_on_a_wall(void **unused) {
  const double d = 0.8, radius = 1, mass = 0.5, v = 1, angle = 0.6, k = 1e9;
  const double M = 2 * mass, I = 2 * mass * (radius * radius / 2 + d * d), arm = -d * cos(angle);
  const double J = 2 * v / (1 / M + arm * arm / I),
               duration = M_PI * sqrt(1 / (1 / M + arm * arm / I) / k);
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_model *m = system_new((sd_integrator)integrator, SD_CONSERVATIVE, duration / 400,
                             (sd_contact_law){.k_n = k});
    add_dimer(m, 0, d * sin(angle) + radius + 1e-9, angle, d, radius, mass);
    m->clumps[0].velocity[SD_Y] = -v;
    floor_at(m, 0);
    sd_simulation *s = system_start(m);
    system_advance(s, 450);
    const sd_state *q = sd_simulation_state(s);
    assert_int_equal(q->n_contacts, 0);
    SYSTEM_NEAR(q->clump_vx[0], 0, 1e-12, "velocity along the wall");
    SYSTEM_NEAR(q->clump_vy[0], -v + J / M, 1e-4, "velocity");
    SYSTEM_NEAR(q->clump_omega[0], J * arm / I, 1e-4, "angular velocity");
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "energy");
    system_end(s);
  }
}

/* The mass in the damping of a restitution is that of the clump: a dimer that falls end-on leaves
 * at e v, as a disk beside it does. */
static void a_clump_leaves_with_its_restitution(void **unused) {
  const double d = 0.8, radius = 1, mass = 0.5, v = 1, k = 1e6, restitution = 0.5;
  const double duration = M_PI * sqrt(2 * mass / k);
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_model *m = system_new((sd_integrator)integrator, SD_PAPER, duration / 400,
                             (sd_contact_law){.k_n = k, .restitution = restitution});
    const uint32_t disk = system_disk(m, 9, radius + 1e-6, radius, mass);
    m->disks[disk].velocity[SD_Y] = -v;
    add_dimer(m, 0, d + radius + 1e-6, M_PI / 2, d, radius, mass);
    m->clumps[0].velocity[SD_Y] = -v;
    floor_at(m, 0);
    sd_simulation *s = system_start(m);
    system_advance(s, 900);
    assert_int_equal(sd_simulation_state(s)->n_contacts, 0);
    SYSTEM_NEAR(sd_simulation_state(s)->clump_vy[0], restitution * v, 2e-3,
                "velocity of the clump");
    SYSTEM_NEAR(system_at(s, disk).vy, restitution * v, 2e-3, "velocity of the disk");
    system_end(s);
  }
}

/* A round body rolls to and fro about its heavy side: w^2 = M g h/(I + M (R - h)^2), h from the middle to the centre of mass. */
static void a_tumbler_rocks(void **unused) {
  const double R = 1, mass = 0.3, heavy = 0.7, below = 0.6, g = 10, k = 1e8, turned = 0.01;
  const sd_contact_law law = {.k_n = k, .k_t = k, .mu = 100};
  const double M = mass + heavy, h = heavy * below / M, r = 0.2;
  const double I = mass * (R * R / 2 + h * h) + heavy * (r * r / 2 + (below - h) * (below - h));
  const double period = 2 * M_PI * sqrt((I + M * (R - h) * (R - h)) / (M * g * h));
  sd_model *m = system_new(SD_GEAR5, SD_CONSERVATIVE, 1e-5, law);
  m->gravity[SD_Y] = -g;
  const uint32_t disks[] = {
      system_disk(m, 0, R - M * g / k, R, mass),
      system_disk(m, below * sin(turned), R - M * g / k - below * cos(turned), r, heavy)};
  add_clump(m, 2, disks, 0, 0, 0);
  floor_at(m, 0);
  sd_simulation *s = system_start(m);
  double last = 0, crossed[4] = {0};
  int n = 0;
  for (int64_t step = 1; n < 4 && step < 2000000; step++) {
    system_advance(s, 1);
    const double now = (double)system_at(s, 0).theta + turned;
    if (last < 0 && now >= 0) crossed[n++] = ((double)step - now / (now - last)) * 1e-5;
    last = now;
  }
  assert_int_equal(n, 4);
  SYSTEM_NEAR((crossed[3] - crossed[0]) / 3, period, 1e-4 * period, "period");
  const sd_energy e = sd_simulation_energy(s);
  assert_true(e.friction == 0);
  SYSTEM_NEAR(e.residual, 0, 1e-7 * e.scale, "energy");
  system_end(s);
}

static sd_simulation *two_dimers(double shift) {
  const sd_contact_law law = {.k_n = 1e5, .k_t = 1e5, .gamma_n = 2, .mu = 0.3};
  sd_model *m = system_new(SD_GEAR5, SD_CONSERVATIVE, 1e-5, law);
  for (int c = 0; c < 2; c++) {
    m->periodic[c] = true;
    m->upper[c] = 10;
  }
  add_dimer(m, 3, 3, 0.3, 0.8, 1, 1);
  add_dimer(m, 7.2, 3.9, 2.0, 0.5, 0.8, 0.7);
  for (size_t i = 0; i < m->n_disks; i++)
    for (int c = 0; c < 2; c++) m->disks[i].position[c] = fmod(m->disks[i].position[c] + shift, 10);
  m->clumps[0].velocity[SD_X] = 2;
  m->clumps[0].velocity[SD_Y] = 0.1;
  m->clumps[0].velocity[SD_THETA] = 3;
  return system_start(m);
}

/* Where the edges are is no matter: the disks of one clump may stand on both sides. */
static void edges_of_a_periodic_box_are_not_felt(void **unused) {
  sd_simulation *a = two_dimers(0);
  int images = 0;
  system_advance(a, 400000);
  for (double shift = 1.7; shift < 10; shift += 2.9) {
    sd_simulation *b = two_dimers(shift);
    system_advance(b, 400000);
    const sd_state *p = sd_simulation_state(a), *q = sd_simulation_state(b);
    assert_true(sd_simulation_energy(b).friction > 1e-3);
    for (int k = 0; k < 2; k++) images += abs(q->clump_image_x[k]) + abs(q->clump_image_y[k]);
    for (int k = 0; k < 2; k++) {
      SYSTEM_NEAR(q->clump_vx[k], p->clump_vx[k], 1e-8, "velocity of clump %d, shifted by %g", k,
                  shift);
      SYSTEM_NEAR(q->clump_omega[k], p->clump_omega[k], 1e-8,
                  "angular velocity of clump %d, shifted by %g", k, shift);
    }
    for (size_t k = 0; k < 4;
         k++) { /* each disk is beside the others of its clump, images counted */
      const size_t c = k / 2;
      const double dx = q->x[k] + 10 * q->image_x[k] - q->clump_x[c] - 10 * q->clump_image_x[c];
      const double dy = q->y[k] + 10 * q->image_y[k] - q->clump_y[c] - 10 * q->clump_image_y[c];
      SYSTEM_NEAR(hypot(dx, dy), c ? 0.5 : 0.8, 1e-12, "distance from the centre");
    }
    const sd_energy e = sd_simulation_energy(b);
    SYSTEM_NEAR(e.residual, 0, 1e-7 * e.scale, "energy");
    system_end(b);
  }
  assert_true(images > 0);
  system_end(a);
}

/* Disks of a body of up to 0.7 of the box, each with its own mass, in any order, anywhere, along either axis. */
enum { MEMBERS = 4, ORDERS = 24 };
static const double bodies[][MEMBERS][3] = {
    {{0.5, 0, 0.2}, {1.7, 0, 0.2}, {2.9, 0, 0.2}, {2.9, 0.3, 0.2}},
    {{0, 0, 0.6}, {0.7, 0.1, 0.3}, {1.4, 0, 0.5}, {2.3, 0.1, 0.4}},
    {{0, 0, 0.8}, {0.9, 0, 0.1}, {-1.6, 0, 0.1}, {-0.5, 0.8, 0.1}}};

/* Element `place` of permutation `order` of four. */
static int permuted(int order, int place) {
  int left[MEMBERS] = {0, 1, 2, 3}, n = MEMBERS;
  for (int k = 0; k < place; k++, n--) {
    const int of = order % n;
    order /= n;
    for (int j = of; j + 1 < n; j++) left[j] = left[j + 1];
  }
  return left[order % n];
}

static sd_model *body_of(int body, int axis, double shift, int order, bool periodic) {
  sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1e3});
  uint32_t disks[MEMBERS];
  for (int c = 0; c < 2; c++) {
    m->periodic[c] = periodic;
    m->upper[c] = 4;
  }
  for (int k = 0; k < MEMBERS; k++) {
    const int of = permuted(order, k);
    double at[2];
    for (int c = 0; c < 2; c++) {
      at[c] = bodies[body][of][axis ? 1 - c : c] + (c == axis ? shift : 1.3);
      if (periodic) at[c] -= 4 * floor(at[c] / 4);
    }
    disks[k] = system_disk(m, at[0], at[1], bodies[body][of][2], 1 + 0.3 * of);
  }
  add_clump(m, MEMBERS, disks, 0.3, 0.2, 1);
  return m;
}

static void the_shape_does_not_depend_on_the_order(void **unused) {
  for (int body = 0; body < 3; body++)
    for (int axis = 0; axis < 2; axis++) {
      sd_model *free_one = body_of(body, axis, 0, 0, false);
      sd_simulation *open = system_start(free_one);
      const double inertia = free_one->clumps[0].inertia,
                   radius = clumps_grain(free_one, 0, MEMBERS).radius;
      system_end(open);
      for (int order = 0; order < ORDERS; order++)
        for (double shift = 0; shift < 4; shift += 0.75) {
          sd_model *m = body_of(body, axis, shift, order, true);
          sd_simulation *s = system_start(m);
          SYSTEM_NEAR(m->clumps[0].inertia, inertia, 1e-12 * inertia, "body %d, order %d, shift %g",
                      body, order, shift);
          SYSTEM_NEAR(clumps_grain(m, 0, MEMBERS).radius, radius, 1e-12, "the circle around it");
          if (order % 5 == 0) system_advance(s, 100);
          const sd_state *q = sd_simulation_state(s);
          for (size_t k = 0; k < MEMBERS; k++) { /* distances within the body, images counted */
            const int of = permuted(order, (int)q->id[k]), first = permuted(order, (int)q->id[0]);
            const double dx = q->x[k] + 4 * q->image_x[k] - q->x[0] - 4 * q->image_x[0],
                         dy = q->y[k] + 4 * q->image_y[k] - q->y[0] - 4 * q->image_y[0];
            const double *p = bodies[body][of], *o = bodies[body][first];
            SYSTEM_NEAR(hypot(dx, dy), hypot(p[0] - o[0], p[1] - o[1]), 1e-12, "distance");
          }
          system_end(s);
        }
    }
}

/* Disks as far apart around the box as within it have no shape. */
static void a_body_that_closes_around_the_box_is_refused(void **unused) {
  for (int axis = 0; axis < 2; axis++)
    for (int held = 0; held < 2; held++) {
      sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1e3});
      uint32_t disks[4];
      for (int c = 0; c < 2; c++) m->periodic[c] = true, m->upper[c] = 4;
      for (int k = 0; k < 4; k++)
        disks[k] = system_disk(m, axis ? 1 : 0.3 + k, axis ? 0.3 + k : 1, 0.1, 1);
      add_clump(m, 4, disks, 0, 0, 0);
      m->clumps[0].locked[SD_THETA] = held != 0;
      m->phases = calloc(1, sizeof *m->phases);
      m->phases[0].steps = m->n_phases = 1;
      sd_messages *messages = sd_messages_new();
      assert_int_equal(sd_model_finish(m, messages), held ? SD_OK : SD_ERROR_USER);
      if (!held)
        assert_string_equal(
            sd_messages_text(messages, 0),
            axis ? "clump 0: it closes around the periodic box in y: expected locked = \"theta\""
                 : "clump 0: it closes around the periodic box in x: expected locked = \"theta\"");
      sd_messages_free(messages);
      sd_model_free(m);
    }
}

/* A rough plate with mass lies on three disks that stick to the floor, and is pulled along x at a given speed. */
static void a_plate_is_dragged(void **unused) {
  const sd_contact_law law = {.k_n = 1e5, .k_t = 1e5, .gamma_n = 20, .mu = 0.3};
  const double mass = 5, g = 10;
  sd_model *m = system_new(SD_GEAR5, SD_CONSERVATIVE, 1e-5, law);
  uint32_t plate[9];
  m->gravity[SD_Y] = -g;
  for (int k = 0; k < 4; k++) system_disk(m, -3 + 2 * k, 0.999, 1, 1);
  for (int k = 0; k < 9; k++) plate[k] = system_disk(m, -3.9 + k, 2.5 - 1e-4, 0.5, 0.1);
  const sd_clump c = {.n_disks = 9, .disks = plate, .mass = mass, .locked = {false, false, true}};
  system_move(m, sd_model_add_clump(m, &c), SD_X, 0.5);
  floor_at(m, 0);
  sd_simulation *s = system_start(m);
  const double x = system_at(s, plate[0]).x;
  double pull = 0;
  for (int64_t k = 0; k < 100000; k++) {
    system_advance(s, 1);
    pull += sd_simulation_state(s)->clump_force_x[0] * 0.5 * 1e-5;
  }
  const sd_state *q = sd_simulation_state(s);
  SYSTEM_NEAR(system_at(s, plate[0]).x, x + 0.5, 1e-12, "way of the plate");
  SYSTEM_NEAR(q->clump_theta[0], 0, 0, "its angle");
  const sd_energy e = sd_simulation_energy(s);
  assert_true(e.friction > 1e-3);
  SYSTEM_NEAR(e.work, -pull, 2e-3 * fabs(pull),
              "work of the plate"); /* against the rectangle rule */
  SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "energy");
  system_end(s);
}

static const char *const heap = "gravity = { g = 9.81; }; contact_variant = \"conservative\"; "
                                "materials = ( { name = \"m\"; k_n = 2e4; k_t = 1e4; gamma_n = "
                                "0.5; mu = 0.5; } ); container = { type = \"box\"; width = 1.5; "
                                "height = 1.2; open = true; };\n"
                                "packings = ( { type = \"square\"; count = 1000; spacing = 0.04; "
                                "sizes = \"uniform\"; lower = 0.008; upper = 0.011; density = "
                                "40.0; clump = { at = ([-0.8, 0.0], [0.8, 0.0]); }; } );\n";

static sd_model *heap_of(double dt, const char *more) {
  text t = {0};
  text_add(&t, "dt = %g; %s %s", dt, heap, more);
  return model_of_text(&t);
}

static void a_packing_closes_its_budget(void **unused) {
  double residual[2];
  const int64_t steps = BRIEF(20000, 500);
  for (int k = 0; k < 2; k++) {
    sd_model *m = heap_of(k ? 1e-5 : 2e-5, "time = 0.4;");
    sd_simulation *s = begin_run(m, 1);
    advance(s, k ? 2 * steps : steps);
    const sd_energy e = sd_simulation_energy(s);
    assert_int_equal(sd_model_clumps(m), 1000);
    residual[k] = fabs(e.residual) / e.scale;
    print_message("  dt %g: residual/scale %.2g, friction/scale %.2g, %zu contacts\n", m->dt,
                  residual[k], e.friction / e.scale, sd_simulation_state(s)->n_contacts);
    assert_true(steps < 20000 ||
                (e.friction > 0.01 * e.scale && sd_simulation_state(s)->n_contacts > 500));
    end_run(s, m);
  }
  assert_true(steps < 20000 || (residual[1] < 1e-6 && residual[1] < 0.5 * residual[0]));
}

/* A disk that names a clump which does not exist is a disk of its own. */
static void clumps_that_are_not_are_none(void **unused) {
  const int names[] = {-1, 2, 1000};
  for (size_t k = 0; k < 3; k++) {
    sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = 1e4});
    const uint32_t disk = system_disk(m, 9, 0, 1, 1);
    add_dimer(m, 0, 0, 0, 0.5, 1, 1);
    m->disks[disk].clump = names[k];
    m->disks[disk].velocity[SD_X] = 1;
    sd_simulation *s = system_start(m);
    assert_int_equal(m->disks[disk].clump, 0);
    system_advance(s, 100);
    SYSTEM_NEAR(system_at(s, disk).x, 9.1, 1e-12, "x");
    system_end(s);
  }
}

RUN_TESTS(TEST(a_free_clump_keeps_its_momenta), TEST(a_collision_keeps_the_momenta),
          TEST(one_end_falls_on_a_wall), TEST(a_clump_leaves_with_its_restitution),
          TEST(a_tumbler_rocks), TEST(edges_of_a_periodic_box_are_not_felt),
          TEST(the_shape_does_not_depend_on_the_order),
          TEST(a_body_that_closes_around_the_box_is_refused), TEST(a_plate_is_dragged),
          TEST(a_packing_closes_its_budget), TEST(clumps_that_are_not_are_none))
