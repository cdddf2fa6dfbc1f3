/* test_packings_mistakes.c: containers and packings of decks that are refused, and with which words. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>
#include <math.h>

#include "packings_decks.h"

/* --- containers ------------------------------------------------------------------------------------------- */

#define CONTAINER(keys) HEAD ONE "container = { " keys " };\n"

static void test_container_mistakes(void **state) {
  (void)state;
  refused(HEAD ONE BOX "box = { x = (0, 1); };",
          "box.x = (0, 1): given together with container \"box\", which has its own edges");
  refused(
      CONTAINER(
          "type = \"channel\"; width = 10; height = 8;") "box = { periodic = \"y\"; y = (0, 8); };",
      "box.y = (0, 8): given together with container \"channel\", which has its own edges\n"
      "box.periodic = \"y\": given together with container \"channel\", which is periodic in x");
  refused(CONTAINER("type = \"bag\"; width = 10;"),
          "container.type = \"bag\": expected one of \"box\", \"channel\", \"bed\", \"hopper\", "
          "\"drum\", "
          "\"periodic\"; did you mean \"box\"?");
  refused(CONTAINER("type = \"box\"; width = 10;"),
          "container.height: missing: type \"box\" needs it (inner height)");
  refused(CONTAINER("type = \"box\"; width = 10; height = -1;"),
          "container.height = -1: expected a number > 0");
  refused(CONTAINER("type = \"drum\"; radius = 5; width = 10;"),
          "container.width = 10: does not belong to type \"drum\"");
  refused(CONTAINER("type = \"hopper\"; width = 10; height = 12; outlet = 11; angle = 1;"),
          "container.outlet = 11: expected less than the width, 10");
  refused(
      CONTAINER("type = \"hopper\"; width = 10; height = 12; outlet = 2; angle = \"pi/2\";"),
      "container.angle = \"pi/2\": expected an inclination from 0 to 1.5, less than a right angle");
  refused(CONTAINER("type = \"hopper\"; width = 10; height = 4; outlet = 2; angle = \"45 deg\";"),
          "container.height = 4: the inclined walls alone are 4 high; expected more");
  refused(CONTAINER("type = \"bed\"; width = 10; height = 8; radius = 1e-9;"),
          "container.spacing: the floor would have 5e+09 disks; expected 1e6 at most");
  refused(CONTAINER("type = \"box\"; width = 10; height = 8; material = \"steel\";"),
          "container.material = \"steel\": no material is called that; there is \"m\"");
  refused(HEAD ONE BOX
          "walls = ( { name = \"left\"; type = \"line\"; points = ((0, 0), (1, 0)); } );",
          "container.type = \"box\": it has a wall \"left\", but a wall or a disk of the deck is "
          "called so");
  refused(HEAD ONE BOX "disks = ( { name = \"floor\"; x = 0; y = 6; radius = 1; mass = 1; } );",
          "container.type = \"box\": it has a wall \"floor\", but a wall or a disk of the deck is "
          "called so");
  refused(CONTAINER("type = \"bed\"; width = 10; height = 8; radius = 0.3;") "disks = ( { x = 0; y "
                                                                             "= 4; radius = 0.3; "
                                                                             "mass = 1; group = "
                                                                             "\"floor\"; } );",
          "container.type = \"bed\": its floor is the group \"floor\", but the deck has disks in "
          "this group");
}

/* --- packings --------------------------------------------------------------------------------------------- */

#define PACKING(keys) "packings = ( { " keys " } );\n"
#define RANDOM(keys) HEAD BOX PACKING("type = \"random\"; count = 9; density = 1; " keys)

