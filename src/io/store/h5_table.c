/* h5_table.c: tables of particles for the deck, in four forms; see h5_read_table in h5.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "io/store/h5.h"
#include "io/store/h5_private.h"

/* The table being read. */
typedef struct table {
  const h5_file *file;
  const char *path;
  size_t n_columns;
  const char *const *columns;
  double *values;
  h5_range rows;
  bool sized;    /* their number is known */
  bool too_long; /* reported */
  sd_messages *messages;
} table;

static sd_status user_error(const table *t, const char *column, const char *what) {
  return sd_fail(t->messages, SD_ERROR_USER, "%s: %s: column \"%s\": %s", t->file->path, t->path, column,
                 what);
}

/* The first column fixes the number of rows. */
static sd_status size_rows(table *t, const char *column, size_t n) {
  if (!t->sized && n > LIMIT_DISKS) {
    t->too_long = true;
    return sd_fail(t->messages, SD_ERROR_USER, "%s: %s has %zu rows; expected at most %d", t->file->path,
                   t->path, n, LIMIT_DISKS);
  }
  if (!t->sized) {
    h5_range *r = &t->rows;
    r->all = n;
    if (r->first > n) r->first = n;
    if (r->n > n - r->first) r->n = n - r->first;
    t->sized = true;
    t->values = calloc(r->n * t->n_columns + 1, sizeof *t->values);
    if (!t->values) return sd_fail(t->messages, SD_ERROR_IO, "no memory to read %s", t->file->path);
  }
  return n == t->rows.all ? SD_OK
                          : user_error(t, column, "has another number of rows than the columns before");
}

static bool is_number(hid_t type) {
  H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT || kind == H5T_ENUM;
}

/* Copies one column, as read, to its place in the rows. */
static void scatter(table *t, size_t column, const double *data) {
  for (size_t k = 0; k < t->rows.n; k++) t->values[k * t->n_columns + column] = data[k];
}

/* Reads a box of a dataset: count values from `start` on in each of its dimensions (1 beyond them). */
static bool read_box(hid_t set, hid_t type, const hsize_t start[H5_MAX_RANK],
                     const hsize_t count[H5_MAX_RANK], double *data) {
  hid_t space = H5Dget_space(set);
  hsize_t total = 1;
  for (int k = 0; k < H5_MAX_RANK; k++) total *= count[k];
  hid_t memory = H5Screate_simple(1, &total, NULL);
  const bool good = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                    H5Dread(set, type, memory, space, H5P_DEFAULT, data) >= 0;
  H5Sclose(memory);
  H5Sclose(space);
  return good;
}

/* --- compound ------------------------------------------------------------------------------------- */

/* Of more than one dimension: all rows, one after the other. */
static sd_status read_compound(table *t, hid_t set, hid_t type, int rank) {
  hid_t space = H5Dget_space(set);
  hssize_t points = H5Sget_simple_extent_npoints(space);
  size_t rows = points < 0 ? SIZE_MAX : (size_t)points;
  H5Sclose(space);
  sd_status status = size_rows(t, "", rows);
  if (t->too_long) return status;
  const bool line = rank == 1;
  const hsize_t start[H5_MAX_RANK] = {t->rows.first}, count[H5_MAX_RANK] = {t->rows.n, 1, 1, 1};
  double *data = calloc((line ? t->rows.n : rows) + 1, sizeof *data);
  if (!data) return sd_fail(t->messages, SD_ERROR_IO, "no memory to read %s", t->file->path);
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
      if (t->rows.n > 0 && !(line ? read_box(set, one, start, count, data)
                                  : H5Dread(set, one, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0))
        status = user_error(t, t->columns[c], "cannot be read");
      else
        scatter(t, c, line ? data : data + t->rows.first);
      H5Tclose(one);
    }
    if (kind >= 0) H5Tclose(kind);
  }
  free(data);
  return status;
}

/* --- two-dimensional ------------------------------------------------------------------------------ */

/* The names in attribute "columns" (an array of strings, or one with commas or blanks) as one text with a
 * newline after each name; NULL when there is none. */
