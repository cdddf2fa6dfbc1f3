/* validity.c: checks of the neighbour lists and of completed steps; implements validity.h. */
#include "physics/neighbours/validity.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "physics/contact/energy.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/chunks.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"
#include "physics/system/clumps.h"
#include "physics/system/halo.h"

/* --- checks of lists that were just built ----------------------------------------------------- */

static bool in_play(const sd_state *s, size_t slot) {
  return slot >= s->n_free || body_in_play(s, slot);
}

/* --- slots ------------------------------------------------------------------------------------ */

/* Checks that every body has one slot: free disks first (with several ranks: own disks, then
 * ghosts), then driven disks, then walls. */
static void check_slots(const engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  const size_t free_disks = s->n_free + s->n_ghosts;
  assert(e->halo ? free_disks <= m->n_free : free_disks == m->n_free);
  assert(s->n_disks - free_disks == m->n_disks - m->n_free);
  assert(s->n_bodies - s->n_disks == sd_model_bodies(m) - m->n_disks);
  for (size_t slot = 0; slot < s->n_bodies; slot++) {
    const uint32_t id = s->id[slot];
    assert(id < sd_model_bodies(m) && slot_of(&e->work.slots, id) == slot);
    assert((id < m->n_disks) == (slot < s->n_disks));
    if (slot >= s->n_disks) continue;
    assert(m->disks[id].driven == (slot >= free_disks));
    assert(s->radius[slot] > 0.0 && s->mass[slot] > 0.0 && s->inertia[slot] > 0.0);
    assert(s->material[slot] >= 0 && (size_t)s->material[slot] < m->n_materials);
  }
}

/* --- pairs ------------------------------------------------------------------------------------ */

static bool ascends(const pairs *p, size_t k) {
  if (p->a[k - 1] != p->a[k]) return p->a[k - 1] < p->a[k];
  if (p->b[k - 1] != p->b[k]) return p->b[k - 1] < p->b[k];
  return p->part[k - 1] < p->part[k];
}

static void check_bodies(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const int32_t a = p->a[k], b = p->b[k];
  assert(a >= 0 && a < b && (size_t)a < s->n_free && (size_t)b < s->n_bodies);
  assert(in_play(s, (size_t)a) && in_play(s, (size_t)b));
  assert(PAIR(p, k, law) == s->material[a] * (int32_t)e->model->n_materials + s->material[b]);
  if (!pairs_is_segment(p, k)) {
    assert(p->part[k] == 0 && s->radius[b] != 0.0);
  } else {
    assert(p->part[k] >= 0 && (size_t)p->part[k] < e->model->n_segments);
    assert(s->id[b] == e->model->segments[p->part[k]].body && s->radius[b] == 0.0);
  }
}

static bool is_padding(const pairs *p, size_t k) {
  return (k >= p->n_round && k < p->first_ghost) || (k >= p->end_ghost && k < p->first_segment);
}

static void check_pairs(const engine *e) {
  const pairs *p = &e->work.pairs;
  assert(p->n_round <= p->first_ghost && p->first_ghost <= p->end_ghost &&
         p->end_ghost <= p->first_segment && p->first_segment <= p->count &&
         p->count <= p->capacity);
  assert(p->first_ghost % PAIR_BLOCK == 0 && p->first_ghost - p->n_round < PAIR_BLOCK);
  assert(p->first_segment % PAIR_BLOCK == 0 && p->first_segment - p->end_ghost < PAIR_BLOCK);
  for (size_t k = 0; k < p->count; k++) {
    if (is_padding(p, k)) {
      assert(p->a[k] == PAIR_PADDING && p->b[k] == PAIR_PADDING && p->part[k] == 0);
      continue;
    }
    check_bodies(e, k);
    assert(halo_is_ghost(e, (size_t)p->b[k]) == (k >= p->first_ghost && k < p->end_ghost));
    assert(k == 0 || k == p->first_ghost || k == p->first_segment || ascends(p, k));
  }
}

static bool is_zero(const sd_contact_record *r) {
#define ZERO(name, unit, meaning) &&r->name == 0.0
  return true SD_CONTACT_RECORD(ZERO);
#undef ZERO
}

