/* box.h: nearest images in the periodic box, whose cells repeat by (length[0], 0) and (offset, length[1]): rows of cells may be
 * shifted against each other (Lees-Edwards). Rows first, since they shift x. */
#ifndef PHYSICS_BOX_H
#define PHYSICS_BOX_H

#include <math.h>

#include "physics/system/work.h"

/* How many cells away an image is, and how fast it moves against the original. */
typedef struct box_image {
  double x, y;
} box_image;

/* Makes a difference of two positions the one to the nearest image; returns the cells that were taken away. */
static inline box_image box_nearest(const work *w, double *dx, double *dy) {
  box_image n = {0.0, 0.0};
  if (w->periodic[1]) {
    n.y = nearbyint(*dy * w->inverse_length[1]);
    *dy -= w->length[1] * n.y;
    *dx -= w->offset * n.y;
  }
  if (w->periodic[0]) {
    n.x = nearbyint(*dx * w->inverse_length[0]);
    *dx -= w->length[0] * n.x;
  }
  return n;
}

/* Position of the disk in this slot beyond the box, where its way has led it. */
static inline double box_absolute_x(const engine *e, size_t slot) {
  const work *w = &e->work;
  return e->state->x[slot] + e->state->image_x[slot] * w->length[0] +
         e->state->image_y[slot] * w->offset;
}
static inline double box_absolute_y(const engine *e, size_t slot) {
  return e->state->y[slot] + e->state->image_y[slot] * e->work.length[1];
}

#endif
