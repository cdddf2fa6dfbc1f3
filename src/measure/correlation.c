/* correlation.c: pair correlation and distributions of forces, with threads (see correlation.h). */
#include "base/gsl.h"
#include "measure/correlation.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "base/buckets.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/team.h"
#include "measure/statistics.h"
#include "model/model.h"

/* --- pairs of centres ------------------------------------------------------------------------- */

/* Disk centres in the window W (correlation.h), sorted into grid cells no narrower than the largest
 * r of g(r). */
typedef struct grid {
  size_t n; /* number of disk centres, rows of at, x and y */
  double (*at)[2];
  double lower[2], width[2]; /* lower corner and lengths of the window */
  /* inverse[k]: 1/width[k] if direction k is periodic, else 0; narrows[k]: 0 if direction k is
   * periodic, 1 if the window has edges along k */
  double inverse[2], narrows[2];
  bool wraps[2];
  double offset; /* x shift of the periodic image above, in a sheared box */
  size_t cells[2];
  buckets sorted; /* disk centres of each grid cell */
  /* [n] coordinates of the disk centres, ordered by grid cell */
  double *x, *y;
} grid;

static size_t grid_cell(const void *with, size_t i) {
  const grid *g = with;
  size_t cell[2];
  for (int k = 0; k < 2; k++)
    cell[k] =
        cell_nearest((g->at[i][k] - g->lower[k]) / g->width[k] * (double)g->cells[k], g->cells[k]);
  return cell[1] * g->cells[0] + cell[0];
}

/* Sorts the disk centres into grid cells, of which there are at most about four per disk. */
static sd_status grid_fill(grid *g, double reach) {
  for (int k = 0; k < 2; k++) {
    const double most = floor(2.0 * sqrt((double)g->n)) + 1.0;
    g->cells[k] = (size_t)math_max(math_min(floor(g->width[k] / reach), most), 1.0);
    /* with two cells along a periodic direction, each would be the other's neighbour twice */
    if (g->wraps[k] && g->cells[k] < 3) g->cells[k] = 1;
    g->inverse[k] = g->wraps[k] ? 1.0 / g->width[k] : 0.0;
    g->narrows[k] = g->wraps[k] ? 0.0 : 1.0;
  }
  if (g->offset != 0.0 && g->cells[1] == 1) g->cells[0] = 1;
  if (!buckets_new(&g->sorted, g->n, g->cells[0] * g->cells[1], grid_cell, g)) return SD_ERROR_IO;
  for (size_t k = 0; k < g->n; k++) {
    g->x[k] = g->at[g->sorted.item[k]][0];
    g->y[k] = g->at[g->sorted.item[k]][1];
  }
  return SD_OK;
}

static void grid_free(grid *g) {
  free(g->at);
  buckets_free(&g->sorted);
  free(g->x);
  free(g->y);
  *g = (grid){0};
}

/* Returns a histogram with bins of equal width from 0 to `upper`. */
static gsl_histogram *histogram_new(size_t bins, double upper) {
  gsl_histogram *h = gsl_histogram_calloc_uniform(bins, 0.0, upper);
  if (!h) memory_lacks(0);
  return h;
}

/* Number of chunks of rows of grid cells. All threads count pairs, one chunk at a time. The
 * histograms of the chunks are added in order, so that the sums do not depend on the number of
 * threads. */
enum { CHUNKS = 32 };
typedef struct counter {
  const grid *g;
  double reach;
  size_t bins;
  const double *range; /* [bins + 1] limits of the bins, in r */
  double *bin;         /* [CHUNKS][bins] histogram of each chunk */
  atomic_size_t next;  /* index of the next chunk to be counted */
} counter;

/* Rounds to the nearest integer like nearbyint, in a form that compilers vectorise; |x| < 2^51. */
static inline double rounded(double x) {
  static const double shift = 0x1.8p52;
  return (x + shift) - shift;
}

