/* motion.c: switches motions on and off at phases, and sets the poses of prescribed bodies; see
 * motion.h. */
#include "physics/motion/motion.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/motions.h"
#include "physics/contact/pairs.h"
#include "physics/motion/signals.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"
#include "physics/system/kernels.h"

/* One motion that adds to one coordinate of one body. place: SD_MOVED * slot + coordinate, which
 * identifies the coordinate; motion: index in the model. */
typedef struct addend {
  size_t place, motion;
} addend;

struct motions {
  signals signals;
  int64_t first; /* step of the first value computed ahead; < 0: nothing is computed */
  size_t n_addends;
  /* motions that run or are about to start, once per body; ordered by coordinate (place), then as
   * in the deck */
  addend *addends;
  size_t n_prescribed;
  prescribed *prescribed; /* coordinates that a running motion moves */
  /* signals that are added to the prescribed coordinates, those of one coordinate after those of
   * another */
  const signal_values **terms;
  size_t *term_motions; /* index in the model of the motion of each entry of `terms` */
  feedbacks feedbacks;  /* list of the running loads and servos */
  unsigned moves;       /* bits MOVES_... of the running motions */
  /* true: no value computed ahead makes the neighbour lists stale or leaves its coordinate range */
  bool quiet;
};

bool motion_in_range(const engine *e, int coordinate, double at) {
  if (coordinate == SD_THETA) return at >= -4.0 && at <= 4.0;
  if (coordinate == SD_SURFACE) return fabs(at) <= 0.5 * body_surface_turn(e);
  return at >= e->work.lower[coordinate] && at < e->work.upper[coordinate];
}

/* Pointers to the columns of the state for one body or clump: coordinates, velocities, forces and
 * base poses (without running motions). NULL for coordinates that it lacks. Slots of clumps follow
 * those of the bodies. */
typedef struct mover {
  double *at[SD_MOVED], *speed[SD_MOVED], *force[SD_MOVED], *base[SD_MOVED], *turn, *surface_turn;
  int32_t *image[2];
} mover;

static mover mover_of(const sd_state *s, size_t slot) {
  if (slot < s->n_bodies) {
    mover b = (mover){{s->x + slot, s->y + slot, s->theta + slot},
                      {s->vx + slot, s->vy + slot, s->omega + slot},
                      {s->force_x + slot, s->force_y + slot, s->torque + slot},
                      {s->base_x + slot, s->base_y + slot, s->base_theta + slot},
                      s->turn + slot,
                      NULL,
                      {s->image_x + slot, s->image_y + slot}};
    if (slot < s->n_disks || s->n_surfaces == 0) return b;
    const size_t wall = slot - s->n_disks;
    b.at[SD_SURFACE] = s->surface + wall;
    b.speed[SD_SURFACE] = s->surface_speed + wall;
    b.force[SD_SURFACE] = s->surface_force + wall;
    b.base[SD_SURFACE] = s->base_surface + wall;
    b.surface_turn = s->surface_turn + wall;
    return b;
  }
  const size_t k = slot - s->n_bodies;
  assert(k < s->n_clumps);
  return (mover){{s->clump_x + k, s->clump_y + k, s->clump_theta + k},
                 {s->clump_vx + k, s->clump_vy + k, s->clump_omega + k},
                 {s->clump_force_x + k, s->clump_force_y + k, s->clump_torque + k},
                 {s->clump_base_x + k, s->clump_base_y + k, s->clump_base_theta + k},
                 s->clump_turn + k,
                 NULL,
                 {s->clump_image_x + k, s->clump_image_y + k}};
}

static size_t movers_of(const sd_state *s) { return s->n_bodies + s->n_clumps; }

void motion_offset(const engine *e, uint32_t slot, int coordinate, double *off, double *base) {
  const mover b = mover_of(e->state, slot);
  assert(coordinate != SD_SURFACE || b.surface_turn);
  *off = coordinate == SD_SURFACE ? *b.surface_turn
         : coordinate == SD_THETA ? *b.turn
                                  : *b.image[coordinate] * e->work.length[coordinate];
  *base = *b.base[coordinate];
}

