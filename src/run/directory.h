/* directory.h: rows by number, spread over the ranks: each keeps those of a strip of numbers.
 * Functions are collective; without memory the job ends. */
#ifndef SLIPDISK_RUN_DIRECTORY_H
#define SLIPDISK_RUN_DIRECTORY_H

#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"

typedef struct directory {
  const comm *comm;
  size_t width, first, size; /* numbers of a strip; of this rank's; bytes of a row */
  char *rows;
} directory;

/* Rows of `size` bytes, all zero, for numbers below n. */
void directory_new(directory *d, const comm *c, size_t n, size_t size);
void directory_free(directory *d);
/* Notes n rows. */
void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows);
/* The rows of n numbers, which may be asked for many times. */
void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows);

#endif
