/* test_model_image.c: what a rank of a run gets of the model: all but disks whose rows of the state say everything. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "model/image.h"
#include "slipdisk/deck.h"

static const char *const deck =
    "dt = 1e-3; steps = 10; container = { type = \"box\"; width = 20; height = 20; };"
    "materials = ( { name = \"m\"; k_n = 100; k_t = 80; mu = 0.5; } );"
    "disks = ( { name = \"named\"; x = 0; y = 1; radius = 1; mass = 1; },"
    "{ x = 3; y = 1; radius = 0.8; mass = 1; force = (0, 0.3); },"
    "{ x = -3; y = 1; radius = 0.7; mass = 1; locked = (\"x\"); },"
    "{ x = 6; y = 1; radius = 2; mass = 1; fixed = true; } );"
    "packings = ( { type = \"square\"; y = (5, 20); radius = 0.5; mass = 1; count = 60; } );";
enum { SPECIAL = 4, DISKS = 64 };

static sd_model *received(const sd_model *m, size_t *size) {
  sd_model *rank = NULL;
  void *bytes = image_for_ranks(m, size);
  assert_non_null(bytes);
  assert_int_equal(image_read_for_rank(bytes, *size, &rank, NULL), SD_OK);
  assert_non_null(rank);
  free(bytes);
  return rank;
}

static void disks_come_where_they_are_special(void **unused) {
  (void)unused;
  static const sd_disk none;
  sd_model *m;
  size_t size;
  assert_int_equal(sd_deck_load_text(deck, "deck", 0, NULL, &m, NULL), SD_OK);
  assert_int_equal(m->n_disks, DISKS);
  sd_model *rank = received(m, &size);
  assert_true(rank->finished && rank->n_disks == m->n_disks && rank->n_free == m->n_free);
  for (size_t k = 0; k < SPECIAL; k++) {
    sd_disk there = m->disks[k], here = rank->disks[k];
    there.name = here.name = NULL;
    assert_memory_equal(&there, &here, sizeof here);
  }
  assert_string_equal(rank->disks[0].name, "named");
  for (size_t k = SPECIAL; k < DISKS; k++) assert_memory_equal(&rank->disks[k], &none, sizeof none);
  sd_model_free(rank);
  sd_model_free(m);
}

static void numbers_of_all_disks_come(void **unused) {
  (void)unused;
  sd_model *m;
  size_t size;
  assert_int_equal(sd_deck_load_text(deck, "deck", 0, NULL, &m, NULL), SD_OK);
  sd_model *rank = received(m, &size);
  double inverse = 0;
  for (size_t k = 0; k < DISKS; k++) inverse += 1 / m->disks[k].radius;
  assert_true(m->mean_radius == DISKS / inverse && m->largest_radius == 1);
  assert_true(rank->mean_radius == m->mean_radius && rank->largest_radius == m->largest_radius);
  assert_int_equal(rank->n_segments, m->n_segments);
  assert_memory_equal(rank->segments, m->segments, m->n_segments * sizeof *m->segments);
  sd_model_free(rank);
  sd_model_free(m);
}

static void a_damaged_one_is_refused(void **unused) {
  (void)unused;
  sd_model *m, *rank;
  size_t size;
  assert_int_equal(sd_deck_load_text(deck, "deck", 0, NULL, &m, NULL), SD_OK);
  unsigned char *bytes = image_for_ranks(m, &size);
  assert_non_null(bytes);
  for (size_t less = 1; less < size; less += 97)
    assert_int_not_equal(image_read_for_rank(bytes, size - less, &rank, NULL), SD_OK);
  free(bytes);
  sd_model_free(m);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(disks_come_where_they_are_special),
                                     cmocka_unit_test(numbers_of_all_disks_come),
                                     cmocka_unit_test(a_damaged_one_is_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
