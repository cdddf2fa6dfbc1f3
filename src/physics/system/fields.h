/* fields.h: force fields, of the program that uses the library and of the model.
 *
 * Those of the program (sd_simulation_add_force_field) belong to the engine, not to its work:
 * rebuilding leaves them.
 */
#ifndef PHYSICS_FIELDS_H
#define PHYSICS_FIELDS_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

typedef struct fields {
  size_t n;
  bool calling; /* one of them is being called */
  struct {
    sd_force_field *call;
    void *user;
  } * item;
  double *force[SD_COORDINATES]; /* [n_free] their sum in the last step */
  double *total[SD_COORDINATES]; /* the same and what is constant: the integrator's `constant` */
} fields;

/* SD_ERROR_IO: no memory for columns of the disks.
 * At step 0 the accelerations are those with the field. */
sd_status fields_add(engine *e, sd_force_field *call, void *user);
void fields_free(engine *e);
/* For another number of free disks. SD_ERROR_IO: no memory. */
sd_status fields_resize(engine *e);
/* After the constants have changed, or stand elsewhere. */
void fields_attach(engine *e);
/* Forces at the predicted coordinates of the step that is being made. */
void fields_apply(engine *e);
/* Work in the step that was made: the trapezoid of force and corrected velocity. */
void fields_work(engine *e);

/* The model's fields (sd_body_force) in the step: how strongly each acts on each free disk, and the
 * sums of their forces with all that is constant. The forces themselves: physics/step/field_pass.h.
 */

typedef struct body_force_row {
  const sd_body_force *field;
  double *weight,
      *turn_weight; /* [n_free] 0 where it does not act; else 1, R or m, and 1, R^3 or I */
} body_force_row;

/* Powers of the fields on a disk, and their sums: sd_energy's work, drag, damping. */
enum { FIELD_WORK, FIELD_DRAG, FIELD_DAMPED, FIELD_POWERS };

typedef struct body_forces {
  size_t n;
  int64_t phase; /* that the weights are of */
  double *
      total[SD_COORDINATES]; /* [n_free] constant forces and those of the fields in the last step */
  const double
      *base[SD_COORDINATES]; /* [n_free] what is constant, and forces of the program's fields */
  const double
      *clumped; /* [n_free] 1 of disks in clumps, whose coordinates are not held; NULL: none */
  double *force[SD_COORDINATES], *power[FIELD_POWERS],
      *sum[FIELD_POWERS]; /* columns of the state */
  void *arena;
  body_force_row row[];
} body_forces;

/* For a model with fields. SD_ERROR_IO: no memory for columns of the disks. */
sd_status body_forces_new(engine *e);
void body_forces_free(engine *e);
/* Weights in the phase of the state, from disks in play. */
void body_forces_fill(engine *e);
/* After the constants have changed, or stand elsewhere: the integrator's `constant` is their sum with the fields'. */
void body_forces_attach(engine *e);
/* Fields of free disks [begin, end), whose forces of contacts stand in the state, at their coordinates as they are. */
void body_forces_renew(engine *e, size_t begin, size_t end);

#endif
