/* window_check.h: comparison of a window with the same steps taken one by one, in checking builds
 * (VALIDITY_CHECKED). */
#ifndef PHYSICS_WINDOW_CHECK_H
#define PHYSICS_WINDOW_CHECK_H

#include "physics/system/work.h"

/* Copy of all that steps change: columns of the state, contact records, prescribed coordinates. */
typedef struct step_image step_image;

step_image *step_image_new(engine *e);
void step_image_free(step_image *image);
/* Compares the copy, made after a window, with the engine after single steps from step `from` on.
 * If any byte differs, names the column and body or contact, and returns SD_ERROR_NUMERIC. */
sd_status step_image_compare(const step_image *image, engine *e, int64_t from,
                             sd_messages *messages);

#endif
