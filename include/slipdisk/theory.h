/* theory.h: mean rotation of the 3-disk ratchet, in closed form or to rounding, and closed forms
 * for tests.
 *
 * docs/physics.md derives each formula; numbers in parentheses are equations of the paper. Contact
 * 1 is that with the left support, contact 2 that with the right one. A sign s = +1 means a
 * positive (counter-clockwise) torque on the upper disk.
 */
#ifndef SLIPDISK_THEORY_H
#define SLIPDISK_THEORY_H

#include <stdbool.h>
#include <stddef.h>

#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Geometry and constants of the upper disk, which lies on two supports. */
typedef struct sd_three_disk {
  /* tilt theta_T = (alpha_2 - alpha_1)/2, rad; alpha_i: angle of contact i from the vertical */
  double tilt;
  /* half aperture theta_h = (alpha_2 + alpha_1)/2, rad, in (0, pi/2); alpha_i as for tilt */
  double half_aperture;
  double mu;      /* Amonton's coefficient of friction at both contacts */
  double weight;  /* weight m g of the upper disk, > 0 */
  double radius;  /* radius R of the upper disk */
  double inertia; /* moment of inertia I of the upper disk, > 0 */
} sd_three_disk;

/* Waveform of the rotation of a support: sine, (20) of the paper, or parabolic half waves, (21). */
typedef enum sd_waveform { SD_SINE, SD_PARABOLA } sd_waveform;

/* --- translational equilibrium points (TEP) --------------------------------------------------- */

/* A translational equilibrium point (TEP): forces on the upper disk balance while both contacts
 * slide. */
typedef struct sd_tep {
  double normal[2]; /* normal forces at contacts 1 and 2; an equilibrium point needs both >= 0 */
  double torque;    /* torque on the upper disk */
  bool compressive; /* true if both normal forces are >= 0 */
  /* true: the centre returns to the point; false only for S-+ with mu > tan theta_h */
  bool stable;
} sd_tep;

/* Solves the force balance (13)-(14) of the paper with tau_i = s_i mu n_i as a 2x2 linear
 * system; s1, s2 are -1, 0 or +1. If it has no solution (s1 = -1, s2 = +1, tan theta_h = mu)
 * forces and torque are NAN, and the point is neither compressive nor stable. */
SD_API sd_tep sd_tep_solve(const sd_three_disk *disk, int s1, int s2);

/* Returns the torque at a translational equilibrium point in closed form: (15)-(18) of the paper
 * for s_i = +1 or -1, and their generalisation for s_i = 0. */
SD_API double sd_tep_torque(const sd_three_disk *disk, int s1, int s2);

/* Returns the mean torque just after tilting if all four configurations last equally long: (19)
 * of the paper, as printed. */
SD_API double sd_slight_tilt_torque(const sd_three_disk *disk);
/* Returns the mean torque just after tilting for supports in phase, with the configurations S++
 * and S-- only: (31) of the paper, with mu^2 where the print has mu. */
SD_API double sd_slight_tilt_torque_sync(const sd_three_disk *disk);

/* --- closed forms for supports of the upper disk's radius that turn by Theta_b sin(w_b t) ----- */

/* Periodic state for supports in phase with the parabolic waveform, (21) of the paper. It holds
 * while both torques are below 8 I Theta_b w_b^2/pi^2. */
typedef struct sd_sync {
  double t1, t2;  /* times at which S-- and S++ begin, (25) and (43) of the paper */
  double pp, mm;  /* durations of S++ and S-- in a period, (26) and (27) of the paper */
  double mean;    /* mean angular velocity of the upper disk, (29) of the paper */
  bool permanent; /* true: the contacts never stick, so that the formulas hold */
} sd_sync;
/* Returns the periodic state for supports in phase with the parabolic waveform. amplitude:
 * Theta_b, rad; omega: w_b, rad/time. */
SD_API sd_sync sd_sync_parabola(const sd_three_disk *disk, double amplitude, double omega);

/* Returns the mean angular velocity for supports in phase with the parabolic waveform, (30) of
 * the paper: (4/pi) mu Theta_b w_b tan theta_T. */
SD_API double sd_sync_mean_parabola(const sd_three_disk *disk, double amplitude, double omega);
/* Returns the mean angular velocity for supports in phase with the sine waveform, (20) of the
 * paper, in the limit Theta_b -> infinity: Theta_b w_b sin((pi/2) mu tan theta_T). */
SD_API double sd_sync_limit_sine(const sd_three_disk *disk, double amplitude, double omega);
/* Returns the mean angular velocity for supports in phase with the sine waveform at any amplitude;
 * NAN: there is no periodic state of permanent sliding. */
SD_API double sd_sync_mean_sine(const sd_three_disk *disk, double amplitude, double omega);

/* Returns the mean angular velocity for supports in opposite phases with the parabolic waveform,
 * to first order in theta_T: (35) of the paper, with the factor w_b/pi that the print lacks. */
SD_API double sd_async_first_order(const sd_three_disk *disk, double amplitude, double omega);
/* Returns the mean angular velocity for supports in opposite phases at any tilt, in the limit
 * Theta_b -> infinity. */
SD_API double sd_async_limit(const sd_three_disk *disk, sd_waveform waveform, double amplitude,
                             double omega);

/* Returns the phase difference between equal supports, rad, at which the sense of rotation reverses
 * in the limit Theta_b -> infinity: pi (sin^2 theta_h - mu^2 cos^2 theta_h), for any waveform and
 * tilt. */
SD_API double sd_reversal_phase(const sd_three_disk *disk);

/* --- periodic state for any phase and either waveform ----------------------------------------- */

/* Rotation of the supports: theta_i(t) = amplitude_i f(omega t + phase_i), with f the sine, (20)
 * of the paper, or parabolas, (21). */
