/* lanes_pass.h: the step of small systems in lanes (lanes.h); included after contact_step.h and
 * integrate_pass.h, once per vector width and variant. LANES_TEXT is the name of the variant:
 * `three` for a disk on two supports (LANES_KNOWN = 2 pairs), `wall` for a disk on a straight wall
 * (LANES_KNOWN = 1), `any` for all systems that can run in lanes (LANES_KNOWN = 0). LANES_STRAIGHT
 * tells whether none, some or all pairs have straight walls.
 *
 * Numbers that are carried from step to step are in struct step_registers. If the number of pairs
 * is known, the macros EACH_... unroll the loops, so that this struct is kept in registers; the
 * general variant has loops.
 */
#ifndef LANES_PASS_COMMON
#define LANES_PASS_COMMON
#define LANES_PASTE2(name, text) name##_##text
#define LANES_PASTE(name, text) LANES_PASTE2(name, text)
#define PASS(name) LANE(LANES_PASTE(name, LANES_TEXT))
enum { WALLS_NONE, WALLS_SOME, WALLS_ALL };
#define EACH_COORDINATE(c, statement)                                                              \
  do {                                                                                             \
    {                                                                                              \
      const int c = SD_X;                                                                          \
      statement;                                                                                   \
    }                                                                                              \
    {                                                                                              \
      const int c = SD_Y;                                                                          \
      statement;                                                                                   \
    }                                                                                              \
    {                                                                                              \
      const int c = SD_THETA;                                                                      \
      statement;                                                                                   \
    }                                                                                              \
  } while (0)
#endif

#undef EACH_PAIR
#undef EACH_DISK
#if LANES_KNOWN
/* variants for one free disk with one or two pairs: the loops are unrolled */
#define EACH_DISK(i, n, statement)                                                                 \
  do {                                                                                             \
    (void)(n);                                                                                     \
    const size_t i = 0;                                                                            \
    statement;                                                                                     \
  } while (0)
#define EACH_PAIR(k, n, statement)                                                                 \
  do {                                                                                             \
    (void)(n);                                                                                     \
    {                                                                                              \
      const size_t k = 0;                                                                          \
      statement;                                                                                   \
    }                                                                                              \
    if (LANES_KNOWN > 1) {                                                                         \
      const size_t k = 1;                                                                          \
      statement;                                                                                   \
    }                                                                                              \
  } while (0)
#else
#define EACH_DISK(i, number, statement)                                                            \
  for (size_t i = 0; i < (number); i++) statement
#define EACH_PAIR(k, number, statement)                                                            \
  for (size_t k = 0; k < (number); k++) statement
#endif

typedef struct PASS(shape) {
  size_t n_free, n_pairs;
  bool gear, conservative;
  unsigned features;
  bool single; /* true: all lanes have the same system, and its poses are not interleaved */
} PASS(shape);

typedef struct PASS(step_registers) {
  LANE(nordsieck) c[LANES_FREE][SD_COORDINATES];
  LANE(contact_memory) m[LANES_PAIRS];
  LANE(mask) closed[LANES_PAIRS];
  LANE(pair_geometry) geometry[LANES_PAIRS];
  LANE(contact_output) out[LANES_PAIRS];
  LANE(mask) rare[LANES_PAIRS]; /* for each pair, the lanes in which a rare event happened */
  /* For pairs with straight walls. side: side of the wall on which the contact began, 0 if it is
   * open; lever: lever of the tangential force; arm_x, arm_y: vector from the wall's pivot to the
   * disk. crossed: lanes in which the disk has crossed to the other side. */
  LANE(real) side[LANES_PAIRS], lever[LANES_PAIRS], arm_x[LANES_PAIRS], arm_y[LANES_PAIRS];
  LANE(mask) crossed[LANES_PAIRS];
  LANE(mask) returns; /* lanes in which an angle must be wrapped, or a disk is too fast */
} PASS(step_registers);

