/* cases.h: what bench_steps.c times: systems x integrators x instruction sets, each on one thread; small systems by
 * themselves and as ensembles that fill one vector or two ("/lanes", "/lanes2").
 *
 * A system is a deck that ships, with overrides that make its last phase endless, or a packing made here. Members of an
 * ensemble differ in seed, tilt and drive; the first is the deck itself. Each is settled once, with velocity
 * Verlet on the fastest path; all cases go on from a copy of that state. Only sd_simulation_advance and ensemble_advance
 * are timed: nothing is stored, but all that the deck measures is measured.
 */
#ifndef BENCH_CASES_H
#define BENCH_CASES_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "run/ensemble.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

enum { MAX_OVERRIDES = 4, MAX_CASES = 128, MAX_MEMBERS = 32, TILTS = 5, DRIVES = 4 };

typedef struct bench_system {
  const char *name;
  const char *deck;                     /* below inputs/; NULL: the packing */
  const char *overrides[MAX_OVERRIDES]; /* up to the first NULL */
  double settle;                        /* time units until the timing begins */
  size_t ensembles;                     /* up to how many full vectors of members are timed */
  const char *key, *drives[DRIVES];     /* what members are driven by, besides the first */
} bench_system;

#define ENDLESS(first)                                                                             \
  { "phases." first, "phases.measure.steps=1e15" }
#define TURNING(type)                                                                              \
  { "phases.rest.steps=2e5", "phases.measure.steps=1e15", "motions[*].type=" type }
#define SHAKEN                                                                                     \
  "motions[*].amplitude", { "1e-4", "4e-5", "8e-5", "2e-5" }
#define TURNED                                                                                     \
  "motions[*].amplitude", { "0.04", "1e-3", "0.01", "0.1" }
static const char *const tilts[TILTS] = {"0.04 pi", "0", "0.02 pi", "0.08 pi", "0.06 pi"};

static const bench_system systems[] = {
    {"random", "three_disk/random.cfg", ENDLESS("settle.steps=3e5"), 0.4, 2, SHAKEN},
    {"random10",
     "three_disk/random.cfg",
     {"phases.settle.steps=3e5", "phases.measure.steps=1e15", "motions[*].interval=10"},
     0.4,
     1,
     SHAKEN},
    {"visits",
     "three_disk/random.cfg",
     {"phases.settle.steps=3e5", "phases.measure.steps=1e15", "measure.configurations=true"},
     0.4,
     1,
     SHAKEN},
    {"sync", "three_disk/sync.cfg", TURNING("parabolic"), 0.3, 1, TURNED},
    {"harmonic", "three_disk/sync.cfg", TURNING("harmonic"), 0.3, 2, TURNED},
    {"steady",
     "three_disk/steady.cfg",
     ENDLESS("settle.steps=2e5"),
     0.3,
     1,
     "motions[*].velocity",
     {"-1", "0.5", "-2", "1"}},
    {"epo", "epo/symmetric.cfg", ENDLESS("rest.steps=2e5"), 0.8, 0, NULL, {NULL}},
    {"heap",
     "packing/heap.cfg",
     {"phases.settle.steps=1e5", "phases.rest.steps=1e15"},
     2.1,
     0,
     NULL,
     {NULL}},
    {"relax",
     "packing/heap.cfg",
     {"phases.settle.steps=1e5", "phases.rest.steps=1e15", "phases.rest.relax=true"},
     2.1,
     0,
     NULL,
     {NULL}},
    {"packing", NULL, {NULL}, 0.6, 0, NULL, {NULL}},
};
enum { SYSTEMS = sizeof systems / sizeof *systems };

static const char *const integrators[] = {"gear5", "verlet"};
static const char *const paths[] = {"avx512", "avx2", "baseline"};
enum {
  INTEGRATORS = sizeof integrators / sizeof *integrators,
  PATHS = sizeof paths / sizeof *paths
};

typedef struct bench_case {
  const bench_system *system;
  const char *integrator, *path;
  size_t vectors; /* of an ensemble; 0: one simulation by itself */
  char name[64];
  size_t members;
  sd_model *model[MAX_MEMBERS];
  sd_simulation *simulation[MAX_MEMBERS];
  sd_status status[MAX_MEMBERS];
  sd_messages *messages[MAX_MEMBERS];
  ensemble *ensemble;
  int64_t steps; /* per repeat; 0: not ready */
  size_t free_disks, contacts;
} bench_case;

static _Noreturn void give_up(const char *what, sd_messages *messages) {
  fprintf(stderr, "bench: %s\n", what);
  if (messages) sd_messages_print(messages, stderr);
  exit(EXIT_FAILURE);
}

static void *room(size_t n, size_t size) {
  void *p = calloc(n, size);
  if (!p) give_up("out of memory", NULL);
  return p;
}

