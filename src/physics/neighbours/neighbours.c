/* neighbours.c: decides when the lists of candidate pairs are stale, builds them, and adapts the
 * Verlet margin; implements neighbours.h. */
#include "model/advice.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "model/model.h"
#include "physics/contact/energy.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/neighbours/grid.h"
#include "physics/neighbours/validity.h"
#include "physics/system/kernels.h"

void neighbours_free(engine *e) {
  pairs_free(&e->work.pairs);
  pairs_free(&e->work.spare);
  pairs_list_free(e);
}

/* Returns true if the body in this slot can have contacts. Only free disks that were not added yet
 * (waiting) or were removed cannot. */
static bool in_play(const sd_state *s, size_t slot) {
  return slot >= s->n_free || body_in_play(s, slot);
}

/* Returns the largest gap between the surfaces of a candidate pair: Verlet margin plus the largest
 * gap at which a cohesive contact begins or ends. */
static double largest_margin(const engine *e) { return e->work.skin + e->work.margin; }

/* Lists the wall segments that occur in candidate pairs, ascending. Only these segments are moved
 * in every step. */
static void find_pieces(engine *e) {
  work *w = &e->work;
  const pairs *p = &w->pairs;
  memset(w->pieces, 0, e->model->n_segments * sizeof *w->pieces);
  for (size_t k = p->first_segment; k < p->count; k++) w->pieces[p->part[k]] = 1;
  w->n_pieces = 0;
  for (uint32_t k = 0; k < e->model->n_segments; k++)
    if (w->pieces[k]) w->pieces[w->n_pieces++] = k;
}

static void find_watched(engine *e) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < 2 * e->model->n_slides; k++) {
    const sd_slide_watch *watch = &e->model->slides[k / 2];
    int32_t d = (int32_t)slot_of(&e->work.slots, watch->disk),
            q = (int32_t)slot_of(&e->work.slots, watch->partner[k % 2]);
    e->work.watched[k] = -1;
    const incidence *n = &e->work.incidence;
    for (size_t at = n->start[d]; at < n->start[d + 1]; at++) {
      size_t pair = n->entry[at] / 2;
      if (p->a[pair] + p->b[pair] == d + q && (p->a[pair] == d || p->b[pair] == d)) {
        /* If a wall has several segments near the disk, take the pair with the first: their pairs
         * are consecutive in the list, and which of them is closed changes. */
        if (e->work.watched[k] < 0 || (int64_t)pair < e->work.watched[k])
          e->work.watched[k] = (int64_t)pair;
      }
    }
  }
}

/* --- building the lists ----------------------------------------------------------------------- */

static sd_status tell_not_finite(const engine *e, int64_t step, size_t slot,
                                 const double pose[SD_COORDINATES], sd_messages *messages) {
  char name[96], hint[200];
  return sd_fail(messages, SD_ERROR_NUMERIC,
                 "step %lld: %s is at (%g, %g), angle %g: not finite; %s", (long long)step,
                 sd_model_body_name(e->model, e->state->id[slot], name, sizeof name), pose[SD_X],
                 pose[SD_Y], pose[SD_THETA],
                 advice_of_failure(e->model, "is dt too large?", hint, sizeof hint));
}

static bool all_finite(const double pose[SD_COORDINATES]) {
  return isfinite(pose[SD_X]) && isfinite(pose[SD_Y]) && isfinite(pose[SD_THETA]);
}

sd_status neighbours_check_finite(const engine *e, int64_t step, sd_messages *messages) {
  const sd_state *s = e->state;
  for (size_t i = 0; i < s->n_bodies; i++) {
    const double pose[SD_COORDINATES] = {s->x[i], s->y[i], s->theta[i]};
    if (!all_finite(pose)) return tell_not_finite(e, step, i, pose, messages);
  }
  return SD_OK;
}

