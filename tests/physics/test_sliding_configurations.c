/* test_sliding_configurations.c: torque, normal forces and visits in each sliding configuration: against closed forms, against
 * sums over the contacts of every step, and against the angular momentum.
 */
#include "measure/observable.h"
#include "slipdisk/deck.h"
#include "system.h"

enum { C = SD_CONFIGURATIONS, STICK = 4, OPEN = 5 };

typedef struct run {
  sd_model *model;
  sd_simulation *simulation;
} run;

static run begin(const char *deck, size_t n, const char *const *overrides) {
  char path[512];
  snprintf(path, sizeof path, "%s/inputs/%s", SLIPDISK_SOURCE_DIR, deck);
  sd_messages *m = sd_messages_new();
  run r;
  if (sd_deck_load(path, n, overrides, &r.model, m) != SD_OK) sd_messages_print(m, stderr);
  assert_int_equal(sd_simulation_new(r.model, 1, &r.simulation, m), SD_OK);
  sd_messages_free(m);
  return r;
}

static void end(run *r) {
  sd_simulation_free(r->simulation);
  sd_model_free(r->model);
}

static void advance(run *r, int64_t n) {
  assert_int_equal(sd_simulation_advance(r->simulation, n, NULL), SD_OK);
}

static const sd_state *state_of(const run *r) { return sd_simulation_state(r->simulation); }

/* All time in one configuration: torque and forces of eqs. 15 to 18, which do not fluctuate. */
static void steady_rotation(void **unused) {
  static const char *const velocity[2] = {"-1", "1"};
  for (int c = 0; c < 4; c++) {
    char left[64], right[64];
    snprintf(left, sizeof left, "motions.left.velocity=%s", velocity[c / 2]);
    snprintf(right, sizeof right, "motions.right.velocity=%s", velocity[c % 2]);
    const char *overrides[] = {left,
                               right,
                               "dt=1e-5",
                               "phases.settle.steps=3e5",
                               "phases.measure.steps=5000",
                               "measure.configurations=true"};
    run r = begin("three_disk/steady.cfg", 6, overrides);
    advance(&r, 305000);
    const sd_three_disk disk = {0.04 * M_PI, M_PI / 6, 0.1, 1, 1, 0.05};
    const sd_tep tep = sd_tep_solve(&disk, c / 2 ? -1 : 1, c % 2 ? -1 : 1);
    for (size_t k = 0; k < C; k++) {
      sd_configuration q = sd_configuration_of(r.model, state_of(&r), k);
      assert_int_equal(q.steps, (int)k == c ? 5000 : 0);
      assert_int_equal(q.visits, 0); /* it neither begins nor ends */
      assert_true(isnan(q.dwell) && isnan(q.torque) == ((int)k != c));
      if ((int)k != c) continue;
      SYSTEM_NEAR(q.torque, tep.torque, 1e-3 * fabs(tep.torque), "torque in %d", c);
      for (size_t side = 0; side < 2; side++)
        SYSTEM_NEAR(q.force[side], tep.normal[side], 1e-3, "force %zu in %d", side, c);
      assert_true(q.torque_sd < 1e-5 && q.force_sd[0] < 1e-5 && q.force_sd[1] < 1e-5);
    }
    end(&r);
  }
}

typedef struct sums {
  int64_t n, visits;
  long double torque, torque2, force[2], force2[2], steps, steps2;
  int64_t age[SD_AGES];
  long double age_torque[SD_AGES];
} sums;

typedef struct watch {
  sums in[C];
  int class;
  int64_t age; /* of the visit, -1: it began before */
} watch;

/* The two contacts of disk 0 with 1 and 2 as the state has them. */
static int contacts_now(const run *r, double force[2], double *torque) {
  const sd_state *s = state_of(r);
  int now[2] = {SD_OPEN, SD_OPEN};
  *torque = force[0] = force[1] = 0;
  for (size_t k = 0; k < s->n_contacts; k++) {
    assert_true(s->contact_a[k] == 0 && s->contact_b[k] <= 2);
    const size_t side = s->contact_b[k] - 1;
    now[side] = s->contact_slide[k] > 0   ? SD_SLIDE_POSITIVE
                : s->contact_slide[k] < 0 ? SD_SLIDE_NEGATIVE
                                          : SD_STUCK;
    force[side] = s->contact_force[k];
    *torque -= sd_model_law(r->model, 0, 0)->k_t * s->contact_zeta[k] * s->radius[0];
  }
  const bool open = now[0] == SD_OPEN || now[1] == SD_OPEN;
  return open ? OPEN : now[0] == SD_STUCK || now[1] == SD_STUCK ? STICK : 2 * now[0] + now[1];
}

static int octave_of(int64_t age) {
  int b = 0;
  while (b < SD_AGES - 1 && age >= 32LL << b) b++;
  return b;
}

static void add_step(watch *w, const run *r) {
  double force[2], torque;
  const int class = contacts_now(r, force, &torque);
  if (class != w->class) {
    sums *ended = w->class >= 0 ? &w->in[w->class] : NULL;
    if (ended && w->age >= 0)
      ended->visits++, ended->steps += w->age, ended->steps2 += w->age * w->age;
    w->age = ended ? 0 : -1;
    w->class = class;
  }
  sums *in = &w->in[class];
  in->n++;
  in->torque += torque;
  in->torque2 += (long double)torque * torque;
  for (int k = 0; k < 2; k++)
    in->force[k] += force[k], in->force2[k] += (long double)force[k] * force[k];
  if (w->age < 0) return;
  in->age[octave_of(w->age)]++;
  in->age_torque[octave_of(w->age)] += torque;
  w->age++;
}

