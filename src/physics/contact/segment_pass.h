/* segment_pass.h: one evaluation of LANE_WIDTH pairs of a disk and a wall segment; included once
 * per width after physics/contact/pair_pass.h. The nearest points are found one by one; the contact
 * law is the same as for round bodies. */

/* Data that only pairs with wall segments have, for LANE_WIDTH pairs; arrays are indexed by
 * lane. */
typedef struct LANE(nearest_points) {
  nearest_point q[LANE_WIDTH];
  /* Lever of the tangential force if the nearest point lies between the ends of the segment (1 on a
   * straight segment, see walls_lever); 0 if it is an end. */
  double flat[LANE_WIDTH];
  /* side of the wall, +1 or -1; for a closed contact the side on which it began */
  double side[LANE_WIDTH];
  double slide[LANE_WIDTH]; /* dlambda/dt; 0 if no law has a tangential dashpot or a bond */
  /* Displacement from the wall to its periodic image nearest to the disk; 0 if it has no images. */
  double shift_x[LANE_WIDTH], shift_y[LANE_WIDTH];
  bool crossed; /* true if q[l].crossed is true for some lane l */
} LANE(nearest_points);

/* Returns dlambda/dt of pair k. q: nearest point; lever: lever of the tangential force, 0 if q is
 * an end of the segment; dvx, dvy: velocity of the wall's material at q relative to the disk's
 * centre. If q is an end of the segment, the normal turns with the component of this velocity
 * across the normal. Else q moves along the segment; the normal turns with q on an arc, and with
 * the wall on a straight segment. */
LANE_INLINE double LANE(slide_on)(const engine *e, size_t k, const nearest_point *q, double lever,
                                  double dvx, double dvy) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const int32_t a = p->a[k], b = p->b[k];
  const placed_segment *g = &e->work.segments[p->part[k]];
  const double radius = s->radius[a], r = sqrt(q->dx * q->dx + q->dy * q->dy);
  double spin = radius * s->omega[a];
  if (s->n_surfaces > 0) spin -= s->surface_speed[(size_t)b - s->n_disks];
  if (!(r > 0.0)) return spin;
  const double across = (q->dx * dvy - q->dy * dvx) / r;
  if (lever == 0.0) return spin - radius / r * across;
  if (g->piece == SD_PIECE_STRAIGHT) return spin - across - (radius - r) * s->omega[b];
  const double carried = q->side * g->radius * s->omega[b];
  return spin - lever * (across - carried) - carried;
}

/* Finds the nearest points of LANE_WIDTH pairs, beginning with pair `at`, and sets *in to the input
 * of their geometry. The nearest point counts as a body of radius 0, with lambda = R_a (theta_a -
 * turned) + side * (arc length of the point) - (displacement of a moving surface); docs/physics.md,
 * section 4. Returns the mask of the lanes whose segment can touch the disk at this point
 * (nearest_point.active). */
