/* json.h: output of results as JSON. JSON has no NaN, so values that are not known are written as
 * null. */
#ifndef SLIPDISK_APP_JSON_H
#define SLIPDISK_APP_JSON_H

#include <jansson.h>

#include "io/results/summary.h"
#include "measure/observable.h"
#include "slipdisk/status.h"

json_t *json_number(double value);
json_t *json_numbers(size_t n, const double *values);
/* Returns a JSON string. If the text is not valid UTF-8, bytes that cannot be shown become "?". */
json_t *json_text(const char *text);
/* Returns an array with an object for each message: {"kind": "error" or "warning", "text": ...}. */
json_t *json_messages(const sd_messages *messages);
/* Returns element k of a quantity of the row as a JSON boolean, integer or real, by the type of the
 * quantity; null if it is not finite. */
json_t *json_observable(const observable *o, const void *row, size_t k);
/* Returns an array with the first n elements of a quantity of the row. */
json_t *json_elements(const observable *o, const void *row, size_t n);
/* Puts a value into `object`; with a name "group.name" into its member object "group", which is
 * made if it is missing. */
void json_put(json_t *object, const char *name, json_t *value);
/* Adds element k of all quantities of the row that have `width` elements to `object`, under their
 * JSON names (json_put); width 0: adds all quantities, as arrays if they have several elements. */
void json_add(json_t *object, const observable_list *list, const void *row, size_t width, size_t k);
/* Returns a new object with all quantities of a row that are single numbers (width 1). */
json_t *json_row(const observable_list *list, const void *row);
/* Returns an array with the mean rotation of each watched disk. */
json_t *json_rotations(const summary *found);
/* Returns an array with an object for each average of the series. */
json_t *json_averages(const summary *found);
/* Prints `root` to the standard output. Returns SD_ERROR_IO, after a message, if that fails. */
sd_status json_print(const json_t *root);

#endif
