/* lanes_geometry.h: geometry of the pairs of small systems; included by lanes_pass.h. Free disks
 * are at their predicted positions, prescribed bodies where their motions put them. */

LANE_INLINE LANE(real)
    PASS(prescribed)(const lanes *l, const PASS(shape) * s, size_t slot, int which, int64_t at) {
  if (s->single) return LANE(splat)(l->pose[slot][which][at]);
  size_t stretch = (slot - s->n_free) * POSES + (size_t)which;
  return PASS(row)(l->poses + stretch * POSE_STEPS * LANE_WIDTH, (size_t)at);
}

/* Returns one component of a body's pose or velocity: the predicted one of a free disk, that at
 * index `at` of the batch for a prescribed body. */
LANE_INLINE LANE(real)
    PASS(pose)(const lanes *l, const PASS(shape) * s, const PASS(step_registers) * f, size_t slot,
               int which, int64_t at) {
  if (slot >= s->n_free) return PASS(prescribed)(l, s, slot, which, at);
  const LANE(nordsieck) *c = &f->c[slot][which % SD_COORDINATES];
  return which < SD_COORDINATES ? c->q : c->v;
}

/* Computes the tangential velocity dlambda/dt of pair k and, if laws need it, the rolling velocity,
 * with the formulas of pair_pass.h. */
LANE_INLINE void PASS(turning)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                               int64_t at, size_t k, const LANE(pair_input) * in) {
  size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  LANE(pair_geometry) *g = &f->geometry[k];
  LANE(pair_distance) d;
  LANE(pair_distance_of)(in, &d);
  LANE(real) ra = PASS(row)(p, PAIR_RA), rb = PASS(row)(p, PAIR_RB);
  LANE(real)
  spin_a = ra * f->c[a][SD_THETA].v, spin_b = rb * PASS(pose)(l, s, f, b, POSE_VX + SD_THETA, at);
  d.cross_velocity = in->dx * in->dvy - in->dy * in->dvx;
  g->slide = (spin_b + spin_a) - g->lever * (d.cross_velocity * d.inverse_r);
  if (!(s->features & LAW_ROLLING)) return;
  LANE(rolled)
  (ra, rb, ra * f->c[a][SD_THETA].q, rb * PASS(pose)(l, s, f, b, POSE_THETA, at), spin_a, spin_b,
   g);
}

/* Finds the point of a straight wall (line or segment, not turning) nearest to the disk, with the
 * same bits as walls_nearest. *flat: lanes in which this point is between the ends of the wall. */
LANE_INLINE LANE(pair_input)
    PASS(straight)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f, int64_t at,
                   size_t k, size_t a, size_t b, LANE(mask) * flat) {
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const double *w = PASS(straight_rows)(l, k);
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  const LANE(real) tx = PASS(row)(w, STRAIGHT_TX), ty = PASS(row)(w, STRAIGHT_TY),
                   x = f->c[a][SD_X].q, y = f->c[a][SD_Y].q;
  const LANE(real) wall_x = PASS(pose)(l, s, f, b, POSE_X, at),
                   wall_y = PASS(pose)(l, s, f, b, POSE_Y, at);
  const LANE(real) rx = x - (wall_x + PASS(row)(w, STRAIGHT_START_X)),
                   ry = y - (wall_y + PASS(row)(w, STRAIGHT_START_Y));
  const LANE(real) u = rx * tx + ry * ty, back = PASS(row)(w, STRAIGHT_BACK),
                   length = PASS(row)(w, STRAIGHT_LENGTH);
  const LANE(mask) before = LANE(greater)(back, u), beyond = LANE(greater)(u, length);
  const LANE(real) on = LANE(select)(before, back, LANE(select)(beyond, length, u));
  const LANE(real) here = LANE(select)(LANE(greater)(zero, tx * ry - ty * rx), -one, one),
                   kept = f->side[k];
  const LANE(mask) crossed =
      LANE(not )(LANE(equal)(kept, zero)) & LANE(not )(LANE(equal)(kept, here));
  const LANE(real) side = LANE(select)(crossed, kept, here);
  f->side[k] = side;
  f->crossed[k] = crossed;
  f->arm_x[k] = x - wall_x;
  f->arm_y[k] = y - wall_y;
  *flat = LANE(not )(before | beyond);
  return (LANE(pair_input)){.dx = on * tx - rx,
                            .dy = on * ty - ry,
                            .dvx = PASS(pose)(l, s, f, b, POSE_VX, at) - f->c[a][SD_X].v,
                            .dvy = PASS(pose)(l, s, f, b, POSE_VY, at) - f->c[a][SD_Y].v,
                            .sum = PASS(row)(p, PAIR_RA),
                            .arc = PASS(row)(p, PAIR_RA) * f->c[a][SD_THETA].q + side * on,
                            .ex = f->m[k].ex,
                            .ey = f->m[k].ey};
}

