/* deck_overlap.c: disks that overlap too much at the start, lie outside the box or sit in a wall. See deck_tree.h.
 *
 * Each pair is found from its smaller disk. Disks are sorted into levels by size, a factor of two in radius each; a
 * level has cells of its largest diameter, as a hash table of lists. So a disk looks at nine cells of every level above
 * its own, whatever the sizes are, and of disks that lie upon each other it looks at the first.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_tree.h"
#include "model/bodies.h"

/* Of one kind of mistake so many are told, the others are counted: one wrong number can move all disks. */
enum { NONE = -1, MOST_ALIKE = 8 };

/* Disks of radii within a factor of two. Cells have numbers of type double: far away they are still apart. */
typedef struct level {
  double cell;
  size_t n_cells; /* of the hash table, a power of two */
  int64_t *head;
} level;

typedef struct grid {
  deck *d;
  const sd_model *m;
  size_t n_levels;
  level *levels;    /* the smallest first */
  int64_t *next;    /* of each disk: the next in its list */
  double length[2]; /* of the box, 0: open */
  size_t found;
} grid;

static void tell_rest(deck *d, size_t found, const char *what) {
  if (found > MOST_ALIKE)
    deck_fail_place(d, (deck_place){d->path, 0}, "%zu more %s", found - MOST_ALIKE, what);
}

static bool sound(const sd_disk *disk) {
  return isfinite(disk->position[0]) && isfinite(disk->position[1]) && disk->radius > 0;
}

static double wrapped(const grid *g, double x, int c) {
  if (g->length[c] <= 0) return x;
  return x - floor((x - g->m->lower[c]) / g->length[c]) * g->length[c];
}

static size_t hash(const level *l, double i, double j) {
  uint64_t a, b;
  memcpy(&a, &i, sizeof a);
  memcpy(&b, &j, sizeof b);
  uint64_t h = a * 0x9E3779B97F4A7C15u ^ (b * 0xC2B2AE3D27D4EB4Fu + 0x165667B19E3779F9u);
  h ^= h >> 29;
  return (size_t)(h * 0xBF58476D1CE4E5B9u >> 20) & (l->n_cells - 1);
}

/* + 0.0: there is one zero only. */
static double cell_of(const level *l, double x) { return floor(x / l->cell) + 0.0; }

static const char *name_of(const grid *g, size_t i, char text[96]) {
  return sd_model_body_name(g->m, (uint32_t)i, text, 96);
}

/* Disk j, as large or larger, against an image of disk i at x, y. True: they overlap too much. */
static bool check_pair(grid *g, size_t i, size_t j, double x, double y) {
  const sd_disk *a = &g->m->disks[i], *b = &g->m->disks[j];
  if (b->radius < a->radius || (b->radius == a->radius && j <= i)) return false;
  double dx = wrapped(g, b->position[0], 0) - x, dy = wrapped(g, b->position[1], 1) - y, r = hypot(dx, dy);
  double overlap = a->radius + b->radius - r, smaller = a->radius;
  bool still = a->driven && b->driven;
  if (r > 0 && (still || overlap <= g->m->max_overlap * smaller)) return false;
  if (g->found++ >= MOST_ALIKE) return true;
  char one[96], two[96];
  size_t later = i > j ? i : j, earlier = i > j ? j : i;
  if (r == 0)
    deck_fail_place(g->d, g->d->disk_place[later], "%s and %s have the same centre", name_of(g, later, one),
                    name_of(g, earlier, two));
  else
    deck_fail_place(g->d, g->d->disk_place[later],
                    "%s and %s overlap by %g, more than max_overlap = %g of the smaller radius %g",
                    name_of(g, later, one), name_of(g, earlier, two), overlap, g->m->max_overlap, smaller);
  return true;
}

/* Overlaps of one cell. When enough was told one pair of each disk is counted: true, then the disk is done. */
static bool check_cell(grid *g, const level *l, size_t i, const double at[2], double p, double q) {
  for (int64_t j = l->head[hash(l, p, q)]; j != NONE; j = g->next[j]) {
    /* another cell may share the slot of the table */
    const double *c = g->m->disks[j].position;
    bool here = cell_of(l, wrapped(g, c[0], 0)) == p && cell_of(l, wrapped(g, c[1], 1)) == q;
    if (here && (size_t)j != i && check_pair(g, i, (size_t)j, at[0], at[1]) && g->found > MOST_ALIKE)
      return true;
  }
  return false;
}

