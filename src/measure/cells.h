/* cells.h: radical (power, Laguerre) cells of disks: the points whose power distance |x - c|^2 - R^2 to this disk is the
 * least. For equal radii these are Voronoi cells; cells of disks that do not overlap contain their disks.
 *
 * A cell is cut out of the plane by the radical lines of near disks; then each of its corners is asked which site is nearest to
 * it, and the radical line of that one cuts, until no site is nearer to any corner than the disk itself: then no other can cut.
 * Straight walls and the region cut last. Areas are exact to rounding. Along periodic directions images are added, as many as the
 * cells turn out to need.
 *
 * A cell is closed when neighbours and walls bound it, and no corner of it is farther from the disk's edge than
 * CELLS_VOID largest radii (in a box that is periodic in x and y there is no such limit). Otherwise it is open: it lies at
 * a free surface, at a hole larger than a missing disk, or at an edge of the region where there is no wall.
 */
#ifndef MEASURE_CELLS_H
#define MEASURE_CELLS_H

#include "measure/configuration.h"

/* A missing disk of a triangular lattice leaves 1. */
#define CELLS_VOID 1.5

typedef struct cells {
  size_t n;     /* disks of the configuration */
  double *area; /* within the region; NAN: of a disk beyond it or without a cell */
  bool *closed;
  size_t n_closed, n_open;
  double total; /* area of all cells */
  double
      inside; /* area of the disks with closed cells over that of their cells: packing fraction in the bulk; NAN */
  double mean, deviation, least, most; /* local packing fraction pi R^2 / area of closed cells */
} cells;

/* Statistics are over free disks whose centre lies in `counted`; cells are cut by `whole`, the region of the run.
 * cells_free also when it fails. */
sd_status cells_new(cells *t, const configuration *c, const region *whole, const region *counted,
                    sd_messages *messages);
void cells_free(cells *t);
/* Local packing fraction of disk i, NAN when its cell is open. */
double cells_fraction(const cells *t, const configuration *c, size_t i);

#endif
