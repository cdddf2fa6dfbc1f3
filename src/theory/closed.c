/* closed.c: closed forms: mean rotation, torques at the equilibrium points, single collisions,
 * random vibration. Numbers in parentheses are equations of the paper. The first part is the mean
 * rotation for supports of equal radius that turn in phase or in opposite phase.
 *
 * In phase only two configurations occur: S++, in which both contacts slide with positive torque,
 * for a fraction f of the period, and S--. Their torques must cancel over a period: f = -T--/(T++ -
 * T--) = (1 - mu tan theta_T)/2, whatever the waveform. It remains to find two points of the
 * support's velocity curve that are as far apart in time as S-- lasts and whose velocities differ
 * by the change of Omega during S--.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>

#include "slipdisk/theory.h"

sd_sync sd_sync_parabola(const sd_three_disk *disk, double amplitude, double omega) {
  double plus = sd_tep_torque(disk, 1, 1), minus = sd_tep_torque(disk, -1, -1);
  double period = 2 * M_PI / omega;
  /* 4 m R^2 in the paper equals 8 I, with I = m R^2/2 of a disk */
  double drive = 8 * disk->inertia * amplitude * omega * omega;
  double scale = M_PI * plus / (drive * (plus - minus) * omega);
  return (sd_sync){
      .t1 = scale * (M_PI * M_PI * minus - drive),
      .t2 = scale * (M_PI * M_PI * minus + drive),
      .pp = -minus / (plus - minus) * period,
      .mm = plus / (plus - minus) * period,
      .mean = 4 * amplitude * omega / M_PI * (plus + minus) / (plus - minus),
      .permanent = fmax(plus, -minus) * M_PI * M_PI < drive,
  };
}

double sd_sync_mean_parabola(const sd_three_disk *disk, double amplitude, double omega) {
  return 4 / M_PI * disk->mu * amplitude * omega * tan(disk->tilt);
}

double sd_sync_limit_sine(const sd_three_disk *disk, double amplitude, double omega) {
  return amplitude * omega * sin(M_PI / 2 * disk->mu * tan(disk->tilt));
}

/* Omega changes linearly between the two phases of the support at which Omega equals the
 * support's velocity, so the mean of Omega is the mean of these two velocities. With u_c the
 * middle of S-- and h = pi (1 - f) half its length, both as phases, the velocities are -cos(u_c
 * -+ h); their difference gives sin u_c = q, their mean is -cos(u_c) cos(h). */
double sd_sync_mean_sine(const sd_three_disk *disk, double amplitude, double omega) {
  double plus = sd_tep_torque(disk, 1, 1), minus = sd_tep_torque(disk, -1, -1);
  /* change of Omega/(Theta_b w_b) per unit torque and unit phase */
  double rate = 1 / (disk->inertia * amplitude * omega * omega);
  double h = M_PI * plus / (plus - minus), q = rate * minus * h / sin(h);
  if (!(fabs(q) < 1)) return NAN;

  /* At both phases where Omega equals the support's velocity, the support's velocity must change
   * faster than Omega, else the contact sticks. */
  double centre = asin(q), first = sin(centre - h), second = sin(centre + h);
  if (!(first < rate * minus && second > rate * plus)) return NAN;
  return -amplitude * omega * cos(centre) * cos(h);
}

double sd_async_first_order(const sd_three_disk *disk, double amplitude, double omega) {
  double mu2 = disk->mu * disk->mu, c = cos(disk->half_aperture);
  return omega / M_PI * 8 * disk->mu * (mu2 + 1) * amplitude * disk->tilt * c * c /
         ((mu2 + 1) * cos(2 * disk->half_aperture) + mu2 - 1);
}

/* Omega is constant in this limit. For a fraction x of the period Omega is above both supports'
 * velocities (in S--, if Omega is positive) or below both (in S++, if negative); S+- and S-+
 * share the rest of the period equally: T x + (T+- + T-+) (1 - x)/2 = 0. */
double sd_async_limit(const sd_three_disk *disk, sd_waveform waveform, double amplitude,
                      double omega) {
  double mixed = sd_tep_torque(disk, 1, -1) + sd_tep_torque(disk, -1, 1);
  double torque = mixed < 0 ? sd_tep_torque(disk, 1, 1) : -sd_tep_torque(disk, -1, -1);
  double x = mixed / (2 * torque + fabs(mixed));
  return amplitude * omega * (waveform == SD_SINE ? sin(M_PI / 2 * x) : 4 / M_PI * x);
}

