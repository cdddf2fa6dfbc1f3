/* theory_facts.c: numbers of the theory of three disks, one row each, from which JSON, CSV and
 * lines of the text follow; see theory.h and docs/theory.md. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/json.h"
#include "app/theory/theory.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/model.h"
#include "slipdisk/deck.h"

const char *const theory_configurations[4] = {
    [SD_PP] = "++", [SD_PM] = "+-", [SD_MP] = "-+", [SD_MM] = "--"};

const char *theory_configuration(const int sign[2]) {
  return sign[0] && sign[1] ? theory_configurations[2 * (sign[0] < 0) + (sign[1] < 0)] : NULL;
}

/* --- facts ------------------------------------------------------------------------------------ */

/* Row of a member of theory_case. name: "group.name" in JSON, "": not there; label: in text, NULL:
 * not there; column: in CSV, NULL: not there. */
#define ROW(name, type, element, field, label, column)                                             \
  {                                                                                                \
    name, "", label, OBSERVABLE_##type, sizeof((theory_case *)0)->field / sizeof(element),         \
        offsetof(theory_case, field), NULL, column, NULL, NULL                                     \
  }
#define REAL(name, field, label, column) ROW(name, F64, double, field, label, column)
#define FLAG(name, field) ROW(name, FLAG, bool, field, NULL, NULL)
#define SIGN(name, field) ROW(name, I32, int, field, NULL, NULL)
/* Rows of numbers in JSON alone and in CSV alone */
#define JSON(name, field) REAL(name, field, NULL, NULL)
#define CELL(column, field) REAL("", field, NULL, column)

static const observable rows[] = {
    FLAG("geometry.swapped", swapped),
    REAL("geometry.tilt", disk.tilt, "tilt theta_T", "tilt"),
    REAL("geometry.half_aperture", disk.half_aperture, "half aperture theta_h", "half_aperture"),
    JSON("geometry.alpha", alpha),
    REAL("geometry.mu", disk.mu, "friction mu", "mu"),
    JSON("geometry.weight", disk.weight),
    JSON("geometry.radius", disk.radius),
    JSON("geometry.support_radius", support_radius),
    JSON("geometry.inertia", disk.inertia),
    JSON("geometry.t_g", t_g),
    JSON("geometry.offset", offset),
    FLAG("geometry.locked", locked),
    CELL("torque_pp", torque[SD_PP]),
    CELL("torque_pm", torque[SD_PM]),
    CELL("torque_mp", torque[SD_MP]),
    CELL("torque_mm", torque[SD_MM]),
    CELL("normal_1_pp", tep[SD_PP].normal[0]),
    CELL("normal_2_pp", tep[SD_PP].normal[1]),
    CELL("normal_1_pm", tep[SD_PM].normal[0]),
    CELL("normal_2_pm", tep[SD_PM].normal[1]),
    CELL("normal_1_mp", tep[SD_MP].normal[0]),
    CELL("normal_2_mp", tep[SD_MP].normal[1]),
    CELL("normal_1_mm", tep[SD_MM].normal[0]),
    CELL("normal_2_mm", tep[SD_MM].normal[1]),
    REAL("slight_tilt.all", slight, "all four equally long (19)", "slight_tilt"),
    REAL("slight_tilt.sync", sync, "S++ and S-- only (31)", "slight_tilt_sync"),
    JSON("steady.velocity", velocity),
    SIGN("steady.signs", signs),
    REAL("steady.torque", start_torque, "torque", NULL),
    REAL("steady.final", final_spin, "angular velocity that it tends to", NULL),
    FLAG("random.shared", shared),
    SIGN("random.sign", sense),
    JSON("periodic.amplitudes", drive.amplitude),
    JSON("periodic.phases", drive.phase),
    REAL("periodic.amplitude", amplitude, "Theta_b", "amplitude"),
    REAL("periodic.omega", drive.omega, "w_b", "omega"),
    FLAG("periodic.even", even),
    REAL("periodic.phase", apart, NULL, "phase"),
    REAL("periodic.ratio", ratio, "torque/(I Theta_b w_b^2)", NULL),
    REAL("sync.t1", parabola.t1, "t1: S-- begins", NULL),
    REAL("sync.t2", parabola.t2, "t2: S++ begins", NULL),
    REAL("sync.++", parabola.pp, "T++", NULL),
    REAL("sync.--", parabola.mm, "T--", NULL),
    JSON("sync.mean", parabola.mean),
    FLAG("sync.permanent", parabola.permanent),
    REAL("solution.mean", solution.mean, NULL, "mean"),
    REAL("solution.mean_scaled", mean_scaled, NULL, "mean_scaled"),
    REAL("solution.mean_normalised", mean_normalised, NULL, "mean_normalised"),
    REAL("formulas.first_order", first_order, NULL, "first_order"),
    JSON("formulas.sine", sine),
    REAL("formulas.limit", limit, NULL, "limit"),
    REAL("formulas.reversal_phase", reversal, "phase at which the sense turns over", NULL),
    CELL("pp", fraction[SD_PP]),
    CELL("pm", fraction[SD_PM]),
    CELL("mp", fraction[SD_MP]),
    CELL("mm", fraction[SD_MM]),
    CELL("stuck", stuck),
    CELL("permanent", permanent),
};
const observable_list theory_facts = OBSERVABLES("theory", "", rows);

