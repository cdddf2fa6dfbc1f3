/* compress.c: scales the lengths of a region until a pressure or packing fraction is reached (see
 * compress.h). */
#include "pack/compress.h"

#include <math.h>

#include "base/comm.h"
#include "base/math.h"
#include "model/cell.h"
#include "model/laws.h"
#include "pack/rain.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/step/step.h"
#include "physics/system/bodies.h"
#include "physics/system/halo.h"

/* Fraction of the pressure error that one change of the lengths would remove if all disks moved
 * affinely with it. */
static const double GAIN = 0.1;
/* The lengths do not change while the pressure error is below this fraction of the tolerance, so
 * that forces can come to balance. */
static const double QUIET = 0.5;

/* --- pressure and packing fraction ------------------------------------------------------------ */

double compress_area(const sd_model *m, const sd_state *s) {
  double width = m->region_upper[0] - m->region_lower[0],
         height = m->region_upper[1] - m->region_lower[1];
  return width * height * cell_scale(s, SD_X) * cell_scale(s, SD_Y);
}

/* Computes the vector arm[] from the centre of a clump to its disk in slot i; 0 for a body in no
 * clump. Image counts are used, as the clump may lie across the edge of a periodic box (a box with
 * clumps does not deform). */
static void arm_of(const sd_model *m, const sd_state *s, size_t i, double arm[2]) {
  const int clump = i < s->n_free ? m->disks[s->id[i]].clump : 0;
  arm[0] = arm[1] = 0.0;
  if (clump == 0) return;
  const size_t k = (size_t)clump - 1;
  arm[0] = s->x[i] - s->clump_x[k];
  arm[1] = s->y[i] - s->clump_y[k];
  for (int c = 0; c < 2; c++)
    if (m->periodic[c])
      arm[c] += (c ? s->image_y[i] - s->clump_image_y[k] : s->image_x[i] - s->clump_image_x[k]) *
                (s->box_scale * (m->upper[c] - m->lower[c]));
}

double compress_inner(const sd_model *m, const sd_state *s, size_t slot) {
  double arm[2];
  arm_of(m, s, slot, arm);
  return -(arm[0] * s->force_x[slot] + arm[1] * s->force_y[slot]);
}

/* Returns n . (arm_a - arm_b), with n the normal of contact k and arm the vector from the centre of
 * a clump to its disk. The distance of the two disks plus this length is the normal component of
 * the vector between the centres of their clumps. */
static double longer(const engine *e, size_t k) {
  const sd_model *m = e->model;
  double arm[2][2], n[2];
  arm_of(m, e->state, engine_contact_a(e, k), arm[0]);
  arm_of(m, e->state, engine_contact_b(e, k), arm[1]);
  engine_contact_direction(e, k, n);
  return n[0] * (arm[0][0] - arm[1][0]) + n[1] * (arm[0][1] - arm[1][1]);
}

typedef struct virial {
  /* stiffness: -dp/d(ln L) of the pressure p if all lengths L are scaled and the centres of the
   * disks move affinely */
  double pressure, stiffness;
} virial;

/* Computes pressure and stiffness from the contacts of all ranks; collective. */
static virial virial_of(const engine *e) {
  const sd_state *s = e->state;
  const double twice = 2.0 * compress_area(e->model, s);
  enum { FORCE, STIFFNESS, SUMS };
  exact_sum sum[SUMS] = {0};
  for (size_t k = 0; k < engine_candidates(e); k++) {
    if (!engine_contact_closed(e, k) || !halo_counts(e, k)) continue;
    size_t a = engine_contact_a(e, k), b = engine_contact_b(e, k);
    double r = s->radius[a] + (b < s->n_disks ? s->radius[b] : 0.0) - engine_contact_overlap(e, k);
    exact_sum_add(&sum[FORCE], engine_contact_force(e, k) * r);
    if (s->n_clumps > 0) r += longer(e, k);
    exact_sum_add(&sum[STIFFNESS], engine_contact_stiffness(e, k) * r * r);
  }
  for (size_t i = 0; s->n_clumps > 0 && i < s->n_free; i++)
    exact_sum_add(&sum[FORCE], compress_inner(e->model, s, i));
  comm_total_exact(e->comm, sum, SUMS);
  const double force = exact_sum_value(&sum[FORCE]), stiffness = exact_sum_value(&sum[STIFFNESS]);
  return (virial){force / twice, (stiffness + 2.0 * force) / twice};
}

