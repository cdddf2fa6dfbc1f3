/* test_limits.c: counters, angles and images near the ends of their ranges: a run that stands there goes on with the same
 * bits as one that has just begun. */
#include "deck_runs.h"
#include "model/state.h"
#include "slipdisk/measure.h"

enum { BEFORE = 700, AFTER = 900, DECKS = 3 };

#define LAW "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"

/* Three disks, one turned to and fro and on. */
static void supports(text *t) {
  text_add(t,
           "dt = 5e-6; gravity = { g = 10; tilt = 0.1; };\n" LAW
           "disks = ( { name = \"top\"; x = 0; y = 0; theta = 3; omega = 200; radius = 1; mass = "
           "0.1; },\n"
           "{ name = \"left\"; x = -1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; },\n"
           "{ name = \"right\"; x = 1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; } "
           ");\n"
           "motions = ( { disk = \"left\"; coordinate = \"theta\"; type = \"harmonic\"; "
           "amplitude = 0.2; omega = 700; },\n"
           "{ disk = \"right\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 2e3; },\n"
           "{ disk = \"right\"; coordinate = \"y\"; type = \"parabolic\"; amplitude = 1e-4; "
           "omega = 900; } );\n"
           "measure = { rotation = [\"top\"]; sliding = ( { disk = \"top\"; partners = "
           "[\"left\", \"right\"]; } ); };\n");
}

