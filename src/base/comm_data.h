/* comm_data.h: data between the ranks of one run; see comm.h. Collective: every rank calls, from the thread that called comm_begin.
 *
 * A row is `size` bytes. Counts are rows per rank [comm_size()]; rows to and from ranks stand one rank after the other. With one
 * rank all of it copies from the sender to itself.
 */
#ifndef BASE_COMM_DATA_H
#define BASE_COMM_DATA_H

#include <stddef.h>
#include <stdint.h>

#include "base/exact_sum.h"

/* Bits that any rank has set. */
unsigned comm_or(unsigned bits);
/* Largest value, and the sum, of all ranks. */
double comm_largest(double value);
double comm_total(double value);
/* n sums of all ranks, without rounding. */
void comm_total_exact(exact_sum *sums, size_t n);
/* Each of n numbers becomes its sum over all ranks. */
void comm_add(int64_t *values, size_t n);
/* How many rows each rank sends here. */
void comm_counts(const int *to, int *from);
/* Rows to each rank, and from each. */
void comm_exchange(const void *send, const int *to, void *receive, const int *from, size_t size);
/* The rows of all ranks on every rank. mine: how many this one has; counts: filled by comm_gather_counts. */
void comm_gather_counts(int mine, int *counts);
void comm_gather(const void *send, void *receive, const int *counts, size_t size);

/* Persistent messages: the same rows from and to the same places again and again. comm_links_start reads `send`, and until
 * comm_links_wait has returned neither may be touched. MPI moves long messages only while it is called: comm_links_progress does
 * that, and never waits. */
typedef struct comm_links comm_links;
comm_links *comm_links_new(const void *send, const int *to, void *receive, const int *from, size_t size);
void comm_links_start(comm_links *links);
void comm_links_progress(comm_links *links);
void comm_links_wait(comm_links *links);
void comm_links_free(comm_links *links);

#endif