/* CPU time of this thread: time for which other processes hold the core does not count. */
static double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Numbers in [0, 1), the same on every machine. */
static double next_uniform(uint32_t *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (*seed >> 8) * 0x1p-24;
}

/* 1000 disks, radii 0.8 to 1.2 of the mean, stacked loosely on a flat floor, periodic along x. */
static char *packing_deck(void) {
  enum { WIDE = 40, HIGH = 25, ROOM = 1 << 17 };
  const double mean = 0.02, spacing = 2.45 * mean;
  char *text = malloc(ROOM);
  if (!text) give_up("out of memory", NULL);
  int n = snprintf(
      text, ROOM,
      "dt = 2e-5; gravity = { g = 9.81; };\n"
      "box = { x = (0.0, %.17g); periodic = \"x\"; };\n"
      "materials = ( { name = \"grain\"; k_n = 1e4; k_t = 5e3; gamma_n = 5; mu = 0.5; } );\n"
      "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );\n"
      "phases = ( { steps = 1e15; } );\n"
      "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (",
      WIDE * spacing);
  uint32_t seed = 1;
  for (int k = 0; k < WIDE * HIGH; k++) {
    int row = k / WIDE;
    double x = spacing * (k % WIDE + 0.5 * (row % 2)), y = spacing * (0.5 + 0.87 * row);
    n += snprintf(text + n, (size_t)(ROOM - n), "%s(%.6f, %.6f, %.6f)", k ? ", " : "", x, y,
                  mean * (0.8 + 0.4 * next_uniform(&seed)));
  }
  snprintf(text + n, (size_t)(ROOM - n), ") } );\n");
  return text;
}

static sd_model *load(const bench_system *system, const char *integrator, size_t member) {
  char choice[4][64], file[1024];
  snprintf(choice[0], sizeof *choice, "integrator=%s", integrator);
  snprintf(choice[1], sizeof *choice, "seed=%zu", member + 1);
  snprintf(choice[2], sizeof *choice, "gravity.tilt=%s", tilts[member % TILTS]);
  if (member > 0)
    snprintf(choice[3], sizeof *choice, "%s=%s", system->key, system->drives[member % DRIVES]);
  const char *overrides[MAX_OVERRIDES + 4];
  size_t n = 0;
  for (size_t k = 0; k < MAX_OVERRIDES && system->overrides[k]; k++)
    overrides[n++] = system->overrides[k];
  for (size_t k = 0; k < (member > 0 ? 4 : 1); k++) overrides[n++] = choice[k];
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  if (system->deck) {
    snprintf(file, sizeof file, "%s/inputs/%s", SLIPDISK_SOURCE_DIR, system->deck);
    sd_deck_load(file, n, overrides, &model, messages);
  } else {
    char *text = packing_deck();
    sd_deck_load_text(text, "packing", n, overrides, &model, messages);
    free(text);
  }
  if (!model) give_up(system->name, messages);
  sd_messages_free(messages);
  return model;
}

static void advance(bench_case *c, int64_t steps) {
  if (c->ensemble)
    ensemble_advance(c->ensemble, steps, c->status, c->messages);
  else
    c->status[0] = sd_simulation_advance(c->simulation[0], steps, c->messages[0]);
  for (size_t k = 0; k < c->members; k++)
    if (c->status[k] != SD_OK) give_up(c->name, c->messages[k]);
}

/* Puts the members [from, from + n) of the case together. */
static void join(bench_case *c, size_t from, size_t n) {
  c->ensemble = ensemble_new(n, c->simulation + from);
}

/* Settled simulations of each system, made when they are first asked for. */
static bench_case made[SYSTEMS];

static sd_simulation *const *settled(const bench_system *system, size_t members) {
  bench_case *c = &made[system - systems];
  if (c->members >= members) return c->simulation;
  bench_case added = {.system = system, .members = members - c->members};
  snprintf(added.name, sizeof added.name, "%s", system->name);
  unsetenv("SLIPDISK_PATH");
  for (size_t k = 0; k < added.members; k++) {
    added.messages[k] = sd_messages_new();
    added.model[k] = load(system, "verlet", c->members + k);
    if (sd_simulation_new(added.model[k], 1, &added.simulation[k], added.messages[k]) != SD_OK)
      give_up(system->name, added.messages[k]);
  }
  join(&added, 0, added.members);
  advance(&added, (int64_t)(system->settle / added.model[0]->dt));
  ensemble_free(added.ensemble);
  for (size_t k = 0; k < added.members; k++) {
    c->messages[c->members] = added.messages[k];
    c->model[c->members] = added.model[k];
    c->simulation[c->members++] = added.simulation[k];
  }
  return c->simulation;
}

