/* deck_rows.c: tables of disks from files: detects the format, reads CSV and HDF5. See deck_rows.h.
 *
 * CSV: values separated by commas (by semicolons or tabs, if the line of names has no comma), a
 * line of names at the top; # begins a comment line, blank lines are skipped. Values may be in
 * quotes, in which "" is a quote. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/limits.h"
#include "io/deck/deck_result.h"
#include "io/store/file.h"
#include "io/store/h5.h"

/* --- CSV -------------------------------------------------------------------------------------- */

typedef struct csv {
  deck *d;
  char *p;
  deck_place here;
  char separator; /* Character between values; 0 before the line of names is read */
  bool lammps;    /* True if the file begins like one of LAMMPS */
  size_t n_fields, capacity;
  char **field; /* [n_fields]: values of the current line */
} csv;

/* Adds a value to the current line, without blanks around it. Values beyond LIMIT_COLUMNS are only
 * counted. */
static void add_field(csv *in, char *text) {
  if (in->n_fields >= LIMIT_COLUMNS) {
    in->n_fields++;
    return;
  }
  in->field = deck_extend(in->d, in->field, in->n_fields, &in->capacity, sizeof *in->field);
  while (isspace((unsigned char)*text)) text++;
  char *end = text + strlen(text);
  while (end > text && isspace((unsigned char)end[-1])) *--end = 0;
  in->field[in->n_fields++] = text;
}

/* Removes the quotes of a value in quotes, in place. Returns the end of the value in the line. */
static char *unquote(csv *in, char *text) {
  char *from = text + 1, *to = text;
  while (*from && (*from != '"' || from[1] == '"')) {
    from += *from == '"';
    *to++ = *from++;
  }
  bool closed = *from == '"';
  from += closed;
  char *end = strchrnul(from, in->separator);
  *to = 0;
  if (!closed)
    deck_fail_place(in->d, in->here, "the quote before %s is not closed on this line",
                    deck_quote(in->d, text, strlen(text)));
  else if (from + strspn(from, " \t\r") < end)
    deck_fail_place(in->d, in->here, "unexpected %s behind a quote",
                    deck_quote(in->d, from, (size_t)(end - from)));
  return end;
}

static void split(csv *in, char *line) {
  in->n_fields = 0;
  for (bool last = false; !last;) {
    char *text = line + strspn(line, " "),
         *end = *text == '"' ? unquote(in, text) : strchrnul(line, in->separator);
    last = !*end;
    *end = 0;
    add_field(in, text);
    line = end + 1;
  }
}

/* Reads the next line that is neither blank nor a comment, and splits it into values, in place.
 * Returns false at the end of the file. */
static bool csv_line(csv *in) {
  while (*in->p) {
    char *line = in->p, *end = strchr(line, '\n');
    in->p = end ? end + 1 : line + strlen(line);
    if (end) *end = 0;
    in->here.line++;
    char *start = line + strspn(line, " \t\r");
    if (!*start || *start == '#') continue;
    if (!in->separator)
      in->separator = strchr(line, ',')    ? ','
                      : strchr(line, ';')  ? ';'
                      : strchr(line, '\t') ? '\t'
                                           : ',';
    split(in, line);
    return true;
  }
  return false;
}

static bool csv_open(csv *in, deck *d, const deck_node *file) {
  const char *path = deck_resolve(d, d->path, file->value.text);
  *in = (csv){.d = d, .here = {path, 0}};
  in->p = deck_read_file(d, path, (uint64_t)LIMIT_TABLE * LIMIT_MIB, file->place, "file");
  if (!in->p) return false;
  if (strncmp(in->p, "\xef\xbb\xbf", 3) == 0) in->p += 3; /* Skips the byte order mark of UTF-8 */
  in->lammps = strncmp(in->p, "ITEM:", 5) == 0 ||
               memmem(in->p, strnlen(in->p, LIMIT_LINE), "xlo xhi", 7) != NULL;
  for (char *c = strchr(in->p, '\n') ? NULL : in->p; c && (c = strchr(c, '\r'));) *c = '\n';
  size_t before = d->reported;
  bool line = csv_line(in), good = line && in->n_fields <= LIMIT_COLUMNS && d->reported == before;
  if (!line) deck_fail(d, file, "the file is empty; expected a line with the names of its columns");
  if (line && in->n_fields > LIMIT_COLUMNS)
    deck_fail_place(d, in->here, "%zu columns; expected at most %d", in->n_fields, LIMIT_COLUMNS);
  return good;
}

