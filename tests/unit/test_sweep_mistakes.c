/* test_sweep_mistakes.c: what is said of mistakes in a deck's sweep, and of those that only some of its points make. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/text.h"
#include "run/sweep.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "sweep_decks.h"

/* libconfig 1.5 itself loses the string it was reading at a syntax error. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libconfig\n"; }

/* --- mistakes ---------------------------------------------------------------------------------------------- */

static void count_is(size_t n) {
  if (sd_messages_count(messages) != n) sd_messages_print(messages, stderr);
  assert_int_equal(sd_messages_count(messages), n);
}

static void expect_message(const char *words) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strstr(sd_messages_text(messages, k), words)) return;
  print_error("expected a message with: %s\nbut there are:\n", words);
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    print_error("  %s\n", sd_messages_text(messages, k));
  fail();
}

/* The mistake is told, by the sweep and by any other reading of the deck, once. */
static void bad(const char *grids, const char *words) {
  char text[4000];
  snprintf(text, sizeof text, HEAD "sweep = %s;\n" TAIL, grids);
  assert_int_equal(load(text, 0, NULL), SD_ERROR_USER);
  expect_message(words);
  count_is(1);
  sd_model *m = NULL;
  sd_messages_clear(messages);
  assert_int_equal(sd_deck_load(path, 0, NULL, &m, messages), SD_ERROR_USER);
  expect_message(words);
  count_is(1);
}

