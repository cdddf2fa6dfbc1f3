/* rain.c: see rain.h. */
#include "pack/rain.h"

int64_t rain_next(const engine *e, int64_t step) {
  (void)e, (void)step;
  return INT64_MAX;
}
sd_status rain_release(engine *e, sd_messages *messages) {
  (void)e, (void)messages;
  return SD_OK;
}
bool rain_waits(const engine *e) { return e->state->released < 0; }