static size_t csv_find(const csv *in, const char *name) {
  for (size_t k = 0; k < in->n_fields; k++)
    if (strcmp(in->field[k], name) == 0) return k;
  return SIZE_MAX;
}

static bool csv_number(const csv *in, const char *column, const char *text, double *x) {
  char *end;
  *x = strtod(text, &end);
  if (end != text && !*end && isfinite(*x)) return true;
  const char *why = strchr(text, ',')      ? "; decimals are written with a point"
                    : strpbrk(text, "*/ ") ? ", without arithmetic and units"
                                           : "";
  deck_fail_place(in->d, in->here, "%s = %s: expected a number%s", column,
                  *text ? deck_quote(in->d, text, strlen(text)) : "(empty)", why);
  *x = NAN;
  return false;
}

/* Returns the entry of the key `columns` for a column of disks, such as "radius = 0.5 * Diameter",
 * as far as the names in the file tell it; NULL: they do not. */
static const char *csv_hint(const csv *in, int column) {
  const char *hint = NULL;
  if (csv_find(in, deck_column_names[column]) != SIZE_MAX) return deck_column_names[column];
  for (size_t k = 0; k < in->n_fields && !hint; k++)
    hint = deck_columns_hint(in->d, column, in->field[k]);
  return hint;
}

/* column: the property of disks (COLUMN_...) that has this name in the deck; -1: none. */
static size_t csv_find_reported(const csv *in, const char *name, int column) {
  size_t k = csv_find(in, name);
  if (k != SIZE_MAX) return k;
  const char *hint = column < 0 ? NULL : csv_hint(in, column);
  if (hint) {
    deck_fail_place(in->d, in->here, "no column \"%s\" in the line of names; did you mean \"%s\"?",
                    name, hint);
    return SIZE_MAX;
  }
  guess near = guess_start(name);
  for (size_t j = 0; j < in->n_fields && column < 0; j++) guess_add(&near, in->field[j]);
  if (near.best) {
    deck_fail_place(in->d, in->here, "no column \"%s\" in the line of names; did you mean \"%s\"?",
                    name, near.best);
    return SIZE_MAX;
  }
  const char *found = "";
  for (size_t j = 0; j < in->n_fields && j < 8; j++)
    found = deck_format(in->d, "%s%s\"%s\"", found, j ? ", " : "",
                        deck_quote(in->d, in->field[j], strlen(in->field[j])));
  deck_fail_place(
      in->d, in->here,
      "no column \"%s\" in the line of names; found %s%s; the key columns names those to be read",
      name, found, in->n_fields > 8 ? ", ..." : "");
  return SIZE_MAX;
}

static bool csv_row_is_whole(const csv *in, size_t n) {
  if (in->n_fields == n) return true;
  deck_fail_place(in->d, in->here, "%zu values; expected %zu, one per name in the first line",
                  in->n_fields, n);
  return false;
}

/* Returns a suggestion for the key `columns`, such as columns = ("x", "y = Y", "radius = ..."); the
 * dots are for names that are not known. */
static const char *example_columns(const csv *in) {
  static const int usual[] = {COLUMN_X, COLUMN_Y, COLUMN_RADIUS};
  const char *text = "columns = (";
  for (int c = 0; c < 3; c++) {
    const char *hint = csv_hint(in, usual[c]);
    text = deck_format(in->d, "%s%s\"%s%s\"", text, c ? ", " : "",
                       hint ? hint : deck_column_names[usual[c]], hint ? "" : " = ...");
  }
  return deck_format(in->d, "%s)", text);
}

/* Takes all columns of the file, if the key `columns` is missing; each name must then be a property
 * of disks. Returns false after an error, which is reported. */
