/* joints.h: ends of walls that meet. */
#ifndef SLIPDISK_MODEL_JOINTS_H
#define SLIPDISK_MODEL_JOINTS_H

#include "model/model.h"

/* One end of a wall: of a segment, of an open polyline, of an arc. */
typedef struct wall_end {
  uint32_t wall;
  int end; /* 0: where the wall begins, 1: where it ends */
  double
      at[2]; /* its place at the start of the run; in a periodic box that of its image in there */
  int cells[2];  /* how many periods away the image is */
  double along;  /* length of the piece that ends there */
  double way[2]; /* unit vector from there along the wall */
} wall_end;

/* All ends, by x; *n: how many. To be freed. */
wall_end *joints_ends(const sd_model *model, size_t *n);
/* Within which another point is at the same place. */
double joints_tolerance(const wall_end *end);
/* Do two ends stand at one place? */
bool joints_meet(const wall_end *a, const wall_end *b);
/* The ends after k, in order of x, that may meet it: up to the one returned. */
size_t joints_near(const wall_end *ends, size_t n, size_t k);
/* Do the walls of two ends keep their places to one another in all motions? */
bool joints_rigid(const sd_model *model, const wall_end *a, const wall_end *b);
/* Numbers the vertices of all pieces; model->segments are there. */
void joints_number(sd_model *model);

#endif
