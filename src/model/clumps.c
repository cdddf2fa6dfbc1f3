/* clumps.c: see clumps.h. */
#include "model/clumps.h"

#include <math.h>
#include <stdlib.h>

size_t sd_model_clumps(const sd_model *m) { return m->n_clumps; }

const sd_clump *sd_model_clump(const sd_model *m, size_t k) { return k < m->n_clumps ? &m->clumps[k] : NULL; }

static const char *name_of(const sd_model *m, size_t k, char text[96]) {
  return sd_model_body_name(m, (uint32_t)(sd_model_bodies(m) + k), text, 96);
}

/* Disks by clump, in the order of their numbers. */
static sd_status list_disks(sd_model *m) {
  size_t *end = calloc(m->n_clumps + 1, sizeof *end), n = 0;
  free(m->clump_disks);
  free(m->clump_offsets);
  for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].clump > 0;
  m->clump_disks = calloc(n + 1, sizeof *m->clump_disks);
  m->clump_offsets = calloc(n + 1, sizeof *m->clump_offsets);
  if (!end || !m->clump_disks || !m->clump_offsets) {
    free(end);
    return SD_ERROR_IO;
  }
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].clump > 0) end[m->disks[i].clump - 1]++;
  for (size_t k = 0, first = 0; k < m->n_clumps; k++) {
    m->clumps[k].n_disks = end[k];
    m->clumps[k].disks = m->clump_disks + first;
    end[k] = first;
    first += m->clumps[k].n_disks;
  }
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].clump > 0) m->clump_disks[end[m->disks[i].clump - 1]++] = (uint32_t)i;
  free(end);
  return SD_OK;
}

/* From disk a to disk b in the nearest image: a clump may lie across the edge of a periodic box. */
static double between(const sd_model *m, size_t a, size_t b, int coordinate) {
  const double length = m->periodic[coordinate] ? m->upper[coordinate] - m->lower[coordinate] : 0.0;
  const double d = m->disks[b].position[coordinate] - m->disks[a].position[coordinate];
  return length > 0.0 ? d - length * nearbyint(d / length) : d;
}

clump_grain clumps_grain(const sd_model *m, size_t first, size_t end) {
  clump_grain grain = {1, m->disks[first].radius};
  double mass = 0.0, centre[2] = {0.0, 0.0};
  if (m->disks[first].clump == 0) return grain;
  while (first + grain.disks < end && clumps_join(m, first, first + grain.disks)) grain.disks++;
  for (int pass = 0; pass < 2; pass++) { /* the centre, and how far from it the disks reach */
    double at[2] = {0.0, 0.0};
    for (size_t i = first; i < first + grain.disks; i++) {
      const sd_disk *d = &m->disks[i];
      for (int q = 0; q < 2; q++) at[q] += i > first ? between(m, i - 1, i, q) : 0.0;
      for (int q = 0; q < 2 && pass == 0; q++) centre[q] += d->mass * at[q];
      if (pass == 0) mass += d->mass;
      if (pass == 1)
        grain.radius =
            fmax(grain.radius, hypot(at[0] - centre[0] / mass, at[1] - centre[1] / mass) + d->radius);
    }
  }
  return grain;
}

/* Offsets of the disks from the centre of mass, each in the image that is nearest to the disk before; centre: from the first.
 * Returns the mass. */
static double measure(const sd_model *m, const sd_clump *c, double (*offset)[2], double centre[2]) {
  double mass = 0.0, at[2] = {0.0, 0.0};
  centre[0] = centre[1] = 0.0;
  for (size_t n = 0; n < c->n_disks; n++) {
    const double part = m->disks[c->disks[n]].mass;
    mass += part;
    for (int q = 0; q < 2; q++) {
      if (n > 0) at[q] += between(m, c->disks[n - 1], c->disks[n], q);
      offset[n][q] = at[q];
      centre[q] += part * at[q];
    }
  }
  for (int q = 0; q < 2; q++) centre[q] /= mass;
  for (size_t n = 0; n < c->n_disks; n++)
    for (int q = 0; q < 2; q++) offset[n][q] -= centre[q];
  return mass;
}

sd_disk clumps_felt(const sd_model *m, size_t disk) {
  sd_disk d = m->disks[disk];
  if (d.clump == 0 || !m->clump_offsets) return d;
  const sd_clump *c = &m->clumps[d.clump - 1];
  size_t n = 0;
  while (c->disks[n] != disk) n++;
  const double *offset = m->clump_offsets[(c->disks - m->clump_disks) + (ptrdiff_t)n];
  const double arm = hypot(offset[0], offset[1]), end = arm + d.radius;
  for (int q = 0; q < SD_COORDINATES; q++) d.locked[q] = c->locked[q];
  const double turns = d.locked[SD_THETA] ? 0.0 : 1.0 / c->inertia;
  d.mass = 1.0 / (1.0 / c->mass + arm * arm * turns);
  if (turns > 0.0) d.inertia = d.radius * d.radius / ((end * end - arm * arm) * turns);
  return d;
}

