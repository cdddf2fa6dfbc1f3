/* lanes_pass.h: the step of small systems in lanes (lanes.h); included after law.h and integrate_pass.h, once per width
 * and LANES_TEXT: `three` with LANES_KNOWN for a disk on two supports, `any` for whatever goes in lanes.
 *
 * With Gear, history is written beside the forces of the next step: commit and forces do not depend on each other
 * but for lambda*, and a processor that has both at hand waits for one chain of operations instead of two.
 * The function returns with nothing pending.
 *
 * What the loop carries stands in struct flight. For a disk on two supports the macros EACH_... write the turns out, so
 * that it is held in registers; the other text has loops.
 */
#ifndef LANES_PASS_COMMON
#define LANES_PASS_COMMON
#define LANES_PASTE2(name, text) name##_##text
#define LANES_PASTE(name, text) LANES_PASTE2(name, text)
#define PASS(name) LANE(LANES_PASTE(name, LANES_TEXT))
#define EACH_COORDINATE(c, statement)                                                                        \
  do {                                                                                                       \
    {                                                                                                        \
      const int c = SD_X;                                                                                    \
      statement;                                                                                             \
    }                                                                                                        \
    {                                                                                                        \
      const int c = SD_Y;                                                                                    \
      statement;                                                                                             \
    }                                                                                                        \
    {                                                                                                        \
      const int c = SD_THETA;                                                                                \
      statement;                                                                                             \
    }                                                                                                        \
  } while (0)
#endif

#undef EACH_PAIR
#undef EACH_DISK
#if LANES_KNOWN
/* one disk, two pairs */
#define EACH_DISK(i, n, statement)                                                                           \
  do {                                                                                                       \
    (void)(n);                                                                                               \
    const size_t i = 0;                                                                                      \
    statement;                                                                                               \
  } while (0)
#define EACH_PAIR(k, n, statement)                                                                           \
  do {                                                                                                       \
    (void)(n);                                                                                               \
    {                                                                                                        \
      const size_t k = 0;                                                                                    \
      statement;                                                                                             \
    }                                                                                                        \
    {                                                                                                        \
      const size_t k = 1;                                                                                    \
      statement;                                                                                             \
    }                                                                                                        \
  } while (0)
#else
#define EACH_DISK(i, number, statement)                                                                      \
  for (size_t i = 0; i < (number); i++) statement
#define EACH_PAIR(k, number, statement)                                                                      \
  for (size_t k = 0; k < (number); k++) statement
#endif

typedef struct PASS(shape) {
  size_t n_free, n_pairs;
  bool gear, conservative;
  bool single; /* one system in all lanes: poses stand one by one */
} PASS(shape);

/* Pairs as they are seen from some poses: of the forces of a step, or of its commit. */
typedef struct PASS(look) {
  LANE(real) free[LANES_FREE][POSES];
  LANE(law_input) in[LANES_PAIRS];
  LANE(law_geometry) geometry[LANES_PAIRS];
  LANE(law_output) out[LANES_PAIRS];
} PASS(look);

typedef struct PASS(flight) {
  LANE(nordsieck) c[LANES_FREE][SD_COORDINATES];
  LANE(law_memory) m[LANES_PAIRS];
  LANE(real) ex[LANES_PAIRS], ey[LANES_PAIRS];
  LANE(law_push) push[LANES_PAIRS];
  PASS(look) before, now; /* corrected poses of the step whose history is pending; trial poses */
  LANE(mask) returns;     /* an angle must return into its range, or a disk is too fast */
  bool pending, treated;
} PASS(flight);

LANE_INLINE double *PASS(rows_at)(const lanes *l, size_t row) { return l->memory + row * LANE_WIDTH; }
LANE_INLINE LANE(real) PASS(row)(const double *rows, size_t k) { return LANE(load)(rows + k * LANE_WIDTH); }
LANE_INLINE void PASS(set_row)(double *rows, size_t k, LANE(real) a) {
  LANE(store)(rows + k * LANE_WIDTH, a);
}

/* --- rows -------------------------------------------------------------------------------------------- */

