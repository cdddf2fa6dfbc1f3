/* frames.c: finds frames (stored configurations of all bodies) by number or time and reads them;
 * see frames.h. */
#include "io/results/frames.h"

#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "io/results/constants.h"
#include "model/cell.h"

#define DISKS "/particles/disks"
#define WALLS "/particles/walls"

/* Largest number of contacts of one frame that is accepted from a file. */
static const int64_t MOST_CONTACTS = 8 * (int64_t)LIMIT_DISKS;

/* Returns the number of rows of a dataset; 0: there is no such dataset. */
static size_t rows_of(const h5_file *file, const char *path) {
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  return h5_exists(file, path) && h5_shape(file, path, &rank, dims, NULL) == SD_OK ? dims[0] : 0;
}

/* --- Sources and list of frames --------------------------------------------------------------- */

/* Opens file number `source` of the files with frames; call release_source when done with it. */
static sd_status open_source(const frames *f, size_t source, h5_file **out, sd_messages *messages) {
  const char *path = f->sources[source].path;
  *out = f->base;
  if (strcmp(path, f->path) == 0) return SD_OK;
  /* The checksum of each file is verified only the first time, by add_source. */
  return f->sources[source].checked ? h5_open_again(path, out, messages)
                                    : h5_open(path, out, messages);
}

static void release_source(const frames *f, h5_file *file) {
  if (file != f->base) h5_close(file, NULL);
}

/* Appends a file to the list of files with frames, and counts its frames. */
static sd_status add_source(frames *f, const char *path, sd_messages *messages) {
  size_t k = f->n_sources;
  f->sources = memory_grow(f->sources, k + 1, sizeof *f->sources);
  f->sources[f->n_sources++] = (frame_source){.path = memory_text(path), .first = f->n};
  h5_file *file = NULL;
  sd_status status = open_source(f, k, &file, messages);
  if (status != SD_OK) return status;
  f->sources[k].checked = true;
  f->n += f->sources[k].n = rows_of(file, DISKS "/position/step");
  release_source(f, file);
  return SD_OK;
}

sd_status frames_open(frames *f, const char *base, size_t n_sources, const char *const *sources,
                      constants_deck_reader *read_deck, sd_messages *messages) {
  *f = (frames){.path = memory_text(base)};
  sd_status status = h5_open(base, &f->base, messages);
  if (status != SD_OK) return status;
  if (!h5_exists(f->base, "/state/id") || !h5_exists(f->base, "/summary"))
    return sd_fail(messages, SD_ERROR_USER,
                   "%s is not a result of slipdisk: there is no /state; expected a result, its "
                   "folder of parts, or a "
                   "part or checkpoint in it",
                   base);
  status = checkpoint_check_origin(f->base, base, messages);
  if (status != SD_OK) return status;
  f->state_time = h5_get_attr_f64(f->base, "/summary", "time", NAN);
  f->state_step = h5_get_attr_i64(f->base, "/summary", "step", -1);
  status = constants_read(f->base, base, read_deck, &f->constants, messages);
  for (size_t k = 0; status == SD_OK && k < n_sources; k++)
    status = add_source(f, sources[k], messages);
  return status;
}

void frames_close(frames *f) {
  h5_close(f->base, NULL);
  sd_model_free(f->constants);
  for (size_t k = 0; k < f->n_sources; k++) free(f->sources[k].path);
  free(f->sources);
  free(f->path);
  *f = (frames){0};
}

bool frames_is_part(const char *path) {
  h5_file *file = NULL;
  if (h5_open(path, &file, NULL) != SD_OK) return false;
  bool part = h5_has_attr(file, "/", "run_id") && !h5_exists(file, "/state");
  h5_close(file, NULL);
  return part;
}

sd_status frames_entry(const frames *f, size_t k, frame_entry *out, sd_messages *messages) {
  size_t source = 0;
  while (k >= f->sources[source].first + f->sources[source].n) source++;
  *out = (frame_entry){.source = source, .row = k - f->sources[source].first};
  h5_file *file = NULL;
  sd_status status = open_source(f, source, &file, messages);
  if (status != SD_OK) return status;
  status =
      h5_get_values(file, DISKS "/position/step", SD_I64, out->row, 1, 1, &out->step, messages);
  if (status == SD_OK)
    status =
        h5_get_values(file, DISKS "/position/time", SD_F64, out->row, 1, 1, &out->time, messages);
  release_source(f, file);
  return status;
}

