/* trajectory.h: makes and fills the tables of frames (configurations of all bodies) and of closed
 * contacts, with the columns of frame_observables and contact_observables.
 *
 * Disks and walls are in the order of the deck (body number), whatever their slots in the state.
 * The contacts stored at one time are consecutive rows of one long table; a second table, the
 * index, gives their range: rows first ... first + count - 1. The column `first` is computed when
 * part files are merged (merge.c).
 *
 * shared: true if columns of disks and contacts are left out, because each rank writes its own
 * (record.h).
 */
#ifndef SLIPDISK_IO_TRAJECTORY_H
#define SLIPDISK_IO_TRAJECTORY_H

#include "io/store/table.h"
#include "measure/observable.h"

/* Adds the columns of a table of frames: of walls if `walls` is true, else of disks. If the model
 * has no such bodies the table stays empty. Edges of the box and scale of the region are columns
 * only if some phase compresses, else they are stored as constants (constants.h). */
void trajectory_new_bodies(table *t, const sd_model *model, bool walls, bool shared);
/* Adds one frame, which is one row of the table. */
sd_status trajectory_sample_bodies(table *t, const moment *now, bool walls, bool shared,
                                   sd_messages *messages);

/* trajectory_new_clumps adds the columns of a table of clumps (clump_observables);
 * trajectory_sample_clumps adds one row, for the time of `now`. */
void trajectory_new_clumps(table *t, const sd_model *model);
sd_status trajectory_sample_clumps(table *t, const moment *now, sd_messages *messages);

/* Adds the columns of the contact index and of the table of contacts. */
void trajectory_new_contacts(table *index, table *rows, const sd_model *model, bool shared);
/* Adds one row to the contact index and, unless each rank writes its own contacts (kind
 * RECORD_HEAD), one row per contact to `rows`. count: number of contacts at this time. */
sd_status trajectory_sample_contacts(table *index, table *rows, const moment *now, size_t count,
                                     sd_messages *messages);

/* trajectory_add_bodies adds the columns of bodies to a table, below the path `group`: each row
 * holds an array of n bodies, or a single body (no array) if n = 0. trajectory_put_bodies fills
 * these columns for n bodies, beginning with column number `column`, and returns the number of
 * the next column. slots: slots of the bodies; NULL: all bodies in the order of their numbers. */
void trajectory_add_bodies(table *t, const sd_model *model, const char *group, bool walls,
                           size_t n);
size_t trajectory_put_bodies(table *t, size_t column, const moment *now, bool walls, size_t n,
                             const uint32_t *slots);
/* trajectory_add_contacts adds the columns of contacts to a table, one contact per row, below the
 * path `group`; trajectory_put_contacts fills these columns for n contacts, beginning with column
 * number `column`. which: indices of the contacts in the state; NULL: 0 ... n - 1. */
void trajectory_add_contacts(table *rows, const sd_model *model, const char *group);
void trajectory_put_contacts(table *rows, size_t column, const moment *now, size_t n,
                             const uint32_t *which);

/* Computes the lengths of the periodic box along x and y, `scale` times those given in the deck; 0
 * in open directions. */
void trajectory_edges(const sd_model *model, double scale, double edges[2]);

/* --- Time series: the columns of energy_observables and series_observables -------------------- */

/* Adds the columns that the time series of this model has. */
void series_new(table *t, const sd_model *model);
/* Adds one row to the time series. */
sd_status series_sample(table *t, const moment *now, sd_messages *messages);
/* Writes lists of the disks, walls and groups to which the elements of the series' per-body columns
 * belong, in order. */
void series_write_columns(h5_file *file, const sd_model *model);

#endif
