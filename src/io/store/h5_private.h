/* h5_private.h: what h5*.c share; no other file includes it. */
#ifndef SLIPDISK_IO_H5_PRIVATE_H
#define SLIPDISK_IO_H5_PRIVATE_H

#include <hdf5.h>

#include "io/store/h5.h"

/* A dataset that is being filled by rows, see h5_file.c. */
typedef struct h5_rows {
  hid_t set, type;
  int rank, filters;
  bool checksum; /* the last of the filters */
  bool chunked;  /* rows are gathered until a chunk is full */
  hsize_t dims[H5_MAX_RANK], chunk[H5_MAX_RANK];
  size_t element, row; /* bytes */
  size_t first, held;  /* rows in the buffer; those before are written */
  unsigned char *buffer, *padded;
} h5_rows;

/* The dataset's type must be that of the rows, or they are written as they come. False: it has another rank. */
bool h5_rows_open(h5_rows *w, hid_t set, sd_type type);
bool h5_rows_put(h5_rows *w, size_t first, size_t n, const void *data);
bool h5_rows_flush(h5_rows *w); /* what is still held */
void h5_rows_close(h5_rows *w); /* frees; the dataset stays open */

/* Kept open, so that its rows can come in many calls. */
typedef struct h5_open_set {
  char *path;
  h5_rows rows;
} h5_open_set;

/* Sum of a dataset or an attribute as it was put into a file on disk, to be compared with the finished file. */
typedef struct h5_entry {
  char *path, *attr;      /* attr NULL: a dataset */
  uint64_t expected, put; /* elements */
  uint64_t sum;           /* h5_sum of all */
} h5_entry;

/* A dataset whose values stay where they are until the file is saved. */
typedef struct h5_loan {
  uint64_t at; /* in the file */
  const void *data;
  size_t bytes;
} h5_loan;

/* Loans stand at multiples of this, so that the seal's words do not straddle their borders. */
enum { H5_LOAN_LEAST = 64 << 10, H5_LOAN_ALIGNED = 4096, H5_LOAN_WORD = 8 };

typedef struct h5_shares h5_shares;
typedef struct h5_shared_set h5_shared_set;

struct h5_file {
  hid_t id;
  char *path;     /* for messages */
  bool memory;    /* made by h5_new */
  bool borrows;   /* made by h5_new_borrowing */
  h5_loan *loans; /* in the order of the file */
  size_t n_loans;
  bool writing;
  bool failed;   /* a write went wrong ... */
  char *trouble; /* ... and this was the first */
  h5_open_set *sets;
  size_t n_sets;
  h5_shares *shares; /* NULL: it has none */
  bool on_disk;      /* made by h5_create: has a journal */
  h5_entry *journal;
  size_t n_entries, most_entries;
};

/* --- h5_file.c -------------------------------------------------------------------------------- */
static inline hid_t h5_native(sd_type type) {
  switch (type) {
    case SD_F64: return H5T_NATIVE_DOUBLE;
    case SD_I64: return H5T_NATIVE_INT64;
    case SD_I32: return H5T_NATIVE_INT32;
    case SD_U32: return H5T_NATIVE_UINT32;
  }
  return H5I_INVALID_HID;
}

/* An empty record of a file, and its end. */
h5_file *h5_allocate(const char *path);
void h5_release(h5_file *file);
/* Writes rows that are still held, or in the chunk caches. */
void h5_flush_sets(h5_file *file);

/* Flushes and closes; what went wrong while writing is reported. The file is still to be released. */
sd_status h5_end(h5_file *file, sd_messages *messages);
/* Remembers the first failure, of what is at path. */
void h5_require(h5_file *file, bool good, const char *path);

/* --- h5_journal.c ----------------------------------------------------------------------------------- */
/* Sum over elements, each with its place, so that pieces add up in any order. */
uint64_t h5_sum(const void *data, size_t n, size_t element, uint64_t first);
/* Makes or finds the entry of an object with so many elements. */
void h5_expect(h5_file *file, const char *path, const char *attr, uint64_t elements);
/* Elements first ... first + n - 1 were put there. */
void h5_note(h5_file *file, const char *path, const char *attr, const void *data, size_t n,
             size_t element, uint64_t first);
/* Is what `file` (just opened) holds what the journal of `written` says? */
sd_status h5_compare(const h5_file *file, const h5_file *written, sd_messages *messages);

/* --- h5_seal.c -------------------------------------------------------------------------------------- */
typedef struct h5_mark {
  bool sealed;    /* there is a seal, and the file has the length that it says */
  bool broken;    /* there is a seal, and the file has not */
  bool has_small; /* there is a sum of the small data */
  uint64_t size;  /* bytes that the seal covers */
  uint64_t sum, small;
} h5_mark;

/* Reads the marks at the end of the file. */
sd_status h5_read_mark(int fd, const char *path, h5_mark *mark, sd_messages *messages);
/* Is the sum of the bytes that of the seal? */
sd_status h5_check_whole(int fd, const char *path, const h5_mark *mark, sd_messages *messages);
/* Sum of all attributes and of the datasets of up to 64 KiB, in the order of their names. */
sd_status h5_small_sum(const h5_file *file, uint64_t *sum, sd_messages *messages);
/* The seal of bytes in memory with this sum, to stand behind them. */
enum { H5_SEAL_BYTES = 24 };
void h5_make_seal(size_t size, uint64_t sum, unsigned char seal[H5_SEAL_BYTES]);
/* Puts seal and sum of the small data behind the HDF5 data of an open file. */
sd_status h5_put_seal(int fd, const char *path, uint64_t small, sd_messages *messages);

