/* lanes_pass.h: the step of small systems in lanes (lanes.h); included once per width after law.h and
 * integrate_pass.h.
 *
 * With Gear, history is written beside the forces of the next step: commit and forces do not depend on each other
 * but for lambda*, and a processor that has both at hand waits for one chain of operations instead of two. The
 * function returns with nothing pending. What the loop carries stands in struct hand, which for the three disks
 * (one free, two pairs: known when this is compiled) the compiler keeps in registers.
 */

typedef struct LANE(hand) {
  LANE(nordsieck) c[LANES_FREE][SD_COORDINATES];
  LANE(law_memory) m[LANES_PAIRS];
  LANE(law_push) push[LANES_PAIRS];
} LANE(hand);

/* What passes over pairs need: for the forces of a step, and for its commit. */
typedef struct LANE(look) {
  LANE(law_input) in[LANES_PAIRS];
  LANE(law_geometry) geometry[LANES_PAIRS];
  LANE(real) free[LANES_FREE][POSES];
} LANE(look);

typedef struct LANE(shape) {
  size_t n_free, n_pairs;
  bool gear, conservative;
  bool single; /* one system in all lanes: poses stand one by one */
} LANE(shape);

LANE_INLINE LANE(real) LANE(row)(const double *rows, size_t k) { return LANE(load)(rows + k * LANE_WIDTH); }
LANE_INLINE void LANE(set_row)(double *rows, size_t k, LANE(real) a) {
  LANE(store)(rows + k * LANE_WIDTH, a);
}

LANE_INLINE void LANE(pick_up)(const lanes *l, const LANE(shape) * s, LANE(hand) * h) {
  for (size_t i = 0; i < s->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      const double *rows = l->disk[i] + c * DISK_COLUMNS * LANE_WIDTH;
      h->c[i][c] = (LANE(nordsieck)){LANE(row)(rows, 0), LANE(row)(rows, 1), LANE(row)(rows, 2),
                                     LANE(row)(rows, 3), LANE(row)(rows, 4), LANE(row)(rows, 5)};
    }
}

LANE_INLINE void LANE(pick_up_pairs)(const lanes *l, const LANE(shape) * s, LANE(hand) * h) {
  for (size_t k = 0; k < s->n_pairs; k++) {
    const double *p = l->pair[k];
    LANE(law_memory) *m = &h->m[k];
    m->star = LANE(row)(p, PAIR_STAR);
    m->ex = LANE(row)(p, PAIR_EX);
    m->ey = LANE(row)(p, PAIR_EY);
    m->force = LANE(row)(p, PAIR_FORCE);
    m->overlap = LANE(row)(p, PAIR_OVERLAP);
    m->stretch = LANE(row)(p, PAIR_STRETCH);
    m->turned = LANE(row)(p, PAIR_TURNED);
    m->slip = LANE(row)(p, PAIR_SLIP);
    m->damping = m->force - LANE(row)(p, PAIR_KN) * m->overlap;
    m->torn = m->stretch * m->overlap;
    h->push[k] = (LANE(law_push)){LANE(row)(p, PAIR_FX), LANE(row)(p, PAIR_FY), LANE(row)(p, PAIR_TAU)};
  }
}

LANE_INLINE void LANE(put_disks)(const lanes *l, const LANE(shape) * s, const LANE(hand) * h) {
  for (size_t i = 0; i < s->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      double *rows = l->disk[i] + c * DISK_COLUMNS * LANE_WIDTH;
      const LANE(nordsieck) *q = &h->c[i][c];
      LANE(set_row)(rows, 0, q->q);
      LANE(set_row)(rows, 1, q->v);
      LANE(set_row)(rows, 2, q->q2);
      LANE(set_row)(rows, 3, q->q3);
      LANE(set_row)(rows, 4, q->q4);
      LANE(set_row)(rows, 5, q->q5);
    }
}

