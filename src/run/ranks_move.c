/* ranks_move.c: cuts the plane into one domain per rank, moves disks and contacts to the ranks of
 * their domains, and chooses ghosts; see ranks_move.h. */
#include "run/ranks_move.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/laws.h"
#include "model/model.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/access.h"
#include "run/ranks_share.h"
#include "run/route.h"

/* --- Owners of disks -------------------------------------------------------------------------- */

/* Data of a move of disks between ranks: order, positions and radii of the disks of the new domain,
 * and the routes by which disks, ghosts and contacts come to this rank. */
typedef struct shares {
  const comm *comm;
  const sd_model *model;
  const comm_cuts *cuts;
  const engine *from;
  bool first;
  int *owner; /* [number of own disks and ghosts before the move] rank to which each disk goes */
  route disks, ghosts, contacts;
  uint32_t *place; /* [number of disks that come] slot of each in the new state */
  /* [number of own disks, then of ghosts, after the move] slots in the sorted order of all disks */
  uint32_t *order;
  uint32_t *ghost_place; /* [number of ghosts that come] slot of each in the new state */
  double *x, *y, *radius;
  int32_t *activity;
} shares;

static void part_free(shares *p) {
  route_free(&p->disks);
  route_free(&p->ghosts);
  route_free(&p->contacts);
  free(p->owner);
  free(p->place);
  free(p->order);
  free(p->ghost_place);
  free(p->x);
  free(p->y);
  free(p->radius);
  free(p->activity);
}

/* Ends the job if `memory` is false (an allocation failed), since the other ranks would wait. */
static sd_status need(const comm *c, bool memory) {
  if (memory) return SD_OK;
  comm_fail(c, "no memory");
  return SD_ERROR_IO;
}

/* Finds the rank to which each disk goes: that of its domain. Disks that wait for their release are
 * distributed by number, so that all ranks need about the same memory. */
static sd_status find_owners(shares *p) {
  double low[2], high[2];
  const sd_state *s = p->from->state;
  const size_t n = s->n_free + s->n_ghosts;
  if (need(p->comm, memory_resize_row(&p->owner, n, sizeof *p->owner)) != SD_OK) return SD_ERROR_IO;
  comm_cuts_mine(p->cuts, low, high);
  for (size_t i = 0; i < n; i++) {
    if (i < s->n_free && s->activity[i] == SD_WAITING) {
      p->owner[i] = (int)(s->id[i] % (uint32_t)comm_size(p->comm));
      continue;
    }
    const bool inside =
        s->x[i] > low[0] && s->x[i] < high[0] && s->y[i] > low[1] && s->y[i] < high[1];
    p->owner[i] = inside ? comm_rank(p->comm) : comm_cuts_owner(p->cuts, s->x[i], s->y[i]);
  }
  return SD_OK;
}

/* Finds slots for the rows that come from all ranks such that they ascend by the column `order`.
 * found: scratch buffer for that column. */
static sd_status come_in_order(route *r, const uint32_t *order, uint32_t *found, uint32_t *place) {
  const sd_status status = route_columns(r, &(route_column){order, found, sizeof *order}, 1, NULL);
  if (status == SD_OK) route_merge(r, found, place);
  return status;
}

/* Receives the slots in the order of all disks, positions, radii and activity of the disks that
 * come to this rank; they are needed to choose ghosts. */
static sd_status call_disks(shares *p) {
  const sd_state *s = p->from->state;
  const uint32_t *order = p->from->halo->order;
  route *r = &p->disks;
  uint32_t *found = NULL;
  if (need(p->comm, route_new(r, p->comm, s->n_free, NULL, p->owner) == SD_OK) != SD_OK)
    return SD_ERROR_IO;
  route_count(r);
  const size_t n = r->n_receive;
  const memory_column arrays[] = {
      {&p->place, n, sizeof *p->place},   {&p->order, n, sizeof *p->order},
      {&p->x, n, sizeof *p->x},           {&p->y, n, sizeof *p->y},
      {&p->radius, n, sizeof *p->radius}, {&p->activity, n, sizeof *p->activity},
      {&found, n, sizeof *found}};
  sd_status status = need(p->comm, memory_resize(sizeof arrays / sizeof *arrays, arrays));
  const route_column known[] = {{order, p->order, sizeof *order},
                                {s->x, p->x, sizeof *p->x},
                                {s->y, p->y, sizeof *p->y},
                                {s->radius, p->radius, sizeof *p->radius},
                                {s->activity, p->activity, sizeof *p->activity}};
  if (status == SD_OK) status = come_in_order(r, order, found, p->place);
  if (status == SD_OK) status = route_columns(r, known, sizeof known / sizeof *known, p->place);
  free(found);
  return status;
}

