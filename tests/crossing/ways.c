/* ways.c: runs decks in every way there is, and compares each with the plainest one.
 *
 *   ways DECK...     a line per deck and way: deck, way, what came of it (tabs between):
 *     same              the way takes the deck, and gives the same bits, energies and messages
 *     same: HASH        of the plainest way
 *     left: REASON      the way does not take the deck, and says so
 *     wrong: WHAT       it gives something else
 *     ends, refused: MESSAGE   of the plainest way: the run fails, the deck is refused
 *   ways --alone DECK...   only the ways of one thread
 *   ways --results DECK...   writes a result in every way in which sessions go, and names it
 *   ways --list      names of the ways
 *
 * Lines of a deck like "# at 100: set law.mu 0 0.3", "add X Y RADIUS", "remove NUMBER" and "bond A B" are calls of
 * the library at these steps.
 *
 * The plainest way is one thread, the narrowest vectors, the general step, one step at a time.
 * Small chunks (SLIPDISK_CHUNK) let decks of a few dozen disks be taken in windows. The status is 1
 * if any way was wrong.
 */
#include "model/model.h"
#include "physics/system/kernels.h"
#include "ranks_run.h"
#include "run/ensemble.h"
#include "run/session.h"

/* How a deck is run. */
typedef struct way {
  const char *name, *path, *windows;
  int threads, ranks;
  simulation_step step;
  int64_t piece; /* steps at a time, with `between` after each */
  enum { GOES_ON, COPIED, CLONED, SAVED, FILED, REBUILT } between;
  int lanes;        /* systems side by side */
  const char *from; /* "complete": the complete deck, as it is read again; else what is set */
} way;

enum { PLAIN, ALL = 1 << 20 };
static const way ways[] = {
    [PLAIN] = {"plain", "baseline", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"pieces", "baseline", "never", 1, 0, SIMULATION_GENERAL, 7, GOES_ON, 0, NULL},
    {"avx2", "avx2", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"avx512", "avx512", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"2 threads", "", "never", 2, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"3 threads", "baseline", "never", 3, 0, SIMULATION_GENERAL, 110, GOES_ON, 0, NULL},
    {"windows", "baseline", "always", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"windows, 2 threads", "", "always", 2, 0, SIMULATION_GENERAL, 130, GOES_ON, 0, NULL},
    {"small step", "baseline", "never", 1, 0, SIMULATION_SUITABLE, ALL, GOES_ON, 0, NULL},
    {"lanes", "", "never", 1, 0, SIMULATION_SUITABLE, 90, GOES_ON, 3, NULL},
    {"full lanes", "", "never", 1, 0, SIMULATION_SUITABLE, 64, GOES_ON, 8, NULL},
    {"lanes, avx2", "avx2", "never", 1, 0, SIMULATION_SUITABLE, 31, GOES_ON, 4, NULL},
    {"lanes, baseline", "baseline", "never", 1, 0, SIMULATION_SUITABLE, ALL, GOES_ON, 2, NULL},
    {"2 ranks", "baseline", "never", 1, 2, SIMULATION_GENERAL, ALL, GOES_ON, 0, NULL},
    {"3 ranks, 2 threads", "", "never", 2, 3, SIMULATION_GENERAL, 170, GOES_ON, 0, NULL},
    {"state copied", "baseline", "never", 1, 0, SIMULATION_GENERAL, 1, COPIED, 0, NULL},
    {"state copied, other threads", "", "always", 2, 0, SIMULATION_SUITABLE, 47, COPIED, 0, NULL},
    {"cloned", "baseline", "never", 1, 0, SIMULATION_SUITABLE, 53, CLONED, 0, NULL},
    {"saved and restored", "baseline", "never", 1, 0, SIMULATION_SUITABLE, 149, SAVED, 0, NULL},
    {"saved to a file", "", "always", 1, 0, SIMULATION_GENERAL, 160, FILED, 0, NULL},
    {"complete deck", "baseline", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0, "complete"},
    {"other lists", "baseline", "never", 1, 0, SIMULATION_SUITABLE, ALL, GOES_ON, 0, "skin=2e-2"},
    {"lists rebuilt", "baseline", "always", 1, 0, SIMULATION_GENERAL, 13, REBUILT, 0, NULL},
};
enum { WAYS = sizeof ways / sizeof *ways };

