/* test_sweep_deck.c: the group `sweep` of a deck: which points it asks for, their names and seeds; then its mistakes,
 * also those that only some points make. */
#include <unistd.h>

#include "base/text.h"
#include "model/model.h"
#include "model/state.h"
#include "run/sweep.h"
#include "slipdisk/deck.h"
#include "sweep_decks.h"

static const deck_sweep *good_deck(const char *text) {
  sd_status status = load(text, 0, NULL);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  /* names, numbers and sets belong together */
  for (size_t k = 0; k < sweep_now.n_points; k++) {
    assert_in_range(sweep_now.points[k].set, 0, sweep_now.n_sets - 1);
    for (size_t j = 0; j < k; j++)
      assert_string_not_equal(sweep_now.points[k].name, sweep_now.points[j].name);
  }
  return &sweep_now;
}

/* The points of `sweep = ...;`. */
static const deck_sweep *good(const char *grids) {
  char text[8000];
  assert_in_range(snprintf(text, sizeof text, HEAD "sweep = %s;\n" TAIL, grids), 1,
                  sizeof text - 1);
  return good_deck(text);
}

static const sweep_point *point(const char *name) {
  for (size_t k = 0; k < sweep_now.n_points; k++)
    if (strcmp(sweep_now.points[k].name, name) == 0) return &sweep_now.points[k];
  print_error("there is no point %s among\n", name);
  for (size_t k = 0; k < sweep_now.n_points; k++) print_error("  %s\n", sweep_now.points[k].name);
  fail();
  return NULL;
}

/* The names of all points, in order. */
static void names_are(const char *wanted) {
  char names[8000] = "";
  for (size_t k = 0; k < sweep_now.n_points; k++) {
    strcat(names, k ? " " : "");
    strcat(names, sweep_now.points[k].name);
  }
  assert_string_equal(names, wanted);
}

