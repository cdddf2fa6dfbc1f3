/* test_session_group.c: sessions side by side: those who are behind go first, and each ends as it would alone. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <signal.h>
#include <unistd.h>

#include "deck_runs.h"
#include "run/session.h"
#include "run/session_private.h"

enum { MEMBERS = 3, FIRST = 2000, SECOND = 3000, AHEAD = 2500 };

static char folder_name[] = "/tmp/slipdisk-group-XXXXXX";

static int make_folder(void **unused) { return mkdtemp(folder_name) ? 0 : -1; }

static int remove_folder(void **unused) { return rmdir(folder_name); }

/* A disk on two that shake; the k-th tilt. The last one comes to rest in its first phase. */
static sd_model *model_number(int k) {
  text t = {0};
  text_add(&t, "dt = 1e-6; seed = %d; gravity = { g = 10; tilt = %g; };\n", k + 1, 0.02 * k);
  text_add(
      &t,
      "materials = ( { name = \"m\"; k_n = 1e3; k_t = 1e6; gamma_n = 10; mu = 0.1; } );\n"
      "disks = ( { name = \"upper\"; x = 0; y = 0; radius = 1; mass = 0.1; },\n"
      "  { name = \"left\"; x = -1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; },\n"
      "  { name = \"right\"; x = 1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; } );\n"
      "motions = ( { name = \"shake\"; disk = [\"left\", \"right\"]; coordinate = [\"x\", "
      "\"theta\"];\n"
      "  type = \"random\"; amplitude = 1e-4; omega = 60; damping = 0.5; } );\n"
      "measure = { rotation = [\"upper\"]; };\n");
  text_add(&t,
           "phases = ( { name = \"one\"; steps = %d; measure = false;\n"
           "  settle = { kinetic = %g; every = 700; }; }, { name = \"two\"; steps = %d; } );\n",
           FIRST, k == MEMBERS - 1 ? 1e3 : 1e-30, SECOND);
  return model_of_text(&t);
}

typedef struct world {
  sd_model *models[MEMBERS];
  char results[MEMBERS][80];
  session *sessions[MEMBERS];
  session_member members[MEMBERS];
  volatile sig_atomic_t stop;
  int64_t left_at[MEMBERS];
  bool compare;
} world;

static void stop_in_phase_two(void *user, const session_progress *p) {
  world *w = user;
  if (p->new_phase && strcmp(p->phase, "two") == 0) w->stop = 1;
}

static void open_member(world *w, int k, void (*progress)(void *, const session_progress *)) {
  session_options options = {
      .result = w->results[k], .stop = &w->stop, .progress = progress, .user = w};
  sd_messages *messages = sd_messages_new();
  sd_status status = session_open(w->models[k], &options, &w->sessions[k], messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  w->members[k] = (session_member){.session = w->sessions[k], .messages = messages};
}

static void left(void *user, size_t k) {
  world *w = user;
  session *s = w->members[k].session;
  w->left_at[k] = s->step;
  if (w->compare) {
    sd_simulation *alone = begin_run(w->models[k], 1);
    advance(alone, FIRST + SECOND);
    assert_true(sd_simulation_finished(alone));
    same_states(sd_simulation_state(s->simulation), sd_simulation_state(alone), w->results[k]);
    sd_simulation_free(alone);
  }
  session_close(s);
}

static void run(world *w, sd_status expected) {
  session_group_run(MEMBERS, w->members, left, w);
  for (int k = 0; k < MEMBERS; k++) {
    if (w->members[k].status != expected) sd_messages_print(w->members[k].messages, stderr);
    assert_int_equal(w->members[k].status, expected);
    sd_messages_free(w->members[k].messages);
  }
}

static void those_behind_go_first(void **unused) {
  world w = {0};
  for (int k = 0; k < MEMBERS; k++) {
    w.models[k] = model_number(k);
    snprintf(w.results[k], sizeof w.results[k], "%s/%d.h5", folder_name, k);
    open_member(&w, k, k == 1 ? stop_in_phase_two : NULL);
  }
  /* the first is in its second phase already; when the next one gets there, all are stopped */
  session *ahead = w.sessions[0];
  assert_int_equal(sd_simulation_advance(ahead->simulation, AHEAD, NULL), SD_OK);
  ahead->step += AHEAD;
  run(&w, SD_INTERRUPTED);
  assert_int_equal(w.left_at[0], AHEAD);
  assert_in_range(w.left_at[1], FIRST, AHEAD);
  /* the last one's first phase was short, and then it waited */
  assert_in_range(w.left_at[2], 700, 700 + w.left_at[1] - FIRST);
  /* from there, to the end */
  w.stop = 0;
  w.compare = true;
  for (int k = 0; k < MEMBERS; k++) open_member(&w, k, NULL);
  run(&w, SD_OK);
  assert_int_equal(w.left_at[0], FIRST + SECOND);
  assert_int_equal(w.left_at[2], 700 + SECOND);
  for (int k = 0; k < MEMBERS; k++) {
    assert_int_equal(unlink(w.results[k]), 0);
    sd_model_free(w.models[k]);
  }
}

static void none(void **unused) { session_group_run(0, NULL, NULL, NULL); }

RUN_TESTS_BETWEEN(make_folder, remove_folder, TEST(those_behind_go_first), TEST(none))
