/* comm.h: collective functions for ranks that work together on one run, or on the runs of one
 * parameter sweep.
 *
 * A comm is the group of ranks of an MPI job (comm_world), or a group of threads of this process
 * that act as ranks (comm_threads.c). NULL stands for a single rank: every function accepts it and
 * then does nothing or returns its own argument, so that a run on one process needs no code of its
 * own.
 *
 * Functions are collective unless their comment says otherwise: every rank calls them, in the same
 * order, each from one thread at a time. Builds with SLIPDISK_CHECK compare the source locations of
 * the calls; a rank that makes another call ends the job with a message instead of a deadlock.
 *
 * Data are exchanged in rows, elements of `size` bytes each. Counts are numbers of rows per rank
 * [comm_size()]; buffers hold the rows to (or from) rank 0 first, then those of rank 1, and so on.
 */
#ifndef BASE_COMM_H
#define BASE_COMM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/exact_sum.h"
#include "slipdisk/status.h"

typedef struct comm comm;

/* Starts MPI. The thread that calls it makes all later calls for comm_world. A process that forks
 * workers must fork them before this call, or never call it. Returns SD_ERROR_USER if a launcher
 * started several processes that cannot find each other, because this build has no MPI or another
 * MPI; SD_ERROR_IO if MPI does not start. */
sd_status comm_begin(sd_messages *messages);
/* Waits for all ranks, then ends MPI. Does nothing if comm_begin was not called or failed. */
void comm_end(void);
/* Returns the communicator of all ranks of the job; NULL if this process is the only one. Not
 * collective. */
const comm *comm_world(void);

/* comm_rank returns the number of this rank, counted from 0; comm_size the number of ranks. Not
 * collective. */
int comm_rank(const comm *c);
int comm_size(const comm *c);
/* Ends all processes of the job at once with this exit status, after an error that would leave
 * other ranks waiting forever. With one rank it does nothing: the caller then ends the process
 * itself. Not collective. */
void comm_abort(const comm *c, int status);
/* comm_fail reports `why` through the function that comm_on_fail has registered, then calls
 * comm_abort with SD_ERROR_IO. Neither function is collective. */
void comm_fail(const comm *c, const char *why);
void comm_on_fail(void (*tell)(const char *why));

/* comm_max returns the largest value over all ranks. comm_broadcast broadcasts `bytes` bytes at
 * `data` from rank 0 to all ranks. In both, ranks that wait sleep and do not spin. */
int comm_max(const comm *c, int value);
void comm_broadcast(const comm *c, void *data, size_t bytes);
/* Broadcasts a text from rank 0; the other ranks may pass NULL. Returns a copy of the text on every
 * rank, which the caller frees. */
char *comm_text(const comm *c, const char *text);
/* Returns the bitwise OR of the bits of all ranks. */
unsigned comm_or(const comm *c, unsigned bits);
/* Returns the largest status over all ranks, on every rank: SD_OK only if all ranks pass SD_OK. */
sd_status comm_agree(const comm *c, sd_status status);
/* Returns the largest status over all ranks, like comm_agree, but ranks that wait sleep and do not
 * spin: for use where one rank works for long while the others wait. */
sd_status comm_wait(const comm *c, sd_status status);
/* Returns true on every rank if all ranks pass SD_OK. */
bool comm_all_well(const comm *c, sd_status status);
/* comm_largest returns the largest value over all ranks; comm_total the sum over all ranks, added
 * in the order of ranks. */
double comm_largest(const comm *c, double value);
double comm_total(const comm *c, double value);
/* Replaces each of the n exact sums (exact_sum.h) by its total over all ranks, without rounding. */
void comm_total_exact(const comm *c, exact_sum *sums, size_t n);
/* Replaces each of n integers by its sum over all ranks. */
void comm_add(const comm *c, int64_t *values, size_t n);
/* Exchanges numbers of rows between all ranks: to[q] is the number that this rank will send to rank
 * q, from[q] is set to the number that rank q will send to this rank. */
void comm_counts(const comm *c, const int *to, int *from);
/* Sends rows to each rank and receives rows from each rank (all-to-all). send: to[0] rows for rank
 * 0, then to[1] rows for rank 1, and so on; receive: from[0] rows of rank 0, then from[1] rows of
 * rank 1, and so on. */
void comm_exchange(const comm *c, const void *send, const int *to, void *receive, const int *from,
                   size_t size);
/* comm_gather_counts sets counts[q] to the number of rows (`mine`) of each rank q. comm_gather then
 * gathers the rows of all ranks on every rank. */
void comm_gather_counts(const comm *c, int mine, int *counts);
void comm_gather(const comm *c, const void *send, void *receive, const int *counts, size_t size);
/* Gathers one row of `size` bytes of each rank on every rank. receive: [comm_size()] rows. */
void comm_gather_one(const comm *c, const void *send, void *receive, size_t size);

/* Persistent messages, which send the same numbers of rows between the same buffers again and
 * again. comm_links_start reads `send`; neither buffer may be touched until comm_links_wait has
 * returned. comm_links_progress lets MPI move long messages, which it does only inside its own
 * calls; it never waits and is not collective. */
typedef struct comm_links comm_links;
comm_links *comm_links_new(const comm *c, const void *send, const int *to, void *receive,
                           const int *from, size_t size);
void comm_links_start(comm_links *links);
void comm_links_progress(comm_links *links);
void comm_links_wait(comm_links *links);
void comm_links_free(comm_links *links);

#ifdef SD_CHECK
/* COMM_HERE stores the source location at which this thread calls the next collective function; the
 * macros below put it before each call. */
#define COMM_TEXT(line) #line
#define COMM_LINE(line) COMM_TEXT(line)
#define COMM_HERE comm_at(__FILE__ ":" COMM_LINE(__LINE__))
void comm_at(const char *place);
#define comm_max(...) (COMM_HERE, comm_max(__VA_ARGS__))
#define comm_broadcast(...) (COMM_HERE, comm_broadcast(__VA_ARGS__))
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

/* --- threads of one process as ranks, so that tests need no launcher -------------------------- */

/* Runs task(c, with) on n ranks, each of which is a thread of its own, and returns when all have
 * returned. If memory runs out, or after comm_abort, the process ends (memory_lacks). */
void comm_threads_run(int n, void (*task)(const comm *c, void *with), void *with);

#endif
