/* front.c: advancing-front packing (see place.h).
 *
 * A disk of radius r touches a round body of radius R if its centre lies on the circle of radius R
 * + r about the body's centre (drum: negative R; corner: R = 0), and a straight wall if its centre
 * lies on a parallel line at the distance r. A pocket (a position at which a new disk touches two
 * bodies) is thus an intersection of two such curves; its `variant` selects which one. */
#include "pack/place.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"

/* WINDOW: number of disks, next in the order of placing, that are tried in a pocket. VARIANTS:
 * number of positions that are tried for each pair of bodies. */
enum { WINDOW = 16, VARIANTS = 8 };

/* Body that a new disk can touch. A number below s->n stands for a disk of the place_space, FIXED |
 * k for the fixed body k (edge, wall or corner). */
typedef struct body {
  double x, y;   /* centre of a round body, start point of a straight one */
  double radius; /* radius of a round body, negative for a drum */
  double tx, ty; /* unit tangent of a straight body */
  /* length of a straight body from (x, y) along t; infinite: the line extends both ways */
  double length;
  bool straight;
  double lower[2], upper[2]; /* bounding box, for fixed bodies only */
} body;

typedef struct pocket {
  /* position of a disk in the pocket; pockets are ordered by it: lowest first, then leftmost, then
   * oldest (`made`) */
  double y, x;
  uint64_t made;
  uint32_t a, b;
  int variant;
} pocket;

typedef struct front {
  place_space *s;
  double smallest, middle, largest;
  /* number of fixed bodies (edges, wall segments, corners, round walls); allocated rows */
  size_t n_fixed, fixed_capacity;
  body *fixed;
  pocket *heap;
  size_t n, capacity;
  uint64_t made;
} front;

#define FIXED 0x80000000u

/* --- heap of pockets -------------------------------------------------------------------------- */

static bool before(const pocket *a, const pocket *b) {
  if (a->y != b->y) return a->y < b->y;
  if (a->x != b->x) return a->x < b->x;
  return a->made < b->made;
}

static sd_status push(front *f, pocket p) {
  if (f->n == f->capacity) {
    const size_t capacity = 2 * f->n + 256;
    if (!memory_resize_row(&f->heap, capacity, sizeof *f->heap)) return SD_ERROR_IO;
    f->capacity = capacity;
  }
  pocket *heap = f->heap;
  size_t k = f->n++;
  for (; k > 0 && before(&p, &heap[(k - 1) / 2]); k = (k - 1) / 2) heap[k] = heap[(k - 1) / 2];
  heap[k] = p;
  return SD_OK;
}

static pocket pop(front *f) {
  pocket *heap = f->heap, lowest = heap[0], last = heap[--f->n];
  size_t k = 0;
  for (size_t child; (child = 2 * k + 1) < f->n; k = child) {
    if (child + 1 < f->n && before(&heap[child + 1], &heap[child])) child++;
    if (!before(&heap[child], &last)) break;
    heap[k] = heap[child];
  }
  heap[k] = last;
  return lowest;
}

/* --- intersections: a disk that touches two bodies -------------------------------------------- */

static body body_of(const front *f, uint32_t number) {
  if (number & FIXED) return f->fixed[number & ~FIXED];
  const double *disk = f->s->disk[number];
  return (body){.x = disk[0], .y = disk[1], .radius = disk[2]};
}

/* Returns the square root of `square`; 0 if it is negative by rounding (the curves touch), NAN if
 * it is more negative. scale: magnitude of the terms of which `square` is the difference. */
static double root(double square, double scale) {
  return square >= 0 ? sqrt(square) : square > -1e-9 * scale ? 0 : NAN;
}

static void two_circles(const place_space *s, const body *a, const body *b, double r, int variant,
                        double p[2]) {
  double dx = periodic_difference(s, b->x, a->x, 0), dy = periodic_difference(s, b->y, a->y, 1);
  double from_a = a->radius + r, from_b = b->radius + r, square = dx * dx + dy * dy;
  double along = (square + (from_a - from_b) * (from_a + from_b)) / (2 * square);
  double across = root(from_a * from_a / square - along * along, from_a * from_a / square);
  if (variant & 1) across = -across;
  p[0] = variant < 2 ? a->x + along * dx - across * dy : NAN;
  p[1] = a->y + along * dy + across * dx;
}