static void test_mistakes(void **state) {
  (void)state;
#define ONE(text) "{ parameters = ( { " text " } ); }"
  bad("3", "deck.cfg:2: sweep = 3: expected a group");
  bad("(1)", "deck.cfg:2: sweep[0] = 1: expected a group");
  bad("{ replicas = 0; }", "deck.cfg:2: sweep.replicas = 0: expected a whole number >= 1");
  bad("{ replicas = 1.5; }", "sweep.replicas = 1.5: expected a whole number");
  bad("{ replica = 2; }", "sweep.replica = 2: unknown key of sweep; did you mean \"replicas\"?");
  bad("{ parameters = { path = \"dt\"; values = (1); }; }",
      "sweep.parameters: expected a list of groups");
  bad("{ parameters = (\"dt\"); }", "sweep.parameters[0] = \"dt\": expected a group");
  bad(ONE("values = (1);"),
      "deck.cfg:2: sweep.parameters[0].path: missing: expected the key to set");
  bad(ONE("path = 3; values = (1);"), "sweep.parameters[0].path = 3: expected the path of a key");
  bad(ONE("path = \"\"; values = (1);"),
      "sweep.parameters[0].path = \"\": expected the path of a key");
  bad(ONE("path = (); values = (1);"), "sweep.parameters[0].path = (): expected the path of a key");
  bad(ONE("path = \"a=b\"; values = (1);"),
      "sweep.parameters[0].path = \"a=b\": expected the path of a key");
  bad(ONE("path = \"sweep\"; values = (1);"),
      "sweep.parameters[0].path = \"sweep\": a sweep cannot vary itself");
  bad(ONE("path = \"sweep.replicas\"; values = (1);"), "a sweep cannot vary itself");
  bad(ONE("path = \"dt\";"),
      "sweep.parameters[0].values: missing: expected values, linspace or logspace");
  bad(ONE("path = \"dt\"; values = (1); linspace = (1, 2, 3);"),
      "sweep.parameters[0].linspace = (1, 2, 3): given together with values; expected one of them");
  bad(ONE("path = \"dt\"; values = ();"),
      "sweep.parameters[0].values = (): expected a list of values");
  bad(ONE("path = \"dt\"; values = 3;"),
      "sweep.parameters[0].values = 3: expected a list of values");
  bad(ONE("path = \"dt\"; values = ({ a = 1; });"),
      "sweep.parameters[0].values[0]: expected a number, a text");
  bad(ONE("path = \"dt\"; values = ((1, { a = 1; }));"),
      "sweep.parameters[0].values[0] = (1, {...}): expected a number");
  bad(ONE("path = \"dt\"; linspace = (1, 2);"), "linspace = (1, 2): expected (first, last, count)");
  bad(ONE("path = \"dt\"; linspace = 1;"), "linspace = 1: expected (first, last, count)");
  bad(ONE("path = \"dt\"; linspace = (1, 2, 2.5);"),
      "linspace = (1, 2, 2.5): expected a whole number from 1 to");
  bad(ONE("path = \"dt\"; linspace = (1, 2, 0);"),
      "linspace = (1, 2, 0): expected a whole number from 1 to");
  bad(ONE("path = \"dt\"; linspace = (1, \"two\", 2);"),
      "linspace[1] = \"two\": expected a number; no constant is called");
  bad(ONE("path = \"dt\"; logspace = (0, 1, 3);"),
      "logspace = (0, 1, 3): expected two numbers of the same sign");
  bad(ONE("path = \"dt\"; logspace = (-1, 1, 3);"),
      "logspace = (-1, 1, 3): expected two numbers of the same sign");
  bad(ONE("path = \"dt\"; values = (1); nam = \"a\";"), "did you mean \"name\"?");
  bad(ONE("path = \"dt\"; values = (1); name = \"a b\";"),
      "sweep.parameters[0].name = \"a b\": expected letters");
  bad(ONE("path = \"dt\"; values = (1); name = \".\";"),
      "sweep.parameters[0].name = \".\": expected letters");
  bad(ONE("path = \"dt\"; values = (1); zip = 1;"),
      "sweep.parameters[0].zip = 1: expected a text in quotes");
  bad(ONE("path = \"seed\"; values = (1);"),
      "deck.cfg:2: sweep.parameters[0].name: missing: \"seed\" cannot "
      "be taken from the path (the tables of results have "
      "a column of this name); expected a name");
  bad(ONE("path = \"dt\"; name = \"status\"; values = (1);"),
      "sweep.parameters[0].name = \"status\": the tables of results have a column of this name; "
      "expected "
      "another");
  bad(ONE("path = \"dt\"; name = \"a.omega\"; values = (1);"), "have a column of this name");
  bad("{ parameters = ( { path = \"dt\"; name = \"a\"; values = (1); },\n{ path = \"skin\"; name = "
      "\"a\"; "
      "values = (1); } ); }",
      "deck.cfg:3: sweep.parameters[1].name = \"a\": another parameter has this name; expected "
      "another");
  bad("( { replicas = 2; }, { collect = (1); } )",
      "sweep[1].collect[0] = 1: expected the name of a column");
  bad("( { parameters = ( { path = \"dt\"; values = (1); },\n{ path = \"skin\"; name = \"dt\"; "
      "values = (1); "
      "} ); } )",
      "deck.cfg:2: sweep[0].parameters[0].name: missing: \"dt\" cannot be taken from the path "
      "(another");
  bad("{ parameters = ( { path = \"dt\"; values = (1, 2); zip = \"z\"; },\n{ path = \"skin\"; "
      "values = (1); "
      "zip = "
      "\"z\"; } ); }",
      "deck.cfg:3: sweep.parameters[1].zip = \"z\": 1 values here, and 2 in the parameter before "
      "it");
  bad("{ parameters = ( { path = \"dt\"; values = (1, 2); },\n{ path = [\"skin\", \"dt\"]; values "
      "= (1); } "
      "); }",
      "deck.cfg:3: sweep.parameters[1].path = (\"skin\", \"dt\"): dt is set by another parameter "
      "already");
  bad("( { replicas = 2; }, { parameters = ( { path = \"seed\"; name = \"n\"; values = (1); } "
      ");\nreplicas = "
      "2; } )",
      "deck.cfg:3: sweep[1].replicas = 2: a parameter sets the seed; expected either this or "
      "replicas");
  bad("{ parameters = ( { path = \"dt\"; linspace = (1, 2, 1001); }, { path = \"skin\"; linspace = "
      "(1, 2, "
      "1000); } ); }",
      "more than 1000000 points");
}

