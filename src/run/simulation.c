/* simulation.c: phases, threads, and the way in and out of a running system; see slipdisk/simulation.h. */
#include "slipdisk/simulation.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/subnormal.h"
#include "measure/disks.h"
#include "measure/sample.h"
#include "model/cell.h"
#include "model/overlaps.h"
#include "pack/compress.h"
#include "pack/rain.h"
#include "pack/relax.h"
#include "pack/settle.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/order.h"
#include "physics/step/outside.h"
#include "physics/step/step.h"
#include "physics/system/fields.h"
#include "run/lanes_loop.h"
#include "run/phase.h"
#include "run/simulation_private.h"

int simulation_threads_for(const sd_model *m, int most) {
  size_t worth = m->n_free / SIMULATION_DISKS_PER_THREAD;
  if ((size_t)most > worth) most = (int)worth;
  return most < 1 ? 1 : most;
}

static int choose_threads(const sd_model *m, int asked) {
  int n = asked > 0 ? asked : simulation_threads_for(m, pool_most());
  return n > WORK_MAX_THREADS ? WORK_MAX_THREADS : n;
}

/* state->phase is new: switch motions, start measuring. */
static sd_status begin_phase(engine *e, sd_messages *messages) {
  if (e->state->phase >= (int64_t)e->model->n_phases) return SD_OK;
  relax_begin(e);
  cell_begin(e);
  if (motion_begin_phase(e) != SD_OK) return sd_fail(messages, SD_ERROR_IO, "out of memory for the motions");
  return SD_OK;
}

static sd_status fail_new(sd_simulation *sim, sd_simulation **out, sd_status status) {
  sd_simulation_free(sim);
  *out = NULL;
  return status;
}

/* Work, and the rows of a small system, whose step has one thread. */
static sd_status build(engine *e, bool small, int threads, sd_messages *messages) {
  sd_status status = engine_build(e, small ? 1 : threads, messages);
  if (status == SD_OK && small && lanes_new(true, 1, &e, engine_lanes_place(e)) != SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for the system");
  return status;
}

/* The step of small systems knows no disks that were taken out. */
static bool all_in_play(const sd_state *s) {
  for (size_t i = 0; i < s->n_free; i++)
    if (s->activity[i] == SD_REMOVED) return false;
  return true;
}

static void release(engine *e) {
  lanes_free(engine_lanes(e));
  engine_free(e);
}

sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out, sd_messages *messages) {
  return simulation_new(model, threads, SIMULATION_SUITABLE, NULL, out, messages);
}

static bool is_finished(const sd_model *model, sd_messages *messages) {
  if (!model->finished)
    sd_fail(messages, SD_ERROR_USER, "the model is not finished: call sd_model_finish after the last change");
  return model->finished;
}

/* Can ranks share the steps of this phase? NULL, or why not: "it relaxes". */
static const char *unsuited_in(const engine *whole, int64_t phase) {
  const sd_model *m = whole->model;
  /* of a run that is over, which only has to be merged: NULL */
  const sd_phase *p = phase < (int64_t)m->n_phases ? &m->phases[phase] : NULL;
  if (whole->fields) return "the program has force fields of its own";
  if (m->n_clumps > 0) return "there are clumps";
  if (cell_deforms(m)) return "the box deforms";
  if (m->n_rotations > 0 || m->n_slides > 0) return "single disks are watched";
  if (p && p->relax) return "it relaxes";
  if (p && p->compress.asked) return "it compresses";
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] < m->n_disks && !m->disks[m->motions[k].bodies[b]].driven)
        return "a motion moves a free disk";
  return NULL;
}

static const char *unsuited(const engine *whole) { return unsuited_in(whole, whole->state->phase); }

/* Lists are made where the steps of the present phase are: on the ranks, or here. */
static sd_status build_work(sd_simulation *sim, bool small, int threads, sd_messages *messages) {
  engine *e = &sim->engine;
  if (threads > 1 && !(e->pool = pool_new(threads)))
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the threads");
  if (sim->ranks && !unsuited(e)) return engine_build_bodies(e, threads, messages);
  if (state_bring(e->state) != SD_OK) return sd_fail(messages, SD_ERROR_IO, "cannot read the state");
  state_spread(e->state, e->pool);
  return build(e, small, threads, messages);
}