/* Counts the pairs of centre i with the centres first ... last - 1, at most BATCH of these at a
 * time: computes all their distances, selects those within q->reach, and adds them to the bins. */
static void count_run(const counter *q, double *bin, size_t i, size_t first, size_t last) {
  enum { BATCH = 64 };
  const grid *g = q->g;
  double square[BATCH], area[BATCH];
  const double limit = q->reach * q->reach, scale = (double)q->bins / q->reach;
  for (size_t n; first < last; first += n) {
    size_t near = 0;
    n = last - first < BATCH ? last - first : BATCH;
    for (size_t k = 0; k < n; k++) {
      double y = g->y[first + k] - g->y[i], turns = rounded(y * g->inverse[1]);
      double x = g->x[first + k] - g->x[i] - g->offset * turns;
      y -= g->width[1] * turns;
      x -= g->width[0] * rounded(x * g->inverse[0]);
      square[k] = x * x + y * y;
      area[k] = (g->width[0] - g->narrows[0] * fabs(x)) * (g->width[1] - g->narrows[1] * fabs(y));
    }
    for (size_t k = 0; k < n; k++) {
      const bool is_near = square[k] <= limit;
      square[near] = square[k];
      area[near] = area[k];
      near += is_near;
    }
    for (size_t k = 0; k < near; k++) {
      const double r = sqrt(square[k]);
      size_t b = (size_t)(r * scale);
      if (!(r < q->reach)) continue;
      b = b < q->bins ? b : q->bins - 1;
      b += r >= q->range[b + 1];
      b -= r < q->range[b];
      bin[b] += 2.0 / area[k]; /* one weight for the pair (i, j), one for (j, i) */
    }
  }
}

/* Counts the pairs of centres in cells c and `other`. The callers' loops visit each pair of cells
 * in both orders, so calls with other < c do nothing. */
static void count_cells(const counter *q, double *bin, size_t c, size_t other) {
  const uint32_t *start = q->g->sorted.start;
  for (size_t p = start[c]; other >= c && p < start[c + 1]; p++)
    count_run(q, bin, p, c == other ? p + 1 : start[other], start[other + 1]);
}

/* Finds the neighbour *to of cell `from` in direction k (0: x, 1: y), at the other end of the
 * window if direction k is periodic. Returns false if the neighbour is outside the window. */
static bool step_cell(const grid *g, int k, size_t from, int step, size_t *to) {
  if (g->cells[k] == 1) return *to = 0, step == 0;
  if (step < 0 && from == 0) return *to = g->cells[k] - 1, g->wraps[k];
  if (step > 0 && from + 1 == g->cells[k]) return *to = 0, g->wraps[k];
  *to = (size_t)((int64_t)from + step);
  return true;
}

/* Counts the pairs of cell c, in column x, with those cells of `row` that are near it in the
 * periodic image above (side 1) or below (side -1). In a sheared box this image is shifted along
 * x. */
static void count_shifted(const counter *q, double *bin, size_t c, size_t x, size_t row, int side) {
  const grid *g = q->g;
  const int64_t n = (int64_t)g->cells[0];
  const int64_t first = (int64_t)floor((double)x - side * g->offset / g->width[0] * (double)n) - 1;
  for (int64_t k = first; k < first + (n < 4 ? n : 4); k++)
    count_cells(q, bin, c, row * g->cells[0] + (size_t)(((k % n) + n) % n));
}

static void count_row(const counter *q, double *bin, size_t y) {
  const grid *g = q->g;
  for (size_t x = 0; x < g->cells[0]; x++) {
    size_t c = y * g->cells[0] + x;
    for (int k = 0; k < 9; k++) {
      size_t nx, ny;
      if (!step_cell(g, 0, x, k % 3 - 1, &nx) || !step_cell(g, 1, y, k / 3 - 1, &ny)) continue;
      const bool shifted =
          g->offset != 0.0 && k / 3 != 1 && g->cells[1] > 1 && ny + 1 != y && ny != y + 1;
      if (!shifted)
        count_cells(q, bin, c, ny * g->cells[0] + nx);
      else if (k % 3 == 0)
        count_shifted(q, bin, c, x, ny, k / 3 - 1); /* one call counts all three columns */
    }
  }
}

