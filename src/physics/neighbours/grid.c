/* grid.c: builds the cell grid and searches it; implements grid.h. */
#include "physics/neighbours/grid.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/math.h"
#include "base/memory.h"
#include "physics/system/bodies.h"

/* Constants of the grid, chosen by measurement (tests/bench/README.md). LEVEL_FACTOR: ratio of the
 * largest to the smallest radius on a level; with a larger ratio a search tests more disks of each
 * level, with a smaller one it searches more levels. CELL_SIZE: side of a cell divided by the
 * largest distance at which two of the level's largest disks form a pair; where disks are sparse,
 * cells are larger. CELLS_PER_DISK: largest number of cells per disk. */
static const double LEVEL_FACTOR = 2.5, CELL_SIZE = 1.0, CELLS_PER_DISK = 4.0;

/* --- levels ----------------------------------------------------------------------------------- */

size_t grid_levels_of(const double *radius, size_t n, double factor, const comm *c,
                      double top[GRID_LEVELS]) {
  double least = HUGE_VAL, below = HUGE_VAL;
  size_t count = 0;
  assert(factor > 1.0);
  for (size_t i = 0; i < n; i++) least = radius[i] < least ? radius[i] : least;
  least = -comm_largest(c, -least);
  while (count < GRID_LEVELS) {
    double largest = 0.0;
    for (size_t i = 0; i < n; i++)
      if (radius[i] < below && radius[i] > largest) largest = radius[i];
    largest = comm_largest(c, largest);
    if (largest == 0.0) break;
    top[count++] = largest;
    below = largest / factor;
    if (least >= below) break;
  }
  return count;
}

static size_t level_of(const grid *g, double radius) {
  size_t k = 0;
  while (k + 1 < g->count && radius <= g->level[k + 1].largest) k++;
  return k;
}

/* --- cells ------------------------------------------------------------------------------------ */

/* Returns the index of the cell that contains coordinate `at` along direction c. Along an open
 * direction the first and last cell extend to infinity; along a periodic one disks lie inside the
 * box, except for a small distance (grid.overhang). */
static int64_t cell_of(const grid_level *l, int c, double at) {
  double k = math_min((at - l->lower[c]) * l->per_cell[c], (double)(l->cells[c] - 1));
  return k > 0.0 ? (int64_t)k : 0;
}

static size_t cell_index(const grid_level *l, double x, double y) {
  return (size_t)(cell_of(l, 1, y) * l->cells[0] + cell_of(l, 0, x));
}

/* Returns true if the body in this slot can have contacts. Only free disks that were not added yet
 * (waiting) or were removed cannot. */
static bool in_play(const sd_state *s, size_t slot) {
  return slot >= s->n_free || body_in_play(s, slot);
}

static void choose_cells(grid_level *l, const double low[2], const double high[2], double reach) {
  const double most = CELLS_PER_DISK * (double)l->count + 1.0;
  const double area = (high[0] - low[0]) * (high[1] - low[1]),
               size = math_max(CELL_SIZE * reach, sqrt(area / most));
  for (int c = 0; c < 2; c++) {
    const double span = high[c] - low[c], cells = math_max(math_min(floor(span / size), most), 1.0);
    l->lower[c] = low[c];
    l->cells[c] = (int64_t)cells;
    l->per_cell[c] = span > 0.0 ? cells / span : 0.0;
    assert(l->cells[c] >= 1 && isfinite(l->per_cell[c]));
  }
}

/* Results of one thread, for the disks that it counts. */
typedef struct grid_share {
  /* bounding box of the centres of these disks; low > high if there are none */
  _Alignas(64) double low[2], high[2];
  double overhang;
  size_t count[GRID_LEVELS];
  uint32_t last[GRID_LEVELS];
} grid_share;

typedef struct grid_task {
  const engine *e;
  grid *g;
  double margin;
  uint32_t *cell; /* [n_disks] index of the cell of each disk, on the disk's level */
  sd_status status;
  grid_share share[WORK_MAX_THREADS];
} grid_task;

