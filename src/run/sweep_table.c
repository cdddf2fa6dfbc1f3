/* sweep_table.c: writes the table of a sweep's results, with a row per point, and the means over
 * replicas; see sweep.h. docs/sweep.md lists the columns. Only finished points have numbers;
 * `--status` shows the results of unfinished points so far. */
#include <assert.h>
#include <fnmatch.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "model/model.h"
#include "run/sweep_private.h"

/* --- One row per point ------------------------------------------------------------------------ */

/* Fills the columns with the values of the parameters that the sweep varies. */
static void put_parameters(result_table *t, size_t row, const sweep *s, const sweep_point *p) {
  for (size_t j = 0; j < s->deck.n_parameters; j++) {
    const sweep_parameter *a = &s->deck.parameters[j];
    if (a->text)
      result_table_text(t, row, a->name, "varied", p->texts[j]);
    else
      result_table_number(t, row, a->name, "", "varied; an angle in rad", p->values[j]);
  }
}

static void put_point(result_table *t, const sweep *s, size_t k, size_t point,
                      const sweep_result *r) {
  const sweep_point *p = &s->deck.points[point];
  result_table_integer(t, k, "point", "number of the point, as for --point", (int64_t)point);
  result_table_text(t, k, "name", "the result is points/NAME.h5", p->name);
  result_table_text(t, k, "status", "done, or why there are no numbers",
                    sweep_status_names[r->status]);
  result_table_integer(t, k, "set", "points of the same set differ in the replica only",
                       (int64_t)p->set);
  result_table_integer(t, k, "replica", "number of the replica", p->replica);
  result_table_integer(t, k, "seed", "seed of the random streams", p->seed);
  put_parameters(t, k, s, p);
  result_table_text(t, k, "message", "why the point failed, or its result is in doubt", r->message);
}

/* Fills the columns for element k of all quantities of `list` that have `width` elements. Names of
 * columns begin with `owner`, the name of a body, contact or average, unless it is "". */
static void put_columns(result_table *t, size_t row, const char *owner, const observable_list *list,
                        const void *values, size_t width, size_t k) {
  for (const observable *o = list->rows; o < list->rows + list->n; o++) {
    if (!o->column || o->width != width) continue;
    char *name = format_text("%s%s%s", owner, *owner ? "." : "", o->column);
    double x = observable_value(o, values, k);
    if (o->type == OBSERVABLE_I64 && !*owner)
      result_table_integer(t, row, name, o->meaning, (int64_t)x);
    else
      result_table_number(t, row, name, o->unit, o->meaning, x);
    free(name);
  }
}

static void put_configuration(result_table *t, size_t row, const summary *f, size_t k) {
  char *const *names = &f->slide_names[3 * (k / SD_CONFIGURATIONS)],
              *name = f->configuration_names[k];
  put_columns(t, row, name, &configuration_observables, &f->configurations[k], 1, 0);
  for (size_t c = 0; c < 2; c++) {
    char *owner = format_text("%s.%s", name, names[1 + c]);
    put_columns(t, row, owner, &configuration_observables, &f->configurations[k], 2, c);
    free(owner);
  }
}

/* Fills the columns of average k, whose mean and error have the unit of its expression. */
static void put_average(result_table *t, size_t row, const summary *f, size_t k) {
  char *const *names = f->average_names + 3 * k;
  char *mean = format_text("%s.mean", names[0]), *error = format_text("%s.mean_error", names[0]);
  result_table_number(t, row, mean, names[2], average_observables.rows[0].meaning,
                      f->averages[k].mean);
  result_table_number(t, row, error, names[2], average_observables.rows[1].meaning,
                      f->averages[k].error);
  put_columns(t, row, names[0], &average_observables, &f->averages[k], 1, 0);
  free(mean);
  free(error);
}

