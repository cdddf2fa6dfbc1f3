/* record_share.h: frames and tables of contacts of one rank, waiting in memory until they are sealed into its share of a part
 * (h5.h). */
#ifndef SLIPDISK_IO_RECORD_SHARE_H
#define SLIPDISK_IO_RECORD_SHARE_H

#include "io/results/checkpoint.h"
#include "io/results/record.h"

typedef struct record_share {
  const sd_model *model;
  table disks, contacts;
} record_share;

/* record_share_free also when it fails. */
void record_share_new(record_share *r, const sd_model *model);
void record_share_free(record_share *r);
/* Adds what the bits ask for: frame number `frame` of the part that is to be sealed, of the slots [0, n_free) and from `driven` to
 * n_disks, and contacts of moment `moment_number`, whose places are `order`. */
sd_status record_share_sample(record_share *r, unsigned what, const sd_state *state, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages);
/* Writes all rows and clears them, also when that fails; sum: of the seal. */
sd_status record_share_seal(record_share *r, const char *path, int64_t *sum, sd_messages *messages);
size_t record_share_bytes(const record_share *r);

#endif
