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

/* view_file.c: makes the page of a finished or unfinished run. *path: receives the path of the
 * page, which the caller frees; *made: set to true if the page was written. */
sd_status view_file(const view_options *o, char **path, bool *made, sd_messages *messages);
/* view_deck.c: makes the page of a deck, which shows how its run would begin. SD_ERROR_USER: the
 * deck has mistakes; the page is made all the same if the deck can be displayed. path, made: same
 * as for view_file. */
sd_status view_deck(const view_options *o, char **path, bool *made, sd_messages *messages);

/* Chunk of numbers for the viewer's page, such as a frame: columns in one block of bytes, in the
 * following form.
 *
 * Layout: u32 J (little endian), J bytes of JSON, padded so that 4 + J is a multiple of 8, then the
 * columns, each beginning at a multiple of 8. The JSON has a list `columns` of {name, type, count,
 * offset from the end of the JSON, scale, zero, shuffle}; a value is zero + scale * stored, and
 * here scale is 1 and zero is 0. shuffle true: the first bytes of all numbers come first, then all
 * second bytes, ..., which compresses better. The whole chunk is a zlib stream. */

typedef enum view_form {
  VIEW_EXACT, /* Stored as 64-bit float */
  /* Stored as 32-bit float, rounded to multiples of view_chunk.grain if that is > 0 */
  VIEW_REAL,
  /* Stored as 32-bit float whose last 13 bits are 0, that is, with about three decimal digits */
  VIEW_SHORT,
  VIEW_WHOLE /* Stored as integer, in the smallest type that holds all values */
} view_form;

typedef struct view_chunk {
  /* JSON at the beginning of the chunk; callers may add values to it */
  json_t *head;
  bool shuffle;
  /* Step to whose multiples VIEW_REAL values are rounded, a power of two; 0: no rounding */
  double grain;
  size_t size, room;
  /* Bytes of the columns; size: number of bytes in use, room: number of bytes allocated */
  unsigned char *bytes;
  bool failed; /* True: out of memory for the columns */
} view_chunk;

/* Begins an empty chunk. shuffle: true orders the bytes so that the chunk compresses better but
 * takes longer to make. */
void view_chunk_begin(view_chunk *c, bool shuffle);
/* Adds a column of n values of the C type `type`, stored in the form `form`; consecutive values are
 * `stride` elements apart in `values`. */
void view_chunk_add(view_chunk *c, const char *name, view_form form, sd_type type,
                    const void *values, size_t n, size_t stride);
/* Compresses a chunk into *stream, which the caller frees. The chunk is freed in any case. level:
 * compression level of zlib, 0 to 9. SD_ERROR_IO: out of memory. */
sd_status view_chunk_end(view_chunk *c, int level, unsigned char **stream, size_t *size,
                         sd_messages *messages);
/* Frees a chunk that will not be written. */
void view_chunk_drop(view_chunk *c);

/* --- view_page.c: the viewer's page with the numbers that it shows ---------------------------- */

/* Viewer's page from src/app/view/page as one zero-terminated text, made by
 * tools/cmake/embed.cmake. */
extern const unsigned char viewer_page[];

/* view_page_head writes the page up to the place where the chunks of numbers come, with the JSON
 * `meta` about the run; view_page_tail writes the rest of the page. Both return false after an
 * error of `out`. */
bool view_page_head(FILE *out, const json_t *meta);
bool view_page_tail(FILE *out);

typedef struct view_page {
  file_stream file;
  size_t bytes; /* Bytes of compressed chunks written so far */
} view_page;

/* Opens a page for writing, under a temporary name until it is complete. Call view_page_close also
 * after an error. */
sd_status view_page_open(view_page *p, const char *path, const json_t *meta, sd_messages *messages);
/* Writes a chunk to the page under the name `name`; frees the chunk also after an error. */
sd_status view_page_add(view_page *p, const char *name, view_chunk *c, sd_messages *messages);
/* Closes the page. If `status` is SD_OK, gives the file its final name; else removes it. Returns
 * the first error. */
sd_status view_page_close(view_page *p, sd_status status, sd_messages *messages);

/* Opens a page, given by its path or address, in the browser and does not wait for the browser.
 * Warns if there is none. */
sd_status view_open(const char *page, sd_messages *messages);

/* --- view_data.c: run, disks and frames for the viewer's page (docs/view.md) ------------------ */

/* Number of disks above which values are stored with only as many digits as can be seen. */
enum { VIEW_FEW = 1000 };

/* Returns a JSON object with the data that every run has: walls, names, box. kind: "result", "deck"
 * or "live". */
json_t *view_meta(const sd_model *model, const char *kind, const char *title, const char *source);
/* Adds the phases of a model, for a run that has not begun, to `meta`. */
void view_meta_phases(json_t *meta, const sd_model *model);
/* Adds phases, means of watched disks, and the residual of the energy budget to `meta`, as found in
 * a run. */
void view_meta_summary(json_t *meta, const summary *found);

/* Makes a chunk of the columns that are the same in all frames. first: angles of the disks in the
 * first frame, NULL: angles in the deck; found: means of every disk, may be NULL. */
void view_static(view_chunk *c, const sd_model *model, const double *first,
                 const summary_disks *found, bool shuffle);
/* Replaces the angles of the disks in a frame by the angles turned since the first frame. first:
 * angles in the first frame; NULL: angles in the deck. */
void view_turns(frame_data *frame, const sd_model *model, const double *first);
/* Makes a chunk of a frame, whose angles must have been replaced by view_turns. */
void view_frame(view_chunk *c, const sd_model *model, const frame_data *frame, bool shuffle);

/* --- view_data.c: time series ----------------------------------------------------------------- */

/* Number of rows, about, above which a time series is thinned out evenly for the page. */
enum { VIEW_MOST_ROWS = 10000 };

/* Adds names and units of the time series to meta.series and makes a chunk of their values. *rows:
 * receives the number of rows; 0: there are none, and no chunk is made. */
sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows,
                           sd_messages *messages);

/* Called for each time series that a run of this model has. The series is element k of the quantity
 * `o`, which is column number `column` of the table that series_new makes. name: name of the
 * series. */
typedef void view_series_visitor(void *user, const observable *o, size_t column, size_t k,
                                 const char *name);
/* Adds each time series of the model to meta.series and calls visit for it; meta and visit may be
 * NULL. */
void view_series_each(const sd_model *model, json_t *meta, view_series_visitor *visit, void *user);

/* --- live.c: a running simulation, shown in a browser on this machine ------------------------- */

typedef struct live live;

/* Starts the server. It listens on a port of 127.0.0.1 that the system chooses, and answers only
 * GET requests whose path begins with a random token of 128 bits. It answers from the copies that
 * live_look makes. source: name of the deck or of the result. The model must outlive *out.
 * SD_ERROR_IO: no port, or out of memory; SD_ERROR_USER: this build has no server. */
sd_status live_open(const sd_model *model, const char *source, live **out, sd_messages *messages);
/* Returns the address of the server, "http://127.0.0.1:PORT/TOKEN/". */
const char *live_address(const live *l);
/* Copies the state and a row of the time series for the server if a copy is due, and in any case
 * after the last step. The stepping thread calls it every few steps. It only reads the simulation,
 * and takes a small part of the wall time. */
void live_look(live *l, sd_simulation *simulation);
/* Stops the server and frees l; NULL is allowed. Before that it waits a moment, so that an open
 * page can ask for the last state. */
void live_close(live *l);

#endif
