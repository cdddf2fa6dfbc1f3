/* route.c: packs rows for other ranks, exchanges them and unpacks those received; see route.h. */
#include "run/route.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/buckets.h"
#include "base/comm.h"
#include "base/memory.h"

void *route_allocate(const comm *c, size_t n, size_t size) {
  void *rows;
  assert(comm_size(c) > 1);
  while (!memory_row(&rows, n, size)) comm_fail(c, "no memory");
  return rows;
}

void route_free(route *r) {
  free(r->to);
  free(r->from);
  free(r->row);
  free(r->out);
  free(r->in);
  *r = (route){0};
}

static size_t rank_of(const void *with, size_t k) { return (size_t)((const int *)with)[k]; }

sd_status route_new(route *r, const comm *c, size_t n, const uint32_t *row, const int *rank) {
  const size_t ranks = (size_t)comm_size(c);
  *r = (route){.comm = c,
               .n_send = n,
               .to = memory_new(ranks, sizeof *r->to),
               .from = memory_new(ranks, sizeof *r->from)};
  buckets b;
  if (!buckets_new(&b, n, ranks, rank_of, rank)) return SD_ERROR_IO;
  r->row = b.item;
  for (size_t q = 0; q < ranks; q++) r->to[q] = (int)(b.start[q + 1] - b.start[q]);
  for (size_t k = 0; row && k < n; k++) r->row[k] = row[r->row[k]];
  free(b.start);
  return SD_OK;
}

void route_count(route *r) {
  comm_counts(r->comm, r->to, r->from);
  for (int q = 0; q < comm_size(r->comm); q++) r->n_receive += (size_t)r->from[q];
}

/* Copy of n rows: row from_row[k] of `from` becomes row to_row[k] of `to`; from_row or to_row NULL:
 * row k. Rows are from_stride and to_stride bytes apart. */
typedef struct row_copy {
  char *to;
  size_t to_stride;
  const uint32_t *to_row;
  const char *from;
  size_t from_stride;
  const uint32_t *from_row;
} row_copy;

static void copy_rows(const row_copy *r, size_t n, size_t size) {
  for (size_t k = 0; k < n; k++) {
    char *to = r->to + r->to_stride * (r->to_row ? r->to_row[k] : k);
    const char *from = r->from + r->from_stride * (r->from_row ? r->from_row[k] : k);
    if (size == sizeof(double))
      memcpy(to, from, sizeof(double));
    else if (size == sizeof(int32_t))
      memcpy(to, from, sizeof(int32_t));
    else
      memcpy(to, from, size);
  }
}

/* Returns the number of rows to or from lower ranks: the index in the buffer at which the rows that
 * stay on this rank would be. counts: r->to or r->from. */
static size_t before_own(const route *r, const int *counts) {
  size_t n = 0;
  for (int q = 0; q < comm_rank(r->comm); q++) n += (size_t)counts[q];
  return n;
}

/* Enlarges a buffer to at least `bytes` bytes; its contents are lost. */
static sd_status reserve(const comm *c, char **buffer, size_t *capacity, size_t bytes) {
  if (bytes <= *capacity) return SD_OK;
  free(*buffer);
  *buffer = NULL;
  *capacity = bytes;
  if (memory_resize_row(buffer, bytes, 1)) return SD_OK;
  comm_fail(c, "no memory"); /* ends the job, since the other ranks would wait */
  return SD_ERROR_IO;
}

/* Copies the rows of one column that go to other ranks into the send buffer, whose rows hold all
 * columns one after the other. offset: position of this column in a row of the buffer; all: bytes
 * of such a row. */
static void pack(const route *r, const route_column *c, size_t offset, size_t all) {
  const size_t before = before_own(r, r->to), own = (size_t)r->to[comm_rank(r->comm)],
               after = before + own;
  char *to = r->out + offset;
  copy_rows(&(row_copy){to, all, NULL, c->from, c->size, r->row}, before, c->size);
  copy_rows(&(row_copy){to + all * before, all, NULL, c->from, c->size, r->row + after},
            r->n_send - after, c->size);
}

/* Copies one column of the received rows to its destination, and directly those rows of the column
 * that stay on this rank. */
static void unpack(const route *r, const route_column *c, size_t offset, size_t all,
                   const uint32_t *place) {
  const size_t before = before_own(r, r->from), own = (size_t)r->from[comm_rank(r->comm)],
               after = before + own;
  const size_t sent = before_own(r, r->to);
  const char *in = r->in + offset;
  char *to = c->to;
  if (place) {
    copy_rows(&(row_copy){to, c->size, place, in, all, NULL}, before, c->size);
    copy_rows(&(row_copy){to, c->size, place + before, c->from, c->size, r->row + sent}, own,
              c->size);
    copy_rows(&(row_copy){to, c->size, place + after, in + all * before, all, NULL},
              r->n_receive - after, c->size);
  } else {
    copy_rows(&(row_copy){to, c->size, NULL, in, all, NULL}, before, c->size);
    copy_rows(&(row_copy){to + c->size * before, c->size, NULL, c->from, c->size, r->row + sent},
              own, c->size);
    copy_rows(&(row_copy){to + c->size * after, c->size, NULL, in + all * before, all, NULL},
              r->n_receive - after, c->size);
  }
}