/* Extends the bounding box to a point, the centre of a disk. Disks that have left the bounds of the
 * run (SD_OUTSIDE) are not passed to this function: one disk lost far away would make all cells
 * large. Points outside the grid belong to the nearest cell. */
static void find_extent(grid_share *mine, const double at[2]) {
  for (int c = 0; c < 2; c++) {
    if (at[c] < mine->low[c]) mine->low[c] = at[c];
    if (at[c] > mine->high[c]) mine->high[c] = at[c];
  }
}

/* Counts the disks of each level in slots [begin, end), and finds their bounding box and the
 * largest distance by which one lies outside a periodic box. */
static void count_disks(const grid_task *f, size_t begin, size_t end, grid_share *mine) {
  const sd_state *s = f->e->state;
  const work *w = &f->e->work;
  for (int c = 0; c < 2; c++) mine->low[c] = HUGE_VAL, mine->high[c] = -HUGE_VAL;
  for (size_t i = begin; i < end; i++) {
    const double at[2] = {s->x[i], s->y[i]};
    if (i >= s->n_free || s->activity[i] == SD_IN_PLAY || s->activity[i] == SD_HELD)
      find_extent(mine, at);
    if (!in_play(s, i)) continue;
    const size_t k = level_of(f->g, s->radius[i]);
    mine->count[k]++;
    mine->last[k] = (uint32_t)i;
    for (int c = 0; c < 2; c++)
      if (w->periodic[c])
        mine->overhang =
            math_max(mine->overhang, math_max(w->lower[c] - at[c], at[c] - w->upper[c]));
  }
}

static void join_counts(const grid_task *f, int threads, grid_share *all) {
  *all = f->share[0];
  for (int t = 1; t < threads; t++) {
    const grid_share *more = &f->share[t];
    for (int c = 0; c < 2; c++) {
      all->low[c] = math_min(all->low[c], more->low[c]);
      all->high[c] = math_max(all->high[c], more->high[c]);
    }
    all->overhang = math_max(all->overhang, more->overhang);
    for (size_t k = 0; k < f->g->count; k++) {
      all->count[k] += more->count[k];
      if (more->count[k]) all->last[k] = more->last[k];
    }
  }
  for (int c = 0; c < 2; c++)
    if (!(all->low[c] <= all->high[c])) all->low[c] = all->high[c] = 0.0;
}

static sd_status make_cells(grid_task *f, int threads) {
  const work *w = &f->e->work;
  const size_t n_disks = f->e->state->n_disks;
  grid *g = f->g;
  grid_share all;
  join_counts(f, threads, &all);
  double low[2], high[2];
  size_t cells = 0;
  g->overhang = all.overhang;
  for (int c = 0; c < 2; c++) {
    low[c] = w->periodic[c] ? w->lower[c] : all.low[c];
    high[c] = w->periodic[c] ? w->upper[c] : all.high[c];
  }
  for (size_t k = 0; k < g->count; k++) {
    grid_level *l = &g->level[k];
    l->count = all.count[k];
    l->last = all.last[k];
    for (int c = 0; c < 2; c++) l->periodic[c] = w->periodic[c];
    l->offset = w->offset;
    choose_cells(l, low, high, 2.0 * l->largest + f->margin);
    cells += (size_t)(l->cells[0] * l->cells[1]);
  }
  if (cells >= UINT32_MAX) return SD_ERROR_IO;
  if (!memory_rows(3, (memory_column[]){{&g->start, cells + 2 * g->count, sizeof *g->start},
                                        {&f->cell, n_disks, sizeof *f->cell},
                                        {&g->disks, n_disks, sizeof *g->disks}}))
    return SD_ERROR_IO;
  uint32_t *start = g->start, *disks = g->disks;
  for (size_t k = 0; k < g->count; k++) {
    grid_level *l = &g->level[k];
    l->start = start;
    l->disks = disks;
    start += l->cells[0] * l->cells[1] + 2;
    disks += l->count;
  }
  return SD_OK;
}

