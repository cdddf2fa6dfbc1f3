/* measure/sites.h: circles in the plane, and which of them is nearest to a point by power distance |x - c|^2 - R^2.
 *
 * They lie in grids, one for each octave of radii: around the point, ring by ring of cells, until no circle of the octave can be
 * nearer. */
#ifndef MEASURE_SITES_H
#define MEASURE_SITES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

enum { SITES_OCTAVES = 10 };

typedef struct sites_grid {
  double largest; /* radius */
  double lower[2], width;
  size_t cells[2];
  size_t *start; /* [cells + 1] into site; NULL: there are none of this octave */
  uint32_t *site;
} sites_grid;

typedef struct sites {
  size_t n, n_disks, capacity; /* disks come first, then their images */
  double (*at)[2];
  double *radius;
  unsigned char *octave_of; /* [n] set by sites_sort */
  bool one_octave;          /* all are of the same */
  double centre[2], size;   /* of what the sites cover */
  sites_grid octave[SITES_OCTAVES];
} sites;

/* SD_ERROR_IO: there is no memory. */
sd_status sites_add(sites *s, double x, double y, double radius);
/* When all are there. SD_ERROR_IO: there is no memory. */
sd_status sites_sort(sites *s);
void sites_free(sites *s);

/* The site other than `own` with the least power distance from `at` below `most`; SIZE_MAX: none has. */
size_t sites_nearest(const sites *s, size_t own, const double at[2], double most);
/* A rectangle of cells. */
typedef struct sites_block {
  double lower[2], upper[2];
  bool complete; /* all sites with their centres in it were found */
} sites_block;

/* The sites in the cells around site i, of its own octave, without i; returns how many, at most `room`. */
size_t sites_around(const sites *s, size_t i, uint32_t *found, size_t room, sites_block *block);

#endif