/* --- Ghosts ----------------------------------------------------------------------------------- */

/* Growing list of pairs (row, rank to which the row is sent). */
typedef struct sends {
  uint32_t *row;
  int *rank;
  size_t n, capacity;
} sends;

static sd_status add_send(sends *l, uint32_t row, int rank) {
  if (l->n == l->capacity) {
    const size_t capacity = 2 * l->capacity + 64;
    const memory_column arrays[] = {{&l->row, capacity, sizeof *l->row},
                                    {&l->rank, capacity, sizeof *l->rank}};
    if (!memory_resize(sizeof arrays / sizeof *arrays, arrays)) return SD_ERROR_IO;
    l->capacity = capacity;
  }
  l->row[l->n] = row;
  l->rank[l->n++] = rank;
  return SD_OK;
}

/* Rectangle of this rank's domain (low, high), cut off at the edges of the periodic box, and the
 * periodic box (lower, upper, length). */
typedef struct box {
  /* [2]: along x and y; length 0: open direction */
  double low[2], high[2], lower[2], upper[2], length[2];
} box;

/* Returns true if a periodic image with coordinate `at` along direction c is so far outside the
 * periodic box that no disk is near it. The rectangles at the edges extend to infinity, but their
 * disks are in the box. */
static bool is_beyond(const box *b, int c, double at, double beside) {
  return b->length[c] > 0.0 && (at + 2.0 * beside < b->lower[c] || at - 2.0 * beside > b->upper[c]);
}

/* Adds disk i to the list for each other rank whose rectangle is within distance `beside` of the
 * disk or of one of its periodic images. seen: [number of ranks] scratch, all zero on entry and on
 * return. */
static sd_status add_ghost(const shares *p, sends *l, const box *b, uint32_t i, double beside,
                           int *ranks, uint8_t *seen) {
  const double at[2] = {p->x[i], p->y[i]};
  if (at[0] - beside > b->low[0] && at[0] + beside < b->high[0] && at[1] - beside > b->low[1] &&
      at[1] + beside < b->high[1])
    return SD_OK;
  const int nx = b->length[0] > 0.0 ? 1 : 0, ny = b->length[1] > 0.0 ? 1 : 0;
  const size_t first = l->n;
  for (int ix = -nx; ix <= nx; ix++)
    for (int iy = -ny; iy <= ny; iy++) {
      const double x = at[0] + ix * b->length[0], y = at[1] + iy * b->length[1];
      if (is_beyond(b, SD_X, x, beside) || is_beyond(b, SD_Y, y, beside)) continue;
      const double low[2] = {x - beside, y - beside}, high[2] = {x + beside, y + beside};
      const int n = comm_cuts_near(p->cuts, low, high, ranks);
      for (int k = 0; k < n; k++) {
        if (ranks[k] == comm_rank(p->comm) || seen[ranks[k]]) continue;
        seen[ranks[k]] = 1;
        if (add_send(l, i, ranks[k]) != SD_OK) return SD_ERROR_IO;
      }
    }
  for (size_t k = first; k < l->n; k++) seen[l->rank[k]] = 0;
  return SD_OK;
}

/* Returns the rectangle of this rank's domain, cut off at the edges of the periodic box, since
 * beyond them are periodic images of other domains. */
