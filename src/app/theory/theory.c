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
  theory_result r;
  sd_model *model = NULL;
  sd_status status = deck_sweep_model(s, point, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    sd_messages *own = sd_messages_new();
    theory_case_solve(&c, &r, own);
    for (size_t k = 0; k < sd_messages_count(own); k++)
      sd_warn(messages, "%s: point %s: %s", s->deck_path, s->points[point].name,
              sd_messages_text(own, k));
    sd_messages_free(own);
    theory_table_row(out, s, point, &c, &r);
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

static sd_status write_wave(const arguments *a, const theory_result *r, sd_messages *messages) {
  table t;
  if (!r->solved)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s: theory: there is no periodic solution to be written; expected supports "
                   "that turn to and "
                   "fro",
                   a->deck);
  table_open(&t);
  theory_wave(t.out, r);
  return table_close(&t, a->wave, SD_OK, messages);
}

/* --- command ---------------------------------------------------------------------------------- */

/* Does what the options --json or --wave ask for, or prints the results as text, for the deck
 * without its sweep. */
static sd_status tell(const arguments *a, sd_messages *messages) {
  theory_case c;
  theory_result r;
  sd_model *model = NULL;
  sd_status status = deck_load_run(a->deck, a->overrides.n, a->overrides.item, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    status = theory_case_solve(&c, &r, messages);
    /* Print the results also if no periodic state was found, since the other results are valid. */
    if (a->json && !theory_json(stdout, model, &c, &r))
      status = sd_fail(messages, SD_ERROR_IO, "cannot write to the standard output");
    if (!a->json && !a->wave) theory_page(stdout, model, &c, &r);
    if (a->wave && status == SD_OK) status = write_wave(a, &r, messages);
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

static void angle_line(FILE *out, const char *label, double value) {
  char note[64];
  snprintf(note, sizeof note, "= %.8g pi", value / M_PI);
  line(out, label, value, note);
}

static void print_geometry(FILE *out, const theory_case *c) {
  static const char *const side[2] = {"left", "right"};
  fprintf(out, "\ngeometry\n");
  fprintf(out, "  %s: R %.8g, m %.8g, I %.8g, weight %.8g, t_g = sqrt(2 R/g) = %.8g\n", c->upper,
          c->disk.radius, c->mass, c->disk.inertia, c->disk.weight, c->t_g);
  for (int i = 0; i < 2; i++)
    fprintf(out, "  contact %d (%s) with %s: R %.8g, alpha_%d = %.8g = %.8g pi\n", i + 1, side[i],
            c->support[i], c->support_radius[i], i + 1, c->alpha[i], c->alpha[i] / M_PI);
  angle_line(out, "half aperture theta_h", c->disk.half_aperture);
  angle_line(out, "tilt theta_T", c->disk.tilt);
  line(out, "friction mu", c->disk.mu, "");
  if (c->swapped)
    fprintf(out,
            "  the deck names the right support first: its S+- is S-+ here, and its S-+ S+-\n");
  if (c->offset > 1e-3 * c->disk.radius)
    fprintf(
        out,
        "  angles where the disks just touch; the deck puts the upper disk %.3g away from there\n",
        c->offset);
}

static void print_torques(FILE *out, const theory_case *c, const theory_result *r) {
  static const char *const label[4] = {
      [SD_PP] = "(15)", [SD_MM] = "(16)", [SD_PM] = "(17)", [SD_MP] = "(18)"};
  fprintf(out, "\ntranslational equilibrium points (both contacts slide)\n");
  fprintf(out, "       %14s %14s %14s %14s\n", "normal 1", "normal 2", "torque", "closed form");
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &r->tep[k];
    fprintf(out, "  S%s  %14.8g %14.8g %14.8g %14.8g  %s  %s, %s\n", theory_configurations[k],
            t->normal[0], t->normal[1], t->torque, r->torque[k], label[k],
            t->compressive ? "compressive" : "NOT COMPRESSIVE",
            t->stable ? "stable" : "NOT STABLE");
  }
  fprintf(out, "mean torque just after tilting\n");
  line(out, "all four equally long (19)", r->slight, "random and independent supports");
  line(out, "S++ and S-- only (31)", r->sync,
       "supports in phase; with mu^2 where the print has mu");
  if (c->disk.half_aperture > 0 && tan(c->disk.half_aperture) > c->disk.mu)
    angle_line(out, "phase at which the sense turns over", sd_reversal_phase(&c->disk));
}

static const char *sense(double torque) {
  return torque > 0 ? "positive (counter-clockwise)" : torque < 0 ? "negative (clockwise)" : "none";
}

static void print_random(FILE *out, const theory_case *c, const theory_result *r) {
  fprintf(out, "\ndrive: random vibration\n");
  if (c->shared)
    fprintf(out,
            "  both supports turn by one signal: S++ and S-- only, sense of rotation by (31): %s\n",
            sense(r->sync));
  else
    fprintf(out, "  all four configurations occur, sense of rotation by (19): %s\n",
            sense(r->slight));
  fprintf(
      out,
      "  valid for strong drive that changes slowly enough for the centre to find its equilibria;\n"
      "  there is no formula for the velocity\n");
}

static void print_steady(FILE *out, const theory_case *c, const theory_result *r) {
  fprintf(out, "\ndrive: the supports turn steadily, by %.8g and %.8g\n", c->velocity[0],
          c->velocity[1]);
  const int *s = r->signs;
  if (s[0] && s[1]) {
    int k = 2 * (s[0] < 0) + (s[1] < 0);
    fprintf(out, "  %sconfiguration S%s\n", c->locked ? "" : "at the start ",
            theory_configurations[k]);
    line(out, "torque", r->torque[k], "");
    if (!c->locked) line(out, "angular acceleration", r->torque[k] / c->disk.inertia, "");
  } else {
    fprintf(
        out,
        "  a contact sticks%s: its surfaces move alike, and no equilibrium point tells its force\n",
        c->locked ? "" : " at the start");
  }
  if (c->locked)
    fprintf(out, "  the upper disk cannot turn\n");
  else if (isfinite(r->final_spin))
    line(out, "angular velocity that it tends to", r->final_spin,
         "it rolls with that support then");
  else
    fprintf(out,
            "  between the velocities of the supports there is no torque: any of these remains\n");
}

/* --- periodic drive --------------------------------------------------------------------------- */

/* Returns as text the value of torque/(I Theta_b w_b^2) below which no contact sticks. I: moment of
 * inertia of the upper disk; Theta_b, w_b: amplitude and angular frequency of the drive. */
static const char *sticking(const theory_case *c, const theory_result *r) {
  if (r->even && c->drive.waveform == SD_PARABOLA)
    return "no contact ever sticks below 8/pi^2 = 0.811";
  if (r->even && r->relation == THEORY_IN_PHASE)
    return "no contact ever sticks below 1/sqrt(1 + pi^2/4) = 0.537 (small tilt)";
  if (r->even && r->relation == THEORY_OPPOSITE)
    return "no contact ever sticks below 1 (small tilt)";
  return "no contact ever sticks where it is small";
}

static void print_drive(FILE *out, const theory_case *c, const theory_result *r) {
  const sd_drive *d = &c->drive;
  bool sine = d->waveform == SD_SINE;
  fprintf(out, "\ndrive: the supports turn to and fro, %s; ",
          sine ? "sines (20)" : "parabolas (21)");
  if (!(d->amplitude[0] > 0) || !(d->amplitude[1] > 0))
    fprintf(out, "one of them is at rest\n");
  else if (r->relation == THEORY_OTHER_PHASE)
    fprintf(out, "phase of the right one ahead by %.8g pi\n", r->apart / M_PI);
  else
    fprintf(out, "%s\n", r->relation == THEORY_IN_PHASE ? "in phase" : "in opposite phases");
  for (int i = 0; i < 2; i++)
    fprintf(out, "  %s: amplitude %.8g, phase %.8g pi\n", c->support[i], d->amplitude[i],
            d->phase[i] / M_PI);
  char note[96];
  snprintf(note, sizeof note, "= %.8g pi, period %.8g", d->omega / M_PI, 2 * M_PI / d->omega);
  line(out, "w_b", d->omega, note);
  line(out, "Theta_b", r->amplitude,
       r->even ? "" : "the larger of Theta_i R_i/R, whose units are used below");
  line(out, "Theta_b w_b", r->amplitude * d->omega, "");
  line(out, "torque/(I Theta_b w_b^2)", r->ratio, sticking(c, r));
  line(out, "w_b sqrt(m/k_n)", d->omega * sqrt(c->mass / c->stiffness),
       "the centre is at its equilibria in time where this is small");
  for (int i = 0; i < 2; i++) {
    double stroke = d->amplitude[i] * d->support_radius[i];
    double slip = c->disk.mu * fmax(r->tep[SD_PP].normal[i], r->tep[SD_MM].normal[i]) / c->k_t[i];
    if (!(slip > 0.1 * stroke) || !(stroke > 0)) continue;
    snprintf(note, sizeof note, "of support %d's stroke %.3g: the rigid spring below is no good",
             i + 1, stroke);
    line(out, "zeta at slip, mu n/k_t", slip, note);
  }
}

/* Prints a line with an angular velocity three times: as it is, divided by Theta_b w_b (amplitude
 * times frequency of the drive), and times t_g = sqrt(2 R/g); prints nothing if it is NAN. */
static void velocity(FILE *out, const theory_case *c, const theory_result *r, const char *label,
                     double value, const char *note) {
  if (isnan(value)) return;
  fprintf(out, "  %-34s %14.8g %14.8g %14.8g%s%s\n", label, value,
          value / (r->amplitude * c->drive.omega), value * c->t_g, *note ? "  " : "", note);
}

static void print_formulas(FILE *out, const theory_case *c, const theory_result *r) {
  const sd_drive *d = &c->drive;
  const sd_three_disk *disk = &c->disk;
  bool sine = d->waveform == SD_SINE, in_phase = r->relation == THEORY_IN_PHASE;
  if (r->even && in_phase && !sine) {
    const sd_sync *p = &r->parabola;
    fprintf(out, "\nin phase, parabola: (25), (43), (26), (27)%s\n",
            p->permanent ? "" : "; NOT VALID: the drive is too weak for permanent sliding");
    if (p->permanent) {
      line(out, "t1: S-- begins", p->t1,
           "t = 0 where the supports pass their middle, turning positively");
      line(out, "t2: S++ begins", p->t2, "");
      line(out, "T++", p->pp, "");
      line(out, "T--", p->mm, "");
    }
  }
  fprintf(out, "\nmean angular velocity              %16s %14s %14s\n", "Omega", "/(Theta_b w_b)",
          "t_g Omega");
  if (r->even && in_phase && !sine) {
    const char *note = r->parabola.permanent ? "exact for permanent sliding" : "not valid";
    velocity(out, c, r, "(29)", r->parabola.mean, note);
    velocity(out, c, r, "(30)", r->first_order, note);
  } else if (r->even && in_phase) {
    velocity(out, c, r, "as (30), sine", sd_sync_limit_sine(disk, r->amplitude, d->omega),
             "limit of strong drive");
    velocity(out, c, r, "closed form, sine", r->sine, "exact for permanent sliding");
  } else if (r->even && r->relation == THEORY_OPPOSITE) {
    velocity(out, c, r, sine ? "(35) x pi^2/8, sine" : "(35), with w_b/pi", r->first_order,
             "first order in the tilt");
    velocity(out, c, r, "closed form, any tilt",
             sd_async_limit(disk, d->waveform, r->amplitude, d->omega), "limit of strong drive");
  }
  velocity(out, c, r, "balance of torques", r->limit, "limit of strong drive");
  velocity(out, c, r, "periodic solution", r->solution.mean,
           r->solution.permanent ? "exact for permanent sliding" : "contacts stick at times");
}

static void print_solution(FILE *out, const sd_sliding *s) {
  fprintf(out, "\nperiodic solution: %s\n",
          s->permanent ? "permanent sliding"
                       : "NOT permanent: contacts stick at times (rigid tangential spring)");
  fprintf(out, "  %-34s %14s %14s\n", "", "time", "of the period");
  for (int k = 0; k < 4; k++)
    fprintf(out, "  T%-33s %14.8g %14.8g\n", theory_configurations[k], s->duration[k],
            s->duration[k] / s->period);
  fprintf(out, "  %-34s %14.8g %14.8g\n", "stuck", s->stuck, s->stuck / s->period);
  fprintf(out, "  %-34s %14s %14s\n", "from t", "", "Omega");
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    char text[32];
    if (p->sign[0] && p->sign[1])
      snprintf(text, sizeof text, "S%s",
               theory_configurations[2 * (p->sign[0] < 0) + (p->sign[1] < 0)]);
    else if (!p->sign[0] && !p->sign[1])
      snprintf(text, sizeof text, "rolls with both supports");
    else
      snprintf(text, sizeof text, "rolls with support %d", p->sign[0] ? 2 : 1);
    fprintf(out, "  %14.8g %19s %14s %14.8g  %s\n", p->start, "", "", p->omega, text);
  }
}

