/* test_checkpoint.c: a state survives its way through a file in every bit, and a run that went that way
 * continues as one that did not; damaged files are told from good ones; tables are read from HDF5. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <unistd.h>

#include "brief.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/deck.h"

#define SCRATCH_NAME "checkpoint"
#include "scratch_file.h"

static void write_state(sd_simulation *simulation, sd_messages *messages) {
  const sd_model *model = sd_simulation_model(simulation);
  const sd_state *state = sd_simulation_state(simulation);
  sd_energy energy = sd_simulation_energy(simulation);
  provenance origin;
  summary found;
  provenance_new(&origin, model);
  provenance_refresh(&origin, 1, 1, sd_simulation_path(simulation));
  summary_collect(&found, model, state, NULL, &energy, NAN);
  check(summary_disks_collect(&found.packing, model, state, 2, messages), messages);
  checkpoint_parts parts = {.n = 3, .last = 7, .replaces = ""};
  check(checkpoint_write(-1, path, state, &parts, NULL, &origin, &found, messages), messages);
  summary_free(&found);
  provenance_free(&origin);
}

/* Looking at a simulation changes nothing. */
static void test_reading_is_free(void **unused) {
  char name[512];
  snprintf(name, sizeof name, "%s/inputs/three_disk/random.cfg", SLIPDISK_SOURCE_DIR);
  sd_messages *messages = sd_messages_new();
  sd_model *model;
  check(sd_deck_load(name, 0, NULL, &model, messages), messages);
  sd_simulation *one, *two;
  check(sd_simulation_new(model, 1, &one, messages), messages);
  check(sd_simulation_new(model, 1, &two, messages), messages);
  check(sd_simulation_advance(one, 30000, messages), messages);
  for (int k = 0; k < 300; k++) {
    check(sd_simulation_advance(two, 100, messages), messages);
    if (k % 3 == 0) write_state(two, messages);
    if (k % 3 == 1) sd_simulation_state(two);
    if (k % 3 == 2) sd_simulation_energy(two);
  }
  assert_null(sd_state_difference(sd_simulation_state(one), sd_simulation_state(two)));
  sd_simulation_free(one);
  sd_simulation_free(two);
  sd_model_free(model);
  sd_messages_free(messages);
}

static void test_damage_is_found(void **unused) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  double data[1000];
  size_t n = 1000;
  for (size_t k = 0; k < n; k++) data[k] = (double)k;
  check(h5_new(&file, messages), messages);
  h5_put(file, "/a/b", SD_F64, 1, &n, data, false);
  check(h5_save(file, -1, path, NULL, messages), messages);
  unsigned char *bytes;
  size_t size;
  check(file_read(path, SIZE_MAX, &bytes, &size, messages), messages);
  for (size_t at = 0; at < size; at += BRIEF(97, 397)) {
    bytes[at] ^= 4;
    check(file_write_atomic(path, bytes, size, messages), messages);
    assert_int_equal(h5_open_sealed(-1, path, &file, NULL, NULL), SD_ERROR_IO);
    bytes[at] ^= 4;
  }
  const size_t lengths[] = {0, 1, 23, 24, 25, size - 1, size / 2};
  for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
    check(file_write_atomic(path, bytes, lengths[k], messages), messages);
    assert_int_equal(h5_open_sealed(-1, path, &file, NULL, NULL), SD_ERROR_IO);
  }
  free(bytes);
  assert_int_equal(h5_open_sealed(-1, "/nonexistent/x", &file, NULL, NULL), SD_ERROR_IO);
  assert_int_equal(h5_open(path, &file, NULL), SD_ERROR_IO);
  sd_messages_free(messages);
}

