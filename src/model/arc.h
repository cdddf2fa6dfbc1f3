/* arc.h: walls that are part of a circle: their pieces, their picture, and how far a point is from them. */
#ifndef SLIPDISK_MODEL_ARC_H
#define SLIPDISK_MODEL_ARC_H

#include "model/model.h"

/* Points of the picture, evenly spaced from end to end; a whole turn, with room for its rounding. */
enum { ARC_POINTS = 129 };
#define ARC_RING 6.283185307179588

/* Is it a ring, without ends? */
bool arc_is_ring(const sd_wall *arc);
/* Fills the ARC_POINTS points. */
void arc_trace(sd_wall *arc);
/* Its three pieces, numbered from `number` on. */
void arc_pieces(const sd_wall *arc, uint32_t body, sd_segment piece[3], int64_t number);
double arc_distance(const sd_wall *arc, const double at[2]);

#endif
