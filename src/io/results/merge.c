/* merge.c: copies the rows of all part files of a run into the result file; see merge.h. */
#include "io/results/merge.h"

#include <assert.h>
#include <inttypes.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/results/constants.h"
#include "io/results/trajectory.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "model/law_features.h"
#include "model/model.h"
#include "model/law_features.h"
#include "model/model.h"

/* Rows are copied in blocks of at most this many bytes. */
enum { PIECE_BYTES = 32 << 20 };

/* Opens part file number `number` of the result and counts the rows of each table. sum: on entry
 * the checksum at the end of the part before, on return that at the end of this part. */
static sd_status open_part(const merge_job *job, int64_t number, h5_file **part,
                           size_t rows[RECORD_TABLES], uint64_t *bytes, uint64_t *sum,
                           sd_messages *messages) {
  char *path = folder_part(job->folder->path, number);
  record_link link = {.run_id = job->origin->run_id, .number = number, .after = *sum};
  sd_status status = record_open(job->folder->at, path, &link, part, sum, messages);
  for (int t = 0; t < RECORD_TABLES; t++) {
    const table *layout = job->layout->tables[t];
    size_t dims[H5_MAX_RANK] = {0};
    int rank;
    if (status == SD_OK && layout->n_columns > 0)
      status = h5_shape(*part, layout->columns[0].path, &rank, dims, messages);
    rows[t] = dims[0];
  }
  *bytes = file_size(path);
  free(path);
  return status;
}

/* Checks part file number `number` and counts the rows of its tables, without keeping it open. */
static sd_status count_rows(const merge_job *job, int64_t number, size_t rows[RECORD_TABLES],
                            uint64_t *bytes, uint64_t *sum, sd_messages *messages) {
  h5_file *part = NULL;
  sd_status status = open_part(job, number, &part, rows, bytes, sum, messages);
  h5_close(part, NULL);
  return status;
}

sd_status merge_check_parts(const folder *f, const record *layout, const char *run_id,
                            int64_t parts, uint64_t last, sd_messages *messages) {
  provenance origin = {.run_id = (char *)(uintptr_t)run_id};
  merge_job job = {.folder = f, .layout = layout, .origin = &origin};
  uint64_t bytes, sum = 0;
  sd_status status = SD_OK;
  for (int64_t p = 1; status == SD_OK && p <= parts; p++) {
    size_t rows[RECORD_TABLES] = {0};
    status = count_rows(&job, p, rows, &bytes, &sum, messages);
  }
  if (status == SD_OK && sum != last)
    status =
        sd_fail(messages, SD_ERROR_IO,
                "the last of the %" PRId64 " parts in %s is not the one that its checkpoint names",
                parts, f->path);
  return status;
}

/* Copies n rows of one column from a part file into the result, to rows first ... first + n - 1: as
 * they are stored where that is possible, else as values. */
static sd_status copy_column(const table_column *c, const h5_file *part, h5_file *out, size_t first,
                             size_t n, sd_messages *messages) {
  size_t row = c->width * sd_type_size(c->type);
  size_t piece = row > 0 && PIECE_BYTES / row > 0 ? PIECE_BYTES / row : 1;
  if (piece > n) piece = n;
  assert(n == 0 || piece >= 1);
  const size_t direct = h5_copy_rows(part, out, c->path, c->type, first, n);
  if (direct == n) return SD_OK;
  void *data = NULL;
  if (!memory_resize_row(&data, piece, row))
    return sd_fail(messages, SD_ERROR_IO, "no memory to merge");
  sd_status status = SD_OK;
  for (size_t k = direct; status == SD_OK && !h5_failed(out) && k < n; k += piece) {
    size_t m = n - k < piece ? n - k : piece;
    status = h5_get_values(part, c->path, c->type, k, m, c->width, data, messages);
    if (status == SD_OK) h5_put_rows(out, c->path, c->type, first + k, m, data);
  }
  free(data);
  return status;
}

/* Copies all rows of one part file into the result. The part is opened and verified again, so the
 * copied bytes are verified ones. done: number of rows of each table copied so far. */
static sd_status copy_part(const merge_job *job, int64_t number, h5_file *out,
                           size_t done[RECORD_TABLES], uint64_t *sum, sd_messages *messages) {
  h5_file *part = NULL;
  size_t rows[RECORD_TABLES];
  uint64_t bytes;
  sd_status status = open_part(job, number, &part, rows, &bytes, sum, messages);
  for (int t = 0; status == SD_OK && t < RECORD_TABLES; t++) {
    const table *layout = job->layout->tables[t];
    for (size_t c = 0; status == SD_OK && c < layout->n_columns; c++)
      status = copy_column(&layout->columns[c], part, out, done[t], rows[t], messages);
    done[t] += rows[t];
  }
  h5_close(part, NULL);
  return status;
}

/* Writes the column `first` of the contact index: for each time at which contacts were stored, the
 * row of the first contact, which is the sum of the counts before. */
static sd_status write_offsets(h5_file *out, size_t n, sd_messages *messages) {
  enum { BLOCK = 65536 };
  h5_make(out, "/contacts/first", SD_I64, 1, &n, false);
  h5_attr_text(out, "/contacts/first", "unit", "1");
  h5_attr_text(out, "/contacts/first", "description", "row of the first contact of this step");
  int64_t *count = memory_new(BLOCK, sizeof *count), first = 0;
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && !h5_failed(out) && k < n; k += BLOCK) {
    size_t m = n - k < BLOCK ? n - k : BLOCK;
    status = h5_get_values(out, "/contacts/count", SD_I64, k, m, 1, count, messages);
    for (size_t i = 0; i < m; i++) {
      int64_t next = first + count[i];
      count[i] = first;
      first = next;
    }
    if (status == SD_OK) h5_put_rows(out, "/contacts/first", SD_I64, k, m, count);
  }
  free(count);
  return status;
}