sd_status neighbours_check_next(const engine *e, sd_messages *messages) {
  const sd_state *s = e->state;
  const double dt = e->work.dt;
  for (size_t i = 0; i < s->n_free; i++) {
    const double pose[SD_COORDINATES] = {s->x[i] + (s->vx[i] * dt + s->x2[i]),
                                         s->y[i] + (s->vy[i] * dt + s->y2[i]),
                                         s->theta[i] + (s->omega[i] * dt + s->theta2[i])};
    if (!all_finite(pose)) return tell_not_finite(e, s->step + 1, i, pose, messages);
  }
  return SD_OK;
}

/* Returns an upper bound of the distance between a wall's pivot and any point of a disk. low, high:
 * bounding box of the disks. */
static double farthest_disk(const engine *e, const double pivot[2], const double low[2],
                            const double high[2]) {
  const double dx = math_max(high[0] - pivot[0], pivot[0] - low[0]),
               dy = math_max(high[1] - pivot[1], pivot[1] - low[1]);
  return math_hypot(dx, dy) + largest_margin(e);
}

/* Finds for each wall the largest distance from its pivot to a point of the wall that may touch a
 * disk. This distance times the angle by which the wall turns is an upper bound of the displacement
 * of its surface. Points farther from the pivot than all disks do not count; for a round wall the
 * distance is 0, since turning does not displace its surface. */
static void note_reaches(const engine *e, const double low[2], const double high[2]) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  memset(w->reach, 0, (s->n_bodies - s->n_disks) * sizeof *w->reach);
  if (!(low[0] <= high[0])) return;
  for (size_t k = 0; k < e->model->n_segments; k++) {
    const placed_segment *g = &w->segments[k];
    const uint32_t b = slot_of(&w->slots, e->model->segments[k].body);
    const double x = g->x - s->x[b], y = g->y - s->y[b];
    const double end =
        isfinite(g->length) ? math_hypot(x + g->length * g->tx, y + g->length * g->ty) : HUGE_VAL;
    double *reach = &w->reach[b - s->n_disks];
    *reach = math_max(*reach, math_max(math_hypot(x, y) + g->radius, end));
  }
  for (size_t b = s->n_disks; b < s->n_bodies; b++) {
    const double pivot[2] = {s->x[b], s->y[b]};
    double *reach = &w->reach[b - s->n_disks];
    /* in a periodic box a disk may touch an image of the wall, far from the pivot */
    const bool images = w->periodic[0] || w->periodic[1];
    if (!images || !isfinite(*reach)) *reach = math_min(*reach, farthest_disk(e, pivot, low, high));
  }
}

/* Bounding box of the free disks that each thread treats. */
typedef struct note_task {
  const engine *e;
  struct {
    _Alignas(64) double low[2], high[2];
  } share[WORK_MAX_THREADS];
} note_task;

static void note_together(const team *t, void *with) {
  note_task *f = with;
  const sd_state *s = f->e->state;
  const work *w = &f->e->work;
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  size_t begin, end;
  team_share(t, s->n_bodies, &begin, &end);
  memcpy(w->x0 + begin, s->x + begin, (end - begin) * sizeof(double));
  memcpy(w->y0 + begin, s->y + begin, (end - begin) * sizeof(double));
  for (size_t i = begin; i < end && i < s->n_free; i++) {
    if (!in_play(s, i)) continue;
    const double at[2] = {s->x[i], s->y[i]};
    for (int c = 0; c < 2; c++) {
      if (at[c] - s->radius[i] < low[c]) low[c] = at[c] - s->radius[i];
      if (at[c] + s->radius[i] > high[c]) high[c] = at[c] + s->radius[i];
    }
  }
  for (int c = 0; c < 2; c++) {
    f->share[t->rank].low[c] = low[c];
    f->share[t->rank].high[c] = high[c];
  }
}