/* --- JSON ------------------------------------------------------------------------------------- */

static json_t *tep_json(const theory_case *c) {
  json_t *list = json_array();
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &c->tep[k];
    json_array_append_new(
        list, json_pack("{s:s, s:o, s:o, s:o, s:b, s:b}", "configuration", theory_configurations[k],
                        "normal", json_numbers(2, t->normal), "torque", json_number(t->torque),
                        "closed", json_number(c->torque[k]), "compressive", (int)t->compressive,
                        "stable", (int)t->stable));
  }
  return list;
}

/* Returns the drive; facts: groups of numbers, one of them named like the kind of drive. */
static json_t *drive_json(const theory_case *c, const json_t *facts) {
  static const char *const kinds[] = {[THEORY_REST] = "rest",
                                      [THEORY_STEADY] = "steady",
                                      [THEORY_PERIODIC] = "periodic",
                                      [THEORY_RANDOM] = "random"};
  static const char *const relations[] = {[THEORY_OTHER_PHASE] = "other",
                                          [THEORY_IN_PHASE] = "in phase",
                                          [THEORY_OPPOSITE] = "opposite"};
  const char *kind = kinds[c->kind];
  json_t *drive = json_pack("{s:s}", "kind", kind);
  /* Names with null set the order of members; their values follow */
  if (c->kind == THEORY_PERIODIC)
    json_object_update_new(drive, json_pack("{s:s, s:n, s:n, s:n, s:n, s:n, s:n, s:s}", "waveform",
                                            c->drive.waveform == SD_SINE ? "sine" : "parabola",
                                            "amplitudes", "phases", "omega", "amplitude", "even",
                                            "phase", "relation", relations[c->relation]));
  json_object_update(drive, json_object_get(facts, kind));
  return drive;
}

static json_t *formulas_json(const theory_case *c, const json_t *facts) {
  json_t *sync = isnan(c->parabola.mean) ? json_null() : json_object_get(facts, "sync");
  json_t *formulas = json_pack("{s:O}", "sync", sync);
  json_object_update(formulas, json_object_get(facts, "formulas"));
  json_object_set(formulas, "slight_tilt", json_object_get(facts, "slight_tilt"));
  return formulas;
}

static json_t *solution_json(const theory_case *c, const json_t *facts) {
  if (!c->solved) return json_null();
  const sd_sliding *s = &c->solution;
  json_t *pieces = json_array(), *durations = json_object();
  for (int k = 0; k < 4; k++)
    json_object_set_new(durations, theory_configurations[k], json_number(s->duration[k]));
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    json_array_append_new(pieces,
                          json_pack("{s:o, s:o, s:o, s:[i, i]}", "start", json_number(p->start),
                                    "omega", json_number(p->omega), "acceleration",
                                    json_number(p->acceleration), "signs", p->sign[0], p->sign[1]));
  }
  json_t *solution = json_copy(json_object_get(facts, "solution"));
  json_object_update_new(solution,
                         json_pack("{s:o, s:o, s:o, s:b, s:o}", "period", json_number(s->period),
                                   "durations", durations, "stuck", json_number(s->stuck),
                                   "permanent", (int)s->permanent, "pieces", pieces));
  return solution;
}

