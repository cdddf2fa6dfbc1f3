/* view_data.c: makes the JSON and the chunks of numbers for a page; see view.h. */
#include "app/view/view.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/model.h"
#include "version.h"

/* --- the run ---------------------------------------------------------------------------------- */

static json_t *pair(double a, double b) {
  const double values[2] = {a, b};
  return json_numbers(2, values);
}

/* Returns an array of the names of n things; JSON null if none of them has a name. */
static json_t *names_of(size_t n, const char *(*name)(const sd_model *m, size_t k),
                        const sd_model *m) {
  json_t *list = json_array();
  bool any = false;
  for (size_t k = 0; k < n; k++) {
    const char *text = name(m, k);
    any = any || text;
    json_array_append_new(list, text ? json_text(text) : json_null());
  }
  if (any || n == 0) return list;
  json_decref(list);
  return json_null();
}

static const char *disk_name(const sd_model *m, size_t k) { return m->disks[k].name; }
static const char *group_name(const sd_model *m, size_t k) { return m->groups[k]; }
static const char *material_name(const sd_model *m, size_t k) { return m->materials[k].name; }

/* Returns a wall as JSON, with its points for angle 0, relative to its pivot. */
static json_t *wall_json(const sd_wall *w) {
  static const char *const kinds[] = {[SD_WALL_LINE] = "line",
                                      [SD_WALL_SEGMENT] = "segment",
                                      [SD_WALL_POLYLINE] = "polyline",
                                      [SD_WALL_CIRCLE] = "circle",
                                      [SD_WALL_ARC] = "arc"};
  json_t *points = json_array();
  for (size_t k = 0; k < w->n_points; k++)
    json_array_append_new(points,
                          pair(w->points[k][0] - w->pivot[0], w->points[k][1] - w->pivot[1]));
  return json_pack("{s:o, s:s, s:o, s:b, s:b, s:i, s:o}", "name",
                   w->name ? json_text(w->name) : json_null(), "kind", kinds[w->kind], "radius",
                   json_number(w->radius), "closed", (int)w->closed, "inside", (int)w->inside,
                   "material", w->material, "points", points);
}

/* Returns a matrix with [k_n, k_t, gamma_n, mu] for each pair of materials, and null for pairs
 * without a contact law. */
static json_t *laws_json(const sd_model *m) {
  json_t *list = json_array();
  for (size_t a = 0; a < m->n_materials; a++) {
    json_t *row = json_array();
    for (size_t b = 0; b < m->n_materials; b++) {
      const sd_contact_law *law = sd_model_law(m, (int)a, (int)b);
      const double values[] = {law->k_n, law->k_t, law->gamma_n, law->mu};
      json_array_append_new(row, law->k_n > 0 ? json_numbers(4, values) : json_null());
    }
    json_array_append_new(list, row);
  }
  return list;
}

/* Returns the lower corner of the periodic box, which never moves; 0 along open directions. */
static json_t *lower_json(const sd_model *m) {
  return pair(m->periodic[0] ? m->lower[0] : 0, m->periodic[1] ? m->lower[1] : 0);
}

static json_t *edges_json(const sd_model *m, double scale, const double *stretch) {
  double edges[2] = {0};
  for (int c = 0; c < 2; c++)
    if (m->periodic[c])
      edges[c] = scale * (stretch ? stretch[c] : 1.0) * (m->upper[c] - m->lower[c]);
  return json_numbers(2, edges);
}

json_t *view_meta(const sd_model *m, const char *kind, const char *title, const char *source) {
  json_t *walls = json_array();
  for (size_t k = 0; k < m->n_walls; k++) json_array_append_new(walls, wall_json(&m->walls[k]));
  json_t *box =
      json_pack("{s:o, s:o, s:[b, b]}", "lower", lower_json(m), "edges", edges_json(m, 1.0, NULL),
                "periodic", (int)m->periodic[0], (int)m->periodic[1]);
  json_t *budget = json_pack(
      "{s:[s, s, s, s, s, s, s, s], s:[s, s, s], s:[s, s, s, s, s, s, s, s, s, s, s], s:s, s:s}",
      "stored", "kinetic_translation", "kinetic_rotation", "elastic_normal", "elastic_tangential",
      "elastic_rolling", "elastic_bond", "cohesion", "external", "supplied", "start", "work",
      "nonconservative_work", "lost", "viscous", "friction", "rolling", "bridge", "opening",
      "broken_tension", "broken_shear", "broken_bending", "drag", "damping", "relaxed", "residual",
      "residual", "scale", "scale");
  return json_pack("{s:i, s:o, s:o, s:s, s:s, s:o, s:o, s:I, s:o, s:o, s:o, s:o, s:o, s:[], s:o, "
                   "s:[], s:[], s:{}}",
                   "format", 1, "title", json_text(title ? title : ""), "source", json_text(source),
                   "kind", kind, "version", SD_VERSION, "box", box, "gravity",
                   json_numbers(2, m->gravity), "disks", (json_int_t)m->n_disks, "disk_names",
                   names_of(m->n_disks, disk_name, m), "groups",
                   names_of(m->n_groups, group_name, m), "materials",
                   names_of(m->n_materials, material_name, m), "walls", walls, "laws", laws_json(m),
                   "series", "budget", budget, "phases", "messages", "summary");
}

