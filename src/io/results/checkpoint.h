/* checkpoint.h: writes and reads checkpoints, the files from which a run continues.
 *
 * Group /state holds one dataset per row of sd_fields, with unit and description, and a hash of the
 * state; /checkpoint holds the number of part files of the result
 * that belong to the state; /parameters holds the deck and the provenance of the run; /summary
 * holds the results measured so far. A finished result has the same groups except /checkpoint.
 */
#ifndef SLIPDISK_IO_CHECKPOINT_H
#define SLIPDISK_IO_CHECKPOINT_H

#include "io/results/constants.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"

/* CHECKPOINT_FORMAT is raised when the name or meaning of a column changes, or a column is added. A
 * run continues only from a checkpoint of the present format. Format 3: contacts are ordered by
 * slots, not by the number of the second body; 4: adds columns fast_*; 5: columns of contacts have
 * the names in slipdisk/contact.h, the contact history is that of the evaluation whose forces act,
 * results have the names in io/store/members.c; 6: adds field_power; 7: adds visit_*.
 * CHECKPOINT_OF_PACKING is the oldest format from which a packing is read: a packing takes bodies
 * and contacts in any order and needs no fast_*, so formats 2 and 3 serve as well. */
enum { CHECKPOINT_FORMAT = 11, CHECKPOINT_OF_PACKING = 2 };
/* Returns the name that a column of the state (`name`, as in sd_fields) has in the format of this
 * file: an older name if the format is below 5, else `name`. */
const char *checkpoint_column(const h5_file *file, const char *name);

/* Part files of the result that belong to a checkpoint: they hold the output up to its step, and a
 * run cannot continue without them. */
typedef struct checkpoint_parts {
  int64_t n; /* number of part files */
  /* checksum at the end of the last part file; each part also stores the checksum of the part
   * before it */
  uint64_t last;
  /* path of an older result that the result may replace when the run ends (session_begin.c); "":
   * none */
  const char *replaces;
} checkpoint_parts;

/* Describes a checkpoint whose free disks and contacts are in share files, one written by each rank
 * (h5.h). The share files must be written before the checkpoint itself. */
typedef struct checkpoint_shares {
  const sd_model *model;
  size_t n;
  int64_t *sums;     /* [n] checksum at the end of each share file */
  size_t n_contacts; /* number of contacts of all ranks */
} checkpoint_shares;

/* Writes a checkpoint, with a checksum at its end, to `path`; replaces a file of that name. folder:
 * descriptor of an open folder, see file.h. shares: NULL if `state` holds all disks and
 * contacts. */
sd_status checkpoint_write(int folder, const char *path, const sd_state *state,
                           const checkpoint_parts *parts, const checkpoint_shares *shares,
                           const provenance *origin, const summary *found, sd_messages *messages);

/* Order of the rows of one rank's share file among the rows of all ranks, given by keys. The keys
 * of a share file ascend. */
typedef struct checkpoint_order {
  /* [n_free] key of each free disk: its slot in a run on one rank */
  int64_t *disk_key;
  /* [n_contacts] key of each row of contacts: slot of the disk in a run on one rank, plus 2^32 if
   * the other body is a wall with segments */
  int64_t *contact_key;
  /* [n_contacts] index, in the rank's state, of the contact in each row; contacts of equal key are
   * ordered by the other body and its segment */
  uint32_t *contact;
} checkpoint_order;

/* Removes the share file of rank k, which belongs to a checkpoint that will not be completed.
 * folder: descriptor of an open folder, see file.h. */
void checkpoint_remove_share(int folder, const char *path, size_t k);
/* Writes the free disks and contacts of one rank's state to a share file. sum: receives the
 * checksum at the end of this file. */
sd_status checkpoint_write_share(const char *path, const sd_state *state,
                                 const checkpoint_order *order, int64_t *sum,
                                 sd_messages *messages);

/* Adds the group /state to a file that is being written. If h5_new_borrowing has made the file,
 * large columns are not copied, so the state must not change before h5_save. */
void checkpoint_put_state(h5_file *file, const sd_state *state);
/* Copies the group /state of a checkpoint into `file`, one column at a time, so that no complete
 * state is in memory. */