static bool take_all_columns(csv *in, deck_columns *t) {
  enum { SHOWN = 200 };
  deck *d = in->d;
  const char *unknown = "";
  char *end;
  bool number = strtod(in->field[0], &end) < HUGE_VAL && end != in->field[0] && !*end, good = true;
  if (number || in->n_fields == 1) {
    deck_fail_place(d, in->here,
                    "the first line is %s%s; expected the names of the columns, with commas "
                    "between: x, y, radius, ...%s",
                    deck_quote(d, in->field[0], strlen(in->field[0])),
                    in->n_fields > 1 ? ", ..." : "",
                    in->lammps ? "; files of LAMMPS need format = \"lammps\"" : "");
    return false;
  }
  for (size_t k = 0; k < in->n_fields; k++) {
    const char *name = in->field[k];
    if (deck_column(name) >= 0) {
      good &= deck_columns_add(d, t, name, NULL, in->here);
    } else if (!*name) {
      deck_fail_place(d, in->here, "column %zu has no name; is there a comma too many?", k + 1);
      return false;
    } else if (strlen(unknown) < SHOWN) {
      unknown = deck_format(d, "%s%s\"%s\"", unknown, *unknown ? ", " : "",
                            deck_quote(d, name, strlen(name)));
    }
  }
  if (*unknown)
    deck_fail_place(d, in->here,
                    "columns of disks are x, y, radius, mass, ..., and not %s; name those to be "
                    "read in the deck: %s",
                    unknown, example_columns(in));
  return good && !*unknown;
}

static bool csv_there(void *file, const char *name) { return csv_find(file, name) != SIZE_MAX; }

static void read_csv(deck_group *g, deck_node *file, deck_columns *t) {
  deck *d = g->d;
  csv in;
  if (!csv_open(&in, d, file)) return;
  size_t n = in.n_fields, from[COLUMN_KINDS] = {0}, before = d->reported;
  bool whole = true;
  if (t->n_columns == 0) whole = take_all_columns(&in, t);
  deck_columns_resolve(g, t, csv_there, &in);
  if (d->reported > before) return;
  for (size_t c = 0; c < t->n_columns; c++) {
    const int column = deck_column(t->source[c]);
    from[c] = csv_find_reported(&in, t->source[c], column == t->column[c] ? column : -1);
    whole &= from[c] != SIZE_MAX;
  }
  while (whole && csv_line(&in)) {
    if (!csv_row_is_whole(&in, n)) continue;
    if (!deck_columns_add_row(d, t, in.here)) return;
    for (size_t c = 0; c < t->n_columns; c++) {
      size_t at = (t->n_rows - 1) * t->n_columns + c;
      t->number[at] = NAN;
      if (t->column[c] < COLUMN_NUMBERS) {
        csv_number(&in, t->source[c], in.field[from[c]], &t->number[at]);
        t->number[at] = deck_columns_value(d, t, c, t->number[at], in.here);
      } else if (*in.field[from[c]]) {
        t->text[at] = in.field[from[c]];
      }
    }
  }
  if (whole && t->n_rows == 0 && d->reported == before)
    deck_fail(d, file, "no disks: the file ends with the line of its names");
}

size_t deck_csv_pair(deck *d, const deck_node *file, const char *const names[2], double **a,
                     double **b) {
  csv in;
  if (!csv_open(&in, d, file)) return 0;
  size_t n = in.n_fields, rows = 0, capacity[2] = {0, 0}, from[2];
  for (int k = 0; k < 2; k++) from[k] = csv_find_reported(&in, names[k], -1);
  if (from[0] == SIZE_MAX || from[1] == SIZE_MAX) return 0;
  double *out[2] = {NULL, NULL};
  while (csv_line(&in)) {
    if (!csv_row_is_whole(&in, n)) continue;
    if (rows == LIMIT_TABLE_ROWS) {
      deck_fail_place(d, in.here, "more than %d rows", LIMIT_TABLE_ROWS);
      return 0;
    }
    for (int k = 0; k < 2; k++) {
      out[k] = deck_extend(d, out[k], rows, &capacity[k], sizeof(double));
      csv_number(&in, names[k], in.field[from[k]], &out[k][rows]);
    }
    rows++;
  }
  *a = out[0];
  *b = out[1];
  return rows;
}

