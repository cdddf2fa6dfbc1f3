/* checkpoint.c: writes and reads the columns of a state in checkpoint files. In runs over several
 * ranks (processes) each rank writes a file of its own with its disks and contacts, called a share;
 * see checkpoint.h. */
#include "io/results/checkpoint.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/team.h"
#include "base/text.h"
#include "io/results/constants.h"
#include "model/model.h"

const checkpoint_extent checkpoint_extents[CHECKPOINT_EXTENTS] = {
    {"n_disks", offsetof(sd_state, n_disks)},
    {"n_bodies", offsetof(sd_state, n_bodies)},
    {"n_free", offsetof(sd_state, n_free)},
    {"n_motions", offsetof(sd_state, n_motions)},
    {"n_rotations", offsetof(sd_state, n_rotations)},
    {"n_slides", offsetof(sd_state, n_slides)},
    {"n_means", offsetof(sd_state, n_means)},
    {"n_phases", offsetof(sd_state, n_phases)},
    {"n_visits", offsetof(sd_state, n_visits)},
    {"n_clumps", offsetof(sd_state, n_clumps)},
    {"n_surfaces", offsetof(sd_state, n_surfaces)},
    {"n_averages", offsetof(sd_state, n_averages)},
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
  /* The columns are not compressed: a checkpoint is written often and read once. */
  if (f->extent == SD_PER_RUN)
    h5_put(file, path, f->type, 0, &n, data, false);
  else
    h5_lend(file, path, f->type, 1, &n, data);
  h5_attr_text(file, path, "unit", f->unit);
  h5_attr_text(file, path, "description", f->meaning);
  free(path);
}

/* Writes all columns of the state. shared: true to leave out the rows of free disks and contacts,
 * because each rank writes its own to a share file. */
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

static void put_extents(h5_file *file, const sd_state *sizes, size_t n_contacts, size_t n_breaks) {
  h5_group(file, "/state");
  h5_attr_i64(file, "/state", "format", CHECKPOINT_FORMAT);
  for (size_t k = 0; k < CHECKPOINT_EXTENTS; k++)
    h5_attr_i64(file, "/state", checkpoint_extents[k].name,
                (int64_t)checkpoint_extent_of(sizes, k));
  h5_attr_i64(file, "/state", "n_contacts", (int64_t)n_contacts);
  h5_attr_i64(file, "/state", "n_breaks", (int64_t)n_breaks);
}

/* Returns the number of broken bonds in a checkpoint; -1: damaged. */
static int64_t count_breaks(const h5_file *file) {
  return h5_get_attr_i64(file, "/state", "n_breaks", -1);
}

int64_t checkpoint_count_contacts(const h5_file *file) {
  return h5_get_attr_i64(file, "/state", "n_contacts", -1);
}

/* Returns a hash of all columns of the state. One over 64-bit words takes a tenth of the time
 * of the bytewise sd_state_hash. */
