/* check.c: `slipdisk check DECK` checks a deck, prints it in full and estimates its run time.
 *
 * The output is a deck again: the full one, followed by the findings as comments. */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "app/app.h"
#include "app/check/check.h"
#include "app/sweep/sweep.h"
#include "base/team.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "model/model.h"
#include "run/ensemble.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

static const double probe_seconds = 0.2;

typedef struct options {
  const char *deck;
  option_list overrides;
  bool brief, no_probe, keys, json;
} options;

static const option_row rows[] = {
    {"define", 'D', OPTION_LIST, offsetof(options, overrides), NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"brief", 0, OPTION_FLAG, offsetof(options, brief), NULL, NULL, "leave the full deck out"},
    {"no-probe", 0, OPTION_FLAG, offsetof(options, no_probe), NULL, NULL,
     "do not measure the speed"},
    {"json", 0, OPTION_FLAG, offsetof(options, json), NULL, NULL,
     "all of it as JSON, messages included"},
    {"keys", 0, OPTION_FLAG, offsetof(options, keys), NULL, NULL,
     "print the tables of all keys, and nothing else"},
    CONFINED_OPTION,
};
const command_line app_check_line = {
    .name = "check",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_DECK,
    .offset = offsetof(options, deck),
    .optional = true,
    .operands = "DECK",
    .summary = "Checks a deck, prints it with all defaults, estimates the run time",
    .more = "Told are numbers of disks, walls and contacts, the time step against the shortest "
            "contact period,\n"
            "restitution of each pair of materials, size of the result, speed and length of the "
            "run. All points "
            "of a\n"
            "sweep are checked, too. A DECK of - is the standard input.\n",
    .examples = "slipdisk check deck.cfg                 # mistakes, all keys, limits, run time\n"
                "slipdisk check deck.cfg --brief -D gravity.tilt=0.2\n"};

/* --- speed ------------------------------------------------------------------------------------ */

/* Measures the speed: runs the deck for about probe_seconds, but at least its first steps. */
static sd_status probe(check_found *f, sd_messages *messages) {
  sd_simulation *s = NULL;
  sd_status status = sd_simulation_new(f->model, 0, &s, messages);
  if (status != SD_OK) return status;
  const sd_state *first = sd_simulation_state(s);
  f->probed = first;
  if (first) f->contacts = first->n_contacts;
  if (!first) status = sd_fail(messages, SD_ERROR_IO, "no memory for the contacts of the state");
  int64_t chunk = 16;
  double start = clock_seconds(), spent = 0;
  while (status == SD_OK && !sd_simulation_finished(s) && spent < probe_seconds) {
    status = sd_simulation_advance(s, chunk, messages);
    f->tried = sd_simulation_stage(s).step;
    spent = clock_seconds() - start;
    if (chunk < 1 << 20 && spent < probe_seconds / 4) chunk *= 2;
  }
  if (status != SD_OK || spent <= 0) f->tried = 0;
  if (f->tried > 0) f->speed = (double)f->tried / spent;
  f->threads = sd_simulation_threads(s);
  snprintf(f->path, sizeof f->path, "%s", sd_simulation_path(s));
  sd_simulation_free(s);
  return status;
}

/* --- sweep ------------------------------------------------------------------------------------ */

/* Wall time per step on this machine, to estimate the wall time of a sweep. */
typedef struct pace {
  double alone; /* Wall time per step of one system computed by itself, s; 0: not known */
  /* Wall time per step of a group of systems in the SIMD lanes, s; the same for any number of
   * systems up to `width`; 0: no SIMD lanes, or not known */
  double together;
  size_t width;
} pace;

/* Returns the wall time per step of `width` systems in the SIMD lanes, s, measured with copies of
 * the deck's system in all lanes; 0: not known. */
static double probe_lanes(const sd_model *m, size_t width) {
  sd_simulation **all = memory_new(width, sizeof *all);
  sd_messages **messages = memory_new(width, sizeof *messages);
  sd_status *status = memory_new(width, sizeof *status);
  ensemble *e = NULL;
  bool good = true;
  for (size_t k = 0; good && k < width; k++) {
    messages[k] = sd_messages_new();
    good = sd_simulation_new(m, 1, &all[k], messages[k]) == SD_OK;
  }
  if (good) e = ensemble_new(width, all);
  double start = clock_seconds(), spent = 0;
  for (int64_t chunk = 16; good && !sd_simulation_finished(all[0]) && spent < probe_seconds;) {
    ensemble_advance(e, chunk, status, messages);
    spent = clock_seconds() - start;
    good = status[0] == SD_OK && ensemble_in_lanes(e) == width;
    if (chunk < 1 << 20 && spent < probe_seconds / 4) chunk *= 2;
  }
  double done = good ? (double)sd_simulation_stage(all[0]).step : 0;
  ensemble_free(e);
  for (size_t k = 0; k < width; k++) {
    sd_simulation_free(all[k]);
    sd_messages_free(messages[k]);
  }
  free(all);
  free(messages);
  free(status);
  return done > 0 ? spent / done : 0;
}

