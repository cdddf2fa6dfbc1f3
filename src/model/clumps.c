/* clumps.c: shape, mass and checks of clumps of disks; see clumps.h. */
#include "model/clumps.h"

#include <math.h>
#include <stdlib.h>

#include "base/buckets.h"
#include "base/math.h"
#include "base/memory.h"

size_t sd_model_clumps(const sd_model *m) { return m->n_clumps; }

const sd_clump *sd_model_clump(const sd_model *m, size_t k) {
  return k < m->n_clumps ? &m->clumps[k] : NULL;
}

static subject about_clump(const sd_model *m, size_t k) {
  return about_body(m, sd_model_bodies(m) + k);
}

static size_t clump_of(const void *with, size_t disk) {
  return (size_t)((const sd_model *)with)->disks[disk].clump - 1;
}

/* Lists the disks of each clump in the order of disk numbers, and allocates their offsets. */
static sd_status list_disks(sd_model *m) {
  buckets b;
  free(m->clump_disks);
  free(m->clump_offsets);
  m->clump_offsets = NULL;
  bool made = buckets_new(&b, m->n_disks, m->n_clumps, clump_of, m);
  m->clump_disks = b.item;
  for (size_t k = 0; made && k < m->n_clumps; k++) {
    m->clumps[k].n_disks = b.start[k + 1] - b.start[k];
    m->clumps[k].disks = b.item + b.start[k];
  }
  made = made && memory_row(&m->clump_offsets, b.start[m->n_clumps], sizeof *m->clump_offsets);
  free(b.start);
  return made ? SD_OK : SD_ERROR_IO;
}

/* --- shape ------------------------------------------------------------------------------------ */

/* Disk of a clump, while the clump is put together across the edges of a periodic box. */
typedef struct member {
  uint32_t disk;
  bool placed;
  /* Disk, among those already placed, whose surface is nearest to this disk's; as an index into
   * the clump's disks. */
  size_t beside;
  double gap; /* gap between the surfaces of this disk and the disk `beside` */
  /* Number of box lengths along x and y by which the disk is moved to lie beside the first disk. */
  double cells[2];
} member;

/* Length of the box along a coordinate; 0: not periodic. */
static double period(const sd_model *m, int coordinate) {
  return m->periodic[coordinate] ? m->upper[coordinate] - m->lower[coordinate] : 0.0;
}

/* Number of box lengths to subtract from coordinate c of disk b to get its image nearest to disk
 * a. */
static double periods(const sd_model *m, uint32_t a, uint32_t b, int coordinate) {
  const double length = period(m, coordinate);
  const double d = m->disks[b].position[coordinate] - m->disks[a].position[coordinate];
  return length > 0.0 ? nearbyint(d / length) : 0.0;
}

/* Gap between the surfaces of two disks, using the nearest periodic image. */
static double gap_of(const sd_model *m, uint32_t a, uint32_t b) {
  const sd_disk *p = &m->disks[a], *q = &m->disks[b];
  double d[2];
  for (int c = 0; c < 2; c++)
    d[c] = q->position[c] - p->position[c] - period(m, c) * periods(m, a, b, c);
  return math_hypot(d[0], d[1]) - (p->radius + q->radius);
}

/* Places disk k of a clump beside its nearest disk that is already placed. Then updates the gaps
 * of the n disks of the clump that are not placed yet. */
static void place(const sd_model *m, member *of, size_t n, size_t k) {
  of[k].placed = true;
  for (int c = 0; c < 2; c++)
    of[k].cells[c] =
        of[of[k].beside].cells[c] - (k ? periods(m, of[of[k].beside].disk, of[k].disk, c) : 0.0);
  for (size_t j = 0; j < n; j++) {
    const double gap = of[j].placed ? 0.0 : gap_of(m, of[k].disk, of[j].disk);
    if (of[j].placed || gap >= of[j].gap) continue;
    of[j].gap = gap;
    of[j].beside = k;
  }
}

/* Assembles a clump that may lie across the edges of the box. Starting from the first disk, the
 * disk nearest to any placed one is placed next, so that the shape does not depend on the order
 * in which the disks are listed. */
