/* neighbours.c: cell grid, candidate pairs, incidence; see neighbours.h. */
#include "model/advice.h"
#include "physics/system/bodies.h"
#include "physics/neighbours/neighbours.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "physics/system/kernels.h"
#include "physics/contact/losses.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/rows.h"
#include "physics/neighbours/validity.h"
#include "physics/contact/walls.h"

void neighbours_free(engine *e) {
  pairs_free(&e->work.pairs);
  pairs_free(&e->work.spare);
  pairs_list_free(e);
}

/* --- cells ------------------------------------------------------------------------------------------- */

typedef struct grid {
  double lower[2], per_cell[2];
  int64_t cells[2];
  uint32_t *start, *disks; /* cell c holds disks[start[c] .. start[c + 1]) */
} grid;

static int64_t cell_of(const grid *g, int c, double at) {
  double k = fmin((at - g->lower[c]) * g->per_cell[c], (double)(g->cells[c] - 1));
  return k > 0.0 ? (int64_t)k : 0;
}

static size_t cell_index(const grid *g, double x, double y) {
  return (size_t)(cell_of(g, 1, y) * g->cells[0] + cell_of(g, 0, x));
}

/* Does the body in this slot touch anything? */
static bool in_play(const sd_state *s, size_t slot) { return slot >= s->n_free || body_in_play(s, slot); }

/* Where the disks are; those that got lost far away would make the cells of all others large. Beyond the grid
 * the nearest cell counts. */
static void grid_extent(const sd_state *s, const double *at, double *low, double *high) {
  bool any = false;
  for (size_t i = 0; i < s->n_disks; i++) {
    if (i < s->n_free && s->activity[i] != SD_IN_PLAY) continue;
    *low = any ? fmin(*low, at[i]) : at[i];
    *high = any ? fmax(*high, at[i]) : at[i];
    any = true;
  }
  if (!any) *low = *high = 0.0;
}

/* Cells no smaller than the reach of a pair; fewer, larger ones where disks are sparse. */
static void grid_size(const engine *e, double reach, grid *g) {
  const sd_state *s = e->state;
  for (int c = 0; c < 2; c++) {
    const double *at = c ? s->y : s->x;
    double low = e->work.lower[c], high = e->work.upper[c];
    if (!e->work.periodic[c]) grid_extent(s, at, &low, &high);
    double most = 2.0 * sqrt((double)s->n_disks) + 3.0, span = high - low;
    double cells = fmin(floor(span / reach), 8.0 * most);
    if (cells < 1.0) cells = 1.0;
    /* with fewer than three, a periodic neighbour would be met twice: one cell holds all */
    if (e->work.periodic[c] && cells < 3.0) cells = 1.0;
    /* a pair within reach stands in cells that are neighbours */
    assert(cells == 1.0 || (cells > 1.0 && span / cells >= reach));
    g->lower[c] = low;
    g->cells[c] = (int64_t)cells;
    g->per_cell[c] = span > 0.0 ? cells / span : 0.0;
  }
}

static sd_status grid_fill(const engine *e, grid *g) {
  const sd_state *s = e->state;
  assert(g->cells[0] >= 1 && g->cells[1] >= 1);
  size_t cells = (size_t)(g->cells[0] * g->cells[1]);
  g->start = calloc(cells + 2, sizeof *g->start);
  g->disks = malloc((s->n_disks + 1) * sizeof *g->disks);
  if (!g->start || !g->disks) return SD_ERROR_IO;
  for (size_t i = 0; i < s->n_disks; i++)
    if (in_play(s, i)) g->start[cell_index(g, s->x[i], s->y[i]) + 2]++;
  for (size_t c = 2; c < cells + 2; c++) g->start[c] += g->start[c - 1];
  for (size_t i = 0; i < s->n_disks; i++)
    if (in_play(s, i)) g->disks[g->start[cell_index(g, s->x[i], s->y[i]) + 1]++] = (uint32_t)i;
  assert(g->start[0] == 0 && g->start[cells] == g->start[cells + 1] && g->start[cells] <= s->n_disks);
  return SD_OK;
}

/* --- candidates -------------------------------------------------------------------------------------- */

static bool near(const engine *e, uint32_t i, uint32_t j, double skin) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
  if (w->periodic[0]) dx -= w->length[0] * nearbyint(dx * w->inverse_length[0]);
  if (w->periodic[1]) dy -= w->length[1] * nearbyint(dy * w->inverse_length[1]);
  double reach = s->radius[i] + s->radius[j] + skin;
  return dx * dx + dy * dy < reach * reach;
}

