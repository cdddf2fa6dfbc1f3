/* ways.c: runs decks in every way there is, and compares each with the plainest one.
 *
 *   ways DECK...     a line per deck and way: deck, way, what came of it (tabs between):
 *     same              the way takes the deck, and gives the same bits, energies and messages
 *     left: REASON      the way does not take the deck, and says so
 *     wrong: WHAT       it gives something else
 *     ends, refused: MESSAGE   of the plainest way: the run fails, the deck is refused
 *   ways --alone DECK...   only the ways of one thread
 *   ways --list      names of the ways
 *
 * The plainest way is one thread, the narrowest vectors, the general step, one step at a time.
 * Small chunks (SLIPDISK_CHUNK) let decks of a few dozen disks be taken in windows. The status is 1
 * if any way was wrong.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "physics/system/kernels.h"
#include "ranks_run.h"
#include "run/ensemble.h"

/* How a deck is run. */
typedef struct way {
  const char *name, *path, *windows;
  int threads, ranks;
  simulation_step step;
  int64_t piece; /* steps at a time, with `between` after each */
  enum { GOES_ON, COPIED, SAVED, REBUILT } between;
  int lanes; /* systems side by side */
} way;

enum { PLAIN, ALL = 1 << 20 };
static const way ways[] = {
    [PLAIN] = {"plain", "baseline", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"pieces", "baseline", "never", 1, 0, SIMULATION_GENERAL, 7, GOES_ON, 0},
    {"avx2", "avx2", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"avx512", "avx512", "never", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"2 threads", "", "never", 2, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"3 threads", "baseline", "never", 3, 0, SIMULATION_GENERAL, 110, GOES_ON, 0},
    {"windows", "baseline", "always", 1, 0, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"windows, 2 threads", "", "always", 2, 0, SIMULATION_GENERAL, 130, GOES_ON, 0},
    {"small step", "baseline", "never", 1, 0, SIMULATION_SUITABLE, ALL, GOES_ON, 0},
    {"lanes", "", "never", 1, 0, SIMULATION_SUITABLE, 90, GOES_ON, 3},
    {"2 ranks", "baseline", "never", 1, 2, SIMULATION_GENERAL, ALL, GOES_ON, 0},
    {"3 ranks, 2 threads", "", "never", 2, 3, SIMULATION_GENERAL, 170, GOES_ON, 0},
    {"state copied", "baseline", "never", 1, 0, SIMULATION_GENERAL, 31, COPIED, 0},
    {"state copied, other threads", "", "always", 2, 0, SIMULATION_SUITABLE, 47, COPIED, 0},
    {"saved and restored", "baseline", "never", 1, 0, SIMULATION_SUITABLE, 149, SAVED, 0},
    {"lists rebuilt", "baseline", "always", 1, 0, SIMULATION_GENERAL, 13, REBUILT, 0},
};
enum { WAYS = sizeof ways / sizeof *ways };

/* Outcome of a run in one way. */
typedef struct outcome {
  sd_status status;
  sd_state *end;
  sd_energy energy;
  char message[400], left[400]; /* the first message; why the way does not take the deck */
} outcome;

static void keep_message(outcome *o, const sd_messages *m) {
  if (sd_messages_count(m)) snprintf(o->message, sizeof o->message, "%s", sd_messages_text(m, 0));
}

/* --- one process ------------------------------------------------------------------------------ */

