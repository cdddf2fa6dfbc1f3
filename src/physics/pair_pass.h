/* pair_pass.h: one pass over LANE_WIDTH pairs; included once per width after physics/law.h.
 *
 * The force pass writes what each contact does to its two bodies, from trial coordinates, and leaves the memory alone. The commit
 * pass slides the skin, opens and closes contacts and books the losses of the step. Velocity Verlet does both in
 * one.
 */

LANE_INLINE LANE(law_constants) LANE(constants)(const work *w, const int32_t *law) {
  LANE(law_constants) k;
  if (w->one_law) {
    k.k_n = LANE(splat)(w->laws->k_n);
    k.k_t = LANE(splat)(w->laws->k_t);
    k.half_k_t = 0.5 * k.k_t;
    k.gamma_n = LANE(splat)(w->laws->gamma_n);
    k.cap = LANE(splat)(w->laws->cap);
    return k;
  }
  double row[4][LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++) {
    const law_row *r = &w->laws[law[l]];
    row[0][l] = r->k_n;
    row[1][l] = r->k_t;
    row[2][l] = r->gamma_n;
    row[3][l] = r->cap;
  }
  k.k_n = LANE(load)(row[0]);
  k.k_t = LANE(load)(row[1]);
  k.half_k_t = 0.5 * k.k_t;
  k.gamma_n = LANE(load)(row[2]);
  k.cap = LANE(load)(row[3]);
  return k;
}

/* Forces on b: F_n n - scale tau t, with t = (-n_y, n_x); on a the opposite. */
LANE_INLINE void LANE(store_force)(work *w, size_t at, const LANE(law_push) * push) {
  const LANE(real) row[PUSH_ROW] = {push->fx, push->fy, push->tau, LANE(splat)(0.0)};
  LANE(put4)(w->incidence.push, w->pairs.push_b + at, w->pairs.push_a + at, row);
}

/* Size of the forces that acted in the step. */
LANE_INLINE LANE(real) LANE(acted)(const work *w, size_t at) {
  LANE(real) f[2];
  LANE(pick2)(w->incidence.push, w->pairs.push_b + at, f);
  return LANE(root)(f[0] * f[0] + f[1] * f[1]);
}

/* Writes down what has to be treated one by one after the pass; the memory is still that of before. */
LANE_INLINE void LANE(note)(const pairs *p, thread_work *mine, size_t at, const LANE(law_booked) * b,
                            LANE(mask) which, LANE(real) missed) {
  double drop[LANE_WIDTH], wrong[LANE_WIDTH];
  LANE(store)(wrong, missed);
  LANE(store)(drop, b->drop);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    if (!LANE(lane_is)(which, (int)l)) continue;
    event *v = event_add(&mine->events, (uint32_t)(at + l), drop[l]);
    if (!v) return; /* the list knows */
    v->star = p->star[at + l];
    v->ex = p->ex[at + l];
    v->ey = p->ey[at + l];
    v->side = p->side[at + l];
    v->force = p->force[at + l];
    v->overlap = p->overlap[at + l];
    v->stretch = p->stretch[at + l];
    v->missed = wrong[l];
  }
}

/* Adds to what contacts have lost. */
LANE_INLINE void LANE(book)(double *sum, LANE(real) loss) { LANE(store)(sum, LANE(load)(sum) + loss); }

/* Slides the skin. Of the overlaps, those beyond the limit of the smallest body are called rare: more than there are. */
LANE_INLINE LANE(law_booked)
    LANE(slide)(const work *w, size_t at, const LANE(law_input) * in, const LANE(law_geometry) * g,
                const LANE(law_output) * out, const LANE(law_constants) * k, int variant,
                LANE(law_memory) * before, LANE(law_memory) * m) {
  const pairs *p = &w->pairs;
  *before = (LANE(law_memory)){.star = in->star,
                               .force = LANE(load)(p->force + at),
                               .overlap = LANE(load)(p->overlap + at),
                               .stretch = LANE(load)(p->stretch + at),
                               .turned = LANE(load)(p->turned + at)};
  before->damping = before->force - k->k_n * before->overlap;
  *m = *before;
  return LANE(law_commit)(in, g, out, k, LANE(splat)(w->least_limit), variant, m);
}

/* Contacts that open and begin, and what has to be treated one by one. */
LANE_INLINE void LANE(turn_over)(work *w, thread_work *mine, size_t at, const LANE(law_input) * in,
                                 const LANE(law_geometry) * g, const LANE(law_output) * out,
                                 const LANE(law_constants) * k, LANE(real) limit,
                                 const LANE(law_memory) * before, LANE(law_memory) * m,
                                 LANE(law_booked) * b) {
  pairs *p = &w->pairs;
  LANE(real) step = LANE(splat)(w->dt), acted = LANE(acted)(w, at);
  LANE(law_turn_over)(in, g, out, k, before, step, m, b);
  LANE(mask) near = LANE(law_near)(in, g, out, step) & LANE(greater)(acted, LANE(splat)(0.0));
  LANE(mask) which = b->turned | LANE(greater)(out->delta, limit) | near;
  if (LANE(any)(which)) LANE(note)(p, mine, at, b, which, LANE(law_missed)(in, g, out, acted, step));
  LANE(store)(p->ex + at, LANE(law_direction)(b, out, LANE(load)(p->ex + at), g->nx));
  LANE(store)(p->ey + at, LANE(law_direction)(b, out, LANE(load)(p->ey + at), g->ny));
}

