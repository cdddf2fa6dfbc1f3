/* cells.c: computes the radical (power, Laguerre) cells of disks with several threads (see
 * cells.h). */
#include "measure/cells.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/buckets.h"
#include "base/gsl.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/team.h"
#include "measure/statistics.h"
#include "model/model.h"
#include "physics/contact/walls.h"

/* --- circles and the search by power distance ------------------------------------------------- */

/* Sites (circles in the plane), and the search for the site nearest to a point by power distance
 * |x - c|^2 - R^2, with c the centre and R the radius of the site.
 *
 * Sites whose radii are within one factor of two (octave) are sorted into a grid of their own. A
 * search goes outwards from the point, ring by ring of grid cells, until no site of the octave can
 * be nearer. */

enum { SITES_OCTAVES = 10 };

typedef struct sites_grid {
  size_t n;                         /* number of sites in the grid */
  double largest;                   /* largest radius of these sites */
  double lower[2], upper[2], width; /* rectangle around their centres; width of a cell */
  size_t cells[2], first;           /* number of cells along x and y; first bucket of the grid */
} sites_grid;

typedef struct sites {
  /* n: number of sites, disks first, then their periodic images; n_disks: number of disks;
   * capacity: allocated rows */
  size_t n, n_disks, capacity;
  double (*at)[2];
  double *radius;
  unsigned char *octave_of; /* [n] octave of each site's radius, set by sites_sort */
  bool one_octave;          /* true if all sites have the same octave */
  double centre[2], size;   /* centre and side length of a square around the region and all sites */
  sites_grid octave[SITES_OCTAVES];
  buckets sorted; /* sites of each cell, all grids one after the other */
} sites;

/* Rectangle of grid cells that was searched for sites. */
typedef struct sites_block {
  double lower[2], upper[2];
  bool complete; /* true if all sites with centres in the rectangle were found */
} sites_block;

/* Adds a site. SD_ERROR_IO: out of memory. */
static sd_status sites_add(sites *s, double x, double y, double radius) {
  if (s->n == s->capacity) {
    size_t capacity = 2 * s->capacity + 64;
    const memory_column rows[] = {{&s->at, capacity, sizeof *s->at},
                                  {&s->radius, capacity, sizeof *s->radius},
                                  {&s->octave_of, capacity, sizeof *s->octave_of}};
    if (!memory_resize(sizeof rows / sizeof *rows, rows)) return SD_ERROR_IO;
    s->capacity = capacity;
  }
  s->at[s->n][0] = x;
  s->at[s->n][1] = y;
  s->radius[s->n++] = radius;
  return SD_OK;
}

static void sites_free(sites *s) {
  free(s->at);
  free(s->radius);
  free(s->octave_of);
  buckets_free(&s->sorted);
  *s = (sites){0};
}

/* --- grids ------------------------------------------------------------------------------------ */

static int octave_of(double radius, double largest) {
  int o = SITES_OCTAVES;
  if (radius > 0.0 && isfinite(largest / radius)) frexp(largest / radius, &o);
  o = o < SITES_OCTAVES ? o - 1 : SITES_OCTAVES - 1;
  return o > 0 ? o : 0;
}

/* Returns the index along coordinate k (0: x, 1: y) of the grid cell that contains the coordinate
 * `at`; the first or the last cell if `at` is outside the grid. */
static size_t cell_along(const sites_grid *g, int k, double at) {
  return cell_nearest((at - g->lower[k]) / g->width, g->cells[k]);
}

static size_t cell_of(const void *with, size_t i) {
  const sites *s = with;
  const sites_grid *g = &s->octave[s->octave_of[i]];
  const double *at = s->at[i];
  return g->first + cell_along(g, 1, at[1]) * g->cells[0] + cell_along(g, 0, at[0]);
}

/* Divides the rectangle of the grid into square cells with about two sites each. Returns the number
 * of cells. */
static size_t shape(sites_grid *g) {
  const double x = g->upper[0] - g->lower[0], y = g->upper[1] - g->lower[1], n = (double)g->n;
  g->width = math_max(sqrt(2.0 * x * y / n), math_max(x, y) / n);
  if (!(g->width > 0.0)) g->width = 1.0;
  g->cells[0] = (size_t)floor(x / g->width) + 1;
  g->cells[1] = (size_t)floor(y / g->width) + 1;
  return g->cells[0] * g->cells[1];
}

