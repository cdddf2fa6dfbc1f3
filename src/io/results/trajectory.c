/* trajectory.c: see trajectory.h. */
#include "io/results/trajectory.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/results/constants.h"
#include "io/store/file.h"

/* --- bodies --------------------------------------------------------------------------------------- */

enum { STEP, TIME, POSITION, IMAGE, VELOCITY, ANGLE, SPIN, EDGES, SCALE, ACTIVITY, FRAME_COLUMNS };

static const struct element {
  const char *name;
  sd_type type;
  int components;
  const char *unit, *meaning;
} elements[FRAME_COLUMNS] = {
    [STEP] = {"position/step", SD_I64, 0, "1", "steps since the start"},
    [TIME] = {"position/time", SD_F64, 0, "time", "step * dt"},
    [POSITION] = {"position/value", SD_F64, 2, "length", "centre of a disk, pivot of a wall"},
    [IMAGE] = {"image/value", SD_I32, 2, "1", "periodic images crossed: absolute = position + image * edges"},
    [VELOCITY] = {"velocity/value", SD_F64, 2, "length/time", "velocity"},
    [ANGLE] = {"angle/value", SD_F64, 1, "rad", "angle, counter-clockwise positive, not wrapped"},
    [SPIN] = {"angular_velocity/value", SD_F64, 1, "rad/time", "spin, counter-clockwise positive"},
    [EDGES] = {"box/edges/value", SD_F64, 1, "length", "lengths of the periodic box, 0 where it is open"},
    [SCALE] = {"box/scale/value", SD_F64, 0, "1", "lengths of the region over those of the deck"},
    [ACTIVITY] = {"activity/value", SD_I32, 1, "1", "0 in play, 1 waiting, 2 removed, 3 outside the bounds"},
};

/* Some phase changes the lengths of the box. */
static bool box_changes(const sd_model *model) {
  for (size_t k = 0; k < model->n_phases; k++)
    if (model->phases[k].compress.asked) return true;
  return false;
}

/* Disks can wait, or be taken out. */
static bool activity_changes(const sd_model *model) { return model->n_rains > 0 || model->bounds.given; }

/* Columns that only some runs have. */
static bool has_column(const sd_model *model, bool walls, int column) {
  if (column == EDGES || column == SCALE) return box_changes(model);
  return column != ACTIVITY || (!walls && activity_changes(model));
}

static void box_edges(const sd_model *model, double scale, double edges[2]) {
  for (int c = 0; c < 2; c++) edges[c] = model->periodic[c] ? scale * (model->upper[c] - model->lower[c]) : 0;
}

static const char *group_of(bool walls) { return walls ? "/particles/walls" : "/particles/disks"; }

sd_status trajectory_new_bodies(table *t, const sd_model *model, bool walls, sd_messages *messages) {
  size_t n = walls ? model->n_walls : model->n_disks;
  t->compress = true;
  if (n == 0) return SD_OK;
  sd_status status = SD_OK;
  for (int k = 0; status == SD_OK && k < FRAME_COLUMNS; k++) {
    const struct element *e = &elements[k];
    size_t dims[2] = {n, 2};
    if (!has_column(model, walls, k)) continue;
    if (k == EDGES) dims[0] = 2;
    char *path = format_text("%s/%s", group_of(walls), e->name);
    status = path ? table_add(t, path, e->type, e->components, dims, e->unit, e->meaning, messages)
                  : sd_fail(messages, SD_ERROR_IO, "no memory for the results");
    free(path);
  }
  return status;
}

