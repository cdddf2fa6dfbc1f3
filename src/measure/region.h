/* region.h: the part of the plane over which a configuration is measured, and areas within it.
 *
 * A region is a rectangle or the round inside of a drum. Areas of disks in it are exact: straight
 * edges divide a circle into triangles and sectors, a round edge cuts a lens out of it. */
#ifndef MEASURE_REGION_H
#define MEASURE_REGION_H

#include <stdbool.h>
#include <stddef.h>

typedef struct region {
  double lower[2], upper[2];
  bool whole[2]; /* [c] true if the region spans the periodic direction c: it has no edges there */
  /* [c] period of a periodic direction that the region does not span, so that the region has
   * images; else 0 */
  double image[2];
  /* true for a drum with this centre and radius; lower and upper are then its bounding box */
  bool round;
  double centre[2], radius;
} region;

double region_area(const region *g);
/* Returns true if the point, or a periodic image of it, lies in the region or on its edge. */
bool region_holds(const region *g, double x, double y);
/* Returns the area inside the region of a disk and its periodic images. */
double region_disk(const region *g, double x, double y, double radius);
/* Returns the fraction, 0 to 1, of the line from (x, y) to (x + dx, y + dy) inside the region. For
 * a round region it is 1 or 0, depending on the middle of the line. */
double region_line(const region *g, double x, double y, double dx, double dy);

/* Returns the area that a circle of this radius about the origin shares with a polygon of n corners
 * in counter-clockwise order; negative for clockwise order. */
double region_circle_polygon(double radius, size_t n, const double (*corner)[2]);

#endif