static sd_model *model_of(const char *name) {
  sd_model *m = NULL;
  sd_messages_clear(messages);
  sd_status status =
      deck_sweep_model(&sweep_now, (size_t)(point(name) - sweep_now.points), &m, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  assert_int_equal(sd_model_deck(m)->sweep_points, 0);
  return m;
}

static void test_crossed(void **state) {
  const deck_sweep *s =
      good("{ parameters = ( { path = \"gravity.tilt\"; values = (0, \"0.02 pi\", \"7.2 deg\"); },"
           " { path = \"motions[*].amplitude\"; name = \"eps\"; values = (1e-5, 0.5, 2.0); } ); }");
  names_are(
      "tilt=0,eps=1e-05 tilt=0,eps=0.5 tilt=0,eps=2 tilt=0.02pi,eps=1e-05 tilt=0.02pi,eps=0.5 "
      "tilt=0.02pi,eps=2 tilt=7.2deg,eps=1e-05 tilt=7.2deg,eps=0.5 tilt=7.2deg,eps=2");
  assert_int_equal(s->n_sets, 9);
  assert_int_equal(s->n_parameters, 2);
  assert_string_equal(s->parameters[1].path, "motions[*].amplitude");
  assert_false(s->parameters[0].text || s->parameters[1].text);
  const sweep_point *p = point("tilt=7.2deg,eps=0.5");
  assert_true(fabs(p->values[0] - 7.2 * M_PI / 180) < 1e-16 && p->values[1] == 0.5);
  assert_string_equal(p->texts[0], "7.2 deg");
  sd_model *m = model_of("tilt=7.2deg,eps=0.5");
  assert_true(fabs(m->gravity[0] + 10 * sin(7.2 * M_PI / 180)) < 1e-15);
  assert_true(m->motions[0].amplitude == 0.5 && m->motions[1].amplitude == 0.5);
  assert_int_equal(m->seed, p->seed);
  sd_model_free(m);
}

static void test_zipped(void **state) {
  good("{ parameters = ( { path = \"dt\"; values = (1e-3, 2e-3); zip = \"t\"; },"
       " { path = \"gravity.g\"; values = (1, 2); }, { path = \"steps\"; name = \"n\"; values = "
       "(20, 10); zip = \"t\"; } ); }");
  names_are("dt=0.001,g=1,n=20 dt=0.001,g=2,n=20 dt=0.002,g=1,n=10 dt=0.002,g=2,n=10");
  sd_model *m = model_of("dt=0.002,g=2,n=10");
  assert_true(m->dt == 2e-3 && m->phases[0].steps == 10 && m->gravity[1] == -2);
  sd_model_free(m);
}

static void test_ranges(void **state) {
  good("{ parameters = ( { path = \"gravity.g\"; linspace = (1, 2, 5); } ); }");
  names_are("g=1 g=1.25 g=1.5 g=1.75 g=2");
  good("{ parameters = ( { path = \"gravity.g\"; logspace = (1e-5, 1e-3, 5); } ); }");
  names_are("g=1e-05 g=3.16227766017e-05 g=0.0001 g=0.000316227766017 g=0.001");
  /* what the name says is what is set */
  sd_model *m = model_of("g=3.16227766017e-05");
  assert_true(m->gravity[1] == -3.16227766017e-05 &&
              point("g=3.16227766017e-05")->values[0] == 3.16227766017e-05);
  sd_model_free(m);
  good("{ parameters = ( { path = \"gravity.tilt\"; linspace = (0, \"0.1 pi\", 3); } ); }");
  names_are("tilt=0pi tilt=0.05pi tilt=0.1pi");
  assert_true(fabs(point("tilt=0.05pi")->values[0] - 0.05 * M_PI) < 1e-16);
  good("{ parameters = ( { path = \"gravity.tilt\"; linspace = (\"-9 deg\", \"9 deg\", 3); } ); }");
  names_are("tilt=-9deg tilt=0deg tilt=9deg");
  assert_true(fabs(point("tilt=9deg")->values[0] - M_PI / 20) < 1e-16);
  /* two units: radians */
  good("{ parameters = ( { path = \"gravity.tilt\"; linspace = (\"90 deg\", \"1 pi\", 2); } ); }");
  names_are("tilt=1.57079632679 tilt=3.14159265359");
  good("{ parameters = ( { path = \"gravity.tilt\"; logspace = (\"0.01 pi\", \"1 pi\", 3); } ); }");
  names_are("tilt=0.01pi tilt=0.1pi tilt=1pi");
  /* no rounding errors about 0, one value, downwards, negative */
  good("{ parameters = ( { path = \"gravity.tilt\"; linspace = (-0.2, 0.4, 7); } ); }");
  names_are("tilt=-0.2 tilt=-0.1 tilt=0 tilt=0.1 tilt=0.2 tilt=0.3 tilt=0.4");
  good("{ parameters = ( { path = \"gravity.tilt\"; linspace = (3, 7, 1); } ); }");
  names_are("tilt=3");
  good("{ parameters = ( { path = \"gravity.tilt\"; logspace = (-100, -1, 3); } ); }");
  names_are("tilt=-100 tilt=-10 tilt=-1");
  good("{ parameters = ( { path = \"gravity.g\"; logspace = (1e-90, 1e90, 2); } ); }");
  names_are("g=1e-90 g=1e+90");
}

static void test_paths(void **state) {
  const deck_sweep *s =
      good("{ parameters = ( { path = [\"disks.a.mass\", \"disks[1].mass\", \"motions.p.omega\"]; "
           "values = (3, \"5\"); } ); }");
  assert_string_equal(s->parameters[0].name, "mass");
  assert_string_equal(s->parameters[0].path, "disks.a.mass disks[1].mass motions.p.omega");
  sd_model *m = model_of("mass=3");
  assert_true(m->disks[0].mass == 3 && m->disks[1].mass == 3 && m->motions[0].omega == 3 &&
              m->motions[1].omega == 1);
  sd_model_free(m);
}

/* Points that two grids have are run once, whatever they are called in the second. */
static void test_union(void **state) {
  const deck_sweep *s = good(
      "( { parameters = ( { path = \"gravity.g\"; values = (1, 2); }, { path = \"gravity.tilt\"; "
      "values = (0, \"1 deg\"); } ); },"
      " { parameters = ( { path = \"gravity.tilt\"; values = (0.0, \"1deg\", 0.25); }, { path = "
      "\"gravity.g\"; linspace = (2, 3, 2); } ); replicas = 2; },"
      " { parameters = ( { path = \"skin\"; values = (0.5); } ); }, { } )");
  names_are(
      "g=1,tilt=0 g=1,tilt=1deg g=2,tilt=0 g=2,tilt=1deg "
      "g=2,tilt=0,r=1 g=3,tilt=0 g=3,tilt=0,r=1 g=2,tilt=1deg,r=1 g=3,tilt=1deg g=3,tilt=1deg,r=1 "
      "g=2,tilt=0.25 g=2,tilt=0.25,r=1 g=3,tilt=0.25 g=3,tilt=0.25,r=1 skin=0.5 base");
  assert_int_equal(s->n_sets, 10);
  assert_int_equal(point("g=2,tilt=0,r=1")->set, point("g=2,tilt=0")->set);
  assert_int_equal(point("g=2,tilt=0,r=1")->replica, 1);
  /* parameters that a grid does not have */
  const sweep_point *p = point("skin=0.5");
  assert_true(isnan(p->values[0]) && isnan(p->values[1]) && p->values[2] == 0.5);
  assert_string_equal(p->texts[0], "");
  assert_true(isnan(point("g=3,tilt=0.25")->values[2]));
  assert_true(isnan(point("base")->values[0]));
}

/* 10, 10.0 and 1e1 are the same, and so are their seeds. */
static void test_same_numbers(void **state) {
  static const char *const ways[] = {"values = (10)",          "values = (10.0)",
                                     "values = (1e1)",         "values = (1e+1)",
                                     "linspace = (10, 20, 1)", "logspace = (10.0, 1, 1)"};
  int64_t seed = 0;
  for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
    char text[200];
    snprintf(text, sizeof text, "{ parameters = ( { path = \"gravity.g\"; %s; } ); }", ways[k]);
    good(text);
    names_are("g=10");
    if (k == 0) seed = point("g=10")->seed;
    assert_int_equal(point("g=10")->seed, seed);
  }
  good("{ parameters = ( { path = \"steps\"; name = \"n\"; values = (2e6, 2000000, 5000000000, "
       "5e9, 0x10); } ); }");
  names_are("n=2000000 n=5000000000 n=16");
  sd_model *m = model_of("n=5000000000");
  assert_int_equal(m->phases[0].steps, 5000000000);
  sd_model_free(m);
}

