/* test_bonds_energy.c: energy of bonded clusters with and without breaks, and what they keep while
 * they spin; stiff bonds make a rigid body. */
#include "bonds.h"
#include "brief.h"

/* --- a cluster -------------------------------------------------------------------------------- */

enum { CLUSTER = 7, CLUSTER_BONDS = 12 };

/* A disk in the middle and six around it, of unequal radii, with gaps, which fly apart or whirl. */
static sd_simulation *cluster_of(const law *l, int i, int v, double dt, double speed) {
  uint64_t seed = 5;
  text t = {0};
  bonds_deck(&t, (sd_integrator)i, (sd_variant)v, dt, l);
  text_add(&t, "disks = ( ");
  for (int k = 0; k < CLUSTER; k++) {
    const double angle = M_PI / 3 * k, far = k ? 1 : 0, radius = 0.42 + 0.06 * next_uniform(&seed);
    char more[200];
    snprintf(more, sizeof more, "vx = %.17g; vy = %.17g; omega = %.17g;",
             speed * (next_uniform(&seed) - 0.5), speed * (next_uniform(&seed) - 0.5),
             2 * speed * (next_uniform(&seed) - 0.5));
    bonds_disk(&t, k == 0, (double[]){far * cos(angle), far * sin(angle)}, radius, radius * radius,
               more);
  }
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), CLUSTER_BONDS);
  return s;
}

static const law elastic = {.k_n = 500,
                            .bond_k_n = 700,
                            .bond_k_t = 300,
                            .bond_k_r = 250,
                            .bond_gap = 0.16,
                            .bond_extension = 0.5};

static law viscous(void) {
  law l = elastic;
  l.bond_gamma_n = l.bond_gamma_t = 0.8;
  l.bond_gamma_r = 0.5;
  return l;
}

static double relative_residual(sd_simulation *s) {
  const sd_energy e = sd_simulation_energy(s);
  return fabs(e.residual) / e.start;
}

/* Largest residual at some moments until the time is up. */
static double largest_residual(const law *l, int i, int v, double dt, double speed, double time,
                               sd_energy *end, size_t *breaks) {
  sd_simulation *s = cluster_of(l, i, v, dt, speed);
  double worst = 0;
  for (int k = 0; k < 50; k++) {
    system_advance(s, (int64_t)nearbyint(time / 50 / dt));
    worst = fmax(worst, relative_residual(s));
  }
  *end = sd_simulation_energy(s);
  *breaks = sd_simulation_state(s)->n_breaks;
  assert_int_equal(*breaks + bonds_left(s), CLUSTER_BONDS);
  system_end(s);
  return worst;
}

static void whole(void **unused) {
  for (int damped = 0; damped < 2; damped++)
    for (int i = 0; i < 2; i++)
      for (int v = 0; v < 2; v++) {
        const law l = damped ? viscous() : elastic;
        double worst[2];
        sd_energy e;
        size_t breaks;
        for (int half = 0; half < 2; half++)
          worst[half] = largest_residual(&l, i, v, 4e-4 / (1 << half), 0.3, 4, &e, &breaks);
        print_message("%s, %s, %s: residual %.1e, %.1e at half the step; lost %.3f of %.3f\n",
                      system_integrators[i], system_variants[v], damped ? "dashpots" : "springs",
                      worst[0], worst[1], e.viscous, e.start);
        assert_int_equal(breaks, 0);
        SYSTEM_NEAR(worst[0], 0, 1e-3, "residual");
        assert_true(damped ? e.viscous > 0.5 * e.start : fabs(e.viscous) < 1e-12 * e.start);
        between(worst[0] / worst[1], 3.8, 4.4, "order of the residual");
      }
}

/* --- breaks ----------------------------------------------------------------------------------- */

static double springs_of(const law *l, const bond_displacement *u) {
  return 0.5 * (l->bond_k_n * u->n * u->n + l->bond_k_t * u->t * u->t + l->bond_k_r * u->r * u->r);
}

/* What a run with breaks shows: the largest residual; by how much the energy of its broken bonds
 * is off what the springs
 * held by positions, over that; breaks by mode. */
typedef struct breaking {
  double residual, off;
  size_t breaks;
  double by_mode[4];
} breaking;

