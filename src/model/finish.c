/* finish.c: checks a model and derives its tables; see slipdisk/model.h. */

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/advice.h"
#include "model/cell.h"
#include "model/clumps.h"
#include "model/field_kinds.h"
#include "model/keys.h"
#include "model/laws.h"
#include "model/model.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/rows.h"
#include "model/walls.h"

/* --- checks ----------------------------------------------------------------------------------- */

/* Reports errors of the run's parameters, and empty lists of disks, phases or materials. */
static void check_run(const sd_model *m, sd_messages *msg) {
  deck_key_check(&deck_top, m, "", msg);
  deck_key_check(&deck_limits, &m->limits, "limits", msg);
  if (m->n_disks == 0) fail_about(msg, about_path("disks"), "expected at least one disk");
  if (m->n_phases == 0)
    fail_about(msg, about_path("phases"), "expected a duration, `steps` or `time`");
  if (m->n_materials == 0)
    fail_about(msg, about_path("materials"), "expected at least one material");
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].steps < 1)
      fail_about(msg, about_path("phases[%zu]", k), "expected at least one step");
}

/* Reports an error if the parameter `key` of a body is below `least` (or equal to it, if `open`
 * is true), not finite, or beyond LIMIT_NUMBER. */
static void check_number(const sd_model *m, uint32_t body, const char *key, double value,
                         double least, bool open, sd_messages *msg) {
  const bool large = value >= least && !(value <= LIMIT_NUMBER),
             good = open ? value > least : value >= least;
  if (good && !large) return;
  if (large || least < 0.0)
    fail_about(msg, about_body(m, body), "%s = %g: expected a number of at most 1e100", key, value);
  else
    fail_about(msg, about_body(m, body), "%s = %g: expected a number %s 0", key, value,
               open ? ">" : ">=");
}

static void check_disks(const sd_model *m, sd_messages *msg) {
  static const char *const keys[3][3] = {
      {"x", "y", "theta"}, {"vx", "vy", "omega"}, {"force x", "force y", "torque"}};
  for (size_t row = 0; row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    const uint32_t i = rows_number(m, row);
    const double *const numbers[3] = {d->position, d->velocity, d->force};
    for (int c = 0; c < 3; c++) {
      for (int k = 0; k < 3; k++)
        check_number(m, i, keys[k][c], numbers[k][c], -LIMIT_NUMBER, false, msg);
      if (d->locked[c] && d->velocity[c] != 0.0)
        fail_about(msg, about_body(m, i), "a locked coordinate cannot have a velocity");
    }
    check_number(m, i, "radius", d->radius, 0.0, true, msg);
    check_number(m, i, "mass", d->mass, 0.0, true, msg);
    check_number(m, i, "inertia", d->inertia, 0.0, false, msg);
    if (d->material < 0 || (size_t)d->material >= m->n_materials)
      fail_about(msg, about_body(m, i), "material %d: expected one of the %zu that there are",
                 d->material, m->n_materials);
  }
}

/* True if |x| <= LIMIT_NUMBER; false for infinity and NaN. */
static bool has_size(double x) { return fabs(x) <= LIMIT_NUMBER; }

static bool wall_is_finite(const sd_wall *w) {
  bool good = has_size(w->pivot[0]) && has_size(w->pivot[1]) && has_size(w->radius) &&
              has_size(w->center[0]) && has_size(w->center[1]) && has_size(w->from) &&
              has_size(w->to);
  for (size_t k = 0; k < w->n_points; k++)
    good = good && has_size(w->points[k][0]) && has_size(w->points[k][1]);
  return good;
}

