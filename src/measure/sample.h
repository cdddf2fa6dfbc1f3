/* sample.h: running statistics: sliding configurations and angles of the watched disks at every measured
 * step, and means of every disk. */
#ifndef MEASURE_SAMPLE_H
#define MEASURE_SAMPLE_H

#include "base/team.h"
#include "physics/system/work.h"

/* A measured phase begins or goes on after one that was not measured. */
void sample_begin(engine *e);
/* A measured phase ends. */
void sample_end(engine *e);
/* One measured step was completed. */
void sample_step(engine *e);
/* The parts of it, for a loop that counts configurations and steps by itself: the angles, which must be new, at the
 * end of a bin; measured steps until then. */
void sample_bins(engine *e);
int64_t sample_room(const engine *e);

/* Means of every free disk, gathered in the state's columns mean_* while a run measures.
 *
 * Angles: a record of SD_MEAN_BINS bins per disk, as sample.c has it for watched ones. Contacts, positions and energies:
 * sums over looks, every model->measure_every measured steps. Losses: differences of the state's loss_*, at no cost.
 * Openings: counted by contacts.c. Everything is done by index of the disk, its contacts in the fixed order of
 * the incidence, so that the bits depend on neither threads nor lists.
 */

/* Begin and end a measured phase, like sample_begin; no-ops unless the model asks for means. */
void disks_begin(engine *e);
void disks_end(engine *e);
/* A measured step was completed, the measured-th; one member's share. The state's own count (state->measured)
 * is not looked at, as another member may be changing it. */
void disks_step(engine *e, const team *t, int64_t measured);

#endif
