/* contact.h: what a closed contact remembers, listed once.
 *
 * Columns of the pair list, their carrying over rebuilds, the state, checkpoints, rare events, the rows of small systems
 * and packings that are read from a result follow from the tables. An open contact remembers nothing: all columns are 0.
 */
#ifndef SLIPDISK_CONTACT_H
#define SLIPDISK_CONTACT_H

#include <stdint.h>

/* X(name, unit, meaning). The last two are 0 with the conservative variant. */
#define SD_CONTACT_RECORD(X)                                                                       \
  X(lambda_ref, "length", "lambda* from the reference direction (eq. tau)")                        \
  X(ex, "1", "reference direction, x")                                                             \
  X(ey, "1", "reference direction, y")                                                             \
  X(force, "force", "normal force F_n")                                                            \
  X(overlap, "length", "overlap delta")                                                            \
  X(zeta, "length", "tangential displacement lambda - lambda*")                                    \
  X(viscous, "energy", "lost to viscosity since the contact began")                                \
  X(friction, "energy", "lost to sliding since the contact began")                                 \
  X(turned, "rad", "angle of the normal from the reference direction")                             \
  X(nonconservative_work, "energy",                                                                \
    "put in by the paper's tangential force since the contact began")

/* Columns that models have whose laws need them, 0 in others. */
#define SD_CONTACT_MORE(X)                                                                         \
  X(tau, "force", "tangential force, spring and dashpot")                                          \
  X(pull, "force", "attraction, by which the normal force is smaller")                             \
  X(rho_ref, "length", "reference of the rolling displacement")                                    \
  X(rho, "length", "rolling displacement R_eff (theta_a - theta_b) from there")                    \
  X(roll, "force", "rolling force; over the arm R_eff it is the couple")                           \
  X(rolling, "energy", "lost to rolling since the contact began")

#define SD_CONTACT_MEMBER(name, unit, meaning) double name;
typedef struct sd_contact_record {
  SD_CONTACT_RECORD(SD_CONTACT_MEMBER)
  SD_CONTACT_MORE(SD_CONTACT_MEMBER)
} sd_contact_record;
#undef SD_CONTACT_MEMBER

/* Columns of all models, of these laws, and of both. */
#define SD_CONTACT_ONE(name, unit, meaning) +1
enum {
  SD_CONTACT_COLUMNS = 0 SD_CONTACT_RECORD(SD_CONTACT_ONE),
  SD_CONTACT_EXTRA = 0 SD_CONTACT_MORE(SD_CONTACT_ONE),
  SD_CONTACT_ALL = SD_CONTACT_COLUMNS + SD_CONTACT_EXTRA
};
#undef SD_CONTACT_ONE

#endif
