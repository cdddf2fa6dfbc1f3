/* bonds.h: bonds that are made and that break; their forces are in contact/law_bond.h. */
#ifndef PHYSICS_BONDS_H
#define PHYSICS_BONDS_H

#include "physics/system/work.h"

/* Bonds the bodies of candidate pair k, unless they are bonded or their law has no bonds. The pair
 * becomes a closed contact, also across a gap. The bond carries no force at the present
 * coordinates. */
void bonds_make(engine *e, size_t pair);
/* True if pair k is of a law with bonds, in play, and near enough for a bond (bond_gap). */
bool bonds_can(const engine *e, size_t pair);
/* Makes the bonds with which the present phase begins (key bond); *made: how many pairs
 * of those that are named are bonded then, on this rank. Collective. SD_ERROR_IO: no memory. */
sd_status bonds_begin_phase(engine *e, size_t *made);
/* Bonds pair k, a contact that began in this step, if the present phase says so (bond.sinter). */
sd_status bonds_sinter(engine *e, size_t pair);
/* Books the energy of the bond that broke in event v, and lists it in the state. SD_ERROR_IO: no
 * memory. */
sd_status bonds_broke(engine *e, const event *v);
/* Over ranks: makes the list of the bonds that broke in the last step complete on all ranks.
 * Collective. SD_ERROR_IO: no memory. */
sd_status bonds_gather(engine *e);
/* Sorts the bonds that broke in the last step by the numbers of their bodies. */
void bonds_sort(sd_state *state);

#endif