/* A key is a key however its path is written, and of either-or keys one counts. */
static void test_same_keys(void **state) {
  (void)state;
#define TWO(a, b)                                                                                  \
  "{ parameters = ( { path = " a "; name = \"one\"; values = (1, 2); },\n{ path = " b              \
  "; name = \"two\"; values = (3); } ); }"
  bad(TWO("\"dt\"", "\"dt \""), "dt  is set by another parameter already, as dt (");
  bad(TWO("\"motions[*].amplitude\"", "\"motions.q.amplitude\""),
      "deck.cfg:3: sweep.parameters[1].path = \"motions.q.amplitude\": motions.q.amplitude is set "
      "by another "
      "parameter already, as motions[*].amplitude (");
  expect_message("deck.cfg:2)");
  bad(TWO("\"motions.q.amplitude\"", "\"motions.[1].amplitude\""),
      "already, as motions.q.amplitude (");
  bad(TWO("\"motions[*].omega\"", "\"motions.[*].omega\""), "already, as motions[*].omega (");
  bad(TWO("\"disks.b.locked\"", "\"disks[1].locked[0]\""), "already, as disks.b.locked (");
  bad(TWO("\"box.x\"", "\"box.x[1]\""), "already, as box.x (");
  bad(TWO("\"motions.p.acceleration\"", "\"motions.p.amplitude\""),
      "deck.cfg:3: sweep.parameters[1].path = \"motions.p.amplitude\": motions.p.amplitude takes "
      "motions.p.acceleration away, which another parameter sets (");
  bad(TWO("\"motions[0].frequency\"", "\"motions[*].omega\""), "takes motions[0].frequency away");
  bad(TWO("\"steps\"", "\"time\""), "time takes steps away");
  bad(TWO("\"gravity.g\"", "[\"motions.p.omega\", \"skin\", \"motions[0].frequency\"]"),
      "motions[0].frequency takes motions.p.omega away, which this parameter sets (");
#undef TWO
  /* what only looks alike is apart */
  assert_int_equal(
      load(
          HEAD
          "sweep = ( { parameters = ( { path = \"motions[0].amplitude\"; values = (1); }, { path = "
          "\"motions[1].amplitude\"; values = (1); }, { path = \"motions.p.omega\"; values = (1); "
          "}, { "
          "path = [\"motions.q.frequency\", \"motions[1].frequency\"]; values = (1); }, { path = "
          "\"motions.r.amplitude\"; name = \"u\"; values = (1); }, { path = \"phases.a.steps\"; "
          "name = "
          "\"s\"; values = (1); } ); }, { parameters = ( { path = \"motions[*].acceleration\"; "
          "values = "
          "(1); }); } );\n" TAIL,
          0, NULL),
      SD_OK);
}

/* Mistakes of the sweep and of the rest are told together. */
static void test_all_at_once(void **state) {
  (void)state;
  assert_int_equal(
      load("dt = 1e-3; steps = 10;\nsede = 3;\nsweep = { replicas = -1; };\n" TAIL, 0, NULL),
      SD_ERROR_USER);
  expect_message("deck.cfg:2: sede = 3: unknown key; did you mean \"seed\"?");
  expect_message("deck.cfg:3: sweep.replicas = -1");
  count_is(2);
}

/* --- mistakes that only points make ---------------------------------------------------------------------------- */

/* What sweep_check says of a sweep. */
static size_t checked(const char *grids) {
  char text[4000];
  sweep s;
  size_t usable;
  snprintf(text, sizeof text, HEAD "sweep = %s;\n" TAIL, grids);
  sd_status status = load(text, 0, NULL);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  assert_int_equal(sweep_open(&s, path, 0, NULL, "nowhere", messages), SD_OK);
  status = sweep_check(&s, NULL, NULL, &usable, messages);
  assert_true((status == SD_OK) == (usable == s.deck.n_sets));
  sweep_close(&s);
  return usable;
}

