/* lattice.c: see lattice.h. */
#include "pack/lattice.h"

#include <gsl/gsl_randist.h>
#include <math.h>

/* What divides evenly shall do so in spite of rounding. */
#define ROUNDING 1e-9

/* Rows of a lattice. */
typedef struct rows {
  double rows, first, high;   /* how many, y of the first, distance */
  double columns[2], left[2]; /* of even and odd rows: how many, x of the first */
  double wide;
} rows;

static double whole(double x) { return fmax(0, floor(x + ROUNDING)); }

static rows plan(const place_space *s, sd_packing_kind kind, double spacing) {
  bool triangular = kind == SD_PACKING_TRIANGULAR;
  double width = s->upper[0] - s->lower[0], height = s->upper[1] - s->lower[1];
  double least = triangular ? spacing * sqrt(0.75) : spacing;
  rows r = {.wide = spacing, .high = least};
  if (s->edge[0]) {
    double shift = triangular ? spacing / 2 : 0, room = (width - spacing) / spacing;
    r.columns[0] = room > -ROUNDING ? whole(room) + 1 : 0;
    r.columns[1] = room - shift / spacing > -ROUNDING ? whole(room - shift / spacing) + 1 : 0;
    /* from the leftmost site to the rightmost one, of even or of odd rows */
    double extent = fmax((r.columns[0] - 1) * spacing, (r.columns[1] - 1) * spacing + shift);
    r.left[0] = s->lower[0] + (width - extent) / 2;
    r.left[1] = r.left[0] + shift;
  } else {
    r.columns[0] = r.columns[1] = whole(width / spacing);
    r.wide = width / fmax(1, r.columns[0]);
    r.left[0] = s->lower[0] + (triangular ? r.wide / 4 : r.wide / 2);
    r.left[1] = r.left[0] + (triangular ? r.wide / 2 : 0);
  }
  if (s->edge[1]) {
    double room = (height - spacing) / least;
    r.rows = room > -ROUNDING ? whole(room) + 1 : 0;
    r.first = s->lower[1] + spacing / 2;
  } else {
    r.rows = triangular ? 2 * whole(height / least / 2) : whole(height / least);
    r.high = height / fmax(1, r.rows);
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
      /* the circle of a site may reach over the edge by what whole() has forgiven */
      if (!place_fits(s, x, y, spacing / 2 * (1 - 4 * ROUNDING))) continue;
      site[n][0] = x;
      site[n++][1] = y;
    }
  }
  return n;
}

void lattice_jitter(const place_space *s, gsl_rng *rng, double spacing, double jitter, size_t n,
                    const double *radius, double (*site)[2]) {
  for (size_t k = 0; k < n; k++) {
    double room = jitter * fmax(0, spacing / 2 - radius[k]), direction[2];
    gsl_ran_dir_2d(rng, &direction[0], &direction[1]);
    double way = room * sqrt(gsl_rng_uniform(rng));
    for (int c = 0; c < 2; c++) site[k][c] = place_wrapped(s, site[k][c] + way * direction[c], c);
  }
}
