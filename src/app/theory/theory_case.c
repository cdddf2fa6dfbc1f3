/* theory_case.c: finds the three disks of a deck, their angles and their drive, as input of the
 * theory.
 *
 * Angles hold where the upper disk just touches both supports, seen with its weight pointing down:
 * alpha_1 = theta_h - theta_T on the left, alpha_2 = theta_h + theta_T on the right (theta_h: half
 * aperture, theta_T: tilt). */
#include <math.h>

#include "app/theory/theory.h"
#include "model/model.h"
#include "model/motions.h"
#include "slipdisk/deck.h"

/* Disks count as touching the upper disk if the gap between them is less than this fraction of its
 * radius. */
static const double NEAR = 0.01;
/* Largest distance allowed between the position of the upper disk in the deck and the position
 * where it touches both supports, as a fraction of its radius. */
static const double AWAY = 0.25;

static sd_status fail_disk(const sd_model *m, sd_messages *messages, uint32_t body,
                           const char *what) {
  char name[96];
  return sd_fail(messages, SD_ERROR_USER, "%s: theory: %s %s", sd_model_deck(m)->path,
                 sd_model_body_name(m, body, name, sizeof name), what);
}

/* Computes the vector out = to - from, with the periodic image of `to` that is nearest to
 * `from`. */
static void towards(const sd_model *m, const double from[2], const double to[2], double out[2]) {
  for (int c = 0; c < 2; c++) {
    out[c] = to[c] - from[c];
    double width = m->upper[c] - m->lower[c];
    if (m->periodic[c]) out[c] -= width * nearbyint(out[c] / width);
  }
}

static double gap(const sd_model *m, uint32_t a, uint32_t b) {
  double d[2];
  towards(m, m->disks[a].position, m->disks[b].position, d);
  return hypot(d[0], d[1]) - m->disks[a].radius - m->disks[b].radius;
}

/* --- choice of the disks ---------------------------------------------------------------------- */

static sd_status find_upper(const sd_model *m, uint32_t *upper, sd_messages *messages) {
  if (m->n_slides > 1)
    sd_warn(messages, "%s: theory: measure.sliding has %zu entries; this is about the first",
            sd_model_deck(m)->path, m->n_slides);
  if (m->n_slides > 0) {
    *upper = m->slides[0].disk;
    return SD_OK;
  }
  for (uint32_t i = 0; i < m->n_disks; i++)
    if (!m->disks[i].driven) *upper = i;
  if (m->n_free == 1) return SD_OK;
  return sd_fail(
      messages, SD_ERROR_USER,
      "%s: theory: there are %zu free disks; expected one on two supports, or an entry of "
      "measure.sliding that names it",
      sd_model_deck(m)->path, m->n_free);
}

/* Finds the two supports if the deck has no measure.sliding to name them: the two driven disks if
 * there are just two, else the two disks that touch the upper disk. */
static sd_status find_supports(const sd_model *m, uint32_t upper, uint32_t support[2],
                               sd_messages *messages) {
  size_t n_driven = m->n_disks - m->n_free, n = 0;
  for (uint32_t i = 0; i < m->n_disks; i++) {
    if (!m->disks[i].driven || (n_driven != 2 && gap(m, upper, i) > NEAR * m->disks[upper].radius))
      continue;
    if (n < 2) support[n] = i;
    n++;
  }
  if (n == 2) return SD_OK;
  char name[96];
  return sd_fail(messages, SD_ERROR_USER,
                 "%s: theory: %s rests on %zu fixed or moved disks; expected two supports",
                 sd_model_deck(m)->path, sd_model_body_name(m, upper, name, sizeof name), n);
}

static sd_status find_disks(const sd_model *m, uint32_t *upper, uint32_t support[2],
                            sd_messages *messages) {
  sd_status status = find_upper(m, upper, messages);
  if (status) return status;
  if (m->n_slides == 0) return find_supports(m, *upper, support, messages);
  for (int k = 0; k < 2; k++) {
    support[k] = m->slides[0].partner[k];
    if (support[k] >= m->n_disks)
      status = fail_disk(m, messages, support[k],
                         "of measure.sliding is a wall; expected a disk as a support");
    else if (!m->disks[support[k]].driven)
      status = fail_disk(m, messages, support[k],
                         "of measure.sliding is free; expected a support that is fixed or moved");
  }
  return status;
}

