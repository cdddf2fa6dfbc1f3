/* trajectory.c: defines the columns of frames, contacts and time series, and fills their rows; see
 * trajectory.h. */
#include "io/results/trajectory.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/members.h"
#include "model/cell.h"

/* --- Bodies ----------------------------------------------------------------------------------- */

void trajectory_edges(const sd_model *model, double scale, double edges[2]) {
  for (int c = 0; c < 2; c++)
    edges[c] = model->periodic[c] ? scale * (model->upper[c] - model->lower[c]) : 0;
}

/* Computes the edge vectors (rows of `edges`) and the velocity gradient of a periodic box that
 * deforms. */
static void put_cell(const moment *now, double edges[2][2], double gradient[SD_CELL_COMPONENTS]) {
  const sd_model *m = now->model;
  for (int c = 0; c < 2; c++) edges[c][c] = cell_scale(now->state, c) * (m->upper[c] - m->lower[c]);
  edges[0][1] = 0.0;
  edges[1][0] = cell_offset(m, now->state);
  cell_gradient_of(m, now->state, gradient);
}

static void add_cell(table *t, bool walls) {
  const size_t square[2] = {2, 2}, three = SD_CELL_COMPONENTS;
  const char *edges =
      walls ? "/particles/walls/box/edges/value" : "/particles/disks/box/edges/value";
  const char *rate = walls ? "/particles/walls/box/rate/value" : "/particles/disks/box/rate/value";
  table_add(t, edges, SD_F64, 2, square, "length", "edges of the periodic box, one a row");
  table_add(t, rate, SD_F64, 1, &three, "1/time", "velocity gradient of the box: xx, yy, xy");
}

/* Returns true if the table of disks (or of walls, if `walls` is true) has this column. Columns
 * with a condition exist only for disks: walls are neither inserted nor removed. */
static bool has_row(const observable *o, const sd_model *model, bool walls) {
  return !o->when || (!walls && o->when(model));
}

void trajectory_add_bodies(table *t, const sd_model *model, const char *group, bool walls,
                           size_t n) {
  for (size_t k = 0; k < frame_observables.n; k++) {
    const observable *o = &frame_observables.rows[k];
    if (has_row(o, model, walls)) table_add_observable(t, group, o, "/value", n);
  }
}

size_t trajectory_put_bodies(table *t, size_t column, const moment *now, bool walls, size_t n,
                             const uint32_t *slots) {
  const size_t first = walls ? now->model->n_disks : 0;
  for (size_t k = 0; k < frame_observables.n; k++) {
    const observable *o = &frame_observables.rows[k];
    if (!has_row(o, now->model, walls)) continue;
    for (size_t i = 0; i < n; i++) {
      const uint32_t slot = slots ? slots[i] : slot_of(now->slots, (uint32_t)(first + i));
      table_put(t, column, i, o, &(moment_body){now->state, slot}, o->width);
    }
    column++;
  }
  return column;
}

void trajectory_new_bodies(table *t, const sd_model *model, bool walls, bool shared) {
  const char *group = walls ? "/particles/walls" : "/particles/disks";
  const size_t n = walls ? model->n_walls : model->n_disks, two = 2;
  t->compress = true;
  if (n == 0) return;
  table_add_clock(t, walls ? "/particles/walls/position" : "/particles/disks/position");
  if (!shared) trajectory_add_bodies(t, model, group, walls, n);
  if (!series_compresses(model)) return;
  const char *edges =
      walls ? "/particles/walls/box/edges/value" : "/particles/disks/box/edges/value";
  const char *scale =
      walls ? "/particles/walls/box/scale/value" : "/particles/disks/box/scale/value";
  if (cell_deforms(model))
    add_cell(t, walls);
  else
    table_add(t, edges, SD_F64, 1, &two, "length",
              "lengths of the periodic box, 0 where it is open");
  table_add(t, scale, SD_F64, 0, NULL, "1", "lengths of the region over those of the deck");
}

sd_status trajectory_sample_bodies(table *t, const moment *now, bool walls, bool shared,
                                   sd_messages *messages) {
  if (t->n_columns == 0) return SD_OK;
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  const sd_model *model = now->model;
  size_t column = table_put_clock(t, now->state->step, model->dt);
  if (!shared)
    column =
        trajectory_put_bodies(t, column, now, walls, walls ? model->n_walls : model->n_disks, NULL);
  if (series_compresses(model)) {
    double edges[2][2], gradient[SD_CELL_COMPONENTS];
    const bool deforms = cell_deforms(model);
    if (deforms) {
      put_cell(now, edges, gradient);
      memcpy(table_cell(t, column++), edges, sizeof edges);
      memcpy(table_cell(t, column++), gradient, sizeof gradient);
    } else {
      trajectory_edges(model, now->state->box_scale, table_cell(t, column++));
    }
    memcpy(table_cell(t, column++), &now->state->box_scale, sizeof now->state->box_scale);
  }
  assert(column == t->n_columns);
  table_commit(t, 1);
  return SD_OK;
}

/* --- Clumps ----------------------------------------------------------------------------------- */

void trajectory_new_clumps(table *t, const sd_model *model) {
  t->compress = true;
  if (model->n_clumps == 0) return;
  table_add_clock(t, "/particles/clumps/position");
  for (size_t k = 0; k < clump_observables.n; k++)
    table_add_observable(t, "/particles/clumps", &clump_observables.rows[k], "/value",
                         model->n_clumps);
}

