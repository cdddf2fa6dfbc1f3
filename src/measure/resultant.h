/* resultant.h: what the contacts of a moment add up to, as series that the deck asks for: forces on walls, on groups and on
 * chosen disks, size of the region, stress.
 *
 * A wall and a disk count all their contacts, a group those between one of its disks and a body that is not in it. Of each:
 * force and torque that act on it, of a wall about its pivot, of a disk about its centre, of a group about its
 * centre of mass (with images); normal, the sum of F_n; tangential, the sum of tau, which is positive where it turns the disks
 * of the contact counter-clockwise. */
#ifndef MEASURE_RESULTANT_H
#define MEASURE_RESULTANT_H

#include "model/state.h"

typedef struct resultant {
  double force_x, force_y, torque;
  double normal, tangential;
  int64_t contacts, sliding; /* closed contacts, and those that slide */
} resultant;

typedef struct resultants {
  resultant *wall, *group, *disk; /* of the model's walls, groups, contact_disks */
  uint32_t *chosen;               /* [n_disks] 1 + place in contact_disks, 0: none */
  double width, height;           /* of the region, NAN: there is none */
  double stress[4], kinetic[4];   /* as in stress.h */
} resultants;

/* resultants_free also when it fails. */
sd_status resultants_new(resultants *r, const sd_model *model, sd_messages *messages);
void resultants_free(resultants *r);
/* slots[body] in the state. Only what the model asks for is computed. */
sd_status resultants_take(resultants *r, const sd_model *model, const sd_state *state, const uint32_t *slots,
                          sd_messages *messages);

#endif