/* All but what is done once at step 0, and lists that are made on the ranks. */
static sd_status create(const sd_model *model, sd_state *state, int threads, simulation_step step,
                        volatile sig_atomic_t *over_ranks, sd_simulation **out, sd_messages *messages) {
  *out = NULL;
  if (!is_finished(model, messages)) {
    sd_state_free(state);
    return SD_ERROR_USER;
  }
  sd_simulation *sim = memory_lines(sizeof *sim);
  *sim = (sd_simulation){.engine = {.model = model, .state = state}};
  const bool small = step == SIMULATION_SUITABLE && lanes_suit(model) && all_in_play(state);
  sd_status status = SD_OK;
  if (over_ranks && !small && !(sim->ranks = ranks_new(model, over_ranks)))
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for the ranks");
  if (status == SD_OK) status = build_work(sim, small, small ? 1 : choose_threads(model, threads), messages);
  if (status != SD_OK) return fail_new(sim, out, status);
  *out = sim;
  return SD_OK;
}

/* Of step 0, once the first phase has begun. */
static sd_status start(sd_simulation *sim, sd_messages *messages) {
  engine *e = &sim->engine;
  if (!engine_has_lists(e)) return ranks_start(sim->ranks, e, phase_measures(e), messages);
  sd_status status = rain_next(e, -1) == 0 ? rain_release(e, messages) : SD_OK;
  if (status == SD_OK) status = engine_start(e, messages);
  if (status == SD_OK) motion_begin_run(e);
  if (status == SD_OK && phase_measures(e)) phase_measure_begin(e);
  return status;
}

typedef struct coincidence {
  const sd_model *model;
  sd_messages *messages;
  bool found;
} coincidence;

/* A motion moves its centre, perhaps at once. */
static bool is_moved(const sd_model *m, uint32_t disk) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; m->motions[k].coordinate <= SD_Y && b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] == disk) return true;
  return false;
}

static bool tell_coincident(void *user, const overlap *o) {
  coincidence *c = user;
  char one[96], two[96];
  if (!o->coincident || c->found) return c->found;
  if (is_moved(c->model, o->a) || is_moved(c->model, o->b)) return false;
  c->found = true;
  sd_fail(c->messages, SD_ERROR_USER, "%s and %s have the same centre",
          sd_model_body_name(c->model, o->a > o->b ? o->a : o->b, one, sizeof one),
          sd_model_body_name(c->model, o->a > o->b ? o->b : o->a, two, sizeof two));
  return true;
}

/* Coincident disks have no normal and never touch. Decks are checked when they are read. */
static sd_status refuse_coincident(const sd_model *model, sd_messages *messages) {
  coincidence c = {.model = model, .messages = messages};
  if (model->deck) return SD_OK;
  if (overlaps_of_disks(model, tell_coincident, &c) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the overlaps");
  return c.found ? SD_ERROR_USER : SD_OK;
}

sd_status simulation_new(const sd_model *model, int threads, simulation_step step,
                         volatile sig_atomic_t *over_ranks, sd_simulation **out, sd_messages *messages) {
  *out = NULL;
  if (!is_finished(model, messages)) return SD_ERROR_USER;
  /* of ranks each has the rows of its own disks */
  if (!over_ranks && state_refuse(model, messages) != SD_OK) return SD_ERROR_IO;
  const sd_status apart = refuse_coincident(model, messages);
  if (apart != SD_OK) return apart;
  sd_state *state = sd_state_new(model);
  if (!state) {
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the state");
  }
  if (engine_fill_state(model, state) != SD_OK) {
    sd_state_free(state);
    *out = NULL;
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  }
  sd_status status = create(model, state, threads, step, over_ranks, out, messages);
  if (status != SD_OK) return status;
  assert(*out);
  status = begin_phase(&(*out)->engine, messages);
  if (status == SD_OK) status = start(*out, messages);
  return status == SD_OK ? SD_OK : fail_new(*out, out, status);
}

sd_status simulation_resume(const sd_model *model, sd_state *state, int threads, simulation_step step,
                            volatile sig_atomic_t *over_ranks, sd_simulation **out, sd_messages *messages) {
  sd_status status = create(model, state, threads, step, over_ranks, out, messages);
  if (status != SD_OK) return status;
  assert(*out);
  sd_simulation *sim = *out;
  if (!engine_has_lists(&sim->engine)) status = ranks_spread(sim->ranks, &sim->engine, messages);
  state->source = NULL; /* what it read may go */
  return status == SD_OK ? SD_OK : fail_new(sim, out, status);
}

sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads, sd_simulation **out,
                               sd_messages *messages) {
  return simulation_resume(model, state, threads, SIMULATION_SUITABLE, NULL, out, messages);
}

