/* theory.c: `slipdisk theory DECK` prints what the theory predicts for the three disks of a deck.
 * See docs/theory.md. */
#include "app/theory/theory.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/app.h"
#include "app/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/store/file.h"
#include "model/model.h"
#include "slipdisk/deck.h"

typedef struct arguments {
  /* Values of the operand DECK and of the options --csv and --wave; csv, wave: NULL if not given */
  const char *deck, *csv, *wave;
  bool json;
  option_list overrides;
} arguments;

static const option_row rows[] = {
    {"define", 'D', OPTION_LIST, offsetof(arguments, overrides), NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"json", 0, OPTION_FLAG, offsetof(arguments, json), NULL, NULL, "for programs"},
    {"wave", 0, OPTION_STREAM, offsetof(arguments, wave), NULL, "FILE",
     "the curves of one period as CSV; - is the standard output"},
    {"csv", 0, OPTION_STREAM, offsetof(arguments, csv), NULL, "FILE",
     "a row per set of the sweep; - is the standard output"},
    CONFINED_OPTION,
};
const command_line app_theory_line = {
    .name = "theory",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_DECK,
    .offset = offsetof(arguments, deck),
    .operands = "DECK",
    .summary = "Says what theory knows of a disk on two turning supports",
    .more = "Torques, periodic states, mean rotation. A DECK of - is the standard input.\n",
    .examples = "slipdisk theory deck.cfg\n"
                "slipdisk theory deck.cfg --wave wave.csv\n"};

static int parse(int argc, char **argv, arguments *a) {
  int mistake = options_parse(&app_theory_line, argc, argv, a);
  if (mistake) return mistake;
  int taken =
      a->json + (a->csv && strcmp(a->csv, "-") == 0) + (a->wave && strcmp(a->wave, "-") == 0);
  if (taken > 1)
    return app_misuse("theory", "the standard output can take one of --json, --csv - and --wave -");
  return 0;
}

/* --- tables in files -------------------------------------------------------------------------- */

/* CSV table that is built in memory and written to its file in one piece. */
typedef struct table {
  FILE *out;
  char *text;
  size_t size;
} table;

static void table_open(table *t) {
  *t = (table){0};
  t->out = open_memstream(&t->text, &t->size);
  if (!t->out) memory_lacks(0);
}

/* Writes a table to `path`, a device or a pipe, or to the standard output (path NULL). Regular
 * files are written in another way: they are replaced. */
static sd_status pour(const table *t, const char *path, sd_messages *messages) {
  FILE *out = path ? fopen(path, "w") : stdout;
  bool good = out && fwrite(t->text, 1, t->size, out) == t->size && fflush(out) == 0;
  int why = errno;
  if (path && out) fclose(out);
  if (good) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "cannot write to %s: %s",
                 path ? path : "the standard output", strerror(why));
}

/* Writes a table to the file `path` ("-": the standard output), unless `status` is an error, and
 * frees the table in any case. Returns the first error. */
static sd_status table_close(table *t, const char *path, sd_status status, sd_messages *messages) {
  if (!t->out) return status;
  if (fclose(t->out) != 0) memory_lacks(t->size);
  struct stat what;
  if (status == SD_OK && strcmp(path, "-") == 0)
    status = pour(t, NULL, messages);
  else if (status == SD_OK && stat(path, &what) == 0 && !S_ISREG(what.st_mode) &&
           !S_ISDIR(what.st_mode))
    status = pour(t, path, messages);
  else if (status == SD_OK)
    status = file_write_atomic(path, t->text, t->size, messages);
  free(t->text);
  return status;
}

/* Writes the CSV row of a point of the sweep. If no periodic state was found, the cells about it
 * are empty, and a warning says why. */