static void test_texts(void **state) {
  const deck_sweep *s =
      good("{ parameters = ( { path = \"integrator\"; values = (\"gear5\", \"verlet\"); },"
           " { path = \"title\"; values = (\"a b\", \"ab\", \"a/b\", \"..\", \"say "
           "\\\"no\\\", or\\nnot\\\\\"); } ); }");
  assert_int_equal(s->n_points, 10);
  assert_true(s->parameters[0].text && s->parameters[1].text);
  assert_string_equal(s->points[1].name, "integrator=gear5,title=ab");
  assert_string_equal(s->points[3].name, "integrator=gear5,title=..");
  for (size_t k = 0; k < s->n_points; k++) {
    assert_null(strpbrk(s->points[k].name, "/ \"\n\\"));
    for (size_t j = 0; j < s->points[k].n_overrides; j++)
      assert_null(strchr(s->points[k].overrides[j], '\n'));
  }
  sd_model *m = model_of(s->points[4].name);
  assert_string_equal(m->title, "say \"no\", or\nnot\\");
  assert_int_equal(m->integrator, SD_GEAR5);
  sd_model_free(m);
  /* lists, truth, numbers beside texts */
  s = good(
      "{ parameters = ( { path = \"disks.b.locked\"; values = ((), (\"x\", \"y\")); }, { path = "
      "\"disks.b.fixed\"; values = (true, false); }, { path = \"disks.b.y\"; name = \"y\"; "
      "values = (1, 2); } ); }");
  assert_int_equal(s->n_points, 8);
  assert_string_equal(s->points[0].texts[1], "true");
  m = model_of(s->points[6].name);
  assert_true(m->disks[1].locked[SD_X] && m->disks[1].locked[SD_Y] &&
              !m->disks[1].locked[SD_THETA]);
  assert_true(m->disks[1].position[1] == 1);
  sd_model_free(m);
  s = good("{ parameters = ( { path = \"motions.p.phase\"; values = (0, \"1 pi\"); }, { path = "
           "\"title\"; values = (1, \"one\"); } ); }");
  assert_true(!s->parameters[0].text && s->parameters[1].text);
}

