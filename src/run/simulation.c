/* simulation.c: creates, advances, saves, loads and clones simulations, and reads their state; see
 * slipdisk/simulation.h. */
#include <assert.h>
#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"
#include "base/message.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "model/model.h"
#include "model/overlaps.h"
#include "model/state.h"
#include "pack/settle.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/small/lanes.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/system/fields.h"
#include "run/loop.h"
#include "run/ranks.h"
#include "run/simulation_private.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

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

/* Returns true if no disk was removed; the step for small systems cannot handle removed disks. */
static bool all_in_play(const sd_state *s) {
  for (size_t i = 0; i < s->n_free; i++)
    if (s->activity[i] == SD_REMOVED) return false;
  return true;
}

/* Arguments of the functions that make a simulation, and their result. */
typedef struct making {
  const sd_model *model; /* sd_simulation_new */
  sd_simulation *from;   /* sd_simulation_clone */
  const char *path;      /* sd_simulation_load */
  const void *data;      /* sd_simulation_load_memory */
  size_t size;
  int threads;
  sd_simulation **out;
  sd_messages *messages;
  sd_status status;
} making;

static void make_new(void *task) {
  making *t = task;
  t->status =
      simulation_new(t->model, t->threads, SIMULATION_SUITABLE, NULL, NULL, t->out, t->messages);
}

/* Calls one of the functions that make a simulation; without memory nothing is made. */
static sd_status try_making(void (*make)(void *task), making t) {
  if (memory_try(make, &t)) return t.status;
  *t.out = NULL;
  return fail_memory(t.messages);
}

sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out,
                            sd_messages *messages) {
  return try_making(make_new,
                    (making){.model = model, .threads = threads, .out = out, .messages = messages});
}

static bool is_finished(const sd_model *model, sd_messages *messages) {
  if (!model->finished)
    sd_fail(messages, SD_ERROR_USER,
            "the model is not finished: call sd_model_finish after the last change");
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

/* Makes a simulation of a given state, without the work that comes once at step 0. Takes over
 * `state`. */
static sd_status create(const sd_model *model, sd_state *state, int threads, simulation_step step,
                        sd_simulation **out, sd_messages *messages) {
  sd_simulation *sim = *out = blank(model);
  sim->engine.state = state;
  const bool small = step == SIMULATION_SUITABLE && lanes_suit(model) && all_in_play(state);
  return build_work(sim, small, small ? 1 : choose_threads(model, threads), messages);
}

/* Search for two disks with the same centre; found: true once a pair was reported. */
typedef struct coincidence {
  const sd_model *model;
  sd_messages *messages;
  bool found;
} coincidence;

/* Returns true if a motion is prescribed for the centre of the disk, which may separate it from
 * another disk in the first step. */
static bool is_moved(const sd_model *m, uint32_t disk) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; m->motions[k].coordinate <= SD_Y && b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] == disk) return true;
  return false;
}

/* Reports the first pair of disks with the same centre that no motion moves; returns true to end
 * the search. */
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

/* Refuses models with two disks at the same centre: their contact has no normal, and they would
 * never touch. Models from a deck were already checked when it was read. */
