/* walls.h: pieces of walls in space, the point of a piece that is nearest to a disk, and joints, where
 * pieces meet. */
#ifndef PHYSICS_WALLS_H
#define PHYSICS_WALLS_H

#include <math.h>

#include "model/law_features.h"
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
static inline nearest_point walls_nearest_straight(const placed_segment *g, double x, double y) {
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

/* An arc owns the wedge between the directions of its ends; its ends push where a point is beyond them and not in the wedge.
 * Both may push: a large disk lies on the rims of a bowl. `left` of the way is the inner side. */
static inline nearest_point walls_nearest_arc(const placed_segment *g, double x, double y) {
  const double rx = x - g->x, ry = y - g->y, r = sqrt(rx * rx + ry * ry);
  const double after = g->fx * ry - g->fy * rx,
               before = g->lx * ry - g->ly * rx; /* the wedge: after >= 0 > before */
  const bool within = g->wide ? after >= 0.0 || before < 0.0 : after >= 0.0 && before < 0.0;
  nearest_point q = {.side = r < g->radius ? 1.0 : -1.0, .arc = g->arc};
  if (g->piece == SD_PIECE_CURVE) {
    const double scale = r > 0.0 ? (g->radius - r) / r : 0.0; /* the centre is nowhere near */
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

/* Lever of the tangential force between the ends of a piece: 1, on an arc (R_a + R_b)/r as for round bodies. */
static inline double walls_lever(const placed_segment *g, const nearest_point *q, double radius) {
  if (g->piece == SD_PIECE_STRAIGHT) return 1.0;
  /* radius of the disk, then of the circle; the way from the one's centre to the other's */
  const double sum = radius - q->side * g->radius, way = hypot(q->dx, q->dy) - q->side * g->radius;
  return sum / way;
}

/* R_b of the piece: of an arc that of a round wall, negative inside; 0: straight pieces and ends. side: of the disk. */
static inline double walls_radius(const placed_segment *g, double side) {
  return g->piece == SD_PIECE_CURVE ? -side * g->radius : 0.0;
}

/* R_eff of a disk's rolling on a piece whose radius is rb, as `rolled` has it. */
static inline double walls_arm(double ra, double rb) {
  return rb != 0.0 && ra + rb == 0.0 ? ra * rb : law_arm(ra, rb);
}

/* Arc length at an end of a piece; end 0: where it starts. */
static inline double walls_arc_at(const placed_segment *g, int end) {
  if (g->piece == SD_PIECE_CURVE) return g->arc + (end ? 0.5 : -0.5) * g->length;
  return g->arc + (end ? g->length : 0.0);
}

static inline nearest_point walls_nearest(const placed_segment *g, double x, double y) {
  return g->piece == SD_PIECE_STRAIGHT ? walls_nearest_straight(g, x, y)
                                       : walls_nearest_arc(g, x, y);
}

/* The image of a piece that is nx, ny periods away. */
static inline void walls_shift(const double length[2], double nx, double ny, placed_segment *g) {
  g->shift_x = length[0] * nx;
  g->shift_y = length[1] * ny;
  g->x += g->shift_x;
  g->y += g->shift_y;
  /* as the start of that piece's own image, to the last digit: no point belongs to both, or to none */
  g->end_x += length[0] * (nx + g->cells[0]);
  g->end_y += length[1] * (ny + g->cells[1]);
}

/* How many periods away the image is whose middle is nearest to (x, y). length: of the periodic box. */
static inline void walls_periods(const double length[2], const placed_segment *g, double x,
                                 double y, double n[2]) {
  n[0] = g->image[0] ? nearbyint((x - (g->x + g->middle_x)) / length[0]) : 0.0;
  n[1] = g->image[1] ? nearbyint((y - (g->y + g->middle_y)) / length[1]) : 0.0;
}

/* The nearest image of a piece: that whose middle is nearest to (x, y), since pieces are short (model/walls.h). Returns g itself
 * where it has no images, else `image`. */
static inline const placed_segment *walls_image(const double length[2], const placed_segment *g,
                                                double x, double y, placed_segment *image) {
  if (!(g->image[0] || g->image[1])) return g;
  double n[2];
  walls_periods(length, g, x, y, n);
  *image = *g;
  walls_shift(length, n[0], n[1], image);
  return image;
}

/* The box around a piece; infinite for a line. */
void walls_bounds(const placed_segment *g, double lower[2], double upper[2]);

/* A piece of a wall whose pivot, and cosine and sine of whose angle these are; without the start of the next piece. */
placed_segment walls_place(const sd_segment *from, double x, double y, double c, double i,
                           double scale);

/* Brings every piece to its wall's present pose. */
void walls_pose(engine *e);
/* The same for those in the list of pairs: the others may be left where they were, until walls_pose. */
void walls_pose_listed(engine *e);

/* Pieces of walls that meet: of which of them a disk touches the joint, and a contact that goes from one to the next. */

/* Several pieces may meet in point q of pair k's piece: does the disk touch this one there? */
bool joints_own(const engine *e, size_t pair, const nearest_point *q);
/* The same for any point of piece g, that of pair k: joints are near its ends only. */
static inline bool joints_active(const engine *e, size_t pair, const placed_segment *g,
                                 const nearest_point *q) {
  if (!g->shared || !q->active) return q->active;
  const double on = q->arc - g->arc, near = 1e-6 * e->state->radius[e->work.pairs.a[pair]];
  const bool straight = q->flat && g->piece == SD_PIECE_STRAIGHT;
  if (straight ? on >= near && on <= g->length - near : !g->meets) return true;
  return joints_own(e, pair, q);
}
/* Pair k is about to open or begin, `closed` says which. If its disk goes from one piece to the next here, the contact goes along with all that
 * it remembers: nothing opens, and nothing begins. */
bool joints_hand_over(engine *e, size_t pair, bool closed);
/* R_b of a round wall and of an arc (negative inside), 0 of straight pieces and ends. k: a closed contact with a piece, or a
 * round pair. */
double joints_radius(const engine *e, size_t pair);

#endif
