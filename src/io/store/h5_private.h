/* h5_private.h: structs and functions that the files h5*.c share; no other file includes it. */
#ifndef SLIPDISK_IO_H5_PRIVATE_H
#define SLIPDISK_IO_H5_PRIVATE_H

#include <hdf5.h>

#include "io/store/h5.h"

/* A dataset that is being written row by row, see h5_file.c. */
typedef struct h5_rows {
  hid_t set, type;   /* handle of the dataset, and type of the elements in memory */
  int rank, filters; /* rank: number of dimensions; filters: number of filters of the dataset */
  bool checksum;     /* true if the last of the filters is HDF5's Fletcher checksum */
  bool chunked;      /* true if rows are gathered until a chunk is full */
  /* dimensions, in elements, of the dataset and of one chunk */
  hsize_t dims[H5_MAX_RANK], chunk[H5_MAX_RANK];
  size_t element, row; /* bytes of one element, and of one row (first index), of the dataset */
  /* first: first row in the buffer, all rows before it are written; held: number of rows in it */
  size_t first, held;
  /* buffer: rows of the unfinished chunk; padded: a chunk filled up with zeros; both NULL until
   * needed */
  unsigned char *buffer, *padded;
} h5_rows;

/* Prepares writing of rows into an open dataset. If its element type is not `type`, rows are not
 * gathered but written at once. Returns false if its rank is 0 or above H5_MAX_RANK. */
bool h5_rows_open(h5_rows *w, hid_t set, sd_type type);
/* Writes n rows from row `first` on, or holds them in the buffer until their chunk is full. Rows of
 * a chunked dataset must come in order. Returns false if a write failed. */
bool h5_rows_put(h5_rows *w, size_t first, size_t n, const void *data);
/* Writes the rows that are still in the buffer. Returns false if that failed. */
bool h5_rows_flush(h5_rows *w);
/* Frees the buffers; the dataset stays open. */
void h5_rows_close(h5_rows *w);

/* A dataset that is kept open, so that its rows can be written in many calls. */
typedef struct h5_open_set {
  char *path;
  h5_rows rows;
} h5_open_set;

/* Journal entry: checksum of a dataset or an attribute as it was put into a file on disk, to be
 * compared with the finished file. */
typedef struct h5_entry {
  /* path: path of the object; attr: name of the attribute, NULL: the object is a dataset */
  char *path, *attr;
  /* expected: number of elements of the object; put: number written so far */
  uint64_t expected, put;
  uint64_t sum; /* checksum (h5_sum) of all elements written, or of stored chunks */
  /* [rows] true if `sum` has the stored chunks of this row (h5_copy_rows); NULL: of none */
  bool *direct;
} h5_entry;

/* A lent dataset: its values stay in the caller's memory until the file is saved. */
typedef struct h5_loan {
  uint64_t at; /* position of the values in the file, bytes */
  const void *data;
  size_t bytes;
} h5_loan;

/* Lent datasets have at least H5_LOAN_LEAST bytes and start in the file at multiples of
 * H5_LOAN_ALIGNED. */
enum { H5_LOAN_LEAST = 64 << 10, H5_LOAN_ALIGNED = 4096 };

/* h5_shares: the files of single ranks (shares) that belong to a file; h5_shared_set: a dataset
 * whose rows are in these files. Both are defined below. */
typedef struct h5_shares h5_shares;
typedef struct h5_shared_set h5_shared_set;

struct h5_file {
  hid_t id;       /* handle of the open file */
  char *path;     /* path, for messages */
  bool memory;    /* true if the file is in memory */
  bool borrows;   /* true if made by h5_new_borrowing: datasets may be lent */
  h5_loan *loans; /* [n_loans] lent datasets, in the order of their positions in the file */
  size_t n_loans;
  bool writing;      /* true if the file is being written and must be flushed at the end */
  bool failed;       /* true if a write has failed; later writes are skipped */
  char *trouble;     /* description of the first failure, NULL: none */
  h5_open_set *sets; /* [n_sets] datasets that are kept open while their rows are written */
  size_t n_sets;
  h5_shares *shares; /* files of single ranks (shares) joined with this file, NULL: none */
  bool on_disk;      /* true if made by h5_create: has a journal, for h5_compare */
  /* [n_entries] checksums of what was put into the file; allocated: most_entries */
  h5_entry *journal;
  size_t n_entries, most_entries;
};

