/* bodies.h: what follows from the points of a wall, and from locks and motions of a disk. */
#ifndef SLIPDISK_MODEL_BODIES_H
#define SLIPDISK_MODEL_BODIES_H

#include "model/model.h"

/* Marks the disks whose coordinates are all prescribed or locked as driven, and counts the free
 * ones. SD_ERROR_IO: there is no memory. */
sd_status model_find_driven(sd_model *model);
/* Coordinates that motions prescribe, of each disk that is held (rows.h): bits 1 << coordinate; to
 * be freed. NULL: there is no memory. */
unsigned char *model_moved(const sd_model *model);

/* Fills m->segments. */
void model_find_pieces(sd_model *model);
/* Does a motion move the surface of a wall? */
bool model_moves_surfaces(const sd_model *model);

/* Pieces of a wall; a circle has none. Those of an arc: its ends and what is between them, or three thirds of a ring. */
static inline size_t wall_segments(const sd_wall *w) {
  if (w->kind == SD_WALL_CIRCLE || w->n_points < 2) return 0;
  if (w->kind == SD_WALL_ARC) return 3;
  return w->kind == SD_WALL_POLYLINE ? w->n_points - 1 + (w->closed ? 1 : 0) : 1;
}

/* One straight piece? */
static inline bool wall_is_straight(const sd_wall *w) {
  return w->kind == SD_WALL_LINE || w->kind == SD_WALL_SEGMENT;
}

/* The usual pivot: the mean of the points. */
static inline void wall_set_pivot(sd_wall *w) {
  for (int c = 0; c < 2; c++) {
    w->pivot[c] = 0;
    for (size_t k = 0; k < w->n_points; k++) w->pivot[c] += w->points[k][c] / (double)w->n_points;
  }
}

#endif