static void test_points(void **state) {
  (void)state;
  assert_int_equal(
      checked("{ parameters = ( { path = \"gravity.g\"; values = (1, 2); } ); replicas = 2; }"), 2);
  /* a key that there is not: once, with the place of the first value */
  assert_int_equal(checked("{ parameters = ( { path = \"skin\"; values = (1, 2); },\n"
                           "{ path = \"gravity.tlt\"; values = (\n0, 1,\n2); } ); }"),
                   0);
  count_is(1);
  expect_message("deck.cfg:4: gravity.tlt = 0: unknown key of gravity; did you mean \"tilt\"?");
  /* one value of three, at its line, with the points that have it */
  assert_int_equal(
      checked("{ parameters = ( { path = \"skin\"; values = (1, 2); },\n"
              "{ path = \"max_overlap\"; values = (0.5,\n7,\n0.25); } ); replicas = 2; }"),
      4);
  count_is(1);
  expect_message("deck.cfg:4: max_overlap = 7: expected a number > 0 and <= 1 (point 2, "
                 "skin=1,max_overlap=7, and "
                 "others: 2 of 6 sets of values)");
  assert_int_equal(checked("{ parameters = ( { path = \"max_overlap\"; values = (0.5, 7); } ); }"),
                   1);
  expect_message(
      "deck.cfg:2: max_overlap = 7: expected a number > 0 and <= 1 (point 1, max_overlap=7)");
  /* paths that lead nowhere */
  assert_int_equal(
      checked("{ parameters = ( { path = \"motions.r.amplitude\"; values = (1, 2); } ); }"), 0);
  count_is(1);
  expect_message("deck.cfg:2: motions.r.amplitude = 1: motions has no entry named \"r\"; expected "
                 "\"p\" or \"q\"");
  assert_int_equal(
      checked("{ parameters = ( { path = \"motions[2].amplitude\"; linspace = (1, 2, 5); } ); }"),
      0);
  count_is(1);
  expect_message("deck.cfg:2: motions[2].amplitude = 1: motions has entries [0] to [1] only");
  assert_int_equal(checked("{ parameters = ( { path = \"dt[0]\"; values = (1); } ); }"), 0);
  expect_message("deck.cfg:2: dt[0] = 1: dt has no entries [ ]");
  assert_int_equal(checked("{ parameters = ( { path = \"dt[*]\"; values = (1); } ); }"), 0);
  expect_message("deck.cfg:2: dt[*] = 1: dt is no list");
  assert_int_equal(checked("{ parameters = ( { path = \"dt.x\"; values = (1); } ); }"), 0);
  expect_message("deck.cfg:2: dt.x = 1: dt is a value and has no keys");
  assert_int_equal(checked("{ parameters = ( { path = \"disks.grain.mass\"; values = (1); } ); }"),
                   0);
  expect_message(
      "disks.grain.mass = 1: disks has no entry named \"grain\"; expected \"a\" or \"b\"");
  /* a consequence elsewhere: the point is told */
  assert_int_equal(
      checked("{ parameters = ( { path = \"disks.a.radius\"; values = (1, 1.5, 3); } ); }"), 2);
  count_is(1);
  expect_message("overlap");
  expect_message("(point 2, radius=3)");
  /* a seed that is none */
  assert_int_equal(
      checked(
          "{ parameters = ( { path = \"seed\"; name = \"n\"; values = (1, 2.5, -1, \"x\"); } ); }"),
      1);
  expect_message("deck.cfg:2: seed = 2.5: expected a whole number");
}

