/* comm_cuts.h: the plane cut into rectangles, one a rank, by recursive bisection. Outer
 * rectangles have no end.
 *
 * Collective where said; of a rank alone the plane is one rectangle. An MPI job cuts by Zoltan's
 * RCB, which needs no rank to know all points; ranks of threads know them all.
 */
#ifndef BASE_COMM_CUTS_H
#define BASE_COMM_CUTS_H

#include <stddef.h>

#include "base/comm.h"

typedef struct comm_cuts comm_cuts;

/* Collective. It is NULL when Zoltan does not start, never with one rank. */
comm_cuts *comm_cuts_new(const comm *c);
void comm_cuts_free(comm_cuts *cuts);
/* The ranks that it was made for. */
const comm *comm_cuts_comm(const comm_cuts *cuts);
/* Collective: cuts anew, so that the weights of the points, wherever they stand now, are equal.
 * SD_ERROR_IO, on any rank: Zoltan failed, or there is no memory. */
sd_status comm_cuts_make(comm_cuts *cuts, size_t n, const double *x, const double *y,
                         const float *weight);
/* Rank of the rectangle that holds the point: the same answer on all ranks. */
int comm_cuts_owner(const comm_cuts *cuts, double x, double y);
/* Ranks whose rectangles meet the box, each once, into ranks[comm_size()]; how many. */
int comm_cuts_near(const comm_cuts *cuts, const double low[2], const double high[2], int *ranks);
/* Rectangle of this rank; sides without an end are +-HUGE_VAL. */
void comm_cuts_mine(const comm_cuts *cuts, double low[2], double high[2]);

#endif