void theory_page(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r) {
  fprintf(out, "%s: %s\n", sd_model_deck(m)->path, m->title && *m->title ? m->title : "(no title)");
  if (sd_model_deck(m)->sweep_points > 0)
    fprintf(out, "the deck as it stands; its sweep of %zu points: --csv FILE\n",
            sd_model_deck(m)->sweep_points);
  print_geometry(out, c);
  print_torques(out, c, r);
  switch (c->kind) {
    case THEORY_REST:
      fprintf(out, "\ndrive: nothing moves the supports while it is measured\n");
      break;
    case THEORY_STEADY: print_steady(out, c, r); break;
    case THEORY_RANDOM: print_random(out, c, r); break;
    case THEORY_PERIODIC:
      print_drive(out, c, r);
      if (r->solved) {
        print_formulas(out, c, r);
        print_solution(out, &r->solution);
      } else {
        fprintf(out, "\nno periodic state: see the message\n");
      }
      break;
  }
}

/* --- JSON output; names and units: docs/theory.md --------------------------------------------- */

static const char *const relations[] = {
    [THEORY_OTHER_PHASE] = "other", [THEORY_IN_PHASE] = "in phase", [THEORY_OPPOSITE] = "opposite"};

static json_t *pair(const double value[2]) { return json_numbers(2, value); }