static char *column_names(hid_t set) {
  if (H5Aexists(set, "columns") <= 0) return NULL;
  hid_t attr = H5Aopen(set, "columns", H5P_DEFAULT), type = H5Aget_type(attr), space = H5Aget_space(attr);
  hssize_t n = H5Sget_simple_extent_npoints(space);
  char *text = NULL;
  bool variable = H5Tis_variable_str(type) > 0;
  size_t size = variable ? sizeof(char *) : H5Tget_size(type), total = 1;
  if (H5Tget_class(type) == H5T_STRING && n > 0 && n <= LIMIT_COLUMNS && size <= LIMIT_MIB) {
    char *raw = calloc((size_t)n, size);
    hid_t memory = H5Tcopy(type);
    if (raw && H5Aread(attr, memory, raw) >= 0) {
      for (hssize_t k = 0; k < n; k++) {
        char *word = raw + (size_t)k * size;
        if (variable) memcpy(&word, raw + (size_t)k * size, sizeof word);
        total += (variable ? word ? strlen(word) : 0 : size) + 1;
      }
      text = calloc(total, 1);
      for (hssize_t k = 0; text && k < n; k++) {
        char *word = raw + (size_t)k * size;
        if (variable) memcpy(&word, raw + (size_t)k * size, sizeof word);
        if (word) strncat(text, word, variable ? strlen(word) : size);
        strcat(text, "\n");
      }
      if (variable) H5Dvlen_reclaim(memory, space, H5P_DEFAULT, raw);
    }
    H5Tclose(memory);
    free(raw);
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attr);
  for (char *c = text; c && *c; c++)
    if (*c == ',' || *c == ' ') *c = '\n';
  return text;
}

/* Index of a name in the list of column_names, SIZE_MAX when it is not there. */
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

/* One column of a 2D dataset: however wide it is, there is memory for one. */
static bool read_wide(const table *t, hid_t set, size_t column, double *data) {
  const hsize_t start[H5_MAX_RANK] = {t->rows.first, column}, count[H5_MAX_RANK] = {t->rows.n, 1, 1, 1};
  return read_box(set, H5T_NATIVE_DOUBLE, start, count, data);
}

static sd_status read_matrix(table *t, hid_t set, size_t rows, size_t width) {
  sd_status status = size_rows(t, "", rows);
  if (status != SD_OK) return status;
  double *data = calloc(t->rows.n + 1, sizeof *data);
  if (!data) return sd_fail(t->messages, SD_ERROR_IO, "no memory to read %s", t->file->path);
  char *names = column_names(set);
  for (size_t c = 0; status != SD_ERROR_IO && c < t->n_columns; c++) {
    size_t from = names ? find_name(names, t->columns[c]) : c;
    if (from >= width)
      status =
          user_error(t, t->columns[c],
                     names ? "is not among the names in attribute \"columns\"" : "the dataset is too narrow");
    else if (t->rows.n > 0 && !read_wide(t, set, from, data))
      status = user_error(t, t->columns[c], "cannot be read as numbers");
    else
      scatter(t, c, data);
  }
  free(names);
  free(data);
  return status;
}

/* --- group of columns, or H5MD particles ---------------------------------------------------------- */

/* Of a vector. */
enum { MOST_COMPONENTS = 3 };

/* Short names of the components of H5MD elements. */
static const struct alias {
  const char *column, *element;
  int component; /* -1: a scalar per particle */
} aliases[] = {{"x", "position", 0},  {"y", "position", 1},   {"vx", "velocity", 0},
               {"vy", "velocity", 1}, {"theta", "angle", -1}, {"omega", "angular_velocity", -1}};

/* The rows asked for, `width` numbers each; of the last of so many frames. */
static sd_status read_rows(const table *t, const char *path, size_t frames, size_t width, double *data) {
  const hsize_t start[] = {frames ? frames - 1 : 0, t->rows.first, 0, 0, 0},
                count[] = {1, t->rows.n, width, 1, 1};
  const int skip = frames ? 0 : 1;
  if (t->rows.n == 0) return SD_OK;
  hid_t set = h5_open_data(t->file, path, NULL);
  if (set < 0) return SD_ERROR_IO;
  const bool good = read_box(set, H5T_NATIVE_DOUBLE, start + skip, count + skip, data);
  H5Oclose(set);
  return good ? SD_OK : SD_ERROR_IO;
}

