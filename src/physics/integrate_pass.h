/* integrate_pass.h: predictor and corrector of LANE_WIDTH disks, one coordinate at a time; included once per
 * width after base/lane.h.
 *
 * Gear, fifth order, Nordsieck form for second-order equations (physics.md 4): column k holds dt^k/k! times
 * the k-th derivative; velocities are kept as such. Velocity Verlet uses column 2 only; its forces see the
 * velocity predicted with the old acceleration.
 */
#ifndef INTEGRATE_COMMON
#define INTEGRATE_COMMON
/* 3/16 because the forces depend on velocity (Allen & Tildesley, Computer Simulation of Liquids, app. E). */
#define GEAR0 (3.0 / 16.0)
#define GEAR1 (251.0 / 360.0)
#define GEAR3 (11.0 / 18.0)
#define GEAR4 (1.0 / 6.0)
#define GEAR5 (1.0 / 60.0)
#endif

typedef struct LANE(nordsieck) {
  LANE(real) q, v, q2, q3, q4, q5;
} LANE(nordsieck);

/* Binomial sums by repeated addition. */
LANE_INLINE void LANE(gear_predict)(LANE(nordsieck) * c, LANE(real) dt, LANE(real) per_dt) {
  LANE(real) q1 = c->v * dt, q5 = c->q5;
  LANE(real) a4 = c->q4 + q5, a3 = c->q3 + a4, a2 = c->q2 + a3, a1 = q1 + a2;
  LANE(real) b4 = a4 + q5, b3 = a3 + b4, b2 = a2 + b3, b1 = a1 + b2;
  LANE(real) c4 = b4 + q5, c3 = b3 + c4, d4 = c4 + q5;
  c->q = c->q + a1; /* rounded once, or small corrections would be lost one by one */
  c->v = b1 * per_dt;
  c->q2 = b2 + c3;
  c->q3 = c3 + d4;
  c->q4 = d4 + q5;
}

/* acceleration: dt^2/2 of it */
LANE_INLINE void LANE(gear_correct)(LANE(nordsieck) * c, LANE(real) acceleration, LANE(real) per_dt) {
  LANE(real) error = acceleration - c->q2;
  c->q = c->q + GEAR0 * error;
  c->v = c->v + (GEAR1 * per_dt) * error;
  c->q2 = c->q2 + error;
  c->q3 = c->q3 + GEAR3 * error;
  c->q4 = c->q4 + GEAR4 * error;
  c->q5 = c->q5 + GEAR5 * error;
}

LANE_INLINE void LANE(verlet_predict)(LANE(nordsieck) * c, LANE(real) dt, LANE(real) per_dt) {
  c->q = c->q + (c->v * dt + c->q2);
  c->v = c->v + (2.0 * per_dt) * c->q2;
}

LANE_INLINE void LANE(verlet_correct)(LANE(nordsieck) * c, LANE(real) acceleration, LANE(real) per_dt) {
  c->v = c->v + per_dt * (acceleration - c->q2);
  c->q2 = acceleration;
}

/* dt^2/2 times the acceleration; inverse: of the mass, 0 where nothing moves. */
LANE_INLINE LANE(real)
    LANE(accelerate)(LANE(real) force, LANE(real) constant, LANE(real) inverse, LANE(real) half_dt2) {
  return force * (half_dt2 * inverse) + constant * (half_dt2 * inverse);
}

/* The same of disks i ... in columns. */
LANE_INLINE LANE(nordsieck) LANE(nordsieck_load)(const columns *k, size_t i) {
  return (LANE(nordsieck)){.q = LANE(load)(k->q + i),
                           .v = LANE(load)(k->v + i),
                           .q2 = LANE(load)(k->q2 + i),
                           .q3 = LANE(load)(k->q3 + i),
                           .q4 = LANE(load)(k->q4 + i),
                           .q5 = LANE(load)(k->q5 + i)};
}

LANE_INLINE void LANE(nordsieck_store)(const columns *k, size_t i, const LANE(nordsieck) * c) {
  LANE(store)(k->q + i, c->q);
  LANE(store)(k->v + i, c->v);
  LANE(store)(k->q2 + i, c->q2);
  LANE(store)(k->q3 + i, c->q3);
  LANE(store)(k->q4 + i, c->q4);
  LANE(store)(k->q5 + i, c->q5);
}

