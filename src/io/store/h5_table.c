/* h5_table.c: reads tables of particles for the deck, in four forms; see h5_read_table in h5.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/h5.h"
#include "io/store/h5_private.h"

/* State of the reading of a table. */
typedef struct table {
  const h5_file *file;
  const char *path;
  size_t n_columns;
  const char *const *columns;
  double *values; /* [rows][n_columns] result: values of the requested columns */
  double *data;   /* values of one column or element, as read from the file */
  bool *gone;     /* [rows] true if the row holds no particle */
  uint32_t *kept; /* [rows] indices of the rows that hold a particle, for rows.kept */
  h5_range rows;
  bool sized;    /* true if the number of rows is known */
  bool too_long; /* true if the table has too many rows, which has been reported */
  sd_messages *messages;
} table;

static sd_status user_error(const table *t, const char *column, const char *what) {
  return sd_fail(t->messages, SD_ERROR_USER, "%s: %s: column \"%s\": %s", t->file->path, t->path,
                 column, what);
}

static sd_status no_memory(const table *t) {
  return sd_fail(t->messages, SD_ERROR_IO, "no memory to read %s", t->file->path);
}

/* The first column sets the number of rows of the table and allocates memory for them; each later
 * column must have the same number. */
static sd_status size_rows(table *t, const char *column, size_t n) {
  if (!t->sized && n > LIMIT_DISKS) {
    t->too_long = true;
    return sd_fail(t->messages, SD_ERROR_USER, "%s: %s has %zu rows; expected at most %d",
                   t->file->path, t->path, n, LIMIT_DISKS);
  }
  if (!t->sized) {
    h5_range *r = &t->rows;
    r->all = n;
    if (r->first > n) r->first = n;
    if (r->n > n - r->first) r->n = n - r->first;
    if (!memory_rows(3, (memory_column[]){{&t->values, r->n * t->n_columns, sizeof *t->values},
                                          {&t->gone, r->n, sizeof *t->gone},
                                          {&t->kept, r->n, sizeof *t->kept}}))
      return no_memory(t);
    t->sized = true;
  }
  return n == t->rows.all
             ? SD_OK
             : user_error(t, column, "has another number of rows than the columns before");
}

/* Allocates t->data for n values; returns false, with a message, if there is no memory. */
static bool has_room(table *t, size_t n) {
  const bool enough = memory_resize_row(&t->data, n, sizeof *t->data);
  if (!enough) no_memory(t);
  return enough;
}

static bool is_number(hid_t type) {
  H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT || kind == H5T_ENUM;
}

/* Copies the values of one column into the rows of the table. */
static void scatter(table *t, size_t column, const double *data) {
  for (size_t k = 0; k < t->rows.n; k++) t->values[k * t->n_columns + column] = data[k];
}

/* Returns true if all values in the box of count[k] elements from start[k] on along each dimension
 * k were written. A chunk that was never written would read as zeros. */
static bool is_written(hid_t set, const hsize_t start[H5_MAX_RANK],
                       const hsize_t count[H5_MAX_RANK]) {
  hid_t made = H5Dget_create_plist(set);
  const H5D_layout_t layout = H5Pget_layout(made);
  hsize_t chunk[H5S_MAX_RANK] = {0}, at[H5S_MAX_RANK] = {0}, size;
  const int rank = layout == H5D_CHUNKED ? H5Pget_chunk(made, H5S_MAX_RANK, chunk) : 0;
  bool good = layout == H5D_CHUNKED || H5Dget_storage_size(set) > 0;
  H5Pclose(made);
  for (int k = 0; k < rank; k++) at[k] = start[k] / chunk[k] * chunk[k];
  for (bool more = rank > 0; more && good;) {
    haddr_t address = HADDR_UNDEF;
    good =
        H5Dget_chunk_info_by_coord(set, at, NULL, &address, &size) >= 0 && address != HADDR_UNDEF;
    int k = rank - 1;
    for (; k >= 0; k--) {
      at[k] += chunk[k];
      if (at[k] < start[k] + count[k]) break;
      at[k] = start[k] / chunk[k] * chunk[k];
    }
    more = k >= 0;
  }
  return good;
}

/* Reads count[k] values from start[k] on along each dimension k of a dataset; count is 1 beyond its
 * rank. Returns a text that says what is wrong; NULL: nothing is. */
static const char *read_box(hid_t set, hid_t type, const hsize_t start[H5_MAX_RANK],
                            const hsize_t count[H5_MAX_RANK], double *data) {
  if (!is_written(set, start, count)) return "has values that were never written";
  return h5_read_slab(set, type, start, count, data) ? NULL : "cannot be read as numbers";
}

