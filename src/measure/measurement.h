/* measurement.h: all measurements of one stored frame; docs/measure.md defines the quantities. */
#ifndef MEASURE_MEASUREMENT_H
#define MEASURE_MEASUREMENT_H

#include "measure/cells.h"
#include "measure/correlation.h"
#include "measure/observable.h"
#include "measure/stress.h"
#include "slipdisk/measurement.h"

typedef struct measurement {
  const char *file;
  int64_t frame; /* number of the stored frame; -1: the stored state at the end of the run */
  configuration c;
  region region;
  bool region_given; /* true if the caller chose the region */
  /* edges that are neither wall nor periodic, see configuration_open; 0 if region_given */
  unsigned open;
  double width, height;
  stress s;
  cells cells;
  bool has_cells;
  correlation pairs;
  size_t bins; /* number of bins of each histogram */
} measurement;

/* Measures a frame. wanted: x0, x1, y0, y1 of a region, or NULL. Call measurement_free also when it
 * fails. SD_ERROR_USER: no disk is in play, or a region was given in a sheared box. If the radical
 * cells cannot be computed (SD_ERROR_NUMERIC) this is only a warning, and has_cells is false. */
sd_status measurement_new(measurement *m, const sd_model *constants, const frame_data *frame,
                          const double *wanted, size_t bins, sd_messages *messages);
void measurement_free(measurement *m);
/* Returns the pressure on a disk: the sum of l.f over its contacts divided by twice the area of its
 * radical cell, with l from its centre to the contact and f the contact force. For a disk in a
 * clump, sum and area are those of the whole clump. NAN if a cell is open. */
double measurement_pressure(const measurement *m, size_t disk);

/* Table of all quantities of a measurement, with their columns in frames.csv and their names in the
 * JSON output (OBJECT.NAME). The program, the library (slipdisk/measurement.h) and Python loop over
 * it: a new quantity is one more row. */
extern const observable_list measurement_observables;
/* Values of observable.width in this table: xx, xy, yx, yy of a tensor; a value for each bin of a
 * histogram; the limits of the bins. */
#define MEASUREMENT_TENSOR (OBSERVABLE_CHOSEN - 1)
#define MEASUREMENT_BINS (OBSERVABLE_CHOSEN - 2)
#define MEASUREMENT_EDGES (OBSERVABLE_CHOSEN - 3)
/* Returns the number of elements of a quantity of the table. */
size_t measurement_width(const observable *o, size_t bins);

/* quantities.c: measures a frame like measurement_new, and copies all quantities of the table into
 * *out, which sd_measurement_free frees; NULL on errors. Checks wanted and bins. */
sd_status measurement_tabulate(const sd_model *constants, const frame_data *frame,
                               const double *wanted, size_t bins, sd_measurement **out,
                               sd_messages *messages);

#endif
