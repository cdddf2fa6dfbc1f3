/* fields.h: force fields of the program that uses the library (sd_simulation_add_force_field). They belong to the engine, not
 * to its work: rebuilding leaves them. */
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

#endif
