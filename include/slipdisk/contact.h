/* contact.h: what a closed contact remembers, listed once.
 *
 * Columns of the pair list, their carrying over rebuilds, the state, checkpoints, rare events, the rows of small systems
 * and packings that are read from a result follow from the table. An open contact remembers nothing: all columns are 0.
 */
#ifndef SLIPDISK_CONTACT_H
#define SLIPDISK_CONTACT_H

#include <stdint.h>

/* X(name, unit, meaning). The last two are 0 with the conservative variant. */
#define SD_CONTACT_RECORD(X)                                                                                 \
  X(lambda_ref, "length", "lambda* from the reference direction (eq. tau)")                                  \
  X(ex, "1", "reference direction, x")                                                                       \
  X(ey, "1", "reference direction, y")                                                                       \
  X(force, "force", "normal force F_n")                                                                      \
  X(overlap, "length", "overlap delta")                                                                      \
  X(zeta, "length", "tangential displacement lambda - lambda*")                                              \
  X(viscous, "energy", "lost to viscosity since the contact began")                                          \
  X(friction, "energy", "lost to sliding since the contact began")                                           \
  X(turned, "rad", "angle of the normal from the reference direction")                                       \
  X(nonconservative_work, "energy", "put in by the paper's tangential force since the contact began")

#define SD_CONTACT_MEMBER(name, unit, meaning) double name;
typedef struct sd_contact_record {
  SD_CONTACT_RECORD(SD_CONTACT_MEMBER)
} sd_contact_record;
#undef SD_CONTACT_MEMBER

enum { SD_CONTACT_COLUMNS = sizeof(sd_contact_record) / sizeof(double) };

#endif