/* Sorts all sites into the grids of their octaves. Call it when all sites have been added.
 * SD_ERROR_IO: out of memory. */
static sd_status sites_sort(sites *s) {
  double largest = 0.0;
  size_t n_cells = 0;
  for (size_t i = 0; i < s->n; i++) largest = math_max(largest, s->radius[i]);
  for (int o = 0; o < SITES_OCTAVES; o++)
    s->octave[o] = (sites_grid){.lower = {HUGE_VAL, HUGE_VAL}, .upper = {-HUGE_VAL, -HUGE_VAL}};
  for (size_t i = 0; i < s->n; i++) {
    sites_grid *g = &s->octave[s->octave_of[i] = (unsigned char)octave_of(s->radius[i], largest)];
    g->n++;
    g->largest = math_max(g->largest, s->radius[i]);
    for (int k = 0; k < 2; k++) {
      g->lower[k] = math_min(g->lower[k], s->at[i][k]);
      g->upper[k] = math_max(g->upper[k], s->at[i][k]);
    }
  }
  for (int o = 0; o < SITES_OCTAVES; o++) {
    sites_grid *g = &s->octave[o];
    g->first = n_cells;
    if (g->n > 0) n_cells += shape(g);
    s->one_octave = s->one_octave || g->n == s->n;
  }
  return buckets_new(&s->sorted, s->n, n_cells, cell_of, s) ? SD_OK : SD_ERROR_IO;
}

/* --- searches --------------------------------------------------------------------------------- */

typedef struct search {
  const sites *s;
  size_t own, found;
  /* at: the point; least: smallest power distance so far, which is that of site `found` */
  double at[2], least;
} search;

static void look(search *q, const sites_grid *g, size_t x, size_t y) {
  const size_t c = g->first + y * g->cells[0] + x;
  const buckets *b = &q->s->sorted;
  for (size_t k = b->start[c]; k < b->start[c + 1]; k++) {
    const size_t i = b->item[k];
    const double dx = q->s->at[i][0] - q->at[0], dy = q->s->at[i][1] - q->at[1],
                 r = q->s->radius[i];
    const double power = dx * dx + dy * dy - r * r;
    if (!(power < q->least) || i == q->own) continue;
    q->least = power;
    q->found = i;
  }
}

/* Searches the square ring of cells that are `ring` cells away from the middle one; parts of the
 * ring outside the grid are skipped. */
static void look_around(search *q, const sites_grid *g, const size_t middle[2], size_t ring) {
  const int64_t r = (int64_t)ring, nx = (int64_t)g->cells[0], ny = (int64_t)g->cells[1];
  const int64_t mx = (int64_t)middle[0], my = (int64_t)middle[1];
  for (int64_t y = my - r > 0 ? my - r : 0; y <= my + r && y < ny; y++) {
    const bool edge = y == my - r || y == my + r;
    if (edge) {
      for (int64_t x = mx - r > 0 ? mx - r : 0; x <= mx + r && x < nx; x++)
        look(q, g, (size_t)x, (size_t)y);
    } else {
      if (mx - r >= 0) look(q, g, (size_t)(mx - r), (size_t)y);
      if (mx + r < nx) look(q, g, (size_t)(mx + r), (size_t)y);
    }
  }
}

/* Searches the grid of one octave: the cell nearest to the point, then rings of cells around it,
 * until no site farther out can be nearer than the best one found. For a point outside the grid,
 * the lower bound of the distance to a ring includes the distance of the point from the grid. */
static void search_octave(search *q, const sites_grid *g) {
  size_t middle[2], last = 0;
  /* beyond: distance of the point from the grid along x and y, 0 inside; inner: distance from the
   * point to the nearest edge of the middle cell, 0 outside the cell */
  double beyond[2], inner = HUGE_VAL;
  for (int k = 0; k < 2; k++) {
    const double top = g->lower[k] + (double)g->cells[k] * g->width;
    middle[k] = cell_along(g, k, q->at[k]);
    beyond[k] = math_max(math_max(g->lower[k] - q->at[k], q->at[k] - top), 0.0);
    const double low = g->lower[k] + (double)middle[k] * g->width;
    inner = math_min(inner, math_max(math_min(q->at[k] - low, low + g->width - q->at[k]), 0.0));
    const size_t after = g->cells[k] - 1 - middle[k];
    last = middle[k] > last ? middle[k] : last;
    last = after > last ? after : last;
  }
  for (size_t ring = 0; ring <= last; ring++) {
    const double far = ring > 0 ? (double)(ring - 1) * g->width + inner : 0.0;
    const double x = beyond[0] + far, y = beyond[1] + far;
    const double nearest = math_min(x * x + beyond[1] * beyond[1], beyond[0] * beyond[0] + y * y);
    if (nearest - g->largest * g->largest > q->least) return;
    look_around(q, g, middle, ring);
  }
}