static void place_all(const sd_model *m, member *of, size_t n) {
  for (size_t k = 0; k < n; k++) {
    of[k].placed = false;
    of[k].beside = 0;
    of[k].gap = HUGE_VAL;
    of[k].cells[0] = of[k].cells[1] = 0.0;
  }
  if (!(m->periodic[0] || m->periodic[1])) return;
  place(m, of, n, 0);
  for (size_t left = n - 1; left > 0; left--) {
    size_t next = 0;
    for (size_t j = 1; j < n; j++)
      if (!of[j].placed && (of[next].placed || of[j].gap < of[next].gap)) next = j;
    place(m, of, n, next);
  }
}

/* Component c of the vector from disk a to disk b of a clump that has been put together. */
static double between(const sd_model *m, const member *a, const member *b, int c) {
  const double d = m->disks[b->disk].position[c] - m->disks[a->disk].position[c];
  return d - period(m, c) * (a->cells[c] - b->cells[c]);
}

/* Radius of the circle about the centre of mass that encloses the n disks of a clump. */
static double radius_of(const sd_model *m, const member *of, size_t n) {
  double mass = 0.0, centre[2] = {0.0, 0.0}, radius = m->disks[of->disk].radius;
  for (int pass = 0; pass < 2; pass++) {
    double at[2] = {0.0, 0.0};
    for (size_t k = 0; k < n; k++) {
      const sd_disk *d = &m->disks[of[k].disk];
      for (int q = 0; q < 2; q++) at[q] += k > 0 ? between(m, &of[k - 1], &of[k], q) : 0.0;
      for (int q = 0; q < 2 && pass == 0; q++) centre[q] += d->mass * at[q];
      if (pass == 0) mass += d->mass;
      if (pass == 1)
        radius = math_max(radius, math_hypot(at[0] - centre[0] / mass, at[1] - centre[1] / mass) +
                                      d->radius);
    }
  }
  return radius;
}

clump_grain clumps_grain(const sd_model *m, size_t first, size_t end) {
  enum { FEW = 64 };
  clump_grain grain = {1, m->disks[first].radius};
  member few[FEW], *of = few;
  if (m->disks[first].clump == 0) return grain;
  while (first + grain.disks < end && clumps_join(m, first, first + grain.disks)) grain.disks++;
  if (grain.disks > FEW) of = memory_new(grain.disks, sizeof *of);
  for (size_t k = 0; k < grain.disks; k++) of[k].disk = (uint32_t)(first + k);
  place_all(m, of, grain.disks);
  grain.radius = radius_of(m, of, grain.disks);
  if (of != few) free(of);
  return grain;
}

/* Computes the offsets of a clump's disks from its centre of mass; centre: position of the
 * centre relative to the first disk. Returns the mass. */
static double measure(const sd_model *m, const sd_clump *c, const member *of, double (*offset)[2],
                      double centre[2]) {
  double mass = 0.0, at[2] = {0.0, 0.0};
  centre[0] = centre[1] = 0.0;
  for (size_t n = 0; n < c->n_disks; n++) {
    const double part = m->disks[c->disks[n]].mass;
    mass += part;
    for (int q = 0; q < 2; q++) {
      if (n > 0) at[q] += between(m, &of[n - 1], &of[n], q);
      offset[n][q] = at[q];
      centre[q] += part * at[q];
    }
  }
  for (int q = 0; q < 2; q++) centre[q] /= mass;
  for (size_t n = 0; n < c->n_disks; n++)
    for (int q = 0; q < 2; q++) offset[n][q] -= centre[q];
  return mass;
}

/* Largest gap along the chain of disks that connects disks a and b of a clump; each disk of the
 * chain was placed beside the next one. */
static double widest(const member *of, size_t a, size_t b) {
  double most = -HUGE_VAL;
  size_t up_a = 0, up_b = 0;
  for (size_t k = a; k; k = of[k].beside) up_a++;
  for (size_t k = b; k; k = of[k].beside) up_b++;
  while (a != b) {
    size_t *k = up_a >= up_b ? &a : &b;
    most = math_max(most, of[*k].gap);
    *k = of[*k].beside;
    *(k == &a ? &up_a : &up_b) -= 1;
  }
  return most;
}

