/* law_constants.h: the constants of general contact laws, one row each:
 *
 *   ROW(features, name, value)  features: LAW_ bits of the laws that have the constant
 *                               name:     member of law_row and of contact_constants
 *                               value:    computed once from the law `l` (sd_contact_law) of a pair
 *                                         of materials
 *
 * The members of these structs, the table of laws and the code that loads the constants of a pair
 * follow from the rows. A constant is loaded as 0 if no law of the model has its features. */
#ifndef MODEL_LAW_CONSTANTS_H
#define MODEL_LAW_CONSTANTS_H

#include <math.h>

#include "base/math.h"
#include "model/law_features.h"

/* Returns a/b, or 0 if b is 0. */
static inline double law_ratio(double a, double b) { return b > 0.0 ? a / b : 0.0; }
static inline bool law_is_bridge(const sd_contact_law *l) {
  return l->cohesion == SD_COHESION_BRIDGE;
}
static inline bool law_is_constant(const sd_contact_law *l) {
  return l->cohesion == SD_COHESION_CONSTANT;
}

/* Section modulus of a bond per unit depth, width^2/6: its bending strength over the tensile
 * one. */
static inline double law_beam(const sd_contact_law *l) {
  return l->bond_width * l->bond_width / 6.0;
}

#define LAW_CONSTANTS(ROW)                                                                         \
  /* 1: damping may pull (make the normal force attractive) */                                     \
  ROW(LAW_PULLS, pulls, l->damping_pulls)                                                          \
  /* limit of the tangential displacement while the contact slides, over the normal force */       \
  ROW(LAW_KINETIC, cap_kinetic, law_ratio(l->mu_kinetic > 0.0 ? l->mu_kinetic : l->mu, l->k_t))    \
  ROW(LAW_CRITICAL, critical_load, l->critical_load)                                               \
  ROW(LAW_MINDLIN, mindlin, l->tangential == SD_TANGENTIAL_MINDLIN)                                \
  ROW(LAW_DASHPOT, dashpot_ratio, law_ratio(l->gamma_t, l->k_t))                                   \
  /* 1: k_n, and k_t with what is divided by it, depend on R_eff (law_radius.h) */                 \
  ROW(LAW_RADIUS, scales_k_n, l->E_star > 0.0)                                                     \
  ROW(LAW_RADIUS, scales_k_t, l->poisson > 0.0)                                                    \
  ROW(LAW_ROLLING, k_r, l->k_r)                                                                    \
  ROW(LAW_ROLLING, cap_r, law_ratio(l->mu_r, l->k_r))                                              \
  ROW(LAW_ROLLING, dashpot_ratio_r, law_ratio(l->gamma_r, l->k_r))                                 \
  ROW(LAW_ROLLING, drag_r, l->drag_r)                                                              \
  ROW(LAW_COHESION, bridge, law_is_bridge(l))                                                      \
  ROW(LAW_COHESION, pull_off, l->cohesion == SD_COHESION_NONE ? 0.0 : l->pull_off)                 \
  ROW(LAW_COHESION, range, l->cohesion == SD_COHESION_NONE ? 0.0 : l->range)                       \
  ROW(LAW_COHESION, per_range, l->cohesion == SD_COHESION_NONE ? 0.0 : law_ratio(1.0, l->range))   \
  /* attraction over pull_off at the gap where a bridge breaks */                                  \
  ROW(LAW_COHESION, broken,                                                                        \
      law_is_bridge(l) ? math_exp(-l->rupture *law_ratio(1.0, l->range)) : 0.0)                    \
  /* gaps at which a contact begins and ends */                                                    \
  ROW(LAW_COHESION, begins, law_is_constant(l) ? l->range : 0.0)                                   \
  ROW(LAW_COHESION, ends, law_is_constant(l) ? l->range : law_is_bridge(l) ? l->rupture : 0.0)     \
  /* stiffnesses of a bond; those of a beam: times its length, and times length and R_eff^2 */     \
  ROW(LAW_BOND, bond_k_n, l->bond_E > 0.0 ? l->bond_E * l->bond_width : l->bond_k_n)               \
  ROW(LAW_BOND, bond_k_t,                                                                          \
      l->bond_E > 0.0 ? l->bond_E * l->bond_width / (2.0 * (1.0 + l->bond_poisson)) : l->bond_k_t) \
  ROW(LAW_BOND, bond_k_r,                                                                          \
      l->bond_E > 0.0 ? l->bond_E * law_beam(l) * l->bond_width / 2.0 : l->bond_k_r)               \
  ROW(LAW_BEAM, is_beam, l->bond_E > 0.0)                                                          \
  ROW(LAW_BOND, bond_gamma_n, l->bond_gamma_n)                                                     \
  ROW(LAW_BOND, bond_gamma_t, l->bond_gamma_t)                                                     \
  ROW(LAW_BOND, bond_gamma_r, l->bond_gamma_r)                                                     \
  ROW(LAW_BOND, bond_alone, l->bond_alone)                                                         \
  /* 1 over tensile, shear and bending strength and largest extension, 0: no limit */              \
  ROW(LAW_BOND, per_tension,                                                                       \
      law_ratio(1.0, l->bond_max_tension + l->bond_tension * l->bond_width))                       \
  ROW(LAW_BOND, per_shear, law_ratio(1.0, l->bond_max_shear + l->bond_cohesion * l->bond_width))   \
  ROW(LAW_BOND, per_bending, law_ratio(1.0, l->bond_max_bending + l->bond_tension * law_beam(l)))  \
  ROW(LAW_BOND, bond_friction, l->bond_friction)                                                   \
  ROW(LAW_BOND, per_extension, law_ratio(1.0, l->bond_extension))                                  \
  /* 1: the loads by tension, shear and bending are added up */                                    \
  ROW(LAW_BOND, loads_add, l->bond_max_tension + l->bond_max_shear + l->bond_max_bending > 0.0)

#endif
