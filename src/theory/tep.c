/* tep.c: torques at the translational equilibrium points, (13)-(19) and (31).
 *
 * With both contacts sliding, tau_i = s_i mu n_i, the centre is in equilibrium for one pair (n_1, n_2).
 * In terms of friction angles phi_i = s_i atan(mu) the contact force F_i = n_i/cos(phi_i) leans away from
 * its normal by phi_i, and the balance of two forces and a weight is the law of sines:
 *   F_1 = m g sin(alpha_2 - phi_2)/D,  F_2 = m g sin(alpha_1 + phi_1)/D,
 *   D = sin(alpha_1 + alpha_2 + phi_1 - phi_2),  torque = R (F_1 sin phi_1 + F_2 sin phi_2).
 * (15)-(18) are this for phi_i = +-phi.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>

#include "slipdisk/theory.h"

sd_tep sd_tep_solve(const sd_three_disk *disk, int s1, int s2) {
  sd_tep tep = {.normal = {NAN, NAN}, .torque = NAN};
  double a1 = disk->half_aperture - disk->tilt, a2 = disk->half_aperture + disk->tilt;
  double m1 = s1 * disk->mu, m2 = s2 * disk->mu;

  /* rows: forces along x and y; columns: n_1 and n_2 */
  double a[4] = {sin(a1) + m1 * cos(a1), -sin(a2) + m2 * cos(a2), cos(a1) - m1 * sin(a1),
                 cos(a2) + m2 * sin(a2)};
  double b[2] = {0, disk->weight}, n[2];

  /* equal springs along the contact lines push back along the columns: their stiffness matrix has the sign
   * of this determinant times sin(2 theta_h), and a positive trace */
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
  if (s1 == s2) /* (15), (16) */
    return scale * sin(s1 * phi) * cos(tilt - s1 * phi) / cos(half);
  if (s1 == -s2) /* (17), (18) */
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

/* The print of (31) has mu where the half sum of (15) and (16) has mu^2. */
double sd_slight_tilt_torque_sync(const sd_three_disk *disk) {
  double mu = disk->mu;
  return disk->weight * disk->radius * mu * mu * sin(disk->tilt) / ((1 + mu * mu) * cos(disk->half_aperture));
}
