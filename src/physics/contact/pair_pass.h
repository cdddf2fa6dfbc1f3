/* pair_pass.h: one evaluation of LANE_WIDTH pairs of round bodies; included once per width after
 * physics/contact/contact_step.h.
 *
 * It loads the input of contact_step from packed bodies and from the columns of pairs, adds the
 * forces to the force sums of the bodies, and writes the contact records back.
 */

#ifndef PAIR_PASS_COMMON
#define PAIR_PASS_COMMON
#include <stddef.h>

/* Returns bits: bit k is set if the contact in lane l + k of the block slid in the previous
 * step. */
static inline unsigned slides_at(const pair_flags *flags, size_t l) {
  return (unsigned)(flags->slides_positive | flags->slides_negative) >> l;
}
/* Bits of `kind`, the kind of a pass. The pass is compiled once for each combination that is
 * used. */
enum {
  PASS_PAPER = 1 /* tangential force of the paper's variant (docs/physics.md, section 3) */,
  PASS_LAWS = 2 /* contact laws differ from pair to pair; all are linear with damping gamma_n */,
  PASS_MIXED = 4 /* contact laws differ, and some are not linear with damping gamma_n */,
  PASS_CELL = 8 /* the periodic box deforms, so forces across its edges are noted */,
  PASS_GENERAL = 16 /* laws may have any of the features in model/law_features.h */
};
#endif

/* Location of a vector of LANE_WIDTH pairs in the list: pairs l, l + 1, ... of block *b. */
typedef struct LANE(location) {
  pair_block *b;
  size_t l;
} LANE(location);

/* Returns the constants of the single law of a pass in which all pairs have the same, linear
 * law. */

LANE_INLINE LANE(contact_constants) LANE(constants)(const work *w) {
  return (LANE(contact_constants)){.k_n = LANE(splat)(w->laws->k_n),
                                   .k_t = LANE(splat)(w->laws->k_t),
                                   .half_k_t = LANE(splat)(0.5 * w->laws->k_t),
                                   .gamma_n = LANE(splat)(w->laws->gamma_n),
                                   .cap = LANE(splat)(w->laws->cap)};
}

/* Loads the constants of the laws of LANE_WIDTH pairs. mixed: not 0 if they include normal and
 * tsuji (LAW_NORMAL); tsuji then lacks the factor sqrt(m_eff k_n). */