sd_status frames_nearest(const frames *f, double time, size_t *nearest, sd_messages *messages) {
  /* Bisection, since times ascend: find the first frame that is not before `time`. The nearest
   * frame is that one, the one before it, or the final state. */
  size_t low = 0, high = f->n;
  frame_entry e;
  sd_status status = SD_OK;
  while (status == SD_OK && low < high) {
    size_t middle = low + (high - low) / 2;
    status = frames_entry(f, middle, &e, messages);
    if (e.time < time)
      low = middle + 1;
    else
      high = middle;
  }
  *nearest = f->n; /* index that stands for the final state */
  double off = fabs(f->state_time - time);
  for (size_t k = low < f->n ? low + 1 : f->n; status == SD_OK && k-- > (low > 0 ? low - 1 : 0);) {
    status = frames_entry(f, k, &e, messages);
    if (status != SD_OK || fabs(e.time - time) > off) continue;
    off = fabs(e.time - time);
    *nearest = k;
  }
  return status;
}

/* --- The state as a frame --------------------------------------------------------------------- */

/* File that is being read, and the first error that occurred. */
typedef struct reader {
  const h5_file *file;
  sd_status status;
  sd_messages *messages;
} reader;

/* Reads a column of the state; the caller frees it. */
static void *state_column(reader *r, const char *name, sd_type type, size_t n) {
  char path[64];
  snprintf(path, sizeof path, "/state/%s", name);
  return h5_column(r->file, path, type, n, &r->status, r->messages);
}

/* Copies poses and velocities of the bodies from the state of the file into a frame, sorted by body
 * number. */
static void state_bodies(reader *r, frame_data *f) {
  size_t n = f->n_bodies, n_free = rows_of(r->file, "/state/activity");
  uint32_t *id = state_column(r, "id", SD_U32, n);
  int32_t *activity = state_column(r, "activity", SD_I32, n_free);
  static const char *const names[] = {"x", "y", "vx", "vy", "omega", "theta", "turn"};
  enum { X, Y, VX, VY, OMEGA, THETA, TURN, COLUMNS };
  double *column[COLUMNS] = {0};
  for (int c = 0; c < COLUMNS; c++) column[c] = state_column(r, names[c], SD_F64, n);
  for (size_t k = 0; r->status == SD_OK && k < n; k++) {
    uint32_t body = id[k];
    if (body >= n || (k < n_free && body >= f->n_disks)) {
      r->status = sd_fail(r->messages, SD_ERROR_IO, "/state/id is damaged");
      break;
    }
    f->position[body][0] = column[X][k];
    f->position[body][1] = column[Y][k];
    f->velocity[body][0] = column[VX][k];
    f->velocity[body][1] = column[VY][k];
    f->spin[body] = column[OMEGA][k];
    f->angle[body] = column[TURN][k] + column[THETA][k];
    if (k < n_free) f->activity[body] = activity[k];
  }
  for (int c = 0; c < COLUMNS; c++) free(column[c]);
  free(activity);
  int32_t *image[2] = {state_column(r, "image_x", SD_I32, n),
                       state_column(r, "image_y", SD_I32, n)};
  for (size_t k = 0; r->status == SD_OK && k < n; k++)
    for (int c = 0; c < 2 && id[k] < f->n_disks; c++) f->image[id[k]][c] = image[c][k];
  free(image[0]);
  free(image[1]);
  free(id);
}

/* Reads the shape of a deforming periodic box from the state of the file. If the box does not
 * deform, these columns are empty or missing. */
static void state_cell(reader *r, const sd_model *m, frame_data *f) {
  double cell[CELL_COLUMNS], speed[CELL_COLUMNS];
  if (!h5_exists(r->file, "/state/cell") || rows_of(r->file, "/state/cell") != CELL_COLUMNS) return;
  r->status = h5_get(r->file, "/state/cell", SD_F64, CELL_COLUMNS, cell, r->messages);
  if (r->status == SD_OK)
    r->status = h5_get(r->file, "/state/cell_speed", SD_F64, CELL_COLUMNS, speed, r->messages);
  if (r->status != SD_OK) return;
  const sd_state s = {
      .box_scale = f->scale, .n_cell = CELL_COLUMNS, .cell = cell, .cell_speed = speed};
  for (int c = 0; c < 2; c++) f->stretch[c] = cell[c];
  f->offset = cell_offset(m, &s);
  cell_gradient_of(m, &s, f->gradient);
}