static sd_status refuse_coincident(const sd_model *model, sd_messages *messages) {
  coincidence c = {.model = model, .messages = messages};
  if (model->deck) return SD_OK;
  if (overlaps_of_disks(model, tell_coincident, &c) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the overlaps");
  return c.found ? SD_ERROR_USER : SD_OK;
}

static sd_status start(const sd_model *model, int threads, simulation_step step,
                       sd_simulation **out, sd_messages *messages) {
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
  status = loop_begin_phase(&(*out)->engine, messages);
  return status != SD_OK ? status : loop_start(&(*out)->engine, messages);
}

/* Makes the simulation of this rank in a run over several ranks; it has no disks yet. */
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

sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads,
                               sd_simulation **out, sd_messages *messages) {
  return simulation_resume(model, state, NULL, threads, SIMULATION_SUITABLE, NULL, NULL, out,
                           messages);
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

settle_measure simulation_rest(sd_simulation *sim) { return settle_measure_now(&sim->engine); }

bool simulation_finished(const sd_simulation *sim) { return loop_finished(&sim->engine); }

/* --- Observers -------------------------------------------------------------------------------- */

sd_status sd_simulation_observe(sd_simulation *sim, int64_t every, sd_observer *observer,
                                void *user) {
  bool outer;
  if (every < 1 || !observer ||
      !simulation_enter(sim, NEED_CHANGE, "sd_simulation_observe", &outer, NULL))
    return SD_ERROR_USER;
  sim->observers = memory_grow(sim->observers, sim->n_observers + 1, sizeof *sim->observers);
  sim->observers[sim->n_observers++] = (simulation_observer){every, observer, user};
  simulation_leave(sim, outer);
  return SD_OK;
}

int64_t observers_steps_left(const sd_simulation *sim, int64_t most) {
  const int64_t step = sim->engine.state->step;
  for (size_t k = 0; k < sim->n_observers; k++) {
    const int64_t left = sim->observers[k].every - step % sim->observers[k].every;
    if (left < most) most = left;
  }
  return most;
}

/* Call all observers that are due, even if one of them asks to stop. */
sd_status observers_call(sd_simulation *sim, sd_messages *messages) {
  const int64_t step = sim->engine.state->step;
  sd_status worst = SD_OK;
  for (size_t k = 0; k < sim->n_observers; k++) {
    const simulation_observer *o = &sim->observers[k];
    if (step % o->every != 0) continue;
    sim->door.observed = true;
    const sd_status status = o->call(sim, o->user);
    sim->door.observed = false;
    if (worst == SD_OK) worst = status;
    if (status != SD_OK && status != SD_INTERRUPTED)
      sd_fail(messages, status, "step %lld: an observer ended the run with status %d",
              (long long)step, (int)status);
  }
  return worst;
}

/* --- Steps ------------------------------------------------------------------------------------ */

static sd_status advance_all(sd_simulation *sim, int64_t n, sd_messages *messages) {
  engine *e = &sim->engine;
  if (sim->ranks) return ranks_advance(sim->ranks, n, messages);
  if (!e->fields) e->state->field_power = 0.0;
  engine_ready(e, messages);
  while (n > 0 && !loop_finished(e)) {
    const int64_t from = e->state->step, room = observers_steps_left(sim, loop_steps_left(e));
    sd_status status = loop_advance(e, n < room ? n : room, messages);
    n -= e->state->step - from;
    sim->door.broken = pool_forked(e->pool);
    if (sim->door.broken)
      status = sd_fail(messages, SD_ERROR_USER,
                       "the process was forked within a force field: its step was not ended");
    if (status == SD_OK) status = observers_call(sim, messages);
    /* An observer may have called a function that has set another message list: set this one
     * again. */
    engine_tell(e, messages);
    if (status != SD_OK) return status;
  }
  /* Finite poses are checked at every rebuild of the neighbour lists; check here the steps since
   * the last rebuild. */
  return neighbours_check_finite(e, e->state->step, messages);
}

sd_status sd_simulation_advance(sd_simulation *sim, int64_t n, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_advance", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status =
      n < 0 ? sd_fail(messages, SD_ERROR_USER,
                      "sd_simulation_advance: %lld steps: expected 0 or more", (long long)n)
            : advance_all(sim, n, messages);
  simulation_leave(sim, outer);
  return status;
}

sd_status sd_simulation_rebuild(sd_simulation *sim, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_rebuild", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = simulation_state(sim)
                               ? loop_rebuild(&sim->engine, engine_lanes(&sim->engine), messages)
                               : sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  simulation_leave(sim, outer);
  return status;
}

enum { DOOMED = 1 };

/* The address of this variable identifies the thread. */
static _Thread_local int thread_mark;
static uintptr_t me(void) { return (uintptr_t)&thread_mark; }

static simulation_lock *door_of(const sd_simulation *sim) {
  /* the cast is safe: reading a number from outside does not change the system */
  return &((sd_simulation *)(uintptr_t)sim)->door;
}

/* Returns true while a force function of the user's program is being called. */
static bool in_force(const sd_simulation *sim) {
  return sim->engine.fields && sim->engine.fields->calling;
}

/* Adds an error message that the function `call` is refused, and returns false. */
static bool refuse(const char *call, const char *why, sd_messages *messages) {
  sd_fail(messages, SD_ERROR_USER, "%s: %s", call, why);
  return false;
}

/* Returns true if memory ran out while the simulation was changed. */
static bool is_lost(const sd_simulation *sim) {
  return !sim->ranks && !engine_is_built(&sim->engine);
}

bool simulation_enter(sd_simulation *sim, simulation_need need, const char *call, bool *outer,
                      sd_messages *messages) {
  simulation_lock *d = &sim->door;
  uintptr_t holder = 0;
  *outer = atomic_compare_exchange_strong(&d->holder, &holder, me());
  if (!*outer && (holder & ~(uintptr_t)DOOMED) != me())
    return refuse(call, "another thread is in a call of this simulation", messages);
  while (*outer && atomic_load(&d->readers) > 0) sched_yield();
  const char *why =
      in_force(sim)                        ? "not within a force field: its step is being made"
      : d->observed && need == NEED_CHANGE ? "not within an observer, which only reads"
      : d->broken    ? "the process was forked within a force field: its step was not ended"
      : is_lost(sim) ? "memory ran out in an earlier call, in which this simulation was lost"
                     : NULL;
  if (!why) return true;
  simulation_leave(sim, *outer);
  return refuse(call, why, messages);
}

void simulation_leave(sd_simulation *sim, bool outer) {
  if (outer && atomic_exchange(&sim->door.holder, 0) & DOOMED) simulation_free(sim);
}

void sd_simulation_free(sd_simulation *sim) {
  if (sim && (atomic_fetch_or(&sim->door.holder, DOOMED) & ~(uintptr_t)DOOMED) == 0)
    simulation_free(sim);
}

bool simulation_read_begin(const sd_simulation *sim) {
  simulation_lock *d = door_of(sim);
  atomic_fetch_add(&d->readers, 1);
  const uintptr_t holder = atomic_load(&d->holder) & ~(uintptr_t)DOOMED;
  if ((holder == 0 || holder == me()) && !is_lost(sim)) return true;
  atomic_fetch_sub(&d->readers, 1);
  return false;
}

void simulation_read_end(const sd_simulation *sim) { atomic_fetch_sub(&door_of(sim)->readers, 1); }

/* --- Reading numbers and columns -------------------------------------------------------------- */

const sd_model *sd_simulation_model(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return NULL;
  const sd_model *model = sim->engine.model;
  simulation_read_end(sim);
  return model;
}

sd_status simulation_store(sd_simulation *sim, bool rows, sd_messages *messages) {
  engine *e = &sim->engine;
  if (sim->ranks) return ranks_store(sim->ranks, rows, messages);
  motion_store(e);
  const sd_status status = rows ? contacts_store_rows(e) : contacts_store(e);
  return status == SD_OK ? SD_OK
                         : sd_fail(messages, status, "no memory for the contacts of the state");
}

const sd_state *simulation_state(sd_simulation *sim) {
  return simulation_store(sim, false, NULL) == SD_OK ? sim->engine.state : NULL;
}

const sd_state *sd_simulation_state(sd_simulation *sim) {
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_state", &outer, NULL)) return NULL;
  const sd_state *state = simulation_state(sim);
  simulation_leave(sim, outer);
  return state;
}

/* Returns the state of this rank, for those of its numbers that are the same on every rank. */
static const sd_state *run_state(const sd_simulation *sim) { return sim->engine.state; }

int64_t sd_simulation_step(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return -1;
  const int64_t step = run_state(sim)->step;
  simulation_read_end(sim);
  return step;
}

bool sd_simulation_column_at(sd_simulation *sim, size_t k, sd_column *out) {
  bool outer;
  if (k >= sd_field_count ||
      !simulation_enter(sim, NEED_STATE, "sd_simulation_column", &outer, NULL))
    return false;
  const bool good = simulation_state(sim);
  const sd_field *f = &sd_fields[k];
  if (good)
    *out = (sd_column){.name = f->name,
                       .unit = f->unit,
                       .meaning = f->meaning,
                       .type = f->type,
                       .extent = f->extent,
                       .n = sd_extent_size(sim->engine.state, f->extent),
                       .data = sd_field_data(sim->engine.state, f)};
  simulation_leave(sim, outer);
  return good;
}

bool sd_simulation_column(sd_simulation *sim, const char *name, sd_column *out) {
  for (size_t k = 0; k < sd_field_count; k++)
    if (strcmp(sd_fields[k].name, name) == 0) return sd_simulation_column_at(sim, k, out);
  return false;
}

double sd_simulation_time(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return NAN;
  const double time = (double)run_state(sim)->step * sim->engine.model->dt;
  simulation_read_end(sim);
  return time;
}

bool sd_simulation_finished(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return false;
  const bool over = simulation_finished(sim);
  simulation_read_end(sim);
  return over;
}

sd_stage sd_simulation_stage(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return (sd_stage){-1, -1, -1, -1};
  const sd_state *s = run_state(sim);
  const sd_stage stage = {.step = s->step,
                          .phase = s->phase,
                          .phase_step = s->phase_step,
                          .before = s->phase > 0 ? s->phase_steps[s->phase - 1] : 0};
  simulation_read_end(sim);
  return stage;
}

sd_goal sd_simulation_goal(const sd_simulation *sim) {
  if (!simulation_read_begin(sim))
    return (sd_goal){.value = NAN, .error = NAN, .goal = NAN, .measured = NAN};
  const sd_goal goal = sd_goal_of(sim->engine.model, run_state(sim));
  simulation_read_end(sim);
  return goal;
}

sd_energy sd_simulation_energy(sd_simulation *sim) {
  sd_energy energy;
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_energy", &outer, NULL)) {
    double *numbers = (double *)&energy;
    for (size_t k = 0; k < sizeof energy / sizeof *numbers; k++) numbers[k] = NAN;
    return energy;
  }
  energy = energy_of(&sim->engine);
  simulation_leave(sim, outer);
  return energy;
}