/* Computes the values of a prescribed coordinate at all MOTION_BATCH steps ahead, as the sum of its
 * signals. */
static void fill_one(engine *e, prescribed *p) {
  assert(p->count > 0 && p->slot < movers_of(e->state));
  pose_sum b = {e->work.motions->terms + p->first, p->count, .value = p->value,
                .velocity = p->velocity};
  motion_offset(e, p->slot, p->coordinate, &b.off, &b.base);
  e->work.kernels->motion->sum(&b, MOTION_BATCH);
  p->low = b.low;
  p->high = b.high;
  assert(!(p->low > p->high));
}

/* True if a prescribed coordinate stays far from its limits at all steps computed ahead. It may
 * move by 0.24 of the largest displacement that the neighbour lists allow; for walls, which also
 * turn, by 0.14. These are below 1/2 because a list that is built in between can double the
 * displacement, and the Verlet margin may shrink. */
static bool is_quiet(const engine *e, const prescribed *p) {
  const work *w = &e->work;
  const sd_state *s = e->state;
  /* For clumps only the range is tested: positions of their disks are checked in every step. */
  if (p->slot >= s->n_bodies)
    return motion_in_range(e, p->coordinate, p->low) && motion_in_range(e, p->coordinate, p->high);
  bool wall = p->slot >= s->n_disks;
  double from = p->coordinate == SD_X       ? w->x0[p->slot]
                : p->coordinate == SD_Y     ? w->y0[p->slot]
                : p->coordinate == SD_THETA ? w->theta0[p->slot] - s->turn[p->slot]
                                            : 0.0;
  double arm = p->coordinate == SD_SURFACE ? 0.0
               : p->coordinate != SD_THETA ? 1.0
               : wall                      ? w->reach[p->slot - s->n_disks]
                                           : 0.0;
  double most = (wall ? 0.02 : 0.06) * w->moved_limit2; /* squares of 0.14 and 0.24 */
  double down = (p->low - from) * arm, up = (p->high - from) * arm;
  return down * down <= most && up * up <= most && motion_in_range(e, p->coordinate, p->low) &&
         motion_in_range(e, p->coordinate, p->high);
}

/* Computes MOTION_BATCH steps ahead, from step `first` on. */
static void fill(engine *e, int64_t first) {
  motions *q = e->work.motions;
  assert(first == e->state->step || first == e->state->step + 1);
  signals_fill(e, &q->signals, first);
  q->first = first;
  q->quiet = q->feedbacks.count == 0;
  for (size_t k = 0; k < q->n_prescribed; k++) {
    fill_one(e, &q->prescribed[k]);
    q->quiet = q->quiet && is_quiet(e, &q->prescribed[k]);
  }
}

/* --- tables ----------------------------------------------------------------------------------- */

sd_status motion_new(engine *e, sd_messages *messages) {
  const sd_model *m = e->model;
  motions *q = e->work.motions = memory_new(1, sizeof *q);
  const size_t most = SD_MOVED * model_movables(m);
  size_t terms = 0;
  for (size_t k = 0; k < m->n_motions; k++) terms += m->motions[k].n_bodies;
  if (!memory_rows(
          4, (memory_column[]){{&q->prescribed, most < terms ? most : terms, sizeof *q->prescribed},
                               {&q->addends, terms, sizeof *q->addends},
                               {&q->terms, terms, sizeof *q->terms},
                               {&q->term_motions, terms, sizeof *q->term_motions}}))
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the motions");
  feedback_new(e, &q->feedbacks);
  return signals_new(e, &q->signals, messages);
}

void motion_free(engine *e) {
  motions *q = e->work.motions;
  if (!q) return;
  signals_free(e, &q->signals);
  free(q->prescribed);
  free(q->addends);
  free(q->terms);
  free(q->term_motions);
  feedback_free(&q->feedbacks);
  free(q);
  e->work.motions = NULL;
}

