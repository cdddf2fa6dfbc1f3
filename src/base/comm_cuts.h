/* comm_cuts.h: divides the plane into rectangles, one per rank, by recursive bisection. The outer
 * rectangles extend to infinity.
 *
 * Functions are collective only where their comment says so. For a single rank the whole plane is
 * one rectangle. An MPI job uses recursive coordinate bisection (RCB) of the library Zoltan, for
 * which no rank needs to know all points; ranks that are threads gather all points.
 */
#ifndef BASE_COMM_CUTS_H
#define BASE_COMM_CUTS_H

#include <stddef.h>

#include "base/comm.h"
#include "slipdisk/status.h"

typedef struct comm_cuts comm_cuts;

/* Creates a division in which every rank has the whole plane. Collective. Returns NULL if Zoltan
 * does not start; never NULL with one rank. */
comm_cuts *comm_cuts_new(const comm *c);
void comm_cuts_free(comm_cuts *cuts);
/* Returns the communicator of the ranks that the plane is divided among. */
const comm *comm_cuts_comm(const comm_cuts *cuts);
/* Recomputes the rectangles so that the points in each have about the same total weight.
 * Collective; each rank gives its own n points, at any positions. Returns SD_ERROR_IO, possibly on
 * some ranks only, if Zoltan failed or memory ran out. */
sd_status comm_cuts_make(comm_cuts *cuts, size_t n, const double *x, const double *y,
                         const float *weight);
/* Returns the rank whose rectangle contains the point; all ranks get the same answer. */
int comm_cuts_owner(const comm_cuts *cuts, double x, double y);
/* Writes the ranks whose rectangles overlap the box from `low` to `high`, each once, to
 * ranks[comm_size()]; returns their number. */
int comm_cuts_near(const comm_cuts *cuts, const double low[2], const double high[2], int *ranks);
/* Sets low and high to the corners of this rank's rectangle; sides at infinity are +-HUGE_VAL. */
void comm_cuts_mine(const comm_cuts *cuts, double low[2], double high[2]);

/* Recursive coordinate bisection by the library Zoltan, for comm_cuts.c only. Each function
 * zoltan_cuts_* implements comm_cuts_* for an MPI job. */

typedef struct zoltan_cuts zoltan_cuts;

zoltan_cuts *zoltan_cuts_new(void);
void zoltan_cuts_free(zoltan_cuts *cuts);
sd_status zoltan_cuts_make(zoltan_cuts *cuts, size_t n, const double *x, const double *y,
                           const float *weight);
int zoltan_cuts_owner(const zoltan_cuts *cuts, double x, double y);
int zoltan_cuts_near(const zoltan_cuts *cuts, const double low[2], const double high[2],
                     int *ranks);
/* Sets low and high to the corners of the rectangle of rank `rank`; sides at infinity are
 * +-HUGE_VAL. */
void zoltan_cuts_of(const zoltan_cuts *cuts, int rank, double low[2], double high[2]);

#endif
