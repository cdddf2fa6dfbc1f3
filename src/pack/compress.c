/* compress.c: see compress.h. */
#include "pack/compress.h"

sd_status compress_step(engine *e, sd_messages *messages) {
  (void)e, (void)messages;
  return SD_OK;
}
bool compress_done(const engine *e) { return e->state->box_scale < 0.0; }
double compress_pressure(const engine *e) { return e->state->box_scale * 0.0; }
double compress_fraction(const engine *e) { return e->state->box_scale * 0.0; }
