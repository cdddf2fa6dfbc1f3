/* overlaps.c: finds overlapping bodies; see overlaps.h.
 *
 * Each pair of disks is found from its smaller disk. Disks are sorted by size into levels, each a
 * factor of two in radius; a level has a grid of cells, as wide as its largest diameter, and a hash
 * table of cells with a bucket of disks for each. So a disk searches nine cells in its own level
 * and in each level of larger disks, whatever the sizes are. Blocks of 8 by 8 cells are contiguous
 * in the table, so that neighbouring cells are near in memory.
 */
#include "model/overlaps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/buckets.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/clumps.h"
#include "model/laws.h"
#include "model/normal_laws.h"
#include "model/walls.h"

/* A level: disks whose radii lie within a factor of two. Cell indices have type double, so that
 * far cells do not overflow. */
typedef struct level {
  double largest; /* largest radius of a disk in this level */
  /* width of a cell, length */
  double cell;
  size_t n_disks, n_cells; /* number of disks; size of the hash table of cells, a power of two */
  size_t first;            /* first bucket of the table */
} level;

/* Number of size levels, and smallest binary exponent of a radius: all exponents of type double
 * are covered. */
enum { EXPONENTS = 2200, LEAST_EXPONENT = -1100 };

typedef struct grid {
  const sd_model *m;
  overlap_visitor *visit;
  void *user;
  level *levels;         /* one level per binary exponent of the radius; n_disks 0: unused */
  int smallest, largest; /* smallest and largest level in use */
  size_t n_cells;        /* number of buckets: cells of all levels, one level after the other */
  buckets sorted;
  const sd_disk **disk; /* [disks] the disks of each bucket, in the order of larger_first */
  double length[2];     /* length of the periodic box along x and y; 0: not periodic */
} grid;

/* True if the position of a disk is finite and its radius > 0. */
static bool sound(const sd_disk *disk) {
  return isfinite(disk->position[0]) && isfinite(disk->position[1]) && disk->radius > 0;
}

/* Wraps coordinate x into the periodic box. */
static double wrapped(const grid *g, double x, int c) {
  if (g->length[c] <= 0) return x;
  return x - floor((x - g->m->lower[c]) / g->length[c]) * g->length[c];
}

/* Mixes two cell indices into one hash value. */
static uint64_t mixed(double i, double j) {
  uint64_t a, b;
  memcpy(&a, &i, sizeof a);
  memcpy(&b, &j, sizeof b);
  uint64_t h = a * 0x9E3779B97F4A7C15u ^ (b * 0xC2B2AE3D27D4EB4Fu + 0x165667B19E3779F9u);
  h ^= h >> 29;
  return h * 0xBF58476D1CE4E5B9u >> 20;
}

/* Bucket of cell (i, j). The 64 cells of a block of 8 by 8 get distinct neighbouring entries of
 * the table: XOR with the hash of the block spreads the blocks, even if each block has disks
 * only in the same one of its cells. */
static size_t hash(const level *l, double i, double j) {
  enum { SIDE = 8 };
  const double p = floor(i / SIDE) + 0.0, q = floor(j / SIDE) + 0.0;
  const uint64_t block = mixed(p, q),
                 within = (uint64_t)math_max(0.0, (i - SIDE * p) + SIDE * (j - SIDE * q));
  return l->first + (size_t)((block ^ within) & (l->n_cells - 1));
}

/* Index of the cell of coordinate x; + 0.0 turns -0.0 into 0.0. */
static double cell_of(const level *l, double x) { return floor(x / l->cell) + 0.0; }

/* Order of the disks of a bucket: larger ones first, of equal ones those of higher numbers. */
static int larger_first(const void *a, const void *b) {
  const sd_disk *p = *(const sd_disk *const *)a, *q = *(const sd_disk *const *)b;
  if (p->radius != q->radius) return p->radius > q->radius ? -1 : 1;
  return p > q ? -1 : p < q;
}

/* Reports the overlaps of disk i, whose image is at `at`, with those disks in cell (p, q) of a
 * level that come before it in the order of buckets. True: end the search for overlaps of disk
 * i. */