static void count_together(const team *t, void *with) {
  counter *q = with;
  (void)t;
  for (size_t k = q->next++; k < CHUNKS; k = q->next++) {
    const size_t rows = q->g->cells[1];
    for (size_t y = rows * k / CHUNKS; y < rows * (k + 1) / CHUNKS; y++)
      count_row(q, q->bin + k * q->bins, y);
  }
}

static void count_pairs(const grid *g, gsl_histogram *h, double reach) {
  counter q = {.g = g, .reach = reach, .bins = h->n, .range = h->range};
  q.bin = memory_new(CHUNKS * h->n, sizeof *q.bin);
  pool_run_once(g->n, count_together, &q);
  for (size_t k = 0; k < CHUNKS; k++)
    for (size_t b = 0; b < h->n; b++) h->bin[b] += q.bin[k * h->n + b];
  free(q.bin);
}

/* Sets the window to the region, cut down to the bounding box of the disks along directions that
 * are not periodic, and collects the disk centres in it. */
static sd_status fill_window(grid *g, const configuration *c, const region *r) {
  const sd_model *m = c->model;
  double upper[2], low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  const memory_column rows[] = {{&g->at, m->n_disks, sizeof *g->at},
                                {&g->x, m->n_disks, sizeof *g->x},
                                {&g->y, m->n_disks, sizeof *g->y}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows)) return SD_ERROR_IO;
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (d->driven || !region_holds(r, d->position[0], d->position[1])) continue;
    for (int k = 0; k < 2; k++) {
      double at = d->position[k];
      double period = r->whole[k] ? c->length[k] : r->image[k];
      if (period > 0.0) at -= period * floor((at - r->lower[k]) / period);
      g->at[g->n][k] = at;
      low[k] = math_min(low[k], at - d->radius);
      high[k] = math_max(high[k], at + d->radius);
    }
    g->n++;
  }
  for (int k = 0; k < 2; k++) {
    g->wraps[k] = r->whole[k];
    g->lower[k] = g->wraps[k] ? r->lower[k] : math_max(r->lower[k], low[k]);
    upper[k] = g->wraps[k] ? r->upper[k] : math_min(r->upper[k], high[k]);
    g->width[k] = upper[k] - g->lower[k];
  }
  g->offset = g->wraps[1] ? c->offset : 0.0;
  return SD_OK;
}

static sd_status correlate(correlation *t, const configuration *c, const region *r, size_t bins) {
  grid g = {0};
  sd_status status = fill_window(&g, c, r);
  t->n_disks = g.n;
  t->reach = 10.0 * configuration_radius(c);
  for (int k = 0; k < 2; k++) t->reach = math_min(t->reach, 0.5 * g.width[k]);
  const bool pairs = g.n > 1 && t->reach > 0.0;
  if (status == SD_OK && pairs) status = grid_fill(&g, t->reach);
  if (status == SD_OK && pairs) {
    double area = g.width[0] * g.width[1], n = (double)g.n;
    t->density = n / area;
    t->pairs = histogram_new(bins, t->reach);
    count_pairs(&g, t->pairs, t->reach);
    for (size_t k = 0; k < bins; k++) {
      double low, high;
      gsl_histogram_get_range(t->pairs, k, &low, &high);
      t->pairs->bin[k] /= n * (n - 1.0) / (area * area) * M_PI * (high * high - low * low);
    }
    size_t top = gsl_histogram_max_bin(t->pairs);
    t->peak = gsl_histogram_get(t->pairs, top);
    t->peak_r = 0.5 * (t->pairs->range[top] + t->pairs->range[top + 1]);
  }
  grid_free(&g);
  return status;
}