static void put_result(result_table *t, size_t row, const summary *f) {
  put_columns(t, row, "", &fact_observables, f, 1, 0);
  for (size_t k = 0; k < f->n_rotations; k++)
    put_columns(t, row, f->rotation_names[k], &rotation_observables, &f->rotations[k], 1, 0);
  for (size_t k = 0; k < f->n_slides; k++) {
    char *const *names = &f->slide_names[3 * k];
    put_columns(t, row, names[0], &slide_observables, &f->slides[k], 1, 0);
    for (size_t c = 0; c < 2; c++) {
      char *owner = format_text("%s.%s", names[0], names[1 + c]);
      put_columns(t, row, owner, &slide_observables, &f->slides[k], 2, c);
      free(owner);
    }
  }
  for (size_t k = 0; k < f->n_configurations && k < SD_CONFIGURATIONS * f->n_slides; k++)
    put_configuration(t, row, f, k);
  for (size_t k = 0; k < f->n_averages; k++) put_average(t, row, f, k);
  if (f->packing.n > 0) put_columns(t, row, "", &total_observables, &f->packing.totals, 1, 0);
  if (f->has_until) put_columns(t, row, "", &until_observables, f, 1, 0);
  put_columns(t, row, "", &energy_observables, &f->energy, 1, 0);
  put_columns(t, row, "", &outcome_observables, f, 1, 0);
}

void sweep_columns(const sweep *s, size_t point, const sd_model *model, bool *collected) {
  result_table t = {.n_rows = 1};
  sweep_result blank = {.message = (char[]){""}};
  summary_new(&blank.found, model);
  blank.found.packing.n = model->measure_disks ? model->n_free : 0;
  put_point(&t, s, 0, point, &blank);
  put_result(&t, 0, &blank.found);
  for (size_t p = 0; p < s->deck.n_collect; p++)
    for (size_t k = 0; k < t.n_columns && !collected[p]; k++)
      collected[p] = fnmatch(s->deck.collect[p], t.columns[k].name, 0) == 0;
  blank.found.packing = (summary_disks){0};
  summary_free(&blank.found);
  result_table_free(&t);
}

/* --- One row per set of values ---------------------------------------------------------------- */

/* Sums over the finished replicas of a set (points with equal parameter values). */
typedef struct pool {
  double n, sum;
  /* squares: sum of squared deviations from the mean; errors: sum of squared error bars */
  double squares, errors;
} pool;

/* Sums the values of a column over the replicas of each set of parameter values: in a first pass
 * for the means, in a second pass the squared deviations from them. */
static void fill_pools(pool *p, const sweep *s, const result_column *c,
                       const result_column *error) {
  for (size_t pass = 0; pass < 2; pass++)
    for (size_t k = 0; k < s->deck.n_points; k++) {
      pool *one = &p[s->deck.points[k].set];
      if (!isfinite(c->number[k])) continue;
      if (pass == 0) {
        one->n++;
        one->sum += c->number[k];
        one->errors += error ? error->number[k] * error->number[k] : 0;
      } else {
        double off = c->number[k] - one->sum / one->n;
        one->squares += off * off;
      }
    }
}

/* Fills the column of the mean over replicas. If the quantity has error bars, also fills the column
 * of the error of the mean from these error bars, and that of the error from the scatter of the
 * replicas. */
static void put_means(result_table *m, const sweep *s, const result_table *t,
                      const result_column *c) {
  char *error_name = format_text("%s_error", c->name),
       *scatter_name = format_text("%s_scatter", c->name);
  pool *pools = memory_new(m->n_rows, sizeof *pools);
  const result_column *error = result_table_find(t, error_name);
  fill_pools(pools, s, c, error);
  for (size_t set = 0; set < m->n_rows; set++) {
    const pool *p = &pools[set];
    result_table_number(m, set, c->name, c->unit, c->meaning, p->n > 0 ? p->sum / p->n : NAN);
    if (!error) continue;
    result_table_number(m, set, error_name, c->unit,
                        "one standard error, from the error bars of the replicas",
                        p->n > 0 ? sqrt(p->errors) / p->n : NAN);
    result_table_number(m, set, scatter_name, c->unit,
                        "one standard error, from the scatter of the replicas",
                        p->n > 1 ? sqrt(p->squares / (p->n * (p->n - 1))) : NAN);
  }
  free(pools);
  free(error_name);
  free(scatter_name);
}

