/* walls.h: straight walls in space, and the point of a piece that is nearest to a disk. */
#ifndef PHYSICS_WALLS_H
#define PHYSICS_WALLS_H

#include "physics/work.h"

typedef struct nearest_point {
  double dx, dy; /* from (x, y) to the point */
  double arc;    /* arc length of the point along the wall */
  double side;   /* the one remembered, else where (x, y) is: +1 left of the tangent, -1 right */
  bool active;   /* false: a neighbouring piece owns this region, or nothing is there */
  bool flat;     /* the point lies between the ends */
  bool crossed;  /* (x, y) is not on the remembered side */
} nearest_point;

/* The regions of the pieces of a polyline do not overlap: a vertex belongs to the piece that starts there,
 * and only where the disk is beyond the end of the piece before. */
static inline nearest_point walls_nearest(const placed_segment *g, double x, double y) {
  double rx = x - g->x, ry = y - g->y, u = rx * g->tx + ry * g->ty;
  double on = u < g->backwards ? g->backwards : u > g->length ? g->length : u;
  nearest_point q;
  q.dx = on * g->tx - rx;
  q.dy = on * g->ty - ry;
  q.arc = g->arc + on;
  q.side = g->tx * ry - g->ty * rx >= 0.0 ? 1.0 : -1.0;
  q.flat = on == u;
  /* a joint is touched from the outer side of the bend only, however sharp it is */
  double bend = g->px * g->ty - g->py * g->tx;
  if (u < 0.0 && !q.flat && bend != 0.0) q.side = bend > 0.0 ? -1.0 : 1.0;
  q.crossed = false;
  q.active = q.flat || (u > g->length ? g->end_cap : rx * g->px + ry * g->py > 0.0);
  return q;
}

/* Brings every piece to its wall's present pose. */
void walls_place(engine *e);

#endif
