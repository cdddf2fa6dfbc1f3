/* h5.h: functions that write and read HDF5 files; h5*.c are the only files that include hdf5.h.
 *
 * Objects are named by absolute paths; missing groups on the way are made. Functions that write
 * return nothing: the first failure is kept in the file and reported once, by h5_save or h5_close,
 * so that code that writes twenty datasets reads like a list of twenty datasets.
 *
 * Only data in the file itself are read: links to other files or to other places in the file,
 * external storage and virtual datasets are refused (a missing source would read as zeros).
 *
 * Files are built in memory and saved whole (h5_new ... h5_save): a file on disk is never appended
 * to, so that a kill or a full disk cannot damage existing data. Only the merge of a finished run
 * writes to disk through the library (h5_create), into a draft, and h5_finish compares what can be
 * read from it with what was put into it. All files end with a seal, a checksum behind the HDF5
 * data, where readers of HDF5 ignore it (h5_seal.c).
 */
#ifndef SLIPDISK_IO_H5_H
#define SLIPDISK_IO_H5_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/store/file.h"
#include "model/state.h"
#include "slipdisk/status.h"

/* Largest number of dimensions of a dataset. */
enum { H5_MAX_RANK = 4 };

/* An HDF5 file that is open for writing or for reading, opaque. */
typedef struct h5_file h5_file;

/* Returns the version of the HDF5 library, like "1.10.8", written into text[size]. */
const char *h5_version(char *text, size_t size);

/* --- Opening and closing ---------------------------------------------------------------------- */
/* Makes an empty file in memory, for writing. Returns SD_ERROR_IO if there is no memory; *out is
 * then NULL. */
sd_status h5_new(h5_file **out, sd_messages *messages);
/* Makes an empty file in memory, for writing, in which h5_lend can refer to about `bytes` bytes of
 * the caller's data without a copy. If address space for them cannot be reserved, it makes a file
 * as h5_new does, and h5_lend copies. */
sd_status h5_new_borrowing(uint64_t bytes, h5_file **out, sd_messages *messages);
/* Makes an empty file in a draft (temporary file), for writing. Space for about `bytes` bytes is
 * reserved first, so that a full disk shows before the library writes (the library may crash when a
 * write fails). */
sd_status h5_create(const file_draft *draft, uint64_t bytes, h5_file **out, sd_messages *messages);
/* Closes a file of h5_create, reads it back, compares it with what was put into it, and appends its
 * checksum (seal). Frees the file in any case; the caller then publishes or drops the draft. */
sd_status h5_finish(h5_file *file, const file_draft *draft, sd_messages *messages);
/* Opens a file for reading, with its files of single ranks (shares, see below). A checksum at its
 * end (seal) is checked: for files up to 64 MiB that of all bytes, else only that of the attributes
 * and small datasets. A file without a checksum is accepted if another process can read it
 * (sd_set_program). */
sd_status h5_open(const char *path, h5_file **out, sd_messages *messages);
/* Opens a file for reading like h5_open, but checks all bytes of a file with a checksum (seal),
 * whatever its size. */
sd_status h5_open_whole(const char *path, h5_file **out, sd_messages *messages);
/* Opens a file for reading that must have a checksum at its end (seal), and checks all of it.
 * Returns SD_ERROR_IO if it has none or does not match it. folder: see file.h; sum: receives the
 * checksum, may be NULL. */
sd_status h5_open_sealed(int folder, const char *path, h5_file **out, uint64_t *sum,
                         sd_messages *messages);
/* Like h5_open_sealed, without a folder, but does not open the files of single ranks (shares) that
 * belong to the file. */
sd_status h5_open_head(const char *path, h5_file **out, sd_messages *messages);
/* Opens a file for reading like h5_open, but without the checks, for a file that was opened and
 * checked before. */
sd_status h5_open_again(const char *path, h5_file **out, sd_messages *messages);
/* Checks all of a file against the checksum at its end (seal). Returns SD_ERROR_IO if it does not
 * match or if the file is no HDF5 file. sealed: receives true if there is a checksum; sum: receives
 * the checksum (file_sum) of the whole file, of which that at its end is the last part. */
sd_status h5_verify(const char *path, bool *sealed, uint64_t *sum, sd_messages *messages);
/* Replaces the checksum at the end of a file (seal) by that of its present contents, after it was
 * changed on purpose. */
sd_status h5_reseal(const char *path, sd_messages *messages);
/* Writes a file of h5_new to path, with a checksum at its end (seal), so that it appears complete
 * or not at all (file_write_atomic). Frees the file in any case. sum: receives the checksum, may be
 * NULL. */
sd_status h5_save(h5_file *file, int folder, const char *path, uint64_t *sum,
                  sd_messages *messages);
/* Writes a file of h5_new into memory instead of to disk: *data, with its checksum (seal), which
 * the caller frees with free; NULL on errors. Frees the file in any case. */
sd_status h5_save_memory(h5_file *file, void **data, size_t *size, sd_messages *messages);
/* Opens the bytes of h5_save_memory for reading and checks their checksum. The caller may free the
 * bytes afterwards. */
