/* walls.c: wall segments at the present poses of their walls, and joints of segments; implements
 * walls.h. */
#include "physics/contact/walls.h"

#include <assert.h>
#include <math.h>

#include "base/math.h"
#include "model/model.h"
#include "model/normal_laws.h"
#include "physics/contact/pairs.h"
#include "physics/system/bodies.h"

/* Pose of one wall. The segments of a wall have consecutive numbers, so that its pose is computed
 * once for all of them. */
typedef struct wall_pose {
  uint32_t body; /* number of the wall among all bodies */
  bool known;    /* false: the members below are not set */
  /* x, y: pivot; c, i: cosine and sine of the wall's angle; scale: ratio of present lengths to
   * those in the model */
  double x, y, c, i, scale;
} wall_pose;

/* Sets (*x, *y) to the vector `from`, rotated by the angle with cosine c and sine i. */
static void turn_by(double c, double i, const double from[2], double *x, double *y) {
  *x = c * from[0] - i * from[1];
  *y = i * from[0] + c * from[1];
}

/* Sets the members of *g that only arcs and their end points have: radius, and directions of the
 * ends and the middle. g->arc becomes the arc length along the wall at the middle of the arc. */
static void place_arc(const sd_segment *from, double c, double i, placed_segment *g) {
  g->piece = from->piece;
  g->radius = from->radius;
  g->wide = from->wide;
  g->joined = false;
  g->arc = from->arc + 0.5 * from->length;
  turn_by(c, i, from->first, &g->fx, &g->fy);
  turn_by(c, i, from->last, &g->lx, &g->ly);
  turn_by(c, i, from->middle, &g->mx, &g->my);
}

void walls_bounds(const placed_segment *g, double lower[2], double upper[2]) {
  if (g->piece == SD_PIECE_STRAIGHT) {
    const bool line = g->backwards < 0.0;
    const double from[2] = {g->x, g->y}, along[2] = {g->tx, g->ty};
    for (int c = 0; c < 2; c++) {
      const double to = from[c] + (line ? 0.0 : g->length * along[c]);
      lower[c] = line ? -HUGE_VAL : math_min(from[c], to);
      upper[c] = line ? HUGE_VAL : math_max(from[c], to);
    }
    return;
  }
  const double center[2] = {g->x, g->y};
  for (int c = 0; c < 2; c++)
    for (int side = -1; side <= 1; side += 2) {
      /* (ux, uy): unit vector towards this edge of the bounding box. If the arc contains this
       * direction, the edge is that of the circle, else the end of the arc that is farther in this
       * direction. */
      const double ux = c == 0 ? side : 0.0, uy = c == 1 ? side : 0.0;
      const bool curve = g->piece == SD_PIECE_CURVE;
      const nearest_point q = walls_nearest_arc(g, g->x + g->radius * ux, g->y + g->radius * uy);
      const double first = c ? g->fy : g->fx, last = c ? g->ly : g->lx;
      const double end = g->piece == SD_PIECE_FIRST_END  ? first
                         : g->piece == SD_PIECE_LAST_END ? last
                         : side > 0                      ? math_max(first, last)
                                                         : math_min(first, last);
      const double edge = center[c] + g->radius * (curve && q.active ? side : end);
      if (side > 0)
        upper[c] = edge;
      else
        lower[c] = edge;
    }
}

/* Sets (*x, *y) to the position in space of the point `from`, given in the frame of the wall. */
static void point_of(const wall_pose *w, const double from[2], double *x, double *y) {
  *x = w->x + w->scale * (w->c * from[0] - w->i * from[1]);
  *y = w->y + w->scale * (w->i * from[0] + w->c * from[1]);
}

static placed_segment place(const sd_segment *from, const wall_pose *w) {
  placed_segment g = {.c = w->c,
                      .i = w->i,
                      .length = from->length,
                      .backwards = from->length < HUGE_VAL ? 0.0 : -HUGE_VAL,
                      .arc = from->arc,
                      .end_cap = from->end_cap,
                      .joined = from->next >= 0,
                      .image = {from->image[0], from->image[1]},
                      .cells = {from->cells[0], from->cells[1]},
                      .shared = from->vertex[0] || from->vertex[1],
                      .meets = from->meets[0] || from->meets[1]};
  point_of(w, from->start, &g.x, &g.y);
  turn_by(w->c, w->i, from->tangent, &g.tx, &g.ty);
  turn_by(w->c, w->i, from->previous, &g.px, &g.py);
  turn_by(w->c, w->i, from->center, &g.middle_x, &g.middle_y);
  if (from->piece != SD_PIECE_STRAIGHT) place_arc(from, w->c, w->i, &g);
  return g;
}

