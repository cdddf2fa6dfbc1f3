/* contacts.c: rare events of contacts, and the copy of contact records to and from the state;
 * implements contacts.h. */
#include "physics/step/cell.h"
#include "physics/step/step.h"
#include "physics/step/contacts.h"
#include "physics/system/bodies.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/normal_laws.h"
#include "physics/contact/energy.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/step/access.h"
#include "physics/step/bonds.h"
#include "physics/system/box.h"
#include "physics/system/halo.h"

/* --- rare events ------------------------------------------------------------------------------ */

/* Returns the point of a wall segment, or of its nearest image, that is nearest to the disk of pair
 * k. */
static nearest_point nearest_on_piece(const engine *e, size_t k) {
  const work *w = &e->work;
  const double x = e->state->x[w->pairs.a[k]], y = e->state->y[w->pairs.a[k]];
  placed_segment image;
  return walls_nearest(walls_image(w->length, &w->segments[w->pairs.part[k]], x, y, &image), x, y);
}

/* Computes the unit normal of pair k, which points from disk a to the surface of b, as in the
 * contact law. */
static void normal(const engine *e, size_t k, double *nx, double *ny) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  int32_t a = w->pairs.a[k], b = w->pairs.b[k];
  double dx, dy, sign = 1.0;
  if (!pairs_is_segment(&w->pairs, k)) {
    dx = s->x[b] - s->x[a];
    dy = s->y[b] - s->y[a];
    box_nearest(w, &dx, &dy);
    if (s->radius[a] + s->radius[b] < 0.0) sign = -1.0;
  } else {
    const nearest_point q = nearest_on_piece(e, k);
    dx = q.dx;
    dy = q.dy;
  }
  double r = sign * sqrt(dx * dx + dy * dy);
  *nx = dx / r;
  *ny = dy / r;
}

/* Makes the present normal of closed pair k its reference direction, and changes lambda_ref so that
 * the tangential displacement stays the same. If the nearest point is an end of a wall segment, the
 * side of the wall on which the disk is now is stored as well. */
static void rebase(engine *e, size_t k) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  const contact_geometry g = contact_geometry_of(e, k);
  double sum = s->radius[p->a[k]] + s->radius[p->b[k]];
  assert(pairs_closed(p, k));
  pairs_shift_lambda(p, k, sum * g.turned);
  PAIR(p, k, turned) = 0.0;
  normal(e, k, &PAIR(p, k, ex), &PAIR(p, k, ey));
  assert(!(fabs(math_hypot(PAIR(p, k, ex), PAIR(p, k, ey)) - 1.0) > 1e-9));
  if (!pairs_is_segment(p, k)) return;
  const nearest_point q = nearest_on_piece(e, k);
  if (!q.flat && q.side != p->side[k]) {
    pairs_shift_lambda(p, k, (q.side - p->side[k]) * q.arc);
    p->side[k] = q.side;
  }
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
  double ra = s->radius[p->a[k]], rb = fabs(s->radius[p->b[k]]),
         least = rb > 0.0 && rb < ra ? rb : ra;
  if (!(PAIR(p, k, overlap) > e->model->max_overlap * least)) return SD_OK;
  char a[96], b[96], hint[200];
  return sd_fail(
      messages, SD_ERROR_NUMERIC,
      "step %lld: %s and %s overlap by %g, more than max_overlap = %g of the radius %g; "
      "%s",
      (long long)s->step + 1, sd_model_body_name(e->model, s->id[p->a[k]], a, sizeof a),
      sd_model_body_name(e->model, s->id[p->b[k]], b, sizeof b), PAIR(p, k, overlap),
      e->model->max_overlap, least,
      advice_of_failure(e->model, "is k_n too small for this speed or load?", hint, sizeof hint));
}