static bool check_cell(grid *g, const level *l, size_t i, const double at[2], double p, double q) {
  const sd_disk *const disks = g->m->disks, *const own = &disks[i];
  const uint32_t *start = &g->sorted.start[hash(l, p, q)];
  for (size_t k = start[0]; k < start[1] && larger_first(&g->disk[k], &own) < 0; k++) {
    const sd_disk *d = g->disk[k];
    const double x = wrapped(g, d->position[0], 0), y = wrapped(g, d->position[1], 1);
    const double dx = x - at[0], dy = y - at[1], touch = (d->radius + own->radius) * (1 + 1e-9);
    if (fabs(dx) > touch || fabs(dy) > touch) continue;
    /* another cell may have the same hash */
    if (cell_of(l, x) != p || cell_of(l, y) != q) continue;
    const size_t j = (size_t)(d - disks);
    const double r = math_hypot(dx, dy);
    const overlap found = {(uint32_t)i, (uint32_t)j, i, own->radius + d->radius - r, r == 0};
    if (found.depth > 0 && !clumps_join(g->m, i, j) && g->visit(g->user, &found)) return true;
  }
  return false;
}

/* Searches the nine cells of a level around an image of disk i at `at`: the sum of its radius
 * and that of any disk in the level is at most one cell width. True: end the search for disk i. */
static bool check_around(grid *g, const level *l, size_t i, const double at[2]) {
  const double reach = (g->m->disks[i].radius + l->largest) * (1 + 1e-9);
  const double x = cell_of(l, at[0]), left = cell_of(l, at[0] - reach),
               right = cell_of(l, at[0] + reach);
  const double y = cell_of(l, at[1]), below = cell_of(l, at[1] - reach),
               above = cell_of(l, at[1] + reach);
  for (int p = -1; p <= 1; p++)
    for (int q = -1; q <= 1; q++) {
      if ((p && x + p == x) || (q && y + q == y))
        continue; /* at this distance adjacent cell indices round to the same double */
      if (x + p < left || x + p > right || y + q < below || y + q > above) continue;
      if (check_cell(g, l, i, at, x + p, y + q)) return true;
    }
  return false;
}

/* Searches a level of disks around all periodic images of disk i that may touch them. True: end
 * the search for overlaps of disk i. */
static bool check_level(grid *g, const level *l, size_t i) {
  double x[2] = {wrapped(g, g->m->disks[i].position[0], 0),
                 wrapped(g, g->m->disks[i].position[1], 1)};
  bool over[2][3];
  for (int c = 0; c < 2; c++) {
    bool box = g->length[c] > 0;
    over[c][0] = box && x[c] + l->cell > g->m->upper[c];
    over[c][1] = true;
    over[c][2] = box && x[c] - l->cell < g->m->lower[c];
  }
  for (int p = -1; p <= 1; p++)
    for (int q = -1; q <= 1; q++) {
      const double at[2] = {x[0] + p * g->length[0], x[1] + q * g->length[1]};
      if (over[0][p + 1] && over[1][q + 1] && check_around(g, l, i, at)) return true;
    }
  return false;
}

/* Returns the size level of a radius, from its binary exponent. */
static int level_of(double radius) {
  int exponent;
  frexp(radius, &exponent);
  return exponent - LEAST_EXPONENT;
}

/* --- buckets of cells ------------------------------------------------------------------------- */

/* Computes the cells of each size level. */
static void make_levels(grid *g) {
  g->levels = memory_new(EXPONENTS, sizeof *g->levels);
  for (size_t i = 0; i < model_held(g->m); i++) {
    if (!sound(&g->m->disks[i])) continue;
    const double radius = g->m->disks[i].radius;
    level *l = &g->levels[level_of(radius)];
    l->n_disks++;
    if (radius > l->largest) l->largest = radius;
  }
  g->smallest = EXPONENTS;
  for (int k = 0; k < EXPONENTS; k++) {
    level *l = &g->levels[k];
    if (l->n_disks == 0) continue;
    if (g->smallest == EXPONENTS) g->smallest = k;
    g->largest = k;
    l->cell = 2 * l->largest;
    l->n_cells = 64;
    while (l->n_cells < 2 * l->n_disks) l->n_cells *= 2;
    l->first = g->n_cells;
    g->n_cells += l->n_cells;
  }
}

