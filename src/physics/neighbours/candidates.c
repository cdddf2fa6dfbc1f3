/* candidates.c: searches for the candidate pairs of the neighbour list; implements candidates_find
 * of neighbours.h. */
#include "physics/neighbours/neighbours.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "model/model.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"
#include "physics/system/clumps.h"
#include "physics/system/halo.h"
#include "physics/system/list.h"

/* --- criteria for a candidate ----------------------------------------------------------------- */

/* Returns true if the body in this slot can have contacts. Only free disks that were not added yet
 * (waiting) or were removed cannot. */
static bool in_play(const sd_state *s, size_t slot) {
  return slot >= s->n_free || body_in_play(s, slot);
}

/* Returns the largest gap between the surfaces of a candidate pair: Verlet margin plus the largest
 * gap at which a cohesive contact begins or ends. */
static double largest_margin(const engine *e) { return e->work.skin + e->work.margin; }

static inline bool near(const engine *e, uint32_t i, uint32_t j, double skin) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
  box_nearest(w, &dx, &dy);
  double reach = s->radius[i] + s->radius[j] + skin;
  return dx * dx + dy * dy < reach * reach;
}

/* Returns true if disk i is a candidate for the round wall b, that is, if their overlap is above
 * -largest_margin. In a drum (disk inside, R_b < 0) the overlap is R_i - |R_b| plus the distance of
 * the centres. */
static bool near_round_wall(const engine *e, uint32_t i, uint32_t b) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[b] - s->x[i], dy = s->y[b] - s->y[i], sum = s->radius[i] + s->radius[b];
  box_nearest(w, &dx, &dy);
  double r = math_hypot(dx, dy);
  if (s->radius[b] < 0.0) r = -r;
  return sum - r > -largest_margin(e);
}

static bool near_image(const engine *e, uint32_t i, const placed_segment *g) {
  nearest_point q = walls_nearest(g, e->state->x[i], e->state->y[i]);
  return math_hypot(q.dx, q.dy) < e->state->radius[i] + largest_margin(e);
}

/* Returns true if disk i is near any periodic image of a wall segment. All images are tested, since
 * the disk may come to touch another image than the one nearest now before the list is rebuilt. */
static bool near_segment(const engine *e, uint32_t i, const placed_segment *g) {
  if (!(g->image[0] || g->image[1])) return near_image(e, i, g);
  bool near = false;
  double n[2];
  walls_periods(e->work.length, g, e->state->x[i], e->state->y[i], n);
  for (int v = -g->image[1]; v <= g->image[1] && !near; v++)
    for (int u = -g->image[0]; u <= g->image[0] && !near; u++) {
      placed_segment image = *g;
      walls_shift(e->work.length, n[0] + u, n[1] + v, &image);
      near = near_image(e, i, &image);
    }
  return near;
}

/* --- sorting of slots ------------------------------------------------------------------------- */

static int ascending(const void *one, const void *two) {
  const uint32_t *p = one, *q = two;
  return *p < *q ? -1 : *p > *q;
}

/* Lists up to this length are sorted by insertion, which is fast since most lists are short and
 * nearly sorted; longer ones (a large disk may have thousands of candidates) by qsort. */
enum { FEW = 48 };
static void sort(numbers *list) {
  if (list->n > FEW) {
    qsort(list->at, list->n, sizeof *list->at, ascending);
    return;
  }
  for (size_t k = 1; k < list->n; k++) {
    uint32_t j = list->at[k];
    size_t at = k;
    for (; at > 0 && list->at[at - 1] > j; at--) list->at[at] = list->at[at - 1];
    list->at[at] = j;
  }
}

/* --- candidates of walls ---------------------------------------------------------------------- */

/* Candidate pairs of walls. Each round wall, or each wall segment, searches the cells for disks
 * near it. `of` has the walls (or segments) of disk i at indices start[i] to start[i + 1] - 1,
 * ascending; `start` and `of` are NULL if no pair was found. */
typedef struct wall_lists {
  numbers disk, wall; /* disk and wall (or segment) of each pair found, in the order of walls */
  uint32_t *start, *of;
} wall_lists;

static void wall_lists_free(wall_lists *l) {
  free(l->disk.at);
  free(l->wall.at);
  free(l->start);
  free(l->of);
}

static void add_wall(wall_lists *l, uint32_t disk, uint32_t wall) {
  numbers_add(&l->disk, disk);
  numbers_add(&l->wall, wall);
}

/* Returns true if memory ran out, so that some pairs are missing. */
static bool is_short(const wall_lists *l) { return l->disk.failed || l->wall.failed; }

