/* fields.h: force fields that functions of the calling program compute, and force fields that the
 * deck defines.
 *
 * Fields of the calling program (sd_simulation_add_force_field) belong to the engine, not to its
 * work, so they survive a rebuild of work.
 */
#ifndef PHYSICS_FIELDS_H
#define PHYSICS_FIELDS_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* Force fields that functions of the calling program compute. */
typedef struct fields {
  size_t n;
  bool calling; /* true while one of the calling program's functions is being called */
  struct {
    sd_force_field *call;
    void *user;
  } * item;
  double *force[SD_COORDINATES]; /* [n_free] sum of the fields' forces in the last step */
  double *total[SD_COORDINATES]; /* [n_free] `force` plus constant forces; read by the integrator */
} fields;

/* Adds a force field of the calling program; at step 0 the accelerations in the state are updated.
 * SD_ERROR_IO: no memory for columns of the disks. */
sd_status fields_add(engine *e, sd_force_field *call, void *user);
void fields_free(engine *e);
/* Resizes the columns of forces to the present number of free disks. SD_ERROR_IO: no memory. */
sd_status fields_resize(engine *e);
/* Computes `total`, the constant forces of the model plus the forces of the calling program's
 * fields, and makes the integrator read it. Call it after constant forces have changed or have
 * moved in memory. */
void fields_attach(engine *e);
/* Evaluates the calling program's fields at the predicted coordinates of the present step. */
void fields_apply(engine *e);
/* Evaluates the calling program's fields at the present coordinates and velocities, after the
 * bodies were changed between two steps. */
void fields_renew(engine *e);
/* Adds the work of the calling program's fields in the step just completed to the budget:
 * trapezoidal rule for force times corrected velocity. */
void fields_work(engine *e);

/* --- force fields of the model (sd_body_force) ---
 *
 * Here: the weight with which each field acts on each free disk, and the sums of field forces and
 * constant forces. The forces themselves are computed in physics/step/field_pass.h.
 */

/* Weights of one force field on the free disks; 0 for disks that it does not act on. */
typedef struct body_force_row {
  const sd_body_force *field;
  /* [n_free] weight of the force (1, R or m, by kind of field), and of the torque (1, R^3 or I) */
  double *weight, *turn_weight;
  double push[2]; /* turning gravity: acceleration at the step that is being made */
} body_force_row;

/* Kinds of power of the force fields on a disk; their time integrals are the members work, drag and
 * damping of sd_energy. */
enum { FIELD_WORK, FIELD_DRAG, FIELD_DAMPED, FIELD_POWERS };

/* Force fields that the deck defines. */
typedef struct body_forces {
  size_t n;
  int64_t phase; /* phase for which the weights have been computed */
  /* [n_free] `base` plus forces of the deck's fields in the last step */
  double *total[SD_COORDINATES];
  /* [n_free] constant forces plus fields of the calling program */
  const double *base[SD_COORDINATES];
  /* [n_free] 1 for disks in clumps, 0 for other disks; NULL: there are no clumps. It marks disks
   * whose inverse masses are 0 although they are not locked. */
  const double *clumped;
  /* Pointers to columns of the state: forces of the fields, their powers, and the time integrals of
   * the powers. */
  double *force[SD_COORDINATES], *power[FIELD_POWERS], *sum[FIELD_POWERS];
  void *arena; /* memory of `total` and of the weights */
  body_force_row row[];
} body_forces;

/* Allocates the force fields of the model, if it has any. SD_ERROR_IO: no memory for columns of the
 * disks. */
sd_status body_forces_new(engine *e);
void body_forces_free(engine *e);
/* Sets the weights of the force fields for the present phase; they are 0 for disks that are not in
 * play. */
void body_forces_fill(engine *e);
/* Makes the integrator use the sum of constant forces, fields of the calling program and fields of
 * the deck. To be called after constant forces have changed or have moved in memory. */
void body_forces_attach(engine *e);
/* Sets the parts of the deck's fields that depend on time to their values at a step. */
void body_forces_at(engine *e, int64_t step);
/* Evaluates the deck's force fields on free disks [begin, end) at their present coordinates; the
 * contact forces on these disks must be in the state. */
void body_forces_renew(engine *e, size_t begin, size_t end);

#endif