static void fill_means(result_table *m, const sweep *s, const result_table *t) {
  for (size_t k = s->deck.n_points; k-- > 0;) {
    const sweep_point *p = &s->deck.points[k];
    result_table_integer(m, p->set, "set", "number of the set", (int64_t)p->set);
    put_parameters(m, p->set, s, p);
  }
  const result_column *status = result_table_find(t, "status");
  assert(!status || status->text || t->n_rows == 0);
  for (size_t set = 0; set < m->n_rows; set++)
    result_table_integer(m, set, "replicas", "finished replicas", 0);
  result_column *replicas = result_table_find(m, "replicas");
  for (size_t k = 0; k < t->n_rows && status && replicas; k++)
    if (status->text[k] && strcmp(status->text[k], sweep_status_names[SWEEP_DONE]) == 0)
      replicas->integer[s->deck.points[k].set]++;
  for (size_t c = 0; c < t->n_columns; c++) {
    const result_column *from = &t->columns[c];
    bool wanted = !from->always && from->kind == RESULT_NUMBER &&
                  !text_ends(from->name, "_error") && strcmp(from->name, "ns_per_step") != 0;
    if (wanted) put_means(m, s, t, from);
  }
}

/* --- Writing ---------------------------------------------------------------------------------- */

/* Returns the list of the files that belong to the tables, one per line: the CSV files with their
 * checksums, and the results of finished points. `slipdisk verify` compares it with the folder. */
static char *list_files(const sweep *s, const result_table *t, uint64_t table, uint64_t means) {
  const result_column *status = result_table_find(t, "status");
  char *text =
      format_text("table.csv XXH3_%016" PRIx64 "\nmeans.csv XXH3_%016" PRIx64 "\n", table, means);
  for (size_t k = 0; status && k < t->n_rows; k++)
    if (strcmp(status->text[k], sweep_status_names[SWEEP_DONE]) == 0)
      text = append_text(text, "points/%s.h5\n", s->deck.points[k].name);
  return text;
}

static sd_status write_h5(const sweep *s, const result_table *t, const result_table *m,
                          const char *path, const char *files, sd_messages *messages) {
  h5_file *file;
  sd_status status = h5_new(&file, messages);
  if (status != SD_OK) return status;
  result_table_write_h5(t, file, "/points");
  result_table_write_h5(m, file, "/means");
  h5_put_text(file, "/parameters/files", files);
  h5_put_text(file, "/parameters/deck_text", s->deck.deck_text);
  char *lines = memory_text("");
  for (size_t k = 0; k < s->deck.n_overrides; k++)
    lines = append_text(lines, "%s\n", s->deck.overrides[k]);
  h5_put_text(file, "/parameters/deck_overrides", lines);
  h5_attr_text(file, "/parameters", "deck_path", s->deck.deck_path);
  for (size_t j = 0; j < s->deck.n_parameters; j++)
    h5_attr_text(file, "/parameters", s->deck.parameters[j].name, s->deck.parameters[j].path);
  free(lines);
  return h5_save(file, -1, path, NULL, messages);
}

static sd_status write_all(const sweep *s, const result_table *t, const result_table *m,
                           sd_messages *messages) {
  char *csv = format_text("%s/table.csv", s->folder), *h5 = format_text("%s/table.h5", s->folder),
       *means = format_text("%s/means.csv", s->folder);
  uint64_t table_sum, means_sum;
  sd_status status = result_table_write_csv(t, csv, &table_sum, messages);
  if (status == SD_OK) status = result_table_write_csv(m, means, &means_sum, messages);
  if (status == SD_OK) {
    char *files = list_files(s, t, table_sum, means_sum);
    status = write_h5(s, t, m, h5, files, messages);
    free(files);
  }
  free(csv);
  free(h5);
  free(means);
  return status;
}