/* A shaken cup of disks. */
static void packing(text *t) {
  text_add(t, "dt = 2e-5; gravity = { g = 9.81; };\n" LAW
              "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(t, 53, 9, -0.17, 0.03, 0.042, 0.02, 5);
  text_add(t, "); } );\n"
              "walls = ( { name = \"cup\"; type = \"polyline\"; points = ((-0.3, 0.3), (-0.2, "
              "0), (0, -0.003), (0.2, 0), (0.3, 0.3)); } );\n"
              "motions = ( { wall = \"cup\"; coordinate = \"y\"; type = \"harmonic\"; amplitude "
              "= 4e-4; frequency = 90; },\n"
              "{ wall = \"cup\"; coordinate = \"theta\"; type = \"harmonic\"; amplitude = 0.4; "
              "frequency = 4; } );\n"
              "measure = { disks = true; rotation = (0, 11); sliding = ( { disk = 2; partners = "
              "[\"cup\", 3]; } ); };\n");
}

/* Disks that drift around a periodic box, and one that is driven around it. */
static void gas(text *t) {
  text_add(t, "dt = 1e-4; box = { x = (0, 1); y = (-0.5, 0.5); periodic = \"xy\"; };\n" LAW
              "disk_rows = (");
  uint64_t seed = 12;
  text_add(
      t,
      "{ columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\", \"omega\"); density = 3; rows = (");
  for (int k = 0; k < 40; k++)
    text_add(t, "%s(%.4f, %.4f, %.4f, %.4f, %.4f, %.4f)", k ? ", " : "", 0.07 + 0.14 * (k % 7),
             -0.43 + 0.14 * (k / 7), 0.05 + 0.018 * next_uniform(&seed),
             8 * next_uniform(&seed) + 1, 8 * next_uniform(&seed) - 4,
             400 * next_uniform(&seed) - 200);
  text_add(t,
           "); }, { columns = (\"x\", \"y\", \"radius\"); mass = 1; fixed = true; rows = ((0, "
           "0.42, 0.06)); } );\n"
           "motions = ( { disk = 40; coordinate = \"x\"; type = \"velocity\"; velocity = 4; } );\n"
           "measure = { rotation = (0, 3); };\n");
}

static void (*const decks[DECKS])(text *t) = {supports, packing, gas};
static const char *const names[DECKS] = {"supports", "packing", "gas"};

static sd_model *deck(int d, int integrator) {
  text t = {0};
  text_add(&t,
           "integrator = \"%s\"; seed = 31; phases = ( { steps = 9000000000000000000; measure = "
           "true; } );\n",
           integrator ? "verlet" : "gear5");
  decks[d](&t);
  return model_of_text(&t);
}

enum { STEPS = 1, TURNS = 2, IMAGES = 4 };

typedef struct shift {
  int what;
  int64_t steps;
  double turn;    /* multiple of 8 rad */
  int32_t images; /* of boxes of length 1 */
  const char *name;
} shift;

static void add(int64_t *numbers, size_t n, int64_t by) {
  for (size_t k = 0; k < n; k++) numbers[k] += by;
}

/* There (sign 1) and back (-1). */
static void move(sd_state *s, const shift *by, int sign) {
  if (by->what & STEPS) {
    s->step += sign * by->steps;
    s->phase_step += sign * by->steps;
    for (size_t k = 0; k < s->n_motions; k++) s->motion_start[k] += sign * by->steps;
    add(s->slide_count, 16 * s->n_slides, sign * by->steps);
    add(s->slide_openings, 2 * s->n_slides, sign * by->steps);
    add(s->sum_openings, s->n_means, sign * by->steps);
  }
  /* of prescribed bodies both follow from the motions */
  double turn = by->what & TURNS ? sign * by->turn : 0;
  int32_t images = by->what & IMAGES ? sign * by->images : 0;
  for (size_t i = 0; i < s->n_free; i++) s->turn[i] += turn, s->image_x[i] += images;
  for (size_t k = 0; k < s->n_rotations; k++)
    s->rotation_start[k] += turn, s->rotation_last[k] += turn;
  for (size_t k = 0; k < s->n_means; k++) s->mean_angle[k] += turn, s->mean_last[k] += turn;
}

static void compare_angles(const double *a, double *b, size_t n, double tolerance,
                           const char *what) {
  for (size_t k = 0; k < n; k++) between(b[k] - a[k], -tolerance, tolerance, what);
  if (n > 0) memcpy(b, a, n * sizeof *b);
}

/* The record of angles holds sums turn + theta, so it alone is rounded. */
static void compare_records(const sd_state *a, sd_state *b, double tolerance) {
  compare_angles(a->rotation_start, b->rotation_start, a->n_rotations, tolerance,
                 "angle when measuring began");
  compare_angles(a->rotation_last, b->rotation_last, a->n_rotations, tolerance,
                 "angle of the last bin");
  compare_angles(a->rotation_bin, b->rotation_bin, a->n_rotations * SD_BINS, 2 * tolerance, "bins");
  compare_angles(a->mean_angle, b->mean_angle, a->n_means, tolerance, "angle when means began");
  compare_angles(a->mean_last, b->mean_last, a->n_means, tolerance, "angle of the means' last bin");
  compare_angles(a->mean_bin, b->mean_bin, a->n_means * SD_MEAN_BINS, 2 * tolerance,
                 "bins of means");
}

/* Begins, is moved, goes on, is moved back, and is what it would have been. */
static void go_on_there(int d, int integrator, const shift *by, int threads) {
  sd_model *model = deck(d, integrator);
  sd_simulation *plain = begin_run(model, threads), *other = begin_run(model, threads);
  advance(plain, BEFORE);
  advance(other, BEFORE);
  sd_state *moved = copy_of(model, sd_simulation_state(other));
  sd_simulation_free(other);
  move(moved, by, 1);
  other = NULL;
  assert_int_equal(sd_simulation_resume(model, moved, threads, &other, NULL), SD_OK);
  advance(plain, AFTER);
  advance(other, AFTER);
  sd_state *a = copy_of(model, sd_simulation_state(plain)),
           *b = copy_of(model, sd_simulation_state(other));
  assert_int_equal(b->step, BEFORE + AFTER + (by->what & STEPS ? by->steps : 0));
  move(b, by, -1);
  if (by->what & TURNS) compare_records(a, b, fabs(by->turn) * 0x1p-52);
  char what[96];
  snprintf(what, sizeof what, "%s, integrator %d, %s", names[d], integrator, by->name);
  same_states(a, b, what);
  sd_state_free(a);
  sd_state_free(b);
  sd_simulation_free(plain);
  end_run(other, model);
}

/* In the part of the run that is compared disks cross the box, and return into their range of angles with closed contacts. */
static void the_decks_are_lively(void **unused) {
  for (int d = 0; d < DECKS; d++) {
    sd_model *model = deck(d, 0);
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, BEFORE);
    sd_state *before = copy_of(model, sd_simulation_state(sim));
    advance(sim, AFTER);
    const sd_state *after = sd_simulation_state(sim);
    int turned = 0, crossed = 0;
    for (size_t i = 0; i < after->n_free; i++) {
      turned += before->turn[i] != after->turn[i];
      crossed += before->image_x[i] != after->image_x[i];
    }
    print_message("  %s: %d turned, %d crossed\n", names[d], turned, crossed);
    assert_true(after->n_contacts > 0);
    if (d == 0) assert_true(turned == 1 && before->n_contacts == 2 && after->n_contacts == 2);
    if (d == 2) assert_true(turned > 5 && crossed > 5);
    sd_state_free(before);
    end_run(sim, model);
  }
}

