/* model_share.h: the model of a run over several ranks, from the first of them to the others. */
#ifndef SLIPDISK_RUN_MODEL_SHARE_H
#define SLIPDISK_RUN_MODEL_SHARE_H

#include "base/comm.h"
#include "model/model.h"

/* Every rank calls it. Rank 0 has a finished model; each other rank gets what it has to know of it (image_for_ranks), to be
 * freed. Without memory the job ends (comm_fail); SD_ERROR_IO: told in messages. */
sd_status model_share(const comm *c, const sd_model *model, sd_model **out, sd_messages *messages);

#endif