/* Columns that meant something else would be taken for what they are not. */
static void test_other_formats_are_refused(void **unused) {
  const int64_t formats[] = {CHECKPOINT_FORMAT - 1, CHECKPOINT_FORMAT + 1};
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  check(
      sd_deck_load(SLIPDISK_SOURCE_DIR "/inputs/three_disk/random.cfg", 0, NULL, &model, messages),
      messages);
  for (size_t k = 0; k < 2; k++) {
    sd_messages *told = sd_messages_new();
    h5_file *file;
    sd_state *state = NULL;
    check(h5_new(&file, messages), messages);
    h5_group(file, "/state");
    h5_attr_i64(file, "/state", "format", formats[k]);
    check(h5_save(file, -1, path, NULL, messages), messages);
    check(h5_open_sealed(-1, path, &file, NULL, messages), messages);
    assert_int_equal(checkpoint_get_state(file, model, &state, told), SD_ERROR_USER);
    assert_null(state);
    assert_non_null(strstr(sd_messages_text(told, 0), "is stored in format"));
    h5_close(file, NULL);
    sd_messages_free(told);
  }
  sd_model_free(model);
  sd_messages_free(messages);
}

static void test_errors_are_told_once(void **unused) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  size_t n = 2;
  double data[2] = {1, 2};
  check(h5_new(&file, messages), messages);
  h5_put(file, "/a", SD_F64, 1, &n, data, false);
  h5_put(file, "/a", SD_F64, 1, &n, data, false); /* there already */
  h5_put(file, "/a/b", SD_F64, 1, &n, data, false);
  assert_true(h5_failed(file));
  assert_int_equal(h5_save(file, -1, path, NULL, messages), SD_ERROR_IO);
  assert_int_equal(sd_messages_errors(messages), 1);
  assert_int_equal(file_write_atomic("/nonexistent/x", "x", 1, messages), SD_ERROR_IO);
  assert_int_equal(file_write_atomic("/dev/null/x", "x", 1, messages), SD_ERROR_IO);
  sd_messages_free(messages);
}

static void test_h5_round_trip(void **unused) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  size_t dims[3] = {500, 7, 2}, none = 0;
  int32_t *data = calloc(7000, sizeof *data), *back = calloc(7000, sizeof *back);
  for (int k = 0; k < 7000; k++) data[k] = k * k;
  check(h5_new(&file, messages), messages);
  h5_put(file, "/deep/er/data", SD_I32, 3, dims, data, true);
  h5_put(file, "/empty", SD_F64, 1, &none, NULL, true);
  h5_put_text(file, "/text", "Größe\nline");
  h5_put_text(file, "/nothing", "");
  h5_attr_f64(file, "/text", "x", 0.1);
  h5_attr_text(file, "/", "note", "hello");
  h5_make(file, "/rows", SD_I32, 3, dims, true);
  for (size_t k = 0; k < 500; k += 13)
    h5_put_rows(file, "/rows", SD_I32, k, k + 13 > 500 ? 500 - k : 13, data + 14 * k);
  check(h5_save(file, -1, path, NULL, messages), messages);

  check(h5_open_sealed(-1, path, &file, NULL, messages), messages);
  check(h5_get(file, "/deep/er/data", SD_I32, 7000, back, messages), messages);
  assert_memory_equal(data, back, 7000 * sizeof *data);
  memset(back, 0, 7000 * sizeof *back);
  check(h5_get(file, "/rows", SD_I32, 7000, back, messages), messages);
  assert_memory_equal(data, back, 7000 * sizeof *data);
  char *text = h5_get_text(file, "/text");
  assert_string_equal(text, "Größe\nline");
  free(text);
  text = h5_get_text(file, "/nothing");
  assert_string_equal(text, "");
  free(text);
  text = h5_get_attr_text(file, "/", "note");
  assert_string_equal(text, "hello");
  free(text);
  assert_true(h5_get_attr_f64(file, "/text", "x", 0) == 0.1);
  assert_int_equal(h5_get_attr_i64(file, "/text", "y", 17), 17);
  assert_null(h5_get_text(file, "/deep/none"));
  assert_int_equal(h5_get(file, "/empty", SD_F64, 0, NULL, messages), SD_OK);
  assert_int_equal(h5_get(file, "/empty", SD_F64, 3, back, NULL), SD_ERROR_IO);
  assert_int_equal(h5_get_values(file, "/rows", SD_I32, 499, 2, 14, back, NULL), SD_ERROR_IO);
  assert_int_equal(h5_get_values(file, "/rows", SD_I32, 0, 2, 7, back, NULL), SD_ERROR_IO);
  h5_close(file, NULL);
  free(data);
  free(back);
  sd_messages_free(messages);
}

