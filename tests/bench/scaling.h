/* scaling.h: bench_steps --scaling: cost of a disk-step of packings, over the number of disks, their contacts, the
 * order of their numbers and the number of threads.
 *
 * All sizes, integrators and numbers of threads of a packing are in memory together and take turns. Lists of
 * neighbours are made anew once in hundreds or thousands of steps, and then all at once: few repeats hold such a step.
 * So it is timed by itself and taken off the repeats that hold it; how often it happens is counted over all steps.
 */
#ifndef BENCH_SCALING_H
#define BENCH_SCALING_H

#include "bench/packings.h"
#include "bench/scaling_table.h"
#include "physics/neighbours/neighbours.h"
#include "run/simulation_private.h"

enum { BUILD_REPEATS = 5, LEAST_STEPS = 16, QUICK_STEPS = 64, MAX_CHOICES = 16 };

typedef struct scaling_options {
  const char *sizes, *threads, *packings, *only, *csv;
  bool shuffle, quick;
  int repeats;
  double seconds; /* of a repeat */
} scaling_options;

typedef struct scaling_case {
  scaling_row row; /* what is known before, and at the end all of it */
  size_t integrator;
  sd_model
      *model; /* shared with the cases of the same packing and integrator; the last one frees it */
  bool owns_model;
  sd_simulation *simulation;
  sd_messages *messages;
  double contacts, candidates; /* sums over repeats */
  double seconds[MAX_REPEATS], build_seconds[BUILD_REPEATS];
  int64_t builds[MAX_REPEATS];
} scaling_case;

/* Positive whole numbers with commas between them; 1e5 is one, too. */
static size_t read_numbers(const char *text, size_t *number) {
  size_t n = 0;
  for (const char *at = text; *at; n++) {
    char *end;
    double value = strtod(at, &end);
    if (n == MAX_CHOICES || end == at || !(value >= 1.0 && value <= 1e9) || value != floor(value) ||
        (*end && *end != ','))
      give_up("expected whole numbers with commas between them", NULL);
    number[n] = (size_t)value;
    at = *end ? end + 1 : end;
  }
  if (n == 0) give_up("expected a number", NULL);
  return n;
}

static void check_size(size_t disks) {
  size_t unit = disks < BASE_DISKS ? FEW_ROWS : BASE_DISKS;
  if (disks < LEAST_DISKS || disks % unit)
    give_up("sizes: expected multiples of 10 from 50 on, of 1000 from there on", NULL);
}

static sd_simulation *start(const scaling_case *c) {
  sd_simulation *simulation = NULL;
  if (sd_simulation_new(c->model, c->row.threads, &simulation, c->messages) != SD_OK ||
      sd_messages_count(c->messages))
    give_up(c->row.name, c->messages);
  if (sd_simulation_threads(simulation) != c->row.threads)
    give_up("not as many threads as asked for", NULL);
  return simulation;
}

/* The cases of one size, integrators and threads varying; returns how many there are now. */
static size_t add_size(const scaling_options *o, const packing *base, size_t disks, bool shuffled,
                       scaling_case *list, size_t n) {
  size_t threads[MAX_CHOICES], n_threads = read_numbers(o->threads, threads);
  for (size_t i = 0; i < INTEGRATORS; i++) {
    sd_model *model = NULL;
    size_t first = n;
    for (size_t t = 0; t < n_threads; t++) {
      scaling_case *c = &list[n];
      *c = (scaling_case){.integrator = i, .row = {.disks = disks, .threads = (int)threads[t]}};
      scaling_row *r = &c->row;
      snprintf(r->packing, sizeof r->packing, "%s", base->kind->name);
      snprintf(r->numbers, sizeof r->numbers, shuffled ? "shuffled" : "placed");
      snprintf(r->integrator, sizeof r->integrator, "%s", integrators[i]);
      snprintf(r->name, sizeof r->name, "%s/%zu/%s/%s/%d", r->packing, disks, r->numbers,
               r->integrator, r->threads);
      if (!is_asked(r->name, o->only)) continue;
      if (n + 1 == MAX_SCALING) give_up("too many cases", NULL);
      if (!model) {
        packing p = repeated_packing(base, disks / base->n_disks, shuffled);
        model = packing_model(&p, i == 0 ? SD_GEAR5 : SD_VERLET, 0);
      }
      c->model = model;
      c->messages = sd_messages_new();
      c->simulation = start(c);
      snprintf(r->path, sizeof r->path, "%s", sd_simulation_path(c->simulation));
      n++;
    }
    if (n > first) list[n - 1].owns_model = true;
  }
  return n;
}

/* The packing of which those of so many disks are copies; `bases` holds those there are. */
static const packing *base_of(const packing_kind *kind, size_t disks, packing *bases) {
  size_t count = disks < BASE_DISKS ? disks : BASE_DISKS, k = 0;
  while (bases[k].n_disks && bases[k].n_disks != count) k++;
  if (!bases[k].n_disks) bases[k] = settled_packing(kind, count);
  return &bases[k];
}

static void free_scaling_case(scaling_case *c) {
  sd_simulation_free(c->simulation);
  sd_messages_free(c->messages);
  if (c->owns_model) sd_model_free(c->model);
}