LANE_INLINE LANE(mask) LANE(nearest_of)(const engine *e, size_t at, LANE(pair_input) * in,
                                        LANE(nearest_points) * found) {
  enum { DX, DY, DVX, DVY, SUM, ARC, ACTIVE, ROWS };
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double row[ROWS][LANE_WIDTH];
  found->crossed = false;
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const int32_t a = p->a[at + l], b = p->b[at + l];
    placed_segment image;
    const placed_segment *g =
        walls_image(e->work.length, &e->work.segments[p->part[at + l]], s->x[a], s->y[a], &image);
    nearest_point q = walls_nearest(g, s->x[a], s->y[a]);
    q.active = joints_active(e, at + l, g, &q);
    found->shift_x[l] = g->shift_x;
    found->shift_y[l] = g->shift_y;
    row[DX][l] = q.dx;
    row[DY][l] = q.dy;
    /* (lx, ly): vector from the wall's pivot to the nearest point; the velocity of the wall's
     * material there follows from it */
    double lx = s->x[a] + q.dx - (s->x[b] + g->shift_x),
           ly = s->y[a] + q.dy - (s->y[b] + g->shift_y);
    row[DVX][l] = (s->vx[b] - s->omega[b] * ly) - s->vx[a];
    row[DVY][l] = (s->vy[b] + s->omega[b] * lx) - s->vy[a];
    row[SUM][l] = s->radius[a];
    row[ACTIVE][l] = q.active ? 1.0 : 0.0;
    /* a contact keeps the side of the wall on which it began */
    q.crossed = p->side[at + l] != 0.0 && p->side[at + l] != q.side;
    if (q.crossed) q.side = p->side[at + l];
    row[ARC][l] = s->radius[a] * s->theta[a] + q.side * q.arc;
    if (s->n_surfaces > 0) row[ARC][l] -= body_surface(s, (size_t)b);
    found->side[l] = q.side;
    found->flat[l] = q.flat ? walls_lever(g, &q, s->radius[a]) : 0.0;
    found->slide[l] = 0.0;
    if (e->work.features & (LAW_DASHPOT | LAW_BOND))
      found->slide[l] = LANE(slide_on)(e, at + l, &q, found->flat[l], row[DVX][l], row[DVY][l]);
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

/* Adds the contact forces to the force sums of disks and walls. The torque on a wall is about its
 * pivot: -tau R_a plus the moment of the force, which acts at the vector from the pivot to the
 * disk's centre. */
LANE_INLINE void LANE(scatter_segments)(engine *e, size_t at, const LANE(nearest_points) * found,
                                        const LANE(contact_output) * out) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const unsigned features = e->work.features;
  double fx[LANE_WIDTH], fy[LANE_WIDTH], tau[LANE_WIDTH], couple[LANE_WIDTH] = {0},
                                                          *row = e->work.sums.row;
  if (features & LAW_ROLLING) LANE(store)(couple, out->couple);
  LANE(store)(fx, out->fx);
  LANE(store)(fy, out->fy);
  LANE(store)(tau, out->tau);
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const int32_t a = p->a[at + l], b = p->b[at + l];
    double rx = s->x[a] - (s->x[b] + found->shift_x[l]),
           ry = s->y[a] - (s->y[b] + found->shift_y[l]);
    double turn = rx * fy[l] - ry * fx[l] - tau[l] * s->radius[a];
    if (features & LAW_ROLLING) turn -= couple[l];
    double *on_a = row + PAIR(p, at + l, sum_a), *on_b = row + PAIR(p, at + l, sum_b);
    on_b[SUM_X] += fx[l];
    on_b[SUM_Y] += fy[l];
    on_b[SUM_TORQUE] += turn;
    on_b[SUM_SURFACE] -= tau[l];
    on_a[SUM_X] -= fx[l];
    on_a[SUM_Y] -= fy[l];
    on_a[SUM_TORQUE] += tau[l];
    if (features & LAW_ROLLING) on_a[SUM_COUPLE] += couple[l];
  }
}

/* Stores the side of the wall for each closed contact (0 for open ones). Appends a rare event for
 * each contact whose disk has moved around a free end to the other side of the wall. */
LANE_INLINE void LANE(store_sides)(pairs *p, thread_work *mine, size_t at, LANE(mask) touching,
                                   LANE(mask) closed, const LANE(nearest_points) * found) {
  LANE(store)(p->side + at, LANE(mask_zero)(touching, LANE(load)(found->side)));
  for (size_t l = 0; found->crossed && l < LANE_WIDTH; l++)
    if (found->q[l].crossed && LANE(lane_is)(closed, (int)l))
      event_add_pair(&mine->events, p, at + l, &(event){.was_closed = true});
}

/* Returns R_eff of the disk and the wall segment of pair k. An arc counts as a round wall. */
LANE_INLINE double LANE(arm_on_wall)(const engine *e, size_t k, double side) {
  const pairs *p = &e->work.pairs;
  return walls_arm(e->state->radius[p->a[k]], walls_radius(&e->work.segments[p->part[k]], side));
}

/* Computes the rolling displacement R_eff (theta_a - theta_b) of disks on walls, its time
 * derivative, and R_eff. */
LANE_INLINE void LANE(rolled_on)(const engine *e, size_t at, const LANE(nearest_points) * found,
                                 LANE(pair_geometry) * g) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  double rho[LANE_WIDTH], rolls[LANE_WIDTH], arm[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    const size_t a = (size_t)p->a[at + l], b = (size_t)p->b[at + l];
    arm[l] = LANE(arm_on_wall)(e, at + l, found->side[l]);
    rho[l] = arm[l] * (s->theta[a] - s->theta[b]);
    rolls[l] = arm[l] * (s->omega[a] - s->omega[b]);
  }
  g->rho = LANE(load)(rho);
  g->rolls = LANE(load)(rolls);
  g->arm = LANE(load)(arm);
}

/* Moves the contact records of disks that pass from one wall segment to the next
 * (joint_transfer). which: bit l is set if the contact in lane l would begin or end; closed: bit
 * l is set if it was closed before. Returns true if any record was moved. */
