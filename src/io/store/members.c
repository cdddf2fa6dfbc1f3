/* members.c: see members.h. */
#include "io/store/members.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/store/file.h"

/* Copies a member between the structures and a dense array. */
static void pack(const member *m, char *first, size_t stride, size_t n, char *dense, bool out) {
  size_t bytes = m->width * sd_type_size(m->type);
  for (size_t k = 0; k < n; k++) {
    char *at = first + k * stride + m->offset;
    memcpy(out ? dense + k * bytes : at, out ? at : dense + k * bytes, bytes);
  }
}

void members_write(h5_file *file, const char *group, const member *members, size_t n_members, void *first,
                   size_t stride, size_t n) {
  h5_group(file, group);
  for (size_t k = 0; k < n_members; k++) {
    const member *m = &members[k];
    size_t dims[2] = {n, m->width};
    char *dense = calloc(n * m->width + 1, sd_type_size(m->type)),
         *path = format_text("%s/%s", group, m->name);
    if (h5_have(file, dense && path, group)) {
      pack(m, first, stride, n, dense, true);
      h5_put(file, path, m->type, m->width > 1 ? 2 : 1, dims, dense, true);
      h5_attr_text(file, path, "unit", m->unit);
      h5_attr_text(file, path, "description", m->meaning);
    }
    free(dense);
    free(path);
  }
}

sd_status members_read(const h5_file *file, const char *group, const member *members, size_t n_members,
                       void *first, size_t stride, size_t n, sd_messages *messages) {
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < n_members; k++) {
    const member *m = &members[k];
    char *dense = calloc(n * m->width + 1, sd_type_size(m->type)),
         *path = format_text("%s/%s", group, m->name);
    if (!dense || !path) status = sd_fail(messages, SD_ERROR_IO, "no memory for %s", group);
    if (status == SD_OK) status = h5_get(file, path, m->type, n * m->width, dense, messages);
    if (status == SD_OK) pack(m, first, stride, n, dense, false);
    free(dense);
    free(path);
  }
  return status;
}
