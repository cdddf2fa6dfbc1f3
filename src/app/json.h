/* json.h: what is known, for programs. JSON has no NaN: what is not known is null. */
#ifndef SLIPDISK_APP_JSON_H
#define SLIPDISK_APP_JSON_H

#include <jansson.h>

#include "io/results/summary.h"
#include "measure/observable.h"
#include "slipdisk/status.h"

json_t *json_number(double value);
json_t *json_numbers(size_t n, const double *values);
/* A text that may be no UTF-8: then with ? for what cannot be shown. */
json_t *json_text(const char *text);
/* [{"kind": "error" or "warning", "text": ...}] */
json_t *json_messages(const sd_messages *messages);
/* The value of an observable as its type says. */
json_t *json_observable(const observable *o, const void *row, size_t k);
/* Adds element k of the quantities of this width to an object, under their names for JSON; one that is "group.name" goes
 * into an object of this name. */
void json_add(json_t *object, const observable_list *list, const void *row, size_t width, size_t k);
/* The same as a new object, of all quantities of one element. */
json_t *json_row(const observable_list *list, const void *row);
/* A list of the means of each watched disk. */
json_t *json_rotations(const summary *found);
/* Prints it on the standard output, and says so when that cannot be written. */
sd_status json_print(const json_t *root);

#endif
