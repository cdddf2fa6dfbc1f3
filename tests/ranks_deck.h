/* ranks_deck.h: a deck as the ranks of a run read it, for tests: what each has of it, beside what
 * one process has.
 *
 * Include after cmocka.h, scratch_file.h and packings_decks.h.
 */
#ifndef TESTS_RANKS_DECK_H
#define TESTS_RANKS_DECK_H

#include "unit.h"
#include "base/comm.h"
#include "io/deck/deck.h"
#include "io/results/provenance.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

enum { RANKS = 3 };

typedef struct reading {
  const char *text;
  size_t n_overrides;
  const char *const *overrides;
  int ranks;
  sd_status status[RANKS];
  sd_model *model[RANKS];
  sd_messages *messages[RANKS];
  sd_step_limit limit[RANKS];
  sd_messages *advised[RANKS];
} reading;

HELPER void read_one(const comm *c, void *with) {
  reading *r = with;
  const int q = comm_rank(c);
  r->messages[q] = sd_messages_new();
  r->advised[q] = sd_messages_new();
  r->status[q] = deck_load_for_ranks(c, r->text, path, r->n_overrides, r->overrides, NULL,
                                     &r->model[q], r->messages[q]);
  if (r->status[q] != SD_OK) return;
  r->limit[q] = sd_model_step_limit(r->model[q]);
  sd_model_advise(r->model[q], r->advised[q]);
  r->model[q]->comm = NULL;
}

HELPER bool says(const sd_messages *m, const char *text) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    if (strstr(sd_messages_text(m, k), text)) return true;
  return false;
}

HELPER bool any_says(const reading *r, const char *text) {
  for (int q = 0; q < r->ranks; q++)
    if (says(r->messages[q], text)) return true;
  return false;
}

HELPER void end_reading(reading *r) {
  for (int q = 0; q < r->ranks; q++) {
    sd_model_free(r->model[q]);
    sd_messages_free(r->messages[q]);
    sd_messages_free(r->advised[q]);
  }
}

/* The same deck in one process. */
HELPER sd_model *alone(const char *text) {
  sd_model *m;
  sd_messages_clear(messages);
  check(sd_deck_load_text(text, path, 0, NULL, &m, messages), messages);
  return m;
}

/* All ranks get the same status. */
HELPER reading read_deck(const char *text, int ranks, size_t n_overrides,
                         const char *const *overrides) {
  reading r = {.text = text, .ranks = ranks, .n_overrides = n_overrides, .overrides = overrides};
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
  sd_messages_clear(messages);
  comm_threads_run(ranks, read_one, &r);
  for (int q = 0; q < ranks; q++) {
    assert_int_equal(r.status[q], r.status[0]);
    assert_true((r.model[q] != NULL) == (r.status[q] == SD_OK));
  }
  return r;
}

/* Rows [0, held) are on all ranks; each of the others is with one rank, and is what one process
 * has. */
HELPER void check_rows(const reading *r, const sd_model *all, size_t held) {
  size_t *seen = calloc(all->n_disks, sizeof *seen);
  for (int q = 0; q < r->ranks; q++) {
    const sd_model *m = r->model[q];
    assert_true(m->tiles.away);
    assert_int_equal(model_held(m), held);
    assert_int_equal(m->n_disks, all->n_disks);
    assert_int_equal(m->n_free, all->n_free);
    for (size_t k = 0; k < m->mine->n; k++) {
      const uint32_t number = m->mine->number[k];
      assert_memory_equal(&m->mine->disk[k], &all->disks[number], sizeof(sd_disk));
      seen[number]++;
    }
  }
  for (size_t k = held; k < all->n_disks; k++) assert_int_equal(seen[k], 1);
  free(seen);
}

/* All ranks know the numbers of all disks that one process finds. */
HELPER void check_numbers(const reading *r, const sd_model *all) {
  const sd_step_limit limit = sd_model_step_limit(all);
  sd_messages *advised = sd_messages_new();
  sd_model_advise(all, advised);
  for (int q = 0; q < r->ranks; q++) {
    const sd_model *m = r->model[q];
    assert_true(m->largest_radius == all->largest_radius &&
                m->smallest_radius == all->smallest_radius);
    assert_true(fabs(m->mean_radius / all->mean_radius - 1) < 1e-12);
    assert_true(m->shortest_period == all->shortest_period);
    assert_true(r->limit[q].dt == limit.dt && r->limit[q].disk == limit.disk &&
                r->limit[q].bound == limit.bound);
    assert_string_equal(m->deck->full, all->deck->full);
    assert_memory_equal(&m->bounds, &all->bounds, sizeof m->bounds);
    assert_true(provenance_inputs(m) == provenance_inputs(all));
    assert_int_equal(sd_messages_count(r->advised[q]), sd_messages_count(advised));
    for (size_t k = 0; k < sd_messages_count(advised); k++)
      assert_string_equal(sd_messages_text(r->advised[q], k), sd_messages_text(advised, k));
    assert_int_equal(m->n_segments, all->n_segments);
    for (size_t k = 0; k < m->n_segments; k++)
      assert_int_equal(m->segments[k].body, all->segments[k].body);
  }
  sd_messages_free(advised);
}

#endif
