/* slipdisk.h: includes all public headers. docs/library.md is the introduction to the library. */
#ifndef SLIPDISK_SLIPDISK_H
#define SLIPDISK_SLIPDISK_H

#include "slipdisk/deck.h"
#include "slipdisk/measure.h"
#include "slipdisk/measurement.h"
#include "slipdisk/model.h"
#include "slipdisk/simulation.h"
#include "slipdisk/state.h"
#include "slipdisk/status.h"
#include "slipdisk/theory.h"
#include "slipdisk/version.h"

#endif
