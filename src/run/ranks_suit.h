/* ranks_suit.h: which runs several ranks can share. */
#ifndef SLIPDISK_RUN_RANKS_SUIT_H
#define SLIPDISK_RUN_RANKS_SUIT_H

#include "model/model.h"

/* SD_ERROR_USER, with a message for each reason: this run is for one process. */
sd_status ranks_suit(const sd_model *model, sd_messages *messages);

#endif
