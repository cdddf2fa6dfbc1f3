/* bonds.c: implements bonds.h. */
#include "physics/step/bonds.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "model/law_features.h"
#include "model/model.h"
#include "physics/contact/energy.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/system/bodies.h"
#include "physics/system/halo.h"

/* --- bonds that are made ---------------------------------------------------------------------- */

static const sd_contact_law *law_of(const engine *e, size_t k) {
  return &e->model->laws[PAIR(&e->work.pairs, k, law)];
}

/* Returns the point of pair k's wall segment that is nearest to its disk; *belongs: false if it
 * belongs to another segment. */
static nearest_point point_on_wall(const engine *e, size_t k, bool *belongs) {
  const work *w = &e->work;
  const double x = e->state->x[w->pairs.a[k]], y = e->state->y[w->pairs.a[k]];
  placed_segment image;
  const placed_segment *g = walls_image(w->length, &w->segments[w->pairs.part[k]], x, y, &image);
  const nearest_point q = walls_nearest(g, x, y);
  *belongs = joints_active(e, k, g, &q);
  return q;
}

/* Closes the open contact of candidate pair k at its present gap, without displacements or
 * forces. */
static void close_contact(engine *e, size_t k) {
  pairs *p = &e->work.pairs;
  const contact_geometry open = contact_geometry_of(e, k);
  bool belongs;
  PAIR(p, k, ex) = open.nx;
  PAIR(p, k, ey) = open.ny;
  if (pairs_is_segment(p, k)) p->side[k] = point_on_wall(e, k, &belongs).side;
  pairs_set_flags(p, k, true, 0);
  const contact_geometry g = contact_geometry_of(e, k);
  PAIR(p, k, lambda_ref) = g.lambda;
  PAIR(p, k, overlap) = g.overlap;
  MORE(p, k, rho_ref) = contact_rho_of(e, k);
}

void bonds_make(engine *e, size_t k) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  if (!law_bonds(law_of(e, k)) || MORE(p, k, bond) > 0.0) return;
  if (!pairs_closed(p, k)) close_contact(e, k);
  const contact_geometry g = contact_geometry_of(e, k);
  MORE(p, k, bond_overlap) = g.overlap;
  MORE(p, k, bond_lambda) = g.lambda;
  MORE(p, k, bond_rho) = contact_rho_of(e, k);
  MORE(p, k, bond) =
      bond_strength(law_of(e, k), bond_draw(e->model->seed, s->id[p->a[k]], s->id[p->b[k]]));
}

bool bonds_can(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  if (p->a[k] == PAIR_PADDING || !law_bonds(law_of(e, k))) return false;
  const size_t ends[2] = {(size_t)p->a[k], (size_t)p->b[k]};
  for (int n = 0; n < 2; n++)
    if (ends[n] < s->n_free && !body_in_play(s, ends[n])) return false;
  bool belongs = true;
  if (!pairs_closed(p, k) && pairs_is_segment(p, k)) point_on_wall(e, k, &belongs);
  if (!belongs) return false;
  return -contact_geometry_of(e, k).overlap <= law_of(e, k)->bond_gap;
}

static bool is_between(const sd_bonding *b, uint32_t body) {
  return bsearch(&body, b->between, b->n_between, sizeof body, model_by_number) != NULL;
}

/* True if the phase bonds these two bodies. */
static bool is_meant(const sd_bonding *b, uint32_t one, uint32_t two) {
  const uint32_t key[2] = {one < two ? one : two, one < two ? two : one};
  if (b->n_pairs > 0) return bsearch(key, b->pairs, b->n_pairs, sizeof key, model_by_pair) != NULL;
  return b->n_between == 0 || (is_between(b, one) && is_between(b, two));
}

sd_status bonds_begin_phase(engine *e, size_t *made) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const sd_bonding *b = &e->model->phases[s->phase].bond;
  if (!b->asked || b->later || !(e->work.features & LAW_BOND)) return SD_OK;
  if (e->halo) halo_refresh(e, NULL);
  for (size_t k = 0; k < p->count; k++) {
    if (!bonds_can(e, k) || !is_meant(b, s->id[p->a[k]], s->id[p->b[k]])) continue;
    bonds_make(e, k);
    *made += halo_counts(e, k);
  }
  return SD_OK;
}

