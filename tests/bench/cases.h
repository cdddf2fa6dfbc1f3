/* cases.h: what bench_steps.c times: systems x integrators x instruction sets, each a simulation of one thread.
 *
 * A system is a deck that ships, with overrides that make its last phase endless, or a packing made here. It
 * is settled once, with velocity Verlet on the fastest path; all its cases go on from a copy of that state.
 * Only sd_simulation_advance is timed: nothing is stored, but all that the deck measures is measured.
 */
#ifndef BENCH_CASES_H
#define BENCH_CASES_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

enum { MAX_OVERRIDES = 4, MAX_CASES = 64 };

typedef struct bench_system {
  const char *name;
  const char *deck;                     /* below inputs/; NULL: the packing */
  const char *overrides[MAX_OVERRIDES]; /* up to the first NULL */
  double settle;                        /* time units until the timing begins */
} bench_system;

static const bench_system systems[] = {
    {"random", "three_disk/random.cfg", {"phases.settle.steps=3e5", "phases.measure.steps=1e15"}, 0.4},
    {"sync", "three_disk/sync.cfg", {"phases.rest.steps=2e5", "phases.measure.steps=1e15"}, 0.3},
    {"steady", "three_disk/steady.cfg", {"phases.settle.steps=2e5", "phases.measure.steps=1e15"}, 0.3},
    {"epo", "epo/symmetric.cfg", {"phases.rest.steps=2e5", "phases.measure.steps=1e15"}, 0.8},
    {"heap", "packing/heap.cfg", {"phases.settle.steps=1e5", "phases.rest.steps=1e15"}, 2.1},
    {"packing", NULL, {NULL}, 0.6},
};
enum { SYSTEMS = sizeof systems / sizeof *systems };

static const char *const integrators[] = {"gear5", "verlet"};
static const char *const paths[] = {"avx512", "avx2", "baseline"};

typedef struct bench_case {
  const bench_system *system;
  const char *integrator, *path;
  char name[64];
  sd_model *model;
  sd_simulation *simulation;
  int64_t steps; /* per repeat; 0: not ready */
  size_t free_disks, contacts;
} bench_case;

static _Noreturn void give_up(const char *what, sd_messages *messages) {
  fprintf(stderr, "bench: %s\n", what);
  if (messages) sd_messages_print(messages, stderr);
  exit(EXIT_FAILURE);
}

/* CPU time of this thread: time for which other processes hold the core does not count. */
static double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- decks ------------------------------------------------------------------------------------------- */

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
  int n = snprintf(text, ROOM,
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

static sd_model *load(const bench_system *system, const char *integrator) {
  char choice[64], file[1024];
  snprintf(choice, sizeof choice, "integrator=%s", integrator);
  const char *overrides[MAX_OVERRIDES + 1] = {choice};
  size_t n = 1;
  for (size_t k = 0; k < MAX_OVERRIDES && system->overrides[k]; k++) overrides[n++] = system->overrides[k];
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

/* --- simulations ------------------------------------------------------------------------------------- */

static void advance(sd_simulation *simulation, int64_t steps) {
  sd_messages *messages = sd_messages_new();
  if (sd_simulation_advance(simulation, steps, messages) != SD_OK) give_up("the run failed", messages);
  sd_messages_free(messages);
}

static sd_simulation *made[SYSTEMS];

/* Settled simulation of a system, made when it is first asked for. */
static sd_simulation *settled(const bench_system *system) {
  sd_simulation **at = &made[system - systems];
  if (*at) return *at;
  sd_messages *messages = sd_messages_new();
  sd_model *model = load(system, "verlet");
  unsetenv("SLIPDISK_PATH");
  if (sd_simulation_new(model, 1, at, messages) != SD_OK) give_up(system->name, messages);
  sd_messages_free(messages);
  advance(*at, (int64_t)(system->settle / model->dt));
  return *at;
}

static sd_state *copy_of(const sd_model *model, const sd_state *from) {
  sd_state *to = sd_state_new(model);
  if (!from || !to || sd_state_reserve_contacts(to, from->n_contacts) != SD_OK)
    give_up("out of memory", NULL);
  to->n_contacts = from->n_contacts;
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    size_t bytes = sd_extent_size(from, f->extent) * sd_type_size(f->type);
    if (bytes) memcpy(sd_field_data(to, f), sd_field_data(from, f), bytes);
  }
  return to;
}

/* Is this what a simulation gets that asks for the path? */
static bool path_runs_here(const char *path) {
  sd_model *model = load(&systems[0], "verlet");
  sd_simulation *simulation = NULL;
  setenv("SLIPDISK_PATH", path, 1);
  if (sd_simulation_new(model, 1, &simulation, NULL) != SD_OK) give_up("no simulation", NULL);
  bool runs = strcmp(sd_simulation_path(simulation), path) == 0;
  sd_simulation_free(simulation);
  sd_model_free(model);
  return runs;
}

/* One repeat: ns per step. */
static double time_once(const bench_case *c) {
  double before = cpu_seconds();
  advance(c->simulation, c->steps);
  return 1e9 * (cpu_seconds() - before) / (double)c->steps;
}

/* Copies the settled state, warms up, and chooses the steps so that a repeat takes about `seconds`. */
static void prepare(bench_case *c, double seconds) {
  if (c->steps > 0) return;
  const sd_state *from = sd_simulation_state(settled(c->system));
  sd_messages *messages = sd_messages_new();
  c->model = load(c->system, c->integrator);
  setenv("SLIPDISK_PATH", c->path, 1);
  if (sd_simulation_resume(c->model, copy_of(c->model, from), 1, &c->simulation, messages) != SD_OK)
    give_up(c->name, messages);
  sd_messages_free(messages);
  c->free_disks = from->n_free;
  c->contacts = from->n_contacts;
  double spent = 0.0;
  for (c->steps = 64; spent < 0.2 * seconds; c->steps *= 2) spent = 1e-9 * time_once(c) * (double)c->steps;
  c->steps = (int64_t)((double)c->steps * 0.5 * seconds / spent / 64.0 + 1.0) * 64;
}

/* Every case whose name holds `only` (NULL: all). */
static size_t list_cases(bench_case *list, const char *only) {
  size_t n = 0;
  for (size_t s = 0; s < SYSTEMS; s++)
    for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++)
      for (size_t p = 0; p < sizeof paths / sizeof *paths; p++) {
        bench_case *c = &list[n];
        *c = (bench_case){.system = &systems[s], .integrator = integrators[i], .path = paths[p]};
        snprintf(c->name, sizeof c->name, "%s/%s/%s", systems[s].name, integrators[i], paths[p]);
        if ((!only || strstr(c->name, only)) && path_runs_here(paths[p])) n++;
      }
  return n;
}

static void free_case(bench_case *c) {
  sd_simulation_free(c->simulation);
  sd_model_free(c->model);
  *c = (bench_case){0};
}

static void free_settled(void) {
  for (size_t k = 0; k < SYSTEMS; k++) {
    if (!made[k]) continue;
    sd_model *model = (sd_model *)(uintptr_t)sd_simulation_model(made[k]);
    sd_simulation_free(made[k]);
    sd_model_free(model);
    made[k] = NULL;
  }
}

#endif
