/* integrate_pass.h: predictor and corrector for LANE_WIDTH disks, one coordinate at a time;
 * included once per width after base/lane.h.
 *
 * Gear's fifth-order method for second-order equations, in Nordsieck form (docs/physics.md, section
 * 5): q2 to q5 hold dt^k/k! times the k-th derivative of q; v is the velocity itself. Velocity
 * Verlet uses q, v and q2 only; its forces are evaluated at the velocity predicted with the old
 * acceleration.
 */
#ifndef INTEGRATE_COMMON
#define INTEGRATE_COMMON
/* Gear's corrector coefficients. The first is 3/16 since forces depend on velocity (Allen &
 * Tildesley, Computer Simulation of Liquids, app. E). */
#define GEAR0 (3.0 / 16.0)
#define GEAR1 (251.0 / 360.0)
#define GEAR3 (11.0 / 18.0)
#define GEAR4 (1.0 / 6.0)
#define GEAR5 (1.0 / 60.0)
#endif

typedef struct LANE(nordsieck) {
  LANE(real) q, v, q2, q3, q4, q5;
} LANE(nordsieck);

/* a + b and a + factor b, 0 if subnormal: the derivatives of free disks decay until they are. */
LANE_INLINE LANE(real) LANE(plus)(LANE(real) a, LANE(real) b) { return LANE(normal)(a + b); }
LANE_INLINE LANE(real) LANE(plus_part)(LANE(real) a, LANE(real) factor, LANE(real) b) {
  return LANE(plus)(a, LANE(normal)(factor * b));
}

/* Predicts the coordinate and its derivatives by Taylor's formula. The binomial coefficients arise
 * from repeated additions. */
LANE_INLINE void LANE(gear_predict)(LANE(nordsieck) * c, LANE(real) dt, LANE(real) per_dt) {
  LANE(real) q1 = c->v * dt, q5 = c->q5;
  LANE(real) a4 = LANE(plus)(c->q4, q5), a3 = LANE(plus)(c->q3, a4), a2 = LANE(plus)(c->q2, a3);
  LANE(real) b4 = LANE(plus)(a4, q5), b3 = LANE(plus)(a3, b4), b2 = LANE(plus)(a2, b3);
  LANE(real) c4 = LANE(plus)(b4, q5), c3 = LANE(plus)(b3, c4), d4 = LANE(plus)(c4, q5);
  LANE(real) a1 = q1 + a2, b1 = a1 + b2;
  c->q = c->q + a1; /* q is rounded once: small terms added to it one by one would be lost */
  c->v = b1 * per_dt;
  c->q2 = LANE(plus)(b2, c3);
  c->q3 = LANE(plus)(c3, d4);
  c->q4 = LANE(plus)(d4, q5);
}

/* Corrects the coordinate and its derivatives. acceleration: dt^2/2 times the new acceleration. */
LANE_INLINE void LANE(gear_correct)(LANE(nordsieck) * c, LANE(real) acceleration,
                                    LANE(real) per_dt) {
  LANE(real) error = LANE(plus)(acceleration, -c->q2);
  c->q = LANE(plus_part)(c->q, LANE(splat)(GEAR0), error);
  c->v = LANE(plus_part)(c->v, GEAR1 * per_dt, error);
  c->q2 = LANE(plus)(c->q2, error);
  c->q3 = LANE(plus_part)(c->q3, LANE(splat)(GEAR3), error);
  c->q4 = LANE(plus_part)(c->q4, LANE(splat)(GEAR4), error);
  c->q5 = LANE(plus_part)(c->q5, LANE(splat)(GEAR5), error);
}

LANE_INLINE void LANE(verlet_predict)(LANE(nordsieck) * c, LANE(real) dt, LANE(real) per_dt) {
  c->q = c->q + (c->v * dt + c->q2);
  c->v = c->v + (2.0 * per_dt) * c->q2;
}

LANE_INLINE void LANE(verlet_correct)(LANE(nordsieck) * c, LANE(real) acceleration,
                                      LANE(real) per_dt) {
  c->v = c->v + per_dt * (acceleration - c->q2);
  c->q2 = acceleration;
}

/* Returns dt^2/2 times the acceleration by two forces. inverse: inverse mass, 0 for coordinates
 * that are held or prescribed. */
LANE_INLINE LANE(real) LANE(accelerate)(LANE(real) force, LANE(real) constant, LANE(real) inverse,
                                        LANE(real) half_dt2) {
  return force * (half_dt2 * inverse) + constant * (half_dt2 * inverse);
}

/* --- disks in columns ------------------------------------------------------------------------- */

#ifndef INTEGRATE_VIEW
#define INTEGRATE_VIEW

/* Pointers and constants of an engine that the loops need, copied so that the compiler does not
 * reload them after every store. view_of makes one for slots from `begin` on, as far as these slots
 * have consecutive rows. */