static breaking break_cluster(const law *l, int i, int v, double dt, double speed, double time) {
  sd_simulation *s = cluster_of(l, i, v, dt, speed);
  const sd_state *q = sd_simulation_state(s);
  tracked_bond bonds[CLUSTER_BONDS];
  for (size_t k = 0, n = 0; k < q->n_contacts; k++)
    if (q->contact_bond[k] > 0) bonds[n++] = bond_track(s, q->contact_a[k], q->contact_b[k]);
  breaking b = {0};
  double held = 0, sum = 0;
  for (int64_t step = 0; step < (int64_t)(time / dt); step++) {
    system_advance(s, 1);
    for (size_t k = 0; k < CLUSTER_BONDS; k++) { /* also follows their direction */
      const bond_displacement u = bond_now(s, &bonds[k]);
      for (; b.breaks < q->n_breaks; b.breaks++) {
        const double row = q->break_energy[b.breaks];
        for (size_t j = 0; j < CLUSTER_BONDS; j++) {
          const uint32_t low = bonds[j].a < bonds[j].b ? bonds[j].a : bonds[j].b;
          if (low != q->break_a[b.breaks] || bonds[j].a + bonds[j].b - low != q->break_b[b.breaks])
            continue;
          const bond_displacement at = bond_now(s, &bonds[j]);
          held += springs_of(l, &at);
          sum += row;
          b.off += fabs(row - springs_of(l, &at));
          b.by_mode[q->break_mode[b.breaks]] += row;
        }
      }
      (void)u;
    }
    b.residual = fmax(b.residual, relative_residual(s));
  }
  const sd_energy e = sd_simulation_energy(s);
  SYSTEM_NEAR(sum, bonds_broken_energy(&e), 1e-12 * e.start, "losses of all bonds that broke");
  SYSTEM_NEAR(b.by_mode[1], e.broken_tension, 1e-12 * e.start, "by tension");
  SYSTEM_NEAR(b.by_mode[2], e.broken_shear, 1e-12 * e.start, "by shear");
  SYSTEM_NEAR(b.by_mode[3], e.broken_bending, 1e-12 * e.start, "by bending");
  b.off /= held;
  assert_int_equal(b.breaks + bonds_left(s), CLUSTER_BONDS);
  system_end(s);
  return b;
}

static void broken(void **unused) {
  for (int damped = 0; damped < 2; damped++)
    for (int i = 0; i < 2; i++)
      for (int v = 0; v < 2; v++) {
        law l = damped ? viscous() : elastic;
        l.bond_max_tension = 6;
        l.bond_max_shear = 6;
        l.bond_max_bending = 0.5;
        breaking b[2];
        for (int half = 0; half < 2; half++)
          b[half] = break_cluster(&l, i, v, 1e-4 / (1 << half), 3, 2);
        print_message("%s, %s, %s: %zu breaks, residual %.1e, %.1e at half the step; what they "
                      "held is off by %.1e, %.1e\n",
                      system_integrators[i], system_variants[v], damped ? "dashpots" : "springs",
                      b[0].breaks, b[0].residual, b[1].residual, b[0].off, b[1].off);
        assert_true(b[0].breaks > 3);
        /* Gear's polynomials do not know the jump of a force: first order in dt */
        SYSTEM_NEAR(b[0].residual, 0, i == SD_VERLET ? 1e-5 : 1e-3, "residual with breaks");
        between(b[0].residual / b[1].residual, i == SD_VERLET ? 3.5 : 1.6, 4.5, "its order");
        SYSTEM_NEAR(b[0].off, 0, 0.03, "energy of bonds that broke");
        between(b[0].off / b[1].off, 1.6, 2.5, "its order");
      }
}

/* --- beside a contact ------------------------------------------------------------------------- */

/* The surfaces of the cluster touch and part again and again while their bonds last. */
static sd_simulation *rattling(const law *l, int i, int v, double dt) {
  uint64_t seed = 8;
  text t = {0};
  bonds_deck(&t, (sd_integrator)i, (sd_variant)v, dt, l);
  text_add(&t, "disks = ( ");
  for (int k = 0; k < CLUSTER; k++) {
    const double angle = M_PI / 3 * k, far = k ? 1.0005 : 0;
    char more[200];
    snprintf(more, sizeof more, "vx = %.17g; vy = %.17g; omega = %.17g;",
             0.1 * (next_uniform(&seed) - 0.5), 0.1 * (next_uniform(&seed) - 0.5),
             next_uniform(&seed) - 0.5);
    bonds_disk(&t, k == 0, (double[]){far * cos(angle), far * sin(angle)}, 0.5, 0.25, more);
  }
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), CLUSTER_BONDS);
  return s;
}

