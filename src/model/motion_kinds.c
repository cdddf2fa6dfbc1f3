/* motion_kinds.c: see motion_kinds.h. */
#include "model/motion_kinds.h"

#include <assert.h>

static void check_random(const sd_motion *q, double dt, const char *name, sd_messages *msg) {
  (void)dt;
  if (!(q->omega > 0.0) || !(q->damping > 0.0) || q->interval < 1)
    sd_fail(msg, SD_ERROR_USER, "motion \"%s\": expected omega > 0, damping > 0, interval >= 1", name);
}

static void check_table(const sd_motion *q, double dt, const char *name, sd_messages *msg) {
  (void)dt;
  if (q->n_table < 3) sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: expected 3 rows or more", name);
  for (size_t r = 0; r < q->n_table; r++)
    if (!isfinite(q->table_time[r]) || !isfinite(q->table_value[r])) {
      sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: expected finite numbers (row %zu)", name, r);
      break;
    }
  for (size_t r = 1; r < q->n_table; r++)
    if (!(q->table_time[r] > q->table_time[r - 1])) {
      sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: time must increase (row %zu)", name, r);
      break;
    }
  if (q->periodic && q->n_table && q->table_value[0] != q->table_value[q->n_table - 1])
    sd_fail(msg, SD_ERROR_USER, "motion \"%s\": table: periodic, so the last value must equal the first",
            name);
}

#define ROW(kind, word, source, amplitude, check, ...) [kind] = {#word, source, amplitude, check},
const motion_kind motion_kinds[SD_MOTION_KINDS] = {MOTION_KINDS(ROW)};
#undef ROW

double motion_period(const sd_motion *q) {
  if (motion_is_wave(q)) return 2 * M_PI / fabs(q->omega);
  return motion_source(q) == SIGNAL_TABLE && q->periodic ? q->table_time[q->n_table - 1] - q->table_time[0]
                                                         : 0;
}

double motion_reach(const sd_motion *q) {
  return motion_is_wave(q) || motion_source(q) == SIGNAL_RANDOM ? fabs(q->amplitude) : HUGE_VAL;
}

void motion_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
#define SHAPE_CASE(kind, word, ...)                                                                          \
  case kind: word##_shape(q, shape); return;
  switch (q->kind) {
    WAVEFORMS(SHAPE_CASE)
    default: assert(!"a wave");
  }
#undef SHAPE_CASE
}
