/* closed.c: mean rotation in closed form for supports of equal radius that turn in or out of phase.
 *
 * In phase only S++ (for a fraction f of the period) and S-- occur, and the torques must cancel over a
 * period: f = -T--/(T++ - T--) = (1 - mu tan theta_T)/2, whatever the waveform. The rest is where on the
 * support's velocity two points lie that are so far apart and as different as S-- makes Omega.
 */
#include <math.h>

#include "slipdisk/theory.h"

sd_sync sd_sync_parabola(const sd_three_disk *disk, double amplitude, double omega) {
  double plus = sd_tep_torque(disk, 1, 1), minus = sd_tep_torque(disk, -1, -1);
  double period = 2 * M_PI / omega;
  /* 4 m R^2 of the print is 8 I of a disk */
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

/* Omega is linear between its two meetings with the support, so its mean is that of the two: with u_c the
 * middle of S-- and h = pi (1 - f) half its length in phase, the support's velocities there are
 * -cos(u_c -+ h); their difference fixes sin u_c = q, their mean is -cos(u_c) cos(h). */
double sd_sync_mean_sine(const sd_three_disk *disk, double amplitude, double omega) {
  double plus = sd_tep_torque(disk, 1, 1), minus = sd_tep_torque(disk, -1, -1);
  double rate = 1 / (disk->inertia * amplitude * omega * omega); /* of Omega/(Theta_b w_b) in phase */
  double h = M_PI * plus / (plus - minus), q = rate * minus * h / sin(h);
  if (!(fabs(q) < 1)) return NAN;

  /* the support must be the faster changing one at both meetings, else the contact sticks */
  double centre = asin(q), first = sin(centre - h), second = sin(centre + h);
  if (!(first < rate * minus && second > rate * plus)) return NAN;
  return -amplitude * omega * cos(centre) * cos(h);
}

double sd_async_first_order(const sd_three_disk *disk, double amplitude, double omega) {
  double mu2 = disk->mu * disk->mu, c = cos(disk->half_aperture);
  return omega / M_PI * 8 * disk->mu * (mu2 + 1) * amplitude * disk->tilt * c * c /
         ((mu2 + 1) * cos(2 * disk->half_aperture) + mu2 - 1);
}

/* Omega is constant and beyond both supports for a fraction x of the period, in S++ when it is negative and
 * S-- when positive; S+- and S-+ share the rest: T x + (T+- + T-+) (1 - x)/2 = 0. */
double sd_async_limit(const sd_three_disk *disk, sd_waveform waveform, double amplitude, double omega) {
  double mixed = sd_tep_torque(disk, 1, -1) + sd_tep_torque(disk, -1, 1);
  double torque = mixed < 0 ? sd_tep_torque(disk, 1, 1) : -sd_tep_torque(disk, -1, -1);
  double x = mixed / (2 * torque + fabs(mixed));
  return amplitude * omega * (waveform == SD_SINE ? sin(M_PI / 2 * x) : 4 / M_PI * x);
}

/* Without rotation supports that are a phase psi apart spend (1 - psi/pi)/2 of the period in each of S++, S--
 * and psi/(2 pi) in each of S+-, S-+; psi is where the torques cancel. */
double sd_reversal_phase(const sd_three_disk *disk) {
  double c = cos(disk->half_aperture), s = sin(disk->half_aperture), mu = disk->mu;
  return M_PI * (s - mu * c) * (s + mu * c);
}
