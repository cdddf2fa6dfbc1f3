/* validity.h: examines what lists and completed steps promise: over all pairs, disks, contacts, chunks and rows.
 *
 * Builds with SLIPDISK_CHECK (preset dev) call it; a violated promise is a bug of the engine and ends the process. It
 * only reads, so that no bit depends on it. Systems that have blown up, which is for the user to mend, pass.
 */
#ifndef PHYSICS_VALIDITY_H
#define PHYSICS_VALIDITY_H

#include "physics/system/work.h"

#ifdef SD_CHECK
enum { VALIDITY_CHECKED = 1 };
#else
enum { VALIDITY_CHECKED = 0 };
#endif

/* The lists, just built: slots, pairs, incidence, chunks, rows, and whether near pairs are missing. */
void validity_check_lists(const engine *e);
/* The state, and the contacts among the pairs, after a step that went well, or a change of all lengths. */
void validity_check_step(const engine *e);

/* Lists are examined whenever they are built. A step costs several times as much when it is examined, so these are: all
 * at the beginning, then every power of two and every 97th, which meets all residues of the usual intervals. */
enum { VALIDITY_ALL = 256, VALIDITY_EVERY = 97 };
static inline bool validity_due(int64_t step) {
  return VALIDITY_CHECKED &&
         (step <= VALIDITY_ALL || step % VALIDITY_EVERY == 0 || (step & (step - 1)) == 0);
}

#endif