double compress_pressure(const engine *e) { return virial_of(e).pressure; }

double compress_fraction(const engine *e) {
  const sd_state *s = e->state;
  exact_sum squares = {0};
  for (size_t i = 0; i < s->n_free; i++)
    if (body_in_play(s, i)) exact_sum_add(&squares, s->radius[i] * s->radius[i]);
  comm_total_exact(e->comm, &squares, 1);
  return M_PI * exact_sum_value(&squares) / compress_area(e->model, s);
}

/* --- target ----------------------------------------------------------------------------------- */

static const sd_compress *target_of(const engine *e) {
  return &e->model->phases[e->state->phase].compress;
}

bool compress_done(const engine *e) {
  const sd_compress *c = target_of(e);
  if (c->pressure > 0.0)
    return fabs(compress_pressure(e) - c->pressure) <= c->tolerance * c->pressure;
  return fabs(compress_fraction(e) - c->fraction) <= c->tolerance * c->fraction;
}

/* Returns the factor by which the lengths change now; 1: no change. It is limited by the rate that
 * the deck gives, and is closer to 1 near the target. */
static double factor(const engine *e) {
  const sd_compress *c = target_of(e);
  double most = c->rate * e->model->dt * COMPRESS_EVERY, shrink;
  if (c->pressure > 0.0) {
    virial now = virial_of(e);
    double missing = c->pressure - now.pressure;
    if (fabs(missing) <= QUIET * c->tolerance * c->pressure) return 1.0;
    shrink = now.stiffness > 0.0 ? GAIN * missing / now.stiffness : most;
  } else {
    shrink = 1.0 - sqrt(compress_fraction(e) / c->fraction);
    if (fabs(shrink) < 1e-14) return 1.0; /* a smaller change is rounding error */
  }
  return 1.0 - math_min(math_max(shrink, -most), most);
}

/* --- change of the lengths -------------------------------------------------------------------- */

/* Returns SD_ERROR_NUMERIC if a periodic box, scaled by f, would be so narrow that the nearest
 * image is not unique; the same limit holds at the start (cell_least_length). */
static sd_status check_width(const engine *e, double f, sd_messages *messages) {
  const sd_state *s = e->state;
  const double reach = laws_range(e->model);
  double largest = 0.0;
  for (size_t i = 0; i < s->n_disks; i++) largest = math_max(largest, s->radius[i]);
  largest = comm_largest(e->comm, largest);
  for (int c = 0; c < 2; c++)
    if (e->model->periodic[c] && !(f * engine_length(e, c) > 4.0 * largest * 1.2 + 2.0 * reach))
      return sd_fail(
          messages, SD_ERROR_NUMERIC,
          "step %lld: the compressed box would be %g long in %c; expected more than 4.8 times the "
          "largest radius (%g) and twice the gap over which disks attract each other (%g)",
          (long long)s->step, f * engine_length(e, c), c == SD_X ? 'x' : 'y', largest, reach);
  return SD_OK;
}

static double potential(const sd_energy *e) {
  return e->elastic_normal + e->elastic_tangential + e->elastic_rolling + e->elastic_bond +
         e->cohesion + e->external;
}

static double broken(const sd_energy *e) {
  return e->broken_tension + e->broken_shear + e->broken_bending;
}

sd_status compress_step(engine *e, sd_messages *messages) {
  double f = factor(e);
  if (f == 1.0 || rain_waits(e)) return SD_OK;
  if (check_width(e, f, messages) != SD_OK) return SD_ERROR_NUMERIC;
  sd_energy before = energy_of(e);
  const sd_status status = rescale(e, f, messages);
  if (status != SD_OK) return status;
  sd_energy after = energy_of(e);
  e->state->work_driven += (potential(&after) - potential(&before)) +
                           (after.friction - before.friction) + (after.opening - before.opening) +
                           (after.rolling - before.rolling) + (after.bridge - before.bridge) +
                           (broken(&after) - broken(&before));
  return SD_OK;
}
