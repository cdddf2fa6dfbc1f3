/* ranks_order.c: see ranks_order.h. */
#include "run/ranks_order.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "physics/neighbours/order.h"
#include "run/route.h"

/* Strips, some together where there are very many: buckets that ascend in the order, the last of disks that are not in play. */
typedef struct buckets {
  uint64_t strips, width; /* of one size; strips in a bucket */
  size_t n, *begin;       /* [n + 1]: disks of all ranks before them */
} buckets;

enum { STRIPS = 1 << 16 };

static size_t bucket_of(const buckets *b, const order_place *p) {
  if (p->strip == UINT64_MAX) return b->n - 1;
  return (size_t)(p->level * b->strips + p->strip / b->width);
}

static sd_status count_buckets(const comm *c, const order_place *list, size_t n, buckets *b) {
  double strip = 0.0, level = 0.0;
  for (size_t k = 0; k < n; k++) {
    if (list[k].strip == UINT64_MAX) continue;
    strip = fmax(strip, (double)list[k].strip);
    level = fmax(level, (double)list[k].level);
  }
  const uint64_t most = (uint64_t)comm_largest(c, strip) + 1;
  b->width = (most + STRIPS - 1) / STRIPS;
  b->strips = (most + b->width - 1) / b->width;
  b->n = (size_t)((uint64_t)comm_largest(c, level) + 1) * (size_t)b->strips + 1;
  int64_t *counts;
  if (!memory_rows(
          2, (memory_column[]){{&b->begin, b->n + 1, sizeof *b->begin}, {&counts, b->n, sizeof *counts}}))
    return SD_ERROR_IO;
  for (size_t k = 0; k < n; k++) counts[bucket_of(b, &list[k])]++;
  comm_add(c, counts, b->n);
  for (size_t k = 0; k < b->n; k++) b->begin[k + 1] = b->begin[k] + (size_t)counts[k];
  free(counts);
  return SD_OK;
}

/* The rank that numbers a bucket: they ascend with the order, so that each numbers a run of it. */
static int keeper_of(const comm *c, const buckets *b, size_t bucket) {
  const size_t all = b->begin[b->n], ranks = (size_t)comm_size(c);
  return (int)(b->begin[bucket] * ranks / all);
}

static size_t first_kept(const comm *c, const buckets *b) {
  size_t k = 0;
  while (k < b->n && (b->begin[k + 1] == b->begin[k] || keeper_of(c, b, k) < comm_rank(c))) k++;
  return b->begin[k];
}

/* Numbers from `first` on, by the order of the places. */
static void number_places(order_place *came, size_t n, size_t first, uint32_t *number) {
  for (size_t k = 0; k < n; k++) came[k].slot = (uint32_t)k;
  if (n > 1) qsort(came, n, sizeof *came, order_by_place);
  for (size_t k = 0; k < n; k++) number[came[k].slot] = (uint32_t)(first + k);
}

/* Slots in the whole of the places of this rank, which ascend. rank: room for n. Collective. */
static sd_status find_order(const comm *c, const order_place *list, size_t n, int *rank, uint32_t *order) {
  buckets b = {0};
  route r = {0};
  order_place *came = NULL;
  uint32_t *number = NULL;
  sd_status status = count_buckets(c, list, n, &b);
  for (size_t k = 0; status == SD_OK && k < n; k++) rank[k] = keeper_of(c, &b, bucket_of(&b, &list[k]));
  if (status == SD_OK) status = route_new(&r, c, n, NULL, rank);
  if (status != SD_OK) comm_fail(c, "no memory");
  if (status == SD_OK) route_count(&r);
  const size_t n_came = r.n_receive;
  const memory_column arrays[] = {{&came, n_came, sizeof *came}, {&number, n_came, sizeof *number}};
  if (status == SD_OK && !memory_resize(sizeof arrays / sizeof *arrays, arrays)) {
    comm_fail(c, "no memory");
    status = SD_ERROR_IO;
  }
  if (status == SD_OK) status = route_columns(&r, &(route_column){list, came, sizeof *came}, 1, NULL);
  if (status == SD_OK) {
    number_places(came, n_came, first_kept(c, &b), number);
    route_answer(&r, (route_column){number, order, sizeof *order});
  }
  for (size_t k = 1; k < n && status == SD_OK; k++) assert(order[k - 1] < order[k]);
  route_free(&r);
  free(b.begin);
  free(came);
  free(number);
  return status;
}

sd_status ranks_order(const comm *c, const sd_model *m, sd_state *part, uint32_t *order) {
  order_place *list = NULL;
  int *rank = NULL;
  const memory_column arrays[] = {{&list, part->n_free, sizeof *list}, {&rank, part->n_free, sizeof *rank}};
  const bool there = memory_resize(sizeof arrays / sizeof *arrays, arrays);
  sd_status status = there ? order_part(m, part, c, list) : SD_ERROR_IO;
  if (status != SD_OK) comm_fail(c, "no memory for the order of its disks");
  if (status == SD_OK) status = find_order(c, list, part->n_free, rank, order);
  free(list);
  free(rank);
  return status;
}
