/* resultant.h: what the disks and contacts of a moment add up to, as series: counts and pressure, and, where the deck asks for them,
 * forces on walls, on groups and on chosen disks, size of the region, stress.
 *
 * A wall and a disk count all their contacts, a group those between one of its disks and a body that is not in it. Of each:
 * force and torque that act on it, of a wall about its pivot, of a disk about its centre, of a group about its
 * centre of mass (with images); normal, the sum of F_n; tangential, the sum of tau, which is positive where it turns the disks
 * of the contact counter-clockwise.
 *
 * All sums are exact (base/exact_sum.h): ranks that add up their parts have the bits of one process. */
#ifndef MEASURE_RESULTANT_H
#define MEASURE_RESULTANT_H

#include "base/comm.h"
#include "base/exact_sum.h"
#include "model/slot_table.h"

typedef struct resultant {
  double force_x, force_y, torque;
  double normal, tangential;
  int64_t contacts, sliding; /* closed contacts, and those that slide */
} resultant;

typedef struct resultants {
  int64_t contacts, sliding,
      outside; /* contacts that do not hold by attraction alone, and disks beyond the bounds */
  double pressure, fraction;      /* in the region, of models that compress or deform */
  resultant *wall, *group, *disk; /* of the model's walls, groups, contact_disks */
  double width, height;           /* of the region, NAN: there is none */
  double stress[4], kinetic[4];   /* as in stress.h */
  struct resultant_disk *chosen;  /* contact_disks, by their numbers */
  exact_sum *sums;                /* scratch */
  size_t n_sums;
} resultants;

/* SD_OK always. */
void resultants_new(resultants *r, const sd_model *model);
void resultants_free(resultants *r);
/* Only what the model asks for is computed. shared: every rank calls, with the part of the state
 * that it has, contacts stored; then all know the sums, and a rank without memory ends the job.
 * */
sd_status resultants_take(resultants *r, const sd_model *model, const sd_state *state,
                          const slot_table *slots, const comm *c, sd_messages *messages);

#endif