LANE_INLINE LANE(contact_constants)
    LANE(constants_of)(const work *w, const int32_t *law, const int mixed) {
  double row[6][LANE_WIDTH];
  if (w->one_law) {
    LANE(contact_constants) one = LANE(constants)(w);
    one.normal = LANE(splat)(w->laws->normal);
    one.tsuji = LANE(splat)(w->laws->tsuji);
    return one;
  }
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

/* Loads one member of law_row, at byte offset `member`, for the laws of LANE_WIDTH pairs. */
LANE_INLINE LANE(real) LANE(law_number)(const work *w, const int32_t *law, size_t member) {
  double row[LANE_WIDTH];
  if (w->one_law) {
    memcpy(row, (const char *)w->laws + member, sizeof *row);
    return LANE(splat)(row[0]);
  }
  for (int l = 0; l < LANE_WIDTH; l++)
    memcpy(&row[l], (const char *)&w->laws[law[l]] + member, sizeof *row);
  return LANE(load)(row);
}
#define LAW_NUMBER(member) LANE(law_number)(w, law, offsetof(law_row, member))

/* Sets the constants of general laws, in addition to those of constants_of. */
LANE_INLINE void LANE(constants_general)(const work *w, const int32_t *law, const unsigned features,
                                         LANE(contact_constants) * k) {
  const LANE(real) zero = LANE(splat)(0.0);
#define LAW_LOAD(bits, name, value) k->name = features & (bits) ? LAW_NUMBER(name) : zero;
  LAW_CONSTANTS(LAW_LOAD)
#undef LAW_LOAD
}
#undef LAW_NUMBER

/* Loads the constants of round pairs with LAW_NORMAL: like constants_of, with the factor sqrt(m_eff
 * k_n) of tsuji, where 1/m_eff = 1/m_a + 1/m_b. The mass of prescribed bodies is infinite. */
LANE_INLINE LANE(contact_constants) LANE(constants_mixed)(const work *w, LANE(location) at) {
  LANE(contact_constants) k = LANE(constants_of)(w, at.b->law + at.l, 1);
  const double *inverse_mass = w->packed + PACKED_INVERSE_MASS;
  LANE(real)
  inverse = LANE(gather)(inverse_mass, at.b->packed_a + at.l) +
            LANE(gather)(inverse_mass, at.b->packed_b + at.l);
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

/* Loads the constants of LANE_WIDTH round pairs that a pass of this kind needs. */
LANE_INLINE LANE(contact_constants)
    LANE(constants_for)(const work *w, LANE(location) at, const int kind, const unsigned features) {
  if (!(kind & (PASS_MIXED | PASS_GENERAL))) return LANE(constants_of)(w, at.b->law + at.l, 0);
  LANE(contact_constants)
  k = features & LAW_NORMAL ? LANE(constants_mixed)(w, at)
                            : LANE(constants_of)(w, at.b->law + at.l, 0);
  if (kind & PASS_GENERAL) LANE(constants_general)(w, at.b->law + at.l, features, &k);
  if (__builtin_expect(features & LAW_RADIUS, 0)) {
    const double *radius = w->packed + PACKED_RADIUS;
    LANE(scale_by_radius)
    (LANE(effective_radius)(LANE(gather)(radius, at.b->packed_a + at.l),
                            LANE(gather)(radius, at.b->packed_b + at.l)),
     &k);
  }
  if (__builtin_expect(features & LAW_BEAM, 0)) {
    const double *radius = w->packed + PACKED_RADIUS;
    const LANE(real) ra = LANE(gather)(radius, at.b->packed_a + at.l),
                     rb = LANE(gather)(radius, at.b->packed_b + at.l);
    const size_t first = (size_t)(at.b - w->pairs.block) * PAIR_BLOCK + at.l;
    double of_disk[LANE_WIDTH]; /* a wall adds no length */
    LANE(store)(of_disk, rb);
    for (size_t l = 0; l < LANE_WIDTH; l++)
      if (w->pairs.b[first + l] >= w->n_disks) of_disk[l] = 0.0;
    LANE(scale_by_length)(ra + LANE(load)(of_disk), LANE(effective_radius)(ra, rb), &k);
  }
  return k;
}

/* Returns the LAW_ bits (model/law_features.h) that a pass of this kind evaluates. They are a
 * compile-time constant unless the pass is general. */
LANE_INLINE unsigned LANE(features_of)(const work *w, const int kind) {
  return kind & PASS_GENERAL ? w->features : kind & PASS_MIXED ? LAW_NORMAL : 0;
}

LANE_INLINE pair_more *LANE(more_of)(const work *w, LANE(location) at) {
  return &w->pairs.more[at.b - w->pairs.block];
}

/* Loads the part of the contact record that only general laws have; load_memory loads the other
 * part. slides: bit k is set if the contact in lane k slid in the previous step. */
LANE_INLINE void LANE(load_more)(const pair_more *more, size_t l, const unsigned features,
                                 unsigned slides, LANE(contact_memory) * m) {
  m->slid = LANE(mask_of)(slides);
#define MEMORY_LOAD(name, unit, meaning, laws)                                                     \
  m->name = LAW_NEEDS(features, laws) ? LANE(load)(more->name + l) : LANE(splat)(0.0);
  SD_CONTACT_MEMORY(MEMORY_LOAD)
#undef MEMORY_LOAD
}

LANE_INLINE void LANE(add_loss)(double *sum, LANE(real) loss) {
  LANE(store)(sum, LANE(load)(sum) + loss);
}

/* all: also what only changes when contacts begin, end or break. */
LANE_INLINE void LANE(store_more)(pair_more *more, size_t l, const unsigned features, const int all,
                                  const LANE(contact_memory) * m,
                                  const LANE(contact_output) * out) {
#define MEMORY_STORE(name, unit, meaning, laws)                                                    \
  if (LAW_NEEDS(features, laws) && (all || LAW_CHANGES(laws))) LANE(store)(more->name + l, m->name);
#define LOSS_STORE(name, unit, meaning, laws)                                                      \
  if (LAW_NEEDS(features, laws)) LANE(add_loss)(more->name + l, out->name);
  SD_CONTACT_MEMORY(MEMORY_STORE)
  SD_CONTACT_LOSSES(LOSS_STORE)
#undef MEMORY_STORE
#undef LOSS_STORE
}

/* Stores the contact records of LANE_WIDTH pairs, and adds the losses of this step to the sums in
 * the records. */
LANE_INLINE void LANE(store_memory)(LANE(location) at, const int paper,
                                    const LANE(contact_memory) * m,
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

/* Sets the flags of lanes l to l + LANE_WIDTH - 1 in *flags to `bits`. */
LANE_INLINE void LANE(set_flags)(uint8_t *flags, size_t l, unsigned bits) {
  const unsigned all = (1u << LANE_WIDTH) - 1u;
  *flags = (uint8_t)((*flags & ~(all << l)) | bits << l);
}

LANE_INLINE void LANE(set_slides)(pair_flags *flags, size_t l, LANE(real) slip) {
  const LANE(real) zero = LANE(splat)(0.0);
  LANE(set_flags)(&flags->slides_positive, l, LANE(bits_of)(LANE(greater)(zero, slip)));
  LANE(set_flags)(&flags->slides_negative, l, LANE(bits_of)(LANE(greater)(slip, zero)));
}

/* Adds the contact forces to the force sums of both bodies: the force to that of b, the opposite
 * force to that of a, and tau (torque divided by radius) to both. */
LANE_INLINE void LANE(scatter)(double *sum, LANE(location) at, const LANE(contact_output) * out) {
  const LANE(real) row[SUM_ROW] = {[SUM_X] = out->fx,
                                   [SUM_Y] = out->fy,
                                   [SUM_TORQUE] = out->tau,
                                   [SUM_COUPLE] = LANE(splat)(0.0)};
  LANE(add4)(sum, at.b->sum_b + at.l, at.b->sum_a + at.l, row);
}

/* Adds the torque of rolling resistance to the force sum of a, and the opposite torque to that of
 * b. For a round wall it is added to the sum of torques that are divided by the radius. */
LANE_INLINE void LANE(scatter_couple)(const engine *e, LANE(location) at,
                                      const LANE(contact_output) * out) {
  const pairs *p = &e->work.pairs;
  const size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l;
  double couple[LANE_WIDTH], *sum = e->work.sums.row;
  LANE(store)(couple, out->couple);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    double *on_a = sum + at.b->sum_a[at.l + l], *on_b = sum + at.b->sum_b[at.l + l];
    on_a[SUM_COUPLE] += couple[l];
    if (p->b[k + l] < (int32_t)e->state->n_disks)
      on_b[SUM_COUPLE] -= couple[l];
    else
      on_b[SUM_TORQUE] -= couple[l] / e->state->radius[p->b[k + l]];
  }
}

/* Computes dlambda/dt and the rolling displacement of pairs of round bodies, if their laws need
 * these in every step. */
LANE_INLINE void LANE(turning)(const work *w, LANE(location) at, const unsigned features,
                               const LANE(pair_distance) * d, LANE(pair_geometry) * g) {
  LANE(real) spin_a, spin_b;
  if (!(features & (LAW_DASHPOT | LAW_ROLLING))) return;
  spin_a = LANE(gather)(w->packed + PACKED_SPIN, at.b->packed_a + at.l);
  spin_b = LANE(gather)(w->packed + PACKED_SPIN, at.b->packed_b + at.l);
  g->slide = (spin_b + spin_a) - g->lever * (d->cross_velocity * d->inverse_r);
  if (!(features & LAW_ROLLING)) return;
  LANE(real) of_a[4], of_b[4];
  LANE(gather4)(w->packed, at.b->packed_a + at.l, of_a);
  LANE(gather4)(w->packed, at.b->packed_b + at.l, of_b);
  LANE(rolled)
  (of_a[PACKED_RADIUS], of_b[PACKED_RADIUS], of_a[PACKED_ARC], of_b[PACKED_ARC], spin_a, spin_b, g);
}

/* Sets at[] to the middle of the gap or overlap of pair k, as the bodies are evaluated in this
 * step. It is measured from the body with the lower number, so that it is the same on all ranks. */
static inline void LANE(place_of)(const engine *e, size_t k, double at[2]) {
  const work *w = &e->work;
  const sd_state *s = e->state;
  const int32_t a = w->pairs.a[k], b = w->pairs.b[k];
  if (pairs_is_segment(&w->pairs, k)) {
    placed_segment image;
    const nearest_point q = walls_nearest(
        walls_image(w->length, &w->segments[w->pairs.part[k]], s->x[a], s->y[a], &image), s->x[a],
        s->y[a]);
    at[0] = s->x[a] + q.dx;
    at[1] = s->y[a] + q.dy;
    return;
  }
  const bool first = s->id[a] < s->id[b];
  const double *from = w->packed + PACKED_ROW * w->row[first ? a : b],
               *to = w->packed + PACKED_ROW * w->row[first ? b : a];
  double dx = to[PACKED_X] - from[PACKED_X], dy = to[PACKED_Y] - from[PACKED_Y];
  box_nearest(w, &dx, &dy);
  const double r = sqrt(dx * dx + dy * dy),
               part = 0.5 * (1.0 + (from[PACKED_RADIUS] - fabs(to[PACKED_RADIUS])) / r);
  at[0] = from[PACKED_X] + part * dx;
  at[1] = from[PACKED_Y] + part * dy;
}

/* Appends a rare event for each pair in the lanes `which`. Events are handled after all pairs have
 * been evaluated. */
LANE_INLINE void LANE(note)(const engine *e, thread_work *mine, LANE(location) at, LANE(mask) which,
                            LANE(mask) was_closed, LANE(real) dropped,
                            const LANE(bond_output) * bond) {
  const pairs *p = &e->work.pairs;
  double drop[LANE_WIDTH], mode[LANE_WIDTH], broken[LANE_WIDTH];
  LANE(store)(drop, dropped);
  LANE(store)(mode, bond->mode);
  LANE(store)(broken, bond->broken);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    if (!LANE(lane_is)(which, (int)l)) continue;
    const size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l + l;
    event v = {.was_closed = LANE(lane_is)(was_closed, (int)l),
               .dropped = drop[l],
               .broken = broken[l],
               .mode = (int)mode[l]};
    if (v.mode) LANE(place_of)(e, k, v.place);
    event_add_pair(&mine->events, p, k, &v);
  }
}

/* Computes the first part of the geometry of a vector of pairs of round bodies, up to 1/r. In a
 * periodic box it uses the nearest image of b. */
LANE_INLINE void LANE(distance)(const work *w, LANE(location) at, const int kind,
                                LANE(pair_distance) * d) {
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
  if (kind & PASS_CELL) {
    const LANE(real) ny = LANE(nearest)(in.dy * w->inverse_length[1]);
    in.dx = in.dx - w->offset * ny;
    const LANE(real) nx = LANE(nearest)(in.dx * w->inverse_length[0]);
    in.dx = in.dx - w->length[0] * nx;
    in.dy = in.dy - w->length[1] * ny;
    in.dvx = in.dvx - (w->cell.speed[0] * nx + w->cell.speed[2] * ny);
    in.dvy = in.dvy - w->cell.speed[1] * ny;
    d->away = nx * nx + ny * ny;
  } else {
    if (w->periodic[0]) in.dx = in.dx - w->length[0] * LANE(nearest)(in.dx * w->inverse_length[0]);
    if (w->periodic[1]) in.dy = in.dy - w->length[1] * LANE(nearest)(in.dy * w->inverse_length[1]);
  }
  LANE(pair_distance_of)(&in, d);
  if (kind & PASS_GENERAL) d->cross_velocity = in.dx * in.dvy - in.dy * in.dvx;
}

/* Returns R omega of the body in this slot, 0 for padding. Only packed bodies have that of ghosts
 * and, in a window of steps, of prescribed bodies in the step of this engine. */
static inline double LANE(spin_in)(const engine *e, int32_t slot) {
  if (slot < 0) return 0.0;
  if ((size_t)slot >= e->state->n_free)
    return e->work.packed[PACKED_ROW * e->work.row[slot] + PACKED_SPIN];
  return body_spin(e->state, (size_t)slot);
}

/* Returns dlambda/dt of pairs of round bodies. It is called only when a contact begins; other steps
 * need it only with a tangential dashpot. */
LANE_INLINE LANE(real) LANE(slide_of)(const engine *e, LANE(location) at, const int kind,
                                      const LANE(pair_geometry) * g) {
  const pairs *p = &e->work.pairs;
  const size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l;
  double a[LANE_WIDTH], b[LANE_WIDTH];
  LANE(pair_distance) d;
  LANE(distance)(&e->work, at, kind | PASS_GENERAL, &d);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    a[l] = LANE(spin_in)(e, p->a[k + l]);
    b[l] = LANE(spin_in)(e, p->b[k + l]);
  }
  return (LANE(load)(b) + LANE(load)(a)) - g->lever * (d.cross_velocity * d.inverse_r);
}

