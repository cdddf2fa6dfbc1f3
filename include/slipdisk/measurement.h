/* measurement.h: measures a packing at one moment: contacts, packing fractions, stress, fabric,
 * g(r) and forces, as named values with units. They are the values of `slipdisk measure --json`;
 * docs/measure.md defines them.
 *
 * region: x0, x1, y0, y1 of the part of the plane that counts, lengths; NULL: the region of the
 * deck. A region of a sheared box is refused. bins: number of bins of each histogram, 1 to
 * 100000. Functions with a status set *out to NULL on errors; SD_ERROR_USER: a mistake in the
 * arguments, or no disk is in play. */
#ifndef SLIPDISK_MEASUREMENT_H
#define SLIPDISK_MEASUREMENT_H

#include "slipdisk/simulation.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sd_quantity_kind {
  SD_REAL,  /* any number */
  SD_COUNT, /* a whole number */
  SD_FLAG   /* 0 or 1 */
} sd_quantity_kind;

/* A measured value or array. */
typedef struct sd_quantity {
  const char *name, *unit, *meaning; /* unit: in terms of length, mass, force, time; "1": none */
  const char *json; /* name in `slipdisk measure --json`, OBJECT.NAME; "": it is not there */
  sd_quantity_kind kind;
  /* number of dimensions: 0 a single value, 1 a vector or histogram, 2 a tensor; their lengths */
  size_t rank, shape[2];
  const double *values; /* all elements, row by row; NAN: not known */
} sd_quantity;

/* All quantities of a packing at one moment. */
typedef struct sd_measurement {
  size_t n;
  const sd_quantity *quantities;
} sd_measurement;

/* Returns the quantity with this name; NULL: there is none. */
SD_API const sd_quantity *sd_measurement_find(const sd_measurement *measurement, const char *name);
SD_API void sd_measurement_free(sd_measurement *measurement); /* NULL is allowed */

/* Measures a simulation at the present step. It changes nothing, and is served where
 * sd_simulation_state is. */
SD_API sd_status sd_simulation_measure(sd_simulation *simulation, const double *region, size_t bins,
                                       sd_measurement **out, sd_messages *messages);

/* Stored frames and last state of a run, opaque; sd_result_close frees it. */
typedef struct sd_result sd_result;
/* Opens a finished result, an unfinished run (NAME.h5.parts), a part in that folder (frames
 * only) or a checkpoint (state only). Returns SD_ERROR_USER if there is none, SD_ERROR_IO if it
 * is damaged. */
SD_API sd_status sd_result_open(const char *path, sd_result **out, sd_messages *messages);
SD_API void sd_result_close(sd_result *result); /* NULL is allowed */
/* Returns the number of stored frames. */
SD_API size_t sd_result_frames(const sd_result *result);
/* Measures stored frame 0 ... sd_result_frames - 1; -1: the last state, of a part its last
 * frame. */
SD_API sd_status sd_result_measure(const sd_result *result, int64_t frame, const double *region,
                                   size_t bins, sd_measurement **out, sd_messages *messages);

#ifdef __cplusplus
}
#endif

#endif
