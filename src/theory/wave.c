/* wave.c: the supports' velocities for (20) and (21), and where Omega meets them.
 *
 * w = -amplitude cos(u + phase), or the triangle wave (22), -amplitude (4/pi)(1 - 2 |v|/pi) with
 * v = u + phase taken into [-pi, pi]. Both are odd about their zeros and turn at multiples of pi.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_roots.h>
#include <math.h>

#include "base/memory.h"
#include "theory/sliding.h"

double sliding_wave(const sliding_system *y, int i, double u) {
  double v = u + y->phase[i];
  if (y->waveform == SD_SINE) return -y->amplitude[i] * cos(v);
  return -y->amplitude[i] * (4 / M_PI) * (1 - 2 * fabs(remainder(v, 2 * M_PI)) / M_PI);
}

double sliding_slope(const sliding_system *y, int i, double u) {
  double v = u + y->phase[i];
  if (y->waveform == SD_SINE) return y->amplitude[i] * sin(v);
  /* at a corner the slope that follows counts, also when u has been rounded to just before it */
  double slope = y->amplitude[i] * 8 / (M_PI * M_PI), w = remainder(v + 1e-12, 2 * M_PI);
  return w >= 0 ? slope : -slope;
}

/* Integral of w: minus the angle itself. */
double sliding_turned(const sliding_system *y, int i, double u, double v) {
  double angle[2], at[2] = {u + y->phase[i], v + y->phase[i]};
  for (int k = 0; k < 2; k++) {
    double r = remainder(at[k], 2 * M_PI);
    angle[k] = y->waveform == SD_SINE ? sin(r) : 4 / M_PI * (r - r * fabs(r) / M_PI);
  }
  return -y->amplitude[i] * (angle[1] - angle[0]);
}

/* First u' > u with u' + phase = v modulo 2 pi. */
static double next_at(double v, double phase, double u) {
  double from = u + 1e-12, first = v - phase;
  return first + 2 * M_PI * ceil((from - first) / (2 * M_PI));
}

/* --- meetings while sliding ---------------------------------------------------------------------------- */

typedef struct gap {
  const sliding_system *y;
  int i;
  double u, omega, rate;
} gap;

static double gap_at(double u, void *argument) {
  const gap *g = argument;
  return sliding_wave(g->y, g->i, u) - (g->omega + g->rate * (u - g->u));
}

bool sliding_root(double (*of)(double, void *), void *with, double lower, double upper, double least,
                  double part, double *root) {
  gsl_function f = {of, with};
  bool found = false;
  *root = lower;
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
  if (!solver) memory_lacks(0);
  if (gsl_root_fsolver_set(solver, &f, lower, upper) == GSL_SUCCESS)
    for (int k = 0; k < 200 && !found; k++) {
      if (gsl_root_fsolver_iterate(solver) != GSL_SUCCESS) break;
      lower = gsl_root_fsolver_x_lower(solver);
      upper = gsl_root_fsolver_x_upper(solver);
      *root = gsl_root_fsolver_root(solver);
      found = upper - lower <= fmax(least, part * upper) || of(*root, with) == 0;
    }
  gsl_root_fsolver_free(solver);
  gsl_set_error_handler(handler);
  return found;
}

/* Root of the gap in [p, q], where it is monotone and changes sign. */
static double root_between(gap *g, double p, double q) {
  const double fp = gap_at(p, g), fq = gap_at(q, g), rounding = 4e-16;
  double root;
  if (g->y->waveform == SD_PARABOLA || fp == 0 || fq == 0)
    return fp == fq ? p : p + (q - p) * (fp / (fp - fq)); /* exact: the gap is straight */
  sliding_root(gap_at, g, p, q, rounding, rounding, &root);
  return root;
}

