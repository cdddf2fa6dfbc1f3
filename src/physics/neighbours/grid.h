/* grid.h: disks in cells, by levels of size (hierarchical grid: Ogarko & Luding, Comput. Phys. Commun. 183, 931).
 *
 * A level holds the disks of radii within a factor (LEVEL_FACTOR), in cells of its own size. The top level begins with the
 * largest disk, each next one with the largest disk that is left: sizes within one factor are one level, whatever they
 * are, and a few disks of another size are a level of their own. So the cost of a search follows the disks near it, not
 * the largest of all.
 */
#ifndef PHYSICS_GRID_H
#define PHYSICS_GRID_H

#include "base/comm.h"
#include "physics/system/work.h"

enum { GRID_LEVELS = 16 };

typedef struct grid_level {
  double largest; /* radius */
  uint32_t last;  /* highest slot */
  size_t count;
  bool periodic[2];
  double lower[2], per_cell[2],
      offset; /* offset: of a row of periodic images against the one below */
  int64_t cells[2];
  uint32_t *start; /* cell c holds disks[start[c] .. start[c + 1]) */
  uint32_t *disks; /* of the level, by cell and slot */
} grid_level;

typedef struct grid {
  size_t count;
  grid_level level[GRID_LEVELS]; /* the largest disks first */
  uint32_t *start, *disks;       /* of all levels */
  double overhang;               /* how far disks stand beyond a periodic box, for a step */
} grid;

/* Runs of a level's disks: disks[from .. to). */
typedef struct grid_runs {
  struct grid_run {
    uint32_t from, to;
  } * run;
  size_t count, capacity;
} grid_runs;

/* A straight line from (x, y) along (tx, ty); either length may be infinite. */
typedef struct grid_line {
  double x, y, tx, ty, back, length; /* it goes from -back to length */
} grid_line;

/* margin: by how much pairs that are looked for are farther apart than the sum of their radii, at most. SD_ERROR_IO
 * without memory. */
sd_status grid_build(const engine *e, double margin, grid *g);
void grid_free(grid *g);
/* Disks whose centres are nearer to a point than `reach`, and others; each once. */
void grid_around(const grid *g, const grid_level *l, const double at[2], double reach,
                 grid_runs *found);
/* The same for a line, not for its periodic images. */
void grid_along(const grid_level *l, const grid_line *line, double reach, grid_runs *found);
/* Radii of the levels: writes the largest of each, descending, and returns how many there are. most: the largest of a value on all
 * ranks, which then call together; NULL: of this one. */
size_t grid_levels_of(const double *radius, size_t n, double factor, const comm *c,
                      double top[GRID_LEVELS]);

#endif