/* --- Compound datasets ------------------------------------------------------------------------ */

/* Reads a compound dataset. If it has several dimensions, its elements in C order are the rows. */
static sd_status read_compound(table *t, hid_t set, hid_t type, int rank) {
  hid_t space = H5Dget_space(set);
  hssize_t points = H5Sget_simple_extent_npoints(space);
  size_t rows = points < 0 ? SIZE_MAX : (size_t)points;
  H5Sclose(space);
  sd_status status = size_rows(t, "", rows);
  if (status != SD_OK) return status;
  const bool line = rank == 1;
  const hsize_t start[H5_MAX_RANK] = {t->rows.first}, count[H5_MAX_RANK] = {t->rows.n, 1, 1, 1};
  if (!has_room(t, line ? t->rows.n : rows)) return SD_ERROR_IO;
  for (size_t c = 0; status != SD_ERROR_IO && c < t->n_columns; c++) {
    int member = H5Tget_member_index(type, t->columns[c]);
    hid_t kind = member < 0 ? H5I_INVALID_HID : H5Tget_member_type(type, (unsigned)member);
    if (member < 0) {
      status = user_error(t, t->columns[c], "there is no such field");
    } else if (!is_number(kind)) {
      status = user_error(t, t->columns[c], "is not a number");
    } else {
      hid_t one = H5Tcreate(H5T_COMPOUND, sizeof(double));
      H5Tinsert(one, t->columns[c], 0, H5T_NATIVE_DOUBLE);
      const char *trouble = NULL;
      if (t->rows.n > 0 && line)
        trouble = read_box(set, one, start, count, t->data);
      else if (t->rows.n > 0 && H5Dread(set, one, H5S_ALL, H5S_ALL, H5P_DEFAULT, t->data) < 0)
        trouble = "cannot be read";
      if (trouble)
        status = user_error(t, t->columns[c], trouble);
      else
        scatter(t, c, line ? t->data : t->data + t->rows.first);
      H5Tclose(one);
    }
    if (kind >= 0) H5Tclose(kind);
  }
  return status;
}

/* --- Two-dimensional datasets ----------------------------------------------------------------- */

/* Returns the index of a name in a list of names with a newline after each (h5_words); SIZE_MAX: it
 * is not there. */
static size_t find_name(const char *names, const char *name) {
  size_t index = 0;
  for (const char *at = names; *at;) {
    size_t length = strcspn(at, "\n");
    if (length > 0) {
      if (strlen(name) == length && strncmp(at, name, length) == 0) return index;
      index++;
    }
    at += length;
    if (*at) at++;
  }
  return SIZE_MAX;
}

/* Returns the number of names in a list of names with a newline after each (h5_words). */
static size_t count_names(const char *names) {
  size_t n = 0;
  for (const char *at = names; *at; at++) n += *at != '\n' && (at[1] == '\n' || !at[1]);
  return n;
}

/* Checks that the attribute "columns" of a two-dimensional dataset has a name for each column. */
static sd_status check_names(const table *t, const char *names, size_t width) {
  if (!names)
    return sd_fail(t->messages, SD_ERROR_USER,
                   "%s: %s is a matrix without names of its columns; expected an attribute "
                   "\"columns\", such as "
                   "\"x,y,radius\"",
                   t->file->path, t->path);
  const size_t n = count_names(names);
  if (n == width) return SD_OK;
  return sd_fail(t->messages, SD_ERROR_USER,
                 "%s: %s has %zu columns, and its attribute \"columns\" %zu names", t->file->path,
                 t->path, width, n);
}

/* Reads a two-dimensional dataset, one column at a time, so that a wide dataset needs little
 * memory. */
static sd_status read_matrix(table *t, hid_t set, size_t rows, size_t width) {
  sd_status status = size_rows(t, "", rows);
  if (status != SD_OK) return status;
  if (!has_room(t, t->rows.n)) return SD_ERROR_IO;
  char *names = h5_words(t->file, t->path, "columns");
  status = check_names(t, names, width);
  for (size_t c = 0; names && status == SD_OK && c < t->n_columns; c++) {
    const size_t from = find_name(names, t->columns[c]);
    const hsize_t start[H5_MAX_RANK] = {t->rows.first, from},
                  count[H5_MAX_RANK] = {t->rows.n, 1, 1, 1};
    const char *trouble = from >= width ? "is not among the names in attribute \"columns\"" : NULL;
    if (!trouble && t->rows.n > 0)
      trouble = read_box(set, H5T_NATIVE_DOUBLE, start, count, t->data);
    if (trouble)
      status = user_error(t, t->columns[c], trouble);
    else
      scatter(t, c, t->data);
  }
  free(names);
  return status;
}

