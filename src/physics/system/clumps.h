/* clumps.h: clumps, rigid bodies of several free disks: poses of their disks, and the sums of the
 * forces on these disks.
 *
 * For neighbour lists, contacts and results the disks of a clump are ordinary free disks. Their
 * inverse masses are 0: their coordinates follow from those of the clump, which has a predictor and
 * corrector of its own (step/clump_step.c).
 */
#ifndef PHYSICS_CLUMPS_H
#define PHYSICS_CLUMPS_H

#include "physics/system/work.h"

/* Sets poses and velocities of clumps at step 0, from the model. Disks of a clump get periodic
 * image counts such that their unwrapped positions lie around the clump's centre. */
void clumps_fill_state(const sd_model *model, sd_state *state);
/* Allocates and fills work.clumps, from model and state. SD_ERROR_IO: no memory. */
sd_status clumps_new(engine *e);
void clumps_free(engine *e);
/* Sets inverse masses and constant forces of clumps. Inverse masses and moments of inertia are 0
 * for coordinates that are locked or moved by motions. Inverse masses and constant forces are 0 for
 * clumps that are not in play. */
void clumps_fill_constants(engine *e);

/* Sets poses and velocities of the disks of clump k, from the coordinates of the clump. */
void clump_place(engine *e, size_t k);
void clumps_place_all(engine *e);
/* Places clump k, which has waited for its insertion, at (x, y) with velocity (0, vy), and wraps
 * its disks into the box. */
void clump_set_out(engine *e, size_t k, double x, double y, double vy);

/* Returns dt^2/2 times the acceleration, along coordinate c (SD_X or SD_Y), of the disk in this
 * slot, which must belong to a clump; docs/physics.md, section 8. */
double clump_second(const engine *e, size_t slot, int c);

/* Force on a clump, and torque about its centre. */
typedef struct clump_load {
  double on[SD_COORDINATES];
} clump_load;
/* Returns the force on clump k and the torque about its centre from forces on its disks. fx, fy,
 * torque: [n_free] forces and torques on disks, by slot; they are added in the order of the disks'
 * body numbers. */
clump_load clumps_load_of(const engine *e, size_t k, const double *fx, const double *fy,
                          const double *torque);
/* Sums the contact forces on the disks of clump k, and stores the sum in the state as the contact
 * force on the clump. */
void clump_sum(engine *e, size_t k);
/* clump_constant returns the sum of gravity, constant forces and force fields on clump k;
 * clump_total returns this sum plus the contact forces that clump_sum has stored. */
clump_load clump_constant(const engine *e, size_t k);
clump_load clump_total(const engine *e, size_t k);
/* clump_field_booked returns the power of the deck's force fields on the disks of clump k at their
 * present velocities, which the corrector of disks adds to the budget. clump_book_field adds the
 * rest: the power on the corrected clump minus `booked`, the value returned before. dt: time step,
 * 0 at step 0. */
double clump_field_booked(const engine *e, size_t k);
void clump_book_field(engine *e, size_t k, double booked, double dt);
/* clump_damping returns the force of Cundall's non-viscous damping on clump k: in each coordinate a
 * fraction of the sum of all other forces (`all`), against the velocity that this sum leads to.
 * kappa: weight of the new acceleration in the corrected velocity (field_pass.h).
 * clump_book_damping adds the energy lost by damping to the budget, at the velocities in the
 * state. */
clump_load clump_damping(const engine *e, size_t k, double kappa, const clump_load *all);
void clump_book_damping(engine *e, size_t k, const clump_load *damped, double dt);
/* Set the accelerations (times dt^2/2) from the forces on the disks: clump_accelerate those of
 * clump k, clumps_accelerate those of all clumps. */
void clump_accelerate(engine *e, size_t k);
void clumps_accelerate(engine *e);

struct sd_energy;
/* Adds the kinetic energies and the potentials of constant forces of all clumps to the energy
 * budget `sum`. */
void clumps_add_energy(const engine *e, struct sd_energy *sum);

/* True if clump k takes part in the run: it is not waiting and has not been removed. Its disks come
 * and go together with it. A clump outside the bounds (SD_OUTSIDE) is still in play. */
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