sd_status h5_open_memory(const void *data, size_t size, h5_file **out, sd_messages *messages);
/* Closes a file and reports the first failure of a write to it. Frees the file in any case; NULL is
 * allowed. */
sd_status h5_close(h5_file *file, sd_messages *messages);

/* --- Writing ---------------------------------------------------------------------------------- */
/* Makes a group; one that exists is left as it is. */
void h5_group(h5_file *file, const char *path);
/* Writes a dataset with all its values: dims[rank] elements of `type` in C order; rank 0: a
 * scalar. */
void h5_put(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
            const void *data, bool compress);
/* Writes a dataset without compression. In a file of h5_new_borrowing a long dataset is not copied:
 * its data must stay unchanged until h5_save. */
void h5_lend(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             const void *data);
/* Writes a text as a dataset; NULL counts as "". */
void h5_put_text(h5_file *file, const char *path, const char *text);
/* Writes n texts as a dataset of strings of equal storage length; NULL counts as "". */
void h5_put_texts(h5_file *file, const char *path, size_t n, const char *const *texts);
/* Writes an attribute of n elements; n = 0: a scalar. */
void h5_attr(h5_file *file, const char *path, const char *name, sd_type type, size_t n,
             const void *data);
/* Writes an attribute that is a text; NULL counts as "". */
void h5_attr_text(h5_file *file, const char *path, const char *name, const char *text);
/* Writes an attribute that is an array of n texts of equal storage length; NULL counts as "".
 * n = 0: no attribute is written. */
void h5_attr_texts(h5_file *file, const char *path, const char *name, size_t n,
                   const char *const *texts);
/* Writes an attribute that is one floating-point number. */
void h5_attr_f64(h5_file *file, const char *path, const char *name, double value);
/* Writes an attribute that is one integer. */
void h5_attr_i64(h5_file *file, const char *path, const char *name, int64_t value);
/* Makes a hard link at `path` to the object at `target`. */
void h5_link(h5_file *file, const char *target, const char *path);
/* Makes a dataset of known size without values, which h5_put_rows writes row by row (first index).
 * With compress it is stored in chunks; its rows must then come in order, and are held in memory
 * until their chunk is full or the file is saved or closed. */
void h5_make(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             bool compress);
/* Writes rows first ... first + n - 1 of a dataset of h5_make; data: all elements of these rows. */
void h5_put_rows(h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                 const void *data);
/* Copies the n rows of a dataset to rows first ... first + n - 1 of the dataset of h5_make at the
 * same path of another file, without unpacking them, if both have rows longer than a chunk. Returns
 * the number of rows copied: 0 if they are stored in another way, less than n if a row cannot be
 * read, or written (h5_failed). */
size_t h5_copy_rows(const h5_file *from, h5_file *out, const char *path, sd_type type, size_t first,
                    size_t n);
/* Returns true if a write has failed. */
bool h5_failed(const h5_file *file);
/* Records in the file that there is no memory for the object at path; this is reported like a
 * failed write. */
void h5_no_memory(h5_file *file, const char *path);
/* Returns `got`, which is true if memory was allocated; if it is false, records in the file that
 * there is no memory for the object at path. */
static inline bool h5_check_memory(h5_file *file, bool got, const char *path) {
  if (!got) h5_no_memory(file, path);
  return got;
}

/* --- Reading ---------------------------------------------------------------------------------- */
/* Returns true if there is an object at path that is reached by hard links alone. */
bool h5_exists(const h5_file *file, const char *path);
/* Returns SD_OK if a dataset has n elements and was written completely. It is called before memory
 * is allocated for a number of elements that was read from a file. */
sd_status h5_check(const h5_file *file, const char *path, size_t n, sd_messages *messages);
/* Reads the rank of a dataset and its dimensions dims[H5_MAX_RANK]; those beyond the rank are 1. */
sd_status h5_shape(const h5_file *file, const char *path, int *rank, size_t *dims,
                   sd_messages *messages);
/* Reads all of a dataset, which must have n elements, converted to type. */
sd_status h5_get(const h5_file *file, const char *path, sd_type type, size_t n, void *data,
                 sd_messages *messages);
/* Reads all of a dataset, which must have n elements, converted to type, into a new array that the
 * caller frees. Returns NULL, with *status set, if it cannot be read, or if *status was an error
 * before. */
void *h5_column(const h5_file *file, const char *path, sd_type type, size_t n, sd_status *status,
                sd_messages *messages);
/* Reads rows first ... first + n - 1 (first index) of a dataset whose rows have `width` elements
 * each, converted to type; another shape in the file is an error. */
sd_status h5_get_values(const h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                        size_t width, void *data, sd_messages *messages);
/* Returns the text in a dataset, to be freed; NULL: there is none. Texts are returned as printable
 * UTF-8, with ? for other bytes. */
