/* containers.h: kinds of containers, which are walls around the disks. One row per kind says where
 * its corners are, which walls join them, and in which directions it repeats. The deck's group
 * `container`, its walls, packings, bounds and the region of measurements follow from the row. */
#ifndef SLIPDISK_MODEL_CONTAINERS_H
#define SLIPDISK_MODEL_CONTAINERS_H

#include <stddef.h>

#include "slipdisk/model.h"

struct deck_table;

/* Numbers of the kinds; result files store them. */
typedef enum sd_container_kind {
  SD_CONTAINER_NONE,
  SD_CONTAINER_BOX,
  SD_CONTAINER_CHANNEL,
  SD_CONTAINER_BED,
  SD_CONTAINER_HOPPER,
  SD_CONTAINER_DRUM,
  SD_CONTAINER_PERIODIC,
  SD_CONTAINER_POLYGON
} sd_container_kind;

#define CONTAINER_CORNERS 64

/* A convex outline: a polygon of n corners in counter-clockwise order or, with n = 0 and a radius
 * above 0, a circle. */
typedef struct container_outline {
  size_t n;
  double corner[CONTAINER_CORNERS][2];
  double centre[2], radius;
} container_outline;

/* The values of the keys, and what follows from them. */
typedef struct container {
  sd_container_kind kind;
  double width, height, radius, outlet, angle, origin[2];
  int64_t sides;
  bool open;                 /* open above; disks may lie higher than its corners */
  container_outline outline; /* relative to the origin */
  const char *key;           /* key with a value that this kind cannot have; NULL: all are good */
  char expected[96];         /* message about that key */
} container;

/* A wall along the outline: from corner to corner, or the whole outline (n = 0). */
typedef struct container_wall {
  const char *name;
  sd_wall_kind kind;
  int n, corner[3];
} container_wall;

typedef struct container_kind {
  unsigned periodic;           /* bit c: periodic along coordinate c */
  bool rectangle;              /* the inside is a rectangle, whose sides are straight lines */
  bool disk_floor;             /* a row of fixed disks lies under its lower edge */
  bool outlet;                 /* disks that fall below its lower edge have left it */
  void (*shape)(container *c); /* sets the outline; or `key` and `expected` */
  container_wall walls[5];
  /* walls at the left, right, lower and upper side; NULL: none */
  const char *sides[4];
} container_kind;

/* The keys of the deck's group `container`. */
extern const struct deck_table container_table;

/* Returns the row of a kind. */
const container_kind *container_kind_of(int kind);
/* Sets the outline from the values of the keys, or `key` and `expected`. */
void container_shape(container *c);
/* Stores the bounding box of the outline. */
void container_bounds(const container_outline *o, double lower[2], double upper[2]);
/* Stores the smallest and largest x inside the container at height y, relative to its origin:
 * infinite for a rectangle and for kind 0. Returns false where y is outside. */
bool container_span(const container *c, double y, double span[2]);
/* Returns true if the rectangle from lower to upper lies inside the container. */
bool container_holds(const container *c, const double lower[2], const double upper[2]);
/* Returns the lowest y from which an open container reaches as far to both sides of its origin as
 * `half`; at most its upper edge. */
double container_wide_from(const container *c, double half);
/* Returns the area of the part of the rectangle from lower to upper inside the container. */
double container_area(const container *c, const double lower[2], const double upper[2]);

#endif
