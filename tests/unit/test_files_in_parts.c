/* test_files_in_parts.c: decks whose last disks are in a large HDF5 file, of which each rank reads
 * some rows. */
#include <hdf5.h>

#include "io/store/h5.h"
#include "slipdisk/simulation.h"
#define SCRATCH_NAME "files"
#include "scratch_file.h"
#include "packings_decks.h"
#include "ranks_deck.h"

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

#define FILES                                                                                      \
  HEAD "box = { x = (0, 150); periodic = \"x\"; };\n"                                              \
       "disks = ( { name = \"peg\"; x = 9; y = 200; radius = 1; mass = 1; } );\n"                  \
       "disk_files = ( { file = \"table.h5\"; dataset = \"/disks\"; columns = (\"x\", \"y\", "     \
       "\"radius\", "                                                                              \
       "\"mass\"); omega = 2; group = \"grains\"; } );\n"

static void test_files_of_ranks(void **state) {
  fill();
  put_table(ROWS);
  sd_model *all = alone(FILES);
  const int64_t inputs = all->tiles.inputs;
  assert_true(!all->tiles.away && inputs != 0);
  for (int ranks = 2; ranks <= RANKS; ranks++) {
    reading r = read_deck(FILES, ranks, 0, NULL);
    check_rows(&r, all, 1);
    check_numbers(&r, all);
    for (int q = 0; q < ranks; q++) {
      assert_int_equal(sd_messages_count(r.messages[q]), 0);
      assert_true(r.model[q]->tiles.inputs == inputs);
    }
    end_reading(&r);
  }
  sd_model_free(all);
  /* other files have other sums, also where they are read as a whole */
  put_table(ROWS - 12);
  all = alone(FILES);
  assert_true(all->tiles.inputs != inputs);
  sd_model_free(all);
  mass[ROWS - 1] *= 1.5;
  put_table(ROWS);
  all = alone(FILES);
  assert_true(all->tiles.inputs != inputs);
  sd_model_free(all);
}

/* All ranks read all where the deck speaks of single disks of the file, or all must know some of
 * them. */
static void test_files_that_stay(void **state) {
  static const char packing[] = "packings = ( { type = \"square\"; count = 1; x = (0, 9); "
                                "y = (300, 310); radius = 1; mass = 1; } );";
  static const char *const more[] = {"locks = ( { disk = 20000; coordinates = \"x\"; } );",
                                     "forces = ( { group = \"grains\"; force = (1, 0); } );",
                                     packing};
  fill();
  put_table(ROWS);
  for (size_t k = 0; k < sizeof more / sizeof *more; k++) {
    char text[4096];
    snprintf(text, sizeof text, "%s%s", FILES, more[k]);
    reading r = read_deck(text, 2, 0, NULL);
    assert_non_null(r.model[1]);
    assert_false(r.model[1]->tiles.away);
    assert_int_equal(r.model[1]->n_disks, 1 + ROWS + (k == 2));
    end_reading(&r);
  }
  char means[4096], fixed[4096];
  snprintf(means, sizeof means, "%smeasure = { disks = true; };", FILES);
  reading r = read_deck(means, 2, 0, NULL);
  assert_true(r.model[0] && r.model[0]->tiles.away);
  end_reading(&r);
  snprintf(fixed, sizeof fixed, "%.*s fixed = true; %s", (int)(strstr(FILES, "omega") - FILES),
           FILES, strstr(FILES, "group"));
  r = read_deck(fixed, 2, 0, NULL);
  assert_true(r.model[1] && !r.model[1]->tiles.away && model_held(r.model[1]) == 1 + ROWS);
  end_reading(&r);
}

/* Rows are looked at by the ranks that have them: their messages have the numbers of the deck.
 * Whether disks overlap is seen when the run begins (test_ranks_mpi.py). */
