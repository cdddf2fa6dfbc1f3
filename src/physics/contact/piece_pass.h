/* piece_pass.h: one pass over LANE_WIDTH disks beside pieces of straight walls; included once per width after
 * physics/pair_pass.h. Where a disk is nearest is found one by one, the law is that of round pairs.
 */

/* Of each lane, what only pieces have. */
typedef struct LANE(pieces) {
  nearest_point q[LANE_WIDTH];
  double flat[LANE_WIDTH]; /* 1.0: the point lies between the ends */
  double side[LANE_WIDTH];
  bool crossed; /* any */
} LANE(pieces);

/* Fills what the law needs: the nearest point of a piece is a surface of radius 0, and
 * lambda = R_a (th_a - turned) + side * (arc length of that point). physics.md 3. */
LANE_INLINE void LANE(see_pieces)(const engine *e, size_t at, LANE(law_input) * in, LANE(pieces) * found) {
  enum { DX, DY, DVX, DVY, SUM, ARC, ACTIVE, ROWS };
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double row[ROWS][LANE_WIDTH];
  found->crossed = false;
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const int32_t a = p->a[at + l], b = p->b[at + l];
    nearest_point q = walls_nearest(&e->work.segments[p->part[at + l]], s->x[a], s->y[a]);
    row[DX][l] = q.dx;
    row[DY][l] = q.dy;
    /* velocity of the wall's material at that point */
    double lx = s->x[a] + q.dx - s->x[b], ly = s->y[a] + q.dy - s->y[b];
    row[DVX][l] = (s->vx[b] - s->omega[b] * ly) - s->vx[a];
    row[DVY][l] = (s->vy[b] + s->omega[b] * lx) - s->vy[a];
    row[SUM][l] = s->radius[a];
    row[ACTIVE][l] = q.active ? 1.0 : 0.0;
    /* an open contact begins on the side where the disk is */
    q.crossed = p->side[at + l] != 0.0 && p->side[at + l] != q.side;
    if (q.crossed) q.side = p->side[at + l];
    row[ARC][l] = s->radius[a] * s->theta[a] + q.side * q.arc;
    found->side[l] = q.side;
    found->flat[l] = q.flat ? 1.0 : 0.0;
    found->crossed |= q.crossed;
    found->q[l] = q;
  }
  const LANE(place) here = LANE(place_of)(p, at);
  const LANE(real) zero = LANE(splat)(0.0);
  *in = (LANE(law_input)){.dx = LANE(load)(row[DX]),
                          .dy = LANE(load)(row[DY]),
                          .dvx = LANE(load)(row[DVX]),
                          .dvy = LANE(load)(row[DVY]),
                          .sum = LANE(load)(row[SUM]),
                          .arc = LANE(load)(row[ARC]),
                          .star = LANE(load)(here.b->star + here.l),
                          .ex = LANE(load)(here.b->ex + here.l),
                          .ey = LANE(load)(here.b->ey + here.l),
                          .was_closed = LANE(greater)(LANE(load)(here.b->overlap + here.l), zero),
                          .active = LANE(greater)(LANE(load)(row[ACTIVE]), zero)};
}

/* The wall feels the torque about its pivot: -tau R_a, and the arm from there to the disk's centre. */
LANE_INLINE void LANE(act_pieces)(engine *e, size_t at, const LANE(law_push) * push) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double fx[LANE_WIDTH], fy[LANE_WIDTH], tau[LANE_WIDTH], *row = e->work.sums.row;
  LANE(store)(fx, push->fx);
  LANE(store)(fy, push->fy);
  LANE(store)(tau, push->tau);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const int32_t a = p->a[at + l], b = p->b[at + l];
    double rx = s->x[a] - s->x[b], ry = s->y[a] - s->y[b];
    double turn = rx * fy[l] - ry * fx[l] - tau[l] * s->radius[a];
    double *on_a = row + PAIR(p, at + l, sum_a), *on_b = row + PAIR(p, at + l, sum_b);
    on_b[SUM_X] += fx[l];
    on_b[SUM_Y] += fy[l];
    on_b[SUM_TURN] += turn;
    on_a[SUM_X] -= fx[l];
    on_a[SUM_Y] -= fy[l];
    on_a[SUM_TURN] += tau[l];
  }
}

/* Which side each contact is on, and which went around a free end. */
LANE_INLINE void LANE(remember_sides)(pairs *p, thread_work *mine, size_t at, const LANE(law_output) * out,
                                      const LANE(pieces) * found) {
  LANE(store)(p->side + at, LANE(keep)(out->touching, LANE(load)(found->side)));
  for (size_t l = 0; found->crossed && l < LANE_WIDTH; l++) {
    if (!found->q[l].crossed || !LANE(lane_is)(out->closed, (int)l)) continue;
    event *v = event_add(&mine->events, (uint32_t)(at + l), 0.0);
    if (v) v->ex = PAIR(p, at + l, ex), v->ey = PAIR(p, at + l, ey);
  }
}

LANE_INLINE void LANE(meet_pieces)(engine *e, thread_work *mine, size_t at, int pass) {
  work *w = &e->work;
  const LANE(place) here = LANE(place_of)(&w->pairs, at);
  LANE(law_input) in;
  LANE(pieces) found;
  LANE(see_pieces)(e, at, &in, &found);
  LANE(law_constants) k = LANE(constants_of)(w, here.b->law + here.l);
  LANE(law_geometry) g = LANE(law_geometry_of)(&in);
  LANE(law_output) out = LANE(law)(&in, &g, &k);
  LANE(real) acted = LANE(load)(here.b->acted + here.l), one = LANE(splat)(1.0);
  if (pass & PASS_FORCE) {
    /* the force that derives from the skin's energy, in both variants: the paper has no walls */
    LANE(mask) flat = LANE(greater)(LANE(load)(found.flat), LANE(splat)(0.0));
    LANE(law_push) push = LANE(law_force)(&g, &out, &k, LANE(select)(flat, one, g.lever));
    LANE(act_pieces)(e, at, &push);
    acted = out.force;
    LANE(store)(here.b->acted + here.l, acted);
  }
  if (pass & PASS_COMMIT) {
    LANE(law_memory) before, m;
    LANE(law_booked) b = LANE(slide)(w, here, &in, &g, &out, &k, 0, &before, &m);
    if (LANE(any)(b.rare | LANE(law_near)(&in, &g, &out, LANE(splat)(w->dt)))) LANE(turn_over)
    (w, mine, here, &in, &g, &out, &k, e->model->max_overlap * in.sum, acted, &before, &m, &b);
    LANE(store_memory)(here, &m, &b, 0);
    LANE(remember_sides)(&w->pairs, mine, at, &out, &found);
  }
}
