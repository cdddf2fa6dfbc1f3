/* sliding.c: the periodic state of a disk on two turning supports, if its contacts slide all the
 * time.
 *
 *   I dOmega/dt = T(s_1, s_2),  s_i = sign(w_i(t) - Omega),  w_i = -theta_i' R_i/R,
 *
 * with the constant torques (15)-(18) of the paper at the translational equilibrium points:
 * Omega(t) is piecewise linear, and its corners are the transition times of (23)-(24) and
 * (32)-(33). Time is measured as the phase u = w_b t and Omega in units of w_b. The map Omega(0) ->
 * Omega(2 pi) is followed from corner to corner, each found to rounding; its fixed point is the
 * root of the net change of Omega, which decreases monotonically with Omega(0), found by Brent's
 * method.
 *
 * If w_i changes more slowly than the torques on either side would change Omega, no sign is
 * consistent: the contact sticks and Omega follows w_i (the solution in the sense of Filippov). Two
 * supports that move alike act as one contact with the torques T++ and T--.
 */
#include "theory/sliding.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_roots.h>
#include <math.h>

#include "base/memory.h"
#include "slipdisk/theory.h"

/* Returns dOmega/du if the contacts slide with the signs s. */
static double rate_of(const sliding_system *y, const int s[2]) {
  return y->n == 1 ? y->rate[s[0] < 0][s[0] < 0] : y->rate[s[0] < 0][s[1] < 0];
}

/* Sets the signs of sliding s just after phase u; the sign of contact i is that of w_i - Omega.
 * Contacts in `active` have w_i = Omega now, and their sign must be consistent with the motion
 * that it causes; 0: the contact sticks. Torques decrease with Omega, so exactly one choice is
 * consistent, except for ties. */
static void choose(const sliding_system *y, double u, const bool active[2], int s[2]) {
  double d[2] = {sliding_slope(y, 0, u), y->n == 2 ? sliding_slope(y, 1, u) : 0};
  for (int k = 0; k < 4; k++) {
    int t[2] = {active[0] ? 1 - 2 * (k & 1) : s[0], active[1] ? 1 - (k & 2) : s[1]};
    double rate = rate_of(y, t);
    bool consistent = true;
    for (int i = 0; i < y->n; i++) consistent &= !active[i] || t[i] * (d[i] - rate) > 0;
    if (!consistent) continue;
    s[0] = t[0];
    s[1] = t[1];
    return;
  }
  for (int i = 0; i < y->n; i++) {
    if (!active[i]) continue;
    int j = 1 - i;
    for (int sj = 1; sj >= -1; sj -= 2) {
      int up[2], down[2];
      up[i] = 1, down[i] = -1;
      up[j] = down[j] = y->n == 2 && active[j] ? sj : s[j];
      if (d[i] > rate_of(y, up) || d[i] < rate_of(y, down)) continue;
      if (y->n == 2 && active[j] && !(sj * (d[j] - d[i]) > 0)) continue;
      s[i] = 0;
      s[j] = up[j];
      return;
    }
  }
  /* a tie: the velocities of both supports have the same slope at this moment */
  s[active[0] ? 0 : 1] = 0;
}

/* Returns the phase at which sliding with the signs s ends, for a piece of the path that starts
 * at phase u with the angular velocity omega. *which: the contact that reverses then; -1: none
 * before the end of the period. */
static double slide_until(const sliding_system *y, double u, double omega, const int s[2],
                          int *which) {
  double rate = rate_of(y, s), next = y->end;
  *which = -1;
  for (int i = 0; i < 2 && i < y->n; i++) {
    double meeting = sliding_meeting(y, i, u, omega, rate, s[i]);
    if (meeting < next) {
      next = meeting;
      *which = i;
    }
  }
  return next;
}

/* Follows Omega from phase u = 0 to 2 pi and stores the path, which begins with Omega = start.
 * False: the path has too many pieces. */
