/* Every function of slipdisk/simulation.h is called where a program should not call it: in an observer, in a force field, and while
 * another thread is in a call. It refuses or answers, the system goes on with the same bits, and nothing is used after it was freed. */
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit.h"
#include "slipdisk/slipdisk.h"

enum { DISKS = 1600, SIDE = 40 };

static sd_model *made_model(size_t n) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-3);
  sd_model_set_text(m, "integrator", "verlet");
  sd_model_set_gravity(m, 0, -1);
  sd_model_add_material(m, "g", &(sd_contact_law){.k_n = 1e4, .k_t = 5e3, .gamma_n = 1, .mu = 0.4});
  for (size_t k = 0; k < n; k++)
    sd_model_add_disk(m, &(sd_disk){.position = {(double)(k % SIDE), 0.5 + (double)(k / SIDE)},
                                    .velocity = {sin((double)k), cos((double)k)},
                                    .radius = 0.48,
                                    .mass = 1});
  sd_model_add_wall(m, &(sd_wall){.name = "floor",
                                  .kind = SD_WALL_LINE,
                                  .n_points = 2,
                                  .points = (double[2][2]){{0, 0}, {1, 0}}});
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  return m;
}

static sd_simulation *made(const sd_model *m, int threads) {
  sd_simulation *sim = NULL;
  assert_int_equal(sd_simulation_new(m, threads, &sim, NULL), SD_OK);
  return sim;
}

static uint64_t hash(sd_simulation *sim) { return sd_state_hash(sd_simulation_state(sim)); }

static sd_status looks(sd_simulation *sim, void *user) {
  return sim || user ? SD_OK : SD_ERROR_USER;
}
static void pulls(const sd_force_columns *c, void *user) {
  (void)user;
  c->force_x[0] += 0.0;
}

static bool ok(sd_status status) { return status == SD_OK; }

static bool free_clone(sd_simulation *s, sd_messages *m) {
  sd_simulation *other = NULL;
  const bool good = ok(sd_simulation_clone(s, &other, m));
  sd_simulation_free(other);
  return good;
}
static bool save_memory(sd_simulation *s, sd_messages *m) {
  void *data = NULL;
  size_t size;
  const bool good = ok(sd_simulation_save_memory(s, &data, &size, m));
  sd_free(data);
  return good;
}
static bool save(sd_simulation *s, sd_messages *m) {
  char path[] = "/tmp/test_callbacks_XXXXXX";
  const int file = mkstemp(path);
  const bool good = ok(sd_simulation_save(s, path, m));
  close(file);
  unlink(path);
  return good;
}
static bool advance(sd_simulation *s, sd_messages *m) { return ok(sd_simulation_advance(s, 1, m)); }
static bool observe(sd_simulation *s, sd_messages *m) {
  (void)m;
  return ok(sd_simulation_observe(s, 1000000, looks, NULL));
}
static bool force(sd_simulation *s, sd_messages *m) {
  return ok(sd_simulation_add_force_field(s, pulls, NULL, m));
}
static bool add(sd_simulation *s, sd_messages *m) {
  return ok(sd_simulation_add_disks(
      s, 1, &(sd_disk){.position = {5, 500}, .radius = 0.4, .mass = 1}, NULL, m));
}
static bool take(sd_simulation *s, sd_messages *m) {
  return ok(sd_simulation_remove_disks(s, 1, (const uint32_t[]){1}, m));
}
static bool rebuild(sd_simulation *s, sd_messages *m) { return ok(sd_simulation_rebuild(s, m)); }
static bool state(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_state(s);
}
static bool column(sd_simulation *s, sd_messages *m) {
  sd_column c;
  (void)m;
  return sd_simulation_column(s, "x", &c);
}
static bool column_at(sd_simulation *s, sd_messages *m) {
  sd_column c;
  (void)m;
  return sd_simulation_column_at(s, 3, &c);
}
static bool energy(sd_simulation *s, sd_messages *m) {
  (void)m;
  return !isnan(sd_simulation_energy(s).work);
}
static bool model(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_model(s);
}
static bool step(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_step(s) >= 0;
}
static bool when(sd_simulation *s, sd_messages *m) {
  (void)m;
  return !isnan(sd_simulation_time(s));
}
static bool finished(sd_simulation *s, sd_messages *m) {
  (void)m;
  sd_simulation_finished(s);
  return sd_simulation_step(s) >= 0;
}
static bool stage(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_stage(s).step >= 0;
}
static bool goal(sd_simulation *s, sd_messages *m) {
  (void)m;
  sd_simulation_goal(s);
  return sd_simulation_step(s) >= 0;
}
static bool threads(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_threads(s) > 0;
}
static bool path(sd_simulation *s, sd_messages *m) {
  (void)m;
  return *sd_simulation_path(s);
}
static bool slot(sd_simulation *s, sd_messages *m) {
  (void)m;
  return sd_simulation_slot(s, 0) != UINT32_MAX;
}
static bool angle(sd_simulation *s, sd_messages *m) {
  (void)m;
  return !isnan(sd_simulation_angle(s, 0));
}

