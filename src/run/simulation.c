/* simulation.c: phases, threads, and the way in and out of a running system; see slipdisk/simulation.h. */
#include "slipdisk/simulation.h"

#include <stdlib.h>

#include "base/memory.h"
#include "model/overlaps.h"
#include "pack/settle.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/fields.h"
#include "physics/small/lanes.h"
#include "run/loop.h"
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

static sd_status fail_new(sd_simulation *sim, sd_simulation **out, sd_status status) {
  sd_simulation_free(sim);
  *out = NULL;
  return status;
}

/* The step of small systems knows no disks that were taken out. */
static bool all_in_play(const sd_state *s) {
  for (size_t i = 0; i < s->n_free; i++)
    if (s->activity[i] == SD_REMOVED) return false;
  return true;
}

sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out, sd_messages *messages) {
  return simulation_new(model, threads, SIMULATION_SUITABLE, NULL, NULL, out, messages);
}

static bool is_finished(const sd_model *model, sd_messages *messages) {
  if (!model->finished)
    sd_fail(messages, SD_ERROR_USER, "the model is not finished: call sd_model_finish after the last change");
  return model->finished;
}

static sd_simulation *blank(const sd_model *model) {
  sd_simulation *sim = memory_lines(sizeof *sim);
  *sim = (sd_simulation){.engine = {.model = model}};
  return sim;
}

static sd_status build_work(sd_simulation *sim, bool small, int threads, sd_messages *messages) {
  engine *e = &sim->engine;
  if (threads > 1) e->pool = pool_new(threads);
  state_spread(e->state, e->pool);
  return loop_build(e, small, threads, messages);
}

/* All but what is done once at step 0. */
static sd_status create(const sd_model *model, sd_state *state, int threads, simulation_step step,
                        sd_simulation **out, sd_messages *messages) {
  sd_simulation *sim = *out = blank(model);
  sim->engine.state = state;
  const bool small = step == SIMULATION_SUITABLE && lanes_suit(model) && all_in_play(state);
  return build_work(sim, small, small ? 1 : choose_threads(model, threads), messages);
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

static sd_status start(const sd_model *model, int threads, simulation_step step, sd_simulation **out,
                       sd_messages *messages) {
  sd_status status = refuse_coincident(model, messages);
  if (status == SD_OK) status = state_refuse(model, messages);
  if (status != SD_OK) return status;
  sd_state *state = sd_state_new(model);
  if (!state) return sd_fail(messages, SD_ERROR_IO, "out of memory for the state");
  if (engine_fill_state(model, state) != SD_OK) {
    sd_state_free(state);
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  }
  status = create(model, state, threads, step, out, messages);
  if (status != SD_OK) return status;
  loop_begin_phase(&(*out)->engine);
  return loop_start(&(*out)->engine, messages);
}

/* One of several ranks. */
static sd_simulation *join(const sd_model *model, const comm *c, volatile sig_atomic_t *stop) {
  sd_simulation *sim = blank(model);
  sim->ranks = ranks_new(c, &sim->engine, stop);
  return sim;
}

sd_status simulation_new(const sd_model *model, int threads, simulation_step step, const comm *c,
                         volatile sig_atomic_t *stop, sd_simulation **out, sd_messages *messages) {
  *out = NULL;
  if (!is_finished(model, messages)) return SD_ERROR_USER;
  if (c) *out = join(model, c, stop);
  const sd_status status = c ? ranks_start((*out)->ranks, choose_threads(model, threads), messages)
                             : start(model, threads, step, out, messages);
  return status == SD_OK ? SD_OK : fail_new(*out, out, status);
}

sd_status simulation_resume(const sd_model *model, sd_state *state, uint32_t *order, int threads,
                            simulation_step step, const comm *c, volatile sig_atomic_t *stop,
                            sd_simulation **out, sd_messages *messages) {
  *out = NULL;
  if (!is_finished(model, messages)) {
    sd_state_free(state);
    free(order);
    return SD_ERROR_USER;
  }
  if (c) *out = join(model, c, stop);
  const sd_status status =
      c ? ranks_spread((*out)->ranks, state, order, choose_threads(model, threads), messages)
        : create(model, state, threads, step, out, messages);
  return status == SD_OK ? SD_OK : fail_new(*out, out, status);
}

sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads, sd_simulation **out,
                               sd_messages *messages) {
  return simulation_resume(model, state, NULL, threads, SIMULATION_SUITABLE, NULL, NULL, out, messages);
}

void simulation_free(sd_simulation *sim) {
  ranks_free(sim->ranks);
  loop_release(&sim->engine);
  fields_free(&sim->engine);
  pool_free(sim->engine.pool);
  sd_state_free(sim->engine.state);
  sd_model_free(sim->owned);
  free(sim->observers);
  free(sim);
}

engine *simulation_engine(sd_simulation *sim) { return &sim->engine; }

const slot_table *simulation_slots(const sd_simulation *sim) { return engine_slots(&sim->engine); }

bool simulation_is_small(const sd_simulation *sim) { return engine_lanes(&sim->engine); }

bool simulation_is_spread(const sd_simulation *sim) { return sim->ranks != NULL; }

settle_measure simulation_rest(sd_simulation *sim) { return settle_look(&sim->engine); }

bool simulation_finished(const sd_simulation *sim) { return loop_finished(&sim->engine); }

static sd_status advance_all(sd_simulation *sim, int64_t n, sd_messages *messages) {
  engine *e = &sim->engine;
  if (sim->ranks) return ranks_advance(sim->ranks, n, messages);
  if (!e->fields) e->state->field_power = 0.0;
  engine_ready(e, messages);
  while (n > 0 && !loop_finished(e)) {
    const int64_t from = e->state->step, room = observers_room(sim, loop_room(e));
    sd_status status = loop_advance(e, n < room ? n : room, messages);
    n -= e->state->step - from;
    sim->door.broken = pool_forked(e->pool);
    if (sim->door.broken)
      status = sd_fail(messages, SD_ERROR_USER,
                       "the process was forked within a force field: its step was not ended");
    if (status == SD_OK) status = observers_call(sim, messages);
    engine_tell(e, messages); /* an observer may have called functions with a list of its own */
    if (status != SD_OK) return status;
  }
  /* the lists look at every pose before they are rebuilt; what came after is looked at here */
  return neighbours_check_finite(e, e->state->step, messages);
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
                               ? loop_rebuild(&sim->engine, engine_lanes(&sim->engine), messages)
                               : sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  simulation_leave(sim, outer);
  return status;
}
