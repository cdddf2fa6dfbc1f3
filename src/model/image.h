/* image.h: a model serialized to bytes, from which the same program restores it; used for clones
 * and saved simulations. */
#ifndef MODEL_IMAGE_H
#define MODEL_IMAGE_H

#include "model/model.h"

/* Returns the model as *size bytes, followed by a 32-bit zero; the caller frees them. NULL: out
 * of memory. Equal models give equal bytes. The model must not be distributed over ranks. */
void *image_of_model(const sd_model *model, size_t *size);
/* Restores a model in *out, finished if the original was; the caller frees it with
 * sd_model_free. SD_ERROR_USER: the bytes are those of another version; SD_ERROR_IO: damaged, or
 * out of memory; *out is then NULL. */
sd_status image_read(const void *bytes, size_t size, sd_model **out, sd_messages *messages);

#endif
