/* sites.c: grids of circles and search by power distance (see sites.h). */
#include "measure/sites.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"

sd_status sites_add(sites *s, double x, double y, double radius) {
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

void sites_free(sites *s) {
  free(s->at);
  free(s->radius);
  free(s->octave_of);
  for (int o = 0; o < SITES_OCTAVES; o++) {
    free(s->octave[o].start);
    free(s->octave[o].site);
  }
  *s = (sites){0};
}

/* --- grids ------------------------------------------------------------------------------------ */

static int octave_of(double radius, double largest) {
  int o = radius > 0.0 ? (int)fmin(floor(log2(largest / radius)), SITES_OCTAVES - 1)
                       : SITES_OCTAVES - 1;
  return o > 0 ? o : 0;
}

/* Returns the index along k of the cell that contains `at`, or of the nearest cell. */
static size_t cell_along(const sites_grid *g, int k, double at) {
  double place = floor((at - g->lower[k]) / g->width);
  return place > 0.0 ? (size_t)fmin(place, (double)(g->cells[k] - 1)) : 0;
}

static size_t cell_of(const sites_grid *g, const double at[2]) {
  return cell_along(g, 1, at[1]) * g->cells[0] + cell_along(g, 0, at[0]);
}

/* Chooses square cells with about two sites each, from g->lower to `upper`. */
static sd_status shape(sites_grid *g, const double upper[2], size_t n) {
  const double x = upper[0] - g->lower[0], y = upper[1] - g->lower[1];
  g->width = fmax(sqrt(2.0 * x * y / (double)n), fmax(x, y) / (double)n);
  if (!(g->width > 0.0)) g->width = 1.0;
  g->cells[0] = (size_t)floor(x / g->width) + 1;
  g->cells[1] = (size_t)floor(y / g->width) + 1;
  const memory_column rows[] = {{&g->start, g->cells[0] * g->cells[1] + 2, sizeof *g->start},
                                {&g->site, n, sizeof *g->site}};
  return memory_rows(sizeof rows / sizeof *rows, rows) ? SD_OK : SD_ERROR_IO;
}

static sd_status sort_octave(sites *s, sites_grid *g, int octave) {
  double upper[2] = {-HUGE_VAL, -HUGE_VAL};
  size_t n = 0;
  for (int k = 0; k < 2; k++) g->lower[k] = HUGE_VAL;
  for (size_t i = 0; i < s->n; i++) {
    if (s->octave_of[i] != octave) continue;
    n++;
    g->largest = fmax(g->largest, s->radius[i]);
    for (int k = 0; k < 2; k++) {
      g->lower[k] = fmin(g->lower[k], s->at[i][k]);
      upper[k] = fmax(upper[k], s->at[i][k]);
    }
  }
  if (n == 0) return SD_OK;
  if (shape(g, upper, n) != SD_OK) return SD_ERROR_IO;
  for (size_t i = 0; i < s->n; i++)
    if (s->octave_of[i] == octave) g->start[cell_of(g, s->at[i]) + 2]++;
  for (size_t c = 0; c < g->cells[0] * g->cells[1]; c++) g->start[c + 2] += g->start[c + 1];
  for (size_t i = 0; i < s->n; i++)
    if (s->octave_of[i] == octave) g->site[g->start[cell_of(g, s->at[i]) + 1]++] = (uint32_t)i;
  return SD_OK;
}

sd_status sites_sort(sites *s) {
  double largest = 0.0;
  size_t in_octave[SITES_OCTAVES] = {0};
  sd_status status = SD_OK;
  for (size_t i = 0; i < s->n; i++) largest = fmax(largest, s->radius[i]);
  for (size_t i = 0; i < s->n; i++)
    in_octave[s->octave_of[i] = (unsigned char)octave_of(s->radius[i], largest)]++;
  for (int o = 0; status == SD_OK && o < SITES_OCTAVES; o++) {
    if (in_octave[o] > 0) status = sort_octave(s, &s->octave[o], o);
    s->one_octave = s->one_octave || in_octave[o] == s->n;
  }
  return status;
}

/* --- searches --------------------------------------------------------------------------------- */

typedef struct search {
  const sites *s;
  size_t own, found;
  /* at: the point; least: smallest power distance so far, that of site `found` */
  double at[2], least;
} search;

static void look(search *q, const sites_grid *g, size_t x, size_t y) {
  const size_t c = y * g->cells[0] + x;
  for (size_t k = g->start[c]; k < g->start[c + 1]; k++) {
    const size_t i = g->site[k];
    const double dx = q->s->at[i][0] - q->at[0], dy = q->s->at[i][1] - q->at[1],
                 r = q->s->radius[i];
    const double power = dx * dx + dy * dy - r * r;
    if (!(power < q->least) || i == q->own) continue;
    q->least = power;
    q->found = i;
  }
}

/* Searches the cells at a distance of `ring` cells from the middle one, within the grid. */
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

/* Searches rings of cells around the cell nearest to the point until no site farther out can be
 * nearer. The lower bound of the distance to a ring adds, for a point outside the grid, its
 * distance from the grid. */
static void search_octave(search *q, const sites_grid *g) {
  size_t middle[2], last = 0;
  /* distance from the point to the nearest edge of the middle cell */
  double beyond[2], inner = HUGE_VAL;
  for (int k = 0; k < 2; k++) {
    const double top = g->lower[k] + (double)g->cells[k] * g->width;
    middle[k] = cell_along(g, k, q->at[k]);
    beyond[k] = fmax(fmax(g->lower[k] - q->at[k], q->at[k] - top), 0.0);
    const double low = g->lower[k] + (double)middle[k] * g->width;
    inner = fmin(inner, fmax(fmin(q->at[k] - low, low + g->width - q->at[k]), 0.0));
    const size_t after = g->cells[k] - 1 - middle[k];
    last = middle[k] > last ? middle[k] : last;
    last = after > last ? after : last;
  }
  for (size_t ring = 0; ring <= last; ring++) {
    const double far = ring > 0 ? (double)(ring - 1) * g->width + inner : 0.0;
    const double x = beyond[0] + far, y = beyond[1] + far;
    const double nearest = fmin(x * x + beyond[1] * beyond[1], beyond[0] * beyond[0] + y * y);
    if (nearest - g->largest * g->largest > q->least) return;
    look_around(q, g, middle, ring);
  }
}

size_t sites_nearest(const sites *s, size_t own, const double at[2], double most) {
  search q = {.s = s, .own = own, .found = SIZE_MAX, .at = {at[0], at[1]}, .least = most};
  for (int o = 0; o < SITES_OCTAVES; o++)
    if (s->octave[o].start) search_octave(&q, &s->octave[o]);
  return q.found;
}

size_t sites_around(const sites *s, size_t i, uint32_t *found, size_t room, sites_block *block) {
  const sites_grid *g = &s->octave[s->octave_of[i]];
  const size_t x = cell_along(g, 0, s->at[i][0]), y = cell_along(g, 1, s->at[i][1]);
  size_t n = 0;
  for (size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < g->cells[1]; v++)
    for (size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < g->cells[0]; u++)
      for (size_t k = g->start[v * g->cells[0] + u];
           k < g->start[v * g->cells[0] + u + 1] && n < room; k++)
        if (g->site[k] != i) found[n++] = g->site[k];
  block->complete = s->one_octave && n < room;
  for (int k = 0; k < 2; k++) {
    block->lower[k] = g->lower[k] + ((double)(k ? y : x) - 1.0) * g->width;
    block->upper[k] = block->lower[k] + 3.0 * g->width;
  }
  return n;
}
