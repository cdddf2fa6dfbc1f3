/* contacts.c: rare events, store and load; see contacts.h. */
#include "physics/system/bodies.h"
#include "physics/step/contacts.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "model/advice.h"
#include "physics/step/engine.h"
#include "physics/system/kernels.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/losses.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/contact/pairs.h"
#include "physics/step/speed.h"
#include "physics/contact/walls.h"

#define LANE_WIDTH 1
#include "base/lane.h"

/* --- rare events ------------------------------------------------------------------------------------- */

/* Unit vector from a to b's surface, as the law has it. */
static void normal(const engine *e, size_t k, double *nx, double *ny) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  int32_t a = w->pairs.a[k], b = w->pairs.b[k];
  double dx, dy, sign = 1.0;
  if (k < w->pairs.n_round) {
    dx = s->x[b] - s->x[a];
    dy = s->y[b] - s->y[a];
    if (w->periodic[0]) dx -= w->length[0] * nearest_w1(dx * w->inverse_length[0]);
    if (w->periodic[1]) dy -= w->length[1] * nearest_w1(dy * w->inverse_length[1]);
    if (s->radius[a] + s->radius[b] < 0.0) sign = -1.0;
  } else {
    nearest_point q = walls_nearest(&w->segments[w->pairs.part[k]], s->x[a], s->y[a]);
    dx = q.dx;
    dy = q.dy;
  }
  double r = sign * sqrt(dx * dx + dy * dy);
  *nx = dx / r;
  *ny = dy / r;
}

/* Measures lambda from the present contact line on; on a straight wall also from the present side. */
static void rebase(engine *e, size_t k) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  const contact_geometry g = contact_geometry_of(e, k);
  double sum = s->radius[p->a[k]] + s->radius[p->b[k]];
  assert(pairs_closed(p, k));
  PAIR(p, k, lambda_ref) += sum * g.turned;
  PAIR(p, k, turned) = 0.0;
  normal(e, k, &PAIR(p, k, ex), &PAIR(p, k, ey));
  assert(!(fabs(hypot(PAIR(p, k, ex), PAIR(p, k, ey)) - 1.0) > 1e-9));
  if (!pairs_is_segment(p, k)) return;
  nearest_point q = walls_nearest(&e->work.segments[p->part[k]], s->x[p->a[k]], s->y[p->a[k]]);
  if (!q.flat && q.side != p->side[k]) {
    PAIR(p, k, lambda_ref) += (q.side - p->side[k]) * q.arc;
    p->side[k] = q.side;
  }
}

/* The event of this step in which the disk's contact with a piece next to k's opened, NULL: none. */
static event *left_next_piece(engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  const sd_segment *pieces = e->model->segments;
  int64_t here = p->part[k];
  const event_list *events = &e->work.threads[0].events;
  for (size_t n = 0; n < events->count; n++) {
    event *v = &events->item[n];
    bool opened = pairs_is_segment(p, v->index) && v->was_closed && !pairs_closed(p, v->index);
    if (!opened || p->a[v->index] != p->a[k] || v->transferred) continue;
    int64_t there = p->part[v->index];
    if (pieces[there].next == here || pieces[here].next == there) return v;
  }
  return NULL;
}

/* The arc length runs on through a vertex, so a disk that passes from one segment to the next keeps lambda*.
 * False: it comes from no other segment. */
static bool transfer_history(engine *e, size_t k) {
  pairs *p = &e->work.pairs;
  event *v = left_next_piece(e, k);
  assert(pairs_is_segment(p, k));
  if (!v) return false;
  assert(v->index != k && !v->transferred && fabs(v->side_before) == 1.0);
  /* around the joint of a closed polyline the arc length jumps by its whole */
  const sd_segment *there = &e->model->segments[p->part[v->index]], *here = &e->model->segments[p->part[k]];
  double jump = 0.0;
  if (there->next == p->part[k] && here <= there) jump = there->arc + there->length - here->arc;
  if (here->next == p->part[v->index] && there <= here) jump = -(here->arc + here->length - there->arc);
  sd_contact_record record = v->before;
  record.lambda_ref -= v->side_before * jump;
  record.viscous = record.friction = record.nonconservative_work =
      0.0; /* these stay with the segment that it left */
  record.turned = 0.0;
  pairs_set_record(p, k, &record);
  pairs_set_flags(p, k, true, 0);
  p->side[k] = v->side_before;
  v->transferred = true;
  /* the losses of this step are those of one contact, from the segment it left to this one */
  contact_evaluate_again(e, k);
  assert(pairs_closed(p, k));
  return true;
}

