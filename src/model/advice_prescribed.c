/* advice_prescribed.c: prescribed bodies that run into one another, between which no force acts. See advice.h. */
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/shortage.h"
#include "model/advice.h"
#include "model/motion_kinds.h"
#include "model/overlaps.h"
#include "model/rows.h"

/* Overlap over the radius beyond which it is told; moments of the run that are looked at; and pairs, at all moments. */
static const double LEAST_OVERLAP = 0.01;
enum { MOMENTS = 101, MOST_LOOKS = 2000000 };

typedef struct displaced {
  double by[3];
} displaced;

/* Prescribed bodies, ascending, and how far the motions that are ever on have brought each body. */
typedef struct bodies {
  size_t n;
  uint32_t *list;
  displaced *all; /* [disks and walls] */
} bodies;

static double total_time(const sd_model *m) {
  double steps = 0;
  for (size_t k = 0; k < m->n_phases; k++) steps += (double)m->phases[k].steps;
  return steps * m->dt;
}

static bool list_bodies(const sd_model *m, bodies *p) {
  const size_t n_bodies = m->n_disks + m->n_walls;
  if (!memory_rows(2, (memory_column[]){{&p->list, n_bodies - m->n_free, sizeof *p->list},
                                        {&p->all, n_bodies, sizeof *p->all}})) {
    shortage_note();
    return false;
  }
  for (uint32_t b = 0; b < n_bodies; b++)
    if (b >= m->n_disks || (b < model_held(m) && m->disks[b].driven && !m->disks[b].waiting))
      p->list[p->n++] = b;
  return true;
}

static void displace(const sd_model *m, double t, const bodies *p) {
  displaced *all = p->all;
  for (size_t k = 0; k < p->n; k++) all[p->list[k]] = (displaced){{0}};
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (q->coordinate == SD_SURFACE) continue;
    const double u = motion_at(q, t);
    for (size_t b = 0; b < q->n_bodies; b++)
      if (q->bodies[b] < m->n_disks + m->n_walls) all[q->bodies[b]].by[q->coordinate] += u;
  }
}

/* Distance between a disk and another body that are displaced. */
static double gap_of(const sd_model *m, uint32_t disk, uint32_t body, const displaced *all) {
  const sd_disk *d = &m->disks[disk];
  const bool wall = body >= m->n_disks;
  const double *at = wall ? m->walls[body - m->n_disks].pivot : m->disks[body].position;
  const double x[2] = {d->position[0] + all[disk].by[0], d->position[1] + all[disk].by[1]};
  const double pose[3] = {at[0] + all[body].by[0], at[1] + all[body].by[1], wall ? all[body].by[2] : 0};
  return overlaps_gap(m, disk, x, body, pose);
}

typedef struct meeting {
  uint32_t disk, body;
  double depth; /* over the radius of the smaller */
} meeting;

static double smaller(const sd_model *m, uint32_t disk, uint32_t body) {
  const double radius = m->disks[disk].radius;
  return body < m->n_disks ? fmin(radius, m->disks[body].radius) : radius;
}

/* Bodies that moved with respect to one another. */
static bool parted(const sd_model *m, uint32_t disk, uint32_t body, const displaced *all) {
  const double *one = all[disk].by, *other = all[body].by;
  const bool turns = body >= m->n_disks && other[SD_THETA] != 0;
  return one[SD_X] != other[SD_X] || one[SD_Y] != other[SD_Y] || turns;
}

/* Pairs that overlap more deeply than at the start. */
static void look(const sd_model *m, const bodies *p, meeting *worst) {
  for (size_t k = 0; k < p->n && p->list[k] < m->n_disks; k++)
    for (size_t l = k + 1; l < p->n; l++) {
      const uint32_t disk = p->list[k], body = p->list[l];
      const double gap = parted(m, disk, body, p->all) ? gap_of(m, disk, body, p->all) : 0;
      if (!(gap < 0)) continue;
      const double radius = smaller(m, disk, body),
                   deeper = -gap + fmin(overlaps_first_gap(m, disk, body), 0);
      if (deeper > fmax(LEAST_OVERLAP, worst->depth) * radius)
        *worst = (meeting){disk, body, deeper / radius};
    }
}

double advice_prescribed(const sd_model *m, sd_messages *messages) {
  char one[96], two[96];
  const double driven = (double)(m->n_disks - m->n_free), time = total_time(m),
               looks = MOMENTS * driven * (driven + (double)m->n_walls);
  meeting worst = {0};
  bodies p = {0};
  if (m->n_motions == 0 || !(driven > 0) || looks > MOST_LOOKS) return 0;
  const bool listed = list_bodies(m, &p);
  for (int k = 0; k < MOMENTS && listed; k++) { /* the golden ratio falls in step with no wave */
    displace(m, k == 0 ? time : time * fmod(k * 0.6180339887498949, 1.0), &p);
    look(m, &p, &worst);
  }
  free(p.list);
  free(p.all);
  if (!(worst.depth > 0)) return 0;
  sd_warn(
      messages,
      "%s and %s are both prescribed, and motions bring them to overlap by %.2g of the radius: no force acts "
      "between them, only on disks that are free",
      sd_model_body_name(m, worst.disk, one, sizeof one), sd_model_body_name(m, worst.body, two, sizeof two),
      worst.depth);
  return worst.depth / LEAST_OVERLAP;
}
