/* law_cohesion.h: attraction A(delta) of closed contacts, which is subtracted from the normal
 * force; the overlap delta is negative where there is a gap.
 *
 *   constant  A = pull_off while disks overlap, falling linearly to 0 at gap `range`, where the
 *             contact begins and ends
 *   bridge    A = pull_off exp(-gap/range) from first touch until gap `rupture`: the form measured
 *             and computed for capillary bridges (Soulie, Cherblanc, El Youssoufi, Saix, Int. J.
 *             Numer. Anal. Meth. Geomech. 30, 213); forming a bridge dissipates bridge_energy,
 *             and the energy is 0 where it breaks
 *
 * Both attractions derive from a potential energy <= 0, which is 0 beyond the gap at which they
 * end. The enum sd_cohesion_law has the number of each law; rows of the table have the form of
 * those in normal_laws.h. The functions for SIMD lanes are compiled once per LANE_WIDTH, after
 * base/lane.h, with constants as in law_constants.h.
 */
#ifndef MODEL_LAW_COHESION_H
#define MODEL_LAW_COHESION_H

#define COHESION_LAWS(ROW)                                                                         \
  ROW(SD_COHESION_NONE, none, "", "no attraction")                                                 \
  ROW(SD_COHESION_CONSTANT, constant, "pull_off* range",                                           \
      "pull_off while touching, falling linearly to 0 at gap `range`; acts on approach, too")      \
  ROW(SD_COHESION_BRIDGE, bridge, "pull_off* range* rupture*",                                     \
      "pull_off exp(-gap/range) from the first touch until gap `rupture`")

#endif

#ifdef LANE_WIDTH
#include "base/vexp.h"

/* Constants of the attraction; each SIMD lane holds those of one contact. */
typedef struct LANE(cohesion) {
  LANE(mask) bridge; /* true: capillary bridge; false: constant, or none (pull_off 0) */
  LANE(real) pull_off;
  LANE(real) range, per_range; /* per_range: 1/range, or 0 if range is 0 */
  /* attraction where a bridge breaks, divided by pull_off: exp(-rupture/range) */
  LANE(real) broken;
} LANE(cohesion);

/* Attraction divided by pull_off at overlap delta (< 0: gap). any: 0 if no lane has a capillary
 * bridge. */
LANE_INLINE LANE(real)
    LANE(cohesion_part)(const LANE(cohesion) * c, LANE(real) delta, const int any) {
  const LANE(real) zero = LANE(splat)(0.0), gap = LANE(max)(-delta, zero) * c->per_range;
  LANE(real) part = LANE(max)(1.0 - gap, zero);
  return any ? LANE(select)(c->bridge, LANE(exponential)(-gap), part) : part;
}

/* Potential energy of the attraction at overlap delta, <= 0. */
LANE_INLINE LANE(real) LANE(cohesion_energy)(const LANE(cohesion) * c, LANE(real) delta) {
  const LANE(real) part = LANE(cohesion_part)(c, delta, 1);
  LANE(real) depth = LANE(max)(delta, LANE(splat)(0.0));
  LANE(real) beyond = LANE(select)(c->bridge, part - c->broken, 0.5 * part * part);
  return -(c->pull_off * (depth + c->range * beyond));
}

/* Energy dissipated when a capillary bridge forms; 0 for other attractions. */
LANE_INLINE LANE(real) LANE(bridge_energy)(const LANE(cohesion) * c) {
  return LANE(mask_zero)(c->bridge, c->pull_off * (c->range * (1.0 - c->broken)));
}

#endif