/* --- geometry --------------------------------------------------------------------------------- */

/* Computes the position where the upper disk just touches both supports, relative to its position
 * in the deck. */
static sd_status touch(const sd_model *m, uint32_t upper, const uint32_t support[2], double out[2],
                       sd_messages *messages) {
  const sd_disk *disk = &m->disks[upper];
  double first[2], second[2], between[2], r[2];
  towards(m, disk->position, m->disks[support[0]].position, first);
  towards(m, disk->position, m->disks[support[1]].position, second);
  for (int c = 0; c < 2; c++) between[c] = second[c] - first[c];
  for (int k = 0; k < 2; k++) r[k] = disk->radius + m->disks[support[k]].radius;
  double far = hypot(between[0], between[1]);
  if (!(far < r[0] + r[1]))
    return fail_disk(m, messages, upper,
                     "falls through between its supports; expected it to rest on both of them");
  if (!(far > fabs(r[0] - r[1])))
    return fail_disk(m, messages, upper,
                     "cannot touch both supports; expected them to stand beside each other");

  /* Coordinates of that position, relative to the first support. along: along the line to the other
   * support; away: distance from that line, on the side where the disk is in the deck. */
  double along = (r[0] * r[0] - r[1] * r[1] + far * far) / (2 * far);
  double away = sqrt((r[0] - along) * (r[0] + along));
  double e[2] = {between[0] / far, between[1] / far};
  if (first[0] * -e[1] + first[1] * e[0] > 0) away = -away;
  out[0] = first[0] + along * e[0] - away * e[1];
  out[1] = first[1] + along * e[1] + away * e[0];
  if (hypot(out[0], out[1]) > AWAY * disk->radius)
    return fail_disk(m, messages, upper,
                     "starts far from where it touches both supports; expected it to rest on them");
  return SD_OK;
}

/* Returns the distance of the point `at` from the nearest point of a wall's surface, >= 0. */
static double wall_gap(const sd_model *m, const sd_wall *w, const double at[2]) {
  double d[2];
  if (w->kind == SD_WALL_CIRCLE) {
    towards(m, at, w->pivot, d);
    return fabs(hypot(d[0], d[1]) - w->radius);
  }
  double least = HUGE_VAL;
  size_t pieces = w->closed ? w->n_points : w->n_points - 1;
  for (size_t k = 0; k < pieces; k++) {
    const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
    double e[2] = {q[0] - p[0], q[1] - p[1]}, length = hypot(e[0], e[1]);
    towards(m, p, at, d);
    double along = (d[0] * e[0] + d[1] * e[1]) / length, off = (d[0] * e[1] - d[1] * e[0]) / length;
    if (w->kind != SD_WALL_LINE && (along < 0 || along > length)) {
      double beyond = along < 0 ? along : along - length;
      off = hypot(off, beyond);
    }
    least = fmin(least, fabs(off));
  }
  return least;
}

/* Checks that with its centre at `at` the upper disk touches no bodies other than the two
 * supports. */
static sd_status check_alone(const sd_model *m, uint32_t upper, const uint32_t support[2],
                             const double at[2], sd_messages *messages) {
  sd_status status = SD_OK;
  double radius = m->disks[upper].radius, reach = (1 + NEAR) * radius;
  for (uint32_t b = 0; b < sd_model_bodies(m); b++) {
    if (b == upper || b == support[0] || b == support[1]) continue;
    double d[2], distance;
    if (b < m->n_disks) {
      towards(m, at, m->disks[b].position, d);
      distance = hypot(d[0], d[1]) - m->disks[b].radius;
    } else {
      distance = wall_gap(m, &m->walls[b - m->n_disks], at);
    }
    if (distance < reach)
      status =
          fail_disk(m, messages, b,
                    "touches the upper disk too; expected contacts with the two supports alone");
  }
  return status;
}