LANE_INLINE void PASS(pick_up_disk)(const lanes *l, PASS(flight) * f, size_t i, int c) {
  const double *rows = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS) + c * DISK_COLUMNS * LANE_WIDTH;
  f->c[i][c] = (LANE(nordsieck)){PASS(row)(rows, 0), PASS(row)(rows, 1), PASS(row)(rows, 2),
                                 PASS(row)(rows, 3), PASS(row)(rows, 4), PASS(row)(rows, 5)};
}

LANE_INLINE void PASS(put_disk)(const lanes *l, const PASS(flight) * f, size_t i, int c) {
  double *rows = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS) + c * DISK_COLUMNS * LANE_WIDTH;
  const LANE(nordsieck) *q = &f->c[i][c];
  PASS(set_row)(rows, 0, q->q);
  PASS(set_row)(rows, 1, q->v);
  PASS(set_row)(rows, 2, q->q2);
  PASS(set_row)(rows, 3, q->q3);
  PASS(set_row)(rows, 4, q->q4);
  PASS(set_row)(rows, 5, q->q5);
}

LANE_INLINE void PASS(pick_up_pair)(const lanes *l, PASS(flight) * f, size_t k) {
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  LANE(law_memory) *m = &f->m[k];
  m->star = PASS(row)(p, PAIR_STAR);
  f->ex[k] = PASS(row)(p, PAIR_EX);
  f->ey[k] = PASS(row)(p, PAIR_EY);
  m->force = PASS(row)(p, PAIR_FORCE);
  m->overlap = PASS(row)(p, PAIR_OVERLAP);
  m->stretch = PASS(row)(p, PAIR_STRETCH);
  m->turned = PASS(row)(p, PAIR_TURNED);
  m->slip = PASS(row)(p, PAIR_SLIP);
  m->damping = m->force - PASS(row)(p, PAIR_KN) * m->overlap;
}

LANE_INLINE void PASS(put_pair)(const lanes *l, const PASS(flight) * f, size_t k) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(law_memory) *m = &f->m[k];
  PASS(set_row)(p, PAIR_STAR, m->star);
  PASS(set_row)(p, PAIR_EX, f->ex[k]);
  PASS(set_row)(p, PAIR_EY, f->ey[k]);
  PASS(set_row)(p, PAIR_FORCE, m->force);
  PASS(set_row)(p, PAIR_OVERLAP, m->overlap);
  PASS(set_row)(p, PAIR_STRETCH, m->stretch);
  PASS(set_row)(p, PAIR_TURNED, m->turned);
  PASS(set_row)(p, PAIR_SLIP, m->slip);
}

LANE_INLINE void PASS(put_push)(const lanes *l, const PASS(flight) * f, size_t k) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  PASS(set_row)(p, PAIR_FX, f->push[k].fx);
  PASS(set_row)(p, PAIR_FY, f->push[k].fy);
  PASS(set_row)(p, PAIR_TAU, f->push[k].tau);
}

LANE_INLINE LANE(law_constants) PASS(law_of)(const double *p) {
  return (LANE(law_constants)){.k_n = PASS(row)(p, PAIR_KN),
                               .k_t = PASS(row)(p, PAIR_KT),
                               .half_k_t = 0.5 * PASS(row)(p, PAIR_KT),
                               .gamma_n = PASS(row)(p, PAIR_GAMMA),
                               .cap = PASS(row)(p, PAIR_CAP)};
}

/* --- places ------------------------------------------------------------------------------------------ */

LANE_INLINE void PASS(see_free)(const PASS(flight) * f, PASS(look) * w, size_t i) {
  w->free[i][POSE_X] = f->c[i][SD_X].q;
  w->free[i][POSE_Y] = f->c[i][SD_Y].q;
  w->free[i][POSE_THETA] = f->c[i][SD_THETA].q;
  w->free[i][POSE_VX] = f->c[i][SD_X].v;
  w->free[i][POSE_VY] = f->c[i][SD_Y].v;
  w->free[i][POSE_OMEGA] = f->c[i][SD_THETA].v;
}

