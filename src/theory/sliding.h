/* sliding.h: the upper disk that slides on two turning supports: its motion over one period, and
 * the velocities of the supports. Time is the phase u = w_b t, angular velocities are in units
 * of w_b. */
#ifndef SLIPDISK_THEORY_SLIDING_H
#define SLIPDISK_THEORY_SLIDING_H

#include "slipdisk/theory.h"

/* The supports and torques of a problem, scaled. w_i is the angular velocity at which support i
 * would roll the disk. */
typedef struct sliding_system {
  sd_waveform waveform;
  int n;               /* number of contacts; 1 if both supports move alike and act as one */
  double amplitude[2]; /* angle amplitude of support i, scaled to the upper disk: Theta_b R_i/R */
  double phase[2];     /* phase of support i, rad, within [-pi, pi] */
  double rate[2][2];   /* torque/(I w_b^2), by signs of sliding: [s_1 < 0][s_2 < 0] */
  double peak;         /* largest |w_i| of both supports */
  double end;          /* end of the period, 2 pi */
} sliding_system;

/* A piece of the path between two changes of sliding: Omega = omega + rate (u - start). sign:
 * signs of sliding of the two contacts; 0: the disk rolls on that support. */
typedef struct sliding_piece {
  double start, omega, rate;
  int sign[2];
} sliding_piece;

/* The path Omega(u) over one period. */
typedef struct sliding_path {
  double change;    /* net change of Omega over the period */
  double turned;    /* angle turned by the disk: integral of Omega over u */
  double length[4]; /* total phase spent in each configuration, by SD_PP ... */
  double stuck;     /* total phase in which a contact sticks */
  size_t n;
  sliding_piece piece[SD_SLIDING_PIECES];
} sliding_path;

/* Returns the velocity w_i of support i at phase u. */
double sliding_wave(const sliding_system *y, int i, double u);
/* Returns the slope dw_i/du of the velocity of support i just after phase u. */
double sliding_slope(const sliding_system *y, int i, double u);
/* Returns the integral of w_i over the phase from u to v. */
double sliding_turned(const sliding_system *y, int i, double u, double v);

/* Returns the first phase u' after u at which the difference w_i - (omega + rate (u' - u))
 * changes sign; s: its sign just after u. HUGE_VAL: no change before y->end. */
double sliding_meeting(const sliding_system *y, int i, double u, double omega, double rate, int s);

/* Finds a root of of(x, with) in [lower, upper], at whose ends the function has different signs,
 * by Brent's method, to an error of max(least, part * root). False: this was not achieved. */
bool sliding_root(double (*of)(double, void *), void *with, double lower, double upper,
                  double least, double part, double *root);

/* Returns the phase at which a piece ends in which contact i sticks and the other contact slides
 * with the sign s[1-i]. *release: the sign with which contact i slides on if w_i changes faster
 * than the torques allow; 0 if the other support's velocity becomes equal (*which is the number
 * of that contact) or the period ends (*which is -1). */
double sliding_stuck_until(const sliding_system *y, int i, double u, const int s[2], int *release,
                           int *which);

#endif
