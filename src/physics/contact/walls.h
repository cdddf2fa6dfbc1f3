/* walls.h: wall segments in space, the point of a segment nearest to a disk, and joints, which are
 * points at which segments meet. A segment is straight or an arc; the two end points of an arc are
 * segments of their own. */
#ifndef PHYSICS_WALLS_H
#define PHYSICS_WALLS_H

#include <math.h>

#include "base/math.h"
#include "model/segments.h"
#include "physics/system/work.h"

/* Point of a wall segment that is nearest to (x, y), the centre of a disk. */
typedef struct nearest_point {
  double dx, dy; /* vector from (x, y) to the nearest point */
  double arc;    /* arc length from the start of the wall to the nearest point */
  /* Side of the wall: +1 left of the tangent, -1 right of it. For a closed contact it is the side
   * on which the contact began, else the side on which (x, y) is. */
  double side;
  /* true: the segment can touch a disk at (x, y); false: a neighbouring segment may touch it
   * instead */
  bool active;
  bool flat;    /* true: the nearest point lies between the ends of the segment */
  bool crossed; /* true: (x, y) is not on the side of the wall on which the contact began */
} nearest_point;

/* Returns the point of straight segment g nearest to (x, y). Each segment of a polyline has a
 * region of the plane in which disks touch it; these regions overlap only where the polyline bends
 * towards the disk. A vertex belongs to the segment that starts there, and is active only beyond
 * the end of the segment before. Both segments use the same coordinates of the vertex, so that
 * rounding leaves no gap between their regions. */