LANE_INLINE LANE(real)
    PASS(prescribed)(const lanes *l, const PASS(shape) * s, size_t slot, int which, int64_t at) {
  if (s->single) return LANE(splat)(l->pose[slot][which][at]);
  size_t stretch = (slot - s->n_free) * POSES + (size_t)which;
  return PASS(row)(l->scene + stretch * SCENE_STEPS * LANE_WIDTH, (size_t)at);
}

LANE_INLINE LANE(real) PASS(pose)(const lanes *l, const PASS(shape) * s, const PASS(look) * w, size_t slot,
                                  int which, int64_t at) {
  return s->n_free > 1 && slot < s->n_free ? w->free[slot][which] : PASS(prescribed)(l, s, slot, which, at);
}

/* Geometry of a pair: of the free disks as seen, and prescribed ones at step `at`. With one free disk pair k is
 * that of slots 0 and k + 1. */
LANE_INLINE void PASS(see_pair)(const lanes *l, const PASS(shape) * s, const PASS(flight) * f, PASS(look) * w,
                                int64_t at, size_t k) {
  size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  LANE(law_input) *in = &w->in[k];
  in->dx = PASS(pose)(l, s, w, b, POSE_X, at) - w->free[a][POSE_X];
  in->dy = PASS(pose)(l, s, w, b, POSE_Y, at) - w->free[a][POSE_Y];
  in->dvx = PASS(pose)(l, s, w, b, POSE_VX, at) - w->free[a][POSE_VX];
  in->dvy = PASS(pose)(l, s, w, b, POSE_VY, at) - w->free[a][POSE_VY];
  in->sum = PASS(row)(p, PAIR_SUM);
  in->arc = PASS(row)(p, PAIR_RA) * w->free[a][POSE_THETA] +
            PASS(row)(p, PAIR_RB) * PASS(pose)(l, s, w, b, POSE_THETA, at);
  in->ex = f->ex[k];
  in->ey = f->ey[k];
  in->active = LANE(all_lanes)(1);
  w->geometry[k] = LANE(law_geometry_of)(in);
}

/* What the contact does there, with the present memory. */
LANE_INLINE void PASS(meet)(const lanes *l, const PASS(flight) * f, PASS(look) * w, size_t k) {
  const LANE(law_constants) c = PASS(law_of)(PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS));
  w->in[k].star = f->m[k].star;
  w->in[k].was_closed = LANE(greater)(f->m[k].overlap, LANE(splat)(0.0)); /* else it would be 0 */
  w->out[k] = LANE(law)(&w->in[k], &w->geometry[k], &c);
}

/* --- forces ------------------------------------------------------------------------------------------ */

LANE_INLINE void PASS(push)(const lanes *l, const PASS(shape) * s, PASS(flight) * f, size_t k) {
  const LANE(law_constants) c = PASS(law_of)(PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS));
  const PASS(look) *w = &f->now;
  LANE(real) scale = s->conservative ? w->geometry[k].lever : LANE(splat)(1.0);
  f->push[k] = LANE(law_force)(&w->geometry[k], &w->out[k], &c, scale);
  /* a commit looks at the force that acted where the contact was open */
  if (__builtin_expect(LANE(any)(LANE(not )(w->in[k].was_closed)), 0))
    PASS(set_row)(PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS), PAIR_ACTED, w->out[k].force);
}

LANE_INLINE LANE(real) PASS(component)(const LANE(law_push) * push, int c) {
  return c == SD_X ? push->fx : c == SD_Y ? push->fy : push->tau;
}

LANE_INLINE LANE(real) PASS(add)(LANE(real) sum, const LANE(law_push) * push, int c, bool on_b) {
  LANE(real) part = PASS(component)(push, c);
  return c == SD_THETA || on_b ? sum + part : sum - part;
}