/* Outcome of a run in one way. */
typedef struct outcome {
  sd_status status;
  sd_state *end;
  sd_energy energy;
  char message[400], left[400]; /* the first message; why the way does not take the deck */
} outcome;

/* Calls of the library between steps. */
typedef struct call {
  long long step;
  char name[32]; /* a quantity of sd_simulation_set, "add", "remove", "bond" */
  unsigned number;
  double value[3];
} call;

typedef struct calls {
  size_t n;
  call all[8];
} calls;

/* Deck that is tried. */
typedef struct scene {
  const char *path, *text;
  const sd_model *model;
  calls calls;
} scene;

static calls calls_of(const char *deck) {
  calls found = {0};
  for (const char *at = deck; (at = strstr(at, "# at ")) != NULL; at++) {
    assert_true(found.n < sizeof found.all / sizeof *found.all);
    call *c = &found.all[found.n++];
    const int set = sscanf(at, "# at %lld: set %31s %u %lf %lf", &c->step, c->name, &c->number,
                           &c->value[0], &c->value[1]);
    if (set >= 4) continue;
    const int two = sscanf(at, "# at %lld: %31s %lf %lf %lf", &c->step, c->name, &c->value[0],
                           &c->value[1], &c->value[2]);
    assert_true(two >= 3);
    c->number = (unsigned)c->value[0];
  }
  return found;
}

/* A call that is refused leaves its message. */
static sd_status steer(sd_simulation *sim, const call *c, sd_messages *messages) {
  sd_status status = SD_OK;
  if (strcmp(c->name, "add") == 0) {
    const sd_disk disk = {.position = {c->value[0], c->value[1], 0},
                          .radius = c->value[2],
                          .mass = 0.01,
                          .group = -1};
    status = sd_simulation_add_disks(sim, 1, &disk, NULL, messages);
  } else if (strcmp(c->name, "remove") == 0) {
    status = sd_simulation_remove_disks(sim, 1, &c->number, messages);
  } else if (strcmp(c->name, "bond") == 0) {
    const uint32_t pair[1][2] = {{c->number, (uint32_t)c->value[1]}};
    status = sd_simulation_bond(sim, 1, pair, messages);
  } else {
    status = sd_simulation_set(sim, c->name, 1, &c->number, c->value, messages);
  }
  return status == SD_ERROR_USER ? SD_OK : status;
}

/* Steps that may be made at once. next: number of the next call. */
static int64_t steps_to_call(const scene *on, size_t next, int64_t step, int64_t most) {
  if (next == on->calls.n || on->calls.all[next].step - step >= most) return most;
  return on->calls.all[next].step - step;
}

static void keep_message(outcome *o, const sd_messages *m) {
  if (sd_messages_count(m)) snprintf(o->message, sizeof o->message, "%s", sd_messages_text(m, 0));
}

/* The simulation goes on as a new one. */
static sd_simulation *saved_and_restored(sd_simulation *sim, const way *w, outcome *o,
                                         sd_messages *messages) {
  void *bytes = NULL;
  size_t size = 0;
  sd_simulation *next = NULL;
  o->status = sd_simulation_save_memory(sim, &bytes, &size, messages);
  if (o->status == SD_OK)
    o->status = sd_simulation_load_memory(bytes, size, w->threads, &next, messages);
  free(bytes);
  if (o->status != SD_OK) return sim;
  sd_simulation_free(sim);
  return next;
}

