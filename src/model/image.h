/* image.h: a model as bytes, from which the same program makes it again: for clones and saved simulations. */
#ifndef MODEL_IMAGE_H
#define MODEL_IMAGE_H

#include "model/model.h"

/* *size bytes, with zeros behind them up to a whole word of 32 bits; to be freed; NULL: no memory.
 * Equal models have equal bytes. */
void *image_of_model(const sd_model *model, size_t *size);
/* The model, finished where that was. SD_ERROR_USER: another version's; SD_ERROR_IO: damaged, no memory. */
sd_status image_read(const void *bytes, size_t size, sd_model **out, sd_messages *messages);

#endif