/* --- Groups of columns, and particles of H5MD files ------------------------------------------- */

/* Largest number of components of a vector in an H5MD element. */
enum { MOST_COMPONENTS = 3 };

/* Names of table columns that are components of H5MD elements. */
static const struct alias {
  const char *column, *element;
  int component; /* index of the component; -1: the element is a scalar per particle */
} aliases[] = {{"x", "position", 0},  {"y", "position", 1},   {"vx", "velocity", 0},
               {"vy", "velocity", 1}, {"theta", "angle", -1}, {"omega", "angular_velocity", -1}};

enum { MOST_ELEMENTS = 64 };

/* Source of a column: index of the H5MD element in the list of elements, and its component; -1: the
 * element is a scalar. */
typedef struct source {
  size_t element;
  int component;
} source;

/* Returns true if there is a dataset at path. */
static bool is_set(const h5_file *file, const char *path) {
  if (!h5_exists(file, path)) return false;
  hid_t object = h5_open_object(file, path, NULL);
  bool set = object >= 0 && H5Iget_type(object) == H5I_DATASET;
  if (object >= 0) H5Oclose(object);
  return set;
}

/* Returns the path of the group to which "/name" is appended: "" for the root group. */
static const char *base_of(const table *t) { return strcmp(t->path, "/") == 0 ? "" : t->path; }

/* Returns the path of an H5MD element's values; the caller frees it. framed: true if the values are
 * in frames. */
static char *path_of(const table *t, const char *element, bool framed) {
  return format_text(framed ? "%s/%s/value" : "%s/%s", base_of(t), element);
}

/* Returns the index of an H5MD element in the list, to which it is added if it is new. */
static size_t add_element(h5_element *elements, size_t *n, const char *name) {
  size_t k = 0;
  while (k < *n && strcmp(elements[k].name, name) != 0) k++;
  if (k == *n) elements[(*n)++] = (h5_element){.name = name};
  return k;
}

/* Finds the source of table column c. A dataset of the column's own name takes precedence over an
 * H5MD element that has the column as a component. */
static sd_status find_source(const table *t, size_t c, h5_element *elements, size_t *n,
                             source *from) {
  const char *name = t->columns[c], *element = name;
  char *path = path_of(t, name, false), *fixed = NULL, *framed = NULL;
  *from = (source){.component = -1};
  for (size_t k = 0; !h5_exists(t->file, path) && k < sizeof aliases / sizeof *aliases; k++)
    if (strcmp(aliases[k].column, name) == 0) {
      element = aliases[k].element;
      from->component = aliases[k].component;
    }
  fixed = path_of(t, element, false);
  framed = path_of(t, element, true);
  sd_status status = SD_OK;
  if (is_set(t->file, fixed) || is_set(t->file, framed))
    from->element = add_element(elements, n, element);
  else if (h5_is_link(t->file, path) || h5_is_link(t->file, fixed) || h5_is_link(t->file, framed))
    status = user_error(t, name, "is a link, which is not followed");
  else
    status = user_error(t, name, "there is no such dataset");
  free(path);
  free(fixed);
  free(framed);
  return status;
}

/* Reads the rows t->rows, `width` numbers each, from the selected frame of an element. Returns a
 * text that says what is wrong; NULL: nothing is. */
static const char *read_rows(const table *t, const h5_element *e, const char *path, size_t width,
                             double *data) {
  const hsize_t start[] = {e->frame, t->rows.first, 0, 0, 0}, count[] = {1, t->rows.n, width, 1, 1};
  const int skip = e->framed ? 0 : 1;
  if (t->rows.n == 0) return NULL;
  hid_t set = h5_open_data(t->file, path, NULL);
  if (set < 0) return "cannot be read as numbers";
  const char *trouble = read_box(set, H5T_NATIVE_DOUBLE, start + skip, count + skip, data);
  H5Oclose(set);
  return trouble;
}

/* Reads the rows t->rows of an element, *width numbers each, into t->data, which is valid until the
 * next call. component < 0: the element must be a scalar. Returns NULL, with a message, if that
 * fails. */
