/* view.h: the parts of the command view. */
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

/* view_file.c: what a run has left. *path: of the page, to be freed; made: it is there. */
sd_status view_file(const view_options *o, char **path, bool *made, sd_messages *messages);
/* view_deck.c: a run before it begins. A deck with mistakes is SD_ERROR_USER, and has a page if it can be shown. */
sd_status view_deck(const view_options *o, char **path, bool *made, sd_messages *messages);

/* Numbers of a moment as the viewer's page reads them: columns in one block of bytes.
 *
 * u32 J (little endian), J bytes of JSON, padded so that 4 + J is a multiple of 8, then the columns, each from a
 * multiple of 8 on. The JSON has a list `columns` of {name, type, count, offset behind the JSON, scale, zero, shuffle};
 * a value is zero + scale * stored. shuffle: first all first bytes of the numbers, then all second ones, ..., which
 * compresses better. Here scale is 1 and zero 0. The whole is a zlib stream. */

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

/* --- the viewer's page, with the numbers it shows written into it piece by piece -------------- */

/* src/app/viewer in one text, ending in 0; made by tools/cmake/embed.cmake. */
extern const unsigned char viewer_page[];

/* Writes the page without its numbers, but with what is told about the run. False: out has an
 * error. */
bool view_page_head(FILE *out, const json_t *meta);
bool view_page_tail(FILE *out);

typedef struct view_page {
  file_stream file;
  size_t bytes; /* of chunks */
} view_page;

/* Under a name of its own until it is complete. view_page_close also when it fails. */
sd_status view_page_open(view_page *p, const char *path, const json_t *meta, sd_messages *messages);
/* Adds the chunk and frees it, also when it fails. */
sd_status view_page_add(view_page *p, const char *name, view_chunk *c, sd_messages *messages);
/* As file_stream_close. */
sd_status view_page_close(view_page *p, sd_status status, sd_messages *messages);

/* Opens a page or an address in the browser, which is not waited for; says so when there is none. */
sd_status view_open(const char *page, sd_messages *messages);

/* What the viewer's page is told: the run, the disks, and how all stands at a moment. docs/view.md lists it. */

/* More disks than these are told with fewer digits, as far as they can be seen. */
enum { VIEW_FEW = 1000 };

/* The object with what is known of every run: walls, names, box. */
json_t *view_meta(const sd_model *model, const char *kind, const char *title, const char *source);
/* Phases of a run that has not begun. */
void view_meta_phases(json_t *meta, const sd_model *model);
/* Phases, means of watched disks, and the residual of the budget. */
void view_meta_summary(json_t *meta, const summary *found);

/* Columns that do not change. first: angles of the first frame, NULL: those of the deck; found
 * (may be NULL): with means of every disk. */
void view_static(view_chunk *c, const sd_model *model, const double *first,
                 const summary_disks *found, bool shuffle);
/* Angles of the frame's disks become turns since the first frame, or since the deck. */
void view_turns(frame_data *frame, const sd_model *model, const double *first);
/* A frame with turns instead of angles. */
void view_frame(view_chunk *c, const sd_model *model, const frame_data *frame, bool shuffle);

/* --- the time series of a run for the viewer's page ------------------------------------------- */

/* A long series tells every so many rows. */
enum { VIEW_MOST_ROWS = 10000 };

/* Names and units into meta.series, values into the chunk. *rows = 0: there are none, and no chunk. */
sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows,
                           sd_messages *messages);

/* Calls visit for every series that a run of this model has: element k of a quantity. column: place of the quantity in the
 * table of series_new. */
typedef void view_series_visitor(void *user, const observable *o, size_t column, size_t k,
                                 const char *name);
/* Into meta.series (may be NULL) and to visit (may be NULL). */
void view_series_each(const sd_model *model, json_t *meta, view_series_visitor *visit, void *user);

/* A running simulation, shown in a browser on this machine.
 *
 * The thread that steps calls live_look between pieces of steps. It only reads, and only now and then: the time that it takes
 * is a small part of that in between. A thread of the server answers from what live_look has put down.
 *
 * The server listens on 127.0.0.1 alone, on a port that the system chooses. It answers only requests whose path begins
 * with a random token of 128 bits, and only to GET. */

typedef struct live live;

/* source: name of the deck or the result. The model must outlive it. SD_ERROR_IO: no port, or no memory; SD_ERROR_USER: this build has
 * no server. */
sd_status live_open(const sd_model *model, const char *source, live **out, sd_messages *messages);
/* "http://127.0.0.1:PORT/TOKEN/" */
const char *live_address(const live *l);
/* When the run is over it puts down the last state. */
void live_look(live *l, sd_simulation *simulation);
/* A page that is open may still ask for the end; NULL is allowed. */
void live_close(live *l);

#endif
