/* feedback.c: walls that are moved by the contact forces on them, loads and servos; see signals.h.
 *
 * Load of mass M: its coordinate is integrated with velocity Verlet, whatever the integrator of the
 * disks:
 *   u += v dt + a dt^2/2,  forces at v + a dt,  v += (a + a_new) dt/2,
 *   a = (contacts + weight + force)/M.
 * Servo: v = speed clamp((target - F)/|target|, -1, 1), where F is the force of the wall on the
 * disks, averaged exponentially over the shortest contact period P. Within the clamp the wall
 * behaves like one of mass P target/speed with a drag coefficient target/speed: it removes energy
 * from the system that it pushes and cannot make it oscillate.
 */
#include "physics/motion/signals.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/motions.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"

void feedback_new(const engine *e, feedbacks *all) {
  size_t n = 0;
  bool servo = false;
  for (size_t k = 0; k < e->model->n_motions; k++) {
    n += motion_is_feedback(&e->model->motions[k]);
    servo |= e->model->motions[k].kind == SD_MOTION_SERVO;
  }
  all->item = memory_new(n, sizeof *all->item);
  assert(!servo || n > 0);
  if (servo) all->smoothing = -math_expm1(-e->model->dt / e->model->shortest_period);
}

void feedback_free(feedbacks *all) {
  free(all->item);
  *all = (feedbacks){0};
}

void feedback_list(engine *e, feedbacks *all) {
  const sd_model *m = e->model;
  sd_state *s = e->state;
  all->count = 0;
  for (size_t k = 0; k < m->n_motions; k++) {
    if (s->motion_start[k] < 0 || !motion_is_feedback(&m->motions[k])) continue;
    uint32_t slot = slot_of(&e->work.slots, m->motions[k].bodies[0]);
    assert(m->motions[k].n_bodies == 1 && slot >= s->n_disks &&
           m->motions[k].coordinate != SD_THETA);
    bool x = m->motions[k].coordinate == SD_X;
    all->item[all->count++] = (feedback){.motion = k,
                                         .slot = slot,
                                         .coordinate = m->motions[k].coordinate,
                                         .at = (x ? s->x : s->y) + slot,
                                         .speed = (x ? s->vx : s->vy) + slot,
                                         .force = (x ? s->force_x : s->force_y) + slot,
                                         .base = (x ? s->base_x : s->base_y) + slot,
                                         .image = (x ? s->image_x : s->image_y) + slot};
  }
}

void feedback_begin(engine *e, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  assert(motion_is_feedback(m));
  sd_state *s = e->state;
  uint32_t slot = slot_of(&e->work.slots, m->bodies[0]);
  double force = m->coordinate == SD_X ? s->force_x[slot] : s->force_y[slot];
  s->motion_u0[k] = s->motion_v0[k] = 0.0;
  s->motion_u1[k] = m->kind == SD_MOTION_SERVO ? -force : 0.0;
}

void feedback_end(engine *e, size_t k) {
  const sd_motion *m = &e->model->motions[k];
  assert(motion_is_feedback(m));
  sd_state *s = e->state;
  (m->coordinate == SD_X ? s->base_x : s->base_y)[slot_of(&e->work.slots, m->bodies[0])] +=
      s->motion_u0[k];
  s->motion_u0[k] = s->motion_v0[k] = s->motion_u1[k] = 0.0;
}

/* --- servo ------------------------------------------------------------------------------------ */

/* Returns how far a wall has moved along coordinate c since the start, apart from the scaling of
 * the region; 0 if `body` is 0, which means that there is no wall. */
static double displaced(const engine *e, uint32_t body, int c) {
  if (body == 0) return 0.0;
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  uint32_t slot = slot_of(&e->work.slots, body);
  double at = c == SD_X ? s->x[slot] + s->image_x[slot] * e->work.length[0]
                        : s->y[slot] + s->image_y[slot] * e->work.length[1];
  double corner = box_corner(m, c);
  return at - (corner + s->box_scale * (m->walls[body - m->n_disks].pivot[c] - corner));
}