/* Sorts the pairs by disk (counting sort); the walls of each disk stay in ascending order. */
static sd_status by_disks(wall_lists *l, size_t n_free) {
  if (is_short(l)) return SD_ERROR_IO;
  if (l->disk.n == 0) return SD_OK;
  if (!memory_rows(2, (memory_column[]){{&l->start, n_free + 2, sizeof *l->start},
                                        {&l->of, l->disk.n, sizeof *l->of}}))
    return SD_ERROR_IO;
  for (size_t k = 0; k < l->disk.n; k++) l->start[l->disk.at[k] + 2]++;
  for (size_t i = 2; i < n_free + 2; i++) l->start[i] += l->start[i - 1];
  for (size_t k = 0; k < l->disk.n; k++) l->of[l->start[l->disk.at[k] + 1]++] = l->wall.at[k];
  return SD_OK;
}

static void find_round_wall(const engine *e, const grid *g, uint32_t b, grid_runs *runs,
                            wall_lists *l) {
  const sd_state *s = e->state;
  const double at[2] = {s->x[b], s->y[b]};
  for (uint32_t i = 0; i < s->n_free && s->radius[b] < 0.0; i++)
    if (in_play(s, i) && near_round_wall(e, i, b)) add_wall(l, i, b);
  for (size_t k = 0; k < g->count && s->radius[b] > 0.0; k++) {
    const grid_level *level = &g->level[k];
    grid_around(g, level, at, s->radius[b] + level->largest + largest_margin(e), runs);
    for (size_t r = 0; r < runs->count; r++)
      for (uint32_t n = runs->run[r].from; n < runs->run[r].to; n++) {
        const uint32_t i = level->disks[n];
        if (i < s->n_free && near_round_wall(e, i, b)) add_wall(l, i, b);
      }
  }
}

static sd_status find_round_walls(const engine *e, const grid *g, wall_lists *l) {
  const sd_state *s = e->state;
  grid_runs runs = {0};
  for (uint32_t b = (uint32_t)s->n_disks; b < s->n_bodies && !is_short(l); b++)
    if (s->radius[b] != 0.0) find_round_wall(e, g, b, &runs, l);
  free(runs.run);
  return by_disks(l, s->n_free);
}

/* Returns a line that runs along the segment, and sets *beside to how far the segment extends to
 * either side of this line: 0 for a straight one. For an arc the line is the horizontal middle line
 * of the arc's bounding box. */
static grid_line line_along(const placed_segment *p, double *beside) {
  double lower[2], upper[2];
  *beside = 0.0;
  if (p->piece == SD_PIECE_STRAIGHT)
    return (grid_line){p->x, p->y, p->tx, p->ty, -p->backwards, p->length};
  walls_bounds(p, lower, upper);
  *beside = 0.5 * (upper[1] - lower[1]);
  return (grid_line){lower[0], 0.5 * (lower[1] + upper[1]), 1.0, 0.0, 0.0, upper[0] - lower[0]};
}

/* Adds pairs of segment m with the disks near `image`, one of its periodic images; a disk that is
 * near several images is added several times. */
static void find_image(const engine *e, const grid *g, uint32_t m, const placed_segment *image,
                       grid_runs *runs, wall_lists *l) {
  double beside;
  const grid_line line = line_along(image, &beside);
  for (size_t k = 0; k < g->count; k++) {
    const grid_level *level = &g->level[k];
    grid_along(level, &line, level->largest + largest_margin(e) + beside, runs);
    for (size_t r = 0; r < runs->count; r++)
      for (uint32_t n = runs->run[r].from; n < runs->run[r].to; n++) {
        const uint32_t i = level->disks[n];
        if (i < e->state->n_free && near_segment(e, i, &e->work.segments[m])) add_wall(l, i, m);
      }
  }
}

/* Finds which periodic images of a segment can be near a disk: those displaced by *first to *last
 * box lengths along direction c. */
static void find_range(const engine *e, const grid *g, const placed_segment *p, int c,
                       double *first, double *last) {
  const work *w = &e->work;
  double lower[2], upper[2];
  *first = *last = 0.0;
  if (!p->image[c] || g->count == 0) return;
  walls_bounds(p, lower, upper);
  if (!isfinite(lower[c]))
    lower[c] = upper[c] = c == 0 ? p->x : p->y; /* an infinite line perpendicular to direction c */
  const double reach = g->level[0].largest + largest_margin(e) + g->overhang;
  *first = ceil((w->lower[c] - reach - upper[c]) / w->length[c]);
  *last = floor((w->upper[c] + reach - lower[c]) / w->length[c]);
}

