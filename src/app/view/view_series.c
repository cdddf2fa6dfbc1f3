/* view_series.c: see view_series.h. */
#include "app/view/view_series.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/json.h"
#include "base/memory.h"
#include "base/text.h"

#define CLOCK "/observables/kinetic_translation/time"
enum { MOST_ELEMENTS = 32, BLOCK = 1 << 16 }; /* of one quantity; numbers read at once */

/* Rows of all files, every `every`-th of which is told. */
typedef struct reader {
  const frames *f;
  size_t n, every, kept;
  size_t rows[2]; /* scratch */
  sd_status status;
  sd_messages *messages;
} reader;

static size_t rows_of(const h5_file *file, const char *path, size_t *width) {
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  if (!h5_exists(file, path) || h5_shape(file, path, &rank, dims, NULL) != SD_OK) return 0;
  *width = rank > 1 ? dims[1] : 1;
  return dims[0];
}

/* File k of those with series; NULL: it cannot be opened. To be released. */
static h5_file *open_source(reader *r, size_t k) {
  h5_file *file;
  r->status = stored_source(r->f, k, &file, r->messages);
  return file;
}

/* Rows first ... of one file into values[kept][width], from place `at` on; where the next file goes on. */
static size_t read_rows(reader *r, const h5_file *file, const char *path, size_t before, size_t n,
                        size_t width, size_t at, double *values) {
  size_t block = BLOCK / width > 0 ? BLOCK / width : 1;
  double *rows = memory_grow(NULL, block * width, sizeof *rows);
  for (size_t first = 0; r->status == SD_OK && first < n; first += block) {
    size_t have = n - first < block ? n - first : block;
    r->status = h5_get_values(file, path, SD_F64, first, have, width, rows, r->messages);
    for (size_t k = 0; r->status == SD_OK && k < have; k++) {
      size_t row = before + first + k;
      if (row % r->every != 0 && row + 1 != r->n) continue;
      memcpy(values + at++ * width, rows + k * width, width * sizeof *rows);
    }
  }
  free(rows);
  return at;
}

/* All kept rows of a dataset, to be freed. */
static double *read_all(reader *r, const char *path, size_t width) {
  double *values;
  if (!memory_row(&values, r->kept * width, sizeof *values)) {
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for the series");
    return NULL;
  }
  size_t before = 0, at = 0;
  for (size_t k = 0; r->status == SD_OK && k < r->f->n_sources; k++) {
    h5_file *file = open_source(r, k);
    size_t columns = width, n = file ? rows_of(file, path, &columns) : 0;
    if (r->status == SD_OK && columns != width)
      r->status = sd_fail(r->messages, SD_ERROR_IO, "%s: %s does not have %zu columns", r->f->sources[k].path,
                          path, width);
    if (r->status == SD_OK && before + n > r->n)
      r->status = sd_fail(r->messages, SD_ERROR_IO, "%s: %s is too long", r->f->sources[k].path, path);
    if (r->status == SD_OK && n > 0) at = read_rows(r, file, path, before, n, width, at, values);
    before += n;
    stored_release(r->f, file);
  }
  for (size_t k = at; k < r->kept * (width > 0); k++)
    for (size_t c = 0; c < width; c++) values[k * width + c] = NAN;
  return values;
}

static const char *section_of(const observable *o, bool energy) {
  if (energy) return "energy";
  if (o->width == OBSERVABLE_WALLS) return "walls";
  if (o->width == OBSERVABLE_GROUPS) return "groups";
  if (o->width == OBSERVABLE_CHOSEN || o->width == OBSERVABLE_WATCHED) return "disks";
  return strstr(o->name, "contacts") || strcmp(o->name, "outside") == 0 ? "contacts" : "region";
}

static void describe(json_t *meta, const observable *o, bool energy, const char *name) {
  json_array_append_new(json_object_get(meta, "series"),
                        json_pack("{s:o, s:s, s:s, s:s}", "name", json_text(name), "unit", o->unit,
                                  "description", o->meaning, "section", section_of(o, energy)));
}

