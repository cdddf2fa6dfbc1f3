/* lattice.h: disks on a triangular or a square lattice, with jitter.
 *
 * Every site has a circle of diameter `spacing` for itself: it lies inside the space and clear of what is there,
 * and a disk that is displaced stays in it. Rows go up from the lower edge, in the middle of the region. In a
 * periodic direction the spacing is stretched so that a whole number (of triangular rows: an even one) fits.
 */
#ifndef PACK_LATTICE_H
#define PACK_LATTICE_H

#include <gsl/gsl_rng.h>

#include "pack/place.h"

/* The lowest free sites, `most` of them if there are as many; returns how many. kind: SD_PACKING_TRIANGULAR, SD_PACKING_SQUARE. */
size_t lattice_sites(const place_space *s, sd_packing_kind kind, double spacing, size_t most,
                     double (*site)[2]);
/* Moves each to a point drawn evenly from the disk of radius jitter (spacing/2 - radius[k]) about it; jitter <= 1. */
void lattice_jitter(const place_space *s, gsl_rng *rng, double spacing, double jitter, size_t n,
                    const double *radius, double (*site)[2]);

#endif