typedef struct view {
  columns k[SD_COORDINATES];
  /* mass, omega: NULL if no contact law needs them. x0, y0: positions when the lists were built */
  const double *radius, *mass, *omega, *x0, *y0;
  double *packed, *sums;
  size_t shift; /* slot + shift is the row of a disk in `packed` and `sums` */
  double dt, per_dt, half_dt2, moved_limit2, speed_limit2, lower[2], upper[2];
  bool periodic[2];
  const work_cell *cell; /* NULL: the box does not deform */
  bool show;             /* true: contact forces are also stored in the state */
  /* bodies in slots below this number have torques by rolling resistance (SUM_COUPLE) */
  size_t couples;
} view;

static inline view view_of(const engine *e, size_t begin) {
  const work *w = &e->work;
  view v = {.radius = e->state->radius,
            .mass = !(w->features & LAW_NORMAL) ? NULL
                    : w->clumps.count           ? w->clumps.contact_mass
                                                : e->state->mass,
            .omega = w->features & (LAW_DASHPOT | LAW_ROLLING) ? e->state->omega : NULL,
            .couples = w->features & LAW_ROLLING ? e->state->n_disks : 0,
            .x0 = w->x0,
            .y0 = w->y0,
            .packed = w->packed,
            .sums = w->sums.row,
            .shift = (size_t)w->row[begin] - begin,
            .dt = w->dt,
            .per_dt = w->per_dt,
            .half_dt2 = w->half_dt2,
            .moved_limit2 = w->moved_limit2,
            .speed_limit2 = w->speed_limit2,
            .cell = w->cell.on ? &w->cell : NULL,
            .show = w->predict_all || e->state->step + 1 >= w->show_from};
  for (int c = 0; c < SD_COORDINATES; c++) {
    v.k[c] = w->columns[c];
    if (w->nothing_constant[c]) v.k[c].constant = NULL;
  }
  for (int c = 0; c < 2; c++) {
    v.lower[c] = w->lower[c];
    v.upper[c] = w->upper[c];
    v.periodic[c] = w->periodic[c];
  }
  return v;
}
#endif

LANE_INLINE void LANE(gear_predict_at)(const columns *k, size_t i, LANE(real) dt, LANE(real) per_dt,
                                       LANE(nordsieck) * c) {
  c->q3 = LANE(load)(k->q3 + i);
  c->q4 = LANE(load)(k->q4 + i);
  c->q5 = LANE(load)(k->q5 + i);
  LANE(gear_predict)(c, dt, per_dt);
  LANE(store)(k->q2 + i, c->q2);
  LANE(store)(k->q3 + i, c->q3);
  LANE(store)(k->q4 + i, c->q4);
}

/* Writes the rows of packed bodies (work.packed: position, velocity and so on, for the pass over
 * pairs) of disks i, i + 1, ... */
LANE_INLINE void LANE(store_packed)(const view *v, size_t i, LANE(real) x, LANE(real) y,
                                    LANE(real) theta, LANE(real) vx, LANE(real) vy) {
  LANE(real) radius = LANE(load)(v->radius + i), zero = LANE(splat)(0.0);
  const LANE(real) pose[] = {
      [PACKED_X] = x, [PACKED_Y] = y, [PACKED_ARC] = radius * theta, [PACKED_RADIUS] = radius};
  const LANE(real) inverse_mass = v->mass ? 1.0 / LANE(load)(v->mass + i) : zero;
  const LANE(real) spin = v->omega ? radius * LANE(load)(v->omega + i) : zero;
  const LANE(real) speed[] = {vx, vy, inverse_mass, spin};
  double *row = v->packed + PACKED_ROW * (i + v->shift);
  LANE(scatter4)(row, PACKED_ROW, pose);
  LANE(scatter4)(row + PACKED_VX, PACKED_ROW, speed);
}

LANE_INLINE void LANE(pack_at)(const view *v, size_t i) {
  const columns *x = &v->k[SD_X], *y = &v->k[SD_Y];
  LANE(store_packed)
  (v, i, LANE(load)(x->q + i), LANE(load)(y->q + i), LANE(load)(v->k[SD_THETA].q + i),
   LANE(load)(x->v + i), LANE(load)(y->v + i));
}

/* Returns nonzero if a disk at (x, y) is farther than the limit from its position when the lists
 * were built, or if a coordinate is not a number. */
LANE_INLINE int LANE(is_stale)(const view *v, size_t i, LANE(real) x, LANE(real) y) {
  LANE(real) x0 = LANE(load)(v->x0 + i), y0 = LANE(load)(v->y0 + i), dx = x - x0, dy = y - y0;
  if (v->cell) { /* subtract the displacement of this point with the deforming box */
    x0 = x0 - v->lower[0];
    y0 = y0 - v->lower[1];
    dx = dx - (v->cell->shift[0] + (v->cell->map[0] * x0 + v->cell->map[2] * y0));
    dy = dy - (v->cell->shift[1] + v->cell->map[1] * y0);
  }
  return LANE(any)(LANE(not )(LANE(within)(dx * dx + dy * dy, LANE(splat)(v->moved_limit2))));
}

