/* advice_bodies.c: warnings about set-ups of bodies that are seldom intended: walls that meet,
 * prescribed bodies that overlap each other, motions that start with a jump. See advice.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/advice.h"
#include "model/field_kinds.h"
#include "model/laws.h"
#include "model/motions.h"
#include "model/overlaps.h"
#include "model/rows.h"
#include "model/walls.h"

/* --- points at which a disk touches two walls ------------------------------------------------- */

static double cross(const double a[2], const double b[2]) { return a[0] * b[1] - a[1] * b[0]; }
static double dot(const double a[2], const double b[2]) { return a[0] * b[0] + a[1] * b[1]; }

/* Points at which a disk may touch two walls at once: their number, and the first of them. */
typedef struct twice {
  size_t count;
  uint32_t a, b; /* walls of the first point */
  double at[2];  /* position of the first point */
} twice;

/* Counts a point at which a disk may touch the walls a and b, and stores the first one. */
static void note(twice *t, uint32_t a, uint32_t b, const double at[2]) {
  if (t->count++ > 0) return;
  t->a = a;
  t->b = b;
  for (int c = 0; c < 2; c++) t->at[c] = at[c];
}

/* Function that tests the position of a disk; user: further data for the test. */
typedef bool disk_place(const double at[2], const void *user);

/* Collective. True if the test `is` holds for the position of any free disk. Disks that wait to
 * be released have no position yet and are skipped. */
static bool any_disk(const sd_model *m, disk_place *is, const void *user) {
  bool any = false;
  for (size_t row = 0; row < rows_count(m) && !any; row++) {
    const sd_disk *d = rows_disk(m, row);
    any = !d->driven && !d->waiting && is(d->position, user);
  }
  return rows_any(m, any);
}

/* --- joined ends of walls that move apart ----------------------------------------------------- */

/* True if a disk at this position would touch two joined walls at their common end point, so
 * that both push it there. It is false within the angle between the walls, where a disk touches
 * each wall at a point of its own. user: the ends of the two walls. */
static bool is_beyond_corner(const double at[2], const void *user) {
  const wall_end *const *e = user, *a = e[0], *b = e[1];
  const double p[2] = {at[0] - a->at[0], at[1] - a->at[1]}, opens = cross(a->way, b->way);
  return !(fabs(opens) > 1e-9) || cross(a->way, p) * opens < 0.0 || cross(p, b->way) * opens < 0.0;
}

/* Finds ends of two walls that meet at the start but do not move together, if a disk lies where
 * it would touch both ends. */
static void look_at_ends(const sd_model *m, const wall_end *ends, size_t n, twice *found) {
  for (size_t k = 0; k < n; k++)
    for (size_t j = k + 1, last = joints_near(ends, n, k); j < last; j++) {
      const wall_end *two[2] = {&ends[k], &ends[j]};
      if (joints_meet(two[0], two[1]) && !joints_rigid(m, two[0], two[1]) &&
          any_disk(m, is_beyond_corner, two))
        note(found, ends[k].wall, ends[j].wall, ends[k].at);
    }
}

/* --- walls that end on another wall ----------------------------------------------------------- */

/* Surface of a wall, a straight line or a circle, on which the end of another wall lies. */
typedef struct surface {
  const double *at, *center; /* point of the surface; centre of the circle, NULL: straight line */
  double normal[2], radius;
  /* Side of this surface on which the other wall lies, > 0: that to which `normal` points; 0:
   * the other wall runs along the surface. */
  double side;
} surface;

/* Describes side k of wall w in *s. True if the end e of another wall lies on this side, within
 * the distance `near`, and not on an end of w. */
