/* contact.h: the quantities that a closed contact stores from step to step, as tables.
 *
 * Code that is generated from these tables: columns of the pair list and their transfer when
 * neighbour lists are rebuilt, contact columns of the state and of checkpoints, contacts that open
 * or begin, rows of small systems that run side by side in SIMD lanes, and packings that are read
 * from a result. All columns of an open contact are 0.
 */
#ifndef SLIPDISK_CONTACT_H
#define SLIPDISK_CONTACT_H

#include <stdint.h>

/* X(name, unit, meaning): table with a row for each quantity that contacts of every model store.
 * `turned` and `nonconservative_work` are 0 with the conservative tangential force
 * (SD_CONSERVATIVE). */
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

/* X(name, unit, meaning, laws): further quantities. `laws` is the part of a contact law that needs
 * the quantity: ROLLING, COHESION, BOND, BOND_MADE (set when a bond is made, and when it
 * breaks), or GENERAL for any of these, damping that may pull, kinetic friction, Mindlin's
 * tangential spring or a tangential dashpot. They are 0 unless a law of the model has that part.
 * SD_CONTACT_MEMORY has what the next step needs, SD_CONTACT_LOSSES sums of energies. */
#define SD_CONTACT_MEMORY(X)                                                                       \
  X(tau, "force", "tangential force, spring and dashpot", GENERAL)                                 \
  X(pull, "force", "attraction, by which the normal force is smaller", COHESION)                   \
  X(rho_ref, "length", "reference of the rolling displacement", ROLLING)                           \
  X(rho, "length", "rolling displacement R_eff (theta_a - theta_b) from there", ROLLING)           \
  X(roll, "force", "rolling force; over the arm R_eff it is the couple", ROLLING)                  \
  X(bond, "1", "0: no bond; else its strength over that of the law", BOND_MADE)                    \
  X(bond_overlap, "length", "overlap when the bond was made, negative for a gap", BOND_MADE)       \
  X(bond_lambda, "length", "tangential coordinate lambda when the bond was made", BOND_MADE)       \
  X(bond_rho, "length", "rolling displacement when the bond was made", BOND_MADE)                  \
  X(bond_pull, "force", "tension in the bond, by which the normal force is smaller", BOND)         \
  X(bond_shear, "force", "shear force in the bond, by which tau is smaller", BOND)                 \
  X(bond_bend, "force", "moment in the bond over the arm R_eff", BOND)
#define SD_CONTACT_LOSSES(X)                                                                       \
  X(rolling, "energy", "lost to rolling since the contact began", ROLLING)
#define SD_CONTACT_MORE(X) SD_CONTACT_MEMORY(X) SD_CONTACT_LOSSES(X)

#define SD_CONTACT_MEMBER(name, ...) double name;
/* The stored quantities of one contact between two bodies a and b, in the order of the tables
 * SD_CONTACT_RECORD and SD_CONTACT_MORE. */
typedef struct sd_contact_record {
  SD_CONTACT_RECORD(SD_CONTACT_MEMBER)
  SD_CONTACT_MORE(SD_CONTACT_MEMBER)
} sd_contact_record;
#undef SD_CONTACT_MEMBER

#define SD_CONTACT_ONE(name, ...) +1
/* Numbers of columns per contact: rows of SD_CONTACT_RECORD, rows of SD_CONTACT_MORE, and their
 * sum. */
enum {
  SD_CONTACT_COLUMNS = 0 SD_CONTACT_RECORD(SD_CONTACT_ONE),
  SD_CONTACT_EXTRA = 0 SD_CONTACT_MORE(SD_CONTACT_ONE),
  SD_CONTACT_ALL = SD_CONTACT_COLUMNS + SD_CONTACT_EXTRA
};
#undef SD_CONTACT_ONE

#endif
