/* test_expressions.c: arithmetic and named constants in decks: values to the bit, the echo, -D, sweeps, mistakes, and
 * texts that were made to break the reader. */
#include "unit.h"
#include "io/deck/deck.h"
#include "brief.h"
#include "model/model.h"
#include "slipdisk/deck.h"

#define REST                                                                                       \
  "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );\n"                          \
  "disks = ( { name = \"a\"; x = 0; y = 0; theta = 0; radius = 1; mass = 2; } );\n"

static sd_messages *messages;

static sd_model *load(const char *text, size_t n, const char *const *overrides) {
  sd_model *m = NULL;
  sd_messages_free(messages);
  messages = sd_messages_new();
  sd_status status = sd_deck_load_text(text, "test.cfg", n, overrides, &m, messages);
  assert_true((status == SD_OK) == (m != NULL));
  assert_true((status == SD_OK) == (sd_messages_errors(messages) == 0));
  return m;
}

/* The deck above, with path=value and perhaps more text. */
static sd_model *with(const char *more, const char *setting) {
  char text[2048];
  snprintf(text, sizeof text, "%s%s", REST, more);
  return load(text, 1, &setting);
}

static const char constants[] = "constants = { R = 0.02; long_name2 = \"R / 10\"; g = 9.81; A = "
                                "\"0.7 * g\"; a = \"30 deg\"; };";

static void expect_setting(const char *path, const char *text, int coordinate, double x) {
  char setting[256];
  snprintf(setting, sizeof setting, "%s=\"%s\"", path, text);
  sd_model *m = with(constants, setting);
  if (!m) sd_messages_print(messages, stderr);
  assert_non_null(m);
  if (m->disks[0].position[coordinate] != x)
    print_error("%s: %.17g, expected %.17g\n", text, m->disks[0].position[coordinate], x);
  assert_true(m->disks[0].position[coordinate] == x);
  sd_model_free(m);
}

static void expect(const char *text, double x) { expect_setting("disks.a.x", text, 0, x); }
static void expect_angle(const char *text, double x) {
  expect_setting("disks.a.theta", text, 2, x);
}

static void test_values(void **state) {
  volatile double R = 0.02, g = 9.81;
  expect("12", 12);
  expect(" 1e-5 ", 1e-5);
  expect("2 * R", 2 * R);
  expect("R", R);
  expect("0.7*9.81", 0.7 * g);
  expect("A", 0.7 * g);
  expect("A/g", 0.7 * g / g);
  expect("long_name2", R / 10);
  expect("1 - 2 - 3", -4);
  expect("1 - (2 - 3)", 2);
  expect("8/4/2", 1);
  expect("8/(4/2)", 4);
  expect("2+3*4", 14);
  expect("-2^2", -4);
  expect("2^-1", 0.5);
  expect("2**3", 8);
  expect("2^3^2", 512);
  expect("--3", 3);
  expect("2*-R", -2 * R);
  expect("-sqrt(3)", -sqrt(3));
  expect("2 pi * R", 2 * M_PI * R);
  expect("hypot(3, 4)", 5);
  expect("min(1, 2) - max(1, 2)", -1);
  expect("abs(-3) + floor(1.5) + ceil(1.5) + round(1.6)", 8);
  expect("2 * cos(60 deg)", 2 * cos(60 * (M_PI / 180)));
  expect("exp(log(2)) + log10(100)", exp(log(2)) + 2);
  expect(".5e1", 5);
}

/* Angles are as they were before there was arithmetic. */
static void test_angles(void **state) {
  expect_angle("0.04 pi", 0.04 * M_PI);
  expect_angle("7.2 deg", 7.2 * (M_PI / 180));
  expect_angle("7.2deg", 7.2 * (M_PI / 180));
  expect_angle("pi/6", M_PI / 6);
  expect_angle("-2*pi", -2 * M_PI);
  expect_angle("- pi / 7", -(M_PI / 7));
  expect_angle("2 pi/3", 2 * M_PI / 3);
  expect_angle("3 rad", 3);
  expect_angle("1/3 pi", 1.0 / 3 * M_PI);
  expect_angle("a/2", 30 * (M_PI / 180) / 2);
  expect_angle("90 deg - a", 90 * (M_PI / 180) - 30 * (M_PI / 180));
}

