/* check.c: slipdisk check DECK: is the deck right, what does it say in full, and how long will it run?
 *
 * The output is a deck again: the full one, followed by the findings as comments.
 */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "app/app.h"
#include "base/shortage.h"
#include "app/sweep.h"
#include "io/deck/deck.h"
#include "run/ensemble.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"
#include "slipdisk/theory.h"

static const double probe_seconds = 0.2;

typedef struct options {
  const char *deck;
  option_list overrides;
  bool brief, no_probe, keys;
} options;

static const option_row rows[] = {
    {"define", 'D', OPTION_LIST, offsetof(options, overrides), 0, 0, NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"brief", 0, OPTION_FLAG, offsetof(options, brief), 0, 0, NULL, NULL, "leave the full deck out"},
    {"no-probe", 0, OPTION_FLAG, offsetof(options, no_probe), 0, 0, NULL, NULL, "do not measure the speed"},
    {"keys", 0, OPTION_FLAG, offsetof(options, keys), 0, 0, NULL, NULL,
     "print the tables of all keys, and nothing else"},
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
    .more =
        "Told are numbers of disks, walls and contacts, the time step against the shortest contact period,\n"
        "restitution of each pair of materials, size of the result, speed and length of the run. All points "
        "of a\n"
        "sweep are checked, too. A DECK of - is the standard input.\n"};

/* --- findings ------------------------------------------------------------------------------------------------ */

static void print_duration(double s) {
  if (s < 120)
    printf("%.3g s", s);
  else if (s < 7200)
    printf("%.3g min", s / 60);
  else if (s < 48 * 3600)
    printf("%.3g h", s / 3600);
  else
    printf("%.3g days", s / 86400);
}

static void print_counts(const sd_model *m) {
  printf("# disks       %zu: %zu free, %zu fixed or moved\n", m->n_disks, m->n_free, m->n_disks - m->n_free);
  if (m->n_walls) printf("# walls       %zu\n", m->n_walls);
  for (size_t k = 0; k < m->n_groups; k++) {
    size_t n = 0;
    for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].group == (int)k;
    printf("# group       \"%s\": %zu disks\n", m->groups[k], n);
  }
}

/* Goals that may end the phase before its length, and its relaxation or compression. */
static void print_phase_aims(const sd_phase *p) {
  const sd_settle *s = &p->settle;
  const sd_compress *c = &p->compress;
  if (p->relax) printf(", relaxed");
  if (c->asked && c->pressure > 0) printf(", compressed to pressure %g", c->pressure);
  if (c->asked && c->fraction > 0) printf(", compressed to packing fraction %g", c->fraction);
  if (s->asked) printf(", until at rest");
}

static void print_rains(const sd_model *m) {
  for (size_t k = 0; k < m->n_rains; k++) {
    const sd_rain *r = &m->rains[k];
    size_t batches = (r->count + r->batch - 1) / r->batch;
    printf("# rain        %zu disks in %zu batches of %zu, one every %g: the last at time %g\n", r->count,
           batches, r->batch, (double)r->interval * m->dt,
           (double)(batches - 1) * (double)r->interval * m->dt);
  }
}

/* With walls there are limits anyway, or no way out. */
static void print_bounds(const sd_model *m) {
  bool falls = m->n_free > 0 && (m->gravity[0] != 0 || m->gravity[1] != 0);
  if (!m->bounds.given && m->n_walls == 0 && falls && !m->periodic[0] && !m->periodic[1])
    printf("# bounds      none: a disk that falls off is not told of; with `bounds = { };` it is\n");
}

static void print_limits(const sd_model *m) {
  const sd_limits *l = &m->limits;
  printf("# limits      in doubt beyond:");
  if (l->residual > 0) printf(" residual %g", l->residual);
  if (l->open > 0) printf(" open %g", l->open);
  if (l->displacement > 0) printf(" displacement %g", l->displacement);
  printf("%s\n", l->residual > 0 || l->open > 0 || l->displacement > 0 ? "" : " nothing");
}

