/* simulation.h: a running system: it is stepped, read without copying, extended, saved, cloned.
 *
 * Between two calls the same model gives the same bits, however the steps are divided into calls and with any number of
 * threads; observers, columns and saving only read. Pointers are not NULL where nothing says that they may be.
 *
 * A simulation serves one call at a time. A call is refused (SD_ERROR_USER, with a message that says why; nothing is changed)
 * while another thread is in a call of it, and within its own callbacks:
 *
 *                                                                      observer   force field   other thread
 *   numbers: _model, _step, _time, _finished, _stage, _goal, _threads,
 *   _path, _slot, _angle                                                served     served        refused
 *   state: _state, _column, _column_at, _energy, _save, _save_memory,
 *   _clone, _rebuild                                                    served     refused       refused
 *   changes: _advance, _observe, _add_force_field, _add_disks,
 *   _remove_disks                                                       refused    refused       refused
 *
 * Functions without a status return when refused: NULL, "" (path), false, -1 (step, stage, threads), UINT32_MAX (slot), NAN (the
 * rest). sd_simulation_free waits for the call that is under way: it is freed when that returns. Threads stay in the parent of a
 * fork: a child starts threads of its own at its next step. A child that was forked within a force field cannot end the step: then all
 * but sd_simulation_free is refused.
 */
#ifndef SLIPDISK_SIMULATION_H
#define SLIPDISK_SIMULATION_H

#include "slipdisk/measure.h"
#include "slipdisk/model.h"
#include "slipdisk/state.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sd_simulation sd_simulation;

/* --- beginning and end ----------------------------------------------------------------------------- */

/* Starts at step 0 of a finished model (SD_ERROR_USER: it is not), which must outlive the simulation. threads: 0 = chosen from
 * the system's size.
 * *out is NULL on errors. */
SD_API sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out,
                                   sd_messages *messages);
/* Goes on from a state (of the same model); takes the state over, also when it fails. */
SD_API sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads,
                                      sd_simulation **out, sd_messages *messages);
/* Another one at the same step, which goes on with the same bits. It owns a copy of the model. Observers and force fields are
 * not copied: they may hold on to the first one. */
SD_API sd_status sd_simulation_clone(sd_simulation *simulation, sd_simulation **out,
                                     sd_messages *messages);
/* NULL is allowed. Within a call it is freed when the call returns. */
SD_API void sd_simulation_free(sd_simulation *simulation);

/* --- stepping -------------------------------------------------------------------------------------- */

/* Advances by n steps; crosses the ends of phases by itself and stops at the end of the last (with `until` it
 * ends when the goal is reached: sd_until in model.h).
 * SD_ERROR_NUMERIC: a value is not finite or an overlap is beyond the limit; the message says which
 * disks and which step, and the state is the one at which it was found. SD_INTERRUPTED: an observer asked to stop. */
SD_API sd_status sd_simulation_advance(sd_simulation *simulation, int64_t n, sd_messages *messages);

/* Called after steps that are multiples of `every`; reads only. Returns SD_OK, or SD_INTERRUPTED: sd_simulation_advance
 * returns here. Other values end the run as its errors do. */
typedef sd_status sd_observer(sd_simulation *simulation, void *user);
/* Observers are called in the order in which they were added. SD_ERROR_USER: every < 1, or no
 * observer. */
SD_API sd_status sd_simulation_observe(sd_simulation *simulation, int64_t every,
                                       sd_observer *observer, void *user);

/* Bodies at the positions for which forces are wanted, and the columns to be filled. All by slot, free disks [0, n_free),
 * then driven disks and walls up to n_bodies. */
typedef struct sd_force_columns {
  int64_t step; /* that is being made: positions are those of its end */
  double time;  /* step * dt */
  size_t n_free, n_bodies;
  const uint32_t *id;            /* body numbers */
  const double *x, *y;           /* length; in the periodic box where there is one */
  const double *theta, *turn;    /* rad; the angle is turn + theta */
  const double *vx, *vy, *omega; /* as predicted */
  const double *radius, *mass, *inertia;
  const int32_t *material, *group, *activity; /* activity: [n_free] */
  double *force_x, *force_y,
      *torque; /* [n_free]: 0 at the call, to be added to; force, force length */
} sd_force_columns;
/* Called once in every step, by the thread that called sd_simulation_advance, so that bits do not depend on threads.
 * Its forces should be functions of the columns and of constants: then restarts and clones go on with the same bits. */
typedef void sd_force_field(const sd_force_columns *columns, void *user);
/* Adds a force on the free disks. Forces add up in the order of their fields; their work enters the energy budget as `work`.
 * At step 0 it counts from the start. After loading or cloning, fields are added again before the next step. SD_ERROR_USER: NULL
 * instead of a field; SD_ERROR_IO: no memory. */
SD_API sd_status sd_simulation_add_force_field(sd_simulation *simulation, sd_force_field *field,
                                               void *user, sd_messages *messages);

/* Adds n free disks, in no group, between two steps. They get the next disk numbers, from *first (may be NULL); numbers of
 * walls move up by n: find them by name, or say SD_WALL(w). The energy that they bring is no error of the budget, that of
 * overlaps is. Overlaps beyond max_overlap and equal centres are refused, as decks refuse them. The simulation goes on with a
 * model of its own. SD_ERROR_USER: nothing is changed; while means of every disk are measured no disks are added.
 * SD_ERROR_IO: no memory, the simulation can only be freed. */
SD_API sd_status sd_simulation_add_disks(sd_simulation *simulation, size_t n, const sd_disk *disks,
                                         uint32_t *first, sd_messages *messages);