/* Returns *count, then adds 1 to it; atomically unless the caller is the only thread (alone). */
static uint32_t next_of(uint32_t *count, bool alone) {
  return alone ? (*count)++ : __atomic_fetch_add(count, 1, __ATOMIC_RELAXED);
}

static void count_cells(const grid_task *f, size_t begin, size_t end, bool alone) {
  const sd_state *s = f->e->state;
  for (size_t i = begin; i < end; i++) {
    if (!in_play(s, i)) continue;
    const grid_level *l = &f->g->level[level_of(f->g, s->radius[i])];
    f->cell[i] = (uint32_t)cell_index(l, s->x[i], s->y[i]);
    next_of(&l->start[f->cell[i] + 2], alone);
  }
}

static void add_up_cells(const grid *g) {
  for (size_t k = 0; k < g->count; k++) {
    const grid_level *l = &g->level[k];
    const size_t n = (size_t)(l->cells[0] * l->cells[1]);
    for (size_t c = 2; c < n + 2; c++) l->start[c] += l->start[c - 1];
    assert(l->start[0] == 0 && l->start[n + 1] == l->count);
  }
}

static void fill_cells(const grid_task *f, size_t begin, size_t end, bool alone) {
  const sd_state *s = f->e->state;
  for (size_t i = begin; i < end; i++) {
    if (!in_play(s, i)) continue;
    const grid_level *l = &f->g->level[level_of(f->g, s->radius[i])];
    l->disks[next_of(&l->start[f->cell[i] + 1], alone)] = (uint32_t)i;
  }
}

static int ascending(const void *one, const void *two) {
  const uint32_t *p = one, *q = two;
  return *p < *q ? -1 : *p > *q;
}

/* Sorts the disks of each cell by slot: several threads fill the cells, in no fixed order. */
static void sort_cells(const grid *g, const team *t) {
  for (size_t k = 0; k < g->count; k++) {
    const grid_level *l = &g->level[k];
    size_t begin, end;
    team_share(t, (size_t)(l->cells[0] * l->cells[1]), &begin, &end);
    for (size_t c = begin; c < end; c++) {
      const uint32_t from = l->start[c], to = l->start[c + 1];
      bool sorted = true;
      for (uint32_t n = from + 1; n < to; n++) sorted &= l->disks[n - 1] < l->disks[n];
      if (!sorted) qsort(l->disks + from, to - from, sizeof *l->disks, ascending);
    }
  }
}

/* Sorts all disks into the grid: by level, cell and slot. All threads call it together. */
static void grid_together(const team *t, void *with) {
  grid_task *f = with;
  const bool alone = t->size == 1;
  size_t begin, end;
  team_share(t, f->e->state->n_disks, &begin, &end);
  count_disks(f, begin, end, &f->share[t->rank]);
  team_wait(t);
  if (t->rank == 0) f->status = make_cells(f, t->size);
  team_wait(t);
  if (f->status != SD_OK) return;
  count_cells(f, begin, end, alone);
  team_wait(t);
  if (t->rank == 0) add_up_cells(f->g);
  team_wait(t);
  fill_cells(f, begin, end, alone);
  team_wait(t);
  if (!alone) sort_cells(f->g, t);
}

sd_status grid_build(const engine *e, double margin, grid *g) {
  const sd_state *s = e->state;
  double top[GRID_LEVELS] = {0};
  *g = (grid){.count = grid_levels_of(s->radius, s->n_disks, LEVEL_FACTOR, NULL, top)};
  for (size_t k = 0; k < g->count; k++) g->level[k].largest = top[k];
  grid_task f = {.e = e, .g = g, .margin = margin};
  pool_run(work_pool(e), grid_together, &f);
  free(f.cell);
  return f.status;
}