static bool follow(const sliding_system *y, double start, sliding_path *path) {
  double u = 0, omega = start, tiny = 1e-13 * y->peak;
  int s[2] = {1, 1};
  bool active[2] = {false, false};
  *path = (sliding_path){0};

  for (int i = 0; i < y->n; i++) {
    double ahead = sliding_wave(y, i, 0) - omega;
    active[i] = fabs(ahead) <= tiny;
    s[i] = ahead < 0 ? -1 : 1;
  }
  if (active[0] || active[1]) choose(y, u, active, s);

  while (path->n < SD_SLIDING_PIECES) {
    int which, stuck = s[0] == 0 ? 0 : y->n == 2 && s[1] == 0 ? 1 : -1, release = 0;
    double rate = stuck < 0 ? rate_of(y, s) : 0;
    double next = stuck < 0 ? slide_until(y, u, omega, s, &which)
                            : sliding_stuck_until(y, stuck, u, s, &release, &which);

    /* Adds this piece to the path. The net change of Omega is summed from the torques
     * themselves, so that nothing cancels near the root. */
    double length = next - u, after = omega + rate * length;
    double area = (omega + rate * length / 2) * length;
    if (stuck >= 0 || which >= 0) after = sliding_wave(y, stuck >= 0 ? stuck : which, next);
    if (stuck >= 0) area = sliding_turned(y, stuck, u, next);
    path->piece[path->n++] = (sliding_piece){u, omega, rate, {s[0], y->n == 2 ? s[1] : s[0]}};
    path->change += stuck < 0 ? rate * length : after - omega;
    path->turned += area;
    if (stuck >= 0)
      path->stuck += length;
    else
      path->length[2 * (s[0] < 0) + (y->n == 2 ? s[1] < 0 : s[0] < 0)] += length;

    u = next;
    omega = after;
    if (u >= y->end) return true;

    /* Finds the next signs of sliding: that of a contact that sticking has released is known;
     * contacts at equal velocities need `choose`. */
    if (release) {
      s[stuck] = release;
      continue;
    }
    for (int i = 0; i < y->n; i++)
      active[i] = i == which || i == stuck || fabs(sliding_wave(y, i, u) - omega) <= tiny;
    choose(y, u, active, s);
  }
  return false;
}

/* --- roots ------------------------------------------------------------------------------------ */

/* Arguments of `net`, the function whose root is sought. */
typedef struct task {
  const sliding_system *system;
  /* NULL: the function is the net change of Omega over a period; else [4] torques by
   * configuration, for the limit of constant Omega */
  const double *weight;
  bool failed;
} task;

/* Returns the net change of Omega over a period that begins with Omega = omega, or, if weights
 * are given, the net torque for constant Omega. */
static double net(double omega, void *argument) {
  task *t = argument;
  sliding_path path;
  if (!follow(t->system, omega, &path)) t->failed = true;
  if (!t->weight) return path.change;
  double sum = 0;
  for (int k = 0; k < 4; k++) sum += t->weight[k] * path.length[k];
  return sum;
}

/* Finds the root of the function `net`. The tolerance scales with the supports' largest
 * velocity, as rounding does, since near zero tilt the root itself is near zero. */
static bool solve(task *t, double *root) {
  const double most = 1.001 * t->system->peak;
  return sliding_root(net, t, -most, most, 1e-15 * t->system->peak, 0, root) && !t->failed;
}

/* --- public functions ------------------------------------------------------------------------- */

/* signs of sliding of contacts 1 and 2 in each configuration, SD_PP ... */
static const int signs[4][2] = {{1, 1}, {1, -1}, {-1, 1}, {-1, -1}};

static sd_status check(const sd_three_disk *disk, const sd_drive *drive, sd_messages *messages) {
  if (!(disk->half_aperture > 0 && disk->half_aperture < M_PI / 2))
    return sd_fail(messages, SD_ERROR_USER,
                   "theory: half aperture = %g: expected a value in (0, pi/2)",
                   disk->half_aperture);
  if (!(disk->mu > 0 && disk->weight > 0 && disk->radius > 0 && disk->inertia > 0))
    return sd_fail(messages, SD_ERROR_USER,
                   "theory: mu = %g, weight = %g, radius = %g, inertia = %g: expected values > 0",
                   disk->mu, disk->weight, disk->radius, disk->inertia);
  if (!(drive->omega > 0) || !(drive->amplitude[0] >= 0) || !(drive->amplitude[1] >= 0) ||
      !(drive->amplitude[0] + drive->amplitude[1] > 0) || !isfinite(drive->phase[0]) ||
      !isfinite(drive->phase[1]) || !(drive->support_radius[0] > 0) ||
      !(drive->support_radius[1] > 0))
    return sd_fail(messages, SD_ERROR_USER,
                   "theory: a drive needs a frequency > 0, finite phases, support radii > 0 and an "
                   "amplitude > 0");
  return SD_OK;
}

/* Checks the arguments and fills in *y, with the phase as time, and the torque in each
 * configuration. */