enum {
  OBSERVER = 1,
  FORCE = 2,
  TELLS = 4,
  ANYWHERE = 8
}; /* where it answers; it has a list of messages */
static const struct {
  const char *name;
  bool (*call)(sd_simulation *s, sd_messages *m);
  int where;
} calls[] = {{"advance", advance, TELLS},
             {"observe", observe, 0},
             {"add_force_field", force, TELLS},
             {"add_disks", add, TELLS},
             {"remove_disks", take, TELLS},
             {"rebuild", rebuild, OBSERVER | TELLS},
             {"state", state, OBSERVER},
             {"column", column, OBSERVER},
             {"column_at", column_at, OBSERVER},
             {"energy", energy, OBSERVER},
             {"save", save, OBSERVER | TELLS},
             {"save_memory", save_memory, OBSERVER | TELLS},
             {"clone", free_clone, OBSERVER | TELLS},
             {"model", model, OBSERVER | FORCE},
             {"step", step, OBSERVER | FORCE},
             {"time", when, OBSERVER | FORCE},
             {"finished", finished, OBSERVER | FORCE},
             {"stage", stage, OBSERVER | FORCE},
             {"goal", goal, OBSERVER | FORCE},
             {"threads", threads, OBSERVER | FORCE},
             {"path", path, OBSERVER | FORCE},
             {"slot", slot, OBSERVER | FORCE},
             {"angle", angle, OBSERVER | FORCE}};
enum { CALLS = sizeof calls / sizeof *calls };

/* Calls all; each answers in the places that the table names, and says why where it does not. */
static void call_all(sd_simulation *sim, int where, const char *why) {
  for (int k = 0; k < CALLS; k++) {
    sd_messages *m = sd_messages_new();
    const bool good = calls[k].call(sim, m);
    if (good != (where == ANYWHERE || (calls[k].where & where) != 0))
      fail_msg("%s: %s", calls[k].name, good ? "not refused" : "refused");
    if (!good && calls[k].where & TELLS) {
      assert_int_equal(sd_messages_count(m), 1);
      if (!strstr(sd_messages_text(m, 0), why))
        fail_msg("%s: %s", calls[k].name, sd_messages_text(m, 0));
      assert_non_null(strstr(sd_messages_text(m, 0), calls[k].name));
    }
    sd_messages_free(m);
  }
}

typedef struct place {
  sd_simulation *sim;
  int called;
} place;

static sd_status in_observer(sd_simulation *sim, void *user) {
  place *p = user;
  p->called++;
  call_all(sim, OBSERVER, "within an observer");
  return SD_OK;
}

static void in_force(const sd_force_columns *c, void *user) {
  place *p = user;
  if (c->step % 10) return;
  p->called++;
  call_all(p->sim, FORCE, "within a force field");
}

