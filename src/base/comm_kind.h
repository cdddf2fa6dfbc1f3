/* comm_kind.h: what ranks of an MPI job and ranks of threads do each in their own way; for
 * base/comm*.c only.
 *
 * Functions are as those of comm.h, of two ranks or more.
 */
#ifndef BASE_COMM_KIND_H
#define BASE_COMM_KIND_H

/* The places of callers of comm.h are noted, not those of its own calls. */
#include "base/comm.h"
#undef comm_max
#undef comm_share
#undef comm_text
#undef comm_or
#undef comm_agree
#undef comm_wait
#undef comm_all_well
#undef comm_largest
#undef comm_total
#undef comm_total_exact
#undef comm_add
#undef comm_counts
#undef comm_exchange
#undef comm_gather_counts
#undef comm_gather
#undef comm_gather_one

typedef struct comm_kind {
  void (*end)(const comm *c, int status);
  int (*max)(const comm *c, int value);
  void (*share)(const comm *c, void *data, size_t bytes);
  unsigned (*any)(const comm *c, unsigned bits);
  double (*largest)(const comm *c, double value);
  void (*add)(const comm *c, int64_t *values, size_t n);
  void (*exchange)(const comm *c, const void *send, const int *to, void *receive, const int *from,
                   size_t size);
  void (*gather)(const comm *c, const void *send, void *receive, const int *counts, size_t size);
  comm_links *(*links_new)(const comm *c, const void *send, const int *to, void *receive,
                           const int *from, size_t size);
  void (*links_start)(comm_links *links);
  void (*links_progress)(comm_links *links);
  void (*links_wait)(comm_links *links);
  void (*links_free)(comm_links *links);
} comm_kind;

struct comm {
  const comm_kind *kind;
  int rank, size;
};

/* The first member of the links of each kind. */
struct comm_links {
  const comm *comm;
};

/* The first row of each rank, to be freed. */
int *comm_starts(const comm *c, const int *counts);

#endif
