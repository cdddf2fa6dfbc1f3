/* view_series.h: the time series of a run for the viewer's page. */
#ifndef SLIPDISK_APP_VIEW_SERIES_H
#define SLIPDISK_APP_VIEW_SERIES_H

#include "app/view/view_chunk.h"
#include "io/results/frames.h"
#include "measure/observable.h"

/* Of long series every so many rows are told. */
enum { VIEW_MOST_ROWS = 10000 };

/* Names and units into meta.series, values into the chunk. *rows = 0: there are none, and no chunk. */
sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows, sd_messages *messages);

/* Calls visit for every series that a run of this model has: element k of a quantity. column: place of the quantity in the
 * table of series_new. */
typedef void view_series_visitor(void *user, const observable *o, size_t column, size_t k, const char *name);
/* Into meta.series (may be NULL) and to visit (may be NULL). */
void view_series_each(const sd_model *model, json_t *meta, view_series_visitor *visit, void *user);

#endif
