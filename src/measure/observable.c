/* observable.c: reads, writes and prints measured quantities (see observable.h). */
#include "measure/observable.h"

#include <string.h>

#include "model/model.h"

sd_type observable_stored(const observable *o) {
  switch (o->type) {
    case OBSERVABLE_F64: return SD_F64;
    case OBSERVABLE_I64:
    case OBSERVABLE_SIZE: return SD_I64;
    case OBSERVABLE_U32: return SD_U32;
    case OBSERVABLE_I32:
    case OBSERVABLE_FLAG: break;
  }
  return SD_I32;
}

double observable_value(const observable *o, const void *row, size_t k) {
  if (o->get) return o->get(row, k);
  const void *at = (const char *)row + o->offset;
  switch (o->type) {
    case OBSERVABLE_F64: return ((const double *)at)[k];
    case OBSERVABLE_I64: return (double)((const int64_t *)at)[k];
    case OBSERVABLE_I32: return ((const int32_t *)at)[k];
    case OBSERVABLE_U32: return ((const uint32_t *)at)[k];
    case OBSERVABLE_SIZE: return (double)((const size_t *)at)[k];
    case OBSERVABLE_FLAG: break;
  }
  return ((const bool *)at)[k] ? 1 : 0;
}

/* Returns `value` if it is in [lower, upper), else 0: a damaged file may hold a number that the
 * integer type cannot. upper is the first value beyond the type. */
static double within(double value, double lower, double upper) {
  return value >= lower && value < upper ? value : 0.0;
}
static int64_t as_i64(double value) { return (int64_t)within(value, -0x1p63, 0x1p63); }
static int32_t as_i32(double value) { return (int32_t)within(value, -0x1p31, 0x1p31); }
static uint32_t as_u32(double value) { return (uint32_t)within(value, 0.0, 0x1p32); }
static size_t as_size(double value) { return (size_t)within(value, 0.0, 0x1p63); }

void observable_set(const observable *o, void *row, size_t k, double value) {
  if (o->get) return;
  void *at = (char *)row + o->offset;
  switch (o->type) {
    case OBSERVABLE_F64: ((double *)at)[k] = value; break;
    case OBSERVABLE_I64: ((int64_t *)at)[k] = as_i64(value); break;
    case OBSERVABLE_I32: ((int32_t *)at)[k] = as_i32(value); break;
    case OBSERVABLE_U32: ((uint32_t *)at)[k] = as_u32(value); break;
    case OBSERVABLE_SIZE: ((size_t *)at)[k] = as_size(value); break;
    case OBSERVABLE_FLAG: ((bool *)at)[k] = value != 0; break;
  }
}

double observable_element(sd_type type, const void *dense, size_t k) {
  switch (type) {
    case SD_F64: return ((const double *)dense)[k];
    case SD_I64: return (double)((const int64_t *)dense)[k];
    case SD_U32: return ((const uint32_t *)dense)[k];
    case SD_I32: break;
  }
  return ((const int32_t *)dense)[k];
}

void observable_store(const observable *o, void *dense, size_t k, double value) {
  switch (observable_stored(o)) {
    case SD_F64: ((double *)dense)[k] = value; break;
    case SD_I64: ((int64_t *)dense)[k] = as_i64(value); break;
    case SD_U32: ((uint32_t *)dense)[k] = as_u32(value); break;
    case SD_I32: ((int32_t *)dense)[k] = as_i32(value); break;
  }
}

size_t observable_width(const observable *o, const sd_model *model) {
  switch (o->width) {
    case OBSERVABLE_WATCHED: return model->n_rotations;
    case OBSERVABLE_WALLS: return model->n_walls;
    case OBSERVABLE_GROUPS: return model->n_groups;
    case OBSERVABLE_CHOSEN: return model->n_contact_disks;
    default: return o->width;
  }
}

const observable *observable_find(const observable_list *list, const char *name) {
  for (size_t k = 0; k < list->n; k++)
    if (strcmp(list->rows[k].name, name) == 0) return &list->rows[k];
  return NULL;
}

static bool has_columns(const observable_list *list) {
  bool any = false;
  for (size_t k = 0; k < list->n; k++) any = any || list->rows[k].column;
  return any;
}

void observable_print(FILE *out, const observable_list *list) {
  bool columns = has_columns(list);
  fprintf(out, "**%s**: %s\n\n| name | unit |%s meaning |\n|---|---|%s---|\n", list->name,
          list->title, columns ? " column |" : "", columns ? "---|" : "");
  for (size_t k = 0; k < list->n; k++) {
    const observable *o = &list->rows[k];
    fprintf(out, "| `%s` | %s | ", o->name, o->unit);
    if (o->column) fprintf(out, "`%s` | ", o->column);
    if (columns && !o->column) fprintf(out, "| ");
    for (const char *c = o->meaning; *c; c++) /* a plain | would end the table cell */
      fprintf(out, *c == '|' ? "\\|" : "%c", *c);
    fprintf(out, " |\n");
  }
  fputc('\n', out);
}