/* Of one thread CPU time, of several the time that passes: threads that wait spend CPU time, too. */
static double seconds_now(const scaling_case *c) {
  struct timespec t;
  if (c->row.threads == 1) return cpu_seconds();
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static const work *work_of(const scaling_case *c) {
  return &simulation_engine(c->simulation)->work;
}

/* Seconds that the steps take, and how often lists are made anew in them. */
static double advance_packing(scaling_case *c, int64_t steps, int64_t *builds) {
  int64_t before = work_of(c)->builds;
  double begin = seconds_now(c);
  if (sd_simulation_advance(c->simulation, steps, c->messages) != SD_OK)
    give_up(c->row.name, c->messages);
  double seconds = seconds_now(c) - begin;
  *builds = work_of(c)->builds - before;
  c->row.all_steps += steps;
  c->row.builds += *builds;
  return seconds;
}

/* A period of the floor, so that velocities and lists are those of a packing that goes on; then the steps of a
 * repeat are chosen. */
static void prepare_packing(const scaling_options *o, scaling_case *c) {
  int64_t steps = o->quick ? QUICK_STEPS : PERIOD, builds;
  double each = advance_packing(c, steps, &builds) / (double)steps;
  c->row.steps = (int64_t)(o->seconds / each) + 1;
  int64_t least = o->quick ? LEAST_STEPS
                           : PERIOD / o->repeats + 1; /* all repeats together: a period at least */
  if (c->row.steps < least) c->row.steps = least;
}

static void repeat_packing(scaling_case *c, int r) {
  c->seconds[r] = advance_packing(c, c->row.steps, &c->builds[r]);
  const sd_state *s = sd_simulation_state(c->simulation);
  if (!s) give_up("out of memory", NULL);
  c->contacts += (double)s->n_contacts;
  c->candidates += (double)work_of(c)->pairs.count;
}

static double time_build(scaling_case *c) {
  double begin = seconds_now(c);
  if (neighbours_build(simulation_engine(c->simulation), c->messages) != SD_OK)
    give_up(c->row.name, c->messages);
  return seconds_now(c) - begin;
}

/* ns per disk-step of the repeats, without the lists; these by themselves. */
static void fill_row(scaling_case *c, int repeats) {
  scaling_row *r = &c->row;
  double disks = (double)r->disks, ns[MAX_REPEATS],
         build = spread_of(c->build_seconds, BUILD_REPEATS).median;
  for (int k = 0; k < repeats; k++)
    ns[k] = 1e9 * (c->seconds[k] - build * (double)c->builds[k]) / ((double)r->steps * disks);
  r->repeats = repeats;
  r->ns = spread_of(ns, repeats);
  r->build_ns = 1e9 * build / disks;
  r->contacts = c->contacts / (repeats * disks);
  r->candidates = c->candidates / (repeats * disks);
}

/* Repeats in turn, then the lists in turn, since lists that are made anew would be fresher than they are in a run. */
static void measure_packing(const scaling_options *o, scaling_case *list, size_t n, FILE *csv) {
  for (size_t k = 0; k < n; k++) prepare_packing(o, &list[k]);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++) repeat_packing(&list[k], r);
  for (int r = 0; r < BUILD_REPEATS; r++)
    for (size_t k = 0; k < n; k++) list[k].build_seconds[r] = time_build(&list[k]);
  for (size_t k = 0; k < n; k++) {
    fill_row(&list[k], o->repeats);
    print_scaling_row(&list[k].row);
    if (csv) write_scaling_row(csv, &list[k].row);
  }
  fflush(stdout);
  if (csv) fflush(csv);
}

/* Which packings are asked for. */
static void choose_packings(const scaling_options *o, bool *asked) {
  char words[512], *rest = words;
  bool all = strcmp(o->packings, "all") == 0;
  for (size_t k = 0; k < PACKING_KINDS; k++) asked[k] = all;
  snprintf(words, sizeof words, "%s", o->packings);
  for (const char *word; !all && (word = strsep(&rest, ","));) {
    size_t k = 0;
    while (k < PACKING_KINDS && strcmp(word, packing_kinds[k].name) != 0) k++;
    if (k == PACKING_KINDS) give_up("packings: no such packing", NULL);
    asked[k] = true;
  }
}

/* One kind, placed and then, if asked for, shuffled; returns the number of cases. */
static size_t measure_kind(const scaling_options *o, const packing_kind *kind, scaling_case *list,
                           FILE *csv) {
  size_t sizes[MAX_CHOICES], n_sizes = read_numbers(o->sizes, sizes), all = 0;
  packing bases[MAX_CHOICES] = {0};
  for (int shuffled = 0; shuffled <= o->shuffle; shuffled++) {
    size_t n = 0;
    for (size_t k = 0; k < n_sizes; k++)
      n = add_size(o, base_of(kind, sizes[k], bases), sizes[k], shuffled, list, n);
    measure_packing(o, list, n, csv);
    for (size_t k = 0; k < n; k++) free_scaling_case(&list[k]);
    all += n;
  }
  for (size_t k = 0; k < MAX_CHOICES; k++) free_packing(&bases[k]);
  return all;
}

static void measure_scaling(const scaling_options *o) {
  size_t sizes[MAX_CHOICES], n_sizes = read_numbers(o->sizes, sizes), all = 0;
  bool asked[PACKING_KINDS];
  for (size_t k = 0; k < n_sizes; k++) check_size(sizes[k]);
  choose_packings(o, asked);
  scaling_case *list = room(MAX_SCALING, sizeof *list);
  FILE *csv = o->csv ? open_table(o->csv, "w") : NULL;
  print_scaling_head(stdout, "", o->repeats, o->seconds);
  if (csv) print_scaling_head(csv, "# ", o->repeats, o->seconds);
  print_scaling_title(csv);
  for (size_t k = 0; k < PACKING_KINDS; k++)
    if (asked[k]) all += measure_kind(o, &packing_kinds[k], list, csv);
  free(list);
  if (all == 0) give_up("no such case", NULL);
  if (!csv) return;
  close_table(csv, o->csv);
  printf("\ntable: %s\n", o->csv);
}

#endif
