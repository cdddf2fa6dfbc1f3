/* ranks_move.h: moves disks and contacts between the ranks of one run; see ranks.h. All
 * functions are collective. */
#ifndef SLIPDISK_RUN_RANKS_MOVE_H
#define SLIPDISK_RUN_RANKS_MOVE_H

#include "base/comm.h"
#include "base/comm_cuts.h"
#include "model/model.h"
#include "model/state.h"
#include "physics/system/halo.h"
#include "physics/system/work.h"

/* Cuts the plane into one rectangle per rank. All disks have equal weight, except those that are
 * not in play. SD_ERROR_IO: a rank is out of memory. */
sd_status move_first_cut(comm_cuts *cuts, const sd_state *mine);
/* Cuts the plane again. The weight of a disk is its number of contacts plus a constant, in
 * proportion to the seconds that its rank was busy with them, within a factor of the mean. */
sd_status move_cut_again(comm_cuts *cuts, const engine *part, double busy);
/* Makes the state and halo of this rank's domain, by the rectangles of `cuts`. from: an engine with
 * a halo, with contacts and motions stored and poses of ghosts refreshed; or (first) an engine with
 * only model, state and order of its disks, which may be anywhere, like its contacts. skin: Verlet
 * margin of the next lists. SD_ERROR_IO: a rank is out of memory. */
sd_status move_parts(const comm_cuts *cuts, const engine *from, bool first, double skin,
                     sd_state **state, halo **h);

/* --- Order of all disks when each rank has some of them --------------------------------------- */

/* Collective: sorts the free disks of this rank into the order of order_disks. order[n_free]:
 * receives their slots in the order of all disks, ascending. Contacts are not changed. Each rank
 * sorts its disks and sends their sort keys, strip by strip, to ranks that number them and send the
 * numbers back. A rank without memory ends the job. */
sd_status ranks_order(const comm *c, const sd_model *model, sd_state *part, uint32_t *order);

#endif
