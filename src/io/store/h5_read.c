/* h5_read.c: reads HDF5 files: paths, shapes, datasets, attributes, lists of datasets, rows in
 * files of single ranks (shares); see h5.h. */
#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/h5.h"
#include "io/store/h5_private.h"

/* Returns true if there is an object at path, reached by hard links alone. Other links, which may
 * lead to other files, are not followed; *link is then true. HDF5 requires that every group on the
 * way exists before the next is asked for. */
static bool is_there(const h5_file *file, const char *path, bool *link) {
  *link = false;
  if (path[0] == '/' && path[1] == 0) return true;
  char *copy = memory_text(path);
  h5_quiet();
  bool there = true;
  for (char *slash = strchr(copy + 1, '/'); there; slash = strchr(slash + 1, '/')) {
    H5L_info_t info;
    if (slash) *slash = 0;
    there = H5Lexists(file->id, copy, H5P_DEFAULT) > 0 &&
            H5Lget_info(file->id, copy, &info, H5P_DEFAULT) >= 0;
    *link = there && info.type != H5L_TYPE_HARD;
    there = there && !*link;
    if (!slash) break;
    *slash = '/';
  }
  free(copy);
  return there;
}

bool h5_exists(const h5_file *file, const char *path) {
  bool link;
  return is_there(file, path, &link);
}

bool h5_is_link(const h5_file *file, const char *path) {
  bool link;
  is_there(file, path, &link);
  return link;
}

hid_t h5_open_object(const h5_file *file, const char *path, sd_messages *messages) {
  bool link;
  hid_t object =
      is_there(file, path, &link) ? H5Oopen(file->id, path, H5P_DEFAULT) : H5I_INVALID_HID;
  if (link)
    sd_fail(messages, SD_ERROR_IO,
            "%s: %s is a link, which is not followed; expected the data in this place", file->path,
            path);
  else if (object < 0)
    sd_fail(messages, SD_ERROR_IO, "%s: there is no dataset or group %s", file->path, path);
  return object;
}

const char *h5_set_trouble(hid_t set) {
  hid_t made = H5Dget_create_plist(set), type = H5Dget_type(set);
  const char *trouble = NULL;
  H5D_layout_t layout = H5Pget_layout(made);
  if (H5Pget_external_count(made) > 0)
    trouble = "its values stand in other files (external storage)";
  if (layout == H5D_VIRTUAL) trouble = "its values stand in other datasets (a virtual dataset)";
  hsize_t chunk[H5S_MAX_RANK], bytes = H5Tget_size(type);
  int rank = layout == H5D_CHUNKED ? H5Pget_chunk(made, H5S_MAX_RANK, chunk) : 0;
  const hsize_t most = (hsize_t)LIMIT_CHUNK * LIMIT_MIB;
  for (int k = 0; k < rank; k++)
    bytes = chunk[k] > 0 && bytes > most / chunk[k] ? most + 1 : bytes * chunk[k];
  if (bytes > most) trouble = "its chunks are too large";
  H5Tclose(type);
  H5Pclose(made);
  return trouble;
}

hid_t h5_open_data(const h5_file *file, const char *path, sd_messages *messages) {
  hid_t set = h5_open_object(file, path, messages);
  if (set < 0) return set;
  const char *trouble = H5Iget_type(set) != H5I_DATASET ? "it is no dataset" : h5_set_trouble(set);
  if (!trouble) return set;
  sd_fail(messages, SD_ERROR_IO, "%s: %s cannot be read: %s", file->path, path, trouble);
  H5Oclose(set);
  return H5I_INVALID_HID;
}

int h5_extent(hid_t set, size_t dims[H5_MAX_RANK]) {
  hsize_t extent[H5S_MAX_RANK] = {0};
  hid_t space = H5Dget_space(set);
  int rank = H5Sget_simple_extent_dims(space, extent, NULL);
  for (int k = 0; k < H5_MAX_RANK; k++) dims[k] = k < rank ? (size_t)extent[k] : 1;
  H5Sclose(space);
  return rank;
}