static void test_what_cannot_fit(void **state) {
  (void)state;
  refused(
      HEAD BOX PACKING("type = \"random\"; count = 1000; " MONO),
      "packings[0]: 1000 disks of area 196.35 in all in a region of area 80: a packing fraction of "
      "2.454; expected "
      "at most 0.9069");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 0.95; " MONO),
          "packings[0].fraction = 0.95: more than the densest packing of equal disks has; expected "
          "at most "
          "0.9069");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 1.5; " MONO),
          "packings[0].fraction = 1.5: expected a number > 0 and <= 1");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 1e-4; " MONO),
          "packings[0].fraction = 0.0001: less than one disk in a region of area 80");
  refused(HEAD BOX PACKING("type = \"square\"; count = 321; " MONO),
          "packings[0].count = 321: the lattice has 320 free sites only");
  refused(HEAD BOX PACKING("type = \"square\"; y = (0, 1); x = (0, 1); radius = 0.6; mass = 1;"),
          "packings[0]: a disk of radius 0.6 does not fit into a region that is 1 wide\n"
          "packings[0]: a disk of radius 0.6 does not fit into a region that is 1 high");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 1e-6; radius = 1e-7; mass = 1;"),
          "packings[0].spacing = 1e-06: the lattice has about 9.23761e+13 sites; expected at most "
          "200000000");
  refused(HEAD BOX PACKING("type = \"square\"; count = 3; spacing = 9; " MONO),
          "packings[0]: the lattice has no free site in the region");
  refused(HEAD BOX PACKING("type = \"random\"; count = 1000000000; radius = 1e-6; mass = 1;"),
          "packings[0]: 1e+09 disks; expected at most 200000000");
  refused(
      HEAD BOX PACKING("type = \"rain\"; count = 400; " MONO),
      "packings[0]: 400 disks of area 78.5398 in all in a region of area 80: a packing fraction of "
      "0.9817; expected "
      "at most 0.9069");
  refused(HEAD BOX "disks = ( { x = 0; y = 4; radius = 3.9; mass = 1; } );" PACKING(
              "type = \"front\"; x = (-1, 1); y = (3, 5); " MONO),
          "packings[0]: the front found no place for a disk in the region");
}

/* The numbers in these messages follow from the generators. */
static void test_generators_that_end(void **state) {
  (void)state;
  size_t placed, all;
  double fraction, asked;
  assert_null(load(HEAD BOX PACKING("type = \"random\"; fraction = 0.6; " MONO), NULL, NULL));
  assert_int_equal(sscanf(sd_messages_text(messages, 0),
                          "test.cfg:%*d: packings[0].fraction = 0.6: random placement found no "
                          "room for more than %zu of "
                          "%zu disks, a fraction of %lf of the region where %lf was asked for; "
                          "expected less, or type "
                          "\"front\"",
                          &placed, &all, &fraction, &asked),
                   4);
  assert_int_equal(all, 244); /* 0.6 * 80/(pi/16) */
  assert_true(fabs(fraction - placed * M_PI / 16 / 80) < 5e-4 &&
              fabs(asked - all * M_PI / 16 / 80) < 5e-4);
  assert_true(fraction > 0.46 && fraction < 0.55);
  assert_null(load(HEAD BOX PACKING("type = \"front\"; count = 360; " MONO), NULL, NULL));
  assert_int_equal(sscanf(sd_messages_text(messages, 0),
                          "test.cfg:%*d: packings[0].count = 360: the front has filled the region "
                          "with %zu disks, a "
                          "fraction of %lf",
                          &placed, &fraction),
                   2);
  assert_true(fabs(fraction - placed * M_PI / 16 / 80) < 5e-4 && fraction > 0.78);
}

