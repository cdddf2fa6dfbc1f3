/* mean.c: computes means with error bars, of records and of running sums in a state, and the length
 * of the transient; tests whether the goal of a run is met. */

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "measure/error_bar.h"
#include "measure/observable.h"
#include "model/model.h"
#include "model/motions.h"
#include "model/state.h"
#include "slipdisk/measure.h"

/* Returns the systematic error of a mean due to the drift `left` in the record. For a relaxation
 * without noise, exp(-t/T), the bias of the mean is h (1 + u)/(1 - u), with h half the difference
 * between the means of the two halves of the record, and u the ratio of the differences between its
 * last and its first two quarters. */
static double systematic(drift left, error_bar error, bool quiet) {
  double u = math_min(left.ratio, 0.75);
  if (quiet && !error.reliable) return left.half * (1 + u) / (1 - u);
  return !error.slow && !(left.sigmas > DRIFT_SEEN) ? 0 : left.half;
}

sd_mean sd_mean_of(const double *x, size_t n, bool look) {
  sd_mean mean = {.mean = NAN, .error = NAN, .correlation = NAN};
  if (n == 0) return mean;
  const transient start = look ? transient_of(x, n) : transient_none(x, n);
  const error_bar error = start.rest;
  const drift left = start.left;
  mean.discarded = start.length;
  mean.used = n - start.length;
  mean.mean = sums_mean(x + start.length, mean.used);
  mean.correlation = error.correlation;
  mean.error =
      math_hypot(error.error, math_hypot(start.tail, systematic(left, error, start.quiet)));
  /* Converged: either the error is reliable and no significant drift is left, or a relaxation
   * without noise has mostly decayed. */
  bool over =
      (error.reliable && !(left.sigmas > DRIFT_CERTAIN)) || (start.quiet && left.ratio < 0.5);
  mean.converged = start.inside && isfinite(error.error) && over;
  return mean;
}

/* --- periodic drive --------------------------------------------------------------------------- */

double mean_period(const sd_model *model) {
  enum { MOST = 16 };
  double each[MOST];
  size_t n = 0;
  for (size_t m = 0; m < model->n_motions; m++) {
    const sd_motion *motion = &model->motions[m];
    bool used = false;
    for (size_t p = 0; p < model->n_phases; p++)
      used |= model->phases[p].measure && model->phases[p].active[m];
    if (!used) continue;
    double period = motion_period(motion);
    if (!(period > 0) || n == MOST) return 0;
    each[n++] = period;
  }
  for (int turns = 1; n > 0 && turns <= MOST; turns++) {
    bool common = true;
    for (size_t m = 0; m < n && common; m++) {
      double part = turns * each[0] / each[m];
      common = part > 0.5 && fabs(part - round(part)) < 1e-6 * part;
    }
    if (common) return turns * each[0];
  }
  return 0;
}

/* Returns the integral from 0 to u of a triangular weight on [0, 2] with total area 1. */
static double triangle(double u) {
  if (u <= 0) return 0;
  return u < 1 ? u * u / 2 : u < 2 ? 1 - (2 - u) * (2 - u) / 2 : 1;
}

/* Computes running means y[] of x[0..n), weighted by a triangle of length 2 * width. The windows
 * are `stride` apart, as many as fit, and the last one ends with the record. A triangular weight is
 * a running mean over one width applied twice, so a ripple whose period divides the width cancels,
 * wherever the edges of the bins lie. Returns the number of means. */
static size_t windows(const double *x, size_t n, double width, double stride, double *y) {
  size_t count = (size_t)(((double)n - 2 * width) / stride) + 1;
  for (size_t k = 0; k < count; k++) {
    double from = math_max(0, (double)n - 2 * width - (double)(count - 1 - k) * stride);
    size_t end = (size_t)math_min((double)n, ceil(from + 2 * width));
    y[k] = 0;
    for (size_t b = (size_t)from; b < end; b++)
      y[k] += x[b] *
              (triangle(((double)(b + 1) - from) / width) - triangle(((double)b - from) / width));
  }
  return count;
}

/* Returns the mean and error bar, as sd_mean_of does, of a record with a periodic ripple. period:
 * period of the ripple, in samples. */
