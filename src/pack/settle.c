/* settle.c: kinetic energy and unbalanced force of a packing, and criteria for rest (see
 * settle.h). */
#include "pack/settle.h"

#include <math.h>

#include "base/exact_sum.h"
#include "base/math.h"
#include "pack/rain.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/system/clumps.h"
#include "physics/system/halo.h"

enum { SETTLE_KINETIC, SETTLE_FORCE, SETTLE_CONTACT, SETTLE_SUMS };
enum { DISKS, CONTACTS, OUTSIDE, COUNTS };
typedef struct settle_sums {
  exact_sum of[SETTLE_SUMS];
  int64_t n[COUNTS];
} settle_sums;

/* Returns the total force on body i along one coordinate; 0 if the coordinate is locked or
 * prescribed. */
static double resultant(const columns *c, size_t i) {
  return c->inverse[i] != 0.0 ? c->force[i] + c->constant[i] : 0.0;
}

static double moving(const columns *c, const double *mass, size_t i) {
  return c->inverse[i] != 0.0 ? 0.5 * mass[i] * c->v[i] * c->v[i] : 0.0;
}

static void add_contacts(const engine *e, settle_sums *all) {
  for (size_t k = 0; k < engine_candidates(e); k++) {
    if (!engine_contact_closed(e, k) || !halo_counts(e, k)) continue;
    exact_sum_add(&all->of[SETTLE_CONTACT], engine_contact_force(e, k));
    all->n[CONTACTS]++;
  }
}

/* Adds the clumps to the sums, each as one body. */
static void add_clumps(const engine *e, settle_sums *all) {
  const columns *c = engine_clump_columns(e, 0);
  for (size_t k = 0; k < engine_clumps(e); k++) {
    if (!clump_in_play(e, k)) continue;
    const clump_load load = clump_total(e, k);
    for (int q = 0; q < SD_COORDINATES; q++)
      if (c[q].inverse[k] != 0.0)
        exact_sum_add(&all->of[SETTLE_KINETIC], 0.5 * c[q].v[k] * c[q].v[k] / c[q].inverse[k]);
    exact_sum_add(&all->of[SETTLE_FORCE],
                  math_hypot(c[SD_X].inverse[k] != 0.0 ? load.on[SD_X] : 0.0,
                             c[SD_Y].inverse[k] != 0.0 ? load.on[SD_Y] : 0.0));
    all->n[DISKS]++;
  }
}

/* Computes the sums over the disks, clumps and contacts that this rank includes in its sums. */
static void add_up(const engine *e, settle_sums *all) {
  const sd_state *s = e->state;
  const columns *c = engine_columns(e, 0);
  *all = (settle_sums){0};
  for (size_t i = 0; i < s->n_free; i++) {
    all->n[OUTSIDE] += s->activity[i] == SD_OUTSIDE;
    if (s->activity[i] != SD_IN_PLAY || engine_in_clump(e, i)) continue;
    exact_sum_add(&all->of[SETTLE_KINETIC], moving(&c[SD_X], s->mass, i) +
                                                moving(&c[SD_Y], s->mass, i) +
                                                moving(&c[SD_THETA], s->inertia, i));
    exact_sum_add(&all->of[SETTLE_FORCE],
                  math_hypot(resultant(&c[SD_X], i), resultant(&c[SD_Y], i)));
    all->n[DISKS]++;
  }
  add_clumps(e, all);
  add_contacts(e, all);
}

settle_measure settle_measure_now(const engine *e) {
  settle_sums all;
  add_up(e, &all);
  comm_total_exact(e->comm, all.of, SETTLE_SUMS);
  comm_add(e->comm, all.n, COUNTS);
  /* A packing whose disks have all fallen out of the bounds is not at rest. */
  if (all.n[DISKS] == 0)
    return all.n[OUTSIDE] ? (settle_measure){HUGE_VAL, HUGE_VAL} : (settle_measure){0.0, 0.0};
  const double n = (double)all.n[DISKS], kinetic = exact_sum_value(&all.of[SETTLE_KINETIC]) / n,
               mean = exact_sum_value(&all.of[SETTLE_FORCE]) / n,
               contact = all.n[CONTACTS] > 0
                             ? exact_sum_value(&all.of[SETTLE_CONTACT]) / (double)all.n[CONTACTS]
                             : 0.0;
  return (settle_measure){kinetic, mean == 0.0 ? 0.0 : contact > 0.0 ? mean / contact : HUGE_VAL};
}

/* Largest relative error at which a servo wall, or a box under stress control, counts as having
 * reached its target. Servo: speed divided by its largest speed, which equals the relative error of
 * the force. Box: stress error divided by the largest target stress. */
static const double SERVO_NEAR = 0.01;

static bool walls_rest(const engine *e, double kinetic) {
  const sd_state *s = e->state;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    const sd_motion *m = &e->model->motions[k];
    double v = s->motion_v0[k];
    if (s->motion_start[k] < 0) continue;
    if (m->kind == SD_MOTION_SERVO && fabs(v) > SERVO_NEAR * m->velocity) return false;
    if (m->kind == SD_MOTION_LOAD && kinetic > 0.0 && 0.5 * m->mass * v * v > kinetic) return false;
  }
  return true;
}

bool settle_reached(const engine *e, const settle_measure *now) {
  const sd_settle *asked = &e->model->phases[e->state->phase].settle;
  if (rain_waits(e) || !walls_rest(e, asked->kinetic)) return false;
  return (asked->kinetic <= 0.0 || now->kinetic <= asked->kinetic) &&
         (asked->unbalanced <= 0.0 || now->unbalanced <= asked->unbalanced) &&
         cell_near(e, SERVO_NEAR);
}