LANE_INLINE double *PASS(rows_at)(const lanes *l, size_t row) {
  return l->memory + row * LANE_WIDTH;
}
LANE_INLINE double *PASS(straight_rows)(const lanes *l, size_t k) {
  return PASS(rows_at)(l, ROWS_STRAIGHT + k * STRAIGHT_ROWS);
}
LANE_INLINE LANE(real) PASS(row)(const double *rows, size_t k) {
  return LANE(load)(rows + k * LANE_WIDTH);
}
LANE_INLINE void PASS(set_row)(double *rows, size_t k, LANE(real) a) {
  LANE(store)(rows + k * LANE_WIDTH, a);
}

/* Returns true if the second body of pair k is a straight wall. */
LANE_INLINE bool PASS(is_straight)(const lanes *l, size_t k) {
  return LANES_STRAIGHT == WALLS_ALL || (LANES_STRAIGHT == WALLS_SOME && l->straight[k]);
}

/* --- loads and stores of rows ----------------------------------------------------------------- */

LANE_INLINE void PASS(load_disk)(const lanes *l, PASS(step_registers) * f, size_t i, int c) {
  const double *rows = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS) + c * DISK_COLUMNS * LANE_WIDTH;
  f->c[i][c] = (LANE(nordsieck)){PASS(row)(rows, 0), PASS(row)(rows, 1), PASS(row)(rows, 2),
                                 PASS(row)(rows, 3), PASS(row)(rows, 4), PASS(row)(rows, 5)};
}

LANE_INLINE void PASS(store_disk)(const lanes *l, const PASS(step_registers) * f, size_t i, int c) {
  double *rows = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS) + c * DISK_COLUMNS * LANE_WIDTH;
  const LANE(nordsieck) *q = &f->c[i][c];
  PASS(set_row)(rows, 0, q->q);
  PASS(set_row)(rows, 1, q->v);
  PASS(set_row)(rows, 2, q->q2);
  PASS(set_row)(rows, 3, q->q3);
  PASS(set_row)(rows, 4, q->q4);
  PASS(set_row)(rows, 5, q->q5);
}

LANE_INLINE void PASS(load_pair)(const lanes *l, PASS(step_registers) * f, size_t k,
                                 const unsigned features) {
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  LANE(contact_memory) *m = &f->m[k];
  m->lambda_ref = PASS(row)(p, PAIR_lambda_ref);
  m->ex = PASS(row)(p, PAIR_ex);
  m->ey = PASS(row)(p, PAIR_ey);
  m->force = PASS(row)(p, PAIR_force);
  m->overlap = PASS(row)(p, PAIR_overlap);
  m->zeta = PASS(row)(p, PAIR_zeta);
  m->turned = PASS(row)(p, PAIR_turned);
  if (features & LAW_GENERAL) {
#define MEMORY_LOAD(name, ...) m->name = PASS(row)(p, PAIR_##name);
    SD_CONTACT_MEMORY(MEMORY_LOAD)
#undef MEMORY_LOAD
    f->out[k].slip = PASS(row)(p, PAIR_SLIP);
  }
  f->closed[k] = LANE(greater)(PASS(row)(p, PAIR_CLOSED), LANE(splat)(0.0));
  if (PASS(is_straight)(l, k)) f->side[k] = PASS(row)(PASS(straight_rows)(l, k), STRAIGHT_SIDE);
}

