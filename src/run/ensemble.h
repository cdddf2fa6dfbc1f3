/* ensemble.h: simulations that are advanced together: those that are alike go side by side in the lanes of vectors.
 *
 * Each gives the bits of the simulation on its own, whatever else is in the ensemble and on whatever machine: lanes
 * do not mix. Members are alike when they have the same bodies, motions, phases and measurements; any number in
 * them may differ. Members that cannot go in lanes are advanced by themselves.
 */
#ifndef SLIPDISK_RUN_ENSEMBLE_H
#define SLIPDISK_RUN_ENSEMBLE_H

#include "slipdisk/simulation.h"

typedef struct ensemble ensemble;

/* How many systems are worth putting together on this machine: a multiple of the lanes of a vector. */
size_t ensemble_width(void);
/* Can simulations of this model go in lanes (few bodies, open box, nothing that needs the general step)? */
bool ensemble_takes(const sd_model *model);
/* Can two such models share lanes? Symmetric, and transitive. */
bool ensemble_alike(const sd_model *a, const sd_model *b);

/* Members stay the caller's, and must outlive the ensemble. They need not stand at the same step,
 * nor be alike: what does not fit together is advanced one by one. Simulations of one thread
 * only. */
ensemble *ensemble_new(size_t n, sd_simulation *const *members);
void ensemble_free(ensemble *e);

/* Advances every member by n steps, as sd_simulation_advance would; each has its own status and messages. One that
 * is finished, or whose status is not SD_OK on entry, is left as it is. All states are complete afterwards:
 * everything may be done with a member between calls that may be done with a simulation. */
void ensemble_advance(ensemble *e, int64_t n, sd_status *status, sd_messages *const *messages);

/* Members that went in lanes during the last call. */
size_t ensemble_in_lanes(const ensemble *e);

#endif