/* Reads only the activity of the disks (in play, waiting, removed) from the state of the file, for
 * a frame that does not store it. */
static void state_activity(reader *r, frame_data *f) {
  size_t n_free = rows_of(r->file, "/state/activity");
  uint32_t *id = state_column(r, "id", SD_U32, f->n_bodies);
  int32_t *activity = state_column(r, "activity", SD_I32, n_free);
  for (size_t k = 0; r->status == SD_OK && k < n_free && k < f->n_bodies; k++)
    if (id[k] < f->n_disks) f->activity[id[k]] = activity[k];
  free(id);
  free(activity);
}

/* Reads the contacts of the file's state into a frame. If the file does not store the tangential
 * force tau, tau = - k_t zeta. */
static void state_contacts(reader *r, const sd_model *m, frame_data *f) {
  size_t n = rows_of(r->file, "/state/contact_a");
  if (r->status == SD_OK) r->status = h5_check(r->file, "/state/contact_a", n, r->messages);
  if (r->status == SD_OK) r->status = frame_data_contacts(f, n, r->messages);
  if (r->status != SD_OK) return;
  const bool has_tau = n > 0 && h5_exists(r->file, "/state/contact_tau") &&
                       rows_of(r->file, "/state/contact_tau") == n;
  const char *zeta = has_tau                                     ? "/state/contact_tau"
                     : h5_exists(r->file, "/state/contact_zeta") ? "/state/contact_zeta"
                                                                 : "/state/contact_stretch";
  const struct {
    const char *path;
    sd_type type;
    void *data;
  } columns[] = {
      {"/state/contact_a", SD_U32, f->a},         {"/state/contact_b", SD_U32, f->b},
      {"/state/contact_part", SD_U32, f->part},   {"/state/contact_overlap", SD_F64, f->overlap},
      {"/state/contact_force", SD_F64, f->force}, {zeta, SD_F64, f->tau},
      {"/state/contact_slide", SD_I32, f->slide},
  };
  for (size_t k = 0; r->status == SD_OK && k < sizeof columns / sizeof *columns; k++)
    r->status = h5_get(r->file, columns[k].path, columns[k].type, n, columns[k].data, r->messages);
  /* columns that the laws of the run, or its version, may lack */
  const struct {
    const char *path;
    double *data;
  } more[] = {{"/state/contact_roll", f->roll},
              {"/state/contact_bond", f->bond},
              {"/state/contact_bond_pull", f->bond_pull},
              {"/state/contact_bond_shear", f->bond_shear}};
  for (size_t k = 0; r->status == SD_OK && k < sizeof more / sizeof *more; k++)
    if (has_tau && h5_exists(r->file, more[k].path) && rows_of(r->file, more[k].path) == n)
      r->status = h5_get(r->file, more[k].path, SD_F64, n, more[k].data, r->messages);
  for (size_t k = 0; r->status == SD_OK && k < n; k++) {
    if (f->a[k] >= m->n_disks || f->b[k] >= sd_model_bodies(m))
      r->status = sd_fail(r->messages, SD_ERROR_IO, "the contacts of the state are damaged");
    else if (!has_tau)
      f->tau[k] *=
          -sd_model_law(m, configuration_material(m, f->a[k]), configuration_material(m, f->b[k]))
               ->k_t;
  }
}

static sd_status read_state(const frames *f, frame_data *out, sd_messages *messages) {
  const sd_model *m = f->constants;
  reader r = {f->base, SD_OK, messages};
  size_t stored = rows_of(f->base, "/state/id");
  if (stored != sd_model_bodies(m))
    return sd_fail(messages, SD_ERROR_USER, "%s: the state has %zu bodies, its deck %zu", f->path,
                   stored, sd_model_bodies(m));
  r.status = frame_data_new(out, m->n_disks, m->n_walls, messages);
  out->step = f->state_step;
  out->time = f->state_time;
  if (r.status == SD_OK && h5_exists(f->base, "/state/box_scale"))
    r.status = h5_get(f->base, "/state/box_scale", SD_F64, 1, &out->scale, messages);
  if (r.status == SD_OK) state_cell(&r, m, out);
  if (r.status == SD_OK) state_bodies(&r, out);
  if (r.status == SD_OK) state_contacts(&r, m, out);
  return r.status;
}