static const double *read_values(table *t, const h5_element *e, const char *name, int component,
                                 size_t *width) {
  size_t dims[H5_MAX_RANK];
  int rank;
  char *path = path_of(t, e->name, e->framed);
  if (h5_shape(t->file, path, &rank, dims, t->messages) != SD_OK) {
    free(path);
    return NULL;
  }
  const size_t *inner = dims + e->framed;
  const char *trouble = NULL;
  if (rank - e->framed != (component < 0 ? 1 : 2) ||
      (component >= 0 && ((size_t)component >= inner[1] || inner[1] > MOST_COMPONENTS)))
    trouble = "has not the shape of one value per particle";
  bool room = false;
  if (!trouble && size_rows(t, name, inner[0]) == SD_OK) {
    const h5_range *r = &t->rows;
    const bool shared = h5_shared_set_of(t->file, path) != NULL;
    *width = component < 0 ? 1 : inner[1];
    const size_t n = (shared ? r->all : r->n) * *width;
    room = has_room(t, n);
    double *data = t->data;
    /* a dataset joined from shares (files of single ranks) is read a frame at a time */
    if (room && shared) {
      const sd_status got = e->framed
                                ? h5_get_values(t->file, path, SD_F64, e->frame, 1, n, data, NULL)
                                : h5_get(t->file, path, SD_F64, n, data, NULL);
      if (got != SD_OK) trouble = "cannot be read as numbers";
      memmove(data, data + r->first * *width, r->n * *width * sizeof *data);
    } else if (room && !e->framed && h5_check(t->file, path, r->all * *width, NULL) != SD_OK) {
      trouble = "cannot be read as numbers";
    } else if (room) {
      trouble = read_rows(t, e, path, *width, data);
    }
  }
  free(path);
  if (trouble) user_error(t, name, trouble);
  return trouble || !room ? NULL : t->data;
}

/* Returns true if row k holds no particle. gone: [rows] true for such rows, NULL: all rows hold
 * one. */
static bool is_gone(const bool *gone, size_t k) { return gone && gone[k]; }

/* Checks, for an element with vectors of three components, that all particles are, or move, in one
 * plane. */