/* Takes free disks out between two steps: they touch nothing any more, and keep numbers and columns (activity SD_REMOVED). */
SD_API sd_status sd_simulation_remove_disks(sd_simulation *simulation, size_t n,
                                            const uint32_t *disks, sd_messages *messages);

/* --- reading --------------------------------------------------------------------------------------- */

SD_API const sd_model *sd_simulation_model(const sd_simulation *simulation);
SD_API int64_t sd_simulation_step(const sd_simulation *simulation);
SD_API double sd_simulation_time(const sd_simulation *simulation); /* step * dt */
SD_API bool sd_simulation_finished(const sd_simulation *simulation);

/* A column of the state: n elements of `type` (sd_type_size), in place. */
typedef struct sd_column {
  const char *name, *unit, *meaning;
  sd_type type;
  sd_extent extent; /* how many, and in which order: state.h */
  size_t n;
  const void *data;
} sd_column;
/* Column number k; false beyond the last. Contacts are brought up to date first. Valid until the next call that changes the
 * simulation: steps, clones and saving leave columns where they are, new contacts and phases do not. */
SD_API bool sd_simulation_column_at(sd_simulation *simulation, size_t k, sd_column *out);
/* Column of this name: "x", "vx", "contact_force", ...; false: there is none, or no memory. */
SD_API bool sd_simulation_column(sd_simulation *simulation, const char *name, sd_column *out);
/* The state, with its closed contacts brought up to date. Valid until the next call on the simulation. NULL: no memory. */
SD_API const sd_state *sd_simulation_state(sd_simulation *simulation);
/* Slot of a body in the columns; a wall is meant by its number or SD_WALL(w). UINT32_MAX: there is none. */
SD_API uint32_t sd_simulation_slot(const sd_simulation *simulation, uint32_t body);
/* Angle turned since the start of the deck, rad (turn + theta). NAN: no such body. */
SD_API double sd_simulation_angle(const sd_simulation *simulation, uint32_t body);

/* Energies and their changes since step 0 (physics.md 8). All in units of energy.
 * residual = (kinetic + elastic_normal + elastic_tangential + elastic_rolling + cohesion + external) - start
 *            - (work + nonconservative_work) + viscous + friction + rolling + bridge + opening + drag + damping + relaxed,
 * ideally 0. */
typedef struct sd_energy {
  double kinetic_translation,
      kinetic_rotation; /* of coordinates that are neither driven nor locked */
  double elastic_normal, elastic_tangential, elastic_rolling;
  double cohesion; /* of attraction, <= 0; 0 where it ends */
  double external; /* potential of gravity and constant body forces */
  double start;    /* the sum of the above at step 0, and what disks brought or took along since */
  double work; /* done by prescribed bodies and coordinates, by compression and by force fields */
  double nonconservative_work; /* put in by the paper's variant of the tangential force */
  double viscous, friction;    /* lost to dashpots of contacts, and to sliding */
  double rolling, bridge,
      opening;          /* lost to rolling, when capillary bridges form, in contacts that opened */
  double drag, damping; /* lost to viscous drag of fields, and to non-viscous damping */
  double relaxed;       /* taken out by the relaxer */
  double residual;
  double
      scale; /* the larger of |work| + losses and the kinetic energy, at rest 1e-9 of the other energies: what the
                   residual is compared with */
} sd_energy;
SD_API sd_energy sd_simulation_energy(sd_simulation *simulation);

/* Where a run stands; costs nothing. A phase can end before its length (sd_settle, sd_until in model.h). */
typedef struct sd_stage {
  int64_t step, phase, phase_step; /* as in the state */
  int64_t before;                  /* steps that the phase before this one took */
} sd_stage;
SD_API sd_stage sd_simulation_stage(const sd_simulation *simulation);
/* How far the run is from the goal of `until`; without one it means nothing. */
SD_API sd_goal sd_simulation_goal(const sd_simulation *simulation);
SD_API int sd_simulation_threads(const sd_simulation *simulation);
/* "avx512", "avx2" or "baseline": the instructions the kernels were chosen for. */
SD_API const char *sd_simulation_path(const sd_simulation *simulation);

/* --- saving and loading ---------------------------------------------------------------------------- */

/* Writes model and state into a file (HDF5), under a name of its own until it is complete. SD_ERROR_IO: what was there before
 * stays. A program that loads it goes on with the same bits. */
SD_API sd_status sd_simulation_save(sd_simulation *simulation, const char *path,
                                    sd_messages *messages);
/* Loads what sd_simulation_save has written, or a checkpoint of `slipdisk run` (NAME.h5.parts/checkpoint-*.h5), whose deck it
 * holds. The simulation owns its model. SD_ERROR_USER: another version's; SD_ERROR_IO: missing or damaged. */
SD_API sd_status sd_simulation_load(const char *path, int threads, sd_simulation **out,
                                    sd_messages *messages);
/* The same in memory: *size bytes, freed with sd_free. */
SD_API sd_status sd_simulation_save_memory(sd_simulation *simulation, void **data, size_t *size,
                                           sd_messages *messages);
SD_API sd_status sd_simulation_load_memory(const void *data, size_t size, int threads,
                                           sd_simulation **out, sd_messages *messages);

/* Throws away all that can be recomputed and builds it anew; changes not one bit of what follows. */
SD_API sd_status sd_simulation_rebuild(sd_simulation *simulation, sd_messages *messages);

#ifdef __cplusplus
}
#endif

#endif