static void all_functions_in_callbacks(void **unused) {
  for (int n = 1; n <= DISKS; n += DISKS - 1) { /* the step of small systems, and threads */
    sd_model *m = made_model((size_t)n);
    sd_simulation *sim = made(m, 2), *plain = made(m, 2);
    place observer = {sim, 0}, field = {sim, 0};
    assert_int_equal(sd_simulation_add_force_field(plain, pulls, NULL, NULL), SD_OK);
    assert_int_equal(sd_simulation_observe(sim, 10, in_observer, &observer), SD_OK);
    assert_int_equal(sd_simulation_add_force_field(sim, in_force, &field, NULL),
                     SD_OK); /* calls it: step 0 */
    assert_int_equal(sd_simulation_advance(sim, 30, NULL), SD_OK);
    assert_int_equal(sd_simulation_advance(plain, 30, NULL), SD_OK);
    assert_int_equal(observer.called, 3);
    assert_int_equal(field.called, 4);
    assert_true(hash(sim) == hash(plain));
    call_all(sim, ANYWHERE, ""); /* outside all are served */
    sd_simulation_free(sim);
    sd_simulation_free(plain);
    sd_model_free(m);
  }
}

/* It is freed when the call is through. */
static sd_status frees(sd_simulation *sim, void *user) {
  ++*(int *)user;
  sd_simulation_free(sim);
  return SD_OK;
}

static void one_that_is_freed_in_a_callback(void **unused) {
  sd_model *m = made_model(DISKS);
  sd_simulation *sim = made(m, 2);
  int called = 0;
  assert_int_equal(sd_simulation_observe(sim, 10, frees, &called), SD_OK);
  assert_int_equal(sd_simulation_advance(sim, 25, NULL), SD_OK);
  assert_int_equal(called, 2);
  sd_model_free(m);
}

static void *in_thread(void *with) {
  call_all(with, 0, "another thread");
  return NULL;
}

static sd_status starts_thread(sd_simulation *sim, void *user) {
  pthread_t thread;
  ++*(int *)user;
  assert_int_equal(pthread_create(&thread, NULL, in_thread, sim), 0);
  assert_int_equal(pthread_join(thread, NULL), 0);
  return SD_OK;
}

static void all_functions_in_another_thread(void **unused) {
  sd_model *m = made_model(DISKS);
  sd_simulation *sim = made(m, 2), *plain = made(m, 1);
  int called = 0;
  assert_int_equal(sd_simulation_observe(sim, 10, starts_thread, &called), SD_OK);
  assert_int_equal(sd_simulation_advance(sim, 20, NULL), SD_OK);
  assert_int_equal(sd_simulation_advance(plain, 20, NULL), SD_OK);
  assert_int_equal(called, 2);
  assert_true(hash(sim) == hash(plain));
  sd_simulation_free(sim);
  sd_simulation_free(plain);
  sd_model_free(m);
}

/* The child of a fork starts threads of its own: same bits; or only frees. */
static void a_fork_between_calls(void **unused) {
  sd_model *m = made_model(DISKS);
  sd_simulation *sim = made(m, 2), *plain = made(m, 1);
  assert_int_equal(sd_simulation_advance(sim, 20, NULL), SD_OK);
  assert_int_equal(sd_simulation_advance(plain, 40, NULL), SD_OK);
  for (int steps = 0; steps <= 20; steps += 20) {
    const pid_t child = fork();
    if (child == 0) {
      const bool good = sd_simulation_advance(sim, steps, NULL) == SD_OK &&
                        (steps == 0 || hash(sim) == hash(plain));
      sd_simulation_free(sim);
      _exit(good ? 0 : 1);
    }
    int status = 1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
  }
  assert_int_equal(sd_simulation_advance(sim, 20, NULL), SD_OK);
  assert_true(hash(sim) == hash(plain));
  sd_simulation_free(sim);
  sd_simulation_free(plain);
  sd_model_free(m);
}

static void forks(const sd_force_columns *c, void *user) {
  if (c->step == 5) *(pid_t *)user = fork();
}