static sd_simulation *interrupt(sd_simulation *sim, const char *path, const way *w, outcome *o,
                                sd_messages *messages) {
  sd_simulation *next = NULL;
  if (w->between == GOES_ON) return sim;
  if (w->between == SAVED) return saved_and_restored(sim, w, o, messages);
  if (w->between == REBUILT) {
    o->status = sd_simulation_rebuild(sim, messages);
    return sim;
  }
  if (w->between == COPIED && sim->owned) {
    snprintf(o->left, sizeof o->left, "the simulation has a model of its own");
    return sim;
  }
  if (w->between == CLONED) {
    o->status = sd_simulation_clone(sim, &next, messages);
  } else if (w->between == FILED) {
    char file[1024];
    snprintf(file, sizeof file, "%s.h5", path);
    o->status = sd_simulation_save(sim, file, messages);
    if (o->status == SD_OK) o->status = sd_simulation_load(file, w->threads, &next, messages);
  } else {
    const sd_model *model = sd_simulation_model(sim);
    sd_state *state = copy_of(model, sd_simulation_state(sim));
    o->status =
        simulation_resume(model, state, NULL, w->threads, w->step, NULL, NULL, &next, messages);
  }
  if (o->status != SD_OK) return sim;
  sd_simulation_free(sim);
  return next;
}

static void run_alone(const scene *on, const way *w, outcome *o) {
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = NULL;
  o->status = simulation_new(on->model, w->threads, w->step, NULL, NULL, &sim, messages);
  if (sim && w->step == SIMULATION_SUITABLE && w->between == GOES_ON && !w->from &&
      !simulation_is_small(sim))
    snprintf(o->left, sizeof o->left, "the general step is taken");
  size_t next = 0;
  while (o->status == SD_OK && !o->left[0] && !sd_simulation_finished(sim)) {
    const int64_t n = steps_to_call(on, next, sd_simulation_step(sim), w->piece);
    o->status = sd_simulation_advance(sim, n, messages);
    while (o->status == SD_OK && next < on->calls.n &&
           on->calls.all[next].step == sd_simulation_step(sim))
      o->status = steer(sim, &on->calls.all[next++], messages);
    if (o->status == SD_OK && !sd_simulation_finished(sim))
      sim = interrupt(sim, on->path, w, o, messages);
  }
  if (sim && !o->left[0]) {
    o->energy = sd_simulation_energy(sim);
    o->end = copy_of(sd_simulation_model(sim), sd_simulation_state(sim));
    if (strcmp(w->windows, "always") == 0 && w->between == GOES_ON &&
        simulation_engine(sim)->work.window.taken == 0)
      snprintf(o->left, sizeof o->left, "single steps are taken");
  }
  keep_message(o, messages);
  sd_messages_free(messages);
  sd_simulation_free(sim);
}

static const char *skip_comment(const char *at) {
  const size_t spaces = strspn(at, " ");
  if (at[spaces] == '#') return at + spaces + strcspn(at + spaces, "\n");
  return at;
}

/* Two decks are the same but for comments. */
static bool same_text(const char *a, const char *b) {
  for (;; a++, b++) {
    a = skip_comment(a);
    b = skip_comment(b);
    if (*a != *b || *a == '\0') return *a == *b;
  }
}

static void run_other_deck(const scene *on, const way *w, outcome *o) {
  sd_messages *messages = sd_messages_new();
  const bool complete = strcmp(w->from, "complete") == 0;
  const char *full = sd_model_deck(on->model)->full;
  sd_model *again = NULL;
  o->status = sd_deck_load_text(complete ? full : on->text, on->path, !complete, &w->from, &again,
                                messages);
  if (o->status != SD_OK) keep_message(o, messages);
  sd_messages_free(messages);
  if (o->status != SD_OK) return;
  scene other = *on;
  other.model = again;
  run_alone(&other, w, o);
  if (complete && !same_text(full, sd_model_deck(again)->full))
    snprintf(o->message, sizeof o->message, "the complete deck of the complete deck is another");
  sd_model_free(again);
}

