/* ensemble.c: see ensemble.h. */
#include "run/ensemble.h"

#include <stdlib.h>

struct ensemble {
  size_t n;
  sd_simulation **members;
};

size_t ensemble_width(void) { return 8; }

bool ensemble_takes(const sd_model *model) { return model->n_free <= 4; }

bool ensemble_alike(const sd_model *a, const sd_model *b) {
  return a->n_disks == b->n_disks && a->n_phases == b->n_phases;
}

sd_status ensemble_new(size_t n, sd_simulation *const *members, ensemble **out, sd_messages *messages) {
  ensemble *e = calloc(1, sizeof *e);
  *out = e;
  if (e) e->members = calloc(n + 1, sizeof(sd_simulation *));
  if (!e || !e->members) {
    ensemble_free(e);
    *out = NULL;
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the ensemble");
  }
  e->n = n;
  for (size_t k = 0; k < n; k++) e->members[k] = members[k];
  return SD_OK;
}

void ensemble_free(ensemble *e) {
  if (!e) return;
  free(e->members);
  free(e);
}

void ensemble_advance(ensemble *e, int64_t n, sd_status *status, sd_messages *const *messages) {
  for (size_t k = 0; k < e->n; k++)
    if (status[k] == SD_OK) status[k] = sd_simulation_advance(e->members[k], n, messages[k]);
}

size_t ensemble_in_lanes(const ensemble *e) { return (void)e, 0; }