static box box_of(const shares *p, const sd_state *s) {
  box b = {0};
  comm_cuts_mine(p->cuts, b.low, b.high);
  for (int c = 0; c < 2; c++) {
    if (!p->model->periodic[c]) continue;
    const double upper =
        p->model->lower[c] + s->box_scale * (p->model->upper[c] - p->model->lower[c]);
    b.lower[c] = p->model->lower[c];
    b.upper[c] = upper;
    b.length[c] = upper - b.lower[c];
    b.low[c] = math_max(b.low[c], b.lower[c]);
    b.high[c] = math_min(b.high[c], upper);
  }
  return b;
}

/* Chooses the disks of this domain that other ranks need as ghosts; skin: Verlet margin. */
static sd_status choose_ghosts(shares *p, double skin) {
  sends list = {0};
  const box b = box_of(p, p->from->state);
  const double reach = p->model->largest_radius + (skin + laws_range(p->model)) * (1.0 + 1e-9);
  int *ranks = memory_new((size_t)comm_size(p->comm), sizeof *ranks);
  uint8_t *seen = memory_new((size_t)comm_size(p->comm), 1);
  sd_status status = SD_OK;
  for (uint32_t i = 0; i < p->disks.n_receive && status == SD_OK; i++)
    if (p->activity[i] != SD_WAITING && p->activity[i] != SD_REMOVED)
      status = add_ghost(p, &list, &b, i, p->radius[i] + reach, ranks, seen);
  if (status == SD_OK) status = route_new(&p->ghosts, p->comm, list.n, list.row, list.rank);
  status = need(p->comm, status == SD_OK);
  if (status == SD_OK) route_count(&p->ghosts);
  free(list.row);
  free(list.rank);
  free(ranks);
  free(seen);
  return status;
}

/* Finds the slots of the ghosts that come to this rank, ascending by their slots in the order of
 * all disks. */
static sd_status place_ghosts(shares *p) {
  route *r = &p->ghosts;
  const size_t n_own = p->disks.n_receive, n = r->n_receive;
  uint32_t *found = NULL;
  const memory_column arrays[] = {{&p->order, n_own + n, sizeof *p->order},
                                  {&p->ghost_place, n, sizeof *p->ghost_place},
                                  {&found, n, sizeof *found}};
  sd_status status = need(p->comm, memory_resize(sizeof arrays / sizeof *arrays, arrays));
  if (status == SD_OK) status = come_in_order(r, p->order, found, p->ghost_place);
  free(found);
  for (size_t k = 0; k < r->n_receive && status == SD_OK; k++) p->ghost_place[k] += (uint32_t)n_own;
  if (status == SD_OK)
    status =
        route_columns(r, &(route_column){p->order, p->order, sizeof *p->order}, 1, p->ghost_place);
  return status;
}

/* --- Contacts --------------------------------------------------------------------------------- */

/* Returns the ranks that own the disks of each contact, [2 n]: those of the n first disks, then
 * those of the second disks. If the second body is prescribed, its entry is the owner of the first
 * disk. Asks a distributed table (directory), because the disks of a contact may be on other
 * ranks. */
static int32_t *look_up_owners(const shares *p) {
  const sd_state *s = p->from->state;
  const size_t n = s->n_contacts, disks = p->model->n_disks;
  directory d;
  int32_t *mine = route_allocate(p->comm, s->n_free, sizeof *mine),
          *found = route_allocate(p->comm, 2 * n, sizeof *found);
  uint32_t *number = route_allocate(p->comm, 2 * n, sizeof *number);
  for (size_t i = 0; i < s->n_free; i++) mine[i] = 1 + p->owner[i];
  for (size_t k = 0; k < n; k++) {
    number[k] = s->contact_a[k];
    number[n + k] = s->contact_b[k] < disks ? s->contact_b[k] : s->contact_a[k];
  }
  directory_new(&d, p->comm, disks, sizeof *mine);
  directory_put(&d, s->n_free, s->id, mine);
  directory_get(&d, 2 * n, number, found);
  directory_free(&d);
  for (size_t k = 0; k < n; k++) {
    while (found[k] == 0) comm_fail(p->comm, "a contact is of no free disk");
    found[k] -= 1;
    found[n + k] = found[n + k] > 0 ? found[n + k] - 1 : found[k];
  }
  free(mine);
  free(number);
  return found;
}

