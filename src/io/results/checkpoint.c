/* checkpoint.c: see checkpoint.h. */
#include "io/results/checkpoint.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

const checkpoint_extent checkpoint_extents[CHECKPOINT_EXTENTS] = {
    {"n_disks", offsetof(sd_state, n_disks)},         {"n_bodies", offsetof(sd_state, n_bodies)},
    {"n_free", offsetof(sd_state, n_free)},           {"n_motions", offsetof(sd_state, n_motions)},
    {"n_rotations", offsetof(sd_state, n_rotations)}, {"n_slides", offsetof(sd_state, n_slides)},
    {"n_means", offsetof(sd_state, n_means)},         {"n_phases", offsetof(sd_state, n_phases)},
    {"n_visits", offsetof(sd_state, n_visits)},       {"n_clumps", offsetof(sd_state, n_clumps)},
    {"n_surfaces", offsetof(sd_state, n_surfaces)},
};

const char *checkpoint_column(const h5_file *file, const char *name) {
  static const char *const renamed[][2] = {{"contact_lambda_ref", "contact_lambda"},
                                           {"contact_zeta", "contact_stretch"},
                                           {"contact_nonconservative_work", "contact_gain"},
                                           {"nonconservative_work", "gain_variant"},
                                           {"past_nonconservative_work", "past_gain"}};
  if (h5_get_attr_i64(file, "/state", "format", 0) >= 5) return name;
  for (size_t k = 0; k < sizeof renamed / sizeof *renamed; k++)
    if (strcmp(name, renamed[k][0]) == 0) return renamed[k][1];
  return name;
}

size_t checkpoint_extent_of(const sd_state *sizes, size_t k) {
  assert(k < CHECKPOINT_EXTENTS);
  size_t n;
  memcpy(&n, (const char *)sizes + checkpoint_extents[k].offset, sizeof n);
  return n;
}

static void put_column(h5_file *file, const sd_field *f, size_t n, const void *data) {
  char *path = format_text("/state/%s", f->name);
  /* no filter: a checkpoint is written often and read once */
  if (f->extent == SD_PER_RUN)
    h5_put(file, path, f->type, 0, &n, data, false);
  else
    h5_lend(file, path, f->type, 1, &n, data);
  h5_attr_text(file, path, "unit", f->unit);
  h5_attr_text(file, path, "description", f->meaning);
  free(path);
}

/* shared: without rows of free disks and of contacts, which stand in shares. */
static void put_columns(h5_file *file, const sd_state *state, bool shared) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const char *data = sd_field_data(state, f);
    size_t n = sd_extent_size(state, f->extent), first = 0;
    if (shared && f->extent == SD_PER_BODY) first = state->n_free + state->n_ghosts;
    if (shared && (state_of_free(f->extent) || state_of_contacts(f->extent))) first = n;
    put_column(file, f, n - first, data ? data + first * sd_type_size(f->type) : NULL);
  }
}

static void put_extents(h5_file *file, const sd_state *sizes, size_t n_contacts) {
  h5_group(file, "/state");
  h5_attr_i64(file, "/state", "format", CHECKPOINT_FORMAT);
  for (size_t k = 0; k < CHECKPOINT_EXTENTS; k++)
    h5_attr_i64(file, "/state", checkpoint_extents[k].name,
                (int64_t)checkpoint_extent_of(sizes, k));
  h5_attr_i64(file, "/state", "n_contacts", (int64_t)n_contacts);
}

int64_t checkpoint_count_contacts(const h5_file *file) {
  return h5_get_attr_i64(file, "/state", "n_contacts", -1);
}

/* As `hash`, by words: a tenth of the time. */
uint64_t checkpoint_sum_of(const sd_state *state) {
  uint64_t sum = FILE_SUM;
  for (size_t k = 0; k < sd_field_count; k++)
    sum = file_sum(sum, sd_field_data(state, &sd_fields[k]),
                   sd_extent_size(state, sd_fields[k].extent) * sd_type_size(sd_fields[k].type));
  return sum;
}

static const char *hash_text(uint64_t hash, char text[20]) {
  snprintf(text, 20, "%016" PRIx64, hash);
  return text;
}

const char *checkpoint_hash_of(const sd_state *state, char text[20]) {
  return hash_text(sd_state_hash(state), text);
}

void checkpoint_put_state(h5_file *file, const sd_state *state) {
  char hash[20];
  put_extents(file, state, state->n_contacts);
  put_columns(file, state, false);
  h5_attr_text(file, "/state", "hash", checkpoint_hash_of(state, hash));
}