sd_status contacts_pair_event(engine *e, const event *v, sd_messages *messages) {
  pairs *p = &e->work.pairs;
  size_t k = v->index;
  assert(k < p->count && p->a[k] != PAIR_PADDING);
  if (v->mode && bonds_broke(e, v) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for broken bonds");
  if (!pairs_closed(p, k)) {
    assert(PAIR(p, k, ex) == 0.0 && PAIR(p, k, ey) == 0.0 && PAIR(p, k, force) == 0.0);
    losses_end(e, p, k);
    if (v->was_closed && !v->unbooked) book_opening(e, k, v->dropped);
    return SD_OK;
  }
  if (v->was_closed && halo_is_ghost(e, (size_t)p->b[k])) {
    if (halo_wait_for(&e->halo->rebased, (halo_wait){.index = (uint32_t)k}) != SD_OK)
      return sd_fail(messages, SD_ERROR_IO, "out of memory for contact events");
  } else if (v->was_closed)
    rebase(e, k);
  else if (v->dropped != 0.0)
    losses_share(e, e->state->loss_bridge, p->a[k], p->b[k], v->dropped);
  if (!v->was_closed && bonds_sinter(e, k) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for contact events");
  return check_overlap(e, k, messages);
}

/* Reduces the displacement of a wall's moving surface (a conveyor) to its standard range, and
 * returns the length that was subtracted; 0 for bodies without one. i: slot. */
static double wrap_surface(engine *e, uint32_t i) {
  sd_state *s = e->state;
  if (i < s->n_disks || s->n_surfaces == 0) return 0.0;
  double *way = &s->surface[i - s->n_disks], most = body_surface_turn(e);
  const double back = most * nearbyint(*way / most);
  *way -= back;
  s->surface_turn[i - s->n_disks] += back;
  return back;
}

/* Adjusts the reference rolling displacement of pair k after the angle of body i was reduced by
 * `turn`, and the surface displacement of a round wall by the length `slid`. */
static void wrap_rolling(engine *e, size_t k, uint32_t i, double turn, double slid) {
  if (!(e->work.features & LAW_ROLLING)) return;
  pairs *p = &e->work.pairs;
  const double ra = e->state->radius[p->a[k]], rb = e->state->radius[p->b[k]],
               arm = walls_arm(ra, joints_radius(e, k));
  pairs_shift_rho(p, k, (uint32_t)p->a[k] == i ? -(arm * turn) : arm * turn);
  if (slid != 0.0 && rb != 0.0)
    pairs_shift_rho(p, k, (rb > 0.0 ? 1.0 : -1.0) * slid * (ra / (ra + rb)));
}

void contacts_wrap(engine *e, uint32_t i) {
  sd_state *s = e->state;
  work *w = &e->work;
  pairs *p = &w->pairs;
  if (i >= s->n_bodies) {
    clumps_wrap(e, i - s->n_bodies);
    return;
  }
  assert(remainder(s->turn[i], 8.0) == 0.0);
  double turn = s->theta[i] > 4.0 ? 8.0 : s->theta[i] < -4.0 ? -8.0 : 0.0;
  const double ny = s->y[i] < w->lower[1] ? -1.0 : s->y[i] >= w->upper[1] ? 1.0 : 0.0;
  /* in a sheared box the row of images above is shifted along x by `offset` */
  const double across = s->x[i] - ny * w->offset;
  const double nx = across < w->lower[0] ? -1.0 : across >= w->upper[0] ? 1.0 : 0.0;
  const double shift[2] = {-nx * w->length[0] - ny * w->offset, -ny * w->length[1]};
  if ((nx != 0.0 || ny != 0.0) && e->halo && i < s->n_free && e->halo->sent[i] &&
      halo_wait_for(&e->halo->shifted, (halo_wait){.index = i, .x = s->x[i], .y = s->y[i]}) !=
          SD_OK)
    e->halo->lost = true;
  s->theta[i] -= turn;
  s->turn[i] += turn;
  s->x[i] += shift[0];
  s->y[i] += shift[1];
  s->image_x[i] += (int32_t)nx;
  s->image_y[i] += (int32_t)ny;
  if (w->cell.on) {
    if (nx != 0.0 || ny != 0.0) cell_wrap(e, i, nx, ny);
  } else {
    w->x0[i] += shift[0];
    w->y0[i] += shift[1];
  }
  const double slid = wrap_surface(e, i);
  motion_wrapped(e, i);
  body_pack(e, i);
  if (turn != 0.0 && e->halo && i < s->n_free && e->halo->sent[i] &&
      halo_wait_for(&e->halo->wrapped, (halo_wait){.index = i, .turn = turn}) != SD_OK)
    e->halo->lost = true;
  if (i >= s->n_disks) walls_pose(e);
  for (size_t at = w->incidence.start[i]; at < w->incidence.start[i + 1]; at++) {
    size_t k = w->incidence.entry[at] / 2;
    if (!pairs_closed(p, k) || halo_is_ghost(e, (size_t)p->b[k])) continue;
    pairs_shift_lambda(p, k, -(s->radius[i] * turn));
    if (slid != 0.0) pairs_shift_lambda(p, k, s->radius[i] > 0.0 ? -slid : slid);
    if (p->more) wrap_rolling(e, k, i, turn, slid);
    if (pairs_is_segment(p, k)) {
      /* When the disk or the wall is wrapped, the arc length of the nearest point changes, except
       * along directions in which the segment has periodic images. */
      const placed_segment *g = &w->segments[p->part[k]];
      double way = (g->image[0] ? 0.0 : shift[0] * g->tx) + (g->image[1] ? 0.0 : shift[1] * g->ty);
      pairs_shift_lambda(p, k, i < s->n_disks ? p->side[k] * way : -(p->side[k] * way));
    }
  }
}

static int by_place(const void *one, const void *two) {
  const event *p = one, *q = two;
  return p->at < q->at ? -1 : p->at > q->at;
}

/* Sets the sort keys of pair events. In a run on one rank events are in the order of pairs; with
 * several ranks they are sorted by the global slots of the two bodies, the lower one first, and
 * those with wall segments come last. */
static void place_events(const engine *e, event_list *list) {
  const pairs *p = &e->work.pairs;
  for (size_t n = 0; n < list->count; n++) {
    event *v = &list->item[n];
    v->at = v->index;
    if (!e->halo) continue;
    if (pairs_is_segment(p, v->index)) {
      v->at |= (uint64_t)1 << 63;
      continue;
    }
    const uint64_t a = e->halo->order[p->a[v->index]], slot = (uint64_t)p->b[v->index];
    const uint64_t b = halo_is_free(e, slot) ? e->halo->order[slot] : (uint64_t)1 << 31 | slot;
    assert(a < (uint64_t)1 << 31);
    v->at = a < b ? a << 32 | b : b << 32 | a;
  }
}

static void place_wraps(event_list *list) {
  for (size_t n = 0; n < list->count; n++) list->item[n].at = list->item[n].index;
}

/* Appends the events of another thread to the first list. Returns SD_ERROR_IO if any event was
 * lost. */
static sd_status merge(event_list *first, const event_list *more) {
  for (size_t n = 0; n < more->count; n++) {
    event *v = event_add(first, 0);
    if (!v) return SD_ERROR_IO;
    *v = more->item[n];
  }
  return first->failed || more->failed ? SD_ERROR_IO : SD_OK;
}

void contacts_sort_events(const engine *e, thread_work *mine) {
  event_list *events = &mine->events, *returns = &mine->returns;
  place_events(e, events);
  place_wraps(returns);
  if (events->count > 1) qsort(events->item, events->count, sizeof(event), by_place);
  if (returns->count > 1) qsort(returns->item, returns->count, sizeof(event), by_place);
}

/* Collects the events of all threads in those of the first one, and sorts them. */
static sd_status collect_events(engine *e) {
  work *w = &e->work;
  thread_work *first = &w->threads[0];
  sd_status status = first->events.failed || first->returns.failed ? SD_ERROR_IO : SD_OK;
  for (int t = 1; t < w->n_threads && status == SD_OK; t++) {
    status = merge(&first->events, &w->threads[t].events);
    if (status == SD_OK) status = merge(&first->returns, &w->threads[t].returns);
    w->threads[t].events.count = w->threads[t].returns.count = 0;
  }
  contacts_sort_events(e, first);
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
  if (collect_events(e) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for contact events");
  event_list *events = &w->threads[0].events, *returns = &w->threads[0].returns;
  for (size_t n = 1; n < events->count; n++) assert(events->item[n - 1].at <= events->item[n].at);
  for (size_t n = 0; n < events->count; n++) {
    event v = events->item[n];
    sd_status s = contacts_pair_event(e, &v, messages);
    if (status == SD_OK) status = s;
  }
  if (!e->halo) bonds_sort(e->state);
  for (size_t n = 0; n < returns->count; n++) contacts_wrap(e, returns->item[n].index);
  returns->count = events->count = 0;
  check_speed(e);
  if (status == SD_OK && e->halo && e->halo->lost)
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for contact events");
  return status;
}

/* --- contacts with ghosts --------------------------------------------------------------------- */

static void follow_wrap(engine *e, size_t i, double turn) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  const incidence *n = &e->work.incidence;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
    const size_t k = n->entry[at] / 2;
    if (!pairs_closed(p, k) || !halo_is_ghost(e, (size_t)p->b[k]))
      continue; /* contacts_wrap has adjusted the contacts with other bodies already */
    pairs_shift_lambda(p, k, -(s->radius[i] * turn));
    if (p->more) wrap_rolling(e, k, (uint32_t)i, turn, 0.0);
  }
}

static int by_order(const void *one, const void *two) {
  const uint32_t p = ((const halo_wait *)one)->order, q = ((const halo_wait *)two)->order;
  return p < q ? -1 : p > q;
}

/* Swaps the present position of a disk with the one in *w, which it had before it was wrapped
 * around the box. */
static void exchange_place(const sd_state *s, halo_wait *w) {
  const double x = s->x[w->index], y = s->y[w->index];
  s->x[w->index] = w->x;
  s->y[w->index] = w->y;
  w->x = x;
  w->y = y;
}

static void exchange_places(const engine *e, halo_wait *ghosts) {
  halo_waits *own = &e->halo->shifted;
  for (size_t n = 0; n < own->count; n++) exchange_place(e->state, &own->item[n]);
  for (size_t g = 0; g < e->state->n_ghosts; g++) exchange_place(e->state, &ghosts[g]);
}

/* Updates contacts with ghosts in the same order as a run on one rank does: first reference
 * directions are renewed, at the positions before disks were wrapped; then wraps are applied, in
 * the order of global slots. */
sd_status contacts_update_ghosts(engine *e) {
  halo *h = e->halo;
  halo_waits *wrapped = &h->wrapped;
  const sd_state *s = e->state;
  halo_wait *ghosts;
  if (!memory_row(&ghosts, s->n_ghosts, sizeof *ghosts)) {
    /* a status cannot be returned to all ranks any more, since they have already agreed on the next
     * step; so the run ends here */
    comm_fail(e->halo->comm, "no memory");
    return SD_ERROR_IO;
  }
  halo_refresh(e, ghosts);
  exchange_places(e, ghosts);
  for (size_t n = 0; n < h->rebased.count; n++)
    (h->rebased.item[n].bonds ? bonds_make : rebase)(e, h->rebased.item[n].index);
  exchange_places(e, ghosts);
  sd_status status = SD_OK;
  for (size_t g = 0; g < s->n_ghosts && status == SD_OK; g++)
    if (ghosts[g].turn != 0.0) status = halo_wait_for(wrapped, ghosts[g]);
  for (size_t n = 0; n < wrapped->count; n++)
    wrapped->item[n].order = h->order[wrapped->item[n].index];
  if (wrapped->count > 1) qsort(wrapped->item, wrapped->count, sizeof *wrapped->item, by_order);
  for (size_t n = 0; n < wrapped->count; n++)
    follow_wrap(e, wrapped->item[n].index, wrapped->item[n].turn);
  h->rebased.count = wrapped->count = 0;
  free(ghosts);
  if (status != SD_OK) comm_fail(e->halo->comm, "no memory");
  return status;
}

/* --- conversion from and to the state --------------------------------------------------------- */

size_t contacts_count(const engine *e) {
  const pairs *p = &e->work.pairs;
  size_t n = 0;
  for (size_t k = 0; k < p->count; k++) n += pairs_closed(p, k) && halo_counts(e, k);
  return n;
}

/* Describes the overlap of the disks in slots a and b, for a message; the smaller disk is named
 * first. depth: overlap, a length. */
static first_overlap overlap_of(const engine *e, size_t a, size_t b, double depth) {
  const sd_state *s = e->state;
  const double *g = e->model->gravity;
  const sd_contact_law law = law_at(sd_model_law(e->model, s->material[a], s->material[b]),
                                    law_arm(s->radius[a], s->radius[b]));
  if (s->radius[b] < s->radius[a]) {
    const size_t swap = a;
    a = b;
    b = swap;
  }
  return (first_overlap){.a = s->id[a],
                         .b = s->id[b],
                         .depth = depth,
                         .relative = depth / s->radius[a],
                         .force = law_force(&law, depth),
                         .weight = math_min(s->mass[a], s->mass[b]) * math_hypot(g[0], g[1])};
}

sd_status contacts_check_start(const engine *e, first_overlap *deepest, sd_messages *messages) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const double most = e->model->max_overlap;
  *deepest = (first_overlap){0};
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] == PAIR_PADDING || (size_t)p->b[k] >= s->n_disks) continue;
    const size_t a = (size_t)p->a[k], b = (size_t)p->b[k];
    const double dx = engine_nearest(e, SD_X, s->x[a] - s->x[b]),
                 dy = engine_nearest(e, SD_Y, s->y[a] - s->y[b]);
    const double least = math_min(s->radius[a], s->radius[b]),
                 depth = s->radius[a] + s->radius[b] - math_hypot(dx, dy);
    if (depth > deepest->relative * least && !pairs_closed(p, k))
      *deepest = overlap_of(e, a, b, depth);
    if (!(most > 0.0 && depth > most * least)) continue;
    char one[96], two[96];
    const size_t later = s->id[a] > s->id[b] ? a : b;
    return sd_fail(
        messages, SD_ERROR_USER,
        "disk_files[%zu].file: %s and %s overlap by %g, more than max_overlap = %g of the smaller "
        "radius %g",
        e->model->tiles.entry, sd_model_body_name(e->model, s->id[later], one, sizeof one),
        sd_model_body_name(e->model, s->id[a + b - later], two, sizeof two), depth, most, least);
  }
  return SD_OK;
}