LANE_INLINE void PASS(store_pair)(const lanes *l, const PASS(step_registers) * f, size_t k,
                                  const unsigned features) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(contact_memory) *m = &f->m[k];
  PASS(set_row)(p, PAIR_lambda_ref, m->lambda_ref);
  PASS(set_row)(p, PAIR_ex, m->ex);
  PASS(set_row)(p, PAIR_ey, m->ey);
  PASS(set_row)(p, PAIR_force, m->force);
  PASS(set_row)(p, PAIR_overlap, m->overlap);
  PASS(set_row)(p, PAIR_zeta, m->zeta);
  PASS(set_row)(p, PAIR_turned, m->turned);
  PASS(set_row)(p, PAIR_CLOSED, LANE(mask_zero)(f->closed[k], LANE(splat)(1.0)));
  PASS(set_row)(p, PAIR_SLIP, f->out[k].slip);
  PASS(set_row)(p, PAIR_FX, f->out[k].fx);
  PASS(set_row)(p, PAIR_FY, f->out[k].fy);
  PASS(set_row)(p, PAIR_TAU, f->out[k].tau);
  if (features & LAW_GENERAL) {
    PASS(set_row)(p, PAIR_COUPLE, f->out[k].couple);
#define MEMORY_STORE(name, ...) PASS(set_row)(p, PAIR_##name, m->name);
    SD_CONTACT_MEMORY(MEMORY_STORE)
#undef MEMORY_STORE
  }
  if (!PASS(is_straight)(l, k)) return;
  double *w = PASS(straight_rows)(l, k);
  PASS(set_row)(w, STRAIGHT_SIDE, f->side[k]);
  const LANE(contact_output) *out = &f->out[k];
  PASS(set_row)
  (w, STRAIGHT_TURN,
   f->arm_x[k] * out->fy - f->arm_y[k] * out->fx - out->tau * PASS(row)(p, PAIR_RA));
}

LANE_INLINE LANE(contact_constants) PASS(constants)(const double *p) {
  return (LANE(contact_constants)){.k_n = PASS(row)(p, PAIR_KN),
                                   .k_t = PASS(row)(p, PAIR_KT),
                                   .half_k_t = 0.5 * PASS(row)(p, PAIR_KT),
                                   .gamma_n = PASS(row)(p, PAIR_GAMMA),
                                   .cap = PASS(row)(p, PAIR_CAP),
                                   .normal = PASS(row)(p, PAIR_NORMAL),
                                   .tsuji = PASS(row)(p, PAIR_TSUJI)};
}

/* Loads the constants of a pair; those of general laws are the members of law_row from `pulls`
 * on. */
LANE_INLINE LANE(contact_constants) PASS(constants_for)(const double *p, const unsigned features) {
  LANE(contact_constants) k = PASS(constants)(p);
  const LANE(real) zero = LANE(splat)(0.0);
#define LAW_LOAD(bits, name, value)                                                                \
  k.name = features & (bits) ? PASS(row)(p, PAIR_LAW + LAW_PLACE(name)) : zero;
  if (!(features & LAW_GENERAL)) return k;
  LAW_CONSTANTS(LAW_LOAD)
#undef LAW_LOAD
  if (features & LAW_RADIUS) LANE(scale_by_radius)
  (LANE(effective_radius)(PASS(row)(p, PAIR_RA), PASS(row)(p, PAIR_RB)), &k);
  return k;
}

#include "physics/small/lanes_geometry.h"

/* --- contacts --------------------------------------------------------------------------------- */

LANE_INLINE void PASS(add_loss)(double *p, size_t row, LANE(real) loss) {
  PASS(set_row)(p, row, PASS(row)(p, row) + loss);
}

LANE_INLINE LANE(mask)
    PASS(rare)(const lanes *l, const PASS(step_registers) * f, size_t k, LANE(mask) was_closed) {
  const double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(mask) touching = f->closed[k];
  LANE(mask) deep = LANE(contact_is_deep)(&f->geometry[k], PASS(row)(p, PAIR_LIMIT)) & touching;
  if (PASS(is_straight)(l, k)) deep = deep | (f->crossed[k] & touching & was_closed);
  return (touching ^ was_closed) | deep;
}

/* Evaluates the contact law of pair k. On straight walls the tangential force always derives from
 * the tangential energy; for other pairs this depends on the variant of the model. */
