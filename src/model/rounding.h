/* rounding.h: coordinates so far from 0 that contacts of the smallest disk are lost in their rounding. */
#ifndef SLIPDISK_MODEL_ROUNDING_H
#define SLIPDISK_MODEL_ROUNDING_H

#include "model/model.h"

/* A mistake where a disk or wall is that far away at the start. */
void rounding_check(const sd_model *model, sd_messages *messages);

#endif