static void add_phase(json_t *meta, const char *name, double from, double to) {
  json_array_append_new(json_object_get(meta, "phases"),
                        json_pack("{s:o, s:o, s:o}", "name", json_text(name ? name : ""), "from",
                                  json_number(from), "to", json_number(to)));
}

void view_meta_phases(json_t *meta, const sd_model *m) {
  double from = 0;
  for (size_t k = 0; k < m->n_phases; k++) {
    double to = from + (double)m->phases[k].steps * m->dt;
    add_phase(meta, m->phases[k].name, from, to);
    from = to;
  }
}

void view_meta_summary(json_t *meta, const summary *s) {
  json_t *object = json_object_get(meta, "summary");
  int64_t step = 0;
  for (size_t k = 0; k < s->n_stages && step <= s->step; k++) {
    bool over = s->stages[k].steps > 0;
    int64_t end = over ? step + s->stages[k].steps : s->step;
    add_phase(meta, s->stage_names[k], (double)step * s->dt, (double)end * s->dt);
    step = over ? end : s->step + 1;
  }
  json_object_set_new(object, "dt", json_number(s->dt));
  json_object_set_new(object, "steps", json_integer((json_int_t)s->step));
  json_object_set_new(object, "residual", json_number(s->energy.residual / s->energy.scale));
  json_t *means = json_array();
  for (size_t k = 0; k < s->n_rotations; k++)
    json_array_append_new(
        means, json_pack("{s:I, s:s, s:o, s:o}", "disk", (json_int_t)s->rotations[k].disk, "name",
                         s->rotation_names[k], "omega", json_number(s->rotations[k].omega), "error",
                         json_number(s->rotations[k].error)));
  json_object_set_new(object, "rotation", means);
  json_t *averages = json_array();
  for (size_t k = 0; k < s->n_averages; k++)
    json_array_append_new(averages,
                          json_pack("{s:o, s:o, s:o}", "name", json_text(s->average_names[3 * k]),
                                    "mean", json_number(s->averages[k].mean), "error",
                                    json_number(s->averages[k].error)));
  json_object_set_new(object, "averages", averages);
}

/* --- columns ---------------------------------------------------------------------------------- */

/* Returns the step to whose multiples positions are rounded: a power of two near 1e-4 of the
 * smallest radius. Returns 0, no rounding, if there are few disks. */
static double grain(const sd_model *m) {
  double least = HUGE_VAL;
  for (size_t k = 0; k < m->n_disks; k++) least = fmin(least, m->disks[k].radius);
  return m->n_disks > VIEW_FEW && least > 0 && isfinite(least) ? exp2(floor(log2(1e-4 * least)))
                                                               : 0;
}

/* Adds the mean angular velocity of each of n disks and its error. omega, error: scratch buffers
 * for n numbers each. */
static void add_means(view_chunk *c, size_t n, const summary_disks *found, double *omega,
                      double *error) {
  for (size_t k = 0; k < n; k++) omega[k] = error[k] = NAN;
  for (size_t k = 0; k < found->n; k++) {
    const sd_disk_mean *d = &found->disks[k];
    if (d->disk >= n) continue;
    omega[d->disk] = d->omega;
    error[d->disk] = d->error;
  }
  view_chunk_add(c, "omega", VIEW_REAL, SD_F64, omega, n, 1);
  view_chunk_add(c, "omega_error", VIEW_REAL, SD_F64, error, n, 1);
}