LANE_INLINE void PASS(contact)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                               size_t k, const LANE(contact_constants) * c, LANE(mask) touching,
                               LANE(mask) closed) {
  const LANE(pair_geometry) *g = &f->geometry[k];
  if (PASS(is_straight)(l, k))
    LANE(contact_step)(g, c, touching, closed, f->lever[k], 0, s->features, &f->m[k], &f->out[k]);
  else
    LANE(contact_step)
  (g, c, touching, closed, s->conservative ? g->lever : LANE(splat)(1.0), !s->conservative,
   s->features, &f->m[k], &f->out[k]);
}

/* Evaluates pair k again with the code for rare events, if in some lane the contact begins, ends,
 * turns far or overlaps deeply. */
LANE_INLINE void PASS(evaluate_slow)(const lanes *l, const PASS(shape) * s,
                                     PASS(step_registers) * f, int64_t at, size_t k,
                                     LANE(mask) was_closed, const LANE(contact_memory) * before) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(contact_constants) c = PASS(constants_for)(p, s->features);
  const LANE(pair_geometry) *g = &f->geometry[k];
  const LANE(real) dt = PASS(row)(PASS(rows_at)(l, ROWS_DT), 0);
  const LANE(mask) touching = f->closed[k] & LANE(has_direction)(g), closed = touching & was_closed;
  LANE(contact_memory) *m = &f->m[k];
  LANE(contact_output) *out = &f->out[k];
  *m = *before;
  PASS(slide)(l, s, f, at, k);
  LANE(contact_begin)
  (g, &c, LANE(surfaces_meet)(g, &c, before, touching, was_closed, s->features), dt, s->features,
   m);
  PASS(contact)(l, s, f, k, &c, touching, closed);
  size_t a = s->n_free == 1 ? 0 : l->a[k], b = s->n_free == 1 ? k + 1 : l->b[k];
  const LANE(real) zero = LANE(splat)(0.0);
  LANE(real) x2 = (s->n_free > 1 && b < s->n_free ? f->c[b][SD_X].q2 : zero) - f->c[a][SD_X].q2;
  LANE(real) y2 = (s->n_free > 1 && b < s->n_free ? f->c[b][SD_Y].q2 : zero) - f->c[a][SD_Y].q2;
  LANE(contact_begin_end)
  (g, &c, touching, was_closed, dt, g->nx * x2 + g->ny * y2, s->features, before, m, out);
  f->closed[k] = touching;
  f->rare[k] = PASS(rare)(l, f, k, was_closed);
  PASS(set_row)(p, PAIR_WAS_CLOSED, LANE(mask_zero)(was_closed, LANE(splat)(1.0)));
  PASS(set_row)
  (p, PAIR_DROPPED, s->features & LAW_BRIDGE ? out->dropped + out->bridge : out->dropped);
}