static void check_walls(const sd_model *m, sd_messages *msg) {
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->material < 0 || (size_t)wall->material >= m->n_materials)
      fail_about(msg, about_wall(m, w), "material: no such material");
    if ((unsigned)wall->kind >= SD_WALL_KINDS)
      fail_about(msg, about_wall(m, w), "kind %d: expected SD_WALL_LINE ...", (int)wall->kind);
    if (!wall_is_finite(wall))
      fail_about(msg, about_wall(m, w), "points, pivot and radius must be finite, at most 1e100");
    const bool arc = wall->kind == SD_WALL_ARC;
    if ((arc || wall->kind == SD_WALL_CIRCLE) && !(wall->radius > 0.0))
      fail_about(msg, about_wall(m, w), "radius = %g: expected a number > 0", wall->radius);
    if (arc && !(wall->to > wall->from && wall->to - wall->from <= ARC_RING))
      fail_about(msg, about_wall(m, w),
                 "from = %g, to = %g: expected from < to, at most a whole turn apart", wall->from,
                 wall->to);
    if (arc || wall->kind == SD_WALL_CIRCLE) continue;
    if (wall->n_points < 2 || (wall->kind != SD_WALL_POLYLINE && wall->n_points != 2)) {
      fail_about(msg, about_wall(m, w), "%zu points: expected %s", wall->n_points,
                 wall->kind == SD_WALL_POLYLINE ? "two or more" : "two");
      continue;
    }
    for (size_t k = 0; k < wall->n_points - (wall->closed ? 0 : 1); k++) {
      size_t next = (k + 1) % wall->n_points;
      if (wall->points[k][0] == wall->points[next][0] &&
          wall->points[k][1] == wall->points[next][1])
        fail_about(msg, about_wall(m, w), "points %zu and %zu coincide", k, next);
    }
  }
}

/* True for a round wall with rolling resistance. Its surface cannot be moved by
 * itself, since rolling is computed from the wall's angle and not from the displacement of its
 * surface. */
static bool rolls_on_surface(const sd_model *m, size_t body) {
  const sd_wall *wall = &m->walls[body - m->n_disks];
  bool rolls = false;
  for (size_t k = 0; k < m->n_materials && wall->kind == SD_WALL_CIRCLE; k++) {
    const sd_contact_law *law = sd_model_law(m, wall->material, (int)k);
    rolls = rolls || (law && law_features(law) & LAW_ROLLING);
  }
  return rolls;
}

static void check_motions(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (q->n_bodies == 0) fail_about(msg, about_motion(m, k), "it moves no disk and no wall");
    for (size_t b = 0; b < q->n_bodies; b++)
      if (q->bodies[b] >= model_movables(m))
        fail_about(msg, about_motion(m, k), "body %u does not exist", q->bodies[b]);
      else if (q->coordinate == SD_SURFACE &&
               (q->bodies[b] < m->n_disks || q->bodies[b] >= m->n_disks + m->n_walls))
        fail_about(msg, about_motion(m, k),
                   "only walls have a surface that moves; others turn (theta)");
      else if (q->coordinate == SD_SURFACE && rolls_on_surface(m, q->bodies[b]))
        fail_about(msg, about_motion(m, k),
                   "the surface of a round wall with rolling resistance (k_r); turn the wall "
                   "(theta) instead");
    if (!has_size(q->amplitude) || !has_size(q->omega) || !has_size(q->phase) ||
        !has_size(q->velocity))
      fail_about(msg, about_motion(m, k),
                 "amplitude, omega, phase and velocity must be finite, at most 1e100");
    if (!(q->ramp >= 0.0)) fail_about(msg, about_motion(m, k), "ramp = %g: expected >= 0", q->ramp);
    motion_check(m, k, msg);
  }
}

static const char *material_name(const sd_model *m, size_t k) {
  return m->materials[k].name ? m->materials[k].name : "?";
}

/* Reports errors of the contact law of materials a and b, if the law is given. */
static void check_law(const sd_model *m, size_t a, size_t b, sd_messages *msg) {
  const sd_contact_law *law = sd_model_law(m, (int)a, (int)b);
  const char *key = NULL;
  if (!law_is_given(law)) return;
  deck_key_check(&law_table, law, material_name(m, a), msg);
  double value = 0.0;
  char *text = law_mistake(law, &key, &value);
  if (text)
    fail_about(msg, about_value(about_path("%s.%s", material_name(m, a), key), "%g", value), "%s",
               text);
  free(text);
}

