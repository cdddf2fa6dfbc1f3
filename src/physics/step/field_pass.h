/* field_pass.h: forces of the model's force fields on LANE_WIDTH disks, at the coordinates of one
 * step; included once per width after integrate_pass.h.
 *
 * Every field is the sum of a force that depends on position and one that is linear in velocity:
 * (X, Y) - f (v - u) + b (v_y, -v_x), with torque -f_r (omega - w). f, f_r: drag coefficients; u,
 * w: velocity and rotation of the flow; b: Coriolis coefficient. Both integrators correct the
 * velocity to v = v_predicted + kappa (a(v) dt^2/2 - q2); the v in a(v) is this corrected velocity,
 * found from two linear equations. So Coriolis forces do no work, and strong drag is stable.
 * Cundall's damping is a fraction alpha of the sum of all other forces, contacts and gravity
 * included, against the direction of this velocity (P. A. Cundall, in: Analytical and Computational
 * Methods in Engineering Rock Mechanics, ed. E. T. Brown, 1987, p. 129).
 */

/* Coefficients of the equations above for a disk, summed over all fields. place: (X, Y); drag: f,
 * f_r; flow: f u_x, f u_y, f_r w; flow2: f u_x^2, f u_y^2, f_r w^2; turn: b; alpha: fractions of
 * Cundall's damping, for forces and torque. */
typedef struct LANE(field_sum) {
  LANE(real) place[2], drag[2], flow[SD_COORDINATES], flow2[SD_COORDINATES], turn, alpha[2];
} LANE(field_sum);

/* Force (x, y) and torque of all fields on a disk. force: without Cundall's damping; damped:
 * Cundall's damping; total: both, plus the constant forces. */
typedef struct LANE(field_force) {
  LANE(field_sum) s;
  LANE(real) force[SD_COORDINATES], damped[SD_COORDINATES], total[SD_COORDINATES];
} LANE(field_force);

/* Position of a disk relative to the centre of a field, the factors by which the field's force
 * and torque on this disk are multiplied, and the field's acceleration at this step. */
typedef struct LANE(field_place) {
  LANE(real) x, y, weight, turn_weight;
  const double *push; /* acceleration (x, y) of a turning gravity at this step */
} LANE(field_place);

LANE_INLINE void LANE(drag_field)(const sd_body_force *f, const LANE(field_place) * p,
                                  LANE(field_sum) * s) {
  const LANE(real) drag[2] = {f->gamma * p->weight, f->gamma_rotation * p->turn_weight};
  const LANE(real) u[SD_COORDINATES] = {f->flow[0] + (f->shear_rate - f->swirl) * p->y,
                                        f->flow[1] + f->swirl * p->x,
                                        LANE(splat)(f->swirl - 0.5 * f->shear_rate)};
  for (int c = 0; c < SD_COORDINATES; c++) {
    const LANE(real) flow = drag[c == SD_THETA] * u[c];
    s->flow[c] = s->flow[c] + flow;
    s->flow2[c] = s->flow2[c] + flow * u[c];
  }
  for (int k = 0; k < 2; k++) s->drag[k] = s->drag[k] + drag[k];
}

LANE_INLINE void LANE(damping_field)(const sd_body_force *f, const LANE(field_place) * p,
                                     LANE(field_sum) * s) {
  s->alpha[0] = s->alpha[0] + f->alpha * p->weight;
  s->alpha[1] = s->alpha[1] + f->alpha_rotation * p->weight;
}

/* Force towards a centre, strength (r^2 + softening^2)^((power - 1)/2) times the vector to it. A
 * disk exactly at the centre gets no force. */
LANE_INLINE void LANE(central_field)(const sd_body_force *f, const LANE(field_place) * p,
                                     LANE(field_sum) * s) {
  const int n = (int)f->power - 1, times = n < 0 ? -n : n;
  const LANE(real) square = p->x * p->x + p->y * p->y + f->softening * f->softening;
  const LANE(real) base = n % 2 ? LANE(sqrt)(square) : square;
  LANE(real) power = LANE(splat)(1.0);
  for (int k = 0; k < (n % 2 ? times : times / 2); k++) power = power * base;
  if (n < 0) power = 1.0 / power;
  const LANE(real) scale =
      LANE(mask_zero)(LANE(greater)(square, LANE(splat)(0.0)), f->strength * p->weight * power);
  s->place[0] = s->place[0] - scale * p->x;
  s->place[1] = s->place[1] - scale * p->y;
}

LANE_INLINE void LANE(rotation_field)(const sd_body_force *f, const LANE(field_place) * p,
                                      LANE(field_sum) * s) {
  const LANE(real) push = (f->omega * f->omega) * p->weight;
  s->place[0] = s->place[0] + push * p->x;
  s->place[1] = s->place[1] + push * p->y;
  s->turn = s->turn + (2.0 * f->omega) * p->weight;
}