/* Clears the force sums of disks i, i + 1, ...; this also brings their rows into the cache. */
LANE_INLINE void LANE(clear_sum)(const view *v, size_t i) {
  const LANE(real) zero = LANE(splat)(0.0);
  double *sum = v->sums + SUM_ROW * (i + v->shift);
  for (size_t k = 0; k < SUM_ROW; k++) LANE(store)(sum + LANE_WIDTH * k, zero);
}

/* Predicts the coordinates of disks i, i + 1, ..., stores them in the state and in the packed
 * bodies, and clears the disks' force sums. */
LANE_INLINE void LANE(predict_at)(const view *v, size_t i, const int gear) {
  LANE(nordsieck) c[SD_COORDINATES];
  LANE(real) dt = LANE(splat)(v->dt), per_dt = LANE(splat)(v->per_dt);
  for (int n = 0; n < SD_COORDINATES; n++) {
    const columns *k = &v->k[n];
    c[n].q = LANE(load)(k->q + i);
    c[n].v = LANE(load)(k->v + i);
    c[n].q2 = LANE(load)(k->q2 + i);
    if (gear)
      LANE(gear_predict_at)(k, i, dt, per_dt, &c[n]);
    else
      LANE(verlet_predict)(&c[n], dt, per_dt);
    LANE(store)(k->q + i, c[n].q);
    LANE(store)(k->v + i, c[n].v);
  }
  LANE(store_packed)(v, i, c[SD_X].q, c[SD_Y].q, c[SD_THETA].q, c[SD_X].v, c[SD_Y].v);
  LANE(clear_sum)(v, i);
}

LANE_INLINE LANE(mask) LANE(beyond)(const view *v, int c, LANE(real) q) {
  return LANE(greater)(LANE(splat)(v->lower[c]), q) | LANE(within)(LANE(splat)(v->upper[c]), q);
}

LANE_INLINE LANE(mask)
    LANE(out_of_range)(const view *v, LANE(real) x, LANE(real) y, LANE(real) theta) {
  LANE(mask) out = LANE(greater)(theta, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), theta);
  if (v->periodic[0]) out = out | LANE(beyond)(v, 0, x);
  if (v->periodic[1]) out = out | LANE(beyond)(v, 1, y);
  return out;
}

/* Returns the lanes in which a disk exceeds the displacement limit (step.h): v^2 > limit2, with
 * limit2 = speed_limit2 R^2. */
LANE_INLINE LANE(mask) LANE(is_fast)(LANE(real) vx, LANE(real) vy, LANE(real) limit2) {
  return LANE(greater)(vx * vx + vy * vy, limit2);
}
LANE_INLINE LANE(mask) LANE(is_fast_at)(const view *v, size_t i, LANE(real) vx, LANE(real) vy) {
  LANE(real) radius = LANE(load)(v->radius + i);
  return LANE(is_fast)(vx, vy, radius * radius * LANE(splat)(v->speed_limit2));
}

/* Reads the contact forces and torques on disks i, i + 1, ... from the force sums; stores them in
 * sum[] and, if v->show is set, in the state. */
LANE_INLINE void LANE(take_sum)(const view *v, size_t i, LANE(real) sum[SD_COORDINATES]) {
  LANE(real) row[SUM_ROW];
  LANE(load4)(v->sums + SUM_ROW * (i + v->shift), SUM_ROW, row);
  sum[SD_X] = row[SUM_X];
  sum[SD_Y] = row[SUM_Y];
  sum[SD_THETA] = row[SUM_TORQUE] * LANE(load)(v->radius + i);
  if (i < v->couples) sum[SD_THETA] = sum[SD_THETA] + row[SUM_COUPLE];
  for (int n = 0; v->show && n < SD_COORDINATES; n++) LANE(store)(v->k[n].force + i, sum[n]);
}

/* Returns nonzero if one of disks i, i + 1, ... will have moved too far for the neighbour lists
 * after `ahead` steps; 0: has done so. */
LANE_INLINE int LANE(stale_at)(const view *v, size_t i, double ahead) {
  const columns *x = &v->k[SD_X], *y = &v->k[SD_Y];
  LANE(real) qx = LANE(load)(x->q + i), qy = LANE(load)(y->q + i), dt = LANE(splat)(v->dt);
  if (ahead != 0.0) {
    qx = qx + LANE(splat)(ahead) * (LANE(load)(x->v + i) * dt + LANE(load)(x->q2 + i));
    qy = qy + LANE(splat)(ahead) * (LANE(load)(y->v + i) * dt + LANE(load)(y->q2 + i));
  }
  return LANE(is_stale)(v, i, qx, qy);
}
