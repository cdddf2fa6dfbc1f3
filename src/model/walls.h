/* walls.h: the segments of walls, with which disks make contacts, also in periodic boxes. */
#ifndef SLIPDISK_MODEL_WALLS_H
#define SLIPDISK_MODEL_WALLS_H

#include "model/model.h"

/* Makes m->segments, the segments of all walls, and numbers their vertices. */
void model_find_pieces(sd_model *model);
/* True if a motion moves the surface of a wall. */
bool model_moves_surfaces(const sd_model *model);

/* Number of segments of a wall in an open box; a circle has none, an arc three: both ends and
 * the curve, or three thirds of a full circle. */
static inline size_t wall_segments(const sd_wall *w) {
  if (w->kind == SD_WALL_CIRCLE || w->n_points < 2) return 0;
  if (w->kind == SD_WALL_ARC) return 3;
  return w->kind == SD_WALL_POLYLINE ? w->n_points - 1 + (w->closed ? 1 : 0) : 1;
}

/* True if the wall is one straight segment or line. */
static inline bool wall_is_straight(const sd_wall *w) {
  return w->kind == SD_WALL_LINE || w->kind == SD_WALL_SEGMENT;
}

/* Sets the default pivot: the mean of the points. */
static inline void wall_set_pivot(sd_wall *w) {
  for (int c = 0; c < 2; c++) {
    w->pivot[c] = 0;
    for (size_t k = 0; k < w->n_points; k++) w->pivot[c] += w->points[k][c] / (double)w->n_points;
  }
}

/* --- periodic boxes --------------------------------------------------------------------------- */

/* Each segment and each arc has images in a periodic box; a disk touches the nearest image of a
 * segment. To make this image unique, long straight segments are cut, and walls whose images are
 * too near are rejected. */

/* Number of equal segments into which side k of a wall is cut, so that none is longer than half
 * of the shorter box length; 1 in an open box, and for lines and arcs. */
size_t wall_cuts(const sd_model *m, const sd_wall *w, size_t k);
/* Number of segments of a wall after cutting for the periodic box; in an open box that of
 * wall_segments. */
size_t wall_pieces(const sd_model *m, const sd_wall *w);
/* True if the last point of wall w is a periodic image of its first and no motion turns the
 * wall, so that it continues in its image. cells: number of box lengths between these two
 * points, along x and y. */
bool wall_meets_image(const sd_model *m, size_t w, int cells[2]);
/* Sets the periodic directions in which a segment has images, and its midpoint. endless: the
 * wall is an infinite line. */
void wall_piece_images(const sd_model *m, bool endless, sd_segment *piece);
/* Reports walls whose periodic images are too near to each other or do not fit together. */
void wall_images_check(const sd_model *m, sd_messages *messages);

/* Bounding box of a wall at the start; empty (lower > upper) for a wall without points. */
typedef struct wall_bounds {
  double lower[2], upper[2];
} wall_bounds;
wall_bounds wall_bounds_of(const sd_wall *w);

/* Periodic images of a point that may be nearer to a wall than a given distance: those displaced
 * by first[c] ... last[c] box lengths along coordinate c. */
typedef struct wall_range {
  double length[2]; /* length of the periodic box; 0: no images along this direction */
  double first[2], last[2];
} wall_range;

/* Finds the periodic images of the point `at` that may be nearer than `reach` to the wall in its
 * position at the start. */
wall_range wall_range_of(const sd_model *m, const sd_wall *w, const wall_bounds *bounds,
                         const double at[2], double reach);

/* --- ends of walls that meet, and the vertices that their segments share ---------------------- */

/* One end of a segment, an open polyline or an arc. */
typedef struct wall_end {
  uint32_t wall;
  int end; /* 0: the end at the first point of the wall, 1: at the last point */
  /* Position at the start of the run; in a periodic box that of its image inside the box. */
  double at[2];
  int cells[2];  /* number of box lengths from the end to this image, along x and y */
  double along;  /* length of the side of the wall that ends here */
  double way[2]; /* unit vector that points from the end along the wall */
} wall_end;

/* Returns the ends of all walls (segments, open polylines, arcs), sorted by x, and the number of
 * ends in *n. The caller frees them. */
wall_end *joints_ends(const sd_model *model, size_t *n);
/* Distance within which another point counts as the same point as this end. */
double joints_tolerance(const wall_end *end);
/* True if two ends are at the same point. */
bool joints_meet(const wall_end *a, const wall_end *b);
/* Ends are sorted by x. Returns the index after the last end that follows end k and is so near
 * in x that it may meet end k. */
size_t joints_near(const wall_end *ends, size_t n, size_t k);
/* True if the walls of two ends keep their relative position in all motions. */
bool joints_rigid(const sd_model *model, const wall_end *a, const wall_end *b);
/* Numbers the vertices of all wall segments: fills in `vertex` and `meets` of sd_segment.
 * model->segments must exist. */
void joints_number(sd_model *model);

#endif
