/* Rows of numbers against vectors (base/lane.h), for every width, whatever this machine's is. */

#define LANE_WIDTH 1
#include "unit.h"
#include "base/lane.h"
#undef LANE_WIDTH
#define LANE_WIDTH 2
#include "base/lane.h"
#undef LANE_WIDTH
#define LANE_WIDTH 4
#include "base/lane.h"
#undef LANE_WIDTH
#define LANE_WIDTH 8
#include "base/lane.h"

enum { MOST = 8, ROW = 12, ROWS = 40 };

/* Where row k of a test begins: in no order, at any double. */
static int32_t place(int k, int seed) { return ROW * ((k * 7 + seed * 3) % ROWS) + seed % 5; }

/* Of both signs, zeros of both signs among them. */
static void fill(double *memory, size_t n) {
  for (size_t k = 0; k < n; k++)
    memory[k] = k % 7 == 0 ? -0.0 : k % 11 == 0 ? 0.0 : (k % 3 ? 1.0 : -1.0) * (1.0 + (double)k);
}

#define TEST_OF(width)                                                                             \
  static void rows_w##width(void **unused) {                                                       \
    (void)unused;                                                                                  \
    for (int seed = 0; seed < 50; seed++) {                                                        \
      double memory[ROW * ROWS + 16], expected[ROW * ROWS + 16];                                   \
      int32_t at[MOST], other[MOST];                                                               \
      real_w##width c[4], between[4], two[2];                                                      \
      fill(memory, sizeof memory / sizeof *memory);                                                \
      for (int l = 0; l < width; l++) at[l] = place(l, seed), other[l] = place(l + width, seed);   \
      gather4_w##width(memory, at, c);                                                             \
      across4_w##width(memory, at, other, between);                                                \
      across2_w##width(memory + 1, at, other, two);                                                \
      double column[4][MOST], way[4][MOST], half[2][MOST];                                         \
      for (int k = 0; k < 4; k++) store_w##width(column[k], c[k]);                                 \
      for (int k = 0; k < 4; k++) store_w##width(way[k], between[k]);                              \
      for (int k = 0; k < 2; k++) store_w##width(half[k], two[k]);                                 \
      for (int l = 0; l < width; l++) {                                                            \
        for (int k = 0; k < 4; k++) assert_true(column[k][l] == memory[at[l] + k]);                \
        for (int k = 0; k < 4; k++) {                                                              \
          const double a = memory[at[l] + k], b = memory[other[l] + k];                            \
          assert_true(as_bits_w1(way[k][l]) == as_bits_w1(k % 2 ? b + a : b - a));                 \
        }                                                                                          \
        for (int k = 0; k < 2; k++)                                                                \
          assert_true(as_bits_w1(half[k][l]) ==                                                    \
                      as_bits_w1(memory[other[l] + 1 + k] - memory[at[l] + 1 + k]));               \
      }                                                                                            \
      /* rows that several lanes add to */                                                         \
      if (seed % 2) other[0] = at[width - 1], at[0] = at[width / 2];                               \
      memcpy(expected, memory, sizeof memory);                                                     \
      add4_w##width(memory, at, other, c);                                                         \
      for (int l = 0; l < width; l++) {                                                            \
        for (int k = 0; k < 4; k++) expected[at[l] + k] += column[k][l];                           \
        for (int k = 0; k < 4; k++)                                                                \
          expected[other[l] + k] += k % 2 ? column[k][l] : -column[k][l];                          \
      }                                                                                            \
      assert_memory_equal(memory, expected, sizeof memory);                                        \
      memset(memory, 0, sizeof memory);                                                            \
      memset(expected, 0, sizeof expected);                                                        \
      scatter4_w##width(memory + 3, 6, c);                                                         \
      for (int l = 0; l < width; l++)                                                              \
        for (int k = 0; k < 4; k++) expected[3 + 6 * l + k] = column[k][l];                        \
      assert_memory_equal(memory, expected, sizeof memory);                                        \
      real_w##width back[4];                                                                       \
      load4_w##width(memory + 3, 6, back);                                                         \
      for (int k = 0; k < 4; k++) {                                                                \
        store_w##width(half[0], back[k]);                                                          \
        assert_memory_equal(half[0], column[k], width * sizeof(double));                           \
      }                                                                                            \
    }                                                                                              \
  }
TEST_OF(1)
TEST_OF(2)
TEST_OF(4)
TEST_OF(8)

RUN_TESTS(TEST(rows_w1), TEST(rows_w2), TEST(rows_w4), TEST(rows_w8))
