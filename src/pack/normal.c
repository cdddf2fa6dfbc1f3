/* normal.c: the standard normal distribution by rational functions; see normal.h.
 *
 * Probabilities: W. J. Cody, Math. Comp. 23, 631 (1969). Their inverse: M. J. Wichura, algorithm AS
 * 241, Appl. Stat. 37, 477 (1988).
 */
#include "pack/normal.h"

#include <float.h>
#include <math.h>

#include "base/math.h"

/* Sums of powers of z, beginning with the highest. first: coefficient of the highest power; rest:
 * the others, n numbers. */
static double powers(double first, const double *rest, int n, double z) {
  for (int k = 0; k < n; k++) first = first * z + rest[k];
  return first;
}

/* Probability between 0 and x, |x| < 0.66291; negative for x < 0. */
static double central(double x) {
  static const double TOP[] = {2.2352520354606839287, 161.02823106855587881, 1067.6894854603709582,
                               18154.981253343561249},
                      BOTTOM[] = {47.20258190468824187, 976.09855173777669322,
                                  10260.932208618978205, 45507.789335026729956};
  const double z = x * x;
  return x * powers(0.065682337918207449113, TOP, 4, z) / powers(1.0, BOTTOM, 4, z);
}

/* exp(-x^2/2), with x^2 in two parts */
static double bell(double x) {
  const double coarse = floor(x * 16.0) / 16.0, rest = (x - coarse) * (x + coarse) * 0.5;
  return math_exp(-0.5 * coarse * coarse) * math_exp(-rest);
}

/* Probability beyond |x|, for 0.66291 <= |x| < sqrt(32). */
static double outer(double x) {
  static const double TOP[] = {0.39894151208813466764, 8.8831497943883759412, 93.506656132177855979,
                               597.27027639480026226,  2494.5375852903726711, 6848.1904505362823326,
                               11602.651437647350124,  9842.7148383839780218},
                      BOTTOM[] = {22.266688044328115691, 235.38790178262499861,
                                  1519.377599407554805,  6485.558298266760755,
                                  18615.571640885098091, 34900.952721145977266,
                                  38912.003286093271411, 19685.429676859990727};
  const double way = fabs(x);
  return bell(x) * (powers(1.0765576773720192317e-8, TOP, 8, way) / powers(1.0, BOTTOM, 8, way));
}

/* Probability beyond |x|, for |x| >= sqrt(32). */
static double far(double x) {
  static const double TOP[] = {0.21589853405795699, 0.1274011611602473639, 0.022235277870649807,
                               0.001421619193227893466, 2.9112874951168792e-5},
                      BOTTOM[] = {1.28426009614491121, 0.468238212480865118, 0.0659881378689285515,
                                  0.00378239633202758244, 7.29751555083966205e-5};
  const double z = 1.0 / (x * x);
  const double ratio = z * powers(0.02307344176494017303, TOP, 5, z) / powers(1.0, BOTTOM, 5, z);
  return bell(x) * ((M_2_SQRTPI * M_SQRT1_2 / 2.0 - ratio) / fabs(x));
}

/* Probability on the side of x beyond x, |x| >= 0.66291. */
static double beyond(double x) { return fabs(x) < 4.0 * M_SQRT2 ? outer(x) : far(x); }

double normal_below(double x) {
  if (fabs(x) < DBL_EPSILON / 2.0) return 0.5;
  if (fabs(x) < 0.66291) return 0.5 + central(x);
  if (x > 8.572 || x < -37.519) return x > 0.0 ? 1.0 : 0.0;
  return x > 0.0 ? 1.0 - beyond(x) : beyond(x);
}

double normal_above(double x) { return normal_below(-x); }

double normal_at(double p) {
  static const double TOP[3][7] = {
      {33430.575583588128105, 67265.770927008700853, 45921.953931549871457, 13731.693765509461125,
       1971.5909503065514427, 133.14166789178437745, 3.387132872796366608},
      {0.0227238449892691845833, 0.24178072517745061177, 1.27045825245236838258,
       3.64784832476320460504, 5.7694972214606914055, 4.6303378461565452959,
       1.42343711074968357734},
      {2.71155556874348757815e-5, 0.0012426609473880784386, 0.026532189526576123093,
       0.29656057182850489123, 1.7848265399172913358, 5.4637849111641143699,
       6.6579046435011037772}};
  static const double TOP_FIRST[3] = {2509.0809287301226727, 7.7454501427834140764e-4,
                                      2.01033439929228813265e-7};
  static const double BOTTOM[3][7] = {
      {28729.085735721942674, 39307.89580009271061, 21213.794301586595867, 5394.1960214247511077,
       687.1870074920579083, 42.313330701600911252, 1.0},
      {5.475938084995344946e-4, 0.0151986665636164571966, 0.14810397642748007459,
       0.68976733498510000455, 1.6763848301838038494, 2.05319162663775882187, 1.0},
      {1.4215117583164458887e-7, 1.8463183175100546818e-5, 7.868691311456132591e-4,
       0.0148753612908506148525, 0.13692988092273580531, 0.59983220655588793769, 1.0}};
  static const double BOTTOM_FIRST[3] = {5226.495278852854561, 1.05075007164441684324e-9,
                                         2.04426310338993978564e-15};
  const double q = p - 0.5;
  if (p == 1.0) return HUGE_VAL;
  if (p == 0.0) return -HUGE_VAL;
  int k = 0;
  double z = 0.180625 - q * q;
  if (fabs(q) > 0.425) {
    const double r = sqrt(-math_log(p < 0.5 ? p : 1.0 - p));
    k = r <= 5.0 ? 1 : 2;
    z = k == 1 ? r - 1.6 : r - 5.0;
  }
  const double ratio =
      powers(TOP_FIRST[k], TOP[k], 7, z) / powers(BOTTOM_FIRST[k], BOTTOM[k], 7, z);
  return k == 0 ? q * ratio : p < 0.5 ? -ratio : ratio;
}
