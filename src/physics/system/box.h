/* box.h: nearest images in the periodic box. The lattice vectors of the box are (length[0], 0) and
 * (offset, length[1]): rows of cells can be shifted against each other (Lees-Edwards). The y
 * direction is wrapped first, since wrapping it also shifts x. */
#ifndef PHYSICS_BOX_H
#define PHYSICS_BOX_H

#include <math.h>

#include "physics/system/work.h"

/* Number of periodic cells, along x and y, between a body and its nearest image. */
typedef struct box_image {
  double x, y;
} box_image;

/* Changes the difference of two positions (*dx, *dy) to the minimum image; returns the numbers of
 * periods that were subtracted. */
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

/* box_absolute_x and box_absolute_y return the unwrapped position of the disk in a slot: its path
 * is continued across the edges of the box. */
static inline double box_absolute_x(const engine *e, size_t slot) {
  const work *w = &e->work;
  return e->state->x[slot] + e->state->image_x[slot] * w->length[0] +
         e->state->image_y[slot] * w->offset;
}
static inline double box_absolute_y(const engine *e, size_t slot) {
  return e->state->y[slot] + e->state->image_y[slot] * e->work.length[1];
}

#endif