typedef struct partners {
  uint32_t *slot;
  size_t n, capacity;
} partners;

static sd_status partners_add(partners *p, uint32_t j) {
  if (p->n == p->capacity) {
    size_t capacity = 2 * (p->capacity + 8);
    uint32_t *more = realloc(p->slot, capacity * sizeof *more);
    if (!more) return SD_ERROR_IO;
    p->slot = more;
    p->capacity = capacity;
  }
  p->slot[p->n++] = j;
  return SD_OK;
}

/* Adds the partners of free disk i in higher slots, unordered. */
static sd_status find_partners(const engine *e, const grid *g, uint32_t i, partners *found) {
  const sd_state *s = e->state;
  int64_t cx = cell_of(g, 0, s->x[i]), cy = cell_of(g, 1, s->y[i]);
  for (int64_t v = cy - 1; v <= cy + 1; v++) {
    int64_t row = v;
    if (e->work.periodic[1] && g->cells[1] >= 3) row = (v + g->cells[1]) % g->cells[1];
    if (row < 0 || row >= g->cells[1]) continue;
    for (int64_t u = cx - 1; u <= cx + 1; u++) {
      int64_t column = u;
      if (e->work.periodic[0] && g->cells[0] >= 3) column = (u + g->cells[0]) % g->cells[0];
      if (column < 0 || column >= g->cells[0]) continue;
      size_t c = (size_t)(row * g->cells[0] + column);
      for (uint32_t k = g->start[c]; k < g->start[c + 1]; k++) {
        uint32_t j = g->disks[k];
        if (j > i && near(e, i, j, e->work.skin) && partners_add(found, j) != SD_OK) return SD_ERROR_IO;
      }
    }
  }
  return SD_OK;
}

/* Few and nearly in order. */
static void sort(uint32_t *list, size_t n) {
  for (size_t k = 1; k < n; k++) {
    uint32_t j = list[k];
    size_t at = k;
    for (; at > 0 && list[at - 1] > j; at--) list[at] = list[at - 1];
    list[at] = j;
  }
}

/* Round walls: a disk is near when its overlap is above -skin; inside a drum the signed distance counts. */
static bool near_round_wall(const engine *e, uint32_t i, uint32_t b) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[b] - s->x[i], dy = s->y[b] - s->y[i], sum = s->radius[i] + s->radius[b];
  if (w->periodic[0]) dx -= w->length[0] * nearbyint(dx * w->inverse_length[0]);
  if (w->periodic[1]) dy -= w->length[1] * nearbyint(dy * w->inverse_length[1]);
  double r = hypot(dx, dy);
  if (s->radius[b] < 0.0) r = -r;
  return sum - r > -w->skin;
}

static bool near_piece(const engine *e, uint32_t i, const placed_segment *g) {
  nearest_point q = walls_nearest(g, e->state->x[i], e->state->y[i]);
  return hypot(q.dx, q.dy) < e->state->radius[i] + e->work.skin;
}

/* Closed contacts stay candidates until a commit opens them, however far one step took their bodies: what
 * they drop is booked there, whatever the skin. The old list is ordered by the first disk, so that its pairs
 * of disk i follow those of i - 1. */
typedef struct closed_before {
  size_t from, to; /* pairs of the present disk */
} closed_before;

static void next_disk(const pairs *old, size_t end, uint32_t i, closed_before *c) {
  assert(c->to <= end && (c->to == end || old->a[c->to] >= (int32_t)i));
  c->from = c->to;
  while (c->to < end && old->a[c->to] == (int32_t)i) c->to++;
}

static bool was_closed(const pairs *old, const closed_before *c, uint32_t b, size_t part) {
  for (size_t k = c->from; k < c->to; k++)
    if (old->b[k] == (int32_t)b && old->part[k] == (int32_t)part) return pairs_closed(old, k);
  return false;
}

static sd_status add_closed(const engine *e, const closed_before *c, uint32_t i, partners *found) {
  const pairs *old = &e->work.pairs;
  for (size_t k = c->from; k < c->to; k++) {
    uint32_t j = (uint32_t)old->b[k];
    if (!pairs_closed(old, k) || j >= e->state->n_disks || !in_play(e->state, j) ||
        near(e, i, j, e->work.skin))
      continue;
    if (partners_add(found, j) != SD_OK) return SD_ERROR_IO;
  }
  return SD_OK;
}