static void derive(sd_model *m, sd_clump *c) {
  double(*offset)[2] = m->clump_offsets + (c->disks - m->clump_disks), inertia = 0.0, centre[2];
  const double mass = measure(m, c, offset, centre);
  for (size_t n = 0; n < c->n_disks; n++) {
    const sd_disk *d = &m->disks[c->disks[n]];
    inertia += d->inertia + d->mass * (offset[n][0] * offset[n][0] + offset[n][1] * offset[n][1]);
  }
  for (int k = 0; k < 2; k++) {
    c->position[k] = m->disks[c->disks[0]].position[k] + centre[k];
    const double length = m->periodic[k] ? m->upper[k] - m->lower[k] : 0.0;
    if (length > 0.0) c->position[k] -= length * floor((c->position[k] - m->lower[k]) / length);
  }
  if (c->mass == 0.0) c->mass = mass;
  if (c->inertia == 0.0) c->inertia = inertia * (c->mass / mass);
  for (size_t n = 0; n < c->n_disks && fabs(c->mass - mass) > 1e-12 * mass; n++) {
    m->disks[c->disks[n]].mass *= c->mass / mass;
    m->disks[c->disks[n]].inertia *= c->mass / mass;
  }
}

/* --- checks ------------------------------------------------------------------------------------------ */

static void check_disk(const sd_model *m, const char *clump, uint32_t i, bool waiting, sd_messages *msg) {
  const sd_disk *d = &m->disks[i];
  char text[96];
  const char *name = sd_model_body_name(m, i, text, sizeof text);
  if (d->driven || d->locked[SD_X] || d->locked[SD_Y] || d->locked[SD_THETA])
    sd_fail(msg, SD_ERROR_USER, "%s: %s is fixed, locked or moved: expected that of the whole clump", clump,
            name);
  if (d->velocity[SD_X] != 0.0 || d->velocity[SD_Y] != 0.0 || d->velocity[SD_THETA] != 0.0)
    sd_fail(msg, SD_ERROR_USER, "%s: %s has a velocity: expected one of the whole clump", clump, name);
  if (d->waiting != waiting)
    sd_fail(msg, SD_ERROR_USER, "%s: %s %s for rain, others do not: expected all or none", clump, name,
            d->waiting ? "waits" : "does not wait");
}

/* A clump that spans a periodic box would turn into its own image. */
static void check_length(const sd_model *m, const sd_clump *c, const char *name, sd_messages *msg) {
  const double(*offset)[2] = (const double(*)[2])m->clump_offsets + (c->disks - m->clump_disks);
  double reach = 0.0;
  for (size_t n = 0; n < c->n_disks; n++)
    reach = fmax(reach, hypot(offset[n][0], offset[n][1]) + m->disks[c->disks[n]].radius);
  for (int q = 0; q < 2; q++)
    if (m->periodic[q] && !c->locked[SD_THETA] && !(2.0 * reach < m->upper[q] - m->lower[q]))
      sd_fail(msg, SD_ERROR_USER, "%s: it is longer than the periodic box in %c: expected locked = \"theta\"",
              name, "xy"[q]);
}

static void check_clump(const sd_model *m, size_t k, sd_messages *msg) {
  const sd_clump *c = &m->clumps[k];
  char text[96];
  const char *name = name_of(m, k, text);
  for (size_t n = 0; n < c->n_disks; n++)
    check_disk(m, name, c->disks[n], m->disks[c->disks[0]].waiting, msg);
  if (!(c->mass > 0.0) || !isfinite(c->mass) || !(c->inertia > 0.0) || !isfinite(c->inertia))
    sd_fail(msg, SD_ERROR_USER, "%s: mass = %g, inertia = %g: expected numbers > 0", name, c->mass,
            c->inertia);
  for (int q = 0; q < SD_COORDINATES; q++) {
    if (!isfinite(c->velocity[q]) || !isfinite(c->force[q]))
      sd_fail(msg, SD_ERROR_USER, "%s: velocity and force must be finite", name);
    if (c->locked[q] && c->velocity[q] != 0.0)
      sd_fail(msg, SD_ERROR_USER, "%s: a locked coordinate cannot have a velocity", name);
  }
  check_length(m, c, name, msg);
}

static void check_motions(const sd_model *m, sd_messages *msg) {
  char text[96], motion[96];
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && m->disks[body].clump > 0)
        sd_fail(msg, SD_ERROR_USER, "%s: %s belongs to a clump: expected the clump",
                model_motion_name(m, k, motion, sizeof motion),
                sd_model_body_name(m, body, text, sizeof text));
    }
}

sd_status clumps_derive(sd_model *m, sd_messages *msg) {
  const size_t before = sd_messages_errors(msg);
  char text[96];
  if (m->n_clumps == 0) return SD_OK;
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].clump < 0 || (size_t)m->disks[i].clump > m->n_clumps) m->disks[i].clump = 0;
  if (list_disks(m) != SD_OK) return sd_fail(msg, SD_ERROR_IO, "out of memory for the clumps");
  for (size_t k = 0; k < m->n_clumps; k++) {
    if (m->clumps[k].n_disks == 0) {
      sd_fail(msg, SD_ERROR_USER, "%s: it has no disk", name_of(m, k, text));
      continue;
    }
    derive(m, &m->clumps[k]);
    check_clump(m, k, msg);
  }
  check_motions(m, msg);
  return sd_messages_errors(msg) > before ? SD_ERROR_USER : SD_OK;
}
