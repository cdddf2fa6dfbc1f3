/* record_share.c: see record_share.h. The first column of a table is its key. */
#include "io/results/record_share.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

/* Keys of one moment are less than this, see checkpoint_order. */
static const int64_t MOMENT = INT64_C(1) << 33;

static void add_columns(table *t, const sd_model *model, const observable_list *list, const char *group,
                        const char *ending) {
  t->compress = true;
  table_add(t, "key", SD_I64, 0, NULL, "1", "order");
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    if (o->when && !o->when(model)) continue;
    const size_t width = o->width;
    char *path = format_text("%s/%s%s", group, o->name, ending);
    table_add(t, path, observable_stored(o), width > 1, &width, o->unit, o->meaning);
    free(path);
  }
}

void record_share_new(record_share *r, const sd_model *model) {
  *r = (record_share){.model = model};
  add_columns(&r->disks, model, &frame_observables, "/disks/particles/disks", "/value");
  add_columns(&r->contacts, model, &contact_observables, "/contacts/contacts", "");
}

void record_share_free(record_share *r) {
  table_free(&r->disks);
  table_free(&r->contacts);
}

size_t record_share_bytes(const record_share *r) {
  return table_bytes(&r->disks) + table_bytes(&r->contacts);
}

static void put_row(table *t, const sd_model *model, const observable_list *list, int64_t key,
                    const void *row) {
  size_t column = 0;
  memcpy(table_cell(t, column++), &key, sizeof key);
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    if (!o->when || o->when(model)) table_put(t, column++, 0, o, row, o->width > 1 ? o->width : 1);
  }
  assert(column == t->n_columns);
  table_commit(t, 1);
}

static int by_number(const void *one, const void *two) {
  const uint64_t p = *(const uint64_t *)one, q = *(const uint64_t *)two;
  return p < q ? -1 : p > q;
}

/* Keys ascend: disks go by their numbers. */
static sd_status put_disks(record_share *r, const sd_state *s, size_t driven, int64_t first,
                           sd_messages *messages) {
  uint64_t *list;
  size_t n = 0;
  if (!memory_rows(1, &(memory_column){&list, s->n_disks, sizeof *list}))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the results");
  for (size_t slot = 0; slot < s->n_disks; slot++)
    if (slot < s->n_free || slot >= driven) list[n++] = (uint64_t)s->id[slot] << 32 | slot;
  qsort(list, n, sizeof *list, by_number);
  for (size_t k = 0; k < n; k++)
    put_row(&r->disks, r->model, &frame_observables, first + (int64_t)(list[k] >> 32),
            &(moment_body){s, (uint32_t)list[k]});
  free(list);
  return SD_OK;
}

sd_status record_share_sample(record_share *r, unsigned what, const sd_state *s, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages) {
  const int64_t n_disks = (int64_t)r->model->n_disks;
  sd_status status = SD_OK;
  if (what & RECORD_FRAMES) status = table_reserve(&r->disks, s->n_disks, messages);
  if (what & RECORD_CONTACTS && status == SD_OK)
    status = table_reserve(&r->contacts, s->n_contacts, messages);
  if (status != SD_OK) return status;
  if (what & RECORD_FRAMES) status = put_disks(r, s, driven, frame * n_disks, messages);
  if (status != SD_OK) return status;
  for (size_t c = 0; what & RECORD_CONTACTS && c < s->n_contacts; c++)
    put_row(&r->contacts, r->model, &contact_observables, moment_number * MOMENT + order->contact_key[c],
            &(moment_contact){r->model, s, slots, order->contact[c]});
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

sd_status record_share_seal(record_share *r, const char *path, int64_t *sum, sd_messages *messages) {
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