/* Collective. Reports pairs of materials that can touch and have no law, and laws with errors. */
static sd_status check_laws(const sd_model *m, sd_messages *msg) {
  law_use *use = memory_new(m->n_materials, sizeof *use);
  size_t before = sd_messages_errors(msg);
  laws_count_uses(m, use);
  for (size_t a = 0, b = 0; laws_find_missing(m, use, &a, &b); b++)
    sd_fail(msg, SD_ERROR_USER,
            "materials \"%s\" and \"%s\" can touch, but their contact constants are not given",
            material_name(m, a), material_name(m, b));
  for (size_t a = 0; a < m->n_materials; a++)
    for (size_t b = a; b < m->n_materials; b++) check_law(m, a, b, msg);
  free(use);
  return sd_messages_errors(msg) > before ? SD_ERROR_USER : SD_OK;
}

/* Reports phases that hold or release disks that do not exist or belong to a clump or a rain. */
static void check_holds(const sd_model *m, sd_messages *msg) {
  char name[96];
  for (size_t k = 0; k < m->n_phases; k++)
    for (size_t n = 0; n < m->phases[k].n_hold + m->phases[k].n_release; n++) {
      const sd_phase *p = &m->phases[k];
      const bool hold = n < p->n_hold;
      const uint32_t i = hold ? p->hold[n] : p->release[n - p->n_hold];
      const sd_disk *d = i < model_held(m) ? &m->disks[i] : NULL;
      if (!d || d->clump > 0 || d->waiting)
        fail_about(msg, about_path("phases[%zu].%s", k, hold ? "hold" : "release"), "%s %s",
                   d ? sd_model_body_name(m, i, name, sizeof name) : "a disk that does not exist",
                   !d             ? "cannot be held"
                   : d->clump > 0 ? "belongs to a clump; expected a disk that moves by itself"
                                  : "waits for rain");
    }
}

/* Reports phases that bond bodies that do not exist, or one with itself. */
static void check_bonds(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_bonding *b = &m->phases[k].bond;
    bool exist = b->n_between == 0 || b->between[b->n_between - 1] < sd_model_bodies(m);
    bool itself = false;
    for (size_t n = 0; n < b->n_pairs; n++) {
      exist = exist && b->pairs[n][1] < sd_model_bodies(m);
      itself = itself || b->pairs[n][0] == b->pairs[n][1];
    }
    if (!exist || itself)
      fail_about(msg, about_path("phases[%zu].bond", k), "%s",
                 exist ? "a bond of a body with itself" : "a body that does not exist");
  }
}

/* Reports contacts restored from a file whose body numbers do not exist. */
static void check_memories(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_memories; k++) {
    const sd_contact_memory *c = &m->memories[k];
    if (c->a >= m->n_disks || c->b >= sd_model_bodies(m) || c->a == c->b)
      fail_about(msg, about_path("memories[%zu]", k),
                 "expected a disk, and another disk or a wall");
  }
}

/* Reports measurements that name disks or contacts which do not exist. */
static void check_watches(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_rotations; k++)
    if (m->rotations[k] >= m->n_disks)
      fail_about(msg, about_path("measure.rotation"), "disk %u does not exist", m->rotations[k]);
  for (size_t k = 0; k < m->n_contact_disks; k++)
    if (m->contact_disks[k] >= m->n_disks)
      fail_about(msg, about_path("measure.contacts"), "disk %u does not exist",
                 m->contact_disks[k]);
  for (size_t k = 0; k < m->n_slides; k++) {
    const sd_slide_watch *s = &m->slides[k];
    if (s->disk >= m->n_disks || s->partner[0] >= sd_model_bodies(m) ||
        s->partner[1] >= sd_model_bodies(m))
      fail_about(msg, about_path("measure.sliding[%zu]", k), "no such disk or wall");
    else if (m->disks[s->disk].driven)
      fail_about(msg, about_path("measure.sliding[%zu]", k),
                 "the disk is prescribed; name a free one");
  }
}

/* Reports errors in the goal `until`: the last phase ends when an error bar has fallen to this
 * goal. */