void grid_free(grid *g) {
  free(g->start);
  free(g->disks);
  *g = (grid){0};
}

/* --- search ----------------------------------------------------------------------------------- */

/* Range of cells from `first` to `last` along one direction. Along a periodic direction the indices
 * may lie outside [0, number of cells), but no cell occurs twice. */
typedef struct range {
  int64_t first, last;
} range;

static int64_t round_down(double v) {
  const int64_t k = (int64_t)v;
  return k - (v < (double)k);
}

static range range_of(const grid_level *l, int c, double low, double high) {
  const double from = (low - l->lower[c]) * l->per_cell[c],
               to = (high - l->lower[c]) * l->per_cell[c];
  const int64_t n = l->cells[c];
  if (!l->periodic[c])
    return (range){from >= (double)n ? n - 1
                   : from > 0.0      ? (int64_t)from
                                     : 0,
                   to >= (double)n ? n - 1
                   : to > 0.0      ? (int64_t)to
                                   : 0};
  if (!(to - from < (double)(n - 1) && fabs(from) < 1e15)) return (range){0, n - 1};
  return (range){round_down(from), round_down(to)};
}

static void add_run(const grid_level *l, int64_t row, int64_t first, int64_t last,
                    grid_runs *found) {
  const uint32_t *start = l->start + row * l->cells[0];
  const uint32_t from = start[first], to = start[last + 1];
  if (from == to) return;
  if (found->count == found->capacity) {
    found->capacity = 2 * found->capacity + 16;
    found->run = memory_grow(found->run, found->capacity, sizeof *found->run);
  }
  found->run[found->count++] = (struct grid_run){from, to};
}

static int64_t wrapped(int64_t k, int64_t n) {
  while (k < 0) k += n;
  return k < n ? k : k % n;
}

/* Adds the cells u.first to u.last of a row, which must lie inside the grid. If u crosses a
 * periodic edge of the box, the cells form two ranges. */
static void add_columns(const grid_level *l, int64_t row, range u, grid_runs *found) {
  const int64_t n = l->cells[0];
  assert(row >= 0 && row < l->cells[1] && u.first <= u.last);
  if (u.first >= 0 && u.last < n) {
    add_run(l, row, u.first, u.last, found);
    return;
  }
  assert(l->periodic[0] && u.last - u.first < n);
  const int64_t first = wrapped(u.first, n), last = wrapped(u.last, n);
  if (first <= last) {
    add_run(l, row, first, last, found);
    return;
  }
  add_run(l, row, first, n - 1, found);
  add_run(l, row, 0, last, found);
}

/* Adds the cells of row v between x = low and x = high. A row above or below a periodic box is the
 * image of a row inside, which in a sheared box is shifted along x by `offset` for each box height;
 * the shift is applied here and nowhere else. */
static void add_row(const grid_level *l, int64_t v, double low, double high, grid_runs *found) {
  assert(l->cells[1] > 0);
  const int64_t row = l->periodic[1] ? wrapped(v, l->cells[1]) : v, image = (v - row) / l->cells[1];
  const double shift = (double)image * l->offset;
  add_columns(l, row, range_of(l, 0, low - shift, high - shift), found);
}

/* Sets *low and *high to the lower and upper y of a row of cells. The first and last row of an open
 * grid extend to infinity. */
static void row_edges(const grid_level *l, int64_t v, double *low, double *high) {
  const double height = l->per_cell[1] > 0.0 ? 1.0 / l->per_cell[1] : 0.0;
  const bool open = !l->periodic[1];
  *low = open && v <= 0 ? -HUGE_VAL : l->lower[1] + height * (double)v;
  *high = open && v >= l->cells[1] - 1 ? HUGE_VAL : l->lower[1] + height * (double)(v + 1);
}