/* Checks the contact records that were carried over from the old list: the direction of a closed
 * contact is a unit vector, the record of an open pair is zero. Before the first step the direction
 * may come from a file and is not checked. */
static void check_memory(const engine *e) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < p->count; k++) {
    const sd_contact_record r = pairs_record(p, k);
    if (pairs_closed(p, k))
      assert(p->a[k] >= 0 && (e->state->step == 0 || fabs(r.ex * r.ex + r.ey * r.ey - 1.0) < 1e-9));
    else
      assert(is_zero(&r) && p->side[k] == 0.0 && pairs_slide_sign(p, k) == 0);
  }
}

/* --- missing candidates ----------------------------------------------------------------------- */

static bool is_listed_pair(const engine *e, size_t i, size_t j) {
  const incidence *n = &e->work.incidence;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
    const size_t k = n->entry[at] / 2;
    if ((size_t)(n->entry[at] & 1 ? e->work.pairs.a[k] : e->work.pairs.b[k]) == j) return true;
  }
  return false;
}

/* Checks that all disks within the Verlet margin of disk i are in the list of candidates. */
static void check_near(const engine *e, size_t i) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  if (!in_play(s, i)) return;
  for (size_t j = 0; j < s->n_disks; j++) {
    if (j == i || !in_play(s, j) || clumps_same(e, i, j)) continue;
    double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
    box_nearest(w, &dx, &dy);
    const double reach = (s->radius[i] + s->radius[j] + w->skin + w->margin) * (1.0 - 1e-12);
    assert(dx * dx + dy * dy >= reach * reach || is_listed_pair(e, i, j));
  }
}

/* Limits of the check for missing candidates. All disks are checked if there are fewer than
 * NEAR_ALL; otherwise only NEAR_SOME, different ones for each new list. */
enum { NEAR_ALL = 64, NEAR_SOME = 8 };
static void check_candidates(const engine *e) {
  const size_t n = e->state->n_free, some = n < NEAR_ALL ? n : NEAR_SOME;
  for (size_t k = 0; k < some; k++)
    check_near(e, n < NEAR_ALL ? k : ((size_t)e->work.builds * NEAR_SOME + k) * 7919 % n);
}

/* --- contacts of each body -------------------------------------------------------------------- */

/* Returns true if two consecutive contacts of a body are in order. With several ranks, contacts of
 * a free disk with round bodies are sorted by the global slots of the partners, those of a run on
 * one rank; all others are in the order of pairs. */
static bool follows(const engine *e, size_t slot, uint32_t first, uint32_t second) {
  const pairs *p = &e->work.pairs;
  const size_t one = (size_t)(first & 1 ? p->a[first / 2] : p->b[first / 2]);
  const size_t two = (size_t)(second & 1 ? p->a[second / 2] : p->b[second / 2]);
  if (!e->halo || slot >= e->state->n_free || pairs_is_segment(p, second / 2))
    return first / 2 < second / 2;
  return halo_order(e, one) < halo_order(e, two);
}

/* Checks that the contacts of each body are in order, and that each pair occurs once in the
 * contacts of each of its two bodies. */
static void check_incidence(const engine *e) {
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  const size_t padding = p->first_ghost - p->n_round + p->first_segment - p->end_ghost;
  assert(n->start[0] == 0 && n->start[e->state->n_bodies] == 2 * (p->count - padding));
  assert(n->start[e->state->n_bodies] <= n->capacity);
  for (size_t slot = 0; slot < e->state->n_bodies; slot++)
    for (size_t at = n->start[slot]; at < n->start[slot + 1]; at++) {
      const size_t k = n->entry[at] / 2;
      assert(k < p->count && (size_t)(n->entry[at] & 1 ? p->b[k] : p->a[k]) == slot);
      assert(at == n->start[slot] || follows(e, slot, n->entry[at - 1], n->entry[at]));
    }
}

static void check_watched(const engine *e) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < 2 * e->model->n_slides; k++) {
    const int64_t at = e->work.watched[k];
    const sd_slide_watch *watch = &e->model->slides[k / 2];
    if (at < 0) continue;
    assert((size_t)at < p->count);
    const uint32_t a = e->state->id[p->a[at]], b = e->state->id[p->b[at]];
    assert((a == watch->disk && b == watch->partner[k % 2]) ||
           (b == watch->disk && a == watch->partner[k % 2]));
  }
}