static sd_status prepare(const sd_three_disk *disk, const sd_drive *drive, sliding_system *y,
                         double torque[4], sd_messages *messages) {
  sd_status status = check(disk, drive, messages);
  if (status) return status;
  *y = (sliding_system){.waveform = drive->waveform, .end = 2 * M_PI};
  for (int i = 0; i < 2; i++) {
    y->amplitude[i] = drive->amplitude[i] * drive->support_radius[i] / disk->radius;
    y->phase[i] = remainder(drive->phase[i], 2 * M_PI);
    y->peak = fmax(y->peak, y->amplitude[i] * (drive->waveform == SD_SINE ? 1 : 4 / M_PI));
  }
  double apart = remainder(y->phase[0] - y->phase[1], 2 * M_PI);
  y->n = fabs(y->amplitude[0] - y->amplitude[1]) <= 1e-14 * y->peak && fabs(apart) <= 1e-14 ? 1 : 2;

  for (int k = 0; k < 4; k++) {
    bool needed = y->n == 2 || k == SD_PP || k == SD_MM;
    sd_tep tep = sd_tep_solve(disk, signs[k][0], signs[k][1]);
    torque[k] = sd_tep_torque(disk, signs[k][0], signs[k][1]);
    if (needed && !(tep.compressive && tep.stable))
      return sd_fail(
          messages, SD_ERROR_USER,
          "theory: configuration S%c%c has no stable equilibrium with both normal forces "
          "compressive (tilt %g, half aperture %g, mu %g)",
          signs[k][0] > 0 ? '+' : '-', signs[k][1] > 0 ? '+' : '-', disk->tilt, disk->half_aperture,
          disk->mu);
    y->rate[k >> 1][k & 1] = torque[k] / (disk->inertia * drive->omega * drive->omega);
  }
  return SD_OK;
}

sd_status sd_sliding_solve(const sd_three_disk *disk, const sd_drive *drive, sd_sliding *out,
                           sd_messages *messages) {
  sliding_system y;
  sliding_path path;
  double torque[4], root;
  sd_status status = prepare(disk, drive, &y, torque, messages);
  if (status) return status;
  task t = {.system = &y};
  if (!solve(&t, &root) || !follow(&y, root, &path))
    return sd_fail(messages, SD_ERROR_NUMERIC, "theory: no periodic solution was found");

  *out = (sd_sliding){.disk = *disk,
                      .drive = *drive,
                      .period = 2 * M_PI / drive->omega,
                      .mean = path.turned / (2 * M_PI) * drive->omega,
                      .stuck = path.stuck / drive->omega,
                      .permanent = path.stuck == 0,
                      .n_pieces = path.n};
  for (int k = 0; k < 4; k++) out->duration[k] = path.length[k] / drive->omega;
  for (size_t k = 0; k < path.n; k++) {
    const sliding_piece *p = &path.piece[k];
    out->pieces[k] = (sd_sliding_piece){p->start / drive->omega,
                                        p->omega * drive->omega,
                                        p->rate * drive->omega * drive->omega,
                                        {p->sign[0], p->sign[1]}};
  }
  return SD_OK;
}

sd_status sd_sliding_limit(const sd_three_disk *disk, const sd_drive *drive, double *mean,
                           sd_messages *messages) {
  sliding_system y;
  double torque[4], root;
  sd_status status = prepare(disk, drive, &y, torque, messages);
  if (status) return status;
  for (int k = 0; k < 4; k++) y.rate[k >> 1][k & 1] = 0;
  task t = {.system = &y, .weight = torque};
  if (!solve(&t, &root))
    return sd_fail(messages, SD_ERROR_NUMERIC, "theory: no balance of torques was found");
  *mean = root * drive->omega;
  return SD_OK;
}

double sd_sliding_support(const sd_three_disk *disk, const sd_drive *drive, int i, double t) {
  sliding_system y = {.waveform = drive->waveform, .n = 2};
  y.amplitude[i] = drive->amplitude[i] * drive->support_radius[i] / disk->radius;
  y.phase[i] = drive->phase[i];
  return sliding_wave(&y, i, drive->omega * t) * drive->omega;
}

double sd_sliding_angle(const sd_drive *drive, int i, double t) {
  sliding_system y = {.waveform = drive->waveform, .n = 2};
  y.amplitude[i] = drive->amplitude[i];
  y.phase[i] = drive->phase[i];
  /* the angle theta_i is 0 at phase 0 */
  return -sliding_turned(&y, i, -drive->phase[i], drive->omega * t);
}

