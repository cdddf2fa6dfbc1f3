/* trajectory.h: frames of all bodies, and tables of all closed contacts: the rows of frame_observables and
 * contact_observables.
 *
 * Disks and walls stand in the order of the deck (body number), whatever their slots in the state.
 * Contacts of one moment are rows of one long table; the index says which: rows first ... first + count - 1.
 * `first` is known only when the parts are put together (merge.c).
 *
 * shared: what is of disks and of contacts stands in shares of the ranks (record.h), and is left out.
 */
#ifndef SLIPDISK_IO_TRAJECTORY_H
#define SLIPDISK_IO_TRAJECTORY_H

#include "io/store/table.h"
#include "measure/observable.h"

/* With no disks (no walls) the table has no columns and no rows. The edges of the box, and the scale of the region, are
 * columns when some phase compresses, else constants (constants.h). */
void trajectory_new_bodies(table *t, const sd_model *model, bool walls, bool shared);
sd_status trajectory_sample_bodies(table *t, const moment *now, bool walls, bool shared,
                                   sd_messages *messages);

/* The same of clumps: the rows of clump_observables. */
void trajectory_new_clumps(table *t, const sd_model *model);
sd_status trajectory_sample_clumps(table *t, const moment *now, sd_messages *messages);

void trajectory_new_contacts(table *index, table *rows, bool shared);
/* count: of the moment's contacts. */
sd_status trajectory_sample_contacts(table *index, table *rows, const moment *now, size_t count,
                                     sd_messages *messages);

/* Columns of bodies in a group, n of them in a row, or one (n = 0); and their values, from this
 * column on: bodies in these slots, NULL: by number. Returns the number of the next column. */
void trajectory_add_bodies(table *t, const sd_model *model, const char *group, bool walls,
                           size_t n);
size_t trajectory_put_bodies(table *t, size_t column, const moment *now, bool walls, size_t n,
                             const uint32_t *slots);
/* The same of contacts, one a row. which: of the state; NULL: all. */
void trajectory_add_contacts(table *rows, const char *group);
void trajectory_put_contacts(table *rows, size_t column, const moment *now, size_t n,
                             const uint32_t *which);

/* Lengths of the periodic box, 0 where it is open. */
void trajectory_edges(const sd_model *model, double scale, double edges[2]);

/* --- the time series: the rows of energy_observables and series_observables ------------------- */

void series_new(table *t, const sd_model *model);
/* One row. */
sd_status series_sample(table *t, const moment *now, sd_messages *messages);
/* Which disks, walls and groups the columns with a number for each are about. */
void series_write_columns(h5_file *file, const sd_model *model);

#endif
