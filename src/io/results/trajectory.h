/* trajectory.h: frames of all bodies, and tables of all closed contacts.
 *
 * Disks and walls stand in the order of the deck (body number), whatever their slots in the state.
 * Contacts of one moment are rows of one long table; the index says which: rows first ... first + count - 1.
 * `first` is known only when the parts are put together (merge.c).
 */
#ifndef SLIPDISK_IO_TRAJECTORY_H
#define SLIPDISK_IO_TRAJECTORY_H

#include "io/store/table.h"

/* With no disks (no walls) the table has no columns and no rows. The edges of the box are a column when some
 * phase compresses, else a constant; so is the scale of the region, and whether disks take part where they may wait or
 * leave. */
sd_status trajectory_new_bodies(table *t, const sd_model *model, bool walls, sd_messages *messages);
sd_status trajectory_sample_bodies(table *t, const sd_model *model, const sd_state *state, bool walls,
                                   const uint32_t *slots, sd_messages *messages);

sd_status trajectory_new_contacts(table *index, table *rows, sd_messages *messages);
sd_status trajectory_sample_contacts(table *index, table *rows, const sd_model *model, const sd_state *state,
                                     sd_messages *messages);

/* What does not change: box, radius, mass, species, id, names, shapes of walls, laws (constants.h). */
void trajectory_write_constants(h5_file *file, const sd_model *model);

#endif
