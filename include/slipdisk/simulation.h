/* simulation.h: functions that advance a simulation, read its columns in place, extend, save and
 * clone it.
 *
 * The same model gives the same results, bit for bit, however its steps are divided into calls and
 * with any number of threads; observers, reading of columns and saving change nothing. Pointers
 * must not be NULL unless a comment says that they may be.
 *
 * A simulation serves one call at a time. A call is refused (SD_ERROR_USER, with a message that
 * says why; nothing is changed) while another thread is in a call of the same simulation, and
 * within its own callbacks:
 *
 *                                                           observer   force field   other thread
 *   numbers: _model, _step, _time, _finished, _stage,
 *   _goal, _threads, _path, _slot, _angle, _get, _index     served     served        refused
 *   state: _state, _column, _column_at, _energy, _save,
 *   _save_memory, _clone, _rebuild                          served     refused       refused
 *   changes: _advance, _observe, _add_force_field,
 *   _add_disks, _remove_disks, _set                         refused    refused       refused
 *
 * Functions without a status then return NULL, "" (path), false, -1 (step, stage, threads),
 * UINT32_MAX (slot) or NAN (all others). sd_simulation_free takes effect when the call that is
 * under way returns.
 *
 * After a fork the threads stay in the parent; a child starts threads of its own at its next step.
 * A child that was forked within a force field cannot finish the step: every call but
 * sd_simulation_free is refused there. So it is after a change that memory did not suffice to end
 * (SD_ERROR_IO): the simulation is lost then, and goes on from what was saved.
 */
#ifndef SLIPDISK_SIMULATION_H
#define SLIPDISK_SIMULATION_H

#include "slipdisk/measure.h"
#include "slipdisk/model.h"
#include "slipdisk/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A simulation, opaque; sd_simulation_free frees it. */
typedef struct sd_simulation sd_simulation;

/* --- beginning and end ------------------------------------------------------------------------ */

/* Makes a simulation at step 0 of a finished model, which must outlive it. threads: number of
 * threads; 0: chosen by the size of the system. Returns SD_ERROR_USER if the model is not finished;
 * *out is NULL on errors. */
SD_API sd_status sd_simulation_new(const sd_model *model, int threads, sd_simulation **out,
                                   sd_messages *messages);
/* Makes a simulation that continues from a state of the same model. The simulation owns the
 * state from then on, and frees it also if this function fails. */
SD_API sd_status sd_simulation_resume(const sd_model *model, sd_state *state, int threads,
                                      sd_simulation **out, sd_messages *messages);
/* Makes a copy at the same step; its further steps give the same results, bit for bit. It owns a
 * copy of the model. Observers and force fields are not copied, since their `user` data may
 * belong to the original. */
SD_API sd_status sd_simulation_clone(sd_simulation *simulation, sd_simulation **out,
                                     sd_messages *messages);
/* Frees a simulation; NULL is allowed. Within a call of the same simulation it takes effect when
 * that call returns. */
SD_API void sd_simulation_free(sd_simulation *simulation);

/* --- stepping --------------------------------------------------------------------------------- */

/* Advances a simulation by n steps. It goes from phase to phase by itself and stops at the end of
 * the last one, which with `until` is the step at which the goal is reached (sd_until in model.h).
 * Returns SD_ERROR_NUMERIC if a value is not finite or an overlap is beyond the limit: the message
 * names the disks and the step, and the state is the one in which it was found. Returns
 * SD_INTERRUPTED if an observer asked to stop. */
SD_API sd_status sd_simulation_advance(sd_simulation *simulation, int64_t n, sd_messages *messages);

/* A function that is called after each step whose number is a multiple of `every`; it may only
 * read. It returns SD_OK, or SD_INTERRUPTED to let sd_simulation_advance return at this step; other
 * values end the run as an error. */
typedef sd_status sd_observer(sd_simulation *simulation, void *user);
/* Adds an observer, which is called with `user`. Observers are called in the order in which they
 * were added. Returns SD_ERROR_USER if every < 1 or if observer is NULL. */
SD_API sd_status sd_simulation_observe(sd_simulation *simulation, int64_t every,
                                       sd_observer *observer, void *user);

/* Arguments of a force field: the bodies, at the positions at which the forces are needed, and
 * the arrays to which the field adds the forces. All arrays are ordered by slot: free disks [0,
 * n_free), then driven disks and walls up to n_bodies. */
