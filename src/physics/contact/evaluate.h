/* evaluate.h: single contacts at the present coordinates, outside the pass over all pairs. */
#ifndef PHYSICS_EVALUATE_H
#define PHYSICS_EVALUATE_H

#include "physics/contact/walls.h"

typedef struct contact_geometry {
  double nx, ny;  /* from a to b's surface */
  double overlap; /* negative where there is a gap */
  double lambda;  /* from the reference direction */
  double turned;  /* angle of the normal from there */
} contact_geometry;

contact_geometry contact_geometry_of(const engine *e, size_t pair);
/* Force of a closed contact on b, and the torques about both centres, a wall's about its pivot; normal from a to b's surface. The torques
 * have the couple of rolling resistance: on a, the opposite on b. */
typedef struct contact_reaction {
  double nx, ny, fx, fy, torque_a, torque_b, couple;
} contact_reaction;
/* Where a contact is: what its force depends on beside F_n, tau and the rolling force. */
typedef struct contact_place {
  double dx, dy;       /* from a's centre to b's, or to the nearest point of a piece of a wall */
  double ra, rb;       /* rb: negative inside a round wall, 0 of a piece */
  double arm_x, arm_y; /* from a wall's pivot to a's centre; of pieces */
  const placed_segment *piece; /* NULL: b is round */
  nearest_point nearest;       /* of the piece */
  bool conservative;           /* the variant; pieces have the force of their energy in both */
} contact_place;
/* The force of a contact for all that is not in the passes: with their text and levers. */
contact_reaction contact_reaction_at(const contact_place *at, double force, double tau,
                                     double roll);
contact_reaction contact_reaction_of(const engine *e, size_t pair);
/* Adds the remembered force of a closed contact to the force sums of its bodies. */
void contact_sum(engine *e, size_t pair);
/* Rolling displacement R_eff (theta_a - theta_b), length. */
double contact_rho_of(const engine *e, size_t pair);
/* Energies stored in closed contact k at the present coordinates. */
typedef struct contact_energies {
  double normal, tangential, rolling, cohesion;
} contact_energies;
contact_energies contact_energies_of(const engine *e, size_t pair);

#endif