/* Returns the site other than `own` whose power distance from `at` is the smallest and below
 * `most`; SIZE_MAX: none. */
static size_t sites_nearest(const sites *s, size_t own, const double at[2], double most) {
  search q = {.s = s, .own = own, .found = SIZE_MAX, .at = {at[0], at[1]}, .least = most};
  for (int o = 0; o < SITES_OCTAVES; o++)
    if (s->octave[o].n > 0) search_octave(&q, &s->octave[o]);
  return q.found;
}

/* Finds the sites of the same octave in the 3 x 3 grid cells around site i, without i itself.
 * Returns their number, at most `room`; *block receives the rectangle of these cells. */
static size_t sites_around(const sites *s, size_t i, uint32_t *found, size_t room,
                           sites_block *block) {
  const sites_grid *g = &s->octave[s->octave_of[i]];
  const size_t x = cell_along(g, 0, s->at[i][0]), y = cell_along(g, 1, s->at[i][1]);
  size_t n = 0;
  for (size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < g->cells[1]; v++)
    for (size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < g->cells[0]; u++)
      for (size_t c = g->first + v * g->cells[0] + u, k = s->sorted.start[c];
           k < s->sorted.start[c + 1] && n < room; k++)
        if (s->sorted.item[k] != i) found[n++] = s->sorted.item[k];
  block->complete = s->one_octave && n < room;
  for (int k = 0; k < 2; k++) {
    block->lower[k] = g->lower[k] + ((double)(k ? y : x) - 1.0) * g->width;
    block->upper[k] = block->lower[k] + 3.0 * g->width;
  }
  return n;
}

/* --- sites ------------------------------------------------------------------------------------ */

/* Adds those periodic images of the disks whose centres lie at most `margin` (along x and y)
 * outside the periodic box. */
static sd_status add_images(sites *s, const configuration *c, const double margin[2]) {
  const sd_model *m = c->model;
  sd_status status = SD_OK;
  /* The images above and below a sheared box are shifted in x by up to half its length, so use two
   * images on each side in x. */
  const int most = c->offset != 0.0 ? 2 : 1;
  for (int j = -1; j <= 1; j++)
    for (int i = -most; i <= most; i++) {
      double shift[2] = {i * c->length[0] + j * c->offset, j * c->length[1]};
      if ((i == 0 && j == 0) || (i != 0 && shift[0] == 0.0) || (j != 0 && shift[1] == 0.0))
        continue;
      for (size_t k = 0; status == SD_OK && k < m->n_disks; k++) {
        bool near = true;
        double at[2];
        for (int x = 0; x < 2; x++) {
          at[x] = m->disks[k].position[x] + shift[x];
          if (shift[x] != 0.0)
            near = near && at[x] >= m->lower[x] - margin[x] && at[x] <= m->upper[x] + margin[x];
        }
        if (near) status = sites_add(s, at[0], at[1], m->disks[k].radius);
      }
    }
  return status;
}

static sd_status sites_new(sites *s, const configuration *c, const region *g,
                           const double margin[2]) {
  const sd_model *m = c->model;
  sd_status status = SD_OK;
  *s = (sites){.n_disks = m->n_disks};
  double lower[2], upper[2];
  for (int k = 0; k < 2; k++) lower[k] = g->lower[k], upper[k] = g->upper[k];
  for (size_t i = 0; status == SD_OK && i < m->n_disks; i++)
    status = sites_add(s, m->disks[i].position[0], m->disks[i].position[1], m->disks[i].radius);
  if (status == SD_OK) status = add_images(s, c, margin);
  for (size_t i = 0; i < s->n; i++)
    for (int k = 0; k < 2; k++) {
      lower[k] = math_min(lower[k], s->at[i][k] - s->radius[i]);
      upper[k] = math_max(upper[k], s->at[i][k] + s->radius[i]);
    }
  for (int k = 0; k < 2; k++) s->centre[k] = 0.5 * (lower[k] + upper[k]);
  s->size = math_max(upper[0] - lower[0], upper[1] - lower[1]);
  return status == SD_OK ? sites_sort(s) : status;
}