static void check_until(const sd_model *m, sd_messages *msg) {
  const sd_until *u = &m->until;
  if (!u->asked || m->n_phases == 0) return;
  const sd_phase *last = &m->phases[m->n_phases - 1];
  if (u->rotation >= m->n_rotations)
    fail_about(msg, about_path("until.observable"),
               "expected a disk that measure.rotation watches");
  if (!(u->error >= 0.0) || !(u->relative >= 0.0) || (u->error > 0.0) == (u->relative > 0.0))
    fail_about(msg, about_path("until"), "expected either error > 0 or relative > 0");
  if (u->scaled && m->gravity[0] == 0.0 && m->gravity[1] == 0.0)
    fail_about(msg, about_path("until.observable"), "t_g Omega does not exist without gravity");
  if (!last->measure) fail_about(msg, about_path("until"), "expected a last phase that measures");
  if (u->least < 1 || u->least > last->steps)
    fail_about(msg, about_path("until"),
               "expected 1 to %lld steps at least, the length of the last phase",
               (long long)last->steps);
}

/* Collective. Reports a periodic box that is too short, and disks outside it. */
static void check_box(const sd_model *m, sd_messages *msg) {
  double reach;
  const double least = cell_least_length(m, &reach);
  for (int c = 0; c < 2; c++) {
    if (!m->periodic[c]) continue;
    double length = m->upper[c] - m->lower[c];
    char axis = c == SD_X ? 'x' : 'y';
    if (!(length > least) && reach > 0.0)
      fail_about(msg, about_path("box.%c", axis),
                 "length %g: expected more than %.6g, 4.8 times the largest radius and twice the "
                 "gap (%g) over which disks attract each other",
                 length, least, reach);
    else if (!(length > least))
      fail_about(msg, about_path("box.%c", axis),
                 "length %g: expected more than 4.8 times the largest radius (%g)", length,
                 least / 4.8);
    for (size_t row = 0; row < rows_count(m); row++) {
      double p = rows_disk(m, row)->position[c];
      if (p < m->lower[c] || p >= m->upper[c])
        fail_about(msg, about_body(m, rows_number(m, row)),
                   "%c = %g lies outside the periodic box [%g, %g)", axis, p, m->lower[c],
                   m->upper[c]);
    }
  }
}

/* Reports walls other than lines in a phase that compresses: their size would not change. */
static void check_compressed_walls(const sd_model *m, size_t phase, sd_messages *msg) {
  char name[96];
  for (uint32_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].kind != SD_WALL_LINE)
      fail_about(msg, about_path("phases[%zu].compress", phase),
                 "%s has a size of its own, which does not change; expected lines only",
                 sd_model_body_name(m, (uint32_t)m->n_disks + w, name, sizeof name));
}

/* Reports a load or servo that may have moved its wall before a phase that compresses: the
 * packing fraction would refer to the area of the original container. */
static void check_moved_walls(const sd_model *m, size_t phase, sd_messages *msg) {
  for (size_t q = 0; q < m->n_motions; q++) {
    const sd_motion *motion = &m->motions[q];
    bool moved = false;
    for (size_t k = 0; k < phase; k++) moved |= m->phases[k].active && m->phases[k].active[q];
    if (moved && motion_is_feedback(motion))
      fail_about(msg, about_motion(m, q),
                 "its wall may be anywhere when phases[%zu].compress begins, which expects walls "
                 "that only compression moves, or servo walls all the time",
                 phase);
  }
}

static void check_compress(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    const sd_compress *c = &p->compress;
    if (!c->asked) continue;
    if ((c->pressure > 0.0) == (c->fraction > 0.0))
      fail_about(msg, about_path("phases[%zu].compress", k),
                 "expected either pressure > 0 or fraction > 0");
    if (!(c->rate > 0.0) || !(c->rate * m->dt <= 1e-3))
      fail_about(msg, about_value(about_path("phases[%zu].compress.rate", k), "%g", c->rate),
                 "expected a number > 0 and at most %g, a thousandth per time step", 1e-3 / m->dt);
    if (!(m->region_upper[0] > m->region_lower[0] && m->region_upper[1] > m->region_lower[1]))
      fail_about(msg, about_path("phases[%zu].compress", k), "there is no region to compress");
    check_compressed_walls(m, k, msg);
    for (size_t q = 0; q < m->n_motions; q++)
      if (p->active && p->active[q] && m->motions[q].coordinate < SD_THETA)
        fail_about(msg, about_motion(m, q),
                   "it prescribes positions that phases[%zu].compress changes; expected a phase in "
                   "which it is off",
                   k);
    check_moved_walls(m, k, msg);
  }
}

