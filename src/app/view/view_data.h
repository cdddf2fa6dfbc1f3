/* view_data.h: what the viewer's page is told: the run, the disks, and how all stands at a moment. docs/view.md lists it. */
#ifndef SLIPDISK_APP_VIEW_DATA_H
#define SLIPDISK_APP_VIEW_DATA_H

#include "app/view/view_chunk.h"
#include "io/results/frames.h"
#include "io/results/summary.h"
#include "measure/configuration.h"
#include "measure/observable.h"

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

#endif