static bool lies_on(const sd_wall *w, size_t k, const wall_end *e, double near, surface *s) {
  *s = (surface){.at = e->at};
  if (w->kind == SD_WALL_CIRCLE || w->kind == SD_WALL_ARC) {
    s->center = w->kind == SD_WALL_ARC ? w->center : w->pivot;
    s->radius = w->radius;
    for (int c = 0; c < 2; c++) s->normal[c] = (e->at[c] - s->center[c]) / w->radius;
    const double angle =
        remainder(math_atan2(s->normal[1], s->normal[0]) - 0.5 * (w->from + w->to), 2.0 * M_PI);
    return fabs(math_hypot(s->normal[0], s->normal[1]) - 1.0) * w->radius <= near &&
           (w->kind == SD_WALL_CIRCLE ||
            (0.5 * (w->to - w->from) - fabs(angle)) * w->radius > near);
  }
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
  const double along[2] = {q[0] - p[0], q[1] - p[1]}, from[2] = {e->at[0] - p[0], e->at[1] - p[1]};
  const double length = math_hypot(along[0], along[1]), on = dot(along, from) / length;
  const bool first = k == 0 && !w->closed, last = k + 2 == w->n_points && !w->closed;
  s->normal[0] = -along[1] / length;
  s->normal[1] = along[0] / length;
  return fabs(dot(s->normal, from)) <= near &&
         (w->kind == SD_WALL_LINE ||
          (on > (first ? near : -near) && on < length - (last ? near : -near)));
}

/* True if a disk at this position is not on the side of the surface on which the other wall
 * lies. user: the surface. */
static bool is_on_other_side(const double at[2], const void *user) {
  const surface *s = user;
  double side;
  if (s->center) {
    side = math_hypot(at[0] - s->center[0], at[1] - s->center[1]) - s->radius;
  } else {
    const double p[2] = {at[0] - s->at[0], at[1] - s->at[1]};
    side = dot(s->normal, p);
  }
  return !(side * s->side > 0.0);
}

/* Number of straight sides of a polyline; 1 for walls of other shapes. */
static size_t sides_of(const sd_wall *w) {
  if (w->kind != SD_WALL_POLYLINE) return 1;
  return w->n_points - (w->closed ? 0 : 1);
}

/* Computes the smallest and largest x of a wall, which are infinite for an infinite line. */
static void bounds_of(const sd_wall *w, double *lower, double *upper) {
  *lower = w->kind == SD_WALL_CIRCLE ? w->pivot[0] - w->radius : HUGE_VAL;
  *upper = w->kind == SD_WALL_CIRCLE ? w->pivot[0] + w->radius : -HUGE_VAL;
  for (size_t k = 0; k < w->n_points; k++) {
    *lower = math_min(*lower, w->points[k][0]);
    *upper = math_max(*upper, w->points[k][0]);
  }
  if (w->kind == SD_WALL_ARC) *lower = w->center[0] - w->radius, *upper = w->center[0] + w->radius;
  if (w->kind == SD_WALL_LINE) *lower = -HUGE_VAL, *upper = HUGE_VAL;
}

/* Returns the index of the first of n wall ends, sorted by x, that is not left of the given x. */
static size_t first_from(const wall_end *ends, size_t n, double x) {
  size_t from = 0;
  while (from < n) {
    const size_t middle = from + (n - from) / 2;
    if (ends[middle].at[0] + joints_tolerance(&ends[middle]) < x)
      from = middle + 1;
    else
      n = middle;
  }
  return from;
}

/* Finds ends of walls that lie on the surface of another wall, if a disk is on the opposite side
 * of that surface. */
static void look_at_surfaces(const sd_model *m, const wall_end *ends, size_t n, twice *found) {
  double lower, upper;
  for (uint32_t w = 0; w < m->n_walls; w++) {
    bounds_of(&m->walls[w], &lower, &upper);
    for (size_t e = first_from(ends, n, lower); e < n; e++) {
      const double near = joints_tolerance(&ends[e]);
      surface s;
      bool on = false;
      if (ends[e].at[0] - near > upper) break;
      for (size_t k = 0; ends[e].wall != w && !on && k < sides_of(&m->walls[w]); k++)
        on = lies_on(&m->walls[w], k, &ends[e], near, &s);
      if (!on) continue;
      s.side = dot(s.normal, ends[e].way);
      if (fabs(s.side) < 1e-9) s.side = 0.0; /* this end of the wall runs along the other wall */
      if (any_disk(m, is_on_other_side, &s)) note(found, ends[e].wall, w, ends[e].at);
    }
  }
}

