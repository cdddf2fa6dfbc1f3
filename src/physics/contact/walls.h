/* walls.h: straight walls in space, and the point of a piece that is nearest to a disk. */
#ifndef PHYSICS_WALLS_H
#define PHYSICS_WALLS_H

#include "physics/system/work.h"

typedef struct nearest_point {
  double dx, dy; /* from (x, y) to the point */
  double arc;    /* arc length of the point along the wall */
  double side;   /* the one remembered, else where (x, y) is: +1 left of the tangent, -1 right */
  bool active;   /* false: a neighbouring piece owns this region, or nothing is there */
  bool flat;     /* the point lies between the ends */
  bool crossed;  /* (x, y) is not on the remembered side */
} nearest_point;

/* The regions of the pieces of a polyline do not overlap but where it bends inwards: a vertex belongs to the
 * piece that starts there, and only where the disk is beyond the end of the piece before. Both pieces measure
 * from the vertex itself, so that no rounding comes between them. */
static inline nearest_point walls_nearest(const placed_segment *g, double x, double y) {
  double rx = x - g->x, ry = y - g->y, u = rx * g->tx + ry * g->ty;
  double bend = g->px * g->ty - g->py * g->tx;
  /* where two pieces are one straight line, the point between them is the first one's */
  bool straight = bend == 0.0 && g->px * g->tx + g->py * g->ty > 0.0;
  bool before = straight ? u <= g->backwards : u < g->backwards;
  bool beyond = g->joined ? (x - g->end_x) * g->tx + (y - g->end_y) * g->ty > 0.0 : u > g->length;
  double on = before ? g->backwards : beyond ? g->length : u;
  nearest_point q;
  q.dx = on * g->tx - rx;
  q.dy = on * g->ty - ry;
  q.arc = g->arc + on;
  q.side = g->tx * ry - g->ty * rx >= 0.0 ? 1.0 : -1.0;
  q.flat = !before && !beyond;
  /* a joint is touched from the outer side of the bend only, however sharp it is */
  if (before && bend != 0.0) q.side = bend > 0.0 ? -1.0 : 1.0;
  q.crossed = false;
  q.active = q.flat || (beyond ? g->end_cap : rx * g->px + ry * g->py > 0.0);
  return q;
}

/* Brings every piece to its wall's present pose. */
void walls_pose(engine *e);

#endif