static double first_angle(const sd_model *m, const double *first, size_t k) {
  return first ? first[k] : m->disks[k].position[SD_THETA];
}

void view_static(view_chunk *c, const sd_model *m, const double *first, const summary_disks *found,
                 bool shuffle) {
  view_chunk_begin(c, shuffle);
  size_t n = m->n_disks;
  double *real, *error;
  int32_t *whole;
  c->failed = !memory_rows(3, (memory_column[]){{&real, n, sizeof *real},
                                                {&error, n, sizeof *error},
                                                {&whole, n, sizeof *whole}});
  if (c->failed) return;
  for (int column = 0; column < 5; column++) {
    static const char *const names[] = {"radius", "mass", "group", "material", "driven"};
    for (size_t k = 0; k < n; k++) {
      const sd_disk *d = &m->disks[k];
      real[k] = column == 0 ? d->radius : d->mass;
      whole[k] = column == 2 ? d->group : column == 3 ? d->material : d->driven;
    }
    if (column < 2)
      view_chunk_add(c, names[column], VIEW_REAL, SD_F64, real, n, 1);
    else
      view_chunk_add(c, names[column], VIEW_WHOLE, SD_I32, whole, n, 1);
  }
  /* Subtract whole turns from the angles: the mark on a disk looks the same. */
  for (size_t k = 0; k < n; k++) real[k] = remainder(first_angle(m, first, k), 2 * M_PI);
  view_chunk_add(c, "angle", VIEW_REAL, SD_F64, real, n, 1);
  if (found && found->n > 0 && found->disks) add_means(c, n, found, real, error);
  free(real);
  free(error);
  free(whole);
}

void view_turns(frame_data *f, const sd_model *m, const double *first) {
  for (size_t k = 0; k < m->n_disks; k++) f->angle[k] -= first_angle(m, first, k);
}

static void add_contacts(view_chunk *c, const frame_data *f, view_form form) {
  size_t n = f->n_contacts;
  view_chunk_add(c, "contact_a", VIEW_WHOLE, SD_U32, f->a, n, 1);
  view_chunk_add(c, "contact_b", VIEW_WHOLE, SD_U32, f->b, n, 1);
  view_chunk_add(c, "contact_part", VIEW_WHOLE, SD_U32, f->part, n, 1);
  view_chunk_add(c, "contact_force", form, SD_F64, f->force, n, 1);
  view_chunk_add(c, "contact_tau", form, SD_F64, f->tau, n, 1);
  view_chunk_add(c, "contact_overlap", form, SD_F64, f->overlap, n, 1);
  view_chunk_add(c, "contact_sliding", VIEW_WHOLE, SD_I32, f->slide, n, 1);
  bool any = false;
  for (size_t k = 0; k < n; k++) any = any || f->bond[k] > 0.0;
  if (any) view_chunk_add(c, "contact_bond", VIEW_SHORT, SD_F64, f->bond, n, 1);
}

void view_frame(view_chunk *c, const sd_model *m, const frame_data *f, bool shuffle) {
  view_chunk_begin(c, shuffle);
  json_t *head = json_pack("{s:o, s:I, s:o, s:o, s:o, s:o}", "time", json_number(f->time), "step",
                           (json_int_t)f->step, "lower", lower_json(m), "edges",
                           edges_json(m, f->scale, f->stretch), "offset", json_number(f->offset),
                           "scale", json_number(f->scale));
  json_object_update_new(c->head, head);
  size_t n = m->n_disks, walls = m->n_walls;
  view_form form = n > VIEW_FEW ? VIEW_SHORT : VIEW_REAL;
  c->grain = grain(m);
  view_chunk_add(c, "x", VIEW_REAL, SD_F64, &f->position[0][0], n, 2);
  view_chunk_add(c, "y", VIEW_REAL, SD_F64, &f->position[0][1], n, 2);
  /* Round angles to about 0.001 rad, the smallest difference that can be seen. */
  c->grain = n > VIEW_FEW ? 0x1p-10 : 0;
  view_chunk_add(c, "turned", VIEW_REAL, SD_F64, f->angle, n, 1);
  c->grain = 0;
  view_chunk_add(c, "spin", form, SD_F64, f->spin, n, 1);
  view_chunk_add(c, "vx", form, SD_F64, &f->velocity[0][0], n, 2);
  view_chunk_add(c, "vy", form, SD_F64, &f->velocity[0][1], n, 2);
  bool all = true;
  for (size_t k = 0; k < n; k++) all = all && f->activity[k] == SD_IN_PLAY;
  if (!all) view_chunk_add(c, "activity", VIEW_WHOLE, SD_I32, f->activity, n, 1);
  if (walls > 0) {
    view_chunk_add(c, "wall_x", VIEW_EXACT, SD_F64, &f->position[n][0], walls, 2);
    view_chunk_add(c, "wall_y", VIEW_EXACT, SD_F64, &f->position[n][1], walls, 2);
    view_chunk_add(c, "wall_angle", VIEW_EXACT, SD_F64, &f->angle[n], walls, 1);
  }
  if (f->has_contacts) add_contacts(c, f, form);
}