double sd_sliding_omega(const sd_sliding *solution, double t) {
  double in = t - solution->period * floor(t / solution->period);
  size_t k = solution->n_pieces - 1;
  while (k > 0 && in < solution->pieces[k].start) k--;
  const sd_sliding_piece *p = &solution->pieces[k];
  for (int i = 0; i < 2; i++)
    if (p->sign[i] == 0) return sd_sliding_support(&solution->disk, &solution->drive, i, t);
  return p->omega + p->acceleration * (in - p->start);
}

/* The supports' velocities for the waveforms (20) and (21) of the paper, and the phases at which
 * Omega equals them.
 *
 * w = -amplitude cos(u + phase), or the triangle wave (22), -amplitude (4/pi)(1 - 2 |v|/pi) with v
 * = u + phase reduced to [-pi, pi]. Both are odd about their zeros and have their extrema at
 * multiples of pi.
 */

double sliding_wave(const sliding_system *y, int i, double u) {
  double v = u + y->phase[i];
  if (y->waveform == SD_SINE) return -y->amplitude[i] * cos(v);
  return -y->amplitude[i] * (4 / M_PI) * (1 - 2 * fabs(remainder(v, 2 * M_PI)) / M_PI);
}

double sliding_slope(const sliding_system *y, int i, double u) {
  double v = u + y->phase[i];
  if (y->waveform == SD_SINE) return y->amplitude[i] * sin(v);
  /* at a corner of the triangle wave, the slope after the corner is returned, also if u was
   * rounded to just before it */
  double slope = y->amplitude[i] * 8 / (M_PI * M_PI), w = remainder(v + 1e-12, 2 * M_PI);
  return w >= 0 ? slope : -slope;
}

/* The integral of the velocity w_i from u to v is minus the angle that the support turns, times
 * R_i/R. */
double sliding_turned(const sliding_system *y, int i, double u, double v) {
  double angle[2], at[2] = {u + y->phase[i], v + y->phase[i]};
  for (int k = 0; k < 2; k++) {
    double r = remainder(at[k], 2 * M_PI);
    angle[k] = y->waveform == SD_SINE ? sin(r) : 4 / M_PI * (r - r * fabs(r) / M_PI);
  }
  return -y->amplitude[i] * (angle[1] - angle[0]);
}

/* Returns the first u' > u with u' + phase = v modulo 2 pi. */
static double next_at(double v, double phase, double u) {
  double from = u + 1e-12, first = v - phase;
  return first + 2 * M_PI * ceil((from - first) / (2 * M_PI));
}

/* --- meetings while sliding ------------------------------------------------------------------- */

/* Difference between the velocity of support i and an Omega that changes linearly from the value
 * omega at phase u. */
typedef struct gap {
  const sliding_system *y;
  int i;
  double u, omega, rate;
} gap;

static double gap_at(double u, void *argument) {
  const gap *g = argument;
  return sliding_wave(g->y, g->i, u) - (g->omega + g->rate * (u - g->u));
}

bool sliding_root(double (*of)(double, void *), void *with, double lower, double upper,
                  double least, double part, double *root) {
  gsl_function f = {of, with};
  bool found = false;
  *root = lower;
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
  if (!solver) memory_lacks(0);
  if (gsl_root_fsolver_set(solver, &f, lower, upper) == GSL_SUCCESS)
    for (int k = 0; k < 200 && !found; k++) {
      if (gsl_root_fsolver_iterate(solver) != GSL_SUCCESS) break;
      lower = gsl_root_fsolver_x_lower(solver);
      upper = gsl_root_fsolver_x_upper(solver);
      *root = gsl_root_fsolver_root(solver);
      found = upper - lower <= fmax(least, part * upper) || of(*root, with) == 0;
    }
  gsl_root_fsolver_free(solver);
  gsl_set_error_handler(handler);
  return found;
}

/* Returns the phase in [p, q] at which the velocity difference g is 0; it must be monotonic
 * there and change sign. */
static double root_between(gap *g, double p, double q) {
  const double fp = gap_at(p, g), fq = gap_at(q, g), rounding = 4e-16;
  double root;
  if (g->y->waveform == SD_PARABOLA || fp == 0 || fq == 0)
    /* exact for a linear velocity difference */
    return fp == fq ? p : p + (q - p) * (fp / (fp - fq));
  sliding_root(gap_at, g, p, q, rounding, rounding, &root);
  return root;
}

/* Finds the phases in (u, end) between which the velocity difference g is monotonic, in
 * ascending order; returns their number. */
