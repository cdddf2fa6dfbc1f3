/* sliding.h: the upper disk that slides on two turning supports: its motion over one period, and
 * the velocities of the supports. Time is the phase u = w_b t, angular velocities are in units
 * of w_b. */
#ifndef SLIPDISK_THEORY_SLIDING_H
#define SLIPDISK_THEORY_SLIDING_H

#include "slipdisk/theory.h"

/* The supports and torques of a problem; w_i is the angular velocity at which support i would
 * roll the disk. */
typedef struct sliding_system {
  sd_waveform waveform;
  int n;               /* number of contacts; 1 if both supports move alike */
  double amplitude[2]; /* angle amplitude of support i, scaled to the upper disk: Theta_b R_i/R */
  double phase[2];     /* phase of support i, rad, within [-pi, pi] */
  double rate[2][2];   /* torque/(I w_b^2), by signs of sliding [s_1 < 0][s_2 < 0] */
  double peak;         /* largest |w_i| of both supports */
  double end;          /* end of the period, 2 pi */
} sliding_system;

/* A piece of the path between two changes of sliding: Omega = omega + rate (u - start), signs of
 * sliding; a sign 0: the disk rolls with that support. */
typedef struct sliding_piece {
  double start, omega, rate;
  int sign[2];
} sliding_piece;

/* The path over one period. */
typedef struct sliding_path {
  double change;    /* net change of Omega */
  double turned;    /* angle turned: integral of Omega over u */
  double length[4]; /* total phase of each configuration, by SD_PP ... */
  double stuck;     /* total phase in which a contact sticks */
  size_t n;
  sliding_piece piece[SD_SLIDING_PIECES];
} sliding_path;

/* Velocity w_i of support i at phase u, its slope just after u, and its integral from u to v. */
double sliding_wave(const sliding_system *y, int i, double u);
double sliding_slope(const sliding_system *y, int i, double u);
double sliding_turned(const sliding_system *y, int i, double u, double v);

/* Returns the first phase u' after u at which w_i - (omega + rate (u' - u)), which has the sign
 * s just after u, changes sign; HUGE_VAL: not before y->end. */
double sliding_meeting(const sliding_system *y, int i, double u, double omega, double rate, int s);

/* Finds a root of `of(x, with)` in [lower, upper], at whose ends its signs differ, by Brent's
 * method, to an error of max(least, part * root). False: this was not achieved. */
bool sliding_root(double (*of)(double, void *), void *with, double lower, double upper,
                  double least, double part, double *root);

/* Returns the end of a piece in which contact i sticks and the other contact has the sign
 * s[1-i]. *release is the sign with which i slides on if w_i changes faster than the torques
 * allow; 0 if the other contact's velocity is met (*which is its number) or the period ends
 * (*which is -1). */
double sliding_stuck_until(const sliding_system *y, int i, double u, const int s[2], int *release,
                           int *which);

#endif
