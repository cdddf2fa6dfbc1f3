/* quantities.c: measurement of a frame as named values of the library (slipdisk/measurement.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/measurement.h"

/* Refuses a region or a number of bins that cannot be measured. */
static sd_status check(const double *wanted, size_t bins, sd_messages *messages) {
  enum { MOST_BINS = 100000 };
  if (bins < 1 || bins > MOST_BINS)
    return sd_fail(messages, SD_ERROR_USER, "bins = %zu: expected 1 ... %d", bins, MOST_BINS);
  bool good = true;
  for (int k = 0; wanted && k < 4; k++) good = good && isfinite(wanted[k]);
  if (wanted && !(good && wanted[0] < wanted[1] && wanted[2] < wanted[3]))
    return sd_fail(messages, SD_ERROR_USER,
                   "region = %g, %g, %g, %g: expected x0, x1, y0, y1 with x0 < x1 and y0 < y1",
                   wanted[0], wanted[1], wanted[2], wanted[3]);
  return SD_OK;
}

/* Describes a row of the table; its `width` values are at `values`. */
static sd_quantity describe(const observable *o, size_t width, const double *values) {
  const bool tensor = o->width == MEASUREMENT_TENSOR;
  return (sd_quantity){.name = o->name,
                       .unit = o->unit,
                       .meaning = o->meaning,
                       .json = o->json ? o->json : o->name,
                       .kind = o->type == OBSERVABLE_FLAG  ? SD_FLAG
                               : o->type == OBSERVABLE_F64 ? SD_REAL
                                                           : SD_COUNT,
                       .rank = tensor ? 2 : o->width != 1,
                       .shape = {tensor ? 2 : width, tensor ? 2 : 1},
                       .values = values};
}

/* The values follow the quantities, which follow the measurement, in one piece of memory. */
static sd_measurement *tabulate(const measurement *m) {
  const observable_list *list = &measurement_observables;
  size_t n_values = 0;
  for (size_t k = 0; k < list->n; k++) n_values += measurement_width(&list->rows[k], m->bins);
  sd_measurement *out =
      memory_new(1, sizeof *out + list->n * sizeof(sd_quantity) + n_values * sizeof(double));
  sd_quantity *quantity = (sd_quantity *)(out + 1);
  double *value = (double *)(quantity + list->n);
  *out = (sd_measurement){.n = list->n, .quantities = quantity};
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    const size_t width = measurement_width(o, m->bins);
    quantity[k] = describe(o, width, value);
    for (size_t i = 0; i < width; i++) *value++ = observable_value(o, m, i);
  }
  return out;
}

sd_status measurement_tabulate(const sd_model *constants, const frame_data *frame,
                               const double *wanted, size_t bins, sd_measurement **out,
                               sd_messages *messages) {
  *out = NULL;
  sd_status status = check(wanted, bins, messages);
  if (status != SD_OK) return status;
  measurement m = {.frame = -1};
  status = measurement_new(&m, constants, frame, wanted, bins, messages);
  if (status == SD_OK) *out = tabulate(&m);
  measurement_free(&m);
  return status;
}

const sd_quantity *sd_measurement_find(const sd_measurement *m, const char *name) {
  for (size_t k = 0; k < m->n; k++)
    if (strcmp(m->quantities[k].name, name) == 0) return &m->quantities[k];
  return NULL;
}

void sd_measurement_free(sd_measurement *m) { free(m); }