/* Below so many bytes of the state a copy costs less than pages. */
static const uint64_t BORROWED = 16 << 20;

uint64_t checkpoint_bytes(const sd_state *state) {
  uint64_t bytes = 0;
  for (size_t k = 0; k < sd_field_count; k++)
    bytes += sd_extent_size(state, sd_fields[k].extent) * sd_type_size(sd_fields[k].type);
  return bytes;
}

static sd_status file_for(const sd_state *state, h5_file **file, sd_messages *messages) {
  const uint64_t bytes = checkpoint_bytes(state);
  return bytes < BORROWED ? h5_new(file, messages) : h5_new_borrowing(bytes, file, messages);
}

sd_status checkpoint_write(int folder, const char *path, const sd_state *state,
                           const checkpoint_parts *parts, const checkpoint_shares *shares,
                           const provenance *origin, const summary *found, sd_messages *messages) {
  h5_file *file;
  sd_status status = file_for(state, &file, messages);
  if (status != SD_OK) return status;
  assert(parts->n >= 0 && state->n_contacts <= state->contact_capacity);
  h5_group(file, "/checkpoint");
  h5_attr_i64(file, "/checkpoint", "parts", parts->n);
  h5_attr_i64(file, "/checkpoint", "last_part", (int64_t)parts->last);
  h5_attr_text(file, "/checkpoint", "replaces", parts->replaces);
  provenance_write(origin, file);
  summary_write(found, file);
  if (shares) {
    const sd_state sizes = state_sizes(shares->model);
    put_extents(file, &sizes, shares->n_contacts);
    put_columns(file, state, true);
    h5_put_shares(file, shares->n, shares->sums);
  } else {
    put_extents(file, state, state->n_contacts);
    put_columns(file, state, false);
    h5_attr_i64(file, "/state", "sum", (int64_t)checkpoint_sum_of(state));
  }
  return h5_save(file, folder, path, NULL, messages);
}

/* GCOVR_EXCL_START: over ranks only, the counted build has one */
void checkpoint_remove_share(int folder, const char *path, size_t k) {
  char *name = h5_share_path(path, k);
  file_remove(folder, name);
  free(name);
}

/* Rows of a column in a group of a share; from[k] (NULL: k) is which of the state is row k. */
static void put_rows(h5_file *file, const char *group, const sd_field *f, const void *data,
                     size_t n, const uint32_t *from, char *scratch) {
  const size_t size = sd_type_size(f->type), dims[2] = {n, SD_MEAN_BINS};
  char *path = format_text("%s/state/%s", group, f->name);
  for (size_t k = 0; from && k < n; k++)
    memcpy(scratch + k * size, (const char *)data + from[k] * size, size);
  if (from)
    h5_put(file, path, f->type, 1, dims, scratch, false);
  else
    h5_lend(file, path, f->type, f->extent == SD_PER_MEAN_BIN ? 2 : 1, dims, data);
  free(path);
}

sd_status checkpoint_write_share(const char *path, const sd_state *state,
                                 const checkpoint_order *order, int64_t *sum,
                                 sd_messages *messages) {
  h5_file *file;
  uint64_t seal = 0;
  sd_status status = file_for(state, &file, messages);
  if (status != SD_OK) return status;
  char *scratch = NULL;
  const bool room = memory_resize_row(&scratch, state->n_contacts, sizeof(double));
  h5_put(file, "/disks/key", SD_I64, 1, &state->n_free, order->disk_key, false);
  h5_put(file, "/contacts/key", SD_I64, 1, &state->n_contacts, order->contact_key, false);
  for (size_t k = 0; h5_have(file, room, "/contacts") && k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const void *data = sd_field_data(state, f);
    const bool of_body = f->extent == SD_PER_BODY;
    const size_t n = of_body ? state->n_free : sd_extent_size(state, f->extent);
    if (n == 0) continue;
    if (of_body || state_of_free(f->extent))
      put_rows(file, "/disks", f, data, state->n_free, NULL, NULL);
    if (state_of_contacts(f->extent))
      put_rows(file, "/contacts", f, data, n, order->contact, scratch);
  }
  free(scratch);
  status = h5_save(file, -1, path, &seal, messages);
  *sum = (int64_t)seal;
  return status;
}

