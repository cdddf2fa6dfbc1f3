/* pair_pass.h: one evaluation of LANE_WIDTH round pairs; included once per width after physics/contact/contact_step.h.
 *
 * Loads what contact_step wants from packed bodies and columns of pairs, adds the forces to the rows of the bodies, and
 * writes the history back.
 */

/* Copies of the pass: */
#ifndef PAIR_PASS_COMMON
#define PAIR_PASS_COMMON
enum {
  PASS_PAPER = 1 /* the paper's tangential force */,
  PASS_LAWS = 2 /* laws differ from pair to pair */,
  PASS_MIXED = 4 /* likewise, and not all are linear */
};
#endif

/* A vector of pairs: lanes l ... of a block, and the flags of that block. */
typedef struct LANE(location) {
  pair_block *b;
  size_t l;
} LANE(location);

LANE_INLINE LANE(contact_constants) LANE(constants)(const work *w) {
  return (LANE(contact_constants)){.k_n = LANE(splat)(w->laws->k_n),
                                   .k_t = LANE(splat)(w->laws->k_t),
                                   .half_k_t = LANE(splat)(0.5 * w->laws->k_t),
                                   .gamma_n = LANE(splat)(w->laws->gamma_n),
                                   .cap = LANE(splat)(w->laws->cap)};
}

LANE_INLINE LANE(contact_constants) LANE(constants_of)(const work *w, const int32_t *law, const int mixed) {
  double row[6][LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++) {
    const law_row *r = &w->laws[law[l]];
    row[0][l] = r->k_n;
    row[1][l] = r->k_t;
    row[2][l] = r->gamma_n;
    row[3][l] = r->cap;
    if (!mixed) continue;
    row[4][l] = r->normal;
    row[5][l] = r->tsuji;
  }
  LANE(contact_constants) k;
  k.k_n = LANE(load)(row[0]);
  k.k_t = LANE(load)(row[1]);
  k.half_k_t = 0.5 * k.k_t;
  k.gamma_n = LANE(load)(row[2]);
  k.cap = LANE(load)(row[3]);
  k.normal = k.tsuji = LANE(splat)(0.0);
  if (!mixed) return k;
  k.normal = LANE(load)(row[4]);
  k.tsuji = LANE(load)(row[5]);
  return k;
}

/* The masses of a vector of round pairs enter by sqrt(m_eff k_n); that of prescribed bodies is infinite. */
LANE_INLINE LANE(contact_constants) LANE(constants_mixed)(const work *w, LANE(location) at) {
  LANE(contact_constants) k = LANE(constants_of)(w, at.b->law + at.l, 1);
  const double *inverse_mass = w->packed + PACKED_INVERSE_MASS;
  LANE(real)
  inverse =
      LANE(gather)(inverse_mass, at.b->packed_a + at.l) + LANE(gather)(inverse_mass, at.b->packed_b + at.l);
  k.tsuji = k.tsuji * LANE(sqrt)(k.k_n / LANE(max)(inverse, LANE(splat)(1e-300)));
  return k;
}

LANE_INLINE void LANE(load_memory)(LANE(location) at, const int paper, LANE(contact_memory) * m) {
  const pair_block *b = at.b;
  m->lambda_ref = LANE(load)(b->lambda_ref + at.l);
  m->force = LANE(load)(b->force + at.l);
  m->overlap = LANE(load)(b->overlap + at.l);
  m->zeta = LANE(load)(b->zeta + at.l);
  m->turned = paper ? LANE(load)(b->turned + at.l) : LANE(splat)(0.0);
}

LANE_INLINE void LANE(add_loss)(double *sum, LANE(real) loss) { LANE(store)(sum, LANE(load)(sum) + loss); }

LANE_INLINE void LANE(store_memory)(LANE(location) at, const int paper, const LANE(contact_memory) * m,
                                    const LANE(contact_output) * out) {
  pair_block *b = at.b;
  LANE(add_loss)(b->viscous + at.l, out->viscous);
  LANE(add_loss)(b->friction + at.l, out->friction);
  if (paper) LANE(add_loss)(b->nonconservative_work + at.l, out->work);
  LANE(store)(b->lambda_ref + at.l, m->lambda_ref);
  LANE(store)(b->force + at.l, m->force);
  LANE(store)(b->overlap + at.l, m->overlap);
  LANE(store)(b->zeta + at.l, m->zeta);
  if (paper) LANE(store)(b->turned + at.l, m->turned);
}