/* --- Record of an open file (h5_file.c) ------------------------------------------------------- */
/* Returns the library's type in memory for elements of `type`. */
static inline hid_t h5_native(sd_type type) {
  switch (type) {
    case SD_F64: return H5T_NATIVE_DOUBLE;
    case SD_I64: return H5T_NATIVE_INT64;
    case SD_I32: return H5T_NATIVE_INT32;
    case SD_U32: return H5T_NATIVE_UINT32;
  }
  return H5I_INVALID_HID;
}

/* Makes the record of a file without opening it. h5_release frees it; NULL is allowed there. */
h5_file *h5_allocate(const char *path);
void h5_release(h5_file *file);
/* Writes rows that are still held in buffers or in the library's chunk caches. */
void h5_flush_sets(h5_file *file);

/* Flushes and closes a file and reports the first failure of a write. The caller must still call
 * h5_release. */
sd_status h5_flush_and_close(h5_file *file, sd_messages *messages);
/* Records a failed operation on the object at path, unless `good` is true; only the first failure
 * is kept. */
void h5_require(h5_file *file, bool good, const char *path);

/* --- Journal of what was written (h5_journal.c) ----------------------------------------------- */
/* Returns the checksum of n elements of `element` bytes, the first of which has the index `first`
 * in its dataset. Each element enters with its index, so that checksums of parts add up in any
 * order. */
uint64_t h5_sum(const void *data, size_t n, size_t element, uint64_t first);
/* Adds a journal entry for a dataset (attr NULL) or an attribute with this number of elements. Does
 * nothing for files without a journal. */
void h5_expect(h5_file *file, const char *path, const char *attr, uint64_t elements);
/* Adds elements first ... first + n - 1, which were written, to the checksum in the journal. Does
 * nothing for files without a journal. */
void h5_note(h5_file *file, const char *path, const char *attr, const void *data, size_t n,
             size_t element, uint64_t first);
/* Adds the checksum (h5_copy_chunks) of a row with `elements` elements that was copied into a
 * dataset with n_rows rows. */
void h5_note_chunks(h5_file *file, const char *path, size_t row, size_t n_rows, size_t elements,
                    uint64_t sum);
/* Compares the contents of `file`, which was just opened, with the journal (checksums) of
 * `written`. Returns SD_ERROR_IO at the first difference. */
sd_status h5_compare(const h5_file *file, const h5_file *written, sd_messages *messages);

/* --- Stored chunks (h5_chunks.c) -------------------------------------------------------------- */
/* Returns true if both datasets have rows longer than a chunk, and a stored chunk of one means the
 * same in the other. */
bool h5_chunks_alike(hid_t from, hid_t to);
/* Copies the chunks of a row of such a dataset to row `to_row` of another, and adds their checksum
 * to *sum. Returns false if they cannot be read; *written: false if they cannot be written. */
bool h5_copy_chunks(hid_t from, size_t row, hid_t to, size_t to_row, bool *written, uint64_t *sum);
/* Adds to *sum the checksum of the chunks of rows first ... first + n - 1 as they are stored.
 * Returns false if they cannot be read. */
bool h5_sum_chunks(hid_t set, size_t first, size_t n, uint64_t *sum);

/* --- Seals (h5_seal.c) ------------------------------------------------------------------------ */
/* The checksum that was found at the end of a file (seal). */
typedef struct h5_mark {
  bool sealed;    /* true if there is a seal, and the file has the size stated in it */
  bool broken;    /* true if there is a seal, but the file has another size */
  bool has_small; /* true if there is also a hash of the attributes and small datasets */
  uint64_t size;  /* number of bytes covered by the checksum of the seal */
  bool words;     /* true if `sum` is a hash_words, as in files of versions up to 0.6 */
  /* sum: checksum of these bytes; small: hash of the attributes and small datasets; all: checksum
   * (file_sum) of the whole file with its seal */
  uint64_t sum, small, all;
} h5_mark;

/* Reads the checksum at the end of a file (seal) into *mark; a file without one is no error. */
sd_status h5_read_mark(int fd, const char *path, h5_mark *mark, sd_messages *messages);
/* Returns SD_OK if the checksum of an open file, computed now, is that in its seal, `mark`. Sets
 * mark->all. */
