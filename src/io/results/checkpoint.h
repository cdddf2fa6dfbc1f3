/* checkpoint.h: the state, and all that is needed to go on from it, in one file.
 *
 * /state holds one dataset per row of sd_fields, with unit and description; /checkpoint the number of sealed
 * parts that belong to it and the hash of the state; /parameters the deck and where the run comes from;
 * /summary what has been measured so far. A finished result has the same groups.
 */
#ifndef SLIPDISK_IO_CHECKPOINT_H
#define SLIPDISK_IO_CHECKPOINT_H

#include "io/results/constants.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"

/* Raised when a name or a meaning changes, or a column is new; a run goes on from its own format only. 3: contacts stand by slots, and
 * not by the number of the partner; 4: columns fast_*; 5: columns of contacts named as in slipdisk/contact.h, history of the
 * evaluation whose forces act, names of results as in io/store/members.c; 6: field_power; 7: visit_*. A packing takes bodies and contacts in any order, and
 * no fast_*, so that it reads 2 and 3 as well. */
enum { CHECKPOINT_FORMAT = 9, CHECKPOINT_OF_PACKING = 2 };
/* Name below /state of a column of sd_fields in the file's format. */
const char *checkpoint_column(const h5_file *file, const char *name);

/* Parts that belong to a state, without which a run cannot go on from it. */
typedef struct checkpoint_parts {
  int64_t n;     /* sealed parts */
  uint64_t last; /* sum in the seal of the last one; each part names that of the one before */
  const char *replaces; /* which result may be replaced in the end, see session_begin.c; "": none */
} checkpoint_parts;

/* Free disks and contacts stand in files of the ranks (shares, see h5.h), which are there already. */
typedef struct checkpoint_shares {
  const sd_model *model;
  size_t n;
  int64_t *sums;     /* [n] of their seals */
  size_t n_contacts; /* of all */
} checkpoint_shares;

/* folder: see file.h. shares: NULL: the state has all. */
sd_status checkpoint_write(int folder, const char *path, const sd_state *state,
                           const checkpoint_parts *parts, const checkpoint_shares *shares,
                           const provenance *origin, const summary *found, sd_messages *messages);

/* Where the rows of a part of the state stand in the whole: by ascending keys. */
typedef struct checkpoint_order {
  int64_t *disk_key;    /* [n_free] */
  int64_t *contact_key; /* [n_contacts] */
  uint32_t *
      contact; /* [n_contacts] which contact of the part has this key; those of one key in their order */
} checkpoint_order;

/* Share k of a checkpoint that is not written after all; folder: see file.h. */
void checkpoint_remove_share(int folder, const char *path, size_t k);
/* A share: the free disks and contacts of a part of the state. sum: of its seal. */
sd_status checkpoint_write_share(const char *path, const sd_state *state,
                                 const checkpoint_order *order, int64_t *sum,
                                 sd_messages *messages);

/* The group /state of a file that is being written; of one that borrows the state must stay as it is until it is saved. */
void checkpoint_put_state(h5_file *file, const sd_state *state);
/* The same from a checkpoint, column by column, as it stands there: no state is needed. */
sd_status checkpoint_copy_state(h5_file *file, const h5_file *checkpoint, sd_messages *messages);
uint64_t checkpoint_stored_bytes(const h5_file *checkpoint); /* of all its columns */
/* The state in an open file, sized for the model; verified against its hash. SD_ERROR_USER: it belongs to
 * another model. */
sd_status checkpoint_get_state(const h5_file *file, const sd_model *model, sd_state **out,
                               sd_messages *messages);
/* SD_ERROR_USER: the state in an open file belongs to another model; SD_ERROR_IO: it is damaged. */
sd_status checkpoint_check_state(const h5_file *file, const sd_model *model, sd_messages *messages);
/* The rows of one of several ranks that go on with a checkpoint, as a state of its own: of
 * prescribed bodies and the run all, of free disks and contacts the shares rank, rank + ranks
 * ..., or of a file without shares as many rows. order[n_free]: places of the disks in the whole,
 * ascending. Seals are checked. */
sd_status checkpoint_get_some(const char *path, const sd_model *model, size_t rank, size_t ranks,
                              sd_state **out, uint32_t **order, sd_messages *messages);
/* Means of every disk (summary_disks_collect) from the state in a file, of which some disks are
 * read at a time. */
sd_status checkpoint_collect_disks(const h5_file *file, const sd_model *model, summary_disks *s,
                                   int threads, sd_messages *messages);
/* Means of every disk that a checkpoint leaves to its readers (SUMMARY_LATER), from its state. path: of the file; model: of the
 * run, NULL: from its deck (constants_read). */
sd_status checkpoint_complete(const h5_file *file, const char *path, const sd_model *model,
                              constants_deck_reader *read_deck, summary_disks *s,
                              sd_messages *messages);
uint64_t checkpoint_bytes(const sd_state *state);  /* of all its columns */
int64_t checkpoint_get_parts(const h5_file *file); /* -1: this is no checkpoint */
uint64_t checkpoint_get_last_part(const h5_file *file);
char *checkpoint_get_replaces(const h5_file *file); /* to be freed; NULL: none */
/* Is it a result, or a checkpoint, that this version can read? SD_ERROR_USER: another program's, or a newer one's. */
sd_status checkpoint_check_origin(const h5_file *file, const char *path, sd_messages *messages);
/* And a checkpoint that it can go on from? */
sd_status checkpoint_check_format(const h5_file *file, const char *path, sd_messages *messages);

/* --- Reading ------------------------------------------------------------------------------------- */
/* Sizes in a state, and their names as attributes of /state. */
typedef struct checkpoint_extent {
  const char *name;
  size_t offset;
} checkpoint_extent;
enum { CHECKPOINT_EXTENTS = 11 };
extern const checkpoint_extent checkpoint_extents[CHECKPOINT_EXTENTS];
size_t checkpoint_extent_of(const sd_state *sizes, size_t k);
int64_t checkpoint_count_contacts(const h5_file *file); /* -1: not there */
uint64_t checkpoint_sum_of(const sd_state *state);
const char *checkpoint_hash_of(const sd_state *state, char text[20]);

#endif
