/* walls.h: wall segments in space, the point of a segment nearest to a disk, and joints, at which
 * segments meet. Segments are straight or arcs; the two end points of an arc are segments, too. */
#ifndef PHYSICS_WALLS_H
#define PHYSICS_WALLS_H

#include <math.h>

#include "model/model.h"
#include "physics/system/work.h"

/* Point of a wall segment that is nearest to (x, y), the centre of a disk. */
typedef struct nearest_point {
  double dx, dy; /* vector from (x, y) to the nearest point */
  double arc;    /* arc length of the nearest point along the wall */
  /* Side of the wall: +1 left of the tangent, -1 right. It is the side on which the contact began;
   * without a contact, the side of (x, y). */
  double side;
  bool active;  /* false: the segment cannot touch a disk at (x, y); a neighbour may */
  bool flat;    /* the nearest point lies between the ends of the segment */
  bool crossed; /* (x, y) is not on the side on which the contact began */
} nearest_point;

/* Returns the point of straight segment g nearest to (x, y). Each segment of a polyline owns a
 * region of the plane; regions overlap only where the polyline bends towards the disk. A vertex
 * belongs to the segment that starts there, and is active only beyond the end of the segment
 * before. Both segments use the coordinates of the same vertex, so rounding leaves no gap between
 * their regions. */
static inline nearest_point walls_nearest_straight(const placed_segment *g, double x, double y) {
  double rx = x - g->x, ry = y - g->y, u = rx * g->tx + ry * g->ty;
  double bend = g->px * g->ty - g->py * g->tx;
  /* if two segments form one straight line, the vertex between them belongs to the first one */
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
  /* a vertex can only be touched from the outer side of the bend, even if the bend is sharp */
  if (before && bend != 0.0) q.side = bend > 0.0 ? -1.0 : 1.0;
  q.crossed = false;
  q.active = q.flat || (beyond ? g->end_cap : rx * g->px + ry * g->py > 0.0);
  return q;
}

/* Returns the point of an arc, or of one of its end points, nearest to (x, y). An arc owns the
 * wedge between the directions of its ends; an end point is active outside this wedge if (x, y)
 * lies beyond that end. Both end points can be active: a large disk can rest on both rims of a
 * bowl. side: +1 inside the circle, -1 outside. */
static inline nearest_point walls_nearest_arc(const placed_segment *g, double x, double y) {
  const double rx = x - g->x, ry = y - g->y, r = sqrt(rx * rx + ry * ry);
  const double after = g->fx * ry - g->fy * rx,
               before = g->lx * ry - g->ly * rx; /* the wedge is where after >= 0 and before < 0 */
  const bool within = g->wide ? after >= 0.0 || before < 0.0 : after >= 0.0 && before < 0.0;
  nearest_point q = {.side = r < g->radius ? 1.0 : -1.0, .arc = g->arc};
  if (g->piece == SD_PIECE_CURVE) {
    const double scale = r > 0.0 ? (g->radius - r) / r : 0.0; /* the centre has no nearest point */
    q.dx = rx * scale;
    q.dy = ry * scale;
    q.arc += g->radius * atan2(g->mx * ry - g->my * rx, g->mx * rx + g->my * ry);
    q.active = q.flat = within;
    return q;
  }
  const bool first = g->piece == SD_PIECE_FIRST_END;
  q.dx = g->radius * (first ? g->fx : g->lx) - rx;
  q.dy = g->radius * (first ? g->fy : g->ly) - ry;
  q.active = !within && (first ? after <= 0.0 : before >= 0.0);
  return q;
}

/* Returns the lever of the tangential force at a nearest point between the ends of a segment: 1 on
 * a straight one, (R_a + R_b)/r on an arc, as for round bodies. radius: of the disk. */
static inline double walls_lever(const placed_segment *g, const nearest_point *q, double radius) {
  if (g->piece == SD_PIECE_STRAIGHT) return 1.0;
  /* R_a + R_b, and the signed distance r from the disk's centre to that of the circle */
  const double sum = radius - q->side * g->radius, way = hypot(q->dx, q->dy) - q->side * g->radius;
  return sum / way;
}

/* Returns R_b of a segment: for an arc that of a round wall, negative if the disk is inside; 0 for
 * straight segments and end points. side: nearest_point.side. */
static inline double walls_radius(const placed_segment *g, double side) {
  return g->piece == SD_PIECE_CURVE ? -side * g->radius : 0.0;
}

/* Returns R_eff for rolling of a disk (radius ra) on a wall segment (radius rb), as computed by
 * `rolled` in law_rolling.h. */