LANE_INLINE void PASS(evaluate)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                                int64_t at, size_t k) {
  double *p = PASS(rows_at)(l, ROWS_PAIR + k * PAIR_ROWS);
  const LANE(contact_constants) c = PASS(constants_for)(p, s->features);
  const LANE(pair_geometry) *g = &f->geometry[k];
  const LANE(mask) was_closed = f->closed[k],
                   touching = LANE(contact_touches)(g, &c, &f->m[k], was_closed, s->features);
  LANE(contact_output) *out = &f->out[k];
  if (s->features & LAW_GENERAL)
    f->m[k].slid = LANE(not )(LANE(equal)(out->slip, LANE(splat)(0.0)));
  const LANE(contact_memory) before = f->m[k];
  PASS(contact)(l, s, f, k, &c, touching, touching & was_closed);
  f->closed[k] = touching;
  f->rare[k] = PASS(rare)(l, f, k, was_closed);
  LANE(mask) rare = f->rare[k];
  if (s->features & LAW_COHESION)
    rare = rare | LANE(surfaces_meet)(g, &c, &before, touching, was_closed, s->features);
  if (__builtin_expect(LANE(any)(rare), 0))
    PASS(evaluate_slow)(l, s, f, at, k, was_closed, &before);
  if (PASS(is_straight)(l, k)) f->side[k] = LANE(mask_zero)(f->closed[k], f->side[k]);
  PASS(add_loss)(p, PAIR_viscous, out->viscous);
  PASS(add_loss)(p, PAIR_friction, out->friction);
#define LOSS_ADD(name, unit, meaning, laws)                                                        \
  if (s->features & LAW_##laws) PASS(add_loss)(p, PAIR_##name, out->name);
  SD_CONTACT_LOSSES(LOSS_ADD)
#undef LOSS_ADD
  if (!s->conservative) PASS(add_loss)(p, PAIR_nonconservative_work, out->work);
}

/* --- forces ----------------------------------------------------------------------------------- */

LANE_INLINE LANE(real) PASS(component)(const LANE(contact_output) * out, int c) {
  return c == SD_X ? out->fx : c == SD_Y ? out->fy : out->tau;
}

LANE_INLINE LANE(real)
    PASS(add)(LANE(real) sum, const LANE(contact_output) * out, int c, bool on_b) {
  LANE(real) part = PASS(component)(out, c);
  return c == SD_THETA || on_b ? sum + part : sum - part;
}

/* Adds to `sum` the torque (couple) of rolling resistance in one contact on the body in this slot.
 * For a wall it adds the whole torque of the contact instead, divided by the wall's radius
 * (pair_pass.h). */
LANE_INLINE LANE(real) PASS(add_couple)(const lanes *l, LANE(real) sum,
                                        const LANE(contact_output) * out, size_t slot, bool on_b) {
  if (slot < l->n_disks) return on_b ? sum - out->couple : sum + out->couple;
  const LANE(real) radius = PASS(row)(PASS(rows_at)(l, ROWS_RADIUS), slot);
  return sum + (out->tau - out->couple / radius);
}

/* Returns the torque of rolling resistance on the body in this slot. For a disk the torque of
 * tangential forces must be added to it; for a wall the result includes that torque, and is divided
 * by the wall's radius. */
LANE_INLINE LANE(real) PASS(couples_on)(const lanes *l, const PASS(shape) * s,
                                        const PASS(step_registers) * f, size_t slot) {
  LANE(real) sum = LANE(splat)(0.0);
  if (s->n_free == 1 && slot > 0) return PASS(add_couple)(l, sum, &f->out[slot - 1], slot, true);
  if (s->n_free == 1)
    EACH_PAIR(k, s->n_pairs, sum = PASS(add_couple)(l, sum, &f->out[k], slot, false));
  else
    for (size_t n = 0; n < l->touching[slot]; n++)
      sum = PASS(add_couple)(l, sum, &f->out[l->entry[slot][n] / 2], slot, l->entry[slot][n] & 1);
  return sum;
}

/* Returns the sum of all contact forces along coordinate c on the body in this slot; for c =
 * SD_THETA their torque. */
LANE_INLINE LANE(real) PASS(force_on)(const lanes *l, const PASS(shape) * s,
                                      const PASS(step_registers) * f, size_t slot, int c) {
  LANE(real) sum = LANE(splat)(0.0);
  if (s->n_free == 1 && slot > 0)
    sum = PASS(add)(sum, &f->out[slot - 1], c, true);
  else if (s->n_free == 1)
    EACH_PAIR(k, s->n_pairs, sum = PASS(add)(sum, &f->out[k], c, false));
  else
    for (size_t n = 0; n < l->touching[slot]; n++)
      sum = PASS(add)(sum, &f->out[l->entry[slot][n] / 2], c, l->entry[slot][n] & 1);
  if (c != SD_THETA) return sum;
  const LANE(real) radius = PASS(row)(PASS(rows_at)(l, ROWS_RADIUS), slot);
  if (!(s->features & LAW_ROLLING)) return sum * radius;
  const LANE(real) couples = PASS(couples_on)(l, s, f, slot);
  return slot < l->n_disks ? sum * radius + couples : couples * radius;
}

LANE_INLINE void PASS(predict)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                               size_t i, int c) {
  LANE(real)
  dt = PASS(row)(PASS(rows_at)(l, ROWS_DT), 0),
  per_dt = PASS(row)(PASS(rows_at)(l, ROWS_PER_DT), 0);
  if (s->gear)
    LANE(gear_predict)(&f->c[i][c], dt, per_dt);
  else
    LANE(verlet_predict)(&f->c[i][c], dt, per_dt);
}

