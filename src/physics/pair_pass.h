/* pair_pass.h: one pass over LANE_WIDTH pairs; included once per width after physics/law.h.
 *
 * The force pass writes fx, fy (on b) and tau from trial coordinates and leaves the memory alone. The commit
 * pass slides the skin, opens and closes contacts and books the losses of the step (trapezoid between the
 * last committed values and the new ones; physics.md 9). Velocity Verlet does both in one.
 */

LANE_INLINE LANE(law_constants) LANE(constants)(const work *w, const int32_t *law) {
  LANE(law_constants) k;
  if (w->one_law) {
    k.k_n = LANE(splat)(w->laws->k_n);
    k.k_t = LANE(splat)(w->laws->k_t);
    k.inverse_k_t = LANE(splat)(w->laws->inverse_k_t);
    k.gamma_n = LANE(splat)(w->laws->gamma_n);
    k.mu = LANE(splat)(w->laws->mu);
    return k;
  }
  double row[5][LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++) {
    const law_row *r = &w->laws[law[l]];
    row[0][l] = r->k_n;
    row[1][l] = r->k_t;
    row[2][l] = r->inverse_k_t;
    row[3][l] = r->gamma_n;
    row[4][l] = r->mu;
  }
  k.k_n = LANE(load)(row[0]);
  k.k_t = LANE(load)(row[1]);
  k.inverse_k_t = LANE(load)(row[2]);
  k.gamma_n = LANE(load)(row[3]);
  k.mu = LANE(load)(row[4]);
  return k;
}

/* Forces on b: F_n n - scale tau t, with t = (-n_y, n_x). */
LANE_INLINE void LANE(store_force)(pairs *p, size_t at, const LANE(law_output) * out,
                                   const LANE(law_constants) * k, LANE(real) scale) {
  LANE(real) tau = -(k->k_t * out->stretch), push = tau * scale;
  LANE(store)(p->fx + at, out->force * out->nx + push * out->ny);
  LANE(store)(p->fy + at, out->force * out->ny - push * out->nx);
  LANE(store)(p->tau + at, tau);
}

