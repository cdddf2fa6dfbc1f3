/* ranks_contacts.c: see ranks_contacts.h.
 *
 * Each rank reads as many rows, and keeps a strip of the directory: for each disk of the file its radius, its angle and its rank. A
 * contact goes to the rank that keeps its first disk, to the one that keeps its second, and then to the ranks that have them.
 */
#include "run/ranks_contacts.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "model/tiles.h"
#include "physics/neighbours/order.h"
#include "physics/step/engine.h"
#include "run/route.h"

/* Contacts that a rank reads at a time. */
enum { AT_ONCE = 1 << 16 };

/* Of a disk of the file. */
typedef struct entry {
  deck_turned turned;
  int32_t rank;
  uint32_t number;
} entry;

typedef struct directory {
  const comm *comm;
  const sd_model *model;
  size_t width, first; /* of a strip; of this rank's */
  entry *entries;      /* [width] */
} directory;

static int keeper_of(const directory *d, uint32_t number) { return (int)(number / d->width); }

/* Else the job ends, here: there are other ranks, which would wait for ever. */
static void need(const comm *c, bool memory) {
  assert(comm_size(c) > 1);
  if (memory) return;
  for (;;) comm_fail(c, "no memory for contacts");
}

/* Rows that are all zero. */
static void *room_for(const comm *c, size_t n, size_t size) {
  void *rows;
  need(c, memory_rows(1, (memory_column[]){{&rows, n, size}}));
  return rows;
}

/* Rows of any size to ranks. The rows that come, to be freed. */
static void *send_rows(const comm *c, const void *rows, size_t n, size_t size, const int *rank,
                       size_t *n_come) {
  route r = {0};
  need(c, route_new(&r, c, n, NULL, rank) == SD_OK);
  route_count(&r);
  void *come = room_for(c, r.n_receive, size);
  need(c, route_columns(&r, &(route_column){rows, come, size}, 1, NULL) == SD_OK);
  *n_come = r.n_receive;
  route_free(&r);
  return come;
}

/* --- the directory ----------------------------------------------------------------------------------------------- */

/* Entries to the ranks that keep them: what the file says, or (turned NULL) the rank that has the disk. */
static void tell(directory *d, size_t n, const uint32_t *number, const deck_turned *turned) {
  entry *list = room_for(d->comm, n, sizeof *list);
  int *rank = room_for(d->comm, n, sizeof *rank);
  size_t n_come;
  for (size_t k = 0; k < n; k++) {
    list[k] = (entry){
        .turned = turned ? turned[k] : (deck_turned){0}, .rank = comm_rank(d->comm), .number = number[k]};
    rank[k] = keeper_of(d, number[k]);
  }
  entry *come = send_rows(d->comm, list, n, sizeof *list, rank, &n_come);
  for (size_t k = 0; k < n_come; k++) {
    entry *e = &d->entries[come[k].number - d->first];
    if (turned)
      e->turned = come[k].turned;
    else
      e->rank = come[k].rank;
  }
  free(come);
  free(list);
  free(rank);
}

static sd_status tell_turned(directory *d, sd_messages *messages) {
  const sd_tiles *t = &d->model->tiles;
  const size_t most = model_tile_begin(t, 1), ranks = (size_t)comm_size(d->comm);
  uint32_t *number = room_for(d->comm, most, sizeof *number);
  deck_turned *turned = room_for(d->comm, most, sizeof *turned);
  sd_status status = SD_OK;
  for (size_t k = 0; k < t->n && !comm_or(d->comm, status != SD_OK); k += ranks) {
    const size_t part = k + (size_t)comm_rank(d->comm);
    const size_t n = part < t->n ? model_tile_begin(t, part + 1) - model_tile_begin(t, part) : 0;
    if (n > 0) status = deck_make_turned(d->model, part, number, turned, messages);
    tell(d, status == SD_OK ? n : 0, number, turned);
  }
  free(number);
  free(turned);
  return status;
}

static void tell_ranks(directory *d, const sd_state *part) {
  const size_t before = d->model->tiles.first;
  uint32_t *number = room_for(d->comm, part->n_free, sizeof *number);
  size_t n = 0;
  for (size_t i = 0; i < part->n_free; i++)
    if (part->id[i] >= before) number[n++] = part->id[i] - (uint32_t)before;
  tell(d, n, number, NULL);
  free(number);
}

/* --- contacts ------------------------------------------------------------------------------------------------------ */

/* A contact on its way. */
typedef struct carried {
  sd_contact_memory contact;
  entry a, b; /* as far as they are known */
} carried;

static const sd_tile_wall *wall_of(const sd_tiles *t, const sd_contact_memory *c) {
  return c->b < t->count ? NULL : &t->walls[c->b - t->count];
}