sd_status bonds_sinter(engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const sd_bonding *b = &e->model->phases[s->phase].bond;
  if (!(e->work.features & LAW_BOND) || !b->sinter || !law_bonds(law_of(e, k))) return SD_OK;
  if (b->n_pairs == 0 && !is_meant(b, s->id[p->a[k]], s->id[p->b[k]])) return SD_OK;
  if (halo_is_ghost(e, (size_t)p->b[k]))
    return halo_wait_for(&e->halo->rebased, (halo_wait){.index = (uint32_t)k, .bonds = true});
  bonds_make(e, k);
  return SD_OK;
}

/* --- bonds that break ------------------------------------------------------------------------- */

/* One row of the list of broken bonds. */
typedef struct broken_bond {
  int64_t step;
  uint32_t a, b;
  int32_t mode;
  double x, y, energy;
} broken_bond;

static broken_bond row_at(const sd_state *s, size_t k) {
  return (broken_bond){s->break_step[k], s->break_a[k], s->break_b[k],     s->break_mode[k],
                       s->break_x[k],    s->break_y[k], s->break_energy[k]};
}

static void set_row(sd_state *s, size_t k, const broken_bond *row) {
  s->break_step[k] = row->step;
  s->break_a[k] = row->a;
  s->break_b[k] = row->b;
  s->break_mode[k] = row->mode;
  s->break_x[k] = row->x;
  s->break_y[k] = row->y;
  s->break_energy[k] = row->energy;
}

sd_status bonds_broke(engine *e, const event *v) {
  sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const size_t k = v->index;
  double *const losses[] = {s->broken_tension, s->broken_shear, s->broken_bending};
  const int32_t a = p->a[k], b = p->b[k];
  losses_share(e, losses[v->mode - 1], a, b, v->broken);
  if (!halo_counts(e, k)) return SD_OK;
  if (state_reserve_breaks(s, s->n_breaks + 1) != SD_OK) return SD_ERROR_IO;
  const uint32_t one = s->id[a], two = s->id[b];
  set_row(s, s->n_breaks++,
          &(broken_bond){s->step + 1, one < two ? one : two, one < two ? two : one, v->mode,
                         v->place[0], v->place[1], v->broken});
  if (!e->halo) return SD_OK;
  e->halo->bits |= HALO_BROKE;
  e->halo->n_broke++;
  return SD_OK;
}

static int by_bodies(const void *one, const void *two) {
  const broken_bond *p = one, *q = two;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  return p->b < q->b ? -1 : p->b > q->b;
}

/* Returns the first row of the last step in the list. */
static size_t first_of_step(const sd_state *s) {
  size_t first = s->n_breaks;
  while (first > 0 && s->break_step[first - 1] == s->break_step[s->n_breaks - 1]) first--;
  return first;
}

void bonds_sort(sd_state *s) {
  const size_t first = first_of_step(s), n = s->n_breaks - first;
  if (n < 2) return;
  broken_bond *rows = memory_new(n, sizeof *rows);
  for (size_t k = 0; k < n; k++) rows[k] = row_at(s, first + k);
  qsort(rows, n, sizeof *rows, by_bodies);
  for (size_t k = 0; k < n; k++) set_row(s, first + k, &rows[k]);
  free(rows);
}

sd_status bonds_gather(engine *e) {
  sd_state *s = e->state;
  const comm *c = e->halo->comm;
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  const size_t own = e->halo->n_broke;
  size_t n = 0;
  comm_gather_counts(c, (int)own, counts);
  for (int q = 0; q < comm_size(c); q++) n += (size_t)counts[q];
  broken_bond *mine = memory_new(own + 1, sizeof *mine), *all = memory_new(n + 1, sizeof *all);
  assert(own <= s->n_breaks);
  s->n_breaks -= own;
  e->halo->n_broke = 0;
  for (size_t k = 0; k < own; k++) mine[k] = row_at(s, s->n_breaks + k);
  comm_gather(c, mine, all, counts, sizeof *all);
  const sd_status status = comm_agree(c, state_reserve_breaks(s, s->n_breaks + n));
  for (size_t k = 0; status == SD_OK && k < n; k++) set_row(s, s->n_breaks++, &all[k]);
  bonds_sort(s);
  free(counts);
  free(mine);
  free(all);
  return status;
}