/* --- warnings --------------------------------------------------------------------------------- */

/* Warns about the first point in t and the number of further ones, and returns the number of
 * points. where: how the two walls touch; advice: how to avoid it. */
static double tell(const sd_model *m, const twice *t, const char *where, const char *advice,
                   sd_messages *messages) {
  char one[96], two[96], more[48] = "";
  if (t->count == 0) return 0.0;
  if (t->count > 1) snprintf(more, sizeof more, " (and %zu more)", t->count - 1);
  sd_warn(messages, "%s %s %s at (%g, %g)%s: %s",
          sd_model_body_name(m, (uint32_t)m->n_disks + t->a, one, sizeof one), where,
          sd_model_body_name(m, (uint32_t)m->n_disks + t->b, two, sizeof two), t->at[0], t->at[1],
          more, advice);
  return (double)t->count;
}

double advice_joints(const sd_model *m, sd_messages *messages) {
  twice ends = {0}, surfaces = {0};
  size_t n;
  wall_end *all = joints_ends(m, &n);
  look_at_ends(m, all, n, &ends);
  look_at_surfaces(m, all, n, &surfaces);
  free(all);
  const double apart =
      tell(m, &ends, "meets",
           "they move apart, so a disk there feels both; name both in the same motions, or "
           "draw them as one polyline",
           messages);
  return math_max(
      apart,
      tell(m, &surfaces, "ends on",
           "a disk on its other side feels both there; let the first end before it, or draw the "
           "second in two parts whose ends meet there",
           messages));
}

/* --- overlaps of prescribed bodies, between which no force acts ------------------------------- */

/* Check of prescribed bodies: overlap divided by the radius beyond which a warning is given,
 * number of times of the run that are examined (MOMENTS), and largest number of pairs examined
 * at all times together (MOST_LOOKS). */
static const double LEAST_OVERLAP = 0.01;
enum { MOMENTS = 101, MOST_LOOKS = 2000000 };

/* Displacement of a body by its prescribed motions: x, y, angle. */
typedef struct displaced {
  double by[3];
} displaced;

/* Bodies with prescribed positions, by ascending body number, and the displacement of each body
 * if all motions are switched on. */
typedef struct bodies {
  size_t n;
  uint32_t *list;
  displaced *all; /* [disks and walls] displacement of each body, indexed by body number */
} bodies;

/* Duration of the run. */
static double total_time(const sd_model *m) {
  double steps = 0;
  for (size_t k = 0; k < m->n_phases; k++) steps += (double)m->phases[k].steps;
  return steps * m->dt;
}

/* Lists the prescribed disks and all walls. False: out of memory. */
static bool list_bodies(const sd_model *m, bodies *p) {
  const size_t n_bodies = m->n_disks + m->n_walls;
  if (!memory_rows(2, (memory_column[]){{&p->list, n_bodies - m->n_free, sizeof *p->list},
                                        {&p->all, n_bodies, sizeof *p->all}})) {
    shortage_note();
    return false;
  }
  for (uint32_t b = 0; b < n_bodies; b++)
    if (b >= m->n_disks || (b < model_held(m) && m->disks[b].driven && !m->disks[b].waiting))
      p->list[p->n++] = b;
  return true;
}

/* Computes the displacements of the listed bodies at time t. */
static void displace(const sd_model *m, double t, const bodies *p) {
  displaced *all = p->all;
  for (size_t k = 0; k < p->n; k++) all[p->list[k]] = (displaced){{0}};
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (q->coordinate == SD_SURFACE) continue;
    const double u = motion_at(q, t);
    for (size_t b = 0; b < q->n_bodies; b++)
      if (q->bodies[b] < m->n_disks + m->n_walls) all[q->bodies[b]].by[q->coordinate] += u;
  }
}

