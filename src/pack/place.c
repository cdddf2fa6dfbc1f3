/* place.c: finds free positions for disks: grid of cells, overlap tests, random placement, lattices
 * (see place.h). */
#include "base/gsl.h"
#include "pack/place.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/walls.h"

/* --- cell grid -------------------------------------------------------------------------------- */

/* Divides the space into square cells, about two for each expected disk, at least 16 and at most
 * 5e7 in all. */
static void choose_cells(place_space *s, size_t expected) {
  double extent[2], area = 1;
  for (int c = 0; c < 2; c++) {
    s->corner[c] = s->edge[c] ? s->lower[c] : s->model->lower[c];
    extent[c] = s->edge[c] ? s->upper[c] - s->lower[c] : s->period[c];
    area *= extent[c];
  }
  double wanted = math_min(2.0 * (double)expected + 16, 5e7), size = sqrt(area / wanted);
  for (int c = 0; c < 2; c++) {
    s->cells[c] = (int64_t)math_max(1, math_min(floor(extent[c] / size), wanted));
    s->cell[c] = extent[c] / (double)s->cells[c];
    assert(s->cells[c] >= 1);
  }
}

/* Stores in range[] the first and the last index, along coordinate c, of the cells that overlap [x
 * - reach, x + reach]; returns false if there are none. Along a periodic direction without edges
 * the indices may lie outside the grid: the caller wraps them with modulo(). */
static bool cell_range(const place_space *s, double x, double reach, int c, int64_t range[2]) {
  double low = floor((x - reach - s->corner[c]) / s->cell[c]), n = (double)s->cells[c],
         high = floor((x + reach - s->corner[c]) / s->cell[c]);
  if (!s->edge[c]) {
    if (high - low >= n) {
      low = 0;
      high = n - 1;
    }
  } else {
    if (high < 0 || low > n - 1) return false;
    low = math_max(low, 0);
    high = math_min(high, n - 1);
  }
  range[0] = (int64_t)low;
  range[1] = (int64_t)high;
  return true;
}

static int64_t modulo(int64_t k, int64_t n) {
  int64_t rest = k % n;
  return rest < 0 ? rest + n : rest;
}

static int64_t cell_number(const place_space *s, int64_t i, int64_t j) {
  return modulo(j, s->cells[1]) * s->cells[0] + modulo(i, s->cells[0]);
}

/* Allocates the cells, and rows for these numbers of disks and list nodes; existing rows are
 * kept. */
static sd_status make_room(place_space *s, size_t disks, size_t nodes) {
  const size_t n_cells = (size_t)(s->cells[0] * s->cells[1]);
  if (!memory_resize(6, (memory_column[]){{&s->head, n_cells, sizeof *s->head},
                                          {&s->disk, disks, sizeof *s->disk},
                                          {&s->stamp, disks, sizeof *s->stamp},
                                          {&s->near, disks, sizeof *s->near},
                                          {&s->next, nodes, sizeof *s->next},
                                          {&s->holder, nodes, sizeof *s->holder}}))
    return SD_ERROR_IO;
  s->capacity = disks;
  s->node_capacity = nodes;
  return SD_OK;
}

static sd_status add_node(place_space *s, int64_t cell, uint32_t disk) {
  if (s->n_nodes == s->node_capacity &&
      make_room(s, s->capacity, 2 * s->node_capacity + 1024) != SD_OK)
    return SD_ERROR_IO;
  assert(cell >= 0 && cell < s->cells[0] * s->cells[1] && disk < s->n);
  s->next[s->n_nodes] = s->head[cell];
  s->holder[s->n_nodes] = disk;
  s->head[cell] = (int64_t)s->n_nodes++;
  return SD_OK;
}

static sd_status add_nodes(place_space *s, double x, double y, double radius, uint32_t disk) {
  int64_t along[2], up[2];
  sd_status status = SD_OK;
  if (!cell_range(s, x, radius, 0, along) || !cell_range(s, y, radius, 1, up)) return SD_OK;
  for (int64_t j = up[0]; j <= up[1] && status == SD_OK; j++)
    for (int64_t i = along[0]; i <= along[1] && status == SD_OK; i++)
      status = add_node(s, cell_number(s, i, j), disk);
  return status;
}

