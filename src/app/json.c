/* json.c: see json.h. */
#include "app/json.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

json_t *json_number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

json_t *json_numbers(size_t n, const double *values) {
  json_t *list = json_array();
  for (size_t k = 0; k < n; k++) json_array_append_new(list, json_number(values[k]));
  return list;
}

json_t *json_text(const char *text) {
  json_t *value = json_string(text);
  if (value) return value;
  char *copy = format_text("%s", text);
  value = json_string(text_clean(copy));
  free(copy);
  return value;
}

json_t *json_messages(const sd_messages *messages) {
  json_t *list = json_array();
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    json_array_append_new(list,
                          json_pack("{s:s, s:o}", "kind",
                                    sd_messages_kind(messages, k) == SD_OK ? "warning" : "error",
                                    "text", json_text(sd_messages_text(messages, k))));
  return list;
}

json_t *json_observable(const observable *o, const void *row, size_t k) {
  double value = observable_value(o, row, k);
  if (o->type == OBSERVABLE_FLAG) return json_boolean(value != 0);
  return o->type == OBSERVABLE_F64 || !isfinite(value) ? json_number(value)
                                                       : json_integer((json_int_t)value);
}

json_t *json_elements(const observable *o, const void *row, size_t n) {
  json_t *list = json_array();
  for (size_t k = 0; k < n; k++) json_array_append_new(list, json_observable(o, row, k));
  return list;
}

void json_put(json_t *object, const char *name, json_t *value) {
  const char *dot = strchr(name, '.');
  if (dot) {
    char group[64] = "";
    strncat(group, name,
            (size_t)(dot - name) < sizeof group ? (size_t)(dot - name) : sizeof group - 1);
    if (!json_object_get(object, group)) json_object_set_new(object, group, json_object());
    object = json_object_get(object, group);
    name = dot + 1;
  }
  json_object_set_new(object, name, value);
}

void json_add(json_t *object, const observable_list *list, const void *row, size_t width,
              size_t k) {
  for (const observable *o = list->rows; o < list->rows + list->n; o++) {
    const char *name = o->json ? o->json : o->name;
    if (!*name || (width && o->width != width)) continue;
    json_put(object, name,
             width || o->width == 1 ? json_observable(o, row, k) : json_elements(o, row, o->width));
  }
}

json_t *json_row(const observable_list *list, const void *row) {
  json_t *object = json_object();
  json_add(object, list, row, 1, 0);
  return object;
}

json_t *json_rotations(const summary *found) {
  json_t *list = json_array();
  for (size_t k = 0; k < found->n_rotations; k++) {
    json_t *object = json_row(&rotation_observables, &found->rotations[k]);
    json_object_set_new(object, "name", json_text(found->rotation_names[k]));
    json_array_append_new(list, object);
  }
  return list;
}

json_t *json_averages(const summary *found) {
  json_t *list = json_array();
  for (size_t k = 0; k < found->n_averages; k++) {
    char *const *names = found->average_names + 3 * k;
    json_t *object = json_row(&average_observables, &found->averages[k]);
    json_object_set_new(object, "name", json_text(names[0]));
    json_object_set_new(object, "of", json_text(names[1]));
    json_object_set_new(object, "unit", json_text(names[2]));
    json_array_append_new(list, object);
  }
  return list;
}

sd_status json_print(const json_t *root) {
  const bool good = json_dumpf(root, stdout, JSON_INDENT(2)) == 0 && putchar('\n') != EOF;
  if (!good) fprintf(stderr, "error: cannot write to the standard output: %s\n", strerror(errno));
  return good ? SD_OK : SD_ERROR_IO;
}
