/* record.h: keeps rows of series, frames and contacts in memory until they are sealed into a
 * part of the result.
 *
 * In a run over several ranks a part consists of a head, which rank 0 writes, and one share per
 * rank with the rows of the rank's own disks and contacts (h5.h). */
#ifndef SLIPDISK_IO_RECORD_H
#define SLIPDISK_IO_RECORD_H

#include "io/results/checkpoint.h"
#include "io/store/table.h"
#include "slipdisk/simulation.h"

/* Bits of `what`: tables to which a sample adds rows. */
enum { RECORD_SERIES = 1, RECORD_FRAMES = 2, RECORD_CONTACTS = 4, RECORD_ALL = 7 };
enum { RECORD_CONTACT_INDEX = 3, RECORD_TABLES = 6 }; /* indices into record.tables */

typedef enum record_kind {
  RECORD_WHOLE, /* holds all rows of a run in one process */
  /* rank 0: holds all rows except those of disks and contacts, which are in the shares */
  RECORD_HEAD,
  RECORD_SHARE /* one rank: holds the rows of its disks and contacts, each with its key */
} record_kind;

typedef struct record {
  const sd_model *model;
  record_kind kind;
  /* a share uses only disks and contact_rows */
  table series, disks, walls, contact_index, contact_rows, clumps;
  table *tables[RECORD_TABLES]; /* pointers to the tables above */
  resultants sums;              /* scratch for forces and torques on groups; a share has none */
  /* head: number of contacts of all ranks at the sampled moment; set by the caller */
  size_t n_contacts;
} record;

/* Initialises the tables of a record without rows. */
void record_new(record *r, const sd_model *model, record_kind kind);
void record_free(record *r);
/* Returns the memory taken by the rows of all tables. */
size_t record_bytes(const record *r);
/* Returns true if no table has a row. */
bool record_empty(const record *r);
/* Removes the rows of all tables; keeps their memory. */
void record_clear(record *r);

/* Sums over all bodies, for a row of the series. */
typedef struct record_sums {
  sd_energy energy;
  /* resultants besides the energies; NULL: they are computed from the state */
  const resultants *others;
} record_sums;

/* Adds rows for the time of `state` to the tables that the bits of `what` select (RECORD_SERIES
 * ...). Not for shares. */
sd_status record_sample(record *r, unsigned what, const sd_state *state, const slot_table *slots,
                        const record_sums *sums, sd_messages *messages);
/* Adds rows to a share: frame number `frame` of the part, for disks in the slots [0, n_free) and
 * [driven, n_disks), and the contacts of contact table number `moment_number`, in the order of
 * `order`. what: as in record_sample. */
sd_status record_sample_share(record *r, unsigned what, const sd_state *state, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages);

/* Position of a part in the chain of parts: each part stores its run, its number, and the checksum
 * in the seal of the part before it. */
typedef struct record_link {
  const char *run_id;
  int64_t number; /* number of the part, counted from 1 */
  uint64_t after; /* checksum in the seal of the part before; 0: first part */
} record_link;

/* Returns true if a head has frames or contacts, so that its part needs shares. */
bool record_has_shares(const record *head);
/* Moves the series of a head to r, which must be empty; the head must need no shares. */
void record_take_series(record *r, record *head);
/* Writes all rows of a record that is not a share to a part, and removes them from memory on
 * success. folder: see file.h. shares: checksums in the seals of the n_shares shares, which must be
 * written before. sum: receives the checksum in the part's own seal. */
sd_status record_seal(record *r, int folder, const char *path, const record_link *link,
                      size_t n_shares, const int64_t *shares, uint64_t *sum, sd_messages *messages);
/* Writes all rows of a share to `path` and removes them from memory, also on failure. sum: receives
 * the checksum in its seal. */
sd_status record_seal_share(record *r, const char *path, int64_t *sum, sd_messages *messages);
/* Opens a part and checks that it is this link of the chain. sum: receives the checksum in its
 * seal. SD_ERROR_IO: the part is missing, damaged, or belongs to another run. */
sd_status record_open(int folder, const char *path, const record_link *link, h5_file **out,
                      uint64_t *sum, sd_messages *messages);

#endif