static void check_settle(const sd_model *m, sd_messages *msg) {
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_settle *s = &m->phases[k].settle;
    if (s->asked && (s->every < 1 || !(s->kinetic > 0.0 || s->unbalanced > 0.0)))
      fail_about(msg, about_path("phases[%zu].settle", k),
                 "expected kinetic > 0 or unbalanced > 0, and every >= 1");
  }
}

static void check_bounds(const sd_model *m, sd_messages *msg) {
  for (int c = 0; m->bounds.given && c < 2; c++)
    if (!(m->bounds.lower[c] < m->bounds.upper[c]))
      fail_about(msg, about_path("bounds.%c", c == SD_X ? 'x' : 'y'),
                 "expected (lower, upper) with lower < upper");
}

/* Reports round walls that do not fit into the periodic box, since a disk could touch two images
 * of them, and disks that do not fit into a round container. */
static void check_round_walls(const sd_model *m, sd_messages *msg) {
  char disk[96];
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind != SD_WALL_CIRCLE) continue;
    double reach = wall->inside ? wall->radius : wall->radius + m->largest_radius;
    for (int c = 0; c < 2; c++)
      if (m->periodic[c] && !(m->upper[c] - m->lower[c] > 2.0 * reach))
        fail_about(msg, about_wall(m, w),
                   "radius = %g: the periodic box must be wider than %g to hold it", wall->radius,
                   2.0 * reach);
    for (size_t row = 0; wall->inside && row < rows_count(m); row++) {
      const sd_disk *d = rows_disk(m, row);
      if (!d->driven && d->radius >= wall->radius)
        fail_about(msg, about_wall(m, w), "radius = %g: %s, of radius %g, does not fit into it",
                   wall->radius, sd_model_body_name(m, rows_number(m, row), disk, sizeof disk),
                   d->radius);
    }
  }
}

/* Largest rounding error of a coordinate divided by the smallest radius; beyond it, contacts are
 * meaningless. */
static const double COARSE = 0.01;

/* Largest absolute coordinate of a wall. */
static double farthest_of(const sd_wall *w) {
  double far = math_max(fabs(w->pivot[0]), fabs(w->pivot[1]));
  if (w->kind == SD_WALL_ARC) far = math_max(far, math_max(fabs(w->center[0]), fabs(w->center[1])));
  for (size_t k = 0; k < w->n_points; k++)
    far = math_max(far, math_max(fabs(w->points[k][0]), fabs(w->points[k][1])));
  return far;
}

/* Reports an error if a coordinate as large as `far` has a rounding error that is too large for
 * the smallest disk; returns true if it did. */
static bool tell_rounding(const sd_model *m, size_t body, double far, sd_messages *msg) {
  const double rounding = DBL_EPSILON * far;
  if (!(rounding > COARSE * m->smallest_radius)) return false;
  fail_about(msg, about_body(m, body),
             "a coordinate of %.3g is rounded by %.2g, and the smallest disk has a radius of %g: "
             "expected at most %.3g",
             far, rounding, m->smallest_radius, COARSE * m->smallest_radius / DBL_EPSILON);
  return true;
}

static void check_rounding(const sd_model *m, sd_messages *msg) {
  for (size_t row = 0; row < rows_count(m); row++) {
    const double *at = rows_disk(m, row)->position;
    if (tell_rounding(m, rows_number(m, row), math_max(fabs(at[0]), fabs(at[1])), msg)) return;
  }
  for (size_t w = 0; w < m->n_walls; w++)
    if (tell_rounding(m, m->n_disks + w, farthest_of(&m->walls[w]), msg)) return;
}

/* Reports an error if a disk that rain k shall release is not free, does not wait for its
 * release, or is wider than the rain. */