sd_status h5_shape(const h5_file *file, const char *path, int *rank, size_t *dims,
                   sd_messages *messages) {
  hid_t set = h5_open_data(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  *rank = h5_extent(set, dims);
  H5Oclose(set);
  if (*rank >= 0 && *rank <= H5_MAX_RANK) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: %s has a shape that cannot be read here", file->path,
                 path);
}

/* Returns the number of elements of a dataset; SIZE_MAX: it does not fit a size_t. */
static size_t elements(hid_t set) {
  hid_t space = H5Dget_space(set);
  hssize_t n = H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  return n < 0 ? SIZE_MAX : (size_t)n;
}

/* Returns true if the n values of a dataset are stored, or have at most 1 MiB. Values that were
 * never written would read as zeros, and a damaged size could ask for unlimited memory. The number
 * of stored bytes tells: compression saves at most a factor of LIMIT_EXPANSION. */
static bool is_stored(hid_t set, size_t n) {
  hid_t type = H5Dget_type(set);
  double bytes = (double)n * (double)H5Tget_size(type);
  H5Tclose(type);
  return bytes <= LIMIT_MIB || bytes <= LIMIT_EXPANSION * (double)H5Dget_storage_size(set);
}

/* Checks that a dataset has n elements and was written completely. */
static sd_status check_size(const h5_file *file, const char *path, hid_t set, size_t n,
                            sd_messages *messages) {
  size_t have = elements(set);
  if (have == n && (h5_shared_set_of(file, path) || is_stored(set, n))) return SD_OK;
  if (have == n)
    return sd_fail(messages, SD_ERROR_IO, "%s: %s was not written as a whole", file->path, path);
  return sd_fail(messages, SD_ERROR_IO, "%s: %s has %zu values where %zu are expected", file->path,
                 path, have, n);
}