static json_t *by_configuration(const double value[4]) {
  json_t *object = json_object();
  for (int k = 0; k < 4; k++)
    json_object_set_new(object, theory_configurations[k], json_number(value[k]));
  return object;
}

static json_t *geometry_json(const theory_case *c) {
  return json_pack("{s:s, s:[s, s], s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}",
                   "upper", c->upper, "supports", c->support[0], c->support[1], "swapped",
                   (int)c->swapped, "tilt", json_number(c->disk.tilt), "half_aperture",
                   json_number(c->disk.half_aperture), "alpha", pair(c->alpha), "mu",
                   json_number(c->disk.mu), "weight", json_number(c->disk.weight), "radius",
                   json_number(c->disk.radius), "support_radius", pair(c->support_radius),
                   "inertia", json_number(c->disk.inertia), "t_g", json_number(c->t_g), "offset",
                   json_number(c->offset), "locked", (int)c->locked);
}

static json_t *tep_json(const theory_result *r) {
  json_t *list = json_array();
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &r->tep[k];
    json_array_append_new(list,
                          json_pack("{s:s, s:o, s:o, s:o, s:b, s:b}", "configuration",
                                    theory_configurations[k], "normal", pair(t->normal), "torque",
                                    json_number(t->torque), "closed", json_number(r->torque[k]),
                                    "compressive", (int)t->compressive, "stable", (int)t->stable));
  }
  return list;
}