char *h5_get_text(const h5_file *file, const char *path);
/* Returns true if the object at path has an attribute of this name. */
bool h5_has_attr(const h5_file *file, const char *path, const char *name);
/* Returns the value of a numeric attribute; `otherwise` if there is none. */
double h5_get_attr_f64(const h5_file *file, const char *path, const char *name, double otherwise);
/* Returns the value of an integer attribute; `otherwise` if there is none. */
int64_t h5_get_attr_i64(const h5_file *file, const char *path, const char *name, int64_t otherwise);
/* Reads an attribute of n numbers. Returns false, with values unchanged, if there is none or it has
 * another size. */
bool h5_get_attr_f64s(const h5_file *file, const char *path, const char *name, size_t n,
                      double *values);
/* Returns the text of an attribute, to be freed; NULL: there is none. */
char *h5_get_attr_text(const h5_file *file, const char *path, const char *name);
/* A function that h5_visit calls for a dataset. type: the sd_type nearest to the stored type; text:
 * true if it holds strings; dims: H5_MAX_RANK dimensions. */
typedef void h5_visitor(void *user, const char *path, sd_type type, bool text, int rank,
                        const size_t *dims);
/* Calls visit for every dataset below the root, in alphabetical order of paths. */
sd_status h5_visit(const h5_file *file, h5_visitor *visit, void *user, sd_messages *messages);

/* --- Shares ----------------------------------------------------------------------------------- */
/* A file may have shares: files with a checksum beside it, each with some rows of some datasets,
 * each written by one rank. When the file is opened they are joined, so that it reads as one file.
 * In a share the rows of /path are at /disks/path or at /contacts/path, and /disks/key[row] or
 * /contacts/key[row] orders them: rows of lower keys, in any share, come first; rows with equal
 * keys are in one share. Rows that the file itself has at /path come last. The attribute `each` of
 * the key dataset gives the number of rows of the shares that form one row of /path, as the disks
 * of a frame do; without it each is a row of its own. */

/* Returns the path of share k of a file, i.e. of the file that rank k writes: NAME-k.h5 for
 * NAME.h5; the caller frees it. */
char *h5_share_path(const char *path, size_t k);
/* Writes into a file that it has n files of single ranks (shares), with these checksums. */
void h5_put_shares(h5_file *file, size_t n, const int64_t *sums);
/* Returns true if rows of a file are in files of single ranks (shares). */
bool h5_has_shares(const h5_file *file);

/* --- Tables of particles ---------------------------------------------------------------------- */
/* Range of rows of a table. On input: the rows asked for, at most n from `first` on. On output: the
 * rows read, and the number `all` of rows in the table; all = 0: the rows cannot be read in ranges,
 * since some rows hold no particle. */
typedef struct h5_range {
  size_t first, n, all;
  bool again;   /* input: true if the file was opened, and checked, before */
  int64_t step; /* output: step of the values in an H5MD file; -1: none */
  /* output: [n] indices of the rows kept, among those asked for; the caller frees it; NULL: all
   * rows were kept */
  uint32_t *kept;
} h5_range;

/* Reads the named columns of a table as (*values)[row * n_columns + column], to be freed. `dataset`
 * is one of
 * - a compound dataset with these fields,
 * - a 2D dataset whose attribute "columns" names its columns,
 * - a group with a 1D dataset per column,
 * - a particles group of an H5MD file, such as "/particles/disks", read at the last step that all
 *   columns have, without rows that hold no particle; x, y, vx, vy, theta, omega there are the
 *   components of the elements position, velocity, angle, angular_velocity.
 * Every missing column gives one message. Returns SD_ERROR_IO if the file cannot be read,
 * SD_ERROR_USER for all other errors. */
sd_status h5_read_table(const char *file, const char *dataset, size_t n_columns,
                        const char *const *columns, double **values, h5_range *rows,
                        sd_messages *messages);

/* Lower and upper edges of a box along x and y; they are equal in directions that are not periodic.
 * step: step to which they belong, -1 if the box does not change. */
typedef struct h5_box {
  double lower[2], upper[2];
  int64_t step;
} h5_box;

/* Reads the box of the particles of an H5MD file at the step of their positions. found: receives
 * true if the file has a box. */
sd_status h5_particles_box(const h5_file *file, bool *found, h5_box *box, sd_messages *messages);
/* Returns the path of the only group of particles that has positions, to be freed; NULL: there is
 * none, or more than one, or the file is a checkpoint, or cannot be opened. */
char *h5_only_particles(const char *path);
/* Returns true if the library takes the file for an HDF5 file, also behind a user block. */
bool h5_is_file(const char *path);
/* Command of the program slipdisk that h5_probe starts, with a file as its standard input. It calls
 * h5_probe_serve with its two words, which ends the process, or returns if there is no file. */
#define H5_PROBE_COMMAND "read-hdf5"
void h5_probe_serve(const char *how, const char *small);
/* Kinds of files that a user may name. */
typedef enum file_kind {
  FILE_OTHER,
  FILE_DECK,
  FILE_HDF5,
  FILE_H5MD,
  FILE_LAMMPS,
  FILE_TABLE
} file_kind;
/* Returns the kind of a file from the ending of its name, such as ".cfg"; if this is none of the
 * known endings, FILE_HDF5 if the content is HDF5, else FILE_OTHER. The file need not exist. */
file_kind h5_kind_of(const char *path);

#endif
