/* constants_laws.h: the laws of contacts in a finished result (/parameters/model). */
#ifndef SLIPDISK_IO_CONSTANTS_LAWS_H
#define SLIPDISK_IO_CONSTANTS_LAWS_H

#include "io/store/h5.h"
#include "model/model.h"

void constants_laws_write(h5_file *file, const sd_model *model);
/* Materials without names, and their laws. SD_ERROR_IO: not there, damaged, no memory. */
sd_status constants_laws_read(const h5_file *file, sd_model *model, sd_messages *messages);
/* The laws, the integrator and dt (0: not known) alone; NULL: not there, damaged, no memory. */
sd_model *constants_laws_model(const h5_file *file);

#endif
