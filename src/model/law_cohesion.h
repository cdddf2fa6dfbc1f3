/* law_cohesion.h: attraction A(delta) of closed contacts, besides the normal law; at a gap, delta is negative.
 *
 *   constant  A = pull_off while disks overlap, falling to 0 at gap `range`: the contact begins and ends there
 *   bridge    A = pull_off exp(-gap/range) from touch until gap `rupture`: of the kind measured and computed for capillary bridges
 *             (Soulie, Cherblanc, El Youssoufi, Saix, Int. J. Numer. Anal. Meth. Geomech. 30, 213); forming it costs
 *             bridge_energy, which is lost, and is 0 where it breaks
 *
 * Both derive from an energy <= 0, 0 beyond the end. The number of a law stands in sd_cohesion_law; rows as in
 * normal_laws.h. The text over lanes comes once per LANE_WIDTH, after base/lane.h, and constants as in law_row.
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

typedef struct LANE(cohesion) {
  LANE(mask) bridge; /* else constant, or none with pull_off 0 */
  LANE(real) pull_off;
  LANE(real) range, per_range; /* per_range: its inverse, 0 where it is 0 */
  LANE(real) broken;           /* exp(-rupture/range) */
  LANE(real) begins, ends;     /* gaps at which a contact begins and ends */
} LANE(cohesion);

/* Part of pull_off that A has at a gap. any: there may be bridges. */
LANE_INLINE LANE(real)
    LANE(cohesion_part)(const LANE(cohesion) * c, LANE(real) delta, const int any) {
  const LANE(real) zero = LANE(splat)(0.0), gap = LANE(max)(-delta, zero) * c->per_range;
  LANE(real) part = LANE(max)(1.0 - gap, zero);
  return any ? LANE(select)(c->bridge, LANE(exponential)(-gap), part) : part;
}

LANE_INLINE LANE(real) LANE(cohesion_energy)(const LANE(cohesion) * c, LANE(real) delta) {
  const LANE(real) part = LANE(cohesion_part)(c, delta, 1);
  LANE(real) depth = LANE(max)(delta, LANE(splat)(0.0));
  LANE(real) beyond = LANE(select)(c->bridge, part - c->broken, 0.5 * part * part);
  return -(c->pull_off * (depth + c->range * beyond));
}

/* Lost where a bridge forms. */
LANE_INLINE LANE(real) LANE(bridge_energy)(const LANE(cohesion) * c) {
  return LANE(mask_zero)(c->bridge, c->pull_off * (c->range * (1.0 - c->broken)));
}

#endif