static void book_opening(engine *e, size_t k, double energy) {
  sd_state *s = e->state;
  int32_t a = e->work.pairs.a[k], b = e->work.pairs.b[k];
  bool shared = (size_t)b < s->n_free;
  losses_share(e, s->loss_opening, a, b, energy);
  if (s->n_means == 0 || !e->model->phases[s->phase].measure) return;
  s->sum_openings[a]++;
  if (shared) s->sum_openings[b]++;
}

static sd_status check_overlap(engine *e, size_t k, sd_messages *messages) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double ra = s->radius[p->a[k]], rb = fabs(s->radius[p->b[k]]), least = rb > 0.0 && rb < ra ? rb : ra;
  if (!(PAIR(p, k, overlap) > e->model->max_overlap * least)) return SD_OK;
  char a[96], b[96], hint[200];
  return sd_fail(messages, SD_ERROR_NUMERIC,
                 "step %lld: %s and %s overlap by %g, more than max_overlap = %g of the radius %g; "
                 "%s",
                 (long long)s->step + 1, sd_model_body_name(e->model, s->id[p->a[k]], a, sizeof a),
                 sd_model_body_name(e->model, s->id[p->b[k]], b, sizeof b), PAIR(p, k, overlap),
                 e->model->max_overlap, least,
                 advice_of_failure(e->model, "is k_n too small for this speed or load?", hint, sizeof hint));
}

static sd_status pair_event(engine *e, const event *v, sd_messages *messages) {
  pairs *p = &e->work.pairs;
  size_t k = v->index;
  assert(k < p->count && p->a[k] != PAIR_PADDING);
  if (!pairs_closed(p, k)) {
    assert(PAIR(p, k, ex) == 0.0 && PAIR(p, k, ey) == 0.0 && PAIR(p, k, force) == 0.0);
    losses_end(e, p, k);
    if (v->was_closed && !v->transferred) book_opening(e, k, v->dropped);
    return SD_OK;
  }
  if (v->was_closed) rebase(e, k);
  return check_overlap(e, k, messages);
}

/* theta back into [-4, 4] and the position into the box; lambda* of the disk's contacts follows. */
static void wrap(engine *e, uint32_t i) {
  sd_state *s = e->state;
  work *w = &e->work;
  pairs *p = &w->pairs;
  assert(i < s->n_bodies && remainder(s->turn[i], 8.0) == 0.0);
  double turn = s->theta[i] > 4.0 ? 8.0 : s->theta[i] < -4.0 ? -8.0 : 0.0;
  double shift[2] = {0.0, 0.0};
  if (s->x[i] < w->lower[0] || s->x[i] >= w->upper[0])
    shift[0] = s->x[i] < w->lower[0] ? w->length[0] : -w->length[0];
  if (s->y[i] < w->lower[1] || s->y[i] >= w->upper[1])
    shift[1] = s->y[i] < w->lower[1] ? w->length[1] : -w->length[1];
  s->theta[i] -= turn;
  s->turn[i] += turn;
  s->x[i] += shift[0];
  s->y[i] += shift[1];
  w->x0[i] += shift[0];
  w->y0[i] += shift[1];
  s->image_x[i] -= shift[0] > 0.0 ? 1 : shift[0] < 0.0 ? -1 : 0;
  s->image_y[i] -= shift[1] > 0.0 ? 1 : shift[1] < 0.0 ? -1 : 0;
  motion_wrapped(e, i);
  body_pack(e, i);
  if (i >= s->n_disks) walls_pose(e);
  for (size_t at = w->incidence.start[i]; at < w->incidence.start[i + 1]; at++) {
    size_t k = w->incidence.entry[at] / 2;
    if (!pairs_closed(p, k)) continue;
    PAIR(p, k, lambda_ref) -= s->radius[i] * turn;
    if (pairs_is_segment(
            p, k)) { /* the arc length of the nearest point changes, with the disk or with the wall */
      const placed_segment *g = &w->segments[p->part[k]];
      double way = shift[0] * g->tx + shift[1] * g->ty;
      PAIR(p, k, lambda_ref) += i < s->n_disks ? p->side[k] * way : -(p->side[k] * way);
    }
  }
}

static int by_index(const void *one, const void *two) {
  const event *p = one, *q = two;
  return p->index < q->index ? -1 : p->index > q->index;
}

/* All into the first list, in the order of pairs or slots, whoever noted them when. */
static sd_status merge(event_list *first, const event_list *more) {
  for (size_t n = 0; n < more->count; n++) {
    event *v = event_add(first, 0);
    if (!v) return SD_ERROR_IO;
    *v = more->item[n];
  }
  return first->failed || more->failed ? SD_ERROR_IO : SD_OK;
}