/* Names are no longer than those of files may be. */
static void test_long_names(void **state) {
  char text[4000] = "{ parameters = ( { path = \"title\"; values = (\"", *end = text + strlen(text);
  memset(end, 'x', 300);
  strcpy(end + 300, "y\", \"");
  end += strlen(end);
  memset(end, 'x', 300);
  strcpy(end + 300, "z\"); } ); replicas = 2; }");
  const deck_sweep *s = good(text);
  assert_int_equal(s->n_points, 4);
  for (size_t k = 0; k < 4; k++) assert_in_range(strlen(s->points[k].name), 100, 150);
  /* replicas differ in the ending only */
  assert_int_equal(strncmp(s->points[0].name, s->points[1].name, strlen(s->points[0].name)), 0);
}

static void test_without_sweep(void **state) {
  const deck_sweep *s = good_deck(HEAD TAIL);
  names_are("base");
  assert_int_equal(s->n_points, 1);
  assert_int_equal(s->points[0].n_overrides, 0);
  assert_int_equal(s->points[0].seed, 5);
  sd_model *m = model_of("base");
  assert_int_equal(m->seed, 5);
  sd_model_free(m);
  s = good("( )");
  assert_int_equal(s->n_points, 1);
  /* replicas of the deck itself */
  good("{ replicas = 3; }");
  names_are("base r=1 r=2");
  assert_int_equal(sweep_now.n_sets, 1);
}

static void test_names(void **state) {
  const deck_sweep *s =
      good("{ parameters = ( { path = \"motions.p.amplitude\"; values = (1); }, { path = "
           "\"motions.q.amplitude\"; values = (1); }, { path = \"motions[0].omega\"; values = "
           "(1); }, { path = \"phases[0].steps\"; values = (10); }, { path = \"gravity.tilt\"; "
           "name = \"q\"; values = (0); } ); }");
  static const char *const wanted[] = {"amplitude", "q.amplitude", "omega", "phases0.steps", "q"};
  for (size_t k = 0; k < 5; k++) assert_string_equal(s->parameters[k].name, wanted[k]);
}

static void test_seeds(void **state) {
  good("{ parameters = ( { path = \"gravity.g\"; values = (1, 2); }, { path = \"gravity.tilt\"; "
       "values = (0, 1); } ); }");
  int64_t seed = point("g=2,tilt=1")->seed;
  /* it is what the model gets, and whatever it is it is a positive number that a double holds */
  assert_in_range(seed, 1, INT64_C(1) << 53);
  for (size_t k = 0; k < 4; k++)
    for (size_t j = 0; j < k; j++)
      assert_int_not_equal(sweep_now.points[k].seed, sweep_now.points[j].seed);
  static const char *const grown[] = {
      /* more values, in another order; replicas; another grid, before and behind; names; zip */
      "{ parameters = ( { path = \"gravity.g\"; values = (3, 2, 1.5, 1); }, { path = "
      "\"gravity.tilt\"; values = (1, 0); } ); }",
      "{ parameters = ( { path = \"gravity.g\"; values = (1, 2); }, { path = \"gravity.tilt\"; "
      "values = (0, 1); } ); replicas = 7; }",
      "( { parameters = ( { path = \"skin\"; values = (1, 2); } ); }, { parameters = ( { path = "
      "\"gravity.g\"; values = "
      "(1, 2); }, { path = \"gravity.tilt\"; values = (0, 1); } ); }, { replicas = 2; } )",
      "{ parameters = ( { path = \"gravity.g\"; values = (1, 2); zip = \"a\"; }, { path = "
      "\"gravity.tilt\"; values = (0, 1); zip = \"a\"; } ); collect = \"work\"; }",
      "( { parameters = ( { path = \"seed\"; name = \"noise\"; values = (1, 2); } ); }, { "
      "parameters = ( { path = \"gravity.g\"; values = (1, 2); }, { path = \"gravity.tilt\"; "
      "values = (0, 1); } ); } )",
  };
  for (size_t k = 0; k < sizeof grown / sizeof *grown; k++) {
    good(grown[k]);
    assert_int_equal(point("g=2,tilt=1")->seed, seed);
  }
  /* all different, replicas too */
  good("{ parameters = ( { path = \"gravity.g\"; linspace = (1, 2, 50); } ); replicas = 20; }");
  assert_int_equal(sweep_now.n_points, 1000);
  assert_int_equal(sweep_now.n_sets, 50);
  for (size_t k = 0; k < 1000; k++)
    for (size_t j = 0; j < k; j++)
      assert_int_not_equal(sweep_now.points[k].seed, sweep_now.points[j].seed);
}