sd_status place_add(place_space *s, double x, double y, double radius) {
  if (s->n == s->capacity && make_room(s, 2 * s->capacity + 256, s->node_capacity) != SD_OK)
    return SD_ERROR_IO;
  uint32_t number = (uint32_t)s->n;
  s->stamp[number] = 0;
  double *disk = s->disk[s->n++];
  disk[0] = x;
  disk[1] = y;
  disk[2] = radius;
  const int p_most = s->edge[0] && s->period[0] > 0, q_most = s->edge[1] && s->period[1] > 0;
  sd_status status = SD_OK;
  for (int p = -p_most; p <= p_most && status == SD_OK; p++)
    for (int q = -q_most; q <= q_most && status == SD_OK; q++)
      status = add_nodes(s, x + p * s->period[0], y + q * s->period[1], radius, number);
  return status;
}

sd_status place_begin(place_space *s, const sd_model *m, size_t n_there, const container *inside,
                      const double lower[2], const double upper[2], size_t expected) {
  *s = (place_space){.model = m, .inside = inside};
  for (int c = 0; c < 2; c++) {
    s->lower[c] = lower[c];
    s->upper[c] = upper[c];
    s->period[c] = m->periodic[c] ? math_max(0, m->upper[c] - m->lower[c]) : 0;
    s->edge[c] = !(s->period[c] > 0 && upper[c] - lower[c] >= s->period[c]);
  }
  choose_cells(s, n_there + expected);
  sd_status status = make_room(s, 256, 1024);
  if (status != SD_OK) return status;
  for (int64_t k = 0; k < s->cells[0] * s->cells[1]; k++) s->head[k] = -1;
  for (size_t i = 0; i < n_there && status == SD_OK; i++) {
    const sd_disk *disk = &m->disks[i];
    bool sound = isfinite(disk->position[0]) && isfinite(disk->position[1]) && disk->radius > 0 &&
                 isfinite(disk->radius);
    if (sound && !disk->waiting)
      status = place_add(s, disk->position[0], disk->position[1], disk->radius);
  }
  return status;
}

void place_end(place_space *s) {
  free(s->disk);
  free(s->head);
  free(s->next);
  free(s->holder);
  free(s->stamp);
  free(s->near);
  *s = (place_space){0};
}

/* --- overlap tests ---------------------------------------------------------------------------- */

double periodic_wrap(const place_space *s, double x, int c) {
  if (!(s->period[c] > 0)) return x;
  double low = s->model->lower[c], in = x - floor((x - low) / s->period[c]) * s->period[c];
  return in >= s->model->upper[c] || in < low ? low : in;
}

double periodic_difference(const place_space *s, double a, double b, int c) {
  double d = a - b;
  return s->period[c] > 0 ? d - s->period[c] * rint(d / s->period[c]) : d;
}

static double from_piece(double x, double y, const double *a, const double *b, bool endless) {
  double tx = b[0] - a[0], ty = b[1] - a[1];
  double along = ((x - a[0]) * tx + (y - a[1]) * ty) / (tx * tx + ty * ty);
  if (!endless) along = math_max(0, math_min(1, along));
  return math_hypot(x - a[0] - along * tx, y - a[1] - along * ty);
}

/* Returns true if x lies outside the interval between a and b by at least `within`. */
static bool beyond(double x, double a, double b, double within) {
  return (a - x >= within && b - x >= within) || (x - a >= within && x - b >= within);
}

/* Returns the distance of (x, y) from the wall's surface, without periodic images; negative inside
 * a solid circle or outside a drum. Straight segments farther away than `within` may be skipped, so
 * larger distances can come out infinite. */
static double from_wall(const sd_wall *wall, double x, double y, double within) {
  if (wall->kind == SD_WALL_CIRCLE) {
    double r = math_hypot(x - wall->pivot[0], y - wall->pivot[1]);
    return wall->inside ? wall->radius - r : r - wall->radius;
  }
  double nearest = HUGE_VAL;
  if (wall->kind == SD_WALL_ARC) return arc_distance(wall, (const double[2]){x, y});
  for (size_t k = 0; k + 1 < wall->n_points + (wall->closed ? 1 : 0); k++) {
    const double *a = wall->points[k], *b = wall->points[(k + 1) % wall->n_points];
    if (wall->kind != SD_WALL_LINE &&
        (beyond(x, a[0], b[0], within) || beyond(y, a[1], b[1], within)))
      continue;
    nearest = math_min(nearest, from_piece(x, y, a, b, wall->kind == SD_WALL_LINE));
  }
  return nearest;
}