/* --- Stored frames ---------------------------------------------------------------------------- */

/* Reads row `row` of the stored quantity `name` (such as "position"), for disks and then for walls,
 * into `data`, which has `width` numbers for each body. */
static sd_status frame_element(const h5_file *file, const char *name, size_t row, size_t width,
                               frame_data *f, double *data, sd_messages *messages) {
  sd_status status = SD_OK;
  for (int walls = 0; status == SD_OK && walls < 2; walls++) {
    size_t n = walls ? f->n_bodies - f->n_disks : f->n_disks, dims[H5_MAX_RANK] = {0};
    if (n == 0) continue;
    char path[96];
    int rank;
    snprintf(path, sizeof path, "%s/%s/value", walls ? WALLS : DISKS, name);
    status = h5_shape(file, path, &rank, dims, messages);
    if (status == SD_OK && (dims[1] != n || (width > 1 && dims[2] != width)))
      status = sd_fail(messages, SD_ERROR_IO, "%s does not have %zu bodies", path, n);
    if (status == SD_OK)
      status = h5_get_values(file, path, SD_F64, row, 1, n * width,
                             data + (walls ? f->n_disks * width : 0), messages);
  }
  return status;
}

/* Sets *first to the first row, in the long table of contacts, of those that row `row` of the
 * contact index describes. A finished result stores this number; in a part file it is the sum of
 * the counts before. */
static sd_status first_contact(const h5_file *file, size_t row, int64_t *first,
                               sd_messages *messages) {
  if (h5_exists(file, "/contacts/first"))
    return h5_get_values(file, "/contacts/first", SD_I64, row, 1, 1, first, messages);
  enum { BLOCK = 4096 };
  int64_t counts[BLOCK];
  sd_status status = SD_OK;
  *first = 0;
  for (size_t at = 0; status == SD_OK && at < row; at += BLOCK) {
    const size_t n = row - at < BLOCK ? row - at : BLOCK;
    status = h5_get_values(file, "/contacts/count", SD_I64, at, n, 1, counts, messages);
    for (size_t k = 0; status == SD_OK && k < n; k++) *first += counts[k];
  }
  return status;
}

/* Finds the contacts that were stored at this step: *rows rows of the long table of contacts, from
 * row *first on. Steps ascend; if contacts were stored several times at one step, the last ones are
 * taken. Returns false if there are none or after a failure. */
static bool find_table(const h5_file *file, int64_t step, int64_t *first, int64_t *rows,
                       sd_status *status, sd_messages *messages) {
  size_t low = 0, high = rows_of(file, "/contacts/step");
  int64_t at = -1;
  /* Bisection: find the first entry of the contact index with a later step. */
  while (*status == SD_OK && low < high) {
    size_t middle = low + (high - low) / 2;
    *status = h5_get_values(file, "/contacts/step", SD_I64, middle, 1, 1, &at, messages);
    if (at <= step)
      low = middle + 1;
    else
      high = middle;
  }
  if (*status != SD_OK || low == 0) return false;
  *status = h5_get_values(file, "/contacts/step", SD_I64, low - 1, 1, 1, &at, messages);
  if (*status != SD_OK || at != step) return false;
  *status = h5_get_values(file, "/contacts/count", SD_I64, low - 1, 1, 1, rows, messages);
  if (*status == SD_OK) *status = first_contact(file, low - 1, first, messages);
  return *status == SD_OK;
}

