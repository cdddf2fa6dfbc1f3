/* pairs.h: the list of candidate pairs, the records of the closed contacts in it, and how records
 * are moved from one list to the next. */
#ifndef PHYSICS_PAIRS_H
#define PHYSICS_PAIRS_H

#include <assert.h>

#include "physics/system/work.h"

/* Frees all columns. Of the functions below, those that return a status return SD_ERROR_IO if
 * memory runs out. */
void pairs_free(pairs *p);
/* Enlarges the columns, if needed, so that `count` pairs fit in. Records and flags are lost when
 * this happens. */
sd_status pairs_reserve(pairs *p, size_t count);
/* value of a and b for padding, entries without bodies that fill up a block of pairs */
enum { PAIR_PADDING = -1 };
/* Appends padding up to the end of the block, so that the next list begins with a new block. */
sd_status pairs_fill_block(pairs *p);
/* Completes list `to`, into which all pairs have been entered: sets the law of each pair, and
 * copies the record of each contact that is closed in `from`. The losses in such a record are set
 * to 0 in `from`. */
sd_status pairs_finish(const engine *e, pairs *from, pairs *to);

/* --- closed or open --------------------------------------------------------------------------- */

/* Returns the first pair with index in [from, to) whose disk a is in `slot` or a later slot; `to`
 * if there is none. The range must lie in one of the lists (round bodies, ghosts, wall
 * segments). */
static inline size_t pairs_from(const pairs *p, size_t from, size_t to, size_t slot) {
  while (from < to) {
    const size_t middle = from + (to - from) / 2;
    if (p->a[middle] < (int32_t)slot)
      from = middle + 1;
    else
      to = middle;
  }
  return from;
}

/* Returns true if pair k is a disk and a wall segment, false if both bodies are round. */
static inline bool pairs_is_segment(const pairs *p, size_t k) { return k >= p->first_segment; }

/* pairs_flags_at returns the index in p->flags of the entry with the flags of pair k,
 * pairs_flag_bit the bit of pair k in this entry. */
static inline size_t pairs_flags_at(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? p->first_segment / PAIR_BLOCK + (k - p->first_segment)
                                : k / PAIR_BLOCK;
}
static inline unsigned pairs_flag_bit(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? 1u : 1u << k % PAIR_BLOCK;
}

/* Returns true if pair k was in contact when it was last evaluated; it then has a contact
 * record. */
static inline bool pairs_closed(const pairs *p, size_t k) {
  return (p->flags[pairs_flags_at(p, k)].closed & pairs_flag_bit(p, k)) != 0;
}
/* Returns the sign (+1 or -1) of the torque on both disks if contact k slides; 0 if it is stuck or
 * open. */
static inline int pairs_slide_sign(const pairs *p, size_t k) {
  const pair_flags *flags = &p->flags[pairs_flags_at(p, k)];
  const unsigned bit = pairs_flag_bit(p, k);
  return ((flags->slides_positive & bit) != 0) - ((flags->slides_negative & bit) != 0);
}
/* Sets the flags of pair k. closed: true if it is in contact; slide_sign: see pairs_slide_sign,
 * must be 0 if the pair is open. */
void pairs_set_flags(pairs *p, size_t k, bool closed, int slide_sign);

/* --- record ----------------------------------------------------------------------------------- */

/* pairs_record returns the record of pair k, pairs_set_record replaces it. If p->more is NULL, the
 * columns of SD_CONTACT_MORE read as 0 and are not written. */
sd_contact_record pairs_record(const pairs *p, size_t k);
void pairs_set_record(pairs *p, size_t k, const sd_contact_record *record);

/* Adds the length `by` to the values from which tangential (pairs_shift_lambda) or rolling
 * displacements (pairs_shift_rho) of closed pair k are measured, those of a bond included. */
static inline void pairs_shift_lambda(pairs *p, size_t k, double by) {
  PAIR(p, k, lambda_ref) += by;
  if (p->more && MORE(p, k, bond) > 0.0) MORE(p, k, bond_lambda) += by;
}
static inline void pairs_shift_rho(pairs *p, size_t k, double by) {
  MORE(p, k, rho_ref) += by;
  if (MORE(p, k, bond) > 0.0) MORE(p, k, bond_rho) += by;
}

/* --- rare events ------------------------------------------------------------------------------ */

/* Appends an event. index: a pair, or the slot of a disk. Returns the new item, which the caller
 * fills; if memory runs out, returns NULL and sets list->failed. */
event *event_add(event_list *list, uint32_t index);
/* Appends a contact that crosses the edge of a deforming box. Sets list->failed if memory runs
 * out. */
void crossing_add(crossing_list *list, const crossing *c);
/* Appends event `v` for pair k, with its index. */
void event_add_pair(event_list *list, const pairs *p, size_t k, const event *v);

#endif
