/* h5_private.h: what h5*.c share; no other file includes it. */
#ifndef SLIPDISK_IO_H5_PRIVATE_H
#define SLIPDISK_IO_H5_PRIVATE_H

#include <hdf5.h>

#include "io/h5.h"

/* A dataset that is being filled by rows, see h5_chunks.c. */
typedef struct h5_rows {
  hid_t set, type;
  int rank, filters;
  bool chunked; /* rows are gathered until a chunk is full */
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

struct h5_file {
  hid_t id;
  char *path;  /* for messages */
  bool memory; /* made by h5_new */
  bool writing;
  bool failed;   /* a write went wrong ... */
  char *trouble; /* ... and this was the first */
  h5_open_set *sets;
  size_t n_sets;
};

/* Switches the library's own printing off, in this thread, and its clean-up at exit (which writes). */
void h5_quiet(void);
/* The library's reason for the last failure, written into text[size]. */
const char *h5_reason(char *text, size_t size);
hid_t h5_native(sd_type type);

#endif