/* --- chunks ----------------------------------------------------------------------------------- */

/* Checks that the chunks cover the free disks and all pairs, in whole blocks. */
static void check_cover(const engine *e) {
  const chunks *c = &e->work.chunks;
  const pairs *p = &e->work.pairs;
  assert(c->count <= c->capacity && c->n_threads == e->work.n_threads && c->size % CHUNK_STEP == 0);
  assert(c->begin[0] == 0 && c->begin[c->count] == e->state->n_free);
  assert(c->share[0] == 0 && c->share[c->n_threads] == c->count);
  for (int t = 0; t < c->n_threads; t++) assert(c->share[t] <= c->share[t + 1]);
  assert(c->segment[c->count] == p->count && c->pair[c->count] == p->first_ghost);
  if (c->count > 0) assert(c->pair[0] == 0 && c->segment[0] == p->first_segment);
  for (size_t k = 0; k < c->count; k++) {
    assert(c->begin[k] % CHUNK_STEP == 0 && c->begin[k] < c->begin[k + 1]);
    assert(c->begin[k + 1] - c->begin[k] <= c->size);
    assert(c->pair[k] <= c->pair[k + 1] && c->pair[k] % PAIR_BLOCK == 0 &&
           c->segment[k] <= c->segment[k + 1]);
    for (size_t slot = c->begin[k]; slot < c->begin[k + 1]; slot += CHUNK_STEP)
      assert(chunks_of_disk(c, slot) == k);
  }
}

static bool needs(const chunks *c, size_t k, size_t other) {
  for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
    if (c->need[n] == other) return true;
  return false;
}

/* Checks a pair that chunk k evaluates; `end` is the end of the thread's range of chunks. All
 * forces on both disks must be known when they are corrected: disks in chunks of other threads are
 * corrected at the end of the step, disks of the same thread not before chunk k. */
static void check_reader(const engine *e, size_t k, size_t end, size_t pair) {
  const chunks *c = &e->work.chunks;
  const pairs *p = &e->work.pairs;
  if (p->a[pair] == PAIR_PADDING) return;
  assert((size_t)p->a[pair] >= c->begin[k]);
  for (int side = 0; side < 2; side++) {
    const size_t slot = (size_t)(side ? p->b[pair] : p->a[pair]);
    if (slot >= e->state->n_free) continue;
    const size_t of = chunks_of_disk(c, slot);
    const int32_t sum = side ? PAIR(p, pair, sum_b) : PAIR(p, pair, sum_a);
    assert(of >= k && needs(c, k, of));
    if (of < end) continue;
    assert(c->boundary_last[of] && c->boundary_first[of] && c->any_boundary_first);
    /* There is a row of sums for the forces of this contact. */
    assert((size_t)sum / SUM_ROW >= rows_of_bodies(e));
  }
}

static void check_readers(const engine *e) {
  const chunks *c = &e->work.chunks;
  for (int t = 0; t < c->n_threads; t++)
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
      assert(needs(c, k, k));
      for (size_t at = c->pair[k]; at < c->pair[k + 1]; at++) {
        check_reader(e, k, c->share[t + 1], at);
        /* only the last block has pairs of disks in later chunks */
        assert(at % PAIR_BLOCK || e->work.pairs.a[at] < (int32_t)c->begin[k + 1]);
      }
      for (size_t at = c->segment[k]; at < c->segment[k + 1]; at++) {
        check_reader(e, k, c->share[t + 1], at);
        assert((size_t)e->work.pairs.a[at] < c->begin[k + 1]);
      }
    }
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Checks that chunks which share rows never need them at the same time. Chunk k needs its rows
 * while chunks from[k] to to[k] are evaluated; both arrays are filled here. */
