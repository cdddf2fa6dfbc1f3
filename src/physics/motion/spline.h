/* spline.h: cubic splines through the table of a motion. */
#ifndef SLIPDISK_PHYSICS_MOTION_SPLINE_H
#define SLIPDISK_PHYSICS_MOTION_SPLINE_H

#include <stdbool.h>
#include <stddef.h>

/* Zeroed memory is no spline. */
typedef struct spline {
  const double *x, *y; /* [n] the table */
  double *half_bend;   /* [n] half the second derivative */
  size_t n;
  size_t last; /* interval of the value before */
} spline;

/* Puts a spline through n >= 3 points with ascending x, which must outlive it: natural, or
 * periodic, y[n - 1] = y[0]. false: there is none. */
bool spline_new(spline *s, const double *x, const double *y, size_t n, bool periodic);
void spline_free(spline *s);

/* Value and derivative at x between x[0] and x[n - 1]. */
double spline_value(spline *s, double x);
double spline_slope(spline *s, double x);

#endif