static sd_status find_segments(const engine *e, const grid *g, wall_lists *l) {
  grid_runs runs = {0};
  for (uint32_t m = 0; m < e->model->n_segments && !is_short(l); m++) {
    const placed_segment *p = &e->work.segments[m];
    double first[2], last[2];
    for (int c = 0; c < 2; c++) find_range(e, g, p, c, &first[c], &last[c]);
    for (double v = first[1]; v <= last[1] && !is_short(l); v++)
      for (double u = first[0]; u <= last[0] && !is_short(l); u++) {
        placed_segment image = *p;
        walls_shift(e->work.length, u, v, &image);
        find_image(e, g, m, &image, &runs, l);
      }
  }
  free(runs.run);
  return by_disks(l, e->state->n_free);
}

/* --- candidates of disks ---------------------------------------------------------------------- */

/* Appends, unsorted, the candidate partners of free disk i among the disks in higher slots. */
static void find_partners(const engine *e, const grid *g, uint32_t i, grid_runs *runs,
                          numbers *found) {
  const sd_state *s = e->state;
  const double at[2] = {s->x[i], s->y[i]}, margin = largest_margin(e);
  for (size_t k = 0; k < g->count; k++) {
    const grid_level *l = &g->level[k];
    if (l->last <= i) continue;
    grid_around(g, l, at, s->radius[i] + l->largest + margin, runs);
    for (size_t r = 0; r < runs->count; r++)
      for (uint32_t n = runs->run[r].from; n < runs->run[r].to; n++) {
        const uint32_t j = l->disks[n];
        if (j > i && near(e, i, j, largest_margin(e)) && !clumps_same(e, i, j))
          numbers_add(found, j);
      }
  }
}

/* Pairs of the old list whose first disk is i, the disk that is searched for now. A closed contact
 * stays a candidate, even if one step moved its bodies far apart, until the step opens it and books
 * the energy lost. The old list is sorted by the first disk, so the pairs of disk i follow those of
 * disk i - 1. */
typedef struct closed_before {
  size_t from, to; /* these pairs have indices from, ..., to - 1 in the old list */
} closed_before;

static void next_disk(const pairs *old, size_t end, uint32_t i, closed_before *c) {
  assert(c->to <= end && (c->to == end || old->a[c->to] >= (int32_t)i));
  c->from = c->to;
  while (c->to < end && old->a[c->to] == (int32_t)i) c->to++;
}

static bool is_near(const engine *e, uint32_t i, uint32_t j) {
  return j < e->state->n_disks ? near(e, i, j, largest_margin(e)) : near_round_wall(e, i, j);
}

static void add_closed(const engine *e, const closed_before *c, uint32_t i, numbers *found) {
  const pairs *old = &e->work.pairs;
  for (size_t k = c->from; k < c->to; k++) {
    const uint32_t j = (uint32_t)old->b[k];
    if (pairs_closed(old, k) && in_play(e->state, j) && !is_near(e, i, j)) numbers_add(found, j);
  }
}

static void add_closed_segments(const engine *e, const closed_before *c, uint32_t i,
                                numbers *found) {
  const pairs *old = &e->work.pairs;
  for (size_t k = c->from; k < c->to; k++)
    if (pairs_closed(old, k) && !near_segment(e, i, &e->work.segments[old->part[k]]))
      numbers_add(found, (size_t)old->part[k]);
}

static void add_walls(const wall_lists *l, uint32_t i, numbers *found) {
  for (uint32_t k = l->start ? l->start[i] : 0; l->start && k < l->start[i + 1]; k++)
    if (k == l->start[i] || l->of[k] != l->of[k - 1])
      numbers_add(found, l->of[k]); /* add a wall once, even if several images were found */
}

/* --- search by all threads -------------------------------------------------------------------- */

/* Candidate pairs found by one thread. a: slot of the disk; b: slot of its partner, or index of the
 * wall segment. pairs[0] has the pairs without ghosts, pairs[1] those with a ghost. */
typedef struct share {
  _Alignas(64) struct {
    numbers a, b;
    size_t at; /* index in the joint list at which the pairs of this thread begin */
  } pairs[2];
  bool failed; /* true: memory ran out, so that some pairs are missing */
} share;

typedef struct search {
  const engine *e;
  const grid *g;
  /* true: searches for pairs of disks with wall segments; false: for pairs of disks with disks or
   * round walls */
  bool pieces;
  wall_lists walls;
  pairs *to;
  sd_status status;
  share share[WORK_MAX_THREADS];
} search;

static void find_round(const search *q, uint32_t i, const closed_before *before, grid_runs *runs,
                       numbers *found) {
  find_partners(q->e, q->g, i, runs, found);
  add_walls(&q->walls, i, found);
  add_closed(q->e, before, i, found);
}

