/* region.c: areas and lengths within a rectangle or a container (see configuration.h). */
#include "measure/configuration.h"

#include <math.h>

#include "base/math.h"

/* --- outlines --------------------------------------------------------------------------------- */

/* Keeps the part of a polygon in which side * (coordinate c - at) <= 0. */
static void cut(container_outline *o, int c, double side, double at) {
  const container_outline whole = *o;
  o->n = 0;
  for (size_t k = 0; k < whole.n; k++) {
    const double *p = whole.corner[k], *q = whole.corner[k + 1 < whole.n ? k + 1 : 0];
    double u = side * (p[c] - at), v = side * (q[c] - at);
    for (int i = 0; u <= 0.0 && i < 2; i++) o->corner[o->n][i] = p[i];
    o->n += u <= 0.0;
    if (!((u < 0.0 && v > 0.0) || (u > 0.0 && v < 0.0))) continue;
    for (int i = 0; i < 2; i++) o->corner[o->n][i] = p[i] + (q[i] - p[i]) * (u / (u - v));
    o->n++;
  }
}

void region_use_outline(region *g, const container_outline *o, bool closed) {
  if (o->n == 0 && o->radius == 0.0) return;
  g->outline = *o;
  if (closed) {
    container_bounds(o, g->lower, g->upper);
    return;
  }
  cut(&g->outline, 1, 1.0, g->upper[1]);
  cut(&g->outline, 1, -1.0, g->lower[1]);
}

static double polygon_area(const container_outline *o) {
  double area = 0.0;
  for (size_t k = 1; k + 1 < o->n; k++) {
    const double *a = o->corner[0], *p = o->corner[k], *q = o->corner[k + 1];
    area += 0.5 * ((p[0] - a[0]) * (q[1] - a[1]) - (p[1] - a[1]) * (q[0] - a[0]));
  }
  return area;
}

