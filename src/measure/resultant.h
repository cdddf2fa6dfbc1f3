/* resultant.h: sums over the disks and contacts at one time, recorded as series: counts, pressure,
 * and, if the deck asks for them, forces on walls, groups and chosen disks, size of the region,
 * stress.
 *
 * Walls and disks sum over all their contacts, groups over contacts between one of their disks and
 * a body outside the group. The sums are: force and torque on the body (torque of a wall about its
 * pivot, of a disk about its centre, of a group about its centre of mass, with periodic images);
 * normal, the sum of F_n; tangential, the sum of tau, which is positive if it turns the disks of
 * the contact counter-clockwise.
 *
 * All sums are exact (base/exact_sum.h): several ranks get bit for bit the result of one
 * process. */
#ifndef MEASURE_RESULTANT_H
#define MEASURE_RESULTANT_H

#include "base/comm.h"
#include "base/exact_sum.h"
#include "model/state.h"

typedef struct resultant {
  double force_x, force_y, torque;
  double normal, tangential;
  int64_t contacts, sliding; /* numbers of closed contacts and of those that slide */
} resultant;

typedef struct resultants {
  /* numbers of closed contacts and of those that slide, without pairs held by attraction alone;
   * number of disks beyond the bounds or taken out */
  int64_t contacts, sliding, outside;
  /* pressure and packing fraction in the region, only for models that compress or deform */
  double pressure, fraction;
  /* arrays with one element per wall, per group, and per disk of the model's contact_disks */
  resultant *wall, *group, *disk;
  /* width and height of the region; NAN: the model has no region */
  double width, height;
  /* stress tensors of contacts and motion: xx, xy, yx, yy, as in stress.h */
  double stress[4], kinetic[4];
  /* free disks in the region that are rattlers, and mean number of load-bearing contacts of the
   * others (contact_graph.h) */
  int64_t rattlers;
  double z_backbone;
  int64_t bonds;
  /* bodies of bonded free disks, single disks and clumps too, and the mass of the heaviest */
  int64_t fragments;
  double largest_fragment;
  struct resultant_disk *chosen; /* disks of the model's contact_disks, sorted by number */
  exact_sum *sums; /* [n_sums] exact sums, from which the other members are computed */
  size_t n_sums;
} resultants;

/* Allocates the resultants for this model and sets them to 0. Ends the process if there is no
 * memory. */
void resultants_new(resultants *r, const sd_model *model);
void resultants_free(resultants *r);
/* Computes the sums that the model asks for from a state with its stored contacts. c: communicator
 * of the ranks, NULL: one process. Several ranks all call this, each with its part of the state,
 * and all receive the total sums; a rank without memory ends the job. SD_ERROR_IO: out of
 * memory. */
sd_status resultants_compute(resultants *r, const sd_model *model, const sd_state *state,
                             const slot_table *slots, const comm *c, sd_messages *messages);

#endif