/* Values that -D has put into the sweep are shown as such, and values of an included file with its name. */
static void test_places(void **state) {
  (void)state;
  sweep s;
  size_t usable;
  const char *const more[] = {"sweep.parameters[0].values=(7)"};
  assert_int_equal(
      load(HEAD "sweep = { parameters = ( { path = \"max_overlap\"; values = (1); } ); };\n" TAIL,
           0, NULL),
      SD_OK);
  assert_int_equal(sweep_open(&s, path, 1, more, "nowhere", messages), SD_OK);
  assert_int_equal(sweep_check(&s, NULL, NULL, &usable, messages), SD_ERROR_USER);
  expect_message("-D sweep.parameters[0].values=(7): max_overlap = 7: expected");
  sweep_close(&s);
  char *part = format_text("%s/part.cfg", folder);
  FILE *out = fopen(part, "w");
  assert_non_null(out);
  fputs("# points\nsweep = { parameters = ( { path = \"max_overlap\";\nvalues = (1, 7); } ); };\n",
        out);
  fclose(out);
  assert_int_equal(load(HEAD "@include \"part.cfg\"\n" TAIL, 0, NULL), SD_OK);
  assert_int_equal(sweep_open(&s, path, 0, NULL, "nowhere", messages), SD_OK);
  assert_int_equal(sweep_check(&s, NULL, NULL, &usable, messages), SD_ERROR_USER);
  expect_message("part.cfg:3: max_overlap = 7: expected");
  sweep_close(&s);
  remove(part);
  free(part);
}

/* Damaged sweeps are refused or read, without a crash or a leak; most telling with sanitizers. */
static void test_damaged(void **state) {
  (void)state;
  static const char whole[] =
      HEAD "sweep = ( { parameters = ( { path = \"gravity.tilt\"; name = \"tilt\"; "
           "values = (0, \"0.02 pi\", 1e-3); zip = \"z\"; },\n"
           "{ path = [\"skin\", \"disks[*].mass\"]; linspace = (1, 2, 3); zip = "
           "\"z\"; } ); replicas = 2; collect = \"work\"; },\n"
           "{ parameters = ( { path = \"seed\"; name = \"noise\"; values = (3, 4); "
           "}, { path = \"motions.p.type\"; values = "
           "(\"harmonic\", (1, \"a\"), true); }, { path = \"gravity.g\"; logspace = "
           "(1, \"9\", 2); } ); } );\n" TAIL;
  static const char *const pieces[] = {"(", ")",  "{", "}", "\"",    ";",    "=", ",",
                                       "0", "-1", "[", "]", "sweep", "1e99", "."};
  const size_t first = sizeof HEAD - 1, n = sizeof whole - sizeof TAIL - first;
  char text[sizeof whole];
  uint64_t bits = 88172645463325252u;
  size_t good = 0;
  for (int k = 0; k < 1000; k++) {
    memcpy(text, whole, sizeof whole);
    for (int damages = 1 + k % 3; damages > 0; damages--) {
      bits ^= bits << 13;
      bits ^= bits >> 7;
      bits ^= bits << 17;
      size_t at = first + bits % n;
      const char *piece = pieces[(bits >> 40) % (sizeof pieces / sizeof *pieces)];
      if (bits >> 63)
        memcpy(text + at, piece, strlen(piece));
      else if (bits >> 62)
        text[at] = whole[first + (bits >> 20) % n];
      else
        memmove(text + at, text + at + 1, strlen(text + at));
    }
    if (load(text, 0, NULL) != SD_OK || sweep_now.n_points > 2000) continue;
    good++;
    for (size_t p = 0; p < sweep_now.n_points; p++) {
      sd_model *m;
      sd_messages_clear(messages);
      sd_status status = deck_sweep_model(&sweep_now, p, &m, messages);
      assert_true((status == SD_OK) == (m != NULL));
      sd_model_free(m);
    }
  }
  /* some damages change what is said and not whether it can be read */
  assert_in_range(good, 50, 950);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mistakes),    cmocka_unit_test(test_same_keys),
      cmocka_unit_test(test_all_at_once), cmocka_unit_test(test_points),
      cmocka_unit_test(test_places),      cmocka_unit_test(test_damaged),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