/* Returns dt^2/2 times the acceleration of b relative to a along the normal n. Prescribed bodies
 * count as not accelerated. */
LANE_INLINE LANE(real)
    LANE(bent_of)(const engine *e, LANE(location) at, LANE(real) nx, LANE(real) ny) {
  const pairs *p = &e->work.pairs;
  double x[LANE_WIDTH], y[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const size_t k = (size_t)(at.b - p->block) * PAIR_BLOCK + at.l + l;
    const int32_t a = p->a[k], b = p->b[k];
    x[l] = halo_second(e, b, SD_X) - halo_second(e, a, SD_X);
    y[l] = halo_second(e, b, SD_Y) - halo_second(e, a, SD_Y);
  }
  return nx * LANE(load)(x) + ny * LANE(load)(y);
}

/* Stores the forces of closed contacts with a periodic image of b, which do work when the box
 * deforms, in the list of crossings. */
static __attribute__((noinline)) void LANE(note_crossings)(const work *w, thread_work *mine,
                                                           LANE(location) at,
                                                           const LANE(contact_output) * out) {
  const unsigned closed = w->pairs.flags[at.b - w->pairs.block].closed;
  double fx[LANE_WIDTH], fy[LANE_WIDTH];
  LANE(store)(fx, out->fx);
  LANE(store)(fy, out->fy);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const double *a = w->packed + at.b->packed_a[at.l + l],
                 *b = w->packed + at.b->packed_b[at.l + l];
    double dx = b[PACKED_X] - a[PACKED_X], dy = b[PACKED_Y] - a[PACKED_Y];
    const box_image n = box_nearest(w, &dx, &dy);
    if (closed >> (at.l + l) & 1u && (n.x != 0.0 || n.y != 0.0))
      crossing_add(&mine->crossings, &(crossing){fx[l], fy[l], n.x, n.y});
  }
}