static void check_raining(const sd_model *m, size_t k, size_t row, sd_messages *msg) {
  const sd_rain *r = &m->rains[k];
  const sd_disk *d = rows_disk(m, row);
  const uint32_t i = rows_number(m, row);
  const double radius =
      i < model_held(m) ? clumps_grain(m, i, r->first + r->count).radius : d->radius;
  if (!d->waiting || d->driven)
    fail_about(msg, about_body(m, i), "expected a free disk that waits for rains[%zu]", k);
  if (!(2.0 * radius <= r->upper - r->lower))
    fail_about(msg, about_body(m, i), "radius = %g: it does not fit into rain %g wide", d->radius,
               r->upper - r->lower);
}

/* Collective. Reports errors in the rains, which release disks in batches, and in their disks. */
static void check_rains(const sd_model *m, sd_messages *msg) {
  char name[96];
  const size_t held = model_held(m), n = rows_count(m);
  /* number of disks that wait for their release, number of disks that belong to a rain */
  int64_t counts[2] = {0};
  for (size_t row = rows_first(m); row < n; row++) counts[0] += rows_disk(m, row)->waiting;
  for (size_t k = 0; k < m->n_rains; k++) {
    const sd_rain *r = &m->rains[k];
    const size_t end = r->first + r->count;
    if (r->count < 1 || end > m->n_disks || r->batch < 1 || r->interval < 1)
      fail_about(msg, about_path("rains[%zu]", k),
                 "expected disks that exist, a batch and an interval >= 1");
    if (!(r->gap >= 0.0) || !isfinite(r->gap) || !isfinite(r->speed) || !isfinite(r->floor))
      fail_about(msg, about_path("rains[%zu]", k), "expected a gap >= 0, and a speed and a floor");
    for (size_t row = r->first < held ? r->first : held; row < n; row++) {
      const uint32_t i = rows_number(m, row);
      /* continue with the disks that are stored on this rank only */
      if (i >= end && row < held) row = held - 1;
      if (i < r->first || i >= end) continue;
      counts[1] += row >= rows_first(m);
      check_raining(m, k, row, msg);
    }
  }
  comm_add(m->comm, counts, 2);
  if (counts[0] != counts[1])
    sd_fail(msg, SD_ERROR_USER,
            "%lld disks wait, %lld belong to rain: expected each to belong to one",
            (long long)counts[0], (long long)counts[1]);
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      uint32_t body = m->motions[k].bodies[b];
      if (body < held && m->disks[body].waiting)
        fail_about(msg, about_motion(m, k), "%s waits for rain, which says where it begins",
                   sd_model_body_name(m, body, name, sizeof name));
    }
}

/* Reports a time step beyond the stability limit. If the model comes from an input deck, deck.c
 * reports it instead, with the line. */
static void check_step(const sd_model *m, sd_messages *msg) {
  char *text = advice_unstable(m);
  if (text) fail_about(msg, about_value(about_path("dt"), "%g", m->dt), "%s", text);
  free(text);
}

/* --- derived tables --------------------------------------------------------------------------- */

/* Sets moments of inertia that were not given (0) to m R^2/2. */
static void complete_disks(sd_model *m) {
  const size_t held = model_held(m);
  for (size_t row = 0; row < rows_count(m); row++) {
    sd_disk *d = row < held ? &m->disks[row] : &m->mine->disk[row - held];
    if (d->inertia == 0.0) d->inertia = 0.5 * d->mass * d->radius * d->radius;
  }
}

/* Collective. Computes the mean, largest and smallest radius of the model's disks, the number of
 * restored contacts on all ranks, and default intervals of motions. */
static void derive_numbers(sd_model *m) {
  double inverse = 0.0, largest = 0.0, smallest = HUGE_VAL;
  for (size_t k = 0; k < m->n_motions; k++)
    if (m->motions[k].interval < 1) m->motions[k].interval = 1;
  complete_disks(m);
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    inverse += 1.0 / d->radius;
    if (d->driven) continue;
    largest = math_max(largest, d->radius);
    smallest = math_min(smallest, d->radius);
  }
  m->mean_radius = (double)m->n_disks / rows_sum(m, inverse);
  m->largest_radius = rows_largest(m, largest);
  m->smallest_radius = rows_least(m, smallest);
  int64_t contacts[1] = {m->mine ? (int64_t)m->mine->n_contacts : 0};
  comm_add(m->comm, contacts, 1);
  m->all_memories = m->n_memories + (size_t)contacts[0];
}

