/* correlation.c: see correlation.h. */
#include "measure/correlation.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>

/* --- pairs of centres --------------------------------------------------------------------------------- */

/* Disks of the window in square cells no smaller than the reach. */
typedef struct grid {
  size_t n;
  double (*at)[2];
  double lower[2], width[2]; /* of the window */
  bool wraps[2];
  size_t cells[2];
  size_t *start;
  uint32_t *disk;
} grid;

static size_t grid_cell(const grid *g, const double at[2]) {
  size_t cell[2];
  for (int k = 0; k < 2; k++) {
    double place = (at[k] - g->lower[k]) / g->width[k] * (double)g->cells[k];
    cell[k] = place > 0.0 ? (size_t)fmin(place, (double)(g->cells[k] - 1)) : 0;
  }
  return cell[1] * g->cells[0] + cell[0];
}

static sd_status grid_fill(grid *g, double reach) {
  for (int k = 0; k < 2; k++) {
    double most = 2.0 * sqrt((double)g->n) + 1.0;
    g->cells[k] = (size_t)fmax(fmin(floor(g->width[k] / reach), most), 1.0);
    if (g->wraps[k] && g->cells[k] < 3) g->cells[k] = 1; /* else a cell is its neighbour twice */
  }
  size_t cells = g->cells[0] * g->cells[1];
  g->start = calloc(cells + 2, sizeof *g->start);
  g->disk = calloc(g->n + 1, sizeof *g->disk);
  if (!g->start || !g->disk) return SD_ERROR_IO;
  for (size_t i = 0; i < g->n; i++) g->start[grid_cell(g, g->at[i]) + 2]++;
  for (size_t c = 0; c < cells; c++) g->start[c + 2] += g->start[c + 1];
  for (size_t i = 0; i < g->n; i++) g->disk[g->start[grid_cell(g, g->at[i]) + 1]++] = (uint32_t)i;
  return SD_OK;
}

static void grid_free(grid *g) {
  free(g->at);
  free(g->start);
  free(g->disk);
  *g = (grid){0};
}

static void count_pair(const grid *g, size_t i, size_t j, gsl_histogram *h, double reach) {
  double d[2], weight = 2.0; /* i, j and j, i */
  for (int k = 0; k < 2; k++) {
    d[k] = g->at[j][k] - g->at[i][k];
    if (g->wraps[k]) d[k] -= g->width[k] * nearbyint(d[k] / g->width[k]);
  }
  double r = hypot(d[0], d[1]);
  if (!(r < reach)) return;
  for (int k = 0; k < 2; k++) weight /= g->wraps[k] ? g->width[k] : g->width[k] - fabs(d[k]);
  gsl_histogram_accumulate(h, r, weight);
}

/* Neighbouring cell, or false beyond the window. */
static bool step_cell(const grid *g, int k, size_t from, int step, size_t *to) {
  if (g->cells[k] == 1) return *to = 0, step == 0;
  if (step < 0 && from == 0) return *to = g->cells[k] - 1, g->wraps[k];
  if (step > 0 && from + 1 == g->cells[k]) return *to = 0, g->wraps[k];
  *to = (size_t)((int64_t)from + step);
  return true;
}

static void count_pairs(const grid *g, gsl_histogram *h, double reach) {
  for (size_t y = 0; y < g->cells[1]; y++)
    for (size_t x = 0; x < g->cells[0]; x++) {
      size_t c = y * g->cells[0] + x;
      for (int k = 0; k < 9; k++) {
        size_t nx, ny;
        if (!step_cell(g, 0, x, k % 3 - 1, &nx) || !step_cell(g, 1, y, k / 3 - 1, &ny)) continue;
        size_t other = ny * g->cells[0] + nx;
        for (size_t p = g->start[c]; p < g->start[c + 1]; p++)
          for (size_t q = g->start[other]; q < g->start[other + 1]; q++)
            if (g->disk[p] < g->disk[q]) count_pair(g, g->disk[p], g->disk[q], h, reach);
      }
    }
}

/* The region, and no more than where disks are. */
static sd_status fill_window(grid *g, const configuration *c, const region *r) {
  const sd_model *m = c->model;
  double upper[2], low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  g->at = calloc(m->n_disks + 1, sizeof *g->at);
  if (!g->at) return SD_ERROR_IO;
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (d->driven || !region_holds(r, d->position[0], d->position[1])) continue;
    for (int k = 0; k < 2; k++) {
      double at = d->position[k];
      double period = r->whole[k] ? c->length[k] : r->image[k];
      if (period > 0.0) at -= period * floor((at - r->lower[k]) / period);
      g->at[g->n][k] = at;
      low[k] = fmin(low[k], at - d->radius);
      high[k] = fmax(high[k], at + d->radius);
    }
    g->n++;
  }
  for (int k = 0; k < 2; k++) {
    g->wraps[k] = r->whole[k];
    g->lower[k] = g->wraps[k] ? r->lower[k] : fmax(r->lower[k], low[k]);
    upper[k] = g->wraps[k] ? r->upper[k] : fmin(r->upper[k], high[k]);
    g->width[k] = upper[k] - g->lower[k];
  }
  return SD_OK;
}