/* Reads the contacts at the step of the frame, if contacts were stored at that step. */
static sd_status frame_contacts(const h5_file *file, frame_data *f, sd_messages *messages) {
  sd_status status = SD_OK;
  int64_t first = 0, n = 0;
  if (!find_table(file, f->step, &first, &n, &status, messages) || status != SD_OK) return status;
  size_t stored = rows_of(file, "/contacts/a");
  if (first < 0 || n < 0 || n > MOST_CONTACTS || (uint64_t)first + (uint64_t)n > stored)
    return sd_fail(messages, SD_ERROR_IO,
                   "/contacts is damaged: the table of step %lld is not there", (long long)f->step);
  status = frame_data_contacts(f, (size_t)n, messages);
  if (status != SD_OK) return status;
  const struct {
    const char *path;
    sd_type type;
    void *data;
  } columns[] = {
      {"/contacts/a", SD_U32, f->a},           {"/contacts/b", SD_U32, f->b},
      {"/contacts/part", SD_U32, f->part},     {"/contacts/overlap", SD_F64, f->overlap},
      {"/contacts/force", SD_F64, f->force},   {"/contacts/tau", SD_F64, f->tau},
      {"/contacts/sliding", SD_I32, f->slide},
  };
  for (size_t k = 0; status == SD_OK && k < sizeof columns / sizeof *columns; k++)
    status = h5_get_values(file, columns[k].path, columns[k].type, (size_t)first, (size_t)n, 1,
                           columns[k].data, messages);
  const struct {
    const char *path;
    double *data;
  } bonds[] = {{"/contacts/bond", f->bond},
               {"/contacts/bond_pull", f->bond_pull},
               {"/contacts/bond_shear", f->bond_shear}};
  for (size_t k = 0; status == SD_OK && k < sizeof bonds / sizeof *bonds; k++)
    if (h5_exists(file, bonds[k].path))
      status = h5_get_values(file, bonds[k].path, SD_F64, (size_t)first, (size_t)n, 1,
                             bonds[k].data, messages);
  return status;
}

static sd_status read_frame(const frames *f, const h5_file *file, const frame_entry *e,
                            frame_data *out, sd_messages *messages) {
  const sd_model *m = f->constants;
  sd_status status = frame_data_new(out, m->n_disks, m->n_walls, messages);
  out->step = e->step;
  out->time = e->time;
  if (status == SD_OK)
    status = frame_element(file, "position", e->row, 2, out, &out->position[0][0], messages);
  if (status == SD_OK)
    status = frame_element(file, "velocity", e->row, 2, out, &out->velocity[0][0], messages);
  if (status == SD_OK) status = frame_element(file, "angle", e->row, 1, out, out->angle, messages);
  if (status == SD_OK)
    status = frame_element(file, "angular_velocity", e->row, 1, out, out->spin, messages);
  if (status == SD_OK && h5_exists(file, DISKS "/image/value"))
    status = h5_get_values(file, DISKS "/image/value", SD_I32, e->row, 1, 2 * out->n_disks,
                           out->image, messages);
  if (status == SD_OK && h5_exists(file, DISKS "/box/scale/value"))
    status =
        h5_get_values(file, DISKS "/box/scale/value", SD_F64, e->row, 1, 1, &out->scale, messages);
  if (status == SD_OK && h5_exists(file, DISKS "/box/rate/value")) {
    double edges[4];
    status = h5_get_values(file, DISKS "/box/rate/value", SD_F64, e->row, 1, SD_CELL_COMPONENTS,
                           out->gradient, messages);
    if (status == SD_OK)
      status = h5_get_values(file, DISKS "/box/edges/value", SD_F64, e->row, 1, 4, edges, messages);
    for (int c = 0; status == SD_OK && c < 2; c++)
      out->stretch[c] = edges[3 * c] / (out->scale * (m->upper[c] - m->lower[c]));
    if (status == SD_OK) out->offset = edges[2];
  }
  if (status == SD_OK && h5_exists(file, DISKS "/activity/value")) {
    status = h5_get_values(file, DISKS "/activity/value", SD_I32, e->row, 1, out->n_disks,
                           out->activity, messages);
  } else if (status == SD_OK) {
    reader r = {f->base, SD_OK, messages};
    state_activity(&r, out);
    status = r.status;
  }
  if (status == SD_OK) status = frame_contacts(file, out, messages);
  return status;
}

sd_status frames_read(const frames *f, size_t k, frame_data *out, sd_messages *messages) {
  *out = (frame_data){0};
  frame_entry e = {.step = f->state_step};
  sd_status status = k < f->n ? frames_entry(f, k, &e, messages) : SD_OK;
  if (status != SD_OK) return status;
  if (e.step == f->state_step) return read_state(f, out, messages);
  h5_file *file = NULL;
  status = open_source(f, e.source, &file, messages);
  if (status != SD_OK) return status;
  status = read_frame(f, file, &e, out, messages);
  release_source(f, file);
  return status;
}