/* Returns the number (addend.place) of the coordinate of the motion's b-th body that it moves. */
static size_t place_of(const engine *e, const sd_motion *m, size_t b) {
  const size_t slot = slot_of(&e->work.slots, m->bodies[b]);
  assert(slot < movers_of(e->state));
  return SD_MOVED * slot + (size_t)m->coordinate;
}

/* False if the motion's b-th body is a disk that was released. */
static bool is_moved_body(const engine *e, const sd_motion *m, size_t b) {
  return body_is_moved(e, m->bodies[b], slot_of(&e->work.slots, m->bodies[b]));
}

static int by_place(const void *one, const void *two) {
  const addend *p = one, *q = two;
  if (p->place != q->place) return p->place < q->place ? -1 : 1;
  return p->motion < q->motion ? -1 : p->motion > q->motion;
}

/* Lists the motions that run, once for each of their bodies. begins: [n_motions] true for motions
 * to be included although they do not run yet; NULL: none. */
static void list_addends(engine *e, const bool *begins) {
  const sd_model *m = e->model;
  motions *q = e->work.motions;
  q->n_addends = 0;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0;
         (e->state->motion_start[k] >= 0 || (begins && begins[k])) && b < m->motions[k].n_bodies;
         b++)
      if (is_moved_body(e, &m->motions[k], b))
        q->addends[q->n_addends++] = (addend){place_of(e, &m->motions[k], b), k};
  if (q->n_addends > 1) qsort(q->addends, q->n_addends, sizeof *q->addends, by_place);
}

static void prescribe(engine *e, prescribed *p, size_t place, size_t first) {
  size_t slot = place / SD_MOVED, k = place % SD_MOVED;
  const mover b = mover_of(e->state, slot);
  assert(b.at[k]);
  p->slot = (uint32_t)slot;
  p->coordinate = (int)k;
  p->first = first;
  p->count = 0;
  p->at = b.at[k];
  p->last = *p->at;
  p->speed = b.speed[k];
  p->force = b.force[k];
}

/* Returns the bit MOVES_... of the coordinate with this number (addend.place). */
static unsigned moves_of(const sd_state *s, size_t place) {
  const size_t slot = place / SD_MOVED;
  return slot < s->n_free                 ? MOVES_FREE
         : slot < s->n_disks              ? MOVES_DISKS
         : slot >= s->n_bodies            ? MOVES_CLUMPS
         : place % SD_MOVED == SD_SURFACE ? MOVES_SURFACES
                                          : MOVES_WALLS;
}

/* Lists the coordinates that a running motion moves, by slot and coordinate, each with its signals
 * in the order of the deck; and the running loads and servos. */
static void list_prescribed(engine *e) {
  const sd_state *s = e->state;
  motions *q = e->work.motions;
  size_t terms = 0, last = SIZE_MAX;
  q->n_prescribed = 0;
  q->moves = 0;
  list_addends(e, NULL);
  for (const addend *a = q->addends; a < q->addends + q->n_addends; a++) {
    q->moves |= moves_of(s, a->place);
    if (motion_is_feedback(&e->model->motions[a->motion])) {
      q->moves |= MOVES_BY_FORCE;
      continue;
    }
    if (a->place != last) prescribe(e, &q->prescribed[q->n_prescribed++], a->place, terms);
    last = a->place;
    q->prescribed[q->n_prescribed - 1].count++;
    q->terms[terms] = &q->signals.item[a->motion].now;
    q->term_motions[terms++] = a->motion;
  }
  feedback_list(e, &q->feedbacks);
}

/* True if a running motion moves the coordinate with this number (addend.place). */
static bool is_moved(const engine *e, size_t place) {
  const motions *q = e->work.motions;
  size_t k = 0, end = q->n_addends;
  while (k < end) {
    const size_t middle = k + (end - k) / 2;
    if (q->addends[middle].place < place)
      k = middle + 1;
    else
      end = middle;
  }
  for (; k < q->n_addends && q->addends[k].place == place; k++)
    if (e->state->motion_start[q->addends[k].motion] >= 0) return true;
  return false;
}

/* Moves a coordinate to its base pose, minus full turns or periods removed by wrapping, and sets
 * its velocity to 0. */
