/* ranks_move.h: moves disks and contacts between the ranks of one simulation; see ranks.h. All
 * functions are collective. */
#ifndef SLIPDISK_RUN_RANKS_MOVE_H
#define SLIPDISK_RUN_RANKS_MOVE_H

#include "base/comm.h"
#include "base/comm_cuts.h"
#include "slipdisk/model.h"
#include "model/state.h"
#include "physics/system/halo.h"
#include "physics/system/work.h"

/* Cuts the plane into one rectangle per rank, each with about the same number of disks that are in
 * play. SD_ERROR_IO: a rank is out of memory. */
sd_status move_first_cut(comm_cuts *cuts, const sd_state *mine);
/* Cuts the plane again, into rectangles with about the same work. The weight of a disk is its
 * number of contacts plus a constant, times the seconds that its rank was busy per such unit, which
 * are limited to within a factor of the mean. */
sd_status move_cut_again(comm_cuts *cuts, const engine *part, double busy);
/* Makes the state and halo of this rank's domain, that is, of its rectangle in `cuts`. from: engine
 * with the data before the move. first false: it has a halo, contacts and motions are stored, and
 * poses of ghosts are up to date; true: it has only model, state and order of its disks, and these
 * and its contacts may be anywhere. skin: Verlet margin of the next lists. SD_ERROR_IO: a rank is
 * out of memory. */
sd_status move_parts(const comm_cuts *cuts, const engine *from, bool first, double skin,
                     sd_state **state, halo **h);

/* --- Order of all disks when each rank has some of them --------------------------------------- */

/* Collective: sorts the free disks of this rank in the way of order_disks. order[n_free]: receives
 * their slots in the sorted order of the disks of all ranks, ascending. Contacts are not changed.
 * Each rank sorts its disks and sends their sort keys, by strips of the plane, to ranks that number
 * them and send the numbers back. A rank without memory ends the job. */
sd_status ranks_order(const comm *c, const sd_model *model, sd_state *part, uint32_t *order);

#endif
