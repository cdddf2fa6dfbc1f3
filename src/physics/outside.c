/* outside.c: see outside.h. */
#include "physics/outside.h"

sd_status outside_look(engine *e, sd_messages *messages) {
  (void)e, (void)messages;
  return SD_OK;
}
