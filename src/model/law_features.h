/* law_features.h: the parts of contact laws, as flags by which loops over contacts leave out what
 * no law of a model has. */
#ifndef MODEL_LAW_FEATURES_H
#define MODEL_LAW_FEATURES_H

#include <stdint.h>

#include "slipdisk/law.h"

/* Flags of the parts of a contact law beyond the basic one, which is linear with gamma_n, k_t
 * and mu. Loops over contacts leave out parts that no law of the model has. */
enum {
  LAW_NORMAL = 1,  /* normal law not linear, or damped by a coefficient of restitution */
  LAW_PULLS = 2,   /* normal damping that may make the normal force attractive */
  LAW_KINETIC = 4, /* friction coefficient of sliding contacts below mu */
  LAW_MINDLIN = 8,
  LAW_DASHPOT = 16, /* tangential viscosity */
  LAW_ROLLING = 32,
  LAW_COHESION = 64,
  LAW_BRIDGE = 128,   /* capillary bridges */
  LAW_RADIUS = 256,   /* stiffness from a modulus and R_eff (E_star) */
  LAW_CRITICAL = 512, /* friction above a critical load only */
  LAW_BOND = 1024,
  LAW_BOND_MADE = LAW_BOND, /* what is set when a bond is made */
  LAW_BEAM = 2048, /* bonds whose stiffness follows from a modulus and the radii (bond_E) */
  LAW_GAP = LAW_COHESION | LAW_BOND, /* contacts that may be closed across a gap */
  LAW_GENERAL = ~LAW_NORMAL
};
/* True if a pass over general laws with these features needs what the part `laws` of a law needs:
 * a row of SD_CONTACT_MORE (slipdisk/contact.h). */
#define LAW_NEEDS(features, laws) (LAW_##laws == LAW_GENERAL || ((features)&LAW_##laws) != 0)
/* True if quantities of the part `laws` change in steps in which no contact begins, ends or
 * breaks. */
#define LAW_CHANGES(laws) (LAW_CHANGES_##laws != 0)
enum {
  LAW_CHANGES_GENERAL = 1,
  LAW_CHANGES_COHESION = 1,
  LAW_CHANGES_ROLLING = 1,
  LAW_CHANGES_BOND = 1,
  LAW_CHANGES_BOND_MADE = 0
};
/* Returns the flags LAW_... of the parts that one contact law has; 0 if the law is not given. */
unsigned law_features(const sd_contact_law *law);

/* Effective radius R_a R_b/(R_a + R_b) of rolling, and of Hertz' law; on a straight wall (rb = 0)
 * R_a. */
static inline double law_arm(double ra, double rb) { return rb == 0.0 ? ra : ra * rb / (ra + rb); }

/* True if phases can bond pairs of this law. */
static inline bool law_bonds(const sd_contact_law *law) {
  return law->bond_k_n > 0.0 || law->bond_E > 0.0;
}
/* Returns the strength of a bond over that of its law: 1, or (-ln u)^(1/m) with the Weibull modulus
 * m (Weibull, J. Appl. Mech. 18, 293). u: uniform in [0, 1), taken as at least 2^-54. */
double bond_strength(const sd_contact_law *law, double u);
/* Returns a number u for the bond of two bodies, a function of the seed and their numbers. */
double bond_draw(int64_t seed, uint32_t a, uint32_t b);
/* Returns the law with the stiffnesses of a bond between these radii (rb: 0 for walls; arm: R_eff)
 * in place of bond_E, as law_radius.h does it in steps. */
sd_contact_law bond_law_at(const sd_contact_law *law, double ra, double rb, double arm);

#endif
