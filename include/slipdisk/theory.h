/* theory.h: what the 3-disk ratchet does in closed form or to rounding, and closed forms for tests.
 *
 * docs/physics.md derives each formula; equation labels are the paper's. Contact 1 is the left support,
 * contact 2 the right one; a sign s = +1 means a positive (counter-clockwise) torque on the upper disk.
 */
#ifndef SLIPDISK_THEORY_H
#define SLIPDISK_THEORY_H

#include <stdbool.h>
#include <stddef.h>

#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The upper disk on its two supports. */
typedef struct sd_three_disk {
  double tilt;          /* theta_T = (alpha_2 - alpha_1)/2, rad */
  double half_aperture; /* theta_h = (alpha_2 + alpha_1)/2, rad, in (0, pi/2) */
  double mu;            /* Amonton's coefficient at both contacts */
  double weight;        /* m g, > 0 */
  double radius;        /* of the upper disk */
  double inertia;       /* of the upper disk, > 0 */
} sd_three_disk;

typedef enum sd_waveform { SD_SINE, SD_PARABOLA } sd_waveform; /* (20), (21) */

/* --- translational equilibrium points (TEP) ------------------------------------------------------- */

typedef struct sd_tep {
  double normal[2]; /* normal forces; a TEP needs both >= 0 */
  double torque;    /* on the upper disk */
  bool compressive;
  bool stable; /* the centre returns to it: only S-+ can fail, where mu > tan theta_h */
} sd_tep;

/* Force balance (13)-(14) with tau_i = s_i mu n_i, solved as a 2x2 linear system. s_i in {-1, 0, +1}.
 * Forces NAN, neither compressive nor stable when the balance has no solution (s1 = -1, s2 = +1, tan theta_h = mu). */
SD_API sd_tep sd_tep_solve(const sd_three_disk *disk, int s1, int s2);

/* The same torque in closed form: (15)-(18) for s_i = +-1, and their common parent for any s_i. */
SD_API double sd_tep_torque(const sd_three_disk *disk, int s1, int s2);

/* Mean torque just after tilting, all four configurations equally long (19), as printed. */
SD_API double sd_slight_tilt_torque(const sd_three_disk *disk);
/* The same with S++ and S-- only (31), supports in phase; with mu^2 where the print has mu. */
SD_API double sd_slight_tilt_torque_sync(const sd_three_disk *disk);

/* --- closed forms for supports of the upper disk's radius that turn by Theta_b sin(w_b t) ------------ */

/* Supports in phase, parabolic waveform (21). Valid while both torques are below 8 I Theta_b w_b^2/pi^2. */
typedef struct sd_sync {
  double t1, t2;  /* (25), (43): S-- begins, S++ begins */
  double pp, mm;  /* (26), (27): durations of S++ and S-- */
  double mean;    /* (29) */
  bool permanent; /* the contacts never stick: the formulas hold */
} sd_sync;
SD_API sd_sync sd_sync_parabola(const sd_three_disk *disk, double amplitude, double omega);

/* (30): the mean of the above, (4/pi) mu Theta_b w_b tan theta_T. */
SD_API double sd_sync_mean_parabola(const sd_three_disk *disk, double amplitude, double omega);
/* Sine waveform (20), Theta_b -> infinity: Theta_b w_b sin((pi/2) mu tan theta_T). */
SD_API double sd_sync_limit_sine(const sd_three_disk *disk, double amplitude, double omega);
/* Sine waveform at any amplitude; NAN where no periodic state of permanent sliding exists. */
SD_API double sd_sync_mean_sine(const sd_three_disk *disk, double amplitude, double omega);

/* (35) with the factor w_b/pi that the print lacks: opposite phases, parabola, first order in theta_T. */
SD_API double sd_async_first_order(const sd_three_disk *disk, double amplitude, double omega);
/* Opposite phases, any tilt, Theta_b -> infinity. */
SD_API double sd_async_limit(const sd_three_disk *disk, sd_waveform waveform, double amplitude,
                             double omega);

/* Phase between equal supports at which the sense of rotation turns over, Theta_b -> infinity:
 * pi (sin^2 theta_h - mu^2 cos^2 theta_h), whatever the waveform and the tilt. */
SD_API double sd_reversal_phase(const sd_three_disk *disk);

/* --- the periodic state for any phase, either waveform ----------------------------------------------- */