static __attribute__((noinline, cold)) bool
LANE(transfer_records)(engine *e, size_t at, unsigned which, unsigned closed) {
  bool any = false;
  for (size_t l = 0; l < LANE_WIDTH; l++)
    if (which >> l & 1u && joint_transfer(e, at + l, (closed >> l & 1u) != 0)) any = true;
  return any;
}

/* Returns the mask of the lanes whose contact was closed when it was last evaluated. */
LANE_INLINE LANE(mask) LANE(closed_before)(const pairs *p, size_t at) {
  double row[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) row[l] = pairs_closed(p, at + l) ? 1.0 : 0.0;
  return LANE(greater)(LANE(load)(row), LANE(splat)(0.0));
}

/* Returns the mask of the lanes whose contact would stay closed if it were closed now; whether it
 * is does not matter here. */
LANE_INLINE LANE(mask)
    LANE(lasts)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                const LANE(contact_memory) * m, LANE(mask) active, const unsigned features) {
  return LANE(contact_touches)(g, k, m, LANE(all_lanes)(1), features) & active &
         LANE(has_direction)(g);
}

/* Loads the records of LANE_WIDTH pairs with wall segments. */
LANE_INLINE void LANE(load_on_walls)(const work *w, size_t at, LANE(location) here,
                                     LANE(contact_memory) * m) {
  unsigned slides = 0;
  for (size_t l = 0; l < LANE_WIDTH; l++)
    slides |= (pairs_slide_sign(&w->pairs, at + l) != 0 ? 1u : 0u) << l;
  LANE(load_memory)(here, 0, m);
  if (w->features & LAW_GENERAL)
    LANE(load_more)(LANE(more_of)(w, here), here.l, w->features, slides, m);
}

LANE_INLINE void LANE(constants_on_wall)(const engine *e, size_t at, LANE(location) here,
                                         const LANE(nearest_points) * found,
                                         const unsigned features, LANE(contact_constants) * k) {
  const work *w = &e->work;
  *k = LANE(constants_of)(w, here.b->law + here.l, 1);
  LANE(constants_general)(w, here.b->law + here.l, features, k);
  if (features & LAW_NORMAL) { /* m_eff is the disk's mass, since the wall's is infinite */
    const double *masses = w->clumps.count ? w->clumps.contact_mass : e->state->mass;
    double mass[LANE_WIDTH];
    for (size_t l = 0; l < LANE_WIDTH; l++) mass[l] = masses[w->pairs.a[at + l]];
    k->tsuji = k->tsuji * LANE(sqrt)(LANE(load)(mass) * k->k_n);
  }
  if (__builtin_expect(!(features & (LAW_RADIUS | LAW_BEAM)), 1)) return;
  double arm[LANE_WIDTH], radius[LANE_WIDTH];
  for (size_t l = 0; l < LANE_WIDTH; l++) {
    arm[l] = LANE(arm_on_wall)(e, at + l, found->side[l]);
    radius[l] = e->state->radius[w->pairs.a[at + l]];
  }
  if (features & LAW_RADIUS) LANE(scale_by_radius)(LANE(load)(arm), k);
  if (features & LAW_BEAM) LANE(scale_by_length)(LANE(load)(radius), LANE(load)(arm), k);
}

/* Returns dlambda/dt of all lanes. It is needed only when a contact begins, so it is not
 * inlined. */
static __attribute__((noinline, cold)) LANE(real)
    LANE(slide_on_walls)(const engine *e, size_t at, const LANE(pair_input) * in,
                         const LANE(nearest_points) * found) {
  double dvx[LANE_WIDTH], dvy[LANE_WIDTH], slide[LANE_WIDTH];
  LANE(store)(dvx, in->dvx);
  LANE(store)(dvy, in->dvy);
  for (size_t l = 0; l < LANE_WIDTH; l++)
    slide[l] = LANE(slide_on)(e, at + l, &found->q[l], found->flat[l], dvx[l], dvy[l]);
  return LANE(load)(slide);
}

LANE_INLINE void LANE(store_flags_on_walls)(pairs *p, size_t at, LANE(mask) touching,
                                            LANE(real) slips) {
  double slip[LANE_WIDTH];
  LANE(store)(slip, slips);
  for (size_t l = 0; l < LANE_WIDTH; l++)
    p->flags[pairs_flags_at(p, at + l)] =
        (pair_flags){.closed = LANE(lane_is)(touching, (int)l) != 0,
                     .slides_positive = slip[l]<0.0, .slides_negative = slip[l]> 0.0};
}