static void test_region_mistakes(void **state) {
  (void)state;
  refused(HEAD PACKING("type = \"random\"; count = 3; x = (0, 1); " MONO),
          "packings[0].y: missing: expected (lower, upper), since no container and no box gives "
          "edges in y");
  refused(RANDOM("radius = 0.1; x = (1, 0);"),
          "packings[0].x = (1, 0): expected (lower, upper) with lower < upper");
  refused(RANDOM("radius = 0.1; x = (-6, 0);"),
          "packings[0].x = (-6, 0): reaches beyond the container, from -5 to 5");
  refused(RANDOM("radius = 0.1; y = (-1, 2);"),
          "packings[0].y = (-1, 2): reaches beyond the container, from 0 to 8");
  refused(HEAD "container = { type = \"box\"; width = 10; height = 8; open = false; };" PACKING(
              "type = \"random\"; count = 3; y = (0, 9); " MONO),
          "packings[0].y = (0, 9): reaches beyond the container, from 0 to 8");
  refused(HEAD PERIODIC PACKING("type = \"random\"; count = 3; x = (9, 11); " MONO),
          "packings[0].x = (9, 11): reaches beyond the periodic box, from 0 to 10");
  refused(HEAD DRUM PACKING(
              "type = \"random\"; count = 3; x = (4.9, 5); y = (4.9, 5); radius = 0.01; mass = 1;"),
          "packings[0]: its region lies outside the container");
  /* over the open top of a box there is room; edges of a box without walls do, too */
  sd_model_free(good(RANDOM("radius = 0.1; y = (0, 20);")));
  sd_model_free(good(
      HEAD "box = { x = (0, 4); y = (0, 4); };" PACKING("type = \"random\"; count = 3; " MONO)));
  /* a container with mistakes does not lead to more of them */
  refused(HEAD "container = { type = \"box\"; width = 10; height = 0; };" PACKING(
              "type = \"random\"; count = 3; " MONO),
          "container.height = 0: expected a number > 0");
}

static void test_size_mistakes(void **state) {
  (void)state;
  refused(RANDOM(""), "packings[0].radius: missing: sizes \"mono\" needs it (radius; gaussian: "
                      "mean; lognormal: median)");
  refused(RANDOM("sizes = \"mono\"; radius = 1; lower = 1;"),
          "packings[0].lower = 1: does not belong to sizes \"mono\"");
  refused(RANDOM("sizes = \"normal\"; radius = 1;"),
          "packings[0].sizes = \"normal\": expected one of \"mono\", \"list\", \"uniform\", "
          "\"gaussian\", "
          "\"lognormal\", "
          "\"powerlaw\"; did you mean \"lognormal\"?");
  refused(RANDOM("sizes = \"uniform\"; lower = 0.3; upper = 0.2;"),
          "packings[0].upper = 0.2: expected more than lower, 0.3");
  refused(RANDOM("sizes = \"powerlaw\"; exponent = 2; lower = 0.2; upper = 0.2;"),
          "packings[0].upper = 0.2: expected more than lower, 0.2");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.01; lower = 0.3;"),
          "packings[0].lower = 0.3: expected less than upper, 0.23");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.1;"),
          "packings[0].lower: missing: 3 deviations below the mean is -0.1; expected a radius > 0");
  refused(RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = -0.1;"),
          "packings[0].deviation = -0.1: expected a number > 0");
  refused(
      RANDOM("sizes = \"gaussian\"; radius = 0.2; deviation = 0.01; lower = 0.3; upper = 0.4;"),
      "packings[0].lower = 0.3: only 7.61985e-24 of the distribution lies between lower and upper");
  refused(RANDOM("sizes = \"list\"; radii = ();"),
          "packings[0].radii = (): expected a list of numbers > 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, -0.2);"),
          "packings[0].radii[1] = -0.2: expected a number > 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, \"b\");"),
          "packings[0].radii[1] = \"b\": expected a number; no constant is called \"b\"");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (1, 2, 3);"),
          "packings[0].weights = (1, 2, 3): 3 weights for 2 radii; expected one for each");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (1, -2);"),
          "packings[0].weights[1] = -2: expected a number >= 0");
  refused(RANDOM("sizes = \"list\"; radii = (0.1, 0.2); weights = (0, 0);"),
          "packings[0].weights = (0, 0): all are 0");
}