LANE_INLINE void PASS(correct)(const lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                               size_t i, int c) {
  double *d = PASS(rows_at)(l, ROWS_DISK + i * DISK_ROWS);
  LANE(real)
  force = PASS(force_on)(l, s, f, i, c), per_dt = PASS(row)(PASS(rows_at)(l, ROWS_PER_DT), 0);
  LANE(real)
  acceleration = force * PASS(row)(d, DISK_GAIN + (size_t)c) + PASS(row)(d, DISK_PUSH + (size_t)c);
  if (s->gear)
    LANE(gear_correct)(&f->c[i][c], acceleration, per_dt);
  else
    LANE(verlet_correct)(&f->c[i][c], acceleration, per_dt);
}

LANE_INLINE LANE(mask) PASS(out_of_turn)(const PASS(step_registers) * f, size_t i) {
  LANE(real) theta = f->c[i][SD_THETA].q;
  return LANE(greater)(theta, LANE(splat)(4.0)) | LANE(greater)(LANE(splat)(-4.0), theta);
}

LANE_INLINE LANE(mask) PASS(too_fast)(const lanes *l, const PASS(step_registers) * f, size_t i) {
  return LANE(is_fast)(f->c[i][SD_X].v, f->c[i][SD_Y].v, PASS(row)(PASS(rows_at)(l, ROWS_FAST), i));
}

/* Adds (F_before + F_now) (x_now - x_before) to *done, for a prescribed coordinate x and the
 * contact force F along it, in the step that ends at index `at`. The sum is minus twice the work
 * that the motion does. p: rows of this coordinate; returns the rows of the next one. */
LANE_INLINE double *PASS(work_of)(const lanes *l, const PASS(shape) * s,
                                  const PASS(step_registers) * f, int64_t at, size_t slot, int c,
                                  double *p, LANE(real) * done) {
  if (!l->placed[slot][c]) return p;
  LANE(real) now = PASS(prescribed)(l, s, slot, c, at), force = PASS(force_on)(l, s, f, slot, c);
  *done = *done + (PASS(row)(p, PLACE_FORCE) + force) * (now - PASS(row)(p, PLACE_LAST));
  PASS(set_row)(p, PLACE_FORCE, force);
  PASS(set_row)(p, PLACE_LAST, now);
  return p + PLACE_ROWS * LANE_WIDTH;
}

LANE_INLINE void PASS(book_work)(const lanes *l, const PASS(shape) * s,
                                 const PASS(step_registers) * f, int64_t at) {
  LANE(real) done = LANE(splat)(0.0);
  size_t n = s->n_free == 1 ? s->n_pairs : l->n_bodies - s->n_free;
  double *p = PASS(rows_at)(l, ROWS_PLACE);
  EACH_PAIR(b, n, EACH_COORDINATE(c, p = PASS(work_of)(l, s, f, at, s->n_free + b, c, p, &done)));
  PASS(set_row)
  (PASS(rows_at)(l, ROWS_WORK), 0, PASS(row)(PASS(rows_at)(l, ROWS_WORK), 0) - 0.5 * done);
}

/* --- sampling --------------------------------------------------------------------------------- */