static size_t bucket_of_disk(const void *with, size_t i) {
  const grid *g = with;
  const sd_disk *d = &g->m->disks[i];
  if (!sound(d)) return SIZE_MAX;
  const level *l = &g->levels[level_of(d->radius)];
  return hash(l, cell_of(l, wrapped(g, d->position[0], 0)),
              cell_of(l, wrapped(g, d->position[1], 1)));
}

/* Sorts the disks into buckets. Each begins with its largest disk, so that if many disks lie on
 * each other, all but that one find a larger one at once. False: out of memory. */
static bool make_grid(grid *g) {
  const size_t n = model_held(g->m);
  make_levels(g);
  if (!buckets_new(&g->sorted, n, g->n_cells, bucket_of_disk, g) ||
      !memory_resize_row(&g->disk, n, sizeof *g->disk))
    return false;
  const uint32_t *start = g->sorted.start;
  for (size_t k = 0; k < start[g->n_cells]; k++) g->disk[k] = &g->m->disks[g->sorted.item[k]];
  for (size_t c = 0; c < g->n_cells; c++)
    if (start[c + 1] > start[c] + 1)
      qsort(g->disk + start[c], start[c + 1] - start[c], sizeof *g->disk, larger_first);
  return true;
}

sd_status overlaps_of_disks(const sd_model *m, overlap_visitor *visit, void *user) {
  grid g = {.m = m, .visit = visit, .user = user};
  for (int c = 0; c < 2; c++)
    if (m->periodic[c] && m->upper[c] > m->lower[c]) g.length[c] = m->upper[c] - m->lower[c];
  bool made = make_grid(&g);
  for (size_t i = 0; made && i < model_held(m); i++) {
    if (!sound(&m->disks[i])) continue;
    bool done = false;
    for (int k = level_of(m->disks[i].radius); k <= g.largest && !done; k++)
      if (g.levels[k].n_disks > 0) done = check_level(&g, &g.levels[k], i);
  }
  free(g.levels);
  buckets_free(&g.sorted);
  free(g.disk);
  return made ? SD_OK : SD_ERROR_IO;
}

/* --- walls ------------------------------------------------------------------------------------ */

static double distance_to_segment(const double *p, const double *a, const double *b, bool endless) {
  double tx = b[0] - a[0], ty = b[1] - a[1], l2 = tx * tx + ty * ty;
  double s = ((p[0] - a[0]) * tx + (p[1] - a[1]) * ty) / l2;
  if (!endless) s = math_max(0, math_min(1, s));
  return math_hypot(p[0] - a[0] - s * tx, p[1] - a[1] - s * ty);
}

/* The segments of a wall in a binary tree of bounding boxes, so that a disk examines few
 * segments of a long wall. */
typedef struct wall_tree {
  const sd_wall *wall;
  wall_bounds bounds;
  /* n: number of segments; leaves: a power of two >= n. Node k has the children 2k and 2k + 1,
   * leaf i is node leaves + i. */
  size_t n, leaves;
  /* [2 * leaves] bounding boxes of the nodes */
  double (*low)[2], (*high)[2];
} wall_tree;