static void steps_beyond_all_limits(void **unused) {
  /* each limit is crossed half way */
  const int bits[] = {31, 32, 53, 62};
  for (size_t k = 0; k < sizeof bits / sizeof *bits; k++)
    for (int c = 0; c < 2 * DECKS; c++) {
      shift by = {STEPS, .steps = (INT64_C(1) << bits[k]) - BEFORE - AFTER / 2,
                  .name = "many steps"};
      go_on_there(c / 2, c % 2, &by, 1);
    }
}

/* 1.3e6 and 1.4e12 turns: the stretch of a skin is as exact as in the first. */
static void angles_of_a_million_turns(void **unused) {
  const double turns[] = {0x1p23, -0x1p23, 0x1p43};
  for (size_t k = 0; k < sizeof turns / sizeof *turns; k++)
    for (int c = 0; c < 2 * DECKS; c++) {
      shift by = {TURNS, .turn = turns[k], .name = "many turns"};
      go_on_there(c / 2, c % 2, &by, 1);
    }
}

static void images_near_the_end_of_32_bits(void **unused) {
  const int32_t images[] = {INT32_MAX - 8, INT32_MIN + 8};
  for (size_t k = 0; k < 2; k++)
    for (int integrator = 0; integrator < 2; integrator++) {
      shift by = {IMAGES, .images = images[k], .name = "many images"};
      go_on_there(2, integrator, &by, 1);
    }
}

static const double DT = 1e-6, OMEGA = 62.831853071795864, PHASE = 0.3;

/* Turns of a wave less whole ones after n steps, without rounding but of the turns per step. */
static long double wave_turns(int64_t n) {
  long double rate = OMEGA * DT * (0.5 / M_PI), turns = PHASE / (2 * acosl(-1.0L));
  for (int low = 0; low < 64; low += 8) { /* eight digits at a time: the products are exact */
    long double part = rate * ldexpl((long double)(n >> low & 0xff), low);
    turns += part - rintl(part);
  }
  return turns;
}

/* A simulation at step n of a run in which everything has been on from the start. */
static sd_simulation *far_away(const sd_model *model, int64_t n) {
  sd_simulation *sim = begin_run(model, 1);
  sd_state *s = copy_of(model, sd_simulation_state(sim));
  sd_simulation_free(sim);
  s->step = s->phase_step = n;
  sim = NULL;
  assert_int_equal(sd_simulation_resume(model, s, 1, &sim, NULL), SD_OK);
  return sim;
}

/* To 2^33 steps (2.4 hours at a microsecond) the turns are exact (signal_pass.h); later their product is rounded, to 2^-53
 * of the periods that have passed. */
static void signals_stay_in_phase(void **unused) {
  sd_model *model =
      model_of("dt = 1e-6; steps = 9000000000000000000;\n" LAW
               "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n"
               "motions = ( { disk = 0; coordinate = \"x\"; type = \"harmonic\"; amplitude = 1; "
               "omega = 62.831853071795864; phase = 0.3; } ); measure = { rotation = (); };\n");
  const int bits[] = {20, 31, 33, 40, 50};
  for (size_t k = 0; k < sizeof bits / sizeof *bits; k++) {
    int64_t n = (INT64_C(1) << bits[k]) - 100;
    sd_simulation *sim = far_away(model, n);
    double worst = 0;
    for (int i = 1; i <= 200; i++) {
      advance(sim, 1);
      long double u = sinl(2 * acosl(-1.0L) * wave_turns(n + i));
      worst = fmax(worst, (double)fabsl(u - sd_simulation_state(sim)->x[0]));
    }
    print_message(
        "  harmonic motion after 2^%d steps (%.3g periods): off by %.2g of its amplitude\n",
        bits[k], (double)n * DT * OMEGA / 6.283, worst);
    double periods = (double)n * DT * OMEGA / (2 * M_PI);
    between(worst, 0, bits[k] <= 33 ? 1e-14 : M_PI * periods * 0x1p-52,
            "error of a harmonic motion");
    sd_simulation_free(sim);
  }
  sd_model_free(model);
}

