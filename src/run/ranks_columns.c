/* ranks_columns.c: see ranks_columns.h. */
#include "run/ranks_columns.h"

#include <assert.h>
#include <string.h>

#include "base/comm.h"
#include "model/cell.h"
#include "model/laws.h"

/* --- which ------------------------------------------------------------------------------------------------- */

/* Bytes of a free disk's row in this column; 0: it has none. The same on all ranks, also on those without disks. */
static size_t disk_row(const sd_model *m, const sd_field *f) {
  const size_t size = sd_type_size(f->type);
  switch (f->extent) {
    case SD_PER_BODY:
    case SD_PER_FREE: return size;
    case SD_PER_MEAN: return m->measure_disks ? size : 0;
    case SD_PER_MEAN_BIN: return m->measure_disks ? size * SD_MEAN_BINS : 0;
    case SD_PER_FIELDED: return m->n_fields ? size : 0;
    case SD_PER_LAW_FREE: return laws_features(m) & LAW_GENERAL ? size : 0;
    case SD_PER_CELL_DISK: return cell_deforms(m) ? size : 0;
    default: return 0;
  }
}

static size_t contact_row(const sd_state *s, const sd_field *f) {
  const bool there = f->extent == SD_PER_CONTACT || (f->extent == SD_PER_LAW_CONTACT && s->law_columns);
  return there ? sd_type_size(f->type) : 0;
}

/* The part of a column that every rank has: of prescribed bodies, motions, the run. */
static size_t common_part(const sd_state *s, const sd_field *f, char **at) {
  const size_t size = sd_type_size(f->type);
  *at = sd_field_data(s, f);
  if (state_of_free(f->extent) || state_of_contacts(f->extent)) return 0;
  if (f->extent != SD_PER_BODY) return size * sd_extent_size(s, f->extent);
  const size_t first = s->n_free + s->n_ghosts;
  *at += size * first;
  return size * (s->n_bodies - first);
}

void common_take(const sd_state *from, sd_state *to) {
  for (size_t k = 0; k < sd_field_count; k++) {
    char *source, *target;
    const size_t bytes = common_part(from, &sd_fields[k], &source);
    const size_t room = common_part(to, &sd_fields[k], &target);
    assert(bytes == room);
    if (bytes > 0) memcpy(target, source, bytes);
  }
}

/* --- rows --------------------------------------------------------------------------------------------------- */

static void add(moving *m, const sd_field *f, size_t size) {
  if (size == 0) return;
  assert(m->n < MOVING_MOST);
  m->field[m->n] = f;
  m->size[m->n++] = size;
}

void moving_disks(moving *m, const sd_model *model, bool bodies) {
  for (size_t k = 0; k < sd_field_count; k++)
    if (!bodies || sd_fields[k].extent == SD_PER_BODY) add(m, &sd_fields[k], disk_row(model, &sd_fields[k]));
}

void moving_contacts(moving *m) {
  for (size_t k = 0; k < sd_field_count; k++) add(m, &sd_fields[k], contact_row(m->to, &sd_fields[k]));
}

static bool is_zero(const char *data, size_t bytes) {
  assert(data || bytes == 0);
  return bytes == 0 || (data[0] == 0 && memcmp(data, data + 1, bytes - 1) == 0);
}

/* At the start most columns are zero on all ranks, as those of new parts are. */
static size_t leave_zeros(const moving *m, size_t n, route_column *list) {
  const size_t rows = state_of_contacts(m->field[0]->extent) ? m->from->n_contacts : m->from->n_free;
  int64_t has[MOVING_NARROW];
  size_t left = 0;
  assert(n <= MOVING_NARROW);
  for (size_t k = 0; k < n; k++) has[k] = !is_zero(list[k].from, rows * list[k].size);
  comm_add(m->route->comm, has, n);
  for (size_t k = 0; k < n; k++)
    if (has[k]) list[left++] = list[k];
  return left;
}

sd_status moving_send(const moving *m, const uint32_t *place) {
  const size_t most = m->narrow ? MOVING_NARROW : m->n;
  sd_status status = SD_OK;
  for (size_t k = 0; k < m->n && status == SD_OK; k += most) {
    route_column list[MOVING_MOST];
    size_t n = m->n - k < most ? m->n - k : most;
    for (size_t c = 0; c < n; c++) {
      const sd_field *f = m->field[k + c];
      list[c] = (route_column){sd_field_data(m->from, f), sd_field_data(m->to, f), m->size[k + c]};
    }
    if (m->narrow) n = leave_zeros(m, n, list);
    if (n > 0) status = route_columns(m->route, list, n, place);
  }
  return status;
}
