/* keys.h: groups of a deck whose keys set members of the model. See key.h. */
#ifndef SLIPDISK_MODEL_KEYS_H
#define SLIPDISK_MODEL_KEYS_H

#include "model/key.h"

extern const deck_table deck_top, deck_gravity, deck_box, deck_bounds, deck_limits, deck_phases, deck_settle,
    deck_compress, deck_cell, deck_output, deck_measure, deck_sliding, deck_until;

#endif
