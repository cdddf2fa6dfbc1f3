/* halo.h: one engine of a run over several processes (ranks), and its messages in a step.
 *
 * A rank owns some of the free disks. Disks of other ranks that its own disks may touch are ghosts:
 * they have slots [n_free, n_free + n_ghosts) in its state, and their poses come by messages.
 * Driven disks and walls are on every rank. A contact between disks of two ranks is evaluated on
 * both; both get the same bits, since the law is even or odd under exchange of the bodies, so
 * forces are not sent back.
 *
 * Sums and sorted lists use the global order of disks, which is the order of their slots in a run
 * on one rank (member `order`):
 *
 * - Forces and losses of a disk are summed in the global order of the disks that touch it (rows.c).
 * - Forces on prescribed bodies are gathered from all ranks, and each rank sums them in that order.
 * - Events that change the reference of a contact with a ghost wait until the ranks have exchanged
 *   corrected poses.
 */
#ifndef PHYSICS_HALO_H
#define PHYSICS_HALO_H

#include "base/comm.h"
#include "physics/system/clumps.h"
#include "physics/system/work.h"

/* Number of doubles in a message row: a packed body, and dt^2/2 times its acceleration (x2, y2). */
enum { HALO_ROW = PACKED_ROW + 2 };

/* Postponed change of lambda_ref (reference value of lambda) in contacts with ghosts. There are
 * three kinds: pair `index` gets a new reference direction; the angle theta of body `index` was
 * wrapped by `turn`; body `index` was wrapped around the box from position (x, y), at which
 * postponed reference directions are still to be computed. order: slot in the global order. */
typedef struct halo_wait {
  uint32_t index, order;
  double turn, x, y;
  bool bonds; /* `index` is a contact that becomes bonded, in place of a new reference direction */
} halo_wait;

typedef struct halo_waits {
  halo_wait *item;
  size_t count, capacity;
} halo_waits;

/* Contact forces on prescribed bodies, one row per contact: those of this rank (mine) and those of
 * all ranks (all). */
typedef struct halo_rows {
  size_t *start; /* [n_prescribed + 1] first entry of each prescribed body in `from` */
  /* row numbers in `all`: the contacts of the first body in their global order, then those of the
   * next */
  uint32_t *from;
  /* [rows][SUM_ROW] contact forces: of this rank's contacts, of those of all ranks */
  double *mine, *all;
  uint32_t *mine_at; /* [n_mine] row of work.sums from which each row of `mine` is copied */
  int *counts;       /* [ranks] number of contacts (rows) of each rank */
  size_t n_mine;     /* number of contacts (rows) of this rank */
} halo_rows;

struct halo {
  const comm *comm;
  double skin;            /* Verlet margin of the neighbour lists, the same on all ranks */
  size_t n_own, n_ghosts; /* number of free disks of this rank, and of its ghosts */
  /* [n_own + n_ghosts] slot of each disk in the global order; ascending among the own disks, and
   * again among the ghosts */
  uint32_t *order;
  /* slot of the disk in each row of `send`, and in each row of `receive` */
  uint32_t *send_slot, *ghost_slot;
  size_t n_send;
  /* Messages, [rows][HALO_ROW]: `send` has own disks that are ghosts of other ranks, `receive` the
   * ghosts of this rank. */
  double *send, *receive;
  /* [n_ghosts] dt^2/2 times the acceleration, like columns x2 and y2 of the state */
  double *x2, *y2;
  comm_links *links;
  bool *sent; /* [n_own] true for own disks that are ghosts of another rank */
  halo_rows prescribed;
  /* Postponed changes: pairs with a new reference direction (rebased), angles that were wrapped
   * (wrapped), positions of own disks before they were wrapped around the box in this step
   * (shifted). */
  halo_waits rebased, wrapped, shifted;
  bool lost;      /* true: memory ran out, and a postponed change was lost */
  size_t n_broke; /* last rows of the list of broken bonds, which other ranks do not know yet */
  unsigned bits;  /* bits (HALO_STALE ...) that this rank contributes to the next halo_agree */
  double waited;  /* seconds spent waiting for messages since this member was last set to 0 */
};