static sd_status correlate(correlation *t, const configuration *c, const region *r, size_t bins) {
  grid g = {0};
  sd_status status = fill_window(&g, c, r);
  t->n_disks = g.n;
  t->reach = 10.0 * configuration_radius(c);
  for (int k = 0; k < 2; k++) t->reach = fmin(t->reach, 0.5 * g.width[k]);
  if (status == SD_OK && g.n > 1 && t->reach > 0.0) {
    double area = g.width[0] * g.width[1], n = (double)g.n;
    t->density = n / area;
    t->pairs = gsl_histogram_calloc_uniform(bins, 0.0, t->reach);
    status = t->pairs ? grid_fill(&g, t->reach) : SD_ERROR_IO;
    if (status == SD_OK) count_pairs(&g, t->pairs, t->reach);
    for (size_t k = 0; status == SD_OK && k < bins; k++) {
      double low, high;
      gsl_histogram_get_range(t->pairs, k, &low, &high);
      t->pairs->bin[k] /= n * (n - 1.0) / (area * area) * M_PI * (high * high - low * low);
    }
    if (status == SD_OK) {
      size_t top = gsl_histogram_max_bin(t->pairs);
      t->peak = gsl_histogram_get(t->pairs, top);
      t->peak_r = 0.5 * (t->pairs->range[top] + t->pairs->range[top + 1]);
    }
  }
  grid_free(&g);
  return status;
}

/* --- forces ------------------------------------------------------------------------------------------- */

/* scaled: values are divided by their mean. */
static sd_status distribute(distribution *d, double *value, size_t n, double most, size_t bins, bool scaled) {
  *d = (distribution){.n = n, .mean = NAN, .deviation = NAN, .skewness = NAN, .kurtosis = NAN};
  if (n == 0) return SD_OK;
  d->mean = gsl_stats_mean(value, 1, n);
  gsl_stats_minmax(&d->least, &d->most, value, 1, n);
  d->histogram = gsl_histogram_calloc_uniform(bins, 0.0, most);
  if (!d->histogram) return SD_ERROR_IO;
  double unit = scaled && d->mean > 0.0 ? d->mean : 1.0;
  for (size_t k = 0; k < n; k++) {
    value[k] /= unit;
    if (!scaled) value[k] = fmin(value[k], nextafter(most, 0.0)); /* the limit belongs to the last bin */
    d->beyond += value[k] >= most;
    gsl_histogram_increment(d->histogram, value[k]); /* what is beyond is left out */
  }
  double mean = d->mean / unit;
  d->deviation = gsl_stats_sd_with_fixed_mean(value, 1, n, mean);
  if (n > 1 && d->deviation > 0.0) {
    double sd = gsl_stats_sd_m(value, 1, n, mean);
    d->skewness = gsl_stats_skew_m_sd(value, 1, n, mean, sd);
    d->kurtosis = gsl_stats_kurtosis_m_sd(value, 1, n, mean, sd);
  }
  return SD_OK;
}

double distribution_density(const distribution *d, size_t bin) {
  const gsl_histogram *h = d->histogram;
  return gsl_histogram_get(h, bin) / ((double)d->n * (h->range[bin + 1] - h->range[bin]));
}

static sd_status distribute_forces(correlation *t, const configuration *c, const region *g, size_t bins) {
  double *value = calloc(3 * c->n_contacts + 1, sizeof *value);
  if (!value) return SD_ERROR_IO;
  double *normal = value, *tangential = value + c->n_contacts, *mobilised = tangential + c->n_contacts;
  size_t n = 0, n_skin = 0;
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const double *centre = c->model->disks[q->a].position;
    if (!(q->force > 0.0) || !region_holds(g, centre[0] + 0.5 * q->lx, centre[1] + 0.5 * q->ly)) continue;
    normal[n++] = q->force;
    if (!(q->mu > 0.0) || !isfinite(q->tau)) continue;
    tangential[n_skin] = fabs(q->tau);
    mobilised[n_skin++] = fabs(q->tau) / (q->mu * q->force);
    t->n_limit += q->slide != 0;
  }
  sd_status status = distribute(&t->normal, normal, n, CORRELATION_FORCES, bins, true);
  if (status == SD_OK)
    status = distribute(&t->tangential, tangential, n_skin, CORRELATION_FORCES, bins, true);
  if (status == SD_OK) status = distribute(&t->mobilised, mobilised, n_skin, 1.0, bins, false);
  free(value);
  return status;
}

/* --- all ---------------------------------------------------------------------------------------------- */

sd_status correlation_new(correlation *t, const configuration *c, const region *g, size_t bins,
                          sd_messages *messages) {
  *t = (correlation){0};
  gsl_error_handler_t *before = gsl_set_error_handler_off();
  sd_status status = correlate(t, c, g, bins);
  if (status == SD_OK) status = distribute_forces(t, c, g, bins);
  gsl_set_error_handler(before);
  if (status != SD_OK) sd_fail(messages, status, "no memory for the distributions");
  return status;
}

void correlation_free(correlation *t) {
  gsl_histogram *all[] = {t->pairs, t->normal.histogram, t->tangential.histogram, t->mobilised.histogram};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++)
    if (all[k]) gsl_histogram_free(all[k]);
  *t = (correlation){0};
}