typedef struct sd_force_columns {
  int64_t step; /* number of the step that is being made; positions are those at the end of it */
  double time;  /* time of the positions: step * dt */
  size_t n_free, n_bodies;       /* number of free disks; number of all bodies */
  const uint32_t *id;            /* [n_bodies] body numbers */
  const double *x, *y;           /* [n_bodies] position, length, wrapped into a periodic box */
  const double *theta, *turn;    /* [n_bodies] two parts of the angle, which is turn + theta, rad */
  const double *vx, *vy, *omega; /* [n_bodies] predicted velocities and angular velocity */
  /* [n_bodies] radius, mass and moment of inertia, as in the state */
  const double *radius, *mass, *inertia;
  /* [n_bodies] numbers of material and group; [n_free] activity, SD_IN_PLAY ... of state.h */
  const int32_t *material, *group, *activity;
  /* [n_free] force and torque on each free disk, to which the field adds its own; 0 at first */
  double *force_x, *force_y, *torque;
} sd_force_columns;
/* A force field: a function that is called once in every step, by the thread that called
 * sd_simulation_advance, so that results do not depend on the number of threads. If its forces
 * depend on the columns and on constants only, restarts and clones continue with the same
 * results, bit for bit. */
typedef void sd_force_field(const sd_force_columns *columns, void *user);
/* Adds a force field on the free disks, which is called with `user`. Forces of several fields add
 * up in the order in which the fields were added; their work is part of `work` in the energy
 * budget. A field added at step 0 acts from the start. A simulation that was loaded or cloned has
 * no fields: they are added again before the next step. Returns SD_ERROR_USER if field is NULL,
 * SD_ERROR_IO if there is no memory. */
SD_API sd_status sd_simulation_add_force_field(sd_simulation *simulation, sd_force_field *field,
                                               void *user, sd_messages *messages);

/* Adds n free disks, in no group, between two steps. They get the next n disk numbers, the first of
 * which is written to *first (NULL is allowed). Numbers of walls grow by n: find walls by name, or
 * use SD_WALL(w). The energy of the new disks is added to `start` of the energy budget, but not
 * that of their overlaps, which shows in the residual. Overlaps beyond max_overlap and equal
 * centres are refused, as in decks. The simulation owns its model from then on. Returns
 * SD_ERROR_USER, with nothing changed, for mistakes and while means of every disk are measured.
 * Returns SD_ERROR_IO if there is no memory: the simulation may then be lost. */
SD_API sd_status sd_simulation_add_disks(sd_simulation *simulation, size_t n, const sd_disk *disks,
                                         uint32_t *first, sd_messages *messages);
/* Removes n free disks between two steps. They touch nothing any more, but keep their numbers and
 * their rows in the columns, with the activity SD_REMOVED. */
SD_API sd_status sd_simulation_remove_disks(sd_simulation *simulation, size_t n,
                                            const uint32_t *disks, sd_messages *messages);

/* Bonds n pairs of bodies between two steps, by their numbers or SD_WALL(w): two surfaces whose gap
 * is at most bond_gap of their law. A bond carries no force when it is made. Pairs that are bonded
 * already stay as they are. Returns SD_ERROR_USER, with nothing changed, if a pair cannot be
 * bonded. SD_ERROR_IO: no memory. */
SD_API sd_status sd_simulation_bond(sd_simulation *simulation, size_t n, const uint32_t (*pairs)[2],
                                    sd_messages *messages);

/* --- steering --------------------------------------------------------------------------------- */

/* Sets a quantity between two steps, for n indices at once. index: [n]; NULL: 0 ... n - 1. values:
 * [n], or [2 n] for "position" and "velocity": x and y in turn.
 *
 *   name                               index
 *   x y position angle                 number of a free disk, or of one that is held
 *   vx vy velocity omega               number of a free disk
 *   radius mass inertia                number of a free disk; each leaves the other two as they are
 *   held                               number of a disk, free or fixed; 1 holds it, 0 releases it
 *   gravity                            SD_X, SD_Y
 *   law.mu law.k_n ...                 a n + b, for two of the n materials; the law of b and a
 *                                      follows. Each constant of a law that is a number, by its
 *                                      name in decks
 *   motion.velocity motion.amplitude   number of a motion that has this constant
 *   motion.force motion.pressure
 *
 * Energy: changes of kinetic, potential and stored energy are added to `work` of the energy budget,
 * those by "held" to `start`: the budget has no energy of a held disk.
 *
 * Contacts: a disk that is set to another place begins its contacts anew, with relaxed springs.
 * All other changes keep the tangential displacement zeta of a contact, and what it has lost; its
 * forces follow from the new constants, and it slides if it is beyond the new limit of friction.
 * With laws that store the tangential force (Mindlin's stiffness, dashpots) this force stays.
 *
 * Held disks stay where they are, or as motions that name them move them; forces do not move them.
 * A disk that is held loses its velocity, one that is released keeps it. From then on only `held`
 * says whether motions move a disk.
 *
 * Integrator: forces and accelerations are evaluated anew, as at step 0. With Gear's the third and
 * higher derivatives of coordinates that were set (by a size: of all three) restart at 0, as at
 * step 0; others keep them, so that a constant may change a little in every step.
 *
 * Motions go on from where they are: with another velocity or amplitude a body does not jump, so
 * that the centre of a vibration moves unless u is 0 then. Angles that are set do not count as
 * rotation in means. Weights of loads, part of their force, do not follow gravity.
 *
 * The changed constants are part of clones and saved simulations; the deck is not changed, so that
 * sd_model_deck is NULL after a change of constants. Results have the same bits with any number of
 * threads. Returns SD_ERROR_USER, with nothing changed, for mistakes: among them locked and
 * prescribed coordinates, overlaps beyond max_overlap, unstable time steps, and all positions and
 * angles while means of every disk are measured. SD_ERROR_IO if there is no memory,
 * SD_ERROR_NUMERIC if a result is not finite: the simulation can then only be freed. */
