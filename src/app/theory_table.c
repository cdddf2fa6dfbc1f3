/* theory_table.c: the theory as CSV: a row per set of a sweep, and the curves of one period. */
#include <math.h>
#include <string.h>

#include "app/theory.h"

/* --- a row per set ------------------------------------------------------------------------------------- */

static const char *const columns[] = {"tilt",
                                      "half_aperture",
                                      "mu",
                                      "torque_pp",
                                      "torque_pm",
                                      "torque_mp",
                                      "torque_mm",
                                      "slight_tilt",
                                      "slight_tilt_sync",
                                      "amplitude",
                                      "omega",
                                      "phase",
                                      "mean",
                                      "mean_scaled",
                                      "mean_normalised",
                                      "first_order",
                                      "limit",
                                      "pp",
                                      "pm",
                                      "mp",
                                      "mm",
                                      "stuck"};
enum { COLUMNS = sizeof columns / sizeof *columns };

/* Quoted where a comma, a quote or a line break makes it necessary. */
static void text_cell(FILE *out, const char *text) {
  if (!strpbrk(text, ",\"\n\r")) {
    fputs(text, out);
    return;
  }
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"') fputc('"', out);
    fputc(*text, out);
  }
  fputc('"', out);
}

/* What does not apply is an empty cell. */
static void number_cell(FILE *out, double value) {
  if (isfinite(value)) fprintf(out, "%.15g", value + 0.0); /* no -0 */
}

/* A column whose name the sweep uses already is told apart. */
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
  for (size_t k = 0; k < COLUMNS; k++) head_cell(out, s, columns[k]);
  head_cell(out, s, "permanent");
  fputc('\n', out);
}

void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c,
                      const theory_result *r) {
  const sweep_point *p = &s->points[point];
  const sd_sliding *x = &r->solution;
  bool periodic = c->kind == THEORY_PERIODIC;
  double unknown = r->solved ? 0 : NAN; /* added to what only a solution has */
  double period = r->solved ? x->period : NAN;
  const double value[COLUMNS] = {
      c->disk.tilt,
      c->disk.half_aperture,
      c->disk.mu,
      r->torque[SD_PP],
      r->torque[SD_PM],
      r->torque[SD_MP],
      r->torque[SD_MM],
      r->slight,
      r->sync,
      r->amplitude,
      periodic ? c->drive.omega : NAN,
      r->apart,
      x->mean + unknown,
      x->mean * c->t_g + unknown,
      x->mean / (r->amplitude * c->drive.omega) + unknown,
      r->first_order,
      r->limit,
      x->duration[SD_PP] / period,
      x->duration[SD_PM] / period,
      x->duration[SD_MP] / period,
      x->duration[SD_MM] / period,
      x->stuck / period,
  };
  fprintf(out, "%zu,", p->set);
  text_cell(out, p->name);
  for (size_t k = 0; k < s->n_parameters; k++) {
    fputc(',', out);
    if (isfinite(p->values[k]))
      number_cell(out, p->values[k]);
    else
      text_cell(out, p->texts[k]);
  }
  for (size_t k = 0; k < COLUMNS; k++) {
    fputc(',', out);
    number_cell(out, value[k]);
  }
  fprintf(out, ",%s\n", !r->solved ? "" : x->permanent ? "1" : "0");
}

/* --- one period ------------------------------------------------------------------------------------------ */

enum { WAVE_ROWS = 2001 };

static void wave_row(FILE *out, const sd_sliding *s, double t, size_t piece) {
  const sd_sliding_piece *p = &s->pieces[piece];
  bool slides = p->sign[0] && p->sign[1];
  fprintf(out, "%.15g", t);
  for (int i = 0; i < 2; i++) fprintf(out, ",%.15g", sd_sliding_support(&s->disk, &s->drive, i, t));
  for (int i = 0; i < 2; i++) fprintf(out, ",%.15g", sd_sliding_angle(&s->drive, i, t));
  fprintf(out, ",%.15g,%s\n", sd_sliding_omega(s, t),
          slides ? theory_configurations[2 * (p->sign[0] < 0) + (p->sign[1] < 0)] : "stuck");
}

/* Evenly spaced rows, and between them one for each corner, with the configuration that begins there. */
void theory_wave(FILE *out, const theory_result *r) {
  const sd_sliding *s = &r->solution;
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