/* Enlarges the search radius `reach` a little, to allow for the rounding errors of cell edges near
 * coordinate `at`. */
static double slack(double reach, double at) { return reach * (1.0 + 1e-9) + 1e-14 * at; }

/* Adds the cells that a circle of radius r around point `at` overlaps, in the rows v.first to
 * v.last. */
static void add_circle(const grid_level *l, range v, const double at[2], double r,
                       grid_runs *found) {
  for (int64_t k = v.first; k <= v.last; k++) {
    double low, high;
    row_edges(l, k, &low, &high);
    const double dy = math_max(math_max(low - at[1], at[1] - high), 0.0);
    const double half = slack(sqrt(math_max(r * r - dy * dy, 0.0)), r);
    add_row(l, k, at[0] - half, at[0] + half, found);
  }
}

/* Up to this number of rows, each row is searched over the whole width of the circle, without
 * computing the chord. This is also done if all rows of a periodic box are searched, since a row
 * then stands for several of its images; in a sheared box all cells are searched. */
enum { FEW_ROWS = 4 };
void grid_around(const grid *g, const grid_level *l, const double at[2], double reach,
                 grid_runs *found) {
  const double r = slack(reach + 2.0 * g->overhang, fabs(at[0]) + fabs(at[1]));
  const range v = range_of(l, 1, at[1] - r, at[1] + r);
  const bool all = l->periodic[1] && v.last - v.first + 1 == l->cells[1];
  found->count = 0;
  if (v.last - v.first >= FEW_ROWS && !all) {
    add_circle(l, v, at, r, found);
    return;
  }
  if (v.first < 0 || v.last >= l->cells[1]) { /* some rows are periodic images */
    for (int64_t k = v.first; k <= v.last; k++) add_row(l, k, at[0] - r, at[0] + r, found);
    return;
  }
  const bool shifted = all && l->offset != 0.0;
  const range u = shifted ? (range){0, l->cells[0] - 1} : range_of(l, 0, at[0] - r, at[0] + r);
  for (int64_t k = v.first; k <= v.last; k++) add_columns(l, k, u, found);
}

/* Finds the part of the line between two heights, both widened by `reach`, and sets [*left, *right]
 * to its range of x, widened by `reach`. Returns false if no part of the line lies between them. */
static bool chord(const grid_line *line, double reach, double low, double high, double *left,
                  double *right) {
  double from = -line->back, to = line->length;
  if (line->ty != 0.0) {
    const double one = (low - reach - line->y) / line->ty,
                 two = (high + reach - line->y) / line->ty;
    from = math_max(from, math_min(one, two));
    to = math_min(to, math_max(one, two));
  } else if (line->y < low - reach || line->y > high + reach) {
    return false;
  }
  if (!(from <= to)) return false;
  const double one = line->x + (line->tx != 0.0 ? from * line->tx : 0.0);
  const double two = line->x + (line->tx != 0.0 ? to * line->tx : 0.0);
  *left = math_min(one, two) - reach;
  *right = math_max(one, two) + reach;
  return true;
}

void grid_along(const grid_level *l, const grid_line *line, double reach, grid_runs *found) {
  const double r = slack(reach, fabs(line->x) + fabs(line->y));
  const double back = line->ty != 0.0 ? -line->back * line->ty : 0.0;
  const double end = line->ty != 0.0 ? line->length * line->ty : 0.0;
  const double low = line->y + math_min(back, end) - r, high = line->y + math_max(back, end) + r;
  found->count = 0;
  /* treat the grid as open: disks outside the box are in its outermost cells */
  grid_level open = *l;
  open.periodic[0] = open.periodic[1] = false;
  const range v = range_of(&open, 1, low, high);
  for (int64_t k = v.first; k <= v.last; k++) {
    double bottom, top, left, right;
    row_edges(&open, k, &bottom, &top);
    if (chord(line, r, bottom, top, &left, &right)) add_row(&open, k, left, right, found);
  }
}