/* Evaluates LANE_WIDTH pairs with wall segments, beginning with pair `at`: adds the forces to the
 * force sums of the bodies, and writes the contact records back. */
LANE_INLINE void LANE(evaluate_segments)(engine *e, thread_work *mine, size_t at) {
  work *w = &e->work;
  const LANE(location) here = {w->pairs.block + at / PAIR_BLOCK, at % PAIR_BLOCK};
  LANE(pair_input) in;
  LANE(nearest_points) found;
  LANE(mask) active = LANE(nearest_of)(e, at, &in, &found);
  const unsigned features = w->features;
  LANE(contact_constants) k;
  LANE(constants_on_wall)(e, at, here, &found, features, &k);
  LANE(pair_geometry) g = LANE(pair_geometry_of)(&in);
  LANE(mask) was_closed = LANE(closed_before)(&w->pairs, at);
  LANE(contact_memory) m, before;
  LANE(load_on_walls)(w, at, here, &m);
  const LANE(mask) changes = was_closed ^ LANE(lasts)(&g, &k, &m, active, features);
  if (LANE(any)(changes) &&
      LANE(transfer_records)(e, at, LANE(bits_of)(changes), LANE(bits_of)(was_closed))) {
    was_closed = LANE(closed_before)(&w->pairs, at);
    active = LANE(nearest_of)(e, at, &in, &found);
    if (features & (LAW_RADIUS | LAW_BEAM))
      LANE(constants_on_wall)(e, at, here, &found, features, &k);
    g = LANE(pair_geometry_of)(&in);
    LANE(load_on_walls)(w, at, here, &m);
  }
  if (features & (LAW_DASHPOT | LAW_BOND)) g.slide = LANE(load)(found.slide);
  if (features & LAW_ROLLING) LANE(rolled_on)(e, at, &found, &g);
  LANE(contact_output) out;
  m.ex = in.ex;
  m.ey = in.ey;
  LANE(bond_output) bond;
  LANE(bond_step)(&g, &k, active & LANE(has_direction)(&g), 0, features, &m, &bond);
  before = m;
  const LANE(mask) touching =
      LANE(contact_touches)(&g, &k, &m, was_closed, features) & active & LANE(has_direction)(&g);
  const LANE(mask) closed = touching & was_closed;
  /* On walls the tangential force always derives from the tangential energy, since the paper's
   * variant is not defined for walls. */
  const LANE(real) lever = LANE(load)(found.flat);
  const LANE(mask) flat = LANE(greater)(lever, LANE(splat)(0.0));
  const LANE(mask) meet = LANE(surfaces_meet)(&g, &k, &before, touching, was_closed, features);
  if (LANE(any)(meet)) {
    g.slide = LANE(slide_on_walls)(e, at, &in, &found);
    LANE(contact_begin)(&g, &k, meet, LANE(splat)(w->dt), features, &m);
  }
  LANE(contact_history)(&g, &k, touching, closed, 0, features, &m, &out);
  const LANE(mask) deep = LANE(contact_is_deep)(&g, e->work.max_overlap * in.sum) & touching;
  const LANE(mask) rare = (touching ^ was_closed) | deep | bond.breaks;
  if (LANE(any)(rare | meet)) {
    LANE(contact_begin_end)
    (&g, &k, touching, was_closed, LANE(splat)(w->dt), LANE(bent_of)(e, here, g.nx, g.ny), features,
     &before, &m, &out);
    if (features & LAW_BRIDGE) out.dropped = out.dropped + out.bridge;
    LANE(note)(e, mine, here, rare, was_closed, out.dropped, &bond);
    LANE(store)(here.b->ex + here.l, m.ex);
    LANE(store)(here.b->ey + here.l, m.ey);
  }
  if (features & LAW_BOND) LANE(bond_add)(&g, &bond, &m, &out);
  LANE(contact_force)(&g, &k, LANE(select)(flat, lever, g.lever), features, &m, &out);
  LANE(scatter_segments)(e, at, &found, &out);
  LANE(store_memory)(here, 0, &m, &out);
  if (features & LAW_GENERAL)
    LANE(store_more)(LANE(more_of)(w, here), here.l, features, 1, &m, &out);
  LANE(store_sides)(&w->pairs, mine, at, touching, closed, &found);
  LANE(store_flags_on_walls)(&w->pairs, at, touching, out.slip);
}
