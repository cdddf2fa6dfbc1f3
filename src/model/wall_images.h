/* wall_images.h: walls in periodic boxes. Each straight piece and each arc repeats with the box; a disk meets the nearest image of
 * a piece. So that this is one only, long straight pieces are cut, and walls are refused whose images come too near.
 */
#ifndef MODEL_WALL_IMAGES_H
#define MODEL_WALL_IMAGES_H

#include "model/model.h"

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

wall_range wall_range_of(const sd_model *m, const sd_wall *w, const wall_bounds *bounds, const double at[2],
                         double reach);

#endif
