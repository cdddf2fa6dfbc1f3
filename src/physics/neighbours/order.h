/* order.h: free disks in slots such that disks that are near each other stand near each other in memory.
 *
 * Slots are part of the state, and sums run in their order: they change only at steps that model and state fix, at the
 * start and where a phase begins.
 */
#ifndef PHYSICS_ORDER_H
#define PHYSICS_ORDER_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Below so many free disks all fit into the cache in any order, and stay in the order of the deck. */
enum { ORDER_LEAST = 1000 };

/* Puts the free disks into the order of strips across the longer side of where they are, from the lower end of each strip to
 * the upper one; a periodic side is folded, so that its ends stand side by side. Disks that wait or were taken out
 * follow, in the order of the deck. The contacts in the state follow suit. SD_ERROR_IO: no memory. */
sd_status order_disks(const sd_model *model, sd_state *state);
/* Where a disk stands in this order: sizes ascend, and in them strips. */
typedef struct order_place {
  uint64_t strip; /* UINT64_MAX: not in play */
  double along;
  uint32_t id, slot; /* slot: where it stood */
  uint32_t level;    /* of size, the smallest first */
} order_place;
int order_by_place(const void *one, const void *two);
/* Puts the free disks of a part without contacts in this order, and says where they stand in that
 * of all parts: list[n_free]. c: the ranks of all parts, which call together; NULL: this part is
 * all. SD_ERROR_IO: no memory. */
sd_status order_part(const sd_model *model, sd_state *state, const comm *c, order_place *list);
/* The contacts in the state, however they stand, as the lists have them: the disk in the lower slot first, round ones
 * before those with pieces of straight walls, by slots. SD_ERROR_IO: no memory, nothing is changed. */
sd_status order_contacts(const sd_model *model, sd_state *state);

#endif