/* The disk reaches no farther than one cell: its radius and that of the other make one at most. */
static bool check_around(grid *g, const level *l, size_t i, const double at[2]) {
  for (int p = -1; p <= 1; p++)
    for (int q = -1; q <= 1; q++) {
      double x = cell_of(l, at[0]), y = cell_of(l, at[1]);
      if ((p && x + p == x) || (q && y + q == y)) continue; /* so far away that there are no next cells */
      if (check_cell(g, l, i, at, x + p, y + q)) return true;
    }
  return false;
}

/* All images of a disk that may touch a disk of the level. */
static bool check_level(grid *g, const level *l, size_t i) {
  double x[2] = {wrapped(g, g->m->disks[i].position[0], 0), wrapped(g, g->m->disks[i].position[1], 1)};
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

static int level_of(double radius) {
  int exponent;
  frexp(radius, &exponent);
  return exponent;
}

typedef struct sized {
  double radius;
  size_t disk;
} sized;

static int by_size(const void *a, const void *b) {
  const sized *p = a, *q = b;
  if (p->radius != q->radius) return p->radius < q->radius ? -1 : 1;
  return p->disk < q->disk ? -1 : 1;
}

/* All sound disks, the smallest first. */
static sized *sort_disks(grid *g, size_t *n) {
  const sd_model *m = g->m;
  sized *all = deck_alloc(g->d, m->n_disks, sizeof *all);
  *n = 0;
  for (size_t i = 0; i < m->n_disks; i++)
    if (sound(&m->disks[i])) all[(*n)++] = (sized){m->disks[i].radius, i};
  if (*n) qsort(all, *n, sizeof *all, by_size);
  return all;
}

/* Lists of the disks by level and cell. Each begins with the largest, so that of disks upon each other all but that one
 * find a larger one at once. */
static void make_grid(grid *g) {
  const sd_model *m = g->m;
  size_t n;
  const sized *all = sort_disks(g, &n);
  g->next = deck_alloc(g->d, m->n_disks, sizeof *g->next);
  for (size_t first = 0, end; first < n; first = end) {
    int size = level_of(all[first].radius);
    for (end = first; end < n && level_of(all[end].radius) == size;) end++;
    g->levels = deck_more(g->d, g->levels, g->n_levels, g->n_levels + 1, sizeof *g->levels);
    level *l = &g->levels[g->n_levels++];
    *l = (level){.cell = ldexp(2, size), .n_cells = 16};
    while (l->n_cells < 2 * (end - first)) l->n_cells *= 2;
    l->head = deck_alloc(g->d, l->n_cells, sizeof *l->head);
    for (size_t k = 0; k < l->n_cells; k++) l->head[k] = NONE;
    for (size_t k = first; k < end; k++) {
      const double *x = m->disks[all[k].disk].position;
      size_t slot = hash(l, cell_of(l, wrapped(g, x[0], 0)), cell_of(l, wrapped(g, x[1], 1)));
      g->next[all[k].disk] = l->head[slot];
      l->head[slot] = (int64_t)all[k].disk;
    }
  }
}

static void check_disks(deck *d) {
  const sd_model *m = d->model;
  grid g = {.d = d, .m = m};
  for (int c = 0; c < 2; c++)
    if (m->periodic[c] && m->upper[c] > m->lower[c]) g.length[c] = m->upper[c] - m->lower[c];
  make_grid(&g);
  for (size_t i = 0; i < m->n_disks; i++) {
    if (!sound(&m->disks[i])) continue;
    bool done = false;
    for (size_t k = 0; k < g.n_levels && !done; k++)
      if (g.levels[k].cell > 2 * m->disks[i].radius) done = check_level(&g, &g.levels[k], i);
  }
  tell_rest(d, g.found, "disks overlap others too much");
}

/* --- box and walls --------------------------------------------------------------------------------------- */

static void check_inside(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t i = 0; i < m->n_disks; i++)
    for (int c = 0; c < 2; c++) {
      double x = m->disks[i].position[c];
      if (!m->periodic[c] || isnan(x) || !(m->upper[c] > m->lower[c]) ||
          (x >= m->lower[c] && x < m->upper[c]))
        continue;
      if (found++ >= MOST_ALIKE) continue;
      char name[96];
      deck_fail_place(d, d->disk_place[i], "%s: %c = %g lies outside the periodic box from %g to %g",
                      sd_model_body_name(m, (uint32_t)i, name, sizeof name), "xy"[c], x, m -> lower[c],
                      m -> upper[c]);
    }
  tell_rest(d, found, "coordinates lie outside the periodic box");
}

