/* h5_private.h: structs and functions that the files h5*.c share; no other file includes it. */
#ifndef SLIPDISK_IO_H5_PRIVATE_H
#define SLIPDISK_IO_H5_PRIVATE_H

#include <hdf5.h>

#include "io/store/h5.h"

/* A dataset that is being written row by row, see h5_file.c. */
typedef struct h5_rows {
  hid_t set, type;   /* handle of the dataset, and type of the elements in memory */
  int rank, filters; /* number of dimensions; number of filters of the dataset */
  bool checksum;     /* the last of the filters is HDF5's Fletcher checksum */
  bool chunked;      /* rows are gathered until a chunk is full */
  /* Dimensions of the dataset and of a chunk, elements */
  hsize_t dims[H5_MAX_RANK], chunk[H5_MAX_RANK];
  size_t element, row; /* bytes of an element and of a row */
  size_t first, held;  /* first row in the buffer, all before are written; number of rows in it */
  /* Rows of the unfinished chunk; a chunk filled up with zeros. NULL until they are needed */
  unsigned char *buffer, *padded;
} h5_rows;

/* Prepares writing of rows into an open dataset. If its element type is not `type`, rows are not
 * gathered but written at once. Returns false if its rank is 0 or above H5_MAX_RANK. */
bool h5_rows_open(h5_rows *w, hid_t set, sd_type type);
/* Takes n rows from row `first` on; those of a chunked dataset must come in order. Returns false if
 * a write failed. */
bool h5_rows_put(h5_rows *w, size_t first, size_t n, const void *data);
/* Writes the rows that are still in the buffer. Returns false if that failed. */
bool h5_rows_flush(h5_rows *w);
/* Frees the buffers; the dataset stays open. */
void h5_rows_close(h5_rows *w);

/* A dataset that is kept open, so that its rows can come in many calls. */
typedef struct h5_open_set {
  char *path;
  h5_rows rows;
} h5_open_set;

/* Checksum of a dataset or an attribute as it was put into a file on disk, to be compared with the
 * finished file. */
typedef struct h5_entry {
  char *path, *attr;      /* path of the object; name of the attribute, NULL: a dataset */
  uint64_t expected, put; /* number of elements it has; number put so far */
  uint64_t sum;           /* h5_sum of all elements put */
} h5_entry;

/* A dataset whose values stay in the caller's memory until the file is saved. */
typedef struct h5_loan {
  uint64_t at; /* position of the values in the file, bytes */
  const void *data;
  size_t bytes;
} h5_loan;

/* Loans start at multiples of H5_LOAN_ALIGNED and have at least H5_LOAN_LEAST bytes, a multiple of
 * H5_LOAN_WORD, so that no word of the seal's checksum straddles their borders. */
enum { H5_LOAN_LEAST = 64 << 10, H5_LOAN_ALIGNED = 4096, H5_LOAN_WORD = 8 };

/* Shares of a file, and a dataset whose rows are in shares; see h5_open.c below. */
typedef struct h5_shares h5_shares;
typedef struct h5_shared_set h5_shared_set;

