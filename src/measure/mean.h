/* measure/mean.h: means of records of a driven system, apart so that all that measures can use them. */
#ifndef SLIPDISK_MEASURE_MEAN_H
#define SLIPDISK_MEASURE_MEAN_H

#include "slipdisk/measure.h"

/* The common period of all motions of the measured phases; 0: there is none. */
double mean_period(const sd_model *model);
/* sd_mean_of, with its transient, of a record with a ripple of the given period, in samples; 0: of none. */
sd_mean mean_of_record(const double *x, size_t n, double period);

#endif