/* Returns the directions (bit 0: x, bit 1: y) in which a clump closes into a ring around the
 * periodic box: two of its disks are nearest to each other across an edge, with a gap no larger
 * than those on the chain of disks between them, so that the ring could as well be open there. */
static unsigned closes_around(const sd_model *m, const member *of, size_t n) {
  unsigned around = 0;
  for (size_t a = 0; (m->periodic[0] || m->periodic[1]) && a < n; a++)
    for (size_t b = a + 1; b < n; b++)
      for (int c = 0; c < 2; c++) {
        if (of[a].cells[c] - of[b].cells[c] == periods(m, of[a].disk, of[b].disk, c)) continue;
        const double near = 1e-9 * (m->disks[of[a].disk].radius + m->disks[of[b].disk].radius);
        if (gap_of(m, of[a].disk, of[b].disk) <= widest(of, a, b) + near) around |= 1u << c;
      }
  return around;
}

sd_disk clump_effective_disk(const sd_model *m, size_t disk) {
  sd_disk d = m->disks[disk];
  if (d.clump == 0 || !m->clump_offsets) return d;
  const sd_clump *c = &m->clumps[d.clump - 1];
  size_t n = 0;
  while (c->disks[n] != disk) n++;
  const double *offset = m->clump_offsets[(c->disks - m->clump_disks) + (ptrdiff_t)n];
  const double arm = math_hypot(offset[0], offset[1]), end = arm + d.radius;
  for (int q = 0; q < SD_COORDINATES; q++) d.locked[q] = c->locked[q];
  const double turns = d.locked[SD_THETA] ? 0.0 : 1.0 / c->inertia;
  d.mass = 1.0 / (1.0 / c->mass + arm * arm * turns);
  if (turns > 0.0) d.inertia = d.radius * d.radius / ((end * end - arm * arm) * turns);
  return d;
}

/* Computes the centre, mass and moment of inertia of a clump; if its mass is given, scales the
 * masses of its disks first, so that a saved model, whose masses are scaled, has the same centre to
 * the last bit. */
static void derive(sd_model *m, sd_clump *c, member *of) {
  double(*offset)[2] = m->clump_offsets + (c->disks - m->clump_disks), inertia = 0.0, centre[2];
  for (size_t n = 0; n < c->n_disks; n++) of[n].disk = c->disks[n];
  place_all(m, of, c->n_disks);
  const double mass = measure(m, c, of, offset, centre);
  if (c->mass == 0.0) c->mass = mass;
  if (fabs(c->mass - mass) > 1e-12 * mass) {
    for (size_t n = 0; n < c->n_disks; n++) {
      m->disks[c->disks[n]].mass *= c->mass / mass;
      m->disks[c->disks[n]].inertia *= c->mass / mass;
    }
    measure(m, c, of, offset, centre);
  }
  for (size_t n = 0; n < c->n_disks; n++) {
    const sd_disk *d = &m->disks[c->disks[n]];
    inertia += d->inertia + d->mass * (offset[n][0] * offset[n][0] + offset[n][1] * offset[n][1]);
  }
  for (int k = 0; k < 2; k++) {
    c->position[k] = m->disks[c->disks[0]].position[k] + centre[k];
    const double length = m->periodic[k] ? m->upper[k] - m->lower[k] : 0.0;
    if (length > 0.0) c->position[k] -= length * floor((c->position[k] - m->lower[k]) / length);
  }
  if (c->inertia == 0.0) c->inertia = inertia;
}

/* --- checks ----------------------------------------------------------------------------------- */

/* Reports an error if disk i of a clump is locked, has a motion of its own, or waits to be
 * released while other disks of the clump do not. */
