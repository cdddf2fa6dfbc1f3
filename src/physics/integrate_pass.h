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

LANE_INLINE void LANE(gear_predict)(const columns *k, size_t i, double dt, double per_dt) {
  LANE(real) q1 = LANE(load)(k->v + i) * dt, q2 = LANE(load)(k->q2 + i), q3 = LANE(load)(k->q3 + i);
  LANE(real) q4 = LANE(load)(k->q4 + i), q5 = LANE(load)(k->q5 + i);
  LANE(store)(k->q + i, LANE(load)(k->q + i) + (q1 + (q2 + (q3 + (q4 + q5)))));
  LANE(store)(k->v + i, (q1 + (2.0 * q2 + (3.0 * q3 + (4.0 * q4 + 5.0 * q5)))) * per_dt);
  LANE(store)(k->q2 + i, q2 + (3.0 * q3 + (6.0 * q4 + 10.0 * q5)));
  LANE(store)(k->q3 + i, q3 + (4.0 * q4 + 10.0 * q5));
  LANE(store)(k->q4 + i, q4 + 5.0 * q5);
}

LANE_INLINE void LANE(gear_correct)(const columns *k, size_t i, double half_dt2, double per_dt) {
  LANE(real) force = LANE(load)(k->force + i) + LANE(load)(k->constant + i);
  LANE(real) error = half_dt2 * (force * LANE(load)(k->inverse + i)) - LANE(load)(k->q2 + i);
  LANE(store)(k->q + i, LANE(load)(k->q + i) + GEAR0 * error);
  LANE(store)(k->v + i, LANE(load)(k->v + i) + (GEAR1 * per_dt) * error);
  LANE(store)(k->q2 + i, LANE(load)(k->q2 + i) + error);
  LANE(store)(k->q3 + i, LANE(load)(k->q3 + i) + GEAR3 * error);
  LANE(store)(k->q4 + i, LANE(load)(k->q4 + i) + GEAR4 * error);
  LANE(store)(k->q5 + i, LANE(load)(k->q5 + i) + GEAR5 * error);
}

LANE_INLINE void LANE(verlet_predict)(const columns *k, size_t i, double dt, double per_dt) {
  LANE(real) v = LANE(load)(k->v + i), q2 = LANE(load)(k->q2 + i);
  LANE(store)(k->q + i, LANE(load)(k->q + i) + (v * dt + q2));
  LANE(store)(k->v + i, v + (2.0 * per_dt) * q2);
}

LANE_INLINE void LANE(verlet_correct)(const columns *k, size_t i, double half_dt2, double per_dt) {
  LANE(real) force = LANE(load)(k->force + i) + LANE(load)(k->constant + i);
  LANE(real) q2 = half_dt2 * (force * LANE(load)(k->inverse + i));
  LANE(store)(k->v + i, LANE(load)(k->v + i) + per_dt * (q2 - LANE(load)(k->q2 + i)));
  LANE(store)(k->q2 + i, q2);
}

/* Beyond the limit since the lists were built; a coordinate that is not a number is, too. */
LANE_INLINE int LANE(stale)(const engine *e, size_t i) {
  LANE(real) dx = LANE(load)(e->state->x + i) - LANE(load)(e->work.x0 + i);
  LANE(real) dy = LANE(load)(e->state->y + i) - LANE(load)(e->work.y0 + i);
  return LANE(any)(LANE(not )(dx * dx + dy * dy <= e->work.moved_limit2));
}

LANE_INLINE int LANE(out_of_range)(const engine *e, size_t i) {
  const work *w = &e->work;
  LANE(real)
  x = LANE(load)(e->state->x + i), y = LANE(load)(e->state->y + i), th = LANE(load)(e->state->theta + i);
  LANE(mask) out = (th > 4.0) | (th < -4.0);
  if (w->periodic[0]) out = out | (x < w->lower[0]) | (x >= w->upper[0]);
  if (w->periodic[1]) out = out | (y < w->lower[1]) | (y >= w->upper[1]);
  return LANE(any)(out);
}