typedef struct sd_drive {
  sd_waveform waveform;     /* form f of the rotation as a function of the phase */
  double omega;             /* angular frequency w_b of both supports, rad/time, > 0 */
  double amplitude[2];      /* amplitude Theta_b of each support, rad, >= 0 */
  double phase[2];          /* phase of each support, rad */
  double support_radius[2]; /* radius of each support disk, > 0 */
} sd_drive;

/* Largest number of intervals in `pieces` of sd_sliding. */
enum { SD_SLIDING_PIECES = 32 };
/* Configurations S++, S+-, S-+, S-- as indices: signs of sliding of contacts 1 and 2. */
enum { SD_PP = 0, SD_PM = 1, SD_MP = 2, SD_MM = 3 };

/* An interval in which the angular velocity of the upper disk is linear: Omega(t) = omega +
 * acceleration (t - start), until the next interval starts. If sign[i] is 0 the upper disk rolls
 * on support i instead: Omega = sd_sliding_support(). */
typedef struct sd_sliding_piece {
  double start, omega, acceleration; /* start time of the interval; Omega at that time; dOmega/dt */
  int sign[2];                       /* sign of sliding of each contact; 0: the contact sticks */
} sd_sliding_piece;

/* Periodic solution for the rotation of the upper disk. */
typedef struct sd_sliding {
  sd_three_disk disk;  /* the upper disk to which the solution belongs */
  sd_drive drive;      /* the rotation of the supports to which the solution belongs */
  double period, mean; /* period; mean angular velocity of the upper disk */
  /* time per period in each configuration, indexed by SD_PP, SD_PM, SD_MP, SD_MM */
  double duration[4];
  /* Time per period in which a contact sticks; > 0: the drive is too weak for permanent sliding */
  double stuck;
  /* true if stuck == 0: the solution satisfies the velocity-matching equations of the paper */
  bool permanent;
  size_t n_pieces; /* number of intervals in `pieces` */
  /* intervals of one period [0, period); the first starts at 0 */
  sd_sliding_piece pieces[SD_SLIDING_PIECES];
} sd_sliding;

/* Finds the periodic solution of I dOmega/dt = T, with T the torque of the translational
 * equilibrium point (TEP) for the present signs of sliding: (23)-(24), (32)-(33) of the paper
 * and their generalisation to other phases. If a torque accelerates the upper disk faster than a
 * support, the contact sticks (Coulomb friction with a rigid tangential spring). Returns
 * SD_ERROR_USER for values out of range, or if a configuration has no compressive, stable TEP;
 * SD_ERROR_NUMERIC if no root was found. */
SD_API sd_status sd_sliding_solve(const sd_three_disk *disk, const sd_drive *drive, sd_sliding *out,
                                  sd_messages *messages);

/* Finds the mean angular velocity in the limit torque/(I Theta_b w_b^2) -> 0, in which Omega is
 * constant and the durations of the four configurations balance the torques. Errors are those of
 * sd_sliding_solve. */
SD_API sd_status sd_sliding_limit(const sd_three_disk *disk, const sd_drive *drive, double *mean,
                                  sd_messages *messages);

/* Returns the angular velocity Omega of the upper disk at any time t of a periodic solution. */
SD_API double sd_sliding_omega(const sd_sliding *solution, double t);

/* Returns the angular velocity at which the upper disk would roll on support i (0 or 1):
 * -theta_i'(t) R_i/R. */
SD_API double sd_sliding_support(const sd_three_disk *disk, const sd_drive *drive, int i, double t);

/* Returns the angle theta_i(t) of support i (0 or 1), (20) or (21) of the paper, rad. */
SD_API double sd_sliding_angle(const sd_drive *drive, int i, double t);

/* --- closed forms that tests compare with ----------------------------------------------------- */

/* Outcome of a head-on collision. */
typedef struct sd_collision {
  /* coefficient of restitution: speed after divided by speed before the collision */
  double restitution;
  double duration; /* duration of the contact, until the normal force is 0 */
} sd_collision;

/* Returns the outcome of a head-on collision with the normal force (2) of the paper. Arguments:
 * k_n > 0, gamma_n >= 0, m_eff > 0; overdamped contacts are allowed. */
SD_API sd_collision sd_restitution(double k_n, double gamma_n, double m_eff);

/* Outcome of the collision of a disk with a plane, if the surface of the disk slides all the
 * time. */
typedef struct sd_oblique {
  /* velocities after the collision: normal, > 0 away from the plane; tangential; angular */
  double v_n, v_t, spin;
  bool sliding; /* true: the surface never stopped sliding, so that the formula holds */
} sd_oblique;
/* Returns the outcome of the collision of a sliding disk with a plane. Before the collision v_n > 0
 * is the speed of approach, v_t the velocity of the centre along the tangent, and v_t + radius spin
 * the velocity of the surface. */
SD_API sd_oblique sd_gross_sliding(double mass, double inertia, double radius, double mu,
                                   double restitution, double v_n, double v_t, double spin);

/* Writes the time after which a disk rolls that is put on a plane with the speed u and without
 * spin, and the speed of the disk at that time. */
SD_API void sd_slide_to_roll(double mass, double inertia, double radius, double mu, double g,
                             double u, double *time, double *speed);

/* Writes the stationary covariances of the random vibration, (52) of the paper, at a lag t >= 0:
 * c[0] = <x(0) x(t)>, c[1] = <x(0) x'(t)> = -<x'(0) x(t)>, c[2] = <x'(0) x'(t)>. omega, damping
 * > 0; overdamped oscillators are allowed. */
SD_API void sd_vibration_covariance(double omega, double damping, double rms, double lag,
                                    double c[3]);

#ifdef __cplusplus
}
#endif

#endif