/* Returns the present target of the force of a servo's wall on the disks: the given force, or the
 * given pressure times the distance between the two walls beside the servo's wall. */
static double target(const engine *e, const sd_motion *m) {
  if (m->pressure == 0.0) return m->force;
  int across = m->coordinate == SD_X ? SD_Y : SD_X;
  double length = e->state->box_scale * m->length + displaced(e, m->beside[1], across) -
                  displaced(e, m->beside[0], across);
  return m->pressure * math_max(length, 0.0);
}

/* Updates the time-averaged force of a servo's wall on the disks, and returns the velocity of the
 * wall in this step. */
static double servo_speed(engine *e, const feedbacks *all, const feedback *f) {
  const sd_motion *m = &e->model->motions[f->motion];
  double *felt = &e->state->motion_u1[f->motion], wanted = target(e, m);
  *felt += all->smoothing * (-*f->force - *felt);
  /* The two walls beside the servo's wall have met: there is no length left to push on. */
  if (wanted == 0.0) return 0.0;
  return m->velocity * math_min(math_max((wanted - *felt) / fabs(wanted), -1.0), 1.0);
}

/* --- loads and servos ------------------------------------------------------------------------- */

/* Returns the acceleration of a load under the contact force `contacts` and its constant force
 * (m->force), which includes its weight. */
static double acceleration(const engine *e, const feedback *f, double contacts) {
  const sd_motion *m = &e->model->motions[f->motion];
  assert(m->mass > 0.0);
  return (contacts + m->force) / m->mass;
}

void feedback_pose(engine *e, feedbacks *all, thread_work *mine) {
  const work *w = &e->work;
  sd_state *s = e->state;
  for (feedback *f = all->item; f < all->item + all->count; f++) {
    double *u = &s->motion_u0[f->motion], *v = &s->motion_v0[f->motion], before = *u;
    f->force_before = *f->force;
    if (e->model->motions[f->motion].kind == SD_MOTION_SERVO) {
      *v = servo_speed(e, all, f);
      *u += w->dt * *v;
      *f->speed = *v;
    } else {
      double a = acceleration(e, f, *f->force);
      *u += w->dt * *v + w->half_dt2 * a;
      *f->speed = *v + w->dt * a;
    }
    f->moved = *u - before;
    *f->at = *f->base + *u - *f->image * w->length[f->coordinate];
    body_pack(e, f->slot);
    if (neighbours_moved(e, f->slot)) mine->stale = true;
    if (!(*f->at >= w->lower[f->coordinate] && *f->at < w->upper[f->coordinate]))
      event_add(&mine->returns, f->slot);
  }
}

/* Tests loads at their next position, and servos at their highest speed in both directions. */
bool feedback_outruns(const engine *e, const feedbacks *all) {
  const work *w = &e->work;
  bool outruns = false;
  for (const feedback *f = all->item; f < all->item + all->count; f++) {
    const sd_motion *m = &e->model->motions[f->motion];
    const bool servo = m->kind == SD_MOTION_SERVO;
    const double at = *f->at, way = servo ? w->dt * m->velocity
                                          : w->dt * e->state->motion_v0[f->motion] +
                                                w->half_dt2 * acceleration(e, f, *f->force);
    *f->at = at + way;
    outruns |= neighbours_moved(e, f->slot);
    *f->at = at - way;
    if (servo) outruns |= neighbours_moved(e, f->slot);
    *f->at = at;
  }
  return outruns;
}

double feedback_correct(engine *e, feedbacks *all) {
  sd_state *s = e->state;
  double done = 0.0;
  for (feedback *f = all->item; f < all->item + all->count; f++) {
    done += (f->force_before + *f->force) * f->moved;
    if (e->model->motions[f->motion].kind != SD_MOTION_LOAD) continue;
    double *v = &s->motion_v0[f->motion];
    *v += 0.5 * e->work.dt * (acceleration(e, f, f->force_before) + acceleration(e, f, *f->force));
    *f->speed = *v;
    body_pack(e, f->slot);
  }
  return done;
}