static void test_mistakes_in_files(void **state) {
  static const struct {
    double *column, value;
    const char *says;
  } rows[] = {
      {mass, 1e-7, "dt = 0.001"},
      {mass, -1, "table.h5: row 20010: mass: -1: expected a number > 0"},
      {x, 151, "row 20010: disk 20011: x = 151 lies outside the periodic box from 0 to 150"},
      {x, NAN, "row 20010: x = nan: expected a number"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    fill();
    rows[k].column[ROWS - 1] = rows[k].value;
    put_table(ROWS);
    reading r = read_deck(FILES, 2, 0, NULL);
    assert_null(r.model[0]);
    if (!any_says(&r, rows[k].says))
      for (int q = 0; q < 2; q++) sd_messages_print(r.messages[q], stderr);
    assert_true(any_says(&r, rows[k].says));
    end_reading(&r);
  }
  fill();
  y[ROWS - 1] = 0.1;
  put_table(ROWS);
  char text[4096];
  snprintf(text, sizeof text,
           "%swalls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );",
           FILES);
  reading r = read_deck(text, 2, 0, NULL);
  assert_null(r.model[0]);
  assert_true(any_says(&r, "row 20010: disk 20011 sits "));
  end_reading(&r);
  y[ROWS - 1] = -9;
  put_table(ROWS);
  snprintf(text, sizeof text, "%sbounds = { y = (-1, 900); };", FILES);
  r = read_deck(text, 2, 0, NULL);
  assert_null(r.model[0]);
  assert_true(any_says(&r, "row 20010: disk 20011 at (60.5, -9) starts outside the bounds"));
  end_reading(&r);
}

/* Materials and groups of a result that lie in turn, in another order in its state; keys that
 * change nothing, and mistakes. */
#define TWO                                                                                        \
  "dt = 1e-3; steps = 10; gravity = { g = 10; }; materials = ( { name = \"m\"; k_n = 10; }, { "    \
  "name = "                                                                                        \
  "\"n\"; k_n = 9; } );\n"                                                                         \
  "material_pairs = ( { materials = (\"m\", \"n\"); k_n = 9; } ); box = { x = (0, 150); periodic " \
  "= \"x\"; "                                                                                      \
  "};\n"
#define SOURCE(more) TWO "disk_files = ( { file = \"table.h5\"; " more " } );\n"

static void test_results_of_ranks(void **state) {
  sd_simulation *run;
  sd_model *m = alone(TWO "packings = ( { type = \"square\"; count = 15000; x = (0, 150); y = "
                          "(100, 201); radius = 0.5; density = 1; group = \"high\"; material = "
                          "\"n\"; }, { type = \"square\"; count = 9000; x = (0, 150); y = (0, "
                          "61); radius = 0.4; density = 1; group = \"low\"; material = \"m\"; } "
                          ");");
  check(sd_simulation_new(m, 1, &run, messages), messages);
  check(sd_simulation_save(run, table, messages), messages);
  sd_simulation_free(run);
  sd_model_free(m);
  static const char *const same[] = {"", "format = \"hdf5\"; contacts = false;", "omega = 1;"};
  for (size_t k = 0; k < sizeof same / sizeof *same; k++) {
    char text[2048];
    snprintf(text, sizeof text, SOURCE("%s"), same[k]);
    sd_model *all = alone(text);
    reading r = read_deck(text, RANKS, 0, NULL);
    check_rows(&r, all, 0);
    check_numbers(&r, all);
    for (int q = 0; q < RANKS; q++) {
      assert_int_equal(r.model[q]->n_groups, 2);
      assert_string_equal(r.model[q]->groups[0], "high");
      assert_string_equal(r.model[q]->groups[1], "low");
    }
    end_reading(&r);
    sd_model_free(all);
  }
  const char *const overrides[] = {"dt=2e-3", "steps=5"};
  reading r = read_deck(SOURCE(""), 2, 2, overrides);
  assert_true(r.model[1]->tiles.away && r.model[1]->dt == 2e-3);
  end_reading(&r);
  static const char *const wrong[] = {"format = 1;",
                                      "contacts = 1;",
                                      "format = \"csv\";",
                                      "colour = 1;",
                                      "columns = (\"x\", \"z\");",
                                      "dataset = \"/none\";"};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    char text[2048];
    snprintf(text, sizeof text, SOURCE("%s"), wrong[k]);
    r = read_deck(text, 2, 0, NULL);
    assert_null(r.model[0]);
    for (int q = 0; q < 2; q++) assert_true(sd_messages_errors(r.messages[q]) > 0);
    end_reading(&r);
  }
  static const char *const no_file[] = {TWO "disk_files = ( { dataset = \"x\"; } );",
                                        TWO "disk_files = ( { file = 3; } );",
                                        TWO "disk_files = ( { file = \"none.h5\"; } );"};
  for (size_t k = 0; k < sizeof no_file / sizeof *no_file; k++) {
    r = read_deck(no_file[k], 2, 0, NULL);
    assert_null(r.model[0]);
    end_reading(&r);
  }
}

/* A result whose contacts come along: what ranks read of them, part by part, and make of it is what
 * one process has. */
#define TOUCHING(more)                                                                             \
  "dt = 1e-3; steps = 4; gravity = { g = 1; }; materials = ( { name = \"m\"; k_n = 100; k_t = "    \
  "50; gamma_n "                                                                                   \
  "= 1; mu = 0.3; cohesion = \"constant\"; pull_off = 0.1; range = 0.01; } ); box = { x = (0, "    \
  "150); "                                                                                         \
  "periodic = \"x\"; };\n"                                                                         \
  "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );\n" more