/* Within a force field the other threads of the step are lost: the child is told, and can free. */
static void a_fork_within_a_force_field(void **unused) {
  sd_model *m = made_model(DISKS);
  sd_simulation *sim = made(m, 2), *plain = made(m, 1);
  pid_t child = -1;
  assert_int_equal(sd_simulation_add_force_field(sim, forks, &child, NULL), SD_OK);
  assert_int_equal(sd_simulation_add_force_field(plain, pulls, NULL, NULL), SD_OK);
  const sd_status status = sd_simulation_advance(sim, 10, NULL);
  if (child == 0) {
    const bool good =
        status == SD_ERROR_USER && sd_simulation_advance(sim, 1, NULL) == SD_ERROR_USER;
    sd_simulation_free(sim);
    _exit(good ? 0 : 1);
  }
  int left = 1;
  assert_int_equal(waitpid(child, &left, 0), child);
  assert_int_equal(left, 0);
  assert_int_equal(sd_simulation_advance(plain, 10, NULL), SD_OK);
  assert_int_equal(status, SD_OK);
  assert_true(hash(sim) == hash(plain));
  sd_simulation_free(sim);
  sd_simulation_free(plain);
  sd_model_free(m);
}

/* They would feel nothing of each other. */
static void two_disks_in_one_place(void **unused) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-3);
  sd_model_add_material(m, "g", &(sd_contact_law){.k_n = 1e4});
  for (int k = 0; k < 3; k++)
    sd_model_add_disk(m, &(sd_disk){.position = {k == 1 ? 5 : 2, 7}, .radius = 0.4, .mass = 1});
  sd_model_add_phase(m, &(sd_phase){.steps = 10});
  sd_messages *told = sd_messages_new();
  sd_simulation *sim;
  assert_int_equal(sd_model_finish(m, told), SD_OK);
  assert_int_equal(sd_simulation_new(m, 1, &sim, told), SD_ERROR_USER);
  assert_null(sim);
  assert_string_equal(sd_messages_text(told, 0), "disk 2 and disk 0 have the same centre");
  sd_messages_free(told);
  sd_model_free(m);
}

