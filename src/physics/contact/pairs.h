/* pairs.h: candidate pairs, the record of closed contacts among them, and its way from one list to the next. */
#ifndef PHYSICS_PAIRS_H
#define PHYSICS_PAIRS_H

#include <assert.h>

#include "physics/system/work.h"

/* All return SD_ERROR_IO without memory. */
void pairs_free(pairs *p);
/* Capacity for so many; records are lost where it has to grow. */
sd_status pairs_reserve(pairs *p, size_t count);
enum { PAIR_PADDING = -1 }; /* a and b of what fills up a block */
/* A list is complete: what follows begins with a whole block. */
sd_status pairs_fill_block(pairs *p);
/* All are pushed: fills laws, and records with those of the same pairs in `from`, whose losses go along. */
sd_status pairs_finish(const engine *e, pairs *from, pairs *to);

/* --- closed or open ---------------------------------------------------------------------------------------- */

/* The first pair in [from, to), all of one list, whose disk a stands in this slot or a later one. */
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

static inline bool pairs_is_segment(const pairs *p, size_t k) { return k >= p->first_segment; }

/* Where the flags of pair k stand. */
static inline size_t pairs_flags_at(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? p->first_segment / PAIR_BLOCK + (k - p->first_segment)
                                : k / PAIR_BLOCK;
}
static inline unsigned pairs_flag_bit(const pairs *p, size_t k) {
  return pairs_is_segment(p, k) ? 1u : 1u << k % PAIR_BLOCK;
}

/* The pair touched in the last evaluation, and has a record. */
static inline bool pairs_closed(const pairs *p, size_t k) {
  return (p->flags[pairs_flags_at(p, k)].closed & pairs_flag_bit(p, k)) != 0;
}
/* +1, -1: sliding with that sign of torque on both disks; 0: stuck or open. */
static inline int pairs_slide_sign(const pairs *p, size_t k) {
  const pair_flags *flags = &p->flags[pairs_flags_at(p, k)];
  const unsigned bit = pairs_flag_bit(p, k);
  return ((flags->slides_positive & bit) != 0) - ((flags->slides_negative & bit) != 0);
}
void pairs_set_flags(pairs *p, size_t k, bool closed, int slide_sign);

/* --- record ---------------------------------------------------------------------------------------------- */

sd_contact_record pairs_record(const pairs *p, size_t k);
void pairs_set_record(pairs *p, size_t k, const sd_contact_record *record);

/* --- rare events ------------------------------------------------------------------------------------------ */

/* Disk or pair `index`; returns the new item to fill, NULL without memory, which the list remembers. */
event *event_add(event_list *list, uint32_t index);
/* A contact across the edge of a box that deforms. */
void crossing_add(crossing_list *list, const crossing *c);
/* Pair k. */
void event_add_pair(event_list *list, const pairs *p, size_t k, bool was_closed, double dropped);

#endif