static inline nearest_point walls_nearest_straight(const placed_segment *g, double x, double y) {
  double rx = x - g->x, ry = y - g->y, u = rx * g->tx + ry * g->ty;
  double bend = g->px * g->ty - g->py * g->tx;
  /* if two segments form one straight line, the vertex between them belongs to the first segment */
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

/* Returns the point nearest to (x, y) of an arc, or of one of the end points of an arc. An arc is
 * active in the wedge between the directions of its ends; an end point is active outside this
 * wedge, if (x, y) is beyond that end. Both end points can be active: a large disk can rest on both
 * rims of a bowl. side: +1 inside the circle, -1 outside. */
static inline nearest_point walls_nearest_arc(const placed_segment *g, double x, double y) {
  const double rx = x - g->x, ry = y - g->y, r = sqrt(rx * rx + ry * ry);
  const double after = g->fx * ry - g->fy * rx,
               /* (x, y) is in the wedge if after >= 0 and before < 0 */
      before = g->lx * ry - g->ly * rx;
  const bool within = g->wide ? after >= 0.0 || before < 0.0 : after >= 0.0 && before < 0.0;
  nearest_point q = {.side = r < g->radius ? 1.0 : -1.0, .arc = g->arc};
  if (g->piece == SD_PIECE_CURVE) {
    /* at the centre of the circle all points are equally near: the vector is 0 */
    const double scale = r > 0.0 ? (g->radius - r) / r : 0.0;
    q.dx = rx * scale;
    q.dy = ry * scale;
    q.arc += g->radius * math_atan2(g->mx * ry - g->my * rx, g->mx * rx + g->my * ry);
    q.active = q.flat = within;
    return q;
  }
  const bool first = g->piece == SD_PIECE_FIRST_END;
  q.dx = g->radius * (first ? g->fx : g->lx) - rx;
  q.dy = g->radius * (first ? g->fy : g->ly) - ry;
  q.active = !within && (first ? after <= 0.0 : before >= 0.0);
  return q;
}

/* Returns the lever of the tangential force for a nearest point q between the ends of segment g: 1
 * on a straight segment, (R_a + R_b)/r on an arc, as for round bodies. radius: radius of the
 * disk. */
static inline double walls_lever(const placed_segment *g, const nearest_point *q, double radius) {
  if (g->piece == SD_PIECE_STRAIGHT) return 1.0;
  /* sum: R_a + R_b; way: signed distance r from the disk's centre to the centre of the circle */
  const double sum = radius - q->side * g->radius,
               way = math_hypot(q->dx, q->dy) - q->side * g->radius;
  return sum / way;
}

/* Returns R_b of a segment: for an arc the radius, negative if the disk is inside the circle; 0 for
 * straight segments and end points. side: nearest_point.side. */
static inline double walls_radius(const placed_segment *g, double side) {
  return g->piece == SD_PIECE_CURVE ? -side * g->radius : 0.0;
}

/* Returns R_eff = ra rb/(ra + rb) for rolling of a disk (radius ra) on a wall segment (R_b = rb):
 * ra on a straight segment (rb = 0), and ra rb if ra + rb = 0, as in law_rolling.h. */
static inline double walls_arm(double ra, double rb) {
  return rb != 0.0 && ra + rb == 0.0 ? ra * rb : law_arm(ra, rb);
}

/* Returns the arc length along the wall at one end of segment g. end: 0 the start, 1 the far
 * end. */
static inline double walls_arc_at(const placed_segment *g, int end) {
  if (g->piece == SD_PIECE_CURVE) return g->arc + (end ? 0.5 : -0.5) * g->length;
  return g->arc + (end ? g->length : 0.0);
}

/* Returns the point of segment g, of any shape, nearest to (x, y). */
static inline nearest_point walls_nearest(const placed_segment *g, double x, double y) {
  return g->piece == SD_PIECE_STRAIGHT ? walls_nearest_straight(g, x, y)
                                       : walls_nearest_arc(g, x, y);
}

/* Moves segment *g to its periodic image nx, ny periods away. length: periods of the box along x
 * and y. */
static inline void walls_shift(const double length[2], double nx, double ny, placed_segment *g) {
  g->shift_x = length[0] * nx;
  g->shift_y = length[1] * ny;
  g->x += g->shift_x;
  g->y += g->shift_y;
  /* The end is computed like the start of the next segment's image and has the same bits, so that
   * each point belongs to exactly one of the two. */
  g->end_x += length[0] * (nx + g->cells[0]);
  g->end_y += length[1] * (ny + g->cells[1]);
}

/* Sets n[] to the number of periods along x and y from segment g to its image whose middle is
 * nearest to (x, y); 0 along directions without images. length: periods of the box along x and
 * y. */
static inline void walls_periods(const double length[2], const placed_segment *g, double x,
                                 double y, double n[2]) {
  n[0] = g->image[0] ? nearbyint((x - (g->x + g->middle_x)) / length[0]) : 0.0;
  n[1] = g->image[1] ? nearbyint((y - (g->y + g->middle_y)) / length[1]) : 0.0;
}

/* Returns the image of g whose middle is nearest to (x, y). It is the image nearest to this point,
 * because segments with images are short (model/walls.h). If g has no images, the result is g, else
 * *image, which is filled in. length: periods of the box along x and y. */
static inline const placed_segment *walls_image(const double length[2], const placed_segment *g,
                                                double x, double y, placed_segment *image) {
  if (!(g->image[0] || g->image[1])) return g;
  double n[2];
  walls_periods(length, g, x, y, n);
  *image = *g;
  walls_shift(length, n[0], n[1], image);
  return image;
}

/* Sets lower[] and upper[] to the corners of the bounding box of segment g; they are infinite for
 * an infinite line. */
void walls_bounds(const placed_segment *g, double lower[2], double upper[2]);

/* Returns a segment of a wall at its position in space. x, y: pivot of the wall; c, i: cosine and
 * sine of the wall's angle; scale: ratio of present lengths to those in the model. end_x and end_y
 * are not set. */
placed_segment walls_place(const sd_segment *from, double x, double y, double c, double i,
                           double scale);

/* Moves all segments to the present poses of their walls. */
void walls_pose(engine *e);
/* Moves only the segments that occur in the list of pairs to the present poses of their walls. The
 * other segments have old positions until walls_pose is called. */
void walls_pose_listed(engine *e);

/* --- joints, at which segments meet ----------------------------------------------------------- */

/* Returns true if the disk of `pair` touches the segment of this pair at its nearest point q, and
 * false if the contact belongs to another segment that meets it there. */
bool joints_own(const engine *e, size_t pair, const nearest_point *q);
/* Returns true if segment g of `pair` can touch the disk at its nearest point q. joints_own is
 * called only if q is near an end of g, where the contact may belong to another segment. */
static inline bool joints_active(const engine *e, size_t pair, const placed_segment *g,
                                 const nearest_point *q) {
  if (!g->shared || !q->active) return q->active;
  const double on = q->arc - g->arc, near = 1e-6 * e->state->radius[e->work.pairs.a[pair]];
  const bool straight = q->flat && g->piece == SD_PIECE_STRAIGHT;
  if (straight ? on >= near && on <= g->length - near : !g->meets) return true;
  return joints_own(e, pair, q);
}
/* Moves the contact of a disk that passes from one wall segment to the next. Called when the
 * contact of `pair` is about to open (closed: true) or to begin (closed: false). If the disk passes
 * a joint, the contact record is moved from the pair with one segment to the pair with the other,
 * so that no contact opens or begins. Returns true if a record was moved. */
bool joint_transfer(engine *e, size_t pair, bool closed);
/* Returns R_b of the second body of `pair`: the radius of a round body or an arc, negative if the
 * disk is inside; 0 for straight segments and end points. pair: a pair of round bodies, or a closed
 * contact with a wall segment. */
double joints_radius(const engine *e, size_t pair);
/* Returns the law of this pair, with the stiffnesses for its R_eff (law_at). */
sd_contact_law contact_law_of(const engine *e, size_t pair);

#endif
