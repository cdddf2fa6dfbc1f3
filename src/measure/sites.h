/* measure/sites.h: circles in the plane (sites), and the search for the one nearest to a point by
 * power distance |x - c|^2 - R^2.
 *
 * Sites are sorted into grids, one for each octave of radii. A search goes outwards from the point,
 * ring by ring of cells, until no site of the octave can be nearer. */
#ifndef MEASURE_SITES_H
#define MEASURE_SITES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

enum { SITES_OCTAVES = 10 };

typedef struct sites_grid {
  double largest; /* largest radius in the grid */
  double lower[2], width;
  size_t cells[2];
  /* [cells + 1] first element of each cell in `site`; NULL: the octave is empty */
  size_t *start;
  uint32_t *site;
} sites_grid;

typedef struct sites {
  /* number of sites, disks first, then their images; number of disks; allocated rows */
  size_t n, n_disks, capacity;
  double (*at)[2];
  double *radius;
  unsigned char *octave_of; /* [n] octave of the radius, set by sites_sort */
  bool one_octave;          /* true if all sites have the same octave */
  double centre[2], size;   /* centre and size of the square around all sites */
  sites_grid octave[SITES_OCTAVES];
} sites;

/* Adds a site. SD_ERROR_IO: out of memory. */
sd_status sites_add(sites *s, double x, double y, double radius);
/* Builds the grids when all sites have been added. SD_ERROR_IO: out of memory. */
sd_status sites_sort(sites *s);
void sites_free(sites *s);

/* Returns the site other than `own` whose power distance from `at` is the smallest and below
 * `most`; SIZE_MAX: none. */
size_t sites_nearest(const sites *s, size_t own, const double at[2], double most);
/* Rectangle of grid cells. */
typedef struct sites_block {
  double lower[2], upper[2];
  bool complete; /* true if all sites with centres in the rectangle were found */
} sites_block;

/* Finds the sites of the same octave in the 3 x 3 cells around site i, without i itself. Returns
 * their number, at most `room`; *block is the rectangle that was searched. */
size_t sites_around(const sites *s, size_t i, uint32_t *found, size_t room, sites_block *block);

#endif
