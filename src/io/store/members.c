/* members.c: writes and reads structs as groups of datasets or as attributes; see members.h. */
#include "io/store/members.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

/* Members that have another name since file format 5: present name, and name in older files. */
static const struct renamed {
  const char *now, *before;
} renamed[] = {{"elastic_tangential", "elastic_skin"},
               {"nonconservative_work", "variant"},
               {"zeta", "stretch"}};
enum { RENAMED = sizeof renamed / sizeof *renamed };

char *members_path(const h5_file *file, const char *path) {
  char *found = memory_text(path);
  for (size_t k = 0; k < RENAMED && !h5_exists(file, found); k++) {
    const char *at = strstr(path, renamed[k].now), *after = at ? at + strlen(renamed[k].now) : NULL;
    if (!at || at == path || at[-1] != '/' || (*after && *after != '/')) continue;
    free(found);
    found = format_text("%.*s%s%s", (int)(at - path), path, renamed[k].before, after);
  }
  return found;
}

/* Returns the name of an attribute, or its older name if the object has none of this name. */
static const char *attr_name(const h5_file *file, const char *path, const char *name) {
  for (size_t k = 0; k < RENAMED; k++)
    if (strcmp(name, renamed[k].now) == 0 && !h5_has_attr(file, path, name))
      return renamed[k].before;
  return name;
}

void members_put(h5_file *file, const char *group, const char *name, sd_type type, int rank,
                 const size_t *dims, const void *data, bool compress, const char *unit,
                 const char *meaning) {
  if (!h5_check_memory(file, data, group)) return;
  char *path = format_text("%s/%s", group, name);
  h5_put(file, path, type, rank, dims, data, compress);
  h5_attr_text(file, path, "unit", unit);
  h5_attr_text(file, path, "description", meaning);
  free(path);
}

/* Allocates memory for n values of any quantity in the list; the caller frees it. NULL: no
 * memory. */
static void *make_room(const observable_list *list, size_t n) {
  size_t most = 1;
  void *room;
  for (size_t k = 0; k < list->n; k++) {
    const size_t row = list->rows[k].width * sd_type_size(observable_stored(&list->rows[k]));
    most = row > most ? row : most;
  }
  return memory_row(&room, n, most) ? room : NULL;
}

void members_write(h5_file *file, const char *group, const observable_list *list, const void *first,
                   size_t stride, size_t n) {
  h5_group(file, group);
  void *dense = make_room(list, n);
  for (size_t k = 0; h5_check_memory(file, dense, group) && k < list->n; k++) {
    const observable *o = &list->rows[k];
    assert(o->width >= 1);
    sd_type type = observable_stored(o);
    size_t dims[2] = {n, o->width};
    for (size_t i = 0; i < n * o->width; i++)
      observable_store(
          o, dense, i,
          observable_value(o, (const char *)first + i / o->width * stride, i % o->width));
    members_put(file, group, o->name, type, o->width > 1 ? 2 : 1, dims, dense, true, o->unit,
                o->meaning);
  }
  free(dense);
}

sd_status members_read(const h5_file *file, const char *group, const observable_list *list,
                       void *first, size_t stride, size_t n, sd_messages *messages) {
  sd_status status = SD_OK;
  void *dense = NULL;
  for (size_t k = 0; status == SD_OK && k < list->n; k++) {
    const observable *o = &list->rows[k];
    if (o->get) continue;
    sd_type type = observable_stored(o);
    char *wanted = format_text("%s/%s", group, o->name), *path = members_path(file, wanted);
    free(wanted);
    bool there = k == 0 || h5_exists(file, path);
    if (there) status = h5_check(file, path, n * o->width, messages);
    if (status == SD_OK && !dense && !(dense = make_room(list, n)))
      status = sd_fail(messages, SD_ERROR_IO, "no memory for %s", group);
    if (status == SD_OK && there) status = h5_get(file, path, type, n * o->width, dense, messages);
    for (size_t i = 0; status == SD_OK && i < n * o->width; i++)
      observable_set(o, (char *)first + i / o->width * stride, i % o->width,
                     there            ? observable_element(type, dense, i)
                     : type == SD_F64 ? NAN
                                      : 0);
    free(path);
  }
  free(dense);
  return status;
}

/* Integer members of 64 bits are written directly, since a double would lose digits. */
void members_write_attrs(h5_file *file, const char *path, const observable_list *list,
                         const void *row) {
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    if (o->type == OBSERVABLE_I64 && !o->get)
      h5_attr(file, path, o->name, SD_I64, 0, (const char *)row + o->offset);
    else if (observable_stored(o) == SD_F64)
      h5_attr_f64(file, path, o->name, observable_value(o, row, 0));
    else
      h5_attr_i64(file, path, o->name, (int64_t)observable_value(o, row, 0));
  }
}

void members_read_attrs(const h5_file *file, const char *path, const observable_list *list,
                        void *row) {
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    if (o->get) continue;
    const char *name = attr_name(file, path, o->name);
    bool real = observable_stored(o) == SD_F64;
    int64_t whole = real ? 0 : h5_get_attr_i64(file, path, name, 0);
    if (o->type == OBSERVABLE_I64)
      memcpy((char *)row + o->offset, &whole, sizeof whole);
    else
      observable_set(o, row, 0, real ? h5_get_attr_f64(file, path, name, NAN) : (double)whole);
  }
}

void members_write_lines(h5_file *file, const char *path, size_t n, char *const *lines) {
  size_t total = 1;
  for (size_t k = 0; k < n; k++) total += (lines[k] ? strlen(lines[k]) : 0) + 1;
  char *text = memory_new(total, 1), *at = text;
  for (size_t k = 0; k < n; k++) at += sprintf(at, "%s\n", lines[k] ? lines[k] : "");
  assert((size_t)(at - text) == total - 1);
  *at = 0;
  h5_put_text(file, path, text);
  free(text);
}

void members_read_lines(const h5_file *file, const char *path, size_t n, char **lines) {
  char *text = h5_get_text(file, path);
  const char *at = text ? text : "";
  for (size_t k = 0; k < n; k++) {
    size_t length = strcspn(at, "\n");
    lines[k] = format_text("%.*s", (int)length, at);
    at += length + (at[length] != 0);
  }
  free(text);
}
