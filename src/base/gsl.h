/* gsl.h: includes those parts of the GNU Scientific Library that the core uses: random numbers
 * (packings), sorting, smallest and largest numbers and histograms (measuring). GSL is the core's
 * only dependency besides the C library. What computes with rounding is our own, since GSL's bits
 * depend on the processor (base/math.h).
 *
 * GSL's default error handler ends the process: callers switch it off (gsl_set_error_handler_off)
 * around calls that may fail, which then return a status or NAN.
 */
#ifndef SLIPDISK_BASE_GSL_H
#define SLIPDISK_BASE_GSL_H

#include <gsl/gsl_errno.h>
#include <gsl/gsl_histogram.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>

#endif
