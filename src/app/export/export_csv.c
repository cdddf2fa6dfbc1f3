/* export_csv.c: writes CSV tables (RFC 4180) of disks, contacts and series, and a table of their
 * units. See export.h. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "app/app.h"
#include "app/export/export.h"
#include "app/measure/measure.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

enum { DISKS, CONTACTS, SERIES, UNITS, TABLES };
static const char *const names[TABLES] = {"disks.csv", "contacts.csv", "series.csv", "units.csv"};

/* --- units ------------------------------------------------------------------------------------ */

static const struct column {
  const char *name, *unit, *meaning;
} disk_columns[] =
    {
        {"step", "1", "steps since the start"},
        {"time", "time", "step * dt"},
        {"disk", "1", "number in the deck"},
        {"x", "length", "centre, in the box along periodic directions"},
        {"y", "length", "centre"},
        {"theta", "rad", "angle, counter-clockwise positive, not wrapped"},
        {"vx", "length/time", "velocity"},
        {"vy", "length/time", "velocity"},
        {"omega", "rad/time", "angular velocity"},
        {"radius", "length", "radius"},
        {"mass", "mass", "mass"},
        {"inertia", "mass length^2", "moment of inertia"},
        {"fixed", "1", "1: fixed or driven"},
        {"material", "-", "name of the material"},
        {"group", "-", "name of the group"},
        {"image_x", "1",
         "periodic images crossed: absolute = x + image_x * width of the box + image_y * its "
         "offset"},
        {"image_y", "1", "periodic images crossed"},
},
  contact_columns[] = {
      {"step", "1", "steps since the start"},
      {"a", "1", "number of the disk"},
      {"b", "1", "number of the other body: disks, then walls"},
      {"part", "1", "straight piece of the wall"},
      {"x", "length", "point of contact"},
      {"y", "length", "point of contact"},
      {"nx", "1", "unit vector from a to b"},
      {"ny", "1", "unit vector from a to b"},
      {"overlap", "length", "overlap"},
      {"force", "force", "normal force, compression positive"},
      {"tau", "force", "tangential force; empty where contacts were not stored"},
      {"mobilised", "1", "abs(tau)/(mu force)"},
      {"sliding", "1", "0 stuck, 1, -1 sliding with that sign of tau"},
      {"force_x", "force", "force on b"},
      {"force_y", "force", "force on b"},
      {"zeta", "length", "tangential displacement"},
};
enum { DISK_COLUMNS = sizeof disk_columns / sizeof *disk_columns };
enum { CONTACT_COLUMNS = sizeof contact_columns / sizeof *contact_columns };

static void put_unit(FILE *out, const char *table, const char *name, const char *unit,
                     const char *meaning) {
  fprintf(out, "%s,", table);
  text_cell(out, name);
  fputc(',', out);
  text_cell(out, unit);
  fputc(',', out);
  text_cell(out, meaning);
  fputs("\n", out);
}

static void put_units(FILE *out) {
  fputs("table,column,unit,meaning\n", out);
  for (int k = 0; k < DISK_COLUMNS; k++)
    put_unit(out, "disks", disk_columns[k].name, disk_columns[k].unit, disk_columns[k].meaning);
  for (int k = 0; k < CONTACT_COLUMNS; k++)
    put_unit(out, "contacts", contact_columns[k].name, contact_columns[k].unit,
             contact_columns[k].meaning);
}

/* --- disks ------------------------------------------------------------------------------------ */

static void put_disks(const export_job *job, const frame_data *f, FILE *out) {
  const sd_model *m = job->m;
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (!export_has(job, f, i)) continue;
    fprintf(out, "%" PRId64 ",%.17g,%zu,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%d,",
            f->step, f->time, i, f->position[i][0], f->position[i][1], f->angle[i],
            f->velocity[i][0], f->velocity[i][1], f->spin[i], d->radius, d->mass, d->inertia,
            d->driven);
    text_cell(out, export_material(job, d->material));
    fputc(',', out);
    text_cell(out, export_group(job, d->group));
    fprintf(out, ",%d,%d\n", f->image[i][0], f->image[i][1]);
  }
}

static sd_status put_contacts(const export_job *job, const frame_data *f, FILE *out) {
  configuration c = {0};
  sd_status status = configuration_new(&c, job->m, f, job->messages);
  if (status == SD_OK) measure_contacts(out, &c, NULL);
  configuration_free(&c);
  return status;
}

/* --- series ----------------------------------------------------------------------------------- */

#define SERIES_CLOCK "/observables/kinetic_translation"
enum { BLOCK = 4096, MOST_SERIES = 128 };

typedef struct series {
  const observable *row[MOST_SERIES];
  char *path[MOST_SERIES];
  size_t width[MOST_SERIES], n;
  /* For each series a buffer of [BLOCK][width] values, as its rows are read BLOCK at a time */
  double *value[MOST_SERIES];
} series;

/* Finds the columns of the time series in the first file that has any, and allocates a buffer for
 * each column. */
static sd_status series_find(series *s, const h5_file *file, sd_messages *messages) {
  const observable_list *lists[] = {&energy_observables, &series_observables};
  for (size_t l = 0; l < 2; l++)
    for (size_t k = 0; k < lists[l]->n && s->n < MOST_SERIES; k++) {
      int rank;
      size_t dims[H5_MAX_RANK] = {0};
      char *path = format_text("/observables/%s/value", lists[l]->rows[k].name);
      if (!h5_exists(file, path)) {
        free(path);
        continue;
      }
      s->row[s->n] = &lists[l]->rows[k];
      s->path[s->n] = path;
      sd_status status = h5_shape(file, path, &rank, dims, messages);
      size_t width = rank > 1 ? dims[1] : 1;
      double **value = &s->value[s->n];
      s->width[s->n++] = width;
      if (status != SD_OK) return status;
      if (!memory_row(value, BLOCK * width, sizeof **value))
        return sd_fail(messages, SD_ERROR_IO, "no memory to export");
    }
  return SD_OK;
}