static void rest(engine *e, uint32_t slot, int coordinate) {
  const mover b = mover_of(e->state, slot);
  double off, base;
  motion_offset(e, slot, coordinate, &off, &base);
  *b.at[coordinate] = base - off;
  *b.speed[coordinate] = 0.0;
}

/* Switches motion k off. If it has made at least one step, its last value is added to the base pose
 * of its bodies. Coordinates that no other motion moves come to rest. */
static void switch_off(engine *e, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  const motions *q = e->work.motions;
  sd_state *s = e->state;
  assert(s->motion_start[k] >= 0 && s->motion_start[k] <= s->step);
  if (motion_is_feedback(m))
    feedback_end(e, k);
  else if (s->step > s->motion_start[k]) {
    assert(s->step >= q->first && s->step - q->first < MOTION_BATCH);
    for (size_t b = 0; b < m->n_bodies; b++)
      *mover_of(s, slot_of(&e->work.slots, m->bodies[b])).base[m->coordinate] +=
          q->signals.item[k].now.u[s->step - q->first];
  }
  s->motion_start[k] = -1;
  for (size_t b = 0; b < m->n_bodies; b++)
    if (is_moved_body(e, m, b) && !is_moved(e, place_of(e, m, b)))
      rest(e, slot_of(&e->work.slots, m->bodies[b]), m->coordinate);
}

static void switch_on(engine *e, size_t k) {
  assert(e->state->motion_start[k] < 0);
  e->state->motion_start[k] = e->state->step;
  if (motion_source(&e->model->motions[k]) == SIGNAL_RANDOM)
    signals_start_random(e, &e->work.motions->signals, k);
  if (motion_is_feedback(&e->model->motions[k])) feedback_begin(e, k);
}

void motion_begin_phase(engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  assert(s->phase >= 0 && (size_t)s->phase < m->n_phases);
  motion_store(e);
  const bool *active = m->phases[s->phase].active;
  list_addends(e, active);
  /* switch_off needs the values at this step; those ahead may begin with the next one, if the ranks
   * have asked for it already (motion_outruns) */
  motions *q = e->work.motions;
  if (q->first > s->step) signals_load(e, &q->signals);
  if (q->first < 0 || q->first > s->step) fill(e, s->step);
  for (size_t k = 0; k < m->n_motions; k++) {
    bool on = s->motion_start[k] >= 0;
    if (on && !active[k]) switch_off(e, k);
    if (!on && active[k]) switch_on(e, k);
  }
  motion_resume(e);
}

void motion_reload(engine *e) {
  motions *q = e->work.motions;
  signals_load(e, &q->signals);
  q->first = INT64_MIN / 2; /* marks the values ahead as not computed */
  for (size_t k = 0; k < q->n_prescribed; k++) q->prescribed[k].last = *q->prescribed[k].at;
}

void motion_resume(engine *e) {
  motion_reload(e);
  list_prescribed(e);
}

void motion_store(engine *e) {
  const motions *q = e->work.motions;
  if (q && q->first >= 0) signals_store(e, &q->signals);
}

void motion_begin_run(engine *e) {
  for (size_t k = 0; k < e->model->n_motions; k++)
    if (motion_is_feedback(&e->model->motions[k]) && e->state->motion_start[k] >= 0)
      feedback_begin(e, k);
}

unsigned motion_moves(const engine *e) { return e->work.motions->moves; }

int64_t motion_index(const engine *e) { return e->state->step + 1 - e->work.motions->first; }

prescribed *motion_prescribed(engine *e, size_t *n) {
  *n = e->work.motions->n_prescribed;
  return e->work.motions->prescribed;
}

size_t motion_term(const engine *e, const prescribed *p, size_t t) {
  assert(t < p->count);
  return e->work.motions->term_motions[p->first + t];
}

signals *motion_signals(const engine *e) { return &e->work.motions->signals; }

bool motion_ahead(engine *e) {
  int64_t k = motion_index(e);
  if (k < 0 || k >= MOTION_BATCH) fill(e, e->state->step + 1);
  assert(motion_index(e) >= 0 && motion_index(e) < MOTION_BATCH);
  return e->work.motions->quiet;
}

