/* comm_mpi.h: the communicator of comm.c, for base/comm*.c only. */
#ifndef BASE_COMM_MPI_H
#define BASE_COMM_MPI_H

#include <mpi.h>

/* Our own, apart from other users of MPI in the process; from comm_begin to comm_end. */
extern MPI_Comm comm_ranks;

#endif