/* Contact that ends because one of its disks is removed. first, second: keys by which such contacts
 * are sorted, the global slots of the two bodies, the lower one first. */
typedef struct ending {
  uint64_t first, second;
  uint32_t part, k;
  bool piece;
} ending;

static int by_whole(const void *one, const void *two) {
  const ending *p = one, *q = two;
  if (p->piece != q->piece) return p->piece ? 1 : -1;
  if (p->first != q->first) return p->first < q->first ? -1 : 1;
  if (p->second != q->second) return p->second < q->second ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

static bool goes(const engine *e, const bool *gone, int32_t slot) {
  return (size_t)slot < e->state->n_free + e->state->n_ghosts && gone[slot];
}

sd_status contacts_end(engine *e, const bool *gone) {
  pairs *p = &e->work.pairs;
  size_t n = 0, most = 0;
  for (size_t k = 0; k < p->count; k++)
    most += pairs_closed(p, k) && (goes(e, gone, p->a[k]) || goes(e, gone, p->b[k]));
  ending *list;
  if (!memory_row(&list, most, sizeof *list)) return SD_ERROR_IO;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k) || !(goes(e, gone, p->a[k]) || goes(e, gone, p->b[k]))) continue;
    const uint64_t a = halo_order(e, (size_t)p->a[k]), b = halo_order(e, (size_t)p->b[k]);
    list[n++] = (ending){a < b ? a : b, a < b ? b : a, (uint32_t)p->part[k], (uint32_t)k,
                         pairs_is_segment(p, k)};
  }
  if (n > 1) qsort(list, n, sizeof *list, by_whole);
  for (size_t k = 0; k < n; k++) {
    losses_end(e, p, list[k].k);
    p->flags[pairs_flags_at(p, list[k].k)].closed &= ~pairs_flag_bit(p, list[k].k);
  }
  free(list);
  return SD_OK;
}