/* variant: the paper's tangential force does work that is not the skin's; conservative: none. */
LANE_INLINE void LANE(commit)(pairs *p, thread_work *mine, size_t at, const LANE(law_input) * in,
                              const LANE(law_output) * out, const LANE(law_constants) * k, LANE(real) limit,
                              LANE(mask) variant, double dt) {
  LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  LANE(real) force = LANE(load)(p->force + at), overlap = LANE(load)(p->overlap + at);
  LANE(real) stretch = LANE(load)(p->stretch + at), turned = LANE(load)(p->turned + at);
  LANE(mask) was_open = in->ex * in->ex + in->ey * in->ey < 0.5;

  /* Losses of this step. The force with which a contact begins worked over the whole way of the step, not
   * only over the part of it on which the disks overlapped. */
  LANE(real) rise = out->delta - overlap;
  LANE(real) way = LANE(select)(was_open, -(out->approach * dt) - rise, zero);
  LANE(real)
  viscous = half * ((force - k->k_n * overlap) + (out->force - k->k_n * out->delta)) * rise +
            half * out->force * way;
  LANE(real) friction = half * k->k_t * (stretch + out->stretch) * out->slip;
  LANE(real) gain = half * -k->k_t * (stretch * overlap + out->stretch * out->delta) * (out->turned - turned);
  LANE(store)(p->loss_viscous + at, LANE(select)(out->touching, viscous, zero));
  LANE(store)(p->loss_friction + at, LANE(select)(out->closed, friction, zero));
  LANE(store)(p->gain + at, LANE(select)(out->closed & variant, gain, zero));

  /* memory: keep, start (lambda* = lambda, reference direction = n), or forget */
  LANE(real) star = LANE(select)(out->closed, in->star + out->slip, in->arc);
  LANE(store)(p->star + at, LANE(select)(out->touching, star, zero));
  LANE(store)(p->ex + at, LANE(select)(out->touching, LANE(select)(out->closed, in->ex, out->nx), zero));
  LANE(store)(p->ey + at, LANE(select)(out->touching, LANE(select)(out->closed, in->ey, out->ny), zero));
  LANE(store)(p->force + at, out->force);
  LANE(store)(p->overlap + at, out->delta);
  LANE(store)(p->stretch + at, out->stretch);
  LANE(store)(p->turned + at, LANE(select)(out->closed, out->turned, zero));
  LANE(real) slide = LANE(select)(out->slip > 0.0, LANE(splat)(-1.0), LANE(splat)(1.0));
  LANE(store)(p->slide + at, LANE(select)(out->slip == 0.0, zero, slide));

  /* rare cases, treated one by one after the pass */
  LANE(mask) opened = LANE(not )(was_open | out->touching);
  LANE(mask) far = out->closed & ((out->sine > LAW_REBASE) | (out->sine < -LAW_REBASE));
  LANE(mask) deep = out->delta > limit, begun = was_open & out->touching;
  LANE(mask)
  near = was_open & LANE(not )(out->touching) & in->active & (out->reach > 2.0 * dt * out->approach);
  LANE(mask) rare = opened | far | deep | begun;
  if (!LANE(any)(rare | near)) return;

  /* A disk that arrives at touch to rounding: the force at the trial coordinates acted, and the corrected ones
   * do not touch, or the other way round. What the losses have for this step is then wrong by the force's work. */
  LANE(real) fx = LANE(load)(p->fx + at), fy = LANE(load)(p->fy + at), acted = LANE(root)(fx * fx + fy * fy);
  LANE(mask) felt = acted > 0.0;
  rare = rare | (near & felt);
  if (!LANE(any)(rare)) return;
  LANE(real) wrong = LANE(select)(out->touching, LANE(select)(felt, zero, -out->force), acted);
  double drop[LANE_WIDTH], missed[LANE_WIDTH], memory[6][LANE_WIDTH];
  LANE(store)(missed, LANE(select)(was_open, -(wrong * out->approach * dt), zero));
  LANE(store)(drop, viscous + half * k->k_t * stretch * stretch);
  LANE(store)(memory[0], in->star);
  LANE(store)(memory[1], in->ex);
  LANE(store)(memory[2], in->ey);
  LANE(store)(memory[3], force);
  LANE(store)(memory[4], overlap);
  LANE(store)(memory[5], stretch);
  for (int l = 0; l < LANE_WIDTH; l++) {
    if (!LANE(lane_is)(rare, l)) continue;
    event *v = event_add(&mine->events, (uint32_t)at + (uint32_t)l, LANE(lane_is)(opened, l) ? drop[l] : 0.0);
    if (v)
      v->star = memory[0][l], v->ex = memory[1][l], v->ey = memory[2][l], v->side = p->side[at + (size_t)l];
    if (v)
      v->force = memory[3][l], v->overlap = memory[4][l], v->stretch = memory[5][l], v->missed = missed[l];
  }
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
  in.active = in.sum == in.sum;

  LANE(law_constants) k = LANE(constants)(w, p->law + at);
  LANE(law_output) out = LANE(law)(&in, &k);
  if (pass & PASS_FORCE) {
    LANE(real) scale = w->conservative ? in.sum * out.inverse_r : LANE(splat)(1.0);
    LANE(store_force)(p, at, &out, &k, scale);
  }
  if (pass & PASS_COMMIT) {
    LANE(real) smaller = LANE(least)(ra, LANE(most)(rb, -rb));
    LANE(mask) variant = in.active;
    if (w->conservative) variant = variant ^ variant;
    LANE(commit)(p, mine, at, &in, &out, &k, e->model->max_overlap * smaller, variant, w->dt);
  }
}
