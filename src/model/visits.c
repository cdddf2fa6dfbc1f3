/* visits.c: sums of the visits to sliding configurations; see visits.h. */
#include "model/visits.h"

#include <assert.h>
#include <string.h>

double visits_left(const sd_state *s, size_t k, int64_t now) {
  int64_t since = s->visit_since[k];
  if (s->visit_class[k] == VISIT_NONE || since < 0) return HUGE_VAL;
  int b = visits_octave(s->visit_from[k] - since);
  return b < VISIT_AGES - 1 ? (double)(since + ((int64_t)VISIT_YOUNG << b) - now) : HUGE_VAL;
}

/* Adds the sums of the current part of pair k to those of its class, and begins a new part. */
static void end_part(sd_state *s, size_t k, const double *part, size_t stride, int64_t now) {
  size_t class = VISIT_CLASSES * k + (size_t)s->visit_class[k];
  double *sum = s->visit_sum + VISIT_SUMS * class;
  assert(s->visit_class[k] >= 0 && s->visit_class[k] < VISIT_CLASSES && now >= s->visit_from[k]);
  if (s->visit_since[k] >= 0) {
    size_t bin = VISIT_AGES * class + (size_t)visits_octave(s->visit_from[k] - s->visit_since[k]);
    s->visit_age_torque[bin] += part[VISIT_TORQUE * stride];
    s->visit_age_steps[bin] += now - s->visit_from[k];
  }
  for (size_t q = 0; q < VISIT_SUMS; q++) sum[q] += part[q * stride];
  s->visit_from[k] = now;
}

void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now) {
  const int was = s->visit_class[k];
  if (was != VISIT_NONE) end_part(s, k, part, stride, now);
  if (class == was) return;
  if (was != VISIT_NONE && s->visit_since[k] >= 0) {
    size_t ended = VISIT_CLASSES * k + (size_t)was;
    int64_t steps = now - s->visit_since[k];
    s->visit_count[ended]++;
    s->visit_steps[ended] += steps;
    s->visit_steps2[ended] += (double)steps * (double)steps;
  }
  s->visit_since[k] = was == VISIT_NONE ? -1 : now;
  s->visit_from[k] = now;
  s->visit_class[k] = class;
}

void visits_cut(sd_state *s, size_t k) {
  double *part = s->visit_part + VISIT_SUMS * k;
  if (s->measured > 0 && s->visit_class[k] != VISIT_NONE) end_part(s, k, part, 1, s->measured);
  memset(part, 0, VISIT_SUMS * sizeof *part);
  s->visit_class[k] = VISIT_NONE;
}
