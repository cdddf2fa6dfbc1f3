/* test_tiles.c: decks whose last packing is made in tiles, of which each rank makes some. */
#include "io/store/h5.h"
#define SCRATCH_NAME "tiles"
#include "scratch_file.h"
#include "packings_decks.h"
#include "ranks_deck.h"

#define TILES(more)                                                                                \
  HEAD                                                                                             \
      "container = { type = \"box\"; width = 60; height = 60; };\n"                                \
      "disks = ( { name = \"peg\"; x = 0; y = 40; radius = 1; mass = 1; fixed = true; } );\n"      \
      "packings = ( { type = \"front\"; count = 3301; tiles = 3; sizes = \"uniform\"; lower = "    \
      "0.2; upper "                                                                                \
      "= 0.4; "                                                                                    \
      "density = 2; group = \"grains\"; " more " } );\n"                                           \
      "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 0.1; " \
      "frequency = 1; } );\n"

static void test_tiles_of_ranks(void **state) {
  /* what depends on all disks: a servo, the surface of a wall, the stream of one random motion of
   * several walls, drag */
  static const char *const more[] = {
      "",
      "motions = ( { wall = \"floor\"; coordinate = \"surface\"; type = \"velocity\"; velocity = "
      "1; } );",
      "motions = ( { wall = (\"floor\", \"left\"); coordinate = \"x\"; type = \"random\"; "
      "amplitude = 0.1; frequency = 1; independent = false; } );",
      "motions = ( { wall = \"left\"; coordinate = \"x\"; type = \"servo\"; force = 3; speed = 1; "
      "} );",
      "fields = ( { type = \"drag\"; gamma = 300; } );",
      "measure = { disks = true; };",
      "walls = ( { type = \"segment\"; points = ((-30, 50), (0, 50)); }, { type = \"segment\"; "
      "points = ((-10, 50), (-10, 55)); } );",
  };
  for (size_t k = 0; k < sizeof more / sizeof *more; k++) {
    char text[4096];
    snprintf(text, sizeof text, "%s", TILES(""));
    char *motions = strstr(text, "motions");
    assert_non_null(motions);
    if (*more[k]) snprintf(motions, sizeof text - (size_t)(motions - text), "%s", more[k]);
    sd_model *all = alone(text);
    for (int ranks = 2; ranks <= RANKS; ranks++) {
      reading r = read_deck(text, ranks, 0, NULL);
      check_rows(&r, all, 1);
      check_numbers(&r, all);
      for (size_t n = 0; n < all->n_motions; n++) {
        assert_int_equal(r.model[1]->motions[n].bodies[0], all->motions[n].bodies[0]);
        assert_int_equal(r.model[1]->motions[n].stream, all->motions[n].stream);
      }
      end_reading(&r);
    }
    sd_model_free(all);
  }
}

/* All ranks make all disks of a deck that speaks of single ones, or asks for their order. */
static void test_tiles_that_stay(void **state) {
  static const struct {
    const char *text, *why;
  } more[] = {
      {"measure = { contacts = (1, 3000); };", "the deck speaks of single disks of it"},
      {"forces = ( { group = \"grains\"; force = (1, 0); } );",
       "the deck speaks of single disks of it"},
      {"locks = ( { group = \"grains\"; coordinates = \"theta\"; } );",
       "the deck speaks of single disks of it"},
      {"fields = ( { type = \"drag\"; gamma = 1; group = \"grains\"; } );",
       "the deck speaks of single disks of it"},
  };
  char text[4096];
  for (size_t k = 0; k < sizeof more / sizeof *more; k++) {
    char told[200];
    snprintf(text, sizeof text, "%s%s", TILES(""), more[k].text);
    snprintf(told, sizeof told, "packings[0].tiles: every rank makes all, since %s", more[k].why);
    reading r = read_deck(text, 2, 0, NULL);
    assert_non_null(r.model[1]);
    for (int q = 0; q < 2; q++) {
      assert_false(r.model[q]->tiles.away);
      assert_int_equal(model_held(r.model[q]), 3302);
      assert_true(says(r.messages[q], told));
    }
    end_reading(&r);
  }
  /* the packing is not the last; it is so small that its disks keep the order of the deck */
  reading r = read_deck(
      TILES("}, { type = \"square\"; count = 1; x = (0, 1); y = (55, 60); radius = 0.1; mass = 1;"),
      2, 0, NULL);
  assert_true(r.model[1] && !r.model[1]->tiles.away && model_held(r.model[1]) == 3303);
  end_reading(&r);
  snprintf(text, sizeof text, "%s", TILES(""));
  memcpy(strstr(text, "3301"), " 999", 4);
  r = read_deck(text, 2, 0, NULL);
  assert_true(r.model[1] && !r.model[1]->tiles.away && model_held(r.model[1]) == 1000);
  end_reading(&r);
}

