/* constants.h: what a frame does not say and measuring needs: sizes, masses, walls, contact laws, box, region. It
 * stands in every finished result (/particles and /parameters/model), so that nothing outside the file is needed. */
#ifndef SLIPDISK_IO_CONSTANTS_H
#define SLIPDISK_IO_CONSTANTS_H

#include "io/store/h5.h"

void constants_write(h5_file *file, const sd_model *model);
/* A model, not finished, with one material per row of the laws: from a result, or, where /parameters/model is not
 * there (a checkpoint, an old result), from the deck that is stored in the file. SD_ERROR_USER: the deck cannot be
 * read again, for example since it names files that are gone. */
sd_status constants_read(const h5_file *file, const char *path, sd_model **out, sd_messages *messages);

#endif