static void test_integers(void **state) {
  sd_model *m = with("", "steps=\"2 * 50 + 1\"");
  assert_non_null(m);
  assert_int_equal(m->phases[0].steps, 101);
  sd_model_free(m);
  m = with("constants = { N = 7; };", "seed=\"N - 4\"");
  assert_non_null(m);
  assert_int_equal(m->seed, 3);
  sd_model_free(m);
  assert_null(with("", "steps=\"7 / 2\""));
  assert_non_null(strstr(sd_messages_text(messages, 0),
                         "it is 3.5; expected a whole number >= 1, such as round(...)"));
}

/* One message, which holds these words. */
static void bad(const char *more, const char *setting, const char *words) {
  sd_model *m = with(more, setting);
  assert_null(m);
  if (sd_messages_errors(messages) != 1 || !strstr(sd_messages_text(messages, 0), words)) {
    print_error("%s, %s: expected: %s\n", more, setting, words);
    sd_messages_print(messages, stderr);
    fail();
  }
}

static void test_mistakes(void **state) {
  const char *R = "constants = { R = 0.02; };";
  bad(R, "skin=\"2 * r\"", "no constant is called \"r\"; did you mean \"R\"?");
  bad("", "skin=\"2 * R\"", "expected a number; no constant is called \"R\"");
  bad(R, "skin=\"1 mm\"", "\"mm\": units are not written");
  bad(R, "skin=\"1e4 N/m\"", "\"N/m\": units are not written");
  bad(R, "disks.a.theta=\"2 pie\"", "\"pie\" behind a number; did you mean \"pi\"?");
  bad(R, "skin=\"2 R\"", "a product needs *");
  bad(R, "skin=\"3 deg\"", "deg belongs to angles");
  bad(R, "skin=\"2 3\"", "a comma or an operator is missing before \"3\"");
  bad(R, "skin=\"2 (3)\"", "a comma or an operator is missing before \"(3)\"");
  bad(R, "skin=\"2 *\"", "not complete");
  bad(R, "skin=\"\"", "expected a number");
  bad(R, "skin=\"(2\"", "a ) is missing");
  bad(R, "skin=\"2)\"", "unexpected \")\"");
  bad(R, "skin=\"R = 3\"", "unexpected \"= 3\"");
  bad(R, "skin=\"1, 2\"", "unexpected \", 2\"");
  bad(R, "skin=\"1/0\"", "division by zero");
  bad(R, "skin=\"R/(R-R)\"", "division by zero");
  bad(R, "skin=\"sqrt(-1)\"", "sqrt of -1 is no number");
  bad(R, "skin=\"log(0)\"", "not finite");
  bad(R, "skin=\"10^400\"", "not finite");
  bad(R, "skin=\"1e400\"", "too large");
  bad(R, "skin=\"1e-400\"", "too small");
  bad(R, "skin=\"10^200\"", "from -1e100 to 1e100");
  bad(R, "skin=\"R - 1\"", "it is -0.98; expected a number >= 0");
  bad(R, "skin=\"sqr(2)\"", "no function is called \"sqr\"; did you mean \"sqrt\"?");
  bad(R, "skin=\"hypot(2)\"", "hypot takes two numbers");
  bad(R, "skin=\"nan\"", "no constant is called \"nan\"");
  bad(R, "skin=\"0x10\"", "\"x10\"");
  bad(R, "R=3", "did you mean constants.R?");
}

