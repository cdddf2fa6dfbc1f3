/* directory.c: see directory.h. */
#include "run/directory.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "run/route.h"

void directory_new(directory *d, const comm *c, size_t n, size_t size) {
  *d = (directory){.comm = c, .width = n / (size_t)comm_size(c) + 1, .size = size};
  d->first = (size_t)comm_rank(c) * d->width;
  d->rows = route_room(c, d->width, size);
}

void directory_free(directory *d) {
  free(d->rows);
  *d = (directory){0};
}

/* Numbers to their keepers. The numbers that come, to be freed. */
static uint32_t *call(const directory *d, route *r, size_t n, const uint32_t *number) {
  int *keeper = route_room(d->comm, n, sizeof *keeper);
  for (size_t k = 0; k < n; k++) keeper[k] = (int)(number[k] / d->width);
  if (route_new(r, d->comm, n, NULL, keeper) != SD_OK) comm_fail(d->comm, "no memory");
  free(keeper);
  route_count(r);
  uint32_t *come = route_room(d->comm, r->n_receive, sizeof *come);
  route_columns(r, &(route_column){number, come, sizeof *come}, 1, NULL);
  return come;
}

static char *row_of(const directory *d, uint32_t number) {
  assert(number >= d->first && number < d->first + d->width);
  return d->rows + (number - d->first) * d->size;
}

void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows) {
  route r;
  uint32_t *come = call(d, &r, n, number);
  char *values = route_room(d->comm, r.n_receive, d->size);
  route_columns(&r, &(route_column){rows, values, d->size}, 1, NULL);
  for (size_t k = 0; k < r.n_receive; k++) memcpy(row_of(d, come[k]), values + k * d->size, d->size);
  route_free(&r);
  free(come);
  free(values);
}

void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows) {
  route r;
  uint32_t *come = call(d, &r, n, number);
  char *values = route_room(d->comm, r.n_receive, d->size);
  for (size_t k = 0; k < r.n_receive; k++) memcpy(values + k * d->size, row_of(d, come[k]), d->size);
  route_answer(&r, (route_column){values, rows, d->size});
  route_free(&r);
  free(come);
  free(values);
}
