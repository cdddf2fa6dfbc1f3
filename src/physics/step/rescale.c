/* rescale.c: multiplies all lengths of the region by a factor, and evaluates the forces of a system
 * that was changed between steps; implements rescale() and renew_forces() of step.h.
 *
 * Positions are multiplied by the factor; velocities and angles stay. The direction of a contact
 * between round bodies stays the same, and so does lambda. Along a wall the arc length of the
 * nearest point changes, and lambda_ref is changed by the same amount. So every tangential
 * displacement stays as it was, and only overlaps change. Contacts, forces and accelerations are
 * then evaluated in the new state, as at step 0.
 */

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/step.h"
#include "physics/system/bodies.h"
#include "physics/system/clumps.h"
#include "physics/system/fields.h"
#include "physics/system/halo.h"

static void scale_column(double *x, size_t n, double corner, double f) {
  for (size_t i = 0; i < n; i++) x[i] = corner + f * (x[i] - corner);
}

/* Changes lambda_ref of contacts with wall segments, in which the arc length of the nearest point
 * is multiplied by f: the tangential displacement stays the same. */
static void scale_arcs(engine *e, double f) {
  pairs *p = &e->work.pairs;
  for (size_t k = p->first_segment; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    const placed_segment *g = &e->work.segments[p->part[k]];
    double arc = walls_nearest(g, e->state->x[p->a[k]], e->state->y[p->a[k]]).arc - g->arc;
    pairs_shift_lambda(p, k, p->side[k] * ((f - 1.0) * arc));
  }
}

/* Sets the overlaps in the records of closed contacts to those with the new lengths, so that the
 * contact law does not take the change for a motion. */
static void renew_overlaps(engine *e) {
  pairs *p = &e->work.pairs;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    /* an overlap that was positive may become 0 but not negative, since the contact counts as
     * closed until the next evaluation */
    const double overlap = contact_geometry_of(e, k).overlap;
    PAIR(p, k, overlap) = PAIR(p, k, overlap) > 0.0 ? math_max(overlap, 0.0) : overlap;
  }
}

sd_status renew_forces(engine *e, sd_messages *messages) {
  work *w = &e->work;
  const sd_state *s = e->state;
  pairs *p = &w->pairs;
  double *before;
  if (e->halo) halo_refresh(e, NULL);
  const bool there = memory_row(&before, 2 * p->count, sizeof *before);
  if (!there) sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  if (comm_or(e->comm, !there)) {
    free(before);
    return SD_ERROR_IO;
  }
  for (size_t k = 0; k < p->count; k++) {
    before[k] = PAIR(p, k, viscous);
    before[p->count + k] = PAIR(p, k, nonconservative_work);
  }
  renew_overlaps(e);
  chunks_forces(e, CHUNKS_EVALUATE);
  if (cell_work(e, true) != SD_OK) {
    free(before);
    return SD_ERROR_IO;
  }
  for (size_t k = 0; k < p->count; k++) {
    PAIR(p, k, viscous) = before[k];
    PAIR(p, k, nonconservative_work) = before[p->count + k];
  }
  free(before);
  sd_status status = contacts_events(e, messages);
  body_forces_renew(e, 0, s->n_free);
  for (int k = 0; k < SD_COORDINATES; k++)
    for (size_t i = 0; i < s->n_free; i++) engine_accelerate(e, k, i, w->columns[k].force[i]);
  clumps_accelerate(e);
  if (e->halo) step_agree(e, false);
  return comm_agree(e->comm, status != SD_OK ? status : engine_status(e));
}

sd_status rescale(engine *e, double f, sd_messages *messages) {
  sd_state *s = e->state;
  assert(f > 0.0 && isfinite(f));
  scale_arcs(e, f);
  double corner[2] = {box_corner(e->model, SD_X), box_corner(e->model, SD_Y)};
  scale_column(s->x, s->n_bodies, corner[SD_X], f);
  scale_column(s->y, s->n_bodies, corner[SD_Y], f);
  scale_column(s->base_x, s->n_bodies, corner[SD_X], f);
  scale_column(s->base_y, s->n_bodies, corner[SD_Y], f);
  scale_column(s->clump_x, s->n_clumps, corner[SD_X], f);
  scale_column(s->clump_y, s->n_clumps, corner[SD_Y], f);
  scale_column(s->clump_base_x, s->n_clumps, corner[SD_X], f);
  scale_column(s->clump_base_y, s->n_clumps, corner[SD_Y], f);
  s->box_scale *= f;
  box_update(e);
  clumps_place_all(e); /* clumps move, but their size stays the same */
  walls_pose(e);
  const bool stale = comm_or(e->comm, !neighbours_rescale(e, f)) != 0;
  sd_status status = stale ? engine_renew(e, messages) : SD_OK;
  if (status == SD_OK) status = renew_forces(e, messages);
  if (validity_due(e->state->step) && status == SD_OK) validity_check_step(e);
  return status;
}
