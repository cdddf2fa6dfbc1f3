/* test_ranks.c: runs over ranks that are threads of this process end with the bits of one
 * process: states, energies, messages, and the step of a failure. Ranks of an MPI job:
 * tests/program/test_ranks_*.py. */
#include "ranks_run.h"

#define HEAD                                                                                       \
  "integrator = \"verlet\"; dt = 1e-3;\n"                                                          \
  "materials = ( { name = \"grain\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"
#define PACKING                                                                                    \
  "packings = ( { type = \"square\"; jitter = 0.5; count = 120; x = (0, 12); y = (0, 12); "        \
  "density = 1.27;\n"                                                                              \
  "  group = \"grains\"; sizes = \"uniform\"; lower = 0.4; upper = 0.5; } );\n"

typedef struct deck_case {
  const char *name, *text;
} deck_case;

static void same_messages(const sd_messages *a, const sd_messages *b) {
  assert_int_equal(sd_messages_count(a), sd_messages_count(b));
  for (size_t k = 0; k < sd_messages_count(a); k++)
    assert_string_equal(sd_messages_text(a, k), sd_messages_text(b, k));
}

static void same_runs(const run *a, const run *b, const char *what) {
  same_messages(a->messages, b->messages);
  assert_int_equal(a->status, b->status);
  assert_non_null(a->end);
  assert_non_null(b->end);
  same_states(a->end, b->end, what);
  assert_memory_equal(&a->energy, &b->energy, sizeof a->energy);
}

/* So many disks that one process takes several steps at once, and that the rows of a rank's chunks
 * would be given in turn (physics/step/window.h). */
static void test_large_packings(void **unused) {
  static const char deck[] =
      HEAD "packings = ( { type = \"front\"; count = 44000; density = 1.27; sizes = \"uniform\"; "
           "lower = 0.4; upper = 0.5; } );\n"
           "gravity = { g = 10; }; container = { type = \"box\"; width = 1600; height = 40; };\n"
           "phases = ( { steps = 60; } );";
  run alone = {.deck = deck, .steps = 60, .threads = 1};
  run shared = alone;
  go(&alone, 1);
  go(&shared, 2);
  same_runs(&alone, &shared, "a large packing on two ranks");
  end(&alone);
  end(&shared);
}

/* Found by one rank, or by rank 0 alone: all stop, with the message and at the step of one
 * process. */
static void test_failures(void **unused) {
  static const deck_case decks[] = {
      {"too deep in a compression",
       HEAD PACKING "box = { x = (0, 12); y = (0, 12); periodic = \"xy\"; }; max_overlap = 0.03;\n"
                    "phases = ( { steps = 3000; compress = { fraction = 0.97; rate = 0.5; }; } );"},
      {"too deep in a step", HEAD PACKING
       "gravity = { g = 300; }; container = { type = \"box\"; width = 26; height = 20; };\n"
       "max_overlap = 0.05; phases = ( { steps = 3000; } );"},
      {"no room for rain",
       HEAD "gravity = { g = 1; }; container = { type = \"box\"; width = 12; height = 9; };\n"
            "walls = ( { name = \"roof\"; type = \"line\"; points = ((-6, 9), (6, 9)); } );\n"
            "packings = ( { type = \"rain\"; count = 120; sizes = \"uniform\"; lower = 0.4; "
            "upper = 0.5; density = 1; } );\n"
            "phases = ( { steps = 30000; } );"},
      {"out of bounds", HEAD PACKING
       "gravity = { g = 1; }; walls = ( { type = \"line\"; points = ((0, 0), (14, 0)); } );\n"
       "bounds = { x = (-1, 13); y = (-3, 30); outside = \"stop\"; };\n"
       "phases = ( { steps = 9000; } );"}};
  for (size_t d = 0; d < sizeof decks / sizeof *decks; d++)
    for (int size = 2; size <= 3; size++) {
      run alone = {.deck = decks[d].text, .steps = 100000, .threads = 1};
      run shared = {.deck = decks[d].text, .steps = 100000, .threads = 1};
      go(&alone, 1);
      go(&shared, size);
      print_message("  %s: %s\n", decks[d].name,
                    sd_messages_count(alone.messages) ? sd_messages_text(alone.messages, 0)
                                                      : "no message");
      assert_int_equal(alone.status, SD_ERROR_NUMERIC);
      assert_int_equal(shared.status, SD_ERROR_NUMERIC);
      same_messages(alone.messages, shared.messages);
      assert_non_null(shared.end);
      assert_int_equal(alone.end->step, shared.end->step);
      end(&alone);
      end(&shared);
    }
}

static void tell(const char *why) { fprintf(stderr, "a rank fails: %s\n", why); }

int main(void) {
  comm_on_fail(tell);
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_large_packings),
                                     cmocka_unit_test(test_failures)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
