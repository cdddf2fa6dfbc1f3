/* test_buckets.c: items sorted by bucket; empty buckets, items left out, no items; cells of points off the grid. */
#include "unit.h"
#include "base/buckets.h"

static size_t given(const void *with, size_t item) { return ((const size_t *)with)[item]; }

static void items_ascend_in_their_buckets(void **state) {
  const size_t bucket[] = {3, 1, SIZE_MAX, 3, 0, 4, 1, 3};
  const uint32_t start[] = {0, 1, 3, 3, 6}, item[] = {4, 1, 6, 0, 3, 7};
  buckets b;
  assert_true(buckets_new(&b, 8, 4, given, bucket));
  assert_memory_equal(b.start, start, sizeof start);
  assert_memory_equal(b.item, item, sizeof item);
  buckets_free(&b);
  assert_null(b.item);
}

static void no_items_or_no_buckets(void **state) {
  const size_t bucket[] = {0, 0};
  buckets b;
  assert_true(buckets_new(&b, 0, 2, given, bucket));
  assert_int_equal(b.start[2], 0);
  buckets_free(&b);
  assert_true(buckets_new(&b, 2, 0, given, bucket));
  assert_int_equal(b.start[0], 0);
  buckets_free(&b);
}

static void points_off_the_grid_count_to_its_nearest_cell(void **state) {
  const double x[] = {-HUGE_VAL, -0.5, 0.0, 0.99, 1.0, 2.5, 3.0, 1e300, NAN};
  const size_t cell[] = {0, 0, 0, 0, 1, 2, 2, 2, 0};
  for (size_t k = 0; k < sizeof cell / sizeof *cell; k++)
    assert_int_equal(cell_nearest(x[k], 3), cell[k]);
}

RUN_TESTS(TEST(items_ascend_in_their_buckets), TEST(no_items_or_no_buckets),
          TEST(points_off_the_grid_count_to_its_nearest_cell))