/* Mistakes in tiles are found by the ranks that have them; the others fail with them. */
static void test_mistakes_in_tiles(void **state) {
  static const struct {
    const char *from, *to, *says;
  } changes[] = {
      {"y = 40; radius = 1", "y = 30; radius = 24", "tile 1 of 3 holds "},
      {"motions =", "bounds = { x = (-30, 15); };\nmotions =", "starts outside the bounds"},
      {"density = 2", "density = 1e-9", "dt = "},
  };
  for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
    char text[4096];
    const char *whole = TILES(""), *at = strstr(whole, changes[k].from);
    assert_non_null(at);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - whole), whole, changes[k].to,
             at + strlen(changes[k].from));
    reading r = read_deck(text, RANKS, 0, NULL);
    if (!any_says(&r, changes[k].says)) {
      for (int q = 0; q < RANKS; q++) sd_messages_print(r.messages[q], stderr);
      print_error("%s\n", changes[k].says);
    }
    assert_null(r.model[0]);
    assert_true(any_says(&r, changes[k].says));
    end_reading(&r);
  }
}

/* Every rank makes a packing without parts, up to a size. */
static void test_too_many_for_every_rank(void **state) {
  reading r = read_deck(HEAD "container = { type = \"box\"; width = 6000; height = 6000; };\n"
                             "packings = ( { type = \"front\"; count = 3000000; " MONO " } );\n",
                        2, 0, NULL);
  assert_null(r.model[0]);
  assert_true(says(r.messages[0],
                   "packings[0].count = 3000000: every rank would have all 3000000 disks; expected "
                   "at most 2000000, a packing with `tiles`, or an HDF5 file"));
  end_reading(&r);
}

/* Runs of disks of a rain: where they wait goes by their numbers. */
#define RAIN(tiles, rows)                                                                          \
  HEAD "container = { type = \"box\"; width = 60; height = 40; };\n"                               \
       "disks = ( { name = \"peg\"; x = 0; y = 20; radius = 1; mass = 1; fixed = true; } );\n"     \
       "packings = ( { type = \"rain\"; count = 3301; tiles = " tiles "; rows = " rows             \
       "; sizes = \"uniform\"; "                                                                   \
       "lower = 0.2; upper = 0.4; density = 2; } );\n"

static void test_rain_of_ranks(void **state) {
  sd_model *all = alone(RAIN("3", "2"));
  assert_int_equal(all->rains[0].count, 3301);
  for (int ranks = 2; ranks <= RANKS; ranks++) {
    reading r = read_deck(RAIN("3", "2"), ranks, 0, NULL);
    check_rows(&r, all, 1);
    check_numbers(&r, all);
    for (int q = 0; q < ranks; q++) {
      const sd_model *m = r.model[q];
      assert_int_equal(sd_messages_count(r.messages[q]), 0);
      assert_int_equal(m->n_rains, 1);
      assert_memory_equal(m->rains, all->rains, sizeof *m->rains);
      for (size_t k = 0; k < m->mine->n; k++) {
        const double y = m->mine->disk[k].position[1];
        assert_true(m->mine->disk[k].waiting);
        assert_true(y - 0.4 >= all->tiles.lower[1] && y + 0.4 <= all->tiles.upper[1]);
      }
    }
    end_reading(&r);
  }
  sd_model_free(all);
  /* a batch that one tile does not hold */
  reading r = read_deck(RAIN("3", "400"), 2, 0, NULL);
  assert_true(r.model[0] && model_held(r.model[0]) == 3302);
  assert_true(says(r.messages[0],
                   "packings[0].tiles: every rank makes all, since tiles have fewer disks than a "
                   "batch of rain"));
  end_reading(&r);
  refused(RAIN("3302", "2"),
          "packings[0].tiles = 3302: expected at most one for each of the 3301 disks");
}

static int end(void **state) {
  tear_down(state);
  return remove_folder(state);
}

static int begin(void **state) {
  messages = sd_messages_new();
  return messages ? make_folder(state) : -1;
}

RUN_TESTS_BETWEEN(begin, end, TEST(test_tiles_of_ranks), TEST(test_tiles_that_stay),
                  TEST(test_mistakes_in_tiles), TEST(test_too_many_for_every_rank),
                  TEST(test_rain_of_ranks))