/* Gap between a disk and another body after their displacements `all`; < 0: overlap. */
static double gap_of(const sd_model *m, uint32_t disk, uint32_t body, const displaced *all) {
  const sd_disk *d = &m->disks[disk];
  const bool wall = body >= m->n_disks;
  const double *at = wall ? m->walls[body - m->n_disks].pivot : m->disks[body].position;
  const double x[2] = {d->position[0] + all[disk].by[0], d->position[1] + all[disk].by[1]};
  const double pose[3] = {at[0] + all[body].by[0], at[1] + all[body].by[1],
                          wall ? all[body].by[2] : 0};
  return overlaps_gap(m, disk, x, body, pose);
}

/* The deepest overlap of two bodies with prescribed positions. */
typedef struct meeting {
  uint32_t disk, body;
  double depth; /* overlap divided by the radius of the smaller disk */
} meeting;

/* Returns the smaller radius of two disks, or the radius of the disk if the other body is a
 * wall. */
static double smaller(const sd_model *m, uint32_t disk, uint32_t body) {
  const double radius = m->disks[disk].radius;
  return body < m->n_disks ? math_min(radius, m->disks[body].radius) : radius;
}

/* True if the two bodies have moved relative to each other. */
static bool parted(const sd_model *m, uint32_t disk, uint32_t body, const displaced *all) {
  const double *one = all[disk].by, *other = all[body].by;
  const bool turns = body >= m->n_disks && other[SD_THETA] != 0;
  return one[SD_X] != other[SD_X] || one[SD_Y] != other[SD_Y] || turns;
}

/* Finds the pair of prescribed bodies whose overlap, relative to the radius, has grown most
 * since the start; replaces *worst if it is deeper. */
static void look(const sd_model *m, const bodies *p, meeting *worst) {
  for (size_t k = 0; k < p->n && p->list[k] < m->n_disks; k++)
    for (size_t l = k + 1; l < p->n; l++) {
      const uint32_t disk = p->list[k], body = p->list[l];
      const double gap = parted(m, disk, body, p->all) ? gap_of(m, disk, body, p->all) : 0;
      if (!(gap < 0)) continue;
      const double radius = smaller(m, disk, body),
                   deeper = -gap + math_min(overlaps_first_gap(m, disk, body), 0);
      if (deeper > math_max(LEAST_OVERLAP, worst->depth) * radius)
        *worst = (meeting){disk, body, deeper / radius};
    }
}

double advice_prescribed(const sd_model *m, sd_messages *messages) {
  char one[96], two[96];
  const double driven = (double)(m->n_disks - m->n_free), time = total_time(m),
               looks = MOMENTS * driven * (driven + (double)m->n_walls);
  meeting worst = {0};
  bodies p = {0};
  if (m->n_motions == 0 || !(driven > 0) || looks > MOST_LOOKS) return 0;
  const bool listed = list_bodies(m, &p);
  /* times that are spaced by the golden ratio do not repeat in step with any periodic motion */
  for (int k = 0; k < MOMENTS && listed; k++) {
    displace(m, k == 0 ? time : time * fmod(k * 0.6180339887498949, 1.0), &p);
    look(m, &p, &worst);
  }
  free(p.list);
  free(p.all);
  if (!(worst.depth > 0)) return 0;
  sd_warn(messages,
          "%s and %s are both prescribed, and motions bring them to overlap by %.2g of the radius: "
          "no force acts "
          "between them, only on disks that are free",
          sd_model_body_name(m, worst.disk, one, sizeof one),
          sd_model_body_name(m, worst.body, two, sizeof two), worst.depth);
  return worst.depth / LEAST_OVERLAP;
}

/* --- motions that jump, or move too far in a step --------------------------------------------- */

/* A motion gets a warning if its initial jump divided by the radius of the smallest disk is
 * larger than LEAST_JUMP, or if one of its cycles has fewer than FEWEST_STEPS time steps. */
static const double LEAST_JUMP = 1e-3, FEWEST_STEPS = 20;

