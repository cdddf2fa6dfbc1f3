/* spline.c: cubic splines; see spline.h.
 *
 * Half the second derivatives c of a spline solve h_(k-1) c_(k-1) + 2 (h_(k-1) + h_k) c_k + h_k
 * c_(k+1) = g_k, with h_k = x_(k+1) - x_k and g_k three times the change of slope at point k. The
 * matrix L D L^T is symmetric (G. Engeln-Muellges & F. Uhlig, Numerical Algorithms with C, 1996).
 */
#include "physics/motion/spline.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

typedef struct rows {
  size_t n;      /* number of equations */
  double *main;  /* [n] main diagonal; then D */
  double *side;  /* [n] next to it; its last element is in the corner of a periodic matrix */
  double *right; /* [n] right-hand sides; then the solution */
  double *lower; /* [n] L below its diagonal */
  double *last;  /* [n] last row of L, of a periodic matrix */
} rows;

/* Equation k, of the point between two intervals, which begin at points `before` and `after`. */
static void fill(rows *m, const spline *s, size_t k, size_t before, size_t after) {
  const double h[2] = {s->x[before + 1] - s->x[before], s->x[after + 1] - s->x[after]};
  const double rise[2] = {s->y[before + 1] - s->y[before], s->y[after + 1] - s->y[after]};
  m->side[k] = h[1];
  m->main[k] = 2.0 * (h[1] + h[0]);
  m->right[k] = 3.0 * (rise[1] * (1.0 / h[1]) - rise[0] * (1.0 / h[0]));
}

static void solve(rows *m) {
  const size_t n = m->n;
  double *d = m->main, *z = m->right;
  for (size_t k = 0; k + 1 < n; k++) {
    m->lower[k] = m->side[k] / d[k];
    d[k + 1] -= m->side[k] * m->lower[k];
    z[k + 1] -= m->lower[k] * z[k];
  }
  for (size_t k = 0; k < n; k++) z[k] /= d[k];
  for (size_t k = n - 1; k-- > 0;) z[k] -= m->lower[k] * z[k + 1];
}

/* The same with side[n - 1] in the corners, n >= 3. */
static void solve_periodic(rows *m) {
  const size_t n = m->n;
  double *d = m->main, *z = m->right, square = 0.0, along = 0.0;
  m->last[0] = m->side[n - 1] / d[0];
  for (size_t k = 0; k + 2 < n; k++) {
    if (k > 0) {
      d[k] -= m->side[k - 1] * m->lower[k - 1];
      m->last[k] = -m->last[k - 1] * m->side[k - 1] / d[k];
      z[k] -= z[k - 1] * m->lower[k - 1];
    }
    m->lower[k] = m->side[k] / d[k];
    square += d[k] * m->last[k] * m->last[k];
    along += m->last[k] * z[k];
  }
  d[n - 2] -= m->side[n - 3] * m->lower[n - 3];
  m->lower[n - 2] = (m->side[n - 2] - m->side[n - 3] * m->last[n - 3]) / d[n - 2];
  z[n - 2] -= z[n - 3] * m->lower[n - 3];
  d[n - 1] = d[n - 1] - square - d[n - 2] * m->lower[n - 2] * m->lower[n - 2];
  z[n - 1] = z[n - 1] - along - m->lower[n - 2] * z[n - 2];
  for (size_t k = 0; k < n; k++) z[k] /= d[k];
  z[n - 2] -= m->lower[n - 2] * z[n - 1];
  for (size_t k = n - 2; k-- > 0;) z[k] = z[k] - m->lower[k] * z[k + 1] - m->last[k] * z[n - 1];
}

/* The periodic spline through three points, y[2] = y[0]. */
static void solve_two(spline *s) {
  const double *x = s->x, *y = s->y, h[2] = {x[1] - x[0], x[2] - x[1]};
  const double a = 2.0 * (h[0] + h[1]), b = h[0] + h[1], det = 3.0 * (h[0] + h[1]) * (h[0] + h[1]);
  const double g[2] = {3.0 * ((y[2] - y[1]) / h[1] - (y[1] - y[0]) / h[0]),
                       3.0 * ((y[1] - y[2]) / h[0] - (y[2] - y[1]) / h[1])};
  s->half_bend[1] = (a * g[0] - b * g[1]) / det;
  s->half_bend[0] = s->half_bend[2] = (-b * g[0] + a * g[1]) / det;
}

bool spline_new(spline *s, const double *x, const double *y, size_t n, bool periodic) {
  *s = (spline){.x = x, .y = y, .n = n, .half_bend = memory_new(n, sizeof *s->half_bend)};
  for (size_t k = 0; k + 1 < n; k++)
    if (!(x[k] < x[k + 1])) return false;
  rows m = {.n = periodic ? n - 1 : n - 2};
  double *memory = memory_new(5 * m.n, sizeof *memory);
  m.main = memory, m.side = memory + m.n, m.right = memory + 2 * m.n, m.lower = memory + 3 * m.n;
  m.last = memory + 4 * m.n;
  for (size_t k = 0; k < m.n; k++) fill(&m, s, k, k, k + 2 < n ? k + 1 : 0);
  if (!periodic)
    solve(&m);
  else if (m.n > 2)
    solve_periodic(&m);
  for (size_t k = 0; k < m.n; k++) s->half_bend[k + 1] = m.right[k];
  if (periodic) s->half_bend[0] = s->half_bend[n - 1];
  if (periodic && m.n == 2) solve_two(s);
  free(memory);
  for (size_t k = 0; k < n; k++)
    if (!isfinite(s->half_bend[k])) return false;
  return true;
}

void spline_free(spline *s) {
  free(s->half_bend);
  *s = (spline){0};
}

/* Coefficients of y + t (slope + t (bend + t cubic)), t from the left end of an interval. */
typedef struct cubic {
  double t, y, slope, bend, third;
} cubic;

static cubic find(spline *s, double at) {
  size_t low = 0, high = s->n - 1;
  if (s->x[s->last] <= at) low = s->last;
  if (at < s->x[s->last + 1]) high = s->last + 1;
  if (low >= high) low = 0;
  while (high > low + 1) {
    const size_t k = low + (high - low) / 2;
    if (s->x[k] > at)
      high = k;
    else
      low = k;
  }
  s->last = low;
  const double h = s->x[low + 1] - s->x[low], rise = s->y[low + 1] - s->y[low];
  const double c = s->half_bend[low], next = s->half_bend[low + 1];
  return (cubic){.t = at - s->x[low],
                 .y = s->y[low],
                 .slope = (rise / h) - h * (next + 2.0 * c) / 3.0,
                 .bend = c,
                 .third = (next - c) / (3.0 * h)};
}

double spline_value(spline *s, double x) {
  const cubic p = find(s, x);
  return p.y + p.t * (p.slope + p.t * (p.bend + p.t * p.third));
}

double spline_slope(spline *s, double x) {
  const cubic p = find(s, x);
  return p.slope + p.t * (2.0 * p.bend + 3.0 * p.third * p.t);
}
