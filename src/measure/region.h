/* region.h: the part of the plane over which a configuration is measured, and areas within it.
 *
 * A region is a rectangle, or the round inside of a drum. Areas of disks in it are exact: a circle is cut along
 * straight edges by segments (triangles and sectors), along a round edge by a lens.
 */
#ifndef MEASURE_REGION_H
#define MEASURE_REGION_H

#include <stdbool.h>
#include <stddef.h>

typedef struct region {
  double lower[2], upper[2];
  bool whole[2];   /* it spans a periodic direction: nothing is cut there */
  double image[2]; /* period of a direction that it does not span, else 0: the region has images */
  bool round;      /* a drum of this centre and radius; lower and upper are its bounding box */
  double centre[2], radius;
} region;

double region_area(const region *g);
bool region_holds(const region *g, double x, double y); /* edges belong to it */
/* Area of a disk, or of its periodic images, inside. */
double region_disk(const region *g, double x, double y, double radius);
/* Part of the line from (x, y) to (x + dx, y + dy) inside, 0 to 1; of a round region 1 or 0, by its middle. */
double region_line(const region *g, double x, double y, double dx, double dy);

/* Area that a circle of this radius about the origin shares with a polygon whose n corners go round
 * counter-clockwise; negative for clockwise ones. */
double region_circle_polygon(double radius, size_t n, const double (*corner)[2]);

#endif