static sd_status check_plane(const table *t, const h5_element *e, const double *data, size_t width,
                             const bool *gone) {
  double least[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, most[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL},
         range[3];
  for (size_t k = 0; k < t->rows.n; k++)
    for (size_t c = 0; c < width && c < 3 && !is_gone(gone, k); c++) {
      least[c] = fmin(least[c], data[k * width + c]);
      most[c] = fmax(most[c], data[k * width + c]);
    }
  if (width < 3 || least[0] > most[0]) return SD_OK;
  const bool moves = strcmp(e->name, "velocity") == 0;
  for (int c = 0; c < 3; c++) range[c] = moves ? fmax(-least[c], most[c]) : most[c] - least[c];
  if (range[2] <= 1e-6 * fmax(range[0], range[1])) return SD_OK;
  return sd_fail(
      t->messages, SD_ERROR_USER,
      "%s: %s: %s has three dimensions, its third component goes from %g to %g; expected particles "
      "in a plane",
      t->file->path, t->path, e->name, least[2], most[2]);
}

/* Reports rows that have the fill value, and so were not written, although they should hold a
 * particle. */
static sd_status check_fill(const table *t, const h5_element *e, const double *data, size_t width,
                            const bool *gone) {
  double fill;
  char *path = path_of(t, e->name, e->framed);
  sd_status status = SD_OK;
  const bool given = h5_is_fill(t->file, path, &fill);
  free(path);
  for (size_t k = 0; k < t->rows.n && status == SD_OK; k++) {
    bool filled = given && !is_gone(gone, k);
    for (size_t c = 0; c < width && filled; c++)
      filled = data[k * width + c] == fill || (isnan(fill) && isnan(data[k * width + c]));
    if (filled)
      status = sd_fail(t->messages, SD_ERROR_USER,
                       "%s: %s: row %zu of %s holds the fill value %g: it was not written",
                       t->file->path, t->path, t->rows.first + k, e->name, fill);
  }
  return status;
}

/* Reads column c of the table from its element. */
static sd_status read_column(table *t, size_t c, const source *from, const h5_element *e,
                             const bool *gone) {
  size_t width = 1;
  const double *data = read_values(t, e, t->columns[c], from->component, &width);
  if (!data) return SD_ERROR_USER;
  sd_status status = check_fill(t, e, data, width, gone);
  if (status == SD_OK && from->component >= 0) status = check_plane(t, e, data, width, gone);
  const double *first = data + (from->component < 0 ? 0 : (size_t)from->component);
  for (size_t k = 0; status == SD_OK && k < t->rows.n; k++)
    t->values[k * t->n_columns + c] = first[k * width];
  return status;
}

/* Finds the rows that hold no particle, from the element that marks them. */
static sd_status read_absent(table *t, const h5_element *e) {
  size_t width = 1;
  const double *data = read_values(t, e, e->name, -1, &width);
  if (!data) return SD_ERROR_USER;
  return h5_absent(t->file, base_of(t), e, data, t->rows.n, t->gone, t->messages);
}

/* Removes the rows without a particle from the table. */
static void leave_out(table *t, const bool *gone) {
  size_t n = 0;
  for (size_t k = 0; k < t->rows.n; k++) n += !is_gone(gone, k);
  if (n == t->rows.n) return;
  t->rows.kept = t->kept;
  t->kept = NULL;
  n = 0;
  for (size_t k = 0; k < t->rows.n; k++) {
    if (gone[k]) continue;
    memmove(t->values + n * t->n_columns, t->values + k * t->n_columns,
            t->n_columns * sizeof *t->values);
    t->rows.kept[n++] = (uint32_t)k;
  }
  t->rows.n = n;
  t->rows.all = 0;
}

/* Reads all columns from a group. Each column that is missing or cannot be read gives one
 * message. */
static sd_status read_group(table *t) {
  h5_element elements[MOST_ELEMENTS];
  source from[MOST_ELEMENTS] = {0};
  size_t n = 0, absence = SIZE_MAX;
  const bool *gone = NULL;
  sd_status status, worst = SD_OK;
  if (t->n_columns >= MOST_ELEMENTS)
    return user_error(t, t->columns[MOST_ELEMENTS - 1], "is one too many");
  for (size_t c = 0; c < t->n_columns; c++)
    if ((status = find_source(t, c, elements, &n, &from[c])) != SD_OK && worst == SD_OK)
      worst = status;
  if (worst != SD_OK) return worst;
  const char *name = h5_absence(t->file, base_of(t));
  if (name) absence = add_element(elements, &n, name);
  worst = h5_moment(t->file, base_of(t), elements, n, &t->rows.step, t->messages);
  if (worst == SD_OK && name) {
    worst = read_absent(t, &elements[absence]);
    gone = t->gone;
  }
  for (size_t c = 0; (worst == SD_OK || c > 0) && c < t->n_columns && !t->too_long; c++)
    if ((status = read_column(t, c, &from[c], &elements[from[c].element], gone)) != SD_OK &&
        worst == SD_OK)
      worst = status;
  if (worst == SD_OK) leave_out(t, gone);
  return worst;
}

/* --- Choice of the form ----------------------------------------------------------------------- */

/* Reads a table from a single dataset. */
static sd_status read_set(table *t, hid_t set) {
  size_t dims[H5_MAX_RANK];
  int rank;
  sd_status status = h5_shape(t->file, t->path, &rank, dims, t->messages);
  if (status != SD_OK) return status;
  hid_t type = H5Dget_type(set);
  if (h5_shared_set_of(t->file, t->path))
    status =
        sd_fail(t->messages, SD_ERROR_USER, "%s: %s is a column; expected the group that it is in",
                t->file->path, t->path);
  else if (H5Tget_class(type) == H5T_COMPOUND)
    status = read_compound(t, set, type, rank);
  else if (rank == 2 && is_number(type))
    status = read_matrix(t, set, dims[0], dims[1]);
  else
    status = sd_fail(t->messages, SD_ERROR_USER,
                     "%s: %s is neither a compound dataset nor a 2D one of numbers", t->file->path,
                     t->path);
  H5Tclose(type);
  return status;
}

sd_status h5_read_table(const char *file, const char *dataset, size_t n_columns,
                        const char *const *columns, double **values, h5_range *rows,
                        sd_messages *messages) {
  *values = NULL;
  h5_file *h5;
  sd_status status = (rows->again ? h5_open_again : h5_open)(file, &h5, messages);
  if (status != SD_OK) return status;
  table t = {.file = h5,
             .path = dataset && *dataset ? dataset : "/",
             .n_columns = n_columns,
             .columns = columns,
             .rows = *rows,
             .messages = messages};
  *rows = (h5_range){.step = -1};
  t.rows.step = -1;
  t.rows.kept = NULL;
  hid_t object = h5_open_object(h5, t.path, messages);
  if (object < 0)
    status = SD_ERROR_USER;
  else
    status = H5Iget_type(object) == H5I_DATASET ? read_set(&t, object) : read_group(&t);
  if (object >= 0) H5Oclose(object);
  h5_close(h5, NULL);
  free(t.data);
  free(t.gone);
  free(t.kept);
  if (status == SD_OK) {
    *values = t.values;
    *rows = t.rows;
  } else {
    free(t.values);
    free(t.rows.kept);
  }
  return status;
}
