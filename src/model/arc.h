/* arc.h: walls that are circular arcs: their segments, the points that trace them, and
 * distances. */
#ifndef SLIPDISK_MODEL_ARC_H
#define SLIPDISK_MODEL_ARC_H

#include "model/model.h"

/* Number of points that trace an arc, evenly spaced from end to end; and the largest angle of an
 * arc, 2 pi plus a margin for rounding. */
enum { ARC_POINTS = 129 };
#define ARC_RING 6.283185307179588

/* True if the arc is a full circle, which has no ends. */
bool arc_is_ring(const sd_wall *arc);
/* Fills the ARC_POINTS points that trace the arc. */
void arc_trace(sd_wall *arc);
/* Makes the three segments of an arc, whose numbers in the model start at `number`: end, curve,
 * end, or three thirds of a full circle. */
void arc_pieces(const sd_wall *arc, uint32_t body, sd_segment piece[3], int64_t number);
/* Distance from the point `at` to the arc, >= 0. */
double arc_distance(const sd_wall *arc, const double at[2]);

#endif
