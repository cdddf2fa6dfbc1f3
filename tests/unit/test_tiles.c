/* test_tiles.c: decks whose last disks are left to the ranks of a run: packings in tiles, and large files in parts. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/deck/deck.h"
#include "io/results/provenance.h"
#include "io/store/h5.h"
#include "model/tiles.h"
#include "pack/tiles.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"
#define SCRATCH_NAME "tiles"
#include "scratch_file.h"
#include "packings_decks.h"

/* --- packings ------------------------------------------------------------------------------------------------ */

#define TILES(more)                                                                                          \
  HEAD "container = { type = \"box\"; width = 60; height = 60; };\n"                                         \
       "disks = ( { name = \"peg\"; x = 0; y = 40; radius = 1; mass = 1; fixed = true; } );\n"               \
       "packings = ( { type = \"front\"; count = 3301; tiles = 3; sizes = \"uniform\"; lower = 0.2; upper "  \
       "= 0.4; "                                                                                             \
       "density = 2; group = \"grains\"; " more " } );\n"                                                    \
       "motions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 0.1; "          \
       "frequency = 1; } );\n"

/* The deck as a run reads it that ranks will share; how many of its disks are there. */
static sd_model *for_ranks(const char *text, size_t *held) {
  FILE *file = fopen(path, "w");
  sd_model *m;
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
  sd_messages_clear(messages);
  const sd_status status = deck_load_for_ranks(path, 0, NULL, NULL, &m, messages);
  *held = m ? model_held(m) : 0;
  if (m) check(status, messages);
  return m;
}

static void test_tiles_of_ranks(void **state) {
  (void)state;
  size_t held;
  sd_model *all = good(TILES("")), *m = for_ranks(TILES(""), &held);
  assert_int_equal(held, 1);
  assert_int_equal(m->tiles.sample, 1101);
  assert_int_equal(m->n_disks, all->n_disks);
  assert_int_equal(m->n_free, all->n_free);
  assert_int_equal(m->n_segments, all->n_segments);
  for (size_t k = 0; k < m->n_segments; k++) assert_int_equal(m->segments[k].body, all->segments[k].body);
  assert_int_equal(m->motions[0].bodies[0], all->motions[0].bodies[0]);
  assert_string_equal(m->deck->full, all->deck->full);
  assert_memory_equal(&m->bounds, &all->bounds, sizeof m->bounds);
  assert_true(m->largest_radius >= all->largest_radius);
  assert_true(provenance_inputs(m) == provenance_inputs(all));
  for (size_t k = 1; k < m->n_disks; k++) {
    const sd_disk none = {0};
    assert_memory_equal(&m->disks[k], &none, sizeof none);
  }
  for (size_t tile = 0, placed; tile < 3; tile++)
    assert_int_equal(tiles_make(m, tile, &m->disks[1 + model_tile_begin(&m->tiles, tile)], &placed), SD_OK);
  for (size_t k = 1; k < m->n_disks; k++) {
    sd_disk a = m->disks[k], b = all->disks[k];
    assert_true(a.position[0] == b.position[0] && a.position[1] == b.position[1] && a.radius == b.radius);
    assert_true(a.mass == b.mass && a.inertia == b.inertia && a.material == b.material && a.group == b.group);
  }
  sd_model_free(m);
  sd_model_free(all);
}

