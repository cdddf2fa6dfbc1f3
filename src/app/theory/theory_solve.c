/* theory_solve.c: selects the formulas that apply to the three disks of a deck, evaluates them,
 * and writes them as CSV. */
#include <math.h>
#include <string.h>

#include "app/theory/theory.h"
#include "base/text.h"

const char *const theory_configurations[4] = {
    [SD_PP] = "++", [SD_PM] = "+-", [SD_MP] = "-+", [SD_MM] = "--"};

static const int signs[4][2] = {
    [SD_PP] = {1, 1}, [SD_PM] = {1, -1}, [SD_MP] = {-1, 1}, [SD_MM] = {-1, -1}};

/* Phases that differ by less than this many rad count as equal. */
static const double SAME = 1e-9;

static int sign(double x) { return (x > 0) - (x < 0); }

/* Solves the case of steady drive. The torque on the upper disk falls with its angular velocity
 * Omega: it is positive (torque of S++) when Omega is below the values at which the disk would roll
 * on either support, and negative (S--) when Omega is above both. A disk free to rotate ends at the
 * Omega at which the torque changes sign. */
static void solve_steady(const theory_case *c, theory_result *r) {
  double w[2];
  for (int i = 0; i < 2; i++) {
    w[i] = -c->velocity[i] * c->support_radius[i] / c->disk.radius;
    r->signs[i] = sign(w[i] - c->spin);
  }
  double between = r->torque[w[0] > w[1] ? SD_PM : SD_MP];
  r->final_spin = between > 0 ? fmax(w[0], w[1]) : between < 0 ? fmin(w[0], w[1]) : NAN;
  if (w[0] == w[1]) r->final_spin = w[0];
  if (c->locked) r->final_spin = NAN;
}

static void solve_closed(const theory_case *c, theory_result *r) {
  const sd_drive *d = &c->drive;
  const sd_three_disk *disk = &c->disk;
  bool sine = d->waveform == SD_SINE;
  /* Acceleration at velocity 0 of a sine divided by that of the parabolic wave with the same
   * amplitude */
  double slope = sine ? M_PI * M_PI / 8 : 1;
  if (!r->even) return;
  if (r->relation == THEORY_IN_PHASE) {
    if (sine)
      r->sine = sd_sync_mean_sine(disk, r->amplitude, d->omega);
    else
      r->parabola = sd_sync_parabola(disk, r->amplitude, d->omega);
    r->first_order = slope * sd_sync_mean_parabola(disk, r->amplitude, d->omega);
  } else if (r->relation == THEORY_OPPOSITE) {
    r->first_order = slope * sd_async_first_order(disk, r->amplitude, d->omega);
  }
}

static sd_status solve_periodic(const theory_case *c, theory_result *r, sd_messages *messages) {
  sd_drive exact = c->drive, *d = &exact;
  double a[2];
  for (int i = 0; i < 2; i++) a[i] = d->amplitude[i] * d->support_radius[i] / c->disk.radius;
  r->amplitude = fmax(a[0], a[1]);
  r->even = fabs(a[0] - a[1]) <= 1e-12 * r->amplitude;
  r->apart = remainder(d->phase[1] - d->phase[0], 2 * M_PI);
  if (fabs(r->apart) > M_PI - SAME) r->apart = M_PI;
  if (fabs(r->apart) < SAME) r->apart = 0;
  d->phase[1] = d->phase[0] + r->apart;
  r->relation = r->apart == 0      ? THEORY_IN_PHASE
                : r->apart == M_PI ? THEORY_OPPOSITE
                                   : THEORY_OTHER_PHASE;
  double largest = 0;
  for (int k = 0; k < 4; k++)
    if (r->relation != THEORY_IN_PHASE || !r->even || k == SD_PP || k == SD_MM)
      largest = fmax(largest, fabs(r->torque[k]));
  r->ratio = largest / (c->disk.inertia * r->amplitude * d->omega * d->omega);
  sd_status status = sd_sliding_solve(&c->disk, d, &r->solution, messages);
  r->solved = status == SD_OK;
  if (status) return status; /* No formula applies if a sliding configuration has no equilibrium */
  solve_closed(c, r);
  return sd_sliding_limit(&c->disk, d, &r->limit, messages);
}

sd_status theory_case_solve(const theory_case *c, theory_result *r, sd_messages *messages) {
  *r = (theory_result){.apart = NAN,
                       .amplitude = NAN,
                       .ratio = NAN,
                       .parabola = {.t1 = NAN, .t2 = NAN, .pp = NAN, .mm = NAN, .mean = NAN},
                       .first_order = NAN,
                       .sine = NAN,
                       .limit = NAN,
                       .final_spin = NAN};
  for (int k = 0; k < 4; k++) {
    r->tep[k] = sd_tep_solve(&c->disk, signs[k][0], signs[k][1]);
    r->torque[k] = sd_tep_torque(&c->disk, signs[k][0], signs[k][1]);
  }
  r->slight = sd_slight_tilt_torque(&c->disk);
  r->sync = sd_slight_tilt_torque_sync(&c->disk);
  if (c->kind == THEORY_STEADY) solve_steady(c, r);
  return c->kind == THEORY_PERIODIC ? solve_periodic(c, r, messages) : SD_OK;
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

typedef struct cell {
  const char *name;
  double value;
} cell;
enum { MOST_CELLS = 32 };

/* Fills out[] with names and values of all CSV columns, and returns their number. */
static size_t list_cells(const theory_case *c, const theory_result *r, cell out[MOST_CELLS]) {
  const sd_sliding *x = &r->solution;
  /* 0 if a periodic state was found, else NAN; added to values that are known only with one */
  double unknown = r->solved ? 0 : NAN;
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

/* --- CSV: curves of one period ---------------------------------------------------------------- */

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

/* Writes rows at equal intervals of time, and a further row at each time at which a new sliding
 * configuration begins, labelled with the new one. */
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
