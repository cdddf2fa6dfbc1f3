/* math.c: functions of the C library whose last bits decide about the bits of a simulation, in
 * place of those of musl, which emscripten has.
 *
 * The native program is linked with glibc, whose sine and its like are rounded correctly but for
 * one argument in some hundreds. Here they are computed with 113 bits and rounded. hypot is the
 * algorithm that glibc has, too: C. F. Borges, ACM Trans. Math. Softw. 47, 9 (2020), corrected.
 */
#include <math.h>

double sin(double x) { return (double)sinl(x); }
double cos(double x) { return (double)cosl(x); }
double tan(double x) { return (double)tanl(x); }
double asin(double x) { return (double)asinl(x); }
double acos(double x) { return (double)acosl(x); }
double atan(double x) { return (double)atanl(x); }
double atan2(double y, double x) { return (double)atan2l(y, x); }

/* Beyond these bounds squares overflow or underflow. */
static const double LARGE = 0x1p+511, TINY = 0x1p-459, SCALE = 0x1p-600, EPSILON = 0x1p-54;

/* sqrt(a^2 + b^2) for a >= b > 0, with a correction of the rounding error. */
static double corrected(double a, double b) {
  double h = sqrt(a * a + b * b), first, second;
  if (h <= 2.0 * b) {
    const double rest = h - b;
    first = a * (2.0 * rest - a);
    second = (rest - 2.0 * (a - b)) * rest;
  } else {
    const double rest = h - a;
    first = 2.0 * rest * (a - 2.0 * b);
    second = (4.0 * rest - b) * b + rest * rest;
  }
  return h - (first + second) / (2.0 * h);
}

double hypot(double x, double y) {
  if (isinf(x) || isinf(y)) return INFINITY;
  if (isnan(x) || isnan(y)) return x + y;
  const double one = fabs(x), two = fabs(y), a = one < two ? two : one, b = one < two ? one : two;
  if (a > LARGE) return b <= a * EPSILON ? a + b : corrected(a * SCALE, b * SCALE) / SCALE;
  if (b < TINY) return a >= b / EPSILON ? a + b : corrected(a / SCALE, b / SCALE) * SCALE;
  return b <= a * EPSILON ? a + b : corrected(a, b);
}
