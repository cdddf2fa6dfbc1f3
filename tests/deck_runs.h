/* deck_runs.h: what the tests of whole runs share: decks as text, simulations, copies of states.
 */
#ifndef TESTS_DECK_RUNS_H
#define TESTS_DECK_RUNS_H

#include "unit.h"
#include "physics/system/work.h"
#include "run/simulation_private.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

/* Text that grows. */
typedef struct text {
  char *s;
  size_t n, room;
} text;

HELPER SD_PRINTF(2, 3) void text_add(text *t, const char *format, ...) {
  for (;;) {
    va_list args;
    va_start(args, format);
    int n = vsnprintf(t->s ? t->s + t->n : NULL, t->room - t->n, format, args);
    va_end(args);
    assert_true(n >= 0);
    if (t->s && (size_t)n < t->room - t->n) {
      t->n += (size_t)n;
      return;
    }
    t->room = 2 * (t->room + (size_t)n + 64);
    t->s = realloc(t->s, t->room);
    assert_non_null(t->s);
  }
}

HELPER void between(double value, double low, double high, const char *what) {
  if (value >= low && value <= high) return;
  print_error("%s: %.10g, expected %.10g to %.10g\n", what, value, low, high);
  fail();
}

HELPER sd_model *model_of(const char *deck) {
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  sd_deck_load_text(deck, "test.cfg", 0, NULL, &model, messages);
  if (!model) sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_non_null(model);
  return model;
}

/* Frees the text. */
HELPER sd_model *model_of_text(text *t) {
  sd_model *model = model_of(t->s);
  free(t->s);
  *t = (text){0};
  return model;
}

/* What is asked to have several threads takes the general step, also where the model is small enough for the other. */
HELPER simulation_step step_for(int threads) {
  return threads > 1 ? SIMULATION_GENERAL : SIMULATION_SUITABLE;
}

HELPER sd_simulation *begin_run(const sd_model *model, int threads) {
  sd_simulation *sim = NULL;
  sd_messages *messages = sd_messages_new();
  simulation_new(model, threads, step_for(threads), NULL, NULL, &sim, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_non_null(sim);
  return sim;
}

HELPER void advance(sd_simulation *sim, int64_t n) {
  sd_messages *messages = sd_messages_new();
  sd_status status = sd_simulation_advance(sim, n, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_int_equal(status, SD_OK);
}

HELPER void end_run(sd_simulation *sim, sd_model *model) {
  sd_simulation_free(sim);
  sd_model_free(model);
}

/* A fresh state with the same columns. */
HELPER sd_state *copy_of(const sd_model *model, const sd_state *from) {
  sd_state *to = sd_state_new(model);
  assert_non_null(to);
  assert_int_equal(state_size_like(to, from), SD_OK);
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    size_t bytes = sd_extent_size(from, f->extent) * sd_type_size(f->type);
    if (bytes) memcpy(sd_field_data(to, f), sd_field_data(from, f), bytes);
  }
  return to;
}

/* Frees the run and goes on with another one from a copy of its state. */
HELPER sd_simulation *go_on_from_copy(sd_simulation *sim, int threads) {
  const sd_model *model = sd_simulation_model(sim);
  sd_state *state = copy_of(model, sd_simulation_state(sim));
  sd_simulation_free(sim);
  sd_simulation *next = NULL;
  assert_int_equal(
      simulation_resume(model, state, NULL, threads, step_for(threads), NULL, NULL, &next, NULL),
      SD_OK);
  return next;
}

/* All columns have the same bits. */
HELPER void same_states(const sd_state *a, const sd_state *b, const char *what) {
  const sd_field *f = sd_state_difference(a, b);
  if (!f) return;
  print_error("%s: column %s differs at step %lld/%lld\n", what, f->name, (long long)a->step,
              (long long)b->step);
  fail();
}

/* The private side of a simulation. */
HELPER engine *engine_of(sd_simulation *sim) { return simulation_engine(sim); }

/* Bits of a splitmix64 sequence: the tests' own random numbers. */
HELPER uint64_t next_bits(uint64_t *seed) {
  uint64_t z = *seed += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
HELPER double next_uniform(uint64_t *seed) { return (double)(next_bits(seed) >> 11) * 0x1p-53; }

/* Rows "(x, y, radius)" of n disks on a slightly disordered square lattice of the given spacing. */
HELPER void add_lattice(text *t, int n, int wide, double x, double y, double spacing, double radius,
                        uint64_t seed) {
  for (int k = 0; k < n; k++)
    text_add(t, "%s(%.6f, %.6f, %.6f)", k ? ", " : "",
             x + spacing * (k % wide) + 0.06 * radius * (next_uniform(&seed) - 0.5),
             y + spacing * (k / wide) + 0.06 * radius * (next_uniform(&seed) - 0.5),
             radius * (0.8 + 0.3 * next_uniform(&seed)));
}

#endif
