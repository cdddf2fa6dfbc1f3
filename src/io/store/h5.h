/* h5.h: the little of HDF5 that slipdisk needs; h5*.c are the only files that see hdf5.h.
 *
 * Objects are named by absolute paths; groups on the way are made as needed. Calls that write return
 * nothing: the first problem is remembered in the file and reported once, by h5_save or h5_close, so that
 * code that writes twenty datasets reads like a list of twenty datasets.
 *
 * Only data in the file itself are read: links to other files or places, external storage and virtual datasets are
 * refused (a missing source would read as zeros).
 *
 * Files are built in memory and saved whole (h5_new ... h5_save): a file on disk is never appended to, so a
 * kill or a full disk cannot damage what is there. Only the merge of a finished run writes through the library to
 * disk (h5_create), into a draft, and h5_finish compares what can be read from it with what was put into it. All files
 * end with a seal, a checksum behind the HDF5 data where readers of HDF5 do not look (h5_seal.c).
 */
#ifndef SLIPDISK_IO_H5_H
#define SLIPDISK_IO_H5_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/store/file.h"
#include "model/state.h"
#include "slipdisk/status.h"

enum { H5_MAX_RANK = 4 };

typedef struct h5_file h5_file;

/* "1.10.8"; written into text[size]. */
const char *h5_version(char *text, size_t size);

/* --- open and close ------------------------------------------------------------------------------- */
sd_status h5_new(h5_file **out, sd_messages *messages); /* empty, in memory */
/* The same, for h5_lend of about so many bytes in all. */
sd_status h5_new_borrowing(uint64_t bytes, h5_file **out, sd_messages *messages);
/* Empty, in a draft; room for about `bytes` is reserved first, so that a full disk shows before the library
 * writes (it may crash when a write fails). */
sd_status h5_create(const file_draft *draft, uint64_t bytes, h5_file **out, sd_messages *messages);
/* Closes a file of h5_create, reads it back, compares it with what was put into it, and seals it. Frees the file in any
 * case; the draft is to be published or dropped. */
sd_status h5_finish(h5_file *file, const file_draft *draft, sd_messages *messages);
/* Read only. Of a sealed file the seal is checked: all of it up to 64 MiB, else its attributes and small datasets; files
 * without a seal are read as they are. h5_open_whole checks all of any sealed file. */
sd_status h5_open(const char *path, h5_file **out, sd_messages *messages);
sd_status h5_open_whole(const char *path, h5_file **out, sd_messages *messages);
/* Read only; SD_ERROR_IO when there is no seal or it does not fit. folder: see file.h; sum (may be NULL): of the seal. */
sd_status h5_open_sealed(int folder, const char *path, h5_file **out, uint64_t *sum,
                         sd_messages *messages);
/* The same without its shares, if it has any. */
sd_status h5_open_head(const char *path, h5_file **out, sd_messages *messages);
/* h5_open of a file that was opened, and checked, before. */
sd_status h5_open_again(const char *path, h5_file **out, sd_messages *messages);
/* SD_ERROR_IO: all of the file does not fit its seal, or it is no HDF5 file. sealed: there is one. */
sd_status h5_verify(const char *path, bool *sealed, uint64_t *sum, sd_messages *messages);
/* Seals a file anew, as it is now, after it was changed on purpose. */
sd_status h5_reseal(const char *path, sd_messages *messages);
/* Writes a file of h5_new to path, with a seal, as file_write_atomic does. Frees the file in any case.
 * sum (may be NULL): of the seal. */
sd_status h5_save(h5_file *file, int folder, const char *path, uint64_t *sum,
                  sd_messages *messages);
/* The same bytes in memory, to be freed with free; *data is NULL on errors. Frees the file in any case. */
sd_status h5_save_memory(h5_file *file, void **data, size_t *size, sd_messages *messages);
/* Read only, of bytes of h5_save_memory, which may go when it returns; the seal is checked. */
sd_status h5_open_memory(const void *data, size_t size, h5_file **out, sd_messages *messages);
/* Reports what went wrong while writing; frees the file in any case. NULL is allowed. */
sd_status h5_close(h5_file *file, sd_messages *messages);

/* --- write ---------------------------------------------------------------------------------------- */
void h5_group(h5_file *file, const char *path);
/* A whole dataset; rank 0 is a scalar. */
void h5_put(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
            const void *data, bool compress);
/* The same, uncompressed. Of a file of h5_new_borrowing a long one is not copied: it must stay as
 * it is until h5_save. */
void h5_lend(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             const void *data);
void h5_put_text(h5_file *file, const char *path, const char *text); /* NULL counts as "" */
/* n strings of equal storage length; NULL counts as "". */
void h5_put_texts(h5_file *file, const char *path, size_t n, const char *const *texts);
/* Attribute of n elements; n = 0: a scalar. */
void h5_attr(h5_file *file, const char *path, const char *name, sd_type type, size_t n,
             const void *data);
void h5_attr_text(h5_file *file, const char *path, const char *name, const char *text);
/* Attribute that is an array of n strings of equal storage length. */
void h5_attr_texts(h5_file *file, const char *path, const char *name, size_t n,
                   const char *const *texts);
void h5_attr_f64(h5_file *file, const char *path, const char *name, double value);
void h5_attr_i64(h5_file *file, const char *path, const char *name, int64_t value);
void h5_link(h5_file *file, const char *target, const char *path); /* hard link */
/* A dataset of known size (in chunks when compressed), to be filled by rows (first index) with h5_put_rows. Those of
 * a compressed one come in order, and wait in memory until their chunk is full, or the file is saved or closed. */