static sd_status add_row(const deck_sweep *s, size_t point, FILE *out, sd_messages *messages) {
  theory_case c;
  sd_model *model = NULL;
  sd_status status = deck_sweep_model(s, point, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    sd_messages *own = sd_messages_new();
    theory_case_solve(&c, own);
    for (size_t k = 0; k < sd_messages_count(own); k++)
      sd_warn(messages, "%s: point %s: %s", s->deck_path, s->points[point].name,
              sd_messages_text(own, k));
    sd_messages_free(own);
    theory_table_row(out, s, point, &c);
  } else if (s->n_points > 1) {
    sd_warn(messages, "%s: that was point %s", s->deck_path, s->points[point].name);
  }
  sd_model_free(model);
  return status;
}

/* Writes a CSV row for each set of parameter values of the sweep, computed with the first point of
 * the set. */
static sd_status write_csv(const arguments *a, sd_messages *messages) {
  deck_sweep s = {0};
  table t = {0};
  sd_status status = deck_sweep_load(a->deck, a->overrides.n, a->overrides.item, &s, messages);
  if (status == SD_OK) {
    table_open(&t);
    theory_table_head(t.out, &s);
  }
  size_t sets = 0;
  for (size_t k = 0; status == SD_OK && k < s.n_points; k++) {
    if (s.points[k].set != sets)
      /* Only the first point of each set gets a row; sets are numbered in the order of these
       * points */
      continue;
    status = add_row(&s, k, t.out, messages);
    sets++;
  }
  status = table_close(&t, a->csv, status, messages);
  deck_sweep_free(&s);
  return status;
}

static sd_status write_wave(const arguments *a, const theory_case *c, sd_messages *messages) {
  table t;
  if (!c->solved)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s: theory: there is no periodic solution to be written; expected supports "
                   "that turn to and "
                   "fro",
                   a->deck);
  table_open(&t);
  theory_wave(t.out, c);
  return table_close(&t, a->wave, SD_OK, messages);
}

/* --- command ---------------------------------------------------------------------------------- */

/* Does what the options --json or --wave ask for, or prints the results as text, for the deck
 * without its sweep. */
static sd_status tell(const arguments *a, sd_messages *messages) {
  theory_case c;
  sd_model *model = NULL;
  sd_status status = deck_load_run(a->deck, a->overrides.n, a->overrides.item, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    status = theory_case_solve(&c, messages);
    /* Print the results also if no periodic state was found, since the other results are valid. */
    if (a->json && !theory_json(stdout, model, &c))
      status = sd_fail(messages, SD_ERROR_IO, "cannot write to the standard output");
    if (!a->json && !a->wave) theory_page(stdout, model, &c);
    if (a->wave && status == SD_OK) status = write_wave(a, &c, messages);
  }
  sd_model_free(model);
  return status;
}

int app_theory(int argc, char **argv) {
  arguments a = {0};
  sd_messages *messages = sd_messages_new();
  int status = parse(argc, argv, &a);
  if (status == 0) {
    assert(a.deck);
    if (a.csv) status = (int)write_csv(&a, messages);
    if (status == 0 && (a.json || a.wave || !a.csv)) status = (int)tell(&a, messages);
    fflush(stdout);
    sd_messages_print(messages, stderr);
  }
  sd_messages_free(messages);
  free(a.overrides.item);
  return status;
}

/* --- text output ------------------------------------------------------------------------------ */

/* Prints a line such as "  theta_T              0.125664   (0.04 pi)": label, value, note. Numbers
 * in labels, such as (15), are those of equations in the paper; docs/theory.md explains the lines,
 * docs/physics.md derives the equations. */
static void line(FILE *out, const char *label, double value, const char *note) {
  /* Adding 0.0 turns -0 into 0 */
  fprintf(out, "  %-34s %14.8g%s%s\n", label, value + 0.0, *note ? "   " : "", note);
}

/* Prints the line of a row of theory_facts. note NULL: the note is the value over pi. */
static void fact(FILE *out, const theory_case *c, const char *name, const char *note) {
  const observable *o = observable_find(&theory_facts, name);
  assert(o && o->meaning);
  const double value = observable_value(o, c, 0);
  char angle[64];
  snprintf(angle, sizeof angle, "= %.8g pi", value / M_PI);
  line(out, o->meaning, value, note ? note : angle);
}

