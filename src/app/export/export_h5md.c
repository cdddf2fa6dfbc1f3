/* export_h5md.c: writes H5MD 1.1 files in three dimensions, for programs that read no
 * two-dimensional ones. See export.h.
 *
 * The only group of particles is `trajectory`, the name that MDAnalysis expects. Each frame has a
 * row for each disk of the deck; the column `activity` marks disks that wait for their release or
 * were removed (1 or 2). Positions are wrapped into the box, and the edges of the box are a matrix
 * per frame, as MDAnalysis expects. The datasets that MDAnalysis reads have no attribute `unit`,
 * since it refuses units that it cannot translate. */
#include <stdlib.h>
#include <string.h>

#include "app/export/export.h"
#include "base/memory.h"
#include "version.h"

#define GROUP "/particles/trajectory"

typedef struct element {
  const char *name;
  sd_type type;
  size_t width; /* Number of components per disk: 3 for a vector, 0 for a scalar */
  const char *unit, *meaning;
} element;

enum { POSITION, VELOCITY, IMAGE, ANGLE, SPIN, ACTIVITY, ELEMENTS };
static const element elements[ELEMENTS] = {
    [POSITION] = {"position", SD_F64, 3, NULL,
                  "centre, in the box along periodic directions, z = 0; unit length"},
    [VELOCITY] = {"velocity", SD_F64, 3, NULL, "velocity of the centre; unit length/time"},
    [IMAGE] = {"image", SD_I32, 3, "1", "absolute position = position + image * edges"},
    [ANGLE] = {"angle", SD_F64, 0, "rad", "angle about z, counter-clockwise positive, not wrapped"},
    [SPIN] = {"angular_velocity", SD_F64, 0, "rad/time", "angular velocity about z"},
    [ACTIVITY] = {"activity", SD_I32, 0, "1",
                  "0 in play, 1 waiting, 2 removed, 3 outside the bounds"},
};

static char *path_of(char path[96], const char *name, const char *leaf) {
  snprintf(path, 96, GROUP "/%s/%s", name, leaf);
  return path;
}

static void describe(h5_file *file, const char *path, const char *unit, const char *meaning) {
  if (unit) h5_attr_text(file, path, "unit", unit);
  h5_attr_text(file, path, "description", meaning);
}

/* Makes datasets with space for all frames. All datasets share the steps and times of the positions
 * through links. */
static void make_elements(const export_job *job, h5_file *file) {
  char path[96], clock[96];
  size_t dims[3] = {job->range.n, job->m->n_disks, 3};
  bool boxed = job->m->periodic[0] || job->m->periodic[1];
  for (int k = 0; k < ELEMENTS; k++) {
    const element *e = &elements[k];
    dims[2] = e->width;
    h5_make(file, path_of(path, e->name, "value"), e->type, e->width ? 3 : 2, dims, true);
    describe(file, path, e->unit, e->meaning);
  }
  h5_make(file, path_of(path, "position", "step"), SD_I64, 1, dims, false);
  h5_make(file, path_of(path, "position", "time"), SD_F64, 1, dims, false);
  describe(file, path, NULL, "step * dt; unit time");
  const size_t box[3] = {job->range.n, 3, 3};
  if (boxed) h5_make(file, GROUP "/box/edges/value", SD_F64, 3, box, false);
  if (boxed)
    describe(file, GROUP "/box/edges/value", NULL,
             "edge vectors in rows; along open directions and z what holds all disks and walls; "
             "unit length");
  for (int k = VELOCITY; k <= ELEMENTS; k++) {
    const char *name = k < ELEMENTS ? elements[k].name : "box/edges";
    if (k == ELEMENTS && !boxed) break;
    h5_link(file, path_of(clock, "position", "step"), path_of(path, name, "step"));
    h5_link(file, path_of(clock, "position", "time"), path_of(path, name, "time"));
  }
  /* MDAnalysis reads only three of the quantities of particles, but all observables, which it puts
   * into Timestep.data: link these as observables. */
  h5_link(file, GROUP "/angle", "/observables/angle");
  h5_link(file, GROUP "/angular_velocity", "/observables/angular_velocity");
  h5_link(file, GROUP "/activity", "/observables/activity");
}

static void put_column(h5_file *file, const char *name, sd_type type, size_t n, const void *data,
                       const char *unit, const char *meaning) {
  char path[96];
  snprintf(path, sizeof path, GROUP "/%s", name);
  h5_put(file, path, type, 1, &n, data, true);
  describe(file, path, unit, meaning);
}

/* Writes the columns that are the same in all frames. room: scratch buffer of three doubles per
 * disk. */
static void put_constants(const export_job *job, h5_file *file, void *room) {
  const sd_model *m = job->m;
  size_t n = m->n_disks;
  double *real = room;
  int32_t *whole = room;
  for (size_t i = 0; i < n; i++) real[i] = m->disks[i].radius;
  put_column(file, "radius", SD_F64, n, real, "length", "radius");
  for (size_t i = 0; i < n; i++) real[i] = m->disks[i].mass;
  put_column(file, "mass", SD_F64, n, real, "mass", "mass");
  for (size_t i = 0; i < n; i++) real[i] = m->disks[i].inertia;
  put_column(file, "inertia", SD_F64, n, real, "mass length^2", "moment of inertia about z");
  for (size_t i = 0; i < n; i++) whole[i] = (int32_t)i;
  put_column(file, "id", SD_I32, n, whole, "1", "permanent number, as in the deck");
  for (size_t i = 0; i < n; i++) whole[i] = (int32_t)job->type_of[i] + 1;
  put_column(file, "species", SD_I32, n, whole, "1",
             "material, group, free or prescribed: /parameters/species");
  for (size_t i = 0; i < n; i++) whole[i] = m->disks[i].group;
  put_column(file, "group", SD_I32, n, whole, "1", "index of the group, -1: none");
}