static void test_constants(void **state) {
  bad("constants = { a = \"a\"; };", "skin=1", "constants.a = \"a\": a depends on itself");
  bad("constants = { a = \"2*b\"; b = \"c\"; c = \"a - 1\"; };", "skin=1", "a depends on itself");
  bad("constants = { a = \"b\"; };", "skin=1",
      "constants.a = \"b\": expected a number; no constant is called \"b\"");
  bad("constants = { a = true; };", "skin=1", "expected a number");
  bad("constants = { pi = 3; };", "skin=1", "has a meaning of its own");
  bad("constants = { sqrt = 3; };", "skin=1", "has a meaning of its own");
  bad("constants = { a-b = 3; };", "skin=1", "letters, digits and _");
  bad("constants = 3;", "skin=1", "expected a group");
  /* a mistake in a constant is told once, however often it is used */
  bad("constants = { a = \"1/0\"; b = \"a\"; };", "skin=\"a + b\"",
      "constants.a = \"1/0\": division by zero");
}

static const char deck[] =
    "constants = { R = 0.02; g = 9.81; A = \"0.7 * g\"; };\n"
    "dt = \"R / 1000\"; steps = \"10 * 10\"; gravity = { g = \"A\"; tilt = \"1/3 pi\"; };\n"
    "materials = ( { name = \"m\"; k_n = \"1e4 / 3\"; } );\n"
    "disks = ( { name = \"a\"; x = \"sqrt(3) * R\"; y = 0; radius = \"R\"; mass = 2; } );\n"
    "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); rows = ( (\"10 * R\", 1, \"R/3\") ); "
    "mass = 1; } );\n";

static void same_models(const sd_model *a, const sd_model *b) {
  assert_memory_equal(a->gravity, b->gravity, sizeof a->gravity);
  assert_memory_equal(&a->dt, &b->dt, sizeof a->dt);
  assert_memory_equal(&a->laws[0].k_n, &b->laws[0].k_n, sizeof(double));
  assert_int_equal(a->phases[0].steps, b->phases[0].steps);
  for (size_t k = 0; k < 2; k++) {
    assert_memory_equal(a->disks[k].position, b->disks[k].position, sizeof a->disks[k].position);
    assert_memory_equal(&a->disks[k].radius, &b->disks[k].radius, sizeof(double));
  }
}

static void test_echo(void **state) {
  sd_model *m = load(deck, 0, NULL);
  assert_non_null(m);
  const char *full = sd_model_deck(m)->full;
  assert_non_null(strstr(full, "radius = \"R\" /* 0.02 */;"));
  assert_non_null(strstr(full, "tilt = \"1/3 pi\";"));
  assert_non_null(strstr(full, "A = \"0.7 * g\" /* 6.867 */;"));
  sd_model *again = load(full, 0, NULL);
  assert_non_null(again);
  same_models(m, again);
  /* the echo is as alive as the deck */
  const char *set[] = {"constants.R=0.03"};
  sd_model *other = load(deck, 1, set), *echo = load(full, 1, set);
  assert_non_null(other);
  assert_non_null(echo);
  assert_true(other->disks[0].radius == 0.03 && other->dt == 0.03 / 1000);
  same_models(other, echo);
  sd_model_free(m);
  sd_model_free(again);
  sd_model_free(other);
  sd_model_free(echo);
}

static void test_command_line(void **state) {
  static const char *const ways[] = {"gravity.tilt=3deg", "gravity.tilt=3 deg",
                                     "gravity.tilt=\"3 deg\"", "gravity.tilt=9/3 deg"};
  for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
    sd_model *m = load(deck, 1, &ways[k]);
    if (!m) sd_messages_print(messages, stderr);
    assert_non_null(m);
    assert_true(m->gravity[0] == -(0.7 * 9.81) * sin(3 * (M_PI / 180)));
    sd_model_free(m);
  }
  const char *product = "gravity.g=2*A", *title = "title=10kg";
  sd_model *m = load(deck, 1, &product);
  assert_non_null(m);
  assert_true(hypot(m->gravity[0], m->gravity[1]) > 13.7);
  sd_model_free(m);
  m = load(deck, 1, &title);
  assert_non_null(m);
  sd_model_free(m);
}

