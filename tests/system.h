/* system.h: small systems built by hand for tests, with tolerant comparison.
 *
 *   sd_model *m = system_new(SD_GEAR5, SD_PAPER, 1e-4, law);   one material, one endless phase
 *   system_disk(m, x, y, radius, mass);                       returns the body number
 *   system_straight(m, kind, n, points) / system_circle(...)  returns the wall's place in m->walls
 *   system_motion(m, body, coordinate, kind)                  fill in the rest
 *   sd_simulation *s = system_start(m);   ...   system_end(s);
 *
 * Body numbers of walls (system_wall_body) are known once all disks are there.
 */
#ifndef TESTS_SYSTEM_H
#define TESTS_SYSTEM_H

#include "unit.h"
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/simulation.h"
#include "slipdisk/theory.h"

#define SYSTEM_NEAR(value, expected, tolerance, ...)                                               \
  do {                                                                                             \
    double value_ = (value), expected_ = (expected), tolerance_ = (tolerance);                     \
    if (!(fabs(value_ - expected_) <= tolerance_)) {                                               \
      print_error(__VA_ARGS__);                                                                    \
      print_error(": %.15g, expected %.15g within %.2g (off by %.2g)\n", value_, expected_,        \
                  tolerance_, fabs(value_ - expected_));                                           \
      fail();                                                                                      \
    }                                                                                              \
  } while (0)

static const char *const system_integrators[] = {"gear5", "verlet"};
static const char *const system_variants[] = {"paper", "conservative"};

static inline void *system_grow(void *list, size_t n, size_t size) {
  void *more = realloc(list, (n + 1) * size);
  assert_non_null(more);
  memset((char *)more + n * size, 0, size);
  return more;
}

/* laws: n * n rows */
static inline sd_model *system_new_laws(sd_integrator integrator, sd_variant variant, double dt,
                                        size_t n, const sd_contact_law *laws) {
  sd_model *m = sd_model_new();
  assert_non_null(m);
  m->integrator = integrator;
  m->variant = variant;
  m->dt = dt;
  m->n_materials = n;
  m->materials = calloc(n, sizeof *m->materials);
  m->laws = calloc(n * n, sizeof *m->laws);
  assert_non_null(m->materials);
  assert_non_null(m->laws);
  memcpy(m->laws, laws, n * n * sizeof *laws);
  return m;
}

static inline sd_model *system_new(sd_integrator integrator, sd_variant variant, double dt,
                                   sd_contact_law law) {
  return system_new_laws(integrator, variant, dt, 1, &law);
}

static inline uint32_t system_disk(sd_model *m, double x, double y, double radius, double mass) {
  m->disks = system_grow(m->disks, m->n_disks, sizeof *m->disks);
  m->disks[m->n_disks] =
      (sd_disk){.position = {x, y, 0}, .radius = radius, .mass = mass, .group = -1};
  return (uint32_t)m->n_disks++;
}

static inline void system_velocity(sd_model *m, uint32_t disk, double vx, double vy, double omega) {
  m->disks[disk].velocity[SD_X] = vx;
  m->disks[disk].velocity[SD_Y] = vy;
  m->disks[disk].velocity[SD_THETA] = omega;
}

/* The pivot is the first point. */
static inline size_t system_straight(sd_model *m, sd_wall_kind kind, size_t n,
                                     const double (*points)[2]) {
  m->walls = system_grow(m->walls, m->n_walls, sizeof *m->walls);
  sd_wall *w = &m->walls[m->n_walls];
  w->kind = kind;
  w->n_points = n;
  w->points = malloc(n * sizeof *w->points);
  assert_non_null(w->points);
  memcpy(w->points, points, n * sizeof *points);
  w->pivot[0] = points[0][0];
  w->pivot[1] = points[0][1];
  return m->n_walls++;
}

static inline size_t system_circle(sd_model *m, double x, double y, double radius, bool inside) {
  m->walls = system_grow(m->walls, m->n_walls, sizeof *m->walls);
  m->walls[m->n_walls] =
      (sd_wall){.kind = SD_WALL_CIRCLE, .pivot = {x, y}, .radius = radius, .inside = inside};
  return m->n_walls++;
}

static inline uint32_t system_wall_body(const sd_model *m, size_t wall) {
  return (uint32_t)(m->n_disks + wall);
}

