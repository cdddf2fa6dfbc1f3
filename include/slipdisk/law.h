/* law.h: the contact law of two materials. */
#ifndef SLIPDISK_LAW_H
#define SLIPDISK_LAW_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Tangential force on the centres of two disks at distance r: tau of the paper, or tau (R_a +
 * R_b)/r, which derives from the tangential energy. */
typedef enum sd_variant { SD_PAPER, SD_CONSERVATIVE } sd_variant;

/* Elastic normal force at the overlap delta: k_n delta, or k_n delta^(3/2). SD_NORMAL_LAWS is the
 * number of laws. */
typedef enum sd_normal_law { SD_NORMAL_LINEAR, SD_NORMAL_HERTZ, SD_NORMAL_LAWS } sd_normal_law;
/* Tangential stiffness at the overlap delta: k_t, or k_t sqrt(delta). */
typedef enum sd_tangential_law { SD_TANGENTIAL_SPRING, SD_TANGENTIAL_MINDLIN } sd_tangential_law;
/* Attraction of two surfaces: none; `pull_off` in contact, falling to 0 at the gap `range`; or a
 * capillary bridge, which forms at contact and breaks at the gap `rupture`. */
typedef enum sd_cohesion_law {
  SD_COHESION_NONE,
  SD_COHESION_CONSTANT,
  SD_COHESION_BRIDGE
} sd_cohesion_law;

/* Constants of the contact law for one pair of materials (docs/physics.md 2; eqs. 2 and 36 of
 * the paper). */
typedef struct sd_contact_law {
  double k_n;           /* normal stiffness > 0, force/length; Hertz: force/length^(3/2) */
  double k_t;           /* tangential stiffness, force/length, >= 0; Mindlin: force/length^(3/2) */
  double gamma_n;       /* normal viscosity, force time/length, >= 0 */
  double mu;            /* Amonton's coefficient of friction, >= 0 */
  sd_normal_law normal; /* kind of elastic normal force */
  /* Coefficient of restitution < 1, from which a damping beside gamma_n is computed; 0 or 1:
   * none */
  double restitution;
  /* true: damping may make the normal force of overlapping bodies attractive (limit_damping =
   * false) */
  bool damping_pulls;
  /* true: a bond acts in place of friction and rolling friction of its contact while it lasts */
  bool bond_alone;
  double mu_kinetic; /* coefficient of friction while a contact slides, <= mu; 0: equal to mu */
  /* Normal force above which there is friction, >= 0: the tangential force is at most mu times the
   * normal force less this; needs k_t and mu */
  double critical_load;
  sd_tangential_law tangential; /* kind of tangential spring */
  double gamma_t;               /* tangential viscosity, force time/length, >= 0 */
  double k_r, gamma_r; /* rolling stiffness, force/length, and viscosity, force time/length; >= 0 */
  double drag_r;       /* rolling viscosity without limit, force time/length, >= 0 */
  double mu_r;         /* coefficient of rolling friction, >= 0 */
  sd_cohesion_law cohesion; /* kind of attraction between the surfaces */
  double pull_off;          /* largest attraction (unit: force); must be > 0 with an attraction */
  /* Constant attraction: gap at which it ends, >= 0; capillary bridge: decay length, > 0 */
  double range;
  double rupture; /* gap at which a capillary bridge breaks, > 0 */
  /* Hertz: effective modulus E*, force/length^2, in place of k_n, which is then 0 or 4/3 E_star.
   * The stiffness of a contact is 4/3 E_star sqrt(R_eff), R_eff = R_a R_b/(R_a + R_b), on
   * straight walls R_a. 0: k_n is the stiffness, whatever the radii are */
  double E_star;
  /* Mindlin with E_star: Poisson's ratio nu, > 0 and at most 0.5, in place of k_t, which is then
   * 0 or k_n 3 (1 - nu)/(2 - nu); it is multiplied by sqrt(R_eff), too. 0: k_t is the stiffness */
  double poisson;
  /* Bonds that join two surfaces (docs/laws.md, Bonds). Stiffnesses, force/length, for the changes
   * of gap, lambda and rho since the bond was made, >= 0; all 0: there are no bonds of this law */
  double bond_k_n, bond_k_t, bond_k_r;
  /* In place of the stiffnesses, a beam of length R_a + R_b: Young's modulus, force/length,
   * Poisson's ratio and width, a length. The width is needed for strengths that are stresses. */
  double bond_E, bond_poisson, bond_width;
  double bond_gamma_n, bond_gamma_t, bond_gamma_r; /* viscosities, force time/length, >= 0 */
  double bond_gap; /* largest gap of the surfaces when a bond is made, >= 0 */
  /* Strength, >= 0, 0: no limit. As stresses in the beam, force/length: tensile strength, cohesion
   * and coefficient of internal friction; or as forces, and a bending moment, force length, whose
   * loads are added up. */
  double bond_tension, bond_cohesion, bond_friction;
  double bond_max_tension, bond_max_shear, bond_max_bending;
  double bond_extension; /* length by which a bond may become longer before it breaks; 0: any */
  /* Weibull modulus of the strengths, > 0; 0: all bonds have the strength above, which is else the
   * one that a share 1/e of the bonds exceeds */
  double bond_weibull;
} sd_contact_law;

#ifdef __cplusplus
}
#endif

#endif