uint64_t checkpoint_sum_of(const sd_state *state) {
  uint64_t sum = HASH_WORDS;
  for (size_t k = 0; k < sd_field_count; k++)
    sum = hash_words(sum, sd_field_data(state, &sd_fields[k]),
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
  put_extents(file, state, state->n_contacts, state->n_breaks);
  put_columns(file, state, false);
  h5_attr_text(file, "/state", "hash", checkpoint_hash_of(state, hash));
}

/* Size in bytes below which a state is copied into the file; for larger states the file refers to
 * the memory of the state (h5_new_borrowing), which costs more for small ones. */
static const uint64_t BORROWED = 16 << 20;

uint64_t checkpoint_bytes(const sd_state *state) {
  uint64_t bytes = 0;
  for (size_t k = 0; k < sd_field_count; k++)
    bytes += sd_extent_size(state, sd_fields[k].extent) * sd_type_size(sd_fields[k].type);
  return bytes;
}

/* Makes a new file in memory for this state. If the state is large, the file refers to the state's
 * columns instead of copying them. */
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
    put_extents(file, &sizes, shares->n_contacts, state->n_breaks);
    put_columns(file, state, true);
    h5_put_shares(file, shares->n, shares->sums);
  } else {
    put_extents(file, state, state->n_contacts, state->n_breaks);
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

/* Writes a column of free disks or contacts into a group (/disks or /contacts) of a rank's share
 * file. Row k of the file is row from[k] of the state, or row k if `from` is NULL. scratch: buffer
 * for n rows of at most 8 bytes; not used if `from` is NULL. */
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
  for (size_t k = 0; h5_check_memory(file, room, "/contacts") && k < sd_field_count; k++) {
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

/* Sets *n to the number of values in a stored column; a column with a single number has 1. */
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
  h5_attr_i64(file, "/state", "n_breaks", count_breaks(checkpoint));
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

/* Checks that slipdisk has written a file, in a format that this version can read. least: oldest
 * format that is accepted. */
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

/* --- Checks of a stored state against the model ----------------------------------------------- */

static sd_status check_extents(const h5_file *file, const sd_state *sizes, sd_messages *messages) {
  int64_t format = h5_get_attr_i64(file, "/state", "format", -1);
  if (format != CHECKPOINT_FORMAT)
    return sd_fail(messages, SD_ERROR_USER,
                   "the state is stored in format %" PRId64 ", this program reads %d", format,
                   CHECKPOINT_FORMAT);
  sd_status status = SD_OK;
  for (size_t k = 0; k < CHECKPOINT_EXTENTS; k++) {
    const char *name = checkpoint_extents[k].name;
    const size_t expected = checkpoint_extent_of(sizes, k);
    int64_t stored = h5_get_attr_i64(file, "/state", name, -1);
    if (stored != (int64_t)expected)
      status = sd_fail(messages, SD_ERROR_USER,
                       "the state does not belong to this deck: %s is %" PRId64
                       ", in the deck it is %zu",
                       name, stored, expected);
  }
  return status;
}

sd_status checkpoint_check_state(const h5_file *file, const sd_model *model,
                                 sd_messages *messages) {
  const sd_state sizes = state_sizes(model);
  sd_status status = check_extents(file, &sizes, messages);
  const int64_t contacts = checkpoint_count_contacts(file);
  /* A damaged count must not lead to an allocation of all memory, so it is compared with the length
   * of a column. */
  if (status == SD_OK &&
      (contacts < 0 || h5_check(file, "/state/contact_a", (size_t)contacts, NULL) != SD_OK))
    status =
        sd_fail(messages, SD_ERROR_IO, "the state is damaged: the number of contacts is missing");
  return status;
}

/* Verifies the checksum of the state. Checkpoints have the attribute `sum`, results and checkpoints
 * of older versions `hash`. If the disks are in share files (one per rank), the checksum at the end
 * of each share is verified instead. */
static sd_status check_hash(const h5_file *file, const sd_state *state, sd_messages *messages) {
  if (h5_has_shares(file)) return SD_OK;
  char found[20], *stored = h5_get_attr_text(file, "/state", "hash");
  bool same =
      stored ? strcmp(stored, checkpoint_hash_of(state, found)) == 0
             : h5_has_attr(file, "/state", "sum") &&
                   (uint64_t)h5_get_attr_i64(file, "/state", "sum", 0) == checkpoint_sum_of(state);
  free(stored);
  return same ? SD_OK
              : sd_fail(messages, SD_ERROR_IO, "the state is damaged: its hash does not fit");
}

/* --- Columns, read from one file or from several shares --------------------------------------- */

/* Range of rows of free disks and of contacts in one file: in a checkpoint that holds all disks, or
 * in the share file of one rank. */
typedef struct piece {
  h5_file *file;
  /* names of the groups with the columns of disks and of contacts in a share file; "" in a
   * checkpoint that holds all disks */
  const char *disks, *contacts;
  size_t first, n, first_contact, n_contacts;
} piece;

static size_t width_of(const sd_field *f) {
  return f->extent == SD_PER_MEAN_BIN ? SD_MEAN_BINS : 1;
}

/* Reads n rows of a column. A column with several numbers per row is a two-dimensional dataset in a
 * share file (file of one rank); in a checkpoint of all disks it is one-dimensional, row after
 * row. */
static sd_status read_rows(const h5_file *file, const char *group, const sd_field *f, size_t first,
                           size_t n, void *rows, sd_messages *messages) {
  size_t dims[H5_MAX_RANK];
  int rank;
  const size_t width = width_of(f);
  if (n == 0) return SD_OK;
  char *path = format_text("%s/state/%s", group, f->name);
  sd_status status = h5_shape(file, path, &rank, dims, messages);
  if (status == SD_OK)
    status = rank > 1
                 ? h5_get_values(file, path, f->type, first, n, width, rows, messages)
                 : h5_get_values(file, path, f->type, first * width, n * width, 1, rows, messages);
  free(path);
  return status;
}

/* Reads those rows of a column that do not belong to free disks or contacts. In a column of bodies,
 * the rows of prescribed bodies follow those of the free disks. before: number of rows of free
 * disks in the file `head`; 0 if they are in share files. */
static sd_status read_common(const h5_file *head, const sd_field *f, size_t before, sd_state *s,
                             sd_messages *messages) {
  const size_t size = sd_type_size(f->type), all = sd_extent_size(s, f->extent);
  char *data = sd_field_data(s, f), *path;
  if (f->extent == SD_PER_BODY)
    return read_rows(head, "", f, before, all - s->n_free, data + size * s->n_free, messages);
  path = format_text("/state/%s", f->name);
  const sd_status status = h5_get(head, path, f->type, all, data, messages);
  free(path);
  return status;
}

/* Reads a column for the disks of one piece (a file of one rank, or a range of rows). at: number of
 * disks in the pieces before this one. place: slot in the state of each disk, in the order of the
 * pieces; NULL: slot k for disk k. */
static sd_status read_disks(const piece *p, const sd_field *f, size_t at, const uint32_t *place,
                            sd_state *s, sd_messages *messages) {
  const size_t row = sd_type_size(f->type) * width_of(f);
  char *data = sd_field_data(s, f), *scratch = NULL;
  if (!place) return read_rows(p->file, p->disks, f, p->first, p->n, data + at * row, messages);
  if (!memory_resize_row(&scratch, p->n, row))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  const sd_status status = read_rows(p->file, p->disks, f, p->first, p->n, scratch, messages);
  for (size_t k = 0; status == SD_OK && k < p->n; k++)
    memcpy(data + place[at + k] * row, scratch + k * row, row);
  free(scratch);
  return status;
}

/* Reads a column for the contacts of one piece (a file of one rank, or a range of rows). at: number
 * of contacts in the pieces before this one. */
static sd_status read_contacts(const piece *p, const sd_field *f, size_t at, sd_state *s,
                               sd_messages *messages) {
  if (f->extent == SD_PER_LAW_CONTACT && !s->law_columns) return SD_OK;
  char *data = sd_field_data(s, f);
  return read_rows(p->file, p->contacts, f, p->first_contact, p->n_contacts,
                   data + at * sd_type_size(f->type), messages);
}

/* Reads one column of the state from all pieces (files of ranks, or ranges of rows). head: file
 * with the rows of everything but free disks and contacts; they follow `before` rows of free
 * disks. */
static sd_status read_column(const h5_file *head, size_t before, size_t n_pieces, const piece *list,
                             const sd_field *f, const uint32_t *place, sd_state *s,
                             sd_messages *messages) {
  const bool disks = state_of_free(f->extent), contacts = state_of_contacts(f->extent);
  sd_status status = disks || contacts ? SD_OK : read_common(head, f, before, s, messages);
  size_t disk = 0, contact = 0;
  for (const piece *p = list; p < list + n_pieces && status == SD_OK; p++) {
    if (f->extent == SD_PER_BODY || (disks && sd_extent_size(s, f->extent) > 0))
      status = read_disks(p, f, disk, place, s, messages);
    if (contacts) status = read_contacts(p, f, contact, s, messages);
    disk += p->n;
    contact += p->n_contacts;
  }
  return status;
}

/* Makes room in the state for the broken bonds in a file. */
static sd_status reserve_breaks(const h5_file *head, sd_state *s, sd_messages *messages) {
  const int64_t n = count_breaks(head);
  if (n < 0 || n > UINT32_MAX)
    return sd_fail(messages, SD_ERROR_IO, "the state is damaged: %lld broken bonds", (long long)n);
  if (state_reserve_breaks(s, (size_t)n) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "no memory for %lld broken bonds", (long long)n);
  s->n_breaks = (size_t)n;
  return SD_OK;
}

/* Makes a state from the disks and contacts of n pieces (files of ranks, or ranges of rows), and
 * from all other data in `head`. before: number of rows of free disks in `head`; place: slot in the
 * state of each disk read, or NULL. */
static sd_status get_pieces(const h5_file *head, size_t before, const sd_model *model, size_t n,
                            const piece *list, const uint32_t *place, sd_state **out,
                            sd_messages *messages) {
  size_t disks = 0, contacts = 0;
  for (size_t k = 0; k < n; k++) {
    disks += list[k].n;
    contacts += list[k].n_contacts;
  }
  sd_status status = SD_OK;
  sd_state *s = *out = state_new_part(model, disks, 0);
  if (!s || sd_state_reserve_contacts(s, contacts) != SD_OK) {
    shortage_note();
    status = s ? sd_fail(messages, SD_ERROR_IO, "no memory for %zu contacts", contacts)
               : sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  }
  if (s) {
    s->n_contacts = status == SD_OK ? contacts : 0;
    if (status == SD_OK) status = reserve_breaks(head, s, messages);
  }
  for (size_t k = 0; status == SD_OK && k < sd_field_count; k++)
    status = read_column(head, before, n, list, &sd_fields[k], place, s, messages);
  if (status == SD_OK) return SD_OK;
  sd_state_free(s);
  *out = NULL;
  return status;
}

/* --- Reading a whole state -------------------------------------------------------------------- */

/* Checks that each column has the number of values that the model implies. */
static sd_status check_columns(const h5_file *file, const sd_model *model, sd_messages *messages) {
  sd_state sizes = state_sizes(model);
  sizes.n_contacts = (size_t)checkpoint_count_contacts(file);
  sizes.n_breaks = (size_t)count_breaks(file);
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < sd_field_count; k++) {
    char *path = format_text("/state/%s", sd_fields[k].name);
    status = h5_check(file, path, sd_extent_size(&sizes, sd_fields[k].extent), messages);
    free(path);
  }
  return status;
}

sd_status checkpoint_get_state(const h5_file *file, const sd_model *model, sd_state **out,
                               sd_messages *messages) {
  *out = NULL;
  sd_status status = checkpoint_check_state(file, model, messages);
  if (status == SD_OK) status = check_columns(file, model, messages);
  if (status != SD_OK) return status;
  const piece all = {(h5_file *)(uintptr_t)file,
                     "",
                     "",
                     0,
                     model->n_free,
                     0,
                     (size_t)checkpoint_count_contacts(file)};
  status = get_pieces(file, model->n_free, model, 1, &all, NULL, out, messages);
  if (status == SD_OK) status = check_hash(file, *out, messages);
  if (status == SD_OK || !*out) return status;
  sd_state_free(*out);
  *out = NULL;
  return status;
}

/* --- Reading a part of a state, in runs over several ranks ------------------------------------ */
/* GCOVR_EXCL_START */

/* Sets *n to the number of rows of a dataset. */
static sd_status count_rows(const h5_file *file, const char *path, size_t *n,
                            sd_messages *messages) {
  size_t dims[H5_MAX_RANK] = {0};
  int rank;
  const sd_status status = h5_shape(file, path, &rank, dims, messages);
  *n = dims[0];
  return status;
}

/* Opens share file k (that of one rank) of the checkpoint `path`, and verifies the checksum at its
 * end, which must be `sum`. */
static sd_status open_share(const char *path, size_t k, int64_t sum, piece *p,
                            sd_messages *messages) {
  uint64_t found = 0;
  char *name = h5_share_path(path, k);
  *p = (piece){.disks = "/disks", .contacts = "/contacts"};
  sd_status status = h5_open_sealed(-1, name, &p->file, &found, messages);
  if (status == SD_OK && found != (uint64_t)sum)
    status = sd_fail(messages, SD_ERROR_IO, "%s is not the share that %s names", name, path);
  if (status == SD_OK) status = count_rows(p->file, "/disks/key", &p->n, messages);
  if (status == SD_OK) status = count_rows(p->file, "/contacts/key", &p->n_contacts, messages);
  free(name);
  return status;
}

/* Sort key of a disk, which is its slot in a run on one rank, and index of the row that was read
 * for it. */
typedef struct keyed {
  int64_t key;
  uint32_t row;
} keyed;

static int by_key(const void *one, const void *two) {
  const int64_t p = ((const keyed *)one)->key, q = ((const keyed *)two)->key;
  return p < q ? -1 : p > q;
}

/* Sorts the disks of several share files (files of ranks) by key. place: receives, for each row
 * read, the slot in the new state; order: receives the keys, ascending. */
static sd_status order_rows(size_t n_pieces, const piece *list, size_t n, uint32_t *place,
                            uint32_t *order, sd_messages *messages) {
  keyed *rows;
  sd_status status = SD_OK;
  if (!memory_row(&rows, n, sizeof *rows))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  for (size_t p = 0, at = 0; p < n_pieces && status == SD_OK; at += list[p++].n) {
    int64_t *key = h5_column(list[p].file, "/disks/key", SD_I64, list[p].n, &status, messages);
    for (size_t k = 0; key && k < list[p].n; k++)
      rows[at + k] = (keyed){key[k], (uint32_t)(at + k)};
    free(key);
  }
  if (n > 1) qsort(rows, n, sizeof *rows, by_key);
  for (size_t k = 0; status == SD_OK && k < n; k++) {
    place[rows[k].row] = (uint32_t)k;
    order[k] = (uint32_t)rows[k].key;
  }
  free(rows);
  return status;
}

/* Reads the disks and contacts in share files rank, rank + ranks, ... of a checkpoint as a state.
 * Share file k was written by rank k of the earlier run. */
static sd_status get_shares(const h5_file *head, const char *path, const sd_model *model,
                            size_t rank, size_t ranks, sd_state **out, uint32_t **order,
                            sd_messages *messages) {
  size_t all = 0, n = 0, disks = 0;
  sd_status status = count_rows(head, "/shares", &all, messages);
  int64_t *sums = h5_column(head, "/shares", SD_I64, all, &status, messages);
  piece *list = memory_new(all, sizeof *list);
  uint32_t *place = NULL;
  for (size_t k = rank; sums && status == SD_OK && k < all; k += ranks) {
    status = open_share(path, k, sums[k], &list[n], messages);
    disks += list[n++].n;
  }
  if (status == SD_OK && !memory_rows(2, (memory_column[]){{&place, disks, sizeof *place},
                                                           {order, disks, sizeof **order}}))
    status = sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  if (status == SD_OK) status = order_rows(n, list, disks, place, *order, messages);
  if (status == SD_OK) status = get_pieces(head, 0, model, n, list, place, out, messages);
  for (size_t k = 0; k < n; k++) h5_close(list[k].file, NULL);
  free(list);
  free(sums);
  free(place);
  return status;
}

/* Returns the first of n rows that `rank` gets when all rows are divided into `ranks` equal
 * ranges. */
static size_t begin_of(size_t n, size_t rank, size_t ranks) {
  return n / ranks * rank + n % ranks * rank / ranks;
}

/* Reads one of `ranks` equal ranges of a checkpoint's disks and contacts, that with the number
 * `rank`, as a state. The checkpoint is a single file. */
static sd_status get_range(h5_file *file, const sd_model *model, size_t rank, size_t ranks,
                           sd_state **out, uint32_t **order, sd_messages *messages) {
  const size_t disks = model->n_free, contacts = (size_t)checkpoint_count_contacts(file),
               first = begin_of(disks, rank, ranks),
               first_contact = begin_of(contacts, rank, ranks);
  const piece mine = {file,
                      "",
                      "",
                      first,
                      begin_of(disks, rank + 1, ranks) - first,
                      first_contact,
                      begin_of(contacts, rank + 1, ranks) - first_contact};
  if (!memory_row(order, mine.n, sizeof **order))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  for (size_t k = 0; k < mine.n; k++) (*order)[k] = (uint32_t)(first + k);
  return get_pieces(file, disks, model, 1, &mine, NULL, out, messages);
}

sd_status checkpoint_get_some(const char *path, const sd_model *model, size_t rank, size_t ranks,
                              sd_state **out, uint32_t **order, sd_messages *messages) {
  h5_file *head = NULL;
  *out = NULL;
  *order = NULL;
  sd_status status = h5_open_head(path, &head, messages);
  if (status == SD_OK)
    status = h5_has_shares(head) ? get_shares(head, path, model, rank, ranks, out, order, messages)
                                 : get_range(head, model, rank, ranks, out, order, messages);
  h5_close(head, NULL);
  return status;
}

/* GCOVR_EXCL_STOP */
/* --- Means of disks, computed from a stored state --------------------------------------------- */

/* Returns true if all n numbers of the list are below `end`; false also if the list is NULL. */
static bool are_below(const uint32_t *list, size_t n, size_t end) {
  bool good = list != NULL;
  for (size_t k = 0; good && k < n; k++) good = list[k] < end;
  return good;
}

/* Reads those columns that sd_disk_totals_of needs besides the means of each disk. */
static sd_status read_for_totals(const h5_file *file, sd_state *s, sd_messages *messages) {
  sd_status status = SD_OK;
  s->n_contacts = (size_t)checkpoint_count_contacts(file);
  s->id = h5_column(file, "/state/id", SD_U32, s->n_bodies, &status, messages);
  s->radius = h5_column(file, "/state/radius", SD_F64, s->n_bodies, &status, messages);
  s->contact_a = h5_column(file, "/state/contact_a", SD_U32, s->n_contacts, &status, messages);
  s->contact_b = h5_column(file, "/state/contact_b", SD_U32, s->n_contacts, &status, messages);
  if (status != SD_OK) return status;
  if (are_below(s->id, s->n_bodies, s->n_bodies) && are_below(s->id, s->n_means, s->n_disks) &&
      are_below(s->contact_a, s->n_contacts, s->n_bodies) &&
      are_below(s->contact_b, s->n_contacts, s->n_bodies))
    return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "the state is damaged: there is no such body");
}

