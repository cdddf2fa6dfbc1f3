/* series.c: see series.h. */
#include "io/results/series.h"

#include <assert.h>

sd_status series_new(table *t, const sd_model *model, sd_messages *messages) {
  sd_status status = table_add_clock(t, "/observables/kinetic_translation", messages);
  const observable_list *lists[] = {&energy_observables, &series_observables};
  for (size_t l = 0; l < 2; l++)
    for (size_t k = 0; status == SD_OK && k < lists[l]->n; k++) {
      const observable *o = &lists[l]->rows[k];
      if (o->when && !o->when(model)) continue;
      size_t n = o->width == OBSERVABLE_WATCHED ? model->n_rotations : 0;
      status = table_add_observable(t, "/observables", o, "/value", n, messages);
    }
  return status;
}

sd_status series_sample(table *t, const moment *now, sd_messages *messages) {
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  size_t column = table_put_clock(t, now->state->step, now->model->dt);
  for (size_t k = 0; k < energy_observables.n; k++)
    table_put(t, column++, 0, &energy_observables.rows[k], now->energy, 1);
  for (size_t k = 0; k < series_observables.n; k++) {
    const observable *o = &series_observables.rows[k];
    if (!o->when || o->when(now->model))
      table_put(t, column++, 0, o, now, o->width == OBSERVABLE_WATCHED ? now->model->n_rotations : 1);
  }
  assert(column == t->n_columns);
  table_commit(t, 1);
  return SD_OK;
}