#define CLOCK "/observables/kinetic_translation/time"
/* Largest number of elements of one quantity; largest number of values read from a file at once */
enum { MOST_ELEMENTS = 32, BLOCK = 1 << 16 };

/* Reader of the time series in all files of a run, which have n rows together. Rows 0, every, 2
 * every, ... and the last row are kept. */
typedef struct reader {
  const frames *f;
  size_t n, every, kept;
  size_t rows[2]; /* Not used */
  sd_status status;
  sd_messages *messages;
} reader;

static size_t rows_of(const h5_file *file, const char *path, size_t *width) {
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  if (!h5_exists(file, path) || h5_shape(file, path, &rank, dims, NULL) != SD_OK) return 0;
  *width = rank > 1 ? dims[1] : 1;
  return dims[0];
}

/* Opens file k of the files that have time series; close it with frames_source_close. NULL: the
 * file cannot be opened, and r->status is set. */
static h5_file *open_source(reader *r, size_t k) {
  h5_file *file;
  r->status = frames_source_open(r->f, k, &file, r->messages);
  return file;
}

/* Reads the n rows of one file and copies the kept ones to values[][width], beginning at
 * values[at]. before: number of rows in earlier files. Returns the index in values[] at which the
 * rows of the next file begin. */
static size_t read_rows(reader *r, const h5_file *file, const char *path, size_t before, size_t n,
                        size_t width, size_t at, double *values) {
  size_t block = BLOCK / width > 0 ? BLOCK / width : 1;
  double *rows = memory_grow(NULL, block * width, sizeof *rows);
  for (size_t first = 0; r->status == SD_OK && first < n; first += block) {
    size_t have = n - first < block ? n - first : block;
    r->status = h5_get_values(file, path, SD_F64, first, have, width, rows, r->messages);
    for (size_t k = 0; r->status == SD_OK && k < have; k++) {
      size_t row = before + first + k;
      if (row % r->every != 0 && row + 1 != r->n) continue;
      memcpy(values + at++ * width, rows + k * width, width * sizeof *rows);
    }
  }
  free(rows);
  return at;
}

/* Returns the kept rows of a dataset from all files, which the caller frees; rows missing in a file
 * are NAN. NULL: out of memory. */
static double *read_all(reader *r, const char *path, size_t width) {
  double *values;
  if (!memory_row(&values, r->kept * width, sizeof *values)) {
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for the series");
    return NULL;
  }
  size_t before = 0, at = 0;
  for (size_t k = 0; r->status == SD_OK && k < r->f->n_sources; k++) {
    h5_file *file = open_source(r, k);
    size_t columns = width, n = file ? rows_of(file, path, &columns) : 0;
    if (r->status == SD_OK && columns != width)
      r->status = sd_fail(r->messages, SD_ERROR_IO, "%s: %s does not have %zu columns",
                          r->f->sources[k].path, path, width);
    if (r->status == SD_OK && before + n > r->n)
      r->status =
          sd_fail(r->messages, SD_ERROR_IO, "%s: %s is too long", r->f->sources[k].path, path);
    if (r->status == SD_OK && n > 0) at = read_rows(r, file, path, before, n, width, at, values);
    before += n;
    frames_source_close(r->f, file);
  }
  for (size_t k = at; k < r->kept * (width > 0); k++)
    for (size_t c = 0; c < width; c++) values[k * width + c] = NAN;
  return values;
}

static const char *section_of(const observable *o, bool energy) {
  if (energy) return "energy";
  if (o->width == OBSERVABLE_WALLS) return "walls";
  if (o->width == OBSERVABLE_GROUPS) return "groups";
  if (o->width == OBSERVABLE_CHOSEN || o->width == OBSERVABLE_WATCHED) return "disks";
  return strstr(o->name, "contacts") || strcmp(o->name, "outside") == 0 ? "contacts" : "region";
}