sd_status h5_check(const h5_file *file, const char *path, size_t n, sd_messages *messages) {
  hid_t set = h5_open_data(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  sd_status status = check_size(file, path, set, n, messages);
  H5Oclose(set);
  return status;
}

sd_status h5_get(const h5_file *file, const char *path, sd_type type, size_t n, void *data,
                 sd_messages *messages) {
  hid_t set = h5_open_data(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  sd_status status = check_size(file, path, set, n, messages);
  char reason[200];
  const h5_shared_set *shared = h5_shared_set_of(file, path);
  size_t dims[H5_MAX_RANK];
  if (shared && status == SD_OK && n > 0 && h5_extent(set, dims) > 0)
    status = h5_shared_rows(file, shared, type, 0, dims[0], data, messages);
  else if (status == SD_OK && n > 0 &&
           H5Dread(set, h5_native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    status = sd_fail(messages, SD_ERROR_IO, "%s: cannot read %s: %s", file->path, path,
                     h5_reason(reason, sizeof reason));
  H5Oclose(set);
  return status;
}

void *h5_column(const h5_file *file, const char *path, sd_type type, size_t n, sd_status *status,
                sd_messages *messages) {
  /* checked before memory is allocated: a damaged file may ask for any number */
  if (*status == SD_OK) *status = h5_check(file, path, n, messages);
  void *data = NULL;
  if (*status == SD_OK)
    *status = memory_row(&data, n, sd_type_size(type))
                  ? h5_get(file, path, type, n, data, messages)
                  : sd_fail(messages, SD_ERROR_IO, "no memory to read %s", path);
  if (*status == SD_OK) return data;
  free(data);
  return NULL;
}

bool h5_read_slab(hid_t set, hid_t type, const hsize_t *start, const hsize_t *count, void *data) {
  hid_t space = H5Dget_space(set);
  hid_t memory = H5Screate_simple(H5Sget_simple_extent_ndims(space), count, NULL);
  const bool good = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                    H5Dread(set, type, memory, space, H5P_DEFAULT, data) >= 0;
  H5Sclose(memory);
  H5Sclose(space);
  return good;
}

sd_status h5_get_values(const h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                        size_t width, void *data, sd_messages *messages) {
  if (n == 0) return SD_OK;
  hid_t set = h5_open_data(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  const hsize_t start[H5S_MAX_RANK] = {first};
  hsize_t count[H5S_MAX_RANK] = {0}, each = 1;
  hid_t space = H5Dget_space(set);
  const int rank = H5Sget_simple_extent_dims(space, count, NULL);
  H5Sclose(space);
  for (int k = 1; k < rank; k++) each *= count[k];
  const h5_shared_set *shared = h5_shared_set_of(file, path);
  bool good = rank > 0 && first <= count[0] && n <= count[0] - first && each == (hsize_t)width;
  count[0] = n;
  good = good && (shared || h5_read_slab(set, h5_native(type), start, count, data));
  H5Oclose(set);
  if (good && shared) return h5_shared_rows(file, shared, type, first, n, data, messages);
  if (good) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: cannot read rows of %s", file->path, path);
}

/* Reads a string of fixed or variable length from a dataset or an attribute; NULL: it is no
 * string. */
static char *read_text(hid_t id, bool attribute) {
  hid_t type = attribute ? H5Aget_type(id) : H5Dget_type(id);
  hid_t space = attribute ? H5Aget_space(id) : H5Dget_space(id);
  char *text = NULL;
  bool one = H5Sget_simple_extent_npoints(space) == 1 &&
             H5Tget_size(type) <= (size_t)LIMIT_TEXT * LIMIT_MIB;
  if (one && H5Tget_class(type) == H5T_STRING) {
    if (H5Tis_variable_str(type) > 0) {
      hid_t memory = H5Tcopy(H5T_C_S1);
      H5Tset_size(memory, H5T_VARIABLE);
      H5Tset_cset(memory, H5Tget_cset(type));
      char *found = NULL;
      herr_t result = attribute ? H5Aread(id, memory, &found)
                                : H5Dread(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, &found);
      if (result >= 0) text = memory_text(found);
      if (found) H5free_memory(found);
      H5Tclose(memory);
    } else {
      text = memory_new(H5Tget_size(type) + 1, 1);
      herr_t result = attribute ? H5Aread(id, type, text)
                                : H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text);
      if (result < 0) {
        free(text);
        text = NULL;
      }
    }
  }
  H5Sclose(space);
  H5Tclose(type);
  return text_clean(text);
}

char *h5_get_text(const h5_file *file, const char *path) {
  hid_t set = h5_open_data(file, path, NULL);
  if (set < 0) return NULL;
  char *text = read_text(set, false);
  H5Oclose(set);
  return text;
}

bool h5_has_attr(const h5_file *file, const char *path, const char *name) {
  return h5_exists(file, path) && H5Aexists_by_name(file->id, path, name, H5P_DEFAULT) > 0;
}

/* Reads an attribute of n elements as `type`. Returns false, with *value unchanged, if there is
 * none or it has another size. */
static bool get_attr(const h5_file *file, const char *path, const char *name, hid_t type, size_t n,
                     void *value) {
  if (!h5_has_attr(file, path, name)) return false;
  hid_t attr = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attr < 0) return false;
  hid_t space = H5Aget_space(attr);
  bool found =
      H5Sget_simple_extent_npoints(space) == (hssize_t)n && H5Aread(attr, type, value) >= 0;
  H5Sclose(space);
  H5Aclose(attr);
  return found;
}

double h5_get_attr_f64(const h5_file *file, const char *path, const char *name, double otherwise) {
  get_attr(file, path, name, H5T_NATIVE_DOUBLE, 1, &otherwise);
  return otherwise;
}

int64_t h5_get_attr_i64(const h5_file *file, const char *path, const char *name,
                        int64_t otherwise) {
  get_attr(file, path, name, H5T_NATIVE_INT64, 1, &otherwise);
  return otherwise;
}

bool h5_get_attr_f64s(const h5_file *file, const char *path, const char *name, size_t n,
                      double *values) {
  return get_attr(file, path, name, H5T_NATIVE_DOUBLE, n, values);
}

char *h5_get_attr_text(const h5_file *file, const char *path, const char *name) {
  if (!h5_has_attr(file, path, name)) return NULL;
  hid_t attr = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attr < 0) return NULL;
  char *text = read_text(attr, true);
  H5Aclose(attr);
  return text;
}

/* Joins n strings of `size` bytes, or n pointers to strings, into one text with a newline after
 * each. */
static char *join_words(const char *raw, size_t n, size_t size, bool variable) {
  char *text = NULL;
  size_t length;
  FILE *out = open_memstream(&text, &length);
  if (!out) memory_lacks(0);
  for (size_t k = 0; k < n; k++) {
    const char *word = raw + k * size;
    if (variable) memcpy(&word, raw + k * size, sizeof word);
    fprintf(out, "%.*s\n", variable ? INT_MAX : (int)size, word ? word : "");
  }
  if (fclose(out) != 0) memory_lacks(length);
  return text;
}

char *h5_words(const h5_file *file, const char *path, const char *name) {
  if (!h5_has_attr(file, path, name)) return NULL;
  hid_t attr = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attr < 0) return NULL;
  hid_t type = H5Aget_type(attr), space = H5Aget_space(attr), memory = H5Tcopy(type);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  const bool variable = H5Tis_variable_str(type) > 0;
  const size_t size = variable ? sizeof(char *) : H5Tget_size(type);
  char *text = NULL;
  if (H5Tget_class(type) == H5T_STRING && n > 0 && n <= LIMIT_COLUMNS && size <= LIMIT_MIB &&
      (size_t)n * size <= (size_t)LIMIT_TEXT * LIMIT_MIB) {
    char *raw = memory_new((size_t)n, size);
    const bool got = H5Aread(attr, memory, raw) >= 0;
    if (got) text = join_words(raw, (size_t)n, size, variable);
    if (got && variable) H5Dvlen_reclaim(memory, space, H5P_DEFAULT, raw);
    free(raw);
  }
  H5Tclose(memory);
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attr);
  for (char *c = text; c && *c; c++)
    if (*c == ',' || *c == ' ') *c = '\n';
  return text;
}

