/* trajectory.h: makes and fills the tables of frames of all bodies, and of all closed contacts,
 * with the columns of frame_observables and contact_observables.
 *
 * Disks and walls are in the order of the deck (body number), whatever their slots in the state.
 * The contacts of one moment are consecutive rows of one long table; a second table, the index,
 * gives their range: rows first ... first + count - 1. `first` is computed when parts are merged
 * (merge.c).
 *
 * shared: true if columns of disks and contacts are left out, because they are in the shares of
 * the ranks (record.h). */
#ifndef SLIPDISK_IO_TRAJECTORY_H
#define SLIPDISK_IO_TRAJECTORY_H

#include "io/store/table.h"
#include "measure/observable.h"

/* Adds the columns of a table of frames: of walls if `walls` is true, else of disks. Without such
 * bodies the table stays empty. Edges of the box and scale of the region are columns only if some
 * phase compresses, else they are constants (constants.h). */
void trajectory_new_bodies(table *t, const sd_model *model, bool walls, bool shared);
/* Adds one frame, a row of the table. */
sd_status trajectory_sample_bodies(table *t, const moment *now, bool walls, bool shared,
                                   sd_messages *messages);

/* Add the columns, and one row, of a table of clumps (clump_observables). */
void trajectory_new_clumps(table *t, const sd_model *model);
sd_status trajectory_sample_clumps(table *t, const moment *now, sd_messages *messages);

/* Adds the columns of the index and of the table of contacts. */
void trajectory_new_contacts(table *index, table *rows, bool shared);
/* Adds one row to the index and, unless the table is shared, a row per contact. count: number of
 * contacts at this moment. */
sd_status trajectory_sample_contacts(table *index, table *rows, const moment *now, size_t count,
                                     sd_messages *messages);

/* trajectory_add_bodies adds the columns of bodies in a group: each row has n bodies, or one (n =
 * 0). trajectory_put_bodies fills them for n bodies, beginning with column `column`, and returns
 * the number of the next column. slots: slots of the bodies; NULL: all bodies in the order of their
 * numbers. */
void trajectory_add_bodies(table *t, const sd_model *model, const char *group, bool walls,
                           size_t n);
size_t trajectory_put_bodies(table *t, size_t column, const moment *now, bool walls, size_t n,
                             const uint32_t *slots);
/* trajectory_add_contacts adds the columns of contacts, one contact per row;
 * trajectory_put_contacts fills them for n contacts, beginning with column `column`. which: indices
 * of the contacts in the state; NULL: 0 ... n - 1. */
void trajectory_add_contacts(table *rows, const char *group);
void trajectory_put_contacts(table *rows, size_t column, const moment *now, size_t n,
                             const uint32_t *which);

/* Computes the lengths of the periodic box along x and y, at `scale` times those of the deck; 0 in
 * open directions. */
void trajectory_edges(const sd_model *model, double scale, double edges[2]);

/* --- Time series: the columns of energy_observables and series_observables -------------------- */

/* Adds the columns of the series that a run of this model has. */
void series_new(table *t, const sd_model *model);
/* Adds one row to the series. */
sd_status series_sample(table *t, const moment *now, sd_messages *messages);
/* Writes lists of the disks, walls and groups to which the elements of per-body columns belong. */
void series_write_columns(h5_file *file, const sd_model *model);

#endif
