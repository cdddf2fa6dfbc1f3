/* visits.h: torque, normal forces and duration of the visits to each sliding configuration of a watched pair of contacts.
 *
 * A visit is an unbroken run of measured steps in one of six classes. The sums of a step go to those of a part of the
 * visit, which are added to the sums of the class when the part ends: when the class changes, or the age of the visit
 * reaches the next octave. So a step costs a few additions, and short sums lose no digits.
 */
#ifndef MODEL_VISITS_H
#define MODEL_VISITS_H

#include <math.h>

#include "model/state.h"

/* S++, S+-, S-+ and S-- are 2 * (first contact) + (second contact); stick: one contact stuck, none open. */
enum { VISIT_STICK = 4, VISIT_OPEN = 5, VISIT_CLASSES = SD_CONFIGURATIONS, VISIT_NONE = -1 };
/* Sums of a part: torque, its square, and of each contact the normal force beyond the reference, its square. */
enum { VISIT_TORQUE, VISIT_TORQUE2, VISIT_FORCE, VISIT_FORCE2, VISIT_SUMS = VISIT_FORCE + 4 };
/* Ages: below VISIT_YOUNG steps, then octaves; the last has no end. */
enum { VISIT_YOUNG = 32, VISIT_AGES = SD_AGES };

static inline int visits_class(int first, int second) {
  int more = first > second ? first : second;
  return more >= SD_STUCK ? more + 2 : 2 * first + second;
}

/* Octave of an age >= 0 in steps. */
static inline int visits_octave(int64_t age) {
  int b = 63 - __builtin_clzll((unsigned long long)age | (VISIT_YOUNG / 2)) - 4;
  return b < VISIT_AGES - 1 ? b : VISIT_AGES - 1;
}
/* Measured steps from `now` until the part under way ends by age; HUGE_VAL: it does not. */
double visits_left(const sd_state *s, size_t k, int64_t now);
/* After `now` measured steps the part under way ends, and the next step is in this class. Its sums stand `stride` apart, and are
 * to be cleared. */
void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now);
/* Measuring pauses, or begins: the visit under way has no known duration. */
void visits_cut(sd_state *s, size_t k);

#endif
