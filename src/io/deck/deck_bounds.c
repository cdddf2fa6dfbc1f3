/* deck_bounds.c: reads the group `bounds`, the region that disks should not leave, and checks
 * the positions of bodies at the start. See deck_tree.h and sd_bounds in slipdisk/model.h.
 *
 * Without explicit limits the bounds follow the container: its walls, plus the largest radius,
 * plus the distance that motions may move these walls; a disk below the outlet of a hopper is
 * outside. Without a container the limits are far out: FAR times the extent of all bodies at the
 * start. Bounds without explicit limits apply even if the deck has no group `bounds`, if gravity
 * may pull a disk past the walls, that is, if there are walls and none of them is an infinite
 * line. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_tree.h"
#include "model/motions.h"
#include "model/overlaps.h"

/* FAR: distance of the default bounds from the bodies, divided by the extent of all bodies.
 * MOST_ALIKE: number of errors of one kind that are shown; further ones are only counted, since one
 * wrong number can displace all disks. */
enum { FAR = 10, MOST_ALIKE = 8 };
/* Largest displacement that a motion is assumed to cause, divided by motion_amplitude
 * (amplitude, or rms displacement of a random motion); a random motion rarely exceeds 4 times
 * its rms value. */
static const double SWING = 4;

static double largest_radius(const sd_model *m) {
  /* Tiles (parts of a packing or file) have a known largest radius; their disks may be stored on
   * other ranks */
  double largest = m->tiles.n ? m->tiles.most : 0;
  for (size_t i = 0; i < model_held(m); i++) largest = math_max(largest, m->disks[i].radius);
  return largest;
}

/* --- bounds of the container ------------------------------------------------------------------ */

/* Finds the wall with this name, else a disk of the group with this name. Also returns true if the
 * disks of that group are stored on other ranks; *body is then not valid. */
static bool find_side(const deck *d, const char *name, uint32_t *body) {
  const sd_model *m = d->model;
  for (uint32_t w = 0; w < m->n_walls; w++) {
    *body = (uint32_t)m->n_disks + w;
    if (m->walls[w].name && strcmp(m->walls[w].name, name) == 0) return true;
  }
  for (*body = 0; *body < model_held(m); ++*body) {
    int group = m->disks[*body].group;
    if (group >= 0 && strcmp(m->groups[group], name) == 0) return true;
  }
  for (size_t k = 0; k < d->n_away_groups; k++)
    if (d->away_group[k] && strcmp(m->groups[k], name) == 0) return true;
  return false;
}

/* Returns the largest distance by which motions may displace a body along a coordinate; infinite if
 * it is not known. */
static double travel(const sd_model *m, uint32_t body, int coordinate) {
  double sum = 0;
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    bool turns = q->coordinate == SD_THETA && body >= m->n_disks &&
                 m->walls[body - m->n_disks].kind != SD_WALL_CIRCLE;
    if (!turns && q->coordinate != coordinate) continue;
    for (size_t b = 0; b < q->n_bodies; b++)
      if (q->bodies[b] == body) sum += turns ? HUGE_VAL : SWING * motion_amplitude(q);
  }
  return sum;
}

/* Sets one limit of the bounds: the edge of the region, moved outwards by `margin` and by the
 * largest displacement of the wall there. Does nothing in a periodic direction or without such a
 * wall. */
static void limit_side(const deck *d, const char *wall, int c, bool upper, double margin) {
  sd_model *m = d->model;
  uint32_t body;
  if (m->periodic[c] || !find_side(d, wall, &body)) return;
  double distance = margin + travel(m, body, c);
  if (upper)
    m->bounds.upper[c] = m->region_upper[c] + distance;
  else
    m->bounds.lower[c] = m->region_lower[c] - distance;
}

static void follow_container(const deck *d) {
  const sd_model *m = d->model;
  const container_kind *kind = container_kind_of(m->container);
  for (int side = 0; side < 4; side++)
    if (kind->sides[side])
      limit_side(d, kind->sides[side], side / 2, side % 2,
                 side == 2 && kind->outlet ? 0 : largest_radius(m));
}

/* --- bounds without container ----------------------------------------------------------------- */

typedef struct extent {
  double low[2], high[2];
} extent;

static void extend(extent *e, const double *at, double radius) {
  for (int c = 0; c < 2; c++) {
    e->low[c] = math_min(e->low[c], at[c] - radius);
    e->high[c] = math_max(e->high[c], at[c] + radius);
  }
}