static void print_geometry(FILE *out, const theory_case *c) {
  static const char *const side[2] = {"left", "right"};
  fprintf(out, "\ngeometry\n");
  fprintf(out, "  %s: R %.8g, m %.8g, I %.8g, weight %.8g, t_g = sqrt(2 R/g) = %.8g\n", c->upper,
          c->disk.radius, c->mass, c->disk.inertia, c->disk.weight, c->t_g);
  for (int i = 0; i < 2; i++)
    fprintf(out, "  contact %d (%s) with %s: R %.8g, alpha_%d = %.8g = %.8g pi\n", i + 1, side[i],
            c->support[i], c->support_radius[i], i + 1, c->alpha[i], c->alpha[i] / M_PI);
  fact(out, c, "geometry.half_aperture", NULL);
  fact(out, c, "geometry.tilt", NULL);
  fact(out, c, "geometry.mu", "");
  if (c->swapped)
    fprintf(out,
            "  the deck names the right support first: its S+- is S-+ here, and its S-+ S+-\n");
  if (c->offset > 1e-3 * c->disk.radius)
    fprintf(
        out,
        "  angles where the disks just touch; the deck puts the upper disk %.3g away from there\n",
        c->offset);
}

static void print_torques(FILE *out, const theory_case *c) {
  static const char *const label[4] = {
      [SD_PP] = "(15)", [SD_MM] = "(16)", [SD_PM] = "(17)", [SD_MP] = "(18)"};
  fprintf(out, "\ntranslational equilibrium points (both contacts slide)\n");
  fprintf(out, "       %14s %14s %14s %14s\n", "normal 1", "normal 2", "torque", "closed form");
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &c->tep[k];
    fprintf(out, "  S%s  %14.8g %14.8g %14.8g %14.8g  %s  %s, %s\n", theory_configurations[k],
            t->normal[0], t->normal[1], t->torque, c->torque[k], label[k],
            t->compressive ? "compressive" : "NOT COMPRESSIVE",
            t->stable ? "stable" : "NOT STABLE");
  }
  fprintf(out, "mean torque just after tilting\n");
  fact(out, c, "slight_tilt.all", "random and independent supports");
  fact(out, c, "slight_tilt.sync", "supports in phase; with mu^2 where the print has mu");
  if (isfinite(c->reversal)) fact(out, c, "formulas.reversal_phase", NULL);
}

static const char *sense(int sign) {
  return sign > 0 ? "positive (counter-clockwise)" : sign < 0 ? "negative (clockwise)" : "none";
}

static void print_random(FILE *out, const theory_case *c) {
  fprintf(out, "\ndrive: random vibration\n");
  if (c->shared)
    fprintf(out,
            "  both supports turn by one signal: S++ and S-- only, sense of rotation by (31): %s\n",
            sense(c->sense));
  else
    fprintf(out, "  all four configurations occur, sense of rotation by (19): %s\n",
            sense(c->sense));
  fprintf(
      out,
      "  valid for strong drive that changes slowly enough for the centre to find its equilibria;\n"
      "  there is no formula for the velocity\n");
}

static void print_steady(FILE *out, const theory_case *c) {
  fprintf(out, "\ndrive: the supports turn steadily, by %.8g and %.8g\n", c->velocity[0],
          c->velocity[1]);
  const char *name = theory_configuration(c->signs);
  if (name) {
    fprintf(out, "  %sconfiguration S%s\n", c->locked ? "" : "at the start ", name);
    fact(out, c, "steady.torque", "");
    if (!c->locked) line(out, "angular acceleration", c->start_torque / c->disk.inertia, "");
  } else {
    fprintf(
        out,
        "  a contact sticks%s: its surfaces move alike, and no equilibrium point tells its force\n",
        c->locked ? "" : " at the start");
  }
  if (c->locked)
    fprintf(out, "  the upper disk cannot turn\n");
  else if (isfinite(c->final_spin))
    fact(out, c, "steady.final", "it rolls with that support then");
  else
    fprintf(out,
            "  between the velocities of the supports there is no torque: any of these remains\n");
}