LANE_INLINE void LANE(gravity_field)(const sd_body_force *f, const LANE(field_place) * p,
                                     LANE(field_sum) * s) {
  (void)f;
  for (int c = 0; c < 2; c++) s->place[c] = s->place[c] + p->push[c] * p->weight;
}

LANE_INLINE void LANE(field_sums)(const body_forces *f, const view *v, size_t i,
                                  LANE(field_sum) * s) {
  const LANE(real) x = LANE(load)(v->k[SD_X].q + i), y = LANE(load)(v->k[SD_Y].q + i);
  for (size_t k = 0; k < f->n; k++) {
    const sd_body_force *field = f->row[k].field;
    const LANE(field_place) p = {.x = x - field->centre[0],
                                 .y = y - field->centre[1],
                                 .weight = LANE(load)(f->row[k].weight + i),
                                 .turn_weight = LANE(load)(f->row[k].turn_weight + i),
                                 .push = f->row[k].push};
    switch (field->kind) {
#define FIELD_CASE(kind, word, ...)                                                                \
  case kind: LANE(word##_field)(field, &p, s); break;
      FIELD_KINDS(FIELD_CASE)
#undef FIELD_CASE
      case SD_FIELD_KINDS: break;
    }
  }
}

/* Computes the field forces on disks i, i + 1, ... and stores them. kappa: factor by which the
 * corrector turns dt^2/2 times an acceleration into a change of velocity; 0: forces are those at
 * the present velocities. sum: contact forces and torque. */
LANE_INLINE void LANE(field_forces)(const body_forces *f, const view *v, size_t i, double kappa,
                                    const LANE(real) sum[SD_COORDINATES], LANE(field_force) * o) {
  LANE(real) base[SD_COORDINATES], gain[SD_COORDINATES], u[SD_COORDINATES], r[SD_COORDINATES];
  LANE(field_sum) *s = &o->s;
  *s = (LANE(field_sum)){0};
  LANE(field_sums)(f, v, i, s);
  for (int n = 0; n < SD_COORDINATES; n++) {
    const columns *k = &v->k[n];
    base[n] = LANE(load)(f->base[n] + i);
    gain[n] = LANE(load)(k->inverse + i) * (kappa * v->half_dt2);
    o->force[n] = n == SD_THETA ? s->flow[n] : s->place[n] + s->flow[n];
    r[n] = LANE(load)(k->v + i) +
           (gain[n] * (sum[n] + base[n] + o->force[n]) - kappa * LANE(load)(k->q2 + i));
  }
  const LANE(real) dx = 1.0 + gain[SD_X] * s->drag[0], dy = 1.0 + gain[SD_Y] * s->drag[0];
  const LANE(real) tx = gain[SD_X] * s->turn, ty = gain[SD_Y] * s->turn,
                   per = 1.0 / (dx * dy + tx * ty);
  u[SD_X] = (dy * r[SD_X] + tx * r[SD_Y]) * per;
  u[SD_Y] = (dx * r[SD_Y] - ty * r[SD_X]) * per;
  u[SD_THETA] = r[SD_THETA] / (1.0 + gain[SD_THETA] * s->drag[1]);
  o->force[SD_X] = o->force[SD_X] - s->drag[0] * u[SD_X] + s->turn * u[SD_Y];
  o->force[SD_Y] = o->force[SD_Y] - s->drag[0] * u[SD_Y] - s->turn * u[SD_X];
  o->force[SD_THETA] = o->force[SD_THETA] - s->drag[1] * u[SD_THETA];
  for (int n = 0; n < SD_COORDINATES; n++) {
    const LANE(real) zero = LANE(splat)(0.0), all = sum[n] + base[n] + o->force[n];
    const LANE(real) most = s->alpha[n == SD_THETA] * LANE(max)(all, zero - all);
    o->damped[n] = LANE(mask_zero)(LANE(greater)(zero, u[n]), most) -
                   LANE(mask_zero)(LANE(greater)(u[n], zero), most);
    o->total[n] = base[n] + (o->force[n] + o->damped[n]);
    LANE(store)(f->force[n] + i, o->force[n] + o->damped[n]);
    LANE(store)(f->total[n] + i, o->total[n]);
  }
}

/* Computes the powers of the fields at the corrected velocities (speed), and adds 0.5 dt (old + new
 * power) to the sums over time; with dt = 0 only the powers are stored. The power of work is F v +
 * f (v - u)^2, the part that is not lost by drag. Coordinates that are held or prescribed
 * contribute nothing. */
LANE_INLINE void LANE(field_book)(const body_forces *f, const view *v, size_t i, double dt,
                                  const LANE(field_force) * o,
                                  const LANE(real) speed[SD_COORDINATES]) {
  LANE(real) power[FIELD_POWERS];
  for (int k = 0; k < FIELD_POWERS; k++) power[k] = LANE(splat)(0.0);
  for (int n = 0; n < SD_COORDINATES; n++) {
    const LANE(mask) held = LANE(equal)(LANE(load)(v->k[n].inverse + i), LANE(splat)(0.0));
    const LANE(real) kept = f->clumped ? LANE(load)(f->clumped + i) : LANE(splat)(0.0);
    const LANE(real) w = LANE(select)(held, kept, LANE(splat)(1.0)), q = speed[n];
    const LANE(real) lost = (o->s.drag[n == SD_THETA] * q - 2.0 * o->s.flow[n]) * q + o->s.flow2[n];
    power[FIELD_WORK] = power[FIELD_WORK] + w * (o->force[n] * q + lost);
    power[FIELD_DRAG] = power[FIELD_DRAG] + w * lost;
    power[FIELD_DAMPED] = power[FIELD_DAMPED] - w * (o->damped[n] * q);
  }
  for (int k = 0; k < FIELD_POWERS; k++) {
    LANE(real)
    sum = LANE(load)(f->sum[k] + i) + (0.5 * dt) * (LANE(load)(f->power[k] + i) + power[k]);
    LANE(store)(f->sum[k] + i, sum);
    LANE(store)(f->power[k] + i, power[k]);
  }
}

/* Recomputes field forces and powers of disks i, i + 1, ... from coordinates and contact forces in
 * the state. */
LANE_INLINE void LANE(field_renew)(const body_forces *f, const view *v, size_t i) {
  LANE(real) sum[SD_COORDINATES], speed[SD_COORDINATES];
  for (int n = 0; n < SD_COORDINATES; n++) {
    sum[n] = LANE(load)(v->k[n].force + i);
    speed[n] = LANE(load)(v->k[n].v + i);
  }
  LANE(field_force) o;
  LANE(field_forces)(f, v, i, 0.0, sum, &o);
  LANE(field_book)(f, v, i, 0.0, &o, speed);
}

/* Corrects the coordinates of disks i, i + 1, ... with the sums of forces on them. Returns nonzero
 * if an angle or position of a disk must be wrapped, or a disk is too fast. *stale is set if the
 * next step would make the neighbour lists stale. */
LANE_INLINE int LANE(correct_at)(const view *v, size_t i, const int gear, const body_forces *acting,
                                 int *stale) {
  LANE(real) sum[SD_COORDINATES], q[SD_COORDINATES], speed[SD_COORDINATES], next[SD_COORDINATES];
  LANE(real) dt = LANE(splat)(v->dt), per_dt = LANE(splat)(v->per_dt);
  LANE(take_sum)(v, i, sum);
  LANE(field_force) field;
  if (acting) LANE(field_forces)(acting, v, i, gear ? GEAR1 * v->per_dt : v->per_dt, sum, &field);
  for (int n = 0; n < SD_COORDINATES; n++) {
    const columns *k = &v->k[n];
    LANE(real) constant = LANE(splat)(0.0);
    if (acting)
      constant = field.total[n];
    else if (k->constant)
      constant = LANE(load)(k->constant + i);
    LANE(real)
    a = LANE(accelerate)(sum[n], constant, LANE(load)(k->inverse + i), LANE(splat)(v->half_dt2));
    LANE(nordsieck)
    c = {.q = LANE(load)(k->q + i), .v = LANE(load)(k->v + i), .q2 = LANE(load)(k->q2 + i)};
    if (gear) {
      c.q3 = LANE(load)(k->q3 + i);
      c.q4 = LANE(load)(k->q4 + i);
      c.q5 = LANE(load)(k->q5 + i);
      LANE(gear_correct)(&c, a, per_dt);
      LANE(store)(k->q + i, c.q);
      LANE(store)(k->q3 + i, c.q3);
      LANE(store)(k->q4 + i, c.q4);
      LANE(store)(k->q5 + i, c.q5);
    } else {
      LANE(verlet_correct)(&c, a, per_dt);
    }
    LANE(store)(k->v + i, c.v);
    LANE(store)(k->q2 + i, c.q2);
    q[n] = c.q;
    speed[n] = c.v;
    next[n] = c.q + (c.v * dt + c.q2);
  }
  if (acting) LANE(field_book)(acting, v, i, v->dt, &field, speed);
  *stale |= LANE(is_stale)(v, i, next[SD_X], next[SD_Y]);
  return LANE(any)(LANE(out_of_range)(v, q[SD_X], q[SD_Y], q[SD_THETA]) |
                   LANE(is_fast_at)(v, i, speed[SD_X], speed[SD_Y]));
}
