/* place.h: where disks can be placed, at random or on a lattice.
 *
 * A space is a rectangle in which new disks shall lie, with all that is there already: the disks of the model that
 * do not wait, its walls, the images of both in a periodic box. Disks are listed in every cell of a grid that
 * they reach into, so that sizes may differ as they like.
 */
#ifndef PACK_PLACE_H
#define PACK_PLACE_H

#include "base/gsl.h"
#include "model/model.h"

/* Touching disks overlap by rounding only; nearer than this fraction of their radii counts as an overlap. */
#define PLACE_SLACK 1e-10

/* The inside of a hopper or a drum, symmetric about x; every other container is a rectangle. */
typedef struct place_interior {
  sd_container_kind kind;
  double x, y;              /* middle of the outlet; centre of the drum */
  double radius;            /* drum */
  double bottom, top, rise; /* hopper: half the width at y, and at y + rise and above */
} place_interior;

/* Half the width at height y: infinite where the container is a rectangle, < 0 outside. */
double place_half_width(const place_interior *inside, double y);
/* Area of the part of a rectangle that lies inside. */
double place_area(const place_interior *inside, const double lower[2], const double upper[2]);

typedef struct place_space {
  const sd_model *model;
  place_interior interior;
  double lower[2], upper[2];
  /* disks lie between the edges of the rectangle, and so does the grid, which holds images; false: both go round the box */
  bool edge[2];
  double period[2];   /* of the box; 0: open */
  size_t n, capacity; /* disks: of the model, then those that were added */
  double (*disk)[3];  /* x, y, radius */
  double corner[2], cell[2];
  int64_t cells[2];
  int64_t *head;    /* [cells]: first node of a cell, -1: none */
  int64_t *next;    /* [nodes] */
  uint32_t *holder; /* [nodes]: the disk */
  size_t n_nodes, node_capacity;
  uint32_t *stamp, stamps; /* [capacity]: the search that has met the disk last; searches so far */
  uint32_t *near;          /* [capacity]: what it has found */
} place_space;

/* A space for about `expected` new disks beside the first n_there of the model; to be ended in any case. SD_ERROR_IO: out of
 * memory. */
sd_status place_begin(place_space *s, const sd_model *m, size_t n_there,
                      const place_interior *inside, const double lower[2], const double upper[2],
                      size_t expected);
void place_end(place_space *s);

/* Puts a coordinate back into the periodic box. */
double place_wrapped(const place_space *s, double x, int c);
/* From b to a along c, the nearest image. */
double place_apart(const place_space *s, double a, double b, int c);
/* A disk here lies inside and overlaps nothing. */
bool place_fits(const place_space *s, double x, double y, double radius);
sd_status place_add(place_space *s, double x, double y, double radius);
/* The disks whose surfaces are nearer to a point than reach, in s->near until something is added; how many. */
size_t place_near(place_space *s, double x, double y, double reach);

/* Random sequential addition, the largest disks first: each goes to a point drawn evenly from the rectangle, and
 * again until it fits (B. Widom, J. Chem. Phys. 44, 3888 (1966)). position[k] is that of radius[k], NAN
 * for those that found no place within a number of tries that grows as n; how many did is *placed. */
sd_status place_random(place_space *s, gsl_rng *rng, size_t n, const double *radius,
                       double (*position)[2], size_t *placed);

/* Where n disks wait: rows from `lower` to `upper` in x, upwards from y, `spacing` or more apart. */
void place_waiting(double lower, double upper, double y, double spacing, size_t first, size_t n,
                   double (*position)[2]);

/* Disks on a triangular or a square lattice, with jitter.
 *
 * Every site has a circle of diameter `spacing` for itself: it lies inside the space and clear of what is there,
 * and a disk that is displaced stays in it. Rows go up from the lower edge, in the middle of the region. In a
 * periodic direction the spacing is stretched so that a whole number (of triangular rows: an even one) fits.
 */

/* The lowest free sites, `most` of them if there are as many; returns how many. kind: SD_PACKING_TRIANGULAR, SD_PACKING_SQUARE. */
size_t lattice_sites(const place_space *s, sd_packing_kind kind, double spacing, size_t most,
                     double (*site)[2]);
/* Moves each to a point drawn evenly from the disk of radius jitter (spacing/2 - radius[k]) about it; jitter <= 1. */
void lattice_jitter(const place_space *s, gsl_rng *rng, double spacing, double jitter, size_t n,
                    const double *radius, double (*site)[2]);

#endif
