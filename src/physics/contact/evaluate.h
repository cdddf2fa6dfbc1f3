/* evaluate.h: single contacts at the present coordinates, outside the pass over all pairs. */
#ifndef PHYSICS_EVALUATE_H
#define PHYSICS_EVALUATE_H

#include "physics/system/work.h"

typedef struct contact_geometry {
  double nx, ny;  /* from a to b's surface */
  double overlap; /* negative where there is a gap */
  double lambda;  /* from the reference direction */
  double turned;  /* angle of the normal from there */
} contact_geometry;

contact_geometry contact_geometry_of(const engine *e, size_t pair);
/* Force of a closed contact on b, and the torques about both centres, a wall's about its pivot. */
typedef struct contact_reaction {
  double fx, fy, torque_a, torque_b;
} contact_reaction;
contact_reaction contact_reaction_of(const engine *e, size_t pair);
/* Energies stored in closed contact k at the present coordinates. */
typedef struct contact_energies {
  double normal, tangential, rolling, cohesion;
} contact_energies;
contact_energies contact_energies_of(const engine *e, size_t pair);
/* The contact with a wall segment once more, after its record has changed: history only, no forces on the bodies. */
void contact_evaluate_again(engine *e, size_t pair);

#endif
