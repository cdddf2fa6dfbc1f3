/* validity.h: checks the invariants of the neighbour lists and of completed steps: of pairs, disks,
 * contacts, chunks and rows.
 *
 * Builds with SLIPDISK_CHECK (preset dev) call these functions; a violated invariant is a bug of
 * the engine and ends the process. The checks change nothing, so results do not depend on them.
 * Systems that have blown up are not checked, since this is an error of the user's input.
 */
#ifndef PHYSICS_VALIDITY_H
#define PHYSICS_VALIDITY_H

#include "physics/system/work.h"

#ifdef SD_CHECK
enum { VALIDITY_CHECKED = 1 };
#else
enum { VALIDITY_CHECKED = 0 };
#endif

/* Checks lists that were just built: slots, pairs, contacts of each body, chunks and rows, and that
 * no pair of near disks is missing. */
void validity_check_lists(const engine *e);
/* Checks the state and the closed contacts after a step without error, or after all lengths were
 * rescaled. */
void validity_check_step(const engine *e);

/* Returns true if step `step` is to be checked. Checking costs several times the step itself, so
 * only these steps are checked: the first VALIDITY_ALL, then every power of two and every multiple
 * of VALIDITY_EVERY. As 97 is a prime, its multiples fall on all phases of the usual output
 * intervals. Lists are checked whenever they are built. */
enum { VALIDITY_ALL = 256, VALIDITY_EVERY = 97 };
static inline bool validity_due(int64_t step) {
  return VALIDITY_CHECKED &&
         (step <= VALIDITY_ALL || step % VALIDITY_EVERY == 0 || (step & (step - 1)) == 0);
}

#endif