static void check_disk(const sd_model *m, size_t k, uint32_t i, bool waiting, sd_messages *msg) {
  const sd_disk *d = &m->disks[i];
  char text[96];
  const char *name = sd_model_body_name(m, i, text, sizeof text);
  if (d->driven || d->locked[SD_X] || d->locked[SD_Y] || d->locked[SD_THETA])
    fail_about(msg, about_clump(m, k),
               "%s is fixed, locked or moved: expected that of the whole clump", name);
  if (d->velocity[SD_X] != 0.0 || d->velocity[SD_Y] != 0.0 || d->velocity[SD_THETA] != 0.0)
    fail_about(msg, about_clump(m, k), "%s has a velocity: expected one of the whole clump", name);
  if (d->waiting != waiting)
    fail_about(msg, about_clump(m, k), "%s %s for rain, others do not: expected all or none", name,
               d->waiting ? "waits" : "does not wait");
}

/* Reports a clump that could turn into its own periodic image: it is longer than the box or
 * closes around it, and its rotation is not locked. */
static void check_length(const sd_model *m, size_t k, const member *of, sd_messages *msg) {
  const sd_clump *c = &m->clumps[k];
  const double(*offset)[2] = (const double(*)[2])m->clump_offsets + (c->disks - m->clump_disks);
  const unsigned around = c->locked[SD_THETA] ? 0 : closes_around(m, of, c->n_disks);
  double reach = 0.0;
  for (size_t n = 0; n < c->n_disks; n++)
    reach = math_max(reach, math_hypot(offset[n][0], offset[n][1]) + m->disks[c->disks[n]].radius);
  for (int q = 0; q < 2; q++)
    if (m->periodic[q] && !c->locked[SD_THETA] && !(2.0 * reach < m->upper[q] - m->lower[q]))
      fail_about(msg, about_clump(m, k),
                 "it is longer than the periodic box in %c: expected locked = \"theta\"", "xy"[q]);
    else if (around >> q & 1u)
      fail_about(msg, about_clump(m, k),
                 "it closes around the periodic box in %c: expected locked = \"theta\"", "xy"[q]);
}

static void check_clump(const sd_model *m, size_t k, const member *of, sd_messages *msg) {
  const sd_clump *c = &m->clumps[k];
  for (size_t n = 0; n < c->n_disks; n++)
    check_disk(m, k, c->disks[n], m->disks[c->disks[0]].waiting, msg);
  if (!(c->mass > 0.0) || !isfinite(c->mass) || !(c->inertia > 0.0) || !isfinite(c->inertia))
    fail_about(msg, about_clump(m, k), "mass = %g, inertia = %g: expected numbers > 0", c->mass,
               c->inertia);
  for (int q = 0; q < SD_COORDINATES; q++) {
    if (!isfinite(c->velocity[q]) || !isfinite(c->force[q]))
      fail_about(msg, about_clump(m, k), "velocity and force must be finite");
    if (c->locked[q] && c->velocity[q] != 0.0)
      fail_about(msg, about_clump(m, k), "a locked coordinate cannot have a velocity");
  }
  check_length(m, k, of, msg);
}

/* Reports motions that name a disk of a clump. */
static void check_motions(const sd_model *m, sd_messages *msg) {
  char text[96];
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && m->disks[body].clump > 0)
        fail_about(msg, about_motion(m, k), "%s belongs to a clump: expected the clump",
                   sd_model_body_name(m, body, text, sizeof text));
    }
}

sd_status clumps_derive(sd_model *m, sd_messages *msg) {
  const size_t before = sd_messages_errors(msg);
  if (m->n_clumps == 0) return SD_OK;
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].clump < 0 || (size_t)m->disks[i].clump > m->n_clumps) m->disks[i].clump = 0;
  size_t most = 0;
  if (list_disks(m) != SD_OK) return sd_fail(msg, SD_ERROR_IO, "out of memory for the clumps");
  for (size_t k = 0; k < m->n_clumps; k++)
    if (m->clumps[k].n_disks > most) most = m->clumps[k].n_disks;
  member *of = memory_new(most, sizeof *of);
  for (size_t k = 0; k < m->n_clumps; k++) {
    if (m->clumps[k].n_disks == 0) {
      fail_about(msg, about_clump(m, k), "it has no disk");
      continue;
    }
    derive(m, &m->clumps[k], of);
    check_clump(m, k, of, msg);
  }
  free(of);
  check_motions(m, msg);
  return sd_messages_errors(msg) > before ? SD_ERROR_USER : SD_OK;
}