static void check_lifetimes(const chunks *c, size_t *from, size_t *to) {
  for (size_t k = 0; k < c->count; k++) {
    const bool kept = c->boundary_first[k] || c->boundary_last[k];
    from[k] = kept ? 0 : SIZE_MAX;
    to[k] = kept ? SIZE_MAX : 0;
  }
  for (size_t k = 0; k < c->count; k++)
    for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++) {
      if (from[c->need[n]] > k) from[c->need[n]] = k;
      if (to[c->need[n]] < k) to[c->need[n]] = k;
    }
  for (size_t k = 0; k < c->count; k++)
    for (size_t j = 0; j < k; j++) {
      const size_t apart = c->row[j] < c->row[k] ? c->row[k] - c->row[j] : c->row[j] - c->row[k];
      assert(apart >= c->size || to[j] < from[k] || to[k] < from[j]);
    }
}

static void check_chunk_rows(const engine *e) {
  const chunks *c = &e->work.chunks;
  for (size_t k = 0; k < c->count; k++)
    assert(c->row[k] < c->rows && c->row[k] + (c->begin[k + 1] - c->begin[k]) <= c->rows);
  assert(c->shares || c->rows == e->state->n_free);
  if (!c->shares) return;
  size_t *life = memory_new(2 * c->count, sizeof *life);
  check_lifetimes(c, life, life + c->count);
  free(life);
}

/* Checks that the row of every body is in the table, and that every pair has the offsets of the
 * rows of its two bodies. */
static void check_rows(const engine *e) {
  const work *w = &e->work;
  const chunks *c = &w->chunks;
  const pairs *p = &w->pairs;
  const size_t n_free = e->state->n_free, n_bodies = e->state->n_bodies;
  assert(rows_of_bodies(e) <= w->packed_capacity && rows_of_bodies(e) <= w->sums.end);
  assert(w->sums.end <= w->sums.capacity);
  for (size_t k = 0; k < c->count; k++)
    for (size_t slot = c->begin[k]; slot < c->begin[k + 1]; slot++)
      assert((size_t)w->row[slot] == c->row[k] + slot - c->begin[k]);
  for (size_t slot = n_free; slot <= n_bodies; slot++)
    assert((size_t)w->row[slot] == c->rows + slot - n_free);
  assert((size_t)w->row[n_bodies] + 1 == rows_of_bodies(e)); /* the last row is that of padding */
  for (size_t k = 0; k < p->count; k++) {
    const bool padding = p->a[k] == PAIR_PADDING;
    const int32_t a = w->row[padding ? n_bodies : (size_t)p->a[k]];
    const int32_t b = w->row[padding ? n_bodies : (size_t)p->b[k]];
    assert(PAIR(p, k, packed_a) == PACKED_ROW * a && PAIR(p, k, packed_b) == PACKED_ROW * b);
    if (padding) assert(PAIR(p, k, sum_a) == SUM_ROW * a && PAIR(p, k, sum_b) == SUM_ROW * b);
  }
  for (int r = 0; r < PACKED_ROW; r++)
    assert(w->packed[PACKED_ROW * (size_t)w->row[n_bodies] + (size_t)r] == 0.0);
}

/* Checks that the forces of contacts on the body in this slot go to the right rows: all to the row
 * of the body or, if the body is listed, each to its own row, beginning with row `single`. */
static void check_sum_rows(const engine *e, size_t slot, bool listed, size_t single) {
  const incidence *n = &e->work.incidence;
  for (size_t at = n->start[slot]; at < n->start[slot + 1]; at++) {
    const size_t k = n->entry[at] / 2;
    const size_t row = listed ? single + (at - n->start[slot]) : (size_t)e->work.row[slot];
    const int32_t sum =
        n->entry[at] & 1 ? PAIR(&e->work.pairs, k, sum_b) : PAIR(&e->work.pairs, k, sum_a);
    assert((size_t)sum == SUM_ROW * row);
  }
}

static void check_sums(const engine *e) {
  const sums *m = &e->work.sums;
  const chunks *c = &e->work.chunks;
  const incidence *n = &e->work.incidence;
  size_t k = 0;
  for (size_t slot = 0; slot < e->state->n_bodies; slot++) {
    const bool listed = k < m->n_listed && m->listed[k] == slot;
    /* prescribed bodies have one row of forces per contact */
    assert(listed || slot < e->state->n_free);
    check_sum_rows(e, slot, listed, listed ? m->single[k] : 0);
    if (!listed) continue;
    assert(slot >= e->state->n_free || c->boundary_last[chunks_of_disk(c, slot)]);
    assert(m->single[k + 1] - m->single[k] == n->start[slot + 1] - n->start[slot]);
    k++;
  }
  assert(k == m->n_listed && m->single[0] == rows_of_bodies(e) && m->single[k] == m->end);
}