/* Computes shortest_period, the shortest contact period, if any motion is a servo; else sets it
 * to 0. */
void model_derive_period(sd_model *m) {
  bool servo = false;
  for (size_t k = 0; k < m->n_motions; k++) servo |= m->motions[k].kind == SD_MOTION_SERVO;
  m->shortest_period = servo ? sd_model_shortest_period(m, NULL) : 0.0;
}

/* Checks all input from which tables are derived. */
static void check_all(const sd_model *m, sd_messages *msg) {
  check_run(m, msg);
  check_disks(m, msg);
  check_walls(m, msg);
  check_motions(m, msg);
  loads_check(m, msg);
  body_forces_check(m, msg);
  check_box(m, msg);
  check_compress(m, msg);
  cell_check(m, msg);
  check_rains(m, msg);
  check_settle(m, msg);
  check_holds(m, msg);
  check_bonds(m, msg);
  check_bounds(m, msg);
  check_memories(m, msg);
  check_watches(m, msg);
  check_until(m, msg);
}

/* Collective. Returns the same status on all ranks: SD_ERROR_USER if any rank now has more
 * errors than the number `before`, since each rank checks its own disks. */
static sd_status found(const sd_model *m, sd_status status, const sd_messages *msg, size_t before) {
  if (status == SD_OK && sd_messages_errors(msg) > before) status = SD_ERROR_USER;
  return comm_agree(m->comm, status);
}

/* Computes and checks the tables that are derived from a model's input. */
static sd_status derive(sd_model *m, sd_messages *msg) {
  const size_t before = sd_messages_errors(msg);
  sd_status status = comm_agree(m->comm, model_find_driven(m));
  if (status != SD_OK) return sd_fail(msg, SD_ERROR_IO, "out of memory for the model's tables");
  model_find_pieces(m);
  derive_numbers(m);
  check_rounding(m, msg);
  status = comm_agree(m->comm, clumps_derive(m, msg));
  if (status == SD_OK) status = comm_agree(m->comm, check_laws(m, msg));
  if (status != SD_OK) return status;
  check_round_walls(m, msg);
  loads_check_steps(m, msg);
  model_derive_period(m);
  if (!m->deck) check_step(m, msg);
  return found(m, SD_OK, msg, before);
}

sd_status sd_model_finish(sd_model *m, sd_messages *msg) {
  size_t before = sd_messages_errors(msg);
  sd_messages *own = msg ? msg : sd_messages_new();
  model_complete(m);
  sd_status status = model_tell_mistakes(m, own);
  if (status != SD_ERROR_IO) {
    check_all(m, own);
    status = found(m, SD_OK, own, before);
    if (status == SD_OK) wall_images_check(m, own);
    status = found(m, status, own, before);
    if (status == SD_OK) status = derive(m, own);
  }
  if (own != msg) sd_messages_free(own);
  m->finished = status == SD_OK;
  return status;
}

sd_status model_finish_again(sd_model *m, sd_messages *msg) {
  return sd_model_finish(m, NULL) == SD_OK ? SD_OK : sd_model_finish(m, msg);
}

sd_status model_check_constants(sd_model *m, const sd_contact_law *before, sd_messages *msg) {
  const size_t errors = sd_messages_errors(msg), n = m->n_materials * m->n_materials;
  check_motions(m, msg);
  loads_check(m, msg);
  loads_check_steps(m, msg);
  sd_status status = found(m, check_laws(m, msg), msg, errors);
  bool stiff = false;
  for (size_t k = 0; k < n; k++) stiff |= !law_is_as_stiff(&m->laws[k], &before[k]);
  if (status != SD_OK || !stiff) return status;
  check_step(m, msg);
  return found(m, status, msg, errors);
}

sd_status model_part(sd_model *m, size_t few) {
  assert(m->finished);
  m->limit = sd_model_step_limit(m);
  m->advised = sd_messages_new();
  sd_model_advise(m, m->advised);
  return rows_part(m, few) ? SD_OK : SD_ERROR_IO;
}