sd_status contacts_store(engine *e) {
  losses_update(e);
  return contacts_store_rows(e);
}

sd_status contacts_store_rows(engine *e) {
  sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const size_t n = contacts_count(e);
  s->n_contacts = 0; /* with this count, old contacts are not copied when the arrays grow */
  if (sd_state_reserve_contacts(s, n) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k) || !halo_counts(e, k)) continue;
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

/* Returns true if stored contact c comes before pair k in the order of the lists of pairs: round
 * bodies, then pairs with ghosts, then wall segments, each sorted by slots. */
static bool stands_before(const engine *e, size_t c, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  assert(s->contact_a[c] < e->model->n_disks && s->contact_b[c] < sd_model_bodies(e->model));
  uint32_t a = slot_of(&e->work.slots, s->contact_a[c]),
           b = slot_of(&e->work.slots, s->contact_b[c]), n_disks = (uint32_t)s->n_disks;
  bool piece = b >= n_disks && e->model->walls[b - n_disks].kind != SD_WALL_CIRCLE;
  if (piece != pairs_is_segment(p, k)) return !piece;
  if (halo_is_ghost(e, b) != halo_is_ghost(e, (size_t)p->b[k])) return !halo_is_ghost(e, b);
  if (a != (uint32_t)p->a[k]) return a < (uint32_t)p->a[k];
  if (b != (uint32_t)p->b[k]) return b < (uint32_t)p->b[k];
  return s->contact_part[c] < (uint32_t)p->part[k];
}

