/* math.c: elementary functions by numbers of twice the digits; see math.h. */
#include "base/math.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* --- numbers of twice the digits -------------------------------------------------------------- */

/* The number hi + lo, |lo| <= half a unit in the last place of hi (T. J. Dekker, Numer. Math. 18,
 * 224 (1971)). */
typedef struct twofold {
  double hi, lo;
} twofold;

static const twofold ONE = {1.0, 0.0};
static const twofold HALF_PI = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
static const twofold LN_2 = {0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
static const twofold PER_LN_10 = {0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};

/* a + b exactly, for |a| >= |b| or a = 0. */
static inline twofold sum_ordered(double a, double b) {
  const double hi = a + b;
  return (twofold){hi, b - (hi - a)};
}

/* a + b exactly. */
static inline twofold sum(double a, double b) {
  const double hi = a + b, of_b = hi - a;
  return (twofold){hi, (a - (hi - of_b)) + (b - of_b)};
}

/* Splits a into two halves of 26 binary digits. */
static inline twofold halves(double a) {
  const double c = 134217729.0 * a, hi = c - (c - a);
  return (twofold){hi, a - hi};
}

/* a b exactly. */
static inline twofold product(double a, double b) {
  const double hi = a * b;
  const twofold p = halves(a), q = halves(b);
  return (twofold){hi, ((p.hi * q.hi - hi) + p.hi * q.lo + p.lo * q.hi) + p.lo * q.lo};
}

static inline twofold add(twofold a, twofold b) {
  twofold s = sum(a.hi, b.hi);
  const twofold t = sum(a.lo, b.lo);
  s = sum_ordered(s.hi, s.lo + t.hi);
  return sum_ordered(s.hi, s.lo + t.lo);
}

static inline twofold negative(twofold a) { return (twofold){-a.hi, -a.lo}; }

static inline twofold multiply(twofold a, twofold b) {
  const twofold p = product(a.hi, b.hi);
  return sum_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline twofold divide(twofold a, twofold b) {
  const double q = a.hi / b.hi;
  const twofold rest = add(a, negative(multiply(b, (twofold){q, 0.0})));
  return sum_ordered(q, rest.hi / b.hi);
}

static inline twofold root(twofold a) {
  if (a.hi <= 0.0) return (twofold){0.0, 0.0};
  const double s = sqrt(a.hi);
  const twofold rest = add(a, negative(product(s, s)));
  return sum_ordered(s, rest.hi / (2.0 * s));
}

/* c[0] + z (c[1] + z (c[2] + ... + z tail)). */
static twofold series(const twofold *c, int n, twofold z, double tail) {
  twofold p = {tail, 0.0};
  for (int k = n - 1; k >= 0; k--) p = add(c[k], multiply(z, p));
  return p;
}

static double polynomial(const double *c, int n, double z) {
  double p = c[n - 1];
  for (int k = n - 2; k >= 0; k--) p = p * z + c[k];
  return p;
}

static double of_bits(uint64_t bits) {
  double a;
  memcpy(&a, &bits, sizeof a);
  return a;
}

static uint64_t bits_of(double a) {
  uint64_t bits;
  memcpy(&bits, &a, sizeof bits);
  return bits;
}

/* a 2^n for -2100 < n < 2100. */
static double scale(double a, int n) {
  for (; n > 1000; n -= 1000) a *= 0x1p1000;
  for (; n < -1000; n += 1000) a *= 0x1p-1000;
  return a * of_bits((uint64_t)(n + 1023) << 52);
}

/* m in [1, 2) and n with a = m 2^n, for finite a > 0. */
static double mantissa(double a, int *n) {
  const bool small = a < DBL_MIN;
  const uint64_t bits = bits_of(small ? a * 0x1p100 : a);
  *n = (int)(bits >> 52) - 1023 - (small ? 100 : 0);
  return of_bits((bits & 0xfffffffffffffu) | 0x3ff0000000000000u);
}

/* --- sine and cosine -------------------------------------------------------------------------- */

/* binary digits of 2/pi behind the point, after a word of zeros */
static const uint64_t TWO_OVER_PI[] = {
    0,
    0xa2f9836e4e441529,
    0xfc2757d1f534ddc0,
    0xdb6295993c439041,
    0xfe5163abdebbc561,
    0xb7246e3a424dd2e0,
    0x06492eea09d1921c,
    0xfe1deb1cb129a73e,
    0xe88235f52ebb4484,
    0xe99c7026b45f7e41,
    0x3991d639835339f4,
    0x9c845f8bbdf9283b,
    0x1ff897ffde05980f,
    0xef2f118b5a0a6d1f,
    0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d,
    0x7527bac7ebe5f17b,
    0x3d0739f78a5292ea,
    0x6bfb5fb11f8d5d08,
    0x56033046fc7b6bab,
    0xf0cfbc209af4361d,
    0xa9e391615ee61b08,
};

static uint64_t word_at(unsigned bit) {
  const unsigned k = bit / 64, by = bit % 64;
  return by ? TWO_OVER_PI[k] << by | TWO_OVER_PI[k + 1] >> (64 - by) : TWO_OVER_PI[k];
}

/* Returns x without the nearest multiple *q of pi/2, for finite x > pi/4; *q modulo 4. (M. H. Payne
 * & R. N. Hanek, SIGNUM Newsl. 18, 19 (1983)) */
static twofold reduce(double x, unsigned *q) {
  enum { WORDS = 4 };
  int n;
  const uint64_t m = bits_of(mantissa(x, &n)) << 12 >> 12 | 1ull << 52;
  /* x 2/pi modulo 4 is m times the digits from n - 54 on: of the product, 2 digits are before the
   * point. */
  uint64_t p[WORDS], carry = 0;
  for (int k = WORDS - 1; k >= 0; k--) {
    const uint64_t w = word_at((unsigned)(64 + n - 54 + 64 * k)), low = w & 0xffffffffu;
    /* m w + carry, in parts of 32 bits: m has 53 */
    const uint64_t m_low = m & 0xffffffffu, m_high = m >> 32, w_high = w >> 32;
    const uint64_t a = m_low * low, b = m_high * low + (a >> 32);
    const uint64_t c = m_low * w_high + (b & 0xffffffffu);
    const uint64_t product_low = c << 32 | (a & 0xffffffffu);
    p[k] = product_low + carry;
    carry = m_high * w_high + (b >> 32) + (c >> 32) + (p[k] < carry);
  }
  *q = (unsigned)(p[0] >> 62);
  for (int k = 0; k < WORDS; k++) p[k] = p[k] << 2 | (k + 1 < WORDS ? p[k + 1] >> 62 : 0);
  const bool minus = p[0] >> 63;
  if (minus) {
    ++*q;
    for (int k = 0; k < WORDS; k++) p[k] = ~p[k];
  }
  int zeros = 0;
  while (!(p[0] >> 63) && zeros < 128) { /* a double is not so near a multiple of pi/2 */
    for (int k = 0; k < WORDS; k++) p[k] = p[k] << 1 | (k + 1 < WORDS ? p[k + 1] >> 63 : 0);
    zeros++;
  }
  const double first = (double)(p[0] >> 11), second = (double)((p[0] & 0x7ff) << 42 | p[1] >> 22);
  const double unit = scale(minus ? -1.0 : 1.0, -53 - zeros);
  return multiply(sum_ordered(first * unit, second * unit * 0x1p-53), HALF_PI);
}

static twofold sine_of(twofold r) {
  static const twofold C[] = {{-0x1.5555555555555p-3, -0x1.5555555555555p-57},
                              {0x1.1111111111111p-7, 0x1.1111111111111p-63},
                              {-0x1.a01a01a01a01ap-13, -0x1.a01a01a01a01ap-73}};
  static const double TAIL[] = {1.0 / 362880.0,           -1.0 / 39916800.0,
                                1.0 / 6227020800.0,       -1.0 / 1307674368000.0,
                                1.0 / 355687428096000.0,  -1.0 / 121645100408832000.0,
                                1.0 / 51090942171709440e3};
  const twofold z = multiply(r, r);
  return add(r, multiply(multiply(r, z), series(C, 3, z, polynomial(TAIL, 7, z.hi))));
}

static twofold cosine_of(twofold r) {
  static const twofold C[] = {{1.0, 0.0},
                              {-0.5, 0.0},
                              {0x1.5555555555555p-5, 0x1.5555555555555p-59},
                              {-0x1.6c16c16c16c17p-10, 0x1.f49f49f49f49fp-65}};
  static const double TAIL[] = {1.0 / 40320.0,
                                -1.0 / 3628800.0,
                                1.0 / 479001600.0,
                                -1.0 / 87178291200.0,
                                1.0 / 20922789888000.0,
                                -1.0 / 6402373705728000.0,
                                1.0 / 2432902008176640000.0};
  const twofold z = multiply(r, r);
  return series(C, 4, z, polynomial(TAIL, 7, z.hi));
}

/* Sine and cosine of finite x. */
static void circle(double x, twofold *sine, twofold *cosine) {
  unsigned q = 0;
  const double way = fabs(x);
  const twofold r = way <= 0.785 ? (twofold){way, 0.0} : reduce(way, &q);
  const twofold s = sine_of(r), c = cosine_of(r);
  *sine = q % 2 ? c : s;
  *cosine = q % 2 ? s : c;
  if ((q % 4 >= 2) != (x < 0.0)) *sine = negative(*sine);
  if (q % 4 == 1 || q % 4 == 2) *cosine = negative(*cosine);
}

/* Below this f(x) = x + c x^3 + ... rounds to x. */
static const double TINY = 0x1p-28;

void math_sine_cosine(double x, double *sine, double *cosine) {
  if (!isfinite(x)) {
    *sine = *cosine = NAN;
    return;
  }
  twofold s, c;
  circle(x, &s, &c);
  *sine = fabs(x) < TINY ? x : s.hi;
  *cosine = c.hi;
}

double math_sin(double x) {
  double s, c;
  math_sine_cosine(x, &s, &c);
  return s;
}

double math_cos(double x) {
  double s, c;
  math_sine_cosine(x, &s, &c);
  return c;
}

double math_tan(double x) {
  if (!isfinite(x)) return NAN;
  if (fabs(x) < TINY) return x;
  twofold s, c;
  circle(x, &s, &c);
  return divide(s, c).hi;
}

/* --- inverse functions ------------------------------------------------------------------------ */

/* arc tangents of k/8 */
static const twofold ARC_TANGENT[] = {
    {0.0, 0.0},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};

/* Arc tangent of y/x for 0 <= y <= x: that of k/8 nearby, and the series of the rest. */
static twofold arc_tangent(twofold y, twofold x) {
  static const twofold C[] = {{1.0, 0.0},
                              {-0x1.5555555555555p-2, -0x1.5555555555555p-56},
                              {0x1.999999999999ap-3, -0x1.999999999999ap-57}};
  static const double TAIL[] = {-1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0};
  const double near = floor(8.0 * (y.hi / x.hi) + 0.5);
  const twofold k = {near, 0.0}, eight = {8.0, 0.0};
  const twofold u = divide(add(multiply(eight, y), negative(multiply(k, x))),
                           add(multiply(eight, x), multiply(k, y)));
  const twofold z = multiply(u, u);
  return add(ARC_TANGENT[(int)near], multiply(u, series(C, 3, z, polynomial(TAIL, 5, z.hi))));
}

/* Arc tangent of y/x for 0 < y <= x to 60 binary digits or more, enough to round most of them. */
static twofold arc_tangent_fast(double y, double x) {
  static const double SERIES[] = {-1.0 / 3.0,  1.0 / 5.0,  -1.0 / 7.0, 1.0 / 9.0,
                                  -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0};
  const double k = floor(8.0 * (y / x) + 0.5);
  const twofold kx = product(k, x), ky = product(k, y);
  const double above = 8.0 * y - kx.hi;
  const twofold below = sum_ordered(8.0 * x, ky.hi);
  const double u = above / (below.hi + below.lo), z = u * u;
  const twofold exact = product(u, below.hi);
  const double rest = (above - exact.hi) - exact.lo - kx.lo - u * (below.lo + ky.lo);
  const double more = u * z * polynomial(SERIES, 7, z);
  const twofold a = sum_ordered(ARC_TANGENT[(int)k].hi, u);
  return sum_ordered(a.hi, a.lo + (ARC_TANGENT[(int)k].lo + (rest / below.hi + more)));
}

/* The angle of a direction from that to the nearer axis; steep: to the y axis; left: x < 0. */
static twofold in_half_plane(twofold angle, bool steep, bool left) {
  if (steep) angle = add(HALF_PI, negative(angle));
  if (left) angle = add((twofold){2.0 * HALF_PI.hi, 2.0 * HALF_PI.lo}, negative(angle));
  return angle;
}

/* Angle of the direction (x, y), y >= 0, x and y not both 0, both at most about 2. */
static double angle_of(twofold y, twofold x) {
  const bool left = x.hi<0.0, steep = y.hi> fabs(x.hi);
  if (left) x = negative(x);
  const twofold a = steep ? x : y, b = steep ? y : x;
  if (y.lo == 0.0 && x.lo == 0.0 && a.hi > TINY) {
    const twofold angle = in_half_plane(arc_tangent_fast(a.hi, b.hi), steep, left);
    const double error = angle.hi * 0x1p-58;
    if (angle.hi + (angle.lo - error) == angle.hi + (angle.lo + error)) return angle.hi;
  }
  return in_half_plane(arc_tangent(a, b), steep, left).hi;
}

double math_atan2(double y, double x) {
  if (isnan(x) || isnan(y)) return NAN;
  double a = fabs(x), b = fabs(y), angle;
  if (isinf(a) || isinf(b)) a = isinf(a) ? 1.0 : 0.0, b = isinf(b) ? 1.0 : 0.0;
  if (b == 0.0) {
    angle = signbit(x) ? 2.0 * HALF_PI.hi : 0.0;
  } else if (a == 0.0) {
    angle = HALF_PI.hi;
  } else if (x > 0.0 && b < a * TINY) {
    angle = b / a;
  } else {
    int n;
    mantissa(a > b ? a : b, &n);
    angle = angle_of((twofold){scale(b, -n), 0.0}, (twofold){scale(x < 0.0 ? -a : a, -n), 0.0});
  }
  return signbit(y) ? -angle : angle;
}

double math_atan(double x) { return fabs(x) < TINY ? x : math_atan2(x, 1.0); }

/* The other side of a right triangle with hypotenuse 1. */
static twofold other_side(double x) { return root(multiply(sum(1.0, -x), sum(1.0, x))); }

double math_asin(double x) {
  if (!(fabs(x) <= 1.0)) return NAN;
  if (fabs(x) < TINY) return x;
  const double angle = angle_of((twofold){fabs(x), 0.0}, other_side(x));
  return x < 0.0 ? -angle : angle;
}

double math_acos(double x) {
  if (!(fabs(x) <= 1.0)) return NAN;
  return x == 1.0 ? 0.0 : angle_of(other_side(x), (twofold){x, 0.0});
}

/* --- exponential and logarithm ---------------------------------------------------------------- */

/* exp(r) - 1 for |r| < 0.35: exp(r/8) - 1 by a series, squared three times. */
static twofold grow(twofold r) {
  static const twofold C[] = {{1.0, 0.0},
                              {0.5, 0.0},
                              {0x1.5555555555555p-3, 0x1.5555555555555p-57},
                              {0x1.5555555555555p-5, 0x1.5555555555555p-59}};
  static const double TAIL[] = {1.0 / 120.0,    1.0 / 720.0,     1.0 / 5040.0,    1.0 / 40320.0,
                                1.0 / 362880.0, 1.0 / 3628800.0, 1.0 / 39916800.0};
  const twofold t = {r.hi * 0.125, r.lo * 0.125};
  twofold p = multiply(t, series(C, 4, t, polynomial(TAIL, 7, t.hi)));
  for (int k = 0; k < 3; k++) p = add((twofold){2.0 * p.hi, 2.0 * p.lo}, multiply(p, p));
  return p;
}

/* exp(x) = result 2^n for |x| < 800. */
static twofold exponential(twofold x, int *n) {
  const double count = floor(x.hi * 1.44269504088896340736 + 0.5);
  *n = (int)count;
  /* ln 2 = LONG + REST; LONG has 42 binary digits, so count LONG is exact */
  static const double LONG = 0x1.62e42fefa3800p-1;
  static const twofold REST = {0x1.ef35793c76730p-45, 0x1.f97b57a079a19p-103};
  const twofold left = add(sum(x.hi, -count * LONG), (twofold){x.lo, 0.0});
  return add(ONE, grow(add(left, negative(multiply(REST, (twofold){count, 0.0})))));
}

/* exp(x) for finite x */
static double raise(twofold x) {
  if (x.hi > 710.0) return HUGE_VAL;
  if (x.hi < -746.0) return 0.0;
  int n;
  const twofold e = exponential(x, &n);
  return scale(e.hi, n);
}

double math_exp(double x) {
  if (isnan(x)) return x;
  if (isinf(x)) return x > 0.0 ? x : 0.0;
  return raise((twofold){x, 0.0});
}

double math_expm1(double x) {
  if (isnan(x) || fabs(x) < 0x1p-54) return x;
  if (x > 700.0) return math_exp(x);
  if (x < -50.0) return -1.0;
  if (fabs(x) < 0.34) return grow((twofold){x, 0.0}).hi;
  int n;
  const twofold e = exponential((twofold){x, 0.0}, &n);
  return add((twofold){scale(e.hi, n), scale(e.lo, n)}, (twofold){-1.0, 0.0}).hi;
}

/* log(1 + d) for 1 + d between sqrt(1/2) and sqrt(2): 2 artanh(d/(2 + d)). */
static twofold log_near(twofold d) {
  static const twofold C[] = {{1.0, 0.0},
                              {0x1.5555555555555p-2, 0x1.5555555555555p-56},
                              {0x1.999999999999ap-3, -0x1.999999999999ap-57},
                              {0x1.2492492492492p-3, 0x1.2492492492492p-57}};
  static const double TAIL[] = {1.0 / 9.0,  1.0 / 11.0, 1.0 / 13.0, 1.0 / 15.0,
                                1.0 / 17.0, 1.0 / 19.0, 1.0 / 21.0, 1.0 / 23.0,
                                1.0 / 25.0, 1.0 / 27.0, 1.0 / 29.0, 1.0 / 31.0};
  const twofold s = divide(d, add((twofold){2.0, 0.0}, d)), z = multiply(s, s);
  const twofold half = multiply(s, series(C, 4, z, polynomial(TAIL, 12, z.hi)));
  return (twofold){2.0 * half.hi, 2.0 * half.lo};
}

/* log(x) for finite x > 0; lo: a small addition to x, for x >= DBL_MIN */
static twofold logarithm(double x, double lo) {
  int n;
  double m = mantissa(x, &n);
  if (m > M_SQRT2) m *= 0.5, n++;
  const twofold d = add((twofold){m - 1.0, 0.0}, (twofold){lo == 0.0 ? 0.0 : scale(lo, -n), 0.0});
  const twofold near = log_near(d);
  return n == 0 ? near : add(multiply(LN_2, (twofold){n, 0.0}), near);
}

double math_log(double x) {
  if (x == 0.0) return -HUGE_VAL;
  if (!(x > 0.0)) return NAN;
  return isinf(x) ? x : logarithm(x, 0.0).hi;
}

double math_log1p(double x) {
  if (x == -1.0) return -HUGE_VAL;
  if (!(x > -1.0)) return NAN;
  if (isinf(x) || fabs(x) < 0x1p-54) return x;
  if (fabs(x) < 0.25) return log_near((twofold){x, 0.0}).hi;
  const twofold one_more = sum(1.0, x);
  return logarithm(one_more.hi, one_more.lo).hi;
}

double math_log10(double x) {
  if (!(x > 0.0) || isinf(x)) return math_log(x);
  return multiply(logarithm(x, 0.0), PER_LN_10).hi;
}

/* x^y for x > 0 and finite y. */
static double power(double x, double y) {
  if (isinf(x)) return y > 0.0 ? x : 0.0;
  if (x == 1.0) return 1.0;
  const twofold l = logarithm(x, 0.0);
  const double size = l.hi * y;
  if (fabs(size) > 800.0) return size > 0.0 ? HUGE_VAL : 0.0;
  return raise(multiply(l, (twofold){y, 0.0}));
}

double math_pow(double x, double y) {
  if (y == 0.0 || x == 1.0) return 1.0;
  if (isnan(x) || isnan(y)) return NAN;
  const double a = fabs(x);
  if (isinf(y)) return a == 1.0 ? 1.0 : (a > 1.0) == (y > 0.0) ? HUGE_VAL : 0.0;
  const bool whole = floor(y) == y, odd = whole && fabs(y) < 0x1p53 && fmod(y, 2.0) != 0.0;
  if (x < 0.0 && !whole && !isinf(x)) return NAN;
  const double size = a == 0.0 ? (y > 0.0 ? 0.0 : HUGE_VAL) : power(a, y);
  return signbit(x) && odd ? -size : size;
}

/* --- hypot ------------------------------------------------------------------------------------ */

/* sqrt(a^2 + b^2) for a >= b > 0, with a correction of the rounding error (C. F. Borges, ACM Trans.
 * Math. Softw. 47, 9 (2020)). */
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

double math_hypot(double x, double y) {
  /* Beyond these bounds squares overflow or underflow. */
  static const double LARGE = 0x1p+511, SMALL = 0x1p-459, SCALE = 0x1p-600, EPSILON = 0x1p-54;
  if (isinf(x) || isinf(y)) return HUGE_VAL;
  if (isnan(x) || isnan(y)) return NAN;
  const double one = fabs(x), two = fabs(y), a = one < two ? two : one, b = one < two ? one : two;
  if (a > LARGE) return b <= a * EPSILON ? a + b : corrected(a * SCALE, b * SCALE) / SCALE;
  if (b < SMALL) return a >= b / EPSILON ? a + b : corrected(a / SCALE, b / SCALE) * SCALE;
  return b <= a * EPSILON ? a + b : corrected(a, b);
}