/* Returns the same array as look_up_owners, without communication, if the disks of all contacts are
 * on this rank, as own disks or ghosts. */
static int32_t *find_contact_owners(const shares *p) {
  const sd_state *s = p->from->state;
  const size_t n = s->n_contacts, known = s->n_free + s->n_ghosts;
  int32_t *found = route_allocate(p->comm, 2 * n, sizeof *found);
  for (size_t k = 0; k < n; k++) {
    const uint32_t a = engine_slot(p->from, s->contact_a[k]),
                   b = engine_slot(p->from, s->contact_b[k]);
    assert(a < known && s->id[a] == s->contact_a[k] && s->id[b] == s->contact_b[k]);
    found[k] = p->owner[a];
    found[n + k] = b < known ? p->owner[b] : p->owner[a];
  }
  return found;
}

/* Makes the route by which contacts are sent: each contact goes to the owners of both its disks. */
static sd_status call_contacts(shares *p) {
  sends list = {0};
  sd_status status = SD_OK;
  const size_t n = p->from->state->n_contacts;
  int32_t *owner = p->first ? look_up_owners(p) : find_contact_owners(p);
  for (uint32_t k = 0; k < n && status == SD_OK; k++) {
    status = add_send(&list, k, owner[k]);
    if (owner[n + k] != owner[k] && status == SD_OK) status = add_send(&list, k, owner[n + k]);
  }
  if (status == SD_OK) status = route_new(&p->contacts, p->comm, list.n, list.row, list.rank);
  status = need(p->comm, status == SD_OK);
  if (status == SD_OK) route_count(&p->contacts);
  free(list.row);
  free(list.rank);
  free(owner);
  return status;
}

static sd_status take_contacts(shares *p, sd_state *to) {
  route *r = &p->contacts;
  to->n_contacts = 0;
  const sd_status status = need(r->comm, sd_state_reserve_contacts(to, r->n_receive) == SD_OK);
  to->n_contacts = r->n_receive;
  moving m = {.route = r, .from = p->from->state, .to = to, .narrow = p->first};
  moving_contacts(&m);
  return status == SD_OK ? moving_send(&m, NULL) : status;
}

/* --- New state and halo ----------------------------------------------------------------------- */

static sd_status take_disks(shares *p, sd_state *to) {
  moving disks = {.route = &p->disks, .from = p->from->state, .to = to, .narrow = p->first},
         ghosts = {.route = &p->ghosts, .from = to, .to = to};
  moving_disks(&disks, p->model, false);
  moving_disks(&ghosts, p->model, true);
  const sd_status status = moving_send(&disks, p->place);
  return status == SD_OK ? moving_send(&ghosts, p->ghost_place) : status;
}

static sd_status make_halo(shares *p, double skin, halo **out) {
  halo *h = *out = memory_new(1, sizeof *h);
  h->comm = p->comm;
  h->skin = skin;
  h->n_own = p->disks.n_receive;
  h->n_ghosts = p->ghosts.n_receive;
  h->n_send = p->ghosts.n_send;
  h->order = p->order;
  h->send_slot = p->ghosts.row;
  h->ghost_slot = p->ghost_place;
  p->order = p->ghosts.row = p->ghost_place = NULL;
  return halo_connect(h, p->ghosts.to, p->ghosts.from);
}

sd_status move_parts(const comm_cuts *cuts, const engine *from, bool first, double skin,
                     sd_state **state, halo **h) {
  const comm *c = comm_cuts_comm(cuts);
  const sd_model *model = from->model;
  shares p = {.comm = c, .model = model, .cuts = cuts, .from = from, .first = first};
  *state = NULL;
  *h = NULL;
  sd_status status = find_owners(&p);
  if (status == SD_OK) status = call_disks(&p);
  if (status == SD_OK) status = choose_ghosts(&p, skin);
  if (status == SD_OK) status = place_ghosts(&p);
  if (status == SD_OK) *state = state_new_part(model, p.disks.n_receive, p.ghosts.n_receive);
  if (status == SD_OK) status = need(c, *state);
  if (status == SD_OK) status = take_disks(&p, *state);
  if (status == SD_OK) status = call_contacts(&p);
  if (status == SD_OK) status = take_contacts(&p, *state);
  if (status == SD_OK) status = need(c, common_take(from->state, *state));
  if (status == SD_OK) status = make_halo(&p, skin, h);
  part_free(&p);
  if (status == SD_OK) status = order_contacts(model, *state);
  return status;
}

