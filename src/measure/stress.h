/* stress.h: what contacts say of a configuration: coordination and rattlers, sliding, stress and fabric, overlaps,
 * forces out of balance, and the packing fraction of the region.
 *
 * A contact bears load when its force is > 0. A free disk has a contact with each thing it touches: one between two
 * free disks counts for both, one with a wall or a prescribed disk for one. Rattlers are free disks with fewer than 2
 * bearing contacts (3 without friction anywhere), found again and again without those found before.
 *
 * Stress, compression positive: sigma_xy = (1/A) sum over contacts of l_x f_y, l the branch vector from a on and f
 * the force on b, each contact with the part of its branch that lies in the region. Branches end on the surface of
 * walls and prescribed disks. Kinetic part: (1/A) sum of m v_x v_y, relative to the mean velocity.
 *
 * A clump is one body: branches begin and end at its centre, since the forces that hold it together are not known, and the
 * kinetic part has its mass and the velocity of its centre. Rattlers, energies and resultants are those of clumps, too.
 */
#ifndef MEASURE_STRESS_H
#define MEASURE_STRESS_H

#include "measure/configuration.h"

enum { STRESS_XX, STRESS_XY, STRESS_YX, STRESS_YY };

/* Of a tensor's symmetric part. */
typedef struct principal {
  double mean, deviator; /* (s1 + s2)/2, (s1 - s2)/2 */
  double
      angle; /* of the larger principal value to the x axis, rad, in (-pi/2, pi/2]; NAN: isotropic */
} principal;
principal stress_principal(const double tensor[4]);

typedef struct stress {
  /* per disk of the configuration, to be freed with stress_free */
  int32_t *contacts, *bearing; /* closed, load-bearing */
  bool *rattler;
  double (*resultant)[2]; /* contacts, gravity and constant force */
  double *
      virial; /* sum of l.f over its contacts, l from its centre, or that of its clump, to the point of contact */

  /* of the region: disks whose centre, contacts whose point lies in it */
  double area,
      fraction; /* of the region; area of disks (also prescribed ones) in it over its own */
  size_t free, fixed, outside; /* disks in play: free and prescribed inside, free ones elsewhere */
  size_t rattlers;             /* of the free disks; those of clumps that rattle */
  size_t clumps;               /* whose centre lies in the region */
  size_t n_contacts, n_bearing,
      n_wall; /* contacts; of these load-bearing, with a wall or prescribed disk */
  size_t n_sliding;
  double z, z_bearing; /* contacts per free disk: closed, load-bearing */
  double
      z_backbone; /* load-bearing contacts among and on disks that are no rattlers, per such disk */
  double contact[4], kinetic[4];
  principal contact_principal;
  double fabric[4];    /* mean of n_x n_y of load-bearing contacts */
  double anisotropy;   /* 2 (F_1 - F_2): a in P(beta) = (1 + a cos 2(beta - beta_0))/2pi */
  double fabric_angle; /* beta_0 */
  double mean_force;   /* of load-bearing contacts */
  double overlap_mean, overlap_max;           /* closed contacts */
  uint32_t overlap_a, overlap_b;              /* bodies of the largest, as in configuration.model */
  double energy_translation, energy_rotation; /* kinetic, per free disk or clump */
  double
      unbalanced; /* mean resultant on one over mean_force; NAN: tangential forces are not known */
} stress;

/* stress_free also when it fails. */
sd_status stress_new(stress *s, const configuration *c, const region *g, sd_messages *messages);
void stress_free(stress *s);
/* Only these of it: exact sums. Collective. */
void stress_tensors(double contact[4], double kinetic[4], const configuration *c, const region *g);

#endif