void validity_check_lists(const engine *e) {
  check_slots(e);
  check_pairs(e);
  check_memory(e);
  check_incidence(e);
  check_candidates(e);
  check_watched(e);
  check_cover(e);
  check_readers(e);
  check_chunk_rows(e);
  check_rows(e);
  check_sums(e);
}

/* --- checks after a step ---------------------------------------------------------------------- */

static const double ROUNDING = 1e-9;

/* --- state ------------------------------------------------------------------------------------ */

/* Returns true if a pose or velocity is not a number, or beyond 1e100: the run has blown up. The
 * next call of neighbours_check_finite reports it. */
static bool has_blown_up(const sd_state *s) {
  for (size_t i = 0; i < s->n_bodies; i++) {
    const double at[] = {s->x[i], s->y[i], s->theta[i], s->vx[i], s->vy[i], s->omega[i]};
    for (size_t k = 0; k < sizeof at / sizeof *at; k++)
      if (!(fabs(at[k]) < 1e100)) return true;
  }
  return false;
}

/* Checks that columns of the run, of bodies, of disks and of motions are finite; the static
 * assertion is about the order of enum values that the check uses. Columns of measured data are
 * left out, as they may be infinite if nothing was measured; columns of contacts, too, as they are
 * only filled when the state is requested. */
_Static_assert(SD_PER_FREE<SD_PER_MOTION && SD_PER_PHASE> SD_PER_MOTION, "extents");
static void check_numbers(const sd_state *s) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const double *column = sd_field_data(s, f);
    if (f->type != SD_F64 || f->extent == SD_PER_CONTACT ||
        (f->extent > SD_PER_MOTION && f->extent != SD_PER_LAW_FREE))
      continue;
    for (size_t i = 0; i < sd_extent_size(s, f->extent); i++) assert(isfinite(column[i]));
  }
}

static void check_run(const engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  assert(s->step > 0 && s->phase >= 0 && (size_t)s->phase < m->n_phases);
  assert(s->phase_step >= 0 && s->phase_step <= s->step && s->measured >= 0 &&
         s->measured <= s->step);
  assert(s->bins >= 0 && s->bins < SD_BINS && s->bin_steps > 0 &&
         (s->bin_steps & (s->bin_steps - 1)) == 0);
  assert(s->mean_bins >= 0 && s->mean_bins < SD_MEAN_BINS && s->mean_bin_steps > 0);
  assert(s->box_scale > 0.0 && s->n_contacts <= s->contact_capacity && s->outside >= 0);
  assert(s->fast_step >= -1 && s->fast_step <= s->step &&
         s->fast_disk < (int64_t)(m->n_disks + m->n_walls));
  for (size_t k = 0; k < s->n_motions; k++)
    assert(s->motion_start[k] >= -1 && s->motion_start[k] <= s->step);
}

/* Checks that angles are in [-4, 4] rad, that positions are in the periodic box, and that disks
 * which are not in the simulation are at rest. */
static void check_poses(const engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  for (size_t i = 0; i < s->n_bodies; i++) {
    assert(remainder(s->turn[i], 8.0) == 0.0);
    if (i < s->n_free) assert(s->activity[i] >= SD_IN_PLAY && s->activity[i] <= SD_HELD);
    if (i >= s->n_free) continue;
    if (!body_in_play(s, i)) {
      assert(s->vx[i] == 0.0 && s->vy[i] == 0.0 && s->omega[i] == 0.0);
      assert(w->inverse_mass_x[i] == 0.0 && w->inverse_mass_y[i] == 0.0 &&
             w->inverse_inertia[i] == 0.0);
      continue;
    }
    assert(fabs(s->theta[i]) <= 4.0);
    /* a position just below the lower edge plus the box length may round to the upper edge */
    if (w->periodic[0]) assert(s->x[i] >= w->lower[0] && s->x[i] <= w->upper[0]);
    if (w->periodic[1]) assert(s->y[i] >= w->lower[1] && s->y[i] <= w->upper[1]);
  }
}

