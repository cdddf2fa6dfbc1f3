/* finish.h: the end of making a model: checks and derived tables, after which it is const. */
#ifndef SLIPDISK_MODEL_FINISH_H
#define SLIPDISK_MODEL_FINISH_H

#include "model/model.h"

/* sd_model_finish of a model whose warnings were told before: errors alone. */
sd_status model_finish_again(sd_model *model, sd_messages *messages);

/* Collective, of a finished model: each rank keeps the rows that all must know and its own part
 * (rows_part), and what is asked of all disks later: warnings, the limit of the time step.
 * SD_ERROR_IO: no memory. */
sd_status model_part(sd_model *m, size_t few);

/* Motions of kind load and servo: ranges, what they may drive, and that each is alone there. Warns
 * of a wall that is pushed away from all disks. */
void loads_check(const sd_model *model, sd_messages *messages);
/* Warns when the time step is long for a load on as many disks as fit beside one another; laws and
 * n_free are known. */
void loads_check_steps(const sd_model *model, sd_messages *messages);

#endif