/* --- forces ----------------------------------------------------------------------------------- */

/* Computes the distribution of n values, in `bins` bins from 0 to `most`. scaled: true if the
 * values are divided by their mean first. */
static void distribute(distribution *d, double *value, size_t n, double most, size_t bins,
                       bool scaled) {
  *d = (distribution){.n = n,
                      .mean = NAN,
                      .deviation = NAN,
                      .skewness = NAN,
                      .kurtosis = NAN,
                      .least = NAN,
                      .most = NAN};
  if (n == 0) return;
  d->mean = statistics_mean(value, n);
  gsl_stats_minmax(&d->least, &d->most, value, 1, n);
  d->histogram = histogram_new(bins, most);
  double unit = scaled && d->mean > 0.0 ? d->mean : 1.0;
  for (size_t k = 0; k < n; k++) {
    value[k] /= unit;
    if (!scaled) /* put a value at the upper limit into the last bin */
      value[k] = math_min(value[k], nextafter(most, 0.0));
    d->beyond += value[k] >= most;
    gsl_histogram_increment(d->histogram, value[k]); /* GSL ignores values outside the bins */
  }
  double mean = d->mean / unit;
  d->deviation = statistics_deviation(value, n, mean, (double)n);
  if (n > 1 && d->deviation > 0.0) {
    double sd = statistics_deviation(value, n, mean, (double)n - 1.0);
    d->skewness = statistics_moment(value, n, mean, sd, 3);
    d->kurtosis = statistics_moment(value, n, mean, sd, 4) - 3.0;
  }
}

double distribution_density(const distribution *d, size_t bin) {
  const gsl_histogram *h = d->histogram;
  return gsl_histogram_get(h, bin) / ((double)d->n * (h->range[bin + 1] - h->range[bin]));
}

static sd_status distribute_forces(correlation *t, const configuration *c, const region *g,
                                   size_t bins) {
  double *value;
  if (!memory_row(&value, 3 * c->n_contacts, sizeof *value)) return SD_ERROR_IO;
  double *normal = value, *tangential = value + c->n_contacts,
         *mobilised = tangential + c->n_contacts;
  size_t n = 0, n_skin = 0;
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const double *centre = c->model->disks[q->a].position;
    if (!(q->force > 0.0) || !region_holds(g, centre[0] + 0.5 * q->lx, centre[1] + 0.5 * q->ly))
      continue;
    normal[n++] = q->force;
    if (!(q->mu > 0.0 && q->push > 0.0) || !isfinite(q->tau)) continue;
    tangential[n_skin] = fabs(q->tau);
    mobilised[n_skin++] = fabs(q->tau + q->bond_shear) / (q->mu * q->push);
    t->n_limit += q->slide != 0;
  }
  distribute(&t->normal, normal, n, CORRELATION_FORCES, bins, true);
  distribute(&t->tangential, tangential, n_skin, CORRELATION_FORCES, bins, true);
  distribute(&t->mobilised, mobilised, n_skin, 1.0, bins, false);
  free(value);
  return SD_OK;
}

/* --- all distributions ------------------------------------------------------------------------ */

sd_status correlation_new(correlation *t, const configuration *c, const region *g, size_t bins,
                          sd_messages *messages) {
  *t = (correlation){.density = NAN, .peak_r = NAN, .peak = NAN};
  gsl_error_handler_t *before = gsl_set_error_handler_off();
  sd_status status = correlate(t, c, g, bins);
  if (status == SD_OK) status = distribute_forces(t, c, g, bins);
  gsl_set_error_handler(before);
  if (status != SD_OK) sd_fail(messages, status, "no memory for the distributions");
  return status;
}

void correlation_free(correlation *t) {
  gsl_histogram *all[] = {t->pairs, t->normal.histogram, t->tangential.histogram,
                          t->mobilised.histogram};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++)
    if (all[k]) gsl_histogram_free(all[k]);
  *t = (correlation){0};
}
