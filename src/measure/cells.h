/* cells.h: radical (power, Laguerre) cells of disks. The cell of a disk is the set of points whose
 * power distance |x - c|^2 - R^2 to this disk is the smallest. For equal radii these are Voronoi
 * cells; cells of disks that do not overlap contain their disks.
 *
 * A cell starts as a large rectangle and is cut by the radical lines with near disks. Then the
 * nearest site to each of its corners is searched, and the radical line with this site cuts, until
 * the disk itself is nearest to all corners: no other site can cut then. Straight walls and the
 * region cut last. Areas are exact to rounding. Along periodic directions images are added, as many
 * as the cells turn out to need.
 *
 * A cell is closed if its edges are neighbours and walls, and no corner is farther from the disk's
 * edge than CELLS_VOID largest radii (no such limit applies in a box periodic in x and y).
 * Otherwise it is open: it lies at a free surface, at a hole larger than a missing disk, or at an
 * edge of the region without a wall. */
#ifndef MEASURE_CELLS_H
#define MEASURE_CELLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "measure/configuration.h"
#include "slipdisk/status.h"

/* Largest distance from the edge of a disk to a corner of its cell at which the cell still counts
 * as closed, in units of the largest radius. At a vacancy of a triangular lattice the distance is
 * 1. */
#define CELLS_VOID 1.5

typedef struct cells {
  size_t n; /* number of disks of the configuration */
  /* [n] area of each cell within the region; NAN for a disk outside the region or without a cell */
  double *area;
  bool *closed;
  size_t n_closed, n_open;
  double total; /* total area of all cells, open ones included */
  /* packing fraction in the bulk: area of the disks with closed cells divided by the area of these
   * cells; NAN if no cell is closed */
  double inside;
  /* mean, standard deviation, minimum and maximum of the local packing fraction pi R^2/(area of the
   * cell) of disks with closed cells; NAN if no cell is closed */
  double mean, deviation, least, most;
} cells;

/* Computes the cells of all disks, cut at the edges of `whole`, the region of the run. The
 * statistics include the free disks with their centre in `counted`. Call cells_free also when it
 * fails. SD_ERROR_IO: out of memory. */
sd_status cells_new(cells *t, const configuration *c, const region *whole, const region *counted,
                    sd_messages *messages);
void cells_free(cells *t);
/* Returns the local packing fraction pi R^2/(area of the cell) of disk i, NAN if its cell is
 * open. */
double cells_fraction(const cells *t, const configuration *c, size_t i);

#endif