sd_status trajectory_sample_bodies(table *t, const sd_model *model, const sd_state *state, bool walls,
                                   const uint32_t *slots, sd_messages *messages) {
  if (t->n_columns == 0) return SD_OK;
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  double time = (double)state->step * model->dt;
  memcpy(table_cell(t, STEP), &state->step, sizeof state->step);
  memcpy(table_cell(t, TIME), &time, sizeof time);
  double *position = table_cell(t, POSITION), *velocity = table_cell(t, VELOCITY);
  double *angle = table_cell(t, ANGLE), *spin = table_cell(t, SPIN);
  int32_t *image = table_cell(t, IMAGE);
  size_t first = walls ? model->n_disks : 0, n = walls ? model->n_walls : model->n_disks;
  for (size_t k = 0; k < n; k++) {
    uint32_t slot = slots[first + k];
    position[2 * k] = state->x[slot];
    position[2 * k + 1] = state->y[slot];
    velocity[2 * k] = state->vx[slot];
    velocity[2 * k + 1] = state->vy[slot];
    image[2 * k] = state->image_x[slot];
    image[2 * k + 1] = state->image_y[slot];
    angle[k] = state->turn[slot] + state->theta[slot];
    spin[k] = state->omega[slot];
  }
  size_t next = EDGES; /* of the columns that not all runs have */
  if (box_changes(model)) {
    box_edges(model, state->box_scale, table_cell(t, next++));
    memcpy(table_cell(t, next++), &state->box_scale, sizeof state->box_scale);
  }
  if (has_column(model, walls, ACTIVITY)) {
    int32_t *activity = table_cell(t, next);
    for (size_t k = 0; k < n; k++)
      activity[k] = slots[k] < state->n_free ? state->activity[slots[k]] : SD_IN_PLAY;
  }
  table_commit(t, 1);
  return SD_OK;
}

/* --- contacts ------------------------------------------------------------------------------------- */

enum { A, B, PART, OVERLAP, FORCE, TORQUE, STRETCH, SLIDING, CONTACT_COLUMNS };

sd_status trajectory_new_contacts(table *index, table *rows, sd_messages *messages) {
  static const struct element columns[CONTACT_COLUMNS] = {
      [A] = {"/contacts/a", SD_U32, 0, "1", "body number of the disk"},
      [B] = {"/contacts/b", SD_U32, 0, "1", "body number of the partner, disk or wall"},
      [PART] = {"/contacts/part", SD_U32, 0, "1", "straight piece of the wall, 0 for round bodies"},
      [OVERLAP] = {"/contacts/overlap", SD_F64, 0, "length", "delta"},
      [FORCE] = {"/contacts/force", SD_F64, 0, "force", "normal force F_n, compression positive"},
      [TORQUE] = {"/contacts/tau", SD_F64, 0, "force",
                  "tangential force tau (eq. tau): torque on a over its radius"},
      [STRETCH] = {"/contacts/stretch", SD_F64, 0, "length", "lambda - lambda*"},
      [SLIDING] = {"/contacts/sliding", SD_I32, 0, "1", "0 stuck, +1/-1 sliding with that sign of tau"},
  };
  static const struct element indices[] = {
      {"/contacts/step", SD_I64, 0, "1", "steps since the start"},
      {"/contacts/time", SD_F64, 0, "time", "step * dt"},
      {"/contacts/count", SD_I64, 0, "1", "closed contacts at this step"},
  };
  sd_status status = SD_OK;
  rows->compress = true;
  for (size_t k = 0; status == SD_OK && k < sizeof indices / sizeof *indices; k++)
    status = table_add(index, indices[k].name, indices[k].type, 0, NULL, indices[k].unit, indices[k].meaning,
                       messages);
  for (size_t k = 0; status == SD_OK && k < CONTACT_COLUMNS; k++)
    status = table_add(rows, columns[k].name, columns[k].type, 0, NULL, columns[k].unit, columns[k].meaning,
                       messages);
  return status;
}

static int material_of(const sd_model *model, uint32_t body) {
  return body < model->n_disks ? model->disks[body].material : model->walls[body - model->n_disks].material;
}