static void beside_contacts(void **unused) {
  const law plain = {.k_n = 800,
                     .k_t = 400,
                     .mu = 0.3,
                     .bond_k_n = 300,
                     .bond_k_t = 200,
                     .bond_k_r = 150,
                     .bond_gap = 0.01,
                     .bond_extension = 0.5};
  static const char *const kinds[] = {"springs",    "dashpots",  "Mindlin", "rolling resistance",
                                      "bond_alone", "attraction"};
  for (int kind = 0; kind < 6; kind++)
    for (int i = 0; i < 2; i++)
      for (int v = 0; v < 2; v++) {
        law l = plain;
        if (kind == 1) l.gamma_n = 2, l.gamma_t = 1, l.bond_gamma_n = 0.5;
        if (kind == 2)
          l.normal = SD_NORMAL_HERTZ, l.tangential = SD_TANGENTIAL_MINDLIN, l.k_n = l.k_t = 2e4;
        if (kind == 3) l.k_r = 200, l.mu_r = 0.1, l.gamma_r = 0.3;
        if (kind == 4) l.bond_alone = true;
        if (kind == 5) l.cohesion = SD_COHESION_CONSTANT, l.pull_off = 0.1, l.range = 0.002;
        double worst[2] = {0};
        sd_energy e;
        for (int half = 0; half < 2; half++) {
          const double dt = 2e-4 / (1 << half);
          sd_simulation *s = rattling(&l, i, v, dt);
          for (int k = 0; k < 50; k++) {
            system_advance(s, (int64_t)nearbyint(0.04 / dt));
            worst[half] = fmax(worst[half], relative_residual(s));
          }
          e = sd_simulation_energy(s);
          assert_int_equal(bonds_left(s), CLUSTER_BONDS);
          system_end(s);
        }
        print_message("%s, %s, %s: residual %.1e, %.1e at half the step; friction took %.2f\n",
                      system_integrators[i], system_variants[v], kinds[kind], worst[0], worst[1],
                      e.friction / e.start);
        SYSTEM_NEAR(worst[0], 0, 1e-4, "residual beside contacts");
        between(worst[0] / worst[1], 3.6, 4.5, "order of the residual");
        assert_true(l.bond_alone ? e.friction == 0 : e.friction > 0.2 * e.start);
      }
}

/* --- thousand turns --------------------------------------------------------------------------- */

enum { SPINNER = 3 };

/* A triangle of unequal disks, which turns once in the time 1; it does not breathe much. */
static sd_simulation *spinner(const law *l, int i, double dt, const double radius[SPINNER]) {
  const double length = 1, w = 2 * M_PI, at[SPINNER][2] = {{0, 0}, {length, 0}, {0.5, sqrt(0.75)}};
  double center[2] = {0}, mass = 0;
  text t = {0};
  for (int k = 0; k < SPINNER; k++) {
    const double m = radius[k] * radius[k];
    mass += m;
    for (int c = 0; c < 2; c++) center[c] += m * at[k][c];
  }
  bonds_deck(&t, (sd_integrator)i, SD_CONSERVATIVE, dt, l);
  text_add(&t, "disks = ( ");
  for (int k = 0; k < SPINNER; k++) {
    char more[200];
    snprintf(more, sizeof more, "vx = %.17g; vy = %.17g; omega = %.17g;",
             -w * (at[k][1] - center[1] / mass), w * (at[k][0] - center[0] / mass), w);
    bonds_disk(&t, k == 0, at[k], radius[k], radius[k] * radius[k], more);
  }
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  return laws_begin(&t, false);
}

static double angular_momentum(sd_simulation *s, const double radius[SPINNER]) {
  double sum = 0;
  for (uint32_t k = 0; k < SPINNER; k++) {
    const system_body b = system_at(s, k);
    const double m = radius[k] * radius[k];
    sum += m * (b.x * b.vy - b.y * b.vx) + 0.5 * m * radius[k] * radius[k] * b.omega;
  }
  return sum;
}

/* Extremes over some turns. */
typedef struct turns {
  double residual, extension, momentum, forces;
} turns;