sd_status h5_check_whole(int fd, const char *path, h5_mark *mark, sd_messages *messages);
/* Returns true if these bytes are a file with a seal that fits them. */
bool h5_seal_fits(const void *data, size_t size);
/* Computes the hash (hash_words) of all attributes and of the datasets of up to 64 KiB, in
 * alphabetical order. */
sd_status h5_small_sum(const h5_file *file, uint64_t *sum, sd_messages *messages);
/* Size in bytes of a seal (checksum at the end of a file). */
enum { H5_SEAL_BYTES = 24 };
/* Makes the seal (checksum) that belongs at the end of a file of `size` bytes with the checksum
 * `sum`. */
void h5_make_seal(size_t size, uint64_t sum, unsigned char seal[H5_SEAL_BYTES]);
/* Appends the hash `small` of the attributes and small datasets, and then the checksum of all
 * bytes (seal), to an open file. */
sd_status h5_put_seal(int fd, const char *path, uint64_t small, sd_messages *messages);

/* --- Files in memory (h5_memory.c) ------------------------------------------------------------ */
/* Writes a name that no other file in memory has. */
void h5_memory_name(char *name, size_t size);
/* Opens a file in memory whose contents are a copy of these bytes. flags: as for H5Fopen. Returns a
 * negative value if they are no HDF5 file or if there is no memory. */
hid_t h5_open_image(const char *name, const void *bytes, size_t size, unsigned flags);

/* --- Shares (h5_open.c) ----------------------------------------------------------------------- */
/* A group of datasets in the shares (files of single ranks); all its datasets have the same order
 * of rows. */
typedef struct h5_shared_group {
  const char *name; /* path of the group in the file of each rank: "/disks" or "/contacts" */
  size_t *rows;     /* [number of ranks] number of rows in the file of each rank */
  /* [number of ranks][rows] index of each row of a rank among the rows of all ranks, ascending */
  int64_t **place;
  size_t total; /* number of rows in the files of all ranks together */
  /* number of rows in the files of the ranks that form one row (frame) of the joined dataset; 0:
   * each row is one */
  size_t each;
} h5_shared_group;

/* A dataset whose rows are in shares (files of single ranks). */
struct h5_shared_set {
  char *path;
  const h5_shared_group *group;
  sd_type type; /* type of the elements in the files of the ranks */
  size_t width; /* number of elements in one row in the file of a rank */
  size_t tail;  /* number of rows in the main file itself, which follow those of the shares */
  char *own;    /* values of the rows in the main file, as elements of `type` */
};

enum { H5_SHARED_GROUPS = 2 };

/* The shares (files of single ranks) of a file, whose datasets have been joined. */
struct h5_shares {
  h5_file *head, **file; /* head: the main file; file: [n] files of the ranks */
  size_t n;
  h5_shared_group group[H5_SHARED_GROUPS];
  h5_shared_set *set; /* [n_sets] datasets whose rows are in the files of the ranks */
  size_t n_sets;
  /* group whose datasets are being listed, in the file listed_in of one rank */
  const h5_shared_group *listed;
  const h5_file *listed_in;
  sd_status status;
  sd_messages *messages;
};

/* Opens the shares (files of single ranks) of a file. From then on a dataset whose rows are in them
 * is listed and read like one of the file itself, with its joined shape; values are read from the
 * shares when they are asked for. folder: see file.h. */
sd_status h5_join(h5_file *file, int folder, sd_messages *messages);
/* Closes the shares (files of single ranks) of a file and frees the record of them; NULL is
 * allowed. */
void h5_shares_free(h5_shares *s);
/* Returns the dataset at path if its rows are in shares (files of single ranks), else NULL. */
const h5_shared_set *h5_shared_set_of(const h5_file *file, const char *path);
/* Reads rows [first, first + n) of a dataset joined from shares (files of single ranks), converted
 * to type; the rows must exist. */
sd_status h5_shared_rows(const h5_file *file, const h5_shared_set *set, sd_type type, size_t first,
                         size_t n, void *data, sd_messages *messages);

/* --- Pages of files that borrow (h5_memory.c) ------------------------------------------------- */
/* Selects a driver that keeps a file in memory, in at most `room` bytes of address space; only
 * pages that are written take memory. Returns false if the library refuses it. */
