/* settle.c: see settle.h. */
#include "pack/settle.h"

#include <math.h>

#include "pack/rain.h"
#include "physics/step/access.h"

/* 0 for a coordinate that is held. */
static double resultant(const columns *c, size_t i) {
  return c->inverse[i] != 0.0 ? c->force[i] + c->constant[i] : 0.0;
}

static double moving(const columns *c, const double *mass, size_t i) {
  return c->inverse[i] != 0.0 ? 0.5 * mass[i] * c->v[i] * c->v[i] : 0.0;
}

static double mean_force(const engine *e) {
  double sum = 0.0;
  size_t n = 0;
  for (size_t k = 0; k < engine_candidates(e); k++) {
    if (!engine_contact_closed(e, k)) continue;
    sum += engine_contact_force(e, k);
    n++;
  }
  return n > 0 ? sum / (double)n : 0.0;
}

settle_measure settle_look(const engine *e) {
  const sd_state *s = e->state;
  const columns *c = engine_columns(e, 0);
  double kinetic = 0.0, force = 0.0;
  size_t n = 0;
  bool outside = false;
  for (size_t i = 0; i < s->n_free; i++) {
    outside |= s->activity[i] == SD_OUTSIDE;
    if (s->activity[i] != SD_IN_PLAY) continue;
    kinetic +=
        moving(&c[SD_X], s->mass, i) + moving(&c[SD_Y], s->mass, i) + moving(&c[SD_THETA], s->inertia, i);
    force += hypot(resultant(&c[SD_X], i), resultant(&c[SD_Y], i));
    n++;
  }
  /* what falls beyond the bounds is not at rest */
  if (n == 0) return outside ? (settle_measure){HUGE_VAL, HUGE_VAL} : (settle_measure){0.0, 0.0};
  double contact = mean_force(e), mean = force / (double)n;
  return (settle_measure){kinetic / (double)n, mean == 0.0 ? 0.0 : contact > 0.0 ? mean / contact : HUGE_VAL};
}

/* A servo whose disks do not feel its force yet creeps on, however slowly; a lid must not swing. */
static const double SERVO_NEAR = 0.01; /* of the force, as its speed is of the largest */

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

bool settle_reached(const engine *e) {
  const sd_settle *asked = &e->model->phases[e->state->phase].settle;
  if (rain_waits(e) || !walls_rest(e, asked->kinetic)) return false;
  settle_measure now = settle_look(e);
  return (asked->kinetic <= 0.0 || now.kinetic <= asked->kinetic) &&
         (asked->unbalanced <= 0.0 || now.unbalanced <= asked->unbalanced);
}