/* Computes the time averages of all disks, AT_ONCE disks at a time. s: receives the numbers of
 * samples, bins and measured steps of the run. */
static sd_status read_means(const h5_file *file, const sd_model *model, sd_state *s,
                            sd_disk_mean *means, int threads, sd_messages *messages) {
  enum { AT_ONCE = 1 << 16 };
  sd_status status = SD_OK;
  for (size_t at = 0; status == SD_OK && at < s->n_means; at += AT_ONCE) {
    const size_t n = s->n_means - at < AT_ONCE ? s->n_means - at : AT_ONCE;
    const piece some = {(h5_file *)(uintptr_t)file, "", "", at, n, 0, 0};
    sd_state *part = NULL;
    status = get_pieces(file, model->n_free, model, 1, &some, NULL, &part, messages);
    if (status != SD_OK) break;
    summary_disks_means(means + at, n, model, part, threads);
    s->mean_samples = part->mean_samples;
    s->mean_bins = part->mean_bins;
    s->measured = part->measured;
    sd_state_free(part);
  }
  return status;
}

sd_status checkpoint_collect_disks(const h5_file *file, const sd_model *model, summary_disks *s,
                                   int threads, sd_messages *messages) {
  sd_state all = state_sizes(model);
  sd_disk_mean *means = NULL;
  sd_status status = checkpoint_check_state(file, model, messages);
  if (status == SD_OK && !memory_row(&means, all.n_means, sizeof *means))
    status = sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
  if (status == SD_OK) status = read_for_totals(file, &all, messages);
  if (status == SD_OK) status = read_means(file, model, &all, means, threads, messages);
  if (status == SD_OK) {
    summary_disks_announce(s, model, &all);
    status = summary_disks_fill(s, model, &all, means, messages);
  }
  free(all.id);
  free(all.radius);
  free(all.contact_a);
  free(all.contact_b);
  free(means);
  return status;
}

sd_status checkpoint_complete(const h5_file *file, const char *path, const sd_model *model,
                              constants_deck_reader *read_deck, summary_disks *s,
                              sd_messages *messages) {
  sd_model *own = NULL;
  bool sealed;
  uint64_t sum;
  if (!s->later) return SD_OK;
  if (checkpoint_get_parts(file) < 0)
    return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  sd_status status = checkpoint_check_format(file, path, messages);
  /* The whole file is read now, so the checksum at its end is verified. Share files (those of
   * ranks) were verified when the file was opened, and the run may have removed the file since. */
  if (status == SD_OK && !h5_has_shares(file) && file_exists(path))
    status = h5_verify(path, &sealed, &sum, messages);
  if (status == SD_OK && !model) status = constants_read(file, path, read_deck, &own, messages);
  if (!model) model = own;
  if (status == SD_OK) status = checkpoint_collect_disks(file, model, s, pool_most(), messages);
  sd_model_free(own);
  return status;
}