/* To the ranks that keep the first disk of each, or the second. */
static carried *ask(const directory *d, carried *list, size_t *n, bool second) {
  int *rank = room_for(d->comm, *n, sizeof *rank);
  for (size_t k = 0; k < *n; k++) {
    const sd_contact_memory *c = &list[k].contact;
    rank[k] =
        second && wall_of(&d->model->tiles, c) ? comm_rank(d->comm) : keeper_of(d, second ? c->b : c->a);
  }
  carried *come = send_rows(d->comm, list, *n, sizeof *list, rank, n);
  for (size_t k = 0; k < *n; k++) {
    const sd_contact_memory *c = &come[k].contact;
    if (!second)
      come[k].a = d->entries[c->a - d->first];
    else if (!wall_of(&d->model->tiles, c))
      come[k].b = d->entries[c->b - d->first];
  }
  free(rank);
  free(list);
  return come;
}

/* To the ranks that have the disks, as the model has them. */
static void deliver(const directory *d, const carried *list, size_t n, sd_state *part) {
  const sd_tiles *t = &d->model->tiles;
  sd_contact_memory *sent = room_for(d->comm, 2 * n, sizeof *sent);
  int *rank = room_for(d->comm, 2 * n, sizeof *rank);
  size_t n_sent = 0, n_come;
  for (size_t k = 0; k < n; k++) {
    sd_contact_memory c = list[k].contact;
    const sd_tile_wall *wall = wall_of(t, &c);
    const entry *a = &list[k].a, *b = wall ? a : &list[k].b;
    deck_carry_contact(&c, a->turned, b->turned, wall, t->forces_carried);
    c.a += (uint32_t)t->first;
    c.b = wall ? (uint32_t)d->model->n_disks + wall->wall : c.b + (uint32_t)t->first;
    sent[n_sent] = c;
    rank[n_sent++] = a->rank;
    if (b->rank == a->rank) continue;
    sent[n_sent] = c;
    rank[n_sent++] = b->rank;
  }
  sd_contact_memory *come = send_rows(d->comm, sent, n_sent, sizeof *sent, rank, &n_come);
  need(d->comm, sd_state_reserve_contacts(part, part->n_contacts + n_come) == SD_OK);
  for (size_t k = 0; k < n_come; k++) engine_fill_contact(part, &come[k]);
  free(come);
  free(sent);
  free(rank);
}

/* Reads contacts, and leaves out those with walls that the model does not have. */
static sd_status read_contacts(const directory *d, size_t first, size_t n, carried *list, size_t *n_kept,
                               int64_t *inputs, sd_messages *messages) {
  const sd_tiles *t = &d->model->tiles;
  sd_contact_memory *rows = room_for(d->comm, n, sizeof *rows);
  int64_t sum = 0;
  *n_kept = 0;
  sd_status status = SD_OK;
  if (n > 0) status = deck_make_contacts(d->model, first, n, rows, &sum, messages);
  *inputs = (int64_t)((uint64_t)*inputs + (uint64_t)sum);
  for (size_t k = 0; status == SD_OK && k < n; k++)
    if (deck_contact_is_kept(&rows[k], wall_of(t, &rows[k])))
      list[(*n_kept)++] = (carried){.contact = rows[k]};
  free(rows);
  return status;
}

static sd_status take_contacts(const directory *d, sd_state *part, sd_messages *messages) {
  const sd_tiles *t = &d->model->tiles;
  const size_t all = (size_t)comm_size(d->comm) * AT_ONCE;
  int64_t inputs[1] = {0};
  sd_status status = SD_OK;
  for (size_t at = 0; at < t->n_contacts && !comm_or(d->comm, status != SD_OK); at += all) {
    const size_t first = at + (size_t)comm_rank(d->comm) * AT_ONCE,
                 left = first < t->n_contacts ? t->n_contacts - first : 0;
    carried *list = room_for(d->comm, AT_ONCE, sizeof *list);
    size_t n;
    status = read_contacts(d, first, left < AT_ONCE ? left : AT_ONCE, list, &n, inputs, messages);
    list = ask(d, list, &n, false);
    list = ask(d, list, &n, true);
    deliver(d, list, n, part);
    free(list);
  }
  if (comm_or(d->comm, status != SD_OK)) return status;
  comm_add(d->comm, inputs, 1);
  if (inputs[0] == t->contact_inputs) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "disk_files[%zu].file has changed while it was read", t->entry);
}

sd_status ranks_contacts_take(const comm *c, const sd_model *m, sd_state *part, sd_messages *messages) {
  directory d = {.comm = c, .model = m, .width = m->tiles.count / (size_t)comm_size(c) + 1};
  d.first = (size_t)comm_rank(c) * d.width;
  d.entries = room_for(c, d.width, sizeof *d.entries);
  sd_status status = tell_turned(&d, messages);
  if (!comm_or(c, status != SD_OK)) {
    tell_ranks(&d, part);
    status = take_contacts(&d, part, messages);
  }
  free(d.entries);
  return status == SD_OK ? order_contacts(m, part) : status;
}
