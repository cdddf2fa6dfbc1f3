/* image.h: a model as bytes, from which the same program makes it again: for clones and saved simulations. */
#ifndef MODEL_IMAGE_H
#define MODEL_IMAGE_H

#include "model/model.h"

/* *size bytes, with zeros behind them up to a whole word of 32 bits; to be freed; NULL: no memory.
 * Equal models have equal bytes. */
void *image_of_model(const sd_model *model, size_t *size);
/* The model, finished where that was. SD_ERROR_USER: another version's; SD_ERROR_IO: damaged, no memory. */
sd_status image_read(const void *bytes, size_t size, sd_model **out, sd_messages *messages);

/* The part of a finished model that a rank needs whose disks come to it as rows of a state: of a disk only names, forces, locks and what
 * prescribes it; nothing of most disks, which take no memory there. Not the contacts with which the run begins. */
void *image_for_ranks(const sd_model *model, size_t *size);
sd_status image_read_for_rank(const void *bytes, size_t size, sd_model **out, sd_messages *messages);
/* Of this disk it has more than a row of the state says. */
bool image_is_special(const sd_disk *disk);

#endif