static double distance_to_segment(const double *p, const double *a, const double *b, bool endless) {
  double tx = b[0] - a[0], ty = b[1] - a[1], l2 = tx * tx + ty * ty;
  double s = ((p[0] - a[0]) * tx + (p[1] - a[1]) * ty) / l2;
  if (!endless) s = fmax(0, fmin(1, s));
  return hypot(p[0] - a[0] - s * tx, p[1] - a[1] - s * ty);
}

/* The segments of a wall, in a binary tree of boxes around runs of them: of a long wall a disk looks at few. */
typedef struct wall_tree {
  const sd_wall *wall;
  size_t n, leaves; /* a power of two; node k has the children 2k and 2k + 1, leaf i is node leaves + i */
  double (*low)[2], (*high)[2];
} wall_tree;

static wall_tree make_tree(deck *d, const sd_wall *wall) {
  wall_tree t = {.wall = wall, .leaves = 1};
  bool endless = wall->kind == SD_WALL_LINE;
  t.n = wall_segments(wall);
  if (t.n == 0) return t;
  while (t.leaves < t.n) t.leaves *= 2;
  t.low = deck_alloc(d, 2 * t.leaves, sizeof *t.low);
  t.high = deck_alloc(d, 2 * t.leaves, sizeof *t.high);
  for (int c = 0; c < 2; c++) {
    for (size_t i = 0; i < t.leaves; i++) { /* leaves without a segment are empty boxes */
      double one = i < t.n ? wall->points[i][c] : HUGE_VAL;
      double two = i < t.n ? wall->points[(i + 1) % wall->n_points][c] : -HUGE_VAL;
      t.low[t.leaves + i][c] = endless ? -HUGE_VAL : i < t.n ? fmin(one, two) : one;
      t.high[t.leaves + i][c] = endless ? HUGE_VAL : i < t.n ? fmax(one, two) : two;
    }
    for (size_t k = t.leaves; k-- > 1;) {
      t.low[k][c] = fmin(t.low[2 * k][c], t.low[2 * k + 1][c]);
      t.high[k][c] = fmax(t.high[2 * k][c], t.high[2 * k + 1][c]);
    }
  }
  return t;
}

/* The distance to the nearest segment below the node, if it is less than `nearest`. */
static double nearest_segment(const wall_tree *t, size_t node, const double *p, double nearest) {
  double dx = fmax(t->low[node][0] - p[0], p[0] - t->high[node][0]);
  double dy = fmax(t->low[node][1] - p[1], p[1] - t->high[node][1]);
  if (fmax(dx, dy) >= nearest) return nearest;
  if (node < t->leaves) return nearest_segment(t, 2 * node + 1, p, nearest_segment(t, 2 * node, p, nearest));
  size_t k = node - t->leaves;
  const sd_wall *w = t->wall;
  return fmin(nearest, distance_to_segment(p, w->points[k], w->points[(k + 1) % w->n_points],
                                           w->kind == SD_WALL_LINE));
}

/* How deep a disk sits in a wall, not looking at periodic images; 0 or less: it does not. */
static double depth_in_wall(const wall_tree *t, const sd_disk *disk) {
  const sd_wall *wall = t->wall;
  if (wall->kind == SD_WALL_CIRCLE) {
    double r = hypot(disk->position[0] - wall->pivot[0], disk->position[1] - wall->pivot[1]);
    return wall->inside ? disk->radius + r - wall->radius : disk->radius + wall->radius - r;
  }
  return t->n ? disk->radius - nearest_segment(t, 1, disk->position, disk->radius) : 0;
}

static void check_walls(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t w = 0; w < m->n_walls; w++) {
    wall_tree tree = make_tree(d, &m->walls[w]);
    for (size_t i = 0; i < m->n_disks; i++) {
      const sd_disk *disk = &m->disks[i];
      if (!sound(disk) || disk->waiting || disk->driven) continue;
      double depth = depth_in_wall(&tree, disk);
      if (!(depth > m->max_overlap * disk->radius)) continue;
      if (found++ >= MOST_ALIKE) continue;
      char one[96], two[96];
      deck_fail_place(
          d, d->disk_place[i], "%s sits %g deep in %s, more than max_overlap = %g of its radius %g",
          sd_model_body_name(m, (uint32_t)i, one, sizeof one), depth,
          sd_model_body_name(m, (uint32_t)(m->n_disks + w), two, sizeof two), m->max_overlap, disk->radius);
    }
  }
  tell_rest(d, found, "disks sit too deep in a wall");
}

void deck_check_overlaps(deck *d) {
  if (!(d->model->max_overlap > 0)) return;
  check_inside(d);
  check_disks(d);
  check_walls(d);
}