sd_status trajectory_sample_contacts(table *index, table *rows, const sd_model *model, const sd_state *state,
                                     sd_messages *messages) {
  size_t n = state->n_contacts;
  sd_status status = table_reserve(index, 1, messages);
  if (status == SD_OK) status = table_reserve(rows, n, messages);
  if (status != SD_OK) return status;
  double time = (double)state->step * model->dt;
  int64_t count = (int64_t)n;
  memcpy(table_cell(index, 0), &state->step, sizeof state->step);
  memcpy(table_cell(index, 1), &time, sizeof time);
  memcpy(table_cell(index, 2), &count, sizeof count);
  table_commit(index, 1);
  if (n == 0) return SD_OK;

  memcpy(table_cell(rows, A), state->contact_a, n * sizeof(uint32_t));
  memcpy(table_cell(rows, B), state->contact_b, n * sizeof(uint32_t));
  memcpy(table_cell(rows, PART), state->contact_part, n * sizeof(uint32_t));
  memcpy(table_cell(rows, OVERLAP), state->contact_overlap, n * sizeof(double));
  memcpy(table_cell(rows, FORCE), state->contact_force, n * sizeof(double));
  memcpy(table_cell(rows, STRETCH), state->contact_zeta, n * sizeof(double));
  memcpy(table_cell(rows, SLIDING), state->contact_slide, n * sizeof(int32_t));
  double *tau = table_cell(rows, TORQUE);
  for (size_t k = 0; k < n; k++) {
    const sd_contact_law *law =
        sd_model_law(model, material_of(model, state->contact_a[k]), material_of(model, state->contact_b[k]));
    tau[k] = 0.0 - law->k_t * state->contact_zeta[k]; /* no -0 */
  }
  table_commit(rows, n);
  return SD_OK;
}

/* --- constants ------------------------------------------------------------------------------------ */

static void write_box(h5_file *file, const sd_model *model, const char *group) {
  char *box = format_text("%s/box", group), *edges = format_text("%s/box/edges", group);
  if (!h5_have(file, box && edges, group)) goto out;
  double lengths[2], lower[2];
  box_edges(model, 1.0, lengths);
  const char *boundary[2];
  for (int k = 0; k < 2; k++) {
    boundary[k] = model->periodic[k] ? "periodic" : "none";
    lower[k] = model->periodic[k] ? model->lower[k] : 0;
  }
  size_t two = 2;
  h5_group(file, box);
  h5_attr_i64(file, box, "dimension", 2);
  h5_attr_texts(file, box, "boundary", 2, boundary);
  if (!box_changes(model)) {
    h5_put(file, edges, SD_F64, 1, &two, lengths, false);
    h5_attr_text(file, edges, "unit", "length");
  }
  h5_attr(file, box, "lower", SD_F64, 2, lower);
out:
  free(box);
  free(edges);
}

/* One value per body: get(model, k, out). */
typedef void getter(const sd_model *model, size_t k, void *out);

static void disk_radius(const sd_model *m, size_t k, void *out) { *(double *)out = m->disks[k].radius; }
static void disk_mass(const sd_model *m, size_t k, void *out) { *(double *)out = m->disks[k].mass; }
static void disk_inertia(const sd_model *m, size_t k, void *out) { *(double *)out = m->disks[k].inertia; }
static void disk_material(const sd_model *m, size_t k, void *out) { *(int32_t *)out = m->disks[k].material; }
static void disk_group(const sd_model *m, size_t k, void *out) { *(int32_t *)out = m->disks[k].group; }
static void disk_id(const sd_model *m, size_t k, void *out) { (void)m, *(uint32_t *)out = (uint32_t)k; }
static void disk_driven(const sd_model *m, size_t k, void *out) { *(int32_t *)out = m->disks[k].driven; }
static void wall_id(const sd_model *m, size_t k, void *out) { *(uint32_t *)out = (uint32_t)(m->n_disks + k); }
static void wall_material(const sd_model *m, size_t k, void *out) { *(int32_t *)out = m->walls[k].material; }
static void wall_kind(const sd_model *m, size_t k, void *out) { *(int32_t *)out = (int32_t)m->walls[k].kind; }
static void wall_radius(const sd_model *m, size_t k, void *out) { *(double *)out = m->walls[k].radius; }
static void wall_points(const sd_model *m, size_t k, void *out) {
  *(int64_t *)out = (int64_t)m->walls[k].n_points;
}

static void write_constant(h5_file *file, const sd_model *model, const char *path, size_t n, sd_type type,
                           getter *get, const char *unit, const char *meaning) {
  size_t size = sd_type_size(type);
  char *data = calloc(n + 1, size);
  if (!h5_have(file, data, path)) return;
  for (size_t k = 0; k < n; k++) get(model, k, data + k * size);
  h5_put(file, path, type, 1, &n, data, true);
  h5_attr_text(file, path, "unit", unit);
  h5_attr_text(file, path, "description", meaning);
  free(data);
}