static sd_status push_round(const engine *e, const grid *g, pairs *p) {
  const sd_state *s = e->state;
  const pairs *old = &e->work.pairs;
  partners found = {0};
  closed_before before = {0};
  sd_status status = SD_OK;
  for (uint32_t i = 0; i < s->n_free && status == SD_OK; i++) {
    found.n = 0;
    next_disk(old, old->n_round, i, &before);
    if (!in_play(s, i)) continue;
    status = find_partners(e, g, i, &found);
    if (status == SD_OK) status = add_closed(e, &before, i, &found);
    sort(found.slot, found.n);
    for (size_t k = 0; k < found.n && status == SD_OK; k++)
      status = pairs_push(p, (int32_t)i, (int32_t)found.slot[k], 0);
    for (uint32_t b = (uint32_t)s->n_disks; b < s->n_bodies && status == SD_OK; b++)
      if (s->radius[b] != 0.0 && (near_round_wall(e, i, b) || was_closed(old, &before, b, 0)))
        status = pairs_push(p, (int32_t)i, (int32_t)b, 0);
  }
  free(found.slot);
  return status;
}

static sd_status push_pieces(const engine *e, pairs *p) {
  const pairs *old = &e->work.pairs;
  closed_before before = {.to = old->first_segment};
  sd_status status = SD_OK;
  if (e->model->n_segments == 0) return SD_OK;
  for (uint32_t i = 0; i < e->state->n_free; i++) {
    next_disk(old, old->count, i, &before);
    if (!in_play(e->state, i)) continue;
    for (size_t k = 0; k < e->model->n_segments && status == SD_OK; k++) {
      uint32_t b = e->work.slot[e->model->segments[k].body];
      assert(b >= e->state->n_disks);
      if (near_piece(e, i, &e->work.segments[k]) || was_closed(old, &before, b, k))
        status = pairs_push(p, (int32_t)i, (int32_t)b, (int32_t)k);
    }
  }
  return status;
}

static void find_watched(engine *e) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < 2 * e->model->n_slides; k++) {
    const sd_slide_watch *watch = &e->model->slides[k / 2];
    int32_t d = (int32_t)e->work.slot[watch->disk], q = (int32_t)e->work.slot[watch->partner[k % 2]];
    e->work.watched[k] = -1;
    const incidence *n = &e->work.incidence;
    for (size_t at = n->start[d]; at < n->start[d + 1]; at++) {
      size_t pair = n->entry[at] / 2;
      if (p->a[pair] + p->b[pair] == d + q && (p->a[pair] == d || p->b[pair] == d)) {
        /* of several pieces of one wall the first: they follow one another, and which is closed changes */
        if (e->work.watched[k] < 0 || (int64_t)pair < e->work.watched[k]) e->work.watched[k] = (int64_t)pair;
      }
    }
  }
}

/* --- build ------------------------------------------------------------------------------------------- */

sd_status neighbours_check_finite(const engine *e, int64_t step, sd_messages *messages) {
  const sd_state *s = e->state;
  for (size_t i = 0; i < s->n_bodies; i++) {
    if (isfinite(s->x[i]) && isfinite(s->y[i]) && isfinite(s->theta[i])) continue;
    char name[96], hint[200];
    return sd_fail(messages, SD_ERROR_NUMERIC, "step %lld: %s is at (%g, %g), angle %g: not finite; %s",
                   (long long)step, sd_model_body_name(e->model, s->id[i], name, sizeof name), s->x[i],
                   s->y[i], s->theta[i], advice_of_failure(e->model, "is dt too large?", hint, sizeof hint));
  }
  return SD_OK;
}

static void note_poses(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  memcpy(w->x0, s->x, s->n_bodies * sizeof(double));
  memcpy(w->y0, s->y, s->n_bodies * sizeof(double));
  for (size_t b = s->n_disks; b < s->n_bodies; b++) {
    w->theta0[b] = s->theta[b] + s->turn[b];
    double reach = 0.0;
    for (size_t i = 0; i < s->n_free; i++)
      if (in_play(s, i))
        reach = fmax(reach, hypot(s->x[i] - s->x[b], s->y[i] - s->y[b]) + s->radius[i] + w->skin);
    w->reach[b - s->n_disks] = reach;
  }
}

