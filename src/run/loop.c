/* loop.c: does the work that is due between steps: phases, rain, compression, checks; see
 * loop.h. */
#include "run/loop.h"

#include <assert.h>
#include <stdlib.h>

#include "measure/sample.h"
#include "model/cell.h"
#include "pack/compress.h"
#include "pack/rain.h"
#include "pack/relax.h"
#include "pack/settle.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/bonds.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/outside.h"
#include "physics/step/steer.h"
#include "run/steps.h"

bool loop_finished(const engine *e) { return e->state->phase >= (int64_t)e->model->n_phases; }

static const sd_phase *phase_of(const engine *e) { return &e->model->phases[e->state->phase]; }

/* --- Work ------------------------------------------------------------------------------------- */

sd_status loop_build(engine *e, bool small, int threads, sd_messages *messages) {
  sd_status status = engine_build(e, small ? 1 : threads, messages);
  if (status == SD_OK && small) *engine_lanes_place(e) = lanes_new(true, 1, &e);
  return status;
}

void loop_release(engine *e) {
  lanes_free(engine_lanes(e));
  engine_free(e);
}

sd_status loop_rebuild(engine *e, bool small, sd_messages *messages) {
  const int threads = engine_threads(e);
  e->rebuilt++;
  loop_release(e);
  sd_status status = loop_build(e, small, threads, messages);
  if (status == SD_OK)
    engine_tell(e, messages);
  else
    loop_release(e); /* all later calls of the simulation are refused */
  return status;
}

/* Sorts the disks again by their present positions, since they have moved since the last sort, and
 * rebuilds lists and buffers of the engine. */