/* 3e6 turns of a support, and 3e9: the angle is exact. */
static void a_support_turns_on(void **unused) {
  sd_model *model = model_of("dt = 1e-6; steps = 9000000000000000000;\n" LAW
                             "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n"
                             "motions = ( { disk = 0; coordinate = \"theta\"; type = \"velocity\"; "
                             "velocity = 9876.54321; } ); "
                             "measure = { rotation = (); };\n");
  const double rate = 9876.54321 * DT;
  const int bits[] = {31, 41};
  for (size_t k = 0; k < sizeof bits / sizeof *bits; k++) {
    int64_t n = (INT64_C(1) << bits[k]) - 1000;
    sd_simulation *sim = begin_run(model, 1);
    sd_state *s = copy_of(model, sd_simulation_state(sim));
    sd_simulation_free(sim);
    s->step = s->phase_step = n;
    s->turn[0] = 8 * nearbyint(rate * (double)n / 8);
    s->theta[0] = fma(rate, (double)n, -s->turn[0]);
    sim = NULL;
    assert_int_equal(sd_simulation_resume(model, s, 1, &sim, NULL), SD_OK);
    double worst = 0;
    for (int i = 1; i <= 2000; i++) {
      advance(sim, 1);
      const sd_state *now = sd_simulation_state(sim);
      assert_true(fabs(now->theta[0]) <= 4 + 0.01);
      worst = fmax(worst, fabs(now->theta[0] - fma(rate, (double)(n + i), -now->turn[0])));
    }
    print_message("  after %.3g turns: off by %.2g rad\n", rate * (double)n / 6.283, worst);
    between(worst, 0, 2e-15, "error of the angle");
    sd_simulation_free(sim);
  }
  sd_model_free(model);
}

/* Bins of 2^40 steps are full soon, then neighbours become one, and the mean is what it was. */
static void bins_of_1e12_steps(void **unused) {
  sd_model *model = deck(0, 0);
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, BEFORE);
  sd_state *s = copy_of(model, sd_simulation_state(sim));
  sd_simulation_free(sim);
  const int64_t length = INT64_C(1) << 40;
  s->bin_steps = length;
  s->bins = SD_BINS - 1;
  s->measured = SD_BINS * length - AFTER / 2;
  s->step = s->phase_step = s->measured;
  const double each = 1e6;
  for (int b = 0; b < SD_BINS - 1; b++) s->rotation_bin[b] = each;
  uint32_t top = 0;
  s->rotation_last[0] = s->turn[top] + s->theta[top] - each;
  sim = NULL;
  assert_int_equal(sd_simulation_resume(model, s, 1, &sim, NULL), SD_OK);
  advance(sim, AFTER);
  const sd_state *now = sd_simulation_state(sim);
  assert_int_equal(now->bin_steps, 2 * length);
  assert_int_equal(now->bins, SD_BINS / 2);
  assert_int_equal(now->measured, SD_BINS * length + AFTER - AFTER / 2);
  double omega = each / ((double)length * 5e-6);
  between(sd_rotation_of(model, now, 0).omega / omega, 1 - 1e-9, 1 + 1e-9,
          "mean angular velocity over the record's");
  end_run(sim, model);
}

RUN_TESTS(TEST(the_decks_are_lively), TEST(steps_beyond_all_limits),
          TEST(angles_of_a_million_turns), TEST(images_near_the_end_of_32_bits),
          TEST(signals_stay_in_phase), TEST(a_support_turns_on), TEST(bins_of_1e12_steps))
