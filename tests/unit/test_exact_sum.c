/* test_exact_sum.c: sums without rounding: hard cases, integers of 128 bits, any order, any division, all exponents. */
#include "unit.h"
#include "base/exact_sum.h"
#include "base/subnormal.h"

static double sum_of(const double *x, size_t n) {
  exact_sum s = {0};
  for (size_t k = 0; k < n; k++) exact_sum_add(&s, x[k]);
  return exact_sum_value(&s);
}

static void same(double found, double expected) {
  uint64_t f, e;
  memcpy(&f, &found, sizeof f);
  memcpy(&e, &expected, sizeof e);
  if (f != e) print_error("%a, expected %a\n", found, expected);
  assert_true(f == e || (isnan(found) && isnan(expected)));
}

static uint64_t stream = 1;
static uint64_t draw(void) {
  stream ^= stream << 13;
  stream ^= stream >> 7;
  return stream ^= stream << 17;
}

/* Of any finite number. */
static double any_number(void) {
  for (;;) {
    const uint64_t bits = draw();
    double x;
    memcpy(&x, &bits, sizeof x);
    if (isfinite(x)) return x;
  }
}

static void shuffle(double *x, size_t n) {
  for (size_t k = n; k > 1; k--) {
    const size_t j = draw() % k;
    const double y = x[k - 1];
    x[k - 1] = x[j];
    x[j] = y;
  }
}

static void hard_cases(void **unused) {
  const double least = 0x1p-1074, most = DBL_MAX, eps = DBL_EPSILON;
  const struct {
    double x[5], sum;
  } cases[] = {{{0}, 0},
               {{-0.0, -0.0}, 0},
               {{1e308, -1e308, 1e-308}, 1e-308},
               {{1e308, 1e308, -1e308, -1e308, least}, least},
               {{most, most, -most}, most},
               {{most, most}, HUGE_VAL},
               {{-most, -most}, -HUGE_VAL},
               {{most, 0x1p969}, most},         /* less than half of the last bit */
               {{most, 0x1p970}, HUGE_VAL},     /* half of it, and the last bit is 1 */
               {{most, 0x1p970, -least}, most}, /* and less than half of it */
               {{1, eps / 2}, 1},               /* ties to even */
               {{1 + eps, eps / 2}, 1 + 2 * eps},
               {{1, eps / 2, least}, 1 + eps},
               {{1, -eps / 4}, 1},
               {{1, -eps / 4, -least}, 1 - eps / 2},
               {{-1, -eps / 2, -least}, -1 - eps},
               {{2, -eps / 2, -least}, 2 - eps},
               {{least, least, least}, 3 * least},
               {{0x1p-1022, -least}, 0x1p-1022 - 0x1p-1074}, /* the largest subnormal */
               {{0x1p-1022 - 0x1p-1074, least}, 0x1p-1022},
               {{1, NAN}, NAN},
               {{1, HUGE_VAL}, HUGE_VAL},
               {{-HUGE_VAL, most, -HUGE_VAL}, -HUGE_VAL},
               {{HUGE_VAL, -HUGE_VAL}, NAN}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    same(sum_of(cases[k].x, 5), cases[k].sum);
}

static void one_number_is_itself(void **unused) {
  for (int k = 0; k < 100000; k++) {
    const double x = any_number();
    if (x != 0.0) same(sum_of(&x, 1), x);
  }
}

static void as_integers_of_128_bits(void **unused) {
  enum { MOST = 3000 };
  static double x[MOST];
  for (int round = 0; round < 300; round++) {
    __extension__ __int128 sum = 0;
    const size_t n = 1 + draw() % MOST;
    const int scale = (int)(draw() % 1900) - 1000;
    for (size_t k = 0; k < n; k++) {
      const int shift = (int)(draw() % 60);
      const int64_t size = (int64_t)draw() >> 11 >> (draw() % 53);
      sum += (__extension__(__int128) 1 << shift) * size;
      x[k] = ldexp((double)size, shift + scale);
    }
    /* the conversion rounds once, to nearest even */
    same(sum_of(x, n), ldexp((double)sum, scale));
  }
}

static void any_order_and_division(void **unused) {
  enum { N = 5000, PARTS = 7 };
  static double x[N];
  for (int round = 0; round < 40; round++) {
    for (size_t k = 0; k < N; k++) x[k] = round % 2 ? any_number() : ldexp(any_number(), -300);
    /* all but the first cancel, now and then */
    if (round % 4 > 1)
      for (size_t k = 1; k + 1 < N; k += 2) x[k + 1] = -x[k];
    const double whole = sum_of(x, N);
    if (round % 4 > 1) same(whole, sum_of((double[]){x[0], x[N - 1]}, 2));
    shuffle(x, N);
    same(sum_of(x, N), whole);
    exact_sum part[PARTS] = {0}, merged = {0}, added = {0};
    for (size_t k = 0; k < N; k++) exact_sum_add(&part[draw() % PARTS], x[k]);
    for (size_t p = 0; p < PARTS; p++) exact_sum_merge(&merged, &part[p]);
    same(exact_sum_value(&merged), whole);
    /* as ranks do */
    for (size_t p = 0; p < PARTS; p++) {
      exact_sum_carry(&part[p]);
      const int64_t *from = (const int64_t *)&part[p];
      for (size_t k = 0; k < sizeof added / sizeof *from; k++) ((int64_t *)&added)[k] += from[k];
    }
    same(exact_sum_value(&added), whole);
  }
}

static void carries_do_not_overflow(void **unused) {
  exact_sum s = {0};
  const int n = 1000000;
  for (int k = 0; k < n; k++) exact_sum_add(&s, 0x1.fffffffffffffp31);
  same(exact_sum_value(&s), 0x1.fffffffffffffp31 * n); /* the product rounds once */
  for (int k = 0; k < n; k++) exact_sum_add(&s, -0x1.fffffffffffffp31);
  same(exact_sum_value(&s), 0.0);
}

static void in_any_mode(void **unused) {
  const uint64_t mode = subnormal_off();
  exact_sum s = {0};
  for (int k = 0; k < 3; k++) exact_sum_add(&s, 0x1p-1074);
  const double found = exact_sum_value(&s);
  subnormal_restore(mode);
  same(found, 0x3p-1074);
}

RUN_TESTS(TEST(hard_cases), TEST(one_number_is_itself), TEST(as_integers_of_128_bits),
          TEST(any_order_and_division), TEST(carries_do_not_overflow), TEST(in_any_mode))
