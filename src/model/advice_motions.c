/* advice_motions.c: motions that strike what they move, or pass through it. See advice.h. */
#include <math.h>
#include <stdlib.h>

#include "base/text.h"
#include "model/advice.h"
#include "model/motion_kinds.h"
#include "model/strides.h"

/* Jumps over the radius of the smallest disk, and cycles in steps, beyond which a motion is warned of. */
static const double LEAST_JUMP = 1e-3, FEWEST_STEPS = 20;

static double check_stride(const sd_model *m, sd_messages *messages) {
  char motion[96], body[96];
  const double limit = m->limits.displacement;
  stride s;
  if (!(limit > 0) || !strides_longest(m, &s) || !(s.length > limit)) return 0;
  const char *name = model_motion_name(m, s.motion, motion, sizeof motion);
  sd_model_body_name(m, s.body, body, sizeof body);
  if (motion_source(&m->motions[s.motion]) == SIGNAL_TABLE)
    sd_warn(messages,
            "%s: %s moves by up to %.3g radii of the smallest disk in a step, and disks may pass through it: "
            "spread the change over more time (limits.displacement is %g)",
            name, body, s.length, limit);
  else
    sd_warn(messages,
            "%s: %s moves by up to %.3g radii of the smallest disk in a step, and disks may pass through it: "
            "take a lower speed, or dt = %.2g or less (limits.displacement is %g)",
            name, body, s.length, m->dt * limit / s.length / 2, limit);
  return s.length / limit;
}

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
      return format_text("%s begins with a jump by %s%.3g radii of the smallest disk, which throws what is "
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

static double check_cycles(const sd_model *m, sd_messages *messages) {
  char name[96];
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    const double steps = motion_is_wave(q) && q->amplitude != 0 ? motion_period(q) / m->dt : HUGE_VAL;
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
  return fmax(far, fmax(jump, cycle));
}
