/* ratios.h: bench_steps --ratios: cost of a contact where disks differ much in size, and where walls have many segments.
 *
 * Beds of disks on a floor that shakes gently: radii 0.8 to 1.2 (narrow); the same with a disk of radius 100 in it, free
 * (intruder) or moved to and fro (driven); radii from 1 to 100, as many in area of each size (decades); narrow disks on a
 * floor of one segment (flat) and of as many segments as disks (rough). All take turns; steps and lists are timed
 * apart, since lists are made once in many steps.
 */
#ifndef BENCH_RATIOS_H
#define BENCH_RATIOS_H

#include "bench/scaling.h"

typedef struct ratio_system {
  const char *name, *than; /* of which the ratio is told */
  const char *disks, *sizes;
  double width;      /* of the box, for one disk; grows with the root of their number */
  double least;      /* the box is no narrower */
  double depth;      /* > 0: a bed of so many rows instead, on a floor of ... */
  bool rough, moves; /* ... segments; disk 0 moves */
} ratio_system;

#define NARROW "sizes = \"uniform\"; lower = 0.8; upper = 1.2;"
#define LARGE(more) "{ name = \"large\"; x = 0; y = 120; radius = 100; mass = 31416;" more " }"
static const ratio_system ratio_systems[] = {
    {"narrow", "narrow", "", NARROW, 1.95, 0, 0, false, false},
    {"intruder", "narrow", LARGE(""), NARROW, 2.6, 260, 0, false, false},
    {"driven", "narrow", LARGE(" fixed = true;"), NARROW, 2.6, 260, 0, false, true},
    {"decades", "narrow", "", "sizes = \"powerlaw\"; lower = 1; upper = 100; exponent = 3;", 5.9,
     500, 0, false, false},
    {"flat", "flat", "", NARROW, 0, 0, 8, false, false},
    {"rough", "flat", "", NARROW, 0, 0, 8, true, false},
};
enum { RATIO_SYSTEMS = sizeof ratio_systems / sizeof *ratio_systems, RATIO_SETTLE = 8000 };

typedef struct ratio_case {
  const ratio_system *system;
  sd_model *model;
  sd_simulation *simulation;
  sd_messages *messages;
  int64_t steps, builds, all_steps, in_repeat[MAX_REPEATS];
  size_t contacts, candidates;
  double seconds[MAX_REPEATS], build_seconds[MAX_REPEATS];
} ratio_case;

static int add_line(char *text, size_t room_left, const char *format, ...) {
  va_list list;
  va_start(list, format);
  int n = vsnprintf(text, room_left, format, list);
  va_end(list);
  if (n < 0 || (size_t)n >= room_left) give_up("a deck is longer than its buffer", NULL);
  return n;
}

static char *ratio_deck(const ratio_system *s, size_t disks) {
  const size_t size = 4096 + 40 * (s->rough ? disks : 0);
  const double n = (double)disks,
               width = s->depth > 0 ? n / s->depth * 2.0 : fmax(s->least, s->width * sqrt(n));
  char *text = room(size, 1), region[96] = "";
  if (s->depth > 0)
    snprintf(region, sizeof region, " x = (%.6f, %.6f); y = (0, 400);", -0.5 * width, 0.5 * width);
  int at = add_line(
      text, size,
      "integrator = \"verlet\"; dt = 7e-4; gravity = { g = 1; };\n"
      "materials = ( { name = \"grain\"; k_n = 3e4; k_t = 1.5e4; gamma_n = 150; mu = 0.5; } );\n"
      "packings = ( { type = \"front\"; count = %zu; density = 1; %s%s } );\n"
      "disks = ( %s );\nphases = ( { steps = 1e15; } );\n"
      "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 0.01; "
      "frequency = 1; }",
      disks, s->sizes, region, s->disks);
  if (s->moves)
    at += add_line(text + at, size - (size_t)at,
                   ", { disk = \"large\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = "
                   "0.1; frequency = 0.3; }");
  at += add_line(text + at, size - (size_t)at, " );\n");
  if (!(s->depth > 0)) {
    add_line(text + at, size - (size_t)at,
             "container = { type = \"box\"; width = %.17g; height = %.17g; };\n", width, 8 * width);
    return text;
  }
  at += add_line(text + at, size - (size_t)at,
                 "walls = ( { type = \"line\"; points = ((%.6f, 1), (%.6f, 0)); },\n"
                 "{ type = \"line\"; points = ((%.6f, 0), (%.6f, 1)); },\n"
                 "{ name = \"floor\"; type = \"polyline\"; points = (",
                 -0.5 * width, -0.5 * width, 0.5 * width, 0.5 * width);
  const size_t segments = s->rough ? disks : 1;
  for (size_t k = 0; k <= segments; k++)
    at += add_line(text + at, size - (size_t)at, "%s(%.6f, %.6f)", k ? ", " : "",
                   width * ((double)k / (double)segments - 0.5),
                   s->rough ? -0.1 * (double)(k % 2) : 0.0);
  add_line(text + at, size - (size_t)at, "); } );\n");
  return text;
}

