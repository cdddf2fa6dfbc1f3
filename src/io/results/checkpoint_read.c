/* checkpoint_read.c: states from checkpoints and results; see checkpoint.h. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/team.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/results/constants.h"

/* --- is it that of the model? ----------------------------------------------------------------- */

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
  /* a damaged number does not get to ask for all memory */
  if (status == SD_OK &&
      (contacts < 0 || h5_check(file, "/state/contact_a", (size_t)contacts, NULL) != SD_OK))
    status =
        sd_fail(messages, SD_ERROR_IO, "the state is damaged: the number of contacts is missing");
  return status;
}

/* Checkpoints have a sum, results and checkpoints of older versions a hash; those of shares have
 * a sum for each instead. */
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

/* --- rows ------------------------------------------------------------------------------------- */

/* Rows of free disks and contacts in one file, which is whole or a share. */
typedef struct piece {
  h5_file *file;
  const char *disks, *contacts; /* groups of their columns */
  size_t first, n, first_contact, n_contacts;
} piece;

static size_t width_of(const sd_field *f) {
  return f->extent == SD_PER_MEAN_BIN ? SD_MEAN_BINS : 1;
}

/* A row of several numbers is a row of the dataset in shares; else all numbers stand one after
 * the other. */
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

/* All but free disks and contacts. Prescribed bodies stand behind the free disks; the head of
 * shares has them alone. */
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

/* place: where disk k of the pieces, one after the other, stands; NULL: k. */
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

static sd_status read_contacts(const piece *p, const sd_field *f, size_t at, sd_state *s,
                               sd_messages *messages) {
  if (f->extent == SD_PER_LAW_CONTACT && !s->law_columns) return SD_OK;
  char *data = sd_field_data(s, f);
  return read_rows(p->file, p->contacts, f, p->first_contact, p->n_contacts,
                   data + at * sd_type_size(f->type), messages);
}

/* head: has the rest, behind so many rows of free disks. */
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

/* The state of these pieces. */
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
  if (s) s->n_contacts = status == SD_OK ? contacts : 0;
  for (size_t k = 0; status == SD_OK && k < sd_field_count; k++)
    status = read_column(head, before, n, list, &sd_fields[k], place, s, messages);
  if (status == SD_OK) return SD_OK;
  sd_state_free(s);
  *out = NULL;
  return status;
}

/* --- all of it -------------------------------------------------------------------------------- */

/* No column has more or fewer values than the model says. */
static sd_status check_columns(const h5_file *file, const sd_model *model, sd_messages *messages) {
  sd_state sizes = state_sizes(model);
  sizes.n_contacts = (size_t)checkpoint_count_contacts(file);
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

/* --- some of it: over ranks only, the counted build has one ----------------------------------- */
/* GCOVR_EXCL_START */

static sd_status count_rows(const h5_file *file, const char *path, size_t *n,
                            sd_messages *messages) {
  size_t dims[H5_MAX_RANK] = {0};
  int rank;
  const sd_status status = h5_shape(file, path, &rank, dims, messages);
  *n = dims[0];
  return status;
}

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

/* A disk's place in the whole, and which of the rows read it is. */
typedef struct keyed {
  int64_t key;
  uint32_t row;
} keyed;

static int by_key(const void *one, const void *two) {
  const int64_t p = ((const keyed *)one)->key, q = ((const keyed *)two)->key;
  return p < q ? -1 : p > q;
}

/* Disks of several shares, in the order of the whole. place: of each row read. */
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

static size_t begin_of(size_t n, size_t rank, size_t ranks) {
  return n / ranks * rank + n % ranks * rank / ranks;
}

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
/* --- means ------------------------------------------------------------------------------------ */

static bool are_below(const uint32_t *list, size_t n, size_t end) {
  bool good = list != NULL;
  for (size_t k = 0; good && k < n; k++) good = list[k] < end;
  return good;
}

/* Totals ask for these beside the means. */
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

/* s: also looks at the contacts, bins and measured steps of the run. */
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
    status = summary_disks_take(s, model, &all, means, messages);
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
  /* all of it is read now; shares were checked when it was opened, and a run may have removed
   * it since */
  if (status == SD_OK && !h5_has_shares(file) && file_exists(path))
    status = h5_verify(path, &sealed, &sum, messages);
  if (status == SD_OK && !model) status = constants_read(file, path, read_deck, &own, messages);
  if (!model) model = own;
  if (status == SD_OK) status = checkpoint_collect_disks(file, model, s, pool_most(), messages);
  sd_model_free(own);
  return status;
}
