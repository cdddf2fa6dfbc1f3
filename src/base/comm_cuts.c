/* comm_cuts.c: implements comm_cuts.h. */
#include "base/comm_cuts.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"

typedef struct rectangle {
  double low[2], high[2];
} rectangle;

struct comm_cuts {
  const comm *c;
  /* division made by Zoltan, in an MPI job; NULL: the rectangles are in `of` */
  struct zoltan_cuts *zoltan;
  rectangle *of; /* [comm_size()] rectangle of each rank; not used if Zoltan makes the division */
};

static const rectangle PLANE = {{-HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL}};

comm_cuts *comm_cuts_new(const comm *c) {
  comm_cuts *cuts = memory_new(1, sizeof *cuts);
  cuts->c = c;
  cuts->of = memory_new((size_t)comm_size(c), sizeof *cuts->of);
  for (int q = 0; q < comm_size(c); q++) cuts->of[q] = PLANE;
#ifdef SD_HAVE_MPI
  if (c && c == comm_world() && !(cuts->zoltan = zoltan_cuts_new())) {
    comm_cuts_free(cuts);
    return NULL;
  }
#endif
  return cuts;
}

void comm_cuts_free(comm_cuts *cuts) {
  if (!cuts) return;
#ifdef SD_HAVE_MPI
  if (cuts->zoltan) zoltan_cuts_free(cuts->zoltan);
#endif
  free(cuts->of);
  free(cuts);
}

const comm *comm_cuts_comm(const comm_cuts *cuts) { return cuts->c; }

/* --- bisection of points that every rank knows ------------------------------------------------ */

typedef struct point {
  double at[2], weight;
} point;

static int by_x(const void *one, const void *two) {
  const double a = ((const point *)one)->at[0], b = ((const point *)two)->at[0];
  return (a > b) - (a < b);
}

static int by_y(const void *one, const void *two) {
  const double a = ((const point *)one)->at[1], b = ((const point *)two)->at[1];
  return (a > b) - (a < b);
}

/* Returns the axis (0: x, 1: y) along which the bounding box of the points is longer. */
static int longer_side(const point *p, size_t n) {
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (size_t k = 0; k < n; k++)
    for (int c = 0; c < 2; c++) {
      low[c] = math_min(low[c], p[k].at[c]);
      high[c] = math_max(high[c], p[k].at[c]);
    }
  return high[1] - low[1] > high[0] - low[0];
}

/* Cuts the rectangle of[0] into `ranks` rectangles, of[0 ... ranks-1], in which the points have
 * about the same total weight. Sorts the points p. */
static void bisect(point *p, size_t n, rectangle *of, int ranks) {
  if (ranks < 2) return;
  const int side = longer_side(p, n), first = ranks / 2;
  double all = 0.0, below = 0.0, cut = 0.0;
  size_t k = 0;
  if (n > 1) qsort(p, n, sizeof *p, side ? by_y : by_x);
  for (size_t i = 0; i < n; i++) all += p[i].weight;
  while (k < n && below + 0.5 * p[k].weight < all * first / ranks) below += p[k++].weight;
  while (k > 0 && k < n && p[k].at[side] == p[k - 1].at[side]) k++;
  if (n > 0)
    cut = k == 0   ? p[0].at[side]
          : k == n ? p[n - 1].at[side] + 1.0
                   : 0.5 * (p[k - 1].at[side] + p[k].at[side]);
  of[first] = of[0];
  of[0].high[side] = of[first].low[side] = cut;
  bisect(p, k, of, first);
  bisect(p + k, n - k, of + first, ranks - first);
}

/* Gathers the points of all ranks on every rank. Returns an array of *n_all points, which the
 * caller frees, or NULL on all ranks if any rank lacks memory. */
static point *gather_points(const comm *c, size_t n, const double *x, const double *y,
                            const float *weight, size_t *n_all) {
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  point *mine = NULL, *all = NULL;
  *n_all = 0;
  comm_gather_counts(c, (int)n, counts);
  for (int q = 0; q < comm_size(c); q++) *n_all += (size_t)counts[q];
  const memory_column arrays[] = {{&mine, n, sizeof *mine}, {&all, *n_all, sizeof *all}};
  const bool there = memory_rows(sizeof arrays / sizeof *arrays, arrays);
  for (size_t k = 0; there && k < n; k++) mine[k] = (point){{x[k], y[k]}, (double)weight[k]};
  if (comm_or(c, !there)) {
    free(all);
    all = NULL;
  } else {
    comm_gather(c, mine, all, counts, sizeof *all);
  }
  free(mine);
  free(counts);
  return all;
}

/* --- public functions ------------------------------------------------------------------------- */

sd_status comm_cuts_make(comm_cuts *cuts, size_t n, const double *x, const double *y,
                         const float *weight) {
  size_t n_all;
  if (!cuts->c) return SD_OK;
#ifdef SD_HAVE_MPI
  if (cuts->zoltan) return zoltan_cuts_make(cuts->zoltan, n, x, y, weight);
#endif
  point *all = gather_points(cuts->c, n, x, y, weight, &n_all);
  if (!all) return SD_ERROR_IO;
  cuts->of[0] = PLANE;
  bisect(all, n_all, cuts->of, comm_size(cuts->c));
  free(all);
  return SD_OK;
}

int comm_cuts_owner(const comm_cuts *cuts, double x, double y) {
#ifdef SD_HAVE_MPI
  if (cuts->zoltan) return zoltan_cuts_owner(cuts->zoltan, x, y);
#endif
  for (int q = 0; q < comm_size(cuts->c); q++) {
    const rectangle *r = &cuts->of[q];
    if (x >= r->low[0] && x < r->high[0] && y >= r->low[1] && y < r->high[1]) return q;
  }
  return 0; /* A coordinate is NaN or infinite; rank 0 owns such points by convention. */
}

int comm_cuts_near(const comm_cuts *cuts, const double low[2], const double high[2], int *ranks) {
  int n = 0;
#ifdef SD_HAVE_MPI
  if (cuts->zoltan) return zoltan_cuts_near(cuts->zoltan, low, high, ranks);
#endif
  for (int q = 0; q < comm_size(cuts->c); q++) {
    const rectangle *r = &cuts->of[q];
    if (low[0] <= r->high[0] && high[0] >= r->low[0] && low[1] <= r->high[1] &&
        high[1] >= r->low[1])
      ranks[n++] = q;
  }
  return n;
}

void comm_cuts_mine(const comm_cuts *cuts, double low[2], double high[2]) {
#ifdef SD_HAVE_MPI
  if (cuts->zoltan) {
    zoltan_cuts_of(cuts->zoltan, comm_rank(cuts->c), low, high);
    return;
  }
#endif
  const rectangle *mine = &cuts->of[comm_rank(cuts->c)];
  for (int k = 0; k < 2; k++) {
    low[k] = mine->low[k];
    high[k] = mine->high[k];
  }
}
