/* record.h: rows of series, frames and contacts, kept in memory until they are sealed into a part
 * of the result.
 *
 * Over ranks a part is a head, which rank 0 writes, and a share per rank with the rows of the
 * rank's own disks and contacts (h5.h). */
#ifndef SLIPDISK_IO_RECORD_H
#define SLIPDISK_IO_RECORD_H

#include "io/results/checkpoint.h"
#include "io/store/table.h"
#include "slipdisk/simulation.h"

enum { RECORD_SERIES = 1, RECORD_FRAMES = 2, RECORD_CONTACTS = 4, RECORD_ALL = 7 };
enum { RECORD_CONTACT_INDEX = 3, RECORD_TABLES = 6 }; /* indices into record.tables */

typedef enum record_kind {
  RECORD_WHOLE, /* all rows */
  RECORD_HEAD,  /* rows of disks and contacts are in the shares of the ranks */
  RECORD_SHARE  /* rows of disks and contacts of one rank, each with its key */
} record_kind;

typedef struct record {
  const sd_model *model;
  record_kind kind;
  table series, disks, walls, contact_index, contact_rows,
      clumps;                   /* a share: disks, contact_rows */
  table *tables[RECORD_TABLES]; /* pointers to these tables */
  resultants sums;              /* buffer for forces and torques on groups; a share has none */
  size_t n_contacts; /* head: contacts of all ranks at the sampled moment; set by the caller */
} record;

void record_new(record *r, const sd_model *model, record_kind kind);
void record_free(record *r);
size_t record_bytes(const record *r);
bool record_empty(const record *r);
void record_clear(record *r);

/* Sums over all bodies for a row of the series. */
typedef struct record_sums {
  sd_energy energy;
  const resultants *others; /* NULL: computed from the state */
} record_sums;

/* Adds rows for this moment to the tables that the bits of `what` select. Not for shares. */
sd_status record_sample(record *r, unsigned what, const sd_state *state, const slot_table *slots,
                        const record_sums *sums, sd_messages *messages);
/* Adds rows to a share: frame number `frame` of the part, for the slots [0, n_free) and
 * [driven, n_disks), and the contacts of moment number `moment_number`, sorted by `order`. */
sd_status record_sample_share(record *r, unsigned what, const sd_state *state, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages);

/* Parts form a chain: each stores its run, its number, and the seal's sum of the part before it. */
typedef struct record_link {
  const char *run_id;
  int64_t number; /* number of this part, counted from 1 */
  uint64_t after; /* sum of the part before; 0 for the first */
} record_link;

/* True if a head has frames or contacts, so that its part needs shares. */
bool record_has_shares(const record *head);
/* Moves the series of a head without shares to r, which is empty. */
void record_take_series(record *r, record *head);
/* Writes all rows of a record that is no share to a part, and clears them on success. folder: see
 * file.h; shares: sums of the seals of the n_shares shares, already written; sum: receives the sum
 * of the part's own seal. */
sd_status record_seal(record *r, int folder, const char *path, const record_link *link,
                      size_t n_shares, const int64_t *shares, uint64_t *sum, sd_messages *messages);
/* Writes all rows of a share to `path` and clears them, also on failure; sum: receives the sum of its
 * seal. */
sd_status record_seal_share(record *r, const char *path, int64_t *sum, sd_messages *messages);
/* Opens a part and checks that it is this link of the chain; sum as above. SD_ERROR_IO: the part is
 * missing, damaged, or belongs to another run. */
sd_status record_open(int folder, const char *path, const record_link *link, h5_file **out,
                      uint64_t *sum, sd_messages *messages);

#endif