static void test_packing_mistakes(void **state) {
  (void)state;
  refused(HEAD BOX PACKING("type = \"random\"; " MONO),
          "packings[0].count/fraction: missing: type \"random\" needs it (number of disks)");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; fraction = 0.2; " MONO),
          "packings[0].fraction = 0.2: given together with count; expected one of them");
  refused(HEAD BOX PACKING("type = \"random\"; count = 0; " MONO),
          "packings[0].count = 0: expected a whole number >= 1");
  refused(HEAD BOX PACKING("type = \"front\"; jitter = 0.5; " MONO),
          "packings[0].jitter = 0.5: does not belong to type \"front\"");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; radius = 0.1;"),
          "packings[0].mass: missing: expected mass or density > 0");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; mass = 1; " MONO),
          "packings[0].density = 2: given together with mass; expected one of them");
  refused(HEAD BOX PACKING("type = \"random\"; count = 3; material = \"n\"; " MONO),
          "packings[0].material = \"n\": no material is called that; there is \"m\"");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 0.49; " MONO),
          "packings[0].spacing = 0.49: expected at least the largest diameter, 0.5");
  refused(HEAD BOX PACKING("type = \"square\"; spacing = 0.6; jitter = 1.1; " MONO),
          "packings[0].jitter = 1.1: expected at most 1; beyond it disks could overlap");
}

static void test_tile_mistakes(void **state) {
  (void)state;
  refused(HEAD BOX PACKING("type = \"front\"; tiles = 2; " MONO),
          "packings[0].count: missing: expected the number of disks, which tiles share");
  refused(HEAD BOX PACKING("type = \"random\"; fraction = 0.2; tiles = 2; " MONO),
          "packings[0].count: missing: expected the number of disks, which tiles share");
  refused(HEAD BOX PACKING("type = \"front\"; count = 3; tiles = 4; " MONO),
          "packings[0].tiles = 4: expected at most one for each of the 3 disks");
  refused(HEAD BOX PACKING("type = \"front\"; count = 50; tiles = 30; " MONO),
          "packings[0].tiles = 30: each is 0.333333 wide; expected fewer, so that a disk of radius "
          "0.25 fits "
          "between their edges");
  refused(HEAD BOX PACKING("type = \"rain\"; count = 50; tiles = 51; " MONO),
          "packings[0].tiles = 51: expected at most one for each of the 50 disks");
  refused(HEAD BOX PACKING("type = \"square\"; count = 50; tiles = 2; jitter = 1.1; " MONO),
          "packings[0].jitter = 1.1: expected at most 1; beyond it disks could overlap");
  refused(HEAD BOX PACKING("type = \"square\"; count = 20; tiles = 3; y = (0, 0.6); " MONO),
          "packings[0].count = 20: tile 0 of 3 holds 6 disks only, where 7 were asked for; "
          "expected fewer "
          "disks or "
          "a larger region");
}

static void test_rain_mistakes(void **state) {
  (void)state;
#define RAIN(keys) PACKING("type = \"rain\"; count = 9; " keys MONO)
  refused(HEAD BOX PACKING("type = \"rain\"; " MONO),
          "packings[0].count: missing: type \"rain\" needs it (number of disks)");
  refused(HEAD BOX RAIN("rows = 0; "), "packings[0].rows = 0: expected a whole number >= 1");
  refused(HEAD PERIODIC RAIN(""), "packings[0]: rain cannot fall in a box that is periodic in y");
  refused(HEAD DRUM RAIN(""),
          "packings[0]: rain in a drum needs x and y, a rectangle that lies inside the drum");
  refused(HEAD DRUM RAIN("x = (-2, 2); y = (0, 1.5); "),
          "packings[0].rows: a batch is 2 high, the region only 1.5");
  refused("dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );" BOX RAIN(""),
          "packings[0]: nothing falls; expected gravity that points down (g > 0), or a speed > 0");
  sd_model_free(good("dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );" BOX RAIN(
      "speed = 1; ")));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_container_mistakes),  cmocka_unit_test(test_what_cannot_fit),
      cmocka_unit_test(test_generators_that_end), cmocka_unit_test(test_region_mistakes),
      cmocka_unit_test(test_size_mistakes),       cmocka_unit_test(test_packing_mistakes),
      cmocka_unit_test(test_rain_mistakes),       cmocka_unit_test(test_tile_mistakes),
  };
  return cmocka_run_group_tests(tests, NULL, tear_down);
}
