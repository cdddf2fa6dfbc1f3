/* loads.c: walls that move under the forces of the disks (loads and servos): the side of a wall
 * on which the disks are, and checks before a run; see model.h. */
#include "model/walls.h"
#include "model/model.h"

#include <math.h>

#include "base/math.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/rows.h"

/* Collective. Computes the mean position of the free disks that do not wait for their release;
 * without any, the centre of the region. */
static void middle(const sd_model *m, double at[2]) {
  double sum[2] = {0.0, 0.0}, n = 0.0;
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (d->driven || d->waiting) continue;
    for (int c = 0; c < 2; c++) sum[c] += d->position[c];
    n++;
  }
  n = rows_sum(m, n);
  for (int c = 0; c < 2; c++) sum[c] = rows_sum(m, sum[c]);
  for (int c = 0; c < 2; c++)
    at[c] = n > 0.0 ? sum[c] / n : 0.5 * (m->region_lower[c] + m->region_upper[c]);
}

static int sign_of(double x) { return (x > 0.0) - (x < 0.0); }

static bool is_wall(const sd_model *m, uint32_t body) {
  return body >= m->n_disks && body < sd_model_bodies(m);
}

int sd_model_side(const sd_model *m, uint32_t body, int coordinate) {
  if (!is_wall(m, body) || (coordinate != SD_X && coordinate != SD_Y)) return 0;
  /* disks are on both sides: between the wall and its periodic image */
  if (m->periodic[coordinate]) return 0;
  const sd_wall *w = &m->walls[body - m->n_disks];
  double disks[2], at = w->pivot[coordinate];
  middle(m, disks);
  if (w->inside || w->closed || (w->kind != SD_WALL_CIRCLE && w->n_points < 2)) return 0;
  if (w->kind == SD_WALL_LINE || w->kind == SD_WALL_SEGMENT) {
    const double *p = w->points[0], *q = w->points[1];
    double dx = q[0] - p[0], dy = q[1] - p[1], length = math_hypot(dx, dy);
    double normal[2] = {-dy / length, dx / length};
    if (fabs(normal[coordinate]) < 1e-9) return 0;
    double away = (disks[0] - p[0]) * normal[0] + (disks[1] - p[1]) * normal[1];
    return sign_of(away) * sign_of(normal[coordinate]);
  }
  if (w->kind == SD_WALL_ARC && arc_is_ring(w)) return 0;
  if (w->kind == SD_WALL_POLYLINE || w->kind == SD_WALL_ARC) {
    at = 0.0;
    for (size_t k = 0; k < w->n_points; k++) at += w->points[k][coordinate] / (double)w->n_points;
  }
  return sign_of(disks[coordinate] - at);
}

/* True if motion j moves the same coordinate of the same wall as motion k, which is a load or
 * servo. */
static bool clash(const sd_model *m, size_t k, size_t j) {
  const sd_motion *a = &m->motions[k], *b = &m->motions[j];
  if (a->n_bodies == 0 || a->coordinate != b->coordinate) return false;
  for (size_t i = 0; i < b->n_bodies; i++)
    if (b->bodies[i] == a->bodies[0]) return true;
  return false;
}

bool sd_model_clash(const sd_model *m, size_t phase, size_t motion[2]) {
  const bool *active = phase < m->n_phases ? m->phases[phase].active : NULL;
  for (size_t k = 0; active && k < m->n_motions; k++) {
    if (!active[k] || !motion_is_feedback(&m->motions[k])) continue;
    for (size_t j = 0; j < m->n_motions; j++) {
      if (j == k || !active[j] || !clash(m, k, j)) continue;
      motion[0] = k;
      motion[1] = j;
      return true;
    }
  }
  return false;
}

/* --- checks ----------------------------------------------------------------------------------- */

/* Reports errors of a load or servo (docs/physics.md 6), and warns if it pushes its wall away
 * from the disks. */