/* Columns of a group, of a matrix with names, and of the last frame of an H5MD file. */
static void test_tables(void **unused) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  size_t three = 3, frames[3] = {2, 3, 2}, matrix[2] = {3, 2};
  const double x[3] = {1, 2, 3}, position[12] = {0, 0, 0, 0, 0, 0, 1, 4, 2, 5, 3, 6};
  const int32_t radius[3] = {7, 8, 9};
  const char *const names[2] = {"radius", "x"};
  check(h5_new(&file, messages), messages);
  h5_put(file, "/group/x", SD_F64, 1, &three, x, false);
  h5_put(file, "/group/radius", SD_I32, 1, &three, radius, false);
  h5_put(file, "/matrix", SD_F64, 2, matrix, position + 6, false);
  h5_put(file, "/named", SD_F64, 2, matrix, position + 6, false);
  h5_attr_texts(file, "/named", "columns", 2, names);
  h5_put(file, "/particles/disks/position/value", SD_F64, 3, frames, position, false);
  h5_put(file, "/particles/disks/radius", SD_I32, 1, &three, radius, false);
  check(h5_save(file, -1, path, NULL, messages), messages);

  const char *const columns[2] = {"x", "radius"}, *const both[3] = {"x", "y", "radius"};
  const struct {
    const char *dataset;
    size_t n_columns;
    const char *const *columns;
    double expected[9];
  } forms[] = {{"/group", 2, columns, {1, 7, 2, 8, 3, 9}},
               {"named", 2, columns, {4, 1, 5, 2, 6, 3}},
               {"/particles/disks", 3, both, {1, 4, 7, 2, 5, 8, 3, 6, 9}}};
  double *values;
  h5_range r;
  for (size_t k = 0; k < sizeof forms / sizeof *forms; k++) {
    /* all, some, what is left, and none */
    static const size_t asked[][3] = {{0, SIZE_MAX, 3}, {1, 1, 1}, {1, 7, 2}, {3, 1, 0}, {5, 1, 0}};
    for (size_t n = 0; n < sizeof asked / sizeof *asked; n++) {
      r = (h5_range){.first = asked[n][0], .n = asked[n][1]};
      check(h5_read_table(path, forms[k].dataset, forms[k].n_columns, forms[k].columns, &values, &r,
                          messages),
            messages);
      assert_int_equal(r.all, 3);
      assert_int_equal(r.n, asked[n][2]);
      assert_memory_equal(values, forms[k].expected + (r.n ? r.first * forms[k].n_columns : 0),
                          r.n * forms[k].n_columns * sizeof *values);
      free(values);
    }
  }

  const char *const wrong[3] = {"x", "width", "height"};
  assert_int_equal(h5_read_table(path, "/matrix", 2, columns, &values, &r, NULL),
                   SD_ERROR_USER); /* no names */
  assert_int_equal(h5_read_table(path, "/group", 3, wrong, &values, &r, messages), SD_ERROR_USER);
  assert_int_equal(sd_messages_errors(messages), 2); /* each missing column */
  assert_null(values);
  assert_int_equal(h5_read_table(path, "/named", 3, wrong, &values, &r, NULL), SD_ERROR_USER);
  assert_int_equal(h5_read_table(path, "/nowhere", 2, columns, &values, &r, NULL), SD_ERROR_USER);
  assert_int_equal(h5_read_table("/nonexistent", "/x", 2, columns, &values, &r, NULL), SD_ERROR_IO);
  sd_messages_free(messages);
}

RUN_TESTS_BETWEEN(make_folder, remove_folder, TEST(test_reading_is_free),
                  TEST(test_damage_is_found), TEST(test_errors_are_told_once),
                  TEST(test_h5_round_trip), TEST(test_tables), TEST(test_other_formats_are_refused))
