/* comm_mpi.h: the MPI communicator of the job, for base/comm*.c only. */
#ifndef BASE_COMM_MPI_H
#define BASE_COMM_MPI_H

#include <mpi.h>

#include "base/comm_kind.h"

/* Duplicate of MPI_COMM_WORLD, separate from other users of MPI in the process. Valid from
 * comm_begin to comm_end. */
extern MPI_Comm comm_ranks;
/* comm_rest sleeps, longer in each call: *ns, 0 before the first call, becomes 20 us and then
 * doubles up to 5 ms. comm_await waits for an MPI request in this way, without spinning. */
void comm_rest(long *ns);
void comm_await(MPI_Request *request);

#endif