/* Sets the angles of the contacts from the vectors to[k] from the upper disk to support[k]. If
 * support[0] is the right one, swaps the two supports. */
static void set_angles(theory_case *c, uint32_t support[2], double to[2][2],
                       const double weight[2]) {
  double down[2] = {weight[0] / c->disk.weight, weight[1] / c->disk.weight};
  double right[2] = {-down[1], down[0]}, angle[2];
  for (int k = 0; k < 2; k++)
    angle[k] =
        atan2(to[k][0] * right[0] + to[k][1] * right[1], to[k][0] * down[0] + to[k][1] * down[1]);
  c->swapped = angle[0] > angle[1];
  if (c->swapped) {
    uint32_t s = support[0];
    support[0] = support[1];
    support[1] = s;
  }
  c->alpha[0] = -angle[c->swapped];
  c->alpha[1] = angle[!c->swapped];
  c->disk.half_aperture = (c->alpha[1] + c->alpha[0]) / 2;
  c->disk.tilt = (c->alpha[1] - c->alpha[0]) / 2;
}

static sd_status set_geometry(const sd_model *m, theory_case *c, uint32_t upper,
                              uint32_t support[2], sd_messages *messages) {
  const sd_disk *disk = &m->disks[upper];
  double shift[2] = {0}, at[2], to[2][2], weight[2];
  for (int k = 0; k < 2; k++) weight[k] = disk->mass * m->gravity[k] + disk->force[k];
  c->mass = disk->mass;
  c->disk.weight = hypot(weight[0], weight[1]);
  if (!(c->disk.weight > 0))
    return fail_disk(m, messages, upper,
                     "has no weight; expected gravity that presses it on its supports");
  sd_status status = touch(m, upper, support, shift, messages);
  if (status) return status;
  c->offset = hypot(shift[0], shift[1]);
  for (int k = 0; k < 2; k++) at[k] = disk->position[k] + shift[k];
  for (int k = 0; k < 2; k++) towards(m, at, m->disks[support[k]].position, to[k]);
  set_angles(c, support, to, weight);
  c->disk.radius = disk->radius;
  c->disk.inertia = disk->inertia;
  c->t_g = sqrt(2 * disk->radius * disk->mass / c->disk.weight);
  if (!(c->disk.half_aperture < M_PI / 2))
    return fail_disk(m, messages, upper,
                     "does not stand above its supports; expected gravity to press it "
                     "between them");
  return check_alone(m, upper, support, at, messages);
}

/* --- contact laws and constraints ------------------------------------------------------------- */

/* Returns the first key of a contact law for which the theory does not hold, since it covers only
 * linear elastic contacts with Coulomb friction mu; NULL: there is no such key. */
static const char *beyond_theory(const sd_contact_law *law) {
  const unsigned features = law_features(law);
  return law->normal != SD_NORMAL_LINEAR ? "law"
         : features & LAW_MINDLIN        ? "tangential"
         : features & LAW_KINETIC        ? "mu_kinetic"
         : features & LAW_CRITICAL       ? "critical_load"
         : features & LAW_DASHPOT        ? "gamma_t"
         : features & LAW_ROLLING        ? "mu_r"
         : features & LAW_COHESION       ? "cohesion"
                                         : NULL;
}