static int corners_of(const gap *g, double end, double corner[8]) {
  double amplitude = g->y->amplitude[g->i], turn[2] = {0, M_PI};
  int n = 0;
  /* corners where the slope of the support's velocity equals `rate` */
  if (g->y->waveform == SD_SINE) {
    if (!(fabs(g->rate) < amplitude)) return 0;
    turn[0] = asin(g->rate / amplitude);
    turn[1] = M_PI - turn[0];
  }
  for (int k = 0; k < 2; k++)
    for (double at = next_at(turn[k], g->y->phase[g->i], g->u); at < end && n < 8; at += 2 * M_PI) {
      int place = n++;
      for (; place > 0 && corner[place - 1] > at; place--) corner[place] = corner[place - 1];
      corner[place] = at;
    }
  return n;
}

double sliding_meeting(const sliding_system *y, int i, double u, double omega, double rate, int s) {
  gap g = {y, i, u, omega, rate};
  double corner[8], from = u;
  int n = corners_of(&g, y->end, corner);
  for (int k = 0; k <= n; k++) {
    double to = k < n ? corner[k] : y->end;
    if (s * gap_at(to, &g) < 0) {
      /* A piece that starts where the velocities are equal has a difference of rounding size,
       * which may have the wrong sign. */
      if (s * gap_at(from, &g) <= 0) return from;
      return root_between(&g, from, to);
    }
    from = to;
  }
  return HUGE_VAL;
}

/* --- the end of sticking ---------------------------------------------------------------------- */

/* Returns the first phase after u at which the velocities w_i and w_j of the supports are equal
 * again; HUGE_VAL: none within a period. */
static double supports_meet(const sliding_system *y, int i, int j, double u) {
  if (y->waveform == SD_SINE) {
    /* w_j - w_i = |c| cos(u + arg c), c = a_i exp(i phase_i) - a_j exp(i phase_j) */
    double re = y->amplitude[i] * cos(y->phase[i]) - y->amplitude[j] * cos(y->phase[j]);
    double im = y->amplitude[i] * sin(y->phase[i]) - y->amplitude[j] * sin(y->phase[j]);
    double phase = atan2(im, re);
    return fmin(next_at(M_PI / 2, phase, u), next_at(-M_PI / 2, phase, u));
  }
  /* both velocities are linear between the corners of either wave */
  double from = u + 1e-12, limit = u + 2 * M_PI;
  double before = sliding_wave(y, j, from) - sliding_wave(y, i, from);
  while (from < limit) {
    double to = limit;
    for (int k = 0; k < 4; k++) to = fmin(to, next_at(k & 1 ? M_PI : 0, y->phase[k >> 1], from));
    double after = sliding_wave(y, j, to) - sliding_wave(y, i, to);
    if (after == 0) return to;
    if (before * after < 0) return from + (to - from) * (before / (before - after));
    from = to;
    before = after;
  }
  return HUGE_VAL;
}

/* Returns the first phase after u at which the slope of w_i leaves [low, high]; *release: sign
 * with which the contact then slides. */
static double outruns(const sliding_system *y, int i, double u, double low, double high,
                      int *release) {
  double a = y->amplitude[i], plus = HUGE_VAL, minus = HUGE_VAL;
  if (y->waveform == SD_SINE) {
    if (fabs(high) < a) plus = next_at(asin(high / a), y->phase[i], u);
    if (fabs(low) < a) minus = next_at(M_PI - asin(low / a), y->phase[i], u);
  } else {
    double slope = 8 * a / (M_PI * M_PI);
    if (slope > high) plus = next_at(0, y->phase[i], u);
    if (-slope < low) minus = next_at(M_PI, y->phase[i], u);
  }
  *release = plus < minus ? 1 : -1;
  return fmin(plus, minus);
}

double sliding_stuck_until(const sliding_system *y, int i, double u, const int s[2], int *release,
                           int *which) {
  int j = 1 - i;
  bool both = y->n == 2;
  double high = both ? (i == 0 ? y->rate[0][s[1] < 0] : y->rate[s[0] < 0][0]) : y->rate[0][0];
  double low = both ? (i == 0 ? y->rate[1][s[1] < 0] : y->rate[s[0] < 0][1]) : y->rate[1][1];
  double next = outruns(y, i, u, low, high, release),
         meet = both ? supports_meet(y, i, j, u) : HUGE_VAL;
  *which = -1;
  if (meet < next) {
    next = meet;
    *release = 0;
    *which = j;
  }
  if (next >= y->end) {
    next = y->end;
    *release = 0;
    *which = -1;
  }
  return next;
}