placed_segment walls_place(const sd_segment *from, double x, double y, double c, double i,
                           double scale) {
  return place(from, &(wall_pose){.x = x, .y = y, .c = c, .i = i, .scale = scale});
}

/* Moves segment k to the present pose of its wall. *wall: pose of the wall of the segment before;
 * replaced by the pose of this wall if it is another one. */
static void pose_piece(engine *e, size_t k, wall_pose *wall) {
  const sd_state *s = e->state;
  const sd_segment *from = &e->model->segments[k];
  placed_segment *g = &e->work.segments[k];
  if (!wall->known || wall->body != from->body) {
    const uint32_t b = slot_of(&e->work.slots, from->body);
    assert(b >= s->n_disks && b < s->n_bodies && s->radius[b] == 0.0);
    const double angle = s->theta[b] + s->turn[b];
    double sine, cosine;
    math_sine_cosine(angle, &sine, &cosine);
    *wall = (wall_pose){from->body, true, s->x[b], s->y[b], cosine, sine, s->box_scale};
  }
  /* if the wall has not turned since, only its points move, not its directions */
  if (g->c == wall->c && g->i == wall->i)
    point_of(wall, from->start, &g->x, &g->y);
  else
    *g = place(from, wall);
  if (!g->joined) return;
  assert((size_t)from->next < e->model->n_segments);
  point_of(wall, e->model->segments[from->next].start, &g->end_x, &g->end_y);
}

void walls_pose(engine *e) {
  wall_pose wall = {.known = false};
  for (size_t k = 0; k < e->model->n_segments; k++) pose_piece(e, k, &wall);
}

void walls_pose_listed(engine *e) {
  wall_pose wall = {.known = false};
  for (size_t k = 0; k < e->work.n_pieces; k++) pose_piece(e, e->work.pieces[k], &wall);
}

/* --- segments that meet ----------------------------------------------------------------------- */

/* piece_of returns the segment of pair k as it is in the model, placed() the same segment in
 * space. */
static const sd_segment *piece_of(const engine *e, size_t k) {
  return &e->model->segments[e->work.pairs.part[k]];
}

static const placed_segment *placed(const engine *e, size_t k) {
  return &e->work.segments[e->work.pairs.part[k]];
}

/* Returns the point of pair k's wall segment that is nearest to the pair's disk. */
static nearest_point nearest_on(const engine *e, size_t k) {
  const int32_t a = e->work.pairs.a[k];
  const double x = e->state->x[a], y = e->state->y[a];
  placed_segment image;
  return walls_nearest(walls_image(e->work.length, placed(e, k), x, y, &image), x, y);
}

/* Returns which end of a segment lies at `vertex`: 0 the start, 1 the far end, -1 neither. */
static int end_at(const sd_segment *s, uint32_t vertex) {
  return s->vertex[0] == vertex ? 0 : s->vertex[1] == vertex ? 1 : -1;
}

/* Finds the range [begin, end) of all pairs with wall segments that have the same disk as pair
 * k. */
static void pairs_beside(const pairs *p, size_t k, size_t *begin, size_t *end) {
  *begin = k;
  *end = k + 1;
  while (*begin > p->first_segment && p->a[*begin - 1] == p->a[k]) --*begin;
  while (*end < p->count && p->a[*end] == p->a[k]) ++*end;
}

/* Joint of two segments (from, to), which have one end each at the same vertex. */
typedef struct joint {
  const placed_segment *from, *to;
  int from_end, to_end; /* end of each segment that lies at the joint: 0 the start, 1 the far end */
} joint;

/* Sets at[] to the position of an end of segment g: 0 the start, 1 the far end. */
static void vertex_point(const placed_segment *g, int end, double at[2]) {
  if (g->piece == SD_PIECE_STRAIGHT) {
    at[0] = g->x + (end ? g->length * g->tx : 0.0);
    at[1] = g->y + (end ? g->length * g->ty : 0.0);
    return;
  }
  at[0] = g->x + g->radius * (end ? g->lx : g->fx);
  at[1] = g->y + g->radius * (end ? g->ly : g->fy);
}

