/* test_disk_means.c: means of every free disk: known rotations, a recount step by step, powers against the energy
 * budget, the same bits however a run is cut or shared, and error bars against records whose true error is known. */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "deck_runs.h"
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/measure.h"

#define LAW "materials = ( { name = \"m\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"
enum { MOST = 200 };

static void means_of(sd_simulation *sim, sd_disk_mean *means, sd_disk_totals *totals) {
  const sd_model *m = sd_simulation_model(sim);
  const sd_state *s = sd_simulation_state(sim);
  assert_true(s->n_means > 0 && s->n_means <= MOST);
  for (size_t i = 0; i < s->n_means; i++) means[i] = sd_disk_mean_of(m, s, i);
  *totals = sd_disk_totals_of(m, s, means);
}

static sd_simulation *run_of(const char *deck, sd_disk_mean *means, sd_disk_totals *totals) {
  sd_model *m = model_of(deck);
  sd_simulation *sim = begin_run(m, 1);
  advance(sim, sd_model_steps(m));
  assert_true(sd_simulation_finished(sim));
  means_of(sim, means, totals);
  return sim;
}

static void end_of(sd_simulation *sim) {
  sd_model *m = (sd_model *)(uintptr_t)sd_simulation_model(sim);
  end_run(sim, m);
}

/* Disks that fly and spin without touching: everything is known; what happens between the measured phases is left
 * out of angles, and positions are absolute. */
static void free_disks(void **unused) {
  sd_disk_mean d[MOST];
  sd_disk_totals t;
  sd_simulation *sim = run_of(
      "integrator = \"verlet\"; dt = 1e-3; box = { x = (0, 10); y = (0, 10); periodic = \"x\"; "
      "};\n" LAW "disks = ( { x = 9; y = 1; vx = 3; omega = 2; radius = 0.1; mass = 2; },\n"
      "  { x = 5; y = 3; omega = -5; radius = 0.2; mass = 1; }, { x = 5; y = 5; "
      "radius = 0.3; mass = 1; },\n"
      "  { x = 5; y = 8; radius = 0.3; mass = 1; fixed = true; } );\n"
      "phases = ( { steps = 300; }, { steps = 1000; measure = true; }, { steps = 500; "
      "}, { steps = 2000; measure = true; } );\n"
      "measure = { disks = true; rotation = (0, 1, 2); };\n",
      d, &t);
  const sd_state *s = sd_simulation_state(sim);
  const double omega[] = {2, -5, 0};
  assert_int_equal(s->n_means, 3);
  assert_int_equal(s->mean_samples, 3000);
  assert_int_equal(s->mean_bin_steps, 32);
  assert_int_equal(s->mean_bins, 93);
  for (size_t i = 0; i < 3; i++) {
    assert_int_equal(d[i].disk, i);
    between(d[i].omega - omega[i], -1e-11, 1e-11, "Omega");
    between(d[i].first - omega[i], -1e-11, 1e-11, "Omega, first half");
    between(d[i].second - omega[i], -1e-11, 1e-11, "Omega, second half");
    between(d[i].error, 0, 1e-11, "its error");
    between(d[i].turned - 93 * 0.032 * omega[i], -1e-11, 1e-11, "angle turned in full bins");
    between(d[i].rotation, 0.25 * s->mass[i] * pow(s->radius[i] * omega[i], 2) * (1 - 1e-12),
            0.25 * s->mass[i] * pow(s->radius[i] * omega[i], 2) * (1 + 1e-12),
            "energy of rotation");
    assert_true(isnan(d[i].sliding) && isnan(d[i].force));
    assert_true(d[i].coordination == 0 && d[i].openings == 0 && d[i].injected == 0);
  }
  assert_true(d[2].significance == 0 && d[2].rms == 0 && d[2].displacement == 0);
  assert_true(d[0].significance > 3 && d[1].significance < -3);
  /* measuring began at t = 0.3, x = 9.9; looks at 0.301 ... 1.3 and 1.801 ... 3.8 */
  double sum = 0, square = 0;
  for (int k = 301; k <= 3800; k++)
    if (k <= 1300 || k > 1800) sum += 9 + 3e-3 * k, square += pow(9 + 3e-3 * k, 2);
  between(d[0].x - sum / 3000, -1e-11, 1e-11, "mean x");
  between(d[0].y - 1, -1e-13, 1e-13, "mean y");
  between(d[0].rms - sqrt(square / 3000 - pow(sum / 3000, 2)), -1e-10, 1e-10, "rms displacement");
  between(d[0].displacement - 3 * 3.5, -1e-11, 1e-11, "displacement");
  between(d[0].translation - 9, -1e-11, 1e-11, "energy of translation");
  between(t.significant - 2. / 3, -1e-15, 1e-15, "significant");
  between(t.omega_mean + 1, -1e-11, 1e-11, "mean of Omega");
  between(t.omega_rms - sqrt(29. / 3), -1e-11, 1e-11, "rms of Omega");
  between(t.omega_median - 2, -1e-11, 1e-11, "median of |Omega|");
  between(t.persistence, 1 - 1e-12, 1 + 1e-12, "persistence");
  between(t.persistence_rank, 1 - 1e-12, 1 + 1e-12, "persistence of ranks");
  assert_true(isnan(t.neighbours));
  end_of(sim);
}

