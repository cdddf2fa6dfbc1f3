/* cells.c: see cells.h. Qhull: Barber, Dobkin, Huhdanpaa, ACM Trans. Math. Software 22 (1996) 469; radical cells
 * through the lower hull: Aurenhammer, SIAM J. Comput. 16 (1987) 78. */
#include "measure/cells.h"

#include <assert.h>
#include <gsl/gsl_statistics_double.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wstrict-prototypes"
#include <libqhull_r/libqhull_r.h>
#pragma GCC diagnostic pop

/* --- sites -------------------------------------------------------------------------------------------- */

/* Disks, then images of disks, then four points far away that make every hull solid. */
typedef struct sites {
  size_t n, n_disks, capacity;
  double (*at)[2];
  double *radius;
  double centre[2], size; /* of what the sites cover */
} sites;

enum { FAR = 4 }; /* points */

static sd_status sites_add(sites *s, double x, double y, double radius) {
  if (s->n == s->capacity) {
    size_t capacity = 2 * s->capacity + 64;
    double(*at)[2] = realloc(s->at, capacity * sizeof *at);
    if (at) s->at = at;
    double *radii = realloc(s->radius, capacity * sizeof *radii);
    if (radii) s->radius = radii;
    if (!at || !radii) return SD_ERROR_IO;
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
  *s = (sites){0};
}

/* Images at most `margin` outside the box. */
static sd_status add_images(sites *s, const configuration *c, const double margin[2]) {
  const sd_model *m = c->model;
  sd_status status = SD_OK;
  for (int j = -1; j <= 1; j++)
    for (int i = -1; i <= 1; i++) {
      double shift[2] = {i * c->length[0], j * c->length[1]};
      if ((i == 0 && j == 0) || (i != 0 && shift[0] == 0.0) || (j != 0 && shift[1] == 0.0)) continue;
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

static sd_status sites_new(sites *s, const configuration *c, const region *g, const double margin[2]) {
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
      lower[k] = fmin(lower[k], s->at[i][k] - s->radius[i]);
      upper[k] = fmax(upper[k], s->at[i][k] + s->radius[i]);
    }
  for (int k = 0; k < 2; k++) s->centre[k] = 0.5 * (lower[k] + upper[k]);
  s->size = fmax(upper[0] - lower[0], upper[1] - lower[1]);
  /* their cells begin beyond all that is measured; not on a circle, and not on lines of a lattice */
  static const double far[FAR][2] = {{4.1, 3.3}, {-3.7, 4.3}, {-4.2, -3.9}, {3.5, -4.4}};
  for (int k = 0; status == SD_OK && k < FAR; k++)
    status = sites_add(s, s->centre[0] + far[k][0] * s->size, s->centre[1] + far[k][1] * s->size, 0.0);
  return status;
}

/* --- neighbours --------------------------------------------------------------------------------------- */

/* Rows of neighbours of the disks (not of images). */
typedef struct edges {
  size_t *start;
  uint32_t *site;
} edges;

static void edges_free(edges *e) {
  free(e->start);
  free(e->site);
  *e = (edges){0};
}

/* Calls for each pair of sites with a common facet of the lower hull, from both sides; each edge is met twice. */
static void visit_edges(qhT *qh, const sites *s, edges *e, bool fill) {
  facetT *facet;
  vertexT *vertex, **vertexp;
  FORALLfacets {
    if (facet->normal[2] >= 0.0) continue; /* of the upper hull */
    int corner[3], n = 0;
    FOREACHvertex_(facet->vertices) {
      if (n < 3) corner[n] = qh_pointid(qh, vertex->point);
      n++;
    }
    for (int k = 0; k < 6 && n == 3; k++) { /* triangles: option Qt */
      size_t a = (size_t)corner[k / 2], b = (size_t)corner[(k / 2 + 1 + k % 2) % 3];
      if (a >= s->n_disks) continue;
      if (fill)
        e->site[e->start[a + 1]++] = (uint32_t)b;
      else
        e->start[a + 2]++;
    }
  }
}

static sd_status collect_edges(qhT *qh, const sites *s, edges *e) {
  e->start = calloc(s->n_disks + 3, sizeof *e->start);
  if (!e->start) return SD_ERROR_IO;
  visit_edges(qh, s, e, false);
  for (size_t i = 0; i < s->n_disks; i++) e->start[i + 2] += e->start[i + 1];
  e->site = calloc(e->start[s->n_disks + 1] + 1, sizeof *e->site);
  if (!e->site) return SD_ERROR_IO;
  visit_edges(qh, s, e, true);
  return SD_OK;
}

/* Coordinates about the middle, in units of the size: Qhull's tolerances are absolute. */
static coordT *lift(const sites *s) {
  coordT *point = calloc(3 * s->n, sizeof *point);
  for (size_t i = 0; point && i < s->n; i++) {
    double x = (s->at[i][0] - s->centre[0]) / s->size, y = (s->at[i][1] - s->centre[1]) / s->size;
    double r = s->radius[i] / s->size;
    point[3 * i] = x;
    point[3 * i + 1] = y;
    point[3 * i + 2] = x * x + y * y - r * r;
  }
  return point;
}

static sd_status triangulate(const sites *s, edges *e, sd_messages *messages) {
  char options[] = "qhull Qt Qbb Q12 Pp", *said = NULL;
  size_t size = 0;
  coordT *points = lift(s);
  FILE *errors = open_memstream(&said, &size); /* the library prints what goes wrong */
  qhT *qh = calloc(1, sizeof *qh);
  if (!points || !errors || !qh || s->n > INT32_MAX) {
    if (errors) fclose(errors);
    free(said);
    free(points);
    free(qh);
    return sd_fail(messages, SD_ERROR_IO, "no memory for the cells of %zu disks", s->n_disks);
  }
  qh_zero(qh, errors);
  int failed = qh_new_qhull(qh, 3, (int)s->n, points, False, options, NULL, errors);
  sd_status status = failed == qh_ERRmem ? SD_ERROR_IO : failed ? SD_ERROR_NUMERIC : collect_edges(qh, s, e);
  qh_freeqhull(qh, !qh_ALL);
  int long_blocks, long_bytes;
  qh_memfreeshort(qh, &long_blocks, &long_bytes);
  fclose(errors);
  if (failed)
    sd_fail(messages, status, "Qhull found no cells: %.*s", said ? (int)strcspn(said, "\n") : 0, said);
  else if (status != SD_OK)
    sd_fail(messages, status, "no memory for the cells of %zu disks", s->n_disks);
  free(said);
  free(points);
  free(qh);
  return status;
}

/* --- one cell ----------------------------------------------------------------------------------------- */

enum { MOST_CORNERS = 2048 };
enum { BY_NEIGHBOUR, BY_WALL, BY_REGION, BY_NOTHING }; /* what made an edge */

/* A convex polygon about the centre of a disk; edge k goes from corner k to the next. */
typedef struct polygon {
  size_t n;
  double at[MOST_CORNERS][2];
  unsigned char edge[MOST_CORNERS];
} polygon;

static void polygon_box(polygon *p, double half_x, double half_y) {
  p->n = 4;
  for (int k = 0; k < 4; k++) {
    p->at[k][0] = k == 1 || k == 2 ? half_x : -half_x;
    p->at[k][1] = k >= 2 ? half_y : -half_y;
    p->edge[k] = BY_NOTHING;
  }
}

/* Keeps the part with n.x <= d, unless what is cut off is no deeper than `slack`. Returns false when the polygon has
 * too many corners. */
static bool polygon_cut(polygon *p, double nx, double ny, double d, double slack, unsigned char by) {
  double deepest = 0.0;
  for (size_t k = 0; k < p->n; k++) deepest = fmax(deepest, nx * p->at[k][0] + ny * p->at[k][1] - d);
  if (!(deepest > slack)) return true;
  if (p->n + 2 > MOST_CORNERS) return false;
  polygon from;
  from.n = p->n;
  memcpy(from.at, p->at, p->n * sizeof *p->at);
  memcpy(from.edge, p->edge, p->n);
  p->n = 0;
  for (size_t k = 0; k < from.n; k++) {
    const double *a = from.at[k], *b = from.at[k + 1 < from.n ? k + 1 : 0];
    double da = nx * a[0] + ny * a[1] - d, db = nx * b[0] + ny * b[1] - d;
    if (da <= 0.0) {
      p->at[p->n][0] = a[0];
      p->at[p->n][1] = a[1];
      p->edge[p->n++] = from.edge[k];
    }
    if ((da <= 0.0) == (db <= 0.0)) continue;
    double t = da / (da - db);
    p->at[p->n][0] = a[0] + t * (b[0] - a[0]);
    p->at[p->n][1] = a[1] + t * (b[1] - a[1]);
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
  const edges *e;
  double margin[2], largest; /* radius */
  bool short_of_images;      /* some cell may have a neighbour that was not there */
} cutter;

static bool cut_neighbours(const cutter *q, size_t i, polygon *p) {
  const double *at = q->s->at[i], r = q->s->radius[i];
  bool fits = true;
  for (size_t k = q->e->start[i]; fits && k < q->e->start[i + 1]; k++) {
    size_t j = q->e->site[k];
    if (j >= q->s->n - FAR) continue;
    double dx = q->s->at[j][0] - at[0], dy = q->s->at[j][1] - at[1], s = q->s->radius[j];
    fits = polygon_cut(p, dx, dy, 0.5 * (dx * dx + dy * dy + (r - s) * (r + s)), 0.0, BY_NEIGHBOUR);
  }
  return fits;
}

/* A site that is not there could come nearer to a corner than this disk only from within a circle about the corner. */
static bool needs_images(const cutter *q, size_t i, const polygon *p) {
  const sd_model *m = q->c->model;
  double r = q->s->radius[i];
  for (size_t k = 0; k < p->n; k++) {
    double x = p->at[k][0], y = p->at[k][1];
    double reach = sqrt(fmax(x * x + y * y - r * r + q->largest * q->largest, 0.0));
    for (int c = 0; c < 2; c++) {
      double length = q->c->length[c], corner = q->s->at[i][c] + p->at[k][c];
      if (length == 0.0 || q->margin[c] >= length) continue;
      if (corner - reach < m->lower[c] - q->margin[c] || corner + reach > m->upper[c] + q->margin[c])
        return true;
    }
  }
  return false;
}

/* Walls stop a cell where the disk stands before them. */
static void cut_walls(const cutter *q, size_t i, polygon *p) {
  const sd_model *m = q->c->model;
  const double *at = q->s->at[i];
  for (size_t k = 0; k < m->n_segments; k++) {
    const sd_segment *g = &m->segments[k];
    const double *pivot = m->walls[g->body - m->n_disks].pivot;
    double rx = pivot[0] + g->start[0] - at[0], ry = pivot[1] + g->start[1] - at[1];
    double u = -(rx * g->tangent[0] + ry * g->tangent[1]);
    if (g->length < HUGE_VAL && (u < 0.0 || u > g->length)) continue;
    double nx = g->tangent[1], ny = -g->tangent[0], d = nx * rx + ny * ry;
    polygon_cut(p, d < 0.0 ? -nx : nx, d < 0.0 ? -ny : ny, fabs(d), 0.0, BY_WALL);
  }
}

/* A wall that has moved a little beyond the region stops a cell, not the region. */
static void cut_region(const cutter *q, size_t i, polygon *p) {
  const region *g = q->whole;
  for (int c = 0; c < 2; c++) {
    if (g->whole[c]) continue;
    double slack = 0.5 * q->s->radius[i], nx = c == 0, ny = c == 1, at = q->s->at[i][c];
    polygon_cut(p, nx, ny, g->upper[c] - at, slack, BY_REGION);
    polygon_cut(p, -nx, -ny, at - g->lower[c], slack, BY_REGION);
  }
}

/* Farther than this from its disk's centre no corner of a cell in the bulk is. */
static double bulk_reach(const cutter *q, size_t i) { return q->s->radius[i] + CELLS_VOID * q->largest; }

static bool is_closed(const cutter *q, size_t i, const polygon *p) {
  bool boundless = q->whole->whole[0] && q->whole->whole[1];
  double reach = bulk_reach(q, i);
  for (size_t k = 0; k < p->n; k++) {
    if (p->edge[k] == BY_NOTHING || p->edge[k] == BY_REGION) return false;
    if (!boundless && hypot(p->at[k][0], p->at[k][1]) > reach) return false;
  }
  return true;
}

/* Does the edge from a to b leave the circle of this radius about the origin at a point that is farther than `reach`
 * from `centre`? */
static bool crosses_far(const double a[2], const double b[2], double radius, const double centre[2],
                        double reach) {
  double dx = b[0] - a[0], dy = b[1] - a[1], dd = dx * dx + dy * dy, ad = a[0] * dx + a[1] * dy;
  double discriminant = ad * ad - dd * (a[0] * a[0] + a[1] * a[1] - radius * radius);
  if (!(discriminant > 0.0) || dd == 0.0) return false;
  for (int sign = -1; sign <= 1; sign += 2) {
    double t = (-ad + sign * sqrt(discriminant)) / dd;
    if (t > 0.0 && t < 1.0 && hypot(a[0] + t * dx - centre[0], a[1] + t * dy - centre[1]) > reach)
      return true;
  }
  return false;
}

/* In a drum a cell ends at the wall, and what is beyond does not count. */
static double round_area(const cutter *q, size_t i, polygon *p, bool *closed) {
  const region *g = q->whole;
  const double own[2] = {q->s->at[i][0] - g->centre[0], q->s->at[i][1] - g->centre[1]};
  double reach = bulk_reach(q, i);
  bool at_wall = false, near = true;
  for (size_t k = 0; k < p->n; k++) {
    bool inside_far = hypot(p->at[k][0], p->at[k][1]) > reach;
    for (int c = 0; c < 2; c++) p->at[k][c] += own[c];
    bool beyond = hypot(p->at[k][0], p->at[k][1]) > g->radius;
    at_wall = at_wall || beyond;
    near = near && (beyond || !inside_far);
  }
  for (size_t k = 0; k < p->n; k++)
    near = near && !crosses_far(p->at[k], p->at[k + 1 < p->n ? k + 1 : 0], g->radius, own, reach);
  double area = region_circle_polygon(g->radius, p->n, (const double(*)[2])p->at);
  *closed = !at_wall || (near && area <= M_PI * reach * reach);
  return area;
}

static double cell_area(cutter *q, size_t i, bool *closed) {
  polygon p;
  const region *g = q->whole;
  const double *length = q->c->length;
  double size = 4.0 * q->s->size, area;
  *closed = false;
  if (!region_holds(g, q->s->at[i][0], q->s->at[i][1])) return NAN;
  polygon_box(&p, length[0] > 0.0 ? length[0] : size, length[1] > 0.0 ? length[1] : size);
  if (q->e->start[i] == q->e->start[i + 1] || !cut_neighbours(q, i, &p))
    return NAN; /* hidden by larger disks */
  cut_walls(q, i, &p);
  if (g->round) {
    area = round_area(q, i, &p, closed);
  } else {
    cut_region(q, i, &p);
    if (!q->short_of_images && needs_images(q, i, &p)) q->short_of_images = true;
    *closed = is_closed(q, i, &p);
    area = polygon_area(&p);
  }
  if (p.n >= 3 && area > 0.0) return area;
  *closed = false;
  return NAN;
}

/* --- all cells ---------------------------------------------------------------------------------------- */

static sd_status cut_cells(cells *t, cutter *q, sd_messages *messages) {
  sites s = {0};
  edges e = {0};
  sd_status status = sites_new(&s, q->c, q->whole, q->margin);
  if (status != SD_OK) sd_fail(messages, status, "no memory for the cells of %zu disks", t->n);
  if (status == SD_OK) status = triangulate(&s, &e, messages);
  if (status == SD_OK) assert(e.start && e.site);
  q->s = &s;
  q->e = &e;
  q->short_of_images = false;
  for (size_t i = 0; status == SD_OK && i < t->n; i++) t->area[i] = cell_area(q, i, &t->closed[i]);
  q->s = NULL;
  q->e = NULL;
  sites_free(&s);
  edges_free(&e);
  return status;
}

static sd_status statistics(cells *t, const configuration *c, const region *counted) {
  const sd_model *m = c->model;
  double *local = calloc(t->n + 1, sizeof *local), disks = 0.0, area = 0.0;
  if (!local) return SD_ERROR_IO;
  for (size_t i = 0; i < t->n; i++) {
    const sd_disk *d = &m->disks[i];
    if (isfinite(t->area[i])) t->total += t->area[i];
    if (d->driven || !region_holds(counted, d->position[0], d->position[1]) || !isfinite(t->area[i]))
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
    t->mean = gsl_stats_mean(local, 1, t->n_closed);
    t->deviation = gsl_stats_sd_with_fixed_mean(local, 1, t->n_closed, t->mean);
    gsl_stats_minmax(&t->least, &t->most, local, 1, t->n_closed);
  }
  free(local);
  return SD_OK;
}

sd_status cells_new(cells *t, const configuration *c, const region *whole, const region *counted,
                    sd_messages *messages) {
  const sd_model *m = c->model;
  *t = (cells){.n = m->n_disks};
  t->area = calloc(t->n + 1, sizeof *t->area);
  t->closed = calloc(t->n + 1, sizeof *t->closed);
  if (!t->area || !t->closed) return sd_fail(messages, SD_ERROR_IO, "no memory for the cells");
  cutter q = {.c = c, .whole = whole};
  for (size_t i = 0; i < t->n; i++) q.largest = fmax(q.largest, m->disks[i].radius);
  double spacing = fmax(2.0 * q.largest, sqrt(region_area(whole) / (double)t->n));
  for (int k = 0; k < 2; k++) q.margin[k] = fmin(4.0 * spacing, c->length[k]);
  sd_status status;
  do {
    status = cut_cells(t, &q, messages);
    for (int k = 0; k < 2; k++) q.margin[k] = fmin(4.0 * q.margin[k], c->length[k]);
  } while (status == SD_OK && q.short_of_images);
  if (status == SD_OK && statistics(t, c, counted) != SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "no memory for the cells");
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
