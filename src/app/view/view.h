/* view.h: declarations shared by the files of the subcommand `view`. */
#ifndef SLIPDISK_APP_VIEW_H
#define SLIPDISK_APP_VIEW_H

#include <jansson.h>

#include "app/app.h"
#include "io/results/frames.h"
#include "io/results/summary.h"
#include "io/store/file.h"
#include "measure/configuration.h"
#include "measure/observable.h"
#include "model/state.h"
#include "slipdisk/simulation.h"
#include "slipdisk/status.h"

typedef struct view_options {
  const char *name, *output, *frames;
  option_list overrides;
  bool open, live;
  long threads;
} view_options;

/* view_file.c: makes the page of a finished or unfinished run. *path: path of the page, which the
 * caller frees; *made: true if the page was written. */
sd_status view_file(const view_options *o, char **path, bool *made, sd_messages *messages);
/* view_deck.c: makes the page of a deck, which shows how its run begins. SD_ERROR_USER: the deck
 * has mistakes; the page is made all the same if the deck can be displayed. path, made: as
 * above. */
sd_status view_deck(const view_options *o, char **path, bool *made, sd_messages *messages);

/* Chunk of numbers for the viewer's page, such as a frame: columns in one block of bytes.
 *
 * Layout: u32 J (little endian), J bytes of JSON, padded so that 4 + J is a multiple of 8, then
 * the columns, each beginning at a multiple of 8. The JSON has a list `columns` of {name, type,
 * count, offset from the end of the JSON, scale, zero, shuffle}; a value is zero + scale *
 * stored, with scale 1 and zero 0 here. shuffle: the first bytes of all numbers come first, then
 * all second bytes, ..., which compresses better. The whole chunk is a zlib stream. */

typedef enum view_form {
  VIEW_EXACT, /* 64-bit float */
  /* 32-bit float, rounded to multiples of view_chunk.grain if that is > 0 */
  VIEW_REAL,
  VIEW_SHORT, /* 32-bit float whose last 13 bits are 0: three digits */
  VIEW_WHOLE  /* Integer, in the smallest type that holds all values */
} view_form;

typedef struct view_chunk {
  /* JSON; callers may add values to it beside the columns */
  json_t *head;
  bool shuffle;
  double grain; /* Rounding of VIEW_REAL, a power of two; 0: none */
  size_t size, room;
  unsigned char *bytes; /* Columns; size: bytes in use, room: bytes allocated */
  bool failed;          /* True: no memory for the columns */
} view_chunk;

/* Begins an empty chunk. shuffle: for pages, which are to be small rather than made fast. */
void view_chunk_begin(view_chunk *c, bool shuffle);
/* Adds a column of n values of `type`; consecutive values are `stride` elements apart. */
void view_chunk_add(view_chunk *c, const char *name, view_form form, sd_type type,
                    const void *values, size_t n, size_t stride);
/* Compresses a chunk into *stream, which the caller frees, and frees the chunk in any case.
 * level: of zlib, 0 to 9. SD_ERROR_IO: no memory. */
sd_status view_chunk_end(view_chunk *c, int level, unsigned char **stream, size_t *size,
                         sd_messages *messages);
/* Frees a chunk that is not used. */
void view_chunk_drop(view_chunk *c);

/* --- view_page.c: the viewer's page with the numbers that it shows ---------------------------- */

/* The page in src/app/view/page as one zero-terminated text, made by tools/cmake/embed.cmake. */
extern const unsigned char viewer_page[];

/* Write the page up to its numbers, with `meta` about the run, and the rest of the page. Return
 * false after an error of `out`. */
bool view_page_head(FILE *out, const json_t *meta);
bool view_page_tail(FILE *out);

typedef struct view_page {
  file_stream file;
  size_t bytes; /* Bytes of compressed chunks written so far */
} view_page;

/* Opens a page under a temporary name, which it has until it is complete. Call view_page_close
 * also after an error. */
sd_status view_page_open(view_page *p, const char *path, const json_t *meta, sd_messages *messages);
/* Writes a chunk to the page and frees it, also after an error. */
sd_status view_page_add(view_page *p, const char *name, view_chunk *c, sd_messages *messages);
/* Closes the page as file_stream_close does: publishes it if `status` is SD_OK, else drops it.
 * Returns the first error. */
sd_status view_page_close(view_page *p, sd_status status, sd_messages *messages);

/* Opens a page or an address in the browser and does not wait for it. Warns if there is no
 * browser. */
sd_status view_open(const char *page, sd_messages *messages);

/* --- view_data.c: run, disks and frames for the viewer's page (docs/view.md) ------------------ */

/* Number of disks above which values are stored with fewer digits, as many as can be seen. */
enum { VIEW_FEW = 1000 };

/* Returns the object with the data that every run has: walls, names, box. kind: "result", "deck"
 * or "live". */
json_t *view_meta(const sd_model *model, const char *kind, const char *title, const char *source);
/* Adds the phases of a run that has not begun. */
void view_meta_phases(json_t *meta, const sd_model *model);
/* Adds phases, means of watched disks, and the residual of the energy budget. */
void view_meta_summary(json_t *meta, const summary *found);

/* Makes a chunk of the columns that do not change. first: angles of the first frame, NULL: those
 * of the deck; found: means of every disk, may be NULL. */
void view_static(view_chunk *c, const sd_model *model, const double *first,
                 const summary_disks *found, bool shuffle);
/* Replaces the angles of the disks by the angles turned since the first frame; first NULL: since
 * the deck. */
void view_turns(frame_data *frame, const sd_model *model, const double *first);
/* Makes a chunk of a frame whose angles have been replaced by view_turns. */
void view_frame(view_chunk *c, const sd_model *model, const frame_data *frame, bool shuffle);

/* --- view_data.c: time series ----------------------------------------------------------------- */

/* Approximate number of rows above which a series is thinned out evenly. */
enum { VIEW_MOST_ROWS = 10000 };

/* Adds names and units of the time series to meta.series and makes a chunk of their values.
 * *rows: their number; 0: there are none, and no chunk. */
sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows,
                           sd_messages *messages);

/* Called for each series that a run of this model has. k: element of the quantity `o`; column:
 * index of the quantity in the table that series_new makes. */
typedef void view_series_visitor(void *user, const observable *o, size_t column, size_t k,
                                 const char *name);
/* Adds each series to meta.series and calls visit for it; meta and visit may be NULL. */
void view_series_each(const sd_model *model, json_t *meta, view_series_visitor *visit, void *user);

/* --- live.c: a running simulation, shown in a browser on this machine ------------------------- */

typedef struct live live;

/* Starts the server. It listens on a port of 127.0.0.1 that the system chooses, and answers only
 * GET requests whose path begins with a random token of 128 bits, from copies that live_look has
 * made. source: name of the deck or the result. The model must outlive *out. SD_ERROR_IO: no
 * port, or no memory; SD_ERROR_USER: this build has no server. */
sd_status live_open(const sd_model *model, const char *source, live **out, sd_messages *messages);
/* Returns "http://127.0.0.1:PORT/TOKEN/". */
const char *live_address(const live *l);
/* Copies state and series for the server, if that is due; after the last step always. The thread
 * that steps calls it between pieces of steps. It only reads, and takes a small part of the
 * time. */
void live_look(live *l, sd_simulation *simulation);
/* Stops the server and frees l; NULL is allowed. Waits a moment first, in which an open page may
 * ask for the last state. */
void live_close(live *l);

#endif