/* Builds the tree of a wall; it is empty for circles and arcs. */
static wall_tree make_tree(const sd_wall *wall) {
  wall_tree t = {.wall = wall, .bounds = wall_bounds_of(wall), .leaves = 1};
  bool endless = wall->kind == SD_WALL_LINE;
  t.n = wall_segments(wall);
  if (wall->kind == SD_WALL_ARC) t.n = 0;
  if (t.n == 0) return t;
  while (t.leaves < t.n) t.leaves *= 2;
  t.low = memory_new(2 * t.leaves, sizeof *t.low);
  t.high = memory_new(2 * t.leaves, sizeof *t.high);
  for (int c = 0; c < 2; c++) {
    for (size_t i = 0; i < t.leaves; i++) { /* unused leaves are empty boxes */
      double one = i < t.n ? wall->points[i][c] : HUGE_VAL;
      double two = i < t.n ? wall->points[(i + 1) % wall->n_points][c] : -HUGE_VAL;
      t.low[t.leaves + i][c] = endless ? -HUGE_VAL : i < t.n ? math_min(one, two) : one;
      t.high[t.leaves + i][c] = endless ? HUGE_VAL : i < t.n ? math_max(one, two) : two;
    }
    for (size_t k = t.leaves; k-- > 1;) {
      t.low[k][c] = math_min(t.low[2 * k][c], t.low[2 * k + 1][c]);
      t.high[k][c] = math_max(t.high[2 * k][c], t.high[2 * k + 1][c]);
    }
  }
  return t;
}

/* Distance from p to the nearest segment below a node, or `nearest` if none is nearer. */
static double nearest_segment(const wall_tree *t, size_t node, const double *p, double nearest) {
  double dx = math_max(t->low[node][0] - p[0], p[0] - t->high[node][0]);
  double dy = math_max(t->low[node][1] - p[1], p[1] - t->high[node][1]);
  if (math_max(dx, dy) >= nearest) return nearest;
  if (node < t->leaves)
    return nearest_segment(t, 2 * node + 1, p, nearest_segment(t, 2 * node, p, nearest));
  size_t k = node - t->leaves;
  const sd_wall *w = t->wall;
  return math_min(nearest, distance_to_segment(p, w->points[k], w->points[(k + 1) % w->n_points],
                                               w->kind == SD_WALL_LINE));
}

/* Overlap of a disk at p with a wall, without periodic images; <= 0: none. Walls other than
 * circles: 0 if they are farther than the radius. */
static double depth_in_one(const wall_tree *t, const double *p, double radius) {
  const sd_wall *wall = t->wall;
  if (wall->kind == SD_WALL_CIRCLE) {
    double r = math_hypot(p[0] - wall->pivot[0], p[1] - wall->pivot[1]);
    return wall->inside ? radius + r - wall->radius : radius + wall->radius - r;
  }
  if (wall->kind == SD_WALL_ARC) return radius - math_min(radius, arc_distance(wall, p));
  return t->n ? radius - nearest_segment(t, 1, p, radius) : 0;
}

/* Overlap of a disk at p with the nearest periodic image of a wall. */
static double depth_in_wall(const sd_model *m, const wall_tree *t, const double *p, double radius) {
  const wall_range r = wall_range_of(m, t->wall, &t->bounds, p, radius);
  double deepest = -HUGE_VAL;
  for (int64_t v = (int64_t)r.first[1]; v <= (int64_t)r.last[1]; v++)
    for (int64_t u = (int64_t)r.first[0]; u <= (int64_t)r.last[0]; u++) {
      const double at[2] = {p[0] + (double)u * r.length[0], p[1] + (double)v * r.length[1]};
      deepest = math_max(deepest, depth_in_one(t, at, radius));
    }
  return deepest;
}

void overlaps_with_walls(const sd_model *m, overlap_visitor *visit, void *user) {
  for (uint32_t w = 0; w < m->n_walls; w++) {
    wall_tree tree = make_tree(&m->walls[w]);
    for (size_t row = 0; row < rows_count(m); row++) {
      const sd_disk *disk = rows_disk(m, row);
      if (!sound(disk) || disk->waiting || disk->driven) continue;
      const overlap found = {rows_number(m, row), (uint32_t)m->n_disks + w, row,
                             depth_in_wall(m, &tree, disk->position, disk->radius), false};
      if (found.depth > 0) visit(user, &found);
    }
    free(tree.low);
    free(tree.high);
  }
}

/* R_b of the other body of an overlap: negative if disk a lies within the circle of a round wall or
 * arc, 0 for straight walls. */
