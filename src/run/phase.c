/* phase.c: see phase.h. */
#include "run/phase.h"

#include <assert.h>

#include "measure/disks.h"
#include "measure/sample.h"
#include "pack/compress.h"
#include "physics/motion/motion.h"

bool phase_measures(const engine *e) {
  return e->state->phase < (int64_t)e->model->n_phases && e->model->phases[e->state->phase].measure;
}

void phase_measure_begin(engine *e) {
  sample_begin(e);
  disks_begin(e);
}

bool phase_settles(const engine *e) {
  const sd_settle *asked = &e->model->phases[e->state->phase].settle;
  return asked->asked && e->state->phase_step % asked->every == 0;
}

static void note_goals(const engine *e, const settle_measure *rest) {
  sd_state *s = e->state;
  const sd_phase *p = &e->model->phases[s->phase];
  s->phase_steps[s->phase] = s->phase_step;
  if (rest) {
    s->phase_kinetic[s->phase] = rest->kinetic;
    s->phase_unbalanced[s->phase] = rest->unbalanced;
  }
  if (p->compress.asked)
    s->phase_target[s->phase] = p->compress.pressure > 0.0 ? compress_pressure(e) : compress_fraction(e);
  s->phase_reached[s->phase] = (!rest || settle_reached(e, rest)) && (!p->compress.asked || compress_done(e));
}

void phase_end(engine *e, const settle_measure *rest) {
  sd_state *s = e->state;
  assert(s->phase_step > 0 && s->phase_steps[s->phase] == 0);
  assert((rest != NULL) == e->model->phases[s->phase].settle.asked);
  if (phase_measures(e)) {
    sample_end(e);
    disks_end(e);
  }
  motion_store(e);
  note_goals(e, rest);
  s->phase++;
  s->phase_step = 0;
}