/* Returns the state of contact k as a number, as in sd_state: 0 sliding with positive torque, 1
 * sliding with negative torque, 2 stuck, 3 open. */
LANE_INLINE LANE(real) PASS(configuration)(const PASS(step_registers) * f, size_t k) {
  const LANE(real) zero = LANE(splat)(0.0), slip = f->out[k].slip;
  return LANE(mask_zero)(LANE(greater)(slip, zero) | LANE(not )(f->closed[k]), LANE(splat)(1.0)) +
         LANE(mask_zero)(LANE(equal)(slip, zero), LANE(splat)(2.0));
}

typedef struct PASS(contact_sample) {
  LANE(real) configuration, force, tau;
} PASS(contact_sample);

LANE_INLINE void PASS(sample_contact)(const lanes *l, const PASS(step_registers) * f, size_t at,
                                      size_t k, PASS(contact_sample) * sample) {
  double *least = PASS(rows_at)(l, ROWS_LEAST);
  PASS(set_row)(least, at, LANE(min)(f->m[k].force, PASS(row)(least, at)));
  *sample = (PASS(contact_sample)){PASS(configuration)(f, k), f->m[k].force, f->out[k].tau};
}

LANE_INLINE void PASS(add_to_row)(double *rows, size_t k, LANE(real) a) {
  PASS(set_row)(rows, k, PASS(row)(rows, k) + a);
}

/* Adds the present step to the sums over the visit of watched pair w. Ends the present part of the
 * visit if its class changes or it has reached its age (model/state.h). */
LANE_INLINE void PASS(sum_visits)(lanes *l, size_t w, const PASS(contact_sample) two[2]) {
  double *v = PASS(rows_at)(l, ROWS_VISIT + VISIT_ROWS * w);
  LANE(real)
  both = 2.0 * two[0].configuration + two[1].configuration,
  more = LANE(max)(two[0].configuration, two[1].configuration),
  class = LANE(select)(LANE(greater)(more, LANE(splat)(1.0)), more + 2.0, both),
  left = PASS(row)(v, VISIT_ROW_LEFT);
  LANE(mask)
  ends = LANE(not )(LANE(equal)(class, PASS(row)(v, VISIT_ROW_CLASS))) |
         LANE(equal)(left, LANE(splat)(0.0));
  if (__builtin_expect(LANE(any)(ends), 0)) {
    PASS(set_row)(v, VISIT_ROW_CLASS, class);
    lanes_visits(l, w, LANE(bits_of)(ends));
    for (size_t q = 0; q < VISIT_SUMS; q++)
      PASS(set_row)(v, q, LANE(mask_zero)(LANE(not )(ends), PASS(row)(v, q)));
    left = PASS(row)(v, VISIT_ROW_LEFT);
  }
  PASS(set_row)(v, VISIT_ROW_LEFT, left - 1.0);
  LANE(real)
  torque = (two[0].tau + two[1].tau) * PASS(row)(PASS(rows_at)(l, ROWS_RADIUS), l->watching[w]);
  PASS(add_to_row)(v, VISIT_TORQUE, torque);
  PASS(add_to_row)(v, VISIT_TORQUE2, torque * torque);
  for (size_t side = 0; side < 2; side++) {
    LANE(real) beyond = two[side].force - PASS(row)(v, VISIT_ROW_REFERENCE + side);
    PASS(add_to_row)(v, VISIT_FORCE + 2 * side, beyond);
    PASS(add_to_row)(v, VISIT_FORCE2 + 2 * side, beyond * beyond);
  }
}

