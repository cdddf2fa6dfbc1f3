/* sliding.h: the map of a sliding disk, and the velocities of its supports, in units of the phase
 * u = w_b t. */
#ifndef SLIPDISK_THEORY_SLIDING_H
#define SLIPDISK_THEORY_SLIDING_H

#include "slipdisk/theory.h"

typedef struct sliding_system {
  sd_waveform waveform;
  int n;               /* contacts: 1 when both supports move alike */
  double amplitude[2]; /* Theta_b R_i/R */
  double phase[2];     /* rad, within [-pi, pi] */
  double rate[2][2];   /* torque/(I w_b^2) by [s_1 < 0][s_2 < 0] */
  double peak;         /* largest |w_i| */
  double end;          /* 2 pi */
} sliding_system;

typedef struct sliding_piece {
  double start, omega, rate;
  int sign[2];
} sliding_piece;

typedef struct sliding_path {
  double change;    /* of Omega */
  double turned;    /* integral of Omega over u */
  double length[4]; /* by SD_PP ... */
  double stuck;
  size_t n;
  sliding_piece piece[SD_SLIDING_PIECES];
} sliding_path;

/* w_i at phase u, its slope just after u, and its integral from u to v. */
double sliding_wave(const sliding_system *y, int i, double u);
double sliding_slope(const sliding_system *y, int i, double u);
double sliding_turned(const sliding_system *y, int i, double u, double v);

/* First phase after u at which w_i - (omega + rate (u' - u)), which has sign s just after u, changes sign;
 * HUGE_VAL: not before y->end. */
double sliding_meeting(const sliding_system *y, int i, double u, double omega, double rate, int s);

/* A root of `of` in [lower, upper], where its sign differs, by Brent's method, to the larger of
 * `least` and that part of itself. False: it is less exact. */
bool sliding_root(double (*of)(double, void *), void *with, double lower, double upper,
                  double least, double part, double *root);

/* End of a piece in which contact i sticks and the other one has the sign s[1-i]. *release is the sign with
 * which i slides on when w_i outruns the torques; 0 when the other contact's velocity is met (*which is its
 * number) or the period ends (*which is -1). */
double sliding_stuck_until(const sliding_system *y, int i, double u, const int s[2], int *release,
                           int *which);

#endif