/* Finds the joint of the segments of two pairs (from, to), which have the same disk. If the
 * segments meet at both ends, the joint nearer to the disk is taken. Returns false if they do not
 * meet. */
static bool joint_of(const engine *e, size_t from, size_t to, joint *found) {
  const sd_segment *p = piece_of(e, from), *q = piece_of(e, to);
  const double x = e->state->x[e->work.pairs.a[from]], y = e->state->y[e->work.pairs.a[from]];
  double nearest = HUGE_VAL, at[2];
  for (int end = 0; end < 2; end++) {
    const int other = p->vertex[end] ? end_at(q, p->vertex[end]) : -1;
    if (other < 0) continue;
    const joint here = {placed(e, from), placed(e, to), end, other};
    placed_segment image;
    vertex_point(walls_image(e->work.length, here.from, x, y, &image), end, at);
    const double distance = math_hypot(at[0] - x, at[1] - y);
    if (distance < nearest) *found = here;
    nearest = math_min(nearest, distance);
  }
  return nearest < HUGE_VAL;
}

/* --- ownership of the nearest point ----------------------------------------------------------- */

/* Returns which end of segment g is the nearest point q: 0 the start, 1 the far end. */
static int end_of(const placed_segment *g, const nearest_point *q) {
  if (g->piece != SD_PIECE_STRAIGHT) return g->piece == SD_PIECE_LAST_END;
  return q->arc - g->arc > 0.5 * g->length;
}

/* Returns true if the nearest point q of pair k, between the ends of the segment, also lies on the
 * segment of an earlier pair of the same disk. This happens if the two segments form one straight
 * line. */
static bool is_of_earlier(const engine *e, size_t k, const nearest_point *q) {
  /* points nearer to each other than radius/SAME count as the same point */
  enum { SAME = 1000000000 };
  const pairs *p = &e->work.pairs;
  const double near = e->state->radius[p->a[k]] / SAME;
  size_t begin, end;
  joint unused;
  pairs_beside(p, k, &begin, &end);
  for (size_t j = begin; j < k; j++) {
    if (!joint_of(e, j, k, &unused)) continue;
    const nearest_point other = nearest_on(e, j);
    if (other.flat && fabs(other.dx - q->dx) <= near && fabs(other.dy - q->dy) <= near) return true;
  }
  return false;
}

/* Returns true if the contact at the vertex at which nearest point q lies belongs to pair k. If the
 * ends of several walls meet there, it belongs to the first pair, and only if the disk is beyond
 * the ends of all these walls. */
static bool owns_vertex(const engine *e, size_t k, const nearest_point *q) {
  const pairs *p = &e->work.pairs;
  const sd_segment *own = piece_of(e, k);
  const int end_here = end_of(placed(e, k), q);
  size_t begin, end;
  if (!own->meets[end_here]) return true;
  pairs_beside(p, k, &begin, &end);
  for (size_t j = begin; j < end; j++) {
    const sd_segment *piece = piece_of(e, j);
    const placed_segment *g = placed(e, j);
    const int there = end_at(piece, own->vertex[end_here]);
    if (j == k || there < 0) continue;
    const nearest_point other = nearest_on(e, j);
    if (other.flat) return false;
    if (g->piece == SD_PIECE_CURVE) continue; /* skip the arc: its end is a segment of its own */
    if (g->piece != SD_PIECE_STRAIGHT ? !other.active : end_of(g, &other) != there) return false;
    if (j < k) return false;
  }
  return true;
}

bool joints_own(const engine *e, size_t k, const nearest_point *q) {
  return q->flat ? !is_of_earlier(e, k, q) : owns_vertex(e, k, q);
}

/* --- history ---------------------------------------------------------------------------------- */

double joints_radius(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  return pairs_is_segment(p, k) ? walls_radius(placed(e, k), p->side[k])
                                : e->state->radius[p->b[k]];
}

/* Returns true if the contact of pair k would stay closed at the present coordinates, by the same
 * test as contact_touches in contact_step.h. */