LANE_INLINE void LANE(put_pairs)(const lanes *l, const LANE(shape) * s, const LANE(hand) * h) {
  for (size_t k = 0; k < s->n_pairs; k++) {
    double *p = l->pair[k];
    const LANE(law_memory) *m = &h->m[k];
    LANE(set_row)(p, PAIR_STAR, m->star);
    LANE(set_row)(p, PAIR_EX, m->ex);
    LANE(set_row)(p, PAIR_EY, m->ey);
    LANE(set_row)(p, PAIR_FORCE, m->force);
    LANE(set_row)(p, PAIR_OVERLAP, m->overlap);
    LANE(set_row)(p, PAIR_STRETCH, m->stretch);
    LANE(set_row)(p, PAIR_TURNED, m->turned);
    LANE(set_row)(p, PAIR_SLIP, m->slip);
    LANE(set_row)(p, PAIR_FX, h->push[k].fx);
    LANE(set_row)(p, PAIR_FY, h->push[k].fy);
    LANE(set_row)(p, PAIR_TAU, h->push[k].tau);
  }
}

LANE_INLINE LANE(law_constants) LANE(law_of)(const double *p) {
  LANE(law_constants)
  k = {.k_n = LANE(row)(p, PAIR_KN),
       .k_t = LANE(row)(p, PAIR_KT),
       .half_k_t = 0.5 * LANE(row)(p, PAIR_KT),
       .gamma_n = LANE(row)(p, PAIR_GAMMA),
       .cap = LANE(row)(p, PAIR_CAP)};
  return k;
}

/* --- places ------------------------------------------------------------------------------------------ */

/* Poses of the free disks; coordinates and the centre's velocity. */
LANE_INLINE void LANE(see_free)(const LANE(shape) * s, const LANE(hand) * h, LANE(look) * w) {
  for (size_t i = 0; i < s->n_free; i++) {
    w->free[i][POSE_X] = h->c[i][SD_X].q;
    w->free[i][POSE_Y] = h->c[i][SD_Y].q;
    w->free[i][POSE_THETA] = h->c[i][SD_THETA].q;
    w->free[i][POSE_VX] = h->c[i][SD_X].v;
    w->free[i][POSE_VY] = h->c[i][SD_Y].v;
    w->free[i][POSE_OMEGA] = h->c[i][SD_THETA].v;
  }
}

LANE_INLINE LANE(real) LANE(pose)(const lanes *l, const LANE(shape) * s, const LANE(look) * w, size_t slot,
                                  int which, int64_t at) {
  if (s->n_free > 1 && slot < s->n_free) return w->free[slot][which];
  const lanes_pose *p = &l->pose[slot][which];
  if (s->single) return LANE(splat)(p->at[(size_t)at * p->stride]);
  return LANE(load)(p->at + (size_t)at * p->stride * LANE_WIDTH);
}

/* Geometry of every pair: of the free disks as seen, and prescribed ones at step `at`. With one free disk pair k is
 * that of slots 0 and k + 1. */
LANE_INLINE void LANE(see_pairs)(const lanes *l, const LANE(shape) * s, const LANE(hand) * h, LANE(look) * w,
                                 int64_t at) {
  for (size_t k = 0; k < s->n_pairs; k++) {
    size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
    const double *p = l->pair[k];
    LANE(law_input) *in = &w->in[k];
    in->dx = LANE(pose)(l, s, w, b, POSE_X, at) - w->free[a][POSE_X];
    in->dy = LANE(pose)(l, s, w, b, POSE_Y, at) - w->free[a][POSE_Y];
    in->dvx = LANE(pose)(l, s, w, b, POSE_VX, at) - w->free[a][POSE_VX];
    in->dvy = LANE(pose)(l, s, w, b, POSE_VY, at) - w->free[a][POSE_VY];
    in->sum = LANE(row)(p, PAIR_SUM);
    in->arc = LANE(row)(p, PAIR_RA) * w->free[a][POSE_THETA] +
              LANE(row)(p, PAIR_RB) * LANE(pose)(l, s, w, b, POSE_THETA, at);
    in->ex = h->m[k].ex;
    in->ey = h->m[k].ey;
    in->active = LANE(all_lanes)(1);
    w->geometry[k] = LANE(law_geometry_of)(in);
  }
}

