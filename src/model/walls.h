/* walls.h: pieces of walls, of which contacts are made, also in periodic boxes. */
#ifndef SLIPDISK_MODEL_WALLS_H
#define SLIPDISK_MODEL_WALLS_H

#include "model/model.h"

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

/* --- periodic boxes --------------------------------------------------------------------------- */

/* Each straight piece and each arc repeats with the box; a disk meets the nearest image of
 * a piece. So that this is one only, long straight pieces are cut, and walls are refused whose images come too near.
 */

/* Into how many equal pieces side k of a wall is cut: none is longer than half of the shortest period. */
size_t wall_cuts(const sd_model *m, const sd_wall *w, size_t k);
/* Pieces of a wall, cut as the box needs it; wall_segments in an open one. */
size_t wall_pieces(const sd_model *m, const sd_wall *w);
/* Does the last point of wall w lie on an image of its first one, and stay there? Its images are joined then. cells: how many
 * periods lie between. */
bool wall_meets_image(const sd_model *m, size_t w, int cells[2]);
/* Along which directions a piece has images, and where its middle is. */
void wall_piece_images(const sd_model *m, bool endless, sd_segment *piece);
/* Walls whose images cannot be told apart, or do not fit together. */
void wall_images_check(const sd_model *m, sd_messages *messages);

/* The rectangle around a wall at the start; empty for one without points. */
typedef struct wall_bounds {
  double lower[2], upper[2];
} wall_bounds;
wall_bounds wall_bounds_of(const sd_wall *w);

/* Images of a point from which a wall as it stands in the model may be nearer than `reach`: first to last along each
 * direction. */
typedef struct wall_range {
  double length[2]; /* of the box; 0: no images along this direction */
  double first[2], last[2];
} wall_range;

wall_range wall_range_of(const sd_model *m, const sd_wall *w, const wall_bounds *bounds,
                         const double at[2], double reach);

#endif