typedef struct entry {
  int kind;
  int64_t steps;
} entry;

static int by_kind(const void *a, const void *b) {
  const entry *p = a, *q = b;
  if (p->kind != q->kind) return p->kind < q->kind ? -1 : 1;
  return p->steps > q->steps ? -1 : p->steps < q->steps;
}

/* Returns the wall time of all points (runs) of the sweep with one worker process, s. Points are
 * put into groups as the command `sweep` does; a group takes as long as its longest point. */
static double sweep_time(entry *entries, size_t n, const pace *p) {
  double time = 0;
  qsort(entries, n, sizeof *entries, by_kind);
  for (size_t k = 0, size; k < n; k += size) {
    bool lanes = p->together > 0 && entries[k].kind != SWEEP_ALONE;
    for (size = 1; lanes && size < p->width && k + size < n; size++)
      if (entries[k + size].kind != entries[k].kind) break;
    time += (double)entries[k].steps * (size > 1 ? p->together : p->alone);
  }
  return time;
}

/* Fills `found` with the number of points (runs) of the sweep, their number of steps and their wall
 * time. */
static void note_sweep(const sweep *s, entry *entries, const pace *p, check_sweep *found) {
  *found = (check_sweep){
      .points = s->deck.n_points, .sets = s->deck.n_sets, .width = p->width, .seconds = NAN};
  for (size_t k = 0; k < found->points; k++) {
    found->steps += (double)entries[k].steps;
    found->together += entries[k].kind != SWEEP_ALONE;
  }
  if (p->alone > 0) found->seconds = sweep_time(entries, found->points, p);
  found->lanes = p->together > 0 && found->together > 1;
}

static sd_status look_at_sweep(const options *o, check_found *f, sd_messages *messages) {
  double speed = f->tried > 0 ? f->speed : 0;
  sweep s;
  size_t usable;
  sd_status status = sweep_open(&s, o->deck, o->overrides.n, o->overrides.item, "", messages);
  size_t n = s.deck.n_points;
  int64_t *steps = memory_new(n, sizeof *steps);
  int *kinds = memory_new(n, sizeof *kinds);
  entry *entries = memory_new(n, sizeof *entries);
  if (status == SD_OK) status = sweep_precheck(&s, 1, steps, kinds, &usable, messages);
  pace p = {.alone = speed > 0 ? 1 / speed : 0, .width = ensemble_width()};
  if (status == SD_OK && speed > 0 && p.width > 1 && n > 1 && ensemble_takes(f->model))
    p.together = probe_lanes(f->model, p.width);
  for (size_t k = 0; k < n; k++) entries[k] = (entry){kinds[k], steps[k]};
  note_sweep(&s, entries, &p, &f->sweep);
  free(steps);
  free(kinds);
  free(entries);
  sweep_close(&s);
  return status;
}

static sd_status find(const options *o, check_found *f, sd_messages *messages) {
  const sd_model *m = f->model;
  sd_model_advise(m, messages);
  if (advice_overlap(m, &f->overlap) != SD_OK) return sd_fail(messages, SD_ERROR_IO, "no memory");
  size_find(&f->size, m);
  sd_status status = size_refuse(m, &f->size, messages);
  if (status == SD_OK) size_warn(&f->size, ".", messages);
  if (status == SD_OK && !o->no_probe) status = probe(f, messages);
  if (status == SD_OK && sd_model_deck(m)->sweep_points > 0) status = look_at_sweep(o, f, messages);
  return status;
}

static int check(const options *o, sd_messages *messages) {
  sd_model *m = NULL;
  int status = deck_load_run(o->deck, o->overrides.n, o->overrides.item, &m, messages);
  check_found found = {.model = m};
  if (status == SD_OK) status = find(o, &found, messages);
  if (o->json) {
    status = check_print_json(&found, o->deck, !o->brief, status, messages);
  } else if (m) {
    if (!o->brief) printf("%s\n", sd_model_deck(m)->full);
    app_line(stdout, "# deck        %s%s%s", o->deck, m->title && *m->title ? ": " : "",
             m->title ? m->title : "");
    check_print(&found);
  }
  sd_model_free(m);
  return status;
}

/* --- command line ----------------------------------------------------------------------------- */

int app_check(int argc, char **argv) {
  options o = {0};
  sd_messages *messages = sd_messages_new();
  int status = options_parse(&app_check_line, argc, argv, &o);
  if (status == SD_OK && o.keys)
    deck_keys_print(stdout);
  else if (status == SD_OK && !o.deck)
    status = app_misuse("check", "no deck is given");
  else if (status == SD_OK)
    status = check(&o, messages);
  fflush(stdout);
  if (!o.json) sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(o.overrides.item);
  return status;
}
