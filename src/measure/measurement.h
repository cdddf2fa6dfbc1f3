/* measurement.h: all that is measured of one stored frame; docs/measure.md has names and definitions. */
#ifndef MEASURE_MEASUREMENT_H
#define MEASURE_MEASUREMENT_H

#include "measure/cells.h"
#include "measure/correlation.h"
#include "measure/observable.h"
#include "measure/stress.h"

typedef struct measurement {
  const char *file;
  int64_t frame; /* number of the stored frame, -1: the state */
  configuration c;
  region region;
  bool region_given; /* by the caller */
  unsigned open;     /* configuration_open; 0 when the region is given */
  double width, height;
  stress s;
  cells cells;
  bool has_cells;
  correlation pairs;
} measurement;

/* wanted (may be NULL): x0, x1, y0, y1. measurement_free also when it fails. A triangulation that fails is a warning:
 * cells are then not known. */
sd_status measurement_new(measurement *m, const sd_model *constants, const frame_data *frame,
                          const double *wanted, size_t bins, sd_messages *messages);
void measurement_free(measurement *m);
/* On a disk: sum of l.f over twice the area of its cell, of a disk in a clump that of the clump; NAN where a cell is open. */
double measurement_pressure(const measurement *m, size_t disk);

/* The numbers of a measurement: columns of frames.csv, and the JSON, with the object in which they stand. */
extern const observable_list measurement_observables;

#endif
