/* grid.h: cell grid of the disks, with a level for each range of sizes (hierarchical grid: Ogarko &
 * Luding, Comput. Phys. Commun. 183, 931).
 *
 * A level holds disks whose radii differ by less than LEVEL_FACTOR, in cells of a size of its own.
 * The top level begins with the largest disk, each further level with the largest disk that is
 * left: if all sizes are within one factor there is one level, and a few disks of another size get
 * a level of their own. The cost of a search thus depends on the disks nearby, not on the largest
 * disk of all.
 */
#ifndef PHYSICS_GRID_H
#define PHYSICS_GRID_H

#include "base/comm.h"
#include "physics/system/work.h"

enum { GRID_LEVELS = 16 };

typedef struct grid_level {
  double largest; /* largest radius on this level */
  uint32_t last;  /* highest slot on this level */
  size_t count;
  bool periodic[2];
  /* lower: corner of the grid; per_cell: inverse size of a cell; offset: shift along x of a row of
   * periodic images against the row below (sheared box) */
  double lower[2], per_cell[2], offset;
  int64_t cells[2];
  uint32_t *start; /* disks[start[c] ... start[c + 1] - 1] are in cell c */
  uint32_t *disks; /* slots of the disks on this level, sorted by cell, then slot */
} grid_level;

typedef struct grid {
  size_t count;
  grid_level level[GRID_LEVELS]; /* in order of decreasing size */
  uint32_t *start, *disks;       /* memory of all levels */
  /* largest distance by which a disk lies outside a periodic box, until it is wrapped */
  double overhang;
} grid;

/* Result of a search: ranges of a level's array of disks, disks[from ... to - 1]. */
typedef struct grid_runs {
  struct grid_run {
    uint32_t from, to;
  } * run;
  size_t count, capacity;
} grid_runs;

/* Straight line from (x, y) along the unit vector (tx, ty); back and length may be infinite. */
typedef struct grid_line {
  /* part of the line, from -back to length along the unit vector */
  double x, y, tx, ty, back, length;
} grid_line;

/* Builds the grid of all disks that are in the simulation. margin: largest gap between surfaces of
 * the pairs that will be searched for; it sets the size of cells. Returns SD_ERROR_IO if memory
 * runs out. */
sd_status grid_build(const engine *e, double margin, grid *g);
void grid_free(grid *g);
/* Finds all disks of a level whose centres are nearer to a point than `reach`; the result may have
 * others as well, but each disk once. */
void grid_around(const grid *g, const grid_level *l, const double at[2], double reach,
                 grid_runs *found);
/* Finds all disks whose centres are nearer to a line than `reach`; the result may have others as
 * well. Periodic images of the line are ignored. */
void grid_along(const grid_level *l, const grid_line *line, double reach, grid_runs *found);
/* Divides radii into levels: writes the largest radius of each level to top[], descending, and
 * returns the number of levels. factor: ratio of the largest to the smallest radius of a level. c:
 * ranks whose disks are divided together, in a collective call; NULL: only these n. */
size_t grid_levels_of(const double *radius, size_t n, double factor, const comm *c,
                      double top[GRID_LEVELS]);

#endif