/* "contacts", "angle[upper]", "wall_force_x[3]"; to be freed. */
static char *series_name(const sd_model *m, const h5_file *file, const observable *o, size_t k) {
  if (o->width == 1) return memory_text(o->name);
  uint32_t body = stored_body(m, file, o, k);
  const char *name = NULL;
  if (o->width == OBSERVABLE_GROUPS && k < m->n_groups) name = m->groups[k];
  if (body < m->n_disks) name = m->disks[body].name;
  if (body >= m->n_disks && body < sd_model_bodies(m)) name = m->walls[body - m->n_disks].name;
  if (name) return format_text("%s[%s]", o->name, name);
  return format_text("%s[%" PRIu32 "]", o->name, body < m->n_disks ? body : (uint32_t)k);
}

void view_series_each(const sd_model *m, json_t *meta, view_series_visitor *visit, void *user) {
  const observable_list *lists[] = {&energy_observables, &series_observables};
  size_t column = 2; /* behind step and time */
  for (size_t l = 0; l < 2; l++)
    for (const observable *o = lists[l]->rows; o < lists[l]->rows + lists[l]->n; o++) {
      if (o->when && !o->when(m)) continue;
      size_t width = observable_width(o, m);
      for (size_t k = 0; k < width && k < MOST_ELEMENTS; k++) {
        char *name = series_name(m, NULL, o, k);
        if (meta) describe(meta, o, l == 0, name);
        if (visit) visit(user, o, column, k, name);
        free(name);
      }
      column++;
    }
}

static void add_series(reader *r, view_chunk *c, json_t *meta, const observable *o, bool energy) {
  size_t width = 1;
  char path[96];
  snprintf(path, sizeof path, "/observables/%s/value", o->name);
  h5_file *file = open_source(r, 0);
  bool there = file && rows_of(file, path, &width) > 0 && width > 0;
  stored_release(r->f, file);
  if (!there || r->status != SD_OK) return;
  double *values = read_all(r, path, width);
  for (size_t k = 0; r->status == SD_OK && k < width && k < MOST_ELEMENTS; k++) {
    char *name = series_name(r->f->constants, r->f->base, o, k);
    view_chunk_add(c, name, VIEW_EXACT, SD_F64, values + k, r->kept, width);
    describe(meta, o, energy, name);
    free(name);
  }
  free(values);
}

sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows,
                           sd_messages *messages) {
  reader r = {.f = f, .messages = messages};
  *rows = 0;
  for (size_t k = 0; r.status == SD_OK && k < f->n_sources; k++) {
    size_t width;
    h5_file *file = open_source(&r, k);
    if (file) r.n += rows_of(file, CLOCK, &width);
    stored_release(f, file);
  }
  if (r.status != SD_OK || r.n == 0) return r.status;
  r.every = (r.n + VIEW_MOST_ROWS - 1) / VIEW_MOST_ROWS;
  r.kept = (r.n - 1) / r.every + 1 + ((r.n - 1) % r.every != 0);
  view_chunk_begin(c, true);
  double *time = read_all(&r, CLOCK, 1);
  if (r.status == SD_OK) view_chunk_add(c, "time", VIEW_EXACT, SD_F64, time, r.kept, 1);
  free(time);
  const observable_list *lists[] = {&energy_observables, &series_observables};
  for (size_t l = 0; l < 2; l++)
    for (size_t k = 0; r.status == SD_OK && k < lists[l]->n; k++)
      add_series(&r, c, meta, &lists[l]->rows[k], l == 0);
  json_object_set_new(meta, "series_rows",
                      json_pack("{s:I, s:I}", "stored", (json_int_t)r.n, "every", (json_int_t)r.every));
  *rows = r.kept;
  if (r.status != SD_OK) view_chunk_drop(c);
  return r.status;
}