/* Bits that are combined over all ranks after each step. They mean that some rank has a stale
 * neighbour list, has failed, asks to stop, or has postponed changes. */
enum { HALO_STALE = 1, HALO_FAILED = 2, HALO_STOP = 4, HALO_WAITS = 8, HALO_BROKE = 16 };

void halo_free(halo *h);
/* Allocates the messages and connects the ranks. to[r], from[r]: numbers of rows sent to and
 * received from rank r. send_slot and ghost_slot must be filled in before. SD_ERROR_IO: no
 * memory. */
sd_status halo_connect(halo *h, const int *to, const int *from);
/* True if the slot holds a free disk that this rank owns, or a ghost. */
static inline bool halo_is_free(const engine *e, size_t slot) {
  return slot < e->state->n_free + e->state->n_ghosts;
}
/* True if the slot holds a ghost (copy of a disk that another rank owns). */
static inline bool halo_is_ghost(const engine *e, size_t slot) {
  return slot >= e->state->n_free && slot < e->state->n_free + e->state->n_ghosts;
}
/* Returns the sort key of a slot in the global order: for a free disk or ghost its slot in a run on
 * one rank, for other bodies a number above all of these. Without other ranks it is the slot
 * itself. */
static inline uint64_t halo_order(const engine *e, size_t slot) {
  if (!e->halo) return slot;
  return halo_is_free(e, slot) ? e->halo->order[slot] : (uint64_t)UINT32_MAX + slot;
}
/* True if contact k is counted on this rank. A contact with a ghost is listed by two ranks; only
 * the rank that owns the disk that comes first in the global order counts it. */
static inline bool halo_counts(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  return !e->halo || !halo_is_ghost(e, (size_t)p->b[k]) ||
         e->halo->order[p->a[k]] < e->halo->order[p->b[k]];
}
/* Returns dt^2/2 times the acceleration of a free disk or a ghost along coordinate c (SD_X or
 * SD_Y); 0 for prescribed bodies and padding (slot -1). */
static inline double halo_second(const engine *e, int32_t slot, int c) {
  const sd_state *s = e->state;
  if (slot < 0 || !halo_is_free(e, (size_t)slot)) return 0.0;
  if (clumps_same(e, (size_t)slot, (size_t)slot)) return clump_second(e, (size_t)slot, c);
  if ((size_t)slot < s->n_free) return (c == SD_X ? s->x2 : s->y2)[slot];
  return (c == SD_X ? e->halo->x2 : e->halo->y2)[(size_t)slot - s->n_free];
}
/* Appends a postponed change of contact references to a list. SD_ERROR_IO: no memory. */
sd_status halo_wait_for(halo_waits *list, halo_wait wait);

/* The functions below are called by one thread of each rank. All are collective except
 * halo_progress and halo_sum_prescribed. */

/* Returns the bitwise or of the member `bits` over all ranks, and sets `bits` to 0. */
unsigned halo_agree(halo *h);
/* halo_start sends the packed bodies of own disks as they are now. halo_progress, called while
 * other work is done, keeps long messages moving. halo_finish waits for the packed bodies of the
 * ghosts and stores them. */
void halo_start(engine *e);
void halo_progress(halo *h);
void halo_finish(engine *e);
/* Updates poses and velocities of the ghosts in the state from the ranks that own them. change:
 * NULL, then accelerations are updated, too; or [n_ghosts], which receives the change of each
 * ghost's turn (angle removed by wrapping) and its position before it was wrapped around the
 * box. */
void halo_refresh(engine *e, halo_wait *change);
/* Prepares the member `prescribed` (forces on prescribed bodies) for a new neighbour list.
 * SD_ERROR_IO: no memory. */
sd_status halo_list_prescribed(engine *e);
/* Gathers the contact forces on prescribed bodies, one row per contact, from all ranks on every
 * rank; sums_add_listed then uses the sums. */
void halo_gather_prescribed(engine *e);
/* Sets `sum` [SUM_ROW] to the contact force on prescribed body k, counted from the first prescribed
 * one; to be called after halo_gather_prescribed. */
void halo_sum_prescribed(const halo *h, size_t k, double *sum);

#endif
