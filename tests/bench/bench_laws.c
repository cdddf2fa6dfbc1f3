/* bench_laws.c: what contact laws cost: ns per step of three disks, and per disk and step of a packing, one thread.
 *
 *   bench_laws [--quick] [--only NAME,...] [--repeats N] [--disks N] [--csv FILE]
 *
 * Velocity Verlet, the conservative variant, the fastest instruction set. One repeat of every law, then the next of every law,
 * so that a slow spell of the machine falls on all alike; the table has medians, quartiles, and the ratio to `linear`. Three disks:
 * one on two supports that turn to and fro, which suits the step of small systems; and the same by the general step is not timed. The
 * packing lies on a floor, periodic in x, and has come to rest with its own law.
 */
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

enum { MOST = 200 };

/* Constants k, kt, c (viscosity), d (overlap), w (weight) are those of the system. */
static const struct {
  const char *name, *keys;
} laws[] = {
    {"linear", "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3;"},
    {"restitution", "k_n = \"k\"; k_t = \"kt\"; restitution = 0.6; mu = 0.3;"},
    {"no-cutoff", "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3; limit_damping = false;"},
    {"hertz", "law = \"hertz\"; k_n = \"k/sqrt(d)\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3;"},
    {"hertz-restitution",
     "law = \"hertz\"; k_n = \"k/sqrt(d)\"; k_t = \"kt\"; restitution = 0.6; mu = 0.3;"},
    {"gamma_t", "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; gamma_t = \"c\"; mu = 0.3;"},
    {"mindlin",
     "law = \"hertz\"; k_n = \"k/sqrt(d)\"; tangential = \"mindlin\"; k_t = \"kt/sqrt(d)\"; "
     "gamma_n = \"c\"; mu = 0.3;"},
    {"modulus", "law = \"hertz\"; E_star = \"k/sqrt(d)\"; tangential = \"mindlin\"; poisson = 0.3; "
                "gamma_n = \"c\"; mu = 0.3;"},
    {"mu_kinetic", "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3; mu_kinetic = 0.2;"},
    {"rolling", "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3; k_r = \"k\"; gamma_r = "
                "\"c\"; mu_r = 0.05;"},
    {"constant",
     "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3; cohesion = \"constant\"; pull_off = "
     "\"w\"; range = \"d\";"},
    {"bridge",
     "k_n = \"k\"; k_t = \"kt\"; gamma_n = \"c\"; mu = 0.3; cohesion = \"bridge\"; pull_off = "
     "\"w\"; range = \"d\"; rupture = \"2*d\";"},
    {"everything",
     "law = \"hertz\"; k_n = \"k/sqrt(d)\"; restitution = 0.6; limit_damping = false; tangential "
     "= \"mindlin\"; k_t = \"kt/sqrt(d)\"; gamma_t = \"c\"; mu = 0.3; mu_kinetic = 0.2; k_r = "
     "\"k\"; gamma_r = \"c\"; mu_r = 0.05; cohesion = \"bridge\"; pull_off = \"w\"; range = "
     "\"d\"; rupture = \"2*d\";"},
};
enum { LAWS = sizeof laws / sizeof *laws, SYSTEMS = 2, CASES = LAWS * SYSTEMS };

static const char *const system_names[SYSTEMS] = {"three", "packing"};

typedef struct law_case {
  int law, system;
  sd_model *model;
  sd_simulation *simulation;
  int64_t steps; /* per repeat */
  size_t free_disks, contacts;
  double ns[MOST]; /* per disk and step */
} law_case;

static _Noreturn void give_up(const char *what, sd_messages *messages) {
  fprintf(stderr, "bench_laws: %s\n", what);
  if (messages) sd_messages_print(messages, stderr);
  exit(EXIT_FAILURE);
}

static double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void advance(law_case *c, int64_t steps) {
  sd_messages *messages = sd_messages_new();
  if (sd_simulation_advance(c->simulation, steps, messages) != SD_OK)
    give_up(laws[c->law].name, messages);
  sd_messages_free(messages);
}

static void load(law_case *c, int disks) {
  static const char *const decks[SYSTEMS] = {
      "dt = 2e-6; gravity = { g = 10; }; constants = { k = 1e3; kt = 1e5; c = 5; d = 1e-3; w = "
      "0.3; };\n"
      "disks = ( { x = 0; y = 0; radius = 1; mass = 0.1; },\n"
      "{ name = \"l\"; x = -1; y = \"-sqrt(3)\"; radius = 1; mass = 0.1; fixed = true; },\n"
      "{ name = \"r\"; x = 1; y = \"-sqrt(3)\"; radius = 1; mass = 0.1; fixed = true; } );\n"
      "motions = ( { disk = (\"l\", \"r\"); coordinate = \"theta\"; type = \"harmonic\"; "
      "amplitude = 0.04; omega = \"20 pi\"; } );\n",
      "dt = 1e-3; gravity = { g = 1; }; constants = { k = 2.5e3; kt = 1.25e3; c = 10; d = 0.005; "
      "w = 1; };\n"
      "container = { type = \"channel\"; width = 100; height = 1000; };\n"
      "packings = ( { type = \"front\"; count = %d; density = 1.27; sizes = \"uniform\"; lower = "
      "0.4; upper = 0.6; } );\n"};
  char text[4096], form[2048];
  snprintf(form, sizeof form, "%s", decks[c->system]);
  int n = snprintf(
      text, sizeof text,
      "integrator = \"verlet\"; contact_variant = \"conservative\"; steps = 1e15; measure = { "
      "rotation = (); };\n"
      "materials = ( { name = \"m\"; %s } );\n",
      laws[c->law].keys);
  char *number = strstr(form, "%d");
  if (number) {
    *number = '\0';
    snprintf(text + n, sizeof text - (size_t)n, "%s%d%s", form, disks, number + 2);
  } else {
    snprintf(text + n, sizeof text - (size_t)n, "%s", form);
  }
  sd_messages *messages = sd_messages_new();
  if (sd_deck_load_text(text, laws[c->law].name, 0, NULL, &c->model, messages) != SD_OK ||
      sd_simulation_new(c->model, 1, &c->simulation, messages) != SD_OK)
    give_up(laws[c->law].name, messages);
  sd_messages_free(messages);
}