/* Without rotation of the disk, supports with a phase difference psi spend (1 - psi/pi)/2 of the
 * period in each of S++ and S--, and psi/(2 pi) in each of S+- and S-+; the returned psi is that
 * at which the mean torque vanishes. */
double sd_reversal_phase(const sd_three_disk *disk) {
  double c = cos(disk->half_aperture), s = sin(disk->half_aperture), mu = disk->mu;
  return M_PI * (s - mu * c) * (s + mu * c);
}

/* Torques at the translational equilibrium points, (13)-(19) and (31) of the paper.
 *
 * If both contacts slide, tau_i = s_i mu n_i, the centre is in equilibrium for one pair (n_1, n_2).
 * With friction angles phi_i = s_i atan(mu) the contact force F_i = n_i/cos(phi_i) is inclined to
 * its normal by phi_i, and the balance of two forces and a weight is the law of sines:
 *
 *   F_1 = m g sin(alpha_2 - phi_2)/D,  F_2 = m g sin(alpha_1 + phi_1)/D,
 *   D = sin(alpha_1 + alpha_2 + phi_1 - phi_2),  torque = R (F_1 sin phi_1 + F_2 sin phi_2).
 *
 * Equations (15)-(18) are the special cases phi_i = +-phi.
 */

sd_tep sd_tep_solve(const sd_three_disk *disk, int s1, int s2) {
  sd_tep tep = {.normal = {NAN, NAN}, .torque = NAN};
  double a1 = disk->half_aperture - disk->tilt, a2 = disk->half_aperture + disk->tilt;
  double m1 = s1 * disk->mu, m2 = s2 * disk->mu;

  /* rows: x and y components of the force; columns: coefficients of n_1 and n_2 */
  double a[4] = {sin(a1) + m1 * cos(a1), -sin(a2) + m2 * cos(a2), cos(a1) - m1 * sin(a1),
                 cos(a2) + m2 * sin(a2)};
  double b[2] = {0, disk->weight}, n[2];

  /* Equal springs along the contact normals push back along the columns of this matrix: the
   * stiffness matrix of the springs has a positive trace, and its determinant has the sign of
   * the determinant of `a` times sin(2 theta_h). */
  bool stable = a[0] * a[3] - a[1] * a[2] > 0;
  size_t order[2];
  gsl_matrix_view matrix = gsl_matrix_view_array(a, 2, 2);
  gsl_vector_view right = gsl_vector_view_array(b, 2), unknown = gsl_vector_view_array(n, 2);
  gsl_permutation permutation = {.size = 2, .data = order};
  int sign;

  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  int failed = gsl_linalg_LU_decomp(&matrix.matrix, &permutation, &sign) ||
               gsl_linalg_LU_solve(&matrix.matrix, &permutation, &right.vector, &unknown.vector);
  gsl_set_error_handler(handler);
  if (failed || !isfinite(n[0]) || !isfinite(n[1])) return tep;

  tep.normal[0] = n[0];
  tep.normal[1] = n[1];
  tep.torque = disk->radius * (m1 * n[0] + m2 * n[1]);
  tep.compressive = n[0] >= 0 && n[1] >= 0;
  tep.stable = stable;
  return tep;
}

double sd_tep_torque(const sd_three_disk *disk, int s1, int s2) {
  double phi = atan(disk->mu), scale = disk->weight * disk->radius;
  double tilt = disk->tilt, half = disk->half_aperture;
  if (s1 == s2) /* equal signs: eqs. (15), (16) of the paper */
    return scale * sin(s1 * phi) * cos(tilt - s1 * phi) / cos(half);
  if (s1 == -s2) /* opposite signs: eqs. (17), (18) of the paper */
    return scale * sin(phi) * sin(tilt) * s1 / sin(half + s1 * phi);
  double phi1 = s1 * phi, phi2 = s2 * phi;
  return scale * (sin(half + tilt - phi2) * sin(phi1) + sin(half - tilt + phi1) * sin(phi2)) /
         sin(2 * half + phi1 - phi2);
}

double sd_slight_tilt_torque(const sd_three_disk *disk) {
  double mu2 = disk->mu * disk->mu, c = cos(disk->half_aperture), t = tan(disk->half_aperture);
  return disk->weight * disk->radius * mu2 * (mu2 + (1 + mu2) * cos(2 * disk->half_aperture)) *
         sin(disk->tilt) / (c * c * c * 2 * (1 + mu2) * (mu2 - t * t));
}

/* The paper's (31) has mu where the mean of (15) and (16) has mu^2. */
double sd_slight_tilt_torque_sync(const sd_three_disk *disk) {
  double mu = disk->mu;
  return disk->weight * disk->radius * mu * mu * sin(disk->tilt) /
         ((1 + mu * mu) * cos(disk->half_aperture));
}

