/* theory_drive.c: how the supports are driven in the phases that measure.
 *
 * The theory knows supports that turn: steadily, or to and fro by (20) or (21) with one frequency; and, for
 * torques and the sense of rotation alone, random vibration (52). A motion of amplitude or velocity 0 is none.
 */
#include <math.h>

#include "app/theory/theory.h"
#include "model/motions.h"
#include "slipdisk/deck.h"

static const char *const coordinate_names[SD_MOVED] = {"x", "y", "theta", "surface"};

/* Active drive: the motion of each support's angle, if any, and whether others shake it at random. */
typedef struct drivers {
  const sd_motion *turn[2];
  size_t number[2];
  bool shaken[2];
} drivers;

static bool names(const sd_motion *motion, uint32_t body) {
  for (size_t b = 0; b < motion->n_bodies; b++)
    if (motion->bodies[b] == body) return true;
  return false;
}

static bool rests(const sd_motion *motion) {
  if (motion_is_feedback(motion)) return false;
  return motion->kind == SD_MOTION_VELOCITY ? motion->velocity == 0 : motion->amplitude == 0;
}

/* Of the angle of a support. */
static bool is_known(const sd_motion *motion) {
  return motion->kind == SD_MOTION_HARMONIC || motion->kind == SD_MOTION_PARABOLIC ||
         motion->kind == SD_MOTION_VELOCITY || motion->kind == SD_MOTION_RANDOM;
}

/* 'motion "turn" (harmonic)' */
static const char *motion_name(const sd_motion *motion, char *text, size_t size) {
  if (motion->name)
    snprintf(text, size, "motion \"%s\" (%s)", motion->name, motion_kinds[motion->kind].name);
  else
    snprintf(text, size, "a %s motion", motion_kinds[motion->kind].name);
  return text;
}

static sd_status fail_motion(const sd_model *m, sd_messages *messages, const sd_motion *motion, uint32_t body,
                             const char *expected) {
  char what[160], whom[96];
  return sd_fail(messages, SD_ERROR_USER, "%s: theory: %s moves %s of %s; expected %s",
                 sd_model_deck(m)->path, motion_name(motion, what, sizeof what),
                 coordinate_names[motion->coordinate], sd_model_body_name(m, body, whom, sizeof whom),
                 expected);
}

/* The first phase that measures, else the last; all that measure must have the same motions on. */
static sd_status find_phase(const sd_model *m, size_t *phase, sd_messages *messages) {
  size_t first = m->n_phases;
  for (size_t p = 0; p < m->n_phases; p++) {
    if (!m->phases[p].measure) continue;
    if (first == m->n_phases) first = p;
    for (size_t k = 0; k < m->n_motions; k++)
      if (m->phases[p].active[k] != m->phases[first].active[k])
        return sd_fail(
            messages, SD_ERROR_USER,
            "%s: theory: phases %zu and %zu both measure, with different motions; expected the same",
            sd_model_deck(m)->path, first, p);
  }
  *phase = first < m->n_phases ? first : m->n_phases - 1;
  return SD_OK;
}

/* Time at which a motion that is on in this phase was switched on. */
static double begin(const sd_model *m, size_t motion, size_t phase) {
  int64_t steps = 0;
  while (phase > 0 && m->phases[phase - 1].active[motion]) phase--;
  for (size_t p = 0; p < phase; p++) steps += m->phases[p].steps;
  return (double)steps * m->dt;
}

static sd_status gather(const sd_model *m, size_t phase, uint32_t upper, const uint32_t support[2],
                        drivers *on, sd_messages *messages) {
  sd_status status = SD_OK;
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *motion = &m->motions[k];
    if (names(motion, upper))
      status = fail_motion(m, messages, motion, upper, "the upper disk to be moved by its supports alone");
    if (rests(motion)) continue;
    for (int i = 0; i < 2; i++) {
      if (!names(motion, support[i])) continue;
      if (!m->phases[phase].active[k]) {
        if (motion->coordinate != SD_THETA)
          status = fail_motion(m, messages, motion, support[i],
                               "the supports to stay where they are before it is measured");
      } else if (motion->coordinate != SD_THETA) {
        on->shaken[i] = true;
        if (motion->kind != SD_MOTION_RANDOM)
          status =
              fail_motion(m, messages, motion, support[i], "supports that only turn, or vibrate at random");
      } else if (!is_known(motion)) {
        status = fail_motion(m, messages, motion, support[i],
                             "type \"harmonic\", \"parabolic\", \"velocity\" or \"random\"");
      } else if (on->turn[i]) {
        status = fail_motion(m, messages, motion, support[i], "one motion of this angle, there is another");
      } else {
        on->turn[i] = motion;
        on->number[i] = k;
      }
    }
  }
  return status;
}