LANE_INLINE void LANE(store_memory)(pairs *p, size_t at, const LANE(law_memory) * m,
                                    const LANE(law_booked) * b, int variant) {
  LANE(book)(p->viscous + at, b->viscous);
  LANE(book)(p->friction + at, b->friction);
  if (variant) LANE(book)(p->gain + at, b->gain);
  LANE(store)(p->star + at, m->star);
  LANE(store)(p->force + at, m->force);
  LANE(store)(p->overlap + at, m->overlap);
  LANE(store)(p->stretch + at, m->stretch);
  LANE(store)(p->turned + at, m->turned);
  LANE(store)(p->slip + at, m->slip);
}

/* Two bodies of each lane as they are seen. */
typedef struct LANE(two_seats) {
  LANE(real) a[4], b[4];
} LANE(two_seats);

LANE_INLINE LANE(two_seats) LANE(seats_of)(const work *w, size_t at) {
  LANE(two_seats) s;
  LANE(pick4)(w->seats, w->pairs.seat_a + at, s.a);
  LANE(pick4)(w->seats, w->pairs.seat_b + at, s.b);
  return s;
}

/* What the law needs of a vector of round pairs. */
LANE_INLINE LANE(law_geometry) LANE(see)(const work *w, size_t at) {
  const pairs *p = &w->pairs;
  LANE(two_seats) s = LANE(seats_of)(w, at);
  LANE(real) va[2], vb[2];
  LANE(pick2)(w->seats + SEAT_VX, p->seat_a + at, va);
  LANE(pick2)(w->seats + SEAT_VX, p->seat_b + at, vb);
  LANE(law_input)
  in = {.dx = s.b[SEAT_X] - s.a[SEAT_X],
        .dy = s.b[SEAT_Y] - s.a[SEAT_Y],
        .dvx = vb[0] - va[0],
        .dvy = vb[1] - va[1],
        .sum = s.a[SEAT_RADIUS] + s.b[SEAT_RADIUS],
        .arc = s.a[SEAT_ARC] + s.b[SEAT_ARC],
        .ex = LANE(load)(p->ex + at),
        .ey = LANE(load)(p->ey + at)};
  if (w->periodic[0]) in.dx = in.dx - w->length[0] * LANE(nearest)(in.dx * w->inverse_length[0]);
  if (w->periodic[1]) in.dy = in.dy - w->length[1] * LANE(nearest)(in.dy * w->inverse_length[1]);
  return LANE(law_geometry_of)(&in);
}

LANE_INLINE void LANE(meet)(engine *e, thread_work *mine, size_t at, const LANE(law_geometry) * g, int pass) {
  work *w = &e->work;
  pairs *p = &w->pairs;
  const int variant = !w->conservative;
  LANE(law_input)
  in = {.star = LANE(load)(p->star + at),
        .was_closed = LANE(greater)(LANE(load)(p->overlap + at), LANE(splat)(0.0)),
        .active = LANE(all_lanes)(1)};
  const LANE(law_constants) k = LANE(constants)(w, p->law + at);
  const LANE(law_output) out = LANE(law)(&in, g, &k);
  if (pass & PASS_FORCE) {
    LANE(law_push) push = LANE(law_force)(g, &out, &k, variant ? LANE(splat)(1.0) : g->lever);
    LANE(store_force)(w, at, &push);
  }
  if (!(pass & PASS_COMMIT)) return;
  LANE(law_memory) before, m;
  LANE(law_booked) b = LANE(slide)(w, at, &in, g, &out, &k, variant, &before, &m);
  LANE(mask) near = LANE(law_near)(&in, g, &out, LANE(splat)(w->dt));
  if (__builtin_expect(LANE(any)(b.rare | near), 0)) {
    LANE(two_seats) s = LANE(seats_of)(w, at);
    LANE(real) rb = s.b[SEAT_RADIUS], smaller = LANE(least)(s.a[SEAT_RADIUS], LANE(most)(rb, -rb));
    in.arc = s.a[SEAT_ARC] + s.b[SEAT_ARC];
    LANE(turn_over)(w, mine, at, &in, g, &out, &k, e->model->max_overlap * smaller, &before, &m, &b);
  }
  LANE(store_memory)(p, at, &m, &b, variant);
}

LANE_INLINE void LANE(round_pass)(engine *e, thread_work *mine, size_t at, int pass) {
  LANE(law_geometry) g = LANE(see)(&e->work, at);
  LANE(meet)(e, mine, at, &g, pass);
}