/* Finds the next pair that has a stored contact: pair *k and stored contact *c, searched from the
 * given values on. Returns false if there is none. Start with 0 and 0, and add 1 to both before the
 * next call. */
static bool next_stored(const engine *e, size_t *k, size_t *c) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  for (; *k < p->count; (*k)++) {
    if (p->a[*k] < 0) continue;
    /* skip contacts of an input packing whose bodies are too far apart here to be candidates */
    while (*c < s->n_contacts && stands_before(e, *c, *k)) (*c)++;
    if (*c == s->n_contacts) return false;
    if (s->contact_a[*c] == s->id[p->a[*k]] && s->contact_b[*c] == s->id[p->b[*k]] &&
        s->contact_part[*c] == (uint32_t)p->part[*k])
      return true;
  }
  return false;
}

/* Returns the sign of the torque that stored contact c had while it slid, 0 if it was stuck.
 * *carried: true if the contact's force is to be taken from the file (SD_FORCE_CARRIED), not
 * computed anew. */
static int slide_of_stored(const sd_state *s, size_t c, bool *carried) {
  *carried = s->contact_slide[c] > 1;
  const int slide = s->contact_slide[c] - (*carried ? SD_FORCE_CARRIED : 0);
  return (slide > 0) - (slide < 0);
}