/* --- List of datasets ------------------------------------------------------------------------- */

/* Group that h5_visit is listing at present. */
typedef struct walk {
  const h5_file *file;
  h5_visitor *visit;
  void *user;
  const char *group; /* path of the group */
  int depth;         /* number of groups above it */
  size_t *listed;    /* number of links visited so far */
} walk;

/* Returns the sd_type in which values of this HDF5 type are best read. */
static sd_type nearest_type(hid_t type) {
  if (H5Tget_class(type) != H5T_INTEGER) return SD_F64;
  if (H5Tget_size(type) > 4) return SD_I64;
  return H5Tget_sign(type) == H5T_SGN_NONE ? SD_U32 : SD_I32;
}

/* Called for every link of a group: visits a dataset, walks through a group. Links, not objects,
 * are visited: a dataset that several elements share by hard links is listed in each. Groups may be
 * linked in rings: limits of depth and number end that. A negative value ends the walk. */
static herr_t list_link(hid_t group, const char *name, const H5L_info_t *info, void *user) {
  const walk *at = user;
  if (info->type != H5L_TYPE_HARD) return 0;
  if (++*at->listed > LIMIT_LINKS || at->depth > LIMIT_GROUPS) return -1;
  hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  if (object < 0) return -1;
  char *path = format_text("%s/%s", at->group, name);
  herr_t result = 0;
  if (H5Iget_type(object) == H5I_GROUP) {
    walk below = {at->file, at->visit, at->user, path, at->depth + 1, at->listed};
    result = H5Literate(object, H5_INDEX_NAME, H5_ITER_INC, NULL, list_link, &below);
  } else if (H5Iget_type(object) == H5I_DATASET) {
    size_t dims[H5_MAX_RANK];
    hid_t type = H5Dget_type(object);
    int rank = h5_extent(object, dims);
    at->visit(at->user, text_clean(path), nearest_type(type), H5Tget_class(type) == H5T_STRING,
              rank, dims);
    H5Tclose(type);
  }
  H5Oclose(object);
  free(path);
  return result < 0 ? -1 : 0;
}