/* --- forces ------------------------------------------------------------------------------------------ */

LANE_INLINE LANE(law_output)
    LANE(respond)(const lanes *l, const LANE(shape) * s, LANE(hand) * h, LANE(look) * w, size_t k) {
  const LANE(law_constants) c = LANE(law_of)(l->pair[k]);
  LANE(law_input) *in = &w->in[k];
  in->star = h->m[k].star;
  in->was_closed = LANE(greater)(h->m[k].overlap, LANE(splat)(0.0)); /* else it would be 0 */
  LANE(law_output) out = LANE(law)(in, &w->geometry[k], &c);
  LANE(real) scale = s->conservative ? in->sum * w->geometry[k].inverse_r : LANE(splat)(1.0);
  h->push[k] = LANE(law_force)(in, &w->geometry[k], &out, &c, scale);
  return out;
}

LANE_INLINE LANE(real) LANE(component)(const LANE(law_push) * push, int c) {
  return c == SD_X ? push->fx : c == SD_Y ? push->fy : push->tau;
}

/* Of the contacts of a body along a coordinate; torques want the radius. */
LANE_INLINE LANE(real)
    LANE(sum_of)(const lanes *l, const LANE(shape) * s, const LANE(hand) * h, size_t slot, int c) {
  LANE(real) sum = LANE(splat)(0.0);
  if (s->n_free == 1 && slot > 0) return sum + LANE(component)(&h->push[slot - 1], c);
  if (s->n_free == 1) {
    for (size_t k = 0; k < s->n_pairs; k++) {
      LANE(real) f = LANE(component)(&h->push[k], c);
      sum = c == SD_THETA ? sum + f : sum - f;
    }
    return sum;
  }
  for (size_t n = 0; n < l->touching[slot]; n++) {
    LANE(real) f = LANE(component)(&h->push[l->entry[slot][n] / 2], c);
    sum = c == SD_THETA || (l->entry[slot][n] & 1) ? sum + f : sum - f;
  }
  return sum;
}

/* Work of the prescribed bodies: trapezoid of the contact forces over the step to `at`. */
LANE_INLINE void LANE(book_work)(const lanes *l, const LANE(shape) * s, const LANE(hand) * h, int64_t at) {
  LANE(real) done = LANE(splat)(0.0);
  size_t last = s->n_free == 1 ? s->n_pairs + 1 : l->n_bodies;
  double *p = l->place;
  for (size_t slot = s->n_free; slot < last; slot++)
    for (int c = 0; c < SD_COORDINATES; c++) {
      if (!l->placed[slot][c]) continue;
      LANE(real) now = LANE(pose)(l, s, NULL, slot, c, at), force = LANE(sum_of)(l, s, h, slot, c);
      if (c == SD_THETA) force = force * LANE(row)(l->radius, slot);
      done = done + (LANE(row)(p, PLACE_FORCE) + force) * (now - LANE(row)(p, PLACE_LAST));
      LANE(set_row)(p, PLACE_FORCE, force);
      LANE(set_row)(p, PLACE_LAST, now);
      p += PLACE_ROWS * LANE_WIDTH;
    }
  LANE(set_row)(l->work, 0, LANE(row)(l->work, 0) - 0.5 * done);
}

LANE_INLINE void LANE(predict)(const lanes *l, const LANE(shape) * s, LANE(hand) * h) {
  for (size_t i = 0; i < s->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      if (s->gear)
        LANE(gear_predict)(&h->c[i][c], LANE(row)(l->dt, 0), LANE(row)(l->per_dt, 0));
      else
        LANE(verlet_predict)(&h->c[i][c], LANE(row)(l->dt, 0), LANE(row)(l->per_dt, 0));
    }
}

