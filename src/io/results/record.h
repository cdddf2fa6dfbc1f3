/* record.h: all that a run writes besides checkpoints, waiting in memory until it is sealed into a part. */
#ifndef SLIPDISK_IO_RECORD_H
#define SLIPDISK_IO_RECORD_H

#include "io/store/table.h"
#include "slipdisk/simulation.h"

enum { RECORD_SERIES = 1, RECORD_FRAMES = 2, RECORD_CONTACTS = 4, RECORD_ALL = 7 };
enum { RECORD_CONTACT_INDEX = 3, RECORD_TABLES = 6 }; /* places in record.tables */

typedef struct record {
  const sd_model *model;
  table series, disks, walls, contact_index, contact_rows, clumps;
  table *tables[RECORD_TABLES]; /* the above */
  resultants sums;              /* scratch */
  bool shared;                  /* frames and contacts stand in shares (record_share.h) ... */
  size_t n_contacts;            /* ... and so many contacts in the last of these */
} record;

void record_new(record *r, const sd_model *model, bool shared);
void record_free(record *r);
/* Sums of a row of the series. */
typedef struct record_sums {
  sd_energy energy;
  const resultants *others; /* NULL: they are taken from the state */
} record_sums;
/* Adds what the bits ask for, of this moment; sums: for a row of the series. */
sd_status record_sample(record *r, unsigned what, const sd_state *state, const slot_table *slots,
                        const record_sums *sums, sd_messages *messages);
size_t record_bytes(const record *r);
bool record_empty(const record *r);
void record_clear(record *r);
/* Parts are a chain: each names its run, its place, and the sum in the seal of the one before. */
typedef struct record_link {
  const char *run_id;
  int64_t number; /* of this part, from 1 on */
  uint64_t after; /* sum of the part before; 0: it is the first */
} record_link;

/* Has a shared record rows of disks or of contacts? Without them it needs no shares: r, which is empty, takes its series over. */
bool record_has_shares(const record *shared);
void record_take_series(record *r, record *shared);
/* Writes all rows to a part, and clears them when that has succeeded; sum: that of its seal. folder: see file.h. The n_shares of
 * a shared one are there already; their sums, see h5.h. */
sd_status record_seal(record *r, int folder, const char *path, const record_link *link,
                      size_t n_shares, const int64_t *shares, uint64_t *sum, sd_messages *messages);
/* Opens a part and makes sure that it is this link of the chain; sum as above. SD_ERROR_IO: it is missing, damaged, or
 * of another run. */
sd_status record_open(int folder, const char *path, const record_link *link, h5_file **out,
                      uint64_t *sum, sd_messages *messages);

#endif
