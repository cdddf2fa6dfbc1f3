/* halo.h: one engine of a run over several processes (ranks), and its messages in a step.
 *
 * A rank owns some free disks. Disks of others that its own may touch are ghosts: slots [n_free, n_free + n_ghosts) of its
 * state, posed by messages as driven disks are by motions. Driven disks and walls are on every rank. A contact between
 * ranks is evaluated on both, with the same bits, since the law is even or odd under exchange of its bodies; so forces need no
 * way back. All that depends on an order goes by `order`, the slots that the disks have in the whole:
 *
 * - Forces and losses of a disk are summed by the order of its partners (rows.c).
 * - Forces on prescribed bodies are gathered from all ranks, and summed in that order on each.
 * - Events that change the reference of a contact with a ghost wait until the ranks have exchanged corrected poses.
 */
#ifndef PHYSICS_HALO_H
#define PHYSICS_HALO_H

#include "base/comm.h"
#include "physics/system/clumps.h"
#include "physics/system/work.h"

/* A packed body, and its acceleration. */
enum { HALO_ROW = PACKED_ROW + 2 };

/* A change of lambda_ref that waits: pair `index` is re-based, or body `index` was wrapped by `turn`, or by turns of the box: it
 * was at x, y, from where contacts are re-based. */
typedef struct halo_wait {
  uint32_t index, order;
  double turn, x, y;
} halo_wait;

typedef struct halo_waits {
  halo_wait *item;
  size_t count, capacity;
} halo_waits;

/* Of one prescribed body: its contacts on all ranks, in order. */
typedef struct halo_rows {
  size_t *start;      /* [n_prescribed + 1] */
  uint32_t *from;     /* places in `all` */
  double *mine, *all; /* [rows][SUM_ROW] */
  uint32_t *mine_at;  /* row of sums of each of mine */
  int *counts;        /* of the ranks */
  size_t n_mine;
} halo_rows;

struct halo {
  const comm *comm;
  double skin; /* of the lists, the same on all ranks */
  size_t n_own, n_ghosts;
  uint32_t
      *order; /* [n_own + n_ghosts] slots in the whole, of own disks and of ghosts each ascending */
  /* messages: rows of HALO_ROW numbers of own disks to ranks that have them as ghosts, and of ghosts */
  uint32_t *send_slot, *ghost_slot;
  size_t n_send;
  double *send, *receive;
  double *x2, *y2; /* [n_ghosts] as columns x2, y2 of the state */
  comm_links *links;
  bool *sent; /* [n_own] is a ghost elsewhere */
  halo_rows prescribed;
  halo_waits rebased, wrapped,
      shifted;   /* shifted: of this step, own disks before they went round the box */
  bool lost;     /* no memory for one of them */
  unsigned bits; /* HALO_STALE ... of this rank for the next halo_agree */
  double waited; /* seconds in messages, since it was last set to 0 */
};

/* After each step every rank knows whether any of them: has stale lists, has failed, is to stop, has changes that wait. */
enum { HALO_STALE = 1, HALO_FAILED = 2, HALO_STOP = 4, HALO_WAITS = 8 };

void halo_free(halo *h);
/* Places for the messages: to[r], from[r] rows to and from rank r; send_slot and ghost_slot are filled. SD_ERROR_IO: no memory. */
sd_status halo_connect(halo *h, const int *to, const int *from);
/* Is the disk in this slot free, here or on another rank? Without a halo the free disks are the first. */
static inline bool halo_is_free(const engine *e, size_t slot) {
  return slot < e->state->n_free + e->state->n_ghosts;
}
static inline bool halo_is_ghost(const engine *e, size_t slot) {
  return slot >= e->state->n_free && slot < e->state->n_free + e->state->n_ghosts;
}
/* Slot in the whole, without a halo the slot itself: of a free disk, and of the slots that follow
 * behind all of them. */
static inline uint64_t halo_order(const engine *e, size_t slot) {
  if (!e->halo) return slot;
  return halo_is_free(e, slot) ? e->halo->order[slot] : (uint64_t)UINT32_MAX + slot;
}
/* A contact that another rank counts, too: it belongs to the disk of the lower order. */
static inline bool halo_counts(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  return !e->halo || !halo_is_ghost(e, (size_t)p->b[k]) ||
         e->halo->order[p->a[k]] < e->halo->order[p->b[k]];
}
/* dt^2/2 times the acceleration of a disk here or on another rank; 0 of prescribed bodies and of padding. */
static inline double halo_second(const engine *e, int32_t slot, int c) {
  const sd_state *s = e->state;
  if (slot < 0 || !halo_is_free(e, (size_t)slot)) return 0.0;
  if (clumps_same(e, (size_t)slot, (size_t)slot)) return clump_second(e, (size_t)slot, c);
  if ((size_t)slot < s->n_free) return (c == SD_X ? s->x2 : s->y2)[slot];
  return (c == SD_X ? e->halo->x2 : e->halo->y2)[(size_t)slot - s->n_free];
}
sd_status halo_wait_for(halo_waits *list, halo_wait wait);

/* Collective, by one thread: */
/* Bits of all ranks. */
unsigned halo_agree(halo *h);
/* Sends packed rows of own disks, as the step has them now; halo_finish waits, and fills the ghosts' rows. In between
 * halo_progress, now and then, keeps long messages moving. */
void halo_start(engine *e);
void halo_progress(halo *h);
void halo_finish(engine *e);
/* Poses and velocities of own disks in the state to those of the ghosts, with their accelerations
 * when change is NULL. change: [n_ghosts] by how much their turn has changed, and where they were
 * before they went round the box; or NULL. */
void halo_refresh(engine *e, halo_wait *change);
/* After new lists: where rows of forces on prescribed bodies go. */
sd_status halo_list_prescribed(engine *e);
/* Brings their rows together; sums_add_listed then takes the sums. */
void halo_gather_prescribed(engine *e);
/* Sum of prescribed body k, after it. */
void halo_sum_prescribed(const halo *h, size_t k, double *sum);

#endif
