/* law_features.h: flags of the parts of the contact law that a model needs. */
#ifndef MODEL_LAW_FEATURES_H
#define MODEL_LAW_FEATURES_H

#include "model/model.h"

/* Parts of the contact law beyond the linear one with gamma_n, k_t and mu; the contact passes
 * omit parts that no law of the model has. */
enum {
  LAW_NORMAL = 1,  /* normal law not linear, or damped by a coefficient of restitution */
  LAW_PULLS = 2,   /* normal damping that may make the force attractive */
  LAW_KINETIC = 4, /* friction coefficient of sliding contacts below mu */
  LAW_MINDLIN = 8,
  LAW_DASHPOT = 16, /* tangential viscosity */
  LAW_ROLLING = 32,
  LAW_COHESION = 64,
  LAW_BRIDGE = 128, /* capillary bridges */
  LAW_GENERAL = ~LAW_NORMAL
};
/* Flags of one law; 0 if it is not given. */
unsigned law_features(const sd_contact_law *law);
/* Flags of all laws of the model. */
unsigned laws_features(const sd_model *model);

/* Effective radius of rolling, R_a R_b/(R_a + R_b); on a straight wall (rb = 0) R_a. */
static inline double law_arm(double ra, double rb) { return rb == 0.0 ? ra : ra * rb / (ra + rb); }

#endif
