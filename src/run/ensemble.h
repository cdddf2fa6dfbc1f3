/* ensemble.h: advances several simulations together; simulations that are alike go side by side in
 * the lanes of SIMD vectors.
 *
 * Each simulation gives the same bits as when it is advanced alone, whatever other members the
 * ensemble has and on any machine, since lanes do not mix. Simulations are alike if they have the
 * same bodies, motions, phases and measurements; any number in them may differ. Members that cannot
 * go in lanes are advanced one by one. */
#ifndef SLIPDISK_RUN_ENSEMBLE_H
#define SLIPDISK_RUN_ENSEMBLE_H

#include "slipdisk/simulation.h"

typedef struct ensemble ensemble;

/* Returns the number of systems that fill the lanes of a SIMD vector on this machine. */
size_t ensemble_width(void);
/* Returns true if simulations of this model can go in SIMD lanes: few bodies, open box, no feature
 * that only the general step has. */
bool ensemble_takes(const sd_model *model);
/* Returns true if simulations of the two models can share SIMD lanes. The relation is symmetric and
 * transitive. */
bool ensemble_alike(const sd_model *a, const sd_model *b);

/* Makes an ensemble. The caller keeps the members, which must outlive the ensemble and have one
 * thread each. They need not be alike nor at the same step: members that do not fit together are
 * advanced one by one. */
ensemble *ensemble_new(size_t n, sd_simulation *const *members);
void ensemble_free(ensemble *e);

/* Advances every member by n steps, as sd_simulation_advance does; each member has its own
 * status[k] and messages[k]. A member that is finished, or whose status is not SD_OK on entry, is
 * not advanced. On return the states of all members are complete, so that any function may be
 * called on a simulation between two calls of this function. */
void ensemble_advance(ensemble *e, int64_t n, sd_status *status, sd_messages *const *messages);

/* Returns the largest number of members that shared SIMD lanes during the last call of
 * ensemble_advance. */
size_t ensemble_in_lanes(const ensemble *e);

#endif