/* Evaluates a vector of contacts if some of them begin or end, have turned far from their reference
 * direction, or overlap deeply. *g: geometry of the pairs, computed by the caller. */
static __attribute__((noinline, cold)) void
LANE(contact_evaluate_slow)(engine *e, thread_work *mine, LANE(location) at,
                            LANE(pair_geometry) * g, int kind) {
  work *w = &e->work;
  pair_block *b = at.b;
  pair_flags *flags = &w->pairs.flags[b - w->pairs.block];
  const int paper = kind & PASS_PAPER;
  const unsigned features = LANE(features_of)(w, kind);
  const LANE(contact_constants) k = LANE(constants_for)(w, at, kind, features);
  const LANE(mask) was_closed = LANE(mask_of)((unsigned)flags->closed >> at.l);
  LANE(contact_memory) m, before;
  LANE(contact_output) out;
  LANE(load_memory)(at, paper, &m);
  if (kind & PASS_GENERAL)
    LANE(load_more)(LANE(more_of)(w, at), at.l, features, slides_at(flags, at.l), &m);
  m.ex = LANE(load)(b->ex + at.l);
  m.ey = LANE(load)(b->ey + at.l);
  g->slide = LANE(slide_of)(e, at, kind, g);
  LANE(bond_output) bond;
  LANE(bond_step)(g, &k, LANE(has_direction)(g), paper, features, &m, &bond);
  before = m;
  const LANE(mask) touching =
      LANE(contact_touches)(g, &k, &m, was_closed, features) & LANE(has_direction)(g);
  const LANE(mask) closed = touching & was_closed;
  LANE(contact_begin)
  (g, &k, LANE(surfaces_meet)(g, &k, &before, touching, was_closed, features), LANE(splat)(w->dt),
   features, &m);
  LANE(contact_history)(g, &k, touching, closed, paper, features, &m, &out);
  LANE(contact_begin_end)
  (g, &k, touching, was_closed, LANE(splat)(w->dt), LANE(bent_of)(e, at, g->nx, g->ny), features,
   &before, &m, &out);
  if (features & LAW_BOND) LANE(bond_add)(g, &bond, &m, &out);
  LANE(contact_force)(g, &k, paper ? LANE(splat)(1.0) : g->lever, features, &m, &out);

  LANE(real) of_a[4], of_b[4];
  LANE(gather4)(w->packed, b->packed_a + at.l, of_a);
  LANE(gather4)(w->packed, b->packed_b + at.l, of_b);
  LANE(real) rb = of_b[PACKED_RADIUS], smaller = LANE(min)(of_a[PACKED_RADIUS], LANE(max)(rb, -rb));
  const LANE(mask) which = (touching ^ was_closed) |
                           (LANE(contact_is_deep)(g, e->work.max_overlap * smaller) & touching) |
                           bond.breaks;
  if (features & LAW_BRIDGE) out.dropped = out.dropped + out.bridge;
  if (LANE(any)(which)) LANE(note)(e, mine, at, which, was_closed, out.dropped, &bond);
  LANE(scatter)(w->sums.row, at, &out);
  LANE(store_memory)(at, paper, &m, &out);
  if (kind & PASS_GENERAL) LANE(store_more)(LANE(more_of)(w, at), at.l, features, 1, &m, &out);
  if (features & LAW_ROLLING) LANE(scatter_couple)(e, at, &out);
  LANE(store)(b->ex + at.l, m.ex);
  LANE(store)(b->ey + at.l, m.ey);
  LANE(set_flags)(&flags->closed, at.l, LANE(bits_of)(touching));
  LANE(set_slides)(flags, at.l, out.slip);
  if (kind & PASS_CELL) LANE(note_crossings)(w, mine, at, &out);
}

