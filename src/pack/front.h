/* front.h: advancing front: dense packings without overlap, built from below.
 *
 * Pockets are places where a disk would touch two bodies: disks, walls, or edges of the region. The lowest
 * pocket is taken first, by the next disk that fits into it; a new disk makes new pockets with all its
 * neighbours (after Y. T. Feng, K. Han, D. R. J. Owen, Int. J. Numer. Meth. Eng. 56, 699 (2003)). A heap of pockets
 * and the grid of the space make this O(N log N).
 */
#ifndef PACK_FRONT_H
#define PACK_FRONT_H

#include "pack/place.h"

/* Places disks of these radii until the region is full; how many is *placed. radius[] is put into the order in
 * which they were placed: a pocket is offered to the next few. SD_ERROR_IO: out of memory. */
sd_status front_fill(place_space *s, size_t n, double *radius, double (*position)[2],
                     size_t *placed);

#endif
