/* configuration_clumps.c: finds the clumps (rigid bodies made of disks) of a configuration.
 *
 * The masses of a clump's disks add up to the clump's mass (model/clumps.c). Its centre of mass and
 * velocity therefore follow from its disks, and frames need no poses of clumps. Image counts tell
 * the relative positions of a clump's disks across the edges of a periodic box. */
#include <stdlib.h>

#include "base/buckets.h"
#include "base/memory.h"
#include "measure/configuration.h"
#include "model/model.h"

/* Returns 1 + the clump number of a disk in play; 0 if it is in no clump. A clump number above the
 * number of disks, as in a damaged file, counts as 0, since each clump has a disk. */
static size_t clump_of(const configuration *c, const sd_model *from, size_t disk) {
  const int clump = from->disks[c->number[disk]].clump;
  return clump > 0 && (size_t)clump <= from->n_disks ? (size_t)clump : 0;
}

static size_t listed_clump(const void *with, size_t disk) {
  return (size_t)((const configuration *)with)->clump_of[disk];
}

/* Lists the disks of each clump in ascending order of their numbers. */
static sd_status list_disks(configuration *c, const sd_model *from) {
  const size_t n = c->model->n_disks;
  buckets b;
  for (size_t i = 0; i < n; i++) c->clump_of[i] = (int32_t)clump_of(c, from, i) - 1;
  if (!buckets_new(&b, n, c->n_clumps, listed_clump, c)) return SD_ERROR_IO;
  c->clump_disks = b.item;
  for (size_t k = 0; k < c->n_clumps; k++) {
    c->clumps[k].n_disks = b.start[k + 1] - b.start[k];
    c->clumps[k].disks = b.item + b.start[k];
  }
  free(b.start);
  return SD_OK;
}

static double between(const configuration *c, const frame_data *f, uint32_t first, uint32_t disk,
                      int q) {
  const uint32_t a = c->number[first], b = c->number[disk];
  return (f->position[b][q] - f->position[a][q]) + (f->image[b][q] - f->image[a][q]) * c->length[q];
}

void configuration_clump(config_clump *k, const sd_disk *disks, double (*arm)[2]) {
  double centre[2] = {0.0, 0.0};
  for (size_t n = 0; n < k->n_disks; n++) {
    const uint32_t i = k->disks[n];
    const sd_disk *d = &disks[i];
    k->mass += d->mass;
    for (int q = 0; q < 2; q++) {
      centre[q] += d->mass * arm[i][q];
      k->velocity[q] += d->mass * d->velocity[q];
      k->force[q] += d->force[q];
    }
  }
  const sd_disk *first = &disks[k->disks[0]];
  for (int q = 0; q < 2; q++) {
    centre[q] /= k->mass;
    k->velocity[q] /= k->mass;
    k->position[q] = first->position[q] + centre[q];
  }
  k->velocity[SD_THETA] = first->velocity[SD_THETA];
  for (size_t n = 0; n < k->n_disks; n++) {
    const uint32_t i = k->disks[n];
    for (int q = 0; q < 2; q++) arm[i][q] -= centre[q];
    k->inertia +=
        disks[i].inertia + disks[i].mass * (arm[i][0] * arm[i][0] + arm[i][1] * arm[i][1]);
  }
}

/* Computes clump k and the vectors c->arm from its centre to its disks. */
static void measure(configuration *c, const frame_data *f, config_clump *k) {
  for (size_t n = 0; n < k->n_disks; n++)
    for (int q = 0; q < 2; q++) c->arm[k->disks[n]][q] = between(c, f, k->disks[0], k->disks[n], q);
  configuration_clump(k, c->model->disks, c->arm);
}

/* Applies the values that the model gives for the clump itself: its moment of inertia, if given,
 * replaces the computed one, and its force is added. */
static void take_given(config_clump *k, const sd_clump *given) {
  if (given->inertia > 0.0) k->inertia = given->inertia;
  for (int q = 0; q < 2; q++) k->force[q] += given->force[q];
}

sd_status configuration_clumps(configuration *c, const sd_model *from, const frame_data *f) {
  const size_t n = c->model->n_disks;
  for (size_t i = 0; i < n; i++) {
    const size_t k = clump_of(c, from, i);
    if (k > c->n_clumps) c->n_clumps = k;
  }
  if (c->n_clumps == 0) return SD_OK;
  const memory_column rows[] = {{&c->clumps, c->n_clumps, sizeof *c->clumps},
                                {&c->clump_of, n, sizeof *c->clump_of},
                                {&c->arm, n, sizeof *c->arm}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows) || list_disks(c, from) != SD_OK)
    return SD_ERROR_IO;
  for (size_t k = 0; k < c->n_clumps; k++) {
    if (c->clumps[k].n_disks == 0) continue;
    measure(c, f, &c->clumps[k]);
    if (k < from->n_clumps) take_given(&c->clumps[k], &from->clumps[k]);
  }
  return SD_OK;
}

void configuration_clumps_free(configuration *c) {
  free(c->clumps);
  free(c->clump_of);
  free(c->clump_disks);
  free(c->arm);
}