/* --- one cell --------------------------------------------------------------------------------- */

enum { MOST_CORNERS = 2048 };
/* line on which an edge of a cell lies: radical line with a neighbour, wall, edge of the region, or
 * side of the initial rectangle */
enum { BY_NEIGHBOUR, BY_WALL, BY_REGION, BY_NOTHING };

/* Convex polygon (a cell) in coordinates relative to the centre of its disk. Edge k goes from
 * corner k to the next corner. */
typedef struct polygon {
  size_t n;
  double at[MOST_CORNERS][2];
  unsigned char edge[MOST_CORNERS];
  bool sure[MOST_CORNERS]; /* true if no site is nearer to this corner than the disk itself */
} polygon;

static void polygon_box(polygon *p, double half_x, double half_y) {
  p->n = 4;
  for (int k = 0; k < 4; k++) {
    p->at[k][0] = k == 1 || k == 2 ? half_x : -half_x;
    p->at[k][1] = k >= 2 ? half_y : -half_y;
    p->edge[k] = BY_NOTHING;
    p->sure[k] = false;
  }
}

/* Cuts off the part of the polygon with n.x > d, unless this part is at most `slack` deep. by: kind
 * of the new edge (BY_...). Returns false if the polygon has too many corners. */
static bool polygon_cut(polygon *p, double nx, double ny, double d, double slack,
                        unsigned char by) {
  double deepest = 0.0;
  for (size_t k = 0; k < p->n; k++) {
    const double depth = nx * p->at[k][0] + ny * p->at[k][1] - d;
    if (depth > deepest) deepest = depth;
  }
  if (!(deepest > slack)) return true;
  if (p->n + 2 > MOST_CORNERS) return false;
  polygon from;
  from.n = p->n;
  memcpy(from.at, p->at, p->n * sizeof *p->at);
  memcpy(from.edge, p->edge, p->n);
  memcpy(from.sure, p->sure, p->n);
  p->n = 0;
  for (size_t k = 0; k < from.n; k++) {
    const double *a = from.at[k], *b = from.at[k + 1 < from.n ? k + 1 : 0];
    double da = nx * a[0] + ny * a[1] - d, db = nx * b[0] + ny * b[1] - d;
    if (da <= 0.0) {
      p->at[p->n][0] = a[0];
      p->at[p->n][1] = a[1];
      p->sure[p->n] = from.sure[k];
      p->edge[p->n++] = from.edge[k];
    }
    if ((da <= 0.0) == (db <= 0.0)) continue;
    double t = da / (da - db);
    p->at[p->n][0] = a[0] + t * (b[0] - a[0]);
    p->at[p->n][1] = a[1] + t * (b[1] - a[1]);
    p->sure[p->n] = false;
    p->edge[p->n++] = da <= 0.0 ? by : from.edge[k];
  }
  return true;
}