/* --- HDF5 ------------------------------------------------------------------------------------- */

/* Returns true for an HDF5 file, even if it is damaged; false for a text or an unreadable file,
 * which is reported as an error. */
static bool is_hdf5(deck *d, const deck_node *file, const char *path) {
  uint64_t size;
  char head[8] = "";
  size_t have = 0, letters = 0;
  if (h5_is_file(path)) return true;
  const int there = file_open_quiet(path, &size);
  if (there < 0) {
    const char *trouble = file_error_text(errno), *maker = deck_result_maker(d, path);
    char *hint = file_hint(path);
    deck_fail(d, file, "cannot be read: %s%s", trouble, *maker ? maker : hint);
    free(hint);
    return false;
  }
  const bool known = file_read_at(there, 0, head, sizeof head, &have);
  close(there);
  while (letters < have &&
         (isprint((unsigned char)head[letters]) || isspace((unsigned char)head[letters])))
    letters++;
  /* Return true, so that the HDF5 library is called and reports what is wrong */
  if (!known || letters == 0 || letters < have) return true;
  deck_fail(
      d, file,
      "it is a text, and its name that of an HDF5 file; expected another name or format = \"csv\"");
  return false;
}

/* Returns the path of the dataset to read. The deck need not give it for an H5MD file with a single
 * group of particles. Returns NULL if it is missing (reported). */
static const char *dataset_of(deck_group *g, const deck_node *node, const char *path) {
  deck *d = g->d;
  h5_file *file;
  if (deck_given(g, "dataset")) return deck_text_of(g, "dataset");
  char *only = h5_only_particles(path);
  const size_t before = sd_messages_errors(d->messages);
  if (!only && h5_open(path, &file, d->messages) != SD_OK) {
    d->reported += sd_messages_errors(d->messages) - before;
    deck_fail(d, node, "cannot be read");
    return NULL;
  }
  if (!only) {
    h5_close(file, NULL);
    deck_fail_key(g, "dataset", "missing: expected the path of a dataset in the HDF5 file");
    return NULL;
  }
  const char *name = deck_copy(d, only, strlen(only));
  free(only);
  deck_default_text(g, "dataset", name);
  return name;
}

/* Reports an error if the disks and the box come from one file but from different steps. */
static void check_moment(deck *d, const deck_node *file, const char *path, int64_t step) {
  if (!d->box_path || strcmp(d->box_path, path) != 0 || d->box_step < 0 || step < 0 ||
      step == d->box_step)
    return;
  deck_fail(d, file, "its disks are read at step %lld, its box at step %lld; expected one moment",
            (long long)step, (long long)d->box_step);
}

/* A table in an HDF5 file. */
typedef struct hdf5_table {
  const char *path, *dataset;
} hdf5_table;

static bool hdf5_there(void *file, const char *name) {
  const hdf5_table *in = file;
  double *values = NULL;
  h5_range none = {0};
  const sd_status status = h5_read_table(in->path, in->dataset, 1, &name, &values, &none, NULL);
  free(values);
  free(none.kept);
  return status == SD_OK;
}