/* Returns the slot of a body in the state, given the number of the disk, or SD_WALL(k) for wall k;
 * UINT32_MAX: there is no such body. */
static uint32_t slot_in(const sd_simulation *sim, uint32_t body) {
  const sd_model *m = sim->engine.model;
  if (body >= SD_WALL(0) && body - SD_WALL(0) < m->n_walls)
    body = body - SD_WALL(0) + (uint32_t)m->n_disks;
  return body < sd_model_bodies(m) ? engine_slot(&sim->engine, body) : UINT32_MAX;
}

uint32_t sd_simulation_slot(const sd_simulation *sim, uint32_t body) {
  if (!simulation_read_begin(sim)) return UINT32_MAX;
  const uint32_t slot = slot_in(sim, body);
  simulation_read_end(sim);
  return slot;
}

double sd_simulation_angle(const sd_simulation *sim, uint32_t body) {
  if (!simulation_read_begin(sim)) return NAN;
  const uint32_t slot = slot_in(sim, body);
  const sd_state *s = sim->engine.state;
  const double angle = slot == UINT32_MAX ? NAN : s->turn[slot] + s->theta[slot];
  simulation_read_end(sim);
  return angle;
}

int sd_simulation_threads(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return -1;
  const int threads = engine_threads(&sim->engine);
  simulation_read_end(sim);
  return threads;
}

