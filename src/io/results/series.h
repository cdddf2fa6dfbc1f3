/* series.h: the time series: the rows of energy_observables and series_observables. */
#ifndef SLIPDISK_IO_SERIES_H
#define SLIPDISK_IO_SERIES_H

#include "io/store/table.h"
#include "measure/observable.h"

void series_new(table *t, const sd_model *model);
/* One row. */
sd_status series_sample(table *t, const moment *now, sd_messages *messages);
/* Which disks, walls and groups the columns with a number for each are about. */
void series_write_columns(h5_file *file, const sd_model *model);

#endif