static turns turn_on(sd_simulation *s, const law *l, tracked_bond bonds[SPINNER], int64_t steps,
                     int n, const double radius[SPINNER], double momentum) {
  turns q = {0};
  const sd_state *state = sd_simulation_state(s);
  for (int k = 0; k < n; k++) {
    system_advance(s, steps);
    q.residual = fmax(q.residual, relative_residual(s));
    q.momentum = fmax(q.momentum, fabs(angular_momentum(s, radius) / momentum - 1));
    for (int j = 0; j < SPINNER; j++) {
      const bond_displacement u = bond_now(s, &bonds[j]);
      q.extension = fmax(q.extension, fabs(u.n));
      q.forces = fmax(q.forces, fabs(state->contact_bond_pull[j] - l->bond_k_n * u.n));
      q.forces = fmax(q.forces, fabs(state->contact_bond_shear[j] - l->bond_k_t * u.t));
      q.forces = fmax(q.forces, fabs(state->contact_bond_bend[j] - l->bond_k_r * u.r));
    }
  }
  return q;
}

static void thousand_turns(void **unused) {
  const double radius[SPINNER] = {0.45, 0.4, 0.48};
  law l = elastic;
  l.bond_k_n = 8e3, l.bond_k_t = 5e3, l.bond_k_r = 4e3;
  for (int i = 0; i < 2; i++) {
    const int64_t eighth = 250;
    const int turns_made = BRIEF(1000, 120);
    sd_simulation *s = spinner(&l, i, 0.125 / (double)eighth, radius);
    const sd_state *state = sd_simulation_state(s);
    tracked_bond bonds[SPINNER];
    assert_int_equal(bonds_left(s), SPINNER);
    for (int k = 0; k < SPINNER; k++)
      bonds[k] = bond_track(s, state->contact_a[k], state->contact_b[k]);
    const double momentum = angular_momentum(s, radius);
    const turns first = turn_on(s, &l, bonds, eighth, 400, radius, momentum);
    turn_on(s, &l, bonds, eighth, 8 * (turns_made - 100), radius, momentum);
    const turns last = turn_on(s, &l, bonds, eighth, 400, radius, momentum);
    const double turned = (double)(system_at(s, 0).theta / (2 * M_PI));
    print_message("%s, %.0f turns: residual %.1e, %.1e in the last 50; extension %.2e, %.2e; "
                  "angular momentum %.1e; "
                  "forces from positions %.1e of %.2f\n",
                  system_integrators[i], turned, first.residual, last.residual, first.extension,
                  last.extension, last.momentum, last.forces, l.bond_k_n * last.extension);
    assert_true(fabs(turned - turns_made) < 2);
    const bool verlet = i == SD_VERLET;
    SYSTEM_NEAR(last.residual, 0, verlet ? 1.1 * first.residual : 3e-4, "energy in the last turns");
    SYSTEM_NEAR(last.extension, first.extension, (verlet ? 0.1 : 0.3) * first.extension, "shape");
    SYSTEM_NEAR(last.momentum, 0, verlet ? 1e-12 : 2e-7, "angular momentum");
    SYSTEM_NEAR(last.forces, 0, verlet ? 5e-8 : 2e-5, "forces from positions");
    system_end(s);
  }
}

/* --- a rigid body ----------------------------------------------------------------------------- */

/* A triangle of disks bounces over the floor: bonded, or as a clump with the same velocities. */
static sd_simulation *bouncing(const law *l, double dt, bool clump) {
  const double at[SPINNER][2] = {{0, 1}, {0.9, 1.2}, {0.3, 1.9}},
               radius[SPINNER] = {0.45, 0.4, 0.48}, velocity[3] = {0.7, -0.4, 1.3};
  double center[2] = {0}, mass = 0;
  text t = {0};
  for (int k = 0; k < SPINNER; k++) {
    const double m = radius[k] * radius[k];
    mass += m;
    for (int c = 0; c < 2; c++) center[c] += m * at[k][c];
  }
  bonds_deck(&t, SD_VERLET, SD_CONSERVATIVE, dt, l);
  text_add(&t, "gravity = { g = 2; }; walls = ( { type = \"line\"; points = ( (-1, 0), (1, 0) ); } "
               ");\ndisks = ( ");
  for (int k = 0; k < SPINNER; k++) {
    char more[200] = "";
    if (!clump)
      snprintf(more, sizeof more, "group = \"bonded\"; vx = %.17g; vy = %.17g; omega = %.17g;",
               velocity[0] - velocity[2] * (at[k][1] - center[1] / mass),
               velocity[1] + velocity[2] * (at[k][0] - center[0] / mass), velocity[2]);
    bonds_disk(&t, k == 0, at[k], radius[k], radius[k] * radius[k], more);
  }
  text_add(&t, " );\n");
  if (clump)
    text_add(&t,
             "steps = 1e15; clumps = ( { disk = (0, 1, 2); velocity = (%.17g, %.17g); omega = "
             "%.17g; } );\n",
             velocity[0], velocity[1], velocity[2]);
  else
    text_add(&t, "phases = ( { steps = 1e15; bond = { group = \"bonded\"; }; } );\n");
  return laws_begin(&t, false);
}

