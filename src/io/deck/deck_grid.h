/* deck_grid.h: the group `sweep` of a deck, as it is written: grids of parameters and their values.
 * deck_sweep.c makes points of them. Everything stands in the arena of the deck. */
#ifndef SLIPDISK_IO_DECK_GRID_H
#define SLIPDISK_IO_DECK_GRID_H

#include "io/deck/deck_tree.h"

typedef struct grid_value {
  const char *text;    /* as in the deck, without quotes; equal numbers have equal texts */
  const char *literal; /* as behind the = of -D; the same */
  double number;       /* an angle in rad; NAN: no number */
  deck_place place;
} grid_value;

typedef struct grid_axis {
  const char *name; /* NULL until all are known and none is given */
  bool named;       /* by the deck */
  size_t n_paths;
  const char **paths;
  size_t n_values;
  grid_value *values;
  size_t dimension; /* axes of one dimension advance together */
  const deck_node *node;
} grid_axis;

typedef struct grid {
  size_t n_axes;
  grid_axis *axes;
  size_t n_dimensions;
  size_t *length; /* [n_dimensions] */
  int64_t replicas;
  bool seed_varies; /* a parameter sets the seed */
  deck_node *node;
} grid;

typedef struct deck_grids {
  size_t n;
  grid *grid;
  size_t n_collect;
  const char **collect;
} deck_grids;

/* Mistakes are reported. n is 0 when the deck has no sweep. */
deck_grids deck_read_grids(deck *d);
/* Number of points, replicas and repeated points included; at most GRID_MOST + 1. */
enum { GRID_MOST = 1000000 };
size_t deck_grid_points(const grid *g);

#endif
