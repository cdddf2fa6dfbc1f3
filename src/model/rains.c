/* rains.c: see rains.h. */
#include "model/rains.h"

#include <math.h>

#include "model/clumps.h"
#include "model/rows.h"

/* A disk of rain k is free, waits, and fits. */
static void check_raining(const sd_model *m, size_t k, size_t row, sd_messages *msg) {
  const sd_rain *r = &m->rains[k];
  const sd_disk *d = rows_disk(m, row);
  const uint32_t i = rows_number(m, row);
  const double radius = i < model_held(m) ? clumps_grain(m, i, r->first + r->count).radius : d->radius;
  char name[96];
  sd_model_body_name(m, i, name, sizeof name);
  if (!d->waiting || d->driven)
    sd_fail(msg, SD_ERROR_USER, "%s: expected a free disk that waits for rains[%zu]", name, k);
  if (!(2.0 * radius <= r->upper - r->lower))
    sd_fail(msg, SD_ERROR_USER, "%s: radius = %g: it does not fit into rain %g wide", name, d->radius,
            r->upper - r->lower);
}

void rains_check(const sd_model *m, sd_messages *msg) {
  char name[96], motion[96];
  const size_t held = model_held(m), n = rows_count(m);
  int64_t counts[2] = {0}; /* that wait, that belong to rain */
  for (size_t row = rows_first(m); row < n; row++) counts[0] += rows_disk(m, row)->waiting;
  for (size_t k = 0; k < m->n_rains; k++) {
    const sd_rain *r = &m->rains[k];
    const size_t end = r->first + r->count;
    if (r->count < 1 || end > m->n_disks || r->batch < 1 || r->interval < 1)
      sd_fail(msg, SD_ERROR_USER, "rains[%zu]: expected disks that exist, a batch and an interval >= 1", k);
    if (!(r->gap >= 0.0) || !isfinite(r->gap) || !isfinite(r->speed) || !isfinite(r->floor))
      sd_fail(msg, SD_ERROR_USER, "rains[%zu]: expected a gap >= 0, and a speed and a floor", k);
    for (size_t row = r->first < held ? r->first : held; row < n; row++) {
      const uint32_t i = rows_number(m, row);
      if (i >= end && row < held) row = held - 1; /* the others are not held */
      if (i < r->first || i >= end) continue;
      counts[1] += row >= rows_first(m);
      check_raining(m, k, row, msg);
    }
  }
  comm_add(m->comm, counts, 2);
  if (counts[0] != counts[1])
    sd_fail(msg, SD_ERROR_USER, "%lld disks wait, %lld belong to rain: expected each to belong to one",
            (long long)counts[0], (long long)counts[1]);
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      uint32_t body = m->motions[k].bodies[b];
      if (body < held && m->disks[body].waiting)
        sd_fail(msg, SD_ERROR_USER, "%s: %s waits for rain, which says where it begins",
                model_motion_name(m, k, motion, sizeof motion),
                sd_model_body_name(m, body, name, sizeof name));
    }
}