static double mean_of(long double sum, int64_t n) { return n ? (double)(sum / n) : NAN; }
static double sd_of(long double sum, long double squares, int64_t n) {
  return n ? sqrt(fmax(0, (double)(squares / n - sum / n * (sum / n)))) : NAN;
}
/* Of a quantity of this size: of a deviation the square is known to as many digits. */
static void same(double a, double b, double size, const char *what, size_t k) {
  if (isnan(a) && isnan(b)) return;
  SYSTEM_NEAR(a, b, 1e-9 * fabs(b) + size, "%s in %zu", what, k);
}

/* Visits do not go on from one phase to the next. Returns the classes that were visited. */
static unsigned brute_force(const char *const *overrides, size_t n, const int64_t phases[2],
                            bool both) {
  watch w = {.class = -1};
  run r = begin("three_disk/random.cfg", n, overrides);
  int64_t measured = 0;
  for (int p = 0; p < 2; p++) {
    w.class = -1;
    for (int64_t k = 0; k < phases[p]; k++) {
      advance(&r, 1);
      if (p == 1 || both) add_step(&w, &r), measured++;
      if (k == phases[p] / 2) assert_int_equal(sd_simulation_rebuild(r.simulation, NULL), SD_OK);
    }
  }
  unsigned met = 0;
  int64_t steps = 0;
  double dt = sd_model_dt(r.model);
  for (size_t k = 0; k < C; k++) {
    const sums *in = &w.in[k];
    sd_configuration q = sd_configuration_of(r.model, state_of(&r), k);
    assert_true(q.steps == in->n && q.visits == in->visits);
    same(q.torque, mean_of(in->torque, in->n), 1e-12, "torque", k);
    same(q.torque_sd, sd_of(in->torque, in->torque2, in->n), 1e-7, "torque_sd", k);
    for (int side = 0; side < 2; side++) {
      same(q.force[side], mean_of(in->force[side], in->n), 1e-12, "force", k);
      same(q.force_sd[side], sd_of(in->force[side], in->force2[side], in->n), 1e-7, "force_sd", k);
    }
    same(q.dwell, mean_of(in->steps, in->visits) * dt, 1e-12, "dwell", k);
    same(q.dwell_sd, sd_of(in->steps, in->steps2, in->visits) * dt, 1e-7, "dwell_sd", k);
    for (int b = 0; b < SD_AGES; b++) {
      assert_int_equal(q.age_steps[b], in->age[b]);
      same(q.age_torque[b], mean_of(in->age_torque[b], in->age[b]), 1e-12, "age_torque", k);
    }
    met |= (q.visits > 0) << k;
    steps += q.steps;
  }
  assert_int_equal(steps, measured);
  end(&r);
  return met;
}

static void every_step_counts(void **unused) {
  const char *overrides[] = {"dt=1e-5",
                             "measure.configurations=true",
                             "phases[0].steps=40000",
                             "phases[1].steps=30000",
                             "motions[*].amplitude=3e-4",
                             "phases[0].measure=true"};
  const int64_t phases[2] = {40000, 30000};
  assert_int_equal(brute_force(overrides, 5, phases, false) & 31u, 31u);
  brute_force(overrides, 6, phases, true);
  /* contacts open */
  overrides[4] = "motions[*].amplitude=3e-3";
  assert_true(brute_force(overrides, 5, phases, false) >> OPEN & 1u);
}

/* The torques of all configurations, with their times, turn the disk. */
static void torques_turn_the_disk(void **unused) {
  const char *overrides[] = {"measure.configurations=true", "phases[0].steps=50000", "dt=1e-5",
                             "motions[*].amplitude=1e-3"};
  run r = begin("three_disk/random.cfg", 4, overrides);
  advance(&r, 50000);
  const double before = state_of(&r)->omega[0];
  advance(&r, 200001);
  const sd_state *s = state_of(&r);
  double impulse = 0, size = 0;
  for (size_t k = 0; k < C; k++) {
    sd_configuration q = sd_configuration_of(r.model, s, k);
    if (q.steps)
      impulse += (double)q.steps * q.torque * 1e-5, size += (double)q.steps * fabs(q.torque) * 1e-5;
  }
  SYSTEM_NEAR(impulse, s->inertia[0] * (s->omega[0] - before), 2e-5 * size, "angular momentum");
  end(&r);
}

/* Without the key, and before anything was measured. */
static void nothing_is_known(void **unused) {
  run r = begin("three_disk/random.cfg", 0, NULL);
  sd_configuration q = sd_configuration_of(r.model, state_of(&r), 0);
  assert_true(q.disk == UINT32_MAX && q.steps == 0 && isnan(q.torque) && isnan(q.force_sd[1]) &&
              isnan(q.dwell) && isnan(q.age_torque[3]));
  assert_int_equal(sd_extent_size(state_of(&r), SD_PER_VISIT_AGE), 0);
  end(&r);
  const char *overrides[] = {"measure.configurations=true"};
  r = begin("three_disk/random.cfg", 1, overrides);
  advance(&r, 10);
  q = sd_configuration_of(r.model, state_of(&r), 0);
  assert_true(q.disk == 0 && q.steps == 0 && isnan(q.torque) && isnan(q.force[0]) &&
              q.age_steps[0] == 0);
  end(&r);
}

RUN_TESTS(TEST(steady_rotation), TEST(every_step_counts), TEST(torques_turn_the_disk),
          TEST(nothing_is_known))