/* --- Cuts ------------------------------------------------------------------------------------- */

/* Weight, for the cut into domains, of a disk that is not in play; others have 1. It is so small
 * that all such disks together count little. */
static const float IDLE = 1e-6f;

sd_status move_first_cut(comm_cuts *cuts, const sd_state *s) {
  const comm *c = comm_cuts_comm(cuts);
  float *weight = NULL;
  const bool there = memory_resize_row(&weight, s->n_free, sizeof *weight);
  for (size_t i = 0; there && i < s->n_free; i++)
    weight[i] = s->activity[i] == SD_IN_PLAY ? 1.0f : IDLE;
  sd_status status = there ? SD_OK : SD_ERROR_IO;
  if (comm_or(c, status != SD_OK) == 0)
    status = comm_cuts_make(cuts, s->n_free, s->x, s->y, weight);
  free(weight);
  return status;
}

/* The seconds of work per contact are limited to a factor MOST above and below the mean of all
 * ranks: a rank that had to wait for its processor should not lose all its disks. */
sd_status move_cut_again(comm_cuts *cuts, const engine *e, double busy) {
  const sd_state *s = e->state;
  enum { REST = 6 /* cost of a disk without its contacts, in units of half a pair */, MOST = 2 };
  const comm *c = comm_cuts_comm(cuts);
  float *weight = NULL;
  const bool there = memory_resize_row(&weight, s->n_free, sizeof *weight);
  const double all = (double)(engine_first(e, s->n_free) + REST * s->n_free),
               mean = comm_total(c, busy) / math_max(comm_total(c, all), 1.0),
               rate = math_min(math_max(busy / math_max(all, 1.0), mean / MOST), mean * MOST);
  sd_status status = there ? SD_OK : SD_ERROR_IO;
  for (size_t i = 0; there && i < s->n_free; i++)
    weight[i] = (float)(rate * (double)(engine_first(e, i + 1) - engine_first(e, i) + REST)) *
                (s->activity[i] == SD_IN_PLAY ? 1.0f : IDLE);
  if (comm_or(c, status != SD_OK) == 0)
    status = comm_cuts_make(cuts, s->n_free, s->x, s->y, weight);
  free(weight);
  return status;
}

/* Buckets for a parallel sort of the disks: each holds the disks of one size class in one strip of
 * the plane, or in several adjacent strips if there are very many. Buckets are in the order of the
 * sort; the last one has the disks that are not in play. */
typedef struct buckets {
  uint64_t strips, width; /* number of buckets per size class; number of strips per bucket */
  /* n: number of buckets; begin: [n + 1] number of disks of all ranks in the buckets before */
  size_t n, *begin;
} buckets;

enum { STRIPS = 1 << 16 };

/* Returns the number of the bucket to which a disk belongs. */
static size_t bucket_of(const buckets *b, const order_place *p) {
  if (p->strip == UINT64_MAX) return b->n - 1;
  return (size_t)(p->level * b->strips + p->strip / b->width);
}

/* Collective: sets the widths of the buckets and counts the disks of all ranks in each. */
static sd_status count_buckets(const comm *c, const order_place *list, size_t n, buckets *b) {
  double strip = 0.0, level = 0.0;
  for (size_t k = 0; k < n; k++) {
    if (list[k].strip == UINT64_MAX) continue;
    strip = math_max(strip, (double)list[k].strip);
    level = math_max(level, (double)list[k].level);
  }
  const uint64_t most = (uint64_t)comm_largest(c, strip) + 1;
  b->width = (most + STRIPS - 1) / STRIPS;
  b->strips = (most + b->width - 1) / b->width;
  b->n = (size_t)((uint64_t)comm_largest(c, level) + 1) * (size_t)b->strips + 1;
  int64_t *counts;
  if (!memory_rows(2, (memory_column[]){{&b->begin, b->n + 1, sizeof *b->begin},
                                        {&counts, b->n, sizeof *counts}}))
    return SD_ERROR_IO;
  for (size_t k = 0; k < n; k++) counts[bucket_of(b, &list[k])]++;
  comm_add(c, counts, b->n);
  for (size_t k = 0; k < b->n; k++) b->begin[k + 1] = b->begin[k] + (size_t)counts[k];
  free(counts);
  return SD_OK;
}

