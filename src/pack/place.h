/* place.h: finds free positions for disks, at random or on a lattice.
 *
 * A place_space is a rectangle that is to be filled with new disks. It knows the obstacles: the
 * disks of the model that do not wait for release, the walls, and the images of both in a periodic
 * box. Each disk is listed in every grid cell that its bounding box overlaps, so radii may differ
 * by any factor. */
#ifndef PACK_PLACE_H
#define PACK_PLACE_H

#include "base/gsl.h"
#include "model/containers.h"
#include "model/model.h"

/* Relative tolerance of contact: a disk overlaps another only if their distance is less than (1 -
 * PLACE_SLACK) times the sum of the radii. Disks placed in contact may overlap by rounding
 * errors. */
#define PLACE_SLACK 1e-10

typedef struct place_space {
  const sd_model *model;
  const container *inside; /* centres stay inside */
  double lower[2], upper[2];
  /* edge[c]: true if the rectangle ends at lower[c] and upper[c]: disks stay between these edges,
   * and the grid, which spans the rectangle, also holds periodic images. False if the rectangle
   * spans the whole period along c: positions and grid cells wrap. */
  bool edge[2];
  double period[2]; /* lengths of the periodic box along x and y, 0: not periodic */
  /* n: number of disks, first the model's, then the added ones; capacity: allocated rows */
  size_t n, capacity;
  double (*disk)[3]; /* [capacity] x, y and radius of each disk */
  double corner[2], cell[2];
  int64_t cells[2];
  int64_t *head;    /* [number of cells] first list node of each cell, -1: the cell is empty */
  int64_t *next;    /* [nodes] next node in the list of the same cell, -1: last */
  uint32_t *holder; /* [nodes] index of the disk that the node stands for */
  size_t n_nodes, node_capacity;
  /* stamp: [capacity] number of the last search that found each disk; stamps: number of searches so
   * far */
  uint32_t *stamp, stamps;
  uint32_t *near; /* [capacity] disks found by the last place_near */
} place_space;

/* Initialises a space with the first n_there disks of the model as obstacles and a grid for about
 * `expected` new disks. Call place_end also when it fails. SD_ERROR_IO: out of memory. */
sd_status place_begin(place_space *s, const sd_model *m, size_t n_there, const container *inside,
                      const double lower[2], const double upper[2], size_t expected);
void place_end(place_space *s);

/* Wraps coordinate c (0: x, 1: y) into the periodic box; returns it unchanged along an open
 * direction. */
double periodic_wrap(const place_space *s, double x, int c);
/* Returns the difference a - b of two values of coordinate c, reduced to the nearest periodic
 * image. */
double periodic_difference(const place_space *s, double a, double b, int c);
/* Returns true if a disk at (x, y) lies inside the rectangle, has its centre in the container and
 * overlaps no disk or wall. */
bool place_fits(const place_space *s, double x, double y, double radius);
sd_status place_add(place_space *s, double x, double y, double radius);
/* Stores in s->near the disks whose surfaces are nearer to the point than reach and returns their
 * number. The list is valid until the next place_near or place_add. */
size_t place_near(place_space *s, double x, double y, double reach);

/* Places disks by random sequential addition, the largest first: for each disk, random points,
 * uniform in the rectangle, are tried until the disk fits at one (B. Widom, J. Chem. Phys. 44, 3888
 * (1966)). The number of tries for all disks together is limited and grows as n. position[k]
 * belongs to radius[k] and is NAN for disks that found no place within this limit; *placed is the
 * number of disks placed. SD_ERROR_IO: out of memory. */
sd_status place_random(place_space *s, gsl_rng *rng, size_t n, const double *radius,
                       double (*position)[2], size_t *placed);

/* Computes positions for n disks that wait for their release, on a rectangular grid between `lower`
 * and `upper` in x. Rows go upwards from y, `spacing` apart; columns are at least `spacing` apart.
 * position[0] is point number `first` of the grid. */
void place_waiting(double lower, double upper, double y, double spacing, size_t first, size_t n,
                   double (*position)[2]);

typedef enum sd_packing_kind {
  SD_PACKING_TRIANGULAR,
  SD_PACKING_SQUARE,
  SD_PACKING_RANDOM,
  SD_PACKING_FRONT,
  SD_PACKING_RAIN
} sd_packing_kind;

/* Disks on a triangular or a square lattice, with random displacements (jitter).
 *
 * Every site owns a circle of diameter `spacing`, which lies inside the space and overlaps no
 * obstacle; a displaced disk stays within its circle. Rows go up from the lower edge, centred in x.
 * Along a periodic direction the spacing is stretched so that a whole number of sites (an even
 * number of triangular rows) fits. */

/* Stores the positions of the lowest free sites of a lattice, at most `most` of them, and returns
 * their number. kind: SD_PACKING_TRIANGULAR or SD_PACKING_SQUARE. */
size_t lattice_sites(const place_space *s, sd_packing_kind kind, double spacing, size_t most,
                     double (*site)[2]);
/* Moves each site k to a random point, uniform in the circle of radius jitter * (spacing/2 -
 * radius[k]) about it; jitter is in [0, 1]. */
void lattice_jitter(const place_space *s, gsl_rng *rng, double spacing, double jitter, size_t n,
                    const double *radius, double (*site)[2]);

/* Advancing front: dense packings without overlap, built from below.
 *
 * A pocket is a position at which a new disk touches two bodies: disks, walls, or edges of the
 * region. The lowest pocket is filled first, with the next disk that fits; each new disk forms new
 * pockets with all its neighbours (after Y. T. Feng, K. Han, D. R. J. Owen, Int. J. Numer. Meth.
 * Eng. 56, 699 (2003)). A heap of pockets and the cell grid of the space make this O(N log N). */

/* Places disks of these n radii until the region is full; *placed is the number of disks placed.
 * Several disks are tried in each pocket, so radius[] is reordered: radius[k] belongs to
 * position[k] for k < *placed. SD_ERROR_IO: out of memory. */
sd_status front_fill(place_space *s, size_t n, double *radius, double (*position)[2],
                     size_t *placed);

#endif
