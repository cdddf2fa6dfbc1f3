/* stress.h: results from the contacts of a configuration: coordination and rattlers, sliding,
 * stress and fabric, overlaps, unbalanced forces, and the packing fraction of the region.
 *
 * A contact bears load if its force is > 0. A contact between two free disks counts for both of
 * them, one with a wall or a prescribed disk for one. Rattlers are free disks with fewer than 2
 * load-bearing contacts (3 without friction anywhere), removed repeatedly until none is left.
 *
 * Stress, compression positive: sigma_xy = (1/A) sum over contacts of l_x f_y, with l the branch
 * vector from a, f the force on b, and each contact weighted by the part of its branch that lies in
 * the region. Branches end on the surface of walls and prescribed disks. Kinetic part: (1/A) sum of
 * m v_x v_y, relative to the mean velocity.
 *
 * A clump is one body: branches begin and end at its centre, since its internal forces are not
 * known, and the kinetic part has its mass and the velocity of its centre. Rattlers, energies and
 * resultants are those of clumps, too. */
#ifndef MEASURE_STRESS_H
#define MEASURE_STRESS_H

#include "base/comm.h"
#include "base/exact_sum.h"
#include "measure/configuration.h"

enum { STRESS_XX, STRESS_XY, STRESS_YX, STRESS_YY };

/* Principal values s1 >= s2 of the symmetric part of a tensor. */
typedef struct principal {
  double mean, deviator; /* (s1 + s2)/2 and (s1 - s2)/2 */
  /* angle of the direction of s1 to the x axis, rad, in (-pi/2, pi/2]; NAN: isotropic */
  double angle;
} principal;
principal stress_principal(const double tensor[4]);

typedef struct stress {
  /* Arrays with one element per disk of the configuration, owned by the struct (stress_free): */
  /* numbers of closed and of load-bearing contacts of each disk */
  int32_t *contacts, *bearing;
  bool *rattler;
  /* total force on each disk (x, y): contacts, gravity and constant body force */
  double (*resultant)[2];
  /* sum of l.f over the contacts of each disk, with l from its centre, or from that of its clump,
   * to the point of contact, and f the force that it exerts there on its partner */
  double *virial;

  /* Results of the region: over disks with their centre in it, and over contacts with the middle of
   * their branch in it: */
  /* area: area of the region; fraction: packing fraction, i.e. the area of free and prescribed
   * disks inside divided by this area */
  double area, fraction;
  /* numbers of disks in play: free and prescribed (fixed) ones inside the region, free ones
   * outside */
  size_t free, fixed, outside;
  /* number of free disks in the region that are rattlers, disks of rattling clumps included */
  size_t rattlers;
  size_t clumps; /* number of clumps with their centre in the region */
  /* numbers of closed contacts, of load-bearing contacts, and of closed contacts with a wall or a
   * prescribed disk */
  size_t n_contacts, n_bearing, n_wall;
  size_t n_sliding;
  /* bonds of the whole configuration; bodies of bonded free disks, single disks and clumps
   * included, and the mass of the heaviest */
  size_t n_bonds, fragments;
  double largest_fragment;
  /* coordination: mean number of closed and of load-bearing contacts per free disk */
  double z, z_bearing;
  /* mean number of load-bearing contacts of a non-rattler with other non-rattlers, walls and
   * prescribed disks */
  double z_backbone;
  double contact[4], kinetic[4];
  principal contact_principal;
  double fabric[4]; /* fabric tensor: mean of n_i n_j over load-bearing contacts */
  /* 2 (F_1 - F_2) with F_1, F_2 the principal values of fabric: the amplitude a of the contact
   * directions, P(beta) = (1 + a cos 2(beta - beta_0))/2pi */
  double anisotropy;
  double fabric_angle;              /* beta_0, angle of the most frequent contact direction, rad */
  double mean_force;                /* mean normal force of load-bearing contacts */
  double overlap_mean, overlap_max; /* mean and largest overlap of closed contacts */
  /* numbers, in configuration.model, of the two bodies with the largest overlap */
  uint32_t overlap_a, overlap_b;
  /* mean kinetic energy of translation and of rotation per free disk or clump */
  double energy_translation, energy_rotation;
  /* mean total force on a free disk or clump, divided by mean_force; NAN if tangential forces are
   * not known */
  double unbalanced;
} stress;

/* Computes all results for region g. Call stress_free also when it fails. SD_ERROR_IO: out of
 * memory. */
sd_status stress_new(stress *s, const configuration *c, const region *g, sd_messages *messages);
void stress_free(stress *s);

/* Computes the kinetic stress (xx, xy, yx, yy) of n rigid bodies in a region of this area. ranks:
 * ranks that share the bodies, NULL: none. Collective. */
void stress_kinetic(double out[4], const configuration *c, double area, size_t n,
                    const config_clump *bodies, const comm *ranks);
/* Adds a contact to the exact sums (xx, xy, yx, yy) of contact stress times area. at: centre of its
 * first disk; arm: vectors to the centres of its two disks from those of their clumps, 0: no
 * clump. */
void stress_add_contact(exact_sum sum[4], const region *g, const config_contact *contact,
                        const double at[2], double arm[2][2]);

#endif