void motion_first_speeds(engine *e) {
  motions *q = e->work.motions;
  const sd_state *s = e->state;
  if (q->n_prescribed == 0) return;
  fill(e, s->step);
  for (prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++)
    if (p->slot >= s->n_free || body_in_play(s, p->slot)) *p->speed = p->velocity[0];
  motion_reload(e);
}

/* --- changes of constants --------------------------------------------------------------------- */

sd_status motion_values(engine *e, double **at) {
  const motions *q = e->work.motions;
  const sd_model *m = e->model;
  if (!memory_row(at, m->n_motions, sizeof **at)) return SD_ERROR_IO;
  motion_store(e);
  motion_reload(e);
  fill(e, e->state->step);
  for (size_t k = 0; k < m->n_motions; k++)
    if (e->state->motion_start[k] >= 0 && !motion_is_feedback(&m->motions[k]))
      (*at)[k] = q->signals.item[k].now.u[0];
  motion_reload(e);
  return SD_OK;
}

sd_status motion_take_over(engine *e, uint32_t disk) {
  const sd_model *m = e->model;
  const uint32_t slot = slot_of(&e->work.slots, disk);
  const mover b = mover_of(e->state, slot);
  double off, base, *now;
  if (motion_values(e, &now) != SD_OK) return SD_ERROR_IO;
  for (int c = 0; c < SD_COORDINATES; c++) {
    motion_offset(e, slot, c, &off, &base);
    *b.base[c] = *b.at[c] + off;
  }
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t n = 0; n < m->motions[k].n_bodies; n++)
      if (m->motions[k].bodies[n] == disk) *b.base[m->motions[k].coordinate] -= now[k];
  free(now);
  return SD_OK;
}

void motion_rescale(engine *e, const sd_motion *next) {
  sd_state *s = e->state;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    const double was = e->model->motions[k].amplitude, now = next[k].amplitude;
    if (next[k].kind != SD_MOTION_RANDOM || was == now) continue;
    assert(was > 0.0);
    double *const of[] = {&s->motion_u0[k], &s->motion_v0[k], &s->motion_u1[k], &s->motion_v1[k]};
    for (size_t n = 0; n < sizeof of / sizeof *of; n++) *of[n] *= now / was;
  }
}

sd_status motion_continue(engine *e, const double *before) {
  const sd_state *s = e->state;
  double *now;
  if (motion_values(e, &now) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    const sd_motion *m = &e->model->motions[k];
    if (s->motion_start[k] < 0 || s->motion_start[k] == s->step || motion_is_feedback(m)) continue;
    for (size_t b = 0; b < m->n_bodies; b++)
      *mover_of(s, slot_of(&e->work.slots, m->bodies[b])).base[m->coordinate] += before[k] - now[k];
  }
  free(now);
  motion_first_speeds(e);
  return SD_OK;
}

/* Sets a coordinate and its velocity to entry k of the values computed ahead; notes displacement,
 * and force and velocity before. */
static void pose(prescribed *p, int64_t k) {
  const double after = p->value[k];
  p->moved = after - p->last;
  p->force_before = *p->force;
  p->speed_before = *p->speed;
  *p->at = p->last = after;
  *p->speed = p->velocity[k];
}

void motion_pose_clumps(engine *e) {
  motions *q = e->work.motions;
  motion_ahead(e);
  for (prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++)
    if (p->slot >= e->state->n_bodies) pose(p, motion_index(e));
}

void motion_pose(engine *e, thread_work *mine) {
  motions *q = e->work.motions;
  const sd_state *s = e->state;
  motion_ahead(e);
  int64_t k = motion_index(e);
  for (prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++) {
    if (p->slot >= s->n_bodies) continue; /* clumps are posed by motion_pose_clumps */
    p->moved = 0.0;
    /* the free disk waits for its insertion or was removed */
    if (p->slot < s->n_free && !body_in_play(s, p->slot)) continue;
    pose(p, k);
    body_pack(e, p->slot);
  }
  if (q->quiet) return;
  feedback_pose(e, &q->feedbacks, mine);
  for (const prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++) {
    if (p->slot < s->n_bodies && neighbours_moved(e, p->slot)) mine->stale = true;
    /* For free disks with a prescribed coordinate the corrector checks the range. */
    if (p->slot >= s->n_free && !motion_in_range(e, p->coordinate, *p->at))
      event_add(&mine->returns, p->slot);
  }
}