/* Another seed of the deck gives other seeds to the points, however it is written. */
static void test_base_seed(void **state) {
#define GRID "sweep = { parameters = ( { path = \"gravity.g\"; values = (1, 2); } ); };\n"
  good_deck(HEAD GRID TAIL);
  int64_t seed = point("g=2")->seed;
  const char *const same[] = {"seed=5.0"}, *const other[] = {"seed=6"};
  assert_int_equal(load(HEAD GRID TAIL, 1, same), SD_OK);
  assert_int_equal(point("g=2")->seed, seed);
  assert_int_equal(load(HEAD GRID TAIL, 1, other), SD_OK);
  assert_int_not_equal(point("g=2")->seed, seed);
  good_deck("dt = 1e-3; steps = 10; seed = 5.0;\n" GRID TAIL);
  assert_int_equal(point("g=2")->seed, seed);
  /* without a seed it is 1 */
  good_deck("dt = 1e-3; steps = 10;\n" GRID TAIL);
  seed = point("g=2")->seed;
  good_deck("dt = 1e-3; steps = 10; seed = 1;\n" GRID TAIL);
  assert_int_equal(point("g=2")->seed, seed);
}

static void test_swept_seed(void **state) {
  good("{ parameters = ( { path = \"seed\"; name = \"noise\"; values = (7, 8.0, "
       "9007199254740993); }, { path = \"gravity.g\"; values = (1, 2); } ); }");
  names_are("noise=7,g=1 noise=7,g=2 noise=8,g=1 noise=8,g=2 noise=9007199254740993,g=1 "
            "noise=9007199254740993,g=2");
  assert_int_equal(point("noise=8,g=2")->seed, 8);
  sd_model *m = model_of("noise=9007199254740993,g=1");
  assert_int_equal(m->seed, 9007199254740993);
  assert_int_equal(point("noise=9007199254740993,g=1")->seed, 9007199254740993);
  sd_model_free(m);
}

static void test_overrides(void **state) {
  const char *const more[] = {"sweep.parameters[0].values=(4, 5)", "sweep.replicas=2",
                              "gravity.tilt=0.5"};
  assert_int_equal(
      load(HEAD
           "sweep = { parameters = ( { path = \"gravity.g\"; linspace = (1, 2, 3); } ); };\n" TAIL,
           3, more),
      SD_OK);
  names_are("g=4 g=4,r=1 g=5 g=5,r=1");
  sd_model *m = model_of("g=5,r=1");
  assert_true(fabs(m->gravity[0] + 5 * sin(0.5)) < 1e-15);
  assert_non_null(strstr(sd_model_deck(m)->overrides,
                         "sweep.replicas=2\ngravity.tilt=0.5\ngravity.g=5\nseed="));
  sd_model_free(m);
  /* what is set twice is told */
  const char *const lost[] = {"gravity.g = 3"};
  assert_int_equal(load(HEAD "sweep = { parameters = ( { path = [\"skin\", \"gravity.g\"]; values "
                             "= (1, 2); } ); };\n" TAIL,
                        1, lost),
                   SD_OK);
  assert_int_equal(sd_messages_count(messages), 1);
  assert_string_equal(
      sd_messages_text(messages, 0),
      "-D gravity.g = 3: the sweep sets this key; it counts for points that do not set it");
  /* in other words, too */
#define SHAKEN                                                                                     \
  HEAD "sweep = { parameters = ( { path = \"motions.p.amplitude\"; name = \"eps\"; values = (1, "  \
       "2); }, { "                                                                                 \
       "path "                                                                                     \
       "= \"gravity.tilt\"; values = (0); } ); };\n" TAIL
  const char *const alike[] = {"motions[*].amplitude=3", "motions[0].acceleration=2",
                               "motions.q.amplitude=4"};
  assert_int_equal(load(SHAKEN, 3, alike), SD_OK);
  assert_int_equal(sd_messages_count(messages), 2);
  assert_string_equal(sd_messages_text(messages, 0),
                      "-D motions[*].amplitude=3: the sweep sets this key; it counts for points "
                      "that do not set it");
  assert_string_equal(sd_messages_text(messages, 1),
                      "-D motions[0].acceleration=2: the sweep sets a key that takes this one "
                      "away; it counts for points that do not set it");
  /* a parameter goes by its name in the table */
  const char *const named[] = {"sweep.parameters.eps.values=(3)",
                               "sweep.parameters.tilt.values=(1, 2)"};
  assert_int_equal(load(SHAKEN, 2, named), SD_OK);
  names_are("eps=3,tilt=1 eps=3,tilt=2");
  const char *const unnamed[] = {"sweep.parameters.tlt.values=(1)"};
  assert_int_equal(load(SHAKEN, 1, unnamed), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0),
                         "sweep.parameters has no entry named \"tlt\"; did you mean \"tilt\"?"));