/* What asks more of single disks than their forces reads the whole deck. */
static void test_tiles_that_stay(void **state) {
  (void)state;
  static const char *const more[] = {
      "measure = { contacts = (1, 3000); };",
      "forces = ( { group = \"grains\"; force = (1, 0); } );",
      "locks = ( { group = \"grains\"; coordinates = \"theta\"; } );",
      "fields = ( { type = \"drag\"; gamma = 1; group = \"grains\"; } );",
      "bounds = { y = (-1, 50); outside = \"report\"; };",
  };
  size_t held;
  for (size_t k = 0; k < sizeof more / sizeof *more; k++) {
    char text[4096];
    snprintf(text, sizeof text, "%s%s", TILES(""), more[k]);
    if (strstr(more[k], "phases")) memset(strstr(text, "steps"), ' ', strlen("steps = 10;"));
    sd_model *m = for_ranks(text, &held);
    if (!m) sd_messages_print(messages, stderr);
    if (m && held != 3302) print_error("%s\n", more[k]);
    if (m) assert_int_equal(held, 3302);
    const size_t n = m ? sd_messages_count(messages) : 0;
    if (m)
      assert_non_null(
          strstr(sd_messages_text(messages, n - 1), "packings[0].tiles: one rank makes all, since "));
    if (!m) print_error("%s\n", more[k]);
    assert_non_null(m);
    sd_model_free(m);
  }
  /* means of every disk are each rank's own */
  char means[4096];
  snprintf(means, sizeof means, "%smeasure = { disks = true; };", TILES(""));
  sd_model *m = for_ranks(means, &held);
  assert_true(m && m->tiles.away && held == 1);
  sd_model_free(m);
  /* the stream of a random motion of several walls goes by their numbers */
  char random[4096] = TILES("");
  strcpy(strstr(random, "motions"),
         "motions = ( { wall = (\"floor\", \"left\"); coordinate = \"x\"; type = \"random\"; "
         "amplitude = 0.1; frequency = 1; independent = false; } );\n");
  m = for_ranks(random, &held);
  assert_int_equal(held, 3302);
  sd_model_free(m);
  m = for_ranks(TILES("}, { type = \"square\"; count = 1; x = (0, 1); y = (55, 60); radius = 0.1; mass = 1;"),
                &held);
  assert_int_equal(held, 3303);
  sd_model_free(m);
}

/* Runs of disks of a rain: where they wait goes by their numbers. */
#define RAIN(tiles, rows)                                                                                    \
  HEAD "container = { type = \"box\"; width = 60; height = 40; };\n"                                         \
       "disks = ( { name = \"peg\"; x = 0; y = 20; radius = 1; mass = 1; fixed = true; } );\n"               \
       "packings = ( { type = \"rain\"; count = 3301; tiles = " tiles "; rows = " rows                       \
       "; sizes = \"uniform\"; "                                                                             \
       "lower = 0.2; upper = 0.4; density = 2; } );\n"

static void test_rain_of_ranks(void **state) {
  (void)state;
  size_t held;
  sd_model *all = good(RAIN("3", "2")), *m = for_ranks(RAIN("3", "2"), &held);
  assert_int_equal(sd_messages_count(messages), 0);
  assert_int_equal(held, 1);
  assert_int_equal(m->n_rains, 1);
  assert_memory_equal(m->rains, all->rains, sizeof *m->rains);
  assert_int_equal(all->rains[0].count, 3301);
  assert_memory_equal(&m->bounds, &all->bounds, sizeof m->bounds);
  assert_true(provenance_inputs(m) == provenance_inputs(all));
  for (size_t tile = 0, placed; tile < 3; tile++)
    assert_int_equal(tiles_make(m, tile, &m->disks[1 + model_tile_begin(&m->tiles, tile)], &placed), SD_OK);
  for (size_t k = 1; k < m->n_disks; k++) {
    const sd_disk *a = &m->disks[k], *b = &all->disks[k];
    assert_true(a->waiting && b->waiting && a->position[0] == b->position[0] &&
                a->position[1] == b->position[1]);
    assert_true(a->radius == b->radius && a->mass == b->mass && a->inertia == b->inertia);
    assert_true(a->position[1] - 0.4 >= all->tiles.lower[1] && a->position[1] + 0.4 <= all->tiles.upper[1]);
  }
  sd_model_free(m);
  sd_model_free(all);
  /* a batch that one tile does not hold */
  m = for_ranks(RAIN("3", "400"), &held);
  assert_int_equal(held, 3302);
  const char *why =
      "packings[0].tiles: one rank makes all, since tiles have fewer disks than a batch of rain";
  assert_non_null(strstr(sd_messages_text(messages, sd_messages_count(messages) - 1), why));
  sd_model_free(m);
  refused(RAIN("3302", "2"), "packings[0].tiles = 3302: expected at most one for each of the 3301 disks");
}

/* --- files -------------------------------------------------------------------------------------------------- */