/* --- h5_memory.c ------------------------------------------------------------------------------ */
/* A name that no other file in memory has. */
void h5_memory_name(char *name, size_t size);
/* Opens a file in memory that begins with these bytes, of which it has a copy; negative: they are
 * no HDF5 file, or there is no memory. */
hid_t h5_open_image(const char *name, const void *bytes, size_t size, unsigned flags);

/* --- h5_open.c -------------------------------------------------------------------------------- */
/* Datasets of one group of the shares have the same order of rows. */
typedef struct h5_shared_group {
  const char *name;
  size_t *rows;    /* [shares] */
  int64_t **place; /* [shares][rows], ascending: where they stand in the whole */
  size_t total;
  size_t each; /* rows of the shares in a row of the whole; 0: they are its rows */
} h5_shared_group;

struct h5_shared_set {
  char *path;
  const h5_shared_group *group;
  sd_type type;
  size_t width; /* elements of a row of a share */
  size_t tail;  /* rows of the head itself, behind all others */
  char *own;    /* these */
};

enum { H5_SHARED_GROUPS = 2 };

struct h5_shares {
  h5_file *head, **file;
  size_t n;
  h5_shared_group group[H5_SHARED_GROUPS];
  h5_shared_set *set;
  size_t n_sets;
  const h5_shared_group *listed; /* while datasets are listed, of this share */
  const h5_file *listed_in;
  sd_status status;
  sd_messages *messages;
};

/* Opens the shares of a file. Their datasets are listed as its own from then on, with the shape of the whole; their values stay in
 * the shares until they are read. */
sd_status h5_join(h5_file *file, int folder, sd_messages *messages);
void h5_shares_free(h5_shares *s);
/* The dataset, if its rows stand in shares; else NULL. */
const h5_shared_set *h5_shared_set_of(const h5_file *file, const char *path);
/* Rows [first, first + n) of the whole, which it must have. */
sd_status h5_shared_rows(const h5_file *file, const h5_shared_set *set, sd_type type, size_t first,
                         size_t n, void *data, sd_messages *messages);

/* --- Pages of files that borrow (h5_memory.c) ---------------------------------------------------- */
/* Files of this access stand in memory, in at most so many bytes, and take pages where something was written. */
bool h5_set_pages(hid_t access, size_t room);

/* --- h5_probe.c ------------------------------------------------------------------------------------- */
/* Reads an open file in another process, which may crash; SD_ERROR_IO: it did. */
typedef enum h5_probing {
  H5_PROBE_QUICK, /* names, attributes and, up to a limit, values; values that cannot be read are left to the reader */
  H5_PROBE_WHOLE, /* everything, and all of it must be readable */
  H5_PROBE_SMALL  /* the sum of the small data is to be `small` */
} h5_probing;
sd_status h5_probe(int fd, const char *path, h5_probing how, uint64_t small, sd_messages *messages);
/* Switches probing off: for trials that make thousands of files with the library itself. */
void h5_probe_nothing(void);
/* What keeps the values of a dataset from being read; NULL: they stand in the file, in chunks of a size that can be meant. */
const char *h5_set_trouble(hid_t set);

/* --- h5_md.c ---------------------------------------------------------------------------------------- */
/* An element of a group of particles of an H5MD file, such as "position" or "box/edges". */
typedef struct h5_element {
  const char *name;
  bool framed, stepped; /* it has frames; they have steps */
  size_t frames, frame; /* number; the one to be read */
  int64_t *step, interval, offset;
} h5_element;

/* Finds the frames to be read of these elements, of the last step that all with frames have. step: -1 where there are none.
 * SD_ERROR_USER: there is no such step. */
sd_status h5_moment(const h5_file *file, const char *group, h5_element *elements, size_t n,
                    int64_t *step, sd_messages *messages);
/* Does the file say by which value, other than 0, rows are filled that were not written? */
bool h5_is_fill(const h5_file *file, const char *path, double *fill);
/* The element that tells rows without a particle; NULL: there is none. */
const char *h5_absence(const h5_file *file, const char *group);
/* Of n rows of this element: gone[k] where there is no particle. */
sd_status h5_absent(const h5_file *file, const char *group, const h5_element *element,
                    const double *value, size_t n, bool *gone, sd_messages *messages);
/* The texts of an attribute (an array of strings, or one with commas or blanks) as one with a newline after each; NULL:
 * none. To be freed. */
char *h5_words(const h5_file *file, const char *path, const char *name);

/* Opens the file behind a descriptor, which stays the caller's. Nothing is checked. */
sd_status h5_open_descriptor(int fd, const char *path, h5_file **out, sd_messages *messages);
/* Switches the library's own printing off, in this thread, and its clean-up at exit (which writes). */
void h5_quiet(void);
/* The library's reason for the last failure, written into text[size]. */
const char *h5_reason(char *text, size_t size);
/* Is there a link on the way that is not followed? */
bool h5_is_link(const h5_file *file, const char *path);
/* Opens a dataset, or the group or dataset at path; negative: reported. */
hid_t h5_open_data(const h5_file *file, const char *path, sd_messages *messages);
hid_t h5_open_object(const h5_file *file, const char *path, sd_messages *messages);
/* Reads `count` elements from `start` on along each dimension of a dataset that has some. */
bool h5_read_slab(hid_t set, hid_t type, const hsize_t *start, const hsize_t *count, void *data);
/* Dimensions; returns the rank. */
int h5_extent(hid_t set, size_t dims[H5_MAX_RANK]);

#endif
