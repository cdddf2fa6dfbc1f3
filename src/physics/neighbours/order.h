/* order.h: assigns slots to the free disks so that disks near each other in space are near each
 * other in memory.
 *
 * Slots are part of the state, and sums run in their order. So they change only at steps that model
 * and state determine: at the start, and where a phase begins.
 */
#ifndef PHYSICS_ORDER_H
#define PHYSICS_ORDER_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Least number of free disks that are sorted. Fewer fit into the cache in any order, and stay in
 * the order of the deck. */
enum { ORDER_LEAST = 1000 };

/* Sorts the free disks by strips across the longer side of their bounding box, and within a strip
 * by the coordinate along it. A periodic side is folded, so that strips at its two ends are
 * neighbours in memory. Disks that wait or were taken out come last, in the order of the deck. The
 * contacts in the state are sorted accordingly. Returns SD_ERROR_IO if memory runs out. */
sd_status order_disks(const sd_model *model, sd_state *state);
/* Sort key of a disk: disks in play first, then by level of size, strip, and coordinate along the
 * strip. */
typedef struct order_place {
  uint64_t strip; /* number of the strip; UINT64_MAX: the disk waits or was taken out */
  double along;
  uint32_t id, slot; /* body number, and the slot before sorting */
  uint32_t level;    /* level of size, the smallest disks first */
} order_place;
int order_by_place(const void *one, const void *two);
/* Sorts the free disks of one rank, without contacts, and returns their keys in list[n_free], by
 * which all ranks together can be sorted. c: all ranks, in a collective call; NULL: there is only
 * this one. Returns SD_ERROR_IO if memory runs out. */
sd_status order_part(const sd_model *model, sd_state *state, const comm *c, order_place *list);
/* Sorts the contacts in the state, whatever their order, as the lists of pairs are: the disk in the
 * lower slot is a, round contacts come before those with wall segments, each sorted by slots.
 * Returns SD_ERROR_IO, with nothing changed, if memory runs out. */
sd_status order_contacts(const sd_model *model, sd_state *state);

#endif
