/* joints.h: ends of walls that meet, and the vertices that their segments share. */
#ifndef SLIPDISK_MODEL_JOINTS_H
#define SLIPDISK_MODEL_JOINTS_H

#include "model/model.h"

/* One end of a segment, an open polyline or an arc. */
typedef struct wall_end {
  uint32_t wall;
  int end; /* 0: first point of the wall, 1: last point */
  /* Position at the start of the run; in a periodic box of the image inside the box. */
  double at[2];
  int cells[2];  /* number of periods from the end to this image */
  double along;  /* length of the side of the wall that ends here */
  double way[2]; /* unit vector from the end along the wall */
} wall_end;

/* Returns the ends of all walls, sorted by x, and their number in *n. The caller frees them. */
wall_end *joints_ends(const sd_model *model, size_t *n);
/* Distance within which another point counts as the same point. */
double joints_tolerance(const wall_end *end);
/* True if two ends are at the same point. */
bool joints_meet(const wall_end *a, const wall_end *b);
/* Returns the index after the last of the ends that follow end k and may meet it, by their x. */
size_t joints_near(const wall_end *ends, size_t n, size_t k);
/* True if the walls of two ends keep their relative position in all motions. */
bool joints_rigid(const sd_model *model, const wall_end *a, const wall_end *b);
/* Numbers the vertices of all segments of walls (sd_segment.vertex and meets). model->segments
 * must exist. */
void joints_number(sd_model *model);

#endif