/* --- closed forms of single collisions, for tests --------------------------------------------- */

/* The normal force (2) of the paper vanishes when tan(w t) = -2 b w/(w^2 - b^2), b = gamma_n/(2
 * m), w^2 = k_n/m - b^2. As 2 b w/(w^2 - b^2) = tan(2 atan(b/w)), t_c = (pi - 2 atan(b/w))/w =
 * (2/w) atan(w/b) on every branch; the speed is then exp(-b t_c) times the initial one. Above
 * critical damping w = i v, and atan becomes atanh. */
sd_collision sd_restitution(double k_n, double gamma_n, double m_eff) {
  double b = gamma_n / (2 * m_eff), w0 = sqrt(k_n / m_eff), t;
  if (b < w0) {
    double w = sqrt((w0 - b) * (w0 + b));
    t = 2 * atan2(w, b) / w;
  } else if (b == w0) {
    t = 2 / b;
  } else {
    /* atanh(v/b) = ln((b + v)/w0): the logarithm has no cancellation as v -> b, atanh none as v
     * -> 0 */
    double v = sqrt((b - w0) * (b + w0));
    t = 2 * (v < b / 2 ? atanh(v / b) : log((b + v) / w0)) / v;
  }
  return (sd_collision){.restitution = exp(-b * t), .duration = t};
}

sd_oblique sd_gross_sliding(double mass, double inertia, double radius, double mu,
                            double restitution, double v_n, double v_t, double spin) {
  double surface = v_t + radius * spin, sense = surface < 0 ? -1 : 1;
  double impulse = mu * mass * (1 + restitution) * v_n; /* impulse of the friction force */
  sd_oblique after = {
      .v_n = restitution * v_n,
      .v_t = v_t - sense * impulse / mass,
      .spin = spin - sense * impulse * radius / inertia,
  };
  after.sliding = sense * (after.v_t + radius * after.spin) >= 0;
  return after;
}

/* Friction mu m g decelerates the centre and spins the disk up until v = R spin (I = m R^2/2: t
 * = u/(3 mu g)). */
void sd_slide_to_roll(double mass, double inertia, double radius, double mu, double g, double u,
                      double *time, double *speed) {
  double ratio = mass * radius * radius / inertia;
  *time = u / (mu * g * (1 + ratio));
  *speed = u * ratio / (1 + ratio);
}

/* Stationary covariances of the random vibration, (52) of the paper,
 *
 *   x'' + 2 c w x' + w^2 x = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t').
 *
 * By the regression theorem <x(0) x(t)>/rms^2 = exp(-c w t) (C + c w S) with C = cos(w1 t), S =
 * sin(w1 t)/w1, w1^2 = w^2 (1 - c^2); the other covariances are its derivatives. C and S are entire
 * functions of w1^2: cosh and sinh above critical damping, 1 and t at it.
 */

/* Computes exp(-g t) C and exp(-g t) S in the covariances above, with g = damping * omega. */
static void decaying(double omega, double damping, double t, double *c, double *s) {
  double g = damping * omega, d = omega * omega * (1 - damping) * (1 + damping), z = d * t * t;
  if (fabs(z) < 1e-3) { /* power series to z^5: its error 1e-15 z^6/12! is far below rounding */
    double envelope = exp(-g * t), even = 1, odd = 1, ce = 1, so = 1;
    for (int k = 1; k <= 5; k++) {
      even *= -z / ((2 * k - 1) * (2 * k));
      odd *= -z / ((2 * k) * (2 * k + 1));
      ce += even;
      so += odd;
    }
    *c = envelope * ce;
    *s = envelope * so * t;
  } else if (d > 0) {
    double w1 = sqrt(d), envelope = exp(-g * t);
    *c = envelope * cos(w1 * t);
    *s = envelope * sin(w1 * t) / w1;
  } else {
    /* the slow exponent g - w1 = w^2/(g + w1) is computed without cancellation, and nothing
     * overflows */
    double w1 = sqrt(-d), slow = exp(-omega * omega / (g + w1) * t), gone = exp(-2 * w1 * t);
    *c = slow * (1 + gone) / 2;
    *s = slow * (1 - gone) / (2 * w1);
  }
}

void sd_vibration_covariance(double omega, double damping, double rms, double lag, double c[3]) {
  double even, odd, variance = rms * rms, g = damping * omega;
  decaying(omega, damping, lag, &even, &odd);
  c[0] = variance * (even + g * odd);
  c[1] = -variance * omega * omega * odd;
  c[2] = variance * omega * omega * (even - g * odd);
}