static void test_sweep(void **state) {
  char path[] = "/tmp/slipdisk-expressions-XXXXXX";
  int fd = mkstemp(path);
  assert_true(fd >= 0);
  FILE *out = fdopen(fd, "w");
  fprintf(out,
          "%ssweep = { parameters = ( { path = \"constants.R\"; values = (0.01, \"0.1 / 5\"); },\n"
          "  { path = \"disks.a.radius\"; values = (\"R / 2\"); },\n"
          "  { path = \"gravity.tilt\"; linspace = (0, \"1/2 pi\", 3); } ); };",
          deck);
  fclose(out);
  deck_sweep s;
  messages = sd_messages_new();
  sd_status status = deck_sweep_load(path, 0, NULL, &s, messages);
  if (status != SD_OK) sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  assert_int_equal(s.n_points, 6);
  assert_true(s.points[5].values[0] == 0.1 / 5); /* the number in the tables */
  assert_string_equal(s.points[5].texts[2], "0.5 pi");
  for (size_t k = 0; k < s.n_points; k++) {
    sd_model *m;
    assert_int_equal(deck_sweep_model(&s, k, &m, messages), SD_OK);
    assert_true(m->disks[0].radius ==
                (k < 3 ? 0.01 : 0.1 / 5) / 2); /* of the constant of this point */
    sd_model_free(m);
  }
  deck_sweep_free(&s);
  remove(path);
}

static void test_hostile(void **state) {
  enum { LONG = BRIEF(300000, 30000) };
  static char text[2 * LONG + 4096];
  static const char *const pieces[] = {"(",  "-",   "2^", "2^-",    "sqrt(", "1+",  "1*",
                                       "R*", "pi ", "1/", "min(1,", ")",     "((1)"};
  for (size_t k = 0; k < sizeof pieces / sizeof *pieces; k++) {
    char *to = text + sprintf(text, "%sskin = \"", REST "constants = { R = 1; };");
    for (size_t n = 0; n < LONG / strlen(pieces[k]); n++) to += sprintf(to, "%s", pieces[k]);
    sprintf(to, "1\";");
    sd_model_free(load(text, 0, NULL));
  }
  /* a long sum is no deep one */
  char *to = text + sprintf(text, "%sskin = \"", REST);
  for (size_t n = 0; n < 10000; n++) to += sprintf(to, "1 + ");
  sprintf(to, "0\";");
  sd_model *m = load(text, 0, NULL);
  assert_non_null(m);
  assert_true(m->skin == 10000);
  sd_model_free(m);
  /* constants that follow from each other */
  to = text + sprintf(text, "%sconstants = { c0 = 1;", REST);
  for (int n = 1; n < 200; n++) to += sprintf(to, " c%d = \"c%d + 1\";", n, n - 1);
  sprintf(to, "};");
  m = load(text, 0, NULL);
  assert_non_null(m); /* in their order none is deep */
  sd_model_free(m);
  to = text + sprintf(text, "%sconstants = { c0 = 1;", REST);
  for (int n = 199; n > 0; n--) to += sprintf(to, " c%d = \"c%d + 1\";", n, n - 1);
  sprintf(to, "};");
  assert_null(load(text, 0, NULL));
  assert_non_null(strstr(sd_messages_text(messages, 0), "follow from each other"));
}

static int end(void **state) {
  sd_messages_free(messages);
  messages = NULL;
  return 0;
}

RUN_TESTS(cmocka_unit_test_teardown(test_values, end), cmocka_unit_test_teardown(test_angles, end),
          cmocka_unit_test_teardown(test_integers, end),
          cmocka_unit_test_teardown(test_mistakes, end),
          cmocka_unit_test_teardown(test_constants, end), cmocka_unit_test_teardown(test_echo, end),
          cmocka_unit_test_teardown(test_command_line, end),
          cmocka_unit_test_teardown(test_sweep, end), cmocka_unit_test_teardown(test_hostile, end))