void simulation_free(sd_simulation *sim) {
  ranks_free(sim->ranks);
  release(&sim->engine);
  fields_free(&sim->engine);
  pool_free(sim->engine.pool);
  sd_state_free(sim->engine.state);
  sd_model_free(sim->owned);
  free(sim->observers);
  free(sim);
}

typedef struct advance_task {
  engine *e;
  int64_t n;
  bool measure;
  relax_sums *sums; /* one a thread; NULL: the phase does not relax */
} advance_task;

/* One member's share of n steps within a phase. */
static void advance_steps(const advance_task *a, const team *t) {
  engine *e = a->e;
  const int64_t measured = e->state->measured;
  for (int64_t k = 1; k <= a->n; k++) {
    step_once(e, t);
    team_wait(t);
    if (engine_status(e) != SD_OK) return;
    if (a->sums) relax_step(e, t, a->sums);
    if (!a->measure) continue;
    disks_step(e, t, measured + k);
    if (t->rank == 0) sample_step(e);
    team_wait(t);
  }
}

static void advance_member(const team *t, void *with) {
  const advance_task *a = with;
  unsigned mode = subnormal_off();
  if (engine_lanes(a->e))
    lanes_loop(engine_lanes(a->e), a->n, a->measure);
  else
    advance_steps(a, t);
  subnormal_restore(mode);
}

static void advance_team(engine *e, int64_t n, bool measure) {
  advance_task task = {.e = e, .n = n, .measure = measure};
  assert(n > 0);
  if (e->model->phases[e->state->phase].relax)
    task.sums = memory_new((size_t)engine_threads(e), sizeof *task.sums);
  step_begin(e, n);
  pool_run(e->pool, advance_member, &task);
  free(task.sums);
}

sd_status simulation_rebuild(engine *e, bool small, sd_messages *messages) {
  const int threads = engine_threads(e);
  release(e);
  sd_status status = build(e, small, threads, messages);
  engine_tell(e, messages);
  return status;
}