/* Computes the centre p of a disk of radius r that touches circle a and line b. Bit 0 of variant
 * selects one of two intersections, bit 1 the side of the line. */
static void circle_line(const body *a, const body *b, double r, int variant, double p[2]) {
  double side = variant & 2 ? -r : r, from = a->radius + r;
  double x = b->x - side * b->ty, y = b->y + side * b->tx;
  double along = (a->x - x) * b->tx + (a->y - y) * b->ty,
         off = (a->x - x) * -b->ty + (a->y - y) * b->tx;
  double half = root(from * from - off * off, from * from);
  along += variant & 1 ? -half : half;
  p[0] = variant < 4 ? x + along * b->tx : NAN;
  p[1] = y + along * b->ty;
}

static void two_lines(const body *a, const body *b, double r, int variant, double p[2]) {
  double side = variant & 1 ? -r : r, other = variant & 2 ? -r : r;
  double ax = a->x - side * a->ty, ay = a->y + side * a->tx, bx = b->x - other * b->ty,
         by = b->y + other * b->tx;
  double cross = a->tx * b->ty - a->ty * b->tx;
  double along = ((bx - ax) * b->ty - (by - ay) * b->tx) / cross;
  bool parallel = fabs(cross) < 1e-9;
  p[0] = variant < 4 && !parallel ? ax + along * a->tx : NAN;
  p[1] = ay + along * a->ty;
}

/* Returns true if the foot of the perpendicular from p lies on the segment; always true for round
 * bodies and infinite lines. The ends of a segment are bodies of their own. */
static bool beside(const body *line, const double p[2]) {
  if (!line->straight || isinf(line->length)) return true;
  double along = (p[0] - line->x) * line->tx + (p[1] - line->y) * line->ty;
  return along >= 0 && along <= line->length;
}

/* Computes the centre p of a disk of radius r in the pocket q. Returns false if the intersection
 * does not exist, or if the disk would overlap something there or leave the region. */
static bool place_in(const front *f, const pocket *q, double r, double p[2]) {
  const place_space *s = f->s;
  body a = body_of(f, q->a), b = body_of(f, q->b);
  if (a.straight && !b.straight) {
    body c = a;
    a = b;
    b = c;
  }
  if (a.straight)
    two_lines(&a, &b, r, q->variant, p);
  else if (b.straight)
    circle_line(&a, &b, r, q->variant, p);
  else
    two_circles(s, &a, &b, r, q->variant, p);
  if (!isfinite(p[0]) || !isfinite(p[1]) || !beside(&a, p) || !beside(&b, p)) return false;
  if (!s->edge[1] && (p[1] < s->lower[1] || p[1] >= s->upper[1])) return false;
  for (int c = 0; c < 2; c++) p[c] = periodic_wrap(s, p[c], c);
  return place_fits(s, p[0], p[1], r);
}

/* Pushes each pocket of bodies a and b onto the heap if a disk of the smallest, mean or largest
 * radius fits into it now. The pocket is ordered by the lowest position of these three disks. */
static sd_status add_pockets(front *f, uint32_t a, uint32_t b) {
  double radii[3] = {f->smallest, f->middle, f->largest};
  sd_status status = SD_OK;
  for (int variant = 0; variant < VARIANTS && status == SD_OK; variant++) {
    pocket q = {.y = HUGE_VAL, .a = a, .b = b, .variant = variant};
    for (int k = 0; k < (f->smallest < f->largest ? 3 : 1); k++) {
      double p[2];
      if (!place_in(f, &q, radii[k], p) || p[1] >= q.y) continue;
      q.x = p[0];
      q.y = p[1];
    }
    q.made = f->made;
    if (q.y < HUGE_VAL) {
      f->made++;
      status = push(f, q);
    }
  }
  return status;
}

/* --- bodies ----------------------------------------------------------------------------------- */