/* Sets flags of lanes l ... */
LANE_INLINE void LANE(set_flags)(uint8_t *flags, size_t l, unsigned bits) {
  const unsigned all = (1u << LANE_WIDTH) - 1u;
  *flags = (uint8_t)((*flags & ~(all << l)) | bits << l);
}

LANE_INLINE void LANE(set_slides)(pair_flags *flags, size_t l, LANE(real) slip) {
  const LANE(real) zero = LANE(splat)(0.0);
  LANE(set_flags)(&flags->slides_positive, l, LANE(bits_of)(LANE(greater)(zero, slip)));
  LANE(set_flags)(&flags->slides_negative, l, LANE(bits_of)(LANE(greater)(slip, zero)));
}

/* Adds the force to b's row, and its opposite to a's. */
LANE_INLINE void LANE(scatter)(double *sum, LANE(location) at, const LANE(contact_output) * out) {
  const LANE(real)
      row[SUM_ROW] = {[SUM_X] = out->fx, [SUM_Y] = out->fy, [SUM_TURN] = out->tau, [3] = LANE(splat)(0.0)};
  LANE(add4)(sum, at.b->sum_b + at.l, at.b->sum_a + at.l, row);
}

/* Notes pairs whose rare event is treated after the pass. */
LANE_INLINE void LANE(note)(const pairs *p, thread_work *mine, LANE(location) at, LANE(mask) which,
                            LANE(mask) was_closed, LANE(real) dropped) {
  double drop[LANE_WIDTH];
  LANE(store)(drop, dropped);
  for (size_t l = 0; l < LANE_WIDTH; l++)
    if (LANE(lane_is)(which, (int)l))
      event_add_pair(&mine->events, p, (size_t)(at.b - p->block) * PAIR_BLOCK + at.l + l,
                     LANE(lane_is)(was_closed, (int)l), drop[l]);
}

/* Geometry of a vector of pairs, as far as the root and the division. */
LANE_INLINE void LANE(distance)(const work *w, LANE(location) at, LANE(pair_distance) * d) {
  LANE(real) pose[4], speed[2];
  LANE(across4)(w->packed, at.b->packed_a + at.l, at.b->packed_b + at.l, pose);
  LANE(across2)(w->packed + PACKED_VX, at.b->packed_a + at.l, at.b->packed_b + at.l, speed);
  LANE(pair_input)
  in = {.dx = pose[PACKED_X],
        .dy = pose[PACKED_Y],
        .dvx = speed[0],
        .dvy = speed[1],
        .sum = pose[PACKED_RADIUS],
        .arc = pose[PACKED_ARC],
        .ex = LANE(load)(at.b->ex + at.l),
        .ey = LANE(load)(at.b->ey + at.l)};
  if (w->periodic[0]) in.dx = in.dx - w->length[0] * LANE(nearest)(in.dx * w->inverse_length[0]);
  if (w->periodic[1]) in.dy = in.dy - w->length[1] * LANE(nearest)(in.dy * w->inverse_length[1]);
  LANE(pair_distance_of)(&in, d);
}

/* dt^2/2 times the relative acceleration along n, of free disks. */
LANE_INLINE LANE(real) LANE(bent_of)(const engine *e, LANE(location) at, LANE(real) nx, LANE(real) ny) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double x[LANE_WIDTH], y[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l + l;
    const int32_t a = p->a[k], b = p->b[k];
    const bool free_a = a >= 0 && (size_t)a < s->n_free, free_b = b >= 0 && (size_t)b < s->n_free;
    x[l] = (free_b ? s->x2[b] : 0.0) - (free_a ? s->x2[a] : 0.0);
    y[l] = (free_b ? s->y2[b] : 0.0) - (free_a ? s->y2[a] : 0.0);
  }
  return nx * LANE(load)(x) + ny * LANE(load)(y);
}

