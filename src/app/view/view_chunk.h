/* view_chunk.h: numbers of a moment as the viewer's page reads them: columns in one block of bytes.
 *
 * u32 J (little endian), J bytes of JSON, padded so that 4 + J is a multiple of 8, then the columns, each from a
 * multiple of 8 on. The JSON has a list `columns` of {name, type, count, offset behind the JSON, scale, zero, shuffle};
 * a value is zero + scale * stored. shuffle: first all first bytes of the numbers, then all second ones, ..., which
 * compresses better. Here scale is 1 and zero 0. The whole is a zlib stream. */
#ifndef SLIPDISK_APP_VIEW_CHUNK_H
#define SLIPDISK_APP_VIEW_CHUNK_H

#include <jansson.h>

#include "model/state.h"
#include "slipdisk/status.h"

typedef enum view_form {
  VIEW_EXACT, /* f64 */
  VIEW_REAL,  /* f32, rounded to multiples of view_chunk.grain where that is > 0 */
  VIEW_SHORT, /* f32 whose last 13 bits are 0: three digits */
  VIEW_WHOLE  /* whole numbers, in the smallest type that takes them */
} view_form;

typedef struct view_chunk {
  json_t *head; /* what is told beside the columns may be added to it */
  bool shuffle;
  double grain; /* a power of two */
  size_t size, room;
  unsigned char *bytes; /* of the columns */
  bool failed;          /* no memory for them */
} view_chunk;

/* shuffle: what is to be kept small rather than made fast. */
void view_chunk_begin(view_chunk *c, bool shuffle);
/* n values of `type`, `stride` numbers apart. */
void view_chunk_add(view_chunk *c, const char *name, view_form form, sd_type type,
                    const void *values, size_t n, size_t stride);
/* The zlib stream, to be freed, and frees the chunk in any case. level: of zlib, 0 to 9. SD_ERROR_IO: no memory. */
sd_status view_chunk_end(view_chunk *c, int level, unsigned char **stream, size_t *size,
                         sd_messages *messages);
/* Frees a chunk that is not wanted. */
void view_chunk_drop(view_chunk *c);

#endif
