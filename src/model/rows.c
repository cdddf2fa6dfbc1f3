/* rows.c: disks of a model that is distributed over MPI ranks: reductions over ranks, and the
 * disks that a rank has for itself; see rows.h. */
#include "model/rows.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* --- reductions over all ranks ---------------------------------------------------------------- */

double rows_largest(const sd_model *m, double value) { return comm_largest(m->comm, value); }
double rows_least(const sd_model *m, double value) { return -comm_largest(m->comm, -value); }
double rows_sum(const sd_model *m, double value) { return comm_total(m->comm, value); }
bool rows_any(const sd_model *m, bool here) { return comm_or(m->comm, here) != 0; }

double rows_extreme(const sd_model *m, double value, uint32_t *disk) {
  const double most = comm_largest(m->comm, value);
  *disk = (uint32_t)rows_least(m, value == most ? (double)*disk : HUGE_VAL);
  return most;
}

/* --- rows of one rank ------------------------------------------------------------------------- */

bool rows_reserve(sd_model *m, size_t n) {
  assert(!m->mine);
  m->mine = memory_new(1, sizeof *m->mine);
  return memory_resize(2, (memory_column[]){{&m->mine->disk, n, sizeof(sd_disk)},
                                            {&m->mine->number, n, sizeof(uint32_t)}});
}

void rows_add(sd_model *m, const sd_disk *disk, uint32_t number) {
  sd_rows *r = m->mine;
  r->disk[r->n] = *disk;
  r->number[r->n++] = number;
}

void rows_free(sd_rows *r) {
  if (!r) return;
  free(r->disk);
  free(r->number);
  free(r->shift);
  free(r->derivatives);
  free(r->memories);
  free(r->contacts);
  *r = (sd_rows){0};
}

size_t model_tile_begin(const sd_tiles *t, size_t part) {
  const size_t each = t->count / t->n, more = t->count % t->n;
  return part * each + (part < more ? part : more);
}

size_t rows_of_tiles(const sd_model *m) {
  const size_t rank = (size_t)comm_rank(m->comm), ranks = (size_t)comm_size(m->comm);
  size_t n = 0;
  for (size_t k = rank; k < m->tiles.n; k += ranks) n += model_tile_size(&m->tiles, k);
  return n;
}

/* --- distribution over ranks ------------------------------------------------------------------ */

bool rows_special(const sd_disk *d) {
  bool special = d->driven || d->clump > 0 || d->name || d->held || disk_holds(d);
  for (int c = 0; c < SD_COORDINATES; c++)
    special = special || d->locked[c] || d->force[c] != 0.0 || signbit(d->force[c]);
  return special;
}

bool model_knows(const sd_model *m, uint32_t disk) {
  size_t from = 0, to = m->n_known;
  if (!m->parted) return disk < m->n_disks;
  while (from < to) {
    const size_t middle = from + (to - from) / 2;
    if (m->known[middle] < disk)
      from = middle + 1;
    else
      to = middle;
  }
  return from < m->n_known && m->known[from] == disk;
}

/* A contiguous range of indices [begin, end). */
typedef struct run_of {
  size_t begin, end;
} run_of;

/* Returns the range of n items that belongs to this rank; few: rank 0 has all of them. */
static run_of share(const comm *c, size_t n, bool few) {
  const size_t rank = (size_t)comm_rank(c), size = (size_t)comm_size(c);
  if (few) return (run_of){rank > 0 ? n : 0, n};
  return (run_of){n * rank / size, n * (rank + 1) / size};
}

/* Appends a disk of model->disks to the disks stored on this rank only. */
static void add_own(sd_model *m, uint32_t disk) {
  sd_rows *r = m->mine;
  if (disk < m->n_derivatives)
    memcpy(r->derivatives[r->n], m->derivatives[disk], sizeof *r->derivatives);
  rows_add(m, &m->disks[disk], disk);
}

/* Appends this rank's range of the free disks in model->disks to the disks stored on this rank
 * only. False: out of memory. */
static bool take_own(sd_model *m, bool few) {
  size_t n = 0, k = 0;
  for (size_t i = 0; i < model_held(m); i++) n += !m->disks[i].driven;
  const run_of own = share(m->comm, n, few);
  if (!m->mine) m->mine = memory_new(1, sizeof *m->mine);
  sd_rows *r = m->mine;
  n = r->n + (own.end - own.begin);
  if (!memory_resize(2, (memory_column[]){{&r->disk, n, sizeof(sd_disk)},
                                          {&r->number, n, sizeof(uint32_t)}}) ||
      (m->n_derivatives > 0 && !memory_row(&r->derivatives, n, sizeof *r->derivatives)))
    return false;
  for (uint32_t i = 0; i < model_held(m); i++) {
    if (m->disks[i].driven) continue;
    if (k >= own.begin && k < own.end) add_own(m, i);
    k++;
  }
  return true;
}

/* Copies this rank's range of the restored contacts to the contacts stored on this rank only.
 * False: out of memory. */
static bool take_memories(sd_model *m, bool few) {
  const run_of own = share(m->comm, m->n_memories, few);
  sd_rows *r = m->mine;
  r->n_memories = own.end - own.begin;
  if (!memory_resize_row(&r->memories, r->n_memories, sizeof *r->memories)) return false;
  if (r->n_memories > 0)
    memcpy(r->memories, m->memories + own.begin, r->n_memories * sizeof *r->memories);
  return true;
}

/* Replaces data of disks that not all ranks must know by zeros, in memory pages that are never
 * written and so take no memory. False: out of memory. */
static bool drop_ordinary(sd_model *m) {
  const size_t held = model_held(m);
  sd_disk *disks;
  m->n_known = 0;
  for (size_t i = 0; i < held; i++) m->n_known += rows_special(&m->disks[i]);
  if (!memory_rows(2, (memory_column[]){{&disks, m->n_disks, sizeof *disks},
                                        {&m->known, m->n_known, sizeof *m->known}}))
    return false;
  m->n_known = 0;
  for (size_t i = 0; i < held; i++) {
    if (!rows_special(&m->disks[i])) continue;
    disks[i] = m->disks[i];
    m->known[m->n_known++] = (uint32_t)i;
  }
  free(m->disks);
  free(m->memories);
  free(m->derivatives);
  m->disks = disks;
  m->memories = NULL;
  m->derivatives = NULL;
  m->n_memories = m->n_derivatives = 0;
  m->parted = true;
  return true;
}

bool rows_part(sd_model *m, size_t few) {
  assert(m->finished && !m->parted);
  const bool is_few = m->n_free < few;
  return take_own(m, is_few) && take_memories(m, is_few) && drop_ordinary(m);
}