static sd_status make_tables(const sweep *s, bool mix, size_t *count, sd_messages *messages) {
  result_table t = {.n_rows = s->deck.n_points}, m = {.n_rows = s->deck.n_sets};
  sweep_tally others = {0};
  sweep_result *results;
  sd_status unread = SD_OK;
  if (!memory_row(&results, s->deck.n_points, sizeof *results))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the table");
  for (size_t k = 0; k < s->deck.n_points; k++) {
    sweep_look(s, k, &results[k]);
    put_point(&t, s, k, k, &results[k]);
    count[results[k].status]++;
    if (!mix) sweep_tally_add(&others, &results[k]);
    if (results[k].status == SWEEP_UNREADABLE)
      unread = sd_fail(messages, SD_ERROR_IO, "no table is written: %s", results[k].message);
  }
  sd_status status = unread != SD_OK
                         ? unread
                         : sweep_refuse_other_decks(s, &others, "no table is written", messages);
  sweep_tally_free(&others);
  result_table_keep_all(&t);
  for (size_t k = 0; k < s->deck.n_points; k++) {
    if (results[k].status == SWEEP_DONE && results[k].has_found)
      put_result(&t, k, &results[k].found);
    sweep_result_free(&results[k]);
  }
  free(results);
  if (status == SD_OK) {
    result_table_collect(&t, s->deck.n_collect, (const char *const *)s->deck.collect, messages);
    fill_means(&m, s, &t);
    status = write_all(s, &t, &m, messages);
  }
  result_table_free(&t);
  result_table_free(&m);
  return status;
}

/* Only one process writes at a time, so that the tables that remain are those of the process that
 * has read the folder last. */
sd_status sweep_write_tables(const sweep *s, double patience, bool mix,
                             size_t count[SWEEP_STATUSES], sd_messages *messages) {
  const double pause = 0.05;
  folder lock = {.at = -1, .lock = -1};
  sd_status status = SD_ERROR_USER;
  for (; (status = folder_open(s->folder, true, &lock, NULL)) == SD_ERROR_USER && patience > 0;
       patience -= pause)
    nanosleep(&(struct timespec){.tv_nsec = (long)(pause * 1e9)}, NULL);
  /* Try once more, now with messages: they tell why the folder cannot be locked. */
  if (status != SD_OK) status = folder_open(s->folder, true, &lock, messages);
  if (status != SD_OK) return status;
  /* remove temporary files left by killed processes */
  static const char *const tables[] = {"table.csv", "table.h5", "means.csv"};
  for (size_t k = 0; k < sizeof tables / sizeof *tables; k++)
    file_remove_drafts(s->folder, tables[k], NULL);
  status = make_tables(s, mix, count, messages);
  folder_close(&lock);
  return status;
}

/* --- Table of results in memory --------------------------------------------------------------- */
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

/* Returns the column of this name, which is added if the table has none; NULL: the column exists
 * with values of another kind. */
static result_column *column(result_table *s, result_kind kind, const char *name, const char *unit,
                             const char *meaning) {
  result_column *c = result_table_find(s, name);
  if (c) return c->kind == kind ? c : NULL;
  s->columns = memory_grow(s->columns, s->n_columns + 1, sizeof *s->columns);
  c = &s->columns[s->n_columns++];
  *c = (result_column){
      .name = memory_text(name), .kind = kind, .unit = memory_text(unit), .meaning = meaning};
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
  free(c->unit);
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

/* --- Writing as CSV --------------------------------------------------------------------------- */

/* Writes a number as text with the fewest digits, but at least 6, from which it can be read back
 * exactly; NAN: writes an empty cell. */
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

sd_status result_table_write_csv(const result_table *s, const char *path, uint64_t *sum,
                                 sd_messages *messages) {
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
  *sum = file_sum(text, size);
  sd_status status = file_write_atomic(path, text, size, messages);
  free(text);
  return status;
}

/* --- Writing to HDF5 -------------------------------------------------------------------------- */

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
