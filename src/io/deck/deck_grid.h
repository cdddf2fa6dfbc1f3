/* deck_grid.h: the group `sweep` of a deck as written: grids of parameters and their values.
 * deck_sweep.c forms the points, which are all combinations of these values. All data are in the
 * arena of the deck. */
#ifndef SLIPDISK_IO_DECK_GRID_H
#define SLIPDISK_IO_DECK_GRID_H

#include "io/deck/deck_tree.h"

typedef struct grid_value {
  /* Value as written in the deck, without quotes; equal numbers have equal texts */
  const char *text;
  const char *literal; /* Value as written after the = of -D path=value, with quotes */
  double number;       /* Numerical value, angles in rad; NAN: not a number */
  deck_place place;
} grid_value;

typedef struct grid_axis {
  const char *name; /* Name of the parameter; NULL until it is derived from the path */
  bool named;       /* True if the name is written in the deck */
  size_t n_paths;
  const char **paths;
  size_t n_values;
  grid_value *values;
  /* Index of the dimension in the grid; axes with the same index advance together (zip) */
  size_t dimension;
  const deck_node *node;
} grid_axis;

typedef struct grid {
  size_t n_axes;
  grid_axis *axes;
  size_t n_dimensions;
  size_t *length; /* [n_dimensions]: number of values in each dimension */
  int64_t replicas;
  bool seed_varies; /* True if a parameter sets the seed */
  deck_node *node;
} grid;

typedef struct deck_grids {
  size_t n;
  grid *grid;
  size_t n_collect;
  const char **collect;
} deck_grids;

/* Reads the group `sweep` and reports its errors. Member n of the returned value is 0 if the deck
 * has no sweep. */
deck_grids deck_read_grids(deck *d);
/* GRID_MOST: largest number of points of a grid. deck_grid_points returns the number of points,
 * including replicas and repeated points, or GRID_MOST + 1 if there are more. */
enum { GRID_MOST = 1000000 };
size_t deck_grid_points(const grid *g);

#endif