/* Returns the rank that sorts and numbers the disks of a bucket. The rank ascends with the bucket,
 * so that each rank numbers a contiguous range. */
static int keeper_of(const comm *c, const buckets *b, size_t bucket) {
  const size_t all = b->begin[b->n], ranks = (size_t)comm_size(c);
  return (int)(b->begin[bucket] * ranks / all);
}

/* Returns the first slot that this rank gives to a disk: the number of disks in the buckets that
 * lower ranks number. */
static size_t first_kept(const comm *c, const buckets *b) {
  size_t k = 0;
  while (k < b->n && (b->begin[k + 1] == b->begin[k] || keeper_of(c, b, k) < comm_rank(c))) k++;
  return b->begin[k];
}

/* Sorts the n sort keys `came` and numbers them from `first` on. number[k]: number of the key that
 * was came[k] on entry. */
static void number_places(order_place *came, size_t n, size_t first, uint32_t *number) {
  for (size_t k = 0; k < n; k++) came[k].slot = (uint32_t)k;
  if (n > 1) qsort(came, n, sizeof *came, order_by_place);
  for (size_t k = 0; k < n; k++) number[came[k].slot] = (uint32_t)(first + k);
}

/* Collective: finds the slots, in the sorted order of the disks of all ranks, of the disks with the
 * n sort keys in `list`, which ascend. rank: scratch buffer for n numbers. */
static sd_status find_order(const comm *c, const order_place *list, size_t n, int *rank,
                            uint32_t *order) {
  buckets b = {0};
  route r = {0};
  order_place *came = NULL;
  uint32_t *number = NULL;
  sd_status status = count_buckets(c, list, n, &b);
  for (size_t k = 0; status == SD_OK && k < n; k++)
    rank[k] = keeper_of(c, &b, bucket_of(&b, &list[k]));
  if (status == SD_OK) status = route_new(&r, c, n, NULL, rank);
  if (status != SD_OK) comm_fail(c, "no memory");
  if (status == SD_OK) route_count(&r);
  const size_t n_came = r.n_receive;
  const memory_column arrays[] = {{&came, n_came, sizeof *came}, {&number, n_came, sizeof *number}};
  if (status == SD_OK && !memory_resize(sizeof arrays / sizeof *arrays, arrays)) {
    comm_fail(c, "no memory");
    status = SD_ERROR_IO;
  }
  if (status == SD_OK)
    status = route_columns(&r, &(route_column){list, came, sizeof *came}, 1, NULL);
  if (status == SD_OK) {
    number_places(came, n_came, first_kept(c, &b), number);
    route_send_back(&r, (route_column){number, order, sizeof *order});
  }
  for (size_t k = 1; k < n && status == SD_OK; k++) assert(order[k - 1] < order[k]);
  route_free(&r);
  free(b.begin);
  free(came);
  free(number);
  return status;
}

sd_status ranks_order(const comm *c, const sd_model *m, sd_state *part, uint32_t *order) {
  order_place *list = NULL;
  int *rank = NULL;
  const memory_column arrays[] = {{&list, part->n_free, sizeof *list},
                                  {&rank, part->n_free, sizeof *rank}};
  const bool there = memory_resize(sizeof arrays / sizeof *arrays, arrays);
  sd_status status = there ? order_part(m, part, c, list) : SD_ERROR_IO;
  if (status != SD_OK) comm_fail(c, "no memory for the order of its disks");
  if (status == SD_OK) status = find_order(c, list, part->n_free, rank, order);
  free(list);
  free(rank);
  return status;
}