static json_t *steady_json(const theory_case *c, const theory_result *r) {
  const int *s = r->signs, k = 2 * (s[0] < 0) + (s[1] < 0);
  return json_pack("{s:s, s:o, s:[i, i], s:o, s:o}", "kind", "steady", "velocity",
                   pair(c->velocity), "signs", s[0], s[1], "torque",
                   json_number(s[0] && s[1] ? r->torque[k] : NAN), "final",
                   json_number(r->final_spin));
}

static json_t *random_json(const theory_case *c, const theory_result *r) {
  const double torque = c->shared ? r->sync : r->slight;
  return json_pack("{s:s, s:b, s:i}", "kind", "random", "shared", (int)c->shared, "sign",
                   (torque > 0) - (torque < 0));
}

static json_t *periodic_json(const theory_case *c, const theory_result *r) {
  const sd_drive *d = &c->drive;
  return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:b, s:o, s:s, s:o}", "kind", "periodic",
                   "waveform", d->waveform == SD_SINE ? "sine" : "parabola", "amplitudes",
                   pair(d->amplitude), "phases", pair(d->phase), "omega", json_number(d->omega),
                   "amplitude", json_number(r->amplitude), "even", (int)r->even, "phase",
                   json_number(r->apart), "relation", relations[r->relation], "ratio",
                   json_number(r->ratio));
}

