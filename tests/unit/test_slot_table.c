/* test_slot_table.c: slots by body number, where all bodies are here and in tables of a rank. */
#include "unit.h"
#include "model/state.h"

enum { WHOLE = 1 << 22 };

/* Entries beyond its own place at which a body stands, on the mean. */
static double mean_distance(const slot_table *t, const sd_state *s) {
  double sum = 0;
  for (size_t i = 0; i < s->n_bodies; i++) {
    uint32_t k = slot_table_home(t, s->id[i]);
    for (; t->body[k] != s->id[i]; k = (k + 1) & t->mask) sum++;
  }
  return sum / (double)s->n_bodies;
}

/* n rows of `width` numbers, `stride` apart; every other number between them is elsewhere. */
static void check_rows(uint32_t first, size_t rows, size_t width, size_t stride) {
  sd_state s = {.n_bodies = rows * width};
  slot_table t;
  s.id = malloc(s.n_bodies * sizeof *s.id);
  assert_non_null(s.id);
  for (size_t i = 0; i < s.n_bodies; i++)
    s.id[i] = (uint32_t)(first + i / width * stride + i % width);
  assert_true(slot_table_new(&t, &s, WHOLE));
  for (size_t i = 0; i < s.n_bodies; i++) assert_int_equal(slot_of(&t, s.id[i]), i);
  if (stride > width)
    for (size_t r = 0; r < rows; r++)
      assert_int_equal(slot_of(&t, (uint32_t)(first + r * stride + width)), SLOT_NONE);
  if (t.body) {
    const double distance = mean_distance(&t, &s);
    print_message("  %zu rows of %zu, %zu apart: %.2f entries\n", rows, width, stride, distance);
    assert_true(distance < 10);
  }
  for (size_t i = 0; i < s.n_bodies / 2; i++) { /* the same bodies in other slots */
    const uint32_t other = s.id[s.n_bodies - 1 - i];
    s.id[s.n_bodies - 1 - i] = s.id[i];
    s.id[i] = other;
  }
  slot_table_fill(&t, &s);
  for (size_t i = 0; i < s.n_bodies; i++) assert_int_equal(slot_of(&t, s.id[i]), i);
  slot_table_free(&t);
  free(s.id);
}

static void test_rows(void **unused) {
  static const struct {
    size_t rows, width, stride;
  } cases[] = {{1, 1, 1},          {1, 5000, 5000},      {512, 512, 2048}, {1000, 250, 1000},
               {1024, 1024, 4096}, {64, 64, 1024},       {3000, 100, 128}, {4000, 1, 64},
               {4000, 1, 1000},    {16, 65536, 1 << 18}, {1, WHOLE, WHOLE}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    check_rows(k % 2 && cases[k].width < WHOLE ? 37 : 0, cases[k].rows, cases[k].width,
               cases[k].stride);
}

RUN_TESTS(TEST(test_rows))