/* Largest distance of a disk, or of a point at its edge as it turns, from where the clump has
 * it. */
static double off_clump(double stiffness, double dt, double time, size_t *touches) {
  law l = elastic;
  l.k_n = 300, l.k_t = 200, l.mu = 0.4, l.gamma_n = 1;
  l.bond_k_n = stiffness, l.bond_k_t = 0.6 * stiffness, l.bond_k_r = 0.5 * stiffness;
  sd_simulation *bonded = bouncing(&l, dt, false), *rigid = bouncing(&l, dt, true);
  assert_int_equal(bonds_left(bonded), SPINNER);
  double worst = 0;
  for (int k = 0; k < 100; k++) {
    system_advance(bonded, (int64_t)nearbyint(time / 100 / dt));
    system_advance(rigid, (int64_t)nearbyint(time / 100 / dt));
    *touches += sd_simulation_state(rigid)->n_contacts > 0;
    for (uint32_t j = 0; j < SPINNER; j++) {
      const system_body a = system_at(bonded, j), b = system_at(rigid, j);
      worst = fmax(worst, hypot(hypot(a.x - b.x, a.y - b.y), 0.4 * (double)(a.theta - b.theta)));
    }
  }
  system_end(bonded);
  system_end(rigid);
  return worst;
}

static void rigid(void **unused) {
  double off[3];
  size_t touches = 0;
  for (int k = 0; k < 3; k++) off[k] = off_clump(1e4 * pow(8, k), 1e-4 / (1 << k), 4, &touches);
  print_message("bonds of stiffness 1, 8, 64 off a clump: %.2e %.2e %.2e; it touches the floor in "
                "%zu of 300\n",
                off[0], off[1], off[2], touches);
  assert_true(touches > 20);
  SYSTEM_NEAR(off[2], 0, 3e-3, "bonded disks and a clump");
  between(off[0] / off[2], 30, 150, "limit of stiff bonds, 64 times as stiff");
}

/* --- changes on the way ----------------------------------------------------------------------- */

/* A stiffness or a radius changes while bonds hold: the change of the energy is work. */
static void steered(void **unused) {
  static const char *const names[] = {"law.bond_k_n", "law.bond_k_t", "law.bond_k_r", "radius"};
  for (int n = 0; n < 4; n++)
    for (int i = 0; i < 2; i++) {
      double worst[2] = {0};
      for (int half = 0; half < 2; half++) {
        const double dt = 2e-4 / (1 << half);
        sd_simulation *s = cluster_of(&elastic, i, SD_CONSERVATIVE, dt, 0.3);
        sd_model *model = (sd_model *)(uintptr_t)sd_simulation_model(s);
        for (int k = 0; k < 20; k++) {
          system_advance(s, (int64_t)nearbyint(0.05 / dt));
          const double value = n == 3 ? 0.45 + 0.002 * (k % 3) : 300 + 40 * (k % 5);
          const uint32_t first = 0;
          sd_messages *m = sd_messages_new();
          assert_int_equal(sd_simulation_set(s, names[n], 1, &first, &value, m), SD_OK);
          sd_messages_free(m);
          worst[half] = fmax(worst[half], relative_residual(s));
        }
        end_run(s, model);
      }
      print_message("%s steered, %s: residual %.1e, %.1e at half the step\n", names[n],
                    system_integrators[i], worst[0], worst[1]);
      SYSTEM_NEAR(worst[0], 0, n == 3 ? 5e-3 : 1e-4, "residual");
      between(worst[0] / worst[1], 3.6, 4.5, "order of the residual");
    }
}

RUN_TESTS(TEST(whole), TEST(broken), TEST(beside_contacts), TEST(thousand_turns), TEST(rigid),
          TEST(steered))