static inline double walls_arm(double ra, double rb) {
  return rb != 0.0 && ra + rb == 0.0 ? ra * rb : law_arm(ra, rb);
}

/* Returns the arc length along the wall at an end of segment g. end: 0 start, 1 far end. */
static inline double walls_arc_at(const placed_segment *g, int end) {
  if (g->piece == SD_PIECE_CURVE) return g->arc + (end ? 0.5 : -0.5) * g->length;
  return g->arc + (end ? g->length : 0.0);
}

/* Returns the point of segment g, of any shape, nearest to (x, y). */
static inline nearest_point walls_nearest(const placed_segment *g, double x, double y) {
  return g->piece == SD_PIECE_STRAIGHT ? walls_nearest_straight(g, x, y)
                                       : walls_nearest_arc(g, x, y);
}

/* Turns segment *g into its periodic image nx, ny periods away. length: periods of the box. */
static inline void walls_shift(const double length[2], double nx, double ny, placed_segment *g) {
  g->shift_x = length[0] * nx;
  g->shift_y = length[1] * ny;
  g->x += g->shift_x;
  g->y += g->shift_y;
  /* The end has the same bits as the start of the next segment's image, so each point belongs to
   * exactly one of them. */
  g->end_x += length[0] * (nx + g->cells[0]);
  g->end_y += length[1] * (ny + g->cells[1]);
}

/* Sets n to the number of periods to the image of g whose middle is nearest to (x, y), 0 along
 * directions without images. length: periods of the box. */
static inline void walls_periods(const double length[2], const placed_segment *g, double x,
                                 double y, double n[2]) {
  n[0] = g->image[0] ? nearbyint((x - (g->x + g->middle_x)) / length[0]) : 0.0;
  n[1] = g->image[1] ? nearbyint((y - (g->y + g->middle_y)) / length[1]) : 0.0;
}

/* Returns the image of g whose middle is nearest to (x, y). This is the nearest image, because
 * segments with images are short (model/walls.h). The result is g itself if it has no images, else
 * `image`, which is filled in. */
static inline const placed_segment *walls_image(const double length[2], const placed_segment *g,
                                                double x, double y, placed_segment *image) {
  if (!(g->image[0] || g->image[1])) return g;
  double n[2];
  walls_periods(length, g, x, y, n);
  *image = *g;
  walls_shift(length, n[0], n[1], image);
  return image;
}

/* Sets the corners of the bounding box of segment g; they are infinite for a line. */
void walls_bounds(const placed_segment *g, double lower[2], double upper[2]);

/* Returns a segment of a wall, placed in space. x, y: pivot of the wall; c, i: cosine and sine of
 * its angle; scale: lengths over those of the model. end_x and end_y are not set. */
placed_segment walls_place(const sd_segment *from, double x, double y, double c, double i,
                           double scale);

/* Moves all segments to the present poses of their walls. */
void walls_pose(engine *e);
/* Moves the segments in the list of pairs to the present poses of their walls. The other segments
 * are not current until walls_pose is called. */
void walls_pose_listed(engine *e);

/* --- joints, at which segments meet --- */

/* True if the disk of `pair` touches the segment of this pair, and not another one that meets it,
 * at its nearest point q. */
bool joints_own(const engine *e, size_t pair, const nearest_point *q);
/* True if the segment g of `pair` can touch the disk at its nearest point q. Calls joints_own only
 * if q is near an end of g, where other segments may own the point. */
static inline bool joints_active(const engine *e, size_t pair, const placed_segment *g,
                                 const nearest_point *q) {
  if (!g->shared || !q->active) return q->active;
  const double on = q->arc - g->arc, near = 1e-6 * e->state->radius[e->work.pairs.a[pair]];
  const bool straight = q->flat && g->piece == SD_PIECE_STRAIGHT;
  if (straight ? on >= near && on <= g->length - near : !g->meets) return true;
  return joints_own(e, pair, q);
}
/* Transfers the contact of a disk that moves from one wall segment to the next. Called when the
 * contact of `pair` is about to open (closed: true) or to begin (false). If the disk passes a
 * joint, the record moves to the pair with the other segment, so that no contact opens or begins.
 * Returns true if it did. */
bool joints_hand_over(engine *e, size_t pair, bool closed);
/* Returns R_b of a round body or an arc (negative inside); 0 for straight segments and end points.
 * pair: a round pair, or a closed contact with a wall segment. */
double joints_radius(const engine *e, size_t pair);

#endif