static void read_hdf5(deck_group *g, deck_node *file, deck_columns *t, const char *path) {
  deck *d = g->d;
  for (size_t c = 0; c < t->n_columns; c++)
    if (t->column[c] >= COLUMN_NUMBERS)
      deck_fail_key(g, "columns", "column \"%s\" is a text; a dataset gives numbers only",
                    deck_column_names[t->column[c]]);
  const char *dataset = is_hdf5(d, file, path) ? dataset_of(g, file, path) : NULL;
  if (!dataset) return;
  static const char *const usual[] = {"x", "y", "radius"};
  for (int k = 0; k < 3 && !deck_given(g, "columns"); k++)
    deck_columns_add(d, t, usual[k], file, file->place);
  double *values = NULL;
  const size_t reported = d->reported;
  deck_columns_resolve(g, t, hdf5_there, &(hdf5_table){path, dataset});
  if (d->reported > reported) return;
  const size_t before = sd_messages_errors(d->messages), first = d->asked.part ? d->asked.first : 0;
  h5_range rows = {
      .first = first, .n = d->asked.part ? d->asked.n : SIZE_MAX, .again = d->asked.again};
  if (h5_read_table(path, dataset, t->n_columns, t->source, &values, &rows, d->messages) != SD_OK) {
    /* The HDF5 reader has reported the reason; add the location in the deck */
    d->reported += sd_messages_errors(d->messages) - before;
    deck_fail(d, file, "cannot be read");
    free(values);
    return;
  }
  const size_t n = rows.n;
  t->all = rows.all;
  check_moment(d, file, path, rows.step);
  if (n) deck_columns_reserve(d, t, n);
  for (size_t r = 0; r < n; r++) {
    const size_t row = first + (rows.kept ? rows.kept[r] : r);
    const deck_place place = {path, -1 - (int)row};
    if (!deck_columns_add_row(d, t, place)) break;
    for (size_t c = 0; c < t->n_columns; c++) {
      const double value = values[r * t->n_columns + c];
      t->number[r * t->n_columns + c] = deck_columns_value(d, t, c, value, place);
      if (!isfinite(value))
        deck_fail_place(d, place, "%s = %g: expected a number", t->source[c], value);
    }
  }
  free(rows.kept);
  free(values);
}

/* Reads a result of this program with all its columns, unless the deck names columns or another
 * dataset; reads any other HDF5 file as a table. */
static void hdf5_or_result(deck_group *g, deck_node *file, deck_columns *t) {
  deck *d = g->d;
  const char *path = deck_resolve(d, d->path, file->value.text);
  deck_node *dataset = deck_get(g, "dataset"), *contacts = deck_get(g, "contacts");
  t->contacts = contacts && contacts->type == DECK_BOOL && contacts->value.flag;
  bool whole = !deck_given(g, "columns") &&
               (!dataset ||
                (dataset->type == DECK_STRING && strcmp(dataset->value.text, RESULT_DISKS) == 0));
  if (whole && deck_result_has_state(path)) {
    deck_default_text(g, "dataset", RESULT_DISKS);
    deck_result_rows(g, file, path, t);
    return;
  }
  if (t->contacts && deck_given(g, "columns"))
    deck_fail_key(g, "columns", "given together with contacts = true, which takes all of a result");
  else if (t->contacts && file_exists(path))
    deck_fail_key(g, "contacts",
                  "%s is no result or checkpoint of a run: its contacts are not known", path);
  t->contacts = false;
  read_hdf5(g, file, t, path);
}

int deck_file_format(deck *d, const char *name) {
  switch (h5_kind_of(deck_resolve(d, d->path, name))) {
    case FILE_HDF5:
    case FILE_H5MD: return DECK_HDF5;
    case FILE_LAMMPS: return DECK_LAMMPS;
    default: return DECK_CSV;
  }
}

void deck_columns_from_file(deck_group *g, deck_columns *t) {
  deck *d = g->d;
  const char *name = deck_text_of(g, "file");
  deck_node *file = deck_get(g, "file");
  if (!name || !file) return;
  deck_default_text(g, "format",
                    deck_key_find(g->table, "format")->words[deck_file_format(d, name)].name);
  int format = deck_choice(g, "format");
  bool contacts = deck_bool(g, "contacts");
  if (format >= 0 && format != DECK_HDF5) {
    if (deck_given(g, "dataset")) deck_fail_key(g, "dataset", "belongs to HDF5 files only");
    if (contacts) deck_fail_key(g, "contacts", "belongs to results of a run (HDF5) only");
  }
  if (format >= 0 && format != DECK_LAMMPS && deck_given(g, "timestep"))
    deck_fail_key(g, "timestep", "belongs to dumps of LAMMPS only");
  if (format == DECK_HDF5) hdf5_or_result(g, file, t);
  if (format == DECK_CSV) read_csv(g, file, t);
  if (format == DECK_LAMMPS) deck_lammps_read(g, file, t);
}