/* Lanes in which an angle leaves its range. */
LANE_INLINE LANE(mask) LANE(correct)(lanes *l, const LANE(shape) * s, LANE(hand) * h) {
  LANE(mask) out = LANE(all_lanes)(0);
  for (size_t i = 0; i < s->n_free; i++) {
    double *d = l->disk[i];
    for (int c = 0; c < SD_COORDINATES; c++) {
      LANE(real) force = LANE(sum_of)(l, s, h, i, c);
      if (c == SD_THETA) force = force * LANE(row)(l->radius, i);
      LANE(set_row)(d, DISK_FORCE + (size_t)c, force);
      LANE(real) gain = LANE(row)(d, DISK_GAIN + (size_t)c), push = LANE(row)(d, DISK_PUSH + (size_t)c);
      if (s->gear)
        LANE(gear_correct)(&h->c[i][c], force * gain + push, LANE(row)(l->per_dt, 0));
      else
        LANE(verlet_correct)(&h->c[i][c], force * gain + push, LANE(row)(l->per_dt, 0));
    }
    LANE(real) theta = h->c[i][SD_THETA].q;
    out = out | LANE(greater)(theta, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), theta);
  }
  return out;
}

/* --- history ------------------------------------------------------------------------------------------ */

LANE_INLINE void LANE(book_losses)(lanes *l, const LANE(shape) * s, const LANE(law_booked) * b) {
  for (size_t i = 0; i < s->n_free; i++) {
    LANE(real) viscous = LANE(splat)(0.0), friction = viscous, gain = viscous;
    size_t n = s->n_free == 1 ? s->n_pairs : l->touching[i];
    for (size_t e = 0; e < n; e++) {
      size_t k = s->n_free == 1 ? e : l->entry[i][e] / 2;
      if (s->n_free == 1 || l->b[k] >= s->n_free) {
        viscous = viscous + b[k].viscous;
        friction = friction + b[k].friction;
        gain = gain + b[k].gain;
      } else { /* shared */
        viscous = viscous + 0.5 * b[k].viscous;
        friction = friction + 0.5 * b[k].friction;
        gain = gain + 0.5 * b[k].gain;
      }
    }
    double *d = l->disk[i];
    LANE(set_row)(d, DISK_VISCOUS, LANE(row)(d, DISK_VISCOUS) + viscous);
    LANE(set_row)(d, DISK_FRICTION, LANE(row)(d, DISK_FRICTION) + friction);
    if (!s->conservative) LANE(set_row)(d, DISK_VARIANT, LANE(row)(d, DISK_VARIANT) + gain);
  }
}

/* Bits of a mask. */
LANE_INLINE unsigned LANE(bits_of)(LANE(mask) m) {
  unsigned bits = 0;
  for (int k = 0; k < LANE_WIDTH; k++) bits |= LANE(lane_is)(m, k) ? 1u << k : 0u;
  return bits;
}

/* Configurations of the watched contacts in the step whose history was just written. */
LANE_INLINE void LANE(count)(lanes *l, const LANE(shape) * s, const LANE(hand) * h) {
  const LANE(real) zero = LANE(splat)(0.0);
  for (size_t w = 0; w < l->n_slides; w++) {
    LANE(real) which = zero;
    for (size_t side = 0; side < 2; side++) {
      size_t k = l->watched[2 * w + side];
      LANE(real) slip = h->m[0].slip, force = h->m[0].force, overlap = h->m[0].overlap;
      for (size_t n = 1; n < s->n_pairs; n++) /* so that the memory stays in registers */
        if (k == n) slip = h->m[n].slip, force = h->m[n].force, overlap = h->m[n].overlap;
      LANE(set_row)(l->least, 2 * w + side, LANE(least)(force, LANE(row)(l->least, 2 * w + side)));
      /* positive 0, negative 1, stuck 2, open 3: as in the state */
      LANE(real)
      now = LANE(keep)(LANE(greater)(slip, zero), LANE(splat)(1.0)) +
            LANE(keep)(LANE(equal)(slip, zero), LANE(splat)(2.0)) +
            LANE(keep)(LANE(equal)(overlap, zero), LANE(splat)(1.0));
      which = side == 0 ? 4.0 * now : which + now;
    }
    /* small integers, in the low bits of the sum */
    uint64_t index[LANE_WIDTH];
    LANE(bits) bits = LANE(as_bits)(which + 0x1p52);
    memcpy(index, &bits, sizeof index);
    for (size_t n = 0; n < LANE_WIDTH; n++) l->count_of[w][index[n] & 15][n]++;
  }
}