/* Of the contacts of a body along a coordinate. */
LANE_INLINE LANE(real)
    PASS(force_on)(const lanes *l, const PASS(shape) * s, const PASS(flight) * f, size_t slot, int c) {
  LANE(real) sum = LANE(splat)(0.0);
  if (s->n_free == 1 && slot > 0)
    sum = PASS(add)(sum, &f->push[slot - 1], c, true);
  else if (s->n_free == 1)
    EACH_PAIR(k, s->n_pairs, sum = PASS(add)(sum, &f->push[k], c, false));
  else
    for (size_t n = 0; n < l->touching[slot]; n++)
      sum = PASS(add)(sum, &f->push[l->entry[slot][n] / 2], c, l->entry[slot][n] & 1);
  return c == SD_THETA ? sum * PASS(row)(PASS(rows_at)(l, ROWS_RADIUS), slot) : sum;
}

LANE_INLINE void PASS(predict)(const lanes *l, const PASS(shape) * s, PASS(flight) * f, size_t i, int c) {
  LANE(real)
  dt = PASS(row)(PASS(rows_at)(l, ROWS_DT), 0), per_dt = PASS(row)(PASS(rows_at)(l, ROWS_PER_DT), 0);
  if (s->gear)
    LANE(gear_predict)(&f->c[i][c], dt, per_dt);
  else
    LANE(verlet_predict)(&f->c[i][c], dt, per_dt);
}

LANE_INLINE void PASS(correct)(const lanes *l, const PASS(shape) * s, PASS(flight) * f, size_t i, int c) {
  double *d = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS);
  LANE(real) force = PASS(force_on)(l, s, f, i, c), per_dt = PASS(row)(PASS(rows_at)(l, ROWS_PER_DT), 0);
  LANE(real) acceleration = force * PASS(row)(d, DISK_GAIN + (size_t)c) + PASS(row)(d, DISK_PUSH + (size_t)c);
  if (s->gear)
    LANE(gear_correct)(&f->c[i][c], acceleration, per_dt);
  else
    LANE(verlet_correct)(&f->c[i][c], acceleration, per_dt);
}

LANE_INLINE LANE(mask) PASS(out_of_turn)(const PASS(flight) * f, size_t i) {
  LANE(real) theta = f->c[i][SD_THETA].q;
  return LANE(greater)(theta, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), theta);
}

LANE_INLINE LANE(mask) PASS(too_fast)(const lanes *l, const PASS(flight) * f, size_t i) {
  return LANE(is_fast)(f->c[i][SD_X].v, f->c[i][SD_Y].v, PASS(row)(PASS(rows_at)(l, ROWS_FAST), i));
}

/* Work of a prescribed coordinate: trapezoid of the contact forces over the step to `at`. */
LANE_INLINE double *PASS(work_of)(const lanes *l, const PASS(shape) * s, const PASS(flight) * f, int64_t at,
                                  size_t slot, int c, double *p, LANE(real) * done) {
  if (!l->placed[slot][c]) return p;
  LANE(real) now = PASS(prescribed)(l, s, slot, c, at), force = PASS(force_on)(l, s, f, slot, c);
  *done = *done + (PASS(row)(p, PLACE_FORCE) + force) * (now - PASS(row)(p, PLACE_LAST));
  PASS(set_row)(p, PLACE_FORCE, force);
  PASS(set_row)(p, PLACE_LAST, now);
  return p + PLACE_ROWS * LANE_WIDTH;
}

LANE_INLINE void PASS(book_work)(const lanes *l, const PASS(shape) * s, const PASS(flight) * f, int64_t at) {
  LANE(real) done = LANE(splat)(0.0);
  size_t n = s->n_free == 1 ? s->n_pairs : l->n_bodies - s->n_free;
  double *p = PASS(rows_at)(l, ROWS_PLACE);
  EACH_PAIR(b, n, EACH_COORDINATE(c, p = PASS(work_of)(l, s, f, at, s->n_free + b, c, p, &done)));
  PASS(set_row)(PASS(rows_at)(l, ROWS_WORK), 0, PASS(row)(PASS(rows_at)(l, ROWS_WORK), 0) - 0.5 * done);
}

/* --- history ----------------------------------------------------------------------------------------- */