static double largest_radius(const sd_state *s) {
  double largest = 0.0;
  for (size_t i = 0; i < s->n_disks; i++) largest = fmax(largest, s->radius[i]);
  return largest;
}

/* How far a body may move until the lists are stale. Two bodies may each take 0.45 of the skin; the rest is for
 * the way from trial to corrected positions. Lengths that shrink bring together what moves not at all. */
static double limit_of(const engine *e) {
  const work *w = &e->work;
  double shrunk = fmax(1.0 - e->state->box_scale / w->list_scale, 0.0);
  return 0.45 * w->skin - 0.5 * shrunk * (2.0 * largest_radius(e->state) + w->skin);
}

sd_status neighbours_rescale(engine *e, double f, sd_messages *messages) {
  work *w = &e->work;
  assert(f > 0.0);
  double corner[2] = {box_corner(e->model, SD_X), box_corner(e->model, SD_Y)};
  for (size_t i = 0; i < e->state->n_bodies; i++) {
    w->x0[i] = corner[SD_X] + f * (w->x0[i] - corner[SD_X]);
    w->y0[i] = corner[SD_Y] + f * (w->y0[i] - corner[SD_Y]);
  }
  for (size_t b = 0; b < e->model->n_walls; b++) w->reach[b] *= fmax(f, 1.0);
  double limit = limit_of(e);
  bool stale = limit < 0.225 * w->skin;
  w->moved_limit2 = limit * limit;
  for (uint32_t i = 0; i < e->state->n_bodies && !stale; i++) stale = neighbours_moved(e, i);
  return stale ? neighbours_build(e, messages) : SD_OK;
}

/* A wider skin costs candidates in every step, a narrower one lists: making one costs per disk as much as TUNE_BALANCE
 * steps' share of the candidates that a skin of one radius adds. Disks move by k per step, so that lists last skin/k steps
 * and the sum of both is least where skin times steps is that, in mean radii. */
static const double TUNE_BALANCE = 27.0, TUNE_LEAST = 0.03, TUNE_MOST = 0.4, TUNE_STEP = 1.4;

void neighbours_tune(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  if (e->model->skin > 0.0) return;
  double steps = fmax((double)(s->step - w->built_at), 1.0), skin = w->skin / w->mean_radius;
  double factor = sqrt(TUNE_BALANCE / (steps * skin));
  skin *= fmin(fmax(factor, 1.0 / TUNE_STEP), TUNE_STEP);
  w->skin = w->mean_radius * fmin(fmax(skin, TUNE_LEAST), TUNE_MOST);
  assert(w->skin > 0.0);
}

sd_status neighbours_build(engine *e, sd_messages *messages) {
  const sd_state *s = e->state;
  work *w = &e->work;
  assert(w->skin > 0.0 && w->n_threads >= 1 && w->n_threads <= WORK_MAX_THREADS);
  if (neighbours_check_finite(e, s->step + 1, messages) != SD_OK) return SD_ERROR_NUMERIC;
  grid g = {0};
  grid_size(e, 2.0 * largest_radius(s) + w->skin, &g);
  pairs *next = &w->spare;
  next->count = 0;
  sd_status status = grid_fill(e, &g);
  if (status == SD_OK) status = push_round(e, &g, next);
  if (status == SD_OK) status = pairs_end_round(next);
  if (status == SD_OK) status = push_pieces(e, next);
  if (status == SD_OK) status = pairs_finish(e, &w->pairs, next);
  free(g.start);
  free(g.disks);
  if (status == SD_OK) {
    for (size_t k = 0; k < w->pairs.count; k++) losses_end(e, &w->pairs, k);
    pairs swap = w->pairs;
    w->pairs = *next;
    *next = swap;
    status = pairs_list(e);
  }
  if (status != SD_OK) return sd_fail(messages, SD_ERROR_IO, "out of memory for the list of neighbours");
  find_watched(e);
  note_poses(e);
  w->kernels->pack(e, s->n_free, s->n_bodies);
  assert(w->pairs.first_segment % PAIR_BLOCK == 0 && w->pairs.count <= w->pairs.capacity);
  w->list_scale = s->box_scale;
  w->built_at = s->step;
  w->moved_limit2 = limit_of(e) * limit_of(e);
  for (int t = 0; t < w->n_threads; t++) w->threads[t].stale = false;
  w->builds++;
  if (VALIDITY_CHECKED) validity_check_lists(e);
  return SD_OK;
}
