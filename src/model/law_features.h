/* law_features.h: which parts of the law of a contact a model needs. */
#ifndef MODEL_LAW_FEATURES_H
#define MODEL_LAW_FEATURES_H

#include "model/model.h"

/* Parts of contacts beyond the linear law with gamma_n, k_t and mu; passes leave out what no law of the model has. */
enum {
  LAW_NORMAL = 1, /* not linear, or damped by a coefficient of restitution */
  LAW_PULLS = 2,  /* damping that may pull */
  LAW_KINETIC = 4,
  LAW_MINDLIN = 8,
  LAW_DASHPOT = 16, /* tangential */
  LAW_ROLLING = 32,
  LAW_COHESION = 64,
  LAW_BRIDGE = 128, /* some of these are bridges */
  LAW_GENERAL = ~LAW_NORMAL
};
unsigned law_features(const sd_contact_law *law);
/* Of all laws. */
unsigned laws_features(const sd_model *model);

/* Effective radius of rolling: R_a R_b/(R_a + R_b), on a straight wall R_a. */
static inline double law_arm(double ra, double rb) { return rb == 0.0 ? ra : ra * rb / (ra + rb); }

#endif
