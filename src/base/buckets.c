/* buckets.c: implements buckets.h. */
#include "base/buckets.h"

#include <stdlib.h>

#include "base/memory.h"

bool buckets_new(buckets *b, size_t n, size_t n_buckets, bucket_of *of, const void *with) {
  size_t k;
  if (!memory_rows(2, (memory_column[]){{&b->start, n_buckets + 1, sizeof *b->start},
                                        {&b->item, n, sizeof *b->item}}))
    return false;
  for (size_t i = 0; i < n; i++)
    if ((k = of(with, i)) < n_buckets) b->start[k]++;
  for (k = 0; k < n_buckets; k++) b->start[k + 1] += b->start[k];
  /* start[k] is the end of bucket k here, and its begin when all its items are in place */
  for (size_t i = n; i-- > 0;)
    if ((k = of(with, i)) < n_buckets) b->item[--b->start[k]] = (uint32_t)i;
  return true;
}

void buckets_free(buckets *b) {
  free(b->start);
  free(b->item);
  *b = (buckets){0};
}