/* Warns about a body that moves farther in one step than limits.displacement allows. */
static double check_stride(const sd_model *m, sd_messages *messages) {
  char motion[96], body[96];
  const double limit = m->limits.displacement;
  body_stride s;
  if (!(limit > 0) || !strides_longest(m, &s) || !(s.length > limit)) return 0;
  const char *name = model_motion_name(m, s.motion, motion, sizeof motion);
  sd_model_body_name(m, s.body, body, sizeof body);
  if (motion_source(&m->motions[s.motion]) == SIGNAL_TABLE)
    sd_warn(messages,
            "%s: %s moves by up to %.3g radii of the smallest disk in a step, and disks may pass "
            "through it: "
            "spread the change over more time (limits.displacement is %g)",
            name, body, s.length, limit);
  else
    sd_warn(messages,
            "%s: %s moves by up to %.3g radii of the smallest disk in a step, and disks may pass "
            "through it: "
            "take a lower speed, or dt = %.2g or less (limits.displacement is %g)",
            name, body, s.length, m->dt * limit / s.length / 2, limit);
  return s.length / limit;
}

/* Returns advice on how to avoid the jump with which a motion begins. */
static const char *instead(const sd_motion *q) {
  if (motion_is_wave(q)) return "take a phase at which it begins at 0 (0 or pi), or give it a ramp";
  if (motion_source(q) == SIGNAL_TABLE) return "let its values begin at 0, or give it a ramp";
  return "give it a ramp";
}

char *advice_first_jump(const sd_model *m) {
  char name[96];
  for (size_t k = 0; k < m->n_motions; k++) {
    const double jump = strides_first_jump(m, k);
    if (jump > LEAST_JUMP)
      return format_text(
          "%s begins with a jump by %s%.3g radii of the smallest disk, which throws what is "
          "there, whatever dt: %s",
          model_motion_name(m, k, name, sizeof name),
          motion_source(&m->motions[k]) == SIGNAL_RANDOM ? "up to " : "", jump,
          instead(&m->motions[k]));
  }
  return NULL;
}

static double check_jump(const sd_model *m, sd_messages *messages) {
  char *text = advice_first_jump(m);
  if (!text) return 0;
  sd_warn(messages, "%s", text);
  free(text);
  return 1;
}

/* Warns about a periodic motion with fewer than FEWEST_STEPS time steps per cycle. */
static double check_cycles(const sd_model *m, sd_messages *messages) {
  char name[96];
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    const double steps =
        motion_is_wave(q) && q->amplitude != 0 ? motion_period(q) / m->dt : HUGE_VAL;
    if (!(steps < FEWEST_STEPS)) continue;
    sd_warn(messages, "%s: a cycle takes %.3g steps, fewer than %g: take dt = %.2g or less",
            model_motion_name(m, k, name, sizeof name), steps, FEWEST_STEPS,
            m->dt * steps / FEWEST_STEPS / 2);
    return FEWEST_STEPS / steps;
  }
  return 0;
}

double advice_motions(const sd_model *m, sd_messages *messages) {
  const double far = check_stride(m, messages), jump = check_jump(m, messages),
               cycle = check_cycles(m, messages);
  return math_max(far, math_max(jump, cycle));
}

/* --- warnings about set-ups with fields that are seldom intended ------------------------------ */

/* Limits of a warning about dt: f dt/m of drag with the coefficient f, and the angle in rad by
 * which a rotating frame turns in one step. */
static const double COARSE_DRAG = 0.2, COARSE_TURN = 0.05;

/* Adds the warning `text` about force field k, frees the text, and returns the severity `how`. */
static double warn_of_field(const sd_model *m, size_t k, sd_messages *messages, double how,
                            char *text) {
  const char *name = m->fields[k].name;
  if (name && *name)
    sd_warn(messages, "fields.%s: %s", name, text);
  else
    sd_warn(messages, "fields[%zu]: %s", k, text);
  free(text);
  return how;
}

static double check_drag(const sd_model *m, sd_messages *messages) {
  char name[96];
  uint32_t disk = 0;
  const double rate = body_forces_drag_rate(m, &disk), coarse = rate * m->dt / COARSE_DRAG;
  if (!(coarse > 1)) return 0;
  sd_warn(messages,
          "fields: drag stops %s within %.2g time steps (f dt/m or f_r dt/I = %.3g): how it stops "
          "is not "
          "resolved; take dt = %.2g "
          "or less",
          sd_model_body_name(m, disk, name, sizeof name), 1 / (rate * m->dt), rate * m->dt,
          COARSE_DRAG / rate / 2);
  return coarse;
}

