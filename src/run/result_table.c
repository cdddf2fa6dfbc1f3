/* result_table.c: see result_table.h. */
#include "run/result_table.h"

#include <fnmatch.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

result_column *result_table_find(const result_table *s, const char *name) {
  for (size_t k = 0; k < s->n_columns; k++)
    if (strcmp(s->columns[k].name, name) == 0) return &s->columns[k];
  return NULL;
}

static void allocate(result_column *c, result_kind kind, size_t n) {
  if (kind == RESULT_TEXT) c->text = memory_new(n, sizeof *c->text);
  if (kind == RESULT_NUMBER) {
    c->number = memory_new(n, sizeof *c->number);
    for (size_t k = 0; k < n; k++) c->number[k] = NAN;
  }
  if (kind == RESULT_INTEGER) {
    c->integer = memory_new(n, sizeof *c->integer);
    for (size_t k = 0; k < n; k++) c->integer[k] = RESULT_EMPTY;
  }
}

/* NULL: a column of this name holds something else. */
static result_column *column(result_table *s, result_kind kind, const char *name, const char *unit,
                             const char *meaning) {
  result_column *c = result_table_find(s, name);
  if (c) return c->kind == kind ? c : NULL;
  s->columns = memory_grow(s->columns, s->n_columns + 1, sizeof *s->columns);
  c = &s->columns[s->n_columns++];
  *c = (result_column){.name = memory_text(name), .kind = kind, .unit = unit, .meaning = meaning};
  allocate(c, kind, s->n_rows);
  return c;
}

void result_table_number(result_table *s, size_t row, const char *name, const char *unit,
                         const char *meaning, double x) {
  result_column *c = column(s, RESULT_NUMBER, name, unit, meaning);
  if (c) c->number[row] = x;
}

void result_table_integer(result_table *s, size_t row, const char *name, const char *meaning,
                          int64_t x) {
  result_column *c = column(s, RESULT_INTEGER, name, "1", meaning);
  if (c) c->integer[row] = x;
}

void result_table_text(result_table *s, size_t row, const char *name, const char *meaning,
                       const char *text) {
  result_column *c = column(s, RESULT_TEXT, name, "", meaning);
  if (!c) return;
  free(c->text[row]);
  c->text[row] = memory_text(text);
}

void result_table_keep_all(result_table *s) {
  for (size_t k = 0; k < s->n_columns; k++) s->columns[k].always = true;
}

static void column_free(result_column *c, size_t n) {
  for (size_t k = 0; c->text && k < n; k++) free(c->text[k]);
  free(c->text);
  free(c->number);
  free(c->integer);
  free(c->name);
}

void result_table_collect(result_table *s, size_t n, const char *const *patterns,
                          sd_messages *messages) {
  if (n == 0) return;
  for (size_t p = 0; p < n; p++) {
    bool any = false;
    for (size_t k = 0; k < s->n_columns; k++)
      any = any || fnmatch(patterns[p], s->columns[k].name, 0) == 0;
    if (!any) sd_warn(messages, "collect: \"%s\" is no column of the table", patterns[p]);
  }
  size_t kept = 0;
  for (size_t k = 0; k < s->n_columns; k++) {
    bool keep = s->columns[k].always;
    for (size_t p = 0; p < n; p++) keep = keep || fnmatch(patterns[p], s->columns[k].name, 0) == 0;
    if (keep)
      s->columns[kept++] = s->columns[k];
    else
      column_free(&s->columns[k], s->n_rows);
  }
  s->n_columns = kept;
}

void result_table_free(result_table *s) {
  for (size_t k = 0; k < s->n_columns; k++) column_free(&s->columns[k], s->n_rows);
  free(s->columns);
  *s = (result_table){0};
}

/* --- CSV --------------------------------------------------------------------------------------------------- */

static void put_number(FILE *out, double x) {
  char text[40];
  if (isnan(x)) return;
  for (int digits = 6; digits <= 17; digits++) {
    snprintf(text, sizeof text, "%.*g", digits, x);
    if (strtod(text, NULL) == x) break;
  }
  fputs(text, out);
}

static void put_cell(FILE *out, const result_column *c, size_t row) {
  if (c->kind == RESULT_NUMBER) put_number(out, c->number[row]);
  if (c->kind == RESULT_INTEGER && c->integer[row] != RESULT_EMPTY)
    fprintf(out, "%" PRId64, c->integer[row]);
  if (c->kind == RESULT_TEXT && c->text[row]) text_cell(out, c->text[row]);
}

sd_status result_table_write_csv(const result_table *s, const char *path, sd_messages *messages) {
  char *text = NULL;
  size_t size = 0;
  FILE *out = open_memstream(&text, &size);
  if (!out) memory_lacks(0);
  for (size_t k = 0; k < s->n_columns; k++) {
    if (k > 0) fputc(',', out);
    text_cell(out, s->columns[k].name);
  }
  fputc('\n', out);
  for (size_t row = 0; row < s->n_rows; row++) {
    for (size_t k = 0; k < s->n_columns; k++) {
      if (k > 0) fputc(',', out);
      put_cell(out, &s->columns[k], row);
    }
    fputc('\n', out);
  }
  if (fclose(out) != 0) memory_lacks(0);
  sd_status status = file_write_atomic(path, text, size, messages);
  free(text);
  return status;
}

/* --- HDF5 -------------------------------------------------------------------------------------------------- */

void result_table_write_h5(const result_table *s, h5_file *file, const char *group) {
  int64_t *integer = memory_new(s->n_rows, sizeof *integer);
  h5_group(file, group);
  for (size_t k = 0; k < s->n_columns; k++) {
    const result_column *c = &s->columns[k];
    char *path = format_text("%s/%s", group, c->name);
    for (size_t row = 0; c->integer && row < s->n_rows; row++)
      integer[row] = c->integer[row] == RESULT_EMPTY ? -1 : c->integer[row];
    if (c->kind == RESULT_NUMBER) h5_put(file, path, SD_F64, 1, &s->n_rows, c->number, false);
    if (c->kind == RESULT_INTEGER) h5_put(file, path, SD_I64, 1, &s->n_rows, integer, false);
    if (c->kind == RESULT_TEXT) h5_put_texts(file, path, s->n_rows, (const char *const *)c->text);
    if (*c->unit) h5_attr_text(file, path, "unit", c->unit);
    h5_attr_text(file, path, "description", c->meaning);
    free(path);
  }
  free(integer);
}
