/* validity_step.c: state and contacts after a step; see validity.h. */
#include "physics/neighbours/validity.h"

#include <assert.h>
#include <math.h>

#include "model/law_features.h"
#include "physics/contact/energy.h"
#include "physics/contact/pairs.h"
#include "physics/system/bodies.h"
#include "physics/system/box.h"
#include "physics/system/clumps.h"
#include "physics/system/halo.h"

static const double ROUNDING = 1e-9;

/* --- state ----------------------------------------------------------------------------------------------- */

/* A pose or velocity that is not a number, or beyond all bounds, means that the run has blown up: the next look at
 * the poses says so (neighbours_check_finite). */
static bool has_blown_up(const sd_state *s) {
  for (size_t i = 0; i < s->n_bodies; i++) {
    const double at[] = {s->x[i], s->y[i], s->theta[i], s->vx[i], s->vy[i], s->omega[i]};
    for (size_t k = 0; k < sizeof at / sizeof *at; k++)
      if (!(fabs(at[k]) < 1e100)) return true;
  }
  return false;
}

/* Then all other columns are numbers, too: those of the run, bodies, disks and motions. (What was measured may be infinite
 * where there was nothing to measure; columns of contacts are filled when the state is asked for.) */
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
  assert(s->phase_step >= 0 && s->phase_step <= s->step && s->measured >= 0 && s->measured <= s->step);
  assert(s->bins >= 0 && s->bins < SD_BINS && s->bin_steps > 0 && (s->bin_steps & (s->bin_steps - 1)) == 0);
  assert(s->mean_bins >= 0 && s->mean_bins < SD_MEAN_BINS && s->mean_bin_steps > 0);
  assert(s->box_scale > 0.0 && s->n_contacts <= s->contact_capacity && s->outside >= 0);
  assert(s->fast_step >= -1 && s->fast_step <= s->step && s->fast_disk < (int64_t)(m->n_disks + m->n_walls));
  for (size_t k = 0; k < s->n_motions; k++) assert(s->motion_start[k] >= -1 && s->motion_start[k] <= s->step);
}

/* Angles within half a turn of 8 rad, positions within the box; disks that are out of play stand still. */
static void check_poses(const engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  for (size_t i = 0; i < s->n_bodies; i++) {
    assert(remainder(s->turn[i], 8.0) == 0.0);
    if (i < s->n_free) assert(s->activity[i] >= SD_IN_PLAY && s->activity[i] <= SD_OUTSIDE);
    if (i >= s->n_free) continue;
    if (!body_in_play(s, i)) {
      assert(s->vx[i] == 0.0 && s->vy[i] == 0.0 && s->omega[i] == 0.0);
      assert(w->inverse_mass_x[i] == 0.0 && w->inverse_mass_y[i] == 0.0 && w->inverse_inertia[i] == 0.0);
      continue;
    }
    assert(fabs(s->theta[i]) <= 4.0);
    /* a whole box length added to a position just below the lower edge may round to the upper one */
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

/* --- contacts -------------------------------------------------------------------------------------------- */

/* Closed: a direction, a force that does not pull, an overlap within the limit, zeta within Amonton's cap, which it has
 * reached where the contact slides. */
static void check_closed(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const pairs *p = &w->pairs;
  const int32_t a = p->a[k], b = p->b[k];
  const sd_contact_record r = pairs_record(p, k);
  const double ra = s->radius[a], rb = fabs(s->radius[b]), least = rb > 0.0 && rb < ra ? rb : ra;
  const law_row *law = &w->laws[PAIR(p, k, law)];
  const bool general = (w->features & LAW_GENERAL) != 0;
  const double cap = law->cap * r.force;
  const int sign = pairs_slide_sign(p, k);
  assert(fabs(r.ex * r.ex + r.ey * r.ey - 1.0) < ROUNDING);
  assert(r.overlap <= e->model->max_overlap * least && r.overlap > -law->ends * (1.0 + ROUNDING));
  if (general) {
    const double limit = fmax(r.force + r.pull, 0.0);
    assert(law->pulls > 0.0 || r.force + r.pull >= -ROUNDING * r.pull);
    assert(r.pull >= 0.0 && r.pull <= law->pull_off && (r.overlap > 0.0 || limit <= ROUNDING * r.pull));
    assert(fabs(r.tau) <= law->cap * law->k_t * (limit + ROUNDING * r.pull) * (1.0 + ROUNDING));
    assert(fabs(r.roll) <= law->cap_r * law->k_r * (limit + ROUNDING * r.pull) * (1.0 + ROUNDING));
  } else {
    assert(r.force >= 0.0 && r.overlap > 0.0 && r.pull == 0.0 && r.roll == 0.0);
    assert(fabs(r.zeta) <= cap * (1.0 + ROUNDING));
    assert(sign == 0 || fabs(r.zeta + sign * cap) <= cap * ROUNDING); /* torque is -k_t zeta */
  }
  assert(fabs(r.turned) < 0.1 && (!w->conservative || r.turned == 0.0));
  assert(!w->conservative || r.nonconservative_work == 0.0);
  assert(isfinite(r.lambda_ref) && isfinite(r.viscous) && isfinite(r.friction) &&
         isfinite(r.nonconservative_work));
  assert(pairs_is_segment(p, k) ? fabs(p->side[k]) == 1.0 : p->side[k] == 0.0);
}

/* An open contact remembers nothing, and the padding never touches. */
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
  return hypot(dx, dy) - s->radius[i] - s->radius[j];
}

static bool is_candidate(const engine *e, size_t i, size_t j) {
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++)
    if ((size_t)(n->entry[at] & 1 ? p->a[n->entry[at] / 2] : p->b[n->entry[at] / 2]) == j) return true;
  return false;
}

/* Pairs that are no candidates do not touch: the lists are renewed in time. With Gear only forces see the predicted
 * positions, about which the lists promise something. Ghosts' positions in the state are older. */
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

/* --- sums ------------------------------------------------------------------------------------------------ */

/* The row of a listed body is the sum of its contacts' rows, in their order; that of a prescribed body is in the state (or has
 * contacts on other ranks). */
static void check_sums(const engine *e) {
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
    const double turn = s->radius[slot] != 0.0 ? sum[SUM_TURN] * s->radius[slot] : sum[SUM_TURN];
    assert(s->torque[slot] == turn || s->torque[slot] == turn + sum[SUM_COUPLE]);
  }
}

/* All disks were predicted for the same step, and rare events are treated. */
static void check_work(const work *w) {
  for (size_t k = 0; k < w->chunks.count; k++) assert(w->chunks.predicted[k] == w->chunks.predicted[0]);
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
  check_sums(e);
  check_energies(e);
}