/* theta_i(t) = amplitude_i f(omega t + phase_i), f = sin (20) or its parabolas (21). */
typedef struct sd_drive {
  sd_waveform waveform;
  double omega;             /* w_b, > 0 */
  double amplitude[2];      /* Theta_b of each support, >= 0 */
  double phase[2];          /* rad */
  double support_radius[2]; /* > 0 */
} sd_drive;

enum { SD_SLIDING_PIECES = 32 };
enum { SD_PP = 0, SD_PM = 1, SD_MP = 2, SD_MM = 3 }; /* S++, S+-, S-+, S-- */

/* Omega(t) = omega + acceleration (t - start) until the next piece starts; in a piece with a sign 0 the
 * upper disk rolls with that support instead, Omega = sd_sliding_support(). */
typedef struct sd_sliding_piece {
  double start, omega, acceleration;
  int sign[2];
} sd_sliding_piece;

typedef struct sd_sliding {
  sd_three_disk disk;
  sd_drive drive;
  double period, mean;
  double duration[4]; /* per period, by SD_PP ... */
  double stuck;       /* per period; > 0 when the drive is too weak for permanent sliding */
  bool permanent;     /* stuck == 0: a solution of the velocity-matching equations */
  size_t n_pieces;
  sd_sliding_piece pieces[SD_SLIDING_PIECES]; /* in [0, period), first at 0 */
} sd_sliding;

/* Periodic solution of I dOmega/dt = torque of the TEP of the current signs of sliding: (23)-(24), (32)-(33)
 * and what they become at other phases. Where a torque outruns a support the contact sticks (Coulomb friction
 * with a rigid tangential spring) instead. SD_ERROR_USER: values out of range, or a configuration without a compressive, stable TEP;
 * SD_ERROR_NUMERIC: no root was found. */
SD_API sd_status sd_sliding_solve(const sd_three_disk *disk, const sd_drive *drive, sd_sliding *out,
                                  sd_messages *messages);

/* Mean angular velocity for torque/(I Theta_b w_b^2) -> 0, in which Omega is constant and the four
 * durations balance the torques. Same errors. */
SD_API sd_status sd_sliding_limit(const sd_three_disk *disk, const sd_drive *drive, double *mean,
                                  sd_messages *messages);

/* Omega at any time t of the periodic solution. */
SD_API double sd_sliding_omega(const sd_sliding *solution, double t);

/* Angular velocity at which support i (0, 1) drives the upper disk: -theta_i'(t) R_i/R. */
SD_API double sd_sliding_support(const sd_three_disk *disk, const sd_drive *drive, int i, double t);

/* theta_i(t) itself, (20) or (21). */
SD_API double sd_sliding_angle(const sd_drive *drive, int i, double t);

/* --- closed forms that tests compare with ------------------------------------------------------------ */

typedef struct sd_collision {
  double restitution; /* speed after / before */
  double duration;    /* until the normal force is zero */
} sd_collision;

/* Head-on collision under (2). k_n, m_eff > 0, gamma_n >= 0; any damping. */
SD_API sd_collision sd_restitution(double k_n, double gamma_n, double m_eff);

/* Disk that hits a plane and slides all through the collision. v_n > 0: speed of approach; v_t: velocity
 * of the centre along the tangent; spin: such that v_t + radius spin is the surface's velocity. */
typedef struct sd_oblique {
  double v_n, v_t, spin; /* after; v_n > 0 away from the plane */
  bool sliding;          /* the surface never stopped: the formula holds */
} sd_oblique;
SD_API sd_oblique sd_gross_sliding(double mass, double inertia, double radius, double mu,
                                   double restitution, double v_n, double v_t, double spin);

/* Time after which a disk set down with speed u and no spin on a plane rolls, and its speed then. */
SD_API void sd_slide_to_roll(double mass, double inertia, double radius, double mu, double g,
                             double u, double *time, double *speed);

/* Stationary covariances of (52) at a lag >= 0: c[0] = <x(0) x(t)>, c[1] = <x(0) x'(t)> = -<x'(0) x(t)>,
 * c[2] = <x'(0) x'(t)>. omega, damping > 0; any damping. */
SD_API void sd_vibration_covariance(double omega, double damping, double rms, double lag,
                                    double c[3]);

#ifdef __cplusplus
}
#endif

#endif