/* Writes down what a rare event is treated with; what it books has to be in the rows already. */
LANE_INLINE void LANE(note)(double *p, const LANE(law_memory) * before, const LANE(law_booked) * b,
                            LANE(real) missed) {
  LANE(set_row)(p, PAIR_WAS + PAIR_STAR, before->star);
  LANE(set_row)(p, PAIR_WAS + PAIR_EX, before->ex);
  LANE(set_row)(p, PAIR_WAS + PAIR_EY, before->ey);
  LANE(set_row)(p, PAIR_WAS + PAIR_FORCE, before->force);
  LANE(set_row)(p, PAIR_WAS + PAIR_OVERLAP, before->overlap);
  LANE(set_row)(p, PAIR_WAS + PAIR_STRETCH, before->stretch);
  LANE(set_row)(p, PAIR_DROP, b->drop);
  LANE(set_row)(p, PAIR_MISSED, missed);
}

/* Commits a pair that was looked at; true: something rare is to be treated (l->rare). */
LANE_INLINE bool LANE(commit)(lanes *l, const LANE(shape) * s, LANE(hand) * h, const LANE(look) * w, size_t k,
                              const LANE(law_output) * out, LANE(law_booked) * booked) {
  double *p = l->pair[k];
  const LANE(law_constants) c = LANE(law_of)(p);
  const LANE(law_memory) before = h->m[k];
  const LANE(law_input) *in = &w->in[k];
  const LANE(real) dt = LANE(row)(l->dt, 0);
  *booked = LANE(law_commit)(in, &w->geometry[k], out, &c, LANE(row)(p, PAIR_LIMIT), !s->conservative, dt,
                             &h->m[k]);
  LANE(mask) rare = booked->rare;
  if (LANE(any)(rare | LANE(not )(in->was_closed))) {
    LANE(real) fx = h->push[k].fx, fy = h->push[k].fy, acted = LANE(root)(fx * fx + fy * fy);
    LANE(mask) near = LANE(law_near)(in, &w->geometry[k], out, dt);
    rare = rare | (near & LANE(greater)(acted, LANE(splat)(0.0)));
    if (LANE(any)(rare)) LANE(note)(p, &before, booked, LANE(law_missed)(in, out, acted, dt));
  }
  l->rare[k] = LANE(bits_of)(rare);
  return LANE(any)(rare);
}

/* Rare events of a completed step whose free poses are those of w: rows, the systems, and back. What has been predicted
 * since stays, since an angle that returns into its range never waits for the next step. */
LANE_INLINE void LANE(treat)(lanes *l, const LANE(shape) * s, LANE(hand) * h, const LANE(look) * w,
                             int64_t at, bool returns) {
  LANE(put_disks)(l, s, h);
  for (size_t i = 0; i < s->n_free; i++) {
    for (int c = 0; c < SD_COORDINATES; c++) {
      double *rows = l->disk[i] + c * DISK_COLUMNS * LANE_WIDTH;
      LANE(set_row)(rows, 0, w->free[i][POSE_X + c]);
      LANE(set_row)(rows, 1, w->free[i][POSE_VX + c]);
    }
  }
  LANE(put_pairs)(l, s, h);
  l->at = at;
  lanes_events(l);
  LANE(pick_up_pairs)(l, s, h);
  for (size_t i = 0; i < s->n_free; i++)
    if (returns) h->c[i][SD_THETA].q = LANE(row)(l->disk[i], DISK_COLUMNS * SD_THETA);
}