static double polygon_area(const polygon *p) {
  double twice = 0.0;
  for (size_t k = 0; k < p->n; k++) {
    const double *a = p->at[k], *b = p->at[k + 1 < p->n ? k + 1 : 0];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * twice;
}

typedef struct cutter {
  const configuration *c;
  const region *whole;
  const sites *s;
  /* margin: distance from the box, along x and y, within which periodic images are sites; largest:
   * largest radius of all disks */
  double margin[2], largest;
  /* true if a cell may have a neighbour among the periodic images that are not sites */
  bool short_of_images;
} cutter;

/* Cuts the cell p of disk i by its radical line with site j. Returns false if the polygon has too
 * many corners. */
static bool cut_site(const sites *s, size_t i, size_t j, polygon *p) {
  double dx = s->at[j][0] - s->at[i][0], dy = s->at[j][1] - s->at[i][1];
  double d =
      0.5 * (dx * dx + dy * dy + (s->radius[i] + s->radius[j]) * (s->radius[i] - s->radius[j]));
  return polygon_cut(p, dx, dy, d, 0.0, BY_NEIGHBOUR);
}

/* Returns true if all sites in the block were found and no site outside it can have a power
 * distance below `power` from the point `at`. largest: largest radius of all sites. */
static bool block_decides(const sites_block *b, const double at[2], double power, double largest) {
  static const double slack = 1e-9; /* tolerance for rounding in the positions of grid cells */
  double gap = HUGE_VAL;
  for (int k = 0; k < 2; k++) {
    const double below = at[k] - b->lower[k], above = b->upper[k] - at[k];
    gap = below < gap ? below : gap;
    gap = above < gap ? above : gap;
  }
  gap *= 1.0 - slack;
  return b->complete && gap > 0.0 && gap * gap - largest * largest > power;
}

/* Cuts the cell of disk i by its neighbours: first by the sites near it, then by the site nearest
 * to each corner, until the disk itself is nearest to all corners. A site that has cut this cell
 * before can be nearer only by rounding and does not cut again. Returns false if the polygon has
 * too many corners. */
static bool cut_neighbours(const sites *s, size_t i, double largest, polygon *p) {
  static const double rounding = 1e-14;
  uint32_t used[MOST_CORNERS];
  enum { NEAR = 64 };
  sites_block block;
  size_t n = sites_around(s, i, used, NEAR, &block);
  for (size_t k = 0; k < n; k++)
    if (!cut_site(s, i, used[k], p)) return false;
  for (size_t k = 0; k < p->n;) {
    if (p->sure[k]) {
      k++;
      continue;
    }
    const double x = p->at[k][0], y = p->at[k][1], far = x * x + y * y, r = s->radius[i];
    const double at[2] = {s->at[i][0] + x, s->at[i][1] + y};
    if (block_decides(&block, at, far - r * r, largest)) {
      p->sure[k++] = true;
      continue;
    }
    const size_t j = sites_nearest(s, i, at, far - r * r - rounding * (far + r * r));
    bool known = j == SIZE_MAX;
    for (size_t u = 0; u < n && !known; u++) known = used[u] == j;
    if (known) {
      p->sure[k] = true;
      continue;
    }
    if (n == MOST_CORNERS || !cut_site(s, i, j, p)) return false;
    used[n++] = (uint32_t)j;
    k = 0;
  }
  return true;
}

/* Returns true if a periodic image outside the margin, which is therefore not a site, could be
 * nearer to a corner of the cell than disk i: its centre would lie within `reach` of the corner. */
static bool needs_images(const cutter *q, size_t i, const polygon *p) {
  const sd_model *m = q->c->model;
  double r = q->s->radius[i];
  if (q->c->length[0] == 0.0 && q->c->length[1] == 0.0) return false;
  for (size_t k = 0; k < p->n; k++) {
    double x = p->at[k][0], y = p->at[k][1];
    double reach = sqrt(math_max(x * x + y * y - r * r + q->largest * q->largest, 0.0));
    for (int c = 0; c < 2; c++) {
      double length = q->c->length[c], corner = q->s->at[i][c] + p->at[k][c];
      if (length == 0.0 || q->margin[c] >= length) continue;
      if (corner - reach < m->lower[c] - q->margin[c] ||
          corner + reach > m->upper[c] + q->margin[c])
        return true;
    }
  }
  return false;
}

/* Cuts a cell by the tangent to an arc-shaped wall segment, at the point of the arc nearest to
 * `at`. */
static void cut_arc(const placed_segment *g, const double *at, polygon *p) {
  const nearest_point q = walls_nearest(g, at[0], at[1]);
  const double r = math_hypot(q.dx, q.dy);
  if (q.active && q.flat && r > 0.0) polygon_cut(p, q.dx / r, q.dy / r, r, 0.0, BY_WALL);
}

/* Cuts a cell by each wall segment that the disk faces, i.e. on which the foot of the perpendicular
 * from its centre lies. */
static void cut_walls(const cutter *q, size_t i, polygon *p) {
  const sd_model *m = q->c->model;
  const double *at = q->s->at[i];
  for (size_t k = 0; k < m->n_segments; k++) {
    const sd_segment *g = &m->segments[k];
    const double *pivot = m->walls[g->body - m->n_disks].pivot;
    const placed_segment placed = walls_place(g, pivot[0], pivot[1], 1.0, 0.0, 1.0);
    placed_segment image;
    const placed_segment *nearest = walls_image(q->c->length, &placed, at[0], at[1], &image);
    if (g->piece != SD_PIECE_STRAIGHT) {
      cut_arc(nearest, at, p);
      continue;
    }
    double rx = nearest->x - at[0], ry = nearest->y - at[1];
    double u = -(rx * g->tangent[0] + ry * g->tangent[1]);
    if (g->length < HUGE_VAL && (u < 0.0 || u > g->length)) continue;
    double nx = g->tangent[1], ny = -g->tangent[0], d = nx * rx + ny * ry;
    polygon_cut(p, d < 0.0 ? -nx : nx, d < 0.0 ? -ny : ny, fabs(d), 0.0, BY_WALL);
  }
}

/* Cuts a cell by the edges of the region. An edge that would cut off a part at most half a radius
 * deep is skipped, so that a wall that has moved slightly beyond this edge bounds the cell
 * instead. */
static void cut_region(const cutter *q, size_t i, polygon *p) {
  const region *g = q->whole;
  for (int c = 0; c < 2; c++) {
    if (g->whole[c]) continue;
    double slack = 0.5 * q->s->radius[i], nx = c == 0, ny = c == 1, at = q->s->at[i][c];
    polygon_cut(p, nx, ny, g->upper[c] - at, slack, BY_REGION);
    polygon_cut(p, -nx, -ny, at - g->lower[c], slack, BY_REGION);
  }
}

/* Returns the largest distance that a corner of a closed cell may have from the centre of its disk
 * i. */
static double bulk_reach(const cutter *q, size_t i) {
  return q->s->radius[i] + CELLS_VOID * q->largest;
}

static bool is_closed(const cutter *q, size_t i, const polygon *p) {
  bool boundless = q->whole->whole[0] && q->whole->whole[1];
  double reach = bulk_reach(q, i);
  for (size_t k = 0; k < p->n; k++) {
    if (p->edge[k] == BY_NOTHING || p->edge[k] == BY_REGION) return false;
    if (!boundless && math_hypot(p->at[k][0], p->at[k][1]) > reach) return false;
  }
  return true;
}

/* Returns true if the edge from a to b crosses the circle of this radius about the origin at a
 * point farther than `reach` from `centre`. */
static bool crosses_far(const double a[2], const double b[2], double radius, const double centre[2],
                        double reach) {
  double dx = b[0] - a[0], dy = b[1] - a[1], dd = dx * dx + dy * dy, ad = a[0] * dx + a[1] * dy;
  double discriminant = ad * ad - dd * (a[0] * a[0] + a[1] * a[1] - radius * radius);
  if (!(discriminant > 0.0) || dd == 0.0) return false;
  for (int sign = -1; sign <= 1; sign += 2) {
    double t = (-ad + sign * sqrt(discriminant)) / dd;
    if (t > 0.0 && t < 1.0 &&
        math_hypot(a[0] + t * dx - centre[0], a[1] + t * dy - centre[1]) > reach)
      return true;
  }
  return false;
}

/* Returns the area of the part of a cell that lies inside the drum. *closed is set to true if the
 * drum's wall does not cut the cell, or if no point of the part inside is farther from the disk
 * than bulk_reach. */
static double round_area(const cutter *q, size_t i, polygon *p, bool *closed) {
  const container_outline *g = &q->whole->outline;
  const double own[2] = {q->s->at[i][0] - g->centre[0], q->s->at[i][1] - g->centre[1]};
  double reach = bulk_reach(q, i);
  bool at_wall = false, near = true;
  for (size_t k = 0; k < p->n; k++) {
    bool inside_far = math_hypot(p->at[k][0], p->at[k][1]) > reach;
    for (int c = 0; c < 2; c++) p->at[k][c] += own[c];
    bool beyond = math_hypot(p->at[k][0], p->at[k][1]) > g->radius;
    at_wall = at_wall || beyond;
    near = near && (beyond || !inside_far);
  }
  for (size_t k = 0; k < p->n; k++)
    near = near && !crosses_far(p->at[k], p->at[k + 1 < p->n ? k + 1 : 0], g->radius, own, reach);
  double area = region_circle_polygon(g->radius, p->n, (const double(*)[2])p->at);
  *closed = !at_wall || (near && area <= M_PI * reach * reach);
  return area;
}

static double cell_area(const cutter *q, size_t i, bool *closed, bool *short_of_images) {
  polygon p;
  const region *g = q->whole;
  const double *length = q->c->length;
  double size = 4.0 * q->s->size, area;
  *closed = false;
  if (!region_holds(g, q->s->at[i][0], q->s->at[i][1])) return NAN;
  polygon_box(&p, length[0] > 0.0 ? length[0] : size, length[1] > 0.0 ? length[1] : size);
  /* no cell: larger disks leave no area to this disk, or the polygon has too many corners */
  if (!cut_neighbours(q->s, i, q->largest, &p) || p.n < 3) return NAN;
  cut_walls(q, i, &p);
  if (region_is_round(g)) {
    area = round_area(q, i, &p, closed);
  } else {
    cut_region(q, i, &p);
    if (!*short_of_images && needs_images(q, i, &p)) *short_of_images = true;
    *closed = is_closed(q, i, &p);
    area = polygon_area(&p);
  }
  if (p.n >= 3 && area > 0.0) return area;
  *closed = false;
  return NAN;
}

typedef struct areas_task {
  const cutter *q;
  cells *t;
  size_t n;
  atomic_bool more; /* true if some cell needs more periodic images */
} areas_task;

static void areas_together(const team *t, void *with) {
  areas_task *f = with;
  size_t begin, end;
  bool more = false;
  team_share(t, f->n, &begin, &end);
  for (size_t i = begin; i < end; i++) f->t->area[i] = cell_area(f->q, i, &f->t->closed[i], &more);
  if (more) f->more = true;
}

/* --- all cells -------------------------------------------------------------------------------- */

static sd_status cut_cells(cells *t, cutter *q, sd_messages *messages) {
  sites s = {0};
  sd_status status = sites_new(&s, q->c, q->whole, q->margin);
  if (status != SD_OK) sd_fail(messages, status, "no memory for the cells of %zu disks", t->n);
  q->s = &s;
  const size_t n = status == SD_OK ? t->n : 0;
  areas_task f = {.q = q, .t = t, .n = n};
  pool_run_once(n, areas_together, &f);
  q->short_of_images = f.more;
  q->s = NULL;
  sites_free(&s);
  return status;
}

/* Computes the statistics of the closed cells of free disks with their centre in `counted`, and the
 * total area of all cells. local: scratch array with one number per disk. */
static void statistics(cells *t, const configuration *c, const region *counted, double *local) {
  const sd_model *m = c->model;
  double disks = 0.0, area = 0.0;
  for (size_t i = 0; i < t->n; i++) {
    const sd_disk *d = &m->disks[i];
    if (isfinite(t->area[i])) t->total += t->area[i];
    if (d->driven || !region_holds(counted, d->position[0], d->position[1]) ||
        !isfinite(t->area[i]))
      continue;
    if (!t->closed[i]) {
      t->n_open++;
      continue;
    }
    local[t->n_closed++] = cells_fraction(t, c, i);
    disks += M_PI * d->radius * d->radius;
    area += t->area[i];
  }
  t->inside = t->mean = t->deviation = t->least = t->most = NAN;
  if (t->n_closed > 0) {
    t->inside = disks / area;
    t->mean = statistics_mean(local, t->n_closed);
    t->deviation = statistics_deviation(local, t->n_closed, t->mean, (double)t->n_closed);
    gsl_stats_minmax(&t->least, &t->most, local, 1, t->n_closed);
  }
}

sd_status cells_new(cells *t, const configuration *c, const region *whole, const region *counted,
                    sd_messages *messages) {
  const sd_model *m = c->model;
  *t = (cells){.n = m->n_disks};
  double *local;
  const memory_column rows[] = {{&t->area, t->n, sizeof *t->area},
                                {&t->closed, t->n, sizeof *t->closed},
                                {&local, t->n, sizeof *local}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows))
    return sd_fail(messages, SD_ERROR_IO, "no memory for the cells");
  cutter q = {.c = c, .whole = whole};
  for (size_t i = 0; i < t->n; i++) q.largest = math_max(q.largest, m->disks[i].radius);
  double spacing = math_max(2.0 * q.largest, sqrt(region_area(whole) / (double)t->n));
  for (int k = 0; k < 2; k++) q.margin[k] = math_min(4.0 * spacing, c->length[k]);
  sd_status status;
  do {
    status = cut_cells(t, &q, messages);
    for (int k = 0; k < 2; k++) q.margin[k] = math_min(4.0 * q.margin[k], c->length[k]);
  } while (status == SD_OK && q.short_of_images);
  if (status == SD_OK) statistics(t, c, counted, local);
  free(local);
  return status;
}

double cells_fraction(const cells *t, const configuration *c, size_t i) {
  double r = c->model->disks[i].radius;
  return t->closed[i] && t->area[i] > 0.0 ? M_PI * r * r / t->area[i] : NAN;
}

void cells_free(cells *t) {
  free(t->area);
  free(t->closed);
  *t = (cells){0};
}