SD_API sd_status sd_simulation_set(sd_simulation *simulation, const char *name, size_t n,
                                   const uint32_t *index, const double *values,
                                   sd_messages *messages);
/* Returns the present value of a quantity of sd_simulation_set that has one number per index; NAN:
 * there is no such quantity or index. */
SD_API double sd_simulation_get(const sd_simulation *simulation, const char *name, uint32_t index);
/* Returns the index that sd_simulation_set takes for a quantity and the name of a disk, a motion or
 * a material. other: for laws the second material, NULL: the same as the first. UINT32_MAX: there
 * is no such quantity or name. */
SD_API uint32_t sd_simulation_index(const sd_simulation *simulation, const char *quantity,
                                    const char *name, const char *other);

/* --- reading ---------------------------------------------------------------------------------- */

/* Returns the model of a simulation, which owns it or borrows it from the caller of
 * sd_simulation_new. */
SD_API const sd_model *sd_simulation_model(const sd_simulation *simulation);
/* Returns the number of steps made since the start of the run. */
SD_API int64_t sd_simulation_step(const sd_simulation *simulation);
/* Returns the simulated time: step * dt. */
SD_API double sd_simulation_time(const sd_simulation *simulation);
/* Returns true if the last phase is over, so that no step is left to be made. */
SD_API bool sd_simulation_finished(const sd_simulation *simulation);

/* A column of the state, in place: n elements of `type` at `data`. */
typedef struct sd_column {
  /* name, unit and meaning of the column, as in the table sd_fields */
  const char *name, *unit, *meaning;
  sd_type type;     /* type of the elements; sd_type_size returns their size */
  sd_extent extent; /* meaning and order of the elements (sd_extent in state.h) */
  size_t n;         /* number of elements */
  const void *data; /* address of the first element; the memory belongs to the simulation */
} sd_column;
/* Finds column number k, in the order of sd_fields; false: k is beyond the last. Columns of
 * contacts are brought up to date first. The column is valid until the next call that changes
 * the simulation. Steps, clones and saving leave columns at their addresses; new contacts and
 * new phases may move them. */
SD_API bool sd_simulation_column_at(sd_simulation *simulation, size_t k, sd_column *out);
/* Finds a column by its name, like "x", "vx", "contact_force"; false: there is none, or no
 * memory. */
SD_API bool sd_simulation_column(sd_simulation *simulation, const char *name, sd_column *out);
/* Returns the state, with its closed contacts brought up to date. It is valid until the next call
 * of the simulation. NULL: no memory. */
SD_API const sd_state *sd_simulation_state(sd_simulation *simulation);
/* Returns the slot of a body, which is its row in the columns. body: number, or SD_WALL(w) for a
 * wall. UINT32_MAX: there is no such body. */
SD_API uint32_t sd_simulation_slot(const sd_simulation *simulation, uint32_t body);
/* Returns the angle of a body, turn + theta, rad, not reduced to one revolution. NAN: there is
 * no such body. */
SD_API double sd_simulation_angle(const sd_simulation *simulation, uint32_t body);

/* Energy budget: energies now, and work and losses since step 0 (physics.md 8). All have units of
 * energy.
 *
 *   residual = kinetic_translation + kinetic_rotation + elastic_normal + elastic_tangential
 *              + elastic_rolling + elastic_bond + cohesion + external - start
 *              - (work + nonconservative_work)
 *              + viscous + friction + rolling + bridge + opening + broken_tension + broken_shear
 *              + broken_bending + drag + damping + relaxed
 *
 * is the error of the budget, ideally 0. */