/* True if any phase of the run shears the periodic box, so that periodic images move with the
 * fluid. */
static bool shears(const sd_model *m) {
  bool any = false;
  for (size_t k = 0; k < m->n_phases; k++)
    any |= m->phases[k].cell.asked &&
           (m->phases[k].cell.rate[SD_CELL_XY] != 0 || m->phases[k].cell.controlled[SD_CELL_XY]);
  return any;
}

/* Warns about a force that depends on position along a periodic direction: the force jumps when
 * a disk crosses the edge of the box. */
static double check_periodic(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  const bool x = m->periodic[SD_X], y = m->periodic[SD_Y];
  const bool by_place = f->kind == SD_FIELD_CENTRAL || f->kind == SD_FIELD_ROTATION ||
                        (f->kind == SD_FIELD_DRAG && f->swirl != 0);
  const bool sheared = f->kind == SD_FIELD_DRAG && f->shear_rate != 0 && y && !shears(m);
  if (!(by_place && (x || y)) && !sheared) return 0;
  return warn_of_field(m, k, messages, 1,
                       format_text("the force depends on place along %s, where the box repeats: it "
                                   "jumps when a disk passes the edge",
                                   x && y && by_place ? "x and y"
                                   : x && by_place    ? "x"
                                                      : "y"));
}

/* Warns about damping, or drag of a fluid without shear, in a sheared box: both act on
 * velocities in the laboratory, not relative to the flow. */
static double check_sheared(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  for (size_t p = 0; p < m->n_phases; p++) {
    const sd_cell *c = &m->phases[p].cell;
    const bool sheared = c->asked && (c->rate[SD_CELL_XY] != 0 || c->controlled[SD_CELL_XY]);
    if (!sheared || !body_force_is_on(m, k, (int64_t)p)) continue;
    if (f->kind == SD_FIELD_DAMPING)
      return warn_of_field(
          m, k, messages, 1,
          format_text("damping acts against velocities in the laboratory, while the box "
                      "shears: what moves with the flow is damped too"));
    if (f->kind == SD_FIELD_DRAG && f->shear_rate == 0)
      return warn_of_field(
          m, k, messages, 1,
          format_text("the fluid does not shear while the box does: it stops what moves with "
                      "the flow; give shear_rate, that of the box"));
  }
  return 0;
}

/* Warns about a rotating frame that turns far in one time step, or that is combined with
 * gravity. */
static double check_frame(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  if (f->kind != SD_FIELD_ROTATION || f->omega == 0) return 0;
  const double turn = fabs(f->omega) * m->dt;
  double worst = 0;
  if (turn > COARSE_TURN)
    worst = warn_of_field(
        m, k, messages, turn / COARSE_TURN,
        format_text("the frame turns by %.3g rad in a time step; take dt = %.2g or less", turn,
                    COARSE_TURN / fabs(f->omega) / 2));
  if (m->gravity[SD_X] == 0 && m->gravity[SD_Y] == 0) return worst;
  warn_of_field(m, k, messages, 1,
                format_text("gravity turns with the frame: it has a fixed direction in it"));
  return math_max(worst, 1);
}

/* Warns about a force field that no phase of the run switches on. */
static double check_off(const sd_model *m, size_t k, sd_messages *messages) {
  for (int64_t p = 0; p < (int64_t)m->n_phases; p++)
    if (body_force_is_on(m, k, p)) return 0;
  return warn_of_field(m, k, messages, 1,
                       format_text("it is on in no phase: no list `fields` of a phase names it"));
}

/* --- disks that fall without end -------------------------------------------------------------- */

/* True if the force field can keep disks from gaining speed without limit: drag, or a central
 * force. */