sd_status checkpoint_copy_state(h5_file *file, const h5_file *checkpoint, sd_messages *messages);
/* Returns the total size in bytes of all columns below /state. */
uint64_t checkpoint_stored_bytes(const h5_file *checkpoint);
/* Reads the state from an open file and verifies its hash; the caller frees *out. SD_ERROR_USER:
 * the state belongs to another model. SD_ERROR_IO: the state is damaged, or memory ran out. */
sd_status checkpoint_get_state(const h5_file *file, const sd_model *model, sd_state **out,
                               sd_messages *messages);
/* Checks that the state in an open file belongs to the model, without reading its columns.
 * SD_ERROR_USER: the state belongs to another model or has another format. SD_ERROR_IO: the state
 * is damaged. */
sd_status checkpoint_check_state(const h5_file *file, const sd_model *model, sd_messages *messages);
/* Reads, as a state, those disks and contacts of a checkpoint with which one of several ranks
 * continues. Columns of prescribed bodies and of the run are complete. If each rank has written a
 * share file, free disks and contacts are those of share files rank, rank + ranks, ...; else they
 * are an equal range of the file's rows. order[n_free]: receives the slots of the disks in a run on
 * one rank, ascending. The caller frees *out and *order. Checksums of the files are verified. */
sd_status checkpoint_get_some(const char *path, const sd_model *model, size_t rank, size_t ranks,
                              sd_state **out, uint32_t **order, sd_messages *messages);
/* Computes the time averages of every disk (see summary_disks_collect) from the state in a file,
 * reading a block of disks at a time. */
sd_status checkpoint_collect_disks(const h5_file *file, const sd_model *model, summary_disks *s,
                                   int threads, sd_messages *messages);
/* Computes the time averages of every disk if the checkpoint does not store them but the state from
 * which they follow (s->later, see SUMMARY_LATER); else does nothing. path: path of the file.
 * model: model of the run; NULL: it is rebuilt from the file (constants_read). */
sd_status checkpoint_complete(const h5_file *file, const char *path, const sd_model *model,
                              constants_deck_reader *read_deck, summary_disks *s,
                              sd_messages *messages);
/* Returns the total size in bytes of all columns of a state in memory. */
uint64_t checkpoint_bytes(const sd_state *state);
/* Returns the number of part files of the result that belong to the checkpoint; -1: the file is not
 * a checkpoint. */
int64_t checkpoint_get_parts(const h5_file *file);
uint64_t checkpoint_get_last_part(const h5_file *file);
/* Returns the path of the older result that may be replaced (checkpoint_parts.replaces), which the
 * caller frees; NULL: none. */
char *checkpoint_get_replaces(const h5_file *file);
/* Checks that the file is a result or checkpoint that this version can read. SD_ERROR_USER: another
 * program or a newer version has written it. */
sd_status checkpoint_check_origin(const h5_file *file, const char *path, sd_messages *messages);
/* Makes the checks of checkpoint_check_origin, and checks that this version can continue a run from
 * the file: its format must be CHECKPOINT_FORMAT. SD_ERROR_USER: it cannot. */
sd_status checkpoint_check_format(const h5_file *file, const char *path, sd_messages *messages);

/* --- Reading ---------------------------------------------------------------------------------- */
/* Describes a member of sd_state that holds a number of rows, and the attribute of /state that
 * stores it. */
typedef struct checkpoint_extent {
  const char *name;
  size_t offset;
} checkpoint_extent;
enum { CHECKPOINT_EXTENTS = 12 };
extern const checkpoint_extent checkpoint_extents[CHECKPOINT_EXTENTS];
/* Returns the number of rows that entry k of checkpoint_extents describes, read from a state. */
size_t checkpoint_extent_of(const sd_state *sizes, size_t k);
/* Returns the number of contacts stored in the file; -1: the attribute is missing. */
int64_t checkpoint_count_contacts(const h5_file *file);
/* Returns a checksum of all columns of a state, computed by 64-bit words (hash_words). */
uint64_t checkpoint_sum_of(const sd_state *state);
/* Writes the hash of a state (sd_state_hash) as 16 hexadecimal digits into `text`, and returns
 * `text`. */
const char *checkpoint_hash_of(const sd_state *state, char text[20]);

#endif