const char *sd_simulation_path(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return "";
  const char *path = engine_kernels(&sim->engine)->name;
  simulation_read_end(sim);
  return path;
}

/* --- Saved simulations and clones ------------------------------------------------------------- */

/* HDF5 path of the model. A saved simulation has the groups of a checkpoint, /state, /parameters
 * and /summary, and this dataset with the bytes of the model (model/model.h). A checkpoint of a run
 * does not have it; its model is read from the deck in /parameters. */
static const char IMAGE[] = "/model/image";

/* --- Saving ----------------------------------------------------------------------------------- */

/* Stores the bytes of the model in the file, as 4-byte words. */
static void put_image(h5_file *file, const sd_model *model) {
  size_t size = 0;
  void *bytes = model_serialize(model, &size);
  const size_t n = (size + 3) / 4;
  if (h5_check_memory(file, bytes, IMAGE)) {
    h5_put(file, IMAGE, SD_U32, 1, &n, bytes, true);
    h5_attr_i64(file, IMAGE, "bytes", (int64_t)size);
    h5_attr_text(file, IMAGE, "description", "the model, for this version of the library");
  }
  free(bytes);
}

static sd_status put_summary(h5_file *file, sd_simulation *sim, const sd_state *state,
                             sd_messages *messages) {
  const sd_model *model = sim->engine.model;
  const sd_energy energy = energy_of(&sim->engine);
  summary found = {0};
  provenance origin = {0};
  provenance_new(&origin, model);
  provenance_refresh(&origin, 1, engine_threads(&sim->engine), engine_kernels(&sim->engine)->name);
  summary_collect(&found, model, state, NULL, &energy, NAN);
  const sd_status status =
      summary_disks_collect(&found.packing, model, state, engine_threads(&sim->engine), messages);
  if (status == SD_OK) {
    provenance_write(&origin, file);
    summary_write(&found, file);
  }
  summary_free(&found);
  provenance_free(&origin);
  return status;
}