/* Returns true if the bounding box of fixed body b and the box lower ... upper are so far apart
 * that no new disk can touch what is in both. Periodic directions, in which the space has no edges,
 * are not tested, as periodic images are not considered. */
static bool boxes_apart(const front *f, const body *b, const double lower[2],
                        const double upper[2]) {
  for (int c = 0; c < 2; c++) {
    const double gap = math_max(b->lower[c] - upper[c], lower[c] - b->upper[c]);
    if (f->s->edge[c] && gap > 2.0 * (1.0 + 1e-9) * f->largest) return true;
  }
  return false;
}

/* Returns true if a new disk could touch both this disk (x, y, radius) and the edge or wall b. */
static bool near_fixed(const front *f, const body *b, const double *disk) {
  const double lower[2] = {disk[0] - disk[2], disk[1] - disk[2]},
               upper[2] = {disk[0] + disk[2], disk[1] + disk[2]};
  double gap;
  if (boxes_apart(f, b, lower, upper)) return false;
  if (b->straight) {
    gap = fabs((disk[0] - b->x) * -b->ty + (disk[1] - b->y) * b->tx) - disk[2];
  } else {
    gap = math_hypot(periodic_difference(f->s, disk[0], b->x, 0),
                     periodic_difference(f->s, disk[1], b->y, 1));
    gap = b->radius < 0 ? -b->radius - gap - disk[2] : gap - b->radius - disk[2];
  }
  return gap <= 2 * f->largest;
}

/* Pushes onto the heap the pockets between a disk and the disks of smaller number near it, and
 * those between the disk and the edges and walls near it. */
static sd_status add_disk(front *f, uint32_t number) {
  place_space *s = f->s;
  const double disk[3] = {s->disk[number][0], s->disk[number][1], s->disk[number][2]};
  size_t n = place_near(s, disk[0], disk[1], disk[2] + 2 * f->largest);
  sd_status status = SD_OK;
  for (size_t k = 0; k < n && status == SD_OK; k++)
    if (s->near[k] < number) status = add_pockets(f, number, s->near[k]);
  for (uint32_t k = 0; k < f->n_fixed && status == SD_OK; k++)
    if (near_fixed(f, &f->fixed[k], disk)) status = add_pockets(f, number, FIXED | k);
  return status;
}

static void add_fixed(front *f, body b) {
  if (f->n_fixed == f->fixed_capacity) {
    f->fixed_capacity = 2 * f->n_fixed + 256;
    f->fixed = memory_grow(f->fixed, f->fixed_capacity, sizeof *f->fixed);
  }
  const double at[2] = {b.x, b.y}, along[2] = {b.tx, b.ty};
  for (int c = 0; c < 2; c++) {
    const double other = at[c] + (isinf(b.length) ? 0.0 : b.length * along[c]),
                 wide = fabs(b.radius);
    b.lower[c] = isinf(b.length) ? -HUGE_VAL : math_min(at[c], other) - wide;
    b.upper[c] = isinf(b.length) ? HUGE_VAL : math_max(at[c], other) + wide;
  }
  f->fixed[f->n_fixed++] = b;
}

static body straight(const double a[2], const double b[2], bool endless) {
  double length = math_hypot(b[0] - a[0], b[1] - a[1]);
  return (body){.x = a[0],
                .y = a[1],
                .straight = true,
                .tx = (b[0] - a[0]) / length,
                .ty = (b[1] - a[1]) / length,
                .length = endless ? HUGE_VAL : length};
}

static void add_wall(front *f, const sd_wall *wall) {
  if (wall->kind == SD_WALL_CIRCLE) {
    const double radius = wall->inside ? -wall->radius : wall->radius;
    add_fixed(f, (body){.x = wall->pivot[0], .y = wall->pivot[1], .radius = radius});
    return;
  }
  bool endless = wall->kind == SD_WALL_LINE;
  for (size_t k = 0; k < wall->n_points; k++) {
    const double *here = wall->points[k], *there = wall->points[(k + 1) % wall->n_points];
    if (!endless) add_fixed(f, (body){.x = here[0], .y = here[1]});
    if (k + 1 < wall->n_points || wall->closed) add_fixed(f, straight(here, there, endless));
  }
}