bool theory_json(FILE *out, const sd_model *m, const theory_case *c) {
  char *deck = text_clean(memory_text(sd_model_deck(m)->path));
  json_t *facts = json_object();
  json_add(facts, &theory_facts, c, 0, 0);
  json_t *geometry =
      json_pack("{s:s, s:[s, s]}", "upper", c->upper, "supports", c->support[0], c->support[1]);
  json_object_update(geometry, json_object_get(facts, "geometry"));
  json_t *root = json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "deck", deck, "title",
                           m->title ? m->title : "", "geometry", geometry, "tep", tep_json(c),
                           "drive", drive_json(c, facts), "formulas", formulas_json(c, facts),
                           "solution", solution_json(c, facts));
  bool done = root && json_dumpf(root, out, JSON_INDENT(2)) == 0;
  if (done) fputc('\n', out);
  json_decref(root);
  json_decref(facts);
  free(deck);
  return done;
}

/* --- CSV: a row per set of a sweep ------------------------------------------------------------ */

/* Writes a CSV cell; the cell is empty if the value is not finite. */
static void number_cell(FILE *out, double value) {
  if (isfinite(value)) fprintf(out, "%.15g", value + 0.0); /* Adding 0.0 turns -0 into 0 */
}

/* Writes the name of a CSV column; adds the prefix "theory_" if a parameter of the sweep has the
 * same name. */
static void head_cell(FILE *out, const deck_sweep *s, const char *name) {
  fputc(',', out);
  for (size_t k = 0; k < s->n_parameters; k++)
    if (strcmp(s->parameters[k].name, name) == 0) {
      fputs("theory_", out);
      break;
    }
  fputs(name, out);
}

void theory_table_head(FILE *out, const deck_sweep *s) {
  fputs("set,name", out);
  for (size_t k = 0; k < s->n_parameters; k++) {
    fputc(',', out);
    text_cell(out, s->parameters[k].name);
  }
  for (size_t k = 0; k < theory_facts.n; k++)
    if (rows[k].column) head_cell(out, s, rows[k].column);
  fputc('\n', out);
}

void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c) {
  const sweep_point *p = &s->points[point];
  fprintf(out, "%zu,", p->set);
  text_cell(out, p->name);
  for (size_t k = 0; k < s->n_parameters; k++) {
    fputc(',', out);
    if (isfinite(p->values[k]))
      number_cell(out, p->values[k]);
    else
      text_cell(out, p->texts[k]);
  }
  for (size_t k = 0; k < theory_facts.n; k++)
    if (rows[k].column) {
      fputc(',', out);
      number_cell(out, observable_value(&rows[k], c, 0));
    }
  fputc('\n', out);
}

/* --- CSV: curves of one period ---------------------------------------------------------------- */

enum { WAVE_ROWS = 2001 };

static void wave_row(FILE *out, const sd_sliding *s, double t, size_t piece) {
  const sd_sliding_piece *p = &s->pieces[piece];
  const char *name = theory_configuration(p->sign);
  fprintf(out, "%.17g", t);
  for (int i = 0; i < 2; i++) fprintf(out, ",%.17g", sd_sliding_support(&s->disk, &s->drive, i, t));
  for (int i = 0; i < 2; i++) fprintf(out, ",%.17g", sd_sliding_angle(&s->drive, i, t));
  fprintf(out, ",%.17g,%s\n", sd_sliding_omega(s, t), name ? name : "stuck");
}

/* Writes rows at equal intervals of time, and a further row at each time at which a new sliding
 * configuration begins, labelled with the new one. */
void theory_wave(FILE *out, const theory_case *c) {
  const sd_sliding *s = &c->solution;
  size_t piece = 0;
  fprintf(out, "t,support1,support2,theta1,theta2,Omega,configuration\n");
  for (int k = 0; k < WAVE_ROWS; k++) {
    double t = s->period * k / (WAVE_ROWS - 1), same = 1e-12 * s->period;
    while (piece + 1 < s->n_pieces && s->pieces[piece + 1].start < t + same) {
      piece++;
      if (s->pieces[piece].start < t - same) wave_row(out, s, s->pieces[piece].start, piece);
    }
    wave_row(out, s, t, k == WAVE_ROWS - 1 ? 0 : piece);
  }
}