static sd_simulation *begin(const sd_model *m, const way *w, outcome *o, sd_messages *messages) {
  sd_simulation *sim = NULL;
  o->status = simulation_new(m, w->threads, w->step, NULL, NULL, &sim, messages);
  return sim;
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

static sd_simulation *interrupt(sd_simulation *sim, const way *w, outcome *o,
                                sd_messages *messages) {
  if (w->between == REBUILT) o->status = sd_simulation_rebuild(sim, messages);
  if (w->between == SAVED) return saved_and_restored(sim, w, o, messages);
  if (w->between != COPIED) return sim;
  const sd_model *model = sd_simulation_model(sim);
  sd_state *state = copy_of(model, sd_simulation_state(sim));
  sd_simulation *next = NULL;
  o->status =
      simulation_resume(model, state, NULL, w->threads, w->step, NULL, NULL, &next, messages);
  if (o->status != SD_OK) return sim;
  sd_simulation_free(sim);
  return next;
}

static void run_alone(const sd_model *m, const way *w, outcome *o) {
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = begin(m, w, o, messages);
  if (sim && w->step == SIMULATION_SUITABLE && w->between == GOES_ON && !simulation_is_small(sim))
    snprintf(o->left, sizeof o->left, "the general step is taken");
  while (o->status == SD_OK && !o->left[0] && !sd_simulation_finished(sim)) {
    o->status = sd_simulation_advance(sim, w->piece, messages);
    if (o->status == SD_OK && !sd_simulation_finished(sim)) sim = interrupt(sim, w, o, messages);
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

/* Several equal systems side by side; the last one counts. */
static void run_lanes(const sd_model *m, const way *w, outcome *o) {
  enum { MOST = 4 };
  sd_simulation *sim[MOST] = {NULL};
  sd_messages *messages[MOST];
  sd_status status[MOST];
  const size_t n = (size_t)w->lanes;
  if (!ensemble_takes(m)) {
    snprintf(o->left, sizeof o->left, "its points do not go in lanes");
    return;
  }
  for (size_t k = 0; k < n; k++) {
    messages[k] = sd_messages_new();
    status[k] = simulation_new(m, 1, w->step, NULL, NULL, &sim[k], messages[k]);
  }
  ensemble *e = ensemble_new(n, sim);
  while (status[n - 1] == SD_OK && !sd_simulation_finished(sim[n - 1]))
    ensemble_advance(e, w->piece, status, messages);
  if (ensemble_in_lanes(e) < 2) snprintf(o->left, sizeof o->left, "its points went one by one");
  ensemble_free(e);
  o->status = status[n - 1];
  keep_message(o, messages[n - 1]);
  o->energy = sd_simulation_energy(sim[n - 1]);
  o->end = copy_of(m, sd_simulation_state(sim[n - 1]));
  for (size_t k = 0; k < n; k++) {
    sd_simulation_free(sim[k]);
    sd_messages_free(messages[k]);
  }
}

/* --- ranks ------------------------------------------------------------------------------------ */

static void run_ranks(const char *deck, const sd_model *m, const way *w, outcome *o) {
  sd_messages *messages = sd_messages_new();
  if (ranks_suit(m, messages) != SD_OK) {
    keep_message(o, messages);
    snprintf(o->left, sizeof o->left, "%s", o->message);
    sd_messages_free(messages);
    return;
  }
  sd_messages_free(messages);
  run r = {.deck = deck, .steps = w->piece, .threads = w->threads};
  go(&r, w->ranks);
  o->status = r.status;
  o->energy = r.energy;
  keep_message(o, r.messages);
  o->end = r.end;
  r.end = NULL;
  end(&r);
}

/* --- comparison ------------------------------------------------------------------------------- */

static void run_way(const char *deck, const sd_model *m, const way *w, outcome *o) {
  setenv("SLIPDISK_WINDOWS", w->windows, 1);
  if (w->path[0])
    setenv("SLIPDISK_PATH", w->path, 1);
  else
    unsetenv("SLIPDISK_PATH");
  if (w->path[0] && !kernels_named(w->path))
    snprintf(o->left, sizeof o->left, "this machine lacks it");
  else if (w->ranks)
    run_ranks(deck, m, w, o);
  else if (w->lanes)
    run_lanes(m, w, o);
  else
    run_alone(m, w, o);
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
static int try_deck(const char *path, bool with_threads) {
  char *deck = text_of(path);
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  int worst = 0;
  if (!deck || sd_deck_load_text(deck, path, 0, NULL, &m, messages) != SD_OK) {
    printf("%s\tplain\trefused: %s\n", path,
           sd_messages_count(messages) ? sd_messages_text(messages, 0) : "it cannot be read");
  }
  sd_messages_free(messages);
  outcome plain = {0};
  for (int k = 0; m && k < WAYS; k++) {
    if (!with_threads && (ways[k].threads > 1 || ways[k].ranks)) continue;
    char what[900];
    outcome o = {0};
    run_way(deck, m, &ways[k], k == PLAIN ? &plain : &o);
    const char *wrong = k != PLAIN && o.end ? difference(&plain, &o, what, sizeof what) : "";
    if (k == PLAIN && plain.status != SD_OK)
      printf("%s\tplain\tends: %s\n", path, plain.message);
    else if (wrong[0])
      printf("%s\t%s\twrong: %s\n", path, ways[k].name, wrong);
    else if (o.left[0])
      printf("%s\t%s\tleft: %s\n", path, ways[k].name, o.left);
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
    return 0;
  }
  const bool alone = n > 1 && strcmp(words[1], "--alone") == 0;
  for (int k = 1 + alone; k < n; k++) {
    const int status = try_deck(words[k], !alone);
    if (status > worst) worst = status;
    fflush(stdout);
  }
  return worst;
}
