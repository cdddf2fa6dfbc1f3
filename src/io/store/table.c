/* table.c: holds rows of results in memory and writes them to HDF5 files; see table.h. */
#include "io/store/table.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

void table_free(table *t) {
  for (size_t k = 0; k < t->n_columns; k++) {
    free(t->columns[k].path);
    free(t->columns[k].unit);
    free(t->columns[k].meaning);
    free(t->columns[k].data);
  }
  free(t->columns);
  *t = (table){0};
}

void table_add(table *t, const char *path, sd_type type, int rank, const size_t *dims,
               const char *unit, const char *meaning) {
  assert(t->n_rows == 0 && rank >= 0 && rank <= 2 && (rank == 0 || dims));
  t->columns = memory_grow(t->columns, t->n_columns + 1, sizeof *t->columns);
  table_column *c = &t->columns[t->n_columns++];
  *c = (table_column){.type = type, .rank = rank, .width = 1, .dims = {1, 1}};
  for (int k = 0; k < rank; k++) {
    c->dims[k] = dims[k];
    c->width *= dims[k];
  }
  c->path = memory_text(path);
  c->unit = memory_text(unit);
  c->meaning = memory_text(meaning);
}

void table_add_clock(table *t, const char *element) {
  char *step = format_text("%s/step", element), *time = format_text("%s/time", element);
  table_add(t, step, SD_I64, 0, NULL, "1", "steps since the start");
  table_add(t, time, SD_F64, 0, NULL, "time", "step * dt");
  free(step);
  free(time);
}

void table_add_observable(table *t, const char *group, const observable *o, const char *ending,
                          size_t n) {
  const size_t dims[2] = {n, o->width};
  const int values = o->width == 1 || o->width >= OBSERVABLE_CHOSEN ? 0 : 1,
            rank = n > 0 ? 1 + values : values;
  char *path = format_text("%s/%s%s", group, o->name, ending);
  table_add(t, path, observable_stored(o), rank, n > 0 ? dims : dims + 1, o->unit, o->meaning);
  free(path);
}

static size_t row_bytes(const table_column *c) { return c->width * sd_type_size(c->type); }

sd_status table_reserve(table *t, size_t n, sd_messages *messages) {
  if (t->n_rows + n <= t->capacity) return SD_OK;
  size_t capacity = t->n_rows + n + t->n_rows / 2;
  for (size_t k = 0; k < t->n_columns; k++) {
    table_column *c = &t->columns[k];
    if (!memory_resize_row(&c->data, capacity, row_bytes(c)))
      return sd_fail(messages, SD_ERROR_IO, "no memory for the results");
  }
  t->capacity = capacity;
  assert(t->n_rows + n <= t->capacity);
  return SD_OK;
}

void *table_cell(table *t, size_t column) {
  assert(column < t->n_columns && t->n_rows < t->capacity);
  table_column *c = &t->columns[column];
  return c->data + t->n_rows * row_bytes(c);
}

size_t table_put_clock(table *t, int64_t step, double dt) {
  double time = (double)step * dt;
  assert(t->n_columns >= 2 && t->columns[0].type == SD_I64 && t->columns[1].type == SD_F64);
  memcpy(table_cell(t, 0), &step, sizeof step);
  memcpy(table_cell(t, 1), &time, sizeof time);
  return 2;
}

void table_put(table *t, size_t column, size_t index, const observable *o, const void *row,
               size_t n) {
  void *cell = table_cell(t, column);
  assert(observable_stored(o) == t->columns[column].type);
  for (size_t k = 0; k < n; k++)
    observable_store(o, cell, index * n + k, observable_value(o, row, k));
}

void table_commit(table *t, size_t n) {
  t->n_rows += n;
  assert(t->n_rows <= t->capacity || t->n_columns == 0);
}

void table_clear(table *t) { t->n_rows = 0; }

size_t table_bytes(const table *t) {
  size_t bytes = 0;
  for (size_t k = 0; k < t->n_columns; k++) bytes += row_bytes(&t->columns[k]);
  return bytes * t->n_rows;
}

int table_shape(const table_column *c, size_t n_rows, size_t dims[H5_MAX_RANK]) {
  assert(c->rank >= 0 && c->rank < H5_MAX_RANK);
  dims[0] = n_rows;
  for (int k = 0; k < c->rank; k++) dims[k + 1] = c->dims[k];
  return c->rank + 1;
}

/* Returns the length of a path without "/value"; 0: it has another ending. */
static int element_of(const char *path) {
  return text_ends(path, "/value") ? (int)(strlen(path) - strlen("/value")) : 0;
}

/* Writes the units and descriptions of all columns, and links each element to the step and time of
 * the table. */
static void annotate(const table *t, h5_file *file) {
  for (size_t k = 0; k < t->n_columns; k++) {
    const table_column *c = &t->columns[k];
    h5_attr_text(file, c->path, "unit", c->unit);
    h5_attr_text(file, c->path, "description", c->meaning);
    int length = element_of(c->path);
    if (length == 0) continue;
    char *step = format_text("%.*s/step", length, c->path),
         *time = format_text("%.*s/time", length, c->path);
    if (strcmp(step, t->columns[0].path) != 0) {
      h5_link(file, t->columns[0].path, step);
      h5_link(file, t->columns[1].path, time);
    }
    free(step);
    free(time);
  }
}

void table_write(const table *t, h5_file *file) {
  for (size_t k = 0; k < t->n_columns; k++) {
    const table_column *c = &t->columns[k];
    size_t dims[H5_MAX_RANK];
    int rank = table_shape(c, t->n_rows, dims);
    h5_put(file, c->path, c->type, rank, dims, c->data, t->compress);
  }
  annotate(t, file);
}

void table_make(const table *t, h5_file *file, size_t n_rows) {
  for (size_t k = 0; k < t->n_columns; k++) {
    const table_column *c = &t->columns[k];
    size_t dims[H5_MAX_RANK];
    int rank = table_shape(c, n_rows, dims);
    h5_make(file, c->path, c->type, rank, dims, t->compress);
  }
  annotate(t, file);
}