/* The model of the k-th system in lanes: the last one is that of the deck, the others have numbers
 * of their own. The caller frees the others. */
static sd_model *lane_model(const scene *on, int k, int n) {
  if (k == n - 1) return NULL;
  char seed[32], dt[32];
  const char *const set[] = {seed, dt};
  snprintf(seed, sizeof seed, "seed=%d", k + 11);
  snprintf(dt, sizeof dt, "dt=%.4g", on->model->dt * (1 - 0.07 * (k + 1)));
  sd_model *m = NULL;
  assert_int_equal(sd_deck_load_text(on->text, on->path, 2, set, &m, NULL), SD_OK);
  return m;
}

/* Several systems side by side; the last one is that of the deck. */
static void run_lanes(const scene *on, const way *w, outcome *o) {
  enum { MOST = 8 };
  sd_simulation *sim[MOST] = {NULL};
  sd_model *model[MOST] = {NULL};
  sd_messages *messages[MOST];
  sd_status status[MOST];
  const int n = w->lanes, last = n - 1;
  if (!ensemble_takes(on->model)) {
    snprintf(o->left, sizeof o->left, "its points do not go in lanes");
    return;
  }
  for (int k = 0; k < n; k++) {
    model[k] = lane_model(on, k, n);
    messages[k] = sd_messages_new();
    status[k] = simulation_new(model[k] ? model[k] : on->model, 1, w->step, NULL, NULL, &sim[k],
                               messages[k]);
  }
  ensemble *e = ensemble_new((size_t)n, sim);
  size_t next = 0, in_lanes = 0;
  while (status[last] == SD_OK && !sd_simulation_finished(sim[last])) {
    const int64_t step = sd_simulation_step(sim[last]);
    ensemble_advance(e, steps_to_call(on, next, step, w->piece), status, messages);
    if (ensemble_in_lanes(e) > in_lanes) in_lanes = ensemble_in_lanes(e);
    for (; next < on->calls.n && on->calls.all[next].step == sd_simulation_step(sim[last]); next++)
      for (int k = 0; k < n; k++)
        if (status[k] == SD_OK) status[k] = steer(sim[k], &on->calls.all[next], messages[k]);
  }
  if (in_lanes < 2) snprintf(o->left, sizeof o->left, "its points went one by one");
  ensemble_free(e);
  o->status = status[last];
  keep_message(o, messages[last]);
  o->energy = sd_simulation_energy(sim[last]);
  o->end = copy_of(sd_simulation_model(sim[last]), sd_simulation_state(sim[last]));
  for (int k = 0; k < n; k++) {
    sd_simulation_free(sim[k]);
    sd_messages_free(messages[k]);
    sd_model_free(model[k]);
  }
}

static void run_ranks(const scene *on, const way *w, outcome *o) {
  if (on->calls.n > 0) {
    snprintf(o->left, sizeof o->left, "programs of one process steer");
    return;
  }
  sd_messages *messages = sd_messages_new();
  if (ranks_suit(on->model, messages) != SD_OK) {
    keep_message(o, messages);
    snprintf(o->left, sizeof o->left, "%s", o->message);
    sd_messages_free(messages);
    return;
  }
  sd_messages_free(messages);
  run r = {.deck = on->text, .steps = w->piece, .threads = w->threads};
  go(&r, w->ranks);
  o->status = r.status;
  o->energy = r.energy;
  keep_message(o, r.messages);
  o->end = r.end;
  r.end = NULL;
  end(&r);
}