static sd_status order_again(engine *e, sd_messages *messages) {
  if (e->comm) return ranks_order_again(e);
  if (e->state->n_free < ORDER_LEAST) return SD_OK;
  if (contacts_store(e) != SD_OK || order_disks(e->model, e->state) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the order of the disks");
  return loop_rebuild(e, engine_lanes(e), messages);
}

/* --- Phases ----------------------------------------------------------------------------------- */

static bool relaxes(const sd_phase *one, const sd_phase *next) { return one->relax && next->relax; }

static bool settles(const sd_phase *one, const sd_phase *next) {
  return one->settle.asked && next->settle.asked && one->settle.every == next->settle.every;
}

static bool compresses(const sd_phase *one, const sd_phase *next) {
  const sd_compress *a = &one->compress, *b = &next->compress;
  return a->asked && b->asked && a->pressure == b->pressure && a->fraction == b->fraction &&
         a->tolerance == b->tolerance && a->rate == b->rate;
}

/* Returns the steps since something began that is done every few steps; what is alike in the phase
 * before goes on. */
static int64_t steps_of(const engine *e, phase_alike *alike) {
  return state_steps_alike(e->model, e->state, alike);
}

/* Returns true if the phase has settle criteria and they are checked after this step. */
static bool settle_is_due(const engine *e) {
  const sd_settle *asked = &e->model->phases[e->state->phase].settle;
  return asked->asked && steps_of(e, settles) % asked->every == 0;
}

/* Stores the outcome of the phase in the state: number of steps, values of the settle criteria, and
 * whether they are met. */
static void note_goals(const engine *e, const settle_measure *rest) {
  sd_state *s = e->state;
  const sd_phase *p = &e->model->phases[s->phase];
  s->phase_steps[s->phase] = s->phase_step;
  if (rest) {
    s->phase_kinetic[s->phase] = rest->kinetic;
    s->phase_unbalanced[s->phase] = rest->unbalanced;
  }
  if (p->compress.asked)
    s->phase_target[s->phase] =
        p->compress.pressure > 0.0 ? compress_pressure(e) : compress_fraction(e);
  s->phase_reached[s->phase] =
      (!rest || settle_reached(e, rest)) && (!p->compress.asked || compress_done(e));
}

/* Ends the phase: stops measuring and stores the outcome of the phase. rest: measured distance from
 * rest; NULL: the phase has no settle criteria. */
static void close_phase(engine *e, const settle_measure *rest) {
  sd_state *s = e->state;
  assert(s->phase_step > 0 && s->phase_steps[s->phase] == 0);
  assert((rest != NULL) == e->model->phases[s->phase].settle.asked);
  if (steps_are_measured(e)) {
    sample_end(e);
    disks_end(e);
  }
  motion_store(e);
  note_goals(e, rest);
  s->phase++;
  s->phase_step = 0;
}

static sd_status begin_bonds(engine *e, sd_messages *messages) {
  const sd_bonding *b = &e->model->phases[e->state->phase].bond;
  size_t made = 0;
  const sd_status status = comm_agree(e->comm, bonds_begin_phase(e, &made));
  if (status != SD_OK || !b->asked || b->later) return status;
  const double all = comm_total(e->comm, (double)made);
  if (all == 0.0)
    sd_warn(
        messages,
        "phases[%lld].bond: no bond is made: no two surfaces that are named, with a law that has "
        "bonds, are within its bond_gap",
        (long long)e->state->phase);
  else if (all < (double)b->n_pairs)
    sd_warn(messages,
            "phases[%lld].bond.file: %.0f of %zu pairs are not bonded: they are farther apart than "
            "bond_gap, do not move, or have a law without bonds",
            (long long)e->state->phase, (double)b->n_pairs - all, b->n_pairs);
  return status;
}

static sd_status prepare_relaxing(engine *e) {
  if (!state_goes_on(e->model, e->state, relaxes)) relax_begin(e);
  return SD_OK;
}

static sd_status prepare_cell(engine *e) {
  cell_begin(e);
  return SD_OK;
}

static sd_status prepare_holding(engine *e) { return comm_agree(e->comm, steer_begin_phase(e)); }

static sd_status prepare_motions(engine *e) {
  motion_begin_phase(e);
  return SD_OK;
}

/* Begins to measure the watched disks and the means of every disk. */
static sd_status begin_measuring(engine *e, sd_messages *messages) {
  (void)messages;
  if (!steps_are_measured(e)) return SD_OK;
  sample_begin(e);
  disks_begin(e);
  return SD_OK;
}

/* Actions at the beginning of a phase, in this order. SD_ERROR_IO: out of memory. */
static const struct {
  sd_status (*prepare)(engine *e); /* before forces are evaluated: sets what they depend on */
  /* with contacts and forces as the first step finds them */
  sd_status (*begin)(engine *e, sd_messages *messages);
} phase_actions[] = {
    {.prepare = prepare_relaxing}, {.prepare = prepare_cell}, {.prepare = prepare_holding},
    {.prepare = prepare_motions},  {.begin = begin_bonds},    {.begin = begin_measuring},
};
enum { PHASE_ACTIONS = sizeof phase_actions / sizeof *phase_actions };

sd_status loop_begin_phase(engine *e, sd_messages *messages) {
  sd_status status = SD_OK;
  for (size_t k = 0; k < PHASE_ACTIONS && status == SD_OK && !loop_finished(e); k++)
    if (phase_actions[k].prepare) status = phase_actions[k].prepare(e);
  return status == SD_OK ? SD_OK : sd_fail(messages, status, "out of memory for a phase");
}

static sd_status begin_with_forces(engine *e, sd_messages *messages) {
  sd_status status = SD_OK;
  for (size_t k = 0; k < PHASE_ACTIONS && status == SD_OK; k++)
    if (phase_actions[k].begin) status = phase_actions[k].begin(e, messages);
  return status == SD_OK ? SD_OK : sd_fail(messages, status, "out of memory for a phase");
}

sd_status loop_start(engine *e, sd_messages *messages) {
  sd_status status = rain_next(e, -1) == 0 ? rain_release(e, messages) : SD_OK;
  if (status == SD_OK) status = engine_start(e, messages);
  if (status != SD_OK) return status;
  motion_begin_run(e);
  return begin_with_forces(e, messages);
}

/* Ends the phase and, unless it was the last, begins the next one. */
static sd_status end_phase(engine *e, sd_messages *messages) {
  const bool settles = phase_of(e)->settle.asked;
  const settle_measure rest = settles ? settle_measure_now(e) : (settle_measure){0};
  close_phase(e, settles ? &rest : NULL);
  if (loop_finished(e)) return SD_OK;
  sd_status status = order_again(e, messages);
  if (status != SD_OK) return status;
  const bool steers = steer_is_due(e);
  const double residual = steers ? energy_residual(e) : 0.0;
  status = loop_begin_phase(e, messages);
  if (status == SD_OK && steers) status = steer_finish(e, residual, true, messages);
  return status == SD_OK ? begin_with_forces(e, messages) : status;
}

/* --- Between steps ---------------------------------------------------------------------------- */

/* Returns true if the model has a goal for its error bar (`until`) and the last phase is
 * running. */
static bool has_goal(const engine *e) {
  return e->model->until.asked && e->state->phase + 1 == (int64_t)e->model->n_phases;
}

/* Returns the step after `now` at which something is due that is done every `every` steps and was
 * begun `since` steps ago, or `stop` if that is less. */
static int64_t nearer(int64_t stop, int64_t now, int64_t since, int64_t every) {
  const int64_t next = now + every - since % every;
  return next < stop ? next : stop;
}

/* Returns the next step of the phase (counted from its start) at which the loop must pause, because
 * the phase ends there, or a check or action between steps is due. */
static int64_t next_stop(const engine *e) {
  const sd_phase *p = phase_of(e);
  int64_t now = e->state->phase_step, stop = has_goal(e) ? sd_goal_look(e->model, now) : p->steps;
  if (p->settle.asked) stop = nearer(stop, now, steps_of(e, settles), p->settle.every);
  if (p->compress.asked) stop = nearer(stop, now, steps_of(e, compresses), COMPRESS_EVERY);
  if (p->cell.asked) stop = nearer(stop, now, steps_of(e, cell_alike), CELL_EVERY);
  /* Rain and checks of the bounds are due at steps counted from the start of the run, not of the
   * phase. */
  int64_t step = e->state->step, next = rain_next(e, step);
  if (e->model->bounds.given) next = nearer(next, step, step, OUTSIDE_EVERY);
  return next - step < stop - now ? now + (next - step) : stop;
}

static bool rain_is_due(const engine *e) {
  return rain_next(e, e->state->step - 1) == e->state->step;
}

/* Does the actions that are due at this step: check of the bounds, rain, compression, deformation
 * of the box. */
static sd_status between_steps(engine *e, sd_messages *messages) {
  const sd_phase *p = phase_of(e);
  sd_status status = SD_OK;
  if (e->model->bounds.given && e->state->step % OUTSIDE_EVERY == 0)
    status = outside_check(e, messages);
  if (status == SD_OK && rain_is_due(e)) status = rain_release(e, messages);
  if (status == SD_OK && p->compress.asked && steps_of(e, compresses) % COMPRESS_EVERY == 0)
    status = compress_step(e, messages);
  if (status == SD_OK && p->cell.asked && steps_of(e, cell_alike) % CELL_EVERY == 0)
    status = cell_change(e, messages);
  return status;
}

/* Returns true if the settle criteria are due and met. */
static bool settled(const engine *e) {
  if (!settle_is_due(e)) return false;
  const settle_measure now = settle_measure_now(e);
  return settle_reached(e, &now);
}

/* Returns true if the goal of `until` is checked at this step. */
static bool goal_is_due(const engine *e) {
  const int64_t now = e->state->phase_step;
  return has_goal(e) && now == sd_goal_look(e->model, now - 1);
}

static bool phase_is_over(const engine *e) {
  const sd_phase *p = phase_of(e);
  if (e->state->phase_step == p->steps) return true;
  if (settled(e) && (!p->compress.asked || compress_done(e))) return true;
  return goal_is_due(e) && sd_goal_of(e->model, e->state).reached;
}

int64_t loop_steps_left(const engine *e) {
  int64_t room = next_stop(e) - e->state->phase_step;
  assert(room > 0 && e->state->phase_step + room <= phase_of(e)->steps);
  return room;
}

sd_status loop_pause(engine *e, int64_t from, sd_messages *messages) {
  assert(from <= e->state->step);
  e->state->phase_step += e->state->step - from;
  assert(e->state->phase_step <= phase_of(e)->steps);
  sd_status status = comm_agree(e->comm, engine_status(e));
  if (status == SD_OK) status = between_steps(e, messages);
  if (status != SD_OK || !phase_is_over(e)) return status;
  if (e->model->bounds.given) status = outside_check(e, messages);
  return status == SD_OK ? end_phase(e, messages) : status;
}

/* --- Steps ------------------------------------------------------------------------------------ */

sd_status loop_advance(engine *e, int64_t n, sd_messages *messages) {
  const int64_t from = e->state->step;
  assert(n > 0 && n <= loop_steps_left(e));
  if (e->comm)
    ranks_steps(e, n);
  else
    loop_steps(e, e->pool, from + n, NULL, NULL);
  assert(e->state->step >= from && e->state->step <= from + n);
  return loop_pause(e, from, messages);
}
