/* lanes_suit.c: tells which systems can run in SIMD lanes, and which of them side by side; see
 * lanes.h. */
#include "physics/small/lanes.h"

#include <string.h>

#include "model/law_features.h"
#include "model/motions.h"
#include "model/walls.h"

/* --- which systems suit lanes ----------------------------------------------------------------- */

static size_t count_pairs(const sd_model *m) {
  size_t bodies = m->n_disks + m->n_walls;
  return m->n_free * (bodies - m->n_free) + m->n_free * (m->n_free - 1) / 2;
}

/* Returns true if all walls are round or straight; round ones must come first, as contacts do in
 * the lists of pairs. */
static bool suits_walls(const sd_model *m) {
  bool suits = true;
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    suits = suits && (wall_is_straight(wall) || wall->kind == SD_WALL_CIRCLE);
    if (w > 0) suits = suits && !(wall_is_straight(wall - 1) && wall->kind == SD_WALL_CIRCLE);
  }
  return suits;
}

/* Returns true if two walls meet at a joint: only the pass over segments handles joints. */
static bool walls_meet(const sd_model *m) {
  for (size_t k = 0; k < m->n_segments; k++)
    if (m->segments[k].meets[0] || m->segments[k].meets[1]) return true;
  return false;
}

static bool suits_motion(const sd_model *m, const sd_motion *motion) {
  if (motion_is_feedback(motion)) return false;
  for (size_t b = 0; b < motion->n_bodies; b++) {
    const uint32_t body = motion->bodies[b];
    if (body < m->n_disks
            ? !m->disks[body].driven
            : motion->coordinate == SD_THETA && wall_is_straight(&m->walls[body - m->n_disks]))
      return false;
  }
  return true;
}

/* Returns true if the watched disk is free and both of its contacts are with other bodies. */
static bool suits_watch(const sd_model *m, const sd_slide_watch *w) {
  return !m->disks[w->disk].driven && w->partner[0] != w->disk && w->partner[1] != w->disk;
}

bool lanes_suit(const sd_model *m) {
  if (m->n_free < 1 || m->n_free > LANES_FREE || m->n_disks + m->n_walls > LANES_BODIES ||
      count_pairs(m) < 1 || count_pairs(m) > LANES_PAIRS || m->n_slides > LANES_SLIDES ||
      !suits_walls(m) || m->periodic[0] || m->periodic[1] || m->measure_disks || m->n_rains > 0 ||
      m->n_fields > 0 || m->n_clumps > 0 || model_moves_surfaces(m) || walls_meet(m) ||
      strides_are_long(m) || (m->n_segments > 0 && laws_features(m) & LAW_GENERAL) ||
      (m->bounds.given && m->bounds.outside == SD_OUTSIDE_REMOVE))
    return false;
  bool suits = true;
  for (size_t k = 0; k < m->n_phases; k++)
    suits = suits && !m->phases[k].relax && !m->phases[k].compress.asked;
  for (size_t k = 0; k < m->n_motions; k++) suits = suits && suits_motion(m, &m->motions[k]);
  for (size_t k = 0; k < m->n_slides; k++) suits = suits && suits_watch(m, &m->slides[k]);
  return suits;
}

/* Empty arrays compare equal, whatever their pointers are. */
static bool same_bytes(const void *a, const void *b, size_t n) {
  return n == 0 || memcmp(a, b, n) == 0;
}

static bool same_motion(const sd_motion *a, const sd_motion *b) {
  return a->kind == b->kind && a->coordinate == b->coordinate && a->n_bodies == b->n_bodies &&
         a->interval == b->interval &&
         same_bytes(a->bodies, b->bodies, a->n_bodies * sizeof *a->bodies);
}

static bool same_phase(const sd_phase *a, const sd_phase *b, size_t n_motions) {
  return a->steps == b->steps && a->measure == b->measure && a->series_every == b->series_every &&
         a->frames_every == b->frames_every && a->contacts_every == b->contacts_every &&
         a->settle.asked == b->settle.asked && a->settle.every == b->settle.every &&
         same_bytes(a->active, b->active, n_motions * sizeof *a->active);
}

bool lanes_alike(const sd_model *a, const sd_model *b) {
  if (a->n_disks != b->n_disks || a->n_walls != b->n_walls || a->n_motions != b->n_motions ||
      a->n_phases != b->n_phases || a->n_rotations != b->n_rotations ||
      a->n_slides != b->n_slides || a->measure_configurations != b->measure_configurations ||
      a->integrator != b->integrator || a->variant != b->variant || !lanes_suit(a) ||
      !lanes_suit(b))
    return false;
  const unsigned features = laws_features(a), other = laws_features(b);
  if (features != other && (features | other) & LAW_GENERAL) return false;
  bool same = same_bytes(a->rotations, b->rotations, a->n_rotations * sizeof *a->rotations) &&
              same_bytes(a->slides, b->slides, a->n_slides * sizeof *a->slides);
  for (size_t k = 0; k < a->n_disks; k++) same = same && a->disks[k].driven == b->disks[k].driven;
  for (size_t k = 0; k < a->n_walls; k++)
    same = same && wall_is_straight(&a->walls[k]) == wall_is_straight(&b->walls[k]);
  for (size_t k = 0; k < a->n_motions; k++)
    same = same && same_motion(&a->motions[k], &b->motions[k]);
  for (size_t k = 0; k < a->n_phases; k++)
    same = same && same_phase(&a->phases[k], &b->phases[k], a->n_motions);
  return same;
}

bool lanes_in_step(const engine *a, const engine *b) {
  const sd_state *s = a->state, *t = b->state;
  bool same = s->phase == t->phase;
  for (size_t k = 0; k < s->n_motions; k++)
    same = same && (s->motion_start[k] < 0
                        ? t->motion_start[k] < 0
                        : t->motion_start[k] >= 0 &&
                              s->step - s->motion_start[k] == t->step - t->motion_start[k]);
  return same;
}
