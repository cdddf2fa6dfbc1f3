/* ranks_move.h: disks and contacts on their way between the ranks of one run; see ranks.h. All functions are collective. */
#ifndef SLIPDISK_RUN_RANKS_MOVE_H
#define SLIPDISK_RUN_RANKS_MOVE_H

#include "base/comm.h"
#include "base/comm_cuts.h"
#include "model/model.h"
#include "model/state.h"
#include "physics/system/halo.h"
#include "physics/system/work.h"

/* Cuts the plane for the disks of all ranks: points of equal weight, but for disks that are not in
 * play. SD_ERROR_IO: no memory, on any rank. */
sd_status move_first_cut(comm_cuts *cuts, const sd_state *mine);
/* Anew, for parts: work per disk is contacts and the rest, in proportion to the seconds that its rank was busy with them, within a factor
 * of the mean. */
sd_status move_cut_again(comm_cuts *cuts, const engine *part, double busy);
/* Makes state and halo of this rank's part of the disks, by the rectangles of `cuts`, from what it
 * has: an engine with a halo, contacts and motions stored, poses of ghosts refreshed; or (first)
 * with model, state and the order of its disks alone, which lie anywhere, as do its contacts.
 * skin: of the lists to come. SD_ERROR_IO: no memory, on any rank. */
sd_status move_parts(const comm_cuts *cuts, const engine *from, bool first, double skin,
                     sd_state **state, halo **h);

/* --- the order that all disks have in the whole, when each rank has some ---------------------- */

/* Collective. Puts the free disks of this rank into the order of order_disks; order[n_free]: their slots in the whole, which ascend. Contacts
 * stay as they are. Places are sorted where they are and sent to ranks that number them, strip by strip; the numbers come back.
 * Without memory the job ends. */
sd_status ranks_order(const comm *c, const sd_model *model, sd_state *part, uint32_t *order);

#endif
