/* pair_pass.h: one pass over LANE_WIDTH pairs; included once per width after physics/law.h.
 *
 * The force pass writes what each contact does to its two bodies, from trial coordinates, and leaves the memory alone. The commit
 * pass slides the skin, opens and closes contacts and books the losses of the step. Velocity Verlet does both in
 * one.
 */

/* What else a copy of the pass is made for. */
#ifndef PAIR_PASS_COMMON
#define PAIR_PASS_COMMON
enum { PASS_VARIANT = 4 /* the paper's */, PASS_LAWS = 8 /* they differ from pair to pair */ };
#endif

LANE_INLINE LANE(law_constants) LANE(constants)(const work *w) {
  return (LANE(law_constants)){.k_n = LANE(splat)(w->laws->k_n),
                               .k_t = LANE(splat)(w->laws->k_t),
                               .half_k_t = LANE(splat)(0.5 * w->laws->k_t),
                               .gamma_n = LANE(splat)(w->laws->gamma_n),
                               .cap = LANE(splat)(w->laws->cap)};
}

LANE_INLINE LANE(law_constants) LANE(constants_of)(const work *w, const int32_t *law) {
  double row[4][LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++) {
    const law_row *r = &w->laws[law[l]];
    row[0][l] = r->k_n;
    row[1][l] = r->k_t;
    row[2][l] = r->gamma_n;
    row[3][l] = r->cap;
  }
  LANE(law_constants) k;
  k.k_n = LANE(load)(row[0]);
  k.k_t = LANE(load)(row[1]);
  k.half_k_t = 0.5 * k.k_t;
  k.gamma_n = LANE(load)(row[2]);
  k.cap = LANE(load)(row[3]);
  return k;
}

/* Where a vector of pairs stands: in lanes l ... of a block. */
typedef struct LANE(place) {
  pair_block *b;
  size_t l;
} LANE(place);

LANE_INLINE LANE(place) LANE(place_of)(const pairs *p, size_t at) {
  return (LANE(place)){p->block + at / PAIR_BLOCK, at % PAIR_BLOCK};
}

/* Forces on b: F_n n - scale tau t, with t = (-n_y, n_x); on a the opposite. */
LANE_INLINE void LANE(act)(double *sum, LANE(place) at, const LANE(law_push) * push) {
  const LANE(real)
      row[SUM_ROW] = {[SUM_X] = push->fx, [SUM_Y] = push->fy, [SUM_TURN] = push->tau, [3] = LANE(splat)(0.0)};
  LANE(add4)(sum, at.b->sum_b + at.l, at.b->sum_a + at.l, row);
}

/* Writes down what has to be treated one by one after the pass; the memory is still that of before. */
LANE_INLINE void LANE(note)(const pairs *p, thread_work *mine, LANE(place) at, const LANE(law_booked) * b,
                            LANE(mask) which, LANE(real) missed) {
  double drop[LANE_WIDTH], wrong[LANE_WIDTH];
  LANE(store)(wrong, missed);
  LANE(store)(drop, b->drop);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    if (!LANE(lane_is)(which, (int)l)) continue;
    size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l + l;
    event *v = event_add(&mine->events, (uint32_t)k, drop[l]);
    if (!v) return; /* the list knows */
    v->star = PAIR(p, k, star);
    v->ex = PAIR(p, k, ex);
    v->ey = PAIR(p, k, ey);
    v->side = p->side[k];
    v->force = PAIR(p, k, force);
    v->overlap = PAIR(p, k, overlap);
    v->stretch = PAIR(p, k, stretch);
    v->missed = wrong[l];
  }
}

/* Adds to what contacts have lost. */
LANE_INLINE void LANE(book)(double *sum, LANE(real) loss) { LANE(store)(sum, LANE(load)(sum) + loss); }

/* Slides the skin. Of the overlaps, those beyond the limit of the smallest body are called rare: more than there are. */
LANE_INLINE LANE(law_booked)
    LANE(slide)(const work *w, LANE(place) at, const LANE(law_input) * in, const LANE(law_geometry) * g,
                const LANE(law_output) * out, const LANE(law_constants) * k, int variant,
                LANE(law_memory) * before, LANE(law_memory) * m) {
  const pair_block *b = at.b;
  *before = (LANE(law_memory)){.star = in->star,
                               .force = LANE(load)(b->force + at.l),
                               .overlap = LANE(load)(b->overlap + at.l),
                               .stretch = LANE(load)(b->stretch + at.l),
                               .turned = LANE(load)(b->turned + at.l)};
  before->damping = before->force - k->k_n * before->overlap;
  *m = *before;
  return LANE(law_commit)(in, g, out, k, LANE(splat)(w->least_limit), variant, m);
}