static void check_one(const sd_model *m, size_t k, sd_messages *msg) {
  const sd_motion *q = &m->motions[k];
  const char *kind = motion_kinds[q->kind].name;
  size_t before = sd_messages_errors(msg);
  char wall[96];
  if (q->n_bodies != 1 || !is_wall(m, q->bodies[0]) || q->coordinate > SD_Y)
    fail_about(msg, about_motion(m, k), "a %s moves one wall along x or y", kind);
  if (!isfinite(q->force) || !isfinite(q->pressure) || q->ramp > 0.0)
    fail_about(msg, about_motion(m, k), "expected a finite force or pressure, and no ramp");
  if (q->kind == SD_MOTION_LOAD && !(q->mass > 0.0))
    fail_about(msg, about_motion(m, k), "mass = %g: expected a number > 0", q->mass);
  if (q->kind == SD_MOTION_SERVO) {
    if (!(q->velocity > 0.0))
      fail_about(msg, about_motion(m, k), "speed = %g: expected a number > 0", q->velocity);
    if ((q->force == 0.0) == (q->pressure == 0.0))
      fail_about(msg, about_motion(m, k), "expected either a force or a pressure, not 0");
    if (q->pressure != 0.0 && !(q->length > 0.0))
      fail_about(msg, about_motion(m, k), "length = %g: expected a number > 0", q->length);
    for (int side = 0; side < 2; side++)
      if (q->beside[side] != 0 && !is_wall(m, q->beside[side]))
        fail_about(msg, about_motion(m, k), "body %u is no wall", q->beside[side]);
  }
  if (sd_messages_errors(msg) > before) return;
  double push = q->kind == SD_MOTION_SERVO && q->pressure != 0.0 ? q->pressure : q->force;
  if (sd_model_side(m, q->bodies[0], q->coordinate) * push < 0.0)
    sd_warn(msg,
            "motion \"%s\": a %s of %g along %c pushes %s away from the disks, and nothing will "
            "hold it",
            q->name ? q->name : "?", kind, push, q->coordinate == SD_X ? 'x' : 'y',
            sd_model_body_name(m, q->bodies[0], wall, sizeof wall));
}

/* Reports phases in which another motion moves the wall of a load or servo. */
static void check_clashes(const sd_model *m, sd_messages *msg) {
  size_t q[2];
  for (size_t k = 0; k < m->n_phases; k++)
    if (sd_model_clash(m, k, q))
      fail_about(msg, about_path("phases[%zu]", k),
                 "motion \"%s\" leaves a wall to the disks that motion \"%s\" moves too",
                 m->motions[q[0]].name ? m->motions[q[0]].name : "?",
                 m->motions[q[1]].name ? m->motions[q[1]].name : "?");
}

void loads_check(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_motions; k++)
    if (motion_is_feedback(&m->motions[k])) check_one(m, k, msg);
  check_clashes(m, msg);
}

/* --- the time step ---------------------------------------------------------------------------- */

/* Smallest number of time steps per oscillation period of a wall moved as a load; with fewer
 * there is a warning. */
enum { STEPS_PER_PERIOD = 20 };

/* Collective. Number of free disks that fit side by side along a wall; across: index of the
 * coordinate parallel to the wall, at right angles to its motion. */
static double disks_along(const sd_model *m, const sd_wall *wall, int across) {
  double low = HUGE_VAL, high = -HUGE_VAL, radius = HUGE_VAL;
  for (size_t row = 0; row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (d->driven) continue;
    low = math_min(low, d->position[across] - d->radius);
    high = math_max(high, d->position[across] + d->radius);
    radius = math_min(radius, d->radius);
  }
  low = rows_least(m, low);
  high = rows_largest(m, high);
  radius = rows_least(m, radius);
  if (m->region_upper[across] > m->region_lower[across])
    high = low + m->region_upper[across] - m->region_lower[across];
  if (wall->kind == SD_WALL_SEGMENT)
    high = low + math_hypot(wall->points[1][0] - wall->points[0][0],
                            wall->points[1][1] - wall->points[0][1]);
  return math_min(math_max(floor((high - low) / (2.0 * radius)), 1.0), (double)m->n_free);
}

void loads_check_steps(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (q->kind != SD_MOTION_LOAD || m->n_free == 0) continue;
    const sd_wall *wall = &m->walls[q->bodies[0] - m->n_disks];
    double largest = 0.0; /* largest radius of any disk */
    for (size_t row = 0; row < rows_count(m); row++)
      largest = math_max(largest, rows_disk(m, row)->radius);
    largest = rows_largest(m, largest);
    double stiffness = 0.0, n = disks_along(m, wall, q->coordinate == SD_X ? SD_Y : SD_X);
    for (int b = 0; b < (int)m->n_materials; b++)
      stiffness =
          math_max(stiffness, law_typical_stiffness(sd_model_law(m, wall->material, b), largest));
    double period = 2.0 * M_PI * sqrt(q->mass / (n * stiffness));
    if (m->dt * STEPS_PER_PERIOD > period)
      sd_warn(msg,
              "motion \"%s\": mass = %g is small: its period on the disks that fit along the wall "
              "(%g) is "
              "%.3g, or %.3g time steps; expected %d or more",
              q->name ? q->name : "?", q->mass, n, period, period / m->dt, STEPS_PER_PERIOD);
  }
}