/* All columns that go to one rank are sent in one message. */
sd_status route_columns(route *r, const route_column *column, size_t n, const uint32_t *place) {
  const int here = comm_rank(r->comm);
  const int own = r->to[here];
  size_t all = 0, offset = 0;
  assert(own == r->from[here]);
  for (size_t k = 0; k < n; k++) all += column[k].size;
  if (reserve(r->comm, &r->out, &r->capacity_out, all * (r->n_send - (size_t)own + 1)) != SD_OK ||
      reserve(r->comm, &r->in, &r->capacity_in, all * (r->n_receive - (size_t)own + 1)) != SD_OK)
    return SD_ERROR_IO;
  for (size_t k = 0; k < n; offset += column[k++].size) pack(r, &column[k], offset, all);
  r->to[here] = r->from[here] = 0;
  comm_exchange(r->comm, r->out, r->to, r->in, r->from, all);
  r->to[here] = r->from[here] = own;
  offset = 0;
  for (size_t k = 0; k < n; offset += column[k++].size) unpack(r, &column[k], offset, all, place);
  return SD_OK;
}

void route_send_back(const route *r, route_column column) {
  route back = {.comm = r->comm,
                .n_send = r->n_receive,
                .n_receive = r->n_send,
                .to = r->from,
                .from = r->to};
  back.row = route_allocate(r->comm, back.n_send, sizeof *back.row);
  for (size_t k = 0; k < back.n_send; k++) back.row[k] = (uint32_t)k;
  route_columns(&back, &column, 1, r->row);
  back.to = back.from = NULL; /* r owns these two arrays: do not free them with `back` */
  route_free(&back);
}

void route_merge(const route *r, const uint32_t *order, uint32_t *place) {
  const size_t ranks = (size_t)comm_size(r->comm);
  size_t *at = memory_new(2 * ranks, sizeof *at), *end = at + ranks, begin = 0;
  runs heads;
  runs_new(&heads, ranks);
  for (size_t q = 0; q < ranks; begin = end[q++]) {
    at[q] = begin;
    end[q] = begin + (size_t)r->from[q];
    if (at[q] < end[q]) runs_add(&heads, q, order[at[q]]);
  }
  for (uint32_t n = 0; n < r->n_receive; n++) {
    const size_t q = runs_least(&heads);
    place[at[q]++] = n;
    if (at[q] < end[q])
      runs_step(&heads, order[at[q]]);
    else
      runs_end(&heads);
  }
  runs_free(&heads);
  free(at);
}

void directory_new(directory *d, const comm *c, size_t n, size_t size) {
  *d = (directory){.comm = c, .width = n / (size_t)comm_size(c) + 1, .size = size};
  d->first = (size_t)comm_rank(c) * d->width;
  d->rows = route_allocate(c, d->width, size);
}

void directory_free(directory *d) {
  free(d->rows);
  *d = (directory){0};
}

/* Sends the numbers to the ranks that store their rows. Returns the numbers that this rank receives
 * from others, which the caller frees. */
static uint32_t *call(const directory *d, route *r, size_t n, const uint32_t *number) {
  int *keeper = route_allocate(d->comm, n, sizeof *keeper);
  for (size_t k = 0; k < n; k++) keeper[k] = (int)(number[k] / d->width);
  if (route_new(r, d->comm, n, NULL, keeper) != SD_OK) comm_fail(d->comm, "no memory");
  free(keeper);
  route_count(r);
  uint32_t *come = route_allocate(d->comm, r->n_receive, sizeof *come);
  route_columns(r, &(route_column){number, come, sizeof *come}, 1, NULL);
  return come;
}

/* Returns the address of the row for a number that this rank stores. */
static char *row_of(const directory *d, uint32_t number) {
  assert(number >= d->first && number < d->first + d->width);
  return d->rows + (number - d->first) * d->size;
}

void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows) {
  route r;
  uint32_t *come = call(d, &r, n, number);
  char *values = route_allocate(d->comm, r.n_receive, d->size);
  route_columns(&r, &(route_column){rows, values, d->size}, 1, NULL);
  for (size_t k = 0; k < r.n_receive; k++)
    memcpy(row_of(d, come[k]), values + k * d->size, d->size);
  route_free(&r);
  free(come);
  free(values);
}

void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows) {
  route r;
  uint32_t *come = call(d, &r, n, number);
  char *values = route_allocate(d->comm, r.n_receive, d->size);
  for (size_t k = 0; k < r.n_receive; k++)
    memcpy(values + k * d->size, row_of(d, come[k]), d->size);
  route_send_back(&r, (route_column){values, rows, d->size});
  route_free(&r);
  free(come);
  free(values);
}