/* Adds to what a contact has lost. */
LANE_INLINE void PASS(book)(double *p, size_t row, LANE(real) loss) {
  PASS(set_row)(p, row, PASS(row)(p, row) + loss);
}

/* Bits of a mask. */
LANE_INLINE unsigned PASS(bits_of)(LANE(mask) m) {
  unsigned bits = 0;
  for (int k = 0; k < LANE_WIDTH; k++) bits |= LANE(lane_is)(m, k) ? 1u << k : 0u;
  return bits;
}

/* A contact's state as a number: positive 0, negative 1, stuck 2, open 3, as in sd_state. */
LANE_INLINE LANE(real) PASS(doing)(const LANE(law_memory) * m) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  return LANE(keep)(LANE(greater)(m->slip, zero) | LANE(equal)(m->overlap, zero), one) +
         LANE(keep)(LANE(equal)(m->slip, zero), LANE(splat)(2.0));
}

LANE_INLINE void PASS(watch)(const lanes *l, const PASS(flight) * f, size_t at, size_t k,
                             LANE(real) * doing) {
  PASS(set_row)
  (PASS(rows_at)(l, ROWS_LEAST), at, LANE(least)(f->m[k].force, PASS(row)(PASS(rows_at)(l, ROWS_LEAST), at)));
  *doing = PASS(doing)(&f->m[k]);
}

/* Configurations of the watched contacts in the step whose history was just written. */
LANE_INLINE void PASS(count)(lanes *l, const PASS(shape) * s, const PASS(flight) * f, size_t w) {
  LANE(real) doing[2] = {LANE(splat)(0.0), LANE(splat)(0.0)};
  for (size_t side = 0; side < 2; side++)
    EACH_PAIR(k, s->n_pairs,
              if (l->watched[2 * w + side] == k)
                  PASS(watch)(l, f, 2 * w + side, k, &doing[side])); /* k: no index that varies */
  /* small integers, in the low bits of the sum */
  uint64_t index[LANE_WIDTH];
  LANE(bits) bits = LANE(as_bits)((4.0 * doing[0] + doing[1]) + 0x1p52);
  memcpy(index, &bits, sizeof index);
  for (size_t n = 0; n < LANE_WIDTH; n++) l->count_of[w][index[n] & 15][n]++;
}

/* Writes down what a rare event is treated with. */
LANE_INLINE void PASS(note)(double *p, const LANE(law_input) * in, const LANE(law_booked) * b,
                            LANE(real) missed) {
  PASS(set_row)(p, PAIR_WAS_EX, in->ex);
  PASS(set_row)(p, PAIR_WAS_EY, in->ey);
  PASS(set_row)(p, PAIR_DROP, b->drop);
  PASS(set_row)(p, PAIR_MISSED, missed);
}

/* Commits a pair as seen; lanes in which something rare happened, which is noted. */
LANE_INLINE LANE(mask)
    PASS(commit)(const lanes *l, const PASS(shape) * s, PASS(flight) * f, const PASS(look) * w, size_t k) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(law_constants) c = PASS(law_of)(p);
  const LANE(law_input) *in = &w->in[k];
  const LANE(real) dt = PASS(row)(PASS(rows_at)(l, ROWS_DT), 0);
  const LANE(law_memory) before = f->m[k];
  LANE(law_booked)
  b = LANE(law_commit)(in, &w->geometry[k], &w->out[k], &c, PASS(row)(p, PAIR_LIMIT), !s->conservative,
                       &f->m[k]);
  LANE(mask) rare = b.rare;
  if (__builtin_expect(LANE(any)(rare | LANE(not )(in->was_closed)), 0)) {
    LANE(real) acted = PASS(row)(p, PAIR_ACTED);
    LANE(mask) near = LANE(law_near)(in, &w->geometry[k], &w->out[k], dt);
    LANE(law_turn_over)(in, &w->geometry[k], &w->out[k], &c, &before, dt, &f->m[k], &b);
    rare = rare | (near & LANE(greater)(acted, LANE(splat)(0.0)));
    if (LANE(any)(rare)) PASS(note)(p, in, &b, LANE(law_missed)(in, &w->geometry[k], &w->out[k], acted, dt));
    f->ex[k] = LANE(law_direction)(&b, &w->out[k], f->ex[k], w->geometry[k].nx);
    f->ey[k] = LANE(law_direction)(&b, &w->out[k], f->ey[k], w->geometry[k].ny);
  }
  PASS(book)(p, PAIR_VISCOUS, b.viscous);
  PASS(book)(p, PAIR_FRICTION, b.friction);
  if (!s->conservative) PASS(book)(p, PAIR_VARIANT, b.gain);
  return rare;
}