#undef SHAKEN
  const char *const made[] = {"sweep.replicas=3"};
  assert_int_equal(load(HEAD TAIL, 1, made), SD_OK);
  names_are("base r=1 r=2");
}

/* Only what is run more than once counts: the model says how many points there are. */
static void test_count(void **state) {
  sd_model *m = NULL;
  sd_messages_clear(messages);
  assert_int_equal(
      sd_deck_load_text(
          HEAD "sweep = ( { parameters = ( { path = \"gravity.g\"; values = (1, 2); } ); }, { "
               "parameters = ( { path = \"gravity.g\"; values = (2, 3); } ); } );\n" TAIL,
          "test.cfg", 0, NULL, &m, messages),
      SD_OK);
  assert_int_equal(sd_model_deck(m)->sweep_points, 3);
  assert_true(m->gravity[1] == -10);
  /* the full deck is one run */
  assert_null(strstr(sd_model_deck(m)->full, "sweep"));
  sd_model_free(m);
  assert_int_equal(sd_deck_load_text(HEAD TAIL, "test.cfg", 0, NULL, &m, messages), SD_OK);
  assert_int_equal(sd_model_deck(m)->sweep_points, 0);
  sd_model_free(m);
}

/* libconfig 1.5 itself loses the string it was reading at a syntax error. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libconfig\n"; }

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
      "deck.cfg:2: sweep.parameters[0].name: missing: \"seed\" cannot be taken from the path "
      "(the tables of results have a column of this name); expected a name");
  bad(ONE("path = \"dt\"; name = \"status\"; values = (1);"),
      "sweep.parameters[0].name = \"status\": the tables of results have a column of this name; "
      "expected another");
  bad(ONE("path = \"dt\"; name = \"a.omega\"; values = (1);"), "have a column of this name");
  bad("{ parameters = ( { path = \"dt\"; name = \"a\"; values = (1); },\n"
      "{ path = \"skin\"; name = \"a\"; values = (1); } ); }",
      "deck.cfg:3: sweep.parameters[1].name = \"a\": another parameter has this name; expected "
      "another");
  bad("( { replicas = 2; }, { collect = (1); } )",
      "sweep[1].collect[0] = 1: expected the name of a column");
  bad("( { parameters = ( { path = \"dt\"; values = (1); },\n"
      "{ path = \"skin\"; name = \"dt\"; values = (1); } ); } )",
      "deck.cfg:2: sweep[0].parameters[0].name: missing: \"dt\" cannot be taken from the path "
      "(another");
  bad("{ parameters = ( { path = \"dt\"; values = (1, 2); zip = \"z\"; },\n"
      "{ path = \"skin\"; values = (1); zip = \"z\"; } ); }",
      "deck.cfg:3: sweep.parameters[1].zip = \"z\": 1 values here, and 2 in the parameter before "
      "it");
  bad("{ parameters = ( { path = \"dt\"; values = (1, 2); },\n"
      "{ path = [\"skin\", \"dt\"]; values = (1); } ); }",
      "deck.cfg:3: sweep.parameters[1].path = (\"skin\", \"dt\"): dt is set by another parameter "
      "already");
  bad("( { replicas = 2; }, { parameters = ( { path = \"seed\"; name = \"n\"; values = (1); } "
      ");\nreplicas = "
      "2; } )",
      "deck.cfg:3: sweep[1].replicas = 2: a parameter sets the seed; expected either this or "
      "replicas");
  bad("{ parameters = ( { path = \"dt\"; linspace = (1, 2, 1001); }, { path = \"skin\"; linspace "
      "= (1, 2, 1000); } ); }",
      "more than 1000000 points");
}

/* A key is a key however its path is written, and of either-or keys one counts. */
static void test_same_keys(void **state) {
#define TWO(a, b)                                                                                  \
  "{ parameters = ( { path = " a "; name = \"one\"; values = (1, 2); },\n{ path = " b              \
  "; name = \"two\"; values = (3); } ); }"
  bad(TWO("\"dt\"", "\"dt \""), "dt  is set by another parameter already, as dt (");
  bad(TWO("\"motions[*].amplitude\"", "\"motions.q.amplitude\""),
      "deck.cfg:3: sweep.parameters[1].path = \"motions.q.amplitude\": motions.q.amplitude is "
      "set by another parameter already, as motions[*].amplitude (");
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
      load(HEAD
           "sweep = ( { parameters = ( { path = \"motions[0].amplitude\"; values = (1); }, { path "
           "= \"motions[1].amplitude\"; values = (1); }, { path = \"motions.p.omega\"; values = "
           "(1); }, { path = [\"motions.q.frequency\", \"motions[1].frequency\"]; values = (1); "
           "}, { path = \"motions.r.amplitude\"; name = \"u\"; values = (1); }, { path = "
           "\"phases.a.steps\"; name = \"s\"; values = (1); } ); }, { parameters = ( { path = "
           "\"motions[*].acceleration\"; values = (1); }); } );\n" TAIL,
           0, NULL),
      SD_OK);
}