static void far_out(sd_model *m) {
  extent e = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
  for (size_t i = 0; i < model_held(m); i++) extend(&e, m->disks[i].position, m->disks[i].radius);
  if (m->tiles.n) {
    extend(&e, m->tiles.lower, 0);
    extend(&e, m->tiles.upper, 0);
  }
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind == SD_WALL_CIRCLE) extend(&e, wall->pivot, wall->radius);
    for (size_t k = 0; k < wall->n_points; k++) extend(&e, wall->points[k], 0);
  }
  double distance = FAR * math_max(e.high[0] - e.low[0], e.high[1] - e.low[1]);
  for (int c = 0; c < 2; c++) {
    if (m->periodic[c] || !isfinite(distance)) continue;
    m->bounds.lower[c] = e.low[c] - distance;
    m->bounds.upper[c] = e.high[c] + distance;
  }
}

/* Returns true if gravity may pull a disk past the walls: gravity is not 0, there are walls, and
 * none of them is an infinite line. */
static bool may_leak(const sd_model *m) {
  bool endless = false;
  for (size_t w = 0; w < m->n_walls; w++) endless = endless || m->walls[w].kind == SD_WALL_LINE;
  return m->n_walls > 0 && !endless && (m->gravity[0] != 0 || m->gravity[1] != 0);
}

/* --- the group -------------------------------------------------------------------------------- */

static bool starts_inside(const deck *d, size_t row) {
  const sd_bounds *b = &d->model->bounds;
  const sd_disk *disk = rows_disk(d->model, row);
  bool inside = disk->waiting || disk->driven;
  for (int c = 0; c < 2 && !inside; c++)
    if (disk->position[c] < b->lower[c] || disk->position[c] > b->upper[c]) return false;
  return true;
}

/* Number of disks that start outside the bounds; disk number and position of the first of them. */
typedef struct outside {
  size_t n;
  uint32_t disk;
  double at[2];
} outside;

/* Counts the disks of all ranks that start outside the bounds, and finds the first of them.
 * Collective. */
static outside find_outside(const deck *d) {
  outside o = {.disk = UINT32_MAX}, *all = memory_new((size_t)comm_size(d->comm), sizeof *all);
  for (size_t row = rows_first(d->model); row < rows_count(d->model); row++) {
    if (starts_inside(d, row)) continue;
    const double *at = rows_disk(d->model, row)->position;
    const uint32_t disk = rows_number(d->model, row);
    if (disk < o.disk) o = (outside){o.n, disk, {at[SD_X], at[SD_Y]}};
    o.n++;
  }
  comm_gather_one(d->comm, &o, all, sizeof o);
  o = all[0];
  for (int q = 1; q < comm_size(d->comm); q++) {
    const size_t n = o.n + all[q].n;
    if (all[q].disk < o.disk) o = all[q];
    o.n = n;
  }
  free(all);
  return o;
}

/* Warns of disks that start outside the container. It is only a warning, since the deck itself does
 * not give these limits. */
static void warn_start(deck *d) {
  const outside o = find_outside(d);
  if (o.n == 0) return;
  sd_warn(d->messages, "%s: %s at (%g, %g) starts outside the container%s",
          deck_place_text(d, deck_disk_place(d, o.disk)), deck_body_name(d, o.disk), o.at[SD_X],
          o.at[SD_Y], o.n > 1 ? ", and so do others" : "");
}

static void check_start(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t row = 0; row < rows_count(m); row++) {
    if (starts_inside(d, row) || found++ >= MOST_ALIKE) continue;
    const sd_disk *disk = rows_disk(m, row);
    deck_fail_place(
        d, deck_disk_place(d, rows_number(m, row)), "%s at (%g, %g) starts outside the bounds",
        deck_body_name(d, rows_number(m, row)), disk->position[SD_X], disk->position[SD_Y]);
  }
  if (found > MOST_ALIKE)
    deck_fail_place(d, (deck_place){d->path, 0}, "%zu more disks start outside the bounds",
                    found - MOST_ALIKE);
}