static bool holds(const engine *e, size_t k, bool bonded) {
  const pairs *p = &e->work.pairs;
  const nearest_point q = nearest_on(e, k);
  const double r = sqrt(math_max(q.dx * q.dx + q.dy * q.dy, 1e-280));
  return joints_active(e, k, placed(e, k), &q) &&
         (bonded || e->state->radius[p->a[k]] - r > -e->work.laws[PAIR(p, k, law)].ends);
}

sd_contact_law contact_law_of(const engine *e, size_t k) {
  const double radius = e->state->radius[e->work.pairs.a[k]];
  return law_at(&e->model->laws[PAIR(&e->work.pairs, k, law)],
                walls_arm(radius, joints_radius(e, k)));
}

/* Returns the elastic energy of this contact record on the segment of pair k, from which R_eff is
 * taken. */
static double energy_on(const engine *e, size_t k, const sd_contact_record *r) {
  const sd_contact_law law = contact_law_of(e, k);
  const double delta = math_max(r->overlap, 0.0);
  const bool mindlin = law.tangential == SD_TANGENTIAL_MINDLIN;
  return law_energy(&law, delta) +
         0.5 * law.k_t * (mindlin ? sqrt(delta) : 1.0) * r->zeta * r->zeta;
}

/* Moves the record of a closed contact from pair `from` to pair `to`, through joint j.
 * lambda_ref is adjusted so that lambda - lambda* stays the same, although the arc length
 * differs on the two segments (its sign changes if they run in opposite directions). rho_ref is
 * adjusted so that the rolling displacement stays the same if R_eff changes; likewise the
 * references of a bond. If the stiffness depends on R_eff, the elastic energy changes at the
 * joint of an arc; the difference counts as viscous loss. */
static void move_contact(engine *e, size_t from, size_t to, const joint *j) {
  const sd_state *s = e->state;
  pairs *p = &e->work.pairs;
  const size_t a = (size_t)p->a[from], b = (size_t)p->b[from], c = (size_t)p->b[to];
  assert(pairs_closed(p, from) && !pairs_closed(p, to) && fabs(p->side[from]) == 1.0);
  assert(j->from && j->to);
  sd_contact_record record = pairs_record(p, from);
  const double arm = walls_arm(s->radius[a], joints_radius(e, from));
  /* ahead: the two segments run in the same direction; this holds for an arc and its own end point,
   * too */
  const bool ahead = j->from_end != j->to_end || (b == c && j->from->piece != j->to->piece);
  const double side = ahead ? p->side[from] : -p->side[from];
  const double arcs =
      side * walls_arc_at(j->to, j->to_end) - p->side[from] * walls_arc_at(j->from, j->from_end);
  const double surfaces = body_surface(s, c) - body_surface(s, b);
  record.lambda_ref += arcs;
  record.lambda_ref -= surfaces;
  p->side[to] = side;
  if (e->work.features & LAW_ROLLING) {
    const double turned =
        walls_arm(s->radius[a], joints_radius(e, to)) * (s->theta[a] - s->theta[c]) -
        arm * (s->theta[a] - s->theta[b]);
    record.rho_ref += turned;
    if (record.bond > 0.0) record.bond_rho += turned;
  }
  if (record.bond > 0.0) record.bond_lambda += arcs - surfaces;
  if (e->work.features & LAW_RADIUS)
    record.viscous += energy_on(e, from, &record) - energy_on(e, to, &record);
  pairs_set_record(p, to, &record);
  pairs_set_flags(p, to, true, pairs_slide_sign(p, from));
  pairs_set_record(p, from, &(sd_contact_record){0});
  pairs_set_flags(p, from, false, 0);
  p->side[from] = 0.0;
}

bool joint_transfer(engine *e, size_t k, bool closed) {
  const pairs *p = &e->work.pairs;
  size_t begin, end;
  joint found = {0};
  if (!placed(e, k)->shared || pairs_closed(p, k) != closed)
    return false; /* the segment has no joint, or the contact has already been moved */
  pairs_beside(p, k, &begin, &end);
  for (size_t j = begin; j < end; j++) {
    if (j == k || pairs_closed(p, j) == closed || PAIR(p, j, law) != PAIR(p, k, law)) continue;
    const size_t from = closed ? k : j, to = closed ? j : k;
    const bool bonded = p->more && MORE(p, from, bond) > 0.0;
    if (!joint_of(e, from, to, &found) || holds(e, j, bonded) != closed) continue;
    move_contact(e, from, to, &found);
    return true;
  }
  return false;
}