/* Builds the file of a saved simulation in memory; NULL: that failed, and a message was added. */
static h5_file *file_of(sd_simulation *sim, sd_messages *messages) {
  h5_file *file = NULL;
  const sd_state *state = simulation_state(sim);
  if (!state) {
    sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
    return NULL;
  }
  if (h5_new(&file, messages) != SD_OK) return NULL;
  if (put_summary(file, sim, state, messages) != SD_OK) {
    h5_close(file, NULL);
    return NULL;
  }
  put_image(file, sim->engine.model);
  checkpoint_put_state(file, state);
  return file;
}

sd_status sd_simulation_save(sd_simulation *sim, const char *path, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_save", &outer, messages))
    return SD_ERROR_USER;
  h5_file *file = file_of(sim, messages);
  const sd_status status = file ? h5_save(file, -1, path, NULL, messages) : SD_ERROR_IO;
  simulation_leave(sim, outer);
  return status;
}

sd_status sd_simulation_save_memory(sd_simulation *sim, void **data, size_t *size,
                                    sd_messages *messages) {
  bool outer;
  *data = NULL;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_save_memory", &outer, messages))
    return SD_ERROR_USER;
  h5_file *file = file_of(sim, messages);
  const sd_status status = file ? h5_save_memory(file, data, size, messages) : SD_ERROR_IO;
  simulation_leave(sim, outer);
  return status;
}

/* --- Loading ---------------------------------------------------------------------------------- */

sd_status simulation_model_of(const comm *c, const provenance *origin, sd_model **out,
                              sd_messages *messages) {
  if (comm_rank(c) > 0) return ranks_load(c, NULL, "", 0, NULL, out, messages);
  char *path = provenance_deck(origin->deck_path, origin->directory),
       *lines = memory_text(origin->deck_overrides);
  size_t n = 0;
  const char **overrides = text_lines(lines, &n);
  const sd_status status =
      c ? ranks_load(c, origin->deck_text, path, n, overrides, out, messages)
        : sd_deck_load_text(origin->deck_text, path, n, overrides, out, messages);
  free(overrides);
  free(lines);
  free(path);
  return status;
}

/* Reads the model from the bytes stored in a saved simulation. */
static sd_status get_image(const h5_file *file, sd_model **out, sd_messages *messages) {
  const int64_t size = h5_get_attr_i64(file, IMAGE, "bytes", -1);
  sd_status status = SD_OK;
  size_t dims[H5_MAX_RANK] = {0};
  int rank = 0;
  if (h5_shape(file, IMAGE, &rank, dims, messages) != SD_OK) return SD_ERROR_IO;
  if (rank != 1 || size < 0 || ((size_t)size + 3) / 4 != dims[0])
    return sd_fail(messages, SD_ERROR_IO, "the saved model is damaged");
  void *bytes = h5_column(file, IMAGE, SD_U32, dims[0], &status, messages);
  if (bytes) status = image_read(bytes, (size_t)size, out, messages);
  free(bytes);
  return status;
}

/* Reads the model from the deck stored in the file, and checks that the files which the deck names
 * have not changed. */