static sd_status set_contacts(const sd_model *m, theory_case *c, uint32_t upper,
                              const uint32_t support[2], sd_messages *messages) {
  double mu[2];
  for (int k = 0; k < 2; k++) {
    const sd_contact_law *law =
        sd_model_law(m, m->disks[upper].material, m->disks[support[k]].material);
    const char *beyond = beyond_theory(law);
    if (beyond)
      return sd_fail(messages, SD_ERROR_USER,
                     "%s: theory: the contacts of %s with %s have `%s`; expected linear ones with "
                     "friction mu alone",
                     sd_model_deck(m)->path, c->upper, c->support[k], beyond);
    mu[k] = law->mu;
    c->k_t[k] = law->k_t;
    c->stiffness = k == 0 ? law->k_n : fmin(c->stiffness, law->k_n);
    c->support_radius[k] = m->disks[support[k]].radius;
  }
  c->disk.mu = mu[0];
  if (!(c->k_t[0] > 0 && c->k_t[1] > 0))
    return sd_fail(
        messages, SD_ERROR_USER,
        "%s: theory: the contacts of %s have k_t = 0, hence no friction; expected k_t > 0",
        sd_model_deck(m)->path, c->upper);
  if (mu[0] != mu[1])
    return sd_fail(
        messages, SD_ERROR_USER,
        "%s: theory: the contacts of %s with %s and %s have mu = %g and %g; expected the same",
        sd_model_deck(m)->path, c->upper, c->support[0], c->support[1], mu[0], mu[1]);
  return SD_OK;
}

/* Checks that apart from weight and contacts nothing constrains or drives the upper disk. */
static sd_status check_bonds(const sd_model *m, theory_case *c, uint32_t upper,
                             sd_messages *messages) {
  const sd_disk *disk = &m->disks[upper];
  sd_status status = SD_OK;
  c->locked = disk->locked[SD_THETA];
  c->spin = disk->velocity[SD_THETA];
  if (disk->locked[SD_X] || disk->locked[SD_Y])
    status = fail_disk(
        m, messages, upper,
        "has its centre locked, so that its normal forces stay as they are; expected it free, "
        "to find its equilibrium");
  if (disk->force[SD_THETA] != 0)
    status = fail_disk(m, messages, upper, "has a constant torque on it; expected none");
  if (disk->clump > 0)
    status = fail_disk(m, messages, upper, "belongs to a clump; expected a disk of its own");
  if (m->n_fields > 0)
    status = sd_fail(messages, SD_ERROR_USER, "%s: theory: it has fields; expected none",
                     sd_model_deck(m)->path);
  return status;
}

sd_status theory_case_read(const sd_model *m, theory_case *c, sd_messages *messages) {
  uint32_t upper = 0, support[2] = {0, 0};
  *c = (theory_case){.drive.omega = NAN,
                     .reversal = NAN,
                     .start_torque = NAN,
                     .final_spin = NAN,
                     .apart = NAN,
                     .amplitude = NAN,
                     .ratio = NAN,
                     .parabola.mean = NAN,
                     .first_order = NAN,
                     .sine = NAN,
                     .limit = NAN,
                     .solution.period = NAN,
                     .solution.mean = NAN};
  sd_status status = find_disks(m, &upper, support, messages), found;
  if (status) return status;
  sd_model_body_name(m, upper, c->upper, sizeof c->upper);
  status = check_bonds(m, c, upper, messages);
  found = set_geometry(m, c, upper, support, messages);
  if (found) return found; /* The checks below need to know which support is the left one */
  for (int k = 0; k < 2; k++)
    sd_model_body_name(m, support[k], c->support[k], sizeof c->support[k]);
  found = set_contacts(m, c, upper, support, messages);
  if (found) status = found;
  found = theory_drive_read(m, upper, support, c, messages);
  return found ? found : status;
}

/* --- drive of the supports in phases that measure --------------------------------------------- */

static const char *const coordinate_names[SD_MOVED] = {"x", "y", "theta", "surface"};

/* Motions of the two supports (left, right) that are switched on: the motion of the support's angle
 * (NULL: none), the index of this motion, and whether random motions move other coordinates of the
 * support. The theory covers steady rotation, and oscillation by equation (20) or (21) of the paper
 * with one frequency for both; random vibration, equation (52), only for torques and the sense of
 * rotation. A motion of amplitude or velocity 0 is ignored. */
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

/* True if the theory covers this kind of motion for the angle of a support. */
static bool is_known(const sd_motion *motion) {
  return motion->kind == SD_MOTION_HARMONIC || motion->kind == SD_MOTION_PARABOLIC ||
         motion->kind == SD_MOTION_VELOCITY || motion->kind == SD_MOTION_RANDOM;
}