sd_status h5_visit(const h5_file *file, h5_visitor *visit, void *user, sd_messages *messages) {
  size_t listed = 0;
  walk top = {file, visit, user, "", 0, &listed};
  h5_quiet();
  if (H5Literate(file->id, H5_INDEX_NAME, H5_ITER_INC, NULL, list_link, &top) >= 0) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: cannot list its contents", file->path);
}

/* --- Rows of shares --------------------------------------------------------------------------- */

/* Largest number of bytes that are read from a share (file of one rank) at a time, unless one row
 * is longer. */
enum { PIECE_BYTES = 1 << 20 };

const h5_shared_set *h5_shared_set_of(const h5_file *file, const char *path) {
  for (size_t k = 0; file->shares && k < file->shares->n_sets; k++)
    if (strcmp(file->shares->set[k].path, path) == 0) return &file->shares->set[k];
  return NULL;
}

/* Returns the index of the first of n ascending numbers place[] that is at least `at`; n: there is
 * none. */
static size_t first_at(const int64_t *place, size_t n, int64_t at) {
  size_t low = 0, high = n;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (place[middle] < at)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* Reads those of the rows [from, to) that share k (file of rank k) has to their positions in data.
 * Rows are numbered over all shares in the order of their keys. */
static sd_status get_piece(const h5_shares *s, const h5_shared_set *set, sd_type type, size_t k,
                           size_t from, size_t to, char *data, sd_messages *messages) {
  const int64_t *place = set->group->place[k];
  const size_t row = set->width * sd_type_size(type),
               most = row < PIECE_BYTES ? PIECE_BYTES / row : 1;
  size_t at = first_at(place, set->group->rows[k], (int64_t)from);
  const size_t end = first_at(place, set->group->rows[k], (int64_t)to);
  if (at == end) return SD_OK;
  char *path = format_text("%s%s", set->group->name, set->path);
  char *piece = memory_grow(NULL, end - at < most ? end - at : most, row);
  sd_status status = SD_OK;
  for (size_t n; status == SD_OK && at < end; at += n) {
    n = end - at < most ? end - at : most;
    status = h5_get_values(s->file[k], path, type, at, n, set->width, piece, messages);
    for (size_t i = 0; status == SD_OK && i < n; i++)
      memcpy(data + ((size_t)place[at + i] - from) * row, piece + i * row, row);
  }
  free(piece);
  free(path);
  return status;
}

/* Reads n rows of a joined dataset, from `first` on among the rows that are in the main file itself
 * and not in shares (files of single ranks), converted to type. */
static sd_status get_own(const h5_shared_set *set, sd_type type, size_t first, size_t n, void *data,
                         sd_messages *messages) {
  const size_t values = n * set->width, from = sd_type_size(set->type), to = sd_type_size(type);
  char *copy = NULL;
  bool good = memory_resize_row(&copy, values, from > to ? from : to);
  if (good) memcpy(copy, set->own + first * set->width * from, values * from);
  good = good &&
         H5Tconvert(h5_native(set->type), h5_native(type), values, copy, NULL, H5P_DEFAULT) >= 0;
  if (good) memcpy(data, copy, values * to);
  free(copy);
  return good ? SD_OK : sd_fail(messages, SD_ERROR_IO, "no memory to read %s", set->path);
}

sd_status h5_shared_rows(const h5_file *file, const h5_shared_set *set, sd_type type, size_t first,
                         size_t n, void *data, sd_messages *messages) {
  const h5_shares *s = file->shares;
  const size_t unit = set->group->each ? set->group->each : 1, total = set->group->total,
               from = first * unit, to = (first + n) * unit, end = to < total ? to : total,
               begin = from > total ? from : total, row = set->width * sd_type_size(type);
  sd_status status = SD_OK;
  assert(to <= total + set->tail);
  for (size_t k = 0; k < s->n && status == SD_OK && from < end; k++)
    status = get_piece(s, set, type, k, from, end, data, messages);
  if (status != SD_OK || to <= total) return status;
  return get_own(set, type, begin - total, to - begin, (char *)data + (begin - from) * row,
                 messages);
}