static void print_phases(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    size_t on = 0;
    for (size_t j = 0; j < m->n_motions; j++) on += p->active[j];
    printf("# phase       %s%s%s%lld steps, time %g", p->name ? p->name : "", p->name ? ": " : "",
           p->settle.asked ? "at most " : "", (long long)p->steps, (double)p->steps * m->dt);
    if (m->n_motions) printf(", %zu of %zu prescribed signals on", on, m->n_motions);
    print_phase_aims(p);
    printf("%s\n", p->measure ? ", measured" : "");
  }
  print_rains(m);
  const sd_until *u = &m->until;
  if (u->asked)
    printf("#             at most; it ends after %lld steps, time %g, or later, with the goal of `until`\n",
           (long long)u->least, (double)u->least * m->dt);
}

static void print_time_step(const sd_model *m) {
  uint32_t disk = 0;
  double period = sd_model_shortest_period(m, &disk);
  char name[96];
  if (!isfinite(period)) {
    printf("# time step   %g; no disk is free to move in a contact\n", m->dt);
    return;
  }
  printf("# time step   %g; shortest contact period %.4g (%s): %.4g steps\n", m->dt, period,
         sd_model_body_name(m, disk, name, sizeof name), period / m->dt);
  static const char *const bounds[] = {"normal spring", "tangential spring", "viscosity"};
  const sd_step_limit limit = sd_model_step_limit(m);
  printf("#             stable up to %.3g (%s of %s, %s): %.3g of it\n", limit.dt, bounds[limit.bound],
         sd_model_body_name(m, limit.disk, name, sizeof name), m->integrator == SD_GEAR5 ? "gear5" : "verlet",
         m->dt / limit.dt);
}

static int by_size(const void *a, const void *b) {
  double p = *(const double *)a, q = *(const double *)b;
  return p < q ? -1 : p > q;
}

/* Median mass of the free disks of a material; 0: there is none. */
static double typical_mass(const sd_model *m, int material) {
  double *mass = malloc((m->n_disks ? m->n_disks : 1) * sizeof *mass), middle = 0;
  size_t n = 0;
  if (!mass) shortage_note();
  for (size_t i = 0; mass && i < m->n_disks; i++)
    if (m->disks[i].material == material && !m->disks[i].driven) mass[n++] = m->disks[i].mass;
  if (n) {
    qsort(mass, n, sizeof *mass, by_size);
    middle = mass[n / 2];
  }
  free(mass);
  return middle;
}

/* Is there a wall, or a disk that nothing pushes, of this material? */
static bool has_still(const sd_model *m, int material) {
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].material == material) return true;
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].material == material && m->disks[i].driven) return true;
  return false;
}

static size_t count_free(const sd_model *m, int material) {
  size_t n = 0;
  for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].material == material && !m->disks[i].driven;
  return n;
}

static void print_one_restitution(const sd_model *m, int a, int b, double mass, const char *what) {
  const sd_contact_law *law = sd_model_law(m, a, b);
  printf("# restitution \"%s\" on \"%s\": e = %.4f (%s, effective mass %.4g)\n", m->materials[a].name,
         m->materials[b].name, sd_restitution(law->k_n, law->gamma_n, mass).restitution, what, mass);
}

/* Of Hertz' law it is that of the deck, whatever the masses. */
static void print_given_restitution(const sd_model *m, int a, int b) {
  const sd_contact_law *law = sd_model_law(m, a, b);
  printf("# restitution \"%s\" on \"%s\": ", m->materials[a].name, m->materials[b].name);
  if (law->gamma_n > 0.0)
    printf("depends on the speed\n");
  else
    printf("e = %g at any speed\n", law->restitution > 0.0 ? law->restitution : 1.0);
}

