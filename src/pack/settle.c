/* settle.c: see settle.h. */
#include "pack/settle.h"

settle_measure settle_look(const engine *e) { return (settle_measure){e->state->relaxed, 0.0}; }
bool settle_reached(const engine *e) { return e->state->released < 0; }