static void find_pieces(const search *q, uint32_t i, const closed_before *before, numbers *found) {
  add_walls(&q->walls, i, found);
  add_closed_segments(q->e, before, i, found);
}

static void find_share(const search *q, size_t begin, size_t end, share *mine) {
  const engine *e = q->e;
  const pairs *old = &e->work.pairs;
  const size_t old_end = q->pieces ? old->count : old->n_round;
  closed_before before = {.to =
                              pairs_from(old, q->pieces ? old->first_segment : 0, old_end, begin)};
  numbers found = {0};
  grid_runs runs = {0};
  for (size_t k = begin; k < end && !mine->failed; k++) {
    const uint32_t i = (uint32_t)k;
    found.n = 0;
    next_disk(old, old_end, i, &before);
    if (!in_play(e->state, i)) continue;
    if (q->pieces)
      find_pieces(q, i, &before, &found);
    else
      find_round(q, i, &before, &runs, &found);
    sort(&found);
    mine->failed = found.failed;
    for (size_t n = 0; n < found.n && !mine->failed; n++) {
      const bool ghost = !q->pieces && halo_is_ghost(e, found.at[n]);
      numbers *a = &mine->pairs[ghost].a, *b = &mine->pairs[ghost].b;
      numbers_add(a, i);
      numbers_add(b, found.at[n]);
      mine->failed = a->failed || b->failed;
    }
  }
  free(found.at);
  free(runs.run);
}

/* Finds at which index of the list the pairs of each of n threads begin. Threads have ascending
 * ranges of slots, so the list is sorted by slots. ghosts: 1 for the pairs with ghosts, else 0. */
static void place_list(search *q, int n, int ghosts) {
  size_t count = q->to->count;
  for (int k = 0; k < n; k++) {
    q->share[k].pairs[ghosts].at = count;
    count += q->share[k].pairs[ghosts].b.n;
    if (q->share[k].failed) q->status = SD_ERROR_IO;
  }
  if (q->status == SD_OK && count > q->to->capacity)
    q->status = pairs_reserve(q->to, count + count / 4);
  if (q->status == SD_OK) q->to->count = count;
}

static void place_shares(search *q, int n) {
  pairs *p = q->to;
  place_list(q, n, false);
  if (q->pieces || q->status != SD_OK) return;
  p->n_round = p->count;
  q->status = pairs_fill_block(p);
  p->first_ghost = p->count;
  if (q->status == SD_OK) place_list(q, n, true);
  p->end_ghost = p->count;
  if (q->status == SD_OK) q->status = pairs_fill_block(p);
  p->first_segment = p->count;
}

static void copy_share(const search *q, const share *mine) {
  pairs *p = q->to;
  for (int list = 0; list < 2; list++)
    for (size_t n = 0; n < mine->pairs[list].b.n; n++) {
      const size_t k = mine->pairs[list].at + n;
      const uint32_t found = mine->pairs[list].b.at[n];
      p->a[k] = (int32_t)mine->pairs[list].a.at[n];
      p->b[k] = (int32_t)(q->pieces ? slot_of(&q->e->work.slots, q->e->model->segments[found].body)
                                    : found);
      p->part[k] = q->pieces ? (int32_t)found : 0;
    }
}

static void search_together(const team *t, void *with) {
  search *q = with;
  size_t begin, end;
  team_share(t, q->e->state->n_free, &begin, &end);
  find_share(q, begin, end, &q->share[t->rank]);
  team_wait(t);
  if (t->rank == 0) place_shares(q, t->size);
  team_wait(t);
  if (q->status == SD_OK) copy_share(q, &q->share[t->rank]);
}

static sd_status push(search *q) {
  q->status =
      q->pieces ? find_segments(q->e, q->g, &q->walls) : find_round_walls(q->e, q->g, &q->walls);
  if (q->status == SD_OK) pool_run(work_pool(q->e), search_together, q);
  for (size_t k = 0; k < WORK_MAX_THREADS; k++)
    for (int list = 0; list < 2; list++) {
      free(q->share[k].pairs[list].a.at);
      free(q->share[k].pairs[list].b.at);
    }
  wall_lists_free(&q->walls);
  return q->status;
}

sd_status candidates_find(const engine *e, const grid *g, pairs *to) {
  to->count = 0;
  sd_status status = push(&(search){.e = e, .g = g, .to = to});
  if (status == SD_OK && e->model->n_segments > 0)
    status = push(&(search){.e = e, .g = g, .to = to, .pieces = true});
  return status;
}