static void print_restitution(const sd_model *m) {
  for (int a = 0; a < (int)m->n_materials; a++)
    for (int b = a; b < (int)m->n_materials; b++) {
      double ma = typical_mass(m, a), mb = typical_mass(m, b);
      if (sd_model_law(m, a, b)->k_n <= 0) continue;
      if (sd_model_law(m, a, b)->normal != SD_NORMAL_LINEAR) {
        print_given_restitution(m, a, b);
        continue;
      }
      size_t enough = a == b ? 2 : 1;
      if (count_free(m, a) >= enough && count_free(m, b) >= enough)
        print_one_restitution(m, a, b, ma * mb / (ma + mb), "two free disks");
      if (ma > 0 && has_still(m, b)) print_one_restitution(m, a, b, ma, "a free disk on a fixed body");
      if (a != b && mb > 0 && has_still(m, a))
        print_one_restitution(m, b, a, mb, "a free disk on a fixed body");
    }
}

/* Runs the deck for a moment, the beginning of it at least. *speed: steps per second; 0: not known. */
static sd_status probe(const sd_model *m, double *speed, sd_messages *messages) {
  sd_simulation *s = NULL;
  sd_status status = sd_simulation_new(m, 0, &s, messages);
  if (status != SD_OK) return status;
  const sd_state *first = sd_simulation_state(s);
  if (first) printf("# contacts    %zu at the start\n", first->n_contacts);
  if (!first) status = sd_fail(messages, SD_ERROR_IO, "no memory for the contacts of the state");
  int64_t done = 0, chunk = 16;
  double start = clock_seconds(), spent = 0;
  while (status == SD_OK && !sd_simulation_finished(s) && spent < probe_seconds) {
    status = sd_simulation_advance(s, chunk, messages);
    done = sd_simulation_stage(s).step;
    spent = clock_seconds() - start;
    if (chunk < 1 << 20 && spent < probe_seconds / 4) chunk *= 2;
  }
  if (status == SD_OK && done > 0 && spent > 0) {
    *speed = (double)done / spent;
    double whole = (double)sd_model_steps(m) / *speed;
    printf("# speed       about %.3g steps per second (%d thread%s, %s), measured on the first %lld steps\n",
           *speed, sd_simulation_threads(s), sd_simulation_threads(s) == 1 ? "" : "s", sd_simulation_path(s),
           (long long)done);
    printf("# run time    about ");
    print_duration(whole);
    printf(" for %s%lld steps\n", m->until.asked ? "at most " : "", (long long)sd_model_steps(m));
  }
  sd_simulation_free(s);
  return status;
}

/* --- sweep --------------------------------------------------------------------------------------------------- */

/* Time that a sweep's points need on this machine. */
typedef struct pace {
  double alone;    /* s per step of a system by itself; 0: not known */
  double together; /* s per step of a group in lanes, however few they are; 0: there are none, or not known */
  size_t width;
} pace;