static double advance_ratio(ratio_case *c, int64_t steps, int64_t *builds) {
  const work *w = &simulation_engine(c->simulation)->work;
  const int64_t before = w->builds;
  const double begin = cpu_seconds();
  if (sd_simulation_advance(c->simulation, steps, c->messages) != SD_OK)
    give_up(c->system->name, c->messages);
  const double seconds = cpu_seconds() - begin;
  *builds = w->builds - before;
  return seconds;
}

static void prepare_ratio(ratio_case *c, size_t disks, double seconds) {
  int64_t builds;
  char *text = ratio_deck(c->system, disks);
  c->messages = sd_messages_new();
  if (sd_deck_load_text(text, c->system->name, 0, NULL, &c->model, c->messages) != SD_OK ||
      sd_simulation_new(c->model, 1, &c->simulation, c->messages) != SD_OK)
    give_up(c->system->name, c->messages);
  free(text);
  const double each = advance_ratio(c, RATIO_SETTLE, &builds) / RATIO_SETTLE;
  c->steps = (int64_t)(seconds / each) + 1;
}

static void repeat_ratio(ratio_case *c, int r) {
  const work *w = &simulation_engine(c->simulation)->work;
  c->seconds[r] = advance_ratio(c, c->steps, &c->in_repeat[r]);
  c->builds += c->in_repeat[r];
  c->all_steps += c->steps;
  c->contacts = sd_simulation_state(c->simulation)->n_contacts;
  c->candidates = w->pairs.count;
}

static void time_ratio_build(ratio_case *c, int r) {
  const double begin = cpu_seconds();
  if (neighbours_build(simulation_engine(c->simulation), c->messages) != SD_OK)
    give_up(c->system->name, c->messages);
  c->build_seconds[r] = cpu_seconds() - begin;
}

typedef struct ratio_cost {
  double step, list,
      whole; /* ns per contact: without lists, of one list, and of a step with its share of them */
} ratio_cost;

static ratio_cost cost_of(const ratio_case *c, int repeats) {
  const double contacts = (double)c->contacts, list = spread_of(c->build_seconds, repeats).median;
  double ns[MAX_REPEATS];
  for (int r = 0; r < repeats; r++)
    ns[r] = (c->seconds[r] - list * (double)c->in_repeat[r]) / (double)c->steps;
  const double step = spread_of(ns, repeats).median,
               share = (double)c->builds / (double)c->all_steps;
  return (ratio_cost){1e9 * step / contacts, 1e9 * list / contacts,
                      1e9 * (step + list * share) / contacts};
}

static void print_ratios(const ratio_case *list, size_t n, int repeats, FILE *csv) {
  const char *title = "case,disks,contacts,candidates,steps_per_list,step_ns,list_ns,whole_ns,"
                      "ratio_step,ratio_list,"
                      "ratio_whole";
  if (csv) fprintf(csv, "%s\n", title);
  printf("\nns per contact, and over that of the case of narrow sizes (of a flat floor)\n"
         "%-10s %8s %9s %10s %10s %8s %8s %8s %20s\n",
         "case", "disks", "contacts", "candidates", "steps/list", "step", "list", "both", "ratios");
  for (size_t k = 0; k < n; k++) {
    const ratio_case *c = &list[k], *than = c;
    for (size_t j = 0; j < n; j++)
      if (strcmp(list[j].system->name, c->system->than) == 0) than = &list[j];
    const ratio_cost a = cost_of(c, repeats), b = cost_of(than, repeats);
    const double steps = (double)c->all_steps / fmax((double)c->builds, 1.0);
    printf("%-10s %8zu %9zu %10zu %10.0f %8.2f %8.1f %8.2f %6.2f %6.2f %6.2f\n", c->system->name,
           c->model->n_free, c->contacts, c->candidates, steps, a.step, a.list, a.whole,
           a.step / b.step, a.list / b.list, a.whole / b.whole);
    if (csv)
      fprintf(csv, "%s,%zu,%zu,%zu,%.1f,%.3f,%.2f,%.3f,%.3f,%.3f,%.3f\n", c->system->name,
              c->model->n_free, c->contacts, c->candidates, steps, a.step, a.list, a.whole,
              a.step / b.step, a.list / b.list, a.whole / b.whole);
  }
}

static void measure_ratios(const scaling_options *o) {
  size_t disks[MAX_CHOICES], n = 0;
  if (read_numbers(o->sizes, disks) != 1) give_up("ratios: expected one number of disks", NULL);
  ratio_case *list = room(RATIO_SYSTEMS, sizeof *list);
  FILE *csv = o->csv ? open_table(o->csv, "w") : NULL;
  for (size_t k = 0; k < RATIO_SYSTEMS; k++)
    if (is_asked(ratio_systems[k].name, o->only)) list[n++].system = &ratio_systems[k];
  if (n == 0) give_up("no such case", NULL);
  for (size_t k = 0; k < n; k++) prepare_ratio(&list[k], disks[0], o->seconds);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++) repeat_ratio(&list[k], r);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++) time_ratio_build(&list[k], r);
  print_ratios(list, n, o->repeats, csv);
  if (csv) close_table(csv, o->csv);
  for (size_t k = 0; k < n; k++) {
    sd_simulation_free(list[k].simulation);
    sd_model_free(list[k].model);
    sd_messages_free(list[k].messages);
  }
  free(list);
}

#endif
