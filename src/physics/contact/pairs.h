/* pairs.h: the list of candidate pairs, the records of the closed contacts in it, and how records
 * are carried over from one list to the next. */
#ifndef PHYSICS_PAIRS_H
#define PHYSICS_PAIRS_H

#include <assert.h>

#include "physics/system/work.h"

/* Frees all columns. The functions below that return a status return SD_ERROR_IO when there is no
 * memory. */
void pairs_free(pairs *p);
/* Makes room for `count` pairs. Records and flags are lost when the columns have to grow. */
sd_status pairs_reserve(pairs *p, size_t count);
enum { PAIR_PADDING = -1 }; /* slots a and b of a padding pair, which fills up a block */
/* Appends padding up to the end of the block, so that the next list begins with a whole block. */
sd_status pairs_fill_block(pairs *p);
/* Completes list `to`, in which all pairs have been entered: sets the law of each pair, and copies
 * the record of each contact that is closed in `from`. Its losses move along: they are 0 in `from`
 * afterwards. */
sd_status pairs_finish(const engine *e, pairs *from, pairs *to);

/* --- closed or open --------------------------------------------------------------------------- */

/* Returns the first pair in [from, to) whose disk a is in `slot` or a later slot; `to` if there is
 * none. The range must lie in one list. */
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

/* True if pair k is a disk and a wall segment, false if both bodies are round. */
static inline bool pairs_is_segment(const pairs *p, size_t k) { return k >= p->first_segment; }

/* Index in p->flags of the entry with the flags of pair k, and the bit of pair k in it. */
static inline size_t pairs_flags_at(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? p->first_segment / PAIR_BLOCK + (k - p->first_segment)
                                : k / PAIR_BLOCK;
}
static inline unsigned pairs_flag_bit(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? 1u : 1u << k % PAIR_BLOCK;
}

/* True if pair k was in contact at the last evaluation; it then has a record. */
static inline bool pairs_closed(const pairs *p, size_t k) {
  return (p->flags[pairs_flags_at(p, k)].closed & pairs_flag_bit(p, k)) != 0;
}
/* Returns the sign (+1 or -1) of the torque on both disks while contact k slides; 0: stuck or
 * open. */
static inline int pairs_slide_sign(const pairs *p, size_t k) {
  const pair_flags *flags = &p->flags[pairs_flags_at(p, k)];
  const unsigned bit = pairs_flag_bit(p, k);
  return ((flags->slides_positive & bit) != 0) - ((flags->slides_negative & bit) != 0);
}
/* Sets the flags of pair k; slide_sign must be 0 if the contact is not closed. */
void pairs_set_flags(pairs *p, size_t k, bool closed, int slide_sign);

/* --- record ----------------------------------------------------------------------------------- */

/* Reads and writes the record of pair k; without p->more the columns of SD_CONTACT_MORE read as 0
 * and are not written. */
sd_contact_record pairs_record(const pairs *p, size_t k);
void pairs_set_record(pairs *p, size_t k, const sd_contact_record *record);

/* --- rare events ------------------------------------------------------------------------------ */

/* Appends an event for a pair or a disk's slot `index`. Returns the new item for the caller to
 * fill; NULL if there is no memory, and then sets list->failed. */
event *event_add(event_list *list, uint32_t index);
/* Appends a contact that crosses the edge of a deforming box; sets list->failed without memory. */
void crossing_add(crossing_list *list, const crossing *c);
/* Appends an event for pair k. was_closed: before the pass; dropped: energy to book
 * (event.dropped). */
void event_add_pair(event_list *list, const pairs *p, size_t k, bool was_closed, double dropped);

#endif