bool motion_outruns(engine *e) {
  const motions *q = e->work.motions;
  if (motion_ahead(e)) return false;
  const int64_t k = motion_index(e);
  bool outruns = feedback_outruns(e, &q->feedbacks);
  for (const prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++) {
    if (p->slot >= e->state->n_bodies) continue;
    const double at = *p->at;
    *p->at = p->value[k];
    outruns |= neighbours_moved(e, p->slot);
    *p->at = at;
  }
  return outruns;
}

bool motion_runs(const engine *e) {
  return e->work.motions->n_prescribed > 0 || e->work.motions->feedbacks.count > 0;
}

void motion_wrapped(engine *e, uint32_t slot) {
  motions *q = e->work.motions;
  bool known = q->first >= 0 && e->state->step + 1 - q->first < MOTION_BATCH;
  for (size_t k = 0; k < q->n_prescribed; k++) {
    if (q->prescribed[k].slot != slot) continue;
    q->prescribed[k].last = *q->prescribed[k].at;
    if (known) fill_one(e, &q->prescribed[k]);
  }
}

/* Returns the displacement of a body in the last step through one of its coordinates, if it exceeds
 * the displacement limit; else 0. It is divided by the body's own radius for a free disk, by the
 * smallest radius for other bodies. moved: change of the coordinate; speed: the larger of the
 * speeds before and after the step. */
static double beyond_limit(const engine *e, uint32_t slot, int coordinate, double moved,
                           double speed) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  if (coordinate == SD_SURFACE || (coordinate == SD_THETA && slot < s->n_disks)) return 0.0;
  const double arm = coordinate == SD_THETA ? strides_arm(m, s->id[slot]) : 1.0;
  const double radius = slot < s->n_free ? s->radius[slot] : m->smallest_radius;
  const double way = fabs(moved) * arm / radius, steady = speed * e->work.dt * arm / radius;
  const double jump = (way - steady) / STRIDES_JUMP;
  return math_max(way, math_max(steady, jump)) > m->limits.displacement ? math_max(way, steady)
                                                                        : 0.0;
}

/* Sets *fastest to `way` and *slot to `body` if `way` is larger than *fastest. */
static void keep_faster(double way, uint32_t body, double *fastest, size_t *slot) {
  if (!(way > *fastest)) return;
  *fastest = way;
  *slot = body;
}

double motion_fastest(const engine *e, size_t *slot) {
  const motions *q = e->work.motions;
  /* clumps are skipped: their disks are checked instead */
  const size_t n_bodies = e->state->n_bodies;
  double fastest = 0.0;
  for (const prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++) {
    const double speed = math_max(fabs(*p->speed), fabs(p->speed_before));
    if (p->slot < n_bodies)
      keep_faster(beyond_limit(e, p->slot, p->coordinate, p->moved, speed), p->slot, &fastest,
                  slot);
  }
  for (const feedback *f = q->feedbacks.item; f < q->feedbacks.item + q->feedbacks.count; f++)
    if (f->slot < n_bodies)
      keep_faster(beyond_limit(e, f->slot, f->coordinate, f->moved, fabs(*f->speed)), f->slot,
                  &fastest, slot);
  return fastest;
}

void motion_work(engine *e) {
  motions *q = e->work.motions;
  double done = feedback_correct(e, &q->feedbacks);
  for (const prescribed *p = q->prescribed; p < q->prescribed + q->n_prescribed; p++)
    done += (p->force_before + *p->force) * p->moved;
  e->state->work_driven -= 0.5 * done;
  size_t slot;
  if (e->work.compare_motions && motion_fastest(e, &slot) > 0.0) e->work.threads[0].fast = true;
}