static void load_one(engine *e, size_t k, size_t c) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  bool carried;
  sd_contact_record record = sd_state_record(s, c);
  if (!(e->work.features & LAW_ROLLING)) record.rho_ref = 0.0;
  pairs_set_record(p, k, &record);
  pairs_set_flags(p, k, true, slide_of_stored(s, c, &carried));
  p->side[k] = s->contact_side[c];
}

void contacts_load(engine *e) {
  for (size_t k = 0, c = 0; next_stored(e, &k, &c); k++, c++) load_one(e, k, c);
}

/* For a contact that slid in its last step, according to the file: returns true if it slid in the
 * step before, too. This is so if its tangential force is within the limit with mu_kinetic. */
static bool slid_before(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  const law_row *l = &e->work.laws[PAIR(p, k, law)];
  const double limit = math_max(
      PAIR(p, k, force) + MORE(p, k, bond_pull) + MORE(p, k, pull) - l->critical_load, 0.0);
  return fabs(MORE(p, k, tau) + MORE(p, k, bond_shear)) <=
         (1.0 + 1e-6) * l->cap_kinetic * l->k_t * limit;
}

void contacts_restore_before(engine *e) {
  pairs *p = &e->work.pairs;
  for (size_t k = 0, c = 0; p->more && next_stored(e, &k, &c); k++, c++) {
    if (pairs_slide_sign(p, k) != 0 && !slid_before(e, k)) pairs_set_flags(p, k, true, 0);
    /* the evaluation of step 0 sets these; it does not if the model has no law with them, and then
     * they must be 0 */
    MORE(p, k, tau) = MORE(p, k, pull) = 0.0;
    MORE(p, k, bond_pull) = MORE(p, k, bond_shear) = MORE(p, k, bond_bend) = 0.0;
    if (isnan(MORE(p, k, rho_ref))) MORE(p, k, rho_ref) = contact_rho_of(e, k);
  }
}

/* Returns true if pair k has the same overlap as stored contact c in the file; it has not, for
 * example, in a box of another size. The tolerance of 1e-5 radii allows for Gear's integrator,
 * which evaluates contacts at predicted positions. */
static bool is_in_place(const engine *e, size_t k, size_t c) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const double far = PAIR(p, k, overlap) - sd_state_record(s, c).overlap;
  return fabs(far) <= 1e-5 * s->radius[p->a[k]];
}

void contacts_restore_after(engine *e) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  for (size_t k = 0, c = 0; next_stored(e, &k, &c); k++, c++) {
    bool carried;
    const int slide = slide_of_stored(s, c, &carried);
    if (!pairs_closed(p, k)) continue;
    if (carried && is_in_place(e, k, c))
      load_one(e, k, c);
    else if (p->more && slide != 0)
      pairs_set_flags(p, k, true, slide);
  }
}