/* Names of bodies, one per line; only where somebody gave names. */
static void write_names(h5_file *file, const sd_model *model, const char *path, size_t first, size_t n) {
  size_t total = 1;
  bool named = false;
  for (size_t k = first; k < first + n; k++) {
    const char *name = k < model->n_disks ? model->disks[k].name : model->walls[k - model->n_disks].name;
    named = named || name;
    total += (name ? strlen(name) : 0) + 1;
  }
  if (!named) return;
  char *text = malloc(total);
  if (!h5_have(file, text, path)) return;
  char *at = text;
  for (size_t k = first; k < first + n; k++) {
    const char *name = k < model->n_disks ? model->disks[k].name : model->walls[k - model->n_disks].name;
    size_t length = name ? strlen(name) : 0;
    if (length > 0) memcpy(at, name, length);
    at += length;
    *at++ = '\n';
  }
  *at = 0;
  h5_put_text(file, path, text);
  h5_attr_text(file, path, "description", "names, one per line, in the order of id");
  free(text);
}

static void write_walls(h5_file *file, const sd_model *model) {
  size_t n = model->n_walls, total = 0;
  write_box(file, model, "/particles/walls");
  write_constant(file, model, "/particles/walls/id", n, SD_U32, wall_id, "1", "body number");
  write_constant(file, model, "/particles/walls/species", n, SD_I32, wall_material, "1",
                 "index of the material");
  write_constant(file, model, "/particles/walls/shape/kind", n, SD_I32, wall_kind, "1",
                 "0 line, 1 segment, 2 polyline, 3 circle");
  write_constant(file, model, "/particles/walls/shape/radius", n, SD_F64, wall_radius, "length",
                 "radius of a circle, else 0");
  write_constant(file, model, "/particles/walls/shape/count", n, SD_I64, wall_points, "1",
                 "points of each wall, one wall after the other");
  for (size_t k = 0; k < n; k++) total += model->walls[k].n_points;
  double *points = calloc(2 * total + 1, sizeof *points);
  if (!h5_have(file, points, "/particles/walls/shape/points")) return;
  double *at = points;
  for (size_t k = 0; k < n; k++)
    for (size_t p = 0; p < model->walls[k].n_points; p++) {
      *at++ = model->walls[k].points[p][0];
      *at++ = model->walls[k].points[p][1];
    }
  size_t dims[2] = {total, 2};
  h5_put(file, "/particles/walls/shape/points", SD_F64, 2, dims, points, true);
  h5_attr_text(file, "/particles/walls/shape/points", "unit", "length");
  h5_attr_text(file, "/particles/walls/shape/points", "description", "where the points stood in the deck");
  free(points);
  write_names(file, model, "/particles/walls/name", model->n_disks, n);
}

void trajectory_write_constants(h5_file *file, const sd_model *model) {
  size_t n = model->n_disks;
  if (n > 0) {
    const char *group = group_of(false);
    write_box(file, model, group);
    write_constant(file, model, "/particles/disks/id", n, SD_U32, disk_id, "1",
                   "permanent number, as in the deck");
    write_constant(file, model, "/particles/disks/radius", n, SD_F64, disk_radius, "length", "radius");
    write_constant(file, model, "/particles/disks/mass", n, SD_F64, disk_mass, "mass", "mass");
    write_constant(file, model, "/particles/disks/inertia", n, SD_F64, disk_inertia, "mass length^2",
                   "moment of inertia");
    write_constant(file, model, "/particles/disks/species", n, SD_I32, disk_material, "1",
                   "index of the material");
    write_constant(file, model, "/particles/disks/group", n, SD_I32, disk_group, "1",
                   "index of the group, -1: none");
    write_constant(file, model, "/particles/disks/driven", n, SD_I32, disk_driven, "1",
                   "1: prescribed, 0: free");
    write_names(file, model, "/particles/disks/name", 0, n);
  }
  if (model->n_walls > 0) write_walls(file, model);
  constants_write(file, model);
}
