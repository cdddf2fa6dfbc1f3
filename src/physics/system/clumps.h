/* clumps.h: rigid bodies of several free disks: where their disks are, and what these feel together.
 *
 * The disks of a clump are ordinary free disks for lists, contacts and results, but with no inverse masses: their coordinates
 * are functions of those of the clump, which a corrector of its own moves (step/clump_step.c).
 */
#ifndef PHYSICS_CLUMPS_H
#define PHYSICS_CLUMPS_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* Poses and velocities of step 0, from the model; disks of a clump get the images that belong to them. */
void clumps_fill_state(const sd_model *model, sd_state *state);
/* Tables in work, from model and state. SD_ERROR_IO: no memory. */
sd_status clumps_new(engine *e);
void clumps_free(engine *e);
/* Inverse masses and constant forces: 0 where locked, moved by motions, or not in play. */
void clumps_fill_constants(engine *e);

/* Where the disks of clump k are, and how fast, from its coordinates. */
void clump_place(engine *e, size_t k);
void clumps_place_all(engine *e);
/* It waited, and begins here; its disks stand in the box, whichever way it came there. */
void clump_set_out(engine *e, size_t k, double x, double y, double vy);

/* dt^2/2 times the acceleration along c of the disk in this slot, which belongs to a clump; physics.md 8. */
double clump_second(const engine *e, size_t slot, int c);

/* Force and torque about the centre, of what is given per slot of a free disk; in the order of the disks' numbers. */
typedef struct clump_load {
  double on[SD_COORDINATES];
} clump_load;
clump_load clumps_load_of(const engine *e, size_t k, const double *fx, const double *fy,
                          const double *torque);
/* Forces of the contacts on the disks, summed up in the state. */
void clump_sum(engine *e, size_t k);
/* Gravity, constant forces and force fields; and the same with the contacts' forces in the state. */
clump_load clump_constant(const engine *e, size_t k);
clump_load clump_total(const engine *e, size_t k);
/* Power of the model's fields as the corrector of the disks books it, with the velocities that they have; and what is missing
 * from there to that of the corrected clump. */
double clump_field_booked(const engine *e, size_t k);
void clump_book_field(engine *e, size_t k, double booked, double dt);
/* Cundall's damping of the whole clump: a fraction of all other forces and torques on it, against the velocity to which they take it;
 * kappa as in field_pass.h. And its loss, at the velocities of the state. */
clump_load clump_damping(const engine *e, size_t k, double kappa, const clump_load *all);
void clump_book_damping(engine *e, size_t k, const clump_load *damped, double dt);
/* Second derivatives from the forces on the disks. */
void clump_accelerate(engine *e, size_t k);
void clumps_accelerate(engine *e);

void clumps_add_energy(const engine *e, sd_energy *sum);

/* As its disks, which come and go together; whether it is within the bounds is no matter (SD_OUTSIDE). */
static inline bool clump_in_play(const engine *e, size_t k) {
  const int32_t first = e->state->activity[e->work.clumps.member[e->work.clumps.start[k]]];
  return first == SD_IN_PLAY || first == SD_OUTSIDE;
}

static inline bool clumps_same(const engine *e, size_t i, size_t j) {
  const int32_t *of = e->work.clumps.of;
  return of && i < e->state->n_free && j < e->state->n_free && of[i] >= 0 && of[i] == of[j];
}

#endif
