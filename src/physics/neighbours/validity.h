/* validity.h: checks the invariants of lists and of completed steps: of all pairs, disks, contacts,
 * chunks and rows.
 *
 * Builds with SLIPDISK_CHECK (preset dev) call these functions; a violated invariant is a bug of
 * the engine and ends the process. They only read, so results do not depend on them. Systems that
 * have blown up, which is an error of the user's input, pass.
 */
#ifndef PHYSICS_VALIDITY_H
#define PHYSICS_VALIDITY_H

#include "physics/system/work.h"

#ifdef SD_CHECK
enum { VALIDITY_CHECKED = 1 };
#else
enum { VALIDITY_CHECKED = 0 };
#endif

/* Checks lists that were just built: slots, pairs, incidence, chunks, rows, and that no near pair
 * is missing. */
void validity_check_lists(const engine *e);
/* Checks the state and the closed contacts after a step without error, or after a change of all
 * lengths. */
void validity_check_step(const engine *e);

/* Lists are checked whenever they are built. Checking a step costs several times the step itself,
 * so only some are checked: the first VALIDITY_ALL, then every power of two and every multiple of
 * 97, which meets all residues of the usual intervals. */
enum { VALIDITY_ALL = 256, VALIDITY_EVERY = 97 };
static inline bool validity_due(int64_t step) {
  return VALIDITY_CHECKED &&
         (step <= VALIDITY_ALL || step % VALIDITY_EVERY == 0 || (step & (step - 1)) == 0);
}

#endif