LANE_INLINE void LANE(note_returns)(lanes *l, const LANE(shape) * s, const LANE(hand) * h) {
  for (size_t i = 0; i < s->n_free; i++) {
    LANE(real) theta = h->c[i][SD_THETA].q;
    l->returns[i] =
        LANE(bits_of)(LANE(greater)(theta, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), theta));
  }
}

/* The whole history of a step: looks at its poses, `at` in the batch. */
LANE_INLINE bool LANE(write_history)(lanes *l, const LANE(shape) * s, LANE(hand) * h, LANE(look) * w,
                                     int64_t at, const LANE(law_output) * known, bool returns) {
  LANE(law_booked) booked[LANES_PAIRS];
  bool rare = returns;
  for (size_t k = 0; k < s->n_pairs; k++) {
    LANE(law_output) out;
    if (known) {
      out = known[k];
    } else {
      const LANE(law_constants) c = LANE(law_of)(l->pair[k]);
      w->in[k].star = h->m[k].star;
      w->in[k].was_closed = LANE(greater)(h->m[k].overlap, LANE(splat)(0.0));
      out = LANE(law)(&w->in[k], &w->geometry[k], &c);
    }
    rare |= LANE(commit)(l, s, h, w, k, &out, &booked[k]);
  }
  LANE(book_losses)(l, s, booked);
  if (__builtin_expect(rare, 0)) LANE(treat)(l, s, h, w, at, returns);
  if (l->measure) LANE(count)(l, s, h);
  return rare;
}

LANE_INLINE void LANE(steps)(lanes *l, int64_t n, const LANE(shape) s) {
  LANE(hand) h;
  int64_t at = l->at;
  bool pending = false;
  LANE(pick_up)(l, &s, &h);
  LANE(pick_up_pairs)(l, &s, &h);
  for (l->done = 0; l->done < n && !l->dead_now;) {
    LANE(look) before, now;
    if (s.gear) LANE(see_free)(&s, &h, &before);
    LANE(predict)(l, &s, &h);
    at++;
    LANE(see_free)(&s, &h, &now);
    LANE(see_pairs)(l, &s, &h, &now, at);
    if (s.gear && pending) {
      LANE(see_pairs)(l, &s, &h, &before, at - 1);
      /* events change what the memory says of the contact line */
      if (LANE(write_history)(l, &s, &h, &before, at - 1, NULL, false)) LANE(see_pairs)(l, &s, &h, &now, at);
    }
    LANE(law_output) out[LANES_PAIRS];
    for (size_t k = 0; k < s.n_pairs; k++) out[k] = LANE(respond)(l, &s, &h, &now, k);
    LANE(book_work)(l, &s, &h, at);
    LANE(mask) returns = LANE(correct)(l, &s, &h);
    l->done++;
    pending = s.gear;
    if (s.gear && !LANE(any)(returns)) continue;
    LANE(see_free)(&s, &h, &now);
    if (s.gear) LANE(see_pairs)(l, &s, &h, &now, at);
    if (LANE(any)(returns)) LANE(note_returns)(l, &s, &h);
    LANE(write_history)(l, &s, &h, &now, at, s.gear ? NULL : out, LANE(any)(returns));
    pending = false;
  }
  if (pending) {
    LANE(look) now;
    LANE(see_free)(&s, &h, &now);
    LANE(see_pairs)(l, &s, &h, &now, at);
    LANE(write_history)(l, &s, &h, &now, at, NULL, false);
  }
  LANE(put_disks)(l, &s, &h);
  LANE(put_pairs)(l, &s, &h);
  l->at = at;
}