static sd_state *copy_of(const sd_model *model, const sd_state *from) {
  sd_state *to = sd_state_new(model);
  if (!from || !to || state_size_like(to, from) != SD_OK) give_up("out of memory", NULL);
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    size_t bytes = sd_extent_size(from, f->extent) * sd_type_size(f->type);
    if (bytes) memcpy(sd_field_data(to, f), sd_field_data(from, f), bytes);
  }
  return to;
}

/* Is this what a simulation gets that asks for the path? */
static bool path_runs_here(const char *path) {
  sd_model *model = load(&systems[0], "verlet", 0);
  sd_simulation *simulation = NULL;
  setenv("SLIPDISK_PATH", path, 1);
  if (sd_simulation_new(model, 1, &simulation, NULL) != SD_OK) give_up("no simulation", NULL);
  bool runs = strcmp(sd_simulation_path(simulation), path) == 0;
  sd_simulation_free(simulation);
  sd_model_free(model);
  return runs;
}

/* One repeat: ns per step of one system. */
static double time_once(bench_case *c) {
  double before = cpu_seconds();
  advance(c, c->steps);
  return 1e9 * (cpu_seconds() - before) / (double)(c->steps * (int64_t)c->members);
}

/* Copies the settled states; on the path of the case. */
static void make_members(bench_case *c) {
  setenv("SLIPDISK_PATH", c->path, 1);
  size_t width = ensemble_width();
  c->members = c->vectors ? c->vectors * width : 1;
  if (c->members > MAX_MEMBERS) give_up("more lanes than MAX_MEMBERS", NULL);
  sd_simulation *const *from = settled(c->system, c->members);
  setenv("SLIPDISK_PATH", c->path, 1);
  for (size_t k = 0; k < c->members; k++) {
    c->messages[k] = sd_messages_new();
    c->model[k] = load(c->system, c->integrator, k);
    sd_state *state = copy_of(c->model[k], sd_simulation_state(from[k]));
    if (sd_simulation_resume(c->model[k], state, 1, &c->simulation[k], c->messages[k]) != SD_OK)
      give_up(c->name, c->messages[k]);
    if (strcmp(sd_simulation_path(c->simulation[k]), c->path) != 0)
      give_up("not on its path", NULL);
  }
  const sd_state *first = sd_simulation_state(c->simulation[0]);
  c->free_disks = first->n_free;
  c->contacts = first->n_contacts;
  if (!c->vectors) return;
  join(c, 0, c->members);
  advance(c, 64);
  if (ensemble_in_lanes(c->ensemble) < width) give_up("members that do not go in lanes", NULL);
}

/* Makes the members, warms up, and chooses the steps so that a repeat takes about `seconds`. */
static void prepare(bench_case *c, double seconds) {
  if (c->steps > 0) return;
  make_members(c);
  double spent = 0.0;
  for (c->steps = 64; spent < 0.2 * seconds; c->steps *= 2)
    spent = 1e-9 * time_once(c) * (double)c->steps * (double)c->members;
  c->steps = (int64_t)((double)c->steps * 0.5 * seconds / spent / 64.0 + 1.0) * 64;
}

/* Is one of the words, with commas between them, part of the name? NULL: yes. */
static bool is_asked(const char *name, const char *only) {
  char words[512], *rest = words;
  if (!only) return true;
  snprintf(words, sizeof words, "%s", only);
  for (const char *word; (word = strsep(&rest, ","));)
    if (*word && strstr(name, word)) return true;
  return false;
}

/* Every case that is asked for and runs here. */
static size_t list_cases(bench_case *list, const char *only) {
  enum { KINDS = 3 };
  static const char *const kinds[KINDS] = {"", "/lanes", "/lanes2"};
  bool runs[PATHS];
  size_t n = 0;
  for (size_t p = 0; p < PATHS; p++) runs[p] = path_runs_here(paths[p]);
  for (size_t s = 0; s < SYSTEMS; s++)
    for (size_t i = 0; i < INTEGRATORS; i++)
      for (size_t p = 0; p < PATHS; p++)
        for (size_t v = 0; v < KINDS && v <= systems[s].ensembles; v++) {
          bench_case *c = &list[n];
          *c = (bench_case){
              .system = &systems[s], .integrator = integrators[i], .path = paths[p], .vectors = v};
          snprintf(c->name, sizeof c->name, "%s/%s/%s%s", systems[s].name, integrators[i], paths[p],
                   kinds[v]);
          if (runs[p] && is_asked(c->name, only)) n++;
        }
  return n;
}

static void free_case(bench_case *c) {
  ensemble_free(c->ensemble);
  for (size_t k = 0; k < c->members; k++) {
    sd_simulation_free(c->simulation[k]);
    sd_model_free(c->model[k]);
    sd_messages_free(c->messages[k]);
  }
  *c = (bench_case){0};
}

static void free_settled(void) {
  for (size_t k = 0; k < SYSTEMS; k++) free_case(&made[k]);
}

#endif