/* Elements of a column; 1: of the run. */
static sd_status count_stored(const h5_file *checkpoint, const char *path, size_t *n,
                              sd_messages *messages) {
  size_t dims[H5_MAX_RANK] = {0};
  int rank = 0;
  const sd_status status = h5_shape(checkpoint, path, &rank, dims, messages);
  *n = 1;
  for (int k = 0; k < rank; k++) *n *= dims[k];
  return status;
}

uint64_t checkpoint_stored_bytes(const h5_file *checkpoint) {
  uint64_t bytes = 0;
  for (size_t k = 0; k < sd_field_count; k++) {
    size_t n = 0;
    char *path = format_text("/state/%s", sd_fields[k].name);
    if (count_stored(checkpoint, path, &n, NULL) == SD_OK)
      bytes += n * sd_type_size(sd_fields[k].type);
    free(path);
  }
  return bytes;
}

sd_status checkpoint_copy_state(h5_file *file, const h5_file *checkpoint, sd_messages *messages) {
  uint64_t hash = STATE_HASH;
  sd_status status = SD_OK;
  h5_group(file, "/state");
  h5_attr_i64(file, "/state", "format", h5_get_attr_i64(checkpoint, "/state", "format", 0));
  for (const checkpoint_extent *e = checkpoint_extents; e < checkpoint_extents + CHECKPOINT_EXTENTS;
       e++)
    h5_attr_i64(file, "/state", e->name, h5_get_attr_i64(checkpoint, "/state", e->name, 0));
  h5_attr_i64(file, "/state", "n_contacts", checkpoint_count_contacts(checkpoint));
  for (size_t k = 0; k < sd_field_count && status == SD_OK && !h5_failed(file); k++) {
    const sd_field *f = &sd_fields[k];
    size_t n;
    char *path = format_text("/state/%s", f->name);
    status = count_stored(checkpoint, path, &n, messages);
    void *column = h5_column(checkpoint, path, f->type, n, &status, messages);
    if (column) put_column(file, f, n, column);
    if (column) hash = state_hash_bytes(hash, column, n * sd_type_size(f->type));
    free(column);
    free(path);
  }
  char text[20];
  h5_attr_text(file, "/state", "hash", hash_text(hash, text));
  return status;
}

/* GCOVR_EXCL_STOP */
int64_t checkpoint_get_parts(const h5_file *file) {
  return h5_get_attr_i64(file, "/checkpoint", "parts", -1);
}

uint64_t checkpoint_get_last_part(const h5_file *file) {
  return (uint64_t)h5_get_attr_i64(file, "/checkpoint", "last_part", 0);
}

char *checkpoint_get_replaces(const h5_file *file) {
  return h5_get_attr_text(file, "/checkpoint", "replaces");
}

/* least: the oldest format that will do. */
static sd_status check_version(const h5_file *file, const char *path, int64_t least,
                               sd_messages *messages) {
  char *creator = h5_get_attr_text(file, "/h5md/creator", "name");
  char *version = h5_get_attr_text(file, "/h5md/creator", "version");
  const char *shown = version ? version : "unknown";
  int64_t format = h5_get_attr_i64(file, "/state", "format", 0);
  sd_status status = SD_OK;
  if (!creator && h5_exists(file, "/disks/key"))
    status = sd_fail(
        messages, SD_ERROR_USER,
        "%s is what one rank has written of a larger file; give the result, or that file: the "
        "name without the number of the rank",
        path);
  else if (!creator || strcmp(creator, "slipdisk") != 0)
    status = sd_fail(messages, SD_ERROR_USER, "%s is no result of slipdisk%s%.80s", path,
                     creator ? ": it was written by " : "", creator ? creator : "");
  else if (format > CHECKPOINT_FORMAT)
    status = sd_fail(messages, SD_ERROR_USER,
                     "%s was written by a newer slipdisk, version %.40s: its format is %" PRId64
                     ", this program reads up to %d",
                     path, shown, format, CHECKPOINT_FORMAT);
  else if (format < least)
    status = sd_fail(
        messages, SD_ERROR_USER,
        "%s was written by an older slipdisk, version %.40s: its format is %" PRId64
        ", this program goes on from %d only; let the older one finish the run, or start over with "
        "--force",
        path, shown, format, CHECKPOINT_FORMAT);
  free(creator);
  free(version);
  return status;
}

sd_status checkpoint_check_origin(const h5_file *file, const char *path, sd_messages *messages) {
  return check_version(file, path, 0, messages);
}

sd_status checkpoint_check_format(const h5_file *file, const char *path, sd_messages *messages) {
  return check_version(file, path, CHECKPOINT_FORMAT, messages);
}