LANE_INLINE LANE(pair_input)
    PASS(round)(const lanes *l, const PASS(shape) * s, const PASS(step_registers) * f, int64_t at,
                size_t k, size_t a, size_t b) {
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  LANE(pair_input) in;
  in.dx = PASS(pose)(l, s, f, b, POSE_X, at) - f->c[a][SD_X].q;
  in.dy = PASS(pose)(l, s, f, b, POSE_Y, at) - f->c[a][SD_Y].q;
  in.dvx = PASS(pose)(l, s, f, b, POSE_VX, at) - f->c[a][SD_X].v;
  in.dvy = PASS(pose)(l, s, f, b, POSE_VY, at) - f->c[a][SD_Y].v;
  in.sum = PASS(row)(p, PAIR_SUM);
  in.arc = PASS(row)(p, PAIR_RA) * f->c[a][SD_THETA].q +
           PASS(row)(p, PAIR_RB) * PASS(pose)(l, s, f, b, POSE_THETA, at);
  in.ex = f->m[k].ex;
  in.ey = f->m[k].ey;
  return in;
}

/* Computes the geometry of pair k (distance, overlap, normal, velocities). With one free disk, pair
 * k is that of slots 0 and k + 1. */
LANE_INLINE void PASS(geometry)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                                int64_t at, size_t k) {
  size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
  if (PASS(is_straight)(l, k)) {
    LANE(mask) flat;
    const LANE(pair_input) in = PASS(straight)(l, s, f, at, k, a, b, &flat);
    f->geometry[k] = LANE(pair_geometry_of)(&in);
    f->lever[k] = LANE(select)(flat, LANE(splat)(1.0), f->geometry[k].lever);
    return;
  }
  const LANE(pair_input) in = PASS(round)(l, s, f, at, k, a, b);
  f->geometry[k] = LANE(pair_geometry_of)(&in);
  if (s->features & (LAW_DASHPOT | LAW_ROLLING)) PASS(turning)(l, s, f, at, k, &in);
}

/* Computes dlambda/dt of contacts that begin, for pair k: for straight walls with the formula of
 * slide_on in segment_pass.h, else with PASS(turning). */
LANE_INLINE void PASS(slide)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                             int64_t at, size_t k) {
  size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
  if (!PASS(is_straight)(l, k)) {
    const LANE(pair_input) in = PASS(round)(l, s, f, at, k, a, b);
    PASS(turning)(l, s, f, at, k, &in);
    return;
  }
  LANE(mask) flat;
  const LANE(pair_input) in = PASS(straight)(l, s, f, at, k, a, b, &flat);
  const LANE(real) r = LANE(sqrt)(in.dx * in.dx + in.dy * in.dy),
                   spin = in.sum * f->c[a][SD_THETA].v;
  const LANE(real) across = (in.dx * in.dvy - in.dy * in.dvx) / r;
  f->geometry[k].slide = LANE(select)(flat, spin - across, spin - in.sum / r * across);
}
