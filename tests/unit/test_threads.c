/* test_threads.c: any number of threads gives the same bits. */
#include <pthread.h>
#include <stdatomic.h>

#include "base/team.h"
#include "deck_runs.h"

/* n disks in a shaken, tilted box with a turning knob; periodic in x or not. */
static sd_model *packing(int n, int wide, const char *integrator, bool periodic) {
  text t = {0};
  double width = 0.042 * wide + 0.02;
  text_add(&t, "dt = 2e-5; seed = 5; integrator = \"%s\"; gravity = { g = 9.81; tilt = 0.05; };\n",
           integrator);
  if (periodic) text_add(&t, "box = { x = (0, %g); periodic = \"x\"; };\n", width);
  text_add(&t, "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 1; mu = 0.5; } );\n"
               "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(&t, n, wide, 0.03, 0.028, 0.0405, 0.02, 21);
  text_add(&t, "); } );\nwalls = ( { name = \"box\"; type = \"polyline\"; points = (");
  if (periodic)
    text_add(&t, "(0, 0), (%g, 0)", width);
  else
    text_add(&t, "(0, 4), (0, 0), (%g, 0), (%g, 4)", width, width);
  text_add(&t,
           "); },\n"
           "{ name = \"knob\"; type = \"circle\"; center = (%g, -0.02); radius = 0.03; side = "
           "\"outside\"; } );\n",
           0.5 * width);
  text_add(
      &t,
      "motions = ( { wall = \"box\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 1e-3; "
      "frequency = 80; },\n"
      "{ wall = \"knob\"; coordinate = (\"y\", \"theta\"); type = \"random\"; amplitude = 1e-3; "
      "frequency = 90; } );\n"
      "phases = ( { steps = 100; }, { steps = 100000; measure = true; } );\n"
      "measure = { rotation = (0, %d); sliding = ( { disk = 0; partners = (\"box\", 1); } ); };\n",
      n - 1);
  return model_of_text(&t);
}

static void compare(const sd_model *model, int steps, const int *threads, int n, bool lively,
                    const char *what) {
  sd_state *one = NULL;
  for (int k = 0; k < n; k++) {
    sd_simulation *sim = begin_run(model, threads[k]);
    assert_int_equal(sd_simulation_threads(sim), threads[k]);
    advance(sim, steps);
    const sd_state *s = sd_simulation_state(sim);
    if (k == 0) {
      sd_energy e = sd_simulation_energy(sim);
      one = copy_of(model, s);
      print_message("  %s: %zu contacts, %lld builds, friction %.2g, opening %.2g\n", what,
                    s->n_contacts, (long long)engine_of(sim)->work.builds, e.friction, e.opening);
      if (lively) assert_true(e.friction > 0 && e.viscous > 0);
    } else
      same_states(one, s, what);
    sd_simulation_free(sim);
  }
  sd_state_free(one);
}

static void large_packings_do_not_depend_on_the_threads(void **unused) {
  const int threads[] = {1, 2, 3, 4};
  for (int c = 0; c < 2; c++) {
    sd_model *model = packing(3000 - c, 75, c ? "verlet" : "gear5", c);
    compare(model, 400, threads, 4, true, c ? "2999 disks, verlet, periodic" : "3000 disks, gear5");
    sd_model_free(model);
  }
}

/* Disks that fly and seldom meet: there are so few pairs that those of several chunks and threads stand in one block. */
static sd_model *gas(int n, int wide, const char *integrator) {
  text t = {0};
  uint32_t draw = 7;
  text_add(&t, "dt = 2e-5; seed = 5; integrator = \"%s\";\n", integrator);
  text_add(&t, "materials = ( { name = \"a\"; k_n = 2e4; k_t = 5e3; gamma_n = 0.2; mu = 0.3; } );\n"
               "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\"); density = "
               "3.57; rows = (");
  for (int i = 0; i < n; i++) {
    double v[2];
    for (int c = 0; c < 2; c++) {
      draw = draw * 1664525u + 1013904223u;
      v[c] = 12.0 * (draw / 4294967296.0 - 0.5);
    }
    text_add(&t, "%s(%g, %g, 0.003, %g, %g)", i ? ", " : "", 0.03 + 0.05 * (i % wide),
             0.03 + 0.05 * (i / wide), v[0], v[1]);
  }
  double width = 0.05 * wide + 0.02, height = 0.05 * ((n - 1) / wide + 1) + 0.02;
  text_add(&t,
           "); } );\nwalls = ( { name = \"box\"; type = \"polyline\"; closed = true; points = ((0, "
           "0), (%g, "
           "0), (%g, %g), "
           "(0, %g)); } );\nphases = ( { steps = 100000; } );\n",
           width, width, height, height);
  return model_of_text(&t);
}

static void gases_do_not_depend_on_the_threads(void **unused) {
  const int threads[] = {1, 2, 3, 7}, sizes[] = {1100, 2600};
  for (int c = 0; c < 4; c++) {
    sd_model *model = gas(sizes[c / 2], 40, c & 1 ? "verlet" : "gear5");
    compare(model, 800, threads, 4, false, "a gas");
    sd_model_free(model);
  }
}

/* Fewer threads than asked for, as under a limit: all disks are moved all the same. */
static void fewer_threads_than_asked_for_do_all_the_work(void **unused) {
  sd_model *model = packing(61, 9, "gear5", false);
  sd_simulation *one = begin_run(model, 1), *many = begin_run(model, 4);
  engine *e = engine_of(many);
  pool_free(e->pool);
  e->pool = pool_new(2);
  advance(one, 400);
  advance(many, 400);
  same_states(sd_simulation_state(one), sd_simulation_state(many), "two threads of four");
  sd_simulation_free(one);
  end_run(many, model);
}

static atomic_bool busy;
static void *keep_busy(void *unused) {
  while (atomic_load(&busy)) {}
  return unused;
}

static void *advance_alone(void *with) {
  advance(with, 100);
  return NULL;
}

/* Many more threads than cores, beside others that want them, too: all wait for some that do not run, and get on. */
static void threads_beside_others_get_on(void **unused) {
  enum { N = 3, THREADS = 4 };
  sd_model *model = packing(301, 25, "verlet", false);
  sd_simulation *one = begin_run(model, 1), *many[N];
  pthread_t other[N], leader[N];
  advance(one, 100);
  atomic_store(&busy, true);
  for (int k = 0; k < N; k++) {
    many[k] = begin_run(model, THREADS);
    assert_int_equal(pthread_create(&other[k], NULL, keep_busy, NULL), 0);
  }
  for (int k = 0; k < N; k++)
    assert_int_equal(pthread_create(&leader[k], NULL, advance_alone, many[k]), 0);
  for (int k = 0; k < N; k++) pthread_join(leader[k], NULL);
  atomic_store(&busy, false);
  for (int k = 0; k < N; k++) {
    pthread_join(other[k], NULL);
    same_states(sd_simulation_state(one), sd_simulation_state(many[k]), "beside others");
    sd_simulation_free(many[k]);
  }
  end_run(one, model);
}

static void add_one(const team *t, void *with) {
  int *count = with;
  for (int k = 0; k < 60; k++) { /* in turn */
    if (k % t->size == t->rank) ++*count;
    team_wait(t);
  }
}

static void add_within(const team *t, void *with) {
  add_one(t, with);
  if (t->rank > 0) {
    team_help(t);
  } else {
    team_lead(t);
    for (int k = 0; k < 3; k++) pool_run(t->pool, add_one, with);
    team_release(t);
  }
  add_one(t, with);
}

static void tasks_within_tasks_are_done_by_all(void **unused) {
  for (int threads = 1; threads <= 5; threads++) {
    pool *c = pool_new(threads);
    int count = 0;
    for (int k = 0; k < 2; k++) pool_run(c, add_within, &count);
    pool_free(c);
    assert_int_equal(count, 600);
  }
}

RUN_TESTS(TEST(large_packings_do_not_depend_on_the_threads),
          TEST(gases_do_not_depend_on_the_threads),
          TEST(fewer_threads_than_asked_for_do_all_the_work), TEST(threads_beside_others_get_on),
          TEST(tasks_within_tasks_are_done_by_all))
