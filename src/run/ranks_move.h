/* ranks_move.h: disks and contacts on their way between the ranks of one run; see ranks.h. All functions are collective. */
#ifndef SLIPDISK_RUN_RANKS_MOVE_H
#define SLIPDISK_RUN_RANKS_MOVE_H

#include "base/comm_cuts.h"
#include "physics/system/halo.h"
#include "physics/system/work.h"

/* Cuts the plane for disks that rank 0 has all of, or each rank some (from: as of move_parts): points of equal weight, but for disks
 * that are not in play. SD_ERROR_IO: no memory, on any rank. */
sd_status move_first_cut(const sd_model *model, comm_cuts *cuts, const engine *from);
/* Anew, for parts: work per disk is contacts and the rest, in proportion to the seconds that its rank was busy with them, within a factor
 * of the mean. */
sd_status move_cut_again(comm_cuts *cuts, const engine *part, double busy);
/* Makes state and halo of this rank's part of the disks, by the rectangles of `cuts`: from the part that it has (from: an engine with a
 * halo, contacts and motions stored, poses of ghosts refreshed), or from all disks, which rank 0 has (from: an engine without
 * one; NULL on the other ranks). skin: of the lists to come. SD_ERROR_IO: no memory, on any rank. */
sd_status move_parts(const sd_model *model, const comm_cuts *cuts, const engine *from, double skin,
                     sd_state **state, halo **h);

/* Brings the parts of all ranks into the whole state of rank 0 (NULL on the others), contacts in their order. SD_ERROR_IO: no
 * memory. */
sd_status move_together(const engine *part, sd_state *whole);
/* Gives a part what is no disk's and no contact's: prescribed bodies, motions, and what is of the run, from what this rank has, or
 * (whole) from rank 0. Without memory the job ends. */
sd_status move_take_common(const comm *c, const engine *from, bool whole, sd_state *to);
/* Brings the same into the whole state of rank 0 (NULL on the others). */
void move_common(const engine *part, sd_state *whole);

#endif
