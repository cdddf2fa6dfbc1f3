/* segment_pass.h: one evaluation of LANE_WIDTH disks beside wall segments; included once per width after
 * physics/contact/pair_pass.h. The nearest points are found one by one, the law is that of round pairs.
 */

/* Of each lane, what only segments have. */
typedef struct LANE(nearest_points) {
  nearest_point q[LANE_WIDTH];
  double flat[LANE_WIDTH]; /* 1.0: the point lies between the ends */
  double side[LANE_WIDTH];
  bool crossed; /* any */
} LANE(nearest_points);

/* The nearest point of a segment is a surface of radius 0, and
 * lambda = R_a (th_a - turned) + side * (arc length of that point). physics.md 4. active: a neighbouring segment owns no
 * part of this region. */
LANE_INLINE LANE(mask)
    LANE(nearest_of)(const engine *e, size_t at, LANE(pair_input) * in, LANE(nearest_points) * found) {
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
    /* a contact begins on the side where the disk is, and keeps it */
    q.crossed = p->side[at + l] != 0.0 && p->side[at + l] != q.side;
    if (q.crossed) q.side = p->side[at + l];
    row[ARC][l] = s->radius[a] * s->theta[a] + q.side * q.arc;
    found->side[l] = q.side;
    found->flat[l] = q.flat ? 1.0 : 0.0;
    found->crossed |= q.crossed;
    found->q[l] = q;
  }
  const LANE(location) here = {p->block + at / PAIR_BLOCK, at % PAIR_BLOCK};
  *in = (LANE(pair_input)){.dx = LANE(load)(row[DX]),
                           .dy = LANE(load)(row[DY]),
                           .dvx = LANE(load)(row[DVX]),
                           .dvy = LANE(load)(row[DVY]),
                           .sum = LANE(load)(row[SUM]),
                           .arc = LANE(load)(row[ARC]),
                           .ex = LANE(load)(here.b->ex + here.l),
                           .ey = LANE(load)(here.b->ey + here.l)};
  return LANE(greater)(LANE(load)(row[ACTIVE]), LANE(splat)(0.0));
}

/* The wall feels the torque about its pivot: -tau R_a, and the arm from there to the disk's centre. */
LANE_INLINE void LANE(scatter_segments)(engine *e, size_t at, const LANE(contact_output) * out) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double fx[LANE_WIDTH], fy[LANE_WIDTH], tau[LANE_WIDTH], *row = e->work.sums.row;
  LANE(store)(fx, out->fx);
  LANE(store)(fy, out->fy);
  LANE(store)(tau, out->tau);
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

/* Sides of closed contacts, and contacts that went around a free end. */
LANE_INLINE void LANE(store_sides)(pairs *p, thread_work *mine, size_t at, LANE(mask) touching,
                                   LANE(mask) closed, const LANE(nearest_points) * found) {
  LANE(store)(p->side + at, LANE(mask_zero)(touching, LANE(load)(found->side)));
  for (size_t l = 0; found->crossed && l < LANE_WIDTH; l++)
    if (found->q[l].crossed && LANE(lane_is)(closed, (int)l))
      event_add_pair(&mine->events, p, at + l, true, 0.0);
}

/* Without forces on the bodies: scatter is 0 where a step is evaluated again, with the memory of another segment. */
LANE_INLINE void LANE(evaluate_segments)(engine *e, thread_work *mine, size_t at, const int scatter) {
  work *w = &e->work;
  const LANE(location) here = {w->pairs.block + at / PAIR_BLOCK, at % PAIR_BLOCK};
  LANE(pair_input) in;
  LANE(nearest_points) found;
  const LANE(mask) active = LANE(nearest_of)(e, at, &in, &found);
  const int mixed = w->mixed_laws;
  LANE(contact_constants) k = LANE(constants_of)(w, here.b->law + here.l, 1);
  if (mixed) { /* the wall's mass is infinite */
    double mass[LANE_WIDTH];
    for (size_t l = 0; l < LANE_WIDTH; l++) mass[l] = e->state->mass[w->pairs.a[at + l]];
    k.tsuji = k.tsuji * LANE(sqrt)(LANE(load)(mass) * k.k_n);
  }
  const LANE(pair_geometry) g = LANE(pair_geometry_of)(&in);
  double closed_row[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) closed_row[l] = pairs_closed(&w->pairs, at + l) ? 1.0 : 0.0;
  const LANE(mask) was_closed = LANE(greater)(LANE(load)(closed_row), LANE(splat)(0.0));
  const LANE(mask) touching = LANE(greater)(g.reach, LANE(splat)(0.0)) & active & LANE(has_direction)(&g);
  const LANE(mask) closed = touching & was_closed;
  /* the force that derives from the tangential energy, in both variants: the paper has no walls */
  const LANE(mask) flat = LANE(greater)(LANE(load)(found.flat), LANE(splat)(0.0));
  LANE(contact_memory) m, before;
  LANE(contact_output) out;
  LANE(load_memory)(here, 0, &m);
  m.ex = in.ex;
  m.ey = in.ey;
  before = m;
  LANE(contact_step)
  (&g, &k, touching, closed, LANE(select)(flat, LANE(splat)(1.0), g.lever), 0, mixed, &m, &out);
  const LANE(mask) deep = LANE(contact_is_deep)(&g, e->model->max_overlap * in.sum) & touching;
  const LANE(mask) rare = (touching ^ was_closed) | deep;
  if (LANE(any)(rare)) {
    LANE(contact_begin_end)
    (&g, &k, touching, closed, was_closed, LANE(splat)(w->dt), LANE(bent_of)(e, here, g.nx, g.ny), &before,
     &m, &out);
    LANE(note)(&w->pairs, mine, here, rare, was_closed, out.dropped);
    LANE(store)(here.b->ex + here.l, m.ex);
    LANE(store)(here.b->ey + here.l, m.ey);
  }
  if (scatter) LANE(scatter_segments)(e, at, &out);
  LANE(store_memory)(here, 0, &m, &out);
  LANE(store_sides)(&w->pairs, mine, at, touching, closed, &found);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    pair_flags *flags = &w->pairs.flags[pairs_flags_at(&w->pairs, at + l)];
    double slip[LANE_WIDTH];
    LANE(store)(slip, out.slip);
    *flags = (pair_flags){.closed = LANE(lane_is)(touching, (int)l) != 0,
                          .slides_positive = slip[l]<0.0, .slides_negative = slip[l]> 0.0};
  }
}
