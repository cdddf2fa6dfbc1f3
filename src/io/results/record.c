/* record.c: see record.h. */
#include "io/results/record.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/results/series.h"
#include "io/results/trajectory.h"

void record_new(record *r, const sd_model *model, bool shared) {
  *r = (record){.model = model, .shared = shared};
  table *tables[RECORD_TABLES] = {&r->series,        &r->disks,        &r->walls,
                                  &r->contact_index, &r->contact_rows, &r->clumps};
  for (int k = 0; k < RECORD_TABLES; k++) r->tables[k] = tables[k];
  series_new(&r->series, model);
  trajectory_new_bodies(&r->disks, model, false, shared);
  trajectory_new_bodies(&r->walls, model, true, false);
  trajectory_new_contacts(&r->contact_index, &r->contact_rows, shared);
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
  assert(r->shared || state->n_bodies == sd_model_bodies(r->model));
  const moment now = {r->model, state, &sums->energy, slots, take ? &r->sums : sums->others};
  if (take) status = resultants_take(&r->sums, r->model, state, slots, NULL, messages);
  if (what & RECORD_SERIES && status == SD_OK) status = series_sample(&r->series, &now, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_bodies(&r->disks, &now, false, r->shared, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_bodies(&r->walls, &now, true, false, messages);
  if (what & RECORD_FRAMES && status == SD_OK)
    status = trajectory_sample_clumps(&r->clumps, &now, messages);
  if (what & RECORD_CONTACTS && status == SD_OK)
    status = trajectory_sample_contacts(&r->contact_index, &r->contact_rows, &now,
                                        r->shared ? r->n_contacts : state->n_contacts, messages);
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
bool record_has_shares(const record *shared) {
  return shared->disks.n_rows > 0 || shared->contact_index.n_rows > 0;
}

void record_take_series(record *r, record *shared) {
  assert(record_empty(r) && !r->shared && shared->shared);
  const table series = r->series;
  r->series = shared->series;
  shared->series = series;
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