static void save_touching(const char *to, const char *disks) {
  sd_simulation *run;
  char text[2048];
  snprintf(text, sizeof text, TOUCHING("%s"), disks);
  sd_model *m = alone(text);
  check(sd_simulation_new(m, 1, &run, messages), messages);
  check(sd_simulation_advance(run, 4, messages), messages);
  check(sd_simulation_save(run, to, messages), messages);
  sd_simulation_free(run);
  sd_model_free(m);
}

/* Contacts of all ranks, turned into those of the model, are those of one process. */
static void check_contacts(const reading *r, const sd_model *all) {
  const sd_tiles *t = &r->model[0]->tiles;
  disk_angle_shift *turned = calloc(t->count, sizeof *turned);
  size_t n = 0;
  for (int q = 0; q < r->ranks; q++) {
    const sd_rows *mine = r->model[q]->mine;
    for (size_t k = 0; k < mine->n; k++)
      turned[mine->number[k] - t->first] = (disk_angle_shift){mine->disk[k].radius, mine->shift[k]};
  }
  for (int q = 0; q < r->ranks; q++) {
    const sd_model *m = r->model[q];
    assert_int_equal(m->n_memories, 0);
    assert_int_equal(m->all_memories, all->n_memories);
    for (size_t k = 0; k < m->mine->n_contacts; k++) {
      sd_contact_memory c = m->mine->contacts[k];
      const sd_tile_wall *wall = c.b < t->count ? NULL : &t->walls[c.b - t->count];
      assert_true(deck_contact_is_kept(&c, wall));
      deck_carry_contact(&c, turned[c.a], wall ? (disk_angle_shift){0} : turned[c.b], wall,
                         t->forces_carried);
      c.a += 1;
      c.b = wall ? (uint32_t)m->n_disks + wall->wall : c.b + 1;
      assert_memory_equal(&c, &all->memories[n++], sizeof c);
    }
  }
  assert_int_equal(n, all->n_memories);
  free(turned);
}

static void test_contacts_of_ranks(void **state) {
  char one[sizeof table];
  snprintf(one, sizeof one, "%s/one.h5", folder_name);
  save_touching(one, "disks = ( { x = 75; y = 200; radius = 1; mass = 1; } );");
  save_touching(table, "packings = ( { type = \"square\"; count = 22500; x = (0, 150); y = (0, "
                       "160); spacing = 0.9998; "
                       "radius = 0.4999; mass = 1; group = \"grains\"; } );");
  const char *text = TOUCHING("disks = ( { x = 75; y = 200; radius = 1; mass = 1; } );\n"
                              "disk_files = ( { file = \"table.h5\"; contacts = true; } );");
  sd_model *all = alone(text);
  assert_in_range(all->n_memories, 40000, 50000);
  for (int ranks = 2; ranks <= RANKS; ranks++) {
    reading r = read_deck(text, ranks, 0, NULL);
    check_rows(&r, all, 1);
    check_numbers(&r, all);
    check_contacts(&r, all);
    assert_string_equal(r.model[1]->deck->bodies, all->deck->bodies);
    assert_true(r.model[1]->tiles.contact_inputs == all->tiles.contact_inputs &&
                all->tiles.contact_inputs != 0);
    end_reading(&r);
  }
  sd_model_free(all);
  /* walls that the deck describes in another way */
  char other[2048];
  snprintf(other, sizeof other, "%s", text);
  memcpy(strstr(other, "(1, 0)"), "(2, 0)", 6);
  all = alone(other);
  reading r = read_deck(other, 2, 0, NULL);
  check_contacts(&r, all);
  char lost[400] = "";
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strstr(sd_messages_text(messages, k), "contacts are with walls"))
      snprintf(lost, sizeof lost, "%s", sd_messages_text(messages, k));
  for (int q = 0; *lost && q < 2; q++) assert_true(says(r.messages[q], lost));
  end_reading(&r);
  sd_model_free(all);
  /* contacts of two files: all are read */
  r = read_deck(
      TOUCHING("disk_files = ( { file = \"one.h5\"; contacts = true; }, { file = \"table.h5\"; "
               "contacts = true; } );"),
      2, 0, NULL);
  assert_true(r.model[1] && !r.model[1]->tiles.away && r.model[1]->n_memories > 40000 &&
              r.model[1]->tiles.n_contacts == 0);
  end_reading(&r);
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
  hbool_t safe = false;
  if (H5is_library_threadsafe(&safe) < 0 || !safe) {
    puts("left out: this HDF5 is not for several threads, which are the ranks here");
    return 0;
  }
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_files_of_ranks),    cmocka_unit_test(test_files_that_stay),
      cmocka_unit_test(test_mistakes_in_files), cmocka_unit_test(test_results_of_ranks),
      cmocka_unit_test(test_contacts_of_ranks),
  };
  return cmocka_run_group_tests(tests, begin, end);
}