static void put_head(const export_job *job, h5_file *file) {
  static const int64_t version[2] = {1, 1};
  const char *boundary[3] = {job->m->periodic[0] ? "periodic" : "none",
                             job->m->periodic[1] ? "periodic" : "none", "none"};
  const double lower[3] = {job->m->periodic[0] ? job->m->lower[0] : 0.0,
                           job->m->periodic[1] ? job->m->lower[1] : 0.0, 0.0};
  char *author = h5_get_attr_text(job->f->base, "/h5md/author", "name");
  h5_group(file, "/h5md/author");
  h5_group(file, "/h5md/creator");
  h5_attr(file, "/h5md", "version", SD_I64, 2, version);
  h5_attr_text(file, "/h5md/author", "name", author ? author : "unknown");
  h5_attr_text(file, "/h5md/creator", "name", "slipdisk export");
  h5_attr_text(file, "/h5md/creator", "version", SD_VERSION);
  free(author);
  h5_group(file, GROUP "/box");
  h5_attr_i64(file, GROUP "/box", "dimension", 3);
  h5_attr_texts(file, GROUP "/box", "boundary", 3, boundary);
  h5_attr(file, GROUP "/box", "lower", SD_F64, 3, lower);
  h5_group(file, "/parameters");
  h5_attr_text(file, "/parameters", "source", job->source);
  char **species = memory_new(job->n_types, sizeof *species);
  for (size_t k = 0; k < job->n_types; k++) species[k] = export_type_text(job, k);
  if (job->n_types > 0)
    h5_put_texts(file, "/parameters/species", job->n_types, (const char *const *)species);
  for (size_t k = 0; k < job->n_types; k++) free(species[k]);
  free(species);
  char *deck = h5_get_text(job->f->base, "/parameters/deck_full");
  if (deck) h5_put_text(file, "/parameters/deck_full", deck);
  free(deck);
}

/* --- frames ----------------------------------------------------------------------------------- */

static void put_row(h5_file *file, int which, size_t row, const void *data) {
  char path[96];
  h5_put_rows(file, path_of(path, elements[which].name, "value"), elements[which].type, row, 1,
              data);
}

static void put_frame(const export_job *job, h5_file *file, size_t row, const frame_data *f,
                      void *room) {
  size_t n = job->m->n_disks;
  double(*real)[3] = room;
  int32_t(*whole)[3] = room;
  char path[96];
  h5_put_rows(file, path_of(path, "position", "step"), SD_I64, row, 1, &f->step);
  h5_put_rows(file, path_of(path, "position", "time"), SD_F64, row, 1, &f->time);
  for (size_t i = 0; i < n; i++)
    memcpy(real[i], f->position[i], sizeof f->position[i]), real[i][2] = 0.0;
  put_row(file, POSITION, row, real);
  for (size_t i = 0; i < n; i++)
    memcpy(real[i], f->velocity[i], sizeof f->velocity[i]), real[i][2] = 0.0;
  put_row(file, VELOCITY, row, real);
  for (size_t i = 0; i < n; i++) memcpy(whole[i], f->image[i], sizeof f->image[i]), whole[i][2] = 0;
  put_row(file, IMAGE, row, room);
  put_row(file, ANGLE, row, f->angle);
  put_row(file, SPIN, row, f->spin);
  put_row(file, ACTIVITY, row, f->activity);
  if (!job->m->periodic[0] && !job->m->periodic[1]) return;
  export_space s = export_space_of(job, f);
  double edges[3][3] = {{0}};
  for (int c = 0; c < 3; c++) edges[c][c] = s.upper[c] - s.lower[c];
  edges[1][0] = s.offset;
  h5_put_rows(file, GROUP "/box/edges/value", SD_F64, row, 1, edges);
}

static sd_status put_frames(const export_job *job, h5_file *file, void *room) {
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < job->range.n && !h5_failed(file); k++) {
    frame_data frame;
    status = export_frame(job, k, &frame);
    if (status == SD_OK) put_frame(job, file, k, &frame, room);
    frame_data_free(&frame);
  }
  return status;
}

sd_status export_h5md(const export_job *job) {
  file_draft draft;
  h5_file *file = NULL;
  void *room = NULL;
  /* Number of bytes of one disk in one frame before compression */
  const double each = 3 * 8 + 3 * 8 + 3 * 4 + 8 + 8 + 4;
  double bytes = 0.6 * each * (double)job->m->n_disks * (double)job->range.n;
  sd_status status = file_draft_new(-1, job->out, &draft, job->messages);
  if (status == SD_OK) status = h5_create(&draft, (uint64_t)bytes, &file, job->messages);
  if (status == SD_OK && !memory_row(&room, job->m->n_disks, 3 * sizeof(double)))
    status = sd_fail(job->messages, SD_ERROR_IO, "no memory to export");
  if (status == SD_OK) {
    put_head(job, file);
    make_elements(job, file);
    put_constants(job, file, room);
    status = put_frames(job, file, room);
  }
  free(room);
  if (status == SD_OK)
    status = h5_finish(file, &draft, job->messages);
  else
    h5_close(file, NULL);
  if (status == SD_OK) return file_draft_publish(&draft, -1, job->out, FILE_REPLACE, job->messages);
  file_draft_drop(&draft);
  return status;
}
