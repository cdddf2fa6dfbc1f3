/* record.c: collects rows of output in memory and writes them to part files of the result; see
 * record.h. */
#include "io/results/record.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/results/trajectory.h"
#include "model/model.h"

/* Upper bound of the sort keys of contacts stored at one time (see checkpoint_order). */
static const int64_t MOMENT = INT64_C(1) << 33;

/* Adds the first column of a table in a share file (file of one rank): the key, which gives the
 * position of the row among the rows of all ranks. */
static table *add_key(table *t) {
  t->compress = true;
  table_add(t, "key", SD_I64, 0, NULL, "1", "order");
  return t;
}

void record_new(record *r, const sd_model *model, record_kind kind) {
  *r = (record){.model = model, .kind = kind};
  table *tables[RECORD_TABLES] = {&r->series,        &r->disks,        &r->walls,
                                  &r->contact_index, &r->contact_rows, &r->clumps};
  for (int k = 0; k < RECORD_TABLES; k++) r->tables[k] = tables[k];
  if (kind == RECORD_SHARE) {
    trajectory_add_bodies(add_key(&r->disks), model, "/disks/particles/disks", false, 0);
    trajectory_add_contacts(add_key(&r->contact_rows), model, "/contacts/contacts");
    return;
  }
  series_new(&r->series, model);
  trajectory_new_bodies(&r->disks, model, false, kind == RECORD_HEAD);
  trajectory_new_bodies(&r->walls, model, true, false);
  trajectory_new_contacts(&r->contact_index, &r->contact_rows, model, kind == RECORD_HEAD);
  trajectory_new_clumps(&r->clumps, model);
  resultants_new(&r->sums, model);
}

void record_free(record *r) {
  for (int k = 0; k < RECORD_TABLES; k++)
    if (r->tables[k]) table_free(r->tables[k]);
  resultants_free(&r->sums);
  *r = (record){0};
}

sd_status record_sample(record *r, unsigned what, const sd_state *state, const slot_table *slots,
                        const record_sums *sums, sd_messages *messages) {
  sd_status status = SD_OK;
  const bool take = what & RECORD_SERIES && !sums->others;
  assert(r->kind == RECORD_HEAD ||
         (r->kind == RECORD_WHOLE && state->n_bodies == sd_model_bodies(r->model)));
  const moment now = {r->model, state, &sums->energy, slots, take ? &r->sums : sums->others};
  if (take) status = resultants_compute(&r->sums, r->model, state, slots, NULL, messages);
  if (what & RECORD_SERIES && status == SD_OK) status = series_sample(&r->series, &now, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_bodies(&r->disks, &now, false, r->kind == RECORD_HEAD, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_bodies(&r->walls, &now, true, false, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_clumps(&r->clumps, &now, messages);
  if (what & RECORD_CONTACTS && status == SD_OK)
    status = trajectory_sample_contacts(&r->contact_index, &r->contact_rows, &now,
                                        r->kind == RECORD_HEAD ? r->n_contacts : state->n_contacts,
                                        messages);
  return status;
}

size_t record_bytes(const record *r) {
  size_t bytes = 0;
  for (int k = 0; k < RECORD_TABLES; k++) bytes += table_bytes(r->tables[k]);
  return bytes;
}

bool record_empty(const record *r) {
  for (int k = 0; k < RECORD_TABLES; k++)
    if (r->tables[k]->n_rows > 0) return false;
  return true;
}

void record_clear(record *r) {
  for (int k = 0; k < RECORD_TABLES; k++) table_clear(r->tables[k]);
}

/* GCOVR_EXCL_START: over ranks only */
bool record_has_shares(const record *head) {
  return head->disks.n_rows > 0 || head->contact_index.n_rows > 0;
}

void record_take_series(record *r, record *head) {
  assert(record_empty(r) && r->kind == RECORD_WHOLE && head->kind == RECORD_HEAD);
  const table series = r->series;
  r->series = head->series;
  head->series = series;
}

static int by_number(const void *one, const void *two) {
  const uint64_t p = *(const uint64_t *)one, q = *(const uint64_t *)two;
  return p < q ? -1 : p > q;
}

static void put_key(table *t, size_t row, int64_t key) {
  memcpy((int64_t *)table_cell(t, 0) + row, &key, sizeof key);
}

/* Adds a frame, one row per disk, with disks sorted by body number, so that keys ascend. */
static sd_status put_disks(record *r, const moment *now, size_t driven, int64_t first,
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

sd_status record_sample_share(record *r, unsigned what, const sd_state *s, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages) {
  assert(r->kind == RECORD_SHARE);
  const moment now = {.model = r->model, .state = s, .slots = slots};
  sd_status status = SD_OK;
  if (what & RECORD_FRAMES) status = table_reserve(&r->disks, s->n_disks, messages);
  if (what & RECORD_CONTACTS && status == SD_OK)
    status = table_reserve(&r->contact_rows, s->n_contacts, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = put_disks(r, &now, driven, frame * (int64_t)r->model->n_disks, messages);
  if (status != SD_OK || !(what & RECORD_CONTACTS) || s->n_contacts == 0) return status;
  for (size_t c = 0; c < s->n_contacts; c++)
    put_key(&r->contact_rows, c, moment_number * MOMENT + order->contact_key[c]);
  trajectory_put_contacts(&r->contact_rows, 1, &now, s->n_contacts, order->contact);
  table_commit(&r->contact_rows, s->n_contacts);
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

sd_status record_seal_share(record *r, const char *path, int64_t *sum, sd_messages *messages) {
  h5_file *file;
  uint64_t seal = 0;
  sd_status status = h5_new(&file, messages);
  if (status != SD_OK) return status;
  put_table(file, &r->disks, "/disks", (int64_t)r->model->n_disks);
  put_table(file, &r->contact_rows, "/contacts", 0);
  status = h5_save(file, -1, path, &seal, messages);
  record_clear(r);
  *sum = (int64_t)seal;
  return status;
}
/* GCOVR_EXCL_STOP */

sd_status record_seal(record *r, int folder, const char *path, const record_link *link,
                      size_t n_shares, const int64_t *shares, uint64_t *sum,
                      sd_messages *messages) {
  h5_file *file;
  sd_status status = h5_new(&file, messages);
  if (status != SD_OK) return status;
  h5_attr_text(file, "/", "run_id", link->run_id);
  h5_attr_i64(file, "/", "part", link->number);
  h5_attr_i64(file, "/", "after", (int64_t)link->after);
  for (int k = 0; k < RECORD_TABLES; k++) table_write(r->tables[k], file);
  if (n_shares > 0) h5_put_shares(file, n_shares, shares);
  status = h5_save(file, folder, path, sum, messages);
  if (status == SD_OK) record_clear(r);
  return status;
}

sd_status record_open(int folder, const char *path, const record_link *link, h5_file **out,
                      uint64_t *sum, sd_messages *messages) {
  sd_status status = h5_open_sealed(folder, path, out, sum, messages);
  if (status != SD_OK) return status;
  char *run_id = h5_get_attr_text(*out, "/", "run_id");
  bool same_run = run_id && strcmp(run_id, link->run_id) == 0;
  bool same_place = h5_get_attr_i64(*out, "/", "part", -1) == link->number &&
                    (uint64_t)h5_get_attr_i64(*out, "/", "after", -1) == link->after;
  free(run_id);
  if (same_run && same_place) return SD_OK;
  h5_close(*out, NULL);
  *out = NULL;
  return sd_fail(messages, SD_ERROR_IO,
                 same_run ? "%s is a part of this run, but does not follow on the one before it"
                          : "%s is a part of another run",
                 path);
}