static void check_energies(const engine *e) {
  const sd_energy sum = energy_of_part(e);
  assert(sum.kinetic_translation >= 0.0 && sum.kinetic_rotation >= 0.0);
  assert(sum.elastic_normal >= 0.0 && sum.elastic_tangential >= 0.0);
  assert(isfinite(sum.external) && isfinite(sum.residual) && isfinite(sum.scale));
}

/* --- contacts --------------------------------------------------------------------------------- */

/* Checks a closed contact: its direction is a unit vector, its force does not pull, its overlap is
 * within the limit, and its tangential displacement zeta is within Coulomb's limit, and equal to it
 * if the contact slides. */
static void check_closed(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const pairs *p = &w->pairs;
  const int32_t a = p->a[k], b = p->b[k];
  const sd_contact_record r = pairs_record(p, k);
  const double ra = s->radius[a], rb = fabs(s->radius[b]), least = rb > 0.0 && rb < ra ? rb : ra;
  const law_row *law = &w->laws[PAIR(p, k, law)];
  const bool general = (w->features & LAW_GENERAL) != 0;
  const bool bonded = r.bond > 0.0;
  const double cap = law->cap * r.force;
  const double force = r.force + r.bond_pull, tau = r.tau + r.bond_shear,
               roll = r.roll + r.bond_bend;
  const int sign = pairs_slide_sign(p, k);
  assert(fabs(r.ex * r.ex + r.ey * r.ey - 1.0) < ROUNDING);
  assert(r.overlap <= e->model->max_overlap * least &&
         (bonded ? r.overlap > -w->margin * (1.0 + ROUNDING)
                 : r.overlap > -law->ends * (1.0 + ROUNDING)));
  if (general) {
    /* differences of these forces may be rounding errors */
    const double slack = ROUNDING * (r.pull + fabs(r.bond_pull)),
                 sheared = ROUNDING * fabs(r.bond_shear), bent = ROUNDING * fabs(r.bond_bend);
    const double limit = math_max(force + r.pull, 0.0) + slack;
    assert(law->pulls > 0.0 || force + r.pull >= -slack);
    assert(r.pull >= 0.0 && r.pull <= law->pull_off && (r.overlap > 0.0 || limit <= 2.0 * slack));
    const double rubs = math_max(limit - law->critical_load, 0.0) + ROUNDING * law->critical_load;
    assert(fabs(tau) <= law->cap * law->k_t * rubs * (1.0 + ROUNDING) + sheared);
    assert(law->drag_r > 0.0 ||
           fabs(roll) <= law->cap_r * law->k_r * limit * (1.0 + ROUNDING) + bent);
    assert(bonded || (r.bond_pull == 0.0 && r.bond_shear == 0.0 && r.bond_bend == 0.0));
  } else {
    assert(r.force >= 0.0 && r.overlap > 0.0 && r.pull == 0.0 && r.roll == 0.0);
    assert(fabs(r.zeta) <= cap * (1.0 + ROUNDING));
    /* zeta and the torque -k_t zeta have opposite signs */
    assert(sign == 0 || fabs(r.zeta + sign * cap) <= cap * ROUNDING);
  }
  assert(fabs(r.turned) < 0.1 && (!w->conservative || r.turned == 0.0));
  assert(!w->conservative || r.nonconservative_work == 0.0);
  assert(isfinite(r.lambda_ref) && isfinite(r.viscous) && isfinite(r.friction) &&
         isfinite(r.nonconservative_work));
  assert(pairs_is_segment(p, k) ? fabs(p->side[k]) == 1.0 : p->side[k] == 0.0);
}

/* Checks that an open pair, or padding, has a record of zeros. */
static void check_open(const pairs *p, size_t k) {
  for (size_t c = 0; c < SD_CONTACT_COLUMNS; c++) assert(PAIR(p, k, record[c]) == 0.0);
  for (size_t c = 0; p->more && c < SD_CONTACT_EXTRA; c++) assert(MORE(p, k, record[c]) == 0.0);
  assert(pairs_slide_sign(p, k) == 0 && p->side[k] == 0.0);
}