/* Reads component (or the scalar) of the last frame, or of a fixed element, of shape [N] or [N][D]. */
static sd_status read_element(table *t, size_t column, const char *path, bool framed, int component) {
  const char *name = t->columns[column];
  size_t dims[H5_MAX_RANK];
  int rank;
  sd_status status = h5_shape(t->file, path, &rank, dims, t->messages);
  if (status != SD_OK) return status;
  const size_t *inner = dims + (framed ? 1 : 0);
  int inner_rank = rank - (framed ? 1 : 0);
  if (inner_rank != (component < 0 ? 1 : 2) || (framed && dims[0] == 0) ||
      (component >= 0 && ((size_t)component >= inner[1] || inner[1] > MOST_COMPONENTS)))
    return user_error(t, name, "has not the shape of one value per particle");
  status = size_rows(t, name, inner[0]);
  if (status != SD_OK) return status;
  const h5_range *r = &t->rows;
  const bool shared = h5_shared_set_of(t->file, path) != NULL;
  const size_t width = component < 0 ? 1 : inner[1], n = (shared ? r->all : r->n) * width;
  double *data = calloc(n + 1, sizeof *data);
  if (!data) return sd_fail(t->messages, SD_ERROR_IO, "no memory to read %s", t->file->path);
  if (shared) /* rows of shares come a frame at a time */
    status = framed ? h5_get_values(t->file, path, SD_F64, dims[0] - 1, 1, n, data, NULL)
                    : h5_get(t->file, path, SD_F64, n, data, NULL);
  else if (framed || (status = h5_check(t->file, path, r->all * width, NULL)) == SD_OK)
    status = read_rows(t, path, framed ? dims[0] : 0, width, data);
  if (status != SD_OK) status = user_error(t, name, "cannot be read as numbers");
  const double *first = data + (shared ? r->first * width : 0) + (component < 0 ? 0 : (size_t)component);
  double *values = t->values;
  for (size_t k = 0; values && status == SD_OK && k < r->n; k++)
    values[k * t->n_columns + column] = first[k * width];
  free(data);
  return status;
}

static bool is_set(const h5_file *file, const char *path) {
  if (!h5_exists(file, path)) return false;
  hid_t object = h5_open_object(file, path, NULL);
  bool set = object >= 0 && H5Iget_type(object) == H5I_DATASET;
  if (object >= 0) H5Oclose(object);
  return set;
}

static sd_status read_column(table *t, size_t c) {
  char path[1024];
  const char *base = strcmp(t->path, "/") == 0 ? "" : t->path, *element = t->columns[c];
  int component = -1;
  /* a dataset of the column's own name goes before an element that holds it */
  snprintf(path, sizeof path, "%s/%s", base, element);
  bool linked = h5_is_link(t->file, path);
  if (!h5_exists(t->file, path))
    for (size_t k = 0; k < sizeof aliases / sizeof *aliases; k++)
      if (strcmp(aliases[k].column, t->columns[c]) == 0) {
        element = aliases[k].element;
        component = aliases[k].component;
      }
  snprintf(path, sizeof path, "%s/%s", base, element);
  if (is_set(t->file, path)) return read_element(t, c, path, false, component);
  snprintf(path, sizeof path, "%s/%s/value", base, element);
  if (is_set(t->file, path)) return read_element(t, c, path, true, component);
  if (linked || h5_is_link(t->file, path))
    return user_error(t, t->columns[c], "is a link, which is not followed");
  return user_error(t, t->columns[c], "there is no such dataset");
}

/* --- which form ----------------------------------------------------------------------------------- */

static sd_status read_set(table *t, hid_t set) {
  size_t dims[H5_MAX_RANK];
  int rank;
  sd_status status = h5_shape(t->file, t->path, &rank, dims, t->messages);
  if (status != SD_OK) return status;
  hid_t type = H5Dget_type(set);
  if (h5_shared_set_of(t->file, t->path))
    status = sd_fail(t->messages, SD_ERROR_USER, "%s: %s is a column; expected the group that it is in",
                     t->file->path, t->path);
  else if (H5Tget_class(type) == H5T_COMPOUND)
    status = read_compound(t, set, type, rank);
  else if (rank == 2 && is_number(type))
    status = read_matrix(t, set, dims[0], dims[1]);
  else
    status = sd_fail(t->messages, SD_ERROR_USER,
                     "%s: %s is neither a compound dataset nor a 2D one of numbers", t->file->path, t->path);
  H5Tclose(type);
  return status;
}

sd_status h5_read_table(const char *file, const char *dataset, size_t n_columns, const char *const *columns,
                        double **values, h5_range *rows, sd_messages *messages) {
  *values = NULL;
  h5_file *h5;
  sd_status status = h5_open(file, &h5, messages), worst = status;
  if (status != SD_OK) return status;
  table t = {.file = h5,
             .path = dataset && *dataset ? dataset : "/",
             .n_columns = n_columns,
             .columns = columns,
             .rows = *rows,
             .messages = messages};
  *rows = (h5_range){0};
  hid_t object = h5_open_object(h5, t.path, messages);
  if (object < 0)
    worst = SD_ERROR_USER;
  else if (H5Iget_type(object) == H5I_DATASET)
    worst = read_set(&t, object);
  else
    /* every missing column gets its message */
    for (size_t c = 0; c < n_columns && !t.too_long; c++)
      if ((status = read_column(&t, c)) != SD_OK && worst == SD_OK) worst = status;
  if (object >= 0) H5Oclose(object);
  h5_close(h5, NULL);
  if (worst == SD_OK) {
    *values = t.values;
    *rows = t.rows;
  } else {
    free(t.values);
  }
  return worst;
}
