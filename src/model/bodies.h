/* bodies.h: what follows from the points of a wall, and from locks and motions of a disk. */
#ifndef SLIPDISK_MODEL_BODIES_H
#define SLIPDISK_MODEL_BODIES_H

#include "model/model.h"

/* Marks the disks whose coordinates are all prescribed or locked as driven, and counts the free ones. */
sd_status model_find_driven(sd_model *model);

/* Straight segments of a wall; a circle has none. */
static inline size_t wall_segments(const sd_wall *w) {
  if (w->kind == SD_WALL_CIRCLE || w->n_points < 2) return 0;
  return w->kind == SD_WALL_POLYLINE ? w->n_points - 1 + (w->closed ? 1 : 0) : 1;
}

/* The usual pivot: the mean of the points. */
static inline void wall_set_pivot(sd_wall *w) {
  for (int c = 0; c < 2; c++) {
    w->pivot[c] = 0;
    for (size_t k = 0; k < w->n_points; k++) w->pivot[c] += w->points[k][c] / (double)w->n_points;
  }
}

#endif