sd_status trajectory_sample_clumps(table *t, const moment *now, sd_messages *messages) {
  if (t->n_columns == 0) return SD_OK;
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  size_t column = table_put_clock(t, now->state->step, now->model->dt);
  for (size_t k = 0; k < clump_observables.n; k++) {
    const observable *o = &clump_observables.rows[k];
    for (size_t i = 0; i < now->model->n_clumps; i++)
      table_put(t, column + k, i, o, &(moment_clump){now->state, i}, o->width);
  }
  table_commit(t, 1);
  return SD_OK;
}

/* --- Contacts --------------------------------------------------------------------------------- */

/* True if contact tables of this model have this column. */
static bool has_column(const sd_model *m, size_t k) {
  const observable *o = &contact_observables.rows[k];
  return !o->when || o->when(m);
}

void trajectory_add_contacts(table *rows, const sd_model *model, const char *group) {
  for (size_t k = 0; k < contact_observables.n; k++)
    if (has_column(model, k))
      table_add_observable(rows, group, &contact_observables.rows[k], "", 0);
}

void trajectory_put_contacts(table *rows, size_t column, const moment *now, size_t n,
                             const uint32_t *which) {
  for (size_t k = 0; k < contact_observables.n; k++) {
    if (!has_column(now->model, k)) continue;
    for (size_t c = 0; c < n; c++)
      table_put(rows, column, c, &contact_observables.rows[k],
                &(moment_contact){now->model, now->state, now->slots, which ? which[c] : c}, 1);
    column++;
  }
}

void trajectory_new_contacts(table *index, table *rows, const sd_model *model, bool shared) {
  rows->compress = true;
  table_add_clock(index, "/contacts");
  table_add(index, "/contacts/count", SD_I64, 0, NULL, "1", "closed contacts at this step");
  if (!shared) trajectory_add_contacts(rows, model, "/contacts");
}

sd_status trajectory_sample_contacts(table *index, table *rows, const moment *now, size_t count,
                                     sd_messages *messages) {
  const size_t n = rows->n_columns > 0 ? count : 0;
  sd_status status = table_reserve(index, 1, messages);
  if (status == SD_OK) status = table_reserve(rows, n, messages);
  if (status != SD_OK) return status;
  const int64_t all = (int64_t)count;
  memcpy(table_cell(index, table_put_clock(index, now->state->step, now->model->dt)), &all,
         sizeof all);
  table_commit(index, 1);
  if (n > 0) trajectory_put_contacts(rows, 0, now, n, NULL);
  table_commit(rows, n);
  return SD_OK;
}

/* --- Time series ------------------------------------------------------------------------------ */
void series_new(table *t, const sd_model *model) {
  table_add_clock(t, "/observables/kinetic_translation");
  const observable_list *lists[] = {&energy_observables, &series_observables};
  for (size_t l = 0; l < 2; l++)
    for (size_t k = 0; k < lists[l]->n; k++) {
      const observable *o = &lists[l]->rows[k];
      if (o->when && !o->when(model)) continue;
      size_t n = o->width == 1 ? 0 : observable_width(o, model);
      table_add_observable(t, "/observables", o, "/value", n);
    }
}

sd_status series_sample(table *t, const moment *now, sd_messages *messages) {
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  size_t column = table_put_clock(t, now->state->step, now->model->dt);
  for (size_t k = 0; k < energy_observables.n; k++)
    table_put(t, column++, 0, &energy_observables.rows[k], now->energy, 1);
  for (size_t k = 0; k < series_observables.n; k++) {
    const observable *o = &series_observables.rows[k];
    if (o->when && !o->when(now->model)) continue;
    size_t n = observable_width(o, now->model);
    const resultant *sums = series_resultants(o, now);
    if (!sums) table_put(t, column, 0, o, now, n);
    for (size_t i = 0; sums && i < n; i++) table_put(t, column, i, o, &sums[i], 1);
    column++;
  }
  assert(column == t->n_columns);
  table_commit(t, 1);
  return SD_OK;
}

/* Writes a list of n body numbers, unless n is 0. */
static void write_ids(h5_file *file, const char *path, size_t n, const uint32_t *id,
                      const char *meaning) {
  if (n == 0) return;
  h5_put(file, path, SD_U32, 1, &n, id, true);
  h5_attr_text(file, path, "description", meaning);
}

/* Writes the names of n walls or groups, one per line; a wall without a name is "wall 3". */
static void write_names(h5_file *file, const char *path, size_t n, const sd_model *m, bool walls) {
  char **lines = memory_new(n, sizeof *lines), text[32];
  for (size_t k = 0; k < n; k++) {
    const char *name = walls ? m->walls[k].name : m->groups[k];
    lines[k] = format_text(
        "%s", name ? name : sd_model_body_name(m, (uint32_t)(m->n_disks + k), text, sizeof text));
  }
  members_write_lines(file, path, n, lines);
  h5_attr_text(file, path, "description",
               walls ? "names of the walls, one per line, in the order of the columns wall_*"
                     : "names of the groups, one per line, in the order of the columns group_*");
  for (size_t k = 0; k < n; k++) free(lines[k]);
  free(lines);
}

void series_write_columns(h5_file *file, const sd_model *m) {
  write_ids(file, "/observables/watched_disks", m->n_rotations, m->rotations,
            "id of the disks whose angle and angular_velocity are here, in this order");
  write_ids(file, "/observables/contact_disks", m->n_contact_disks, m->contact_disks,
            "id of the disks of the columns disk_*, in this order");
  if (m->measure_walls) write_names(file, "/observables/walls", m->n_walls, m, true);
  if (m->measure_groups) write_names(file, "/observables/groups", m->n_groups, m, false);
}
