/* comm_mpi.h: the communicator of comm_job.c, for base/comm*.c only. */
#ifndef BASE_COMM_MPI_H
#define BASE_COMM_MPI_H

#include <mpi.h>

#include "base/comm_kind.h"

/* Our own, apart from other users of MPI in the process; from comm_begin to comm_end. */
extern MPI_Comm comm_ranks;
/* Sleeps longer and longer, from 20 us to 5 ms, and so until the request is done. */
void comm_rest(long *ns);
void comm_await(MPI_Request *request);

#endif
