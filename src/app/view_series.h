/* view_series.h: the time series of a run for the viewer's page. */
#ifndef SLIPDISK_APP_VIEW_SERIES_H
#define SLIPDISK_APP_VIEW_SERIES_H

#include "app/view_chunk.h"
#include "io/results/frames.h"
#include "measure/observable.h"

/* Of long series every so many rows are told. */
enum { VIEW_MOST_ROWS = 10000 };

/* Names and units into meta.series, values into the chunk. *rows = 0: there are none, and no chunk. */
sd_status view_series_read(view_chunk *c, const frames *f, bool shuffle, json_t *meta, size_t *rows,
                           sd_messages *messages);
/* Tells of one series; name: as of its column. */
void view_series_describe(json_t *meta, const observable *o, bool energy, const char *name);

#endif