/* Returns how far the point lies to the left of edge k of a polygon, times the edge's length. */
static double inside_edge(const container_outline *o, size_t k, double x, double y) {
  const double *p = o->corner[k], *q = o->corner[k + 1 < o->n ? k + 1 : 0];
  return (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
}

static bool outline_holds(const container_outline *o, double x, double y) {
  if (o->n == 0) return math_hypot(x - o->centre[0], y - o->centre[1]) <= o->radius;
  for (size_t k = 0; k < o->n; k++)
    if (inside_edge(o, k, x, y) < 0.0) return false;
  return true;
}

static bool has_outline(const region *g) { return g->outline.n > 0 || region_is_round(g); }

double region_area(const region *g) {
  const container_outline *o = &g->outline;
  if (has_outline(g)) return o->n > 0 ? polygon_area(o) : M_PI * o->radius * o->radius;
  return (g->upper[0] - g->lower[0]) * (g->upper[1] - g->lower[1]);
}

/* Returns the smallest periodic image of the value `at` of coordinate c that is not below the lower
 * edge of the region. */
static double first_image(const region *g, int c, double at) {
  if (g->image[c] == 0.0) return at;
  return at - g->image[c] * floor((at - g->lower[c]) / g->image[c]);
}

bool region_holds(const region *g, double x, double y) {
  if (has_outline(g)) return outline_holds(&g->outline, x, y);
  const double at[2] = {x, y};
  for (int c = 0; c < 2; c++) {
    if (g->whole[c]) continue;
    double p = first_image(g, c, at[c]);
    if (p < g->lower[c] || p > g->upper[c]) return false;
  }
  return true;
}

/* --- areas ------------------------------------------------------------------------------------ */

typedef struct point {
  double x, y;
} point;

static double sector(point p, point q, double radius) {
  return 0.5 * radius * radius * math_atan2(p.x * q.y - p.y * q.x, p.x * q.x + p.y * q.y);
}

static point along(point p, point d, double t) { return (point){p.x + t * d.x, p.y + t * d.y}; }

/* Returns the signed area that the circle about the origin shares with the triangle of the origin,
 * p and q; positive if these are in counter-clockwise order. */
static double edge_area(point p, point q, double radius) {
  point d = {q.x - p.x, q.y - p.y};
  double a = d.x * d.x + d.y * d.y, b = p.x * d.x + p.y * d.y;
  double c = p.x * p.x + p.y * p.y - radius * radius, discriminant = b * b - a * c;
  if (!(discriminant > 0.0) || a == 0.0) return sector(p, q, radius);
  double root = sqrt(discriminant), enters = (-b - root) / a, leaves = (-b + root) / a;
  if (leaves <= 0.0 || enters >= 1.0) return sector(p, q, radius);
  point u = enters > 0.0 ? along(p, d, enters) : p, v = leaves < 1.0 ? along(p, d, leaves) : q;
  double area = 0.5 * (u.x * v.y - u.y * v.x);
  if (enters > 0.0) area += sector(p, u, radius);
  if (leaves < 1.0) area += sector(v, q, radius);
  return area;
}

double region_circle_polygon(double radius, size_t n, const double (*corner)[2]) {
  double area = 0.0;
  for (size_t k = 0; k < n; k++) {
    const double *p = corner[k], *q = corner[k + 1 < n ? k + 1 : 0];
    area += edge_area((point){p[0], p[1]}, (point){q[0], q[1]}, radius);
  }
  return area;
}

/* Returns the area common to two circles of radii r and s whose centres have this distance. */
static double lens(double distance, double r, double s) {
  if (distance >= r + s) return 0.0;
  if (distance <= fabs(r - s)) return M_PI * math_min(r, s) * math_min(r, s);
  double u = (distance * distance + r * r - s * s) / (2.0 * distance), v = distance - u;
  return r * r * math_acos(u / r) - u * sqrt(math_max(r * r - u * u, 0.0)) +
         s * s * math_acos(v / s) - v * sqrt(math_max(s * s - v * v, 0.0));
}

/* Returns the area of the part of a disk that lies inside the rectangle, without periodic
 * images. */
static double rectangle_disk(const region *g, double x, double y, double radius) {
  double low[2], high[2];
  const double at[2] = {x, y};
  bool inside = true;
  for (int c = 0; c < 2; c++) {
    low[c] = g->whole[c] ? -2.0 * radius : g->lower[c] - at[c];
    high[c] = g->whole[c] ? 2.0 * radius : g->upper[c] - at[c];
    if (low[c] >= radius || high[c] <= -radius) return 0.0;
    inside = inside && low[c] <= -radius && high[c] >= radius;
  }
  if (inside) return M_PI * radius * radius;
  const double corner[4][2] = {
      {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}};
  return region_circle_polygon(radius, 4, corner);
}

static double outline_disk(const container_outline *o, double x, double y, double radius) {
  if (o->n == 0) return lens(math_hypot(x - o->centre[0], y - o->centre[1]), radius, o->radius);
  double corner[CONTAINER_CORNERS][2];
  for (size_t k = 0; k < o->n; k++) {
    corner[k][0] = o->corner[k][0] - x;
    corner[k][1] = o->corner[k][1] - y;
  }
  return region_circle_polygon(radius, o->n, (const double(*)[2])corner);
}

double region_disk(const region *g, double x, double y, double radius) {
  if (has_outline(g)) return outline_disk(&g->outline, x, y, radius);
  double px = first_image(g, 0, x), py = first_image(g, 1, y), area = 0.0;
  int nx = g->image[0] > 0.0, ny = g->image[1] > 0.0;
  for (int j = -ny; j <= ny; j++)
    for (int i = -nx; i <= nx; i++)
      area += rectangle_disk(g, px + i * g->image[0], py + j * g->image[1], radius);
  return area;
}

/* --- lines ------------------------------------------------------------------------------------ */

/* Returns the fraction of the line p + t d, 0 <= t <= 1, inside the rectangle (algorithm of Liang
 * and Barsky). */
static double rectangle_line(const region *g, const double p[2], const double d[2]) {
  double first = 0.0, last = 1.0;
  for (int c = 0; c < 2; c++) {
    if (g->whole[c]) continue;
    if (d[c] == 0.0) {
      if (p[c] < g->lower[c] || p[c] > g->upper[c]) return 0.0;
      continue;
    }
    double s = (g->lower[c] - p[c]) / d[c], t = (g->upper[c] - p[c]) / d[c];
    first = math_max(first, math_min(s, t));
    last = math_min(last, math_max(s, t));
  }
  return math_max(last - first, 0.0);
}

static double outline_line(const container_outline *o, double x, double y, double dx, double dy) {
  if (o->n == 0) return outline_holds(o, x + 0.5 * dx, y + 0.5 * dy) ? 1.0 : 0.0;
  double first = 0.0, last = 1.0;
  for (size_t k = 0; k < o->n; k++) {
    double from = inside_edge(o, k, x, y), to = inside_edge(o, k, x + dx, y + dy);
    if (from < 0.0 && to < 0.0) return 0.0;
    if (from < 0.0) first = math_max(first, from / (from - to));
    if (to < 0.0) last = math_min(last, from / (from - to));
  }
  return math_max(last - first, 0.0);
}

double region_line(const region *g, double x, double y, double dx, double dy) {
  if (has_outline(g)) return outline_line(&g->outline, x, y, dx, dy);
  double px = first_image(g, 0, x), py = first_image(g, 1, y), part = 0.0;
  int nx = g->image[0] > 0.0, ny = g->image[1] > 0.0;
  for (int j = -ny; j <= ny; j++)
    for (int i = -nx; i <= nx; i++) {
      const double p[2] = {px + i * g->image[0], py + j * g->image[1]}, d[2] = {dx, dy};
      part += rectangle_line(g, p, d);
    }
  return part;
}