enum { ROWS = 20011, WIDE = 150 };
static char table[160];
static double x[ROWS], y[ROWS], radius[ROWS], mass[ROWS];

/* A square lattice, which falls. */
static void fill(void) {
  for (size_t k = 0; k < ROWS; k++) {
    x[k] = (double)(k % WIDE) + 0.5;
    const size_t row = k / WIDE;
    y[k] = (double)row + 0.5;
    radius[k] = 0.3 + 0.1 * (double)(k % 7) / 7;
    mass[k] = radius[k] * radius[k];
  }
}

static void put_table(size_t n) {
  h5_file *file;
  snprintf(table, sizeof table, "%s/table.h5", folder_name);
  sd_messages_clear(messages);
  check(h5_new(&file, messages), messages);
  h5_put(file, "/disks/x", SD_F64, 1, &n, x, false);
  h5_put(file, "/disks/y", SD_F64, 1, &n, y, false);
  h5_put(file, "/disks/radius", SD_F64, 1, &n, radius, false);
  h5_put(file, "/disks/mass", SD_F64, 1, &n, mass, false);
  check(h5_save(file, -1, table, NULL, messages), messages);
}

#define FILES                                                                                                \
  HEAD "box = { x = (0, 150); periodic = \"x\"; };\n"                                                        \
       "disks = ( { name = \"peg\"; x = 9; y = 200; radius = 1; mass = 1; } );\n"                            \
       "disk_files = ( { file = \"table.h5\"; dataset = \"/disks\"; columns = (\"x\", \"y\", \"radius\", "   \
       "\"mass\"); omega = 2; group = \"grains\"; } );\n"

static void test_files_of_ranks(void **state) {
  (void)state;
  fill();
  put_table(ROWS);
  size_t held;
  sd_model *m = for_ranks(FILES, &held), *all;
  assert_non_null(m);
  assert_int_equal(sd_messages_count(messages), 0);
  assert_true(m->tiles.away);
  assert_int_equal(held, 1);
  assert_int_equal(m->n_disks, 1 + ROWS);
  check(sd_deck_load(path, 0, NULL, &all, messages), messages);
  assert_false(all->tiles.away);
  assert_true(m->tiles.inputs == all->tiles.inputs && m->tiles.inputs != 0);
  assert_true(provenance_inputs(m) == provenance_inputs(all));
  assert_string_equal(m->deck->full, all->deck->full);
  assert_memory_equal(&m->bounds, &all->bounds, sizeof m->bounds);
  assert_true(m->largest_radius == all->largest_radius);
  assert_true(m->limit_told == sd_model_step_limit(all).dt);
  static sd_disk disks[ROWS];
  static uint32_t number[ROWS];
  int64_t inputs;
  uint64_t sum = 0;
  for (size_t k = m->tiles.n, n = 0; k-- > 0;) {
    check(deck_make_part(m, k, disks, number, &inputs, messages), messages);
    sum += (uint64_t)inputs;
    n = model_tile_begin(&m->tiles, k + 1) - model_tile_begin(&m->tiles, k);
    for (size_t i = 0; i < n; i++) {
      assert_int_equal(number[i], model_tile_begin(&m->tiles, k) + i);
      assert_memory_equal(&disks[i], &all->disks[1 + number[i]], sizeof disks[i]);
    }
  }
  assert_int_equal(model_tile_begin(&m->tiles, m->tiles.n), ROWS);
  assert_true((int64_t)sum == m->tiles.inputs);
  /* another file is not read as if it were the same */
  put_table(ROWS - 12);
  sd_messages_clear(messages);
  assert_int_equal(deck_make_part(m, m->tiles.n - 1, disks, number, &inputs, messages), SD_ERROR_IO);
  assert_string_equal(sd_messages_text(messages, 0), "disk_files[0].file has changed while it was read");
  sd_model_free(all);
  check(sd_deck_load(path, 0, NULL, &all, messages), messages);
  assert_true(provenance_inputs(m) != provenance_inputs(all)); /* too short for parts */
  sd_model_free(all);
  mass[ROWS - 1] *= 1.5;
  put_table(ROWS);
  check(sd_deck_load(path, 0, NULL, &all, messages), messages);
  assert_true(provenance_inputs(m) != provenance_inputs(all));
  sd_model_free(all);
  sd_model_free(m);
}

