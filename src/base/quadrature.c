/* quadrature.c: integrals by the rule of Gauss and Legendre; see quadrature.h. */
#include "base/quadrature.h"

#include <math.h>

enum { HALF = QUADRATURE_POINTS / 2, DEPTH = 40 };

/* positive points on [-1, 1], and their weights */
static const double POINT[HALF] = {0.0950125098376374401853193, 0.2816035507792589132304605,
                                   0.4580167776572273863424194, 0.6178762444026437484466718,
                                   0.7554044083550030338951012, 0.8656312023878317438804679,
                                   0.9445750230732325760779884, 0.9894009349916499325961542};
static const double WEIGHT[HALF] = {0.1894506104550684962853967, 0.1826034150449235888667637,
                                    0.1691565193950025381893121, 0.1495959888165767320815017,
                                    0.1246289712555338720524763, 0.0951585116824927848099251,
                                    0.0622535239386478928628438, 0.0271524594117540948517806};

void quadrature_point(double from, double to, int k, double *at, double *weight) {
  const double half = (to - from) / 2.0, middle = (from + to) / 2.0;
  const int n = k < HALF ? HALF - 1 - k : k - HALF;
  *at = k < HALF ? middle - half * POINT[n] : middle + half * POINT[n];
  *weight = half * WEIGHT[n];
}

typedef struct integrand {
  double (*f)(double x, void *user);
  void *user;
  double tolerance; /* of each interval */
} integrand;

static double rule(const integrand *q, double from, double to) {
  double sum = 0.0;
  for (int k = 0; k < QUADRATURE_POINTS; k++) {
    double at, weight;
    quadrature_point(from, to, k, &at, &weight);
    sum += weight * q->f(at, q->user);
  }
  return sum;
}

static double bisect(const integrand *q, double from, double to, double whole, int depth) {
  const double middle = from + (to - from) / 2.0;
  const double left = rule(q, from, middle), right = rule(q, middle, to);
  if (depth == DEPTH || !(fabs(left + right - whole) > q->tolerance)) return left + right;
  return bisect(q, from, middle, left, depth + 1) + bisect(q, middle, to, right, depth + 1);
}

double quadrature(double (*f)(double x, void *user), void *user, double from, double to) {
  integrand q = {.f = f, .user = user};
  const double whole = rule(&q, from, to);
  q.tolerance = 1e-12 * fabs(whole);
  return bisect(&q, from, to, whole, 0);
}
