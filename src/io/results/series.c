/* series.c: see series.h. */
#include "io/results/series.h"

#include <assert.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/members.h"

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

static void write_ids(h5_file *file, const char *path, size_t n, const uint32_t *id,
                      const char *meaning) {
  if (n == 0) return;
  h5_put(file, path, SD_U32, 1, &n, id, true);
  h5_attr_text(file, path, "description", meaning);
}

/* One name per line; "wall 3" without a name. */
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