/* Each is refused with a message that names key and value, and the state stays. */
static void disks_that_cannot_be(void **unused) {
  sd_model *m = made_model(60);
  sd_simulation *sim = made(m, 1);
  assert_int_equal(sd_simulation_advance(sim, 10, NULL), SD_OK);
  const uint64_t before = hash(sim);
  sd_column cx, cy;
  assert_true(sd_simulation_column(sim, "x", &cx) && sd_simulation_column(sim, "y", &cy));
  const double on[2] = {((const double *)cx.data)[7], ((const double *)cy.data)[7]};
  const sd_disk good = {.position = {5, 500}, .radius = 0.4, .mass = 1};
  struct {
    const char *says;
    sd_disk disk;
  } wrong[] = {{"radius = 1e+300", good},
               {"radius = nan", good},
               {"radius = -1", good},
               {"radius = 0", good},
               {"radius = inf", good},
               {"x = 1e+308", good},
               {"y = nan", good},
               {"theta = inf", good},
               {"vx = -1e+200", good},
               {"omega = nan", good},
               {"force y = inf", good},
               {"mass = 1e+300", good},
               {"mass = 0", good},
               {"inertia = -2", good},
               {"material 3", good},
               {"material -1", good},
               {"have the same centre", good},
               {"overlap by", good},
               {"floor", good}};
  int k = 0;
  wrong[k++].disk.radius = 1e300, wrong[k++].disk.radius = NAN, wrong[k++].disk.radius = -1;
  wrong[k++].disk.radius = 0, wrong[k++].disk.radius = INFINITY,
  wrong[k++].disk.position[0] = 1e308;
  wrong[k++].disk.position[1] = NAN, wrong[k++].disk.position[2] = INFINITY,
  wrong[k++].disk.velocity[0] = -1e200;
  wrong[k++].disk.velocity[2] = NAN, wrong[k++].disk.force[1] = INFINITY,
  wrong[k++].disk.mass = 1e300;
  wrong[k++].disk.mass = 0, wrong[k++].disk.inertia = -2, wrong[k++].disk.material = 3,
  wrong[k++].disk.material = -1;
  memcpy(wrong[k++].disk.position, on, sizeof on);
  memcpy(wrong[k].disk.position, on, sizeof on), wrong[k++].disk.position[1] += 0.1;
  wrong[k].disk.position[0] = 300, wrong[k++].disk.position[1] = 0.05;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    sd_messages *told = sd_messages_new();
    const sd_disk two[] = {good, wrong[i].disk};
    assert_int_equal(sd_simulation_add_disks(sim, 2, two, NULL, told), SD_ERROR_USER);
    if (!strstr(sd_messages_text(told, 0), wrong[i].says))
      fail_msg("%s: %s", wrong[i].says, sd_messages_text(told, 0));
    sd_messages_free(told);
    assert_true(hash(sim) == before);
  }
  const sd_disk twins[] = {good, good};
  assert_int_equal(sd_simulation_add_disks(sim, 2, twins, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_add_disks(sim, SIZE_MAX, &good, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_add_disks(sim, 1, NULL, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_remove_disks(sim, 1, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_remove_disks(sim, 1, (const uint32_t[]){UINT32_MAX}, NULL),
                   SD_ERROR_USER);
  assert_int_equal(sd_simulation_advance(sim, -1, NULL), SD_ERROR_USER);
  assert_true(hash(sim) == before);
  assert_int_equal(sd_simulation_add_disks(sim, 1, &good, NULL, NULL), SD_OK);
  sd_simulation_free(sim);
  sd_model_free(m);
}

/* Philox is not needed here: a linear congruence (Knuth's MMIX) gives the trials. */
static uint64_t seed;
static unsigned draw(unsigned n) {
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return (unsigned)(seed >> 33) % n;
}

static sd_status random_observer(sd_simulation *sim, void *user) {
  (void)user;
  calls[draw(CALLS)].call(sim, NULL);
  return draw(20) ? SD_OK : SD_INTERRUPTED;
}

static void random_force(const sd_force_columns *c, void *user) {
  calls[draw(CALLS)].call(*(sd_simulation **)user, NULL);
  for (size_t i = 0; i < c->n_free; i++) c->force_y[i] += 0.1 * sin(c->x[i]);
}

static double wild(void) {
  static const double values[] = {0, -1, 1e300, NAN, INFINITY, 0.5, 1e-300, 3, 1e9};
  return draw(3) ? 0.5 + draw(1000) * 0.1 : values[draw(sizeof values / sizeof *values)];
}

static void random_calls(void **unused) {
  const char *asked = getenv("SLIPDISK_TRIALS");
  for (uint64_t trial_seed = 1; trial_seed <= (asked ? strtoull(asked, NULL, 10) : 12);
       trial_seed++) {
    seed = trial_seed;
    sd_model *m = made_model(1 + draw(3) * 30);
    sd_simulation *sim = made(m, 1 + (int)draw(2));
    for (int k = 0; k < 40; k++) {
      const unsigned what = draw(CALLS + 4);
      if (what < CALLS) calls[what].call(sim, NULL);
      if (what == CALLS) sd_simulation_observe(sim, (int64_t)draw(5), random_observer, NULL);
      if (what == CALLS + 1) sd_simulation_add_force_field(sim, random_force, &sim, NULL);
      if (what == CALLS + 2) {
        const sd_disk d = {.position = {wild(), wild() + 60},
                           .radius = wild(),
                           .mass = wild(),
                           .material = (int)draw(3) - 1};
        sd_simulation_add_disks(sim, draw(3), (const sd_disk[]){d, d}, NULL, NULL);
      }
      if (what == CALLS + 3)
        sd_simulation_remove_disks(
            sim, 2, (const uint32_t[]){draw(100), draw(2) ? draw(100) : UINT32_MAX}, NULL);
      sd_simulation_advance(sim, draw(8), NULL);
    }
    sd_simulation_free(sim);
    sd_model_free(m);
  }
}

RUN_TESTS(TEST(all_functions_in_callbacks), TEST(one_that_is_freed_in_a_callback),
          TEST(all_functions_in_another_thread), TEST(a_fork_between_calls),
          TEST(a_fork_within_a_force_field), TEST(two_disks_in_one_place),
          TEST(disks_that_cannot_be), TEST(random_calls))