struct h5_file {
  hid_t id;       /* handle of the open file */
  char *path;     /* path, for messages */
  bool memory;    /* the file is built in memory */
  bool borrows;   /* made by h5_new_borrowing: datasets may be lent */
  h5_loan *loans; /* [n_loans] lent datasets, in the order of their positions */
  size_t n_loans;
  bool writing;      /* the file is being written and must be flushed at the end */
  bool failed;       /* a write has failed; later ones are skipped */
  char *trouble;     /* description of the first failure, NULL: none */
  h5_open_set *sets; /* [n_sets] datasets that are kept open for their rows */
  size_t n_sets;
  h5_shares *shares; /* joined shares, NULL: none */
  bool on_disk;      /* made by h5_create: has a journal, for h5_compare */
  h5_entry *journal; /* [n_entries] what was put into the file; room for most_entries */
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

/* Makes the record of a file without opening it; h5_release frees it, NULL is allowed. */
h5_file *h5_allocate(const char *path);
void h5_release(h5_file *file);
/* Writes rows that are still held in buffers or in the library's chunk caches. */
void h5_flush_sets(h5_file *file);

/* Flushes and closes a file and reports the first failure of a write. The caller still releases the
 * record. */
sd_status h5_end(h5_file *file, sd_messages *messages);
/* Notes a failure concerning the object at path, unless `good`; only the first is kept. */
void h5_require(h5_file *file, bool good, const char *path);

/* --- Journal of what was written (h5_journal.c) ----------------------------------------------- */
/* Returns the checksum of n elements of `element` bytes, the first of which has the index `first`
 * in its dataset. Each element enters with its index, so that checksums of parts add up in any
 * order. */
uint64_t h5_sum(const void *data, size_t n, size_t element, uint64_t first);
/* Adds a journal entry for a dataset (attr NULL) or an attribute with so many elements. Files
 * without a journal ignore it. */
void h5_expect(h5_file *file, const char *path, const char *attr, uint64_t elements);
/* Notes in the journal that elements first ... first + n - 1 were written. Files without a journal
 * ignore it. */
void h5_note(h5_file *file, const char *path, const char *attr, const void *data, size_t n,
             size_t element, uint64_t first);
/* Compares the contents of `file`, just opened, with the journal of `written`. Returns SD_ERROR_IO
 * at the first difference. */
sd_status h5_compare(const h5_file *file, const h5_file *written, sd_messages *messages);

/* --- Seals (h5_seal.c) ------------------------------------------------------------------------ */
/* The seal that was found at the end of a file. */
typedef struct h5_mark {
  bool sealed;         /* there is a seal, and the file has the size that it states */
  bool broken;         /* there is a seal, but the file has another size */
  bool has_small;      /* there is a checksum of the small data, too */
  uint64_t size;       /* number of bytes that the seal covers */
  uint64_t sum, small; /* checksum of the bytes covered; checksum of the small data */
} h5_mark;

/* Reads the seal at the end of a file; none is no error. */
sd_status h5_read_mark(int fd, const char *path, h5_mark *mark, sd_messages *messages);
/* Returns SD_OK if the checksum of the bytes covered is that of the seal. */
sd_status h5_check_whole(int fd, const char *path, const h5_mark *mark, sd_messages *messages);
/* Computes the checksum of all attributes and of the datasets of up to 64 KiB, in alphabetical
 * order. */
sd_status h5_small_sum(const h5_file *file, uint64_t *sum, sd_messages *messages);
/* Bytes of a seal. */
enum { H5_SEAL_BYTES = 24 };
/* Makes the seal that belongs behind `size` bytes with this checksum. */
void h5_make_seal(size_t size, uint64_t sum, unsigned char seal[H5_SEAL_BYTES]);
/* Appends the checksum of the small data and the seal to an open file. */
sd_status h5_put_seal(int fd, const char *path, uint64_t small, sd_messages *messages);

/* --- Files in memory (h5_memory.c) ------------------------------------------------------------ */
/* Writes a name that no other file in memory has. */
void h5_memory_name(char *name, size_t size);
/* Opens a file in memory whose contents are a copy of these bytes. flags: as for H5Fopen. Returns a
 * negative value if they are no HDF5 file or if there is no memory. */
hid_t h5_open_image(const char *name, const void *bytes, size_t size, unsigned flags);

/* --- Shares (h5_open.c) ----------------------------------------------------------------------- */
/* A group of the shares, "/disks" or "/contacts"; all its datasets have the same order of rows. */
typedef struct h5_shared_group {
  const char *name; /* path of the group in the shares */
  size_t *rows;     /* [shares] number of rows in each share */
  int64_t **place;  /* [shares][rows] index of each row among those of all shares, ascending */
  size_t total;     /* number of rows in all shares */
  /* Number of rows of the shares that form one row of the joined dataset; 0: each is one */
  size_t each;
} h5_shared_group;

/* A dataset whose rows are in shares. */
struct h5_shared_set {
  char *path;
  const h5_shared_group *group;
  sd_type type; /* type of the elements in the shares */
  size_t width; /* number of elements in a row of a share */
  size_t tail;  /* number of rows of the file itself, which follow those of the shares */
  char *own;    /* values of these rows, of `type` */
};

enum { H5_SHARED_GROUPS = 2 };

/* The shares of a file, whose datasets have been joined. */
struct h5_shares {
  h5_file *head, **file; /* the file itself; [n] its shares */
  size_t n;
  h5_shared_group group[H5_SHARED_GROUPS];
  h5_shared_set *set; /* [n_sets] datasets with rows in shares */
  size_t n_sets;
  const h5_shared_group *listed; /* group and share whose datasets are being listed */
  const h5_file *listed_in;
  sd_status status;
  sd_messages *messages;
};

/* Opens the shares of a file. From then on their datasets are listed as its own, with the shape of
 * the joined dataset; values are read from the shares when they are asked for. folder: see
 * file.h. */
sd_status h5_join(h5_file *file, int folder, sd_messages *messages);
/* Closes and frees shares; NULL is allowed. */
void h5_shares_free(h5_shares *s);
/* Returns the joined dataset at path if its rows are in shares, else NULL. */
const h5_shared_set *h5_shared_set_of(const h5_file *file, const char *path);
/* Reads rows [first, first + n) of a joined dataset, converted to type; they must exist. */
sd_status h5_shared_rows(const h5_file *file, const h5_shared_set *set, sd_type type, size_t first,
                         size_t n, void *data, sd_messages *messages);

/* --- Pages of files that borrow (h5_memory.c) ------------------------------------------------- */
/* Selects a driver that keeps a file in memory, in at most `room` bytes of address space; only
 * pages that are written take memory. Returns false if the library refuses it. */
bool h5_set_pages(hid_t access, size_t room);

/* --- Trial reading (h5_probe.c) --------------------------------------------------------------- */
/* How h5_probe reads a file. */
typedef enum h5_probing {
  /* Names, attributes and, up to a limit, values; values that cannot be read are left to the
   * reader */
  H5_PROBE_QUICK,
  H5_PROBE_WHOLE, /* names, attributes and all values, which must be readable */
  H5_PROBE_SMALL  /* small data, whose checksum must be `small` */
} h5_probing;
/* Reads an open file in another process, since the library crashes with some damaged files. Returns
 * SD_ERROR_IO if it crashed there or if the file is damaged. */
sd_status h5_probe(int fd, const char *path, h5_probing how, uint64_t small, sd_messages *messages);
/* Switches h5_probe off, for tests that make thousands of files with the library itself. */
void h5_probe_nothing(void);
/* Returns why the values of a dataset are not read (other files, virtual dataset, too large
 * chunks); NULL: they can be read. */
const char *h5_set_trouble(hid_t set);

/* --- Particles of H5MD files (h5_md.c) -------------------------------------------------------- */
/* An element of a group of particles of an H5MD file, such as "position" or "box/edges", and the
 * frame of it that is read. */
typedef struct h5_element {
  const char *name;     /* path of the element in its group */
  bool framed, stepped; /* true: it has frames; true: its frames have steps */
  size_t frames, frame; /* number of frames; index of the frame to be read */
  /* [frames] steps, or NULL: frame k has the step offset + k * interval */
  int64_t *step, interval, offset;
} h5_element;

/* Finds the frames of these elements to be read: those of the last step that all elements with
 * frames have. step: receives this step, -1: no element has steps. Returns SD_ERROR_USER if there
 * is no such step. */
sd_status h5_moment(const h5_file *file, const char *group, h5_element *elements, size_t n,
                    int64_t *step, sd_messages *messages);
/* Returns true if a dataset has a fill value other than 0 for rows that were not written, and
 * writes it to *fill. */
bool h5_is_fill(const h5_file *file, const char *path, double *fill);
/* Returns the name of the element that marks rows without a particle; NULL: there is none. */
const char *h5_absence(const h5_file *file, const char *group);
/* Sets gone[k] for each of n rows of this element, whose values are given, to whether it holds no
 * particle. */
sd_status h5_absent(const h5_file *file, const char *group, const h5_element *element,
                    const double *value, size_t n, bool *gone, sd_messages *messages);
/* Returns the texts of an attribute (an array of strings, or one string with commas or blanks) as
 * one text with a newline after each, to be freed; NULL: there are none. */
char *h5_words(const h5_file *file, const char *path, const char *name);

/* Opens for reading the file of a descriptor, which the caller keeps. Nothing is checked. */
sd_status h5_open_descriptor(int fd, const char *path, h5_file **out, sd_messages *messages);
/* Switches off the library's printing of errors, in this thread, and its clean-up at exit, which
 * would write. */
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
