/* simulation.h: a running system: model, state and everything that can be recomputed from them. */
#ifndef SLIPDISK_SIMULATION_H
#define SLIPDISK_SIMULATION_H

#include "slipdisk/measure.h"
#include "slipdisk/model.h"
#include "slipdisk/state.h"

typedef struct sd_simulation sd_simulation;

/* Energies and their changes since step 0 (physics.md 9). All in units of energy.
 * residual = (kinetic + elastic_normal + elastic_tangential + external) - start
 *            - (work + nonconservative_work) + viscous + friction + opening + relaxed, ideally 0. */
typedef struct sd_energy {
  double kinetic_translation, kinetic_rotation; /* of coordinates that are neither driven nor locked */
  double elastic_normal, elastic_tangential;
  double external; /* potential of gravity and constant body forces */
  double start;    /* the sum of the above at step 0, and what disks brought or took along since */
  double work;     /* done by prescribed bodies and coordinates, and by compression */
  double nonconservative_work;       /* put in by the paper's variant of the tangential force */
  double viscous, friction, opening; /* lost */
  double relaxed;                    /* taken out by the relaxer */
  double residual;
  double
      scale; /* the larger of |work| + losses and the kinetic energy, at rest 1e-9 of the other energies: what the
                   residual is compared with */
} sd_energy;

/* Starts a simulation at step 0 of a finished model. The model must outlive it.
 * threads: 0 = chosen from the system's size. */
SD_API sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out,
                                   sd_messages *messages);
/* Goes on from a state (of the same model); takes the state over, also when it fails. */
SD_API sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads,
                                      sd_simulation **out, sd_messages *messages);
SD_API void sd_simulation_free(sd_simulation *simulation);

/* Advances by n steps; crosses the ends of phases by itself and stops at the end of the last (with `until` it
 * ends when the goal is reached: sd_until in model.h).
 * SD_ERROR_NUMERIC: a value is not finite or an overlap is beyond the limit; the message says which
 * disks and which step, and the state is the one at which it was found. */
SD_API sd_status sd_simulation_advance(sd_simulation *simulation, int64_t n, sd_messages *messages);

SD_API const sd_model *sd_simulation_model(const sd_simulation *simulation);
/* The state, with its closed contacts brought up to date. Valid until the next call on the simulation. */
SD_API const sd_state *sd_simulation_state(sd_simulation *simulation);
SD_API double sd_simulation_time(const sd_simulation *simulation); /* step * dt */
SD_API bool sd_simulation_finished(const sd_simulation *simulation);
/* Where a run stands; costs nothing. A phase can end before its length (sd_settle, sd_until in model.h). */
typedef struct sd_stage {
  int64_t step, phase, phase_step; /* as in the state */
  int64_t before;                  /* steps that the phase before this one took */
} sd_stage;
SD_API sd_stage sd_simulation_stage(const sd_simulation *simulation);
/* How far the run is from the goal of `until`, which the model must have. */
SD_API sd_goal sd_simulation_goal(const sd_simulation *simulation);
SD_API sd_energy sd_simulation_energy(const sd_simulation *simulation);
/* Angle turned since the start of the deck, rad (turn + theta). */
SD_API double sd_simulation_angle(const sd_simulation *simulation, uint32_t body);
/* Where a body (number as in the deck: disks, then walls) stands in the state's columns. */
SD_API uint32_t sd_simulation_slot(const sd_simulation *simulation, uint32_t body);
/* Throws away all that can be recomputed and builds it anew; changes not one bit of what follows. */
SD_API sd_status sd_simulation_rebuild(sd_simulation *simulation, sd_messages *messages);
SD_API int sd_simulation_threads(const sd_simulation *simulation);
/* "avx512", "avx2" or "baseline": the instructions the kernels were chosen for. */
SD_API const char *sd_simulation_path(const sd_simulation *simulation);

#endif
