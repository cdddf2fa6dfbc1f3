/* front.h: advancing front: dense packings without overlap, built from below.
 *
 * A pocket is a position at which a new disk touches two bodies: disks, walls, or edges of the
 * region. The lowest pocket is filled first, with the next disk that fits; each new disk forms new
 * pockets with all its neighbours (after Y. T. Feng, K. Han, D. R. J. Owen, Int. J. Numer. Meth.
 * Eng. 56, 699 (2003)). A heap of pockets and the cell grid of the space make this O(N log N). */
#ifndef PACK_FRONT_H
#define PACK_FRONT_H

#include "pack/place.h"

/* Places disks of these n radii until the region is full; *placed is their number. Each pocket is
 * offered to several of the next disks, so radius[] is reordered: radius[k] belongs to position[k]
 * for k < *placed. SD_ERROR_IO: out of memory. */
sd_status front_fill(place_space *s, size_t n, double *radius, double (*position)[2],
                     size_t *placed);

#endif
