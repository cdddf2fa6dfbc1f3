/* rains.h: the mistakes that rains may have. */
#ifndef MODEL_RAINS_H
#define MODEL_RAINS_H

#include "model/model.h"

/* Collective (rows.h). Every disk that waits belongs to one rain, and only these wait. */
void rains_check(const sd_model *model, sd_messages *messages);

#endif