/* A vector of contacts of which some begin, end, turn far or overlap deeply. */
static __attribute__((noinline, cold)) void LANE(contact_evaluate_slow)(engine *e, thread_work *mine,
                                                                        LANE(location) at,
                                                                        const LANE(pair_geometry) * g,
                                                                        int kind) {
  work *w = &e->work;
  pair_block *b = at.b;
  pair_flags *flags = &w->pairs.flags[b - w->pairs.block];
  const int paper = kind & PASS_PAPER;
  const int mixed = kind & PASS_MIXED;
  const LANE(contact_constants) k =
      mixed ? LANE(constants_mixed)(w, at) : LANE(constants_of)(w, b->law + at.l, 0);
  const LANE(mask) touching = LANE(greater)(g->reach, LANE(splat)(0.0)) & LANE(has_direction)(g);
  const LANE(mask) was_closed = LANE(mask_of)((unsigned)flags->closed >> at.l);
  const LANE(mask) closed = touching & was_closed;
  LANE(contact_memory) m, before;
  LANE(contact_output) out;
  LANE(load_memory)(at, paper, &m);
  m.ex = LANE(load)(b->ex + at.l);
  m.ey = LANE(load)(b->ey + at.l);
  before = m;
  LANE(contact_step)(g, &k, touching, closed, paper ? LANE(splat)(1.0) : g->lever, paper, mixed, &m, &out);
  LANE(contact_begin_end)
  (g, &k, touching, closed, was_closed, LANE(splat)(w->dt), LANE(bent_of)(e, at, g->nx, g->ny), &before, &m,
   &out);

  LANE(real) of_a[4], of_b[4];
  LANE(gather4)(w->packed, b->packed_a + at.l, of_a);
  LANE(gather4)(w->packed, b->packed_b + at.l, of_b);
  LANE(real) rb = of_b[PACKED_RADIUS], smaller = LANE(min)(of_a[PACKED_RADIUS], LANE(max)(rb, -rb));
  const LANE(mask) which =
      (touching ^ was_closed) | (LANE(contact_is_deep)(g, e->model->max_overlap * smaller) & touching);
  if (LANE(any)(which)) LANE(note)(&w->pairs, mine, at, which, was_closed, out.dropped);
  LANE(scatter)(w->sums.row, at, &out);
  LANE(store_memory)(at, paper, &m, &out);
  LANE(store)(b->ex + at.l, m.ex);
  LANE(store)(b->ey + at.l, m.ey);
  LANE(set_flags)(&flags->closed, at.l, LANE(bits_of)(touching));
  LANE(set_slides)(flags, at.l, out.slip);
}

/* The same for all pairs of a pass. */
typedef struct LANE(pass_constants) {
  LANE(contact_constants) law; /* unless PASS_LAWS */
  LANE(real) limit;            /* overlap of the smallest body beyond which contacts are examined */
} LANE(pass_constants);

LANE_INLINE LANE(pass_constants) LANE(pass_constants_of)(const work *w) {
  return (LANE(pass_constants)){LANE(constants)(w), LANE(splat)(w->least_limit)};
}

/* Evaluates the pairs `at` at distance *d; then *d becomes that of the pairs `next`: between history and force, where
 * measurements say that it delays neither. */
LANE_INLINE void LANE(contact_evaluate)(engine *e, thread_work *mine, LANE(location) at, LANE(location) next,
                                        pair_flags *flags, LANE(pair_distance) * d,
                                        const LANE(pass_constants) * constants, double *sum, const int kind) {
  const work *w = &e->work;
  const int paper = kind & PASS_PAPER;
  LANE(pair_geometry) g;
  LANE(pair_geometry_at)(d, &g);
  const LANE(mask) touching = LANE(greater)(g.reach, LANE(splat)(0.0));
  const unsigned all = (1u << LANE_WIDTH) - 1u, closed = (unsigned)flags->closed >> at.l & all;
  if (__builtin_expect(
          LANE(bits_of)(touching) != closed || LANE(any)(LANE(contact_is_deep)(&g, constants->limit)), 0)) {
    LANE(contact_evaluate_slow)(e, mine, at, &g, kind);
    LANE(distance)(w, next, d);
    return;
  }
  const int mixed = kind & PASS_MIXED;
  const LANE(contact_constants) k = mixed              ? LANE(constants_mixed)(w, at)
                                    : kind & PASS_LAWS ? LANE(constants_of)(w, at.b->law + at.l, 0)
                                                       : constants->law;
  LANE(contact_memory) m;
  LANE(contact_output) out;
  LANE(load_memory)(at, paper, &m);
  LANE(contact_history)(&g, &k, touching, touching, paper, mixed, &m, &out);
  LANE(store_memory)(at, paper, &m, &out);
  LANE(set_slides)(flags, at.l, out.slip);
  LANE(distance)(w, next, d);
  LANE(contact_force)(&g, &k, paper ? LANE(splat)(1.0) : g.lever, &m, &out);
  LANE(scatter)(sum, at, &out);
}
