/* clumps.h: clumps, rigid bodies of several free disks: poses of their disks, and the sums of the
 * forces on them.
 *
 * For neighbour lists, contacts and results the disks of a clump are ordinary free disks. Their
 * inverse masses are 0: their coordinates follow from those of the clump, which has a predictor and
 * corrector of its own (step/clump_step.c).
 */
#ifndef PHYSICS_CLUMPS_H
#define PHYSICS_CLUMPS_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* Sets poses and velocities of clumps at step 0, from the model. Disks of a clump get periodic
 * image counts such that their unwrapped positions lie around the clump's centre. */
void clumps_fill_state(const sd_model *model, sd_state *state);
/* Allocates and fills work.clumps, from model and state. SD_ERROR_IO: no memory. */
sd_status clumps_new(engine *e);
void clumps_free(engine *e);
/* Sets inverse masses and constant forces of clumps. Inverse masses are 0 for coordinates that are
 * locked or moved by motions; both are 0 for clumps that are not in play. */
void clumps_fill_constants(engine *e);

/* Sets poses and velocities of the disks of clump k, from the coordinates of the clump. */
void clump_place(engine *e, size_t k);
void clumps_place_all(engine *e);
/* Places clump k, which has waited, at (x, y) with velocity (0, vy), and wraps its disks into the
 * box. */
void clump_set_out(engine *e, size_t k, double x, double y, double vy);

/* Returns dt^2/2 times the acceleration along c (SD_X or SD_Y) of the disk in this slot, which must
 * belong to a clump; docs/physics.md, section 8. */
double clump_second(const engine *e, size_t slot, int c);

/* Force on a clump, and torque about its centre. */
typedef struct clump_load {
  double on[SD_COORDINATES];
} clump_load;
/* Returns the sum of forces and torques on the disks of clump k. fx, fy, torque: [n_free] by slot;
 * they are added in the order of the disks' body numbers. */
clump_load clumps_load_of(const engine *e, size_t k, const double *fx, const double *fy,
                          const double *torque);
/* Sums the contact forces on the disks of clump k, and stores them in the state as the clump's. */
void clump_sum(engine *e, size_t k);
/* Returns the sum of gravity, constant forces and force fields on clump k; clump_total adds the
 * contact forces that clump_sum has stored. */
clump_load clump_constant(const engine *e, size_t k);
clump_load clump_total(const engine *e, size_t k);
/* clump_field_booked returns the power of the model's fields that the corrector of disks books for
 * the disks of clump k, with their present velocities. clump_book_field books the rest: the power
 * on the corrected clump minus `booked`, the value returned before. dt: time step, 0 at step 0. */
double clump_field_booked(const engine *e, size_t k);
void clump_book_field(engine *e, size_t k, double booked, double dt);
/* clump_damping returns Cundall's non-viscous damping of clump k: in each coordinate a fraction of
 * the sum of all other forces (`all`), against the velocity that this force leads to; kappa as in
 * field_pass.h. clump_book_damping books its loss at the velocities in the state. */
clump_load clump_damping(const engine *e, size_t k, double kappa, const clump_load *all);
void clump_book_damping(engine *e, size_t k, const clump_load *damped, double dt);
/* Sets the accelerations (times dt^2/2) of clump k, or of all clumps, from the forces on their
 * disks. */
void clump_accelerate(engine *e, size_t k);
void clumps_accelerate(engine *e);

/* Adds kinetic energies and potentials of all clumps to the budget. */
void clumps_add_energy(const engine *e, sd_energy *sum);

/* True if clump k is in play, like its disks, which come and go together. A clump outside the
 * bounds (SD_OUTSIDE) is still in play. */
static inline bool clump_in_play(const engine *e, size_t k) {
  const int32_t first = e->state->activity[e->work.clumps.member[e->work.clumps.start[k]]];
  return first == SD_IN_PLAY || first == SD_OUTSIDE;
}

/* True if slots i and j hold free disks of the same clump; i == j: true if disk i is in a clump. */
static inline bool clumps_same(const engine *e, size_t i, size_t j) {
  const int32_t *of = e->work.clumps.of;
  return of && i < e->state->n_free && j < e->state->n_free && of[i] >= 0 && of[i] == of[j];
}

#endif
