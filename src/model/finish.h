/* finish.h: checks of a complete model and its derived tables, after which the model is const. */
#ifndef SLIPDISK_MODEL_FINISH_H
#define SLIPDISK_MODEL_FINISH_H

#include "model/model.h"

/* Does what sd_model_finish does for a model whose warnings were reported before: reports errors
 * only. */
sd_status model_finish_again(sd_model *model, sd_messages *messages);

/* Collective. Distributes a finished model: each rank keeps the rows that all must know and its
 * own part (rows_part; below `few` free disks rank 0 has all), after the results that need all
 * disks, warnings and the limit of the time step, have been stored. SD_ERROR_IO: out of memory. */
sd_status model_part(sd_model *m, size_t few);

/* Checks motions of the kinds load and servo: their ranges, the bodies that they move, and that
 * no other motion moves the same coordinate. Warns of a wall that is pushed away from all disks. */
void loads_check(const sd_model *model, sd_messages *messages);
/* Warns if the time step is long for a load on as many disks as fit side by side along its wall.
 * The laws and n_free must be known. */
void loads_check_steps(const sd_model *model, sd_messages *messages);

#endif