static inline sd_motion *system_motion(sd_model *m, uint32_t body, int coordinate,
                                       sd_motion_kind kind) {
  m->motions = system_grow(m->motions, m->n_motions, sizeof *m->motions);
  sd_motion *q = &m->motions[m->n_motions++];
  q->kind = kind;
  q->coordinate = coordinate;
  q->n_bodies = 1;
  q->bodies = malloc(sizeof *q->bodies);
  assert_non_null(q->bodies);
  q->bodies[0] = body;
  return q;
}

static inline void system_move(sd_model *m, uint32_t body, int coordinate, double velocity) {
  system_motion(m, body, coordinate, SD_MOTION_VELOCITY)->velocity = velocity;
}

/* amplitude sin(omega t + phase) */
static inline void system_shake(sd_model *m, uint32_t body, int coordinate, double amplitude,
                                double omega, double phase) {
  sd_motion *q = system_motion(m, body, coordinate, SD_MOTION_HARMONIC);
  q->amplitude = amplitude;
  q->omega = omega;
  q->phase = phase;
}

static inline sd_simulation *system_start(sd_model *m) {
  m->phases = calloc(1, sizeof *m->phases);
  assert_non_null(m->phases);
  m->n_phases = 1;
  m->phases[0].steps = INT64_MAX / 4;
  m->phases[0].active = calloc(m->n_motions + 1, sizeof(bool));
  for (size_t k = 0; k < m->n_motions; k++) m->phases[0].active[k] = true;
  sd_messages *messages = sd_messages_new();
  sd_simulation *s = NULL;
  if (sd_model_finish(m, messages) != SD_OK || sd_simulation_new(m, 1, &s, messages) != SD_OK) {
    sd_messages_print(messages, stderr);
    fail();
  }
  sd_messages_free(messages);
  return s;
}

static inline void system_end(sd_simulation *s) {
  sd_model *m = (sd_model *)(uintptr_t)sd_simulation_model(s);
  sd_simulation_free(s);
  sd_model_free(m);
}

/* Many tests go step by step: one list serves them all. */
static inline void system_advance(sd_simulation *s, int64_t steps) {
  static sd_messages *messages;
  if (!messages) messages = sd_messages_new();
  if (sd_simulation_advance(s, steps, messages) != SD_OK) {
    sd_messages_print(messages, stderr);
    fail();
  }
}

typedef struct system_body {
  double x, y, vx, vy, omega;
  long double theta; /* unwrapped, without rounding */
  double force_x, force_y, torque;
} system_body;

static inline system_body system_at(sd_simulation *s, uint32_t body) {
  const sd_state *q = sd_simulation_state(s);
  const sd_model *m = sd_simulation_model(s);
  uint32_t k = sd_simulation_slot(s, body);
  return (system_body){
      .x = q->x[k] + (m->periodic[0] ? q->image_x[k] * (m->upper[0] - m->lower[0]) : 0),
      .y = q->y[k] + (m->periodic[1] ? q->image_y[k] * (m->upper[1] - m->lower[1]) : 0),
      .vx = q->vx[k],
      .vy = q->vy[k],
      .omega = q->omega[k],
      .theta = (long double)q->turn[k] + q->theta[k],
      .force_x = q->force_x[k],
      .force_y = q->force_y[k],
      .torque = q->torque[k],
  };
}

typedef struct system_contact {
  bool closed;
  double force, overlap, stretch;
  int slide;
  uint32_t part;
  size_t pieces; /* closed contacts between the two bodies */
} system_contact;

/* The contact of two bodies; the last of several pieces of a wall. */
static inline system_contact system_touch(sd_simulation *s, uint32_t a, uint32_t b) {
  const sd_state *q = sd_simulation_state(s);
  system_contact c = {0};
  for (size_t k = 0; k < q->n_contacts; k++) {
    bool same = (q->contact_a[k] == a && q->contact_b[k] == b) ||
                (q->contact_a[k] == b && q->contact_b[k] == a);
    if (!same) continue;
    c = (system_contact){true,
                         q->contact_force[k],
                         q->contact_overlap[k],
                         q->contact_zeta[k],
                         q->contact_slide[k],
                         q->contact_part[k],
                         c.pieces + 1};
  }
  return c;
}

#endif