LANE_INLINE void PASS(put_completed)(const lanes *l, const PASS(flight) * f, const PASS(look) * w, size_t i,
                                     int c) {
  PASS(put_disk)(l, f, i, c);
  double *rows = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS) + c * DISK_COLUMNS * LANE_WIDTH;
  PASS(set_row)(rows, 0, w->free[i][POSE_X + c]);
  PASS(set_row)(rows, 1, w->free[i][POSE_VX + c]);
}

/* Rare events of a completed step whose free poses are those of w: to the rows, through the systems, and back. What
 * has been predicted since stays: an angle that returns into its range does not wait for the next step. */
LANE_INLINE void PASS(treat)(lanes *l, const PASS(shape) * s, PASS(flight) * f, const PASS(look) * w,
                             int64_t at, bool returns) {
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(put_completed)(l, f, w, i, c)));
  EACH_PAIR(k, s->n_pairs, PASS(put_pair)(l, f, k));
  EACH_PAIR(k, s->n_pairs, PASS(put_push)(l, f, k));
  l->at = at;
  lanes_events(l);
  EACH_PAIR(k, s->n_pairs, PASS(pick_up_pair)(l, f, k));
  if (returns) EACH_DISK(i, s->n_free, PASS(pick_up_disk)(l, f, i, SD_THETA));
}

/* Commits all pairs as seen. When something rare happens the rest of the step's history is written at once. */
LANE_INLINE void PASS(commit_all)(lanes *l, const PASS(shape) * s, PASS(flight) * f, const PASS(look) * w,
                                  int64_t at, bool returns) {
  LANE(mask) rare[LANES_PAIRS] = {0}, any = LANE(all_lanes)(0);
  EACH_PAIR(k, s->n_pairs, any = any | (rare[k] = PASS(commit)(l, s, f, w, k)));
  f->treated = returns || LANE(any)(any);
  if (__builtin_expect(!f->treated, 1)) return;
  EACH_PAIR(k, s->n_pairs, l->rare[k] = PASS(bits_of)(rare[k]));
  PASS(treat)(l, s, f, w, at, returns);
}

/* What is left to do for a step once it is committed. */
LANE_INLINE void PASS(conclude)(lanes *l, const PASS(shape) * s, const PASS(flight) * f) {
  if (l->measure)
    for (size_t w = 0; w < l->n_slides; w++) PASS(count)(l, s, f, w);
}

/* --- the step ---------------------------------------------------------------------------------------- */

/* Trial coordinates; what they look like, and the pending step's corrected ones. */
LANE_INLINE void PASS(go)(const lanes *l, const PASS(shape) * s, PASS(flight) * f, int64_t at) {
  if (s->gear) EACH_DISK(i, s->n_free, PASS(see_free)(f, &f->before, i));
  if (s->gear && f->pending) EACH_PAIR(k, s->n_pairs, PASS(see_pair)(l, s, f, &f->before, at - 1, k));
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(predict)(l, s, f, i, c)));
  EACH_DISK(i, s->n_free, PASS(see_free)(f, &f->now, i));
  EACH_PAIR(k, s->n_pairs, PASS(see_pair)(l, s, f, &f->now, at, k));
}