/* Formats name and kind of a motion, such as 'motion "turn" (harmonic)', into text[size] and
 * returns it. */
static const char *motion_name(const sd_motion *motion, char *text, size_t size) {
  if (motion->name)
    snprintf(text, size, "motion \"%s\" (%s)", motion->name, motion_kinds[motion->kind].name);
  else
    snprintf(text, size, "a %s motion", motion_kinds[motion->kind].name);
  return text;
}

static sd_status fail_motion(const sd_model *m, sd_messages *messages, const sd_motion *motion,
                             uint32_t body, const char *expected) {
  char what[160], whom[96];
  return sd_fail(messages, SD_ERROR_USER, "%s: theory: %s moves %s of %s; expected %s",
                 sd_model_deck(m)->path, motion_name(motion, what, sizeof what),
                 coordinate_names[motion->coordinate],
                 sd_model_body_name(m, body, whom, sizeof whom), expected);
}

/* Finds the first phase that measures; if none does, the last phase. SD_ERROR_USER: two phases that
 * measure have different motions switched on. */
static sd_status find_phase(const sd_model *m, size_t *phase, sd_messages *messages) {
  size_t first = m->n_phases;
  for (size_t p = 0; p < m->n_phases; p++) {
    if (!m->phases[p].measure) continue;
    if (first == m->n_phases) first = p;
    for (size_t k = 0; k < m->n_motions; k++)
      if (m->phases[p].active[k] != m->phases[first].active[k])
        return sd_fail(messages, SD_ERROR_USER,
                       "%s: theory: phases %zu and %zu both measure, with different motions; "
                       "expected the same",
                       sd_model_deck(m)->path, first, p);
  }
  *phase = first < m->n_phases ? first : m->n_phases - 1;
  return SD_OK;
}

/* Returns the time at which a motion was switched on that is on in phase `phase`. */
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
      status = fail_motion(m, messages, motion, upper,
                           "the upper disk to be moved by its supports alone");
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
          status = fail_motion(m, messages, motion, support[i],
                               "supports that only turn, or vibrate at random");
      } else if (!is_known(motion)) {
        status = fail_motion(m, messages, motion, support[i],
                             "type \"harmonic\", \"parabolic\", \"velocity\" or \"random\"");
      } else if (on->turn[i]) {
        status = fail_motion(m, messages, motion, support[i],
                             "one motion of this angle, there is another");
      } else {
        on->turn[i] = motion;
        on->number[i] = k;
      }
    }
  }
  return status;
}

/* Checks that the motions of both supports are of the same kind and have the same frequency. */
static sd_status check_pair(const sd_model *m, const drivers *on, const uint32_t support[2],
                            sd_messages *messages) {
  const sd_motion *a = on->turn[0], *b = on->turn[1];
  bool shaken = on->shaken[0] || on->shaken[1];
  for (int i = 0; i < 2; i++) {
    const sd_motion *one = on->turn[i];
    if (shaken && one && one->kind != SD_MOTION_RANDOM)
      return fail_motion(m, messages, one, support[i],
                         "random vibration, as of its other coordinates");
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
    snprintf(expected, sizeof expected, "omega = %.12g, as of the other support, not %.12g",
             a->omega, b->omega);
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
    /* A negative amplitude is a phase shift by pi, since both waveforms fulfil f(u + pi) = -f(u) */
    if (one->amplitude < 0) c->drive.phase[i] += M_PI;
  }
}

sd_status theory_drive_read(const sd_model *m, uint32_t upper, const uint32_t support[2],
                            theory_case *c, sd_messages *messages) {
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
      return sd_fail(
          messages, SD_ERROR_USER,
          "%s: theory: %s cannot turn (theta is locked) while its supports turn to and fro; "
          "expected it free to turn",
          sd_model_deck(m)->path, c->upper);
  }
  return SD_OK;
}
