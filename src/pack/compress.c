/* compress.c: changes of the lengths of a region; see compress.h.
 *
 * A change maps the state: positions by the factor, velocities and angles not at all. Round pairs keep their
 * direction, hence lambda; along a line the arc length of the nearest point changes and lambda* follows. So every
 * stretch stays as it was, and only overlaps change. Contacts, forces and accelerations are then those of the
 * mapped state, as they are at step 0.
 */
#include "pack/compress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/normal_laws.h"
#include "pack/rain.h"
#include "physics/system/bodies.h"
#include "physics/step/contacts.h"
#include "physics/contact/energy.h"
#include "physics/contact/evaluate.h"
#include "physics/step/engine.h"
#include "physics/system/kernels.h"
#include "physics/neighbours/neighbours.h"
#include "physics/contact/pairs.h"
#include "physics/step/sweep.h"
#include "physics/contact/walls.h"

/* Part of the missing pressure that one change would bring if all disks followed it. */
static const double GAIN = 0.1;
/* Within this part of the tolerance nothing is changed, so that forces can come to balance. */
static const double QUIET = 0.5;

/* --- pressure and packing fraction -------------------------------------------------------------------- */

static double area_of(const sd_model *m, const sd_state *s) {
  double width = m->region_upper[0] - m->region_lower[0], height = m->region_upper[1] - m->region_lower[1];
  return width * height * s->box_scale * s->box_scale;
}

typedef struct virial {
  double pressure, stiffness; /* stiffness: of an affine change, - dp/d ln(length) */
} virial;

static virial virial_of(const engine *e) {
  const pairs *p = &e->work.pairs;
  const sd_state *s = e->state;
  double force = 0.0, stiffness = 0.0, twice = 2.0 * area_of(e->model, s);
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    bool disk = (size_t)p->b[k] < s->n_disks;
    double r = s->radius[p->a[k]] + (disk ? s->radius[p->b[k]] : 0.0) - PAIR(p, k, overlap);
    force += PAIR(p, k, force) * r;
    stiffness += law_stiffness(&e->model->laws[PAIR(p, k, law)], PAIR(p, k, overlap)) * r * r;
  }
  return (virial){force / twice, (stiffness + 2.0 * force) / twice};
}

double compress_pressure(const engine *e) { return virial_of(e).pressure; }

double compress_stored_pressure(const sd_model *m, const sd_state *s) {
  double force = 0.0;
  for (size_t c = 0; c < s->n_contacts; c++) {
    uint32_t a = s->contact_a[c], b = s->contact_b[c];
    double r = m->disks[a].radius + (b < m->n_disks ? m->disks[b].radius : 0.0) - s->contact_overlap[c];
    force += s->contact_force[c] * r;
  }
  return force / (2.0 * area_of(m, s));
}

double compress_fraction(const sd_model *m, const sd_state *s) {
  double sum = 0.0;
  for (size_t i = 0; i < s->n_free; i++)
    if (body_in_play(s, i)) sum += s->radius[i] * s->radius[i];
  return M_PI * sum / area_of(m, s);
}

/* --- target ------------------------------------------------------------------------------------------- */

static const sd_compress *target_of(const engine *e) { return &e->model->phases[e->state->phase].compress; }

bool compress_done(const engine *e) {
  const sd_compress *c = target_of(e);
  if (c->pressure > 0.0) return fabs(compress_pressure(e) - c->pressure) <= c->tolerance * c->pressure;
  return fabs(compress_fraction(e->model, e->state) - c->fraction) <= c->tolerance * c->fraction;
}

/* By what the lengths change now: as the rate allows, less near the target. */
static double factor(const engine *e) {
  const sd_compress *c = target_of(e);
  double most = c->rate * e->model->dt * COMPRESS_EVERY, shrink;
  if (c->pressure > 0.0) {
    virial now = virial_of(e);
    double missing = c->pressure - now.pressure;
    if (fabs(missing) <= QUIET * c->tolerance * c->pressure) return 1.0;
    shrink = now.stiffness > 0.0 ? GAIN * missing / now.stiffness : most;
  } else {
    shrink = 1.0 - sqrt(compress_fraction(e->model, e->state) / c->fraction);
    if (fabs(shrink) < 1e-14) return 1.0; /* rounding */
  }
  return 1.0 - fmin(fmax(shrink, -most), most);
}

