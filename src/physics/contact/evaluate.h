/* evaluate.h: geometry, force and energy of single contacts at the present coordinates, outside the
 * evaluation of all pairs in a step. */
#ifndef PHYSICS_EVALUATE_H
#define PHYSICS_EVALUATE_H

#include "physics/contact/walls.h"

/* Geometry of a pair of bodies a and b. */
typedef struct contact_geometry {
  double nx, ny;  /* unit normal, from a's centre towards the surface of b */
  double overlap; /* overlap, a length, negative for a gap */
  /* tangential coordinate lambda, a length, measured from the reference direction of the contact */
  double lambda;
  double turned; /* angle from the reference direction of the contact to the normal, rad */
} contact_geometry;

/* Returns the geometry of this pair at the present coordinates. The pair may be open. */
contact_geometry contact_geometry_of(const engine *e, size_t pair);
/* Force and torques of a closed contact. nx, ny: unit normal, from a's centre towards the surface
 * of b; fx, fy: force on b (a gets the opposite force); torque_a, torque_b: torques on a and b
 * about their centres, or about the pivot of a wall with segments; couple: torque of rolling
 * resistance on a (b gets the opposite torque), already included in torque_a and torque_b. */
typedef struct contact_reaction {
  double nx, ny, fx, fy, torque_a, torque_b, couple;
} contact_reaction;
/* Geometry from which the force of a contact follows, together with F_n, tau and the rolling
 * force. */
typedef struct contact_place {
  /* vector from a's centre to b's centre, or to the nearest point of a wall segment */
  double dx, dy;
  /* radii of a and b; rb: negative for a round wall around the disk, 0 for a wall segment */
  double ra, rb;
  double arm_x, arm_y; /* vector from the wall's pivot to a's centre; only set for wall segments */
  const placed_segment *piece; /* wall segment that a touches; NULL: b is a round body */
  nearest_point nearest;       /* nearest point of this segment */
  /* true: tangential force of the conservative variant of the model; false: that of the paper. Wall
   * segments always use the conservative one. */
  bool conservative;
} contact_place;
/* Returns the force and torques of a contact with the given geometry, by the same formulas as in
 * steps. force: F_n; tau: tangential force; roll: rolling force. */
contact_reaction contact_reaction_at(const contact_place *at, double force, double tau,
                                     double roll);
/* Returns the force and torques of a closed contact, from the forces in its record and the present
 * coordinates. */
contact_reaction contact_reaction_of(const engine *e, size_t pair);
/* Adds the force of a closed contact, from its record, to the force sums of its two bodies. */
void contact_sum(engine *e, size_t pair);
/* Returns the rolling displacement R_eff (theta_a - theta_b) of this pair, a length. */
double contact_rho_of(const engine *e, size_t pair);
/* Energies stored in a closed contact by the normal force, the tangential force, rolling resistance
 * and cohesion; the last one is at most 0. */
typedef struct contact_energies {
  double normal, tangential, rolling, cohesion, bond;
} contact_energies;
/* Returns the energies stored in a closed contact at the present coordinates. */
contact_energies contact_energies_of(const engine *e, size_t pair);

#endif