typedef struct sd_energy {
  /* kinetic energy without that of driven and locked coordinates */
  double kinetic_translation, kinetic_rotation;
  /* energy stored in the springs of contacts */
  double elastic_normal, elastic_tangential, elastic_rolling;
  double elastic_bond; /* energy stored in bonds */
  double cohesion;     /* potential energy of attractions, <= 0; 0 beyond their range */
  double external;     /* potential energy in gravity and constant body forces */
  /* Sum of the energies listed above at step 0, plus those of disks added or released and minus
   * those of disks removed or held since then */
  double start;
  /* Work done by prescribed bodies and coordinates, by compression, by force fields and by
   * sd_simulation_set */
  double work;
  /* Work done by the part of the paper's tangential force that has no potential */
  double nonconservative_work;
  double viscous, friction; /* energy lost to dashpots of contacts, and to sliding */
  /* energy lost to rolling, to bridges that form, to contacts that open */
  double rolling, bridge, opening;
  /* energy of bonds that broke by tension, by shear and by bending */
  double broken_tension, broken_shear, broken_bending;
  double drag, damping; /* energy lost to viscous drag of fields, and to non-viscous damping */
  double relaxed;       /* kinetic energy taken out by the relaxer (key relax of a phase) */
  double residual;      /* error of the budget, by the formula above */
  /* Energy to which the residual is compared: the larger of |work| + losses and the kinetic
   * energy; at rest 1e-9 times the other energies */
  double scale;
} sd_energy;
/* Returns the energy budget at the present step. */
SD_API sd_energy sd_simulation_energy(sd_simulation *simulation);

/* Progress of a run. A phase may end before its full length (sd_settle, sd_until in model.h). */
typedef struct sd_stage {
  /* number of steps made; index of the current phase; number of steps made in this phase */
  int64_t step, phase, phase_step;
  int64_t before; /* number of steps that the preceding phase took */
} sd_stage;
/* Returns the progress of a run, at no cost. */
SD_API sd_stage sd_simulation_stage(const sd_simulation *simulation);
/* Returns the error bar reached and the one at which `until` of the model ends the run;
 * meaningless if the model has no `until`. */
SD_API sd_goal sd_simulation_goal(const sd_simulation *simulation);
/* Returns the number of threads. */
SD_API int sd_simulation_threads(const sd_simulation *simulation);
/* Returns the instruction set of the kernels in use: "avx512", "avx2" or "baseline". */
SD_API const char *sd_simulation_path(const sd_simulation *simulation);

/* --- saving and loading ----------------------------------------------------------------------- */

/* Writes model and state to a file (HDF5). A program that loads the file continues with the same
 * results, bit for bit. The file is written under another name and renamed when it is complete.
 * Returns SD_ERROR_IO if that fails: a file already there stays as it was. */
SD_API sd_status sd_simulation_save(sd_simulation *simulation, const char *path,
                                    sd_messages *messages);
/* Loads a file of sd_simulation_save, or a checkpoint of `slipdisk run`
 * (NAME.h5.parts/checkpoint-*.h5), which contains its deck. The simulation owns its model. threads:
 * 0: chosen by the size of the system. Returns SD_ERROR_USER if another version wrote the file,
 * SD_ERROR_IO if it is missing or damaged; *out is NULL on errors. */
SD_API sd_status sd_simulation_load(const char *path, int threads, sd_simulation **out,
                                    sd_messages *messages);
/* Like sd_simulation_save, but into memory: *size bytes at *data, which the caller frees with
 * sd_free. */
SD_API sd_status sd_simulation_save_memory(sd_simulation *simulation, void **data, size_t *size,
                                           sd_messages *messages);
/* Like sd_simulation_load, but from memory: `size` bytes at `data`, as written by
 * sd_simulation_save_memory. */
SD_API sd_status sd_simulation_load_memory(const void *data, size_t size, int threads,
                                           sd_simulation **out, sd_messages *messages);

/* Discards neighbour lists and all other data that can be recomputed from model and state, and
 * builds them anew. Later steps give the same results as without this call, bit for bit. */
SD_API sd_status sd_simulation_rebuild(sd_simulation *simulation, sd_messages *messages);

/* Returns the size in bytes of a struct that the library and its callers share, by its name such
 * as "sd_energy", for programs in other languages that declare it themselves; 0: unknown name. */
SD_API size_t sd_struct_size(const char *name);

#ifdef __cplusplus
}
#endif

#endif
