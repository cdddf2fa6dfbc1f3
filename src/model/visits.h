/* visits.h: statistics of the visits of a watched pair of contacts to each of its sliding
 * configurations: torque, normal forces and duration.
 *
 * A visit is an unbroken run of measured steps in one of six classes. Each step adds to the sums
 * of the current part of the visit, which are added to the sums of the class when the part ends:
 * when the class changes, or when the age of the visit reaches the next octave. So a step costs
 * a few additions, and short sums lose no digits.
 */
#ifndef MODEL_VISITS_H
#define MODEL_VISITS_H

#include <math.h>

#include "model/state.h"

/* Classes: S++, S+-, S-+ and S-- are 2 * (first contact) + (second contact); stick: at least one
 * contact stuck, none open; open: at least one contact open. */
enum { VISIT_STICK = 4, VISIT_OPEN = 5, VISIT_CLASSES = SD_CONFIGURATIONS, VISIT_NONE = -1 };
/* Sums of a part: torque and its square; then per contact the normal force minus its reference,
 * and the square of this. */
enum { VISIT_TORQUE, VISIT_TORQUE2, VISIT_FORCE, VISIT_FORCE2, VISIT_SUMS = VISIT_FORCE + 4 };
/* Bins of a visit's age: below VISIT_YOUNG steps, then octaves; the last bin is unbounded. */
enum { VISIT_YOUNG = 32, VISIT_AGES = SD_AGES };

/* Class of a pair of contacts in the states first and second (SD_SLIDE_POSITIVE ... SD_OPEN). */
static inline int visits_class(int first, int second) {
  int more = first > second ? first : second;
  return more >= SD_STUCK ? more + 2 : 2 * first + second;
}

/* Bin of an age >= 0, in steps. */
static inline int visits_octave(int64_t age) {
  int b = 63 - __builtin_clzll((unsigned long long)age | (VISIT_YOUNG / 2)) - 4;
  return b < VISIT_AGES - 1 ? b : VISIT_AGES - 1;
}
/* Number of measured steps from `now` until the current part ends because of its age; HUGE_VAL:
 * it does not. */
double visits_left(const sd_state *s, size_t k, int64_t now);
/* Ends the current part of pair k after `now` measured steps; the next step is in `class`. The
 * part's sums are part[q * stride]; the caller sets them to 0 afterwards. */
void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now);
/* Ends the current visit of pair k when measuring pauses or begins; its duration stays unknown. */
void visits_cut(sd_state *s, size_t k);

#endif