/* Writes the table /breaks: the columns of broken bonds in /state, and their times. */
static sd_status write_breaks(const merge_job *job, h5_file *out, sd_messages *messages) {
  static const char *const columns[][2] = {
      {"/breaks/step", "/state/break_step"},    {"/breaks/a", "/state/break_a"},
      {"/breaks/b", "/state/break_b"},          {"/breaks/x", "/state/break_x"},
      {"/breaks/y", "/state/break_y"},          {"/breaks/mode", "/state/break_mode"},
      {"/breaks/energy", "/state/break_energy"}};
  const int64_t rows = h5_get_attr_i64(out, "/state", "n_breaks", 0);
  const size_t n = rows > 0 ? (size_t)rows : 0;
  sd_status status = SD_OK;
  int64_t *step = h5_column(out, "/state/break_step", SD_I64, n, &status, messages);
  double *time = NULL;
  if (status == SD_OK && !memory_row(&time, n, sizeof *time))
    status = sd_fail(messages, SD_ERROR_IO, "no memory for %zu broken bonds", n);
  if (status == SD_OK) {
    for (size_t k = 0; k < n; k++) time[k] = (double)step[k] * job->model->dt;
    h5_group(out, "/breaks");
    h5_attr_text(out, "/breaks", "description", "bonds that have broken, in the order of steps");
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
      h5_link(out, columns[k][1], columns[k][0]);
    h5_put(out, "/breaks/time", SD_F64, 1, &n, time, false);
    h5_attr_text(out, "/breaks/time", "unit", "time");
    h5_attr_text(out, "/breaks/time", "description", "time of the step");
  }
  free(step);
  free(time);
  return status;
}

/* Writes everything into the result except the rows of tables. */
static sd_status write_rest(const merge_job *job, h5_file *out, sd_messages *messages) {
  sd_status status = SD_OK;
  provenance_write(job->origin, out);
  summary_write(job->found, out);
  if (job->state)
    checkpoint_put_state(out, job->state);
  else
    status = checkpoint_copy_state(out, job->checkpoint, messages);
  if (status == SD_OK)
    status = constants_write(out, job->model, &(constants_source){job->state, job->checkpoint},
                             messages);
  series_write_columns(out, job->model);
  if (status == SD_OK && laws_features(job->model) & LAW_BOND)
    status = write_breaks(job, out, messages);
  return status;
}

static bool stopped(const merge_job *job) { return job->stop && *job->stop; }

/* Fills the result file, which is written under a temporary name (draft). total: number of rows of
 * each table. */
static sd_status fill(const merge_job *job, h5_file *out, const size_t total[RECORD_TABLES],
                      sd_messages *messages) {
  size_t done[RECORD_TABLES] = {0};
  uint64_t sum = 0;
  sd_status status = SD_OK;
  for (int t = 0; t < RECORD_TABLES; t++) table_make(job->layout->tables[t], out, total[t]);
  for (int64_t p = 1; status == SD_OK && !h5_failed(out) && p <= job->parts; p++) {
    if (stopped(job)) return SD_INTERRUPTED;
    status = copy_part(job, p, out, done, &sum, messages);
  }
  if (status == SD_OK && !h5_failed(out))
    status = write_offsets(out, total[RECORD_CONTACT_INDEX], messages);
  if (status == SD_OK && !h5_failed(out)) status = write_rest(job, out, messages);
  return status;
}

/* Writes the result. It is first written as a draft in the folder of the parts, so that a merge
 * that is killed leaves no file beside the result. */
static sd_status write_result(const merge_job *job, const size_t total[RECORD_TABLES],
                              uint64_t bytes, sd_messages *messages) {
  h5_file *out = NULL;
  file_draft draft;
  char *name = format_text("%s/result.h5", job->folder->path);
  sd_status status = file_draft_new(job->folder->at, name, &draft, messages);
  free(name);
  if (status == SD_OK) status = h5_create(&draft, bytes, &out, messages);
  if (status == SD_OK) {
    status = fill(job, out, total, messages);
    sd_status closed = status == SD_OK ? h5_finish(out, &draft, messages) : h5_close(out, messages);
    if (status == SD_OK) status = closed;
  }
  if (status == SD_OK) status = folder_check(job->folder, messages);
  if (status == SD_OK) return file_draft_publish(&draft, -1, job->result, job->how, messages);
  file_draft_drop(&draft);
  return status;
}

sd_status merge_parts(const merge_job *job, sd_messages *messages) {
  size_t total[RECORD_TABLES] = {0};
  const uint64_t whole =
      job->state ? checkpoint_bytes(job->state) : checkpoint_stored_bytes(job->checkpoint);
  uint64_t bytes = (4u << 20) + 2 * whole, sum = 0;
  sd_status status = SD_OK;
  for (int64_t p = 1; status == SD_OK && p <= job->parts; p++) {
    size_t rows[RECORD_TABLES] = {0};
    uint64_t size = 0;
    if (stopped(job)) return SD_INTERRUPTED;
    status = count_rows(job, p, rows, &size, &sum, messages);
    for (int t = 0; t < RECORD_TABLES; t++) total[t] += rows[t];
    bytes += size + size / 16;
  }
  return status == SD_OK ? write_result(job, total, bytes, messages) : status;
}