/* All are read where the deck speaks of single ones, and where one of them is not like the first. */
static void test_files_that_stay(void **state) {
  (void)state;
  static const char *const more[] = {
      "locks = ( { disk = 20000; coordinates = \"x\"; } );",
      "forces = ( { group = \"grains\"; force = (1, 0); } );",
      "packings = ( { type = \"square\"; count = 1; x = (0, 9); y = (300, 310); radius = 1; mass = 1; } );"};
  size_t held;
  fill();
  put_table(ROWS);
  for (size_t k = 0; k < sizeof more / sizeof *more; k++) {
    char text[4096];
    snprintf(text, sizeof text, "%s%s", FILES, more[k]);
    sd_model *m = for_ranks(text, &held);
    assert_non_null(m);
    assert_false(m->tiles.away);
    assert_int_equal(m->n_disks, held);
    assert_int_equal(held, 1 + ROWS + (k == 2));
    sd_model_free(m);
  }
  char means[4096], fixed[4096];
  snprintf(means, sizeof means, "%smeasure = { disks = true; };", FILES);
  sd_model *m = for_ranks(means, &held);
  assert_true(m && m->tiles.away);
  sd_model_free(m);
  snprintf(fixed, sizeof fixed, "%.*s fixed = true; %s", (int)(strstr(FILES, "omega") - FILES), FILES,
           strstr(FILES, "group"));
  m = for_ranks(fixed, &held);
  assert_true(m && !m->tiles.away && held == 1 + ROWS);
  sd_model_free(m);
  /* the time step is too long for the last disk */
  mass[ROWS - 1] = 1e-7;
  put_table(ROWS);
  m = for_ranks(FILES, &held);
  assert_null(m);
  assert_non_null(strstr(sd_messages_text(messages, 0), "dt = 0.001"));
  /* the two last ones have the same centre; the last one overlaps a disk that the deck has, or its neighbour, by a little */
  static const struct {
    double x, y;
    const char *text;
  } places[] = {{60.5, 133.5, "row 20010: disk 20011 and disk 20010 have the same centre"},
                {9.2, 200, "row 20010: disk 20011 and disk \"peg\" overlap by "},
                {61.18, 133.5, NULL}};
  for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
    fill();
    x[ROWS - 2] = 60.5;
    y[ROWS - 2] = 133.5;
    x[ROWS - 1] = places[k].x;
    y[ROWS - 1] = places[k].y;
    put_table(ROWS);
    m = for_ranks(FILES, &held);
    assert_true(places[k].text ? !m : m && held == 1 + ROWS);
    const char *text = places[k].text ? places[k].text : "disk 20010 and disk 20011 overlap by 0.0";
    bool told = false;
    if (m) sd_model_advise(m, messages);
    for (size_t n = 0; n < sd_messages_count(messages); n++)
      told = told || strstr(sd_messages_text(messages, n), text);
    if (!told) sd_messages_print(messages, stderr);
    assert_true(told);
    sd_model_free(m);
  }
}

/* Materials and groups of a result that lie in turn, in another order in its state; keys that change nothing, and mistakes. */
#define TWO                                                                                                  \
  "dt = 1e-3; steps = 10; gravity = { g = 10; }; materials = ( { name = \"m\"; k_n = 10; }, { name = "       \
  "\"n\"; k_n = 9; } );\n"                                                                                   \
  "material_pairs = ( { materials = (\"m\", \"n\"); k_n = 9; } ); box = { x = (0, 150); periodic = \"x\"; "  \
  "};\n"
#define SOURCE(more) TWO "disk_files = ( { file = \"table.h5\"; " more " } );\n"