static sd_mean mean_of_ripple(const double *x, size_t n, double period) {
  enum { NARROWEST = 8, ENOUGH = 64 };
  double width = period * ceil(NARROWEST / period), length = (double)n;
  /* if there are few windows, let them overlap more */
  double stride = width / ceil(math_max(1, ENOUGH * width / (length - 2 * width)));
  bool enough = length >= 4 * width && stride >= 1;
  double few[SD_BINS + 1] = {0}, *y = few;
  if (enough && n > SD_BINS && !memory_row(&y, n, sizeof *y)) {
    shortage_note();
    enough = false;
  }
  if (!enough) {
    sd_mean mean = sd_mean_of(x, n, true);
    mean.converged = false; /* the record has too few periods */
    return mean;
  }
  size_t count = windows(x, n, width, stride, y);
  sd_mean mean = sd_mean_of(y, count, true);
  if (y != few) free(y);
  mean.correlation *= stride;
  mean.discarded = (size_t)math_min(length, (double)mean.discarded * stride);
  mean.used = n - mean.discarded;
  return mean;
}

sd_mean mean_of_record(const double *x, size_t n, double period) {
  return period > 0 ? mean_of_ripple(x, n, period) : sd_mean_of(x, n, true);
}

/* The record whose mean has the error of the ratio depends on the ratio of the rows that are kept,
 * and these on the record: so both are computed until the cut stays the same, a few times at
 * most. look: true to search for a transient. */
static sd_mean ratio_of(const double *over, const double *under, size_t n, bool look,
                        double period) {
  enum { MOST = 4 };
  sd_mean mean = sd_mean_of(NULL, 0, false);
  double few[SD_BINS], *z = few;
  if (n > SD_BINS && !memory_row(&z, n, sizeof *z)) {
    shortage_note();
    return mean;
  }
  size_t cut = 0;
  for (int pass = 0; n > 0 && pass < MOST && (pass == 0 || mean.discarded != cut); pass++) {
    cut = mean.discarded;
    const double b = sums_mean(under + cut, n - cut), ratio = sums_mean(over + cut, n - cut) / b;
    for (size_t k = 0; k < n; k++) z[k] = ratio + (over[k] - ratio * under[k]) / b;
    mean = look ? mean_of_record(z, n, period) : sd_mean_of(z, n, false);
  }
  if (z != few) free(z);
  return mean;
}

sd_mean mean_of_ratio(const double *over, const double *under, size_t n, double period) {
  return ratio_of(over, under, n, true, period);
}

sd_mean sd_ratio_of(const double *over, const double *under, size_t n, bool look) {
  return ratio_of(over, under, n, look, 0);
}

sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k) {
  if (k >= model->n_rotations)
    return (sd_rotation){UINT32_MAX, NAN, NAN, NAN, NAN, NAN, NAN, NAN, false};
  uint32_t disk = model->rotations[k];
  double gravity = math_hypot(model->gravity[0], model->gravity[1]);
  double bin = (double)state->bin_steps * model->dt, scale = 1 / bin;
  double t_g = gravity > 0 ? sqrt(2 * model->disks[disk].radius / gravity) : NAN;
  size_t bins = state->bins > 0 ? (size_t)state->bins : 0;

  const double *record = state->rotation_bin + k * SD_BINS;
  sd_mean mean = mean_of_record(record, bins, mean_period(model) / bin);
  return (sd_rotation){
      .disk = disk,
      .omega = mean.mean * scale,
      .error = mean.error * scale,
      .scaled = mean.mean * scale * t_g,
      .scaled_error = mean.error * scale * t_g,
      .transient = (double)mean.discarded * bin,
      .measured = (double)state->measured * model->dt,
      .turned = state->rotation_last[k] - state->rotation_start[k],
      .converged = mean.converged,
  };
}

#define ROTATION(field, unit, meaning, column)                                                     \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_F64, 1, offsetof(sd_rotation, field), NULL, column, NULL,    \
        NULL                                                                                       \
  }

