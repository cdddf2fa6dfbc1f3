/* measure/mean.h: means of records of a driven system, used by all measurements. */
#ifndef SLIPDISK_MEASURE_MEAN_H
#define SLIPDISK_MEASURE_MEAN_H

#include "slipdisk/measure.h"

/* Returns the common period of all motions of the measured phases; 0: there is none. */
double mean_period(const sd_model *model);
/* Returns sd_mean_of, transient cut off, for a record with a periodic ripple. period: of the
 * ripple, in samples; 0: no ripple. */
sd_mean mean_of_record(const double *x, size_t n, double period);

#endif