static void note_poses(const engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  note_task f = {.e = e};
  for (int t = 0; t < WORK_MAX_THREADS; t++)
    for (int c = 0; c < 2; c++) f.share[t].low[c] = HUGE_VAL, f.share[t].high[c] = -HUGE_VAL;
  pool_run(work_pool(e), note_together, &f);
  for (int t = 1; t < WORK_MAX_THREADS; t++)
    for (int c = 0; c < 2; c++) {
      f.share[0].low[c] = math_min(f.share[0].low[c], f.share[t].low[c]);
      f.share[0].high[c] = math_max(f.share[0].high[c], f.share[t].high[c]);
    }
  for (size_t b = s->n_disks; b < s->n_bodies; b++) w->theta0[b] = s->theta[b] + s->turn[b];
  note_reaches(e, f.share[0].low, f.share[0].high);
}

static double largest_radius(const sd_state *s) {
  double largest = 0.0;
  for (size_t i = 0; i < s->n_disks; i++) largest = math_max(largest, s->radius[i]);
  return largest;
}

/* Returns the smallest factor by which the deforming box has stretched a length, of any direction,
 * since the lists were built: the smaller singular value of the map of positions. */
static double least_stretch(const work_cell *c) {
  const double x = 1.0 + c->map[0], y = 1.0 + c->map[1],
               sum = x * x + y * y + c->map[2] * c->map[2],
               root = sqrt(math_max(sum * sum - 4.0 * (x * y) * (x * y), 0.0));
  return sqrt(math_max(0.5 * (sum - root), 0.0));
}

/* Returns how far a body may move before the lists are stale. Each of two bodies may use up 0.45 of
 * the Verlet margin; the rest covers the difference between predicted and corrected positions. If
 * the box shrinks, surfaces approach even without motion, and the limit is reduced by that. */
static double limit_of(const engine *e) {
  const work *w = &e->work;
  double shrunk = math_max(1.0 - e->state->box_scale / w->list_scale, 0.0);
  if (w->cell.on) shrunk += math_max(1.0 - least_stretch(&w->cell), 0.0);
  return 0.45 * w->skin - 0.5 * shrunk * (2.0 * largest_radius(e->state) + largest_margin(e));
}

static void set_limit(work *w, double limit) {
  w->moved_limit2 = limit > 0.0 ? limit * limit : -1.0;
}

void neighbours_deform(engine *e, int64_t step) {
  work *w = &e->work;
  work_cell *c = &w->cell;
  c->step = step;
  if (!c->on) return;
  double h[3] = {w->length[0], w->length[1], w->offset};
  for (int k = 0; k < 3; k++) h[k] += w->dt * c->speed[k];
  c->map[0] = h[0] / c->list[0] - 1.0;
  c->map[1] = h[1] / c->list[1] - 1.0;
  c->map[2] = (h[2] - h[0] / c->list[0] * c->list[2]) / c->list[1];
  const double time = (double)(step + 1 - c->list_step) * w->dt;
  for (int k = 0; k < 2; k++) c->shift[k] = time * c->drift[k];
  set_limit(w, limit_of(e));
}

void neighbours_follow(engine *e) {
  work *w = &e->work;
  work_cell *c = &w->cell;
  for (int k = 0; k < 2; k++) {
    c->list[k] = w->length[k];
    c->drift[k] = 0.0;
  }
  c->list[2] = w->offset;
  c->list_step = c->step = e->state->step;
}

/* Makes the present shape of the box the reference of new lists. Stores the mean velocity of the
 * disks relative to the flow of the deforming box: a displacement that all disks have in common
 * does not make the lists stale. */
static void note_cell(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  work_cell *c = &w->cell;
  if (!c->on) return;
  const double xx = c->speed[0] / w->length[0], yy = c->speed[1] / w->length[1],
               xy = (c->speed[2] - xx * w->offset) / w->length[1];
  double n = 0.0, sum[2] = {0.0, 0.0};
  for (size_t i = 0; i < s->n_free; i++) {
    if (!in_play(s, i)) continue;
    const double x = s->x[i] - w->lower[0], y = s->y[i] - w->lower[1];
    sum[0] += s->vx[i] - (xx * x + xy * y);
    sum[1] += s->vy[i] - yy * y;
    n += 1.0;
  }
  const int64_t step = c->step;
  neighbours_follow(e);
  for (int k = 0; k < 2; k++) c->drift[k] = n > 0.0 ? sum[k] / n : 0.0;
  c->list_step = step;
  neighbours_deform(e, step);
}