/* Counts the present configuration of the two watched contacts of watched disk w. */
LANE_INLINE void PASS(count)(lanes *l, const PASS(shape) * s, const PASS(step_registers) * f,
                             size_t w) {
  PASS(contact_sample) two[2] = {0};
  for (size_t side = 0; side < 2; side++)
    /* the loop with a comparison makes k, the index of the contact, a constant for the compiler */
    EACH_PAIR(k, s->n_pairs,
              if (l->watched[2 * w + side] == k)
                  PASS(sample_contact)(l, f, 2 * w + side, k, &two[side]));
  /* adding 2^52 to a small integer puts it into the low bits of the double */
  uint64_t index[LANE_WIDTH];
  LANE(bits) bits = LANE(as_bits)((4.0 * two[0].configuration + two[1].configuration) + 0x1p52);
  memcpy(index, &bits, sizeof index);
  for (size_t n = 0; n < LANE_WIDTH; n++) l->count_of[w][index[n] & 15][n]++;
  if (l->visits) PASS(sum_visits)(l, w, two);
}

LANE_INLINE void PASS(sample)(lanes *l, const PASS(shape) * s, const PASS(step_registers) * f) {
  for (size_t w = 0; w < l->n_slides; w++) PASS(count)(l, s, f, w);
}

/* --- the step --------------------------------------------------------------------------------- */

LANE_INLINE void PASS(store)(lanes *l, const PASS(shape) * s, const PASS(step_registers) * f,
                             int64_t at) {
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(store_disk)(l, f, i, c)));
  EACH_PAIR(k, s->n_pairs, PASS(store_pair)(l, f, k, s->features));
  l->at = at;
}

/* Handles the rare events of the step: stores the registers in the rows, lets lanes_events handle
 * them in each system, and loads what may have changed. */
LANE_INLINE void PASS(events)(lanes *l, const PASS(shape) * s, PASS(step_registers) * f,
                              int64_t at) {
  EACH_PAIR(k, s->n_pairs, l->rare[k] = LANE(bits_of)(f->rare[k]));
  EACH_DISK(i, s->n_free, l->returns[i] = LANE(bits_of)(PASS(out_of_turn)(f, i)));
  EACH_DISK(i, s->n_free, l->fast |= LANE(bits_of)(PASS(too_fast)(l, f, i)));
  PASS(store)(l, s, f, at);
  lanes_events(l);
  EACH_PAIR(k, s->n_pairs, PASS(load_pair)(l, f, k, s->features));
  EACH_DISK(i, s->n_free, PASS(load_disk)(l, f, i, SD_THETA));
}

LANE_INLINE void PASS(step)(lanes *l, const PASS(shape) * s, PASS(step_registers) * f, int64_t at) {
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(predict)(l, s, f, i, c)));
  EACH_PAIR(k, s->n_pairs, PASS(geometry)(l, s, f, at, k));
  EACH_PAIR(k, s->n_pairs, PASS(evaluate)(l, s, f, at, k));
  EACH_DISK(i, s->n_free, EACH_COORDINATE(c, PASS(correct)(l, s, f, i, c)));
  f->returns = LANE(all_lanes)(0);
  EACH_DISK(i, s->n_free,
            f->returns = f->returns | PASS(out_of_turn)(f, i) | PASS(too_fast)(l, f, i));
  PASS(book_work)(l, s, f, at);
  l->done++;
  LANE(mask) rare = f->returns;
  EACH_PAIR(k, s->n_pairs, rare = rare | f->rare[k]);
  if (__builtin_expect(LANE(any)(rare), 0)) PASS(events)(l, s, f, at);
  if (l->measure) PASS(sample)(l, s, f);
}

/* Takes n steps; ends earlier if there is an error in a lane. */
LANE_INLINE void PASS(steps)(lanes *l, int64_t n, const PASS(shape) s) {
  PASS(step_registers) f = {0};
  int64_t at = l->at;
  l->done = 0;
  EACH_DISK(i, s.n_free, EACH_COORDINATE(c, PASS(load_disk)(l, &f, i, c)));
  EACH_PAIR(k, s.n_pairs, PASS(load_pair)(l, &f, k, s.features));
  while (l->done < n && !l->dead_now) PASS(step)(l, &s, &f, ++at);
  PASS(store)(l, &s, &f, at);
}