/* Contacts that open and begin, and what has to be treated one by one. acted: normal force of the step. */
LANE_INLINE void LANE(turn_over)(work *w, thread_work *mine, LANE(place) at, const LANE(law_input) * in,
                                 const LANE(law_geometry) * g, const LANE(law_output) * out,
                                 const LANE(law_constants) * k, LANE(real) limit, LANE(real) acted,
                                 const LANE(law_memory) * before, LANE(law_memory) * m,
                                 LANE(law_booked) * b) {
  double *ex = at.b->ex + at.l, *ey = at.b->ey + at.l;
  LANE(real) step = LANE(splat)(w->dt);
  LANE(law_turn_over)(in, g, out, k, before, step, m, b);
  LANE(mask) near = LANE(law_near)(in, g, out, step) & LANE(greater)(acted, LANE(splat)(0.0));
  LANE(mask) which = b->turned | LANE(greater)(out->delta, limit) | near;
  if (LANE(any)(which)) LANE(note)(&w->pairs, mine, at, b, which, LANE(law_missed)(in, g, out, acted, step));
  LANE(store)(ex, LANE(law_direction)(b, out, LANE(load)(ex), g->nx));
  LANE(store)(ey, LANE(law_direction)(b, out, LANE(load)(ey), g->ny));
}

LANE_INLINE void LANE(store_memory)(LANE(place) at, const LANE(law_memory) * m, const LANE(law_booked) * b,
                                    int variant) {
  pair_block *p = at.b;
  LANE(book)(p->viscous + at.l, b->viscous);
  LANE(book)(p->friction + at.l, b->friction);
  if (variant) LANE(book)(p->gain + at.l, b->gain);
  LANE(store)(p->star + at.l, m->star);
  LANE(store)(p->force + at.l, m->force);
  LANE(store)(p->overlap + at.l, m->overlap);
  LANE(store)(p->stretch + at.l, m->stretch);
  LANE(store)(p->turned + at.l, m->turned);
  LANE(store)(p->slip + at.l, m->slip);
}

/* Two bodies of each lane as they are seen. */
typedef struct LANE(two_seats) {
  LANE(real) a[4], b[4];
} LANE(two_seats);

LANE_INLINE LANE(two_seats) LANE(seats_of)(const work *w, LANE(place) at) {
  LANE(two_seats) s;
  LANE(pick4)(w->seats, at.b->seat_a + at.l, s.a);
  LANE(pick4)(w->seats, at.b->seat_b + at.l, s.b);
  return s;
}

/* What the law needs of a vector of round pairs. */
LANE_INLINE void LANE(see)(const work *w, LANE(place) at, LANE(law_sight) * sight) {
  LANE(real) pose[4], speed[2];
  LANE(across4)(w->seats, at.b->seat_a + at.l, at.b->seat_b + at.l, pose);
  LANE(across2)(w->seats + SEAT_VX, at.b->seat_a + at.l, at.b->seat_b + at.l, speed);
  LANE(law_input)
  in = {.dx = pose[SEAT_X],
        .dy = pose[SEAT_Y],
        .dvx = speed[0],
        .dvy = speed[1],
        .sum = pose[SEAT_RADIUS],
        .arc = pose[SEAT_ARC],
        .ex = LANE(load)(at.b->ex + at.l),
        .ey = LANE(load)(at.b->ey + at.l)};
  if (w->periodic[0]) in.dx = in.dx - w->length[0] * LANE(nearest)(in.dx * w->inverse_length[0]);
  if (w->periodic[1]) in.dy = in.dy - w->length[1] * LANE(nearest)(in.dy * w->inverse_length[1]);
  LANE(law_look)(&in, sight);
}

/* What is the same for all pairs. */
typedef struct LANE(pass_constants) {
  LANE(law_constants) law; /* unless PASS_LAWS */
  LANE(real) limit, two_dt;
} LANE(pass_constants);

