/* normal_laws.h: the normal contact laws: elastic force, damping, stored energy and tangent
 * stiffness.
 *
 * A law is one row of the table below and one header law_NAME.h; its number is in the enum
 * sd_normal_law (slipdisk/model.h), its deck keys and documentation follow from the row. A law
 * defines these functions of the stiffness k and the overlap delta > 0:
 *
 *   NAME_force(k, delta)      elastic force, without damping
 *   NAME_energy(k, delta)     stored energy
 *   NAME_stiffness(k, delta)  dF/ddelta, for time steps, loads, compression
 *   NAME_viscosity(tsuji, delta)  coefficient of the damping by restitution;
 *                             tsuji = alpha sqrt(m_eff k)
 *   NAME_factor(b)            alpha of this damping, if its restitution is that of a linear
 *                             oscillator of frequency 1 with damping ratio b
 * and these functions of several contacts at once, one per SIMD lane:
 *   NAME_elastic(k, delta)    elastic force, without damping
 *   NAME_damping(gamma_n, tsuji, delta)  coefficient gamma of the damping force -gamma u_n;
 *                             tsuji = alpha sqrt(m_eff k)
 *   NAME_stored(k, delta)     stored energy
 *
 * Normal forces act along the line of centres and exert no torque. The tangential force tau
 * turns both bodies in the same sense, times their radii (SUM_TORQUE of physics/system/work.h);
 * the couple of rolling friction turns them in opposite senses (SUM_COUPLE).
 *
 * The rows are read once; the functions for SIMD lanes are compiled once per LANE_WIDTH, after
 * base/lane.h. */
#ifndef MODEL_NORMAL_LAWS_H
#define MODEL_NORMAL_LAWS_H

#include <math.h>

#include "model/law_features.h"

/* Table of normal contact laws: ROW(number, name in the deck, keys as in deck_shape (keys.h),
 * meaning). */
#define NORMAL_LAWS(ROW)                                                                           \
  ROW(SD_NORMAL_LINEAR, linear, "", "F = k_n delta (eq. 2)")                                       \
  ROW(SD_NORMAL_HERTZ, hertz, "", "F = k_n delta^(3/2)")

typedef struct normal_law {
  const char *name;
  double (*force)(double k, double delta);
  double (*energy)(double k, double delta);
  double (*stiffness)(double k, double delta);
  double (*factor)(double b);
  double (*viscosity)(double tsuji, double delta);
} normal_law;

extern const normal_law normal_laws[SD_NORMAL_LAWS];

/* Sets the k_n of a law with E_star, and the k_t of one with poisson, for R_eff = 1. Values that
 * are not 0 stay; law_mistake (laws.h) reports them if they are others. */
void law_complete(sd_contact_law *law);
/* Returns the law of a contact with effective radius `arm` (law_arm): k_n of E_star and k_t of
 * poisson are multiplied by sqrt(arm), as law_radius.h does it in steps. Other laws stay as they
 * are. */
static inline sd_contact_law law_at(const sd_contact_law *law, double arm) {
  sd_contact_law at = *law;
  if (law->E_star > 0.0) at.k_n *= sqrt(fabs(arm));
  if (law->poisson > 0.0) at.k_t *= sqrt(fabs(arm));
  at.E_star = at.poisson = 0.0;
  return at;
}
/* The three functions below take a law without E_star, or one from law_at.
 * Elastic normal force at overlap delta. */
static inline double law_force(const sd_contact_law *law, double delta) {
  return normal_laws[law->normal].force(law->k_n, delta);
}
/* Energy stored in the normal force at overlap delta. */
static inline double law_energy(const sd_contact_law *law, double delta) {
  return normal_laws[law->normal].energy(law->k_n, delta);
}
/* Tangent stiffness dF/ddelta at overlap delta. */
static inline double law_stiffness(const sd_contact_law *law, double delta) {
  return normal_laws[law->normal].stiffness(law->k_n, delta);
}
/* Stiffness at an overlap of 0.01 R, on a straight wall (R_eff = R), for estimates of periods; a
 * linear law has the same at any overlap. */
static inline double law_typical_stiffness(const sd_contact_law *law, double radius) {
  const sd_contact_law at = law_at(law, radius);
  return law_stiffness(&at, 0.01 * radius);
}
/* Returns the damping ratio b of a linear oscillator whose collisions have this coefficient of
 * restitution. pulls: true if the force may become attractive, false if it is cut off at 0. */
double law_damping_ratio(double restitution, bool pulls);
/* Returns the coefficient alpha of the damping by which a law reaches its coefficient of
 * restitution (Tsuji et al.); 0 if the law gives no restitution. */
double law_tsuji(const sd_contact_law *law);

#endif

#include "model/law_hertz.h"
#include "model/law_linear.h"