static void test_results_of_ranks(void **state) {
  (void)state;
  sd_simulation *run;
  size_t held;
  sd_model *m = good(
      TWO
      "packings = ( { type = \"square\"; count = 15000; x = (0, 150); y = (100, 201); radius = 0.5; density "
      "= 1; "
      "group = \"high\"; material = \"n\"; }, { type = \"square\"; count = 9000; x = (0, 150); y = (0, 61); "
      "radius = 0.4; density = 1; group = \"low\"; material = \"m\"; } );");
  check(sd_simulation_new(m, 1, &run, messages), messages);
  check(sd_simulation_save(run, table, messages), messages);
  sd_simulation_free(run);
  sd_model_free(m);
  static const char *const same[] = {"", "format = \"hdf5\"; contacts = false;", "omega = 1;"};
  for (size_t k = 0; k < sizeof same / sizeof *same; k++) {
    char text[2048];
    snprintf(text, sizeof text, SOURCE("%s"), same[k]);
    m = for_ranks(text, &held);
    sd_model *all;
    assert_true(m && m->tiles.away && held == 0 && m->n_disks == 24000);
    check(sd_deck_load(path, 0, NULL, &all, messages), messages);
    assert_true(provenance_inputs(m) == provenance_inputs(all));
    assert_int_equal(m->n_groups, 2);
    assert_string_equal(m->groups[0], "high");
    sd_disk *disks = calloc(24000, sizeof *disks);
    uint32_t *number = calloc(24000, sizeof *number);
    int64_t inputs;
    for (size_t part = 0; part < m->tiles.n; part++) {
      check(deck_make_part(m, part, disks, number, &inputs, messages), messages);
      for (size_t i = 0; i < model_tile_begin(&m->tiles, part + 1) - model_tile_begin(&m->tiles, part); i++)
        assert_memory_equal(&disks[i], &all->disks[number[i]], sizeof disks[i]);
    }
    free(disks);
    free(number);
    sd_model_free(all);
    sd_model_free(m);
  }
  const char *const overrides[] = {"dt=2e-3", "steps=5"};
  check(deck_load_for_ranks(path, 2, overrides, NULL, &m, messages), messages);
  assert_true(m->tiles.away && m->dt == 2e-3);
  sd_model_free(m);
  static const char *const wrong[] = {
      "format = 1;",         "contacts = 1;", "format = \"csv\";", "colour = 1;", "columns = (\"x\", \"z\");",
      "dataset = \"/none\";"};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    char text[2048];
    snprintf(text, sizeof text, SOURCE("%s"), wrong[k]);
    assert_null(for_ranks(text, &held));
    assert_true(sd_messages_errors(messages) > 0);
  }
  assert_null(for_ranks(TWO "disk_files = ( { dataset = \"x\"; } );", &held));
  assert_null(for_ranks(TWO "disk_files = ( { file = 3; } );", &held));
  assert_null(for_ranks(TWO "disk_files = ( { file = \"none.h5\"; } );", &held));
}

/* A result whose contacts come along: what ranks read of them, part by part, and make of it is what one process has. */
#define TOUCHING(more)                                                                                       \
  "dt = 1e-3; steps = 4; gravity = { g = 1; }; materials = ( { name = \"m\"; k_n = 100; k_t = 50; gamma_n "  \
  "= 1; mu = 0.3; cohesion = \"constant\"; pull_off = 0.1; range = 0.01; } ); box = { x = (0, 150); "        \
  "periodic = \"x\"; };\n"                                                                                   \
  "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );\n" more

static size_t count_turned(const sd_model *m, deck_turned *turned) {
  uint32_t *number = calloc(m->tiles.count, sizeof *number);
  deck_turned *rows = calloc(m->tiles.count, sizeof *rows);
  size_t n = 0;
  for (size_t part = 0; part < m->tiles.n; part++) {
    check(deck_make_turned(m, part, number, rows, messages), messages);
    for (size_t k = 0; k < model_tile_begin(&m->tiles, part + 1) - model_tile_begin(&m->tiles, part);
         k++, n++)
      turned[number[k]] = rows[k];
  }
  free(number);
  free(rows);
  return n;
}

static void save_touching(const char *to, const char *disks) {
  sd_simulation *run;
  char text[2048];
  snprintf(text, sizeof text, TOUCHING("%s"), disks);
  sd_model *m = good(text);
  check(sd_simulation_new(m, 1, &run, messages), messages);
  check(sd_simulation_advance(run, 4, messages), messages);
  check(sd_simulation_save(run, to, messages), messages);
  sd_simulation_free(run);
  sd_model_free(m);
}