/* Mistakes of the sweep and of the rest are told together. */
static void test_all_at_once(void **state) {
  assert_int_equal(
      load("dt = 1e-3; steps = 10;\nsede = 3;\nsweep = { replicas = -1; };\n" TAIL, 0, NULL),
      SD_ERROR_USER);
  expect_message("deck.cfg:2: sede = 3: unknown key; did you mean \"seed\"?");
  expect_message("deck.cfg:3: sweep.replicas = -1");
  count_is(2);
}

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
                 "skin=1,max_overlap=7, and others: 2 of 6 sets of values)");
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
  static const char whole[] =
      HEAD "sweep = ( { parameters = ( { path = \"gravity.tilt\"; name = \"tilt\"; values = (0, "
           "\"0.02 pi\", 1e-3); zip = \"z\"; },\n"
           "{ path = [\"skin\", \"disks[*].mass\"]; linspace = (1, 2, 3); zip = \"z\"; } ); "
           "replicas = 2; collect = \"work\"; },\n"
           "{ parameters = ( { path = \"seed\"; name = \"noise\"; values = (3, 4); }, { path = "
           "\"motions.p.type\"; values = (\"harmonic\", (1, \"a\"), true); }, { path = "
           "\"gravity.g\"; logspace = (1, \"9\", 2); } ); } );\n" TAIL;
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

RUN_TESTS_BETWEEN(set_up, tear_down, TEST(test_crossed), TEST(test_zipped), TEST(test_ranges),
                  TEST(test_paths), TEST(test_union), TEST(test_same_numbers), TEST(test_texts),
                  TEST(test_long_names), TEST(test_without_sweep), TEST(test_names),
                  TEST(test_seeds), TEST(test_base_seed), TEST(test_swept_seed),
                  TEST(test_overrides), TEST(test_count), TEST(test_mistakes), TEST(test_same_keys),
                  TEST(test_all_at_once), TEST(test_points), TEST(test_places), TEST(test_damaged))