static const observable rotations[] = {
    OBSERVABLE_FIELD("disk", "1", "body number", U32, sd_rotation, disk, NULL, NULL),
    ROTATION(omega, "rad/time", "mean angular velocity Omega", "omega"),
    ROTATION(error, "rad/time", "one standard error of omega, correlations included",
             "omega_error"),
    ROTATION(scaled, "rad", "t_g Omega, t_g = sqrt(2 R/g)", "scaled"),
    ROTATION(scaled_error, "rad", "one standard error of scaled", "scaled_error"),
    ROTATION(transient, "time", "measured time discarded as transient", "transient"),
    ROTATION(measured, "time", "measured time, with the transient", "measured"),
    ROTATION(turned, "rad", "angle turned over the measured time", NULL),
    OBSERVABLE_FIELD("converged", "1", "1: the error bar is reliable", FLAG, sd_rotation, converged,
                     "converged", NULL),
};
const observable_list rotation_observables =
    OBSERVABLES("rotation", "of each watched disk, in /summary/rotation", rotations);

sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k) {
  if (k >= model->n_slides) {
    const double no = NAN;
    return (sd_slide){UINT32_MAX, {UINT32_MAX, UINT32_MAX},
                      no,         no,
                      no,         no,
                      no,         no,
                      {no, no},   {no, no},
                      {no, no},   {no, no},
                      {no, no},   {0}};
  }
  const sd_slide_watch *watch = &model->slides[k];
  const int64_t *count = state->slide_count + 16 * k;
  double total = (double)state->measured;
  sd_slide slide = {.disk = watch->disk};

  for (int first = 0; first < 4; first++)
    for (int second = 0; second < 4; second++) {
      /* before anything is measured every fraction is 0/0 = NAN */
      double part = (double)count[4 * first + second] / total;
      int own[2] = {first, second};
      for (int c = 0; c < 2; c++) {
        slide.contact_positive[c] += own[c] == SD_SLIDE_POSITIVE ? part : 0 * part;
        slide.contact_negative[c] += own[c] == SD_SLIDE_NEGATIVE ? part : 0 * part;
        slide.contact_stuck[c] += own[c] == SD_STUCK ? part : 0 * part;
        slide.contact_open[c] += own[c] == SD_OPEN ? part : 0 * part;
      }
      bool open = first == SD_OPEN || second == SD_OPEN;
      bool stick = !open && (first == SD_STUCK || second == SD_STUCK);
      slide.open += open ? part : 0 * part;
      slide.stick += stick ? part : 0 * part;
    }
  slide.pp = (double)count[4 * SD_SLIDE_POSITIVE + SD_SLIDE_POSITIVE] / total;
  slide.pm = (double)count[4 * SD_SLIDE_POSITIVE + SD_SLIDE_NEGATIVE] / total;
  slide.mp = (double)count[4 * SD_SLIDE_NEGATIVE + SD_SLIDE_POSITIVE] / total;
  slide.mm = (double)count[4 * SD_SLIDE_NEGATIVE + SD_SLIDE_NEGATIVE] / total;

  for (int c = 0; c < 2; c++) {
    slide.partner[c] = watch->partner[c];
    slide.force_min[c] = state->slide_force_min[2 * k + (size_t)c];
    slide.openings[c] = state->slide_openings[2 * k + (size_t)c];
  }
  return slide;
}

OBSERVABLE_GET(sliding, sd_slide, at->contact_positive[k] + at->contact_negative[k])