bool neighbours_rescale(engine *e, double f) {
  work *w = &e->work;
  assert(f > 0.0);
  double corner[2] = {box_corner(e->model, SD_X), box_corner(e->model, SD_Y)};
  for (size_t i = 0; i < e->state->n_bodies; i++) {
    w->x0[i] = corner[SD_X] + f * (w->x0[i] - corner[SD_X]);
    w->y0[i] = corner[SD_Y] + f * (w->y0[i] - corner[SD_Y]);
  }
  for (size_t b = 0; b < e->model->n_walls; b++) w->reach[b] *= math_max(f, 1.0);
  for (int k = 0; k < 3; k++) w->cell.list[k] *= f;
  double limit = limit_of(e);
  bool stale = limit < 0.225 * w->skin;
  w->moved_limit2 = limit * limit;
  for (uint32_t i = 0; i < e->state->n_bodies && !stale; i++) stale = neighbours_moved(e, i);
  return !stale;
}

/* Constants of the choice of the Verlet margin. A wide margin adds candidates to every step, a
 * narrow one adds rebuilds of the lists. One rebuild costs as much as the candidates that a margin
 * of one mean radius adds in TUNE_BALANCE steps. If disks move by k per step, lists last skin/k
 * steps, and the total cost is least if skin (in mean radii) times the number of steps equals
 * TUNE_BALANCE. TUNE_LEAST, TUNE_MOST: smallest and largest margin, in mean radii; TUNE_STEP:
 * largest factor of one change. */
static const double TUNE_BALANCE = 27.0, TUNE_LEAST = 0.03, TUNE_MOST = 0.4, TUNE_STEP = 1.4;

void neighbours_tune(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  if (e->model->skin > 0.0) return;
  double steps = math_max((double)(s->step - w->built_at), 1.0), skin = w->skin / w->mean_radius;
  double factor = sqrt(TUNE_BALANCE / (steps * skin));
  skin *= math_min(math_max(factor, 1.0 / TUNE_STEP), TUNE_STEP);
  w->skin = w->mean_radius * math_min(math_max(skin, TUNE_LEAST), TUNE_MOST);
  assert(w->skin > 0.0);
}

sd_status neighbours_build(engine *e, sd_messages *messages) {
  const sd_state *s = e->state;
  work *w = &e->work;
  assert(w->skin > 0.0 && w->n_threads >= 1 && w->n_threads <= WORK_MAX_THREADS);
  if (neighbours_check_finite(e, s->step + 1, messages) != SD_OK) return SD_ERROR_NUMERIC;
  grid g = {0};
  walls_pose(e);
  pairs *next = &w->spare;
  sd_status status = grid_build(e, largest_margin(e), &g);
  if (status == SD_OK) status = candidates_find(e, &g, next);
  if (status == SD_OK) status = pairs_finish(e, &w->pairs, next);
  grid_free(&g);
  if (status == SD_OK) {
    losses_end_all(e, &w->pairs);
    pairs swap = w->pairs;
    w->pairs = *next;
    *next = swap;
    status = pairs_list(e);
  }
  if (status != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the list of neighbours");
  find_pieces(e);
  find_watched(e);
  note_poses(e);
  w->kernels->pack(e, s->n_free, s->n_bodies);
  assert(w->pairs.first_segment % PAIR_BLOCK == 0 && w->pairs.count <= w->pairs.capacity);
  w->list_scale = s->box_scale;
  w->built_at = s->step;
  set_limit(w, limit_of(e));
  note_cell(e);
  for (int t = 0; t < w->n_threads; t++) w->threads[t].stale = false;
  w->builds++;
  if (VALIDITY_CHECKED) validity_check_lists(e);
  return SD_OK;
}
