/* h5_read.c: reading; see h5.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/shortage.h"
#include "io/h5.h"
#include "io/h5_private.h"

/* H5Lexists wants every group on the way to exist: each is asked for in turn. */
bool h5_exists(const h5_file *file, const char *path) {
  if (path[0] == '/' && path[1] == 0) return true;
  char *copy = malloc(strlen(path) + 1);
  if (!copy) shortage_note();
  if (!copy) return false;
  strcpy(copy, path);
  bool exists = true;
  for (char *slash = strchr(copy + 1, '/'); exists; slash = strchr(slash + 1, '/')) {
    if (slash) *slash = 0;
    exists = H5Lexists(file->id, copy, H5P_DEFAULT) > 0;
    if (!slash) break;
    *slash = '/';
  }
  free(copy);
  return exists;
}

static hid_t open_set(const h5_file *file, const char *path, sd_messages *messages) {
  h5_quiet();
  hid_t set = h5_exists(file, path) ? H5Dopen2(file->id, path, H5P_DEFAULT) : H5I_INVALID_HID;
  if (set < 0) sd_fail(messages, SD_ERROR_IO, "%s: there is no dataset %s", file->path, path);
  return set;
}

static int shape_of(hid_t set, size_t *dims) {
  hsize_t extent[H5S_MAX_RANK] = {0};
  hid_t space = H5Dget_space(set);
  int rank = H5Sget_simple_extent_dims(space, extent, NULL);
  for (int k = 0; k < H5_MAX_RANK; k++) dims[k] = k < rank ? (size_t)extent[k] : 1;
  H5Sclose(space);
  return rank;
}