static void check_contacts(const engine *e) {
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < p->count; k++) {
    const pair_flags *flags = &p->flags[pairs_flags_at(p, k)];
    assert((flags->slides_positive & flags->slides_negative) == 0);
    assert(((flags->slides_positive | flags->slides_negative) & ~flags->closed) == 0);
    if (pairs_is_segment(p, k)) assert(flags->closed <= 1);
    if (pairs_closed(p, k)) {
      assert(p->a[k] != PAIR_PADDING);
      check_closed(e, k);
    } else {
      check_open(p, k);
    }
  }
}

static double gap_of(const engine *e, size_t i, size_t j) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
  box_nearest(w, &dx, &dy);
  return math_hypot(dx, dy) - s->radius[i] - s->radius[j];
}

static bool is_candidate(const engine *e, size_t i, size_t j) {
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++)
    if ((size_t)(n->entry[at] & 1 ? p->a[n->entry[at] / 2] : p->b[n->entry[at] / 2]) == j)
      return true;
  return false;
}

/* Checks, for a few disks, that pairs which are not candidates do not touch. With Gear's integrator
 * this is not checked: its lists are valid for the predicted positions, at which forces are
 * evaluated, not for the corrected ones. Ghosts are left out, since their positions in the state
 * are from before the step. */
static void check_gaps(const engine *e) {
  const sd_state *s = e->state;
  if (e->model->integrator != SD_VERLET || s->n_free == 0) return;
  for (size_t k = 0; k < 4; k++) {
    const size_t i = ((size_t)s->step * 4 + k) * 7919 % s->n_free;
    for (size_t j = 0; body_in_play(s, i) && j < s->n_disks; j++)
      if (j != i && !halo_is_ghost(e, j) && (j >= s->n_free || body_in_play(s, j)))
        assert(gap_of(e, i, j) > 0.0 || is_candidate(e, i, j) || clumps_same(e, i, j));
  }
}

/* --- force sums ------------------------------------------------------------------------------- */

/* Checks, for each body whose contacts have their own rows of forces, that the body's row is the
 * sum of these rows, in their order, and that a prescribed body has the same force in the state.
 * With several ranks prescribed bodies are not checked, since they have contacts on other ranks,
 * too. */
static void check_force_sums(const engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const sums *m = &w->sums;
  for (size_t n = 0; n < m->n_listed; n++) {
    const size_t slot = m->listed[n];
    if (e->halo && slot >= s->n_free) break;
    const double *row = m->row + SUM_ROW * (size_t)w->row[slot];
    double sum[SUM_ROW] = {0.0};
    for (size_t at = m->single[n]; at < m->single[n + 1]; at++)
      for (size_t c = 0; c < SUM_ROW; c++) sum[c] += m->row[SUM_ROW * at + c];
    for (size_t c = 0; c < SUM_ROW; c++) assert(row[c] == sum[c]);
    if (slot < s->n_free) continue;
    assert(s->force_x[slot] == sum[SUM_X] && s->force_y[slot] == sum[SUM_Y]);
    const double turn =
        s->radius[slot] != 0.0 ? sum[SUM_TORQUE] * s->radius[slot] : sum[SUM_TORQUE];
    assert(s->torque[slot] == turn || s->torque[slot] == turn + sum[SUM_COUPLE]);
  }
}

/* Checks that the coordinates of all disks were predicted for the same step, and that no rare event
 * is left to be handled. */
static void check_work(const work *w) {
  for (size_t k = 0; k < w->chunks.count; k++)
    assert(w->chunks.predicted[k] == w->chunks.predicted[0]);
  for (int t = 0; t < w->n_threads; t++) {
    assert(w->threads[t].events.count == 0 && w->threads[t].returns.count == 0);
    assert(!w->threads[t].events.failed && !w->threads[t].returns.failed && !w->threads[t].fast);
  }
  assert(w->skin > 0.0 && w->builds > 0 && w->list_scale > 0.0);
}

void validity_check_step(const engine *e) {
  if (has_blown_up(e->state)) return;
  check_run(e);
  check_numbers(e->state);
  check_poses(e);
  check_work(&e->work);
  check_contacts(e);
  check_gaps(e);
  check_force_sums(e);
  check_energies(e);
}
