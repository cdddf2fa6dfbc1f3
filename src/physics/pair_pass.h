/* pair_pass.h: one pass over LANE_WIDTH pairs; included once per width after physics/law.h.
 *
 * The force pass writes fx, fy (on b) and tau from trial coordinates and leaves the memory alone. The commit
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

/* Forces on b: F_n n - scale tau t, with t = (-n_y, n_x). */
LANE_INLINE void LANE(store_force)(pairs *p, size_t at, const LANE(law_input) * in,
                                   const LANE(law_geometry) * g, const LANE(law_output) * out,
                                   const LANE(law_constants) * k, LANE(real) scale) {
  LANE(law_push) push = LANE(law_force)(in, g, out, k, scale);
  LANE(store)(p->fx + at, push.fx);
  LANE(store)(p->fy + at, push.fy);
  LANE(store)(p->tau + at, push.tau);
}

/* Writes down what has to be treated one by one after the pass. before: the memory before the commit. */
LANE_INLINE void LANE(note)(pairs *p, thread_work *mine, size_t at, const LANE(law_memory) * before,
                            const LANE(law_booked) * b, LANE(mask) which, LANE(real) missed) {
  double drop[LANE_WIDTH], wrong[LANE_WIDTH], memory[6][LANE_WIDTH];
  LANE(store)(wrong, missed);
  LANE(store)(drop, b->drop);
  LANE(store)(memory[0], before->star);
  LANE(store)(memory[1], before->ex);
  LANE(store)(memory[2], before->ey);
  LANE(store)(memory[3], before->force);
  LANE(store)(memory[4], before->overlap);
  LANE(store)(memory[5], before->stretch);
  for (int l = 0; l < LANE_WIDTH; l++) {
    if (!LANE(lane_is)(which, l)) continue;
    event *v = event_add(&mine->events, (uint32_t)at + (uint32_t)l, drop[l]);
    if (v)
      v->star = memory[0][l], v->ex = memory[1][l], v->ey = memory[2][l], v->side = p->side[at + (size_t)l];
    if (v)
      v->force = memory[3][l], v->overlap = memory[4][l], v->stretch = memory[5][l], v->missed = wrong[l];
  }
}

LANE_INLINE void LANE(commit)(pairs *p, thread_work *mine, size_t at, const LANE(law_input) * in,
                              const LANE(law_geometry) * g, const LANE(law_output) * out,
                              const LANE(law_constants) * k, LANE(real) limit, int variant, double dt) {
  LANE(law_memory)
  m = {.star = in->star,
       .ex = in->ex,
       .ey = in->ey,
       .force = LANE(load)(p->force + at),
       .overlap = LANE(load)(p->overlap + at),
       .stretch = LANE(load)(p->stretch + at),
       .turned = LANE(load)(p->turned + at)};
  m.damping = m.force - k->k_n * m.overlap;
  const LANE(law_memory) before = m;
  LANE(real) zero = LANE(splat)(0.0), step = LANE(splat)(dt);
  LANE(law_booked) b = LANE(law_commit)(in, g, out, k, limit, variant, step, &m);
  LANE(store)(p->loss_viscous + at, b.viscous);
  LANE(store)(p->loss_friction + at, b.friction);
  LANE(store)(p->gain + at, b.gain);
  LANE(store)(p->star + at, m.star);
  LANE(store)(p->ex + at, m.ex);
  LANE(store)(p->ey + at, m.ey);
  LANE(store)(p->force + at, m.force);
  LANE(store)(p->overlap + at, m.overlap);
  LANE(store)(p->stretch + at, m.stretch);
  LANE(store)(p->turned + at, m.turned);
  LANE(real)
  slide = LANE(select)(LANE(greater)(m.slip, zero), LANE(splat)(-1.0), LANE(splat)(1.0));
  LANE(store)(p->slide + at, LANE(select)(LANE(equal)(m.slip, zero), zero, slide));

  LANE(mask) near = LANE(law_near)(in, g, out, step);
  if (!LANE(any)(b.rare | near)) return;
  LANE(real) fx = LANE(load)(p->fx + at), fy = LANE(load)(p->fy + at), acted = LANE(root)(fx * fx + fy * fy);
  LANE(mask) which = b.rare | (near & LANE(greater)(acted, zero));
  if (LANE(any)(which)) LANE(note)(p, mine, at, &before, &b, which, LANE(law_missed)(in, out, acted, step));
}

LANE_INLINE void LANE(round_pass)(engine *e, thread_work *mine, const pair_view *s, size_t at, int pass) {
  work *w = &e->work;
  pairs *p = &w->pairs;
  const int32_t *a = s->a + at, *b = s->b + at;
  LANE(law_input) in;
  in.dx = LANE(gather)(s->x, b) - LANE(gather)(s->x, a);
  in.dy = LANE(gather)(s->y, b) - LANE(gather)(s->y, a);
  if (w->periodic[0]) in.dx = in.dx - w->length[0] * LANE(nearest)(in.dx * w->inverse_length[0]);
  if (w->periodic[1]) in.dy = in.dy - w->length[1] * LANE(nearest)(in.dy * w->inverse_length[1]);
  in.dvx = LANE(gather)(s->vx, b) - LANE(gather)(s->vx, a);
  in.dvy = LANE(gather)(s->vy, b) - LANE(gather)(s->vy, a);
  LANE(real) ra = LANE(gather)(s->radius, a), rb = LANE(gather)(s->radius, b);
  in.sum = ra + rb;
  in.arc = ra * LANE(gather)(s->theta, a) + rb * LANE(gather)(s->theta, b);
  in.star = LANE(load)(p->star + at);
  in.ex = LANE(load)(p->ex + at);
  in.ey = LANE(load)(p->ey + at);
  in.was_closed = LANE(law_is_closed)(in.ex, in.ey);
  in.active = LANE(all_lanes)(1);

  LANE(law_constants) k = LANE(constants)(w, p->law + at);
  LANE(law_geometry) g = LANE(law_geometry_of)(&in);
  LANE(law_output) out = LANE(law)(&in, &g, &k);
  if (pass & PASS_FORCE) {
    LANE(real) scale = w->conservative ? in.sum * g.inverse_r : LANE(splat)(1.0);
    LANE(store_force)(p, at, &in, &g, &out, &k, scale);
  }
  if (pass & PASS_COMMIT) {
    LANE(real) smaller = LANE(least)(ra, LANE(most)(rb, -rb));
    LANE(commit)(p, mine, at, &in, &g, &out, &k, e->model->max_overlap * smaller, !w->conservative, w->dt);
  }
}
