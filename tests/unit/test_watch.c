/* test_watch.c: the running statistics against a recount that looks at the state after every step. */
#include "deck_runs.h"
#include "model/model.h"

#define LAW "materials = ( { name = \"m\"; k_n = 1e4; k_t = 2e4; gamma_n = 1; mu = 0.3; } );\n"

/* The disk bounces, slides and sticks on two supports that turn to and fro; a third measure of a wall. */
static const char ratchet[] =
    "dt = 2e-5; gravity = { g = 10; tilt = 0.1; };\n" LAW
    "disks = ( { name = \"left\"; x = -1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; "
    "},\n"
    "{ name = \"top\"; x = 0; y = 0.001; radius = 1; mass = 0.1; },\n"
    "{ name = \"right\"; x = 1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; } );\n"
    "motions = ( { disk = [\"left\", \"right\"]; coordinate = \"theta\"; type = \"harmonic\"; "
    "amplitude = 0.02; omega = 60; },\n"
    "{ disk = \"left\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 4e-4; omega = 200; "
    "} );\n"
    "phases = ( { steps = 700; }, { steps = 9000; measure = true; }, { steps = 500; }, { steps = "
    "30000; measure = true; } );\n"
    "measure = { rotation = (\"top\", \"left\"); sliding = ( { disk = \"top\"; partners = "
    "(\"left\", \"right\"); }, { disk = \"top\"; partners = (\"right\", \"left\"); } ); };\n";

/* A disk hops along a polyline and leans on a circle. */
static const char hills[] =
    "integrator = \"verlet\"; dt = 2e-5; gravity = { g = 9.81; tilt = -0.2; };\n" LAW
    "disks = ( { name = \"r\"; x = 0; y = 0.0999; radius = 0.1; mass = 1; }, { name = \"s\"; x = "
    "0.25; y = 0.12; radius = 0.1; mass = 0.5; } );\n"
    "walls = ( { name = \"hills\"; type = \"polyline\"; points = ((-1, 0), (0.1, 0), (0.2, "
    "0.005), (0.3, 0), (0.35, 0), (0.42, 0.05), (1, 0.05)); },\n"
    "{ name = \"post\"; type = \"circle\"; center = (0.7, 0.2); radius = 0.15; side = "
    "\"outside\"; } );\n"
    "motions = ( { wall = \"hills\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 1e-3; "
    "omega = 300; } );\n"
    "phases = ( { steps = 40000; measure = true; } );\n"
    "measure = { rotation = (\"s\", \"r\"); sliding = ( { disk = \"r\"; partners = (\"hills\", "
    "\"s\"); }, { disk = \"s\"; partners = (\"post\", \"hills\"); } ); };\n";

/* What a contact of body d with body q does, from the state's own table of contacts. */
static int look(const sd_state *s, uint32_t d, uint32_t q, double *force) {
  int now = SD_OPEN;
  *force = 0.0;
  for (size_t c = 0; c < s->n_contacts; c++) {
    bool is = (s->contact_a[c] == d && s->contact_b[c] == q) ||
              (s->contact_a[c] == q && s->contact_b[c] == d);
    if (!is || (now != SD_OPEN && s->contact_force[c] <= *force)) continue;
    *force = s->contact_force[c];
    now = s->contact_slide[c] > 0   ? SD_SLIDE_POSITIVE
          : s->contact_slide[c] < 0 ? SD_SLIDE_NEGATIVE
                                    : SD_STUCK;
  }
  return now;
}

typedef struct recount {
  int64_t count[2][16], openings[4], measured;
  double least[4], turned[2];
  int was[4];
} recount;

static void count_step(recount *r, const sd_model *m, const sd_state *s) {
  r->measured++;
  for (size_t k = 0; k < m->n_slides; k++) {
    int now[2];
    for (size_t side = 0; side < 2; side++) {
      size_t c = 2 * k + side;
      double force;
      now[side] = look(s, m->slides[k].disk, m->slides[k].partner[side], &force);
      r->least[c] = fmin(r->least[c], force);
      r->openings[c] += now[side] == SD_OPEN && r->was[c] != SD_OPEN;
      r->was[c] = now[side];
    }
    r->count[k][4 * now[0] + now[1]]++;
  }
}

static void compare_counts(const recount *r, const sd_model *m, const sd_state *s) {
  assert_int_equal(s->measured, r->measured);
  for (size_t k = 0; k < m->n_slides; k++) {
    for (size_t c = 0; c < 16; c++) assert_int_equal(s->slide_count[16 * k + c], r->count[k][c]);
    for (size_t c = 2 * k; c < 2 * k + 2; c++) {
      assert_int_equal(s->slide_openings[c], r->openings[c]);
      assert_true(s->slide_force_min[c] == r->least[c]);
    }
  }
}

static void counts_equal_a_recount(void **unused) {
  const char *decks[] = {ratchet, hills};
  for (int d = 0; d < 2; d++) {
    sd_model *m = model_of(decks[d]);
    sd_simulation *sim = begin_run(m, 1), *fast = begin_run(m, 1);
    recount r = {.least = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL}};
    static double angle[2][40001]; /* after each measured step, unmeasured stretches cut out */
    double last[2], cut[2] = {0, 0};
    bool measured = false;
    for (int64_t step = 0; !sd_simulation_finished(sim); step++) {
      const sd_state *s = sd_simulation_state(sim);
      bool now = m->phases[s->phase].measure;
      for (uint32_t k = 0; k < 2; k++) {
        double at = sd_simulation_angle(sim, m->rotations[k]);
        if (now && !measured) cut[k] += at - (r.measured ? last[k] : 0.0);
        if (now && !measured) angle[k][r.measured] = at - cut[k];
      }
      for (size_t c = 0; now && !measured && c < 4; c++) {
        double force;
        r.was[c] = look(s, m->slides[c / 2].disk, m->slides[c / 2].partner[c % 2], &force);
      }
      measured = now;
      advance(sim, 1);
      if (!now) continue;
      count_step(&r, m, sd_simulation_state(sim));
      for (uint32_t k = 0; k < 2; k++) {
        last[k] = sd_simulation_angle(sim, m->rotations[k]);
        angle[k][r.measured] = last[k] - cut[k];
      }
      if (step % 777 == 0) compare_counts(&r, m, sd_simulation_state(sim));
    }
    const sd_state *s = sd_simulation_state(sim);
    compare_counts(&r, m, s);
    int64_t opened = 0, kinds = 0;
    for (size_t c = 0; c < 16; c++) kinds += r.count[0][c] > 0;
    for (size_t c = 0; c < 4; c++) opened += r.openings[c];
    print_message("  %lld configurations, %lld openings, bins of %lld steps\n", (long long)kinds,
                  (long long)opened, (long long)s->bin_steps);
    assert_true(kinds >= 6 && opened >= 10);

    /* 39000 or 40000 steps: halved four times */
    assert_int_equal(s->bin_steps, 16);
    assert_int_equal(s->bins, r.measured / 16);
    for (size_t k = 0; k < 2; k++)
      for (int64_t b = 0; b < s->bins; b++)
        between(s->rotation_bin[k * SD_BINS + (size_t)b] -
                    (angle[k][16 * (b + 1)] - angle[k][16 * b]),
                -1e-13, 1e-13, "angle turned in a bin");

    /* all at once: the same bits */
    advance(fast, sd_model_steps(m));
    same_states(s, sd_simulation_state(fast), "statistics, step by step and at once");
    sd_simulation_free(sim);
    end_run(fast, m);
  }
}

RUN_TESTS(TEST(counts_equal_a_recount))