/* The speed in lanes, measured with the deck as it stands in all of them. */
static double probe_lanes(const sd_model *m, size_t width) {
  sd_simulation **all = calloc(width, sizeof *all);
  sd_messages **messages = calloc(width, sizeof *messages);
  sd_status *status = calloc(width, sizeof *status);
  ensemble *e = NULL;
  bool good = all && messages && status;
  for (size_t k = 0; good && k < width; k++) {
    messages[k] = app_messages();
    good = sd_simulation_new(m, 1, &all[k], messages[k]) == SD_OK;
  }
  good = good && ensemble_new(width, all, &e, NULL) == SD_OK;
  double start = clock_seconds(), spent = 0;
  for (int64_t chunk = 16; good && !sd_simulation_finished(all[0]) && spent < probe_seconds;) {
    ensemble_advance(e, chunk, status, messages);
    spent = clock_seconds() - start;
    good = status[0] == SD_OK && ensemble_in_lanes(e) == width;
    if (chunk < 1 << 20 && spent < probe_seconds / 4) chunk *= 2;
  }
  double done = good ? (double)sd_simulation_stage(all[0]).step : 0;
  ensemble_free(e);
  for (size_t k = 0; all && messages && k < width; k++) {
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

/* Time of all points with one worker, in groups as `sweep` makes them: the longest of each counts. */
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

static void print_sweep(const sweep *s, entry *entries, const sd_model *m, const pace *p) {
  double all = 0;
  size_t together = 0, n = s->deck.n_points;
  for (size_t k = 0; k < n; k++) {
    all += (double)entries[k].steps;
    together += entries[k].kind != SWEEP_ALONE;
  }
  printf("# sweep       %zu point%s", n, n == 1 ? "" : "s");
  if (s->deck.n_sets < n) printf(", %zu set%s of values", s->deck.n_sets, s->deck.n_sets == 1 ? "" : "s");
  printf("; `slipdisk sweep` runs them, this is the deck as it stands\n");
  printf("#             %s%.4g steps in all", m->until.asked ? "at most " : "", all);
  if (p->alone > 0) {
    printf(", about ");
    print_duration(sweep_time(entries, n, p));
    printf(" with one worker, %s", p->together > 0 && together > 1 ? "in lanes" : "one after the other");
    if (n > 1) printf("; -j N shares them among N");
  }
  printf("\n");
  if (together > 1 && p->width > 1)
    printf("#             %zu of them can go in lanes, up to %zu side by side\n", together, p->width);
}

static sd_status check_sweep(const options *o, const sd_model *m, double speed, sd_messages *messages) {
  sweep s;
  size_t usable;
  sd_status status = sweep_open(&s, o->deck, o->overrides.n, o->overrides.item, "", messages);
  size_t n = s.deck.n_points;
  int64_t *steps = calloc(n + 1, sizeof *steps);
  int *kinds = calloc(n + 1, sizeof *kinds);
  entry *entries = calloc(n + 1, sizeof *entries);
  bool memory = steps && kinds && entries;
  if (status == SD_OK && !memory) status = sd_fail(messages, SD_ERROR_IO, "no memory for the sweep");
  if (status == SD_OK) status = sweep_precheck(&s, steps, kinds, &usable, messages);
  pace p = {.alone = speed > 0 ? 1 / speed : 0, .width = ensemble_width()};
  if (status == SD_OK && speed > 0 && p.width > 1 && n > 1 && ensemble_takes(m))
    p.together = probe_lanes(m, p.width);
  for (size_t k = 0; memory && k < n; k++) entries[k] = (entry){kinds[k], steps[k]};
  if (memory) print_sweep(&s, entries, m, &p);
  free(steps);
  free(kinds);
  free(entries);
  sweep_close(&s);
  return status;
}

static sd_status check(const options *o, sd_messages *messages) {
  sd_model *m = NULL;
  sd_status status = sd_deck_load(o->deck, o->overrides.n, o->overrides.item, &m, messages);
  if (status != SD_OK) return status;
  if (!o->brief) printf("%s\n", sd_model_deck(m)->full);
  app_line(stdout, "# deck        %s%s%s", o->deck, m->title && *m->title ? ": " : "",
           m->title ? m->title : "");
  print_counts(m);
  print_bounds(m);
  print_phases(m);
  print_limits(m);
  print_time_step(m);
  sd_model_advise(m, messages);
  print_restitution(m);
  double speed = 0;
  status = size_print(m, messages);
  if (status == SD_OK && !o->no_probe) status = probe(m, &speed, messages);
  if (status == SD_OK && sd_model_deck(m)->sweep_points > 0) status = check_sweep(o, m, speed, messages);
  sd_model_free(m);
  return status;
}

/* --- command line ---------------------------------------------------------------------------------------------- */

int app_check(int argc, char **argv) {
  options o = {0};
  sd_messages *messages = app_messages();
  int status = options_parse(&app_check_line, argc, argv, &o);
  if (status == SD_OK && o.keys)
    deck_keys_print(stdout);
  else if (status == SD_OK && !o.deck)
    status = app_misuse("check", "no deck is given");
  else if (status == SD_OK)
    status = check(&o, messages);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(o.overrides.item);
  return status;
}
