/* ranks_share.c: sorts a rank's disks and contacts for the file that the rank writes (its share of
 * a checkpoint or part file), adds up sums over ranks, and selects the columns that are sent when
 * disks move; see ranks_share.h. */
#include "run/ranks_share.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "model/cell.h"
#include "physics/step/access.h"
#include "physics/system/halo.h"

/* Sort key of a contact, in the order in which a state has its contacts: first contacts with disks
 * and circular walls, then those with walls of segments; within each by disk, partner and
 * segment. */
typedef struct pair_place {
  /* slot of the first disk in the sorted order of all disks, plus 2^32 if the partner is a wall of
   * segments; contacts of equal key are on one rank */
  int64_t key;
  uint64_t partner;
  uint32_t part, from;
} pair_place;

static int by_place(const void *one, const void *two) {
  const pair_place *p = one, *q = two;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  if (p->partner != q->partner) return p->partner < q->partner ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

/* Returns the sort key of contact number c of the state. */
static pair_place place_of(const engine *e, uint32_t c) {
  const sd_state *s = e->state;
  const uint32_t a = engine_slot(e, s->contact_a[c]), b = engine_slot(e, s->contact_b[c]);
  const bool piece = s->contact_b[c] >= e->model->n_disks &&
                     e->model->walls[s->contact_b[c] - e->model->n_disks].kind != SD_WALL_CIRCLE;
  return (pair_place){.key = (int64_t)piece << 32 | (int64_t)e->halo->order[a],
                      .partner = halo_order(e, b),
                      .part = s->contact_part[c],
                      .from = c};
}

static void order_free(checkpoint_order *order) {
  free(order->disk_key);
  free(order->contact_key);
  free(order->contact);
}

/* Computes the sort keys of this rank's disks and contacts. */
static sd_status order_new(const engine *e, checkpoint_order *order, sd_messages *messages) {
  const sd_state *s = e->state;
  pair_place *list = NULL;
  *order = (checkpoint_order){0};
  const memory_column arrays[] = {{&list, s->n_contacts, sizeof *list},
                                  {&order->disk_key, s->n_free, sizeof *order->disk_key},
                                  {&order->contact_key, s->n_contacts, sizeof *order->contact_key},
                                  {&order->contact, s->n_contacts, sizeof *order->contact}};
  if (!memory_resize(sizeof arrays / sizeof *arrays, arrays)) {
    free(list);
    return sd_fail(messages, SD_ERROR_IO, "no memory for the results of rank %d",
                   comm_rank(e->comm));
  }
  for (size_t i = 0; i < s->n_free; i++) order->disk_key[i] = (int64_t)e->halo->order[i];
  for (uint32_t c = 0; c < s->n_contacts; c++) list[c] = place_of(e, c);
  if (s->n_contacts > 1) qsort(list, s->n_contacts, sizeof *list, by_place);
  for (size_t c = 0; c < s->n_contacts; c++) {
    order->contact_key[c] = list[c].key;
    order->contact[c] = list[c].from;
  }
  free(list);
  return SD_OK;
}

sd_status ranks_write_share(const engine *part, const char *path, int64_t *sum,
                            sd_messages *messages) {
  checkpoint_order order;
  sd_status status = order_new(part, &order, messages);
  if (status == SD_OK) status = checkpoint_write_share(path, part->state, &order, sum, messages);
  order_free(&order);
  return status;
}

/* All ranks have the prescribed disks; only rank 0 writes them. */
sd_status ranks_sample_share(const engine *part, unsigned what, int64_t frame,
                             int64_t moment_number, record *rows, sd_messages *messages) {
  const sd_state *s = part->state;
  const size_t driven = comm_rank(part->comm) == 0 ? s->n_free + s->n_ghosts : s->n_disks;
  checkpoint_order order;
  sd_status status = order_new(part, &order, messages);
  if (status == SD_OK)
    status = record_sample_share(rows, what, s, driven, engine_slots(part), &order, frame,
                                 moment_number, messages);
  order_free(&order);
  return status;
}

void ranks_gather_sums(const comm *c, int64_t sum, int64_t *all) {
  int64_t *every = memory_new((size_t)comm_size(c), sizeof *every);
  comm_gather_one(c, &sum, every, sizeof sum);
  if (all) memcpy(all, every, (size_t)comm_size(c) * sizeof *all);
  free(every);
}

/* --- Sums over ranks -------------------------------------------------------------------------- */

size_t ranks_count_contacts(const engine *part) {
  return (size_t)comm_total(part->comm, (double)part->state->n_contacts);
}

static int by_order(const void *one, const void *two) {
  const struct summary_lost_disk *p = one, *q = two;
  return p->order < q->order ? -1 : p->order > q->order;
}

/* Collective: adds up the numbers of lost disks of all ranks, and stores the first lost disks of
 * all. */
static void add_lost(const engine *part, summary_lost *lost) {
  int *counts = memory_new((size_t)comm_size(part->comm), sizeof *counts);
  struct summary_lost_disk *all =
      memory_new((size_t)comm_size(part->comm) * SUMMARY_LOST, sizeof *all);
  for (size_t k = 0; k < lost->told; k++)
    lost->first[k].order = part->halo->order[lost->first[k].order];
  lost->n = (int64_t)comm_total(part->comm, (double)lost->n);
  size_t n = 0;
  comm_gather_counts(part->comm, (int)lost->told, counts);
  for (int q = 0; q < comm_size(part->comm); q++) n += (size_t)counts[q];
  if (n > 0) {
    comm_gather(part->comm, lost->first, all, counts, sizeof *all);
    qsort(all, n, sizeof *all, by_order);
    lost->told = n < SUMMARY_LOST ? n : SUMMARY_LOST;
    memcpy(lost->first, all, lost->told * sizeof *all);
  }
  free(counts);
  free(all);
}

summary_sums ranks_summary_sums(const engine *e) {
  summary_sums s = summary_sums_of(e->state);
  if (!e->halo) return s;
  s.contacts = ranks_count_contacts(e);
  comm_add(e->comm, &s.bonds, 1);
  comm_total_exact(e->comm, &s.overlap, 1);
  s.farthest = comm_largest(e->comm, s.farthest);
  s.not_finite = comm_or(e->comm, s.not_finite);
  add_lost(e, &s.lost);
  return s;
}

/* --- Columns that a disk or contact has ------------------------------------------------------- */

/* Returns the bytes per free disk in this column of the state; 0: the column has no rows for disks.
 * The result is the same on all ranks, also on ranks without disks. */
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

/* Returns the bytes per contact in this column of the state; 0: the column has no rows for
 * contacts. */
static size_t contact_row(const sd_state *s, const sd_field *f) {
  const bool there =
      f->extent == SD_PER_CONTACT || (f->extent == SD_PER_LAW_CONTACT && s->law_columns);
  return there ? sd_type_size(f->type) : 0;
}

/* Finds the part of a column that all ranks have alike: rows of prescribed bodies, motions, numbers
 * of the run. Returns the bytes of this part; at: receives its address. */
static size_t common_part(const sd_state *s, const sd_field *f, char **at) {
  const size_t size = sd_type_size(f->type);
  *at = sd_field_data(s, f);
  if (state_of_free(f->extent) || state_of_contacts(f->extent)) return 0;
  if (f->extent != SD_PER_BODY) return size * sd_extent_size(s, f->extent);
  const size_t first = s->n_free + s->n_ghosts;
  *at += size * first;
  return size * (s->n_bodies - first);
}

bool common_take(const sd_state *from, sd_state *to) {
  if (state_reserve_breaks(to, from->n_breaks) != SD_OK) return false;
  to->n_breaks = from->n_breaks;
  for (size_t k = 0; k < sd_field_count; k++) {
    char *source, *target;
    const size_t bytes = common_part(from, &sd_fields[k], &source);
    const size_t room = common_part(to, &sd_fields[k], &target);
    assert(bytes == room);
    if (bytes > 0) memcpy(target, source, bytes);
  }
  return true;
}

/* --- Sending columns -------------------------------------------------------------------------- */

/* Adds a column to the columns to be sent, unless its rows have size 0. */
static void add(moving *m, const sd_field *f, size_t size) {
  if (size == 0) return;
  assert(m->n < MOVING_MOST);
  m->field[m->n] = f;
  m->size[m->n++] = size;
}

void moving_disks(moving *m, const sd_model *model, bool bodies) {
  for (size_t k = 0; k < sd_field_count; k++)
    if (!bodies || sd_fields[k].extent == SD_PER_BODY)
      add(m, &sd_fields[k], disk_row(model, &sd_fields[k]));
}

void moving_contacts(moving *m) {
  for (size_t k = 0; k < sd_field_count; k++)
    add(m, &sd_fields[k], contact_row(m->to, &sd_fields[k]));
}

static bool is_zero(const char *data, size_t bytes) {
  assert(data || bytes == 0);
  return bytes == 0 || (data[0] == 0 && memcmp(data, data + 1, bytes - 1) == 0);
}

/* Removes from the list the columns that are zero on all ranks, as most are at the start of a run;
 * the columns of a new state are zero anyway. Returns the number of columns left. */
static size_t leave_zeros(const moving *m, size_t n, route_column *list) {
  const size_t rows =
      state_of_contacts(m->field[0]->extent) ? m->from->n_contacts : m->from->n_free;
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