static void test_contacts_of_ranks(void **state) {
  (void)state;
  enum { AT_ONCE = 10000 };
  size_t held;
  char one[sizeof table];
  snprintf(one, sizeof one, "%s/one.h5", folder_name);
  save_touching(one, "disks = ( { x = 75; y = 200; radius = 1; mass = 1; } );");
  save_touching(
      table, "packings = ( { type = \"square\"; count = 22500; x = (0, 150); y = (0, 160); spacing = 0.9998; "
             "radius = 0.4999; mass = 1; group = \"grains\"; } );");
  sd_model *all, *m;
  m = for_ranks(TOUCHING("disks = ( { x = 75; y = 200; radius = 1; mass = 1; } );\n"
                         "disk_files = ( { file = \"table.h5\"; contacts = true; } );"),
                &held);
  check(sd_deck_load(path, 0, NULL, &all, messages), messages);
  const sd_tiles *t = &m->tiles;
  assert_true(t->away && held == 1 && m->n_memories == 0 && !all->tiles.away);
  assert_in_range(all->n_memories, 40000, 50000);
  assert_int_equal(t->n_contacts, all->n_memories);
  assert_int_equal(t->n_kept, all->n_memories);
  assert_true(t->contact_inputs == all->tiles.contact_inputs && t->contact_inputs != 0);
  assert_true(provenance_inputs(m) == provenance_inputs(all));
  assert_string_equal(m->deck->bodies, all->deck->bodies);
  deck_turned *turned = calloc(t->count, sizeof *turned);
  sd_contact_memory *list = calloc(AT_ONCE, sizeof *list);
  assert_int_equal(count_turned(m, turned), t->count);
  uint64_t sum = 0;
  int64_t inputs;
  for (size_t at = 0; at < t->n_contacts; at += AT_ONCE) {
    const size_t n = t->n_contacts - at < AT_ONCE ? t->n_contacts - at : AT_ONCE;
    check(deck_make_contacts(m, at, n, list, &inputs, messages), messages);
    sum += (uint64_t)inputs;
    for (size_t k = 0; k < n; k++) {
      sd_contact_memory *c = &list[k];
      const sd_tile_wall *wall = c->b < t->count ? NULL : &t->walls[c->b - t->count];
      assert_true(deck_contact_is_kept(c, wall));
      deck_carry_contact(c, turned[c->a], wall ? (deck_turned){0} : turned[c->b], wall, t->forces_carried);
      c->a += 1;
      c->b = wall ? (uint32_t)m->n_disks + wall->wall : c->b + 1;
      assert_memory_equal(c, &all->memories[at + k], sizeof *c);
    }
  }
  assert_true((int64_t)sum == t->contact_inputs);
  sd_messages_clear(messages);
  assert_int_equal(deck_make_contacts(m, t->n_contacts, 1, list, &inputs, messages), SD_ERROR_IO);
  assert_string_equal(sd_messages_text(messages, 0), "disk_files[0].file has changed while it was read");
  free(turned);
  free(list);
  sd_model_free(m);
  sd_model_free(all);
  /* contacts of two files: all are read */
  m = for_ranks(TOUCHING("disk_files = ( { file = \"one.h5\"; contacts = true; }, { file = \"table.h5\"; "
                         "contacts = true; } );"),
                &held);
  assert_true(m && !m->tiles.away && m->n_memories > 40000 && m->tiles.n_contacts == 0);
  sd_model_free(m);
  unlink(one);
}

static int end(void **state) {
  tear_down(state);
  unlink(table);
  return remove_folder(state);
}

static int begin(void **state) {
  messages = sd_messages_new();
  return messages ? make_folder(state) : -1;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_tiles_of_ranks),    cmocka_unit_test(test_tiles_that_stay),
      cmocka_unit_test(test_rain_of_ranks),     cmocka_unit_test(test_files_of_ranks),
      cmocka_unit_test(test_files_that_stay),   cmocka_unit_test(test_results_of_ranks),
      cmocka_unit_test(test_contacts_of_ranks),
  };
  return cmocka_run_group_tests(tests, begin, end);
}