static void series_free(series *s) {
  for (size_t k = 0; k < s->n; k++) free(s->path[k]), free(s->value[k]);
  *s = (series){0};
}

/* Returns the name of the CSV column for element k of a quantity, such as "angle[upper]" with the
 * disk, wall or group of the element in brackets; the caller frees it. */
static char *element_name(const export_job *job, const observable *o, size_t k) {
  const sd_model *m = job->m;
  char text[32];
  const uint32_t body = stored_body(m, job->f->base, o, k);
  if (o->width == OBSERVABLE_GROUPS && *export_group(job, (int)k))
    return format_text("%s[%s]", o->name, export_group(job, (int)k));
  if (body < sd_model_bodies(m)) {
    const char *name = body < m->n_disks ? m->disks[body].name : m->walls[body - m->n_disks].name;
    return format_text("%s[%s]", o->name,
                       name ? name : sd_model_body_name(m, body, text, sizeof text));
  }
  return format_text("%s[%zu]", o->name, k);
}

static void series_head(const export_job *job, const series *s, FILE *out, FILE *units) {
  fputs("step,time", out);
  put_unit(units, "series", "step", "1", "steps since the start");
  put_unit(units, "series", "time", "time", "step * dt");
  for (size_t k = 0; k < s->n; k++)
    for (size_t i = 0; i < s->width[k]; i++) {
      char *name =
          s->row[k]->width == 1 ? memory_text(s->row[k]->name) : element_name(job, s->row[k], i);
      fputc(',', out);
      text_cell(out, name);
      put_unit(units, "series", name, s->row[k]->unit, s->row[k]->meaning);
      free(name);
    }
  fputc('\n', out);
}

/* Copies all rows of one result file to the CSV file, a block of rows at a time. */
static sd_status series_rows(const series *s, const h5_file *file, FILE *out,
                             sd_messages *messages) {
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  int64_t step[BLOCK];
  double time[BLOCK];
  sd_status status = h5_shape(file, SERIES_CLOCK "/step", &rank, dims, messages);
  for (size_t at = 0; status == SD_OK && at < dims[0] && !ferror(out); at += BLOCK) {
    size_t n = dims[0] - at < BLOCK ? dims[0] - at : BLOCK;
    status = h5_get_values(file, SERIES_CLOCK "/step", SD_I64, at, n, 1, step, messages);
    if (status == SD_OK)
      status = h5_get_values(file, SERIES_CLOCK "/time", SD_F64, at, n, 1, time, messages);
    for (size_t k = 0; status == SD_OK && k < s->n; k++)
      status = h5_get_values(file, s->path[k], SD_F64, at, n, s->width[k], s->value[k], messages);
    for (size_t r = 0; status == SD_OK && r < n; r++) {
      fprintf(out, "%" PRId64 ",%.17g", step[r], time[r]);
      for (size_t k = 0; k < s->n; k++)
        for (size_t i = 0; i < s->width[k]; i++) {
          double value = s->value[k][r * s->width[k] + i];
          fprintf(out, isfinite(value) ? ",%.17g" : ",", value);
        }
      fputc('\n', out);
    }
  }
  return status;
}

static sd_status put_series(const export_job *job, FILE *out, FILE *units) {
  const frames *f = job->f;
  series s = {0};
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < f->n_sources; k++) {
    h5_file *file;
    status = frames_source_open(f, k, &file, job->messages);
    if (status == SD_OK && h5_exists(file, SERIES_CLOCK "/step")) {
      if (s.n == 0) {
        status = series_find(&s, file, job->messages);
        if (status == SD_OK) series_head(job, &s, out, units);
      }
      if (status == SD_OK) status = series_rows(&s, file, out, job->messages);
    }
    frames_source_close(f, file);
  }
  series_free(&s);
  return status;
}

/* --- all tables ------------------------------------------------------------------------------- */

static void put_heads(FILE *const *out) {
  for (int k = 0; k < DISK_COLUMNS; k++)
    fprintf(out[DISKS], "%s%s", k ? "," : "", disk_columns[k].name);
  fprintf(out[DISKS], "\n");
  fprintf(out[CONTACTS], "%s\n", MEASURE_CONTACT_COLUMNS);
  put_units(out[UNITS]);
}

sd_status export_csv(const export_job *job) {
  file_folder folder;
  FILE *out[TABLES] = {NULL};
  sd_status status = file_folder_open(job->out, &folder, job->messages);
  for (int k = 0; status == SD_OK && k < TABLES; k++)
    if (!(out[k] = file_folder_new(&folder, names[k], job->messages))) status = SD_ERROR_IO;
  if (status == SD_OK) put_heads(out);
  for (size_t k = 0; status == SD_OK && k < job->range.n && !ferror(out[DISKS]); k++) {
    frame_data frame;
    status = export_frame(job, k, &frame);
    if (status == SD_OK) put_disks(job, &frame, out[DISKS]);
    if (status == SD_OK) status = put_contacts(job, &frame, out[CONTACTS]);
    frame_data_free(&frame);
  }
  if (status == SD_OK) status = put_series(job, out[SERIES], out[UNITS]);
  for (int k = 0; k < TABLES; k++) status = file_folder_end(&folder, out[k], status, job->messages);
  return file_folder_close(&folder, status, job->messages);
}
