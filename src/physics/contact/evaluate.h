/* evaluate.h: evaluates single contacts at the present coordinates, outside the pass over all
 * pairs. */
#ifndef PHYSICS_EVALUATE_H
#define PHYSICS_EVALUATE_H

#include "physics/contact/walls.h"

/* Geometry of a pair of bodies a and b. */
typedef struct contact_geometry {
  double nx, ny;  /* unit normal, from a towards b's surface */
  double overlap; /* length, negative for a gap */
  double lambda;  /* tangential coordinate, length, measured from the reference direction */
  double turned;  /* angle from the contact's reference direction to the normal, rad */
} contact_geometry;

/* Returns the geometry of a pair at the present coordinates; the pair may be open. */
contact_geometry contact_geometry_of(const engine *e, size_t pair);
/* Force and torques of a closed contact. nx, ny: unit normal, from a towards b's surface; fx, fy:
 * force on b (a gets the opposite); torque_a, torque_b: torques about the bodies' centres, for a
 * straight wall or arc about its pivot; couple: torque of rolling resistance on a (b gets the
 * opposite), already included in torque_a and torque_b. */
typedef struct contact_reaction {
  double nx, ny, fx, fy, torque_a, torque_b, couple;
} contact_reaction;
/* Geometry on which the force of a contact depends, besides F_n, tau and the rolling force. */
typedef struct contact_place {
  double dx, dy;       /* vector from a's centre to b's, or to the nearest point of a segment */
  double ra, rb;       /* radii; rb: negative inside a round wall, 0 for a wall segment */
  double arm_x, arm_y; /* vector from the wall's pivot to a's centre; wall segments only */
  const placed_segment *piece; /* wall segment that a touches; NULL: b is round */
  nearest_point nearest;       /* nearest point of that segment */
  /* true: conservative variant of the tangential force. Wall segments always use the force that
   * derives from the tangential energy. */
  bool conservative;
} contact_place;
/* Returns the force and torques of a contact, for callers outside the passes over pairs; it uses
 * the formulae and levers of the passes. force: F_n; tau: tangential force; roll: rolling force. */
contact_reaction contact_reaction_at(const contact_place *at, double force, double tau,
                                     double roll);
/* Returns the force and torques of a closed contact from the forces in its record. */
contact_reaction contact_reaction_of(const engine *e, size_t pair);
/* Adds the recorded force of a closed contact to the force sums of its bodies. */
void contact_sum(engine *e, size_t pair);
/* Returns the rolling displacement R_eff (theta_a - theta_b), a length. */
double contact_rho_of(const engine *e, size_t pair);
/* Energies stored in a closed contact, by the force that they belong to; cohesion <= 0. */
typedef struct contact_energies {
  double normal, tangential, rolling, cohesion;
} contact_energies;
/* Returns the energies stored in a closed contact at the present coordinates. */
contact_energies contact_energies_of(const engine *e, size_t pair);

#endif