/* --- periodic drive --------------------------------------------------------------------------- */

/* Returns as text the value of torque/(I Theta_b w_b^2) below which no contact sticks. I: moment of
 * inertia of the upper disk; Theta_b, w_b: amplitude and angular frequency of the drive. */
static const char *sticking(const theory_case *c) {
  if (c->even && c->drive.waveform == SD_PARABOLA)
    return "no contact ever sticks below 8/pi^2 = 0.811";
  if (c->even && c->relation == THEORY_IN_PHASE)
    return "no contact ever sticks below 1/sqrt(1 + pi^2/4) = 0.537 (small tilt)";
  if (c->even && c->relation == THEORY_OPPOSITE)
    return "no contact ever sticks below 1 (small tilt)";
  return "no contact ever sticks where it is small";
}

static void print_drive(FILE *out, const theory_case *c) {
  const sd_drive *d = &c->drive;
  bool sine = d->waveform == SD_SINE;
  fprintf(out, "\ndrive: the supports turn to and fro, %s; ",
          sine ? "sines (20)" : "parabolas (21)");
  if (!(d->amplitude[0] > 0) || !(d->amplitude[1] > 0))
    fprintf(out, "one of them is at rest\n");
  else if (c->relation == THEORY_OTHER_PHASE)
    fprintf(out, "phase of the right one ahead by %.8g pi\n", c->apart / M_PI);
  else
    fprintf(out, "%s\n", c->relation == THEORY_IN_PHASE ? "in phase" : "in opposite phases");
  for (int i = 0; i < 2; i++)
    fprintf(out, "  %s: amplitude %.8g, phase %.8g pi\n", c->support[i], d->amplitude[i],
            d->phase[i] / M_PI);
  char note[96];
  snprintf(note, sizeof note, "= %.8g pi, period %.8g", d->omega / M_PI, 2 * M_PI / d->omega);
  fact(out, c, "periodic.omega", note);
  fact(out, c, "periodic.amplitude",
       c->even ? "" : "the larger of Theta_i R_i/R, whose units are used below");
  line(out, "Theta_b w_b", c->amplitude * d->omega, "");
  fact(out, c, "periodic.ratio", sticking(c));
  line(out, "w_b sqrt(m/k_n)", d->omega * sqrt(c->mass / c->stiffness),
       "the centre is at its equilibria in time where this is small");
  for (int i = 0; i < 2; i++) {
    double stroke = d->amplitude[i] * d->support_radius[i];
    double slip = c->disk.mu * fmax(c->tep[SD_PP].normal[i], c->tep[SD_MM].normal[i]) / c->k_t[i];
    if (!(slip > 0.1 * stroke) || !(stroke > 0)) continue;
    snprintf(note, sizeof note, "of support %d's stroke %.3g: the rigid spring below is no good",
             i + 1, stroke);
    line(out, "zeta at slip, mu n/k_t", slip, note);
  }
}

/* Prints a line with an angular velocity three times: as it is, divided by Theta_b w_b (amplitude
 * times frequency of the drive), and times t_g = sqrt(2 R/g); prints nothing if it is NAN. */
static void velocity(FILE *out, const theory_case *c, const char *label, double value,
                     const char *note) {
  if (isnan(value)) return;
  fprintf(out, "  %-34s %14.8g %14.8g %14.8g%s%s\n", label, value,
          value / (c->amplitude * c->drive.omega), value * c->t_g, *note ? "  " : "", note);
}

