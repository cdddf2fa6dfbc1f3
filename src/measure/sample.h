/* sample.h: updates running statistics: sliding configurations and angles of the watched disks at
 * every measured step, and means of every disk. */
#ifndef MEASURE_SAMPLE_H
#define MEASURE_SAMPLE_H

#include "base/team.h"
#include "physics/system/work.h"

/* Begins a measured phase, the first or one after a pause in measuring. */
void sample_begin(engine *e);
/* Ends a measured phase. */
void sample_end(engine *e);
/* Samples the watched disks after n completed measured steps, no more than sample_steps_to_look. */
void sample_steps(engine *e, int64_t n);
/* Returns the number of measured steps after which sample_steps and disks_step next look at disks
 * or contacts. */
int64_t sample_steps_to_look(const engine *e);
/* Parts of sample_steps for loops that count steps and sliding configurations themselves.
 * sample_bins closes the current bin of angles if it is complete; angles must be current.
 * sample_steps_to_bin_end returns the number of measured steps until the bin is complete,
 * INT64_MAX without watched angles. */
void sample_bins(engine *e);
int64_t sample_steps_to_bin_end(const engine *e);

/* Means of every free disk, summed in the state's columns mean_* and sum_* while a run measures.
 *
 * Angles: a record of SD_MEAN_BINS bins per disk, like that of watched disks. Contacts, positions
 * and energies: sums over samples, taken every model->measure_every measured steps. Losses:
 * differences of the state's loss_* columns. Openings: counted by contacts.c. Disks are processed
 * by index and the contacts of each disk in a fixed order, so that the results depend bitwise
 * neither on the number of threads nor on the neighbour lists. */

/* disks_begin and disks_end begin and end a measured phase; they do nothing unless the model asks
 * for means. */
void disks_begin(engine *e);
void disks_end(engine *e);
/* Samples the disks of this thread's range after a completed measured step. measured: number of
 * measured steps including this one; it is an argument, as another thread may be changing
 * state->measured. */
void disks_step(engine *e, const team *t, int64_t measured);

#endif
