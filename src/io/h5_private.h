/* h5_private.h: what h5*.c share; no other file includes it. */
#ifndef SLIPDISK_IO_H5_PRIVATE_H
#define SLIPDISK_IO_H5_PRIVATE_H

#include <hdf5.h>

#include "io/h5.h"

/* A dataset that is being filled by rows: kept open, so that the library's chunk cache bridges the calls. */
typedef struct h5_open_set {
  char *path;
  hid_t id;
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