static void print_formulas(FILE *out, const theory_case *c) {
  const sd_drive *d = &c->drive;
  const sd_three_disk *disk = &c->disk;
  bool sine = d->waveform == SD_SINE, in_phase = c->relation == THEORY_IN_PHASE;
  if (c->even && in_phase && !sine) {
    const sd_sync *p = &c->parabola;
    fprintf(out, "\nin phase, parabola: (25), (43), (26), (27)%s\n",
            p->permanent ? "" : "; NOT VALID: the drive is too weak for permanent sliding");
    if (p->permanent) {
      fact(out, c, "sync.t1", "t = 0 where the supports pass their middle, turning positively");
      fact(out, c, "sync.t2", "");
      fact(out, c, "sync.++", "");
      fact(out, c, "sync.--", "");
    }
  }
  fprintf(out, "\nmean angular velocity              %16s %14s %14s\n", "Omega", "/(Theta_b w_b)",
          "t_g Omega");
  if (c->even && in_phase && !sine) {
    const char *note = c->parabola.permanent ? "exact for permanent sliding" : "not valid";
    velocity(out, c, "(29)", c->parabola.mean, note);
    velocity(out, c, "(30)", c->first_order, note);
  } else if (c->even && in_phase) {
    velocity(out, c, "as (30), sine", sd_sync_limit_sine(disk, c->amplitude, d->omega),
             "limit of strong drive");
    velocity(out, c, "closed form, sine", c->sine, "exact for permanent sliding");
  } else if (c->even && c->relation == THEORY_OPPOSITE) {
    velocity(out, c, sine ? "(35) x pi^2/8, sine" : "(35), with w_b/pi", c->first_order,
             "first order in the tilt");
    velocity(out, c, "closed form, any tilt",
             sd_async_limit(disk, d->waveform, c->amplitude, d->omega), "limit of strong drive");
  }
  velocity(out, c, "balance of torques", c->limit, "limit of strong drive");
  velocity(out, c, "periodic solution", c->solution.mean,
           c->solution.permanent ? "exact for permanent sliding" : "contacts stick at times");
}

static void print_solution(FILE *out, const theory_case *c) {
  const sd_sliding *s = &c->solution;
  fprintf(out, "\nperiodic solution: %s\n",
          s->permanent ? "permanent sliding"
                       : "NOT permanent: contacts stick at times (rigid tangential spring)");
  fprintf(out, "  %-34s %14s %14s\n", "", "time", "of the period");
  for (int k = 0; k < 4; k++)
    fprintf(out, "  T%-33s %14.8g %14.8g\n", theory_configurations[k], s->duration[k],
            c->fraction[k]);
  fprintf(out, "  %-34s %14.8g %14.8g\n", "stuck", s->stuck, c->stuck);
  fprintf(out, "  %-34s %14s %14s\n", "from t", "", "Omega");
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    const char *name = theory_configuration(p->sign);
    char text[32];
    if (name)
      snprintf(text, sizeof text, "S%s", name);
    else if (!p->sign[0] && !p->sign[1])
      snprintf(text, sizeof text, "rolls with both supports");
    else
      snprintf(text, sizeof text, "rolls with support %d", p->sign[0] ? 2 : 1);
    fprintf(out, "  %14.8g %19s %14s %14.8g  %s\n", p->start, "", "", p->omega, text);
  }
}

void theory_page(FILE *out, const sd_model *m, const theory_case *c) {
  fprintf(out, "%s: %s\n", sd_model_deck(m)->path, m->title && *m->title ? m->title : "(no title)");
  if (sd_model_deck(m)->sweep_points > 0)
    fprintf(out, "the deck as it stands; its sweep of %zu points: --csv FILE\n",
            sd_model_deck(m)->sweep_points);
  print_geometry(out, c);
  print_torques(out, c);
  switch (c->kind) {
    case THEORY_REST:
      fprintf(out, "\ndrive: nothing moves the supports while it is measured\n");
      break;
    case THEORY_STEADY: print_steady(out, c); break;
    case THEORY_RANDOM: print_random(out, c); break;
    case THEORY_PERIODIC:
      print_drive(out, c);
      if (c->solved) {
        print_formulas(out, c);
        print_solution(out, c);
      } else {
        fprintf(out, "\nno periodic state: see the message\n");
      }
      break;
  }
}