void deck_read_bounds(deck *d) {
  sd_model *m = d->model;
  sd_bounds *b = &m->bounds;
  bool written = deck_child(d->root, "bounds") != NULL, set = false;
  deck_group g;
  for (int c = 0; c < 2; c++) {
    b->lower[c] = -HUGE_VAL;
    b->upper[c] = HUGE_VAL;
  }
  if (m->container != SD_CONTAINER_NONE)
    follow_container(d);
  else if (written || may_leak(m))
    far_out(m);
  for (int c = 0; c < 2; c++) b->given = b->given || isfinite(b->lower[c]) || isfinite(b->upper[c]);
  if (!written && !b->given) return;
  if (!deck_enter_one(d, &deck_bounds, &g)) return;
  for (int c = 0; c < 2; c++) {
    double limit[2];
    if (!deck_pair(&g, c ? "y" : "x", limit)) continue;
    if (!(limit[1] > limit[0]))
      deck_fail_key(&g, c ? "y" : "x", "expected (lower, upper) with lower < upper");
    b->lower[c] = limit[0];
    b->upper[c] = limit[1];
    b->given = set = true;
  }
  deck_fill(&g, b);
  if (written && !b->given)
    deck_fail(d, g.node, "there is nothing to leave; expected x, y or both");
  if (set && d->reported == 0) check_start(d);
  if (!set && d->reported == 0 && m->container != SD_CONTAINER_NONE) warn_start(d);
}

/* --- overlaps, disks outside the box, disks in walls ------------------------------------------ */

typedef struct teller {
  deck *d;
  size_t found;
} teller;

static void tell_rest(deck *d, size_t found, const char *what) {
  if (found > MOST_ALIKE)
    deck_fail_place(d, (deck_place){d->path, 0}, "%zu more %s", found - MOST_ALIKE, what);
}

/* Reports two disks that overlap more than max_overlap allows. After MOST_ALIKE reports it returns
 * true, so that the search (model/overlaps.h) skips the other overlaps of disk a. */
static bool tell_disks(void *user, const overlap *o) {
  teller *t = user;
  const sd_model *m = t->d->model;
  bool still = m->disks[o->a].driven && m->disks[o->b].driven;
  double smaller = m->disks[o->a].radius;
  if (!o->coincident && (still || o->depth <= m->max_overlap * smaller)) return false;
  if (t->found++ >= MOST_ALIKE) return true;
  uint32_t later = o->a > o->b ? o->a : o->b, earlier = o->a > o->b ? o->b : o->a;
  const char *one = deck_body_name(t->d, later), *two = deck_body_name(t->d, earlier);
  if (o->coincident)
    deck_fail_place(t->d, t->d->disk_place[later], "%s and %s have the same centre", one, two);
  else
    deck_fail_place(t->d, t->d->disk_place[later],
                    "%s and %s overlap by %g, more than max_overlap = %g of the smaller radius %g",
                    one, two, o->depth, m->max_overlap, smaller);
  return false;
}

static bool tell_wall(void *user, const overlap *o) {
  teller *t = user;
  const sd_model *m = t->d->model;
  double radius = rows_disk(m, o->row)->radius;
  if (!(o->depth > m->max_overlap * radius) || t->found++ >= MOST_ALIKE) return false;
  deck_fail_place(t->d, deck_disk_place(t->d, o->a),
                  "%s sits %g deep in %s, more than max_overlap = %g of its radius %g",
                  deck_body_name(t->d, o->a), o->depth, deck_body_name(t->d, o->b), m->max_overlap,
                  radius);
  return false;
}

static void check_inside(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t row = 0; row < rows_count(m); row++)
    for (int c = 0; c < 2; c++) {
      double x = rows_disk(m, row)->position[c];
      if (!m->periodic[c] || isnan(x) || !(m->upper[c] > m->lower[c]) ||
          (x >= m->lower[c] && x < m->upper[c]))
        continue;
      if (found++ >= MOST_ALIKE) continue;
      const uint32_t i = rows_number(m, row);
      deck_fail_place(d, deck_disk_place(d, i),
                      "%s: %c = %g lies outside the periodic box from %g to %g",
                      deck_body_name(d, i), c == SD_X ? 'x' : 'y', x, m->lower[c], m->upper[c]);
    }
  tell_rest(d, found, "coordinates lie outside the periodic box");
}

void deck_check_overlaps(deck *d) {
  teller disks = {.d = d}, walls = {.d = d};
  if (!(d->model->max_overlap > 0)) return;
  check_inside(d);
  sd_status status = overlaps_of_disks(d->model, tell_disks, &disks);
  tell_rest(d, disks.found, "disks overlap others too much");
  if (status == SD_OK) overlaps_with_walls(d->model, tell_wall, &walls);
  if (status != SD_OK) longjmp(d->out_of_memory, 1);
  tell_rest(d, walls.found, "disks sit too deep in a wall");
}