bool h5_set_pages(hid_t access, size_t room);

/* --- Trial reading (h5_probe.c) --------------------------------------------------------------- */
/* Ways in which h5_probe reads a file. */
typedef enum h5_probing {
  /* names, attributes and, up to a limit, values; values that cannot be read are no error */
  H5_PROBE_QUICK,
  H5_PROBE_WHOLE, /* names, attributes and all values, which must be readable */
  H5_PROBE_SMALL  /* attributes and small datasets, whose hash must be `small` */
} h5_probing;
/* Reads an open file in another process, since the library crashes with some damaged files. Returns
 * SD_ERROR_IO if it crashed there, took too long, or if the file is damaged. */
sd_status h5_probe(int fd, const char *path, h5_probing how, uint64_t small, sd_messages *messages);
/* Returns true if there is a program for that (sd_set_program); else h5_probe does nothing. */
bool h5_probes(void);
/* Sets the most seconds that the other process may take, beside those for a long file. */
void h5_probe_patience(double seconds);
/* Returns the reason why the values of a dataset are not read (other files, virtual dataset, too
 * large chunks); NULL: they can be read. */
const char *h5_set_trouble(hid_t set);

/* --- Particles of H5MD files (h5_md.c) -------------------------------------------------------- */
/* An element of a group of particles of an H5MD file, such as "position" or "box/edges", and the
 * frame of it that is read. */
typedef struct h5_element {
  const char *name; /* path of the element relative to its group of particles */
  /* framed: true if the element has frames; stepped: true if its frames have steps */
  bool framed, stepped;
  size_t frames, frame; /* frames: number of frames; frame: index of the frame to be read */
  /* [frames] time step of each frame, or NULL: frame k has the step offset + k * interval */
  int64_t *step, interval, offset;
} h5_element;

/* Chooses the frame to be read of each of these n elements: that of the last step that all elements
 * with frames have. *step receives this step, -1: no element has steps. Returns SD_ERROR_USER if
 * there is no such step. */
sd_status h5_moment(const h5_file *file, const char *group, h5_element *elements, size_t n,
                    int64_t *step, sd_messages *messages);
/* Returns true if a dataset has a fill value other than 0, which stands in rows that were not
 * written; *fill receives it. */
bool h5_is_fill(const h5_file *file, const char *path, double *fill);
/* Returns the name of the element (dataset with a value per particle) that marks rows without a
 * particle; NULL: there is none. */
const char *h5_absence(const h5_file *file, const char *group);
/* Sets gone[k] to true for each of n rows that holds no particle. element: the element that marks
 * such rows (h5_absence); value: its value in each row. */
sd_status h5_absent(const h5_file *file, const char *group, const h5_element *element,
                    const double *value, size_t n, bool *gone, sd_messages *messages);
/* Returns the texts of an attribute (an array of strings, or one string with commas or blanks) as
 * one text with a newline after each, to be freed; NULL: there are none. */
char *h5_words(const h5_file *file, const char *path, const char *name);

/* Opens the file of an open descriptor for reading; the caller keeps the descriptor. Nothing is
 * checked. */
sd_status h5_open_descriptor(int fd, const char *path, h5_file **out, sd_messages *messages);
/* Switches off the library's printing of errors, in this thread, and its clean-up at exit, which
 * would write to files. */
void h5_quiet(void);
/* Returns the library's reason for the last failure, written into text[size]. */
const char *h5_reason(char *text, size_t size);
/* Returns true if path leads through a link other than a hard one, which is not followed. */
bool h5_is_link(const h5_file *file, const char *path);
/* h5_open_data opens a dataset, h5_open_object a dataset or group. They return a negative value,
 * with a message, if they cannot. */
hid_t h5_open_data(const h5_file *file, const char *path, sd_messages *messages);
hid_t h5_open_object(const h5_file *file, const char *path, sd_messages *messages);
/* Reads count[k] elements from start[k] on along each dimension k of a dataset with at least one
 * dimension, converted to type. */
bool h5_read_slab(hid_t set, hid_t type, const hsize_t *start, const hsize_t *count, void *data);
/* Returns the rank of a dataset and writes its dimensions; those beyond the rank are 1. */
int h5_extent(hid_t set, size_t dims[H5_MAX_RANK]);

#endif
