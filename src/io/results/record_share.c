/* record_share.c: see record_share.h. The first column of a table is its key. */
#include "io/results/record_share.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/results/trajectory.h"

/* Keys of one moment are less than this, see checkpoint_order. */
static const int64_t MOMENT = INT64_C(1) << 33;

static table *begin(table *t) {
  t->compress = true;
  table_add(t, "key", SD_I64, 0, NULL, "1", "order");
  return t;
}

void record_share_new(record_share *r, const sd_model *model) {
  *r = (record_share){.model = model};
  trajectory_add_bodies(begin(&r->disks), model, "/disks/particles/disks", false, 0);
  trajectory_add_contacts(begin(&r->contacts), "/contacts/contacts");
}

void record_share_free(record_share *r) {
  table_free(&r->disks);
  table_free(&r->contacts);
}

size_t record_share_bytes(const record_share *r) {
  return table_bytes(&r->disks) + table_bytes(&r->contacts);
}

static int by_number(const void *one, const void *two) {
  const uint64_t p = *(const uint64_t *)one, q = *(const uint64_t *)two;
  return p < q ? -1 : p > q;
}

static void put_key(table *t, size_t row, int64_t key) {
  memcpy((int64_t *)table_cell(t, 0) + row, &key, sizeof key);
}

/* Keys ascend: disks go by their numbers. */
static sd_status put_disks(record_share *r, const moment *now, size_t driven, int64_t first,
                           sd_messages *messages) {
  const sd_state *s = now->state;
  uint64_t *list;
  uint32_t *slots;
  size_t n = 0;
  if (!memory_rows(2, (memory_column[]){{&list, s->n_disks, sizeof *list},
                                        {&slots, s->n_disks, sizeof *slots}}))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the results");
  for (size_t slot = 0; slot < s->n_disks; slot++)
    if (slot < s->n_free || slot >= driven) list[n++] = (uint64_t)s->id[slot] << 32 | slot;
  qsort(list, n, sizeof *list, by_number);
  for (size_t k = 0; k < n; k++) {
    put_key(&r->disks, k, first + (int64_t)(list[k] >> 32));
    slots[k] = (uint32_t)list[k];
  }
  const size_t end = trajectory_put_bodies(&r->disks, 1, now, false, n, slots);
  assert(end == r->disks.n_columns);
  table_commit(&r->disks, n);
  free(list);
  free(slots);
  return SD_OK;
}

sd_status record_share_sample(record_share *r, unsigned what, const sd_state *s, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages) {
  const moment now = {.model = r->model, .state = s, .slots = slots};
  sd_status status = SD_OK;
  if (what & RECORD_FRAMES) status = table_reserve(&r->disks, s->n_disks, messages);
  if (what & RECORD_CONTACTS && status == SD_OK)
    status = table_reserve(&r->contacts, s->n_contacts, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = put_disks(r, &now, driven, frame * (int64_t)r->model->n_disks, messages);
  if (status != SD_OK || !(what & RECORD_CONTACTS) || s->n_contacts == 0) return status;
  for (size_t c = 0; c < s->n_contacts; c++)
    put_key(&r->contacts, c, moment_number * MOMENT + order->contact_key[c]);
  trajectory_put_contacts(&r->contacts, 1, &now, s->n_contacts, order->contact);
  table_commit(&r->contacts, s->n_contacts);
  return SD_OK;
}

static void put_table(h5_file *file, const table *t, const char *group, int64_t each) {
  for (size_t k = 0; k < t->n_columns; k++) {
    const table_column *c = &t->columns[k];
    char *key = k == 0 ? format_text("%s/key", group) : NULL;
    const char *path = key ? key : c->path;
    size_t dims[H5_MAX_RANK];
    const int rank = table_shape(c, t->n_rows, dims);
    h5_put(file, path, c->type, rank, dims, c->data, t->compress);
    h5_attr_text(file, path, "unit", c->unit);
    h5_attr_text(file, path, "description", c->meaning);
    if (key && each > 0) h5_attr_i64(file, key, "each", each);
    free(key);
  }
}

sd_status record_share_seal(record_share *r, const char *path, int64_t *sum,
                            sd_messages *messages) {
  h5_file *file;
  uint64_t seal = 0;
  sd_status status = h5_new(&file, messages);
  if (status != SD_OK) return status;
  put_table(file, &r->disks, "/disks", (int64_t)r->model->n_disks);
  put_table(file, &r->contacts, "/contacts", 0);
  status = h5_save(file, -1, path, &seal, messages);
  table_clear(&r->disks);
  table_clear(&r->contacts);
  *sum = (int64_t)seal;
  return status;
}