/* Phases in (u, end) between which the gap is monotone, in order. */
static int corners_of(const gap *g, double end, double corner[8]) {
  double amplitude = g->y->amplitude[g->i], turn[2] = {0, M_PI};
  int n = 0;
  if (g->y->waveform == SD_SINE) { /* amplitude sin(v) = rate */
    if (!(fabs(g->rate) < amplitude)) return 0;
    turn[0] = asin(g->rate / amplitude);
    turn[1] = M_PI - turn[0];
  }
  for (int k = 0; k < 2; k++)
    for (double at = next_at(turn[k], g->y->phase[g->i], g->u); at < end && n < 8; at += 2 * M_PI) {
      int place = n++;
      for (; place > 0 && corner[place - 1] > at; place--) corner[place] = corner[place - 1];
      corner[place] = at;
    }
  return n;
}

double sliding_meeting(const sliding_system *y, int i, double u, double omega, double rate, int s) {
  gap g = {y, i, u, omega, rate};
  double corner[8], from = u;
  int n = corners_of(&g, y->end, corner);
  for (int k = 0; k <= n; k++) {
    double to = k < n ? corner[k] : y->end;
    if (s * gap_at(to, &g) < 0) {
      /* a piece that starts at a meeting starts with a gap of rounding size and maybe of the wrong sign */
      if (s * gap_at(from, &g) <= 0) return from;
      return root_between(&g, from, to);
    }
    from = to;
  }
  return HUGE_VAL;
}

/* --- the end of sticking -------------------------------------------------------------------------------- */

/* First phase after u at which w_i and w_j are equal again. */
static double supports_meet(const sliding_system *y, int i, int j, double u) {
  if (y->waveform == SD_SINE) {
    /* w_j - w_i = |c| cos(u + arg c), c = a_i exp(i phase_i) - a_j exp(i phase_j) */
    double re = y->amplitude[i] * cos(y->phase[i]) - y->amplitude[j] * cos(y->phase[j]);
    double im = y->amplitude[i] * sin(y->phase[i]) - y->amplitude[j] * sin(y->phase[j]);
    double phase = atan2(im, re);
    return fmin(next_at(M_PI / 2, phase, u), next_at(-M_PI / 2, phase, u));
  }
  /* straight between the corners of either */
  double from = u + 1e-12, limit = u + 2 * M_PI;
  double before = sliding_wave(y, j, from) - sliding_wave(y, i, from);
  while (from < limit) {
    double to = limit;
    for (int k = 0; k < 4; k++) to = fmin(to, next_at(k & 1 ? M_PI : 0, y->phase[k >> 1], from));
    double after = sliding_wave(y, j, to) - sliding_wave(y, i, to);
    if (after == 0) return to;
    if (before * after < 0) return from + (to - from) * (before / (before - after));
    from = to;
    before = after;
  }
  return HUGE_VAL;
}

/* When the slope of w_i leaves [low, high]. */
static double outruns(const sliding_system *y, int i, double u, double low, double high, int *release) {
  double a = y->amplitude[i], plus = HUGE_VAL, minus = HUGE_VAL;
  if (y->waveform == SD_SINE) {
    if (fabs(high) < a) plus = next_at(asin(high / a), y->phase[i], u);
    if (fabs(low) < a) minus = next_at(M_PI - asin(low / a), y->phase[i], u);
  } else {
    double slope = 8 * a / (M_PI * M_PI);
    if (slope > high) plus = next_at(0, y->phase[i], u);
    if (-slope < low) minus = next_at(M_PI, y->phase[i], u);
  }
  *release = plus < minus ? 1 : -1;
  return fmin(plus, minus);
}

double sliding_stuck_until(const sliding_system *y, int i, double u, const int s[2], int *release,
                           int *which) {
  int j = 1 - i;
  bool both = y->n == 2;
  double high = both ? (i == 0 ? y->rate[0][s[1] < 0] : y->rate[s[0] < 0][0]) : y->rate[0][0];
  double low = both ? (i == 0 ? y->rate[1][s[1] < 0] : y->rate[s[0] < 0][1]) : y->rate[1][1];
  double next = outruns(y, i, u, low, high, release), meet = both ? supports_meet(y, i, j, u) : HUGE_VAL;
  *which = -1;
  if (meet < next) {
    next = meet;
    *release = 0;
    *which = j;
  }
  if (next >= y->end) {
    next = y->end;
    *release = 0;
    *which = -1;
  }
  return next;
}