LANE_INLINE LANE(pass_constants) LANE(pass_constants_of)(const work *w) {
  return (LANE(pass_constants)){LANE(constants)(w), LANE(splat)(w->least_limit), LANE(splat)(2.0 * w->dt)};
}

/* A vector in which something rare may happen: the whole of the law. */
static __attribute__((noinline, cold)) void LANE(meet_rare)(engine *e, thread_work *mine, LANE(place) at,
                                                            const LANE(law_geometry) * g, int kind) {
  work *w = &e->work;
  pair_block *p = at.b;
  LANE(law_input)
  in = {.star = LANE(load)(p->star + at.l),
        .was_closed = LANE(greater)(LANE(load)(p->overlap + at.l), LANE(splat)(0.0)),
        .active = LANE(all_lanes)(1)};
  const LANE(law_constants) k = LANE(constants_of)(w, p->law + at.l);
  const LANE(law_output) out = LANE(law)(&in, g, &k);
  LANE(real) acted = LANE(load)(p->acted + at.l);
  if (kind & PASS_FORCE) {
    LANE(law_push) push = LANE(law_force)(g, &out, &k, kind & PASS_VARIANT ? LANE(splat)(1.0) : g->lever);
    LANE(act)(w->sums.row, at, &push);
    acted = out.force;
  }
  LANE(law_memory) before, m;
  LANE(law_booked) b = LANE(slide)(w, at, &in, g, &out, &k, kind & PASS_VARIANT, &before, &m);
  LANE(two_seats) s = LANE(seats_of)(w, at);
  LANE(real) rb = s.b[SEAT_RADIUS], smaller = LANE(least)(s.a[SEAT_RADIUS], LANE(most)(rb, -rb));
  in.arc = s.a[SEAT_ARC] + s.b[SEAT_ARC];
  LANE(turn_over)(w, mine, at, &in, g, &out, &k, e->model->max_overlap * smaller, acted, &before, &m, &b);
  LANE(store_memory)(at, &m, &b, kind & PASS_VARIANT);
}

/* What happens to the pairs `at`, of which *seen tells; then that of the pairs `next`, which are looked at on the way: after
 * the history and before the force, where measurements say that it is least in the way of either. */
LANE_INLINE void LANE(meet)(engine *e, thread_work *mine, LANE(place) at, LANE(place) next,
                            LANE(law_sight) * seen, const LANE(pass_constants) * one, double *sum,
                            const int kind) {
  work *w = &e->work;
  pair_block *p = at.b;
  LANE(law_geometry) g;
  LANE(law_geometry_at)(seen, &g);
  LANE(mask) was_closed = LANE(greater)(LANE(load)(p->overlap + at.l), LANE(splat)(0.0));
  if (kind & PASS_COMMIT) {
    if (__builtin_expect(LANE(any)(LANE(law_rare)(&g, was_closed, one->limit, one->two_dt)), 0)) {
      LANE(meet_rare)(e, mine, at, &g, kind);
      LANE(see)(w, next, seen);
      return;
    }
    was_closed = LANE(greater)(g.reach, LANE(splat)(0.0)); /* the same, and what touches is closed */
  }
  LANE(law_input)
  in = {.star = LANE(load)(p->star + at.l), .was_closed = was_closed, .active = LANE(all_lanes)(1)};
  const LANE(law_constants) k = kind & PASS_LAWS ? LANE(constants_of)(w, p->law + at.l) : one->law;
  const LANE(law_output) out = LANE(law)(&in, &g, &k);
  if (kind & PASS_COMMIT) {
    LANE(law_memory) before, m;
    LANE(law_booked) b = LANE(slide)(w, at, &in, &g, &out, &k, kind & PASS_VARIANT, &before, &m);
    LANE(store_memory)(at, &m, &b, kind & PASS_VARIANT);
  }
  LANE(see)(w, next, seen);
  if (!(kind & PASS_FORCE)) return;
  LANE(law_push) push = LANE(law_force)(&g, &out, &k, kind & PASS_VARIANT ? LANE(splat)(1.0) : g.lever);
  LANE(act)(sum, at, &push);
  if (!(kind & PASS_COMMIT)) LANE(store)(p->acted + at.l, out.force);
}
