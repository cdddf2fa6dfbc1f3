/* grid.h: cell grid of the disks, with a level for each range of sizes (hierarchical grid: Ogarko &
 * Luding, Comput. Phys. Commun. 183, 931).
 *
 * A level holds disks whose radii differ by less than the factor LEVEL_FACTOR, in cells whose size
 * suits them. The top level begins with the largest disk, each further level with the largest disk
 * that is left. If all sizes are within one factor there is one level; a few disks of another size
 * get their own level. The cost of a search thus depends on the disks nearby, not on the largest
 * disk of all.
 */
#ifndef PHYSICS_GRID_H
#define PHYSICS_GRID_H

#include "base/comm.h"
#include "physics/system/work.h"

enum { GRID_LEVELS = 16 };

typedef struct grid_level {
  double largest; /* radius of the largest disk on this level */
  uint32_t last;  /* highest slot of a disk on this level */
  size_t count;
  bool periodic[2];
  /* lower: lower left corner of the grid; per_cell: 1/(side of a cell); both along x and y. offset:
   * shift along x of each row of periodic images of the box against the row below (sheared box) */
  double lower[2], per_cell[2], offset;
  int64_t cells[2];
  uint32_t *start; /* disks[start[c]], ..., disks[start[c + 1] - 1] are in cell c */
  uint32_t *disks; /* slots of the disks on this level, sorted by cell, then slot */
} grid_level;

typedef struct grid {
  size_t count;
  grid_level level[GRID_LEVELS]; /* levels, from the largest disks to the smallest */
  uint32_t *start, *disks;       /* memory that `start` and `disks` of all levels point into */
  /* largest distance by which a disk lies outside a periodic box; disks are wrapped only now and
   * then */
  double overhang;
} grid;

/* Result of a search: ranges in the array `disks` of a level. A run is disks[from], ..., disks[to -
 * 1]. */
typedef struct grid_runs {
  struct grid_run {
    uint32_t from, to;
  } * run;
  size_t count, capacity;
} grid_runs;

/* Part of a straight line: the points (x, y) + u (tx, ty) with -back <= u <= length, where (tx, ty)
 * is a unit vector; back and length may be infinite. */
typedef struct grid_line {
  double x, y, tx, ty, back, length;
} grid_line;

/* Builds the grid of all disks that are in the simulation. margin: largest gap between surfaces of
 * the pairs that will be searched for; it sets the size of cells. Returns SD_ERROR_IO if memory
 * runs out. */
sd_status grid_build(const engine *e, double margin, grid *g);
void grid_free(grid *g);
/* Finds all disks of level l whose centres are nearer than `reach` to point `at`. The result may
 * include disks farther away, but no disk twice. */
void grid_around(const grid *g, const grid_level *l, const double at[2], double reach,
                 grid_runs *found);
/* Finds all disks of level l whose centres are nearer than `reach` to a line. The result may
 * include disks farther away. Periodic images of the line are ignored. */
void grid_along(const grid_level *l, const grid_line *line, double reach, grid_runs *found);
/* Divides n radii into levels of size: writes the largest radius of each level to top[],
 * descending, and returns the number of levels. factor: largest ratio of two radii on one level. c:
 * ranks that divide all their radii together, in a collective call; NULL: only these n radii. */
size_t grid_levels_of(const double *radius, size_t n, double factor, const comm *c,
                      double top[GRID_LEVELS]);

#endif