#define SLIDE(field, meaning, json)                                                                \
  { #field, "1", meaning, OBSERVABLE_F64, 1, offsetof(sd_slide, field), NULL, #field, json, NULL }
#define CONTACT(field, type, unit, meaning, column, json)                                          \
  { #field, unit, meaning, type, 2, offsetof(sd_slide, field), NULL, column, json, NULL }

static const observable slides[] = {
    OBSERVABLE_FIELD("disk", "1", "body number", U32, sd_slide, disk, NULL, NULL),
    CONTACT(partner, OBSERVABLE_U32, "1", "body numbers", NULL, NULL),
    SLIDE(pp, "fraction of measured steps in S++", "S++"),
    SLIDE(pm, "fraction of measured steps in S+-", "S+-"),
    SLIDE(mp, "fraction of measured steps in S-+", "S-+"),
    SLIDE(mm, "fraction of measured steps in S--", "S--"),
    SLIDE(stick, "fraction: at least one contact stuck, none open", NULL),
    SLIDE(open, "fraction: at least one contact open", NULL),
    CONTACT(contact_positive, OBSERVABLE_F64, "1", "fraction: slides, tau > 0", NULL, "positive"),
    CONTACT(contact_negative, OBSERVABLE_F64, "1", "fraction: slides, tau < 0", NULL, "negative"),
    CONTACT(contact_stuck, OBSERVABLE_F64, "1", "fraction: stuck", NULL, "stuck"),
    CONTACT(contact_open, OBSERVABLE_F64, "1", "fraction: open", NULL, "open"),
    {"sliding", "1", "fraction: slides", OBSERVABLE_F64, 2, 0, sliding, "sliding", "", NULL},
    CONTACT(force_min, OBSERVABLE_F64, "force", "smallest normal force", "force_min", NULL),
    CONTACT(openings, OBSERVABLE_I64, "1", "times the contact opened", "openings", NULL),
};
const observable_list slide_observables =
    OBSERVABLES("slide", "of each watched pair of contacts, in /summary/slide", slides);

/* Length of the transient by the marginal standard error rule, MSER.
 *
 * The rule takes the truncation d that minimises the naive error of the mean of the rest,
 *   sum_{i >= d} (y_i - mean_d)^2/(m - d)^2,
 * with y_i the m means of batches of samples (White, Simulation 69, 323 (1997); batches of 5:
 * White, Cobb & Spratt, Winter Simulation Conference (2000)). The rest of a transient has the size
 * of the batches' noise and adds up over the transient's length, so batches of 5 leave a bias of
 * several errors in a long record; here the batch size grows with the record, up to sqrt(n). Only
 * the first half is searched, as the statistic is erratic near the end; a minimum at the edge means
 * that no stationary part was found.
 *
 * A stationary record has such a minimum too, at a random position, and a cut there is biased: the
 * rest scatters less than the whole record, so its error bar is too small. So a cut counts only if
 * the part that it removes differs from the rest: the mean of this part, or of its first half,
 * quarter or eighth, by more than `distinct` errors of the difference, from the error bar of the
 * rest.
 *
 * Behind such a cut, the remainder of a relaxation has the size of the batches' noise, but adds up.
 * Two estimates reveal it: the decay within the part that is cut off (tail_of), and the difference
 * between the first quarter and the rest of the kept part (drift_of). While the first exceeds half
 * the error bar, or the second exceeds two standard errors, another sixteenth of the record is cut
 * off, up to half of it. The remainder after that enters the error bar.
 *
 * A record without noise that relaxes for ever (deterministic drive) has no minimum before the
 * edge, and its rest never looks stationary. It is called quiet if the naive error falls to a
 * hundredth of that of the whole record; the search ends once it is `enough` times that of the
 * whole record. */

enum { SMALLEST = 5, FEWEST_BATCHES = 64, PARTS = 4, STEPS = 16, BATCHES = 64, ENOUGH = 16 };
static const double quiet_at = 1e-2, enough = 1e-5, distinct = 3;

/* Computes square[d], the squared naive error of the mean when the first d of the m batches are cut
 * off, for d = 0 ... last. */
static void naive(const double *x, size_t batch, size_t m, size_t last, double *square) {
  /* Running moments (Welford), computed from the end of the record backwards, so that one pass
   * serves all truncations. */
  double scale = 0, mean = 0, squares = 0;
  for (size_t d = m; d-- > 0;) {
    double y = sums_mean(x + d * batch, batch), kept = (double)(m - d), off = y - mean;
    scale = math_max(scale, fabs(y));
    mean += off / kept;
    squares += off * (y - mean);
    if (d > last) continue;
    /* Variances below the rounding errors of the samples count as equal. */
    double rounding = 4 * DBL_EPSILON * scale;
    double variance = math_max(squares / (kept - 1), rounding * rounding);
    square[d] = variance * (kept - 1) / (kept * kept);
  }
}

/* Returns the standard deviation of the means of blocks of `part` samples, for at most BATCHES
 * blocks at the end of x[0..n); 0: there are too few blocks. */
static double scatter_of(const double *x, size_t n, size_t part) {
  double y[BATCHES];
  size_t count = n / part < BATCHES ? n / part : BATCHES;
  for (size_t k = 0; k < count; k++) y[k] = sums_mean(x + (n - (k + 1) * part), part);
  return count < ENOUGH ? 0 : sqrt(sums_variance(y, count));
}

/* Returns true if the mean of x[0..d), or of its first half, quarter or eighth, differs from that
 * of x[d..n). The scatter of means of such short parts is also measured in x[d..n), as
 * anticorrelated samples scatter more than the error bar of the rest implies. */
static bool stands_out(const double *x, size_t d, size_t n) {
  double rest = sums_mean(x + d, n - d), error = error_bar_of(x + d, n - d).error;
  size_t part = d;
  for (int k = 0; k < PARTS && part > 0; k++, part /= 2) {
    double short_one =
        math_max(error * sqrt((double)(n - d) / (double)part), scatter_of(x + d, n - d, part));
    double sigma = math_hypot(error, short_one);
    /* accept the cut also if the error bar is NAN */
    if (!(fabs(sums_mean(x, part) - rest) <= distinct * sigma)) return true;
  }
  return false;
}

drift drift_of(const double *x, size_t n, double error) {
  size_t quarter = n / 4;
  drift result = {.ratio = 0};
  if (n < ENOUGH) return result;
  double q[4];
  for (size_t k = 0; k < 4; k++) q[k] = sums_mean(x + (n - (4 - k) * quarter), quarter);
  double fall = fabs(q[0] - (q[1] + q[2] + q[3]) / 3);
  bool rounding = fall <= 8 * DBL_EPSILON * fabs(q[3]);
  /* The variance of a mean of L samples is error^2 n/L (correlated noise) plus c/L^2 (bounded
   * noise). With L = n/ENOUGH and ENOUGH = 16, c/L^2 is the variance of such means minus 16
   * error^2. */
  double scatter = scatter_of(x, n, n / ENOUGH);
  double bounded = math_max(0, scatter * scatter - 16 * error * error);
  double sigma = sqrt((4 + 4. / 3) * error * error + bounded * (1. / 16 + 1. / 144));
  result.sigmas = rounding ? 0 : fall / sigma;
  result.half = fabs(q[0] + q[1] - q[2] - q[3]) / 4;
  result.ratio = (q[2] - q[3]) / (q[0] - q[1]);
  if (!(result.ratio > 0)) result.ratio = 0;
  return result;
}

/* Returns the bias that a relaxation over x[0..d) leaves in the mean of x[d..n): the means of
 * the first and of the second half of x[0..d), minus the final mean, are continued as a
 * geometric series. */
static double tail_of(const double *x, size_t d, size_t n) {
  size_t half = d / 2;
  if (half == 0) return 0;
  double rest = sums_mean(x + d, n - d);
  double first = sums_mean(x, half) - rest, second = sums_mean(x + (d - half), half) - rest;
  double ratio = math_min(second / first, 0.75);
  return ratio > 0 ? fabs(second) * ratio / (1 - ratio) * (double)half / (double)(n - d) : 0;
}

/* Cuts off more of the start of the record while a relaxation is visible in the rest, and sets the
 * error bar and the drift of the rest. */
static void cut_drift(const double *x, size_t n, transient *found) {
  for (size_t step = n / STEPS;; found->length += step) {
    const double *rest = x + found->length;
    size_t kept = n - found->length;
    found->rest = error_bar_of(rest, kept);
    const double error = found->rest.error;
    found->left = drift_of(rest, kept, error);
    found->tail = tail_of(x, found->length, n);
    if (!(found->tail > error / 2 || found->left.sigmas > DRIFT_SEEN)) return;
    if (step > 0 && found->length + step <= n / 2) continue;
    found->inside &= found->tail <= error;
    return;
  }
}

transient transient_none(const double *x, size_t n) {
  transient found = {.inside = true, .rest = error_bar_of(x, n)};
  found.left = drift_of(x, n, found.rest.error);
  return found;
}

transient transient_of(const double *x, size_t n) {
  size_t batch = (size_t)math_min((double)n / FEWEST_BATCHES, sqrt((double)n));
  if (batch < SMALLEST) batch = SMALLEST;
  /* m: number of batches; last: largest number that may be cut off; start: first sample of the
   * first batch, so that the last batch ends with the record */
  size_t m = n / batch, last = m / 2, best = 0, start = n - m * batch;
  if (m < 4) return transient_none(x, n);

  /* This array is small: `last` is about the larger of FEWEST_BATCHES/2 and sqrt(n)/2. */
  double *square = memory_new(last + 1, sizeof *square);
  naive(x + start, batch, m, last, square);
  double whole = square[0], goal = enough * enough * whole;
  for (size_t d = 1; d <= last && square[best] > goal; d++)
    if (square[d] < square[best]) best = d;
  bool quiet = square[best] <= quiet_at * quiet_at * whole;
  free(square);
  transient found = {
      .length = start + best * batch, .inside = best < last || quiet, .quiet = quiet};
  if (quiet) {
    found.rest = error_bar_of(x + found.length, n - found.length);
    found.left = drift_of(x + found.length, n - found.length, found.rest.error);
    return found;
  }
  if (found.length > 0 && !stands_out(x, found.length, n)) found = (transient){.inside = true};
  cut_drift(x, n, &found);
  return found;
}

/* Test whether the error bar that ends a run is small enough (goal of `until`, see
 * slipdisk/measure.h).
 *
 * An error bar is itself a random number, and a run that ends when it is small ends, on average,
 * when it is too small. Every test adds to that bias, so there are few: one each time the record
 * has grown by 5 % (docs/physics.md 9). */

/* The length of the record grows by 1/LOOKS between two tests: 14 tests while it doubles. */
enum { LOOKS = 20 };

sd_goal sd_goal_of(const sd_model *model, const sd_state *state) {
  const sd_until *u = &model->until;
  sd_rotation r = sd_rotation_of(model, state, u->rotation);
  sd_goal g = {.value = u->scaled ? r.scaled : r.omega,
               .error = u->scaled ? r.scaled_error : r.error,
               .measured = r.measured,
               .converged = r.converged};
  g.goal = u->relative > 0.0 ? u->relative * fabs(g.value) : u->error;
  g.reached = g.converged && g.error <= g.goal; /* false if the error is NAN */
  return g;
}

int64_t sd_goal_look(const sd_model *model, int64_t step) {
  int64_t look = model->until.least, end = model->phases[model->n_phases - 1].steps;
  while (look <= step && look < end) {
    int64_t further = look / LOOKS + 1;
    look = further < end - look ? look + further : end;
  }
  return look;
}

/* --- torque, normal forces and visits in each sliding configuration of a watched pair --------- */

/* Returns the number of steps that a pair of contacts has spent in a sliding configuration (class).
 * count: number of steps in each of the 4 x 4 combined states of the two contacts. */
static int64_t steps_in(const int64_t *count, int class) {
  int64_t steps = 0;
  for (int first = 0; first < 4; first++)
    for (int second = 0; second < 4; second++)
      if (visits_class(first, second) == class) steps += count[4 * first + second];
  return steps;
}

/* mean_from returns the mean of n values from their sum, deviation_from their standard deviation
 * from the sum and the sum of squares; NAN for n = 0. */
static double mean_from(double sum, int64_t n) { return n > 0 ? sum / (double)n : NAN; }
static double deviation_from(double sum, double squares, int64_t n) {
  double mean = mean_from(sum, n);
  return n > 0 ? sqrt(math_max(0, squares / (double)n - mean * mean)) : NAN;
}

/* Fills the number of steps and the mean torque by age of the visit, i.e. by the time since the
 * pair entered configuration k. now: the pair is in this configuration at present, so that the
 * unfinished visit is added. */
static void add_ages(sd_configuration *c, const sd_state *s, size_t k, bool now) {
  const size_t watch = k / VISIT_CLASSES;
  const int64_t since = s->visit_since[watch], from = s->visit_from[watch];
  for (int b = 0; b < VISIT_AGES; b++) {
    const size_t at = VISIT_AGES * k + (size_t)b;
    const bool here = now && since >= 0 && visits_octave(from - since) == b;
    c->age_steps[b] = s->visit_age_steps[at] + (here ? s->measured - from : 0);
    c->age_torque[b] = mean_from(s->visit_age_torque[at] +
                                     (here ? s->visit_part[VISIT_SUMS * watch + VISIT_TORQUE] : 0),
                                 c->age_steps[b]);
  }
}

sd_configuration sd_configuration_of(const sd_model *model, const sd_state *s, size_t k) {
  const size_t watch = k / VISIT_CLASSES;
  sd_configuration c = {.disk = UINT32_MAX, .configuration = (int32_t)(k % VISIT_CLASSES)};
  const bool known = watch < s->n_visits;
  if (known) {
    c.disk = model->slides[watch].disk;
    c.steps = steps_in(s->slide_count + 16 * watch, c.configuration);
    c.visits = s->visit_count[k];
  }
  double sum[VISIT_SUMS] = {0};
  /* A watched pair of contacts is in no sliding configuration until measuring begins. */
  const bool now = known && s->measured > 0 && s->visit_class[watch] == c.configuration;
  for (size_t q = 0; known && q < VISIT_SUMS; q++)
    sum[q] = s->visit_sum[VISIT_SUMS * k + q] + (now ? s->visit_part[VISIT_SUMS * watch + q] : 0);
  c.torque = mean_from(sum[VISIT_TORQUE], c.steps);
  c.torque_sd = deviation_from(sum[VISIT_TORQUE], sum[VISIT_TORQUE2], c.steps);
  for (size_t side = 0; side < 2; side++) {
    c.force[side] = (known ? s->visit_reference[2 * watch + side] : 0) +
                    mean_from(sum[VISIT_FORCE + 2 * side], c.steps);
    c.force_sd[side] =
        deviation_from(sum[VISIT_FORCE + 2 * side], sum[VISIT_FORCE2 + 2 * side], c.steps);
  }
  c.dwell = known ? model->dt * mean_from((double)s->visit_steps[k], c.visits) : NAN;
  c.dwell_sd =
      known ? model->dt * deviation_from((double)s->visit_steps[k], s->visit_steps2[k], c.visits)
            : NAN;
  if (known) add_ages(&c, s, k, now);
  for (int b = 0; !known && b < VISIT_AGES; b++) c.age_torque[b] = NAN;
  return c;
}

#define ROW(field, type, unit, meaning, column, json)                                              \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_##type, 1, offsetof(sd_configuration, field), NULL, column,  \
        json, NULL                                                                                 \
  }
#define OF_EACH_CONTACT(field, unit, meaning)                                                      \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_F64, 2, offsetof(sd_configuration, field), NULL, #field,     \
        NULL, NULL                                                                                 \
  }