/* Returns true if a disk at (x, y) overlaps no wall and no periodic image of a wall. */
static bool clear_of_walls(const place_space *s, double x, double y, double radius) {
  for (size_t w = 0; w < s->model->n_walls; w++) {
    const sd_wall *wall = &s->model->walls[w];
    const wall_bounds around = wall_bounds_of(wall);
    const wall_range r = wall_range_of(s->model, wall, &around, (const double[2]){x, y}, radius);
    for (int64_t p = (int64_t)r.first[0]; p <= (int64_t)r.last[0]; p++)
      for (int64_t q = (int64_t)r.first[1]; q <= (int64_t)r.last[1]; q++)
        if (from_wall(wall, x + (double)p * r.length[0], y + (double)q * r.length[1], radius) <
            radius * (1 - PLACE_SLACK))
          return false;
  }
  return true;
}

static bool clear_of_disks(const place_space *s, double x, double y, double radius) {
  int64_t along[2], up[2];
  if (!cell_range(s, x, radius, 0, along) || !cell_range(s, y, radius, 1, up)) return true;
  for (int64_t j = up[0]; j <= up[1]; j++)
    for (int64_t i = along[0]; i <= along[1]; i++)
      for (int64_t k = s->head[cell_number(s, i, j)]; k >= 0; k = s->next[k]) {
        const double *other = s->disk[s->holder[k]];
        double dx = periodic_difference(s, x, other[0], 0),
               dy = periodic_difference(s, y, other[1], 1);
        double touch = (radius + other[2]) * (1 - PLACE_SLACK);
        if (dx * dx + dy * dy < touch * touch) return false;
      }
  return true;
}

bool place_fits(const place_space *s, double x, double y, double radius) {
  const double centre[2] = {x, y};
  double least = radius * (1 - PLACE_SLACK);
  for (int c = 0; c < 2; c++)
    if (s->edge[c] && (centre[c] - s->lower[c] < least || s->upper[c] - centre[c] < least))
      return false;
  double span[2], along = x - s->inside->origin[0];
  if (!container_span(s->inside, y, span) || along < span[0] || along > span[1]) return false;
  return clear_of_disks(s, x, y, radius) && clear_of_walls(s, x, y, radius);
}

size_t place_near(place_space *s, double x, double y, double reach) {
  int64_t along[2], up[2];
  size_t n = 0;
  if (!cell_range(s, x, reach, 0, along) || !cell_range(s, y, reach, 1, up)) return 0;
  s->stamps++;
  for (int64_t j = up[0]; j <= up[1]; j++)
    for (int64_t i = along[0]; i <= along[1]; i++)
      for (int64_t k = s->head[cell_number(s, i, j)]; k >= 0; k = s->next[k]) {
        uint32_t number = s->holder[k];
        const double *disk = s->disk[number];
        if (s->stamp[number] == s->stamps) continue;
        s->stamp[number] = s->stamps;
        if (math_hypot(periodic_difference(s, x, disk[0], 0),
                       periodic_difference(s, y, disk[1], 1)) < reach + disk[2])
          s->near[n++] = number;
      }
  return n;
}

/* --- random placement ------------------------------------------------------------------------- */

sd_status place_random(place_space *s, gsl_rng *rng, size_t n, const double *radius,
                       double (*position)[2], size_t *placed) {
  size_t *order = NULL;
  sd_status status = SD_OK;
  /* number of tries left for all disks; with it, equal disks reach a packing fraction of 0.53, and
   * 0.54 with ten times as many tries */
  int64_t left = 1000000 + 300 * (int64_t)n;
  *placed = 0;
  if (!memory_resize_row(&order, n, sizeof *order)) return SD_ERROR_IO;
  gsl_sort_index(order, radius, 1, n);
  for (size_t k = 0; k < n; k++) position[k][0] = position[k][1] = NAN;
  for (size_t k = n; k-- > 0 && status == SD_OK;) {
    double r = radius[order[k]], point[2] = {0, 0};
    bool found = false;
    while (!found && left-- > 0) {
      for (int c = 0; c < 2; c++) {
        double margin = s->edge[c] ? r : 0, low = s->lower[c] + margin, high = s->upper[c] - margin;
        point[c] = periodic_wrap(s, low + gsl_rng_uniform(rng) * (high - low), c);
      }
      found = place_fits(s, point[0], point[1], r);
    }
    if (!found) break;
    for (int c = 0; c < 2; c++) position[order[k]][c] = point[c];
    status = place_add(s, point[0], point[1], r);
    ++*placed;
  }
  free(order);
  return status;
}

/* --- positions of waiting disks, lattices ----------------------------------------------------- */