void h5_make(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             bool compress);
void h5_put_rows(h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                 const void *data);
bool h5_failed(const h5_file *file); /* a write has gone wrong */
/* There is no memory for what should stand at path: reported like a failed write. */
void h5_no_memory(h5_file *file, const char *path);
/* Returns got; false is no memory, as above. */
static inline bool h5_have(h5_file *file, bool got, const char *path) {
  if (!got) h5_no_memory(file, path);
  return got;
}

/* --- read ----------------------------------------------------------------------------------------- */
bool h5_exists(const h5_file *file, const char *path);
/* Has the dataset n elements? Asked before there is memory for as many as a number in the file says. */
sd_status h5_check(const h5_file *file, const char *path, size_t n, sd_messages *messages);
/* rank and dims[H5_MAX_RANK] of a dataset. */
sd_status h5_shape(const h5_file *file, const char *path, int *rank, size_t *dims,
                   sd_messages *messages);
/* Exactly n elements, converted to type; another size in the file is an error. */
sd_status h5_get(const h5_file *file, const char *path, sd_type type, size_t n, void *data,
                 sd_messages *messages);
/* The same as an array, to be freed. NULL when it cannot be read, or when *status was no SD_OK before. */
void *h5_column(const h5_file *file, const char *path, sd_type type, size_t n, sd_status *status,
                sd_messages *messages);
/* Rows that have `width` elements each; another shape in the file is an error. */
sd_status h5_get_values(const h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                        size_t width, void *data, sd_messages *messages);
/* To be freed; NULL when there is none. Texts that are read are printable UTF-8: ? stands for other bytes. */
char *h5_get_text(const h5_file *file, const char *path);
bool h5_has_attr(const h5_file *file, const char *path, const char *name);
/* Values when absent: the given default. */
double h5_get_attr_f64(const h5_file *file, const char *path, const char *name, double otherwise);
int64_t h5_get_attr_i64(const h5_file *file, const char *path, const char *name, int64_t otherwise);
/* n numbers; false (values as they were): there is none, or not of n elements. */
bool h5_get_attr_f64s(const h5_file *file, const char *path, const char *name, size_t n,
                      double *values);
char *h5_get_attr_text(const h5_file *file, const char *path,
                       const char *name); /* to be freed, or NULL */
/* Calls visit for every dataset below the root, in alphabetical order. */
typedef void h5_visitor(void *user, const char *path, sd_type type, bool text, int rank,
                        const size_t *dims);
sd_status h5_visit(const h5_file *file, h5_visitor *visit, void *user, sd_messages *messages);

/* --- shares --------------------------------------------------------------------------------------- */
/* A file may have shares: sealed files beside it, each with rows of some datasets, which are put together when it is opened. So
 * it reads as one file, whoever has written how much of it. In a share the rows of /path stand in /disks/path or in
 * /contacts/path, and /disks/key or /contacts/key [row] orders them: those of lower keys, in any share, come first; rows
 * of equal keys stand in one share. Rows that the file itself has at /path come last. Attribute `each` of the key: so many of
 * them are one row of /path, as the disks of a frame are. */

/* Name of share k of a file: NAME-k.h5 of NAME.h5; to be freed. */
char *h5_share_path(const char *path, size_t k);
/* There are n shares, whose seals have these sums. */
void h5_put_shares(h5_file *file, size_t n, const int64_t *sums);
bool h5_has_shares(const h5_file *file);

/* --- tables of particles, for the deck ------------------------------------------------------------ */
/* Rows of a table: asked for (at most n from `first` on), how many that is, and how many there are; 0: rows cannot be had by
 * themselves, since some hold no particle. */
typedef struct h5_range {
  size_t first, n, all;
  bool again;     /* asked: the file was opened, and checked, before */
  int64_t step;   /* of an H5MD file; -1: none */
  uint32_t *kept; /* [n], to be freed: which rows of those asked for; NULL: all of them */
} h5_range;

/* Reads the named columns as (*values)[row * n_columns + column], to be freed. `dataset` is one of
 * - a compound dataset with these fields,
 * - a 2D dataset whose attribute "columns" names its columns,
 * - a group with a 1D dataset per column,
 * - a particles group of an H5MD file, such as "/particles/disks", at the last step that all columns have; rows without
 *   a particle are left out. There x, y, vx, vy, theta, omega stand for the elements position, velocity, angle,
 *   angular_velocity.
 * Every missing column is one message. SD_ERROR_IO: the file cannot be read; SD_ERROR_USER: the rest. */
sd_status h5_read_table(const char *file, const char *dataset, size_t n_columns,
                        const char *const *columns, double **values, h5_range *rows,
                        sd_messages *messages);

/* Edges of a box along x and y; equal in directions that are not periodic. step: whose it is, -1 where it does not change. */
typedef struct h5_box {
  double lower[2], upper[2];
  int64_t step;
} h5_box;

/* The box of the particles of an H5MD file, at the moment of their positions. found: it has one. */
sd_status h5_particles_box(const h5_file *file, bool *found, h5_box *box, sd_messages *messages);
/* The only group of particles that has positions; to be freed, NULL: there is none, or are several. */
char *h5_only_particles(const char *path);
/* Does the library take it for an HDF5 file, also behind a user block? */
bool h5_is_file(const char *path);

#endif