static void run_way(const scene *on, const way *w, outcome *o) {
  setenv("SLIPDISK_WINDOWS", w->windows, 1);
  if (w->path[0])
    setenv("SLIPDISK_PATH", w->path, 1);
  else
    unsetenv("SLIPDISK_PATH");
  if (w->path[0] && !kernels_named(w->path))
    snprintf(o->left, sizeof o->left, "this machine lacks it");
  else if (w->ranks)
    run_ranks(on, w, o);
  else if (w->lanes)
    run_lanes(on, w, o);
  else if (w->from)
    run_other_deck(on, w, o);
  else
    run_alone(on, w, o);
}

/* Names the first column in which two states differ, and its row; of doubles also the numbers. */
static void name_column(const sd_state *a, const sd_state *b, char *what, size_t size) {
  const sd_field *f = sd_state_difference(a, b);
  const size_t n = sd_extent_size(a, f->extent), each = sd_type_size(f->type);
  const char *p = sd_field_data(a, f), *q = sd_field_data(b, f);
  size_t k = 0;
  while (k < n && n == sd_extent_size(b, f->extent) &&
         memcmp(p + k * each, q + k * each, each) == 0)
    k++;
  const int used = snprintf(what, size, "column %s of the state, row %zu", f->name, k);
  if (f->type == SD_F64 && k < n && n == sd_extent_size(b, f->extent))
    snprintf(what + used, size - (size_t)used, ": %.17g for %.17g", ((const double *)q)[k],
             ((const double *)p)[k]);
}

/* Describes the first difference of two outcomes; "": there is none. */
static const char *difference(const outcome *a, const outcome *b, char *what, size_t size) {
  what[0] = '\0';
  if (a->status != b->status)
    snprintf(what, size, "status %d for %d (%s)", (int)b->status, (int)a->status, b->message);
  else if (strcmp(a->message, b->message) != 0)
    snprintf(what, size, "\"%s\" for \"%s\"", b->message, a->message);
  else if (!a->end != !b->end)
    snprintf(what, size, "no state");
  else if (a->status == SD_OK && a->end && sd_state_difference(a->end, b->end))
    name_column(a->end, b->end, what, size);
  else if (a->status == SD_OK && memcmp(&a->energy, &b->energy, sizeof a->energy) != 0)
    snprintf(what, size, "energies");
  else if (a->end && a->end->step != b->end->step)
    snprintf(what, size, "step %lld for %lld", (long long)b->end->step, (long long)a->end->step);
  return what;
}

static const struct result_way {
  const char *name, *path, *windows;
  int threads;
  int64_t piece; /* steps after which the run is stopped, and goes on as another one */
} result_ways[] = {{"results", "baseline", "never", 1, ALL},
                   {"results, 2 threads", "", "always", 2, ALL},
                   {"results, stopped", "", "never", 1, 70},
                   {"results, stopped, 3 threads", "baseline", "always", 3, 110}};
enum { RESULT_WAYS = sizeof result_ways / sizeof *result_ways };

typedef struct stopper {
  volatile sig_atomic_t stop;
  int64_t at;
} stopper;

static void stop_at(void *user, sd_simulation *sim) {
  stopper *s = user;
  s->stop = sd_simulation_step(sim) >= s->at;
}

/* Makes the result PATH.K.h5. Returns how often the run was stopped, or -1. */
static int write_result(const scene *on, int k, char *result, size_t size) {
  const struct result_way *w = &result_ways[k];
  setenv("SLIPDISK_WINDOWS", w->windows, 1);
  if (w->path[0])
    setenv("SLIPDISK_PATH", w->path, 1);
  else
    unsetenv("SLIPDISK_PATH");
  snprintf(result, size, "%s.%d.h5", on->path, k);
  stopper how = {.at = w->piece};
  session_options options = {
      .result = result, .threads = w->threads, .stop = &how.stop, .look = stop_at, .user = &how};
  int stops = -1;
  sd_status status = SD_INTERRUPTED;
  for (; status == SD_INTERRUPTED; stops++, how.stop = 0, how.at += w->piece) {
    session *s = NULL;
    sd_messages *messages = sd_messages_new();
    status = session_open(on->model, &options, &s, messages);
    if (status == SD_OK) {
      status = session_run(s, messages);
      session_close(s);
    }
    sd_messages_free(messages);
  }
  return status == SD_OK ? stops : -1;
}