/* History of the step before; events change what the memory says of the contact line. */
LANE_INLINE void PASS(look_back)(lanes *l, const PASS(shape) * s, PASS(flight) * f, int64_t at) {
  if (!s->gear || !f->pending) return;
  EACH_PAIR(k, s->n_pairs, PASS(meet)(l, f, &f->before, k));
  PASS(commit_all)(l, s, f, &f->before, at - 1, false);
  if (__builtin_expect(f->treated, 0)) EACH_PAIR(k, s->n_pairs, PASS(see_pair)(l, s, f, &f->now, at, k));
}

LANE_INLINE void PASS(force)(const lanes *l, const PASS(shape) * s, PASS(flight) * f) {
  EACH_PAIR(k, s->n_pairs, PASS(meet)(l, f, &f->now, k));
  EACH_PAIR(k, s->n_pairs, PASS(push)(l, s, f, k));
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(correct)(l, s, f, i, c)));
  f->returns = LANE(all_lanes)(0);
  EACH_DISK(i, s->n_free, f->returns = f->returns | PASS(out_of_turn)(f, i) | PASS(too_fast)(l, f, i));
}

LANE_INLINE void PASS(put_contacts)(const lanes *l, const PASS(shape) * s, const PASS(flight) * f) {
  EACH_PAIR(k, s->n_pairs, PASS(put_pair)(l, f, k));
  EACH_PAIR(k, s->n_pairs, PASS(put_push)(l, f, k));
}

/* Writes the history of the last step now. With Gear this is rare: forces and slips of a commit are kept no longer
 * than the step. */
LANE_INLINE void PASS(finish)(lanes *l, const PASS(shape) * s, PASS(flight) * f, int64_t at) {
  bool returns = LANE(any)(f->returns);
  EACH_DISK(i, s->n_free, PASS(see_free)(f, &f->now, i));
  if (s->gear) {
    EACH_PAIR(k, s->n_pairs, PASS(see_pair)(l, s, f, &f->now, at, k));
    EACH_PAIR(k, s->n_pairs, PASS(meet)(l, f, &f->now, k));
  }
  if (returns) EACH_DISK(i, s->n_free, l->returns[i] = PASS(bits_of)(PASS(out_of_turn)(f, i)));
  if (returns) EACH_DISK(i, s->n_free, l->fast |= PASS(bits_of)(PASS(too_fast)(l, f, i)));
  PASS(commit_all)(l, s, f, &f->now, at, returns);
  PASS(conclude)(l, s, f);
  f->pending = false;
  if (s->gear) PASS(put_contacts)(l, s, f);
}

/* After the step: what nothing waits for. */
LANE_INLINE void PASS(settle)(lanes *l, const PASS(shape) * s, PASS(flight) * f, int64_t at) {
  PASS(book_work)(l, s, f, at);
  if (s->gear && f->pending) PASS(conclude)(l, s, f);
  l->done++;
  f->pending = s->gear;
  if (!s->gear || __builtin_expect(LANE(any)(f->returns), 0)) PASS(finish)(l, s, f, at);
}

LANE_INLINE void PASS(start)(lanes *l, const PASS(shape) * s, PASS(flight) * f) {
  l->done = 0;
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(pick_up_disk)(l, f, i, c)));
  EACH_PAIR(k, s->n_pairs, PASS(pick_up_pair)(l, f, k));
}

LANE_INLINE void PASS(stop)(lanes *l, const PASS(shape) * s, PASS(flight) * f, int64_t at) {
  f->returns = LANE(all_lanes)(0);
  if (f->pending) PASS(finish)(l, s, f, at);
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(put_disk)(l, f, i, c)));
  if (!s->gear) PASS(put_contacts)(l, s, f);
  l->at = at;
}

/* n steps, or fewer when something goes wrong in a lane. */
LANE_INLINE void PASS(steps)(lanes *l, int64_t n, const PASS(shape) s) {
  PASS(flight) f = {0};
  int64_t at = l->at;
  PASS(start)(l, &s, &f);
  while (l->done < n && !l->dead_now) {
    at++;
    PASS(go)(l, &s, &f, at);
    PASS(look_back)(l, &s, &f, at);
    PASS(force)(l, &s, &f);
    PASS(settle)(l, &s, &f, at);
  }
  PASS(stop)(l, &s, &f, at);
}