/* Constants that are the same for all pairs of a pass. */
typedef struct LANE(pass_constants) {
  LANE(contact_constants) law; /* used if all pairs have the same linear law */
  LANE(real) limit; /* overlap above which the slow path is taken: max_overlap * smallest radius */
} LANE(pass_constants);

LANE_INLINE LANE(pass_constants) LANE(pass_constants_of)(const work *w) {
  return (LANE(pass_constants)){LANE(constants)(w), LANE(splat)(w->least_limit)};
}

/* Evaluates the pairs at `at`, the first part of whose geometry is *d, and sets *d to that of the
 * pairs at `next`. The latter is done between history and force of the pairs at `at`, where by
 * measurement it delays neither. sum: rows of force sums; kind: bits PASS_..., a compile-time
 * constant. */
LANE_INLINE void LANE(contact_evaluate)(engine *e, thread_work *mine, LANE(location) at,
                                        LANE(location) next, pair_flags *flags,
                                        LANE(pair_distance) * d,
                                        const LANE(pass_constants) * constants, double *sum,
                                        const int kind) {
  const work *w = &e->work;
  const int paper = kind & PASS_PAPER;
  const unsigned features = LANE(features_of)(w, kind);
  LANE(pair_geometry) g;
  LANE(pair_geometry_at)(d, &g);
  const unsigned all = (1u << LANE_WIDTH) - 1u, closed = (unsigned)flags->closed >> at.l & all;
  LANE(contact_constants) k;
  LANE(contact_memory) m;
  if (kind & PASS_GENERAL) {
    LANE(load_memory)(at, paper, &m);
    LANE(load_more)(LANE(more_of)(w, at), at.l, features, slides_at(flags, at.l), &m);
    k = LANE(constants_for)(w, at, kind, features);
    LANE(turning)(w, at, features, d, &g);
  }
  LANE(mask) rare = LANE(contact_is_deep)(&g, constants->limit);
  LANE(bond_output) bond;
  if (kind & PASS_GENERAL) {
    LANE(bond_step)(&g, &k, LANE(all_lanes)(1), paper, features, &m, &bond);
    rare = rare | bond.breaks;
  }
  const LANE(mask) touching =
      kind & PASS_GENERAL ? LANE(contact_touches)(&g, &k, &m, LANE(mask_of)(closed), features)
                          : LANE(greater)(g.reach, LANE(splat)(0.0));
  if (kind & PASS_GENERAL && features & LAW_GAP)
    rare = rare | LANE(surfaces_meet)(&g, &k, &m, touching, LANE(mask_of)(closed), features);
  if (__builtin_expect(LANE(bits_of)(touching) != closed || LANE(any)(rare), 0)) {
    LANE(contact_evaluate_slow)(e, mine, at, &g, kind);
    LANE(distance)(w, next, kind, d);
    return;
  }
  if (!(kind & PASS_GENERAL))
    k = kind & (PASS_MIXED | PASS_LAWS) ? LANE(constants_for)(w, at, kind, features)
                                        : constants->law;
  LANE(contact_output) out;
  if (!(kind & PASS_GENERAL)) LANE(load_memory)(at, paper, &m);
  LANE(contact_history)(&g, &k, touching, touching, paper, features, &m, &out);
  if (kind & PASS_GENERAL && features & LAW_BOND) LANE(bond_add)(&g, &bond, &m, &out);
  LANE(store_memory)(at, paper, &m, &out);
  if (kind & PASS_GENERAL) LANE(store_more)(LANE(more_of)(w, at), at.l, features, 0, &m, &out);
  LANE(set_slides)(flags, at.l, out.slip);
  const LANE(mask) across =
      kind & PASS_CELL ? touching & LANE(greater)(d->away, LANE(splat)(0.0)) : touching;
  LANE(distance)(w, next, kind, d);
  LANE(contact_force)(&g, &k, paper ? LANE(splat)(1.0) : g.lever, features, &m, &out);
  LANE(scatter)(sum, at, &out);
  if (features & LAW_ROLLING) LANE(scatter_couple)(e, at, &out);
  if (kind & PASS_CELL && LANE(any)(across)) LANE(note_crossings)(w, mine, at, &out);
}