/* A train of equal gears behind a driven one: neighbours turn against each other. */
static void gears(void **unused) {
  sd_disk_mean d[MOST];
  sd_disk_totals t;
  sd_simulation *sim = run_of(
      "dt = 1e-4;\n" LAW
      "disks = ( { name = \"engine\"; x = 0; y = 0; radius = 0.5; mass = 1; fixed = true; },\n"
      "  { x = 0.999; y = 0; omega = -3; radius = 0.5; mass = 1; locked = (\"x\", \"y\"); },\n"
      "  { x = 1.998; y = 0; omega = 3; radius = 0.5; mass = 1; locked = (\"x\", \"y\"); },\n"
      "  { x = 2.997; y = 0; omega = -3; radius = 0.5; mass = 1; locked = (\"x\", \"y\"); } );\n"
      "motions = ( { disk = \"engine\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 3; "
      "} );\n"
      "phases = ( { steps = 20000; } ); measure = { disks = true; every = 10; rotation = (); };\n",
      d, &t);
  for (size_t i = 0; i < 3; i++) {
    double omega = i == 1 ? 3 : -3;
    between(d[i].omega - omega, -1e-8, 1e-8, "Omega of a gear");
    between(d[i].coordination - (i == 2 ? 1 : 2), -1e-14, 1e-14, "contacts of a gear");
    between(d[i].force - 10, -1e-8, 1e-8, "normal force of a gear");
    assert_true(d[i].sliding == 0);
  }
  between(t.neighbours, -1 - 1e-8, -1 + 1e-8, "neighbours");
  end_of(sim);
}

/* Openings of a disk that bounces, against the state looked at after every step. */
static void bounces(void **unused) {
  sd_model *m =
      model_of("dt = 1e-4; gravity = { g = 10; };\n" LAW
               "disks = ( { x = 0; y = 0.3; radius = 0.1; mass = 0.1; }, "
               "{ x = 1; y = 0.0999; radius = 0.1; mass = 0.1; } );\n"
               "walls = ( { type = \"line\"; points = ((0, 0), (1, 0)); } );\n"
               "phases = ( { steps = 5000; }, { steps = 9000; measure = true; }, { steps = 4000; "
               "}, { steps = 6000; measure "
               "= true; } ); measure = { disks = true; rotation = (); };\n");
  sd_simulation *sim = begin_run(m, 1);
  int64_t opened = 0, closed = 0;
  bool was = false;
  for (int64_t step = 0; step < 24000; step++) {
    bool measured = m->phases[sd_simulation_state(sim)->phase].measure, now = false;
    advance(sim, 1);
    const sd_state *s = sd_simulation_state(sim);
    for (size_t c = 0; c < s->n_contacts; c++) now = now || s->contact_a[c] == 0;
    opened += measured && was && !now;
    closed += measured && now;
    was = now;
  }
  sd_disk_mean d[MOST];
  sd_disk_totals t;
  means_of(sim, d, &t);
  assert_true(opened >= 3);
  assert_int_equal(sd_simulation_state(sim)->sum_openings[0], opened);
  assert_int_equal(sd_simulation_state(sim)->sum_openings[1], 0);
  between(d[0].openings, (double)opened / 1.5 - 1e-12, (double)opened / 1.5 + 1e-12,
          "openings per time");
  between(d[0].coordination, (double)closed / 15000 - 1e-12, (double)closed / 15000 + 1e-12,
          "time in contact");
  assert_true(d[1].coordination == 1);
  between(d[1].force - 1, -1e-3, 1e-3, "weight of the disk at rest");
  between(t.openings - (double)opened / 1.5 / (1 + (double)closed / 15000), -1e-9, 1e-9,
          "openings per contact");
  end_of(sim);
}

