/* simulation_read.c: numbers and columns of a running system; see slipdisk/simulation.h. Numbers can be read in callbacks, too. */
#include <math.h>
#include <string.h>

#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "run/simulation_private.h"

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
  return status == SD_OK ? SD_OK : sd_fail(messages, status, "no memory for the contacts of the state");
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

/* Numbers of the run, which every rank has alike. */
static const sd_state *run_state(const sd_simulation *sim) { return sim->engine.state; }

int64_t sd_simulation_step(const sd_simulation *sim) {
  if (!simulation_read_begin(sim)) return -1;
  const int64_t step = run_state(sim)->step;
  simulation_read_end(sim);
  return step;
}

bool sd_simulation_column_at(sd_simulation *sim, size_t k, sd_column *out) {
  bool outer;
  if (k >= sd_field_count || !simulation_enter(sim, NEED_STATE, "sd_simulation_column", &outer, NULL))
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
  if (!simulation_read_begin(sim)) return (sd_goal){.value = NAN, .error = NAN, .goal = NAN, .measured = NAN};
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

static uint32_t slot_in(const sd_simulation *sim, uint32_t body) {
  const sd_model *m = sim->engine.model;
  if (body >= SD_WALL(0) && body - SD_WALL(0) < m->n_walls) body = body - SD_WALL(0) + (uint32_t)m->n_disks;
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