/* Adds the edges and walls as fixed bodies and pushes the pockets between them onto the heap. The
 * lower edge always supports disks, even in a box periodic in y; the left and right edges do so
 * only if the space has edges in x. */
static sd_status add_edges_and_walls(front *f) {
  const place_space *s = f->s;
  const double *low = s->lower, *high = s->upper, left[2] = {low[0], high[1]},
               right[2] = {high[0], low[1]};
  sd_status status = SD_OK;
  add_fixed(f, straight(low, right, true));
  if (s->edge[0]) add_fixed(f, straight(low, left, true));
  if (s->edge[0]) add_fixed(f, straight(right, high, true));
  for (size_t w = 0; w < s->model->n_walls; w++) add_wall(f, &s->model->walls[w]);
  for (uint32_t a = 0; a < f->n_fixed && status == SD_OK; a++)
    for (uint32_t b = 0; b < a && status == SD_OK; b++)
      if (!boxes_apart(f, &f->fixed[b], f->fixed[a].lower, f->fixed[a].upper))
        status = add_pockets(f, FIXED | a, FIXED | b);
  return status;
}

/* --- filling the region ----------------------------------------------------------------------- */

/* Finds a position p for the first disk on the lower edge: the leftmost free one of equally spaced
 * positions. It is needed in a space without corners, which may have no pocket to begin with.
 * Returns false if no position is free. */
static bool first_place(const front *f, double radius, double p[2]) {
  const place_space *s = f->s;
  double y = s->lower[1] + radius, left = s->lower[0] + (s->edge[0] ? radius : 0);
  size_t steps = (size_t)math_max(0, (s->upper[0] - left) / radius);
  for (size_t k = 0; k <= steps; k++) {
    double x = left + (double)k * radius;
    if (x >= s->upper[0] || !place_fits(s, x, y, radius)) continue;
    p[0] = x;
    p[1] = y;
    return true;
  }
  return false;
}

/* Finds the first of the next WINDOW disks that fits into the pocket, and moves its radius to
 * radius[0]. After a disk that does not fit, only smaller ones are tried. */
static bool choose(const front *f, const pocket *q, size_t n, double *radius, double p[2]) {
  double too_large = HUGE_VAL;
  for (size_t k = 0; k < n && k < WINDOW; k++) {
    double r = radius[k];
    if (r >= too_large) continue;
    too_large = r;
    if (!place_in(f, q, r, p)) continue;
    for (size_t j = k; j > 0; j--) radius[j] = radius[j - 1];
    radius[0] = r;
    return true;
  }
  return false;
}

static sd_status fill(front *f, size_t n, double *radius, double (*position)[2], size_t *placed) {
  place_space *s = f->s;
  sd_status status = add_edges_and_walls(f);
  for (uint32_t k = 0; k < s->n && status == SD_OK; k++) status = add_disk(f, k);
  bool begun = false;
  while (status == SD_OK && *placed < n) {
    double *next = radius + *placed, *p = position[*placed];
    bool found = !begun && (f->n == 0 || !s->edge[0]) && first_place(f, *next, p);
    begun = true;
    while (!found && f->n > 0) {
      pocket q = pop(f);
      found = choose(f, &q, n - *placed, next, p);
    }
    if (!found) break;
    ++*placed;
    status = place_add(s, p[0], p[1], *next);
    if (status == SD_OK) status = add_disk(f, (uint32_t)s->n - 1);
  }
  return status;
}

sd_status front_fill(place_space *s, size_t n, double *radius, double (*position)[2],
                     size_t *placed) {
  front f = {.s = s, .smallest = HUGE_VAL};
  *placed = 0;
  for (size_t k = 0; k < n; k++) {
    f.smallest = math_min(f.smallest, radius[k]);
    f.largest = math_max(f.largest, radius[k]);
    f.middle += radius[k] / (double)n;
  }
  sd_status status = fill(&f, n, radius, position, placed);
  free(f.fixed);
  free(f.heap);
  return status;
}
