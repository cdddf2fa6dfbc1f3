/* record.h: keeps rows of output (time series, frames, contacts) in memory until they are written
 * to a part file of the result.
 *
 * In a run over several ranks a part consists of a main file, the head, which rank 0 writes, and
 * one share file per rank with the rows of the rank's own disks and contacts (h5.h).
 */
#ifndef SLIPDISK_IO_RECORD_H
#define SLIPDISK_IO_RECORD_H

#include "io/results/checkpoint.h"
#include "io/store/table.h"
#include "slipdisk/simulation.h"

/* Bits of the argument `what`, which select the tables to which rows are added. */
enum { RECORD_SERIES = 1, RECORD_FRAMES = 2, RECORD_CONTACTS = 4, RECORD_ALL = 7 };
/* RECORD_CONTACT_INDEX: index of contact_index in record.tables; RECORD_TABLES: number of tables */
enum { RECORD_CONTACT_INDEX = 3, RECORD_TABLES = 6 };

typedef enum record_kind {
  RECORD_WHOLE, /* holds all rows; in a run on one process */
  /* on rank 0: holds all rows except those of disks and contacts, which are in the records of the
   * ranks */
  RECORD_HEAD,
  /* on each rank: holds the rows of its own disks and contacts, each with a sort key */
  RECORD_SHARE
} record_kind;

typedef struct record {
  const sd_model *model;
  record_kind kind;
  /* tables of rows; a record of kind RECORD_SHARE uses only disks and contact_rows */
  table series, disks, walls, contact_index, contact_rows, clumps;
  table *tables[RECORD_TABLES]; /* pointers to the six tables above */
  resultants sums; /* work memory for forces and torques on groups; not used by kind RECORD_SHARE */
  /* in kind RECORD_HEAD: number of contacts of all ranks at the sampled time; set by the caller */
  size_t n_contacts;
} record;

/* Initialises the tables of a record, with columns but without rows. */
void record_new(record *r, const sd_model *model, record_kind kind);
void record_free(record *r);
/* Returns the memory that the rows of all tables take, in bytes. */
size_t record_bytes(const record *r);
/* Returns true if no table has a row. */
bool record_empty(const record *r);
/* Removes the rows of all tables; keeps their memory. */
void record_clear(record *r);

/* Quantities summed over all bodies, for a row of the time series. */
typedef struct record_sums {
  sd_energy energy;
  /* sums of other quantities than energies; NULL: they are computed from the state */
  const resultants *others;
} record_sums;

/* Adds rows for the time of `state` to the tables that the bits of `what` select (RECORD_SERIES
 * ...). Not for records of kind RECORD_SHARE. */
sd_status record_sample(record *r, unsigned what, const sd_state *state, const slot_table *slots,
                        const record_sums *sums, sd_messages *messages);
/* Adds rows to a record of kind RECORD_SHARE: frame number `frame` of the part, with the disks in
 * slots [0, n_free) and [driven, n_disks), and the contacts of contact table number
 * `moment_number`, in the order of `order`. what: bits that select frames and contacts, as in
 * record_sample. */
sd_status record_sample_share(record *r, unsigned what, const sd_state *state, size_t driven,
                              const slot_table *slots, const checkpoint_order *order, int64_t frame,
                              int64_t moment_number, sd_messages *messages);

/* Position of a part file in the chain of parts: each part stores its run, its number, and the
 * checksum at the end of the part before it. */
typedef struct record_link {
  const char *run_id;
  int64_t number; /* number of the part, counted from 1 */
  /* checksum at the end of the part file before this one; 0: this is the first part */
  uint64_t after;
} record_link;

/* Returns true if the record of rank 0 (head) has frames or contacts, so that the ranks must write
 * share files. */
bool record_has_shares(const record *head);
/* Moves the rows of the time series from the record of rank 0 (head) to r, which must be empty; the
 * head must have no frames or contacts. */
void record_take_series(record *r, record *head);
/* Writes all rows of a record that is not of kind RECORD_SHARE to a part file, and removes them
 * from memory on success. folder: descriptor of an open folder, see file.h. shares: checksums at
 * the ends of the n_shares share files of the ranks, which must be written before. sum: receives
 * the checksum at the end of the part file. */
sd_status record_seal(record *r, int folder, const char *path, const record_link *link,
                      size_t n_shares, const int64_t *shares, uint64_t *sum, sd_messages *messages);
/* Writes all rows of a record of kind RECORD_SHARE to the file `path`, and removes them from
 * memory, also on failure. sum: receives the checksum at the end of the file. */
sd_status record_seal_share(record *r, const char *path, int64_t *sum, sd_messages *messages);
/* Opens a part file and checks that it has this position in the chain of parts. sum: receives the
 * checksum at the end of the file. SD_ERROR_IO: the part is missing, damaged, or belongs to another
 * run. */
sd_status record_open(int folder, const char *path, const record_link *link, h5_file **out,
                      uint64_t *sum, sd_messages *messages);

#endif