/* Where the disks have gone since they were put in order. All that can be recomputed is made anew. */
static sd_status order_again(engine *e, sd_messages *messages) {
  if (e->state->n_free < ORDER_LEAST) return SD_OK;
  if (contacts_store(e) != SD_OK || order_disks(e->model, e->state) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the order of the disks");
  return simulation_rebuild(e, engine_lanes(e), messages);
}

static sd_status end_phase(engine *e, sd_messages *messages) {
  sd_state *s = e->state;
  const bool settles = e->model->phases[s->phase].settle.asked;
  const settle_measure rest = settles ? settle_look(e) : (settle_measure){0};
  phase_end(e, settles ? &rest : NULL);
  sd_status status = s->phase < (int64_t)e->model->n_phases ? order_again(e, messages) : SD_OK;
  if (status == SD_OK) status = begin_phase(e, messages);
  if (status == SD_OK && phase_measures(e)) phase_measure_begin(e);
  return status;
}

/* --- what is done between steps ----------------------------------------------------------------------- */

static const sd_phase *phase_of(const engine *e) { return &e->model->phases[e->state->phase]; }

static bool has_goal(const engine *e) {
  return e->model->until.asked && e->state->phase + 1 == (int64_t)e->model->n_phases;
}

static int64_t nearer(int64_t stop, int64_t step, int64_t every) {
  int64_t next = (step / every + 1) * every;
  return next < stop ? next : stop;
}

/* The phase's next step after which the run pauses: it ends, or something is looked at or done. */
static int64_t next_stop(const engine *e) {
  const sd_phase *p = phase_of(e);
  int64_t now = e->state->phase_step, stop = has_goal(e) ? sd_goal_look(e->model, now) : p->steps;
  if (p->settle.asked) stop = nearer(stop, now, p->settle.every);
  if (p->compress.asked) stop = nearer(stop, now, COMPRESS_EVERY);
  if (p->cell.asked) stop = nearer(stop, now, CELL_EVERY);
  /* rain and looks at the bounds count steps since the start */
  int64_t step = e->state->step, next = rain_next(e, step);
  if (e->model->bounds.given) next = nearer(next, step, OUTSIDE_EVERY);
  return next - step < stop - now ? now + (next - step) : stop;
}

static bool rain_is_due(const engine *e) { return rain_next(e, e->state->step - 1) == e->state->step; }

static sd_status between_steps(engine *e, sd_messages *messages) {
  const sd_phase *p = phase_of(e);
  int64_t now = e->state->phase_step;
  sd_status status = SD_OK;
  if (e->model->bounds.given && e->state->step % OUTSIDE_EVERY == 0) status = outside_look(e, messages);
  if (status == SD_OK && rain_is_due(e)) status = rain_release(e, messages);
  if (status == SD_OK && p->compress.asked && now % COMPRESS_EVERY == 0) status = compress_step(e, messages);
  if (status == SD_OK && p->cell.asked && now % CELL_EVERY == 0) status = cell_change(e, messages);
  return status;
}

static bool settled(const engine *e) {
  if (!phase_settles(e)) return false;
  const settle_measure now = settle_look(e);
  return settle_reached(e, &now);
}

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

/* Is anything done after this step that needs the whole system, beside looks at the bounds? */
static bool whole_is_due(const engine *e) {
  const sd_phase *p = phase_of(e);
  const int64_t now = e->state->phase_step;
  return (p->compress.asked && now % COMPRESS_EVERY == 0) || (p->cell.asked && now % CELL_EVERY == 0) ||
         goal_is_due(e);
}

engine *simulation_engine(sd_simulation *sim) { return &sim->engine; }

bool simulation_is_spread(const sd_simulation *sim) { return sim->ranks && ranks_are_spread(sim->ranks); }

bool simulation_is_small(const sd_simulation *sim) { return engine_lanes(&sim->engine); }

int64_t simulation_room(const engine *e) {
  int64_t room = next_stop(e) - e->state->phase_step;
  assert(room > 0 && e->state->phase_step + room <= phase_of(e)->steps);
  return room;
}

sd_status simulation_pause(engine *e, int64_t from, sd_messages *messages) {
  assert(from <= e->state->step);
  e->state->phase_step += e->state->step - from;
  assert(e->state->phase_step <= phase_of(e)->steps);
  if (engine_status(e) != SD_OK) return engine_status(e);
  sd_status status = between_steps(e, messages);
  if (status != SD_OK || !phase_is_over(e)) return status;
  if (e->model->bounds.given) status = outside_look(e, messages);
  return status == SD_OK ? end_phase(e, messages) : status;
}

/* Steps by all ranks where they can share them, else by this process. */
static sd_status advance(sd_simulation *sim, int64_t n, sd_messages *messages) {
  engine *e = &sim->engine;
  const char *alone = sim->ranks ? unsuited(e) : "";
  if (!alone) return ranks_advance(sim->ranks, e, n, phase_measures(e), messages);
  if (sim->ranks && (alone != sim->told || e->state->phase != sim->told_phase)) {
    const char *name = phase_of(e)->name;
    sd_warn(messages, "phase \"%s\" runs on one rank, since %s", name ? name : "", alone);
    sim->told = alone;
    sim->told_phase = e->state->phase;
  }
  const sd_status status = sim->ranks ? ranks_center(sim->ranks, e, messages) : SD_OK;
  if (status != SD_OK) return status;
  advance_team(e, n, phase_measures(e));
  sim->door.broken = pool_forked(e->pool);
  return sim->door.broken ? sd_fail(messages, SD_ERROR_USER,
                                    "the process was forked within a force field: its step was not ended")
                          : SD_OK;
}

/* Disks that leave the bounds, or come back, while the disks are spread. True: the run is to stop, for which they are needed together. */
static bool look_outside(sd_simulation *sim, sd_status *status, sd_messages *messages) {
  const sd_bounds *b = &sim->engine.model->bounds;
  if (b->given && b->outside == SD_OUTSIDE_STOP) return ranks_outside_is_due(sim->ranks);
  if (b->given) *status = ranks_outside(sim->ranks, &sim->engine, messages);
  return false;
}

/* simulation_pause while the disks are spread. False: they are together now, for what needs the whole system. */
static bool pause_on_ranks(sd_simulation *sim, int64_t from, sd_status *status, sd_messages *messages) {
  engine *e = &sim->engine;
  sd_state *s = e->state;
  const bool goes_on = !unsuited_in(e, s->phase + 1), looks = s->step % OUTSIDE_EVERY == 0;
  s->phase_step += s->step - from;
  if (*status != SD_OK) return true;
  /* rain falls once: where the next phase is for one rank all after it is looked at together */
  const bool may_end = s->phase_step == phase_of(e)->steps || phase_settles(e);
  bool whole = sim->n_observers > 0 || whole_is_due(e) || (rain_is_due(e) && may_end && !goes_on);
  if (!whole && looks) whole = look_outside(sim, status, messages);
  if (!whole && *status == SD_OK && rain_is_due(e)) *status = ranks_rain(sim->ranks, e, messages);
  if (*status != SD_OK) return true;
  if (!whole) {
    bool over = s->phase_step == phase_of(e)->steps;
    if (!over && phase_settles(e)) {
      const settle_measure now = ranks_rest(sim->ranks, e);
      over = settle_reached(e, &now);
    }
    whole = over && (!goes_on || look_outside(sim, status, messages));
    if (over && !whole && *status == SD_OK) *status = ranks_end_phase(sim->ranks, e, messages);
  }
  if (!whole) return true;
  s->phase_step -= s->step - from;
  *status = ranks_center(sim->ranks, e, messages);
  return *status != SD_OK;
}

settle_measure simulation_rest(sd_simulation *sim) {
  return simulation_is_spread(sim) ? ranks_rest(sim->ranks, &sim->engine) : settle_look(&sim->engine);
}

bool simulation_finished(const sd_simulation *sim) {
  return sim->engine.state->phase >= (int64_t)sim->engine.model->n_phases;
}

static sd_status advance_all(sd_simulation *sim, int64_t n, sd_messages *messages) {
  engine *e = &sim->engine;
  if (!e->fields) e->state->field_power = 0.0;
  engine_ready(e, messages);
  while (n > 0 && !simulation_finished(sim)) {
    int64_t left = observers_room(sim, simulation_room(e)), from = e->state->step;
    sd_status status = advance(sim, n < left ? n : left, messages);
    const int64_t done = e->state->step - from;
    assert(done >= 0 && done <= left && done <= n &&
           (done > 0 || status != SD_OK || engine_status(e) != SD_OK));
    n -= done;
    const bool paused = simulation_is_spread(sim) && pause_on_ranks(sim, from, &status, messages);
    const sd_status after = paused ? SD_OK : simulation_pause(e, from, messages);
    if (status == SD_OK) status = after;
    if (status == SD_OK) status = observers_call(sim, messages);
    engine_tell(e, messages); /* an observer may have called functions with a list of its own */
    if (status != SD_OK) return status;
  }
  /* the lists look at every pose before they are rebuilt; what came after is looked at here */
  return simulation_is_spread(sim) ? SD_OK : neighbours_check_finite(e, e->state->step, messages);
}

sd_status sd_simulation_advance(sd_simulation *sim, int64_t n, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_advance", &outer, messages)) return SD_ERROR_USER;
  const sd_status status =
      n < 0 ? sd_fail(messages, SD_ERROR_USER, "sd_simulation_advance: %lld steps: expected 0 or more",
                      (long long)n)
            : advance_all(sim, n, messages);
  simulation_leave(sim, outer);
  return status;
}

sd_status sd_simulation_rebuild(sd_simulation *sim, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_rebuild", &outer, messages)) return SD_ERROR_USER;
  const sd_status status = simulation_state(sim)
                               ? simulation_rebuild(&sim->engine, engine_lanes(&sim->engine), messages)
                               : sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  simulation_leave(sim, outer);
  return status;
}