static sd_status get_deck(const h5_file *file, sd_model **out, sd_messages *messages) {
  provenance origin;
  provenance_read(&origin, file);
  sd_status status = simulation_model_of(NULL, &origin, out, messages);
  if (status == SD_OK && origin.inputs != 0 && origin.inputs != provenance_inputs(*out))
    status = sd_fail(messages, SD_ERROR_USER,
                     "the files that the deck reads have changed since the run began");
  provenance_free(&origin);
  return status;
}

/* Makes a simulation from an open file; closes the file in any case. */
static sd_status load(h5_file *file, const char *name, int threads, sd_simulation **out,
                      sd_messages *messages) {
  sd_model *model = NULL;
  sd_state *state = NULL;
  sd_status status = checkpoint_check_format(file, name, messages);
  if (status == SD_OK && !h5_exists(file, "/state"))
    status = sd_fail(messages, SD_ERROR_USER,
                     "%s holds no state from which a simulation could go on", name);
  if (status == SD_OK)
    status = h5_exists(file, IMAGE) ? get_image(file, &model, messages)
                                    : get_deck(file, &model, messages);
  assert(status != SD_OK || model);
  if (status == SD_OK) status = checkpoint_get_state(file, model, &state, messages);
  h5_close(file, NULL);
  if (status == SD_OK) status = sd_simulation_resume(model, state, threads, out, messages);
  if (status == SD_OK)
    (*out)->owned = model;
  else
    sd_model_free(model);
  return status;
}

static void make_loaded(void *task) {
  making *t = task;
  h5_file *file = NULL;
  t->status = t->path ? h5_open_whole(t->path, &file, t->messages)
                      : h5_open_memory(t->data, t->size, &file, t->messages);
  const char *name = t->path ? t->path : "the saved simulation";
  if (t->status == SD_OK) t->status = load(file, name, t->threads, t->out, t->messages);
}

sd_status sd_simulation_load(const char *path, int threads, sd_simulation **out,
                             sd_messages *messages) {
  *out = NULL;
  return try_making(make_loaded,
                    (making){.path = path, .threads = threads, .out = out, .messages = messages});
}

sd_status sd_simulation_load_memory(const void *data, size_t size, int threads, sd_simulation **out,
                                    sd_messages *messages) {
  *out = NULL;
  return try_making(
      make_loaded,
      (making){.data = data, .size = size, .threads = threads, .out = out, .messages = messages});
}

/* --- Cloning ---------------------------------------------------------------------------------- */

static sd_state *state_clone(const sd_model *model, const sd_state *state) {
  sd_state *copy = sd_state_new(model);
  if (!copy || state_size_like(copy, state) != SD_OK) {
    sd_state_free(copy);
    return NULL;
  }
  for (size_t k = 0; k < sd_field_count; k++) {
    const size_t n = sd_extent_size(state, sd_fields[k].extent) * sd_type_size(sd_fields[k].type);
    if (n) memcpy(sd_field_data(copy, &sd_fields[k]), sd_field_data(state, &sd_fields[k]), n);
  }
  assert(!sd_state_difference(state, copy));
  return copy;
}

static sd_status clone_simulation(sd_simulation *sim, sd_simulation **out, sd_messages *messages) {
  const sd_state *state = simulation_state(sim);
  sd_model *model = state ? sd_model_clone(sim->engine.model) : NULL;
  sd_state *copy = model ? state_clone(model, state) : NULL;
  if (!copy) {
    sd_model_free(model);
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the clone");
  }
  sd_status status = sd_simulation_resume(model, copy, engine_threads(&sim->engine), out, messages);
  if (status == SD_OK)
    (*out)->owned = model;
  else
    sd_model_free(model);
  return status;
}

static void make_clone(void *task) {
  making *t = task;
  t->status = clone_simulation(t->from, t->out, t->messages);
}

sd_status sd_simulation_clone(sd_simulation *sim, sd_simulation **out, sd_messages *messages) {
  bool outer;
  *out = NULL;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_clone", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status =
      try_making(make_clone, (making){.from = sim, .out = out, .messages = messages});
  simulation_leave(sim, outer);
  return status;
}