void place_waiting(double lower, double upper, double y, double spacing, size_t first, size_t n,
                   double (*position)[2]) {
  double columns = math_max(1, floor((upper - lower) / spacing)), wide = (upper - lower) / columns;
  for (size_t k = 0; k < n; k++) {
    const double number = (double)(first + k), row = floor(number / columns);
    position[k][0] = lower + (number - row * columns + 0.5) * wide;
    position[k][1] = y + row * spacing;
  }
}

/* Tolerance, in units of the spacing: if a length is a multiple of the spacing up to rounding, that
 * many sites still fit into it. */
#define ROUNDING 1e-9

/* Layout of the sites of a lattice. */
typedef struct rows {
  /* rows: number of rows; first: y of the lowest row; high: distance between rows */
  double rows, first, high;
  /* columns: number of sites in even and in odd rows; left: x of the first site in such rows */
  double columns[2], left[2];
  double wide;
} rows;

static double whole(double x) { return math_max(0, floor(x + ROUNDING)); }

static rows plan(const place_space *s, sd_packing_kind kind, double spacing) {
  bool triangular = kind == SD_PACKING_TRIANGULAR;
  double width = s->upper[0] - s->lower[0], height = s->upper[1] - s->lower[1];
  double least = triangular ? spacing * sqrt(0.75) : spacing;
  rows r = {.wide = spacing, .high = least};
  if (s->edge[0]) {
    double shift = triangular ? spacing / 2 : 0, room = (width - spacing) / spacing;
    r.columns[0] = room > -ROUNDING ? whole(room) + 1 : 0;
    r.columns[1] = room - shift / spacing > -ROUNDING ? whole(room - shift / spacing) + 1 : 0;
    /* Distance from the leftmost to the rightmost site of all rows. */
    double extent = math_max((r.columns[0] - 1) * spacing, (r.columns[1] - 1) * spacing + shift);
    r.left[0] = s->lower[0] + (width - extent) / 2;
    r.left[1] = r.left[0] + shift;
  } else {
    r.columns[0] = r.columns[1] = whole(width / spacing);
    r.wide = width / math_max(1, r.columns[0]);
    r.left[0] = s->lower[0] + (triangular ? r.wide / 4 : r.wide / 2);
    r.left[1] = r.left[0] + (triangular ? r.wide / 2 : 0);
  }
  if (s->edge[1]) {
    double room = (height - spacing) / least;
    r.rows = room > -ROUNDING ? whole(room) + 1 : 0;
    r.first = s->lower[1] + spacing / 2;
  } else {
    r.rows = triangular ? 2 * whole(height / least / 2) : whole(height / least);
    r.high = height / math_max(1, r.rows);
    r.first = s->lower[1] + r.high / 2;
  }
  return r;
}

size_t lattice_sites(const place_space *s, sd_packing_kind kind, double spacing, size_t most,
                     double (*site)[2]) {
  rows r = plan(s, kind, spacing);
  size_t n = 0;
  for (double j = 0; j < r.rows && n < most; j++) {
    int odd = fmod(j, 2) > 0;
    for (double i = 0; i < r.columns[odd] && n < most; i++) {
      double x = r.left[odd] + i * r.wide, y = r.first + j * r.high;
      /* Test a slightly smaller circle: whole() may have rounded a count up, and then the circles
       * cross an edge by the rounding error. */
      if (!place_fits(s, x, y, spacing / 2 * (1 - 4 * ROUNDING))) continue;
      site[n][0] = x;
      site[n++][1] = y;
    }
  }
  return n;
}

/* J. von Neumann's way, without trigonometric functions */
static void random_direction(gsl_rng *rng, double direction[2]) {
  double u, v, square;
  do {
    u = -1 + 2 * gsl_rng_uniform(rng);
    v = -1 + 2 * gsl_rng_uniform(rng);
    square = u * u + v * v;
  } while (square > 1.0 || square == 0.0);
  direction[0] = (u * u - v * v) / square;
  direction[1] = 2 * u * v / square;
}

void lattice_jitter(const place_space *s, gsl_rng *rng, double spacing, double jitter, size_t n,
                    const double *radius, double (*site)[2]) {
  for (size_t k = 0; k < n; k++) {
    double room = jitter * math_max(0, spacing / 2 - radius[k]), direction[2];
    random_direction(rng, direction);
    double way = room * sqrt(gsl_rng_uniform(rng));
    for (int c = 0; c < 2; c++) site[k][c] = periodic_wrap(s, site[k][c] + way * direction[c], c);
  }
}