/* Kinds of both supports must go together. */
static sd_status check_pair(const sd_model *m, const drivers *on, const uint32_t support[2],
                            sd_messages *messages) {
  const sd_motion *a = on->turn[0], *b = on->turn[1];
  bool shaken = on->shaken[0] || on->shaken[1];
  for (int i = 0; i < 2; i++) {
    const sd_motion *one = on->turn[i];
    if (shaken && one && one->kind != SD_MOTION_RANDOM)
      return fail_motion(m, messages, one, support[i], "random vibration, as of its other coordinates");
  }
  if (!a || !b) return SD_OK;
  if (a->kind != b->kind) {
    char other[160], expected[256];
    snprintf(expected, sizeof expected, "the same type as of %s, which turns the other support",
             motion_name(a, other, sizeof other));
    return fail_motion(m, messages, b, support[1], expected);
  }
  if (motion_is_wave(a) && fabs(a->omega - b->omega) > 1e-12 * a->omega) {
    char expected[128];
    snprintf(expected, sizeof expected, "omega = %.12g, as of the other support, not %.12g", a->omega,
             b->omega);
    return fail_motion(m, messages, b, support[1], expected);
  }
  return SD_OK;
}

static void set_periodic(const sd_model *m, const drivers *on, size_t phase, theory_case *c) {
  int reference = on->turn[0] ? 0 : 1;
  const sd_motion *first = on->turn[reference];
  double began = begin(m, on->number[reference], phase);
  c->kind = THEORY_PERIODIC;
  c->drive.waveform = first->kind == SD_MOTION_HARMONIC ? SD_SINE : SD_PARABOLA;
  c->drive.omega = first->omega;
  for (int i = 0; i < 2; i++) {
    c->drive.support_radius[i] = c->support_radius[i];
    const sd_motion *one = on->turn[i];
    if (!one) continue;
    c->drive.amplitude[i] = fabs(one->amplitude);
    c->drive.phase[i] = one->phase + one->omega * (began - begin(m, on->number[i], phase));
    if (one->amplitude < 0) c->drive.phase[i] += M_PI; /* f(u + pi) = -f(u) */
  }
}

sd_status theory_drive_read(const sd_model *m, uint32_t upper, const uint32_t support[2], theory_case *c,
                            sd_messages *messages) {
  size_t phase = 0;
  drivers on = {0};
  sd_status status = find_phase(m, &phase, messages);
  if (status) return status;
  status = gather(m, phase, upper, support, &on, messages);
  if (!status) status = check_pair(m, &on, support, messages);
  if (status) return status;

  const sd_motion *one = on.turn[0] ? on.turn[0] : on.turn[1];
  bool shaken = on.shaken[0] || on.shaken[1];
  if (shaken || (one && one->kind == SD_MOTION_RANDOM)) {
    c->kind = THEORY_RANDOM;
    c->shared = !shaken && on.turn[0] == on.turn[1];
  } else if (!one) {
    c->kind = THEORY_REST;
  } else if (one->kind == SD_MOTION_VELOCITY) {
    c->kind = THEORY_STEADY;
    for (int i = 0; i < 2; i++) c->velocity[i] = on.turn[i] ? on.turn[i]->velocity : 0;
  } else {
    set_periodic(m, &on, phase, c);
    if (c->locked)
      return sd_fail(messages, SD_ERROR_USER,
                     "%s: theory: %s cannot turn (theta is locked) while its supports turn to and fro; "
                     "expected it free to turn",
                     sd_model_deck(m)->path, c->upper);
  }
  return SD_OK;
}