static bool field_holds(const sd_body_force *f) {
  return (f->kind == SD_FIELD_DRAG && f->gamma > 0) ||
         (f->kind == SD_FIELD_CENTRAL && f->strength != 0);
}

/* True if a wall can keep disks from falling along the axis: it is not straight along the axis,
 * or its contacts have friction. */
static bool wall_holds(const sd_model *m, const sd_wall *w, int axis) {
  bool along = w->kind != SD_WALL_CIRCLE && w->kind != SD_WALL_ARC, rubs = false;
  const double *first = along ? w->points[0] : NULL;
  for (size_t k = 1; along && k < w->n_points; k++)
    along =
        fabs(w->points[k][!axis] - first[!axis]) <= 1e-9 * fabs(w->points[k][axis] - first[axis]);
  for (size_t b = 0; b < m->n_materials; b++) {
    const sd_contact_law *law = sd_model_law(m, w->material, (int)b);
    rubs = rubs || (law_is_given(law) && law->mu > 0 && (law->k_t > 0 || law->gamma_t > 0));
  }
  return !along || rubs;
}

/* True if a prescribed or locked body, a wall, a field or a motion can keep the disks from
 * falling along the axis. */
static bool is_held(const sd_model *m, int axis) {
  bool holds = m->n_free < m->n_disks;
  for (size_t i = 0; i < model_held(m) && !holds; i++) holds = m->disks[i].locked[axis];
  for (size_t k = 0; k < m->n_clumps && !holds; k++) holds = m->clumps[k].locked[axis];
  for (size_t w = 0; w < m->n_walls && !holds; w++) holds = wall_holds(m, &m->walls[w], axis);
  for (size_t k = 0; k < m->n_fields && !holds; k++) holds = field_holds(&m->fields[k]);
  for (size_t k = 0; k < m->n_motions && !holds; k++)
    holds = m->motions[k].coordinate == axis && m->motions[k].bodies[0] < m->n_disks;
  return holds;
}

/* Collective. |sum of the external forces along the axis on all free disks| divided by the sum
 * of their absolute values; the ratio lies within [0, 1]. */
static double pull_of(const sd_model *m, int axis) {
  double sum = 0, parts = 0;
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (d->driven) continue;
    sum += d->mass * m->gravity[axis] + d->force[axis];
    parts += fabs(d->mass * m->gravity[axis]) + fabs(d->force[axis]);
  }
  sum = rows_sum(m, sum);
  parts = rows_sum(m, parts);
  return parts > 0 ? fabs(sum) / parts : 0;
}

/* Warns about disks that fall without end along a periodic direction. */
static double check_falls(const sd_model *m, sd_messages *messages) {
  const double g = math_hypot(m->gravity[SD_X], m->gravity[SD_Y]);
  double found = 0;
  for (int axis = SD_X; axis <= SD_Y; axis++) {
    const bool rounding = fabs(m->gravity[axis]) < 1e-12 * g;
    if (!m->periodic[axis] || m->n_free == 0 || is_held(m, axis) || !(pull_of(m, axis) > 1e-9))
      continue;
    const bool forces = m->gravity[axis] == 0 || rounding;
    bool any = !forces;
    for (size_t i = 0; i < model_held(m) && !any; i++) any = m->disks[i].force[axis] != 0;
    if (!any) continue;
    sd_warn(messages,
            "%s: the box repeats along %c, and nothing there holds the disks: they fall for ever, "
            "faster and "
            "faster; expected a wall or a fixed disk in the way, a wall with friction, or drag",
            forces ? "force" : "gravity", axis == SD_X ? 'x' : 'y');
    found = 1;
  }
  return found;
}

double advice_fields(const sd_model *m, sd_messages *messages) {
  double worst = math_max(m->n_fields ? check_drag(m, messages) : 0, check_falls(m, messages));
  for (size_t k = 0; k < m->n_fields; k++) {
    worst = math_max(worst, check_periodic(m, k, messages));
    worst = math_max(worst, check_sheared(m, k, messages));
    worst = math_max(worst, check_frame(m, k, messages));
    worst = math_max(worst, check_off(m, k, messages));
  }
  return worst;
}
