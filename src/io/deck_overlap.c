/* deck_overlap.c: disks that overlap too much at the start, lie outside the box or sit in a wall. See deck.h.
 *
 * Cells of about one median diameter, as a hash table of lists. Each pair is found from its larger disk,
 * which looks through all cells that it reaches: a few large disks among many small ones stay cheap.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck.h"

/* Of one kind of mistake so many are told, the others are counted: one wrong number can move all disks. */
enum { NONE = -1, MOST_ALIKE = 8 };

typedef struct grid {
  deck *d;
  const sd_model *m;
  size_t n_cells; /* of the hash table, a power of two */
  int64_t *head, *next;
  double cell;
  double length[2]; /* of the box, 0: open */
  size_t *found;
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

static size_t hash(const grid *g, int64_t i, int64_t j) {
  uint64_t h = (uint64_t)i * 0x9E3779B97F4A7C15u ^ ((uint64_t)j * 0xC2B2AE3D27D4EB4Fu + 0x165667B19E3779F9u);
  h ^= h >> 29;
  return (size_t)(h * 0xBF58476D1CE4E5B9u >> 20) & (g->n_cells - 1);
}

/* Far away all cells are one: correct, if slow. */
static int64_t cell_of(const grid *g, double x) {
  return (int64_t)fmax(-1e15, fmin(1e15, floor(x / g->cell)));
}

static const char *name_of(const grid *g, size_t i, char text[96]) {
  return sd_model_body_name(g->m, (uint32_t)i, text, 96);
}

/* Disk j against an image of disk i at x, y. */
static void check_pair(const grid *g, size_t i, size_t j, double x, double y) {
  const sd_disk *a = &g->m->disks[i], *b = &g->m->disks[j];
  if (b->radius > a->radius || (b->radius == a->radius && j <= i)) return;
  double dx = wrapped(g, b->position[0], 0) - x, dy = wrapped(g, b->position[1], 1) - y, r = hypot(dx, dy);
  double overlap = a->radius + b->radius - r, smaller = b->radius;
  bool still = deck_is_driven(g->d, i) && deck_is_driven(g->d, j);
  if (r > 0 && (still || overlap <= g->m->max_overlap * smaller)) return;
  if ((*g->found)++ >= MOST_ALIKE) return;
  char one[96], two[96];
  size_t later = i > j ? i : j, earlier = i > j ? j : i;
  if (r == 0)
    deck_fail_place(g->d, g->d->disk_place[later], "%s and %s have the same centre", name_of(g, later, one),
                    name_of(g, earlier, two));
  else
    deck_fail_place(g->d, g->d->disk_place[later],
                    "%s and %s overlap by %g, more than max_overlap = %g of the smaller radius %g",
                    name_of(g, later, one), name_of(g, earlier, two), overlap, g->m->max_overlap, smaller);
}

static void check_around(const grid *g, size_t i, double x, double y) {
  double reach = 2 * g->m->disks[i].radius;
  int64_t low[2] = {cell_of(g, x - reach), cell_of(g, y - reach)},
          high[2] = {cell_of(g, x + reach), cell_of(g, y + reach)};
  double cells = (double)(high[0] - low[0] + 1) * (double)(high[1] - low[1] + 1);
  if (cells > (double)g->m->n_disks) {
    for (size_t j = 0; j < g->m->n_disks; j++)
      if (j != i && sound(&g->m->disks[j])) check_pair(g, i, j, x, y);
    return;
  }
  for (int64_t p = low[0]; p <= high[0]; p++)
    for (int64_t q = low[1]; q <= high[1]; q++)
      for (int64_t j = g->head[hash(g, p, q)]; j != NONE; j = g->next[j]) {
        /* another cell may share the slot of the table */
        const double *c = g->m->disks[j].position;
        bool here = cell_of(g, wrapped(g, c[0], 0)) == p && cell_of(g, wrapped(g, c[1], 1)) == q;
        if (here && (size_t)j != i) check_pair(g, i, (size_t)j, x, y);
      }
}

static int by_size(const void *a, const void *b) {
  double p = *(const double *)a, q = *(const double *)b;
  return p < q ? -1 : p > q;
}

static double median_diameter(deck *d, size_t *n) {
  const sd_model *m = d->model;
  double *radius = deck_alloc(d, m->n_disks, sizeof *radius);
  *n = 0;
  for (size_t i = 0; i < m->n_disks; i++)
    if (sound(&m->disks[i])) radius[(*n)++] = m->disks[i].radius;
  if (*n) qsort(radius, *n, sizeof *radius, by_size);
  return *n ? 2 * radius[*n / 2] : 1;
}

static void check_disks(deck *d) {
  const sd_model *m = d->model;
  size_t n, found = 0;
  grid g = {.d = d, .m = m, .n_cells = 16, .cell = median_diameter(d, &n), .found = &found};
  for (int c = 0; c < 2; c++)
    if (m->periodic[c] && m->upper[c] > m->lower[c]) g.length[c] = m->upper[c] - m->lower[c];
  while (g.n_cells < 2 * m->n_disks) g.n_cells *= 2;
  g.head = deck_alloc(d, g.n_cells, sizeof *g.head);
  g.next = deck_alloc(d, m->n_disks, sizeof *g.next);
  for (size_t k = 0; k < g.n_cells; k++) g.head[k] = NONE;
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *disk = &m->disks[i];
    if (!sound(disk)) continue;
    size_t slot = hash(&g, cell_of(&g, wrapped(&g, disk->position[0], 0)),
                       cell_of(&g, wrapped(&g, disk->position[1], 1)));
    g.next[i] = g.head[slot];
    g.head[slot] = (int64_t)i;
  }
  for (size_t i = 0; i < m->n_disks; i++) {
    if (!sound(&m->disks[i])) continue;
    double x = wrapped(&g, m->disks[i].position[0], 0), y = wrapped(&g, m->disks[i].position[1], 1);
    double reach = 2 * m->disks[i].radius;
    /* images only where the disk reaches over an edge of the box */
    for (int p = -1; p <= 1; p++)
      for (int q = -1; q <= 1; q++) {
        bool over_x =
            p == 0 || (g.length[0] > 0 && (p < 0 ? x + reach > m->upper[0] : x - reach < m->lower[0]));
        bool over_y =
            q == 0 || (g.length[1] > 0 && (q < 0 ? y + reach > m->upper[1] : y - reach < m->lower[1]));
        if (over_x && over_y) check_around(&g, i, x + p * g.length[0], y + q * g.length[1]);
      }
  }
  tell_rest(d, found, "pairs of disks overlap too much");
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

static double distance_to_piece(const double *p, const double *a, const double *b, bool endless) {
  double tx = b[0] - a[0], ty = b[1] - a[1], l2 = tx * tx + ty * ty;
  double s = ((p[0] - a[0]) * tx + (p[1] - a[1]) * ty) / l2;
  if (!endless) s = fmax(0, fmin(1, s));
  return hypot(p[0] - a[0] - s * tx, p[1] - a[1] - s * ty);
}

/* How deep a disk sits in a wall, not looking at periodic images. */
static double depth_in_wall(const sd_wall *wall, const sd_disk *disk) {
  if (wall->kind == SD_WALL_CIRCLE) {
    double r = hypot(disk->position[0] - wall->pivot[0], disk->position[1] - wall->pivot[1]);
    return wall->inside ? disk->radius + r - wall->radius : disk->radius + wall->radius - r;
  }
  double nearest = HUGE_VAL;
  for (size_t k = 0; k + 1 < wall->n_points + (wall->closed ? 1 : 0); k++)
    nearest =
        fmin(nearest, distance_to_piece(disk->position, wall->points[k],
                                        wall->points[(k + 1) % wall->n_points], wall->kind == SD_WALL_LINE));
  return disk->radius - nearest;
}

static void check_walls(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t w = 0; w < m->n_walls; w++)
    for (size_t i = 0; i < m->n_disks; i++) {
      const sd_disk *disk = &m->disks[i];
      if (!sound(disk) || disk->waiting || deck_is_driven(d, i)) continue;
      double depth = depth_in_wall(&m->walls[w], disk);
      if (!(depth > m->max_overlap * disk->radius)) continue;
      if (found++ >= MOST_ALIKE) continue;
      char one[96], two[96];
      deck_fail_place(
          d, d->disk_place[i], "%s sits %g deep in %s, more than max_overlap = %g of its radius %g",
          sd_model_body_name(m, (uint32_t)i, one, sizeof one), depth,
          sd_model_body_name(m, (uint32_t)(m->n_disks + w), two, sizeof two), m->max_overlap, disk->radius);
    }
  tell_rest(d, found, "disks sit too deep in a wall");
}

void deck_check_overlaps(deck *d) {
  if (!(d->model->max_overlap > 0)) return;
  check_inside(d);
  check_disks(d);
  check_walls(d);
}
