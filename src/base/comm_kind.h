/* comm_kind.h: the table of functions that are implemented both for MPI processes and for threads
 * as ranks; for base/comm*.c only.
 *
 * Each function does what the function of the same name in comm.h does, for two ranks or more.
 * `end` stands for comm_abort, `any` for comm_or.
 */
#ifndef BASE_COMM_KIND_H
#define BASE_COMM_KIND_H

/* The #undef lines remove macros that builds with SD_CHECK define: calls inside base/comm*.c must
 * not overwrite the source location that the caller of comm.h has stored. */
#include "base/comm.h"
#undef comm_max
#undef comm_broadcast
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

/* First member of the structs for persistent messages, that of MPI ranks and that of threads as
 * ranks. */
struct comm_links {
  const comm *comm;
};

/* Returns the index of each rank's first row in a buffer with counts[q] rows for each rank q; the
 * caller frees the array. */
int *comm_starts(const comm *c, const int *counts);

#endif