static json_t *drive_json(const theory_case *c, const theory_result *r) {
  switch (c->kind) {
    case THEORY_STEADY: return steady_json(c, r);
    case THEORY_PERIODIC: return periodic_json(c, r);
    case THEORY_RANDOM: return random_json(c, r);
    case THEORY_REST: break;
  }
  return json_pack("{s:s}", "kind", "rest");
}

static json_t *formulas_json(const theory_case *c, const theory_result *r) {
  const sd_sync *p = &r->parabola;
  json_t *sync = isnan(p->mean) ? json_null()
                                : json_pack("{s:o, s:o, s:o, s:o, s:o, s:b}", "t1",
                                            json_number(p->t1), "t2", json_number(p->t2), "++",
                                            json_number(p->pp), "--", json_number(p->mm), "mean",
                                            json_number(p->mean), "permanent", (int)p->permanent);
  double turn = tan(c->disk.half_aperture) > c->disk.mu ? sd_reversal_phase(&c->disk) : NAN;
  return json_pack(
      "{s:o, s:o, s:o, s:o, s:o, s:o}", "sync", sync, "first_order", json_number(r->first_order),
      "sine", json_number(r->sine), "limit", json_number(r->limit), "reversal_phase",
      json_number(turn), "slight_tilt",
      json_pack("{s:o, s:o}", "all", json_number(r->slight), "sync", json_number(r->sync)));
}

static json_t *solution_json(const theory_case *c, const theory_result *r) {
  if (!r->solved) return json_null();
  const sd_sliding *s = &r->solution;
  json_t *pieces = json_array();
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    json_array_append_new(pieces,
                          json_pack("{s:o, s:o, s:o, s:[i, i]}", "start", json_number(p->start),
                                    "omega", json_number(p->omega), "acceleration",
                                    json_number(p->acceleration), "signs", p->sign[0], p->sign[1]));
  }
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "mean", json_number(s->mean),
                   "mean_scaled", json_number(s->mean * c->t_g), "mean_normalised",
                   json_number(s->mean / (r->amplitude * c->drive.omega)), "period",
                   json_number(s->period), "durations", by_configuration(s->duration), "stuck",
                   json_number(s->stuck), "permanent", (int)s->permanent, "pieces", pieces);
}

bool theory_json(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r) {
  char *deck = text_clean(memory_text(sd_model_deck(m)->path));
  json_t *root =
      json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "deck", deck, "title",
                m->title ? m->title : "", "geometry", geometry_json(c), "tep", tep_json(r), "drive",
                drive_json(c, r), "formulas", formulas_json(c, r), "solution",
                c->kind == THEORY_PERIODIC ? solution_json(c, r) : json_null());
  bool done = root && json_dumpf(root, out, JSON_INDENT(2)) == 0;
  if (done) fputc('\n', out);
  json_decref(root);
  free(deck);
  return done;
}