static void describe(json_t *meta, const observable *o, bool energy, const char *name) {
  json_array_append_new(json_object_get(meta, "series"),
                        json_pack("{s:o, s:s, s:s, s:s}", "name", json_text(name), "unit", o->unit,
                                  "description", o->meaning, "section", section_of(o, energy)));
}

/* Returns the name of the time series for element k of quantity `o`, such as "contacts",
 * "angle[upper]" or "wall_force_x[3]"; the caller frees it. */
static char *series_name(const sd_model *m, const h5_file *file, const observable *o, size_t k) {
  if (o->width == 1) return memory_text(o->name);
  uint32_t body = stored_body(m, file, o, k);
  const char *name = NULL;
  if (o->width == OBSERVABLE_GROUPS && k < m->n_groups) name = m->groups[k];
  if (body < m->n_disks) name = m->disks[body].name;
  if (body >= m->n_disks && body < sd_model_bodies(m)) name = m->walls[body - m->n_disks].name;
  if (name) return format_text("%s[%s]", o->name, name);
  return format_text("%s[%" PRIu32 "]", o->name, body < m->n_disks ? body : (uint32_t)k);
}

void view_series_each(const sd_model *m, json_t *meta, view_series_visitor *visit, void *user) {
  const observable_list *lists[] = {&energy_observables, &series_observables};
  size_t column = 2; /* Skip columns 0 and 1, step and time */
  for (size_t l = 0; l < 2; l++)
    for (const observable *o = lists[l]->rows; o < lists[l]->rows + lists[l]->n; o++) {
      if (o->when && !o->when(m)) continue;
      size_t width = observable_width(o, m);
      for (size_t k = 0; k < width && k < MOST_ELEMENTS; k++) {
        char *name = series_name(m, NULL, o, k);
        if (meta) describe(meta, o, l == 0, name);
        if (visit) visit(user, o, column, k, name);
        free(name);
      }
      column++;
    }
}

static void add_series(reader *r, view_chunk *c, json_t *meta, const observable *o, bool energy) {
  size_t width = 1;
  char path[96];
  snprintf(path, sizeof path, "/observables/%s/value", o->name);
  h5_file *file = open_source(r, 0);
  bool there = file && rows_of(file, path, &width) > 0 && width > 0;
  frames_source_close(r->f, file);
  if (!there || r->status != SD_OK) return;
  double *values = read_all(r, path, width);
  for (size_t k = 0; r->status == SD_OK && k < width && k < MOST_ELEMENTS; k++) {
    char *name = series_name(r->f->constants, r->f->base, o, k);
    view_chunk_add(c, name, VIEW_EXACT, SD_F64, values + k, r->kept, width);
    describe(meta, o, energy, name);
    free(name);
  }
  free(values);
}

sd_status view_series_read(view_chunk *c, const frames *f, json_t *meta, size_t *rows,
                           sd_messages *messages) {
  reader r = {.f = f, .messages = messages};
  *rows = 0;
  for (size_t k = 0; r.status == SD_OK && k < f->n_sources; k++) {
    size_t width;
    h5_file *file = open_source(&r, k);
    if (file) r.n += rows_of(file, CLOCK, &width);
    frames_source_close(f, file);
  }
  if (r.status != SD_OK || r.n == 0) return r.status;
  r.every = (r.n + VIEW_MOST_ROWS - 1) / VIEW_MOST_ROWS;
  r.kept = (r.n - 1) / r.every + 1 + ((r.n - 1) % r.every != 0);
  view_chunk_begin(c, true);
  double *time = read_all(&r, CLOCK, 1);
  if (r.status == SD_OK) view_chunk_add(c, "time", VIEW_EXACT, SD_F64, time, r.kept, 1);
  free(time);
  const observable_list *lists[] = {&energy_observables, &series_observables};
  for (size_t l = 0; l < 2; l++)
    for (size_t k = 0; r.status == SD_OK && k < lists[l]->n; k++)
      add_series(&r, c, meta, &lists[l]->rows[k], l == 0);
  json_object_set_new(
      meta, "series_rows",
      json_pack("{s:I, s:I}", "stored", (json_int_t)r.n, "every", (json_int_t)r.every));
  *rows = r.kept;
  if (r.status != SD_OK) view_chunk_drop(c);
  return r.status;
}