static void write_results(const scene *on) {
  bool plain_fails = false;
  for (int k = 0; k < RESULT_WAYS; k++) {
    char result[1024];
    const int stops = write_result(on, k, result, sizeof result);
    plain_fails |= k == 0 && stops < 0;
    if (stops < 0)
      printf("%s\t%s\t%s: the run fails\n", on->path, result_ways[k].name,
             plain_fails || k == 0 ? "left" : "wrong");
    else if (stops == 0 && result_ways[k].piece < ALL)
      printf("%s\t%s\tleft: no row is due where it could stop\n", on->path, result_ways[k].name);
    else
      printf("%s\t%s\t%s\n", on->path, result_ways[k].name, result);
  }
}

static char *text_of(const char *path) {
  FILE *f = fopen(path, "r");
  if (!f) return NULL;
  text all = {0};
  char line[4096];
  while (fgets(line, sizeof line, f)) text_add(&all, "%s", line);
  fclose(f);
  return all.s;
}

/* Returns the status of the program. */
static int try_deck(const char *path, bool with_threads, bool results) {
  char *deck = text_of(path);
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  int worst = 0;
  if (!deck || sd_deck_load_text(deck, path, 0, NULL, &m, messages) != SD_OK) {
    printf("%s\tplain\trefused: %s\n", path,
           sd_messages_count(messages) ? sd_messages_text(messages, 0) : "it cannot be read");
  }
  sd_messages_free(messages);
  const scene on = {path, deck, m, deck ? calls_of(deck) : (calls){0}};
  outcome plain = {0};
  if (m && results) write_results(&on);
  for (int k = 0; m && !results && k < WAYS; k++) {
    if (!with_threads && (ways[k].threads > 1 || ways[k].ranks)) continue;
    char what[900];
    outcome o = {0};
    run_way(&on, &ways[k], k == PLAIN ? &plain : &o);
    const char *wrong = k != PLAIN && o.end ? difference(&plain, &o, what, sizeof what) : "";
    if (k == PLAIN && plain.status != SD_OK)
      printf("%s\tplain\tends: %s\n", path, plain.message);
    else if (wrong[0])
      printf("%s\t%s\twrong: %s\n", path, ways[k].name, wrong);
    else if (o.left[0])
      printf("%s\t%s\tleft: %s\n", path, ways[k].name, o.left);
    else if (k == PLAIN)
      printf("%s\tplain\tsame: %016llx\n", path, (unsigned long long)sd_state_hash(plain.end));
    else
      printf("%s\t%s\tsame\n", path, ways[k].name);
    if (wrong[0]) worst = 1;
    sd_state_free(o.end);
  }
  sd_state_free(plain.end);
  sd_model_free(m);
  free(deck);
  return worst;
}

static void tell(const char *why) { fprintf(stderr, "a rank fails: %s\n", why); }

int main(int n, char **words) {
  int worst = 0;
  comm_on_fail(tell);
  setenv("SLIPDISK_CHUNK", "8", 0);
  if (n == 2 && strcmp(words[1], "--list") == 0) {
    for (int k = 0; k < WAYS; k++) puts(ways[k].name);
    for (int k = 0; k < RESULT_WAYS; k++) puts(result_ways[k].name);
    return 0;
  }
  const bool alone = n > 1 && strcmp(words[1], "--alone") == 0;
  const bool results = n > 1 && strcmp(words[1], "--results") == 0;
  for (int k = 1 + (alone || results); k < n; k++) {
    const int status = try_deck(words[k], !alone, results);
    if (status > worst) worst = status;
    fflush(stdout);
  }
  return worst;
}
