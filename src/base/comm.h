/* comm.h: ranks that work together on one run, or on the points of one sweep.
 *
 * A comm is the ranks of an MPI job (comm_world), or threads of this process (comm_threads.c).
 * NULL is a rank alone: every function takes it, and then there is nothing to agree on, so that a
 * run over ranks and a run of one process are the same text.
 *
 * Functions are collective where that is not denied: every rank calls them, in the same order,
 * each from one thread at a time. Builds with SLIPDISK_CHECK compare the places of the calls, and
 * a rank that is elsewhere ends the job with a message instead of a wait for ever.
 *
 * A row is `size` bytes. Counts are rows per rank [comm_size()]; rows to and from ranks stand one
 * rank after the other.
 */
#ifndef BASE_COMM_H
#define BASE_COMM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/exact_sum.h"
#include "slipdisk/status.h"

typedef struct comm comm;

/* Starts MPI, from the thread that then makes all calls for comm_world. A process that forks
 * workers does so before, or does not call it. SD_ERROR_USER: a launcher started several
 * processes that do not know of each other, since this is a build without MPI or for another MPI.
 * SD_ERROR_IO: MPI does not start. */
sd_status comm_begin(sd_messages *messages);
/* Waits for all ranks. Does nothing when comm_begin was not called or failed. */
void comm_end(void);
/* All ranks of the job; NULL: this process is alone. Not collective. */
const comm *comm_world(void);

/* Not collective. */
int comm_rank(const comm *c);
int comm_size(const comm *c);
/* Ends the processes of all ranks of the job at once with this exit status, after an error that
 * leaves the others waiting for ever. With one rank it does nothing: to end the process is the
 * caller's affair. Not collective. */
void comm_abort(const comm *c, int status);
/* The same with SD_ERROR_IO, after what comm_on_fail was given has told why. Not collective. */
void comm_fail(const comm *c, const char *why);
void comm_on_fail(void (*tell)(const char *why));

/* The largest value of all ranks, and what rank 0 has at data, on all ranks. Waits sleep, they do
 * not spin. */
int comm_max(const comm *c, int value);
void comm_share(const comm *c, void *data, size_t bytes);
/* The text that rank 0 has, on all ranks, to be freed; others may give NULL. */
char *comm_text(const comm *c, const char *text);
/* Bits that any rank has set. */
unsigned comm_or(const comm *c, unsigned bits);
/* The status on which all ranks agree: SD_OK when it is that of each. */
sd_status comm_agree(const comm *c, sd_status status);
/* The same where one rank has worked for long while the others waited: waits sleep, they do not
 * spin. */
sd_status comm_wait(const comm *c, sd_status status);
/* No rank has failed. */
bool comm_all_well(const comm *c, sd_status status);
/* Largest value, and the sum, of all ranks. */
double comm_largest(const comm *c, double value);
double comm_total(const comm *c, double value);
/* n sums of all ranks, without rounding. */
void comm_total_exact(const comm *c, exact_sum *sums, size_t n);
/* Each of n numbers becomes its sum over all ranks. */
void comm_add(const comm *c, int64_t *values, size_t n);
/* How many rows each rank sends here. */
void comm_counts(const comm *c, const int *to, int *from);
/* Rows to each rank, and from each. */
void comm_exchange(const comm *c, const void *send, const int *to, void *receive, const int *from,
                   size_t size);
/* The rows of all ranks on every rank. mine: how many this one has; counts: filled by
 * comm_gather_counts. */
void comm_gather_counts(const comm *c, int mine, int *counts);
void comm_gather(const comm *c, const void *send, void *receive, const int *counts, size_t size);
/* One row of each rank. receive: [comm_size()] rows. */
void comm_gather_one(const comm *c, const void *send, void *receive, size_t size);

/* Persistent messages: the same rows from and to the same places again and again.
 * comm_links_start reads `send`, and until comm_links_wait has returned neither may be touched.
 * MPI moves long messages only while it is called: comm_links_progress does that, never waits,
 * and is not collective. */
typedef struct comm_links comm_links;
comm_links *comm_links_new(const comm *c, const void *send, const int *to, void *receive,
                           const int *from, size_t size);
void comm_links_start(comm_links *links);
void comm_links_progress(comm_links *links);
void comm_links_wait(comm_links *links);
void comm_links_free(comm_links *links);

#ifdef SD_CHECK
/* Notes the place from which this thread calls the next collective function. */
#define COMM_TEXT(line) #line
#define COMM_LINE(line) COMM_TEXT(line)
#define COMM_HERE comm_at(__FILE__ ":" COMM_LINE(__LINE__))
void comm_at(const char *place);
#define comm_max(...) (COMM_HERE, comm_max(__VA_ARGS__))
#define comm_share(...) (COMM_HERE, comm_share(__VA_ARGS__))
#define comm_text(...) (COMM_HERE, comm_text(__VA_ARGS__))
#define comm_or(...) (COMM_HERE, comm_or(__VA_ARGS__))
#define comm_agree(...) (COMM_HERE, comm_agree(__VA_ARGS__))
#define comm_wait(...) (COMM_HERE, comm_wait(__VA_ARGS__))
#define comm_all_well(...) (COMM_HERE, comm_all_well(__VA_ARGS__))
#define comm_largest(...) (COMM_HERE, comm_largest(__VA_ARGS__))
#define comm_total(...) (COMM_HERE, comm_total(__VA_ARGS__))
#define comm_total_exact(...) (COMM_HERE, comm_total_exact(__VA_ARGS__))
#define comm_add(...) (COMM_HERE, comm_add(__VA_ARGS__))
#define comm_counts(...) (COMM_HERE, comm_counts(__VA_ARGS__))
#define comm_exchange(...) (COMM_HERE, comm_exchange(__VA_ARGS__))
#define comm_gather_counts(...) (COMM_HERE, comm_gather_counts(__VA_ARGS__))
#define comm_gather(...) (COMM_HERE, comm_gather(__VA_ARGS__))
#define comm_gather_one(...) (COMM_HERE, comm_gather_one(__VA_ARGS__))
#endif

/* --- ranks that are threads of one process, so that tests need no launcher -------------------- */

/* Runs task(c, with) on n ranks, each a thread, and returns when all have returned. Without memory, or
 * after comm_abort, the process ends as memory_lacks says. */
void comm_threads_run(int n, void (*task)(const comm *c, void *with), void *with);

#endif