static double other_radius(const sd_model *m, const overlap *o) {
  if (o->b < m->n_disks) return m->disks[o->b].radius;
  const sd_wall *w = &m->walls[o->b - m->n_disks];
  const double *p = rows_disk(m, o->row)->position;
  if (w->kind == SD_WALL_CIRCLE) return w->inside ? -w->radius : w->radius;
  if (w->kind != SD_WALL_ARC) return 0.0;
  return math_hypot(p[0] - w->center[0], p[1] - w->center[1]) < w->radius ? -w->radius : w->radius;
}

double overlap_force(const sd_model *m, const overlap *o) {
  const sd_disk *a = rows_disk(m, o->row);
  const sd_contact_law *law = sd_model_law(
      m, a->material,
      o->b < m->n_disks ? m->disks[o->b].material : m->walls[o->b - m->n_disks].material);
  if (!law || !law_is_given(law)) return 0.0;
  const sd_contact_law at = law_at(law, law_arm(a->radius, other_radius(m, o)));
  return law_force(&at, o->depth);
}

/* --- gap between two bodies ------------------------------------------------------------------- */

/* Gap between a disk at p and a wall at its initial position. */
static double gap_to_wall(const sd_wall *w, const double *p, double radius) {
  double nearest = HUGE_VAL;
  if (w->kind == SD_WALL_CIRCLE) {
    double r = math_hypot(p[0] - w->pivot[0], p[1] - w->pivot[1]);
    return w->inside ? w->radius - r - radius : r - w->radius - radius;
  }
  if (w->kind == SD_WALL_ARC) return arc_distance(w, p) - radius;
  for (size_t k = 0; k < wall_segments(w); k++)
    nearest =
        math_min(nearest, distance_to_segment(p, w->points[k], w->points[(k + 1) % w->n_points],
                                              w->kind == SD_WALL_LINE));
  return nearest - radius;
}

/* Largest number of box lengths between the image of a wall that is nearest to a disk and the
 * image whose pivot is nearest; 0 for circles and along directions that are not periodic, 1 for
 * lines. */
static int images_of(const sd_wall *w, double length) {
  double farthest = 0;
  if (!(length > 0) || w->kind == SD_WALL_CIRCLE) return 0;
  for (size_t k = 0; w->kind != SD_WALL_LINE && k < w->n_points; k++)
    farthest = math_max(farthest,
                        math_hypot(w->points[k][0] - w->pivot[0], w->points[k][1] - w->pivot[1]));
  return 1 + (int)math_min(farthest / length, 1e3);
}

/* The disk is transformed into the frame of the wall, which stays at its initial position. */
double overlaps_gap(const sd_model *m, uint32_t disk, const double x[2], uint32_t body,
                    const double pose[3]) {
  double d[2], length[2], c, s, radius = m->disks[disk].radius;
  math_sine_cosine(pose[2], &s, &c);
  for (int k = 0; k < 2; k++) {
    length[k] = m->periodic[k] ? m->upper[k] - m->lower[k] : 0;
    d[k] = x[k] - pose[k];
    if (length[k] > 0) d[k] -= length[k] * rint(d[k] / length[k]);
  }
  if (body < m->n_disks) return math_hypot(d[0], d[1]) - radius - m->disks[body].radius;
  const sd_wall *w = &m->walls[body - m->n_disks];
  const int most[2] = {images_of(w, length[0]), images_of(w, length[1])};
  double nearest = HUGE_VAL;
  for (int v = -most[1]; v <= most[1]; v++)
    for (int u = -most[0]; u <= most[0]; u++) {
      const double dx = d[0] + u * length[0], dy = d[1] + v * length[1];
      const double p[2] = {w->pivot[0] + c * dx + s * dy, w->pivot[1] - s * dx + c * dy};
      nearest = math_min(nearest, gap_to_wall(w, p, radius));
    }
  return nearest;
}

double overlaps_first_gap(const sd_model *m, uint32_t disk, uint32_t body) {
  const double *at =
      body < m->n_disks ? m->disks[body].position : m->walls[body - m->n_disks].pivot;
  const double pose[3] = {at[0], at[1], 0};
  return overlaps_gap(m, disk, m->disks[disk].position, body, pose);
}