static sd_status collect(work *w) {
  thread_work *first = &w->threads[0];
  sd_status status = first->events.failed || first->returns.failed ? SD_ERROR_IO : SD_OK;
  for (int t = 1; t < w->n_threads && status == SD_OK; t++) {
    status = merge(&first->events, &w->threads[t].events);
    if (status == SD_OK) status = merge(&first->returns, &w->threads[t].returns);
    w->threads[t].events.count = w->threads[t].returns.count = 0;
  }
  if (first->events.count > 1) qsort(first->events.item, first->events.count, sizeof(event), by_index);
  if (first->returns.count > 1) qsort(first->returns.item, first->returns.count, sizeof(event), by_index);
  return status;
}

static void check_speed(engine *e) {
  work *w = &e->work;
  bool fast = false;
  for (int t = 0; t < w->n_threads; t++) {
    fast |= w->threads[t].fast;
    w->threads[t].fast = false;
  }
  if (fast) speed_check(e, e->state->step + 1);
}

sd_status contacts_events(engine *e, sd_messages *messages) {
  sd_status status = SD_OK;
  work *w = &e->work;
  if (collect(w) != SD_OK) return sd_fail(messages, SD_ERROR_IO, "out of memory for contact events");
  event_list *events = &w->threads[0].events, *returns = &w->threads[0].returns;
  for (size_t n = 1; n < events->count; n++) assert(events->item[n - 1].index <= events->item[n].index);
  for (size_t n = 0; n < events->count; n++) {
    const event *v = &events->item[n];
    if (pairs_is_segment(&w->pairs, v->index) && !v->was_closed && pairs_closed(&w->pairs, v->index))
      transfer_history(e, v->index);
  }
  for (size_t n = 0; n < events->count; n++) {
    event v = events->item[n];
    sd_status s = pair_event(e, &v, messages);
    if (status == SD_OK) status = s;
  }
  for (size_t n = 0; n < returns->count; n++) wrap(e, returns->item[n].index);
  returns->count = events->count = 0;
  check_speed(e);
  return status;
}

/* --- store and load ---------------------------------------------------------------------------------- */

sd_status contacts_store(engine *e) {
  sd_state *s = e->state;
  losses_show(e);
  const pairs *p = &e->work.pairs;
  size_t n = 0;
  for (size_t k = 0; k < p->count; k++) n += pairs_closed(p, k);
  s->n_contacts = 0; /* nothing worth copying */
  if (sd_state_reserve_contacts(s, n) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    const sd_contact_record record = pairs_record(p, k);
    size_t c = s->n_contacts++;
    assert(c < s->contact_capacity && p->a[k] != PAIR_PADDING);
    s->contact_a[c] = s->id[p->a[k]];
    s->contact_b[c] = s->id[p->b[k]];
    s->contact_part[c] = (uint32_t)p->part[k];
    sd_state_set_record(s, c, &record);
    s->contact_side[c] = p->side[k];
    s->contact_slide[c] = pairs_slide_sign(p, k);
  }
  assert(s->n_contacts == n);
  return SD_OK;
}

/* Does stored contact c stand before pair k in the order of both: round pairs and then pieces of walls? */
static bool stands_before(const engine *e, size_t c, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  assert(s->contact_a[c] < s->n_disks && s->contact_b[c] < s->n_bodies);
  uint32_t a = e->work.slot[s->contact_a[c]], b = e->work.slot[s->contact_b[c]],
           n_disks = (uint32_t)s->n_disks;
  bool piece = b >= n_disks && e->model->walls[b - n_disks].kind != SD_WALL_CIRCLE;
  if (piece != pairs_is_segment(p, k)) return !piece;
  if (a != (uint32_t)p->a[k]) return a < (uint32_t)p->a[k];
  if (b != (uint32_t)p->b[k]) return b < (uint32_t)p->b[k];
  return s->contact_part[c] < (uint32_t)p->part[k];
}

void contacts_load(engine *e) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  size_t c = 0;
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] < 0) continue;
    /* a contact of a packing may be too far apart here to be a candidate */
    while (c < s->n_contacts && stands_before(e, c, k)) c++;
    if (c == s->n_contacts) return;
    if (s->contact_a[c] != s->id[p->a[k]] || s->contact_b[c] != s->id[p->b[k]] ||
        s->contact_part[c] != (uint32_t)p->part[k])
      continue;
    const sd_contact_record record = sd_state_record(s, c);
    pairs_set_record(p, k, &record);
    pairs_set_flags(p, k, true, (s->contact_slide[c] > 0) - (s->contact_slide[c] < 0));
    p->side[k] = s->contact_side[c];
    c++;
  }
}