/* --- change of the lengths ---------------------------------------------------------------------------- */

/* As at the start (check_box of model.c): the nearest image must be unique. */
static sd_status check_width(const engine *e, double f, sd_messages *messages) {
  const sd_state *s = e->state;
  double largest = 0.0;
  for (size_t i = 0; i < s->n_disks; i++) largest = fmax(largest, s->radius[i]);
  for (int c = 0; c < 2; c++)
    if (e->work.periodic[c] && !(f * e->work.length[c] > 4.0 * largest * 1.2))
      return sd_fail(messages, SD_ERROR_NUMERIC,
                     "step %lld: the compressed box would be %g long in %c; expected more than 4.8 times the "
                     "largest radius (%g)",
                     (long long)s->step, f * e->work.length[c], c == SD_X ? 'x' : 'y', largest);
  return SD_OK;
}

static void scale_column(double *x, size_t n, double corner, double f) {
  for (size_t i = 0; i < n; i++) x[i] = corner + f * (x[i] - corner);
}

/* Where the nearest point of a line stands along it is a length, too. */
static void scale_arcs(engine *e, double f) {
  pairs *p = &e->work.pairs;
  for (size_t k = p->first_piece; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    const placed_segment *g = &e->work.segments[p->part[k]];
    double arc = walls_nearest(g, e->state->x[p->a[k]], e->state->y[p->a[k]]).arc - g->arc;
    PAIR(p, k, lambda_ref) += p->side[k] * ((f - 1.0) * arc);
  }
}

/* What closed contacts remember of their overlap is that of the new lengths, so that the change itself is not
 * taken for a motion. */
static void renew_overlaps(engine *e) {
  pairs *p = &e->work.pairs;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    PAIR(p, k, overlap) =
        fmax(contact_geometry_of(e, k).overlap, 0.0); /* it is closed until the next evaluation */
  }
}

/* Contacts open, close and slide as the new overlaps say; accelerations follow. Only sliding loses energy. */
static sd_status renew_contacts(engine *e, sd_messages *messages) {
  work *w = &e->work;
  const sd_state *s = e->state;
  pairs *p = &w->pairs;
  double *before = calloc(2 * p->count + 1, sizeof *before);
  if (!before) return sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  for (size_t k = 0; k < p->count; k++) {
    before[k] = PAIR(p, k, viscous);
    before[p->count + k] = PAIR(p, k, nonconservative_work);
  }
  renew_overlaps(e);
  sweep_forces(e);
  for (size_t k = 0; k < p->count; k++) {
    PAIR(p, k, viscous) = before[k];
    PAIR(p, k, nonconservative_work) = before[p->count + k];
  }
  free(before);
  sd_status status = contacts_events(e, messages);
  for (int k = 0; k < SD_COORDINATES; k++) {
    const columns *c = &w->columns[k];
    for (size_t i = 0; i < s->n_free; i++)
      c->q2[i] = w->half_dt2 * ((c->force[i] + c->constant[i]) * c->inverse[i]);
  }
  return status;
}

static double potential(const sd_energy *e) { return e->elastic_normal + e->elastic_skin + e->external; }

sd_status compress_step(engine *e, sd_messages *messages) {
  sd_state *s = e->state;
  double f = factor(e);
  if (f == 1.0 || rain_waits(e)) return SD_OK;
  if (check_width(e, f, messages) != SD_OK) return SD_ERROR_NUMERIC;
  sd_energy before = energy_of(e);
  scale_arcs(e, f);
  double corner[2] = {box_corner(e->model, SD_X), box_corner(e->model, SD_Y)};
  scale_column(s->x, s->n_bodies, corner[SD_X], f);
  scale_column(s->y, s->n_bodies, corner[SD_Y], f);
  scale_column(s->base_x, s->n_bodies, corner[SD_X], f);
  scale_column(s->base_y, s->n_bodies, corner[SD_Y], f);
  s->box_scale *= f;
  box_place(e);
  walls_place(e);
  sd_status status = neighbours_rescale(e, f, messages);
  if (status == SD_OK) status = renew_contacts(e, messages);
  sd_energy after = energy_of(e);
  s->work_driven += (potential(&after) - potential(&before)) + (after.friction - before.friction) +
                    (after.opening - before.opening);
  return status;
}
