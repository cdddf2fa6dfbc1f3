/* theory_table.c: the theory as CSV: a row per set of a sweep, and the curves of one period. */
#include <math.h>
#include <string.h>

#include "app/theory/theory.h"
#include "base/text.h"

/* --- a row per set ------------------------------------------------------------------------------------- */

/* Values that do not apply are empty cells. */
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

typedef struct cell {
  const char *name;
  double value;
} cell;
enum { MOST_CELLS = 32 };

/* The columns: names, and the values of a case; returns how many. */
static size_t list_cells(const theory_case *c, const theory_result *r, cell out[MOST_CELLS]) {
  const sd_sliding *x = &r->solution;
  double unknown = r->solved ? 0 : NAN; /* added to what only a solution has */
  double period = r->solved ? x->period : NAN;
  const cell cells[] = {{"tilt", c->disk.tilt},
                        {"half_aperture", c->disk.half_aperture},
                        {"mu", c->disk.mu},
                        {"torque_pp", r->torque[SD_PP]},
                        {"torque_pm", r->torque[SD_PM]},
                        {"torque_mp", r->torque[SD_MP]},
                        {"torque_mm", r->torque[SD_MM]},
                        {"normal_1_pp", r->tep[SD_PP].normal[0]},
                        {"normal_2_pp", r->tep[SD_PP].normal[1]},
                        {"normal_1_pm", r->tep[SD_PM].normal[0]},
                        {"normal_2_pm", r->tep[SD_PM].normal[1]},
                        {"normal_1_mp", r->tep[SD_MP].normal[0]},
                        {"normal_2_mp", r->tep[SD_MP].normal[1]},
                        {"normal_1_mm", r->tep[SD_MM].normal[0]},
                        {"normal_2_mm", r->tep[SD_MM].normal[1]},
                        {"slight_tilt", r->slight},
                        {"slight_tilt_sync", r->sync},
                        {"amplitude", r->amplitude},
                        {"omega", c->kind == THEORY_PERIODIC ? c->drive.omega : NAN},
                        {"phase", r->apart},
                        {"mean", x->mean + unknown},
                        {"mean_scaled", x->mean * c->t_g + unknown},
                        {"mean_normalised", x->mean / (r->amplitude * c->drive.omega) + unknown},
                        {"first_order", r->first_order},
                        {"limit", r->limit},
                        {"pp", x->duration[SD_PP] / period},
                        {"pm", x->duration[SD_PM] / period},
                        {"mp", x->duration[SD_MP] / period},
                        {"mm", x->duration[SD_MM] / period},
                        {"stuck", x->stuck / period},
                        {"permanent", r->solved ? x->permanent : NAN}};
  memcpy(out, cells, sizeof cells);
  return sizeof cells / sizeof *cells;
}

void theory_table_head(FILE *out, const deck_sweep *s) {
  static const theory_case none;
  static const theory_result nothing;
  cell cells[MOST_CELLS];
  size_t n = list_cells(&none, &nothing, cells);
  fputs("set,name", out);
  for (size_t k = 0; k < s->n_parameters; k++) {
    fputc(',', out);
    text_cell(out, s->parameters[k].name);
  }
  for (size_t k = 0; k < n; k++) head_cell(out, s, cells[k].name);
  fputc('\n', out);
}

void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c,
                      const theory_result *r) {
  const sweep_point *p = &s->points[point];
  cell cells[MOST_CELLS];
  size_t n = list_cells(c, r, cells);
  fprintf(out, "%zu,", p->set);
  text_cell(out, p->name);
  for (size_t k = 0; k < s->n_parameters; k++) {
    fputc(',', out);
    if (isfinite(p->values[k]))
      number_cell(out, p->values[k]);
    else
      text_cell(out, p->texts[k]);
  }
  for (size_t k = 0; k < n; k++) {
    fputc(',', out);
    number_cell(out, cells[k].value);
  }
  fputc('\n', out);
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