/* Shaken and turned by a cup; one disk is driven along x only, one is fixed and spins, one rolls below the cup in a
 * drum that turns. Measured after a rest of `rest` steps, from the start when that is 0. */
static void packing(text *t, const char *integrator, double dt, int disks, int64_t rest,
                    int64_t steps, int every) {
  text_add(t,
           "integrator = \"%s\"; dt = %.17g; gravity = { g = 9.81; };\n" LAW
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (",
           integrator, dt);
  add_lattice(t, disks, 9, -0.17, 0.03, 0.042, 0.02, 5);
  text_add(
      t, "); }, { columns = (\"x\", \"y\", \"radius\"); density = 3.57; fixed = true; rows = "
         "((-0.21, 0.1, 0.015)); }, { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = "
         "((0, -0.2801, 0.02)); } );\n"
         "walls = ( { name = \"cup\"; type = \"polyline\"; pivot = (0, 0.1); "
         "points = ((-0.3, 0.3), (-0.2, 0), (0, -0.003), (0.2, 0), (0.3, 0.3)); },\n"
         "{ name = \"drum\"; type = \"circle\"; center = (0, 0.6); radius = 0.9; side = "
         "\"inside\"; } );\n");
  text_add(
      t,
      "motions = ( { wall = \"cup\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 4e-4; "
      "frequency "
      "= 90; },\n"
      "{ wall = \"cup\"; coordinate = \"theta\"; type = \"harmonic\"; amplitude = 0.02; frequency "
      "= 7; },\n"
      "{ wall = \"cup\"; coordinate = \"x\"; type = \"harmonic\"; amplitude = 2e-4; frequency = "
      "70; },\n"
      "{ disk = %d; coordinate = \"theta\"; type = \"velocity\"; velocity = 30; },\n"
      "{ disk = 4; coordinate = \"x\"; type = \"harmonic\"; amplitude = 1e-3; frequency = 30; },\n"
      "{ wall = \"drum\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 5; } );\nphases "
      "= ( ",
      disks);
  if (rest > 0) text_add(t, "{ steps = %lld; }, ", (long long)rest);
  text_add(t,
           "{ steps = %lld; measure = true; } ); measure = { disks = true; every = %d; rotation = "
           "(); };\n",
           (long long)steps, every);
}

typedef struct recount {
  double contacts, sliding, force, x, y, xx, yy, kinetic, spin;
} recount;

static void count_looks(recount *r, const sd_state *s, double (*start)[2]) {
  for (size_t c = 0; c < s->n_contacts; c++)
    for (int side = 0; side < 2; side++) {
      uint32_t body = side ? s->contact_b[c] : s->contact_a[c];
      for (size_t i = 0; i < s->n_free; i++) {
        if (s->id[i] != body) continue;
        r[i].contacts++;
        r[i].sliding += s->contact_slide[c] != 0;
        r[i].force += s->contact_force[c];
      }
    }
  for (size_t i = 0; i < s->n_free; i++) {
    double x = s->x[i] - start[i][0], y = s->y[i] - start[i][1];
    r[i].x += x, r[i].y += y, r[i].xx += x * x, r[i].yy += y * y;
    r[i].kinetic += 0.5 * s->mass[i] * (s->vx[i] * s->vx[i] + s->vy[i] * s->vy[i]);
    r[i].spin += 0.5 * s->inertia[i] * s->omega[i] * s->omega[i];
  }
}

static void near_to(double value, double expected, const char *what) {
  double off = 1e-11 * fabs(expected) + 1e-18;
  between(value, expected - off, expected + off, what);
}

static void looks_equal_a_recount(void **unused) {
  for (int gear = 0; gear < 2; gear++) {
    text deck = {0};
    packing(&deck, gear ? "gear5" : "verlet", 2e-5, 53, 700, 2500, 3);
    sd_model *m = model_of_text(&deck);
    sd_simulation *sim = begin_run(m, 1);
    advance(sim, 700);
    const sd_state *s = sd_simulation_state(sim);
    double start[MOST][2];
    recount r[MOST] = {0};
    for (size_t i = 0; i < s->n_free; i++) start[i][0] = s->x[i], start[i][1] = s->y[i];
    for (int step = 1; step <= 2500; step++) {
      advance(sim, 1);
      s = sd_simulation_state(sim);
      if (step % 3 == 0) count_looks(r, s, start);
    }
    assert_int_equal(s->mean_samples, 833);
    double sliding = 0;
    for (size_t i = 0; i < s->n_means; i++) {
      assert_true(s->sum_contacts[i] == r[i].contacts && s->sum_sliding[i] == r[i].sliding);
      near_to(s->sum_force[i], r[i].force, "sum of normal forces");
      near_to(s->sum_x[i], r[i].x, "sum of x");
      near_to(s->sum_y[i], r[i].y, "sum of y");
      near_to(s->sum_xx[i], r[i].xx, "sum of x^2");
      near_to(s->sum_yy[i], r[i].yy, "sum of y^2");
      near_to(s->sum_kinetic[i], r[i].kinetic, "sum of energies of translation");
      near_to(s->sum_spin[i], r[i].spin, "sum of energies of rotation");
      sliding += r[i].sliding;
    }
    assert_true(sliding > 100);
    end_of(sim);
  }
}

/* What the disks lost in all is what the energy budget says, and what was done on them is the work, but for what
 * lies between a sum over steps and the budget's trapezoid: that falls with dt. */
static void powers_sum_up(void **unused) {
  for (int gear = 0; gear < 2; gear++) {
    double off[3];
    for (int level = 0; level < 3; level++) {
      int cut = 1 << level;
      text deck = {0};
      packing(&deck, gear ? "gear5" : "verlet", 2e-5 / cut, 53, 0, (int64_t)20000 * cut, 1);
      sd_disk_mean d[MOST];
      sd_disk_totals t;
      sd_simulation *sim = run_of(deck.s, d, &t);
      free(deck.s);
      sd_energy e = sd_simulation_energy(sim);
      const double time = 0.4;
      near_to(t.power_viscous * time, e.viscous, "viscous losses");
      near_to(t.power_friction * time, e.friction, "frictional losses");
      near_to(t.power_opening * time, e.opening, "left in openings");
      off[level] = fabs(t.power_injected * time / e.work - 1);
      print_message(
          "  %s dt %.2g: work %.6g, injected * time/work - 1 = %.2e, residual/scale %.1e\n",
          gear ? "gear5 " : "verlet", 2e-5 / cut, e.work, t.power_injected * time / e.work - 1,
          e.residual / e.scale);
      assert_true(e.work > 0 && e.friction > 0.01 * e.work);
      end_of(sim);
    }
    between(off[0], 0, 3e-4, "injected power, dt = 2e-5");
    between(off[2], 0, 1e-4, "injected power, dt = 5e-6");
  }
}

/* Looks change nothing that moves. */
static void looks_change_nothing(void **unused) {
  text deck = {0};
  packing(&deck, "verlet", 2e-5, 150, 300, 3000, 7);
  sd_model *m = model_of_text(&deck);
  sd_simulation *whole = begin_run(m, 1);
  advance(whole, 2900);
  assert_true(sd_simulation_state(whole)->mean_samples == 2600 / 7);
  m->measure_every = 1;
  sd_simulation *often = begin_run(m, 1);
  advance(often, 2900);
  const sd_state *a = sd_simulation_state(whole), *b = sd_simulation_state(often);
  for (size_t i = 0; i < a->n_bodies; i++)
    assert_true(a->x[i] == b->x[i] && a->theta[i] == b->theta[i]);
  sd_simulation_free(often);
  end_of(whole);
}

/* A disk that waits, or was taken out, has no means and is not counted. */
static void disks_out_of_play(void **unused) {
  sd_disk_mean d[MOST];
  sd_disk_totals t;
  sd_simulation *sim = run_of(
      "dt = 1e-3; gravity = { g = 10; };\n" LAW "bounds = { y = (0, 10); outside = \"remove\"; };\n"
      "disks = ( { x = 0; y = 1; omega = 1; radius = 0.1; mass = 1; }, { x = 1; y = 1; vy = 30; "
      "omega "
      "= 2; radius = "
      "0.1; mass = 1; }, { x = 2; y = 9; omega = 3; radius = 0.1; mass = 1; } );\n"
      "phases = ( { steps = 1000; } ); measure = { disks = true; rotation = (); };\n",
      d, &t);
  assert_true(isnan(d[0].omega) && isnan(d[0].x) && isnan(d[1].omega) && isnan(d[1].rms));
  between(d[2].omega - 3, -1e-10, 1e-10, "the one that stayed");
  assert_true(t.disks == 1 && isnan(t.omega_mean_error) && isnan(t.persistence));
  between(t.omega_rms - 3, -1e-10, 1e-10, "rms of the one that stayed");
  end_of(sim);
}

/* An angle whose velocity is Omega + an Ornstein-Uhlenbeck process of the given correlation time, in bins: exact
 * steps (Gillespie, Phys. Rev. E 54, 2084 (1996)). */
static void angle_record(gsl_rng *random, double tau, double omega, double *bin) {
  const double mu = exp(-1 / tau), vv = 1 - mu * mu;
  const double yy = tau * tau * (2 / tau - 3 + 4 * mu - mu * mu), vy = tau * (1 - mu) * (1 - mu);
  double v = gsl_ran_gaussian(random, 1);
  for (int k = 0; k < SD_MEAN_BINS - 1; k++) {
    double n1 = gsl_ran_gaussian(random, 1), n2 = gsl_ran_gaussian(random, 1);
    bin[k] = omega + v * tau * (1 - mu) + sqrt(yy - vy * vy / vv) * n2 + vy / sqrt(vv) * n1;
    v = v * mu + sqrt(vv) * n1;
  }
}

static void error_bars_cover(void **unused) {
  enum { DISKS = 2000 };
  const double omega = 0.1;
  const struct {
    double tau, one, two; /* correlation time in bins; allowed deviation from 0.683 and 0.954 */
  } cases[] = {
      {0.05, 0.05, 0.04}, {0.5, 0.05, 0.04}, {1, 0.06, 0.05}, {2, 0.09, 0.08}, {4, 0.15, 0.14}};
  text deck = {0};
  text_add(&deck, "dt = 1.0; limits = { unstable_step = true; }; " LAW
                  "disk_rows = ( { columns = (\"x\"); y = 0; radius = 0.1; mass = 1; rows = (");
  for (int i = 0; i < DISKS; i++) text_add(&deck, "%s(%d.0)", i ? ", " : "", i);
  text_add(&deck, "); } ); steps = 10000; measure = { disks = true; rotation = (); };\n");
  sd_model *m = model_of_text(&deck);
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    sd_state *s = sd_state_new(m);
    assert_non_null(s);
    s->measured = (SD_MEAN_BINS - 1) * 64;
    s->mean_bin_steps = 1; /* Omega in bins */
    s->mean_bins = SD_MEAN_BINS - 1;
    double one = 0, two = 0, beyond = 0, reliable = 0, error = 0, chi = 0, good_one = 0,
           good_two = 0;
    sd_disk_mean *d = calloc(DISKS, sizeof *d);
    assert_non_null(d);
    for (size_t i = 0; i < DISKS; i++) {
      s->id[i] = (uint32_t)i;
      angle_record(random, cases[c].tau, omega, s->mean_bin + i * SD_MEAN_BINS);
      d[i] = sd_disk_mean_of(m, s, i);
      double off = fabs(d[i].omega - omega) / d[i].error;
      one += off < 1, two += off<2, beyond += off> 3, reliable += d[i].converged;
      good_one += d[i].converged && off < 1, good_two += d[i].converged && off < 2;
      error += d[i].error, chi += fmin(off, 10) * fmin(off, 10);
    }
    double n = SD_MEAN_BINS - 1, tau = cases[c].tau;
    double expected = sqrt(2 * tau * (n - tau * (1 - exp(-n / tau)))) / n;
    print_message("  tau %.2f bins: error/true %.3f, within one %.3f, two %.3f, beyond three "
                  "%.4f, chi^2 %.2f, reliable %.2f, of them within one %.3f, two %.3f\n",
                  tau, error / DISKS / expected, one / DISKS, two / DISKS, beyond / DISKS,
                  chi / DISKS, reliable / DISKS, good_one / reliable, good_two / reliable);
    /* bars of records that are too short hold their drift: rather too large */
    between(one / DISKS, 0.683 - cases[c].one, 0.8, "coverage of one error");
    between(two / DISKS, 0.954 - cases[c].two, 1, "coverage of two errors");
    if (reliable > DISKS / 2.0) {
      between(good_one / reliable, 0.683 - cases[c].one, 0.683 + cases[c].one,
              "coverage of one reliable error");
      between(good_two / reliable, 0.954 - cases[c].two, 0.954 + cases[c].two,
              "coverage of two reliable errors");
    }
    free(d);
    sd_state_free(s);
  }
  gsl_rng_free(random);
  sd_model_free(m);
}

RUN_TESTS(TEST(free_disks), TEST(gears), TEST(bounces), TEST(looks_equal_a_recount),
          TEST(powers_sum_up), TEST(looks_change_nothing), TEST(disks_out_of_play),
          TEST(error_bars_cover))
