/* loads.h: checks of the walls that the disks move (motions of kind load and servo). */
#ifndef MODEL_LOADS_H
#define MODEL_LOADS_H

#include "model/model.h"

/* Ranges, what a motion may drive, and that it is alone there. Warns of a wall that is pushed away from all disks. */
void loads_check(const sd_model *model, sd_messages *messages);
/* Warns when the time step is long for a load on as many disks as fit beside one another; laws and n_free are known. */
void loads_check_steps(const sd_model *model, sd_messages *messages);

#endif