sd_status h5_shape(const h5_file *file, const char *path, int *rank, size_t *dims, sd_messages *messages) {
  hid_t set = open_set(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  *rank = shape_of(set, dims);
  H5Dclose(set);
  if (*rank >= 0 && *rank <= H5_MAX_RANK) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: %s has a shape that cannot be read here", file->path, path);
}

sd_status h5_get(const h5_file *file, const char *path, sd_type type, size_t n, void *data,
                 sd_messages *messages) {
  hid_t set = open_set(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  size_t dims[H5_MAX_RANK], have = 1;
  int rank = shape_of(set, dims);
  for (int k = 0; k < rank && k < H5_MAX_RANK; k++) have *= dims[k];
  sd_status status = SD_OK;
  char reason[200];
  if (have != n)
    status = sd_fail(messages, SD_ERROR_IO, "%s: %s has %zu values where %zu are expected", file->path, path,
                     have, n);
  else if (n > 0 && H5Dread(set, h5_native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    status = sd_fail(messages, SD_ERROR_IO, "%s: cannot read %s: %s", file->path, path,
                     h5_reason(reason, sizeof reason));
  H5Dclose(set);
  return status;
}

sd_status h5_get_rows(const h5_file *file, const char *path, sd_type type, size_t first, size_t n, void *data,
                      sd_messages *messages) {
  if (n == 0) return SD_OK;
  hid_t set = open_set(file, path, messages);
  if (set < 0) return SD_ERROR_IO;
  hsize_t start[H5S_MAX_RANK] = {0}, count[H5S_MAX_RANK] = {0};
  hid_t space = H5Dget_space(set);
  int rank = H5Sget_simple_extent_dims(space, count, NULL);
  bool good = rank > 0 && first + n <= count[0];
  start[0] = first;
  count[0] = n;
  hid_t memory = good ? H5Screate_simple(rank, count, NULL) : H5I_INVALID_HID;
  good = good && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
         H5Dread(set, h5_native(type), memory, space, H5P_DEFAULT, data) >= 0;
  if (memory >= 0) H5Sclose(memory);
  H5Sclose(space);
  H5Dclose(set);
  if (good) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: cannot read rows of %s", file->path, path);
}

/* A string, of fixed or variable length, from a dataset or an attribute. */
static char *read_text(hid_t id, bool attribute) {
  hid_t type = attribute ? H5Aget_type(id) : H5Dget_type(id);
  hid_t space = attribute ? H5Aget_space(id) : H5Dget_space(id);
  char *text = NULL;
  bool one = H5Sget_simple_extent_npoints(space) == 1;
  if (one && H5Tget_class(type) == H5T_STRING) {
    if (H5Tis_variable_str(type) > 0) {
      hid_t memory = H5Tcopy(H5T_C_S1);
      H5Tset_size(memory, H5T_VARIABLE);
      H5Tset_cset(memory, H5Tget_cset(type));
      char *found = NULL;
      herr_t result = attribute ? H5Aread(id, memory, &found)
                                : H5Dread(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, &found);
      if (result >= 0 && found && !(text = malloc(strlen(found) + 1))) shortage_note();
      if (text) strcpy(text, found);
      if (found) H5free_memory(found);
      H5Tclose(memory);
    } else {
      text = calloc(H5Tget_size(type) + 1, 1);
      if (!text) shortage_note();
      herr_t result = !text       ? -1
                      : attribute ? H5Aread(id, type, text)
                                  : H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text);
      if (result < 0) {
        free(text);
        text = NULL;
      }
    }
  }
  H5Sclose(space);
  H5Tclose(type);
  return text;
}

char *h5_get_text(const h5_file *file, const char *path) {
  hid_t set = open_set(file, path, NULL);
  if (set < 0) return NULL;
  char *text = read_text(set, false);
  H5Dclose(set);
  return text;
}

bool h5_has_attr(const h5_file *file, const char *path, const char *name) {
  return h5_exists(file, path) && H5Aexists_by_name(file->id, path, name, H5P_DEFAULT) > 0;
}

/* Reads an attribute of n elements as `type`; leaves value as it is when there is none. */
static bool get_attr(const h5_file *file, const char *path, const char *name, hid_t type, size_t n,
                     void *value) {
  if (!h5_has_attr(file, path, name)) return false;
  hid_t attr = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attr < 0) return false;
  hid_t space = H5Aget_space(attr);
  bool found = H5Sget_simple_extent_npoints(space) == (hssize_t)n && H5Aread(attr, type, value) >= 0;
  H5Sclose(space);
  H5Aclose(attr);
  return found;
}

double h5_get_attr_f64(const h5_file *file, const char *path, const char *name, double otherwise) {
  get_attr(file, path, name, H5T_NATIVE_DOUBLE, 1, &otherwise);
  return otherwise;
}

int64_t h5_get_attr_i64(const h5_file *file, const char *path, const char *name, int64_t otherwise) {
  get_attr(file, path, name, H5T_NATIVE_INT64, 1, &otherwise);
  return otherwise;
}

bool h5_get_attr_f64s(const h5_file *file, const char *path, const char *name, size_t n, double *values) {
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

/* --- list ----------------------------------------------------------------------------------------- */

typedef struct walk {
  const h5_file *file;
  h5_visitor *visit;
  void *user;
  const char *group;
} walk;

static sd_type nearest_type(hid_t type) {
  if (H5Tget_class(type) != H5T_INTEGER) return SD_F64;
  if (H5Tget_size(type) > 4) return SD_I64;
  return H5Tget_sign(type) == H5T_SGN_NONE ? SD_U32 : SD_I32;
}

/* Links, not objects, are walked: a hard link shared by several elements is listed in each. */
static herr_t list_link(hid_t group, const char *name, const H5L_info_t *info, void *user) {
  const walk *at = user;
  if (info->type != H5L_TYPE_HARD) return 0;
  char *path = malloc(strlen(at->group) + strlen(name) + 2);
  if (!path) shortage_note();
  hid_t object = path ? H5Oopen(group, name, H5P_DEFAULT) : H5I_INVALID_HID;
  if (object < 0) {
    free(path);
    return -1;
  }
  herr_t listed = 0;
  sprintf(path, "%s/%s", at->group, name);
  if (H5Iget_type(object) == H5I_GROUP) {
    walk below = {at->file, at->visit, at->user, path};
    listed = H5Literate(object, H5_INDEX_NAME, H5_ITER_INC, NULL, list_link, &below);
  } else if (H5Iget_type(object) == H5I_DATASET) {
    size_t dims[H5_MAX_RANK];
    hid_t type = H5Dget_type(object);
    int rank = shape_of(object, dims);
    at->visit(at->user, path, nearest_type(type), H5Tget_class(type) == H5T_STRING, rank, dims);
    H5Tclose(type);
  }
  H5Oclose(object);
  free(path);
  return listed;
}

sd_status h5_visit(const h5_file *file, h5_visitor *visit, void *user, sd_messages *messages) {
  walk top = {file, visit, user, ""};
  h5_quiet();
  if (H5Literate(file->id, H5_INDEX_NAME, H5_ITER_INC, NULL, list_link, &top) >= 0) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s: cannot list its contents", file->path);
}