LANE_INLINE LANE(real) LANE(acceleration_at)(const columns *k, size_t i, double half_dt2) {
  return LANE(accelerate)(LANE(load)(k->force + i), LANE(load)(k->constant + i), LANE(load)(k->inverse + i),
                          LANE(splat)(half_dt2));
}

LANE_INLINE void LANE(gear_predict_at)(const columns *k, size_t i, double dt, double per_dt) {
  LANE(nordsieck) c = LANE(nordsieck_load)(k, i);
  LANE(gear_predict)(&c, LANE(splat)(dt), LANE(splat)(per_dt));
  LANE(nordsieck_store)(k, i, &c);
}

LANE_INLINE void LANE(gear_correct_at)(const columns *k, size_t i, double half_dt2, double per_dt) {
  LANE(nordsieck) c = LANE(nordsieck_load)(k, i);
  LANE(gear_correct)(&c, LANE(acceleration_at)(k, i, half_dt2), LANE(splat)(per_dt));
  LANE(nordsieck_store)(k, i, &c);
}

LANE_INLINE void LANE(verlet_predict_at)(const columns *k, size_t i, double dt, double per_dt) {
  LANE(nordsieck) c = {.q = LANE(load)(k->q + i), .v = LANE(load)(k->v + i), .q2 = LANE(load)(k->q2 + i)};
  LANE(verlet_predict)(&c, LANE(splat)(dt), LANE(splat)(per_dt));
  LANE(store)(k->q + i, c.q);
  LANE(store)(k->v + i, c.v);
}

LANE_INLINE void LANE(verlet_correct_at)(const columns *k, size_t i, double half_dt2, double per_dt) {
  LANE(nordsieck) c = {.v = LANE(load)(k->v + i), .q2 = LANE(load)(k->q2 + i)};
  LANE(verlet_correct)(&c, LANE(acceleration_at)(k, i, half_dt2), LANE(splat)(per_dt));
  LANE(store)(k->v + i, c.v);
  LANE(store)(k->q2 + i, c.q2);
}

/* Beyond the limit since the lists were built; a coordinate that is not a number is, too. */
LANE_INLINE int LANE(stale)(const engine *e, size_t i) {
  LANE(real) dx = LANE(load)(e->state->x + i) - LANE(load)(e->work.x0 + i);
  LANE(real) dy = LANE(load)(e->state->y + i) - LANE(load)(e->work.y0 + i);
  return LANE(any)(LANE(not )(LANE(within)(dx * dx + dy * dy, LANE(splat)(e->work.moved_limit2))));
}

LANE_INLINE int LANE(out_of_range)(const engine *e, size_t i) {
  const work *w = &e->work;
  LANE(real) x = LANE(load)(e->state->x + i), y = LANE(load)(e->state->y + i);
  LANE(real) th = LANE(load)(e->state->theta + i);
  LANE(mask) out = LANE(greater)(th, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), th);
  if (w->periodic[0])
    out = out | LANE(greater)(LANE(splat)(w->lower[0]), x) | LANE(within)(LANE(splat)(w->upper[0]), x);
  if (w->periodic[1])
    out = out | LANE(greater)(LANE(splat)(w->lower[1]), y) | LANE(within)(LANE(splat)(w->upper[1]), y);
  return LANE(any)(out);
}

/* Rows of SEAT_ROW numbers. */
LANE_INLINE void LANE(seat_at)(engine *e, size_t i) {
  const sd_state *s = e->state;
  double *row = e->work.seats + SEAT_ROW * i;
  LANE(real) radius = LANE(load)(s->radius + i);
  const LANE(real)
      pose[] = {LANE(load)(s->x + i), LANE(load)(s->y + i), radius * LANE(load)(s->theta + i), radius};
  const LANE(real)
      speed[] = {LANE(load)(s->vx + i), LANE(load)(s->vy + i), LANE(splat)(0.0), LANE(splat)(0.0)};
  LANE(lay4)(row, SEAT_ROW, pose);
  LANE(lay4)(row + SEAT_VX, SEAT_ROW, speed);
}