#define AGE(field, type, unit, meaning)                                                            \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_##type, SD_AGES, offsetof(sd_configuration, field), NULL,    \
        NULL, NULL, NULL                                                                           \
  }

static const observable rows[] = {
    ROW(disk, U32, "1", "body number", NULL, ""),
    ROW(configuration, I32, "1", "S++ 0, S+- 1, S-+ 2, S-- 3, stick 4, open 5", NULL, ""),
    ROW(steps, I64, "1", "measured steps in it", NULL, NULL),
    ROW(torque, F64, "force length", "mean torque of the two contacts on the disk", "torque", NULL),
    ROW(torque_sd, F64, "force length", "its standard deviation, over steps", "torque_sd", NULL),
    OF_EACH_CONTACT(force, "force", "mean normal force"),
    OF_EACH_CONTACT(force_sd, "force", "its standard deviation, over steps"),
    ROW(visits, I64, "1", "visits that began and ended while measured", "visits", NULL),
    ROW(dwell, F64, "time", "mean duration of these visits", "dwell", NULL),
    ROW(dwell_sd, F64, "time", "its standard deviation, over visits", "dwell_sd", NULL),
    AGE(age_torque, F64, "force length",
        "mean torque by age of the visit: below 32 steps, then octaves"),
    AGE(age_steps, I64, "1", "measured steps by age of the visit"),
};
const observable_list configuration_observables = OBSERVABLES(
    "configuration",
    "of each watched pair of contacts in each sliding configuration (`measure.configurations`), in "
    "/summary/configuration",
    rows);