/* Settles, and chooses the steps so that a repeat takes about `seconds`. */
static void prepare(law_case *c, double settle, double seconds, int disks) {
  load(c, disks);
  advance(c, (int64_t)(settle * (c->system ? 2e4 : 4e5)));
  const sd_state *state = sd_simulation_state(c->simulation);
  c->free_disks = state->n_free;
  c->contacts = state->n_contacts;
  double spent = 0;
  for (c->steps = 16; spent < 0.3 * seconds; c->steps *= 2) {
    double from = cpu_seconds();
    advance(c, c->steps);
    spent = cpu_seconds() - from;
  }
  c->steps = (int64_t)((double)c->steps * 0.5 * seconds / spent) + 1;
}

static void print_row(FILE *out, const law_case *c, const law_case *linear, int repeats, bool csv) {
  double ratio[MOST], sorted[MOST];
  size_t n = (size_t)repeats;
  for (size_t r = 0; r < n; r++) ratio[r] = c->ns[r] / linear->ns[r];
  memcpy(sorted, c->ns, n * sizeof *sorted);
  gsl_sort(sorted, 1, n);
  gsl_sort(ratio, 1, n);
  fprintf(out,
          csv ? "%s,%s,%zu,%zu,%.3f,%.4f,%.4f,%.4f\n"
              : "| %s | `%s` | %zu | %zu | %.1f | %.2f (%.2f-%.2f) |\n",
          system_names[c->system], laws[c->law].name, c->free_disks, c->contacts,
          gsl_stats_median_from_sorted_data(sorted, 1, n),
          gsl_stats_median_from_sorted_data(ratio, 1, n),
          gsl_stats_quantile_from_sorted_data(ratio, 1, n, 0.25),
          gsl_stats_quantile_from_sorted_data(ratio, 1, n, 0.75));
}

static bool is_asked(const char *name, const char *only) {
  const char *at = only ? strstr(only, name) : name;
  size_t n = strlen(name);
  for (; at && only; at = strstr(at + 1, name))
    if ((at == only || at[-1] == ',') && (at[n] == '\0' || at[n] == ',')) return true;
  return !only;
}

typedef struct options {
  const char *only, *csv;
  int repeats, disks;
  bool quick;
} options;

static options read_options(int argc, char **argv) {
  options o = {.disks = 10000};
  for (int k = 1; k < argc; k++) {
    const char *word = argv[k], *value = k + 1 < argc ? argv[k + 1] : NULL;
    if (strcmp(word, "--quick") == 0)
      o.quick = true;
    else if (!value)
      give_up(
          "unknown option; options: --quick, --only NAME,..., --repeats N, --disks N, --csv FILE",
          NULL);
    else if (k++, strcmp(word, "--only") == 0)
      o.only = value;
    else if (strcmp(word, "--csv") == 0)
      o.csv = value;
    else if (strcmp(word, "--disks") == 0)
      o.disks = atoi(value);
    else if (strcmp(word, "--repeats") != 0 || (o.repeats = atoi(value)) < 1 || o.repeats > MOST)
      give_up("unknown option, or not a number of repeats", NULL);
  }
  if (o.repeats == 0) o.repeats = o.quick ? 3 : 15;
  if (o.disks < 1) give_up("--disks: expected a number of disks", NULL);
  return o;
}

int main(int argc, char **argv) {
  const options o = read_options(argc, argv);
  static law_case cases[CASES];
  size_t n = 0;
  for (int system = 0; system < SYSTEMS; system++)
    for (int law = 0; law < LAWS; law++)
      if (law == 0 || is_asked(laws[law].name, o.only))
        cases[n++] = (law_case){.law = law, .system = system};
  for (size_t k = 0; k < n; k++)
    prepare(&cases[k], o.quick ? 0.02 : 1, o.quick ? 0.01 : 0.1, o.disks);
  for (int r = 0; r < o.repeats; r++)
    for (size_t k = 0; k < n; k++) {
      law_case *c = &cases[k];
      double from = cpu_seconds();
      advance(c, c->steps);
      c->ns[r] = 1e9 * (cpu_seconds() - from) / (double)c->steps / (double)c->free_disks;
    }
  FILE *csv = o.csv ? fopen(o.csv, "w") : NULL;
  if (o.csv && !csv) give_up(o.csv, NULL);
  if (csv)
    fprintf(csv, "system,law,free_disks,contacts,median_ns_per_disk,ratio,ratio_quartile1,ratio_"
                 "quartile3\n");
  printf("| system | law | disks | contacts | ns per disk and step | over linear "
         "|\n|---|---|---:|---:|---:|---:|\n");
  for (size_t k = 0; k < n; k++) {
    const law_case *linear = &cases[cases[k].system == 0 ? 0 : n / 2];
    print_row(stdout, &cases[k], linear, o.repeats, false);
    if (csv) print_row(csv, &cases[k], linear, o.repeats, true);
    sd_simulation_free(cases[k].simulation);
    cases[k].simulation = NULL;
  }
  for (size_t k = 0; k < n; k++) sd_model_free(cases[k].model);
  if (csv && fclose(csv) != 0) give_up(o.csv, NULL);
  return EXIT_SUCCESS;
}
